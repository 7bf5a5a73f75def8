/* libFuzzer target: any bytes as a pack. Opened as they are, and once more with their digests made right, so that the checks behind
 * the digests are reached too. Whatever opens is read through to the last mesh. */
#include <scree/draco.h>
#include <scree/field.h>

#include <stdlib.h>
#include <string.h>

#include "pack_format.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

enum { MOST_ASSETS = 40, MOST_VERTICES = 1 << 16 };

static void reseal(uint8_t* bytes, size_t size) {
  pack_header header;
  if (size < sizeof header) return;
  memcpy(&header, bytes, sizeof header);
  if (header.section_count <= (size - sizeof header) / sizeof(pack_section)) {
    const pack_section* table = (const pack_section*)(const void*)(bytes + sizeof header);
    /* A pack of this kind may lack some: what is to find that out comes before the digest. */
    const pack_section none = {0};
    const pack_section* sections[PACK_SECTION_KINDS];
    for (uint32_t kind = 0; kind < PACK_SECTION_KINDS; ++kind) sections[kind] = &none;
    for (uint32_t i = 0; i < header.section_count; ++i)
      if (table[i].kind >= 1 && table[i].kind <= PACK_SECTION_KINDS && sections[table[i].kind - 1] == &none)
        sections[table[i].kind - 1] = &table[i];
    header.table_digest = scree_rt_pack_bytes_digest(table, header.section_count * sizeof *table);
    header.pack_digest = scree_rt_pack_digest(&header, sections);
  }
  header.header_check = scree_rt_pack_header_check(&header);
  memcpy(bytes, &header, sizeof header);
}

static void read_mesh(const scree_pack* pack, uint32_t asset, uint32_t lod) {
  scree_lod level;
  if (scree_pack_get_lod(pack, asset, lod, &level) != SCREE_OK) return;
  if (level.vertices > MOST_VERTICES || level.triangles > MOST_VERTICES) return;
  const size_t indices = (size_t)level.triangles * 3;
  scree_vertex* vertices = malloc(level.vertices * sizeof *vertices + 1);
  uint32_t* wide = malloc(indices * sizeof *wide + 1);
  uint16_t* narrow = malloc(indices * sizeof *narrow + 1);
  if (scree_draco_decode_u32(pack, asset, lod, vertices, level.vertices, wide, indices) == SCREE_OK)
    for (size_t i = 0; i < indices; ++i)
      if (wide[i] >= level.vertices) abort();
  scree_draco_decode_u16(pack, asset, lod, vertices, level.vertices, narrow, indices);
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  if (lod + 1 == info.lod_count && scree_pack_coarse_mesh(pack, asset, vertices, level.vertices, narrow, indices) == SCREE_OK)
    for (uint32_t i = 0; i < level.vertices; ++i)
      if (info.kind == SCREE_PACK_TILES && (vertices[i].material | vertices[i].durability | vertices[i].curvature) != 0) abort();
  scree_uv* uvs = malloc(level.vertices * sizeof *uvs + 1);
  uint8_t* groups = malloc((size_t)level.vertices + 1);
  scree_draco_decode_uvs(pack, asset, lod, uvs, groups, level.vertices);
  free(groups);
  free(uvs);
  free(narrow);
  free(wide);
  free(vertices);
}

static void read_cliff(const scree_pack* pack, const scree_pack_info* info) {
  for (uint32_t t = 0; t < info->time_count; ++t) {
    scree_cliff_time time;
    if (scree_pack_get_time(pack, t, &time) != SCREE_OK) continue;
    if ((uint64_t)time.first_placement + time.placement_count > info->placement_count) abort();
    for (uint32_t i = 0; i < time.placement_count; ++i) {
      scree_block_placement at;
      if (scree_pack_get_placements(pack, time.first_placement + i, 1, &at) != SCREE_OK) continue;
      if (at.asset < info->time_count || at.asset >= info->asset_count) abort();
    }
  }
}

static void read_field(const scree_pack* pack) {
  const scree_field_desc desc = {.pack = pack, .seed = 1, .cell_size = 1};
  scree_field* field;
  if (scree_field_create(&desc, NULL, &field) != SCREE_OK) return;
  const scree_shape ball = {.kind = SCREE_SHAPE_SPHERE, .sphere = {.radius = 3}};
  scree_support* support;
  if (scree_support_create(&(scree_support_desc){.shapes = &ball, .shape_count = 1}, NULL, &support, NULL) != SCREE_OK) abort();
  const scree_query_desc query = {.field = field, .support = support};
  static scree_instance rocks[4096];
  uint64_t count = 0, filled = 0;
  if (scree_query_count(&query, &count) == SCREE_OK) {
    scree_query_fill(&query, rocks, NULL, sizeof rocks / sizeof *rocks, &filled);
    if (count != filled) abort();
  }
  scree_support_destroy(support);
  scree_field_destroy(field);
}

static void read_through(const void* bytes, size_t size) {
  scree_pack* pack;
  if (scree_pack_open_memory(bytes, size, NULL, &pack) != SCREE_OK) return;
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  if (info.recipe[info.recipe_size] != '\0') abort();
  scree_pack_verify(pack);
  for (uint32_t a = 0; a < info.asset_count && a < MOST_ASSETS; ++a) {
    scree_asset asset;
    scree_contact contacts[8];
    int16_t hull[3 * PACK_MAX_HULL];
    uint32_t count;
    scree_pack_get_asset(pack, a, &asset);
    scree_pack_get_contacts(pack, a, contacts, 8, &count);
    scree_pack_get_hull(pack, a, hull, PACK_MAX_HULL, &count);
    scree_model model;
    if (scree_pack_get_model(pack, a, &model) == SCREE_OK) {
      for (uint32_t part = 0; part < model.part_count; ++part) scree_pack_get_part(pack, a, part, hull, PACK_MAX_HULL, &count);
      if (scree_pack_model(pack, model.variant, model.age) == info.asset_count) abort();
    }
    for (uint32_t lod = 0; lod < info.lod_count; ++lod) read_mesh(pack, a, lod);
  }
  for (uint32_t part = 0; part < 9 && info.proxy_count > 0; ++part)
    for (uint32_t lod = 0; lod < info.lod_count; ++lod) read_mesh(pack, scree_pack_proxy(pack, 255, part), lod);
  uint32_t cell, first, count;
  for (uint32_t code = 0; code < 256; code += 17)
    if (scree_pack_tile_cell(pack, code, 0, info.cells_per_cube - 1, 0, &cell) == SCREE_OK) {
      if (cell >= info.cell_count) abort();
      if (scree_pack_cell_assets(pack, cell, &first, &count) == SCREE_OK && (uint64_t)first + count > info.asset_count) abort();
    }
  read_cliff(pack, &info);
  read_field(pack);
  scree_pack_close(pack);
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  uint8_t* bytes = malloc(size > 0 ? size : 1); /* exactly as long, so that a read past the end is seen */
  memcpy(bytes, data, size);
  read_through(bytes, size);
  reseal(bytes, size);
  read_through(bytes, size);
  free(bytes);
  return 0;
}
