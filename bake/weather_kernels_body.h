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
  return (v_set_int((int32_t)bits) & each) == each;
}

/* table[index], lane by lane, of a table of eight. */
static inline vfloat pick(const float table[8], vint index) {
#ifdef __AVX2__
  return (vfloat)_mm256_permutevar8x32_ps((__m256)v_load(table), (__m256i)index);
#else
  return v_gather(table, index);
#endif
}

/* GCC 12 does not find these by itself. */
static inline vint least_int(vint a, vint b) {
#ifdef __AVX2__
  return (vint)_mm256_min_epi32((__m256i)a, (__m256i)b);
#else
  return v_select_int(a < b, a, b);
#endif
}

static inline vint widen_counts(const uint16_t* from) {
#ifdef __AVX2__
  return (vint)_mm256_cvtepu16_epi32(_mm_loadu_si128((const __m128i*)(const void*)from));
#else
  vhalf counts;
  memcpy(&counts, from, sizeof counts);
  return __builtin_convertvector(counts, vint);
#endif
}

static inline vfloat widen_noise(const int8_t* from) {
#ifdef __AVX2__
  return (vfloat)_mm256_cvtepi32_ps(_mm256_cvtepi8_epi32(_mm_loadl_epi64((const __m128i*)(const void*)from)));
#else
  vbyte noise;
  memcpy(&noise, from, sizeof noise);
  return __builtin_convertvector(noise, vfloat);
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

enum { AHEAD = 6 }; /* rows: too far for the processor to guess */

/* One row of voxels and its layer. */
typedef struct row_context {
  int32_t* life;
  const int8_t* noise;
  const uint16_t* counts;
  uint32_t* stamps;
  const float *rates, *exposure;
  float graph, amplitude, colluvium;
  uint32_t firsts[4]; /* of the rates of each bubble of the layer */
  int32_t last;       /* of all rates */
  bool mixed;
} row_context;

/* Lives are ints, shares of them floats: the same operations, in the same order, for one voxel and for eight. Returns whether the
 * voxel died; *worn grows where its life changed. */
static inline bool wear_one(const row_context* row, uint32_t x, uint32_t faces, bool colluvium, uint32_t first, uint32_t* worn) {
  const float rate = row->rates[first + row->counts[x]] * row->exposure[faces];
  const float factor = 1 + row->amplitude * ((float)row->noise[x] * (1.0f / 127));
  const float rock = row->graph * (factor > 1.0f / 16 ? factor : 1.0f / 16);
  const float share = rate / (colluvium ? row->colluvium : rock);
  const int32_t taken = (int32_t)(share < WEATHER_FULL ? share : WEATHER_FULL), life = row->life[x] - taken;
  row->life[x] = life > 0 ? life : 0;
  *worn |= (uint32_t)taken;
  return life <= 0;
}

/* Eight voxels from x on. `faces` is 0 for those that are not active: nothing is taken from them. Returns the bits of those that
 * have no life left, air among them. */
static inline uint32_t wear_eight(const row_context* row, uint32_t x, vint faces, uint64_t colluvium, vint first, uint32_t* worn) {
  vint life;
  memcpy(&life, row->life + x, sizeof life);
  /* What is not active may lie in the margin, where counts mean nothing. */
  const vint index = least_int(widen_counts(row->counts + x) + first, v_set_int(row->last));
  const vfloat rate = v_gather(row->rates, index) * pick(row->exposure, faces);
  const vfloat factor = v_set(1) + v_set(row->amplitude) * (widen_noise(row->noise + x) * v_set(1.0f / 127));
  vfloat durability = v_set(row->graph) * v_max(factor, v_set(1.0f / 16));
  if ((colluvium & 255) != 0) durability = v_select(lanes_of(colluvium), v_set(row->colluvium), durability);
  const vint taken = v_truncate(v_min(rate / durability, v_set(WEATHER_FULL)));
  life -= taken;
  const vint dead = life < v_set_int(1);
  life &= ~dead;
  memcpy(row->life + x, &life, sizeof life);
  *worn |= v_bits(taken > v_set_int(0));
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

/* Where a surface is steep, the next of it lies in the rows ahead. */
static inline void fetch_ahead(const scree_weather* w, const row_context* row, uint32_t x) {
  __builtin_prefetch(row->life + x + (size_t)AHEAD * w->size[0], 1);
  __builtin_prefetch(row->noise + x + (size_t)AHEAD * w->size[0]);
  __builtin_prefetch(row->counts + x + AHEAD * w->count_row);
}

/* Which bubble of a mixture. */
static inline uint32_t bubble_of(const scree_weather* w, size_t at, uint32_t bit) {
  return (uint32_t)(w->mixture[0][at] >> bit & 1) + 2 * (uint32_t)(w->mixture[1][at] >> bit & 1);
}

static inline vint firsts_of(const scree_weather* w, const row_context* row, size_t at, uint32_t from) {
  const vint one = lanes_of(w->mixture[0][at] >> from), two = lanes_of(w->mixture[1][at] >> from);
  const vint low = v_select_int(one, v_set_int((int32_t)row->firsts[1]), v_set_int((int32_t)row->firsts[0]));
  return v_select_int(two, v_select_int(one, v_set_int((int32_t)row->firsts[3]), v_set_int((int32_t)row->firsts[2])), low);
}

/* The active voxels of one word, from x on. Many eights hold but one, where the surface is steep. */
static inline uint64_t wear_word(const scree_weather* w, const row_context* row, size_t at, uint32_t x, uint64_t active,
                                 const uint64_t faces[3]) {
  const uint64_t colluvium = w->colluvium[at];
  uint64_t dead = 0, left = active;
  do {
    const uint32_t bit = (uint32_t)__builtin_ctzll(left), from = bit & ~7u;
    uint32_t worn = 0;
    if ((left >> from & 255 & ((left >> from) - 1)) == 0) {
      const uint32_t shown =
          (uint32_t)(faces[0] >> bit & 1) + 2 * (uint32_t)(faces[1] >> bit & 1) + 4 * (uint32_t)(faces[2] >> bit & 1);
      const uint32_t first = row->firsts[row->mixed ? bubble_of(w, at, bit) : 0];
      fetch_ahead(w, row, x + bit);
      dead |= (uint64_t)wear_one(row, x + bit, shown, (colluvium >> bit & 1) != 0, first, &worn) << bit;
    } else {
      const vint shown = (lanes_of(faces[0] >> from) & 1) | (lanes_of(faces[1] >> from) & 2) | (lanes_of(faces[2] >> from) & 4);
      const vint first = row->mixed ? firsts_of(w, row, at, from) : v_set_int((int32_t)row->firsts[0]);
      dead |= (uint64_t)wear_eight(row, x + from, shown, colluvium >> from, first, &worn) << from;
    }
    if (worn != 0) row->stamps[(x + from) / WEATHER_BRICK] = w->change;
    left &= ~((uint64_t)255 << from);
  } while (left != 0);
  return dead & active;
}

/* A word with a single active voxel, of which steep surfaces have many. */
static inline uint64_t wear_lone(const scree_weather* w, const row_context* row, size_t at, uint32_t x, uint64_t active,
                                 const uint64_t* s, ptrdiff_t up, ptrdiff_t front) {
  const uint32_t bit = (uint32_t)__builtin_ctzll(active);
  const uint64_t left = *s << 1 | s[-1] >> 63, right = *s >> 1 | s[1] << 63;
  const uint64_t solid = (left >> bit & 1) + (right >> bit & 1) + (s[-up] >> bit & 1) + (s[up] >> bit & 1) +
                         (s[-front] >> bit & 1) + (s[front] >> bit & 1);
  const uint32_t first = row->firsts[row->mixed ? bubble_of(w, at, bit) : 0];
  uint32_t worn = 0;
  fetch_ahead(w, row, x + bit);
  const bool dead = wear_one(row, x + bit, 6 - (uint32_t)solid, (w->colluvium[at] & active) != 0, first, &worn);
  if (worn != 0) row->stamps[(x + bit) / WEATHER_BRICK] = w->change;
  return dead ? active : 0;
}

static inline void enter_row(const scree_weather* w, uint32_t y, uint32_t z, row_context* row) {
  const weather_tables* t = w->tables;
  const weather_layer* layer = &t->layers[y];
  row->life = w->life + weather_at(w, 0, y, z);
  row->noise = w->noise + weather_at(w, 0, y, z);
  row->counts = w->counts + w->count_row * y + w->count_plane * z;
  row->stamps = w->stamps + weather_brick(w, 0, y, z);
  row->graph = layer->graph;
  row->amplitude = layer->amplitude;
  row->colluvium = layer->colluvium;
  row->mixed = layer->bubble_count > 1;
  row->firsts[0] = t->bubbles[layer->bubbles[0]].rate_first;
  for (uint32_t k = 1; k < layer->bubble_count; ++k) row->firsts[k] = t->bubbles[layer->bubbles[k]].rate_first;
}

/* Marks the voxels of a plane that touch air, in `scratch`, word by word through its rows. */
static void mark_active(const scree_weather* w, uint32_t z) {
  const size_t first = weather_row(w, 0, (int32_t)z), count = (size_t)w->words * w->size[1];
  const uint64_t *s = w->solid + first, *above = s + w->words, *below = s - w->words, *front = s + w->bit_plane,
                 *back = s - w->bit_plane;
  uint64_t* to = w->scratch + first;
  for (size_t i = 0; i < count; ++i) {
    const uint64_t left = s[i] << 1 | *(s + i - 1) >> 63, right = s[i] >> 1 | s[i + 1] << 63;
    to[i] = s[i] & ~(left & right & above[i] & below[i] & front[i] & back[i]);
  }
}

static void sweep(scree_weather* w, uint32_t z, uint64_t step_key, weather_tally* tally) {
  const uint32_t words = w->words, layers = w->size[1];
  const ptrdiff_t up = (ptrdiff_t)words, front = (ptrdiff_t)w->bit_plane;
  row_context row = {.rates = w->tables->rates, .exposure = w->tables->exposure, .last = (int32_t)w->tables->rate_count - 1};
  mark_active(w, z);
  size_t at = weather_row(w, 0, (int32_t)z);
  for (uint32_t y = 0; y < layers; ++y) {
    bool entered = false;
    for (uint32_t i = 0; i < words; ++i, ++at) {
      const uint64_t active = w->scratch[at];
      if (active == 0) continue;
      if (!entered) enter_row(w, y, z, &row);
      entered = true;
      const uint64_t* s = w->solid + at;
      uint64_t dead;
      if ((active & (active - 1)) == 0)
        dead = wear_lone(w, &row, at, i * 64, active, s, up, front);
      else {
        const uint64_t air[6] = {~(*s << 1 | s[-1] >> 63), ~(*s >> 1 | s[1] << 63), ~s[-up], ~s[up], ~s[-front], ~s[front]};
        uint64_t faces[3];
        add_faces(air, faces);
        for (int k = 0; k < 3; ++k) faces[k] &= active;
        dead = wear_word(w, &row, at, i * 64, active, faces);
      }
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
 * a place, stays, falls by one a place. Lanes from `at` on; those past the end are 0. */
static inline vcount span_lanes(int32_t length, int32_t half, int32_t at, vshort sign) {
  const vshort lanes = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}, zero = {0};
  const int32_t total = length + 2 * half, width = 2 * half + 1;
  const vshort most = zero + (int16_t)(length < width ? length : width);
  const vshort rise = lanes + (int16_t)(at + 1), fall = (int16_t)(total - at) - lanes;
  const vshort value = v_least(v_least(rise, fall), most) & (fall > zero);
  return (vcount)((value ^ sign) - sign);
}

static inline void add_lanes(uint16_t* to, vcount value) {
  vcount old;
  memcpy(&old, to, sizeof old);
  old += value;
  memcpy(to, &old, sizeof old);
}

/* The spans of one run for every width of bubble rows, as far as two vectors hold them. */
typedef struct span_set {
  vcount lanes[WEATHER_MARGIN + 1][2];
  int32_t length;
  vshort sign;
} span_set;

static inline void make_spans(int32_t length, int32_t reach, vshort sign, span_set* out) {
  out->length = length;
  out->sign = sign;
  for (int32_t half = 0; half <= reach; ++half) {
    out->lanes[half][0] = span_lanes(length, half, 0, sign);
    if (length + 2 * half > SPAN) out->lanes[half][1] = span_lanes(length, half, SPAN, sign);
  }
}

static inline void add_span(uint16_t* to, const span_set* spans, int32_t half) {
  const int32_t total = spans->length + 2 * half;
  add_lanes(to - half, spans->lanes[half][0]);
  if (total <= SPAN) return;
  add_lanes(to - half + SPAN, spans->lanes[half][1]);
  if (total <= 2 * SPAN) return;
  /* A long run: its bubble rows are full but for the two ends. */
  const vcount full = (vcount)((((vshort){0} + (int16_t)(2 * half + 1)) ^ spans->sign) - spans->sign);
  for (int32_t at = 2 * SPAN; at < total; at += SPAN)
    add_lanes(to - half + at, at + SPAN <= spans->length ? full : span_lanes(spans->length, half, at, spans->sign));
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
  const int32_t first = z - t->reach > z_low ? z - t->reach : z_low, last = z + t->reach < z_high ? z + t->reach : z_high - 1;
  const int32_t low = y - t->reach > 0 ? y - t->reach : 0;
  const int32_t high = y + t->reach < (int32_t)w->size[1] ? y + t->reach : (int32_t)w->size[1] - 1;
  const bool alike = t->bubble_count == 1 && !t->mixed, short_run = (int32_t)length + 2 * t->reach <= SPAN;
  span_set spans;
  const int16_t flip = sign < 0 ? -1 : 0;
  make_spans((int32_t)length, t->reach, (vshort){0} + flip, &spans);
  for (int32_t to_z = first; to_z <= last; ++to_z) {
    uint16_t* to = w->counts + w->count_plane * (size_t)to_z + w->count_row * (size_t)low + x;
    if (alike && short_run) {
      const int8_t* half = &t->bubbles[0].half[z - to_z + WEATHER_MARGIN][y - low + WEATHER_MARGIN];
      for (int32_t to_y = low; to_y <= high; ++to_y, to += w->count_row, --half)
        if (*half >= 0) add_lanes(to - *half, spans.lanes[*half][0]);
      continue;
    }
    if (alike) {
      const int8_t* half = &t->bubbles[0].half[z - to_z + WEATHER_MARGIN][y - low + WEATHER_MARGIN];
      for (int32_t to_y = low; to_y <= high; ++to_y, to += w->count_row, --half)
        if (*half >= 0) add_span(to, &spans, *half);
      continue;
    }
    for (int32_t to_y = low; to_y <= high; ++to_y, to += w->count_row) {
      const weather_layer* layer = &t->layers[to_y];
      for (uint32_t k = 0; k < layer->bubble_count; ++k) {
        const int32_t half = t->bubbles[layer->bubbles[k]].half[z - to_z + WEATHER_MARGIN][y - to_y + WEATHER_MARGIN];
        if (half < 0) continue;
        if (layer->bubble_count == 1)
          add_span(to, &spans, half);
        else
          add_span_mixed(w, k, (int32_t)x, length, to_y, to_z, half, sign);
      }
    }
  }
}

const weather_kernels KERNELS_TABLE = {KERNELS_NAME, sweep, scatter};
