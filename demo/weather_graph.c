#include "weather_graph.h"

#include <string.h>

#define BORDER_GAP 0.005 /* two borders on one place could not be told apart any more */

static double clamp(double x, double low, double high) {
  return x > low ? x < high ? x : high : low; /* not a number is `low` */
}

double weather_graph_durability(const scree_hoodoo_rules* rules, double altitude) {
  const scree_durability_point* p = rules->durability;
  const uint32_t last = rules->durability_count - 1;
  if (altitude <= p[0].altitude) return p[0].durability;
  for (uint32_t i = 0; i < last; ++i)
    if (altitude < p[i + 1].altitude) {
      const double t = (altitude - p[i].altitude) / (p[i + 1].altitude - p[i].altitude);
      return p[i].durability + (p[i + 1].durability - p[i].durability) * t;
    }
  return p[last].durability;
}

uint32_t weather_graph_point_below(const scree_hoodoo_rules* rules, double altitude) {
  uint32_t i = 0;
  while (i + 1 < rules->durability_count && rules->durability[i + 1].altitude <= altitude) ++i;
  return i;
}

uint32_t weather_graph_add_point(scree_hoodoo_rules* rules, double altitude) {
  if (rules->durability_count == SCREE_HOODOO_POINTS) return WEATHER_GRAPH_NONE;
  altitude = clamp(altitude, 0, 1);
  const uint32_t below = weather_graph_point_below(rules, altitude);
  /* Below the first point there is its noise, too. */
  const uint32_t at = altitude < rules->durability[0].altitude ? 0 : below + 1;
  scree_durability_point added = rules->durability[below];
  added.altitude = altitude;
  added.durability = weather_graph_durability(rules, altitude);
  memmove(&rules->durability[at + 1], &rules->durability[at], (rules->durability_count - at) * sizeof added);
  rules->durability[at] = added;
  ++rules->durability_count;
  return at;
}

void weather_graph_move_point(scree_hoodoo_rules* rules, uint32_t point, double altitude, double durability) {
  if (point >= rules->durability_count) return;
  scree_durability_point* p = &rules->durability[point];
  const double low = point > 0 ? p[-1].altitude : 0, high = point + 1 < rules->durability_count ? p[1].altitude : 1;
  p->altitude = clamp(altitude, low, high);
  p->durability = clamp(durability, WEATHER_DURABILITY_LEAST, WEATHER_DURABILITY_MOST);
}

bool weather_graph_remove_point(scree_hoodoo_rules* rules, uint32_t point) {
  if (point >= rules->durability_count || rules->durability_count == 1) return false;
  scree_durability_point* p = &rules->durability[point];
  memmove(p, p + 1, (rules->durability_count - point - 1) * sizeof *p);
  --rules->durability_count;
  return true;
}

uint32_t weather_graph_segment_at(const scree_hoodoo_rules* rules, double altitude) {
  uint32_t i = 0;
  while (i + 1 < rules->bubble_count && rules->bubbles[i + 1].altitude <= altitude) ++i;
  return i;
}

uint32_t weather_graph_split(scree_hoodoo_rules* rules, double altitude) {
  if (rules->bubble_count == SCREE_HOODOO_SEGMENTS) return WEATHER_GRAPH_NONE;
  const uint32_t below = weather_graph_segment_at(rules, altitude), at = below + 1;
  const double low = below > 0 ? rules->bubbles[below].altitude : 0;
  const double high = at < rules->bubble_count ? rules->bubbles[at].altitude : 1;
  if (!(high - low > 2 * BORDER_GAP)) return WEATHER_GRAPH_NONE;
  memmove(&rules->bubbles[at + 1], &rules->bubbles[at], (rules->bubble_count - at) * sizeof *rules->bubbles);
  rules->bubbles[at] = rules->bubbles[below];
  rules->bubbles[at].altitude = clamp(altitude, low + BORDER_GAP, high - BORDER_GAP);
  ++rules->bubble_count;
  return at;
}

void weather_graph_move_border(scree_hoodoo_rules* rules, uint32_t segment, double altitude) {
  if (segment == 0 || segment >= rules->bubble_count) return;
  const double low = segment > 1 ? rules->bubbles[segment - 1].altitude : 0;
  const double high = segment + 1 < rules->bubble_count ? rules->bubbles[segment + 1].altitude : 1;
  if (high - low <= 2 * BORDER_GAP) return;
  rules->bubbles[segment].altitude = clamp(altitude, low + BORDER_GAP, high - BORDER_GAP);
}

bool weather_graph_remove_segment(scree_hoodoo_rules* rules, uint32_t segment) {
  if (segment >= rules->bubble_count || rules->bubble_count == 1) return false;
  scree_bubble_segment* s = &rules->bubbles[segment];
  memmove(s, s + 1, (rules->bubble_count - segment - 1) * sizeof *s);
  --rules->bubble_count;
  if (segment == 0) rules->bubbles[0].altitude = 0;
  return true;
}
