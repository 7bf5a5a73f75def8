/* Recipes of hoodoos: the tables of keys, defaults, and the rules between keys; content/schema/hoodoo.schema.json is held against
 * the tables by a test. */
#include "hoodoo_recipe.h"

#include <string.h>

#include "recipe_text.h"

#define SHAPE(name) (1u << SCREE_HOODOO_##name)

static const recipe_key point_keys[] = {
    {"altitude", RECIPE_NUMBER, KEY_AT(scree_durability_point, altitude), KEY_ENDS(0, 1)},
    {"durability", RECIPE_NUMBER, KEY_AT(scree_durability_point, durability), KEY_ENDS(1e-3, 1e6)},
    {"noise", RECIPE_NUMBER, KEY_AT(scree_durability_point, noise_amplitude), KEY_ENDS(0, 4)},
    {"period", RECIPE_NUMBER, KEY_AT(scree_durability_point, noise_period), KEY_ENDS(1, 1e4)},
    {"squash", RECIPE_NUMBER, KEY_AT(scree_durability_point, noise_squash), KEY_ENDS(0.1, 100)},
    {0},
};

static const recipe_key bubble_keys[] = {
    {"kind", RECIPE_CHOICE, KEY_AT(scree_bubble, kind), KEY_ENDS(0, 3), .words = "sphere ellipsoid gumdrop disc"},
    {"radius", RECIPE_NUMBER, KEY_AT(scree_bubble, radius), KEY_ENDS(1, 12)},
    {"height", RECIPE_NUMBER, KEY_AT(scree_bubble, height), KEY_ENDS(1, 12)},
    {0},
};

static const scree_bubble default_bubble = {SCREE_BUBBLE_SPHERE, 4, 4};

static const recipe_key segment_keys[] = {
    {"altitude", RECIPE_NUMBER, KEY_AT(scree_bubble_segment, altitude), KEY_ENDS(0, 1)},
    {"mixture", RECIPE_LIST, KEY_AT(scree_bubble_segment, bubbles), .members = bubble_keys, .blank = &default_bubble,
     .count_at = offsetof(scree_bubble_segment, bubble_count), .stride = sizeof(scree_bubble), .least = 1, .size = 4,
     .of = "bubbles", .alone = true},
    {"period", RECIPE_NUMBER, KEY_AT(scree_bubble_segment, noise_period), KEY_ENDS(1, 1e4)},
    {0},
};

static const recipe_key curve_keys[] = {
    {"curve", RECIPE_CHOICE, KEY_AT(scree_curve, kind), KEY_ENDS(0, 4), .words = "none linear cubic quartic saturating"},
    {"gain", RECIPE_NUMBER, KEY_AT(scree_curve, gain), KEY_ENDS(0, 1000)},
    {"threshold", RECIPE_NUMBER, KEY_AT(scree_curve, threshold), KEY_ENDS(-1, 1)},
    {"saturation", RECIPE_NUMBER, KEY_AT(scree_curve, saturation), KEY_ENDS(1e-3, 2)},
    {"power", RECIPE_COUNT, KEY_AT(scree_curve, power), KEY_ENDS(1, 4)},
    {0},
};

static const recipe_key colluvium_keys[] = {
    {"share", RECIPE_NUMBER, KEY_AT(scree_hoodoo_rules, colluvium_share), KEY_ENDS(0, 1)},
    {"durability", RECIPE_NUMBER, KEY_AT(scree_hoodoo_rules, colluvium_durability), KEY_ENDS(1e-3, 1e6)},
    {"repose", RECIPE_NUMBER, KEY_AT(scree_hoodoo_rules, repose), KEY_ENDS(0.0625, 4)},
    {0},
};

/* What short rows and objects leave out; a curve of cavities that is given is no straight one. */
static const scree_durability_point default_point = {0, 1, 0, 16, 1};
static const scree_bubble_segment default_segment = {
    .bubbles = {{SCREE_BUBBLE_SPHERE, 4, 4}}, .bubble_count = 1, .noise_period = 16};
static const scree_curve default_cavernous = {SCREE_CURVE_SATURATING, 1, 0, 1, 1};

static const recipe_key rule_keys[] = {
    {"durability", RECIPE_ROWS, KEY_AT(scree_hoodoo_rules, durability), .members = point_keys, .blank = &default_point,
     .count_at = offsetof(scree_hoodoo_rules, durability_count), .stride = sizeof(scree_durability_point), .least = 1,
     .size = SCREE_HOODOO_POINTS, .columns = 2, .of = "points"},
    {"bubbles", RECIPE_LIST, KEY_AT(scree_hoodoo_rules, bubbles), .members = segment_keys, .blank = &default_segment,
     .count_at = offsetof(scree_hoodoo_rules, bubble_count), .stride = sizeof(scree_bubble_segment), .least = 1,
     .size = SCREE_HOODOO_SEGMENTS, .of = "segments"},
    {"spheroidal", RECIPE_OBJECT, KEY_AT(scree_hoodoo_rules, spheroidal), .members = curve_keys},
    {"cavernous", RECIPE_OBJECT, KEY_AT(scree_hoodoo_rules, cavernous), .members = curve_keys, .blank = &default_cavernous},
    {"exposure", RECIPE_NUMBER, KEY_AT(scree_hoodoo_rules, exposure), KEY_ENDS(0, 2)},
    {"steps_per_voxel", RECIPE_NUMBER, KEY_AT(scree_hoodoo_rules, steps_per_voxel), KEY_ENDS(1, 1e4)},
    {"colluvium", RECIPE_OBJECT, .members = colluvium_keys},
    {"rockfall", RECIPE_CHOICE, KEY_AT(scree_hoodoo_rules, rockfall), KEY_ENDS(0, 2), .words = "none drop colluvium"},
    {0},
};

static const recipe_key start_keys[] = {
    {"shape", RECIPE_CHOICE, KEY_AT(scree_hoodoo_start, shape), KEY_ENDS(0, 7),
     .words = "box column joint_map joints sphere cylinder cone mesh"},
    {"min", RECIPE_COUNTS, KEY_AT(scree_hoodoo_start, min), KEY_ENDS(0, 4096), .size = 3, .only = SHAPE(BOX) | SHAPE(JOINTS)},
    {"max", RECIPE_COUNTS, KEY_AT(scree_hoodoo_start, max), KEY_ENDS(0, 4096), .size = 3, .only = SHAPE(BOX) | SHAPE(JOINTS)},
    {"radius", RECIPE_NUMBER, KEY_AT(scree_hoodoo_start, radius), KEY_ENDS(1, 4096),
     .only = SHAPE(COLUMN) | SHAPE(SPHERE) | SHAPE(CYLINDER) | SHAPE(CONE)},
    {"height", RECIPE_NUMBER, KEY_AT(scree_hoodoo_start, height), KEY_ENDS(0, 4096),
     .only = SHAPE(COLUMN) | SHAPE(CYLINDER) | SHAPE(CONE)},
    {"lift", RECIPE_NUMBER, KEY_AT(scree_hoodoo_start, lift), KEY_ENDS(0, 4096),
     .only = SHAPE(SPHERE) | SHAPE(CYLINDER) | SHAPE(CONE)},
    {"lobes", RECIPE_NUMBER, KEY_AT(scree_hoodoo_start, lobes), KEY_ENDS(0, 2), .only = SHAPE(COLUMN)},
    {"spacing", RECIPE_NUMBER, KEY_AT(scree_hoodoo_start, spacing), KEY_ENDS(4, 4096), .only = SHAPE(JOINTS)},
    {"gap", RECIPE_NUMBER, KEY_AT(scree_hoodoo_start, gap), KEY_ENDS(0, 0.5), .only = SHAPE(JOINTS)},
    {"warp", RECIPE_NUMBER, KEY_AT(scree_hoodoo_start, warp), KEY_ENDS(0, 1), .only = SHAPE(JOINTS)},
    {"missing", RECIPE_NUMBER, KEY_AT(scree_hoodoo_start, missing), KEY_ENDS(0, 1), .only = SHAPE(JOINTS)},
    {"low", RECIPE_NUMBER, KEY_AT(scree_hoodoo_start, low), KEY_ENDS(0, 1), .only = SHAPE(JOINTS)},
    {"file", RECIPE_TEXT, KEY_AT(scree_hoodoo_start, file), KEY_ENDS(0, 255), .only = SHAPE(JOINT_MAP) | SHAPE(MESH)},
    {0},
};

/* When a phase begins; the keys of rules come on top. */
static const recipe_key phase_keys[] = {
    {"share", RECIPE_NUMBER, KEY_AT(scree_hoodoo_phase, share), KEY_ENDS(0, 1)},
    {"steps", RECIPE_COUNT, KEY_AT(scree_hoodoo_phase, steps), KEY_ENDS(0, 1e6)},
    {0},
};

static const recipe_key top_keys[] = {
    {"name", RECIPE_TEXT, KEY_AT(scree_hoodoo_recipe, name), KEY_ENDS(0, 63)},
    {"random_seed", RECIPE_SEED, KEY_AT(scree_hoodoo_recipe, random_seed), KEY_ENDS(0, 9007199254740992.0)},
    {"voxel", RECIPE_NUMBER, KEY_AT(scree_hoodoo_recipe, voxel), KEY_ENDS(0.001, 100)},
    {"size", RECIPE_COUNTS, KEY_AT(scree_hoodoo_recipe, size), KEY_ENDS(1, 4096), .size = 3},
    {"start", RECIPE_OBJECT, KEY_AT(scree_hoodoo_recipe, start), .members = start_keys},
    {"phases", RECIPE_PHASES, KEY_AT(scree_hoodoo_recipe, phases), .members = phase_keys,
     .count_at = offsetof(scree_hoodoo_recipe, phase_count), .stride = sizeof(scree_hoodoo_phase), .size = SCREE_HOODOO_PHASES,
     .of = "phases"},
    {"variants", RECIPE_COUNT, KEY_AT(scree_hoodoo_recipe, variants), KEY_ENDS(1, SCREE_HOODOO_VARIANTS)},
    {"ages", RECIPE_VALUES, KEY_AT(scree_hoodoo_recipe, ages), KEY_ENDS(0, 1), .count_at = offsetof(scree_hoodoo_recipe, age_count),
     .stride = sizeof(double), .least = 1, .size = SCREE_HOODOO_AGES, .of = "ages"},
    {"age_steps", RECIPE_TIMES, KEY_AT(scree_hoodoo_recipe, age_steps), KEY_ENDS(0, 1e6),
     .count_at = offsetof(scree_hoodoo_recipe, age_step_count), .stride = sizeof(uint32_t), .least = 1, .size = SCREE_HOODOO_AGES,
     .of = "ages"},
    {"max_steps", RECIPE_COUNT, KEY_AT(scree_hoodoo_recipe, max_steps), KEY_ENDS(1, 1e6)},
    {"lod_levels", RECIPE_COUNT, KEY_AT(scree_hoodoo_recipe, lod_levels), KEY_ENDS(1, 6)},
    {"lattice_steps", RECIPE_COUNT, KEY_AT(scree_hoodoo_recipe, lattice_steps), KEY_ENDS(2, 64)},
    {"parts", RECIPE_BOOL, KEY_AT(scree_hoodoo_recipe, parts), KEY_ENDS(0, 1)},
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

/* changes: of scree_hoodoo_phase; what is not among them says nothing. */
static scree_result check_graphs(const scree_hoodoo_rules* rules, uint32_t changes, const char* where, scree_error* error) {
  const uint32_t points = (changes & SCREE_HOODOO_DURABILITY) != 0 ? rules->durability_count : 0;
  const uint32_t segments = (changes & SCREE_HOODOO_BUBBLES) != 0 ? rules->bubble_count : 0;
  for (uint32_t i = 1; i < points; ++i)
    if (!(rules->durability[i].altitude >= rules->durability[i - 1].altitude)) {
      recipe_say(error, "%sdurability[%u].altitude: %g is below that of the point before, %g", where, i,
                 rules->durability[i].altitude, rules->durability[i - 1].altitude);
      return SCREE_ERROR_RANGE;
    }
  for (uint32_t i = 1; i < segments; ++i)
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

static scree_result check(const void* from, scree_error* error) {
  const scree_hoodoo_recipe* recipe = from;
  scree_result result = check_start(recipe, error);
  if (result == SCREE_OK) result = check_graphs(&recipe->rules, ~0u, "", error);
  for (uint32_t i = 0; i < recipe->phase_count && result == SCREE_OK; ++i) {
    char where[32] = "phases[0].";
    where[7] = (char)('0' + i);
    result = check_graphs(&recipe->phases[i].rules, recipe->phases[i].changes, where, error);
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

const recipe_table hoodoo_table = {.kind = "hoodoo",
                                   .kind_is_needed = true,
                                   .keys = top_keys,
                                   .rules = rule_keys,
                                   .rules_at = offsetof(scree_hoodoo_recipe, rules),
                                   .phase_rules_at = offsetof(scree_hoodoo_phase, rules),
                                   .phase_changes_at = offsetof(scree_hoodoo_phase, changes),
                                   .rules_before = "phases",
                                   .either = {"ages", "age_steps"},
                                   .size = sizeof(scree_hoodoo_recipe),
                                   .check = check};

scree_result scree_hoodoo_parse(const char* text, size_t size, scree_hoodoo_recipe* out, scree_error* error) {
  scree_hoodoo_recipe plain;
  scree_hoodoo_default(&plain);
  return recipe_read(&hoodoo_table, &plain, text, size, out, error);
}

scree_result scree_hoodoo_set(scree_hoodoo_recipe* recipe, const char* assignment, scree_error* error) {
  scree_hoodoo_recipe plain, changed = *recipe;
  scree_hoodoo_default(&plain);
  const scree_result result = recipe_assign(&hoodoo_table, &plain, assignment, &changed, error);
  if (result == SCREE_OK) *recipe = changed;
  return result;
}

size_t scree_hoodoo_write(const scree_hoodoo_recipe* recipe, char* text, size_t capacity) {
  return recipe_write(&hoodoo_table, recipe, text, capacity);
}

scree_result hoodoo_check_all(const scree_hoodoo_recipe* recipe, scree_error* error) {
  return recipe_check_keys(&hoodoo_table, recipe, error);
}
