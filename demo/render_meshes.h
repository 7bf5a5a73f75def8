/* Meshes of one source in one growing vertex buffer and one growing index buffer, so that all of them can be drawn by one call. */
#ifndef RENDER_MESHES_H
#define RENDER_MESHES_H

#include <scree/draco.h>

/* A place in the bound buffer, in the way OpenGL wants to be told of it. */
static inline const void* buffer_offset(size_t bytes) {
  return (const void*)(uintptr_t)bytes;
}

typedef struct render_mesh {
  uint32_t first_index, index_count;
  uint32_t base_vertex, vertex_count;
} render_mesh;

typedef struct render_meshes {
  uint32_t vertex_array, vertex_buffer, index_buffer;
  uint32_t vertex_capacity, index_capacity; /* elements */
  uint32_t vertex_count, index_count;
  render_mesh* meshes;
  uint32_t mesh_count, mesh_capacity;
} render_meshes;

/* instance_buffer: of render_instance (render_list.h); it becomes part of the vertex array. */
void render_meshes_create(render_meshes* m, uint32_t instance_buffer);
void render_meshes_destroy(render_meshes* m);

/* Adds a mesh and returns its row, or UINT32_MAX when memory is short. */
uint32_t render_meshes_add(render_meshes* m, const scree_vertex* vertices, uint32_t vertex_count, const uint16_t* indices,
                           uint32_t index_count);
/* Forgets all meshes and keeps the buffers. */
void render_meshes_clear(render_meshes* m);

/* Points the per-instance attributes at row `first` of the instance buffer: what base instances do where OpenGL has them. The
 * vertex array must be bound. */
void render_meshes_point_at(uint32_t instance_buffer, uint32_t first);

#endif
