/* The surface of something that weathers, as a .glb file. */
#ifndef WEATHER_GLB_H
#define WEATHER_GLB_H

#include <scree/weather.h>

/* One mesh of two primitives with a material each, rock and colluvium (where there is any), over the same vertices, so that no gap
 * opens between them. Metres; the middle of the grid's ground lies on the origin. size: voxels of the grid; voxel: metres. Written
 * whole or not at all. Returns SCREE_OK, RANGE (there is no surface), IO or OUT_OF_MEMORY, with a line that names the file. */
scree_result weather_glb_write(const char* path, const char* name, const scree_surface* surface, const uint32_t size[3],
                               double voxel, scree_error* error);

#endif
