/* Rocks of a box, their hulls, and lists of them. */
#include "scene_spatial.h"

#include "scene_scatter.h"

#include <math.h>
#include <string.h>

scree_result scree_rt_spatial_rocks(const spatial_question* q, uint32_t layer, const double low[3], const double high[3],
                                    const scree_rock** rocks, uint64_t* count) {
  const scene_layer* own = &q->scene->layers[layer];
  const double reach = own->given.scatter != NULL ? own->rock_radius : own->reach; /* from what the box is asked for */
  scree_scene_query_desc desc = {.scene = q->scene, .edits = q->edits, .layers = UINT64_C(1) << layer};
  for (int a = 0; a < 3; ++a) {
    const double slack = reach * 4e-6 + (fabs(low[a]) + fabs(high[a])) * 1e-14;
    desc.origin[a] = q->origin[a];
    desc.min[a] = low[a] - reach - slack;
    desc.max[a] = high[a] + reach + slack;
  }
  for (;;) {
    const uint64_t room = scratch_room(q->scratch, SCRATCH_SPATIAL_0, sizeof **rocks);
    scree_rock* to = q->scratch->buffers[SCRATCH_SPATIAL_0].memory;
    const scree_result result = scree_rt_scene_fill(&desc, true, q->scratch, to, room, count);
    *rocks = to;
    if (result != SCREE_ERROR_CAPACITY) return result;
    /* Also what fill says of a box with more rocks than it may look at: then it has no count. */
    if (*count <= room) return result;
    if (scree_rt_scratch_reserve(q->scratch, SCRATCH_SPATIAL_0, (size_t)*count, sizeof **rocks) == NULL)
      return SCREE_ERROR_OUT_OF_MEMORY;
  }
}

spatial_place scree_rt_spatial_place(const scene_layer* layer, const scree_rock* rock, const double from[3]) {
  const scree_field* field = layer->given.field;
  const field_asset* asset = &field->assets[rock->asset];
  spatial_place place;
  int64_t cell[3];
  rock_cell(field, &rock->id, cell);
  double size = 0;
  for (int a = 0; a < 3; ++a) {
    place.home[a] = (field->origin[a] - from[a]) + field->cell_size * (double)cell[a];
    place.centroid[a] = place.home[a] + (double)asset->centroid[a] * field->cell_size;
    size += fabs(place.home[a]);
  }
  place.radius = (double)asset->outer_radius * field->cell_size * (1 + 1e-6) + size * 1e-14;
  return place;
}

bool scree_rt_spatial_hull(const scene_layer* layer, uint32_t asset, const double at[3], spatial_hull* out) {
  const scree_field* field = layer->given.field;
  out->hull = (convex_hull){.x = out->x, .y = out->y, .z = out->z};
  out->hull.count = scree_rt_field_hull(field, asset, out->x, out->y, out->z);
  out->hull.scale = field->cell_size / field->lattice_per_cell;
  memcpy(out->hull.at, at, sizeof out->hull.at);
  return out->hull.count > 0;
}

uint32_t scree_rt_spatial_parts(const scene_layer* layer, const scree_rock* rock) {
  return layer->given.scatter != NULL ? scatter_parts(layer, rock->asset) : 1;
}

spatial_place scree_rt_spatial_part(const scene_layer* layer, const scree_rock* rock, uint32_t part, const double from[3]) {
  if (layer->given.scatter == NULL) return scree_rt_spatial_place(layer, rock, from);
  spatial_place place = {0};
  const double radius = scree_rt_scene_scatter_ball(layer, &rock->id, rock->asset, part, from, place.home, place.centroid);
  place.radius = radius * (1 + 1e-6) + (fabs(place.home[0]) + fabs(place.home[1]) + fabs(place.home[2])) * 1e-14;
  return place;
}

bool scree_rt_spatial_part_hull(const scene_layer* layer, const scree_rock* rock, uint32_t part, const double at[3],
                                spatial_hull* out) {
  if (layer->given.scatter == NULL) return scree_rt_spatial_hull(layer, rock->asset, at, out);
  out->hull = scree_rt_scene_scatter_hull(layer, &rock->id, rock->asset, part, out->x, out->y, out->z);
  memcpy(out->hull.at, at, sizeof out->hull.at);
  return true;
}

void scree_rt_spatial_unpack(const scene_layer* layer, scree_rock* rock) {
  if (layer->given.scatter != NULL) rock->asset = scatter_model_of(rock->asset);
}

bool scree_rt_spatial_add(const spatial_question* q, uint32_t layer, spatial_list* list, const scree_rock* rock) {
  if (list->rocks == NULL || list->count == scratch_room(q->scratch, SCRATCH_SPATIAL_1, sizeof *rock)) {
    const size_t wanted = (size_t)list->count + list->count / 2 + 64;
    list->rocks = scree_rt_scratch_extend(q->scratch, SCRATCH_SPATIAL_1, (size_t)list->count, wanted, sizeof *rock);
    if (list->rocks == NULL) return false;
  }
  list->rocks[list->count] = *rock;
  scree_rt_spatial_unpack(&q->scene->layers[layer], &list->rocks[list->count++]);
  return true;
}

/* --- order ------------------------------------------------------------------------------------------------------------------ */

static bool before(const scree_rock* a, const scree_rock* b) {
  return scree_rt_edits_compare(&a->id, &b->id) < 0;
}

static void sift_down(scree_rock* rocks, uint64_t at, uint64_t count) {
  const scree_rock rock = rocks[at];
  for (uint64_t child; (child = 2 * at + 1) < count; at = child) {
    if (child + 1 < count && before(&rocks[child], &rocks[child + 1])) ++child;
    if (!before(&rock, &rocks[child])) break;
    rocks[at] = rocks[child];
  }
  rocks[at] = rock;
}

/* Heapsort (Williams 1964): in place, and never slower than n log n. */
static void sort(scree_rock* rocks, uint64_t count) {
  for (uint64_t i = count / 2; i-- > 0;) sift_down(rocks, i, count);
  for (uint64_t end = count; end-- > 1;) {
    const scree_rock last = rocks[end];
    rocks[end] = rocks[0];
    rocks[0] = last;
    sift_down(rocks, 0, end);
  }
}

scree_result scree_rt_spatial_deliver(spatial_list* list, scree_rock* rocks, uint64_t capacity, uint64_t* count) {
  sort(list->rocks, list->count);
  uint64_t kept = 0;
  for (uint64_t i = 0; i < list->count; ++i)
    if (kept == 0 || before(&list->rocks[kept - 1], &list->rocks[i])) list->rocks[kept++] = list->rocks[i];
  *count = kept;
  const uint64_t written = kept < capacity ? kept : capacity;
  if (written > 0) memcpy(rocks, list->rocks, written * sizeof *rocks);
  return kept > capacity ? SCREE_ERROR_CAPACITY : SCREE_OK;
}

/* --- hulls ------------------------------------------------------------------------------------------------------------------ */

scree_result scree_scene_hull(const scree_scene* scene, uint32_t layer, uint32_t asset, float* xyz, uint32_t capacity,
                              uint32_t* count) {
  if (count != NULL) *count = 0;
  if (scene == NULL || count == NULL || layer >= scene->layer_count || asset >= scene->layers[layer].given.field->asset_count ||
      (xyz == NULL && capacity > 0))
    return SCREE_ERROR_INVALID_ARGUMENT;
  const scree_scatter* scatter = scene->layers[layer].given.scatter;
  if (scatter != NULL) return scree_scatter_part(scatter, asset, 0, xyz, capacity, count);
  spatial_hull hull;
  scree_rt_spatial_hull(&scene->layers[layer], asset, (const double[3]){0, 0, 0}, &hull);
  *count = hull.hull.count;
  const uint32_t copied = *count < capacity ? *count : capacity;
  for (uint32_t i = 0; i < copied; ++i) {
    xyz[3 * i] = (float)((double)hull.x[i] * hull.hull.scale);
    xyz[3 * i + 1] = (float)((double)hull.y[i] * hull.hull.scale);
    xyz[3 * i + 2] = (float)((double)hull.z[i] * hull.hull.scale);
  }
  return copied < *count ? SCREE_ERROR_CAPACITY : SCREE_OK;
}
