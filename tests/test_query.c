/* Queries against their plain twin (query_twin.h), and what every query promises. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "query_twin.h"
#include "random_support.h"

/* A field on random tables, and a support. */
typedef struct scene {
  synthetic_source source;
  scree_field_desc field_desc;
  scree_field* field;
  random_support shapes;
  scree_support* support;
} scene;

static void make_field(scene* s, random_stream* r, uint32_t n, uint32_t seeds_min, uint32_t seeds_max) {
  s->source = synthetic_create(n, seeds_min, seeds_max, random_bits(r));
  s->field_desc = (scree_field_desc){.seed = random_bits(r), .cell_size = random_in(r, 0.5, 1.5)};
  for (int a = 0; a < 3; ++a) s->field_desc.origin[a] = random_in(r, -50, 50);
  assert_int_equal(field_create_from_source(&s->field_desc, &s->source.source, NULL, &s->field), SCREE_OK);
}

static void make_support(scene* s, random_stream* r) {
  scree_error error;
  for (int a = 0; a < 3; ++a) s->shapes.desc.origin[a] = random_in(r, -50, 50);
  if (scree_support_create(&s->shapes.desc, NULL, &s->support, &error) != SCREE_OK) fail_msg("%s", error.message);
}

static void destroy_scene(scene* s) {
  scree_field_destroy(s->field);
  scree_support_destroy(s->support);
  synthetic_destroy(&s->source);
}

static scree_query_desc random_query(const scene* s, random_stream* r) {
  scree_query_desc d = {.field = s->field, .support = s->support};
  for (int a = 0; a < 3; ++a) d.origin[a] = random_in(r, -80, 80);
  if (random_below(r, 2)) d.threshold = (float)random_in(r, 0.02, 0.98);
  if (random_below(r, 2)) d.flags = SCREE_QUERY_SHELL;
  if (random_below(r, 2)) d.shell_depth = (float)random_in(r, 0.1, 5);
  if (random_below(r, 2)) {
    double min[3], max[3];
    scree_support_bounds(s->support, min, max);
    for (int a = 0; a < 3; ++a) {
      double p = random_in(r, min[a] - 2, max[a] + 2), q = random_in(r, min[a] - 2, max[a] + 2);
      d.min[a] = p < q ? p : q;
      d.max[a] = p < q ? q : p;
    }
  }
  return d;
}

/* The twin's cells: the support, on all sides, and then some. Everything a test makes lies within `reach` of its origin. */
static found_rocks twin(const scene* s, const scree_query_desc* d, double reach) {
  double h = s->field_desc.cell_size;
  int64_t low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    double offset = s->shapes.desc.origin[a] - s->field_desc.origin[a];
    low[a] = (int64_t)floor((offset - reach) / h);
    high[a] = (int64_t)ceil((offset + reach) / h);
  }
  return twin_query(d, &s->source.source, low, high);
}

static void check_scene(const scene* s, const scree_query_desc* d, double reach) {
  found_rocks expected = twin(s, d, reach), plain = run_query(d, QUERY_KERNEL_PLAIN), best = run_query(d, QUERY_KERNEL_BEST);

  assert_found_equal(&expected, &plain);
  assert_found_equal(&expected, &best);
  found_free(&expected);
  found_free(&plain);
  found_free(&best);
}

static void query_equals_its_plain_twin_for_single_shapes(void** state) {
  (void)state;
  random_stream r = {2026};
  for (int round = 0; round < 40; ++round) {
    scene s = {0};
    scree_shape_kind kind = (scree_shape_kind)(round % (SCREE_SHAPE_CALLBACK + 1));
    if (kind == SCREE_SHAPE_MESH) continue;
    uint32_t seeds = random_below(&r, 3) ? 1 : 4;
    make_field(&s, &r, 3 + (uint32_t)round % 6, random_below(&r, 2), seeds);
    random_leaf(&s.shapes, &r, kind, 10);
    make_support(&s, &r);
    scree_query_desc d = random_query(&s, &r);
    check_scene(&s, &d, 30);
    destroy_scene(&s);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(query_equals_its_plain_twin_for_single_shapes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
