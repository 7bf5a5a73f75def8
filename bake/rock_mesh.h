/* The meshes of one rock: the finest level from its field, coarser ones from averaged fields, with ambient occlusion, mass, bounds,
 * hull and the error of each level. */
#ifndef SCREE_ROCK_MESH_H
#define SCREE_ROCK_MESH_H

#include "rock_field.h"
#include "surface_nets.h"

/* One worker's room for meshes. */
typedef struct rock_mesher {
  const scree_allocator* allocator;
  const kernel_set* kernels;
  uint32_t lattice_per_voxel;
  mesh_buffer meshes[ROCK_MAX_LODS];
  float errors[ROCK_MAX_LODS];
  float* coarse;         /* averaged field */
  uint64_t* coarse_rows; /* and its bits, and scratch */
  float* density;        /* blurred occupancy, for ambient occlusion */
  float* blur;
  uint32_t capacity; /* voxels of the largest grid */
  float* points;     /* scratch: positions and normals */
  uint32_t point_capacity;
  uint32_t* fans; /* triangles around each vertex of a coarse mesh */
  uint32_t fan_capacity;
} rock_mesher;

scree_result rock_mesher_create(const rock_worker* worker, uint32_t lattice_per_voxel, const scree_allocator* allocator,
                                rock_mesher* out);
void rock_mesher_destroy(rock_mesher* mesher);

/* Meshes the worker's rock: meshes[0 .. lods - 1] and errors. A level too coarse to hold the finest one's volume
 * within a fifth repeats the one before it. */
scree_result rock_mesh(rock_mesher* mesher, const rock_worker* worker, uint32_t lods);

/* Makes room for a mesh; what the buffer held is gone when it has to grow. */
scree_result mesh_buffer_reserve(mesh_buffer* mesh, uint32_t vertices, uint32_t indices, uint32_t voxels,
                                 const scree_allocator* allocator);
void mesh_buffer_destroy(mesh_buffer* mesh, const scree_allocator* allocator);

/* Surface nets of a field, with room made for them. */
scree_result mesh_field(const voxel_field* field, mesh_buffer* mesh, const scree_allocator* allocator);

/* Moves the vertices of a coarse mesh along their normals, all by the same distance, until it holds `wanted` cubic lattice steps:
 * with its vertices on the surface a polyhedron lies inside the stone and looks shrunken. most: lattice steps. scratch: 9 a vertex.
 */
void mesh_match_volume(mesh_buffer* mesh, double wanted, float most, float* scratch);

/* Volume inside a closed mesh, cubic lattice steps; exact but for the last division. */
double mesh_volume(const mesh_buffer* mesh);

/* Bounds, centroid, volume and radii of a closed mesh, into the record. */
void rock_mass(const mesh_buffer* mesh, float cells_per_lattice, rock_record* out);

/* The points that are farthest in `most` (<= ROCK_MAX_HULL) fixed directions, without repeats. points: x, y and z, `padded` each, a
 * whole number of lanes. Returns how many. */
uint32_t farthest_points(const kernel_set* kernels, const float* const points[3], uint32_t padded, uint32_t most, uint32_t* chosen);

/* Vertices of meshes[0] that are farthest in `most` (<= ROCK_MAX_HULL) fixed directions, without repeats: corners of the convex
 * hull that span nearly all of it. hull: room for `most`. Returns how many. */
uint32_t rock_hull(rock_mesher* mesher, uint32_t most, int16_t (*hull)[3]);

#endif
