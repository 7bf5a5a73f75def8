/* Prints the tables of keys of hoodoo recipes and their defaults as JSON, for check_hoodoo_schema.py. */
#include <stdio.h>

#include "hoodoo_recipe.h"

static void print_keys(const hoodoo_key* keys) {
  static const char* const kinds[] = {"text",   "seed",       "count",   "counts",  "number", "bool",      "choice",
                                      "object", "durability", "bubbles", "mixture", "ages",   "age_steps", "phases"};
  printf("[");
  for (const hoodoo_key* key = keys; key->name != NULL; ++key) {
    printf("%s\n{\"name\": \"%s\", \"kind\": \"%s\", \"min\": %.17g, \"max\": %.17g", key == keys ? "" : ",", key->name,
           kinds[key->kind], key->min, key->max);
    if (key->words != NULL) printf(", \"words\": \"%s\"", key->words);
    if (key->shapes != 0) printf(", \"shapes\": %u", key->shapes);
    if (key->members != NULL) {
      printf(", \"members\": ");
      print_keys(key->members);
    }
    printf("}");
  }
  printf("]");
}

int main(void) {
  static scree_hoodoo_recipe recipe;
  static char text[16384];
  scree_hoodoo_default(&recipe);
  printf("{\"keys\": ");
  print_keys(hoodoo_keys);
  printf(", \"rules\": ");
  print_keys(hoodoo_rule_keys);
  if (scree_hoodoo_write(&recipe, text, sizeof text) >= sizeof text) return 1;
  printf(", \"defaults\": %s}\n", text);
  return 0;
}
