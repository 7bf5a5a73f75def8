/* Bounds, mass and hull of a rock's finest mesh. */
#include <math.h>
#include <string.h>

#include "rock_mesh.h"
#include "vectors.h"

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

double mesh_volume(const mesh_buffer* mesh) {
  int64_t volume6, moment24[3];
  integrate(mesh, &volume6, moment24);
  return (double)volume6 / 6;
}

/* Radius of a ball around the centroid that surely lies inside: no point of a triangle is nearer than its plane, nor nearer than
 * its nearest corner less the longest edge of all. */
static double inner_radius(const mesh_buffer* mesh, const double centroid[3]) {
  int64_t longest2 = 0;
  for (uint32_t i = 0; i < mesh->index_count; i += 3)
    for (uint32_t k = 0; k < 3; ++k) {
      const int16_t *from = mesh->positions[mesh->indices[i + k]], *to = mesh->positions[mesh->indices[i + (k + 1) % 3]];
      const int64_t x = to[0] - from[0], y = to[1] - from[1], z = to[2] - from[2], edge2 = x * x + y * y + z * z;
      if (edge2 > longest2) longest2 = edge2;
    }
  const double longest = sqrt((double)longest2);
  double inner = INFINITY;
  for (uint32_t i = 0; i < mesh->index_count; i += 3) {
    double p[3][3], corner2 = INFINITY;
    for (int k = 0; k < 3; ++k) {
      for (int axis = 0; axis < 3; ++axis) p[k][axis] = mesh->positions[mesh->indices[i + (uint32_t)k]][axis] - centroid[axis];
      const double d2 = dot(p[k], p[k]);
      if (d2 < corner2) corner2 = d2;
    }
    if (corner2 >= (inner + longest) * (inner + longest)) continue;
    const double u[3] = {p[1][0] - p[0][0], p[1][1] - p[0][1], p[1][2] - p[0][2]};
    const double w[3] = {p[2][0] - p[0][0], p[2][1] - p[0][1], p[2][2] - p[0][2]};
    const double normal[3] = {u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]};
    const double length2 = dot(normal, normal);
    const double by_plane = length2 > 0 ? fabs(dot(normal, p[0])) / sqrt(length2) : 0;
    inner = fmin(inner, fmax(by_plane, sqrt(corner2) - longest));
  }
  return inner;
}

void rock_mass(const mesh_buffer* mesh, float cells_per_lattice, rock_record* out) {
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
    const double distance2 = dot(d, d); /* fmax here would stop gcc 12 for aarch64 with an internal error */
    if (distance2 > farthest2) farthest2 = distance2;
  }
  /* The last factors keep the balls conservative when they are rounded to float. */
  const double scale = cells_per_lattice;
  for (int axis = 0; axis < 3; ++axis) out->centroid[axis] = (float)(centroid[axis] * scale);
  out->volume = (float)((double)volume6 / 6 * scale * scale * scale);
  out->inner_radius = (float)(fmax(inner_radius(mesh, centroid), 0) * scale * (1 - 1e-6));
  out->outer_radius = (float)(sqrt(farthest2) * scale * (1 + 1e-6));
}

uint32_t farthest_points(const kernel_set* kernels, const float* const points[3], uint32_t padded, uint32_t most,
                         uint32_t* chosen) {
  uint32_t count = 0;
  /* Directions in order of the squared length of (x, y, z): faces, edges and corners of a cube, then ever finer ones. */
  for (int32_t shell = 1; shell <= 6 && count < most; ++shell)
    for (int32_t code = 0; code < 125 && count < most; ++code) {
      const int32_t x = code % 5 - 2, y = code / 5 % 5 - 2, z = code / 25 - 2;
      if (x * x + y * y + z * z != shell || (shell == 4 && (x == 2 || y == 2 || z == 2 || x == -2 || y == -2 || z == -2))) continue;
      const uint32_t best = kernels->farthest(points, padded, (const float[3]){(float)x, (float)y, (float)z});
      bool known = false;
      for (uint32_t k = 0; k < count; ++k)
        known = known || (points[0][chosen[k]] == points[0][best] && points[1][chosen[k]] == points[1][best] &&
                          points[2][chosen[k]] == points[2][best]);
      if (!known) chosen[count++] = best;
    }
  return count;
}

uint32_t rock_hull(rock_mesher* mesher, uint32_t most, int16_t (*hull)[3]) {
  const mesh_buffer* mesh = &mesher->meshes[0];
  /* Positions as floats, axis by axis; the first vertex pads the last lanes. */
  const uint32_t padded = round_to_lanes(mesh->vertex_count);
  const float* const points[3] = {mesher->points, mesher->points + padded, mesher->points + (size_t)2 * padded};
  for (uint32_t v = 0; v < padded; ++v)
    for (uint32_t axis = 0; axis < 3; ++axis)
      mesher->points[(size_t)axis * padded + v] = mesh->positions[v < mesh->vertex_count ? v : 0][axis];
  uint32_t chosen[ROCK_MAX_HULL];
  const uint32_t count = farthest_points(mesher->kernels, points, padded, most, chosen);
  for (uint32_t k = 0; k < count; ++k)
    memcpy(hull[k], mesh->positions[chosen[k] < mesh->vertex_count ? chosen[k] : 0], sizeof *hull);
  return count;
}
