#define BENCH_PROGRAM "scree-bench-weather"
#define _POSIX_C_SOURCE 200809L
#include "bench_hoodoo.h"

#include <scree/hoodoo.h>
#include <scree/threads.h>
#include <scree/weather.h>
#include <string.h>

#include "bench.h"

#define RECIPE "content/recipes/goblin.json"

static void read_recipe(scree_hoodoo_recipe* recipe) {
  static char text[1 << 16];
  FILE* file = fopen(RECIPE, "rb");
  if (file == NULL) die(RECIPE ": cannot be read; run this from the root of the repository");
  const size_t size = fread(text, 1, sizeof text, file);
  fclose(file);
  scree_error error;
  if (scree_hoodoo_parse(text, size, recipe, &error) != SCREE_OK) die(error.message);
}

/* The first variant of the recipe, before its first step. */
static scree_weather* make_goblin(const scree_hoodoo_recipe* recipe, const scree_jobs* jobs) {
  scree_hoodoo_desc bake = {.recipe = recipe};
  scree_hoodoo_start_memory memory;
  scree_weather_desc desc = {0};
  scree_error error;
  if (scree_hoodoo_start_make(&bake, 0, &desc.start, &memory, &error) != SCREE_OK) die(error.message);
  scree_hoodoo_rules_view(&recipe->rules, &desc.rules);
  if (jobs != NULL) desc.jobs = *jobs;
  scree_weather* w;
  if (scree_weather_create(&desc, &w, &error) != SCREE_OK) die(error.message);
  scree_hoodoo_start_free(&bake, &memory);
  return w;
}

static void check(scree_result result) {
  if (result != SCREE_OK) die(scree_result_string(result));
}

void bench_goblin(void) {
  enum { TRIES = 3 };
  double spent[TRIES];
  scree_surface surface;
  scree_weather_stats stats;
  for (int i = 0; i < TRIES; ++i) {
    const double from = seconds();
    static scree_hoodoo_recipe recipe;
    read_recipe(&recipe);
    scree_weather* w = make_goblin(&recipe, NULL);
    scree_mesher* mesher;
    check(scree_weather_run(w, recipe.ages[recipe.age_count - 1], recipe.max_steps, NULL, NULL));
    check(scree_mesher_create(w, &mesher));
    check(scree_mesher_update(mesher, 0, &surface));
    spent[i] = seconds() - from;
    scree_weather_get_stats(w, &stats);
    scree_mesher_destroy(mesher);
    scree_weather_destroy(w);
  }
  printf(
      "{\"name\": \"hoodoo.goblin_seconds\", \"value\": %.4g, \"unit\": \"s\", \"goal\": 0.5, \"steps\": %u, \"vertices\": %u}\n",
      median(spent, TRIES), (unsigned)stats.step, surface.vertex_count);
}

void bench_steer(bool larger) {
  enum { FRAMES = 41 };
  scree_threads* threads;
  check(scree_threads_create(1, NULL, &threads)); /* and this one */
  const scree_jobs jobs = scree_threads_jobs(threads);
  static scree_hoodoo_recipe recipe;
  read_recipe(&recipe);
  if (larger) {
    for (int a = 0; a < 3; ++a) recipe.size[a] += recipe.size[a] / 4;
    recipe.start.radius *= 1.25;
  }
  scree_weather* w = make_goblin(&recipe, &jobs);
  scree_mesher* mesher;
  scree_surface surface;
  check(scree_weather_run(w, 0.6, 100000, NULL, NULL));
  check(scree_mesher_create(w, &mesher));
  check(scree_mesher_update(mesher, 0, &surface));
  double frames[FRAMES], steps[FRAMES];
  for (int i = 0; i < FRAMES; ++i) {
    const double from = clock_seconds(CLOCK_MONOTONIC);
    check(scree_weather_step(w, 1));
    const double between = clock_seconds(CLOCK_MONOTONIC);
    check(scree_mesher_update(mesher, 0, &surface));
    frames[i] = (clock_seconds(CLOCK_MONOTONIC) - from) * 1e3;
    steps[i] = (between - from) * 1e3;
  }
  double worst = 0;
  for (int i = 0; i < FRAMES; ++i) worst = frames[i] > worst ? frames[i] : worst;
  printf(
      "{\"name\": \"hoodoo.steer%s\", \"value\": %.4g, \"unit\": \"ms\", \"goal\": 16, \"worst\": %.4g, \"step\": %.4g, "
      "\"threads\": %u, \"vertices\": %u}\n",
      larger ? "_larger" : "", median(frames, FRAMES), worst, median(steps, FRAMES), jobs.worker_count, surface.vertex_count);
  scree_mesher_destroy(mesher);
  scree_weather_destroy(w);
  scree_threads_destroy(threads);
}
