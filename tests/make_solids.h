/* Closed meshes for tests of shards: made, weathered or read. All end the program where memory is short. */
#ifndef MAKE_SOLIDS_H
#define MAKE_SOLIDS_H

#include <scree/shards.h>

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
