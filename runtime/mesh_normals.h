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

/* The normal of one vertex from the sum of the cross products around it: the same bits as above. */
void scree_rt_mesh_normal(const int64_t sum[3], int16_t normal[3]);

#ifdef __cplusplus
}
#endif

#endif
