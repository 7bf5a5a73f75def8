/* What a query reads of a pack: for each of the 256 tiles its rocks, in slots, as arrays a vector unit can take.
 *
 * The N x N x N cells of a tile fall into 8 blocks (the halves of each axis; N = 5: cells 0..2 and 3..4), and slots are sorted by
 * block, then z, y, x, seed. A query asks the support once for each block and looks at single rocks only where that leaves doubt.
 */
#ifndef SCREE_FIELD_TABLES_H
#define SCREE_FIELD_TABLES_H

#include <scree/field.h>

#include "lattice.h"

enum {
  FIELD_BLOCKS = 8,
  FIELD_MAX_CELLS = 8,     /* N, cells per side of a cube */
  FIELD_MAX_PER_CELL = 64, /* rocks of one cell */
  FIELD_OCTET = 8          /* slots are read eight at a time, from any slot on: arrays are padded for that */
};

/* One rock as tables are made from it: lengths in cells, relative to the centre of the home cell. */
typedef struct field_rock {
  float centroid[3];
  float inner_radius, outer_radius;
  uint32_t seed;
  uint32_t burial; /* as in scree_asset; 0 = SCREE_BURIAL_NEVER */
} field_rock;

/* Everything a field takes from a pack. */
typedef struct field_source {
  uint32_t cells_per_cube; /* N */
  uint32_t cell_count, asset_count, max_rocks_per_cell;
  float max_radius;           /* no outer_radius is larger */
  const uint32_t* tile_cells; /* [256][N][N][N]: unique cell by code, z, y, x */
  const uint32_t* cell_first; /* cell_count + 1: rocks of cell c are cell_first[c] .. cell_first[c + 1] - 1 */
  const field_rock* rocks;    /* asset_count */
  const scree_pack* pack;     /* has the hulls; NULL: they are here, or there are none */
  uint32_t lattice_per_cell;
  const uint32_t* hull_first; /* asset_count + 1: vertices of asset i's hull are hull_first[i] .. hull_first[i + 1] - 1; or NULL */
  const int16_t* hulls;       /* 3 a vertex, lattice steps; it and hull_first must outlive the field */
} field_source;

/* What rules about single rocks read of an asset. Lengths in cells, relative to the centre of the home cell. */
typedef struct field_asset {
  float centroid[3];
  float inner_radius, outer_radius;
} field_asset;

/* What burial asks about an asset; apart, so that those of a whole pack stay in the nearest cache. */
typedef struct field_hiding {
  uint8_t burial;   /* 1..SCREE_BURIAL_NEVER */
  uint8_t siblings; /* rocks of its cell, itself included */
} field_hiding;

typedef struct field_tile {
  uint32_t rocks; /* its rocks in scree_field.rocks, in units of 16 * FIELD_OCTET bytes */
  uint32_t
      layout; /* its cells in scree_field.layouts, in units of 8 * FIELD_OCTET bytes; with one rock a cell all tiles share one */
  uint32_t padded; /* length of each array, a multiple of FIELD_OCTET, at least FIELD_OCTET - 1 more than there are rocks */
  uint16_t block_first[FIELD_BLOCKS + 1]; /* slots of block b: block_first[b] .. block_first[b + 1] - 1 */
} field_tile;

/* Balls that hold the centroids of each block's rocks in every tile, metres from the centre of the cube's cell (0, 0, 0). */
typedef struct field_balls {
  float x[FIELD_BLOCKS], y[FIELD_BLOCKS], z[FIELD_BLOCKS], radius[FIELD_BLOCKS];
} field_balls;

struct scree_field {
  scree_allocator allocator;
  uint64_t seed;
  double cell_size, origin[3];
  uint32_t cells_per_cube, max_rocks_per_cell;
  uint32_t uniform_count;                                 /* rocks of a tile if all tiles have the same number, otherwise 0 */
  float max_radius;                                       /* cells */
  float centroid_min[3], centroid_max[3], centroid_reach; /* of all rocks, metres from the home cell's centre */
  float mean_radius_min, mean_radius_max;                 /* of all rocks, metres */
  field_balls balls;
  uint64_t lane_order[256]; /* byte i: the place of the i-th set bit of the index, for packing what a mask keeps */
  field_tile tiles[256];
  uint8_t *rocks, *layouts;
  float* mean_radius; /* parallel to the slots of `rocks`, apart because thresholds of one half do not read it */
  size_t rock_bytes, layout_bytes, mean_radius_count;

  const scree_pack* pack; /* or NULL: a field of a test */
  field_asset* assets;    /* asset_count */
  field_hiding* hidings;  /* asset_count */
  uint32_t asset_count;
  uint32_t deepest_burial;    /* the largest that is less than SCREE_BURIAL_NEVER; 0 = no rock is ever hidden */
  uint8_t* cell_counts;       /* rocks of each cell of each tile, [256][N][N][N]; NULL where no cell is empty */
  uint8_t* bare;              /* parallel to the slots of `rocks`: 1 where the burial is SCREE_BURIAL_NEVER; NULL where none is */
  uint32_t per_cell_inverse;  /* see field_cell_of */
  uint8_t (*cell_places)[4];  /* (x, y, z, 0) of cell x + N (y + N z); N * N * N */
  uint32_t lattice_per_cell;  /* of hulls */
  const uint32_t* hull_first; /* as in field_source */
  const int16_t* hulls;
};

enum { FIELD_MAX_HULL = 64 };

/* local / max_rocks_per_cell without a division: exact for the locals of any tile. */
static inline uint32_t field_cell_of(const scree_field* field, uint32_t local) {
  return (local * field->per_cell_inverse) >> 21;
}
static inline uint32_t field_cell_inverse(uint32_t max_rocks_per_cell) {
  return (1u << 21) / max_rocks_per_cell + 1;
}

/* The hull of an asset (below asset_count): x, y, z get at most FIELD_MAX_HULL each, lattice steps relative to the home cell's
 * centre. Returns how many. */
uint32_t scree_rt_field_hull(const scree_field* field, uint32_t asset, float* x, float* y, float* z);
#ifdef SCREE_WIDE_KERNELS
/* x, y, z of `count` points from arrays of points, whose coordinates are int8 or int16, for machines that have AVX2. */
void scree_rt_field_split_points_avx2(const void* xyz, bool narrow, uint32_t count, float* x, float* y, float* z);
#endif

/* The slot of a rock in the tile with this code, or UINT32_MAX when the tile has no such rock. */
uint32_t scree_rt_field_slot(const scree_field* field, uint32_t code, uint32_t local);

/* Cells of block b along an axis: low .. high - 1. The first half is the larger one. */
static inline uint32_t block_low(const scree_field* field, uint32_t b, int axis) {
  return b >> axis & 1 ? (field->cells_per_cube + 1) / 2 : 0;
}
static inline uint32_t block_high(const scree_field* field, uint32_t b, int axis) {
  return b >> axis & 1 ? field->cells_per_cube : (field->cells_per_cube + 1) / 2;
}

/* The arrays of a tile. */
typedef struct tile_slots {
  const float *x, *y, *z; /* centroid, metres from the centre of the home cell */
  const uint32_t* asset;
  const float* mean_radius;    /* half of inner + outer radius, metres */
  const uint32_t* local;       /* as in scree_id */
  const uint8_t *cx, *cy, *cz; /* the home cell in the cube */
} tile_slots;

static inline tile_slots field_slots(const scree_field* field, const field_tile* tile) {
  size_t n = tile->padded;
  const uint8_t* rocks = field->rocks + (size_t)tile->rocks * (16 * FIELD_OCTET);
  const uint8_t* layout = field->layouts + (size_t)tile->layout * (8 * FIELD_OCTET);
  const float* floats = (const float*)(const void*)rocks;
  return (tile_slots){.x = floats,
                      .y = floats + n,
                      .z = floats + 2 * n,
                      .asset = (const uint32_t*)(const void*)(rocks + 12 * n),
                      .mean_radius = field->mean_radius + (size_t)tile->rocks * FIELD_OCTET,
                      .local = (const uint32_t*)(const void*)layout,
                      .cx = layout + 4 * n,
                      .cy = layout + 5 * n,
                      .cz = layout + 6 * n};
}

/* Makes a field from tables that may hold anything; checks them. Returns what scree_field_create returns. */
scree_result scree_rt_field_create_from_source(const scree_field_desc* desc, const field_source* source,
                                               const scree_allocator* allocator, scree_field** out);

#endif
