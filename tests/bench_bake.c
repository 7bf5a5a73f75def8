/* scree-bench-bake [NAME]: how long rocks take to bake, one JSON object a line, for ./dev bench. The reference is what Peytavie et
 * al. report for the same number of rocks in 2009; a ratio above 1 is faster than that. */
#include <scree/threads.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake_internal.h"
#include "clock.h"

static const char* prefix = "";

static bool wanted(const char* name) {
  return strncmp(name, prefix, strlen(prefix)) == 0;
}

static void print_row(const char* name, double value, const char* unit, double reference) {
  printf("{\"name\": \"%s\", \"value\": %.4g, \"unit\": \"%s\"", name, value, unit);
  if (reference > 0) printf(", \"reference\": %g, \"ratio\": %.4g", reference, reference / value);
  printf("}\n");
  fflush(stdout);
}

static void end(scree_result result) {
  fprintf(stderr, "scree-bench-bake: %s\n", scree_result_string(result));
  exit(1);
}

/* Seconds from the recipe to the finest mesh of every unique rock, on this thread. */
static double mesh_all(const scree_recipe* recipe) {
  const double start = clock_seconds();
  const scree_bake_desc desc = {.recipe = recipe};
  bake_run bake;
  scree_result result = bake_begin(&desc, false, &bake);
  if (result != SCREE_OK) end(result);
  bake_worker* worker = &bake.workers[0];
  uint64_t triangles = 0;
  for (uint32_t i = 0; i < bake.cell_count; ++i) {
    const uint32_t cell = bake.cells[i];
    for (uint32_t seed = 0; seed < bake.cell_rocks[cell + 1] - bake.cell_rocks[cell]; ++seed) {
      if (!bake_rock_field(&bake, worker, cell, seed)) continue;
      result = rock_mesh(&worker->mesher, &worker->rock, 1);
      if (result != SCREE_OK) end(result);
      triangles += worker->mesher.meshes[0].index_count / 3;
    }
  }
  bake_end(&bake);
  const double seconds = clock_seconds() - start;
  if (triangles == 0) end(SCREE_ERROR_CORRUPT); /* nothing was timed */
  return seconds;
}

static int compare(const void* a, const void* b) {
  const double x = *(const double*)a, y = *(const double*)b;
  return x < y ? -1 : x > y;
}

static void bench_meshes(const char* name, uint32_t n, bool chiselled, double reference) {
  if (!wanted(name)) return;
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  recipe.n = n;
  recipe.voxels_per_cell = 10;
  if (!chiselled) {
    recipe.chisel_planes = 0;
    recipe.noise = 0;
  }
  double seconds[3];
  for (int run = 0; run < 3; ++run) seconds[run] = mesh_all(&recipe);
  qsort(seconds, 3, sizeof *seconds, compare);
  print_row(name, seconds[1], "s", reference);
}

static void bench_pack(void) {
  if (!wanted("rocks.pack_seconds") && !wanted("rocks.pack_megabytes")) return;
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  scree_threads* pool;
  const scree_result started = scree_threads_create(1, NULL, &pool);
  if (started != SCREE_OK) end(started);
  const scree_bake_desc desc = {.recipe = &recipe, .jobs = scree_threads_jobs(pool)};
  double seconds[3], megabytes = 0;
  for (int run = 0; run < 3; ++run) {
    const double start = clock_seconds();
    uint8_t* bytes;
    size_t size;
    const scree_result result = scree_bake_rocks(&desc, &bytes, &size, NULL, NULL);
    if (result != SCREE_OK) end(result);
    seconds[run] = clock_seconds() - start;
    megabytes = (double)size * 1e-6;
    scree_bake_free(&desc, bytes, size);
  }
  scree_threads_destroy(pool);
  qsort(seconds, 3, sizeof *seconds, compare);
  if (wanted("rocks.pack_seconds")) print_row("rocks.pack_seconds", seconds[1], "s", 0);
  if (wanted("rocks.pack_megabytes")) print_row("rocks.pack_megabytes", megabytes, "MB", 0);
}

int main(int count, char** arguments) {
  if (count > 1) prefix = arguments[1];
  bench_meshes("rocks.n5_plain", 5, false, 23);
  bench_meshes("rocks.n7_chiselled", 7, true, 176);
  bench_pack();
  return 0;
}
