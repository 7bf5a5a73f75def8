/* A heightfield as a support: bilinear heights, the signed distance scaled down by the steepest slope so that it never
 * overestimates how far the surface is. */
#ifndef SCREE_SUPPORT_HEIGHT_H
#define SCREE_SUPPORT_HEIGHT_H

#include <scree/support.h>

typedef struct support_height {
  float* heights; /* width * depth, row-major, x fastest */
  uint32_t width, depth;
  float inverse_spacing;
  float middle_u, middle_v; /* sample coordinates of x = z = 0 */
  float extent_x, extent_z; /* half extents, metres */
  float middle, half;       /* the layer is |y - height - middle| <= half */
  float cosine;             /* 1 / sqrt(1 + steepest slope squared) */
  float lowest, highest;    /* of all heights */
} support_height;

/* Copies and measures; desc was checked. Returns SCREE_OK or OUT_OF_MEMORY, then with nothing left to release. */
scree_result scree_rt_support_height_create(support_height* grid, const scree_shape* shape, const scree_allocator* allocator);
void scree_rt_support_height_destroy(support_height* grid, const scree_allocator* allocator);

#endif
