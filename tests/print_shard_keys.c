/* For check_shard_schema.py. Without arguments: prints the tables of keys of recipes of shards and their defaults as JSON. With a
 * file: prints the recipe that it holds with every key, as scree-bake --print-recipe does, or what is wrong and exits with 2. */
#include <stdio.h>

#include "shard_keys.h"

static void print_keys(const shard_key* keys) {
  static const char* const kinds[] = {"text",   "seed",   "count", "counts", "number", "numbers", "bool",
                                      "choice", "object", "list",  "rows",   "values", "times",   "phases"};
  printf("[");
  for (const shard_key* key = keys; key->name != NULL; ++key) {
    printf("%s\n{\"name\": \"%s\", \"kind\": \"%s\", \"min\": %.17g, \"max\": %.17g, \"least\": %u, \"size\": %u",
           key == keys ? "" : ",", key->name, kinds[key->kind], key->min, key->max, key->least, key->size);
    if (key->words != NULL) printf(", \"words\": \"%s\"", key->words);
    if (key->only != 0) printf(", \"only\": %u", key->only);
    if (key->members != NULL) {
      printf(", \"members\": ");
      print_keys(key->members);
    }
    printf("}");
  }
  printf("]");
}

static int print_recipe(const char* path) {
  static char text[1 << 16];
  static scree_shard_recipe recipe;
  scree_error error = {{0}};
  FILE* file = fopen(path, "rb");
  if (file == NULL) return 1;
  const size_t size = fread(text, 1, sizeof text, file);
  fclose(file);
  if (scree_shard_recipe_parse(text, size, &recipe, &error) != SCREE_OK) {
    fprintf(stderr, "%s\n", error.message);
    return 2;
  }
  if (scree_shard_recipe_write(&recipe, text, sizeof text) >= sizeof text) return 1;
  fputs(text, stdout);
  return 0;
}

int main(int count, char** arguments) {
  if (count > 1) return print_recipe(arguments[1]);
  static scree_shard_recipe recipe;
  static char text[65536];
  scree_shard_recipe_default(&recipe);
  printf("{\"keys\": ");
  print_keys(shard_keys);
  printf(", \"rules\": ");
  print_keys(shard_rule_keys);
  if (scree_shard_recipe_write(&recipe, text, sizeof text) >= sizeof text) return 1;
  printf(", \"defaults\": %s}\n", text);
  return 0;
}
