/* For check_schema.py: print_keys rocks|hoodoo|shards prints the table of keys of this kind of recipe and its defaults as JSON.
 * With a file behind the word: prints the recipe that it holds with every key, as scree-bake --print-recipe does, or what is wrong
 * and exits with 2. */
#include <stdio.h>
#include <string.h>

#include "hoodoo_recipe.h"
#include "recipe.h"
#include "shard_keys.h"

static void print_keys(const recipe_key* keys) {
  static const char* const kinds[] = {"text", "seed",   "count",  "counts", "count_range", "number", "numbers", "range",
                                      "bool", "choice", "object", "list",   "rows",        "values", "times",   "phases"};
  printf("[");
  for (const recipe_key* key = keys; key->name != NULL; ++key) {
    printf("%s\n{\"name\": \"%s\", \"kind\": \"%s\", \"min\": %.17g, \"max\": %.17g, \"least\": %u, \"size\": %u, \"columns\": %u",
           key == keys ? "" : ",", key->name, kinds[key->kind], key->min, key->max, key->least, key->size, key->columns);
    if (key->words != NULL) printf(", \"words\": \"%s\"", key->words);
    if (key->only != 0) printf(", \"only\": %u", key->only);
    if (key->alone) printf(", \"alone\": true");
    if (key->members != NULL) {
      printf(", \"members\": ");
      print_keys(key->members);
    }
    printf("}");
  }
  printf("]");
}

static union {
  scree_recipe rocks;
  scree_hoodoo_recipe hoodoo;
  scree_shard_recipe shards;
} plain, read;

static const recipe_table* table_of(const char* kind) {
  if (strcmp(kind, "hoodoo") == 0) {
    scree_hoodoo_default(&plain.hoodoo);
    return &hoodoo_table;
  }
  if (strcmp(kind, "shards") == 0) {
    scree_shard_recipe_default(&plain.shards);
    return &shard_table;
  }
  scree_recipe_default(&plain.rocks);
  return &rock_table;
}

static int print_recipe(const recipe_table* table, const char* path) {
  static char text[1 << 16];
  scree_error error = {{0}};
  FILE* file = fopen(path, "rb");
  if (file == NULL) return 1;
  const size_t size = fread(text, 1, sizeof text, file);
  fclose(file);
  if (recipe_read(table, &plain, text, size, &read, &error) != SCREE_OK) {
    fprintf(stderr, "%s\n", error.message);
    return 2;
  }
  if (recipe_write(table, &read, text, sizeof text) >= sizeof text) return 1;
  fputs(text, stdout);
  return 0;
}

int main(int count, char** arguments) {
  if (count < 2) return 1;
  const recipe_table* table = table_of(arguments[1]);
  if (count > 2) return print_recipe(table, arguments[2]);
  static char text[65536];
  printf("{\"keys\": ");
  print_keys(table->keys);
  printf(", \"rules\": ");
  if (table->rules != NULL)
    print_keys(table->rules);
  else
    printf("[]");
  if (recipe_write(table, &plain, text, sizeof text) >= sizeof text) return 1;
  printf(", \"defaults\": %s}\n", text);
  return 0;
}
