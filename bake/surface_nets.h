/* Surface nets on the pack's lattice: one vertex in every cube of 2x2x2 voxels that the surface passes, one quad across every edge
 * between an inside and an outside voxel. On a well-composed set of voxels the result is a closed 2-manifold. */
#ifndef SCREE_SURFACE_NETS_H
#define SCREE_SURFACE_NETS_H

#include "rock_set.h"

/* A scalar field on voxels, positive inside. */
typedef struct voxel_field {
  float* values;                 /* [width * height * depth] */
  uint64_t* rows;                /* [height * depth] one bit a voxel: values > 0; the outermost voxels are all outside */
  uint32_t width, height, depth; /* width <= 64 */
  int32_t origin[3];             /* lattice position of voxel (0, 0, 0) */
  int32_t step;                  /* lattice steps from voxel to voxel, even */
} voxel_field;

/* Room for a mesh that is being made. */
typedef struct mesh_buffer {
  int16_t (*positions)[3];
  uint16_t (*cells)[3]; /* the cube of voxels that each vertex lies in */
  uint8_t* occlusion;
  uint32_t* indices;
  uint32_t* vertex_of; /* scratch, one a voxel of the field */
  uint32_t vertex_capacity, index_capacity, voxel_capacity;
  uint32_t vertex_count, index_count;
} mesh_buffer;

/* Meshes a field. Vertices are rounded down to the lattice: that keeps each inside its own half-open cube, so that no two coincide,
 * and none is off by more than half a step from where the whole set lies, which is thereby moved by half a step along each axis,
 * all rocks alike; contacts are rounded the same way. The buffer must have room for every cube and every edge of the field's
 * surface: surface_nets_bounds says how much. */
void surface_nets(const voxel_field* field, mesh_buffer* out);
void surface_nets_bounds(const voxel_field* field, uint32_t* vertices, uint32_t* indices);

/* Splits every quad into two triangles along its shorter diagonal, unless one of them would have no area. Call it when the vertices
 * are where they shall stay. */
void surface_nets_triangulate(mesh_buffer* mesh);

#endif
