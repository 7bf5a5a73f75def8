/* Scenes: their layers, checked and copied, and what can be told without looking for rocks. */
#include <math.h>
#include <string.h>

#include "allocator.h"
#include "scene_layers.h"
#include "scene_scatter.h"
#include "support_text.h"

static scree_result wrong(scree_result code, uint32_t layer, const char* what, scree_error* error) {
  scree_rt_text_add(error, "layer ");
  scree_rt_text_add_count(error, layer);
  scree_rt_text_add(error, ": ");
  scree_rt_text_add(error, what);
  return code;
}

static scree_result wrong_number(uint32_t layer, const char* name, double value, const char* range, scree_error* error) {
  wrong(SCREE_ERROR_RANGE, layer, name, error);
  scree_rt_text_add(error, " is ");
  scree_rt_text_add_number(error, value);
  scree_rt_text_add(error, ", it has to be ");
  scree_rt_text_add(error, range);
  return SCREE_ERROR_RANGE;
}

static bool keys_are_given(const scree_scene_desc* desc) {
  for (uint32_t i = 0; i < desc->layer_count; ++i)
    if (desc->layers[i].key != 0) return true;
  return false;
}

static scree_result check_layer(const scree_scene_desc* desc, uint32_t index, size_t* values, scree_error* error) {
  const scree_layer* layer = &desc->layers[index];
  if (layer->field == NULL && layer->scatter == NULL)
    return wrong(SCREE_ERROR_INVALID_ARGUMENT, index, "field is NULL, and so is scatter", error);
  if (layer->field != NULL && layer->scatter != NULL)
    return wrong(SCREE_ERROR_INVALID_ARGUMENT, index, "it has a field and a scatter", error);
  const bool is_cliff = layer->scatter != NULL && layer->scatter->is_cliff;
  if (is_cliff && layer->support != NULL && layer->support != layer->scatter->ground)
    return wrong(SCREE_ERROR_INVALID_ARGUMENT, index, "a cliff has no support", error);
  if (!is_cliff && layer->support == NULL) return wrong(SCREE_ERROR_INVALID_ARGUMENT, index, "support is NULL", error);
  if (!(layer->threshold >= 0 && layer->threshold < 1))
    return wrong_number(index, "threshold", (double)layer->threshold, "0 or more and less than 1", error);
  if (!(layer->shell_depth >= 0 && isfinite(layer->shell_depth)))
    return wrong_number(index, "shell_depth", (double)layer->shell_depth, "0 or more", error);
  if (layer->scatter != NULL && (layer->threshold != 0 || layer->shell_depth != 0))
    return wrong(SCREE_ERROR_INVALID_ARGUMENT, index, "a scatter has no threshold and no shell_depth", error);
  if (layer->scatter != NULL && !is_cliff && !scree_rt_scene_ground_ends(layer->support))
    return wrong(SCREE_ERROR_RANGE, index, "the ground of a scatter has to end somewhere above", error);
  if (!(layer->density >= 0 && layer->density <= 1)) return wrong_number(index, "density", (double)layer->density, "0..1", error);
  for (uint32_t k = 0; k < index && keys_are_given(desc); ++k)
    if (desc->layers[k].key == layer->key) {
      wrong(SCREE_ERROR_INVALID_ARGUMENT, index, "key ", error);
      scree_rt_text_add_count(error, layer->key);
      scree_rt_text_add(error, " is also that of layer ");
      scree_rt_text_add_count(error, k);
      return SCREE_ERROR_INVALID_ARGUMENT;
    }
  return scree_rt_scene_check_filters(layer, index, values, error);
}

/* Copies the filters of a layer and what they point at. Returns false when memory is short. */
static bool copy_filters(const scree_scene* scene, scene_layer* layer) {
  const scree_filter* given = layer->given.filters;
  uint32_t count = layer->given.filter_count;
  layer->given.filters = NULL;
  if (count == 0) return true;
  layer->filters = scree_rt_allocate(&scene->allocator, count, sizeof *layer->filters);
  if (layer->values > 0) layer->samples = scree_rt_allocate(&scene->allocator, layer->values, sizeof *layer->samples);
  if (layer->filters == NULL || (layer->values > 0 && layer->samples == NULL)) return false;
  memcpy(layer->filters, given, count * sizeof *layer->filters);
  layer->given.filters = layer->filters;
  float* to = layer->samples;
  for (uint32_t i = 0; i < count; ++i) {
    scree_filter* filter = &layer->filters[i];
    if (filter->kind == SCREE_FILTER_ALTITUDE) {
      filter->values = NULL;
      continue;
    }
    size_t size = (size_t)filter->width * filter->depth;
    memcpy(to, filter->values, size * sizeof *to);
    filter->values = to;
    to += size;
  }
  return true;
}

void scree_rt_scene_measure(scene_layer* layer, const double base[3]) {
  const scree_field* field = layer->given.field;
  const scree_support* support = layer->given.support;
  for (int a = 0; a < 3; ++a) layer->offset[a] = field->origin[a] - base[a];
  layer->rock_radius = (double)field->max_radius * field->cell_size;
  layer->reach = (double)field->centroid_reach + layer->rock_radius;
  double slope = 1 - 2 * (layer->given.threshold > 0 ? (double)layer->given.threshold : 0.5);
  double a = slope * (double)field->mean_radius_min, b = slope * (double)field->mean_radius_max;
  layer->level_low = a < b ? a : b;
  layer->level_high = a < b ? b : a;
  layer->lipschitz = scree_rt_support_lipschitz(support);
  layer->doubt = 0;
  for (uint32_t i = 0; i < support->op_count; ++i)
    if ((double)support->ops[i].doubt > layer->doubt) layer->doubt = (double)support->ops[i].doubt;
  layer->density = layer->given.density > 0 ? (double)layer->given.density : 1;
  layer->filtered = layer->density < 1 || layer->given.filter_count > 0;
  if (layer->given.scatter != NULL) scree_rt_scene_measure_scatter(layer);
}

static bool make_layer(scree_scene* scene, const scree_scene_desc* desc, uint32_t index) {
  scene_layer* layer = &scene->layers[index];
  layer->given = desc->layers[index];
  if (!keys_are_given(desc)) layer->given.key = (uint16_t)index;
  if (layer->given.scatter != NULL && layer->given.scatter->is_cliff) layer->given.support = layer->given.scatter->ground;
  layer->told = layer->given;
  if (layer->given.scatter != NULL) layer->given.field = &layer->given.scatter->lattice;
  scree_rt_scene_measure(layer, scene->base);
  const bool copied = copy_filters(scene, layer);
  layer->told.filters = layer->given.filters;
  return copied;
}

scree_result scree_scene_create(const scree_scene_desc* desc, const scree_allocator* given, scree_scene** out, scree_error* error) {
  scree_rt_text_clear(error);
  if (out != NULL) *out = NULL;
  if (desc == NULL || out == NULL || desc->layers == NULL) {
    scree_rt_text_add(error, desc == NULL ? "desc is NULL" : out == NULL ? "out is NULL" : "layers is NULL");
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  if (desc->layer_count < 1 || desc->layer_count > SCENE_MAX_LAYERS) {
    scree_rt_text_add(error, "layer_count is ");
    scree_rt_text_add_count(error, desc->layer_count);
    scree_rt_text_add(error, ", it has to be 1..64");
    return SCREE_ERROR_RANGE;
  }
  size_t values[SCENE_MAX_LAYERS] = {0};
  for (uint32_t i = 0; i < desc->layer_count; ++i) {
    scree_result result = check_layer(desc, i, &values[i], error);
    if (result != SCREE_OK) return result;
  }

  scree_allocator allocator = scree_rt_allocator_or_default(given);
  scree_scene* scene = scree_rt_allocate_zeroed(&allocator, 1, sizeof *scene);
  bool good = scene != NULL;
  if (good) {
    scene->allocator = allocator;
    scene->layer_count = desc->layer_count;
    const scree_layer* first = &desc->layers[0];
    memcpy(scene->base, first->scatter != NULL ? first->scatter->origin : first->field->origin, sizeof scene->base);
    scene->layers = scree_rt_allocate_zeroed(&allocator, desc->layer_count, sizeof *scene->layers);
    good = scene->layers != NULL;
  }
  for (uint32_t i = 0; i < desc->layer_count && good; ++i) {
    scene->layers[i].values = values[i];
    good = make_layer(scene, desc, i);
  }
  if (!good) {
    scree_scene_destroy(scene);
    scree_rt_text_add(error, "out of memory");
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  *out = scene;
  return SCREE_OK;
}

void scree_scene_destroy(scree_scene* scene) {
  if (scene == NULL) return;
  scree_allocator allocator = scene->allocator;
  for (uint32_t i = 0; scene->layers != NULL && i < scene->layer_count; ++i) {
    scene_layer* layer = &scene->layers[i];
    scree_rt_release(&allocator, layer->filters, layer->given.filter_count, sizeof *layer->filters);
    scree_rt_release(&allocator, layer->samples, layer->values, sizeof *layer->samples);
  }
  scree_rt_release(&allocator, scene->layers, scene->layer_count, sizeof *scene->layers);
  scree_rt_release(&allocator, scene, 1, sizeof *scene);
}

void scree_scene_bounds(const scree_scene* scene, double min[3], double max[3]) {
  bool some = false;
  scree_support_bounds(scene->layers[0].given.support, min, max); /* of no size, somewhere, where all are empty */
  for (uint32_t i = 0; i < scene->layer_count; ++i) {
    const scree_support* support = scene->layers[i].given.support;
    if (!(support->min[0] <= support->max[0] && support->min[1] <= support->max[1] && support->min[2] <= support->max[2])) continue;
    double low[3], high[3];
    scree_support_bounds(support, low, high);
    for (int a = 0; a < 3; ++a) {
      if (!some || low[a] < min[a]) min[a] = low[a];
      if (!some || high[a] > max[a]) max[a] = high[a];
    }
    some = true;
  }
}

uint32_t scree_scene_layer_count(const scree_scene* scene) {
  return scene->layer_count;
}

const scree_layer* scree_scene_layer(const scree_scene* scene, uint32_t index) {
  return index < scene->layer_count ? &scene->layers[index].told : NULL;
}

const scree_layer* scree_rt_scene_layer(const scree_scene* scene, uint32_t index) {
  return &scene->layers[index].given;
}

uint32_t scree_scene_layer_of(const scree_scene* scene, uint16_t key) {
  for (uint32_t i = 0; i < scene->layer_count; ++i)
    if (scene->layers[i].given.key == key) return i;
  return UINT32_MAX;
}

uint32_t scree_scene_random(const scree_scene* scene, const scree_id* id) {
  uint32_t layer = scree_scene_layer_of(scene, id->layer);
  if (layer == UINT32_MAX) return 0;
  const scree_layer* given = &scene->layers[layer].given;
  return given->scatter != NULL ? scree_scatter_random(given->scatter, id) : scree_world_hash(given->field, id);
}
