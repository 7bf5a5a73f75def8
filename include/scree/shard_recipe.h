/* Shards from recipe to pack: a recipe of what is split and how it weathers in, a pack of what stands and what fell out, all in
 * memory. `scree-bake` is a thin program over these calls.
 *
 * A recipe says which solid is split by which seeds, by which rules frost breaks it, which shards never fall, at which times the
 * result is kept, and where what fell comes to rest. Every number of scree/frost.h can be set; left out, it is the paper's.
 *
 * Lengths in metres, angles in radians, +Y up. Thread safety: calls share nothing but what they are given. */
#ifndef SCREE_SHARD_RECIPE_H
#define SCREE_SHARD_RECIPE_H

#include "bake.h"
#include "frost.h"
#include "hoodoo.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  SCREE_SHARD_LAYERS = 32,   /* of slabs, and points of a resistance by height, at most */
  SCREE_SHARD_POINTS = 1024, /* seeds that a recipe gives itself */
  SCREE_SHARD_REGIONS = 16,  /* that say what shards are at first */
  SCREE_SHARD_PHASES = 16,
  SCREE_SHARD_TIMES = 16
};

/* What is split. All but meshes and terrains stand in the middle of the ground, y = 0. */
typedef enum scree_shard_shape {
  SCREE_SHARD_BOX = 0,     /* of `size`: a wall, a block */
  SCREE_SHARD_HILL = 1,    /* the paper's: a convex dome of `rings` rings of `sides` walls each; one ring with top 1 is a prism */
  SCREE_SHARD_SPHERE = 2,  /* of `radius` */
  SCREE_SHARD_CONE = 3,    /* of `radius` at its foot and `height` */
  SCREE_SHARD_CAPSULE = 4, /* upright, of `radius` and `height` over all */
  SCREE_SHARD_MESH = 5,    /* a closed triangle mesh, `scale` times as large, moved to `position` */
  SCREE_SHARD_TERRAIN = 6, /* a height map, closed by a skirt and a base */
  SCREE_SHARD_HOODOO = 7,  /* a model of a recipe of hoodoos, with what stands of it above and within the ground */
  SCREE_SHARD_SUPPORT = 8  /* whatever the caller of a bake gives */
} scree_shard_shape;

typedef struct scree_shard_input {
  scree_shard_shape shape;
  double size[3];           /* BOX: 0.01..1e5 */
  double radius, height;    /* HILL, SPHERE, CONE, CAPSULE: 0.01..1e5 */
  double top;               /* HILL: radius of its flat top, share of `radius`, 0.01..1 */
  double bulge;             /* HILL: 0 = straight flanks, 1 = round ones */
  uint32_t rings, sides;    /* HILL: 1..16, 3..64 */
  double noise, wavelength; /* BOX, SPHERE, CONE, CAPSULE: displaces the surface by at most so much, 0 = not at all; its lengths */
  uint32_t octaves;         /* of the noise, 1..8 */
  /* What is made of a distance has so many voxels along its longest side, 8..512, 0 = 96: SPHERE, CONE, CAPSULE, SUPPORT, BOX with
   * noise. MESH: 0 = as it is; else made anew, which takes open and crossing ones. */
  uint32_t resolution;
  char file[256];             /* MESH, TERRAIN, HOODOO: relative to the recipe; whoever reads the recipe reads it */
  double scale, position[3];  /* MESH: 1e-6..1e6; within 1e5 */
  double spacing;             /* TERRAIN: between samples */
  double low, high;           /* TERRAIN: heights of black and white */
  uint32_t crop[4];           /* TERRAIN: first column, first row, columns, rows; all zero = the whole picture */
  double base;                /* TERRAIN: height of the level base */
  uint32_t variant, age, lod; /* HOODOO: which of its models, at which level of detail */
} scree_shard_input;

/* scree_seed_pattern by value; scree/shards.h says what its words mean. */
typedef struct scree_shard_seeds {
  scree_seed_kind kind;
  uint32_t count; /* 0 = by spacing; RANDOM: one in each spacing^3 of the volume */
  double spacing, spacing_end, grade[3], jitter, up[3], stretch[3]; /* stretch: all lengths here are before it */
  double length;                                                    /* COLUMNS: joints end up length * stretch[1] apart */
  double layers[SCREE_SHARD_LAYERS];                                /* SLABS */
  uint32_t layer_count;
  double points[SCREE_SHARD_POINTS][3]; /* POINTS */
  uint32_t point_count;
  uint64_t random_seed; /* on top of the recipe's: other shards under the same weather, and the other way round; 0..2^53 */
} scree_shard_seeds;

/* Where a region is. Shards lie in boxes, balls and half-spaces with their centroid. */
typedef enum scree_shard_where {
  SCREE_SHARD_ALL = 0,
  SCREE_SHARD_EXTERIOR = 1,  /* shards with an exterior link */
  SCREE_SHARD_FACING = 2,    /* of these, where the normal of one is within `angle` of `direction` */
  SCREE_SHARD_AT_BASE = 3,   /* with a vertex within `depth` of the solid's lowest place */
  SCREE_SHARD_IN_BOX = 4,    /* of `min` .. `max` */
  SCREE_SHARD_IN_SPHERE = 5, /* of `radius` about `centre` */
  SCREE_SHARD_BEYOND = 6     /* centroid . direction, unit, >= offset */
} scree_shard_where;

/* What shards of a region are at first. Regions go in their order, later ones over earlier ones: exterior, then facing (0, 0, 1) as
 * solid is the paper's cave. */
typedef struct scree_shard_region {
  scree_shard_where where;
  scree_shard_state state;
  double direction[3];   /* FACING, BEYOND: not zero */
  double angle;          /* FACING: 0..pi */
  double offset;         /* BEYOND */
  double depth;          /* AT_BASE: >= 0 */
  double min[3], max[3]; /* IN_BOX */
  double centre[3], radius;
} scree_shard_region;

/* scree_frost_rules by value: `layers` are the resistance's, whose pointers are filled in by scree_shard_rules_view. */
typedef struct scree_shard_rules {
  scree_frost_rules frost;
  double layers[SCREE_SHARD_LAYERS][2]; /* resistance.layer_count of them: place along `up`, value */
} scree_shard_rules;

/* Which of the rules a phase changes. */
enum {
  SCREE_SHARD_RAINS = 1u << 0,
  SCREE_SHARD_WATER = 1u << 1,
  SCREE_SHARD_GRAVITY = 1u << 2,
  SCREE_SHARD_RESISTANCE = 1u << 3,
  SCREE_SHARD_ABSORPTION = 1u << 4, /* the three absorptions and total_absorption */
  SCREE_SHARD_DAMAGE = 1u << 5,
  SCREE_SHARD_BREAKAGE = 1u << 6, /* break_life, break_chance */
  SCREE_SHARD_FALL = 1u << 7,
  SCREE_SHARD_FALL_LIFE = 1u << 8,
  SCREE_SHARD_STABILITY = 1u << 9 /* density, strength, compression, stability_interval */
};

/* Other rules from some moment on; what a phase does not change stays. Phases begin in their order, each when its moment and that
 * of the one before have come. */
typedef struct scree_shard_phase {
  double share;            /* begins when at most this share of the volume stands, 0..1; < 0 = by paths */
  uint32_t paths;          /* begins after so many paths since the start, where share < 0 */
  uint32_t changes;        /* SCREE_SHARD_... */
  scree_shard_rules rules; /* those of `changes` */
} scree_shard_phase;

/* Where what fell comes to rest: scree_rubble_desc by value. */
typedef struct scree_shard_rubble {
  double ground, resolution, repose, min_volume, share, reach;
} scree_shard_rubble;

/* A stack of grey images, for resistances: one picture with `slices` images one below the other, first slice first. Its columns run
 * along x, its rows down along y, its slices along z, through the box from `min` to `max`. */
typedef struct scree_shard_images {
  char file[256];
  uint32_t slices;       /* 1..4096 */
  double min[3], max[3]; /* all zero = the solid's box */
} scree_shard_images;

/* scree_shard_recipe_default fills it with the paper's hill; the JSON keys are the same names, see
 * content/schema/shards.schema.json. */
typedef struct scree_shard_recipe {
  char name[64];
  uint64_t random_seed; /* 0..2^53 */
  scree_shard_input input;
  scree_shard_seeds seeds;
  scree_clip clip;   /* AUTO: walls only where no two triangles share a plane, for packs keep the solid's own */
  double link_angle; /* of scree_shards_desc, > 0 */
  scree_shard_images images;
  scree_shard_rules rules;
  scree_shard_region states[SCREE_SHARD_REGIONS];
  uint32_t state_count;
  scree_shard_phase phases[SCREE_SHARD_PHASES];
  uint32_t phase_count;
  uint32_t paths[SCREE_SHARD_TIMES]; /* the result is kept after so many paths, each more than the one before; 0 = the start */
  double shares[SCREE_SHARD_TIMES];  /* or when at most such a share of the volume stands, each less than the one before, 0..1 */
  uint32_t path_count, share_count;  /* one of them is 0 */
  uint32_t max_paths;                /* a share that is not reached in so many paths is an error, 1..1e9 */
  scree_shard_rubble rubble;
  uint32_t lod_levels;        /* 1..6 */
  uint32_t lattice_per_metre; /* steps of the pack's lattice, 1..4096; 0 = as fine as what is baked allows, at most 1000 */
} scree_shard_recipe;

/* Fills `out` with the paper's hill of 2,908 shards, rain straight down. */
SCREE_API void scree_shard_recipe_default(scree_shard_recipe* out);

/* As scree_hoodoo_parse, scree_hoodoo_set and scree_hoodoo_write; "kind": "shards". */
SCREE_API scree_result scree_shard_recipe_parse(const char* text, size_t size, scree_shard_recipe* out, scree_error* error);
SCREE_API scree_result scree_shard_recipe_set(scree_shard_recipe* recipe, const char* assignment, scree_error* error);
SCREE_API size_t scree_shard_recipe_write(const scree_shard_recipe* recipe, char* text, size_t capacity);

/* What a bake is given. What the recipe does not ask for may be zero. */
typedef struct scree_shard_desc {
  const scree_shard_recipe* recipe;
  const scree_solid* mesh; /* MESH: as in the file; the bake scales and moves it */
  const float* heights;    /* TERRAIN: height_width * height_depth, x fastest then z: metres, cropped */
  uint32_t height_width, height_depth;
  const scree_support* support;    /* SUPPORT */
  const scree_hoodoo_desc* hoodoo; /* HOODOO: its recipe, map, mesh and memory_limit */
  const uint8_t* images;           /* resistance by images: image_size[0] * [1] * [2], x fastest, then y upwards, then z */
  uint32_t image_size[3];
  scree_resistance_fn resistance; /* resistance by function */
  void* resistance_user;
  scree_jobs jobs;
  scree_allocator allocator; /* all zero = malloc and free */
  /* As in scree_bake_desc. May be NULL. */
  bool (*progress)(void* user, const char* stage, double done);
  void* progress_user;
} scree_shard_desc;

/* The steps of a bake, for those who want shards and frost without a pack. */

/* What is split, to be freed with scree_solid_free by the allocator of `desc`. Returns SCREE_OK, RANGE, INVALID_ARGUMENT (a mesh,
 * heights, a support or a hoodoo that was not given), NOT_CLOSED or OUT_OF_MEMORY. */
SCREE_API scree_result scree_shard_solid_make(const scree_shard_desc* desc, scree_solid_memory* out, scree_error* error);

/* The pattern of seeds by reference: `out` points into the recipe. */
SCREE_API void scree_shard_seeds_view(const scree_shard_recipe* recipe, scree_seed_pattern* out);

/* The rules by reference: `out` points into `rules` and at what `desc` gives. */
SCREE_API void scree_shard_rules_view(const scree_shard_desc* desc, const scree_shard_rules* rules, scree_frost_rules* out);

/* What each shard is at first, by the regions. states: as many as there are shards. Returns a bit for each region in which no shard
 * lies, the lowest for the first: a place that is not where the recipe's writer thought. */
SCREE_API uint32_t scree_shard_states(const scree_shard_recipe* recipe, const scree_shards* shards, uint8_t* states);

typedef struct scree_shard_report {
  scree_bake_report bake; /* rocks = assets: what stands at each time, and blocks */
  uint32_t shards, interior_links, exterior_links;
  uint32_t times, blocks, placements; /* blocks that are assets, and how often they lie somewhere */
  uint64_t paths, breaks;
  double share;         /* of the volume that stands at the last time */
  uint32_t idle_states; /* of scree_shard_states: regions of the recipe that say nothing about any shard */
} scree_shard_report;

/* Splits, weathers and packs. The pack is of kind SCREE_PACK_CLIFF: per time what stands, and the blocks that fell with their
 * places. The bytes do not depend on jobs, compiler or machine, the Draco blobs' own encoding excepted. bytes, size: the pack, to
 * be freed with scree_shards_bake_free. report, error: may be NULL. Returns SCREE_OK, RANGE, NOT_CLOSED, INVALID_ARGUMENT (what was
 * not given; a solid that crosses itself; nothing stands at a time), OUT_OF_MEMORY, UNSUPPORTED (a build without Draco) or
 * CANCELLED. */
SCREE_API scree_result scree_shards_bake(const scree_shard_desc* desc, uint8_t** bytes, size_t* size, scree_shard_report* report,
                                         scree_error* error);
/* Gives a pack back to the allocator it came from; NULL is allowed. */
SCREE_API void scree_shards_bake_free(const scree_shard_desc* desc, uint8_t* bytes, size_t size);

#ifdef __cplusplus
}
#endif

#endif
