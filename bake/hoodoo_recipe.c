/* Recipes of hoodoos: the tables of keys, defaults, and the rules between keys. The reader and the writer go by the tables
 * (hoodoo_text.c), so that they cannot disagree; content/schema/hoodoo.schema.json is held against them by a test. */
#include "hoodoo_recipe.h"

#include <string.h>

#include "recipe_text.h"

#define SHAPE(name) (1u << SCREE_HOODOO_##name)

static const hoodoo_key point_keys[] = {
    {"altitude", HOODOO_NUMBER, offsetof(scree_durability_point, altitude), 0, 1, NULL, NULL, 0},
    {"durability", HOODOO_NUMBER, offsetof(scree_durability_point, durability), 1e-3, 1e6, NULL, NULL, 0},
    {"noise", HOODOO_NUMBER, offsetof(scree_durability_point, noise_amplitude), 0, 4, NULL, NULL, 0},
    {"period", HOODOO_NUMBER, offsetof(scree_durability_point, noise_period), 1, 1e4, NULL, NULL, 0},
    {"squash", HOODOO_NUMBER, offsetof(scree_durability_point, noise_squash), 0.1, 100, NULL, NULL, 0},
    {0},
};

static const hoodoo_key bubble_keys[] = {
    {"kind", HOODOO_CHOICE, offsetof(scree_bubble, kind), 0, 3, "sphere ellipsoid gumdrop disc", NULL, 0},
    {"radius", HOODOO_NUMBER, offsetof(scree_bubble, radius), 1, 12, NULL, NULL, 0},
    {"height", HOODOO_NUMBER, offsetof(scree_bubble, height), 1, 12, NULL, NULL, 0},
    {0},
};

static const hoodoo_key segment_keys[] = {
    {"altitude", HOODOO_NUMBER, offsetof(scree_bubble_segment, altitude), 0, 1, NULL, NULL, 0},
    {"mixture", HOODOO_MIXTURE, 0, 1, 4, NULL, bubble_keys, 0},
    {"period", HOODOO_NUMBER, offsetof(scree_bubble_segment, noise_period), 1, 1e4, NULL, NULL, 0},
    {0},
};

static const hoodoo_key curve_keys[] = {
    {"curve", HOODOO_CHOICE, offsetof(scree_curve, kind), 0, 4, "none linear cubic quartic saturating", NULL, 0},
    {"gain", HOODOO_NUMBER, offsetof(scree_curve, gain), 0, 1000, NULL, NULL, 0},
    {"threshold", HOODOO_NUMBER, offsetof(scree_curve, threshold), -1, 1, NULL, NULL, 0},
    {"saturation", HOODOO_NUMBER, offsetof(scree_curve, saturation), 1e-3, 2, NULL, NULL, 0},
    {"power", HOODOO_COUNT, offsetof(scree_curve, power), 1, 4, NULL, NULL, 0},
    {0},
};

static const hoodoo_key colluvium_keys[] = {
    {"share", HOODOO_NUMBER, offsetof(scree_hoodoo_rules, colluvium_share), 0, 1, NULL, NULL, 0},
    {"durability", HOODOO_NUMBER, offsetof(scree_hoodoo_rules, colluvium_durability), 1e-3, 1e6, NULL, NULL, 0},
    {"repose", HOODOO_NUMBER, offsetof(scree_hoodoo_rules, repose), 0.0625, 4, NULL, NULL, 0},
    {0},
};

const hoodoo_key hoodoo_rule_keys[] = {
    {"durability", HOODOO_DURABILITY, 0, 1, SCREE_HOODOO_POINTS, NULL, point_keys, 0},
    {"bubbles", HOODOO_BUBBLES, 0, 1, SCREE_HOODOO_SEGMENTS, NULL, segment_keys, 0},
    {"spheroidal", HOODOO_OBJECT, offsetof(scree_hoodoo_rules, spheroidal), 0, 0, NULL, curve_keys, 0},
    {"cavernous", HOODOO_OBJECT, offsetof(scree_hoodoo_rules, cavernous), 0, 0, NULL, curve_keys, 0},
    {"exposure", HOODOO_NUMBER, offsetof(scree_hoodoo_rules, exposure), 0, 2, NULL, NULL, 0},
    {"steps_per_voxel", HOODOO_NUMBER, offsetof(scree_hoodoo_rules, steps_per_voxel), 1, 1e4, NULL, NULL, 0},
    {"colluvium", HOODOO_OBJECT, 0, 0, 0, NULL, colluvium_keys, 0},
    {"rockfall", HOODOO_CHOICE, offsetof(scree_hoodoo_rules, rockfall), 0, 2, "none drop colluvium", NULL, 0},
    {0},
};

static const hoodoo_key start_keys[] = {
    {"shape", HOODOO_CHOICE, offsetof(scree_hoodoo_start, shape), 0, 7, "box column joint_map joints sphere cylinder cone mesh",
     NULL, 0},
    {"min", HOODOO_COUNTS, offsetof(scree_hoodoo_start, min), 0, 4096, NULL, NULL, SHAPE(BOX) | SHAPE(JOINTS)},
    {"max", HOODOO_COUNTS, offsetof(scree_hoodoo_start, max), 0, 4096, NULL, NULL, SHAPE(BOX) | SHAPE(JOINTS)},
    {"radius", HOODOO_NUMBER, offsetof(scree_hoodoo_start, radius), 1, 4096, NULL, NULL,
     SHAPE(COLUMN) | SHAPE(SPHERE) | SHAPE(CYLINDER) | SHAPE(CONE)},
    {"height", HOODOO_NUMBER, offsetof(scree_hoodoo_start, height), 0, 4096, NULL, NULL,
     SHAPE(COLUMN) | SHAPE(CYLINDER) | SHAPE(CONE)},
    {"lift", HOODOO_NUMBER, offsetof(scree_hoodoo_start, lift), 0, 4096, NULL, NULL, SHAPE(SPHERE) | SHAPE(CYLINDER) | SHAPE(CONE)},
    {"lobes", HOODOO_NUMBER, offsetof(scree_hoodoo_start, lobes), 0, 2, NULL, NULL, SHAPE(COLUMN)},
    {"spacing", HOODOO_NUMBER, offsetof(scree_hoodoo_start, spacing), 4, 4096, NULL, NULL, SHAPE(JOINTS)},
    {"gap", HOODOO_NUMBER, offsetof(scree_hoodoo_start, gap), 0, 0.5, NULL, NULL, SHAPE(JOINTS)},
    {"warp", HOODOO_NUMBER, offsetof(scree_hoodoo_start, warp), 0, 1, NULL, NULL, SHAPE(JOINTS)},
    {"missing", HOODOO_NUMBER, offsetof(scree_hoodoo_start, missing), 0, 1, NULL, NULL, SHAPE(JOINTS)},
    {"low", HOODOO_NUMBER, offsetof(scree_hoodoo_start, low), 0, 1, NULL, NULL, SHAPE(JOINTS)},
    {"file", HOODOO_TEXT, offsetof(scree_hoodoo_start, file), 0, 255, NULL, NULL, SHAPE(JOINT_MAP) | SHAPE(MESH)},
    {0},
};

/* When a phase begins; the keys of rules come on top. */
static const hoodoo_key phase_keys[] = {
    {"share", HOODOO_NUMBER, offsetof(scree_hoodoo_phase, share), 0, 1, NULL, NULL, 0},
    {"steps", HOODOO_COUNT, offsetof(scree_hoodoo_phase, steps), 0, 1e6, NULL, NULL, 0},
    {0},
};

const hoodoo_key hoodoo_keys[] = {
    {"name", HOODOO_TEXT, offsetof(scree_hoodoo_recipe, name), 0, 63, NULL, NULL, 0},
    {"random_seed", HOODOO_SEED, offsetof(scree_hoodoo_recipe, random_seed), 0, 9007199254740992.0, NULL, NULL, 0},
    {"voxel", HOODOO_NUMBER, offsetof(scree_hoodoo_recipe, voxel), 0.001, 100, NULL, NULL, 0},
    {"size", HOODOO_COUNTS, offsetof(scree_hoodoo_recipe, size), 1, 4096, NULL, NULL, 0},
    {"start", HOODOO_OBJECT, offsetof(scree_hoodoo_recipe, start), 0, 0, NULL, start_keys, 0},
    {"phases", HOODOO_PHASES, 0, 0, SCREE_HOODOO_PHASES, NULL, phase_keys, 0},
    {"variants", HOODOO_COUNT, offsetof(scree_hoodoo_recipe, variants), 1, SCREE_HOODOO_VARIANTS, NULL, NULL, 0},
    {"ages", HOODOO_AGES, 0, 0, 1, NULL, NULL, 0},
    {"age_steps", HOODOO_AGE_STEPS, 0, 0, 1e6, NULL, NULL, 0},
    {"max_steps", HOODOO_COUNT, offsetof(scree_hoodoo_recipe, max_steps), 1, 1e6, NULL, NULL, 0},
    {"lod_levels", HOODOO_COUNT, offsetof(scree_hoodoo_recipe, lod_levels), 1, 6, NULL, NULL, 0},
    {"lattice_steps", HOODOO_COUNT, offsetof(scree_hoodoo_recipe, lattice_steps), 2, 64, NULL, NULL, 0},
    {"parts", HOODOO_BOOL, offsetof(scree_hoodoo_recipe, parts), 0, 1, NULL, NULL, 0},
    {0},
};

static void default_rules(scree_hoodoo_rules* out) {
  static const double graph[][2] = {{0, 1.9},     {0.1, 1.5},   {0.22, 0.55}, {0.34, 0.42}, {0.42, 0.75}, {0.5, 0.5},
                                    {0.58, 0.42}, {0.62, 1.25}, {0.8, 2},     {0.92, 1.7},  {1, 1.2}};
  memset(out, 0, sizeof *out);
  out->durability_count = sizeof graph / sizeof *graph;
  for (uint32_t i = 0; i < out->durability_count; ++i)
    out->durability[i] = (scree_durability_point){graph[i][0], graph[i][1], 0.7, 22, 1};
  out->bubble_count = 1;
  out->bubbles[0] = (scree_bubble_segment){.bubbles = {{SCREE_BUBBLE_SPHERE, 4, 4}}, .bubble_count = 1, .noise_period = 16};
  out->spheroidal = (scree_curve){SCREE_CURVE_CUBIC, 1, 0, 1, 1};
  out->cavernous = (scree_curve){SCREE_CURVE_NONE, 1, 0, 1, 1};
  out->exposure = 0.6;
  out->steps_per_voxel = 12;
  out->colluvium_share = 0.2;
  out->colluvium_durability = 0.35;
  out->repose = 0.7;
  out->rockfall = SCREE_ROCKFALL_COLLUVIUM;
}

void scree_hoodoo_default(scree_hoodoo_recipe* out) {
  memset(out, 0, sizeof *out);
  strcpy(out->name, "goblin");
  out->random_seed = 1;
  out->voxel = 0.05;
  out->size[0] = out->size[2] = 128;
  out->size[1] = 96;
  out->start.shape = SCREE_HOODOO_COLUMN;
  out->start.radius = 38;
  out->start.lobes = 1;
  out->start.spacing = 48;
  out->start.gap = 0.1;
  out->start.warp = 0.25;
  out->start.missing = 0.1;
  out->start.low = 0.6;
  default_rules(&out->rules);
  out->variants = 4;
  out->age_count = 3;
  out->ages[0] = 0.8;
  out->ages[1] = 0.6;
  out->ages[2] = 0.4;
  out->max_steps = 10000;
  out->lod_levels = 4;
  out->lattice_steps = 8;
  out->parts = true;
}

void scree_hoodoo_rules_view(const scree_hoodoo_rules* rules, scree_weather_rules* out) {
  *out = (scree_weather_rules){
      .durability = rules->durability,
      .durability_count = rules->durability_count,
      .bubbles = rules->bubbles,
      .bubble_count = rules->bubble_count,
      .spheroidal = rules->spheroidal,
      .cavernous = rules->cavernous,
      .exposure = rules->exposure,
      .steps_per_voxel = rules->steps_per_voxel,
      .colluvium_share = rules->colluvium_share,
      .colluvium_durability = rules->colluvium_durability,
      .repose = rules->repose,
      .rockfall = rules->rockfall,
  };
}

static scree_result check_graphs(const scree_hoodoo_rules* rules, const char* where, scree_error* error) {
  for (uint32_t i = 1; i < rules->durability_count; ++i)
    if (!(rules->durability[i].altitude >= rules->durability[i - 1].altitude)) {
      recipe_say(error, "%sdurability[%u].altitude: %g is below that of the point before, %g", where, i,
                 rules->durability[i].altitude, rules->durability[i - 1].altitude);
      return SCREE_ERROR_RANGE;
    }
  for (uint32_t i = 1; i < rules->bubble_count; ++i)
    if (!(rules->bubbles[i].altitude > rules->bubbles[i - 1].altitude)) {
      recipe_say(error, "%sbubbles[%u].altitude: %g is not above that of the segment before, %g", where, i,
                 rules->bubbles[i].altitude, rules->bubbles[i - 1].altitude);
      return SCREE_ERROR_RANGE;
    }
  return SCREE_OK;
}

static scree_result check_start(const scree_hoodoo_recipe* recipe, scree_error* error) {
  const scree_hoodoo_start* start = &recipe->start;
  if (start->shape == SCREE_HOODOO_BOX || start->shape == SCREE_HOODOO_JOINTS) {
    bool whole = true;
    for (int a = 0; a < 3; ++a) whole = whole && start->min[a] == 0 && start->max[a] == 0;
    for (int a = 0; a < 3 && !whole; ++a)
      if (start->min[a] >= start->max[a] || start->max[a] > recipe->size[a]) {
        recipe_say(error, "start.max[%d]: expected a number above start.min[%d], %u, and at most size[%d], %u, got %u", a, a,
                   start->min[a], a, recipe->size[a], start->max[a]);
        return SCREE_ERROR_RANGE;
      }
  }
  if ((start->shape == SCREE_HOODOO_JOINT_MAP || start->shape == SCREE_HOODOO_MESH) && start->file[0] == '\0') {
    recipe_say(error, "start.file: missing");
    return SCREE_ERROR_RANGE;
  }
  return SCREE_OK;
}

scree_result hoodoo_check(const scree_hoodoo_recipe* recipe, scree_error* error) {
  scree_result result = check_start(recipe, error);
  if (result == SCREE_OK) result = check_graphs(&recipe->rules, "", error);
  for (uint32_t i = 0; i < recipe->phase_count && result == SCREE_OK; ++i) {
    char where[32] = "phases[0].";
    where[7] = (char)('0' + i);
    result = check_graphs(&recipe->phases[i].rules, where, error);
  }
  for (uint32_t i = 1; i < recipe->age_count && result == SCREE_OK; ++i)
    if (!(recipe->ages[i] < recipe->ages[i - 1])) {
      recipe_say(error, "ages[%u]: %g is not less than the age before, %g", i, recipe->ages[i], recipe->ages[i - 1]);
      result = SCREE_ERROR_RANGE;
    }
  for (uint32_t i = 1; i < recipe->age_step_count && result == SCREE_OK; ++i)
    if (recipe->age_steps[i] <= recipe->age_steps[i - 1]) {
      recipe_say(error, "age_steps[%u]: %u is not more than the age before, %u", i, recipe->age_steps[i], recipe->age_steps[i - 1]);
      result = SCREE_ERROR_RANGE;
    }
  if (result == SCREE_OK && (recipe->age_count == 0) == (recipe->age_step_count == 0)) {
    recipe_say(error, "ages: expected either ages or age_steps");
    result = SCREE_ERROR_RANGE;
  }
  if (result == SCREE_OK && recipe->age_step_count > 0 && recipe->age_steps[recipe->age_step_count - 1] > recipe->max_steps) {
    recipe_say(error, "age_steps[%u]: %u is more than max_steps, %u", recipe->age_step_count - 1,
               recipe->age_steps[recipe->age_step_count - 1], recipe->max_steps);
    result = SCREE_ERROR_RANGE;
  }
  if (result == SCREE_OK && recipe->lattice_steps % 2 != 0) {
    recipe_say(error, "lattice_steps: %u must be even, so that the middles of voxels lie on the lattice", recipe->lattice_steps);
    result = SCREE_ERROR_RANGE;
  }
  return result;
}
