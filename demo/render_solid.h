/* One mesh that is neither stone nor model: a terrain, or the plane of the ground. */
#ifndef RENDER_SOLID_H
#define RENDER_SOLID_H

#include <scree/base.h>

typedef struct render_solid {
  uint32_t vertex_array, vertex_buffer, index_buffer, index_count;
  float min[3], max[3]; /* metres; where there is anything */
} render_solid;

void render_solid_create(render_solid* s);
void render_solid_destroy(render_solid* s);

/* Takes another mesh, see render_set_terrain; nothing when a count is 0. Returns SCREE_OK or OUT_OF_MEMORY. */
scree_result render_solid_fill(render_solid* s, const float* positions, const float* normals, uint32_t vertex_count,
                               const uint32_t* indices, uint32_t index_count);

/* A level disc round the place below the eye, finer towards its middle so that no triangle is so long that its depth turns to
 * noise.
 */
scree_result render_solid_disc(render_solid* s, const float eye[3], float height, float radius);

void render_solid_draw(const render_solid* s);

#endif
