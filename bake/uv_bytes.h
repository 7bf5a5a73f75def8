/* UVs as packs hold them: 16 bits over one range for the whole pack. */
#ifndef SCREE_UV_BYTES_H
#define SCREE_UV_BYTES_H

#include "rock_set.h"

/* The nearest of the 65536 values; what lies outside the range, or is no number, goes to an end of it. */
static inline uint16_t uv_value(float place, float min, float max) {
  const double width = (double)max - (double)min, at = width > 0 ? ((double)place - (double)min) / width : 0;
  return at > 0 ? (uint16_t)((at < 1 ? at : 1) * 65535 + 0.5) : 0;
}

static inline void uv_values(const lattice_mesh* mesh, uint32_t vertex, uint16_t out[2]) {
  for (int axis = 0; axis < 2; ++axis)
    out[axis] = uv_value(mesh->uvs[vertex][axis], mesh->uv_bounds.min[axis], mesh->uv_bounds.max[axis]);
}

#endif
