/* The walls of a convex solid: triangles of one plane are one wall. */
#ifndef SCREE_CONVEX_WALLS_H
#define SCREE_CONVEX_WALLS_H

#include "shard_pieces.h"
#include "voronoi_cell.h"

typedef struct convex_walls {
  voronoi_wall* walls; /* by triangle, rising */
  uint32_t* triangles; /* of each wall: its largest */
  uint32_t* wall_of;   /* of each triangle */
  uint32_t*
      at_first; /* of each vertex of the solid: walls that meet there are at[at_first[v]] .. at[at_first[v] + at_count[v] - 1] */
  uint32_t* at_count;
  uint32_t* at;
  uint32_t* corner_first; /* wall_count + 1; vertices where this and two more walls meet */
  uint32_t* corners;
  uint32_t wall_count, vertex_count, triangle_count;
} convex_walls;

/* convex: may be NULL; set when no edge is hollow and the solid is in one piece without holes. Else walls are of no use. Returns
 * SCREE_OK or OUT_OF_MEMORY. The solid is closed. */
scree_result convex_walls_create(const double* positions, uint32_t vertex_count, const uint32_t* indices, uint32_t triangle_count,
                                 const scree_allocator* allocator, convex_walls* out, bool* convex);
void convex_walls_free(convex_walls* walls, const scree_allocator* allocator); /* all zero is allowed */

/* False where one look at some of the triangles tells that a solid is not convex. */
bool convex_walls_possible(const double* positions, uint32_t vertex_count, const uint32_t* indices, uint32_t triangle_count);

/* The vertex of the solid where three walls meet; UINT32_MAX when there is none. */
uint32_t convex_walls_corner(const convex_walls* walls, uint32_t a, uint32_t b, uint32_t c);

#endif
