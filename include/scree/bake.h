/* The baker: a recipe in, a pack out, all in memory. `scree-bake` is a thin program over these calls.
 *
 * Thread safety: calls share nothing but what they are given, so that recipes and bakes that differ may run at the same time. */
#ifndef SCREE_BAKE_H
#define SCREE_BAKE_H

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What a recipe is of. */
typedef enum scree_recipe_kind { SCREE_RECIPE_ROCKS = 0, SCREE_RECIPE_HOODOO = 1, SCREE_RECIPE_SHARDS = 2 } scree_recipe_kind;

/* Which kind a recipe is of: its key "kind" says "rocks", "hoodoo" or "shards"; without it, rocks. Hoodoos are in scree/hoodoo.h,
 * shards in scree/shard_recipe.h. Returns SCREE_OK or SYNTAX; error: may be NULL. */
SCREE_API scree_result scree_recipe_get_kind(const char* text, size_t size, scree_recipe_kind* out, scree_error* error);

typedef struct scree_range {
  double min, max; /* uniform in [min, max]; min == max is a fixed value */
} scree_range;

typedef enum scree_orientation {
  SCREE_ORIENTATION_RANDOM = 0, /* uniform over all rotations */
  SCREE_ORIENTATION_ALIGNED = 1 /* the frame's z axis within `align_angle` of `align_axis`, spun freely around it */
} scree_orientation;

/* Everything that decides how rocks look. Lengths in cells. scree_recipe_default fills it with the default boulders; the JSON
 * keys are the same names, see content/schema/recipe.schema.json. */
typedef struct scree_recipe {
  char name[64];
  uint64_t random_seed;           /* 0..2^53, what a JSON number holds exactly */
  uint32_t n;                     /* the paper's n: cells per side of a tile with both corner layers counted, 4..9; N = n - 1 */
  uint32_t seeds_min, seeds_max;  /* seeds per cell, 1..20 */
  scree_range alpha, beta, gamma; /* coefficients of the anisotropic distance, > 0, <= 100; a larger one is a thinner rock there */
  scree_range g;                  /* relative size of rocks, > 0, <= 16 */
  scree_orientation orientation;
  double align_axis[3];     /* not zero */
  double align_angle;       /* radians, 0..pi/2 */
  double jitter;            /* share of the cell that a seed may stray over, 0..1 */
  double contact_radius;    /* a: no erosion nearer than this to a contact, 0..0.5 */
  double contact_blend;     /* b: full erosion beyond, > a, <= 1.5 */
  double contact_discard;   /* share of contacts thrown away, 0..1 */
  double erosion;           /* depth of even erosion, 0..0.5 */
  uint32_t erosion_steps;   /* carving steps of smoothing, 0..64 */
  double erosion_strength;  /* lambda of each step, 0..1 */
  uint32_t chisel_planes;   /* random half-spaces per rock, 0..64 */
  double chisel_margin;     /* how far outside the contacts they cut, 0..0.5 */
  double noise;             /* depth of the carved noise, 0..0.5 */
  double noise_frequency;   /* per cell, > 0, <= 16 */
  uint32_t noise_octaves;   /* 1..6 */
  uint32_t voxels_per_cell; /* even, 6..28 */
  uint32_t lod_levels;      /* 1..6 */
  uint32_t lattice_steps;   /* lattice steps per voxel, 2..64 */
  uint32_t hull_vertices;   /* at most so many vertices of the convex hull, 8..64 */
  bool proxies;             /* merged meshes of tiles for far fields, see scree_pack_proxy */
} scree_recipe;

/* Fills `out` with the default boulders. */
SCREE_API void scree_recipe_default(scree_recipe* out);

/* Parses a recipe. Keys that are absent keep their defaults; unknown keys, wrong types and numbers out of range are errors, named
 * in `error` (may be NULL). text: `size` bytes, need not end in NUL. Returns SCREE_OK, SYNTAX, RANGE or OUT_OF_MEMORY. */
SCREE_API scree_result scree_recipe_parse(const char* text, size_t size, scree_recipe* out, scree_error* error);

/* Applies one `KEY=VALUE`, VALUE as in JSON (a word without quotes is taken as a string). assignment: NUL-terminated. On an error
 * the recipe stays as it was. Returns SCREE_OK, SYNTAX, RANGE or OUT_OF_MEMORY; error: may be NULL. */
SCREE_API scree_result scree_recipe_set(scree_recipe* recipe, const char* assignment, scree_error* error);

/* Writes the recipe as JSON with every key, in a fixed order. text: `capacity` bytes, may be NULL when that is 0. Returns the bytes
 * needed without the NUL, like snprintf. */
SCREE_API size_t scree_recipe_write(const scree_recipe* recipe, char* text, size_t capacity);

typedef struct scree_bake_desc {
  const scree_recipe* recipe;
  scree_jobs jobs;
  scree_allocator allocator; /* all zero = malloc and free */
  /* Called between pieces of work, from any worker but never from two at once; `done` in 0..1 never falls. Returns false to cancel.
   * May be NULL. */
  bool (*progress)(void* user, const char* stage, double done);
  void* progress_user;
} scree_bake_desc;

typedef struct scree_bake_stage {
  const char* name; /* static text */
  double seconds;   /* summed over workers for the stages inside rocks, wall clock for the others */
} scree_bake_stage;

typedef struct scree_bake_report {
  uint32_t rocks;     /* or models */
  uint64_t triangles; /* all levels of detail */
  uint64_t lod_triangles[8];
  uint32_t proxies;
  uint64_t proxy_triangles; /* all levels, not among `triangles` */
  uint64_t proxy_bytes;     /* of their meshes */
  uint64_t bytes;           /* of the pack */
  uint64_t contacts;
  uint64_t digest; /* the pack's */
  double seconds;  /* wall clock */
  scree_bake_stage stages[16];
  uint32_t stage_count;
} scree_bake_report;

/* Bakes all unique rocks of a recipe and packs them. The bytes do not depend on jobs, compiler or machine, the Draco blobs' own
 * encoding excepted; the digest depends on nothing but the recipe and the revision.
 * bytes, size: the pack, to be freed with scree_bake_free. report, error: may be NULL.
 * Returns SCREE_OK, RANGE, OUT_OF_MEMORY, UNSUPPORTED (a build without Draco) or CANCELLED. */
SCREE_API scree_result scree_bake_rocks(const scree_bake_desc* desc, uint8_t** bytes, size_t* size, scree_bake_report* report,
                                        scree_error* error);
/* Gives a pack back to the allocator it came from; NULL is allowed. */
SCREE_API void scree_bake_free(const scree_bake_desc* desc, uint8_t* bytes, size_t size);

#ifdef __cplusplus
}
#endif

#endif
