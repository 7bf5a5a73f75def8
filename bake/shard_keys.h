/* The keys of recipes of shards, as a table. */
#ifndef SCREE_SHARD_KEYS_H
#define SCREE_SHARD_KEYS_H

#include <scree/shard_recipe.h>

#include "recipe_keys.h"

extern const recipe_table shard_table;

/* Every key in its range, and the rules that span keys, for recipes that did not come from JSON. */
scree_result shard_check_all(const scree_shard_recipe* recipe, scree_error* error);

#endif
