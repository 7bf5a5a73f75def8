/* Perlin's gradient noise on voxels, in rows along x.
 * Based on: Perlin, Improving Noise, 2002: twelve gradients, quintic fade; the lattice is hashed instead of permuted, so that it
 * has no period. */
#ifndef SCREE_WEATHER_NOISE_H
#define SCREE_WEATHER_NOISE_H

#include <stdint.h>

typedef struct weather_noise {
  uint64_t key;       /* names the noise */
  double frequency;   /* 1 / period, along x and z */
  double frequency_y; /* along y */
} weather_noise;

/* out[i] = two octaves, the second half as high and 2.3 times as fine, clamped to -1..1, at the middle of voxel (x + i, y, z). A
 * value does not depend on the others of the call. */
void weather_noise_row(const weather_noise* noise, int32_t x, int32_t y, int32_t z, uint32_t count, float* out);

#endif
