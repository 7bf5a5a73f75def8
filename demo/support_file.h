/* Shapes from files: closed triangle meshes (OBJ, OFF, glTF) and 16-bit height maps (PNG). Every reader takes hostile files:
 * what is wrong comes back as one line that names the file and, for text, the line. */
#ifndef SUPPORT_FILE_H
#define SUPPORT_FILE_H

#include "scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Triangles, counter-clockwise from outside. Equal positions are one vertex. All zero = empty. */
typedef struct triangle_mesh {
  float* positions;  /* 3 * vertex_count, owned, malloc */
  uint32_t* indices; /* 3 * triangle_count, owned, malloc */
  float* uvs;        /* 6 * triangle_count: u, v of each triangle's corners, owned, malloc; NULL = not of every triangle */
  uint32_t vertex_count, triangle_count;
} triangle_mesh;

/* Reads a mesh; the format is told by the ending: .obj, .off, .glb or .gltf. Positions are taken as they are (glTF: node transforms
 * of the default scene applied). UVs are vt of OBJ and TEXCOORD_0 of glTF; v = 0 is the top of a picture, as in glTF, so that vt is
 * turned. Whether the mesh is closed is for scree_support_create to say.
 * Returns SCREE_OK, IO, SYNTAX, RANGE, UNSUPPORTED or OUT_OF_MEMORY. */
scree_result triangle_mesh_load(const char* file, triangle_mesh* out, scree_error* error);
void triangle_mesh_free(triangle_mesh* mesh);

/* The readers by format, from memory: `size` bytes followed by a NUL. They do not weld. */
scree_result mesh_read_obj(const char* bytes, size_t size, const char* file, triangle_mesh* out, scree_error* error);
scree_result mesh_read_off(const char* bytes, size_t size, const char* file, triangle_mesh* out, scree_error* error);
/* Buffers outside the file are read from its folder. */
scree_result mesh_read_gltf(const char* bytes, size_t size, const char* file, triangle_mesh* out, scree_error* error);

/* Joins vertices at the same position and drops triangles that lose an edge by it. Vertices keep their first place's order.
 * UVs belong to corners, so that vertices are joined across their seams. Returns SCREE_OK or OUT_OF_MEMORY. */
scree_result triangle_mesh_weld(triangle_mesh* mesh);

/* Triangles with a normal and a colour at each vertex: what a glTF file looks like, pictures apart. All zero = empty. */
typedef struct painted_mesh {
  float* positions;  /* 3 * vertex_count, owned, malloc */
  float* normals;    /* likewise, unit */
  float* colours;    /* likewise, linear RGB: base colour of the material times that of the vertex */
  uint32_t* indices; /* 3 * triangle_count, owned, malloc */
  uint32_t vertex_count, triangle_count;
} painted_mesh;

/* Reads a .glb or .gltf file. Returns SCREE_OK, IO, SYNTAX, UNSUPPORTED (another ending) or OUT_OF_MEMORY. */
scree_result painted_mesh_load(const char* file, painted_mesh* out, scree_error* error);
void painted_mesh_free(painted_mesh* mesh);
/* The reader, from memory as above. */
scree_result model_read_gltf(const char* bytes, size_t size, const char* file, painted_mesh* out, scree_error* error);

/* Heights in metres, row-major, x fastest then z. */
typedef struct height_samples {
  float* heights; /* width * depth, owned, malloc */
  uint32_t width, depth;
} height_samples;

/* Reads the picture of a height map, crops it and turns samples into metres. `file` is where map->file was found.
 * Returns SCREE_OK, IO, SYNTAX, RANGE or OUT_OF_MEMORY. */
scree_result height_samples_load(const scene_height_map* map, const char* file, height_samples* out, scree_error* error);
void height_samples_free(height_samples* samples);

#ifdef __cplusplus
}
#endif

#endif
