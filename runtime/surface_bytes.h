/* The 4 bytes that the vertices of models and cliffs have in blobs: material, durability, curvature + 128, smoothing group. The
 * bias keeps neighbouring values near one another, which is what Draco predicts from. */
#ifndef SCREE_SURFACE_BYTES_H
#define SCREE_SURFACE_BYTES_H

#include <scree/pack.h>

/* Curvature has no -128. Only cliffs have cut faces, and more than one group. */
static inline bool scree_rt_surface_is_sound(const uint8_t bytes[4], bool cliff) {
  return (bytes[0] & 15) <= (cliff ? 2 : 1) && bytes[2] > 0 && (cliff || bytes[3] == 0);
}

static inline void scree_rt_surface_decode(const uint8_t bytes[4], scree_vertex* out) {
  out->material = bytes[0];
  out->durability = bytes[1];
  out->curvature = (int8_t)(bytes[2] - 128);
}

#endif
