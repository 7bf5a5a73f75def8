/* The files that recipes name: images of joints, meshes, height maps, stacks of images and other recipes. For scree-bake and
 * scree-view, the library never reads files. */
#ifndef SCREE_START_FILES_H
#define SCREE_START_FILES_H

#include <scree/shard_recipe.h>

typedef struct start_files {
  uint8_t* map; /* width * depth grey values, x fastest; NULL unless the recipe has a joint map */
  uint32_t width, depth;
  scree_support* mesh; /* NULL unless the recipe starts as a mesh */
} start_files;

/* Reads what the recipe at `path` names; nothing for most. Returns SCREE_OK, IO, SYNTAX, RANGE, NOT_CLOSED, UNSUPPORTED or
 * OUT_OF_MEMORY, with a line that names the key and the file. */
scree_result start_files_read(const scree_hoodoo_recipe* recipe, const char* path, start_files* out, scree_error* error);
void start_files_free(start_files* files);

/* What recipes of shards name. */
typedef struct shard_files {
  scree_solid mesh; /* of the file, when the input is a mesh */
  double* positions;
  uint32_t* indices;
  float* uvs;     /* NULL where the file has none */
  float* heights; /* when it is a terrain: metres */
  uint32_t width, depth;
  scree_hoodoo_recipe* hoodoo; /* when it is a hoodoo */
  start_files hoodoo_files;
  scree_hoodoo_desc hoodoo_desc; /* of these two */
  uint8_t* images;               /* where the recipe has some */
  uint32_t image_size[3];
} shard_files;

/* Reads what the recipe at `path` names; as start_files_read. */
scree_result shard_files_read(const scree_shard_recipe* recipe, const char* path, shard_files* out, scree_error* error);
/* Fills in what a bake is given. */
void shard_files_give(const shard_files* files, scree_shard_desc* desc);
void shard_files_free(shard_files* files);

#endif
