/* The keys of recipes of hoodoos, as a table. */
#ifndef SCREE_HOODOO_RECIPE_H
#define SCREE_HOODOO_RECIPE_H

#include <scree/hoodoo.h>

#include "recipe_keys.h"

extern const recipe_table hoodoo_table;

/* Every key in its range, and the rules that span keys, for recipes that did not come from JSON. */
scree_result hoodoo_check_all(const scree_hoodoo_recipe* recipe, scree_error* error);

/* Of all randomness of a variant. */
uint64_t hoodoo_variant_seed(const scree_hoodoo_recipe* recipe, uint32_t variant);

#endif
