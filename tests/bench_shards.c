/* scree-bench-shards [NAME]: shards of solids, one JSON object a line, for ./dev bench. `reference` is Voro++ in the same run: its
 * cells with neighbours, without graphs. Where Voro++ is missing the line has none. */
#define BENCH_PROGRAM "scree-bench-shards"
#define _POSIX_C_SOURCE 200809L
#include "bench.h"

#include <scree/shards.h>
#include <string.h>

#include "convex_solids.h"
#include "make_solids.h"
#ifdef SCREE_VORO
#include "voro_cells.h"
#endif

enum { CELLS = 10000, CONCAVE_CELLS = 3000, ROUNDS = 9 };

static const double MIN[3] = {-1.01, -0.01, -1.01}, MAX[3] = {1.01, 0.91, 1.01};

/* Cells and both graphs of a convex hill of 74 planes. */
static void bench_cells(void) {
  static convex_solid made;
  const convex_solid* hill = &made;
  make_hill(&made);
  double* seeds = must(malloc(3 * (size_t)CELLS * sizeof *seeds));
  lay_seeds(1, MIN, MAX, hill->planes, HILL_PLANES, CELLS, seeds);
  const scree_shards_desc desc = {.solid = hill->solid, .seeds = seeds, .seed_count = CELLS, .link_angle = 1e-3};
  double times[ROUNDS];
  uint32_t links = 0, neighbours = 0;
#ifdef SCREE_VORO
  double voro_times[ROUNDS];
  uint32_t faces = 0;
#endif
  for (int round = 0; round < ROUNDS; ++round) {
    scree_shards* shards;
    scree_error error;
    double from = seconds();
    if (scree_shards_create(&desc, &shards, &error) != SCREE_OK) die(error.message);
    times[round] = (seconds() - from) * 1e3;
    scree_shards_view view;
    scree_shards_get(shards, &view);
    links = view.link_count + view.interior_link_count;
    neighbours = view.neighbour_first[view.link_count] / 2;
    scree_shards_destroy(shards);
#ifdef SCREE_VORO
    voro_cells cells;
    from = seconds();
    voro_cells_make(MIN, MAX, hill->planes, HILL_PLANES, seeds, CELLS, &cells);
    voro_times[round] = (seconds() - from) * 1e3;
    faces = cells.neighbour_first[CELLS];
    voro_cells_free(&cells);
#endif
  }
  free(seeds);
  const double time = median(times, ROUNDS);
#ifdef SCREE_VORO
  if (faces != links) die("Voro++ has other faces");
  const double reference = median(voro_times, ROUNDS);
  printf(
      "{\"name\": \"shards.cells_10k\", \"value\": %.4g, \"unit\": \"ms\", \"reference\": %.4g, \"ratio\": %.4g, \"cells\": %d, "
      "\"faces\": %u, \"neighbours\": %u}\n",
      time, reference, reference / time, CELLS, links, neighbours);
#else
  fprintf(stderr, BENCH_PROGRAM ": Voro++ is missing, no reference\n");
  printf("{\"name\": \"shards.cells_10k\", \"value\": %.4g, \"unit\": \"ms\", \"cells\": %d, \"faces\": %u, \"neighbours\": %u}\n",
         time, CELLS, links, neighbours);
#endif
  fflush(stdout);
}

/* The same of a block that weather has worn, of 75,000 triangles, with all checks. */
static void bench_concave(void) {
  solid_mesh mesh = solid_goblin(84, 100);
  const scree_seed_pattern pattern = {.kind = SCREE_SEEDS_RANDOM, .count = CONCAVE_CELLS, .random_seed = 1};
  scree_shards_desc desc = {.solid = {.positions = mesh.positions,
                                      .indices = mesh.indices,
                                      .vertex_count = mesh.vertex_count,
                                      .triangle_count = mesh.triangle_count}};
  double *seeds, times[ROUNDS];
  scree_error error;
  if (scree_seeds_create(&pattern, &desc.solid, NULL, &seeds, &desc.seed_count, &error) != SCREE_OK) die(error.message);
  desc.seeds = seeds;
  uint32_t count = 0, links = 0;
  for (int round = 0; round < ROUNDS; ++round) {
    scree_shards* shards;
    const double from = seconds();
    if (scree_shards_create(&desc, &shards, &error) != SCREE_OK) die(error.message);
    times[round] = (seconds() - from) * 1e3;
    scree_shards_view view;
    scree_shards_get(shards, &view);
    if (view.attempts > 0) die("seeds were moved");
    count = view.shard_count;
    links = view.link_count;
    scree_shards_destroy(shards);
  }
  printf("{\"name\": \"shards.concave_3k\", \"value\": %.4g, \"unit\": \"ms\", \"triangles\": %u, \"shards\": %u, \"links\": %u}\n",
         median(times, ROUNDS), mesh.triangle_count, count, links);
  fflush(stdout);
  scree_seeds_free(NULL, seeds, desc.seed_count);
  solid_mesh_free(&mesh);
}

int main(int argc, char** argv) {
  const char* prefix = argc > 1 ? argv[1] : "";
  if (strncmp("shards.cells_10k", prefix, strlen(prefix)) == 0) bench_cells();
  if (strncmp("shards.concave_3k", prefix, strlen(prefix)) == 0) bench_concave();
  return 0;
}
