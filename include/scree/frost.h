/* Freeze and thaw: water runs into the cracks between shards, freezes, and breaks links until groups of shards fall.
 * Source: Mateos et al. 2024, section 5, to the letter where it says something; what it leaves open is said here: stability, and
 * where what fell comes to rest.
 *
 * A path of water starts at an exterior link, chosen with a probability in proportion to area * max(normal . rain, 0), where the
 * rain's direction (towards which one looks to see it come) is drawn anew for each path. From link i it goes on to a neighbour j
 * with a probability in proportion to max(gravity . (x_j - x_i) / |x_j - x_i|, 0) * (1 - life_j * resistance_j), and each link
 * takes water and, while it lives, damage. A link whose life is used up is broken, and where that leaves two parts that no unbroken
 * links join, one falls and is air: the one without core shards where the other has some, else the one of fewer shards, and of
 * equal ones that of the link's second shard; none where both have core. With stability on (strength > 0), and as long as no shard
 * is core, supported shards count as core here, so that what rests does not fall.
 *
 * Nothing floats: when a simulation is created, after each edit, and with the first step after other rules, every component of what
 * stands (shards that unbroken links join) that has no core falls where some have core, or what counts as core. Where none has, all
 * fall but the largest by number of shards, of equal ones that with the lowest shard, and those that rest on the lowest place, as
 * supported shards do: bodies that lie on the ground side by side all stand, until breaks between their own shards part them as
 * above. They fall as blocks of the path that was last, 0 at creation, by their lowest shards. What was the largest and rests
 * nowhere falls, too, once another is larger.
 *
 * Where the paper leaves it open: water runs over broken links as long as they have rock on one side, and these absorb as air;
 * what the random event of total absorption takes harms no link; a breakage is dealt with before water goes on; air joins the
 * outside through faces. A rain whose drawn direction meets no face is drawn again.
 *
 * Everything repeats to the bit on every machine. A simulation may be used by one thread at a time; the shards, which it keeps no
 * copy of, must outlive it and may be shared. */
#ifndef SCREE_FROST_H
#define SCREE_FROST_H

#include "shards.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct scree_frost scree_frost;

enum { SCREE_FROST_RAINS = 4 };

/* One source of water. */
typedef struct scree_rain {
  double direction[3]; /* of flow, need not be unit: (0, -1, 0) falls straight down */
  double spread;       /* half the angle of the cone in which directions are uniform, radians, 0..pi */
  double weight;       /* share of paths, > 0 */
} scree_rain;

/* Resistance of the material, rho of the paper, 0..1 - 2^-20, at `count` places: x, y, z of each. */
typedef void (*scree_resistance_fn)(void* user, const double* places, double* resistance, uint32_t count);

typedef enum scree_resistance_kind {
  SCREE_RESISTANCE_CONSTANT = 0,
  SCREE_RESISTANCE_FUNCTION = 1,
  SCREE_RESISTANCE_NOISE = 2,  /* value + amplitude * gradient noise in octaves */
  SCREE_RESISTANCE_LAYERS = 3, /* by the height along `up`, linear between points */
  SCREE_RESISTANCE_IMAGES = 4  /* a stack of images over a box, trilinear */
} scree_resistance_kind;

/* Values beyond 0..1 - 2^-20 are cut to that. */
typedef struct scree_resistance {
  scree_resistance_kind kind;
  double value;                 /* CONSTANT, NOISE: 0..1 */
  scree_resistance_fn function; /* FUNCTION: called while rules are set, never later */
  void* user;
  double amplitude, period; /* NOISE, on top of LAYERS too: 0..1; lengths */
  uint32_t octaves;         /* NOISE: 1..8; 0 = 1 */
  uint64_t random_seed;     /* NOISE */
  double up[3];             /* LAYERS: all zero = +Y */
  const double* layers;     /* LAYERS: 2 * layer_count: place along `up`, value; rising */
  uint32_t layer_count;
  const uint8_t* images; /* IMAGES: size[0] * size[1] * size[2], x fastest, then y, then z; value / 255 */
  uint32_t size[3];
  double min[3], max[3]; /* IMAGES: the box they fill; all zero = the shards' */
} scree_resistance;

/* What becomes of shards that fall. */
typedef enum scree_fall {
  SCREE_FALL_GONE = 0, /* the paper's: they are air */
  SCREE_FALL_KEPT = 1  /* they are air, and remembered as blocks: see scree_frost_blocks and scree_rubble_create */
} scree_fall;

typedef struct scree_frost_rules {
  scree_rain rains[SCREE_FROST_RAINS];
  uint32_t rain_count;
  double water;      /* w_in of a path, > 0 */
  double gravity[3]; /* direction of flow inside and of weight; need not be unit */
  scree_resistance resistance;
  /* Absorption and damage, in units of the mean link area a: k_solid = solid_absorption / a, k_air = air_absorption / a,
   * k_res = resistance_absorption, k_dmg = damage * a. */
  double solid_absorption, air_absorption, resistance_absorption;
  double damage;
  bool total_absorption;           /* the random event that takes all that is left */
  double break_life, break_chance; /* k_break and the greatest chance of forced breakage */
  scree_fall fall;
  double fall_life; /* links of a falling group with life at most this break, so that it falls in so many blocks:
                       1 = every shard for itself, 0 = in one */
  /* Stability, off where strength is 0. See scree_frost_check_stability for the rule. */
  double density;              /* kg per cubic metre */
  double strength;             /* tensile, of a link of life 1, pascals; 0 = off: the paper's way */
  double compression;          /* compressive strength as a multiple of the tensile one, >= 1 */
  uint32_t stability_interval; /* breakages between checks, >= 1; each step call ends with one too */
} scree_frost_rules;

/* The paper's values, and ours where it has none: one rain straight down with a spread of 0.5, water 1, gravity -Y, resistance 0.5,
 * absorption 0.1, 0.05 and 0.25, damage 0.5, total absorption, break_life 0.4, break_chance 0.9; fall KEPT with fall_life 1;
 * density 2600, strength 0, compression 10, interval 64. */
SCREE_API void scree_frost_rules_default(scree_frost_rules* out);

/* What a shard is. */
typedef enum scree_shard_state { SCREE_SHARD_SOLID = 0, SCREE_SHARD_AIR = 1, SCREE_SHARD_CORE = 2 } scree_shard_state;

typedef struct scree_frost_desc {
  const scree_shards* shards;
  scree_frost_rules rules;
  const uint8_t* states; /* scree_shard_state of each shard; NULL = all solid */
  uint64_t random_seed;
  scree_allocator allocator; /* all zero = malloc and free */
} scree_frost_desc;

/* Returns SCREE_OK, INVALID_ARGUMENT, RANGE (names the rule and the value) or OUT_OF_MEMORY. error: may be NULL. */
SCREE_API scree_result scree_frost_create(const scree_frost_desc* desc, scree_frost** out, scree_error* error);
SCREE_API void scree_frost_destroy(scree_frost* frost); /* NULL is allowed */

/* Other rules from the next path or edit on, before which falls what they do not hold; lives stay. On an error nothing changes. */
SCREE_API scree_result scree_frost_set_rules(scree_frost* frost, const scree_frost_rules* rules, scree_error* error);

/* `count` paths, fewer when no link takes water any more (nothing stands, no rain, or none that meets a face): a sane end, told by
 * the stats. Allocates nothing. Returns SCREE_OK. */
SCREE_API scree_result scree_frost_step(scree_frost* frost, uint64_t count);

/* Paths until at most `share` of the volume at the start stands, or `most` paths are done. progress: as in scree_weather_run, may
 * be NULL. Returns SCREE_OK, RANGE or CANCELLED. */
SCREE_API scree_result scree_frost_run(scree_frost* frost, double share, uint64_t most, bool (*progress)(void* user, double done),
                                       void* user);

/* Edits between steps. A shard made air is gone, not fallen; of the parts that it leaves, those without core fall where others have
 * some, else all but the one of most shards, of equal ones that with the lowest. Air made solid or core stands again, out of the
 * block that it fell in, with the links it has to what stands whole again; where it does not hang together with what holds, it
 * falls at once: build from the core, and give several bodies their core at creation, for with the first core what has none falls.
 * Returns SCREE_OK or INVALID_ARGUMENT. */
SCREE_API scree_result scree_frost_set_shard(scree_frost* frost, uint32_t shard, scree_shard_state state);
/* life: 0..1 of an interior link; 0 breaks it as water would, more needs rock on both sides. Returns as above. */
SCREE_API scree_result scree_frost_set_life(scree_frost* frost, uint32_t link, double life);

typedef struct scree_frost_stats {
  uint64_t paths, links_visited;
  uint64_t breaks;             /* links broken, by damage, by force and by stability */
  uint64_t forced, overloaded; /* of these */
  uint64_t detachments;        /* groups that fell */
  uint32_t solid, core, air;   /* shards */
  uint32_t blocks;             /* fallen and kept */
  uint32_t exterior_links;
  double start_volume, volume;      /* solid and core; the former as given, before what nothing holds fell */
  double poured, absorbed, drained; /* water: poured = absorbed + drained (left over at the ends of paths), to rounding */
  bool dry;                         /* the last step found no link that takes water */
  size_t memory;                    /* bytes held, snapshots apart */
} scree_frost_stats;
SCREE_API void scree_frost_get_stats(const scree_frost* frost, scree_frost_stats* out);

/* The state, valid until the next call that changes it. */
typedef struct scree_frost_view {
  const uint8_t* states;   /* of each shard */
  const double* lives;     /* of each link of the shards; 0 = broken, as all exterior ones */
  const uint8_t* exterior; /* of each link: 1 where it has air that joins the outside on one side and rock on the other */
  uint32_t shard_count, link_count;
} scree_frost_view;
SCREE_API void scree_frost_get(const scree_frost* frost, scree_frost_view* out);
SCREE_API uint64_t scree_frost_digest(const scree_frost* frost); /* of states, lives and exterior; equal for equal states */

/* The last path, for viewers: its first 4096 links at most, in the order that water took. Returns the number of links; links,
 * water: at most `capacity`.
 */
SCREE_API uint32_t scree_frost_last_path(const scree_frost* frost, uint32_t* links, double* water, uint32_t capacity);

/* The rule of stability. Supported are core shards or, without any, shards with a vertex within 1e-6 of the solid's extent along
 * gravity from its lowest place. Let d be a shard's distance from the supported ones in unbroken links. For every d > 0, each group
 * of shards that links join among those at distance >= d hangs on its cut, the links that join it to those at distance d - 1. The
 * cut bears the group's weight W, 9.81 m/s^2 of its mass, at its centre of mass: with A = sum of area * life, c the links' centroid
 * weighted likewise, J their second moments about c, each link's own extent included, and t = J^-1 (moment of W about c), a place x
 * of the cut bears p = W / A + t x (x - c) an area. Its part along the normal of the place's link is tension s, where it pulls;
 * what is left is shear q. The group breaks off where some s + q > strength or -s > compression * strength. Groups are taken from
 * the farthest in, each without those that broke off before. For a plane cut this is the section of a beam: normal force, bending,
 * transverse force and torsion. It assumes: rigid groups on links that give alike and linearly, links that all share the load, no
 * help from friction or from pressure against what is not linked; where nothing is supported, nothing breaks. Returns the number of
 * groups that the rule would break now: 0 after every step with strength on, and where it is off.
 */
SCREE_API uint32_t scree_frost_check_stability(const scree_frost* frost);

/* A copy of the state to come back to, the random stream included; rules are not part of it: under other ones, what they do not
 * hold falls with the next step or edit. Destroy snapshots before the simulation. */
typedef struct scree_frost_snapshot scree_frost_snapshot;
SCREE_API scree_result scree_frost_save(const scree_frost* frost, scree_frost_snapshot** out);
SCREE_API void scree_frost_restore(scree_frost* frost, const scree_frost_snapshot* snapshot);
SCREE_API void scree_frost_forget(scree_frost* frost, scree_frost_snapshot* snapshot); /* NULL is allowed */

/* --- what fell -------------------------------------------------------------------------------------------------------------- */

/* A rigid body of shards that fell together, in the order of falling. For physics: its hull is scree_shards_hull of its shards. */
typedef struct scree_block {
  uint32_t first_shard, shard_count; /* in the array of scree_frost_blocks */
  uint64_t path;                     /* when it fell */
  double centroid[3], volume;        /* where it was */
  double push[3];                    /* unit, out of the rock: the normal of what broke, summed by area; 0 if none */
} scree_block;

/* Blocks first .. as many as there are; `shards` is the list that they index. Valid until the next call that changes the state.
 * Returns how many blocks there are. */
SCREE_API uint32_t scree_frost_blocks(const scree_frost* frost, const scree_block** blocks, const uint32_t** shards);

/* Blocks come to rest, in the order of falling, on what stands now, on the ground and on each other. Each is a rigid body, the hull
 * of its shards: it leaves the rock, rather along its push, drops along gravity, lies down on one of its largest faces, goes down
 * the steepest way while that is steeper than its repose, a little farther by what it fell, never through rock or a roof, and is
 * then turned until its centre of mass is as low as it can be there; what stands on end falls over where there is room. No centre
 * of mass rests higher than it was, but for rounding to columns: a block whose only way out of the rock is up is not there. Larger
 * blocks roll farther. Columns of intervals (dexels) along gravity say what is solid: a block touches what it lies on, and is in
 * others by about a column at most; between columns nothing is known, and what is thinner than a tenth of one is dust. */
typedef struct scree_rubble scree_rubble;

typedef struct scree_rubble_desc {
  const scree_frost* frost;
  double ground;        /* height of the level ground, against gravity; a height map's ground is nowhere lower */
  const float* heights; /* NULL, or of ground around: as scree_solid_from_heights, centred on x = z = 0; made for gravity -Y */
  uint32_t width, depth;
  double spacing;
  double resolution; /* width of a dexel; 0 = a third of the cube root of the mean shard's volume, up to four times as wide where
                        there are too many */
  double repose;     /* tangent of the angle of repose of a heap, 0..100; 0 = 0.7 */
  double min_volume; /* smaller blocks are not kept: dust */
  double share;      /* of blocks that are kept, by a hash; the others are carried away; 0..1, 0 = none is kept */
  double reach;      /* how far from the solid's box blocks may roll, lengths; beyond they are gone; 0 = half its width */
  uint64_t random_seed;
  scree_allocator allocator;
  bool (*progress)(void* user, double done); /* may be NULL */
  void* progress_user;
} scree_rubble_desc;

typedef struct scree_resting_block {
  uint32_t block;        /* of scree_frost_blocks */
  double translation[3]; /* a place p of the block, relative to its centroid, lies at translation + rotation * p */
  double rotation[4];    /* unit quaternion x, y, z, w */
} scree_resting_block;

/* Returns SCREE_OK, RANGE (names the number; a resolution of more than 2^24 columns too), CANCELLED or OUT_OF_MEMORY. error: may be
 * NULL. The simulation is not changed, and not needed afterwards but for its blocks. */
SCREE_API scree_result scree_rubble_create(const scree_rubble_desc* desc, scree_rubble** out, scree_error* error);
SCREE_API void scree_rubble_destroy(scree_rubble* rubble); /* NULL is allowed */
/* Blocks that rest, by number; returns how many. */
SCREE_API uint32_t scree_rubble_get(const scree_rubble* rubble, const scree_resting_block** blocks);

/* --- surface ---------------------------------------------------------------------------------------------------------------- */

/* Triangles of what stands, or of a block: the solid's own where it is untouched, those of links between rock and air where it is
 * cut. Where walls cut the shards (SCREE_CLIP_WALLS), triangles that share a plane are made anew: cut by SCREE_CLIP_MESH to keep
 * them. Edges of cuts are sharp: vertices are not shared across them. */
typedef struct scree_frost_vertex {
  float position[3]; /* of a block: relative to its centroid */
  float normal[3];   /* unit */
  float uv[2];       /* of the solid; of cuts, lengths in the plane of the cut */
  uint32_t shard;
  uint8_t material;   /* 0 = the solid's surface, 2 = a cut */
  uint8_t occlusion;  /* how open the place is, 255 = wide */
  uint8_t padding[2]; /* 0 */
} scree_frost_vertex;

typedef struct scree_frost_surface {
  scree_frost_vertex* vertices; /* owned; scree_frost_surface_free */
  uint32_t* indices;            /* 3 a triangle: the solid's first, those of cuts behind */
  uint32_t vertex_count, solid_triangles, cut_triangles;
  size_t memory;
} scree_frost_surface;

/* block: UINT32_MAX = what stands. Returns SCREE_OK, INVALID_ARGUMENT or OUT_OF_MEMORY. */
SCREE_API scree_result scree_frost_surface_create(const scree_frost* frost, uint32_t block, const scree_allocator* allocator,
                                                  scree_frost_surface* out);
SCREE_API void scree_frost_surface_free(const scree_allocator* allocator, scree_frost_surface* surface);

#ifdef __cplusplus
}
#endif

#endif
