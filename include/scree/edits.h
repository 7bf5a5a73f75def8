/* Edits: which rocks of a scene were removed or hidden, by their ids; what a saved game keeps. */
#ifndef SCREE_EDITS_H
#define SCREE_EDITS_H

#include "field.h"

#ifdef __cplusplus
extern "C" {
#endif

struct scree_scene;

typedef struct scree_edits scree_edits;

typedef enum scree_edit {
  SCREE_EDIT_NONE = 0,   /* as it was made: what restore gives */
  SCREE_EDIT_REMOVE = 1, /* gone: not drawn, not hit; its neighbours come into view */
  SCREE_EDIT_HIDE = 2    /* not drawn; rays, overlaps and hulls still find it */
} scree_edit;

/* An empty set. Memory grows with the edits, about 24 bytes each. Not thread-safe while it is changed; any number of threads may
 * read one that is not. */
SCREE_API scree_result scree_edits_create(const scree_allocator* allocator, scree_edits** out);
SCREE_API void scree_edits_destroy(scree_edits* edits);

/* Sets the state of one rock; NONE restores it. An id is taken as it is: whether a rock is there, scree_scene_find tells.
 * Returns SCREE_OK, INVALID_ARGUMENT or OUT_OF_MEMORY (nothing has changed then). */
SCREE_API scree_result scree_edits_set(scree_edits* edits, const scree_id* id, scree_edit edit);
SCREE_API scree_edit scree_edits_get(const scree_edits* edits, const scree_id* id);
SCREE_API void scree_edits_clear(scree_edits* edits);
SCREE_API uint64_t scree_edits_count(const scree_edits* edits);

/* A number that every change makes larger. */
SCREE_API uint64_t scree_edits_revision(const scree_edits* edits);

/* The edits in order of (layer, cube z, y, x, local), from `first` on. ids, edits_out: `capacity` elements, may be NULL. Returns
 * how many were written. */
SCREE_API uint64_t scree_edits_list(const scree_edits* edits, uint64_t first, scree_id* ids, scree_edit* edits_out,
                                    uint64_t capacity);

/* Writes the delta: a small, sorted, versioned and checksummed blob, little-endian, the same bytes for the same edits on every
 * machine (docs/edits_format.md). For each layer it holds a fingerprint of what its ids mean: digest of the pack, seed, cell size
 * (of a scatter, the width of its tiles) and origin. bytes: `capacity`, may be NULL when that is 0. size: how many are needed,
 * always delivered. Returns SCREE_OK, CAPACITY or INVALID_ARGUMENT (an id whose layer the scene does not have). */
SCREE_API scree_result scree_edits_save(const scree_edits* edits, const struct scree_scene* scene, uint8_t* bytes, size_t capacity,
                                        size_t* size);

/* What became of the edits of a delta. */
typedef struct scree_edits_report {
  uint64_t applied;
  uint64_t unknown_layer; /* the scene has no layer with the key */
  uint64_t stale;         /* the layer is made of something else now: other pack, seed, cell size or origin */
  uint64_t unknown_rock;  /* no such rock in the tile that stands there */
} scree_edits_report;

/* Adds the edits of a delta. Whatever is unknown or stale is counted and left out, never applied to another rock. Trusts nothing.
 * Returns SCREE_OK, NOT_A_PACK (not a delta), VERSION, TRUNCATED, DIGEST, CORRUPT or OUT_OF_MEMORY; on failure nothing has changed.
 */
SCREE_API scree_result scree_edits_load(scree_edits* edits, const struct scree_scene* scene, const uint8_t* bytes, size_t size,
                                        scree_edits_report* report);

#ifdef __cplusplus
}
#endif

#endif
