#include "stream_host.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* after the four above */
#include <cmocka.h>

#include "lattice.h"
#include "pack_writer.h"
#include "scatter_internal.h"
#include "stream_internal.h"
#include "synthetic_field.h"

static void* must(void* memory) {
  if (memory == NULL) abort();
  return memory;
}

/* --- worlds ----------------------------------------------------------------------------------------------------------------- */

uint8_t* stream_pack_make(bool proxies, uint32_t levels, uint64_t seed, size_t* size) {
  const test_pack_desc desc = {.cells_per_cube = 3, .lod_count = levels, .voxels_per_cell = 8, .shapes = 3, .proxies = proxies};
  rock_set* set = test_rock_set_make(&desc);
  for (uint32_t i = 0; i < set->rock_count; ++i) {
    rock_record* rock = (rock_record*)&set->rocks[i];
    rock->burial = 1 + (uint32_t)(hash_mix(seed + i) % 4);
    for (uint32_t level = 0; level < levels; ++level)
      rock->lods[level].error = 0.03f * (float)(level * level) * (1 + (float)(hash_mix(seed ^ i) % 100) / 50);
  }
  for (uint32_t i = 0; proxies && i < 256 * 9; ++i)
    for (uint32_t level = 0; level < levels; ++level)
      ((proxy_record*)&set->proxies[i])->lods[level].error = 0.4f + 0.3f * (float)level;
  uint8_t* bytes;
  if (pack_write(set, NULL, &bytes, size) != SCREE_OK) abort();
  test_rock_set_free(set);
  return bytes;
}

static void make_shapes(scree_shape shapes[8]) {
  static const uint32_t children[] = {1, 2, 3, 4};
  memset(shapes, 0, 8 * sizeof *shapes);
  shapes[0] = (scree_shape){.kind = SCREE_SHAPE_UNION, .group = {children, 4, 0}};
  shapes[1] = (scree_shape){.kind = SCREE_SHAPE_CYLINDER, .cylinder = {60, 1.6f}};
  shapes[2] = (scree_shape){.kind = SCREE_SHAPE_SPHERE, .sphere = {8}, .transform.translation = {10, 6, -20}};
  shapes[3] = (scree_shape){.kind = SCREE_SHAPE_SPHERE, .sphere = {5}, .transform.translation = {-30, 3, 25}};
  shapes[4] = (scree_shape){.kind = SCREE_SHAPE_CONE, .cone = {12, 9}, .transform.translation = {25, 0, 30}};
}

void stream_world_make(stream_world* w, const stream_world_desc* desc) {
  memset(w, 0, sizeof *w);
  w->bytes = stream_pack_make(desc->proxies, desc->levels > 0 ? desc->levels : 3, 7, &w->size);
  assert_int_equal(scree_pack_open_memory(w->bytes, w->size, NULL, &w->pack), SCREE_OK);
  double o = desc->origin;
  scree_field_desc field = {
      .pack = w->pack, .seed = 11, .cell_size = desc->cell_size > 0 ? desc->cell_size : 1, .origin = {o, o, o}};
  assert_int_equal(scree_field_create(&field, NULL, &w->field), SCREE_OK);
  scree_shape shapes[8];
  make_shapes(shapes);
  scree_support_desc support = {.shapes = shapes, .shape_count = 5, .origin = {o, o, o}};
  if (desc->shapes != NULL) {
    support.shapes = desc->shapes;
    support.shape_count = desc->shape_count;
  }
  assert_int_equal(scree_support_create(&support, NULL, &w->support, NULL), SCREE_OK);
  scree_layer layer = {.field = w->field, .support = w->support};
  scree_scene_desc scene = {&layer, 1};
  assert_int_equal(scree_scene_create(&scene, NULL, &w->scene, NULL), SCREE_OK);
  assert_int_equal(scree_edits_create(NULL, &w->edits), SCREE_OK);
}

void stream_world_free(stream_world* w) {
  scree_edits_destroy(w->edits);
  scree_scene_destroy(w->scene);
  scree_support_destroy(w->support);
  scree_field_destroy(w->field);
  scree_pack_close(w->pack);
  free(w->bytes);
}

/* --- decoders --------------------------------------------------------------------------------------------------------------- */

scree_result stream_decode_pattern(const scree_pack* pack, uint32_t asset, uint32_t lod, scree_vertex* vertices,
                                   size_t vertex_capacity, uint16_t* indices, size_t index_capacity) {
  scree_lod record;
  if (scree_pack_get_lod(pack, asset, lod, &record) != SCREE_OK) return SCREE_ERROR_INVALID_ARGUMENT;
  if (record.vertices > vertex_capacity || (size_t)record.triangles * 3 > index_capacity) return SCREE_ERROR_CAPACITY;
  for (uint32_t i = 0; i < record.vertices; ++i)
    vertices[i] = (scree_vertex){.position = {(int16_t)asset, (int16_t)lod, (int16_t)i}};
  for (uint32_t i = 0; i < record.triangles * 3; ++i) indices[i] = (uint16_t)(i % record.vertices);
  return SCREE_OK;
}

scree_result stream_decode_broken(const scree_pack* pack, uint32_t asset, uint32_t lod, scree_vertex* vertices,
                                  size_t vertex_capacity, uint16_t* indices, size_t index_capacity) {
  (void)pack, (void)asset, (void)lod, (void)vertices, (void)vertex_capacity, (void)indices, (void)index_capacity;
  return SCREE_ERROR_IO;
}

bool stream_decode_fails(uint32_t asset, uint32_t lod) {
  return hash_mix(asset * 8 + lod) % 3 == 0;
}

scree_result stream_decode_flaky(const scree_pack* pack, uint32_t asset, uint32_t lod, scree_vertex* vertices,
                                 size_t vertex_capacity, uint16_t* indices, size_t index_capacity) {
  if (stream_decode_fails(asset, lod)) return SCREE_ERROR_CORRUPT;
  return stream_decode_pattern(pack, asset, lod, vertices, vertex_capacity, indices, index_capacity);
}

/* --- packs ------------------------------------------------------------------------------------------------------------------ */

static uint32_t pack_index(stream_host* h, const scree_pack* pack) {
  for (uint32_t i = 0; i < h->pack_count; ++i)
    if (h->packs[i] == pack) return i;
  fail_msg("a pack that no layer has");
  return 0;
}

void host_use_scene(stream_host* h, const scree_scene* scene) {
  for (uint32_t i = 0; i < scree_scene_layer_count(scene); ++i) {
    const scree_layer* layer = scree_scene_layer(scene, i);
    const scree_pack* pack = layer->scatter != NULL ? layer->scatter->pack : layer->field->pack;
    h->layer_packs[i] = pack;
    bool known = pack == NULL; /* models of the host's own have no meshes here */
    for (uint32_t k = 0; k < h->pack_count; ++k) known = known || h->packs[k] == pack;
    if (known) continue;
    assert_true(h->pack_count < 8);
    uint32_t k = h->pack_count++;
    h->packs[k] = pack;
    scree_pack_get_info(pack, &h->infos[k]);
    uint32_t count = (h->infos[k].asset_count + h->infos[k].proxy_count) * h->infos[k].lod_count;
    h->slots[k] = must(malloc(count * sizeof **h->slots));
    for (uint32_t m = 0; m < count; ++m) h->slots[k][m] = UINT32_MAX;
  }
  uint32_t slots = scree_stream_mesh_slots(h->stream);
  if (slots > h->mesh_slots) {
    h->meshes = must(realloc(h->meshes, slots * sizeof *h->meshes));
    memset(h->meshes + h->mesh_slots, 0, (slots - h->mesh_slots) * sizeof *h->meshes);
    h->mesh_slots = slots;
  }
}

/* --- create, destroy -------------------------------------------------------------------------------------------------------- */

void host_create(stream_host* h, const scree_stream_desc* desc, const scree_allocator* allocator) {
  memset(h, 0, sizeof *h);
  scree_error error;
  scree_result result = scree_stream_create(desc, allocator, &h->stream, &error);
  if (result != SCREE_OK) fail_msg("%s: %s", scree_result_string(result), error.message);
  h->desc = h->stream->desc;
  h->caps = h->desc.caps;
  h->blocks = must(calloc(h->caps.blocks, sizeof *h->blocks));
  h->instances = must(calloc(h->caps.instances, sizeof *h->instances));
  h->ids = must(calloc(h->caps.instances, sizeof *h->ids));
  h->owners = must(calloc(h->caps.instances, sizeof *h->owners));
  host_use_scene(h, desc->scene);
}

void host_destroy(stream_host* h) {
  scree_stream_destroy(h->stream);
  for (uint32_t i = 0; i < h->pack_count; ++i) free(h->slots[i]);
  free(h->meshes);
  free(h->blocks);
  free(h->instances);
  free(h->ids);
  free(h->owners);
}

/* --- events ----------------------------------------------------------------------------------------------------------------- */

static void digest(stream_host* h, const void* bytes, size_t size) {
  const uint8_t* p = bytes;
  uint64_t word;
  for (; size >= 8; size -= 8, p += 8) {
    memcpy(&word, p, 8);
    h->digest = hash_combine(h->digest, word);
  }
  word = 0;
  memcpy(&word, p, size);
  h->digest = hash_combine(h->digest, word);
}

static void mesh_in(stream_host* h, const scree_event_mesh* e) {
  uint32_t pack = pack_index(h, e->pack), levels = h->infos[pack].lod_count;
  scree_lod lod;
  assert_int_equal(scree_pack_get_lod(e->pack, e->asset, e->level, &lod), SCREE_OK);
  assert_int_equal(e->vertex_count, lod.vertices);
  assert_int_equal(e->index_count, lod.triangles * 3);
  assert_true(e->mesh < h->mesh_slots);
  host_mesh* mesh = &h->meshes[e->mesh];
  assert_false(mesh->in);
  assert_int_equal(h->slots[pack][e->asset * levels + e->level], UINT32_MAX);
  for (uint32_t i = 0; i < e->index_count; ++i) assert_true(e->indices[i] < e->vertex_count);
  if (e->level + 1 < levels && h->desc.decode != NULL) {
    assert_int_equal(e->vertices[e->vertex_count - 1].position[0], (int16_t)e->asset);
    assert_int_equal(e->vertices[e->vertex_count - 1].position[1], (int16_t)e->level);
    assert_int_equal(e->vertices[e->vertex_count - 1].position[2], (int16_t)(e->vertex_count - 1));
  }
  uint64_t bytes = e->vertex_count * sizeof(scree_vertex) + e->index_count * sizeof(uint16_t);
  *mesh = (host_mesh){true, e->pack, e->asset, e->level, 0, bytes};
  h->slots[pack][e->asset * levels + e->level] = e->mesh;
  h->mesh_bytes += bytes;
  h->uploaded += bytes;
  assert_true(h->mesh_bytes <= h->caps.mesh_bytes);
  digest(h, e->vertices, e->vertex_count * sizeof *e->vertices);
  digest(h, e->indices, e->index_count * sizeof *e->indices);
}

static void mesh_out(stream_host* h, const scree_event_mesh* e) {
  assert_true(e->mesh < h->mesh_slots);
  host_mesh* mesh = &h->meshes[e->mesh];
  assert_true(mesh->in && mesh->pack == e->pack && mesh->asset == e->asset && mesh->level == e->level);
  assert_int_equal(mesh->users, 0);
  uint32_t pack = pack_index(h, e->pack);
  h->slots[pack][e->asset * h->infos[pack].lod_count + e->level] = UINT32_MAX;
  h->mesh_bytes -= mesh->bytes;
  mesh->in = false;
}

static void count_level(stream_host* h, const host_block* b, const scree_stream_run* run, uint32_t level, bool in) {
  if (h->layer_packs[b->layer] == NULL) {
    assert_int_equal(level, 0);
    return;
  }
  uint32_t pack = pack_index(h, h->layer_packs[b->layer]), levels = h->infos[pack].lod_count;
  assert_true(level < levels);
  for (uint32_t i = run->first; i < run->first + run->count; ++i) {
    uint32_t slot = h->slots[pack][h->instances[i].asset * levels + level];
    if (slot == UINT32_MAX && h->void_coarsest && level == levels - 1) continue;
    assert_int_not_equal(slot, UINT32_MAX);
    if (in && !b->leaving) assert_int_equal(scree_stream_mesh(h->stream, b->layer, h->instances[i].asset, level), slot);
    assert_true(h->meshes[slot].in);
    h->meshes[slot].users += in ? 1u : UINT32_MAX;
  }
}

static void count_runs(stream_host* h, const host_block* b, bool in) {
  for (uint32_t r = 0; r < b->run_count; ++r) {
    count_level(h, b, &b->runs[r], b->runs[r].level, in);
    if (b->runs[r].from_level != 255) count_level(h, b, &b->runs[r], b->runs[r].from_level, in);
  }
}

static void release_places(stream_host* h, uint32_t block) {
  host_block* b = &h->blocks[block];
  for (uint32_t i = b->first; i < b->first + b->count; ++i) {
    assert_int_equal(h->owners[i], block + 1);
    h->owners[i] = 0;
  }
  h->shown_instances -= b->count;
}

static void set_runs(stream_host* h, host_block* b, const scree_event_block* e) {
  assert_true(e->run_count <= SCREE_STREAM_RUNS);
  memcpy(b->runs, e->runs, e->run_count * sizeof *b->runs);
  b->run_count = e->run_count;
  uint32_t at = b->first;
  for (uint32_t r = 0; r < b->run_count; ++r) {
    assert_int_equal(b->runs[r].first, at);
    assert_true(b->runs[r].count > 0);
    at += b->runs[r].count;
  }
  assert_int_equal(at, b->first + b->count);
  h->uploaded += e->run_count * sizeof *e->runs;
}

static void set_instances(stream_host* h, uint32_t block, const scree_event_block* e) {
  host_block* b = &h->blocks[block];
  assert_non_null(e->instances);
  assert_non_null(e->ids);
  b->layer = e->layer;
  b->level = e->level;
  b->first = e->first_instance;
  b->count = e->instance_count;
  memcpy(b->origin, e->origin, sizeof b->origin);
  memcpy(b->min, e->min, sizeof b->min);
  memcpy(b->max, e->max, sizeof b->max);
  assert_true(b->count > 0 && b->first <= h->caps.instances && b->count <= h->caps.instances - b->first);
  for (uint32_t i = 0; i < b->count; ++i) {
    assert_int_equal(h->owners[b->first + i], 0);
    assert_int_equal(e->instances[i].block, block);
    h->owners[b->first + i] = block + 1;
    h->instances[b->first + i] = e->instances[i];
    h->ids[b->first + i] = e->ids[i];
  }
  h->shown_instances += b->count;
  assert_true(h->shown_instances <= h->caps.instances);
  h->uploaded += e->instance_count * sizeof *e->instances;
  digest(h, e->instances, e->instance_count * sizeof *e->instances);
  digest(h, e->ids, e->instance_count * sizeof *e->ids);
}

static void block_event(stream_host* h, scree_event_kind kind, const scree_event_block* e) {
  assert_true(e->block < h->caps.blocks);
  host_block* b = &h->blocks[e->block];
  assert_int_equal(b->shown, kind != SCREE_EVENT_BLOCK_IN);
  if (kind != SCREE_EVENT_BLOCK_IN) {
    assert_int_equal(e->layer, b->layer);
    assert_int_equal(e->level, b->level);
    count_runs(h, b, false);
  }
  if (kind == SCREE_EVENT_BLOCK_OUT) {
    release_places(h, e->block);
    b->shown = false;
    --h->shown_blocks;
    return;
  }
  if (kind == SCREE_EVENT_BLOCK_IN) {
    b->shown = true;
    ++h->shown_blocks;
    assert_true(h->shown_blocks <= h->caps.blocks);
  } else if (e->instances != NULL) {
    release_places(h, e->block);
  }
  if (kind == SCREE_EVENT_BLOCK_IN || e->instances != NULL) set_instances(h, e->block, e);
  assert_int_equal(e->first_instance, b->first);
  assert_int_equal(e->instance_count, b->count);
  b->leaving = e->leaving;
  set_runs(h, b, e);
  count_runs(h, b, true);
  digest(h, e->runs, e->run_count * sizeof *e->runs);
}

void host_update(stream_host* h, const scree_view* views, uint32_t view_count) {
  const scree_event* events;
  uint32_t count;
  h->time += 1.0 / 60;
  h->uploaded = 0;
  assert_int_equal(scree_stream_update(h->stream, views, view_count, h->time, &events, &count), SCREE_OK);
  assert_true(count <= h->caps.events);
  for (uint32_t i = 0; i < count; ++i) {
    const scree_event* e = &events[i];
    ++h->counts[e->kind];
    uint32_t head[4] = {e->kind, 0, 0, 0};
    if (e->kind == SCREE_EVENT_MESH_IN || e->kind == SCREE_EVENT_MESH_OUT) {
      head[1] = e->mesh.mesh;
      head[2] = e->mesh.asset;
      head[3] = e->mesh.level;
    } else {
      head[1] = e->block.block;
      head[2] = e->block.first_instance;
      head[3] = e->block.run_count;
    }
    digest(h, head, sizeof head);
    if (e->kind == SCREE_EVENT_MESH_IN)
      mesh_in(h, &e->mesh);
    else if (e->kind == SCREE_EVENT_MESH_OUT)
      mesh_out(h, &e->mesh);
    else
      block_event(h, e->kind, &e->block);
  }
  h->events = count;
  scree_stream_stats stats;
  scree_stream_get_stats(h->stream, &stats);
  assert_true(h->uploaded <= h->caps.upload_bytes);
  assert_int_equal(stats.upload_bytes, h->uploaded);
  assert_int_equal(stats.instances, h->shown_instances);
  assert_int_equal(stats.blocks, h->shown_blocks);
  assert_int_equal(stats.mesh_bytes, h->mesh_bytes);
  assert_true(stats.decodes <= h->caps.decodes && stats.builds <= h->caps.builds);
}

uint32_t host_settle(stream_host* h, const scree_view* views, uint32_t view_count, uint32_t most) {
  uint32_t quiet = 0;
  for (uint32_t i = 0; i < most; ++i) {
    scree_stream_wait(h->stream);
    host_update(h, views, view_count);
    scree_stream_stats stats;
    scree_stream_get_stats(h->stream, &stats);
    quiet = h->events == 0 && stats.builds == 0 && stats.decodes == 0 ? quiet + 1 : 0;
    if (quiet == 2 + (uint32_t)(h->desc.fade_seconds * 60)) return i + 1;
  }
  scree_stream_stats stats;
  scree_stream_get_stats(h->stream, &stats);
  fail_msg("not settled after %u updates: %u builds, %u decodes, %u coarser, %u degraded, %llu events", most, stats.builds,
           stats.decodes, stats.coarser, stats.degraded, (unsigned long long)h->events);
  return 0;
}

scree_view host_view(double x, double y, double z) {
  return (scree_view){.position = {x, y, z}, .field_of_view = 1.0471976f, .viewport_height = 1080};
}

/* --- checks ----------------------------------------------------------------------------------------------------------------- */

void host_check(const stream_host* h) {
  scree_stream_stats stats;
  scree_stream_get_stats(h->stream, &stats);
  uint32_t by_level[8] = {0}, proxies = 0, meshes = 0;
  uint64_t triangles = 0;
  for (uint32_t k = 0; k < h->caps.blocks; ++k) {
    const host_block* b = &h->blocks[k];
    if (!b->shown) continue;
    for (uint32_t r = 0; r < b->run_count; ++r) {
      const scree_stream_run* run = &b->runs[r];
      if (b->level == 0)
        by_level[run->level] += run->count;
      else
        proxies += run->count;
      for (uint32_t i = run->first; i < run->first + run->count; ++i) {
        scree_lod lod;
        scree_id id;
        const scree_pack* pack = h->layer_packs[b->layer];
        if (pack != NULL) {
          assert_int_equal(scree_pack_get_lod(pack, h->instances[i].asset, run->level, &lod), SCREE_OK);
          triangles += lod.triangles;
        }
        assert_int_equal(scree_stream_id(h->stream, i, &id), b->level == 0);
        if (b->level == 0) assert_memory_equal(&id, &h->ids[i], sizeof id);
        for (int a = 0; a < 3; ++a) {
          assert_true(h->instances[i].position[a] >= b->min[a] - 1e-3f);
          assert_true(h->instances[i].position[a] <= b->max[a] + 1e-3f);
        }
      }
    }
  }
  for (uint32_t i = 0; i < h->caps.instances; i += 7) {
    scree_id id;
    if (h->owners[i] == 0) assert_false(scree_stream_id(h->stream, i, &id));
  }
  for (uint32_t i = 0; i < h->mesh_slots; ++i) meshes += h->meshes[i].in;
  for (int i = 0; i < 8; ++i) assert_int_equal(stats.instances_by_level[i], by_level[i]);
  assert_int_equal(stats.proxies, proxies);
  assert_int_equal(stats.meshes, meshes);
  assert_int_equal(stats.triangles, triangles);
}

static int by_id(const void* a, const void* b) {
  return memcmp(&((const scree_rock*)a)->id, &((const scree_rock*)b)->id, sizeof(scree_id));
}

static double box_distance(const double p[3], const double low[3], const double high[3]) {
  double sum = 0;
  for (int a = 0; a < 3; ++a) {
    double d = p[a] < low[a] ? low[a] - p[a] : p[a] > high[a] ? p[a] - high[a] : 0;
    sum += d * d;
  }
  return sqrt(sum);
}

static int32_t floor_div(int32_t a, int32_t b) {
  return a / b - (a % b < 0);
}

/* Whether a rock's block is nearer to a view than view_distance. */
static bool is_in_view(const stream_host* h, const scree_id* id, uint32_t layer, const scree_view* views, uint32_t view_count) {
  const scree_field* field = scree_rt_scene_layer(h->desc.scene, layer)->field;
  double low[3], high[3], cell = field->cell_size, cube = cell * field->cells_per_cube;
  for (int a = 0; a < 3; ++a) {
    low[a] = field->origin[a] - 0.5 * cell + floor_div(id->cube[a], 4) * (4 * cube);
    high[a] = low[a] + 4 * cube;
  }
  for (uint32_t v = 0; v < view_count; ++v)
    if (box_distance(views[v].position, low, high) <= h->desc.view_distance) return true;
  return false;
}

/* The levels of a run: within what the rule says with and without hysteresis, from the class's own errors. */
static void check_run_level(const stream_host* h, const host_block* b, const scree_stream_run* run, double sharpness) {
  const scree_pack* pack = h->layer_packs[b->layer];
  const scree_stream* s = h->stream;
  const stream_pack* p = &s->packs[s->layers[b->layer].pack];
  uint8_t class = s->classes[p->first_asset + h->instances[run->first].asset];
  const scree_layer* layer = scree_scene_layer(h->desc.scene, b->layer);
  double cell = layer->scatter != NULL ? (double)layer->scatter->scale_max : layer->field->cell_size;
  if (pack == NULL) {
    assert_int_equal(run->level, 0);
    return;
  }
  uint32_t rule[2];
  for (int k = 0; k < 2; ++k) {
    double allowed = (double)h->desc.max_error_pixels * (k ? 1 : 1 / (1 + (double)h->desc.hysteresis)) * (1 + (k ? 1e-6 : -1e-6));
    rule[k] = 0;
    for (uint32_t level = 1; level < p->levels; ++level)
      if ((double)p->error[0][class][level] * cell * sharpness <= allowed) rule[k] = level;
  }
  assert_true(run->level >= rule[0] && run->level <= rule[1]);
  for (uint32_t i = run->first; i < run->first + run->count; ++i) {
    scree_lod lod;
    assert_int_equal(scree_pack_get_lod(pack, h->instances[i].asset, run->level, &lod), SCREE_OK);
    assert_true(lod.error <= p->error[0][class][run->level]);
    assert_true((double)lod.error * cell * sharpness <= (double)h->desc.max_error_pixels * 1.000001);
  }
}

void host_check_truth(const stream_host* h, const scree_view* views, uint32_t view_count, bool levels) {
  scree_scratch* scratch;
  assert_int_equal(scree_scratch_create(NULL, &scratch), SCREE_OK);
  scree_scene_query_desc query = {.scene = h->desc.scene, .edits = h->desc.edits, .flags = SCREE_SCENE_VISIBLE};
  uint64_t count, expected = 0;
  assert_int_equal(scree_scene_count(&query, scratch, &count), SCREE_OK);
  scree_rock* rocks = must(malloc((count + 1) * sizeof *rocks));
  assert_int_equal(scree_scene_fill(&query, scratch, rocks, count, &count), SCREE_OK);
  for (uint64_t i = 0; i < count; ++i) {
    uint32_t layer = scree_scene_layer_of(h->desc.scene, rocks[i].id.layer);
    if (is_in_view(h, &rocks[i].id, layer, views, view_count)) rocks[expected++] = rocks[i];
  }
  scree_rock* shown = must(malloc((h->shown_instances + 1) * sizeof *shown));
  uint32_t found = 0;
  for (uint32_t k = 0; k < h->caps.blocks; ++k) {
    const host_block* b = &h->blocks[k];
    if (!b->shown) continue;
    assert_int_equal(b->level, 0);
    double low[3], high[3], sharpness = 0;
    for (int a = 0; a < 3; ++a) {
      low[a] = b->origin[a] + (double)b->min[a];
      high[a] = b->origin[a] + (double)b->max[a];
    }
    for (uint32_t v = 0; v < view_count; ++v) {
      double pixels = (double)views[v].viewport_height / (2 * tan((double)views[v].field_of_view / 2));
      sharpness = fmax(sharpness, pixels / fmax(box_distance(views[v].position, low, high), 1e-9));
    }
    for (uint32_t r = 0; r < b->run_count; ++r) {
      if (levels) check_run_level(h, b, &b->runs[r], sharpness);
      for (uint32_t i = b->runs[r].first; i < b->runs[r].first + b->runs[r].count; ++i) {
        scree_rock* rock = &shown[found++];
        rock->asset = h->instances[i].asset;
        rock->id = h->ids[i];
        assert_int_equal(h->instances[i].random, scree_scene_random(h->desc.scene, &rock->id));
        for (int a = 0; a < 3; ++a) rock->position[a] = (float)(b->origin[a] + (double)h->instances[i].position[a]);
      }
    }
  }
  assert_int_equal(found, expected);
  qsort(rocks, expected, sizeof *rocks, by_id);
  qsort(shown, found, sizeof *shown, by_id);
  for (uint32_t i = 0; i < found; ++i) {
    assert_memory_equal(&rocks[i].id, &shown[i].id, sizeof(scree_id));
    assert_int_equal(rocks[i].asset, shown[i].asset);
    for (int a = 0; a < 3; ++a)
      assert_true(fabsf(rocks[i].position[a] - shown[i].position[a]) <= 1e-4f * (1 + fabsf(rocks[i].position[a])));
  }
  free(rocks);
  free(shown);
  scree_scratch_destroy(scratch);
}
