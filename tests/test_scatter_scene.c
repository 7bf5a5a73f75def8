/* Scenes with scatters against their plain twin: which instances exist, which rocks make room for them, and what meets them. */
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
#include "must_create.h"
#include "random_world.h"

static const double REACH = 24; /* metres from the middle: nothing farther matters to what is asked */

static scree_scene_query_desc everything(const world* w) {
  scree_scene_query_desc all = {.scene = w->scene};
  for (int a = 0; a < 3; ++a) {
    all.origin[a] = w->middle[a];
    all.min[a] = w->middle[a] - 9;
    all.max[a] = w->middle[a] + 9;
  }
  return all;
}

static scene_twin twin_of(const world* w, const double origin[3]) {
  return twin_scene(&w->desc, w->source_of, w->scatter_of, w->edit_list, w->edit_count, w->middle, REACH, origin);
}

static void edit_some(world* w, random_stream* r, scree_scratch* scratch) {
  scree_scene_query_desc all = everything(w);
  scene_rocks rocks = ask_scene(&all, scratch);
  make_edits(w, r, &rocks);
  scene_rocks_free(&rocks);
}

static void scenes_with_scatters_equal_their_plain_twin(void** state) {
  (void)state;
  scree_scratch* scratch = make_scratch();
  uint64_t instances = 0, dropped[2] = {0, 0};
  for (uint64_t round = 0; round < 24; ++round) {
    random_stream r = {round};
    world w;
    make_scatter_world(&w, &r, 1 + random_below(&r, 3));
    if (round % 2) edit_some(&w, &r, scratch);
    scree_scene_query_desc d = random_question(&w, &r);
    d.edits = w.edits;
    scene_twin twin = twin_of(&w, d.origin);
    for (uint32_t k = 0; k < w.count; ++k)
      for (uint64_t i = 0; i < twin.layers[k].count; ++i) {
        instances += twin.layers[k].models != NULL;
        dropped[twin.layers[k].models != NULL] += twin.layers[k].rocks[i].dropped;
      }
    for (int visible = 0; visible < 2; ++visible) {
      d.flags = visible ? SCREE_SCENE_VISIBLE : 0;
      scene_rocks expected = twin_answer(&twin, &d), found = ask_scene(&d, scratch);
      assert_scene_rocks_equal(&expected, &found);
      scene_rocks_free(&expected);
      scene_rocks_free(&found);
    }
    twin_scene_free(&twin);
    destroy_world(&w);
  }
  print_message("%llu instances, of which %llu gave way; %llu rocks did\n", (unsigned long long)instances,
                (unsigned long long)dropped[1], (unsigned long long)dropped[0]);
  assert_true(instances > 700 && dropped[0] > 300 && dropped[1] > 40);
  scree_scratch_destroy(scratch);
}

/* What blocks deliver together is what all of them at once deliver, whatever is asked before. */
static void blocks_of_scatters_have_the_instances_of_the_whole(void** state) {
  (void)state;
  scree_scratch* scratch = make_scratch();
  for (uint64_t round = 0; round < 8; ++round) {
    random_stream r = {100 + round};
    world w;
    make_scatter_world(&w, &r, 3);
    for (uint32_t k = 0; k < w.count; ++k) {
      if (w.scatters[k] == NULL) continue;
      const double side = scree_scatter_tile_width(w.scatters[k]->scatter);
      const double* origin = w.scatters[k]->desc.origin;
      scree_scene_query_desc d = {.scene = w.scene, .layers = UINT64_C(1) << k};
      int32_t low[3], high[3];
      memcpy(d.origin, w.middle, sizeof d.origin);
      for (int a = 0; a < 3; ++a) {
        low[a] = (int32_t)floor((w.middle[a] - 12 - origin[a]) / side);
        high[a] = (int32_t)floor((w.middle[a] + 12 - origin[a]) / side) + 1;
        d.min[a] = origin[a] + low[a] * side;
        d.max[a] = origin[a] + high[a] * side;
      }
      scene_rocks whole = ask_scene(&d, scratch), sum = {NULL, 0};
      int32_t c[3];
      for (c[0] = high[0] - 1; c[0] >= low[0]; --c[0])
        for (c[1] = low[1]; c[1] < high[1]; ++c[1])
          for (c[2] = low[2]; c[2] < high[2]; ++c[2]) {
            const int32_t end[3] = {c[0] + 1, c[1] + 1, c[2] + 1};
            const scree_rock* rocks;
            uint64_t count;
            assert_int_equal(scree_rt_scene_block(w.scene, NULL, k, c, end, d.origin, round % 2, scratch, &rocks, &count),
                             SCREE_OK);
            scene_rocks_join(&sum, rocks, count);
            double box_min[3], box_max[3];
            scree_rt_scene_cubes_box(w.scene, k, 0, c, end, box_min, box_max);
            if (count > 0) assert_true(scree_rt_scene_may_hold(w.scene, k, box_min, box_max));
          }
      scene_rocks_sort(&sum);
      assert_scene_rocks_equal(&whole, &sum);
      scene_rocks_free(&whole);
      scene_rocks_free(&sum);
    }
    destroy_world(&w);
  }
  scree_scratch_destroy(scratch);
}

static void every_instance_is_found_by_its_id_in_its_state(void** state) {
  (void)state;
  scree_scratch* scratch = make_scratch();
  uint32_t states[6] = {0};
  for (uint64_t round = 0; round < 8; ++round) {
    random_stream r = {200 + round};
    world w;
    make_scatter_world(&w, &r, 2 + random_below(&r, 2));
    edit_some(&w, &r, scratch);
    scene_twin twin = twin_of(&w, w.middle);
    for (uint32_t k = 0; k < w.count; ++k) {
      if (twin.layers[k].models == NULL) continue;
      for (uint64_t i = 0; i < twin.layers[k].count; ++i) {
        const twin_rock* t = &twin.layers[k].rocks[i];
        bool near = true;
        for (int a = 0; a < 3; ++a) near = near && fabs(t->place[a] - w.middle[a]) < 9;
        if (!near) continue;
        scree_rock rock;
        scree_rock_state found;
        assert_int_equal(scree_scene_find(w.scene, w.edits, scratch, &t->rock.id, w.middle, &rock, &found), SCREE_OK);
        ++states[found];
        assert_int_equal(found, t->dropped                     ? SCREE_ROCK_DROPPED
                                : t->edit == SCREE_EDIT_REMOVE ? SCREE_ROCK_REMOVED
                                : t->edit == SCREE_EDIT_HIDE   ? SCREE_ROCK_HIDDEN
                                                               : SCREE_ROCK_EXISTS);
        assert_memory_equal(&rock, &t->rock, sizeof rock);
        assert_int_equal(scree_scene_random(w.scene, &t->rock.id), t->random);
        scree_id id = t->rock.id;
        ++id.cube[1];
        assert_int_equal(scree_scene_find(w.scene, w.edits, scratch, &id, w.middle, &rock, &found), SCREE_OK);
        assert_int_equal(found, SCREE_ROCK_OUTSIDE);
        assert_int_equal(rock.asset, t->rock.asset);
        id.local = 900;
        assert_int_equal(scree_scene_find(w.scene, w.edits, scratch, &id, w.middle, NULL, &found), SCREE_OK);
        assert_int_equal(found, SCREE_ROCK_UNKNOWN);
      }
    }
    twin_scene_free(&twin);
    destroy_world(&w);
  }
  assert_true(states[SCREE_ROCK_EXISTS] > 50 && states[SCREE_ROCK_REMOVED] > 5 && states[SCREE_ROCK_HIDDEN] > 5);
  assert_true(states[SCREE_ROCK_DROPPED] > 5);
  scree_scratch_destroy(scratch);
}

/* --- rays, overlaps, near ---------------------------------------------------------------------------------------------------- */

static bool is_there(const twin_rock* rock) {
  return !rock->dropped && rock->edit != SCREE_EDIT_REMOVE;
}

/* A ray's start, or a shape's middle, among the rocks. */
static void random_place(const world* w, random_stream* r, double place[3]) {
  for (int a = 0; a < 3; ++a) place[a] = w->middle[a] + random_in(r, -7, 7) * (a == 1 ? 0.4 : 1);
}

static void rays_hit_the_nearest_part_of_all(void** state) {
  (void)state;
  scree_scratch* scratch = make_scratch();
  uint32_t hits[2] = {0, 0};
  for (uint64_t round = 0; round < 8; ++round) {
    random_stream r = {300 + round};
    world w;
    make_scatter_world(&w, &r, 1 + random_below(&r, 3));
    if (round % 2) edit_some(&w, &r, scratch);
    scene_twin twin = twin_of(&w, w.middle);
    for (int shot = 0; shot < 30; ++shot) {
      double start[3], direction[3];
      random_place(&w, &r, start);
      for (int a = 0; a < 3; ++a) direction[a] = 0;
      if (shot % 3 == 0) {
        start[1] += 6;
        direction[1] = -1;
      } else {
        const double angle = random_in(&r, 0, 6.283185307179586); /* unit, so that all normalise it alike */
        direction[0] = cos(angle);
        direction[2] = sin(angle);
      }
      double length2 = 0, largest = 0, along[3];
      for (int a = 0; a < 3; ++a) largest = fmax(largest, fabs(direction[a]));
      for (int a = 0; a < 3; ++a) {
        along[a] = direction[a] / largest;
        length2 += along[a] * along[a];
      }
      for (int a = 0; a < 3; ++a) along[a] /= sqrt(length2);
      double best = 8;
      const twin_rock* nearest = NULL;
      bool scattered = false;
      for (uint32_t k = 0; k < twin.count; ++k)
        for (uint64_t i = 0; i < twin.layers[k].count; ++i) {
          const twin_rock* rock = &twin.layers[k].rocks[i];
          float xyz[3][64];
          convex_hull hull;
          double t, normal[3];
          for (uint32_t part = 0; is_there(rock) && twin_hull(&twin.layers[k], rock, part, start, xyz, &hull); ++part) {
            if (!scree_rt_convex_ray(&hull, (const double[3]){0, 0, 0}, along, best, &t, normal)) continue;
            if (nearest != NULL && t == best && scree_rt_edits_compare(&rock->rock.id, &nearest->rock.id) >= 0) continue;
            best = t;
            nearest = rock;
            scattered = twin.layers[k].models != NULL;
          }
        }
      bool found;
      scree_hit hit;
      assert_int_equal(scree_scene_ray_cast(w.scene, w.edits, scratch, start, direction, 8, &found, &hit), SCREE_OK);
      assert_int_equal(found, nearest != NULL);
      if (!found) continue;
      assert_memory_equal(&hit.rock.id, &nearest->rock.id, sizeof hit.rock.id);
      assert_int_equal(hit.rock.asset, nearest->rock.asset);
      assert_true(hit.distance == best);
      ++hits[scattered];
    }
    twin_scene_free(&twin);
    destroy_world(&w);
  }
  assert_true(hits[0] > 10 && hits[1] > 10);
  scree_scratch_destroy(scratch);
}

static void assert_same_ids(const scene_rocks* expected, const scree_rock* found, uint64_t count) {
  assert_int_equal(count, expected->count);
  for (uint64_t i = 0; i < count; ++i) {
    assert_memory_equal(&found[i].id, &expected->rocks[i].id, sizeof found[i].id);
    assert_int_equal(found[i].asset, expected->rocks[i].asset);
  }
}

static void shapes_and_points_meet_the_parts_that_all_of_them_do(void** state) {
  (void)state;
  scree_scratch* scratch = make_scratch();
  uint64_t met = 0;
  for (uint64_t round = 0; round < 10; ++round) {
    random_stream r = {400 + round};
    world w;
    make_scatter_world(&w, &r, 1 + random_below(&r, 3));
    if (round % 2) edit_some(&w, &r, scratch);
    scene_twin twin = twin_of(&w, w.middle);
    for (int question = 0; question < 12; ++question) {
      scree_convex shape = {.point_count = question % 2 ? 2 : 1, .radius = (float)random_in(&r, 0.1, 1.5)};
      float points[6] = {0, 0, 0, (float)random_in(&r, -2, 2), (float)random_in(&r, -2, 2), (float)random_in(&r, -2, 2)};
      random_place(&w, &r, shape.origin);
      shape.points = points;
      const float x[2] = {points[0], points[3]}, y[2] = {points[1], points[4]}, z[2] = {points[2], points[5]};
      const convex_hull own = {x, y, z, shape.point_count, 1, {0, 0, 0}, (double)shape.radius};
      scene_rocks expected = {NULL, 0};
      for (uint32_t k = 0; k < twin.count; ++k)
        for (uint64_t i = 0; i < twin.layers[k].count; ++i) {
          const twin_rock* rock = &twin.layers[k].rocks[i];
          float xyz[3][64];
          convex_hull hull;
          bool meets = false;
          for (uint32_t part = 0; is_there(rock) && twin_hull(&twin.layers[k], rock, part, shape.origin, xyz, &hull); ++part)
            meets = meets || scree_rt_convex_meet(&hull, &own);
          if (meets) scene_rocks_join(&expected, &rock->rock, 1);
        }
      scene_rocks_sort(&expected);
      met += expected.count;
      static scree_rock found[5000];
      uint64_t count;
      assert_int_equal(scree_scene_overlap(w.scene, w.edits, scratch, &shape, found, 5000, &count), SCREE_OK);
      assert_same_ids(&expected, found, count);
      if (shape.point_count == 1) { /* near a point is what a ball meets */
        assert_int_equal(
            scree_scene_near(w.scene, w.edits, scratch, shape.origin, 1, (double)shape.radius, w.middle, found, 5000, &count),
            SCREE_OK);
        assert_same_ids(&expected, found, count);
      }
      scene_rocks_free(&expected);
    }
    twin_scene_free(&twin);
    destroy_world(&w);
  }
  assert_true(met > 300);
  scree_scratch_destroy(scratch);
}

/* --- rules that can be seen -------------------------------------------------------------------------------------------------- */

static void rocks_make_room_for_models_and_later_models_for_rocks(void** state) {
  (void)state;
  const scree_shape slab = {.kind = SCREE_SHAPE_BOX, .box = {{15, 1, 15}, 0}},
                    pile = {.kind = SCREE_SHAPE_BOX, .box = {{15, 2, 15}, 0}};
  scree_support *ground = one_shape(&slab), *rocks_in = one_shape(&pile);
  const scree_scatter_model post = {.footprint_radius = 1, .height = 4};
  scree_scatter* scatter;
  assert_int_equal(
      scree_scatter_create(&(scree_scatter_desc){.models = &post, .model_count = 1, .spacing = 4}, NULL, &scatter, NULL), SCREE_OK);
  synthetic_source source = synthetic_create(4, 1, 1, 5);
  synthetic_add_hulls(&source, 3, 2, 0);
  scree_field* field;
  assert_int_equal(
      scree_rt_field_create_from_source(&(scree_field_desc){.seed = 4, .cell_size = 0.6}, &source.source, NULL, &field), SCREE_OK);
  scree_layer layers[2] = {{.scatter = scatter, .support = ground}, {.field = field, .support = rocks_in}};
  scree_scratch* scratch = make_scratch();
  uint64_t alone[2], together[2];
  for (int order = 0; order < 2; ++order) {
    scree_scene* scene;
    assert_int_equal(scree_scene_create(&(scree_scene_desc){layers, 2}, NULL, &scene, NULL), SCREE_OK);
    assert_null(scree_scene_layer(scene, (uint32_t)order)->field);
    assert_true(scree_scene_layer(scene, (uint32_t)order)->scatter == scatter);
    for (uint32_t k = 0; k < 2; ++k) {
      scree_scene* one;
      assert_int_equal(scree_scene_create(&(scree_scene_desc){&layers[k], 1}, NULL, &one, NULL), SCREE_OK);
      scree_scene_query_desc d = {.scene = one};
      assert_int_equal(scree_scene_count(&d, scratch, &alone[k]), SCREE_OK);
      d = (scree_scene_query_desc){.scene = scene, .layers = UINT64_C(1) << k};
      assert_int_equal(scree_scene_count(&d, scratch, &together[k]), SCREE_OK);
      scree_scene_destroy(one);
    }
    assert_int_equal(together[0], alone[0]); /* two instances of one scatter never drop each other, the first layer drops nothing */
    assert_true(together[1] < alone[1]);
    if (order == 0) assert_true(alone[1] - together[1] > 10 * alone[0]); /* each post stands where dozens of rocks were */
    if (order == 1) assert_int_equal(together[1], 0);                    /* the pile is full: no post fits in */
    scree_scene_destroy(scene);
    const scree_layer swapped = layers[0];
    layers[0] = layers[1];
    layers[1] = swapped;
  }
  float xyz[3 * 64];
  uint32_t count;
  scree_scene* scene;
  assert_int_equal(scree_scene_create(&(scree_scene_desc){layers, 2}, NULL, &scene, NULL), SCREE_OK);
  assert_int_equal(scree_scene_hull(scene, 0, 0, xyz, 64, &count), SCREE_OK);
  assert_int_equal(count, 16);
  assert_int_equal(scree_scene_hull(scene, 0, 1, xyz, 64, &count), SCREE_ERROR_INVALID_ARGUMENT);
  scree_scene_destroy(scene);
  scree_scratch_destroy(scratch);
  scree_field_destroy(field);
  synthetic_destroy(&source);
  scree_scatter_destroy(scatter);
  scree_support_destroy(ground);
  scree_support_destroy(rocks_in);
}

/* Arms of models reach far from where they stand: a question about one rock has to look there. */
static void single_rocks_are_judged_as_among_all(void** state) {
  (void)state;
  const scree_shape slab = {.kind = SCREE_SHAPE_BOX, .box = {{15, 1, 15}, 0}},
                    pile = {.kind = SCREE_SHAPE_BOX, .box = {{15, 2, 15}, 0}};
  scree_support *ground = one_shape(&slab), *rocks_in = one_shape(&pile);
  const float arm[] = {0, 0.1f, 0, 0, 0.5f, 0.1f, 5, 0.2f, -0.1f, 5, 0.4f, 0.1f};
  const scree_scatter_model armed = {.footprint_radius = 0.1f, .height = 0.5f, .hull = arm, .hull_count = 4};
  scree_scatter* scatter;
  assert_int_equal(
      scree_scatter_create(&(scree_scatter_desc){.models = &armed, .model_count = 1, .spacing = 6}, NULL, &scatter, NULL),
      SCREE_OK);
  synthetic_source source = synthetic_create(4, 1, 1, 5);
  synthetic_add_hulls(&source, 3, 2, 0);
  scree_field* field;
  assert_int_equal(
      scree_rt_field_create_from_source(&(scree_field_desc){.seed = 4, .cell_size = 0.6}, &source.source, NULL, &field), SCREE_OK);
  const scree_layer layers[2] = {{.scatter = scatter, .support = ground}, {.field = field, .support = rocks_in}};
  scree_scratch* scratch = make_scratch();
  scree_scene *scene, *alone;
  assert_int_equal(scree_scene_create(&(scree_scene_desc){layers, 2}, NULL, &scene, NULL), SCREE_OK);
  assert_int_equal(scree_scene_create(&(scree_scene_desc){&layers[1], 1}, NULL, &alone, NULL), SCREE_OK);
  scree_scene_query_desc all = {.scene = scene, .layers = 2}, every = {.scene = alone};
  scene_rocks kept = ask_scene(&all, scratch), candidates = ask_scene(&every, scratch);
  uint64_t judged = 0;
  for (uint64_t i = 0; i < candidates.count; ++i) {
    scree_id id = candidates.rocks[i].id;
    id.layer = 1;
    candidates.rocks[i].id = id;
    scree_rock_state found;
    if (i % 7 != 0) continue;
    assert_int_equal(scree_scene_find(scene, NULL, scratch, &id, all.origin, NULL, &found), SCREE_OK);
    const scene_rocks one = {&candidates.rocks[i], 1};
    assert_int_equal(found, scene_rocks_missing(&kept, &one) == 0 ? SCREE_ROCK_EXISTS : SCREE_ROCK_DROPPED);
    judged += found == SCREE_ROCK_DROPPED;
  }
  assert_true(judged > 20);
  scene_rocks_free(&kept);
  scene_rocks_free(&candidates);
  scree_scene_destroy(alone);
  scree_scene_destroy(scene);
  scree_scratch_destroy(scratch);
  scree_field_destroy(field);
  synthetic_destroy(&source);
  scree_scatter_destroy(scatter);
  scree_support_destroy(ground);
  scree_support_destroy(rocks_in);
}

static void edits_of_scatters_are_saved_and_apply_to_the_same_instances_only(void** state) {
  (void)state;
  random_stream r = {21};
  world w;
  scree_scratch* scratch = make_scratch();
  uint32_t k;
  uint64_t of_scatter;
  for (;;) { /* until one has edits of a scatter */
    make_scatter_world(&w, &r, 3);
    edit_some(&w, &r, scratch);
    for (k = 0; k < 2 && w.scatters[k] == NULL;) ++k;
    of_scatter = 0;
    for (uint32_t i = 0; i < w.edit_count; ++i) of_scatter += w.edit_list[i].id.layer == scree_scene_layer(w.scene, k)->key;
    if (w.scatters[k] != NULL && of_scatter > 3) break;
    destroy_world(&w);
  }
  size_t size;
  assert_int_equal(scree_edits_save(w.edits, w.scene, NULL, 0, &size), SCREE_ERROR_CAPACITY);
  uint8_t* bytes = malloc(size);
  assert_non_null(bytes);
  assert_int_equal(scree_edits_save(w.edits, w.scene, bytes, size, &size), SCREE_OK);
  const uint16_t key = scree_scene_layer(w.scene, k)->key;
  scree_scatter_desc other = w.scatters[k]->desc;
  for (int change = 0; change < 3; ++change) {
    other = w.scatters[k]->desc;
    if (change == 1) ++other.seed;
    if (change == 2) other.spacing *= 2;
    scree_scatter* scatter;
    assert_int_equal(scree_scatter_create(&other, NULL, &scatter, NULL), SCREE_OK);
    scree_layer layers[3];
    memcpy(layers, w.layers, sizeof layers);
    layers[k].scatter = scatter;
    scree_scene* scene;
    assert_int_equal(scree_scene_create(&(scree_scene_desc){layers, 3}, NULL, &scene, NULL), SCREE_OK);
    scree_edits* loaded;
    assert_int_equal(scree_edits_create(NULL, &loaded), SCREE_OK);
    scree_edits_report report;
    assert_int_equal(scree_edits_load(loaded, scene, bytes, size, &report), SCREE_OK);
    assert_int_equal(report.stale, change == 0 ? 0 : of_scatter);
    assert_int_equal(report.applied, w.edit_count - report.stale);
    for (uint32_t i = 0; i < w.edit_count; ++i)
      if (change == 0 || w.edit_list[i].id.layer != key)
        assert_int_equal(scree_edits_get(loaded, &w.edit_list[i].id), w.edit_list[i].edit);
    scree_edits_destroy(loaded);
    scree_scene_destroy(scene);
    scree_scatter_destroy(scatter);
  }
  /* A point that no tile has. */
  const scree_id nothing = {{1, 0, 1}, 1000, key};
  assert_int_equal(scree_edits_set(w.edits, &nothing, SCREE_EDIT_HIDE), SCREE_OK);
  free(bytes);
  assert_int_equal(scree_edits_save(w.edits, w.scene, NULL, 0, &size), SCREE_ERROR_CAPACITY);
  bytes = malloc(size);
  assert_non_null(bytes);
  assert_int_equal(scree_edits_save(w.edits, w.scene, bytes, size, &size), SCREE_OK);
  scree_edits* loaded;
  assert_int_equal(scree_edits_create(NULL, &loaded), SCREE_OK);
  scree_edits_report report;
  assert_int_equal(scree_edits_load(loaded, w.scene, bytes, size, &report), SCREE_OK);
  assert_int_equal(report.unknown_rock, 1);
  scree_edits_destroy(loaded);
  free(bytes);
  scree_scratch_destroy(scratch);
  destroy_world(&w);
}

static void wrong_layers_of_scatters_are_refused_with_the_reason(void** state) {
  (void)state;
  random_stream r = {9};
  world w;
  uint32_t at = 3;
  while (at == 3) {
    make_scatter_world(&w, &r, 3);
    for (at = 0; at < 3 && w.scatters[at] == NULL;) ++at;
    if (at == 3) destroy_world(&w);
  }
  scree_shape wall = {.kind = SCREE_SHAPE_HALF_SPACE};
  wall.transform.rotation[0] = wall.transform.rotation[3] = 0.70710678f;
  scree_support* upright = one_shape(&wall);
  synthetic_source source = synthetic_create(4, 1, 1, 5);
  scree_field* field;
  assert_int_equal(
      scree_rt_field_create_from_source(&(scree_field_desc){.seed = 4, .cell_size = 0.6}, &source.source, NULL, &field), SCREE_OK);
  const struct {
    scree_layer layer;
    scree_result result;
    const char* words;
  } cases[] = {
      {{.support = upright}, SCREE_ERROR_INVALID_ARGUMENT, "layer 0: field is NULL, and so is scatter"},
      {{.scatter = w.layers[at].scatter, .support = upright}, SCREE_ERROR_RANGE, "end somewhere above"},
      {{.scatter = w.layers[at].scatter}, SCREE_ERROR_INVALID_ARGUMENT, "support is NULL"},
      {{.scatter = w.layers[at].scatter, .field = field, .support = w.supports[at]},
       SCREE_ERROR_INVALID_ARGUMENT,
       "a field and a scatter"},
      {{.scatter = w.layers[at].scatter, .support = w.supports[at], .threshold = 0.3f}, SCREE_ERROR_INVALID_ARGUMENT, "threshold"},
      {{.scatter = w.layers[at].scatter, .support = w.supports[at], .shell_depth = 1}, SCREE_ERROR_INVALID_ARGUMENT, "shell_depth"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    scree_scene* scene;
    scree_error error;
    assert_int_equal(scree_scene_create(&(scree_scene_desc){&cases[i].layer, 1}, NULL, &scene, &error), cases[i].result);
    if (strstr(error.message, cases[i].words) == NULL) fail_msg("\"%s\" does not say \"%s\"", error.message, cases[i].words);
  }
  scree_field_destroy(field);
  synthetic_destroy(&source);
  scree_support_destroy(upright);
  destroy_world(&w);
}

static void each_allocation_of_a_question_may_fail(void** state) {
  (void)state;
  random_stream r = {12};
  world w;
  make_scatter_world(&w, &r, 3);
  scree_scene_query_desc d = everything(&w);
  bool failed = true;
  for (int at = 0; failed; ++at) {
    failing_allocator failing = {.fail_at = at};
    const scree_allocator allocator = failing_allocator_of(&failing);
    scree_scratch* scratch;
    scree_result result = scree_scratch_create(&allocator, &scratch);
    uint64_t count;
    if (result == SCREE_OK) {
      result = scree_scene_count(&d, scratch, &count);
      scree_scratch_destroy(scratch);
    }
    failed = failing.failed;
    assert_int_equal(result, failed ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_OK);
    assert_int_equal(failing.live, 0);
    if (!failed) assert_true(at > 6);
  }
  destroy_world(&w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(scenes_with_scatters_equal_their_plain_twin),
      cmocka_unit_test(blocks_of_scatters_have_the_instances_of_the_whole),
      cmocka_unit_test(every_instance_is_found_by_its_id_in_its_state),
      cmocka_unit_test(rays_hit_the_nearest_part_of_all),
      cmocka_unit_test(shapes_and_points_meet_the_parts_that_all_of_them_do),
      cmocka_unit_test(rocks_make_room_for_models_and_later_models_for_rocks),
      cmocka_unit_test(single_rocks_are_judged_as_among_all),
      cmocka_unit_test(edits_of_scatters_are_saved_and_apply_to_the_same_instances_only),
      cmocka_unit_test(wrong_layers_of_scatters_are_refused_with_the_reason),
      cmocka_unit_test(each_allocation_of_a_question_may_fail),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
