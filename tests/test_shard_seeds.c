/* Seeds of shards: that patterns are what they are called. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* after the five above */
#include <cmocka.h>

#include "failing_allocator.h"
#include "lattice.h"
#include "make_solids.h"
#include "one_line.h"
#include "seed_mask.h"
#include "shard_space.h"
#include "solid_inside.h"

static const double zero[3] = {0, 0, 0};

typedef struct seed_set {
  double* p;
  uint32_t count;
} seed_set;

static seed_set lay(const scree_seed_pattern* pattern, const scree_solid* solid) {
  seed_set out;
  scree_error error;
  if (scree_seeds_create(pattern, solid, NULL, &out.p, &out.count, &error) != SCREE_OK) fail_msg("%s", error.message);
  return out;
}

static void drop(seed_set* set) {
  scree_seeds_free(NULL, set->p, set->count);
}

static double distance(const double* a, const double* b) {
  return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

static bool is_within(const double* p, const double min[3], const double max[3]) {
  return p[0] >= min[0] && p[0] <= max[0] && p[1] >= min[1] && p[1] <= max[1] && p[2] >= min[2] && p[2] <= max[2];
}

static double nearest(const seed_set* set, const double* p, uint32_t self) {
  double least = INFINITY;
  for (uint32_t i = 0; i < set->count; ++i)
    if (i != self) least = fmin(least, distance(set->p + 3 * i, p));
  return least;
}

static uint32_t next_random(uint64_t* state) {
  *state += UINT64_C(0x9e3779b97f4a7c15);
  return (uint32_t)(hash_mix(*state) >> 32);
}

static double unit_random(uint64_t* state) {
  return next_random(state) / 4294967296.0;
}

/* A closed lump with overhangs and 2 n^2 or so triangles: a sphere whose radius has bumps. */
typedef struct lump {
  double* positions;
  uint32_t* indices;
  scree_solid solid;
} lump;

static lump make_lump(uint32_t n, double bumps) {
  lump out = {malloc((size_t)3 * (n * (n - 1) + 2) * sizeof(double)), malloc((size_t)3 * 2 * n * (n - 1) * sizeof(uint32_t)), {0}};
  uint32_t vertices = 0, corners = 0;
  for (uint32_t j = 1; j < n; ++j)
    for (uint32_t i = 0; i < n; ++i) {
      const double a = 6.283185307179586 * i / n, b = 3.141592653589793 * j / n;
      const double r = 1 + bumps * sin(5 * a) * sin(4 * b);
      out.positions[3 * vertices] = r * sin(b) * cos(a);
      out.positions[3 * vertices + 1] = r * cos(b);
      out.positions[3 * vertices++ + 2] = r * sin(b) * sin(a);
    }
  const uint32_t top = vertices, bottom = vertices + 1;
  for (int a = 0; a < 3; ++a) out.positions[3 * top + a] = a == 1, out.positions[3 * bottom + a] = -(a == 1);
  for (uint32_t j = 0; j < n; ++j)
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t k = (i + 1) % n;
      const uint32_t p = j == 0 ? top : (j - 1) * n + i, q = j == 0 ? top : (j - 1) * n + k;
      const uint32_t r = j == n - 1 ? bottom : j * n + i, s = j == n - 1 ? bottom : j * n + k;
      const uint32_t two[6] = {p, q, s, p, s, r};
      for (int t = 0; t < 2; ++t) {
        const uint32_t* v = two + 3 * t;
        if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
        for (int c = 0; c < 3; ++c) out.indices[corners++] = v[c];
      }
    }
  out.solid = (scree_solid){
      .positions = out.positions, .indices = out.indices, .vertex_count = vertices + 2, .triangle_count = corners / 3};
  return out;
}

static void drop_lump(lump* l) {
  free(l->positions);
  free(l->indices);
}

/* --- inside ----------------------------------------------------------------------------------------------------------------- */

/* The solid angle of all triangles, by libm: not repeatable, but independent of rays and bins. */
static double slow_winding(const scree_solid* solid, const double* p) {
  double sum = 0;
  for (uint32_t t = 0; t < solid->triangle_count; ++t) {
    double v[3][3], l[3];
    for (int k = 0; k < 3; ++k) {
      for (int a = 0; a < 3; ++a) v[k][a] = solid->positions[3 * (size_t)solid->indices[3 * t + (uint32_t)k] + (size_t)a] - p[a];
      l[k] = sqrt(v[k][0] * v[k][0] + v[k][1] * v[k][1] + v[k][2] * v[k][2]);
    }
    const double det = v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) - v[0][1] * (v[1][0] * v[2][2] - v[1][2] * v[2][0]) +
                       v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0]);
    double dots[3];
    for (int k = 0; k < 3; ++k) dots[k] = v[k][0] * v[(k + 1) % 3][0] + v[k][1] * v[(k + 1) % 3][1] + v[k][2] * v[(k + 1) % 3][2];
    sum += 2 * atan2(det, l[0] * l[1] * l[2] + dots[0] * l[2] + dots[1] * l[0] + dots[2] * l[1]);
  }
  return sum / (4 * 3.141592653589793);
}

static void inside_is_where_the_solid_angle_says(void** state) {
  (void)state;
  lump l = make_lump(24, 0.3);
  assert_int_equal(scree_solid_check(&l.solid, NULL, NULL), SCREE_OK);
  const scree_allocator allocator = scree_rt_allocator_or_default(NULL);
  solid_inside inside;
  assert_int_equal(solid_inside_create(l.solid.positions, l.solid.indices, l.solid.triangle_count, &allocator, &inside), SCREE_OK);
  assert_true(inside.size[0] > 4 && inside.size[1] > 4);
  uint64_t random = 1;
  uint32_t ins = 0;
  for (int i = 0; i < 3000; ++i) {
    double p[3];
    for (int a = 0; a < 3; ++a) p[a] = 2.8 * unit_random(&random) - 1.4;
    if (i % 4 == 0) { /* right below, on and above vertices */
      const double* q = l.positions + 3 * (next_random(&random) % l.solid.vertex_count);
      p[0] = q[0], p[2] = q[2];
    }
    const double wanted = slow_winding(&l.solid, p);
    if (fabs(wanted - floor(wanted + 0.5)) > 1e-6) continue; /* on the surface */
    assert_int_equal(solid_winding(&inside, p), (int)floor(wanted + 0.5));
    ins += solid_is_inside(&inside, p);
    solid_crossing crossings[64];
    const uint32_t count = solid_crossings(&inside, p[0], p[2], crossings, 64);
    int32_t winding = 0;
    for (uint32_t k = 0; k < count; ++k) winding += crossings[k].y > p[1] ? crossings[k].turn : 0;
    assert_int_equal(winding, solid_winding(&inside, p));
    for (uint32_t k = 1; k < count; ++k) assert_true(crossings[k - 1].y <= crossings[k].y);
  }
  assert_true(ins > 300);
  solid_inside_free(&inside, &allocator);
  drop_lump(&l);
}

static void a_mask_has_all_that_is_inside_or_within_reach(void** state) {
  (void)state;
  lump l = make_lump(16, 0.3);
  const scree_allocator allocator = scree_rt_allocator_or_default(NULL);
  solid_inside inside;
  assert_int_equal(solid_inside_create(l.solid.positions, l.solid.indices, l.solid.triangle_count, &allocator, &inside), SCREE_OK);
  for (int r = 0; r < 3; ++r) {
    const double reach = 0.15 * r, step = 0.06;
    seed_mask mask;
    assert_int_equal(seed_mask_create(&(seed_mask_desc){.positions = l.solid.positions,
                                                        .indices = l.solid.indices,
                                                        .inside = &inside,
                                                        .vertex_count = l.solid.vertex_count,
                                                        .triangle_count = l.solid.triangle_count,
                                                        .step = step,
                                                        .most = reach},
                                      &allocator, &mask),
                     SCREE_OK);
    uint64_t random = 5;
    for (int i = 0; i < 3000; ++i) {
      double p[3], least = INFINITY;
      for (int a = 0; a < 3; ++a) p[a] = 4 * unit_random(&random) - 2;
      for (uint32_t t = 0; t < l.solid.triangle_count; ++t) {
        const uint32_t* v = l.solid.indices + 3 * t;
        least = fmin(least, mask_triangle_distance2(p, l.positions + 3 * v[0], l.positions + 3 * v[1], l.positions + 3 * v[2]));
      }
      const bool wanted = solid_is_inside(&inside, p) || sqrt(least) <= reach;
      if (wanted) assert_true(seed_mask_has(&mask, p));
      if (!wanted && sqrt(least) > reach + 3.5 * step) assert_false(seed_mask_has(&mask, p));
    }
    seed_mask_free(&mask, &allocator);
  }
  solid_inside_free(&inside, &allocator);
  drop_lump(&l);
}

/* --- patterns --------------------------------------------------------------------------------------------------------------- */

static void random_seeds_are_as_many_as_asked_and_all_inside(void** state) {
  (void)state;
  lump l = make_lump(24, 0.3);
  const scree_seed_pattern pattern = {.kind = SCREE_SEEDS_RANDOM, .count = 777, .random_seed = 3};
  seed_set set = lay(&pattern, &l.solid);
  assert_int_equal(set.count, 777);
  for (uint32_t i = 0; i < set.count; ++i) assert_true(slow_winding(&l.solid, set.p + 3 * i) > 0.5);
  drop(&set);
  drop_lump(&l);
}

static void random_seeds_are_uniform(void** state) {
  (void)state;
  box_solid box;
  make_box(&box, zero, (const double[3]){3, 1, 2});
  const scree_seed_pattern pattern = {.kind = SCREE_SEEDS_RANDOM, .count = 40000, .random_seed = 11};
  seed_set set = lay(&pattern, &box.solid);
  uint32_t octants[8] = {0}, bins[64] = {0};
  for (uint32_t i = 0; i < set.count; ++i) {
    const double* p = set.p + 3 * i;
    ++octants[(p[0] >= 1.5) + 2 * (p[1] >= 0.5) + 4 * (p[2] >= 1)];
    ++bins[(int)(p[0] / 3 * 4) + 4 * (int)(p[1] * 4) + 16 * (int)(p[2] / 2 * 4)];
  }
  double chi = 0, chi64 = 0;
  for (int i = 0; i < 8; ++i) chi += (octants[i] - 5000.0) * (octants[i] - 5000.0) / 5000;
  for (int i = 0; i < 64; ++i) chi64 += (bins[i] - 625.0) * (bins[i] - 625.0) / 625;
  assert_true(chi < 24.3);                  /* 7 degrees of freedom, 0.1 % */
  assert_true(chi64 > 30 && chi64 < 103.4); /* 63 degrees of freedom */
  drop(&set);
}

static void a_grid_without_jitter_is_one_of_cubes(void** state) {
  (void)state;
  box_solid box;
  make_box(&box, (const double[3]){1, 2, 3}, (const double[3]){5, 5, 5});
  const scree_seed_pattern pattern = {.kind = SCREE_SEEDS_GRID, .spacing = 0.5};
  seed_set set = lay(&pattern, &box.solid);
  uint32_t within = 0;
  for (uint32_t i = 0; i < set.count; ++i) {
    for (int a = 0; a < 3; ++a) {
      const double at = (set.p[3 * i + a] - box.positions[a]) / 0.5 - 0.5;
      assert_true(fabs(at - floor(at + 0.5)) < 1e-12);
    }
    within += is_within(set.p + 3 * i, box.positions, box.positions + 21);
  }
  assert_int_equal(within, 8 * 6 * 4);
  drop(&set);
  const scree_seed_pattern counted = {.kind = SCREE_SEEDS_GRID, .count = 24};
  set = lay(&counted, &box.solid); /* volume 24 */
  assert_true(fabs(set.p[3] - set.p[0] - 1) < 1e-12 || fabs(nearest(&set, set.p, 0) - 1) < 1e-12);
  drop(&set);
}

static void jitter_moves_seeds_by_half_the_spacing_at_most(void** state) {
  (void)state;
  box_solid box;
  make_box(&box, zero, (const double[3]){4, 4, 4});
  const scree_seed_pattern pattern = {.kind = SCREE_SEEDS_GRID, .spacing = 0.5, .jitter = 0.6, .random_seed = 2};
  seed_set set = lay(&pattern, &box.solid);
  double most = 0;
  for (uint32_t i = 0; i < set.count; ++i)
    for (int a = 0; a < 3; ++a) {
      const double at = set.p[3 * i + a] / 0.5 - 0.5;
      most = fmax(most, fabs(at - floor(at + 0.5)));
    }
  assert_true(most <= 0.3 && most > 0.29);
  drop(&set);
}

/* What is nearest to points of the solid must not depend on how far the pattern was laid beyond it. */
static void assert_no_seed_is_missing(scree_seed_pattern pattern, const scree_solid* small, const scree_solid* large,
                                      const double min[3], const double max[3]) {
  seed_set few = lay(&pattern, small), many = lay(&pattern, large);
  assert_true(few.count < many.count);
  uint64_t random = 77;
  for (int i = 0; i < 2000; ++i) {
    double p[3];
    for (int a = 0; a < 3; ++a) p[a] = min[a] + (max[a] - min[a]) * unit_random(&random);
    assert_true(fabs(nearest(&few, p, UINT32_MAX) - nearest(&many, p, UINT32_MAX)) < 1e-9);
  }
  drop(&few);
  drop(&many);
}

static void seeds_beyond_the_solid_keep_cells_at_its_surface_in_shape(void** state) {
  (void)state;
  box_solid small, large;
  const double min[3] = {0, 0, 0}, max[3] = {2, 2, 2};
  make_box(&small, min, max);
  make_box(&large, min, (const double[3]){4, 4, 4});
  assert_no_seed_is_missing((scree_seed_pattern){.kind = SCREE_SEEDS_GRID, .spacing = 0.4, .jitter = 1, .random_seed = 4},
                            &small.solid, &large.solid, min, max);
  assert_no_seed_is_missing(
      (scree_seed_pattern){.kind = SCREE_SEEDS_COLUMNS, .spacing = 0.4, .length = 0.7, .jitter = 0.7, .random_seed = 4},
      &small.solid, &large.solid, min, max);
  const double layers[3] = {0.2, 0.5, 0.1};
  assert_no_seed_is_missing(
      (scree_seed_pattern){
          .kind = SCREE_SEEDS_SLABS, .spacing = 0.4, .layers = layers, .layer_count = 3, .jitter = 0.7, .random_seed = 4},
      &small.solid, &large.solid, min, max);
}

static void columns_without_jitter_have_six_neighbours_at_the_same_distance(void** state) {
  (void)state;
  box_solid box;
  make_box(&box, zero, (const double[3]){5, 3, 5});
  const scree_seed_pattern pattern = {.kind = SCREE_SEEDS_COLUMNS, .spacing = 0.5};
  seed_set set = lay(&pattern, &box.solid);
  for (uint32_t i = 0; i < set.count; ++i) {
    const double* p = set.p + 3 * i;
    assert_true(p[1] == 1.5);
    if (!is_within(p, (const double[3]){0.5, 0, 0.5}, (const double[3]){4.5, 3, 4.5})) continue;
    uint32_t neighbours = 0;
    for (uint32_t j = 0; j < set.count; ++j) {
      const double d = distance(p, set.p + 3 * j);
      if (i == j) continue;
      assert_true(d > 0.5 - 1e-9);
      neighbours += d < 0.5 + 1e-9;
    }
    assert_int_equal(neighbours, 6);
  }
  drop(&set);
}

static void joints_of_columns_lie_at_random_heights_a_length_apart(void** state) {
  (void)state;
  box_solid box;
  make_box(&box, zero, (const double[3]){4, 8, 4});
  const scree_seed_pattern pattern = {.kind = SCREE_SEEDS_COLUMNS, .spacing = 1, .length = 0.5, .random_seed = 8};
  seed_set set = lay(&pattern, &box.solid);
  double phase = 0;
  uint32_t columns = 0;
  for (uint32_t i = 0; i < set.count; ++i) { /* seeds of a column follow each other */
    const double *p = set.p + 3 * i, *q = p + 3;
    if (i + 1 < set.count && p[0] == q[0] && p[2] == q[2])
      assert_true(q[1] - p[1] >= 0.5 * 0.6 - 1e-9 && q[1] - p[1] <= 0.5 * 1.4 + 1e-9);
    else
      ++columns, phase += p[1] - floor(p[1] / 0.5) * 0.5;
  }
  assert_true(columns > 20);
  assert_true(phase / columns > 0.15 && phase / columns < 0.35);
  drop(&set);
}

/* Midway between seeds that follow each other upwards. */
static uint32_t joints_above(const seed_set* set, uint32_t at, double* joints, uint32_t capacity) {
  uint32_t count = 0;
  for (uint32_t i = at; i + 1 < set->count && count < capacity; ++i) {
    const double *p = set->p + 3 * i, *q = p + 3;
    if (fabs(p[0] - q[0]) > 1e-9 || fabs(p[2] - q[2]) > 1e-9) break;
    joints[count++] = (p[1] + q[1]) / 2;
  }
  return count;
}

static void assert_joints(const double* layers, uint32_t layer_count, uint32_t wanted_splits) {
  box_solid box;
  make_box(&box, (const double[3]){0, 10, 0}, (const double[3]){2, 20, 2});
  const scree_seed_pattern pattern = {
      .kind = SCREE_SEEDS_SLABS, .spacing = 1, .jitter = 0.5, .layers = layers, .layer_count = layer_count, .random_seed = 4};
  seed_set set = lay(&pattern, &box.solid);
  uint32_t longest = 0;
  double joints[4096];
  uint32_t count = 0, most = 0;
  for (uint32_t i = 0; i < set.count; i += count + 1) {
    count = joints_above(&set, i, joints, 4096);
    if (count > most) most = count, longest = i;
  }
  count = joints_above(&set, longest, joints, 4096);
  uint32_t found = 0, others = 0, layer = 0;
  double height = 10;
  for (; height < 20; height += layers[layer++ % layer_count]) {
    bool has = false;
    for (uint32_t k = 0; k < count; ++k) has |= fabs(joints[k] - height) < 1e-9;
    assert_true(has);
    ++found;
  }
  for (uint32_t k = 0; k < count; ++k) others += joints[k] > 10 - 1e-9 && joints[k] < height - 1e-9;
  assert_int_equal(others - found, wanted_splits);
  drop(&set);
}

static void slabs_have_the_thicknesses_of_their_layers(void** state) {
  (void)state;
  assert_joints((const double[1]){0.5}, 1, 0);
  assert_joints((const double[3]){0.5, 0.7, 0.6}, 3, 0);
  assert_joints((const double[2]){1, 0.6}, 2, 4);   /* mirrored seeds drift by 0.4 a pair, as far as there is room */
  assert_joints((const double[2]){1, 0.05}, 2, 10); /* thick layers between thin ones are halved */
  assert_joints((const double[4]){0.1, 3, 0.02, 0.9}, 4, 5);
}

static double radius_of(const double* p, double low, double high, double r0, double r1) {
  const double t = fmin(1, fmax(0, (p[1] - low) / (high - low)));
  return r0 + (r1 - r0) * t;
}

/* Two seeds are never nearer than the larger of their radii, and no point of the solid is much farther from all. */
static void assert_discs(const scree_solid* solid, const double low[3], const double high[3], double r0, double r1) {
  const scree_seed_pattern pattern = {.kind = SCREE_SEEDS_POISSON, .spacing = r0, .spacing_end = r1, .random_seed = 6};
  seed_set set = lay(&pattern, solid);
  const double end = r1 > 0 ? r1 : r0;
  assert_true(set.count > 100);
  for (uint32_t i = 0; i < set.count; ++i)
    for (uint32_t j = 0; j < i; ++j) {
      const double *p = set.p + 3 * i, *q = set.p + 3 * j;
      const double r = fmax(radius_of(p, low[1], high[1], r0, end), radius_of(q, low[1], high[1], r0, end));
      assert_true(distance(p, q) >= r * (1 - 1e-12));
    }
  uint64_t random = 3;
  uint32_t holes = 0;
  for (int i = 0; i < 3000; ++i) {
    double p[3], least = INFINITY;
    for (int a = 0; a < 3; ++a) p[a] = low[a] + (high[a] - low[a]) * unit_random(&random);
    if (slow_winding(solid, p) < 0.5) continue;
    const double r = radius_of(p, low[1], high[1], r0, end);
    for (uint32_t k = 0; k < set.count; ++k) {
      const double* q = set.p + 3 * k;
      least = fmin(least, distance(p, q) / fmax(r, radius_of(q, low[1], high[1], r0, end)));
    }
    assert_true(least < 1.02);
    holes += least > 1;
  }
  assert_true(holes <= 3);
  drop(&set);
}

static void discs_are_apart_and_leave_no_room_for_another(void** state) {
  (void)state;
  box_solid box;
  const double high[3] = {2, 2, 2};
  make_box(&box, zero, high);
  assert_discs(&box.solid, zero, high, 0.25, 0);
  assert_discs(&box.solid, zero, high, 0.15, 0.45);
  assert_discs(&box.solid, zero, high, 0.5, 0.12);
  lump l = make_lump(20, 0.3);
  assert_discs(&l.solid, (const double[3]){-1, -1, -1}, (const double[3]){1, 1, 1}, 0.2, 0.2);
  drop_lump(&l);
}

static void graded_discs_are_sparse_at_the_upper_end(void** state) {
  (void)state;
  box_solid box;
  make_box(&box, zero, (const double[3]){3, 6, 3});
  const scree_seed_pattern pattern = {
      .kind = SCREE_SEEDS_POISSON, .spacing = 1, .spacing_end = 3, .count = 2000, .grade = {0, -2, 0}, .random_seed = 6};
  seed_set set = lay(&pattern, &box.solid);
  uint32_t thirds[3] = {0};
  for (uint32_t i = 0; i < set.count; ++i)
    if (is_within(set.p + 3 * i, zero, (const double[3]){3, 5.999, 3})) ++thirds[(int)(set.p[3 * i + 1] / 2)];
  const double within = thirds[0] + thirds[1] + thirds[2];
  assert_true(within > 2000 * 0.85 && within < 2000 * 1.15);
  /* Radii are least at the top here: 3 to 7/3, to 5/3, to 1; the densities are about as their cubes. */
  assert_true(thirds[2] > 3 * thirds[1] && thirds[1] > 2 * thirds[0]);
  drop(&set);
}

static void counts_are_met_by_volume(void** state) {
  (void)state;
  lump l = make_lump(24, 0.2);
  const scree_allocator allocator = scree_rt_allocator_or_default(NULL);
  solid_inside inside;
  assert_int_equal(solid_inside_create(l.solid.positions, l.solid.indices, l.solid.triangle_count, &allocator, &inside), SCREE_OK);
  const double layers[2] = {0.05, 0.1};
  const scree_seed_pattern patterns[] = {
      {.kind = SCREE_SEEDS_GRID, .count = 1500, .jitter = 0.5},
      {.kind = SCREE_SEEDS_COLUMNS, .count = 1500, .length = 0.1, .jitter = 0.5},
      {.kind = SCREE_SEEDS_SLABS, .count = 1500, .layers = layers, .layer_count = 2, .stretch = {1, 0.5, 2}},
      {.kind = SCREE_SEEDS_POISSON, .count = 1500},
  };
  for (size_t i = 0; i < sizeof patterns / sizeof *patterns; ++i) {
    seed_set set = lay(&patterns[i], &l.solid);
    uint32_t within = 0;
    for (uint32_t k = 0; k < set.count; ++k) within += solid_is_inside(&inside, set.p + 3 * k);
    if (within < 1500 * 0.9 || within > 1500 * 1.1) fail_msg("pattern %zu: %u inside of 1500", i, within);
    assert_true(set.count < 5 * within);
    drop(&set);
  }
  solid_inside_free(&inside, &allocator);
  drop_lump(&l);
}

static void up_tilts_and_stretch_lengthens(void** state) {
  (void)state;
  box_solid box;
  make_box(&box, zero, (const double[3]){4, 4, 4});
  const scree_seed_pattern pattern = {
      .kind = SCREE_SEEDS_GRID, .spacing = 0.5, .up = {1, 2, -0.5}, .stretch = {1, 3, 0.5}, .random_seed = 2};
  seed_set set = lay(&pattern, &box.solid);
  shard_space space;
  assert_true(shard_space_make(pattern.up, pattern.stretch, &space));
  const double length = sqrt(1 + 4 + 0.25);
  for (int a = 0; a < 3; ++a) assert_true(fabs(space.axis[1][a] - pattern.up[a] / length) < 1e-15);
  double first[3];
  shard_space_into(&space, set.p, first);
  for (uint32_t i = 0; i < set.count; ++i) {
    double q[3], back[3];
    shard_space_into(&space, set.p + 3 * i, q);
    shard_space_out_of(&space, q, back);
    for (int a = 0; a < 3; ++a) {
      const double at = (q[a] - first[a]) / 0.5;
      assert_true(fabs(at - floor(at + 0.5)) < 1e-9);
      assert_true(fabs(back[a] - set.p[3 * i + a]) < 1e-12);
    }
  }
  drop(&set);
}

static void the_turn_of_a_space_is_a_turn(void** state) {
  (void)state;
  const double ups[][3] = {{0, 1, 0}, {0, -1, 0}, {1, 0, 0}, {0, 0, -3}, {0.1, -0.99999, 0.1}, {1e-7, -1, 0}, {1, 2, 3}, {0, 0, 0}};
  for (size_t i = 0; i < sizeof ups / sizeof *ups; ++i) {
    shard_space s = {0};
    assert_true(shard_space_make(ups[i], NULL, &s));
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) {
        const double dot = s.axis[j][0] * s.axis[k][0] + s.axis[j][1] * s.axis[k][1] + s.axis[j][2] * s.axis[k][2];
        assert_true(fabs(dot - (j == k)) < 1e-6);
      }
    const double turn = s.axis[0][1] * s.axis[1][2] - s.axis[0][2] * s.axis[1][1];
    assert_true(fabs(turn - s.axis[2][0]) < 1e-6);
  }
}

static void given_points_are_taken_as_they_are(void** state) {
  (void)state;
  const double points[6] = {1, 2, 3, -4, 5.5, 1e5};
  const scree_seed_pattern pattern = {.kind = SCREE_SEEDS_POINTS, .points = points, .point_count = 2, .up = {1, 1, 1}};
  box_solid box;
  make_box(&box, zero, (const double[3]){4, 4, 4});
  seed_set set = lay(&pattern, &box.solid);
  assert_int_equal(set.count, 2);
  assert_memory_equal(set.p, points, sizeof points);
  drop(&set);
}

/* --- the same everywhere, and what goes wrong ------------------------------------------------------------------------------- */

static uint64_t digest(const seed_set* set) {
  uint64_t hash = set->count;
  for (uint32_t i = 0; i < 3 * set->count; ++i) {
    uint64_t bits;
    memcpy(&bits, &set->p[i], sizeof bits);
    hash = hash_combine(hash, bits);
  }
  return hash;
}

static const double some_layers[3] = {0.2, 0.5, 0.1};
static const scree_seed_pattern all_patterns[] = {
    {.kind = SCREE_SEEDS_RANDOM, .count = 500, .random_seed = 1},
    {.kind = SCREE_SEEDS_GRID, .spacing = 0.3, .jitter = 0.8, .up = {1, 3, 0}, .random_seed = 1},
    {.kind = SCREE_SEEDS_COLUMNS, .count = 200, .jitter = 0.4, .random_seed = 1},
    {.kind = SCREE_SEEDS_COLUMNS, .spacing = 0.3, .length = 0.2, .stretch = {1, 4, 1}, .jitter = 0.4, .random_seed = 1},
    {.kind = SCREE_SEEDS_SLABS, .spacing = 0.4, .layers = some_layers, .layer_count = 3, .up = {0.3, 1, 0.1}, .random_seed = 1},
    {.kind = SCREE_SEEDS_POISSON, .spacing = 0.15, .spacing_end = 0.4, .grade = {1, 0, 1}, .stretch = {1, 2, 1}, .random_seed = 1},
    {.kind = SCREE_SEEDS_POISSON, .count = 300, .spacing = 1, .spacing_end = 2, .random_seed = 1},
};
enum { PATTERNS = sizeof all_patterns / sizeof *all_patterns };

static void seeds_are_the_same_everywhere(void** state) {
  (void)state;
  static const uint64_t wanted[PATTERNS] = {
      UINT64_C(0x6b0819fc5f67e032), UINT64_C(0xa46870591227c4a9), UINT64_C(0xfe37c474f422ecc9), UINT64_C(0xc6bd6bc7fa4b9d30),
      UINT64_C(0x882e539f803a2537), UINT64_C(0x059b1caebfa796a8), UINT64_C(0xd806f0cd92a2f3af)};
  float heights[64];
  for (int i = 0; i < 64; ++i) heights[i] = (float)(i % 8 * (7 - i % 8) + i / 8 * 3) / 16;
  scree_solid_memory solid;
  assert_int_equal(scree_solid_from_heights(heights, 8, 8, 0.25, -1, NULL, &solid, NULL), SCREE_OK);
  bool same = true;
  for (int i = 0; i < PATTERNS; ++i) {
    seed_set set = lay(&all_patterns[i], &solid.solid);
    if (digest(&set) != wanted[i])
      same = false, print_error("pattern %d has the digest 0x%016llx, %u seeds\n", i, (unsigned long long)digest(&set), set.count);
    drop(&set);
  }
  assert_true(same);
  scree_solid_free(NULL, &solid);
}

static void assert_refused(scree_seed_pattern pattern, const scree_solid* solid, scree_result wanted) {
  double* seeds = NULL;
  uint32_t count = 7;
  scree_error error;
  assert_int_equal(scree_seeds_create(&pattern, solid, NULL, &seeds, &count, &error), wanted);
  assert_one_line(&error);
  assert_null(seeds);
  assert_int_equal(count, 0);
  assert_int_equal(scree_seeds_create(&pattern, solid, NULL, &seeds, &count, NULL), wanted);
}

static void bad_patterns_are_told(void** state) {
  (void)state;
  box_solid box;
  make_box(&box, zero, (const double[3]){4, 4, 4});
  const scree_solid* s = &box.solid;
  const scree_result invalid = SCREE_ERROR_INVALID_ARGUMENT, range = SCREE_ERROR_RANGE;
  const double nan_point[3] = {0, NAN, 0}, layers[2] = {1, 0};
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_RANDOM}, s, invalid);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_RANDOM, .count = 1000001}, s, range);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_RANDOM, .count = 5}, NULL, invalid);
  assert_refused((scree_seed_pattern){.kind = (scree_seed_kind)17, .count = 5}, s, invalid);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_GRID}, s, range);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_GRID, .spacing = NAN}, s, range);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_GRID, .spacing = -1}, s, range);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_GRID, .spacing = 0.001}, s, range);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_GRID, .spacing = 0.03}, s, range);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_GRID, .spacing = 1e-9}, s, range);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_GRID, .spacing = 1, .jitter = 1.5}, s, range);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_GRID, .spacing = 1, .up = {0, NAN, 0}}, s, range);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_GRID, .spacing = 1, .stretch = {1, 1, 0}}, s, range);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_GRID, .spacing = 1, .stretch = {1, 1, 101}}, s, range);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_COLUMNS, .spacing = 1, .length = -1}, s, range);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_COLUMNS, .spacing = 1, .length = 1e-9}, s, range);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_SLABS, .spacing = 1, .layer_count = 2}, s, invalid);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_SLABS, .spacing = 1, .layers = layers, .layer_count = 2}, s, range);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_SLABS, .spacing = 1e-9}, s, range);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_POISSON, .spacing = 1, .spacing_end = 1e3}, s, range);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_POISSON, .spacing = 1, .grade = {0, INFINITY, 0}}, s, range);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_POINTS}, s, invalid);
  assert_refused((scree_seed_pattern){.kind = SCREE_SEEDS_POINTS, .points = nan_point, .point_count = 1}, s, range);
  assert_int_equal(scree_seeds_create(NULL, s, NULL, NULL, NULL, NULL), invalid);
  scree_seeds_free(NULL, NULL, 0);
}

static void seeds_of_hostile_triangles_are_made_or_refused(void** state) {
  (void)state;
  uint64_t random = 9;
  for (int round = 0; round < 6; ++round) {
    double positions[60];
    uint32_t indices[120];
    for (int i = 0; i < 60; ++i)
      positions[i] = round % 3 == 0 ? next_random(&random) % 3 : unit_random(&random) * (round % 3 == 1 ? 1 : 1e6);
    for (int i = 0; i < 120; ++i) indices[i] = next_random(&random) % 20;
    const scree_solid solid = {.positions = positions, .indices = indices, .vertex_count = 20, .triangle_count = 40};
    for (int i = 0; i < PATTERNS; ++i) {
      scree_seed_pattern pattern = all_patterns[i];
      if (pattern.count == 0) pattern.count = 100;
      double* seeds;
      uint32_t count;
      if (scree_seeds_create(&pattern, &solid, NULL, &seeds, &count, NULL) == SCREE_OK) {
        for (uint32_t k = 0; k < 3 * count; ++k) assert_true(isfinite(seeds[k]));
        scree_seeds_free(NULL, seeds, count);
      }
    }
  }
}

static void seeds_survive_every_failing_allocation(void** state) {
  (void)state;
  box_solid box;
  make_box(&box, zero, (const double[3]){1, 1, 1});
  for (int i = 0; i < PATTERNS; ++i)
    for (int32_t at = 0;; ++at) {
      failing_allocator failing = {.fail_at = at};
      const scree_allocator allocator = failing_allocator_of(&failing);
      double* seeds;
      uint32_t count;
      const scree_result result = scree_seeds_create(&all_patterns[i], &box.solid, &allocator, &seeds, &count, NULL);
      assert_int_equal(result, failing.failed ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_OK);
      if (result == SCREE_OK) scree_seeds_free(&allocator, seeds, count);
      assert_true(failing.live == 0);
      if (!failing.failed) break;
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(inside_is_where_the_solid_angle_says),
      cmocka_unit_test(a_mask_has_all_that_is_inside_or_within_reach),
      cmocka_unit_test(random_seeds_are_as_many_as_asked_and_all_inside),
      cmocka_unit_test(random_seeds_are_uniform),
      cmocka_unit_test(a_grid_without_jitter_is_one_of_cubes),
      cmocka_unit_test(jitter_moves_seeds_by_half_the_spacing_at_most),
      cmocka_unit_test(seeds_beyond_the_solid_keep_cells_at_its_surface_in_shape),
      cmocka_unit_test(columns_without_jitter_have_six_neighbours_at_the_same_distance),
      cmocka_unit_test(joints_of_columns_lie_at_random_heights_a_length_apart),
      cmocka_unit_test(slabs_have_the_thicknesses_of_their_layers),
      cmocka_unit_test(discs_are_apart_and_leave_no_room_for_another),
      cmocka_unit_test(graded_discs_are_sparse_at_the_upper_end),
      cmocka_unit_test(counts_are_met_by_volume),
      cmocka_unit_test(up_tilts_and_stretch_lengthens),
      cmocka_unit_test(the_turn_of_a_space_is_a_turn),
      cmocka_unit_test(given_points_are_taken_as_they_are),
      cmocka_unit_test(seeds_are_the_same_everywhere),
      cmocka_unit_test(bad_patterns_are_told),
      cmocka_unit_test(seeds_of_hostile_triangles_are_made_or_refused),
      cmocka_unit_test(seeds_survive_every_failing_allocation),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
