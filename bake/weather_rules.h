/* Rules: their checks, and the tables that steps look things up in. */
#ifndef SCREE_WEATHER_RULES_H
#define SCREE_WEATHER_RULES_H

#include "weather_internal.h"

scree_result weather_check_rules(const scree_weather_rules* rules, const uint32_t size[3], scree_error* error);

/* Bytes of the tables of checked rules, and whether some segment is a mixture. */
size_t weather_tables_bytes(const scree_weather_rules* rules, const uint32_t size[3], bool* mixed);

/* Of checked rules. Returns SCREE_OK or OUT_OF_MEMORY. */
scree_result weather_tables_create(const scree_weather_rules* rules, const uint32_t size[3], const scree_allocator* allocator,
                                   weather_tables** out);
void weather_tables_destroy(weather_tables* tables, const scree_allocator* allocator); /* NULL is allowed */

/* Whether two tables ask for the same noise, and for the same bubbles everywhere. */
bool weather_same_noise(const weather_tables* a, const weather_tables* b, uint32_t layers);
bool weather_same_bubbles(const weather_tables* a, const weather_tables* b, uint32_t layers);

#endif
