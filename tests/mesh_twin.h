/* Slow and plain facts about triangle meshes on the pack's lattice, for tests to hold the baker's numbers against. */
#ifndef SCREE_TESTS_MESH_TWIN_H
#define SCREE_TESTS_MESH_TWIN_H

#include <stdbool.h>
#include <stdint.h>

typedef struct twin_mesh {
  const int16_t (*positions)[3]; /* lattice steps */
  const uint32_t* indices;       /* 3 a triangle, counter-clockwise from outside */
  uint32_t vertex_count, triangle_count;
} twin_mesh;

/* What keeps a mesh from being a closed, consistently oriented 2-manifold without waste. All zero is right. */
typedef struct mesh_faults {
  uint32_t bad_indices;      /* out of range */
  uint32_t repeated_corners; /* triangles that use a vertex twice */
  uint32_t flat_triangles;   /* no area */
  uint32_t shared_edges;     /* directed edges used more than once: a triangle twice, an edge of 3 triangles, a flipped one */
  uint32_t open_edges;       /* directed edges without their reverse */
  uint32_t pinched_vertices; /* vertices whose triangles are not one fan */
  uint32_t unused_vertices;
  uint32_t repeated_vertices; /* at the place of another */
} mesh_faults;

mesh_faults mesh_find_faults(const twin_mesh* mesh);
uint32_t mesh_fault_sum(const mesh_faults* faults);

/* Volume and centre of mass in lattice units, by tetrahedra to the first vertex in doubles. */
void mesh_mass(const twin_mesh* mesh, double* volume, double centroid[3]);

/* Distance from p to the surface, over all triangles; any upper bound of it once that is not above `enough`. */
double mesh_distance(const twin_mesh* mesh, const double p[3], double enough);

/* How many times the surface winds around p, by solid angles: 1 inside, 0 outside; p must not lie on it. */
double mesh_winding(const twin_mesh* mesh, const double p[3]);

/* Triangles by column of (x, y), for exact tests of lattice points. */
typedef struct mesh_columns {
  twin_mesh mesh;
  int32_t min[3], max[3], width, height;
  uint32_t *first, *list;
} mesh_columns;

void mesh_columns_create(const twin_mesh* mesh, mesh_columns* out);
void mesh_columns_destroy(mesh_columns* columns);

/* Is a lattice point strictly inside? Decided in integers, by the parity of crossings above it; points of the surface are not. */
bool mesh_holds(const mesh_columns* columns, const int32_t p[3]);

/* An upper bound of the distance from p to the convex hull of points, which is the true one after enough rounds: the walk of Frank
 * and Wolfe, 1956, stopped as soon as it is below `enough`. */
double hull_distance(const int16_t (*points)[3], uint32_t count, const double p[3], double enough);

#endif
