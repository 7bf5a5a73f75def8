/* Writes a .glb file: glTF 2.0, one JSON chunk and one BIN chunk. Vertex data goes to scratch files as it comes, so that memory
 * holds only the JSON; the file itself is written at the end under a temporary name and renamed.
 *
 * After the first fault every call does nothing; glb_finish tells what it was. Rows (of views, accessors, materials, meshes, nodes)
 * are numbered from 0 in the order in which they were added. */
#ifndef GLB_H
#define GLB_H

#include <scree/base.h>

#ifdef __cplusplus
extern "C" {
#endif

#define GLB_NONE UINT32_MAX /* no such row */

/* What a run of bytes is for. Each kind lies in one piece of the file and is one buffer view, blobs excepted: each is its own. */
typedef enum glb_stream {
  GLB_POSITIONS = 0, /* 3 floats */
  GLB_NORMALS = 1,   /* 3 floats */
  GLB_COLOURS = 2,   /* 4 bytes, normalised */
  GLB_INDICES16 = 3,
  GLB_INDICES32 = 4,
  GLB_TRANSLATIONS = 5,     /* 3 floats an instance */
  GLB_INSTANCE_COLOURS = 6, /* 3 floats an instance */
  GLB_ROTATIONS = 7,        /* 4 floats an instance: a unit quaternion x, y, z, w */
  GLB_SCALES = 8,           /* 3 floats an instance */
  GLB_UVS = 9,              /* 2 floats, v down */
  GLB_BLOBS = 10,           /* Draco bytes */
  GLB_STREAMS = 11
} glb_stream;

typedef struct glb_writer glb_writer;

/* Starts a file. Returns SCREE_OK, IO or OUT_OF_MEMORY. */
scree_result glb_begin(const char* path, glb_writer** out, scree_error* error);

/* Writes the file. Frees the writer in any case. bytes: size of the file, may be NULL. */
scree_result glb_finish(glb_writer* writer, uint64_t* bytes, scree_error* error);

/* Gives up: nothing is left behind. NULL is allowed. */
void glb_abort(glb_writer* writer);

/* Appends to a stream and returns the accessor that reads it, counted in elements. With min and max (3 floats each, NULL otherwise)
 * they are written too, as positions need it. */
uint32_t glb_add_data(glb_writer* writer, glb_stream stream, const void* data, uint32_t count, const float* min, const float* max);

/* An accessor without data of its own, as meshes with Draco have: of a stream's type, `count` elements. */
uint32_t glb_add_accessor(glb_writer* writer, glb_stream stream, uint32_t count, const float* min, const float* max);

/* Appends a blob and returns its buffer view. */
uint32_t glb_add_blob(glb_writer* writer, const void* data, size_t size);

/* A rough stone. colour: linear RGB. */
uint32_t glb_add_material(glb_writer* writer, const char* name, const float colour[3]);

typedef struct glb_mesh {
  const char* name;                                  /* may be NULL */
  uint32_t positions, normals, colours, uvs;         /* accessors; colours and uvs may be GLB_NONE */
  uint32_t indices;                                  /* accessor */
  uint32_t material;                                 /* GLB_NONE = none */
  uint32_t blob;                                     /* buffer view of Draco bytes, GLB_NONE = none */
  uint32_t position_id, normal_id, colour_id, uv_id; /* of the attributes in the Draco bytes */
  const struct glb_mesh* also;                       /* one more primitive of this mesh, whose name is not looked at; NULL = none */
} glb_mesh;

uint32_t glb_add_mesh(glb_writer* writer, const glb_mesh* mesh);

typedef struct glb_node {
  const char* name;                        /* may be NULL */
  uint32_t mesh;                           /* GLB_NONE = none */
  double translation[3];                   /* metres */
  double rotation[4];                      /* unit quaternion x, y, z, w; all 0 = none */
  double scale;                            /* 0 = 1 */
  uint32_t translations, instance_colours; /* accessors of EXT_mesh_gpu_instancing; GLB_NONE = a plain node */
  uint32_t rotations, scales;              /* likewise; GLB_NONE = instances are neither turned nor scaled */
  uint32_t first_child, child_count;       /* nodes that were added before, in one run */
  bool is_root;                            /* stands in the scene itself */
} glb_node;

uint32_t glb_add_node(glb_writer* writer, const glb_node* node);

/* How many nodes there are: the row of the next one. */
uint32_t glb_node_count(const glb_writer* writer);

#ifdef __cplusplus
}
#endif

#endif
