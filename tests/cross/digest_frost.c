#include "digest_frost.h"

#include <scree/frost.h>

#include "lattice.h"
#include "make_hill.h"
#include "make_shards.h"

static uint64_t frozen(const scree_shards* shards, double strength) {
  scree_frost_desc desc = {.shards = shards, .random_seed = 3};
  scree_frost_rules_default(&desc.rules);
  desc.rules.rains[1] = (scree_rain){{1, -0.5, 0.3}, 1.1, 0.7};
  desc.rules.rains[2] = (scree_rain){{0, 0.2, 1}, 0, 0.2};
  desc.rules.rain_count = 3;
  desc.rules.resistance = (scree_resistance){
      .kind = SCREE_RESISTANCE_NOISE, .value = 0.4, .amplitude = 0.5, .period = 3, .octaves = 3, .random_seed = 4};
  desc.rules.fall_life = 0.3;
  desc.rules.damage = 1;
  desc.rules.strength = strength;
  scree_frost* f;
  if (shards == NULL || scree_frost_create(&desc, &f, NULL) != SCREE_OK) return 0;
  scree_frost_step(f, 2000);
  uint64_t digest = scree_frost_digest(f);
  const scree_block* blocks;
  const uint32_t* list;
  const uint32_t count = scree_frost_blocks(f, &blocks, &list);
  for (uint32_t b = 0; b < count; ++b) {
    digest = hash_combine(digest, blocks[b].path);
    for (uint32_t i = 0; i < blocks[b].shard_count; ++i) digest = hash_combine(digest, list[blocks[b].first_shard + i]);
  }
  scree_frost_destroy(f);
  return digest;
}

uint64_t digest_shards(void) {
  scree_shards *hill = make_hill(400, 20, 5, NULL), *columns = make_columns(9, 5, 6, 5, NULL);
  const uint64_t digest =
      hill != NULL && columns != NULL ? hash_combine(scree_shards_digest(hill), scree_shards_digest(columns)) : 0;
  scree_shards_destroy(hill);
  scree_shards_destroy(columns);
  return digest;
}

uint64_t digest_frost(void) {
  const uint32_t size[3] = {6, 7, 5};
  scree_shards *hill = make_hill(400, 20, 5, NULL), *boxes = make_lattice(size, 2, NULL);
  const uint64_t digest = hash_combine(frozen(hill, 0), frozen(boxes, 1e6));
  scree_shards_destroy(hill);
  scree_shards_destroy(boxes);
  return digest;
}
