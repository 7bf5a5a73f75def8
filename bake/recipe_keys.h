/* Recipes of all kinds as JSON, by tables of their keys: the reader, --set, the writer and the checks go by the same table, so that
 * they cannot disagree. What an object leaves out has its default. */
#ifndef SCREE_RECIPE_KEYS_H
#define SCREE_RECIPE_KEYS_H

#include <scree/base.h>

typedef enum recipe_key_kind {
  RECIPE_TEXT,        /* char array of `max` + 1 bytes */
  RECIPE_SEED,        /* whole number in a uint64_t */
  RECIPE_COUNT,       /* uint32_t */
  RECIPE_COUNTS,      /* `size` of them */
  RECIPE_COUNT_RANGE, /* two of them, least and most; also a single number */
  RECIPE_NUMBER,      /* double */
  RECIPE_NUMBERS,     /* `size` of them */
  RECIPE_RANGE,       /* scree_range; also a single number */
  RECIPE_BOOL,        /* bool */
  RECIPE_CHOICE,      /* an enum, by one of the words in `words` */
  RECIPE_OBJECT,      /* a struct with the members in `members` */
  RECIPE_LIST,        /* `least` to `size` such structs, how many at `count_at` */
  RECIPE_ROWS,        /* likewise, each written as an array of its members */
  RECIPE_VALUES,      /* likewise doubles */
  RECIPE_TIMES,       /* likewise uint32_t */
  RECIPE_PHASES       /* likewise structs with a double that is below 0 unless it says when the phase begins, the uint32_t that says
                         so otherwise, and rules: by `members` and the table's rules */
} recipe_key_kind;

typedef struct recipe_key {
  const char* name;
  recipe_key_kind kind;
  size_t offset;   /* in the struct that the table is about */
  double min, max; /* both allowed */
  const char* words;
  const struct recipe_key*
      members; /* up to a NULL name. Where the first is a choice, it decides by `only` which others there are */
  const void*
      blank; /* OBJECT, LIST, ROWS: a struct with what is left out; NULL = as the default recipe has it, of lists and rows zero */
  size_t count_at, stride;
  uint32_t least, size;
  uint32_t only;    /* bit c is set where choice c of the first member has this key; 0 = always */
  uint32_t columns; /* ROWS: a row has so many members at least, and of the row before what it leaves out; 0 = it has all */
  const char* of;   /* what an array is of, for errors; NULL = elements or numbers */
  bool alone;       /* LIST: one element alone is written as keys of the object around it */
} recipe_key;

/* For tables. */
#define KEY_AT(type, member) .offset = offsetof(type, member)
#define KEY_ENDS(low, high) .min = (low), .max = (high)

/* A kind of recipe. */
typedef struct recipe_table {
  const char* kind;        /* the word */
  bool kind_is_needed;     /* else what does not say its kind is of this one, and the word is not written */
  const recipe_key* keys;  /* up to a NULL name */
  const recipe_key* rules; /* likewise, of a struct of their own that recipe and phases have; NULL = none */
  size_t rules_at, phase_rules_at;
  size_t phase_changes_at;                                       /* uint32_t in a phase: bit i is set where it has rule i */
  const char* rules_before;                                      /* the key that rules are written before */
  const char* either[2];                                         /* lists of which a recipe has one */
  size_t size;                                                   /* of the struct */
  scree_result (*check)(const void* recipe, scree_error* error); /* what no key alone can say. Returns SCREE_OK or RANGE */
} recipe_table;

/* plain: the default recipe. Each returns SCREE_OK, SYNTAX or RANGE, with one line in `error`, which may be NULL. */

/* out: filled whatever comes back. */
scree_result recipe_read(const recipe_table* table, const void* plain, const char* text, size_t size, void* out,
                         scree_error* error);

/* assignment: KEY=VALUE or OBJECT.MEMBER=VALUE. The recipe is of no use unless SCREE_OK comes back. Also OUT_OF_MEMORY. */
scree_result recipe_assign(const recipe_table* table, const void* plain, const char* assignment, void* recipe, scree_error* error);

/* Every key in its range, for recipes that did not come from JSON. */
scree_result recipe_check_keys(const recipe_table* table, const void* recipe, scree_error* error);

/* Returns the length, of which at most `capacity` are written. */
size_t recipe_write(const recipe_table* table, const void* recipe, char* text, size_t capacity);

#endif
