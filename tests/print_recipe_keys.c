/* Prints the table of recipe keys, with defaults, as JSON: what tests/check_recipe_schema.py holds the schema against. */
#include <stdio.h>
#include <stdlib.h>

#include "recipe.h"

int main(void) {
  static const char* const kinds[] = {"text", "seed", "count", "count_range", "number", "range", "vector", "choice", "bool"};
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  char defaults[8192];
  if (scree_recipe_write(&recipe, defaults, sizeof defaults) >= sizeof defaults) return 1;
  printf("{\"defaults\": %s, \"keys\": [", defaults);
  for (size_t k = 0; k < recipe_key_count; ++k) {
    const recipe_key* key = &recipe_keys[k];
    printf("%s\n  {\"name\": \"%s\", \"kind\": \"%s\", \"min\": %.17g, \"max\": %.17g, \"choices\": \"%s\"}", k == 0 ? "" : ",",
           key->name, kinds[key->kind], key->min, key->max, key->choices == NULL ? "" : key->choices);
  }
  printf("\n]}\n");
  return 0;
}
