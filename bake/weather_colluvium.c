/* Colluvium: grains slide down the steepest of eight slopes while that is steeper than their angle of repose, fall, and rest.
 *
 * A grain that rests makes its column one voxel higher: the step down to a column `far` cells away is then the drop to it plus one.
 * Steps are whole numbers of voxels, tangents are not, and a step of one over one cell is 45 degrees. So a grain looks as many
 * cells ahead as it takes for a whole step to have the right slope, within 6 %: 2 over 3 for 35 degrees. Nearer cells may be as far
 * below as on any line of that slope. (Thresholds that vary from column to column have the right mean, but slopes follow the
 * lowest.) */
#include "weather_counts.h"
#include "weather_step.h"

enum { DROP_LOOK = 32 }; /* voxels down a column that a grain sees: more than any angle of repose allows */

static const int32_t ways[8][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};

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

/* Where a grain would slide: steps^2 / cells^2 is the square of the slope. */
typedef struct slope {
  int32_t way, far;
  int64_t steps, cells;
} slope;

static void look(const scree_weather* w, uint32_t x, uint32_t y, uint32_t z, int32_t way, slope* best) {
  const int32_t diagonal = way & 1;
  const weather_repose* repose = &w->tables->repose[diagonal];
  for (int32_t far = 1; far <= repose->look; ++far) {
    const int32_t drop = drop_to(w, (int32_t)x + far * ways[way][0], y, (int32_t)z + far * ways[way][1]);
    if (drop < 0) return;
    if (drop == 0 || drop + 1 <= repose->steps[far]) continue;
    const int64_t steps = (int64_t)(drop + 1) * (drop + 1), cells = (int64_t)far * far * (1 + diagonal);
    if (steps * best->cells > best->steps * cells) *best = (slope){way, far, steps, cells};
    return;
  }
}

/* Returns whether the grain came to rest in the grid. */
static bool slide(scree_weather* w, uint32_t x, uint32_t y, uint32_t z, uint32_t random) {
  /* Grains before it may have come to lie at its place: it starts on top of them, if there is room. */
  while (weather_bit(w->colluvium, weather_row(w, (int32_t)y, (int32_t)z), x))
    if (++y == w->size[1]) return false;
  if (filled(w, x, y, z)) return false;
  y = fall(w, x, y, z);
  for (;;) {
    slope best = {-1, 0, 0, 1};
    for (uint32_t i = 0; i < 8; ++i) look(w, x, y, z, (int32_t)((random + i) & 7), &best);
    if (best.way < 0) break;
    x += (uint32_t)(best.far * ways[best.way][0]);
    z += (uint32_t)(best.far * ways[best.way][1]);
    if (x >= w->size[0] || z >= w->size[2]) return false; /* less than 0, too */
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
