/* Voronoi cells one at a time: a grid of seeds, and a convex cell that bisectors and walls cut.
 *
 * A cell is kept as its dual: a corner is a triple of planes, counter-clockwise seen from outside, and knows the three corners that
 * it shares an edge with. The corners that a plane cuts off are a disk of the dual; each edge of its border becomes a corner with
 * the new plane. What is not such a disk is a near-degenerate cell. A corner's position is solved from its three planes, never
 * carried on from older ones.
 * Based on: Ray, Sokolov, Lefebvre, Levy 2018, "Meshless Voronoi on the GPU"; with links between corners and without its limits.
 *
 * Only + - * / and sqrt, ties to the lowest index: cells repeat to the bit. */
#ifndef SCREE_VORONOI_CELL_H
#define SCREE_VORONOI_CELL_H

#include "allocator.h"

/* --- seeds ------------------------------------------------------------------------------------------------------------------ */

/* Seeds sorted into a grid of about 2.5 each; read by any number of threads. */
typedef struct voronoi_grid {
  const double* seeds; /* the caller's, 3 each */
  double* points;      /* 3 each, in the order of the grid */
  uint32_t* order;     /* which seed each of `points` is: rising within a box of the grid */
  uint32_t* first;     /* of each box of the grid, in `points`: boxes + 1, x fastest */
  uint32_t* box_of;    /* of each seed */
  uint32_t seed_count, size[3];
  double min[3], step[3];
} voronoi_grid;

/* Returns SCREE_OK or OUT_OF_MEMORY. count: >= 1; seeds finite. */
scree_result voronoi_grid_create(const double* seeds, uint32_t count, const scree_allocator* allocator, voronoi_grid* out);
void voronoi_grid_free(voronoi_grid* grid, const scree_allocator* allocator); /* all zero is allowed */

/* The seed nearest to a point, the lowest of equals. */
uint32_t voronoi_grid_nearest(const voronoi_grid* grid, const double point[3]);

/* --- walls ------------------------------------------------------------------------------------------------------------------ */

/* Marks a plane's neighbour as a wall: VORONOI_WALL + 0..5 are the sides of the box (-x, +x, -y, +y, -z, +z), the given walls
 * follow from VORONOI_WALL + VORONOI_BOX on. Sorts after all seeds. */
#define VORONOI_WALL UINT32_C(0x80000000)
enum { VORONOI_BOX = 6 };

/* A half space: normal . x <= offset. */
typedef struct voronoi_wall {
  double normal[3]; /* unit, outwards */
  double offset;    /* positions are solved with this */
  double cut;       /* vertices are cut off by this: equal to offset, or so near to it that corners of more than 3 walls are told
                       apart in the same way by all cells */
} voronoi_wall;

/* What cells are kept in. The box must be finite. */
typedef struct voronoi_bounds {
  double min[3], max[3];
  const voronoi_wall* walls;
  uint32_t wall_count;
} voronoi_bounds;

/* --- cells ------------------------------------------------------------------------------------------------------------------ */

typedef struct voronoi_plane {
  double normal[3]; /* towards the neighbour, not unit; relative to the seed: normal . (x - seed) <= offset */
  double offset, cut;
  uint32_t neighbour; /* a seed, or VORONOI_WALL + ... */
} voronoi_plane;

typedef struct voronoi_corner {
  uint32_t planes[3];  /* counter-clockwise seen from outside */
  uint32_t corners[3]; /* [k]: the corner across the edge of planes[k] and planes[k + 1] */
} voronoi_corner;

typedef struct voronoi_face {
  uint32_t neighbour;          /* a seed, or VORONOI_WALL + ... */
  uint32_t plane;              /* in `planes` */
  uint32_t first_index, count; /* in `indices` */
} voronoi_face;

/* One cell, and the memory for the next: make one per thread, voronoi_cell_free it at the end. All zero is an empty one. */
typedef struct voronoi_cell {
  const scree_allocator* allocator;
  uint32_t seed;
  double origin[3];        /* the seed's position */
  double (*positions)[3];  /* of corners, relative to origin */
  voronoi_corner* corners; /* corner_count; 0 = the cell misses the bounds */
  voronoi_plane* planes;   /* those tried; some may have no corner left */
  voronoi_face* faces;     /* by neighbour, rising */
  uint32_t* indices;       /* of faces: corners, counter-clockwise seen from outside */
  uint32_t corner_count, plane_count, face_count, index_count;
  /* Working memory. */
  uint32_t corner_capacity, plane_capacity, near_capacity, edge_capacity;
  double radius2; /* of the farthest corner, squared */
  void *near, *edges;
  double *x, *y, *z;
  uint32_t *removed, *marks;
  uint64_t* outside; /* a bit a corner */
  uint32_t stamp;
} voronoi_cell;

/* Makes the cell of one seed, faces included. Returns SCREE_OK, OUT_OF_MEMORY, or UNSUPPORTED where rounding cannot tell how planes
 * meet: move the seeds. After a failure the cell may be used again. */
scree_result voronoi_cell_make(voronoi_cell* cell, const voronoi_grid* grid, uint32_t seed, const voronoi_bounds* bounds,
                               const scree_allocator* allocator);
void voronoi_cell_free(voronoi_cell* cell);

/* What names a corner in every cell that has it: its seed and neighbours, rising. */
void voronoi_cell_key(const voronoi_cell* cell, uint32_t corner, uint32_t key[4]);

#endif
