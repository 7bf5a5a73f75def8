/* Bounds, mass and hull of a rock's finest mesh. */
#include <math.h>
#include <string.h>

#include "rock_mesh.h"

/* Sums over the tetrahedra between the triangles and the origin, exact in integers: six times the volume, 24 times the moment. */
static void integrate(const mesh_buffer* mesh, int64_t* volume6, int64_t moment24[3]) {
  *volume6 = moment24[0] = moment24[1] = moment24[2] = 0;
  for (uint32_t i = 0; i < mesh->index_count; i += 3) {
    const int16_t *a = mesh->positions[mesh->indices[i]], *b = mesh->positions[mesh->indices[i + 1]],
                  *c = mesh->positions[mesh->indices[i + 2]];
    const int64_t determinant = (int64_t)a[0] * (b[1] * c[2] - b[2] * c[1]) + (int64_t)a[1] * (b[2] * c[0] - b[0] * c[2]) +
                                (int64_t)a[2] * (b[0] * c[1] - b[1] * c[0]);
    *volume6 += determinant;
    for (int axis = 0; axis < 3; ++axis) moment24[axis] += determinant * (a[axis] + b[axis] + c[axis]);
  }
}

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Radius of a ball around the centroid that surely lies inside: no point of a triangle is nearer than its plane, nor nearer than
 * its nearest corner less its longest edge. */
static double inner_radius(const mesh_buffer* mesh, const double centroid[3]) {
  double inner = INFINITY;
  for (uint32_t i = 0; i < mesh->index_count; i += 3) {
    double p[3][3], corner2 = INFINITY, edge2 = 0;
    for (int k = 0; k < 3; ++k) {
      for (int axis = 0; axis < 3; ++axis) p[k][axis] = mesh->positions[mesh->indices[i + (uint32_t)k]][axis] - centroid[axis];
      corner2 = fmin(corner2, dot(p[k], p[k]));
    }
    for (int k = 0; k < 3; ++k) {
      const double* to = p[(k + 1) % 3];
      const double edge[3] = {to[0] - p[k][0], to[1] - p[k][1], to[2] - p[k][2]};
      edge2 = fmax(edge2, dot(edge, edge));
    }
    const double by_corner = sqrt(corner2) - sqrt(edge2);
    if (by_corner >= inner) continue;
    const double u[3] = {p[1][0] - p[0][0], p[1][1] - p[0][1], p[1][2] - p[0][2]};
    const double w[3] = {p[2][0] - p[0][0], p[2][1] - p[0][1], p[2][2] - p[0][2]};
    const double normal[3] = {u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]};
    const double length2 = dot(normal, normal);
    const double by_plane = length2 > 0 ? fabs(dot(normal, p[0])) / sqrt(length2) : 0;
    inner = fmin(inner, fmax(by_plane, by_corner));
  }
  return inner;
}

void rock_mass(const rock_mesher* mesher, float cells_per_lattice, rock_record* out) {
  const mesh_buffer* mesh = &mesher->meshes[0];
  memcpy(out->bounds_min, mesh->positions[0], sizeof out->bounds_min);
  memcpy(out->bounds_max, mesh->positions[0], sizeof out->bounds_max);
  for (uint32_t v = 0; v < mesh->vertex_count; ++v)
    for (int axis = 0; axis < 3; ++axis) {
      const int16_t p = mesh->positions[v][axis];
      if (p < out->bounds_min[axis]) out->bounds_min[axis] = p;
      if (p > out->bounds_max[axis]) out->bounds_max[axis] = p;
    }
  int64_t volume6, moment24[3];
  integrate(mesh, &volume6, moment24);
  double centroid[3], farthest2 = 0;
  for (int axis = 0; axis < 3; ++axis)
    centroid[axis] =
        volume6 > 0 ? (double)moment24[axis] / (4.0 * (double)volume6) : 0.5 * (out->bounds_min[axis] + out->bounds_max[axis]);
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    const double d[3] = {mesh->positions[v][0] - centroid[0], mesh->positions[v][1] - centroid[1],
                         mesh->positions[v][2] - centroid[2]};
    farthest2 = fmax(farthest2, dot(d, d));
  }
  /* The last factors keep the balls conservative when they are rounded to float. */
  const double scale = cells_per_lattice;
  for (int axis = 0; axis < 3; ++axis) out->centroid[axis] = (float)(centroid[axis] * scale);
  out->volume = (float)((double)volume6 / 6 * scale * scale * scale);
  out->inner_radius = (float)(fmax(inner_radius(mesh, centroid), 0) * scale * (1 - 1e-6));
  out->outer_radius = (float)(sqrt(farthest2) * scale * (1 + 1e-6));
}

/* The vertex farthest along a direction, the first of equals. */
static uint32_t farthest_vertex(const mesh_buffer* mesh, int32_t x, int32_t y, int32_t z) {
  uint32_t best = 0;
  int32_t farthest = INT32_MIN;
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    const int32_t along = x * mesh->positions[v][0] + y * mesh->positions[v][1] + z * mesh->positions[v][2];
    if (along > farthest) farthest = along, best = v;
  }
  return best;
}

uint32_t rock_hull(const rock_mesher* mesher, uint32_t most, int16_t (*hull)[3]) {
  const mesh_buffer* mesh = &mesher->meshes[0];
  uint32_t count = 0;
  /* Directions in order of the squared length of (x, y, z): faces, edges and corners of a cube, then ever finer ones. */
  for (int32_t shell = 1; shell <= 6 && count < most; ++shell)
    for (int32_t code = 0; code < 125 && count < most; ++code) {
      const int32_t x = code % 5 - 2, y = code / 5 % 5 - 2, z = code / 25 - 2;
      if (x * x + y * y + z * z != shell || (shell == 4 && (x == 2 || y == 2 || z == 2 || x == -2 || y == -2 || z == -2))) continue;
      const uint32_t best = farthest_vertex(mesh, x, y, z);
      bool known = false;
      for (uint32_t h = 0; h < count; ++h) known = known || memcmp(hull[h], mesh->positions[best], sizeof *hull) == 0;
      if (!known) memcpy(hull[count++], mesh->positions[best], sizeof *hull);
    }
  return count;
}
