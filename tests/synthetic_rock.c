#include "synthetic_rock.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lattice.h"

enum { PLANES = 12 };

typedef struct rock_shape {
  uint64_t seed;
  double radius; /* cells */
  double axis[3];
  double planes[PLANES][4];
} rock_shape;

static double uniform(uint64_t* state) {
  *state += UINT64_C(0x9e3779b97f4a7c15);
  return (double)(hash_mix(*state) >> 11) * 0x1p-53;
}

static rock_shape make_shape(uint64_t seed) {
  rock_shape shape = {.seed = seed, .radius = 0.57};
  uint64_t state = seed;
  for (int axis = 0; axis < 3; ++axis) shape.axis[axis] = 0.85 + 0.4 * uniform(&state);
  for (int i = 0; i < PLANES; ++i) {
    double n[3], length = 0;
    do {
      for (int axis = 0; axis < 3; ++axis) n[axis] = 2 * uniform(&state) - 1;
      length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    } while (length < 0.1 || length > 1);
    for (int axis = 0; axis < 3; ++axis) shape.planes[i][axis] = n[axis] / length;
    shape.planes[i][3] = 0.42 + 0.15 * uniform(&state);
  }
  return shape;
}

static double lattice_noise(uint64_t seed, const double p[3]) {
  int32_t cell[3];
  double t[3], total = 0;
  for (int axis = 0; axis < 3; ++axis) {
    cell[axis] = (int32_t)floor(p[axis]);
    const double f = p[axis] - cell[axis];
    t[axis] = f * f * (3 - 2 * f);
  }
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) weight *= corner >> axis & 1 ? t[axis] : 1 - t[axis];
    const uint64_t hash = hash_corner(seed, cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1), cell[2] + (corner >> 2 & 1));
    total += weight * (double)(hash >> 11) * 0x1p-53;
  }
  return total;
}

/* Signed distance in cells, negative inside. */
static double field(const rock_shape* shape, const double p[3]) {
  const double q[3] = {p[0] * shape->axis[0], p[1] * shape->axis[1], p[2] * shape->axis[2]};
  double value = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]) - shape->radius;
  for (int i = 0; i < PLANES; ++i) {
    const double* plane = shape->planes[i];
    const double side = plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2] - plane[3];
    if (side > value) value = side;
  }
  const double low[3] = {3.5 * p[0], 3.5 * p[1], 3.5 * p[2]}, high[3] = {7 * p[0], 7 * p[1], 7 * p[2]};
  return value + 0.08 * (lattice_noise(shape->seed, low) - 0.5) + 0.04 * (lattice_noise(~shape->seed, high) - 0.5);
}

typedef struct net {
  uint32_t size; /* samples a side */
  double spacing, first;
  double* samples;
  uint32_t* vertex_of; /* of each cube of samples, UINT32_MAX = none */
} net;

static size_t sample_index(const net* grid, uint32_t x, uint32_t y, uint32_t z) {
  return ((size_t)z * grid->size + y) * grid->size + x;
}

/* The mean of the places where the surface crosses the cube's edges, in cells. Returns false when it crosses none. */
static bool net_vertex(const net* grid, const uint32_t at[3], double out[3]) {
  int crossings = 0;
  double sum[3] = {0, 0, 0};
  for (uint32_t from = 0; from < 8; ++from)
    for (uint32_t axis = 0; axis < 3; ++axis) {
      if (from >> axis & 1) continue;
      const uint32_t to = from | 1u << axis;
      const double a = grid->samples[sample_index(grid, at[0] + (from & 1), at[1] + (from >> 1 & 1), at[2] + (from >> 2))];
      const double b = grid->samples[sample_index(grid, at[0] + (to & 1), at[1] + (to >> 1 & 1), at[2] + (to >> 2))];
      if ((a < 0) == (b < 0)) continue;
      for (uint32_t k = 0; k < 3; ++k) sum[k] += from >> k & 1;
      sum[axis] += a / (a - b);
      ++crossings;
    }
  for (uint32_t k = 0; k < 3 && crossings > 0; ++k) out[k] = grid->first + grid->spacing * (at[k] + sum[k] / crossings);
  return crossings > 0;
}

/* The quad around each edge of samples that the surface crosses. */
static void net_quads(const net* grid, lattice_mesh* out) {
  for (uint32_t z = 1; z + 1 < grid->size; ++z)
    for (uint32_t y = 1; y + 1 < grid->size; ++y)
      for (uint32_t x = 1; x + 1 < grid->size; ++x)
        for (uint32_t axis = 0; axis < 3; ++axis) {
          const uint32_t at[3] = {x, y, z};
          uint32_t next[3] = {x, y, z}, quad[4];
          ++next[axis];
          const bool inside = grid->samples[sample_index(grid, x, y, z)] < 0;
          if (inside == (grid->samples[sample_index(grid, next[0], next[1], next[2])] < 0)) continue;
          const uint32_t u = (axis + 1) % 3, v = (axis + 2) % 3;
          for (uint32_t k = 0; k < 4; ++k) {
            uint32_t cube[3] = {at[0], at[1], at[2]};
            cube[u] -= k == 0 || k == 3;
            cube[v] -= k == 0 || k == 1;
            quad[inside ? k : 3 - k] = grid->vertex_of[sample_index(grid, cube[0], cube[1], cube[2])];
          }
          const uint32_t corners[6] = {quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]};
          memcpy(out->indices + 3 * (size_t)out->triangle_count, corners, sizeof corners);
          out->triangle_count += 2;
        }
}

void synthetic_rock_make(uint64_t seed, uint32_t voxels_per_cell, uint32_t steps_per_voxel, uint32_t coarsening,
                         lattice_mesh* out) {
  const rock_shape shape = make_shape(seed);
  const double spacing = (double)coarsening / voxels_per_cell;
  const uint32_t half = (uint32_t)ceil(0.8 / spacing) + 1;
  net grid = {.size = 2 * half, .spacing = spacing, .first = (0.5 - half) * spacing};
  const size_t count = (size_t)grid.size * grid.size * grid.size;
  grid.samples = malloc(count * sizeof *grid.samples);
  grid.vertex_of = malloc(count * sizeof *grid.vertex_of);
  *out = (lattice_mesh){
      .positions = malloc(count * sizeof *out->positions),
      .occlusion = malloc(count),
      .indices = malloc(count * 18 * sizeof *out->indices),
      .error = (float)(coarsening - 1) * 0.02f,
  };
  for (uint32_t z = 0; z < grid.size; ++z)
    for (uint32_t y = 0; y < grid.size; ++y)
      for (uint32_t x = 0; x < grid.size; ++x) {
        const double p[3] = {grid.first + spacing * x, grid.first + spacing * y, grid.first + spacing * z};
        grid.samples[sample_index(&grid, x, y, z)] = field(&shape, p);
      }
  for (uint32_t z = 0; z + 1 < grid.size; ++z)
    for (uint32_t y = 0; y + 1 < grid.size; ++y)
      for (uint32_t x = 0; x + 1 < grid.size; ++x) {
        double p[3];
        uint32_t* vertex = &grid.vertex_of[sample_index(&grid, x, y, z)];
        *vertex = UINT32_MAX;
        if (!net_vertex(&grid, (uint32_t[3]){x, y, z}, p)) continue;
        *vertex = out->vertex_count;
        for (uint32_t axis = 0; axis < 3; ++axis)
          out->positions[*vertex][axis] = (int16_t)floor(p[axis] * voxels_per_cell * steps_per_voxel + 0.5);
        /* Smooth over the surface and darker in hollows, as real occlusion is. */
        const double wide[3] = {2 * p[0], 2 * p[1], 2 * p[2]};
        out->occlusion[*vertex] = (uint8_t)(100 + 150 * lattice_noise(seed + 1, wide));
        ++out->vertex_count;
      }
  net_quads(&grid, out);
  free(grid.samples);
  free(grid.vertex_of);
}

void synthetic_rock_free(lattice_mesh* mesh) {
  free(mesh->positions);
  free(mesh->occlusion);
  free(mesh->indices);
  *mesh = (lattice_mesh){0};
}
