/* A field: a pack, a seed, a cell size and a place; an endless virtual mass of rock. A query asks which rocks of a field a support
 * makes exist inside a box. It is a pure function: no order, no state, nothing stored. */
#ifndef SCREE_FIELD_H
#define SCREE_FIELD_H

#include "pack.h"
#include "support.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct scree_field scree_field;

typedef struct scree_field_desc {
  const scree_pack* pack; /* must outlive the field */
  uint64_t seed;          /* colours of the corners; any value */
  double cell_size;       /* metres, > 0: the mean distance between stones at one seed a cell */
  double origin[3];       /* world position of corner (0, 0, 0), metres */
} scree_field_desc;

/* Makes a field: builds the tables that queries read (a few bytes a rock), after checking every table of the pack.
 * Returns SCREE_OK, INVALID_ARGUMENT, RANGE, PACK_KIND (a pack of models or of a cliff), CORRUPT or OUT_OF_MEMORY. A field is
 * immutable and may be shared between threads. */
SCREE_API scree_result scree_field_create(const scree_field_desc* desc, const scree_allocator* allocator, scree_field** out);
SCREE_API void scree_field_destroy(scree_field* field);

/* One rock in the world. 16 bytes. */
typedef struct scree_instance {
  float position[3]; /* of the home cell's centre, metres, relative to the query's origin; meshes are relative to this point */
  uint32_t asset;
} scree_instance;

/* The stable name of a rock: never depends on a buffer row, a level of detail, a query or a visit order. 16 bytes. */
typedef struct scree_id {
  int32_t cube[3]; /* the corner cube whose half-open box holds the rock's home cell */
  uint16_t local;  /* (x + N (y + N z)) * max_rocks_per_cell + seed, with the cell (x, y, z) in the cube */
  uint16_t layer;  /* key of the layer in scenes of several (scene.h); 0 in queries of one field */
} scree_id;

enum {
  SCREE_QUERY_SHELL = 1u << 0 /* drop rocks deeper than shell_depth below the support's surface: nobody sees them */
};

typedef struct scree_query_desc {
  const scree_field* field;
  const scree_support* support;
  double origin[3];      /* positions are delivered relative to this world point, metres; it never decides which rocks exist */
  double min[3], max[3]; /* world box; a rock belongs to the box that holds its home cell's centre, min <= c < max, so boxes that
                            share a face share no rock; all zero = wherever the support is */
  float threshold;       /* share of a rock's volume that must lie inside the support, 0..1 exclusive; 0 = 0.5; see below */
  float shell_depth;     /* metres; 0 = twice the largest radius of the pack, the paper's depth */
  uint32_t flags;        /* SCREE_QUERY_... */
} scree_query_desc;

/* Which rocks exist: those whose centroid's signed distance to the support is at most (1 - 2 threshold) * r, with r the mean of the
 * rock's inner and outer radius in metres; for one half, the centroid has to be inside. This is decided in the support's space,
 * from the home cell's integers and the difference of the two origins: neither the box, nor the query's origin, nor the order of
 * anything can matter, and where field and support move together by a distance that doubles hold exactly, nothing changes at all.
 *
 * Queries use up to 100 KiB of the calling thread's stack, whatever the support, plus what a callback uses. */

/* How many rocks the query finds. The count is exact. Returns SCREE_OK, INVALID_ARGUMENT or RANGE (a box beyond the int32 cubes).
 * Thread-safe; allocates nothing. */
SCREE_API scree_result scree_query_count(const scree_query_desc* desc, uint64_t* count);

/* Finds the rocks. Their order is fixed for one box, by no rule that is promised.
 * instances: `capacity` elements. ids: NULL or `capacity` elements, the same order. count: how many there are, always delivered.
 * Elements past the count may have been written to.
 * Returns SCREE_OK, CAPACITY (the first `capacity` rocks were written), INVALID_ARGUMENT or RANGE. Thread-safe; allocates nothing.
 */
SCREE_API scree_result scree_query_fill(const scree_query_desc* desc, scree_instance* instances, scree_id* ids, uint64_t capacity,
                                        uint64_t* count);

/* A 32-bit hash of a rock's place in the world, for colour and wear: the same rock of the same field always gets the same value,
 * two places with the same asset do not. */
SCREE_API uint32_t scree_world_hash(const scree_field* field, const scree_id* id);

/* The tile code (0..255) of a cube of the field. */
SCREE_API uint32_t scree_field_tile_code(const scree_field* field, const int32_t cube[3]);

#ifdef __cplusplus
}
#endif

#endif
