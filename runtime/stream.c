/* Streams: create, destroy, changes of scene and edits, and the order in which an update does its work. See stream_internal.h. */
#include <math.h>
#include <string.h>

#include "stream_internal.h"

/* --- memory ----------------------------------------------------------------------------------------------------------------- */

/* Hands out parts of one allocation, or only adds up their sizes. */
typedef struct arena {
  uint8_t* memory; /* NULL: adding up */
  size_t used;
} arena;

static void* take(arena* a, size_t count, size_t size) {
  void* part = a->memory != NULL ? a->memory + a->used : NULL;
  a->used += (count * size + SCREE_ALIGNMENT - 1) / SCREE_ALIGNMENT * SCREE_ALIGNMENT;
  return part;
}

/* Nodes of the trees: those that are shown, twice as many that are on their way in or out, and what lies above them. */
static uint32_t node_count(const scree_stream_caps* caps) {
  return 2 * caps->blocks + 4096;
}

/* Everything whose size only the caps decide. */
static void lay_out(scree_stream* s, const scree_stream_caps* caps, arena* a) {
  size_t builds = caps->builds, decodes = 2 * (size_t)caps->decodes;
  s->node_count = node_count(caps);
  s->nodes = take(a, s->node_count, sizeof *s->nodes);
  s->holes = take(a, s->node_count, sizeof *s->holes);
  s->wants = take(a, builds, sizeof *s->wants);
  s->blocks = take(a, caps->blocks, sizeof *s->blocks);
  s->watches = take(a, (size_t)12 * scree_rt_stream_watch_rows(caps), sizeof *s->watches);
  s->waiting = take(a, caps->blocks, sizeof *s->waiting);
  s->fading = take(a, caps->blocks, sizeof *s->fading);
  s->moved = take(a, caps->blocks, sizeof *s->moved);
  s->builds = take(a, builds, sizeof *s->builds);
  s->decodes = take(a, decodes, sizeof *s->decodes);
  s->queue_words = take(a, 2 * (builds + decodes), sizeof *s->queue_words);
  s->events = take(a, caps->events, sizeof *s->events);
  s->range_words = take(a, scree_rt_ranges_words(caps->instances), sizeof *s->range_words);
  s->instances = take(a, caps->instances, sizeof *s->instances);
  s->ids = take(a, caps->instances, sizeof *s->ids);
  s->owners = take(a, scree_rt_ranges_words(caps->instances) / 3, sizeof *s->owners);
}

size_t scree_stream_memory(const scree_stream_desc* given) {
  if (given == NULL) return 0;
  scree_stream_desc desc = *given;
  if (scree_rt_stream_check(&desc, NULL) != SCREE_OK) return 0;
  size_t tables = scree_rt_stream_tables_size(&desc);
  if (tables == 0) return 0;
  scree_stream sizes;
  arena a = {NULL, 0};
  lay_out(&sizes, &desc.caps, &a);
  return sizeof(scree_stream) + a.used + tables + desc.caps.builds * scree_rt_stream_scratch_size();
}

/* --- create, destroy -------------------------------------------------------------------------------------------------------- */

static void init_lists(scree_stream* s) {
  s->grave = s->free_node = s->free_block = STREAM_NONE;
  s->idle_first = s->idle_last = STREAM_NONE;
  scree_rt_stream_watch_init(s);
  s->view_limit = s->desc.view_distance;
  s->split_scale = s->mesh_scale = 1;
  s->room_bound = s->mesh_bound = (stream_bound){-INFINITY, -INFINITY, -INFINITY};
  scree_rt_ranges_init(&s->ranges, s->desc.caps.instances, s->range_words);
  for (uint32_t i = 0; i < s->ranges.units; ++i) s->owners[i] = STREAM_NONE;
}

scree_result scree_stream_create(const scree_stream_desc* given, const scree_allocator* given_allocator, scree_stream** out,
                                 scree_error* error) {
  if (out != NULL) *out = NULL;
  if (given == NULL || out == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  scree_stream_desc desc = *given;
  scree_result result = scree_rt_stream_check(&desc, error);
  if (result != SCREE_OK) return result;
  const scree_allocator allocator = scree_rt_allocator_or_default(given_allocator);
  scree_stream* s = scree_rt_allocate_zeroed(&allocator, 1, sizeof *s);
  if (s == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  s->allocator = allocator;
  s->desc = desc;
  arena a = {NULL, 0};
  lay_out(s, &desc.caps, &a);
  s->memory_size = a.used;
  s->memory = scree_rt_allocate(&allocator, s->memory_size, 1);
  if (s->memory == NULL) {
    scree_rt_release(&allocator, s, 1, sizeof *s);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  a = (arena){s->memory, 0};
  lay_out(s, &desc.caps, &a);
  init_lists(s);
  result = scree_rt_stream_tasks_init(s);
  if (result == SCREE_OK) result = scree_rt_stream_set_up(s, desc.scene, 0, error);
  if (result != SCREE_OK) {
    scree_stream_destroy(s);
    return result;
  }
  *out = s;
  return SCREE_OK;
}

void scree_stream_destroy(scree_stream* s) {
  if (s == NULL) return;
  const scree_allocator allocator = s->allocator;
  scree_rt_stream_tasks_destroy(s);
  scree_rt_stream_drop_tables(s);
  scree_rt_release(&allocator, s->memory, s->memory_size, 1);
  scree_rt_release(&allocator, s, 1, sizeof *s);
}

/* --- views ------------------------------------------------------------------------------------------------------------------ */

static bool is_sound(const scree_view* view) {
  for (int a = 0; a < 3; ++a)
    if (!isfinite(view->position[a])) return false;
  if (!(view->field_of_view > 0 && view->field_of_view < 3.14159274f)) return false;
  if (!(view->viewport_height > 0 && isfinite(view->viewport_height))) return false;
  if (view->frustum == NULL) return view->plane_count == 0;
  if (view->plane_count > STREAM_PLANES) return false;
  for (uint32_t i = 0; i < 4 * view->plane_count; ++i)
    if (!isfinite(view->frustum[i])) return false;
  return true;
}

static void set_views(scree_stream* s, const scree_view* views, uint32_t count) {
  double travelled = 0, pixels = 0, sharpness[STREAM_VIEWS];
  for (uint32_t v = 0; v < count; ++v) {
    sharpness[v] = (double)views[v].viewport_height / (2 * tan((double)views[v].field_of_view / 2));
    pixels = fmax(pixels, sharpness[v]);
  }
  if (count != s->view_count) s->revisit = true;
  for (uint32_t v = 0; v < count; ++v) {
    stream_view* view = &s->views[v];
    double ratio = pixels / sharpness[v], moved2 = 0;
    if (view->pixels != sharpness[v] || view->ratio != ratio) s->revisit = true;
    for (int a = 0; a < 3; ++a) {
      double moved = views[v].position[a] - view->position[a];
      moved2 += moved * moved;
      view->position[a] = views[v].position[a];
    }
    travelled = fmax(travelled, sqrt(moved2) * ratio);
    view->pixels = sharpness[v];
    view->ratio = ratio;
    view->plane_count = views[v].plane_count;
    if (view->plane_count > 0) memcpy(view->planes, views[v].frustum, sizeof(float) * 4 * view->plane_count);
  }
  s->view_count = count;
  s->pixels = pixels;
  if (travelled < 1e12)
    s->travel += travelled * (1 + 1e-12);
  else
    s->revisit = true;
}

/* --- update ----------------------------------------------------------------------------------------------------------------- */

scree_result scree_stream_update(scree_stream* s, const scree_view* views, uint32_t view_count, double time,
                                 const scree_event** events, uint32_t* event_count) {
  if (s == NULL || events == NULL || event_count == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  *events = NULL;
  *event_count = 0;
  if (view_count > STREAM_VIEWS || (views == NULL && view_count > 0)) return SCREE_ERROR_INVALID_ARGUMENT;
  if (!isfinite(time) || time < s->time) return SCREE_ERROR_INVALID_ARGUMENT;
  for (uint32_t v = 0; v < view_count; ++v)
    if (!is_sound(&views[v])) return SCREE_ERROR_INVALID_ARGUMENT;

  ++s->update;
  s->time = time;
  s->event_count = 0;
  s->upload_bytes = 0;
  set_views(s, views, view_count);
  scree_rt_stream_tasks_collect(s);
  scree_rt_stream_meshes_send(s);
  scree_rt_stream_tree_update(s);
  scree_rt_stream_levels_update(s);
  scree_rt_stream_bound(s);
  *events = s->events;
  *event_count = s->event_count;
  return SCREE_OK;
}

float scree_stream_fade(const scree_stream* s, float fade_start, double time) {
  if (s == NULL || !(s->desc.fade_seconds > 0)) return 1;
  double share = (time - (double)fade_start) / (double)s->desc.fade_seconds;
  return share >= 1 ? 1 : share > 0 ? (float)share : 0;
}

void scree_stream_wait(scree_stream* s) {
  if (s != NULL) scree_rt_stream_tasks_wait(s);
}

/* --- changes ---------------------------------------------------------------------------------------------------------------- */

static bool same_filter(const scree_filter* a, const scree_filter* b) {
  if (a->kind != b->kind || a->inverted != b->inverted || a->from != b->from || a->to != b->to || a->fade != b->fade) return false;
  if (a->kind == SCREE_FILTER_ALTITUDE) return true;
  if (a->width != b->width || a->depth != b->depth || a->spacing != b->spacing) return false;
  if (memcmp(a->centre, b->centre, sizeof a->centre) != 0) return false;
  return memcmp(a->values, b->values, sizeof *a->values * a->width * a->depth) == 0;
}

/* Whether two layers differ in nothing but their supports. */
static bool same_rules(const scree_layer* a, const scree_layer* b) {
  if (a->threshold != b->threshold || a->shell_depth != b->shell_depth || a->density != b->density) return false;
  if (a->filter_count != b->filter_count) return false;
  for (uint32_t i = 0; i < a->filter_count; ++i)
    if (!same_filter(&a->filters[i], &b->filters[i])) return false;
  return true;
}

typedef struct touched_box {
  double min[3], max[3];
} touched_box;

static void add_box(touched_box* box, const double min[3], const double max[3]) {
  for (int a = 0; a < 3; ++a) {
    box->min[a] = fmin(box->min[a], min[a]);
    box->max[a] = fmax(box->max[a], max[a]);
  }
}

static void add_support(touched_box* box, const scree_support* support) {
  double min[3], max[3];
  scree_support_bounds(support, min, max);
  for (int a = 0; a < 3; ++a)
    if (!(min[a] < max[a])) return;
  add_box(box, min, max);
}

/* What differs between two layers of the same field. */
static void add_difference(touched_box* box, const scree_layer* before, const scree_layer* after) {
  if (!same_rules(before, after)) {
    add_support(box, before->support);
    add_support(box, after->support);
    return;
  }
  if (before->support == after->support) return;
  /* Thresholds below one half let rocks exist whose centroids are this far outside. */
  double threshold = after->threshold == 0 ? 0.5 : (double)after->threshold;
  double level = fmax(0, (1 - 2 * threshold) * (double)after->field->mean_radius_max);
  level = fmax(level, (double)after->shell_depth); /* and what lies deeper than the shell does not, whatever its depth */
  double min[3], max[3];
  if (scree_support_changed_bounds(before->support, after->support, level, min, max)) add_box(box, min, max);
}

static void touch_box(scree_stream* s, uint32_t layer, const touched_box* box, double reach) {
  /* cppcheck-suppress uninitvar ; boxes are filled for every layer that either scene has */
  if (!(box->min[0] <= box->max[0])) return;
  double min[3], max[3];
  for (int a = 0; a < 3; ++a) {
    min[a] = box->min[a] - reach;
    max[a] = box->max[a] + reach;
  }
  scree_rt_stream_touch(s, layer, min, max);
}

scree_result scree_stream_set_scene(scree_stream* s, const scree_scene* scene) {
  if (s == NULL || scene == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  scree_stream_desc desc = s->desc;
  desc.scene = scene;
  scree_result result = scree_rt_stream_check(&desc, NULL);
  if (result != SCREE_OK) return result;
  scree_rt_stream_tasks_wait(s);
  const scree_scene* old = s->scene;
  uint32_t before = s->layer_count, after = scree_scene_layer_count(scene);
  uint64_t kept = 0;
  double reach[STREAM_LAYERS];      /* in the scene before */
  touched_box boxes[STREAM_LAYERS]; /* of what changes up to each layer: later ones give way to earlier ones */
  const touched_box nothing = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  touched_box box = nothing;
  for (uint32_t i = 0; i < before || i < after; ++i) {
    const scree_layer* a = i < before ? scree_rt_scene_layer(old, i) : NULL;
    const scree_layer* b = i < after ? scree_rt_scene_layer(scene, i) : NULL;
    if (a != NULL && b != NULL && a->key == b->key && a->field == b->field) {
      kept |= UINT64_C(1) << i;
      reach[i] = s->layers[i].reach;
      touched_box own = nothing;
      add_difference(&own, a, b);
      if (a->scatter != NULL && own.min[0] <= own.max[0]) own.min[1] = -INFINITY; /* what is above decides about the ground below */
      add_box(&box, own.min, own.max);
    } else {
      if (a != NULL) add_support(&box, a->support);
      if (b != NULL) add_support(&box, b->support);
    }
    boxes[i] = box;
  }
  result = scree_rt_stream_set_up(s, scene, kept, NULL);
  if (result != SCREE_OK) return result;
  s->desc.scene = scene;
  ++s->touch;
  for (uint32_t i = 0; i < after; ++i)
    if (kept >> i & 1) touch_box(s, i, &boxes[i], fmax(reach[i], s->layers[i].reach));
  return SCREE_OK;
}

scree_result scree_stream_edited(scree_stream* s, const scree_id* ids, uint32_t count) {
  if (s == NULL || (ids == NULL && count > 0)) return SCREE_ERROR_INVALID_ARGUMENT;
  ++s->touch;
  if (count == 0)
    for (uint32_t i = 0; i < s->layer_count; ++i) scree_rt_stream_touch(s, i, NULL, NULL);
  for (uint32_t k = 0; k < count; ++k) {
    uint32_t layer = scree_scene_layer_of(s->scene, ids[k].layer);
    if (layer == UINT32_MAX) continue;
    touched_box box;
    int32_t low[3], high[3];
    memcpy(low, ids[k].cube, sizeof low);
    for (int a = 0; a < 3; ++a) high[a] = low[a] < INT32_MAX ? low[a] + 1 : low[a];
    scree_rt_scene_cubes_box(s->scene, layer, 0, low, high, box.min, box.max);
    /* Edits of a rock are seen by the burial of its neighbours, and by nothing else. */
    const scree_field* field = s->layers[layer].field;
    touch_box(s, layer, &box, ((double)field->deepest_burial + 1) * field->cell_size);
  }
  return SCREE_OK;
}

/* --- what a stream tells ---------------------------------------------------------------------------------------------------- */

uint32_t scree_stream_mesh_slots(const scree_stream* s) {
  return s != NULL ? s->mesh_slots : 0;
}

uint32_t scree_stream_mesh(const scree_stream* s, uint32_t layer, uint32_t asset, uint32_t level) {
  if (s == NULL || layer >= s->layer_count) return UINT32_MAX;
  const stream_pack* pack = &s->packs[s->layers[layer].pack];
  if (pack->pack == NULL || asset >= pack->total || level >= pack->levels) return UINT32_MAX;
  return stream_mesh_slot(pack, asset, level);
}

void scree_stream_get_stats(const scree_stream* s, scree_stream_stats* out) {
  memset(out, 0, sizeof *out);
  if (s == NULL) return;
  out->instances = s->shown_instances + s->shown_proxies;
  out->blocks = s->blocks_shown;
  out->meshes = s->meshes_in;
  for (uint32_t i = 0; i < STREAM_LEVELS; ++i) out->instances_by_level[i] = s->shown_by_level[i];
  out->proxies = s->shown_proxies;
  out->mesh_bytes = s->mesh_bytes;
  out->upload_bytes = s->upload_bytes;
  out->triangles = s->triangles;
  out->decodes = s->decodes_under_way;
  out->builds = s->build_queue.count;
  out->coarser = s->coarser;
  out->covered = scree_rt_stream_covered(s);
  out->degraded = s->refused + (s->view_limit < s->desc.view_distance || s->split_scale > 1);
  out->complete = s->pending == 0 && s->build_queue.count == 0 && s->decodes_under_way == 0 && s->waiting_count == 0 &&
                  s->coarser == 0 && out->degraded == 0;
}

bool scree_stream_id(const scree_stream* s, uint32_t instance, scree_id* id) {
  if (s == NULL || id == NULL || instance / s->ranges.unit >= s->ranges.units) return false;
  uint32_t slot = s->owners[instance / s->ranges.unit];
  if (slot == STREAM_NONE) return false;
  const stream_block* b = &s->blocks[slot];
  if (!b->shown || b->level > 0 || instance < b->first || instance - b->first >= b->count) return false;
  *id = s->ids[instance];
  return true;
}
