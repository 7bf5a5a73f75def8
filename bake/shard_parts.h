/* Convex parts of many shards together: near shards are joined as long as their hull holds little air. */
#ifndef SCREE_SHARD_PARTS_H
#define SCREE_SHARD_PARTS_H

#include "shard_asset.h"

/* places: of each vertex of the shards, lattice steps. parts: room for SHARD_PARTS_MAX; by their lowest shard. air: the volume of
 * all parts, cubic lattice steps. Returns SCREE_OK or OUT_OF_MEMORY. */
scree_result shard_parts_make(const scree_shards_view* shards, const uint8_t* inside, const int16_t (*places)[3],
                              const scree_allocator* allocator, shard_part* parts, uint32_t* count, double* volume);

#endif
