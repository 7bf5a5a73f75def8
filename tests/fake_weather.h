/* A simulation that only stands there: voxels and lives as a test sets them, for what reads simulations. */
#ifndef SCREE_TESTS_FAKE_WEATHER_H
#define SCREE_TESTS_FAKE_WEATHER_H

#include "weather_internal.h"

/* All air; one layer graph of durability 1, a sphere of radius 1 as bubble. */
scree_weather* fake_weather_create(const uint32_t size[3], const scree_jobs* jobs, const scree_allocator* allocator);
void fake_weather_destroy(scree_weather* weather);

/* life: 0 (air)..1. The brick's stamp becomes the simulation's. */
void fake_weather_set(scree_weather* weather, uint32_t x, uint32_t y, uint32_t z, scree_voxel voxel, float life);

#endif
