/* The inner loops of weathering. weather_kernels_body.h is compiled once for the plain target and once for AVX2; both give the same
 * bits: each lane does the same operations in the same order. */
#ifndef SCREE_WEATHER_KERNELS_H
#define SCREE_WEATHER_KERNELS_H

#include "weather_internal.h"

typedef struct weather_kernels {
  const char* name;
  /* One step of all exposed voxels of plane z: takes from their lives, takes the dead from rock and colluvium (`solid`, which
   * others read, stays), marks those that become colluvium in `grains`. */
  void (*sweep)(scree_weather* w, uint32_t z, uint64_t step_key, weather_tally* tally);
  /* Adds sign (1 or -1) to the counts of all voxels of planes z_low <= z < z_high whose bubbles hold a voxel of the run
   * (x..x + length - 1, y, z), once for each that they hold. */
  void (*scatter)(const scree_weather* w, uint32_t x, uint32_t length, int32_t y, int32_t z, int32_t z_low, int32_t z_high,
                  int32_t sign);
} weather_kernels;

/* The widest that this machine runs. */
const weather_kernels* weather_kernels_choose(void);

extern const weather_kernels weather_kernels_plain;
extern const weather_kernels weather_kernels_avx2;

#endif
