#include "shard_pieces.h"

#include "allocator.h"

void shard_pieces_free(shard_pieces* pieces, const scree_allocator* allocator) {
  scree_rt_release(allocator, pieces->vertices, pieces->vertex_capacity, 3 * sizeof *pieces->vertices);
  scree_rt_release(allocator, pieces->corners, pieces->corner_capacity, sizeof *pieces->corners);
  scree_rt_release(allocator, pieces->pieces, pieces->piece_capacity, sizeof *pieces->pieces);
  *pieces = (shard_pieces){0};
}
