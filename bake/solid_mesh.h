/* What is inside and what is not, on a grid, as a closed mesh. */
#ifndef SCREE_SOLID_MESH_H
#define SCREE_SOLID_MESH_H

#include "solid_internal.h"

/* Samples of a grid: sample (x, y, z) lies at min + step * (x, y, z). */
typedef struct solid_grid {
  double min[3], step;
  uint32_t size[3];
  uint64_t* inside; /* a bit each, x fastest */
} solid_grid;

static inline size_t solid_grid_at(const solid_grid* grid, uint32_t x, uint32_t y, uint32_t z) {
  return ((size_t)z * grid->size[1] + y) * grid->size[0] + x;
}
static inline bool solid_grid_has(const solid_grid* grid, size_t at) {
  return (grid->inside[at >> 6] >> (at & 63) & 1) != 0;
}
static inline void solid_grid_set(solid_grid* grid, size_t at) {
  grid->inside[at >> 6] |= UINT64_C(1) << (at & 63);
}
static inline void solid_grid_place(const solid_grid* grid, uint32_t x, uint32_t y, uint32_t z, double p[3]) {
  p[0] = grid->min[0] + x * grid->step, p[1] = grid->min[1] + y * grid->step, p[2] = grid->min[2] + z * grid->step;
}

/* Where it comes from. */
typedef struct solid_source {
  void* user;
  /* Sets the bits of all samples that are inside; those at the very border are not looked at. False: out of memory. */
  bool (*fill)(void* user, solid_grid* grid);
  /* How far from p, which is inside, to q, which is not, the surface lies, 0..1. */
  double (*surface)(void* user, const double p[3], const double q[3]);
} solid_source;

/* Meshes what lies in the box, `resolution` samples along its longest side. what: for errors. Returns SCREE_OK, INVALID_ARGUMENT
 * (nothing inside), RANGE or OUT_OF_MEMORY. */
scree_result solid_mesh(const solid_source* source, const double min[3], const double max[3], uint32_t resolution, const char* what,
                        const scree_allocator* allocator, scree_solid_memory* out, scree_error* error);

#endif
