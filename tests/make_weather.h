/* Simulations of weathering for tests. */
#ifndef SCREE_TESTS_MAKE_WEATHER_H
#define SCREE_TESTS_MAKE_WEATHER_H

#include <scree/weather.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static inline scree_weather* make(const scree_weather_start* start, const scree_weather_rules* rules) {
  const scree_weather_desc desc = {.start = *start, .rules = *rules};
  scree_weather* w = NULL;
  scree_error error = {{0}};
  const scree_result result = scree_weather_create(&desc, &w, &error);
  if (result != SCREE_OK) fail_msg("%s: %s", scree_result_string(result), error.message);
  return w;
}

static inline scree_weather_stats stats_of(const scree_weather* w) {
  scree_weather_stats stats;
  scree_weather_get_stats(w, &stats);
  return stats;
}

#endif
