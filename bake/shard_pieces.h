/* Polygons of cells, as the two ways of clipping make them, before they are shards: walls (shard_walls.c) and meshes
 * (shard_clip.c) write them, shard_links.c joins them into shards and links. */
#ifndef SCREE_SHARD_PIECES_H
#define SCREE_SHARD_PIECES_H

#include <scree/shards.h>

#define PIECE_OUTSIDE UINT32_MAX

/* A flat polygon between two cells, or of one cell and the solid's surface. Vertices are shared by index wherever polygons meet:
 * two that have an edge in common have both its vertices in common, and none lies within the edge of another. The pieces of one
 * cell are closed surfaces: one that is inside out is the wall of a hollow and shares no vertex with the surface around it. */
typedef struct shard_piece {
  uint32_t cells[2];                   /* seeds, [0] < [1]; [1] = PIECE_OUTSIDE: a part of `triangle` */
  uint32_t triangle;                   /* UINT32_MAX between cells */
  uint32_t first_corner, corner_count; /* counter-clockwise seen from outside cells[0]; holes joined by bridges */
} shard_piece;

typedef struct shard_pieces {
  double* vertices; /* 3 each */
  uint32_t* corners;
  shard_piece* pieces; /* by (cells[0], cells[1], triangle) */
  uint32_t vertex_count, corner_count, piece_count;
  uint32_t vertex_capacity, corner_capacity, piece_capacity;
} shard_pieces;

/* A solid, ready to be cut: seeds moved and stretched into the space where distances are plain. */
typedef struct shard_input {
  const double* positions; /* 3 * vertex_count, in that space */
  const uint32_t* indices;
  uint32_t vertex_count, triangle_count;
  const double* seeds; /* 3 * seed_count, in that space, no two the same */
  uint32_t seed_count;
  scree_jobs jobs;
  scree_allocator allocator;
} shard_input;

/* Each returns SCREE_OK, OUT_OF_MEMORY, or UNSUPPORTED where the geometry cannot be right: the caller moves the seeds. On failure
 * nothing is owned. Vertices are in the space of the input. */
scree_result shard_walls_cut(const shard_input* input, shard_pieces* out);
scree_result shard_clip_cut(const shard_input* input, shard_pieces* out);
/* Arrays are as long as their capacities say, vertices 3 doubles each; all zero is allowed. */
void shard_pieces_free(shard_pieces* pieces, const scree_allocator* allocator);

#endif
