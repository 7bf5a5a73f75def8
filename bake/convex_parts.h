/* Convex hulls of a closed mesh: one over all of it, or several that fit closer where it is far from convex. */
#ifndef SCREE_CONVEX_PARTS_H
#define SCREE_CONVEX_PARTS_H

#include "rock_mesh.h"

enum { PARTS_MAX = 8, PARTS_MAX_HULL = 32 };

typedef struct convex_part {
  int16_t hull[PARTS_MAX_HULL][3]; /* lattice steps */
  uint32_t hull_count;             /* >= 4 */
  double volume;                   /* of the hull, cubic lattice steps */
  int32_t bottom;                  /* its lowest lattice step */
} convex_part;

/* Volume of the convex hull of points, at most ROCK_MAX_HULL; 0 if they lie in a plane. */
double convex_volume(const int16_t (*points)[3], uint32_t count);

/* At most `most` (<= ROCK_MAX_HULL) corners of the convex hull of a mesh that span nearly all of it. Returns SCREE_OK or
 * OUT_OF_MEMORY. */
scree_result convex_hull_of(const mesh_buffer* mesh, const kernel_set* kernels, uint32_t most, const scree_allocator* allocator,
                            int16_t (*hull)[3], uint32_t* count);

/* Cuts a mesh by planes along the axes, always where that takes most air out of the hulls, into as many parts as are worth it, and
 * fits a hull around each. coarse: the same shape with fewer triangles, which the cuts are looked for on; may be
 * the mesh itself. parts: room for PARTS_MAX; lowest first. count: 1..PARTS_MAX. Returns SCREE_OK or OUT_OF_MEMORY. */
scree_result convex_parts_of(const mesh_buffer* mesh, const mesh_buffer* coarse, const kernel_set* kernels,
                             const scree_allocator* allocator, convex_part* parts, uint32_t* count);

#endif
