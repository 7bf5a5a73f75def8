/* The files that recipes of hoodoos name: images of joints and meshes. For scree-bake and scree-view, the library never reads
 * files. */
#ifndef SCREE_START_FILES_H
#define SCREE_START_FILES_H

#include <scree/hoodoo.h>

typedef struct start_files {
  uint8_t* map; /* width * depth grey values, x fastest; NULL unless the recipe has a joint map */
  uint32_t width, depth;
  scree_support* mesh; /* NULL unless the recipe starts as a mesh */
} start_files;

/* Reads what the recipe at `path` names; nothing for most. Returns SCREE_OK, IO, SYNTAX, RANGE, NOT_CLOSED, UNSUPPORTED or
 * OUT_OF_MEMORY, with a line that names the key and the file. */
scree_result start_files_read(const scree_hoodoo_recipe* recipe, const char* path, start_files* out, scree_error* error);
void start_files_free(start_files* files);

#endif
