/* What a step is made of, in this order: the sweep over exposed voxels, rockfall, colluvium, counts. */
#ifndef SCREE_WEATHER_STEP_H
#define SCREE_WEATHER_STEP_H

#include "lattice.h"
#include "weather_internal.h"

/* Of the step that comes next; names its random numbers. */
static inline uint64_t weather_step_key(const scree_weather* w) {
  return hash_combine(hash_combine(w->seed, 6), w->step);
}

/* Random bits of a place in a step: the top 32 say whether its rock becomes colluvium, the others where it slides. */
static inline uint64_t weather_hash(uint64_t step_key, uint32_t x, uint32_t y, uint32_t z) {
  return hash_corner(step_key, (int32_t)x, (int32_t)y, (int32_t)z);
}

static inline bool weather_becomes_colluvium(const weather_tables* tables, uint64_t hash) {
  return hash >> 32 < tables->share;
}

/* Takes from the grid what has no path of faces to the ground; what of it becomes colluvium is marked in `grains`. */
void weather_rockfall(scree_weather* w);

/* Lets the marked grains slide and fall, one by one, in the order z, y, x. Clears `grains`. */
void weather_settle(scree_weather* w);

#endif
