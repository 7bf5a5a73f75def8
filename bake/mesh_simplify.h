/* Fewer triangles for a closed mesh on an integer lattice: half-edge collapses in the order of quadric errors.
 * Based on: Garland and Heckbert 1997, "Surface Simplification Using Quadric Error Metrics"; the link condition of Dey et al. 1999.
 * We differ in what repeats: places stay on the lattice, ties go to the lowest index, and only + - * / sqrt are used. That, and
 * that Debian compiles meshoptimizer with contraction of floating point on some machines, so that digests of packs would differ
 * between them, is why this is our own.
 *
 * The topology is that of places: a vertex has one place and one fan of triangles. What is not smooth belongs to triangles and
 * their corners: a group, and a uv for each corner. Edges between groups, materials and uvs are cheap to keep and dear to leave. */
#ifndef SCREE_MESH_SIMPLIFY_H
#define SCREE_MESH_SIMPLIFY_H

#include <scree/base.h>

/* Arrays are the caller's; simplifying works in them. A triangle that is gone has corner[0] == SIMPLIFY_GONE. */
typedef struct simplify_mesh {
  int16_t (*positions)[3];
  uint32_t (*corners)[3];   /* counter-clockwise from outside; closed, with one fan around each vertex: see mesh_split_fans */
  float (*uvs)[3][2];       /* of each triangle's corners */
  const uint32_t* groups;   /* of each triangle */
  const uint8_t* materials; /* of each triangle: SIMPLIFY_MATERIAL are the material, the others a shade, whose edges count least */
  uint32_t vertex_count, triangle_count;
} simplify_mesh;

#define SIMPLIFY_GONE UINT32_MAX
#define SIMPLIFY_MATERIAL 3

typedef struct mesh_simplifier mesh_simplifier;

/* Returns SCREE_OK, INVALID_ARGUMENT (not closed) or OUT_OF_MEMORY. */
scree_result mesh_simplifier_create(const simplify_mesh* mesh, const scree_allocator* allocator, mesh_simplifier** out);
void mesh_simplifier_destroy(mesh_simplifier* simplifier); /* NULL is allowed */

/* Joins vertices of one place, and takes away triangles without area where that moves nothing by more than a lattice step. */
void mesh_simplifier_clean(mesh_simplifier* simplifier);

/* Collapses until at most `triangles` are left or none can go: those that would turn a triangle over, make a sliver, or join what
 * is not joined, cannot. Returns how many triangles are left. */
uint32_t mesh_simplifier_run(mesh_simplifier* simplifier, uint32_t triangles);

/* Splits vertices until every edge has two triangles and every vertex one fan, so that solids that touch at an edge or a vertex
 * come apart. positions: 3 doubles each, of the vertices that go in; corners: 3 a triangle, closed: every edge as often in one
 * direction as in the other; where an edge has more than two triangles those are paired that have rock between them. vertex_of: one
 * a corner at most, filled with the old vertex of each new one. Returns SCREE_OK, INVALID_ARGUMENT (not closed) or OUT_OF_MEMORY.
 */
scree_result mesh_split_fans(const double* positions, uint32_t (*corners)[3], uint32_t triangle_count,
                             const scree_allocator* allocator, uint32_t* vertex_of, uint32_t* vertex_count);

#endif
