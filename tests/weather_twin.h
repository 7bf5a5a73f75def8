/* Weathering as the papers write it down, for tests and benchmarks to judge the fast one by: a byte a voxel, bubbles as lists of
 * offsets, air counted anew for every exposed voxel in every step, a queue for what hangs in the air. It shares nothing with the
 * library but the noise and the hash. */
#ifndef WEATHER_TWIN_H
#define WEATHER_TWIN_H

#include <scree/weather.h>

typedef struct weather_twin weather_twin;

/* Starts from voxels as scree_weather_voxels writes them. lives: of 2^30, NULL = whole. NULL when memory is short. */
weather_twin* weather_twin_create(const uint32_t size[3], const uint8_t* voxels, const int32_t* lives, uint64_t seed);
void weather_twin_destroy(weather_twin* twin);
void weather_twin_rules(weather_twin* twin, const scree_weather_rules* rules); /* copied */
void weather_twin_step(weather_twin* twin);

const uint8_t* weather_twin_voxels(const weather_twin* twin);
const int32_t* weather_twin_lives(const weather_twin* twin); /* of 2^30; x fastest, then y, then z */
uint64_t weather_twin_removed(const weather_twin* twin);     /* by the last step */
uint64_t weather_twin_fallen(const weather_twin* twin);

#endif
