/* Random small grids and random rules, for tests of weathering. */
#ifndef RANDOM_WEATHER_H
#define RANDOM_WEATHER_H

#include <scree/weather.h>

#include "random.h"

typedef struct random_rules {
  scree_weather_rules rules; /* points into the arrays below */
  scree_durability_point points[8];
  scree_bubble_segment segments[4];
} random_rules;

typedef struct random_start {
  scree_weather_start start; /* points at the map and the support */
  uint8_t map[32 * 32];
  scree_support* support;
} random_start;

uint32_t random_below(random_stream* random, uint32_t count);

/* A start of sizes up to `most`, at least one voxel of which is rock in most cases. Free with random_start_free. */
void random_start_make(random_stream* random, uint32_t most, random_start* out);
void random_start_free(random_start* start);

/* Rules of every kind; bubbles of up to most_radius. */
void random_rules_make(random_stream* random, double most_radius, random_rules* out);

#endif
