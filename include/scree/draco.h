/* Meshes out of a pack: decodes a level of detail with Draco into vertices that a GPU takes as they are.
 * This is the optional library scree::draco; the core runtime does not need it. */
#ifndef SCREE_DRACO_H
#define SCREE_DRACO_H

#include "pack.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Decodes LOD `lod` of rock `asset`.
 *
 * vertices: room for `vertex_capacity` elements. indices: room for `index_capacity` uint16 or uint32 elements, three a triangle,
 * counter-clockwise seen from outside. The needed sizes are in scree_lod (vertices, 3 * triangles).
 * Positions are the exact integers that were baked; normals are rebuilt, area-weighted, the same bits on every machine.
 * Returns SCREE_OK, CAPACITY, INVALID_ARGUMENT, CORRUPT (bytes Draco refuses or that do not match the record) or OUT_OF_MEMORY.
 * Thread safety: may be called from any number of threads at once on one pack. Draco allocates while it decodes. */
SCREE_API scree_result scree_draco_decode_u16(const scree_pack* pack, uint32_t asset, uint32_t lod, scree_vertex* vertices,
                                              size_t vertex_capacity, uint16_t* indices, size_t index_capacity);
SCREE_API scree_result scree_draco_decode_u32(const scree_pack* pack, uint32_t asset, uint32_t lod, scree_vertex* vertices,
                                              size_t vertex_capacity, uint32_t* indices, size_t index_capacity);

/* The UVs of LOD `lod` of an asset of a cliff, and the smoothing groups, as scree_pack_coarse_uvs: in the order of the vertices
 * that the calls above deliver. A blob decodes to the same order each time; this call decodes it once more. groups may be NULL.
 * Returns what the calls above return, and INVALID_ARGUMENT for a pack of another kind. */
SCREE_API scree_result scree_draco_decode_uvs(const scree_pack* pack, uint32_t asset, uint32_t lod, scree_uv* uvs, uint8_t* groups,
                                              size_t capacity);

/* The digest of a decoded mesh as the baker computes it before encoding: equal to scree_lod.digest when all is well. It does not
 * depend on the order of vertices or triangles. */
SCREE_API uint64_t scree_mesh_digest(const scree_vertex* vertices, size_t vertex_count, const uint32_t* indices,
                                     size_t triangle_count);

/* The same for meshes of packs of models, whose digest sees material, durability and curvature too. */
SCREE_API uint64_t scree_model_mesh_digest(const scree_vertex* vertices, size_t vertex_count, const uint32_t* indices,
                                           size_t triangle_count);

/* The same for meshes of cliffs, whose digest sees UVs and groups besides. uvs, groups: vertex_count each. */
SCREE_API uint64_t scree_cliff_mesh_digest(const scree_vertex* vertices, const scree_uv* uvs, const uint8_t* groups,
                                           size_t vertex_count, const uint32_t* indices, size_t triangle_count);

#ifdef __cplusplus
}
#endif

#endif
