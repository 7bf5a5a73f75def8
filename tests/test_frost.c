/* Freeze and thaw against its twin, which is section 5 of the paper written down, and against its formulas. */
#include <scree/frost.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "frost_draw.h"
#include "frost_twin.h"
#include "make_hill.h"
#include "make_shards.h"
#include "make_solids.h"
#include "random_frost.h"
#include "rounds.h"

static const char* folder = "."; /* with meshes: those that are not there are left out */

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
  assert_int_equal(stats.overloaded, twin->overloaded);
  assert_true(stats.poured == twin->poured && stats.absorbed == twin->absorbed && stats.drained == twin->drained);
  compare_blocks(f, twin);
}

/* Strengths by which some of what stands breaks, looked at often. */
static void random_strength(random_stream* stream, scree_frost_rules* rules) {
  rules->strength = 3e4;
  for (uint32_t i = (uint32_t)(random_unit(stream) * 8); i > 0; --i) rules->strength *= 2;
  rules->strength *= 1 + random_unit(stream);
  rules->compression = 1 + 9 * random_unit(stream);
  rules->stability_interval = 1 + (uint32_t)(random_unit(stream) * 8);
}

/* Paths until nothing takes water or there were `most`, compared every `every` paths. */
static void run_both(scree_frost* f, frost_twin* twin, uint32_t most, uint32_t every, bool walk) {
  bool wet = true;
  for (uint32_t i = 0; i < most && wet; i += every) {
    for (uint32_t k = 0; k < every && wet; ++k) wet = frost_twin_path(twin, walk);
    frost_twin_check(twin);
    assert_int_equal(scree_frost_step(f, every), SCREE_OK);
    compare(f, twin);
    scree_frost_stats stats;
    scree_frost_get_stats(f, &stats);
    assert_int_equal(stats.dry, !wet);
  }
}

static void states_are_the_twins_on_random_lattices_and_rules(void** state) {
  (void)state;
  uint64_t falls = 0, breaks = 0, kept = 0, overloaded = 0;
  for (uint64_t round = 0; round < ROUNDS(300, 10); ++round) {
    random_stream stream = {round};
    uint32_t size[3];
    for (int a = 0; a < 3; ++a) size[a] = 1 + (uint32_t)(random_unit(&stream) * 6);
    scree_shards* shards = make_lattice(size, round % 3 == 0 ? 0 : round, NULL);
    scree_frost_rules rules;
    uint8_t states[216];
    random_frost_rules(&stream, &rules);
    random_frost_states(&stream, shards->view.shard_count, states);
    if (round % 3 == 1) rules.strength = 1e12; /* stability by which nothing breaks, but what rests does not fall */
    if (round % 3 == 2) random_strength(&stream, &rules);
    scree_frost* f = must_freeze(shards, &rules, states, round);
    frost_twin* twin = frost_twin_start(f, states);
    compare(f, twin);
    run_both(f, twin, 600, 1 + (uint32_t)(random_unit(&stream) * 10), false);
    falls += f->stats.detachments;
    breaks += f->stats.breaks;
    kept += f->stats.blocks;
    overloaded += f->stats.overloaded;
    if (round % 3 != 2) assert_int_equal(f->stats.overloaded, 0);
    frost_twin_destroy(twin);
    scree_frost_destroy(f);
    scree_shards_destroy(shards);
  }
  assert_true(breaks > ROUNDS(5000, 10) && falls > ROUNDS(1000, 10) && kept > ROUNDS(1000, 10));
  assert_true(overloaded > ROUNDS(500, 10));
}

/* Random Voronoi cells, where three shards meet at an edge: there the paper's walk over the links graph finds the same links as
 * what air joins the outside. Floating core shards, which such a walk cannot come to, are left out. */
static void states_are_the_twins_on_voronoi_shards(void** state) {
  (void)state;
  uint64_t falls = 0, walks = 0, overloaded = 0;
  for (uint64_t round = 0; round < ROUNDS(12, 4); ++round) {
    random_stream stream = {300 + round};
    scree_error error;
    scree_shards* shards = round % 3 == 2   ? make_columns(8, 5, 6, round, &error)
                           : round % 3 == 1 ? make_ring(200, 20, round, &error)
                                            : make_hill(250, 20, round, &error);
    if (shards == NULL) fail_msg("%s", error.message);
    scree_shards_view v;
    scree_shards_get(shards, &v);
    scree_frost_rules rules;
    random_frost_rules(&stream, &rules);
    if (round % 5 != 0) random_strength(&stream, &rules);
    uint8_t states[512] = {0};
    assert_true(v.shard_count <= sizeof states);
    for (uint32_t s = 0; s < v.shard_count && round % 2 == 1; ++s)
      states[s] = v.shards[s].centroid[1] < v.min[1] + 2 ? SCREE_SHARD_CORE : SCREE_SHARD_SOLID;
    scree_frost* f = must_freeze(shards, &rules, states, round);
    frost_twin* twin = frost_twin_start(f, states);
    run_both(f, twin, 4000, 50, true);
    falls += f->stats.detachments;
    walks += twin->walk_differs;
    overloaded += f->stats.overloaded;
    frost_twin_destroy(twin);
    scree_frost_destroy(f);
    scree_shards_destroy(shards);
  }
  assert_int_equal(walks, 0);
  assert_true(overloaded > ROUNDS(100, 4));
  assert_true(falls > ROUNDS(150, 4));
}

static scree_shards* split(const solid_mesh* mesh, uint32_t count, uint64_t seed) {
  const scree_seed_pattern pattern = {.kind = SCREE_SEEDS_RANDOM, .count = count, .random_seed = seed};
  scree_shards_desc desc = {.solid = {.positions = mesh->positions,
                                      .indices = mesh->indices,
                                      .vertex_count = mesh->vertex_count,
                                      .triangle_count = mesh->triangle_count}};
  scree_shards* shards = NULL;
  scree_error error;
  double* seeds;
  if (scree_seeds_create(&pattern, &desc.solid, NULL, &seeds, &desc.seed_count, &error) != SCREE_OK) fail_msg("%s", error.message);
  desc.seeds = seeds;
  if (scree_shards_create(&desc, &shards, &error) != SCREE_OK) fail_msg("%s", error.message);
  scree_seeds_free(NULL, seeds, desc.seed_count);
  return shards;
}

/* Cells that fall into pieces, links with holes, many exterior links: state for state, water and volume kept, core where it was. */
static void states_are_the_twins_on_concave_meshes(void** state) {
  (void)state;
  static const char* const names[] = {"", "elephant", "knot1", "armadillo", "bunny00"};
  uint64_t falls = 0, overloaded = 0;
  for (size_t n = 0; n < ROUNDS(sizeof names / sizeof *names, 5); ++n) {
    solid_mesh mesh;
    char path[1024];
    snprintf(path, sizeof path, "%s/%s.off", folder, names[n]);
    if (n == 0)
      mesh = solid_goblin(20, 60);
    else if (!solid_read_off(path, &mesh))
      continue;
    for (uint64_t round = 0; round < 4; ++round) {
      scree_shards* shards = split(&mesh, 50, round + 1);
      const scree_shards_view* v = &shards->view;
      random_stream stream = {500 + 10 * n + round};
      scree_frost_rules rules;
      random_frost_rules(&stream, &rules);
      rules.rains[0] = (scree_rain){{0, -1, 0.2}, 0.8, 1};
      rules.damage = 2;
      rules.fall = SCREE_FALL_KEPT;
      rules.stability_interval = 3;
      if (round >= 2) rules.strength = 2600 * 9.81 * (v->max[1] - v->min[1]) * (1 + 20 * random_unit(&stream));
      uint8_t* states = calloc(v->shard_count, 1);
      assert_non_null(states);
      for (uint32_t s = 0; s < v->shard_count && round % 2 == 1; ++s)
        states[s] = v->shards[s].centroid[1] < v->min[1] + 0.3 * (v->max[1] - v->min[1]) ? SCREE_SHARD_CORE : SCREE_SHARD_SOLID;
      scree_frost* f = must_freeze(shards, &rules, states, n);
      frost_twin* twin = frost_twin_start(f, states);
      run_both(f, twin, 400, 40, false);
      scree_frost_stats stats;
      scree_frost_get_stats(f, &stats);
      for (uint32_t s = 0; s < v->shard_count; ++s)
        assert_int_equal(states[s] == SCREE_SHARD_CORE, f->states[s] == SCREE_SHARD_CORE);
      assert_true(fabs(stats.poured - stats.absorbed - stats.drained) <= 1e-12 * stats.poured);
      const scree_block* blocks;
      const uint32_t* list;
      double volume = stats.volume;
      const uint32_t count = scree_frost_blocks(f, &blocks, &list);
      for (uint32_t b = 0; b < count; ++b) volume += blocks[b].volume;
      assert_true(fabs(volume - stats.start_volume) <= 1e-12 * stats.start_volume * v->shard_count);
      falls += stats.detachments;
      overloaded += stats.overloaded;
      free(states);
      frost_twin_destroy(twin);
      scree_frost_destroy(f);
      scree_shards_destroy(shards);
    }
    solid_mesh_free(&mesh);
  }
  assert_true(falls >= 5 && overloaded >= 5);
}

/* --- formulas ---------------------------------------------------------------------------------------------------------------- */

/* Rules under which nothing changes and water runs far. */
static void idle_rules(scree_frost_rules* rules) {
  scree_frost_rules_default(rules);
  rules->damage = 0;
  rules->break_life = 0;
  rules->total_absorption = false;
  rules->solid_absorption = rules->air_absorption = rules->resistance_absorption = 1e-6;
}

/* A frost whose links have random lives and that has lost some shards. */
static scree_frost* worn(const scree_shards* shards, const scree_frost_rules* rules, uint64_t round) {
  random_stream stream = {round};
  uint8_t states[512];
  assert_true(shards->view.shard_count <= sizeof states);
  for (uint32_t s = 0; s < shards->view.shard_count; ++s)
    states[s] = random_unit(&stream) < 0.2 ? SCREE_SHARD_AIR : SCREE_SHARD_CORE; /* core: breaks let nothing fall */
  scree_frost* f = must_freeze(shards, rules, states, round);
  for (uint32_t l = 0; l < shards->view.interior_link_count; ++l)
    if (f->lives[l] > 0)
      assert_int_equal(scree_frost_set_life(f, l, random_unit(&stream) < 0.2 ? 0 : random_unit(&stream)), SCREE_OK);
  return f;
}

/* Pearson's sum over counts and what was expected of them; few are put together. */
typedef struct chi_square {
  double sum, freedom, rest_count, rest_expected;
} chi_square;

static void expect(chi_square* c, double count, double expected) {
  if (expected >= 10) {
    c->sum += (count - expected) * (count - expected) / expected;
    c->freedom += 1;
  } else {
    c->rest_count += count;
    c->rest_expected += expected;
  }
}

/* One set of counts whose sum is given is whole. */
static void close_set(chi_square* c) {
  if (c->rest_expected >= 10) {
    c->sum += (c->rest_count - c->rest_expected) * (c->rest_count - c->rest_expected) / c->rest_expected;
    c->freedom += 1;
  }
  if (c->rest_expected == 0) assert_true(c->rest_count == 0);
  c->rest_count = c->rest_expected = 0;
  c->freedom -= 1;
}

/* Within five standard deviations: once in a million runs by chance, and the stream is always the same. */
static void assert_fits(const chi_square* c) {
  assert_true(c->freedom > 3);
  const double off = fabs(c->sum - c->freedom) / sqrt(2 * c->freedom);
  if (off > 5) fail_msg("chi-square is %g of %g degrees of freedom", c->sum, c->freedom);
}

/* The chance of each link to be where a path starts, by quadrature over the cone. */
static void expect_starts(const scree_frost* f, const scree_rain* rain, double* out) {
  const scree_shards_view* v = &f->view;
  enum { RINGS = 60, SPOKES = 120 };
  double axis[3], length = 0;
  for (int a = 0; a < 3; ++a) length += rain->direction[a] * rain->direction[a];
  for (int a = 0; a < 3; ++a) axis[a] = -rain->direction[a] / sqrt(length);
  const int least = fabs(axis[0]) < 0.5 ? 0 : 1;
  double side[3], other[3];
  for (int a = 0; a < 3; ++a) side[a] = (a == least) - axis[least] * axis[a];
  length = sqrt(side[0] * side[0] + side[1] * side[1] + side[2] * side[2]);
  for (int a = 0; a < 3; ++a) side[a] /= length;
  for (int a = 0; a < 3; ++a) other[a] = axis[(a + 1) % 3] * side[(a + 2) % 3] - axis[(a + 2) % 3] * side[(a + 1) % 3];
  for (uint32_t l = 0; l < v->link_count; ++l) out[l] = 0;
  for (int ring = 0; ring < RINGS; ++ring)
    for (int spoke = 0; spoke < SPOKES; ++spoke) {
      const double along = 1 - (1 - cos(rain->spread)) * (ring + 0.5) / RINGS, across = sqrt(1 - along * along);
      const double angle = 2 * 3.14159265358979323846 * (spoke + 0.5) / SPOKES;
      double w[3], sum = 0;
      for (int a = 0; a < 3; ++a) w[a] = along * axis[a] + across * (cos(angle) * side[a] + sin(angle) * other[a]);
      for (int pass = 0; pass < 2; ++pass)
        for (uint32_t l = 0; l < v->link_count; ++l) {
          if (f->exterior[l] == 0) continue;
          const double sign = frost_stands(f, v->links[l].shards[0]) ? 1 : -1;
          double share = 0;
          for (int a = 0; a < 3; ++a) share += sign * v->links[l].normal[a] * w[a];
          share = share > 0 ? share * v->links[l].area : 0;
          if (pass == 0) sum += share;
          if (pass == 1) out[l] += share / sum / (RINGS * SPOKES);
        }
    }
}

static void paths_start_by_area_and_direction(void** state) {
  (void)state;
  const uint32_t size[3] = {4, 5, 3};
  static const scree_rain rains[5] = {
      {{0, -1, 0}, 0.5, 1}, {{1, -0.5, 0.2}, 0, 3}, {{1, -2, 3}, 1.2, 1}, {{0, 0, 1}, 3.1, 1}, {{0, 3, 0}, 1e-5, 1}};
  enum { PATHS = ROUNDS(100000, 20) };
  for (uint64_t round = 0; round < 5; ++round) {
    scree_shards* shards = make_lattice(size, 1 + round, NULL);
    const uint32_t links = shards->view.link_count;
    scree_frost_rules rules;
    idle_rules(&rules);
    rules.rains[0] = rains[round];
    scree_frost* f = worn(shards, &rules, round);
    double* chances = calloc(links, sizeof *chances);
    uint32_t* counts = calloc(links, sizeof *counts);
    assert_non_null(chances);
    assert_non_null(counts);
    expect_starts(f, &rains[round], chances);
    for (int i = 0; i < PATHS; ++i) {
      uint32_t first;
      assert_int_equal(scree_frost_step(f, 1), SCREE_OK);
      assert_true(scree_frost_last_path(f, &first, NULL, 1) > 0);
      ++counts[first];
    }
    chi_square c = {0};
    for (uint32_t l = 0; l < links; ++l) expect(&c, counts[l], PATHS * chances[l]);
    close_set(&c);
    assert_fits(&c);
    free(chances);
    free(counts);
    scree_frost_destroy(f);
    scree_shards_destroy(shards);
  }
}

static void several_rains_share_paths_by_weight(void** state) {
  (void)state;
  const uint32_t size[3] = {2, 2, 2};
  scree_shards* shards = make_lattice(size, 0, NULL);
  scree_frost_rules rules;
  idle_rules(&rules);
  rules.rain_count = 3;
  rules.rains[0] = (scree_rain){{0, -1, 0}, 0, 2};
  rules.rains[1] = (scree_rain){{1, 0, 0}, 0, 1};
  rules.rains[2] = (scree_rain){{0, 0, -1}, 0, 5};
  scree_frost* f = must_freeze(shards, &rules, NULL, 3);
  enum { PATHS = 20000 };
  uint32_t counts[3] = {0};
  for (int i = 0; i < PATHS; ++i) {
    uint32_t first;
    assert_int_equal(scree_frost_step(f, 1), SCREE_OK);
    assert_true(scree_frost_last_path(f, &first, NULL, 1) > 0);
    const double* n = shards->view.links[first].normal;
    ++counts[n[1] > 0.5 ? 0 : n[0] < -0.5 ? 1 : 2];
  }
  for (int i = 0; i < 3; ++i) {
    const double p = rules.rains[i].weight / 8;
    assert_true(fabs(counts[i] - PATHS * p) < 5 * sqrt(PATHS * p * (1 - p)));
  }
  scree_frost_destroy(f);
  scree_shards_destroy(shards);
}

/* p_flow of the paper, with nothing of the library's but places, lives and which shards stand. */
static double plain_flow(const scree_frost* f, const double gravity[3], double rho, uint32_t from, uint32_t to) {
  const scree_link *a = &f->view.links[from], *b = &f->view.links[to];
  if (!frost_stands(f, b->shards[0]) && (b->shards[1] == SCREE_NO_SHARD || !frost_stands(f, b->shards[1]))) return 0;
  double dot = 0, length = 0, weight = 0;
  for (int i = 0; i < 3; ++i) {
    const double d = b->centroid[i] - a->centroid[i];
    dot += d * gravity[i];
    length += d * d;
    weight += gravity[i] * gravity[i];
  }
  const double pull = dot / sqrt(length * weight);
  return pull > 1e-12 ? pull * (1 - f->lives[to] * rho) : 0;
}

static void water_flows_by_gravity_and_resistance(void** state) {
  (void)state;
  const uint32_t size[3] = {4, 5, 3};
  static const double gravities[3][3] = {{0, -1, 0}, {0.3, -2, 0.7}, {-1, 1, 0.1}};
  enum { PATHS = ROUNDS(60000, 20) };
  for (uint64_t round = 0; round < 3; ++round) {
    scree_shards* shards = make_lattice(size, 1 + round, NULL);
    const scree_shards_view* v = &shards->view;
    scree_frost_rules rules;
    idle_rules(&rules);
    memcpy(rules.gravity, gravities[round], sizeof rules.gravity);
    rules.resistance.value = 0.3 * (double)(round + 1);
    rules.rains[0].spread = 3;
    scree_frost* f = worn(shards, &rules, 10 + round);
    uint32_t* counts = calloc(v->neighbour_first[v->link_count], sizeof *counts);
    uint32_t* ends = calloc(v->link_count, sizeof *ends);
    assert_non_null(counts);
    assert_non_null(ends);
    for (int i = 0; i < PATHS; ++i) {
      uint32_t path[256];
      assert_int_equal(scree_frost_step(f, 1), SCREE_OK);
      const uint32_t length = scree_frost_last_path(f, path, NULL, 256);
      assert_true(length <= 256);
      ++ends[path[length - 1]];
      for (uint32_t k = 0; k + 1 < length; ++k) {
        uint32_t at = v->neighbour_first[path[k]];
        while (at < v->neighbour_first[path[k] + 1] && v->neighbours[at] != path[k + 1]) ++at;
        assert_true(at < v->neighbour_first[path[k] + 1]);
        ++counts[at];
      }
    }
    chi_square c = {0};
    for (uint32_t l = 0; l < v->link_count; ++l) {
      double sum = 0, all = 0;
      for (uint32_t k = v->neighbour_first[l]; k < v->neighbour_first[l + 1]; ++k) {
        sum += plain_flow(f, rules.gravity, rules.resistance.value, l, v->neighbours[k]);
        all += counts[k];
      }
      if (sum > 0) assert_int_equal(ends[l], 0); /* water that is left goes on where it can */
      if (all < 40) continue;
      for (uint32_t k = v->neighbour_first[l]; k < v->neighbour_first[l + 1]; ++k)
        expect(&c, counts[k], all * plain_flow(f, rules.gravity, rules.resistance.value, l, v->neighbours[k]) / sum);
      close_set(&c);
    }
    assert_fits(&c);
    free(counts);
    free(ends);
    scree_frost_destroy(f);
    scree_shards_destroy(shards);
  }
}

static void no_direction_of_a_cone_takes_more_than_the_weight(void** state) {
  (void)state;
  const uint32_t size[3] = {1, 1, 1};
  scree_shards* shards = make_lattice(size, 0, NULL);
  random_stream stream = {5};
  for (int round = 0; round < ROUNDS(3000, 10); ++round) {
    scree_frost_rules rules;
    scree_frost_rules_default(&rules);
    random_direction(&stream, rules.rains[0].direction);
    rules.rains[0].spread = round % 3 == 0 ? 3.14159265358979323846 * random_unit(&stream) : random_unit(&stream) * 1e-3;
    if (round % 50 == 0) rules.rains[0].spread = round % 100 == 0 ? 0 : 3.14159265358979;
    scree_frost* f = must_freeze(shards, &rules, NULL, 0);
    const frost_rain* rain = &f->tables.rains[0];
    const double scale = 0x1p51;
    for (int i = 0; i < 30; ++i) {
      double direction[3], length = 0, along = 0;
      frost_draw_direction(rain, &stream, direction);
      for (int a = 0; a < 3; ++a) length += direction[a] * direction[a], along += direction[a] * rain->axis[a];
      assert_true(fabs(length - 1) < 1e-12);
      assert_true(along > cos(rules.rains[0].spread) - 1e-12);
      scree_link link = {.area = random_unit(&stream)};
      random_direction(&stream, link.normal);
      if (i % 3 == 0) memcpy(link.normal, direction, sizeof link.normal);
      assert_true(frost_share(&link, i % 2 == 0, direction, scale) <= (double)frost_weight(rain, &link, i % 2 == 0, scale));
    }
    scree_frost_destroy(f);
  }
  scree_shards_destroy(shards);
}

/* --- what always holds ------------------------------------------------------------------------------------------------------- */

/* Shards that unbroken links join to `from`, marked. */
static uint32_t reach(const scree_frost* f, uint32_t from, uint8_t* seen) {
  const scree_shards_view* v = &f->view;
  uint32_t queue[512], count = 0;
  if (seen[from] != 0) return 0;
  seen[from] = 1;
  queue[count++] = from;
  for (uint32_t head = 0; head < count; ++head)
    for (uint32_t l = 0; l < v->interior_link_count; ++l)
      for (int side = 0; side < 2; ++side) {
        const uint32_t other = v->links[l].shards[1 - side];
        if (v->links[l].shards[side] != queue[head] || !(f->lives[l] > 0) || seen[other] != 0) continue;
        seen[other] = 1;
        queue[count++] = other;
      }
  return count;
}

static void what_stands_hangs_together_and_core_stays(void** state) {
  (void)state;
  uint64_t falls = 0;
  for (uint64_t round = 0; round < ROUNDS(60, 10); ++round) {
    random_stream stream = {1000 + round};
    const uint32_t size[3] = {2 + (uint32_t)(random_unit(&stream) * 4), 3, 2 + (uint32_t)(random_unit(&stream) * 4)};
    scree_shards* shards = make_lattice(size, round, NULL);
    const scree_shards_view* v = &shards->view;
    uint8_t states[512] = {0};
    for (uint32_t s = 0; s < v->shard_count && round % 2 == 1; ++s)
      states[s] = random_unit(&stream) < 0.1 ? SCREE_SHARD_CORE : SCREE_SHARD_SOLID;
    scree_frost_rules rules;
    random_frost_rules(&stream, &rules);
    scree_frost* f = must_freeze(shards, &rules, states, round);
    double* before = malloc(v->link_count * sizeof *before);
    assert_non_null(before);
    const bool any_core = f->stats.core > 0;
    for (int i = 0; i < 60; ++i) {
      memcpy(before, f->lives, v->link_count * sizeof *before);
      assert_int_equal(scree_frost_step(f, 10), SCREE_OK);
      for (uint32_t l = 0; l < v->link_count; ++l) assert_true(f->lives[l] <= before[l] && f->lives[l] >= 0);
      uint8_t seen[512] = {0};
      uint32_t reached = 0, parts = 0, standing = 0;
      for (uint32_t s = 0; s < v->shard_count; ++s) {
        standing += frost_stands(f, s);
        assert_int_equal(states[s] == SCREE_SHARD_CORE, f->states[s] == SCREE_SHARD_CORE);
        if (any_core ? f->states[s] != SCREE_SHARD_CORE : !frost_stands(f, s)) continue;
        const uint32_t more = reach(f, s, seen);
        parts += more > 0;
        reached += more;
      }
      assert_int_equal(reached, standing);
      if (!any_core) assert_int_equal(parts, 1);
      scree_frost_stats stats;
      scree_frost_get_stats(f, &stats);
      assert_int_equal(stats.solid + stats.core, standing);
      assert_int_equal(stats.air, v->shard_count - standing);
      assert_true(fabs(stats.poured - stats.absorbed - stats.drained) <= 1e-12 * stats.poured);
      assert_true(fabs(stats.volume - f->stats.volume) < 1e-12 * stats.start_volume);
      if (rules.fall == SCREE_FALL_KEPT) { /* all that is air fell, and lies in the blocks */
        double volume = stats.volume;
        const scree_block* blocks;
        const uint32_t* list;
        const uint32_t count = scree_frost_blocks(f, &blocks, &list);
        for (uint32_t b = 0; b < count; ++b) volume += blocks[b].volume;
        assert_true(fabs(volume - stats.start_volume) < 1e-9);
      }
    }
    falls += f->stats.detachments;
    free(before);
    scree_frost_destroy(f);
    scree_shards_destroy(shards);
  }
  assert_true(falls > ROUNDS(300, 10));
}

static void runs_repeat_to_the_bit(void** state) {
  (void)state;
  const uint32_t size[3] = {7, 6, 5};
  scree_shards* shards = make_lattice(size, 11, NULL);
  scree_frost_rules rules;
  scree_frost_rules_default(&rules);
  rules.damage = 1;
  rules.fall_life = 0.3;
  rules.resistance = (scree_resistance){
      .kind = SCREE_RESISTANCE_NOISE, .value = 0.4, .amplitude = 0.5, .period = 2, .octaves = 3, .random_seed = 4};
  scree_frost *a = must_freeze(shards, &rules, NULL, 9), *b = must_freeze(shards, &rules, NULL, 9);
  scree_frost* other = must_freeze(shards, &rules, NULL, 10);
  assert_int_equal(scree_frost_step(a, 1000), SCREE_OK);
  assert_int_equal(scree_frost_step(other, 1000), SCREE_OK);
  for (int i = 0; i < 100; ++i) assert_int_equal(scree_frost_step(b, 10), SCREE_OK); /* however it is cut into calls */
  assert_true(scree_frost_digest(a) == scree_frost_digest(b));
  assert_true(scree_frost_digest(a) != scree_frost_digest(other));
  assert_true(a->stats.air > 20 && a->stats.solid > 20);
  const uint64_t golden = UINT64_C(0x59ea32ef4ffab08f), digest = scree_frost_digest(a);
  if (digest != golden) fail_msg("digest is 0x%016llx", (unsigned long long)digest);
  scree_frost_destroy(a);
  scree_frost_destroy(b);
  scree_frost_destroy(other);
  scree_shards_destroy(shards);
}

int main(int argc, char** argv) {
  if (argc > 1) folder = argv[1];
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(states_are_the_twins_on_random_lattices_and_rules),
      cmocka_unit_test(states_are_the_twins_on_voronoi_shards),
      cmocka_unit_test(states_are_the_twins_on_concave_meshes),
      cmocka_unit_test(paths_start_by_area_and_direction),
      cmocka_unit_test(several_rains_share_paths_by_weight),
      cmocka_unit_test(water_flows_by_gravity_and_resistance),
      cmocka_unit_test(no_direction_of_a_cone_takes_more_than_the_weight),
      cmocka_unit_test(what_stands_hangs_together_and_core_stays),
      cmocka_unit_test(runs_repeat_to_the_bit),
  };
  return cmocka_run_group_tests_name("frost", tests, NULL, NULL);
}
