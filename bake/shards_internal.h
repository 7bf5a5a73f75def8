/* What scree_shards holds; tests make synthetic ones. */
#ifndef SCREE_SHARDS_INTERNAL_H
#define SCREE_SHARDS_INTERNAL_H

#include "allocator.h"
#include "shard_pieces.h"

struct scree_shards {
  scree_allocator allocator;
  scree_shards_view view; /* points into the memory below */
  scree_solid solid;      /* likewise */
  void* memory;
  size_t size;
};

/* Joins pieces into shards and links, with both graphs, and checks every shard: see scree_shards_create. desc: for its solid,
 * link_angle and allocator; pieces: in the space of the solid. Returns SCREE_OK, OUT_OF_MEMORY, or UNSUPPORTED where a check fails,
 * with what failed in `error`. */
scree_result shards_assemble(const scree_shards_desc* desc, const shard_pieces* pieces, scree_shards** out, scree_error* error);

#endif
