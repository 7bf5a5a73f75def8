/* The incremental hull over whole numbers: what is above a plane is decided exactly, so that points in one plane, of which boxes
 * and columns are full, need no tolerance. */
#include "rubble_hull.h"

#include <math.h>
#include <string.h>

#include "random.h"

#define GRID 0x1p18 /* determinants of differences of such numbers stay below 2^62 */

typedef struct whole {
  int64_t at[3];
} whole;

/* 6 times the volume below p: > 0 where p is above the triangle. */
static int64_t above(const whole* points, const uint8_t t[3], uint32_t p) {
  int64_t a[3], b[3], c[3];
  for (int axis = 0; axis < 3; ++axis) {
    a[axis] = points[t[1]].at[axis] - points[t[0]].at[axis];
    b[axis] = points[t[2]].at[axis] - points[t[0]].at[axis];
    c[axis] = points[p].at[axis] - points[t[0]].at[axis];
  }
  return (a[1] * b[2] - a[2] * b[1]) * c[0] + (a[2] * b[0] - a[0] * b[2]) * c[1] + (a[0] * b[1] - a[1] * b[0]) * c[2];
}

/* Keeps the points that are farthest in fixed directions. */
static uint32_t choose(const double* points, uint32_t count, double (*out)[3]) {
  uint32_t kept = 0, chosen[HULL_POINTS] = {0};
  random_stream stream = {1};
  for (uint32_t d = 0; d < 4 * HULL_POINTS && kept < HULL_POINTS; ++d) {
    double direction[3] = {0, 0, 0};
    if (d < 6)
      direction[d / 2] = d % 2 ? -1 : 1;
    else
      random_direction(&stream, direction);
    uint32_t best = 0;
    double most = -INFINITY;
    for (uint32_t i = 0; i < count; ++i) {
      const double* p = points + 3 * (size_t)i;
      const double far = p[0] * direction[0] + p[1] * direction[1] + p[2] * direction[2];
      if (far > most) {
        most = far;
        best = i;
      }
    }
    bool known = false;
    for (uint32_t k = 0; k < kept && !known; ++k) known = chosen[k] == best;
    if (known) continue;
    memcpy(out[kept], points + 3 * (size_t)best, sizeof out[kept]);
    chosen[kept++] = best;
  }
  return kept;
}

/* A first tetrahedron, as far apart as can be had simply; its points' numbers. */
static bool first_four(const whole* points, uint32_t count, uint8_t out[4]) {
  uint32_t a = 0, b = 0, c = 0, d = 0;
  int64_t most = -1;
  for (uint32_t i = 1; i < count; ++i)
    if (points[i].at[0] < points[a].at[0]) a = i;
  for (uint32_t i = 0; i < count; ++i) {
    int64_t square = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const int64_t side = points[i].at[axis] - points[a].at[axis];
      square += side * side;
    }
    if (square > most) {
      most = square;
      b = i;
    }
  }
  double widest = 0;
  for (uint32_t i = 0; i < count; ++i) {
    double u[3], v[3];
    for (int axis = 0; axis < 3; ++axis) {
      u[axis] = (double)(points[b].at[axis] - points[a].at[axis]);
      v[axis] = (double)(points[i].at[axis] - points[a].at[axis]);
    }
    const double x = u[1] * v[2] - u[2] * v[1], y = u[2] * v[0] - u[0] * v[2], z = u[0] * v[1] - u[1] * v[0];
    if (x * x + y * y + z * z > widest) {
      widest = x * x + y * y + z * z;
      c = i;
    }
  }
  if (!(widest > 0)) return false;
  const uint8_t base[3] = {(uint8_t)a, (uint8_t)b, (uint8_t)c};
  int64_t highest = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const int64_t height = above(points, base, i);
    if ((height < 0 ? -height : height) > (highest < 0 ? -highest : highest)) {
      highest = height;
      d = i;
    }
  }
  if (highest == 0) return false;
  out[0] = (uint8_t)a;
  out[1] = (uint8_t)(highest > 0 ? c : b); /* turned so that d is below a, [1], [2] */
  out[2] = (uint8_t)(highest > 0 ? b : c);
  out[3] = (uint8_t)d;
  return true;
}

/* Puts a point that is outside onto the hull: the triangles that see it go, and their border is joined to it. */
static void add_point(const whole* points, uint32_t p, rubble_hull* hull) {
  uint8_t border[2 * HULL_TRIANGLES][2];
  bool edge[HULL_POINTS][HULL_POINTS];
  uint8_t seen[HULL_TRIANGLES][3];
  uint32_t kept = 0, seen_count = 0, border_count = 0;
  for (uint32_t t = 0; t < hull->triangle_count; ++t) {
    if (above(points, hull->triangles[t], p) > 0)
      memcpy(seen[seen_count++], hull->triangles[t], 3);
    else
      memmove(hull->triangles[kept++], hull->triangles[t], 3);
  }
  if (seen_count == 0) return;
  memset(edge, 0, sizeof edge);
  for (uint32_t t = 0; t < seen_count; ++t)
    for (int e = 0; e < 3; ++e) edge[seen[t][e]][seen[t][(e + 1) % 3]] = true;
  for (uint32_t t = 0; t < seen_count; ++t)
    for (int e = 0; e < 3; ++e) {
      const uint8_t from = seen[t][e], to = seen[t][(e + 1) % 3];
      if (edge[to][from]) continue;
      border[border_count][0] = from;
      border[border_count++][1] = to;
    }
  for (uint32_t b = 0; b < border_count; ++b) {
    hull->triangles[kept][0] = border[b][0];
    hull->triangles[kept][1] = border[b][1];
    hull->triangles[kept++][2] = (uint8_t)p;
  }
  hull->triangle_count = kept;
}

/* The area vector of a triangle. */
static void area_vector(const rubble_hull* hull, const uint8_t t[3], double out[3]) {
  const double *a = hull->points[t[0]], *b = hull->points[t[1]], *c = hull->points[t[2]];
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    out[axis] = ((b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u])) / 2;
  }
}

/* Whether the centre of mass, moved along the normal into the triangle's plane, lies in it. */
static bool bears(const rubble_hull* hull, const uint8_t t[3], const double normal[3]) {
  for (int e = 0; e < 3; ++e) {
    const double *a = hull->points[t[e]], *b = hull->points[t[(e + 1) % 3]];
    const double x = (b[1] - a[1]) * -a[2] - (b[2] - a[2]) * -a[1], y = (b[2] - a[2]) * -a[0] - (b[0] - a[0]) * -a[2],
                 z = (b[0] - a[0]) * -a[1] - (b[1] - a[1]) * -a[0];
    if (x * normal[0] + y * normal[1] + z * normal[2] < 0) return false;
  }
  return true;
}

/* How far the hull reaches inwards from a face. */
static double depth_below(const rubble_hull* hull, const double normal[3], const double* on_face) {
  double deepest = 0;
  for (uint32_t p = 0; p < hull->point_count; ++p) {
    double depth = 0;
    for (int axis = 0; axis < 3; ++axis) depth += (on_face[axis] - hull->points[p][axis]) * normal[axis];
    if (depth > deepest) deepest = depth;
  }
  return deepest;
}

/* Triangles that look nearly the same way are one face. */
static void find_faces(rubble_hull* hull) {
  bool done[HULL_TRIANGLES] = {false};
  double vectors[HULL_TRIANGLES][3], areas[HULL_TRIANGLES] = {0};
  for (uint32_t t = 0; t < hull->triangle_count; ++t) {
    area_vector(hull, hull->triangles[t], vectors[t]);
    areas[t] = sqrt(vectors[t][0] * vectors[t][0] + vectors[t][1] * vectors[t][1] + vectors[t][2] * vectors[t][2]);
  }
  hull->thickness = INFINITY;
  for (uint32_t t = 0; t < hull->triangle_count; ++t) {
    if (done[t] || !(areas[t] > 0)) continue;
    hull_face face = {.area = 0};
    const double* normal = vectors[t];
    const double unit[3] = {normal[0] / areas[t], normal[1] / areas[t], normal[2] / areas[t]};
    double sum[3] = {0, 0, 0};
    bool stable = false;
    for (uint32_t k = t; k < hull->triangle_count; ++k) {
      const double* other = vectors[k];
      const double along = (other[0] * normal[0] + other[1] * normal[1] + other[2] * normal[2]) / areas[t];
      if (!(along > 0.995 * areas[k])) continue;
      done[k] = true;
      for (int axis = 0; axis < 3; ++axis) sum[axis] += other[axis];
      stable = stable || bears(hull, hull->triangles[k], unit);
    }
    const double depth = depth_below(hull, unit, hull->points[hull->triangles[t][0]]);
    if (depth < hull->thickness) hull->thickness = depth;
    face.area = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    if (!stable || !(face.area > 0)) continue;
    for (int axis = 0; axis < 3; ++axis) face.normal[axis] = sum[axis] / face.area;
    uint32_t at = hull->face_count;
    if (at == HULL_FACES && face.area <= hull->faces[at - 1].area) continue;
    if (at == HULL_FACES)
      --at;
    else
      ++hull->face_count;
    for (; at > 0 && hull->faces[at - 1].area < face.area; --at) hull->faces[at] = hull->faces[at - 1];
    hull->faces[at] = face;
  }
}

bool rubble_hull_make(const double* points, uint32_t count, rubble_hull* out) {
  memset(out, 0, sizeof *out);
  if (count == 0) return false;
  out->point_count = choose(points, count, out->points);
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, longest = 0;
  for (uint32_t i = 0; i < out->point_count; ++i) {
    double square = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double at = out->points[i][axis];
      if (at < low[axis]) low[axis] = at;
      if (at > high[axis]) high[axis] = at;
      square += at * at;
    }
    if (square > out->radius) out->radius = square;
  }
  out->radius = sqrt(out->radius);
  for (int axis = 0; axis < 3; ++axis) {
    out->size += (high[axis] - low[axis]) / 3;
    if (high[axis] - low[axis] > longest) longest = high[axis] - low[axis];
  }
  if (!(longest > 0)) return false;
  whole grid[HULL_POINTS];
  for (uint32_t i = 0; i < out->point_count; ++i)
    for (int axis = 0; axis < 3; ++axis)
      grid[i].at[axis] = (int64_t)floor((out->points[i][axis] - low[axis]) / longest * GRID + 0.5);
  uint8_t first[4];
  if (!first_four(grid, out->point_count, first)) return false;
  static const uint8_t sides[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
  for (int t = 0; t < 4; ++t)
    for (int c = 0; c < 3; ++c) out->triangles[t][c] = first[sides[t][c]];
  out->triangle_count = 4;
  for (uint32_t p = 0; p < out->point_count; ++p) add_point(grid, p, out);
  find_faces(out);
  return true;
}
