/* Benchmarks of whole scenes: every rock of each field, by the rules of the scene. Prints one JSON object a line.
 * scree-bench-scenes [name prefix] [content/scenes] [packs] [data]; reference: 10 ms, the goal. */
#define _POSIX_C_SOURCE 200809L

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "file.h"
#include "scene_live.h"

enum { RUNS = 31 };

static double seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

static int compare(const void* a, const void* b) {
  const double x = *(const double*)a, y = *(const double*)b;
  return (x > y) - (x < y);
}

static int fail(const char* what) {
  fprintf(stderr, "scree-bench-scenes: %s\n", what);
  return 1;
}

/* The median over runs of one fill of all layers into memory that has been written to before. */
static int measure(const char* name, const scene_live* world, scree_scratch* scratch) {
  scree_scene_query_desc desc = {.scene = scene_live_scene(world)};
  uint64_t count = 0;
  if (scree_scene_count(&desc, scratch, &count) != SCREE_OK || count == 0) return fail("a scene cannot be counted");
  scree_rock* rocks = malloc((size_t)count * sizeof *rocks);
  if (rocks == NULL) return fail("out of memory");
  double times[RUNS];
  bool good = scree_scene_fill(&desc, scratch, rocks, count, &count) == SCREE_OK;
  for (int run = 0; run < RUNS && good; ++run) {
    const double start = seconds();
    good = scree_scene_fill(&desc, scratch, rocks, count, &count) == SCREE_OK;
    times[run] = seconds() - start;
  }
  /* What each layer costs by itself, with the earlier ones that it may meet. */
  for (uint32_t i = 0; getenv("SCREE_BENCH_VERBOSE") != NULL && i < scree_scene_layer_count(desc.scene); ++i) {
    desc.layers = UINT64_C(1) << i;
    uint64_t part = 0;
    const double start = seconds();
    scree_scene_fill(&desc, scratch, rocks, count, &part);
    fprintf(stderr, "%s: layer %u: %llu rocks, %.2f ms\n", name, (unsigned)i, (unsigned long long)part, (seconds() - start) * 1e3);
  }
  free(rocks);
  if (!good) return fail("a scene cannot be queried");
  qsort(times, RUNS, sizeof times[0], compare);
  const double ms = times[RUNS / 2] * 1e3;
  printf("{\"name\": \"%s\", \"value\": %.3f, \"unit\": \"ms\", \"rocks\": %llu, \"reference\": 10, \"ratio\": %.2f}\n", name, ms,
         (unsigned long long)count, 10 / ms);
  return 0;
}

static int run_scene(const char* name, const char* file, const char* packs, const char* data) {
  scene_model scene;
  scree_error error = {""};
  if (scene_load(file, &scene, &error) != SCREE_OK) return fail(error.message);
  const scene_live_desc desc = {.scene = &scene, .paths = {.scene = file, .packs = packs, .data = data}};
  scene_live* world = NULL;
  scree_scratch* scratch = NULL;
  int status = 0;
  if (scene_live_create(&desc, &world, &error) != SCREE_OK || scene_live_update_all(world, &error) != SCREE_OK ||
      scree_scratch_create(NULL, &scratch) != SCREE_OK)
    status = fail(error.message[0] != '\0' ? error.message : "out of memory");
  else
    status = measure(name, world, scratch);
  scree_scratch_destroy(scratch);
  scene_live_destroy(world);
  scene_destroy(&scene);
  return status;
}

int main(int argc, char** argv) {
  static const struct {
    const char *name, *scene;
  } cases[] = {{"query.zen", "zen_garden"}, {"query.canyon", "canyon"}, {"query.bories", "bories"}, {"query.statue", "statue"}};
  const char *prefix = argc > 1 ? argv[1] : "", *scenes = argc > 2 ? argv[2] : "content/scenes";
  int status = 0;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    char file[600];
    if (strncmp(cases[i].name, prefix, strlen(prefix)) != 0) continue;
    snprintf(file, sizeof file, "%s/%s.json", scenes, cases[i].scene);
    status |= run_scene(cases[i].name, file, argc > 3 ? argv[3] : NULL, argc > 4 ? argv[4] : NULL);
  }
  return status;
}
