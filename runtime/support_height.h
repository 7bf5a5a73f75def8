/* A heightfield as a support: bilinear heights, the signed distance scaled down by the steepest slope so that it never
 * overestimates how far the surface is. */
#ifndef SCREE_SUPPORT_HEIGHT_H
#define SCREE_SUPPORT_HEIGHT_H

#include "support_share.h"

typedef struct support_height {
  support_share share;
  float* heights; /* width * depth, row-major, x fastest */
  uint32_t width, depth;
  float inverse_spacing;
  float middle_u, middle_v; /* sample coordinates of x = z = 0 */
  float extent_x, extent_z; /* half extents, metres */
  float cosine;             /* 1 / sqrt(1 + steepest slope squared) */
  float lowest, highest;    /* of all heights */
} support_height;

/* Copies and measures; the shape was checked. NULL when out of memory. */
support_height* scree_rt_support_height_create(const scree_shape* shape, support_key key, const scree_allocator* allocator);
void scree_rt_support_height_drop(support_height* grid); /* NULL is allowed */

#endif
