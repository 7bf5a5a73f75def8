/* Dual blocks: the Voronoi diagram of the seeds, voxel by voxel, in the box between the centres of 2x2x2 cells. Every point lies in
 * the support of just these 8 cells' seeds, so a block is decided by them alone, and the 8 rocks that meet in it share the work. */
#ifndef SCREE_BLOCKS_H
#define SCREE_BLOCKS_H

#include "kernels.h"
#include "seeds.h"

#define BLOCK_MAX_SEEDS 160 /* 8 cells of 20 seeds */

typedef struct block {
  block_fields fields;
  uint8_t first[9];                   /* seeds of corner q are first[q] .. first[q + 1] - 1 */
  uint8_t bounds[BLOCK_MAX_SEEDS][6]; /* of the voxels each seed owns: min xyz, max xyz; min > max = owns none */
} block;

/* Along each axis a block is pinned to a corner plane (between cells 0 and 1, or -1 and 0) or free. Blocks that are pinned along
 * some axis stand in many tiles, so they are made once, for all workers; they are most of the blocks of a tile. */
typedef struct shared_blocks {
  const seed_set* seeds;
  const block_tables* tables;
  const kernel_set* kernels;
  uint32_t count;
  uint32_t* first; /* [N^3] index of the first block of each place class; free along all axes: UINT32_MAX */
  block* blocks;   /* [count] */
  float* memory;
  size_t memory_count;
} shared_blocks;

scree_result shared_blocks_create(const seed_set* seeds, const block_tables* tables, const kernel_set* kernels,
                                  const scree_allocator* allocator, shared_blocks* out);
void shared_blocks_destroy(shared_blocks* shared, const scree_allocator* allocator);

/* Computes shared block `index`; different blocks may be computed at the same time. */
void shared_blocks_fill(shared_blocks* shared, uint32_t index);

/* The blocks of one tile that are free along all axes, made when they are first asked for. One worker's own. */
typedef struct block_cache {
  const shared_blocks* shared;
  uint32_t code;
  uint32_t side;   /* N - 2 free places along an axis */
  block* blocks;   /* [side^3] */
  uint8_t* filled; /* [side^3] */
  float* memory;   /* fields of all blocks */
  size_t memory_count;
} block_cache;

scree_result block_tables_create(const scree_recipe* recipe, const scree_allocator* allocator, block_tables* out);
void block_tables_destroy(block_tables* tables, const scree_allocator* allocator);

scree_result block_cache_create(const shared_blocks* shared, const scree_allocator* allocator, block_cache* out);
void block_cache_destroy(block_cache* cache, const scree_allocator* allocator);

/* Turns to another tile; forgets the blocks of the last one. */
void block_cache_begin(block_cache* cache, uint32_t code);

/* The block whose lowest cell is (x, y, z), each -1..N-1. */
const block* block_cache_get(block_cache* cache, int32_t x, int32_t y, int32_t z);

/* 1 / w and d ln(1 / w) / dt at distance t (cells, 0 <= t < 1) from the cell's centre along one axis: w falls smoothly from 1 at
 * the cell's face to 0 half a cell beyond, so that a seed's distance has compact support. */
static inline double support_weight(double t, double* slope) {
  if (t <= 0.5) {
    *slope = 0;
    return 1;
  }
  double u = (t - 0.5) * 2, v = 1 - u * u;
  *slope = 8 * u / v;
  return 1 / (v * v);
}

#endif
