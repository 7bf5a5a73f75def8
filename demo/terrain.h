/* The mountain under a scree slope: a terrain ground as a mesh to look at. */
#ifndef TERRAIN_H
#define TERRAIN_H

#include "scene_support.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A terrain ground as triangles. All zero = empty. */
typedef struct terrain_mesh {
  float* positions;  /* 3 * vertex_count, metres, relative to ground.position, owned */
  float* normals;    /* 3 * vertex_count, unit, owned */
  uint32_t* indices; /* 3 * triangle_count, owned */
  uint32_t vertex_count, triangle_count;
} terrain_mesh;

/* ground->kind must be SCENE_GROUND_TERRAIN. */
scree_result terrain_mesh_create(const scene_ground* ground, const scene_paths* paths, scene_files* files, terrain_mesh* out,
                                 scree_error* error);
void terrain_mesh_free(terrain_mesh* mesh);

#ifdef __cplusplus
}
#endif

#endif
