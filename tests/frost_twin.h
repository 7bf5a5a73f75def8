/* Freeze and thaw by the book: section 5 of Mateos et al. 2024 written down line by line, over the same random stream as the real
 * one. Slow: each start and each step weighs all links there are, each breakage finds the connected components of all shards. */
#ifndef FROST_TWIN_H
#define FROST_TWIN_H

#include "frost_internal.h"

typedef struct frost_twin {
  const scree_frost* like; /* for the view, the rules, the rains' frames and resistances alone */
  double mean_area, scale; /* a bar of the paper; areas to integer weights */
  double gravity[3];       /* unit, of the rules of the last path */
  bool walk;               /* see frost_twin_path */
  random_stream stream;
  uint8_t *states, *exterior, *walked;
  double* lives;
  uint32_t *labels, *queue;
  uint8_t* down; /* of each shard: whether it reaches the lowest place along `down_gravity` */
  double down_gravity[3];
  uint32_t* blocks; /* of each shard: 1 + the block that it fell in, 0 = none */
  uint32_t block_count;
  uint64_t paths, breaks, forced, detachments, overloaded, visited;
  uint64_t unchecked; /* breaks since stability was looked at */
  double poured, absorbed, drained;
  uint64_t walk_differs; /* links, over all falls, where the walk of the paper is another */
} frost_twin;

/* The state of a simulation, to go on from. Rules are those that `like` has at the time. */
frost_twin* frost_twin_create(const scree_frost* like);
/* From given states, NULL = all solid, and the random stream that `like` is at, which has just been created. */
frost_twin* frost_twin_start(const scree_frost* like, const uint8_t* states);
void frost_twin_destroy(frost_twin* twin);

/* False where nothing takes water. walk: counts where the paper's breadth-first walk over the links graph, from the exterior links
 * that are left, says something else about what is exterior. */
bool frost_twin_path(frost_twin* twin, bool walk);

/* Breaks off what is too weak, by stability_twin.h. A path does it once enough links broke; the end of a step call has to. */
void frost_twin_check(frost_twin* twin);

/* Edits, as scree_frost_set_shard and scree_frost_set_life, by the components of all shards. */
void frost_twin_set_shard(frost_twin* twin, uint32_t shard, scree_shard_state state);
void frost_twin_set_life(frost_twin* twin, uint32_t link, double life);

/* Lets fall what nothing holds: to be called when the rules of `like` were changed. */
void frost_twin_settle(frost_twin* twin);

/* Shards that break the promise: they stand without a path to a core shard, where some are core; else, with stability, to one that
 * rests on the lowest place, where some do; else to one that rests, nor are they of a largest component. */
uint32_t frost_twin_floating(frost_twin* twin);

/* What of a state is exterior, found from nothing. out: of each link. */
void frost_twin_exterior(frost_twin* twin, uint8_t* out);

#endif
