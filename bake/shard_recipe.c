/* Recipes of shards: the tables of keys, defaults, and the rules between keys. The reader and the writer go by the tables
 * (shard_text.c), so that they cannot disagree; content/schema/shards.schema.json is held against them by a test. */
#include <stdio.h>
#include <string.h>

#include "lattice.h"
#include "recipe_text.h"
#include "shard_keys.h"

#define AT(type, member) .offset = offsetof(type, member)
#define ENDS(low, high) .min = (low), .max = (high)
#define FAR 1e5 /* how far anything is from the origin, metres */

#define SHAPE(name) (1u << SCREE_SHARD_##name)
#define SMOOTH (SHAPE(SPHERE) | SHAPE(CONE) | SHAPE(CAPSULE))
static const shard_key input_keys[] = {
    {"shape", SHARD_CHOICE, AT(scree_shard_input, shape), ENDS(0, 8),
     .words = "box hill sphere cone capsule mesh terrain hoodoo support"},
    {"size", SHARD_NUMBERS, AT(scree_shard_input, size), ENDS(0.01, FAR), .size = 3, .only = SHAPE(BOX)},
    {"radius", SHARD_NUMBER, AT(scree_shard_input, radius), ENDS(0.01, FAR), .only = SMOOTH | SHAPE(HILL)},
    {"height", SHARD_NUMBER, AT(scree_shard_input, height), ENDS(0.01, FAR), .only = SHAPE(HILL) | SHAPE(CONE) | SHAPE(CAPSULE)},
    {"top", SHARD_NUMBER, AT(scree_shard_input, top), ENDS(0.01, 1), .only = SHAPE(HILL)},
    {"bulge", SHARD_NUMBER, AT(scree_shard_input, bulge), ENDS(0, 1), .only = SHAPE(HILL)},
    {"rings", SHARD_COUNT, AT(scree_shard_input, rings), ENDS(1, 16), .only = SHAPE(HILL)},
    {"sides", SHARD_COUNT, AT(scree_shard_input, sides), ENDS(3, 64), .only = SHAPE(HILL)},
    {"noise", SHARD_NUMBER, AT(scree_shard_input, noise), ENDS(0, 1e4), .only = SMOOTH | SHAPE(BOX)},
    {"wavelength", SHARD_NUMBER, AT(scree_shard_input, wavelength), ENDS(0.01, FAR), .only = SMOOTH | SHAPE(BOX)},
    {"octaves", SHARD_COUNT, AT(scree_shard_input, octaves), ENDS(1, 8), .only = SMOOTH | SHAPE(BOX)},
    {"resolution", SHARD_COUNT, AT(scree_shard_input, resolution), ENDS(0, 512),
     .only = SMOOTH | SHAPE(BOX) | SHAPE(MESH) | SHAPE(SUPPORT)},
    {"file", SHARD_TEXT, AT(scree_shard_input, file), ENDS(0, 255), .only = SHAPE(MESH) | SHAPE(TERRAIN) | SHAPE(HOODOO)},
    {"scale", SHARD_NUMBER, AT(scree_shard_input, scale), ENDS(1e-6, 1e6), .only = SHAPE(MESH)},
    {"position", SHARD_NUMBERS, AT(scree_shard_input, position), ENDS(-FAR, FAR), .size = 3, .only = SHAPE(MESH)},
    {"spacing", SHARD_NUMBER, AT(scree_shard_input, spacing), ENDS(0.001, 1e4), .only = SHAPE(TERRAIN)},
    {"low", SHARD_NUMBER, AT(scree_shard_input, low), ENDS(-FAR, FAR), .only = SHAPE(TERRAIN)},
    {"high", SHARD_NUMBER, AT(scree_shard_input, high), ENDS(-FAR, FAR), .only = SHAPE(TERRAIN)},
    {"crop", SHARD_COUNTS, AT(scree_shard_input, crop), ENDS(0, 8192), .size = 4, .only = SHAPE(TERRAIN)},
    {"base", SHARD_NUMBER, AT(scree_shard_input, base), ENDS(-FAR, FAR), .only = SHAPE(TERRAIN)},
    {"variant", SHARD_COUNT, AT(scree_shard_input, variant), ENDS(0, SCREE_HOODOO_VARIANTS - 1), .only = SHAPE(HOODOO)},
    {"age", SHARD_COUNT, AT(scree_shard_input, age), ENDS(0, SCREE_HOODOO_AGES - 1), .only = SHAPE(HOODOO)},
    {"lod", SHARD_COUNT, AT(scree_shard_input, lod), ENDS(0, 5), .only = SHAPE(HOODOO)},
    {0},
};

#define PATTERN(name) (1u << SCREE_SEEDS_##name)
static const shard_key place_keys[] = {
    {"x", SHARD_NUMBER, .offset = 0, ENDS(-FAR, FAR)},
    {"y", SHARD_NUMBER, .offset = sizeof(double), ENDS(-FAR, FAR)},
    {"z", SHARD_NUMBER, .offset = 2 * sizeof(double), ENDS(-FAR, FAR)},
    {0},
};
static const shard_key seed_keys[] = {
    {"pattern", SHARD_CHOICE, AT(scree_shard_seeds, kind), ENDS(0, 5), .words = "random grid columns slabs poisson points"},
    {"count", SHARD_COUNT, AT(scree_shard_seeds, count), ENDS(0, 1e6), .only = ~PATTERN(POINTS)},
    {"spacing", SHARD_NUMBER, AT(scree_shard_seeds, spacing), ENDS(1e-3, FAR), .only = ~PATTERN(POINTS)},
    {"spacing_end", SHARD_NUMBER, AT(scree_shard_seeds, spacing_end), ENDS(0, FAR), .only = PATTERN(POISSON)},
    {"grade", SHARD_NUMBERS, AT(scree_shard_seeds, grade), ENDS(-1, 1), .size = 3, .only = PATTERN(POISSON)},
    {"length", SHARD_NUMBER, AT(scree_shard_seeds, length), ENDS(0, FAR), .only = PATTERN(COLUMNS)},
    {"layers", SHARD_VALUES, AT(scree_shard_seeds, layers), ENDS(1e-3, FAR), .count_at = offsetof(scree_shard_seeds, layer_count),
     .stride = sizeof(double), .size = SCREE_SHARD_LAYERS, .only = PATTERN(SLABS)},
    {"jitter", SHARD_NUMBER, AT(scree_shard_seeds, jitter), ENDS(0, 1), .only = PATTERN(GRID) | PATTERN(COLUMNS) | PATTERN(SLABS)},
    {"up", SHARD_NUMBERS, AT(scree_shard_seeds, up), ENDS(-1, 1), .size = 3},
    {"stretch", SHARD_NUMBERS, AT(scree_shard_seeds, stretch), ENDS(0.01, 100), .size = 3},
    {"points", SHARD_ROWS, AT(scree_shard_seeds, points), .members = place_keys,
     .count_at = offsetof(scree_shard_seeds, point_count), .stride = 3 * sizeof(double), .least = 1, .size = SCREE_SHARD_POINTS,
     .only = PATTERN(POINTS)},
    {"random_seed", SHARD_SEED, AT(scree_shard_seeds, random_seed), ENDS(0, 9007199254740992.0)},
    {0},
};

static const shard_key rain_keys[] = {
    {"direction", SHARD_NUMBERS, AT(scree_rain, direction), ENDS(-1, 1), .size = 3},
    {"spread", SHARD_NUMBER, AT(scree_rain, spread), ENDS(0, 3.141592653589793)},
    {"weight", SHARD_NUMBER, AT(scree_rain, weight), ENDS(1e-6, 1e6)},
    {0},
};

#define KIND(name) (1u << SCREE_RESISTANCE_##name)
static const shard_key bed_keys[] = {
    {"place", SHARD_NUMBER, .offset = 0, ENDS(-FAR, FAR)},
    {"value", SHARD_NUMBER, .offset = sizeof(double), ENDS(0, 1)},
    {0},
};
/* Of scree_shard_rules. */
#define RULE(member) .offset = offsetof(scree_shard_rules, frost.member)
static const shard_key resistance_keys[] = {
    {"kind", SHARD_CHOICE, RULE(resistance.kind), ENDS(0, 4), .words = "constant function noise layers images"},
    {"value", SHARD_NUMBER, RULE(resistance.value), ENDS(0, 1), .only = KIND(CONSTANT) | KIND(NOISE)},
    {"amplitude", SHARD_NUMBER, RULE(resistance.amplitude), ENDS(0, 1), .only = KIND(NOISE) | KIND(LAYERS)},
    {"period", SHARD_NUMBER, RULE(resistance.period), ENDS(1e-3, FAR), .only = KIND(NOISE) | KIND(LAYERS)},
    {"octaves", SHARD_COUNT, RULE(resistance.octaves), ENDS(1, 8), .only = KIND(NOISE) | KIND(LAYERS)},
    {"random_seed", SHARD_SEED, RULE(resistance.random_seed), ENDS(0, 9007199254740992.0), .only = KIND(NOISE) | KIND(LAYERS)},
    {"up", SHARD_NUMBERS, RULE(resistance.up), ENDS(-1, 1), .size = 3, .only = KIND(LAYERS)},
    {"layers", SHARD_ROWS, AT(scree_shard_rules, layers), .members = bed_keys,
     .count_at = offsetof(scree_shard_rules, frost.resistance.layer_count), .stride = 2 * sizeof(double), .least = 1,
     .size = SCREE_SHARD_LAYERS, .only = KIND(LAYERS)},
    {0},
};
static const shard_key absorption_keys[] = {
    {"solid", SHARD_NUMBER, RULE(solid_absorption), ENDS(0, 1e3)},
    {"air", SHARD_NUMBER, RULE(air_absorption), ENDS(0, 1e3)},
    {"resistance", SHARD_NUMBER, RULE(resistance_absorption), ENDS(0, 1e3)},
    {"total", SHARD_BOOL, RULE(total_absorption)},
    {0},
};
static const shard_key breakage_keys[] = {
    {"life", SHARD_NUMBER, RULE(break_life), ENDS(0, 1)},
    {"chance", SHARD_NUMBER, RULE(break_chance), ENDS(0, 1)},
    {0},
};
static const shard_key stability_keys[] = {
    {"density", SHARD_NUMBER, RULE(density), ENDS(1, 1e5)},
    {"strength", SHARD_NUMBER, RULE(strength), ENDS(0, 1e12)},
    {"compression", SHARD_NUMBER, RULE(compression), ENDS(1, 1e3)},
    {"interval", SHARD_COUNT, RULE(stability_interval), ENDS(1, 1e9)},
    {0},
};
static const scree_rain default_rain = {{0, -1, 0}, 0.5, 1};

const shard_key shard_rule_keys[] = {
    {"rains", SHARD_LIST, RULE(rains), .members = rain_keys, .blank = &default_rain,
     .count_at = offsetof(scree_shard_rules, frost.rain_count), .stride = sizeof(scree_rain), .least = 1,
     .size = SCREE_FROST_RAINS},
    {"water", SHARD_NUMBER, RULE(water), ENDS(1e-6, 1e6)},
    {"gravity", SHARD_NUMBERS, RULE(gravity), ENDS(-1, 1), .size = 3},
    {"resistance", SHARD_OBJECT, .members = resistance_keys},
    {"absorption", SHARD_OBJECT, .members = absorption_keys},
    {"damage", SHARD_NUMBER, RULE(damage), ENDS(0, 1e3)},
    {"breakage", SHARD_OBJECT, .members = breakage_keys},
    {"fall", SHARD_CHOICE, RULE(fall), ENDS(0, 1), .words = "gone kept"},
    {"fall_life", SHARD_NUMBER, RULE(fall_life), ENDS(0, 1)},
    {"stability", SHARD_OBJECT, .members = stability_keys},
    {0},
};

#define WHERE(name) (1u << SCREE_SHARD_##name)
static const shard_key region_keys[] = {
    {"where", SHARD_CHOICE, AT(scree_shard_region, where), ENDS(0, 6), .words = "all exterior facing base box sphere half_space"},
    {"state", SHARD_CHOICE, AT(scree_shard_region, state), ENDS(0, 2), .words = "solid air core"},
    {"direction", SHARD_NUMBERS, AT(scree_shard_region, direction), ENDS(-1, 1), .size = 3, .only = WHERE(FACING) | WHERE(BEYOND)},
    {"angle", SHARD_NUMBER, AT(scree_shard_region, angle), ENDS(0, 3.141592653589793), .only = WHERE(FACING)},
    {"offset", SHARD_NUMBER, AT(scree_shard_region, offset), ENDS(-FAR, FAR), .only = WHERE(BEYOND)},
    {"depth", SHARD_NUMBER, AT(scree_shard_region, depth), ENDS(0, FAR), .only = WHERE(AT_BASE)},
    {"min", SHARD_NUMBERS, AT(scree_shard_region, min), ENDS(-FAR, FAR), .size = 3, .only = WHERE(IN_BOX)},
    {"max", SHARD_NUMBERS, AT(scree_shard_region, max), ENDS(-FAR, FAR), .size = 3, .only = WHERE(IN_BOX)},
    {"centre", SHARD_NUMBERS, AT(scree_shard_region, centre), ENDS(-FAR, FAR), .size = 3, .only = WHERE(IN_SPHERE)},
    {"radius", SHARD_NUMBER, AT(scree_shard_region, radius), ENDS(1e-3, FAR), .only = WHERE(IN_SPHERE)},
    {0},
};
static const scree_shard_region default_region = {.where = SCREE_SHARD_EXTERIOR,
                                                  .state = SCREE_SHARD_CORE,
                                                  .direction = {0, 0, 1},
                                                  .angle = 0.8,
                                                  .min = {-1, -1, -1},
                                                  .max = {1, 1, 1},
                                                  .radius = 1};

static const shard_key image_keys[] = {
    {"file", SHARD_TEXT, AT(scree_shard_images, file), ENDS(0, 255)},
    {"slices", SHARD_COUNT, AT(scree_shard_images, slices), ENDS(1, 4096)},
    {"min", SHARD_NUMBERS, AT(scree_shard_images, min), ENDS(-FAR, FAR), .size = 3},
    {"max", SHARD_NUMBERS, AT(scree_shard_images, max), ENDS(-FAR, FAR), .size = 3},
    {0},
};

static const shard_key rubble_keys[] = {
    {"ground", SHARD_NUMBER, AT(scree_shard_rubble, ground), ENDS(-FAR, FAR)},
    {"resolution", SHARD_NUMBER, AT(scree_shard_rubble, resolution), ENDS(0, 1e3)},
    {"repose", SHARD_NUMBER, AT(scree_shard_rubble, repose), ENDS(0.0625, 4)},
    {"min_volume", SHARD_NUMBER, AT(scree_shard_rubble, min_volume), ENDS(0, 1e9)},
    {"share", SHARD_NUMBER, AT(scree_shard_rubble, share), ENDS(0, 1)},
    {"reach", SHARD_NUMBER, AT(scree_shard_rubble, reach), ENDS(0, FAR)},
    {0},
};

/* When a phase begins; the keys of rules come on top. */
static const shard_key phase_keys[] = {
    {"share", SHARD_NUMBER, AT(scree_shard_phase, share), ENDS(0, 1)},
    {"paths", SHARD_COUNT, AT(scree_shard_phase, paths), ENDS(0, 1e9)},
    {0},
};

/* Left out of an object that is given; the default recipe has a count. */
static const scree_shard_seeds default_seeds = {.spacing = 1, .jitter = 0.1, .up = {0, 1, 0}, .stretch = {1, 1, 1}};

const shard_key shard_keys[] = {
    {"name", SHARD_TEXT, AT(scree_shard_recipe, name), ENDS(0, 63)},
    {"random_seed", SHARD_SEED, AT(scree_shard_recipe, random_seed), ENDS(0, 9007199254740992.0)},
    {"input", SHARD_OBJECT, AT(scree_shard_recipe, input), .members = input_keys},
    {"seeds", SHARD_OBJECT, AT(scree_shard_recipe, seeds), .members = seed_keys, .blank = &default_seeds},
    {"clip", SHARD_CHOICE, AT(scree_shard_recipe, clip), ENDS(0, 2), .words = "auto walls mesh"},
    {"link_angle", SHARD_NUMBER, AT(scree_shard_recipe, link_angle), ENDS(1e-3, 1.5707963267948966)},
    {"images", SHARD_OBJECT, AT(scree_shard_recipe, images), .members = image_keys},
    {"states", SHARD_LIST, AT(scree_shard_recipe, states), .members = region_keys, .blank = &default_region,
     .count_at = offsetof(scree_shard_recipe, state_count), .stride = sizeof(scree_shard_region), .size = SCREE_SHARD_REGIONS},
    {"phases", SHARD_PHASES, AT(scree_shard_recipe, phases), .members = phase_keys,
     .count_at = offsetof(scree_shard_recipe, phase_count), .stride = sizeof(scree_shard_phase), .size = SCREE_SHARD_PHASES},
    {"paths", SHARD_TIMES, AT(scree_shard_recipe, paths), ENDS(0, 1e9), .count_at = offsetof(scree_shard_recipe, path_count),
     .stride = sizeof(uint32_t), .size = SCREE_SHARD_TIMES},
    {"shares", SHARD_VALUES, AT(scree_shard_recipe, shares), ENDS(0, 1), .count_at = offsetof(scree_shard_recipe, share_count),
     .stride = sizeof(double), .size = SCREE_SHARD_TIMES},
    {"max_paths", SHARD_COUNT, AT(scree_shard_recipe, max_paths), ENDS(1, 1e9)},
    {"rubble", SHARD_OBJECT, AT(scree_shard_recipe, rubble), .members = rubble_keys},
    {"lod_levels", SHARD_COUNT, AT(scree_shard_recipe, lod_levels), ENDS(1, 6)},
    {"lattice_per_metre", SHARD_COUNT, AT(scree_shard_recipe, lattice_per_metre), ENDS(0, 4096)},
    {0},
};

/* Those of the paper, and for what it has not, values within the ends of a table, for JSON to go on from. */
static void default_rules(scree_shard_rules* out) {
  memset(out, 0, sizeof *out);
  scree_frost_rules_default(&out->frost);
  out->frost.resistance.period = 1;
  out->frost.resistance.octaves = 1;
  out->frost.resistance.up[1] = 1;
  out->frost.resistance.layer_count = 1;
  out->layers[0][1] = 0.5;
}

void scree_shard_recipe_default(scree_shard_recipe* out) {
  memset(out, 0, sizeof *out);
  strcpy(out->name, "hill");
  out->random_seed = 1;
  out->input = (scree_shard_input){.shape = SCREE_SHARD_HILL,
                                   .size = {10, 10, 10},
                                   .radius = 20,
                                   .height = 25,
                                   .top = 0.15,
                                   .bulge = 0.3,
                                   .rings = 3,
                                   .sides = 24,
                                   .wavelength = 5,
                                   .octaves = 3,
                                   .scale = 1,
                                   .spacing = 1,
                                   .high = 1,
                                   .base = -1};
  out->seeds = default_seeds;
  out->seeds.count = 2908;
  out->link_angle = 0.35;
  out->images.slices = 1;
  default_rules(&out->rules);
  out->path_count = 1;
  out->paths[0] = 70000;
  out->max_paths = 100000000;
  out->rubble = (scree_shard_rubble){.repose = 0.7, .share = 1};
  out->lod_levels = 4;
}

static bool is_zero(const double v[3]) {
  return v[0] == 0 && v[1] == 0 && v[2] == 0;
}

static scree_result check_box(const double min[3], const double max[3], const char* where, scree_error* error) {
  for (int a = 0; a < 3; ++a)
    if (!(min[a] < max[a])) {
      recipe_say(error, "%s.max[%d]: %g is not above min[%d], %g", where, a, max[a], a, min[a]);
      return SCREE_ERROR_RANGE;
    }
  return SCREE_OK;
}

static scree_result not_zero(const double v[3], const char* where, const char* key, scree_error* error) {
  if (!is_zero(v)) return SCREE_OK;
  recipe_say(error, "%s%s: a direction must not be zero", where, key);
  return SCREE_ERROR_RANGE;
}

static scree_result check_input(const scree_shard_input* input, scree_error* error) {
  const scree_shard_shape shape = input->shape;
  if ((shape == SCREE_SHARD_MESH || shape == SCREE_SHARD_TERRAIN || shape == SCREE_SHARD_HOODOO) && input->file[0] == '\0')
    recipe_say(error, "input.file: missing");
  else if (shape == SCREE_SHARD_TERRAIN && !(input->low < input->high))
    recipe_say(error, "input.high: %g is not above input.low, %g", input->high, input->low);
  else if (shape == SCREE_SHARD_TERRAIN && (input->crop[0] | input->crop[1] | input->crop[2] | input->crop[3]) != 0 &&
           (input->crop[2] < 2 || input->crop[3] < 2))
    recipe_say(error, "input.crop: expected at least 2 columns and 2 rows, got %u and %u", input->crop[2], input->crop[3]);
  else if (shape == SCREE_SHARD_CAPSULE && !(input->height >= 2 * input->radius))
    recipe_say(error, "input.height: %g is less than twice input.radius, %g", input->height, input->radius);
  else if (input->resolution > 0 && input->resolution < 8)
    recipe_say(error, "input.resolution: expected 0 or a number from 8 to 512, got %u", input->resolution);
  else
    return SCREE_OK;
  return SCREE_ERROR_RANGE;
}

/* where: what stands before the key, "" or "phases[3].". */
static scree_result check_rules(const scree_shard_recipe* recipe, const scree_shard_rules* rules, uint32_t changes,
                                const char* where, scree_error* error) {
  const scree_resistance* resistance = &rules->frost.resistance;
  scree_result result = SCREE_OK;
  for (uint32_t i = 0; i < rules->frost.rain_count && result == SCREE_OK && (changes & SCREE_SHARD_RAINS) != 0; ++i) {
    char key[32];
    snprintf(key, sizeof key, "rains[%u].direction", i);
    result = not_zero(rules->frost.rains[i].direction, where, key, error);
  }
  if (result == SCREE_OK && (changes & SCREE_SHARD_GRAVITY) != 0) result = not_zero(rules->frost.gravity, where, "gravity", error);
  if (result != SCREE_OK || (changes & SCREE_SHARD_RESISTANCE) == 0) return result;
  if (resistance->kind == SCREE_RESISTANCE_IMAGES && recipe->images.file[0] == '\0') {
    recipe_say(error, "images.file: missing; %sresistance needs it", where);
    return SCREE_ERROR_RANGE;
  }
  if (resistance->kind != SCREE_RESISTANCE_LAYERS) return SCREE_OK;
  for (uint32_t i = 1; i < resistance->layer_count; ++i)
    if (!(rules->layers[i][0] > rules->layers[i - 1][0])) {
      recipe_say(error, "%sresistance.layers[%u]: %g is not above the place before, %g", where, i, rules->layers[i][0],
                 rules->layers[i - 1][0]);
      return SCREE_ERROR_RANGE;
    }
  return not_zero(resistance->up, where, "resistance.up", error);
}

static scree_result check_states(const scree_shard_recipe* recipe, scree_error* error) {
  scree_result result = SCREE_OK;
  for (uint32_t i = 0; i < recipe->state_count && result == SCREE_OK; ++i) {
    const scree_shard_region* region = &recipe->states[i];
    char where[32];
    snprintf(where, sizeof where, "states[%u]", i);
    if (region->where == SCREE_SHARD_IN_BOX) result = check_box(region->min, region->max, where, error);
    if (region->where == SCREE_SHARD_FACING || region->where == SCREE_SHARD_BEYOND)
      result = not_zero(region->direction, where, ".direction", error);
  }
  return result;
}

static scree_result check_times(const scree_shard_recipe* recipe, scree_error* error) {
  for (uint32_t i = 1; i < recipe->path_count; ++i)
    if (recipe->paths[i] <= recipe->paths[i - 1]) {
      recipe_say(error, "paths[%u]: %u is not more than the time before, %u", i, recipe->paths[i], recipe->paths[i - 1]);
      return SCREE_ERROR_RANGE;
    }
  for (uint32_t i = 1; i < recipe->share_count; ++i)
    if (!(recipe->shares[i] < recipe->shares[i - 1])) {
      recipe_say(error, "shares[%u]: %g is not less than the time before, %g", i, recipe->shares[i], recipe->shares[i - 1]);
      return SCREE_ERROR_RANGE;
    }
  if ((recipe->path_count == 0) == (recipe->share_count == 0)) {
    recipe_say(error, "paths: expected either paths or shares");
    return SCREE_ERROR_RANGE;
  }
  if (recipe->path_count > 0 && recipe->paths[recipe->path_count - 1] > recipe->max_paths) {
    recipe_say(error, "paths[%u]: %u is more than max_paths, %u", recipe->path_count - 1, recipe->paths[recipe->path_count - 1],
               recipe->max_paths);
    return SCREE_ERROR_RANGE;
  }
  return SCREE_OK;
}

scree_result shard_check(const scree_shard_recipe* recipe, scree_error* error) {
  const scree_shard_seeds* seeds = &recipe->seeds;
  scree_result result = check_input(&recipe->input, error);
  if (result == SCREE_OK) result = not_zero(seeds->up, "seeds.", "up", error);
  if (result == SCREE_OK && seeds->kind == SCREE_SEEDS_POINTS && seeds->point_count == 0) {
    recipe_say(error, "seeds.points: missing");
    result = SCREE_ERROR_RANGE;
  }
  if (result == SCREE_OK && !(is_zero(recipe->images.min) && is_zero(recipe->images.max)))
    result = check_box(recipe->images.min, recipe->images.max, "images", error);
  if (result == SCREE_OK) result = check_rules(recipe, &recipe->rules, ~0u, "", error);
  if (result == SCREE_OK) result = check_states(recipe, error);
  for (uint32_t i = 0; i < recipe->phase_count && result == SCREE_OK; ++i) {
    char where[32];
    snprintf(where, sizeof where, "phases[%u].", i);
    result = check_rules(recipe, &recipe->phases[i].rules, recipe->phases[i].changes, where, error);
  }
  return result == SCREE_OK ? check_times(recipe, error) : result;
}

void scree_shard_seeds_view(const scree_shard_recipe* recipe, scree_seed_pattern* out) {
  const scree_shard_seeds* seeds = &recipe->seeds;
  *out = (scree_seed_pattern){.kind = seeds->kind,
                              .count = seeds->count,
                              .spacing = seeds->spacing,
                              .spacing_end = seeds->spacing_end,
                              .length = seeds->length,
                              .layers = seeds->layer_count > 0 ? seeds->layers : NULL,
                              .layer_count = seeds->layer_count,
                              .jitter = seeds->jitter,
                              .points = &seeds->points[0][0],
                              .point_count = seeds->point_count};
  memcpy(out->grade, seeds->grade, sizeof out->grade);
  memcpy(out->up, seeds->up, sizeof out->up);
  memcpy(out->stretch, seeds->stretch, sizeof out->stretch);
  /* Streams of seeds and of weather must differ though they come from one number. */
  out->random_seed = hash_mix(hash_mix(recipe->random_seed ^ UINT64_C(0x73686172647365)) + seeds->random_seed);
}

void scree_shard_rules_view(const scree_shard_desc* desc, const scree_shard_rules* rules, scree_frost_rules* out) {
  *out = rules->frost;
  scree_resistance* resistance = &out->resistance;
  resistance->layers = &rules->layers[0][0];
  resistance->function = desc->resistance;
  resistance->user = desc->resistance_user;
  resistance->images = desc->images;
  memcpy(resistance->size, desc->image_size, sizeof resistance->size);
  memcpy(resistance->min, desc->recipe->images.min, sizeof resistance->min);
  memcpy(resistance->max, desc->recipe->images.max, sizeof resistance->max);
}
