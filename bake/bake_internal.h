/* A bake in progress, and single rocks out of it: for scree_bake_rocks, tests and benchmarks. */
#ifndef SCREE_BAKE_INTERNAL_H
#define SCREE_BAKE_INTERNAL_H

#include "rock_mask.h"

typedef struct bake_worker {
  rock_worker rock;
  rock_mesher mesher;
  bool started;
  double mesh_seconds, encode_seconds, burial_seconds, proxy_seconds;
} bake_worker;

typedef struct bake_run {
  scree_allocator allocator;
  scree_recipe recipe;
  const kernel_set* kernels;
  seed_set seeds;
  block_tables tables;
  shared_blocks shared;
  uint32_t cell_count;
  uint32_t slot_count;  /* seeds of all unique cells: rocks, before empty ones are dropped */
  uint32_t* cells;      /* unique cells by the tile they are baked in */
  uint32_t* cell_rocks; /* [cell_count + 1] first slot of each unique cell */
  uint32_t tile_first[257];
  bake_worker* workers;
  uint32_t worker_count;
} bake_run;

/* Seeds, tables and scratch of a recipe. On success bake_end frees it all. plain_kernels: the portable kernels, for tests. */
scree_result bake_begin(const scree_bake_desc* desc, bool plain_kernels, bake_run* out);
void bake_end(bake_run* bake);

/* The eroded field of one rock, in worker->rock. False when nothing is left of it. */
bool bake_rock_field(bake_run* bake, bake_worker* worker, uint32_t cell, uint32_t seed);

/* One rock, meshed and encoded, and its mask. *out and *mask must be zeroed; they stay so when nothing is left of the rock. On
 * failure the caller still frees what they own. */
scree_result bake_rock(bake_run* bake, bake_worker* worker, uint32_t cell, uint32_t seed, rock_record* out, rock_mask* mask);

#endif
