/* Convex solids with seeds in them, for tests and benchmarks of shards. */
#ifndef CONVEX_SOLIDS_H
#define CONVEX_SOLIDS_H

#include <scree/shards.h>

#include <math.h>

#include "random.h"

enum { HILL_SIDES = 24, HILL_RINGS = 4, HILL_VERTICES = HILL_SIDES * HILL_RINGS, HILL_PLANES = 3 * HILL_SIDES + 2 };
enum { HILL_TRIANGLES = 2 * 3 * HILL_SIDES + 2 * (HILL_SIDES - 2) };

typedef struct convex_solid {
  double positions[3 * HILL_VERTICES];
  uint32_t indices[3 * HILL_TRIANGLES];
  double planes[HILL_PLANES][4]; /* the hill's: normal and offset */
  scree_solid solid;
} convex_solid;

/* A box from 0 to `size`; planes are not set. */
static inline void make_convex_box(convex_solid* out, const double size[3]) {
  static const uint32_t faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (uint32_t i = 0; i < 8; ++i)
    for (uint32_t axis = 0; axis < 3; ++axis) out->positions[3 * i + axis] = (i >> axis & 1) ? size[axis] : 0;
  for (uint32_t f = 0; f < 6; ++f) {
    static const uint32_t fan[6] = {0, 1, 2, 0, 2, 3};
    for (uint32_t k = 0; k < 6; ++k) out->indices[6 * f + k] = faces[f][fan[k]];
  }
  out->solid = (scree_solid){.positions = out->positions, .indices = out->indices, .vertex_count = 8, .triangle_count = 12};
}

/* Three rings of 24 planes, a top and a base. All corners between rings have four walls. */
static inline void make_hill(convex_solid* out) {
  static const double radii[HILL_RINGS] = {1, 0.9, 0.65, 0.3}, heights[HILL_RINGS] = {0, 0.35, 0.7, 0.9};
  /* A turn of 15 degrees, repeated: libm's cosine is not the same everywhere. */
  const double cosine = repeatable_cos(0.26179938779914943654), sine = sqrt(1 - cosine * cosine);
  double x = 1, z = 0;
  for (uint32_t i = 0; i < HILL_SIDES; ++i) {
    for (uint32_t ring = 0; ring < HILL_RINGS; ++ring) {
      double* p = out->positions + 3 * (ring * HILL_SIDES + i);
      p[0] = radii[ring] * x;
      p[1] = heights[ring];
      p[2] = radii[ring] * z;
    }
    const double turned = x * cosine - z * sine;
    z = x * sine + z * cosine;
    x = turned;
  }
  uint32_t* index = out->indices;
  for (uint32_t ring = 0; ring < 3; ++ring)
    for (uint32_t i = 0; i < HILL_SIDES; ++i) {
      const uint32_t a = ring * HILL_SIDES + i, b = ring * HILL_SIDES + (i + 1) % HILL_SIDES, c = a + HILL_SIDES,
                     d = b + HILL_SIDES;
      const uint32_t quad[6] = {a, c, b, b, c, d};
      for (uint32_t k = 0; k < 6; ++k) *index++ = quad[k];
    }
  for (uint32_t i = 1; i + 1 < HILL_SIDES; ++i) {
    const uint32_t top = 3 * HILL_SIDES, fans[6] = {0, i, i + 1, top, top + i + 1, top + i};
    for (uint32_t k = 0; k < 6; ++k) *index++ = fans[k];
  }
  out->solid = (scree_solid){
      .positions = out->positions, .indices = out->indices, .vertex_count = HILL_VERTICES, .triangle_count = HILL_TRIANGLES};
  for (uint32_t wall = 0; wall < HILL_PLANES; ++wall) {
    /* The first triangle of each plane. */
    const uint32_t t = wall < 3 * HILL_SIDES ? 2 * wall : 6 * HILL_SIDES + wall - 3 * HILL_SIDES;
    const double *a = out->positions + 3 * out->indices[3 * t], *b = out->positions + 3 * out->indices[3 * t + 1],
                 *c = out->positions + 3 * out->indices[3 * t + 2];
    const double u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    double* n = out->planes[wall];
    n[0] = u[1] * v[2] - u[2] * v[1];
    n[1] = u[2] * v[0] - u[0] * v[2];
    n[2] = u[0] * v[1] - u[1] * v[0];
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int axis = 0; axis < 3; ++axis) n[axis] /= length;
    n[3] = n[0] * a[0] + n[1] * a[1] + n[2] * a[2];
  }
}

/* Uniform in a box; with planes, only where all of them have the seed inside. */
static inline void lay_seeds(uint64_t random_seed, const double min[3], const double max[3], const double (*planes)[4],
                             uint32_t plane_count, uint32_t count, double* seeds) {
  random_stream stream = {.state = random_seed};
  for (uint32_t i = 0; i < count;) {
    double* p = seeds + 3 * (size_t)i;
    for (int axis = 0; axis < 3; ++axis) p[axis] = min[axis] + (max[axis] - min[axis]) * random_unit(&stream);
    uint32_t k = 0;
    while (k < plane_count && planes[k][0] * p[0] + planes[k][1] * p[1] + planes[k][2] * p[2] < planes[k][3]) ++k;
    i += k == plane_count;
  }
}

#endif
