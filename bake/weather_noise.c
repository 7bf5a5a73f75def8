#include "weather_noise.h"

#include <math.h>

#include "lattice.h"

/* Along a row each corner's dot product is linear in x: at + slope * x. */
typedef struct corner {
  double at, slope;
} corner;

static inline double fade(double t) {
  return t * t * t * (t * (t * 6 - 15) + 10);
}

/* The gradient of a lattice point is one of (+-1, +-1, 0), (+-1, 0, +-1), (0, +-1, +-1). */
static corner gradient(uint64_t key, int32_t x, int32_t y, int32_t z, double dy, double dz) {
  const uint64_t hash = hash_corner(key, x, y, z);
  const uint32_t axis = (uint32_t)((hash >> 40) * 3 >> 24); /* that has no part in it */
  const double a = (hash & 1) != 0 ? 1 : -1, b = (hash & 2) != 0 ? 1 : -1;
  if (axis == 0) return (corner){a * dy + b * dz, 0};
  if (axis == 1) return (corner){b * dz, a};
  return (corner){b * dy, a};
}

static inline corner mix(corner a, corner b, double t) {
  return (corner){a.at + (b.at - a.at) * t, a.slope + (b.slope - a.slope) * t};
}

/* The four corners of one side of a cell, mixed along y and z. */
static corner side(uint64_t key, int32_t x, int32_t y, int32_t z, double fy, double fz, double ty, double tz) {
  const corner low = mix(gradient(key, x, y, z, fy, fz), gradient(key, x, y + 1, z, fy - 1, fz), ty);
  const corner high = mix(gradient(key, x, y, z + 1, fy, fz - 1), gradient(key, x, y + 1, z + 1, fy - 1, fz - 1), ty);
  return mix(low, high, tz);
}

static void octave(uint64_t key, double fx, double fy, double fz, int32_t x, int32_t y, int32_t z, double height, uint32_t count,
                   float* out) {
  const double py = ((double)y + 0.5) * fy, pz = ((double)z + 0.5) * fz;
  const double cell_y = floor(py), cell_z = floor(pz);
  const double ty = fade(py - cell_y), tz = fade(pz - cell_z);
  corner left = {0, 0}, right = {0, 0};
  for (uint32_t i = 0; i < count;) {
    const double cell = floor(((double)(x + (int64_t)i) + 0.5) * fx);
    const int32_t c = (int32_t)cell;
    left = side(key, c, (int32_t)cell_y, (int32_t)cell_z, py - cell_y, pz - cell_z, ty, tz);
    right = side(key, c + 1, (int32_t)cell_y, (int32_t)cell_z, py - cell_y, pz - cell_z, ty, tz);
    uint32_t end = i + 1; /* voxels of this cell */
    while (end < count && floor(((double)(x + (int64_t)end) + 0.5) * fx) == cell) ++end;
    for (; i < end; ++i) {
      const double t = ((double)(x + (int64_t)i) + 0.5) * fx - cell, s = t - 1;
      const double a = left.at + left.slope * t, b = right.at + right.slope * s;
      out[i] += (float)(height * (a + (b - a) * fade(t)));
    }
  }
}

void weather_noise_row(const weather_noise* noise, int32_t x, int32_t y, int32_t z, uint32_t count, float* out) {
  for (uint32_t i = 0; i < count; ++i) out[i] = 0;
  octave(noise->key, noise->frequency, noise->frequency_y, noise->frequency, x, y, z, 1.4, count, out);
  octave(hash_combine(noise->key, 1), noise->frequency * 2.3, noise->frequency_y * 2.3, noise->frequency * 2.3, x, y, z, 0.7, count,
         out);
  for (uint32_t i = 0; i < count; ++i) out[i] = out[i] < -1 ? -1 : out[i] > 1 ? 1 : out[i];
}
