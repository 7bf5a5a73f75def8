/* Vertices with one fan of triangles each. */
#include <math.h>

#include "allocator.h"
#include "disjoint_sets.h"
#include "mesh_simplify.h"
#include "triangle_sides.h"
#include "vectors.h"

/* From a side of triangle `from` through the rock to triangle `to`, as a number that rises with the angle: 0..4. */
static double turn_between(const double* positions, const uint32_t* flat, uint32_t from, uint32_t to) {
  const double *a = positions + (size_t)3 * flat[from], *b = positions + (size_t)3 * flat[next_corner(from)];
  const double *p = positions + (size_t)3 * flat[next_corner(next_corner(from))],
               *q = positions + (size_t)3 * flat[next_corner(next_corner(to))];
  double edge[3], to_p[3], to_q[3], out[3], ahead[3];
  for (uint32_t k = 0; k < 3; ++k) edge[k] = b[k] - a[k], to_p[k] = p[k] - a[k], to_q[k] = q[k] - a[k];
  cross(edge, to_p, out);  /* away from the rock */
  cross(out, edge, ahead); /* into the triangle */
  const double out_length = sqrt(dot(out, out)), ahead_length = sqrt(dot(ahead, ahead));
  const double x = ahead_length > 0 ? dot(to_q, ahead) / ahead_length : 0, y = out_length > 0 ? -dot(to_q, out) / out_length : 0;
  const double size = fabs(x) + fabs(y);
  if (size == 0) return 0;
  const double part = x / size; /* 1..-1..1 over the whole turn */
  return y >= 0 ? 1 - part : 3 + part;
}

/* The sides at one edge in pairs, each rising one with a falling one. */
static bool pair_sides(const double* positions, const uint32_t* flat, triangle_side* sides, uint32_t count, uint32_t* parents) {
  uint32_t rising = 0;
  for (uint32_t i = 0; i < count; ++i) rising += sides[i].rising;
  if (2 * rising != count) return false;
  for (uint32_t i = 0; i < count; ++i) {
    if (!sides[i].rising) continue;
    uint32_t best = count;
    double least = INFINITY;
    for (uint32_t k = 0; k < count; ++k) {
      if (sides[k].rising || sides[k].corner == UINT32_MAX) continue;
      const double turn = count > 2 ? turn_between(positions, flat, sides[i].corner, sides[k].corner) : 0;
      if (turn < least) least = turn, best = k;
    }
    const uint32_t a = sides[i].corner, b = sides[best].corner;
    join(parents, a, next_corner(b));
    join(parents, next_corner(a), b);
    sides[best].corner = UINT32_MAX;
  }
  return true;
}

scree_result mesh_split_fans(const double* positions, uint32_t (*corners)[3], uint32_t triangle_count,
                             const scree_allocator* allocator, uint32_t* vertex_of, uint32_t* vertex_count) {
  const uint32_t count = 3 * triangle_count;
  uint32_t* flat = corners[0];
  triangle_side* sides = scree_rt_allocate(allocator, count, sizeof *sides);
  uint32_t* parents = scree_rt_allocate(allocator, count, sizeof *parents);
  scree_result result = sides != NULL && parents != NULL ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
  if (result == SCREE_OK) triangle_sides_sort(flat, triangle_count, sides);
  for (uint32_t c = 0; result == SCREE_OK && c < count; ++c) parents[c] = c;
  for (uint32_t i = 0; result == SCREE_OK && i < count;) {
    uint32_t end = i + 1;
    while (end < count && sides[end].low == sides[i].low && sides[end].high == sides[i].high) ++end;
    if (!pair_sides(positions, flat, sides + i, end - i, parents)) result = SCREE_ERROR_INVALID_ARGUMENT;
    i = end;
  }
  if (result == SCREE_OK) {
    /* A root is the lowest corner of its fan: it gets its number before the others ask for it. */
    *vertex_count = 0;
    for (uint32_t c = 0; c < count; ++c) {
      const uint32_t root = root_of(parents, c), old = flat[c];
      if (root == c) {
        vertex_of[*vertex_count] = old;
        flat[c] = (*vertex_count)++;
      } else {
        flat[c] = flat[root];
      }
    }
  }
  scree_rt_release(allocator, sides, count, sizeof *sides);
  scree_rt_release(allocator, parents, count, sizeof *parents);
  return result;
}
