/* A cliff of a pack, in the world: what stands of it at one of the times that it was kept at, and the blocks that fell from it
 * until then, each where it came to rest. To scenes and streams it is a scatter whose instances are not random: scree_cliff_create
 * makes a scree_scatter, and everything that takes one takes it; scree_scatter_fill needs no ground then.
 *
 * In a scene its layer has no support. Its instances never drop each other, and no earlier layer drops what stands. The convex
 * parts of what stands hold some air, in which rocks of later layers are dropped: for stones at its foot, or in its caves, put the
 * blocks in a layer before them, what stands in one after them, and take the cliff away from their support, see
 * scree_cliff_mesh_create. */
#ifndef SCREE_CLIFF_H
#define SCREE_CLIFF_H

#include "scatter.h"
#include "support.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Which of its instances. */
enum {
  SCREE_CLIFF_STANDING = 1u << 0, /* one instance: what stands */
  SCREE_CLIFF_BLOCKS = 1u << 1    /* what fell: none where nothing had */
};

typedef struct scree_cliff_desc {
  const scree_pack* pack; /* of kind cliff, which has to outlive the cliff: model = asset */
  uint32_t time;          /* below scree_pack_info.time_count */
  uint32_t what;          /* SCREE_CLIFF_...; 0 = both */
  double origin[3];       /* world place of the cliff's own origin, metres */
  double turn;   /* about +Y, in whole turns, rounded to 1/65536 of one, and a thousandth of a radian off: 0.25 takes +Z to +X */
  float scale;   /* > 0; 0 = 1 */
  uint64_t seed; /* of scree_scene_random */
} scree_cliff_desc;

/* Reads all placements of that time and copies hulls and places: 40 bytes a block. Immutable, may be shared between threads; ends
 * with scree_scatter_destroy. error: may be NULL. Returns SCREE_OK, INVALID_ARGUMENT, PACK_KIND, RANGE, CORRUPT (of the pack) or
 * OUT_OF_MEMORY. */
SCREE_API scree_result scree_cliff_create(const scree_cliff_desc* desc, const scree_allocator* allocator, scree_scatter** out,
                                          scree_error* error);

/* A decoded level of what stands, or of a block, as a closed mesh for SCREE_SHAPE_MESH, so that stones lie at the foot of a cliff
 * and not within it: a difference takes the cliff away from a heap; a smooth union of cliff and ground less both is the talus in
 * the corner between them. Vertices at one place become one, triangles that lose an edge by it go. Metres at scale 1, relative to
 * the cliff's own origin: the shape's transform puts it where scree_cliff_desc puts the cliff. vertices, indices: as
 * scree_draco_decode_u32 gives them, of any level. out: positions and indices are the caller's until scree_cliff_mesh_free with the
 * same allocator; all zero on failure. Whether it is closed is for scree_support_create to say. Returns SCREE_OK, INVALID_ARGUMENT
 * (also index_count % 3), PACK_KIND, RANGE (an index) or OUT_OF_MEMORY. Thread-safe. */
SCREE_API scree_result scree_cliff_mesh_create(const scree_pack* pack, const scree_vertex* vertices, uint32_t vertex_count,
                                               const uint32_t* indices, uint32_t index_count, const scree_allocator* allocator,
                                               scree_mesh* out);
SCREE_API void scree_cliff_mesh_free(const scree_allocator* allocator, scree_mesh* mesh); /* all zero is allowed */

#ifdef __cplusplus
}
#endif

#endif
