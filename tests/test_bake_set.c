/* A whole bake: the same bytes whatever the threads and kernels, progress, cancelling, and memory that runs short anywhere. */
#include <scree/bake.h>
#include <scree/pack.h>
#include <scree/threads.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "bake_internal.h"
#include "failing_allocator.h"
#include "rounds.h"

static scree_recipe small_recipe(void) {
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  recipe.n = 4;
  recipe.voxels_per_cell = 6;
  recipe.lod_levels = 2;
  recipe.proxies = false; /* they are as much work for a small recipe as for a large one */
  return recipe;
}

/* `threads` of them, the calling one among them. */
static scree_threads* pool_of(uint32_t threads) {
  scree_threads* pool;
  assert_int_equal(scree_threads_create(threads - 1, NULL, &pool), SCREE_OK);
  return pool;
}

static void threads_make_no_difference_to_a_byte(void** state) {
  (void)state;
  scree_recipe recipe = small_recipe();
  recipe.seeds_max = 2;
  recipe.proxies = true;
  static const uint32_t threads[3] = {1, 5, 2};
  uint8_t *first = NULL, *bytes;
  size_t first_size = 0, size;
  uint64_t digest = 0;
  for (int i = 0; i < ROUNDS(3, 2); ++i) {
    scree_threads* pool = pool_of(threads[i]);
    const scree_bake_desc desc = {.recipe = &recipe, .jobs = scree_threads_jobs(pool)};
    scree_bake_report report;
    assert_int_equal(scree_bake_rocks(&desc, &bytes, &size, &report, NULL), SCREE_OK);
    scree_threads_destroy(pool);
    assert_int_equal(report.bytes, size);
    if (i == 0) {
      first = bytes;
      first_size = size;
      digest = report.digest;
      continue;
    }
    assert_non_null(first);
    assert_int_equal(size, first_size);
    assert_true(memcmp(bytes, first, size) == 0);
    assert_true(report.digest == digest);
    scree_bake_free(&desc, bytes, size);
  }
  const scree_bake_desc desc = {.recipe = &recipe};
  scree_bake_free(&desc, first, first_size);
}

static void plain_and_wide_kernels_give_the_same_bits(void** state) {
  (void)state;
  for (int kind = 0; kind < 3; ++kind) {
    scree_recipe recipe = small_recipe();
    if (kind == 1) recipe.voxels_per_cell = 10, recipe.gamma = (scree_range){4, 6};
    if (kind == 2) recipe.voxels_per_cell = 8, recipe.seeds_min = 3, recipe.seeds_max = 5;
    const scree_bake_desc desc = {.recipe = &recipe};
    bake_run plain, wide;
    assert_int_equal(bake_begin(&desc, true, &plain), SCREE_OK);
    assert_int_equal(bake_begin(&desc, false, &wide), SCREE_OK);
    assert_string_equal(plain.kernels->name, "plain");
    if (wide.kernels == plain.kernels) print_message("this machine has one set of kernels\n");
    uint32_t rocks = 0, unlike = 0;
    for (uint32_t i = 0; i < plain.cell_count; i += 7) {
      const uint32_t cell = plain.cells[i];
      for (uint32_t seed = 0; seed < plain.cell_rocks[cell + 1] - plain.cell_rocks[cell]; ++seed) {
        bake_worker *a = &plain.workers[0], *b = &wide.workers[0];
        const bool any = bake_rock_field(&plain, a, cell, seed);
        assert_int_equal(bake_rock_field(&wide, b, cell, seed), any);
        if (!any) continue;
        ++rocks;
        assert_memory_equal(&a->rock.grid, &b->rock.grid, sizeof a->rock.grid);
        const rock_grid* grid = &a->rock.grid;
        const size_t count = (size_t)grid->size[0] * grid->size[1] * grid->size[2];
        bool same = memcmp(a->rock.field, b->rock.field, count * sizeof(float)) == 0;
        assert_int_equal(rock_mesh(&a->mesher, &a->rock, recipe.lod_levels), SCREE_OK);
        assert_int_equal(rock_mesh(&b->mesher, &b->rock, recipe.lod_levels), SCREE_OK);
        for (uint32_t level = 0; level < recipe.lod_levels; ++level) {
          const mesh_buffer *m = &a->mesher.meshes[level], *w = &b->mesher.meshes[level];
          same = same && m->vertex_count == w->vertex_count && m->index_count == w->index_count &&
                 memcmp(m->positions, w->positions, m->vertex_count * sizeof *m->positions) == 0 &&
                 memcmp(m->occlusion, w->occlusion, m->vertex_count) == 0 &&
                 memcmp(m->indices, w->indices, m->index_count * sizeof *m->indices) == 0;
        }
        int16_t hull_a[ROCK_MAX_HULL][3], hull_b[ROCK_MAX_HULL][3];
        const uint32_t hull_count = rock_hull(&a->mesher, recipe.hull_vertices, hull_a);
        same = same && rock_hull(&b->mesher, recipe.hull_vertices, hull_b) == hull_count &&
               memcmp(hull_a, hull_b, hull_count * sizeof *hull_a) == 0;
        unlike += !same;
      }
    }
    bake_end(&plain);
    bake_end(&wide);
    assert_true(rocks > 300);
    assert_int_equal(unlike, 0);
  }
}

/* --- Progress. --- */

typedef struct watcher {
  atomic_int inside; /* callbacks that run right now */
  double last, stop_at;
  uint32_t calls, faults;
} watcher;

static bool watch(void* user, const char* stage, double done) {
  watcher* w = user;
  if (atomic_fetch_add(&w->inside, 1) != 0) ++w->faults;
  ++w->calls;
  if (stage == NULL || stage[0] == '\0' || !(done >= w->last && done <= 1)) ++w->faults;
  w->last = done;
  atomic_fetch_sub(&w->inside, 1);
  return done < w->stop_at;
}

static void progress_never_falls_and_is_told_by_one_at_a_time(void** state) {
  (void)state;
  const scree_recipe recipe = small_recipe();
  static const uint32_t threads[2] = {1, 5};
  for (int i = 0; i < 2; ++i) {
    watcher w = {.stop_at = 2};
    scree_threads* pool = pool_of(threads[i]);
    const scree_bake_desc desc = {.recipe = &recipe, .jobs = scree_threads_jobs(pool), .progress = watch, .progress_user = &w};
    uint8_t* bytes;
    size_t size;
    assert_int_equal(scree_bake_rocks(&desc, &bytes, &size, NULL, NULL), SCREE_OK);
    scree_threads_destroy(pool);
    scree_bake_free(&desc, bytes, size);
    assert_int_equal(w.faults, 0);
    assert_true(w.calls >= 2);
    if (threads[i] == 1) assert_true(w.last == 1);
  }
}

/* --- Memory. --- */

static void a_cancelled_bake_leaves_nothing_behind(void** state) {
  (void)state;
  const scree_recipe recipe = small_recipe();
  static const uint32_t threads[2] = {1, 5};
  static const double stops[3] = {0, 0.4, 1};
  for (int i = 0; i < 6; ++i) {
    watcher w = {.stop_at = stops[i / 2]};
    failing_allocator memory = {.fail_at = -1};
    scree_threads* pool = pool_of(threads[i % 2]);
    const scree_bake_desc desc = {.recipe = &recipe,
                                  .jobs = scree_threads_jobs(pool),
                                  .allocator = failing_allocator_of(&memory),
                                  .progress = watch,
                                  .progress_user = &w};
    uint8_t* bytes = (uint8_t*)1;
    size_t size = 1;
    const scree_result result = scree_bake_rocks(&desc, &bytes, &size, NULL, NULL);
    scree_threads_destroy(pool);
    /* With threads the last call may tell of less than all. */
    if (stops[i / 2] < 1 || threads[i % 2] == 1) assert_int_equal(result, SCREE_ERROR_CANCELLED);
    if (result == SCREE_OK) scree_bake_free(&desc, bytes, size);
    if (result != SCREE_OK) assert_true(bytes == NULL && size == 0);
    assert_int_equal(memory.live, 0);
  }
}

/* Returns the number of allocations. */
static int bake_with(failing_allocator* memory, bool proxies, scree_result* result) {
  scree_recipe recipe = small_recipe();
  recipe.proxies = proxies;
  recipe.lod_levels = 1;
  recipe.chisel_planes = 0;
  recipe.noise = 0;
  recipe.erosion_steps = 1;
  const scree_bake_desc desc = {.recipe = &recipe, .allocator = failing_allocator_of(memory)};
  uint8_t* bytes = NULL;
  size_t size = 0;
  scree_bake_report report;
  *result = scree_bake_rocks(&desc, &bytes, &size, &report, NULL);
  if (*result == SCREE_OK)
    scree_bake_free(&desc, bytes, size);
  else
    assert_true(bytes == NULL && size == 0);
  assert_int_equal(memory->live, 0);
  return memory->calls;
}

static void memory_that_runs_short_anywhere_is_reported_and_given_back(void** state) {
  (void)state;
  scree_result result;
  failing_allocator all = {.fail_at = -1};
  const int total = bake_with(&all, false, &result);
  assert_int_equal(result, SCREE_OK);
  assert_true(total > 2000);
  int tried = 0;
  /* Each of the first, where tables are made and buffers grow, alone and with all that follow; two of the many alike; and each of
   * the last, where the pack is. */
  for (int n = 1; n <= total; n += n < 64 || n + 5 > total ? 1 : n < total / 2 ? total / 2 - n : total - 4 - n) {
    for (int after = 0; after < (n <= 64 ? 2 : 1); ++after) {
      failing_allocator memory = {.fail_at = n - 1, .and_later = after != 0};
      bake_with(&memory, false, &result);
      assert_int_equal(result, SCREE_ERROR_OUT_OF_MEMORY);
    }
    ++tried;
  }
  /* And some of the proxies, which come last. */
  failing_allocator merged = {.fail_at = -1};
  const int more = bake_with(&merged, true, &result);
  assert_true(result == SCREE_OK && more > total + 2000);
  for (int n = total; n < total + ROUNDS(12, 3); n += 4) {
    failing_allocator memory = {.fail_at = n - 1};
    bake_with(&memory, true, &result);
    assert_int_equal(result, SCREE_ERROR_OUT_OF_MEMORY);
  }
  print_message("%d of %d allocations failed in turn\n", tried, total);
  assert_true(tried > 60);
}

/* So many seeds on so few voxels that some own none, and noise that eats others: the rest keep the numbers that contacts name. */
static void seeds_whose_rocks_are_empty_leave_gaps_in_the_numbers(void** state) {
  (void)state;
  scree_recipe recipe = small_recipe();
  recipe.lod_levels = 1;
  recipe.seeds_min = 3, recipe.seeds_max = 5;
  recipe.g = (scree_range){0.05, 16};
  recipe.erosion = 0.1;
  scree_threads* pool = pool_of(2);
  const scree_bake_desc desc = {.recipe = &recipe, .jobs = scree_threads_jobs(pool)};
  uint8_t* bytes;
  size_t size;
  assert_int_equal(scree_bake_rocks(&desc, &bytes, &size, NULL, NULL), SCREE_OK);
  scree_threads_destroy(pool);
  scree_pack* pack;
  assert_int_equal(scree_pack_open_memory(bytes, size, NULL, &pack), SCREE_OK);
  assert_int_equal(scree_pack_verify(pack), SCREE_OK);
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  assert_true(info.max_rocks_per_cell <= 5);
  uint32_t gaps = 0;
  for (uint32_t cell = 0; cell < info.cell_count; ++cell) {
    uint32_t first, count;
    assert_int_equal(scree_pack_cell_assets(pack, cell, &first, &count), SCREE_OK);
    for (uint32_t k = 0, next = 0; k < count; ++k) {
      scree_asset asset;
      assert_int_equal(scree_pack_get_asset(pack, first + k, &asset), SCREE_OK);
      assert_true(asset.seed >= next && asset.seed < info.max_rocks_per_cell);
      gaps += asset.seed > next;
      next = asset.seed + 1;
    }
  }
  print_message("%u rocks, %u gaps\n", info.asset_count, gaps);
  assert_true(gaps > 100);
  scree_pack_close(pack);
  scree_bake_free(&desc, bytes, size);
}

static void a_recipe_out_of_range_is_refused_by_name(void** state) {
  (void)state;
  scree_recipe recipe = small_recipe();
  recipe.jitter = 1.5;
  const scree_bake_desc desc = {.recipe = &recipe};
  uint8_t* bytes;
  size_t size;
  scree_error error;
  assert_int_equal(scree_bake_rocks(&desc, &bytes, &size, NULL, &error), SCREE_ERROR_RANGE);
  assert_null(bytes);
  assert_non_null(strstr(error.message, "jitter"));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(threads_make_no_difference_to_a_byte),
      cmocka_unit_test(plain_and_wide_kernels_give_the_same_bits),
      cmocka_unit_test(progress_never_falls_and_is_told_by_one_at_a_time),
      cmocka_unit_test(a_cancelled_bake_leaves_nothing_behind),
      cmocka_unit_test(memory_that_runs_short_anywhere_is_reported_and_given_back),
      cmocka_unit_test(seeds_whose_rocks_are_empty_leave_gaps_in_the_numbers),
      cmocka_unit_test(a_recipe_out_of_range_is_refused_by_name),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
