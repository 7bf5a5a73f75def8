/* A coarse map of space: which of up to eight kinds of balls a point there could be in. Made from lists of balls, asked about many
 * points; most of them are far from all balls and cost one look. */
#ifndef SCREE_NEAR_MAP_H
#define SCREE_NEAR_MAP_H

#include <stdbool.h>
#include <stdint.h>

#include "scratch.h"

typedef struct near_map {
  uint8_t* kinds; /* in the scratch: bits of each cell, x fastest */
  int32_t size[3];
  double low[3], step, per_metre, slack;
  float from[3], inverse; /* the same, for points in floats relative to `origin` */
} near_map;

/* Begins a map of the box low .. high, without balls. Cells are `step` wide, or wider where there would be more of them than
 * `most`. Points will be given relative to `origin`, in floats. Returns false when memory is short. */
bool scree_rt_near_map_begin(near_map* map, scree_scratch* scratch, const double low[3], const double high[3],
                             const double origin[3], double step, double most);

/* Adds a ball of a kind, a bit: notes it in all cells that it reaches into, and in a little more, for rounding. */
void scree_rt_near_map_add(near_map* map, const double centre[3], double radius, uint8_t kind);

static inline int32_t near_map_cell(const near_map* map, int axis, float at) {
  const float last = (float)(map->size[axis] - 1);
  float cell = (at - map->from[axis]) * map->inverse;
  cell = cell > 0 ? cell : 0; /* one after the other: no branches */
  cell = cell < last ? cell : last;
  return (int32_t)cell;
}

/* The kinds of balls that a point may be in, which lies in the map's box but for rounding. It is in none of the others. */
static inline uint8_t near_map_kinds(const near_map* map, const float at[3]) {
  const int32_t x = near_map_cell(map, 0, at[0]), y = near_map_cell(map, 1, at[1]), z = near_map_cell(map, 2, at[2]);
  return map->kinds[(z * map->size[1] + y) * map->size[0] + x];
}

#endif
