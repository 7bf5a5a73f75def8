/* A scene: an ordered list of layers, each a field of rock in a support or a scatter of models on one, with rules for which of its
 * rocks exist; and what can be asked of it: the rocks of a box, one rock by its id, rays, overlaps, hulls for a physics engine. All
 * of it is a pure function of the scene and the edits: no order of visits, no block, no thread matters.
 *
 * "Rock" also means an instance of a scatter (scatter.h) from here on. Its hulls are the convex parts of its model, turned and
 * scaled; its position is where it stands, and boxes that ask for the centres of home cells ask for that.
 *
 * Where layers overlap, the earlier wins: a rock of a later layer whose hull meets the hull of a kept rock of an earlier one is
 * dropped; only what stands of a cliff (cliff.h) is not. "Kept" looks at supports, filters and earlier layers only, never at edits,
 * so that an edit changes no rock but its own.
 *
 * A scene keeps pointers to its fields, scatters and supports, which must outlive it; filters are copied. It is immutable and may
 * be shared between threads. To change a scene, make another (it costs microseconds) and hand that to the streams. */
#ifndef SCREE_SCENE_H
#define SCREE_SCENE_H

#include "edits.h"
#include "field.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct scree_scene scree_scene;
typedef struct scree_scatter scree_scatter; /* scatter.h */

/* Scratch memory of queries, one for each thread that asks. It grows to what the largest question so far needed and stays so: in a
 * steady state nothing allocates. */
typedef struct scree_scratch scree_scratch;
SCREE_API scree_result scree_scratch_create(const scree_allocator* allocator, scree_scratch** out);
SCREE_API void scree_scratch_destroy(scree_scratch* scratch);

/* How dense a layer is from place to place: each filter gives a share 0..1, their product is the chance that a rock exists. A rock
 * exists or not by its world hash, so thinning out a layer never moves a rock. */
typedef enum scree_filter_kind {
  SCREE_FILTER_MASK = 0,    /* an image seen from above */
  SCREE_FILTER_SLOPE = 1,   /* of a terrain, degrees from level */
  SCREE_FILTER_ALTITUDE = 2 /* world height y, metres */
} scree_filter_kind;

typedef struct scree_filter {
  scree_filter_kind kind;
  bool inverted;         /* 1 - share */
  float from, to;        /* SLOPE, ALTITUDE: share 1 in [from, to], from <= to */
  float fade;            /* SLOPE, ALTITUDE: falls to 0 over this much on both sides, >= 0 */
  const float* values;   /* MASK: shares 0..1; SLOPE: heights in metres; width * depth, x fastest then z; copied */
  uint32_t width, depth; /* samples, each >= 2; bilinear between them; beyond the border the nearest sample counts */
  float spacing;         /* metres between samples, > 0 */
  double centre[3];      /* world place of the image's centre; y is not used */
} scree_filter;

typedef struct scree_layer {
  const scree_field* field;     /* rocks; or NULL, and */
  const scree_scatter* scatter; /* models on the ground that the support makes, which has to end somewhere above */
  const scree_support*
      support;       /* NULL where the scatter is a cliff (cliff.h), and only there; scree_scene_layer then shows a box */
  uint16_t key;      /* goes into ids; unique in the scene. All zero in all layers = the layer's index */
  float threshold;   /* as in scree_query_desc; of a scatter 0 */
  float shell_depth; /* metres, > 0: rocks deeper below the surface do not exist; 0 = they do; of a scatter 0 */
  float density;     /* 0 = 1; a share 0..1 on top of the filters */
  const scree_filter* filters;
  uint32_t filter_count; /* at most 16 */
} scree_layer;

typedef struct scree_scene_desc {
  const scree_layer* layers;
  uint32_t layer_count; /* 1..64 */
} scree_scene_desc;

/* Returns SCREE_OK, INVALID_ARGUMENT, RANGE or OUT_OF_MEMORY; error (may be NULL) names the layer, the filter and the value. */
SCREE_API scree_result scree_scene_create(const scree_scene_desc* desc, const scree_allocator* allocator, scree_scene** out,
                                          scree_error* error);
SCREE_API void scree_scene_destroy(scree_scene* scene);

/* The world box that holds all supports; infinite where one is unbounded. */
SCREE_API void scree_scene_bounds(const scree_scene* scene, double min[3], double max[3]);

/* One rock of a scene. 32 bytes. */
typedef struct scree_rock {
  float position[3]; /* of the home cell's centre, metres, relative to the question's origin; meshes are relative to this point */
  uint32_t asset;    /* of the layer's pack; the model of a scatter, whose turn and size scree_scatter_turn says */
  scree_id id;
} scree_rock;

enum {
  SCREE_SCENE_VISIBLE = 1u << 0, /* leave out what nobody can see: rocks hidden by hide, and rocks that their neighbours hide, as
                                    far as the bake's sample of lines of sight tells (scree_asset.burial) */
};

typedef struct scree_scene_query_desc {
  const scree_scene* scene;
  const scree_edits* edits; /* or NULL */
  double origin[3];         /* positions are delivered relative to this world point, metres */
  double min[3], max[3];    /* world box of home cells' centres, min <= c < max; all zero = wherever the supports are */
  uint32_t flags;           /* SCREE_SCENE_... */
  uint64_t layers;          /* bit i: layer i is asked for; 0 = all */
} scree_scene_query_desc;

/* Counts and fills, as scree_query_count and scree_query_fill; rocks come layer by layer. Removed rocks are never delivered, hidden
 * ones unless SCREE_SCENE_VISIBLE is set.
 * Returns SCREE_OK, CAPACITY, INVALID_ARGUMENT, RANGE (a box beyond the int32 cubes, or an unbounded support without a box) or
 * OUT_OF_MEMORY (of the scratch). Thread-safe, with one scratch a thread. */
SCREE_API scree_result scree_scene_count(const scree_scene_query_desc* desc, scree_scratch* scratch, uint64_t* count);
SCREE_API scree_result scree_scene_fill(const scree_scene_query_desc* desc, scree_scratch* scratch, scree_rock* rocks,
                                        uint64_t capacity, uint64_t* count);

/* Why a rock is there or not. */
typedef enum scree_rock_state {
  SCREE_ROCK_EXISTS = 0,
  SCREE_ROCK_REMOVED = 1, /* by an edit */
  SCREE_ROCK_HIDDEN = 2,  /* by an edit: not drawn, but there for rays, overlaps and hulls */
  SCREE_ROCK_OUTSIDE = 3, /* the support, the shell or a filter leaves it out */
  SCREE_ROCK_DROPPED = 4, /* it meets a rock of an earlier layer */
  SCREE_ROCK_UNKNOWN = 5  /* no such layer, or no such rock in the tile that stands there */
} scree_rock_state;

/* One rock by its id. rock: filled unless the state is UNKNOWN; may be NULL; of an instance of a scatter that is OUTSIDE, the
 * height is that of the middle of its cube. origin: as above. Returns SCREE_OK (also when the rock is not there), INVALID_ARGUMENT
 * or OUT_OF_MEMORY. */
SCREE_API scree_result scree_scene_find(const scree_scene* scene, const scree_edits* edits, scree_scratch* scratch,
                                        const scree_id* id, const double origin[3], scree_rock* rock, scree_rock_state* state);

/* What a layer is made of. index: 0..layer_count - 1. */
SCREE_API uint32_t scree_scene_layer_count(const scree_scene* scene);
SCREE_API const scree_layer* scree_scene_layer(const scree_scene* scene, uint32_t index); /* filters: the scene's own copies */
/* The layer with this key, or UINT32_MAX. */
SCREE_API uint32_t scree_scene_layer_of(const scree_scene* scene, uint16_t key);

/* A value for colour and wetness: see scree_world_hash. */
SCREE_API uint32_t scree_scene_random(const scree_scene* scene, const scree_id* id);

typedef struct scree_hit {
  scree_rock rock;
  double distance; /* along the ray, metres */
  float point[3];  /* relative to the ray's start, metres */
  float normal[3]; /* unit, of the hull's face, out of the rock; where the ray starts inside, against its direction */
} scree_hit;

/* The first hull that a ray meets, from the outside or, when it starts inside, at distance 0; of two at one distance, that with the
 * lesser layer key and id. start: world, metres; positions are relative to it. direction: any length > 0. reach: metres, > 0 and
 * finite. Costs microseconds where supports are solid; through a kilometre of thinly strewn rocks, some for each metre.
 * hit: delivered when *found. Returns SCREE_OK, INVALID_ARGUMENT, RANGE or OUT_OF_MEMORY. */
SCREE_API scree_result scree_scene_ray_cast(const scree_scene* scene, const scree_edits* edits, scree_scratch* scratch,
                                            const double start[3], const double direction[3], double reach, bool* found,
                                            scree_hit* hit);

/* The convex hull of some points, grown by a radius: one point is a ball, two a capsule, eight a box. */
typedef struct scree_convex {
  double origin[3];     /* world */
  const float* points;  /* 3 * point_count, metres, relative to the origin */
  uint32_t point_count; /* 1..64 */
  float radius;         /* metres, >= 0 */
} scree_convex;

/* Rocks whose hull meets a convex shape, ordered by layer key and id; touching is meeting. rocks: as in scree_scene_fill, positions
 * relative to the shape's origin; where they do not fit, the first ones. Returns what scree_scene_fill returns. */
SCREE_API scree_result scree_scene_overlap(const scree_scene* scene, const scree_edits* edits, scree_scratch* scratch,
                                           const scree_convex* shape, scree_rock* rocks, uint64_t capacity, uint64_t* count);

/* Rocks for a physics engine: those whose hull comes within `radius` metres of any of some world points (3 * point_count), each
 * once, ordered by layer key and id; positions relative to `origin`. Their hulls: scree_scene_hull. Returns as scree_scene_fill. */
SCREE_API scree_result scree_scene_near(const scree_scene* scene, const scree_edits* edits, scree_scratch* scratch,
                                        const double* points, uint32_t point_count, double radius, const double origin[3],
                                        scree_rock* rocks, uint64_t capacity, uint64_t* count);

/* The hull of a rock's asset in metres relative to the rock's position: 3 floats a vertex; the same for all rocks of one layer and
 * asset, so hosts keep one shape for each. Of a scatter, the first part of a model, to be turned and scaled; all of them:
 * scree_scatter_part. layer: index. Returns as scree_pack_get_hull. */
SCREE_API scree_result scree_scene_hull(const scree_scene* scene, uint32_t layer, uint32_t asset, float* xyz, uint32_t capacity,
                                        uint32_t* count);

#ifdef __cplusplus
}
#endif

#endif
