/* The pack reader. Opening costs the same for every pack; what is not checked there is checked where it is read. */
#include <math.h>
#include <string.h>

#include "allocator.h"
#include "pack_internal.h"
#include "plain_mesh.h"

/* Finds the section of every kind and checks that the sections lie one behind the other, padded to 64 bytes and not more, up to
 * the end of the file: then no two overlap and no byte belongs to none. */
static scree_result read_section_table(scree_pack* pack) {
  const pack_header* header = pack->header;
  if (header->kind > SCREE_PACK_CLIFF || header->reserved != 0) return SCREE_ERROR_CORRUPT;
  const uint32_t kinds = scree_rt_pack_kinds(header);
  if (header->section_count < kinds || header->section_count > PACK_MAX_SECTIONS) return SCREE_ERROR_CORRUPT;
  const size_t table_size = header->section_count * sizeof(pack_section);
  if (pack->size - sizeof(pack_header) < table_size) return SCREE_ERROR_TRUNCATED;
  const pack_section* table = (const pack_section*)(const void*)(pack->bytes + sizeof(pack_header));
  if (scree_rt_pack_bytes_digest(table, table_size) != header->table_digest) return SCREE_ERROR_DIGEST;

  uint64_t end = sizeof(pack_header) + table_size;
  for (uint32_t i = 0; i < header->section_count; ++i) {
    const pack_section* section = &table[i];
    const uint64_t begin = (end + PACK_ALIGNMENT - 1) / PACK_ALIGNMENT * PACK_ALIGNMENT;
    if (section->offset != begin || begin > pack->size || section->size > pack->size - begin) return SCREE_ERROR_CORRUPT;
    if (section->element_size == 0 || section->size % section->element_size != 0) return SCREE_ERROR_CORRUPT;
    end = begin + section->size;
    if (section->kind == 0 || section->kind > PACK_SECTION_KINDS) continue;
    if (section->kind > kinds) return SCREE_ERROR_CORRUPT;
    if (section->element_size != scree_rt_pack_element_size(section->kind, false) &&
        section->element_size != scree_rt_pack_element_size(section->kind, true))
      return SCREE_ERROR_CORRUPT;
    if (pack->sections[section->kind - 1] != NULL) return SCREE_ERROR_CORRUPT;
    pack->sections[section->kind - 1] = section;
  }
  if (end != pack->size) return SCREE_ERROR_CORRUPT;
  for (uint32_t kind = 0; kind < kinds; ++kind)
    if (pack->sections[kind] == NULL) return SCREE_ERROR_CORRUPT;
  if (scree_rt_pack_digest(header, pack->sections) != header->pack_digest) return SCREE_ERROR_DIGEST;
  return SCREE_OK;
}

/* Sets the typed views and checks that the lengths of all arrays agree. */
static scree_result read_views(scree_pack* pack) {
  const pack_header* header = pack->header;
  const uint32_t n = header->cells_per_cube;
  const bool models = header->kind != SCREE_PACK_TILES;
  pack->kind = (scree_pack_kind)header->kind;
  if (models ? n != 0 || header->proxy_per_cell != 0 : n < 1 || n > PACK_MAX_CELLS_PER_CUBE) return SCREE_ERROR_CORRUPT;
  pack->reach = models ? PACK_MAX_MODEL_REACH : PACK_MAX_TILE_REACH;
  if (header->lattice_per_cell < 1 || header->lattice_per_cell > PACK_MAX_LATTICE_PER_CELL) return SCREE_ERROR_CORRUPT;
  if (header->proxy_per_cell > PACK_MAX_LATTICE_PER_CELL) return SCREE_ERROR_CORRUPT;
  if (header->lod_count < 1 || header->lod_count > PACK_MAX_LODS) return SCREE_ERROR_CORRUPT;
  if (header->max_rocks_per_cell < 1 || header->max_rocks_per_cell > PACK_MAX_ROCKS_PER_CELL) return SCREE_ERROR_CORRUPT;
  if (!(header->max_radius > 0 && header->max_radius <= pack->reach)) return SCREE_ERROR_CORRUPT;

  pack->recipe = section_bytes(pack, PACK_RECIPE);
  pack->tiles = section_bytes(pack, PACK_TILES);
  pack->cells = section_bytes(pack, PACK_CELLS);
  pack->assets = section_bytes(pack, PACK_ASSETS);
  pack->lods = section_bytes(pack, PACK_LODS);
  pack->contacts = section_bytes(pack, PACK_CONTACTS);
  pack->hulls = section_bytes(pack, PACK_HULLS);
  pack->blob_index = section_bytes(pack, PACK_BLOB_INDEX);
  pack->blobs = section_bytes(pack, PACK_BLOBS);
  pack->narrow_contacts = pack->sections[PACK_CONTACTS - 1]->element_size == sizeof(pack_narrow_contact);
  pack->narrow_hulls = pack->sections[PACK_HULLS - 1]->element_size == 3 * sizeof(int8_t);
  pack->contact_count = section_elements(pack, PACK_CONTACTS);
  pack->hull_count = section_elements(pack, PACK_HULLS);
  pack->blob_bytes = section_elements(pack, PACK_BLOBS);

  const uint64_t recipe_size = section_elements(pack, PACK_RECIPE);
  if (recipe_size < 1 || pack->recipe[recipe_size - 1] != '\0') return SCREE_ERROR_CORRUPT;
  if (section_elements(pack, PACK_TILES) != UINT64_C(256) * n * n * n) return SCREE_ERROR_CORRUPT;
  const uint64_t cells = section_elements(pack, PACK_CELLS), assets = section_elements(pack, PACK_ASSETS);
  if (cells < 2 || cells - 1 > UINT32_MAX || assets < 1 || assets > UINT32_MAX) return SCREE_ERROR_CORRUPT;
  pack->cell_count = (uint32_t)(cells - 1);
  pack->asset_count = (uint32_t)assets;
  if (pack->cells[0] != 0 || pack->cells[pack->cell_count] != pack->asset_count) return SCREE_ERROR_CORRUPT;
  pack->proxy_count = header->proxy_per_cell > 0 ? PACK_PROXIES : 0;
  if (assets + pack->proxy_count > UINT32_MAX) return SCREE_ERROR_CORRUPT;
  if (models) {
    if (section_elements(pack, PACK_CONTACTS) != 0 || section_elements(pack, PACK_MODELS) != assets) return SCREE_ERROR_CORRUPT;
    if (section_elements(pack, PACK_PARTS) < 1) return SCREE_ERROR_CORRUPT;
    pack->parts = section_bytes(pack, PACK_PARTS);
    pack->models = section_bytes(pack, PACK_MODELS);
    pack->part_count = section_elements(pack, PACK_PARTS) - 1;
  }
  if (pack->kind == SCREE_PACK_CLIFF) {
    const scree_result result = scree_rt_pack_read_cliff(pack);
    if (result != SCREE_OK) return result;
  }
  const uint64_t levels = (assets + pack->proxy_count) * header->lod_count;
  if (section_elements(pack, PACK_LODS) != levels || section_elements(pack, PACK_BLOB_INDEX) != levels) return SCREE_ERROR_CORRUPT;
  return SCREE_OK;
}

static scree_result open_bytes(scree_pack* pack) {
  const size_t seen = pack->size < PACK_MAGIC_SIZE ? pack->size : PACK_MAGIC_SIZE;
  if (seen > 0 && memcmp(pack->bytes, PACK_MAGIC, seen) != 0) return SCREE_ERROR_NOT_A_PACK;
  if (pack->size < sizeof(pack_header)) return SCREE_ERROR_TRUNCATED;
  memcpy(&pack->first_bytes, pack->bytes, sizeof pack->first_bytes);
  const pack_header* header = pack->header = &pack->first_bytes;
  if (header->format_version != PACK_FORMAT_VERSION) return SCREE_ERROR_VERSION;
  if (header->header_check != scree_rt_pack_header_check(header)) return SCREE_ERROR_DIGEST;
  if (header->file_size > pack->size) return SCREE_ERROR_TRUNCATED;
  if (header->file_size < pack->size) return SCREE_ERROR_CORRUPT;
  scree_result result = read_section_table(pack);
  return result == SCREE_OK ? read_views(pack) : result;
}

static scree_result open_with(const void* bytes, size_t size, mapped_file file, const scree_allocator* given, scree_pack** out) {
  scree_allocator allocator = scree_rt_allocator_or_default(given);
  scree_pack* pack = scree_rt_allocate_zeroed(&allocator, 1, sizeof *pack);
  if (pack == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  pack->allocator = allocator;
  pack->bytes = bytes;
  pack->size = size;
  scree_result result = open_bytes(pack);
  if (result != SCREE_OK) {
    scree_rt_release(&allocator, pack, 1, sizeof *pack);
    return result;
  }
  pack->file = file;
  *out = pack;
  return SCREE_OK;
}

scree_result scree_pack_open_memory(const void* bytes, size_t size, const scree_allocator* allocator, scree_pack** out) {
  if (out == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  *out = NULL;
  if ((bytes == NULL && size > 0) || (uintptr_t)bytes % 8 != 0) return SCREE_ERROR_INVALID_ARGUMENT;
  return open_with(bytes, size, (mapped_file){NULL, 0}, allocator, out);
}

scree_result scree_pack_open_file(const char* path, const scree_allocator* allocator, scree_pack** out) {
  if (out == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  *out = NULL;
  if (path == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  mapped_file file;
  if (!scree_rt_map_file(path, &file)) return SCREE_ERROR_IO;
  scree_result result = open_with(file.bytes, file.size, file, allocator, out);
  if (result != SCREE_OK) scree_rt_unmap_file(&file);
  return result;
}

void scree_pack_close(scree_pack* pack) {
  if (pack == NULL) return;
  scree_rt_unmap_file(&pack->file);
  scree_allocator allocator = pack->allocator;
  scree_rt_release(&allocator, pack, 1, sizeof *pack);
}

void scree_pack_get_info(const scree_pack* pack, scree_pack_info* out) {
  *out = (scree_pack_info){
      .format_version = pack->header->format_version,
      .kind = pack->kind,
      .cells_per_cube = pack->header->cells_per_cube,
      .lattice_per_cell = pack->header->lattice_per_cell,
      .cell_count = pack->cell_count,
      .variant_count = pack->models != NULL ? pack->cell_count : 0,
      .time_count = pack->time_count,
      .placement_count = pack->placement_count,
      .asset_count = pack->asset_count,
      .lod_count = pack->header->lod_count,
      .proxy_count = pack->proxy_count,
      .proxy_per_cell = pack->header->proxy_per_cell,
      .max_rocks_per_cell = pack->header->max_rocks_per_cell,
      .max_radius = pack->header->max_radius,
      .digest = pack->header->pack_digest,
      .recipe = pack->recipe,
      .recipe_size = (size_t)section_elements(pack, PACK_RECIPE) - 1,
      .file_size = pack->size,
  };
  if (pack->uvs == NULL) return;
  memcpy(out->uv_min, pack->uvs->min, sizeof out->uv_min);
  memcpy(out->uv_max, pack->uvs->max, sizeof out->uv_max);
}

scree_result scree_pack_get_section(const scree_pack* pack, uint32_t index, scree_pack_section* out) {
  static const char* const names[SCREE_PACK_SECTIONS] = {"recipe",   "tiles",      "cells",      "assets", "lods",
                                                         "contacts", "hulls",      "blob_index", "blobs",  "parts",
                                                         "models",   "placements", "times",      "uvs"};
  if (pack == NULL || out == NULL || index >= scree_rt_pack_kinds(pack->header)) return SCREE_ERROR_INVALID_ARGUMENT;
  const pack_section* section = pack->sections[index];
  *out = (scree_pack_section){names[index], section->size, section->size / section->element_size, section->digest};
  return SCREE_OK;
}

/* A range of an array that holds `available` elements. */
static bool range_fits(uint64_t first, uint64_t count, uint64_t available) {
  return first <= available && count <= available - first;
}

scree_result scree_pack_get_asset(const scree_pack* pack, uint32_t asset, scree_asset* out) {
  if (pack == NULL || out == NULL || asset >= pack->asset_count) return SCREE_ERROR_INVALID_ARGUMENT;
  const pack_asset* record = &pack->assets[asset];
  if (record->cell >= pack->cell_count || record->seed >= pack->header->max_rocks_per_cell) return SCREE_ERROR_CORRUPT;
  if (!range_fits(record->first_contact, record->contact_count, pack->contact_count)) return SCREE_ERROR_CORRUPT;
  if (record->burial < 1 || record->burial > PACK_MAX_BURIAL) return SCREE_ERROR_CORRUPT;
  if (pack->models != NULL && record->burial != PACK_MAX_BURIAL) return SCREE_ERROR_CORRUPT;
  if (record->hull_count < PACK_MIN_HULL || record->hull_count > PACK_MAX_HULL) return SCREE_ERROR_CORRUPT;
  if (!range_fits(record->first_hull, record->hull_count, pack->hull_count)) return SCREE_ERROR_CORRUPT;
  const float reach = pack->header->max_radius;
  if (!(record->volume >= 0 && record->volume <= 8 * reach * reach * reach)) return SCREE_ERROR_CORRUPT;
  if (!(record->outer_radius > 0 && record->outer_radius <= reach)) return SCREE_ERROR_CORRUPT;
  if (!(record->inner_radius >= 0 && record->inner_radius <= record->outer_radius)) return SCREE_ERROR_CORRUPT;

  const float steps = (float)pack->header->lattice_per_cell;
  *out = (scree_asset){
      .cell = record->cell,
      .seed = record->seed,
      .volume = record->volume,
      .inner_radius = record->inner_radius,
      .outer_radius = record->outer_radius,
      .contact_count = record->contact_count,
      .hull_vertices = record->hull_count,
      .burial = record->burial,
  };
  for (int axis = 0; axis < 3; ++axis) {
    if (record->bounds_min[axis] > record->bounds_max[axis] || !within(record->centroid[axis], pack->reach))
      return SCREE_ERROR_CORRUPT;
    out->bounds_min[axis] = (float)record->bounds_min[axis] / steps;
    out->bounds_max[axis] = (float)record->bounds_max[axis] / steps;
    out->centroid[axis] = record->centroid[axis];
  }
  return SCREE_OK;
}

scree_result scree_pack_get_lod(const scree_pack* pack, uint32_t asset, uint32_t lod, scree_lod* out) {
  if (pack == NULL || out == NULL || lod >= pack->header->lod_count || asset >= pack->asset_count + pack->proxy_count)
    return SCREE_ERROR_INVALID_ARGUMENT;
  const size_t index = (size_t)asset * pack->header->lod_count + lod;
  const pack_lod* record = &pack->lods[index];
  const pack_blob* blob = &pack->blob_index[index];
  const uint64_t offset = (uint64_t)blob->offset * PACK_BLOB_UNIT;
  if (!range_fits(offset, blob->size, pack->blob_bytes)) return SCREE_ERROR_CORRUPT;
  if (record->triangles < 1 || record->triangles > (uint64_t)blob->size * PACK_MAX_TRIANGLES_PER_BLOB_BYTE)
    return SCREE_ERROR_CORRUPT;
  if (blob->vertices > (uint64_t)record->triangles * 3) return SCREE_ERROR_CORRUPT;
  if (pack->models != NULL && blob->vertices > PACK_MAX_MODEL_VERTICES) return SCREE_ERROR_CORRUPT;
  if (!(record->error >= 0 && record->error <= pack->reach)) return SCREE_ERROR_CORRUPT;
  *out = (scree_lod){
      .vertices = blob->vertices,
      .triangles = record->triangles,
      .error = record->error,
      .digest = record->digest,
      .blob = pack->blobs + offset,
      .blob_size = blob->size,
  };
  return SCREE_OK;
}

scree_result scree_rt_pack_coarse_mesh(const scree_pack* pack, uint32_t asset, scree_vertex* vertices, size_t vertex_capacity,
                                       void* indices, uint32_t index_size, size_t index_capacity) {
  if (pack == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  scree_lod level;
  const scree_result result = scree_pack_get_lod(pack, asset, pack->header->lod_count - 1, &level);
  if (result != SCREE_OK) return result;
  if (vertex_capacity < level.vertices || index_capacity / 3 < level.triangles) return SCREE_ERROR_CAPACITY;
  if (vertices == NULL || indices == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  plain_mesh mesh;
  if (!scree_rt_plain_mesh_read(level.blob, level.blob_size, level.vertices, level.triangles, pack->kind, &mesh))
    return SCREE_ERROR_CORRUPT;
  scree_rt_plain_mesh_decode(&mesh, vertices, indices, index_size);
  return SCREE_OK;
}

scree_result scree_pack_coarse_mesh(const scree_pack* pack, uint32_t asset, scree_vertex* vertices, size_t vertex_capacity,
                                    uint16_t* indices, size_t index_capacity) {
  return scree_rt_pack_coarse_mesh(pack, asset, vertices, vertex_capacity, indices, sizeof *indices, index_capacity);
}

uint32_t scree_pack_proxy(const scree_pack* pack, uint32_t code, uint32_t part) {
  if (pack == NULL || pack->proxy_count == 0 || code >= 256 || part >= PACK_PROXY_PARTS) return UINT32_MAX;
  return pack->asset_count + code * PACK_PROXY_PARTS + part;
}

pack_contact scree_rt_pack_read_contact(const scree_pack* pack, uint64_t index) {
  if (!pack->narrow_contacts) return ((const pack_contact*)(const void*)pack->contacts)[index];
  const pack_narrow_contact* from = (const pack_narrow_contact*)(const void*)pack->contacts + index;
  return (pack_contact){{from->position[0], from->position[1], from->position[2]}, from->neighbour, from->seed};
}

scree_result scree_pack_get_contacts(const scree_pack* pack, uint32_t asset, scree_contact* contacts, uint32_t capacity,
                                     uint32_t* count) {
  if (pack == NULL || count == NULL || asset >= pack->asset_count || (contacts == NULL && capacity > 0))
    return SCREE_ERROR_INVALID_ARGUMENT;
  const pack_asset* record = &pack->assets[asset];
  *count = 0;
  if (!range_fits(record->first_contact, record->contact_count, pack->contact_count)) return SCREE_ERROR_CORRUPT;
  *count = record->contact_count;
  const uint32_t copied = *count < capacity ? *count : capacity;
  for (uint32_t i = 0; i < copied; ++i) {
    const pack_contact from = scree_rt_pack_read_contact(pack, record->first_contact + (uint64_t)i);
    if (from.neighbour >= PACK_NEIGHBOURS || from.seed >= pack->header->max_rocks_per_cell) return SCREE_ERROR_CORRUPT;
    contacts[i] = (scree_contact){
        .position = {from.position[0], from.position[1], from.position[2]},
        .cell = {(int8_t)(from.neighbour % 3 - 1), (int8_t)(from.neighbour / 3 % 3 - 1), (int8_t)(from.neighbour / 9 - 1)},
        .seed = from.seed,
    };
  }
  return copied < *count ? SCREE_ERROR_CAPACITY : SCREE_OK;
}

/* `count` hull vertices from `first` on, as many as fit. */
static scree_result copy_hull(const scree_pack* pack, uint32_t first, uint32_t count, int16_t* xyz, uint32_t capacity) {
  const uint32_t copied = count < capacity ? count : capacity;
  const size_t begin = 3 * (size_t)first;
  if (pack->narrow_hulls) {
    const int8_t* from = (const int8_t*)pack->hulls + begin;
    for (uint32_t i = 0; i < 3 * copied; ++i) xyz[i] = from[i];
  } else if (copied > 0) {
    memcpy(xyz, pack->hulls + begin * sizeof(int16_t), copied * 3 * sizeof(int16_t));
  }
  return copied < count ? SCREE_ERROR_CAPACITY : SCREE_OK;
}

scree_result scree_pack_get_hull(const scree_pack* pack, uint32_t asset, int16_t* xyz, uint32_t capacity, uint32_t* count) {
  if (pack == NULL || count == NULL || asset >= pack->asset_count || (xyz == NULL && capacity > 0))
    return SCREE_ERROR_INVALID_ARGUMENT;
  const pack_asset* record = &pack->assets[asset];
  *count = 0;
  if (!range_fits(record->first_hull, record->hull_count, pack->hull_count)) return SCREE_ERROR_CORRUPT;
  *count = record->hull_count;
  return copy_hull(pack, record->first_hull, *count, xyz, capacity);
}

scree_result scree_pack_tile_cell(const scree_pack* pack, uint32_t code, uint32_t x, uint32_t y, uint32_t z, uint32_t* cell) {
  if (pack == NULL || cell == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  const uint32_t n = pack->header->cells_per_cube;
  if (code >= 256 || x >= n || y >= n || z >= n) return SCREE_ERROR_INVALID_ARGUMENT;
  const uint32_t value = pack->tiles[((code * n + z) * n + y) * n + x];
  if (value >= pack->cell_count) return SCREE_ERROR_CORRUPT;
  *cell = value;
  return SCREE_OK;
}

scree_result scree_pack_cell_assets(const scree_pack* pack, uint32_t cell, uint32_t* first, uint32_t* count) {
  if (pack == NULL || first == NULL || count == NULL || cell >= pack->cell_count) return SCREE_ERROR_INVALID_ARGUMENT;
  const uint32_t begin = pack->cells[cell], end = pack->cells[cell + 1];
  if (begin > end || end > pack->asset_count || end - begin > pack->header->max_rocks_per_cell) return SCREE_ERROR_CORRUPT;
  /* Of a cliff the times come first, then one age of every block. */
  if (pack->times != NULL && (begin != (cell == 0 ? 0 : pack->time_count + cell - 1) || end != pack->time_count + cell))
    return SCREE_ERROR_CORRUPT;
  *first = begin;
  *count = end - begin;
  return SCREE_OK;
}

uint32_t scree_pack_model(const scree_pack* pack, uint32_t variant, uint32_t age) {
  uint32_t first, count;
  if (pack == NULL || pack->models == NULL || scree_pack_cell_assets(pack, variant, &first, &count) != SCREE_OK || age >= count)
    return UINT32_MAX;
  return first + age;
}

scree_result scree_pack_get_model(const scree_pack* pack, uint32_t asset, scree_model* out) {
  if (pack == NULL || out == NULL || pack->models == NULL || asset >= pack->asset_count) return SCREE_ERROR_INVALID_ARGUMENT;
  const pack_asset* record = &pack->assets[asset];
  const pack_model* model = &pack->models[asset];
  if (record->cell >= pack->cell_count || record->seed >= pack->header->max_rocks_per_cell) return SCREE_ERROR_CORRUPT;
  if (!(model->footprint >= 0 && model->footprint <= pack->reach)) return SCREE_ERROR_CORRUPT;
  if (!(model->height >= 0 && model->height <= pack->reach)) return SCREE_ERROR_CORRUPT;
  if (!(model->share >= 0 && model->share <= 1)) return SCREE_ERROR_CORRUPT;
  if (model->part_count < 1 || model->part_count > PACK_MAX_PARTS) return SCREE_ERROR_CORRUPT;
  if (!range_fits(model->first_part, model->part_count, pack->part_count)) return SCREE_ERROR_CORRUPT;
  *out = (scree_model){
      .variant = record->cell,
      .age = record->seed,
      .footprint = model->footprint,
      .height = model->height,
      .share = model->share,
      .steps = model->steps,
      .part_count = model->part_count,
  };
  return SCREE_OK;
}

scree_result scree_pack_get_part(const scree_pack* pack, uint32_t asset, uint32_t part, int16_t* xyz, uint32_t capacity,
                                 uint32_t* count) {
  if (count == NULL || (xyz == NULL && capacity > 0)) return SCREE_ERROR_INVALID_ARGUMENT;
  *count = 0;
  scree_model model;
  const scree_result result = scree_pack_get_model(pack, asset, &model);
  if (result != SCREE_OK) return result;
  if (part >= model.part_count) return SCREE_ERROR_INVALID_ARGUMENT;
  const uint32_t* ends = &pack->parts[pack->models[asset].first_part + (size_t)part];
  if (ends[0] > ends[1] || ends[1] > pack->hull_count) return SCREE_ERROR_CORRUPT;
  if (ends[1] - ends[0] < PACK_MIN_HULL || ends[1] - ends[0] > PACK_MAX_HULL) return SCREE_ERROR_CORRUPT;
  *count = ends[1] - ends[0];
  return copy_hull(pack, ends[0], *count, xyz, capacity);
}
