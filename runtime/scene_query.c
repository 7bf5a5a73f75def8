/* The rocks of a scene: which layers a question needs and where, what their supports, shells and filters leave, and what is
 * delivered.
 *
 *   asked for: layer 2 in a box            needed of layer 1: where its rocks could meet candidates of layer 2
 *                                          needed of layer 0: the same for layers 1 and 2
 *   from the last layer to the first:      find the candidates; the box that holds them, grown by how far rocks reach, is where
 *                                          earlier layers are needed
 *   from the first layer to the last:      drop what meets a kept rock of an earlier layer (scene_keep.c)
 *
 * Whether a rock is kept depends on its neighbours of earlier layers alone, all of which lie in those boxes; so the answer about
 * a rock is the same in every question. */
#include <math.h>
#include <string.h>

#include "query_kernel.h"
#include "scene_layers.h"
#include "scene_scatter.h"

/* Cuts a range of cells to those whose cubes an int32 can name. */
static void clamp_cells(const scree_field* field, int64_t low[3], int64_t high[3]) {
  int64_t n = field->cells_per_cube, first = INT32_MIN * n, end = INT32_MAX * n;
  for (int a = 0; a < 3; ++a) {
    if (low[a] < first) low[a] = first;
    if (high[a] > end) high[a] = end;
    if (high[a] < low[a]) high[a] = low[a];
  }
}

static int64_t floor_divide(int64_t a, int64_t b) {
  int64_t q = a / b;
  return q - (a % b < 0);
}

static void unite(bool* some, int64_t low[3], int64_t high[3], const int64_t add_low[3], const int64_t add_high[3]) {
  for (int a = 0; a < 3; ++a) {
    if (!*some || add_low[a] < low[a]) low[a] = add_low[a];
    if (!*some || add_high[a] > high[a]) high[a] = add_high[a];
  }
  *some = true;
}

bool scree_rt_scene_cells_may_hold(const scene_layer* layer, const int64_t low[3], const int64_t high[3]) {
  const scree_field* field = layer->given.field;
  const scree_support* support = layer->given.support;
  double h = field->cell_size, bound_low[3], bound_high[3], half2 = 0, largest = support->magnitude;
  float middle[3], distance;
  if (!scree_rt_support_level_bounds(support, layer->level_high > 0 ? layer->level_high : 0, bound_low, bound_high)) return false;
  for (int a = 0; a < 3; ++a) {
    if (low[a] >= high[a]) return false;
    /* The box of the centroids, support's space, and what of it lies where the support can be. */
    double base = field->origin[a] - support->origin[a];
    double from = base + h * (double)low[a] + (double)field->centroid_min[a];
    double to = base + h * (double)(high[a] - 1) + (double)field->centroid_max[a];
    double slack = (fabs(from) + fabs(to) + largest) * 1e-6;
    if (bound_low[a] > to + slack || bound_high[a] < from - slack) return false;
    if (bound_low[a] > from) from = bound_low[a];
    if (bound_high[a] < to) to = bound_high[a];
    middle[a] = (float)((from + to) * 0.5);
    half2 += (to - from) * (to - from) * 0.25;
    if (fabs(from) > largest) largest = fabs(from);
    if (fabs(to) > largest) largest = fabs(to);
  }
  scree_support_distance(support, &middle[0], &middle[1], &middle[2], &distance, 1);
  return !((double)distance > layer->level_high + layer->lipschitz * (sqrt(half2) * 1.00001 + largest * 8e-6) + 2 * layer->doubt);
}

bool scree_rt_scene_may_hold(const scree_scene* scene, uint32_t layer, const double min[3], const double max[3]) {
  const scree_field* field = scene->layers[layer].given.field;
  int64_t low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    low[a] = scree_rt_query_first_cell(min[a] - field->origin[a], field->cell_size);
    high[a] = scree_rt_query_first_cell(max[a] - field->origin[a], field->cell_size);
  }
  clamp_cells(field, low, high);
  return scree_rt_scene_cells_may_hold(&scene->layers[layer], low, high);
}

/* The cells of a layer where a rock could stand that reaches into a box relative to the scene's base. */
static void cells_round(const scene_layer* layer, const double low[3], const double high[3], int64_t cell_low[3],
                        int64_t cell_high[3]) {
  double h = layer->given.field->cell_size;
  for (int a = 0; a < 3; ++a) { /* one cell more on either side, for rounding */
    cell_low[a] = scree_rt_query_first_cell(low[a] - layer->reach - layer->offset[a], h) - 1;
    cell_high[a] = scree_rt_query_first_cell(high[a] + layer->reach - layer->offset[a], h) + 1;
  }
  clamp_cells(layer->given.field, cell_low, cell_high);
}

void scree_rt_scene_ask(scene_question* q, uint32_t layer, const int64_t low[3], const int64_t high[3]) {
  layer_rocks* rocks = &q->layers[layer];
  rocks->asked = true;
  memcpy(rocks->asked_low, low, sizeof rocks->asked_low);
  memcpy(rocks->asked_high, high, sizeof rocks->asked_high);
  memcpy(rocks->low, low, sizeof rocks->low);
  memcpy(rocks->high, high, sizeof rocks->high);
  rocks->needed = true;
  if (!looks_at_burial(q, layer)) return;
  const scree_field* field = q->scene->layers[layer].given.field;
  for (int a = 0; a < 3; ++a) {
    rocks->low[a] -= field->deepest_burial;
    rocks->high[a] += field->deepest_burial;
  }
  clamp_cells(field, rocks->low, rocks->high);
}

bool scree_rt_scene_edited(const scene_question* q, uint32_t index, const int64_t low[3], const int64_t high[3]) {
  if (scree_edits_count(q->edits) == 0) return false;
  const scree_layer* layer = &q->scene->layers[index].given;
  int64_t n = layer->field->cells_per_cube;
  int32_t cube_low[3], cube_high[3];
  for (int a = 0; a < 3; ++a) {
    cube_low[a] = (int32_t)floor_divide(low[a], n);
    cube_high[a] = (int32_t)(floor_divide(high[a] - 1, n) + 1);
  }
  return scree_rt_edits_any(q->edits, layer->key, cube_low, cube_high);
}

/* Whether rocks that lie deep need not be looked for, because nothing but the support decides what exists here. */
static bool may_skip_the_deep(const scene_question* q, uint32_t index) {
  const scene_layer* layer = &q->scene->layers[index];
  const layer_rocks* rocks = &q->layers[index];
  if (layer->filtered || layer->given.shell_depth > 0 || scree_rt_scene_edited(q, index, rocks->low, rocks->high)) return false;
  double low[3], high[3];
  cell_centre(layer, rocks->low, low);
  cell_centre(layer, rocks->high, high);
  for (int a = 0; a < 3; ++a) {
    low[a] -= layer->reach;
    high[a] += layer->reach;
  }
  for (uint32_t j = 0; j < index; ++j) {
    int64_t cell_low[3], cell_high[3];
    cells_round(&q->scene->layers[j], low, high, cell_low, cell_high);
    if (scree_rt_scene_cells_may_hold(&q->scene->layers[j], cell_low, cell_high)) return false;
  }
  return true;
}

/* Finds the rocks of one layer in the cells where it is needed, behind those that are there already. */
static scree_result find_rocks(scene_question* q, uint32_t index) {
  const scene_layer* layer = &q->scene->layers[index];
  layer_rocks* rocks = &q->layers[index];
  if (layer->given.scatter != NULL) return scree_rt_scene_find_scatter(q, index);
  cell_query query = {.field = layer->given.field,
                      .support = layer->given.support,
                      .threshold = layer->given.threshold,
                      .depth = layer->given.shell_depth};
  memcpy(query.origin, q->origin, sizeof query.origin);
  memcpy(query.low, rocks->low, sizeof query.low);
  memcpy(query.high, rocks->high, sizeof query.high);
  rocks->first = q->count;
  bool buried = looks_at_burial(q, index);
  if (buried && may_skip_the_deep(q, index)) {
    double depth = scree_rt_scene_floor(layer, rocks->low, rocks->high);
    if (depth < 1e30) {
      query.depth = (float)depth;
      query.deep = &q->grid;
    }
  }
  for (;;) {
    if (buried) { /* anew each time, because queries write to it */
      scree_result result = scree_rt_scene_make_grid(q->scratch, rocks->low, rocks->high, &q->grid);
      if (result != SCREE_OK) return result;
    }
    size_t room = scratch_room(q->scratch, SCRATCH_INSTANCES, sizeof *q->instances);
    size_t id_room = scratch_room(q->scratch, SCRATCH_IDS, sizeof *q->ids);
    if (id_room < room) room = id_room;
    bool some = room > q->count; /* else only count */
    q->instances = q->scratch->buffers[SCRATCH_INSTANCES].memory;
    q->ids = q->scratch->buffers[SCRATCH_IDS].memory;
    scree_result result = scree_rt_query_cells(&query, some ? q->instances + q->count : NULL, some ? q->ids + q->count : NULL,
                                               some ? room - q->count : 0, &rocks->count);
    if (result != SCREE_OK && result != SCREE_ERROR_CAPACITY) return result;
    if (rocks->count > q->most || q->count + rocks->count > q->most) return SCREE_ERROR_CAPACITY;
    if (result == SCREE_OK) break;
    size_t wanted = (size_t)(q->count + rocks->count) + FIELD_OCTET;
    if (scree_rt_scratch_extend(q->scratch, SCRATCH_INSTANCES, q->count, wanted, sizeof *q->instances) == NULL ||
        scree_rt_scratch_extend(q->scratch, SCRATCH_IDS, q->count, wanted, sizeof *q->ids) == NULL)
      return SCREE_ERROR_OUT_OF_MEMORY;
  }
  if (layer->filtered) {
    uint64_t kept = rocks->first, end = rocks->first + rocks->count;
    for (uint64_t i = rocks->first; i < end; ++i) {
      if (!scree_rt_scene_passes(layer, &q->ids[i])) continue;
      q->ids[kept] = q->ids[i];
      q->instances[kept++] = q->instances[i];
    }
    rocks->count = kept - rocks->first;
  }
  q->count += rocks->count;
  return SCREE_OK;
}

/* The box of the balls round the rocks of a layer, or a little more. */
static void find_tight_box(scene_question* q, uint32_t index) {
  const scene_layer* layer = &q->scene->layers[index];
  layer_rocks* rocks = &q->layers[index];
  const scree_field* field = layer->given.field;
  const uint64_t end = rocks->first + rocks->count;
  int64_t low[3] = {INT64_MAX, INT64_MAX, INT64_MAX}, high[3] = {INT64_MIN, INT64_MIN, INT64_MIN};
  for (uint64_t i = rocks->first; i < end;) { /* rocks come cube by cube */
    const int32_t cube[3] = {q->ids[i].cube[0], q->ids[i].cube[1], q->ids[i].cube[2]};
    uint32_t places = 0; /* where in the cube there are some: a byte for each axis, a bit for each cell along it */
    for (; i < end && q->ids[i].cube[0] == cube[0] && q->ids[i].cube[1] == cube[1] && q->ids[i].cube[2] == cube[2]; ++i) {
      const uint8_t* place = field->cell_places[field_cell_of(field, q->ids[i].local)];
      places |= 1u << place[0] | 0x100u << place[1] | 0x10000u << place[2];
    }
    for (int a = 0; a < 3; ++a, places >>= 8) {
      const int64_t first = (int64_t)cube[a] * field->cells_per_cube, from = first + __builtin_ctz(places),
                    to = first + 31 - __builtin_clz(places & 0xff);
      if (from < low[a]) low[a] = from;
      if (to > high[a]) high[a] = to;
    }
  }
  cell_centre(layer, low, rocks->tight_low);
  cell_centre(layer, high, rocks->tight_high);
  for (int a = 0; a < 3; ++a) {
    rocks->tight_low[a] -= layer->reach;
    rocks->tight_high[a] += layer->reach;
  }
}

scree_result scree_rt_scene_gather(scene_question* q) {
  q->count = 0;
  for (uint32_t k = q->scene->layer_count; k-- > 0;) {
    layer_rocks* rocks = &q->layers[k];
    if (!rocks->needed) continue;
    scree_result result = find_rocks(q, k);
    if (result != SCREE_OK) return result;
    if (rocks->count == 0) continue;
    if (q->scene->layers[k].given.scatter != NULL)
      scree_rt_scene_scatter_box(q, k);
    else if (k > 0 || rocks->wanted)
      find_tight_box(q, k);
    for (uint32_t j = 0; j < k; ++j) {
      layer_rocks* earlier = &q->layers[j];
      int64_t low[3], high[3];
      cells_round(&q->scene->layers[j], rocks->tight_low, rocks->tight_high, low, high);
      if (!scree_rt_scene_cells_may_hold(&q->scene->layers[j], low, high)) continue;
      unite(&earlier->needed, earlier->low, earlier->high, low, high);
      for (int a = 0; a < 3; ++a) {
        if (!earlier->wanted || rocks->tight_low[a] < earlier->region_low[a]) earlier->region_low[a] = rocks->tight_low[a];
        if (!earlier->wanted || rocks->tight_high[a] > earlier->region_high[a]) earlier->region_high[a] = rocks->tight_high[a];
      }
      earlier->wanted = true;
    }
  }
  return SCREE_OK;
}

/* --- delivery -------------------------------------------------------------------------------------------------------------- */

/* Where rocks go to. */
typedef struct rock_sink {
  scree_rock* rocks;
  uint64_t capacity, count;
  bool packed; /* assets of scatters stay as they are in questions */
} rock_sink;

static bool is_in(const int64_t cell[3], const int64_t low[3], const int64_t high[3]) {
  for (int a = 0; a < 3; ++a)
    if (cell[a] < low[a] || cell[a] >= high[a]) return false;
  return true;
}

static void deliver(const scene_question* q, uint32_t index, rock_sink* sink) {
  const scene_layer* layer = &q->scene->layers[index];
  const layer_rocks* rocks = &q->layers[index];
  bool all = memcmp(rocks->low, rocks->asked_low, sizeof rocks->low) == 0 &&
             memcmp(rocks->high, rocks->asked_high, sizeof rocks->high) == 0;
  bool edited = scree_rt_scene_edited(q, index, rocks->asked_low, rocks->asked_high);
  const bool plain = all && !edited && layer->given.scatter == NULL;
  if (plain && sink->capacity - sink->count >= rocks->count && sink->count <= sink->capacity) {
    for (uint64_t i = rocks->first; i < rocks->first + rocks->count; ++i) {
      scree_rock* rock = &sink->rocks[sink->count++];
      memcpy(rock->position, q->instances[i].position, sizeof rock->position);
      rock->asset = q->instances[i].asset;
      rock->id = q->ids[i];
      rock->id.layer = layer->given.key;
    }
    return;
  }
  for (uint64_t i = rocks->first; i < rocks->first + rocks->count; ++i) {
    scree_id id = q->ids[i];
    id.layer = layer->given.key;
    if (!all) {
      int64_t cell[3];
      rock_cell(layer->given.field, &id, cell);
      if (!is_in(cell, rocks->asked_low, rocks->asked_high)) continue;
    }
    if (edited) {
      scree_edit edit = scree_edits_get(q->edits, &id);
      if (edit == SCREE_EDIT_REMOVE || (edit == SCREE_EDIT_HIDE && q->visible)) continue;
    }
    uint32_t asset = q->instances[i].asset;
    if (layer->given.scatter != NULL) {
      if (!scree_rt_scene_scatter_asked(q, layer, &id, asset)) continue;
      if (!sink->packed) asset = scatter_model_of(asset);
    }
    if (sink->count < sink->capacity) {
      scree_rock* rock = &sink->rocks[sink->count];
      memcpy(rock->position, q->instances[i].position, sizeof rock->position);
      rock->asset = asset;
      rock->id = id;
    }
    ++sink->count;
  }
}

/* --- questions ------------------------------------------------------------------------------------------------------------- */

enum {
  MOST_AT_ONCE = 1 << 20,      /* rocks looked at in one go; larger questions are cut up */
  MOST_CELLS_AT_ONCE = 1 << 21 /* where burial is looked at */
};

static scree_result answer(scene_question* q) {
  scree_result result = scree_rt_scene_gather(q);
  return result == SCREE_OK ? scree_rt_scene_keep(q) : result;
}

static void begin(scene_question* q, const scree_scene* scene, const scree_edits* edits, const double origin[3], bool visible,
                  scree_scratch* scratch) {
  q->scene = scene;
  q->edits = edits;
  q->visible = visible;
  q->scratch = scratch;
  memcpy(q->origin, origin, sizeof q->origin);
  q->most = UINT64_MAX;
  q->box_min = q->box_max = NULL;
  memset(q->layers, 0, scene->layer_count * sizeof *q->layers);
}

/* The box of instances of scatters, where one is asked for. */
static void set_box(scene_question* q, const scree_scene_query_desc* d) {
  bool everywhere = true;
  for (int a = 0; a < 3; ++a) everywhere = everywhere && d->min[a] == 0 && d->max[a] == 0;
  q->box_min = everywhere ? NULL : d->min;
  q->box_max = everywhere ? NULL : d->max;
}

static scree_result answer_layer(scene_question* q, uint32_t layer, const int64_t low[3], const int64_t high[3], uint64_t most) {
  q->most = most;
  scree_rt_scene_ask(q, layer, low, high);
  scree_result result = answer(q);
  return result == SCREE_OK && looks_at_burial(q, layer) ? scree_rt_scene_cull(q, layer) : result;
}

scree_result scree_rt_scene_answer(scene_question* q, const scree_scene* scene, const scree_edits* edits, uint32_t layer,
                                   const int64_t low[3], const int64_t high[3], const double origin[3], bool visible, uint64_t most,
                                   scree_scratch* scratch) {
  begin(q, scene, edits, origin, visible, scratch);
  return answer_layer(q, layer, low, high, most);
}

static scree_result check(const scree_scene_query_desc* d, const scree_scratch* scratch) {
  if (d == NULL || d->scene == NULL || scratch == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  if ((d->flags & ~(uint32_t)SCREE_SCENE_VISIBLE) != 0) return SCREE_ERROR_INVALID_ARGUMENT;
  if (d->scene->layer_count < 64 && d->layers >> d->scene->layer_count != 0) return SCREE_ERROR_INVALID_ARGUMENT;
  for (int a = 0; a < 3; ++a)
    if (!isfinite(d->origin[a]) || !(d->min[a] <= d->max[a])) return SCREE_ERROR_INVALID_ARGUMENT;
  return SCREE_OK;
}

/* The cells of a layer that a box asks for. Returns false where there are none, RANGE where they have no names. */
static scree_result find_range(const scree_scene_query_desc* d, const scene_layer* layer, int64_t low[3], int64_t high[3],
                               bool* some) {
  const scree_field* field = layer->given.field;
  const scree_support* support = layer->given.support;
  double h = field->cell_size, bound_low[3], bound_high[3];
  bool everywhere = true;
  for (int a = 0; a < 3; ++a) everywhere = everywhere && d->min[a] == 0 && d->max[a] == 0;
  *some = scree_rt_support_level_bounds(support, layer->level_high > 0 ? layer->level_high : 0, bound_low, bound_high);
  for (int a = 0; a < 3 && *some; ++a) {
    double base = field->origin[a] - support->origin[a];
    low[a] = scree_rt_query_first_cell(bound_low[a] - base - (double)field->centroid_max[a], h) - 1;
    high[a] = scree_rt_query_first_cell(bound_high[a] - base - (double)field->centroid_min[a], h) + 2;
    if (!everywhere) { /* a scatter is asked for what stands in the box, wherever the cubes' middles are */
      const double widen = layer->given.scatter != NULL ? h * 0.500001 : 0;
      int64_t first = scree_rt_query_first_cell(d->min[a] - field->origin[a] - widen, h);
      int64_t end = scree_rt_query_first_cell(d->max[a] - field->origin[a] + widen, h);
      if (first > low[a]) low[a] = first;
      if (end < high[a]) high[a] = end;
    }
    *some = low[a] < high[a];
  }
  if (!*some) return SCREE_OK;
  int64_t kept_low[3], kept_high[3];
  memcpy(kept_low, low, sizeof kept_low);
  memcpy(kept_high, high, sizeof kept_high);
  clamp_cells(field, kept_low, kept_high);
  for (int a = 0; a < 3; ++a)
    if (kept_low[a] != low[a] || kept_high[a] != high[a]) return SCREE_ERROR_RANGE;
  return SCREE_OK;
}

/* What a question about a layer goes through, again for each part of the range where that is large. */
typedef struct layer_visit {
  scene_question* q;
  const scree_scene_query_desc* desc;
  scree_scratch* scratch;
  uint32_t layer;
  rock_sink* sink;
} layer_visit;

static scree_result visit_part(const layer_visit* v, const int64_t low[3], const int64_t high[3], uint64_t most) {
  const scree_scene_query_desc* d = v->desc;
  begin(v->q, d->scene, d->edits, d->origin, (d->flags & SCREE_SCENE_VISIBLE) != 0, v->scratch);
  set_box(v->q, d);
  scree_result result = answer_layer(v->q, v->layer, low, high, most);
  if (result == SCREE_OK) deliver(v->q, v->layer, v->sink);
  return result;
}

static scree_result visit_range(const layer_visit* v, const int64_t low[3], const int64_t high[3]) {
  const scene_layer* layer = &v->desc->scene->layers[v->layer];
  const int64_t n = layer->given.field->cells_per_cube, margin = 2 * (int64_t)layer->given.field->deepest_burial;
  if (!scree_rt_scene_cells_may_hold(layer, low, high)) return SCREE_OK;
  bool burial = (v->desc->flags & SCREE_SCENE_VISIBLE) != 0 && margin > 0;
  double cells = 1;
  int axis = 0;
  for (int a = 0; a < 3; ++a) {
    cells *= (double)(high[a] - low[a] + margin);
    if (high[a] - low[a] > high[axis] - low[axis]) axis = a;
  }
  bool large = high[axis] - low[axis] >= 2 * n;
  if (!(large && burial && cells > MOST_CELLS_AT_ONCE)) {
    scree_result result = visit_part(v, low, high, large ? MOST_AT_ONCE : UINT64_MAX);
    if (result != SCREE_ERROR_CAPACITY) return result;
  }
  int64_t middle[3] = {low[0], low[1], low[2]}, end[3] = {high[0], high[1], high[2]};
  middle[axis] = end[axis] = low[axis] + (high[axis] - low[axis]) / 2;
  scree_result result = visit_range(v, low, end);
  return result == SCREE_OK ? visit_range(v, middle, high) : result;
}

static scree_result find_all(const scree_scene_query_desc* d, scree_scratch* scratch, rock_sink* sink) {
  const scree_scene* scene = d->scene;
  scene_question q;
  uint64_t wanted = d->layers != 0 ? d->layers : UINT64_MAX >> (64 - scene->layer_count);
  int64_t low[SCENE_MAX_LAYERS][3], high[SCENE_MAX_LAYERS][3];
  for (uint32_t k = 0; k < scene->layer_count; ++k) {
    bool some = false;
    scree_result result = SCREE_OK;
    if (wanted >> k & 1) result = find_range(d, &scene->layers[k], low[k], high[k], &some);
    if (result != SCREE_OK) return result;
    if (!some) wanted &= ~(UINT64_C(1) << k);
  }
  /* All layers at once, so that none is looked at twice, unless they are too many rocks or each has its own burial. */
  if ((d->flags & SCREE_SCENE_VISIBLE) == 0) {
    begin(&q, scene, d->edits, d->origin, false, scratch);
    set_box(&q, d);
    q.most = MOST_AT_ONCE;
    for (uint64_t rest = wanted; rest != 0; rest &= rest - 1) {
      uint32_t k = (uint32_t)__builtin_ctzll(rest);
      scree_rt_scene_ask(&q, k, low[k], high[k]);
    }
    scree_result result = answer(&q);
    for (uint64_t rest = wanted; rest != 0 && result == SCREE_OK; rest &= rest - 1)
      deliver(&q, (uint32_t)__builtin_ctzll(rest), sink);
    if (result != SCREE_ERROR_CAPACITY) return result;
  }
  for (uint64_t rest = wanted; rest != 0; rest &= rest - 1) {
    uint32_t k = (uint32_t)__builtin_ctzll(rest);
    layer_visit visit = {&q, d, scratch, k, sink};
    scree_result result = visit_range(&visit, low[k], high[k]);
    if (result != SCREE_OK) return result;
  }
  return SCREE_OK;
}

scree_result scree_scene_count(const scree_scene_query_desc* desc, scree_scratch* scratch, uint64_t* count) {
  if (count == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  *count = 0;
  scree_result result = check(desc, scratch);
  if (result != SCREE_OK) return result;
  rock_sink sink = {NULL, 0, 0, false};
  result = find_all(desc, scratch, &sink);
  if (result == SCREE_OK) *count = sink.count;
  return result;
}

scree_result scree_rt_scene_fill(const scree_scene_query_desc* desc, bool packed, scree_scratch* scratch, scree_rock* rocks,
                                 uint64_t capacity, uint64_t* count) {
  if (count == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  *count = 0;
  if (rocks == NULL && capacity > 0) return SCREE_ERROR_INVALID_ARGUMENT;
  scree_result result = check(desc, scratch);
  if (result != SCREE_OK) return result;
  rock_sink sink = {rocks, capacity, 0, packed};
  result = find_all(desc, scratch, &sink);
  if (result != SCREE_OK) return result;
  *count = sink.count;
  return sink.count > capacity ? SCREE_ERROR_CAPACITY : SCREE_OK;
}

scree_result scree_scene_fill(const scree_scene_query_desc* desc, scree_scratch* scratch, scree_rock* rocks, uint64_t capacity,
                              uint64_t* count) {
  return scree_rt_scene_fill(desc, false, scratch, rocks, capacity, count);
}

scree_result scree_rt_scene_block(const scree_scene* scene, const scree_edits* edits, uint32_t layer, const int32_t cube_low[3],
                                  const int32_t cube_high[3], const double origin[3], bool visible, scree_scratch* scratch,
                                  const scree_rock** rocks, uint64_t* count) {
  const scree_field* field = scene->layers[layer].given.field;
  scene_question q;
  int64_t low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    low[a] = (int64_t)cube_low[a] * field->cells_per_cube;
    high[a] = (int64_t)cube_high[a] * field->cells_per_cube;
  }
  *rocks = NULL;
  *count = 0;
  scree_result result = scree_rt_scene_answer(&q, scene, edits, layer, low, high, origin, visible, UINT64_MAX, scratch);
  if (result != SCREE_OK) return result;
  rock_sink sink = {scree_rt_scratch_reserve(scratch, SCRATCH_ROCKS, q.layers[layer].count + 1, sizeof(scree_rock)),
                    q.layers[layer].count, 0, false};
  if (sink.rocks == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  deliver(&q, layer, &sink);
  *rocks = sink.rocks;
  *count = sink.count;
  return SCREE_OK;
}

/* --- one rock -------------------------------------------------------------------------------------------------------------- */

/* Its asset as it is in the question, or NULL. */
static const uint32_t* find_asset(const scene_question* q, uint32_t layer, const scree_id* id) {
  const layer_rocks* rocks = &q->layers[layer];
  for (uint64_t i = rocks->first; i < rocks->first + rocks->count; ++i)
    if (memcmp(q->ids[i].cube, id->cube, sizeof id->cube) == 0 && q->ids[i].local == id->local) return &q->instances[i].asset;
  return NULL;
}

/* A rock of a field, whether it exists or not. Returns false when there is no such rock in the tile. */
static bool describe(const scree_field* field, const scree_id* id, const double origin[3], scree_rock* rock) {
  uint32_t code = scree_field_tile_code(field, id->cube), slot = scree_rt_field_slot(field, code, id->local);
  if (slot == UINT32_MAX) return false;
  if (rock == NULL) return true;
  int64_t cell[3];
  rock_cell(field, id, cell);
  for (int a = 0; a < 3; ++a) rock->position[a] = (float)((field->origin[a] - origin[a]) + field->cell_size * (double)cell[a]);
  rock->asset = field_slots(field, &field->tiles[code]).asset[slot];
  rock->id = *id;
  return true;
}

scree_result scree_scene_find(const scree_scene* scene, const scree_edits* edits, scree_scratch* scratch, const scree_id* id,
                              const double origin[3], scree_rock* rock, scree_rock_state* state) {
  if (scene == NULL || scratch == NULL || id == NULL || origin == NULL || state == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  for (int a = 0; a < 3; ++a)
    if (!isfinite(origin[a])) return SCREE_ERROR_INVALID_ARGUMENT;
  *state = SCREE_ROCK_UNKNOWN;
  uint32_t layer = scree_scene_layer_of(scene, id->layer);
  if (layer == UINT32_MAX) return SCREE_OK;
  const scene_layer* own = &scene->layers[layer];
  const scree_field* field = own->given.field;
  const bool scattered = own->given.scatter != NULL;
  if (!(scattered ? scree_rt_scene_scatter_rock(own, id, NULL, origin, rock) : describe(field, id, origin, rock))) return SCREE_OK;

  int64_t low[3], high[3];
  rock_cell(field, id, low);
  for (int a = 0; a < 3; ++a) high[a] = low[a] + 1;
  *state = SCREE_ROCK_OUTSIDE;
  clamp_cells(field, low, high);
  scene_question q;
  begin(&q, scene, edits, origin, false, scratch);
  scree_rt_scene_ask(&q, layer, low, high);
  scree_result result = scree_rt_scene_gather(&q);
  const uint32_t* asset = result == SCREE_OK ? find_asset(&q, layer, id) : NULL;
  if (asset == NULL) return result;
  if (scattered) scree_rt_scene_scatter_rock(own, id, asset, origin, rock);
  *state = SCREE_ROCK_DROPPED;
  result = scree_rt_scene_keep(&q);
  if (result != SCREE_OK || find_asset(&q, layer, id) == NULL) return result;
  scree_edit edit = scree_edits_get(edits, id);
  *state = edit == SCREE_EDIT_REMOVE ? SCREE_ROCK_REMOVED : edit == SCREE_EDIT_HIDE ? SCREE_ROCK_HIDDEN : SCREE_ROCK_EXISTS;
  return SCREE_OK;
}

void scree_rt_scene_cubes_box(const scree_scene* scene, uint32_t layer, uint32_t far_level, const int32_t cube_low[3],
                              const int32_t cube_high[3], double min[3], double max[3]) {
  const scree_field* field = scene->layers[layer].given.field;
  double size = field->cell_size * field->cells_per_cube;
  for (uint32_t i = 0; i < far_level; ++i) size *= 2;
  for (int a = 0; a < 3; ++a) { /* cells are centred on the corners */
    min[a] = field->origin[a] - field->cell_size * 0.5 + size * (double)cube_low[a];
    max[a] = field->origin[a] - field->cell_size * 0.5 + size * (double)cube_high[a];
  }
}

double scree_rt_scene_reach(const scree_scene* scene, uint32_t layer) {
  const scene_layer* own = &scene->layers[layer];
  double reach = own->reach;
  for (uint32_t k = 0; k < scene->layer_count; ++k)
    if (scene->layers[k].reach > reach) reach = scene->layers[k].reach;
  /* A rock's cell is within `reach` of where the support decides about it; each earlier layer may hand on what changes by another
   * two radii; burial looks so many cells along each axis, half a cell of which lies in the rock's own. */
  double burial = (double)own->given.field->deepest_burial * own->given.field->cell_size;
  return own->reach + 2 * reach * (double)layer + burial;
}
