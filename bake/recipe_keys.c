#include "recipe_keys.h"

#include <stdio.h>
#include <string.h>

#include "recipe_text.h"

static const recipe_place top = {""};

/* What goes along through objects and lists. */
typedef struct recipe_reader {
  const recipe_table* table;
  const char* plain; /* the default recipe */
  scree_error* error;
} recipe_reader;

/* keys: may be NULL. */
static const recipe_key* find(const recipe_key* keys, const char* name) {
  for (; keys != NULL && keys->name != NULL; ++keys)
    if (strcmp(keys->name, name) == 0) return keys;
  return NULL;
}

static uint32_t* count_of(const recipe_key* key, const void* base) {
  return (uint32_t*)(void*)((char*)(uintptr_t)base + key->count_at);
}

/* The struct of element i. */
static void* item_of(const recipe_key* key, const void* base, uint32_t i) {
  return (char*)(uintptr_t)base + key->offset + (size_t)i * key->stride;
}

/* Which choice the first member of an object is; 0 where it is none. */
static uint32_t choice_of(const recipe_key* members, const void* base) {
  if (members->kind != RECIPE_CHOICE) return 0;
  return (uint32_t) * (const int*)(const void*)((const char*)base + members->offset) & 31;
}

static bool belongs(const recipe_key* key, uint32_t choice) {
  return key->only == 0 || (key->only >> choice & 1) != 0;
}

static const char* word_of(const char* words, uint32_t choice, int* length) {
  for (uint32_t i = 0; i < choice; ++i) words += strcspn(words, " ") + 1;
  *length = (int)strcspn(words, " ");
  return words;
}

static bool is_whole(const recipe_key* key) {
  return key->kind == RECIPE_COUNTS || key->kind == RECIPE_COUNT_RANGE || key->kind == RECIPE_TIMES;
}

/* Number i of those that lie one behind the other. */
static double number_at(const recipe_key* key, const void* field, uint32_t i) {
  return is_whole(key) ? ((const uint32_t*)field)[i] : ((const double*)field)[i];
}

static void set_number(const recipe_key* key, void* field, uint32_t i, double number) {
  if (is_whole(key))
    ((uint32_t*)field)[i] = (uint32_t)number;
  else
    ((double*)field)[i] = number;
}

/* --- reading ---------------------------------------------------------------------------------------------------------------- */

static scree_result check_number(const recipe_key* key, const recipe_place* at, double number, bool whole, scree_error* error) {
  return recipe_check_number(at, key->min, key->max, number, whole, error);
}

static scree_result read_number(const recipe_key* key, const recipe_place* at, const cJSON* value, bool whole, double* out,
                                scree_error* error) {
  if (!cJSON_IsNumber(value)) return recipe_wrong_type(at, "a number", value, error);
  *out = value->valuedouble;
  return check_number(key, at, *out, whole, error);
}

static scree_result read_choice(const recipe_key* key, const recipe_place* at, const cJSON* value, int* out, scree_error* error) {
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

static scree_result read_text(const recipe_key* key, const recipe_place* at, const cJSON* value, char* out, scree_error* error) {
  if (!cJSON_IsString(value) || strlen(value->valuestring) > (size_t)key->max) {
    char expected[64];
    snprintf(expected, sizeof expected, "a text of at most %.0f bytes", key->max);
    return recipe_wrong_type(at, expected, value, error);
  }
  memset(out, 0, (size_t)key->max + 1);
  strcpy(out, value->valuestring);
  return SCREE_OK;
}

/* An array of `least` to `most` elements, which are called `of`. */
static scree_result check_array(const recipe_place* at, const cJSON* value, uint32_t least, uint32_t most, const char* of,
                                scree_error* error) {
  if (!cJSON_IsArray(value)) {
    char expected[160];
    if (least == most)
      snprintf(expected, sizeof expected, "an array of %u %s", most, of);
    else
      snprintf(expected, sizeof expected, "an array of %s", of);
    return recipe_wrong_type(at, expected, value, error);
  }
  const int count = cJSON_GetArraySize(value);
  if (count >= (int)least && count <= (int)most) return SCREE_OK;
  if (least == most)
    recipe_say(error, "%s: expected %u %s, got %d", at->text, most, of, count);
  else
    recipe_say(error, "%s: expected %u to %u %s, got %d", at->text, least, most, of, count);
  return SCREE_ERROR_SYNTAX;
}

static scree_result read_numbers(const recipe_key* key, const recipe_place* at, const cJSON* value, void* field,
                                 scree_error* error) {
  scree_result result = check_array(at, value, key->size, key->size, "numbers", error);
  for (uint32_t i = 0; i < key->size && result == SCREE_OK; ++i) {
    const recipe_place at_item = recipe_element(at, i);
    double number = 0;
    result = read_number(key, &at_item, cJSON_GetArrayItem(value, (int)i), is_whole(key), &number, error);
    if (result == SCREE_OK) set_number(key, field, i, number);
  }
  return result;
}

static scree_result check_range(const recipe_place* at, double least, double most, scree_error* error) {
  if (!(least > most)) return SCREE_OK;
  recipe_say(error, "%s: the least number, %.10g, is greater than the most, %.10g", at->text, least, most);
  return SCREE_ERROR_RANGE;
}

/* A number, or [least, most]. */
static scree_result read_range(const recipe_key* key, const recipe_place* at, const cJSON* value, void* field, scree_error* error) {
  double ends[2] = {0};
  scree_result result = SCREE_OK;
  if (!cJSON_IsArray(value)) {
    result = read_number(key, at, value, is_whole(key), &ends[0], error);
    ends[1] = ends[0];
  } else if (cJSON_GetArraySize(value) != 2) {
    recipe_say(error, "%s: expected a number or [least, most], got %d numbers", at->text, cJSON_GetArraySize(value));
    result = SCREE_ERROR_SYNTAX;
  } else {
    for (int i = 0; i < 2 && result == SCREE_OK; ++i)
      result = read_number(key, at, cJSON_GetArrayItem(value, i), is_whole(key), &ends[i], error);
    if (result == SCREE_OK) result = check_range(at, ends[0], ends[1], error);
  }
  for (uint32_t i = 0; i < 2 && result == SCREE_OK; ++i) set_number(key, field, i, ends[i]);
  return result;
}

static scree_result read_value(const recipe_reader* r, const recipe_key* key, const recipe_place* at, const cJSON* value,
                               void* base);

/* Whether what the object is has this key. */
static scree_result check_belongs(const recipe_key* members, const recipe_key* key, const recipe_place* at, const void* base,
                                  scree_error* error) {
  const uint32_t choice = choice_of(members, base);
  if (belongs(key, choice)) return SCREE_OK;
  int length;
  const char* word = word_of(members->words, choice, &length);
  recipe_say(error, "%s: the %s %.*s has no such key", at->text, members->name, length, word);
  return SCREE_ERROR_SYNTAX;
}

/* The list whose only element may be written as keys of the object around it, or NULL. */
static const recipe_key* find_alone(const recipe_key* keys) {
  for (; keys->name != NULL; ++keys)
    if (keys->alone) return keys;
  return NULL;
}

static scree_result read_members(const recipe_reader* r, const recipe_key* keys, const recipe_place* at, const cJSON* object,
                                 void* base) {
  if (!cJSON_IsObject(object)) return recipe_wrong_type(at, "an object", object, r->error);
  const recipe_key* alone = find_alone(keys);
  const bool is_listed = alone != NULL && cJSON_GetObjectItemCaseSensitive(object, alone->name) != NULL;
  scree_result result = SCREE_OK;
  for (const cJSON* item = object->child; item != NULL && result == SCREE_OK; item = item->next) {
    const recipe_key *key = find(keys, item->string), *inner = NULL;
    if (key == NULL && alone != NULL) inner = find(alone->members, item->string);
    const recipe_place member = recipe_inside(at, item->string);
    result = recipe_check_member(object, item, &member, key != NULL || inner != NULL, r->error);
    if (result == SCREE_OK && inner != NULL && is_listed) {
      recipe_say(r->error, "%s: belongs into the %s of %s", member.text, alone->of, alone->name);
      result = SCREE_ERROR_SYNTAX;
    }
    if (result == SCREE_OK)
      result = read_value(r, key != NULL ? key : inner, &member, item, key != NULL ? base : item_of(alone, base, 0));
  }
  for (const cJSON* item = object->child; item != NULL && result == SCREE_OK; item = item->next) {
    const recipe_key* key = find(keys, item->string);
    const recipe_place member = recipe_inside(at, item->string);
    if (key != NULL) result = check_belongs(keys, key, &member, base, r->error);
  }
  return result;
}

static bool is_list(const recipe_key* key) {
  return key->kind >= RECIPE_LIST;
}

/* Bytes of a member in its struct. */
static size_t size_of(const recipe_key* key) {
  switch (key->kind) {
    case RECIPE_TEXT: return (size_t)key->max + 1;
    case RECIPE_SEED: return sizeof(uint64_t);
    case RECIPE_COUNT: return sizeof(uint32_t);
    case RECIPE_COUNTS: return key->size * sizeof(uint32_t);
    case RECIPE_COUNT_RANGE: return 2 * sizeof(uint32_t);
    case RECIPE_NUMBER: return sizeof(double);
    case RECIPE_NUMBERS: return key->size * sizeof(double);
    case RECIPE_RANGE: return 2 * sizeof(double);
    case RECIPE_BOOL: return sizeof(bool);
    case RECIPE_CHOICE: return sizeof(int);
    case RECIPE_OBJECT: return 0;
    case RECIPE_LIST:
    case RECIPE_ROWS:
    case RECIPE_VALUES:
    case RECIPE_TIMES:
    case RECIPE_PHASES: return key->size * key->stride;
  }
  return 0;
}

static void reset_members(const recipe_key* keys, void* base, const void* from) {
  for (; keys->name != NULL; ++keys) {
    memcpy((char*)base + keys->offset, (const char*)from + keys->offset, size_of(keys));
    if (is_list(keys)) *count_of(keys, base) = *count_of(keys, from);
  }
}

/* field: the struct of the object. */
static scree_result read_object(const recipe_reader* r, const recipe_key* key, const recipe_place* at, const cJSON* value,
                                void* field) {
  const char* from = key->blank;
  if (from == NULL) {
    const bool is_rule = find(r->table->rules, key->name) == key;
    from = r->plain + (is_rule ? r->table->rules_at : 0) + key->offset;
  }
  reset_members(key->members, field, from);
  return read_members(r, key->members, at, value, field);
}

/* The names of all members, for errors. */
static void describe_columns(const recipe_key* columns, char* text, size_t capacity) {
  size_t size = (size_t)snprintf(text, capacity, "numbers: ");
  for (const recipe_key* column = columns; column->name != NULL && size < capacity; ++column)
    size += (size_t)snprintf(text + size, capacity - size, "%s%s", column == columns ? "" : ", ", column->name);
}

static scree_result read_row(const recipe_reader* r, const recipe_key* key, const recipe_place* at, const cJSON* row, void* out) {
  const recipe_key* column = key->members;
  uint32_t count = 0;
  while (column[count].name != NULL) ++count;
  char of[128];
  describe_columns(column, of, sizeof of);
  scree_result result = check_array(at, row, key->columns > 0 ? key->columns : count, count, of, r->error);
  for (const cJSON* number = result == SCREE_OK ? row->child : NULL; number != NULL && result == SCREE_OK; number = number->next) {
    const recipe_place place = recipe_inside(at, column->name);
    result = read_value(r, column++, &place, number, out);
  }
  return result;
}

static void* rules_of(const recipe_table* table, const void* phase) {
  return (char*)(uintptr_t)phase + table->phase_rules_at;
}

static uint32_t* changes_of(const recipe_table* table, const void* phase) {
  return (uint32_t*)(void*)((char*)(uintptr_t)phase + table->phase_changes_at);
}

static double* share_of(const recipe_key* key, const void* phase) {
  return (double*)(void*)((char*)(uintptr_t)phase + key->members->offset);
}

static scree_result read_phase(const recipe_reader* r, const recipe_key* key, const recipe_place* at, const cJSON* value,
                               void* out) {
  if (!cJSON_IsObject(value)) return recipe_wrong_type(at, "an object", value, r->error);
  *share_of(key, out) = -1;
  uint32_t moments = 0;
  for (const cJSON* item = value->child; item != NULL; item = item->next) {
    const recipe_place member = recipe_inside(at, item->string);
    const recipe_key *moment = find(key->members, item->string), *rule = find(r->table->rules, item->string);
    scree_result result = recipe_check_member(value, item, &member, moment != NULL || rule != NULL, r->error);
    if (result == SCREE_OK)
      result = read_value(r, moment != NULL ? moment : rule, &member, item, moment != NULL ? out : rules_of(r->table, out));
    if (result != SCREE_OK) return result;
    moments += moment != NULL;
    if (rule != NULL) *changes_of(r->table, out) |= 1u << (rule - r->table->rules);
  }
  if (moments == 1) return SCREE_OK;
  recipe_say(r->error, "%s: expected either %s or %s, which say when it begins", at->text, key->members[0].name,
             key->members[1].name);
  return SCREE_ERROR_SYNTAX;
}

/* What an element of a list or of rows is before it is read. */
static void begin_item(const recipe_key* key, const void* base, uint32_t i, void* out) {
  if (key->kind == RECIPE_ROWS && i > 0)
    memcpy(out, item_of(key, base, i - 1), key->stride);
  else if (key->blank != NULL)
    memcpy(out, key->blank, key->stride);
  else
    memset(out, 0, key->stride);
}

static scree_result read_list(const recipe_reader* r, const recipe_key* key, const recipe_place* at, const cJSON* value,
                              void* base) {
  const char* of = key->of != NULL ? key->of : "elements";
  scree_result result = check_array(at, value, key->least, key->size, of, r->error);
  if (result != SCREE_OK) return result;
  uint32_t* count = count_of(key, base);
  *count = 0;
  for (const cJSON* item = value->child; item != NULL && result == SCREE_OK; item = item->next) {
    const recipe_place at_item = recipe_element(at, *count);
    void* out = item_of(key, base, *count);
    double number = 0;
    begin_item(key, base, (*count)++, out);
    switch (key->kind) {
      case RECIPE_LIST: result = read_members(r, key->members, &at_item, item, out); break;
      case RECIPE_ROWS: result = read_row(r, key, &at_item, item, out); break;
      case RECIPE_PHASES: result = read_phase(r, key, &at_item, item, out); break;
      default:
        result = read_number(key, &at_item, item, is_whole(key), &number, r->error);
        if (result == SCREE_OK) set_number(key, out, 0, number);
    }
  }
  return result;
}

/* base: the struct that the key's table is about. */
static scree_result read_value(const recipe_reader* r, const recipe_key* key, const recipe_place* at, const cJSON* value,
                               void* base) {
  void* field = (char*)base + key->offset;
  double number = 0;
  scree_result result = SCREE_OK;
  switch (key->kind) {
    case RECIPE_TEXT: return read_text(key, at, value, field, r->error);
    case RECIPE_SEED:
      result = read_number(key, at, value, true, &number, r->error);
      if (result == SCREE_OK) *(uint64_t*)field = (uint64_t)number;
      return result;
    case RECIPE_COUNT:
      result = read_number(key, at, value, true, &number, r->error);
      if (result == SCREE_OK) *(uint32_t*)field = (uint32_t)number;
      return result;
    case RECIPE_NUMBER: return read_number(key, at, value, false, field, r->error);
    case RECIPE_COUNTS:
    case RECIPE_NUMBERS: return read_numbers(key, at, value, field, r->error);
    case RECIPE_COUNT_RANGE:
    case RECIPE_RANGE: return read_range(key, at, value, field, r->error);
    case RECIPE_BOOL:
      if (!cJSON_IsBool(value)) return recipe_wrong_type(at, "true or false", value, r->error);
      *(bool*)field = cJSON_IsTrue(value) != 0;
      return SCREE_OK;
    case RECIPE_CHOICE: return read_choice(key, at, value, field, r->error);
    case RECIPE_OBJECT: return read_object(r, key, at, value, field);
    case RECIPE_LIST:
    case RECIPE_ROWS:
    case RECIPE_VALUES:
    case RECIPE_TIMES:
    case RECIPE_PHASES: return read_list(r, key, at, value, base);
  }
  return result;
}

/* A key of the recipe or of its rules. */
static scree_result read_top(const recipe_reader* r, const char* name, const cJSON* value, void* out) {
  const recipe_table* table = r->table;
  const recipe_key *key = find(table->keys, name), *rule = find(table->rules, name);
  const recipe_place at = recipe_inside(&top, name);
  if (key == NULL && rule == NULL) {
    recipe_say(r->error, "%.60s: unknown key", name);
    return SCREE_ERROR_SYNTAX;
  }
  const scree_result result =
      key != NULL ? read_value(r, key, &at, value, out) : read_value(r, rule, &at, value, (char*)out + table->rules_at);
  for (uint32_t i = 0; i < 2 && result == SCREE_OK && table->either[0] != NULL; ++i)
    if (strcmp(name, table->either[i]) == 0) *count_of(find(table->keys, table->either[1 - i]), out) = 0;
  return result;
}

static scree_result read_root(const recipe_reader* r, const cJSON* root, void* out) {
  const recipe_table* table = r->table;
  bool is_told = !table->kind_is_needed;
  scree_result result = SCREE_OK;
  for (const cJSON* item = root->child; item != NULL && result == SCREE_OK; item = item->next) {
    const bool schema = strcmp(item->string, "$schema") == 0, kind = strcmp(item->string, "kind") == 0;
    if (schema && cJSON_IsString(item)) continue;
    if (kind && cJSON_IsString(item) && strcmp(item->valuestring, table->kind) == 0)
      is_told = true;
    else if (schema || kind) {
      const char* quote = schema ? "" : "\"";
      recipe_say(r->error, "%s: expected %s%s%s", item->string, quote, schema ? "a text" : table->kind, quote);
      result = SCREE_ERROR_SYNTAX;
    } else
      result = read_top(r, item->string, item, out);
  }
  if (result != SCREE_OK) return result;
  const char* const* either = table->either;
  if (!is_told)
    recipe_say(r->error, "kind: missing; expected \"%s\"", table->kind);
  else if (either[0] != NULL && cJSON_HasObjectItem(root, either[0]) && cJSON_HasObjectItem(root, either[1]))
    recipe_say(r->error, "%s: give %s or %s, not both", either[1], either[0], either[1]);
  else
    return SCREE_OK;
  return SCREE_ERROR_SYNTAX;
}

scree_result recipe_read(const recipe_table* table, const void* plain, const char* text, size_t size, void* out,
                         scree_error* error) {
  const recipe_reader r = {table, plain, error};
  memcpy(out, plain, table->size);
  cJSON* root = recipe_root(text, size, error);
  if (root == NULL) return SCREE_ERROR_SYNTAX;
  const scree_result result = read_root(&r, root, out);
  cJSON_Delete(root);
  return result == SCREE_OK ? table->check(out, error) : result;
}

/* `name` is "key" or "object.member". */
static scree_result set_key(const recipe_reader* r, char* name, const cJSON* value, void* out) {
  char* dot = strchr(name, '.');
  if (dot == NULL) return read_top(r, name, value, out);
  const recipe_place at = recipe_inside(&top, name);
  *dot = '\0';
  const recipe_key *key = find(r->table->keys, name), *rule = find(r->table->rules, name);
  const recipe_key* object = key != NULL ? key : rule;
  const recipe_key* member = object != NULL && object->kind == RECIPE_OBJECT ? find(object->members, dot + 1) : NULL;
  if (member == NULL) {
    recipe_say(r->error, "%s: unknown key", at.text);
    return SCREE_ERROR_SYNTAX;
  }
  char* base = (char*)out + (key != NULL ? 0 : r->table->rules_at) + object->offset;
  const scree_result result = read_value(r, member, &at, value, base);
  return result == SCREE_OK ? check_belongs(object->members, member, &at, base, r->error) : result;
}

scree_result recipe_assign(const recipe_table* table, const void* plain, const char* assignment, void* recipe, scree_error* error) {
  const recipe_reader r = {table, plain, error};
  char name[RECIPE_NAME_SIZE];
  const char* text = recipe_assignment(assignment, name, error);
  if (text == NULL) return SCREE_ERROR_SYNTAX;
  cJSON* value = recipe_set_value(text);
  if (value == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  const scree_result result = set_key(&r, name, value, recipe);
  cJSON_Delete(value);
  return result == SCREE_OK ? table->check(recipe, error) : result;
}

/* --- checking what did not come from JSON ------------------------------------------------------------------------------------- */

static scree_result check_members(const recipe_table* table, const recipe_key* keys, const recipe_place* outer, const void* base,
                                  uint32_t chosen, scree_error* error);

static scree_result check_phase(const recipe_table* table, const recipe_key* key, const recipe_place* at, const void* phase,
                                scree_error* error) {
  const double share = *share_of(key, phase);
  const recipe_key* moment = &key->members[share < 0 ? 1 : 0];
  const recipe_place place = recipe_inside(at, moment->name);
  const double number = share < 0 ? *(const uint32_t*)(const void*)((const char*)phase + moment->offset) : share;
  const scree_result result = check_number(moment, &place, number, share < 0, error);
  if (result != SCREE_OK) return result;
  return check_members(table, table->rules, at, rules_of(table, phase), *changes_of(table, phase), error);
}

static bool is_either(const recipe_table* table, const recipe_key* key) {
  for (uint32_t i = 0; i < 2 && table->either[i] != NULL; ++i)
    if (strcmp(key->name, table->either[i]) == 0) return true;
  return false;
}

static scree_result check_list(const recipe_table* table, const recipe_key* key, const recipe_place* at, const void* base,
                               scree_error* error) {
  const uint32_t count = *count_of(key, base);
  if (count == 0 && is_either(table, key)) return SCREE_OK; /* it has the other one, or the table's own check says so */
  if (count < key->least || count > key->size) {
    recipe_say(error, "%s: expected %u to %u %s, got %u", at->text, key->least, key->size, key->of != NULL ? key->of : "elements",
               count);
    return SCREE_ERROR_RANGE;
  }
  scree_result result = SCREE_OK;
  for (uint32_t i = 0; i < count && result == SCREE_OK; ++i) {
    const recipe_place at_item = recipe_element(at, i);
    const void* item = item_of(key, base, i);
    if (key->kind == RECIPE_LIST || key->kind == RECIPE_ROWS)
      result = check_members(table, key->members, &at_item, item, ~0u, error);
    else if (key->kind == RECIPE_PHASES)
      result = check_phase(table, key, &at_item, item, error);
    else
      result = check_number(key, &at_item, number_at(key, item, 0), false, error);
  }
  return result;
}

static scree_result check_key(const recipe_table* table, const recipe_key* key, const recipe_place* at, const void* base,
                              scree_error* error) {
  const void* field = (const char*)base + key->offset;
  scree_result result = SCREE_OK;
  switch (key->kind) {
    case RECIPE_TEXT:
      if (memchr(field, '\0', (size_t)key->max + 1) != NULL) return SCREE_OK;
      recipe_say(error, "%s: expected a text of at most %.0f bytes", at->text, key->max);
      return SCREE_ERROR_RANGE;
    case RECIPE_SEED: return check_number(key, at, (double)*(const uint64_t*)field, true, error);
    case RECIPE_COUNT: return check_number(key, at, *(const uint32_t*)field, true, error);
    case RECIPE_NUMBER: return check_number(key, at, *(const double*)field, false, error);
    case RECIPE_COUNTS:
    case RECIPE_NUMBERS:
      for (uint32_t i = 0; i < key->size && result == SCREE_OK; ++i) {
        const recipe_place item = recipe_element(at, i);
        result = check_number(key, &item, number_at(key, field, i), false, error);
      }
      return result;
    case RECIPE_COUNT_RANGE:
    case RECIPE_RANGE:
      for (uint32_t i = 0; i < 2 && result == SCREE_OK; ++i) result = check_number(key, at, number_at(key, field, i), false, error);
      return result == SCREE_OK ? check_range(at, number_at(key, field, 0), number_at(key, field, 1), error) : result;
    case RECIPE_BOOL: return SCREE_OK;
    case RECIPE_CHOICE: return check_number(key, at, *(const int*)field, true, error);
    case RECIPE_OBJECT: return check_members(table, key->members, at, field, ~0u, error);
    case RECIPE_LIST:
    case RECIPE_ROWS:
    case RECIPE_VALUES:
    case RECIPE_TIMES:
    case RECIPE_PHASES: return check_list(table, key, at, base, error);
  }
  return result;
}

/* Those of the first 32 keys whose bit is set in `chosen`, and that belong to what the object is. */
static scree_result check_members(const recipe_table* table, const recipe_key* keys, const recipe_place* outer, const void* base,
                                  uint32_t chosen, scree_error* error) {
  scree_result result = SCREE_OK;
  for (uint32_t k = 0; keys[k].name != NULL && result == SCREE_OK; ++k) {
    if ((chosen >> (k & 31) & 1) == 0 || !belongs(&keys[k], choice_of(keys, base))) continue;
    if (keys[k].alone && *count_of(&keys[k], base) == 1) {
      result = check_members(table, keys[k].members, outer, item_of(&keys[k], base, 0), ~0u, error);
      continue;
    }
    const recipe_place at = recipe_inside(outer, keys[k].name);
    result = check_key(table, &keys[k], &at, base, error);
  }
  return result;
}

scree_result recipe_check_keys(const recipe_table* table, const void* recipe, scree_error* error) {
  scree_result result = check_members(table, table->keys, &top, recipe, ~0u, error);
  if (result == SCREE_OK && table->rules != NULL)
    result = check_members(table, table->rules, &top, (const char*)recipe + table->rules_at, ~0u, error);
  return result == SCREE_OK ? table->check(recipe, error) : result;
}

/* --- writing ---------------------------------------------------------------------------------------------------------------- */

static void write_value(recipe_writer* out, const recipe_table* table, const recipe_key* key, const void* base);

static void write_name(recipe_writer* out, const char* name, bool first) {
  recipe_put(out, "%s\"%s\": ", first ? "" : ", ", name);
}

static void write_number(recipe_writer* out, const recipe_key* key, const void* field, uint32_t i) {
  if (is_whole(key))
    recipe_put(out, "%u", ((const uint32_t*)field)[i]);
  else
    recipe_put_number(out, ((const double*)field)[i]);
}

static void write_members(recipe_writer* out, const recipe_table* table, const recipe_key* keys, const void* base, bool first) {
  const uint32_t choice = choice_of(keys, base);
  for (const recipe_key* key = keys; key->name != NULL; ++key) {
    if (!belongs(key, choice)) continue;
    if (key->alone && *count_of(key, base) == 1)
      write_members(out, table, key->members, item_of(key, base, 0), first);
    else {
      write_name(out, key->name, first);
      write_value(out, table, key, base);
    }
    first = false;
  }
}

static void write_object(recipe_writer* out, const recipe_table* table, const recipe_key* keys, const void* base) {
  recipe_put(out, "{");
  write_members(out, table, keys, base, true);
  recipe_put(out, "}");
}

static void write_row(recipe_writer* out, const recipe_table* table, const recipe_key* columns, const void* row) {
  for (const recipe_key* column = columns; column->name != NULL; ++column) {
    recipe_put(out, column == columns ? "[" : ", ");
    write_value(out, table, column, row);
  }
  recipe_put(out, "]");
}

static void write_phase(recipe_writer* out, const recipe_table* table, const recipe_key* key, const void* phase) {
  const recipe_key* moment = &key->members[*share_of(key, phase) >= 0 ? 0 : 1];
  recipe_put(out, "{");
  write_name(out, moment->name, true);
  write_value(out, table, moment, phase);
  for (uint32_t k = 0; table->rules[k].name != NULL; ++k) {
    if ((*changes_of(table, phase) >> k & 1) == 0) continue;
    write_name(out, table->rules[k].name, false);
    write_value(out, table, &table->rules[k], rules_of(table, phase));
  }
  recipe_put(out, "}");
}

static void write_list(recipe_writer* out, const recipe_table* table, const recipe_key* key, const void* base) {
  const uint32_t count = *count_of(key, base);
  recipe_put(out, "[");
  for (uint32_t i = 0; i < count; ++i) {
    const void* item = item_of(key, base, i);
    if (i > 0) recipe_put(out, ", ");
    switch (key->kind) {
      case RECIPE_LIST: write_object(out, table, key->members, item); break;
      case RECIPE_ROWS: write_row(out, table, key->members, item); break;
      case RECIPE_PHASES: write_phase(out, table, key, item); break;
      default: write_number(out, key, item, 0);
    }
  }
  recipe_put(out, "]");
}

static void write_numbers(recipe_writer* out, const recipe_key* key, const void* field, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    recipe_put(out, i > 0 ? ", " : "[");
    write_number(out, key, field, i);
  }
  recipe_put(out, "]");
}

static void write_range(recipe_writer* out, const recipe_key* key, const void* field) {
  const double least = number_at(key, field, 0), most = number_at(key, field, 1);
  if (least < most || least > most)
    write_numbers(out, key, field, 2);
  else
    write_number(out, key, field, 0);
}

static void write_value(recipe_writer* out, const recipe_table* table, const recipe_key* key, const void* base) {
  const void* field = (const char*)base + key->offset;
  switch (key->kind) {
    case RECIPE_TEXT: recipe_put_text(out, field); break;
    case RECIPE_SEED: recipe_put(out, "%llu", (unsigned long long)*(const uint64_t*)field); break;
    case RECIPE_COUNT: recipe_put(out, "%u", *(const uint32_t*)field); break;
    case RECIPE_NUMBER: recipe_put_number(out, *(const double*)field); break;
    case RECIPE_COUNTS:
    case RECIPE_NUMBERS: write_numbers(out, key, field, key->size); break;
    case RECIPE_COUNT_RANGE:
    case RECIPE_RANGE: write_range(out, key, field); break;
    case RECIPE_BOOL: recipe_put(out, "%s", *(const bool*)field ? "true" : "false"); break;
    case RECIPE_CHOICE: {
      int length;
      const char* word = word_of(key->words, (uint32_t) * (const int*)field, &length);
      recipe_put(out, "\"%.*s\"", length, word);
      break;
    }
    case RECIPE_OBJECT: write_object(out, table, key->members, field); break;
    case RECIPE_LIST:
    case RECIPE_ROWS:
    case RECIPE_VALUES:
    case RECIPE_TIMES:
    case RECIPE_PHASES: write_list(out, table, key, base); break;
  }
}

static void write_line(recipe_writer* out, const recipe_table* table, const recipe_key* key, const void* base, bool first) {
  recipe_put(out, "%s\n  \"%s\": ", first ? "" : ",", key->name);
  write_value(out, table, key, base);
}

/* Of either of two lists, the one that is not there. */
static bool is_left_out(const recipe_table* table, const recipe_key* key, const void* recipe) {
  if (table->either[0] == NULL) return false;
  const bool has_first = *count_of(find(table->keys, table->either[0]), recipe) > 0;
  return strcmp(key->name, table->either[has_first ? 1 : 0]) == 0;
}

size_t recipe_write(const recipe_table* table, const void* recipe, char* text, size_t capacity) {
  recipe_writer out = {text, capacity, 0};
  bool first = !table->kind_is_needed;
  recipe_put(&out, "{");
  if (!first) recipe_put(&out, "\n  \"kind\": \"%s\"", table->kind);
  for (const recipe_key* key = table->keys; key->name != NULL; ++key) {
    if (is_left_out(table, key, recipe)) continue;
    if (table->rules != NULL && strcmp(key->name, table->rules_before) == 0)
      for (const recipe_key* rule = table->rules; rule->name != NULL; ++rule)
        write_line(&out, table, rule, (const char*)recipe + table->rules_at, false);
    write_line(&out, table, key, recipe, first);
    first = false;
  }
  recipe_put(&out, "\n}\n");
  return out.size;
}
