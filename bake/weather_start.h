/* Start shapes: what is rock before the first step. */
#ifndef SCREE_WEATHER_START_H
#define SCREE_WEATHER_START_H

#include "weather_internal.h"

scree_result weather_check_start(const scree_weather_start* start, scree_error* error);

/* Sets the bits of rock. */
void weather_fill_start(const scree_weather* w, const scree_weather_start* start);

#endif
