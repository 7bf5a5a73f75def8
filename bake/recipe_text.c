#include "recipe_text.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void recipe_say(scree_error* error, const char* format, ...) {
  if (error == NULL) return;
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(error->message, sizeof error->message, format, arguments);
  va_end(arguments);
  for (char* c = error->message; *c != '\0'; ++c)
    if ((unsigned char)*c < ' ') *c = ' ';
}

void recipe_describe(const cJSON* value, char* text, size_t capacity) {
  if (cJSON_IsString(value))
    snprintf(text, capacity, "\"%.40s\"", value->valuestring);
  else if (cJSON_IsNumber(value))
    snprintf(text, capacity, "%g", value->valuedouble);
  else if (cJSON_IsBool(value))
    snprintf(text, capacity, "%s", cJSON_IsTrue(value) ? "true" : "false");
  else
    snprintf(text, capacity, "%s", cJSON_IsArray(value) ? "an array" : cJSON_IsObject(value) ? "an object" : "null");
}

recipe_place recipe_inside(const recipe_place* outer, const char* name) {
  recipe_place at;
  snprintf(at.text, sizeof at.text, "%.80s%s%.40s", outer->text, outer->text[0] != '\0' ? "." : "", name);
  return at;
}

recipe_place recipe_element(const recipe_place* outer, uint32_t index) {
  recipe_place at;
  snprintf(at.text, sizeof at.text, "%.110s[%u]", outer->text, index);
  return at;
}

scree_result recipe_wrong_type(const recipe_place* at, const char* expected, const cJSON* value, scree_error* error) {
  char got[64];
  recipe_describe(value, got, sizeof got);
  recipe_say(error, "%s: expected %s, got %s", at->text, expected, got);
  return SCREE_ERROR_SYNTAX;
}

scree_result recipe_check_number(const recipe_place* at, double min, double max, double number, bool whole, scree_error* error) {
  if (number >= min && number <= max && (!whole || floor(number) == number)) return SCREE_OK;
  recipe_say(error, "%s: expected a %snumber from %.10g to %.10g, got %.10g", at->text, whole ? "whole " : "", min, max, number);
  return SCREE_ERROR_RANGE;
}

scree_result recipe_check_member(const cJSON* object, const cJSON* item, const recipe_place* at, bool there, scree_error* error) {
  bool twice = false;
  for (const cJSON* other = object->child; other != item; other = other->next)
    twice = twice || strcmp(other->string, item->string) == 0;
  if (there && !twice) return SCREE_OK;
  recipe_say(error, "%s: %s", at->text, twice ? "given twice" : "unknown key");
  return SCREE_ERROR_SYNTAX;
}

static bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

cJSON* recipe_root(const char* text, size_t size, scree_error* error) {
  const char* end = NULL;
  cJSON* root = cJSON_ParseWithLengthOpts(text, size, &end, false);
  while (root != NULL && end < text + size && is_space(*end)) ++end;
  if (root != NULL && end < text + size) {
    cJSON_Delete(root);
    root = NULL;
  }
  if (root == NULL) {
    size_t line = 1;
    for (const char* c = text; end != NULL && c < end && c < text + size; ++c) line += *c == '\n';
    recipe_say(error, "line %zu: not valid JSON", line);
    return NULL;
  }
  const char* wrong = cJSON_IsObject(root) ? NULL : "a recipe is a JSON object";
  if (wrong != NULL) recipe_say(error, "%s", wrong);
  for (const cJSON* item = root->child; item != NULL && wrong == NULL; item = item->next)
    for (const cJSON* other = root->child; other != item && wrong == NULL; other = other->next)
      if (strcmp(other->string, item->string) == 0) {
        wrong = item->string;
        recipe_say(error, "%.60s: given twice", item->string);
      }
  if (wrong == NULL) return root;
  cJSON_Delete(root);
  return NULL;
}

const char* recipe_assignment(const char* assignment, char name[RECIPE_NAME_SIZE], scree_error* error) {
  const char* equals = strchr(assignment, '=');
  if (equals == NULL || equals - assignment >= RECIPE_NAME_SIZE) {
    recipe_say(error, "%.60s: expected KEY=VALUE", assignment);
    return NULL;
  }
  memcpy(name, assignment, (size_t)(equals - assignment));
  name[equals - assignment] = '\0';
  return equals + 1;
}

cJSON* recipe_set_value(const char* text) {
  cJSON* value = cJSON_ParseWithOpts(text, NULL, true);
  return value != NULL ? value : cJSON_CreateString(text);
}

void recipe_put(recipe_writer* out, const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  const size_t room = out->size < out->capacity ? out->capacity - out->size : 0;
  out->size += (size_t)vsnprintf(room > 0 ? out->text + out->size : NULL, room, format, arguments);
  va_end(arguments);
}

void recipe_put_number(recipe_writer* out, double number) {
  char text[32];
  for (int digits = 1; digits <= 17; ++digits) {
    snprintf(text, sizeof text, "%.*g", digits, number);
    if (strtod(text, NULL) == number) break;
  }
  recipe_put(out, "%s", text);
}

void recipe_put_text(recipe_writer* out, const char* text) {
  recipe_put(out, "\"");
  for (; *text != '\0'; ++text) {
    const unsigned char c = (unsigned char)*text;
    if (c == '"' || c == '\\')
      recipe_put(out, "\\%c", c);
    else if (c < ' ')
      recipe_put(out, "\\u%04x", c);
    else
      recipe_put(out, "%c", c);
  }
  recipe_put(out, "\"");
}
