/* Sets of voxels, one bit each, a row of x a 64-bit word: rows[y + height * z]. */
#ifndef SCREE_VOXEL_MASK_H
#define SCREE_VOXEL_MASK_H

#include <stddef.h>
#include <stdint.h>

/* Carves voxels until the set is well-composed: no 2x2 square holds just a diagonal pair, no 2x2x2 cube just two opposite corners
 * or all but two. A surface through its border is then a 2-manifold. Of the candidates the one with the least field goes; its field
 * becomes -carved. field has `width` elements a row. The outermost voxels must be empty. Returns how many voxels were carved. */
uint32_t mask_make_well_composed(uint64_t* rows, uint32_t height, uint32_t depth, float* field, uint32_t width, float carved);

/* Keeps the largest face-connected component, the lowest one of equals, and sets the field of all other voxels to -carved.
 * scratch: 2 * height * depth words. Returns the number of voxels kept. */
uint32_t mask_keep_largest(uint64_t* rows, uint32_t height, uint32_t depth, float* field, uint32_t width, float carved,
                           uint64_t* scratch);

/* Fills every empty voxel that no path through faces of empty voxels joins to the outermost ones, which must be empty. width:
 * <= 64. scratch: 2 * height * depth words. */
void mask_fill_voids(uint64_t* rows, uint32_t width, uint32_t height, uint32_t depth, uint64_t* scratch);

/* Adds to a set, or takes away, the voxels that share a face with its border. The outermost voxels are taken as empty and stay so.
 * scratch: height * depth words. */
void mask_grow(uint64_t* rows, uint32_t height, uint32_t depth, uint64_t* scratch);
void mask_shrink(uint64_t* rows, uint32_t height, uint32_t depth, uint64_t* scratch);

#endif
