/* Boxes of a grid that a solid reaches, or comes near to: where seeds are of any use. Never too few, sometimes one too many. */
#ifndef SCREE_SEED_MASK_H
#define SCREE_SEED_MASK_H

#include "solid_inside.h"

typedef struct seed_mask {
  double min[3], step; /* boxes are cubes */
  uint32_t size[3];
  uint8_t* marked; /* x fastest: 0 = out of reach, 1 = near or inside */
} seed_mask;

/* How far from the surface boxes still count, of a point; must not be more than `most` below. */
typedef double (*seed_reach)(const void* user, const double p[3]);

typedef struct seed_mask_desc {
  const double* positions; /* 3 * vertex_count */
  const uint32_t* indices;
  const solid_inside* inside; /* of the same arrays; NULL: a shell without inside */
  uint32_t vertex_count, triangle_count;
  double step;      /* wanted; larger where there would be too many boxes */
  double most;      /* reach at most */
  seed_reach reach; /* NULL: `most` everywhere */
  const void* user;
} seed_mask_desc;

/* Returns SCREE_OK or OUT_OF_MEMORY. */
scree_result seed_mask_create(const seed_mask_desc* desc, const scree_allocator* allocator, seed_mask* out);
void seed_mask_free(seed_mask* mask, const scree_allocator* allocator); /* all zero is allowed */

bool seed_mask_has(const seed_mask* mask, const double p[3]);

/* Squared distance of a point to a triangle, one without area included. */
double mask_triangle_distance2(const double p[3], const double a[3], const double b[3], const double c[3]);

#endif
