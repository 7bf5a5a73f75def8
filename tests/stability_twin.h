/* The rule of stability by its words (bake/frost_stability.h): slow, and added up in another way than the real one. */
#ifndef STABILITY_TWIN_H
#define STABILITY_TWIN_H

#include <scree/frost.h>

typedef struct stability_twin {
  const scree_shards_view* view;
  double gravity[3]; /* need not be unit */
  double density, strength, compression;
} stability_twin;

/* How far each shard is from the supported ones, in links that live; UINT32_MAX = no such way. */
void stability_twin_levels(const stability_twin* rule, const double* lives, const uint8_t* supported, uint32_t* level);

/* The farthest group that breaks is broken off, and all is done again. lives: those of broken links become 0. Returns how many
 * groups broke off. */
uint32_t stability_twin_weigh(const stability_twin* rule, const uint8_t* supported, double* lives);

#endif
