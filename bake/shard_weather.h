/* A recipe's shards under its weather, from one kept time to the next. */
#ifndef SCREE_SHARD_WEATHER_H
#define SCREE_SHARD_WEATHER_H

#include <scree/shard_recipe.h>

typedef struct shard_weather {
  const scree_shard_desc* desc;
  scree_shards* shards;
  scree_frost* frost;
  scree_shard_rules rules; /* that hold now */
  uint32_t next_phase;
  uint32_t idle_states; /* of scree_shard_states */
} shard_weather;

/* How many times the recipe keeps. */
uint32_t shard_times(const scree_shard_recipe* recipe);

/* Splits the solid: all but the weather. progress: as in scree_shards_desc. Returns what scree_shards_bake returns; the caller
 * destroys `shards` and `frost` whatever came back. */
scree_result shard_weather_create(const scree_shard_desc* desc, bool (*progress)(void* user, const char* stage, double done),
                                  void* user, shard_weather* out, scree_error* error);
scree_result shard_weather_start(shard_weather* weather, scree_error* error);
void shard_weather_destroy(shard_weather* weather); /* all zero is allowed */

/* On to time `time` of the recipe, which is not behind. progress: of the way there. Returns SCREE_OK, RANGE (a share that is not
 * reached), INVALID_ARGUMENT (nothing stands) or CANCELLED. */
scree_result shard_weather_advance(shard_weather* weather, uint32_t time, bool (*progress)(void* user, double done), void* user,
                                   scree_frost_stats* stats, scree_error* error);

/* How what has fallen comes to rest: the recipe's words, of the simulation as it is. Progress and allocator are left empty. */
void shard_weather_rubble(const shard_weather* weather, scree_rubble_desc* out);

#endif
