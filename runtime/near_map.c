#include "near_map.h"

#include <math.h>
#include <string.h>

bool scree_rt_near_map_begin(near_map* map, scree_scratch* scratch, const double low[3], const double high[3],
                             const double origin[3], double step, double most) {
  double far = 0;
  step = fmax(step, 1e-30); /* or it would never get wider */
  for (int a = 0; a < 3; ++a) far = fmax(far, fmax(fabs(low[a] - origin[a]), fabs(high[a] - origin[a])));
  for (;; step *= 1.25) {
    double cells = 1;
    for (int a = 0; a < 3; ++a) cells *= floor((high[a] - low[a]) / step) + 1;
    if (cells <= most) break;
  }
  for (int a = 0; a < 3; ++a) {
    map->size[a] = (int32_t)((high[a] - low[a]) / step) + 1;
    map->low[a] = low[a];
    map->from[a] = (float)(low[a] - origin[a]);
  }
  map->step = step;
  map->per_metre = 1 / step;
  map->inverse = (float)map->per_metre;
  map->slack = step * 1e-3 + far * 2e-6;
  const size_t cells = (size_t)map->size[0] * (size_t)map->size[1] * (size_t)map->size[2];
  map->kinds = scree_rt_scratch_reserve(scratch, SCRATCH_NEAR, cells, 1);
  if (map->kinds == NULL) return false;
  memset(map->kinds, 0, cells);
  return true;
}

/* Cells from .. to - 1 along an axis that a stretch of space reaches. */
static void find_cells(const near_map* map, int axis, double low, double high, int32_t* from, int32_t* to) {
  const double first = (low - map->low[axis]) * map->per_metre, last = (high - map->low[axis]) * map->per_metre;
  const double end = (double)map->size[axis];
  /* Points beside the box count to its outermost cells. */
  *from = first < 1 ? 0 : first < end ? (int32_t)first : map->size[axis] - 1;
  *to = last < 1 ? 1 : last < end ? (int32_t)last + 1 : map->size[axis];
}

/* How far a place is from cell i along an axis. */
static double away_from(const near_map* map, int axis, int32_t i, double at) {
  const double low = map->low[axis] + map->step * i, high = low + map->step;
  return at < low ? low - at : at > high ? at - high : 0;
}

void scree_rt_near_map_add(near_map* map, const double centre[3], double radius, uint8_t kind) {
  const double reach = radius + map->slack, reach2 = reach * reach;
  int32_t from[3], to[3];
  for (int a = 0; a < 3; ++a) find_cells(map, a, centre[a] - reach, centre[a] + reach, &from[a], &to[a]);
  for (int32_t z = from[2]; z < to[2]; ++z) {
    const double away_z = away_from(map, 2, z, centre[2]);
    for (int32_t y = from[1]; y < to[1]; ++y) {
      const double away_y = away_from(map, 1, y, centre[1]), left2 = reach2 - away_z * away_z - away_y * away_y;
      if (left2 < 0) continue;
      const double half = sqrt(left2);
      int32_t first, end;
      find_cells(map, 0, centre[0] - half, centre[0] + half, &first, &end);
      uint8_t* row = map->kinds + (z * map->size[1] + y) * map->size[0];
      for (int32_t x = first; x < end; ++x) row[x] |= kind;
    }
  }
}
