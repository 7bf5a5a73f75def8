/* Directable weathering of rock on a grid of voxels: hoodoos, goblins, honeycombs. All in memory; `scree-bake` turns the result
 * into packs. Sources: Beardall et al. 2007, "Goblins by Spheroidal Weathering"; Jones et al. 2010, "Directable Weathering of
 * Concave Rock Using Curvature Estimation".
 *
 *   a voxel of rock or colluvium that touches air on one of its six faces weathers: each step takes
 *       rate = (spheroidal(c) + cavernous(1 - c)) * k^exposure / durability      of its life, which is 1 at first,
 *   with c the share of air among the voxels of a bubble centred on it and k its exposed faces, 1..6: see scree_curve_kind. All
 * voxels whose life is used up vanish together at the end of the step; some of them become colluvium, which slides to its angle of
 * repose; what hangs in the air falls.
 *
 * Lengths are in voxels, the grid's axes are x, y (up) and z, altitudes are shares of the grid's height: 0 = bottom, 1 = top.
 * Outside the grid is air, but below it is ground, which is solid and never weathers.
 *
 * Everything repeats to the bit on every machine and with any number of threads. A simulation may be used by one thread at a time;
 * different ones share nothing. */
#ifndef SCREE_WEATHER_H
#define SCREE_WEATHER_H

#include "base.h"
#include "support.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct scree_weather scree_weather;

/* --- rules: what an artist changes, also between steps ---------------------------------------------------------------------- */

/* One point of the durability graph: durability is linear between points, that of the nearest point beyond them. The noise of the
 * segment from this point up to the next multiplies durability by 1 + amplitude * noise, where noise is two octaves of Perlin's
 * gradient noise, clamped to -1..1; never below 1/16 of the graph. The noise is kept in steps of 1/127. */
typedef struct scree_durability_point {
  double altitude;        /* 0..1, not below that of the point before */
  double durability;      /* > 0, <= 1e6; 1 = the rock that steps_per_voxel speaks of */
  double noise_amplitude; /* 0..4 */
  double noise_period;    /* voxels, 1..1e6; 0 = 16 */
  double noise_squash;    /* 0.1..100: how much shorter the period is along y, for beds; 0 = 1 */
} scree_durability_point;

typedef enum scree_bubble_kind {
  SCREE_BUBBLE_SPHERE = 0,    /* all voxels at most `radius` away */
  SCREE_BUBBLE_ELLIPSOID = 1, /* radius along x and z, `height` along y */
  SCREE_BUBBLE_GUMDROP = 2,   /* a sphere cut flat at y = -radius / 2 */
  SCREE_BUBBLE_DISC = 3       /* x and z within the radius, |y| <= 1 */
} scree_bubble_kind;

typedef struct scree_bubble {
  scree_bubble_kind kind;
  double radius; /* 1..12, at most the longest side of the grid */
  double height; /* ELLIPSOID: as radius; otherwise not looked at */
} scree_bubble;

/* One segment of the bubble graph, from its altitude up to that of the next: which bubble its voxels look through. Of a mixture
 * each voxel has one, by the value of smooth noise there: equal shares of the noise's range. */
typedef struct scree_bubble_segment {
  double altitude; /* 0..1; the first segment's counts as 0; rising */
  scree_bubble bubbles[4];
  uint32_t bubble_count; /* 1..4 */
  double noise_period;   /* voxels, of a mixture; 0 = 16 */
} scree_bubble_segment;

/* f of the papers, and what it takes of the life of a voxel of durability 1 in a step. x is c for the spheroidal term, 1 - c for
 * the cavernous one; x_flat is that of a voxel in a level plain, for its bubble. The first three take gain * f(x) / f(x_flat) /
 * steps_per_voxel: with gain 1, a level plain loses a voxel in steps_per_voxel steps. SATURATING takes gain * f(x). */
typedef enum scree_curve_kind {
  SCREE_CURVE_NONE = 0,      /* 0 */
  SCREE_CURVE_LINEAR = 1,    /* x */
  SCREE_CURVE_CUBIC = 2,     /* 3 x^3 */
  SCREE_CURVE_QUARTIC = 3,   /* 3 x^4 */
  SCREE_CURVE_SATURATING = 4 /* clamp((x - x_flat - threshold) / saturation, 0, 1) ^ power */
} scree_curve_kind;

typedef struct scree_curve {
  scree_curve_kind kind;
  double gain;       /* 0..1e3 */
  double threshold;  /* SATURATING: -1..1 */
  double saturation; /* SATURATING: > 0, <= 2 */
  uint32_t power;    /* SATURATING: 1..4 */
} scree_curve;

typedef enum scree_rockfall {
  SCREE_ROCKFALL_NONE = 0,
  SCREE_ROCKFALL_DROP = 1,     /* what has no path of faces through rock and colluvium to the ground is gone */
  SCREE_ROCKFALL_COLLUVIUM = 2 /* rock becomes colluvium, as removed voxels do; colluvium slides and falls again */
} scree_rockfall;

typedef struct scree_weather_rules {
  const scree_durability_point* durability; /* at least 1; copied */
  uint32_t durability_count;                /* 1..256 */
  const scree_bubble_segment* bubbles;      /* at least 1; copied */
  uint32_t bubble_count;                    /* 1..64 */
  scree_curve spheroidal, cavernous;
  double exposure;             /* e, 0..2: the rate is multiplied by k^e; 0 = the papers' rule, 0.6 makes a cube a sphere */
  double steps_per_voxel;      /* L, 1..1e4: see scree_curve_kind */
  double colluvium_share;      /* of removed voxels of rock that become colluvium, 0..1; by a hash of the place and the step */
  double colluvium_durability; /* of colluvium, as a share of the durability graph, noise apart, where it lies; > 0, <= 1e6 */
  double repose;               /* tangent of the angle of repose, 1/16..4; slopes come out within 6 % of it */
  scree_rockfall rockfall;
} scree_weather_rules;

/* 3 c^3 with a sphere of radius 4, durability 1 without noise, 12 steps a voxel, exposure 0.6, 20 % colluvium of durability 0.35 at
 * 35 degrees, rockfall to colluvium. The graphs point to static storage. */
SCREE_API void scree_weather_rules_default(scree_weather_rules* out);

/* --- start shapes ----------------------------------------------------------------------------------------------------------- */

typedef enum scree_start_kind {
  SCREE_START_BOX = 0,       /* all of `box` */
  SCREE_START_JOINT_MAP = 1, /* an image seen from above: 0 = no rock, otherwise a column of value / 255 of the grid's height */
  SCREE_START_SUPPORT = 2,   /* voxels whose centre lies in a support: any shape, any closed mesh */
  SCREE_START_JOINTS = 3     /* all of `box`, cut by vertical joints: the borders of a 2D Voronoi diagram, warped by noise */
} scree_start_kind;

typedef struct scree_weather_start {
  scree_start_kind kind;
  uint32_t size[3];                /* voxels of the grid: x, y (up), z; 1..4096 each */
  uint32_t box_min[3], box_max[3]; /* BOX, JOINTS: voxels min <= v < max; all zero = the whole grid */
  const uint8_t* map;              /* JOINT_MAP: map_width * map_depth, x fastest, stretched over the grid without smoothing */
  uint32_t map_width, map_depth;
  const scree_support* support; /* SUPPORT */
  double voxel;                 /* SUPPORT: width of a voxel in metres, > 0 */
  double origin[3];             /* SUPPORT: world place of the grid's corner (0, 0, 0), metres */
  double joint_spacing;         /* JOINTS: voxels between the middles of blocks, >= 4 */
  double joint_gap;             /* JOINTS: no rock where F2 - F1 is below this share of the spacing, 0..0.5 */
  double joint_warp;            /* JOINTS: how far the noise moves the joints, as a share of the spacing, 0..1 */
  double joint_missing;         /* JOINTS: share of blocks that are not there, 0..1 */
  double joint_low;             /* JOINTS: blocks are this share of the box's height at least, random up to 1; 0..1 */
  uint64_t seed;                /* of all randomness of this simulation: joints, noise, colluvium */
} scree_weather_start;

typedef struct scree_weather_desc {
  scree_weather_start start;
  scree_weather_rules rules;
  size_t memory_limit;       /* bytes; 0 = 4 GiB. A grid that needs more is refused before anything is allocated */
  scree_jobs jobs;           /* used by every call with this simulation */
  scree_allocator allocator; /* all zero = malloc and free */
} scree_weather_desc;

/* Bytes that a simulation of these sizes needs, 0 for a wrong descriptor. */
SCREE_API uint64_t scree_weather_memory(const scree_weather_desc* desc);

/* Returns SCREE_OK, INVALID_ARGUMENT (no rock at all), RANGE (names the field and the value: NaN, a graph out of order, a radius
 * larger than the grid, more memory than memory_limit, with the size) or OUT_OF_MEMORY. */
SCREE_API scree_result scree_weather_create(const scree_weather_desc* desc, scree_weather** out, scree_error* error);
SCREE_API void scree_weather_destroy(scree_weather* weather); /* NULL is allowed */

/* Other rules from the next step on; the share of its life that each voxel has left stays. On an error nothing changes. */
SCREE_API scree_result scree_weather_set_rules(scree_weather* weather, const scree_weather_rules* rules, scree_error* error);

/* --- steps ------------------------------------------------------------------------------------------------------------------ */

/* `count` steps, fewer when nothing is left. Lives are kept to 2^-30: what a step takes is rounded down to that. Allocates nothing.
 * Returns SCREE_OK. */
SCREE_API scree_result scree_weather_step(scree_weather* weather, uint32_t count);

/* Steps until at most `share` of the volume of the start is left as rock, or until `most` steps are done; progress: as in
 * scree_bake_desc, may be NULL. Returns SCREE_OK, RANGE, CANCELLED or OUT_OF_MEMORY. */
SCREE_API scree_result scree_weather_run(scree_weather* weather, double share, uint32_t most,
                                         bool (*progress)(void* user, double done), void* user);

typedef struct scree_weather_stats {
  uint64_t step;            /* steps since the start */
  uint64_t start_rock;      /* voxels of rock at the start */
  uint64_t rock, colluvium; /* voxels */
  uint64_t active;          /* voxels that touch air */
  uint64_t removed;         /* by the last step: rock and colluvium */
  uint64_t fallen;          /* by rockfall, in the last step */
  size_t memory;            /* bytes held, snapshots apart */
} scree_weather_stats;
SCREE_API void scree_weather_get_stats(const scree_weather* weather, scree_weather_stats* out);

/* Radius of each layer of voxels, sqrt(rock voxels / pi). radii: size[1] values. */
SCREE_API void scree_weather_radii(const scree_weather* weather, double* radii);

/* What stands in a voxel. */
typedef enum scree_voxel { SCREE_VOXEL_AIR = 0, SCREE_VOXEL_ROCK = 1, SCREE_VOXEL_COLLUVIUM = 2 } scree_voxel;
SCREE_API void scree_weather_size(const scree_weather* weather, uint32_t size[3]);
/* All voxels, x fastest, then y, then z. voxels: size[0] * size[1] * size[2] bytes. */
SCREE_API void scree_weather_voxels(const scree_weather* weather, uint8_t* voxels);
/* Names the set of voxels and their lives: equal for equal states. */
SCREE_API uint64_t scree_weather_digest(const scree_weather* weather);

/* A copy of the state to come back to; rules are not part of it. Destroy snapshots before the simulation. */
typedef struct scree_weather_snapshot scree_weather_snapshot;
SCREE_API scree_result scree_weather_save(const scree_weather* weather, scree_weather_snapshot** out);
SCREE_API void scree_weather_restore(scree_weather* weather, const scree_weather_snapshot* snapshot);
SCREE_API void scree_weather_forget(scree_weather* weather, scree_weather_snapshot* snapshot); /* NULL is allowed */

/* --- surface ---------------------------------------------------------------------------------------------------------------- */

/* A vertex of the surface; lengths in voxels from the grid's corner (0, 0, 0). */
typedef struct scree_surface_vertex {
  float position[3];
  float normal[3];    /* unit, outward */
  float durability;   /* of the voxel beneath, noise included */
  float curvature;    /* 2 c - 1 over its bubble, in -1..1: about 0 = level, > 0 = edges and tips, < 0 = hollows */
  float occlusion;    /* how open the place is: 1 = as a plain, 0 = at the end of a hole */
  uint8_t material;   /* 0 = rock, 1 = colluvium; a vertex on their border is colluvium */
  uint8_t layer;      /* segment of the durability graph, 0 = below the first point; 255 at most */
  uint8_t padding[2]; /* 0 */
} scree_surface_vertex;

/* A closed, manifold mesh: the triangles of rock first, those of colluvium behind; they share the vertices of their border. It is
 * closed along the ground too. Counter-clockwise seen from outside. */
typedef struct scree_surface {
  const scree_surface_vertex* vertices;
  const uint32_t* indices; /* 3 a triangle */
  uint32_t vertex_count, rock_triangles, colluvium_triangles;
} scree_surface;

/* A mesher keeps what it made, so that the next call only makes anew what steps have changed since. */
typedef struct scree_mesher scree_mesher;
SCREE_API scree_result scree_mesher_create(const scree_weather* weather, scree_mesher** out);
SCREE_API void scree_mesher_destroy(scree_mesher* mesher); /* NULL is allowed; before the simulation is destroyed */
/* surface: valid until the next call with this mesher. level: 0 = a vertex for each voxel of the surface; each level more halves
 * the grid, 0..5. Returns SCREE_OK, INVALID_ARGUMENT or OUT_OF_MEMORY. */
SCREE_API scree_result scree_mesher_update(scree_mesher* mesher, uint32_t level, scree_surface* surface);

#ifdef __cplusplus
}
#endif

#endif
