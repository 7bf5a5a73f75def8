/* What tests of mesh files share: a folder, files in it, a cube, GLB from its chunks, and broken bytes. */
#ifndef MESH_FILES_H
#define MESH_FILES_H

#include "support_file.h"

extern char folder[64];

/* Setup and teardown of cmocka for `folder`. */
int make_folder(void** state);
int remove_folder(void** state);
/* The path of a new file in it, good until the next call. */
const char* write_file(const char* name, const void* bytes, size_t size);
scree_result load_text(const char* name, const char* text, triangle_mesh* mesh, scree_error* error);

double signed_volume(const triangle_mesh* mesh);
/* Every edge once in each direction. */
bool is_closed(const triangle_mesh* mesh);
void assert_unit_cube(const triangle_mesh* mesh);

/* Mutations of a good file, each in a block of the exact size plus the NUL that readers are promised. */
void mutate(const char* good, size_t size, uint64_t seed, int rounds,
            scree_result (*read)(const char*, size_t, const char*, triangle_mesh*, scree_error*));

typedef struct glb_file {
  char bytes[8192];
  size_t size;
} glb_file;

void make_glb(const char* json, const void* bin, size_t bin_size, glb_file* out);
/* 24 corners of a cube's quads, unwelded, and 36 indices of 16 bits: 288 + 72 bytes. */
void cube_bin(char bin[360]);

#endif
