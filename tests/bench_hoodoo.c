#define BENCH_PROGRAM "scree-bench-weather"
#define _POSIX_C_SOURCE 200809L
#include "bench_hoodoo.h"

#include <math.h>
#include <scree/threads.h>
#include <scree/weather.h>
#include <string.h>

#include "bench.h"

enum { WIDTH = 192, HEIGHT = 130, DEPTH = 188, ROCK_HEIGHT = 110, ROCK_RADIUS = 48 };

#define ALTITUDE(share) ((double)(share)*ROCK_HEIGHT / HEIGHT)

/* Beds of the goblin, with the noise of all of them. */
#define BED(share, durability) \
  { ALTITUDE(share), durability, 0.7, 1 / 0.045, 1 }

static scree_weather* make_goblin(const scree_jobs* jobs) {
  static const scree_durability_point beds[] = {BED(0, 1.9),     BED(0.10, 1.5), BED(0.22, 0.55), BED(0.34, 0.42),
                                                BED(0.42, 0.75), BED(0.50, 0.5), BED(0.58, 0.42), BED(0.62, 1.25),
                                                BED(0.80, 2.0),  BED(0.92, 1.7), BED(1, 1.2)};
  uint8_t* map = must(calloc(WIDTH * DEPTH, 1));
  for (int z = 0; z < DEPTH; ++z)
    for (int x = 0; x < WIDTH; ++x) {
      const double u = x + 0.5 - WIDTH / 2.0, v = z + 0.5 - DEPTH / 2.0, a = atan2(v, u);
      const double lobes = 0.8 + 0.1 * sin(2 * a) + 0.07 * sin(3 * a) + 0.05 * sin(5 * a);
      if (sqrt(u * u + v * v) < ROCK_RADIUS * lobes) map[x + WIDTH * z] = 255 * ROCK_HEIGHT / HEIGHT;
    }
  scree_weather_desc desc = {.start = {.kind = SCREE_START_JOINT_MAP,
                                       .size = {WIDTH, HEIGHT, DEPTH},
                                       .map = map,
                                       .map_width = WIDTH,
                                       .map_depth = DEPTH,
                                       .seed = 7}};
  scree_weather_rules_default(&desc.rules);
  desc.rules.durability = beds;
  desc.rules.durability_count = sizeof beds / sizeof beds[0];
  if (jobs != NULL) desc.jobs = *jobs;
  scree_weather* w;
  scree_error error;
  if (scree_weather_create(&desc, &w, &error) != SCREE_OK) die(error.message);
  free(map);
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
    scree_weather* w = make_goblin(NULL);
    scree_mesher* mesher;
    check(scree_weather_run(w, 0.4, 100000, NULL, NULL));
    check(scree_mesher_create(w, &mesher));
    check(scree_mesher_update(mesher, 0, &surface));
    spent[i] = seconds() - from;
    scree_weather_get_stats(w, &stats);
    scree_mesher_destroy(mesher);
    scree_weather_destroy(w);
  }
  printf("{\"name\": \"hoodoo.goblin_seconds\", \"value\": %.4g, \"unit\": \"s\", \"steps\": %u, \"vertices\": %u}\n",
         median(spent, TRIES), (unsigned)stats.step, surface.vertex_count);
}

void bench_steer(void) {
  enum { FRAMES = 41 };
  scree_threads* threads;
  check(scree_threads_create(1, NULL, &threads)); /* and this one */
  const scree_jobs jobs = scree_threads_jobs(threads);
  scree_weather* w = make_goblin(&jobs);
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
  printf("{\"name\": \"hoodoo.steer\", \"value\": %.4g, \"unit\": \"ms\", \"step\": %.4g, \"threads\": %u, \"vertices\": %u}\n",
         median(frames, FRAMES), median(steps, FRAMES), jobs.worker_count, surface.vertex_count);
  scree_mesher_destroy(mesher);
  scree_weather_destroy(w);
  scree_threads_destroy(threads);
}
