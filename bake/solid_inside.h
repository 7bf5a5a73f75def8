/* Is a point inside a closed mesh: how often the surface is left, less how often it is entered, on the way straight up (+y). Bins
 * of the x, z plane hold the triangles above and below them. Two triangles that share an edge agree to the bit about which of them
 * a ray passes, so that none slips through between them. */
#ifndef SCREE_SOLID_INSIDE_H
#define SCREE_SOLID_INSIDE_H

#include <stdbool.h>

#include "allocator.h"

typedef struct solid_inside {
  const double* positions; /* the caller's, 3 a vertex */
  const uint32_t* indices; /* likewise, 3 a triangle */
  uint32_t* first;         /* of each bin, in `triangles`: size[0] * size[1] + 1, x fastest */
  uint32_t* triangles;
  size_t entries;
  uint32_t size[2];
  double min[2], step[2];
} solid_inside;

/* Where a vertical line passes the surface. */
typedef struct solid_crossing {
  double y;
  int32_t turn; /* +1: upwards out of the solid, -1: into it */
} solid_crossing;

/* Positions finite. Returns SCREE_OK or OUT_OF_MEMORY. */
scree_result solid_inside_create(const double* positions, const uint32_t* indices, uint32_t triangle_count,
                                 const scree_allocator* allocator, solid_inside* out);
void solid_inside_free(solid_inside* inside, const scree_allocator* allocator); /* all zero is allowed */

/* How often the surface winds round a point: 1 inside, 0 outside, more where parts overlap. Thread-safe. */
int32_t solid_winding(const solid_inside* inside, const double p[3]);
static inline bool solid_is_inside(const solid_inside* inside, const double p[3]) {
  return solid_winding(inside, p) > 0;
}

/* All crossings of the line through x, z, lowest first, as many as there is room for; returns how many there are. */
uint32_t solid_crossings(const solid_inside* inside, double x, double z, solid_crossing* out, uint32_t capacity);

#endif
