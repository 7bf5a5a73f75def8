/* Random supports for property tests. */
#ifndef RANDOM_SUPPORT_H
#define RANDOM_SUPPORT_H

#include <scree/support.h>

#include "synthetic_field.h"

enum { RANDOM_MAX_SHAPES = 192, RANDOM_MAX_LEAVES = 24 };

/* What one leaf points at. */
typedef struct random_leaf_data {
  float heights[24 * 24];
  float mesh_positions[3 * 16];
  uint32_t mesh_indices[3 * 32];
  float wave[2];
  float points[3 * 16], radii[16]; /* of curves, polygons and balls */
} random_leaf_data;

/* A description and everything it points at; must not be moved while it is in use. */
typedef struct random_support {
  scree_support_desc desc;
  scree_shape shapes[RANDOM_MAX_SHAPES];
  uint32_t children[RANDOM_MAX_SHAPES * 4];
  random_leaf_data data[RANDOM_MAX_LEAVES];
} random_support;

/* One leaf of this kind (any leaf when kind is a group) within about `reach` metres of the origin; half-spaces and patterns are
 * endless. */
void random_leaf(random_support* s, random_stream* r, scree_shape_kind kind, double reach);

/* A tree of `leaves` leaves (at most RANDOM_MAX_LEAVES), random groups and noise. Endless leaves are cut by a box, they or the
 * whole. */
void random_tree(random_support* s, random_stream* r, uint32_t leaves, double reach);

/* Clusters of shapes of all kinds, groups and noise, about ten shapes each, within `reach` metres of places `spread` metres around
 * the origin and `spread` / 4 above and below; united. */
typedef struct random_grove {
  scree_support_desc desc;
  scree_shape* shapes;
  uint32_t* children;
  random_leaf_data* data;
} random_grove;

random_grove random_grove_create(random_stream* r, uint32_t clusters, double reach, double spread);
void random_grove_destroy(random_grove* grove);

/* A random unit quaternion. */
void random_rotation(random_stream* r, float q[4]);

#endif
