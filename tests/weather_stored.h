/* The algorithm of the papers as they describe it, for benchmarks to be held against: voxel objects for what is exposed, a rate
 * stored with each, and removed voxels that notify those whose bubbles they are in. Spheres, f = 3 c^3, no exposed-face exponent,
 * no colluvium and no rockfall. Beardall et al. 2007, section 5; Jones et al. 2010, section 4.4. */
#ifndef WEATHER_STORED_H
#define WEATHER_STORED_H

#include <stdbool.h>
#include <stdint.h>

typedef struct weather_stored weather_stored;

/* voxels: 0 = air; durability: of each voxel. Both x fastest, then y, then z. NULL when memory is short. */
weather_stored* weather_stored_create(const uint32_t size[3], const uint8_t* voxels, const float* durability, double radius,
                                      double steps_per_voxel);
void weather_stored_destroy(weather_stored* stored);
void weather_stored_step(weather_stored* stored);

uint64_t weather_stored_left(const weather_stored* stored); /* voxels */
bool weather_stored_rock(const weather_stored* stored, uint32_t x, uint32_t y, uint32_t z);

#endif
