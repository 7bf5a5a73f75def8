#include "weather_noise.h"

#include "lattice.h"

/* The gradient of a lattice point is one of (+-1, +-1, 0), (+-1, 0, +-1), (0, +-1, +-1). */
static void make_gradient(uint64_t key, int32_t x, int32_t y, int32_t z, int8_t out[3]) {
  const uint64_t hash = hash_corner(key, x, y, z);
  const uint32_t none = (uint32_t)((hash >> 40) * 3 >> 24);
  const int8_t a = (hash & 1) != 0 ? 1 : -1, b = (hash & 2) != 0 ? 1 : -1;
  out[0] = none == 0 ? 0 : a;
  out[1] = none == 1 ? 0 : none == 0 ? a : b;
  out[2] = none == 2 ? 0 : b;
}

static inline float fade(float t) {
  return t * t * t * (t * (t * 6 - 15) + 10);
}

static void add_octave(const weather_noise* noise, weather_noise_cache* cache, int octave, double finer, float height, uint32_t x,
                       uint32_t y, uint32_t z, uint32_t count, float* out) {
  const double fx = noise->frequency * finer, py = ((double)y + 0.5) * (noise->frequency_y * finer), pz = ((double)z + 0.5) * fx;
  const int32_t first = (int32_t)(((double)x + 0.5) * fx), cell_y = (int32_t)py, cell_z = (int32_t)pz;
  const int32_t points = (int32_t)(((double)(x + count - 1) + 0.5) * fx) - first + 2;
  const bool same = cache->octaves[octave].known && cache->octaves[octave].x == first && cache->octaves[octave].y == cell_y &&
                    cache->octaves[octave].z == cell_z && cache->octaves[octave].count >= points;
  if (!same) {
    const uint64_t key = octave == 0 ? noise->key : hash_combine(noise->key, 1);
    for (int side = 0; side < 4; ++side)
      for (int32_t i = 0; i < points; ++i) {
        int8_t g[3];
        make_gradient(key, first + i, cell_y + (side & 1), cell_z + (side >> 1), g);
        for (int axis = 0; axis < 3; ++axis) cache->octaves[octave].gradients[axis][side][i] = g[axis];
      }
    cache->octaves[octave].known = true;
    cache->octaves[octave].x = first;
    cache->octaves[octave].y = cell_y;
    cache->octaves[octave].z = cell_z;
    cache->octaves[octave].count = points;
  }
  /* Along the row a lattice point's dot product is at + slope * x; mixed along y and z it still is. */
  float at[WEATHER_NOISE_CELLS], slope[WEATHER_NOISE_CELLS];
  const float y0 = (float)(py - cell_y), z0 = (float)(pz - cell_z), ty = fade(y0), tz = fade(z0);
  const float share[4] = {(1 - ty) * (1 - tz), ty * (1 - tz), (1 - ty) * tz, ty * tz};
  for (int32_t i = 0; i < points; ++i) at[i] = slope[i] = 0;
  for (int side = 0; side < 4; ++side) {
    const float dy = (y0 - (float)(side & 1)) * share[side], dz = (z0 - (float)(side >> 1)) * share[side];
    const int8_t *gx = cache->octaves[octave].gradients[0][side], *gy = cache->octaves[octave].gradients[1][side],
                 *gz = cache->octaves[octave].gradients[2][side];
    for (int32_t i = 0; i < points; ++i) {
      at[i] += (float)gy[i] * dy + (float)gz[i] * dz;
      slope[i] += (float)gx[i] * share[side];
    }
  }
  for (uint32_t i = 0; i < count; ++i) {
    const double p = ((double)(x + i) + 0.5) * fx;
    const int32_t cell = (int32_t)p, c = cell - first;
    /* cppcheck-suppress uninitvar ; there are two points at least */
    const float t = (float)(p - cell), a = at[c] + slope[c] * t, b = at[c + 1] + slope[c + 1] * (t - 1);
    out[i] += height * (a + (b - a) * fade(t));
  }
}

void weather_noise_row(const weather_noise* noise, weather_noise_cache* cache, uint32_t x, uint32_t y, uint32_t z, uint32_t count,
                       float* out) {
  weather_noise_cache own;
  if (cache == NULL) {
    cache = &own;
    own.octaves[0].known = own.octaves[1].known = false;
  }
  for (uint32_t i = 0; i < count; ++i) out[i] = 0;
  add_octave(noise, cache, 0, 1, 1.4f, x, y, z, count, out);
  add_octave(noise, cache, 1, 2.3, 0.7f, x, y, z, count, out);
  for (uint32_t i = 0; i < count; ++i) out[i] = out[i] < -1 ? -1 : out[i] > 1 ? 1 : out[i];
}
