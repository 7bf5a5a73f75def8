/* Closed meshes for tests of shards: boxes, made, weathered or read. All but boxes end the program where memory is short. */
#ifndef MAKE_SOLIDS_H
#define MAKE_SOLIDS_H

#include <scree/shards.h>

typedef struct box_solid {
  double positions[24];
  uint32_t indices[36];
  scree_solid solid;
} box_solid;

static inline void make_box(box_solid* out, const double min[3], const double max[3]) {
  static const uint32_t corners[36] = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                       2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
  for (int i = 0; i < 8; ++i)
    for (int a = 0; a < 3; ++a) out->positions[3 * i + a] = i >> a & 1 ? max[a] : min[a];
  for (int i = 0; i < 36; ++i) out->indices[i] = corners[i];
  out->solid = (scree_solid){.positions = out->positions, .indices = out->indices, .vertex_count = 8, .triangle_count = 12};
}

static inline double make_volume(const scree_solid* solid) {
  double sum = 0;
  for (uint32_t t = 0; t < solid->triangle_count; ++t) {
    const double *a = solid->positions + 3 * (size_t)solid->indices[3 * (size_t)t],
                 *b = solid->positions + 3 * (size_t)solid->indices[3 * (size_t)t + 1],
                 *c = solid->positions + 3 * (size_t)solid->indices[3 * (size_t)t + 2];
    sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
  }
  return sum / 6;
}

typedef struct solid_mesh {
  double* positions;
  uint32_t* indices;
  uint32_t vertex_count, triangle_count;
} solid_mesh;

/* Voxels where `map` has something else than a space: `height` layers from below, each `depth` rows of `width`. Corners are at
 * whole numbers, from 0. Voxels must not touch in an edge or a corner alone. */
solid_mesh solid_from_voxels(const char* map, uint32_t width, uint32_t depth, uint32_t height);
/* Around the y axis. */
solid_mesh solid_torus(double major, double minor, uint32_t around, uint32_t across);
/* A block that weather has worn: `size` voxels a side. */
solid_mesh solid_goblin(uint32_t size, uint32_t steps);
/* False where there is no such file. */
bool solid_read_off(const char* file, solid_mesh* out);
/* Puts both into one. */
void solid_add(solid_mesh* to, const solid_mesh* more, const double move[3], double scale);
void solid_mesh_free(solid_mesh* mesh);

#endif
