/* What a path of water draws, in operations that repeat to the bit; the twin in tests/ draws the same.
 *
 * A path draws, in this order: which rain, where there are several that meet a link; a direction in its cone, where it has a
 * spread; pairs of a proposed link and whether it is taken. Then on each link: whether it is broken by force, where its life is
 * within break_life; whether the rest of the water is absorbed, where there is a rest; and where it goes on, if anywhere. */
#ifndef SCREE_FROST_DRAW_H
#define SCREE_FROST_DRAW_H

#include "frost_internal.h"

enum {
  FROST_SKIES = 64,    /* directions that may meet nothing before a path gives up */
  FROST_PROPOSALS = 64 /* links that may be refused before all are weighed */
};

/* The direction towards which this path's rain is seen to come: uniform on the cap of the rain's cone. */
static inline void frost_draw_direction(const frost_rain* rain, random_stream* stream, double out[3]) {
  if (rain->cap == 0) {
    for (int a = 0; a < 3; ++a) out[a] = rain->axis[a];
    return;
  }
  const double down = rain->cap * random_unit(stream); /* 1 - cosine is uniform: Archimedes */
  double u, v, length2;
  do {
    u = 2 * random_unit(stream) - 1;
    v = 2 * random_unit(stream) - 1;
    length2 = u * u + v * v;
  } while (length2 > 1 || length2 < 1e-6);
  const double along = 1 - down, across2 = down * (2 - down);
  const double across = sqrt((across2 > 0 ? across2 : 0) / length2);
  for (int a = 0; a < 3; ++a) out[a] = along * rain->axis[a] + across * (u * rain->side[a] + v * rain->other[a]);
}

/* normal . direction of a link, its normal out of the rock. */
static inline double frost_facing(const scree_link* link, bool first_stands, const double direction[3]) {
  const double* n = link->normal;
  const double dot = n[0] * direction[0] + n[1] * direction[1] + n[2] * direction[2];
  return first_stands ? dot : -dot;
}

/* The integer weight of an exterior link: at least scale * area * the best cosine that the rain's cone has to offer. */
static inline uint64_t frost_weight(const frost_rain* rain, const scree_link* link, bool first_stands, double scale) {
  const double cosine = frost_facing(link, first_stands, rain->axis);
  double best = 1;
  if (cosine < rain->cosine) { /* that of the angle to the axis less the spread */
    const double sine2 = 1 - cosine * cosine;
    best = cosine * rain->cosine + sqrt(sine2 > 0 ? sine2 : 0) * rain->sine;
  }
  best += 1e-12; /* more than the error of cosines */
  return best > 2e-12 ? (uint64_t)ceil(scale * link->area * best) : 0;
}

/* What of a weight a direction takes. */
static inline double frost_share(const scree_link* link, bool first_stands, const double direction[3], double scale) {
  const double facing = frost_facing(link, first_stands, direction);
  return facing > 0 ? scale * link->area * facing : 0;
}

/* Uniform in 0 .. total - 1; total <= 2^52. */
static inline uint64_t frost_draw_below(random_stream* stream, uint64_t total) {
  return (uint64_t)(random_unit(stream) * (double)total);
}

#endif
