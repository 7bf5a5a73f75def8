/* Streams of scenes with scatters against truth: models of a pack, models of the host's own, and rocks between them. */
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
#include "make_model_pack.h"
#include "must_create.h"
#include "scatter_internal.h"
#include "stream_host.h"
#include "synthetic_field.h"

enum { LAYERS = 3, BALLS = 5 };

/* Layer 0: models of the host's own on a disc with balls on and over it; 1: rocks; 2: models of a pack. */
typedef struct scatter_world {
  uint8_t* bytes[2];
  scree_pack* packs[2]; /* rocks, models */
  scree_field* field;
  scree_scatter* scatters[2];
  scree_shape shapes[LAYERS][BALLS + 2];
  scree_support* supports[LAYERS];
  scree_layer layers[LAYERS];
  scree_scene* scene;
  scree_edits* edits;
} scatter_world;

static const scree_scatter_model posts[2] = {{.footprint_radius = 0.2f, .height = 3}, {.footprint_radius = 0.5f, .height = 1}};

static scree_support* support_of(const scatter_world* w, uint32_t k) {
  return must_create(&(scree_support_desc){.shapes = w->shapes[k], .shape_count = BALLS + 2});
}

static scree_scene* scene_of(const scatter_world* w) {
  scree_scene* scene;
  scree_error error;
  if (scree_scene_create(&(scree_scene_desc){w->layers, LAYERS}, NULL, &scene, &error) != SCREE_OK) fail_msg("%s", error.message);
  return scene;
}

static void world_make(scatter_world* w, random_stream* r, bool proxies) {
  static const uint32_t children[] = {1, 2, 3, 4, 5, 6};
  memset(w, 0, sizeof *w);
  size_t size;
  w->bytes[0] = stream_pack_make(proxies, 3, 1, &size);
  assert_int_equal(scree_pack_open_memory(w->bytes[0], size, NULL, &w->packs[0]), SCREE_OK);
  w->bytes[1] = test_model_pack_make(&(test_models_desc){.variants = 3, .ages = 2, .lattice_per_cell = 32}, &size);
  assert_int_equal(scree_pack_open_memory(w->bytes[1], size, NULL, &w->packs[1]), SCREE_OK);
  const scree_field_desc field = {.pack = w->packs[0], .seed = 3, .cell_size = 1};
  assert_int_equal(scree_field_create(&field, NULL, &w->field), SCREE_OK);
  const scree_scatter_desc own = {.models = posts, .model_count = 2, .spacing = 1.1, .scale_min = 0.5f, .scale_max = 1.5f};
  const scree_scatter_desc packed = {
      .pack = w->packs[1], .spacing = 1.7, .seed = 8, .origin = {3, 1, 5}, .scale_min = 1, .scale_max = 2};
  scree_error error;
  if (scree_scatter_create(&own, NULL, &w->scatters[0], &error) != SCREE_OK) fail_msg("%s", error.message);
  if (scree_scatter_create(&packed, NULL, &w->scatters[1], &error) != SCREE_OK) fail_msg("%s", error.message);
  for (uint32_t k = 0; k < LAYERS; ++k) {
    w->shapes[k][0] = (scree_shape){.kind = SCREE_SHAPE_UNION, .group = {children, BALLS + 1, 0}};
    w->shapes[k][1] = (scree_shape){.kind = SCREE_SHAPE_CYLINDER, .cylinder = {k == 2 ? 36 : 30, k == 1 ? 1.1f : 1}};
    for (uint32_t i = 2; i < BALLS + 2; ++i) {
      w->shapes[k][i] = (scree_shape){.kind = SCREE_SHAPE_SPHERE, .sphere = {(float)random_in(r, 1.5, 6)}};
      for (int a = 0; a < 3; ++a)
        w->shapes[k][i].transform.translation[a] = (float)(a == 1 ? random_in(r, -4, 14) : random_in(r, -25, 25));
    }
    w->supports[k] = support_of(w, k);
    w->layers[k] = (scree_layer){.support = w->supports[k], .key = (uint16_t)(k + 4)};
  }
  w->layers[0].density = 0.4f;
  w->layers[1].density = 0.3f;
  w->layers[0].scatter = w->scatters[0];
  w->layers[1].field = w->field;
  w->layers[2].scatter = w->scatters[1];
  w->scene = scene_of(w);
  assert_int_equal(scree_edits_create(NULL, &w->edits), SCREE_OK);
}

static void world_free(scatter_world* w) {
  scree_scene_destroy(w->scene);
  scree_edits_destroy(w->edits);
  for (uint32_t k = 0; k < LAYERS; ++k) scree_support_destroy(w->supports[k]);
  for (int i = 0; i < 2; ++i) scree_scatter_destroy(w->scatters[i]);
  scree_field_destroy(w->field);
  for (int i = 0; i < 2; ++i) {
    scree_pack_close(w->packs[i]);
    free(w->bytes[i]);
  }
}

/* Instances of each layer that are shown. */
static void count_layers(const stream_host* h, uint32_t counts[LAYERS]) {
  memset(counts, 0, LAYERS * sizeof *counts);
  for (uint32_t k = 0; k < h->caps.blocks; ++k)
    if (h->blocks[k].shown && h->blocks[k].level == 0) counts[h->blocks[k].layer] += h->blocks[k].count;
}

static void shown_instances_and_levels_are_the_truth_wherever_the_view_goes(void** state) {
  (void)state;
  random_stream r = {1};
  scatter_world w;
  world_make(&w, &r, false);
  for (int round = 0; round < 3; ++round) {
    const scree_stream_desc desc = {.scene = w.scene,
                                    .edits = w.edits,
                                    .view_distance = 16 + 8 * round,
                                    .max_error_pixels = 3,
                                    .hysteresis = 0.3f,
                                    .fade_seconds = round == 1 ? 0.1f : 0,
                                    .deterministic = round == 2,
                                    .decode = stream_decode_pattern};
    stream_host h;
    host_create(&h, &desc, NULL);
    uint32_t most[LAYERS] = {0};
    for (int i = 0; i < 20; ++i) {
      scree_view view = host_view(random_in(&r, -30, 30), random_in(&r, -2, 12), random_in(&r, -30, 30));
      host_settle(&h, &view, 1, 500);
      host_check(&h);
      host_check_truth(&h, &view, 1, true);
      uint32_t counts[LAYERS];
      count_layers(&h, counts);
      for (int k = 0; k < LAYERS; ++k) most[k] = counts[k] > most[k] ? counts[k] : most[k];
      scree_stream_stats stats;
      scree_stream_get_stats(h.stream, &stats);
      assert_true(stats.complete);
    }
    assert_true(most[0] > 150 && most[1] > 150 && most[2] > 60);
    host_destroy(&h);
  }
  world_free(&w);
}

/* The shapes of a layer have changed. */
static void take_over(scatter_world* w, stream_host* h, uint32_t k) {
  scree_support* old = w->supports[k];
  scree_scene* before = w->scene;
  w->supports[k] = support_of(w, k);
  w->layers[k].support = w->supports[k];
  w->scene = scene_of(w);
  scree_stream_wait(h->stream);
  assert_int_equal(scree_stream_set_scene(h->stream, w->scene), SCREE_OK);
  h->desc.scene = w->scene;
  host_use_scene(h, w->scene);
  scree_scene_destroy(before);
  scree_support_destroy(old);
}

/* Balls of grounds rise, sink and fly over what stands; rocks and instances are removed and come back. */
static void changes_of_grounds_and_edits_end_in_the_truth(void** state) {
  (void)state;
  random_stream r = {2};
  scatter_world w;
  world_make(&w, &r, false);
  const scree_stream_desc desc = {.scene = w.scene,
                                  .edits = w.edits,
                                  .view_distance = 28,
                                  .max_error_pixels = 3,
                                  .hysteresis = 0.3f,
                                  .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &desc, NULL);
  scree_view view = host_view(2, 6, 3);
  host_settle(&h, &view, 1, 500);
  for (int i = 0; i < 40; ++i) {
    if (i % 4 < 3) {
      const uint32_t k = random_below(&r, LAYERS), ball = 2 + random_below(&r, BALLS);
      if (i % 8 < 4)
        w.shapes[k][ball].transform.translation[1] += (float)random_in(&r, -6, 6);
      else
        for (int a = 0; a < 3; ++a) w.shapes[k][ball].transform.translation[a] += (float)random_in(&r, -5, 5);
      take_over(&w, &h, k);
    } else {
      scree_id ids[8];
      uint32_t count = 0;
      uint32_t skip = random_below(&r, h.shown_instances / 10);
      for (uint32_t at = 0; at < h.caps.instances && count < 8; ++at) {
        if (h.owners[at] == 0 || skip-- > 0) continue;
        assert_true(scree_stream_id(h.stream, at, &ids[count++]));
        skip = random_below(&r, h.shown_instances / 10);
      }
      scree_stream_wait(h.stream);
      for (uint32_t e = 0; e < count; ++e)
        assert_int_equal(scree_edits_set(w.edits, &ids[e], e % 2 ? SCREE_EDIT_HIDE : SCREE_EDIT_REMOVE), SCREE_OK);
      assert_int_equal(scree_stream_edited(h.stream, ids, count), SCREE_OK);
    }
    view.position[0] += random_in(&r, -1, 1);
    host_settle(&h, &view, 1, 500);
    host_check_truth(&h, &view, 1, true);
  }
  assert_true(scree_edits_count(w.edits) > 30);
  host_check(&h);
  host_destroy(&h);
  world_free(&w);
}

/* Ground is the highest surface: what comes over it, however high, takes away what stood there, and gives it back. */
static void ground_high_above_takes_instances_away_and_gives_them_back(void** state) {
  (void)state;
  random_stream r = {6};
  scatter_world w;
  world_make(&w, &r, false);
  const scree_stream_desc desc = {.scene = w.scene, .view_distance = 28, .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &desc, NULL);
  scree_view view = host_view(2, 6, 3);
  uint32_t counts[3][LAYERS];
  const float radii[3] = {1, 15, 1};
  for (int i = 0; i < 3; ++i) {
    w.shapes[0][2] = (scree_shape){.kind = SCREE_SHAPE_SPHERE, .sphere = {radii[i]}, .transform.translation = {0, 300, 0}};
    take_over(&w, &h, 0);
    host_settle(&h, &view, 1, 500);
    host_check_truth(&h, &view, 1, true);
    count_layers(&h, counts[i]);
  }
  assert_true(counts[1][0] < counts[0][0] * 3 / 4);
  assert_true(counts[1][1] > counts[0][1]); /* rocks that had made room */
  assert_memory_equal(counts[0], counts[2], sizeof counts[0]);
  host_destroy(&h);
  world_free(&w);
}

static void scatters_are_shown_to_the_end_of_the_view_beside_a_far_field(void** state) {
  (void)state;
  random_stream r = {3};
  scatter_world w;
  world_make(&w, &r, true);
  const scree_stream_desc desc = {.scene = w.scene, .view_distance = 90, .max_error_pixels = 30, .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &desc, NULL);
  scree_view view = host_view(0, 25, 70);
  host_settle(&h, &view, 1, 800);
  uint32_t counts[LAYERS];
  count_layers(&h, counts);
  scree_stream_stats stats;
  scree_stream_get_stats(h.stream, &stats);
  assert_true(stats.complete && stats.proxies > 0);
  scree_scratch* scratch;
  assert_int_equal(scree_scratch_create(NULL, &scratch), SCREE_OK);
  for (uint32_t k = 0; k < LAYERS; k += 2) {
    const scree_scene_query_desc all = {.scene = w.scene, .layers = 1u << k};
    uint64_t count;
    assert_int_equal(scree_scene_count(&all, scratch, &count), SCREE_OK);
    assert_int_equal(counts[k], count);
    assert_true(count > 100);
  }
  scree_scratch_destroy(scratch);
  host_destroy(&h);
  world_free(&w);
}

static void caps_hold_and_memory_is_what_was_said(void** state) {
  (void)state;
  random_stream r = {4};
  scatter_world w;
  world_make(&w, &r, false);
  scree_stream_desc desc = {.scene = w.scene,
                            .view_distance = 30,
                            .max_error_pixels = 2,
                            .caps = {.instances = 1500, .blocks = 30, .mesh_bytes = 1800000, .upload_bytes = 60000, .events = 300},
                            .decode = stream_decode_pattern};
  failing_allocator counting = {.fail_at = -1};
  const scree_allocator allocator = failing_allocator_of(&counting);
  scree_stream* stream;
  assert_int_equal(scree_stream_create(&desc, &allocator, &stream, NULL), SCREE_OK);
  assert_true((size_t)counting.live <= scree_stream_memory(&desc));
  scree_stream_destroy(stream);
  assert_int_equal(counting.live, 0);
  stream_host h;
  host_create(&h, &desc, NULL);
  for (int i = 0; i < 400; ++i) {
    scree_view view = host_view(random_in(&r, -40, 40), random_in(&r, -5, 15), random_in(&r, -40, 40));
    host_update(&h, &view, 1);
    if (i % 40 == 0) host_check(&h);
  }
  host_destroy(&h);
  world_free(&w);
}

/* The parts of models of a pack, as the pack says them. */
static void models_of_a_pack_have_their_footprints_ages_and_parts(void** state) {
  (void)state;
  random_stream r = {5};
  scatter_world w;
  world_make(&w, &r, false);
  const scree_scatter* s = w.scatters[1];
  scree_pack_info info;
  scree_pack_get_info(w.packs[1], &info);
  assert_int_equal(scree_scatter_model_count(s), info.asset_count);
  for (uint32_t i = 0; i < info.asset_count; ++i) {
    scree_model model;
    assert_int_equal(scree_pack_get_model(w.packs[1], i, &model), SCREE_OK);
    assert_true(s->models[i].footprint == model.footprint);
    assert_true(s->variants[model.variant] + model.age == i);
    assert_true(model.part_count > 1);
    for (uint32_t k = 0; k < model.part_count; ++k) {
      int16_t steps[64 * 3];
      float xyz[64 * 3];
      uint32_t count, same;
      assert_int_equal(scree_pack_get_part(w.packs[1], i, k, steps, 64, &count), SCREE_OK);
      assert_int_equal(scree_scatter_part(s, i, k, xyz, 64, &same), SCREE_OK);
      assert_int_equal(count, same);
      for (uint32_t c = 0; c < 3 * count; ++c) assert_true(xyz[c] == (float)steps[c] / (float)info.lattice_per_cell);
    }
    float none[3];
    uint32_t count;
    assert_int_equal(scree_scatter_part(s, i, model.part_count, none, 1, &count), SCREE_ERROR_INVALID_ARGUMENT);
  }
  scree_scatter* refused;
  scree_error error;
  assert_int_equal(scree_scatter_create(&(scree_scatter_desc){.pack = w.packs[0], .spacing = 1}, NULL, &refused, &error),
                   SCREE_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "expected one of models"));
  assert_int_equal(scree_scatter_create(&(scree_scatter_desc){.pack = w.packs[1], .models = posts, .model_count = 2, .spacing = 1},
                                        NULL, &refused, &error),
                   SCREE_ERROR_INVALID_ARGUMENT);
  for (int at = 0, failed = 1; failed; ++at) {
    failing_allocator failing = {.fail_at = at};
    const scree_allocator allocator = failing_allocator_of(&failing);
    const scree_result result =
        scree_scatter_create(&(scree_scatter_desc){.pack = w.packs[1], .spacing = 1}, &allocator, &refused, &error);
    failed = result != SCREE_OK;
    assert_int_equal(result, failing.failed ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_OK);
    scree_scatter_destroy(refused);
    assert_int_equal(failing.live, 0);
  }
  world_free(&w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(shown_instances_and_levels_are_the_truth_wherever_the_view_goes),
      cmocka_unit_test(changes_of_grounds_and_edits_end_in_the_truth),
      cmocka_unit_test(ground_high_above_takes_instances_away_and_gives_them_back),
      cmocka_unit_test(scatters_are_shown_to_the_end_of_the_view_beside_a_far_field),
      cmocka_unit_test(caps_hold_and_memory_is_what_was_said),
      cmocka_unit_test(models_of_a_pack_have_their_footprints_ages_and_parts),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
