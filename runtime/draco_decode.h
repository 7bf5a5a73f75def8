/* One Draco blob to vertices and triangles. The C side of draco_decode.cpp. */
#ifndef SCREE_DRACO_DECODE_H
#define SCREE_DRACO_DECODE_H

#include <scree/draco.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Decodes a blob that must hold exactly vertex_count vertices and triangle_count triangles; see scree_draco_decode_u16.
 * kind: of the pack that it is from. vertices: vertex_count. indices: 3 * triangle_count of index_size (2 or 4) bytes.
 * Returns SCREE_OK, CORRUPT or OUT_OF_MEMORY. Lets no exception out. */
scree_result scree_rt_draco_decode_blob(const uint8_t* blob, size_t blob_size, uint32_t vertex_count, uint32_t triangle_count,
                                        scree_pack_kind kind, scree_vertex* vertices, void* indices, uint32_t index_size);

/* The UVs and groups of a blob of a cliff, vertex_count each; groups may be NULL. Returns the same. */
scree_result scree_rt_draco_decode_uvs(const uint8_t* blob, size_t blob_size, uint32_t vertex_count, uint32_t triangle_count,
                                       scree_uv* uvs, uint8_t* groups);

#ifdef __cplusplus
}
#endif

#endif
