#include "weather_counts.h"

#include <string.h>

#include "lattice.h"
#include "weather_kernels.h"
#include "weather_noise.h"

enum { NOISE_DURABILITY = 1, NOISE_MIXTURE = 2 }; /* what keys of noise are made of */

static void slab_of(const scree_weather* w, uint32_t slab, uint32_t* low, uint32_t* high) {
  *low = slab * WEATHER_BRICK;
  *high = w->size[2] - *low < WEATHER_BRICK ? w->size[2] : *low + WEATHER_BRICK;
}

/* --- noise ------------------------------------------------------------------------------------------------------------------- */

/* One word of each row of a plane, column by column: rows above each other share the noise's lattice. */
static void fill_mixture_plane(const scree_weather* w, uint32_t z) {
  for (uint32_t word = 0; word < w->words; ++word) {
    const uint32_t x = word * 64, count = w->size[0] - x < 64 ? w->size[0] - x : 64;
    weather_noise_cache cache = {0};
    double frequency = 0;
    for (uint32_t y = 0; y < w->size[1]; ++y) {
      const weather_layer* layer = &w->tables->layers[y];
      const size_t at = weather_row(w, (int32_t)y, (int32_t)z) + word;
      w->mixture[0][at] = w->mixture[1][at] = 0;
      if (layer->bubble_count == 1 || count == 0) continue;
      if (frequency != 1 / layer->mixture_period) cache.octaves[0].known = cache.octaves[1].known = false;
      frequency = 1 / layer->mixture_period;
      const weather_noise noise = {hash_combine(w->seed, NOISE_MIXTURE), frequency, frequency};
      float values[64];
      weather_noise_row(&noise, &cache, x, y, z, count, values);
      for (uint32_t i = 0; i < count; ++i) {
        uint32_t which = (uint32_t)((values[i] + 1) * 0.5f * (float)layer->bubble_count);
        if (which >= layer->bubble_count) which = layer->bubble_count - 1u;
        for (int bit = 0; bit < 2; ++bit) w->mixture[bit][at] |= (uint64_t)(which >> bit & 1) << i;
      }
    }
  }
}

static void fill_mixture_slab(void* context, uint32_t slab, uint32_t worker) {
  (void)worker;
  const scree_weather* w = context;
  uint32_t low, high;
  slab_of(w, slab, &low, &high);
  for (uint32_t z = low; z < high; ++z) fill_mixture_plane(w, z);
}

void weather_fill_mixture(const scree_weather* w) {
  weather_parallel(w, w->bricks[2], fill_mixture_slab, (void*)(uintptr_t)w);
}

static void fill_noise_plane(const scree_weather* w, uint32_t z) {
  for (uint32_t word = 0; word < w->words; ++word) {
    const uint32_t x = word * 64, count = w->size[0] - x < 64 ? w->size[0] - x : 64;
    weather_noise_cache cache = {0};
    const scree_durability_point* before = NULL;
    for (uint32_t y = 0; y < w->size[1]; ++y) {
      const weather_layer* layer = &w->tables->layers[y];
      const scree_durability_point* point = &w->tables->points[layer->point];
      if (w->rock[weather_row(w, (int32_t)y, (int32_t)z) + word] == 0) continue;
      float values[64] = {0};
      if (point != before) cache.octaves[0].known = cache.octaves[1].known = false;
      before = point;
      const double frequency = 1 / point->noise_period;
      const weather_noise noise = {hash_combine(w->seed, NOISE_DURABILITY), frequency, frequency * point->noise_squash};
      if (layer->amplitude > 0) weather_noise_row(&noise, &cache, x, y, z, count, values);
      int8_t* to = w->noise + weather_at(w, x, y, z);
      for (uint32_t i = 0; i < count; ++i) to[i] = (int8_t)((int32_t)(values[i] * 127 + 127.5f) - 127); /* rounded */
    }
  }
}

static void fill_noise_slab(void* context, uint32_t slab, uint32_t worker) {
  (void)worker;
  const scree_weather* w = context;
  uint32_t low, high;
  slab_of(w, slab, &low, &high);
  for (uint32_t z = low; z < high; ++z) fill_noise_plane(w, z);
}

void weather_fill_noise(const scree_weather* w) {
  weather_parallel(w, w->bricks[2], fill_noise_slab, (void*)(uintptr_t)w);
}

/* --- counts ------------------------------------------------------------------------------------------------------------------ */

/* Air in a bubble whose middle is in layer y when all of the grid is air. */
static uint16_t empty_count(const weather_bubble* b, uint32_t y) {
  uint32_t count = b->volume;
  for (int32_t dy = -WEATHER_MARGIN; dy + (int32_t)y < 0; ++dy)
    for (int32_t dz = 0; dz < WEATHER_REACH; ++dz)
      count -= (uint32_t)(2 * b->half[dz][dy + WEATHER_MARGIN] + 1) & ~(uint32_t) - (b->half[dz][dy + WEATHER_MARGIN] < 0);
  return (uint16_t)count;
}

static void clear_slab(void* context, uint32_t slab, uint32_t worker) {
  (void)worker;
  scree_weather* w = context;
  uint32_t low, high;
  slab_of(w, slab, &low, &high);
  for (uint32_t y = 0; y < w->size[1]; ++y) {
    const weather_layer* layer = &w->tables->layers[y];
    uint16_t empty[4] = {0};
    for (uint32_t k = 0; k < layer->bubble_count; ++k) empty[k] = empty_count(&w->tables->bubbles[layer->bubbles[k]], y);
    for (uint32_t z = low; z < high; ++z) {
      uint16_t* to = w->counts + w->count_row * y + w->count_plane * z;
      const size_t row = weather_row(w, (int32_t)y, (int32_t)z);
      memset(w->solid + row, 0, w->words * sizeof(uint64_t));
      *weather_row_flag(w, y, z) = 1;
      for (uint32_t x = 0; x < w->size[0]; ++x) {
        const uint32_t which = layer->bubble_count == 1 ? 0
                                                        : (uint32_t)weather_bit(w->mixture[0], row, x) +
                                                              2 * (uint32_t)weather_bit(w->mixture[1], row, x);
        to[x] = empty[which];
      }
    }
  }
}

void weather_clear_counts(scree_weather* w) {
  weather_parallel(w, w->bricks[2], clear_slab, w);
}

/* The first set bit, or with `flip` all bits the first clear one, from `at` on; the end of the words where there is none. */
static uint32_t find_bit(const uint64_t* bits, uint32_t words, uint32_t at, uint64_t flip) {
  for (uint32_t i = at / 64; i < words; ++i) {
    const uint64_t word = (bits[i] ^ flip) & (i == at / 64 ? ~(uint64_t)0 << (at % 64) : ~(uint64_t)0);
    if (word != 0) return i * 64 + (uint32_t)__builtin_ctzll(word);
  }
  return words * 64;
}

/* All runs of set bits of a row. */
static void scatter_row(const scree_weather* w, const uint64_t* bits, uint32_t y, uint32_t z, uint32_t low, uint32_t high,
                        int32_t sign) {
  for (uint32_t x = find_bit(bits, w->words, 0, 0); x < w->words * 64;) {
    const uint32_t end = find_bit(bits, w->words, x, ~(uint64_t)0);
    w->kernels->scatter(w, x, end - x, (int32_t)y, (int32_t)z, (int32_t)low, (int32_t)high, sign);
    x = find_bit(bits, w->words, end, 0);
  }
}

/* Each slab takes what reaches its own planes, from its neighbours' changes too, so that no two write the same counts. */
static void scatter_slab(void* context, uint32_t slab, uint32_t worker) {
  (void)worker;
  const scree_weather* w = context;
  uint32_t low, high;
  slab_of(w, slab, &low, &high);
  const uint32_t reach = (uint32_t)w->tables->reach;
  const uint32_t first = low > reach ? low - reach : 0, end = w->size[2] - high > reach ? high + reach : w->size[2];
  for (uint32_t z = first; z < end; ++z)
    for (uint32_t y = 0; y < w->size[1]; ++y) {
      if (*weather_row_flag(w, y, z) == 0) continue;
      const size_t row = weather_row(w, (int32_t)y, (int32_t)z);
      uint64_t gone[65], come[65], any_gone = 0, any_come = 0;
      for (uint32_t i = 0; i < w->words; ++i) {
        const uint64_t now = w->rock[row + i] | w->colluvium[row + i], before = w->solid[row + i];
        any_gone |= gone[i] = before & ~now;
        any_come |= come[i] = now & ~before;
      }
      if (any_gone != 0) scatter_row(w, gone, y, z, low, high, 1);
      if (any_come != 0) scatter_row(w, come, y, z, low, high, -1);
    }
}

static void settle_slab(void* context, uint32_t slab, uint32_t worker) {
  (void)worker;
  scree_weather* w = context;
  uint32_t low, high;
  slab_of(w, slab, &low, &high);
  for (uint32_t z = low; z < high; ++z)
    for (uint32_t y = 0; y < w->size[1]; ++y) {
      if (*weather_row_flag(w, y, z) == 0) continue;
      *weather_row_flag(w, y, z) = 0;
      const size_t row = weather_row(w, (int32_t)y, (int32_t)z);
      for (uint32_t i = 0; i < w->words; ++i) {
        const uint64_t now = w->rock[row + i] | w->colluvium[row + i], changed = now ^ w->solid[row + i];
        w->solid[row + i] = now;
        for (uint32_t x = 0; changed != 0 && x < 64; x += WEATHER_BRICK)
          if ((changed >> x & 0xffff) != 0) w->stamps[weather_brick(w, i * 64 + x, y, z)] = w->change;
      }
    }
}

void weather_update_counts(scree_weather* w) {
  weather_parallel(w, w->bricks[2], scatter_slab, w);
  weather_parallel(w, w->bricks[2], settle_slab, w);
}
