/* libFuzzer target: any bytes as a recipe of each kind, and as a KEY=VALUE override of one. */
#include <scree/shard_recipe.h>

#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

/* What was accepted writes itself as text that is accepted again and says the same. */
static void check_accepted(const scree_recipe* recipe) {
  size_t length = scree_recipe_write(recipe, NULL, 0);
  char* text = malloc(length + 1);
  char* again = malloc(length + 1);
  if (scree_recipe_write(recipe, text, length + 1) != length) abort();
  scree_recipe read;
  if (scree_recipe_parse(text, length, &read, NULL) != SCREE_OK) abort();
  if (scree_recipe_write(&read, again, length + 1) != length || memcmp(text, again, length) != 0) abort();
  free(again);
  free(text);
}

static void check_accepted_hoodoo(const scree_hoodoo_recipe* recipe) {
  size_t length = scree_hoodoo_write(recipe, NULL, 0);
  char* text = malloc(length + 1);
  char* again = malloc(length + 1);
  if (scree_hoodoo_write(recipe, text, length + 1) != length) abort();
  static scree_hoodoo_recipe read;
  if (scree_hoodoo_parse(text, length, &read, NULL) != SCREE_OK) abort();
  if (scree_hoodoo_write(&read, again, length + 1) != length || memcmp(text, again, length) != 0) abort();
  free(again);
  free(text);
}

static void check_accepted_shards(const scree_shard_recipe* recipe) {
  size_t length = scree_shard_recipe_write(recipe, NULL, 0);
  char* text = malloc(length + 1);
  char* again = malloc(length + 1);
  if (scree_shard_recipe_write(recipe, text, length + 1) != length) abort();
  static scree_shard_recipe read;
  if (scree_shard_recipe_parse(text, length, &read, NULL) != SCREE_OK) abort();
  if (scree_shard_recipe_write(&read, again, length + 1) != length || memcmp(text, again, length) != 0) abort();
  free(again);
  free(text);
}

static void check_refused(scree_result result, const scree_error* error) {
  const char* end = memchr(error->message, '\0', sizeof error->message);
  if (result == SCREE_OK || end == NULL || end == error->message || strchr(error->message, '\n') != NULL) abort();
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  /* An exact-size copy, so that a read past the end is seen. */
  char* text = malloc(size + 1);
  memcpy(text, data, size);
  char* exact = size > 0 ? realloc(text, size) : text;
  scree_recipe recipe;
  scree_error error;
  scree_result result = scree_recipe_parse(exact, size, &recipe, &error);
  if (result == SCREE_OK)
    check_accepted(&recipe);
  else
    check_refused(result, &error);

  static scree_hoodoo_recipe hoodoo;
  result = scree_hoodoo_parse(exact, size, &hoodoo, &error);
  if (result == SCREE_OK)
    check_accepted_hoodoo(&hoodoo);
  else
    check_refused(result, &error);
  static scree_shard_recipe shards;
  result = scree_shard_recipe_parse(exact, size, &shards, &error);
  if (result == SCREE_OK)
    check_accepted_shards(&shards);
  else
    check_refused(result, &error);
  scree_recipe_kind kind;
  result = scree_recipe_get_kind(exact, size, &kind, &error);
  if (result != SCREE_OK) check_refused(result, &error);

  char* assignment = realloc(exact, size + 1);
  assignment[size] = '\0';
  scree_recipe_default(&recipe);
  result = scree_recipe_set(&recipe, assignment, &error);
  if (result == SCREE_OK)
    check_accepted(&recipe);
  else
    check_refused(result, &error);
  scree_hoodoo_default(&hoodoo);
  result = scree_hoodoo_set(&hoodoo, assignment, &error);
  if (result == SCREE_OK)
    check_accepted_hoodoo(&hoodoo);
  else
    check_refused(result, &error);
  scree_shard_recipe_default(&shards);
  result = scree_shard_recipe_set(&shards, assignment, &error);
  if (result == SCREE_OK)
    check_accepted_shards(&shards);
  else
    check_refused(result, &error);
  free(assignment);
  return 0;
}
