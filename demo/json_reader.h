/* Reads typed values out of a JSON tree and says exactly what is wrong: the file, the path of the key, what was expected and what
 * was found. The first fault is kept, calls after it do nothing and return false, so callers may chain them. */
#ifndef JSON_READER_H
#define JSON_READER_H

#include <cjson/cJSON.h>
#include <scree/base.h>

typedef struct json_reader {
  const char* file;   /* for messages */
  scree_error* error; /* may be NULL */
  scree_result result;
  char path[256]; /* "fields[0].support"; a longer one ends in "..." */
  size_t length;
} json_reader;

/* Limits of a number, and the words for them. */
typedef struct json_limits {
  double min, max;
  bool above_min, below_max; /* the limits themselves are excluded */
} json_limits;

/* Parses `size` bytes that are followed by a NUL. NULL on failure, with line and column in the message. To be freed with
 * cJSON_Delete. */
cJSON* json_parse(json_reader* reader, const char* text, size_t size);

/* Enters and leaves a key or an element. json_enter returns the length that json_leave takes. */
size_t json_enter_key(json_reader* reader, const char* key);
size_t json_enter_index(json_reader* reader, uint32_t index);
void json_leave(json_reader* reader, size_t length);

/* Records a fault at the current path, or at `key` below it when that is not NULL. Returns false. */
#ifdef __GNUC__
__attribute__((format(printf, 3, 4)))
#endif
bool json_fail(json_reader* reader, const char* key, const char* format, ...);
bool json_fail_expected(json_reader* reader, const char* key, const char* expected, const cJSON* got);
bool json_fail_memory(json_reader* reader);

/* Checks that a value is an object whose keys are all in one of the two NULL-terminated lists (the second may be NULL), each once.
 */
bool json_check_object(json_reader* reader, const cJSON* value, const char* const* keys, const char* const* more_keys);

/* Each reads object[key] into *out and leaves *out alone when the key is absent. */
bool json_number(json_reader* reader, const cJSON* object, const char* key, json_limits limits, double* out);
bool json_vector(json_reader* reader, const cJSON* object, const char* key, json_limits limits, uint32_t count, double* out);
bool json_integer(json_reader* reader, const cJSON* object, const char* key, uint64_t min, uint64_t max, uint64_t* out);
bool json_integers(json_reader* reader, const cJSON* object, const char* key, uint32_t max, uint32_t count, uint32_t* out);
bool json_bool(json_reader* reader, const cJSON* object, const char* key, bool* out);
bool json_string(json_reader* reader, const cJSON* object, const char* key, size_t capacity, char* out);
bool json_colour(json_reader* reader, const cJSON* object, const char* key, float out[3]);

/* A text, a number, a colour at the current path. */
bool json_string_value(json_reader* reader, const cJSON* value, size_t capacity, char* out);
bool json_number_value(json_reader* reader, const cJSON* value, json_limits limits, double* out);
bool json_colour_value(json_reader* reader, const cJSON* value, float out[3]);

#endif
