/* Queries: from what the caller asks to integer ranges of cells, then to a kernel.
 *
 * Which rocks exist is decided in the support's space and by whole cells alone, so it depends neither on the box that is asked for
 * nor on where positions are delivered to. */
#include <math.h>
#include <string.h>

#include "query_kernel.h"

#define FAR_CELL 1e15 /* beyond the cells of any int32 cube; doubles still count exactly */

/* Boxes that share a face ask this with the same numbers and get the same cell, so they neither share nor lose one. */
int64_t scree_rt_query_first_cell(double bound, double cell_size) {
  double cell = floor(bound / cell_size);
  if (!(cell > -FAR_CELL)) return (int64_t)-FAR_CELL;
  if (!(cell < FAR_CELL)) return (int64_t)FAR_CELL;
  while (cell * cell_size < bound) cell += 1;
  while ((cell - 1) * cell_size >= bound) cell -= 1;
  return (int64_t)cell;
}

static int64_t floor_divide(int64_t a, int64_t b) {
  int64_t q = a / b;
  return q - (a % b < 0);
}

static scree_result check(const scree_query_desc* d) {
  if (d == NULL || d->field == NULL || d->support == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  if ((d->flags & ~(uint32_t)SCREE_QUERY_SHELL) != 0) return SCREE_ERROR_INVALID_ARGUMENT;
  if (!(d->threshold >= 0 && d->threshold < 1)) return SCREE_ERROR_INVALID_ARGUMENT;
  if (!(d->shell_depth >= 0 && isfinite(d->shell_depth))) return SCREE_ERROR_INVALID_ARGUMENT;
  for (int a = 0; a < 3; ++a)
    if (!isfinite(d->origin[a]) || !(d->min[a] <= d->max[a])) return SCREE_ERROR_INVALID_ARGUMENT;
  return SCREE_OK;
}

static bool is_everywhere(const scree_query_desc* d) {
  for (int a = 0; a < 3; ++a)
    if (d->min[a] != 0 || d->max[a] != 0) return false;
  return true;
}

/* Cuts [low, high) to the cells where the support can let a rock exist. Returns false when none are left. */
static bool cut_cells(query_run* run) {
  const scree_field* field = run->field;
  double h = field->cell_size, low[3], high[3];
  double level = (double)run->offset_max > 0 ? (double)run->offset_max : 0;
  if (!scree_rt_support_level_bounds(run->support, level, low, high)) return false;
  for (int a = 0; a < 3; ++a) {
    int64_t first = scree_rt_query_first_cell(low[a] - run->test_base[a] - (double)field->centroid_max[a], h) - 1;
    int64_t end = scree_rt_query_first_cell(high[a] - run->test_base[a] - (double)field->centroid_min[a], h) + 2;
    if (first > run->cell_low[a]) run->cell_low[a] = first;
    if (end < run->cell_high[a]) run->cell_high[a] = end;
    if (run->cell_low[a] >= run->cell_high[a]) return false;
  }
  return true;
}

static scree_result find_cubes(query_run* run) {
  int64_t n = run->field->cells_per_cube;
  for (int a = 0; a < 3; ++a) {
    int64_t low = floor_divide(run->cell_low[a], n), high = floor_divide(run->cell_high[a] - 1, n) + 1;
    if (low < INT32_MIN || high > INT32_MAX) return SCREE_ERROR_RANGE; /* corner `high` is hashed too */
    run->cube_low[a] = (int32_t)low;
    run->cube_high[a] = (int32_t)high;
  }
  return SCREE_OK;
}

/* Rounding moves a distance by some units in the last place of the largest number on the way to it; 2^-24 = 6e-8 is one. */
static float rounding_margin(const query_run* run) {
  double h = run->field->cell_size, largest = run->support->magnitude;
  for (int a = 0; a < 3; ++a) {
    double low = fabs(run->test_base[a] + h * (double)run->cell_low[a]);
    double high = fabs(run->test_base[a] + h * (double)run->cell_high[a]);
    if (low > largest) largest = low;
    if (high > largest) largest = high;
  }
  return (float)((largest + (double)run->field->centroid_reach) * 8e-6);
}

/* No distance of the support is less than this. Thin layers are never so deep that a shell leaves something out. */
static double deepest_value(const scree_support* support) {
  double stack[SUPPORT_MAX_STACK];
  stack[0] = -INFINITY;
  uint32_t top = 0;
  for (uint32_t i = 0; i < support->op_count; ++i) {
    const support_op* op = &support->ops[i];
    if (op_is_leaf(op->kind)) {
      const float* core = op->box.core;
      double least = -INFINITY;
      if (op->kind == OP_HEIGHTFIELD) least = -(double)op->height.half * (double)op->height.frame.scale;
      if (op->kind == OP_BOX || op->kind == OP_BOX_TURNED)
        least = -(double)op->box.rounding - fmin((double)core[0], fmin((double)core[1], (double)core[2]));
      stack[top++] = least * (1 + 1e-6);
    } else if (op_is_pair(op->kind)) {
      --top;
      if (op->kind == OP_UNION) stack[top - 1] = fmin(stack[top - 1], stack[top]);
      if (op->kind == OP_INTERSECTION) stack[top - 1] = fmax(stack[top - 1], stack[top]);
      if (op->kind == OP_SMOOTH_UNION) stack[top - 1] = -INFINITY;
    } else {
      stack[top - 1] = -INFINITY;
    }
  }
  return stack[0];
}

static void run_best(query_run* run, query_kernel kernel) {
#ifdef SCREE_WIDE_KERNELS
  if (kernel != QUERY_KERNEL_PLAIN && __builtin_cpu_supports("avx2")) {
    scree_rt_query_run_avx2(run);
    return;
  }
#endif
  (void)kernel;
  scree_rt_query_run_plain(run);
}

/* Everything but the cells and the sinks. */
static query_run prepare(const scree_field* field, const scree_support* support, const double origin[3], float threshold,
                         float floor) {
  query_run run = {.field = field, .support = support, .floor = floor};
  for (int a = 0; a < 3; ++a) {
    run.test_base[a] = field->origin[a] - support->origin[a];
    run.out_base[a] = field->origin[a] - origin[a];
  }
  run.slope = (float)(1 - 2 * (threshold == 0 ? 0.5 : (double)threshold));
  float a = run.slope * field->mean_radius_min, b = run.slope * field->mean_radius_max;
  run.offset_min = a < b ? a : b;
  run.offset_max = a < b ? b : a;
  return run;
}

static scree_result run_prepared(query_run* run, query_kernel kernel, uint64_t* count) {
  *count = 0;
  if (!cut_cells(run)) return SCREE_OK;
  scree_result result = find_cubes(run);
  if (result != SCREE_OK) return result;
  run->margin = rounding_margin(run);
  if ((double)run->floor < deepest_value(run->support) - (double)run->margin) run->floor = -INFINITY;
  /* Without a floor all that is surely in is alike. */
  run->relevant_low = (isfinite(run->floor) ? run->floor : run->offset_min) - run->margin;
  run->relevant_high = run->offset_max + run->margin;
  run->whole = kernel == QUERY_KERNEL_WHOLE;
  run_best(run, kernel);
  *count = run->count;
  return SCREE_OK;
}

static scree_result execute(const scree_query_desc* d, query_kernel kernel, scree_instance* instances, scree_id* ids,
                            uint64_t capacity, uint64_t* count) {
  if (count == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  *count = 0;
  scree_result result = check(d);
  if (result != SCREE_OK) return result;

  const scree_field* field = d->field;
  float floor = -INFINITY;
  if ((d->flags & SCREE_QUERY_SHELL) != 0)
    floor = -(d->shell_depth > 0 ? d->shell_depth : (float)(2 * (double)field->max_radius * field->cell_size));
  query_run run = prepare(field, d->support, d->origin, d->threshold, floor);
  run.instances = instances;
  run.ids = ids;
  run.capacity = capacity;
  bool everywhere = is_everywhere(d);
  for (int a = 0; a < 3; ++a) {
    double h = field->cell_size;
    run.cell_low[a] = everywhere ? (int64_t)-FAR_CELL : scree_rt_query_first_cell(d->min[a] - field->origin[a], h);
    run.cell_high[a] = everywhere ? (int64_t)FAR_CELL : scree_rt_query_first_cell(d->max[a] - field->origin[a], h);
  }
  return run_prepared(&run, kernel, count);
}

scree_result scree_rt_query_cells(const cell_query* q, scree_instance* instances, scree_id* ids, uint64_t capacity,
                                  uint64_t* count) {
  float floor = q->outside ? q->above : q->depth > 0 ? -q->depth : -INFINITY;
  query_run run = prepare(q->field, q->support, q->origin, q->threshold, floor);
  run.deep = q->deep;
  run.instances = instances;
  run.ids = ids;
  run.capacity = capacity;
  memcpy(run.cell_low, q->low, sizeof run.cell_low);
  memcpy(run.cell_high, q->high, sizeof run.cell_high);
  scree_result result = run_prepared(&run, QUERY_KERNEL_BEST, count);
  return result == SCREE_OK && *count > capacity ? SCREE_ERROR_CAPACITY : result;
}

scree_result scree_rt_query_count(const scree_query_desc* desc, query_kernel kernel, uint64_t* count) {
  return execute(desc, kernel, NULL, NULL, 0, count);
}

scree_result scree_rt_query_fill(const scree_query_desc* desc, query_kernel kernel, scree_instance* instances, scree_id* ids,
                                 uint64_t capacity, uint64_t* count) {
  if (instances == NULL && capacity > 0) return SCREE_ERROR_INVALID_ARGUMENT;
  scree_result result = execute(desc, kernel, instances, ids, capacity, count);
  return result == SCREE_OK && *count > capacity ? SCREE_ERROR_CAPACITY : result;
}

scree_result scree_query_count(const scree_query_desc* desc, uint64_t* count) {
  return scree_rt_query_count(desc, QUERY_KERNEL_BEST, count);
}

scree_result scree_query_fill(const scree_query_desc* desc, scree_instance* instances, scree_id* ids, uint64_t capacity,
                              uint64_t* count) {
  return scree_rt_query_fill(desc, QUERY_KERNEL_BEST, instances, ids, capacity, count);
}
