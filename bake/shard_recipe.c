/* Recipes of shards: the tables of keys, defaults, and the rules between keys; content/schema/shards.schema.json is held against
 * the tables by a test. */
#include <stdio.h>
#include <string.h>

#include "lattice.h"
#include "recipe_text.h"
#include "shard_keys.h"

#define FAR 1e5 /* how far anything is from the origin, metres */

#define SHAPE(name) (1u << SCREE_SHARD_##name)
#define SMOOTH (SHAPE(SPHERE) | SHAPE(CONE) | SHAPE(CAPSULE))
static const recipe_key input_keys[] = {
    {"shape", RECIPE_CHOICE, KEY_AT(scree_shard_input, shape), KEY_ENDS(0, 8),
     .words = "box hill sphere cone capsule mesh terrain hoodoo support"},
    {"size", RECIPE_NUMBERS, KEY_AT(scree_shard_input, size), KEY_ENDS(0.01, FAR), .size = 3, .only = SHAPE(BOX)},
    {"radius", RECIPE_NUMBER, KEY_AT(scree_shard_input, radius), KEY_ENDS(0.01, FAR), .only = SMOOTH | SHAPE(HILL)},
    {"height", RECIPE_NUMBER, KEY_AT(scree_shard_input, height), KEY_ENDS(0.01, FAR),
     .only = SHAPE(HILL) | SHAPE(CONE) | SHAPE(CAPSULE)},
    {"top", RECIPE_NUMBER, KEY_AT(scree_shard_input, top), KEY_ENDS(0.01, 1), .only = SHAPE(HILL)},
    {"bulge", RECIPE_NUMBER, KEY_AT(scree_shard_input, bulge), KEY_ENDS(0, 1), .only = SHAPE(HILL)},
    {"rings", RECIPE_COUNT, KEY_AT(scree_shard_input, rings), KEY_ENDS(1, 16), .only = SHAPE(HILL)},
    {"sides", RECIPE_COUNT, KEY_AT(scree_shard_input, sides), KEY_ENDS(3, 64), .only = SHAPE(HILL)},
    {"noise", RECIPE_NUMBER, KEY_AT(scree_shard_input, noise), KEY_ENDS(0, 1e4), .only = SMOOTH | SHAPE(BOX)},
    {"wavelength", RECIPE_NUMBER, KEY_AT(scree_shard_input, wavelength), KEY_ENDS(0.01, FAR), .only = SMOOTH | SHAPE(BOX)},
    {"octaves", RECIPE_COUNT, KEY_AT(scree_shard_input, octaves), KEY_ENDS(1, 8), .only = SMOOTH | SHAPE(BOX)},
    {"resolution", RECIPE_COUNT, KEY_AT(scree_shard_input, resolution), KEY_ENDS(0, 512),
     .only = SMOOTH | SHAPE(BOX) | SHAPE(MESH) | SHAPE(SUPPORT)},
    {"file", RECIPE_TEXT, KEY_AT(scree_shard_input, file), KEY_ENDS(0, 255), .only = SHAPE(MESH) | SHAPE(TERRAIN) | SHAPE(HOODOO)},
    {"scale", RECIPE_NUMBER, KEY_AT(scree_shard_input, scale), KEY_ENDS(1e-6, 1e6), .only = SHAPE(MESH)},
    {"position", RECIPE_NUMBERS, KEY_AT(scree_shard_input, position), KEY_ENDS(-FAR, FAR), .size = 3, .only = SHAPE(MESH)},
    {"spacing", RECIPE_NUMBER, KEY_AT(scree_shard_input, spacing), KEY_ENDS(0.001, 1e4), .only = SHAPE(TERRAIN)},
    {"low", RECIPE_NUMBER, KEY_AT(scree_shard_input, low), KEY_ENDS(-FAR, FAR), .only = SHAPE(TERRAIN)},
    {"high", RECIPE_NUMBER, KEY_AT(scree_shard_input, high), KEY_ENDS(-FAR, FAR), .only = SHAPE(TERRAIN)},
    {"crop", RECIPE_COUNTS, KEY_AT(scree_shard_input, crop), KEY_ENDS(0, 8192), .size = 4, .only = SHAPE(TERRAIN)},
    {"base", RECIPE_NUMBER, KEY_AT(scree_shard_input, base), KEY_ENDS(-FAR, FAR), .only = SHAPE(TERRAIN)},
    {"variant", RECIPE_COUNT, KEY_AT(scree_shard_input, variant), KEY_ENDS(0, SCREE_HOODOO_VARIANTS - 1), .only = SHAPE(HOODOO)},
    {"age", RECIPE_COUNT, KEY_AT(scree_shard_input, age), KEY_ENDS(0, SCREE_HOODOO_AGES - 1), .only = SHAPE(HOODOO)},
    {"lod", RECIPE_COUNT, KEY_AT(scree_shard_input, lod), KEY_ENDS(0, 5), .only = SHAPE(HOODOO)},
    {0},
};

#define PATTERN(name) (1u << SCREE_SEEDS_##name)
static const recipe_key place_keys[] = {
    {"x", RECIPE_NUMBER, .offset = 0, KEY_ENDS(-FAR, FAR)},
    {"y", RECIPE_NUMBER, .offset = sizeof(double), KEY_ENDS(-FAR, FAR)},
    {"z", RECIPE_NUMBER, .offset = 2 * sizeof(double), KEY_ENDS(-FAR, FAR)},
    {0},
};
static const recipe_key seed_keys[] = {
    {"pattern", RECIPE_CHOICE, KEY_AT(scree_shard_seeds, kind), KEY_ENDS(0, 5),
     .words = "random grid columns slabs poisson points"},
    {"count", RECIPE_COUNT, KEY_AT(scree_shard_seeds, count), KEY_ENDS(0, 1e6), .only = ~PATTERN(POINTS)},
    {"spacing", RECIPE_NUMBER, KEY_AT(scree_shard_seeds, spacing), KEY_ENDS(1e-3, FAR), .only = ~PATTERN(POINTS)},
    {"spacing_end", RECIPE_NUMBER, KEY_AT(scree_shard_seeds, spacing_end), KEY_ENDS(0, FAR), .only = PATTERN(POISSON)},
    {"grade", RECIPE_NUMBERS, KEY_AT(scree_shard_seeds, grade), KEY_ENDS(-1, 1), .size = 3, .only = PATTERN(POISSON)},
    {"length", RECIPE_NUMBER, KEY_AT(scree_shard_seeds, length), KEY_ENDS(0, FAR), .only = PATTERN(COLUMNS)},
    {"layers", RECIPE_VALUES, KEY_AT(scree_shard_seeds, layers), KEY_ENDS(1e-3, FAR),
     .count_at = offsetof(scree_shard_seeds, layer_count), .stride = sizeof(double), .size = SCREE_SHARD_LAYERS,
     .only = PATTERN(SLABS), .of = "thicknesses"},
    {"jitter", RECIPE_NUMBER, KEY_AT(scree_shard_seeds, jitter), KEY_ENDS(0, 1),
     .only = PATTERN(GRID) | PATTERN(COLUMNS) | PATTERN(SLABS)},
    {"up", RECIPE_NUMBERS, KEY_AT(scree_shard_seeds, up), KEY_ENDS(-1, 1), .size = 3},
    {"stretch", RECIPE_NUMBERS, KEY_AT(scree_shard_seeds, stretch), KEY_ENDS(0.01, 100), .size = 3},
    {"points", RECIPE_ROWS, KEY_AT(scree_shard_seeds, points), .members = place_keys,
     .count_at = offsetof(scree_shard_seeds, point_count), .stride = 3 * sizeof(double), .least = 1, .size = SCREE_SHARD_POINTS,
     .only = PATTERN(POINTS), .of = "points"},
    {"random_seed", RECIPE_SEED, KEY_AT(scree_shard_seeds, random_seed), KEY_ENDS(0, 9007199254740992.0)},
    {0},
};

static const recipe_key rain_keys[] = {
    {"direction", RECIPE_NUMBERS, KEY_AT(scree_rain, direction), KEY_ENDS(-1, 1), .size = 3},
    {"spread", RECIPE_NUMBER, KEY_AT(scree_rain, spread), KEY_ENDS(0, 3.141592653589793)},
    {"weight", RECIPE_NUMBER, KEY_AT(scree_rain, weight), KEY_ENDS(1e-6, 1e6)},
    {0},
};

#define KIND(name) (1u << SCREE_RESISTANCE_##name)
static const recipe_key bed_keys[] = {
    {"place", RECIPE_NUMBER, .offset = 0, KEY_ENDS(-FAR, FAR)},
    {"value", RECIPE_NUMBER, .offset = sizeof(double), KEY_ENDS(0, 1)},
    {0},
};
/* Of scree_shard_rules. */
#define RULE(member) .offset = offsetof(scree_shard_rules, frost.member)
static const recipe_key resistance_keys[] = {
    {"kind", RECIPE_CHOICE, RULE(resistance.kind), KEY_ENDS(0, 4), .words = "constant function noise layers images"},
    {"value", RECIPE_NUMBER, RULE(resistance.value), KEY_ENDS(0, 1), .only = KIND(CONSTANT) | KIND(NOISE)},
    {"amplitude", RECIPE_NUMBER, RULE(resistance.amplitude), KEY_ENDS(0, 1), .only = KIND(NOISE) | KIND(LAYERS)},
    {"period", RECIPE_NUMBER, RULE(resistance.period), KEY_ENDS(1e-3, FAR), .only = KIND(NOISE) | KIND(LAYERS)},
    {"octaves", RECIPE_COUNT, RULE(resistance.octaves), KEY_ENDS(1, 8), .only = KIND(NOISE) | KIND(LAYERS)},
    {"random_seed", RECIPE_SEED, RULE(resistance.random_seed), KEY_ENDS(0, 9007199254740992.0), .only = KIND(NOISE) | KIND(LAYERS)},
    {"up", RECIPE_NUMBERS, RULE(resistance.up), KEY_ENDS(-1, 1), .size = 3, .only = KIND(LAYERS)},
    {"layers", RECIPE_ROWS, KEY_AT(scree_shard_rules, layers), .members = bed_keys,
     .count_at = offsetof(scree_shard_rules, frost.resistance.layer_count), .stride = 2 * sizeof(double), .least = 1,
     .size = SCREE_SHARD_LAYERS, .only = KIND(LAYERS), .of = "points"},
    {0},
};
static const recipe_key absorption_keys[] = {
    {"solid", RECIPE_NUMBER, RULE(solid_absorption), KEY_ENDS(0, 1e3)},
    {"air", RECIPE_NUMBER, RULE(air_absorption), KEY_ENDS(0, 1e3)},
    {"resistance", RECIPE_NUMBER, RULE(resistance_absorption), KEY_ENDS(0, 1e3)},
    {"total", RECIPE_BOOL, RULE(total_absorption)},
    {0},
};
static const recipe_key breakage_keys[] = {
    {"life", RECIPE_NUMBER, RULE(break_life), KEY_ENDS(0, 1)},
    {"chance", RECIPE_NUMBER, RULE(break_chance), KEY_ENDS(0, 1)},
    {0},
};
static const recipe_key stability_keys[] = {
    {"density", RECIPE_NUMBER, RULE(density), KEY_ENDS(1, 1e5)},
    {"strength", RECIPE_NUMBER, RULE(strength), KEY_ENDS(0, 1e12)},
    {"compression", RECIPE_NUMBER, RULE(compression), KEY_ENDS(1, 1e3)},
    {"interval", RECIPE_COUNT, RULE(stability_interval), KEY_ENDS(1, 1e9)},
    {0},
};
static const scree_rain default_rain = {{0, -1, 0}, 0.5, 1};

static const recipe_key rule_keys[] = {
    {"rains", RECIPE_LIST, RULE(rains), .members = rain_keys, .blank = &default_rain,
     .count_at = offsetof(scree_shard_rules, frost.rain_count), .stride = sizeof(scree_rain), .least = 1, .size = SCREE_FROST_RAINS,
     .of = "rains"},
    {"water", RECIPE_NUMBER, RULE(water), KEY_ENDS(1e-6, 1e6)},
    {"gravity", RECIPE_NUMBERS, RULE(gravity), KEY_ENDS(-1, 1), .size = 3},
    {"resistance", RECIPE_OBJECT, .members = resistance_keys},
    {"absorption", RECIPE_OBJECT, .members = absorption_keys},
    {"damage", RECIPE_NUMBER, RULE(damage), KEY_ENDS(0, 1e3)},
    {"breakage", RECIPE_OBJECT, .members = breakage_keys},
    {"fall", RECIPE_CHOICE, RULE(fall), KEY_ENDS(0, 1), .words = "gone kept"},
    {"fall_life", RECIPE_NUMBER, RULE(fall_life), KEY_ENDS(0, 1)},
    {"stability", RECIPE_OBJECT, .members = stability_keys},
    {0},
};

#define WHERE(name) (1u << SCREE_SHARD_##name)
static const recipe_key region_keys[] = {
    {"where", RECIPE_CHOICE, KEY_AT(scree_shard_region, where), KEY_ENDS(0, 6),
     .words = "all exterior facing base box sphere half_space"},
    {"state", RECIPE_CHOICE, KEY_AT(scree_shard_region, state), KEY_ENDS(0, 2), .words = "solid air core"},
    {"direction", RECIPE_NUMBERS, KEY_AT(scree_shard_region, direction), KEY_ENDS(-1, 1), .size = 3,
     .only = WHERE(FACING) | WHERE(BEYOND)},
    {"angle", RECIPE_NUMBER, KEY_AT(scree_shard_region, angle), KEY_ENDS(0, 3.141592653589793), .only = WHERE(FACING)},
    {"offset", RECIPE_NUMBER, KEY_AT(scree_shard_region, offset), KEY_ENDS(-FAR, FAR), .only = WHERE(BEYOND)},
    {"depth", RECIPE_NUMBER, KEY_AT(scree_shard_region, depth), KEY_ENDS(0, FAR), .only = WHERE(AT_BASE)},
    {"min", RECIPE_NUMBERS, KEY_AT(scree_shard_region, min), KEY_ENDS(-FAR, FAR), .size = 3, .only = WHERE(IN_BOX)},
    {"max", RECIPE_NUMBERS, KEY_AT(scree_shard_region, max), KEY_ENDS(-FAR, FAR), .size = 3, .only = WHERE(IN_BOX)},
    {"centre", RECIPE_NUMBERS, KEY_AT(scree_shard_region, centre), KEY_ENDS(-FAR, FAR), .size = 3, .only = WHERE(IN_SPHERE)},
    {"radius", RECIPE_NUMBER, KEY_AT(scree_shard_region, radius), KEY_ENDS(1e-3, FAR), .only = WHERE(IN_SPHERE)},
    {0},
};
static const scree_shard_region default_region = {.where = SCREE_SHARD_EXTERIOR,
                                                  .state = SCREE_SHARD_CORE,
                                                  .direction = {0, 0, 1},
                                                  .angle = 0.8,
                                                  .min = {-1, -1, -1},
                                                  .max = {1, 1, 1},
                                                  .radius = 1};

static const recipe_key image_keys[] = {
    {"file", RECIPE_TEXT, KEY_AT(scree_shard_images, file), KEY_ENDS(0, 255)},
    {"slices", RECIPE_COUNT, KEY_AT(scree_shard_images, slices), KEY_ENDS(1, 4096)},
    {"min", RECIPE_NUMBERS, KEY_AT(scree_shard_images, min), KEY_ENDS(-FAR, FAR), .size = 3},
    {"max", RECIPE_NUMBERS, KEY_AT(scree_shard_images, max), KEY_ENDS(-FAR, FAR), .size = 3},
    {0},
};

static const recipe_key rubble_keys[] = {
    {"ground", RECIPE_NUMBER, KEY_AT(scree_shard_rubble, ground), KEY_ENDS(-FAR, FAR)},
    {"resolution", RECIPE_NUMBER, KEY_AT(scree_shard_rubble, resolution), KEY_ENDS(0, 1e3)},
    {"repose", RECIPE_NUMBER, KEY_AT(scree_shard_rubble, repose), KEY_ENDS(0.0625, 4)},
    {"min_volume", RECIPE_NUMBER, KEY_AT(scree_shard_rubble, min_volume), KEY_ENDS(0, 1e9)},
    {"share", RECIPE_NUMBER, KEY_AT(scree_shard_rubble, share), KEY_ENDS(0, 1)},
    {"reach", RECIPE_NUMBER, KEY_AT(scree_shard_rubble, reach), KEY_ENDS(0, FAR)},
    {0},
};

/* When a phase begins; the keys of rules come on top. */
static const recipe_key phase_keys[] = {
    {"share", RECIPE_NUMBER, KEY_AT(scree_shard_phase, share), KEY_ENDS(0, 1)},
    {"paths", RECIPE_COUNT, KEY_AT(scree_shard_phase, paths), KEY_ENDS(0, 1e9)},
    {0},
};

/* Left out of an object that is given; the default recipe has a count. */
static const scree_shard_seeds default_seeds = {.spacing = 1, .jitter = 0.1, .up = {0, 1, 0}, .stretch = {1, 1, 1}};

static const recipe_key top_keys[] = {
    {"name", RECIPE_TEXT, KEY_AT(scree_shard_recipe, name), KEY_ENDS(0, 63)},
    {"random_seed", RECIPE_SEED, KEY_AT(scree_shard_recipe, random_seed), KEY_ENDS(0, 9007199254740992.0)},
    {"input", RECIPE_OBJECT, KEY_AT(scree_shard_recipe, input), .members = input_keys},
    {"seeds", RECIPE_OBJECT, KEY_AT(scree_shard_recipe, seeds), .members = seed_keys, .blank = &default_seeds},
    {"clip", RECIPE_CHOICE, KEY_AT(scree_shard_recipe, clip), KEY_ENDS(0, 2), .words = "auto walls mesh"},
    {"link_angle", RECIPE_NUMBER, KEY_AT(scree_shard_recipe, link_angle), KEY_ENDS(1e-3, 1.5707963267948966)},
    {"images", RECIPE_OBJECT, KEY_AT(scree_shard_recipe, images), .members = image_keys},
    {"states", RECIPE_LIST, KEY_AT(scree_shard_recipe, states), .members = region_keys, .blank = &default_region,
     .count_at = offsetof(scree_shard_recipe, state_count), .stride = sizeof(scree_shard_region), .size = SCREE_SHARD_REGIONS,
     .of = "regions"},
    {"phases", RECIPE_PHASES, KEY_AT(scree_shard_recipe, phases), .members = phase_keys,
     .count_at = offsetof(scree_shard_recipe, phase_count), .stride = sizeof(scree_shard_phase), .size = SCREE_SHARD_PHASES,
     .of = "phases"},
    {"paths", RECIPE_TIMES, KEY_AT(scree_shard_recipe, paths), KEY_ENDS(0, 1e9),
     .count_at = offsetof(scree_shard_recipe, path_count), .stride = sizeof(uint32_t), .size = SCREE_SHARD_TIMES, .least = 1,
     .of = "times"},
    {"shares", RECIPE_VALUES, KEY_AT(scree_shard_recipe, shares), KEY_ENDS(0, 1),
     .count_at = offsetof(scree_shard_recipe, share_count), .stride = sizeof(double), .size = SCREE_SHARD_TIMES, .least = 1,
     .of = "times"},
    {"max_paths", RECIPE_COUNT, KEY_AT(scree_shard_recipe, max_paths), KEY_ENDS(1, 1e9)},
    {"rubble", RECIPE_OBJECT, KEY_AT(scree_shard_recipe, rubble), .members = rubble_keys},
    {"lod_levels", RECIPE_COUNT, KEY_AT(scree_shard_recipe, lod_levels), KEY_ENDS(1, 6)},
    {"lattice_per_metre", RECIPE_COUNT, KEY_AT(scree_shard_recipe, lattice_per_metre), KEY_ENDS(0, 4096)},
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

static scree_result check(const void* from, scree_error* error) {
  const scree_shard_recipe* recipe = from;
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

const recipe_table shard_table = {.kind = "shards",
                                  .kind_is_needed = true,
                                  .keys = top_keys,
                                  .rules = rule_keys,
                                  .rules_at = offsetof(scree_shard_recipe, rules),
                                  .phase_rules_at = offsetof(scree_shard_phase, rules),
                                  .phase_changes_at = offsetof(scree_shard_phase, changes),
                                  .rules_before = "states",
                                  .either = {"paths", "shares"},
                                  .size = sizeof(scree_shard_recipe),
                                  .check = check};

scree_result scree_shard_recipe_parse(const char* text, size_t size, scree_shard_recipe* out, scree_error* error) {
  scree_shard_recipe plain;
  scree_shard_recipe_default(&plain);
  return recipe_read(&shard_table, &plain, text, size, out, error);
}

scree_result scree_shard_recipe_set(scree_shard_recipe* recipe, const char* assignment, scree_error* error) {
  scree_shard_recipe plain, changed = *recipe;
  scree_shard_recipe_default(&plain);
  const scree_result result = recipe_assign(&shard_table, &plain, assignment, &changed, error);
  if (result == SCREE_OK) *recipe = changed;
  return result;
}

size_t scree_shard_recipe_write(const scree_shard_recipe* recipe, char* text, size_t capacity) {
  return recipe_write(&shard_table, recipe, text, capacity);
}

scree_result shard_check_all(const scree_shard_recipe* recipe, scree_error* error) {
  return recipe_check_keys(&shard_table, recipe, error);
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
