/* Seeds: the points that rocks grow from. Which corners of the lattice decide the seeds of a cell is drawn in runtime/lattice.h. */
#ifndef SCREE_SEEDS_H
#define SCREE_SEEDS_H

#include <scree/bake.h>

#include "allocator.h"

/* Fixed point: a voxel has 512 units, so that voxel centres, cell centres and seeds are all integers and their differences are
 * exact in float. */
#define UNITS_PER_VOXEL 512

typedef struct rock_seed {
  int32_t position[3]; /* units, relative to the centre of its cell */
  float metric[6];     /* xx, yy, zz, 2xy, 2xz, 2yz of the quadratic form f / g, per square cell */
  uint64_t key;        /* hash of everything that decides this seed */
} rock_seed;

typedef struct seed_set {
  uint32_t n;      /* N, cells per side of a cube */
  uint32_t voxels; /* R, voxels per cell */
  int32_t unit;    /* units per cell */
  rock_seed* seeds;
  uint32_t seed_count;
  uint32_t* first; /* [N^3 * 256 + 1], by place class and the colours that decide */
  size_t first_count;
} seed_set;

scree_result seed_set_create(const scree_recipe* recipe, const scree_allocator* allocator, seed_set* out);
void seed_set_destroy(seed_set* set, const scree_allocator* allocator);

/* The seeds of cell (x, y, z), each -1..N, of the tile with this code, and how many they are. */
const rock_seed* seeds_of_cell(const seed_set* set, uint32_t code, int32_t x, int32_t y, int32_t z, uint32_t* count);

#endif
