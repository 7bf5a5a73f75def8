/* Hoodoos: a recipe of weathering in, a pack of models out, all in memory. `scree-bake` is a thin program over these calls.
 *
 * A recipe says what stands at first, by which rules it weathers, and at which ages it is kept: so many variants, which differ by
 * their random seed, each in so many ages. docs/hoodoos.md says in an artist's words what the numbers do.
 *
 * Lengths in voxels, but the width of a voxel, which is in metres; see scree/weather.h for the rules of weathering.
 * Thread safety: calls share nothing but what they are given, so that recipes and bakes that differ may run at the same time. */
#ifndef SCREE_HOODOO_H
#define SCREE_HOODOO_H

#include "bake.h"
#include "support.h"
#include "weather.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  SCREE_HOODOO_POINTS = 32,   /* of a durability graph, at most */
  SCREE_HOODOO_SEGMENTS = 8,  /* of a bubble graph */
  SCREE_HOODOO_PHASES = 24,   /* of a recipe: each change by hand is one */
  SCREE_HOODOO_AGES = 16,     /* of a variant */
  SCREE_HOODOO_VARIANTS = 255 /* of a recipe */
};

/* The shapes of scree_hoodoo_start. */
typedef enum scree_hoodoo_shape {
  SCREE_HOODOO_BOX = 0,       /* of `min` .. `max` */
  SCREE_HOODOO_COLUMN = 1,    /* upright, of `radius` and `height`, with lobes whose places are random */
  SCREE_HOODOO_JOINT_MAP = 2, /* an image seen from above, see SCREE_START_JOINT_MAP */
  SCREE_HOODOO_JOINTS = 3,    /* the box, cut by vertical joints, see SCREE_START_JOINTS */
  SCREE_HOODOO_SPHERE = 4,    /* of `radius` */
  SCREE_HOODOO_CYLINDER = 5,  /* upright, of `radius` and `height` */
  SCREE_HOODOO_CONE = 6,      /* upright, of `radius` at its foot and `height` */
  SCREE_HOODOO_MESH = 7       /* a closed triangle mesh in metres; its origin stands in the middle of the grid's ground */
} scree_hoodoo_shape;

/* What is rock at first. Shapes but boxes and joints stand in the middle of the grid's ground, `lift` above it. */
typedef struct scree_hoodoo_start {
  scree_hoodoo_shape shape;
  uint32_t min[3], max[3];                 /* BOX, JOINTS: voxels min <= v < max; all zero = the whole grid */
  double radius;                           /* COLUMN, SPHERE, CYLINDER, CONE: > 0, <= 4096 */
  double height;                           /* COLUMN, CYLINDER, CONE: 0 = up to the top of the grid, <= 4096 */
  double lift;                             /* SPHERE, CYLINDER, CONE: how far above the ground its lowest point is, 0..4096 */
  double lobes;                            /* COLUMN: how far its outline is from a circle, 0..2 */
  double spacing, gap, warp, missing, low; /* JOINTS: joint_spacing .. joint_low of scree_weather_start */
  char file[256];                          /* JOINT_MAP, MESH: relative to the recipe; whoever reads the recipe reads it */
} scree_hoodoo_start;

/* scree_weather_rules by value. */
typedef struct scree_hoodoo_rules {
  scree_durability_point durability[SCREE_HOODOO_POINTS];
  uint32_t durability_count;
  scree_bubble_segment bubbles[SCREE_HOODOO_SEGMENTS];
  uint32_t bubble_count;
  scree_curve spheroidal, cavernous;
  double exposure, steps_per_voxel;
  double colluvium_share, colluvium_durability, repose;
  scree_rockfall rockfall;
} scree_hoodoo_rules;

/* Which of the rules a phase changes. */
enum {
  SCREE_HOODOO_DURABILITY = 1u << 0,
  SCREE_HOODOO_BUBBLES = 1u << 1,
  SCREE_HOODOO_SPHEROIDAL = 1u << 2,
  SCREE_HOODOO_CAVERNOUS = 1u << 3,
  SCREE_HOODOO_EXPOSURE = 1u << 4,
  SCREE_HOODOO_STEPS_PER_VOXEL = 1u << 5,
  SCREE_HOODOO_COLLUVIUM = 1u << 6, /* colluvium_share, colluvium_durability and repose */
  SCREE_HOODOO_ROCKFALL = 1u << 7
};

/* Other rules from some moment on; what a phase does not change stays. Phases begin in their order, each when its moment and that
 * of the one before have come. */
typedef struct scree_hoodoo_phase {
  double share;             /* begins when at most this share of the rock is left, 0..1; < 0 = by steps */
  uint32_t steps;           /* begins after so many steps since the start, where share < 0 */
  uint32_t changes;         /* SCREE_HOODOO_... */
  scree_hoodoo_rules rules; /* those of `changes` */
} scree_hoodoo_phase;

/* Everything that decides how models look. scree_hoodoo_default fills it with the default goblin; the JSON keys are the same names,
 * see content/schema/hoodoo.schema.json. */
typedef struct scree_hoodoo_recipe {
  char name[64];
  uint64_t random_seed; /* 0..2^53 */
  double voxel;         /* metres, 0.001..100; rounded so that a metre is a whole number of lattice steps */
  uint32_t size[3];     /* voxels of the grid: x, y (up), z; 1..4096 each. Leave room for colluvium around what stands */
  scree_hoodoo_start start;
  scree_hoodoo_rules rules;
  scree_hoodoo_phase phases[SCREE_HOODOO_PHASES];
  uint32_t phase_count;
  uint32_t variants;                     /* 1..255 */
  double ages[SCREE_HOODOO_AGES];        /* shares of the rock that are left at each age, each less than the one before, 0..1 */
  uint32_t age_steps[SCREE_HOODOO_AGES]; /* or steps since the start, each more than the one before */
  uint32_t age_count, age_step_count;    /* one of them is 0 */
  uint32_t max_steps;                    /* an age that is not reached in so many steps is an error, 1..1e6 */
  uint32_t lod_levels;                   /* 1..6 */
  uint32_t lattice_steps;                /* lattice steps per voxel, even, 2..64 */
  bool parts;                            /* convex parts; else the one hull is the only part */
} scree_hoodoo_recipe;

/* Fills `out` with the default goblin. */
SCREE_API void scree_hoodoo_default(scree_hoodoo_recipe* out);

/* Parses a recipe: JSON with "kind": "hoodoo", see content/schema/hoodoo.schema.json. Keys that are absent keep their defaults;
 * unknown keys, wrong types and numbers out of range are errors, named in `error` (may be NULL). text: `size` bytes, need not end
 * in NUL. Returns SCREE_OK, SYNTAX, RANGE or OUT_OF_MEMORY. */
SCREE_API scree_result scree_hoodoo_parse(const char* text, size_t size, scree_hoodoo_recipe* out, scree_error* error);

/* Applies one `KEY=VALUE`, VALUE as in JSON (a word without quotes is taken as a string); `start.radius=40` reaches into an object.
 * assignment: NUL-terminated. On an error the recipe stays as it was. Returns SCREE_OK, SYNTAX, RANGE or OUT_OF_MEMORY; error: may
 * be NULL. */
SCREE_API scree_result scree_hoodoo_set(scree_hoodoo_recipe* recipe, const char* assignment, scree_error* error);

/* Writes the recipe as JSON with every key, in a fixed order. text: `capacity` bytes, may be NULL when that is 0. Returns the bytes
 * needed without the NUL, like snprintf. */
SCREE_API size_t scree_hoodoo_write(const scree_hoodoo_recipe* recipe, char* text, size_t capacity);

/* The rules by reference: `out` points into `rules`. */
SCREE_API void scree_hoodoo_rules_view(const scree_hoodoo_rules* rules, scree_weather_rules* out);

/* What a bake is given. */
typedef struct scree_hoodoo_desc {
  const scree_hoodoo_recipe* recipe;
  const uint8_t* map;            /* JOINT_MAP: map_width * map_depth, x fastest */
  uint32_t map_width, map_depth; /* JOINT_MAP */
  const scree_support* mesh;     /* MESH: that one mesh */
  size_t memory_limit;           /* bytes that all simulations at once may take; 0 = 4 GiB */
  scree_jobs jobs;
  scree_allocator allocator; /* all zero = malloc and free */
  /* Called between pieces of work, from any worker but never from two at once; `done` in 0..1 never falls. Returns false to cancel.
   * May be NULL. */
  bool (*progress)(void* user, const char* stage, double done);
  void* progress_user;
} scree_hoodoo_desc;

/* What the arrays of a start shape lie in. */
typedef struct scree_hoodoo_start_memory {
  void* map;
  size_t map_size;
  scree_support* support;
} scree_hoodoo_start_memory;

/* What one variant stands as before its first step. out: its arrays, if any, are owned by `memory`, which scree_hoodoo_start_free
 * gives back. Returns SCREE_OK, RANGE, INVALID_ARGUMENT (a map or mesh that was not given) or OUT_OF_MEMORY. */
SCREE_API scree_result scree_hoodoo_start_make(const scree_hoodoo_desc* desc, uint32_t variant, scree_weather_start* out,
                                               scree_hoodoo_start_memory* memory, scree_error* error);
SCREE_API void scree_hoodoo_start_free(const scree_hoodoo_desc* desc, scree_hoodoo_start_memory* memory);

/* Weathers all variants through all ages and packs them: asset of variant v and age a is scree_pack_model(pack, v, a). The bytes do
 * not depend on jobs, compiler or machine, the Draco blobs' own encoding excepted; the digest depends on nothing but the recipe,
 * its map or mesh, and the revision. bytes, size: the pack, to be freed with scree_hoodoo_free. report (rocks = models), error: may
 * be NULL. Returns SCREE_OK, RANGE, INVALID_ARGUMENT (no rock at the start, nothing left at an age), OUT_OF_MEMORY, UNSUPPORTED (a
 * build without Draco) or CANCELLED. */
SCREE_API scree_result scree_hoodoo_bake(const scree_hoodoo_desc* desc, uint8_t** bytes, size_t* size, scree_bake_report* report,
                                         scree_error* error);
/* Gives a pack back to the allocator it came from; NULL is allowed. */
SCREE_API void scree_hoodoo_free(const scree_hoodoo_desc* desc, uint8_t* bytes, size_t size);

#ifdef __cplusplus
}
#endif

#endif
