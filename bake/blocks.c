#include "blocks.h"

#include <stdbool.h>
#include <string.h>

/* Distance halfway between two mean seeds: what sets apart near and far. */
static double typical_distance(const scree_recipe* recipe) {
  const scree_range ranges[3] = {recipe->alpha, recipe->beta, recipe->gamma};
  double form = 0;
  for (int i = 0; i < 3; ++i) form += (ranges[i].min + ranges[i].max) / 6;
  /* Seeds lie 1 / s cells apart, s being the cube root of their number; Newton's steps repeat to the bit, cbrt does not. */
  const double count = (recipe->seeds_min + recipe->seeds_max) * 0.5;
  double s = 1;
  for (int step = 0; step < 32; ++step) s -= (s * s * s - count) / (3 * s * s);
  return form * 0.25 / (s * s) / ((recipe->g.min + recipe->g.max) * 0.5);
}

scree_result block_tables_create(const scree_recipe* recipe, const scree_allocator* allocator, block_tables* out) {
  memset(out, 0, sizeof *out);
  const uint32_t voxels = recipe->voxels_per_cell;
  out->level = (float)typical_distance(recipe);
  out->voxels = voxels;
  out->plane = round_to_lanes(voxels * voxels);
  out->cells_per_unit = (float)(1.0 / (UNITS_PER_VOXEL * (double)voxels));
  float** planes[10] = {
      &out->x,          &out->y,          &out->weight_xy[0], &out->weight_xy[1], &out->weight_xy[2], &out->weight_xy[3],
      &out->slope_x[0], &out->slope_x[1], &out->slope_y[0],   &out->slope_y[1]};
  float* memory = scree_rt_allocate_zeroed(allocator, (size_t)10 * out->plane + (size_t)4 * voxels, sizeof(float));
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
  scree_rt_release(allocator, tables->x, (size_t)10 * tables->plane + (size_t)4 * tables->voxels, sizeof(float));
  memset(tables, 0, sizeof *tables);
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

/* Computes the block of a tile whose lowest cell is (x, y, z). */
static void fill_block(const seed_set* seeds_from, const block_tables* tables, const kernel_set* kernels, uint32_t code, int32_t x,
                       int32_t y, int32_t z, block* out) {
  block_seed list[BLOCK_MAX_SEEDS];
  uint32_t count = 0;
  for (uint32_t corner = 0; corner < 8; ++corner) {
    const int32_t offset[3] = {(int32_t)(corner & 1), (int32_t)(corner >> 1 & 1), (int32_t)(corner >> 2)};
    uint32_t cell_seeds;
    const rock_seed* seeds = seeds_of_cell(seeds_from, code, x + offset[0], y + offset[1], z + offset[2], &cell_seeds);
    out->first[corner] = (uint8_t)count;
    for (uint32_t s = 0; s < cell_seeds; ++s, ++count) {
      for (int axis = 0; axis < 3; ++axis)
        list[count].position[axis] = (float)(seeds[s].position[axis] + offset[axis] * seeds_from->unit);
      memcpy(list[count].metric, seeds[s].metric, sizeof list[count].metric);
      list[count].corner = corner;
    }
  }
  out->first[8] = (uint8_t)count;
  kernels->voronoi_block(tables, list, count, &out->fields);
  find_bounds(out, count, tables->voxels, tables->plane);
}

/* Floats that the fields of one block take: three a voxel, and a byte a voxel as a quarter of one. */
static size_t block_floats(const block_tables* tables) {
  const size_t voxels = (size_t)tables->plane * tables->voxels;
  return voxels * 3 + voxels / 4;
}

static void lay_out(block* blocks, size_t count, float* memory, const block_tables* tables) {
  const size_t voxels = (size_t)tables->plane * tables->voxels;
  for (size_t i = 0; i < count; ++i) {
    float* at = memory + i * block_floats(tables);
    blocks[i].fields = (block_fields){at, at + voxels, at + 2 * voxels, (uint8_t*)(at + 3 * voxels)};
  }
}

/* Place classes along one axis: 0 = above a plane, 1 = below it, 2.. = free. */
static bool is_free(uint32_t class) {
  return class >= 2;
}

static uint32_t variants(uint32_t n, uint32_t class) {
  uint32_t free_axes = 0;
  for (uint32_t axis = 0; axis < 3; ++axis, class /= n) free_axes += is_free(class % n);
  return free_axes == 3 ? 0 : UINT32_C(1) << (UINT32_C(1) << free_axes);
}

scree_result shared_blocks_create(const seed_set* seeds, const block_tables* tables, const kernel_set* kernels,
                                  const scree_allocator* allocator, shared_blocks* out) {
  memset(out, 0, sizeof *out);
  out->seeds = seeds;
  out->tables = tables;
  out->kernels = kernels;
  const uint32_t classes = seeds->n * seeds->n * seeds->n;
  out->first = scree_rt_allocate(allocator, classes, sizeof *out->first);
  if (out->first == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  for (uint32_t class = 0; class < classes; ++class) {
    const uint32_t count = variants(seeds->n, class);
    out->first[class] = count == 0 ? UINT32_MAX : out->count;
    out->count += count;
  }
  out->memory_count = out->count * block_floats(tables);
  out->blocks = scree_rt_allocate(allocator, out->count, sizeof *out->blocks);
  out->memory = scree_rt_allocate(allocator, out->memory_count, sizeof *out->memory);
  if (out->blocks == NULL || out->memory == NULL) {
    shared_blocks_destroy(out, allocator);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  lay_out(out->blocks, out->count, out->memory, tables);
  return SCREE_OK;
}

void shared_blocks_destroy(shared_blocks* shared, const scree_allocator* allocator) {
  const size_t n = shared->seeds == NULL ? 0 : shared->seeds->n;
  scree_rt_release(allocator, shared->first, n * n * n, sizeof *shared->first);
  scree_rt_release(allocator, shared->blocks, shared->count, sizeof *shared->blocks);
  scree_rt_release(allocator, shared->memory, shared->memory_count, sizeof *shared->memory);
  memset(shared, 0, sizeof *shared);
}

void shared_blocks_fill(shared_blocks* shared, uint32_t index) {
  const uint32_t n = shared->seeds->n, classes = n * n * n;
  uint32_t class = 0;
  for (uint32_t c = 0; c < classes; ++c)
    if (shared->first[c] != UINT32_MAX && shared->first[c] <= index) class = c;
  const uint32_t colours = index - shared->first[class];
  int32_t place[3];
  uint32_t pinned = 0, value = 0;
  for (uint32_t axis = 0, rest = class; axis < 3; ++axis, rest /= n) {
    const uint32_t c = rest % n;
    place[axis] = c == 0 ? 0 : c == 1 ? (int32_t)n - 1 : (int32_t)c - 1;
    if (!is_free(c)) pinned |= 1u << axis, value |= (c == 1 ? 1u : 0u) << axis;
  }
  uint32_t code = 0;
  for (uint32_t corner = 0, count = 0; corner < 8; ++corner)
    if ((corner & pinned) == value) code |= (colours >> count++ & 1) << corner;
  fill_block(shared->seeds, shared->tables, shared->kernels, code, place[0], place[1], place[2], &shared->blocks[index]);
}

scree_result block_cache_create(const shared_blocks* shared, const scree_allocator* allocator, block_cache* out) {
  memset(out, 0, sizeof *out);
  out->shared = shared;
  out->side = shared->seeds->n - 2;
  const size_t count = (size_t)out->side * out->side * out->side;
  out->memory_count = count * block_floats(shared->tables);
  out->blocks = scree_rt_allocate(allocator, count, sizeof *out->blocks);
  out->filled = scree_rt_allocate_zeroed(allocator, count, 1);
  out->memory = scree_rt_allocate(allocator, out->memory_count, sizeof *out->memory);
  if (out->blocks == NULL || out->filled == NULL || out->memory == NULL) {
    block_cache_destroy(out, allocator);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  lay_out(out->blocks, count, out->memory, shared->tables);
  return SCREE_OK;
}

void block_cache_destroy(block_cache* cache, const scree_allocator* allocator) {
  const size_t count = (size_t)cache->side * cache->side * cache->side;
  scree_rt_release(allocator, cache->blocks, count, sizeof *cache->blocks);
  scree_rt_release(allocator, cache->filled, count, 1);
  scree_rt_release(allocator, cache->memory, cache->memory_count, sizeof *cache->memory);
  memset(cache, 0, sizeof *cache);
}

void block_cache_begin(block_cache* cache, uint32_t code) {
  cache->code = code;
  memset(cache->filled, 0, (size_t)cache->side * cache->side * cache->side);
}

const block* block_cache_get(block_cache* cache, int32_t x, int32_t y, int32_t z) {
  const shared_blocks* shared = cache->shared;
  const uint32_t n = shared->seeds->n;
  const int32_t place[3] = {x, y, z};
  uint32_t class = 0, pinned = 0, value = 0;
  for (uint32_t axis = 3; axis-- > 0;) {
    const int32_t m = place[axis];
    const uint32_t c = m == 0 ? 0 : m < 0 || m == (int32_t)n - 1 ? 1 : (uint32_t)m + 1;
    class = class * n + c;
    /* Below a plane: plane 0 for place -1, plane 1 for place N - 1. */
    if (!is_free(c)) pinned |= 1u << axis, value |= (m > 0 ? 1u : 0u) << axis;
  }
  if (pinned != 0) {
    uint32_t colours = 0, count = 0;
    for (uint32_t corner = 0; corner < 8; ++corner)
      if ((corner & pinned) == value) colours |= (cache->code >> corner & 1) << count++;
    return &shared->blocks[shared->first[class] + colours];
  }
  const size_t index = (size_t)(x - 1) + cache->side * ((size_t)(y - 1) + cache->side * (size_t)(z - 1));
  block* out = &cache->blocks[index];
  if (!cache->filled[index]) {
    cache->filled[index] = 1;
    fill_block(shared->seeds, shared->tables, shared->kernels, cache->code, x, y, z, out);
  }
  return out;
}
