/* scree-bench-frost [NAME]: freeze and thaw, one JSON object a line, for ./dev bench. `reference` is the paper written down
 * (frost_twin.c): linear scans, and all connected components at each breakage; it runs the first paths of the same stream, must
 * come to the same state, and its time is scaled to as many paths. */
#define BENCH_PROGRAM "scree-bench-frost"
#define _POSIX_C_SOURCE 200809L
#include "bench.h"

#include <math.h>
#include <string.h>

#include "frost_twin.h"
#include "make_hill.h"

static const char* prefix = "";

static bool wanted(const char* name) {
  return strncmp(name, prefix, strlen(prefix)) == 0;
}

static scree_shards* made(scree_shards* shards, const scree_error* error) {
  if (shards == NULL) die(error->message);
  return shards;
}

static scree_frost* freeze(const scree_shards* shards, const scree_frost_rules* rules, const uint8_t* states) {
  const scree_frost_desc desc = {.shards = shards, .rules = *rules, .states = states, .random_seed = 1};
  scree_frost* f;
  scree_error error;
  if (scree_frost_create(&desc, &f, &error) != SCREE_OK) die(error.message);
  return f;
}

/* Seconds for the twin's first paths, after which ours must be in the same state. */
static double time_twin(scree_frost* f, uint32_t paths) {
  frost_twin* twin = frost_twin_create(f);
  const double from = seconds();
  for (uint32_t i = 0; i < paths; ++i) frost_twin_path(twin, false);
  const double spent = seconds() - from;
  scree_frost_step(f, paths);
  if (memcmp(f->states, twin->states, f->view.shard_count) != 0 ||
      memcmp(f->lives, twin->lives, f->view.link_count * sizeof *f->lives) != 0 ||
      memcmp(f->exterior, twin->exterior, f->view.link_count) != 0)
    die("the twin came to another state");
  frost_twin_destroy(twin);
  return spent;
}

/* The median of five times `paths` paths from the same state. scale: of seconds to the unit. */
static void bench(const char* name, scree_frost* f, uint32_t paths, uint32_t twin_paths, double scale, const char* unit) {
  enum { TIMES = 5 };
  double times[TIMES];
  scree_frost_stats stats;
  scree_frost_snapshot* start;
  if (scree_frost_save(f, &start) != SCREE_OK) die("out of memory");
  for (int i = 0; i < TIMES; ++i) {
    scree_frost_restore(f, start);
    const double from = seconds();
    scree_frost_step(f, paths);
    times[i] = seconds() - from;
  }
  scree_frost_get_stats(f, &stats);
  const double ours = median(times, TIMES);
  scree_frost_restore(f, start);
  const double theirs = time_twin(f, twin_paths) * paths / twin_paths;
  printf(
      "{\"name\": \"%s\", \"value\": %.4g, \"unit\": \"%s\", \"reference\": %.4g, \"ratio\": %.4g, \"shards\": %u, \"links\": %u, "
      "\"paths\": %u, \"visited\": %llu, \"breaks\": %llu, \"falls\": %llu, \"air\": %u}\n",
      name, ours * scale, unit, theirs * scale, theirs / ours, f->view.shard_count, f->view.link_count, paths,
      (unsigned long long)stats.links_visited, (unsigned long long)stats.breaks, (unsigned long long)stats.detachments, stats.air);
  scree_frost_forget(f, start);
  scree_frost_destroy(f);
}

static void bench_path(void) {
  scree_error error;
  scree_shards* shards = made(make_hill(10000, 100, 1, &error), &error);
  scree_frost_rules rules;
  scree_frost_rules_default(&rules);
  bench("shards.path_10k", freeze(shards, &rules, NULL), 1000, 200, 1e6 / 1000, "us");
  scree_shards_destroy(shards);
}

/* The paper's cave: shards of the surface are core but for those that face the front, where the water comes from. */
static void bench_hill(void) {
  scree_error error;
  scree_shards* shards = made(make_hill(2908, 100, 1, &error), &error);
  scree_shards_view v;
  scree_shards_get(shards, &v);
  uint8_t* states = must(calloc(v.shard_count, 1));
  for (int pass = 0; pass < 2; ++pass)
    for (uint32_t l = v.interior_link_count; l < v.link_count; ++l) {
      const bool front = v.links[l].normal[2] > 0.6 && fabs(v.links[l].centroid[0]) < 15;
      if (pass == 0 && !front) states[v.links[l].shards[0]] = SCREE_SHARD_CORE;
      if (pass == 1 && front) states[v.links[l].shards[0]] = SCREE_SHARD_SOLID;
    }
  scree_frost_rules rules;
  scree_frost_rules_default(&rules);
  rules.rains[0] = (scree_rain){{0, -0.3, -1}, 0.3, 1};
  bench("shards.hill_70k", freeze(shards, &rules, states), 70000, 3500, 1, "s");
  free(states);
  scree_shards_destroy(shards);
}

/* A wall of columns of which the last row is core. */
static void bench_basalt(void) {
  scree_error error;
  scree_shards* shards = made(make_columns(29, 9, 15, 1, &error), &error);
  scree_shards_view v;
  scree_shards_get(shards, &v);
  uint8_t* states = must(calloc(v.shard_count, 1));
  for (uint32_t s = 0; s < v.shard_count; ++s)
    if (v.shards[s].centroid[2] < v.min[2] + 0.9) states[s] = SCREE_SHARD_CORE;
  scree_frost_rules rules;
  scree_frost_rules_default(&rules);
  rules.rains[0] = (scree_rain){{0, -1, -0.5}, 0.5, 1};
  memcpy(rules.gravity, rules.rains[0].direction, sizeof rules.gravity); /* upright columns have their links side by side */
  rules.damage = 2;
  bench("shards.basalt_4k", freeze(shards, &rules, states), 4000, 4000, 1e3, "ms");
  free(states);
  scree_shards_destroy(shards);
}

int main(int count, char** arguments) {
  if (count > 1) prefix = arguments[1];
  if (wanted("shards.path_10k")) bench_path();
  if (wanted("shards.hill_70k")) bench_hill();
  if (wanted("shards.basalt_4k")) bench_basalt();
  return 0;
}
