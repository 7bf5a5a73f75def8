/* A cliff of a pack, in the world: what stands of it at one of the times that it was kept at, and the blocks that fell from it
 * until then, each where it came to rest. To scenes and streams it is a scatter whose instances are not random: scree_cliff_create
 * makes a scree_scatter, and everything that takes one takes it; scree_scatter_fill needs no ground then.
 *
 * In a scene its layer has no support. Its instances never drop each other; the convex parts of what stands hold some air, so that
 * blocks in a later layer than the standing part would be dropped at its foot: keep both in one. */
#ifndef SCREE_CLIFF_H
#define SCREE_CLIFF_H

#include "scatter.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Which of its instances. */
enum {
  SCREE_CLIFF_STANDING = 1u << 0, /* one instance: what stands */
  SCREE_CLIFF_BLOCKS = 1u << 1    /* what fell */
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

#ifdef __cplusplus
}
#endif

#endif
