/* Slow and plain facts about triangle surfaces, for tests. */
#ifndef SCREE_TESTS_SURFACE_TWIN_H
#define SCREE_TESTS_SURFACE_TWIN_H

#include <scree/frost.h>

/* Edges that are not used as often in one direction as in the other; those from a vertex to itself do not count. */
uint32_t twin_open_edges(const uint32_t* indices, uint32_t triangle_count);

double twin_volume(const double* positions, const uint32_t* indices, uint32_t triangle_count);

/* Gives vertices at the same place the same number. */
void twin_join_places(const scree_frost_surface* surface, uint32_t* corners);

/* Whether start + t * direction, 0 <= t <= farthest, meets the triangle of three points. */
bool twin_ray_meets(const double* corners, const double start[3], const double direction[3], double farthest);

uint64_t twin_digest(const void* bytes, size_t size);

#endif
