/* The field of one rock: positive inside, eroded everywhere but at its contacts. */
#ifndef SCREE_ROCK_FIELD_H
#define SCREE_ROCK_FIELD_H

#include "blocks.h"
#include "contacts.h"
#include "noise.h"

/* A rock's own grid lies in the box of 2R voxels around its cell's centre; `min` is its first voxel there. */
typedef struct rock_grid {
  int32_t min[3];
  uint32_t size[3]; /* size[0] is a whole number of lanes, <= 64 */
} rock_grid;

/* What one worker needs to make rocks, one at a time. */
typedef struct rock_worker {
  const scree_recipe* recipe;
  const seed_set* seeds;
  const block_tables* tables;
  const kernel_set* kernels;
  block_cache blocks;
  noise_scratch noise_scratch;
  uint32_t capacity; /* voxels of the largest grid */

  /* The last rock. */
  neighbourhood around;
  rock_contact contacts[MAX_CONTACTS];
  uint32_t contact_count;
  rock_grid grid;
  float* field; /* cells, positive inside */
  float* omega; /* damping, 0 at contacts */
  float* other; /* scratch of the same size */
  float* noise;
  uint64_t* rows; /* one bit a voxel: field > 0 */
  uint64_t* row_scratch;
  float* memory;
  double seconds[3]; /* Voronoi, contacts, erosion */
} rock_worker;

scree_result rock_worker_create(const scree_recipe* recipe, const shared_blocks* shared, const scree_allocator* allocator,
                                rock_worker* out);
void rock_worker_destroy(rock_worker* worker, const scree_allocator* allocator);

/* The Voronoi field of rock `seed` in cell (x, y, z) of the tile that worker->blocks stands at, and its contacts. Returns false
 * when the rock owns no voxel. */
bool rock_voronoi(rock_worker* worker, int32_t x, int32_t y, int32_t z, uint32_t seed);

/* Erodes, chisels and carves it. `key` decides planes and noise. Returns the number of voxels that are left, in one piece. */
uint32_t rock_erode(rock_worker* worker, uint64_t key);

#endif
