/* Rocks as a .glb file, in one of two forms.
 *
 * Instanced: one mesh per rock shape and base colour, Draco-compressed (KHR_draco_mesh_compression), one node per mesh with the
 * places of all its rocks (EXT_mesh_gpu_instancing: TRANSLATION, and the shade of each rock as _COLOR_0). Clients that do not know
 * _COLOR_0 still see the base colours, which are materials. Meshes and places are in lattice steps; the node above them has the
 * scale. Flat: no extensions. One node per rock, shared meshes in metres, colours as materials in a few shades.
 *
 * Both: normals, occlusion of each vertex as COLOR_0, only the shapes that are used. Each layer is one node of the scene.
 *
 * Meshes of cliffs have two primitives where frost cut them: what is left of the solid, whose materials are all named "rock", and
 * the cut faces, "cut", so that each can be textured. UVs are TEXCOORD_0; a pack whose range of them is empty gives none. */
#ifndef ROCK_EXPORT_H
#define ROCK_EXPORT_H

#include <scree/field.h>

#include "scene_models.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rock_format { ROCK_FORMAT_INSTANCED = 0, ROCK_FORMAT_FLAT = 1 } rock_format;

typedef struct rock_export_desc {
  const char* path;
  rock_format format;
  uint32_t lod;                              /* of every rock; a pack with fewer levels gives its coarsest */
  scree_jobs jobs;                           /* decode and encode meshes; all zero = the calling thread */
  void (*progress)(void* user, double done); /* 0..1 within a layer, from the calling thread; may be NULL */
  void* user;
} rock_export_desc;

/* How a model stands: turned about +Y, then scaled. */
typedef struct rock_turn {
  float sine, cosine, scale;
} rock_turn;

/* Rocks of one field, models of one scatter, or any others of one pack or set of models. Cuts of cliffs are paler than the
 * rest; hoodoos have the tints of their beds and of what crumbled off them in the colours of their vertices, models from files
 * their own colours there and a white material. */
typedef struct rock_layer {
  const char* name;           /* of the node */
  const scree_pack* pack;     /* or NULL, and */
  const scene_models* models; /* of files; instances' assets are their numbers */
  double cell_size;           /* metres; of models 1 */
  double origin[3];           /* world place that positions are relative to, metres */
  const scene_palette* palette;
  const scree_instance* instances; /* `count` */
  const uint32_t* hashes;          /* `count`: world hashes, which choose the colours */
  const rock_turn* turns;          /* `count`, or NULL: all stand as their meshes do */
  uint64_t count;                  /* at most 2^31 */
} rock_layer;

typedef struct rock_export_stats {
  uint64_t instances, triangles; /* triangles: as drawn, summed over instances */
  uint64_t shapes;               /* different rocks, each stored once */
  uint64_t bytes;                /* of the file, once it is finished */
} rock_export_stats;

typedef struct rock_export rock_export;

scree_result rock_export_begin(const rock_export_desc* desc, rock_export** out, scree_error* error);

/* Adds a layer; nothing of it need live on afterwards. stats: of this layer, may be NULL. */
scree_result rock_export_add(rock_export* file, const rock_layer* layer, rock_export_stats* stats, scree_error* error);

/* Writes the file and frees `file`, in any case. */
scree_result rock_export_finish(rock_export* file, rock_export_stats* stats, scree_error* error);

/* frees `file`; nothing is left on disk. NULL is allowed. */
void rock_export_abort(rock_export* file);

#ifdef __cplusplus
}
#endif

#endif
