#include "rock_mask.h"

#include <string.h>

uint32_t mask_step(uint32_t voxels_per_cell) {
  uint32_t step = (voxels_per_cell + MASK_MAX_PER_CELL - 1) / MASK_MAX_PER_CELL;
  while (voxels_per_cell % step != 0) ++step;
  return step;
}

/* A row of fine voxels as bits of the box. Voxels outside the box are empty. */
static uint64_t fine_row(const rock_worker* worker, int32_t y, int32_t z) {
  const rock_grid* grid = &worker->grid;
  y -= grid->min[1], z -= grid->min[2];
  if (y < 0 || z < 0 || y >= (int32_t)grid->size[1] || z >= (int32_t)grid->size[2]) return 0;
  const uint64_t row = worker->rows[y + (ptrdiff_t)grid->size[1] * z];
  return grid->min[0] < 0 ? row >> -grid->min[0] : row << grid->min[0];
}

/* Every step-th bit from the middle of the first mask voxel on, gathered. */
static uint32_t gather(uint64_t row, uint32_t step, uint32_t count) {
  uint32_t out = 0;
  for (uint32_t i = 0; i < count; ++i) out |= (uint32_t)(row >> (i * step + step / 2) & 1) << i;
  return out;
}

scree_result rock_mask_make(const rock_worker* worker, const scree_allocator* allocator, rock_mask* out) {
  memset(out, 0, sizeof *out);
  const rock_grid* grid = &worker->grid;
  const int32_t step = (int32_t)mask_step(worker->seeds->voxels);
  const int32_t count = 2 * (int32_t)worker->seeds->voxels / step;
  for (int axis = 1; axis < 3; ++axis) {
    const int32_t low = grid->min[axis] < 0 ? 0 : grid->min[axis] / step;
    int32_t high = (grid->min[axis] + (int32_t)grid->size[axis] - 1) / step;
    if (high > count - 1) high = count - 1;
    out->min[axis] = (uint8_t)low;
    out->size[axis] = (uint8_t)(high - low + 1);
  }
  out->size[0] = (uint8_t)count;
  out->rows = scree_rt_allocate(allocator, (size_t)out->size[1] * out->size[2], sizeof *out->rows);
  if (out->rows == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  uint32_t* row = out->rows;
  for (int32_t z = out->min[2]; z < out->min[2] + out->size[2]; ++z)
    for (int32_t y = out->min[1]; y < out->min[1] + out->size[1]; ++y)
      *row++ = gather(fine_row(worker, y * step + step / 2, z * step + step / 2), (uint32_t)step, (uint32_t)count);
  return SCREE_OK;
}

void rock_mask_free(rock_mask* mask, const scree_allocator* allocator) {
  scree_rt_release(allocator, mask->rows, (size_t)mask->size[1] * mask->size[2], sizeof *mask->rows);
  memset(mask, 0, sizeof *mask);
}
