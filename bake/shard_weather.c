#include "shard_weather.h"

#include <math.h>
#include <string.h>

#include "convex_walls.h"
#include "lattice.h"
#include "recipe_text.h"
#include "shard_keys.h"
#include "shards_internal.h"
#include "solid_internal.h"

uint32_t shard_times(const scree_shard_recipe* recipe) {
  return recipe->path_count > 0 ? recipe->path_count : recipe->share_count;
}

static scree_result tell(scree_result result, const char* where, const scree_error* fault, scree_error* error) {
  if (result != SCREE_OK && fault->message[0] != '\0') recipe_say(error, "%s%.400s", where, fault->message);
  return result;
}

/* Puts the key, and the file where there is one, before what is wrong with the solid. */
static scree_result tell_input(const scree_shard_recipe* recipe, scree_result result, const scree_error* fault,
                               scree_error* error) {
  const scree_shard_shape shape = recipe->input.shape;
  const bool is_file = shape == SCREE_SHARD_MESH || shape == SCREE_SHARD_TERRAIN || shape == SCREE_SHARD_HOODOO;
  const char* file = is_file ? recipe->input.file : "";
  if (result != SCREE_OK && fault->message[0] != '\0')
    recipe_say(error, "input: %.200s%s%.400s", file, file[0] != '\0' ? ": " : "", fault->message);
  return result;
}

/* Packs keep the solid's own triangles: walls cut by themselves only where each plane is one triangle. */
static scree_result choose_clip(const scree_shard_desc* desc, const scree_solid* solid, scree_clip* clip) {
  *clip = desc->recipe->clip;
  if (*clip != SCREE_CLIP_AUTO) return SCREE_OK;
  if (!convex_walls_possible(solid->positions, solid->vertex_count, solid->indices, solid->triangle_count)) return SCREE_OK;
  const scree_allocator allocator = scree_rt_allocator_or_default(&desc->allocator);
  convex_walls walls;
  const scree_result result =
      convex_walls_create(solid->positions, solid->vertex_count, solid->indices, solid->triangle_count, &allocator, &walls, NULL);
  if (result != SCREE_OK) return result;
  if (walls.wall_count < solid->triangle_count) *clip = SCREE_CLIP_MESH;
  convex_walls_free(&walls, &allocator);
  return SCREE_OK;
}

/* Points that are all beside the solid leave it nearly whole: a mistake of units or of the place. */
static scree_result check_points(const scree_seed_pattern* pattern, const scree_solid* solid, scree_error* error) {
  double low[3], high[3];
  solid_bounds(solid, low, high);
  for (uint32_t i = 0; i < pattern->point_count; ++i) {
    bool within = true;
    for (uint32_t a = 0; a < 3; ++a)
      within = within && pattern->points[3 * (size_t)i + a] >= low[a] && pattern->points[3 * (size_t)i + a] <= high[a];
    if (within) return SCREE_OK;
  }
  recipe_say(error, "seeds.points: none of %u lies in the box of the input, (%g, %g, %g) .. (%g, %g, %g) m", pattern->point_count,
             low[0], low[1], low[2], high[0], high[1], high[2]);
  return SCREE_ERROR_RANGE;
}

static scree_result split(shard_weather* weather, const scree_solid* solid,
                          bool (*progress)(void* user, const char* stage, double done), void* user, scree_error* error) {
  const scree_shard_desc* desc = weather->desc;
  const scree_shard_recipe* recipe = desc->recipe;
  scree_error fault = {{0}};
  scree_seed_pattern pattern;
  scree_shard_seeds_view(recipe, &pattern);
  if (pattern.kind == SCREE_SEEDS_RANDOM && pattern.count == 0) {
    const double count = floor(solid_volume6(solid) / 6 / (pattern.spacing * pattern.spacing * pattern.spacing) + 0.5);
    if (!(count <= 1e6)) {
      recipe_say(error, "seeds.spacing: %g metres make %.0f seeds; expected at most 1000000", pattern.spacing, count);
      return SCREE_ERROR_RANGE;
    }
    pattern.count = count >= 1 ? (uint32_t)count : 1;
  }
  scree_clip clip;
  scree_result result = pattern.kind == SCREE_SEEDS_POINTS ? check_points(&pattern, solid, error) : SCREE_OK;
  if (result == SCREE_OK) result = choose_clip(desc, solid, &clip);
  if (result != SCREE_OK) return result;
  double* seeds = NULL;
  uint32_t count = 0;
  result = scree_seeds_create(&pattern, solid, &desc->allocator, &seeds, &count, &fault);
  if (result != SCREE_OK) return tell(result, "", &fault, error); /* which says "seeds:" itself */
  const scree_shards_desc shards = {.solid = *solid,
                                    .seeds = seeds,
                                    .seed_count = count,
                                    .stretch = recipe->seeds.stretch,
                                    .up = recipe->seeds.up,
                                    .clip = clip,
                                    .link_angle = recipe->link_angle,
                                    .jobs = desc->jobs,
                                    .allocator = desc->allocator,
                                    .progress = progress,
                                    .progress_user = user};
  result = scree_shards_create(&shards, &weather->shards, &fault);
  scree_seeds_free(&desc->allocator, seeds, count);
  if (result == SCREE_ERROR_UNSUPPORTED) result = SCREE_ERROR_INVALID_ARGUMENT; /* of this solid, not by this build */
  return tell_input(recipe, result, &fault, error);
}

scree_result shard_weather_create(const scree_shard_desc* desc, bool (*progress)(void* user, const char* stage, double done),
                                  void* user, shard_weather* out, scree_error* error) {
  memset(out, 0, sizeof *out);
  out->desc = desc;
  out->rules = desc->recipe->rules;
  scree_solid_memory solid;
  scree_result result = scree_shard_solid_make(desc, &solid, error);
  if (result != SCREE_OK) return result;
  result = split(out, &solid.solid, progress, user, error);
  scree_solid_free(&desc->allocator, &solid);
  return result;
}

static bool lacks(const scree_shard_desc* desc, scree_resistance_kind kind) {
  return (kind == SCREE_RESISTANCE_IMAGES && desc->images == NULL) ||
         (kind == SCREE_RESISTANCE_FUNCTION && desc->resistance == NULL);
}

static scree_result not_given(const scree_shard_desc* desc, scree_error* error) {
  const scree_shard_recipe* recipe = desc->recipe;
  bool missing = lacks(desc, recipe->rules.frost.resistance.kind);
  for (uint32_t p = 0; p < recipe->phase_count; ++p)
    missing = missing || ((recipe->phases[p].changes & SCREE_SHARD_RESISTANCE) != 0 &&
                          lacks(desc, recipe->phases[p].rules.frost.resistance.kind));
  if (!missing) return SCREE_OK;
  recipe_say(error, "resistance.kind: images need images.file, and a function can only come from a program: neither was given");
  return SCREE_ERROR_INVALID_ARGUMENT;
}

scree_result shard_weather_start(shard_weather* weather, scree_error* error) {
  const scree_shard_desc* desc = weather->desc;
  const scree_allocator allocator = scree_rt_allocator_or_default(&desc->allocator);
  scree_error fault = {{0}};
  scree_shards_view view;
  scree_result result = not_given(desc, error);
  if (result != SCREE_OK) return result;
  scree_shards_get(weather->shards, &view);
  uint8_t* states = scree_rt_allocate(&allocator, view.shard_count, 1);
  if (states == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  weather->idle_states = scree_shard_states(desc->recipe, weather->shards, states);
  scree_frost_desc frost = {.shards = weather->shards,
                            .states = states,
                            .random_seed = hash_mix(desc->recipe->random_seed ^ UINT64_C(0x66726f7374)),
                            .allocator = desc->allocator};
  scree_shard_rules_view(desc, &weather->rules, &frost.rules);
  result = scree_frost_create(&frost, &weather->frost, &fault);
  scree_rt_release(&allocator, states, view.shard_count, 1);
  return tell(result, "rules: ", &fault, error);
}

void shard_weather_destroy(shard_weather* weather) {
  scree_frost_destroy(weather->frost);
  scree_shards_destroy(weather->shards);
  memset(weather, 0, sizeof *weather);
}

/* Whether a moment has come: a share of the volume, or paths where it is below 0. */
static bool has_come(const scree_frost_stats* stats, double share, uint32_t paths) {
  return share < 0 ? stats->paths >= paths : stats->volume <= share * stats->start_volume;
}

static void change_rules(scree_frost_rules* rules, const scree_shard_phase* phase) {
  const scree_frost_rules* from = &phase->rules.frost;
  if (phase->changes & SCREE_SHARD_RAINS) {
    memcpy(rules->rains, from->rains, sizeof rules->rains);
    rules->rain_count = from->rain_count;
  }
  if (phase->changes & SCREE_SHARD_WATER) rules->water = from->water;
  if (phase->changes & SCREE_SHARD_GRAVITY) memcpy(rules->gravity, from->gravity, sizeof rules->gravity);
  if (phase->changes & SCREE_SHARD_RESISTANCE) rules->resistance = from->resistance;
  if (phase->changes & SCREE_SHARD_ABSORPTION) {
    rules->solid_absorption = from->solid_absorption;
    rules->air_absorption = from->air_absorption;
    rules->resistance_absorption = from->resistance_absorption;
    rules->total_absorption = from->total_absorption;
  }
  if (phase->changes & SCREE_SHARD_DAMAGE) rules->damage = from->damage;
  if (phase->changes & SCREE_SHARD_BREAKAGE) {
    rules->break_life = from->break_life;
    rules->break_chance = from->break_chance;
  }
  if (phase->changes & SCREE_SHARD_FALL) rules->fall = from->fall;
  if (phase->changes & SCREE_SHARD_FALL_LIFE) rules->fall_life = from->fall_life;
  if (phase->changes & SCREE_SHARD_STABILITY) {
    rules->density = from->density;
    rules->strength = from->strength;
    rules->compression = from->compression;
    rules->stability_interval = from->stability_interval;
  }
}

/* Begins the phases whose moment has come. dry_until: where nothing takes water, paths pass without a change up to so many. */
static scree_result begin_phases(shard_weather* weather, const scree_frost_stats* stats, uint32_t dry_until, bool* begun,
                                 scree_error* error) {
  const scree_shard_recipe* recipe = weather->desc->recipe;
  const uint32_t before = weather->next_phase;
  for (; weather->next_phase < recipe->phase_count; ++weather->next_phase) {
    const scree_shard_phase* phase = &recipe->phases[weather->next_phase];
    if (!has_come(stats, phase->share, phase->paths) && !(stats->dry && phase->share < 0 && phase->paths <= dry_until)) break;
    change_rules(&weather->rules.frost, phase);
    if (phase->changes & SCREE_SHARD_RESISTANCE) memcpy(weather->rules.layers, phase->rules.layers, sizeof phase->rules.layers);
  }
  *begun = weather->next_phase != before;
  if (!*begun) return SCREE_OK;
  scree_frost_rules rules;
  scree_shard_rules_view(weather->desc, &weather->rules, &rules);
  scree_error fault = {{0}};
  const scree_result result = scree_frost_set_rules(weather->frost, &rules, &fault);
  if (result != SCREE_OK) recipe_say(error, "phases[%u]: %.400s", weather->next_phase - 1, fault.message);
  return result;
}

scree_result shard_weather_advance(shard_weather* weather, uint32_t time, bool (*progress)(void* user, double done), void* user,
                                   scree_frost_stats* stats, scree_error* error) {
  const scree_shard_recipe* recipe = weather->desc->recipe;
  const double share = recipe->path_count > 0 ? -1 : recipe->shares[time];
  const uint32_t paths = recipe->path_count > 0 ? recipe->paths[time] : recipe->max_paths;
  for (bool begun = false;;) {
    scree_frost_get_stats(weather->frost, stats);
    scree_result result = begin_phases(weather, stats, paths, &begun, error);
    if (result != SCREE_OK) return result;
    if (stats->solid + stats->core == 0) {
      recipe_say(error, "%s[%u]: nothing stands after %llu paths", share < 0 ? "paths" : "shares", time,
                 (unsigned long long)stats->paths);
      return SCREE_ERROR_INVALID_ARGUMENT;
    }
    if (has_come(stats, share, paths)) return SCREE_OK;
    const bool stuck = stats->dry && !begun;
    if (stuck && share < 0) return SCREE_OK; /* nothing changes any more */
    if (stuck || stats->paths >= paths) {
      recipe_say(error, "shares[%u]: %g is not reached %s: a share of %.3f stands after %llu paths", time, share,
                 stuck ? "because no link takes water" : "in max_paths", stats->volume / stats->start_volume,
                 (unsigned long long)stats->paths);
      return SCREE_ERROR_RANGE;
    }
    double next_share = share < 0 ? 0 : share;
    uint64_t next_paths = paths;
    if (weather->next_phase < recipe->phase_count) {
      const scree_shard_phase* phase = &recipe->phases[weather->next_phase];
      if (phase->share < 0 && phase->paths < next_paths) next_paths = phase->paths;
      if (phase->share > next_share) next_share = phase->share;
    }
    result = scree_frost_run(weather->frost, next_share, next_paths - stats->paths, progress, user);
    if (result != SCREE_OK) return result;
  }
}

void shard_weather_rubble(const shard_weather* weather, scree_rubble_desc* out) {
  const scree_shard_recipe* recipe = weather->desc->recipe;
  const scree_shard_rubble* rules = &recipe->rubble;
  *out = (scree_rubble_desc){.frost = weather->frost,
                             .ground = rules->ground,
                             .resolution = rules->resolution,
                             .repose = rules->repose,
                             .min_volume = rules->min_volume,
                             .share = rules->share,
                             .reach = rules->reach,
                             .random_seed = hash_mix(recipe->random_seed ^ UINT64_C(0x727562626c65))}; /* "rubble" */
}
