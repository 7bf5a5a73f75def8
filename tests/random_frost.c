#include "random_frost.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static uint32_t draw(random_stream* stream, uint32_t count) {
  return (uint32_t)(random_unit(stream) * count);
}

/* Beds of unlike hardness, some places of them no number. */
static void by_place(void* user, const double* places, double* resistance, uint32_t count) {
  (void)user;
  for (uint32_t i = 0; i < count; ++i) {
    const double *at = places + 3 * (size_t)i, sum = at[0] + 2 * at[1] + 3 * at[2];
    resistance[i] = sum > 9 ? NAN : sum - floor(sum);
  }
}

void random_frost_rules(random_stream* stream, scree_frost_rules* out) {
  static const uint8_t images[3 * 4 * 2] = {0,  255, 30, 200, 90, 10, 250, 60, 120, 77, 3,   140,
                                            40, 20,  80, 160, 5,  99, 201, 13, 255, 0,  128, 64};
  static const double layers[8] = {0, 0.2, 1.5, 0.9, 1.5, 0.1, 4, 1};
  scree_frost_rules_default(out);
  out->rain_count = 1 + draw(stream, SCREE_FROST_RAINS);
  for (uint32_t i = 0; i < out->rain_count; ++i) {
    scree_rain* rain = &out->rains[i];
    random_direction(stream, rain->direction);
    rain->spread = draw(stream, 4) == 0 ? 0 : random_unit(stream) * (draw(stream, 2) == 0 ? 0.5 : 3.14159);
    rain->weight = 0.1 + random_unit(stream);
  }
  if (draw(stream, 2) == 0) out->rains[0] = (scree_rain){{0, -2, 0}, 0.5, 1};
  if (draw(stream, 3) == 0) random_direction(stream, out->gravity);
  out->water = 0.5 + random_unit(stream);
  scree_resistance* r = &out->resistance;
  r->kind = (scree_resistance_kind)draw(stream, SCREE_RESISTANCE_IMAGES + 1);
  r->function = by_place;
  r->images = images;
  r->size[0] = 3;
  r->size[1] = 4;
  r->size[2] = 2;
  if (draw(stream, 2) == 0)
    for (int a = 0; a < 3; ++a) r->max[a] = 4; /* else the shards' box */
  r->value = draw(stream, 5) == 0 ? 1 : random_unit(stream);
  r->amplitude = random_unit(stream);
  r->period = 0.5 + 3 * random_unit(stream);
  r->octaves = draw(stream, 4);
  r->random_seed = random_bits(stream);
  r->layers = layers;
  r->layer_count = 4;
  if (draw(stream, 2) == 0) random_direction(stream, r->up);
  out->solid_absorption = 0.3 * random_unit(stream);
  out->air_absorption = draw(stream, 4) == 0 ? 0 : 0.1 * random_unit(stream);
  out->resistance_absorption = 0.5 * random_unit(stream);
  out->damage = 0.2 + 2 * random_unit(stream);
  out->total_absorption = draw(stream, 2) == 0;
  out->break_life = draw(stream, 4) == 0 ? 0 : random_unit(stream);
  out->break_chance = random_unit(stream);
  out->fall = draw(stream, 4) == 0 ? SCREE_FALL_GONE : SCREE_FALL_KEPT;
  out->fall_life = draw(stream, 3) == 0 ? 1 : draw(stream, 2) == 0 ? 0 : random_unit(stream);
}

void random_frost_states(random_stream* stream, uint32_t count, uint8_t* out) {
  const uint32_t core = draw(stream, 3) == 0 ? 2 + draw(stream, 20) : 0, air = draw(stream, 3) == 0 ? 2 + draw(stream, 20) : 0;
  for (uint32_t s = 0; s < count; ++s) {
    out[s] = SCREE_SHARD_SOLID;
    if (core > 0 && draw(stream, core) == 0) out[s] = SCREE_SHARD_CORE;
    if (air > 0 && draw(stream, air) == 0) out[s] = SCREE_SHARD_AIR;
  }
}

scree_frost* must_freeze(const scree_shards* shards, const scree_frost_rules* rules, const uint8_t* states, uint64_t random_seed) {
  const scree_frost_desc desc = {.shards = shards, .rules = *rules, .states = states, .random_seed = random_seed};
  scree_frost* frost = NULL;
  scree_error error;
  if (scree_frost_create(&desc, &frost, &error) != SCREE_OK) fail_msg("%s", error.message);
  return frost;
}
