/* Layers of scenes that are scatters: what they do otherwise than fields of rock. Inside a question an instance is an id and a
 * scree_instance as a rock is; its asset is packed, see scatter_pack. */
#ifndef SCREE_SCENE_SCATTER_H
#define SCREE_SCENE_SCATTER_H

#include "convex.h"
#include "scatter_internal.h"
#include "scene_layers.h"

/* Whether a ground can be used: it has to end somewhere above. */
bool scree_rt_scene_ground_ends(const scree_support* ground);

/* What scree_rt_scene_measure cannot tell from the lattice alone. */
void scree_rt_scene_measure_scatter(scene_layer* layer);

/* Finds the instances of a layer in the cubes where it is needed, behind the rocks that are there already. */
scree_result scree_rt_scene_find_scatter(scene_question* q, uint32_t layer);

/* The box of the balls round them. */
void scree_rt_scene_scatter_box(scene_question* q, uint32_t layer);

/* Whether an instance lies in the box that is asked for. */
bool scree_rt_scene_scatter_asked(const scene_question* q, const scene_layer* layer, const scree_id* id, uint32_t packed);

/* An instance as far as it can be told without the ground; with `packed`, all of it. Returns false when the tile that stands there
 * has no such point. */
bool scree_rt_scene_scatter_rock(const scene_layer* layer, const scree_id* id, const uint32_t* packed, const double origin[3],
                                 scree_rock* rock);

/* A convex part of an instance, 0 .. parts - 1. */
static inline uint32_t scatter_parts(const scene_layer* layer, uint32_t packed) {
  return layer->given.scatter->models[scatter_model_of(packed)].part_count;
}
/* Relative to a world point: the instance's place, and the ball that holds the part, whose radius is returned. */
double scree_rt_scene_scatter_ball(const scene_layer* layer, const scree_id* id, uint32_t packed, uint32_t part,
                                   const double from[3], double home[3], double centre[3]);
/* Its hull, without a place. x, y, z: CONVEX_MAX_POINTS each. */
convex_hull scree_rt_scene_scatter_hull(const scene_layer* layer, const scree_id* id, uint32_t packed, uint32_t part, float* x,
                                        float* y, float* z);

#endif
