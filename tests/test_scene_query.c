/* Scenes against their plain twin (scene_twin.h), and what every question about a scene promises. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "random_world.h"
#include "rounds.h"

static const double REACH = 24; /* metres from the middle: nothing farther matters to what is asked */

static void check_answer(world* w, scree_scene_query_desc* d, scree_scratch* scratch) {
  d->edits = w->edit_count > 0 ? w->edits : NULL;
  scene_twin twin = twin_scene(&w->desc, w->source_of, w->scatter_of, w->edit_list, w->edit_count, w->middle, REACH, d->origin);
  scene_rocks expected = twin_answer(&twin, d), found = ask_scene(d, scratch);
  assert_scene_rocks_equal(&expected, &found);
  scene_rocks_free(&expected);
  scene_rocks_free(&found);
  twin_scene_free(&twin);
}

static void query_equals_its_plain_twin(uint64_t seed, uint32_t layers, uint32_t rounds, uint32_t flags, bool edits) {
  /* layers 0: a thick world; 10 and more: a mixed one of layers - 10 */
  random_stream r = {seed};
  scree_scratch* scratch = make_scratch();
  for (uint32_t round = 0; round < ROUNDS(rounds, 5); ++round) {
    world w;
    if (layers > 10) {
      make_mixed_world(&w, &r, layers - 10);
    } else if (layers > 0) {
      make_world(&w, &r, layers);
    } else {
      make_thick_world(&w, &r);
    }
    if (edits) {
      scree_scene_query_desc all = {.scene = w.scene};
      for (int a = 0; a < 3; ++a) {
        all.min[a] = w.middle[a] - 9;
        all.max[a] = w.middle[a] + 9;
      }
      scene_rocks rocks = ask_scene(&all, scratch);
      make_edits(&w, &r, &rocks);
      scene_rocks_free(&rocks);
    }
    for (int k = 0; k < 2; ++k) {
      scree_scene_query_desc d = random_question(&w, &r);
      d.flags = flags;
      check_answer(&w, &d, scratch);
    }
    destroy_world(&w);
  }
  scree_scratch_destroy(scratch);
}

static void one_layer_equals_its_plain_twin(void** state) {
  (void)state;
  query_equals_its_plain_twin(1, 1, 30, 0, false);
}

static void overlapping_layers_equal_their_plain_twin(void** state) {
  (void)state;
  query_equals_its_plain_twin(2, 2, 15, 0, false);
  query_equals_its_plain_twin(3, 3, 10, 0, true);
  query_equals_its_plain_twin(4, 4, 10, 0, true);
  query_equals_its_plain_twin(10, 12, 12, 0, false);
  query_equals_its_plain_twin(11, 13, 8, 0, true);
}

static void what_is_visible_equals_its_plain_twin(void** state) {
  (void)state;
  query_equals_its_plain_twin(5, 1, 40, SCREE_SCENE_VISIBLE, false);
  query_equals_its_plain_twin(6, 1, 20, SCREE_SCENE_VISIBLE, true);
  query_equals_its_plain_twin(7, 3, 20, SCREE_SCENE_VISIBLE, true);
  query_equals_its_plain_twin(8, 0, 30, SCREE_SCENE_VISIBLE, false);
  query_equals_its_plain_twin(9, 0, 15, SCREE_SCENE_VISIBLE, true);
}

/* --- blocks, boxes, places ------------------------------------------------------------------------------------------------- */

/* The box of cubes that a layer's rocks can stand in, as far as tests look. */
static void cubes_of(const world* w, uint32_t k, double reach, int32_t low[3], int32_t high[3]) {
  const scree_field* f = w->fields[k];
  double size = f->cell_size * f->cells_per_cube;
  for (int a = 0; a < 3; ++a) {
    low[a] = (int32_t)floor((w->middle[a] - reach - f->origin[a]) / size);
    high[a] = (int32_t)ceil((w->middle[a] + reach - f->origin[a]) / size) + 1;
  }
}

static void blocks_of_any_size_and_order_make_up_the_whole(void** state) {
  (void)state;
  random_stream r = {20};
  scree_scratch* scratch = make_scratch();
  for (int round = 0; round < ROUNDS(24, 4); ++round) {
    world w;
    if (round % 3 == 0) {
      make_thick_world(&w, &r);
    } else {
      make_world(&w, &r, 2 + random_below(&r, 3));
    }
    uint32_t k = random_below(&r, w.count);
    int32_t low[3], high[3];
    cubes_of(&w, k, 9, low, high);
    double min[3], max[3];
    scree_rt_scene_cubes_box(w.scene, k, 0, low, high, min, max);
    scree_scene_query_desc d = {.scene = w.scene, .layers = UINT64_C(1) << k};
    memcpy(d.min, min, sizeof min);
    memcpy(d.max, max, sizeof max);
    for (int a = 0; a < 3; ++a) d.origin[a] = w.middle[a] + 3;
    scene_rocks all = ask_scene(&d, scratch);
    make_edits(&w, &r, &all);
    scene_rocks_free(&all);
    d.edits = w.edits;
    d.flags = random_below(&r, 2) ? SCREE_SCENE_VISIBLE : 0;
    all = ask_scene(&d, scratch);

    scene_rocks joined = {NULL, 0};
    int32_t step[3], at[3];
    for (int a = 0; a < 3; ++a) step[a] = 1 + (int32_t)random_below(&r, 4);
    for (at[2] = high[2]; at[2] > low[2]; at[2] -= step[2]) /* from the far end, rows in another order */
      for (at[0] = low[0]; at[0] < high[0]; at[0] += step[0])
        for (at[1] = low[1]; at[1] < high[1]; at[1] += step[1]) {
          int32_t from[3] = {at[0], at[1], at[2] - step[2] > low[2] ? at[2] - step[2] : low[2]};
          int32_t to[3] = {at[0] + step[0] < high[0] ? at[0] + step[0] : high[0],
                           at[1] + step[1] < high[1] ? at[1] + step[1] : high[1], at[2]};
          const scree_rock* rocks;
          uint64_t count;
          assert_int_equal(scree_rt_scene_block(w.scene, d.edits, k, from, to, d.origin, d.flags != 0, scratch, &rocks, &count),
                           SCREE_OK);
          scene_rocks_join(&joined, rocks, count);
          double box_min[3], box_max[3];
          scree_rt_scene_cubes_box(w.scene, k, 0, from, to, box_min, box_max);
          if (count > 0) assert_true(scree_rt_scene_may_hold(w.scene, k, box_min, box_max));
        }
    scene_rocks_sort(&joined);
    assert_scene_rocks_equal(&all, &joined);

    scene_rocks_free(&joined); /* and boxes that no cube knows of */
    double cut[3][4];
    for (int a = 0; a < 3; ++a) {
      cut[a][0] = min[a];
      cut[a][1] = random_in(&r, min[a], max[a]);
      cut[a][2] = random_in(&r, cut[a][1], max[a]);
      cut[a][3] = max[a];
    }
    for (int i = 0; i < 27; ++i) {
      scree_scene_query_desc part = d;
      const int place[3] = {i % 3, i / 3 % 3, i / 9};
      for (int a = 0; a < 3; ++a) {
        part.min[a] = cut[a][place[a]];
        part.max[a] = cut[a][place[a] + 1];
      }
      scene_rocks rocks = ask_scene(&part, scratch);
      scene_rocks_join(&joined, rocks.rocks, rocks.count);
      scene_rocks_free(&rocks);
    }
    scene_rocks_sort(&joined);
    assert_scene_rocks_equal(&all, &joined);
    scene_rocks_free(&joined);
    scene_rocks_free(&all);
    destroy_world(&w);
  }
  scree_scratch_destroy(scratch);
}

/* Everything moved by a distance that doubles hold exactly. */
static void scene_far_from_the_origin_is_the_same_scene(void** state) {
  (void)state;
  random_stream r = {21};
  scree_scratch* scratch = make_scratch();
  for (int round = 0; round < 12; ++round) {
    world w;
    make_world(&w, &r, 1 + random_below(&r, 4));
    for (uint32_t k = 0; k < w.count; ++k) { /* places that stay exact when they are moved */
      scree_field* f = w.fields[k];
      for (int a = 0; a < 3; ++a) {
        f->origin[a] = floor(f->origin[a] * 16) / 16;
        w.shapes[k]->desc.origin[a] = floor(w.shapes[k]->desc.origin[a] * 16) / 16;
        w.supports[k]->origin[a] = w.shapes[k]->desc.origin[a];
      }
      for (uint32_t i = 0; i < w.layers[k].filter_count; ++i) {
        for (int a = 0; a < 3; ++a) w.filters[k][i].centre[a] = floor(w.filters[k][i].centre[a] * 16) / 16;
        if (w.filters[k][i].kind == SCREE_FILTER_ALTITUDE) w.layers[k].filter_count = i; /* world heights change */
      }
    }
    scree_scene_destroy(w.scene);
    assert_int_equal(scree_scene_create(&w.desc, NULL, &w.scene, NULL), SCREE_OK);
    scree_scene_query_desc d = {.scene = w.scene, .flags = random_below(&r, 2)};
    for (int a = 0; a < 3; ++a) {
      d.origin[a] = floor(w.middle[a]);
      d.min[a] = floor(w.middle[a]) - 7.125;
      d.max[a] = floor(w.middle[a]) + 7.125;
    }
    scene_rocks near = ask_scene(&d, scratch);
    const double far[3] = {1e7, -1.25e7, 0.75e7};
    for (int a = 0; a < 3; ++a) {
      d.origin[a] += far[a];
      d.min[a] += far[a];
      d.max[a] += far[a];
      for (uint32_t k = 0; k < w.count; ++k) {
        w.fields[k]->origin[a] += far[a];
        w.supports[k]->origin[a] += far[a];
        for (uint32_t i = 0; i < w.layers[k].filter_count; ++i) w.filters[k][i].centre[a] += far[a];
      }
    }
    scree_scene_destroy(w.scene);
    assert_int_equal(scree_scene_create(&w.desc, NULL, &w.scene, NULL), SCREE_OK);
    d.scene = w.scene;
    scene_rocks moved = ask_scene(&d, scratch);
    assert_scene_rocks_equal(&near, &moved);
    scene_rocks_free(&near);
    scene_rocks_free(&moved);
    destroy_world(&w);
  }
  scree_scratch_destroy(scratch);
}

static void origin_decides_positions_and_nothing_else(void** state) {
  (void)state;
  random_stream r = {22};
  scree_scratch* scratch = make_scratch();
  for (int round = 0; round < 8; ++round) {
    world w;
    make_world(&w, &r, 3);
    scree_scene_query_desc d = random_question(&w, &r);
    scene_rocks here = ask_scene(&d, scratch);
    for (int a = 0; a < 3; ++a) d.origin[a] = random_in(&r, -1e6, 1e6);
    scene_rocks there = ask_scene(&d, scratch);
    assert_int_equal(here.count, there.count);
    for (uint64_t i = 0; i < here.count; ++i) {
      assert_memory_equal(&here.rocks[i].id, &there.rocks[i].id, sizeof(scree_id));
      assert_int_equal(here.rocks[i].asset, there.rocks[i].asset);
    }
    scene_rocks_free(&here);
    scene_rocks_free(&there);
    destroy_world(&w);
  }
  scree_scratch_destroy(scratch);
}

static void rock_is_found_by_its_id_with_why_it_is_there_or_not(void** state) {
  (void)state;
  random_stream r = {23};
  scree_scratch* scratch = make_scratch();
  uint32_t seen[6] = {0};
  for (int round = 0; round < 12; ++round) {
    world w;
    make_world(&w, &r, 1 + random_below(&r, 3));
    scree_scene_query_desc d = {.scene = w.scene};
    for (int a = 0; a < 3; ++a) {
      d.min[a] = w.middle[a] - 8;
      d.max[a] = w.middle[a] + 8;
    }
    scene_rocks all = ask_scene(&d, scratch);
    make_edits(&w, &r, &all);
    scene_twin twin = twin_scene(&w.desc, w.source_of, w.scatter_of, w.edit_list, w.edit_count, w.middle, REACH, w.middle);
    for (uint32_t k = 0; k < w.count; ++k)
      for (uint32_t i = 0; i < 60 && twin.layers[k].count > 0; ++i) {
        const twin_rock* rock = &twin.layers[k].rocks[random_bits(&r) % twin.layers[k].count];
        bool close = true; /* what lies farther may be decided beyond the twin's reach */
        for (int a = 0; a < 3; ++a) close = close && fabsf(rock->rock.position[a]) < 10;
        if (!close) continue;
        scree_rock found;
        scree_rock_state got;
        assert_int_equal(scree_scene_find(w.scene, w.edits, scratch, &rock->rock.id, w.middle, &found, &got), SCREE_OK);
        assert_int_equal(got, rock->dropped                     ? SCREE_ROCK_DROPPED
                              : rock->edit == SCREE_EDIT_REMOVE ? SCREE_ROCK_REMOVED
                              : rock->edit == SCREE_EDIT_HIDE   ? SCREE_ROCK_HIDDEN
                                                                : SCREE_ROCK_EXISTS);
        assert_memory_equal(&found, &rock->rock, sizeof found);
        ++seen[got];
        scree_id id = rock->rock.id;
        for (int a = 0; a < 3; ++a) id.cube[a] += 1000; /* far outside */
        uint32_t code = scree_field_tile_code(w.fields[k], id.cube);
        bool known = scree_rt_field_slot(w.fields[k], code, id.local) != UINT32_MAX;
        double low[3], high[3];
        scree_support_bounds(w.supports[k], low, high);
        assert_int_equal(scree_scene_find(w.scene, w.edits, scratch, &id, w.middle, &found, &got), SCREE_OK);
        if (!known) assert_int_equal(got, SCREE_ROCK_UNKNOWN);
        if (known && isfinite(low[0]) && isfinite(low[1]) && isfinite(low[2])) assert_int_equal(got, SCREE_ROCK_OUTSIDE);
        ++seen[got];
        id.local = UINT16_MAX;
        assert_int_equal(scree_scene_find(w.scene, NULL, scratch, &id, w.middle, NULL, &got), SCREE_OK);
        assert_int_equal(got, SCREE_ROCK_UNKNOWN);
        id.layer = 999;
        assert_int_equal(scree_scene_find(w.scene, NULL, scratch, &id, w.middle, NULL, &got), SCREE_OK);
        assert_int_equal(got, SCREE_ROCK_UNKNOWN);
      }
    const scree_id end = {{INT32_MAX, INT32_MIN, INT32_MAX}, 0, twin.layers[0].given->key};
    scree_rock_state got;
    assert_int_equal(scree_scene_find(w.scene, NULL, scratch, &end, w.middle, NULL, &got), SCREE_OK);
    scene_rocks_free(&all);
    twin_scene_free(&twin);
    destroy_world(&w);
  }
  for (int i = 0; i < 6; ++i) assert_true(seen[i] > 0);
  scree_scratch_destroy(scratch);
}

/* --- the far field --------------------------------------------------------------------------------------------------------- */

typedef struct far_twin {
  const world* w;
  uint32_t layer;
  double scale;
  float shell;
} far_twin;

/* The distance at the middle of a part, by its place: cube * 2 + (0 or 1) along each axis. */
static float part_distance(const far_twin* t, const int64_t part[3], scree_id* id) {
  const scree_field* f = t->w->fields[t->layer];
  uint32_t n = f->cells_per_cube;
  double cell = f->cell_size * t->scale, half = cell * n * 0.5;
  float at[3], d;
  *id = (scree_id){.local = 0};
  for (int a = 0; a < 3; ++a) {
    int64_t high = ((part[a] % 2) + 2) % 2;
    double middle = high ? ((n + 1) / 2 + n) * cell * 0.5 : (n + 1) / 2 * cell * 0.5; /* from the cube's start */
    double start = f->origin[a] - f->cell_size * 0.5;
    at[a] = (float)((start + half * 0.5 - t->w->supports[t->layer]->origin[a]) + half * (double)part[a]) +
            (float)(middle - (high ? half * 1.5 : half * 0.5));
    id->cube[a] = (int32_t)((part[a] - high) / 2);
    id->local = (uint16_t)(id->local | high << a);
  }
  scree_support_distance(t->w->supports[t->layer], &at[0], &at[1], &at[2], &d, 1);
  return d;
}

/* How far outside middles may be. */
static float part_offset(const far_twin* t) {
  const scree_field* f = t->w->fields[t->layer];
  const scree_layer* layer = &t->w->layers[t->layer];
  float threshold = layer->threshold > 0 ? layer->threshold : 0.5f;
  return (float)(1 - 2 * (double)threshold) * ((f->mean_radius_min + f->mean_radius_max) * 0.5f);
}

static bool part_passes(const far_twin* t, const scree_id* id) {
  const scree_layer* layer = &t->w->layers[t->layer];
  uint64_t hash = hash_corner(t->w->fields[t->layer]->seed ^ UINT64_C(0xd1b54a32d192ed03), id->cube[0], id->cube[1], id->cube[2]);
  return layer->density == 0 || (double)(hash_combine(hash, id->local) >> 11) * 0x1p-53 < (double)layer->density;
}

static bool part_exists(const far_twin* t, const int64_t part[3]) {
  scree_id id;
  float d = part_distance(t, part, &id);
  if (d > part_offset(t) || (t->w->layers[t->layer].shell_depth > 0 && d <= -t->shell)) return false;
  return part_passes(t, &id);
}

/* Whether a part exists because the support is too thin for middles. */
static bool part_is_thin(const far_twin* t, const int64_t part[3]) {
  const scree_field* f = t->w->fields[t->layer];
  double width = f->cell_size * t->scale * f->cells_per_cube * 0.5, steepest = scree_rt_support_lipschitz(t->w->supports[t->layer]);
  scree_id id, other;
  float d = part_distance(t, part, &id), offset = part_offset(t), rise[3], most = 0;
  bool nearest[3], some = false;
  if (!(d > offset && (double)d <= (double)offset + width * 0.5 * fmax(steepest, 1))) return false;
  for (int a = 0; a < 3; ++a) {
    int64_t after[3] = {part[0], part[1], part[2]}, before[3] = {part[0], part[1], part[2]};
    ++after[a];
    --before[a];
    float d_after = part_distance(t, after, &other), d_before = part_distance(t, before, &other);
    rise[a] = fmaxf(d_after, d_before) - d;
    most = fmaxf(most, rise[a]);
    nearest[a] = d < d_after && d <= d_before;
  }
  for (int a = 0; a < 3; ++a) some = some || (nearest[a] && rise[a] >= most * 0.7f);
  return some && part_passes(t, &id);
}

static void far_field_equals_its_plain_twin(void** state) {
  (void)state;
  random_stream r = {24};
  scree_scratch* scratch = make_scratch();
  uint64_t wholes = 0, singles = 0, culled = 0, thin = 0;
  for (int round = 0; round < 80; ++round) {
    world w;
    round % 2 ? make_world(&w, &r, 1) : make_thick_world(&w, &r);
    for (uint32_t i = 0; i < w.count; ++i) w.layers[i].filter_count = 0;
    scree_scene_destroy(w.scene);
    assert_int_equal(scree_scene_create(&w.desc, NULL, &w.scene, NULL), SCREE_OK);
    uint32_t k = random_below(&r, w.count), level = random_below(&r, 4);
    const scree_field* f = w.fields[k];
    far_twin t = {&w, k, (double)(1u << level), w.layers[k].shell_depth};
    double size = f->cell_size * f->cells_per_cube * t.scale, origin[3];
    float thickest = (float)(size * scree_rt_support_lipschitz(w.supports[k]));
    if (t.shell < thickest) t.shell = thickest;
    int32_t low[3], high[3], c[3];
    for (int a = 0; a < 3; ++a) {
      low[a] = (int32_t)floor((w.middle[a] - 12 - f->origin[a]) / size) + (int32_t)random_below(&r, 2);
      high[a] = (int32_t)ceil((w.middle[a] + 12 - f->origin[a]) / size) - (int32_t)random_below(&r, 2);
      if (high[a] <= low[a]) high[a] = low[a] + 1;
      origin[a] = w.middle[a] + 5;
    }
    const scree_rock* found;
    uint64_t count, expected = 0;
    assert_int_equal(scree_rt_scene_far(w.scene, k, level, low, high, origin, scratch, &found, &count), SCREE_OK);
    scene_rocks sorted = {malloc((count + 1) * sizeof *sorted.rocks), count};
    assert_non_null(sorted.rocks);
    if (count > 0) memcpy(sorted.rocks, found, count * sizeof *found);
    scene_rocks_sort(&sorted);
    for (c[2] = low[2]; c[2] < high[2]; ++c[2])
      for (c[1] = low[1]; c[1] < high[1]; ++c[1])
        for (c[0] = low[0]; c[0] < high[0]; ++c[0]) {
          uint32_t shown = 0, thin_ones = 0;
          for (uint32_t p = 0; p < 8; ++p) {
            const int64_t part[3] = {2 * (int64_t)c[0] + (p & 1), 2 * (int64_t)c[1] + (p >> 1 & 1), 2 * (int64_t)c[2] + (p >> 2)};
            if (part_is_thin(&t, part)) thin_ones |= 1u << p;
            if (!part_exists(&t, part)) continue;
            bool hidden = true;
            for (int i = 0; i < 27 && hidden; ++i) {
              const int64_t next[3] = {part[0] + i % 3 - 1, part[1] + i / 3 % 3 - 1, part[2] + i / 9 - 1};
              hidden = part_exists(&t, next);
            }
            culled += hidden;
            if (!hidden) shown |= 1u << p;
          }
          for (uint32_t p = 0; p < 9; ++p) {
            if (!(p == 0 ? shown == 0xff : shown != 0xff && ((shown | thin_ones) >> (p - 1) & 1))) continue;
            if (p > 0) thin += thin_ones >> (p - 1) & 1;
            assert_true(expected < sorted.count);
            const scree_rock* rock = &sorted.rocks[expected++];
            assert_memory_equal(rock->id.cube, c, sizeof c);
            assert_int_equal(rock->id.local, p);
            assert_int_equal(rock->id.layer, scree_scene_layer(w.scene, k)->key);
            assert_int_equal(rock->asset, f->asset_count + 9 * scree_field_tile_code(f, c) + p);
            for (int a = 0; a < 3; ++a) { /* the tile starts where its cube does */
              double min[3], max[3];
              scree_rt_scene_cubes_box(w.scene, k, level, c, c, min, max);
              double start = origin[a] + (double)rock->position[a] - f->cell_size * t.scale * 0.5;
              assert_true(fabs(start - min[a]) < 1e-4);
            }
            *(p == 0 ? &wholes : &singles) += 1;
          }
        }
    assert_int_equal(expected, count);
    free(sorted.rocks);
    destroy_world(&w);
  }

  assert_true(wholes > 20 && singles > 1000 && culled > 1000 && thin > 80);
  scree_scratch_destroy(scratch);
}

/* One layer of a field of N cells a cube of 1 m; parts are N / 2 m wide. */
typedef struct far_layer {
  synthetic_source source;
  scree_field* field;
  scree_support* support;
  scree_scene* scene;
  double width; /* of a part */
} far_layer;

static void make_far_layer(far_layer* l, random_stream* r, uint32_t n, const scree_shape* shapes, uint32_t shape_count) {
  l->source = synthetic_create(n, 1, 1, random_bits(r));
  scree_field_desc field = {.seed = random_bits(r), .cell_size = 1};
  for (int a = 0; a < 3; ++a) field.origin[a] = random_in(r, -(double)n, n);
  assert_int_equal(scree_rt_field_create_from_source(&field, &l->source.source, NULL, &l->field), SCREE_OK);
  scree_support_desc desc = {.shapes = shapes, .shape_count = shape_count};
  assert_int_equal(scree_support_create(&desc, NULL, &l->support, NULL), SCREE_OK);
  scree_layer layer = {.field = l->field, .support = l->support};
  assert_int_equal(scree_scene_create(&(scree_scene_desc){&layer, 1}, NULL, &l->scene, NULL), SCREE_OK);
  l->width = n * 0.5;
}

static void free_far_layer(far_layer* l) {
  scree_scene_destroy(l->scene);
  scree_support_destroy(l->support);
  scree_field_destroy(l->field);
  synthetic_destroy(&l->source);
}

/* The box of a proxy, in the world. */
static void proxy_box(const far_layer* l, const scree_rock* rock, double low[3], double high[3]) {
  uint32_t n = l->field->cells_per_cube;
  for (int a = 0; a < 3; ++a) {
    double start = l->field->origin[a] - 0.5 + (double)n * rock->id.cube[a], middle = start + (n + 1) / 2;
    bool upper = rock->id.local > 0 && ((rock->id.local - 1u) >> a & 1);
    low[a] = upper ? middle : start;
    high[a] = rock->id.local == 0 || upper ? start + n : middle;
  }
}

static const int32_t FAR_LOW[3] = {-9, -9, -9}, FAR_HIGH[3] = {10, 10, 10}; /* cubes, to 8 N metres at least */

/* Flat sheets, bent ones and heightfields, from a tenth of a part to two parts thick, at every slope. */
static void far_field_of_a_thin_layer_has_no_holes(void** state) {
  (void)state;
  random_stream r = {77};
  scree_scratch* scratch = make_scratch();
  enum { SIDE = 33, POINTS = 1000 };
  for (int round = 0; round < 60; ++round) {
    uint32_t n = 3 + random_below(&r, 4);
    double s = n * 0.5, thickness = s * random_in(&r, 0.1, round % 2 ? 0.6 : 2), radius = s * random_in(&r, 5, 9), side = 0.5 * s;
    double steep = random_in(&r, 0, 1.5), along[2] = {random_in(&r, -1, 1), random_in(&r, -1, 1)}, bend = random_in(&r, 4, 10) * s;
    float heights[SIDE * SIDE];
    for (int i = 0; i < SIDE * SIDE; ++i) {
      double x = (i % SIDE - SIDE / 2) * side, z = (i / SIDE - SIDE / 2) * side; /* NOLINT(bugprone-integer-division) */
      heights[i] = (float)(steep * (along[0] * x + along[1] * z) + steep * bend * 0.2 * sin(x / bend * 2) * cos(z / bend * 2));
    }
    static const uint32_t shell[] = {1, 2};
    scree_shape shapes[3] = {{.kind = SCREE_SHAPE_DIFFERENCE, .group = {shell, 2, 0}},
                             {.kind = SCREE_SHAPE_SPHERE, .sphere = {(float)(radius + thickness * 0.5)}},
                             {.kind = SCREE_SHAPE_SPHERE, .sphere = {(float)(radius - thickness * 0.5)}}};
    uint32_t shape_count = 3, kind = (uint32_t)round % 3;
    double turned[3][3];
    if (kind == 1) {
      shape_count = 1;
      shapes[0] =
          (scree_shape){.kind = SCREE_SHAPE_HEIGHTFIELD,
                        .heightfield = {heights, SIDE, SIDE, (float)side, (float)thickness * 0.5f, (float)thickness * 0.5f}};
    }
    if (kind == 2) {
      shape_count = 1;
      shapes[0] = (scree_shape){.kind = SCREE_SHAPE_BOX, .box = {{(float)(6 * s), (float)(thickness * 0.5), (float)(6 * s)}, 0}};
      random_rotation(&r, shapes[0].transform.rotation);
      double q[4];
      for (int i = 0; i < 4; ++i) q[i] = (double)shapes[0].transform.rotation[i];
      for (int i = 0; i < 3; ++i) { /* columns: where the box's axes point */
        int j = (i + 1) % 3, k = (i + 2) % 3;
        turned[i][i] = 1 - 2 * (q[j] * q[j] + q[k] * q[k]);
        turned[j][i] = 2 * (q[i] * q[j] + q[3] * q[k]);
        turned[k][i] = 2 * (q[i] * q[k] - q[3] * q[j]);
      }
    }
    far_layer l;
    make_far_layer(&l, &r, n, shapes, shape_count);
    const scree_rock* parts;
    uint64_t count;
    const double origin[3] = {0, 0, 0};
    assert_int_equal(scree_rt_scene_far(l.scene, 0, 0, FAR_LOW, FAR_HIGH, origin, scratch, &parts, &count), SCREE_OK);
    double worst = 0;
    for (int p = 0; p < POINTS; ++p) {
      double at[3], u = random_in(&r, -5, 5) * s, v = random_in(&r, -5, 5) * s;
      if (kind == 1) { /* at the samples, where no bilinear patch is to be followed */
        uint32_t i = random_below(&r, SIDE * SIDE);
        at[0] = ((int)(i % SIDE) - SIDE / 2) * side;
        at[1] = (double)heights[i];
        at[2] = ((int)(i / SIDE) - SIDE / 2) * side;
        if (fabs(at[1]) > 7 * n || fabs(at[0]) > 6 * s || fabs(at[2]) > 6 * s) continue;
      } else if (kind == 2) {
        for (int a = 0; a < 3; ++a) at[a] = turned[a][0] * u + turned[a][2] * v;
      } else {
        double length2 = 0;
        for (int a = 0; a < 3; ++a) {
          at[a] = random_in(&r, -1, 1);
          length2 += at[a] * at[a];
        }
        for (int a = 0; a < 3; ++a) at[a] *= radius / sqrt(length2 + 1e-9);
      }
      double nearest = INFINITY;
      for (uint64_t i = 0; i < count; ++i) {
        double low[3], high[3], d2 = 0;
        proxy_box(&l, &parts[i], low, high);
        for (int a = 0; a < 3; ++a) {
          double d = fmax(fmax(low[a] - at[a], at[a] - high[a]), 0);
          d2 += d * d;
        }
        nearest = fmin(nearest, d2);
      }
      worst = fmax(worst, sqrt(nearest) / s);
    }

    assert_true(worst < 0.45); /* of a part */
    free_far_layer(&l);
  }
  scree_scratch_destroy(scratch);
}

static void far_field_of_a_thick_support_lies_inside(void** state) {
  (void)state;
  random_stream r = {78};
  scree_scratch* scratch = make_scratch();
  uint64_t all = 0, outside = 0;
  for (int round = 0; round < 30; ++round) {
    uint32_t n = 3 + random_below(&r, 4);
    float s = (float)n * 0.5f;
    scree_shape shapes[2] = {{.kind = SCREE_SHAPE_NOISE, .noise = {1, 0.5f * s, 8 * s, 1, 1}}};
    scree_shape* shape = &shapes[round % 2];
    *shape = round % 4 < 2 ? (scree_shape){.kind = SCREE_SHAPE_BOX, .box = {{5 * s, 4 * s, 6 * s}, 0}}
                           : (scree_shape){.kind = SCREE_SHAPE_SPHERE, .sphere = {6 * s}};
    if (round % 2) shapes[0] = (scree_shape){.kind = SCREE_SHAPE_NOISE, .noise = {1, 0.5f * s, 8 * s, 1, 1}};
    random_rotation(&r, shape->transform.rotation);
    far_layer l;
    make_far_layer(&l, &r, n, shapes, 1 + (uint32_t)round % 2);
    const scree_rock* parts;
    uint64_t count;
    const double origin[3] = {0, 0, 0};
    assert_int_equal(scree_rt_scene_far(l.scene, 0, 0, FAR_LOW, FAR_HIGH, origin, scratch, &parts, &count), SCREE_OK);
    for (uint64_t i = 0; i < count; ++i) {
      double low[3], high[3];
      float at[3], d;
      proxy_box(&l, &parts[i], low, high);
      for (int a = 0; a < 3; ++a) at[a] = (float)((low[a] + high[a]) * 0.5);
      scree_support_distance(l.support, &at[0], &at[1], &at[2], &d, 1);
      ++all;
      outside += parts[i].id.local > 0 && d > 1e-3f;
    }
    free_far_layer(&l);
  }
  assert_true(all > 10000 && outside * 25 < all);
  scree_scratch_destroy(scratch);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(one_layer_equals_its_plain_twin),
      cmocka_unit_test(what_is_visible_equals_its_plain_twin),
      cmocka_unit_test(overlapping_layers_equal_their_plain_twin),
      cmocka_unit_test(blocks_of_any_size_and_order_make_up_the_whole),
      cmocka_unit_test(scene_far_from_the_origin_is_the_same_scene),
      cmocka_unit_test(origin_decides_positions_and_nothing_else),
      cmocka_unit_test(rock_is_found_by_its_id_with_why_it_is_there_or_not),
      cmocka_unit_test(far_field_equals_its_plain_twin),
      cmocka_unit_test(far_field_of_a_thin_layer_has_no_holes),
      cmocka_unit_test(far_field_of_a_thick_support_lies_inside),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
