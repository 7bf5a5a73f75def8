#include "render_list.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct render_pick_item {
  uint32_t stone, lod;
} render_pick_item;

/* `array` is the address of a pointer of any type. */
static bool reserve(void* array, uint32_t* capacity, uint32_t needed, size_t element) {
  if (needed <= *capacity) return true;
  uint32_t wanted = *capacity < 256 ? 256 : *capacity;
  while (wanted < needed) wanted += wanted / 2;
  void* memory;
  memcpy(&memory, array, sizeof memory);
  void* bigger = realloc(memory, wanted * element);
  if (bigger == NULL) return false;
  memcpy(array, &bigger, sizeof bigger);
  *capacity = wanted;
  return true;
}

uint32_t render_choose_lod(const render_view* view, const render_asset* asset, uint32_t lod_count, float cell_size,
                           float distance) {
  if (view->lod >= 0) return (uint32_t)view->lod < lod_count ? (uint32_t)view->lod : lod_count - 1;
  float metres = view->pixel_error * view->pixel;
  if (!view->parallel) {
    float nearest = distance - asset->radius * cell_size;
    metres *= nearest > 0.1f * cell_size ? nearest : 0.1f * cell_size;
  }
  uint32_t lod = lod_count - 1;
  while (lod > 0 && asset->errors[lod] * cell_size > metres) --lod;
  return lod;
}

void render_stone_centre(const render_stone* stone, const render_asset* asset, float centre[3]) {
  const float size = stone->cell_size, sine = stone->turn[0], *c = asset->centre;
  const float cosine = sine == 0 && stone->turn[1] == 0 ? 1 : stone->turn[1];
  centre[0] = stone->position[0] + (cosine * c[0] + sine * c[2]) * size;
  centre[1] = stone->position[1] + c[1] * size;
  centre[2] = stone->position[2] + (cosine * c[2] - sine * c[0]) * size;
}

uint32_t render_pack_size(float metres) {
  float steps = (log2f(metres) + 32.0f) * 1024.0f;
  return steps <= 0 ? 0 : steps >= 65535 ? 65535 : (uint32_t)(steps + 0.5f);
}

/* How many times as coarse the pattern of a cliff's rock is as that of stones: the first asset is what stands at first, and its
 * grain would be a fine weave where that is a mountain. */
static float cliff_grain(const render_cached_source* slot) {
  const float coarser = slot->assets[0].radius / 20;
  return coarser > 1 ? coarser : 1;
}

bool render_list_choose(render_list* list, const render_view* view, render_cache* cache, const render_stone* stones, uint32_t count,
                        uint8_t* levels) {
  list->instance_count = 0; /* number of picks until the list is built */
  for (uint32_t i = 0; i < count; ++i) {
    const render_stone* stone = &stones[i];
    const render_cached_source* slot = &cache->sources[stone->source];
    const render_asset* asset = &slot->assets[stone->asset];
    const float size = stone->cell_size, radius = asset->radius * size;
    float centre[3];
    render_stone_centre(stone, asset, centre);
    bool out = false;
    for (uint32_t p = 0; p < view->plane_count && !out; ++p) {
      const float* plane = view->planes[p];
      out = plane[0] * centre[0] + plane[1] * centre[1] + plane[2] * centre[2] + plane[3] < -radius;
    }
    if (!view->parallel) levels[i] = RENDER_UNSEEN;
    if (out) continue;
    float distance = 0;
    if (!view->parallel) {
      const float d[3] = {centre[0] - view->eye[0], centre[1] - view->eye[1], centre[2] - view->eye[2]};
      distance = sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    }
    uint32_t lod = render_choose_lod(view, asset, slot->source.lod_count, size, distance), found;
    if (!view->parallel)
      levels[i] = (uint8_t)lod;
    else if (levels[i] != RENDER_UNSEEN)
      lod = levels[i];
    if (!reserve(&list->picks, &list->pick_capacity, list->instance_count + 1, sizeof *list->picks)) return false;
    list->picks[list->instance_count++] = (render_pick_item){i, lod};
    render_cache_find(cache, stone->source, stone->asset, lod, &found);
  }
  return true;
}

bool render_list_build(render_list* list, const render_view* view, render_cache* cache, const render_stone* stones,
                       uint32_t first_instance) {
  uint32_t first_row[RENDER_SOURCES + 1] = {0};
  for (uint32_t s = 0; s < RENDER_SOURCES; ++s) first_row[s + 1] = first_row[s] + cache->sources[s].meshes.mesh_count;
  const uint32_t rows = first_row[RENDER_SOURCES], picks = list->instance_count;
  if (!reserve(&list->counts, &list->count_capacity, rows + 1, sizeof *list->counts) ||
      !reserve(&list->instances, &list->instance_capacity, picks, sizeof *list->instances) ||
      !reserve(&list->commands, &list->command_capacity, picks < rows ? picks : rows, sizeof *list->commands))
    return false;

  /* A counting sort by mesh: count, add up, place. */
  memset(list->counts, 0, (rows + 1) * sizeof *list->counts);
  for (uint32_t i = 0; i < picks; ++i) {
    const render_stone* stone = &stones[list->picks[i].stone];
    uint32_t found, row = render_cache_find(cache, stone->source, stone->asset, list->picks[i].lod, &found);
    list->picks[i].lod = found;
    if (row != RENDER_NOTHING) ++list->counts[first_row[stone->source] + row];
  }
  list->command_count = list->span_count = 0;
  list->triangles = 0;
  uint32_t total = 0;
  for (uint32_t s = 0; s < RENDER_SOURCES; ++s) {
    render_span span = {s, list->command_count, 0};
    for (uint32_t row = first_row[s]; row < first_row[s + 1]; ++row) {
      uint32_t count = list->counts[row];
      list->counts[row] = total;
      if (count == 0) continue;
      const render_mesh* mesh = &cache->sources[s].meshes.meshes[row - first_row[s]];
      list->commands[list->command_count++] =
          (render_command){mesh->index_count, count, mesh->first_index, (int32_t)mesh->base_vertex, first_instance + total};
      ++span.command_count;
      list->triangles += (uint64_t)count * (mesh->index_count / 3);
      total += count;
    }
    if (span.command_count > 0) list->spans[list->span_count++] = span;
  }
  for (uint32_t i = 0; i < picks; ++i) {
    const uint32_t index = list->picks[i].stone, lod = list->picks[i].lod;
    const render_stone* stone = &stones[index];
    const render_cached_source* slot = &cache->sources[stone->source];
    uint32_t row = slot->rows[(size_t)stone->asset * slot->source.lod_count + lod];
    if (row >= RENDER_MESH_BROKEN) continue;
    render_instance* instance = &list->instances[list->counts[first_row[stone->source] + row]++];
    memcpy(instance->place, stone->position, sizeof stone->position);
    instance->place[3] = stone->cell_size / slot->source.lattice_per_cell;
    const bool is_stone = slot->source.look == RENDER_LOOK_STONE || slot->source.look == RENDER_LOOK_CLIFF;
    const float grain = slot->source.look == RENDER_LOOK_CLIFF ? cliff_grain(slot) : 1;
    const bool turned = stone->turn[0] != 0 || stone->turn[1] != 0;
    instance->turn[0] = stone->turn[0];
    instance->turn[1] = turned ? stone->turn[1] : 1;
    instance->tags[0] = stone->hash;
    instance->tags[1] = (is_stone ? view->tags : view->model_tags) | lod | render_pack_size(stone->cell_size * grain) << 16;
    instance->tags[2] = index + 1;
    instance->tags[3] =
        stone->colour[0] | (uint32_t)stone->colour[1] << 8 | (uint32_t)stone->colour[2] << 16 | (uint32_t)stone->tile << 24;
  }
  list->instance_count = total;
  return true;
}

void render_list_destroy(render_list* list) {
  free(list->instances);
  free(list->commands);
  free(list->picks);
  free(list->counts);
  memset(list, 0, sizeof *list);
}
