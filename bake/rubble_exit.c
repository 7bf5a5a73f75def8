/* A block's way out of the rock that it was part of. */
#include <math.h>
#include <string.h>

#include "rubble_internal.h"

enum { LEVELS = 4 };

const int32_t rubble_directions[RUBBLE_DIRECTIONS][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};

bool rubble_clear(const rubble_mover* m, const int32_t from[2], const int32_t to[2], double height) {
  const int32_t way[2] = {to[0] - from[0], to[1] - from[1]};
  int32_t steps = way[0] < 0 ? -way[0] : way[0];
  if ((way[1] < 0 ? -way[1] : way[1]) > steps) steps = way[1] < 0 ? -way[1] : way[1];
  for (int32_t n = 1; n <= steps; ++n) {
    const int32_t at[2] = {from[0] + way[0] * n / steps, from[1] + way[1] * n / steps};
    if (dexels_hold(m->rock, at, height)) return false;
  }
  return true;
}

/* Directions by how far they go along the push, the farthest first. */
static void sort_directions(const double push[3], int out[RUBBLE_DIRECTIONS]) {
  double along[RUBBLE_DIRECTIONS] = {0};
  for (int k = 0; k < RUBBLE_DIRECTIONS; ++k) {
    const double value = (push[0] * rubble_directions[k][0] + push[2] * rubble_directions[k][1]) * (k % 2 ? sqrt(0.5) : 1);
    int n = k;
    for (; n > 0 && along[n - 1] < value; --n) {
      along[n] = along[n - 1];
      out[n] = out[n - 1];
    }
    along[n] = value;
    out[n] = k;
  }
}

/* In a column, at the height where it was or some way below: where it fits and comes to rest no higher than it was. */
static rubble_fit fits_in_column(const rubble_mover* m, const int32_t at[2], double height, double* rest) {
  for (int level = 0; level < LEVELS; ++level, height -= 0.4 * m->hull->size) {
    if (level > 0 && dexels_hold(m->rock, at, height)) break;
    if (dexels_hold(m->solid, at, height)) continue; /* far within another block */
    const rubble_fit f = rubble_fits(m, &m->rasters[0], at, height, INFINITY, rest);
    if (f == FIT_OUT || (f == FIT_FREE && *rest <= m->limit)) return f;
  }
  return FIT_BLOCKED;
}

bool rubble_leave(const rubble_mover* m, rubble_pose* pose, const double push[3]) {
  rubble_flood* flood = m->flood;
  int order[RUBBLE_DIRECTIONS];
  sort_directions(push, order);
  memset(flood->seen, 0, sizeof flood->seen);
  const uint32_t middle = FLOOD_REACH * (FLOOD_SIDE + 1);
  uint32_t head = 0, count = 0;
  flood->queue[count++] = (uint16_t)middle;
  flood->seen[middle] = 1;
  /* The centre of mass of several shards, or of one smaller than a column, may itself seem to be in rock. */
  const int32_t within = (int32_t)(0.5 * m->hull->size / m->solid->size) + 1;
  while (head < count) {
    const uint32_t place = flood->queue[head++];
    const int32_t from[2] = {(int32_t)(place % FLOOD_SIDE) - FLOOD_REACH, (int32_t)(place / FLOOD_SIDE) - FLOOD_REACH};
    const int32_t at[2] = {pose->column[0] + from[0], pose->column[1] + from[1]};
    const bool buried = dexels_hold(m->rock, at, pose->height);
    double rest;
    const rubble_fit f = fits_in_column(m, at, pose->height, &rest);
    if (f == FIT_OUT) return false;
    if (f == FIT_FREE) {
      pose->column[0] = at[0];
      pose->column[1] = at[1];
      pose->height = rest;
      return true;
    }
    for (int k = 0; k < RUBBLE_DIRECTIONS; ++k) {
      const int32_t* by = rubble_directions[order[k]];
      const int32_t to[2] = {from[0] + by[0], from[1] + by[1]};
      if (to[0] < -FLOOD_REACH || to[1] < -FLOOD_REACH || to[0] > FLOOD_REACH || to[1] > FLOOD_REACH) continue;
      const uint32_t next = (uint32_t)(to[0] + FLOOD_REACH + FLOOD_SIDE * (to[1] + FLOOD_REACH));
      if (flood->seen[next]) continue;
      const int32_t there[2] = {at[0] + by[0], at[1] + by[1]}, beside[2][2] = {{there[0], at[1]}, {at[0], there[1]}};
      bool open = !dexels_hold(m->rock, there, pose->height);
      if (open && by[0] != 0 && by[1] != 0) /* not through the corner of a wall */
        open = !dexels_hold(m->rock, beside[0], pose->height) && !dexels_hold(m->rock, beside[1], pose->height);
      if (!open && buried) open = to[0] <= within && to[0] >= -within && to[1] <= within && to[1] >= -within;
      if (!open) continue;
      flood->seen[next] = 1;
      flood->queue[count++] = (uint16_t)next;
    }
  }
  return false;
}
