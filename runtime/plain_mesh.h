/* A mesh that needs no decoder: the coarsest level of every rock, proxy and model, which a stream has resident before anything
 * else.
 *
 *   0        6                7            8
 *   | i16[3] | u8             | u8         | u8 or u16 [vertices][3] | u8 [vertices] | u8 or u16 [triangles][3] |
 *     base     position bytes   index bytes  position - base           occlusion       corners
 *
 * Models have u8 [vertices][4], see mesh_digest.h, between occlusion and corners; cliffs have u16 [vertices][2], the UVs, behind
 * these. */
#ifndef SCREE_PLAIN_MESH_H
#define SCREE_PLAIN_MESH_H

#include <scree/pack.h>

enum { PLAIN_MESH_HEAD = 8, PLAIN_MESH_MAX_VERTICES = 1 << 16 };

/* The parts of a plain mesh, checked. */
typedef struct plain_mesh {
  int16_t base[3];
  uint32_t position_size, index_size; /* bytes of a coordinate and of an index: 1 or 2 */
  uint32_t vertex_count, triangle_count;
  const uint8_t *positions, *occlusion, *indices;
  const uint8_t (*surface)[4]; /* NULL for rocks */
  const uint8_t* uvs;          /* of cliffs, else NULL: two u16 a vertex, which may lie anywhere */
} plain_mesh;

/* Returns false where the bytes are not a plain mesh of just these numbers of vertices and triangles: another size, a position
 * beyond int16, an index out of range. kind: of the pack that it is from. */
bool scree_rt_plain_mesh_read(const uint8_t* blob, size_t blob_size, uint32_t vertex_count, uint32_t triangle_count,
                              scree_pack_kind kind, plain_mesh* out);

/* One coordinate of a vertex. */
int32_t scree_rt_plain_mesh_coordinate(const plain_mesh* mesh, uint32_t vertex, uint32_t axis);

/* Vertices with rebuilt normals, and indices of index_size (2 or 4) bytes. Allocates nothing. */
void scree_rt_plain_mesh_decode(const plain_mesh* mesh, scree_vertex* vertices, void* indices, uint32_t index_size);

#endif
