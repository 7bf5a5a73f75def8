/* Which crossed edges of a cube of 2x2x2 voxels belong to one piece of surface: the tables of dual marching cubes.
 *
 * Corner i of a cube lies at (i & 1, i >> 1 & 1, i >> 2). Edge 4 * axis + k runs along `axis`; k counts the corners that it can
 * start at. A configuration has a bit for each corner that is inside.
 *
 * Based on: Nielson, Dual Marching Cubes, 2004, made manifold as by Wenger, Isosurfaces, 2013, section 5.4: on a face whose corners
 * are inside along one diagonal only, surface cuts the two inside corners apart. In a few configurations both cuts belong to one
 * piece; where two such cubes meet face to face, four quads would share an edge. There, and only there, the face is cut the other
 * way in both. That looks at nothing but a cube and its neighbour, so it is right for any set of voxels, without carving any. */
#ifndef SCREE_SURFACE_CUBES_H
#define SCREE_SURFACE_CUBES_H

#include <stdint.h>

enum { CUBE_EDGES = 12, CUBE_FACES = 6, CUBE_NO_FACE = 6 };

typedef struct surface_cubes {
  /* The first index is 1 where the pinching face is cut the other way. */
  uint8_t piece[2][256][CUBE_EDGES]; /* piece of each crossed edge: 0, 1, ... in order of their first edge */
  uint8_t pieces[2][256];            /* how many */
  uint8_t pinching[256];             /* face with both cuts in one piece, or CUBE_NO_FACE; a configuration has one at most */
  uint16_t crossed[256];             /* edges that are crossed, a bit each */
} surface_cubes;

void surface_cubes_fill(surface_cubes* out);

/* The corners of an edge. */
static inline uint32_t cube_edge_low(uint32_t edge) {
  const uint32_t k = edge & 3;
  return edge < 4 ? k << 1 : edge < 8 ? (k & 1) | (k & 2) << 1 : k;
}
static inline uint32_t cube_edge_high(uint32_t edge) {
  return cube_edge_low(edge) | 1u << (edge >> 2);
}

#endif
