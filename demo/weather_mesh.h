/* From the surface of something that weathers to the free mesh of the renderer. */
#ifndef WEATHER_MESH_H
#define WEATHER_MESH_H

#include "render.h"
#include "weather_colour.h"

/* out: surface->vertex_count. Metres; the middle of the grid's ground lies on the origin. size: voxels of the grid; voxel: metres.
 * Natural ones are for RENDER_LOOK_HOODOO, others for PAINTED. */
void weather_mesh_fill(const scree_surface* surface, const uint32_t size[3], double voxel, weather_colour colour,
                       const weather_range* range, render_vertex* out);

#endif
