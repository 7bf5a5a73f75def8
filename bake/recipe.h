/* The keys of a recipe, as one table. */
#ifndef SCREE_RECIPE_H
#define SCREE_RECIPE_H

#include <scree/bake.h>

typedef enum recipe_kind {
  RECIPE_TEXT,
  RECIPE_SEED,        /* whole number in a uint64_t */
  RECIPE_COUNT,       /* uint32_t */
  RECIPE_COUNT_RANGE, /* two uint32_t, least and most */
  RECIPE_NUMBER,      /* double */
  RECIPE_RANGE,       /* scree_range */
  RECIPE_VECTOR,      /* three doubles */
  RECIPE_CHOICE,      /* an enum, by one of the words in `choices` */
  RECIPE_BOOL
} recipe_kind;

typedef struct recipe_key {
  const char* name;
  recipe_kind kind;
  size_t offset;   /* in scree_recipe */
  double min, max; /* both allowed */
  const char* choices;
} recipe_key;

extern const recipe_key recipe_keys[];
extern const size_t recipe_key_count;

/* Every key in its range, and the rules that span keys. Returns SCREE_OK or SCREE_ERROR_RANGE. */
scree_result recipe_check_all(const scree_recipe* recipe, scree_error* error);

#endif
