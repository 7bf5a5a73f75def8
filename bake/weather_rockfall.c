/* Rockfall: what no path of faces joins to the ground. A flood fill of whole words: each row takes what its four neighbours
 * reached, spreads it along x through itself, and passes it on; sweeps up and down the grid until one finds nothing more. */
#include <string.h>

#include "weather_counts.h"
#include "weather_step.h"

/* Fills runs of `open` from the bits of `reached` in them, in both directions of x, across words. reached is part of open. */
static void spread(const uint64_t* open, uint64_t* reached, uint32_t words) {
  uint64_t carry = 0;
  for (uint32_t i = 0; i < words; ++i) {
    /* A carry runs up from the lowest bit that was reached, through its run and no further. */
    const uint64_t start = reached[i] | (carry & open[i]);
    const uint64_t sum = open[i] + start;
    reached[i] = start | (open[i] & ~sum);
    carry = reached[i] >> 63;
  }
  carry = 0;
  for (uint32_t i = words; i-- > 0;) {
    uint64_t fill = reached[i] | (carry << 63 & open[i]), through = open[i];
    for (uint32_t shift = 1; shift < 64; shift *= 2) {
      fill |= through & fill >> shift;
      through &= through >> shift;
    }
    reached[i] = fill;
    carry = fill & 1;
  }
}

/* Returns whether the row has reached more than before. */
static bool flood_row(const scree_weather* w, uint32_t y, uint32_t z) {
  const size_t row = weather_row(w, (int32_t)y, (int32_t)z);
  uint64_t* reached = w->scratch + row;
  uint64_t open[65], more = 0;
  for (uint32_t i = 0; i < w->words; ++i) {
    open[i] = w->rock[row + i] | w->colluvium[row + i];
    if (open[i] == reached[i]) continue;
    const uint64_t* r = reached + i;
    const uint64_t around = r[w->words] | *(r - w->words) | r[w->bit_plane] | *(r - w->bit_plane);
    more |= around & open[i] & ~*r;
  }
  if (more == 0) return false;
  for (uint32_t i = 0; i < w->words; ++i) {
    const uint64_t* r = reached + i;
    reached[i] |= (r[w->words] | *(r - w->words) | r[w->bit_plane] | *(r - w->bit_plane)) & open[i];
  }
  spread(open, reached, w->words);
  return true;
}

/* Marks in `scratch` what is joined to the ground. */
static void flood(const scree_weather* w) {
  memset(w->scratch, 0, w->bit_count * sizeof *w->scratch);
  for (uint32_t z = 0; z < w->size[2]; ++z) {
    const size_t row = weather_row(w, 0, (int32_t)z);
    for (uint32_t i = 0; i < w->words; ++i) w->scratch[row + i] = w->rock[row + i] | w->colluvium[row + i];
  }
  bool up = true, down = true;
  while (up || down) {
    up = false;
    for (uint32_t z = 0; z < w->size[2]; ++z)
      for (uint32_t y = 0; y < w->size[1]; ++y) up = flood_row(w, y, z) || up;
    if (!up) break;
    down = false;
    for (uint32_t z = w->size[2]; z-- > 0;)
      for (uint32_t y = w->size[1]; y-- > 0;) down = flood_row(w, y, z) || down;
  }
}

void weather_rockfall(scree_weather* w) {
  flood(w);
  const uint64_t key = weather_step_key(w);
  const bool keep = w->tables->rockfall == SCREE_ROCKFALL_COLLUVIUM;
  for (uint32_t z = 0; z < w->size[2]; ++z)
    for (uint32_t y = 0; y < w->size[1]; ++y) {
      const size_t row = weather_row(w, (int32_t)y, (int32_t)z);
      for (uint32_t i = 0; i < w->words; ++i) {
        const uint64_t rock = w->rock[row + i] & ~w->scratch[row + i], colluvium = w->colluvium[row + i] & ~w->scratch[row + i];
        if ((rock | colluvium) == 0) continue;
        *weather_row_flag(w, y, z) = 1;
        w->rock[row + i] &= ~rock;
        w->colluvium[row + i] &= ~colluvium;
        const uint64_t fallen = (uint64_t)__builtin_popcountll(rock), sand = (uint64_t)__builtin_popcountll(colluvium);
        w->rock_count -= fallen;
        w->colluvium_count -= sand;
        w->fallen += fallen + sand;
        int32_t* life = w->life + weather_at(w, i * 64, y, z);
        for (uint64_t left = rock | colluvium; left != 0; left &= left - 1) {
          const uint32_t bit = (uint32_t)__builtin_ctzll(left);
          life[bit] = 0;
          if (!keep) continue;
          if ((rock >> bit & 1) != 0 && !weather_becomes_colluvium(w->tables, weather_hash(key, i * 64 + bit, y, z))) continue;
          w->grains[row + i] |= (uint64_t)1 << bit;
          ++w->grain_count;
        }
      }
    }
}
