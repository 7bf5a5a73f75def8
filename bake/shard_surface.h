/* The surface of some of the shards, by index: the solid's own triangles where they are untouched, and the polygons of links
 * between a shard inside and one outside, cut into triangles. Closed: every edge is used as often in one direction as in the other,
 * also where a whole triangle lies beside a clipped one, because vertices on a common edge are kept or dropped on both sides alike.
 */
#ifndef SCREE_SHARD_SURFACE_H
#define SCREE_SHARD_SURFACE_H

#include <scree/shards.h>

typedef struct shard_triangle {
  uint32_t corner[3]; /* vertices of the shards, counter-clockwise from outside */
  uint32_t source;    /* the solid's triangle; of cuts the link */
  uint32_t shard;     /* that it is the surface of; of a triangle that several shards share, the lowest */
} shard_triangle;

typedef enum shard_place_kind { PLACE_INNER, PLACE_VERTEX, PLACE_EDGE, PLACE_FACE } shard_place_kind;

/* Where on the solid a vertex of the shards is. */
typedef struct shard_place {
  shard_place_kind kind;
  uint32_t on[2]; /* VERTEX: [0], of the solid; EDGE: both its ends, rising; FACE: [0], the triangle; INNER: not on the surface */
} shard_place;

typedef struct shard_surface {
  shard_triangle* triangles; /* those of the solid first, by triangle; then cuts, by link */
  uint32_t count, solid_count, capacity;
  shard_place* places; /* of each vertex of the shards */
  uint32_t place_count;
} shard_surface;

/* inside: of each shard, not 0 = it is part. joints: triangles of the solid that several shards share come apart along the joints
 * between them, so that each has one shard. Returns SCREE_OK or OUT_OF_MEMORY; on failure nothing is held. */
scree_result shard_surface_create(const scree_shards_view* shards, const uint8_t* inside, bool joints,
                                  const scree_allocator* allocator, shard_surface* out);
void shard_surface_destroy(shard_surface* surface, const scree_allocator* allocator); /* all zero is allowed */

#endif
