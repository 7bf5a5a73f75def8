#include "query_twin.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static int compare_ids(const void* a, const void* b) {
  const scree_id *p = &((const found_rock*)a)->id, *q = &((const found_rock*)b)->id;
  for (int k = 2; k >= 0; --k)
    if (p->cube[k] != q->cube[k]) return p->cube[k] < q->cube[k] ? -1 : 1;
  return p->local < q->local ? -1 : p->local > q->local;
}

static void add(found_rocks* found, uint64_t* capacity, const found_rock* rock) {
  if (found->count == *capacity) {
    *capacity = *capacity * 2 + 64;
    found->rocks = realloc(found->rocks, *capacity * sizeof *found->rocks);
    assert_non_null(found->rocks);
  }
  found->rocks[found->count++] = *rock;
}

static int64_t floor_division(int64_t a, int64_t b) {
  return (a - ((a % b) + b) % b) / b;
}

static bool in_box(const scree_query_desc* d, const int64_t cell[3]) {
  bool everywhere = true, inside = true;
  for (int a = 0; a < 3; ++a) {
    double centre = d->field->cell_size * (double)cell[a], origin = d->field->origin[a];
    if (d->min[a] != 0 || d->max[a] != 0) everywhere = false;
    if (centre < d->min[a] - origin || centre >= d->max[a] - origin) inside = false;
  }
  return everywhere || inside;
}

/* Rocks whose distance is still to be asked for; many at once, since a call has its price. What a point's distance is does not
 * depend on its neighbours in the call: test_support.c holds that. */
typedef struct pending_rocks {
  float x[512], y[512], z[512], mean_radius[512];
  found_rock rocks[512];
  uint32_t count;
} pending_rocks;

static void settle(const scree_query_desc* d, float depth, pending_rocks* pending, found_rocks* found, uint64_t* capacity) {
  float distance[512], share = d->threshold == 0 ? 0.5f : d->threshold;
  scree_support_distance(d->support, pending->x, pending->y, pending->z, distance, pending->count);
  for (uint32_t i = 0; i < pending->count; ++i) {
    if (distance[i] > (float)(1 - 2 * (double)share) * pending->mean_radius[i]) continue;
    if ((d->flags & SCREE_QUERY_SHELL) && distance[i] <= -depth) continue;
    add(found, capacity, &pending->rocks[i]);
  }
  pending->count = 0;
}

found_rocks twin_query(const scree_query_desc* d, const field_source* source, const int64_t low[3], const int64_t high[3]) {
  const scree_field* field = d->field;
  double h = field->cell_size;
  int64_t n = source->cells_per_cube, c[3];
  float depth = d->shell_depth > 0 ? d->shell_depth : (float)(2 * (double)source->max_radius * h);
  found_rocks found = {NULL, 0};
  uint64_t capacity = 0;
  pending_rocks pending;
  pending.count = 0;
  for (c[2] = low[2]; c[2] < high[2]; ++c[2])
    for (c[1] = low[1]; c[1] < high[1]; ++c[1])
      for (c[0] = low[0]; c[0] < high[0]; ++c[0]) {
        if (!in_box(d, c)) continue;
        found_rock rock = {0}; /* ids of one field have layer 0 */
        uint32_t place[3];
        float at[3];
        for (int a = 0; a < 3; ++a) {
          rock.id.cube[a] = (int32_t)floor_division(c[a], n);
          place[a] = (uint32_t)(c[a] - n * rock.id.cube[a]);
          rock.instance.position[a] = (float)((field->origin[a] - d->origin[a]) + h * (double)c[a]);
          at[a] = (float)((field->origin[a] - d->support->origin[a]) + h * (double)c[a]);
        }
        uint32_t code = cube_code(field->seed, rock.id.cube[0], rock.id.cube[1], rock.id.cube[2]);
        uint32_t cell = scree_rt_lattice_cell((uint32_t)n, code, place[0], place[1], place[2]);
        for (uint32_t asset = source->cell_first[cell]; asset < source->cell_first[cell + 1]; ++asset) {
          const field_rock* r = &source->rocks[asset];
          uint32_t k = pending.count++;
          pending.x[k] = at[0] + (float)((double)r->centroid[0] * h);
          pending.y[k] = at[1] + (float)((double)r->centroid[1] * h);
          pending.z[k] = at[2] + (float)((double)r->centroid[2] * h);
          pending.mean_radius[k] = (float)(0.5 * ((double)r->inner_radius + (double)r->outer_radius) * h);
          rock.id.local =
              (uint16_t)((place[0] + (uint32_t)n * (place[1] + (uint32_t)n * place[2])) * source->max_rocks_per_cell + r->seed);
          rock.instance.asset = asset;
          pending.rocks[k] = rock;
          if (pending.count == 512) settle(d, depth, &pending, &found, &capacity);
        }
      }
  settle(d, depth, &pending, &found, &capacity);
  if (found.count > 0) qsort(found.rocks, found.count, sizeof *found.rocks, compare_ids);
  return found;
}

found_rocks run_query(const scree_query_desc* desc, query_kernel kernel) {
  uint64_t count = 0, filled = 0;
  assert_int_equal(scree_rt_query_count(desc, kernel, &count), SCREE_OK);
  size_t room = (size_t)count + 1;
  scree_instance* instances = malloc(room * sizeof *instances);
  scree_instance* alone = malloc(room * sizeof *alone);
  scree_id* ids = malloc(room * sizeof *ids);
  found_rocks found = {malloc(room * sizeof *found.rocks), count};
  assert_true(instances != NULL && alone != NULL && ids != NULL && found.rocks != NULL);
  assert_int_equal(scree_rt_query_fill(desc, kernel, instances, ids, count, &filled), SCREE_OK);
  assert_int_equal(filled, count);
  assert_int_equal(scree_rt_query_fill(desc, kernel, alone, NULL, count, &filled),
                   SCREE_OK); /* ids are a side line: same rocks, same order */
  assert_int_equal(filled, count);
  assert_memory_equal(instances, alone, count * sizeof *instances);
  for (uint64_t i = 0; i < count; ++i) found.rocks[i] = (found_rock){ids[i], instances[i]};
  if (count > 0) qsort(found.rocks, count, sizeof *found.rocks, compare_ids);
  free(instances);
  free(alone);
  free(ids);
  return found;
}

void found_free(found_rocks* found) {
  free(found->rocks);
  *found = (found_rocks){NULL, 0};
}

void assert_found_equal(const found_rocks* expected, const found_rocks* found) {
  assert_int_equal(found->count, expected->count);
  for (uint64_t i = 0; i < expected->count; ++i) assert_memory_equal(&found->rocks[i], &expected->rocks[i], sizeof *found->rocks);
}

void found_join(found_rocks* a, const found_rocks* b) {
  if (b->count == 0) return;
  a->rocks = realloc(a->rocks, (a->count + b->count) * sizeof *a->rocks);
  assert_non_null(a->rocks);
  memcpy(a->rocks + a->count, b->rocks, b->count * sizeof *b->rocks);
  a->count += b->count;
  qsort(a->rocks, a->count, sizeof *a->rocks, compare_ids);
}
