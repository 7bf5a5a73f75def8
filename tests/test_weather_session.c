/* Weathering by hand, as a script: a recipe in, steps, edited graphs, back in time, the recipe and the surface out. The judge is a
 * replay of the recipe that was saved, and the baker. */
#define _POSIX_C_SOURCE 200809L

#include <cjson/cJSON.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* after the ones above */
#include <cmocka.h>
#include <scree/pack.h>

#include "file.h"
#include "weather_graph.h"
#include "weather_mesh.h"
#include "weather_session.h"

static char folder[64], recipe_file[96], saved_file[96], glb_file[96];
static const char* exported; /* where the .glb is left for other tests, NULL = nowhere */

static const char small[] =
    "{\"kind\": \"hoodoo\", \"name\": \"small\", \"voxel\": 0.125, \"size\": [40, 28, 40],\n"
    " \"start\": {\"shape\": \"column\", \"radius\": 11, \"lobes\": 1},\n"
    " \"durability\": [[0, 1.4, 0.5, 9], [0.4, 0.5], [0.7, 1.6], [1, 1]],\n"
    " \"bubbles\": [{\"radius\": 3}], \"steps_per_voxel\": 14, \"exposure\": 0.6,\n"
    " \"colluvium\": {\"share\": 0.35, \"durability\": 0.6, \"repose\": 0.7}, \"rockfall\": \"colluvium\",\n"
    " \"phases\": [{\"share\": 0.8, \"exposure\": 0.2}, {\"steps\": 400, \"rockfall\": \"drop\"}],\n"
    " \"variants\": 2, \"ages\": [0.97, 0.05], \"max_steps\": 500, \"lod_levels\": 1}\n";

static void put_file(const char* path, const char* text) {
  FILE* file = fopen(path, "w");
  assert_non_null(file);
  assert_true(fputs(text, file) >= 0);
  assert_int_equal(fclose(file), 0);
}

static weather_session* open_session(const char* path, uint32_t variant) {
  scree_error error = {""};
  weather_session* s;
  const weather_session_desc desc = {.path = path, .variant = variant, .snapshot_every = 3};
  if (weather_session_open(&desc, &s, &error) != SCREE_OK) fail_msg("%s", error.message);
  return s;
}

static void go(weather_session* s, uint32_t step) {
  scree_error error = {""};
  if (weather_session_go(s, step, &error) != SCREE_OK) fail_msg("%s", error.message);
  scree_weather_stats stats;
  weather_session_stats(s, &stats);
  assert_int_equal(stats.step, step);
}

static void set_rules(weather_session* s, const scree_hoodoo_rules* rules) {
  scree_error error = {""};
  if (weather_session_set_rules(s, rules, &error) != SCREE_OK) fail_msg("%s", error.message);
}

/* Drags the point in the middle. */
static void edit_durability(weather_session* s, double durability) {
  scree_hoodoo_rules rules = *weather_session_rules(s);
  weather_graph_move_point(&rules, 1, 0.45, durability);
  set_rules(s, &rules);
}

static void save(weather_session* s, const char* path) {
  scree_error error = {""};
  if (weather_session_save(s, path, &error) != SCREE_OK) fail_msg("%s", error.message);
  assert_false(weather_session_unsaved(s));
}

/* What a recipe is after some steps, by the letter of scree/hoodoo.h, step by step and without snapshots. */
static uint64_t replay(const char* path, uint32_t variant, uint32_t steps) {
  char* text;
  size_t size;
  scree_error error = {""};
  assert_int_equal(file_read(path, 1 << 20, &text, &size, &error), SCREE_OK);
  static scree_hoodoo_recipe recipe;
  if (scree_hoodoo_parse(text, size, &recipe, &error) != SCREE_OK) fail_msg("%s", error.message);
  free(text);
  const scree_hoodoo_desc desc = {.recipe = &recipe};
  scree_hoodoo_start_memory memory;
  scree_weather_desc weather = {.memory_limit = 0};
  assert_int_equal(scree_hoodoo_start_make(&desc, variant, &weather.start, &memory, &error), SCREE_OK);
  scree_hoodoo_rules rules = recipe.rules;
  scree_hoodoo_rules_view(&rules, &weather.rules);
  scree_weather* w;
  assert_int_equal(scree_weather_create(&weather, &w, &error), SCREE_OK);
  scree_hoodoo_start_free(&desc, &memory);
  for (uint32_t step = 0, next = 0; step < steps; ++step) {
    scree_weather_stats stats;
    scree_weather_get_stats(w, &stats);
    for (; next < recipe.phase_count; ++next) {
      const scree_hoodoo_phase* phase = &recipe.phases[next];
      if (phase->share < 0 ? step < phase->steps : (double)stats.rock > phase->share * (double)stats.start_rock) break;
      const scree_hoodoo_rules* from = &phase->rules;
      if (phase->changes & SCREE_HOODOO_DURABILITY) {
        memcpy(rules.durability, from->durability, sizeof rules.durability);
        rules.durability_count = from->durability_count;
      }
      if (phase->changes & SCREE_HOODOO_BUBBLES) {
        memcpy(rules.bubbles, from->bubbles, sizeof rules.bubbles);
        rules.bubble_count = from->bubble_count;
      }
      if (phase->changes & SCREE_HOODOO_SPHEROIDAL) rules.spheroidal = from->spheroidal;
      if (phase->changes & SCREE_HOODOO_CAVERNOUS) rules.cavernous = from->cavernous;
      if (phase->changes & SCREE_HOODOO_EXPOSURE) rules.exposure = from->exposure;
      if (phase->changes & SCREE_HOODOO_STEPS_PER_VOXEL) rules.steps_per_voxel = from->steps_per_voxel;
      if (phase->changes & SCREE_HOODOO_COLLUVIUM) {
        rules.colluvium_share = from->colluvium_share;
        rules.colluvium_durability = from->colluvium_durability;
        rules.repose = from->repose;
      }
      if (phase->changes & SCREE_HOODOO_ROCKFALL) rules.rockfall = from->rockfall;
      scree_weather_rules view;
      scree_hoodoo_rules_view(&rules, &view);
      assert_int_equal(scree_weather_set_rules(w, &view, &error), SCREE_OK);
    }
    assert_int_equal(scree_weather_step(w, 1), SCREE_OK);
  }
  const uint64_t digest = scree_weather_digest(w);
  scree_weather_destroy(w);
  return digest;
}

/* --- What is seen and what is saved --- */

static void saved_recipe_gives_what_was_seen(void** state) {
  (void)state;
  weather_session* s = open_session(recipe_file, 1);
  go(s, 7);
  edit_durability(s, 0.2);
  go(s, 12);
  scree_hoodoo_rules rules = *weather_session_rules(s);
  assert_int_not_equal(weather_graph_split(&rules, 0.5), WEATHER_GRAPH_NONE);
  rules.bubbles[1].bubbles[0] = (scree_bubble){SCREE_BUBBLE_GUMDROP, 4, 4};
  rules.colluvium_share = 0.1;
  rules.cavernous = (scree_curve){SCREE_CURVE_LINEAR, 0.5, 0, 1, 1};
  set_rules(s, &rules);
  go(s, 20);
  go(s, 10); /* back over one change, which stays, and a change before it */
  rules = *weather_session_rules(s);
  rules.exposure = 1;
  set_rules(s, &rules);
  go(s, 22);
  assert_true(weather_session_unsaved(s));
  save(s, saved_file);
  const uint64_t seen = weather_session_digest(s);
  weather_session_close(s);
  assert_int_equal(replay(saved_file, 1, 22), seen);
  assert_int_not_equal(replay(recipe_file, 1, 22), seen);
  s = open_session(saved_file, 1);
  go(s, 22);
  assert_int_equal(weather_session_digest(s), seen);
  weather_session_close(s);
}

static void kept_ages_are_the_steps_that_are_baked(void** state) {
  (void)state;
  scree_error error = {""};
  weather_session* s = open_session(recipe_file, 0);
  go(s, 29);
  edit_durability(s, 0.3);
  static const uint32_t steps[] = {44, 31, 63}; /* in no order */
  uint64_t rock[3];
  for (int i = 0; i < 3; ++i) {
    go(s, steps[i]);
    if (weather_session_keep_age(s, &error) != SCREE_OK) fail_msg("%s", error.message);
    scree_weather_stats stats;
    weather_session_stats(s, &stats);
    rock[i] = stats.rock;
    assert_int_equal(weather_session_keep_age(s, &error), SCREE_ERROR_RANGE); /* it is there already */
    assert_non_null(strstr(error.message, "ages"));
  }
  /* The recipe's own last age is far off; the first stays. */
  const uint32_t count = weather_session_ages(s);
  assert_int_equal(count, 5);
  assert_int_equal(weather_session_drop_age(s, count - 1, &error), SCREE_OK);
  save(s, saved_file);
  scree_hoodoo_recipe* recipe = malloc(sizeof *recipe);
  assert_non_null(recipe);
  *recipe = *weather_session_recipe(s);
  weather_session_close(s);
  recipe->variants = 1;
  const scree_hoodoo_desc desc = {.recipe = recipe};
  uint8_t* bytes;
  size_t size;
  if (scree_hoodoo_bake(&desc, &bytes, &size, NULL, &error) != SCREE_OK) fail_msg("%s", error.message);
  scree_pack* pack;
  assert_int_equal(scree_pack_open_memory(bytes, size, NULL, &pack), SCREE_OK);
  static const int by_age[3] = {1, 0, 2};
  for (uint32_t age = 1; age < 4; ++age) {
    scree_model model;
    assert_int_equal(scree_pack_get_model(pack, scree_pack_model(pack, 0, age), &model), SCREE_OK);
    assert_int_equal(model.steps, steps[by_age[age - 1]]);
    assert_true(fabs((double)model.share - recipe->ages[age]) < 0.01);
  }
  assert_true(rock[2] < rock[0] && rock[0] < rock[1]);
  scree_pack_close(pack);
  scree_hoodoo_free(&desc, bytes, size);
  free(recipe);
}

/* --- Time --- */

static void time_goes_back_and_forth_over_the_same_states(void** state) {
  (void)state;
  enum { LAST = 30 };
  uint64_t digests[LAST + 1];
  weather_session* s = open_session(recipe_file, 0);
  for (uint32_t step = 0; step <= LAST; ++step) {
    go(s, step);
    digests[step] = weather_session_digest(s);
  }
  static const uint32_t ways[] = {0, 29, 30, 17, 16, 1, 28, 3, 0, 30};
  for (size_t i = 0; i < sizeof ways / sizeof *ways; ++i) {
    go(s, ways[i]);
    assert_int_equal(weather_session_digest(s), digests[ways[i]]);
    assert_int_equal(weather_session_last(s), LAST);
  }
  /* The phase of the recipe comes and goes with time. */
  assert_int_equal(weather_session_phases_begun(s), 1);
  assert_true(weather_session_rules(s)->exposure == 0.2);
  go(s, 0);
  assert_int_equal(weather_session_phases_begun(s), 0);
  assert_true(weather_session_rules(s)->exposure == 0.6);
  /* Many more steps than there is room for snapshots. */
  weather_session_close(s);
  scree_error error = {""};
  const weather_session_desc often = {.path = recipe_file, .snapshot_every = 1};
  assert_int_equal(weather_session_open(&often, &s, &error), SCREE_OK);
  go(s, WEATHER_SNAPSHOTS + 20);
  assert_true(weather_session_snapshots(s) <= WEATHER_SNAPSHOTS);
  assert_true(weather_session_snapshots(s) >= WEATHER_SNAPSHOTS / 2);
  for (size_t i = 0; i < sizeof ways / sizeof *ways; ++i) {
    go(s, ways[i]);
    assert_int_equal(weather_session_digest(s), digests[ways[i]]);
  }
  weather_session_close(s);
}

static void a_change_keeps_the_past_and_ends_the_future(void** state) {
  (void)state;
  weather_session* s = open_session(recipe_file, 0);
  go(s, 12);
  const uint64_t twelve = weather_session_digest(s);
  go(s, 5);
  const uint64_t five = weather_session_digest(s);
  edit_durability(s, 0.25);
  assert_int_equal(weather_session_digest(s), five);
  assert_int_equal(weather_session_last(s), 5);
  go(s, 12);
  assert_int_not_equal(weather_session_digest(s), twelve);
  go(s, 5);
  assert_int_equal(weather_session_digest(s), five);
  /* Without the change everything is as before. */
  scree_error error = {""};
  assert_int_equal(weather_session_recipe(s)->phase_count, 3);
  assert_int_equal(weather_session_drop_phase(s, weather_session_phases_begun(s) - 1, &error), SCREE_OK);
  go(s, 12);
  assert_int_equal(weather_session_digest(s), twelve);
  weather_session_close(s);
}

static void dropping_a_phase_keeps_the_step(void** state) {
  (void)state;
  scree_error error = {""};
  weather_session* s = open_session(recipe_file, 0);
  go(s, 14);
  const uint64_t plain = weather_session_digest(s);
  go(s, 4);
  edit_durability(s, 0.25);
  const uint32_t phase = weather_session_phases_begun(s) - 1;
  go(s, 14);
  assert_int_equal(weather_session_drop_phase(s, phase, &error), SCREE_OK);
  scree_weather_stats stats;
  weather_session_stats(s, &stats);
  assert_int_equal(stats.step, 14);
  assert_int_equal(weather_session_digest(s), plain);
  weather_session_close(s);
}

static void changes_of_one_step_are_one_phase(void** state) {
  (void)state;
  weather_session* s = open_session(recipe_file, 0);
  edit_durability(s, 0.4);
  assert_int_equal(weather_session_recipe(s)->phase_count, 2); /* at the start the recipe's own rules change */
  assert_true(weather_session_recipe(s)->rules.durability[1].durability == 0.4);
  go(s, 6);
  const scree_hoodoo_rules before = *weather_session_rules(s);
  edit_durability(s, 0.9);
  edit_durability(s, 2.5);
  const scree_hoodoo_recipe* recipe = weather_session_recipe(s);
  const scree_hoodoo_phase* phase = &recipe->phases[weather_session_phases_begun(s) - 1];
  assert_int_equal(recipe->phase_count, 3);
  assert_true(phase->share < 0 && phase->steps == 6);
  assert_int_equal(phase->changes, SCREE_HOODOO_DURABILITY);
  assert_true(phase->rules.durability[1].durability == 2.5);
  set_rules(s, &before);
  assert_int_equal(recipe->phase_count, 2);
  weather_session_close(s);
}

static void rules_of_now_can_hold_from_the_start(void** state) {
  (void)state;
  scree_error error = {""};
  weather_session* s = open_session(recipe_file, 0);
  go(s, 8);
  edit_durability(s, 0.25);
  const scree_hoodoo_rules rules = *weather_session_rules(s);
  assert_int_equal(weather_session_flatten(s, &error), SCREE_OK);
  scree_weather_stats stats;
  weather_session_stats(s, &stats);
  assert_int_equal(stats.step, 0);
  assert_int_equal(weather_session_recipe(s)->phase_count, 0);
  assert_true(weather_session_recipe(s)->rules.durability[1].durability == rules.durability[1].durability);
  go(s, 10);
  save(s, saved_file);
  assert_int_equal(replay(saved_file, 0, 10), weather_session_digest(s));
  weather_session_close(s);
}

static void variants_differ_and_keep_their_recipe(void** state) {
  (void)state;
  scree_error error = {""};
  weather_session* s = open_session(recipe_file, 0);
  go(s, 5);
  const uint64_t first = weather_session_digest(s);
  assert_int_equal(weather_session_set_variant(s, 1, &error), SCREE_OK);
  assert_int_equal(weather_session_variant(s), 1);
  go(s, 5);
  assert_int_not_equal(weather_session_digest(s), first);
  assert_int_equal(weather_session_digest(s), replay(recipe_file, 1, 5));
  assert_int_equal(weather_session_set_variant(s, 2, &error), SCREE_ERROR_RANGE);
  assert_non_null(strstr(error.message, "variants"));
  assert_int_equal(weather_session_variant(s), 1);
  weather_session_close(s);
}

static void nothing_is_left_at_the_end(void** state) {
  (void)state;
  scree_error error = {""};
  weather_session* s = open_session(recipe_file, 0);
  assert_int_equal(weather_session_go(s, 100000, &error), SCREE_OK);
  scree_weather_stats stats;
  weather_session_stats(s, &stats);
  assert_int_equal(stats.rock, 0);
  const uint64_t end = stats.step;
  assert_int_equal(weather_session_step(s, &error), SCREE_OK);
  weather_session_stats(s, &stats);
  assert_int_equal(stats.step, end);
  assert_int_equal(weather_session_keep_age(s, &error), SCREE_ERROR_RANGE);
  go(s, 3);
  assert_int_equal(weather_session_digest(s), replay(recipe_file, 0, 3));
  weather_session_close(s);
}

/* --- Faults --- */

static void refuses(const char* text, const char* words) {
  char path[96];
  snprintf(path, sizeof path, "%s/wrong.json", folder);
  put_file(path, text);
  scree_error error = {""};
  weather_session* s = NULL;
  const weather_session_desc desc = {.path = path};
  assert_int_not_equal(weather_session_open(&desc, &s, &error), SCREE_OK);
  assert_null(s);
  if (strstr(error.message, "wrong.json") == NULL || strstr(error.message, words) == NULL)
    fail_msg("%s: expected wrong.json and %s", error.message, words);
  remove(path);
}

static void faults_name_the_file_and_the_key(void** state) {
  (void)state;
  refuses("{\"kind\": \"hoodoo\", \"exposure\": 7}", "exposure");
  refuses("{\"kind\": \"hoodoo\", \"colluvium\": {\"shore\": 1}}", "colluvium.shore");
  refuses("{\"kind\": \"hoodoo\",", "");
  refuses("{\"kind\": \"hoodoo\", \"start\": {\"shape\": \"joint_map\", \"file\": \"nowhere.png\"}}", "nowhere.png");
  refuses("{\"kind\": \"hoodoo\", \"start\": {\"shape\": \"mesh\", \"file\": \"nowhere.obj\"}}", "nowhere.obj");
  refuses("{\"kind\": \"hoodoo\", \"size\": [2, 2, 2], \"start\": {\"shape\": \"box\"}}", "radius");
  scree_error error = {""};
  weather_session* s;
  const weather_session_desc missing = {.path = "/nowhere/x.json"};
  assert_int_equal(weather_session_open(&missing, &s, &error), SCREE_ERROR_IO);
  assert_non_null(strstr(error.message, "/nowhere/x.json"));
  const weather_session_desc third = {.path = recipe_file, .variant = 2};
  assert_int_equal(weather_session_open(&third, &s, &error), SCREE_ERROR_RANGE);
  assert_non_null(strstr(error.message, "variants"));
}

static void wrong_rules_change_nothing(void** state) {
  (void)state;
  scree_error error = {""};
  weather_session* s = open_session(recipe_file, 0);
  go(s, 4);
  scree_hoodoo_rules rules = *weather_session_rules(s);
  rules.durability[1].durability = NAN;
  assert_int_equal(weather_session_set_rules(s, &rules, &error), SCREE_ERROR_RANGE);
  assert_non_null(strstr(error.message, "durability"));
  assert_non_null(strstr(error.message, recipe_file));
  assert_int_equal(weather_session_recipe(s)->phase_count, 2);
  assert_false(weather_session_unsaved(s));
  go(s, 9);
  assert_int_equal(weather_session_digest(s), replay(recipe_file, 0, 9));
  weather_session_close(s);
}

static void full_phases_refuse_one_more(void** state) {
  (void)state;
  scree_error error = {""};
  weather_session* s = open_session(recipe_file, 0);
  for (uint32_t i = 2; i < SCREE_HOODOO_PHASES; ++i) {
    go(s, i);
    edit_durability(s, 0.3 + 0.01 * i);
  }
  assert_int_equal(weather_session_recipe(s)->phase_count, SCREE_HOODOO_PHASES);
  go(s, SCREE_HOODOO_PHASES + 3);
  const scree_hoodoo_rules before = *weather_session_rules(s);
  scree_hoodoo_rules rules = before;
  rules.exposure = 1.5;
  assert_int_equal(weather_session_set_rules(s, &rules, &error), SCREE_ERROR_RANGE);
  assert_non_null(strstr(error.message, "phases"));
  assert_true(weather_session_rules(s)->exposure == before.exposure);
  save(s, saved_file);
  go(s, SCREE_HOODOO_PHASES + 6);
  assert_int_equal(replay(saved_file, 0, SCREE_HOODOO_PHASES + 6), weather_session_digest(s));
  weather_session_close(s);
}

static void what_cannot_be_written_leaves_nothing(void** state) {
  (void)state;
  scree_error error = {""};
  char path[128];
  weather_session* s = open_session(recipe_file, 0);
  snprintf(path, sizeof path, "%s/no/such/x.json", folder);
  edit_durability(s, 0.3);
  assert_int_equal(weather_session_save(s, path, &error), SCREE_ERROR_IO);
  assert_non_null(strstr(error.message, "no/such/x.json"));
  assert_true(weather_session_unsaved(s));
  assert_int_equal(weather_session_export(s, path, &error), SCREE_ERROR_IO);
  assert_non_null(strstr(error.message, "no/such/x.json"));
  weather_session_close(s);
}

static void recipes_are_told_from_scenes(void** state) {
  (void)state;
  char path[96];
  snprintf(path, sizeof path, "%s/other.json", folder);
  assert_true(weather_recipe_is(recipe_file));
  put_file(path, "{\"fields\": []}");
  assert_false(weather_recipe_is(path));
  put_file(path, "{\"kind\": \"hoo");
  assert_false(weather_recipe_is(path));
  remove(path);
  assert_false(weather_recipe_is(path));
}

/* --- Graphs --- */

static void a_new_point_changes_nothing_until_it_is_moved(void** state) {
  (void)state;
  scree_hoodoo_recipe* recipe = malloc(sizeof *recipe);
  assert_non_null(recipe);
  scree_hoodoo_default(recipe);
  scree_hoodoo_rules *rules = &recipe->rules, before = *rules;
  static const double places[] = {0, 0.05, 0.33, 0.5, 0.999, 1};
  for (size_t i = 0; i < sizeof places / sizeof *places; ++i) {
    const uint32_t point = weather_graph_add_point(rules, places[i]);
    assert_int_not_equal(point, WEATHER_GRAPH_NONE);
    assert_true(rules->durability[point].altitude == places[i]);
    for (double a = 0; a <= 1; a += 1.0 / 64)
      assert_true(fabs(weather_graph_durability(rules, a) - weather_graph_durability(&before, a)) < 1e-12);
  }
  while (weather_graph_add_point(rules, 0.7) != WEATHER_GRAPH_NONE) continue;
  assert_int_equal(rules->durability_count, SCREE_HOODOO_POINTS);
  for (uint32_t i = 1; i < rules->durability_count; ++i)
    assert_true(rules->durability[i - 1].altitude <= rules->durability[i].altitude);
  while (weather_graph_remove_point(rules, rules->durability_count / 2)) continue;
  assert_int_equal(rules->durability_count, 1);
  free(recipe);
}

static void points_and_borders_stay_between_their_neighbours(void** state) {
  (void)state;
  scree_hoodoo_recipe* recipe = malloc(sizeof *recipe);
  assert_non_null(recipe);
  scree_hoodoo_default(recipe);
  scree_hoodoo_rules* rules = &recipe->rules;
  const double low = rules->durability[3].altitude, high = rules->durability[5].altitude;
  weather_graph_move_point(rules, 4, -3, -1);
  assert_true(rules->durability[4].altitude == low && rules->durability[4].durability == WEATHER_DURABILITY_LEAST);
  weather_graph_move_point(rules, 4, 3, 1e9);
  assert_true(rules->durability[4].altitude == high && rules->durability[4].durability == WEATHER_DURABILITY_MOST);
  weather_graph_move_point(rules, 4, NAN, NAN);
  assert_true(rules->durability[4].altitude == low && rules->durability[4].durability == WEATHER_DURABILITY_LEAST);
  assert_int_equal(weather_graph_split(rules, 0.3), 1);
  assert_int_equal(weather_graph_split(rules, 0.6), 2);
  weather_graph_move_border(rules, 1, 0.9);
  assert_true(rules->bubbles[1].altitude < rules->bubbles[2].altitude);
  weather_graph_move_border(rules, 2, 7);
  assert_true(rules->bubbles[2].altitude < 1);
  assert_true(weather_graph_remove_segment(rules, 0));
  assert_true(rules->bubbles[0].altitude == 0);
  assert_true(weather_graph_remove_segment(rules, 1));
  assert_false(weather_graph_remove_segment(rules, 0));
  while (weather_graph_split(rules, 0.5) != WEATHER_GRAPH_NONE) continue;
  char* text = malloc(65536);
  assert_non_null(text);
  scree_error error = {""};
  const size_t size = scree_hoodoo_write(recipe, text, 65536);
  if (scree_hoodoo_parse(text, size, recipe, &error) != SCREE_OK) fail_msg("%s", error.message);
  free(text);
  free(recipe);
}

static void colours_tell_durable_from_soft(void** state) {
  (void)state;
  const scree_durability_point points[] = {{0, 0.3, 0, 1, 1}, {1, 40, 0, 1, 1}};
  const weather_range range = weather_range_of(points, 2);
  assert_true(range.low == 0.1 && range.high == 100);
  uint8_t soft[3], hard[3], none[3];
  weather_durability_colour(&range, 0.2, soft);
  weather_durability_colour(&range, 60, hard);
  weather_durability_colour(&range, 0, none); /* not drawn, and no fault */
  assert_true(soft[2] > soft[0] && hard[0] > hard[2] && none[2] > none[0]);
}

/* --- The surface --- */

static uint32_t le32(const uint8_t* at) {
  return at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static double number(const cJSON* object, const char* key) {
  const cJSON* item = cJSON_GetObjectItemCaseSensitive(object, key);
  if (!cJSON_IsNumber(item)) fail_msg("no number %s", key);
  return item->valuedouble;
}

static const cJSON* item_of(const cJSON* json, const char* array, double row) {
  const cJSON* item = cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(json, array), (int)row);
  if (item == NULL) fail_msg("no %s[%g]", array, row);
  return item;
}

static void surface_goes_out_as_rock_and_colluvium(void** state) {
  (void)state;
  scree_error error = {""};
  weather_session* s = open_session(recipe_file, 0);
  go(s, 20);
  if (weather_session_export(s, glb_file, &error) != SCREE_OK) fail_msg("%s", error.message);
  scree_surface surface;
  assert_int_equal(weather_session_surface(s, &surface, &error), SCREE_OK);
  assert_true(surface.rock_triangles > 0 && surface.colluvium_triangles > 0);
  char* bytes;
  size_t size;
  assert_int_equal(file_read(glb_file, 1 << 26, &bytes, &size, &error), SCREE_OK);
  const uint8_t* data = (const uint8_t*)bytes;
  assert_true(size > 20 && memcmp(data, "glTF", 4) == 0 && le32(data + 8) == size);
  cJSON* json = cJSON_ParseWithLength(bytes + 20, le32(data + 12));
  assert_non_null(json);
  const uint8_t* bin = data + 20 + le32(data + 12) + 8;
  const cJSON* primitives = cJSON_GetObjectItemCaseSensitive(item_of(json, "meshes", 0), "primitives");
  assert_int_equal(cJSON_GetArraySize(primitives), 2);
  static const char* const names[2] = {"rock", "colluvium"};
  const uint32_t triangles[2] = {surface.rock_triangles, surface.colluvium_triangles};
  double positions[2];
  for (int i = 0; i < 2; ++i) {
    const cJSON* primitive = cJSON_GetArrayItem(primitives, i);
    const cJSON* material = item_of(json, "materials", number(primitive, "material"));
    assert_string_equal(cJSON_GetObjectItemCaseSensitive(material, "name")->valuestring, names[i]);
    const cJSON* indices = item_of(json, "accessors", number(primitive, "indices"));
    assert_int_equal(number(indices, "count"), 3 * triangles[i]);
    positions[i] = number(cJSON_GetObjectItemCaseSensitive(primitive, "attributes"), "POSITION");
    /* The indices themselves. */
    const cJSON* view = item_of(json, "bufferViews", number(indices, "bufferView"));
    const cJSON* offset = cJSON_GetObjectItemCaseSensitive(indices, "byteOffset");
    const uint8_t* at = bin + (size_t)(number(view, "byteOffset") + (offset != NULL ? offset->valuedouble : 0));
    for (uint32_t k = 0; k < 3 * triangles[i]; ++k)
      assert_int_equal(le32(at + 4 * (size_t)k), surface.indices[k + (i == 1 ? 3 * surface.rock_triangles : 0)]);
  }
  assert_true(positions[0] == positions[1]); /* one set of vertices: no gap */
  const cJSON* place = item_of(json, "accessors", positions[0]);
  assert_int_equal(number(place, "count"), surface.vertex_count);
  const cJSON *min = cJSON_GetObjectItemCaseSensitive(place, "min"), *max = cJSON_GetObjectItemCaseSensitive(place, "max");
  /* In metres, on the ground, round the origin: a column of 11 voxels of 1/8 m, 28 of them high. */
  assert_true(fabs(cJSON_GetArrayItem(min, 1)->valuedouble) <= 0.125 && cJSON_GetArrayItem(max, 1)->valuedouble <= 28 * 0.125);
  for (int a = 0; a < 3; a += 2) {
    assert_true(cJSON_GetArrayItem(min, a)->valuedouble < -0.5 && cJSON_GetArrayItem(min, a)->valuedouble > -20 * 0.125);
    assert_true(cJSON_GetArrayItem(max, a)->valuedouble > 0.5 && cJSON_GetArrayItem(max, a)->valuedouble < 20 * 0.125);
  }
  cJSON_Delete(json);
  if (exported != NULL) {
    FILE* copy = fopen(exported, "wb");
    assert_non_null(copy);
    assert_int_equal(fwrite(bytes, 1, size, copy), size);
    assert_int_equal(fclose(copy), 0);
  }
  free(bytes);
  weather_session_close(s);
}

static void painted_vertices_tell_what_they_are(void** state) {
  (void)state;
  scree_error error = {""};
  weather_session* s = open_session(recipe_file, 0);
  go(s, 20);
  scree_surface surface;
  assert_int_equal(weather_session_surface(s, &surface, &error), SCREE_OK);
  render_vertex* vertices = malloc(surface.vertex_count * sizeof *vertices);
  assert_non_null(vertices);
  const scree_hoodoo_recipe* recipe = weather_session_recipe(s);
  const scree_hoodoo_rules* rules = weather_session_rules(s);
  const weather_range range = weather_range_of(rules->durability, rules->durability_count);
  weather_mesh_fill(&surface, recipe->size, recipe->voxel, WEATHER_DURABILITY, &range, vertices);
  uint32_t purple = 0, colluvium = 0;
  for (uint32_t i = 0; i < surface.vertex_count; ++i) {
    purple += memcmp(vertices[i].surface, weather_colluvium_colour, 3) == 0;
    colluvium += surface.vertices[i].material == 1;
  }
  assert_true(colluvium > 0);
  assert_int_equal(purple, colluvium);
  weather_mesh_fill(&surface, recipe->size, recipe->voxel, WEATHER_NATURAL, &range, vertices);
  for (uint32_t i = 0; i < surface.vertex_count; ++i) {
    assert_int_equal(vertices[i].surface[0] & 15, surface.vertices[i].material);
    assert_int_equal(vertices[i].surface[0] >> 4, surface.vertices[i].layer);
    const double at = (double)(surface.vertices[i].position[1]) * 0.125;
    assert_true(fabs((double)vertices[i].position[1] - at) < 1e-5);
  }
  free(vertices);
  weather_session_close(s);
}

static int set_up(void** state) {
  (void)state;
  strcpy(folder, "/tmp/weather-session-XXXXXX");
  if (mkdtemp(folder) == NULL) return -1;
  snprintf(recipe_file, sizeof recipe_file, "%s/small.json", folder);
  snprintf(saved_file, sizeof saved_file, "%s/saved.json", folder);
  snprintf(glb_file, sizeof glb_file, "%s/small.glb", folder);
  put_file(recipe_file, small);
  return 0;
}

static int tear_down(void** state) {
  (void)state;
  remove(recipe_file);
  remove(saved_file);
  remove(glb_file);
  return rmdir(folder); /* nothing else was left there */
}

int main(int count, char** arguments) {
  exported = count > 1 ? arguments[1] : NULL;
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(saved_recipe_gives_what_was_seen),
      cmocka_unit_test(kept_ages_are_the_steps_that_are_baked),
      cmocka_unit_test(time_goes_back_and_forth_over_the_same_states),
      cmocka_unit_test(a_change_keeps_the_past_and_ends_the_future),
      cmocka_unit_test(dropping_a_phase_keeps_the_step),
      cmocka_unit_test(changes_of_one_step_are_one_phase),
      cmocka_unit_test(rules_of_now_can_hold_from_the_start),
      cmocka_unit_test(variants_differ_and_keep_their_recipe),
      cmocka_unit_test(nothing_is_left_at_the_end),
      cmocka_unit_test(faults_name_the_file_and_the_key),
      cmocka_unit_test(wrong_rules_change_nothing),
      cmocka_unit_test(full_phases_refuse_one_more),
      cmocka_unit_test(what_cannot_be_written_leaves_nothing),
      cmocka_unit_test(recipes_are_told_from_scenes),
      cmocka_unit_test(a_new_point_changes_nothing_until_it_is_moved),
      cmocka_unit_test(points_and_borders_stay_between_their_neighbours),
      cmocka_unit_test(colours_tell_durable_from_soft),
      cmocka_unit_test(surface_goes_out_as_rock_and_colluvium),
      cmocka_unit_test(painted_vertices_tell_what_they_are),
  };
  return cmocka_run_group_tests(tests, set_up, tear_down);
}
