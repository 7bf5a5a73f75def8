/* Recipes of shards: what is accepted, what is refused and by which words. Argument: the folder of the recipes that ship. */
#include <scree/shard_recipe.h>

#include <dirent.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "one_line.h"
#include "random.h"
#include "shard_keys.h"

static const char* folder;

/* Parses a copy of just `size` bytes, so that a read past the end is seen. */
static scree_result parse(const char* text, size_t size, scree_shard_recipe* out, scree_error* error) {
  char* exact = malloc(size > 0 ? size : 1);
  assert_non_null(exact);
  memcpy(exact, text, size);
  memset(error, 0, sizeof *error);
  const scree_result result = scree_shard_recipe_parse(exact, size, out, error);
  free(exact);
  return result;
}

static char* write_recipe(const scree_shard_recipe* recipe, size_t* size) {
  *size = scree_shard_recipe_write(recipe, NULL, 0);
  char* text = malloc(*size + 1);
  assert_non_null(text);
  assert_int_equal(scree_shard_recipe_write(recipe, text, *size + 1), *size);
  assert_int_equal(strlen(text), *size);
  return text;
}

static void every_truncation_is_refused(void** state) {
  (void)state;
  static scree_shard_recipe recipe, out;
  scree_shard_recipe_default(&recipe);
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

static void the_default_is_the_papers(void** state) {
  (void)state;
  static scree_shard_recipe recipe;
  scree_frost_rules rules;
  scree_shard_recipe_default(&recipe);
  assert_int_equal(shard_check_all(&recipe, NULL), SCREE_OK);
  scree_shard_rules_view(&(scree_shard_desc){.recipe = &recipe}, &recipe.rules, &rules);
  assert_true(rules.rain_count == 1 && rules.rains[0].direction[1] == -1 && rules.rains[0].spread == 0.5);
  assert_true(rules.water == 1 && rules.gravity[1] == -1 && rules.resistance.value == 0.5);
  assert_true(rules.solid_absorption == 0.1 && rules.air_absorption == 0.05 && rules.resistance_absorption == 0.25);
  assert_true(rules.damage == 0.5 && rules.total_absorption && rules.break_life == 0.4 && rules.break_chance == 0.9);
  assert_true(rules.strength == 0 && rules.fall == SCREE_FALL_KEPT && rules.fall_life == 1 && rules.density == 2600);
  assert_true(recipe.seeds.count == 2908 && recipe.input.rings == 3 && recipe.input.sides == 24);
}

static void faults_are_refused_by_name(void** state) {
  (void)state;
  static const struct {
    const char *members, *said;
    scree_result result;
  } faults[] = {
      {"\"colour\": 1", "colour: unknown key", SCREE_ERROR_SYNTAX},
      {"\"name\": 5", "name: expected a text of at most 63 bytes, got 5", SCREE_ERROR_SYNTAX},
      {"\"name\": \"a\", \"name\": \"b\"", "name: given twice", SCREE_ERROR_SYNTAX},
      {"\"input\": 5", "input: expected an object, got 5", SCREE_ERROR_SYNTAX},
      {"\"input\": {\"shape\": \"pyramid\"}", "input.shape: expected one of: box hill", SCREE_ERROR_SYNTAX},
      {"\"input\": {\"shape\": \"box\", \"radius\": 3}", "input.radius: the shape box has no such key", SCREE_ERROR_SYNTAX},
      {"\"input\": {\"radius\": 3, \"shape\": \"box\"}", "input.radius: the shape box has no such key", SCREE_ERROR_SYNTAX},
      {"\"input\": {\"shape\": \"box\", \"size\": [1, 2]}", "input.size: expected 3 numbers, got 2", SCREE_ERROR_SYNTAX},
      {"\"input\": {\"shape\": \"box\", \"size\": [1, 0, 2]}", "input.size[1]: expected a number from 0.01 to 100000, got 0",
       SCREE_ERROR_RANGE},
      {"\"input\": {\"shape\": \"mesh\"}", "input.file: missing", SCREE_ERROR_RANGE},
      {"\"input\": {\"shape\": \"terrain\", \"file\": \"a.png\", \"low\": 5, \"high\": 5}",
       "input.high: 5 is not above input.low, 5", SCREE_ERROR_RANGE},
      {"\"input\": {\"shape\": \"terrain\", \"file\": \"a.png\", \"crop\": [0, 0, 1, 5]}",
       "input.crop: expected at least 2 columns", SCREE_ERROR_RANGE},
      {"\"input\": {\"shape\": \"capsule\", \"radius\": 3, \"height\": 5}", "input.height: 5 is less than twice input.radius, 3",
       SCREE_ERROR_RANGE},
      {"\"input\": {\"shape\": \"sphere\", \"resolution\": 7}", "input.resolution: expected 0 or", SCREE_ERROR_RANGE},
      {"\"seeds\": {\"pattern\": \"hexagons\"}", "seeds.pattern: expected one of: random grid", SCREE_ERROR_SYNTAX},
      {"\"seeds\": {\"pattern\": \"grid\", \"length\": 2}", "seeds.length: the pattern grid has no such key", SCREE_ERROR_SYNTAX},
      {"\"seeds\": {\"pattern\": \"points\", \"points\": []}", "seeds.points: expected 1 to 1024 points, got 0",
       SCREE_ERROR_SYNTAX},
      {"\"seeds\": {\"pattern\": \"points\"}", "seeds.points: missing", SCREE_ERROR_RANGE},
      {"\"seeds\": {\"pattern\": \"points\", \"points\": [[1, 2]]}", "seeds.points[0]: expected 3 numbers: x, y, z, got 2",
       SCREE_ERROR_SYNTAX},
      {"\"seeds\": {\"pattern\": \"slabs\", \"layers\": [1, 0]}", "seeds.layers[1]", SCREE_ERROR_RANGE},
      {"\"seeds\": {\"up\": [0, 0, 0]}", "seeds.up: a direction must not be zero", SCREE_ERROR_RANGE},
      {"\"seeds\": {\"stretch\": [1, 0, 1]}", "seeds.stretch[1]", SCREE_ERROR_RANGE},
      {"\"clip\": \"both\"", "clip: expected one of: auto walls mesh; got \"both\"", SCREE_ERROR_SYNTAX},
      {"\"link_angle\": 0", "link_angle", SCREE_ERROR_RANGE},
      {"\"rains\": []", "rains: expected 1 to 4 rains, got 0", SCREE_ERROR_SYNTAX},
      {"\"rains\": [{}, {\"direction\": [0, 0, 0]}]", "rains[1].direction: a direction must not be zero", SCREE_ERROR_RANGE},
      {"\"rains\": [{\"spread\": 4}]", "rains[0].spread", SCREE_ERROR_RANGE},
      {"\"rains\": [{\"weight\": 0}]", "rains[0].weight", SCREE_ERROR_RANGE},
      {"\"rains\": [{\"spread\": 1, \"spread\": 1}]", "rains[0].spread: given twice", SCREE_ERROR_SYNTAX},
      {"\"water\": 0", "water", SCREE_ERROR_RANGE},
      {"\"water\": 1e999", "water", SCREE_ERROR_RANGE},
      {"\"gravity\": [0, 0, 0]", "gravity: a direction must not be zero", SCREE_ERROR_RANGE},
      {"\"resistance\": 0.5", "resistance: expected an object, got 0.5", SCREE_ERROR_SYNTAX},
      {"\"resistance\": {\"kind\": \"images\"}", "images.file: missing; resistance needs it", SCREE_ERROR_RANGE},
      {"\"resistance\": {\"kind\": \"layers\", \"layers\": [[0, 0.5], [0, 0.6]]}",
       "resistance.layers[1]: 0 is not above the place before, 0", SCREE_ERROR_RANGE},
      {"\"resistance\": {\"kind\": \"layers\", \"layers\": [[0, 1.5]]}", "resistance.layers[0].value", SCREE_ERROR_RANGE},
      {"\"resistance\": {\"kind\": \"noise\", \"layers\": [[0, 1]]}", "resistance.layers: the kind noise has no such key",
       SCREE_ERROR_SYNTAX},
      {"\"absorption\": {\"total\": 1}", "absorption.total: expected true or false, got 1", SCREE_ERROR_SYNTAX},
      {"\"breakage\": {\"chance\": 2}", "breakage.chance", SCREE_ERROR_RANGE},
      {"\"fall\": \"slow\"", "fall: expected one of: gone kept", SCREE_ERROR_SYNTAX},
      {"\"fall_life\": -1", "fall_life", SCREE_ERROR_RANGE},
      {"\"stability\": {\"interval\": 0.5}", "stability.interval: expected a whole number", SCREE_ERROR_RANGE},
      {"\"images\": {\"min\": [0, 0, 0], \"max\": [1, 0, 1]}", "images.max[1]: 0 is not above min[1], 0", SCREE_ERROR_RANGE},
      {"\"states\": [{\"where\": \"top\"}]", "states[0].where: expected one of: all exterior", SCREE_ERROR_SYNTAX},
      {"\"states\": [{}, {\"where\": \"base\", \"offset\": 2}]", "states[1].offset: the where base has no such key",
       SCREE_ERROR_SYNTAX},
      {"\"states\": [{\"where\": \"facing\", \"direction\": [0, 0, 0]}]", "states[0].direction: a direction must not be zero",
       SCREE_ERROR_RANGE},
      {"\"states\": [{\"where\": \"box\", \"min\": [1, 1, 1], \"max\": [2, 1, 2]}]", "states[0].max[1]: 1 is not above min[1], 1",
       SCREE_ERROR_RANGE},
      {"\"phases\": [{\"water\": 1}]", "phases[0]: expected either share or paths", SCREE_ERROR_SYNTAX},
      {"\"phases\": [{\"share\": 0.5, \"paths\": 5}]", "phases[0]: expected either share or paths", SCREE_ERROR_SYNTAX},
      {"\"phases\": [{\"paths\": 5, \"absorption\": {\"solid\": -3}}]", "phases[0].absorption.solid", SCREE_ERROR_RANGE},
      {"\"phases\": [{\"paths\": 5, \"gravity\": [0, 0, 0]}]", "phases[0].gravity: a direction", SCREE_ERROR_RANGE},
      {"\"phases\": [{\"paths\": 5, \"name\": \"x\"}]", "phases[0].name: unknown key", SCREE_ERROR_SYNTAX},
      {"\"paths\": [5, 5]", "paths[1]: 5 is not more than the time before, 5", SCREE_ERROR_RANGE},
      {"\"paths\": [500], \"max_paths\": 400", "paths[0]: 500 is more than max_paths, 400", SCREE_ERROR_RANGE},
      {"\"paths\": []", "paths: expected 1 to 16 times, got 0", SCREE_ERROR_SYNTAX},
      {"\"shares\": [0.5, 0.6]", "shares[1]: 0.6 is not less than the time before, 0.5", SCREE_ERROR_RANGE},
      {"\"shares\": [0.5], \"paths\": [5]", "not both", SCREE_ERROR_SYNTAX},
      {"\"rubble\": {\"repose\": 0}", "rubble.repose", SCREE_ERROR_RANGE},
      {"\"lod_levels\": 7", "lod_levels", SCREE_ERROR_RANGE},
      {"\"lattice_per_metre\": 5000", "lattice_per_metre", SCREE_ERROR_RANGE},
      {"\n\"name\": \"x\",\n", "line 3", SCREE_ERROR_SYNTAX},
  };
  static scree_shard_recipe out;
  scree_error error;
  for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i) {
    char text[512];
    snprintf(text, sizeof text, "{\"kind\": \"shards\", %s}", faults[i].members);
    const scree_result result = parse(text, strlen(text), &out, &error);
    if (result != faults[i].result || strstr(error.message, faults[i].said) == NULL)
      fail_msg("%s gave %s: %s", text, scree_result_string(result), error.message);
    assert_one_line(&error);
    assert_int_equal(scree_shard_recipe_parse(text, strlen(text), &out, NULL), result);
  }
  assert_int_equal(parse("{}", 2, &out, &error), SCREE_ERROR_SYNTAX);
  assert_non_null(strstr(error.message, "kind: missing"));
  assert_int_equal(parse("{\"kind\": \"rocks\"}", 17, &out, &error), SCREE_ERROR_SYNTAX);
  assert_non_null(strstr(error.message, "kind: expected \"shards\""));
}

static void the_kind_is_told_apart_from_others(void** state) {
  (void)state;
  scree_recipe_kind kind = SCREE_RECIPE_ROCKS;
  assert_int_equal(scree_recipe_get_kind("{\"kind\": \"shards\"}", 18, &kind, NULL), SCREE_OK);
  assert_int_equal(kind, SCREE_RECIPE_SHARDS);
  scree_recipe rocks;
  static scree_hoodoo_recipe hoodoo;
  assert_int_equal(scree_recipe_parse("{\"kind\": \"shards\"}", 18, &rocks, NULL), SCREE_ERROR_SYNTAX);
  assert_int_equal(scree_hoodoo_parse("{\"kind\": \"shards\"}", 18, &hoodoo, NULL), SCREE_ERROR_SYNTAX);
}

static uint32_t below(random_stream* stream, uint32_t limit) {
  return (uint32_t)(random_bits(stream) % limit);
}

static double random_number(random_stream* stream, const recipe_key* key, bool whole) {
  const uint32_t draw = below(stream, 8);
  if (draw == 0) return key->min;
  if (draw == 1) return key->max;
  const double number = key->min + (key->max - key->min) * random_unit(stream);
  return whole ? floor(number) : number;
}

/* Fills a struct by its table: every key, whatever it is, gets a value within its ends. */
static void random_members(random_stream* stream, const recipe_key* keys, void* base) {
  for (const recipe_key* key = keys; key->name != NULL; ++key) {
    char* field = (char*)base + key->offset;
    const uint32_t count = key->least + below(stream, key->size - key->least + 1);
    switch (key->kind) {
      case RECIPE_TEXT:
        snprintf(field, (size_t)key->max + 1, "a \"%u\" \\ %c", below(stream, 1000), (char)(1 + below(stream, 126)));
        break;
      case RECIPE_SEED: *(uint64_t*)(void*)field = random_bits(stream) >> 11; break;
      case RECIPE_COUNT: *(uint32_t*)(void*)field = (uint32_t)random_number(stream, key, true); break;
      case RECIPE_COUNTS:
        for (uint32_t i = 0; i < key->size; ++i) ((uint32_t*)(void*)field)[i] = (uint32_t)random_number(stream, key, true);
        break;
      case RECIPE_NUMBER: *(double*)(void*)field = random_number(stream, key, false); break;
      case RECIPE_NUMBERS:
        for (uint32_t i = 0; i < key->size; ++i) ((double*)(void*)field)[i] = random_number(stream, key, false);
        break;
      case RECIPE_BOOL: *(bool*)(void*)field = below(stream, 2) == 1; break;
      case RECIPE_CHOICE: *(int*)(void*)field = (int)below(stream, (uint32_t)key->max + 1); break;
      case RECIPE_OBJECT: random_members(stream, key->members, field); break;
      case RECIPE_LIST:
      case RECIPE_ROWS:
        for (uint32_t i = 0; i < count; ++i) random_members(stream, key->members, field + i * key->stride);
        break;
      case RECIPE_VALUES:
        for (uint32_t i = 0; i < count; ++i) ((double*)(void*)field)[i] = random_number(stream, key, false);
        break;
      case RECIPE_TIMES:
        for (uint32_t i = 0; i < count; ++i) ((uint32_t*)(void*)field)[i] = (uint32_t)random_number(stream, key, true);
        break;
      case RECIPE_PHASES:
        for (uint32_t i = 0; i < count; ++i) {
          scree_shard_phase* phase = (scree_shard_phase*)(void*)(field + i * key->stride);
          phase->share = below(stream, 2) == 0 ? -1 : random_unit(stream);
          phase->paths = below(stream, 1000000);
          phase->changes = below(stream, 1u << 10);
          random_members(stream, shard_table.rules, &phase->rules);
        }
        break;
      default: fail_msg("%s is of a kind that recipes of shards have not", key->name);
    }
    if (key->kind >= RECIPE_LIST) *(uint32_t*)(void*)((char*)base + key->count_at) = count;
  }
}

/* What rules between keys ask for, on top of ends. */
static void mend_rules(scree_shard_rules* rules) {
  for (uint32_t i = 0; i < rules->frost.rain_count; ++i) rules->frost.rains[i].direction[0] = 0.25;
  rules->frost.gravity[1] = rules->frost.resistance.up[1] = -0.5;
  for (uint32_t i = 0; i < rules->frost.resistance.layer_count; ++i) rules->layers[i][0] = i * 1.25 - 7;
}

static void random_recipe(random_stream* stream, scree_shard_recipe* out) {
  memset(out, 0, sizeof *out);
  random_members(stream, shard_table.keys, out);
  random_members(stream, shard_table.rules, &out->rules);
  mend_rules(&out->rules);
  for (uint32_t i = 0; i < out->phase_count; ++i) mend_rules(&out->phases[i].rules);
  for (uint32_t i = 0; i < out->state_count; ++i) {
    out->states[i].direction[1] = 0.5;
    for (int a = 0; a < 3; ++a) out->states[i].max[a] = fmin(1e5, (out->states[i].min[a] = -5 * random_unit(stream)) + 2);
  }
  for (int a = 0; a < 3; ++a) out->images.max[a] = (out->images.min[a] = random_unit(stream)) + 1;
  out->seeds.up[1] = 0.5;
  scree_shard_input* input = &out->input;
  input->high = fmin(1e5, (input->low = 5 * random_unit(stream)) + 1);
  input->crop[2] = input->crop[3] = 2 + below(stream, 100);
  input->height = 2 * (input->radius = 1 + random_unit(stream));
  input->resolution = 8 + below(stream, 505);
  out->max_paths = 1000000000;
  out->share_count = out->path_count = 0;
  const uint32_t times = 1 + below(stream, SCREE_SHARD_TIMES);
  for (uint32_t i = 0; i < times; ++i) {
    out->shares[i] = 1 - (i + random_unit(stream)) / (times + 1);
    out->paths[i] = i * 600 + below(stream, 600);
  }
  *(below(stream, 2) == 0 ? &out->path_count : &out->share_count) = times;
}

static void what_is_written_reads_back_the_same(void** state) {
  (void)state;
  random_stream stream = {2024};
  static scree_shard_recipe recipe, again;
  uint32_t shapes = 0, patterns = 0;
  for (int round = 0; round < 150; ++round) {
    scree_error error;
    random_recipe(&stream, &recipe);
    memset(&error, 0, sizeof error);
    if (shard_check_all(&recipe, &error) != SCREE_OK) fail_msg("%s", error.message);
    shapes |= 1u << recipe.input.shape;
    patterns |= 1u << recipe.seeds.kind;
    size_t size, size_again;
    char* text = write_recipe(&recipe, &size);
    if (parse(text, size, &again, &error) != SCREE_OK) fail_msg("%s: %.3000s", error.message, text);
    char* text_again = write_recipe(&again, &size_again);
    assert_string_equal(text, text_again);
    /* Not only as text: the numbers that weathering goes by. */
    assert_memory_equal(recipe.rules.frost.rains, again.rules.frost.rains, recipe.rules.frost.rain_count * sizeof(scree_rain));
    assert_true(recipe.random_seed == again.random_seed && recipe.rules.frost.water == again.rules.frost.water &&
                recipe.rules.frost.stability_interval == again.rules.frost.stability_interval &&
                recipe.rules.frost.total_absorption == again.rules.frost.total_absorption);
    assert_memory_equal(recipe.paths, again.paths, recipe.path_count * sizeof *recipe.paths);
    assert_memory_equal(recipe.shares, again.shares, recipe.share_count * sizeof *recipe.shares);
    assert_memory_equal(&recipe.rubble, &again.rubble, sizeof recipe.rubble);
    assert_true(recipe.phase_count == again.phase_count && recipe.state_count == again.state_count);
    for (uint32_t i = 0; i < recipe.phase_count; ++i) {
      assert_int_equal(recipe.phases[i].changes, again.phases[i].changes);
      assert_true(recipe.phases[i].share < 0 ? recipe.phases[i].paths == again.phases[i].paths
                                             : recipe.phases[i].share == again.phases[i].share);
    }
    if (recipe.seeds.kind == SCREE_SEEDS_POINTS)
      assert_memory_equal(recipe.seeds.points, again.seeds.points, recipe.seeds.point_count * sizeof *recipe.seeds.points);
    /* A buffer too small gets what fits, and the size that is needed. */
    char small[16];
    assert_int_equal(scree_shard_recipe_write(&recipe, small, sizeof small), size);
    assert_memory_equal(small, text, sizeof small - 1);
    free(text);
    free(text_again);
  }
  assert_int_equal(shapes, 511);
  assert_int_equal(patterns, 63);
}

static void changed_bytes_are_read_or_refused_in_one_line(void** state) {
  (void)state;
  random_stream stream = {77};
  static scree_shard_recipe recipe, out, again;
  uint32_t accepted = 0;
  for (int round = 0; round < 3000; ++round) {
    size_t size, size_again;
    scree_error error;
    if (round % 300 == 0) random_recipe(&stream, &recipe);
    recipe.seeds.point_count = recipe.seeds.point_count < 3 ? recipe.seeds.point_count : 3;
    if (recipe.phase_count > 2) recipe.phase_count = 2;
    char* text = write_recipe(&recipe, &size);
    for (uint32_t i = below(&stream, 4); i < 4; ++i) {
      const size_t at = (size_t)(random_bits(&stream) % size);
      text[at] = below(&stream, 2) == 0 ? text[(size_t)(random_bits(&stream) % size)] : (char)below(&stream, 256);
    }
    if (parse(text, size, &out, &error) == SCREE_OK) {
      char* written = write_recipe(&out, &size_again);
      assert_int_equal(shard_check_all(&out, &error), SCREE_OK);
      assert_int_equal(parse(written, size_again, &again, &error), SCREE_OK);
      free(written);
      ++accepted;
    } else
      assert_one_line(&error);
    free(text);
  }
  assert_in_range(accepted, 100, 2900);
}

static void numbers_that_did_not_come_from_json_are_checked_too(void** state) {
  (void)state;
  static scree_shard_recipe recipe;
  scree_error error;
#define REFUSED(change, said)                                               \
  do {                                                                      \
    scree_shard_recipe_default(&recipe);                                    \
    change;                                                                 \
    memset(&error, 0, sizeof error);                                        \
    assert_int_equal(shard_check_all(&recipe, &error), SCREE_ERROR_RANGE);  \
    if (strstr(error.message, said) == NULL) fail_msg("%s", error.message); \
  } while (0)
  REFUSED(recipe.input.radius = (double)NAN, "input.radius");
  REFUSED(recipe.input.shape = (scree_shard_shape)99, "input.shape");
  REFUSED(recipe.input.sides = 65, "input.sides");
  REFUSED(recipe.seeds.kind = (scree_seed_kind)-1, "seeds.pattern");
  REFUSED(recipe.seeds.stretch[2] = 0, "seeds.stretch[2]");
  REFUSED(recipe.rules.frost.rain_count = 5, "rains");
  REFUSED(recipe.rules.frost.rain_count = 0, "rains");
  REFUSED(recipe.rules.frost.rains[0].spread = (double)NAN, "rains[0].spread");
  REFUSED(recipe.rules.frost.resistance.kind = (scree_resistance_kind)5, "resistance.kind");
  REFUSED((recipe.rules.frost.resistance.kind = SCREE_RESISTANCE_LAYERS, recipe.rules.frost.resistance.layer_count = 99),
          "resistance.layers");
  REFUSED(recipe.rules.frost.stability_interval = 0, "stability.interval");
  REFUSED(recipe.state_count = 17, "states");
  REFUSED((recipe.state_count = 1, recipe.states[0].where = SCREE_SHARD_BEYOND), "states[0].direction");
  REFUSED((recipe.phase_count = 1, recipe.phases[0].share = -1, recipe.phases[0].paths = 4000000000u), "phases[0].paths");
  REFUSED(recipe.phase_count = 17, "phases");
  REFUSED((recipe.phase_count = 1, recipe.phases[0].share = 2), "phases[0].share");
  REFUSED((recipe.phase_count = 1, recipe.phases[0].changes = SCREE_SHARD_WATER), "phases[0].water");
  REFUSED(recipe.path_count = 17, "paths");
  REFUSED(recipe.path_count = 0, "paths");
  REFUSED((recipe.path_count = 0, recipe.share_count = 1, recipe.shares[0] = (double)NAN), "shares[0]");
  REFUSED(memset(recipe.name, 'x', sizeof recipe.name), "name");
  REFUSED(recipe.rubble.share = 2, "rubble.share");
}

static void one_key_can_be_set_and_a_wrong_one_changes_nothing(void** state) {
  (void)state;
  static scree_shard_recipe recipe, before;
  scree_error error;
  scree_shard_recipe_default(&recipe);
#define SET(assignment)                                                                                                 \
  do {                                                                                                                  \
    if (scree_shard_recipe_set(&recipe, assignment, &error) != SCREE_OK) fail_msg("%s: %s", assignment, error.message); \
  } while (0)
  SET("lod_levels=2");
  assert_int_equal(recipe.lod_levels, 2);
  SET("input.radius=9");
  assert_true(recipe.input.radius == 9 && recipe.input.shape == SCREE_SHARD_HILL);
  SET("input.shape=box");
  SET("input.size=[4,2,1]");
  assert_true(recipe.input.shape == SCREE_SHARD_BOX && recipe.input.size[0] == 4 && recipe.input.size[2] == 1);
  SET("seeds.pattern=slabs");
  SET("seeds.layers=[0.5,0.25]");
  scree_seed_pattern pattern;
  scree_shard_seeds_view(&recipe, &pattern);
  assert_true(pattern.kind == SCREE_SEEDS_SLABS && pattern.layer_count == 2 && pattern.layers[1] == 0.25);
  SET("resistance.kind=layers");
  SET("resistance.layers=[[0,0.9],[3,0.1]]");
  scree_frost_rules rules;
  scree_shard_rules_view(&(scree_shard_desc){.recipe = &recipe}, &recipe.rules, &rules);
  assert_true(rules.resistance.layer_count == 2 && rules.resistance.layers[2] == 3 && rules.resistance.layers[3] == 0.1);
  SET("absorption.total=false");
  assert_false(recipe.rules.frost.total_absorption);
  SET("shares=[0.9,0.5]");
  assert_true(recipe.path_count == 0 && recipe.share_count == 2);
  SET("states=[{\"where\":\"base\"}]");
  assert_true(recipe.state_count == 1 && recipe.states[0].state == SCREE_SHARD_CORE && recipe.states[0].depth == 0);
  SET("rains=[{\"direction\":[1,0,0]},{\"weight\":3}]");
  assert_true(recipe.rules.frost.rain_count == 2 && recipe.rules.frost.rains[1].weight == 3);
  static const char* const wrong[][2] = {
      {"lod_levels", "expected KEY=VALUE"},
      {"=5", "unknown key"},
      {"n=5", "n: unknown key"},
      {"input.depth=5", "input.depth: unknown key"},
      {"rules.water=5", "rules.water: unknown key"},
      {"water.x=5", "water.x: unknown key"},
      {"input.file=a.obj", "input.file: the shape box has no such key"},
      {"input.shape=mesh", "input.file: missing"},
      {"lod_levels=0", "lod_levels"},
      {"shares=[0.5,0.6]", "shares[1]"},
      {"states=[{\"where\":\"exterior\",\"angle\":1}]", "states[0].angle: the where exterior has no such key"},
  };
  memcpy(&before, &recipe, sizeof before);
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
    memset(&error, 0, sizeof error);
    if (scree_shard_recipe_set(&recipe, wrong[i][0], &error) == SCREE_OK) fail_msg("%s was accepted", wrong[i][0]);
    if (strstr(error.message, wrong[i][1]) == NULL) fail_msg("%s: %s", wrong[i][0], error.message);
    assert_one_line(&error);
    assert_memory_equal(&recipe, &before, sizeof before);
  }
}

static void seeds_and_weather_have_streams_of_their_own(void** state) {
  (void)state;
  static scree_shard_recipe recipe;
  scree_seed_pattern first, second, third;
  scree_shard_recipe_default(&recipe);
  scree_shard_seeds_view(&recipe, &first);
  recipe.seeds.random_seed = 1;
  scree_shard_seeds_view(&recipe, &second);
  recipe.seeds.random_seed = 0;
  recipe.random_seed = 2;
  scree_shard_seeds_view(&recipe, &third);
  assert_true(first.random_seed != second.random_seed && first.random_seed != third.random_seed);
}

static void shipped_recipes_are_accepted(void** state) {
  (void)state;
  DIR* directory = opendir(folder);
  assert_non_null(directory);
  uint32_t count = 0;
  for (const struct dirent* entry; (entry = readdir(directory)) != NULL;) {
    const size_t length = strlen(entry->d_name);
    if (length < 6 || strcmp(entry->d_name + length - 5, ".json") != 0) continue;
    char path[1024];
    static char text[65536];
    snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
    FILE* file = fopen(path, "rb");
    assert_non_null(file);
    const size_t size = fread(text, 1, sizeof text, file);
    fclose(file);
    scree_recipe_kind kind;
    assert_int_equal(scree_recipe_get_kind(text, size, &kind, NULL), SCREE_OK);
    if (kind != SCREE_RECIPE_SHARDS) continue;
    static scree_shard_recipe recipe;
    scree_error error;
    if (parse(text, size, &recipe, &error) != SCREE_OK) fail_msg("%s: %s", path, error.message);
    for (size_t c = 0; c < length - 5; ++c) assert_int_equal(entry->d_name[c], recipe.name[c] == ' ' ? '_' : recipe.name[c]);
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
      cmocka_unit_test(the_default_is_the_papers),
      cmocka_unit_test(faults_are_refused_by_name),
      cmocka_unit_test(the_kind_is_told_apart_from_others),
      cmocka_unit_test(what_is_written_reads_back_the_same),
      cmocka_unit_test(changed_bytes_are_read_or_refused_in_one_line),
      cmocka_unit_test(numbers_that_did_not_come_from_json_are_checked_too),
      cmocka_unit_test(one_key_can_be_set_and_a_wrong_one_changes_nothing),
      cmocka_unit_test(seeds_and_weather_have_streams_of_their_own),
      cmocka_unit_test(shipped_recipes_are_accepted),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
