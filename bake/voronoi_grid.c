#include <string.h>

#include "random.h"
#include "vectors.h"
#include "voronoi_cell.h"

enum { MAX_SIDE = 1024 };

static uint32_t box_along(const voronoi_grid* grid, int axis, double x) {
  const double box = (x - grid->min[axis]) / grid->step[axis];
  if (!(box > 0)) return 0;
  return box >= grid->size[axis] ? grid->size[axis] - 1 : (uint32_t)box;
}

static uint32_t box_at(const voronoi_grid* grid, const double point[3]) {
  const uint32_t x = box_along(grid, 0, point[0]), y = box_along(grid, 1, point[1]), z = box_along(grid, 2, point[2]);
  return (z * grid->size[1] + y) * grid->size[0] + x;
}

static void choose_size(voronoi_grid* grid) {
  double max[3], extent[3], longest = 0;
  points_bounds(grid->seeds, grid->seed_count, grid->min, max);
  for (int axis = 0; axis < 3; ++axis) {
    extent[axis] = max[axis] - grid->min[axis];
    if (extent[axis] > longest) longest = extent[axis];
  }
  if (!(longest > 0)) longest = 1;
  for (int axis = 0; axis < 3; ++axis)
    if (extent[axis] < 1e-3 * longest) extent[axis] = 1e-3 * longest;
  const double step =
      repeatable_cube_root(extent[0] / longest * (extent[1] / longest) * (extent[2] / longest) * 2.5 / grid->seed_count) * longest;
  for (int axis = 0; axis < 3; ++axis) {
    const double boxes = extent[axis] / step;
    grid->size[axis] = boxes >= MAX_SIDE ? MAX_SIDE : (uint32_t)boxes + 1;
    grid->step[axis] = extent[axis] / grid->size[axis];
  }
}

scree_result voronoi_grid_create(const double* seeds, uint32_t count, const scree_allocator* allocator, voronoi_grid* out) {
  *out = (voronoi_grid){.seeds = seeds, .seed_count = count};
  choose_size(out);
  const uint32_t boxes = out->size[0] * out->size[1] * out->size[2];
  out->points = scree_rt_allocate(allocator, count, 3 * sizeof *out->points);
  out->order = scree_rt_allocate(allocator, count, sizeof *out->order);
  out->box_of = scree_rt_allocate(allocator, count, sizeof *out->box_of);
  out->first = scree_rt_allocate_zeroed(allocator, (size_t)boxes + 1, sizeof *out->first);
  if (out->points == NULL || out->order == NULL || out->box_of == NULL || out->first == NULL) {
    voronoi_grid_free(out, allocator);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  for (size_t i = 0; i < count; ++i) {
    out->box_of[i] = box_at(out, seeds + 3 * i);
    ++out->first[out->box_of[i] + 1];
  }
  for (size_t box = 0; box < boxes; ++box) out->first[box + 1] += out->first[box];
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t at = out->first[out->box_of[i]]++;
    out->order[at] = i;
    memcpy(out->points + 3 * (size_t)at, seeds + 3 * (size_t)i, 3 * sizeof *seeds);
  }
  memmove(out->first + 1, out->first, boxes * sizeof *out->first);
  out->first[0] = 0;
  return SCREE_OK;
}

void voronoi_grid_free(voronoi_grid* grid, const scree_allocator* allocator) {
  const size_t boxes = (size_t)grid->size[0] * grid->size[1] * grid->size[2];
  scree_rt_release(allocator, grid->points, grid->seed_count, 3 * sizeof *grid->points);
  scree_rt_release(allocator, grid->order, grid->seed_count, sizeof *grid->order);
  scree_rt_release(allocator, grid->box_of, grid->seed_count, sizeof *grid->box_of);
  scree_rt_release(allocator, grid->first, boxes + 1, sizeof *grid->first);
  *grid = (voronoi_grid){0};
}

static double squared(double x) {
  return x * x;
}

uint32_t voronoi_grid_nearest(const voronoi_grid* grid, const double point[3]) {
  int centre[3];
  for (int axis = 0; axis < 3; ++axis) centre[axis] = (int)box_along(grid, axis, point[axis]);
  uint32_t best = 0;
  double best2 = -1;
  for (int ring = 0;; ++ring) {
    /* How far what lies beyond the boxes of earlier rings is at least; a side at the grid's border has nothing beyond. */
    double beyond = -1;
    for (int axis = 0; axis < 3; ++axis) {
      const int low = centre[axis] - ring + 1, high = centre[axis] + ring;
      if (low > 0) {
        const double d = point[axis] - (grid->min[axis] + low * grid->step[axis]);
        if (beyond < 0 || d < beyond) beyond = d > 0 ? d : 0;
      }
      if (high < (int)grid->size[axis]) {
        const double d = grid->min[axis] + high * grid->step[axis] - point[axis];
        if (beyond < 0 || d < beyond) beyond = d > 0 ? d : 0;
      }
    }
    if (ring > 0 && (beyond < 0 || (best2 >= 0 && beyond * beyond * (1 - 1e-9) > best2))) return best;
    for (int z = centre[2] - ring; z <= centre[2] + ring; ++z) {
      if (z < 0 || z >= (int)grid->size[2]) continue;
      for (int y = centre[1] - ring; y <= centre[1] + ring; ++y) {
        if (y < 0 || y >= (int)grid->size[1]) continue;
        const bool whole = z == centre[2] - ring || z == centre[2] + ring || y == centre[1] - ring || y == centre[1] + ring;
        const int skip = whole || ring == 0 ? 1 : 2 * ring;
        for (int x = centre[0] - ring; x <= centre[0] + ring; x += skip) {
          if (x < 0 || x >= (int)grid->size[0]) continue;
          const uint32_t box = ((uint32_t)z * grid->size[1] + (uint32_t)y) * grid->size[0] + (uint32_t)x;
          for (uint32_t i = grid->first[box]; i < grid->first[box + 1]; ++i) {
            const double* seed = grid->points + 3 * (size_t)i;
            const double d2 = squared(seed[0] - point[0]) + squared(seed[1] - point[1]) + squared(seed[2] - point[2]);
            if (best2 < 0 || d2 < best2 || (d2 == best2 && grid->order[i] < best)) best2 = d2, best = grid->order[i];
          }
        }
      }
    }
  }
}
