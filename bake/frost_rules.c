/* What rules may say. */
#include <string.h>

#include "faults.h"
#include "frost_internal.h"
#include "support_text.h"

void scree_frost_rules_default(scree_frost_rules* out) {
  *out = (scree_frost_rules){
      .rains = {{.direction = {0, -1, 0}, .spread = 0.5, .weight = 1}},
      .rain_count = 1,
      .water = 1,
      .gravity = {0, -1, 0},
      .resistance = {.kind = SCREE_RESISTANCE_CONSTANT, .value = 0.5},
      .solid_absorption = 0.1,
      .air_absorption = 0.05,
      .resistance_absorption = 0.25,
      .damage = 0.5,
      .total_absorption = true,
      .break_life = 0.4,
      .break_chance = 0.9,
      .fall = SCREE_FALL_KEPT,
      .fall_life = 1,
      .density = 2600,
      .strength = 0,
      .compression = 10,
      .stability_interval = 64,
  };
}

/* --- messages ---------------------------------------------------------------------------------------------------------------- */

/* Where in the rules something is wrong: "name[index].part", index UINT32_MAX for what is no array. */
typedef struct place {
  const char* name;
  uint32_t index;
  const char* part;
} place;

static void say_place(scree_error* error, place at) {
  scree_rt_text_clear(error);
  scree_rt_text_add(error, at.name);
  if (at.index != UINT32_MAX) {
    scree_rt_text_add(error, "[");
    scree_rt_text_add_count(error, at.index);
    scree_rt_text_add(error, "]");
  }
  scree_rt_text_add(error, at.part);
  scree_rt_text_add(error, ": ");
}

static scree_result wrong(scree_error* error, place at, double value, const char* what) {
  say_place(error, at);
  return fault_add(error, value, what);
}

static scree_result missing(scree_error* error, const char* name, const char* what) {
  say_place(error, (place){name, UINT32_MAX, ""});
  scree_rt_text_add(error, what);
  return SCREE_ERROR_INVALID_ARGUMENT;
}

/* --- checks ------------------------------------------------------------------------------------------------------------------ */

bool frost_unit(const double v[3], double out[3]) {
  double most = 0;
  for (int a = 0; a < 3; ++a) {
    if (!within(v[a], -1e300, 1e300)) return false;
    most = fabs(v[a]) > most ? fabs(v[a]) : most;
  }
  if (!(most > 1e-300)) return false;
  for (int a = 0; a < 3; ++a) out[a] = v[a] / most; /* no overflow in the squares */
  const double length = sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
  for (int a = 0; a < 3; ++a) out[a] /= length;
  return true;
}

static scree_result check_direction(scree_error* error, place at, const double v[3]) {
  double unit[3];
  if (frost_unit(v, unit)) return SCREE_OK;
  say_place(error, at);
  scree_rt_text_add(error, "no direction: must be finite and not all 0");
  return SCREE_ERROR_RANGE;
}

static scree_result check_rains(const scree_frost_rules* rules, scree_error* error) {
  if (rules->rain_count > SCREE_FROST_RAINS)
    return wrong(error, (place){"rain_count", UINT32_MAX, ""}, rules->rain_count, "0 to 4");
  for (uint32_t i = 0; i < rules->rain_count; ++i) {
    const scree_rain* rain = &rules->rains[i];
    const scree_result result = check_direction(error, (place){"rains", i, ".direction"}, rain->direction);
    if (result != SCREE_OK) return result;
    if (!within(rain->spread, 0, 3.14159265358979323846))
      return wrong(error, (place){"rains", i, ".spread"}, rain->spread, "0 to pi radians");
    if (!within(rain->weight, 1e-9, 1e9)) return wrong(error, (place){"rains", i, ".weight"}, rain->weight, "1e-9 to 1e9");
  }
  return SCREE_OK;
}

static scree_result check_noise(const scree_resistance* r, scree_error* error) {
  if (!within(r->amplitude, 0, 1)) return wrong(error, (place){"resistance.amplitude", UINT32_MAX, ""}, r->amplitude, "0 to 1");
  if (r->amplitude > 0 && !within(r->period, 1e-6, 1e9))
    return wrong(error, (place){"resistance.period", UINT32_MAX, ""}, r->period, "1e-6 to 1e9");
  if (r->octaves > 8) return wrong(error, (place){"resistance.octaves", UINT32_MAX, ""}, r->octaves, "1 to 8, or 0 for 1");
  return SCREE_OK;
}

static scree_result check_layers(const scree_resistance* r, scree_error* error) {
  if (r->layers == NULL || r->layer_count == 0) return missing(error, "resistance.layers", "there are none");
  const bool given = r->up[0] != 0 || r->up[1] != 0 || r->up[2] != 0;
  if (given) {
    const scree_result result = check_direction(error, (place){"resistance.up", UINT32_MAX, ""}, r->up);
    if (result != SCREE_OK) return result;
  }
  for (uint32_t i = 0; i < r->layer_count; ++i) {
    const double* layer = r->layers + 2 * (size_t)i;
    if (!within(layer[0], i > 0 ? layer[-2] : -1e9, 1e9))
      return wrong(error, (place){"resistance.layers", i, ""}, layer[0], "-1e9 to 1e9 and not below that of the point before");
    if (!within(layer[1], 0, 1)) return wrong(error, (place){"resistance.layers", i, ".value"}, layer[1], "0 to 1");
  }
  return SCREE_OK;
}

static scree_result check_images(const scree_resistance* r, scree_error* error) {
  if (r->images == NULL) return missing(error, "resistance.images", "there are none");
  bool given = false;
  for (int a = 0; a < 3; ++a) {
    if (r->size[a] == 0 || r->size[a] > 65536)
      return wrong(error, (place){"resistance.size", (uint32_t)a, ""}, r->size[a], "1 to 65536");
    given = given || r->min[a] != 0 || r->max[a] != 0;
  }
  for (int a = 0; a < 3 && given; ++a)
    if (!within(r->min[a], -1e9, 1e9) || !within(r->max[a], -1e9, 1e9) || !(r->max[a] > r->min[a]))
      return wrong(error, (place){"resistance.max", (uint32_t)a, ""}, r->max[a], "more than min, up to 1e9");
  return SCREE_OK;
}

static scree_result check_resistance(const scree_resistance* r, scree_error* error) {
  if ((uint32_t)r->kind > SCREE_RESISTANCE_IMAGES)
    return wrong(error, (place){"resistance.kind", UINT32_MAX, ""}, (double)r->kind, "no such kind");
  if (r->kind == SCREE_RESISTANCE_FUNCTION && r->function == NULL) return missing(error, "resistance.function", "there is none");
  const bool value = r->kind == SCREE_RESISTANCE_CONSTANT || r->kind == SCREE_RESISTANCE_NOISE;
  if (value && !within(r->value, 0, 1)) return wrong(error, (place){"resistance.value", UINT32_MAX, ""}, r->value, "0 to 1");
  if (r->kind == SCREE_RESISTANCE_NOISE || r->kind == SCREE_RESISTANCE_LAYERS) {
    const scree_result result = check_noise(r, error);
    if (result != SCREE_OK) return result;
  }
  if (r->kind == SCREE_RESISTANCE_LAYERS) return check_layers(r, error);
  if (r->kind == SCREE_RESISTANCE_IMAGES) return check_images(r, error);
  return SCREE_OK;
}

scree_result frost_check_rules(const scree_frost_rules* rules, scree_error* error) {
  scree_result result = check_rains(rules, error);
  if (result == SCREE_OK) result = check_direction(error, (place){"gravity", UINT32_MAX, ""}, rules->gravity);
  if (result == SCREE_OK) result = check_resistance(&rules->resistance, error);
  if (result != SCREE_OK) return result;
  const struct {
    const char* name;
    double value, low, high;
    const char* what;
  } numbers[] = {
      {"water", rules->water, 1e-9, 1e9, "1e-9 to 1e9"},
      {"solid_absorption", rules->solid_absorption, 0, 1e9, "0 to 1e9"},
      {"air_absorption", rules->air_absorption, 0, 1e9, "0 to 1e9"},
      {"resistance_absorption", rules->resistance_absorption, 0, 1e9, "0 to 1e9"},
      {"damage", rules->damage, 0, 1e9, "0 to 1e9"},
      {"break_life", rules->break_life, 0, 1, "0 to 1"},
      {"break_chance", rules->break_chance, 0, 1, "0 to 1"},
      {"fall", (double)(uint32_t)rules->fall, 0, SCREE_FALL_KEPT, "no such kind"},
      {"fall_life", rules->fall_life, 0, 1, "0 to 1"},
      {"density", rules->density, 0, 1e9, "0 to 1e9 kg per cubic metre"},
      {"strength", rules->strength, 0, 1e15, "0 to 1e15 pascals"},
      {"compression", rules->compression, 1, 1e9, "1 to 1e9"},
      {"stability_interval", rules->stability_interval, 1, UINT32_MAX, "at least 1"},
  };
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i)
    if (!within(numbers[i].value, numbers[i].low, numbers[i].high))
      return wrong(error, (place){numbers[i].name, UINT32_MAX, ""}, numbers[i].value, numbers[i].what);
  return SCREE_OK;
}
