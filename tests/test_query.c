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
#include "rounds.h"

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
  assert_int_equal(scree_rt_field_create_from_source(&s->field_desc, &s->source.source, NULL, &s->field), SCREE_OK);
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
  double min[3], max[3];
  scree_support_bounds(s->support, min, max);
  bool endless = false;
  for (int a = 0; a < 3; ++a) endless = endless || !isfinite(min[a]) || !isfinite(max[a]);
  if (endless || random_below(r, 2)) {
    for (int a = 0; a < 3; ++a) {
      double at = s->shapes.desc.origin[a];
      if (!isfinite(min[a])) min[a] = (isfinite(max[a]) ? max[a] : at + 8) - 16;
      if (!isfinite(max[a])) max[a] = min[a] + 16;
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
  for (int round = 0; round < ROUNDS(75, 4); ++round) {
    scene s = {0};
    scree_shape_kind kind = (scree_shape_kind)(round % (SCREE_SHAPE_PATTERN + 1));
    uint32_t seeds = random_below(&r, 3) ? 1 : 4;
    make_field(&s, &r, 3 + (uint32_t)round % 6, random_below(&r, 2), seeds);
    random_leaf(&s.shapes, &r, kind, 10);
    make_support(&s, &r);
    scree_query_desc d = random_query(&s, &r);
    check_scene(&s, &d, 30);
    destroy_scene(&s);
  }
}

/* Layers and boxes that are about as thin as the shell is deep: where nothing is deep enough, nothing is looked at for it. */
static void query_equals_its_plain_twin_for_layers_as_thin_as_the_shell(void** state) {
  (void)state;
  static const uint32_t children[] = {1, 2};
  random_stream r = {31};
  uint64_t shells = 0, wholes = 0;
  for (int round = 0; round < 60; ++round) {
    scene s = {0};
    make_field(&s, &r, 3 + (uint32_t)round % 6, random_below(&r, 2), random_below(&r, 3) ? 1 : 4);
    random_leaf(&s.shapes, &r, SCREE_SHAPE_HEIGHTFIELD, 10);
    scree_shape *shapes = s.shapes.shapes, layer = shapes[0], box = {.kind = SCREE_SHAPE_BOX, .transform = layer.transform};
    double thin = 0.5 * (double)(layer.heightfield.above + layer.heightfield.below) * (double)layer.transform.scale;
    for (int a = 0; a < 3; ++a) box.box.half[a] = (float)(a == 1 ? random_in(&r, 0.5, 1.5) : random_in(&r, 2, 8));
    if (random_below(&r, 2)) box.transform = (scree_transform){.scale = 1}; /* else it is turned with the layer */
    static const scree_shape_kind kinds[] = {SCREE_SHAPE_UNION, SCREE_SHAPE_INTERSECTION, SCREE_SHAPE_DIFFERENCE,
                                             SCREE_SHAPE_SMOOTH_UNION};
    shapes[0] = (scree_shape){.kind = kinds[round % 4], .group = {.children = children, .child_count = 2}};
    if (shapes[0].kind == SCREE_SHAPE_SMOOTH_UNION) shapes[0].group.blend = 0.5f;
    shapes[1] = round & 4 ? box : layer;
    shapes[2] = round & 4 ? layer : box;
    s.shapes.desc.shape_count = 3;
    make_support(&s, &r);
    scree_query_desc d = {.field = s.field, .support = s.support, .flags = SCREE_QUERY_SHELL};
    d.shell_depth = (float)(thin * random_in(&r, 0.3, 1.3));
    if (random_below(&r, 2)) d.threshold = (float)random_in(&r, 0.1, 0.9);
    check_scene(&s, &d, 30);
    found_rocks shell = run_query(&d, QUERY_KERNEL_BEST);
    d.flags = 0;
    found_rocks whole = run_query(&d, QUERY_KERNEL_BEST);
    shells += shell.count;
    wholes += whole.count;
    found_free(&shell);
    found_free(&whole);
    destroy_scene(&s);
  }
  assert_true(shells > 1000 && wholes > shells);
}

static void query_equals_its_plain_twin_for_random_trees(void** state) {
  (void)state;
  random_stream r = {7};
  for (int round = 0; round < ROUNDS(60, 5); ++round) {
    scene s = {0};
    make_field(&s, &r, 3 + random_below(&r, 6), random_below(&r, 2), random_below(&r, 3) ? 1 : 3);
    random_tree(&s.shapes, &r, 2 + random_below(&r, RANDOM_MAX_LEAVES - 1), 10);
    make_support(&s, &r);
    for (int k = 0; k < 3; ++k) {
      scree_query_desc d = random_query(&s, &r);
      check_scene(&s, &d, 30);
    }
    destroy_scene(&s);
  }
}

/* Thousands of rocks along surfaces that smooth unions and thresholds move about: where a part of space is cut off a little too
 * early, some of them go missing. The twin trusts the support's bounds here, which test_support.c holds. */
static void query_equals_its_plain_twin_where_many_rocks_are_in_doubt(void** state) {
  (void)state;
  random_stream r = {70};
  for (int round = 0; round < 10; ++round) {
    scene s = {0};
    s.source = synthetic_create(3 + random_below(&r, 4), 1, 1, random_bits(&r));
    s.field_desc = (scree_field_desc){.seed = random_bits(&r), .cell_size = 0.3};
    assert_int_equal(scree_rt_field_create_from_source(&s.field_desc, &s.source.source, NULL, &s.field), SCREE_OK);
    static const uint32_t children[] = {1, 2, 3, 4, 5, 6};
    scree_shape* shapes = s.shapes.shapes;
    uint32_t count = 2 + random_below(&r, 5);
    memset(shapes, 0, sizeof *shapes * (count + 1));
    shapes[0] = (scree_shape){.kind = SCREE_SHAPE_SMOOTH_UNION, .group = {children, count, (float)random_in(&r, 1, 6)}};
    for (uint32_t i = 1; i <= count; ++i) {
      shapes[i].kind = SCREE_SHAPE_SPHERE;
      shapes[i].sphere.radius = (float)random_in(&r, 1, 4);
      for (int a = 0; a < 3; ++a) shapes[i].transform.translation[a] = (float)random_in(&r, -5, 5);
    }
    s.shapes.desc = (scree_support_desc){.shapes = shapes, .shape_count = count + 1};
    assert_int_equal(scree_support_create(&s.shapes.desc, NULL, &s.support, NULL), SCREE_OK);
    for (int k = 0; k < 3; ++k) {
      scree_query_desc d = {.field = s.field, .support = s.support, .flags = k & 1};
      d.threshold = (float[]){0.5f, 0.05f, 0.9f}[k];
      double min[3], max[3];
      int64_t low[3], high[3];
      assert_true(scree_rt_support_level_bounds(s.support, 0.5, min, max));
      for (int a = 0; a < 3; ++a) {
        low[a] = (int64_t)floor(min[a] / 0.3) - 2;
        high[a] = (int64_t)ceil(max[a] / 0.3) + 2;
      }
      found_rocks expected = twin_query(&d, &s.source.source, low, high), found = run_query(&d, QUERY_KERNEL_BEST);
      assert_true(expected.count > 500);
      assert_found_equal(&expected, &found);
      found_free(&expected);
      found_free(&found);
    }
    destroy_scene(&s);
  }
}

/* A tree beyond what the scratch for pruned programs holds, so that parts go on with programs that were not pruned. */
static void query_equals_its_plain_twin_for_hundreds_of_shapes(void** state) {
  (void)state;
  enum { LEAVES = 2000 };
  random_stream r = {99};
  static scree_shape shapes[LEAVES + 1];
  static uint32_t children[LEAVES];
  memset(shapes, 0, sizeof shapes);
  for (uint32_t i = 0; i < LEAVES; ++i) {
    scree_shape* leaf = &shapes[i + 1];
    children[i] = i + 1;
    leaf->kind = i % 2 ? SCREE_SHAPE_SPHERE : SCREE_SHAPE_BOX;
    for (int a = 0; a < 3; ++a) leaf->transform.translation[a] = (float)random_in(&r, -6, 6);
    leaf->sphere.radius = (float)random_in(&r, 0.5, 2);
    if (leaf->kind == SCREE_SHAPE_BOX)
      for (int a = 0; a < 3; ++a) leaf->box.half[a] = (float)random_in(&r, 0.5, 2);
  }
  const scree_shape_kind kinds[] = {SCREE_SHAPE_UNION, SCREE_SHAPE_SMOOTH_UNION, SCREE_SHAPE_DIFFERENCE};
  for (int k = 0; k < 3; ++k) {
    scene s = {0};
    shapes[0] = (scree_shape){.kind = kinds[k], .group = {children, LEAVES, 0.5f}};
    shapes[1] = (scree_shape){.kind = SCREE_SHAPE_SPHERE, .sphere = {6}};
    make_field(&s, &r, 5, 1, 1);
    s.shapes.desc = (scree_support_desc){.shapes = shapes, .shape_count = LEAVES + 1};
    make_support(&s, &r);
    scree_query_desc d = {.field = s.field, .support = s.support, .flags = SCREE_QUERY_SHELL};
    check_scene(&s, &d, 10);
    destroy_scene(&s);
  }
}

/* Five hundred shapes of all kinds, with groups and noise. */
static void query_equals_its_plain_twin_for_a_grove_of_all_shapes(void** state) {
  (void)state;
  random_stream r = {500};
  for (uint32_t round = 0; round < 2; ++round) {
    scene s = {0};
    make_field(&s, &r, 5, 1, 1);
    random_grove grove = random_grove_create(&r, 45, 5, 24);
    assert_in_range(grove.desc.shape_count, 450, 650);
    s.shapes.desc = grove.desc;
    make_support(&s, &r);
    double min[3], max[3], h = s.field_desc.cell_size;
    int64_t low[3], high[3];
    assert_true(scree_rt_support_level_bounds(s.support, 1, min, max));
    for (int a = 0; a < 3; ++a) {
      double offset = s.support->origin[a] - s.field_desc.origin[a];
      low[a] = (int64_t)floor((offset + min[a]) / h) - 2;
      high[a] = (int64_t)ceil((offset + max[a]) / h) + 2;
    }
    for (uint32_t kind = 0; kind < 3; ++kind) {
      scree_query_desc d = {.field = s.field, .support = s.support, .flags = kind > 0};
      d.threshold = kind == 2 ? 0.3f : 0;
      found_rocks expected = twin_query(&d, &s.source.source, low, high);
      const query_kernel kernels[] = {QUERY_KERNEL_BEST, QUERY_KERNEL_PLAIN, QUERY_KERNEL_WHOLE};
      assert_true(expected.count > 500);
      for (int k = 0; k < 3; ++k) {
        found_rocks found = run_query(&d, kernels[k]);
        assert_found_equal(&expected, &found);
        found_free(&found);
      }
      found_free(&expected);
    }
    random_grove_destroy(&grove);
    destroy_scene(&s);
  }
}

/* Random cuts of a box into boxes, asked for in random order, find the whole and nothing twice. */
static void union_of_any_partition_into_boxes_is_the_whole(void** state) {
  (void)state;
  random_stream r = {31};
  for (int round = 0; round < 12; ++round) {
    scene s = {0};
    make_field(&s, &r, 3 + random_below(&r, 6), 1, 2);
    random_tree(&s.shapes, &r, 1 + random_below(&r, 8), 10);
    make_support(&s, &r);
    scree_query_desc d = random_query(&s, &r);
    double min[3], max[3];
    scree_support_bounds(s.support, min, max);
    for (int a = 0; a < 3; ++a) {
      d.min[a] = min[a] - 4;
      d.max[a] = max[a] + 4;
    }
    found_rocks whole = run_query(&d, QUERY_KERNEL_BEST), parts = {NULL, 0};
    enum { BOXES = 40 };
    double boxes[BOXES][2][3];
    memcpy(boxes[0][0], d.min, sizeof d.min);
    memcpy(boxes[0][1], d.max, sizeof d.max);
    for (uint32_t n = 1; n < BOXES; ++n) { /* cut one, anywhere or exactly through cell centres */
      uint32_t cut = random_below(&r, n), axis = random_below(&r, 3);
      double at = random_in(&r, boxes[cut][0][axis], boxes[cut][1][axis]), origin = s.field_desc.origin[axis];
      if (random_below(&r, 2)) at = origin + s.field_desc.cell_size * floor((at - origin) / s.field_desc.cell_size);
      if (at < boxes[cut][0][axis]) at = boxes[cut][0][axis];
      memcpy(boxes[n], boxes[cut], sizeof boxes[n]);
      boxes[cut][1][axis] = boxes[n][0][axis] = at;
    }
    for (uint32_t left = BOXES; left > 0; --left) {
      uint32_t pick = random_below(&r, left);
      memcpy(d.min, boxes[pick][0], sizeof d.min);
      memcpy(d.max, boxes[pick][1], sizeof d.max);
      memcpy(boxes[pick], boxes[left - 1], sizeof boxes[pick]);
      bool zero = true; /* which would mean everywhere */
      for (int a = 0; a < 3; ++a) zero = zero && d.min[a] == 0 && d.max[a] == 0;
      if (zero) continue;
      found_rocks part = run_query(&d, random_below(&r, 2) ? QUERY_KERNEL_BEST : QUERY_KERNEL_PLAIN);
      found_join(&parts, &part);
      found_free(&part);
    }
    assert_found_equal(&whole, &parts);
    for (uint64_t i = 1; i < parts.count; ++i)
      assert_memory_not_equal(&parts.rocks[i - 1].id, &parts.rocks[i].id, sizeof(scree_id));
    found_free(&whole);
    found_free(&parts);
    destroy_scene(&s);
  }
}

/* 10,000 km away everything is the same to the byte: places and shift are multiples of 1/1024 m, so their sums are exact. */
static void field_far_from_the_origin_is_the_same_field(void** state) {
  (void)state;
  random_stream r = {64};
  const double shifts[3] = {1e7, -1e7, 1e7 / 1024};
  for (int round = 0; round < 10; ++round) {
    scene near = {0};
    make_field(&near, &r, 5, 1, 1);
    random_tree(&near.shapes, &r, 1 + random_below(&r, 12), 10);
    make_support(&near, &r);
    scree_query_desc d = random_query(&near, &r);
    scene far = near;
    scree_query_desc e = d;
    for (int a = 0; a < 3; ++a) {
      double* places[] = {&near.field_desc.origin[a], &near.shapes.desc.origin[a], &d.origin[a], &d.min[a], &d.max[a]};
      double* shifted[] = {&far.field_desc.origin[a], &far.shapes.desc.origin[a], &e.origin[a], &e.min[a], &e.max[a]};
      for (int k = 0; k < 5; ++k) {
        *places[k] = floor(*places[k] * 1024) / 1024;
        *shifted[k] = *places[k] + shifts[a];
      }
    }
    bool everywhere = true;
    for (int a = 0; a < 3; ++a) everywhere = everywhere && d.min[a] == 0 && d.max[a] == 0;
    if (everywhere) {
      memset(e.min, 0, sizeof e.min);
      memset(e.max, 0, sizeof e.max);
    }
    scree_field_destroy(near.field);
    scree_support_destroy(near.support);
    assert_int_equal(scree_rt_field_create_from_source(&near.field_desc, &near.source.source, NULL, &near.field), SCREE_OK);
    assert_int_equal(scree_rt_field_create_from_source(&far.field_desc, &near.source.source, NULL, &far.field), SCREE_OK);
    assert_int_equal(scree_support_create(&near.shapes.desc, NULL, &near.support, NULL), SCREE_OK);
    near.shapes.desc.origin[0] = far.shapes.desc.origin[0];
    near.shapes.desc.origin[1] = far.shapes.desc.origin[1];
    near.shapes.desc.origin[2] = far.shapes.desc.origin[2];
    assert_int_equal(scree_support_create(&near.shapes.desc, NULL, &far.support, NULL), SCREE_OK);
    d.field = near.field;
    d.support = near.support;
    e.field = far.field;
    e.support = far.support;
    found_rocks here = run_query(&d, QUERY_KERNEL_BEST), there = run_query(&e, QUERY_KERNEL_BEST);
    assert_found_equal(&here, &there);
    found_free(&here);
    found_free(&there);
    scree_field_destroy(far.field);
    scree_support_destroy(far.support);
    destroy_scene(&near);
  }
}

static void origin_of_a_query_decides_positions_and_nothing_else(void** state) {
  (void)state;
  random_stream r = {12};
  scene s = {0};
  make_field(&s, &r, 5, 1, 1);
  random_tree(&s.shapes, &r, 6, 10);
  make_support(&s, &r);
  scree_query_desc d = {.field = s.field, .support = s.support, .flags = SCREE_QUERY_SHELL};
  found_rocks first = run_query(&d, QUERY_KERNEL_BEST);
  assert_true(first.count > 50);
  for (int round = 0; round < 10; ++round) {
    for (int a = 0; a < 3; ++a) d.origin[a] = random_in(&r, -1e6, 1e6);
    found_rocks again = run_query(&d, QUERY_KERNEL_BEST);
    assert_int_equal(again.count, first.count);
    for (uint64_t i = 0; i < first.count; ++i) {
      assert_memory_equal(&again.rocks[i].id, &first.rocks[i].id, sizeof(scree_id));
      assert_int_equal(again.rocks[i].instance.asset, first.rocks[i].instance.asset);
      for (int a = 0; a < 3; ++a) {
        double moved = (double)again.rocks[i].instance.position[a] + d.origin[a];
        assert_true(fabs(moved - (double)first.rocks[i].instance.position[a]) <= 0.07); /* half a float step at 1e6 */
      }
    }
    found_free(&again);
  }
  found_free(&first);
  destroy_scene(&s);
}

/* An id names the cell and the seed it came from. */
static void ids_decode_to_cells_and_seeds(void** state) {
  (void)state;
  random_stream r = {5};
  scene s = {0};
  make_field(&s, &r, 4, 1, 3);
  random_leaf(&s.shapes, &r, SCREE_SHAPE_BOX, 20);
  make_support(&s, &r);
  scree_query_desc d = {.field = s.field, .support = s.support};
  memcpy(d.origin, s.field_desc.origin, sizeof d.origin);
  found_rocks found = run_query(&d, QUERY_KERNEL_BEST);
  assert_true(found.count > 100);
  const field_source* source = &s.source.source;
  for (uint64_t i = 0; i < found.count; ++i) {
    const found_rock* rock = &found.rocks[i];
    uint32_t seed = rock->id.local % source->max_rocks_per_cell, cell = rock->id.local / source->max_rocks_per_cell;
    uint32_t place[3] = {cell % 4, cell / 4 % 4, cell / 16};
    assert_true(place[2] < 4);
    uint32_t code = scree_field_tile_code(s.field, rock->id.cube);
    assert_int_equal(code, cube_code(s.field_desc.seed, rock->id.cube[0], rock->id.cube[1], rock->id.cube[2]));
    uint32_t unique = scree_rt_lattice_cell(4, code, place[0], place[1], place[2]);
    assert_in_range(rock->instance.asset, source->cell_first[unique], source->cell_first[unique + 1] - 1);
    assert_int_equal(source->rocks[rock->instance.asset].seed, seed);
    for (int a = 0; a < 3; ++a)
      assert_true(rock->instance.position[a] ==
                  (float)(s.field_desc.cell_size * (double)(rock->id.cube[a] * 4 + (int32_t)place[a])));
    if (i > 0) assert_memory_not_equal(&rock->id, &rock[-1].id, sizeof rock->id);
  }
  found_free(&found);
  destroy_scene(&s);
}

/* Every capacity from 0 on: the first rocks, the whole count, and not a byte past the end. */
static void fill_stops_at_the_capacity_and_counts_on(void** state) {
  (void)state;
  random_stream r = {8};
  scene s = {0};
  make_field(&s, &r, 5, 1, 1);
  random_leaf(&s.shapes, &r, SCREE_SHAPE_SPHERE, 8);
  make_support(&s, &r);
  scree_query_desc d = {.field = s.field, .support = s.support};
  const query_kernel kernels[] = {QUERY_KERNEL_BEST, QUERY_KERNEL_PLAIN};
  for (int k = 0; k < 2; ++k) {
    uint64_t count, total;
    assert_int_equal(scree_rt_query_count(&d, kernels[k], &total), SCREE_OK);
    assert_in_range(total, 20, 5000);
    scree_instance* all = malloc(total * sizeof *all);
    scree_id* all_ids = malloc(total * sizeof *all_ids);
    assert_int_equal(scree_rt_query_fill(&d, kernels[k], all, all_ids, total, &count), SCREE_OK);
    for (uint64_t capacity = 0; capacity < total + 20; ++capacity) { /* exact-size buffers, for the sanitizers */
      scree_instance* some = malloc((capacity + !capacity) * sizeof *some);
      scree_id* ids = malloc((capacity + !capacity) * sizeof *ids);
      scree_result expected = capacity < total ? SCREE_ERROR_CAPACITY : SCREE_OK;
      uint64_t kept = capacity < total ? capacity : total;
      for (int with_ids = 0; with_ids < 2; ++with_ids) {
        assert_int_equal(scree_rt_query_fill(&d, kernels[k], some, with_ids ? ids : NULL, capacity, &count), expected);
        assert_int_equal(count, total);
        assert_memory_equal(some, all, kept * sizeof *some);
      }
      assert_memory_equal(ids, all_ids, kept * sizeof *ids);
      free(some);
      free(ids);
    }
    assert_int_equal(scree_rt_query_fill(&d, kernels[k], NULL, NULL, 0, &count), SCREE_ERROR_CAPACITY);
    assert_int_equal(count, total);
    free(all);
    free(all_ids);
  }
  destroy_scene(&s);
}

static void higher_thresholds_and_shallower_shells_only_take_rocks_away(void** state) {
  (void)state;
  random_stream r = {55};
  scene s = {0};
  make_field(&s, &r, 5, 1, 1);
  random_leaf(&s.shapes, &r, SCREE_SHAPE_SPHERE, 16);
  make_support(&s, &r);
  scree_query_desc d = {.field = s.field, .support = s.support};
  uint64_t last = UINT64_MAX, count;
  for (int k = 1; k < 20; ++k) {
    d.threshold = (float)k * 0.05f;
    assert_int_equal(scree_query_count(&d, &count), SCREE_OK);
    assert_true(count < last);
    last = count;
  }
  d.threshold = 0;
  d.flags = SCREE_QUERY_SHELL;
  last = 0;
  for (int k = 1; k < 20; ++k) {
    d.shell_depth = (float)k * 0.5f;
    assert_int_equal(scree_query_count(&d, &count), SCREE_OK);
    assert_true(count >= last);
    last = count;
  }
  d.flags = 0;
  assert_int_equal(scree_query_count(&d, &count), SCREE_OK);
  assert_true(count >= last && count > 0);
  destroy_scene(&s);
}

static void no_shell_depth_means_twice_the_largest_radius(void** state) {
  (void)state;
  random_stream r = {56};
  scene s = {0};
  make_field(&s, &r, 5, 1, 1);
  random_leaf(&s.shapes, &r, SCREE_SHAPE_SPHERE, 30);
  make_support(&s, &r);
  scree_query_desc d = {.field = s.field, .support = s.support, .flags = SCREE_QUERY_SHELL};
  found_rocks by_default = run_query(&d, QUERY_KERNEL_BEST);
  d.shell_depth = (float)(2 * (double)s.source.source.max_radius * s.field_desc.cell_size);
  found_rocks by_number = run_query(&d, QUERY_KERNEL_BEST);
  assert_found_equal(&by_default, &by_number);
  found_free(&by_default);
  found_free(&by_number);
  destroy_scene(&s);
}

static void infinite_boxes_and_all_zero_boxes_reach_everywhere(void** state) {
  (void)state;
  random_stream r = {57};
  scene s = {0};
  make_field(&s, &r, 5, 1, 1);
  random_leaf(&s.shapes, &r, SCREE_SHAPE_BOX, 12);
  make_support(&s, &r);
  scree_query_desc d = {.field = s.field, .support = s.support};
  found_rocks everywhere = run_query(&d, QUERY_KERNEL_BEST);
  assert_true(everywhere.count > 10);
  for (int round = 0; round < 2; ++round) {
    for (int a = 0; a < 3; ++a) {
      d.min[a] = round == 0 ? -INFINITY : -1e300;
      d.max[a] = round == 0 ? INFINITY : 1e300;
    }
    found_rocks infinite = run_query(&d, QUERY_KERNEL_BEST);
    assert_found_equal(&everywhere, &infinite);
    found_free(&infinite);
  }
  for (int a = 0; a < 3; ++a) d.min[a] = d.max[a] = 1; /* half-open: nothing */
  found_rocks none = run_query(&d, QUERY_KERNEL_BEST);
  assert_int_equal(none.count, 0);
  found_free(&none);
  found_free(&everywhere);
  destroy_scene(&s);
}

static void wrong_queries_are_refused(void** state) {
  (void)state;
  random_stream r = {58};
  scene s = {0};
  make_field(&s, &r, 5, 1, 1);
  random_leaf(&s.shapes, &r, SCREE_SHAPE_SPHERE, 8);
  make_support(&s, &r);
  const scree_query_desc good = {.field = s.field, .support = s.support};
  uint64_t count = 77;
  scree_instance one;
  assert_int_equal(scree_query_count(&good, NULL), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_query_count(NULL, &count), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(count, 0);
  assert_int_equal(scree_query_fill(&good, NULL, NULL, 3, &count), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_query_fill(&good, &one, NULL, 1, NULL), SCREE_ERROR_INVALID_ARGUMENT);
#define REFUSED(change)                                                                          \
  do {                                                                                           \
    scree_query_desc d = good;                                                                   \
    change;                                                                                      \
    assert_int_equal(scree_query_count(&d, &count), SCREE_ERROR_INVALID_ARGUMENT);               \
    assert_int_equal(scree_query_fill(&d, &one, NULL, 1, &count), SCREE_ERROR_INVALID_ARGUMENT); \
  } while (0)
  REFUSED(d.field = NULL);
  REFUSED(d.support = NULL);
  REFUSED(d.flags = 2);
  REFUSED(d.threshold = 1);
  REFUSED(d.threshold = -0.1f);
  REFUSED(d.threshold = NAN);
  REFUSED(d.shell_depth = -1);
  REFUSED(d.shell_depth = INFINITY);
  REFUSED(d.shell_depth = NAN);
  for (int a = 0; a < 3; ++a) {
    REFUSED(d.origin[a] = NAN);
    REFUSED(d.origin[a] = INFINITY);
    REFUSED(d.min[a] = NAN);
    REFUSED(d.max[a] = NAN);
    REFUSED(d.min[a] = 1);
  }
#undef REFUSED
  destroy_scene(&s);
}

static void cubes_beyond_int32_are_out_of_range(void** state) {
  (void)state;
  random_stream r = {59};
  synthetic_source source = synthetic_create(3, 1, 1, 1);
  scree_shape ball = {.kind = SCREE_SHAPE_SPHERE, .sphere = {2}};
  scree_field_desc field_desc = {.seed = 1, .cell_size = 1};
  scree_field* field;
  assert_int_equal(scree_rt_field_create_from_source(&field_desc, &source.source, NULL, &field), SCREE_OK);
  const double last = 3.0 * INT32_MAX;
  const struct {
    double at;
    scree_result expected;
  } places[] = {{0, SCREE_OK},
                {last - 10, SCREE_OK},
                {last + 10, SCREE_ERROR_RANGE},
                {-last + 10, SCREE_OK},
                {-last - 10, SCREE_ERROR_RANGE},
                {1e300, SCREE_ERROR_RANGE},
                {-1e300, SCREE_ERROR_RANGE}};
  for (size_t i = 0; i < sizeof places / sizeof places[0]; ++i)
    for (int a = 0; a < 3; ++a) {
      scree_support_desc desc = {.shapes = &ball, .shape_count = 1};
      desc.origin[a] = places[i].at;
      scree_support* support;
      assert_int_equal(scree_support_create(&desc, NULL, &support, NULL), SCREE_OK);
      scree_query_desc d = {.field = field, .support = support};
      uint64_t count;
      assert_int_equal(scree_query_count(&d, &count), places[i].expected);
      assert_true(places[i].expected != SCREE_OK || count > 10);
      d.max[0] = d.max[1] = d.max[2] = 1; /* a box elsewhere has nothing to do with it */
      d.min[0] = d.min[1] = d.min[2] = 0.5;
      assert_int_equal(scree_query_count(&d, &count), SCREE_OK);
      scree_support_destroy(support);
    }
  scree_field_destroy(field);
  synthetic_destroy(&source);
  (void)r;
}

static void world_hash_is_a_value_of_the_place_alone(void** state) {
  (void)state;
  random_stream r = {60};
  scene s = {0}, t = {0};
  make_field(&s, &r, 5, 1, 1);
  make_field(&t, &r, 5, 1, 1);
  uint32_t bits = 0, same_neighbour = 0, same_field = 0;
  for (int32_t i = 0; i < 1000; ++i) {
    scree_id id = {{i % 10, i / 10 % 10, -i / 100}, (uint16_t)(i % 125), 0}, next = id;
    next.local += 1;
    uint32_t hash = scree_world_hash(s.field, &id);
    assert_int_equal(hash, scree_world_hash(s.field, &id));
    bits += (uint32_t)__builtin_popcount(hash);
    same_neighbour += hash == scree_world_hash(s.field, &next);
    same_field += hash == scree_world_hash(t.field, &id);
  }
  assert_in_range(bits, 15500, 16500);
  assert_int_equal(same_neighbour, 0);
  assert_int_equal(same_field, 0);
  const int32_t end[3] = {INT32_MAX, INT32_MIN, INT32_MAX};
  assert_in_range(scree_field_tile_code(s.field, end), 0, 255);
  destroy_scene(&s);
  destroy_scene(&t);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(query_equals_its_plain_twin_for_single_shapes),
      cmocka_unit_test(query_equals_its_plain_twin_for_layers_as_thin_as_the_shell),
      cmocka_unit_test(query_equals_its_plain_twin_for_random_trees),
      cmocka_unit_test(query_equals_its_plain_twin_where_many_rocks_are_in_doubt),
      cmocka_unit_test(query_equals_its_plain_twin_for_hundreds_of_shapes),
      cmocka_unit_test(query_equals_its_plain_twin_for_a_grove_of_all_shapes),
      cmocka_unit_test(union_of_any_partition_into_boxes_is_the_whole),
      cmocka_unit_test(field_far_from_the_origin_is_the_same_field),
      cmocka_unit_test(origin_of_a_query_decides_positions_and_nothing_else),
      cmocka_unit_test(ids_decode_to_cells_and_seeds),
      cmocka_unit_test(fill_stops_at_the_capacity_and_counts_on),
      cmocka_unit_test(higher_thresholds_and_shallower_shells_only_take_rocks_away),
      cmocka_unit_test(no_shell_depth_means_twice_the_largest_radius),
      cmocka_unit_test(infinite_boxes_and_all_zero_boxes_reach_everywhere),
      cmocka_unit_test(wrong_queries_are_refused),
      cmocka_unit_test(cubes_beyond_int32_are_out_of_range),
      cmocka_unit_test(world_hash_is_a_value_of_the_place_alone),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
