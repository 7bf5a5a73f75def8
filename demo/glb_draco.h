/* A rock as Draco bytes for glTF: float positions on the pack's lattice, normals, occlusion as colour, UVs where it has some. The C
 * side of glb_draco.cpp. The pack's own blobs do not serve: glTF viewers expect floats, and normals with them. */
#ifndef GLB_DRACO_H
#define GLB_DRACO_H

#include <scree/draco.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct glb_draco {
  uint8_t* bytes; /* owned, malloc */
  size_t size;
  uint32_t points, triangles;                        /* what a decoder will deliver */
  uint32_t position_id, normal_id, colour_id, uv_id; /* unique ids of the attributes; uv_id only where there are UVs */
} glb_draco;

typedef struct glb_draco_mesh {
  const scree_vertex* vertices; /* vertex_count */
  const uint8_t* colours;       /* 4 * vertex_count */
  const float* uvs;             /* 2 * vertex_count, or NULL */
  float uv_min[2], uv_span;     /* UVs are within uv_min .. uv_min + uv_span, which is > 0 where there are any */
  uint32_t vertex_count;
  const uint32_t* indices; /* 3 * triangle_count, each < vertex_count */
  uint32_t triangle_count;
} glb_draco_mesh;

/* Positions decode to exactly the integers that go in, as floats; normals to about half a degree; UVs to half of 1/65535 of
 * uv_span. Returns SCREE_OK, CORRUPT (Draco refuses the mesh) or OUT_OF_MEMORY. Thread-safe. */
scree_result glb_draco_encode(const glb_draco_mesh* mesh, glb_draco* out);

#ifdef __cplusplus
}
#endif

#endif
