/* How much of the sky a point of a weathered surface sees: ambient occlusion by coarse densities of what stands around it. */
#ifndef SCREE_WEATHER_SKY_H
#define SCREE_WEATHER_SKY_H

#include "weather_internal.h"

enum { SKY_LEVELS = 3 };

/* Share of solid voxels in cells of 4, 8 and 16 voxels a side, blurred over their neighbours; solid below the ground. */
typedef struct weather_sky {
  float* cells[SKY_LEVELS];
  uint32_t size[SKY_LEVELS][3];
  float* scratch; /* as many as cells[0] */
} weather_sky;

scree_result weather_sky_create(const uint32_t size[3], const scree_allocator* allocator, weather_sky* out);
void weather_sky_destroy(weather_sky* sky, const scree_allocator* allocator); /* all zero is allowed */

/* Of what stands now. */
void weather_sky_update(weather_sky* sky, const scree_weather* weather);

/* 0 = wholly hidden, 1 = as open as a plain. position: in voxels. */
float weather_sky_at(const weather_sky* sky, const float position[3], const float normal[3]);

#endif
