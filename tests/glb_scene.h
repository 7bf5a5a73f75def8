/* A .glb with rocks, read back by other code than wrote it: tinygltf for the file, Draco's decoder for the meshes, and the two
 * extensions by the letter of their specifications, since Khronos' validator checks neither. */
#ifndef SCREE_TESTS_GLB_SCENE_H
#define SCREE_TESTS_GLB_SCENE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* One rock as a viewer would draw it. */
typedef struct glb_rock {
  double position[3];    /* world, metres */
  double min[3], max[3]; /* of its vertices, metres, relative to position, before its turn */
  double turn[2];        /* sine and cosine of its turn about +Y */
  int is_grey;           /* all vertices have grey colours */
  double volume;         /* signed, cubic metres: positive when triangles face outwards */
  float colour[3];       /* base colour times the instance's own, linear */
  float base[3];         /* base colour alone, of its first primitive */
  uint32_t vertices, triangles;
  uint32_t cut_triangles; /* of them, those of materials named "cut" */
  int has_uvs;
  double uv_sums[2]; /* of u and v times x + 2 y + 3 z in metres, over all corners of triangles, before its turn */
  uint32_t shape;    /* number of the mesh's positions: equal for rocks that share them */
} glb_rock;

typedef struct glb_scene {
  glb_rock* rocks; /* malloc */
  size_t rock_count;
  uint32_t shape_count, mesh_count, node_count, material_count;
  int needs_draco, needs_instancing;
  char message[512]; /* what is wrong with the file; empty when nothing is */
} glb_scene;

/* Reads and checks everything it meets: ranges, counts, bounds, unit normals, indices. 1 when all is well. */
int glb_scene_load(const char* path, glb_scene* out);
void glb_scene_free(glb_scene* scene);

#ifdef __cplusplus
}
#endif

#endif
