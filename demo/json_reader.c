/* Typed values out of a cJSON tree. */
#include "json_reader.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "file.h"

static void append(json_reader* reader, const char* text) {
  size_t room = sizeof reader->path - 1 - reader->length;
  size_t length = strlen(text);
  if (length > room) {
    length = 0;
    memcpy(reader->path + sizeof reader->path - 4, "...", 4);
    reader->length = sizeof reader->path - 1;
  }
  memcpy(reader->path + reader->length, text, length);
  reader->length += length;
  reader->path[reader->length] = '\0';
}

size_t json_enter_key(json_reader* reader, const char* key) {
  size_t before = reader->length;
  if (before > 0) append(reader, ".");
  append(reader, key);
  return before;
}

size_t json_enter_index(json_reader* reader, uint32_t index) {
  size_t before = reader->length;
  char text[16];
  snprintf(text, sizeof text, "[%u]", index);
  append(reader, text);
  return before;
}

void json_leave(json_reader* reader, size_t length) {
  reader->length = length;
  reader->path[length] = '\0';
}

static bool fail_text(json_reader* reader, scree_result result, const char* key, const char* text) {
  if (reader->result != SCREE_OK) return false;
  reader->result = result;
  size_t before = reader->length;
  if (key != NULL) json_enter_key(reader, key);
  fail_with(reader->error, result, "%s: %s%s%s", reader->file, reader->path, reader->length > 0 ? ": " : "", text);
  json_leave(reader, before);
  return false;
}

bool json_fail(json_reader* reader, const char* key, const char* format, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return fail_text(reader, SCREE_ERROR_SYNTAX, key, text);
}

bool json_fail_memory(json_reader* reader) {
  return fail_text(reader, SCREE_ERROR_OUT_OF_MEMORY, NULL, "out of memory");
}

static void describe(const cJSON* value, char* text, size_t capacity) {
  if (value == NULL) {
    snprintf(text, capacity, "nothing");
  } else if (cJSON_IsNumber(value)) {
    snprintf(text, capacity, "%.15g", value->valuedouble);
  } else if (cJSON_IsString(value)) {
    bool cut = strlen(value->valuestring) > 40;
    snprintf(text, capacity, "\"%.40s%s\"", value->valuestring, cut ? "..." : "");
  } else if (cJSON_IsBool(value)) {
    snprintf(text, capacity, cJSON_IsTrue(value) ? "true" : "false");
  } else if (cJSON_IsArray(value)) {
    int count = cJSON_GetArraySize(value);
    snprintf(text, capacity, "an array of %d", count);
  } else {
    snprintf(text, capacity, cJSON_IsNull(value) ? "null" : "an object");
  }
}

bool json_fail_expected(json_reader* reader, const char* key, const char* expected, const cJSON* got) {
  char found[64], text[256];
  describe(got, found, sizeof found);
  snprintf(text, sizeof text, "expected %s, got %s", expected, found);
  bool is_range = cJSON_IsNumber(got) && strstr(expected, "number") != NULL;
  return fail_text(reader, is_range ? SCREE_ERROR_RANGE : SCREE_ERROR_SYNTAX, key, text);
}

cJSON* json_parse(json_reader* reader, const char* text, size_t size) {
  const char* end = memchr(text, '\0', size);
  const char* stop = NULL;
  cJSON* root = NULL;
  if (end == NULL) root = cJSON_ParseWithLengthOpts(text, size + 1, &stop, true);
  if (root != NULL) return root;
  if (end == NULL && stop != NULL) end = stop;
  if (end == NULL || end > text + size) end = text + size;
  unsigned line = 1, column = 1;
  for (const char* c = text; c < end; ++c) {
    ++column;
    if (*c == '\n') {
      ++line;
      column = 1;
    }
  }
  json_fail(reader, NULL, "line %u, column %u: not valid JSON", line, column);
  return NULL;
}

static bool listed(const char* const* keys, const char* key) {
  for (; keys != NULL && *keys != NULL; ++keys) {
    if (strcmp(*keys, key) == 0) return true;
  }
  return false;
}

bool json_check_object(json_reader* reader, const cJSON* value, const char* const* keys, const char* const* more_keys) {
  if (reader->result != SCREE_OK) return false;
  if (!cJSON_IsObject(value)) return json_fail_expected(reader, NULL, "an object", value);
  const cJSON* item;
  cJSON_ArrayForEach(item, value) {
    char key[64];
    snprintf(key, sizeof key, "%s", item->string);
    if (!listed(keys, item->string) && !listed(more_keys, item->string)) return json_fail(reader, key, "unknown key");
    /* Every key is known by now, so an object that passes has few of them and looking back is cheap. */
    for (const cJSON* earlier = value->child; earlier != item; earlier = earlier->next) {
      if (strcmp(earlier->string, item->string) == 0) return json_fail(reader, key, "key appears twice");
    }
  }
  return true;
}

static void describe_limits(json_limits limits, char* text, size_t capacity) {
  bool has_min = limits.min > -HUGE_VAL, has_max = limits.max < HUGE_VAL;
  if (has_min && has_max) {
    snprintf(text, capacity, "a number in %g..%g%s", limits.min, limits.max,
             limits.above_min || limits.below_max ? ", limits excluded" : "");
    if (limits.above_min != limits.below_max)
      snprintf(text, capacity, "a number %s %g and %s %g", limits.above_min ? ">" : ">=", limits.min,
               limits.below_max ? "<" : "<=", limits.max);
  } else if (has_min) {
    snprintf(text, capacity, "a number %s %g", limits.above_min ? ">" : ">=", limits.min);
  } else {
    snprintf(text, capacity, "a finite number");
  }
}

static bool number_value(json_reader* reader, const char* key, const cJSON* value, json_limits limits, double* out) {
  double number = cJSON_IsNumber(value) ? value->valuedouble : 0;
  bool good = cJSON_IsNumber(value) && isfinite(number) && (limits.above_min ? number > limits.min : number >= limits.min) &&
              (limits.below_max ? number < limits.max : number <= limits.max);
  if (!good) {
    char expected[96];
    describe_limits(limits, expected, sizeof expected);
    return json_fail_expected(reader, key, expected, value);
  }
  *out = number;
  return true;
}

/* object[key], or NULL; *go_on is what the caller returns when there is nothing to read. */
static const cJSON* find(const json_reader* reader, const cJSON* object, const char* key, bool* go_on) {
  *go_on = reader->result == SCREE_OK;
  return *go_on ? cJSON_GetObjectItemCaseSensitive(object, key) : NULL;
}

bool json_number(json_reader* reader, const cJSON* object, const char* key, json_limits limits, double* out) {
  bool go_on;
  const cJSON* value = find(reader, object, key, &go_on);
  return value == NULL ? go_on : number_value(reader, key, value, limits, out);
}

bool json_vector(json_reader* reader, const cJSON* object, const char* key, json_limits limits, uint32_t count, double* out) {
  bool go_on;
  const cJSON* value = find(reader, object, key, &go_on);
  if (value == NULL) return go_on;
  if (!cJSON_IsArray(value) || cJSON_GetArraySize(value) != (int)count) {
    char expected[48];
    snprintf(expected, sizeof expected, "an array of %u numbers", count);
    return json_fail_expected(reader, key, expected, value);
  }
  size_t before = json_enter_key(reader, key);
  const cJSON* item;
  uint32_t i = 0;
  bool good = true;
  cJSON_ArrayForEach(item, value) {
    size_t element = json_enter_index(reader, i);
    good = good && number_value(reader, NULL, item, limits, &out[i]);
    json_leave(reader, element);
    ++i;
  }
  json_leave(reader, before);
  return good;
}

bool json_number_value(json_reader* reader, const cJSON* value, json_limits limits, double* out) {
  return reader->result == SCREE_OK && number_value(reader, NULL, value, limits, out);
}

static bool integer_value(json_reader* reader, const char* key, const cJSON* value, uint64_t min, uint64_t max, uint64_t* out) {
  double number = cJSON_IsNumber(value) ? value->valuedouble : -1;
  if (!(number >= (double)min && number <= (double)max && floor(number) == number)) {
    char expected[96];
    snprintf(expected, sizeof expected, "a whole number in %llu..%llu", (unsigned long long)min, (unsigned long long)max);
    return json_fail_expected(reader, key, expected, value);
  }
  *out = (uint64_t)number;
  return true;
}

bool json_integer(json_reader* reader, const cJSON* object, const char* key, uint64_t min, uint64_t max, uint64_t* out) {
  bool go_on;
  const cJSON* value = find(reader, object, key, &go_on);
  return value == NULL ? go_on : integer_value(reader, key, value, min, max, out);
}

bool json_integers(json_reader* reader, const cJSON* object, const char* key, uint32_t max, uint32_t count, uint32_t* out) {
  bool go_on;
  const cJSON* value = find(reader, object, key, &go_on);
  if (value == NULL) return go_on;
  if (!cJSON_IsArray(value) || cJSON_GetArraySize(value) != (int)count) {
    char expected[48];
    snprintf(expected, sizeof expected, "an array of %u whole numbers", count);
    return json_fail_expected(reader, key, expected, value);
  }
  size_t before = json_enter_key(reader, key);
  const cJSON* item;
  uint32_t i = 0;
  bool good = true;
  cJSON_ArrayForEach(item, value) {
    uint64_t number = 0;
    size_t element = json_enter_index(reader, i);
    good = good && integer_value(reader, NULL, item, 0, max, &number);
    json_leave(reader, element);
    out[i++] = (uint32_t)number;
  }
  json_leave(reader, before);
  return good;
}

bool json_bool(json_reader* reader, const cJSON* object, const char* key, bool* out) {
  bool go_on;
  const cJSON* value = find(reader, object, key, &go_on);
  if (value == NULL) return go_on;
  if (!cJSON_IsBool(value)) return json_fail_expected(reader, key, "true or false", value);
  *out = cJSON_IsTrue(value) != 0;
  return true;
}

/* Whether text is well-formed UTF-8 without control characters: it goes into other JSON files and onto terminals. */
static bool is_clean_text(const char* text) {
  const unsigned char* c = (const unsigned char*)text;
  while (*c != 0) {
    if (*c < 0x20 || *c == 0x7f) return false;
    uint32_t code = *c, more = 0;
    if (*c >= 0x80) {
      if ((*c & 0xe0) == 0xc0) {
        code = *c & 0x1fu, more = 1;
      } else if ((*c & 0xf0) == 0xe0) {
        code = *c & 0x0fu, more = 2;
      } else if ((*c & 0xf8) == 0xf0) {
        code = *c & 0x07u, more = 3;
      } else {
        return false;
      }
    }
    ++c;
    for (uint32_t i = 0; i < more; ++i, ++c) {
      if ((*c & 0xc0) != 0x80) return false;
      code = code << 6 | (*c & 0x3fu);
    }
    static const uint32_t least[4] = {0, 0x80, 0x800, 0x10000};
    if (code < least[more] || code > 0x10ffff || (code >= 0xd800 && code <= 0xdfff)) return false;
  }
  return true;
}

static bool text_value(json_reader* reader, const char* key, const cJSON* value, size_t capacity, char* out) {
  if (!cJSON_IsString(value)) return json_fail_expected(reader, key, "a string", value);
  size_t length = strlen(value->valuestring);
  if (length >= capacity) return json_fail(reader, key, "expected at most %zu bytes of text, got %zu", capacity - 1, length);
  if (!is_clean_text(value->valuestring)) return json_fail(reader, key, "expected UTF-8 text without control characters");
  memcpy(out, value->valuestring, length + 1);
  return true;
}

bool json_string(json_reader* reader, const cJSON* object, const char* key, size_t capacity, char* out) {
  bool go_on;
  const cJSON* value = find(reader, object, key, &go_on);
  return value == NULL ? go_on : text_value(reader, key, value, capacity, out);
}

bool json_string_value(json_reader* reader, const cJSON* value, size_t capacity, char* out) {
  return reader->result == SCREE_OK && text_value(reader, NULL, value, capacity, out);
}

static int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

bool json_colour_value(json_reader* reader, const cJSON* value, float out[3]) {
  if (reader->result != SCREE_OK) return false;
  const char* text = cJSON_IsString(value) ? value->valuestring : "";
  bool good = strlen(text) == 7 && text[0] == '#';
  for (int i = 1; good && i < 7; ++i) good = hex_digit(text[i]) >= 0;
  if (!good) return json_fail_expected(reader, NULL, "a colour such as \"#a09080\"", value);
  for (int i = 0; i < 3; ++i) out[i] = (float)(hex_digit(text[1 + 2 * i]) * 16 + hex_digit(text[2 + 2 * i])) / 255.0f;
  return true;
}

bool json_colour(json_reader* reader, const cJSON* object, const char* key, float out[3]) {
  bool go_on;
  const cJSON* value = find(reader, object, key, &go_on);
  if (value == NULL) return go_on;
  size_t before = json_enter_key(reader, key);
  bool good = json_colour_value(reader, value, out);
  json_leave(reader, before);
  return good;
}
