/* The free mesh: one that changes from picture to picture. Only what has changed is sent to the GPU. */
#ifndef RENDER_FREE_H
#define RENDER_FREE_H

#include "render.h"

typedef struct render_free {
  uint32_t vertex_array, vertex_buffer, index_buffer;
  uint32_t vertex_room, index_room; /* elements of the buffers */
  render_vertex* vertices;          /* what the buffers hold */
  uint32_t* indices;
  uint32_t vertex_count, index_count;
  uint64_t sent; /* bytes, by the last fill */
  uint8_t colour[3];
  render_look look;
  float min[3], max[3]; /* metres; where there is anything */
} render_free;

void render_free_create(render_free* f);
void render_free_destroy(render_free* f);

/* Takes another mesh, see render_set_free_mesh. Returns SCREE_OK, INVALID_ARGUMENT or OUT_OF_MEMORY: then there is none. */
scree_result render_free_fill(render_free* f, const render_vertex* vertices, uint32_t vertex_count, const uint32_t* indices,
                              uint32_t index_count);

/* With the program in use. tags: of frame.glsl, without the colour. */
void render_free_draw(const render_free* f, uint32_t tags);

#endif
