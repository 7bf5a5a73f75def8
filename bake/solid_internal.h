/* What all that reads or makes solids shares. */
#ifndef SCREE_SOLID_INTERNAL_H
#define SCREE_SOLID_INTERNAL_H

#include <scree/shards.h>

#include "allocator.h"

/* Beyond this no coordinate of a solid is read. */
#define SOLID_LIMIT 1e6

/* Arrays are there, indices within range and numbers finite and within SOLID_LIMIT: nothing about edges. Returns SCREE_OK,
 * INVALID_ARGUMENT or RANGE. */
scree_result solid_check_numbers(const scree_solid* solid, scree_error* error);

/* scree_solid_check in two halves: all but crossings, and these, of a solid that passed the first. */
scree_result solid_check_closed(const scree_solid* solid, const scree_allocator* allocator, scree_error* error);
scree_result solid_check_crossings(const scree_solid* solid, const scree_allocator* allocator, scree_error* error);

/* Six times the volume, measured from the middle of the box so that far away meshes keep their digits. */
double solid_volume6(const scree_solid* solid);

void solid_bounds(const scree_solid* solid, double min[3], double max[3]);

/* Room for a solid in one piece of memory, all of it zeroed; vertices below 2^32 and triangles below 2^32 / 3. */
scree_result solid_memory_create(uint64_t vertices, uint64_t triangles, bool uvs, const scree_allocator* allocator,
                                 scree_solid_memory* out, scree_error* error);
static inline double* solid_positions(const scree_solid_memory* memory) {
  return (double*)memory->memory;
}
static inline uint32_t* solid_indices(const scree_solid_memory* memory) {
  return (uint32_t*)(void*)(solid_positions(memory) + (size_t)3 * memory->solid.vertex_count);
}
/* Of a solid that has them. */
static inline float* solid_uvs(const scree_solid_memory* memory) {
  return (float*)(void*)(solid_indices(memory) + (size_t)3 * memory->solid.triangle_count);
}

#endif
