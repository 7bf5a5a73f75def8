/* Snapshots: the bits of the grid, and only those lives that are neither whole nor gone, which are those of the surface. */
#include <string.h>

#include "weather_counts.h"

struct scree_weather_snapshot {
  uint64_t *rock, *colluvium;
  int32_t* lives; /* of voxels with a bit in `worn`, row by row */
  uint64_t* worn;
  size_t life_count;
  uint64_t step, rock_count, colluvium_count, removed, fallen;
  uint32_t noise_version;
};

/* Voxels of a word that have lost some of their life. */
static uint64_t worn_in(const scree_weather* w, uint32_t word, uint32_t y, uint32_t z) {
  const size_t at = weather_row(w, (int32_t)y, (int32_t)z) + word;
  const int32_t* life = w->life + weather_at(w, word * 64, y, z);
  uint64_t worn = 0;
  for (uint64_t left = w->solid[at]; left != 0; left &= left - 1) {
    const uint32_t bit = (uint32_t)__builtin_ctzll(left);
    worn |= (uint64_t)(life[bit] != WEATHER_FULL) << bit;
  }
  return worn;
}

static void release(const scree_weather* w, scree_weather_snapshot* s) {
  scree_rt_release(&w->allocator, s->rock, w->bit_count, sizeof *s->rock);
  scree_rt_release(&w->allocator, s->colluvium, w->bit_count, sizeof *s->colluvium);
  scree_rt_release(&w->allocator, s->worn, w->bit_count, sizeof *s->worn);
  scree_rt_release(&w->allocator, s->lives, s->life_count, sizeof *s->lives);
  scree_rt_release(&w->allocator, s, 1, sizeof *s);
}

scree_result scree_weather_save(const scree_weather* w, scree_weather_snapshot** out) {
  *out = NULL;
  scree_weather_snapshot* s = scree_rt_allocate_zeroed(&w->allocator, 1, sizeof *s);
  if (s == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  s->rock = scree_rt_allocate(&w->allocator, w->bit_count, sizeof *s->rock);
  s->colluvium = scree_rt_allocate(&w->allocator, w->bit_count, sizeof *s->colluvium);
  s->worn = scree_rt_allocate_zeroed(&w->allocator, w->bit_count, sizeof *s->worn);
  if (s->rock == NULL || s->colluvium == NULL || s->worn == NULL) {
    release(w, s);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  memcpy(s->rock, w->rock, w->bit_count * sizeof *s->rock);
  memcpy(s->colluvium, w->colluvium, w->bit_count * sizeof *s->colluvium);
  for (uint32_t z = 0; z < w->size[2]; ++z)
    for (uint32_t y = 0; y < w->size[1]; ++y)
      for (uint32_t i = 0; i < w->words; ++i) {
        const uint64_t worn = worn_in(w, i, y, z);
        s->worn[weather_row(w, (int32_t)y, (int32_t)z) + i] = worn;
        s->life_count += (size_t)__builtin_popcountll(worn);
      }
  if (s->life_count > 0) {
    s->lives = scree_rt_allocate(&w->allocator, s->life_count, sizeof *s->lives);
    if (s->lives == NULL) {
      release(w, s);
      return SCREE_ERROR_OUT_OF_MEMORY;
    }
  }
  int32_t* to = s->lives;
  for (uint32_t z = 0; z < w->size[2]; ++z)
    for (uint32_t y = 0; y < w->size[1]; ++y)
      for (uint32_t i = 0; i < w->words; ++i) {
        const int32_t* life = w->life + weather_at(w, i * 64, y, z);
        for (uint64_t left = s->worn[weather_row(w, (int32_t)y, (int32_t)z) + i]; left != 0; left &= left - 1)
          *to++ = life[__builtin_ctzll(left)];
      }
  s->step = w->step;
  s->rock_count = w->rock_count;
  s->colluvium_count = w->colluvium_count;
  s->removed = w->removed;
  s->fallen = w->fallen;
  s->noise_version = w->noise_version;
  *out = s;
  return SCREE_OK;
}

void scree_weather_restore(scree_weather* w, const scree_weather_snapshot* s) {
  const int32_t* from = s->lives;
  memcpy(w->rock, s->rock, w->bit_count * sizeof *s->rock);
  memcpy(w->colluvium, s->colluvium, w->bit_count * sizeof *s->colluvium);
  for (uint32_t z = 0; z < w->size[2]; ++z)
    for (uint32_t y = 0; y < w->size[1]; ++y) {
      const size_t row = weather_row(w, (int32_t)y, (int32_t)z);
      *weather_row_flag(w, y, z) = 1;
      for (uint32_t i = 0; i < w->words; ++i) {
        int32_t* life = w->life + weather_at(w, i * 64, y, z);
        const uint64_t now = w->rock[row + i] | w->colluvium[row + i], worn = s->worn[row + i];
        for (uint64_t left = w->solid[row + i] & ~now; left != 0; left &= left - 1) life[__builtin_ctzll(left)] = 0;
        for (uint64_t left = now & ~worn; left != 0; left &= left - 1) life[__builtin_ctzll(left)] = WEATHER_FULL;
        for (uint64_t left = worn; left != 0; left &= left - 1) life[__builtin_ctzll(left)] = *from++;
      }
    }
  w->step = s->step;
  w->rock_count = s->rock_count;
  w->colluvium_count = s->colluvium_count;
  w->removed = s->removed;
  w->fallen = s->fallen;
  w->may_hang = true; /* rules may have begun to ask for rockfall */
  ++w->change;
  for (size_t i = 0; i < (size_t)w->bricks[0] * w->bricks[1] * w->bricks[2]; ++i) w->stamps[i] = w->change;
  /* Noises are kept where there was rock when they were made. */
  if (w->noise_version != s->noise_version) weather_fill_noise(w);
  weather_update_counts(w);
}

void scree_weather_forget(scree_weather* w, scree_weather_snapshot* s) {
  if (s != NULL) release(w, s);
}
