/* The keys of recipes of hoodoos, as tables. */
#ifndef SCREE_HOODOO_RECIPE_H
#define SCREE_HOODOO_RECIPE_H

#include <scree/hoodoo.h>

typedef enum hoodoo_kind {
  HOODOO_TEXT,       /* char array of `max` + 1 bytes */
  HOODOO_SEED,       /* whole number in a uint64_t */
  HOODOO_COUNT,      /* uint32_t */
  HOODOO_COUNTS,     /* three uint32_t */
  HOODOO_NUMBER,     /* double */
  HOODOO_BOOL,       /* bool */
  HOODOO_CHOICE,     /* an enum, by one of the words in `words` */
  HOODOO_OBJECT,     /* the members in `members`, of the same struct as this key */
  HOODOO_DURABILITY, /* rows of 2 to 5 numbers: members of a scree_durability_point, by `members` */
  HOODOO_BUBBLES,    /* array of scree_bubble_segment, by `members` */
  HOODOO_MIXTURE,    /* array of scree_bubble, by `members` */
  HOODOO_AGES,       /* array of falling doubles */
  HOODOO_AGE_STEPS,  /* array of rising uint32_t */
  HOODOO_PHASES      /* array of scree_hoodoo_phase, by `members` and the keys of rules */
} hoodoo_kind;

typedef struct hoodoo_key {
  const char* name;
  hoodoo_kind kind;
  size_t offset;   /* in the struct that the table is about */
  double min, max; /* both allowed; of arrays, of their numbers or of their length */
  const char* words;
  const struct hoodoo_key* members; /* up to a NULL name */
  uint32_t shapes;                  /* start: bit s is set where shape s has this key; 0 = every shape */
} hoodoo_key;

extern const hoodoo_key hoodoo_keys[];      /* of scree_hoodoo_recipe, up to a NULL name */
extern const hoodoo_key hoodoo_rule_keys[]; /* of scree_hoodoo_rules; bit i of scree_hoodoo_phase.changes is key i */

/* The rules that span keys. Returns SCREE_OK or SCREE_ERROR_RANGE. */
scree_result hoodoo_check(const scree_hoodoo_recipe* recipe, scree_error* error);

/* Every key in its range too, for recipes that did not come from JSON. */
scree_result hoodoo_check_all(const scree_hoodoo_recipe* recipe, scree_error* error);

/* Of all randomness of a variant. */
uint64_t hoodoo_variant_seed(const scree_hoodoo_recipe* recipe, uint32_t variant);

#endif
