#include "scene_live.h"

#include <math.h>
#include <scree/cliff.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"

#define PATH_SIZE (2 * SCENE_FILE_SIZE)
#define BOX_CELLS 4e6 /* of a box that is counted in one go, where a field may have too many rocks */

/* A pack, or models from files, that all fields share which name them. */
typedef struct opened_pack {
  char* key;        /* owned: the pack's path, or the names of all files; NULL = free slot */
  scree_pack* pack; /* one of the two */
  scene_models* models;
  uint32_t users;
} opened_pack;

/* A field that is open has a pack, a support, and a field or a scatter. */
typedef struct opened_field {
  opened_pack* pack;
  scree_field* field;
  scree_scatter* scatter;
  scree_support* support;
  scree_layer layer; /* its filters point at what `files` holds */
  scree_filter filters[SCENE_FILTERS_MAX];
} opened_field;

struct scene_live {
  scene_live_desc desc;
  scene_files* files;
  scree_scratch* scratch;
  scree_scene* scene;
  opened_pack packs[SCENE_FIELDS_MAX + 1]; /* one more: a field may change to a new pack before it leaves the old one */
  opened_field fields[SCENE_FIELDS_MAX];
  uint32_t layers[SCENE_FIELDS_MAX]; /* of each field, UINT32_MAX = none */
  uint32_t field_count;
};

/* --- Packs --- */

/* The path of a pack, or the names of model files one a line; to be freed. */
static scree_result make_key(scene_live* w, uint32_t index, char** out, scree_error* error) {
  const scene_field* field = &w->desc.scene->fields[index];
  const scene_scatter* scatter = &field->scatter;
  const bool has_models = field->is_scatter && scatter->model_count > 0;
  char* key = malloc(has_models ? (size_t)scatter->model_count * (SCENE_FILE_SIZE + 1) + 1 : PATH_SIZE);
  if (key == NULL) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", w->desc.paths.scene);
  scree_result result = SCREE_OK;
  if (has_models) {
    size_t length = 0;
    for (uint32_t i = 0; i < scatter->model_count; ++i) {
      const size_t size = strlen(scatter->models[i]);
      memcpy(key + length, scatter->models[i], size);
      key[length + size] = '\n';
      length += size + 1;
    }
    key[length] = '\0';
  } else {
    char where[64];
    snprintf(where, sizeof where, "fields[%u].pack", (unsigned)index);
    result = scene_find_pack(&w->desc.paths, where, field->pack, key, PATH_SIZE, error);
  }
  if (result != SCREE_OK) free(key), key = NULL;
  *out = key;
  return result;
}

/* Fills a free slot with what the key of field `index` names. */
static scree_result fill_slot(scene_live* w, uint32_t index, opened_pack* slot, const char* key, scree_error* error) {
  const scene_field* field = &w->desc.scene->fields[index];
  scree_result result;
  if (field->is_scatter && field->scatter.model_count > 0) {
    result = scene_models_create(w->desc.scene, index, &w->desc.paths, &slot->models, error);
    if (result != SCREE_OK) return result;
  } else {
    result = scree_pack_open_file(key, NULL, &slot->pack);
  }
  if (result == SCREE_OK && w->desc.pack_opened != NULL)
    result = w->desc.pack_opened(w->desc.user, (uint32_t)(slot - w->packs), slot->pack, slot->models);
  if (result == SCREE_OK) return SCREE_OK;
  scree_pack_close(slot->pack);
  const bool has_models = slot->models != NULL;
  scene_models_destroy(slot->models);
  slot->pack = NULL;
  slot->models = NULL;
  if (has_models)
    return fail_with(error, result, "%s: fields[%u].models: %s", w->desc.paths.scene, (unsigned)index, scree_result_string(result));
  return fail_with(error, result, "%s: %s", key, scree_result_string(result));
}

static scree_result open_pack(scene_live* w, uint32_t index, opened_pack** out, scree_error* error) {
  char* key = NULL;
  scree_result result = make_key(w, index, &key, error);
  if (result != SCREE_OK) return result;
  opened_pack* slot = NULL;
  for (uint32_t i = 0; i <= SCENE_FIELDS_MAX; ++i) {
    opened_pack* p = &w->packs[i];
    if (p->key != NULL && strcmp(p->key, key) == 0) {
      free(key);
      ++p->users;
      *out = p;
      return SCREE_OK;
    }
    if (p->key == NULL && slot == NULL) slot = p;
  }
  result =
      slot != NULL ? fill_slot(w, index, slot, key, error) : fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: too many packs", key);
  if (result != SCREE_OK) {
    free(key);
    return result;
  }
  slot->key = key;
  slot->users = 1;
  *out = slot;
  return SCREE_OK;
}

static void close_pack(scene_live* w, opened_pack* p) {
  if (p == NULL || --p->users > 0) return;
  if (w->desc.pack_closing != NULL) w->desc.pack_closing(w->desc.user, (uint32_t)(p - w->packs));
  scree_pack_close(p->pack);
  scene_models_destroy(p->models);
  free(p->key);
  *p = (opened_pack){.key = NULL};
}

/* --- Fields --- */

static bool is_open(const opened_field* f) {
  return f->pack != NULL && (f->field != NULL || f->scatter != NULL) && f->support != NULL;
}

static scree_result fill_filter(scene_live* w, const scene_filter* model, const char* where, scree_filter* out,
                                scree_error* error) {
  *out = (scree_filter){.kind = model->kind,
                        .inverted = model->inverted,
                        .from = (float)model->from,
                        .to = (float)model->to,
                        .fade = (float)model->fade,
                        .spacing = (float)model->map.spacing};
  memcpy(out->centre, model->position, sizeof out->centre);
  if (model->kind == SCREE_FILTER_ALTITUDE) return SCREE_OK;
  const height_samples* samples;
  scree_result result = scene_files_heights(w->files, &w->desc.paths, where, &model->map, &samples, error);
  if (result != SCREE_OK) return result;
  out->values = samples->heights;
  out->width = samples->width;
  out->depth = samples->depth;
  return SCREE_OK;
}

/* One weight a model as the runtime wants it; the file may give one a variant instead, which then goes for each of its ages. */
static scree_result fill_weights(scene_live* w, uint32_t index, const opened_pack* from, float** out, scree_error* error) {
  const scene_scatter* scatter = &w->desc.scene->fields[index].scatter;
  scree_pack_info info = {.asset_count = from->models != NULL ? from->models->count : 0};
  *out = NULL;
  if (from->pack != NULL) scree_pack_get_info(from->pack, &info);
  if (scatter->weight_count == 0) return SCREE_OK;
  const bool by_variant = scatter->weight_count != info.asset_count;
  if (by_variant && scatter->weight_count != info.variant_count) {
    if (from->models != NULL)
      return fail_with(error, SCREE_ERROR_RANGE, "%s: fields[%u].weights: expected %u numbers, one a model", w->desc.paths.scene,
                       (unsigned)index, (unsigned)info.asset_count);
    return fail_with(error, SCREE_ERROR_RANGE, "%s: fields[%u].weights: expected %u numbers, one a variant, or %u, one a model",
                     w->desc.paths.scene, (unsigned)index, (unsigned)info.variant_count, (unsigned)info.asset_count);
  }
  float* weights = malloc((info.asset_count > 0 ? info.asset_count : 1) * sizeof *weights);
  if (weights == NULL) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", w->desc.paths.scene);
  scree_result result = SCREE_OK;
  for (uint32_t i = 0; i < info.asset_count && result == SCREE_OK; ++i) {
    scree_model model = {.variant = i};
    if (by_variant) result = scree_pack_get_model(from->pack, i, &model);
    if (result != SCREE_OK || model.variant >= scatter->weight_count) break;
    weights[i] = (float)scatter->weights[model.variant];
  }
  *out = weights;
  return result == SCREE_OK ? SCREE_OK : fail_with(error, result, "%s: %s", from->key, scree_result_string(result));
}

static scree_result open_scatter(scene_live* w, uint32_t index, opened_field* made, scree_error* error) {
  const scene_field* model = &w->desc.scene->fields[index];
  const scene_scatter* scatter = &model->scatter;
  const opened_pack* from = made->pack;
  if (from->pack != NULL) {
    scree_pack_info info;
    scree_pack_get_info(from->pack, &info);
    if (info.kind == SCREE_PACK_CLIFF)
      return fail_with(error, SCREE_ERROR_PACK_KIND, "%s: fields[%u].pack: %s holds a cliff, whose blocks lie where they fell",
                       w->desc.paths.scene, (unsigned)index, from->key);
    if (info.kind != SCREE_PACK_MODELS)
      return fail_with(error, SCREE_ERROR_PACK_KIND,
                       "%s: fields[%u].pack: %s holds rocks, which fill shapes: give the field a cell_size instead of a spacing",
                       w->desc.paths.scene, (unsigned)index, from->key);
  }
  char where[64];
  snprintf(where, sizeof where, "fields[%u].ages", (unsigned)index);
  scree_filter ages;
  float* weights = NULL;
  scree_result result = scatter->has_ages ? fill_filter(w, &scatter->ages, where, &ages, error) : SCREE_OK;
  if (result == SCREE_OK) result = fill_weights(w, index, from, &weights, error);
  if (result == SCREE_OK) {
    scree_scatter_desc desc = {.pack = from->pack,
                               .models = from->models != NULL ? from->models->shapes : NULL,
                               .model_count = from->models != NULL ? from->models->count : 0,
                               .weights = weights,
                               .age_mask = scatter->has_ages ? &ages : NULL,
                               .spacing = scatter->spacing,
                               .seed = model->seed,
                               .scale_min = (float)scatter->scale[0],
                               .scale_max = (float)scatter->scale[1],
                               .max_slope = (float)scatter->max_slope};
    memcpy(desc.origin, model->origin, sizeof desc.origin);
    scree_error cause = {""};
    result = scree_scatter_create(&desc, NULL, &made->scatter, &cause);
    if (result != SCREE_OK)
      fail_with(error, result, "%s: fields[%u]: %.400s", w->desc.paths.scene, (unsigned)index,
                cause.message[0] != '\0' ? cause.message : scree_result_string(result));
  }
  free(weights);
  return result;
}

static scree_result open_cliff(scene_live* w, uint32_t index, opened_field* made, scree_error* error) {
  const scene_field* model = &w->desc.scene->fields[index];
  scree_cliff_desc desc = {.pack = made->pack->pack,
                           .time = model->cliff.time,
                           .what = model->cliff.what,
                           .turn = model->cliff.turn / 360,
                           .scale = (float)model->cliff.scale,
                           .seed = model->seed};
  memcpy(desc.origin, model->origin, sizeof desc.origin);
  scree_error cause = {""};
  const scree_result result = scree_cliff_create(&desc, NULL, &made->scatter, &cause);
  if (result == SCREE_OK) return SCREE_OK;
  return fail_with(error, result, "%s: fields[%u]: %s: %.400s", w->desc.paths.scene, (unsigned)index, made->pack->key,
                   cause.message[0] != '\0' ? cause.message : scree_result_string(result));
}

/* A box around what stands of a cliff and its blocks, however it is turned, for those who ask where its instances are. */
static scree_result box_cliff(scene_live* w, uint32_t index, opened_field* made, scree_error* error) {
  const scene_field* model = &w->desc.scene->fields[index];
  const scree_pack* pack = made->pack->pack;
  scree_cliff_time time;
  scree_asset standing;
  scree_result result = scree_pack_get_time(pack, model->cliff.time, &time);
  if (result == SCREE_OK) result = scree_pack_get_asset(pack, time.asset, &standing);
  if (result == SCREE_OK) {
    double reach[3];
    for (int a = 0; a < 3; ++a)
      reach[a] = fmax(fmax(fabs((double)time.bounds_min[a]), fabs((double)time.bounds_max[a])),
                      fmax(fabs((double)standing.bounds_min[a]), fabs((double)standing.bounds_max[a])));
    const double across = sqrt(reach[0] * reach[0] + reach[2] * reach[2]) * model->cliff.scale;
    const scree_shape box = {.kind = SCREE_SHAPE_BOX,
                             .box.half = {(float)across, (float)(reach[1] * model->cliff.scale), (float)across}};
    scree_support_desc desc = {.shapes = &box, .shape_count = 1};
    memcpy(desc.origin, model->origin, sizeof desc.origin);
    result = scree_support_create(&desc, NULL, &made->support, NULL);
  }
  if (result == SCREE_OK) return SCREE_OK;
  return fail_with(error, result, "%s: fields[%u]: %s", w->desc.paths.scene, (unsigned)index, scree_result_string(result));
}

static scree_result open_field(scene_live* w, uint32_t index, opened_field* made, scree_error* error) {
  const scene_field* model = &w->desc.scene->fields[index];
  scree_result result = open_pack(w, index, &made->pack, error);
  if (result != SCREE_OK) return result;
  if (model->is_scatter) return open_scatter(w, index, made, error);
  if (model->is_cliff) return open_cliff(w, index, made, error);
  scree_pack_info info;
  scree_pack_get_info(made->pack->pack, &info);
  if (info.kind == SCREE_PACK_CLIFF)
    return fail_with(error, SCREE_ERROR_PACK_KIND,
                     "%s: fields[%u].pack: %s holds a cliff, which fills no shape: give the field a time", w->desc.paths.scene,
                     (unsigned)index, made->pack->key);
  if (info.kind != SCREE_PACK_TILES)
    return fail_with(error, SCREE_ERROR_PACK_KIND,
                     "%s: fields[%u].pack: %s holds models, which stand on the ground: give the field a spacing",
                     w->desc.paths.scene, (unsigned)index, made->pack->key);
  scree_field_desc desc = {.pack = made->pack->pack, .seed = model->seed, .cell_size = model->cell_size};
  memcpy(desc.origin, model->origin, sizeof desc.origin);
  result = scree_field_create(&desc, NULL, &made->field);
  if (result == SCREE_OK) return SCREE_OK;
  return fail_with(error, result, "%s: fields[%u]: %s: %s", w->desc.paths.scene, (unsigned)index, made->pack->key,
                   scree_result_string(result));
}

static scree_result open_support(scene_live* w, uint32_t index, const scree_support* reuse, opened_field* made,
                                 scree_error* error) {
  if (w->desc.scene->fields[index].is_cliff) return box_cliff(w, index, made, error);
  scree_result result =
      scene_support_create(w->desc.scene, index, &w->desc.paths, w->files, &w->desc.jobs, reuse, &made->support, error);
  if (result != SCREE_OK) return result;
  double min[3], max[3];
  scree_support_bounds(made->support, min, max);
  for (int a = 0; a < 3; ++a)
    if (isinf(min[a]) || isinf(max[a]))
      return fail_with(error, SCREE_ERROR_RANGE, "%s: fields[%u].support: it has no end; cut it to size with an intersection",
                       w->desc.paths.scene, (unsigned)index);
  return SCREE_OK;
}

static scree_result fill_layer(scene_live* w, uint32_t index, opened_field* made, scree_error* error) {
  const scene_field* model = &w->desc.scene->fields[index];
  made->layer = (scree_layer){.field = made->field,
                              .scatter = made->scatter,
                              .support = model->is_cliff ? NULL : made->support,
                              .key = scene_field_key(w->desc.scene, index),
                              .density = (float)model->density,
                              .filter_count = model->filter_count};
  if (!model->is_scatter && !model->is_cliff) {
    scree_pack_info info;
    scree_pack_get_info(made->pack->pack, &info);
    made->layer.threshold = (float)model->threshold;
    made->layer.shell_depth = model->shell ? (float)(2 * (double)info.max_radius * model->cell_size) : 0;
  }
  for (uint32_t i = 0; i < model->filter_count; ++i) {
    char where[64];
    snprintf(where, sizeof where, "fields[%u].filters[%u]", (unsigned)index, (unsigned)i);
    scree_result result = fill_filter(w, &model->filters[i], where, &made->filters[i], error);
    if (result != SCREE_OK) return result;
  }
  return SCREE_OK;
}

/* The scene of all fields that are open, with `made` in the place of field `index`. */
static scree_result make_scene(const scene_live* w, uint32_t index, const opened_field* made, scree_scene** out,
                               uint32_t layer_of[SCENE_FIELDS_MAX], scree_error* error) {
  scree_layer layers[SCENE_FIELDS_MAX];
  uint32_t fields[SCENE_FIELDS_MAX], count = 0;
  for (uint32_t i = 0; i < SCENE_FIELDS_MAX; ++i) {
    const opened_field* f = i == index ? made : &w->fields[i];
    layer_of[i] = UINT32_MAX;
    if (f == NULL || !is_open(f)) continue;
    layers[count] = f->layer;
    layers[count].filters = f->filters;
    fields[count] = i;
    layer_of[i] = count++;
  }
  *out = NULL;
  if (count == 0) return SCREE_OK;
  const scree_scene_desc desc = {layers, count};
  scree_error cause = {""};
  scree_result result = scree_scene_create(&desc, NULL, out, &cause);
  if (result == SCREE_OK) return SCREE_OK;
  /* The runtime counts layers; people count fields. */
  uint32_t number = 0;
  int end = 0;
  if (sscanf(cause.message, "layer %u: %n", &number, &end) != 1 || end == 0 || number >= count) number = count, end = 0;
  const char* what = cause.message[0] != '\0' ? cause.message + end : scree_result_string(result);
  return fail_with(error, result, "%s: fields[%u]: %.400s", w->desc.paths.scene,
                   (unsigned)(number < count ? fields[number] : index), what);
}

static void replace_scene(scene_live* w, scree_scene* scene, const uint32_t layer_of[SCENE_FIELDS_MAX]) {
  scree_scene_destroy(w->scene);
  w->scene = scene;
  memcpy(w->layers, layer_of, sizeof w->layers);
}

scree_result scene_live_update(scene_live* w, uint32_t index, uint32_t changed, scree_error* error) {
  if (index >= w->desc.scene->field_count || index >= SCENE_FIELDS_MAX)
    return fail_with(error, SCREE_ERROR_INVALID_ARGUMENT, "there is no field %u", (unsigned)index);
  opened_field* f = &w->fields[index];
  const bool was_open = is_open(f);
  if (was_open && (changed & (SCENE_CHANGED_PACK | SCENE_CHANGED_SUPPORT | SCENE_CHANGED_RULES)) == 0) return SCREE_OK;
  const bool new_field = !was_open || (changed & SCENE_CHANGED_PACK) != 0;
  const bool new_support =
      !was_open || (changed & SCENE_CHANGED_SUPPORT) != 0 || (new_field && w->desc.scene->fields[index].is_cliff);
  opened_field made = *f; /* takes the place of *f when all is well */
  if (new_field) made.pack = NULL, made.field = NULL, made.scatter = NULL;
  if (new_support) made.support = NULL;
  scree_result result = new_field ? open_field(w, index, &made, error) : SCREE_OK;
  if (result == SCREE_OK && new_support) result = open_support(w, index, f->support, &made, error);
  if (result == SCREE_OK) result = fill_layer(w, index, &made, error);
  scree_scene* scene = NULL;
  uint32_t layer_of[SCENE_FIELDS_MAX];
  if (result == SCREE_OK) result = make_scene(w, index, &made, &scene, layer_of, error);
  opened_field gone = result == SCREE_OK ? *f : made;
  if (result == SCREE_OK) {
    *f = made;
    replace_scene(w, scene, layer_of);
    if (index >= w->field_count) w->field_count = index + 1;
  }
  if (new_support) scree_support_destroy(gone.support);
  if (new_field) {
    scree_field_destroy(gone.field);
    scree_scatter_destroy(gone.scatter);
    close_pack(w, gone.pack);
  }
  return result;
}

static void forget_all(scene_live* w) {
  scree_scene_destroy(w->scene);
  w->scene = NULL;
  for (uint32_t i = 0; i < SCENE_FIELDS_MAX; ++i) {
    opened_field* f = &w->fields[i];
    w->layers[i] = UINT32_MAX;
    scree_support_destroy(f->support);
    scree_field_destroy(f->field);
    scree_scatter_destroy(f->scatter);
    close_pack(w, f->pack);
    memset(f, 0, sizeof *f);
  }
  w->field_count = 0;
}

scree_result scene_live_update_all(scene_live* w, scree_error* error) {
  scree_result first = SCREE_OK;
  forget_all(w);
  for (uint32_t i = 0; i < w->desc.scene->field_count; ++i) {
    scree_error own = {""};
    scree_result result = scene_live_update(w, i, SCENE_CHANGED_ALL, &own);
    if (result == SCREE_OK || first != SCREE_OK) continue;
    first = result;
    if (error != NULL) *error = own;
  }
  return first;
}

/* --- Queries --- */

typedef struct counter {
  scree_scene_query_desc desc;
  scree_scratch* scratch;
  const scree_support* support;
  double origin[3], cell, reach, shell, rocks_per_cell;
  uint64_t count, most;
} counter;

/* Counts the rocks of a box, part by part where it is large, until there are more than `most`. Parts that are wholly outside, or
 * deeper than the shell, are passed over. */
static scree_result count_box(counter* c, const double min[3], const double max[3]) {
  if (c->count > c->most) return SCREE_OK;
  double cells = c->rocks_per_cell, squared = 0;
  int longest = 0;
  for (int a = 0; a < 3; ++a) {
    const double side = max[a] - min[a];
    cells *= ceil(side / c->cell) + 1;
    squared += 0.25 * side * side;
    if (side > max[longest] - min[longest]) longest = a;
  }
  if (cells <= BOX_CELLS) {
    uint64_t count = 0;
    memcpy(c->desc.min, min, sizeof c->desc.min);
    memcpy(c->desc.max, max, sizeof c->desc.max);
    scree_result result = scree_scene_count(&c->desc, c->scratch, &count);
    c->count += count;
    return result;
  }
  float at[3], distance;
  for (int a = 0; a < 3; ++a) at[a] = (float)(0.5 * (min[a] + max[a]) - c->origin[a]);
  scree_support_distance(c->support, &at[0], &at[1], &at[2], &distance, 1);
  const double around = 1.01 * (sqrt(squared) + c->reach);
  if ((double)distance > around || (c->shell > 0 && (double)-distance > around + c->shell)) return SCREE_OK;
  double middle[3];
  memcpy(middle, max, sizeof middle);
  middle[longest] = 0.5 * (min[longest] + max[longest]);
  scree_result result = count_box(c, min, middle);
  memcpy(middle, min, sizeof middle);
  middle[longest] = 0.5 * (min[longest] + max[longest]);
  return result == SCREE_OK ? count_box(c, middle, max) : result;
}

/* Counts the rocks of a field that may have more than `most`, in time that does not depend on how many more there are. */
static scree_result count_rocks(scene_live* w, uint32_t index, uint32_t flags, uint64_t most, uint64_t* count) {
  const opened_field* f = &w->fields[index];
  *count = 0;
  if (w->desc.scene->fields[index].is_cliff) return SCREE_OK; /* never more than a pack holds */
  if (f->scatter != NULL) {
    /* Discs of half the spacing do not overlap: they cover at most all of the ground, and half of it at least. */
    double min[3], max[3];
    const double spacing = w->desc.scene->fields[index].scatter.spacing;
    scree_support_bounds(f->support, min, max);
    const double points = (max[0] - min[0] + spacing) * (max[2] - min[2] + spacing) / (0.78 * spacing * spacing);
    *count = points > (double)most ? most + 1 : 0;
    return SCREE_OK;
  }
  scree_pack_info info;
  scree_pack_get_info(f->pack->pack, &info);
  counter c = {.desc = {.scene = w->scene, .flags = flags, .layers = UINT64_C(1) << w->layers[index]},
               .scratch = w->scratch,
               .support = f->support,
               .cell = w->desc.scene->fields[index].cell_size,
               .reach = scene_live_reach(w, index),
               .shell = (double)f->layer.shell_depth,
               .rocks_per_cell = info.max_rocks_per_cell,
               .most = most};
  memcpy(c.origin, w->desc.scene->fields[index].support->position, sizeof c.origin);
  double min[3], max[3], cells = c.rocks_per_cell;
  scree_support_bounds(f->support, min, max);
  for (int a = 0; a < 3; ++a) {
    min[a] -= c.reach;
    max[a] += c.reach;
    cells *= (max[a] - min[a]) / c.cell;
  }
  *count = 0;
  if (cells <= (double)most) return SCREE_OK; /* it cannot have more */
  scree_result result = min[0] < max[0] ? count_box(&c, min, max) : SCREE_OK;
  *count = c.count;
  return result;
}

static bool make_room(scene_rocks* rocks, uint64_t count) {
  if (count <= rocks->capacity && rocks->rocks != NULL) return true;
  const uint64_t room = count + count / 8 + 64;
  scree_rock* grown = room <= SIZE_MAX / sizeof *grown ? realloc(rocks->rocks, (size_t)room * sizeof *grown) : NULL;
  if (grown == NULL) return false;
  rocks->rocks = grown;
  rocks->capacity = room;
  return true;
}

void scene_rocks_free(scene_rocks* rocks) {
  free(rocks->rocks);
  *rocks = (scene_rocks){.rocks = NULL};
}

scree_result scene_live_query(scene_live* w, uint32_t index, const double origin[3], uint32_t flags, uint64_t most,
                              scene_rocks* out, scree_error* error) {
  out->count = 0;
  if (index >= SCENE_FIELDS_MAX || w->layers[index] == UINT32_MAX)
    return fail_with(error, SCREE_ERROR_INVALID_ARGUMENT, "%s: fields[%u] is not open", w->desc.paths.scene, (unsigned)index);
  uint64_t count = 0;
  scree_result result = count_rocks(w, index, flags, most, &count);
  if (result == SCREE_OK && count > most)
    return fail_with(error, SCREE_ERROR_RANGE, "%s: fields[%u]: it has more than %llu %s", w->desc.paths.scene, (unsigned)index,
                     (unsigned long long)most,
                     w->fields[index].scatter != NULL ? "models; enlarge spacing" : "rocks; enlarge cell_size");
  /* What the last query needed is often enough for this one; if not, the first try tells how many there are. */
  scree_scene_query_desc desc = {.scene = w->scene, .flags = flags, .layers = UINT64_C(1) << w->layers[index]};
  memcpy(desc.origin, origin, sizeof desc.origin);
  for (int round = 0; round < 2 && result == SCREE_OK; ++round) {
    if (!make_room(out, count > 0 ? count : 1))
      return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: fields[%u]: out of memory for %llu rocks", w->desc.paths.scene,
                       (unsigned)index, (unsigned long long)count);
    result = scree_scene_fill(&desc, w->scratch, out->rocks, out->capacity, &count);
    if (result != SCREE_ERROR_CAPACITY || round > 0) break;
    result = SCREE_OK;
  }
  out->count = count;
  if (result == SCREE_OK) return SCREE_OK;
  out->count = 0;
  return fail_with(error, result, "%s: fields[%u]: %s", w->desc.paths.scene, (unsigned)index, scree_result_string(result));
}

/* --- Making, and questions --- */

scree_result scene_live_create(const scene_live_desc* desc, scene_live** out, scree_error* error) {
  *out = NULL;
  scene_live* w = calloc(1, sizeof *w);
  if (w == NULL) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "out of memory");
  w->desc = *desc;
  for (uint32_t i = 0; i < SCENE_FIELDS_MAX; ++i) w->layers[i] = UINT32_MAX;
  w->files = scene_files_create();
  if (w->files == NULL || scree_scratch_create(NULL, &w->scratch) != SCREE_OK) {
    scene_live_destroy(w);
    return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "out of memory");
  }
  *out = w;
  return SCREE_OK;
}

void scene_live_destroy(scene_live* w) {
  if (w == NULL) return;
  forget_all(w);
  scree_scratch_destroy(w->scratch);
  scene_files_destroy(w->files);
  free(w);
}

const scree_scene* scene_live_scene(const scene_live* w) {
  return w->scene;
}

uint32_t scene_live_layer(const scene_live* w, uint32_t index) {
  return index < SCENE_FIELDS_MAX ? w->layers[index] : UINT32_MAX;
}

static const opened_field* field_at(const scene_live* w, uint32_t index) {
  return index < SCENE_FIELDS_MAX && is_open(&w->fields[index]) ? &w->fields[index] : NULL;
}

const scree_field* scene_live_field(const scene_live* w, uint32_t index) {
  const opened_field* f = field_at(w, index);
  return f != NULL ? f->field : NULL;
}

const scree_support* scene_live_support(const scene_live* w, uint32_t index) {
  const opened_field* f = field_at(w, index);
  return f != NULL ? f->support : NULL;
}

const scree_pack* scene_live_pack(const scene_live* w, uint32_t index) {
  const opened_field* f = field_at(w, index);
  return f != NULL ? f->pack->pack : NULL;
}

const scree_scatter* scene_live_scatter(const scene_live* w, uint32_t index) {
  const opened_field* f = field_at(w, index);
  return f != NULL ? f->scatter : NULL;
}

const scene_models* scene_live_models(const scene_live* w, uint32_t index) {
  const opened_field* f = field_at(w, index);
  return f != NULL ? f->pack->models : NULL;
}

uint32_t scene_live_pack_slot(const scene_live* w, uint32_t index) {
  const opened_field* f = field_at(w, index);
  return f != NULL ? (uint32_t)(f->pack - w->packs) : UINT32_MAX;
}

scene_files* scene_live_files(scene_live* w) {
  return w->files;
}

double scene_live_reach(const scene_live* w, uint32_t index) {
  const opened_field* f = field_at(w, index);
  if (f == NULL) return 0;
  const scene_field* model = &w->desc.scene->fields[index];
  const double size = model->is_cliff ? model->cliff.scale : model->is_scatter ? model->scatter.scale[1] : model->cell_size;
  double radius = 0;
  if (f->pack->models != NULL) {
    for (uint32_t i = 0; i < f->pack->models->count; ++i) radius = fmax(radius, (double)f->pack->models->shapes[i].outer_radius);
  } else {
    scree_pack_info info;
    scree_pack_get_info(f->pack->pack, &info);
    radius = 2 * (double)info.max_radius;
  }
  return radius * size;
}
