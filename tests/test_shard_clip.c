/* Cutting concave meshes into cells. The first argument is a folder with meshes: those that are not there are said to be skipped.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "allocator.h"
#include "failing_allocator.h"
#include "make_solids.h"
#include "pieces_twin.h"
#include "random.h"
#include "rounds.h"

static const char* folder = "";

/* --- Cutting as scree_shards_create does: seeds that do not go are moved. --- */

static shard_input input_of(const solid_mesh* mesh, double* seeds, uint32_t count) {
  return (shard_input){.positions = mesh->positions,
                       .indices = mesh->indices,
                       .vertex_count = mesh->vertex_count,
                       .triangle_count = mesh->triangle_count,
                       .seeds = seeds,
                       .seed_count = count,
                       .allocator = scree_rt_allocator_or_default(NULL)};
}

static void bounds_of(const solid_mesh* mesh, double min[3], double max[3]) {
  for (int a = 0; a < 3; ++a) min[a] = INFINITY, max[a] = -INFINITY;
  for (size_t k = 0; k < 3 * (size_t)mesh->vertex_count; ++k) {
    min[k % 3] = fmin(min[k % 3], mesh->positions[k]);
    max[k % 3] = fmax(max[k % 3], mesh->positions[k]);
  }
}

/* Moves by 1e-6 of about the spacing. */
static void move_seeds(const solid_mesh* mesh, double* seeds, uint32_t count, uint64_t round) {
  double min[3], max[3];
  bounds_of(mesh, min, max);
  const double spacing = cbrt((max[0] - min[0]) * (max[1] - min[1]) * (max[2] - min[2]) / count);
  random_stream stream = {.state = round};
  for (size_t k = 0; k < 3 * (size_t)count; ++k) seeds[k] += 1e-6 * spacing * (2 * random_unit(&stream) - 1);
}

static scree_result cut_moving(const solid_mesh* mesh, double* seeds, uint32_t count, shard_pieces* pieces, uint32_t* moves) {
  for (*moves = 0;; ++*moves) {
    const shard_input input = input_of(mesh, seeds, count);
    const scree_result result = shard_clip_cut(&input, pieces);
    if (result != SCREE_ERROR_UNSUPPORTED || *moves == 8) return result;
    move_seeds(mesh, seeds, count, *moves + 1);
  }
}

static double* random_seeds(const solid_mesh* mesh, uint32_t count, uint64_t round) {
  double min[3], max[3];
  bounds_of(mesh, min, max);
  double* seeds = malloc((size_t)count * 3 * sizeof *seeds);
  assert_non_null(seeds);
  random_stream stream = {.state = round};
  for (size_t k = 0; k < 3 * (size_t)count; ++k) seeds[k] = min[k % 3] + (max[k % 3] - min[k % 3]) * random_unit(&stream);
  return seeds;
}

static void assert_whole(const pieces_facts* facts, const char* what) {
  if (facts->disorder > 0 || facts->open_edges > 0)
    fail_msg("%s: %u out of order, %u open edges", what, facts->disorder, facts->open_edges);
  if (!(facts->worst_closure <= 1e-9)) fail_msg("%s: closure %g", what, facts->worst_closure);
  if (!(facts->volume_error <= 1e-9)) fail_msg("%s: volume off by %g", what, facts->volume_error);
  if (!(facts->surface_error <= 1e-9)) fail_msg("%s: surface off by %g", what, facts->surface_error);
  if (!(facts->least_volume >= 0)) fail_msg("%s: a cell of volume %g", what, facts->least_volume);
}

static void cut_randomly(const solid_mesh* mesh, const char* what, uint32_t rounds, uint32_t least, uint32_t most, bool twin) {
  uint32_t moved = 0;
  for (uint32_t round = 0; round < rounds; ++round) {
    const uint32_t count = least + (most - least) * round / (rounds > 1 ? rounds - 1 : 1);
    double* seeds = random_seeds(mesh, count, round + 1);
    shard_pieces pieces;
    uint32_t moves;
    const scree_result result = cut_moving(mesh, seeds, count, &pieces, &moves);
    if (result != SCREE_OK) fail_msg("%s, round %u: %s", what, round, scree_result_string(result));
    moved += moves;
    const shard_input input = input_of(mesh, seeds, count);
    double* volumes = malloc((size_t)count * sizeof *volumes);
    assert_non_null(volumes);
    pieces_facts facts;
    pieces_judge(&input, &pieces, volumes, &facts);
    char name[64];
    snprintf(name, sizeof name, "%s, round %u, %u seeds", what, round, count);
    assert_whole(&facts, name);
    for (uint32_t k = 0; twin && k < count; ++k) {
      const double plain = cell_volume_twin(&input, k);
      if (!(fabs(plain - volumes[k]) <= 1e-9 * input_volume(&input)))
        fail_msg("%s: cell %u has %.12g, the twin says %.12g", name, k, volumes[k], plain);
    }
    free(volumes);
    shard_pieces_free(&pieces, &input.allocator);
    free(seeds);
  }
  if (moved > rounds / 3) fail_msg("%s: seeds moved %u times", what, moved);
}

/* --- Solids that are always there. --- */

static solid_mesh make_u(void) {
  return solid_from_voxels(
      "XXX"
      "X X"
      "X X"
      "X X",
      3, 1, 4);
}

static void a_torus_is_cut(void** state) {
  (void)state;
  solid_mesh mesh = solid_torus(2, 0.7, 20, 10);
  cut_randomly(&mesh, "torus", ROUNDS(30, 6), 1, 40, true);
  cut_randomly(&mesh, "torus", ROUNDS(30, 6), 100, 2000, false);
  solid_mesh_free(&mesh);
}

static void a_box_with_a_hole_is_cut(void** state) {
  (void)state;
  solid_mesh mesh = solid_from_voxels(
      "XXX"
      "X X"
      "XXX",
      3, 3, 1);
  cut_randomly(&mesh, "box with a hole", ROUNDS(30, 6), 1, 60, true);
  cut_randomly(&mesh, "box with a hole", ROUNDS(30, 6), 100, 2000, false);
  solid_mesh_free(&mesh);
}

/* --- Meshes. --- */

static void meshes_are_cut(void** state) {
  (void)state;
  static const char* const names[] = {"elephant", "knot1", "armadillo", "bunny00"};
  for (size_t k = 0; k < sizeof names / sizeof *names; ++k) {
    char file[1024];
    solid_mesh mesh;
    snprintf(file, sizeof file, "%s/%s.off", folder, names[k]);
    if (!solid_read_off(file, &mesh)) {
      print_message("%s is not there: left out; ./dev fetches it\n", file);
      continue;
    }
    cut_randomly(&mesh, names[k], ROUNDS(30, 15), 20, 3000, false);
    solid_mesh_free(&mesh);
  }
}

static void a_goblin_is_cut(void** state) {
  (void)state;
  solid_mesh mesh = solid_goblin(48, 120);
  cut_randomly(&mesh, "goblin", ROUNDS(30, 15), 20, 3000, false);
  solid_mesh_free(&mesh);
}

int main(int argc, char** argv) {
  if (argc > 1) folder = argv[1];
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_torus_is_cut),
      cmocka_unit_test(a_box_with_a_hole_is_cut),
      cmocka_unit_test(meshes_are_cut),
      cmocka_unit_test(a_goblin_is_cut),
  };
  (void)make_u;
  return cmocka_run_group_tests(tests, NULL, NULL);
}
