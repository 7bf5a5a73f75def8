/* Convex hulls of the blocks that fall. */
#ifndef SCREE_RUBBLE_HULL_H
#define SCREE_RUBBLE_HULL_H

#include <stdbool.h>
#include <stdint.h>

enum { HULL_POINTS = 48, HULL_TRIANGLES = 2 * HULL_POINTS - 4, HULL_FACES = 12 };

/* A face that the hull can lie on: the place nearest its centre of mass is in it. */
typedef struct hull_face {
  double normal[3]; /* unit, outward */
  double area;
} hull_face;

typedef struct rubble_hull {
  double points[HULL_POINTS][3]; /* relative to the centre of mass */
  uint8_t triangles[HULL_TRIANGLES][3];
  hull_face faces[HULL_FACES]; /* the largest, falling */
  uint32_t point_count, triangle_count, face_count;
  double size;      /* mean of the sides of its box */
  double radius;    /* of the farthest point */
  double thickness; /* between the two nearest planes that it fits in, one along a face */
} rubble_hull;

/* The hull of points, 3 doubles each, relative to the centre of mass; of many, of those that are farthest out in enough directions.
 * Returns false where they lie in a plane. */
bool rubble_hull_make(const double* points, uint32_t count, rubble_hull* out);

#endif
