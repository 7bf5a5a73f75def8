#include "creases.h"

#include <math.h>
#include <string.h>

#include "allocator.h"
#include "disjoint_sets.h"
#include "triangle_sides.h"
#include "vectors.h"

/* Twice the area vector. */
static void area_vector(const scree_solid* solid, uint32_t triangle, double out[3]) {
  const uint32_t* c = solid->indices + (size_t)3 * triangle;
  const double *p = solid->positions + (size_t)3 * c[0], *q = solid->positions + (size_t)3 * c[1],
               *r = solid->positions + (size_t)3 * c[2];
  for (uint32_t a = 0; a < 3; ++a) {
    const uint32_t u = (a + 1) % 3, v = (a + 2) % 3;
    out[a] = (q[u] - p[u]) * (r[v] - p[v]) - (q[v] - p[v]) * (r[u] - p[u]);
  }
}

/* An edge is smooth if it has just two triangles, whose normals are near each other. what: joined over it, the corners at its ends,
 * or the triangles. */
typedef enum joined { CORNERS, TRIANGLES } joined;

static void join_over_edges(const scree_solid* solid, const triangle_side* sides, joined what, uint32_t* parents) {
  const uint32_t count = solid->triangle_count * 3;
  for (uint32_t i = 0; i < count;) {
    uint32_t end = i + 1;
    while (end < count && sides[end].low == sides[i].low && sides[end].high == sides[i].high) ++end;
    if (end == i + 2) {
      const uint32_t a = sides[i].corner, b = sides[i + 1].corner;
      double m[3], n[3];
      area_vector(solid, a / 3, m);
      area_vector(solid, b / 3, n);
      if (dot(m, n) >= CREASE_COSINE * (sqrt(dot(m, m)) * sqrt(dot(n, n)))) {
        const bool along = solid->indices[a] == solid->indices[b];
        if (what == TRIANGLES) {
          join(parents, a / 3, b / 3);
        } else {
          join(parents, a, along ? b : next_corner(b));
          join(parents, next_corner(a), along ? next_corner(b) : b);
        }
      }
    }
    i = end;
  }
}

static void add_normals(const scree_solid* solid, uint32_t* parents, double* normals) {
  const uint32_t corners = solid->triangle_count * 3;
  memset(normals, 0, (size_t)3 * corners * sizeof *normals);
  for (uint32_t c = 0; c < corners; ++c) {
    double n[3], *sum = normals + (size_t)3 * root_of(parents, c);
    area_vector(solid, c / 3, n);
    for (uint32_t a = 0; a < 3; ++a) sum[a] += n[a];
  }
  /* The root of a group is its lowest corner: all others take its sum before it is made unit. */
  for (uint32_t c = corners; c-- > 0;) {
    double* n = normals + (size_t)3 * c;
    memcpy(n, normals + (size_t)3 * root_of(parents, c), 3 * sizeof *n);
    const double length = sqrt(dot(n, n));
    for (uint32_t a = 0; a < 3; ++a) n[a] = length > 0 ? n[a] / length : a == 1;
  }
}

/* Joins what smooth edges join. parents: one a corner. */
static scree_result find_smooth(const scree_solid* solid, joined what, const scree_allocator* allocator, uint32_t* parents) {
  const uint32_t corners = solid->triangle_count * 3;
  triangle_side* sides = scree_rt_allocate(allocator, corners, sizeof *sides);
  if (sides == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  triangle_sides_sort(solid->indices, solid->triangle_count, sides);
  for (uint32_t c = 0; c < corners; ++c) parents[c] = c;
  join_over_edges(solid, sides, what, parents);
  scree_rt_release(allocator, sides, corners, sizeof *sides);
  return SCREE_OK;
}

scree_result crease_normals(const scree_solid* solid, const scree_allocator* allocator, double* normals) {
  const uint32_t corners = solid->triangle_count * 3;
  uint32_t* parents = scree_rt_allocate(allocator, corners, sizeof *parents);
  const scree_result result = parents != NULL ? find_smooth(solid, CORNERS, allocator, parents) : SCREE_ERROR_OUT_OF_MEMORY;
  if (result == SCREE_OK) add_normals(solid, parents, normals);
  scree_rt_release(allocator, parents, corners, sizeof *parents);
  return result;
}

scree_result crease_charts(const scree_solid* solid, const scree_allocator* allocator, uint32_t* charts) {
  const uint32_t corners = solid->triangle_count * 3;
  uint32_t* parents = scree_rt_allocate(allocator, corners, sizeof *parents);
  const scree_result result = parents != NULL ? find_smooth(solid, TRIANGLES, allocator, parents) : SCREE_ERROR_OUT_OF_MEMORY;
  for (uint32_t t = 0; result == SCREE_OK && t < solid->triangle_count; ++t) charts[t] = root_of(parents, t);
  scree_rt_release(allocator, parents, corners, sizeof *parents);
  return result;
}
