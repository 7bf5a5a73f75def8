#include "weather_colour.h"

#include <math.h>

const uint8_t weather_colluvium_colour[3] = {150, 92, 178};
const float weather_rock_base[3] = {0.47f, 0.27f, 0.16f}, weather_colluvium_base[3] = {0.60f, 0.41f, 0.27f};

weather_range weather_range_of(const scree_durability_point* points, uint32_t count) {
  weather_range range = {0.1, 10};
  for (uint32_t i = 0; i < count; ++i) {
    while (points[i].durability < range.low) range.low /= 10;
    while (points[i].durability > range.high) range.high *= 10;
  }
  return range;
}

/* Blue, cyan, green, yellow, red for 0..1, none of them so bright that light and shadow get lost. */
static void ramp(double t, uint8_t rgb[3]) {
  static const double stops[5][3] = {{52, 84, 190}, {46, 150, 178}, {88, 160, 74}, {206, 168, 58}, {196, 58, 44}};
  t = t > 0 ? t < 1 ? t : 1 : 0; /* not a number is 0, too */
  const int i = t < 1 ? (int)(t * 4) : 3;
  const double part = t * 4 - i;
  for (int c = 0; c < 3; ++c) rgb[c] = (uint8_t)(stops[i][c] + (stops[i + 1][c] - stops[i][c]) * part + 0.5);
}

void weather_durability_colour(const weather_range* range, double durability, uint8_t rgb[3]) {
  /* The middle three quarters of the range: what people draw seldom reaches its ends. */
  const double t = durability > 0 ? log(durability / range->low) / log(range->high / range->low) : 0;
  ramp((t - 0.125) / 0.75, rgb);
}

void weather_curvature_colour(double curvature, uint8_t rgb[3]) {
  ramp(0.5 + 0.9 * curvature, rgb);
}

static uint32_t mixed(uint32_t x) {
  x ^= x >> 16;
  x *= UINT32_C(0x45d9f3b);
  x ^= x >> 16;
  x *= UINT32_C(0x45d9f3b);
  return x ^ x >> 16;
}

void weather_natural_tint(const scree_surface_vertex* v, float rgb[3]) {
  static const float dark[3] = {0.86f, 0.80f, 0.76f}, light[3] = {1, 1, 1};
  const float t = (float)(mixed(v->layer * UINT32_C(2654435761) + 97) >> 8) / 16777216.0f;
  const float bend = v->curvature < 0 ? v->curvature : 0.4f * v->curvature;
  float level = 0.92f * (1 + 0.2f * bend) * (0.3f + 0.7f * v->occlusion);
  level = level > 0 ? level < 1 ? level : 1 : 0;
  for (int c = 0; c < 3; ++c) rgb[c] = level * (v->material == 1 ? 1 : dark[c] + (light[c] - dark[c]) * t);
}
