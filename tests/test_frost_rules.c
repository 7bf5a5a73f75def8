/* Freeze and thaw: resistances, and rules that are refused. */
#include <scree/frost.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "make_shards.h"
#include "random_frost.h"

static void by_place(void* user, const double* places, double* resistance, uint32_t count) {
  *(uint32_t*)user += count;
  for (uint32_t i = 0; i < count; ++i) resistance[i] = i == 0 ? NAN : places[3 * (size_t)i + 1] - 1;
}

static void resistances_are_those_of_their_places(void** state) {
  (void)state;
  const uint32_t size[3] = {4, 4, 4};
  scree_shards* shards = make_lattice(size, 0, NULL);
  const scree_shards_view* v = &shards->view;
  scree_frost_rules rules;
  scree_frost_rules_default(&rules);
  scree_frost* f = must_freeze(shards, &rules, NULL, 1);
  const double* rho = f->tables.resistance;
  for (uint32_t l = 0; l < v->link_count; ++l) assert_true(rho[l] == 0.5);

  uint32_t calls = 0;
  rules.resistance = (scree_resistance){.kind = SCREE_RESISTANCE_FUNCTION, .function = by_place, .user = &calls};
  assert_int_equal(scree_frost_set_rules(f, &rules, NULL), SCREE_OK);
  assert_int_equal(calls, v->link_count);
  rho = f->tables.resistance;
  for (uint32_t l = 0; l < v->link_count; ++l) {
    const double y = v->links[l].centroid[1] - 1;
    assert_true(rho[l] == (l % 64 == 0 || y < 0 ? 0 : y > 1 - 0x1p-20 ? 1 - 0x1p-20 : y));
  }

  const double layers[6] = {0.5, 0.2, 1.5, 0.8, 1.5, 0.4};
  rules.resistance = (scree_resistance){.kind = SCREE_RESISTANCE_LAYERS, .layers = layers, .layer_count = 3};
  assert_int_equal(scree_frost_set_rules(f, &rules, NULL), SCREE_OK);
  rho = f->tables.resistance;
  for (uint32_t l = 0; l < v->link_count; ++l) {
    const double y = v->links[l].centroid[1];
    assert_true(fabs(rho[l] - (y < 0.5 ? 0.2 : y >= 1.5 ? 0.4 : 0.2 + 0.6 * (y - 0.5))) < 1e-12);
  }
  rules.resistance.up[0] = -2; /* along -x */
  assert_int_equal(scree_frost_set_rules(f, &rules, NULL), SCREE_OK);
  rho = f->tables.resistance;
  for (uint32_t l = 0; l < v->link_count; ++l) {
    const double y = -v->links[l].centroid[0];
    assert_true(fabs(rho[l] - (y < 0.5 ? 0.2 : y >= 1.5 ? 0.4 : 0.2 + 0.6 * (y - 0.5))) < 1e-12);
  }

  const uint8_t images[8] = {0, 255, 0, 255, 51, 255, 51, 255}; /* x: rises, and from z to z */
  rules.resistance = (scree_resistance){.kind = SCREE_RESISTANCE_IMAGES, .images = images, .size = {2, 2, 2}};
  assert_int_equal(scree_frost_set_rules(f, &rules, NULL), SCREE_OK);
  rho = f->tables.resistance;
  for (uint32_t l = 0; l < v->link_count; ++l) {
    double x = (v->links[l].centroid[0] + 1) / 2, z = (v->links[l].centroid[2] + 1) / 2; /* middles of voxels are at -1 and 1 */
    x = x < 0 ? 0 : x > 1 ? 1 : x;
    z = z < 0 ? 0 : z > 1 ? 1 : z;
    const double expected = x + (1 - x) * z * 0.2;
    assert_true(fabs(rho[l] - (expected < 1 - 0x1p-20 ? expected : 1 - 0x1p-20)) < 1e-12);
  }

  rules.resistance = (scree_resistance){
      .kind = SCREE_RESISTANCE_NOISE, .value = 0.5, .amplitude = 0.4, .period = 1.7, .octaves = 3, .random_seed = 2};
  assert_int_equal(scree_frost_set_rules(f, &rules, NULL), SCREE_OK);
  rho = f->tables.resistance;
  double sum = 0, square = 0;
  for (uint32_t l = 0; l < v->link_count; ++l) {
    assert_true(rho[l] >= 0 && rho[l] < 1);
    sum += rho[l] - 0.5;
    square += (rho[l] - 0.5) * (rho[l] - 0.5);
  }
  assert_true(fabs(sum / v->link_count) < 0.05);
  assert_true(sqrt(square / v->link_count) > 0.05 && sqrt(square / v->link_count) < 0.3);
  scree_frost_destroy(f);
  scree_shards_destroy(shards);
}

/* --- mistakes ---------------------------------------------------------------------------------------------------------------- */

static void bad_rules_are_told_by_name(void** state) {
  (void)state;
  const uint32_t size[3] = {2, 2, 2};
  scree_shards* shards = make_lattice(size, 0, NULL);
  scree_frost_rules good, bad;
  scree_frost_rules_default(&good);
  scree_frost* f = must_freeze(shards, &good, NULL, 1);
  const double falling[4] = {1, 0.5, 0, 0.5};
  scree_error error;
#define BAD(change, result, name)                                                           \
  bad = good;                                                                               \
  bad.change;                                                                               \
  assert_int_equal(scree_frost_set_rules(f, &bad, &error), result);                         \
  if (strstr(error.message, name) == NULL) fail_msg("%s: no word of " name, error.message); \
  assert_int_equal(scree_frost_set_rules(f, &bad, NULL), result)
  BAD(rain_count = 5, SCREE_ERROR_RANGE, "rain_count");
  BAD(rains[0].direction[1] = 0, SCREE_ERROR_RANGE, "rains[0].direction");
  BAD(rains[0].direction[0] = INFINITY, SCREE_ERROR_RANGE, "rains[0].direction");
  BAD(rains[0].spread = 3.2, SCREE_ERROR_RANGE, "rains[0].spread");
  BAD(rains[0].spread = NAN, SCREE_ERROR_RANGE, "rains[0].spread");
  BAD(rains[0].weight = 0, SCREE_ERROR_RANGE, "rains[0].weight");
  BAD(rain_count = 2, SCREE_ERROR_RANGE, "rains[1].direction");
  BAD(water = 0, SCREE_ERROR_RANGE, "water");
  BAD(gravity[1] = 0, SCREE_ERROR_RANGE, "gravity");
  BAD(gravity[2] = NAN, SCREE_ERROR_RANGE, "gravity");
  BAD(resistance.kind = (scree_resistance_kind)5, SCREE_ERROR_RANGE, "resistance.kind");
  BAD(resistance.value = 1.5, SCREE_ERROR_RANGE, "resistance.value");
  BAD(resistance.kind = SCREE_RESISTANCE_FUNCTION, SCREE_ERROR_INVALID_ARGUMENT, "resistance.function");
  BAD(resistance.kind = SCREE_RESISTANCE_LAYERS, SCREE_ERROR_INVALID_ARGUMENT, "resistance.layers");
  BAD(resistance = ((scree_resistance){.kind = SCREE_RESISTANCE_LAYERS, .layers = falling, .layer_count = 2}), SCREE_ERROR_RANGE,
      "resistance.layers[1]");
  BAD(resistance = ((scree_resistance){.kind = SCREE_RESISTANCE_NOISE, .amplitude = 2}), SCREE_ERROR_RANGE, "resistance.amplitude");
  BAD(resistance = ((scree_resistance){.kind = SCREE_RESISTANCE_NOISE, .amplitude = 1}), SCREE_ERROR_RANGE, "resistance.period");
  BAD(resistance = ((scree_resistance){.kind = SCREE_RESISTANCE_NOISE, .octaves = 9}), SCREE_ERROR_RANGE, "resistance.octaves");
  BAD(resistance.kind = SCREE_RESISTANCE_IMAGES, SCREE_ERROR_INVALID_ARGUMENT, "resistance.images");
  BAD(resistance = ((scree_resistance){.kind = SCREE_RESISTANCE_IMAGES, .images = (const uint8_t*)"", .size = {1, 0, 1}}),
      SCREE_ERROR_RANGE, "resistance.size[1]");
  BAD(resistance =
          ((scree_resistance){.kind = SCREE_RESISTANCE_IMAGES, .images = (const uint8_t*)"", .size = {1, 1, 1}, .max = {1, 1, 0}}),
      SCREE_ERROR_RANGE, "resistance.max[2]");
  BAD(solid_absorption = -1, SCREE_ERROR_RANGE, "solid_absorption");
  BAD(air_absorption = NAN, SCREE_ERROR_RANGE, "air_absorption");
  BAD(resistance_absorption = -1, SCREE_ERROR_RANGE, "resistance_absorption");
  BAD(damage = INFINITY, SCREE_ERROR_RANGE, "damage");
  BAD(break_life = 2, SCREE_ERROR_RANGE, "break_life");
  BAD(break_chance = -0.1, SCREE_ERROR_RANGE, "break_chance");
  BAD(fall = (scree_fall)2, SCREE_ERROR_RANGE, "fall");
  BAD(fall_life = 1.1, SCREE_ERROR_RANGE, "fall_life");
  BAD(density = -1, SCREE_ERROR_RANGE, "density");
  BAD(strength = -1, SCREE_ERROR_RANGE, "strength");
  BAD(compression = 0.5, SCREE_ERROR_RANGE, "compression");
  BAD(stability_interval = 0, SCREE_ERROR_RANGE, "stability_interval");
#undef BAD
  scree_frost* other;
  scree_frost_desc desc = {.rules = good};
  assert_int_equal(scree_frost_create(&desc, &other, &error), SCREE_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "shards"));
  const uint8_t states[8] = {0, 1, 2, 3};
  desc = (scree_frost_desc){.shards = shards, .rules = good, .states = states};
  assert_int_equal(scree_frost_create(&desc, &other, &error), SCREE_ERROR_RANGE);
  assert_non_null(strstr(error.message, "states[3]"));
  desc.states = NULL;
  desc.rules.water = -1;
  assert_int_equal(scree_frost_create(&desc, &other, &error), SCREE_ERROR_RANGE);
  assert_null(other);
  scree_frost_destroy(NULL);
  scree_frost_destroy(f);
  scree_shards_destroy(shards);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(resistances_are_those_of_their_places),
      cmocka_unit_test(bad_rules_are_told_by_name),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
