/* A small pack of models, or of a cliff, made in memory without the baker. */
#ifndef SCREE_TESTS_MAKE_MODEL_PACK_H
#define SCREE_TESTS_MAKE_MODEL_PACK_H

#include "rock_set.h"

/* What it is made of; zero means the default in brackets. */
typedef struct test_models_desc {
  uint32_t variants;         /* [2] */
  uint32_t ages;             /* [2]; variant v has 1 + (v + ages - 1) % ages of them */
  uint32_t lod_count;        /* [2] */
  uint32_t lattice_per_cell; /* steps a metre [8]: a model is about 50 steps wide, less the older it is */
  /* A cliff: variant 0 has `ages` times, a model with groups by octant; the others are blocks, cubes with sharp edges, 12 + 2
   * variant steps wide, each of one age; the last has one group, so it
   * is smooth. At time t > 0 there are TEST_PLACEMENTS t placements. */
  bool cliff;
} test_models_desc;

enum { TEST_PLACEMENTS = 20 };

/* A set for pack_write, with real meshes that stand on y = 0 and reach a little below it, each of two convex parts. Ends the test
 * on failure. */
rock_set* test_model_set_make(const test_models_desc* desc);
void test_model_set_free(rock_set* set);

/* The bytes of a pack, malloc'ed: to be freed with free(). NULL: all defaults. */
uint8_t* test_model_pack_make(const test_models_desc* desc, size_t* size);

#endif
