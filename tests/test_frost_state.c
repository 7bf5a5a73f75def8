/* Freeze and thaw: edits, snapshots and ends. */
#include <scree/frost.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "failing_allocator.h"
#include "frost_twin.h"
#include "make_shards.h"
#include "random_frost.h"
#include "rounds.h"

static scree_frost_stats stats_of(const scree_frost* f) {
  scree_frost_stats stats;
  scree_frost_get_stats(f, &stats);
  return stats;
}

/* --- edits ------------------------------------------------------------------------------------------------------------------- */

/* The link between two shards. */
static uint32_t link_between(const scree_shards_view* v, uint32_t a, uint32_t b) {
  for (uint32_t l = 0; l < v->interior_link_count; ++l)
    if (v->links[l].shards[0] == a && v->links[l].shards[1] == b) return l;
  fail_msg("%u and %u have no link", a, b);
  return 0;
}

static void of_two_parts_the_smaller_falls_unless_it_has_core(void** state) {
  (void)state;
  const uint32_t size[3] = {5, 1, 1};
  scree_shards* shards = make_lattice(size, 0, NULL);
  scree_frost_rules rules;
  scree_frost_rules_default(&rules);
  static const struct {
    uint8_t states[5];
    uint32_t cut; /* between this shard and the next */
    uint8_t after[5];
  } cases[] = {
      {{0, 0, 0, 0, 0}, 1, {1, 1, 0, 0, 0}}, {{0, 0, 0, 0, 0}, 2, {0, 0, 0, 1, 1}}, {{2, 0, 0, 0, 0}, 1, {2, 0, 1, 1, 1}},
      {{2, 0, 0, 0, 2}, 2, {2, 0, 0, 0, 2}}, {{1, 0, 0, 2, 0}, 2, {1, 1, 1, 2, 0}}, {{1, 0, 0, 0, 0}, 2, {1, 0, 0, 1, 1}},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    scree_frost* f = must_freeze(shards, &rules, cases[i].states, 1);
    assert_int_equal(scree_frost_set_life(f, link_between(&shards->view, cases[i].cut, cases[i].cut + 1), 0), SCREE_OK);
    assert_memory_equal(f->states, cases[i].after, 5);
    scree_frost_destroy(f);
  }
  scree_shards_destroy(shards);
}

static void with_stability_what_rests_stays(void** state) {
  (void)state;
  const uint32_t size[3] = {1, 5, 1};
  scree_shards* shards = make_lattice(size, 0, NULL);
  static const struct {
    uint8_t states[5]; /* from below */
    uint32_t cut;
    double strength;
    double gravity; /* along y */
    uint8_t after[5];
  } cases[] = {
      {{0, 0, 0, 0, 0}, 0, 0, -1, {1, 0, 0, 0, 0}},   /* the paper's: the smaller part falls */
      {{0, 0, 0, 0, 0}, 0, 1e9, -1, {0, 1, 1, 1, 1}}, /* the lowest carries */
      {{0, 0, 0, 0, 0}, 0, 1e9, 1, {1, 0, 0, 0, 0}},  /* gravity upwards: the other end is the lowest */
      {{0, 0, 0, 2, 0}, 0, 1e9, -1, {1, 0, 0, 2, 0}}, /* with core, core alone carries */
      {{1, 0, 0, 0, 0}, 1, 1e9, -1, {1, 1, 0, 0, 0}}, /* nothing rests */
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    scree_frost_rules rules;
    scree_frost_rules_default(&rules);
    rules.gravity[1] = cases[i].gravity;
    scree_frost* f = must_freeze(shards, &rules, cases[i].states, 1);
    rules.strength = cases[i].strength; /* from now on */
    assert_int_equal(scree_frost_set_rules(f, &rules, NULL), SCREE_OK);
    assert_int_equal(scree_frost_set_life(f, link_between(&shards->view, cases[i].cut, cases[i].cut + 1), 0), SCREE_OK);
    assert_memory_equal(f->states, cases[i].after, 5);
    scree_frost_destroy(f);
  }
  /* The last core shard is taken: what rests carries from then on, and of the two parts that it leaves the upper one falls. */
  scree_frost_rules rules;
  scree_frost_rules_default(&rules);
  rules.strength = 1e9;
  const uint8_t states[5] = {0, 2, 0, 0, 0}, after[5] = {0, 1, 1, 1, 1};
  scree_frost* f = must_freeze(shards, &rules, states, 1);
  assert_int_equal(scree_frost_set_shard(f, 1, SCREE_SHARD_AIR), SCREE_OK);
  assert_memory_equal(f->states, after, 5);
  assert_int_equal(stats_of(f).solid, 1);
  assert_int_equal(stats_of(f).core, 0);
  assert_int_equal(stats_of(f).air, 4);
  scree_frost_destroy(f);
  scree_shards_destroy(shards);
}

static void what_an_edit_leaves_hanging_falls(void** state) {
  (void)state;
  const uint32_t size[3] = {5, 3, 1}; /* a cross beam on a post: shards x + 5 y */
  scree_shards* shards = make_lattice(size, 0, NULL);
  scree_frost_rules rules;
  scree_frost_rules_default(&rules);
  uint8_t states[15] = {1, 1, 2, 1, 1, /* y = 0 */ 1, 1, 0, 1, 1, /* y = 1 */ 0, 0, 0, 0, 0};
  scree_frost* f = must_freeze(shards, &rules, states, 1);
  assert_int_equal(scree_frost_set_shard(f, 7, SCREE_SHARD_AIR), SCREE_OK);
  assert_int_equal(stats_of(f).air, 14);
  assert_int_equal(stats_of(f).core, 1);
  assert_int_equal(stats_of(f).blocks, 5); /* the one taken away did not fall */
  assert_int_equal(stats_of(f).detachments, 1);
  scree_frost_destroy(f);

  states[2] = SCREE_SHARD_SOLID; /* without core the larger part stays */
  f = must_freeze(shards, &rules, states, 1);
  assert_int_equal(scree_frost_set_shard(f, 11, SCREE_SHARD_AIR), SCREE_OK);
  assert_int_equal(f->states[10], SCREE_SHARD_AIR);
  assert_int_equal(stats_of(f).solid, 5);
  /* And back: out of the block, with new links, and it can fall again. */
  assert_int_equal(stats_of(f).blocks, 1);
  assert_int_equal(scree_frost_set_shard(f, 11, SCREE_SHARD_SOLID), SCREE_OK);
  assert_int_equal(scree_frost_set_shard(f, 10, SCREE_SHARD_SOLID), SCREE_OK);
  assert_int_equal(stats_of(f).blocks, 0);
  assert_int_equal(stats_of(f).solid, 7);
  assert_true(fabs(stats_of(f).volume - 7) < 1e-12);
  assert_true(f->lives[link_between(&shards->view, 10, 11)] == 1);
  assert_int_equal(scree_frost_set_life(f, link_between(&shards->view, 11, 12), 0), SCREE_OK);
  assert_int_equal(stats_of(f).solid, 5);
  assert_int_equal(stats_of(f).blocks, 2);

  assert_int_equal(scree_frost_set_shard(f, 15, SCREE_SHARD_AIR), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_frost_set_shard(f, 0, (scree_shard_state)3), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_frost_set_life(f, shards->view.interior_link_count, 0.5), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_frost_set_life(f, 0, 1.5), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_frost_set_life(f, 0, NAN), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_frost_set_life(f, link_between(&shards->view, 10, 11), 0.5), SCREE_ERROR_INVALID_ARGUMENT);
  scree_frost_destroy(f);
  scree_shards_destroy(shards);
}

static void what_nothing_holds_falls_at_once(void** state) {
  (void)state;
  static const struct {
    uint32_t across, high; /* shards of a wall: x + across * y */
    uint8_t given[12];
    double strength;
    uint8_t created[12];
    uint32_t edited;
    scree_shard_state to;
    uint8_t after[12];
  } cases[] = {
      /* created: without core the largest stays, of equal ones that with the lowest shard, and what rests on the lowest place */
      {1, 5, {1, 0, 1, 0, 0}, 0, {1, 1, 1, 0, 0}, 3, SCREE_SHARD_SOLID, {1, 1, 1, 0, 0}},
      {1, 6, {1, 0, 0, 1, 0, 0}, 0, {1, 0, 0, 1, 1, 1}, 1, SCREE_SHARD_SOLID, {1, 0, 0, 1, 1, 1}},
      {1, 5, {0, 1, 0, 0, 0}, 0, {0, 1, 0, 0, 0}, 2, SCREE_SHARD_SOLID, {0, 1, 0, 0, 0}},
      {5, 1, {0, 0, 1, 0, 0}, 0, {0, 0, 1, 0, 0}, 1, SCREE_SHARD_SOLID, {0, 0, 1, 0, 0}}, /* two bodies on the ground */
      {5, 1, {0, 0, 1, 0, 0}, 1e9, {0, 0, 1, 0, 0}, 1, SCREE_SHARD_SOLID, {0, 0, 1, 0, 0}},
      {1, 5, {0, 1, 0, 0, 0}, 1e9, {0, 1, 1, 1, 1}, 2, SCREE_SHARD_SOLID, {0, 1, 1, 1, 1}}, /* what rests carries */
      {5, 1, {2, 0, 1, 0, 0}, 0, {2, 0, 1, 1, 1}, 2, SCREE_SHARD_SOLID, {2, 0, 0, 1, 1}},   /* core alone holds */
      /* edits */
      {5, 1, {2, 0, 1, 0, 2}, 0, {2, 0, 1, 0, 2}, 4, SCREE_SHARD_SOLID, {2, 0, 1, 1, 1}}, /* the last path to core is lost */
      {5, 1, {2, 0, 1, 0, 2}, 1e9, {2, 0, 1, 0, 2}, 0, SCREE_SHARD_SOLID, {1, 1, 1, 0, 2}},
      {5, 1, {0, 0, 1, 0, 0}, 0, {0, 0, 1, 0, 0}, 4, SCREE_SHARD_CORE, {1, 1, 1, 0, 2}},  /* the first core */
      {1, 5, {2, 1, 1, 1, 1}, 0, {2, 1, 1, 1, 1}, 2, SCREE_SHARD_SOLID, {2, 1, 1, 1, 1}}, /* built in the air */
      {1, 5, {2, 1, 1, 1, 1}, 0, {2, 1, 1, 1, 1}, 2, SCREE_SHARD_CORE, {2, 1, 2, 1, 1}},
      /* the largest becomes another */
      {3,
       4,
       {0, 0, 0, 1, 1, 1, 1, 0, 1, 0, 0, 0},
       0,
       {0, 0, 0, 1, 1, 1, 1, 0, 1, 0, 0, 0},
       7,
       SCREE_SHARD_AIR,
       {0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1}},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    const uint32_t size[3] = {cases[i].across, cases[i].high, 1}, count = size[0] * size[1];
    scree_shards* shards = make_lattice(size, 0, NULL);
    scree_frost_rules rules;
    scree_frost_rules_default(&rules);
    rules.strength = cases[i].strength;
    rules.fall_life = 0;
    scree_frost* f = must_freeze(shards, &rules, cases[i].given, 1);
    if (memcmp(f->states, cases[i].created, count) != 0) fail_msg("case %zu as created", i);
    const scree_block* blocks;
    const uint32_t* list;
    for (uint32_t b = 0; b < scree_frost_blocks(f, &blocks, &list); ++b) assert_int_equal(blocks[b].path, 0);
    assert_true(stats_of(f).start_volume > 0 && stats_of(f).paths == 0);
    assert_int_equal(scree_frost_set_shard(f, cases[i].edited, cases[i].to), SCREE_OK);
    if (memcmp(f->states, cases[i].after, count) != 0) fail_msg("case %zu as edited", i);
    scree_frost_destroy(f);
    scree_shards_destroy(shards);
  }
}

static void a_pocket_is_exterior_when_it_is_opened(void** state) {
  (void)state;
  const uint32_t size[3] = {5, 5, 5};
  scree_shards* shards = make_lattice(size, 0, NULL);
  scree_frost_rules rules;
  scree_frost_rules_default(&rules);
  scree_frost* f = must_freeze(shards, &rules, NULL, 1);
  const uint32_t outside = stats_of(f).exterior_links, middle = 2 + 5 * (2 + 5 * 2);
  assert_int_equal(outside, 150);
  assert_int_equal(scree_frost_set_shard(f, middle, SCREE_SHARD_AIR), SCREE_OK);
  assert_int_equal(stats_of(f).exterior_links, outside);
  assert_int_equal(scree_frost_set_shard(f, middle + 5, SCREE_SHARD_AIR), SCREE_OK);
  assert_int_equal(stats_of(f).exterior_links, outside);
  assert_int_equal(scree_frost_set_shard(f, middle + 10, SCREE_SHARD_AIR), SCREE_OK); /* a shaft from the top, three deep */
  assert_int_equal(stats_of(f).exterior_links, outside - 1 + 3 * 4 + 1);
  assert_int_equal(scree_frost_set_shard(f, middle + 10, SCREE_SHARD_SOLID), SCREE_OK);
  assert_int_equal(stats_of(f).exterior_links, outside);
  scree_frost_destroy(f);
  scree_shards_destroy(shards);
}

/* What is kept up to date by and by is what it would be made anew. */
static void check_derived(scree_frost* f) {
  const scree_shards_view* v = &f->view;
  const size_t links = v->link_count, rains = f->rules.rain_count, words = rains * (2 * links + 1);
  uint8_t* bytes = malloc(v->shard_count + links);
  double* passage = malloc(links * sizeof *passage);
  uint64_t* weights = malloc((words + SCREE_FROST_RAINS) * sizeof *weights);
  assert_true(bytes != NULL && passage != NULL && weights != NULL);
  memcpy(bytes, f->open, v->shard_count);
  memcpy(bytes + v->shard_count, f->exterior, links);
  memcpy(passage, f->passage, links * sizeof *passage);
  memcpy(weights, f->tables.weights, rains * links * sizeof *weights);
  memcpy(weights + rains * links, f->tables.trees, rains * (links + 1) * sizeof *weights);
  memcpy(weights + words, f->tables.totals, sizeof f->tables.totals);
  frost_derive(f);
  assert_memory_equal(bytes, f->open, v->shard_count);
  assert_memory_equal(bytes + v->shard_count, f->exterior, links);
  assert_memory_equal(passage, f->passage, links * sizeof *passage);
  if (rains > 0) {
    assert_memory_equal(weights, f->tables.weights, rains * links * sizeof *weights);
    assert_memory_equal(weights + rains * links, f->tables.trees, rains * (links + 1) * sizeof *weights);
    assert_memory_equal(weights + words, f->tables.totals, rains * sizeof *weights);
  }
  free(bytes);
  free(passage);
  free(weights);
}

static void compare_with_twin(const scree_frost* f, const frost_twin* twin) {
  const scree_shards_view* v = &f->view;
  assert_memory_equal(f->states, twin->states, v->shard_count);
  assert_memory_equal(f->exterior, twin->exterior, v->link_count);
  assert_memory_equal(f->lives, twin->lives, v->link_count * sizeof *f->lives);
  assert_int_equal(f->stats.paths, twin->paths);
  assert_int_equal(f->stats.detachments, twin->detachments);
  const scree_block* blocks;
  const uint32_t* list;
  assert_int_equal(scree_frost_blocks(f, &blocks, &list), twin->block_count);
  for (uint32_t b = 0; b < twin->block_count; ++b)
    for (uint32_t i = 0; i < blocks[b].shard_count; ++i) assert_int_equal(twin->blocks[list[blocks[b].first_shard + i]], b + 1);
}

/* Shards that stand where the promise says that they cannot. */
static uint32_t floating(const scree_frost* f) {
  frost_twin* twin = frost_twin_create(f);
  const uint32_t count = frost_twin_floating(twin);
  frost_twin_destroy(twin);
  return count;
}

/* Random states, edits, rules and steps: nothing solid without a path to what holds it, after each. */
static void nothing_stands_without_a_path_to_what_holds_it(void** state) {
  (void)state;
  uint32_t fell_at_once = 0, fell_in_edits = 0, bodies = 0, overloaded = 0;
  for (uint64_t round = 0; round < ROUNDS(300, 10); ++round) {
    random_stream stream = {7000 + round};
    uint32_t size[3];
    for (int a = 0; a < 3; ++a) size[a] = 1 + (uint32_t)(random_unit(&stream) * 5);
    scree_shards* shards = make_lattice(size, round, NULL);
    const scree_shards_view* v = &shards->view;
    scree_frost_rules rules;
    random_frost_rules(&stream, &rules);
    if (round % 3 != 0) rules.strength = round % 3 == 1 ? 1e12 : 1e4;
    uint8_t states[125];
    const double air = 0.5 * random_unit(&stream), core = round % 4 == 0 ? 0.1 : 0;
    for (uint32_t s = 0; s < v->shard_count; ++s)
      states[s] = random_unit(&stream) < air ? SCREE_SHARD_AIR : random_unit(&stream) < core ? SCREE_SHARD_CORE : SCREE_SHARD_SOLID;
    scree_frost* f = must_freeze(shards, &rules, states, round);
    fell_at_once += stats_of(f).detachments > 0;
    assert_int_equal(floating(f), 0);
    for (int i = 0; i < 20; ++i) {
      const uint64_t falls = stats_of(f).detachments;
      const uint32_t shard = (uint32_t)(random_unit(&stream) * v->shard_count);
      const scree_shard_state to = (scree_shard_state)(random_bits(&stream) % (round % 4 == 0 ? 3 : 2)); /* core in some */
      assert_int_equal(scree_frost_set_shard(f, shard, to), SCREE_OK);
      fell_in_edits += stats_of(f).detachments > falls;
      assert_int_equal(floating(f), 0);
      check_derived(f);
      if (v->interior_link_count > 0) {
        const uint32_t link = (uint32_t)(random_unit(&stream) * v->interior_link_count);
        (void)scree_frost_set_life(f, link, random_bits(&stream) % 2 == 0 ? 0 : 1); /* in air: refused */
        assert_int_equal(floating(f), 0);
      }
      assert_int_equal(scree_frost_step(f, 1), SCREE_OK);
      assert_int_equal(floating(f), 0);
      bodies += f->apart;
      if (i % 5 == 4) {
        scree_frost_snapshot* snapshot;
        assert_int_equal(scree_frost_save(f, &snapshot), SCREE_OK);
        const uint64_t digest = scree_frost_digest(f);
        assert_int_equal(scree_frost_step(f, 40), SCREE_OK);
        const uint64_t later = scree_frost_digest(f);
        assert_int_equal(floating(f), 0);
        scree_frost_restore(f, snapshot);
        assert_true(scree_frost_digest(f) == digest);
        assert_int_equal(scree_frost_step(f, 40), SCREE_OK);
        assert_true(scree_frost_digest(f) == later);
        scree_frost_forget(f, snapshot);
      }
    }
    overloaded += stats_of(f).overloaded > 0;
    scree_frost_destroy(f);
    scree_shards_destroy(shards);
  }
  assert_true(fell_at_once > ROUNDS(30, 10) && fell_in_edits > ROUNDS(100, 10));
  assert_true(fell_at_once > ROUNDS(20, 10) && fell_in_edits > ROUNDS(200, 10));
  assert_true(bodies > ROUNDS(30, 10) && overloaded > ROUNDS(20, 10)); /* `apart`, broken by weight */
}

static void steps_after_edits_are_the_twins(void** state) {
  (void)state;
  for (uint64_t round = 0; round < ROUNDS(60, 10); ++round) {
    random_stream stream = {500 + round};
    const uint32_t size[3] = {4, 4, 2 + (uint32_t)(round % 3)};
    scree_shards* shards = make_lattice(size, round, NULL);
    const scree_shards_view* v = &shards->view;
    scree_frost_rules rules;
    random_frost_rules(&stream, &rules);
    uint8_t states[512];
    random_frost_states(&stream, v->shard_count, states);
    if (round % 3 == 1) rules.strength = 1e12; /* by which nothing breaks, but what rests does not fall */
    scree_frost* f = must_freeze(shards, &rules, states, round);
    frost_twin* twin = frost_twin_start(f, states);
    compare_with_twin(f, twin);
    for (int i = 0; i < 30; ++i) {
      const uint32_t shard = (uint32_t)(random_unit(&stream) * v->shard_count);
      const uint32_t link = (uint32_t)(random_unit(&stream) * v->interior_link_count);
      const uint32_t* sides = v->links[link].shards;
      if (i % 3 == 0) {
        const scree_shard_state to = (scree_shard_state)(random_bits(&stream) % 3);
        assert_int_equal(scree_frost_set_shard(f, shard, to), SCREE_OK);
        frost_twin_set_shard(twin, shard, to);
      }
      if (i % 3 == 1 && frost_stands(f, sides[0]) && frost_stands(f, sides[1])) { /* broken ones are mended */
        const double life = random_bits(&stream) % 3 == 0 ? 0 : random_unit(&stream);
        assert_int_equal(scree_frost_set_life(f, link, life), SCREE_OK);
        frost_twin_set_life(twin, link, life);
      }
      if (i % 3 == 2) {
        random_frost_rules(&stream, &rules);
        rules.strength = random_bits(&stream) % 2 == 0 ? 0 : 1e12;
        assert_int_equal(scree_frost_set_rules(f, &rules, NULL), SCREE_OK);
        assert_int_equal(scree_frost_step(f, 0), SCREE_OK); /* what these do not hold falls */
        frost_twin_settle(twin);
      }
      compare_with_twin(f, twin);
      for (uint32_t l = 0; l < v->interior_link_count; ++l)
        if (f->lives[l] > 0) assert_true(frost_stands(f, v->links[l].shards[0]) && frost_stands(f, v->links[l].shards[1]));
      check_derived(f);
      for (int k = 0; k < 20; ++k)
        if (!frost_twin_path(twin, false)) break;
      assert_int_equal(scree_frost_step(f, 20), SCREE_OK);
      compare_with_twin(f, twin);
      check_derived(f);
      const scree_block* blocks;
      const uint32_t* list;
      uint32_t fallen = 0, seen[512] = {0};
      const uint32_t count = scree_frost_blocks(f, &blocks, &list);
      for (uint32_t b = 0; b < count; ++b) {
        assert_int_equal(blocks[b].first_shard, fallen);
        assert_true(blocks[b].shard_count > 0);
        for (uint32_t m = 0; m < blocks[b].shard_count; ++m, ++fallen) {
          assert_int_equal(seen[list[fallen]]++, 0);
          assert_int_equal(f->states[list[fallen]], SCREE_SHARD_AIR);
        }
      }
      assert_int_equal(f->block_shard_count, fallen);
    }
    frost_twin_destroy(twin);
    scree_frost_destroy(f);
    scree_shards_destroy(shards);
  }
}

/* --- blocks ------------------------------------------------------------------------------------------------------------------ */

static void a_group_falls_in_blocks_by_the_life_of_its_links(void** state) {
  (void)state;
  const uint32_t size[3] = {8, 1, 1};
  scree_shards* shards = make_lattice(size, 0, NULL);
  scree_frost_rules rules;
  scree_frost_rules_default(&rules);
  for (int round = 0; round < 3; ++round) {
    rules.fall_life = round == 0 ? 0 : round == 1 ? 0.5 : 1;
    const uint8_t states[8] = {2, 0, 0, 0, 0, 0, 0, 0};
    scree_frost* f = must_freeze(shards, &rules, states, 1);
    assert_int_equal(scree_frost_set_life(f, 3, 0.5), SCREE_OK);
    assert_int_equal(scree_frost_set_life(f, 5, 0.6), SCREE_OK);
    assert_int_equal(scree_frost_set_life(f, 0, 0), SCREE_OK);
    const scree_block* blocks;
    const uint32_t* list;
    const uint32_t count = scree_frost_blocks(f, &blocks, &list), expected[3] = {1, 2, 7};
    assert_int_equal(count, expected[round]);
    for (uint32_t i = 0; i < 7; ++i) assert_int_equal(list[i], i + 1);
    if (round == 1) assert_int_equal(blocks[0].shard_count, 3);
    if (round == 0) assert_true(fabs(blocks[0].volume - 7) < 1e-12);
    if (round == 0) assert_true(fabs(blocks[0].centroid[0] - 0.5) < 1e-12 && fabs(blocks[0].centroid[1] - 0.5) < 1e-12);
    assert_true(blocks[0].push[0] == 1 && blocks[0].push[1] == 0); /* away from the core */
    if (count > 1) assert_true(blocks[1].push[0] == 0);            /* no rock beside it stayed */
    scree_frost_destroy(f);
  }
  scree_shards_destroy(shards);
}

/* --- snapshots --------------------------------------------------------------------------------------------------------------- */

static void snapshots_come_back_exactly(void** state) {
  (void)state;
  for (uint64_t round = 0; round < ROUNDS(20, 4); ++round) {
    random_stream stream = {900 + round};
    const uint32_t size[3] = {4, 3, 4};
    scree_shards* shards = make_lattice(size, round, NULL);
    failing_allocator memory = {.fail_at = -1};
    scree_frost_desc desc = {.shards = shards, .random_seed = round, .allocator = failing_allocator_of(&memory)};
    random_frost_rules(&stream, &desc.rules);
    desc.rules.fall = SCREE_FALL_KEPT;
    scree_frost* f;
    assert_int_equal(scree_frost_create(&desc, &f, NULL), SCREE_OK);
    const long long held = memory.live;
    assert_int_equal(held, (long long)stats_of(f).memory);
    assert_int_equal(scree_frost_step(f, 100 * round), SCREE_OK);
    scree_frost_snapshot* snapshot;
    assert_int_equal(scree_frost_save(f, &snapshot), SCREE_OK);
    const uint64_t digest = scree_frost_digest(f);
    const scree_frost_stats before = stats_of(f);
    uint32_t path[2][64];
    const uint32_t length = scree_frost_last_path(f, path[0], NULL, 64);

    assert_int_equal(scree_frost_step(f, 300), SCREE_OK);
    const uint64_t later = scree_frost_digest(f);
    const scree_frost_stats after = stats_of(f);
    assert_int_equal(scree_frost_set_shard(f, 7, frost_stands(f, 7) ? SCREE_SHARD_AIR : SCREE_SHARD_CORE), SCREE_OK);
    scree_frost_rules other;
    random_frost_rules(&stream, &other);
    assert_int_equal(scree_frost_set_rules(f, &other, NULL), SCREE_OK);
    assert_int_equal(scree_frost_step(f, 50), SCREE_OK);

    assert_int_equal(scree_frost_set_rules(f, &desc.rules, NULL), SCREE_OK);
    scree_frost_restore(f, snapshot);
    assert_true(scree_frost_digest(f) == digest);
    scree_frost_stats now = stats_of(f);
    assert_memory_equal(&now, &before, sizeof now);
    assert_int_equal(scree_frost_last_path(f, path[1], NULL, 64), length);
    assert_memory_equal(path[0], path[1], (length < 64 ? length : 64) * sizeof *path[0]);
    assert_int_equal(scree_frost_step(f, 300), SCREE_OK);
    assert_true(scree_frost_digest(f) == later);
    now = stats_of(f);
    assert_memory_equal(&now, &after, sizeof now);
    scree_frost_forget(f, snapshot);
    scree_frost_forget(f, NULL);
    assert_int_equal(memory.live, held);
    scree_frost_destroy(f);
    assert_int_equal(memory.live, 0);
    scree_shards_destroy(shards);
  }
}

/* --- ends -------------------------------------------------------------------------------------------------------------------- */

static void nothing_falls_where_all_is_core(void** state) {
  (void)state;
  const uint32_t size[3] = {3, 3, 3};
  scree_shards* shards = make_lattice(size, 2, NULL);
  scree_frost_rules rules;
  scree_frost_rules_default(&rules);
  uint8_t states[27];
  memset(states, SCREE_SHARD_CORE, sizeof states);
  scree_frost* f = must_freeze(shards, &rules, states, 1);
  assert_int_equal(scree_frost_step(f, 20000), SCREE_OK);
  const scree_frost_stats stats = stats_of(f);
  assert_int_equal(stats.core, 27);
  assert_int_equal(stats.paths, 20000);
  assert_int_equal(stats.detachments, 0);
  assert_true(stats.breaks > 20 && stats.breaks <= shards->view.interior_link_count);
  assert_false(stats.dry);
  scree_frost_destroy(f);
  scree_shards_destroy(shards);
}

static void paths_end_where_nothing_takes_water(void** state) {
  (void)state;
  const uint32_t size[3] = {3, 2, 3};
  scree_shards* shards = make_lattice(size, 2, NULL);
  scree_frost_rules rules;
  scree_frost_rules_default(&rules);
  uint8_t states[18];
  memset(states, SCREE_SHARD_AIR, sizeof states);
  scree_frost* f = must_freeze(shards, &rules, states, 1); /* nothing stands */
  assert_int_equal(scree_frost_step(f, 10), SCREE_OK);
  assert_true(stats_of(f).dry && stats_of(f).paths == 0);
  assert_int_equal(scree_frost_set_shard(f, 4, SCREE_SHARD_SOLID), SCREE_OK);
  assert_int_equal(scree_frost_step(f, 10), SCREE_OK);
  assert_true(!stats_of(f).dry && stats_of(f).paths == 10);
  rules.rain_count = 0; /* no rain */
  assert_int_equal(scree_frost_set_rules(f, &rules, NULL), SCREE_OK);
  assert_int_equal(scree_frost_step(f, 10), SCREE_OK);
  assert_true(stats_of(f).dry && stats_of(f).paths == 10);
  assert_int_equal(scree_frost_run(f, 0, 10, NULL, NULL), SCREE_OK);
  assert_int_equal(stats_of(f).paths, 10);
  scree_frost_destroy(f);
  scree_shards_destroy(shards);
}

static void rain_from_below_drains_where_it_lands(void** state) {
  (void)state;
  const uint32_t size[3] = {3, 2, 3};
  scree_shards* shards = make_lattice(size, 2, NULL);
  scree_frost_rules rules;
  scree_frost_rules_default(&rules);
  rules.rains[0] = (scree_rain){{0, 1, 0}, 0, 1};
  rules.total_absorption = false;
  scree_frost* f = must_freeze(shards, &rules, NULL, 1);
  assert_int_equal(scree_frost_step(f, 1000), SCREE_OK);
  const scree_frost_stats stats = stats_of(f);
  assert_int_equal(stats.paths, 1000);
  assert_int_equal(stats.links_visited, 1000);
  assert_int_equal(stats.breaks, 0);
  assert_true(stats.drained > 0.5 * stats.poured);
  scree_frost_destroy(f);
  scree_shards_destroy(shards);
}

typedef struct watcher {
  uint32_t calls, stop_after;
  double last;
} watcher;

static bool watch(void* user, double done) {
  watcher* w = user;
  assert_true(done >= w->last && done <= 1);
  w->last = done;
  return ++w->calls != w->stop_after;
}

static void runs_stop_at_a_share_of_the_volume(void** state) {
  (void)state;
  const uint32_t size[3] = {5, 5, 5};
  scree_shards* shards = make_lattice(size, 2, NULL);
  scree_frost_rules rules;
  scree_frost_rules_default(&rules);
  scree_frost* f = must_freeze(shards, &rules, NULL, 1);
  watcher w = {0};
  assert_int_equal(scree_frost_run(f, 0.5, UINT64_MAX, watch, &w), SCREE_OK);
  assert_true(w.last == 1);
  const scree_frost_stats stats = stats_of(f);
  assert_true(stats.volume <= 0.5 * stats.start_volume && stats.volume > 0.2 * stats.start_volume);
  assert_int_equal(scree_frost_run(f, 0.5, 100, NULL, NULL), SCREE_OK); /* it is there already */
  assert_int_equal(stats_of(f).paths, stats.paths);
  assert_int_equal(scree_frost_run(f, 0, 100, NULL, NULL), SCREE_OK);
  assert_int_equal(stats_of(f).paths, stats.paths + 100);
  w = (watcher){.stop_after = 2};
  assert_int_equal(scree_frost_run(f, 0, 1000000, watch, &w), SCREE_ERROR_CANCELLED);
  assert_int_equal(w.calls, 2);
  assert_int_equal(scree_frost_run(f, 1.5, 100, NULL, NULL), SCREE_ERROR_RANGE);
  assert_int_equal(scree_frost_run(f, NAN, 100, NULL, NULL), SCREE_ERROR_RANGE);
  scree_frost_destroy(f);
  scree_shards_destroy(shards);
}

static void what_is_too_weak_to_stand_breaks_in_steps(void** state) {
  (void)state;
  const uint32_t size[3] = {6, 6, 6};
  scree_shards* shards = make_lattice(size, 2, NULL);
  scree_frost_rules rules;
  scree_frost_rules_default(&rules);
  rules.strength = 2e5;
  rules.damage = 1;
  uint8_t states[216] = {0};
  for (uint32_t s = 0; s < 216; ++s) states[s] = s / 6 % 6 == 0 ? SCREE_SHARD_CORE : SCREE_SHARD_SOLID;
  scree_frost* f = must_freeze(shards, &rules, states, 1);
  for (int i = 0; i < 40; ++i) {
    assert_int_equal(scree_frost_step(f, 50), SCREE_OK);
    assert_int_equal(scree_frost_check_stability(f), 0);
  }
  assert_true(stats_of(f).overloaded > 0);
  assert_true(stats_of(f).breaks > stats_of(f).overloaded + stats_of(f).forced);
  scree_frost_destroy(f);
  scree_shards_destroy(shards);
}

static void stability_is_looked_at_between_paths_by_its_interval(void** state) {
  (void)state;
  const uint32_t size[3] = {6, 6, 6};
  scree_shards* shards = make_lattice(size, 2, NULL);
  uint64_t digests[2];
  for (int round = 0; round < 2; ++round) {
    scree_frost_rules rules;
    scree_frost_rules_default(&rules);
    rules.strength = 2e5;
    rules.damage = 1;
    rules.stability_interval = round == 0 ? 1 : UINT32_MAX;
    uint8_t states[216] = {0};
    for (uint32_t s = 0; s < 216; ++s) states[s] = s / 6 % 6 == 0 ? SCREE_SHARD_CORE : SCREE_SHARD_SOLID;
    scree_frost* f = must_freeze(shards, &rules, states, 1);
    assert_int_equal(scree_frost_step(f, 1500), SCREE_OK);
    digests[round] = scree_frost_digest(f);
    scree_frost_destroy(f);
  }
  assert_true(digests[0] != digests[1]); /* the end of the call is too late for some */
  scree_shards_destroy(shards);
}

/* --- resistances ------------------------------------------------------------------------------------------------------------- */

static void each_failed_allocation_is_told_and_nothing_leaks(void** state) {
  (void)state;
  const uint32_t size[3] = {3, 3, 3};
  scree_shards* shards = make_lattice(size, 0, NULL);
  scree_frost_rules weak;
  scree_frost_rules_default(&weak);
  weak.strength = 1e9;
  bool whole = false;
  for (int32_t n = 0; !whole; ++n) {
    assert_true(n < 100);
    failing_allocator memory = {.fail_at = n};
    scree_frost_desc desc = {.shards = shards, .allocator = failing_allocator_of(&memory)};
    scree_frost_rules_default(&desc.rules);
    scree_frost* f;
    scree_result result = scree_frost_create(&desc, &f, NULL);
    scree_frost_snapshot* snapshot = NULL;
    if (result == SCREE_OK) {
      memory.fail_at = memory.failed ? -1 : n;
      const int calls = memory.calls;
      assert_int_equal(scree_frost_step(f, 400), SCREE_OK);
      assert_int_equal(memory.calls, calls); /* steps allocate nothing */
      const uint64_t digest = scree_frost_digest(f);
      result = scree_frost_set_rules(f, &weak, NULL);
      assert_true(result != SCREE_OK || f->rules.strength > 0);
      assert_true(result == SCREE_OK || f->rules.strength == 0);
      if (result == SCREE_OK) result = scree_frost_save(f, &snapshot);
      assert_true(scree_frost_digest(f) == digest);
      if (result == SCREE_OK) scree_frost_forget(f, snapshot);
      scree_frost_destroy(f);
    }
    assert_true(result == SCREE_OK || result == SCREE_ERROR_OUT_OF_MEMORY);
    assert_int_equal(memory.live, 0);
    whole = !memory.failed;
    if (whole) assert_true(n > 15);
  }
  scree_shards_destroy(shards);
}

/* Sums of volumes are rounded as they are added up: a share has to be reached by the one that people are told. */
static void a_run_ends_where_the_stats_say_that_the_share_is_reached(void** state) {
  (void)state;
  random_stream r = {11};
  uint32_t below = 0;
  for (uint32_t round = 0; round < ROUNDS(200, 40); ++round) {
    scree_shards* shards = make_lattice((const uint32_t[3]){5, 4, 5}, 1 + round, NULL);
    scree_frost_rules rules;
    scree_frost_rules_default(&rules);
    scree_frost* f = must_freeze(shards, &rules, NULL, round);
    for (uint32_t k = 0; k < 20; ++k) scree_frost_set_shard(f, (uint32_t)(random_unit(&r) * 100), SCREE_SHARD_AIR);
    const scree_frost_stats before = stats_of(f);
    double share = before.volume / before.start_volume;
    if (share * before.start_volume >= before.volume) share = nextafter(share, 0);
    assert_int_equal(scree_frost_run(f, share, 20000, NULL, NULL), SCREE_OK);
    const scree_frost_stats after = stats_of(f);
    assert_true(after.volume <= share * after.start_volume || after.paths == before.paths + 20000 || after.dry);
    below += after.volume <= share * after.start_volume;
    scree_frost_destroy(f);
    scree_shards_destroy(shards);
  }
  assert_true(below > ROUNDS(100, 40)); /* most of them are reached, so that the bound above is one */
}

static void weight_knows_only_the_direction_of_gravity(void** state) {
  (void)state;
  scree_shards* shards = make_lattice((const uint32_t[3]){4, 6, 4}, 5, NULL);
  uint64_t digests[3];
  uint64_t overloaded[3];
  static const double lengths[3] = {1, 1e200, 1e-200};
  for (int i = 0; i < 3; ++i) {
    scree_frost_rules rules;
    scree_frost_rules_default(&rules);
    rules.gravity[1] = -lengths[i];
    rules.strength = 2e5;
    scree_frost* f = must_freeze(shards, &rules, NULL, 3);
    assert_int_equal(scree_frost_step(f, 3000), SCREE_OK);
    digests[i] = scree_frost_digest(f);
    overloaded[i] = stats_of(f).overloaded;
    scree_frost_destroy(f);
  }
  assert_true(overloaded[0] > 0);
  assert_true(digests[1] == digests[0] && digests[2] == digests[0]);
  assert_true(overloaded[1] == overloaded[0] && overloaded[2] == overloaded[0]);
  scree_shards_destroy(shards);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_run_ends_where_the_stats_say_that_the_share_is_reached),
      cmocka_unit_test(weight_knows_only_the_direction_of_gravity),
      cmocka_unit_test(of_two_parts_the_smaller_falls_unless_it_has_core),
      cmocka_unit_test(with_stability_what_rests_stays),
      cmocka_unit_test(what_an_edit_leaves_hanging_falls),
      cmocka_unit_test(what_nothing_holds_falls_at_once),
      cmocka_unit_test(a_pocket_is_exterior_when_it_is_opened),
      cmocka_unit_test(steps_after_edits_are_the_twins),
      cmocka_unit_test(nothing_stands_without_a_path_to_what_holds_it),
      cmocka_unit_test(a_group_falls_in_blocks_by_the_life_of_its_links),
      cmocka_unit_test(snapshots_come_back_exactly),
      cmocka_unit_test(nothing_falls_where_all_is_core),
      cmocka_unit_test(paths_end_where_nothing_takes_water),
      cmocka_unit_test(rain_from_below_drains_where_it_lands),
      cmocka_unit_test(runs_stop_at_a_share_of_the_volume),
      cmocka_unit_test(what_is_too_weak_to_stand_breaks_in_steps),
      cmocka_unit_test(stability_is_looked_at_between_paths_by_its_interval),
      cmocka_unit_test(each_failed_allocation_is_told_and_nothing_leaks),
  };
  return cmocka_run_group_tests_name("frost_state", tests, NULL, NULL);
}
