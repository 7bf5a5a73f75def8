#include "support_height.h"

#include <math.h>
#include <string.h>

#include "allocator.h"

static double square(double x) {
  return x * x;
}

/* Inside one cell of a bilinear surface each slope lies between those of the two opposite edges. */
static double steepest_slope2(const support_height* g, double spacing) {
  double steepest = 0;
  for (uint32_t v = 0; v + 1 < g->depth; ++v) {
    const float* row = g->heights + (size_t)v * g->width;
    const float* next = row + g->width;
    for (uint32_t u = 0; u + 1 < g->width; ++u) {
      double x0 = square((double)row[u + 1] - (double)row[u]), x1 = square((double)next[u + 1] - (double)next[u]);
      double z0 = square((double)next[u] - (double)row[u]), z1 = square((double)next[u + 1] - (double)row[u + 1]);
      double slope2 = (x0 > x1 ? x0 : x1) + (z0 > z1 ? z0 : z1);
      if (slope2 > steepest) steepest = slope2;
    }
  }
  return steepest / square(spacing);
}

support_height* scree_rt_support_height_create(const scree_shape* shape, support_key key, const scree_allocator* allocator) {
  uint32_t width = shape->heightfield.width, depth = shape->heightfield.depth;
  size_t count = (size_t)width * depth;
  double spacing = (double)shape->heightfield.spacing;

  support_height* grid = scree_rt_allocate_zeroed(allocator, 1, sizeof *grid);
  if (grid == NULL) return NULL;
  grid->share.allocator = *allocator;
  grid->share.key = key;
  atomic_init(&grid->share.uses, 1);
  grid->width = width;
  grid->depth = depth;
  grid->heights = scree_rt_allocate(allocator, count, sizeof(float));
  if (grid->heights == NULL) {
    scree_rt_support_height_drop(grid);
    return NULL;
  }
  memcpy(grid->heights, shape->heightfield.heights, count * sizeof(float));

  grid->inverse_spacing = (float)(1 / spacing);
  grid->middle_u = (float)((width - 1) * 0.5);
  grid->middle_v = (float)((depth - 1) * 0.5);
  grid->extent_x = (float)((width - 1) * 0.5 * spacing);
  grid->extent_z = (float)((depth - 1) * 0.5 * spacing);
  grid->cosine = (float)(1 / sqrt(1 + steepest_slope2(grid, spacing)));
  grid->lowest = grid->highest = grid->heights[0];
  for (size_t i = 1; i < count; ++i) {
    if (grid->heights[i] < grid->lowest) grid->lowest = grid->heights[i];
    if (grid->heights[i] > grid->highest) grid->highest = grid->heights[i];
  }
  return grid;
}

void scree_rt_support_height_drop(support_height* grid) {
  if (grid == NULL || !support_drop(&grid->share)) return;
  scree_allocator allocator = grid->share.allocator;
  scree_rt_release(&allocator, grid->heights, (size_t)grid->width * grid->depth, sizeof(float));
  scree_rt_release(&allocator, grid, 1, sizeof *grid);
}
