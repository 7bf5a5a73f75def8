#include "blocks.h"

#include <string.h>

scree_result block_tables_create(uint32_t voxels, const scree_allocator* allocator, block_tables* out) {
  memset(out, 0, sizeof *out);
  out->voxels = voxels;
  out->plane = round_to_lanes(voxels * voxels);
  out->cells_per_unit = (float)(1.0 / (UNITS_PER_VOXEL * (double)voxels));
  float** planes[10] = {
      &out->x,          &out->y,          &out->weight_xy[0], &out->weight_xy[1], &out->weight_xy[2], &out->weight_xy[3],
      &out->slope_x[0], &out->slope_x[1], &out->slope_y[0],   &out->slope_y[1]};
  float* memory = allocate_zeroed(allocator, (size_t)10 * out->plane + (size_t)4 * voxels, sizeof(float));
  if (memory == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  for (uint32_t i = 0; i < 10; ++i) *planes[i] = memory + (size_t)i * out->plane;
  for (uint32_t side = 0; side < 2; ++side) {
    out->weight[side] = memory + (size_t)10 * out->plane + (size_t)side * voxels;
    out->slope[side] = memory + (size_t)10 * out->plane + (size_t)(2 + side) * voxels;
  }
  for (uint32_t v = 0; v < voxels; ++v) {
    const double t = (v + 0.5) / voxels;
    double slope;
    out->weight[0][v] = (float)support_weight(t, &slope);
    out->slope[0][v] = (float)slope;
    /* The upper cell sees the same voxel mirrored. */
    out->weight[1][voxels - 1 - v] = out->weight[0][v];
    out->slope[1][voxels - 1 - v] = -out->slope[0][v];
  }
  for (uint32_t at = 0; at < out->plane; ++at) {
    const uint32_t x = at % voxels, y = at / voxels < voxels ? at / voxels : voxels - 1;
    out->x[at] = (float)(256 * (2 * x + 1));
    out->y[at] = (float)(256 * (2 * y + 1));
    for (uint32_t side = 0; side < 4; ++side) out->weight_xy[side][at] = out->weight[side & 1][x] * out->weight[side >> 1][y];
    for (uint32_t side = 0; side < 2; ++side) {
      out->slope_x[side][at] = out->slope[side][x];
      out->slope_y[side][at] = out->slope[side][y];
    }
  }
  return SCREE_OK;
}

void block_tables_destroy(block_tables* tables, const scree_allocator* allocator) {
  release(allocator, tables->x, (size_t)10 * tables->plane + (size_t)4 * tables->voxels, sizeof(float));
  memset(tables, 0, sizeof *tables);
}

scree_result block_cache_create(const seed_set* seeds, const block_tables* tables, const kernel_set* kernels,
                                const scree_allocator* allocator, block_cache* out) {
  memset(out, 0, sizeof *out);
  out->seeds = seeds;
  out->tables = tables;
  out->kernels = kernels;
  out->side = seeds->n + 1;
  const size_t count = (size_t)out->side * out->side * out->side;
  /* Three float fields and one byte field a voxel; the byte field is counted as a quarter of a float one. */
  const size_t voxels = (size_t)tables->plane * tables->voxels, floats = voxels * 3 + voxels / 4;
  out->memory_count = count * floats;
  out->blocks = allocate(allocator, count, sizeof *out->blocks);
  out->filled = allocate_zeroed(allocator, count, 1);
  out->memory = allocate(allocator, out->memory_count, sizeof *out->memory);
  if (out->blocks == NULL || out->filled == NULL || out->memory == NULL) {
    block_cache_destroy(out, allocator);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  for (size_t i = 0; i < count; ++i) {
    float* at = out->memory + i * floats;
    out->blocks[i].fields = (block_fields){at, at + voxels, at + 2 * voxels, (uint8_t*)(at + 3 * voxels)};
  }
  return SCREE_OK;
}

void block_cache_destroy(block_cache* cache, const scree_allocator* allocator) {
  const size_t count = (size_t)cache->side * cache->side * cache->side;
  release(allocator, cache->blocks, count, sizeof *cache->blocks);
  release(allocator, cache->filled, count, 1);
  release(allocator, cache->memory, cache->memory_count, sizeof *cache->memory);
  memset(cache, 0, sizeof *cache);
}

void block_cache_begin(block_cache* cache, uint32_t code) {
  cache->code = code;
  memset(cache->filled, 0, (size_t)cache->side * cache->side * cache->side);
}

static void find_bounds(block* out, uint32_t seeds, uint32_t voxels, uint32_t plane) {
  for (uint32_t k = 0; k < seeds; ++k) {
    memset(out->bounds[k], 255, 3);
    memset(out->bounds[k] + 3, 0, 3);
  }
  for (uint32_t z = 0; z < voxels; ++z)
    for (uint32_t y = 0; y < voxels; ++y) {
      const uint8_t* row = out->fields.owner + (size_t)z * plane + (size_t)y * voxels;
      uint32_t start = 0;
      while (start < voxels) { /* run by run */
        uint32_t end = start + 1;
        while (end < voxels && row[end] == row[start]) ++end;
        uint8_t* bounds = out->bounds[row[start]];
        const uint8_t low[3] = {(uint8_t)start, (uint8_t)y, (uint8_t)z}, high[3] = {(uint8_t)(end - 1), (uint8_t)y, (uint8_t)z};
        for (uint32_t axis = 0; axis < 3; ++axis) {
          if (low[axis] < bounds[axis]) bounds[axis] = low[axis];
          if (high[axis] > bounds[3 + axis]) bounds[3 + axis] = high[axis];
        }
        start = end;
      }
    }
}

const block* block_cache_get(block_cache* cache, int32_t x, int32_t y, int32_t z) {
  const size_t index = (size_t)(x + 1) + cache->side * ((size_t)(y + 1) + cache->side * (size_t)(z + 1));
  block* out = &cache->blocks[index];
  if (cache->filled[index]) return out;
  cache->filled[index] = 1;

  block_seed list[BLOCK_MAX_SEEDS];
  uint32_t count = 0;
  for (uint32_t corner = 0; corner < 8; ++corner) {
    const int32_t offset[3] = {(int32_t)(corner & 1), (int32_t)(corner >> 1 & 1), (int32_t)(corner >> 2)};
    uint32_t cell_seeds;
    const rock_seed* seeds = seeds_of_cell(cache->seeds, cache->code, x + offset[0], y + offset[1], z + offset[2], &cell_seeds);
    out->first[corner] = (uint8_t)count;
    for (uint32_t s = 0; s < cell_seeds; ++s, ++count) {
      for (int axis = 0; axis < 3; ++axis)
        list[count].position[axis] = (float)(seeds[s].position[axis] + offset[axis] * cache->seeds->unit);
      memcpy(list[count].metric, seeds[s].metric, sizeof list[count].metric);
      list[count].corner = corner;
    }
  }
  out->first[8] = (uint8_t)count;
  cache->kernels->voronoi_block(cache->tables, list, count, &out->fields);
  find_bounds(out, count, cache->tables->voxels, cache->tables->plane);
  return out;
}
