/* What a weathered surface is painted with: as stone would look, or by what it tells. */
#ifndef WEATHER_COLOUR_H
#define WEATHER_COLOUR_H

#include <scree/weather.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum weather_colour { WEATHER_NATURAL = 0, WEATHER_DURABILITY = 1, WEATHER_CURVATURE = 2 } weather_colour;

/* The range of durabilities that the colours are spread over; it holds all points of the graph. */
typedef struct weather_range {
  double low, high; /* 0 < low < high */
} weather_range;

weather_range weather_range_of(const scree_durability_point* points, uint32_t count);

/* Red = durable, green, blue = soft, by the logarithm; sRGB bytes. As in Jones et al. 2010, figure 7. */
void weather_durability_colour(const weather_range* range, double durability, uint8_t rgb[3]);
/* Red = edges and tips, green = level, blue = hollows. */
void weather_curvature_colour(double curvature, uint8_t rgb[3]);
/* Of colluvium, where rock is painted by durability: purple, as in the paper. */
extern const uint8_t weather_colluvium_colour[3];

/* Base colour of the rock and of what crumbles off it, linear, for files. */
extern const float weather_rock_base[3], weather_colluvium_base[3];
/* A tint of them for one vertex, 0..1 for each channel: its bed, its occlusion, darker in hollows. */
void weather_natural_tint(const scree_surface_vertex* vertex, float rgb[3]);

#ifdef __cplusplus
}
#endif

#endif
