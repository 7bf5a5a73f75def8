/* What rays, overlaps and near rocks have in common: the rocks of a box, and where their hulls lie. */
#ifndef SCREE_SCENE_SPATIAL_H
#define SCREE_SCENE_SPATIAL_H

#include "convex.h"
#include "scene_layers.h"

/* Whose rocks are asked for. */
typedef struct spatial_question {
  const scree_scene* scene;
  const scree_edits* edits;
  scree_scratch* scratch;
  double origin[3]; /* world: where positions are relative to */
} spatial_question;

/* The rocks of one layer of which some part may lie in the world box [low, high]; removed ones are left out; assets of scatters are
 * packed (scene_scatter.h). rocks: in the scratch (SCRATCH_SPATIAL_0), until the next call. */
scree_result scree_rt_spatial_rocks(const spatial_question* q, uint32_t layer, const double low[3], const double high[3],
                                    const scree_rock** rocks, uint64_t* count);

/* A rock's place relative to a world point, metres, from the integers of its cell: the same whoever asks. */
typedef struct spatial_place {
  double home[3];     /* centre of the home cell: hulls are relative to it */
  double centroid[3]; /* of the ball that holds the rock */
  double radius;      /* of that ball, a little larger, for rounding */
} spatial_place;

spatial_place scree_rt_spatial_place(const scene_layer* layer, const scree_rock* rock, const double from[3]);

/* A hull with its coordinates. */
typedef struct spatial_hull {
  float x[CONVEX_MAX_POINTS], y[CONVEX_MAX_POINTS], z[CONVEX_MAX_POINTS];
  convex_hull hull;
} spatial_hull;

/* The hull of an asset, its home cell's centre at `at`. Returns false when it has none. */
bool scree_rt_spatial_hull(const scene_layer* layer, uint32_t asset, const double at[3], spatial_hull* out);

/* The same for each convex part of a rock as scree_rt_spatial_rocks delivers it: one of a field, some of a scatter. */
uint32_t scree_rt_spatial_parts(const scene_layer* layer, const scree_rock* rock);
spatial_place scree_rt_spatial_part(const scene_layer* layer, const scree_rock* rock, uint32_t part, const double from[3]);
bool scree_rt_spatial_part_hull(const scene_layer* layer, const scree_rock* rock, uint32_t part, const double at[3],
                                spatial_hull* out);

/* Makes of such a rock one that is told to others. */
void scree_rt_spatial_unpack(const scene_layer* layer, scree_rock* rock);

/* A list of rocks in the scratch (SCRATCH_SPATIAL_1). Start with all zero. */
typedef struct spatial_list {
  scree_rock* rocks;
  uint64_t count;
} spatial_list;

bool scree_rt_spatial_add(const spatial_question* q, uint32_t layer, spatial_list* list, const scree_rock* rock);

/* Sorts by layer key and id, takes out what is there twice, and delivers. Returns SCREE_OK or CAPACITY. */
scree_result scree_rt_spatial_deliver(spatial_list* list, scree_rock* rocks, uint64_t capacity, uint64_t* count);

#endif
