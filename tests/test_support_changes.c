/* What supports share, what differs between two, and what wrong callbacks can do. */
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "failing_allocator.h"
#include "must_create.h"
#include "query_twin.h"
#include "random_support.h"
#include "support_program.h"

/* --- changed bounds -------------------------------------------------------------------------------------------------------- */

/* Two trees that were made the same way. */
static random_support one, other;

static void make_two(random_stream* r, uint32_t leaves) {
  random_stream again = *r;
  random_tree(&one, r, leaves, 10);
  random_tree(&other, &again, leaves, 10);
}

static scree_shape* any_leaf(random_support* s, random_stream* r) {
  scree_shape* shapes = s->shapes + (RANDOM_MAX_SHAPES - s->desc.shape_count);
  for (;;) {
    scree_shape* shape = &shapes[random_below(r, s->desc.shape_count)];
    if (s->desc.shape_count == 1) return &s->shapes[0];
    if (shape->kind < SCREE_SHAPE_UNION) return shape;
  }
}

static bool alike(float a, float b, double level) {
  return memcmp(&a, &b, sizeof a) == 0 || ((double)a > level && (double)b > level) || ((double)a < -level && (double)b < -level);
}

/* Fails the test when a point outside the box can tell the two apart. Returns how many of `points` lie outside. */
static int check_outside(const scree_support* a, const scree_support* b, double level, random_stream* r, int points) {
  double min[3], max[3];
  bool some = scree_support_changed_bounds(a, b, level, min, max);
  int outside = 0;
  for (int i = 0; i < points; ++i) {
    float p[3], before, after;
    bool inside = some;
    for (int k = 0; k < 3; ++k) {
      double reach = random_below(r, 2) ? 25 : 8;
      p[k] = (float)random_in(r, -reach, reach);
      inside = inside && a->origin[k] + (double)p[k] >= min[k] && a->origin[k] + (double)p[k] <= max[k];
    }
    if (inside) continue;
    ++outside;
    scree_support_distance(a, &p[0], &p[1], &p[2], &before, 1);
    scree_support_distance(b, &p[0], &p[1], &p[2], &after, 1);
    if (!alike(before, after, level))
      fail_msg("at %g %g %g: %g and %g, level %g", (double)p[0], (double)p[1], (double)p[2], (double)before, (double)after, level);
  }
  return outside;
}

static void nothing_changes_outside_the_changed_bounds(void** state) {
  (void)state;
  random_stream r = {1};
  int outside = 0, alone = 0;
  for (int round = 0; round < 150; ++round) {
    make_two(&r, 2 + random_below(&r, RANDOM_MAX_LEAVES - 1));
    uint32_t changes = 1 + random_below(&r, 2);
    for (uint32_t i = 0; i < changes; ++i) {
      scree_shape* leaf = any_leaf(&other, &r);
      if (random_below(&r, 2)) leaf->transform.translation[random_below(&r, 3)] += (float)random_in(&r, -3, 3);
      if (random_below(&r, 2)) leaf->transform.scale = (float)random_in(&r, 0.5, 1.5);
      if (leaf->kind == SCREE_SHAPE_BOX) leaf->box.half[1] += 0.25f;
    }
    for (int a = 0; a < 3; ++a) one.desc.origin[a] = other.desc.origin[a] = random_in(&r, -100, 100);
    scree_support *a = must_create(&one.desc), *b = must_create(&other.desc);
    double level = random_below(&r, 3) ? random_in(&r, 0, 4) : 0;
    int found = check_outside(a, b, level, &r, 1500);
    outside += found;
    double min[3], max[3];
    assert_false(scree_support_changed_bounds(a, a, level, min, max));
    scree_support* twin = must_create(&one.desc); /* made again: nothing differs, whatever is pointed at */
    assert_false(scree_support_changed_bounds(a, twin, level, min, max));
    alone += found > 500;
    scree_support_destroy(twin);
    scree_support_destroy(a);
    scree_support_destroy(b);
  }
  assert_true(alone > 75 && outside > 75 * 800); /* or a box round everything would do */
}

static void changed_bounds_of_trees_built_otherwise_hold_both(void** state) {
  (void)state;
  random_stream r = {2};
  for (int round = 0; round < 40; ++round) {
    make_two(&r, 3);
    random_tree(&other, &r, 1 + random_below(&r, 8), 10);
    if (round % 2) other.desc.origin[1] = 1;
    scree_support *a = must_create(&one.desc), *b = must_create(&other.desc);
    double min[3], max[3], low[3], high[3];
    if (scree_support_changed_bounds(a, b, 1, min, max) && scree_rt_support_level_bounds(b, 1, low, high))
      for (int k = 0; k < 3; ++k) assert_true(min[k] <= low[k] + other.desc.origin[k] && max[k] >= high[k] + other.desc.origin[k]);
    if (round % 2 == 0) check_outside(a, b, 1, &r, 500);
    scree_support_destroy(a);
    scree_support_destroy(b);
  }
}

static void moving_one_ball_of_many_touches_two_balls(void** state) {
  (void)state;
  enum { BALLS = 200 };
  scree_shape shapes[BALLS + 1];
  uint32_t children[BALLS];
  memset(shapes, 0, sizeof shapes);
  for (uint32_t i = 0; i < BALLS; ++i) {
    children[i] = i + 1;
    shapes[i + 1] = (scree_shape){.kind = SCREE_SHAPE_SPHERE, .sphere = {1}};
    shapes[i + 1].transform.translation[0] = 3 * (float)i;
  }
  shapes[0] = (scree_shape){.kind = SCREE_SHAPE_UNION, .group = {children, BALLS, 0}};
  scree_support* before = must_create(&(scree_support_desc){.shapes = shapes, .shape_count = BALLS + 1});
  shapes[100].transform.translation[1] = 2;
  scree_support* after = must_create(&(scree_support_desc){.shapes = shapes, .shape_count = BALLS + 1});
  double min[3], max[3];
  const double low[3] = {295, -2, -2}, high[3] = {299, 4, 2}; /* radius 1, level 1, the ball at 297 */
  assert_true(scree_support_changed_bounds(before, after, 1, min, max));
  for (int a = 0; a < 3; ++a) {
    assert_true(min[a] <= low[a] && min[a] > low[a] - 0.01);
    assert_true(max[a] >= high[a] && max[a] < high[a] + 0.01);
  }
  scree_support_destroy(before);
  scree_support_destroy(after);
}

/* --- shared grids ---------------------------------------------------------------------------------------------------------- */

typedef struct shared_scene {
  random_support ring, ground;
  uint32_t children[4];
  scree_shape shapes[5];
  scree_support_desc desc;
} shared_scene;

/* A ring, ground, and the ring once more. */
static void make_shared(shared_scene* s) {
  random_stream r = {3};
  random_leaf(&s->ring, &r, SCREE_SHAPE_MESH, 10);
  random_leaf(&s->ground, &r, SCREE_SHAPE_HEIGHTFIELD, 10);
  memset(s->shapes, 0, sizeof s->shapes);
  for (uint32_t i = 0; i < 4; ++i) s->children[i] = i + 1;
  s->shapes[0] = (scree_shape){.kind = SCREE_SHAPE_UNION, .group = {s->children, 4, 0}};
  s->shapes[1] = s->ring.shapes[0];
  s->shapes[2] = s->ground.shapes[0];
  s->shapes[3] = s->ring.shapes[0];
  s->shapes[3].transform.translation[0] += 20;
  s->shapes[4] = (scree_shape){.kind = SCREE_SHAPE_SPHERE, .sphere = {1}};
  s->desc = (scree_support_desc){.shapes = s->shapes, .shape_count = 5};
}

static void assert_same_distances(const scree_support* a, const scree_support* b, random_stream* r) {
  for (int i = 0; i < 300; ++i) {
    float p[3], da, db;
    for (int k = 0; k < 3; ++k) p[k] = (float)random_in(r, -25, 25);
    scree_support_distance(a, &p[0], &p[1], &p[2], &da, 1);
    scree_support_distance(b, &p[0], &p[1], &p[2], &db, 1);
    assert_memory_equal(&da, &db, sizeof da);
  }
}

static void equal_grids_are_shared_and_outlive_their_maker(void** state) {
  (void)state;
  static shared_scene s;
  random_stream r = {4};
  make_shared(&s);
  failing_allocator first_memory = {.fail_at = -1}, second_memory = {.fail_at = -1};
  const scree_allocator first = failing_allocator_of(&first_memory), second = failing_allocator_of(&second_memory);
  for (int order = 0; order < 2; ++order) {
    scree_support *a, *b, *alone;
    s.desc.reuse = NULL;
    assert_int_equal(scree_support_create(&s.desc, &first, &a, NULL), SCREE_OK);
    assert_ptr_equal(a->meshes[0], a->meshes[1]); /* also within one support */
    s.shapes[1].transform.translation[1] += 1;
    s.shapes[2].heightfield.above += 0.5f; /* of the layer, not of the grid */
    s.desc.reuse = a;
    second_memory.asked = 0;
    assert_int_equal(scree_support_create(&s.desc, &second, &b, NULL), SCREE_OK);
    assert_ptr_equal(a->meshes[0], b->meshes[0]);
    assert_ptr_equal(a->heights[0], b->heights[0]);
    assert_true(second_memory.asked < 8192);
    s.desc.reuse = NULL;
    alone = must_create(&s.desc);
    assert_same_distances(b, alone, &r);
    scree_support_destroy(order == 0 ? a : b);
    if (order == 0) assert_same_distances(b, alone, &r);
    scree_support_destroy(order == 0 ? b : a);
    scree_support_destroy(alone);
    assert_int_equal(first_memory.live, 0);
    assert_int_equal(second_memory.live, 0);
  }
}

static void grids_of_other_content_are_not_shared(void** state) {
  (void)state;
  static shared_scene s;
  make_shared(&s);
  scree_support* a = must_create(&s.desc);
  s.desc.reuse = a;
  for (int change = 0; change < 5; ++change) {
    make_shared(&s);
    s.desc.reuse = a;
    bool mesh = change < 2;
    if (change == 0) s.shapes[1].mesh.resolution += 1;
    if (change == 1) s.ring.data[0].mesh_positions[7] *= 1.01f, s.shapes[3] = s.shapes[1];
    if (change == 2) s.shapes[2].heightfield.spacing *= 1.01f;
    if (change == 3) s.ground.data[0].heights[1] += 0.01f;
    if (change == 4 && s.shapes[2].heightfield.depth > 2) s.shapes[2].heightfield.depth -= 1;
    scree_support* b = must_create(&s.desc);
    if (mesh)
      assert_ptr_not_equal(a->meshes[0], b->meshes[0]);
    else
      assert_ptr_not_equal(a->heights[0], b->heights[0]);
    s.desc.reuse = NULL;
    scree_support* alone = must_create(&s.desc);
    random_stream r = {5};
    assert_same_distances(b, alone, &r);
    scree_support_destroy(b);
    scree_support_destroy(alone);
  }
  scree_support_destroy(a);
}

/* Wrong content is found although something is reused. */
static void reuse_does_not_skip_checks_of_what_is_new(void** state) {
  (void)state;
  static shared_scene s;
  scree_error error;
  make_shared(&s);
  scree_support *a = must_create(&s.desc), *b;
  s.desc.reuse = a;
  s.ground.data[0].heights[3] = NAN;
  assert_int_equal(scree_support_create(&s.desc, NULL, &b, &error), SCREE_ERROR_RANGE);
  assert_non_null(strstr(error.message, "shape 2: heightfield.heights[3] is not a number"));
  make_shared(&s);
  s.desc.reuse = a;
  s.ring.data[0].mesh_indices[4] = s.ring.data[0].mesh_indices[3];
  assert_int_equal(scree_support_create(&s.desc, NULL, &b, &error), SCREE_ERROR_INVALID_ARGUMENT);
  scree_support_destroy(a);
}

typedef struct sharer {
  scree_support_desc desc;
  scree_support* kept;
} sharer;

static void* share(void* context) {
  sharer* s = context;
  for (int i = 0; i < 200; ++i) {
    scree_support* next;
    s->desc.reuse = s->kept != NULL ? s->kept : s->desc.reuse;
    if (scree_support_create(&s->desc, NULL, &next, NULL) != SCREE_OK) return context;
    scree_support_destroy(s->kept);
    s->kept = next;
  }
  return NULL;
}

static void threads_share_and_drop_grids_at_once(void** state) {
  (void)state;
  enum { THREADS = 4 };
  static shared_scene s;
  make_shared(&s);
  scree_support* base = must_create(&s.desc);
  sharer sharers[THREADS];
  pthread_t threads[THREADS];
  for (int t = 0; t < THREADS; ++t) {
    sharers[t] = (sharer){s.desc, NULL};
    sharers[t].desc.reuse = base;
    assert_int_equal(pthread_create(&threads[t], NULL, share, &sharers[t]), 0);
  }
  for (int t = 0; t < THREADS; ++t) {
    void* failed;
    assert_int_equal(pthread_join(threads[t], &failed), 0);
    assert_null(failed);
  }
  random_stream r = {6};
  assert_ptr_equal(sharers[0].kept->meshes[0], base->meshes[0]);
  assert_int_equal(atomic_load(&base->meshes[0]->share.uses), 2 * (THREADS + 1));
  scree_support_destroy(base);
  for (int t = 1; t < THREADS; ++t) assert_same_distances(sharers[0].kept, sharers[t].kept, &r);
  for (int t = 0; t < THREADS; ++t) scree_support_destroy(sharers[t].kept);
}

/* --- callbacks that break their promises ----------------------------------------------------------------------------------- */

static void constant(void* user, const float* x, const float* y, const float* z, float* distance, uint32_t count) {
  (void)x;
  (void)y;
  (void)z;
  for (uint32_t i = 0; i < count; ++i) distance[i] = *(const float*)user;
}

/* A ball whose distance grows by `user` a metre. */
static void steep_ball(void* user, const float* x, const float* y, const float* z, float* distance, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) distance[i] = (sqrtf(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]) - 3) * *(const float*)user;
}

typedef struct heard {
  int count;
  char last[512];
} heard;

static void hear(void* user, scree_log_level level, const char* message) {
  heard* h = user;
  assert_int_equal(level, SCREE_LOG_ERROR);
  ++h->count;
  snprintf(h->last, sizeof h->last, "%s", message);
}

static scree_shape wrong_callback(scree_distance_fn distance, float* user) {
  return (scree_shape){.kind = SCREE_SHAPE_CALLBACK,
                       .callback = {.distance = distance, .user = user, .min = {-4, -4, -4}, .max = {4, 4, 4}}};
}

/* A ball of radius 5 at (2, 0, 0) and a callback in a box of half size 4, combined. */
static scree_support* combined(scree_shape_kind kind, bool callback_first, const scree_shape* callback, heard* h) {
  static const uint32_t children[2] = {1, 2};
  scree_shape ball = {.kind = SCREE_SHAPE_SPHERE, .transform = {.translation = {2, 0, 0}}, .sphere = {5}};
  scree_shape shapes[3] = {{.kind = kind, .group = {children, 2, 1}}, ball, *callback};
  if (callback_first) {
    shapes[1] = *callback;
    shapes[2] = ball;
  }
  if (kind == SCREE_SHAPE_NOISE) {
    memset(&shapes[0], 0, sizeof shapes[0]);
    shapes[0].kind = kind;
    shapes[0].noise = (scree_noise){.child = callback_first ? 1 : 2, .amplitude = 0.5f, .wavelength = 2, .octaves = 2};
  }
  return must_create(&(scree_support_desc){.shapes = shapes, .shape_count = 3, .log = {hear, h}});
}

static void what_is_not_a_number_makes_no_rock_appear(void** state) {
  (void)state;
  float nan = NAN;
  scree_shape callback = wrong_callback(constant, &nan), ball = {.kind = SCREE_SHAPE_SPHERE, .sphere = {5}};
  ball.transform.translation[0] = 2;
  scree_support* alone = must_create(&(scree_support_desc){.shapes = &ball, .shape_count = 1});
  random_stream r = {7};
  heard h = {0, ""};
  for (int round = 0; round < 10; ++round) {
    scree_shape_kind kind = (scree_shape_kind)(SCREE_SHAPE_UNION + round % 5);
    bool first = round >= 5;
    scree_support* s = combined(kind, first, &callback, &h);
    for (int i = 0; i < 200; ++i) {
      float p[3], of_ball, d;
      for (int a = 0; a < 3; ++a) p[a] = (float)random_in(&r, -3.9, 3.9); /* in the callback's box */
      scree_support_distance(s, &p[0], &p[1], &p[2], &d, 1);
      scree_support_distance(alone, &p[0], &p[1], &p[2], &of_ball, 1);
      if (kind == SCREE_SHAPE_UNION || kind == SCREE_SHAPE_SMOOTH_UNION)
        assert_memory_equal(&d, &of_ball, sizeof d); /* the rest of the support is as it was */
      else
        assert_true(d == INFINITY);
    }
    scree_support_destroy(s);
  }
#ifdef NDEBUG
  assert_int_equal(h.count, 0);
#else
  assert_true(h.count > 0);
  assert_non_null(strstr(h.last, "the callback's distance at ("));
  assert_non_null(strstr(h.last, ") is not a number"));
#endif
  scree_support_destroy(alone);
}

/* Whatever a callback says, a query ends, and both kernels find the same. */
static void wrong_callbacks_harm_no_query(void** state) {
  (void)state;
  float values[] = {NAN, INFINITY, -INFINITY, 1e30f, -1e30f, 0, -0.0f, 50};
  synthetic_source source = synthetic_create(4, 1, 2, 9);
  const scree_field_desc field_desc = {.seed = 3, .cell_size = 0.8};
  scree_field* field;
  heard h = {0, ""};
  assert_int_equal(scree_rt_field_create_from_source(&field_desc, &source.source, NULL, &field), SCREE_OK);
  for (int round = 0; round < 160; ++round) {
    scree_shape callback = wrong_callback(round % 16 < 8 ? constant : steep_ball, &values[round % 8]);
    scree_support* s = combined((scree_shape_kind)(SCREE_SHAPE_UNION + round / 16 % 5), round >= 80, &callback, &h);
    for (uint32_t flags = 0; flags < 2; ++flags) {
      const scree_query_desc d = {.field = field, .support = s, .flags = flags};
      found_rocks best = run_query(&d, QUERY_KERNEL_BEST), plain = run_query(&d, QUERY_KERNEL_PLAIN);
      assert_found_equal(&plain, &best);
      found_free(&best);
      found_free(&plain);
    }
    scree_support_destroy(s);
  }
  scree_field_destroy(field);
  synthetic_destroy(&source);
}

static void broken_bounds_are_told_in_debug_builds(void** state) {
  (void)state;
  float slope = 3;
  scree_shape callback = wrong_callback(steep_ball, &slope);
  float x[64], y[64], z[64], d[64];
  random_stream r = {8};
  for (int i = 0; i < 64; ++i) {
    x[i] = (float)random_in(&r, -3, 3);
    y[i] = (float)random_in(&r, -3, 3);
    z[i] = (float)random_in(&r, -3, 3);
  }
  for (int honest = 0; honest < 2; ++honest) {
    heard h = {0, ""};
    callback.callback.lipschitz = honest ? 3 : 2;
    scree_support* s = must_create(&(scree_support_desc){.shapes = &callback, .shape_count = 1, .log = {hear, &h}});
    scree_support_distance(s, x, y, z, d, 64);
#ifdef NDEBUG
    assert_int_equal(h.count, 0);
#else
    assert_int_equal(h.count, !honest);
    if (!honest) assert_non_null(strstr(h.last, "shape 0: the callback's distance at ("));
    if (!honest) assert_non_null(strstr(h.last, "its bound is 2"));
#endif
    scree_support_destroy(s);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(nothing_changes_outside_the_changed_bounds),
      cmocka_unit_test(changed_bounds_of_trees_built_otherwise_hold_both),
      cmocka_unit_test(moving_one_ball_of_many_touches_two_balls),
      cmocka_unit_test(equal_grids_are_shared_and_outlive_their_maker),
      cmocka_unit_test(grids_of_other_content_are_not_shared),
      cmocka_unit_test(reuse_does_not_skip_checks_of_what_is_new),
      cmocka_unit_test(threads_share_and_drop_grids_at_once),
      cmocka_unit_test(what_is_not_a_number_makes_no_rock_appear),
      cmocka_unit_test(wrong_callbacks_harm_no_query),
      cmocka_unit_test(broken_bounds_are_told_in_debug_builds),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
