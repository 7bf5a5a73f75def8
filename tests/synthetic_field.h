/* Fields without a pack, made of random numbers: what tests and benchmarks of queries need of one. */
#ifndef SYNTHETIC_FIELD_H
#define SYNTHETIC_FIELD_H

#include "field_tables.h"

/* A stream of random numbers: splitmix64. */
typedef struct random_stream {
  uint64_t state;
} random_stream;

static inline uint64_t random_bits(random_stream* r) {
  r->state += UINT64_C(0x9e3779b97f4a7c15);
  return hash_mix(r->state);
}

/* Uniform in [low, high). */
static inline double random_in(random_stream* r, double low, double high) {
  return low + (high - low) * ((double)(random_bits(r) >> 11) * 0x1p-53);
}

/* Uniform in 0 .. count - 1. */
static inline uint32_t random_below(random_stream* r, uint32_t count) {
  return (uint32_t)(random_bits(r) % count);
}

typedef struct synthetic_source {
  field_source source;
  uint32_t* tile_cells;
  uint32_t* cell_first;
  field_rock* rocks;
  uint32_t* hull_first;
  int16_t* hulls;
} synthetic_source;

/* Tables with the zones of a real pack and seeds_min .. seeds_max rocks a cell. Aborts when memory is short. */
synthetic_source synthetic_create(uint32_t cells_per_cube, uint32_t seeds_min, uint32_t seeds_max, uint64_t seed);

/* Gives every rock a hull within its outer ball, and a burial of 1..deepest, or SCREE_BURIAL_NEVER for one in `bare` (0: none). */
void synthetic_add_hulls(synthetic_source* s, uint64_t seed, uint32_t deepest, uint32_t bare);

void synthetic_destroy(synthetic_source* s);

#endif
