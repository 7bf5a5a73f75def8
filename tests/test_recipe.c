/* Recipes: what is accepted, what is refused and by which words. Argument: the folder of the recipes that ship. */
#include <scree/bake.h>

#include <dirent.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "lattice.h"
#include "one_line.h"
#include "random.h"
#include "recipe.h"

static const char* folder;

/* Parses a copy of just `size` bytes, so that a read past the end is seen. */
static scree_result parse(const char* text, size_t size, scree_recipe* out, scree_error* error) {
  char* exact = malloc(size > 0 ? size : 1);
  assert_non_null(exact);
  memcpy(exact, text, size);
  memset(error, 0, sizeof *error);
  const scree_result result = scree_recipe_parse(exact, size, out, error);
  free(exact);
  return result;
}

static char* write_recipe(const scree_recipe* recipe, size_t* size) {
  *size = scree_recipe_write(recipe, NULL, 0);
  char* text = malloc(*size + 1);
  assert_non_null(text);
  assert_int_equal(scree_recipe_write(recipe, text, *size + 1), *size);
  assert_int_equal(strlen(text), *size);
  return text;
}

static void every_truncation_is_refused(void** state) {
  (void)state;
  scree_recipe recipe, out;
  scree_recipe_default(&recipe);
  size_t size;
  char* text = write_recipe(&recipe, &size);
  scree_error error;
  assert_int_equal(parse(text, size, &out, &error), SCREE_OK);
  for (size_t cut = 0; cut + 1 < size; ++cut) { /* the last byte is a line break */
    assert_int_equal(parse(text, cut, &out, &error), SCREE_ERROR_SYNTAX);
    assert_one_line(&error);
  }
  free(text);
}

static void faults_are_refused_by_name(void** state) {
  (void)state;
  static const struct {
    const char *text, *said;
    scree_result result;
  } faults[] = {
      {"[]", "object", SCREE_ERROR_SYNTAX},
      {"5", "object", SCREE_ERROR_SYNTAX},
      {"{\"n\": 5} x", "JSON", SCREE_ERROR_SYNTAX},
      {"{\"n\": 5}}", "JSON", SCREE_ERROR_SYNTAX},
      {"{\n\"n\": 5,\n}", "line 3", SCREE_ERROR_SYNTAX},
      {"{\"n\": NaN}", "JSON", SCREE_ERROR_SYNTAX},
      {"{\"jitter\": Infinity}", "JSON", SCREE_ERROR_SYNTAX},
      {"{\"jitter\": 1e999}", "jitter", SCREE_ERROR_RANGE},
      {"{\"jitter\": -1e999}", "jitter", SCREE_ERROR_RANGE},
      {"{\"alpha\": [1, 1e400]}", "alpha", SCREE_ERROR_RANGE},
      {"{\"n\": 5.5}", "n", SCREE_ERROR_RANGE},
      {"{\"n\": 4294967301}", "n", SCREE_ERROR_RANGE},
      {"{\"n\": \"5\"}", "n: expected a number, got \"5\"", SCREE_ERROR_SYNTAX},
      {"{\"n\": null}", "n: expected a number, got null", SCREE_ERROR_SYNTAX},
      {"{\"n\": true}", "n: expected a number, got true", SCREE_ERROR_SYNTAX},
      {"{\"n\": [5, 6]}", "n: expected a number, got an array", SCREE_ERROR_SYNTAX},
      {"{\"n\": {}}", "n: expected a number, got an object", SCREE_ERROR_SYNTAX},
      {"{\"seeds\": []}", "seeds", SCREE_ERROR_SYNTAX},
      {"{\"seeds\": [1, 2, 3]}", "seeds", SCREE_ERROR_SYNTAX},
      {"{\"seeds\": [5, 2]}", "seeds", SCREE_ERROR_RANGE},
      {"{\"seeds\": [1, \"2\"]}", "seeds", SCREE_ERROR_SYNTAX},
      {"{\"g\": [3, 1]}", "g", SCREE_ERROR_RANGE},
      {"{\"name\": 5}", "name", SCREE_ERROR_SYNTAX},
      {"{\"name\": \"0123456789012345678901234567890123456789012345678901234567890123\"}", "name", SCREE_ERROR_SYNTAX},
      {"{\"orientation\": \"sideways\"}", "orientation: expected one of: random aligned; got \"sideways\"", SCREE_ERROR_SYNTAX},
      {"{\"orientation\": \"\"}", "orientation", SCREE_ERROR_SYNTAX},
      {"{\"orientation\": 1}", "orientation", SCREE_ERROR_SYNTAX},
      {"{\"align_axis\": [0, 1]}", "align_axis", SCREE_ERROR_SYNTAX},
      {"{\"align_axis\": [0, 1, \"x\"]}", "align_axis", SCREE_ERROR_SYNTAX},
      {"{\"align_axis\": [0, 0, 0], \"orientation\": \"aligned\"}", "align_axis", SCREE_ERROR_RANGE},
      {"{\"contact_radius\": 0.5, \"contact_blend\": 0.4}", "contact_blend", SCREE_ERROR_RANGE},
      {"{\"lattice_steps\": 7}", "lattice_steps", SCREE_ERROR_RANGE},
      {"{\"voxels_per_cell\": 7}", "voxels_per_cell", SCREE_ERROR_RANGE},
      {"{\"colour\": 1}", "colour: unknown key", SCREE_ERROR_SYNTAX},
      {"{\"N\": 5}", "N: unknown key", SCREE_ERROR_SYNTAX},
      {"{\"\": 5}", "unknown key", SCREE_ERROR_SYNTAX},
      {"{\"n\": 5, \"jitter\": 1, \"n\": 5}", "n: given twice", SCREE_ERROR_SYNTAX},
  };
  for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i) {
    scree_recipe out;
    scree_error error;
    const scree_result result = parse(faults[i].text, strlen(faults[i].text), &out, &error);
    if (result != faults[i].result || strstr(error.message, faults[i].said) == NULL)
      fail_msg("%s gave %s: %s", faults[i].text, scree_result_string(result), error.message);
    assert_one_line(&error);
  }
}

static void deep_nesting_is_refused(void** state) {
  (void)state;
  static const char brackets[2] = {'[', '{'};
  for (int kind = 0; kind < 2; ++kind) {
    const size_t depth = 200000;
    char* text = malloc(depth + 8);
    assert_non_null(text);
    memcpy(text, "{\"n\":", 5);
    memset(text + 5, brackets[kind], depth);
    scree_recipe out;
    scree_error error;
    assert_int_equal(parse(text, depth + 5, &out, &error), SCREE_ERROR_SYNTAX);
    assert_one_line(&error);
    free(text);
  }
}

/* One key at its ends and just beyond them, from the table. */
static void keys_are_accepted_up_to_their_ends_and_refused_beyond(void** state) {
  (void)state;
  uint32_t refused = 0;
  for (const recipe_key* key = rock_table.keys; key->name != NULL; ++key) {
    if (key->kind == RECIPE_TEXT || key->kind == RECIPE_CHOICE || key->kind == RECIPE_BOOL) continue;
    const bool whole = key->kind == RECIPE_COUNT || key->kind == RECIPE_COUNT_RANGE || key->kind == RECIPE_SEED;
    const double step = whole ? 1 : fabs(key->max) * 1e-9 + 1e-12;
    const double values[4] = {key->min, key->max, key->min - step, key->max + (key->kind == RECIPE_SEED ? 2 : step)};
    for (int i = 0; i < 4; ++i) {
      char text[128];
      snprintf(text, sizeof text, key->kind == RECIPE_NUMBERS ? "{\"%s\": [1, 1, %.17g]}" : "{\"%s\": %.17g}", key->name,
               values[i]);
      scree_recipe out;
      scree_error error;
      const scree_result result = parse(text, strlen(text), &out, &error);
      if (i < 2) {
        /* The end of one key may not go with the default of another; then that is said. */
        if (result != SCREE_OK && strstr(error.message, "contact_blend") == NULL) fail_msg("%s: %s", text, error.message);
      } else {
        if (result != SCREE_ERROR_RANGE || strncmp(error.message, key->name, strlen(key->name)) != 0)
          fail_msg("%s gave %s: %s", text, scree_result_string(result), error.message);
        ++refused;
      }
    }
  }
  assert_true(refused > 40);
}

static double random_number(random_stream* stream, const recipe_key* key, bool whole) {
  const double value = random_in(stream, (scree_range){key->min, key->max});
  return whole ? floor(value) : value;
}

/* A recipe with every key anywhere in its range. */
static void random_recipe(random_stream* stream, scree_recipe* out) {
  scree_recipe_default(out);
  for (const recipe_key* key = rock_table.keys; key->name != NULL; ++key) {
    char* field = (char*)out + key->offset;
    switch (key->kind) {
      case RECIPE_TEXT:
        for (uint32_t i = 0, length = (uint32_t)(random_bits(stream) % 64); i <= length; ++i)
          field[i] = i == length ? '\0' : (char)(1 + random_bits(stream) % 126);
        break;
      case RECIPE_SEED: *(uint64_t*)(void*)field = (uint64_t)random_number(stream, key, true); break;
      case RECIPE_BOOL: *(bool*)(void*)field = random_bits(stream) % 2 == 1; break;
      case RECIPE_COUNT: *(uint32_t*)(void*)field = (uint32_t)random_number(stream, key, true); break;
      case RECIPE_COUNT_RANGE:
        out->seeds_min = (uint32_t)random_number(stream, key, true);
        out->seeds_max = out->seeds_min + (uint32_t)(random_bits(stream) % 2) * (20 - out->seeds_min);
        break;
      case RECIPE_NUMBER: *(double*)(void*)field = random_number(stream, key, false); break;
      case RECIPE_RANGE: {
        scree_range* range = (scree_range*)(void*)field;
        range->min = random_number(stream, key, false);
        range->max = random_bits(stream) % 2 ? range->min : key->max;
        break;
      }
      case RECIPE_NUMBERS:
        for (int i = 0; i < 3; ++i) out->align_axis[i] = random_number(stream, key, false);
        break;
      case RECIPE_CHOICE: out->orientation = (scree_orientation)(random_bits(stream) % 2); break;
      default: fail_msg("%s is of a kind that recipes of rocks have not", key->name);
    }
  }
  out->voxels_per_cell &= ~1u;
  out->lattice_steps &= ~1u;
  if (out->contact_blend <= out->contact_radius) out->contact_blend = out->contact_radius + 0.1;
}

static void what_is_written_reads_back_the_same(void** state) {
  (void)state;
  random_stream stream = {2009};
  for (int round = 0; round < 500; ++round) {
    scree_recipe recipe, again;
    scree_error error;
    random_recipe(&stream, &recipe);
    size_t size;
    char* text = write_recipe(&recipe, &size);
    if (parse(text, size, &again, &error) != SCREE_OK) fail_msg("%s: %s", error.message, text);
    for (const recipe_key* key = rock_table.keys; key->name != NULL; ++key) {
      static const size_t sizes[] = {
          [RECIPE_SEED] = sizeof(uint64_t), [RECIPE_COUNT] = sizeof(uint32_t),          [RECIPE_COUNT_RANGE] = 2 * sizeof(uint32_t),
          [RECIPE_NUMBER] = sizeof(double), [RECIPE_NUMBERS] = 3 * sizeof(double),      [RECIPE_RANGE] = sizeof(scree_range),
          [RECIPE_BOOL] = sizeof(bool),     [RECIPE_CHOICE] = sizeof(scree_orientation)};
      const char *a = (const char*)&recipe + key->offset, *b = (const char*)&again + key->offset;
      if (key->kind == RECIPE_TEXT)
        assert_string_equal(a, b);
      else
        assert_memory_equal(a, b, sizes[key->kind]);
    }
    /* A buffer too small gets what fits, and the size that is needed. */
    char small[16];
    assert_int_equal(scree_recipe_write(&recipe, small, sizeof small), size);
    assert_memory_equal(small, text, sizeof small - 1);
    assert_int_equal(small[sizeof small - 1], '\0');
    free(text);
  }
}

static void one_key_can_be_set_and_a_wrong_one_changes_nothing(void** state) {
  (void)state;
  scree_recipe recipe, before;
  scree_error error;
  scree_recipe_default(&recipe);
  assert_int_equal(scree_recipe_set(&recipe, "n=5", &error), SCREE_OK);
  assert_int_equal(recipe.n, 5);
  assert_int_equal(scree_recipe_set(&recipe, "g=[1,2]", &error), SCREE_OK);
  assert_true(recipe.g.min == 1 && recipe.g.max == 2);
  assert_int_equal(scree_recipe_set(&recipe, "seeds=3", &error), SCREE_OK);
  assert_true(recipe.seeds_min == 3 && recipe.seeds_max == 3);
  assert_int_equal(scree_recipe_set(&recipe, "orientation=aligned", &error), SCREE_OK);
  assert_int_equal(recipe.orientation, SCREE_ORIENTATION_ALIGNED);
  assert_int_equal(scree_recipe_set(&recipe, "name=two words", &error), SCREE_OK);
  assert_string_equal(recipe.name, "two words");
  static const char* const wrong[][2] = {
      {"n", "n: expected KEY=VALUE"},
      {"", "expected KEY=VALUE"},
      {"=5", "unknown key"},
      {"m=5", "m: unknown key"},
      {"n=", "n"},
      {"n=99", "n"},
      {"n=five", "n"},
      {"g=[2,1]", "g"},
      {"g=[1,2", "g"},
      {"contact_blend=0.01", "contact_blend"},
      {"lattice_steps=5", "lattice_steps"},
      {"orientation=up", "orientation"},
  };
  memcpy(&before, &recipe, sizeof before);
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
    memset(&error, 0, sizeof error);
    if (scree_recipe_set(&recipe, wrong[i][0], &error) == SCREE_OK) fail_msg("%s was accepted", wrong[i][0]);
    if (strstr(error.message, wrong[i][1]) == NULL) fail_msg("%s: %s", wrong[i][0], error.message);
    assert_one_line(&error);
    assert_memory_equal(&recipe, &before, sizeof before);
  }
  char long_key[2000];
  memset(long_key, 'k', sizeof long_key - 1);
  long_key[sizeof long_key - 1] = '\0';
  assert_int_equal(scree_recipe_set(&recipe, long_key, &error), SCREE_ERROR_SYNTAX);
  assert_int_equal(scree_recipe_set(&recipe, "n=99", NULL), SCREE_ERROR_RANGE);
}

static void shipped_recipes_are_accepted_and_boulders_are_the_default(void** state) {
  (void)state;
  DIR* directory = opendir(folder);
  assert_non_null(directory);
  uint32_t count = 0;
  for (const struct dirent* entry; (entry = readdir(directory)) != NULL;) {
    const size_t length = strlen(entry->d_name);
    if (length < 6 || strcmp(entry->d_name + length - 5, ".json") != 0) continue;
    char path[1024], text[65536];
    snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
    FILE* file = fopen(path, "rb");
    assert_non_null(file);
    const size_t size = fread(text, 1, sizeof text, file);
    fclose(file);
    scree_recipe_kind kind;
    assert_int_equal(scree_recipe_get_kind(text, size, &kind, NULL), SCREE_OK);
    if (kind != SCREE_RECIPE_ROCKS) continue;
    scree_recipe recipe;
    scree_error error;
    if (parse(text, size, &recipe, &error) != SCREE_OK) fail_msg("%s: %s", path, error.message);
    assert_int_equal(recipe_check_all(&recipe, NULL), SCREE_OK);
    assert_int_equal(strlen(recipe.name), length - 5);
    for (size_t c = 0; c < length - 5; ++c) assert_int_equal(entry->d_name[c], recipe.name[c] == ' ' ? '_' : recipe.name[c]);
    if (strcmp(recipe.name, "boulders") == 0) {
      scree_recipe plain;
      scree_recipe_default(&plain);
      size_t a, b;
      char *written = write_recipe(&recipe, &a), *expected = write_recipe(&plain, &b);
      assert_string_equal(written, expected);
      free(written);
      free(expected);
    }
    ++count;
  }
  closedir(directory);
  assert_true(count >= 5);
}

int main(int count, char** arguments) {
  if (count != 2) return 2;
  folder = arguments[1];
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_truncation_is_refused),
      cmocka_unit_test(faults_are_refused_by_name),
      cmocka_unit_test(deep_nesting_is_refused),
      cmocka_unit_test(keys_are_accepted_up_to_their_ends_and_refused_beyond),
      cmocka_unit_test(what_is_written_reads_back_the_same),
      cmocka_unit_test(one_key_can_be_set_and_a_wrong_one_changes_nothing),
      cmocka_unit_test(shipped_recipes_are_accepted_and_boulders_are_the_default),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
