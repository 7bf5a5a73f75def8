/* The keys of recipes of rocks, as a table. */
#ifndef SCREE_RECIPE_H
#define SCREE_RECIPE_H

#include <scree/bake.h>

#include "recipe_keys.h"

extern const recipe_table rock_table;

/* Every key in its range, and the rules that span keys. Returns SCREE_OK or SCREE_ERROR_RANGE. */
scree_result recipe_check_all(const scree_recipe* recipe, scree_error* error);

#endif
