/* The models of a scatter that come from glTF files: what a scree_scatter has to know of them, and meshes to draw and export. */
#ifndef SCENE_MODELS_H
#define SCENE_MODELS_H

#include <scree/draco.h>
#include <scree/scatter.h>

#include "scene_support.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SCENE_MODEL_VERTICES = 65535, SCENE_HULL_POINTS = 26 };

/* A model as it is drawn. */
typedef struct scene_model_mesh {
  painted_mesh mesh;
  float hull[3 * SCENE_HULL_POINTS]; /* points of its convex hull */
  uint32_t hull_count;
  float centre[3], radius; /* of a ball that holds it, metres */
} scene_model_mesh;

typedef struct scene_models {
  scene_model_mesh* models;
  scree_scatter_model* shapes; /* of each model; their hulls are above */
  uint32_t count;
  float steps_per_metre; /* of the lattice on which scene_models_vertices puts vertices */
} scene_models;

/* Reads the files that field `index`, a scatter, names. error: one line with the scene's file and the key. Returns SCREE_OK or the
 * code of whatever went wrong; a model of more than SCENE_MODEL_VERTICES vertices, or one without height, is RANGE. */
scree_result scene_models_create(const scene_model* scene, uint32_t index, const scene_paths* paths, scene_models** out,
                                 scree_error* error);
void scene_models_destroy(scene_models* models); /* NULL is allowed */

/* The mesh of a model as a renderer of packs takes it: places on the lattice, the sRGB colour in the bytes material, durability and
 * curvature. vertices, indices: as many as its painted_mesh has. */
void scene_models_vertices(const scene_models* models, uint32_t model, scree_vertex* vertices, uint16_t* indices);

#ifdef __cplusplus
}
#endif

#endif
