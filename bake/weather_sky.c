#include "weather_sky.h"

#include <math.h>
#include <string.h>

static size_t cell_count(const uint32_t size[3]) {
  return (size_t)size[0] * size[1] * size[2];
}

scree_result weather_sky_create(const uint32_t size[3], const scree_allocator* allocator, weather_sky* out) {
  memset(out, 0, sizeof *out);
  bool complete = true;
  for (uint32_t level = 0; level < SKY_LEVELS; ++level) {
    for (uint32_t axis = 0; axis < 3; ++axis) out->size[level][axis] = (size[axis] + (4u << level) - 1) / (4u << level);
    out->cells[level] = scree_rt_allocate(allocator, cell_count(out->size[level]), sizeof(float));
    complete = complete && out->cells[level] != NULL;
  }
  out->scratch = scree_rt_allocate(allocator, cell_count(out->size[0]), sizeof(float));
  if (complete && out->scratch != NULL) return SCREE_OK;
  weather_sky_destroy(out, allocator);
  return SCREE_ERROR_OUT_OF_MEMORY;
}

void weather_sky_destroy(weather_sky* sky, const scree_allocator* allocator) {
  for (uint32_t level = 0; level < SKY_LEVELS; ++level)
    scree_rt_release(allocator, sky->cells[level], cell_count(sky->size[level]), sizeof(float));
  scree_rt_release(allocator, sky->scratch, cell_count(sky->size[0]), sizeof(float));
  memset(sky, 0, sizeof *sky);
}

/* --- Densities. --- */

typedef struct count_run {
  weather_sky* sky;
  const scree_weather* weather;
} count_run;

/* One slab of cells, 4 voxels thick. Sums of nibbles grow in the bytes of two words, at most 64 in each. */
static void count_slab(void* context, uint32_t index, uint32_t worker) {
  (void)worker;
  const count_run* run = context;
  const scree_weather* w = run->weather;
  const uint32_t* size = run->sky->size[0];
  for (uint32_t cy = 0; cy < size[1]; ++cy)
    for (uint32_t word = 0; word * 16 < size[0]; ++word) {
      uint64_t even = 0, odd = 0;
      for (uint32_t row = 0; row < 16; ++row) {
        const uint32_t y = cy * 4 + row % 4, z = index * 4 + row / 4;
        if (y >= w->size[1] || z >= w->size[2]) continue;
        const size_t at = weather_row(w, (int32_t)y, (int32_t)z) + word;
        uint64_t bits = w->rock[at] | w->colluvium[at];
        bits = (bits & UINT64_C(0x5555555555555555)) + (bits >> 1 & UINT64_C(0x5555555555555555));
        bits = (bits & UINT64_C(0x3333333333333333)) + (bits >> 2 & UINT64_C(0x3333333333333333));
        even += bits & UINT64_C(0x0f0f0f0f0f0f0f0f);
        odd += bits >> 4 & UINT64_C(0x0f0f0f0f0f0f0f0f);
      }
      float* to = run->sky->cells[0] + (size_t)size[0] * (cy + (size_t)size[1] * index) + (size_t)word * 16;
      const uint32_t cells = size[0] - word * 16 < 16 ? size[0] - word * 16 : 16;
      for (uint32_t x = 0; x < cells; ++x) to[x] = (float)((x & 1 ? odd : even) >> (x / 2 * 8) & 255) * (1.0f / 64);
    }
}

/* Means of 2 x 2 x 2 cells. */
static void halve(const float* from, const uint32_t from_size[3], float* to, const uint32_t size[3]) {
  for (uint32_t z = 0; z < size[2]; ++z)
    for (uint32_t y = 0; y < size[1]; ++y)
      for (uint32_t x = 0; x < size[0]; ++x) {
        float sum = 0;
        for (uint32_t i = 0; i < 8; ++i) {
          const uint32_t fx = 2 * x + (i & 1), fy = 2 * y + (i >> 1 & 1), fz = 2 * z + (i >> 2);
          if (fx < from_size[0] && fy < from_size[1] && fz < from_size[2])
            sum += from[fx + (size_t)from_size[0] * (fy + (size_t)from_size[1] * fz)];
        }
        to[x + (size_t)size[0] * (y + (size_t)size[1] * z)] = sum * 0.125f;
      }
}

/* [1 2 1] / 4 along one axis; air beyond the ends, but rock below. */
static void blur_axis(const float* from, float* to, const uint32_t size[3], uint32_t axis) {
  const size_t step = axis == 0 ? 1 : axis == 1 ? size[0] : (size_t)size[0] * size[1];
  for (uint32_t z = 0; z < size[2]; ++z)
    for (uint32_t y = 0; y < size[1]; ++y) {
      const size_t row = (size_t)size[0] * (y + (size_t)size[1] * z);
      for (uint32_t x = 0; x < size[0]; ++x) {
        const uint32_t at = axis == 0 ? x : axis == 1 ? y : z;
        const float before = at > 0 ? from[row + x - step] : axis == 1 ? 1.0f : 0.0f;
        const float after = at + 1 < size[axis] ? from[row + x + step] : 0.0f;
        to[row + x] = (before + 2 * from[row + x] + after) * 0.25f;
      }
    }
}

void weather_sky_update(weather_sky* sky, const scree_weather* weather) {
  count_run run = {sky, weather};
  weather_parallel(weather, sky->size[0][2], count_slab, &run);
  for (uint32_t level = 1; level < SKY_LEVELS; ++level)
    halve(sky->cells[level - 1], sky->size[level - 1], sky->cells[level], sky->size[level]);
  for (uint32_t level = 0; level < SKY_LEVELS; ++level) {
    blur_axis(sky->cells[level], sky->scratch, sky->size[level], 0);
    blur_axis(sky->scratch, sky->cells[level], sky->size[level], 1);
    blur_axis(sky->cells[level], sky->scratch, sky->size[level], 2);
    memcpy(sky->cells[level], sky->scratch, cell_count(sky->size[level]) * sizeof(float));
  }
}

/* --- One point. --- */

/* Trilinear between the middles of cells. */
static float density(const weather_sky* sky, uint32_t level, const float p[3]) {
  const uint32_t* size = sky->size[level];
  const float scale = 1.0f / (float)(4u << level);
  int32_t at[3];
  float t[3];
  for (uint32_t axis = 0; axis < 3; ++axis) {
    float q = p[axis] * scale + 0.5f; /* cells, from the middle of cell -1 */
    const float most = (float)size[axis] + 1;
    q = q < 0 ? 0 : q > most ? most : q;
    const int32_t whole = (int32_t)q;
    at[axis] = whole - 1;
    t[axis] = q - (float)whole;
  }
  float v[8];
  const bool within = at[0] >= 0 && at[1] >= 0 && at[2] >= 0 && (uint32_t)at[0] + 1 < size[0] && (uint32_t)at[1] + 1 < size[1] &&
                      (uint32_t)at[2] + 1 < size[2];
  const size_t dy = size[0], dz = (size_t)size[0] * size[1];
  const float* cell = sky->cells[level] + (within ? (uint32_t)at[0] + dy * (uint32_t)at[1] + dz * (uint32_t)at[2] : 0);
  if (within) {
    v[0] = cell[0], v[1] = cell[1], v[2] = cell[dy], v[3] = cell[dy + 1];
    v[4] = cell[dz], v[5] = cell[dz + 1], v[6] = cell[dz + dy], v[7] = cell[dz + dy + 1];
  } else
    for (uint32_t i = 0; i < 8; ++i) {
      const int32_t x = at[0] + (int32_t)(i & 1), y = at[1] + (int32_t)(i >> 1 & 1), z = at[2] + (int32_t)(i >> 2);
      if (y < 0)
        v[i] = 1;
      else if (x < 0 || z < 0 || (uint32_t)x >= size[0] || (uint32_t)y >= size[1] || (uint32_t)z >= size[2])
        v[i] = 0;
      else
        v[i] = sky->cells[level][(uint32_t)x + (size_t)size[0] * ((uint32_t)y + (size_t)size[1] * (uint32_t)z)];
    }
  for (uint32_t i = 0; i < 4; ++i) v[i] = v[2 * i] + (v[2 * i + 1] - v[2 * i]) * t[0];
  v[0] += (v[1] - v[0]) * t[1];
  v[1] = v[2] + (v[3] - v[2]) * t[1];
  return v[0] + (v[1] - v[0]) * t[2];
}

/* Cones, looked at where they are as wide as a cell: how far out, what a plain holds there, and how much of what is seen the rest
 * hides. One along the normal, and a weaker one tilted up, from where most light comes: it is what darkens the neck under a cap. */
typedef struct sky_look {
  float distance, plain, weight;
} sky_look;
static const sky_look along_normal[SKY_LEVELS] = {{3.5f, 0.145f, 1.3f}, {8.0f, 0.125f, 1.1f}, {17.0f, 0.115f, 0.9f}};
static const sky_look tilted_up[SKY_LEVELS] = {{0, 0, 0}, {9.0f, 0.185f, 0.9f}, {19.0f, 0.175f, 0.9f}};
#define TILT 0.9f

static float look_along(const weather_sky* sky, const sky_look* looks, uint32_t first, const float position[3], const float to[3]) {
  float open = 1;
  for (uint32_t level = first; level < SKY_LEVELS; ++level) {
    float p[3];
    for (uint32_t axis = 0; axis < 3; ++axis) p[axis] = position[axis] + to[axis] * looks[level].distance;
    const float hidden = (density(sky, level, p) - looks[level].plain) * looks[level].weight;
    if (hidden > 0) open *= hidden < 1 ? 1 - hidden : 0;
  }
  return open;
}

float weather_sky_at(const weather_sky* sky, const float position[3], const float normal[3]) {
  const float up[3] = {normal[0], normal[1] + TILT, normal[2]};
  /* Not zero: the normal is unit, and the tilt is less. */
  const float scale = 1 / sqrtf(up[0] * up[0] + up[1] * up[1] + up[2] * up[2]);
  const float tilted[3] = {up[0] * scale, up[1] * scale, up[2] * scale};
  return look_along(sky, along_normal, 0, position, normal) * look_along(sky, tilted_up, 1, position, tilted);
}
