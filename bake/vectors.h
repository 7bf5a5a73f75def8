/* Vectors of three doubles. */
#ifndef SCREE_VECTORS_H
#define SCREE_VECTORS_H

#include <stdbool.h>
#include <stddef.h>

static inline double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void cross(const double a[3], const double b[3], double out[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

/* The box of points, 3 each; count > 0. */
static inline void points_bounds(const double* points, size_t count, double min[3], double max[3]) {
  for (size_t axis = 0; axis < 3; ++axis) min[axis] = max[axis] = points[axis];
  for (size_t i = 1; i < count; ++i)
    for (size_t axis = 0; axis < 3; ++axis) {
      const double x = points[3 * i + axis];
      if (x < min[axis]) min[axis] = x;
      if (x > max[axis]) max[axis] = x;
    }
}

/* Whether two boxes have a point in common. */
static inline bool boxes_meet(const double a_min[3], const double a_max[3], const double b_min[3], const double b_max[3]) {
  for (int k = 0; k < 3; ++k)
    if (a_min[k] > b_max[k] || b_min[k] > a_max[k]) return false;
  return true;
}

#endif
