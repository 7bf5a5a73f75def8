/* From a scene to what the runtime takes: supports with their files loaded, packs found.
 *
 * Where files are looked for: a mesh or a picture beside the scene's file, then in the data folder; a pack that is a plain name
 * ("boulders") as NAME.scree in the packs folder, one that ends in .scree beside the scene's file. Absolute paths stay as they are.
 */
#ifndef SCENE_SUPPORT_H
#define SCENE_SUPPORT_H

#include <scree/support.h>

#include "scene.h"
#include "support_file.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SCENE_DEFAULT_PACKS "build/packs"
#define SCENE_DEFAULT_DATA "build/data"

typedef struct scene_paths {
  const char* scene; /* the scene's file, also named in messages */
  const char* packs; /* NULL = SCENE_DEFAULT_PACKS */
  const char* data;  /* NULL = SCENE_DEFAULT_DATA */
} scene_paths;

/* out: `capacity` bytes, SCENE_FILE_SIZE * 2 are enough for usual folders. Returns SCREE_OK, or IO with a line that names the
 * places where it was looked for. `where` is the path of the key, for messages ("fields[0].pack"). */
scree_result scene_find_pack(const scene_paths* paths, const char* where, const char* pack, char* out, size_t capacity,
                             scree_error* error);
scree_result scene_find_file(const scene_paths* paths, const char* where, const char* file, char* out, size_t capacity,
                             scree_error* error);

/* Files that supports were made from, kept so that moving a shape reads none again. Not thread-safe. */
typedef struct scene_files scene_files;
scene_files* scene_files_create(void); /* NULL when memory is short */
void scene_files_destroy(scene_files* files);

/* The mesh of a file or of a cliff, as the shape wants it, and the heights of a file: owned by `files`. */
scree_result scene_files_mesh(scene_files* files, const scene_paths* paths, const char* where, const scene_mesh* mesh,
                              scree_mesh* out, scree_error* error);
scree_result scene_files_heights(scene_files* files, const scene_paths* paths, const char* where, const scene_height_map* map,
                                 const height_samples** out, scree_error* error);

/* How many times the pack of a cliff's mesh keeps: 0 unless a mesh of that pack was asked for before, and of a mesh of a file. */
uint32_t scene_files_times(const scene_files* files, const scene_paths* paths, const scene_mesh* mesh);

/* Compiles the support of field `index`. The support stands on its own: the scene may change afterwards.
 * The position of the root becomes the support's origin, in doubles, so that a scene may lie far from the world's.
 * files: may be NULL (every file is then read). jobs: may be NULL. reuse: NULL, or an earlier support, whose grids of the same
 * meshes are taken over. error: one line with the scene's file and the key. Returns SCREE_OK or the code of whatever went wrong. */
scree_result scene_support_create(const scene_model* scene, uint32_t index, const scene_paths* paths, scene_files* files,
                                  const scree_jobs* jobs, const scree_support* reuse, scree_support** out, scree_error* error);

/* A leaf alone in its own space, without its transform: what a viewer asks for distances. Returns what scree_support_create
 * returns, or UNSUPPORTED for groups and shapes from files. */
scree_result scene_leaf_support(const scene_node* leaf, scree_support** out);

#ifdef __cplusplus
}
#endif

#endif
