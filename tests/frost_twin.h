/* Freeze and thaw by the book: section 5 of Mateos et al. 2024 written down line by line, over the same random stream as the real
 * one. Slow: each start and each step weighs all links there are, each breakage finds the connected components of all shards. */
#ifndef FROST_TWIN_H
#define FROST_TWIN_H

#include "frost_internal.h"

typedef struct frost_twin {
  const scree_frost* like; /* for the view, the rules, rains and resistances alone */
  random_stream stream;
  uint8_t *states, *exterior, *walked;
  double* lives;
  uint32_t *labels, *queue;
  uint32_t* blocks; /* of each shard: 1 + the block that it fell in, 0 = none */
  uint32_t block_count;
  uint64_t paths, breaks, forced, detachments, visited;
  double poured, absorbed, drained;
  uint64_t walk_differs; /* links, over all falls, where the walk of the paper is another */
} frost_twin;

/* The state of a simulation, to go on from. Rules must stay those of `like`. */
frost_twin* frost_twin_create(const scree_frost* like);
void frost_twin_destroy(frost_twin* twin);

/* False where nothing takes water. walk: counts where the paper's breadth-first walk over the links graph, from the exterior links
 * that are left, says something else about what is exterior. */
bool frost_twin_path(frost_twin* twin, bool walk);

/* What of a state is exterior, found from nothing. out: of each link. */
void frost_twin_exterior(frost_twin* twin, uint8_t* out);

#endif
