/* scree-bench-weather [NAME]: weathering, one JSON object a line, for ./dev bench. `reference` is the algorithm of the papers,
 * stored rates and notified neighbours, `naive` a recount of every bubble, both from the same state in the same run; milliseconds a
 * cycle unless the unit says otherwise. The three remove the same voxels, or the benchmark ends. */
#define BENCH_PROGRAM "scree-bench-weather"
#define _POSIX_C_SOURCE 200809L
#include "bench.h"
#include "bench_hoodoo.h"

#include <scree/weather.h>
#include <string.h>

#include "weather_internal.h"
#include "weather_stored.h"
#include "weather_twin.h"

static const char* prefix = "";

static bool wanted(const char* name) {
  return strncmp(name, prefix, strlen(prefix)) == 0;
}

static void check(scree_result result) {
  if (result != SCREE_OK) die(scree_result_string(result));
}

static scree_weather* make(const scree_weather_start* start, double radius, double steps_per_voxel) {
  static const scree_durability_point durability = {.durability = 1, .noise_amplitude = 0.5};
  const scree_bubble_segment bubble = {.bubbles = {{SCREE_BUBBLE_SPHERE, radius, 0}}, .bubble_count = 1};
  scree_weather_desc desc = {.start = *start};
  scree_weather_rules_default(&desc.rules);
  desc.rules.durability = &durability;
  desc.rules.bubbles = &bubble;
  desc.rules.exposure = 0; /* as in the papers */
  desc.rules.steps_per_voxel = steps_per_voxel;
  desc.rules.colluvium_share = 0;
  desc.rules.rockfall = SCREE_ROCKFALL_NONE;
  scree_weather* w;
  scree_error error;
  if (scree_weather_create(&desc, &w, &error) != SCREE_OK) die(error.message);
  return w;
}

/* The naive twin in the state of w, for a few steps: milliseconds a step. */
static double time_naive(const scree_weather* w, const scree_weather_start* start, const uint8_t* voxels, double radius,
                         double steps_per_voxel) {
  const size_t count = (size_t)start->size[0] * start->size[1] * start->size[2];
  const scree_durability_point durability = {.durability = 1, .noise_amplitude = 0.5};
  const scree_bubble_segment bubble = {.bubbles = {{SCREE_BUBBLE_SPHERE, radius, 0}}, .bubble_count = 1};
  scree_weather_rules rules;
  scree_weather_rules_default(&rules);
  rules.durability = &durability;
  rules.bubbles = &bubble;
  rules.exposure = 0;
  rules.steps_per_voxel = steps_per_voxel;
  rules.colluvium_share = 0;
  rules.rockfall = SCREE_ROCKFALL_NONE;
  int32_t* lives = must(malloc(count * sizeof *lives));
  size_t at = 0;
  for (uint32_t z = 0; z < w->size[2]; ++z)
    for (uint32_t y = 0; y < w->size[1]; ++y)
      for (uint32_t x = 0; x < w->size[0]; ++x) lives[at++] = w->life[weather_at(w, x, y, z)];
  weather_twin* twin = must(weather_twin_create(start->size, voxels, lives, start->seed));
  weather_twin_rules(twin, &rules);
  enum { STEPS = 3 };
  const double from = seconds();
  for (int i = 0; i < STEPS; ++i) weather_twin_step(twin);
  const double spent = seconds() - from;
  weather_twin_destroy(twin);
  free(lives);
  return spent * 1e3 / STEPS;
}

/* Means over the first `steps` steps with at least `least` and at most `most` active voxels. */
static void bench_cycles(const char* name, const scree_weather_start* start, double radius, double steps_per_voxel, uint64_t least,
                         uint64_t most, uint32_t steps) {
  if (!wanted(name)) return;
  const size_t count = (size_t)start->size[0] * start->size[1] * start->size[2];
  scree_weather* w = make(start, radius, steps_per_voxel);
  uint8_t* voxels = must(malloc(count));
  float* durability = must(malloc(count * sizeof *durability));
  scree_weather_voxels(w, voxels);
  size_t at = 0;
  for (uint32_t z = 0; z < w->size[2]; ++z)
    for (uint32_t y = 0; y < w->size[1]; ++y)
      for (uint32_t x = 0; x < w->size[0]; ++x) durability[at++] = weather_durability(w, x, y, z);
  weather_stored* stored = must(weather_stored_create(start->size, voxels, durability, radius, steps_per_voxel));
  double ours = 0, theirs = 0, naive = 0;
  uint64_t active = 0, removed = 0;
  uint32_t first = 0, measured = 0, step = 0;
  for (; measured < steps && step < 4096; ++step) {
    scree_weather_stats stats;
    scree_weather_get_stats(w, &stats);
    const bool counts = stats.active >= least && stats.active <= most;
    if (measured > 0 && !counts) break;
    if (stats.rock == 0) break;
    if (counts && measured == 0) {
      first = step;
      scree_weather_voxels(w, voxels);
      naive = time_naive(w, start, voxels, radius, steps_per_voxel);
    }
    const double from = seconds();
    check(scree_weather_step(w, 1));
    const double spent = seconds() - from;
    if (!counts) continue;
    ours += spent;
    active += stats.active;
    scree_weather_get_stats(w, &stats);
    removed += stats.removed;
    ++measured;
  }
  if (measured == 0) die("no step had the right number of active voxels");
  for (uint32_t i = 0; i < step; ++i) {
    const double from = seconds();
    weather_stored_step(stored);
    if (i >= first) theirs += seconds() - from;
  }
  scree_weather_voxels(w, voxels);
  at = 0;
  for (uint32_t z = 0; z < w->size[2]; ++z)
    for (uint32_t y = 0; y < w->size[1]; ++y)
      for (uint32_t x = 0; x < w->size[0]; ++x)
        if ((voxels[at++] != 0) != weather_stored_rock(stored, x, y, z)) die("the algorithms differ");
  printf(
      "{\"name\": \"%s\", \"value\": %.4g, \"unit\": \"ms\", \"reference\": %.4g, \"ratio\": %.4g, \"naive\": %.4g, "
      "\"active\": %.0f, \"removed\": %.0f, \"steps\": %u}\n",
      name, ours * 1e3 / measured, theirs * 1e3 / measured, theirs / ours, naive, (double)active / measured,
      (double)removed / measured, measured);
  weather_stored_destroy(stored);
  scree_weather_destroy(w);
  free(voxels);
  free(durability);
}

/* A column of ten million voxels on the ground to nothing. */
static void bench_dissolve(void) {
  if (!wanted("hoodoo.dissolve_seconds") && !wanted("hoodoo.dissolve_megabytes")) return;
  const scree_weather_start start = {.kind = SCREE_START_BOX, .size = {100, 1000, 100}};
  const double from = seconds();
  scree_weather* w = make(&start, 4, 3);
  check(scree_weather_run(w, 0, 100000, NULL, NULL));
  const double spent = seconds() - from;
  scree_weather_stats stats;
  scree_weather_get_stats(w, &stats);
  if (stats.rock != 0) die("something is left of the column");
  const double megabytes = (double)stats.memory * 1e-6;
  scree_weather_destroy(w);

  w = make(&start, 4, 3);
  const size_t count = (size_t)start.size[0] * start.size[1] * start.size[2];
  uint8_t* voxels = must(malloc(count));
  float* durability = must(malloc(count * sizeof *durability));
  scree_weather_voxels(w, voxels);
  size_t at = 0;
  for (uint32_t z = 0; z < w->size[2]; ++z)
    for (uint32_t y = 0; y < w->size[1]; ++y)
      for (uint32_t x = 0; x < w->size[0]; ++x) durability[at++] = weather_durability(w, x, y, z);
  scree_weather_destroy(w);
  const double theirs_from = seconds();
  weather_stored* stored = must(weather_stored_create(start.size, voxels, durability, 4, 3));
  uint64_t cycles = 0;
  while (weather_stored_left(stored) > 0) {
    weather_stored_step(stored);
    ++cycles;
  }
  const double theirs = seconds() - theirs_from;
  if (cycles != stats.step) die("the algorithms differ");
  weather_stored_destroy(stored);
  free(voxels);
  free(durability);
  if (wanted("hoodoo.dissolve_seconds"))
    printf(
        "{\"name\": \"hoodoo.dissolve_seconds\", \"value\": %.4g, \"unit\": \"s\", \"reference\": %.4g, \"ratio\": %.4g, "
        "\"steps\": %u}\n",
        spent, theirs, theirs / spent, (unsigned)stats.step);
  if (wanted("hoodoo.dissolve_megabytes"))
    printf("{\"name\": \"hoodoo.dissolve_megabytes\", \"value\": %.4g, \"unit\": \"MB\"}\n", megabytes);
}

int main(int count, char** arguments) {
  if (count > 1) prefix = arguments[1];
  /* The papers' cube has 100 voxels a side and counts the layer under the surface as active, too. Here only what is exposed is
   * active: as many voxels take a larger cube. It floats, as theirs does. */
  const scree_weather_start cube = {
      .kind = SCREE_START_BOX, .size = {136, 152, 136}, .box_min = {0, 16, 0}, .box_max = {136, 152, 136}};
  bench_cycles("hoodoo.cycle_r1", &cube, 1, 16, 100000, 110000, 24);
  bench_cycles("hoodoo.cycle_r4", &cube, 4, 16, 100000, 110000, 24);
  bench_cycles("hoodoo.cycle_r7", &cube, 7, 16, 100000, 110000, 24);
  const scree_weather_start column = {.kind = SCREE_START_BOX, .size = {53, 106, 53}};
  bench_cycles("hoodoo.column_r3", &column, 3, 8, 22000, 25500, 24);
  bench_cycles("hoodoo.column_r7", &column, 7, 8, 22000, 25500, 24);
  bench_dissolve();
  if (wanted("hoodoo.goblin_seconds")) bench_goblin();
  if (wanted("hoodoo.steer")) bench_steer(false);
  if (wanted("hoodoo.steer_larger")) bench_steer(true);
  return 0;
}
