/* A scatter, as the files that answer questions about it see it.
 *
 *   scatter_tiles.c    the points of its tiles
 *   scatter.c          create, destroy; turns, sizes, hulls
 *   scatter_models.c   models, of the host's own or of a pack
 *   scatter_ground.c   where its instances stand: the search for the ground, the choice of models
 *   cliff.c            scatters whose instances are the placements of a pack
 *   scene_scatter.c    layers of scenes that are scatters
 *
 * Scenes and streams see a scatter through its lattice: a field without rocks whose cubes are the tiles, one cell each, as high as
 * they are wide. All places are whole steps of `unit` metres from the origin. */
#ifndef SCREE_SCATTER_INTERNAL_H
#define SCREE_SCATTER_INTERNAL_H

#include <scree/scatter.h>

#include "field_tables.h"
#include "scatter_tiles.h"

enum {
  SCATTER_MOST_MODELS = 65536,
  SCATTER_MOST_LOCALS = 1024 /* locals below this may be asked about */
};

typedef struct scatter_model {
  float footprint; /* radius, metres; all lengths before scaling */
  uint32_t first_part, part_count;
  double weight;
} scatter_model;

typedef struct scatter_part {
  uint32_t first, count; /* points in the arrays */
  float centre[3], radius;
} scatter_part;

/* An instance of a cliff. */
typedef struct cliff_point {
  int64_t steps[3];
  int32_t tile[2]; /* of steps[0] and steps[2] */
  uint32_t asset;
  uint32_t number; /* in the pack */
} cliff_point;

struct scree_scatter {
  scree_allocator allocator;
  scree_field lattice;
  uint8_t place[1][4]; /* of the lattice's only cell */
  scatter_tile tiles[SCATTER_TILES];
  double unit; /* metres a step */
  double origin[3];
  float scale_min, scale_max;
  double slope;              /* tangent of the steepest */
  double outer_radius, sink; /* metres: no instance reaches farther from its place; none is sunk deeper */
  const scree_pack* pack;    /* or NULL */
  scatter_model* models;
  uint32_t* variants; /* variant_count + 1: models of variant v are variants[v] .. variants[v + 1] - 1, the youngest first */
  uint32_t model_count, variant_count;
  scatter_part* parts;
  uint32_t part_count;
  float *x, *y, *z; /* point_count each, metres */
  uint32_t point_count;
  bool masked;
  scree_filter age_mask; /* values: `samples` */
  float* samples;
  size_t sample_count;
  /* Of cliffs only: */
  bool is_cliff;
  cliff_point* points; /* point k of a tile is its local k; by tile z, tile x, and then as in the pack */
  uint32_t cliff_count;
  uint32_t turn_bits;    /* of scree_scatter_random */
  scree_support* ground; /* a box around all instances */
};

/* What a scatter takes from its descriptor or pack: models, variants, parts and points. Nothing is left behind on failure but what
 * scree_rt_scatter_drop_models releases. */
scree_result scree_rt_scatter_copy_models(scree_scatter* scatter, const scree_scatter_desc* desc, scree_error* error);
void scree_rt_scatter_drop_models(scree_scatter* scatter);

/* What follows from unit, scales, slope and models; the last step of making a scatter. */
void scree_rt_scatter_finish(scree_scatter* scatter);

/* --- instances -------------------------------------------------------------------------------------------------------------- */

/* What a question keeps of an instance in scree_instance.asset: the model, and the step of its height in its cube. */
static inline uint32_t scatter_pack(uint32_t model, int64_t level) {
  return model | (uint32_t)(level & (SCATTER_SIDE - 1)) << 16;
}
static inline uint32_t scatter_model_of(uint32_t packed) {
  return packed & 0xffff;
}
static inline int64_t scatter_level_of(const scree_id* id, uint32_t packed) {
  return (int64_t)id->cube[1] * SCATTER_SIDE + (packed >> 16);
}

/* The tile code of a cube, and the hash of a point. */
uint32_t scree_rt_scatter_code(const scree_scatter* scatter, int32_t x, int32_t z);
uint64_t scree_rt_scatter_hash(const scree_scatter* scatter, int32_t x, int32_t z, uint32_t local);

/* Steps of a point from the scatter's origin along x and z; false when the tile has no such point. */
bool scree_rt_scatter_steps(const scree_scatter* scatter, int32_t x, int32_t z, uint32_t local, int64_t steps[2]);

/* An instance's place relative to the scatter's origin, metres. */
void scree_rt_scatter_place(const scree_scatter* scatter, const scree_id* id, uint32_t packed, double place[3]);

/* A part of a model, turned but not scaled: its points, and the ball that holds it. x, y, z: CONVEX_MAX_POINTS each. Returns how
 * many points. */
uint32_t scree_rt_scatter_hull(const scree_scatter* scatter, uint32_t part, uint32_t random, float* x, float* y, float* z,
                               float* scale);
/* Centre relative to the instance's place, metres; returns the radius. */
double scree_rt_scatter_ball(const scree_scatter* scatter, uint32_t part, uint32_t random, double centre[3]);

/* The model at a point, by weights, ages and its hash; steps as above. */
uint32_t scree_rt_scatter_choose(const scree_scatter* scatter, uint64_t hash, const int64_t steps[2]);

/* Of a cliff: the instance with this number in its tile, NULL where there is none; and scree_rt_scatter_visit. */
const cliff_point* scree_rt_cliff_point(const scree_scatter* cliff, int32_t x, int32_t z, uint32_t local);
struct scatter_visit;
struct scatter_found;
bool scree_rt_cliff_visit(const struct scatter_visit* visit, bool (*found)(void* user, const struct scatter_found* instance),
                          void* user);

/* --- the ground ------------------------------------------------------------------------------------------------------------- */

struct scene_layer;

typedef struct scatter_visit {
  const scree_scatter* scatter;
  const scree_support* ground;     /* bounded above */
  const struct scene_layer* layer; /* whose filters thin it out, or NULL */
  int64_t low[3], high[3];         /* cubes: low <= c < high, within int32 */
  double box_low[2], box_high[2];  /* x and z relative to the scatter's origin: points outside are left out */
} scatter_visit;

/* An instance that exists. */
typedef struct scatter_found {
  int32_t tile[2];
  uint32_t local, model;
  int64_t steps[3];
} scatter_found;

/* Whether the layer's filters let an instance exist. planar: those that need a height are left out. */
bool scree_rt_scatter_passes(const scatter_visit* visit, const scatter_found* found, bool planar);

/* Calls `found` for every instance, in a fixed order; stops, and returns false, when it does. */
bool scree_rt_scatter_visit(const scatter_visit* visit, bool (*found)(void* user, const scatter_found* instance), void* user);

/* What is wrong with a descriptor, as the text and the code of a failed create. */
scree_result scree_rt_scatter_wrong(scree_result code, const char* what, scree_error* error);
scree_result scree_rt_scatter_wrong_number(const char* name, double value, const char* range, scree_error* error); /* RANGE */

#endif
