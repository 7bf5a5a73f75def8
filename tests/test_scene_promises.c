/* What scenes promise beside their answers: no allocation in steady state, nothing lost when memory is short, threads that share,
 * edits that touch their neighbourhood and nothing else, layers that never meet, and descriptions that are refused. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <scree/threads.h>

#include "convex.h"
#include "random_world.h"

/* --- memory ---------------------------------------------------------------------------------------------------------------- */

typedef struct counter {
  uint64_t calls, live; /* bytes that are held */
  uint64_t fail_at;     /* the call with this number fails; 0 = none */
} counter;

static void* counted_alloc(void* user, size_t size) {
  counter* c = user;
  if (++c->calls == c->fail_at) return NULL;
  size_t rounded = (size + 63) / 64 * 64;
  void* memory = aligned_alloc(64, rounded > 0 ? rounded : 64);
  if (memory != NULL) c->live += size;
  return memory;
}

static void counted_release(void* user, void* memory, size_t size) {
  ((counter*)user)->live -= size;
  free(memory);
}

static scree_allocator counting(counter* c) {
  return (scree_allocator){counted_alloc, counted_release, c};
}

/* Asks a scene everything once. */
static scree_result ask_everything(const world* w, scree_scratch* scratch, uint64_t answers[8]) {
  scree_result result = SCREE_OK;
  scree_scene_query_desc d = {.scene = w->scene, .edits = w->edits};
  for (int a = 0; a < 3; ++a) {
    d.min[a] = w->middle[a] - 8;
    d.max[a] = w->middle[a] + 8;
  }
  for (uint32_t i = 0; i < 2 && result == SCREE_OK; ++i) {
    d.flags = i;
    result = scree_scene_count(&d, scratch, &answers[i]);
  }
  const scree_rock* rocks;
  int32_t low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    const scree_field* f = w->fields[w->count - 1];
    low[a] = (int32_t)floor((w->middle[a] - f->origin[a]) / f->cell_size / f->cells_per_cube) - 1;
    high[a] = low[a] + 3;
  }
  if (result == SCREE_OK)
    result = scree_rt_scene_block(w->scene, w->edits, w->count - 1, low, high, w->middle, true, scratch, &rocks, &answers[2]);
  scree_id id = {{low[0], low[1], low[2]}, 0, scree_scene_layer(w->scene, w->count - 1)->key};
  if (result == SCREE_OK && answers[2] > 0) id = rocks[0].id;
  if (result == SCREE_OK)
    result = scree_rt_scene_far(w->scene, w->count - 1, 0, low, high, w->middle, scratch, &rocks, &answers[3]);
  scree_rock_state state = SCREE_ROCK_UNKNOWN;
  if (result == SCREE_OK) result = scree_scene_find(w->scene, w->edits, scratch, &id, w->middle, NULL, &state);
  answers[4] = (uint64_t)state;
  return result;
}

static void nothing_allocates_in_steady_state(void** state) {
  (void)state;
  random_stream r = {31};
  for (int round = 0; round < 8; ++round) {
    world w;
    if (round % 2) {
      make_world(&w, &r, 3);
    } else {
      make_thick_world(&w, &r);
    }
    counter c = {0, 0, 0};
    scree_allocator allocator = counting(&c);
    scree_scratch* scratch;
    assert_int_equal(scree_scratch_create(&allocator, &scratch), SCREE_OK);
    uint64_t first[8] = {0}, second[8] = {0};
    assert_int_equal(ask_everything(&w, scratch, first), SCREE_OK);
    uint64_t calls = c.calls;
    assert_int_equal(ask_everything(&w, scratch, second), SCREE_OK);
    assert_memory_equal(first, second, sizeof first);
    assert_int_equal(c.calls, calls);
    scree_scratch_destroy(scratch);
    assert_int_equal(c.live, 0);
    destroy_world(&w);
  }
}

static void every_allocation_may_fail(void** state) {
  (void)state;
  random_stream r = {32};
  for (int round = 0; round < 6; ++round) {
    world w;
    if (round % 2) {
      make_world(&w, &r, 3);
    } else {
      make_thick_world(&w, &r);
    }
    uint64_t expected[8] = {0};
    scree_scratch* good = make_scratch();
    assert_int_equal(ask_everything(&w, good, expected), SCREE_OK);
    scree_scratch_destroy(good);

    counter c = {0, 0, 0};
    scree_allocator allocator = counting(&c);
    scree_scene* scene = NULL;
    scree_error error;
    for (uint64_t nth = 1;; ++nth) {
      c.calls = 0;
      c.fail_at = nth;
      scree_result result = scree_scene_create(&w.desc, &allocator, &scene, &error);
      if (c.calls < nth) {
        assert_int_equal(result, SCREE_OK);
        assert_true(nth > 2);
        break;
      }
      assert_int_equal(result, SCREE_ERROR_OUT_OF_MEMORY);
      assert_null(scene);
      assert_string_equal(error.message, "out of memory");
      assert_int_equal(c.live, 0);
    }
    scree_scene_destroy(scene);
    assert_int_equal(c.live, 0);

    bool done = false;
    for (uint64_t nth = 1; !done; ++nth) {
      c = (counter){0, 0, nth};
      scree_scratch* scratch;
      scree_result result = scree_scratch_create(&allocator, &scratch);
      assert_int_equal(result, nth == 1 ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_OK);
      if (nth == 1) continue;
      uint64_t answers[8] = {0};
      result = ask_everything(&w, scratch, answers);
      done = c.calls < nth;
      assert_int_equal(result, done ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY);
      assert_int_equal(ask_everything(&w, scratch, answers), SCREE_OK); /* the same scratch is good again */
      assert_memory_equal(expected, answers, sizeof answers);
      scree_scratch_destroy(scratch);
      assert_int_equal(c.live, 0);
      assert_true(!done || nth > 5);
    }
    destroy_world(&w);
  }
}

/* --- threads --------------------------------------------------------------------------------------------------------------- */

typedef struct shared_question {
  const world* w;
  scree_scratch* scratch[5];
  uint64_t expected[8];
  uint32_t wrong[5];
} shared_question;

static void ask_in_thread(void* context, uint32_t index, uint32_t worker) {
  (void)index;
  shared_question* q = context;
  uint64_t answers[8] = {0};
  if (ask_everything(q->w, q->scratch[worker], answers) != SCREE_OK || memcmp(answers, q->expected, sizeof answers) != 0)
    ++q->wrong[worker];
}

static void threads_share_one_scene(void** state) {
  (void)state;
  scree_threads* threads;
  if (scree_threads_create(4, NULL, &threads) != SCREE_OK) skip();
  scree_jobs jobs = scree_threads_jobs(threads);
  assert_true(jobs.worker_count <= 5);
  random_stream r = {33};
  for (int round = 0; round < 3; ++round) {
    world w;
    make_world(&w, &r, 3);
    shared_question q = {.w = &w};
    for (int i = 0; i < 5; ++i) q.scratch[i] = make_scratch();
    assert_int_equal(ask_everything(&w, q.scratch[0], q.expected), SCREE_OK);
    jobs.parallel_for(jobs.user, 20, ask_in_thread, &q);
    for (int i = 0; i < 5; ++i) {
      assert_int_equal(q.wrong[i], 0);
      scree_scratch_destroy(q.scratch[i]);
    }
    destroy_world(&w);
  }
  scree_threads_destroy(threads);
}

/* --- edits ----------------------------------------------------------------------------------------------------------------- */

static bool has_id(const scene_rocks* rocks, const scree_id* id) {
  for (uint64_t i = 0; i < rocks->count; ++i)
    if (memcmp(&rocks->rocks[i].id, id, sizeof *id) == 0) return true;
  return false;
}

static void an_edit_changes_its_rock_and_what_comes_into_view_near_it(void** state) {
  (void)state;
  random_stream r = {34};
  scree_scratch* scratch = make_scratch();
  uint64_t uncovered = 0;
  for (int round = 0; round < 16; ++round) {
    world w;
    if (round % 2) {
      make_world(&w, &r, 3);
    } else {
      make_thick_world(&w, &r);
    }
    scree_scene_query_desc d = {.scene = w.scene, .edits = w.edits};
    for (int a = 0; a < 3; ++a) {
      d.origin[a] = w.middle[a];
      d.min[a] = w.middle[a] - 7;
      d.max[a] = w.middle[a] + 7;
    }
    for (int k = 0; k < 4; ++k) {
      d.flags = 0;
      scene_rocks before = ask_scene(&d, scratch);
      d.flags = SCREE_SCENE_VISIBLE;
      scene_rocks seen_before = ask_scene(&d, scratch);
      if (before.count == 0) {
        scene_rocks_free(&before);
        scene_rocks_free(&seen_before);
        break;
      }
      const scree_rock rock = before.rocks[random_bits(&r) % before.count];
      scree_edit edit = random_below(&r, 2) ? SCREE_EDIT_REMOVE : SCREE_EDIT_HIDE;
      assert_int_equal(scree_edits_set(w.edits, &rock.id, edit), SCREE_OK);
      d.flags = 0;
      scene_rocks after = ask_scene(&d, scratch);
      d.flags = SCREE_SCENE_VISIBLE;
      scene_rocks seen_after = ask_scene(&d, scratch);

      assert_int_equal(after.count, before.count - (edit == SCREE_EDIT_REMOVE));
      assert_int_equal(scene_rocks_missing(&before, &after), 0);
      assert_int_equal(has_id(&after, &rock.id), edit == SCREE_EDIT_HIDE);

      double reach = scree_rt_scene_reach(w.scene, scree_scene_layer_of(w.scene, rock.id.layer));
      assert_false(has_id(&seen_after, &rock.id));
      assert_int_equal(scene_rocks_missing(&seen_after, &seen_before), has_id(&seen_before, &rock.id));
      for (uint64_t i = 0; i < seen_after.count; ++i) {
        if (has_id(&seen_before, &seen_after.rocks[i].id)) continue;
        ++uncovered;
        double away2 = 0;
        for (int a = 0; a < 3; ++a) {
          double away = (double)seen_after.rocks[i].position[a] - (double)rock.position[a];
          away2 += away * away;
        }
        assert_true(away2 < reach * reach);
        assert_int_equal(seen_after.rocks[i].id.layer, rock.id.layer);
      }
      assert_int_equal(scree_edits_set(w.edits, &rock.id, SCREE_EDIT_NONE), SCREE_OK);
      scene_rocks restored = ask_scene(&d, scratch);
      assert_scene_rocks_equal(&seen_before, &restored);
      scene_rocks* all[] = {&before, &after, &seen_before, &seen_after, &restored};
      for (int i = 0; i < 5; ++i) scene_rocks_free(all[i]);
    }
    destroy_world(&w);
  }
  assert_true(uncovered > 50);
  scree_scratch_destroy(scratch);
}

/* --- layers ---------------------------------------------------------------------------------------------------------------- */

/* Where the layers were thousands of rocks deep in one another, no two that are kept meet: every pair is looked at. */
static void no_two_kept_rocks_of_different_layers_meet(void** state) {
  (void)state;
  random_stream r = {35};
  scree_scratch* scratch = make_scratch();
  uint64_t pairs = 0, dropped = 0;
  for (int round = 0; round < 40; ++round) {
    world w;
    if (round % 4) {
      make_world(&w, &r, 4);
    } else {
      make_mixed_world(&w, &r, 3);
    }
    scree_scene_query_desc d = {.scene = w.scene};
    for (int a = 0; a < 3; ++a) {
      d.min[a] = w.middle[a] - 9;
      d.max[a] = w.middle[a] + 9;
    }
    scene_rocks rocks = ask_scene(&d, scratch);
    for (uint32_t k = 0; k < w.count; ++k) { /* each layer alone has more */
      scree_scene_desc alone = {&w.layers[k], 1};
      scree_scene* single;
      assert_int_equal(scree_scene_create(&alone, NULL, &single, NULL), SCREE_OK);
      scree_scene_query_desc e = d;
      e.scene = single;
      uint64_t count;
      assert_int_equal(scree_scene_count(&e, scratch, &count), SCREE_OK);
      dropped += count;
      scree_scene_destroy(single);
    }
    dropped -= rocks.count;
    for (uint64_t i = 0; i < rocks.count; ++i)
      for (uint64_t k = i + 1; k < rocks.count; ++k) {
        const scree_rock* pair[2] = {&rocks.rocks[i], &rocks.rocks[k]};
        if (pair[0]->id.layer == pair[1]->id.layer) continue;
        float xyz[2][3][FIELD_MAX_HULL];
        convex_hull hulls[2];
        double away2 = 0, most = 0;
        for (int side = 0; side < 2; ++side) {
          const scene_layer* layer = &w.scene->layers[scree_scene_layer_of(w.scene, pair[side]->id.layer)];
          const scree_field* field = layer->given.field;
          hulls[side] = (convex_hull){.x = xyz[side][0], .y = xyz[side][1], .z = xyz[side][2]};
          hulls[side].scale = field->cell_size / field->lattice_per_cell;
          int64_t cell[3];
          rock_cell(field, &pair[side]->id, cell);
          cell_centre(layer, cell, hulls[side].at);
          most += 2 * field->cell_size;
        }
        for (int a = 0; a < 3; ++a) away2 += (hulls[0].at[a] - hulls[1].at[a]) * (hulls[0].at[a] - hulls[1].at[a]);
        if (away2 > most * most) continue;
        for (int side = 0; side < 2; ++side) {
          const scree_field* field = w.fields[scree_scene_layer_of(w.scene, pair[side]->id.layer)];
          hulls[side].count = scree_rt_field_hull(field, pair[side]->asset, xyz[side][0], xyz[side][1], xyz[side][2]);
          for (int a = 0; side == 1 && a < 3; ++a) hulls[1].at[a] -= hulls[0].at[a];
        }
        memset(hulls[0].at, 0, sizeof hulls[0].at);
        ++pairs;
        assert_false(scree_rt_convex_meet(&hulls[0], &hulls[1]));
      }
    scene_rocks_free(&rocks);
    destroy_world(&w);
  }
  assert_true(pairs > 1000 && dropped > 1000);
  scree_scratch_destroy(scratch);
}

static void scene_bounds_hold_all_supports(void** state) {
  (void)state;
  random_stream r = {36};
  for (int round = 0; round < 10; ++round) {
    world w;
    make_world(&w, &r, 3);
    double min[3], max[3], low[3], high[3];
    scree_scene_bounds(w.scene, min, max);
    for (int a = 0; a < 3; ++a) {
      double least = INFINITY, most = -INFINITY;
      for (uint32_t k = 0; k < 3; ++k) {
        scree_support_bounds(w.supports[k], low, high);
        if (high[0] == low[0] && high[1] == low[1] && high[2] == low[2]) continue; /* empty */
        least = fmin(least, low[a]);
        most = fmax(most, high[a]);
      }
      if (least <= most) assert_true(min[a] == least && max[a] == most);
    }
    for (uint32_t k = 0; k < 3; ++k) {
      const scree_layer* layer = scree_scene_layer(w.scene, k);
      assert_int_equal(scree_scene_layer_of(w.scene, layer->key), k);
      scree_id id = {{1, 2, 3}, 4, layer->key};
      assert_int_equal(scree_scene_random(w.scene, &id), scree_world_hash(w.fields[k], &id));
      assert_ptr_equal(layer->field, w.fields[k]);
    }
    assert_int_equal(scree_scene_layer_count(w.scene), 3);
    assert_null(scree_scene_layer(w.scene, 3));
    assert_int_equal(scree_scene_layer_of(w.scene, 12345), UINT32_MAX);
    destroy_world(&w);
  }
}

/* --- what is refused ------------------------------------------------------------------------------------------------------- */

static void wrong_scenes_are_refused_by_name(void** state) {
  (void)state;
  random_stream r = {37};
  world w;
  make_thick_world(&w, &r);
  const float image[4] = {0, 0.5f, 1, 0.25f};
  const scree_filter mask = {.kind = SCREE_FILTER_MASK, .values = image, .width = 2, .depth = 2, .spacing = 1};
  const scree_filter height = {.kind = SCREE_FILTER_ALTITUDE, .from = 1, .to = 2};
  scree_filter filters[17];
  scree_layer layers[2];
  scree_error error;
  scree_scene* scene;
#define REFUSED(code, words, change)                                             \
  do {                                                                           \
    for (int i = 0; i < 17; ++i) filters[i] = i % 2 ? height : mask;             \
    for (int i = 0; i < 2; ++i) {                                                \
      layers[i] = (scree_layer){.field = w.fields[0], .support = w.supports[0]}; \
      layers[i].filters = filters;                                               \
      layers[i].filter_count = 2;                                                \
    }                                                                            \
    scree_scene_desc desc = {layers, 2};                                         \
    change;                                                                      \
    assert_int_equal(scree_scene_create(&desc, NULL, &scene, &error), code);     \
    if (strstr(error.message, words) == NULL) fail_msg("%s", error.message);     \
    scree_scene_destroy(scene);                                                  \
    assert_int_equal(scree_scene_create(&desc, NULL, &scene, NULL), code);       \
    scree_scene_destroy(scene);                                                  \
  } while (0)
  REFUSED(SCREE_OK, "", (void)0);
  scree_scene_create(NULL, NULL, &scene, &error);
  assert_string_equal(error.message, "desc is NULL");
  REFUSED(SCREE_ERROR_INVALID_ARGUMENT, "layers is NULL", desc.layers = NULL);
  REFUSED(SCREE_ERROR_RANGE, "layer_count is 0", desc.layer_count = 0);
  REFUSED(SCREE_ERROR_RANGE, "layer_count is 65", desc.layer_count = 65);
  REFUSED(SCREE_ERROR_INVALID_ARGUMENT, "layer 1: field is NULL", layers[1].field = NULL);
  REFUSED(SCREE_ERROR_INVALID_ARGUMENT, "layer 0: support is NULL", layers[0].support = NULL);
  REFUSED(SCREE_ERROR_INVALID_ARGUMENT, "layer 1: key 7 is also that of layer 0", layers[0].key = layers[1].key = 7);
  REFUSED(SCREE_ERROR_RANGE, "layer 0: threshold is 1", layers[0].threshold = 1);
  REFUSED(SCREE_ERROR_RANGE, "layer 0: threshold is not a number", layers[0].threshold = NAN);
  REFUSED(SCREE_ERROR_RANGE, "shell_depth is -1", layers[1].shell_depth = -1);
  REFUSED(SCREE_ERROR_RANGE, "shell_depth is infinity", layers[1].shell_depth = INFINITY);
  REFUSED(SCREE_ERROR_RANGE, "density is 1.5", layers[1].density = 1.5f);
  REFUSED(SCREE_ERROR_RANGE, "16 at most", layers[1].filter_count = 17);
  REFUSED(SCREE_ERROR_INVALID_ARGUMENT, "filters is NULL", layers[0].filters = NULL);
  REFUSED(SCREE_ERROR_INVALID_ARGUMENT, "layer 0, filter 1: no such kind", filters[1].kind = (scree_filter_kind)3);
  REFUSED(SCREE_ERROR_INVALID_ARGUMENT, "filter 0: values is NULL", filters[0].values = NULL);
  REFUSED(SCREE_ERROR_RANGE, "width is 1", filters[0].width = 1);
  REFUSED(SCREE_ERROR_RANGE, "depth is 1", filters[0].depth = 1);
  REFUSED(SCREE_ERROR_RANGE, "spacing is 0", filters[0].spacing = 0);
  REFUSED(SCREE_ERROR_RANGE, "centre", filters[0].centre[2] = NAN);
  const float bad[4] = {0, 0.5f, 1.25f, 0.25f}, none[4] = {0, NAN, 1, 0};
  REFUSED(SCREE_ERROR_RANGE, "a value is 1.25", filters[0].values = bad);
  REFUSED(SCREE_ERROR_RANGE, "a value is not a number", filters[0].values = none);
  REFUSED(SCREE_OK, "", (filters[0].values = bad, filters[0].kind = SCREE_FILTER_SLOPE));
  REFUSED(SCREE_ERROR_RANGE, "from", filters[1].from = NAN);
  REFUSED(SCREE_ERROR_RANGE, "to is 0.5", filters[1].to = 0.5f);
  REFUSED(SCREE_ERROR_RANGE, "fade is -1", filters[1].fade = -1);
#undef REFUSED
  destroy_world(&w);
}

static void wrong_questions_are_refused(void** state) {
  (void)state;
  random_stream r = {38};
  world w;
  make_world(&w, &r, 2);
  scree_scratch* scratch = make_scratch();
  uint64_t count = 9;
  scree_rock rock;
  scree_rock_state found;
  const scree_id id = {{0, 0, 0}, 0, 0};
  const double here[3] = {0, 0, 0}, nowhere[3] = {0, NAN, 0};
  scree_scene_query_desc good = {.scene = w.scene, .max = {1, 1, 1}};
#define REFUSED(change)                                                                              \
  do {                                                                                               \
    scree_scene_query_desc d = good;                                                                 \
    change;                                                                                          \
    assert_int_equal(scree_scene_count(&d, scratch, &count), SCREE_ERROR_INVALID_ARGUMENT);          \
    assert_int_equal(count, 0);                                                                      \
    assert_int_equal(scree_scene_fill(&d, scratch, &rock, 1, &count), SCREE_ERROR_INVALID_ARGUMENT); \
  } while (0)
  REFUSED(d.scene = NULL);
  REFUSED(d.flags = 2);
  REFUSED(d.layers = 4);
  REFUSED(d.origin[1] = NAN);
  REFUSED(d.min[2] = 2);
  REFUSED(d.max[0] = NAN);
#undef REFUSED
  assert_int_equal(scree_scene_count(NULL, scratch, &count), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_scene_count(&good, NULL, &count), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_scene_count(&good, scratch, NULL), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_scene_fill(&good, scratch, NULL, 1, &count), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_scene_find(w.scene, NULL, scratch, NULL, here, NULL, &found), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_scene_find(w.scene, NULL, scratch, &id, nowhere, NULL, &found), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_scene_find(w.scene, NULL, scratch, &id, here, NULL, NULL), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_scratch_create(NULL, NULL), SCREE_ERROR_INVALID_ARGUMENT);
  scree_scratch_destroy(NULL);
  scree_scene_destroy(NULL);
  destroy_world(&w);

  /* An endless support has to be asked for in a box; boxes beyond the int32 cubes have no names. */
  make_thick_world(&w, &r);
  scree_shape ground = {.kind = SCREE_SHAPE_HALF_SPACE};
  scree_support_desc desc = {.shapes = &ground, .shape_count = 1};
  scree_support* endless;
  assert_int_equal(scree_support_create(&desc, NULL, &endless, NULL), SCREE_OK);
  scree_layer layer = {.field = w.fields[0], .support = endless};
  scree_scene_desc scene_desc = {&layer, 1};
  scree_scene* scene;
  assert_int_equal(scree_scene_create(&scene_desc, NULL, &scene, NULL), SCREE_OK);
  scree_scene_query_desc d = {.scene = scene};
  for (uint32_t flags = 0; flags < 2; ++flags) {
    d.flags = flags;
    memset(d.min, 0, sizeof d.min);
    memset(d.max, 0, sizeof d.max);
    assert_int_equal(scree_scene_count(&d, scratch, &count), SCREE_ERROR_RANGE);
    for (int a = 0; a < 3; ++a) d.min[a] = -3, d.max[a] = 3;
    assert_int_equal(scree_scene_count(&d, scratch, &count), SCREE_OK);
    assert_true(count > 10);
    d.min[1] = -1e300;
    assert_int_equal(scree_scene_count(&d, scratch, &count), SCREE_ERROR_RANGE);
  }
  scree_scene_destroy(scene);
  scree_support_destroy(endless);
  destroy_world(&w);
  scree_scratch_destroy(scratch);
}

static void fill_stops_at_the_capacity_and_counts_on(void** state) {
  (void)state;
  random_stream r = {39};
  world w;
  make_world(&w, &r, 3);
  scree_scratch* scratch = make_scratch();
  scree_scene_query_desc d = {.scene = w.scene};
  for (int a = 0; a < 3; ++a) {
    d.min[a] = w.middle[a] - 8;
    d.max[a] = w.middle[a] + 8;
  }
  uint64_t all, count;
  assert_int_equal(scree_scene_count(&d, scratch, &all), SCREE_OK);
  assert_true(all > 20);
  scree_rock* whole = calloc(all, sizeof *whole);
  assert_true(whole != NULL);
  assert_int_equal(scree_scene_fill(&d, scratch, whole, all, &count), SCREE_OK);
  for (uint64_t i = 1; i < all; ++i) /* layer by layer */
    assert_true(scree_scene_layer_of(w.scene, whole[i - 1].id.layer) <= scree_scene_layer_of(w.scene, whole[i].id.layer));
  for (uint64_t capacity = 0; capacity < all; capacity += 1 + all / 7) {
    scree_rock* exact = malloc(capacity * sizeof *exact + 1);
    assert_non_null(exact);
    assert_int_equal(scree_scene_fill(&d, scratch, exact, capacity, &count), SCREE_ERROR_CAPACITY);
    assert_int_equal(count, all);
    if (capacity > 0) assert_memory_equal(whole, exact, capacity * sizeof *exact);
    free(exact);
  }
  free(whole);
  scree_scratch_destroy(scratch);
  destroy_world(&w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(nothing_allocates_in_steady_state),
      cmocka_unit_test(every_allocation_may_fail),
      cmocka_unit_test(threads_share_one_scene),
      cmocka_unit_test(an_edit_changes_its_rock_and_what_comes_into_view_near_it),
      cmocka_unit_test(no_two_kept_rocks_of_different_layers_meet),
      cmocka_unit_test(scene_bounds_hold_all_supports),
      cmocka_unit_test(wrong_scenes_are_refused_by_name),
      cmocka_unit_test(wrong_questions_are_refused),
      cmocka_unit_test(fill_stops_at_the_capacity_and_counts_on),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
