#include "pack_writer.h"

#include <stdlib.h>
#include <string.h>

#include "allocator.h"
#include "lattice.h"
#include "pack_format.h"
#include "plain_mesh.h"

/* A placement by where it lies: code, then its number in the set. */
typedef struct place {
  uint64_t code;
  uint32_t index;
} place;

/* Sizes and places of all sections. */
typedef struct pack_layout {
  pack_section sections[PACK_SECTION_KINDS];
  uint32_t* blob_offsets; /* of every level, in units; levels with the same bytes share a blob */
  bool narrow_contacts, narrow_hulls;
  scree_pack_kind kind;
  uint32_t kinds; /* of sections */
  place* places;  /* of a cliff: its placements in the order of the file */
  uint64_t file_size;
  uint32_t max_rocks_per_cell;
  float max_radius;
} pack_layout;

static uint64_t round_up(uint64_t value, uint64_t unit) {
  return (value + unit - 1) / unit * unit;
}

static scree_result place_sections(const uint64_t elements[PACK_SECTION_KINDS], pack_layout* layout) {
  uint64_t end = sizeof(pack_header) + layout->kinds * sizeof(pack_section);
  for (uint32_t i = 0; i < layout->kinds; ++i) {
    pack_section* section = &layout->sections[i];
    section->kind = i + 1;
    const bool narrow = section->kind == PACK_CONTACTS ? layout->narrow_contacts : layout->narrow_hulls;
    section->element_size = scree_rt_pack_element_size(section->kind, narrow);
    section->offset = round_up(end, PACK_ALIGNMENT);
    section->size = elements[i] * section->element_size;
    end = section->offset + section->size;
  }
  layout->file_size = end;
  return end <= SIZE_MAX ? SCREE_OK : SCREE_ERROR_RANGE;
}

static scree_result check_cells(const rock_set* set, pack_layout* layout) {
  if (set->models == NULL && (set->cells_per_cube < 1 || set->cells_per_cube > PACK_MAX_CELLS_PER_CUBE)) return SCREE_ERROR_RANGE;
  if (set->models != NULL && (set->cells_per_cube != 0 || set->proxies != NULL)) return SCREE_ERROR_INVALID_ARGUMENT;
  if (set->lattice_per_cell < 1 || set->lattice_per_cell > PACK_MAX_LATTICE_PER_CELL) return SCREE_ERROR_RANGE;
  if (set->proxy_per_cell > PACK_MAX_LATTICE_PER_CELL) return SCREE_ERROR_RANGE;
  if ((set->proxies != NULL) != (set->proxy_per_cell > 0)) return SCREE_ERROR_INVALID_ARGUMENT;
  if (set->lod_count < 1 || set->lod_count > ROCK_MAX_LODS) return SCREE_ERROR_RANGE;
  if (set->rock_count < 1 || set->cell_count < 1) return SCREE_ERROR_INVALID_ARGUMENT;
  if (set->models == NULL && set->cell_count != scree_rt_lattice_cell_count(set->cells_per_cube))
    return SCREE_ERROR_INVALID_ARGUMENT;
  if (set->cell_first[0] != 0 || set->cell_first[set->cell_count] != set->rock_count) return SCREE_ERROR_INVALID_ARGUMENT;
  for (uint32_t cell = 0; cell < set->cell_count; ++cell) {
    if (set->cell_first[cell] > set->cell_first[cell + 1]) return SCREE_ERROR_INVALID_ARGUMENT;
    const uint32_t rocks = set->cell_first[cell + 1] - set->cell_first[cell];
    /* Seeds rise, but not by one: a seed whose rock came out empty leaves a gap, because contacts of other rocks name seeds. */
    uint32_t next = 0;
    for (uint32_t k = 0; k < rocks; ++k) {
      const rock_record* rock = &set->rocks[set->cell_first[cell] + k];
      if (rock->cell != cell || rock->seed < next) return SCREE_ERROR_INVALID_ARGUMENT;
      if (rock->seed >= PACK_MAX_ROCKS_PER_CELL) return SCREE_ERROR_RANGE;
      next = rock->seed + 1;
    }
    if (set->models != NULL && (rocks < 1 || next != rocks)) return SCREE_ERROR_INVALID_ARGUMENT; /* ages have no gaps */
    if (next > layout->max_rocks_per_cell) layout->max_rocks_per_cell = next;
  }
  return SCREE_OK;
}

static bool fits_byte(const int16_t p[3]) {
  bool fits = true;
  for (int axis = 0; axis < 3; ++axis) fits &= p[axis] >= INT8_MIN && p[axis] <= INT8_MAX;
  return fits;
}

static scree_result count_parts(const rock_record* rock, const model_record* model, pack_layout* layout, uint64_t* parts,
                                uint64_t* hull_vertices) {
  if (rock->contact_count > 0 || rock->burial != SCREE_BURIAL_NEVER) return SCREE_ERROR_INVALID_ARGUMENT;
  if (rock->outer_radius > PACK_MAX_MODEL_REACH) return SCREE_ERROR_RANGE;
  if (model->part_count < 1 || model->part_count > PACK_MAX_PARTS) return SCREE_ERROR_RANGE;
  if (!(model->footprint >= 0 && model->footprint <= PACK_MAX_MODEL_REACH)) return SCREE_ERROR_INVALID_ARGUMENT;
  if (!(model->height >= 0 && model->height <= PACK_MAX_MODEL_REACH)) return SCREE_ERROR_INVALID_ARGUMENT;
  if (!(model->share >= 0 && model->share <= 1) || model->part_first[0] != 0) return SCREE_ERROR_INVALID_ARGUMENT;
  for (uint32_t p = 0; p < model->part_count; ++p) {
    const uint32_t first = model->part_first[p], end = model->part_first[p + 1];
    if (end < first || end - first < PACK_MIN_HULL || end - first > PACK_MAX_HULL) return SCREE_ERROR_INVALID_ARGUMENT;
    for (uint32_t k = first; k < end; ++k) layout->narrow_hulls &= fits_byte(model->parts[k]);
  }
  *parts += model->part_count;
  *hull_vertices += model->part_first[model->part_count];
  return SCREE_OK;
}

/* elements: of contacts, hulls with those of parts, parts. */
static scree_result count_records(const rock_set* set, pack_layout* layout, uint64_t* contacts, uint64_t* hull_vertices,
                                  uint64_t* parts) {
  layout->narrow_contacts = layout->narrow_hulls = true;
  for (uint32_t i = 0; i < set->rock_count; ++i) {
    const rock_record* rock = &set->rocks[i];
    if (rock->hull_count < PACK_MIN_HULL || rock->hull_count > PACK_MAX_HULL) return SCREE_ERROR_INVALID_ARGUMENT;
    if (rock->contact_count > UINT8_MAX || rock->burial < 1 || rock->burial > PACK_MAX_BURIAL) return SCREE_ERROR_RANGE;
    if (!(rock->outer_radius > 0)) return SCREE_ERROR_INVALID_ARGUMENT;
    if (rock->outer_radius > layout->max_radius) layout->max_radius = rock->outer_radius;
    for (uint32_t k = 0; k < rock->contact_count; ++k) {
      layout->narrow_contacts &= fits_byte(rock->contacts[k].position);
      if (rock->contacts[k].seed >= layout->max_rocks_per_cell) layout->max_rocks_per_cell = rock->contacts[k].seed + 1u;
    }
    for (uint32_t k = 0; k < rock->hull_count; ++k) layout->narrow_hulls &= fits_byte(rock->hull[k]);
    *contacts += rock->contact_count;
    *hull_vertices += rock->hull_count;
    if (set->models == NULL) continue;
    const scree_result result = count_parts(rock, &set->models[i], layout, parts, hull_vertices);
    if (result != SCREE_OK) return result;
  }
  return *contacts <= UINT32_MAX && *hull_vertices <= UINT32_MAX && *parts < UINT32_MAX ? SCREE_OK : SCREE_ERROR_RANGE;
}

/* Levels of all rocks and then of all proxies. */
static size_t level_count(const rock_set* set) {
  return ((size_t)set->rock_count + (set->proxies != NULL ? PACK_PROXIES : 0)) * set->lod_count;
}

static const rock_lod* level_at(const rock_set* set, size_t index) {
  const size_t asset = index / set->lod_count, lod = index % set->lod_count;
  return asset < set->rock_count ? &set->rocks[asset].lods[lod] : &set->proxies[asset - set->rock_count].lods[lod];
}

/* Gives every blob its place. Rocks whose tiles differ only far away come out the same: one in fifty at n = 6.
 * slots: a power of two above the number of levels, each a level or UINT32_MAX. */
static scree_result place_blobs(const rock_set* set, uint32_t* slots, size_t slot_count, uint32_t* offsets, uint64_t* bytes) {
  memset(slots, 0xff, slot_count * sizeof *slots);
  for (size_t i = 0; i < level_count(set); ++i) {
    const rock_lod* level = level_at(set, i);
    if (level->triangle_count < 1) return SCREE_ERROR_INVALID_ARGUMENT;
    if (set->models != NULL && level->vertex_count > PACK_MAX_MODEL_VERTICES) return SCREE_ERROR_RANGE;
    if (level->triangle_count > (uint64_t)level->blob_size * PACK_MAX_TRIANGLES_PER_BLOB_BYTE) return SCREE_ERROR_RANGE;

    size_t slot = (size_t)hash_mix(level->digest + level->blob_size) & (slot_count - 1);
    for (; slots[slot] != UINT32_MAX; slot = (slot + 1) & (slot_count - 1)) {
      const rock_lod* other = level_at(set, slots[slot]);
      if (other->blob_size == level->blob_size && memcmp(other->blob, level->blob, level->blob_size) == 0) break;
    }
    if (slots[slot] != UINT32_MAX) {
      offsets[i] = offsets[slots[slot]];
      continue;
    }
    *bytes = round_up(*bytes, PACK_BLOB_UNIT);
    if (*bytes / PACK_BLOB_UNIT > UINT32_MAX) return SCREE_ERROR_RANGE;
    slots[slot] = (uint32_t)i;
    offsets[i] = (uint32_t)(*bytes / PACK_BLOB_UNIT);
    *bytes += level->blob_size;
  }
  return SCREE_OK;
}

/* --- cliffs ----------------------------------------------------------------------------------------------------------------- */

static uint32_t placement_count(const rock_set* set) {
  return set->cliff != NULL ? set->cliff->placement_first[set->cliff->time_count] : 0;
}

static bool placement_is_sound(const rock_set* set, const scree_block_placement* at) {
  bool sound = at->asset >= set->cliff->time_count && at->asset < set->rock_count;
  for (int axis = 0; axis < 3; ++axis) sound &= within(at->translation[axis], PACK_MAX_MODEL_REACH);
  return sound;
}

/* The blob of the coarsest level says whether meshes have UVs. */
static bool coarsest_is_a_cliffs(const rock_set* set, const rock_record* rock) {
  const rock_lod* level = &rock->lods[set->lod_count - 1];
  plain_mesh mesh;
  return scree_rt_plain_mesh_read(level->blob, level->blob_size, level->vertex_count, level->triangle_count, SCREE_PACK_CLIFF,
                                  &mesh);
}

static scree_result check_cliff(const rock_set* set) {
  const cliff_record* cliff = set->cliff;
  if (set->models == NULL || cliff->time_count != set->cell_first[1] || cliff->placement_first[0] != 0)
    return SCREE_ERROR_INVALID_ARGUMENT;
  for (uint32_t block = 1; block < set->cell_count; ++block)
    if (set->cell_first[block + 1] - set->cell_first[block] != 1) return SCREE_ERROR_INVALID_ARGUMENT;
  for (int axis = 0; axis < 2; ++axis) {
    const float min = cliff->uvs.min[axis], max = cliff->uvs.max[axis];
    if (!within(min, PACK_MAX_UV) || !within(max, PACK_MAX_UV) || min > max) return SCREE_ERROR_RANGE;
  }
  for (uint32_t t = 0; t < cliff->time_count; ++t)
    if (cliff->placement_first[t] > cliff->placement_first[t + 1]) return SCREE_ERROR_INVALID_ARGUMENT;
  for (uint32_t i = 0; i < placement_count(set); ++i)
    if (!placement_is_sound(set, &cliff->placements[i])) return SCREE_ERROR_INVALID_ARGUMENT;
  for (uint32_t i = 0; i < set->rock_count; ++i)
    if (!coarsest_is_a_cliffs(set, &set->rocks[i])) return SCREE_ERROR_INVALID_ARGUMENT;
  return SCREE_OK;
}

static int compare_places(const void* a, const void* b) {
  const place *x = a, *y = b;
  return x->code != y->code ? (x->code > y->code) - (x->code < y->code) : (x->index > y->index) - (x->index < y->index);
}

static scree_result sort_placements(const rock_set* set, const scree_allocator* allocator, pack_layout* layout) {
  const uint32_t count = placement_count(set);
  if (count == 0) return SCREE_OK;
  layout->places = scree_rt_allocate(allocator, count, sizeof *layout->places);
  if (layout->places == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  for (uint32_t i = 0; i < count; ++i)
    layout->places[i] = (place){scree_rt_pack_place_code(set->cliff->placements[i].translation), i};
  for (uint32_t t = 0; t < set->cliff->time_count; ++t) {
    const uint32_t first = set->cliff->placement_first[t], end = set->cliff->placement_first[t + 1];
    if (end > first) qsort(layout->places + first, end - first, sizeof *layout->places, compare_places);
  }
  return SCREE_OK;
}

/* Widens bounds until they hold the ball of a block, and a little more than rounding takes away. */
static void hold_block(const rock_record* rock, const scree_block_placement* at, bool first, pack_time* time) {
  for (int axis = 0; axis < 3; ++axis) {
    const double middle = (double)at->translation[axis] + (double)rock->centroid[axis];
    double low = middle - (double)rock->outer_radius, high = middle + (double)rock->outer_radius;
    low = low < (double)at->translation[axis] ? low : (double)at->translation[axis];
    high = high > (double)at->translation[axis] ? high : (double)at->translation[axis];
    low -= 1e-6 * (1 + (low < 0 ? -low : low));
    high += 1e-6 * (1 + (high < 0 ? -high : high));
    if (first || low < (double)time->bounds_min[axis]) time->bounds_min[axis] = (float)low;
    if (first || high > (double)time->bounds_max[axis]) time->bounds_max[axis] = (float)high;
  }
}

static void write_cliff(const rock_set* set, const pack_layout* layout, uint8_t* bytes) {
  pack_placement* placements = (pack_placement*)(void*)(bytes + layout->sections[PACK_PLACEMENTS - 1].offset);
  pack_time* times = (pack_time*)(void*)(bytes + layout->sections[PACK_TIMES - 1].offset);
  pack_uvs* uvs = (pack_uvs*)(void*)(bytes + layout->sections[PACK_UVS - 1].offset);
  memcpy(uvs->min, set->cliff->uvs.min, sizeof uvs->min);
  memcpy(uvs->max, set->cliff->uvs.max, sizeof uvs->max);
  for (uint32_t t = 0; t < set->cliff->time_count; ++t) {
    const uint32_t first = set->cliff->placement_first[t], end = set->cliff->placement_first[t + 1];
    times[t].first_placement = first;
    times[t].placement_count = end - first;
    for (uint32_t i = first; i < end; ++i) {
      const scree_block_placement* from = &set->cliff->placements[layout->places[i].index];
      placements[i].asset = from->asset;
      memcpy(placements[i].translation, from->translation, sizeof from->translation);
      hold_block(&set->rocks[from->asset], from, i == first, &times[t]);
    }
  }
}

/* --- all of it -------------------------------------------------------------------------------------------------------------- */

static scree_result measure(const rock_set* set, const scree_allocator* allocator, pack_layout* layout) {
  uint64_t contacts = 0, hull_vertices = 0, parts = 0, blob_bytes = 0;
  layout->kind = set->cliff != NULL ? SCREE_PACK_CLIFF : set->models != NULL ? SCREE_PACK_MODELS : SCREE_PACK_TILES;
  layout->kinds = scree_rt_pack_kinds(&(pack_header){.kind = (uint8_t)layout->kind});
  scree_result result = check_cells(set, layout);
  if (result == SCREE_OK) result = count_records(set, layout, &contacts, &hull_vertices, &parts);
  if (result == SCREE_OK && set->cliff != NULL) result = check_cliff(set);
  if (result != SCREE_OK) return result;

  const uint64_t n = set->cells_per_cube, levels = level_count(set);
  if (levels >= UINT32_MAX / 4) return SCREE_ERROR_RANGE;
  size_t slot_count = 16;
  while (slot_count < 2 * levels) slot_count *= 2;
  uint32_t* slots = scree_rt_allocate(allocator, slot_count, sizeof *slots);
  layout->blob_offsets = scree_rt_allocate(allocator, (size_t)levels, sizeof *layout->blob_offsets);
  result = slots != NULL && layout->blob_offsets != NULL ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
  if (result == SCREE_OK) result = place_blobs(set, slots, slot_count, layout->blob_offsets, &blob_bytes);
  scree_rt_release(allocator, slots, slot_count, sizeof *slots);
  if (result == SCREE_OK && set->cliff != NULL) result = sort_placements(set, allocator, layout);
  if (result != SCREE_OK) return result;
  const uint64_t elements[PACK_SECTION_KINDS] = {
      strlen(set->recipe) + 1,
      256 * n * n * n,
      set->cell_count + UINT64_C(1),
      set->rock_count,
      levels,
      contacts,
      hull_vertices,
      levels,
      blob_bytes,
      parts + 1,
      set->rock_count,
      placement_count(set),
      set->cliff != NULL ? set->cliff->time_count : 0,
      1,
  };
  return place_sections(elements, layout);
}

static void write_tiles(const rock_set* set, uint32_t* tiles) {
  const uint32_t n = set->cells_per_cube;
  for (uint32_t code = 0; code < 256; ++code)
    for (uint32_t z = 0; z < n; ++z)
      for (uint32_t y = 0; y < n; ++y)
        for (uint32_t x = 0; x < n; ++x) *tiles++ = scree_rt_lattice_cell(n, code, x, y, z);
}

/* Where the next element of each section with elements of varying number goes. */
typedef struct cursors {
  uint32_t contact;
  uint32_t hull;
} cursors;

static void write_asset(const rock_record* rock, const cursors* at, pack_asset* out) {
  *out = (pack_asset){
      .cell = rock->cell,
      .first_contact = at->contact,
      .first_hull = at->hull,
      .contact_count = (uint8_t)rock->contact_count,
      .burial = (uint8_t)rock->burial,
      .hull_count = (uint8_t)rock->hull_count,
      .seed = (uint8_t)rock->seed,
      .volume = rock->volume,
      .inner_radius = rock->inner_radius,
      .outer_radius = rock->outer_radius,
  };
  memcpy(out->bounds_min, rock->bounds_min, sizeof out->bounds_min);
  memcpy(out->bounds_max, rock->bounds_max, sizeof out->bounds_max);
  memcpy(out->centroid, rock->centroid, sizeof out->centroid);
}

static void write_contact(const scree_contact* contact, bool narrow, uint8_t* section, size_t index) {
  const uint8_t neighbour = (uint8_t)(contact->cell[0] + 1 + 3 * (contact->cell[1] + 1) + 9 * (contact->cell[2] + 1));
  const int16_t* p = contact->position;
  if (narrow)
    ((pack_narrow_contact*)(void*)section)[index] =
        (pack_narrow_contact){{(int8_t)p[0], (int8_t)p[1], (int8_t)p[2]}, neighbour, contact->seed};
  else
    ((pack_contact*)(void*)section)[index] = (pack_contact){{p[0], p[1], p[2]}, neighbour, contact->seed};
}

static void write_hull_vertex(const int16_t p[3], bool narrow, uint8_t* section, size_t index) {
  for (size_t axis = 0; axis < 3; ++axis) {
    if (narrow)
      ((int8_t*)section)[3 * index + axis] = (int8_t)p[axis];
    else
      ((int16_t*)(void*)section)[3 * index + axis] = p[axis];
  }
}

static void write_rocks(const rock_set* set, const pack_layout* layout, uint8_t* bytes) {
  pack_asset* assets = (pack_asset*)(void*)(bytes + layout->sections[PACK_ASSETS - 1].offset);
  uint8_t* contacts = bytes + layout->sections[PACK_CONTACTS - 1].offset;
  uint8_t* hulls = bytes + layout->sections[PACK_HULLS - 1].offset;
  cursors at = {0, 0};
  for (uint32_t i = 0; i < set->rock_count; ++i) {
    const rock_record* rock = &set->rocks[i];
    write_asset(rock, &at, &assets[i]);
    for (uint32_t k = 0; k < rock->contact_count; ++k)
      write_contact(&rock->contacts[k], layout->narrow_contacts, contacts, at.contact++);
    for (uint32_t k = 0; k < rock->hull_count; ++k) write_hull_vertex(rock->hull[k], layout->narrow_hulls, hulls, at.hull++);
  }
}

/* Behind the hulls of all assets. */
static void write_models(const rock_set* set, const pack_layout* layout, uint8_t* bytes) {
  uint32_t* ends = (uint32_t*)(void*)(bytes + layout->sections[PACK_PARTS - 1].offset);
  pack_model* models = (pack_model*)(void*)(bytes + layout->sections[PACK_MODELS - 1].offset);
  uint8_t* hulls = bytes + layout->sections[PACK_HULLS - 1].offset;
  uint32_t part = 0, vertex = 0;
  for (uint32_t i = 0; i < set->rock_count; ++i) vertex += set->rocks[i].hull_count;
  for (uint32_t i = 0; i < set->rock_count; ++i) {
    const model_record* from = &set->models[i];
    models[i] = (pack_model){.footprint = from->footprint,
                             .height = from->height,
                             .share = from->share,
                             .steps = from->steps,
                             .first_part = part,
                             .part_count = from->part_count};
    for (uint32_t p = 0; p < from->part_count; ++p) {
      ends[part++] = vertex;
      for (uint32_t k = from->part_first[p]; k < from->part_first[p + 1]; ++k)
        write_hull_vertex(from->parts[k], layout->narrow_hulls, hulls, vertex++);
    }
  }
  ends[part] = vertex;
}

static void write_levels(const rock_set* set, const pack_layout* layout, uint8_t* bytes) {
  pack_lod* lods = (pack_lod*)(void*)(bytes + layout->sections[PACK_LODS - 1].offset);
  pack_blob* index = (pack_blob*)(void*)(bytes + layout->sections[PACK_BLOB_INDEX - 1].offset);
  uint8_t* blobs = bytes + layout->sections[PACK_BLOBS - 1].offset;
  for (size_t i = 0; i < level_count(set); ++i) {
    const rock_lod* level = level_at(set, i);
    lods[i] = (pack_lod){.digest = level->digest, .triangles = level->triangle_count, .error = level->error};
    index[i] = (pack_blob){.offset = layout->blob_offsets[i], .size = level->blob_size, .vertices = level->vertex_count};
    memcpy(blobs + (size_t)index[i].offset * PACK_BLOB_UNIT, level->blob, level->blob_size);
  }
}

static void seal(const rock_set* set, pack_layout* layout, uint8_t* bytes) {
  const pack_section* sections[PACK_SECTION_KINDS] = {NULL};
  const size_t table_size = layout->kinds * sizeof(pack_section);
  for (uint32_t i = 0; i < layout->kinds; ++i) {
    pack_section* section = &layout->sections[i];
    section->digest = scree_rt_pack_bytes_digest(bytes + section->offset, (size_t)section->size);
    sections[i] = section;
  }
  memcpy(bytes + sizeof(pack_header), layout->sections, table_size);
  pack_header header = {
      .format_version = PACK_FORMAT_VERSION,
      .section_count = layout->kinds,
      .file_size = layout->file_size,
      .table_digest = scree_rt_pack_bytes_digest(layout->sections, table_size),
      .cells_per_cube = (uint8_t)set->cells_per_cube,
      .kind = (uint8_t)layout->kind,
      .lattice_per_cell = (uint16_t)set->lattice_per_cell,
      .proxy_per_cell = (uint16_t)set->proxy_per_cell,
      .lod_count = set->lod_count,
      .max_rocks_per_cell = layout->max_rocks_per_cell,
      .max_radius = layout->max_radius,
  };
  memcpy(header.magic, PACK_MAGIC, PACK_MAGIC_SIZE);
  header.pack_digest = scree_rt_pack_digest(&header, sections);
  header.header_check = scree_rt_pack_header_check(&header);
  memcpy(bytes, &header, sizeof header);
}

static scree_result write(const rock_set* set, const scree_allocator* allocator, pack_layout* layout, uint8_t** bytes) {
  scree_result result = measure(set, allocator, layout);
  if (result != SCREE_OK) return result;
  /* Zeroed, so that the padding is. */
  uint8_t* pack = scree_rt_allocate_zeroed(allocator, (size_t)layout->file_size, 1);
  if (pack == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  memcpy(pack + layout->sections[PACK_RECIPE - 1].offset, set->recipe, (size_t)layout->sections[PACK_RECIPE - 1].size);
  write_tiles(set, (uint32_t*)(void*)(pack + layout->sections[PACK_TILES - 1].offset));
  memcpy(pack + layout->sections[PACK_CELLS - 1].offset, set->cell_first, (size_t)layout->sections[PACK_CELLS - 1].size);
  write_rocks(set, layout, pack);
  if (set->models != NULL) write_models(set, layout, pack);
  if (set->cliff != NULL) write_cliff(set, layout, pack);
  write_levels(set, layout, pack);
  seal(set, layout, pack);
  *bytes = pack;
  return SCREE_OK;
}

scree_result pack_write(const rock_set* set, const scree_allocator* given, uint8_t** bytes, size_t* size) {
  const scree_allocator allocator = scree_rt_allocator_or_default(given);
  *bytes = NULL;
  pack_layout layout = {0};
  const scree_result result = write(set, &allocator, &layout, bytes);
  if (set->cliff != NULL) scree_rt_release(&allocator, layout.places, placement_count(set), sizeof *layout.places);
  scree_rt_release(&allocator, layout.blob_offsets, level_count(set), sizeof *layout.blob_offsets);
  *size = result == SCREE_OK ? (size_t)layout.file_size : 0;
  return result;
}

uint64_t pack_bytes_digest(const uint8_t* bytes) {
  pack_header header;
  memcpy(&header, bytes, sizeof header);
  return header.pack_digest;
}
