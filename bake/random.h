/* Random numbers and the few functions of angles that the baker needs, in operations that repeat to the bit everywhere. */
#ifndef SCREE_RANDOM_H
#define SCREE_RANDOM_H

#include <math.h>
#include <scree/bake.h>

#include "lattice.h"

/* A stream of splitmix64 values; two streams with different keys are independent. */
typedef struct random_stream {
  uint64_t state;
} random_stream;

static inline uint64_t random_bits(random_stream* stream) {
  stream->state += UINT64_C(0x9e3779b97f4a7c15);
  return hash_mix(stream->state);
}

/* Uniform in [0, 1), a multiple of 2^-53. */
static inline double random_unit(random_stream* stream) {
  return (double)(random_bits(stream) >> 11) * 0x1p-53;
}

static inline double random_in(random_stream* stream, scree_range range) {
  return range.min + (range.max - range.min) * random_unit(stream);
}

/* A uniform direction on the unit sphere: rejection from the cube, so that no sine or cosine is needed. */
static inline void random_direction(random_stream* stream, double out[3]) {
  for (;;) {
    double length2 = 0;
    for (int axis = 0; axis < 3; ++axis) {
      out[axis] = 2 * random_unit(stream) - 1;
      length2 += out[axis] * out[axis];
    }
    if (length2 > 1 || length2 < 1e-6) continue;
    double inverse = 1 / sqrt(length2);
    for (int axis = 0; axis < 3; ++axis) out[axis] *= inverse;
    return;
  }
}

/* cos(x) for 0 <= x <= pi / 2 to 1e-14, by its series: libm's cos differs between systems. */
static inline double repeatable_cos(double x) {
  double term = 1, sum = 1;
  for (int k = 1; k <= 12; ++k) {
    term *= -x * x / ((2 * k - 1) * (2 * k));
    sum += term;
  }
  return sum;
}

/* cos(x) for 0 <= x <= pi. */
static inline double repeatable_cos_to_pi(double x) {
  const double pi = 3.14159265358979323846;
  return x <= pi / 2 ? repeatable_cos(x) : -repeatable_cos(pi - x > 0 ? pi - x : 0);
}

/* The cube root by Newton's method, from above; 0 where x is not above 0. */
static inline double repeatable_cube_root(double x) {
  if (!(x > 0)) return 0;
  double root = 1;
  while (root * root * root < x) root *= 2;
  while (root * root * root > x * 8) root *= 0.5;
  for (int k = 0; k < 40; ++k) {
    const double better = (2 * root + x / (root * root)) / 3;
    if (better >= root) break;
    root = better;
  }
  return root;
}

#endif
