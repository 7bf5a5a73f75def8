/* The keys of recipes of shards, as tables. */
#ifndef SCREE_SHARD_KEYS_H
#define SCREE_SHARD_KEYS_H

#include <scree/shard_recipe.h>

typedef enum shard_key_kind {
  SHARD_TEXT,    /* char array of `max` + 1 bytes */
  SHARD_SEED,    /* whole number in a uint64_t */
  SHARD_COUNT,   /* uint32_t */
  SHARD_COUNTS,  /* `size` of them */
  SHARD_NUMBER,  /* double */
  SHARD_NUMBERS, /* `size` of them */
  SHARD_BOOL,    /* bool */
  SHARD_CHOICE,  /* an enum, by one of the words in `words` */
  SHARD_OBJECT,  /* a struct with the members in `members` */
  SHARD_LIST,    /* `least` to `size` such structs, how many at `count_at` */
  SHARD_ROWS,    /* likewise, each written as an array of all its members */
  SHARD_VALUES,  /* likewise doubles */
  SHARD_TIMES,   /* likewise uint32_t */
  SHARD_PHASES   /* scree_shard_phase, by `members` and the keys of rules */
} shard_key_kind;

typedef struct shard_key {
  const char* name;
  shard_key_kind kind;
  size_t offset;   /* in the struct that the table is about */
  double min, max; /* both allowed */
  const char* words;
  const struct shard_key* members; /* up to a NULL name. Where the first is a choice, it decides by `only` which others there are */
  const void* blank;               /* OBJECT, LIST, ROWS: a struct with what is left out; NULL = as the default recipe has it */
  size_t count_at, stride;
  uint32_t least, size;
  uint32_t only; /* bit c is set where choice c of the first member has this key; 0 = always */
} shard_key;

extern const shard_key shard_keys[];      /* of scree_shard_recipe, up to a NULL name */
extern const shard_key shard_rule_keys[]; /* of scree_shard_rules; bit i of scree_shard_phase.changes is key i */

/* The rules that span keys. Returns SCREE_OK or SCREE_ERROR_RANGE. */
scree_result shard_check(const scree_shard_recipe* recipe, scree_error* error);

/* Every key in its range too, for recipes that did not come from JSON. */
scree_result shard_check_all(const scree_shard_recipe* recipe, scree_error* error);

#endif
