/* A small pack, made in memory without the baker. */
#ifndef SCREE_TESTS_MAKE_PACK_H
#define SCREE_TESTS_MAKE_PACK_H

#include "rock_set.h"

/* What a test pack is made of; zero means the default in brackets. */
typedef struct test_pack_desc {
  uint32_t cells_per_cube;  /* N [1]: 2 unique cells; 3 gives 2,266 */
  uint32_t rocks_per_cell;  /* [1]; cell c gets 1 + c % rocks_per_cell */
  uint32_t lod_count;       /* [2] */
  uint32_t voxels_per_cell; /* [6] */
  uint32_t shapes;          /* different rocks, repeated over the assets [4] */
  bool proxies;             /* the meshes of rocks again, as many as a pack has proxies */
} test_pack_desc;

/* A set of rocks for pack_write, with real meshes, encoded. Ends the test on failure. */
rock_set* test_rock_set_make(const test_pack_desc* desc);
void test_rock_set_free(rock_set* set);

/* The bytes of a pack, malloc'ed: to be freed with free(). */
uint8_t* test_pack_make(const test_pack_desc* desc, size_t* size);

/* Makes the digests of changed bytes right again, so that a test reaches the checks behind them. */
void test_pack_reseal(uint8_t* bytes);

#endif
