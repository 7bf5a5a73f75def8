/* The graphs of an artist: changes of durability points and bubble segments that always leave rules which can be used. */
#ifndef WEATHER_GRAPH_H
#define WEATHER_GRAPH_H

#include <scree/hoodoo.h>

#ifdef __cplusplus
extern "C" {
#endif

#define WEATHER_GRAPH_NONE UINT32_MAX
#define WEATHER_DURABILITY_LEAST 1e-3
#define WEATHER_DURABILITY_MOST 1e6

/* Of the graph, noise apart. */
double weather_graph_durability(const scree_hoodoo_rules* rules, double altitude);

/* A new point on the line: nothing changes by it yet. Returns its row, NONE when the graph is full. */
uint32_t weather_graph_add_point(scree_hoodoo_rules* rules, double altitude);
/* As near to there as its neighbours and the limits let it. */
void weather_graph_move_point(scree_hoodoo_rules* rules, uint32_t point, double altitude, double durability);
/* False for the last one, which stays. */
bool weather_graph_remove_point(scree_hoodoo_rules* rules, uint32_t point);
/* The point whose noise rules at an altitude: the segment's lower one. */
uint32_t weather_graph_point_below(const scree_hoodoo_rules* rules, double altitude);

/* The bubble segment at an altitude. */
uint32_t weather_graph_segment_at(const scree_hoodoo_rules* rules, double altitude);
/* Cuts the segment at an altitude in two that are alike. Returns the upper one, NONE when there is no room. */
uint32_t weather_graph_split(scree_hoodoo_rules* rules, double altitude);
/* Moves the lower border of a segment, not of the first, between its neighbours'. */
void weather_graph_move_border(scree_hoodoo_rules* rules, uint32_t segment, double altitude);
/* The one below takes its place, for the first the one above. False for the last one, which stays. */
bool weather_graph_remove_segment(scree_hoodoo_rules* rules, uint32_t segment);

#ifdef __cplusplus
}
#endif

#endif
