/* An endless coloured lattice of cells in one global integer frame, and a slow plain twin of the baker's Voronoi diagram and
 * contacts on it. Tests hold tiled rocks, baked once each, against it.
 *
 * Units are the baker's fixed-point ones, but counted from the centre of global cell (0, 0, 0): the centre of cell c is c * unit,
 * the middle of voxel v is 256 * (2 v + 1). Nothing here knows blocks, zones or a rock's own frame. */
#ifndef SCREE_TESTS_TILING_H
#define SCREE_TESTS_TILING_H

#include "bake_internal.h"

typedef struct tiling {
  uint64_t colours; /* seed of the corners' colours */
  const seed_set* seeds;
  float* weights; /* [voxels per cell] 1 / w of a voxel so many voxels from a cell's centre */
} tiling;

/* Ends the test when memory is short. */
void tiling_create(uint64_t colours, const seed_set* seeds, tiling* out);
void tiling_destroy(tiling* lattice);

/* The unique cell at a global cell. */
uint32_t tiling_cell(const tiling* lattice, const int32_t cell[3]);

/* The seeds of a global cell, as the tile that it lies in gives them. */
const rock_seed* tiling_seeds(const tiling* lattice, const int32_t cell[3], uint32_t* count);

/* A box of global cells with numbered rocks. */
typedef struct tiling_box {
  const tiling* lattice;
  int32_t min[3], size[3];
  const rock_seed** seeds; /* by cell, x fastest */
  uint32_t* first;         /* [cells + 1] number of each cell's first rock */
  uint32_t* unique;        /* unique cell of each */
} tiling_box;

void tiling_box_create(const tiling* lattice, const int32_t min[3], const int32_t size[3], tiling_box* out);
void tiling_box_destroy(tiling_box* box);
uint32_t tiling_box_index(const tiling_box* box, const int32_t cell[3]);
bool tiling_box_holds(const tiling_box* box, const int32_t cell[3]);

/* Number of the rock of the box that owns a voxel: the least distance over all seeds whose support holds the voxel's middle, in the
 * float arithmetic of the baker; equals go to the rock with the lowest number. Cells around the voxel must lie in the box. */
uint32_t reference_owner(const tiling_box* box, const int32_t voxel[3]);

typedef enum reference_verdict {
  REFERENCE_NONE,
  REFERENCE_CONTACT,
  REFERENCE_CLOSE_CALL /* a third seed is as near as the pair to a few thousandths: rounding decides */
} reference_verdict;

/* Whether rocks (a, seed_a) and (b, seed_b), two different ones of a box that holds all cells around both, touch: they are
 * neighbours and no third seed is nearer to the point between their seeds where they are equally near. point: global units. */
reference_verdict reference_contact(const tiling_box* box, const int32_t a[3], uint32_t seed_a, const int32_t b[3], uint32_t seed_b,
                                    double point[3]);

#endif
