/* The space of a pattern of seeds, where distances are plain: its y axis lies along `up`, and cells are stretched along its axes.
 * Seeds are laid in it and cells are measured in it, so that both must turn x and z by the same angle: by the shortest turn that
 * brings +Y to `up`. */
#ifndef SCREE_SHARD_SPACE_H
#define SCREE_SHARD_SPACE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

typedef struct shard_space {
  double axis[3][3]; /* unit: the pattern's x, y, z in the solid's space */
  double stretch[3];
  bool is_plain; /* nothing is turned or stretched: points keep every bit */
} shard_space;

/* up: NULL or all zero = +Y; stretch: NULL or all zero = 1, 1, 1. False where a number is not finite, `up` too short or long to
 * have a direction, or a stretch not 0.01..100. */
static inline bool shard_space_make(const double* up, const double* stretch, shard_space* out) {
  double y[3] = {0, 1, 0};
  if (up != NULL && (up[0] != 0 || up[1] != 0 || up[2] != 0)) {
    const double length = sqrt(up[0] * up[0] + up[1] * up[1] + up[2] * up[2]);
    if (!(length > 1e-12 && length < 1e12)) return false;
    for (int a = 0; a < 3; ++a) y[a] = up[a] / length;
  }
  static const double even[3] = {1, 1, 1};
  const double* given = stretch != NULL && (stretch[0] != 0 || stretch[1] != 0 || stretch[2] != 0) ? stretch : even;
  for (int a = 0; a < 3; ++a) {
    out->stretch[a] = given[a];
    if (!(out->stretch[a] >= 0.01 && out->stretch[a] <= 100)) return false;
    out->axis[1][a] = y[a];
  }
  const double c = 1 + y[1];
  if (c < 1e-9) { /* upside down: half a turn round x */
    const double turned[3][3] = {{1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
    for (int i = 0; i < 3; ++i)
      for (int a = 0; a < 3; ++a) out->axis[i][a] = turned[i][a];
  } else {
    const double x[3] = {1 - y[0] * y[0] / c, -y[0], -y[0] * y[2] / c}, z[3] = {x[2], -y[2], 1 - y[2] * y[2] / c};
    for (int a = 0; a < 3; ++a) out->axis[0][a] = x[a], out->axis[2][a] = z[a];
  }
  out->is_plain = y[1] == 1 && out->stretch[0] == 1 && out->stretch[1] == 1 && out->stretch[2] == 1;
  return true;
}

static inline void shard_space_into(const shard_space* space, const double p[3], double out[3]) {
  double q[3] = {p[0], p[1], p[2]};
  if (!space->is_plain)
    for (int i = 0; i < 3; ++i)
      q[i] = (space->axis[i][0] * p[0] + space->axis[i][1] * p[1] + space->axis[i][2] * p[2]) / space->stretch[i];
  for (int i = 0; i < 3; ++i) out[i] = q[i];
}

static inline void shard_space_out_of(const shard_space* space, const double q[3], double out[3]) {
  double p[3] = {q[0], q[1], q[2]};
  if (!space->is_plain)
    for (int a = 0; a < 3; ++a) {
      p[a] = 0;
      for (int i = 0; i < 3; ++i) p[a] += space->axis[i][a] * (q[i] * space->stretch[i]);
    }
  for (int a = 0; a < 3; ++a) out[a] = p[a];
}

#endif
