/* Recipes of hoodoos: what is accepted, what is refused and by which words. Argument: the folder of the recipes that ship. */
#include <scree/hoodoo.h>

#include <dirent.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "hoodoo_recipe.h"
#include "lattice.h"
#include "one_line.h"
#include "random.h"

static const char* folder;

/* Parses a copy of just `size` bytes, so that a read past the end is seen. */
static scree_result parse(const char* text, size_t size, scree_hoodoo_recipe* out, scree_error* error) {
  char* exact = malloc(size > 0 ? size : 1);
  assert_non_null(exact);
  memcpy(exact, text, size);
  memset(error, 0, sizeof *error);
  const scree_result result = scree_hoodoo_parse(exact, size, out, error);
  free(exact);
  return result;
}

static char* write_recipe(const scree_hoodoo_recipe* recipe, size_t* size) {
  *size = scree_hoodoo_write(recipe, NULL, 0);
  char* text = malloc(*size + 1);
  assert_non_null(text);
  assert_int_equal(scree_hoodoo_write(recipe, text, *size + 1), *size);
  assert_int_equal(strlen(text), *size);
  return text;
}

static void every_truncation_is_refused(void** state) {
  (void)state;
  static scree_hoodoo_recipe recipe, out;
  scree_hoodoo_default(&recipe);
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
      {"{}", "kind: missing", SCREE_ERROR_SYNTAX},
      {"{\"kind\": \"rocks\"}", "kind: expected \"hoodoo\"", SCREE_ERROR_SYNTAX},
      {"{\"kind\": \"hoodoo\", \"colour\": 1}", "colour: unknown key", SCREE_ERROR_SYNTAX},
      {"{\"kind\": \"hoodoo\", \"voxel\": 0}", "voxel: expected a number from 0.001 to 100, got 0", SCREE_ERROR_RANGE},
      {"{\"kind\": \"hoodoo\", \"voxel\": 1e999}", "voxel", SCREE_ERROR_RANGE},
      {"{\"kind\": \"hoodoo\", \"size\": [1, 2]}", "size: expected 3 numbers, got 2", SCREE_ERROR_SYNTAX},
      {"{\"kind\": \"hoodoo\", \"size\": [1, 2, 5000]}", "size[2]", SCREE_ERROR_RANGE},
      {"{\"kind\": \"hoodoo\", \"start\": {\"shape\": \"pyramid\"}}", "start.shape: expected one of: box column",
       SCREE_ERROR_SYNTAX},
      {"{\"kind\": \"hoodoo\", \"start\": {\"shape\": \"joint_map\", \"radius\": 3}}",
       "start.radius: the shape joint_map has no such key", SCREE_ERROR_SYNTAX},
      {"{\"kind\": \"hoodoo\", \"start\": {\"shape\": \"joint_map\"}}", "start.file: missing", SCREE_ERROR_RANGE},
      {"{\"kind\": \"hoodoo\", \"start\": {\"shape\": \"box\", \"max\": [900, 1, 1]}}", "start.max[0]", SCREE_ERROR_RANGE},
      {"{\"kind\": \"hoodoo\", \"durability\": [[0, 1], [0.5, 0]]}", "durability[1].durability", SCREE_ERROR_RANGE},
      {"{\"kind\": \"hoodoo\", \"durability\": [[0.5, 1], [0.4, 1]]}",
       "durability[1].altitude: 0.4 is below that of the point before, 0.5", SCREE_ERROR_RANGE},
      {"{\"kind\": \"hoodoo\", \"durability\": [[0, 1, 1, 1, 1, 1]]}", "durability[0]: expected 2 to 5 numbers",
       SCREE_ERROR_SYNTAX},
      {"{\"kind\": \"hoodoo\", \"bubbles\": [{}, {}]}", "bubbles[1].altitude", SCREE_ERROR_RANGE},
      {"{\"kind\": \"hoodoo\", \"bubbles\": [{\"radius\": 13}]}", "bubbles[0].radius", SCREE_ERROR_RANGE},
      {"{\"kind\": \"hoodoo\", \"bubbles\": [{\"mixture\": [{\"radius\": 13}]}]}", "bubbles[0].mixture[0].radius",
       SCREE_ERROR_RANGE},
      {"{\"kind\": \"hoodoo\", \"bubbles\": [{\"mixture\": [{}], \"radius\": 3}]}", "bubbles[0].radius: belongs into",
       SCREE_ERROR_SYNTAX},
      {"{\"kind\": \"hoodoo\", \"cavernous\": {\"gain\": \"much\"}}", "cavernous.gain: expected a number, got \"much\"",
       SCREE_ERROR_SYNTAX},
      {"{\"kind\": \"hoodoo\", \"colluvium\": {\"share\": 0.1, \"share\": 0.2}}", "colluvium.share: given twice",
       SCREE_ERROR_SYNTAX},
      {"{\"kind\": \"hoodoo\", \"name\": \"a\", \"name\": \"b\"}", "name: given twice", SCREE_ERROR_SYNTAX},
      {"{\"kind\": \"hoodoo\", \"phases\": [{\"share\": 0.5, \"colluvium\": {\"share\": 3}}]}", "phases[0].colluvium.share",
       SCREE_ERROR_RANGE},
      {"{\"kind\": \"hoodoo\", \"phases\": [{\"exposure\": 1}]}", "phases[0]: expected either share or steps", SCREE_ERROR_SYNTAX},
      {"{\"kind\": \"hoodoo\", \"phases\": [{\"steps\": 1, \"durability\": [[1, 1], [0, 1]]}]}", "phases[0].durability[1].altitude",
       SCREE_ERROR_RANGE},
      {"{\"kind\": \"hoodoo\", \"ages\": [0.5, 0.5]}", "ages[1]: 0.5 is not less than the age before, 0.5", SCREE_ERROR_RANGE},
      {"{\"kind\": \"hoodoo\", \"age_steps\": [5, 4]}", "age_steps[1]", SCREE_ERROR_RANGE},
      {"{\"kind\": \"hoodoo\", \"age_steps\": [500], \"max_steps\": 400}", "age_steps[0]: 500 is more than max_steps, 400",
       SCREE_ERROR_RANGE},
      {"{\"kind\": \"hoodoo\", \"ages\": [0.5], \"age_steps\": [5]}", "not both", SCREE_ERROR_SYNTAX},
      {"{\"kind\": \"hoodoo\", \"lattice_steps\": 7}", "lattice_steps: 7 must be even", SCREE_ERROR_RANGE},
      {"{\"kind\": \"hoodoo\",\n\"name\": \"x\",\n}", "line 3", SCREE_ERROR_SYNTAX},
  };
  for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i) {
    static scree_hoodoo_recipe out;
    scree_error error;
    const scree_result result = parse(faults[i].text, strlen(faults[i].text), &out, &error);
    if (result != faults[i].result || strstr(error.message, faults[i].said) == NULL)
      fail_msg("%s gave %s: %s", faults[i].text, scree_result_string(result), error.message);
    assert_one_line(&error);
    assert_int_equal(scree_hoodoo_parse(faults[i].text, strlen(faults[i].text), &out, NULL), result);
  }
}

static void a_recipe_says_of_which_kind_it_is(void** state) {
  (void)state;
  static const struct {
    const char* text;
    scree_result result;
    scree_recipe_kind kind;
  } kinds[] = {
      {"{}", SCREE_OK, SCREE_RECIPE_ROCKS},
      {"{\"kind\": \"rocks\"}", SCREE_OK, SCREE_RECIPE_ROCKS},
      {"{\"n\": 5, \"kind\": \"hoodoo\"}", SCREE_OK, SCREE_RECIPE_HOODOO},
      {"{\"kind\": \"cliff\"}", SCREE_ERROR_SYNTAX, SCREE_RECIPE_ROCKS},
      {"{\"kind\": 1}", SCREE_ERROR_SYNTAX, SCREE_RECIPE_ROCKS},
      {"[]", SCREE_ERROR_SYNTAX, SCREE_RECIPE_ROCKS},
  };
  for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) {
    scree_recipe_kind kind = SCREE_RECIPE_ROCKS;
    assert_int_equal(scree_recipe_get_kind(kinds[i].text, strlen(kinds[i].text), &kind, NULL), kinds[i].result);
    assert_int_equal(kind, kinds[i].kind);
  }
  scree_recipe rocks;
  assert_int_equal(scree_recipe_parse("{\"kind\": \"rocks\"}", 17, &rocks, NULL), SCREE_OK);
  assert_int_equal(scree_recipe_parse("{\"kind\": \"hoodoo\"}", 18, &rocks, NULL), SCREE_ERROR_SYNTAX);
}

static uint32_t below(random_stream* stream, uint32_t limit) {
  return (uint32_t)(random_bits(stream) % limit);
}

static double between(random_stream* stream, double min, double max) {
  return random_in(stream, (scree_range){min, max});
}

static void random_rules(random_stream* stream, scree_hoodoo_rules* out) {
  out->durability_count = 1 + below(stream, SCREE_HOODOO_POINTS);
  for (uint32_t i = 0; i < out->durability_count; ++i)
    out->durability[i] = (scree_durability_point){(i + random_unit(stream)) / out->durability_count, between(stream, 0.01, 9),
                                                  between(stream, 0, 4), between(stream, 1, 100), between(stream, 0.1, 4)};
  out->bubble_count = 1 + below(stream, SCREE_HOODOO_SEGMENTS);
  for (uint32_t i = 0; i < out->bubble_count; ++i) {
    scree_bubble_segment* segment = &out->bubbles[i];
    *segment = (scree_bubble_segment){.altitude = (i + random_unit(stream)) / out->bubble_count,
                                      .bubble_count = 1 + below(stream, 4),
                                      .noise_period = between(stream, 1, 100)};
    for (uint32_t b = 0; b < segment->bubble_count; ++b)
      segment->bubbles[b] = (scree_bubble){(scree_bubble_kind)below(stream, 4), between(stream, 1, 12), between(stream, 1, 12)};
  }
  scree_curve* curves[2] = {&out->spheroidal, &out->cavernous};
  for (int i = 0; i < 2; ++i)
    *curves[i] = (scree_curve){(scree_curve_kind)below(stream, 5), between(stream, 0, 9), between(stream, -1, 1),
                               between(stream, 0.01, 2), 1 + below(stream, 4)};
  out->exposure = between(stream, 0, 2);
  out->steps_per_voxel = between(stream, 1, 100);
  out->colluvium_share = random_unit(stream);
  out->colluvium_durability = between(stream, 0.01, 9);
  out->repose = between(stream, 0.0625, 4);
  out->rockfall = (scree_rockfall)below(stream, 3);
}

static void random_recipe(random_stream* stream, scree_hoodoo_recipe* out) {
  scree_hoodoo_default(out);
  snprintf(out->name, sizeof out->name, "a \"%u\" \\ %c", below(stream, 1000), (char)(1 + below(stream, 126)));
  out->random_seed = random_bits(stream) >> 11;
  out->voxel = between(stream, 0.001, 100);
  for (int a = 0; a < 3; ++a) out->size[a] = 1 + below(stream, 4096);
  scree_hoodoo_start* start = &out->start;
  start->shape = (scree_hoodoo_shape)below(stream, 8);
  for (int a = 0; a < 3; ++a) {
    start->min[a] = below(stream, out->size[a]);
    start->max[a] = start->min[a] + 1 + below(stream, out->size[a] - start->min[a]);
  }
  start->radius = between(stream, 1, 4096);
  start->height = between(stream, 0, 4096);
  start->lift = between(stream, 0, 4096);
  start->lobes = between(stream, 0, 2);
  start->spacing = between(stream, 4, 4096);
  start->gap = between(stream, 0, 0.5);
  start->warp = random_unit(stream);
  start->missing = random_unit(stream);
  start->low = random_unit(stream);
  strcpy(start->file, "a/b.png");
  random_rules(stream, &out->rules);
  out->phase_count = below(stream, SCREE_HOODOO_PHASES + 1);
  for (uint32_t i = 0; i < out->phase_count; ++i) {
    out->phases[i] = (scree_hoodoo_phase){.share = random_unit(stream), .changes = below(stream, 256)};
    if (below(stream, 2) == 0) {
      out->phases[i].share = -1;
      out->phases[i].steps = below(stream, 1000000);
    }
    random_rules(stream, &out->phases[i].rules);
  }
  out->variants = 1 + below(stream, 255);
  out->age_count = out->age_step_count = 0;
  const uint32_t ages = 1 + below(stream, SCREE_HOODOO_AGES);
  for (uint32_t i = 0; i < ages; ++i) {
    out->ages[i] = 1 - (i + random_unit(stream)) / (ages + 1);
    out->age_steps[i] = i * 600 + below(stream, 600);
  }
  *(below(stream, 2) == 0 ? &out->age_count : &out->age_step_count) = ages;
  out->max_steps = 10000 + below(stream, 1000);
  out->lod_levels = 1 + below(stream, 6);
  out->lattice_steps = 2 + 2 * below(stream, 32);
  out->parts = below(stream, 2) == 1;
}

static void what_is_written_reads_back_the_same(void** state) {
  (void)state;
  random_stream stream = {2007};
  static scree_hoodoo_recipe recipe, again;
  for (int round = 0; round < 100; ++round) {
    scree_error error;
    random_recipe(&stream, &recipe);
    memset(&error, 0, sizeof error);
    if (hoodoo_check_all(&recipe, &error) != SCREE_OK) fail_msg("%s", error.message);
    size_t size, size_again;
    char* text = write_recipe(&recipe, &size);
    if (parse(text, size, &again, &error) != SCREE_OK) fail_msg("%s: %s", error.message, text);
    char* text_again = write_recipe(&again, &size_again);
    assert_string_equal(text, text_again);
    /* Not only as text: the numbers that weathering goes by. */
    assert_memory_equal(recipe.rules.durability, again.rules.durability,
                        recipe.rules.durability_count * sizeof *recipe.rules.durability);
    assert_memory_equal(recipe.size, again.size, sizeof recipe.size);
    assert_true(recipe.random_seed == again.random_seed && recipe.voxel == again.voxel &&
                recipe.rules.repose == again.rules.repose);
    assert_true(recipe.phase_count == again.phase_count && recipe.age_count == again.age_count);
    for (uint32_t i = 0; i < recipe.phase_count; ++i) {
      assert_int_equal(recipe.phases[i].changes, again.phases[i].changes);
      assert_true(recipe.phases[i].share == again.phases[i].share && recipe.phases[i].steps == again.phases[i].steps);
    }
    /* A buffer too small gets what fits, and the size that is needed. */
    char small[16];
    assert_int_equal(scree_hoodoo_write(&recipe, small, sizeof small), size);
    assert_memory_equal(small, text, sizeof small - 1);
    free(text);
    free(text_again);
  }
}

static void numbers_that_did_not_come_from_json_are_checked_too(void** state) {
  (void)state;
  static scree_hoodoo_recipe recipe;
  scree_error error;
#define REFUSED(change, said)                                               \
  do {                                                                      \
    scree_hoodoo_default(&recipe);                                          \
    change;                                                                 \
    memset(&error, 0, sizeof error);                                        \
    assert_int_equal(hoodoo_check_all(&recipe, &error), SCREE_ERROR_RANGE); \
    if (strstr(error.message, said) == NULL) fail_msg("%s", error.message); \
  } while (0)
  REFUSED(recipe.voxel = (double)NAN, "voxel");
  REFUSED(recipe.rules.durability[3].durability = (double)NAN, "durability[3].durability");
  REFUSED(recipe.rules.durability_count = 33, "durability");
  REFUSED(recipe.rules.bubble_count = 0, "bubbles");
  REFUSED(recipe.rules.bubbles[0].bubble_count = 5, "bubbles[0]");
  REFUSED(recipe.rules.bubbles[0].bubbles[0].radius = 100, "bubbles[0].radius");
  REFUSED(recipe.rules.spheroidal.gain = (double)INFINITY, "spheroidal.gain");
  REFUSED(recipe.rules.repose = 0, "colluvium.repose");
  REFUSED(recipe.start.shape = (scree_hoodoo_shape)99, "start.shape");
  REFUSED(recipe.start.lobes = -1, "start.lobes");
  REFUSED(recipe.ages[1] = (double)NAN, "ages[1]");
  REFUSED(recipe.age_count = 17, "ages");
  REFUSED(recipe.age_count = 0, "ages");
  REFUSED(recipe.phase_count = SCREE_HOODOO_PHASES + 1, "phases");
  REFUSED((recipe.phase_count = 1, recipe.phases[0].share = 2), "phases[0].share");
  REFUSED((recipe.phase_count = 1, recipe.phases[0].changes = SCREE_HOODOO_EXPOSURE, recipe.phases[0].rules.exposure = 3),
          "phases[0].exposure");
  REFUSED(memset(recipe.name, 'x', sizeof recipe.name), "name");
  REFUSED(recipe.variants = 0, "variants");
}

static void one_key_can_be_set_and_a_wrong_one_changes_nothing(void** state) {
  (void)state;
  static scree_hoodoo_recipe recipe, before;
  scree_error error;
  scree_hoodoo_default(&recipe);
  assert_int_equal(scree_hoodoo_set(&recipe, "variants=7", &error), SCREE_OK);
  assert_int_equal(recipe.variants, 7);
  assert_int_equal(scree_hoodoo_set(&recipe, "start.radius=20", &error), SCREE_OK);
  assert_true(recipe.start.radius == 20 && recipe.start.shape == SCREE_HOODOO_COLUMN);
  assert_int_equal(scree_hoodoo_set(&recipe, "colluvium.share=0.5", &error), SCREE_OK);
  assert_true(recipe.rules.colluvium_share == 0.5);
  assert_int_equal(scree_hoodoo_set(&recipe, "spheroidal.curve=quartic", &error), SCREE_OK);
  assert_int_equal(recipe.rules.spheroidal.kind, SCREE_CURVE_QUARTIC);
  assert_int_equal(scree_hoodoo_set(&recipe, "durability=[[0,1],[1,2]]", &error), SCREE_OK);
  assert_int_equal(recipe.rules.durability_count, 2);
  assert_int_equal(scree_hoodoo_set(&recipe, "age_steps=[5,9]", &error), SCREE_OK);
  assert_true(recipe.age_count == 0 && recipe.age_step_count == 2);
  assert_int_equal(scree_hoodoo_set(&recipe, "rockfall=drop", &error), SCREE_OK);
  assert_int_equal(recipe.rules.rockfall, SCREE_ROCKFALL_DROP);
  static const char* const wrong[][2] = {
      {"variants", "expected KEY=VALUE"},
      {"=5", "unknown key"},
      {"n=5", "n: unknown key"},
      {"start.size=5", "start.size: unknown key"},
      {"rules.exposure=5", "unknown key"},
      {"exposure.x=5", "unknown key"},
      {"start.file=a.png", "start.file: the shape column has no such key"},
      {"variants=0", "variants"},
      {"ages=[0.5,0.6]", "ages[1]"},
      {"lattice_steps=5", "lattice_steps"},
  };
  memcpy(&before, &recipe, sizeof before);
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
    memset(&error, 0, sizeof error);
    if (scree_hoodoo_set(&recipe, wrong[i][0], &error) == SCREE_OK) fail_msg("%s was accepted", wrong[i][0]);
    if (strstr(error.message, wrong[i][1]) == NULL) fail_msg("%s: %s", wrong[i][0], error.message);
    assert_one_line(&error);
    assert_memory_equal(&recipe, &before, sizeof before);
  }
}

static void shipped_recipes_are_accepted(void** state) {
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
    if (kind != SCREE_RECIPE_HOODOO) continue;
    static scree_hoodoo_recipe recipe;
    scree_error error;
    if (parse(text, size, &recipe, &error) != SCREE_OK) fail_msg("%s: %s", path, error.message);
    for (size_t c = 0; c < length - 5; ++c) assert_int_equal(entry->d_name[c], recipe.name[c] == ' ' ? '_' : recipe.name[c]);
    ++count;
  }
  closedir(directory);
  assert_true(count >= 8);
}

int main(int count, char** arguments) {
  if (count != 2) return 2;
  folder = arguments[1];
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_truncation_is_refused),
      cmocka_unit_test(faults_are_refused_by_name),
      cmocka_unit_test(a_recipe_says_of_which_kind_it_is),
      cmocka_unit_test(what_is_written_reads_back_the_same),
      cmocka_unit_test(numbers_that_did_not_come_from_json_are_checked_too),
      cmocka_unit_test(one_key_can_be_set_and_a_wrong_one_changes_nothing),
      cmocka_unit_test(shipped_recipes_are_accepted),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
