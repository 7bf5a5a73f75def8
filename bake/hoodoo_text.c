/* Recipes of hoodoos as JSON: reading, setting single keys, writing, and checking what did not come from JSON, all by the tables of
 * hoodoo_recipe.c. What an object leaves out has its default. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "hoodoo_recipe.h"
#include "recipe_text.h"

static const hoodoo_key* find(const hoodoo_key* keys, const char* name) {
  for (; keys->name != NULL; ++keys)
    if (strcmp(keys->name, name) == 0) return keys;
  return NULL;
}

static scree_result check_number(const hoodoo_key* key, const recipe_place* at, double number, bool whole, scree_error* error) {
  return recipe_check_number(at, key->min, key->max, number, whole, error);
}

static scree_result read_number(const hoodoo_key* key, const recipe_place* at, const cJSON* value, bool whole, double* out,
                                scree_error* error) {
  if (!cJSON_IsNumber(value)) return recipe_wrong_type(at, "a number", value, error);
  *out = value->valuedouble;
  return check_number(key, at, *out, whole, error);
}

static scree_result read_choice(const hoodoo_key* key, const recipe_place* at, const cJSON* value, int* out, scree_error* error) {
  const char* word = key->words;
  for (int i = 0; word != NULL && cJSON_IsString(value); ++i) {
    const size_t length = strcspn(word, " ");
    if (strlen(value->valuestring) == length && strncmp(word, value->valuestring, length) == 0) {
      *out = i;
      return SCREE_OK;
    }
    word = word[length] == ' ' ? word + length + 1 : NULL;
  }
  char got[64];
  recipe_describe(value, got, sizeof got);
  recipe_say(error, "%s: expected one of: %s; got %s", at->text, key->words, got);
  return SCREE_ERROR_SYNTAX;
}

/* An array of `least` to `most` elements. */
static scree_result check_array(const recipe_place* at, const cJSON* value, double least, double most, const char* of,
                                scree_error* error) {
  if (!cJSON_IsArray(value)) {
    char expected[64];
    snprintf(expected, sizeof expected, "an array of %s", of);
    return recipe_wrong_type(at, expected, value, error);
  }
  const int count = cJSON_GetArraySize(value);
  if (count >= least && count <= most) return SCREE_OK;
  if (least == most)
    recipe_say(error, "%s: expected %.0f %s, got %d", at->text, most, of, count);
  else
    recipe_say(error, "%s: expected %.0f to %.0f %s, got %d", at->text, least, most, of, count);
  return SCREE_ERROR_SYNTAX;
}

static scree_result read_value(const hoodoo_key* key, const recipe_place* at, const cJSON* value, void* base, scree_error* error);

static scree_result read_members(const hoodoo_key* keys, const recipe_place* at, const cJSON* object, void* base,
                                 scree_error* error) {
  if (!cJSON_IsObject(object)) return recipe_wrong_type(at, "an object", object, error);
  for (const cJSON* item = object->child; item != NULL; item = item->next) {
    const hoodoo_key* key = find(keys, item->string);
    const recipe_place member = recipe_inside(at, item->string);
    scree_result result = recipe_check_member(object, item, &member, key != NULL, error);
    if (result == SCREE_OK) result = read_value(key, &member, item, base, error);
    if (result != SCREE_OK) return result;
  }
  return SCREE_OK;
}

/* Whether a shape of the start has this key. */
static scree_result check_shape(const hoodoo_key* key, const recipe_place* at, scree_hoodoo_shape shape, scree_error* error) {
  if (key->shapes == 0 || (key->shapes >> shape & 1) != 0) return SCREE_OK;
  const char* word = find(find(hoodoo_keys, "start")->members, "shape")->words;
  for (int i = 0; i < (int)shape; ++i) word += strcspn(word, " ") + 1;
  recipe_say(error, "%s: the shape %.*s has no such key", at->text, (int)strcspn(word, " "), word);
  return SCREE_ERROR_SYNTAX;
}

static scree_result read_start(const hoodoo_key* key, const recipe_place* at, const cJSON* value, scree_hoodoo_start* out,
                               scree_error* error) {
  scree_hoodoo_recipe plain;
  scree_hoodoo_default(&plain);
  *out = plain.start;
  scree_result result = read_members(key->members, at, value, out, error);
  for (const cJSON* item = result == SCREE_OK ? value->child : NULL; item != NULL && result == SCREE_OK; item = item->next) {
    const recipe_place member = recipe_inside(at, item->string);
    result = check_shape(find(key->members, item->string), &member, out->shape, error);
  }
  return result;
}

static scree_result read_object(const hoodoo_key* key, const recipe_place* at, const cJSON* value, void* base, scree_error* error) {
  if (strcmp(key->name, "start") == 0) return read_start(key, at, value, base, error);
  scree_hoodoo_recipe plain;
  scree_hoodoo_default(&plain);
  if (strcmp(key->name, "spheroidal") == 0) *(scree_curve*)base = plain.rules.spheroidal;
  if (strcmp(key->name, "cavernous") == 0) {
    *(scree_curve*)base = plain.rules.cavernous;
    ((scree_curve*)base)->kind = SCREE_CURVE_SATURATING;
  }
  if (strcmp(key->name, "colluvium") == 0) {
    scree_hoodoo_rules* rules = base;
    rules->colluvium_share = plain.rules.colluvium_share;
    rules->colluvium_durability = plain.rules.colluvium_durability;
    rules->repose = plain.rules.repose;
  }
  return read_members(key->members, at, value, base, error);
}

/* Rows [altitude, durability, noise, period, squash]; what a short row leaves out is as in the row before. */
static scree_result read_durability(const hoodoo_key* key, const recipe_place* at, const cJSON* value, scree_hoodoo_rules* out,
                                    scree_error* error) {
  scree_result result = check_array(at, value, key->min, key->max, "points", error);
  scree_durability_point point = {0, 1, 0, 16, 1};
  out->durability_count = 0;
  for (const cJSON* row = result == SCREE_OK ? value->child : NULL; row != NULL && result == SCREE_OK; row = row->next) {
    const recipe_place at_row = recipe_element(at, (int)out->durability_count);
    result = check_array(&at_row, row, 2, 5, "numbers: altitude, durability, noise, period, squash", error);
    const hoodoo_key* column = key->members;
    for (const cJSON* number = result == SCREE_OK ? row->child : NULL; number != NULL && result == SCREE_OK;
         number = number->next) {
      const recipe_place at_number = recipe_inside(&at_row, column->name);
      result = read_value(column++, &at_number, number, &point, error);
    }
    out->durability[out->durability_count++] = point;
  }
  return result;
}

static const scree_bubble default_bubble = {SCREE_BUBBLE_SPHERE, 4, 4};

static scree_result read_mixture(const hoodoo_key* key, const recipe_place* at, const cJSON* value, scree_bubble_segment* out,
                                 scree_error* error) {
  scree_result result = check_array(at, value, key->min, key->max, "bubbles", error);
  out->bubble_count = 0;
  for (const cJSON* item = result == SCREE_OK ? value->child : NULL; item != NULL && result == SCREE_OK; item = item->next) {
    const recipe_place at_item = recipe_element(at, (int)out->bubble_count);
    scree_bubble* bubble = &out->bubbles[out->bubble_count++];
    *bubble = default_bubble;
    result = read_members(key->members, &at_item, item, bubble, error);
  }
  return result;
}

/* A segment of one bubble may hold the bubble's keys itself. */
static scree_result read_segment(const hoodoo_key* keys, const recipe_place* at, const cJSON* value, scree_bubble_segment* out,
                                 scree_error* error) {
  *out = (scree_bubble_segment){.bubbles = {default_bubble}, .bubble_count = 1, .noise_period = 16};
  if (!cJSON_IsObject(value)) return recipe_wrong_type(at, "an object", value, error);
  const hoodoo_key* bubble_keys = find(keys, "mixture")->members;
  const bool mixed = cJSON_GetObjectItemCaseSensitive(value, "mixture") != NULL;
  for (const cJSON* item = value->child; item != NULL; item = item->next) {
    const recipe_place member = recipe_inside(at, item->string);
    const hoodoo_key *key = find(keys, item->string), *of_bubble = find(bubble_keys, item->string);
    scree_result result = recipe_check_member(value, item, &member, key != NULL || of_bubble != NULL, error);
    if (result == SCREE_OK && of_bubble != NULL && mixed) {
      recipe_say(error, "%s: belongs into the bubbles of the mixture", member.text);
      result = SCREE_ERROR_SYNTAX;
    }
    if (result == SCREE_OK)
      result = read_value(key != NULL ? key : of_bubble, &member, item, key != NULL ? (void*)out : out->bubbles, error);
    if (result != SCREE_OK) return result;
  }
  return SCREE_OK;
}

static scree_result read_bubbles(const hoodoo_key* key, const recipe_place* at, const cJSON* value, scree_hoodoo_rules* out,
                                 scree_error* error) {
  scree_result result = check_array(at, value, key->min, key->max, "segments", error);
  out->bubble_count = 0;
  for (const cJSON* item = result == SCREE_OK ? value->child : NULL; item != NULL && result == SCREE_OK; item = item->next) {
    const recipe_place at_item = recipe_element(at, (int)out->bubble_count);
    result = read_segment(key->members, &at_item, item, &out->bubbles[out->bubble_count++], error);
  }
  return result;
}

static scree_result read_ages(const hoodoo_key* key, const recipe_place* at, const cJSON* value, scree_hoodoo_recipe* out,
                              scree_error* error) {
  const bool steps = key->kind == HOODOO_AGE_STEPS;
  scree_result result = check_array(at, value, 1, SCREE_HOODOO_AGES, "ages", error);
  out->age_count = out->age_step_count = 0;
  for (const cJSON* item = result == SCREE_OK ? value->child : NULL; item != NULL && result == SCREE_OK; item = item->next) {
    uint32_t* count = steps ? &out->age_step_count : &out->age_count;
    const recipe_place at_item = recipe_element(at, (int)*count);
    double number = 0;
    result = read_number(key, &at_item, item, steps, &number, error);
    if (result == SCREE_OK && steps)
      out->age_steps[(*count)++] = (uint32_t)number;
    else
      out->ages[(*count)++] = number;
  }
  return result;
}

static scree_result read_phase(const hoodoo_key* keys, const recipe_place* at, const cJSON* value, scree_hoodoo_phase* out,
                               scree_error* error) {
  if (!cJSON_IsObject(value)) return recipe_wrong_type(at, "an object", value, error);
  memset(out, 0, sizeof *out);
  out->share = -1;
  uint32_t moments = 0;
  for (const cJSON* item = value->child; item != NULL; item = item->next) {
    const recipe_place member = recipe_inside(at, item->string);
    const hoodoo_key *key = find(keys, item->string), *rule = find(hoodoo_rule_keys, item->string);
    scree_result result = recipe_check_member(value, item, &member, key != NULL || rule != NULL, error);
    if (result == SCREE_OK)
      result = read_value(key != NULL ? key : rule, &member, item, key != NULL ? (void*)out : &out->rules, error);
    if (result != SCREE_OK) return result;
    moments += key != NULL;
    if (rule != NULL) out->changes |= 1u << (rule - hoodoo_rule_keys);
  }
  if (moments == 1) return SCREE_OK;
  recipe_say(error, "%s: expected either share or steps, which say when it begins", at->text);
  return SCREE_ERROR_SYNTAX;
}

static scree_result read_phases(const hoodoo_key* key, const recipe_place* at, const cJSON* value, scree_hoodoo_recipe* out,
                                scree_error* error) {
  scree_result result = check_array(at, value, key->min, key->max, "phases", error);
  out->phase_count = 0;
  for (const cJSON* item = result == SCREE_OK ? value->child : NULL; item != NULL && result == SCREE_OK; item = item->next) {
    const recipe_place at_item = recipe_element(at, (int)out->phase_count);
    result = read_phase(key->members, &at_item, item, &out->phases[out->phase_count++], error);
  }
  return result;
}

/* base: the struct that the key's table is about. */
static scree_result read_value(const hoodoo_key* key, const recipe_place* at, const cJSON* value, void* base, scree_error* error) {
  char* field = (char*)base + key->offset;
  double number = 0;
  scree_result result = SCREE_OK;
  switch (key->kind) {
    case HOODOO_TEXT:
      if (!cJSON_IsString(value) || strlen(value->valuestring) > (size_t)key->max) {
        char expected[64];
        snprintf(expected, sizeof expected, "a text of at most %.0f bytes", key->max);
        return recipe_wrong_type(at, expected, value, error);
      }
      memset(field, 0, (size_t)key->max + 1);
      strcpy(field, value->valuestring);
      return SCREE_OK;
    case HOODOO_SEED:
      result = read_number(key, at, value, true, &number, error);
      if (result == SCREE_OK) *(uint64_t*)(void*)field = (uint64_t)number;
      return result;
    case HOODOO_COUNT:
      result = read_number(key, at, value, true, &number, error);
      if (result == SCREE_OK) *(uint32_t*)(void*)field = (uint32_t)number;
      return result;
    case HOODOO_COUNTS:
      result = check_array(at, value, 3, 3, "numbers", error);
      for (int i = 0; i < 3 && result == SCREE_OK; ++i) {
        const recipe_place at_item = recipe_element(at, i);
        result = read_number(key, &at_item, cJSON_GetArrayItem(value, i), true, &number, error);
        if (result == SCREE_OK) ((uint32_t*)(void*)field)[i] = (uint32_t)number;
      }
      return result;
    case HOODOO_NUMBER: return read_number(key, at, value, false, (double*)(void*)field, error);
    case HOODOO_BOOL:
      if (!cJSON_IsBool(value)) return recipe_wrong_type(at, "true or false", value, error);
      *(bool*)(void*)field = cJSON_IsTrue(value) != 0;
      return SCREE_OK;
    case HOODOO_CHOICE: return read_choice(key, at, value, (int*)(void*)field, error);
    case HOODOO_OBJECT: return read_object(key, at, value, field, error);
    case HOODOO_DURABILITY: return read_durability(key, at, value, base, error);
    case HOODOO_BUBBLES: return read_bubbles(key, at, value, base, error);
    case HOODOO_MIXTURE: return read_mixture(key, at, value, base, error);
    case HOODOO_AGES:
    case HOODOO_AGE_STEPS: return read_ages(key, at, value, base, error);
    case HOODOO_PHASES: return read_phases(key, at, value, base, error);
  }
  return result;
}

static const recipe_place top = {""};

/* A key of the recipe or of its rules. */
static scree_result read_top(const char* name, const cJSON* value, scree_hoodoo_recipe* out, scree_error* error) {
  const hoodoo_key *key = find(hoodoo_keys, name), *rule = find(hoodoo_rule_keys, name);
  const recipe_place at = recipe_inside(&top, name);
  if (key != NULL) return read_value(key, &at, value, out, error);
  if (rule != NULL) return read_value(rule, &at, value, &out->rules, error);
  recipe_say(error, "%.60s: unknown key", name);
  return SCREE_ERROR_SYNTAX;
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
    const recipe_place at = recipe_inside(&top, "kind");
    recipe_wrong_type(&at, "\"rocks\", \"hoodoo\" or \"shards\"", kind, error);
  }
  cJSON_Delete(root);
  return found ? SCREE_OK : SCREE_ERROR_SYNTAX;
}

scree_result scree_hoodoo_parse(const char* text, size_t size, scree_hoodoo_recipe* out, scree_error* error) {
  scree_hoodoo_default(out);
  cJSON* root = recipe_root(text, size, error);
  if (root == NULL) return SCREE_ERROR_SYNTAX;
  scree_result result = SCREE_OK;
  bool ages = false, steps = false, kind = false;
  for (const cJSON* item = root->child; item != NULL && result == SCREE_OK; item = item->next) {
    if (strcmp(item->string, "$schema") == 0 && cJSON_IsString(item)) continue;
    if (strcmp(item->string, "kind") == 0 && cJSON_IsString(item) && strcmp(item->valuestring, "hoodoo") == 0) {
      kind = true;
      continue;
    }
    ages = ages || strcmp(item->string, "ages") == 0;
    steps = steps || strcmp(item->string, "age_steps") == 0;
    if (strcmp(item->string, "$schema") == 0 || strcmp(item->string, "kind") == 0) {
      recipe_say(error, "%s: expected %s", item->string, item->string[0] == '$' ? "a text" : "\"hoodoo\"");
      result = SCREE_ERROR_SYNTAX;
    } else
      result = read_top(item->string, item, out, error);
  }
  cJSON_Delete(root);
  if (result == SCREE_OK && (!kind || (ages && steps))) {
    recipe_say(error, "%s", kind ? "age_steps: give ages or age_steps, not both" : "kind: missing; expected \"hoodoo\"");
    result = SCREE_ERROR_SYNTAX;
  }
  return result == SCREE_OK ? hoodoo_check(out, error) : result;
}

/* `name` is "key" or "object.member". */
static scree_result set_key(char* name, const cJSON* value, scree_hoodoo_recipe* out, scree_error* error) {
  char* dot = strchr(name, '.');
  if (dot == NULL) return read_top(name, value, out, error);
  const recipe_place at = recipe_inside(&top, name);
  *dot = '\0';
  const hoodoo_key *key = find(hoodoo_keys, name), *rule = find(hoodoo_rule_keys, name);
  const hoodoo_key* object = key != NULL ? key : rule;
  const hoodoo_key* member = object != NULL && object->kind == HOODOO_OBJECT ? find(object->members, dot + 1) : NULL;
  if (member == NULL) {
    recipe_say(error, "%s: unknown key", at.text);
    return SCREE_ERROR_SYNTAX;
  }
  char* base = (key != NULL ? (char*)out : (char*)&out->rules) + object->offset;
  const scree_result result = read_value(member, &at, value, base, error);
  return result == SCREE_OK ? check_shape(member, &at, out->start.shape, error) : result;
}

scree_result scree_hoodoo_set(scree_hoodoo_recipe* recipe, const char* assignment, scree_error* error) {
  char name[RECIPE_NAME_SIZE];
  const char* text = recipe_assignment(assignment, name, error);
  if (text == NULL) return SCREE_ERROR_SYNTAX;
  cJSON* value = recipe_set_value(text);
  if (value == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  scree_hoodoo_recipe changed = *recipe;
  scree_result result = set_key(name, value, &changed, error);
  cJSON_Delete(value);
  if (result == SCREE_OK) result = hoodoo_check(&changed, error);
  if (result == SCREE_OK) *recipe = changed;
  return result;
}

/* --- checking what did not come from JSON ------------------------------------------------------------------------------------- */

static scree_result check_keys(const hoodoo_key* keys, const recipe_place* outer, const void* base, uint32_t shape,
                               scree_error* error);

static scree_result check_count(const recipe_place* at, uint32_t count, double least, double most, scree_error* error) {
  if (count >= least && count <= most) return SCREE_OK;
  recipe_say(error, "%s: expected %.0f to %.0f elements, got %u", at->text, least, most, count);
  return SCREE_ERROR_RANGE;
}

static scree_result check_bubbles(const hoodoo_key* key, const recipe_place* at, const scree_hoodoo_rules* rules,
                                  scree_error* error) {
  scree_result result = check_count(at, rules->bubble_count, key->min, key->max, error);
  const hoodoo_key* mixture = find(key->members, "mixture");
  for (uint32_t i = 0; i < rules->bubble_count && result == SCREE_OK; ++i) {
    const scree_bubble_segment* segment = &rules->bubbles[i];
    const recipe_place item = recipe_element(at, (int)i);
    result = check_count(&item, segment->bubble_count, mixture->min, mixture->max, error);
    if (result == SCREE_OK) result = check_keys(key->members, &item, segment, 0, error);
    for (uint32_t b = 0; b < segment->bubble_count && result == SCREE_OK; ++b)
      result = check_keys(mixture->members, &item, &segment->bubbles[b], 0, error);
  }
  return result;
}

static scree_result check_ages(const hoodoo_key* key, const recipe_place* at, const scree_hoodoo_recipe* recipe,
                               scree_error* error) {
  const bool steps = key->kind == HOODOO_AGE_STEPS;
  const uint32_t count = steps ? recipe->age_step_count : recipe->age_count;
  scree_result result = check_count(at, count, 0, SCREE_HOODOO_AGES, error);
  for (uint32_t i = 0; i < count && result == SCREE_OK; ++i) {
    const recipe_place item = recipe_element(at, (int)i);
    result = check_number(key, &item, steps ? recipe->age_steps[i] : recipe->ages[i], steps, error);
  }
  return result;
}

static scree_result check_phases(const hoodoo_key* key, const recipe_place* at, const scree_hoodoo_recipe* recipe,
                                 scree_error* error) {
  scree_result result = check_count(at, recipe->phase_count, key->min, key->max, error);
  for (uint32_t i = 0; i < recipe->phase_count && result == SCREE_OK; ++i) {
    const scree_hoodoo_phase* phase = &recipe->phases[i];
    const recipe_place item = recipe_element(at, (int)i);
    if (!(phase->share < 0)) {
      const recipe_place share = recipe_inside(&item, "share");
      result = check_number(find(key->members, "share"), &share, phase->share, false, error);
    }
    for (uint32_t k = 0; hoodoo_rule_keys[k].name != NULL && result == SCREE_OK; ++k) {
      const hoodoo_key one[2] = {hoodoo_rule_keys[k], {0}};
      if ((phase->changes >> k & 1) != 0) result = check_keys(one, &item, &phase->rules, 0, error);
    }
  }
  return result;
}

static scree_result check_key(const hoodoo_key* key, const recipe_place* at, const void* base, uint32_t shape, scree_error* error) {
  const char* field = (const char*)base + key->offset;
  switch (key->kind) {
    case HOODOO_TEXT: {
      if (memchr(field, '\0', (size_t)key->max + 1) != NULL) return SCREE_OK;
      recipe_say(error, "%s: expected a text of at most %.0f bytes", at->text, key->max);
      return SCREE_ERROR_RANGE;
    }
    case HOODOO_SEED: return check_number(key, at, (double)*(const uint64_t*)(const void*)field, true, error);
    case HOODOO_COUNT: return check_number(key, at, *(const uint32_t*)(const void*)field, true, error);
    case HOODOO_COUNTS:
      for (int i = 0; i < 3; ++i) {
        const recipe_place item = recipe_element(at, i);
        const scree_result result = check_number(key, &item, ((const uint32_t*)(const void*)field)[i], true, error);
        if (result != SCREE_OK) return result;
      }
      return SCREE_OK;
    case HOODOO_NUMBER: return check_number(key, at, *(const double*)(const void*)field, false, error);
    case HOODOO_CHOICE: return check_number(key, at, *(const int*)(const void*)field, true, error);
    case HOODOO_OBJECT: return check_keys(key->members, at, field, shape, error);
    case HOODOO_DURABILITY: {
      const scree_hoodoo_rules* rules = base;
      scree_result result = check_count(at, rules->durability_count, key->min, key->max, error);
      for (uint32_t i = 0; i < rules->durability_count && result == SCREE_OK; ++i) {
        const recipe_place item = recipe_element(at, (int)i);
        result = check_keys(key->members, &item, &rules->durability[i], 0, error);
      }
      return result;
    }
    case HOODOO_BUBBLES: return check_bubbles(key, at, base, error);
    case HOODOO_AGES:
    case HOODOO_AGE_STEPS: return check_ages(key, at, base, error);
    case HOODOO_PHASES: return check_phases(key, at, base, error);
    case HOODOO_BOOL:
    case HOODOO_MIXTURE: break; /* with its segment */
  }
  return SCREE_OK;
}

static scree_result check_keys(const hoodoo_key* keys, const recipe_place* outer, const void* base, uint32_t shape,
                               scree_error* error) {
  scree_result result = SCREE_OK;
  for (; keys->name != NULL && result == SCREE_OK; ++keys) {
    if (keys->shapes != 0 && (keys->shapes >> shape & 1) == 0) continue;
    const recipe_place at = recipe_inside(outer, keys->name);
    result = check_key(keys, &at, base, shape, error);
  }
  return result;
}

scree_result hoodoo_check_all(const scree_hoodoo_recipe* recipe, scree_error* error) {
  scree_result result = check_keys(hoodoo_keys, &top, recipe, (uint32_t)recipe->start.shape & 31, error);
  if (result == SCREE_OK) result = check_keys(hoodoo_rule_keys, &top, &recipe->rules, 0, error);
  return result == SCREE_OK ? hoodoo_check(recipe, error) : result;
}

/* --- writing ---------------------------------------------------------------------------------------------------------------- */

static void write_value(recipe_writer* out, const hoodoo_key* key, const void* base);

static void write_name(recipe_writer* out, const char* name, bool first) {
  recipe_put(out, "%s\"%s\": ", first ? "" : ", ", name);
}

/* Those that the shape has, of a start. */
static void write_members(recipe_writer* out, const hoodoo_key* keys, const void* base, bool first, uint32_t shape) {
  for (; keys->name != NULL; ++keys) {
    if (keys->shapes != 0 && (keys->shapes >> shape & 1) == 0) continue;
    write_name(out, keys->name, first);
    write_value(out, keys, base);
    first = false;
  }
}

static void write_object(recipe_writer* out, const hoodoo_key* key, const void* field) {
  const bool start = strcmp(key->name, "start") == 0;
  recipe_put(out, "{");
  write_members(out, key->members, field, true, start ? (uint32_t)((const scree_hoodoo_start*)field)->shape : 0);
  recipe_put(out, "}");
}

static void write_durability(recipe_writer* out, const hoodoo_key* key, const scree_hoodoo_rules* rules) {
  recipe_put(out, "[");
  for (uint32_t i = 0; i < rules->durability_count; ++i) {
    for (const hoodoo_key* column = key->members; column->name != NULL; ++column) {
      recipe_put(out, column == key->members ? i > 0 ? ", [" : "[" : ", ");
      write_value(out, column, &rules->durability[i]);
    }
    recipe_put(out, "]");
  }
  recipe_put(out, "]");
}

static void write_bubbles(recipe_writer* out, const hoodoo_key* key, const scree_hoodoo_rules* rules) {
  const hoodoo_key* mixture = find(key->members, "mixture");
  recipe_put(out, "[");
  for (uint32_t i = 0; i < rules->bubble_count; ++i) {
    const scree_bubble_segment* segment = &rules->bubbles[i];
    recipe_put(out, i > 0 ? ", {" : "{");
    if (segment->bubble_count == 1) {
      write_name(out, "altitude", true);
      recipe_put_number(out, segment->altitude);
      write_members(out, mixture->members, &segment->bubbles[0], false, 0);
      write_name(out, "period", false);
      recipe_put_number(out, segment->noise_period);
    } else
      write_members(out, key->members, segment, true, 0);
    recipe_put(out, "}");
  }
  recipe_put(out, "]");
}

static void write_phases(recipe_writer* out, const scree_hoodoo_recipe* recipe) {
  recipe_put(out, "[");
  for (uint32_t i = 0; i < recipe->phase_count; ++i) {
    const scree_hoodoo_phase* phase = &recipe->phases[i];
    recipe_put(out, i > 0 ? ", {" : "{");
    write_name(out, phase->share >= 0 ? "share" : "steps", true);
    if (phase->share >= 0)
      recipe_put_number(out, phase->share);
    else
      recipe_put(out, "%u", phase->steps);
    for (uint32_t k = 0; hoodoo_rule_keys[k].name != NULL; ++k) {
      if ((phase->changes >> k & 1) == 0) continue;
      write_name(out, hoodoo_rule_keys[k].name, false);
      write_value(out, &hoodoo_rule_keys[k], &phase->rules);
    }
    recipe_put(out, "}");
  }
  recipe_put(out, "]");
}

static void write_value(recipe_writer* out, const hoodoo_key* key, const void* base) {
  const char* field = (const char*)base + key->offset;
  const scree_hoodoo_recipe* recipe = base;
  switch (key->kind) {
    case HOODOO_TEXT: recipe_put_text(out, field); break;
    case HOODOO_SEED: recipe_put(out, "%llu", (unsigned long long)*(const uint64_t*)(const void*)field); break;
    case HOODOO_COUNT: recipe_put(out, "%u", *(const uint32_t*)(const void*)field); break;
    case HOODOO_COUNTS: {
      const uint32_t* counts = (const uint32_t*)(const void*)field;
      recipe_put(out, "[%u, %u, %u]", counts[0], counts[1], counts[2]);
      break;
    }
    case HOODOO_NUMBER: recipe_put_number(out, *(const double*)(const void*)field); break;
    case HOODOO_BOOL: recipe_put(out, "%s", *(const bool*)(const void*)field ? "true" : "false"); break;
    case HOODOO_CHOICE: {
      const char* word = key->words;
      for (int i = 0; i < *(const int*)(const void*)field; ++i) word += strcspn(word, " ") + 1;
      recipe_put(out, "\"%.*s\"", (int)strcspn(word, " "), word);
      break;
    }
    case HOODOO_OBJECT: write_object(out, key, field); break;
    case HOODOO_DURABILITY: write_durability(out, key, base); break;
    case HOODOO_BUBBLES: write_bubbles(out, key, base); break;
    case HOODOO_MIXTURE: {
      const scree_bubble_segment* segment = base;
      for (uint32_t i = 0; i < segment->bubble_count; ++i) {
        recipe_put(out, i > 0 ? ", {" : "[{");
        write_members(out, key->members, &segment->bubbles[i], true, 0);
        recipe_put(out, "}");
      }
      recipe_put(out, "]");
      break;
    }
    case HOODOO_AGES:
      for (uint32_t i = 0; i < recipe->age_count; ++i) {
        recipe_put(out, i > 0 ? ", " : "[");
        recipe_put_number(out, recipe->ages[i]);
      }
      recipe_put(out, "]");
      break;
    case HOODOO_AGE_STEPS:
      for (uint32_t i = 0; i < recipe->age_step_count; ++i) recipe_put(out, i > 0 ? ", %u" : "[%u", recipe->age_steps[i]);
      recipe_put(out, "]");
      break;
    case HOODOO_PHASES: write_phases(out, recipe); break;
  }
}

static void write_line(recipe_writer* out, const hoodoo_key* key, const void* base) {
  recipe_put(out, ",\n  \"%s\": ", key->name);
  write_value(out, key, base);
}

size_t scree_hoodoo_write(const scree_hoodoo_recipe* recipe, char* text, size_t capacity) {
  recipe_writer out = {text, capacity, 0};
  recipe_put(&out, "{\n  \"kind\": \"hoodoo\"");
  for (const hoodoo_key* key = hoodoo_keys; key->name != NULL; ++key) {
    if (key->kind == (recipe->age_count > 0 ? HOODOO_AGE_STEPS : HOODOO_AGES)) continue;
    if (key->kind == HOODOO_PHASES) /* behind the rules that they change */
      for (const hoodoo_key* rule = hoodoo_rule_keys; rule->name != NULL; ++rule) write_line(&out, rule, &recipe->rules);
    write_line(&out, key, recipe);
  }
  recipe_put(&out, "\n}\n");
  return out.size;
}
