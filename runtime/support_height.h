/* A heightfield as a support: bilinear heights, the vertical distance scaled down by a cosine so that it never overestimates how
 * far the surface is: by that of the steepest slope anywhere, or by that of the slopes around, whichever says more.
 *
 * The local cosine c is bilinear too, and changes by at most k a metre. What lies v above or below the surface gets c v / (1 + k
 * v): that changes by at most 1 / (1 + k v)^2 a metre for v and k v / (1 + k v) for c, together no more than 1, and by c at the
 * surface. C v, with C the least of all cosines, changes by no more than 1 either, and so does the larger of both. */
#ifndef SCREE_SUPPORT_HEIGHT_H
#define SCREE_SUPPORT_HEIGHT_H

#include "support_share.h"

#define HEIGHT_COSINE 255
#define HEIGHT_BEND 4 /* steps of 1 / HEIGHT_COSINE from sample to sample, at most */

typedef struct support_height {
  support_share share;
  float* heights; /* width * depth, row-major, x fastest */
  uint32_t width, depth;
  float inverse_spacing;
  float middle_u, middle_v; /* sample coordinates of x = z = 0 */
  float extent_x, extent_z; /* half extents, metres */
  float cosine;             /* C: 1 / sqrt(1 + steepest slope squared) */
  float bend;               /* k */
  float local;              /* farther above or below than this the local cosine says less than C */
  uint32_t* cosines;        /* c at the corners of the cell that starts at each sample, a byte each, times HEIGHT_COSINE */
  float lowest, highest;    /* of all heights */
} support_height;

/* Copies and measures; the shape was checked. NULL when out of memory. */
support_height* scree_rt_support_height_create(const scree_shape* shape, support_key key, const scree_allocator* allocator);
void scree_rt_support_height_drop(support_height* grid); /* NULL is allowed */

#endif
