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
} field_rock;

/* Everything a field takes from a pack. */
typedef struct field_source {
  uint32_t cells_per_cube; /* N */
  uint32_t cell_count, asset_count, max_rocks_per_cell;
  float max_radius;           /* no outer_radius is larger */
  const uint32_t* tile_cells; /* [256][N][N][N]: unique cell by code, z, y, x */
  const uint32_t* cell_first; /* cell_count + 1: rocks of cell c are cell_first[c] .. cell_first[c + 1] - 1 */
  const field_rock* rocks;    /* asset_count */
} field_source;

typedef struct field_tile {
  uint32_t offset; /* of its arrays in scree_field.slots, in units of 32 * FIELD_OCTET bytes */
  uint32_t padded; /* length of each array, a multiple of FIELD_OCTET, at least FIELD_OCTET - 1 more than there are rocks */
  uint16_t block_first[FIELD_BLOCKS + 1]; /* slots of block b: block_first[b] .. block_first[b + 1] - 1 */
} field_tile;

typedef struct field_block {
  uint8_t low[3], high[3]; /* cells low .. high - 1 */
  float centre[3]; /* of a ball that holds the centroids of the block's rocks in every tile, metres from the centre of the */
  float radius;    /* cube's cell (0, 0, 0) */
} field_block;

struct scree_field {
  scree_allocator allocator;
  uint64_t seed;
  double cell_size, origin[3];
  uint32_t cells_per_cube, max_rocks_per_cell;
  uint32_t uniform_count;                                 /* rocks of a tile if all tiles have the same number, otherwise 0 */
  float max_radius;                                       /* cells */
  float centroid_min[3], centroid_max[3], centroid_reach; /* of all rocks, metres from the home cell's centre */
  float mean_radius_min, mean_radius_max;                 /* of all rocks, metres */
  field_block blocks[FIELD_BLOCKS];
  field_tile tiles[256];
  uint8_t* slots;
  size_t slot_bytes;
};

/* The arrays of a tile. */
typedef struct tile_slots {
  const float *x, *y, *z;        /* centroid, metres from the centre of the home cell */
  const float* mean_radius;      /* half of inner + outer radius, metres */
  const uint32_t *asset, *local; /* local: as in scree_id */
  const uint8_t *cx, *cy, *cz;   /* the home cell in the cube */
} tile_slots;

static inline tile_slots field_slots(const scree_field* field, const field_tile* tile) {
  const uint8_t* base = field->slots + (size_t)tile->offset * (32 * FIELD_OCTET);
  const float* floats = (const float*)(const void*)base;
  const uint32_t* words = (const uint32_t*)(const void*)base;
  const uint8_t* bytes = base + (size_t)tile->padded * 24;
  size_t n = tile->padded;
  return (tile_slots){floats,        floats + n, floats + 2 * n, floats + 3 * n, words + 4 * n,
                      words + 5 * n, bytes,      bytes + n,      bytes + 2 * n};
}

/* Makes a field from tables that may hold anything; checks them. Returns what scree_field_create returns. */
scree_result field_create_from_source(const scree_field_desc* desc, const field_source* source, const scree_allocator* allocator,
                                      scree_field** out);

#endif
