/* Streams whose scene and edits change: what is touched is built again, everything else stays to the bit. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* after the four above */
#include <cmocka.h>

#include <scree/draco.h>

#include "failing_allocator.h"
#include "rounds.h"
#include "scene_internal.h"
#include "scene_layers.h"
#include "stream_host.h"
#include "synthetic_field.h"

enum { LAYERS = 3, BALLS = 6 };

/* A scene of three layers of two packs, each of some balls that can be moved. */
typedef struct changing_world {
  uint8_t* bytes[2];
  size_t sizes[2];
  scree_pack* packs[2];
  scree_field* fields[LAYERS];
  scree_shape shapes[LAYERS][BALLS + 1];
  scree_support* supports[LAYERS];
  float density[LAYERS];
  float shell; /* of all layers */
  uint32_t layer_count;
  scree_scene* scene;
  scree_edits* edits;
} changing_world;

static scree_support* make_support(changing_world* w, uint32_t layer) {
  scree_support_desc desc = {.shapes = w->shapes[layer], .shape_count = BALLS + 1};
  scree_support* support;
  assert_int_equal(scree_support_create(&desc, NULL, &support, NULL), SCREE_OK);
  return support;
}

static scree_scene* make_scene(changing_world* w) {
  scree_layer layers[LAYERS] = {{0}};
  for (uint32_t k = 0; k < w->layer_count; ++k)
    layers[k] = (scree_layer){.field = w->fields[k],
                              .support = w->supports[k],
                              .key = (uint16_t)(k + 1),
                              .density = w->density[k],
                              .shell_depth = w->shell};
  scree_scene_desc desc = {layers, w->layer_count};
  scree_scene* scene;
  assert_int_equal(scree_scene_create(&desc, NULL, &scene, NULL), SCREE_OK);
  return scene;
}

static void world_make(changing_world* w, random_stream* r) {
  static const uint32_t children[] = {1, 2, 3, 4, 5, 6};
  memset(w, 0, sizeof *w);
  for (uint32_t i = 0; i < 2; ++i) {
    w->bytes[i] = stream_pack_make(false, 3, i + 1, &w->sizes[i]);
    assert_int_equal(scree_pack_open_memory(w->bytes[i], w->sizes[i], NULL, &w->packs[i]), SCREE_OK);
  }
  w->layer_count = LAYERS;
  for (uint32_t k = 0; k < LAYERS; ++k) {
    scree_field_desc field = {.pack = w->packs[k & 1], .seed = k, .cell_size = 0.8 + 0.2 * k, .origin = {3.0 * k, 0.5, 7}};
    assert_int_equal(scree_field_create(&field, NULL, &w->fields[k]), SCREE_OK);
    w->shapes[k][0] = (scree_shape){.kind = SCREE_SHAPE_UNION, .group = {children, BALLS, 0}};
    for (uint32_t i = 1; i <= BALLS; ++i) {
      w->shapes[k][i] = (scree_shape){.kind = SCREE_SHAPE_SPHERE, .sphere = {(float)random_in(r, 2, 5)}};
      for (int a = 0; a < 3; ++a) w->shapes[k][i].transform.translation[a] = (float)random_in(r, -25, 25);
    }
    w->supports[k] = make_support(w, k);
  }
  w->scene = make_scene(w);
  assert_int_equal(scree_edits_create(NULL, &w->edits), SCREE_OK);
}

static void world_free(changing_world* w) {
  scree_scene_destroy(w->scene);
  scree_edits_destroy(w->edits);
  for (uint32_t k = 0; k < LAYERS; ++k) {
    scree_support_destroy(w->supports[k]);
    scree_field_destroy(w->fields[k]);
  }
  for (uint32_t i = 0; i < 2; ++i) {
    scree_pack_close(w->packs[i]);
    free(w->bytes[i]);
  }
}

/* Hands a changed world to a stream; what was before is gone afterwards, as a game would do it. */
static void hand_over(changing_world* w, stream_host* h, scree_support* old_support) {
  scree_scene* scene = make_scene(w);
  assert_int_equal(scree_stream_set_scene(h->stream, scene), SCREE_OK);
  scree_scene_destroy(w->scene);
  scree_support_destroy(old_support);
  w->scene = scene;
  h->desc.scene = scene;
  host_use_scene(h, scene);
}

static void move_ball(changing_world* w, stream_host* h, random_stream* r) {
  uint32_t layer = random_below(r, LAYERS);
  for (int a = 0; a < 3; ++a) w->shapes[layer][1 + random_below(r, BALLS)].transform.translation[a] = (float)random_in(r, -25, 25);
  scree_support* old = w->supports[layer];
  w->supports[layer] = make_support(w, layer);
  hand_over(w, h, old);
}

/* Sets or takes back the edits of some rocks that are shown. */
static void edit_some(changing_world* w, stream_host* h, random_stream* r) {
  scree_id ids[20];
  uint32_t count = 0;
  for (uint32_t i = 0; i < 200 && count < 20; ++i) {
    uint32_t place = random_below(r, h->caps.instances);
    if (h->owners[place] != 0) ids[count++] = h->ids[place];
  }
  scree_stream_wait(h->stream);
  for (uint32_t i = 0; i < count; ++i)
    assert_int_equal(scree_edits_set(w->edits, &ids[i], (scree_edit)random_below(r, 3)), SCREE_OK);
  if (random_below(r, 8) == 0) {
    scree_edits_clear(w->edits);
    count = 0;
  }
  if (count > 0 || scree_edits_count(w->edits) == 0) assert_int_equal(scree_stream_edited(h->stream, ids, count), SCREE_OK);
}

static scree_stream_desc describe(const changing_world* w) {
  return (scree_stream_desc){.scene = w->scene,
                             .edits = w->edits,
                             .view_distance = 28,
                             .max_error_pixels = 3,
                             .caps = {.instances = 40000, .blocks = 600},
                             .decode = stream_decode_pattern};
}

static void changes_end_in_the_truth(void** state) {
  (void)state;
  random_stream r = {17};
  changing_world w;
  world_make(&w, &r);
  for (int round = 0; round < 3; ++round) {
    scree_stream_desc desc = describe(&w);
    desc.deterministic = round == 1;
    desc.fade_seconds = round == 2 ? 0.05f : 0;
    stream_host h;
    host_create(&h, &desc, NULL);
    scree_view view = host_view(0, 5, 0);
    for (int i = 0; i < 100; ++i) {
      uint32_t changes = random_below(&r, 3);
      for (uint32_t k = 0; k < changes; ++k) {
        if (random_below(&r, 2))
          move_ball(&w, &h, &r);
        else
          edit_some(&w, &h, &r);
        host_update(&h, &view, 1);
      }
      for (int a = 0; a < 3; ++a) view.position[a] = i % 20 ? view.position[a] + random_in(&r, -2, 2) : random_in(&r, -20, 20);
      host_settle(&h, &view, 1, 500);
      if (i % 10 == 0) host_check(&h);
      host_check_truth(&h, &view, 1, true);
    }
    host_destroy(&h);
  }
  world_free(&w);
}

/* A hole that wanders through a ball: rocks of its shell, far from it, come and go. */
static void shells_follow_a_support_that_changes(void** state) {
  (void)state;
  static const uint32_t two[] = {1, 2};
  random_stream r = {37};
  changing_world w;
  world_make(&w, &r);
  w.layer_count = 1;
  w.shell = 8;
  w.shapes[0][0] = (scree_shape){.kind = SCREE_SHAPE_DIFFERENCE, .group = {two, 2, 0}};
  w.shapes[0][1] = (scree_shape){.kind = SCREE_SHAPE_SPHERE, .sphere = {16}};
  w.shapes[0][2] = (scree_shape){.kind = SCREE_SHAPE_SPHERE, .sphere = {1}};
  scree_stream_desc desc = describe(&w);
  desc.caps.instances = 80000;
  stream_host h;
  for (int i = 0; i < 25; ++i) {
    for (int a = 0; a < 3; ++a) w.shapes[0][2].transform.translation[a] = (float)random_in(&r, -7, 7);
    scree_support* old = w.supports[0];
    scree_support_desc support = {.shapes = w.shapes[0], .shape_count = 3};
    assert_int_equal(scree_support_create(&support, NULL, &w.supports[0], NULL), SCREE_OK);
    if (i == 0) {
      scree_scene_destroy(w.scene);
      desc.scene = w.scene = make_scene(&w);
      host_create(&h, &desc, NULL);
      scree_support_destroy(old);
    } else {
      hand_over(&w, &h, old);
    }
    scree_view view = host_view(0, 5, 0);
    host_settle(&h, &view, 1, 500);
    host_check_truth(&h, &view, 1, true);
  }
  host_destroy(&h);
  world_free(&w);
}

static void layers_come_and_go(void** state) {
  (void)state;
  random_stream r = {23};
  changing_world w;
  world_make(&w, &r);
  scree_stream_desc desc = describe(&w);
  stream_host h;
  host_create(&h, &desc, NULL);
  scree_view view = host_view(0, 5, 0);
  for (int i = 0; i < 60; ++i) {
    w.layer_count = 1 + random_below(&r, LAYERS);
    for (uint32_t k = 0; k < LAYERS; ++k) w.density[k] = random_below(&r, 3) ? 1 : 0.5f;
    hand_over(&w, &h, NULL);
    for (uint32_t k = random_below(&r, 4); k > 0; --k) host_update(&h, &view, 1);
    if (i % 3 != 0) continue;
    host_settle(&h, &view, 1, 500);
    host_check(&h);
    host_check_truth(&h, &view, 1, true);
    if (w.layer_count == 1) { /* what the other pack brought has gone */
      for (uint32_t m = 0; m < h.mesh_slots; ++m) assert_true(!h.meshes[m].in || h.meshes[m].pack == w.packs[0]);
    }
  }
  host_destroy(&h);
  world_free(&w);
}

static void an_edit_sends_only_the_blocks_it_touches(void** state) {
  (void)state;
  random_stream r = {29};
  changing_world w;
  world_make(&w, &r);
  scree_stream_desc desc = describe(&w);
  desc.view_distance = 60;
  stream_host h;
  host_create(&h, &desc, NULL);
  scree_view view = host_view(0, 5, 0);
  host_settle(&h, &view, 1, 800);
  uint32_t place = 0;
  while (h.owners[place] == 0) ++place;
  scree_id id = h.ids[place];
  uint32_t slot = h.owners[place] - 1, sent = 0;
  double at[3];
  for (int a = 0; a < 3; ++a) at[a] = h.blocks[slot].origin[a] + (double)h.instances[place].position[a];
  scree_stream_wait(h.stream);
  assert_int_equal(scree_edits_set(w.edits, &id, SCREE_EDIT_REMOVE), SCREE_OK);
  assert_int_equal(scree_stream_edited(h.stream, &id, 1), SCREE_OK);
  for (int i = 0; i < 6; ++i) {
    uint64_t before[5];
    memcpy(before, h.counts, sizeof before);
    host_block* blocks = malloc(h.caps.blocks * sizeof *blocks);
    memcpy(blocks, h.blocks, h.caps.blocks * sizeof *blocks);
    host_update(&h, &view, 1);
    for (uint32_t k = 0; k < h.caps.blocks; ++k) {
      if (memcmp(&blocks[k], &h.blocks[k], sizeof *blocks) == 0) continue;
      ++sent;
      for (int a = 0; a < 3; ++a) { /* not far from the rock */
        assert_true(blocks[k].origin[a] + (double)blocks[k].min[a] - 12 <= at[a]);
        assert_true(blocks[k].origin[a] + (double)blocks[k].max[a] + 12 >= at[a]);
      }
    }
    free(blocks);
  }
  assert_true(sent > 0 && sent < h.shown_blocks / 3);
  host_settle(&h, &view, 1, 200);
  host_check_truth(&h, &view, 1, true);
  host_destroy(&h);
  world_free(&w);
}

static scree_rock* visible_rocks(const scree_scene* scene, uint64_t* count) {
  scree_scratch* scratch;
  assert_int_equal(scree_scratch_create(NULL, &scratch), SCREE_OK);
  scree_scene_query_desc query = {.scene = scene, .flags = SCREE_SCENE_VISIBLE};
  assert_int_equal(scree_scene_count(&query, scratch, count), SCREE_OK);
  scree_rock* rocks = malloc((*count + 1) * sizeof *rocks);
  assert_int_equal(scree_scene_fill(&query, scratch, rocks, *count, count), SCREE_OK);
  scree_scratch_destroy(scratch);
  return rocks;
}

static int by_id(const void* a, const void* b) {
  return memcmp(&((const scree_rock*)a)->id, &((const scree_rock*)b)->id, sizeof(scree_id));
}

/* How far the cell of a rock is from a box, along the axis on which that is most. */
static double cell_away(const changing_world* w, const scree_rock* rock, const double low[3], const double high[3]) {
  const scree_field* field = w->fields[rock->id.layer - 1];
  int64_t cell[3];
  double away = 0;
  rock_cell(field, &rock->id, cell);
  for (int a = 0; a < 3; ++a) {
    double from = field->origin[a] + field->cell_size * ((double)cell[a] - 0.5);
    away = fmax(away, fmax(low[a] - from - field->cell_size, from - high[a]));
  }
  return away;
}

/* A ball that moves inside another, as a hole in a layer or as rocks of their own: what is visible changes within
 * scree_rt_scene_reach of it, and not within much less. */
static void what_changes_is_within_reach(void** state) {
  (void)state;
  static const uint32_t two[] = {1, 2};
  double farthest = 0; /* share of the reach, in the layer that changes */
  for (uint32_t round = 0; round < 24; ++round) {
    random_stream r = {round};
    changing_world w;
    world_make(&w, &r);
    w.layer_count = round % 2 ? 1 : LAYERS;
    for (uint32_t k = 0; k < LAYERS; ++k) {
      scree_shape_kind kind = k == 0 ? SCREE_SHAPE_DIFFERENCE : SCREE_SHAPE_UNION;
      w.shapes[k][0] = (scree_shape){.kind = kind, .group = {two, 2, 0}};
      w.shapes[k][1] = (scree_shape){.kind = SCREE_SHAPE_SPHERE, .sphere = {11}};
      w.shapes[k][2].sphere.radius = k == 0 ? 1.5f : 2;
      for (int a = 0; a < 3; ++a) w.shapes[k][2].transform.translation[a] = (float)random_in(&r, -6, 6);
      scree_support_destroy(w.supports[k]);
      scree_support_desc desc = {.shapes = w.shapes[k], .shape_count = 3};
      assert_int_equal(scree_support_create(&desc, NULL, &w.supports[k], NULL), SCREE_OK);
    }
    scree_scene *was = make_scene(&w), *is;
    scree_support* old = w.supports[0];
    double low[3], high[3];
    for (int a = 0; a < 3; ++a) {
      float *at = &w.shapes[0][2].transform.translation[a], before = *at, radius = w.shapes[0][2].sphere.radius;
      *at += (float)random_in(&r, -0.5, 0.5);
      low[a] = (double)(fminf(before, *at) - radius);
      high[a] = (double)(fmaxf(before, *at) + radius);
    }
    scree_support_desc desc = {.shapes = w.shapes[0], .shape_count = 3};
    assert_int_equal(scree_support_create(&desc, NULL, &w.supports[0], NULL), SCREE_OK);
    is = make_scene(&w);
    uint64_t counts[2];
    scree_rock* rocks[2] = {visible_rocks(was, &counts[0]), visible_rocks(is, &counts[1])};
    for (int k = 0; k < 2; ++k) qsort(rocks[k], counts[k], sizeof *rocks[k], by_id);
    for (int k = 0; k < 2; ++k)
      for (uint64_t i = 0; i < counts[k]; ++i) {
        if (bsearch(&rocks[k][i], rocks[1 - k], counts[1 - k], sizeof **rocks, by_id) != NULL) continue;
        uint32_t layer = rocks[k][i].id.layer - 1u;
        double share = cell_away(&w, &rocks[k][i], low, high) / scree_rt_scene_reach(is, layer);
        assert_true(share <= 1);
        if (layer == 0) farthest = fmax(farthest, share);
      }
    for (int k = 0; k < 2; ++k) free(rocks[k]);
    scree_scene_destroy(was);
    scree_scene_destroy(is);
    scree_support_destroy(old);
    world_free(&w);
  }
  assert_true(farthest > 0.6);
}

static void a_scene_that_does_not_fit_changes_nothing(void** state) {
  (void)state;
  random_stream r = {31};
  changing_world w;
  world_make(&w, &r);
  w.layer_count = 1;
  scree_scene* small = make_scene(&w);
  scree_stream_desc desc = describe(&w);
  desc.scene = small;
  desc.caps.mesh_bytes = 1700000; /* the coarsest levels of one pack */
  stream_host h;
  host_create(&h, &desc, NULL);
  scree_view view = host_view(0, 5, 0);
  host_settle(&h, &view, 1, 500);
  assert_int_equal(scree_stream_set_scene(h.stream, w.scene), SCREE_ERROR_CAPACITY);
  assert_int_equal(scree_stream_set_scene(h.stream, NULL), SCREE_ERROR_INVALID_ARGUMENT);
  host_update(&h, &view, 1);
  assert_int_equal(h.events, 0);
  view.position[0] += 10;
  host_settle(&h, &view, 1, 500);
  host_check_truth(&h, &view, 1, false);
  host_destroy(&h);
  scree_scene_destroy(small);
  world_free(&w);
}

/* A flight over what is left of packs: meshes that come in are sound, and rays and hulls end. Returns how many blocks came. */
static uint32_t fly_over_ruins(const changing_world* w, scree_stream* stream, random_stream* r, double* time) {
  scree_scratch* scratch;
  assert_int_equal(scree_scratch_create(NULL, &scratch), SCREE_OK);
  uint32_t blocks = 0;
  for (int i = 0; i < 60; ++i) {
    scree_view view = host_view(random_in(r, -25, 25), random_in(r, -25, 25), random_in(r, -25, 25));
    const scree_event* events;
    uint32_t count;
    scree_stream_wait(stream);
    assert_int_equal(scree_stream_update(stream, &view, 1, *time += 0.1, &events, &count), SCREE_OK);
    for (uint32_t k = 0; k < count; ++k) {
      const scree_event_mesh* mesh = &events[k].mesh;
      blocks += events[k].kind == SCREE_EVENT_BLOCK_IN;
      for (uint32_t v = 0; events[k].kind == SCREE_EVENT_MESH_IN && v < mesh->index_count; ++v)
        assert_true(mesh->indices[v] < mesh->vertex_count);
    }
    const double down[3] = {random_in(r, -1, 1), -1, random_in(r, -1, 1)};
    bool found;
    scree_hit hit;
    scree_rock near[8];
    uint64_t rocks;
    assert_int_equal(scree_scene_ray_cast(w->scene, w->edits, scratch, view.position, down, 50, &found, &hit), SCREE_OK);
    scree_result result = scree_scene_near(w->scene, w->edits, scratch, view.position, 1, 2, view.position, near, 8, &rocks);
    assert_true(result == SCREE_OK || result == SCREE_ERROR_CAPACITY);
  }
  scree_scratch_destroy(scratch);
  return blocks;
}

/* A file that is cut or written over while it is mapped: its bytes are others from one update to the next. */
static void packs_that_go_bad_under_a_stream_cost_meshes_and_nothing_else(void** state) {
  (void)state;
  for (uint32_t round = 0; round < 12; ++round) {
    random_stream r = {round};
    changing_world w;
    world_make(&w, &r);
    scree_stream_desc desc = describe(&w);
    desc.decode = scree_draco_decode_u16;
    failing_allocator memory = {.fail_at = -1};
    const scree_allocator allocator = failing_allocator_of(&memory);
    scree_stream* stream;
    assert_int_equal(scree_stream_create(&desc, &allocator, &stream, NULL), SCREE_OK);
    double time = 0;
    if (round % 2) fly_over_ruins(&w, stream, &r, &time); /* they are still whole */
    for (uint32_t i = 0; i < 2; ++i)
      for (size_t k = 0; k < w.sizes[i]; ++k)
        if (round < 8 || random_below(&r, 50) == 0)
          w.bytes[i][k] = round < 2 ? 0 : round < 4 ? 255 : round < 6 ? 63 : (uint8_t)random_below(&r, 256);
    assert_true(fly_over_ruins(&w, stream, &r, &time) > 0);
    scree_stream_destroy(stream);
    assert_int_equal(memory.live, 0);
    world_free(&w);
  }
}

/* Under caps that all bind; the host checks every event against them. Over a mountain, and as long as one likes:
 * SCREE_BENCH_UPDATES=1000000 scree-bench-stream stream.soak. */
static void twenty_thousand_updates_with_changes_neither_grow_nor_leak(void** state) {
  (void)state;
  random_stream r = {41};
  changing_world w;
  world_make(&w, &r);
  scree_stream_desc desc = describe(&w);
  desc.caps = (scree_stream_caps){
      .instances = 3000, .blocks = 40, .mesh_bytes = 3900000, .upload_bytes = 60000, .builds = 3, .events = 120};
  failing_allocator memory = {.fail_at = -1};
  const scree_allocator allocator = failing_allocator_of(&memory);
  stream_host h;
  host_create(&h, &desc, &allocator);
  scree_view view = host_view(0, 5, 0);
  long long early = 0;
  for (int i = 0; i < ROUNDS(20000, 5); ++i) {
    if (i % 37 == 0) edit_some(&w, &h, &r);
    if (i % 501 == 0) move_ball(&w, &h, &r);
    for (int a = 0; a < 3; ++a) {
      view.position[a] = i % 300 ? view.position[a] + random_in(&r, -0.7, 0.7) : random_in(&r, -25, 25);
      view.position[a] = fmin(fmax(view.position[a], -35), 35);
    }
    host_update(&h, &view, 1);
    if (i % 1000 == 0) host_check(&h);
    if (i == ROUNDS(10000, 5)) early = memory.live;
  }
  assert_true(memory.live <= early + early / 4); /* each of the builds may still meet a denser block */
  host_destroy(&h);
  assert_int_equal(memory.live, 0);
  world_free(&w);
}

/* Each allocation from set_scene on fails once: the call says so and changes nothing, or updates make up for it. */
static void a_change_of_scene_survives_every_allocation_that_fails(void** state) {
  (void)state;
  random_stream r = {21};
  changing_world w;
  world_make(&w, &r);
  w.layer_count = 1;
  scree_scene* small = make_scene(&w);
  w.layer_count = LAYERS; /* brings another pack and larger tables */
  scree_view view = host_view(2, 3, 4);
  bool failed = true;
  uint32_t refused = 0;
  for (int32_t n = 0; failed; ++n) {
    failing_allocator memory = {.fail_at = -1};
    const scree_allocator allocator = failing_allocator_of(&memory);
    scree_stream_desc desc = describe(&w);
    desc.scene = small;
    desc.view_distance = 12;
    desc.caps = (scree_stream_caps){.instances = 20000, .blocks = 300, .builds = 3, .decodes = 8};
    stream_host h;
    host_create(&h, &desc, &allocator);
    host_settle(&h, &view, 1, 500);
    memory.fail_at = memory.calls + n;
    scree_result result = scree_stream_set_scene(h.stream, w.scene);
    if (result != SCREE_OK) {
      assert_int_equal(result, SCREE_ERROR_OUT_OF_MEMORY);
      ++refused;
      host_settle(&h, &view, 1, 500);
      host_check_truth(&h, &view, 1, true);
      assert_int_equal(scree_stream_set_scene(h.stream, w.scene), SCREE_OK);
    }
    h.desc.scene = w.scene;
    host_use_scene(&h, w.scene);
    host_settle(&h, &view, 1, 800);
    uint32_t place = 0;
    while (h.owners[place] == 0) ++place;
    scree_id id = h.ids[place];
    assert_int_equal(scree_edits_set(w.edits, &id, SCREE_EDIT_REMOVE), SCREE_OK);
    assert_int_equal(scree_stream_edited(h.stream, &id, 1), SCREE_OK);
    host_settle(&h, &view, 1, 500);
    host_check(&h);
    host_check_truth(&h, &view, 1, true);
    failed = memory.failed;
    scree_edits_clear(w.edits);
    host_destroy(&h);
    assert_int_equal(memory.live, 0);
  }
  assert_true(refused > 1);
  scree_scene_destroy(small);
  world_free(&w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(changes_end_in_the_truth),
      cmocka_unit_test(shells_follow_a_support_that_changes),
      cmocka_unit_test(layers_come_and_go),
      cmocka_unit_test(a_change_of_scene_survives_every_allocation_that_fails),
      cmocka_unit_test(an_edit_sends_only_the_blocks_it_touches),
      cmocka_unit_test(what_changes_is_within_reach),
      cmocka_unit_test(a_scene_that_does_not_fit_changes_nothing),
      cmocka_unit_test(packs_that_go_bad_under_a_stream_cost_meshes_and_nothing_else),
      cmocka_unit_test(twenty_thousand_updates_with_changes_neither_grow_nor_leak),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
