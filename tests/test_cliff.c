/* Cliffs of packs in scenes and streams: what stands and what fell, each where the pack says. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* after the five above */
#include <cmocka.h>

#include <scree/cliff.h>

#include "failing_allocator.h"
#include "make_model_pack.h"
#include "stream_host.h"
#include "synthetic_field.h"

enum { TIMES = 3, BLOCKS = 7 };

typedef struct cliff_world {
  uint8_t* bytes;
  scree_pack* pack;
  scree_scatter* cliff;
  scree_scene* scene;
  scree_scratch* scratch;
} cliff_world;

static scree_scatter* cliff_of(const scree_cliff_desc* desc) {
  scree_scatter* cliff;
  scree_error error;
  if (scree_cliff_create(desc, NULL, &cliff, &error) != SCREE_OK) fail_msg("%s", error.message);
  return cliff;
}

/* desc: its pack is filled in. */
static void world_make(cliff_world* w, scree_cliff_desc* desc) {
  size_t size;
  memset(w, 0, sizeof *w);
  w->bytes = test_model_pack_make(&(test_models_desc){.variants = BLOCKS + 1, .ages = TIMES, .lattice_per_cell = 32, .cliff = true},
                                  &size);
  assert_int_equal(scree_pack_open_memory(w->bytes, size, NULL, &w->pack), SCREE_OK);
  desc->pack = w->pack;
  w->cliff = cliff_of(desc);
  const scree_layer layer = {.scatter = w->cliff, .key = 9};
  scree_error error;
  if (scree_scene_create(&(scree_scene_desc){&layer, 1}, NULL, &w->scene, &error) != SCREE_OK) fail_msg("%s", error.message);
  assert_int_equal(scree_scratch_create(NULL, &w->scratch), SCREE_OK);
}

static void world_free(cliff_world* w) {
  scree_scratch_destroy(w->scratch);
  scree_scene_destroy(w->scene);
  scree_scatter_destroy(w->cliff);
  scree_pack_close(w->pack);
  free(w->bytes);
}

/* Where an instance belongs by the words of the header, and which asset it is. Instance 0 stands. */
static scree_block_placement expected(const cliff_world* w, const scree_cliff_desc* d, uint32_t i) {
  scree_cliff_time time;
  assert_int_equal(scree_pack_get_time(w->pack, d->time, &time), SCREE_OK);
  scree_block_placement p = {.asset = time.asset};
  if (i > 0) assert_int_equal(scree_pack_get_placements(w->pack, time.first_placement + i - 1, 1, &p), SCREE_OK);
  const double angle = floor(d->turn * 65536 + 0.5) / 65536 * 6.283185307179586, s = sin(angle), c = cos(angle);
  const double scale = d->scale > 0 ? (double)d->scale : 1;
  const double x = (double)p.translation[0], z = (double)p.translation[2];
  p.translation[0] = (float)(scale * (c * x + s * z));
  p.translation[1] = (float)(scale * (double)p.translation[1]);
  p.translation[2] = (float)(scale * (c * z - s * x));
  return p;
}

static scree_rock* ask(const cliff_world* w, const scree_scene_query_desc* desc, uint64_t* count) {
  assert_int_equal(scree_scene_count(desc, w->scratch, count), SCREE_OK);
  scree_rock* rocks = malloc((size_t)(*count + 1) * sizeof *rocks);
  assert_non_null(rocks);
  assert_int_equal(scree_scene_fill(desc, w->scratch, rocks, *count, count), SCREE_OK);
  return rocks;
}

static void instances_are_what_stands_and_every_placement_where_it_belongs(void** state) {
  (void)state;
  const double turns[] = {0, 0.25, 0.4, -0.1};
  for (uint32_t round = 0; round < 12; ++round) {
    scree_cliff_desc desc = {.time = round % TIMES,
                             .turn = turns[round % 4],
                             .scale = round % 2 ? 2.5f : 0,
                             .origin = {100.25 * round, -7, 3e5 * (round % 3)}};
    cliff_world w;
    world_make(&w, &desc);
    scree_scene_query_desc all = {.scene = w.scene};
    memcpy(all.origin, desc.origin, sizeof all.origin);
    uint64_t count;
    scree_rock* rocks = ask(&w, &all, &count);
    assert_int_equal(count, 1 + TEST_PLACEMENTS * desc.time);
    uint32_t matched = 0;
    for (uint32_t i = 0; i < count; ++i) {
      const scree_block_placement p = expected(&w, &desc, i);
      uint32_t found = 0;
      for (uint64_t k = 0; k < count; ++k) {
        double away = 0;
        for (int a = 0; a < 3; ++a) away = fmax(away, fabs((double)rocks[k].position[a] - (double)p.translation[a]));
        found += rocks[k].asset == p.asset && away < 0.08; /* turns are near */
      }
      assert_true(found >= 1);
      matched += found == 1;
    }
    assert_true(matched + 2 >= count);
    for (uint64_t k = 0; k < count; ++k) {
      for (uint64_t j = 0; j < k; ++j) assert_memory_not_equal(&rocks[k].id, &rocks[j].id, sizeof(scree_id));
      scree_rock same;
      scree_rock_state what;
      assert_int_equal(scree_scene_find(w.scene, NULL, w.scratch, &rocks[k].id, desc.origin, &same, &what), SCREE_OK);
      assert_int_equal(what, SCREE_ROCK_EXISTS);
      assert_memory_equal(&same, &rocks[k], sizeof same);
      scree_id wrong = rocks[k].id;
      wrong.cube[1] += 1;
      assert_int_equal(scree_scene_find(w.scene, NULL, w.scratch, &wrong, desc.origin, &same, &what), SCREE_OK);
      assert_int_equal(what, SCREE_ROCK_UNKNOWN);
      assert_int_equal(scree_scene_find(w.scene, NULL, w.scratch, &wrong, desc.origin, NULL, &what), SCREE_OK);
      assert_int_equal(what, SCREE_ROCK_UNKNOWN);
    }
    free(rocks);
    world_free(&w);
  }
}

static void all_instances_of_a_cliff_are_turned_and_sized_alike(void** state) {
  (void)state;
  scree_cliff_desc desc = {.time = 2, .turn = 0.3, .scale = 1.5f};
  cliff_world w;
  world_make(&w, &desc);
  uint64_t count;
  scree_rock* rocks = ask(&w, &(scree_scene_query_desc){.scene = w.scene}, &count);
  uint32_t lows = 0;
  for (uint64_t k = 0; k < count; ++k) {
    float turn[2], scale;
    const uint32_t random = scree_scene_random(w.scene, &rocks[k].id);
    scree_scatter_turn(w.cliff, random, turn, &scale);
    assert_true(fabs((double)turn[0] - sin(0.3 * 6.283185307179586)) < 2e-4);
    assert_true(fabs((double)turn[1] - cos(0.3 * 6.283185307179586)) < 2e-4);
    assert_true(scale == 1.5f);
    lows |= random & 0xffff;
  }
  assert_true(lows == 0xffff); /* the other bits are random, for colours */
  free(rocks);
  world_free(&w);
}

static void a_box_has_the_instances_whose_place_is_in_it(void** state) {
  (void)state;
  scree_cliff_desc desc = {.time = 2, .turn = 0.15, .origin = {5, 6, 7}};
  cliff_world w;
  world_make(&w, &desc);
  scree_scene_query_desc all = {.scene = w.scene};
  uint64_t count, part, hits = 0;
  scree_rock* rocks = ask(&w, &all, &count);
  for (uint64_t k = 0; k < count; ++k) {
    scree_scene_query_desc box = all;
    for (int a = 0; a < 3; ++a) {
      box.min[a] = (double)rocks[k].position[a] - 1.5;
      box.max[a] = (double)rocks[k].position[a] + 0.5;
    }
    scree_rock* some = ask(&w, &box, &part);
    uint64_t inside = 0;
    for (uint64_t j = 0; j < count; ++j) {
      bool in = true;
      for (int a = 0; a < 3; ++a)
        in = in && (double)rocks[j].position[a] >= box.min[a] && (double)rocks[j].position[a] < box.max[a];
      inside += in;
    }
    assert_int_equal(part, inside);
    hits += inside;
    free(some);
  }
  assert_true(hits >= count);
  free(rocks);
  world_free(&w);
}

/* A time slider must not break a scene where it comes to a time before the first fall. */
static void blocks_of_a_time_before_any_fell_are_a_layer_of_none(void** state) {
  (void)state;
  scree_cliff_desc desc = {.time = 0, .what = SCREE_CLIFF_BLOCKS, .origin = {3, 4, 5}};
  cliff_world w;
  world_make(&w, &desc);
  uint64_t count;
  free(ask(&w, &(scree_scene_query_desc){.scene = w.scene}, &count));
  assert_int_equal(count, 0);
  const double start[3] = {3, 100, 5}, down[3] = {0, -1, 0};
  bool found;
  scree_hit hit;
  assert_int_equal(scree_scene_ray_cast(w.scene, NULL, w.scratch, start, down, 200, &found, &hit), SCREE_OK);
  assert_false(found);
  world_free(&w);
}

static void rays_meet_blocks_and_edits_take_them_away(void** state) {
  (void)state;
  scree_cliff_desc desc = {.time = 2, .what = SCREE_CLIFF_BLOCKS};
  cliff_world w;
  world_make(&w, &desc);
  scree_edits* edits;
  assert_int_equal(scree_edits_create(NULL, &edits), SCREE_OK);
  uint64_t count, left;
  scree_rock* rocks = ask(&w, &(scree_scene_query_desc){.scene = w.scene}, &count);
  assert_int_equal(count, 2 * TEST_PLACEMENTS);
  for (uint64_t k = 0; k < count; ++k) {
    const double start[3] = {(double)rocks[k].position[0], (double)rocks[k].position[1] + 100, (double)rocks[k].position[2]};
    const double down[3] = {0, -1, 0};
    bool found;
    scree_hit hit;
    assert_int_equal(scree_scene_ray_cast(w.scene, edits, w.scratch, start, down, 200, &found, &hit), SCREE_OK);
    assert_true(found && hit.distance < 100);
    assert_int_equal(scree_edits_set(edits, &rocks[k].id, SCREE_EDIT_REMOVE), SCREE_OK);
    assert_int_equal(scree_scene_count(&(scree_scene_query_desc){.scene = w.scene, .edits = edits}, w.scratch, &left), SCREE_OK);
    assert_int_equal(left, count - 1 - k);
  }
  free(rocks);
  scree_edits_destroy(edits);
  world_free(&w);
}

static void streams_show_a_cliff_wherever_the_view_goes(void** state) {
  (void)state;
  scree_cliff_desc desc = {.time = 2, .turn = 0.1, .scale = 3, .origin = {40, 2, -9}};
  cliff_world w;
  world_make(&w, &desc);
  const scree_stream_desc stream = {
      .scene = w.scene, .view_distance = 130, .max_error_pixels = 3, .hysteresis = 0.3f, .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &stream, NULL);
  uint32_t most = 0;
  random_stream r = {4};
  for (int i = 0; i < 20; ++i) {
    scree_view view = host_view(40 + random_in(&r, -60, 60), random_in(&r, 0, 12), -9 + random_in(&r, -60, 60));
    host_settle(&h, &view, 1, 500);
    host_check(&h);
    host_check_truth(&h, &view, 1, true);
    most = h.shown_instances > most ? h.shown_instances : most;
  }
  assert_int_equal(most, 1 + 2 * TEST_PLACEMENTS);
  host_destroy(&h);
  world_free(&w);
}

static void another_time_takes_the_place_of_one_while_it_is_shown(void** state) {
  (void)state;
  scree_cliff_desc desc = {.time = 0};
  cliff_world w;
  world_make(&w, &desc);
  const scree_stream_desc stream = {.scene = w.scene, .view_distance = 100, .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &stream, NULL);
  const scree_view view = host_view(0, 5, 20);
  host_settle(&h, &view, 1, 500);
  assert_int_equal(h.shown_instances, 1);
  desc.time = 1;
  scree_scatter* later = cliff_of(&desc);
  const scree_layer layer = {.scatter = later, .key = 9};
  scree_scene* scene;
  assert_int_equal(scree_scene_create(&(scree_scene_desc){&layer, 1}, NULL, &scene, NULL), SCREE_OK);
  scree_stream_wait(h.stream);
  assert_int_equal(scree_stream_set_scene(h.stream, scene), SCREE_OK);
  h.desc.scene = scene;
  host_use_scene(&h, scene);
  host_settle(&h, &view, 1, 500);
  host_check_truth(&h, &view, 1, true);
  assert_int_equal(h.shown_instances, 1 + TEST_PLACEMENTS);
  host_destroy(&h);
  scree_scene_destroy(scene);
  scree_scatter_destroy(later);
  world_free(&w);
}

static void assert_refused(scree_result result, const char* words, const scree_cliff_desc* desc) {
  scree_scatter* cliff;
  scree_error error;
  assert_int_equal(scree_cliff_create(desc, NULL, &cliff, &error), result);
  assert_null(cliff);
  if (strstr(error.message, words) == NULL) fail_msg("'%s' does not say '%s'", error.message, words);
}

static void what_is_wrong_is_said(void** state) {
  (void)state;
  scree_cliff_desc good = {.time = 1};
  cliff_world w;
  world_make(&w, &good);
  size_t size;
  uint8_t* bytes = test_model_pack_make(NULL, &size);
  scree_pack* models;
  assert_int_equal(scree_pack_open_memory(bytes, size, NULL, &models), SCREE_OK);
  scree_cliff_desc desc = good;
  desc.pack = NULL;
  assert_refused(SCREE_ERROR_INVALID_ARGUMENT, "pack is NULL", &desc);
  desc.pack = models;
  assert_refused(SCREE_ERROR_PACK_KIND, "expected one of a cliff", &desc);
  desc = good;
  desc.time = TIMES;
  assert_refused(SCREE_ERROR_RANGE, "time is 3", &desc);
  desc = good;
  desc.what = 4;
  assert_refused(SCREE_ERROR_RANGE, "what is 4", &desc);
  desc = good;
  desc.scale = -1;
  assert_refused(SCREE_ERROR_RANGE, "scale is -1", &desc);
  desc = good;
  desc.turn = (double)NAN;
  assert_refused(SCREE_ERROR_RANGE, "turn", &desc);
  desc = good;
  desc.origin[1] = (double)INFINITY;
  assert_refused(SCREE_ERROR_RANGE, "origin", &desc);
  assert_refused(SCREE_ERROR_INVALID_ARGUMENT, "desc is NULL", NULL);
  /* a layer's own support has no place beside a cliff */
  const scree_layer* told = scree_scene_layer(w.scene, 0);
  assert_non_null(told->support);
  scree_layer layer = {.scatter = w.cliff, .support = told->support};
  scree_scene* scene;
  scree_error error;
  assert_int_equal(scree_scene_create(&(scree_scene_desc){&layer, 1}, NULL, &scene, &error), SCREE_OK);
  scree_scene_destroy(scene);
  const scree_shape ball = {.kind = SCREE_SHAPE_SPHERE, .sphere = {1}};
  scree_support* support;
  assert_int_equal(scree_support_create(&(scree_support_desc){.shapes = &ball, .shape_count = 1}, NULL, &support, NULL), SCREE_OK);
  layer.support = support;
  assert_int_equal(scree_scene_create(&(scree_scene_desc){&layer, 1}, NULL, &scene, &error), SCREE_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "a cliff has no support"));
  scree_support_destroy(support);
  scree_pack_close(models);
  free(bytes);
  world_free(&w);
}

static void failing_allocations_leave_nothing_behind(void** state) {
  (void)state;
  scree_cliff_desc desc = {.time = 2};
  cliff_world w;
  world_make(&w, &desc);
  int tried = 0;
  for (bool failed = true; failed; ++tried) {
    failing_allocator failing = {.fail_at = tried};
    const scree_allocator allocator = failing_allocator_of(&failing);
    scree_scatter* cliff;
    scree_error error;
    const scree_result result = scree_cliff_create(&desc, &allocator, &cliff, &error);
    failed = result != SCREE_OK;
    assert_int_equal(result, failing.failed ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_OK);
    scree_scatter_destroy(cliff);
    assert_int_equal(failing.live, 0);
  }
  assert_true(tried > 5);
  world_free(&w);
}

static void earlier_layers_drop_blocks_and_never_what_stands(void** state) {
  (void)state;
  scree_cliff_desc desc = {.time = 2};
  cliff_world w;
  world_make(&w, &desc);
  const scree_layer layers[2] = {{.scatter = w.cliff, .key = 1}, {.scatter = w.cliff, .key = 2}};
  scree_scene* scene;
  assert_int_equal(scree_scene_create(&(scree_scene_desc){layers, 2}, NULL, &scene, NULL), SCREE_OK);
  const scree_scene_query_desc all = {.scene = scene};
  uint64_t count;
  scree_rock* rocks = ask(&w, &all, &count);
  uint32_t standing[2] = {0}, blocks[2] = {0};
  for (uint64_t i = 0; i < count; ++i) {
    const uint32_t later = rocks[i].id.layer == 2;
    ++*(rocks[i].asset < TIMES ? &standing[later] : &blocks[later]);
  }
  assert_true(standing[0] == 1 && standing[1] == 1);
  assert_true(blocks[0] == 2 * TEST_PLACEMENTS && blocks[1] == 0);
  free(rocks);
  scree_scene_destroy(scene);
  world_free(&w);
}

/* A cube of steps 0..side as decoders give it: each side has corners of its own. The last triangle has no area and no edge that
 * others know. */
static void make_cube(int16_t side, scree_vertex vertices[27], uint32_t indices[39]) {
  memset(vertices, 0, 27 * sizeof *vertices);
  for (uint32_t k = 0; k < 6; ++k) {
    const uint32_t axis = k / 2, u = (axis + 1) % 3, v = (axis + 2) % 3, up = k % 2;
    for (uint32_t c = 0; c < 4; ++c) {
      int16_t* p = vertices[4 * k + c].position;
      p[axis] = up ? side : 0;
      p[u] = c == 1 || c == 2 ? side : 0;
      p[v] = c >= 2 ? side : 0;
    }
    static const uint32_t fans[2][6] = {{0, 2, 1, 0, 3, 2}, {0, 1, 2, 0, 2, 3}};
    for (uint32_t i = 0; i < 6; ++i) indices[6 * k + i] = 4 * k + fans[up][i];
  }
  for (uint32_t i = 0; i < 3; ++i) indices[36 + i] = 24 + i;
  vertices[25].position[0] = side;
}

static void meshes_of_cliffs_are_supports(void** state) {
  (void)state;
  scree_cliff_desc desc = {.time = 0};
  cliff_world w;
  world_make(&w, &desc);
  scree_vertex vertices[27];
  uint32_t indices[39];
  make_cube(64, vertices, indices);
  scree_shape shape = {.kind = SCREE_SHAPE_MESH};
  assert_int_equal(scree_cliff_mesh_create(w.pack, vertices, 27, indices, 39, NULL, &shape.mesh), SCREE_OK);
  assert_true(shape.mesh.vertex_count == 8 && shape.mesh.triangle_count == 12);
  scree_support* support;
  scree_error error;
  if (scree_support_create(&(scree_support_desc){.shapes = &shape, .shape_count = 1}, NULL, &support, &error) != SCREE_OK)
    fail_msg("%s", error.message);
  double low[3], high[3];
  scree_support_bounds(support, low, high);
  for (int a = 0; a < 3; ++a) assert_true(fabs(low[a]) < 0.1 && fabs(high[a] - 2) < 0.1); /* 32 steps a metre */
  scree_support_destroy(support);
  scree_cliff_mesh_free(NULL, &shape.mesh);
  assert_true(shape.mesh.positions == NULL && shape.mesh.vertex_count == 0);
  /* What is wrong leaves nothing. */
  assert_int_equal(scree_cliff_mesh_create(NULL, vertices, 27, indices, 39, NULL, &shape.mesh), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_cliff_mesh_create(w.pack, vertices, 27, indices, 38, NULL, &shape.mesh), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_cliff_mesh_create(w.pack, vertices, 26, indices, 39, NULL, &shape.mesh), SCREE_ERROR_RANGE);
  assert_null(shape.mesh.positions);
  bool failed = true;
  for (int n = 0; failed; ++n) {
    failing_allocator failing = {.fail_at = n};
    const scree_allocator allocator = failing_allocator_of(&failing);
    const scree_result result = scree_cliff_mesh_create(w.pack, vertices, 27, indices, 39, &allocator, &shape.mesh);
    failed = result != SCREE_OK;
    assert_int_equal(result, failing.failed ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_OK);
    scree_cliff_mesh_free(&allocator, &shape.mesh);
    assert_int_equal(failing.live, 0);
    assert_true(failed || n >= 4);
  }
  world_free(&w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(earlier_layers_drop_blocks_and_never_what_stands),
      cmocka_unit_test(meshes_of_cliffs_are_supports),
      cmocka_unit_test(instances_are_what_stands_and_every_placement_where_it_belongs),
      cmocka_unit_test(all_instances_of_a_cliff_are_turned_and_sized_alike),
      cmocka_unit_test(a_box_has_the_instances_whose_place_is_in_it),
      cmocka_unit_test(blocks_of_a_time_before_any_fell_are_a_layer_of_none),
      cmocka_unit_test(rays_meet_blocks_and_edits_take_them_away),
      cmocka_unit_test(streams_show_a_cliff_wherever_the_view_goes),
      cmocka_unit_test(another_time_takes_the_place_of_one_while_it_is_shown),
      cmocka_unit_test(what_is_wrong_is_said),
      cmocka_unit_test(failing_allocations_leave_nothing_behind),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
