/* What the kernels of supports share: points in vectors. */
#ifndef SCREE_SUPPORT_VECTORS_H
#define SCREE_SUPPORT_VECTORS_H

#include "simd.h"
#include "support_program.h"

typedef struct vpoint {
  vfloat x, y, z;
} vpoint;

static inline vfloat dot3(vfloat ax, vfloat ay, vfloat az, const float b[3]) {
  return ax * v_set(b[0]) + ay * v_set(b[1]) + az * v_set(b[2]);
}

static inline vfloat length2(vfloat x, vfloat y) {
  return v_sqrt(x * x + y * y);
}
static inline vfloat length3(vfloat x, vfloat y, vfloat z) {
  return v_sqrt(x * x + y * y + z * z);
}

static inline vpoint minus(vpoint p, const float c[3]) {
  return (vpoint){p.x - v_set(c[0]), p.y - v_set(c[1]), p.z - v_set(c[2])};
}

static inline vpoint into_frame(const op_frame* f, vpoint p) {
  vpoint q = minus(p, f->centre);
  return (vpoint){dot3(q.x, q.y, q.z, f->rows[0]), dot3(q.x, q.y, q.z, f->rows[1]), dot3(q.x, q.y, q.z, f->rows[2])};
}

/* Distance from an axis and height along it. */
static inline vfloat off_axis(vpoint q, const float axis[3], vfloat* height) {
  *height = dot3(q.x, q.y, q.z, axis);
  return length3(q.x - *height * v_set(axis[0]), q.y - *height * v_set(axis[1]), q.z - *height * v_set(axis[2]));
}

#endif
