/* What a rock fills, in voxels of a grid that all rocks share and that is coarse enough to be kept for all of them: what burial and
 * proxies are found from. */
#ifndef SCREE_ROCK_MASK_H
#define SCREE_ROCK_MASK_H

#include "rock_mesh.h"

#define MASK_MAX_PER_CELL 14 /* mask voxels per cell: a row of two cells fits 32 bits */

/* Voxels of the box of two cells around the home cell's centre, one bit each: is the middle of the voxel inside the finest level?
 */
typedef struct rock_mask {
  uint8_t min[3], size[3]; /* rows y = min[1] .., z = min[2] .., each all of x */
  uint32_t* rows;          /* [size[2]][size[1]]; NULL: nothing is left of the rock */
} rock_mask;

/* Fine voxels to a mask voxel along each axis, so that at most MASK_MAX_PER_CELL make a cell. */
uint32_t mask_step(uint32_t voxels_per_cell);

/* The mask of the worker's rock. On failure *out owns nothing. */
scree_result rock_mask_make(const rock_worker* worker, const scree_allocator* allocator, rock_mask* out);
void rock_mask_free(rock_mask* mask, const scree_allocator* allocator);

#endif
