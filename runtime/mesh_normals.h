/* Vertex normals from a mesh on the lattice: the sum of the cross products of the triangles around a vertex, that is weighted by
 * area. The sums are of integers and exact, so the order of triangles does not matter and every machine gets the same bits. */
#ifndef SCREE_MESH_NORMALS_H
#define SCREE_MESH_NORMALS_H

#include <scree/pack.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Fills `normal` of every vertex from the positions. A vertex without area around it gets +Y.
 * indices: 3 a triangle, each less than vertex_count.
 * scratch: vertex_count * MESH_NORMALS_SCRATCH bytes, aligned for int64_t. */
#define MESH_NORMALS_SCRATCH 24
void scree_rt_mesh_normals(scree_vertex* vertices, uint32_t vertex_count, const uint32_t* indices, uint32_t triangle_count,
                           void* scratch);

/* The same of a cliff: vertices at one place that have one smoothing group share their normal, whatever their UVs.
 * groups: one a vertex. scratch: scree_rt_joined_normals_scratch(vertex_count) bytes, aligned as above. */
size_t scree_rt_joined_normals_scratch(uint32_t vertex_count);
void scree_rt_joined_normals(scree_vertex* vertices, const uint8_t* groups, uint32_t vertex_count, const uint32_t* indices,
                             uint32_t triangle_count, void* scratch);

/* Equal for vertices that share their normal; and a hash of it, whose top bits are the best. */
static inline uint64_t scree_rt_normal_key(const int16_t position[3], uint8_t group) {
  return (uint64_t)(uint16_t)position[0] | (uint64_t)(uint16_t)position[1] << 16 | (uint64_t)(uint16_t)position[2] << 32 |
         (uint64_t)group << 48;
}
static inline uint64_t scree_rt_normal_hash(uint64_t key) {
  key *= UINT64_C(0x9e3779b97f4a7c15);
  return (key ^ key >> 29) * UINT64_C(0xbf58476d1ce4e5b9);
}

/* The normal of one vertex from the sum of the cross products around it: the same bits as above. */
void scree_rt_mesh_normal(const int64_t sum[3], int16_t normal[3]);

#ifdef __cplusplus
}
#endif

#endif
