#include "mesh_twin.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { COLUMN = 8 }; /* lattice steps along x and y */

static void* need(size_t count, size_t size) {
  void* memory = calloc(count + 1, size);
  assert_non_null(memory);
  return memory;
}

/* A triangle (v, next, last) as its vertex v sees it. */
typedef struct fan_blade {
  uint32_t next, last;
} fan_blade;

static int compare_positions(const void* a, const void* b) {
  return memcmp(a, b, 3 * sizeof(int16_t));
}

static bool is_flat(const int16_t a[3], const int16_t b[3], const int16_t c[3]) {
  for (int axis = 0; axis < 3; ++axis) {
    const int i = (axis + 1) % 3, k = (axis + 2) % 3;
    if ((b[i] - a[i]) * (c[k] - a[k]) != (b[k] - a[k]) * (c[i] - a[i])) return false;
  }
  return true;
}

/* The triangles around a vertex: every edge that leaves it does so once and comes back once, and they are one ring. */
static void check_fan(const fan_blade* fan, uint32_t count, mesh_faults* faults) {
  uint32_t shared = 0, open = 0;
  for (uint32_t i = 0; i < count; ++i) {
    uint32_t leaves = 0, returns = 0;
    for (uint32_t k = 0; k < count; ++k) {
      leaves += fan[k].next == fan[i].next;
      returns += fan[k].last == fan[i].next;
    }
    shared += leaves > 1;
    open += returns == 0;
  }
  faults->shared_edges += shared;
  faults->open_edges += open;
  if (shared > 0 || open > 0) return;
  uint32_t at = 0, steps = 0;
  do {
    const uint32_t wanted = fan[at].last;
    for (at = 0; fan[at].next != wanted; ++at) {}
    ++steps;
  } while (at != 0);
  faults->pinched_vertices += steps != count;
}

mesh_faults mesh_find_faults(const twin_mesh* mesh) {
  mesh_faults faults = {0};
  for (uint32_t i = 0; i < 3 * mesh->triangle_count; ++i) faults.bad_indices += mesh->indices[i] >= mesh->vertex_count;
  if (faults.bad_indices > 0) return faults;

  uint32_t* first = need(mesh->vertex_count + 1, sizeof *first); /* fan of vertex v: first[v] .. first[v + 1] - 1 */
  fan_blade* fans = need((size_t)3 * mesh->triangle_count, sizeof *fans);
  for (uint32_t i = 0; i < 3 * mesh->triangle_count; ++i) ++first[mesh->indices[i]];
  for (uint32_t v = 0, sum = 0; v <= mesh->vertex_count; ++v) {
    sum += v < mesh->vertex_count ? first[v] : 0;
    first[v] = sum; /* its end, for now: filling goes down from there */
  }
  for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
    const uint32_t* v = mesh->indices + (size_t)3 * t;
    const bool repeats = v[0] == v[1] || v[1] == v[2] || v[2] == v[0];
    faults.repeated_corners += repeats;
    faults.flat_triangles += !repeats && is_flat(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]);
    for (uint32_t k = 0; k < 3; ++k) fans[--first[v[k]]] = (fan_blade){v[(k + 1) % 3], v[(k + 2) % 3]};
  }
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    faults.unused_vertices += first[v] == first[v + 1];
    if (first[v] < first[v + 1]) check_fan(fans + first[v], first[v + 1] - first[v], &faults);
  }
  free(first);
  free(fans);

  int16_t(*sorted)[3] = need(mesh->vertex_count, sizeof *sorted);
  if (mesh->vertex_count > 0) memcpy(sorted, mesh->positions, mesh->vertex_count * sizeof *sorted);
  qsort(sorted, mesh->vertex_count, sizeof *sorted, compare_positions);
  for (uint32_t v = 1; v < mesh->vertex_count; ++v) faults.repeated_vertices += compare_positions(sorted[v - 1], sorted[v]) == 0;
  free(sorted);
  return faults;
}

uint32_t mesh_fault_sum(const mesh_faults* f) {
  return f->bad_indices + f->repeated_corners + f->flat_triangles + f->shared_edges + f->open_edges + f->pinched_vertices +
         f->unused_vertices + f->repeated_vertices;
}

static void corner(const twin_mesh* mesh, uint32_t index, double out[3]) {
  const int16_t* p = mesh->positions[mesh->indices[index]];
  for (int axis = 0; axis < 3; ++axis) out[axis] = p[axis];
}

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

static void subtract(const double a[3], const double b[3], double out[3]) {
  for (int axis = 0; axis < 3; ++axis) out[axis] = a[axis] - b[axis];
}

void mesh_mass(const twin_mesh* mesh, double* volume, double centroid[3]) {
  double origin[3], sum[3] = {0, 0, 0}, total = 0;
  corner(mesh, 0, origin);
  for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
    double p[3][3], normal[3];
    for (uint32_t k = 0; k < 3; ++k) {
      corner(mesh, 3 * t + k, p[k]);
      subtract(p[k], origin, p[k]);
    }
    cross(p[1], p[2], normal);
    const double tetrahedron = dot(p[0], normal) / 6;
    total += tetrahedron;
    for (int axis = 0; axis < 3; ++axis) sum[axis] += tetrahedron * (p[0][axis] + p[1][axis] + p[2][axis]) / 4;
  }
  *volume = total;
  for (int axis = 0; axis < 3; ++axis) centroid[axis] = origin[axis] + sum[axis] / total;
}

static double segment_distance2(const double p[3], const double a[3], const double b[3]) {
  double along[3], to[3];
  subtract(b, a, along);
  subtract(p, a, to);
  const double length2 = dot(along, along);
  double t = length2 > 0 ? dot(to, along) / length2 : 0;
  t = t < 0 ? 0 : t > 1 ? 1 : t;
  for (int axis = 0; axis < 3; ++axis) to[axis] -= t * along[axis];
  return dot(to, to);
}

/* The plane where the foot of the perpendicular lies inside, else the nearest of the three edges. */
static double triangle_distance2(const double p[3], const double a[3], const double b[3], const double c[3]) {
  double ab[3], ac[3], normal[3], to[3];
  subtract(b, a, ab);
  subtract(c, a, ac);
  cross(ab, ac, normal);
  subtract(p, a, to);
  const double length2 = dot(normal, normal);
  if (length2 > 0) {
    double n1[3], n2[3];
    cross(to, ac, n1);
    cross(ab, to, n2);
    const double s = dot(n1, normal), t = dot(n2, normal);
    if (s >= 0 && t >= 0 && s + t <= length2) {
      const double height = dot(to, normal);
      return height * height / length2;
    }
  }
  return fmin(segment_distance2(p, a, b), fmin(segment_distance2(p, b, c), segment_distance2(p, c, a)));
}

double mesh_distance(const twin_mesh* mesh, const double p[3], double enough) {
  double least = INFINITY;
  for (uint32_t t = 0; t < mesh->triangle_count && least > enough * enough; ++t) {
    double v[3][3], box2 = 0;
    for (uint32_t k = 0; k < 3; ++k) corner(mesh, 3 * t + k, v[k]);
    /* The triangle's box is never farther than the triangle. */
    for (int axis = 0; axis < 3; ++axis) {
      const double low = fmin(v[0][axis], fmin(v[1][axis], v[2][axis])), high = fmax(v[0][axis], fmax(v[1][axis], v[2][axis]));
      const double away = fmax(0, fmax(low - p[axis], p[axis] - high));
      box2 += away * away;
    }
    if (box2 < least) least = fmin(least, triangle_distance2(p, v[0], v[1], v[2]));
  }
  return sqrt(least);
}

double mesh_winding(const twin_mesh* mesh, const double p[3]) {
  double sum = 0;
  for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
    double v[3][3], length[3], normal[3];
    for (uint32_t k = 0; k < 3; ++k) {
      corner(mesh, 3 * t + k, v[k]);
      subtract(v[k], p, v[k]);
      length[k] = sqrt(dot(v[k], v[k]));
    }
    cross(v[1], v[2], normal);
    /* Van Oosterom and Strackee, The Solid Angle of a Plane Triangle, 1983. */
    const double down =
        length[0] * length[1] * length[2] + dot(v[0], v[1]) * length[2] + dot(v[1], v[2]) * length[0] + dot(v[2], v[0]) * length[1];
    sum += 2 * atan2(dot(v[0], normal), down);
  }
  return sum / (4 * 3.14159265358979323846);
}

void mesh_columns_create(const twin_mesh* mesh, mesh_columns* out) {
  memset(out, 0, sizeof *out);
  out->mesh = *mesh;
  for (int axis = 0; axis < 3; ++axis) {
    out->min[axis] = out->max[axis] = mesh->positions[0][axis];
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
      const int32_t p = mesh->positions[v][axis];
      if (p < out->min[axis]) out->min[axis] = p;
      if (p > out->max[axis]) out->max[axis] = p;
    }
  }
  out->width = (out->max[0] - out->min[0]) / COLUMN + 1;
  out->height = (out->max[1] - out->min[1]) / COLUMN + 1;
  const size_t columns = (size_t)out->width * (size_t)out->height;
  out->first = need(columns + 1, sizeof *out->first);
  /* Count, then fill. */
  for (int pass = 0; pass < 2; ++pass) {
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
      int32_t low[2] = {INT32_MAX, INT32_MAX}, high[2] = {INT32_MIN, INT32_MIN};
      for (uint32_t k = 0; k < 3; ++k)
        for (int axis = 0; axis < 2; ++axis) {
          const int32_t at = (mesh->positions[mesh->indices[3 * t + k]][axis] - out->min[axis]) / COLUMN;
          if (at < low[axis]) low[axis] = at;
          if (at > high[axis]) high[axis] = at;
        }
      for (int32_t y = low[1]; y <= high[1]; ++y)
        for (int32_t x = low[0]; x <= high[0]; ++x) {
          uint32_t* slot = &out->first[x + (size_t)out->width * (size_t)y];
          if (pass == 1) out->list[slot[0]] = t;
          ++*slot;
        }
    }
    uint32_t sum = 0;
    for (size_t c = 0; c <= columns && pass == 0; ++c) {
      const uint32_t count = c < columns ? out->first[c] : 0;
      out->first[c] = sum;
      sum += count;
    }
    if (pass == 0) out->list = need(sum, sizeof *out->list);
  }
  for (size_t c = columns; c > 0; --c) out->first[c] = out->first[c - 1];
  out->first[0] = 0;
}

void mesh_columns_destroy(mesh_columns* columns) {
  free(columns->first);
  free(columns->list);
}

/* Which side of the line from a to b the point p + (e, e^2) lies on, e being infinitely small: never 0 unless a and b coincide. */
static int side_of(const int16_t a[3], const int16_t b[3], const int32_t p[3]) {
  const int64_t x = b[0] - a[0], y = b[1] - a[1];
  const int64_t cross_product = x * (p[1] - a[1]) - y * (p[0] - a[0]);
  if (cross_product != 0) return cross_product > 0 ? 1 : -1;
  if (y != 0) return y < 0 ? 1 : -1;
  return x > 0 ? 1 : x < 0 ? -1 : 0;
}

bool mesh_holds(const mesh_columns* columns, const int32_t p[3]) {
  for (int axis = 0; axis < 3; ++axis)
    if (p[axis] < columns->min[axis] || p[axis] > columns->max[axis]) return false;
  const size_t column =
      (size_t)((p[0] - columns->min[0]) / COLUMN) + (size_t)columns->width * (size_t)((p[1] - columns->min[1]) / COLUMN);
  bool inside = false;
  for (uint32_t i = columns->first[column]; i < columns->first[column + 1]; ++i) {
    const uint32_t* v = columns->mesh.indices + (size_t)3 * columns->list[i];
    const int16_t *a = columns->mesh.positions[v[0]], *b = columns->mesh.positions[v[1]], *c = columns->mesh.positions[v[2]];
    const int side = side_of(a, b, p);
    if (side == 0 || side_of(b, c, p) != side || side_of(c, a, p) != side) continue;
    int64_t u[3], w[3], to[3];
    for (int axis = 0; axis < 3; ++axis) u[axis] = b[axis] - a[axis], w[axis] = c[axis] - a[axis], to[axis] = p[axis] - a[axis];
    const int64_t height =
        to[0] * (u[1] * w[2] - u[2] * w[1]) + to[1] * (u[2] * w[0] - u[0] * w[2]) + to[2] * (u[0] * w[1] - u[1] * w[0]);
    if (height == 0) return false; /* on it */
    /* The triangle is above where the point is on the back of its upward side. */
    if ((height < 0) == (side > 0)) inside = !inside;
  }
  return inside;
}

double hull_distance(const int16_t (*points)[3], uint32_t count, const double p[3], double enough) {
  double at[3] = {points[0][0], points[0][1], points[0][2]}, distance = INFINITY;
  for (int round = 0; round < 400; ++round) {
    double away[3];
    subtract(p, at, away);
    distance = sqrt(dot(away, away));
    if (distance <= enough) return distance;
    /* The point farthest towards p, and the best place on the way there. */
    uint32_t best = 0;
    double farthest = -INFINITY;
    for (uint32_t i = 0; i < count; ++i) {
      const double along = away[0] * points[i][0] + away[1] * points[i][1] + away[2] * points[i][2];
      if (along > farthest) farthest = along, best = i;
    }
    double step[3];
    for (int axis = 0; axis < 3; ++axis) step[axis] = points[best][axis] - at[axis];
    const double length2 = dot(step, step), t = length2 > 0 ? dot(away, step) / length2 : 0;
    if (t <= 1e-9) return distance;
    for (int axis = 0; axis < 3; ++axis) at[axis] += (t > 1 ? 1 : t) * step[axis];
  }
  return distance;
}
