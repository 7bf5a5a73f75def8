/* Recipes of rocks: the table of keys, defaults, and the rules between keys; content/schema/recipe.schema.json is held against the
 * table by a test. */
#include "recipe.h"

#include <string.h>

#include "recipe_text.h"

#define TURN_QUARTER 1.5707963267948966

static const recipe_key keys[] = {
    {"name", RECIPE_TEXT, KEY_AT(scree_recipe, name), KEY_ENDS(0, 63)},
    {"random_seed", RECIPE_SEED, KEY_AT(scree_recipe, random_seed), KEY_ENDS(0, 9007199254740992.0)},
    {"n", RECIPE_COUNT, KEY_AT(scree_recipe, n), KEY_ENDS(4, 9)},
    {"seeds", RECIPE_COUNT_RANGE, KEY_AT(scree_recipe, seeds_min), KEY_ENDS(1, 20)},
    {"alpha", RECIPE_RANGE, KEY_AT(scree_recipe, alpha), KEY_ENDS(0.01, 100)},
    {"beta", RECIPE_RANGE, KEY_AT(scree_recipe, beta), KEY_ENDS(0.01, 100)},
    {"gamma", RECIPE_RANGE, KEY_AT(scree_recipe, gamma), KEY_ENDS(0.01, 100)},
    {"g", RECIPE_RANGE, KEY_AT(scree_recipe, g), KEY_ENDS(0.01, 16)},
    {"orientation", RECIPE_CHOICE, KEY_AT(scree_recipe, orientation), KEY_ENDS(0, 1), .words = "random aligned"},
    {"align_axis", RECIPE_NUMBERS, KEY_AT(scree_recipe, align_axis), KEY_ENDS(-1e6, 1e6), .size = 3},
    {"align_angle", RECIPE_NUMBER, KEY_AT(scree_recipe, align_angle), KEY_ENDS(0, TURN_QUARTER)},
    {"jitter", RECIPE_NUMBER, KEY_AT(scree_recipe, jitter), KEY_ENDS(0, 1)},
    {"contact_radius", RECIPE_NUMBER, KEY_AT(scree_recipe, contact_radius), KEY_ENDS(0, 0.5)},
    {"contact_blend", RECIPE_NUMBER, KEY_AT(scree_recipe, contact_blend), KEY_ENDS(0.01, 1.5)},
    {"contact_discard", RECIPE_NUMBER, KEY_AT(scree_recipe, contact_discard), KEY_ENDS(0, 1)},
    {"erosion", RECIPE_NUMBER, KEY_AT(scree_recipe, erosion), KEY_ENDS(0, 0.5)},
    {"erosion_steps", RECIPE_COUNT, KEY_AT(scree_recipe, erosion_steps), KEY_ENDS(0, 64)},
    {"erosion_strength", RECIPE_NUMBER, KEY_AT(scree_recipe, erosion_strength), KEY_ENDS(0, 1)},
    {"chisel_planes", RECIPE_COUNT, KEY_AT(scree_recipe, chisel_planes), KEY_ENDS(0, 64)},
    {"chisel_margin", RECIPE_NUMBER, KEY_AT(scree_recipe, chisel_margin), KEY_ENDS(0, 0.5)},
    {"noise", RECIPE_NUMBER, KEY_AT(scree_recipe, noise), KEY_ENDS(0, 0.5)},
    {"noise_frequency", RECIPE_NUMBER, KEY_AT(scree_recipe, noise_frequency), KEY_ENDS(0.01, 16)},
    {"noise_octaves", RECIPE_COUNT, KEY_AT(scree_recipe, noise_octaves), KEY_ENDS(1, 6)},
    {"voxels_per_cell", RECIPE_COUNT, KEY_AT(scree_recipe, voxels_per_cell), KEY_ENDS(6, 28)},
    {"lod_levels", RECIPE_COUNT, KEY_AT(scree_recipe, lod_levels), KEY_ENDS(1, 6)},
    {"lattice_steps", RECIPE_COUNT, KEY_AT(scree_recipe, lattice_steps), KEY_ENDS(2, 64)},
    {"hull_vertices", RECIPE_COUNT, KEY_AT(scree_recipe, hull_vertices), KEY_ENDS(8, 64)},
    {"proxies", RECIPE_BOOL, KEY_AT(scree_recipe, proxies), KEY_ENDS(0, 1)},
    {0},
};

void scree_recipe_default(scree_recipe* out) {
  memset(out, 0, sizeof *out);
  strcpy(out->name, "boulders");
  out->random_seed = 1;
  out->n = 6;
  out->seeds_min = out->seeds_max = 1;
  out->alpha = out->beta = out->gamma = (scree_range){1, 1.6};
  out->g = (scree_range){1, 3};
  out->align_axis[1] = 1;
  out->jitter = 0.95;
  out->contact_radius = 0.08;
  out->contact_blend = 0.5;
  out->erosion = 0.07;
  out->erosion_steps = 5;
  out->erosion_strength = 0.5;
  out->chisel_planes = 12;
  out->chisel_margin = 0.05;
  out->noise = 0.1;
  out->noise_frequency = 3.5;
  out->noise_octaves = 2;
  out->voxels_per_cell = 8;
  out->lod_levels = 4;
  out->lattice_steps = 8;
  out->hull_vertices = 32;
  out->proxies = true;
}

static scree_result check(const void* from, scree_error* error) {
  const scree_recipe* recipe = from;
  if (recipe->contact_blend <= recipe->contact_radius) {
    recipe_say(error, "contact_blend: %g must be greater than contact_radius, %g", recipe->contact_blend, recipe->contact_radius);
    return SCREE_ERROR_RANGE;
  }
  if (recipe->lattice_steps % 2 != 0) {
    recipe_say(error, "lattice_steps: %u must be even, so that voxel centres lie on the lattice", recipe->lattice_steps);
    return SCREE_ERROR_RANGE;
  }
  if (recipe->voxels_per_cell % 2 != 0) {
    recipe_say(error, "voxels_per_cell: %u must be even, so that no voxel lies on the border of a cell", recipe->voxels_per_cell);
    return SCREE_ERROR_RANGE;
  }
  const double* axis = recipe->align_axis;
  if (recipe->orientation == SCREE_ORIENTATION_ALIGNED && axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2] < 1e-12) {
    recipe_say(error, "align_axis: the axis must not be zero");
    return SCREE_ERROR_RANGE;
  }
  return SCREE_OK;
}

const recipe_table rock_table = {.kind = "rocks", .keys = keys, .size = sizeof(scree_recipe), .check = check};

scree_result scree_recipe_parse(const char* text, size_t size, scree_recipe* out, scree_error* error) {
  scree_recipe plain;
  scree_recipe_default(&plain);
  return recipe_read(&rock_table, &plain, text, size, out, error);
}

scree_result scree_recipe_set(scree_recipe* recipe, const char* assignment, scree_error* error) {
  scree_recipe plain, changed = *recipe;
  scree_recipe_default(&plain);
  const scree_result result = recipe_assign(&rock_table, &plain, assignment, &changed, error);
  if (result == SCREE_OK) *recipe = changed;
  return result;
}

size_t scree_recipe_write(const scree_recipe* recipe, char* text, size_t capacity) {
  return recipe_write(&rock_table, recipe, text, capacity);
}

scree_result recipe_check_all(const scree_recipe* recipe, scree_error* error) {
  return recipe_check_keys(&rock_table, recipe, error);
}

scree_result scree_recipe_get_kind(const char* text, size_t size, scree_recipe_kind* out, scree_error* error) {
  static const char* const words[] = {"rocks", "hoodoo", "shards"};
  *out = SCREE_RECIPE_ROCKS;
  cJSON* root = recipe_root(text, size, error);
  if (root == NULL) return SCREE_ERROR_SYNTAX;
  const cJSON* kind = cJSON_GetObjectItemCaseSensitive(root, "kind");
  bool found = kind == NULL;
  for (int i = 0; i < 3 && !found; ++i)
    if (cJSON_IsString(kind) && strcmp(kind->valuestring, words[i]) == 0) {
      *out = (scree_recipe_kind)i;
      found = true;
    }
  if (!found) {
    const recipe_place at = {"kind"};
    recipe_wrong_type(&at, "\"rocks\", \"hoodoo\" or \"shards\"", kind, error);
  }
  cJSON_Delete(root);
  return found ? SCREE_OK : SCREE_ERROR_SYNTAX;
}
