/* A rock as Draco bytes for glTF: float positions on the pack's lattice, normals, occlusion as colour. The C side of glb_draco.cpp.
 * The pack's own blobs do not serve: glTF viewers expect floats, and normals with them. */
#ifndef GLB_DRACO_H
#define GLB_DRACO_H

#include <scree/draco.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct glb_draco {
  uint8_t* bytes; /* owned, malloc */
  size_t size;
  uint32_t points, triangles;                 /* what a decoder will deliver */
  uint32_t position_id, normal_id, colour_id; /* unique ids of the attributes */
} glb_draco;

/* Positions decode to exactly the integers that go in, as floats; normals to about half a degree.
 * colours: 4 * vertex_count. indices: 3 * triangle_count, each < vertex_count. Returns SCREE_OK, CORRUPT (Draco refuses the mesh)
 * or OUT_OF_MEMORY. Thread-safe. */
scree_result glb_draco_encode(const scree_vertex* vertices, const uint8_t* colours, uint32_t vertex_count, const uint32_t* indices,
                              uint32_t triangle_count, glb_draco* out);

#ifdef __cplusplus
}
#endif

#endif
