/* Colluvium: grains slide down the steepest of eight slopes while that is steeper than their angle of repose, fall, and rest.
 *
 * Slopes between voxels are whole numbers of voxels, angles of repose are not. So each column lets a grain rest over a drop of the
 * whole part of tan(repose) or one more, by a low-discrepancy sequence of its place: on average, and over any few neighbours, the
 * slope is that of repose, whatever the angle. (A fixed threshold gives slopes of 0, 45 or 63 degrees; looking two cells ahead adds
 * only 27.) */
#include "weather_counts.h"
#include "weather_step.h"

enum { DROP_LOOK = 16 }; /* voxels down a column that a grain sees: more than any angle of repose allows */

static const int32_t ways[8][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};

/* In 1/65536: Roberts' R2 sequence over two indices. */
static uint32_t repose_share(uint32_t x, uint32_t z) {
  return (x * UINT32_C(0xc13fa9a9) + z * UINT32_C(0x91e10da5)) >> 16;
}

static bool filled(const scree_weather* w, uint32_t x, uint32_t y, uint32_t z) {
  const size_t at = weather_row(w, (int32_t)y, (int32_t)z) + x / 64;
  return ((w->rock[at] | w->colluvium[at]) >> (x % 64) & 1) != 0;
}

static uint32_t fall(const scree_weather* w, uint32_t x, uint32_t y, uint32_t z) {
  while (y > 0 && !filled(w, x, y - 1, z)) --y;
  return y;
}

/* Voxels of air below level y in a column, -1 where the column is filled at y. Beside the grid there is nothing but the ground. */
static int32_t drop_to(const scree_weather* w, int32_t x, uint32_t y, int32_t z) {
  if (x < 0 || z < 0 || (uint32_t)x >= w->size[0] || (uint32_t)z >= w->size[2]) return y < DROP_LOOK ? (int32_t)y : DROP_LOOK;
  if (filled(w, (uint32_t)x, y, (uint32_t)z)) return -1;
  int32_t drop = 0;
  while (drop < DROP_LOOK && (uint32_t)drop < y && !filled(w, (uint32_t)x, y - 1 - (uint32_t)drop, (uint32_t)z)) ++drop;
  return drop;
}

/* Returns whether the grain came to rest in the grid. */
static bool slide(scree_weather* w, uint32_t x, uint32_t y, uint32_t z, uint32_t random) {
  /* Grains before it may have come to lie at its place: it starts on top of them, if there is room. */
  while (weather_bit(w->colluvium, weather_row(w, (int32_t)y, (int32_t)z), x))
    if (++y == w->size[1]) return false;
  if (filled(w, x, y, z)) return false;
  y = fall(w, x, y, z);
  for (;;) {
    const uint32_t share = repose_share(x, z);
    int32_t steepest = 0; /* square of the slope, twice */
    const int32_t* way = NULL;
    for (uint32_t i = 0; i < 8; ++i) {
      const uint32_t k = (random + i) & 7, diagonal = k & 1;
      const int32_t drop = drop_to(w, (int32_t)x + ways[k][0], y, (int32_t)z + ways[k][1]);
      if (drop <= (int32_t)((w->tables->repose[diagonal] + share) >> 16)) continue;
      const int32_t slope = drop * drop * (diagonal != 0 ? 1 : 2);
      if (slope <= steepest) continue;
      steepest = slope;
      way = ways[k];
    }
    if (way == NULL) break;
    x += (uint32_t)way[0];
    z += (uint32_t)way[1];
    if (x >= w->size[0] || z >= w->size[2]) return false; /* -1 too */
    y = fall(w, x, y, z);
    random = random >> 3 | random << 29;
  }
  const size_t row = weather_row(w, (int32_t)y, (int32_t)z);
  w->colluvium[row + x / 64] |= (uint64_t)1 << (x % 64);
  w->life[weather_at(w, x, y, z)] = WEATHER_FULL;
  w->stamps[weather_brick(w, x, y, z)] = w->change;
  *weather_row_flag(w, y, z) = 1;
  return true;
}

void weather_settle(scree_weather* w) {
  const uint64_t key = weather_step_key(w);
  for (uint32_t z = 0; z < w->size[2]; ++z)
    for (uint32_t y = 0; y < w->size[1]; ++y) {
      if (*weather_row_flag(w, y, z) == 0) continue; /* grains come from rows that lost something */
      const size_t row = weather_row(w, (int32_t)y, (int32_t)z);
      for (uint32_t i = 0; i < w->words; ++i)
        while (w->grains[row + i] != 0) {
          const uint32_t bit = (uint32_t)__builtin_ctzll(w->grains[row + i]);
          w->grains[row + i] &= w->grains[row + i] - 1;
          const uint32_t x = i * 64 + bit;
          if (slide(w, x, y, z, (uint32_t)weather_hash(key, x, y, z))) ++w->colluvium_count;
        }
    }
}
