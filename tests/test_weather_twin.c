/* The fast simulation and the naive one have the same voxels and lives, step by step, whatever the rules. */
#include <scree/threads.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* after the four above */
#include <cmocka.h>

#include "random_weather.h"
#include "weather_kernels.h"
#include "weather_twin.h"

/* Both simulations of one start. */
typedef struct pair {
  scree_weather* weather;
  weather_twin* twin;
  uint8_t* voxels;
  size_t count;
} pair;

static bool pair_make(pair* p, const scree_weather_start* start, const scree_weather_rules* rules, scree_jobs jobs) {
  const scree_weather_desc desc = {.start = *start, .rules = *rules, .jobs = jobs};
  scree_error error;
  const scree_result result = scree_weather_create(&desc, &p->weather, &error);
  if (result == SCREE_ERROR_INVALID_ARGUMENT) return false; /* no rock */
  if (result != SCREE_OK) print_message("%s\n", error.message);
  assert_int_equal(result, SCREE_OK);
  /* Half of all runs go through the plain kernels, whatever the machine has. */
  if ((start->seed ^ rules->durability_count) % 2 == 0) p->weather->kernels = &weather_kernels_plain;
  p->count = (size_t)start->size[0] * start->size[1] * start->size[2];
  p->voxels = malloc(p->count);
  assert_non_null(p->voxels);
  scree_weather_voxels(p->weather, p->voxels);
  p->twin = weather_twin_create(start->size, p->voxels, NULL, start->seed);
  assert_non_null(p->twin);
  weather_twin_rules(p->twin, rules);
  return true;
}

static void pair_free(pair* p) {
  scree_weather_destroy(p->weather);
  weather_twin_destroy(p->twin);
  free(p->voxels);
}

static void assert_same(const pair* p) {
  const scree_weather* w = p->weather;
  scree_weather_voxels(w, p->voxels);
  const uint8_t* voxels = weather_twin_voxels(p->twin);
  const int32_t* lives = weather_twin_lives(p->twin);
  size_t at = 0;
  for (uint32_t z = 0; z < w->size[2]; ++z)
    for (uint32_t y = 0; y < w->size[1]; ++y)
      for (uint32_t x = 0; x < w->size[0]; ++x, ++at)
        if (p->voxels[at] != voxels[at] || w->life[weather_at(w, x, y, z)] != lives[at])
          fail_msg("voxel (%u, %u, %u) after step %u: %u with %d left, should be %u with %d", x, y, z, (unsigned)w->step,
                   p->voxels[at], (int)w->life[weather_at(w, x, y, z)], voxels[at], (int)lives[at]);
  scree_weather_stats stats;
  scree_weather_get_stats(w, &stats);
  uint64_t rock = 0, colluvium = 0;
  for (at = 0; at < p->count; ++at) {
    rock += voxels[at] == SCREE_VOXEL_ROCK;
    colluvium += voxels[at] == SCREE_VOXEL_COLLUVIUM;
  }
  assert_int_equal(stats.rock, rock);
  assert_int_equal(stats.colluvium, colluvium);
  assert_int_equal(stats.removed, weather_twin_removed(p->twin));
  assert_int_equal(stats.fallen, weather_twin_fallen(p->twin));
}

static void pair_step(pair* p) {
  scree_weather_stats stats;
  scree_weather_get_stats(p->weather, &stats);
  if (stats.rock + stats.colluvium == 0) return; /* no more steps */
  assert_int_equal(scree_weather_step(p->weather, 1), SCREE_OK);
  weather_twin_step(p->twin);
  assert_same(p);
}

/* --- tests ------------------------------------------------------------------------------------------------------------------- */

static void every_bubble_radius_and_curve_gives_the_twins_voxels(void** state) {
  (void)state;
  const scree_weather_start start = {
      .kind = SCREE_START_BOX, .size = {17, 15, 13}, .box_min = {2, 0, 1}, .box_max = {16, 13, 12}, .seed = 5};
  scree_weather_rules rules;
  scree_weather_rules_default(&rules);
  rules.steps_per_voxel = 3;
  for (uint32_t kind = 0; kind < 4; ++kind)
    for (uint32_t radius = 1; radius <= 8; ++radius)
      for (uint32_t curve = SCREE_CURVE_LINEAR; curve <= SCREE_CURVE_SATURATING; ++curve) {
        const scree_bubble_segment segment = {.bubbles = {{(scree_bubble_kind)kind, radius, 1 + (radius * 3) % 8}},
                                              .bubble_count = 1};
        rules.bubbles = &segment;
        rules.spheroidal = (scree_curve){(scree_curve_kind)curve, 1, -0.2, 0.8, 1 + radius % 4};
        rules.cavernous = (scree_curve){(scree_curve_kind)((curve + radius) % 5), 0.4, 0, 0.1, 1};
        rules.exposure = radius % 3 * 0.35;
        pair p;
        assert_true(pair_make(&p, &start, &rules, (scree_jobs){0}));
        for (int step = 0; step < 5; ++step) pair_step(&p);
        pair_free(&p);
      }
}

static void random_grids_and_rules_give_the_twins_voxels(void** state) {
  (void)state;
  random_stream random = {11};
  uint32_t cases = 0, stepped = 0;
  while (cases < 150) {
    random_start start;
    random_rules rules;
    const bool wide = cases % 10 == 0; /* rows of several words */
    random_start_make(&random, wide ? 210 : 22, &start);
    if (wide) {
      start.start.size[1] = start.start.size[2] = 9;
      memset(start.start.box_max, 0, sizeof start.start.box_max);
      memset(start.start.box_min, 0, sizeof start.start.box_min);
    }
    uint32_t side = start.start.size[0];
    for (int a = 1; a < 3; ++a) side = start.start.size[a] > side ? start.start.size[a] : side;
    random_rules_make(&random, side < 8 ? side : 8, &rules);
    pair p;
    if (pair_make(&p, &start.start, &rules.rules, (scree_jobs){0})) {
      ++cases;
      for (int step = 0; step < 8; ++step, ++stepped) pair_step(&p);
      pair_free(&p);
    }
    random_start_free(&start);
  }
  assert_int_equal(stepped, 150 * 8);
}

static void rules_change_between_steps_as_in_the_twin(void** state) {
  (void)state;
  random_stream random = {12};
  uint32_t cases = 0;
  while (cases < 25) {
    random_start start;
    random_rules rules;
    random_start_make(&random, 18, &start);
    uint32_t side = start.start.size[0];
    for (int a = 1; a < 3; ++a) side = start.start.size[a] > side ? start.start.size[a] : side;
    const double most = side < 8 ? side : 8;
    random_rules_make(&random, most, &rules);
    pair p;
    if (pair_make(&p, &start.start, &rules.rules, (scree_jobs){0})) {
      ++cases;
      for (int change = 0; change < 5; ++change) {
        for (int step = 0; step < 3; ++step) pair_step(&p);
        random_rules_make(&random, most, &rules);
        assert_int_equal(scree_weather_set_rules(p.weather, &rules.rules, NULL), SCREE_OK);
        weather_twin_rules(p.twin, &rules.rules);
      }
      pair_free(&p);
    }
    random_start_free(&start);
  }
}

static void a_column_of_rock_wears_to_nothing_as_in_the_twin(void** state) {
  (void)state;
  const scree_weather_start start = {.kind = SCREE_START_BOX, .size = {20, 24, 18}, .box_min = {4, 0, 4}, .box_max = {16, 22, 14}};
  scree_weather_rules rules;
  scree_weather_rules_default(&rules);
  rules.steps_per_voxel = 4;
  pair p;
  assert_true(pair_make(&p, &start, &rules, (scree_jobs){0}));
  scree_weather_stats stats;
  scree_weather_get_stats(p.weather, &stats);
  for (int step = 0; step < 400 && stats.rock + stats.colluvium > 0; ++step) {
    pair_step(&p);
    scree_weather_get_stats(p.weather, &stats);
  }
  assert_int_equal(stats.rock + stats.colluvium, 0);
  pair_free(&p);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_bubble_radius_and_curve_gives_the_twins_voxels),
      cmocka_unit_test(random_grids_and_rules_give_the_twins_voxels),
      cmocka_unit_test(rules_change_between_steps_as_in_the_twin),
      cmocka_unit_test(a_column_of_rock_wears_to_nothing_as_in_the_twin),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
