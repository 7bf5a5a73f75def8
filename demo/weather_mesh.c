#include "weather_mesh.h"

#include <string.h>

static uint8_t to_byte(float value) {
  return (uint8_t)((value > 0 ? value < 255 ? value : 255 : 0) + 0.5f);
}

/* As packs have them, see scree_vertex. */
static void natural(const scree_surface_vertex* v, uint8_t out[4]) {
  out[0] = (uint8_t)(v->material | (v->layer < 15 ? v->layer : 15) << 4);
  out[1] = to_byte(v->durability * (255.0f / 4));
  out[2] = (uint8_t)(to_byte(128 + 127 * v->curvature) - 128);
}

void weather_mesh_fill(const scree_surface* surface, const uint32_t size[3], double voxel, weather_colour colour,
                       const weather_range* range, render_vertex* out) {
  const float metres = (float)voxel, middle[3] = {0.5f * (float)size[0], 0, 0.5f * (float)size[2]};
  for (uint32_t i = 0; i < surface->vertex_count; ++i) {
    const scree_surface_vertex* v = &surface->vertices[i];
    render_vertex* to = &out[i];
    for (int a = 0; a < 3; ++a) {
      to->position[a] = (v->position[a] - middle[a]) * metres;
      to->normal[a] = v->normal[a];
    }
    to->occlusion = v->occlusion;
    to->surface[3] = 0;
    if (colour == WEATHER_NATURAL)
      natural(v, to->surface);
    else if (colour == WEATHER_CURVATURE)
      weather_curvature_colour((double)v->curvature, to->surface);
    else if (v->material == 1)
      memcpy(to->surface, weather_colluvium_colour, sizeof weather_colluvium_colour);
    else
      weather_durability_colour(range, (double)v->durability, to->surface);
  }
}
