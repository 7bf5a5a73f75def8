/* Random supports for property tests. */
#ifndef RANDOM_SUPPORT_H
#define RANDOM_SUPPORT_H

#include <scree/support.h>

#include "synthetic_field.h"

enum { RANDOM_MAX_SHAPES = 192, RANDOM_MAX_LEAVES = 24 };

/* A description and everything it points at; must not be moved while it is in use. */
typedef struct random_support {
  scree_support_desc desc;
  scree_shape shapes[RANDOM_MAX_SHAPES];
  uint32_t children[RANDOM_MAX_SHAPES * 4];
  struct { /* of each leaf */
    float heights[24 * 24];
    float mesh_positions[3 * 16];
    float wave[2];
    float points[3 * 16], radii[16]; /* of curves, polygons and balls */
  } data[RANDOM_MAX_LEAVES];
  uint32_t mesh_indices[3 * 32];
} random_support;

/* One leaf of this kind (any leaf when kind is a group) within about `reach` metres of the origin; half-spaces and patterns are
 * endless. */
void random_leaf(random_support* s, random_stream* r, scree_shape_kind kind, double reach);

/* A tree of `leaves` leaves (at most RANDOM_MAX_LEAVES), random groups and noise. Endless leaves are cut by a box, they or the
 * whole. */
void random_tree(random_support* s, random_stream* r, uint32_t leaves, double reach);

/* A random unit quaternion. */
void random_rotation(random_stream* r, float q[4]);

#endif
