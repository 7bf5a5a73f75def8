/* Fields: the tables of a pack, rearranged for queries (field_tables.h), and the hashes of places. */
#include <math.h>
#include <string.h>

#include "allocator.h"
#include "field_tables.h"

static scree_result check_desc(const scree_field_desc* desc) {
  if (!(isfinite(desc->cell_size) && desc->cell_size >= 1e-6 && desc->cell_size <= 1e6)) return SCREE_ERROR_RANGE;
  for (int a = 0; a < 3; ++a)
    if (!isfinite(desc->origin[a])) return SCREE_ERROR_RANGE;
  return SCREE_OK;
}

static bool rock_is_sound(const field_rock* rock, float max_radius) {
  for (int a = 0; a < 3; ++a)
    if (!(fabsf(rock->centroid[a]) <= 2)) return false;
  return rock->inner_radius >= 0 && rock->inner_radius <= rock->outer_radius && rock->outer_radius <= max_radius;
}

static scree_result check_source(const field_source* s) {
  uint32_t n = s->cells_per_cube;
  if (n < 3 || n > FIELD_MAX_CELLS) return SCREE_ERROR_CORRUPT;
  if (s->max_rocks_per_cell < 1 || s->max_rocks_per_cell > FIELD_MAX_PER_CELL) return SCREE_ERROR_CORRUPT;
  if (!(s->max_radius > 0 && s->max_radius <= 8)) return SCREE_ERROR_CORRUPT;
  for (uint32_t i = 0; i < 256 * n * n * n; ++i)
    if (s->tile_cells[i] >= s->cell_count) return SCREE_ERROR_CORRUPT;
  for (uint32_t cell = 0; cell < s->cell_count; ++cell) {
    uint32_t first = s->cell_first[cell], end = s->cell_first[cell + 1];
    if (first > end || end > s->asset_count || end - first > s->max_rocks_per_cell) return SCREE_ERROR_CORRUPT;
    for (uint32_t i = first; i < end; ++i) {
      const field_rock* rock = &s->rocks[i];
      if (rock->seed >= s->max_rocks_per_cell || (i > first && rock->seed <= rock[-1].seed)) return SCREE_ERROR_CORRUPT;
      if (!rock_is_sound(rock, s->max_radius)) return SCREE_ERROR_CORRUPT;
    }
  }
  return SCREE_OK;
}

static uint32_t tile_cell(const field_source* s, uint32_t code, uint32_t x, uint32_t y, uint32_t z) {
  uint32_t n = s->cells_per_cube;
  return s->tile_cells[((code * n + z) * n + y) * n + x];
}

/* Counts the slots of every tile and lays out their arrays. */
static void place_tiles(scree_field* field, const field_source* s) {
  uint32_t octets = 0;
  for (uint32_t code = 0; code < 256; ++code) {
    field_tile* tile = &field->tiles[code];
    uint32_t count = 0;
    for (uint32_t b = 0; b < FIELD_BLOCKS; ++b) {
      tile->block_first[b] = (uint16_t)count;
      for (uint32_t z = block_low(field, b, 2); z < block_high(field, b, 2); ++z)
        for (uint32_t y = block_low(field, b, 1); y < block_high(field, b, 1); ++y)
          for (uint32_t x = block_low(field, b, 0); x < block_high(field, b, 0); ++x) {
            uint32_t cell = tile_cell(s, code, x, y, z);
            count += s->cell_first[cell + 1] - s->cell_first[cell];
          }
    }
    tile->block_first[FIELD_BLOCKS] = (uint16_t)count;
    tile->padded = (count + 2 * (FIELD_OCTET - 1)) / FIELD_OCTET * FIELD_OCTET;
    if (tile->padded == 0) tile->padded = FIELD_OCTET;
    tile->rocks = octets;
    octets += tile->padded / FIELD_OCTET;
    field->uniform_count = code == 0 || field->uniform_count == count ? count : 0;
  }
  field->rock_bytes = (size_t)octets * (16 * FIELD_OCTET);
  field->layout_bytes = (size_t)octets * (8 * FIELD_OCTET);
  field->mean_radius_count = (size_t)octets * FIELD_OCTET;
}

static void fill_slot(scree_field* field, const field_tile* tile, uint32_t slot, const field_rock* rock, uint32_t asset,
                      const uint32_t cell[3]) {
  double h = field->cell_size, reach2 = 0;
  uint8_t* rocks = field->rocks + (size_t)tile->rocks * (16 * FIELD_OCTET);
  uint8_t* layout = field->layouts + (size_t)tile->layout * (8 * FIELD_OCTET);
  uint32_t n = tile->padded, cells = field->cells_per_cube;
  for (uint32_t a = 0; a < 3; ++a) {
    float v = (float)((double)rock->centroid[a] * h);
    ((float*)(void*)rocks)[a * n + slot] = v;
    layout[(4 + a) * n + slot] = (uint8_t)cell[a];
    if (v < field->centroid_min[a]) field->centroid_min[a] = v;
    if (v > field->centroid_max[a]) field->centroid_max[a] = v;
    reach2 += (double)v * (double)v;
  }
  ((uint32_t*)(void*)rocks)[3 * n + slot] = asset;
  ((uint32_t*)(void*)layout)[slot] = (cell[0] + cells * (cell[1] + cells * cell[2])) * field->max_rocks_per_cell + rock->seed;
  float mean = (float)(0.5 * ((double)rock->inner_radius + (double)rock->outer_radius) * h);
  field->mean_radius[(size_t)tile->rocks * FIELD_OCTET + slot] = mean;
  if (mean < field->mean_radius_min) field->mean_radius_min = mean;
  if (mean > field->mean_radius_max) field->mean_radius_max = mean;
  float reach = (float)(sqrt(reach2) * 1.000001);
  if (reach > field->centroid_reach) field->centroid_reach = reach;
}

static void fill_assets(scree_field* field, const field_source* s) {
  for (uint32_t cell = 0; cell < s->cell_count; ++cell)
    for (uint32_t i = s->cell_first[cell]; i < s->cell_first[cell + 1]; ++i) {
      const field_rock* rock = &s->rocks[i];
      field_asset* asset = &field->assets[i];
      memcpy(asset->centroid, rock->centroid, sizeof asset->centroid);
      asset->inner_radius = rock->inner_radius;
      asset->outer_radius = rock->outer_radius;
      field_hiding* hiding = &field->hidings[i];
      hiding->burial = rock->burial > 0 && rock->burial < SCREE_BURIAL_NEVER ? (uint8_t)rock->burial : SCREE_BURIAL_NEVER;
      hiding->siblings = (uint8_t)(s->cell_first[cell + 1] - s->cell_first[cell]);
      if (hiding->burial < SCREE_BURIAL_NEVER && hiding->burial > field->deepest_burial) field->deepest_burial = hiding->burial;
    }
}

static void fill_cells(scree_field* field, const field_source* s) {
  uint32_t n = field->cells_per_cube;
  for (uint32_t i = 0; i < n * n * n; ++i) {
    uint8_t* place = field->cell_places[i];
    place[0] = (uint8_t)(i % n);
    place[1] = (uint8_t)(i / n % n);
    place[2] = (uint8_t)(i / n / n);
    place[3] = 0;
  }
  for (uint32_t i = 0; field->cell_counts != NULL && i < 256 * n * n * n; ++i)
    field->cell_counts[i] = (uint8_t)(s->cell_first[s->tile_cells[i] + 1] - s->cell_first[s->tile_cells[i]]);
}

static void fill_bare(scree_field* field) {
  for (uint32_t code = 0; field->bare != NULL && code < 256; ++code) {
    const field_tile* tile = &field->tiles[code];
    tile_slots slots = field_slots(field, tile);
    for (uint32_t i = 0; i < tile->block_first[FIELD_BLOCKS]; ++i)
      field->bare[(size_t)tile->rocks * FIELD_OCTET + i] = field->hidings[slots.asset[i]].burial == SCREE_BURIAL_NEVER;
  }
}

static bool some_cell_is_empty(const field_source* s) {
  for (uint32_t cell = 0; cell < s->cell_count; ++cell)
    if (s->cell_first[cell + 1] == s->cell_first[cell]) return true;
  return false;
}

static bool some_rock_is_bare(const field_source* s) {
  for (uint32_t i = 0; i < s->asset_count; ++i)
    if (s->rocks[i].burial < 1 || s->rocks[i].burial >= SCREE_BURIAL_NEVER) return true;
  return false;
}

static void fill_tile(scree_field* field, const field_source* s, uint32_t code) {
  uint32_t slot = 0, c[3];
  for (uint32_t b = 0; b < FIELD_BLOCKS; ++b)
    for (c[2] = block_low(field, b, 2); c[2] < block_high(field, b, 2); ++c[2])
      for (c[1] = block_low(field, b, 1); c[1] < block_high(field, b, 1); ++c[1])
        for (c[0] = block_low(field, b, 0); c[0] < block_high(field, b, 0); ++c[0]) {
          uint32_t cell = tile_cell(s, code, c[0], c[1], c[2]);
          for (uint32_t i = s->cell_first[cell]; i < s->cell_first[cell + 1]; ++i)
            fill_slot(field, &field->tiles[code], slot++, &s->rocks[i], i, c);
        }
}

static void fill_tiles(scree_field* field, const field_source* s) {
  field->mean_radius_min = INFINITY;
  for (int a = 0; a < 3; ++a) field->centroid_min[a] = INFINITY, field->centroid_max[a] = -INFINITY;
  uint32_t end = 0; /* of the layouts that are in use */
  for (uint32_t code = 0; code < 256; ++code) {
    field_tile* tile = &field->tiles[code];
    uint32_t octets = tile->padded / FIELD_OCTET;
    tile->layout = end;
    fill_tile(field, s, code);
    /* The same cells in the same order as the tile before: share them, so that they stay in the nearest cache. */
    const field_tile* last = code > 0 ? tile - 1 : NULL;
    uint8_t* own = field->layouts + (size_t)end * (8 * FIELD_OCTET);
    if (last != NULL && last->padded == tile->padded &&
        memcmp(own, field->layouts + (size_t)last->layout * (8 * FIELD_OCTET), (size_t)octets * (8 * FIELD_OCTET)) == 0) {
      tile->layout = last->layout;
      memset(own, 0, (size_t)octets * (8 * FIELD_OCTET));
    } else {
      end += octets;
    }
  }
  for (int a = 0; a < 3; ++a)
    if (field->centroid_min[a] > field->centroid_max[a]) field->centroid_min[a] = field->centroid_max[a] = 0;
  if (field->mean_radius_min > field->mean_radius_max) field->mean_radius_min = field->mean_radius_max;
}

/* Centroid of a slot, metres from the centre of the cube's cell (0, 0, 0). */
static void slot_centroid(const scree_field* field, const tile_slots* t, uint32_t slot, double out[3]) {
  double h = field->cell_size;
  out[0] = h * t->cx[slot] + (double)t->x[slot];
  out[1] = h * t->cy[slot] + (double)t->y[slot];
  out[2] = h * t->cz[slot] + (double)t->z[slot];
}

static void bound_block(scree_field* field, uint32_t b) {
  float* centre[3] = {&field->balls.x[b], &field->balls.y[b], &field->balls.z[b]};
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, p[3], radius2 = 0;
  for (int pass = 0; pass < 2; ++pass) {
    for (uint32_t code = 0; code < 256; ++code) {
      const field_tile* tile = &field->tiles[code];
      tile_slots slots = field_slots(field, tile);
      for (uint32_t i = tile->block_first[b]; i < tile->block_first[b + 1]; ++i) {
        slot_centroid(field, &slots, i, p);
        double distance2 = 0;
        for (int a = 0; a < 3; ++a) {
          if (p[a] < low[a]) low[a] = p[a];
          if (p[a] > high[a]) high[a] = p[a];
          double d = p[a] - (double)*centre[a];
          distance2 += d * d;
        }
        if (pass == 1 && distance2 > radius2) radius2 = distance2;
      }
    }
    if (low[0] > high[0]) break; /* no rocks at all */
    for (int a = 0; a < 3; ++a) *centre[a] = (float)((low[a] + high[a]) * 0.5);
  }
  field->balls.radius[b] = (float)(sqrt(radius2) * 1.000001);
}

scree_result scree_rt_field_create_from_source(const scree_field_desc* desc, const field_source* source,
                                               const scree_allocator* given, scree_field** out) {
  *out = NULL;
  scree_result result = check_desc(desc);
  if (result == SCREE_OK) result = check_source(source);
  if (result != SCREE_OK) return result;

  scree_allocator allocator = scree_rt_allocator_or_default(given);
  scree_field* field = scree_rt_allocate_zeroed(&allocator, 1, sizeof *field);
  if (field == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  field->allocator = allocator;
  field->seed = desc->seed;
  field->cell_size = desc->cell_size;
  memcpy(field->origin, desc->origin, sizeof field->origin);
  field->cells_per_cube = source->cells_per_cube;
  field->max_rocks_per_cell = source->max_rocks_per_cell;
  field->per_cell_inverse = field_cell_inverse(source->max_rocks_per_cell);
  field->max_radius = source->max_radius;
  for (uint32_t mask = 0; mask < 256; ++mask)
    for (uint32_t bit = 0, kept = 0; bit < 8; ++bit)
      if (mask >> bit & 1) field->lane_order[mask] |= (uint64_t)bit << (8 * kept++);
  place_tiles(field, source);
  field->rocks = scree_rt_allocate_zeroed(&allocator, field->rock_bytes, 1);
  field->layouts = scree_rt_allocate_zeroed(&allocator, field->layout_bytes, 1);
  field->mean_radius = scree_rt_allocate_zeroed(&allocator, field->mean_radius_count, sizeof *field->mean_radius);
  field->pack = source->pack;
  field->asset_count = source->asset_count;
  field->lattice_per_cell = source->lattice_per_cell;
  field->hull_first = source->hull_first;
  field->hulls = source->hulls;
  size_t cells = (size_t)source->cells_per_cube * source->cells_per_cube * source->cells_per_cube;
  bool empty = some_cell_is_empty(source), bare = some_rock_is_bare(source);
  field->assets = scree_rt_allocate_zeroed(&allocator, (size_t)source->asset_count + 1, sizeof *field->assets);
  field->hidings = scree_rt_allocate_zeroed(&allocator, (size_t)source->asset_count + 1, sizeof *field->hidings);
  field->cell_places = scree_rt_allocate_zeroed(&allocator, cells, sizeof *field->cell_places);
  if (empty) field->cell_counts = scree_rt_allocate_zeroed(&allocator, 256 * cells, 1);
  if (bare) field->bare = scree_rt_allocate_zeroed(&allocator, field->mean_radius_count, 1);
  if (field->rocks == NULL || field->layouts == NULL || field->mean_radius == NULL || field->assets == NULL ||
      field->hidings == NULL || field->cell_places == NULL || (empty && field->cell_counts == NULL) ||
      (bare && field->bare == NULL)) {
    scree_field_destroy(field);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  fill_tiles(field, source);
  fill_assets(field, source);
  fill_cells(field, source);
  fill_bare(field);
  for (uint32_t b = 0; b < FIELD_BLOCKS; ++b) bound_block(field, b);
  *out = field;
  return SCREE_OK;
}

void scree_field_destroy(scree_field* field) {
  if (field == NULL) return;
  scree_allocator allocator = field->allocator;
  scree_rt_release(&allocator, field->rocks, field->rock_bytes, 1);
  scree_rt_release(&allocator, field->layouts, field->layout_bytes, 1);
  scree_rt_release(&allocator, field->mean_radius, field->mean_radius_count, sizeof *field->mean_radius);
  size_t cells = (size_t)field->cells_per_cube * field->cells_per_cube * field->cells_per_cube;
  scree_rt_release(&allocator, field->assets, (size_t)field->asset_count + 1, sizeof *field->assets);
  scree_rt_release(&allocator, field->hidings, (size_t)field->asset_count + 1, sizeof *field->hidings);
  scree_rt_release(&allocator, field->cell_places, cells, sizeof *field->cell_places);
  scree_rt_release(&allocator, field->cell_counts, 256 * cells, 1);
  scree_rt_release(&allocator, field->bare, field->mean_radius_count, 1);
  scree_rt_release(&allocator, field, 1, sizeof *field);
}

uint32_t scree_rt_field_slot(const scree_field* field, uint32_t code, uint32_t local) {
  const field_tile* tile = &field->tiles[code];
  tile_slots slots = field_slots(field, tile);
  for (uint32_t i = 0; i < tile->block_first[FIELD_BLOCKS]; ++i)
    if (slots.local[i] == local) return i;
  return UINT32_MAX;
}

uint32_t scree_world_hash(const scree_field* field, const scree_id* id) {
  uint64_t hash = hash_corner(field->seed ^ UINT64_C(0x5c3ee0f1e1d5a1d7), id->cube[0], id->cube[1], id->cube[2]);
  return (uint32_t)(hash_combine(hash, id->local) >> 32);
}

uint32_t scree_field_tile_code(const scree_field* field, const int32_t cube[3]) {
  uint32_t code = 0;
  for (uint32_t corner = 0; corner < 8; ++corner) /* wraps at the end of the lattice, as its hash does */
    code |= corner_colour(field->seed, (int32_t)((uint32_t)cube[0] + (corner & 1)),
                          (int32_t)((uint32_t)cube[1] + (corner >> 1 & 1)), (int32_t)((uint32_t)cube[2] + (corner >> 2)))
            << corner;
  return code;
}
