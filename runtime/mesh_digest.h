/* A digest of a mesh that does not depend on the order of its triangles, on which corner of a triangle comes first, or on how
 * vertices are numbered or shared: the same before Draco encodes a mesh and after it decodes, although Draco reorders everything
 * and doubles pinched vertices.
 *
 *   key(vertex)      = x | y << 16 | z << 32 | occlusion << 48       (x, y, z as 16-bit patterns)
 *   digest(triangle) = XXH3-64 of its three keys as 24 little-endian bytes, in the rotation that is least in lexical order
 *                      for models 48 bytes: each key is followed by material | durability << 8 | curvature << 16, which for
 *                      cliffs has group << 24 | u << 32 | v << 48 added
 *   digest(mesh)     = XXH3-64 of (sum of the triangles' digests mod 2^64, number of triangles) as 16 little-endian bytes */
#ifndef SCREE_MESH_DIGEST_H
#define SCREE_MESH_DIGEST_H

#include <stddef.h>
#include <stdint.h>

/* Vertex i has its three int16 at (const char*)positions + i * position_stride and its occlusion at occlusion[i *
 * occlusion_stride]. Every index must be less than the number of vertices. */
uint64_t scree_rt_mesh_digest(const void* positions, size_t position_stride, const uint8_t* occlusion, size_t occlusion_stride,
                              const uint32_t* indices, size_t triangle_count);

/* The same of a model. surface: of vertex i, the 4 bytes at surface[i] as blobs have them: material, durability, curvature + 128,
 * group. uvs: NULL but for cliffs. */
uint64_t scree_rt_model_digest(const void* positions, size_t position_stride, const uint8_t* occlusion, const uint8_t (*surface)[4],
                               const uint16_t (*uvs)[2], const uint32_t* indices, size_t triangle_count);

#endif
