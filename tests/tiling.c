#include "tiling.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "lattice.h"

static void* need(size_t count, size_t size) {
  void* memory = calloc(count, size);
  assert_non_null(memory);
  return memory;
}

/* 1 / w at distance t from a cell's centre along one axis, 0 <= t < 1. */
static double inverse_weight(double t) {
  if (t <= 0.5) return 1;
  const double u = 2 * (t - 0.5), w = 1 - u * u;
  return 1 / (w * w);
}

void tiling_create(uint64_t colours, const seed_set* seeds, tiling* out) {
  *out = (tiling){colours, seeds, need(seeds->voxels, sizeof(float))};
  for (uint32_t v = 0; v < seeds->voxels; ++v) out->weights[v] = (float)inverse_weight((2 * v + 1) / (2.0 * seeds->voxels));
}

void tiling_destroy(tiling* lattice) {
  free(lattice->weights);
}

static int32_t floor_divide(int32_t a, int32_t b) {
  return a / b - (a % b < 0);
}

/* Tile code and place in the tile of a global cell. */
static uint32_t find_place(const tiling* lattice, const int32_t cell[3], int32_t place[3]) {
  const int32_t n = (int32_t)lattice->seeds->n;
  int32_t cube[3];
  for (int axis = 0; axis < 3; ++axis) {
    cube[axis] = floor_divide(cell[axis], n);
    place[axis] = cell[axis] - cube[axis] * n;
  }
  return cube_code(lattice->colours, cube[0], cube[1], cube[2]);
}

uint32_t tiling_cell(const tiling* lattice, const int32_t cell[3]) {
  int32_t place[3];
  const uint32_t code = find_place(lattice, cell, place);
  return scree_rt_lattice_cell(lattice->seeds->n, code, (uint32_t)place[0], (uint32_t)place[1], (uint32_t)place[2]);
}

const rock_seed* tiling_seeds(const tiling* lattice, const int32_t cell[3], uint32_t* count) {
  int32_t place[3];
  const uint32_t code = find_place(lattice, cell, place);
  return seeds_of_cell(lattice->seeds, code, place[0], place[1], place[2], count);
}

uint32_t tiling_box_index(const tiling_box* box, const int32_t cell[3]) {
  return (uint32_t)((cell[0] - box->min[0]) + box->size[0] * ((cell[1] - box->min[1]) + box->size[1] * (cell[2] - box->min[2])));
}

bool tiling_box_holds(const tiling_box* box, const int32_t cell[3]) {
  for (int axis = 0; axis < 3; ++axis)
    if (cell[axis] < box->min[axis] || cell[axis] >= box->min[axis] + box->size[axis]) return false;
  return true;
}

void tiling_box_create(const tiling* lattice, const int32_t min[3], const int32_t size[3], tiling_box* out) {
  *out = (tiling_box){.lattice = lattice};
  memcpy(out->min, min, sizeof out->min);
  memcpy(out->size, size, sizeof out->size);
  const size_t cells = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
  out->seeds = need(cells, sizeof *out->seeds);
  out->first = need(cells + 1, sizeof *out->first);
  out->unique = need(cells, sizeof *out->unique);
  uint32_t rocks = 0, index = 0;
  int32_t cell[3];
  for (cell[2] = min[2]; cell[2] < min[2] + size[2]; ++cell[2])
    for (cell[1] = min[1]; cell[1] < min[1] + size[1]; ++cell[1])
      for (cell[0] = min[0]; cell[0] < min[0] + size[0]; ++cell[0], ++index) {
        uint32_t count;
        out->seeds[index] = tiling_seeds(lattice, cell, &count);
        out->unique[index] = tiling_cell(lattice, cell);
        out->first[index] = rocks;
        rocks += count;
      }
  out->first[cells] = rocks;
}

void tiling_box_destroy(tiling_box* box) {
  free((void*)box->seeds);
  free(box->first);
  free(box->unique);
}

static bool supports(const int64_t from_centre[3], int64_t unit) {
  for (int axis = 0; axis < 3; ++axis)
    if (from_centre[axis] <= -unit || from_centre[axis] >= unit) return false;
  return true;
}

uint32_t reference_owner(const tiling_box* box, const int32_t voxel[3]) {
  const int64_t unit = box->lattice->seeds->unit;
  const float cells_per_unit = (float)(1.0 / (double)unit);
  float least = INFINITY;
  uint32_t owner = UINT32_MAX;
  const int32_t voxels = (int32_t)box->lattice->seeds->voxels;
  int32_t middle[3], cell[3];
  for (int axis = 0; axis < 3; ++axis) middle[axis] = floor_divide(voxel[axis] + voxels / 2, voxels);
  for (cell[2] = middle[2] - 1; cell[2] <= middle[2] + 1; ++cell[2])
    for (cell[1] = middle[1] - 1; cell[1] <= middle[1] + 1; ++cell[1])
      for (cell[0] = middle[0] - 1; cell[0] <= middle[0] + 1; ++cell[0]) {
        int64_t from_centre[3];
        for (int axis = 0; axis < 3; ++axis) from_centre[axis] = 256 * (2 * (int64_t)voxel[axis] + 1) - unit * cell[axis];
        if (!supports(from_centre, unit)) continue;
        float inverse[3];
        for (int axis = 0; axis < 3; ++axis) {
          const int64_t away = from_centre[axis] < 0 ? -from_centre[axis] : from_centre[axis];
          inverse[axis] = box->lattice->weights[away / 512];
        }
        const float weight = (inverse[0] * inverse[1]) * inverse[2];
        const uint32_t index = tiling_box_index(box, cell);
        for (uint32_t rock = box->first[index]; rock < box->first[index + 1]; ++rock) {
          const rock_seed* seed = &box->seeds[index][rock - box->first[index]];
          float d[3];
          for (int axis = 0; axis < 3; ++axis) d[axis] = (float)(from_centre[axis] - seed->position[axis]) * cells_per_unit;
          const float* m = seed->metric;
          const float x = (m[0] * d[0] + m[3] * d[1]) + m[4] * d[2], y = m[1] * d[1] + m[5] * d[2], z = m[2] * d[2];
          const float distance = ((x * d[0] + y * d[1]) + z * d[2]) * weight;
          if (distance < least) {
            least = distance;
            owner = rock;
          }
        }
      }
  return owner;
}

/* Distance from a seed of a global cell at a point, in doubles; infinite outside the support. */
static double distance_at(const tiling_box* box, const int32_t cell[3], const rock_seed* seed, const double point[3]) {
  const double unit = box->lattice->seeds->unit;
  double d[3], weight = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double from_centre = (point[axis] - cell[axis] * unit) / unit;
    if (fabs(from_centre) >= 1) return INFINITY;
    weight *= inverse_weight(fabs(from_centre));
    d[axis] = from_centre - seed->position[axis] / unit;
  }
  double m[6];
  for (int i = 0; i < 6; ++i) m[i] = seed->metric[i];
  const double x = m[0] * d[0] + m[3] * d[1] + m[4] * d[2], y = m[1] * d[1] + m[5] * d[2];
  return (x * d[0] + y * d[1] + m[2] * d[2] * d[2]) * weight;
}

reference_verdict reference_contact(const tiling_box* box, const int32_t a[3], uint32_t seed_a, const int32_t b[3], uint32_t seed_b,
                                    double point[3]) {
  const double unit = box->lattice->seeds->unit;
  const uint32_t index_a = tiling_box_index(box, a), index_b = tiling_box_index(box, b);
  const rock_seed *first = &box->seeds[index_a][seed_a], *second = &box->seeds[index_b][seed_b];
  double from[3], along[3];
  for (int axis = 0; axis < 3; ++axis) {
    if (abs(a[axis] - b[axis]) > 1) return REFERENCE_NONE;
    from[axis] = first->position[axis] + a[axis] * unit;
    along[axis] = second->position[axis] + b[axis] * unit - from[axis];
  }
  double low = 0, high = 1;
  for (int step = 0; step < 40; ++step) {
    const double middle = 0.5 * (low + high);
    for (int axis = 0; axis < 3; ++axis) point[axis] = from[axis] + middle * along[axis];
    *(distance_at(box, a, first, point) < distance_at(box, b, second, point) ? &low : &high) = middle;
  }
  const double own = fmin(distance_at(box, a, first, point), distance_at(box, b, second, point));
  double third = INFINITY;
  int32_t cell[3];
  for (cell[2] = a[2] - 2; cell[2] <= a[2] + 2; ++cell[2])
    for (cell[1] = a[1] - 2; cell[1] <= a[1] + 2; ++cell[1])
      for (cell[0] = a[0] - 2; cell[0] <= a[0] + 2; ++cell[0]) {
        const uint32_t index = tiling_box_index(box, cell);
        for (uint32_t rock = box->first[index]; rock < box->first[index + 1] && third >= own * 0.996; ++rock)
          if (rock != box->first[index_a] + seed_a && rock != box->first[index_b] + seed_b)
            third = fmin(third, distance_at(box, cell, &box->seeds[index][rock - box->first[index]], point));
      }
  if (third < own * 0.996 || !(own < INFINITY)) return REFERENCE_NONE;
  return third > own * 1.004 ? REFERENCE_CONTACT : REFERENCE_CLOSE_CALL;
}
