/* The kernels themselves, included by weather_kernels_plain.c and weather_kernels_avx2.c with KERNELS_TABLE and KERNELS_NAME set.
 */
#include <string.h>

#include "weather_counts.h"
#include "weather_kernels.h"
#include "weather_step.h"

#define LANES 8
#define SIMD_WIDTH LANES
#include "simd.h"

typedef int8_t vbyte __attribute__((vector_size(LANES)));
typedef uint16_t vhalf __attribute__((vector_size(2 * LANES)));

/* --- sweep ------------------------------------------------------------------------------------------------------------------- */

/* Bit i of the low byte to all bits of lane i. */
static inline vint lanes_of(uint64_t bits) {
  const vint each = {1, 2, 4, 8, 16, 32, 64, 128};
  return (v_set_int((int32_t)(bits & 255)) & each) != v_set_int(0);
}

/* table[index], lane by lane, of a table of eight. */
static inline vfloat pick(const float table[8], vint index) {
#ifdef __AVX2__
  return (vfloat)_mm256_permutevar8x32_ps((__m256)v_load(table), (__m256i)index);
#else
  return v_gather(table, index);
#endif
}

/* How many of the six faces of each of 64 voxels show air, in binary: bit i of faces[0] + 2 faces[1] + 4 faces[2]. */
static inline void add_faces(const uint64_t air[6], uint64_t faces[3]) {
  const uint64_t low = air[0] ^ air[1] ^ air[2], high = air[3] ^ air[4] ^ air[5];
  const uint64_t a = (air[0] & air[1]) | (air[2] & (air[0] | air[1])), b = (air[3] & air[4]) | (air[5] & (air[3] | air[4]));
  const uint64_t c = low & high;
  faces[0] = low ^ high;
  faces[1] = a ^ b ^ c;
  faces[2] = (a & b) | (c & (a | b));
}

/* Eight voxels of one row. */
typedef struct octet {
  int32_t* life;
  const int8_t* noise;
  const uint16_t* counts;
  uint32_t active, colluvium; /* a bit each */
  vint faces;
  vint first; /* of the rates of each one's bubble */
} octet;

/* Returns the bits of those that died; *worn is set where a life changed. */
static inline uint32_t wear(const octet* o, const weather_layer* layer, const weather_tables* tables, bool* worn) {
  const vint active = lanes_of(o->active);
  vhalf counts;
  vbyte noise;
  vint life;
  memcpy(&counts, o->counts, sizeof counts);
  memcpy(&noise, o->noise, sizeof noise);
  memcpy(&life, o->life, sizeof life);
  /* What is not active may lie in the margin, where counts mean nothing. */
  const vint index = (__builtin_convertvector(counts, vint) + o->first) & active;
  const vfloat rate = v_gather(tables->rates, index) * pick(tables->exposure, o->faces);
  const vfloat factor = v_set(1) + v_set(layer->amplitude) * (__builtin_convertvector(noise, vfloat) * v_set(1.0f / 127));
  const vfloat rock = v_set(layer->graph) * v_max(factor, v_set(1.0f / 16));
  const vfloat durability = v_select(lanes_of(o->colluvium), v_set(layer->colluvium), rock);
  const vint taken = v_truncate(v_min(rate / durability, v_set(WEATHER_FULL))) & active;
  life -= taken;
  const vint dead = (life <= v_set_int(0)) & active;
  life &= ~dead;
  memcpy(o->life, &life, sizeof life);
  *worn = v_bits(taken != v_set_int(0)) != 0;
  return v_bits(dead);
}

static void bury_dead(scree_weather* w, uint32_t word, uint32_t y, uint32_t z, uint64_t dead, uint64_t step_key,
                      weather_tally* tally) {
  const size_t at = weather_row(w, (int32_t)y, (int32_t)z) + word;
  const uint64_t rock = dead & w->rock[at];
  *weather_row_flag(w, y, z) = 1;
  w->rock[at] &= ~dead;
  w->colluvium[at] &= ~dead;
  tally->rock += (uint64_t)__builtin_popcountll(rock);
  tally->colluvium += (uint64_t)__builtin_popcountll(dead & ~rock);
  if (w->tables->share == 0) return;
  for (uint64_t left = rock; left != 0; left &= left - 1) {
    const uint32_t bit = (uint32_t)__builtin_ctzll(left);
    if (!weather_becomes_colluvium(w->tables, weather_hash(step_key, word * 64 + bit, y, z))) continue;
    w->grains[at] |= (uint64_t)1 << bit;
    ++tally->grains;
  }
}

/* The active voxels of one word. */
static inline uint64_t wear_word(scree_weather* w, uint32_t word, uint32_t y, uint32_t z, uint64_t active,
                                 const uint64_t faces[3]) {
  const weather_layer* layer = &w->tables->layers[y];
  const size_t at = weather_row(w, (int32_t)y, (int32_t)z) + word;
  const uint64_t colluvium = w->colluvium[at];
  const bool mixed = layer->bubble_count > 1;
  const uint64_t low = mixed ? w->mixture[0][at] : 0, high = mixed ? w->mixture[1][at] : 0;
  vint firsts[4];
  for (uint32_t k = 0; k < 4; ++k) firsts[k] = v_set_int((int32_t)w->tables->bubbles[layer->bubbles[k]].rate_first);
  uint64_t dead = 0;
  for (uint32_t from = 0; from < 64; from += LANES) {
    octet o;
    o.active = (uint32_t)(active >> from) & 255;
    if (o.active == 0) continue;
    const uint32_t x = word * 64 + from;
    o.life = w->life + weather_at(w, x, y, z);
    o.noise = w->noise + weather_at(w, x, y, z);
    o.counts = w->counts + x + w->count_row * y + w->count_plane * z;
    o.colluvium = (uint32_t)(colluvium >> from) & 255;
    o.faces = (lanes_of(faces[0] >> from) & 1) | (lanes_of(faces[1] >> from) & 2) | (lanes_of(faces[2] >> from) & 4);
    o.first = firsts[0];
    if (mixed) {
      const vint one = lanes_of(low >> from), two = lanes_of(high >> from);
      o.first = v_select_int(two, v_select_int(one, firsts[3], firsts[2]), v_select_int(one, firsts[1], firsts[0]));
    }
    bool worn;
    dead |= (uint64_t)wear(&o, layer, w->tables, &worn) << from;
    if (worn) w->stamps[weather_brick(w, x, y, z)] = w->change;
  }
  return dead;
}

static void sweep(scree_weather* w, uint32_t z, uint64_t step_key, weather_tally* tally) {
  for (uint32_t y = 0; y < w->size[1]; ++y) {
    const uint64_t* s = w->solid + weather_row(w, (int32_t)y, (int32_t)z);
    for (uint32_t i = 0; i < w->words; ++i, ++s) {
      if (*s == 0) continue;
      const uint64_t air[6] = {~(*s << 1 | *(s - 1) >> 63), ~(*s >> 1 | s[1] << 63), ~*(s - w->words), ~s[w->words],
                               ~*(s - w->bit_plane),        ~s[w->bit_plane]};
      const uint64_t active = *s & (air[0] | air[1] | air[2] | air[3] | air[4] | air[5]);
      if (active == 0) continue;
      uint64_t faces[3];
      add_faces(air, faces);
      const uint64_t dead = wear_word(w, i, y, z, active, faces);
      if (dead != 0) bury_dead(w, i, y, z, dead, step_key, tally);
    }
  }
}

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

const weather_kernels KERNELS_TABLE = {KERNELS_NAME, sweep, scatter};
