/* From a pack to a field: reads the tables through the pack's own checked calls. */
#include <string.h>

#include "allocator.h"
#include "field_tables.h"

typedef struct pack_tables {
  uint32_t* tile_cells;
  uint32_t* cell_first;
  field_rock* rocks;
} pack_tables;

static scree_result read_cells(const scree_pack* pack, const scree_pack_info* info, pack_tables* tables) {
  uint32_t next = 0;
  for (uint32_t cell = 0; cell < info->cell_count; ++cell) {
    uint32_t first = 0, count = 0;
    scree_result result = scree_pack_cell_assets(pack, cell, &first, &count);
    if (result != SCREE_OK) return result;
    if (first != next || count > info->asset_count - next) return SCREE_ERROR_CORRUPT; /* every rock has one cell, in order */
    tables->cell_first[cell] = first;
    next = first + count;
  }
  if (next != info->asset_count) return SCREE_ERROR_CORRUPT;
  tables->cell_first[info->cell_count] = next;
  return SCREE_OK;
}

static scree_result read_rocks(const scree_pack* pack, const scree_pack_info* info, pack_tables* tables) {
  for (uint32_t i = 0; i < info->asset_count; ++i) {
    scree_asset asset;
    scree_result result = scree_pack_get_asset(pack, i, &asset);
    if (result != SCREE_OK) return result;
    if (asset.cell >= info->cell_count || i < tables->cell_first[asset.cell] || i >= tables->cell_first[asset.cell + 1])
      return SCREE_ERROR_CORRUPT;
    field_rock* rock = &tables->rocks[i];
    memcpy(rock->centroid, asset.centroid, sizeof rock->centroid);
    rock->inner_radius = asset.inner_radius;
    rock->outer_radius = asset.outer_radius;
    rock->seed = asset.seed;
    rock->burial = asset.burial;
    uint32_t hull = 0;
    result = scree_pack_get_hull(pack, i, NULL, 0, &hull);
    if (result != SCREE_OK && result != SCREE_ERROR_CAPACITY) return result;
    if (hull > FIELD_MAX_HULL) return SCREE_ERROR_CORRUPT;
  }
  return SCREE_OK;
}

static scree_result read_tiles(const scree_pack* pack, const scree_pack_info* info, pack_tables* tables) {
  uint32_t n = info->cells_per_cube;
  uint32_t* cell = tables->tile_cells;
  for (uint32_t code = 0; code < 256; ++code)
    for (uint32_t z = 0; z < n; ++z)
      for (uint32_t y = 0; y < n; ++y)
        for (uint32_t x = 0; x < n; ++x) {
          scree_result result = scree_pack_tile_cell(pack, code, x, y, z, cell++);
          if (result != SCREE_OK) return result;
        }
  return SCREE_OK;
}

scree_result scree_field_create(const scree_field_desc* desc, const scree_allocator* given, scree_field** out) {
  if (out != NULL) *out = NULL;
  if (desc == NULL || out == NULL || desc->pack == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  scree_pack_info info;
  scree_pack_get_info(desc->pack, &info);
  if (info.kind != SCREE_PACK_TILES) return SCREE_ERROR_PACK_KIND;
  if (info.cells_per_cube < 3 || info.cells_per_cube > FIELD_MAX_CELLS || info.asset_count == UINT32_MAX ||
      info.cell_count == UINT32_MAX)
    return SCREE_ERROR_CORRUPT;

  scree_allocator allocator = scree_rt_allocator_or_default(given);
  size_t tile_count = (size_t)256 * info.cells_per_cube * info.cells_per_cube * info.cells_per_cube;
  pack_tables tables = {scree_rt_allocate(&allocator, tile_count, sizeof *tables.tile_cells),
                        scree_rt_allocate(&allocator, (size_t)info.cell_count + 1, sizeof *tables.cell_first),
                        scree_rt_allocate(&allocator, (size_t)info.asset_count + 1, sizeof *tables.rocks)};
  scree_result result = SCREE_ERROR_OUT_OF_MEMORY;
  if (tables.tile_cells != NULL && tables.cell_first != NULL && tables.rocks != NULL) {
    result = read_cells(desc->pack, &info, &tables);
    if (result == SCREE_OK) result = read_rocks(desc->pack, &info, &tables);
    if (result == SCREE_OK) result = read_tiles(desc->pack, &info, &tables);
    const field_source source = {.cells_per_cube = info.cells_per_cube,
                                 .cell_count = info.cell_count,
                                 .asset_count = info.asset_count,
                                 .max_rocks_per_cell = info.max_rocks_per_cell,
                                 .max_radius = info.max_radius,
                                 .tile_cells = tables.tile_cells,
                                 .cell_first = tables.cell_first,
                                 .rocks = tables.rocks,
                                 .pack = desc->pack,
                                 .lattice_per_cell = info.lattice_per_cell};
    if (result == SCREE_OK) result = scree_rt_field_create_from_source(desc, &source, given, out);
  }
  scree_rt_release(&allocator, tables.tile_cells, tile_count, sizeof *tables.tile_cells);
  scree_rt_release(&allocator, tables.cell_first, (size_t)info.cell_count + 1, sizeof *tables.cell_first);
  scree_rt_release(&allocator, tables.rocks, (size_t)info.asset_count + 1, sizeof *tables.rocks);
  return result;
}
