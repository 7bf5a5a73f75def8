/* A scatter: an endless set of points on the ground, at least `spacing` metres apart and so dense that no further point would fit,
 * each with a model, a turn about the vertical and a size: hoodoos of a pack of models, or any assets of the host's own. It is a
 * pure function of its descriptor and the ground: nothing is stored, no order and no box matters.
 *
 * The ground at a point is the highest surface of a support over it. A model stands there upright, sunk until the circle of its
 * footprint touches the ground all round; where the ground under the circle is too steep for that, it does not exist.
 *
 * In a scene a scatter is a layer, as a field of rocks is (scene.h); scree_scatter_fill asks without one. */
#ifndef SCREE_SCATTER_H
#define SCREE_SCATTER_H

#include "scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What the scatter has to know of one model of the host's own. Lengths in metres; its space: the origin on the ground in the middle
 * of the footprint, +Y up. */
typedef struct scree_scatter_model {
  float footprint_radius; /* of the circle that has to stand on the ground, > 0 */
  float height;           /* above the ground, > 0 */
  float outer_radius;     /* of a ball round the origin that holds all of it; 0 = what footprint, height and hull need */
  const float* hull;      /* 3 * hull_count: points of its convex hull; NULL: a prism over the footprint; copied */
  uint32_t hull_count;    /* 4..64 */
} scree_scatter_model;

typedef struct scree_scatter_desc {
  const scree_pack* pack; /* of kind models, not of a cliff, which has to outlive the scatter: model = asset; one that does not
                             touch the ground is fitted by its middle alone; or NULL, and models of the host's own */
  const scree_scatter_model* models;
  uint32_t model_count; /* 1..65536; with a pack 0 */
  uint32_t age_count;   /* of models of the host's own: model = variant * age_count + age, age 0 the youngest; 0 = 1 */
  const float* weights; /* of each model, >= 0, some > 0: how many there are of it; NULL = as many of each; copied */
  /* NULL: weights choose among all models. Otherwise of kind SCREE_FILTER_MASK, copied: the weights of all ages of a variant
   * together choose the variant, and the image its age: 0 = the youngest, 1 = the oldest, with gradual changes between. */
  const scree_filter* age_mask;
  double spacing;             /* metres, > 0: no two points are nearer */
  double origin[3];           /* world place of a corner of the tiles, metres */
  uint64_t seed;              /* of points, tiles and choices */
  float scale_min, scale_max; /* of sizes, 0 < min <= max; both 0 = 1 */
  float max_slope;            /* degrees, > 0 and <= 80; 0 = 45; see scree_scatter_fill */
} scree_scatter_desc;

/* Makes a scatter: fills its tiles (some milliseconds) and copies the models. Immutable, may be shared between threads.
 * error: may be NULL; says what is wrong. Returns SCREE_OK, INVALID_ARGUMENT, RANGE, CORRUPT (of the pack) or OUT_OF_MEMORY. */
SCREE_API scree_result scree_scatter_create(const scree_scatter_desc* desc, const scree_allocator* allocator, scree_scatter** out,
                                            scree_error* error);
/* NULL is allowed. */
SCREE_API void scree_scatter_destroy(scree_scatter* scatter);

/* Models are numbered below this. */
SCREE_API uint32_t scree_scatter_model_count(const scree_scatter* scatter);

/* Width of a tile, metres: about ten times the spacing; of a cliff narrower. The cube of an id is (tile x, floor(y / width), tile
 * z), its local part the number of the point in the tile. */
SCREE_API double scree_scatter_tile_width(const scree_scatter* scatter);

/* What scree_scene_random says of an instance. It depends on tile and point, not on the ground. */
SCREE_API uint32_t scree_scatter_random(const scree_scatter* scatter, const scree_id* id);

/* Turn and size of an instance, from those 32 bits alone, so that a vertex shader can do the same:
 *
 *   float u = float(random >> 16u & 0x3fffu) / 16384.0;
 *   float t = u * (0.7854 + u * u * (0.1615 + u * u * 0.0531)); // near the tangent of an eighth of a turn times u
 *   float c = (1.0 - t * t) / (1.0 + t * t), s = 2.0 * t / (1.0 + t * t);
 *   if ((random >> 30u & 1u) != 0u) { float swapped = c; c = -s; s = swapped; } // a quarter more
 *   if ((random >> 31u & 1u) != 0u) { c = -c; s = -s; }                         // half a turn more
 *   float scale = scale_min + (scale_max - scale_min) * float(random & 0xffffu) / 65535.0;
 *   vec3 place = instance.position + scale * vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x); // p: metres, in the model's space
 *
 * turn: sine and cosine of the angle about +Y. The same bits everywhere. */
SCREE_API void scree_scatter_turn(const scree_scatter* scatter, uint32_t random, float turn[2], float* scale);

/* The points of a convex part of a model, 3 floats each, in its own space: metres, to be turned and scaled. part: 0 is there
 * always; only models of packs have others. Returns SCREE_OK, CAPACITY (the first `capacity` points were written) or
 * INVALID_ARGUMENT (also: no such part). count: how many points, at most 64. */
SCREE_API scree_result scree_scatter_part(const scree_scatter* scatter, uint32_t model, uint32_t part, float* xyz,
                                          uint32_t capacity, uint32_t* count);

/* One instance without a scene. 64 bytes. */
typedef struct scree_placement {
  double position[3]; /* world, metres: where the model's origin goes */
  float turn[2];      /* sine and cosine */
  float scale;
  uint32_t model;
  scree_id id; /* layer 0 */
  uint32_t random;
  uint32_t padding; /* 0 */
} scree_placement;

/* The instances whose position lies in a world box, min <= position < max, on the ground that a support makes; all zero = wherever
 * the support is. The height of the ground is looked for on a lattice of 1/4096 of a tile's width: the highest place of a point's
 * vertical line that is inside the support. Where that differs at any of eight points of the footprint's circle by more than
 * max_slope from that in the middle, there is no instance; otherwise the lowest of the nine is its height. Only ground within that
 * slope of the middle is looked for round the circle: what arches over it higher up does not count.
 * ground: bounded above. placements: `capacity` elements, in no order that is promised. count: how many there are.
 * Returns SCREE_OK, CAPACITY (the first `capacity` were written), INVALID_ARGUMENT or RANGE (a box beyond the int32 tiles, or an
 * unbounded support without a box). Thread-safe; allocates nothing. */
SCREE_API scree_result scree_scatter_fill(const scree_scatter* scatter, const scree_support* ground, const double min[3],
                                          const double max[3], scree_placement* placements, uint64_t capacity, uint64_t* count);

#ifdef __cplusplus
}
#endif

#endif
