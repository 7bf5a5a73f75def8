/* What all kinds of recipes share: the words of errors, JSON in, JSON out. */
#ifndef SCREE_RECIPE_TEXT_H
#define SCREE_RECIPE_TEXT_H

#include <cjson/cJSON.h>
#include <scree/base.h>

/* One line, printable. error: may be NULL. */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
void recipe_say(scree_error* error, const char* format, ...);

/* A value of the file as a short piece of text, for errors. */
void recipe_describe(const cJSON* value, char* text, size_t capacity);

/* Where in a recipe something stands, for errors: "phases[2].colluvium.share". */
typedef struct recipe_place {
  char text[128];
} recipe_place;
recipe_place recipe_inside(const recipe_place* outer, const char* name);
recipe_place recipe_element(const recipe_place* outer, uint32_t index);

/* Returns SYNTAX. */
scree_result recipe_wrong_type(const recipe_place* at, const char* expected, const cJSON* value, scree_error* error);
/* A number that is not from min to max, or not whole where it has to be, is RANGE; NaN is out of every range. */
scree_result recipe_check_number(const recipe_place* at, double min, double max, double number, bool whole, scree_error* error);

/* A member that an object may have once; there: it has a meaning. Returns SCREE_OK or SYNTAX. */
scree_result recipe_check_member(const cJSON* object, const cJSON* item, const recipe_place* at, bool there, scree_error* error);

/* The object that a recipe is, to be freed with cJSON_Delete, or NULL with what is wrong in `error`; repeated keys are wrong. */
cJSON* recipe_root(const char* text, size_t size, scree_error* error);

/* The name of KEY=VALUE, to be as long as keys are at most, and where VALUE begins; NULL with what is wrong in `error`. */
#define RECIPE_NAME_SIZE 64
const char* recipe_assignment(const char* assignment, char name[RECIPE_NAME_SIZE], scree_error* error);

/* The value of a --set: JSON, or else a text without quotes. NULL when memory is short. */
cJSON* recipe_set_value(const char* text);

/* Appends like snprintf, counting what does not fit. */
typedef struct recipe_writer {
  char* text;
  size_t capacity, size;
} recipe_writer;

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
void recipe_put(recipe_writer* out, const char* format, ...);
/* The shortest decimal that reads back as the same number. */
void recipe_put_number(recipe_writer* out, double number);
void recipe_put_text(recipe_writer* out, const char* text);

#endif
