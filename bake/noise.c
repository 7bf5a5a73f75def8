#include "noise.h"

#include <math.h>
#include <string.h>

#include "lattice.h"

scree_result noise_scratch_create(uint32_t voxels, double cells, double frequency, const scree_allocator* allocator,
                                  noise_scratch* out) {
  memset(out, 0, sizeof *out);
  out->side = (uint32_t)ceil(cells * frequency) + 5;
  out->width = voxels;
  const size_t side = out->side;
  out->lattice = scree_rt_allocate(allocator, side * side * side, sizeof *out->lattice);
  out->plane = scree_rt_allocate(allocator, side * side, sizeof *out->plane);
  out->row = scree_rt_allocate(allocator, side, sizeof *out->row);
  out->index = scree_rt_allocate(allocator, voxels, sizeof *out->index);
  out->weights = scree_rt_allocate(allocator, (size_t)voxels * 4, sizeof *out->weights);
  if (out->lattice == NULL || out->plane == NULL || out->row == NULL || out->index == NULL || out->weights == NULL) {
    noise_scratch_destroy(out, allocator);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  return SCREE_OK;
}

void noise_scratch_destroy(noise_scratch* scratch, const scree_allocator* allocator) {
  const size_t side = scratch->side;
  scree_rt_release(allocator, scratch->lattice, side * side * side, sizeof *scratch->lattice);
  scree_rt_release(allocator, scratch->plane, side * side, sizeof *scratch->plane);
  scree_rt_release(allocator, scratch->row, side, sizeof *scratch->row);
  scree_rt_release(allocator, scratch->index, scratch->width, sizeof *scratch->index);
  scree_rt_release(allocator, scratch->weights, (size_t)scratch->width * 4, sizeof *scratch->weights);
  memset(scratch, 0, sizeof *scratch);
}

/* Where voxel i lies between lattice values: the first of the four that count, relative to `base`, and their weights. */
static uint32_t spline(const noise_grid* grid, int axis, uint32_t i, float frequency, float base, float weights[4]) {
  const float at = (grid->origin[axis] + (float)i * grid->step) * frequency - base;
  const float whole = floorf(at), t = at - whole, s = 1 - t;
  weights[0] = s * s * s * (1.0f / 6);
  weights[1] = (3 * t * t * t - 6 * t * t + 4) * (1.0f / 6);
  weights[2] = (3 * s * s * s - 6 * s * s + 4) * (1.0f / 6);
  weights[3] = t * t * t * (1.0f / 6);
  return (uint32_t)whole;
}

void noise_add(const noise_scratch* scratch, const noise_grid* grid, float frequency, float amplitude, uint64_t key, float* out) {
  float base[3];
  uint32_t side[3];
  for (int axis = 0; axis < 3; ++axis) {
    base[axis] = floorf(grid->origin[axis] * frequency);
    side[axis] = (uint32_t)(floorf((grid->origin[axis] + (float)(grid->size[axis] - 1) * grid->step) * frequency) - base[axis]) + 4;
    if (side[axis] > scratch->side) side[axis] = scratch->side;
  }
  /* Lattice values belong to places in the rock's own frame, so that the grid's bounds do not move the noise. */
  for (uint32_t z = 0; z < side[2]; ++z)
    for (uint32_t y = 0; y < side[1]; ++y) {
      const uint64_t line =
          hash_combine(key, (uint64_t)(int64_t)(base[1] + (float)y) << 32 ^ (uint64_t)(uint32_t)(int32_t)(base[2] + (float)z));
      float* row = scratch->lattice + (size_t)side[0] * (y + (size_t)side[1] * z);
      for (uint32_t x = 0; x < side[0]; ++x)
        row[x] = (float)(hash_mix(line + (uint64_t)(int64_t)(base[0] + (float)x)) >> 40) * 0x1p-24f;
    }

  for (uint32_t x = 0; x < grid->size[0]; ++x)
    scratch->index[x] = spline(grid, 0, x, frequency, base[0], scratch->weights + (size_t)x * 4);
  const size_t slice = (size_t)side[0] * side[1];
  for (uint32_t z = 0; z < grid->size[2]; ++z) {
    float wz[4], wy[4];
    const float* planes = scratch->lattice + slice * spline(grid, 2, z, frequency, base[2], wz);
    for (size_t i = 0; i < slice; ++i)
      scratch->plane[i] =
          planes[i] * wz[0] + planes[i + slice] * wz[1] + planes[i + 2 * slice] * wz[2] + planes[i + 3 * slice] * wz[3];
    for (uint32_t y = 0; y < grid->size[1]; ++y) {
      const float* rows = scratch->plane + (size_t)side[0] * spline(grid, 1, y, frequency, base[1], wy);
      for (uint32_t i = 0; i < side[0]; ++i)
        scratch->row[i] =
            rows[i] * wy[0] + rows[i + side[0]] * wy[1] + rows[i + 2 * side[0]] * wy[2] + rows[i + 3 * side[0]] * wy[3];
      float* to = out + (size_t)grid->size[0] * (y + (size_t)grid->size[1] * z);
      for (uint32_t x = 0; x < grid->size[0]; ++x) {
        const float *from = scratch->row + scratch->index[x], *w = scratch->weights + (size_t)x * 4;
        float value = from[0] * w[0] + from[1] * w[1] + from[2] * w[2] + from[3] * w[3];
        /* The spline flattens the values towards one half; stretch them back. */
        value = (value - 0.5f) * 2 + 0.5f;
        value = value < 0 ? 0 : value > 1 ? 1 : value;
        to[x] += amplitude * value;
      }
    }
  }
}
