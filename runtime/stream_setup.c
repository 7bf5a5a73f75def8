/* What a stream makes of a scene: layers, packs and the classes of their assets. See stream_internal.h. */
#include <math.h>
#include <string.h>

#include "scatter_internal.h"
#include "stream_internal.h"
#include "support_text.h"

static scree_result fail(scree_error* error, scree_result result, const char* message) {
  scree_rt_text_clear(error);
  scree_rt_text_add(error, message);
  return result;
}

/* --- the descriptor --------------------------------------------------------------------------------------------------------- */

static void default_u32(uint32_t* value, uint32_t usual) {
  if (*value == 0) *value = usual;
}

static void default_u64(uint64_t* value, uint64_t usual) {
  if (*value == 0) *value = usual;
}

scree_result scree_rt_stream_check(scree_stream_desc* d, scree_error* error) {
  if (d->scene == NULL) return fail(error, SCREE_ERROR_INVALID_ARGUMENT, "scene: expected one");
  if (!(d->view_distance > 0 && isfinite(d->view_distance))) return fail(error, SCREE_ERROR_RANGE, "view_distance: expected > 0");
  if (!(d->max_error_pixels >= 0 && isfinite(d->max_error_pixels)))
    return fail(error, SCREE_ERROR_RANGE, "max_error_pixels: expected > 0, or 0 for 1");
  if (!(d->hysteresis >= 0 && isfinite(d->hysteresis))) return fail(error, SCREE_ERROR_RANGE, "hysteresis: expected >= 0");
  if (!(d->fade_seconds >= 0 && isfinite(d->fade_seconds))) return fail(error, SCREE_ERROR_RANGE, "fade_seconds: expected >= 0");
  if (d->max_error_pixels == 0) d->max_error_pixels = 1;
  if (d->hysteresis == 0) d->hysteresis = 0.1f;
  default_u32(&d->caps.instances, 1u << 20);
  default_u32(&d->caps.blocks, 1u << 14);
  default_u64(&d->caps.mesh_bytes, UINT64_C(256) << 20);
  default_u64(&d->caps.upload_bytes, UINT64_C(8) << 20);
  default_u32(&d->caps.decodes, 64);
  default_u32(&d->caps.builds, 64);
  default_u32(&d->caps.events, 1u << 14);
  if (d->caps.instances > 1u << 30 || d->caps.blocks > 1u << 24 || d->caps.decodes > 1u << 16 || d->caps.builds > 1u << 16 ||
      d->caps.events > 1u << 24)
    return fail(error, SCREE_ERROR_RANGE, "caps: expected at most 2^30 instances, 2^24 blocks and events, 2^16 decodes and builds");
  for (uint32_t i = 0; i < scree_scene_layer_count(d->scene); ++i)
    if (scree_rt_scene_layer(d->scene, i)->scatter == NULL && scree_rt_scene_layer(d->scene, i)->field->pack == NULL)
      return fail(error, SCREE_ERROR_INVALID_ARGUMENT, "scene: a field without a pack has nothing to draw");
  return SCREE_OK;
}

/* --- packs ------------------------------------------------------------------------------------------------------------------ */

/* Whether a finer level of a rock can be asked for at all. */
static bool is_decodable(const scree_lod* lod, const scree_stream_caps* caps) {
  uint64_t bytes = (uint64_t)lod->vertices * sizeof(scree_vertex) + (uint64_t)lod->triangles * 6;
  return lod->vertices <= 65536 && lod->triangles <= UINT32_MAX / 3 && bytes <= caps->upload_bytes && bytes <= caps->mesh_bytes;
}

/* What a layer draws with. */
static stream_pack drawn_by(const scree_scene* scene, uint32_t layer) {
  const scree_layer* given = scree_rt_scene_layer(scene, layer);
  stream_pack pack = {.pack = given->scatter != NULL ? given->scatter->pack : given->field->pack};
  if (pack.pack == NULL) pack.models = given->scatter;
  return pack;
}

/* Models of the host's own have one level that counts as there and as nothing. */
static void measure_models(const scree_scatter* scatter, stream_pack* out) {
  *out = (stream_pack){.models = scatter, .assets = scatter->model_count, .total = scatter->model_count, .levels = 1};
  out->lattice[0] = 1;
  out->coarse_next[0] = out->assets;
}

static void fill_models(const stream_pack* p, stream_mesh* meshes, uint8_t* classes) {
  memset(classes + p->first_asset, 0, p->assets);
  for (uint32_t i = 0; i < p->assets; ++i)
    meshes[p->first_mesh + i] = (stream_mesh){.before = STREAM_NONE, .after = STREAM_NONE, .state = MESH_VOID, .coarsest = true};
}

/* Sizes of all meshes of a pack. */
static scree_result measure_pack(const scree_pack* pack, const scree_stream_caps* caps, stream_pack* out) {
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  memset(out, 0, sizeof *out);
  out->pack = pack;
  out->assets = info.asset_count;
  out->total = info.asset_count + info.proxy_count;
  out->levels = info.lod_count;
  if (info.lod_count < 1 || info.lod_count > STREAM_LEVELS || out->total < out->assets || out->total > UINT32_MAX / 16)
    return SCREE_ERROR_CORRUPT;
  out->lattice[0] = info.lattice_per_cell > 0 ? 1.0f / (float)info.lattice_per_cell : 0;
  out->lattice[1] = info.proxy_per_cell > 0 ? 1.0f / (float)info.proxy_per_cell : 0;
  for (uint32_t asset = 0; asset < out->total; ++asset)
    for (uint32_t level = 0; level < out->levels; ++level) {
      scree_lod lod;
      scree_result result = scree_pack_get_lod(pack, asset, level, &lod);
      if (result != SCREE_OK) return result;
      if (!(lod.error >= 0 && isfinite(lod.error))) return SCREE_ERROR_CORRUPT;
      uint64_t bytes = (uint64_t)lod.vertices * sizeof(scree_vertex) + (uint64_t)lod.triangles * 6;
      if (level == out->levels - 1) {
        if (lod.vertices > 65536 || lod.triangles > UINT32_MAX / 3) return SCREE_ERROR_CORRUPT;
        out->coarse_bytes += bytes;
        if (bytes > out->largest) out->largest = bytes;
        out->bytes += bytes;
      } else if (is_decodable(&lod, caps)) {
        out->bytes += bytes;
        if (lod.vertices > out->largest_vertices) out->largest_vertices = lod.vertices;
        if (lod.triangles * 3 > out->largest_indices) out->largest_indices = lod.triangles * 3;
      }
    }
  return SCREE_OK;
}

/* Levels change at few distances: errors of classes are rounded up to a row of values, each so many times the one below it. */
static const double ERROR_STEP = 1.25;

static float error_of(const scree_pack* pack, uint32_t asset, uint32_t level) {
  scree_lod lod;
  return scree_pack_get_lod(pack, asset, level, &lod) == SCREE_OK ? lod.error : 0;
}

/* How much the errors of an asset's levels are above the mean ones, at worst. */
static double badness(const stream_pack* p, uint32_t asset, const double mean[STREAM_LEVELS]) {
  double worst = 0;
  for (uint32_t level = 0; level < p->levels; ++level)
    if (mean[level] > 0) worst = fmax(worst, (double)error_of(p->pack, asset, level) / mean[level]);
  return worst;
}

/* Sorts the assets from first to end - 1 into classes of about the same errors: class 0 are those that are at most one step better
 * than the worst, and so on; the last are all others. */
static void make_classes(stream_pack* p, uint8_t* classes, uint32_t first, uint32_t end, int kind) {
  double mean[STREAM_LEVELS] = {0}, worst = 0, base = 0;
  for (uint32_t i = first; i < end; ++i)
    for (uint32_t level = 0; level < p->levels; ++level) {
      mean[level] += (double)error_of(p->pack, i, level) / (end - first);
      base = fmax(base, (double)error_of(p->pack, i, level));
    }
  for (uint32_t i = first; i < end; ++i) worst = fmax(worst, badness(p, i, mean));
  for (uint32_t i = first; i < end; ++i) {
    double better = badness(p, i, mean) * ERROR_STEP;
    uint8_t class = 0;
    for (; class < STREAM_CLASSES - 1 && better <= worst; better *= ERROR_STEP) ++class;
    classes[i] = class;
    for (uint32_t level = 0; level < p->levels; ++level) {
      float* error = &p->error[kind][class][level];
      *error = fmaxf(*error, error_of(p->pack, i, level));
      ++p->absent[kind][class][level];
    }
  }
  for (uint32_t class = 0; class < STREAM_CLASSES; ++class)
    for (uint32_t level = 0; level < p->levels; ++level) {
      float* error = &p->error[kind][class][level];
      if (level > 0) *error = fmaxf(*error, error[-1]);
      double value = base;
      while (*error > 0 && value / ERROR_STEP >= (double)*error) value /= ERROR_STEP;
      if (*error > 0) *error = fmaxf(*error, (float)value);
    }
}

enum { HISTOGRAM = 1024 };

static float error_sum(const stream_pack* p, uint32_t asset) {
  float sum = 0;
  for (uint32_t level = 0; level < p->levels; ++level) sum += error_of(p->pack, asset, level);
  return sum;
}

/* The error of seven in eight proxies, cells; the worst, by the sums of their levels, shall not push the whole far field away. */
static float far_error(const stream_pack* p) {
  uint32_t count[HISTOGRAM] = {0}, total = p->total - p->assets;
  float largest = 0, error = 0, any = 0;
  for (uint32_t i = p->assets; i < p->total; ++i) largest = fmaxf(largest, error_sum(p, i));
  float scale = largest > 0 ? (HISTOGRAM - 1) / largest : 0;
  for (uint32_t i = p->assets; i < p->total; ++i) ++count[(uint32_t)(error_sum(p, i) * scale)];
  uint32_t last = 0;
  for (uint64_t before = 0; last < HISTOGRAM && (before + count[last] / 2) * 8 < (uint64_t)total * 7; ++last) before += count[last];
  for (uint32_t i = p->assets; i < p->total; ++i) {
    any = fmaxf(any, error_of(p->pack, i, 0));
    if ((uint32_t)(error_sum(p, i) * scale) < last) error = fmaxf(error, error_of(p->pack, i, 0));
  }
  return error > 0 ? error : fmaxf(any, 0.5f); /* where the pack does not say */
}

static scree_result fill_pack(scree_stream* s, stream_pack* p, stream_mesh* meshes, uint8_t* classes) {
  for (uint32_t asset = 0; asset < p->total; ++asset)
    for (uint32_t level = 0; level < p->levels; ++level) {
      scree_lod lod;
      scree_result result = scree_pack_get_lod(p->pack, asset, level, &lod);
      if (result != SCREE_OK) return result;
      stream_mesh* mesh = &meshes[stream_mesh_slot(p, asset, level)];
      *mesh = (stream_mesh){.before = STREAM_NONE,
                            .after = STREAM_NONE,
                            .vertices = lod.vertices,
                            .triangles = lod.triangles,
                            .coarsest = level == p->levels - 1};
      if (level < p->levels - 1 && !is_decodable(&lod, &s->desc.caps)) mesh->state = MESH_FAILED;
    }
  make_classes(p, classes + p->first_asset, 0, p->assets, 0);
  make_classes(p, classes + p->first_asset, p->assets, p->total, 1);
  p->far_error = far_error(p);
  for (int a = 0; a < 3; ++a) p->low[a] = p->high[a] = 0;
  for (uint32_t asset = 0; asset < p->assets; ++asset) {
    scree_asset record;
    scree_result result = scree_pack_get_asset(p->pack, asset, &record);
    if (result != SCREE_OK) return result;
    for (int a = 0; a < 3; ++a) {
      if (record.bounds_min[a] < p->low[a]) p->low[a] = record.bounds_min[a];
      if (record.bounds_max[a] > p->high[a]) p->high[a] = record.bounds_max[a];
    }
  }
  return SCREE_OK;
}

/* --- tables ----------------------------------------------------------------------------------------------------------------- */

/* Packs and sizes of tables that a scene needs, beside those that are still in use. */
typedef struct setup_plan {
  stream_pack packs[STREAM_PACKS];
  uint32_t mesh_slots, asset_slots;
  uint64_t fresh[STREAM_PACKS / 64]; /* bit: to be filled */
  size_t staging, vertex_room, index_room;
} setup_plan;

static bool is_fresh(const setup_plan* plan, uint32_t i) {
  return plan->fresh[i / 64] >> i % 64 & 1;
}

/* The least place at which `length` elements fit between the regions of the packs. */
static uint64_t find_place(const setup_plan* plan, uint32_t self, bool of_meshes, uint64_t length) {
  uint64_t at = 0;
  for (bool moved = true; moved;) {
    moved = false;
    for (uint32_t i = 0; i < STREAM_PACKS; ++i) {
      const stream_pack* p = &plan->packs[i];
      if (!stream_pack_is_used(p) || i == self) continue;
      uint64_t first = of_meshes ? p->first_mesh : p->first_asset,
               end = first + (of_meshes ? (uint64_t)p->total * p->levels : p->total);
      if (is_fresh(plan, i) && first == UINT32_MAX) continue; /* not placed yet */
      if (at < end && first < at + length) {
        at = end;
        moved = true;
      }
    }
  }
  return at;
}

static uint32_t find_pack(const stream_pack packs[STREAM_PACKS], const stream_pack* wanted) {
  for (uint32_t i = 0; i < STREAM_PACKS; ++i)
    if (packs[i].pack == wanted->pack && packs[i].models == wanted->models && !packs[i].dead) return i;
  return STREAM_NONE;
}

static scree_result add_pack(setup_plan* plan, const stream_pack* wanted, const scree_stream_caps* caps) {
  uint32_t place = 0;
  while (place < STREAM_PACKS && stream_pack_is_used(&plan->packs[place])) ++place;
  if (place == STREAM_PACKS) return SCREE_ERROR_CAPACITY;
  stream_pack measured;
  scree_result result = SCREE_OK;
  if (wanted->pack != NULL)
    result = measure_pack(wanted->pack, caps, &measured);
  else
    measure_models(wanted->models, &measured);
  if (result != SCREE_OK) return result;
  measured.first_mesh = measured.first_asset = UINT32_MAX;
  plan->packs[place] = measured;
  plan->fresh[place / 64] |= UINT64_C(1) << place % 64;
  return SCREE_OK;
}

static scree_result make_plan(setup_plan* plan, const scree_stream* old, const scree_scene* scene, const scree_stream_caps* caps,
                              scree_error* error) {
  memset(plan, 0, sizeof *plan);
  if (old != NULL) memcpy(plan->packs, old->packs, sizeof plan->packs);
  bool used[STREAM_PACKS] = {false};
  for (uint32_t i = 0; i < scree_scene_layer_count(scene); ++i) {
    const stream_pack wanted = drawn_by(scene, i);
    if (find_pack(plan->packs, &wanted) == STREAM_NONE) {
      scree_result result = add_pack(plan, &wanted, caps);
      if (result != SCREE_OK) return fail(error, result, "scene: a pack cannot be used");
    }
    used[find_pack(plan->packs, &wanted)] = true;
  }
  uint64_t coarse = 0, largest = 0, mesh_end = 0, asset_end = 0;
  for (uint32_t i = 0; i < STREAM_PACKS; ++i) {
    stream_pack* p = &plan->packs[i];
    if (!stream_pack_is_used(p)) continue;
    if (!used[i]) p->dead = true;
    if (p->dead && p->meshes_in == 0 && p->blocks == 0) { /* nothing is left of it */
      p->pack = NULL;
      p->models = NULL;
      continue;
    }
    if (!p->dead) {
      coarse += p->coarse_bytes;
      if (p->largest > largest) largest = p->largest;
      if (p->largest_vertices > plan->vertex_room) plan->vertex_room = p->largest_vertices;
      if (p->largest_indices > plan->index_room) plan->index_room = p->largest_indices;
    }
  }
  for (uint32_t i = 0; i < STREAM_PACKS; ++i) {
    stream_pack* p = &plan->packs[i];
    if (!stream_pack_is_used(p)) continue;
    if (is_fresh(plan, i)) {
      uint64_t mesh = find_place(plan, i, true, (uint64_t)p->total * p->levels), asset = find_place(plan, i, false, p->total);
      if (mesh + (uint64_t)p->total * p->levels >= UINT32_MAX) return fail(error, SCREE_ERROR_RANGE, "scene: too many meshes");
      p->first_mesh = (uint32_t)mesh;
      p->first_asset = (uint32_t)asset;
    }
    if (p->first_mesh + (uint64_t)p->total * p->levels > mesh_end) mesh_end = p->first_mesh + (uint64_t)p->total * p->levels;
    if (p->first_asset + (uint64_t)p->total > asset_end) asset_end = p->first_asset + (uint64_t)p->total;
  }
  if (coarse > caps->mesh_bytes || largest > caps->upload_bytes) {
    fail(error, SCREE_ERROR_CAPACITY, "caps: the coarsest levels of all assets take ");
    scree_rt_text_add_count(error, coarse);
    scree_rt_text_add(error, " mesh_bytes, and the largest of them ");
    scree_rt_text_add_count(error, largest);
    scree_rt_text_add(error, " upload_bytes");
    return SCREE_ERROR_CAPACITY;
  }
  plan->mesh_slots = (uint32_t)mesh_end;
  plan->asset_slots = (uint32_t)asset_end;
  plan->staging = (size_t)(coarse < caps->upload_bytes ? coarse : caps->upload_bytes);
  plan->vertex_room = (plan->vertex_room + 3) / 4 * 4;
  plan->index_room = (plan->index_room + 31) / 32 * 32;
  return SCREE_OK;
}

static size_t table_bytes(const setup_plan* plan, const scree_stream_caps* caps) {
  size_t decodes = 2 * (size_t)caps->decodes;
  return plan->mesh_slots * sizeof(stream_mesh) + plan->asset_slots + plan->staging +
         decodes * (plan->vertex_room * sizeof(scree_vertex) + plan->index_room * sizeof(uint16_t));
}

size_t scree_rt_stream_tables_size(const scree_stream_desc* desc) {
  const scree_allocator allocator = scree_rt_allocator_or_default(NULL);
  setup_plan* plan = scree_rt_allocate(&allocator, 1, sizeof *plan);
  size_t size = 0;
  if (plan != NULL && make_plan(plan, NULL, desc->scene, &desc->caps, NULL) == SCREE_OK) size = table_bytes(plan, &desc->caps);
  scree_rt_release(&allocator, plan, 1, sizeof *plan);
  return size;
}

/* --- layers ----------------------------------------------------------------------------------------------------------------- */

static void set_up_layer(scree_stream* s, uint32_t index) {
  stream_layer* layer = &s->layers[index];
  const scree_scatter* scatter = scree_rt_scene_layer(s->scene, index)->scatter;
  const scree_field* field = scree_rt_scene_layer(s->scene, index)->field;
  const stream_pack drawn = drawn_by(s->scene, index);
  memset(layer, 0, sizeof *layer);
  layer->field = field;
  layer->pack = find_pack(s->packs, &drawn);
  layer->cell = scatter != NULL ? 1 : (float)field->cell_size;
  layer->largest = scatter != NULL ? scatter->scale_max : 1;
  layer->radius = scatter != NULL ? (float)scatter->outer_radius * 1.000001f : 0;
  layer->cube = field->cell_size * (double)field->cells_per_cube;
  for (int a = 0; a < 3; ++a) layer->low[a] = field->origin[a] - 0.5 * field->cell_size;
  layer->far_field = !s->desc.no_far_field && s->packs[layer->pack].total > s->packs[layer->pack].assets;
  layer->root = STREAM_NONE;
  layer->root_due = -INFINITY;
  layer->top = 1;
  while (layer->top < STREAM_TOP && stream_node_width(layer, layer->top) < s->desc.view_distance) ++layer->top;
}

/* --- all of it -------------------------------------------------------------------------------------------------------------- */

/* New tables where the old ones are too small. */
typedef struct setup_tables {
  stream_mesh* meshes;
  uint8_t *classes, *staging;
  scree_vertex* vertices;
  uint16_t* indices;
} setup_tables;

static bool allocate_tables(const scree_stream* s, const setup_plan* plan, setup_tables* t) {
  size_t decodes = 2 * (size_t)s->desc.caps.decodes;
  memset(t, 0, sizeof *t);
  bool ok = true;
  if (plan->mesh_slots > s->mesh_capacity)
    ok &= (t->meshes = scree_rt_allocate(&s->allocator, plan->mesh_slots, sizeof *t->meshes)) != NULL;
  if (plan->asset_slots > s->asset_capacity) ok &= (t->classes = scree_rt_allocate(&s->allocator, plan->asset_slots, 1)) != NULL;
  if (plan->staging > s->staging_size) ok &= (t->staging = scree_rt_allocate(&s->allocator, plan->staging, 1)) != NULL;
  if (plan->vertex_room > s->decode_vertex_room)
    ok &= (t->vertices = scree_rt_allocate(&s->allocator, decodes * plan->vertex_room, sizeof *t->vertices)) != NULL;
  if (plan->index_room > s->decode_index_room)
    ok &= (t->indices = scree_rt_allocate(&s->allocator, decodes * plan->index_room, sizeof *t->indices)) != NULL;
  return ok;
}

static void release_tables(const scree_stream* s, const setup_plan* plan, setup_tables* t) {
  size_t decodes = 2 * (size_t)s->desc.caps.decodes;
  scree_rt_release(&s->allocator, t->meshes, plan->mesh_slots, sizeof *t->meshes);
  scree_rt_release(&s->allocator, t->classes, plan->asset_slots, 1);
  scree_rt_release(&s->allocator, t->staging, plan->staging, 1);
  scree_rt_release(&s->allocator, t->vertices, decodes * plan->vertex_room, sizeof *t->vertices);
  scree_rt_release(&s->allocator, t->indices, decodes * plan->index_room, sizeof *t->indices);
}

void scree_rt_stream_drop_tables(scree_stream* s) {
  size_t decodes = 2 * (size_t)s->desc.caps.decodes;
  scree_rt_release(&s->allocator, s->meshes, s->mesh_capacity, sizeof *s->meshes);
  scree_rt_release(&s->allocator, s->classes, s->asset_capacity, 1);
  scree_rt_release(&s->allocator, s->staging, s->staging_size, 1);
  scree_rt_release(&s->allocator, s->decode_vertices, decodes * s->decode_vertex_room, sizeof *s->decode_vertices);
  scree_rt_release(&s->allocator, s->decode_indices, decodes * s->decode_index_room, sizeof *s->decode_indices);
}

/* Puts new tables in the place of the old ones. Nothing is being decoded. */
static void adopt_tables(scree_stream* s, const setup_plan* plan, const setup_tables* t) {
  size_t decodes = 2 * (size_t)s->desc.caps.decodes;
  if (t->meshes != NULL) {
    scree_rt_release(&s->allocator, s->meshes, s->mesh_capacity, sizeof *s->meshes);
    s->meshes = t->meshes;
    s->mesh_capacity = plan->mesh_slots;
  }
  if (t->classes != NULL) {
    scree_rt_release(&s->allocator, s->classes, s->asset_capacity, 1);
    s->classes = t->classes;
    s->asset_capacity = plan->asset_slots;
  }
  if (t->staging != NULL) {
    scree_rt_release(&s->allocator, s->staging, s->staging_size, 1);
    s->staging = t->staging;
    s->staging_size = plan->staging;
  }
  if (t->vertices != NULL) {
    scree_rt_release(&s->allocator, s->decode_vertices, decodes * s->decode_vertex_room, sizeof *s->decode_vertices);
    s->decode_vertices = t->vertices;
    s->decode_vertex_room = plan->vertex_room;
  }
  if (t->indices != NULL) {
    scree_rt_release(&s->allocator, s->decode_indices, decodes * s->decode_index_room, sizeof *s->decode_indices);
    s->decode_indices = t->indices;
    s->decode_index_room = plan->index_room;
  }
  s->mesh_slots = plan->mesh_slots;
  s->asset_slots = plan->asset_slots;
}

static scree_result fill_tables(scree_stream* s, setup_plan* plan, setup_tables* t) {
  if (t->meshes != NULL && s->mesh_slots > 0) memcpy(t->meshes, s->meshes, s->mesh_slots * sizeof *t->meshes);
  if (t->classes != NULL && s->asset_slots > 0) memcpy(t->classes, s->classes, s->asset_slots);
  for (uint32_t i = 0; i < STREAM_PACKS; ++i) {
    stream_mesh* meshes = t->meshes != NULL ? t->meshes : s->meshes;
    uint8_t* classes = t->classes != NULL ? t->classes : s->classes;
    if (!stream_pack_is_used(&plan->packs[i]) || !is_fresh(plan, i)) continue;
    if (plan->packs[i].models != NULL) {
      fill_models(&plan->packs[i], meshes, classes);
      continue;
    }
    scree_result result = fill_pack(s, &plan->packs[i], meshes, classes);
    if (result != SCREE_OK) return result;
  }
  return SCREE_OK;
}

scree_result scree_rt_stream_set_up(scree_stream* s, const scree_scene* scene, uint64_t kept, scree_error* error) {
  setup_plan* plan = scree_rt_allocate(&s->allocator, 1, sizeof *plan);
  if (plan == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  setup_tables tables = {0};
  scree_result result = make_plan(plan, s, scene, &s->desc.caps, error);
  if (result == SCREE_OK && !allocate_tables(s, plan, &tables)) result = SCREE_ERROR_OUT_OF_MEMORY;
  if (result == SCREE_OK) result = fill_tables(s, plan, &tables);
  if (result == SCREE_OK) {
    adopt_tables(s, plan, &tables);
    memcpy(s->packs, plan->packs, sizeof s->packs);
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < STREAM_PACKS; ++i)
      if (s->packs[i].pack != NULL && !s->packs[i].dead) bytes += s->packs[i].bytes;
    if (s->roomy != (bytes <= s->desc.caps.mesh_bytes)) {
      s->roomy = !s->roomy;
      scree_rt_stream_meshes_recount(s);
    }
    s->scene = scene;
    uint32_t before = s->layer_count;
    s->layer_count = scree_scene_layer_count(scene);
    for (uint32_t i = 0; i < before; ++i)
      if (i >= s->layer_count || !(kept >> i & 1)) scree_rt_stream_bury(s, i);
    for (uint32_t i = 0; i < s->layer_count; ++i) {
      if (i >= before || !(kept >> i & 1)) set_up_layer(s, i);
      s->layers[i].reach = scree_rt_scene_reach(scene, i);
    }
  } else {
    release_tables(s, plan, &tables);
  }
  scree_rt_release(&s->allocator, plan, 1, sizeof *plan);
  return result;
}
