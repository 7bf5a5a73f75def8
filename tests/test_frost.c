/* Freeze and thaw against its twin, which is section 5 of the paper written down, and against its formulas. */
#include <scree/frost.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "frost_twin.h"
#include "make_shards.h"
#include "random_frost.h"
#include "rounds.h"

/* --- the twin ---------------------------------------------------------------------------------------------------------------- */

static void compare_blocks(const scree_frost* f, const frost_twin* twin) {
  const scree_block* blocks;
  const uint32_t* list;
  assert_int_equal(scree_frost_blocks(f, &blocks, &list), twin->block_count);
  uint32_t fallen = 0, all = 0;
  for (uint32_t s = 0; s < f->view.shard_count; ++s) all += twin->blocks[s] != 0;
  for (uint32_t b = 0; b < twin->block_count; ++b) {
    assert_int_equal(blocks[b].first_shard, fallen);
    for (uint32_t i = 0; i < blocks[b].shard_count; ++i, ++fallen) {
      assert_int_equal(twin->blocks[list[fallen]], b + 1);
      if (i > 0) assert_true(list[fallen - 1] < list[fallen]);
    }
  }
  assert_int_equal(fallen, all);
}

static void compare(const scree_frost* f, const frost_twin* twin) {
  scree_frost_view v;
  scree_frost_stats stats;
  scree_frost_get(f, &v);
  scree_frost_get_stats(f, &stats);
  assert_memory_equal(v.states, twin->states, v.shard_count);
  assert_memory_equal(v.exterior, twin->exterior, v.link_count);
  assert_memory_equal(v.lives, twin->lives, v.link_count * sizeof *v.lives);
  assert_int_equal(stats.paths, twin->paths);
  assert_int_equal(stats.links_visited, twin->visited);
  assert_int_equal(stats.breaks, twin->breaks);
  assert_int_equal(stats.forced, twin->forced);
  assert_int_equal(stats.detachments, twin->detachments);
  assert_true(stats.poured == twin->poured && stats.absorbed == twin->absorbed && stats.drained == twin->drained);
  compare_blocks(f, twin);
}

/* Paths until nothing takes water or there were `most`, compared every `every` paths. */
static void run_both(scree_frost* f, frost_twin* twin, uint32_t most, uint32_t every, bool walk) {
  bool wet = true;
  for (uint32_t i = 0; i < most && wet; i += every) {
    for (uint32_t k = 0; k < every && wet; ++k) wet = frost_twin_path(twin, walk);
    assert_int_equal(scree_frost_step(f, every), SCREE_OK);
    compare(f, twin);
    scree_frost_stats stats;
    scree_frost_get_stats(f, &stats);
    assert_int_equal(stats.dry, !wet);
  }
}

static void states_are_the_twins_on_random_lattices_and_rules(void** state) {
  (void)state;
  uint64_t falls = 0, breaks = 0, kept = 0;
  for (uint64_t round = 0; round < ROUNDS(200, 10); ++round) {
    random_stream stream = {round};
    uint32_t size[3];
    for (int a = 0; a < 3; ++a) size[a] = 1 + (uint32_t)(random_unit(&stream) * 6);
    scree_shards* shards = make_lattice(size, round % 3 == 0 ? 0 : round, NULL);
    scree_frost_rules rules;
    uint8_t states[216];
    random_frost_rules(&stream, &rules);
    random_frost_states(&stream, shards->view.shard_count, states);
    scree_frost* f = must_freeze(shards, &rules, states, round);
    frost_twin* twin = frost_twin_create(f);
    run_both(f, twin, 600, 1 + (uint32_t)(random_unit(&stream) * 10), false);
    falls += f->stats.detachments;
    breaks += f->stats.breaks;
    kept += f->stats.blocks;
    frost_twin_destroy(twin);
    scree_frost_destroy(f);
    free_lattice(shards);
  }
  assert_true(breaks > ROUNDS(5000, 10) && falls > ROUNDS(1000, 10) && kept > ROUNDS(1000, 10));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(states_are_the_twins_on_random_lattices_and_rules),
  };
  return cmocka_run_group_tests_name("frost", tests, NULL, NULL);
}
