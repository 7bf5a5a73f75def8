/* Triangles of a closed mesh that cross each other.
 *
 * Two triangles cross where their insides meet, borders left out, in a line, or in an area while both look the same way. So these
 * are no crossings: neighbours; closed parts that touch in a point, along an edge, or face to face; a fold of no thickness.
 * Surfaces that go through each other along edges of both alone, or along edges of one, are not told from such that touch there.
 * Signs are exact, so that nothing of this depends on how large or how far away a mesh is. */
#ifndef SCREE_SOLID_CROSSINGS_H
#define SCREE_SOLID_CROSSINGS_H

#include <scree/base.h>

typedef struct solid_crossing {
  uint32_t triangles[2]; /* [0] < [1]; of all pairs the first in this order; both SCREE_NO_CROSSING where there is none */
  double place[3];       /* where both are, to rounding */
} solid_crossing;

#define SCREE_NO_CROSSING UINT32_MAX

/* Numbers must be finite and indices within range. Returns SCREE_OK, crossing or not, or OUT_OF_MEMORY. */
scree_result solid_find_crossing(const double* positions, const uint32_t* indices, uint32_t triangle_count,
                                 const scree_allocator* allocator, solid_crossing* out);

/* Of two triangles of such a mesh; place: may be NULL. */
bool solid_triangles_cross(const double* positions, const uint32_t* a, const uint32_t* b, double place[3]);

#endif
