/* A set of edits as queries and deltas see it: one array, sorted by (layer, cube z, y, x, local). */
#ifndef SCREE_EDITS_INTERNAL_H
#define SCREE_EDITS_INTERNAL_H

#include <scree/edits.h>

typedef struct edits_entry {
  scree_id id;
  scree_edit edit; /* never NONE */
} edits_entry;

struct scree_edits {
  scree_allocator allocator;
  edits_entry* entries; /* capacity, of which count are in use, sorted, each id once */
  size_t count, capacity;
  uint64_t revision;
};

/* Less than, equal to or greater than 0, as a comes before, is, or comes after b. */
int scree_rt_edits_compare(const scree_id* a, const scree_id* b);

/* Walks the edits of the layer with this key in the cubes [low, high), in order: the first from place *next on, NULL at the end.
 * Start with *next = 0. Rows of cubes without an edit are skipped; edits may be NULL. */
const edits_entry* scree_rt_edits_next(const scree_edits* edits, uint16_t layer, const int32_t low[3], const int32_t high[3],
                                       size_t* next);

/* Whether the layer has any edit in the cubes [low, high). */
bool scree_rt_edits_any(const scree_edits* edits, uint16_t layer, const int32_t low[3], const int32_t high[3]);

/* Adds `count` entries, sorted, each id once and none of them NONE; where an id is there already, the new edit stands. Returns
 * false, and changes nothing, when memory is short. */
bool scree_rt_edits_merge(scree_edits* edits, const edits_entry* entries, size_t count);

#endif
