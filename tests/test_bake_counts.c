/* Whole bakes of the paper's three sizes, cheap ones: as many rocks as the formula says. */
#include <scree/bake.h>
#include <scree/pack.h>
#include <scree/threads.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

static void unique_rocks_number_7382_17202_and_33262(void** state) {
  (void)state;
  static const uint32_t counts[3] = {7382, 17202, 33262};
  scree_threads* pool;
  assert_int_equal(scree_threads_create(1, NULL, &pool), SCREE_OK);
  for (uint32_t i = 0; i < 3; ++i) {
    scree_recipe recipe;
    scree_recipe_default(&recipe);
    recipe.n = 5 + i;
    recipe.voxels_per_cell = 6;
    recipe.lod_levels = 1;
    recipe.noise = 0;
    recipe.chisel_planes = 0;
    recipe.erosion_steps = 0;
    const scree_bake_desc desc = {.recipe = &recipe, .jobs = scree_threads_jobs(pool)};
    uint8_t* bytes;
    size_t size;
    scree_bake_report report;
    assert_int_equal(scree_bake_rocks(&desc, &bytes, &size, &report, NULL), SCREE_OK);
    scree_pack* pack;
    assert_int_equal(scree_pack_open_memory(bytes, size, NULL, &pack), SCREE_OK);
    scree_pack_info info;
    scree_pack_get_info(pack, &info);
    print_message("n %u: %u rocks of %u cells, %.1f contacts each, %.1f s\n", recipe.n, report.rocks, info.cell_count,
                  (double)report.contacts / report.rocks, report.seconds);
    assert_int_equal(report.rocks, counts[i]);
    assert_int_equal(info.asset_count, counts[i]);
    assert_int_equal(info.cell_count, counts[i]);
    assert_int_equal(info.max_rocks_per_cell, 1);
    assert_true(info.digest == report.digest);
    assert_true(report.contacts >= 9 * (uint64_t)report.rocks);
    assert_int_equal(scree_pack_verify(pack), SCREE_OK);
    scree_pack_close(pack);
    scree_bake_free(&desc, bytes, size);
  }
  scree_threads_destroy(pool);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(unique_rocks_number_7382_17202_and_33262)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
