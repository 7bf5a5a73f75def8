/* How far a coarse level of detail strays from the finest one. */
#ifndef SCREE_LOD_ERROR_H
#define SCREE_LOD_ERROR_H

#include "surface_nets.h"

/* Largest distance, in lattice steps, from a vertex of `fine` to the surface of `coarse`; never less than the true one, and rarely
 * more. field: the one that `coarse` was made from; coarse->vertex_of is overwritten. scratch: lod_error_scratch(coarse) elements.
 */
float lod_error(const mesh_buffer* fine, const mesh_buffer* coarse, const voxel_field* field, uint32_t* scratch);

/* The same, where a vertex of `fine` counts for no more than its cap: that of a piece which a level may leave out is the piece's
 * radius. caps: one a vertex. */
float lod_error_capped(const mesh_buffer* fine, const mesh_buffer* coarse, const voxel_field* field, uint32_t* scratch,
                       const float* caps);

/* The distance, in lattice steps, that 95 of 100 vertices of `fine` do not pass, from a share of them: for unions with deep pits
 * that nobody looks into. distances: scratch, one a vertex of `fine`. */
float lod_error_of_most(const mesh_buffer* fine, const mesh_buffer* coarse, const voxel_field* field, uint32_t* scratch,
                        float* distances);

static inline uint32_t lod_error_scratch(const mesh_buffer* coarse) {
  return coarse->vertex_count + 1 + coarse->index_count + coarse->index_count / 3;
}

#endif
