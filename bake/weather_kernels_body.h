/* The kernels themselves, included by weather_kernels_plain.c and weather_kernels_avx2.c with KERNELS_TABLE and KERNELS_NAME set.
 */
#include <string.h>

#include "weather_kernels.h"

#ifdef __AVX2__
#include <immintrin.h>
#endif

/* --- counts ------------------------------------------------------------------------------------------------------------------ */

#define SPAN 16 /* lanes */

typedef int16_t vshort __attribute__((vector_size(2 * SPAN)));
typedef uint16_t vcount __attribute__((vector_size(2 * SPAN)));

static inline vshort v_least(vshort a, vshort b) {
#ifdef __AVX2__
  return (vshort)_mm256_min_epi16((__m256i)a, (__m256i)b);
#else
  const vshort less = a < b;
  return (a & less) | (b & ~less);
#endif
}

/* A bubble row of width 2 half + 1 slides over a run: how many voxels of the run each of length + 2 half places holds rises by one
 * a place, stays, falls by one a place. Lanes past the end add 0. */
static inline void add_span(uint16_t* to, int32_t length, int32_t half, vshort sign) {
  const vshort lanes = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}, zero = {0};
  const int32_t total = length + 2 * half, width = 2 * half + 1;
  const vshort most = zero + (int16_t)(length < width ? length : width);
  for (int32_t at = 0; at < total; at += SPAN) {
    const vshort rise = lanes + (int16_t)(at + 1), fall = (int16_t)(total - at) - lanes;
    vshort value = v_least(v_least(rise, fall), most);
    vcount old;
    value &= fall > zero;
    memcpy(&old, to + at, sizeof old);
    old += (vcount)((value ^ sign) - sign);
    memcpy(to + at, &old, sizeof old);
  }
}

/* The same where neighbours in a row look through different bubbles: only those with bubble number `which` of the mixture. */
static void add_span_mixed(const scree_weather* w, uint32_t which, int32_t x, uint32_t length, int32_t y, int32_t z, int32_t half,
                           int32_t sign) {
  const size_t row = weather_row(w, y, z);
  const int32_t total = (int32_t)length + 2 * half, width = 2 * half + 1;
  const int32_t most = (int32_t)length < width ? (int32_t)length : width;
  for (int32_t i = 0; i < total; ++i) {
    const int32_t at = x - half + i;
    if (at < 0 || at >= (int32_t)w->size[0]) continue;
    const uint32_t bubble =
        (uint32_t)weather_bit(w->mixture[0], row, (uint32_t)at) + 2 * (uint32_t)weather_bit(w->mixture[1], row, (uint32_t)at);
    if (bubble != which) continue;
    int32_t value = i + 1 < total - i ? i + 1 : total - i;
    if (value > most) value = most;
    uint16_t* to = w->counts + (size_t)at + w->count_row * (size_t)y + w->count_plane * (size_t)z;
    *to = (uint16_t)(*to + sign * value);
  }
}

static void scatter(const scree_weather* w, uint32_t x, uint32_t length, int32_t y, int32_t z, int32_t z_low, int32_t z_high,
                    int32_t sign) {
  const weather_tables* t = w->tables;
  const vshort signs = (vshort){0} + (int16_t)(sign < 0 ? -1 : 0);
  const int32_t first = z - t->reach > z_low ? z - t->reach : z_low, last = z + t->reach < z_high ? z + t->reach : z_high - 1;
  const int32_t low = y - t->reach > 0 ? y - t->reach : 0;
  const int32_t high = y + t->reach < (int32_t)w->size[1] ? y + t->reach : (int32_t)w->size[1] - 1;
  const bool alike = t->bubble_count == 1 && !t->mixed;
  for (int32_t to_z = first; to_z <= last; ++to_z) {
    uint16_t* plane = w->counts + w->count_plane * (size_t)to_z + x;
    if (alike) {
      const int8_t* half = t->bubbles[0].half[z - to_z + WEATHER_MARGIN];
      for (int32_t to_y = low; to_y <= high; ++to_y) {
        const int32_t h = half[y - to_y + WEATHER_MARGIN];
        if (h >= 0) add_span(plane + w->count_row * (size_t)to_y - h, (int32_t)length, h, signs);
      }
      continue;
    }
    for (int32_t to_y = low; to_y <= high; ++to_y) {
      const weather_layer* layer = &t->layers[to_y];
      for (uint32_t k = 0; k < layer->bubble_count; ++k) {
        const int32_t h = t->bubbles[layer->bubbles[k]].half[z - to_z + WEATHER_MARGIN][y - to_y + WEATHER_MARGIN];
        if (h < 0) continue;
        if (layer->bubble_count == 1)
          add_span(plane + w->count_row * (size_t)to_y - h, (int32_t)length, h, signs);
        else
          add_span_mixed(w, k, (int32_t)x, length, to_y, to_z, h, sign);
      }
    }
  }
}

const weather_kernels KERNELS_TABLE = {KERNELS_NAME, scatter};
