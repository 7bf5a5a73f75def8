/* A coarse map of space, a bit for each cell: whether a point there could be in any of some balls. Made from a list of balls, asked
 * about many points; most of them are far from all balls and cost one look. */
#ifndef SCREE_NEAR_MAP_H
#define SCREE_NEAR_MAP_H

#include <stdbool.h>
#include <stdint.h>

#include "scratch.h"

typedef struct near_map {
  uint64_t* bits; /* in the scratch: rows along x, each of whole words */
  int32_t size[3];
  uint32_t row; /* words */
  double low[3], step, slack;
  float from[3], inverse; /* the same, for points in floats relative to `origin` */
} near_map;

/* Begins a map of the box low .. high, no bit set. Cells are `step` wide, or wider where there would be more of them than `most`.
 * Points will be given relative to `origin`, in floats. Returns false when memory is short. */
bool scree_rt_near_map_begin(near_map* map, scree_scratch* scratch, const double low[3], const double high[3],
                             const double origin[3], double step, double most);

/* Sets the bits of all cells that a ball reaches into, and of a little more than that, for rounding. */
void scree_rt_near_map_add(near_map* map, const double centre[3], double radius);

static inline int32_t near_map_cell(const near_map* map, int axis, float at) {
  const float cell = (at - map->from[axis]) * map->inverse, last = (float)(map->size[axis] - 1);
  return (int32_t)(cell > 0 ? (cell < last ? cell : last) : 0.0f);
}

/* False: the point, which lies in the map's box but for rounding, is in none of the balls. */
static inline bool near_map_has(const near_map* map, const float at[3]) {
  const int32_t x = near_map_cell(map, 0, at[0]), y = near_map_cell(map, 1, at[1]), z = near_map_cell(map, 2, at[2]);
  return map->bits[(size_t)(z * map->size[1] + y) * map->row + (size_t)(x >> 6)] >> (x & 63) & 1;
}

#endif
