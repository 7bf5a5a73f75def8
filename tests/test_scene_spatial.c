/* Rays, overlaps and near rocks against their plain twins: every rock of the scene, one after the other. Which rocks a scene has is
 * held against a twin of its own by test_scene_query. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <scree/threads.h>

#include "failing_allocator.h"
#include "random_support.h"
#include "rounds.h"
#include "scene_spatial.h"

enum { MAX_LAYERS = 4, IMAGE = 6, TARGETS = 32 };

/* A random scene and everything it points at. */
typedef struct world {
  uint32_t count;
  synthetic_source sources[MAX_LAYERS];
  scree_field* fields[MAX_LAYERS];
  random_support* shapes[MAX_LAYERS];
  scree_support* supports[MAX_LAYERS];
  scree_filter filters[MAX_LAYERS];
  float image[IMAGE * IMAGE];
  scree_scene* scene;
  scree_edits* edits;
  scree_scratch* scratch;
  double middle[3];
  double targets[TARGETS][3]; /* places of some rocks */
} world;

static void make_some_world(world* w, random_stream* r, uint32_t layers, double far) {
  memset(w, 0, sizeof *w);
  w->count = layers;
  scree_layer given[MAX_LAYERS] = {{0}};
  for (int a = 0; a < 3; ++a) w->middle[a] = random_in(r, -40, 40) + far * (a - 1);
  for (int i = 0; i < IMAGE * IMAGE; ++i) w->image[i] = (float)random_in(r, 0, 1);
  for (uint32_t k = 0; k < layers; ++k) {
    const uint32_t cells = 3 + random_below(r, 3), fewest = random_below(r, 3) > 0, most = random_below(r, 2) ? 1 : 3;
    w->sources[k] = synthetic_create(cells, fewest, most, random_bits(r));
    synthetic_add_hulls(&w->sources[k], random_bits(r), 2, 0);
    scree_field_desc field = {.seed = random_bits(r)};
    field.cell_size = random_in(r, 0.5, 1.5);
    for (int a = 0; a < 3; ++a) field.origin[a] = w->middle[a] + random_in(r, -50, 50);
    assert_int_equal(scree_rt_field_create_from_source(&field, &w->sources[k].source, NULL, &w->fields[k]), SCREE_OK);
    w->shapes[k] = malloc(sizeof *w->shapes[k]);
    random_tree(w->shapes[k], r, 1 + random_below(r, 4), 6);
    for (int a = 0; a < 3; ++a) w->shapes[k]->desc.origin[a] = w->middle[a] + random_in(r, -4, 4);
    scree_error error;
    if (scree_support_create(&w->shapes[k]->desc, NULL, &w->supports[k], &error) != SCREE_OK) fail_msg("%s", error.message);
    given[k] = (scree_layer){.field = w->fields[k], .support = w->supports[k], .key = (uint16_t)(50 - 7 * k)};
    if (random_below(r, 3) == 0) given[k].threshold = (float)random_in(r, 0.05, 0.95);
    if (random_below(r, 3) == 0) given[k].shell_depth = (float)random_in(r, 0.3, 2);
    if (random_below(r, 3) == 0) given[k].density = (float)random_in(r, 0.02, 1);
    if (random_below(r, 3) == 0) {
      w->filters[k] = (scree_filter){SCREE_FILTER_MASK, false, 0, 0, 0, w->image, IMAGE, IMAGE, 2, {0, 0, 0}};
      memcpy(w->filters[k].centre, w->middle, sizeof w->middle);
      given[k].filters = &w->filters[k];
      given[k].filter_count = 1;
    }
  }
  scree_error error;
  if (scree_scene_create(&(scree_scene_desc){given, layers}, NULL, &w->scene, &error) != SCREE_OK) fail_msg("%s", error.message);
  assert_int_equal(scree_edits_create(NULL, &w->edits), SCREE_OK);
  assert_int_equal(scree_scratch_create(NULL, &w->scratch), SCREE_OK);
}

static void destroy_world(world* w) {
  scree_scene_destroy(w->scene);
  scree_edits_destroy(w->edits);
  scree_scratch_destroy(w->scratch);
  for (uint32_t k = 0; k < w->count; ++k) {
    scree_field_destroy(w->fields[k]);
    scree_support_destroy(w->supports[k]);
    synthetic_destroy(&w->sources[k]);
    free(w->shapes[k]);
  }
}

/* All rocks of the scene, in the order of layer key and id; edits that remove are heeded. */
typedef struct all_rocks {
  scree_rock* rocks;
  uint64_t count;
} all_rocks;

static int by_id(const void* a, const void* b) {
  return scree_rt_edits_compare(&((const scree_rock*)a)->id, &((const scree_rock*)b)->id);
}

static all_rocks find_all(const world* w, const double origin[3]) {
  scree_scene_query_desc d = {.scene = w->scene, .edits = w->edits};
  memcpy(d.origin, origin, sizeof d.origin);
  all_rocks all = {NULL, 0};
  assert_int_equal(scree_scene_count(&d, w->scratch, &all.count), SCREE_OK);
  all.rocks = malloc((size_t)(all.count + 1) * sizeof *all.rocks);
  assert_int_equal(scree_scene_fill(&d, w->scratch, all.rocks, all.count, &all.count), SCREE_OK);
  qsort(all.rocks, (size_t)all.count, sizeof *all.rocks, by_id);
  return all;
}

static void choose_targets(world* w, random_stream* r) {
  all_rocks all = find_all(w, w->middle);
  for (int i = 0; i < TARGETS && all.count > 0; ++i) {
    const scree_rock* rock = &all.rocks[random_bits(r) % all.count];
    for (int a = 0; a < 3; ++a) w->targets[i][a] = w->middle[a] + (double)rock->position[a];
  }
  free(all.rocks);
}

/* One with rocks enough to find something. */
static void make_world(world* w, random_stream* r, uint32_t layers, double far) {
  for (;;) {
    make_some_world(w, r, layers, far);
    const scree_scene_query_desc d = {.scene = w->scene};
    uint64_t count;
    assert_int_equal(scree_scene_count(&d, w->scratch, &count), SCREE_OK);
    if (count >= 100 && count < 3000) break;
    destroy_world(w);
  }
  choose_targets(w, r);
}

static const scene_layer* layer_of(const world* w, const scree_rock* rock) {
  return &w->scene->layers[scree_scene_layer_of(w->scene, rock->id.layer)];
}

static void hull_of(const world* w, const scree_rock* rock, const double from[3], spatial_hull* hull) {
  const scene_layer* layer = layer_of(w, rock);
  const spatial_place place = scree_rt_spatial_place(layer, rock, from);
  assert_true(scree_rt_spatial_hull(layer, rock->asset, place.home, hull));
}

/* --- rays ------------------------------------------------------------------------------------------------------------------- */

typedef struct twin_hit {
  bool found;
  scree_rock rock;
  double t, normal[3];
} twin_hit;

static twin_hit twin_ray(const world* w, const all_rocks* all, const double start[3], const double along[3], double reach) {
  twin_hit best = {.t = (double)INFINITY};
  for (uint64_t i = 0; i < all->count; ++i) {
    spatial_hull hull;
    double t, normal[3];
    hull_of(w, &all->rocks[i], start, &hull);
    if (!scree_rt_convex_ray(&hull.hull, (const double[3]){0, 0, 0}, along, reach, &t, normal) || !(t < best.t)) continue;
    best = (twin_hit){true, all->rocks[i], t, {normal[0], normal[1], normal[2]}};
  }
  return best;
}

static void random_ray(const world* w, random_stream* r, double start[3], double direction[3]) {
  const double away = random_below(r, 8) == 0 ? 1e4 : random_below(r, 2) ? 30 : 6;
  for (int a = 0; a < 3; ++a) {
    start[a] = w->middle[a] + random_in(r, -away, away);
    direction[a] = w->middle[a] + random_in(r, -5, 5) - start[a];
  }
  const double* target = w->targets[random_below(r, TARGETS)];
  if (random_below(r, 2))
    for (int a = 0; a < 3; ++a) direction[a] = target[a] + random_in(r, -0.3, 0.3) - start[a];
  if (random_below(r, 8) == 0) direction[random_below(r, 3)] = 0;
  if (random_below(r, 8) == 0)
    for (int a = 0, keep = (int)random_below(r, 3); a < 3; ++a) direction[a] = a == keep ? 1 : 0;
}

/* The direction as the library has it. */
static void make_unit(const double direction[3], double along[3]) {
  double largest = fmax(fmax(fabs(direction[0]), fabs(direction[1])), fabs(direction[2])), length2 = 0;
  for (int a = 0; a < 3; ++a) {
    along[a] = direction[a] / largest;
    length2 += along[a] * along[a];
  }
  for (int a = 0; a < 3; ++a) along[a] /= sqrt(length2);
}

/* Returns whether something was hit. */
static bool check_ray(const world* w, const double start[3], const double direction[3], double reach) {
  all_rocks all = find_all(w, start);
  double along[3];
  make_unit(direction, along);
  const twin_hit expected = twin_ray(w, &all, start, along, reach);
  bool found;
  scree_hit hit;
  assert_int_equal(scree_scene_ray_cast(w->scene, w->edits, w->scratch, start, direction, reach, &found, &hit), SCREE_OK);
  if (found != expected.found) fail_msg("found %d, expected %d at %.17g of %g", found, expected.found, expected.t, reach);
  if (found) {
    if (hit.distance != expected.t) fail_msg("at %.17g, expected %.17g", hit.distance, expected.t);
    assert_memory_equal(&hit.rock, &expected.rock, sizeof hit.rock);
    double length2 = 0;
    for (int a = 0; a < 3; ++a) {
      assert_true(hit.normal[a] == (float)expected.normal[a]);
      assert_true(hit.point[a] == (float)(along[a] * expected.t));
      length2 += (double)hit.normal[a] * (double)hit.normal[a];
    }
    assert_true(fabs(length2 - 1) < 1e-5);
  }
  free(all.rocks);
  return found;
}

static void random_edits(world* w, random_stream* r) {
  all_rocks all = find_all(w, w->middle);
  for (int i = 0; i < 100 && all.count > 0; ++i) {
    const scree_id* id = &all.rocks[random_bits(r) % all.count].id;
    assert_int_equal(scree_edits_set(w->edits, id, (scree_edit)(1 + random_below(r, 2))), SCREE_OK);
  }
  free(all.rocks);
}

static void rays_hit_the_nearest_of_all_rocks(void** state) {
  (void)state;
  random_stream r = {1};
  int hits = 0, rays = 0;
  for (int round = 0; round < ROUNDS(60, 5); ++round) {
    world w;
    make_world(&w, &r, 1 + random_below(&r, 3), 0);
    for (int i = 0; i < 15; ++i, ++rays) {
      if (i == 8) random_edits(&w, &r);
      double start[3], direction[3];
      random_ray(&w, &r, start, direction);
      const double reach = random_below(&r, 3) ? 1e6 : random_in(&r, 0.1, 20);
      hits += check_ray(&w, start, direction, reach);
    }
    destroy_world(&w);
  }
  if (hits < rays / 5 || hits > rays * 9 / 10) fail_msg("%d of %d rays hit", hits, rays);
}

static void rays_are_right_far_from_the_origin(void** state) {
  (void)state;
  random_stream r = {2};
  int hits = 0;
  for (int round = 0; round < ROUNDS(20, 5); ++round) {
    world w;
    make_world(&w, &r, 2, 1e7);
    for (int i = 0; i < 10; ++i) {
      double start[3], direction[3];
      random_ray(&w, &r, start, direction);
      hits += check_ray(&w, start, direction, 1e6);
    }
    destroy_world(&w);
  }
  assert_true(hits > ROUNDS(40, 5));
}

static void a_ray_that_starts_in_a_rock_hits_it_at_once(void** state) {
  (void)state;
  random_stream r = {3};
  int tested = 0;
  for (int round = 0; round < ROUNDS(20, 5); ++round) {
    world w;
    make_world(&w, &r, 2, 0);
    all_rocks all = find_all(&w, w.middle);
    for (int i = 0; i < 5 && all.count > 0; ++i, ++tested) {
      const scree_rock* rock = &all.rocks[random_bits(&r) % all.count];
      spatial_hull hull;
      hull_of(&w, rock, w.middle, &hull);
      double start[3], direction[3], along[3];
      for (int a = 0; a < 3; ++a) { /* the middle of its hull's points */
        const float* axis = a == 0 ? hull.x : a == 1 ? hull.y : hull.z;
        double sum = 0;
        for (uint32_t k = 0; k < hull.hull.count; ++k) sum += (double)axis[k];
        start[a] = w.middle[a] + hull.hull.at[a] + sum / hull.hull.count * hull.hull.scale;
        direction[a] = random_in(&r, -1, 1);
      }
      make_unit(direction, along);
      bool found;
      scree_hit hit;
      assert_int_equal(scree_scene_ray_cast(w.scene, NULL, w.scratch, start, direction, 0.01, &found, &hit), SCREE_OK);
      assert_true(found);
      assert_true(hit.distance == 0);
      for (int a = 0; a < 3; ++a) assert_true(fabs((double)hit.normal[a] + along[a]) < 1e-6);
      check_ray(&w, start, direction, 10);
    }
    free(all.rocks);
    destroy_world(&w);
  }
  assert_true(tested > ROUNDS(50, 5));
}

/* A hollow ball, rays from within: the way through the empty core is jumped. */
static void rays_from_an_empty_core_hit_the_shell(void** state) {
  (void)state;
  random_stream r = {12};
  world w;
  make_world(&w, &r, 1, 0);
  const double h = w.fields[0]->cell_size;
  const scree_shape ball = {.kind = SCREE_SHAPE_SPHERE, .sphere = {.radius = (float)(12 * h)}};
  scree_support* support;
  scree_support_desc desc = {.shapes = &ball, .shape_count = 1};
  memcpy(desc.origin, w.middle, sizeof desc.origin);
  assert_int_equal(scree_support_create(&desc, NULL, &support, NULL), SCREE_OK);
  const scree_layer layer = {.field = w.fields[0], .support = support, .shell_depth = (float)(1.5 * h)};
  scree_scene_destroy(w.scene);
  assert_int_equal(scree_scene_create(&(scree_scene_desc){&layer, 1}, NULL, &w.scene, NULL), SCREE_OK);
  int hits = 0;
  for (int i = 0; i < 60; ++i) {
    double start[3], direction[3];
    for (int a = 0; a < 3; ++a) {
      start[a] = w.middle[a] + random_in(&r, -4, 4) * h;
      direction[a] = random_in(&r, -1, 1);
    }
    hits += check_ray(&w, start, direction, 100);
  }
  assert_true(hits > 20);
  scree_scene_destroy(w.scene);
  w.scene = NULL;
  scree_support_destroy(support);
  destroy_world(&w);
}

static void removed_rocks_are_not_hit_and_hidden_ones_are(void** state) {
  (void)state;
  random_stream r = {4};
  int removed = 0;
  for (int round = 0; round < ROUNDS(40, 5); ++round) {
    world w;
    make_world(&w, &r, 2, 0);
    double start[3], direction[3], last = 0;
    random_ray(&w, &r, start, direction);
    for (int i = 0; i < 100; ++i) {
      bool found, still;
      scree_hit hit, hidden;
      assert_int_equal(scree_scene_ray_cast(w.scene, w.edits, w.scratch, start, direction, 1e6, &found, &hit), SCREE_OK);
      if (!found) break;
      assert_true(hit.distance >= last);
      last = hit.distance;
      assert_int_equal(scree_edits_get(w.edits, &hit.rock.id), SCREE_EDIT_NONE);
      assert_int_equal(scree_edits_set(w.edits, &hit.rock.id, SCREE_EDIT_HIDE), SCREE_OK);
      assert_int_equal(scree_scene_ray_cast(w.scene, w.edits, w.scratch, start, direction, 1e6, &still, &hidden), SCREE_OK);
      assert_true(still);
      assert_memory_equal(&hit.rock, &hidden.rock, sizeof hit.rock);
      assert_int_equal(scree_edits_set(w.edits, &hit.rock.id, SCREE_EDIT_REMOVE), SCREE_OK);
      ++removed;
    }
    check_ray(&w, start, direction, 1e6);
    destroy_world(&w);
  }
  if (removed < ROUNDS(40, 5)) fail_msg("%d removed", removed);
}

static void the_length_of_the_direction_does_not_matter(void** state) {
  (void)state;
  random_stream r = {5};
  world w;
  make_world(&w, &r, 2, 0);
  for (int i = 0; i < 20; ++i) {
    double start[3], direction[3], scaled[3];
    random_ray(&w, &r, start, direction);
    bool found, again;
    scree_hit hit = {.distance = 0}, other = {.distance = 0};
    assert_int_equal(scree_scene_ray_cast(w.scene, NULL, w.scratch, start, direction, 1e6, &found, &hit), SCREE_OK);
    for (int e = -900; e <= 900; e += 300) {
      for (int a = 0; a < 3; ++a) scaled[a] = ldexp(direction[a], e);
      assert_int_equal(scree_scene_ray_cast(w.scene, NULL, w.scratch, start, scaled, 1e6, &again, &other), SCREE_OK);
      assert_int_equal(found, again);
      assert_true(hit.distance == other.distance);
    }
  }
  destroy_world(&w);
}

/* --- overlaps and near rocks ------------------------------------------------------------------------------------------------ */

static void check_found(const scree_rock* expected, uint64_t expected_count, const scree_rock* found, uint64_t count) {
  assert_int_equal(count, expected_count);
  if (count > 0) assert_memory_equal(expected, found, (size_t)count * sizeof *found);
}

static uint64_t check_overlap(const world* w, const scree_convex* shape) {
  all_rocks all = find_all(w, shape->origin);
  spatial_hull own;
  for (uint32_t i = 0; i < shape->point_count; ++i) {
    own.x[i] = shape->points[3 * i];
    own.y[i] = shape->points[3 * i + 1];
    own.z[i] = shape->points[3 * i + 2];
  }
  own.hull = (convex_hull){own.x, own.y, own.z, shape->point_count, 1, {0, 0, 0}, (double)shape->radius};
  uint64_t expected = 0, count = 0, cut = 0;
  for (uint64_t i = 0; i < all.count; ++i) {
    spatial_hull hull;
    hull_of(w, &all.rocks[i], shape->origin, &hull);
    if (scree_rt_convex_meet(&hull.hull, &own.hull)) all.rocks[expected++] = all.rocks[i];
  }
  scree_rock* rocks = malloc((size_t)(expected + 1) * sizeof *rocks);
  assert_int_equal(scree_scene_overlap(w->scene, w->edits, w->scratch, shape, rocks, expected, &count), SCREE_OK);
  check_found(all.rocks, expected, rocks, count);
  if (expected > 0) { /* a buffer that is too small gets the first ones */
    assert_int_equal(scree_scene_overlap(w->scene, w->edits, w->scratch, shape, rocks, expected - 1, &cut), SCREE_ERROR_CAPACITY);
    check_found(all.rocks, expected, all.rocks, cut);
    check_found(all.rocks, expected - 1, rocks, expected - 1);
  }
  free(rocks);
  free(all.rocks);
  return expected;
}

static void overlaps_are_those_of_all_rocks(void** state) {
  (void)state;
  random_stream r = {6};
  int some = 0, none = 0;
  for (int round = 0; round < ROUNDS(60, 5); ++round) {
    world w;
    make_world(&w, &r, 1 + random_below(&r, 3), round % 4 == 0 ? 1e7 : 0);
    for (int i = 0; i < 10; ++i) {
      if (i == 5) random_edits(&w, &r);
      float points[3 * CONVEX_MAX_POINTS];
      const double size = random_below(&r, 2) ? 0.3 : 4;
      scree_convex shape = {.points = points, .point_count = 1 + random_below(&r, random_below(&r, 2) ? 2 : CONVEX_MAX_POINTS)};
      for (int a = 0; a < 3; ++a) shape.origin[a] = w.middle[a] + random_in(&r, -6, 6);
      for (uint32_t k = 0; k < 3 * shape.point_count; ++k) points[k] = (float)random_in(&r, -size, size);
      if (random_below(&r, 2)) shape.radius = (float)random_in(&r, 0, size);
      const uint64_t found = check_overlap(&w, &shape);
      some += found > 0;
      none += found == 0;
    }
    destroy_world(&w);
  }
  assert_true(some > ROUNDS(100, 5) && none > ROUNDS(50, 5));
}

static void near_rocks_are_those_of_all_rocks(void** state) {
  (void)state;
  random_stream r = {7};
  int some = 0;
  for (int round = 0; round < ROUNDS(60, 5); ++round) {
    world w;
    make_world(&w, &r, 1 + random_below(&r, 3), round % 4 == 0 ? 1e7 : 0);
    if (round % 2) random_edits(&w, &r);
    for (int i = 0; i < 6; ++i) {
      static const float zero[1] = {0};
      double points[3 * 40], origin[3], spread = random_below(&r, 2) ? 1 : 8;
      const uint32_t point_count = random_below(&r, 41);
      const double radius = random_below(&r, 4) == 0 ? 0 : random_in(&r, 0, 2);
      for (uint32_t k = 0; k < 3 * point_count; ++k) points[k] = w.middle[k % 3] + random_in(&r, -spread, spread);
      for (int a = 0; a < 3; ++a) origin[a] = w.middle[a] + random_in(&r, -100, 100);
      all_rocks all = find_all(&w, origin);
      uint64_t expected = 0, count = 0;
      for (uint64_t k = 0; k < all.count; ++k) {
        bool near = false;
        for (uint32_t p = 0; p < point_count && !near; ++p) {
          spatial_hull hull;
          hull_of(&w, &all.rocks[k], points + 3 * p, &hull);
          const convex_hull ball = {zero, zero, zero, 1, 1, {0, 0, 0}, radius};
          near = scree_rt_convex_meet(&hull.hull, &ball);
        }
        if (near) all.rocks[expected++] = all.rocks[k];
      }
      scree_rock* rocks = malloc((size_t)(expected + 1) * sizeof *rocks);
      assert_int_equal(scree_scene_near(w.scene, w.edits, w.scratch, points, point_count, radius, origin, rocks, expected, &count),
                       SCREE_OK);
      check_found(all.rocks, expected, rocks, count);
      if (expected > 0)
        assert_int_equal(scree_scene_near(w.scene, w.edits, w.scratch, points, point_count, radius, origin, NULL, 0, &count),
                         SCREE_ERROR_CAPACITY);
      some += expected > 0;
      free(rocks);
      free(all.rocks);
    }
    destroy_world(&w);
  }
  assert_true(some > ROUNDS(100, 5));
}

static void hulls_are_those_of_the_assets_in_metres(void** state) {
  (void)state;
  random_stream r = {8};
  world w;
  make_world(&w, &r, 2, 0);
  for (uint32_t k = 0; k < 2; ++k) {
    const field_source* s = &w.sources[k].source;
    assert_int_equal(w.fields[k]->lattice_per_cell, s->lattice_per_cell);
    for (uint32_t asset = 0; asset < s->asset_count; asset += 97) {
      float xyz[3 * CONVEX_MAX_POINTS];
      uint32_t count = 0;
      const uint32_t first = s->hull_first[asset], expected = s->hull_first[asset + 1] - first;
      assert_int_equal(scree_scene_hull(w.scene, k, asset, NULL, 0, &count), SCREE_ERROR_CAPACITY);
      assert_int_equal(count, expected);
      assert_int_equal(scree_scene_hull(w.scene, k, asset, xyz, count, &count), SCREE_OK);
      for (uint32_t i = 0; i < 3 * count; ++i) {
        const double metres = s->hulls[3 * first + i] * w.fields[k]->cell_size / s->lattice_per_cell;
        assert_true(fabs((double)xyz[i] - metres) <= fabs(metres) * 1e-6);
      }
    }
    uint32_t count = 1;
    assert_int_equal(scree_scene_hull(w.scene, k, s->asset_count, NULL, 0, &count), SCREE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(count, 0);
    assert_int_equal(scree_scene_hull(w.scene, 2, 0, NULL, 0, &count), SCREE_ERROR_INVALID_ARGUMENT);
  }
  destroy_world(&w);
}

/* --- what every question promises ------------------------------------------------------------------------------------------- */

static void wrong_arguments_are_refused(void** state) {
  (void)state;
  random_stream r = {9};
  world w;
  make_world(&w, &r, 1, 0);
  const double zero[3] = {0, 0, 0}, up[3] = {0, 1, 0}, nan3[3] = {0, (double)NAN, 0}, inf3[3] = {0, (double)INFINITY, 0};
  const double inf = (double)INFINITY;
  bool found = true;
  scree_hit hit;
  const scree_result bad = SCREE_ERROR_INVALID_ARGUMENT;
  assert_int_equal(scree_scene_ray_cast(NULL, NULL, w.scratch, zero, up, 1, &found, &hit), bad);
  assert_false(found);
  assert_int_equal(scree_scene_ray_cast(w.scene, NULL, NULL, zero, up, 1, &found, &hit), bad);
  assert_int_equal(scree_scene_ray_cast(w.scene, NULL, w.scratch, zero, zero, 1, &found, &hit), bad);
  assert_int_equal(scree_scene_ray_cast(w.scene, NULL, w.scratch, zero, nan3, 1, &found, &hit), bad);
  assert_int_equal(scree_scene_ray_cast(w.scene, NULL, w.scratch, inf3, up, 1, &found, &hit), bad);
  assert_int_equal(scree_scene_ray_cast(w.scene, NULL, w.scratch, zero, up, 0, &found, &hit), bad);
  assert_int_equal(scree_scene_ray_cast(w.scene, NULL, w.scratch, zero, up, inf, &found, &hit), bad);
  assert_int_equal(scree_scene_ray_cast(w.scene, NULL, w.scratch, zero, up, 1, NULL, &hit), bad);
  assert_int_equal(scree_scene_ray_cast(w.scene, NULL, w.scratch, zero, up, 1, &found, NULL), bad);

  float points[3 * 65] = {0};
  uint64_t count = 1;
  scree_convex shape = {.points = points, .point_count = 1};
  assert_int_equal(scree_scene_overlap(w.scene, NULL, w.scratch, &shape, NULL, 1, &count), bad);
  assert_int_equal(count, 0);
  assert_int_equal(scree_scene_overlap(w.scene, NULL, w.scratch, NULL, NULL, 0, &count), bad);
  shape.point_count = 65;
  assert_int_equal(scree_scene_overlap(w.scene, NULL, w.scratch, &shape, NULL, 0, &count), bad);
  shape.point_count = 0;
  assert_int_equal(scree_scene_overlap(w.scene, NULL, w.scratch, &shape, NULL, 0, &count), bad);
  shape.point_count = 1;
  shape.radius = -1;
  assert_int_equal(scree_scene_overlap(w.scene, NULL, w.scratch, &shape, NULL, 0, &count), bad);
  shape.radius = 0;
  points[1] = NAN;
  assert_int_equal(scree_scene_overlap(w.scene, NULL, w.scratch, &shape, NULL, 0, &count), bad);

  assert_int_equal(scree_scene_near(w.scene, NULL, w.scratch, NULL, 1, 1, zero, NULL, 0, &count), bad);
  assert_int_equal(scree_scene_near(w.scene, NULL, w.scratch, nan3, 1, 1, zero, NULL, 0, &count), bad);
  assert_int_equal(scree_scene_near(w.scene, NULL, w.scratch, zero, 1, -1, zero, NULL, 0, &count), bad);
  assert_int_equal(scree_scene_near(w.scene, NULL, w.scratch, zero, 1, inf, zero, NULL, 0, &count), bad);
  assert_int_equal(scree_scene_near(w.scene, NULL, w.scratch, zero, 1, 1, nan3, NULL, 0, &count), bad);
  assert_int_equal(scree_scene_near(w.scene, NULL, w.scratch, NULL, 0, 1, zero, NULL, 0, &count), SCREE_OK);
  destroy_world(&w);
}

typedef struct answers {
  scree_result ray, overlap, near;
  bool found;
  scree_hit hit;
  uint64_t overlapping, nearby;
} answers;

static answers ask_everything(const world* w, scree_scratch* scratch) {
  answers a;
  memset(&a, 0, sizeof a);
  double start[3], direction[3], points[60];
  for (int i = 0; i < 3; ++i) {
    start[i] = w->middle[i] + 40 * (i - 1);
    direction[i] = w->middle[i] - start[i];
  }
  for (int i = 0; i < 60; ++i) points[i] = w->middle[i % 3] + (i / 3 % 5 - 2) * (i % 3 == 1 ? 1.5 : 1);
  static const float ball[3] = {0, 0, 0};
  scree_convex shape = {.points = ball, .point_count = 1, .radius = 4};
  memcpy(shape.origin, w->middle, sizeof shape.origin);
  scree_rock* rocks = malloc(20000 * sizeof *rocks);
  assert_non_null(rocks);
  a.ray = scree_scene_ray_cast(w->scene, w->edits, scratch, start, direction, 1e5, &a.found, &a.hit);
  a.overlap = scree_scene_overlap(w->scene, w->edits, scratch, &shape, rocks, 20000, &a.overlapping);
  a.near = scree_scene_near(w->scene, w->edits, scratch, points, 20, 1.5, w->middle, rocks, 20000, &a.nearby);
  free(rocks);
  return a;
}

static void failing_allocations_are_reported_and_lose_nothing(void** state) {
  (void)state;
  random_stream r = {10};
  world w;
  make_world(&w, &r, 3, 0);
  random_edits(&w, &r);
  const answers good = ask_everything(&w, w.scratch);
  assert_true(good.overlapping > 20 && good.nearby > 20);
  for (int32_t n = 0;; ++n) {
    failing_allocator memory = {.fail_at = n};
    const scree_allocator allocator = failing_allocator_of(&memory);
    scree_scratch* scratch;
    if (scree_scratch_create(&allocator, &scratch) != SCREE_OK) continue;
    const answers first = ask_everything(&w, scratch);
    const int failures = (first.ray != SCREE_OK) + (first.overlap != SCREE_OK) + (first.near != SCREE_OK);
    assert_int_equal(failures, memory.failed);
    if (first.ray == SCREE_OK) assert_true(first.hit.distance == good.hit.distance);
    const answers again = ask_everything(&w, scratch); /* the same scratch goes on */
    assert_int_equal(again.overlapping, good.overlapping);
    assert_int_equal(again.nearby, good.nearby);
    assert_true(again.found == good.found && again.hit.distance == good.hit.distance);
    scree_scratch_destroy(scratch);
    assert_int_equal(memory.live, 0);
    if (!memory.failed) break;
    assert_true(n < 200);
  }
  destroy_world(&w);
}

static void nothing_allocates_once_the_scratch_has_grown(void** state) {
  (void)state;
  random_stream r = {11};
  world w;
  make_world(&w, &r, 3, 0);
  failing_allocator memory = {.fail_at = -1};
  const scree_allocator allocator = failing_allocator_of(&memory);
  scree_scratch* scratch;
  assert_int_equal(scree_scratch_create(&allocator, &scratch), SCREE_OK);
  ask_everything(&w, scratch);
  const int32_t calls = memory.calls;
  for (int i = 0; i < 5; ++i) ask_everything(&w, scratch);
  assert_int_equal(memory.calls, calls);
  scree_scratch_destroy(scratch);
  destroy_world(&w);
}

typedef struct shared_question {
  const world* w;
  scree_scratch* scratch[4];
  answers expected;
  uint32_t wrong[4];
} shared_question;

static void ask_in_thread(void* context, uint32_t index, uint32_t worker) {
  (void)index;
  shared_question* q = context;
  const answers a = ask_everything(q->w, q->scratch[worker]);
  const answers* e = &q->expected;
  const bool same = a.ray == e->ray && a.overlap == e->overlap && a.near == e->near && a.found == e->found &&
                    memcmp(&a.hit, &e->hit, sizeof a.hit) == 0 && a.overlapping == e->overlapping && a.nearby == e->nearby;
  q->wrong[worker] += !same;
}

static void threads_share_a_scene_and_its_edits(void** state) {
  (void)state;
  scree_threads* threads;
  if (scree_threads_create(3, NULL, &threads) != SCREE_OK) skip();
  const scree_jobs jobs = scree_threads_jobs(threads);
  assert_true(jobs.worker_count <= 4);
  random_stream r = {13};
  world w;
  make_world(&w, &r, 3, 0);
  random_edits(&w, &r);
  shared_question q = {.w = &w, .expected = ask_everything(&w, w.scratch)};
  for (int i = 0; i < 4; ++i) assert_int_equal(scree_scratch_create(NULL, &q.scratch[i]), SCREE_OK);
  jobs.parallel_for(jobs.user, 20, ask_in_thread, &q);
  for (int i = 0; i < 4; ++i) {
    assert_int_equal(q.wrong[i], 0);
    scree_scratch_destroy(q.scratch[i]);
  }
  scree_threads_destroy(threads);
  destroy_world(&w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rays_hit_the_nearest_of_all_rocks),
      cmocka_unit_test(rays_are_right_far_from_the_origin),
      cmocka_unit_test(a_ray_that_starts_in_a_rock_hits_it_at_once),
      cmocka_unit_test(rays_from_an_empty_core_hit_the_shell),
      cmocka_unit_test(removed_rocks_are_not_hit_and_hidden_ones_are),
      cmocka_unit_test(the_length_of_the_direction_does_not_matter),
      cmocka_unit_test(overlaps_are_those_of_all_rocks),
      cmocka_unit_test(near_rocks_are_those_of_all_rocks),
      cmocka_unit_test(hulls_are_those_of_the_assets_in_metres),
      cmocka_unit_test(wrong_arguments_are_refused),
      cmocka_unit_test(failing_allocations_are_reported_and_lose_nothing),
      cmocka_unit_test(nothing_allocates_once_the_scratch_has_grown),
      cmocka_unit_test(threads_share_a_scene_and_its_edits),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
