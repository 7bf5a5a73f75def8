/* Stability: against a naive twin on random lattices, and against what mechanics of materials says of beams and columns. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "failing_allocator.h"
#include "frost_stability.h"
#include "make_shards.h"
#include "random.h"
#include "stability_twin.h"

/* --- a lattice of boxes to weigh -----------------------------------------------------------------------------------------------
 */

typedef struct scene {
  scree_shards* shards;
  scree_shards_view view;
  uint32_t size[3];
  uint8_t *states, *rests;
  double* lives;
  frost_stability* stability;
  frost_stability_state state;
} scene;

static scene make_scene(uint32_t x, uint32_t y, uint32_t z, uint64_t seed) {
  scene s = {.size = {x, y, z}};
  s.shards = make_lattice(s.size, seed, NULL);
  s.view = s.shards->view;
  s.states = calloc(s.view.shard_count, 1);
  s.rests = calloc(s.view.shard_count, 1);
  s.lives = calloc(s.view.link_count, sizeof *s.lives);
  assert_true(s.states != NULL && s.rests != NULL && s.lives != NULL);
  for (uint32_t l = 0; l < s.view.interior_link_count; ++l) s.lives[l] = 1;
  assert_int_equal(frost_stability_create(s.shards, NULL, &s.stability), SCREE_OK);
  s.state = (frost_stability_state){.states = s.states,
                                    .rests = s.rests,
                                    .lives = s.lives,
                                    .gravity = {0, -1, 0},
                                    .density = 2600,
                                    .strength = 1e5,
                                    .compression = 10};
  return s;
}

static void free_scene(scene* s) {
  frost_stability_destroy(s->stability);
  scree_shards_destroy(s->shards);
  free(s->states);
  free(s->rests);
  free(s->lives);
}

static uint32_t at(const scene* s, uint32_t x, uint32_t y, uint32_t z) {
  return x + s->size[0] * (y + s->size[1] * z);
}

/* As a simulation keeps it: lives of links to air are 0. */
static void make_air(scene* s, uint32_t shard) {
  s->states[shard] = SCREE_SHARD_AIR;
  for (uint32_t l = 0; l < s->view.interior_link_count; ++l)
    if (s->view.links[l].shards[0] == shard || s->view.links[l].shards[1] == shard) s->lives[l] = 0;
}

static uint32_t weigh(scene* s) {
  frost_find_rests(&s->view, s->state.gravity, s->rests);
  return frost_stability_weigh(s->stability, &s->state);
}

/* --- the naive twin ---------------------------------------------------------------------------------------------------------- */

static int by_number(const void* a, const void* b) {
  const uint32_t x = *(const uint32_t*)a, y = *(const uint32_t*)b;
  return (x > y) - (x < y);
}

static void the_twin_breaks_the_same_links(void** unused) {
  (void)unused;
  uint32_t broke = 0, held = 0;
  for (uint64_t seed = 1; seed <= 150; ++seed) {
    random_stream stream = {seed};
    uint32_t size[3];
    for (int axis = 0; axis < 3; ++axis) size[axis] = (axis == 2 ? 1 : 2) + (uint32_t)(random_unit(&stream) * 5);
    scene s = make_scene(size[0], size[1], size[2], seed);
    const bool core = seed % 3 != 0;
    const double gone = 0.4 * random_unit(&stream);
    for (uint32_t i = 0; i < s.view.shard_count; ++i)
      if (random_unit(&stream) < gone) make_air(&s, i);
    for (uint32_t i = 0; core && i < s.view.shard_count; ++i)
      if (s.states[i] == SCREE_SHARD_SOLID && random_unit(&stream) < 0.06) s.states[i] = SCREE_SHARD_CORE;
    for (uint32_t l = 0; l < s.view.interior_link_count; ++l)
      if (s.lives[l] > 0) s.lives[l] = random_unit(&stream) < 0.15 ? 0 : 1 - random_unit(&stream);
    for (int axis = 0; axis < 3; ++axis)
      s.state.gravity[axis] = seed % 2 ? (axis == 1 ? -3 : 0) : random_unit(&stream) - (axis == 1 ? 1.5 : 0.5);
    s.state.strength = 2e4 / (0.02 + random_unit(&stream) * 0.4);
    s.state.compression = 1 + 9 * random_unit(&stream);

    uint8_t* supported = calloc(s.view.shard_count, 1);
    double* lives = calloc(s.view.link_count, sizeof *lives);
    assert_true(supported != NULL && lives != NULL);
    memcpy(lives, s.lives, s.view.link_count * sizeof *lives);
    bool any_core = false;
    double lowest = -INFINITY, highest = INFINITY;
    for (uint32_t i = 0; i < s.view.shard_count; ++i) any_core = any_core || s.states[i] == SCREE_SHARD_CORE;
    for (uint32_t k = 0; k < s.view.vertex_count; ++k) {
      double along = 0;
      for (int axis = 0; axis < 3; ++axis) along += s.view.vertices[3 * k + (uint32_t)axis] * s.state.gravity[axis];
      lowest = fmax(lowest, along);
      highest = fmin(highest, along);
    }
    for (uint32_t i = 0; i < s.view.shard_count; ++i) {
      if (any_core) {
        supported[i] = s.states[i] == SCREE_SHARD_CORE;
        continue;
      }
      for (uint32_t k = 0; k < s.view.shards[i].link_count; ++k) {
        const scree_link* link = &s.view.links[s.view.shard_links[s.view.shards[i].first_link + k]];
        for (uint32_t p = 0; p < link->polygon_count; ++p)
          for (uint32_t c = 0; c < s.view.polygons[link->first_polygon + p].corner_count; ++c) {
            const uint32_t vertex = s.view.corners[s.view.polygons[link->first_polygon + p].first_corner + c];
            double along = 0;
            for (int axis = 0; axis < 3; ++axis) along += s.view.vertices[3 * vertex + (uint32_t)axis] * s.state.gravity[axis];
            if (lowest - along <= 1e-6 * (lowest - highest)) supported[i] = s.states[i] != SCREE_SHARD_AIR;
          }
      }
    }
    stability_twin rule = {
        .view = &s.view, .density = s.state.density, .strength = s.state.strength, .compression = s.state.compression};
    memcpy(rule.gravity, s.state.gravity, sizeof rule.gravity);
    const uint32_t groups = weigh(&s), twins = stability_twin_weigh(&rule, supported, lives);
    assert_int_equal(groups, twins);
    const uint32_t* found;
    const uint32_t count = frost_stability_cuts(s.stability, &found);
    uint32_t* cuts = calloc(count + 1, sizeof *cuts);
    assert_non_null(cuts);
    memcpy(cuts, found, count * sizeof *cuts);
    qsort(cuts, count, sizeof *cuts, by_number);
    uint32_t next = 0;
    for (uint32_t l = 0; l < s.view.interior_link_count; ++l) {
      if (lives[l] == s.lives[l]) continue;
      assert_true(next < count);
      assert_int_equal(cuts[next++], l);
    }
    assert_int_equal(next, count);
    if (groups > 0)
      ++broke;
    else
      ++held;

    /* Once broken, nothing is left to break. */
    for (uint32_t i = 0; i < count; ++i) s.lives[cuts[i]] = 0;
    assert_int_equal(weigh(&s), 0);
    free(cuts);
    free(supported);
    free(lives);
    free_scene(&s);
  }
  assert_true(broke > 40);
  assert_true(held > 15);
}

/* --- what mechanics says -------------------------------------------------------------------------------------------------------
 */

static const double unit_weight = 2600 * 9.81; /* of a cubic metre */

/* Holds at a strength a hair above `bound` and breaks a hair below it: more than the 1e-9 on the diagonal of J. */
static void assert_bound(scene* s, double bound, uint32_t groups_below) {
  s->state.strength = bound * (1 + 1e-8);
  assert_int_equal(weigh(s), 0);
  s->state.strength = bound * (1 - 1e-8);
  assert_int_equal(weigh(s), groups_below);
}

static void a_cantilever_breaks_where_beam_theory_says(void** unused) {
  (void)unused;
  for (uint32_t length = 1; length <= 12; ++length) {
    scene s = make_scene(length + 1, 1, 1, 0);
    s.states[0] = SCREE_SHARD_CORE;
    const double l = length;
    /* Bending 6 M / (b h^2) with M = w l^2 / 2, and the transverse force over the section. */
    assert_bound(&s, unit_weight * (3 * l * l + l), 1);
    const uint32_t* cut;
    assert_int_equal(frost_stability_cuts(s.stability, &cut), 1);
    assert_int_equal(s.view.links[cut[0]].shards[0], 0); /* at the root */
    free_scene(&s);
  }
}

static void a_deep_cantilever_of_many_links_is_one_section(void** unused) {
  (void)unused;
  /* Two boxes deep and three wide, held all over its end: each level is a section of 2 x 3 links. */
  scene s = make_scene(6, 2, 3, 0);
  for (uint32_t y = 0; y < 2; ++y)
    for (uint32_t z = 0; z < 3; ++z) s.states[at(&s, 0, y, z)] = SCREE_SHARD_CORE;
  assert_bound(&s, unit_weight * (3.0 * 25 / 2 + 5), 1);
  free_scene(&s);
}

static void life_is_area(void** unused) {
  (void)unused;
  scene s = make_scene(4, 1, 1, 0);
  s.states[0] = SCREE_SHARD_CORE;
  for (uint32_t l = 0; l < s.view.interior_link_count; ++l)
    if (s.view.links[l].shards[0] == 0) s.lives[l] = 0.25;
  assert_bound(&s, 4 * unit_weight * (3 * 9 + 3), 1);
  free_scene(&s);
}

static void a_column_is_crushed_at_its_height(void** unused) {
  (void)unused;
  for (uint32_t height = 2; height <= 20; height += 3) {
    scene s = make_scene(1, height, 1, 0);
    s.state.compression = 4;
    assert_bound(&s, unit_weight * (height - 1) / 4, 1);
    free_scene(&s);
  }
}

static void a_hanging_column_tears_at_its_length(void** unused) {
  (void)unused;
  scene s = make_scene(1, 9, 1, 0);
  s.states[8] = SCREE_SHARD_CORE;
  assert_bound(&s, unit_weight * 8, 1);
  free_scene(&s);
}

static void a_beam_held_at_both_ends_bears_shear_alone(void** unused) {
  (void)unused;
  scene s = make_scene(7, 1, 1, 0);
  s.states[0] = s.states[6] = SCREE_SHARD_CORE;
  assert_bound(&s, unit_weight * 5 / 2, 1);
  free_scene(&s);
}

static void an_eccentric_weight_twists_its_cut(void** unused) {
  (void)unused;
  /* An L that lies flat: one box out along x from the core, three more along z at its end. */
  scene s = make_scene(2, 1, 4, 0);
  for (uint32_t z = 1; z < 4; ++z) make_air(&s, at(&s, 0, 0, z));
  s.states[0] = SCREE_SHARD_CORE;
  const double weight = 4 * unit_weight, bending = 6 * weight * 0.5, twist = weight * 1.5 / (1.0 / 6);
  /* At the corner that is worst: shear of the weight and of the twist, by the polar moment, together. */
  const double down = weight + twist / 2, across = twist / 2;
  assert_bound(&s, bending + sqrt(down * down + across * across), 1);
  free_scene(&s);
}

static void an_arch_stands_where_half_of_it_falls(void** unused) {
  (void)unused;
  for (int half = 0; half < 2; ++half) {
    scene s = make_scene(9, 4, 1, 0);
    for (uint32_t y = 0; y < 4; ++y)
      for (uint32_t x = 0; x < 9; ++x)
        if ((y < 3 && x > 0 && x < 8) || (half == 1 && x > 4)) make_air(&s, at(&s, x, y, 0));
    s.state.strength = unit_weight * 12;
    if (half == 0)
      assert_int_equal(weigh(&s), 0);
    else
      assert_true(weigh(&s) > 0);
    free_scene(&s);
  }
}

static void what_rests_broadly_never_breaks(void** unused) {
  (void)unused;
  for (uint64_t seed = 0; seed < 8; ++seed) {
    scene s = make_scene(6, 5, 6, seed);
    random_stream stream = {seed};
    /* A terrain of columns without overhangs, links worn down to a tenth. */
    for (uint32_t z = 0; z < 6; ++z)
      for (uint32_t x = 0; x < 6; ++x)
        for (uint32_t y = 1 + (uint32_t)(random_unit(&stream) * 5); y < 5; ++y) make_air(&s, at(&s, x, y, z));
    for (uint32_t l = 0; l < s.view.interior_link_count; ++l)
      if (s.lives[l] > 0) s.lives[l] = 0.1 + 0.9 * random_unit(&stream);
    s.state.strength = 1e6; /* weak rock */
    assert_int_equal(weigh(&s), 0);
    free_scene(&s);
  }
}

static void where_nothing_is_supported_nothing_breaks(void** unused) {
  (void)unused;
  scene s = make_scene(5, 3, 1, 0);
  for (uint32_t x = 0; x < 5; ++x) make_air(&s, at(&s, x, 0, 0));
  s.state.strength = 1e-3;
  assert_int_equal(weigh(&s), 0);
  free_scene(&s);
}

static void what_no_link_joins_to_support_is_left_alone(void** unused) {
  (void)unused;
  scene s = make_scene(5, 1, 1, 0);
  s.states[0] = SCREE_SHARD_CORE;
  for (uint32_t l = 0; l < s.view.interior_link_count; ++l)
    if (s.view.links[l].shards[0] == 1) s.lives[l] = 0;
  assert_bound(&s, unit_weight * (3 + 1), 1); /* as if there were one box, not four */
  free_scene(&s);
}

static void gravity_may_point_anywhere(void** unused) {
  (void)unused;
  scene s = make_scene(1, 5, 1, 0);
  s.states[0] = SCREE_SHARD_CORE;
  s.state.gravity[0] = 7;
  s.state.gravity[1] = 0;
  assert_bound(&s, unit_weight * (3 * 16 + 4), 1);
  s.state.gravity[0] = 0;
  s.state.gravity[1] = 2;
  assert_bound(&s, unit_weight * 4, 1);
  free_scene(&s);
}

static void what_broke_off_weighs_no_more(void** unused) {
  (void)unused;
  /* A beam whose outer half hangs on a sliver: that breaks, and the inner half then holds at a strength at which all would not. */
  scene s = make_scene(9, 1, 1, 0);
  s.states[0] = SCREE_SHARD_CORE;
  for (uint32_t l = 0; l < s.view.interior_link_count; ++l)
    if (s.view.links[l].shards[0] == 4) s.lives[l] = 1e-3;
  s.state.strength = unit_weight * (3 * 16 + 4) * 1.01;
  assert_int_equal(weigh(&s), 1);
  const uint32_t* cut;
  assert_int_equal(frost_stability_cuts(s.stability, &cut), 1);
  assert_int_equal(s.view.links[cut[0]].shards[0], 4);
  free_scene(&s);
}

static void a_simulation_breaks_what_the_rule_says(void** unused) {
  (void)unused;
  const uint32_t size[3] = {9, 6, 5};
  uint64_t overloaded = 0;
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    scree_shards* shards = make_lattice(size, seed, NULL);
    uint8_t* states = calloc(shards->view.shard_count, 1);
    assert_non_null(states);
    for (uint32_t i = 0; i < shards->view.shard_count; ++i)
      if (i % 9 == 0) states[i] = SCREE_SHARD_CORE; /* the wall at its back */
    scree_frost_desc desc = {.shards = shards, .states = states, .random_seed = seed};
    scree_frost_rules_default(&desc.rules);
    desc.rules.strength = 3e6;
    desc.rules.stability_interval = 4;
    scree_frost* frost;
    assert_int_equal(scree_frost_create(&desc, &frost, NULL), SCREE_OK);
    for (int k = 0; k < 20; ++k) {
      assert_int_equal(scree_frost_step(frost, 200), SCREE_OK);
      assert_int_equal(scree_frost_check_stability(frost), 0);
      assert_int_equal(frost_stability_break(frost), 0);
    }
    scree_frost_stats stats;
    scree_frost_get_stats(frost, &stats);
    overloaded += stats.overloaded;
    assert_int_equal(stats.core, 30);

    /* Rules without strength never ask; stronger gravity of heavier rock breaks more. */
    desc.rules.strength = 0;
    assert_int_equal(scree_frost_set_rules(frost, &desc.rules, NULL), SCREE_OK);
    assert_int_equal(scree_frost_check_stability(frost), 0);
    desc.rules.strength = 1;
    assert_int_equal(scree_frost_set_rules(frost, &desc.rules, NULL), SCREE_OK);
    if (stats.solid > 0) assert_true(scree_frost_check_stability(frost) > 0);
    frost_stability_break(frost);
    scree_frost_get_stats(frost, &stats);
    assert_int_equal(stats.solid, 0);
    assert_int_equal(scree_frost_check_stability(frost), 0);
    scree_frost_destroy(frost);
    scree_shards_destroy(shards);
    free(states);
  }
  assert_true(overloaded > 0);
}

static void every_allocation_may_fail(void** unused) {
  (void)unused;
  const uint32_t size[3] = {3, 3, 3};
  scree_shards* shards = make_lattice(size, 1, NULL);
  for (int32_t n = 0;; ++n) {
    failing_allocator failing = {.fail_at = n};
    const scree_allocator allocator = failing_allocator_of(&failing);
    frost_stability* stability;
    const scree_result result = frost_stability_create(shards, &allocator, &stability);
    if (result == SCREE_OK)
      assert_int_equal(failing.live, (long long)frost_stability_memory(stability));
    else
      assert_null(stability);
    frost_stability_destroy(stability);
    assert_int_equal(failing.live, 0);
    if (!failing.failed) break;
    assert_int_equal(result, SCREE_ERROR_OUT_OF_MEMORY);
  }
  scree_shards_destroy(shards);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_twin_breaks_the_same_links),
      cmocka_unit_test(a_cantilever_breaks_where_beam_theory_says),
      cmocka_unit_test(a_deep_cantilever_of_many_links_is_one_section),
      cmocka_unit_test(life_is_area),
      cmocka_unit_test(a_column_is_crushed_at_its_height),
      cmocka_unit_test(a_hanging_column_tears_at_its_length),
      cmocka_unit_test(a_beam_held_at_both_ends_bears_shear_alone),
      cmocka_unit_test(an_eccentric_weight_twists_its_cut),
      cmocka_unit_test(an_arch_stands_where_half_of_it_falls),
      cmocka_unit_test(what_rests_broadly_never_breaks),
      cmocka_unit_test(where_nothing_is_supported_nothing_breaks),
      cmocka_unit_test(what_no_link_joins_to_support_is_left_alone),
      cmocka_unit_test(gravity_may_point_anywhere),
      cmocka_unit_test(what_broke_off_weighs_no_more),
      cmocka_unit_test(a_simulation_breaks_what_the_rule_says),
      cmocka_unit_test(every_allocation_may_fail),
  };
  return cmocka_run_group_tests_name("frost_stability", tests, NULL, NULL);
}
