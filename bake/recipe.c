/* Recipes: defaults, reading from JSON, overriding single keys, writing. One table names every key, its type and its range, so that
 * the reader, the writer and --set cannot disagree; content/schema/recipe.schema.json is held against it by a test. */
#include "recipe.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "recipe_text.h"

#define TURN_QUARTER 1.5707963267948966

const recipe_key recipe_keys[] = {
    {"name", RECIPE_TEXT, offsetof(scree_recipe, name), 0, 63, NULL},
    {"random_seed", RECIPE_SEED, offsetof(scree_recipe, random_seed), 0, 9007199254740992.0, NULL},
    {"n", RECIPE_COUNT, offsetof(scree_recipe, n), 4, 9, NULL},
    {"seeds", RECIPE_COUNT_RANGE, offsetof(scree_recipe, seeds_min), 1, 20, NULL},
    {"alpha", RECIPE_RANGE, offsetof(scree_recipe, alpha), 0.01, 100, NULL},
    {"beta", RECIPE_RANGE, offsetof(scree_recipe, beta), 0.01, 100, NULL},
    {"gamma", RECIPE_RANGE, offsetof(scree_recipe, gamma), 0.01, 100, NULL},
    {"g", RECIPE_RANGE, offsetof(scree_recipe, g), 0.01, 16, NULL},
    {"orientation", RECIPE_CHOICE, offsetof(scree_recipe, orientation), 0, 1, "random aligned"},
    {"align_axis", RECIPE_VECTOR, offsetof(scree_recipe, align_axis), -1e6, 1e6, NULL},
    {"align_angle", RECIPE_NUMBER, offsetof(scree_recipe, align_angle), 0, TURN_QUARTER, NULL},
    {"jitter", RECIPE_NUMBER, offsetof(scree_recipe, jitter), 0, 1, NULL},
    {"contact_radius", RECIPE_NUMBER, offsetof(scree_recipe, contact_radius), 0, 0.5, NULL},
    {"contact_blend", RECIPE_NUMBER, offsetof(scree_recipe, contact_blend), 0.01, 1.5, NULL},
    {"contact_discard", RECIPE_NUMBER, offsetof(scree_recipe, contact_discard), 0, 1, NULL},
    {"erosion", RECIPE_NUMBER, offsetof(scree_recipe, erosion), 0, 0.5, NULL},
    {"erosion_steps", RECIPE_COUNT, offsetof(scree_recipe, erosion_steps), 0, 64, NULL},
    {"erosion_strength", RECIPE_NUMBER, offsetof(scree_recipe, erosion_strength), 0, 1, NULL},
    {"chisel_planes", RECIPE_COUNT, offsetof(scree_recipe, chisel_planes), 0, 64, NULL},
    {"chisel_margin", RECIPE_NUMBER, offsetof(scree_recipe, chisel_margin), 0, 0.5, NULL},
    {"noise", RECIPE_NUMBER, offsetof(scree_recipe, noise), 0, 0.5, NULL},
    {"noise_frequency", RECIPE_NUMBER, offsetof(scree_recipe, noise_frequency), 0.01, 16, NULL},
    {"noise_octaves", RECIPE_COUNT, offsetof(scree_recipe, noise_octaves), 1, 6, NULL},
    {"voxels_per_cell", RECIPE_COUNT, offsetof(scree_recipe, voxels_per_cell), 6, 28, NULL},
    {"lod_levels", RECIPE_COUNT, offsetof(scree_recipe, lod_levels), 1, 6, NULL},
    {"lattice_steps", RECIPE_COUNT, offsetof(scree_recipe, lattice_steps), 2, 64, NULL},
    {"hull_vertices", RECIPE_COUNT, offsetof(scree_recipe, hull_vertices), 8, 64, NULL},
    {"proxies", RECIPE_BOOL, offsetof(scree_recipe, proxies), 0, 1, NULL},
};
const size_t recipe_key_count = sizeof recipe_keys / sizeof *recipe_keys;

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

static const recipe_key* find_key(const char* name) {
  for (size_t i = 0; i < recipe_key_count; ++i)
    if (strcmp(recipe_keys[i].name, name) == 0) return &recipe_keys[i];
  return NULL;
}

static scree_result read_number(const recipe_key* key, const cJSON* value, bool whole, double* out, scree_error* error) {
  char text[64];
  recipe_describe(value, text, sizeof text);
  if (!cJSON_IsNumber(value)) {
    recipe_say(error, "%s: expected a number, got %s", key->name, text);
    return SCREE_ERROR_SYNTAX;
  }
  const double number = value->valuedouble;
  if (!(number >= key->min && number <= key->max) || (whole && floor(number) != number)) {
    recipe_say(error, "%s: expected a %snumber from %.10g to %.10g, got %.10g", key->name, whole ? "whole " : "", key->min,
               key->max, number);
    return SCREE_ERROR_RANGE;
  }
  *out = number;
  return SCREE_OK;
}

/* A number, or [least, most]. */
static scree_result read_range(const recipe_key* key, const cJSON* value, bool whole, double out[2], scree_error* error) {
  if (!cJSON_IsArray(value)) {
    const scree_result result = read_number(key, value, whole, &out[0], error);
    out[1] = out[0];
    return result;
  }
  if (cJSON_GetArraySize(value) != 2) {
    recipe_say(error, "%s: expected a number or [least, most], got %d numbers", key->name, cJSON_GetArraySize(value));
    return SCREE_ERROR_SYNTAX;
  }
  for (int i = 0; i < 2; ++i) {
    const scree_result result = read_number(key, cJSON_GetArrayItem(value, i), whole, &out[i], error);
    if (result != SCREE_OK) return result;
  }
  if (out[0] > out[1]) {
    recipe_say(error, "%s: the least number, %.10g, is greater than the most, %.10g", key->name, out[0], out[1]);
    return SCREE_ERROR_RANGE;
  }
  return SCREE_OK;
}

static scree_result read_choice(const recipe_key* key, const cJSON* value, int* out, scree_error* error) {
  char text[64];
  recipe_describe(value, text, sizeof text);
  if (cJSON_IsString(value)) {
    const char* word = key->choices;
    for (int i = 0; word != NULL; ++i) {
      const char* space = strchr(word, ' ');
      const size_t length = space == NULL ? strlen(word) : (size_t)(space - word);
      if (strlen(value->valuestring) == length && strncmp(word, value->valuestring, length) == 0) {
        *out = i;
        return SCREE_OK;
      }
      word = space == NULL ? NULL : space + 1;
    }
  }
  recipe_say(error, "%s: expected one of: %s; got %s", key->name, key->choices, text);
  return SCREE_ERROR_SYNTAX;
}

static scree_result read_value(const recipe_key* key, const cJSON* value, scree_recipe* out, scree_error* error) {
  char* field = (char*)out + key->offset;
  double number[3];
  scree_result result = SCREE_OK;
  char text[64];
  recipe_describe(value, text, sizeof text);
  switch (key->kind) {
    case RECIPE_TEXT:
      if (!cJSON_IsString(value) || strlen(value->valuestring) > (size_t)key->max) {
        recipe_say(error, "%s: expected a text of at most %.0f bytes, got %s", key->name, key->max, text);
        return SCREE_ERROR_SYNTAX;
      }
      strcpy(field, value->valuestring);
      break;
    case RECIPE_SEED:
      result = read_number(key, value, true, number, error);
      if (result == SCREE_OK) *(uint64_t*)(void*)field = (uint64_t)number[0];
      break;
    case RECIPE_COUNT:
      result = read_number(key, value, true, number, error);
      if (result == SCREE_OK) *(uint32_t*)(void*)field = (uint32_t)number[0];
      break;
    case RECIPE_COUNT_RANGE:
      result = read_range(key, value, true, number, error);
      if (result == SCREE_OK)
        ((uint32_t*)(void*)field)[0] = (uint32_t)number[0], ((uint32_t*)(void*)field)[1] = (uint32_t)number[1];
      break;
    case RECIPE_NUMBER: result = read_number(key, value, false, (double*)(void*)field, error); break;
    case RECIPE_RANGE:
      result = read_range(key, value, false, number, error);
      if (result == SCREE_OK) *(scree_range*)(void*)field = (scree_range){number[0], number[1]};
      break;
    case RECIPE_VECTOR:
      if (!cJSON_IsArray(value) || cJSON_GetArraySize(value) != 3) {
        recipe_say(error, "%s: expected three numbers [x, y, z], got %s", key->name, text);
        return SCREE_ERROR_SYNTAX;
      }
      for (int i = 0; i < 3 && result == SCREE_OK; ++i)
        result = read_number(key, cJSON_GetArrayItem(value, i), false, &number[i], error);
      if (result == SCREE_OK) memcpy(field, number, sizeof number);
      break;
    case RECIPE_BOOL:
      if (!cJSON_IsBool(value)) {
        recipe_say(error, "%s: expected true or false, got %s", key->name, text);
        return SCREE_ERROR_SYNTAX;
      }
      *(bool*)(void*)field = cJSON_IsTrue(value) != 0;
      break;
    case RECIPE_CHOICE: {
      int choice;
      result = read_choice(key, value, &choice, error);
      if (result == SCREE_OK) out->orientation = (scree_orientation)choice;
      break;
    }
  }
  return result;
}

/* What no key alone can say. */
static scree_result recipe_check(const scree_recipe* recipe, scree_error* error) {
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

scree_result scree_recipe_parse(const char* text, size_t size, scree_recipe* out, scree_error* error) {
  scree_recipe_default(out);
  cJSON* root = recipe_root(text, size, error);
  if (root == NULL) return SCREE_ERROR_SYNTAX;
  scree_result result = SCREE_OK;
  for (const cJSON* item = root->child; item != NULL && result == SCREE_OK; item = item->next) {
    const recipe_key* key = find_key(item->string);
    const bool schema = strcmp(item->string, "$schema") == 0, kind = strcmp(item->string, "kind") == 0;
    if (schema && cJSON_IsString(item)) continue;
    if (kind && cJSON_IsString(item) && strcmp(item->valuestring, "rocks") == 0) continue;
    if (key != NULL) {
      result = read_value(key, item, out, error);
      continue;
    }
    recipe_say(error, schema ? "%.60s: expected a text" : kind ? "%.60s: expected \"rocks\"" : "%.60s: unknown key", item->string);
    result = SCREE_ERROR_SYNTAX;
  }
  cJSON_Delete(root);
  return result == SCREE_OK ? recipe_check(out, error) : result;
}

scree_result scree_recipe_set(scree_recipe* recipe, const char* assignment, scree_error* error) {
  char name[RECIPE_NAME_SIZE];
  const char* text = recipe_assignment(assignment, name, error);
  if (text == NULL) return SCREE_ERROR_SYNTAX;
  const recipe_key* key = find_key(name);
  if (key == NULL) {
    recipe_say(error, "%s: unknown key", name);
    return SCREE_ERROR_SYNTAX;
  }
  cJSON* value = recipe_set_value(text);
  if (value == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  scree_recipe changed = *recipe;
  scree_result result = read_value(key, value, &changed, error);
  cJSON_Delete(value);
  if (result == SCREE_OK) result = recipe_check(&changed, error);
  if (result == SCREE_OK) *recipe = changed;
  return result;
}

size_t scree_recipe_write(const scree_recipe* recipe, char* text, size_t capacity) {
  recipe_writer out = {text, capacity, 0};
  recipe_put(&out, "{\n");
  for (size_t i = 0; i < recipe_key_count; ++i) {
    const recipe_key* key = &recipe_keys[i];
    const char* field = (const char*)recipe + key->offset;
    recipe_put(&out, "  \"%s\": ", key->name);
    switch (key->kind) {
      case RECIPE_TEXT: recipe_put_text(&out, field); break;
      case RECIPE_SEED: recipe_put(&out, "%llu", (unsigned long long)*(const uint64_t*)(const void*)field); break;
      case RECIPE_COUNT: recipe_put(&out, "%u", *(const uint32_t*)(const void*)field); break;
      case RECIPE_COUNT_RANGE: {
        const uint32_t* range = (const uint32_t*)(const void*)field;
        if (range[0] == range[1])
          recipe_put(&out, "%u", range[0]);
        else
          recipe_put(&out, "[%u, %u]", range[0], range[1]);
        break;
      }
      case RECIPE_NUMBER: recipe_put_number(&out, *(const double*)(const void*)field); break;
      case RECIPE_RANGE: {
        const scree_range* range = (const scree_range*)(const void*)field;
        if (range->min != range->max) recipe_put(&out, "[");
        recipe_put_number(&out, range->min);
        if (range->min != range->max) {
          recipe_put(&out, ", ");
          recipe_put_number(&out, range->max);
          recipe_put(&out, "]");
        }
        break;
      }
      case RECIPE_VECTOR: {
        const double* vector = (const double*)(const void*)field;
        for (int axis = 0; axis < 3; ++axis) {
          recipe_put(&out, axis == 0 ? "[" : ", ");
          recipe_put_number(&out, vector[axis]);
        }
        recipe_put(&out, "]");
        break;
      }
      case RECIPE_BOOL: recipe_put(&out, "%s", *(const bool*)(const void*)field ? "true" : "false"); break;
      case RECIPE_CHOICE: recipe_put_text(&out, recipe->orientation == SCREE_ORIENTATION_ALIGNED ? "aligned" : "random"); break;
    }
    recipe_put(&out, i + 1 < recipe_key_count ? ",\n" : "\n");
  }
  recipe_put(&out, "}\n");
  return out.size;
}

scree_result recipe_check_all(const scree_recipe* recipe, scree_error* error) {
  for (size_t i = 0; i < recipe_key_count; ++i) {
    const recipe_key* key = &recipe_keys[i];
    const char* field = (const char*)recipe + key->offset;
    double values[3] = {key->min, key->min, key->min};
    switch (key->kind) {
      case RECIPE_TEXT:
      case RECIPE_BOOL:
      case RECIPE_CHOICE: continue;
      case RECIPE_SEED: values[0] = (double)*(const uint64_t*)(const void*)field; break;
      case RECIPE_COUNT: values[0] = *(const uint32_t*)(const void*)field; break;
      case RECIPE_COUNT_RANGE:
        values[0] = ((const uint32_t*)(const void*)field)[0];
        values[1] = ((const uint32_t*)(const void*)field)[1];
        break;
      case RECIPE_NUMBER: values[0] = *(const double*)(const void*)field; break;
      case RECIPE_RANGE:
        values[0] = ((const scree_range*)(const void*)field)->min;
        values[1] = ((const scree_range*)(const void*)field)->max;
        break;
      case RECIPE_VECTOR: memcpy(values, field, sizeof values); break;
    }
    for (int v = 0; v < 3; ++v)
      if (!(values[v] >= key->min && values[v] <= key->max)) {
        recipe_say(error, "%s: expected a number from %.10g to %.10g, got %.10g", key->name, key->min, key->max, values[v]);
        return SCREE_ERROR_RANGE;
      }
    if ((key->kind == RECIPE_RANGE || key->kind == RECIPE_COUNT_RANGE) && values[0] > values[1]) {
      recipe_say(error, "%s: the least number, %.10g, is greater than the most, %.10g", key->name, values[0], values[1]);
      return SCREE_ERROR_RANGE;
    }
  }
  return recipe_check(recipe, error);
}
