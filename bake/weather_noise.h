/* Perlin's gradient noise on voxels, in rows along x.
 * Based on: Perlin, Improving Noise, 2002: twelve gradients, quintic fade; the lattice is hashed instead of permuted, so that it
 * has no period. */
#ifndef SCREE_WEATHER_NOISE_H
#define SCREE_WEATHER_NOISE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
  WEATHER_NOISE_ROW = 64,   /* voxels of a call at most */
  WEATHER_NOISE_CELLS = 152 /* lattice points along such a row at the highest frequency, 2.3 a voxel */
};

typedef struct weather_noise {
  uint64_t key;       /* names the noise */
  double frequency;   /* 1 / period, along x and z; at most 1 */
  double frequency_y; /* along y */
} weather_noise;

/* Gradients of the lattice points round a row: rows that follow each other mostly share them. Zeroed before the first call, and
 * when the noise becomes another. */
typedef struct weather_noise_cache {
  struct {
    bool known;
    int32_t x, y, z; /* of the first lattice point */
    int32_t count;
    int8_t gradients[3][4][WEATHER_NOISE_CELLS]; /* axis; side y + 2 z; point along x */
  } octaves[2];
} weather_noise_cache;

/* out[i] = two octaves, the second half as high and 2.3 times as fine, clamped to -1..1, at the middle of voxel (x + i, y, z), all
 * of them >= 0; count <= WEATHER_NOISE_ROW. A value does not depend on the others of the call, nor on the cache, which may be NULL.
 */
void weather_noise_row(const weather_noise* noise, weather_noise_cache* cache, uint32_t x, uint32_t y, uint32_t z, uint32_t count,
                       float* out);

#endif
