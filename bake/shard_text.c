/* Recipes of shards as JSON: reading, setting single keys, writing, and checking what did not come from JSON, all by the tables of
 * shard_recipe.c. What an object leaves out has its default. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "recipe_text.h"
#include "shard_keys.h"

static const recipe_place top = {""};

static const shard_key* find(const shard_key* keys, const char* name) {
  for (; keys->name != NULL; ++keys)
    if (strcmp(keys->name, name) == 0) return keys;
  return NULL;
}

static uint32_t* count_of(const shard_key* key, const void* base) {
  return (uint32_t*)(void*)((char*)(uintptr_t)base + key->count_at);
}

/* The struct of element i. */
static void* item_of(const shard_key* key, const void* base, uint32_t i) {
  return (char*)(uintptr_t)base + key->offset + (size_t)i * key->stride;
}

/* Which choice the first member of an object is; 0 where it is none. */
static uint32_t choice_of(const shard_key* members, const void* base) {
  if (members->kind != SHARD_CHOICE) return 0;
  return (uint32_t) * (const int*)(const void*)((const char*)base + members->offset) & 31;
}

static bool belongs(const shard_key* key, uint32_t choice) {
  return key->only == 0 || (key->only >> choice & 1) != 0;
}

static const char* word_of(const char* words, uint32_t choice, int* length) {
  for (uint32_t i = 0; i < choice; ++i) words += strcspn(words, " ") + 1;
  *length = (int)strcspn(words, " ");
  return words;
}

/* --- reading ---------------------------------------------------------------------------------------------------------------- */

static scree_result check_number(const shard_key* key, const recipe_place* at, double number, bool whole, scree_error* error) {
  return recipe_check_number(at, key->min, key->max, number, whole, error);
}

static scree_result read_number(const shard_key* key, const recipe_place* at, const cJSON* value, bool whole, double* out,
                                scree_error* error) {
  if (!cJSON_IsNumber(value)) return recipe_wrong_type(at, "a number", value, error);
  *out = value->valuedouble;
  return check_number(key, at, *out, whole, error);
}

static scree_result read_choice(const shard_key* key, const recipe_place* at, const cJSON* value, int* out, scree_error* error) {
  for (uint32_t i = 0; cJSON_IsString(value) && i <= (uint32_t)key->max; ++i) {
    int length;
    const char* word = word_of(key->words, i, &length);
    if (strlen(value->valuestring) != (size_t)length || strncmp(word, value->valuestring, (size_t)length) != 0) continue;
    *out = (int)i;
    return SCREE_OK;
  }
  char got[64];
  recipe_describe(value, got, sizeof got);
  recipe_say(error, "%s: expected one of: %s; got %s", at->text, key->words, got);
  return SCREE_ERROR_SYNTAX;
}

/* An array of `least` to `most` elements. */
static scree_result check_array(const recipe_place* at, const cJSON* value, uint32_t least, uint32_t most, scree_error* error) {
  if (!cJSON_IsArray(value)) return recipe_wrong_type(at, "an array", value, error);
  const int count = cJSON_GetArraySize(value);
  if (count >= (int)least && count <= (int)most) return SCREE_OK;
  if (least == most)
    recipe_say(error, "%s: expected %u elements, got %d", at->text, most, count);
  else
    recipe_say(error, "%s: expected %u to %u elements, got %d", at->text, least, most, count);
  return SCREE_ERROR_SYNTAX;
}

static scree_result read_value(const shard_key* key, const recipe_place* at, const cJSON* value, void* base, scree_error* error);

/* Whether what the object is has this key. */
static scree_result check_belongs(const shard_key* members, const shard_key* key, const recipe_place* at, const void* base,
                                  scree_error* error) {
  const uint32_t choice = choice_of(members, base);
  if (belongs(key, choice)) return SCREE_OK;
  int length;
  const char* word = word_of(members->words, choice, &length);
  recipe_say(error, "%s: the %s %.*s has no such key", at->text, members->name, length, word);
  return SCREE_ERROR_SYNTAX;
}

static scree_result read_members(const shard_key* keys, const recipe_place* at, const cJSON* object, void* base,
                                 scree_error* error) {
  if (!cJSON_IsObject(object)) return recipe_wrong_type(at, "an object", object, error);
  scree_result result = SCREE_OK;
  for (const cJSON* item = object->child; item != NULL && result == SCREE_OK; item = item->next) {
    const shard_key* key = find(keys, item->string);
    const recipe_place member = recipe_inside(at, item->string);
    result = recipe_check_member(object, item, &member, key != NULL, error);
    if (result == SCREE_OK) result = read_value(key, &member, item, base, error);
  }
  for (const cJSON* item = object->child; item != NULL && result == SCREE_OK; item = item->next) {
    const recipe_place member = recipe_inside(at, item->string);
    result = check_belongs(keys, find(keys, item->string), &member, base, error);
  }
  return result;
}

/* Bytes of a member in its struct. */
static size_t size_of(const shard_key* key) {
  switch (key->kind) {
    case SHARD_TEXT: return (size_t)key->max + 1;
    case SHARD_SEED: return sizeof(uint64_t);
    case SHARD_COUNT: return sizeof(uint32_t);
    case SHARD_COUNTS: return key->size * sizeof(uint32_t);
    case SHARD_NUMBER: return sizeof(double);
    case SHARD_NUMBERS: return key->size * sizeof(double);
    case SHARD_BOOL: return sizeof(bool);
    case SHARD_CHOICE: return sizeof(int);
    case SHARD_OBJECT: return 0;
    case SHARD_LIST:
    case SHARD_ROWS:
    case SHARD_VALUES:
    case SHARD_TIMES:
    case SHARD_PHASES: return key->size * key->stride;
  }
  return 0;
}

static bool is_list(const shard_key* key) {
  return key->kind >= SHARD_LIST;
}

static void reset_members(const shard_key* keys, void* base, const void* from) {
  for (; keys->name != NULL; ++keys) {
    memcpy((char*)base + keys->offset, (const char*)from + keys->offset, size_of(keys));
    if (is_list(keys)) *count_of(keys, base) = *count_of(keys, from);
  }
}

/* field: the struct of the object. */
static scree_result read_object(const shard_key* key, const recipe_place* at, const cJSON* value, void* field, scree_error* error) {
  scree_shard_recipe plain;
  const void* from = key->blank;
  if (from == NULL) {
    scree_shard_recipe_default(&plain);
    from = find(shard_rule_keys, key->name) == key ? (const char*)&plain.rules : (const char*)&plain + key->offset;
  }
  reset_members(key->members, field, from);
  return read_members(key->members, at, value, field, error);
}

static scree_result read_row(const shard_key* columns, const recipe_place* at, const cJSON* row, void* out, scree_error* error) {
  uint32_t count = 0;
  while (columns[count].name != NULL) ++count;
  scree_result result = check_array(at, row, count, count, error);
  for (const cJSON* number = result == SCREE_OK ? row->child : NULL; number != NULL && result == SCREE_OK; number = number->next) {
    const recipe_place column = recipe_inside(at, columns->name);
    result = read_value(columns++, &column, number, out, error);
  }
  return result;
}

static scree_result read_phase(const shard_key* keys, const recipe_place* at, const cJSON* value, scree_shard_phase* out,
                               scree_error* error) {
  if (!cJSON_IsObject(value)) return recipe_wrong_type(at, "an object", value, error);
  memset(out, 0, sizeof *out);
  out->share = -1;
  uint32_t moments = 0;
  for (const cJSON* item = value->child; item != NULL; item = item->next) {
    const recipe_place member = recipe_inside(at, item->string);
    const shard_key *key = find(keys, item->string), *rule = find(shard_rule_keys, item->string);
    scree_result result = recipe_check_member(value, item, &member, key != NULL || rule != NULL, error);
    if (result == SCREE_OK)
      result = read_value(key != NULL ? key : rule, &member, item, key != NULL ? (void*)out : &out->rules, error);
    if (result != SCREE_OK) return result;
    moments += key != NULL;
    if (rule != NULL) out->changes |= 1u << (rule - shard_rule_keys);
  }
  if (moments == 1) return SCREE_OK;
  recipe_say(error, "%s: expected either share or paths, which say when it begins", at->text);
  return SCREE_ERROR_SYNTAX;
}

static scree_result read_list(const shard_key* key, const recipe_place* at, const cJSON* value, void* base, scree_error* error) {
  scree_result result = check_array(at, value, key->least, key->size, error);
  if (result != SCREE_OK) return result;
  uint32_t* count = count_of(key, base);
  *count = 0;
  for (const cJSON* item = value->child; item != NULL && result == SCREE_OK; item = item->next) {
    const recipe_place at_item = recipe_element(at, *count);
    void* out = item_of(key, base, (*count)++);
    double number = 0;
    switch (key->kind) {
      case SHARD_LIST:
        memcpy(out, key->blank, key->stride);
        result = read_members(key->members, &at_item, item, out, error);
        break;
      case SHARD_ROWS: result = read_row(key->members, &at_item, item, out, error); break;
      case SHARD_PHASES: result = read_phase(key->members, &at_item, item, out, error); break;
      default:
        result = read_number(key, &at_item, item, key->kind == SHARD_TIMES, &number, error);
        if (result != SCREE_OK) break;
        if (key->kind == SHARD_TIMES)
          *(uint32_t*)out = (uint32_t)number;
        else
          *(double*)out = number;
    }
  }
  return result;
}

/* base: the struct that the key's table is about. */
static scree_result read_value(const shard_key* key, const recipe_place* at, const cJSON* value, void* base, scree_error* error) {
  char* field = (char*)base + key->offset;
  double number = 0;
  scree_result result = SCREE_OK;
  switch (key->kind) {
    case SHARD_TEXT:
      if (!cJSON_IsString(value) || strlen(value->valuestring) > (size_t)key->max) {
        char expected[64];
        snprintf(expected, sizeof expected, "a text of at most %.0f bytes", key->max);
        return recipe_wrong_type(at, expected, value, error);
      }
      memset(field, 0, (size_t)key->max + 1);
      strcpy(field, value->valuestring);
      return SCREE_OK;
    case SHARD_SEED:
      result = read_number(key, at, value, true, &number, error);
      if (result == SCREE_OK) *(uint64_t*)(void*)field = (uint64_t)number;
      return result;
    case SHARD_COUNT:
      result = read_number(key, at, value, true, &number, error);
      if (result == SCREE_OK) *(uint32_t*)(void*)field = (uint32_t)number;
      return result;
    case SHARD_NUMBER: return read_number(key, at, value, false, (double*)(void*)field, error);
    case SHARD_COUNTS:
    case SHARD_NUMBERS:
      result = check_array(at, value, key->size, key->size, error);
      for (uint32_t i = 0; i < key->size && result == SCREE_OK; ++i) {
        const recipe_place at_item = recipe_element(at, i);
        result = read_number(key, &at_item, cJSON_GetArrayItem(value, (int)i), key->kind == SHARD_COUNTS, &number, error);
        if (result != SCREE_OK) break;
        if (key->kind == SHARD_COUNTS)
          ((uint32_t*)(void*)field)[i] = (uint32_t)number;
        else
          ((double*)(void*)field)[i] = number;
      }
      return result;
    case SHARD_BOOL:
      if (!cJSON_IsBool(value)) return recipe_wrong_type(at, "true or false", value, error);
      *(bool*)(void*)field = cJSON_IsTrue(value) != 0;
      return SCREE_OK;
    case SHARD_CHOICE: return read_choice(key, at, value, (int*)(void*)field, error);
    case SHARD_OBJECT: return read_object(key, at, value, field, error);
    case SHARD_LIST:
    case SHARD_ROWS:
    case SHARD_VALUES:
    case SHARD_TIMES:
    case SHARD_PHASES: return read_list(key, at, value, base, error);
  }
  return result;
}

/* A key of the recipe or of its rules. */
static scree_result read_top(const char* name, const cJSON* value, scree_shard_recipe* out, scree_error* error) {
  const shard_key *key = find(shard_keys, name), *rule = find(shard_rule_keys, name);
  const recipe_place at = recipe_inside(&top, name);
  if (key == NULL && rule == NULL) {
    recipe_say(error, "%.60s: unknown key", name);
    return SCREE_ERROR_SYNTAX;
  }
  const scree_result result =
      key != NULL ? read_value(key, &at, value, out, error) : read_value(rule, &at, value, &out->rules, error);
  /* Times are of one kind. */
  if (result == SCREE_OK && key != NULL && strcmp(name, "paths") == 0) out->share_count = 0;
  if (result == SCREE_OK && key != NULL && strcmp(name, "shares") == 0) out->path_count = 0;
  return result;
}

scree_result scree_shard_recipe_parse(const char* text, size_t size, scree_shard_recipe* out, scree_error* error) {
  scree_shard_recipe_default(out);
  cJSON* root = recipe_root(text, size, error);
  if (root == NULL) return SCREE_ERROR_SYNTAX;
  scree_result result = SCREE_OK;
  bool kind = false;
  for (const cJSON* item = root->child; item != NULL && result == SCREE_OK; item = item->next) {
    if (strcmp(item->string, "$schema") == 0 && cJSON_IsString(item)) continue;
    if (strcmp(item->string, "kind") == 0 && cJSON_IsString(item) && strcmp(item->valuestring, "shards") == 0) {
      kind = true;
      continue;
    }
    if (strcmp(item->string, "$schema") == 0 || strcmp(item->string, "kind") == 0) {
      recipe_say(error, "%s: expected %s", item->string, item->string[0] == '$' ? "a text" : "\"shards\"");
      result = SCREE_ERROR_SYNTAX;
    } else
      result = read_top(item->string, item, out, error);
  }
  if (result == SCREE_OK && !kind) {
    recipe_say(error, "kind: missing; expected \"shards\"");
    result = SCREE_ERROR_SYNTAX;
  }
  if (result == SCREE_OK && cJSON_HasObjectItem(root, "paths") && cJSON_HasObjectItem(root, "shares")) {
    recipe_say(error, "shares: give paths or shares, not both");
    result = SCREE_ERROR_SYNTAX;
  }
  cJSON_Delete(root);
  return result == SCREE_OK ? shard_check(out, error) : result;
}

/* `name` is "key" or "object.member". */
static scree_result set_key(char* name, const cJSON* value, scree_shard_recipe* out, scree_error* error) {
  char* dot = strchr(name, '.');
  if (dot == NULL) return read_top(name, value, out, error);
  const recipe_place at = recipe_inside(&top, name);
  *dot = '\0';
  const shard_key *key = find(shard_keys, name), *rule = find(shard_rule_keys, name);
  const shard_key* object = key != NULL ? key : rule;
  const shard_key* member = object != NULL && object->kind == SHARD_OBJECT ? find(object->members, dot + 1) : NULL;
  if (member == NULL) {
    recipe_say(error, "%s: unknown key", at.text);
    return SCREE_ERROR_SYNTAX;
  }
  char* base = (key != NULL ? (char*)out : (char*)&out->rules) + object->offset;
  const scree_result result = read_value(member, &at, value, base, error);
  return result == SCREE_OK ? check_belongs(object->members, member, &at, base, error) : result;
}

scree_result scree_shard_recipe_set(scree_shard_recipe* recipe, const char* assignment, scree_error* error) {
  char name[RECIPE_NAME_SIZE];
  const char* text = recipe_assignment(assignment, name, error);
  if (text == NULL) return SCREE_ERROR_SYNTAX;
  cJSON* value = recipe_set_value(text);
  if (value == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  scree_shard_recipe changed = *recipe;
  scree_result result = set_key(name, value, &changed, error);
  cJSON_Delete(value);
  if (result == SCREE_OK) result = shard_check(&changed, error);
  if (result == SCREE_OK) *recipe = changed;
  return result;
}

/* --- checking what did not come from JSON ------------------------------------------------------------------------------------- */

static scree_result check_keys(const shard_key* keys, const recipe_place* outer, const void* base, uint32_t chosen,
                               scree_error* error);

static scree_result check_phase(const shard_key* key, const recipe_place* at, const scree_shard_phase* phase, scree_error* error) {
  const bool by_paths = phase->share < 0;
  const char* name = by_paths ? "paths" : "share";
  const recipe_place moment = recipe_inside(at, name);
  const scree_result result =
      check_number(find(key->members, name), &moment, by_paths ? phase->paths : phase->share, by_paths, error);
  return result == SCREE_OK ? check_keys(shard_rule_keys, at, &phase->rules, phase->changes, error) : result;
}

static scree_result check_list(const shard_key* key, const recipe_place* at, const void* base, scree_error* error) {
  const uint32_t count = *count_of(key, base);
  if (count < key->least || count > key->size) {
    recipe_say(error, "%s: expected %u to %u elements, got %u", at->text, key->least, key->size, count);
    return SCREE_ERROR_RANGE;
  }
  scree_result result = SCREE_OK;
  for (uint32_t i = 0; i < count && result == SCREE_OK; ++i) {
    const recipe_place at_item = recipe_element(at, i);
    const void* item = item_of(key, base, i);
    if (key->kind == SHARD_LIST || key->kind == SHARD_ROWS)
      result = check_keys(key->members, &at_item, item, ~0u, error);
    else if (key->kind == SHARD_PHASES)
      result = check_phase(key, &at_item, item, error);
    else
      result = check_number(key, &at_item, key->kind == SHARD_TIMES ? *(const uint32_t*)item : *(const double*)item, false, error);
  }
  return result;
}

static scree_result check_key(const shard_key* key, const recipe_place* at, const void* base, scree_error* error) {
  const char* field = (const char*)base + key->offset;
  scree_result result = SCREE_OK;
  switch (key->kind) {
    case SHARD_TEXT:
      if (memchr(field, '\0', (size_t)key->max + 1) != NULL) return SCREE_OK;
      recipe_say(error, "%s: expected a text of at most %.0f bytes", at->text, key->max);
      return SCREE_ERROR_RANGE;
    case SHARD_SEED: return check_number(key, at, (double)*(const uint64_t*)(const void*)field, true, error);
    case SHARD_COUNT: return check_number(key, at, *(const uint32_t*)(const void*)field, true, error);
    case SHARD_NUMBER: return check_number(key, at, *(const double*)(const void*)field, false, error);
    case SHARD_COUNTS:
    case SHARD_NUMBERS:
      for (uint32_t i = 0; i < key->size && result == SCREE_OK; ++i) {
        const recipe_place item = recipe_element(at, i);
        const double number =
            key->kind == SHARD_COUNTS ? ((const uint32_t*)(const void*)field)[i] : ((const double*)(const void*)field)[i];
        result = check_number(key, &item, number, false, error);
      }
      return result;
    case SHARD_BOOL: return SCREE_OK;
    case SHARD_CHOICE: return check_number(key, at, *(const int*)(const void*)field, true, error);
    case SHARD_OBJECT: return check_keys(key->members, at, field, ~0u, error);
    case SHARD_LIST:
    case SHARD_ROWS:
    case SHARD_VALUES:
    case SHARD_TIMES:
    case SHARD_PHASES: return check_list(key, at, base, error);
  }
  return result;
}

/* Those of the first 32 keys whose bit is set in `chosen`, and that belong to what the object is. */
static scree_result check_keys(const shard_key* keys, const recipe_place* outer, const void* base, uint32_t chosen,
                               scree_error* error) {
  scree_result result = SCREE_OK;
  for (uint32_t k = 0; keys[k].name != NULL && result == SCREE_OK; ++k) {
    if ((chosen >> (k & 31) & 1) == 0 || !belongs(&keys[k], choice_of(keys, base))) continue;
    const recipe_place at = recipe_inside(outer, keys[k].name);
    result = check_key(&keys[k], &at, base, error);
  }
  return result;
}

scree_result shard_check_all(const scree_shard_recipe* recipe, scree_error* error) {
  scree_result result = check_keys(shard_keys, &top, recipe, ~0u, error);
  if (result == SCREE_OK) result = check_keys(shard_rule_keys, &top, &recipe->rules, ~0u, error);
  return result == SCREE_OK ? shard_check(recipe, error) : result;
}

/* --- writing ---------------------------------------------------------------------------------------------------------------- */

static void write_value(recipe_writer* out, const shard_key* key, const void* base);

static void write_name(recipe_writer* out, const char* name, bool first) {
  recipe_put(out, "%s\"%s\": ", first ? "" : ", ", name);
}

static void write_members(recipe_writer* out, const shard_key* keys, const void* base) {
  const uint32_t choice = choice_of(keys, base);
  bool first = true;
  recipe_put(out, "{");
  for (const shard_key* key = keys; key->name != NULL; ++key) {
    if (!belongs(key, choice)) continue;
    write_name(out, key->name, first);
    write_value(out, key, base);
    first = false;
  }
  recipe_put(out, "}");
}

static void write_row(recipe_writer* out, const shard_key* columns, const void* row) {
  for (const shard_key* column = columns; column->name != NULL; ++column) {
    recipe_put(out, column == columns ? "[" : ", ");
    write_value(out, column, row);
  }
  recipe_put(out, "]");
}

static void write_phase(recipe_writer* out, const scree_shard_phase* phase) {
  recipe_put(out, "{");
  write_name(out, phase->share >= 0 ? "share" : "paths", true);
  if (phase->share >= 0)
    recipe_put_number(out, phase->share);
  else
    recipe_put(out, "%u", phase->paths);
  for (uint32_t k = 0; shard_rule_keys[k].name != NULL; ++k) {
    if ((phase->changes >> k & 1) == 0) continue;
    write_name(out, shard_rule_keys[k].name, false);
    write_value(out, &shard_rule_keys[k], &phase->rules);
  }
  recipe_put(out, "}");
}

static void write_list(recipe_writer* out, const shard_key* key, const void* base) {
  const uint32_t count = *count_of(key, base);
  recipe_put(out, "[");
  for (uint32_t i = 0; i < count; ++i) {
    const void* item = item_of(key, base, i);
    if (i > 0) recipe_put(out, ", ");
    switch (key->kind) {
      case SHARD_LIST: write_members(out, key->members, item); break;
      case SHARD_ROWS: write_row(out, key->members, item); break;
      case SHARD_PHASES: write_phase(out, item); break;
      case SHARD_TIMES: recipe_put(out, "%u", *(const uint32_t*)item); break;
      default: recipe_put_number(out, *(const double*)item);
    }
  }
  recipe_put(out, "]");
}

static void write_value(recipe_writer* out, const shard_key* key, const void* base) {
  const char* field = (const char*)base + key->offset;
  switch (key->kind) {
    case SHARD_TEXT: recipe_put_text(out, field); break;
    case SHARD_SEED: recipe_put(out, "%llu", (unsigned long long)*(const uint64_t*)(const void*)field); break;
    case SHARD_COUNT: recipe_put(out, "%u", *(const uint32_t*)(const void*)field); break;
    case SHARD_NUMBER: recipe_put_number(out, *(const double*)(const void*)field); break;
    case SHARD_COUNTS:
    case SHARD_NUMBERS:
      for (uint32_t i = 0; i < key->size; ++i) {
        recipe_put(out, i > 0 ? ", " : "[");
        if (key->kind == SHARD_COUNTS)
          recipe_put(out, "%u", ((const uint32_t*)(const void*)field)[i]);
        else
          recipe_put_number(out, ((const double*)(const void*)field)[i]);
      }
      recipe_put(out, "]");
      break;
    case SHARD_BOOL: recipe_put(out, "%s", *(const bool*)(const void*)field ? "true" : "false"); break;
    case SHARD_CHOICE: {
      int length;
      const char* word = word_of(key->words, (uint32_t) * (const int*)(const void*)field, &length);
      recipe_put(out, "\"%.*s\"", length, word);
      break;
    }
    case SHARD_OBJECT: write_members(out, key->members, field); break;
    case SHARD_LIST:
    case SHARD_ROWS:
    case SHARD_VALUES:
    case SHARD_TIMES:
    case SHARD_PHASES: write_list(out, key, base); break;
  }
}

static void write_line(recipe_writer* out, const shard_key* key, const void* base) {
  recipe_put(out, ",\n  \"%s\": ", key->name);
  write_value(out, key, base);
}

size_t scree_shard_recipe_write(const scree_shard_recipe* recipe, char* text, size_t capacity) {
  recipe_writer out = {text, capacity, 0};
  const char* left_out = recipe->path_count > 0 ? "shares" : "paths";
  recipe_put(&out, "{\n  \"kind\": \"shards\"");
  for (const shard_key* key = shard_keys; key->name != NULL; ++key) {
    if (strcmp(key->name, left_out) == 0) continue;
    if (strcmp(key->name, "states") == 0) /* what weathers, behind what is split */
      for (const shard_key* rule = shard_rule_keys; rule->name != NULL; ++rule) write_line(&out, rule, &recipe->rules);
    write_line(&out, key, recipe);
  }
  recipe_put(&out, "\n}\n");
  return out.size;
}
