/* Streams against truth: after every walk, flight and teleport, what a plain host shows is what the scene says. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* after the four above */
#include <cmocka.h>

#include "failing_allocator.h"
#include "rounds.h"
#include "stream_host.h"
#include "synthetic_field.h"

static void a_settled_stream_shows_what_the_scene_says(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  scree_stream_desc desc = {.scene = w.scene, .edits = w.edits, .view_distance = 35, .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &desc, NULL);
  scree_view view = host_view(3, 5, 4);
  host_settle(&h, &view, 1, 600);
  host_check(&h);
  host_check_truth(&h, &view, 1, true);
  assert_true(h.shown_instances > 1000);
  scree_stream_stats stats;
  scree_stream_get_stats(h.stream, &stats);
  assert_true(stats.complete);
  host_destroy(&h);
  stream_world_free(&w);
}

/* Walks, flights and jumps, from one view to three. */
static void move_views(random_stream* r, scree_view views[3], uint32_t* count) {
  uint32_t how = random_below(r, 8);
  if (how == 0) *count = 1 + random_below(r, 3);
  for (uint32_t v = 0; v < 3; ++v) {
    double reach = how < 5 ? 2 : how < 7 ? 12 : 0;
    for (int a = 0; a < 3; ++a) {
      double half = a == 1 ? 15 : 70;
      views[v].position[a] = reach > 0 ? views[v].position[a] + random_in(r, -reach, reach) : random_in(r, -half, half);
      if (fabs(views[v].position[a]) > half * 2) views[v].position[a] = 0;
    }
    if (how == 1) views[v].viewport_height = (float)random_in(r, 200, 2000);
  }
}

static void shown_rocks_and_levels_are_the_truth_at_a_thousand_checkpoints(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  uint32_t checkpoints = 0;
  for (uint32_t round = 0; round < 4; ++round) {
    random_stream r = {round};
    scree_stream_desc desc = {.scene = w.scene,
                              .edits = w.edits,
                              .view_distance = 14 + 6 * round,
                              .max_error_pixels = 4,
                              .hysteresis = round & 1 ? 1e-6f : 0.3f,
                              .no_far_field = round & 1,
                              .fade_seconds = round & 2 ? 0.1f : 0,
                              .deterministic = round == 2,
                              .caps = {.blocks = 256, .instances = 65536},
                              .decode = stream_decode_pattern};
    stream_host h;
    host_create(&h, &desc, NULL);
    scree_view views[3] = {host_view(0, 3, 0), host_view(20, 3, 0), host_view(-5, 8, 30)};
    uint32_t count = 1;
    for (uint32_t i = 0; i < ROUNDS(250, 10); ++i) {
      for (uint32_t k = 0; k < 1 + i % 3; ++k) {
        move_views(&r, views, &count);
        host_update(&h, views, count);
      }
      host_settle(&h, views, count, 500);
      if (i % 10 == 0) host_check(&h);
      host_check_truth(&h, views, count, true);
      ++checkpoints;
    }
    host_destroy(&h);
  }
  assert_int_equal(checkpoints, ROUNDS(1000, 10));
  stream_world_free(&w);
}

static void a_view_that_jumps_every_update_passes_no_cap(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  scree_stream_desc desc = {.scene = w.scene,
                            .view_distance = 25,
                            .max_error_pixels = 2,
                            .caps = {.instances = 6000, .blocks = 60, .mesh_bytes = 1800000, .upload_bytes = 60000, .events = 300},
                            .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &desc, NULL);
  random_stream r = {5};
  for (int i = 0; i < ROUNDS(3000, 10); ++i) {
    scree_view view = host_view(random_in(&r, -60, 60), random_in(&r, -10, 20), random_in(&r, -60, 60));
    host_update(&h, &view, 1);
    if (i % 100 == 0) host_check(&h);
  }
  host_destroy(&h);
  stream_world_free(&w);
}

static void without_views_everything_goes_out_and_comes_back(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  scree_stream_desc desc = {.scene = w.scene, .view_distance = 25, .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &desc, NULL);
  scree_view view = host_view(0, 3, 0);
  host_settle(&h, &view, 1, 500);
  uint32_t shown = h.shown_instances;
  assert_true(shown > 0);
  host_settle(&h, NULL, 0, 100);
  assert_int_equal(h.shown_instances, 0);
  assert_int_equal(h.shown_blocks, 0);
  host_settle(&h, &view, 1, 500);
  assert_int_equal(h.shown_instances, shown);
  host_check_truth(&h, &view, 1, true);
  host_destroy(&h);
  stream_world_free(&w);
}

static void nothing_is_sent_while_nothing_moves(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  scree_stream_desc desc = {.scene = w.scene, .view_distance = 25, .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &desc, NULL);
  scree_view view = host_view(0, 3, 0);
  host_settle(&h, &view, 1, 500);
  for (int i = 0; i < 50; ++i) {
    host_update(&h, &view, 1);
    assert_int_equal(h.events, 0);
    scree_stream_stats stats;
    scree_stream_get_stats(h.stream, &stats);
    assert_int_equal(stats.builds + stats.decodes, 0);
  }
  host_destroy(&h);
  stream_world_free(&w);
}

static void without_a_decoder_only_coarsest_levels_are_drawn(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  scree_stream_desc desc = {.scene = w.scene, .view_distance = 20};
  stream_host h;
  host_create(&h, &desc, NULL);
  scree_view view = host_view(0, 3, 0);
  host_settle(&h, &view, 1, 500);
  scree_stream_stats stats;
  scree_stream_get_stats(h.stream, &stats);
  assert_int_equal(stats.instances_by_level[2], stats.instances);
  assert_true(stats.complete && stats.coarser == 0);
  host_check_truth(&h, &view, 1, false);
  host_destroy(&h);
  stream_world_free(&w);
}

static void lost_logs(void* user, scree_log_level level, const char* message) {
  (void)level, (void)message;
  ++*(uint32_t*)user;
}

static void meshes_that_cannot_be_decoded_cost_levels_and_nothing_else(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  for (int k = 0; k < 2; ++k) {
    uint32_t lines = 0;
    scree_stream_desc desc = {.scene = w.scene, .view_distance = 25, .log = {lost_logs, &lines}};
    desc.decode = k == 0 ? stream_decode_broken : stream_decode_flaky;
    stream_host h;
    host_create(&h, &desc, NULL);
    scree_view view = host_view(0, 3, 0);
    host_settle(&h, &view, 1, 2000);
    host_check(&h);
    host_check_truth(&h, &view, 1, false);
    scree_stream_stats stats;
    scree_stream_get_stats(h.stream, &stats);
    assert_true(lines > 0 && stats.coarser > 0);
    if (k == 0) assert_int_equal(stats.instances_by_level[2], stats.instances);
    uint32_t told = lines;
    for (int i = 0; i < 20; ++i) { /* it is not asked for again */
      view.position[0] += 0.5;
      host_settle(&h, &view, 1, 500);
    }
    assert_true(k == 1 || lines < 2u * h.infos[0].asset_count);
    assert_true(lines >= told);
    host_destroy(&h);
  }
  stream_world_free(&w);
}

static void a_bad_question_changes_nothing(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  scree_stream_desc desc = {.scene = w.scene, .view_distance = 25, .decode = stream_decode_pattern};
  scree_stream* s;
  assert_int_equal(scree_stream_create(NULL, NULL, &s, NULL), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_stream_create(&desc, NULL, NULL, NULL), SCREE_ERROR_INVALID_ARGUMENT);
  scree_stream_desc bad = desc;
  bad.scene = NULL;
  assert_int_equal(scree_stream_create(&bad, NULL, &s, NULL), SCREE_ERROR_INVALID_ARGUMENT);
  const float values[] = {-1, NAN, INFINITY};
  scree_error error;
  for (int i = 0; i < 3; ++i) {
    bad = desc;
    bad.view_distance = (double)values[i];
    assert_int_equal(scree_stream_create(&bad, NULL, &s, &error), SCREE_ERROR_RANGE);
    assert_non_null(strstr(error.message, "view_distance"));
    bad = desc;
    bad.max_error_pixels = values[i];
    assert_int_equal(scree_stream_create(&bad, NULL, &s, &error), SCREE_ERROR_RANGE);
    bad = desc;
    bad.hysteresis = values[i];
    assert_int_equal(scree_stream_create(&bad, NULL, &s, &error), SCREE_ERROR_RANGE);
    bad = desc;
    bad.fade_seconds = values[i];
    assert_int_equal(scree_stream_create(&bad, NULL, &s, &error), SCREE_ERROR_RANGE);
  }
  bad = desc;
  bad.caps.mesh_bytes = 1000;
  assert_int_equal(scree_stream_create(&bad, NULL, &s, &error), SCREE_ERROR_CAPACITY);
  assert_non_null(strstr(error.message, "mesh_bytes"));
  assert_null(s);

  stream_host h;
  host_create(&h, &desc, NULL);
  scree_view view = host_view(0, 3, 0);
  host_settle(&h, &view, 1, 500);
  const scree_event* events;
  uint32_t count;
  scree_view wrong[6];
  for (int i = 0; i < 6; ++i) wrong[i] = view;
  wrong[0].position[1] = NAN;
  wrong[1].field_of_view = 0;
  wrong[2].field_of_view = 4;
  wrong[3].viewport_height = -1;
  wrong[4].plane_count = 1;
  float planes[40] = {NAN};
  wrong[5].frustum = planes;
  wrong[5].plane_count = 1;
  for (int i = 0; i < 6; ++i)
    assert_int_equal(scree_stream_update(h.stream, &wrong[i], 1, h.time + 1, &events, &count), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_stream_update(h.stream, &view, 9, h.time + 1, &events, &count), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_stream_update(h.stream, NULL, 1, h.time + 1, &events, &count), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_stream_update(h.stream, &view, 1, h.time - 1, &events, &count), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_stream_update(h.stream, &view, 1, (double)NAN, &events, &count), SCREE_ERROR_INVALID_ARGUMENT);
  host_check_truth(&h, &view, 1, true);
  scree_id id;
  assert_false(scree_stream_id(h.stream, UINT32_MAX, &id));
  scree_stream_destroy(NULL);
  host_destroy(&h);
  stream_world_free(&w);
}

/* --- far fields ------------------------------------------------------------------------------------------------------------- */

/* How many shown blocks hold the place of each rock that is in view: the cube that a rock lies in, at the level of the block. */
static void count_covers(const stream_host* h, const scree_rock* rock, uint32_t* covers, uint32_t* finest) {
  *covers = 0;
  *finest = UINT32_MAX;
  for (uint32_t k = 0; k < h->caps.blocks; ++k) {
    const host_block* b = &h->blocks[k];
    if (!b->shown || b->leaving) continue;
    double width = 12.0 * (double)(1u << b->level);
    bool inside = true;
    for (int a = 0; a < 3; ++a)
      inside =
          inside && (double)rock->position[a] >= b->origin[a] - 1e-4 && (double)rock->position[a] < b->origin[a] + width - 1e-4;
    if (!inside) continue;
    ++*covers;
    if (b->level < *finest) *finest = b->level;
  }
}

static double split_distance(const stream_host* h, uint32_t level) {
  double pixels = 1080 / (2 * tan(1.0471976 / 2));
  return 0.4 * (double)(1u << (level - 1)) * pixels / (double)h->desc.max_error_pixels; /* as stream_pack_make says */
}

static void far_rocks_are_drawn_once_as_proxies_and_near_ones_as_rocks(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){.proxies = true});
  scree_stream_desc desc = {.scene = w.scene,
                            .view_distance = 90,
                            .max_error_pixels = 25,
                            .hysteresis = 1e-3f,
                            .caps = {.blocks = 512, .instances = 65536},
                            .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &desc, NULL);
  scree_scratch* scratch;
  assert_int_equal(scree_scratch_create(NULL, &scratch), SCREE_OK);
  scree_scene_query_desc query = {.scene = w.scene, .flags = SCREE_SCENE_VISIBLE};
  uint64_t count;
  assert_int_equal(scree_scene_count(&query, scratch, &count), SCREE_OK);
  scree_rock* rocks = malloc(count * sizeof *rocks);
  assert_int_equal(scree_scene_fill(&query, scratch, rocks, count, &count), SCREE_OK);
  random_stream r = {9};
  scree_view view = host_view(0, 3, 0);
  uint64_t as_rocks = 0, as_proxies = 0;
  for (int i = 0; i < 60; ++i) {
    for (int a = 0; a < 3; a += 2) view.position[a] = i % 10 ? view.position[a] + random_in(&r, -8, 8) : random_in(&r, -60, 60);
    host_settle(&h, &view, 1, 500);
    host_check(&h);
    scree_stream_stats stats;
    scree_stream_get_stats(h.stream, &stats);
    assert_true(stats.complete);
    for (uint64_t k = 0; k < count; k += 37) {
      uint32_t covers, level;
      count_covers(&h, &rocks[k], &covers, &level);
      double sum = 0;
      for (int a = 0; a < 3; ++a) sum += pow((double)rocks[k].position[a] - view.position[a], 2);
      double distance = sqrt(sum);
      assert_true(covers <= 1);
      if (distance < split_distance(&h, 1)) assert_true(covers == 1 && level == 0);
      if (covers == 1 && level > 0) {
        ++as_proxies; /* no nearer than the rule allows, for the farthest point of the node */
        assert_true(distance >= split_distance(&h, level) * (1 - 1e-6));
      }
      if (covers == 1 && level == 0) {
        ++as_rocks;
        assert_true(distance < split_distance(&h, 1) * 1.01 + 24 * 1.7320508);
      }
    }
  }
  assert_true(as_rocks > 1000 && as_proxies > 1000);
  free(rocks);
  scree_scratch_destroy(scratch);
  host_destroy(&h);
  stream_world_free(&w);
}

static void a_flight_never_makes_a_hole(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){.proxies = true});
  for (int round = 0; round < 3; ++round) {
    scree_stream_desc desc = {.scene = w.scene,
                              .view_distance = 90,
                              .max_error_pixels = 25,
                              .fade_seconds = round == 1 ? 0.2f : 0,
                              .caps = {.blocks = 512, .instances = 65536, .builds = round == 2 ? 3 : 0},
                              .decode = stream_decode_pattern};
    stream_host h;
    host_create(&h, &desc, NULL);
    scree_scratch* scratch;
    assert_int_equal(scree_scratch_create(NULL, &scratch), SCREE_OK);
    scree_scene_query_desc query = {.scene = w.scene, .flags = SCREE_SCENE_VISIBLE};
    uint64_t count;
    assert_int_equal(scree_scene_count(&query, scratch, &count), SCREE_OK);
    scree_rock* rocks = malloc(count * sizeof *rocks);
    assert_int_equal(scree_scene_fill(&query, scratch, rocks, count, &count), SCREE_OK);
    uint64_t kept = 0; /* some of them, of the middle of the slab, all of which stay in view */
    for (uint64_t k = 0; k < count; k += 101) rocks[kept++] = rocks[k];
    scree_view view = host_view(-25, 4, 0);
    host_settle(&h, &view, 1, 1000);
    bool* covered = calloc(kept, sizeof *covered);
    uint64_t lost = 0, drawn = 0;
    for (int i = 0; i < 200; ++i) {
      view.position[0] += 0.25;
      view.position[2] += 0.1 * sin(i * 0.1);
      host_update(&h, &view, 1);
      for (uint64_t k = 0; k < kept; ++k) {
        double sum = 0;
        for (int a = 0; a < 3; ++a) sum += pow((double)rocks[k].position[a] - view.position[a], 2);
        if (sum > 60 * 60) continue;
        uint32_t covers, level;
        count_covers(&h, &rocks[k], &covers, &level);
        lost += covered[k] && covers == 0;
        drawn += covers > 0;
        covered[k] = covers > 0;
      }
    }
    assert_true(drawn > 10000);
    assert_int_equal(lost, 0);
    free(covered);
    free(rocks);
    scree_scratch_destroy(scratch);
    host_destroy(&h);
  }
  stream_world_free(&w);
}

/* A far field over everything the events may do: jumps, fades, caps that bind. */
static void a_far_field_passes_no_cap(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){.proxies = true});
  for (int round = 0; round < 4; ++round) {
    scree_stream_desc desc = {.scene = w.scene,
                              .edits = w.edits,
                              .view_distance = 90,
                              .max_error_pixels = 10,
                              .fade_seconds = round & 1 ? 0.1f : 0,
                              .caps = {.blocks = round & 2 ? 40 : 400,
                                       .instances = round & 2 ? 5000 : 20000,
                                       .upload_bytes = 200000,
                                       .events = round & 2 ? 60 : 0},
                              .decode = stream_decode_pattern};
    stream_host h;
    host_create(&h, &desc, NULL);
    random_stream r = {(uint64_t)round};
    scree_view view = host_view(0, 5, 0);
    for (int i = 0; i < ROUNDS(800, 5); ++i) {
      for (int a = 0; a < 3; a += 2) view.position[a] = i % 40 ? view.position[a] + random_in(&r, -2, 2) : random_in(&r, -70, 70);
      if (i % 50 == 10) assert_int_equal(scree_stream_edited(h.stream, NULL, 0), SCREE_OK);
      host_update(&h, &view, 1);
      if (i % 20 == 0) host_check(&h);
    }
    view.position[0] = view.position[2] = 0;
    host_settle(&h, &view, 1, 3000);
    assert_true(h.shown_instances > 0);
    host_destroy(&h);
  }
  stream_world_free(&w);
}

static void memory_is_what_the_formula_says_and_does_not_grow(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  failing_allocator memory = {.fail_at = -1};
  const scree_allocator allocator = failing_allocator_of(&memory);
  scree_stream_desc desc = {.scene = w.scene, .view_distance = 25, .caps = {.builds = 7}, .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &desc, &allocator);
  assert_int_equal(memory.live, scree_stream_memory(&desc));
  scree_view view = host_view(0, 3, 0);
  random_stream r = {3};
  int calls = 0;
  for (int i = 0; i < 6000; ++i) { /* every build has seen the densest block by then */
    if (i == 3000) calls = memory.calls;
    for (int a = 0; a < 3; a += 2) view.position[a] = i % 50 ? view.position[a] + random_in(&r, -1, 1) : random_in(&r, -50, 50);
    host_update(&h, &view, 1);
  }
  assert_int_equal(memory.calls, calls);
  host_destroy(&h);
  assert_int_equal(memory.live, 0);
  stream_world_free(&w);
}

/* Every allocation fails once: create says so, an update goes on and makes up for it later. */
static void a_failing_allocation_costs_time_and_nothing_else(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  scree_stream_desc desc = {.scene = w.scene,
                            .view_distance = 12,
                            .caps = {.instances = 20000, .blocks = 200, .builds = 3, .decodes = 8},
                            .decode = stream_decode_pattern};
  scree_view view = host_view(5, 3, 0);
  uint32_t created = 0;
  for (int32_t n = 0; created < 40; ++n) {
    failing_allocator memory = {.fail_at = n};
    const scree_allocator allocator = failing_allocator_of(&memory);
    scree_stream* stream;
    if (scree_stream_create(&desc, &allocator, &stream, NULL) != SCREE_OK) {
      assert_null(stream);
      assert_int_equal(memory.live, 0);
      continue;
    }
    scree_stream_destroy(stream);
    assert_int_equal(memory.live, 0);
    memory = (failing_allocator){.fail_at = n};
    stream_host h;
    host_create(&h, &desc, &allocator);
    host_settle(&h, &view, 1, 500);
    host_check_truth(&h, &view, 1, true);
    if (!memory.failed) created = 40; /* nothing failed any more */
    host_destroy(&h);
    assert_int_equal(memory.live, 0);
    ++created;
  }
  stream_world_free(&w);
}

static void slots_of_meshes_follow_from_asset_and_level(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){.proxies = true});
  scree_pack_info info;
  scree_pack_get_info(w.pack, &info);
  scree_stream_desc desc = {.scene = w.scene, .view_distance = 10, .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &desc, NULL);
  uint32_t assets = info.asset_count + info.proxy_count, slots = scree_stream_mesh_slots(h.stream);
  uint8_t* taken = calloc(slots, 1);
  assert_non_null(taken);
  for (uint32_t asset = 0; asset < assets; ++asset)
    for (uint32_t level = 0; level < info.lod_count; ++level) {
      uint32_t slot = scree_stream_mesh(h.stream, 0, asset, level);
      assert_true(slot < slots);
      assert_int_equal(taken[slot]++, 0);
    }
  assert_int_equal(scree_stream_mesh(h.stream, 0, assets, 0), UINT32_MAX);
  assert_int_equal(scree_stream_mesh(h.stream, 0, 0, info.lod_count), UINT32_MAX);
  assert_int_equal(scree_stream_mesh(h.stream, 1, 0, 0), UINT32_MAX);
  assert_int_equal(scree_stream_mesh(NULL, 0, 0, 0), UINT32_MAX);
  free(taken);
  host_destroy(&h);
  stream_world_free(&w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(slots_of_meshes_follow_from_asset_and_level),
      cmocka_unit_test(a_settled_stream_shows_what_the_scene_says),
      cmocka_unit_test(shown_rocks_and_levels_are_the_truth_at_a_thousand_checkpoints),
      cmocka_unit_test(a_view_that_jumps_every_update_passes_no_cap),
      cmocka_unit_test(without_views_everything_goes_out_and_comes_back),
      cmocka_unit_test(nothing_is_sent_while_nothing_moves),
      cmocka_unit_test(without_a_decoder_only_coarsest_levels_are_drawn),
      cmocka_unit_test(meshes_that_cannot_be_decoded_cost_levels_and_nothing_else),
      cmocka_unit_test(a_bad_question_changes_nothing),
      cmocka_unit_test(far_rocks_are_drawn_once_as_proxies_and_near_ones_as_rocks),
      cmocka_unit_test(a_flight_never_makes_a_hole),
      cmocka_unit_test(a_far_field_passes_no_cap),
      cmocka_unit_test(memory_is_what_the_formula_says_and_does_not_grow),
      cmocka_unit_test(a_failing_allocation_costs_time_and_nothing_else),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
