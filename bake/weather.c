/* Based on: Beardall et al., Goblins by Spheroidal Weathering, 2007; Jones et al., Directable Weathering of Concave Rock Using
 * Curvature Estimation, 2010. Where we differ: voxels are bits, the air of every bubble is kept counted for all voxels, only
 * exposed voxels weather and by how many faces they show, and curves may saturate. */
#include <math.h>
#include <string.h>

#include "faults.h"
#include "lattice.h"
#include "support_text.h"
#include "weather_counts.h"
#include "weather_kernels.h"
#include "weather_rules.h"
#include "weather_start.h"

/* --- memory ------------------------------------------------------------------------------------------------------------------ */

/* Sizes of all arrays, in elements, in 64 bits: a grid may be too large for any machine. */
typedef struct extent {
  uint64_t words, bit_plane, bits, rows, voxel_plane, voxels, count_row, count_plane, counts, bricks, slabs;
} extent;

static extent measure(const uint32_t size[3]) {
  extent e;
  e.words = size[0] / 64 + 1;
  e.bit_plane = e.words * (size[1] + 2u);
  e.bits = e.bit_plane * (size[2] + 2u) + 8;
  e.rows = (uint64_t)size[1] * size[2];
  e.voxel_plane = (uint64_t)size[0] * size[1] + 16;
  e.voxels = e.voxel_plane * size[2];
  e.count_row = size[0] + WEATHER_MARGIN;
  e.count_plane = e.count_row * size[1] + 32;
  /* Planes whose distance is a multiple of 4096 bytes push each other out of the first-level cache. */
  const uint64_t apart = e.count_plane * sizeof(uint16_t) % 4096;
  if (apart < 512 || apart > 4096 - 512) e.count_plane += 1024 / sizeof(uint16_t);
  e.counts = e.count_plane * size[2] + 64;
  e.slabs = (size[2] + WEATHER_BRICK - 1u) / WEATHER_BRICK;
  e.bricks =
      (uint64_t)((size[0] + WEATHER_BRICK - 1u) / WEATHER_BRICK) * ((size[1] + WEATHER_BRICK - 1u) / WEATHER_BRICK) * e.slabs;
  return e;
}

static uint64_t bytes_of(const extent* e, bool mixed) {
  return sizeof(scree_weather) + e->bits * sizeof(uint64_t) * (mixed ? 7 : 5) + e->rows + e->voxels * (sizeof(int32_t) + 1) +
         e->counts * sizeof(uint16_t) + e->bricks * sizeof(uint32_t) + e->slabs * sizeof(weather_tally);
}

static scree_result check(const scree_weather_desc* desc, scree_error* error, uint64_t* bytes) {
  scree_rt_text_clear(error);
  if (desc->jobs.parallel_for != NULL && desc->jobs.worker_count < 1)
    return fault_value(error, "jobs.worker_count", desc->jobs.worker_count, "at least 1");
  scree_result result = weather_check_start(&desc->start, error);
  if (result == SCREE_OK) result = weather_check_rules(&desc->rules, desc->start.size, error);
  if (result != SCREE_OK) return result;
  const extent e = measure(desc->start.size);
  bool mixed;
  const size_t tables = weather_tables_bytes(&desc->rules, desc->start.size, &mixed);
  *bytes = bytes_of(&e, mixed) + tables;
  return SCREE_OK;
}

uint64_t scree_weather_memory(const scree_weather_desc* desc) {
  uint64_t bytes = 0;
  return check(desc, NULL, &bytes) == SCREE_OK ? bytes : 0;
}

static scree_result too_large(scree_error* error, const uint32_t size[3], uint64_t bytes, uint64_t limit) {
  scree_rt_text_clear(error);
  scree_rt_text_add(error, "size: ");
  for (int a = 0; a < 3; ++a) {
    scree_rt_text_add_count(error, size[a]);
    scree_rt_text_add(error, a < 2 ? " x " : " voxels take ");
  }
  scree_rt_text_add_count(error, bytes);
  scree_rt_text_add(error, " bytes, more than memory_limit, ");
  scree_rt_text_add_count(error, limit);
  return SCREE_ERROR_RANGE;
}

static scree_result too_large_rules(scree_error* error, uint64_t bytes, uint64_t limit) {
  scree_rt_text_clear(error);
  scree_rt_text_add(error, "rules: the simulation would take ");
  scree_rt_text_add_count(error, bytes);
  scree_rt_text_add(error, " bytes, more than memory_limit, ");
  scree_rt_text_add_count(error, limit);
  return SCREE_ERROR_RANGE;
}

/* --- life and death ---------------------------------------------------------------------------------------------------------- */

static void set_ground(scree_weather* w) {
  for (uint32_t z = 0; z < w->size[2]; ++z) {
    uint64_t* row = w->solid + weather_row(w, -1, (int32_t)z);
    for (uint32_t x = 0; x < w->size[0]; ++x) row[x / 64] |= (uint64_t)1 << (x % 64);
  }
}

static void set_lives(void* context, uint32_t z, uint32_t worker) {
  (void)worker;
  scree_weather* w = context;
  for (uint32_t y = 0; y < w->size[1]; ++y) {
    int32_t* life = w->life + weather_at(w, 0, y, z);
    const size_t row = weather_row(w, (int32_t)y, (int32_t)z);
    for (uint32_t x = 0; x < w->size[0]; ++x) life[x] = weather_bit(w->rock, row, x) ? WEATHER_FULL : 0;
  }
}

static uint64_t count_bits(const uint64_t* bits, size_t words) {
  uint64_t count = 0;
  for (size_t i = 0; i < words; ++i) count += (uint64_t)__builtin_popcountll(bits[i]);
  return count;
}

static void* zeroed(scree_weather* w, uint64_t count, size_t size) {
  w->memory += (size_t)count * size;
  return scree_rt_allocate_zeroed(&w->allocator, (size_t)count, size);
}

static bool allocate(scree_weather* w, const extent* e) {
  w->rock = zeroed(w, e->bits, sizeof *w->rock);
  w->colluvium = zeroed(w, e->bits, sizeof *w->colluvium);
  w->solid = zeroed(w, e->bits, sizeof *w->solid);
  w->grains = zeroed(w, e->bits, sizeof *w->grains);
  w->scratch = zeroed(w, e->bits, sizeof *w->scratch);
  w->rows = zeroed(w, e->rows, 1);
  w->life = zeroed(w, e->voxels, sizeof *w->life);
  w->noise = zeroed(w, e->voxels, sizeof *w->noise);
  w->counts = zeroed(w, e->counts, sizeof *w->counts);
  w->stamps = zeroed(w, e->bricks, sizeof *w->stamps);
  w->tally = zeroed(w, e->slabs, sizeof *w->tally);
  if (w->counts != NULL) w->counts += 16;
  bool all = w->rock != NULL && w->colluvium != NULL && w->solid != NULL && w->grains != NULL && w->scratch != NULL;
  all = all && w->rows != NULL && w->life != NULL && w->noise != NULL && w->counts != NULL && w->stamps != NULL && w->tally != NULL;
  return all;
}

/* The two bits of which bubble of a mixture, where the tables have mixtures and they are not there yet. */
static bool allocate_mixture(scree_weather* w, uint64_t* bits[2]) {
  for (int i = 0; i < 2; ++i) bits[i] = scree_rt_allocate_zeroed(&w->allocator, w->bit_count, sizeof(uint64_t));
  if (bits[0] != NULL && bits[1] != NULL) return true;
  for (int i = 0; i < 2; ++i) scree_rt_release(&w->allocator, bits[i], w->bit_count, sizeof(uint64_t));
  bits[0] = bits[1] = NULL;
  return false;
}

scree_result scree_weather_create(const scree_weather_desc* desc, scree_weather** out, scree_error* error) {
  *out = NULL;
  uint64_t bytes = 0;
  scree_result result = check(desc, error, &bytes);
  if (result != SCREE_OK) return result;
  const uint64_t limit = desc->memory_limit != 0 ? desc->memory_limit : (uint64_t)4 << 30;
  if (bytes > limit || bytes > SIZE_MAX) return too_large(error, desc->start.size, bytes, limit);

  const scree_allocator allocator = scree_rt_allocator_or_default(&desc->allocator);
  scree_weather* w = scree_rt_allocate_zeroed(&allocator, 1, sizeof *w);
  if (w == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  w->allocator = allocator;
  w->jobs = desc->jobs;
  w->kernels = weather_kernels_choose();
  w->memory_limit = (size_t)(limit < SIZE_MAX ? limit : SIZE_MAX);
  w->seed = desc->start.seed;
  memcpy(w->size, desc->start.size, sizeof w->size);
  const extent e = measure(w->size);
  w->words = (uint32_t)e.words;
  w->bit_plane = (size_t)e.bit_plane;
  w->bit_count = (size_t)e.bits;
  w->voxel_plane = (size_t)e.voxel_plane;
  w->count_row = (size_t)e.count_row;
  w->count_plane = (size_t)e.count_plane;
  w->count_count = (size_t)e.counts;
  for (int a = 0; a < 3; ++a) w->bricks[a] = (w->size[a] + WEATHER_BRICK - 1) / WEATHER_BRICK;
  w->memory = sizeof *w;
  bool memory = allocate(w, &e);
  if (memory && weather_tables_create(&desc->rules, w->size, &allocator, &w->tables) == SCREE_OK)
    w->memory += w->tables->bytes;
  else
    memory = false;
  if (memory && w->tables->mixed) {
    memory = allocate_mixture(w, w->mixture);
    w->memory += 2 * w->bit_count * sizeof(uint64_t);
  }
  if (!memory) {
    scree_weather_destroy(w);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }

  weather_fill_start(w, &desc->start);
  w->start_rock = w->rock_count = count_bits(w->rock, w->bit_count);
  if (w->start_rock == 0) {
    scree_weather_destroy(w);
    scree_rt_text_clear(error);
    scree_rt_text_add(error, "start: no voxel is rock");
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  w->change = 1;
  w->may_hang = true;
  set_ground(w);
  weather_parallel(w, w->size[2], set_lives, w);
  weather_fill_noise(w);
  if (w->tables->mixed) weather_fill_mixture(w);
  weather_clear_counts(w);
  weather_update_counts(w);
  *out = w;
  return SCREE_OK;
}

void scree_weather_destroy(scree_weather* w) {
  if (w == NULL) return;
  const scree_allocator allocator = w->allocator;
  const extent e = measure(w->size);
  scree_rt_release(&allocator, w->rock, (size_t)e.bits, sizeof *w->rock);
  scree_rt_release(&allocator, w->colluvium, (size_t)e.bits, sizeof *w->colluvium);
  scree_rt_release(&allocator, w->solid, (size_t)e.bits, sizeof *w->solid);
  scree_rt_release(&allocator, w->grains, (size_t)e.bits, sizeof *w->grains);
  scree_rt_release(&allocator, w->scratch, (size_t)e.bits, sizeof *w->scratch);
  for (int i = 0; i < 2; ++i) scree_rt_release(&allocator, w->mixture[i], (size_t)e.bits, sizeof(uint64_t));
  scree_rt_release(&allocator, w->rows, (size_t)e.rows, 1);
  scree_rt_release(&allocator, w->life, (size_t)e.voxels, sizeof *w->life);
  scree_rt_release(&allocator, w->noise, (size_t)e.voxels, sizeof *w->noise);
  scree_rt_release(&allocator, w->counts != NULL ? w->counts - 16 : NULL, (size_t)e.counts, sizeof *w->counts);
  scree_rt_release(&allocator, w->stamps, (size_t)e.bricks, sizeof *w->stamps);
  scree_rt_release(&allocator, w->tally, (size_t)e.slabs, sizeof *w->tally);
  weather_tables_destroy(w->tables, &allocator);
  scree_rt_release(&allocator, w, 1, sizeof *w);
}

scree_result scree_weather_set_rules(scree_weather* w, const scree_weather_rules* rules, scree_error* error) {
  scree_rt_text_clear(error);
  scree_result result = weather_check_rules(rules, w->size, error);
  if (result != SCREE_OK) return result;
  bool mixed;
  const uint64_t mixture = 2 * w->bit_count * sizeof(uint64_t);
  uint64_t bytes = w->memory - w->tables->bytes + weather_tables_bytes(rules, w->size, &mixed);
  if (mixed && w->mixture[0] == NULL) bytes += mixture;
  if (bytes > w->memory_limit) return too_large_rules(error, bytes, w->memory_limit);
  weather_tables* tables;
  result = weather_tables_create(rules, w->size, &w->allocator, &tables);
  if (result != SCREE_OK) return result;
  if (tables->mixed && w->mixture[0] == NULL) {
    if (!allocate_mixture(w, w->mixture)) {
      weather_tables_destroy(tables, &w->allocator);
      return SCREE_ERROR_OUT_OF_MEMORY;
    }
    w->memory += (size_t)mixture;
  }
  weather_tables* before = w->tables;
  w->tables = tables;
  w->may_hang = true;
  w->memory += tables->bytes;
  w->memory -= before->bytes;
  ++w->change;
  for (size_t i = 0; i < (size_t)w->bricks[0] * w->bricks[1] * w->bricks[2]; ++i) w->stamps[i] = w->change;
  if (!weather_same_noise(before, tables, w->size[1])) {
    ++w->noise_version;
    weather_fill_noise(w);
  }
  if (!weather_same_bubbles(before, tables, w->size[1])) {
    if (tables->mixed) weather_fill_mixture(w);
    weather_clear_counts(w);
    weather_update_counts(w);
  }
  weather_tables_destroy(before, &w->allocator);
  return SCREE_OK;
}

/* --- what there is ----------------------------------------------------------------------------------------------------------- */

static uint64_t count_active(const scree_weather* w) {
  uint64_t active = 0;
  for (uint32_t z = 0; z < w->size[2]; ++z)
    for (uint32_t y = 0; y < w->size[1]; ++y) {
      const uint64_t* s = w->solid + weather_row(w, (int32_t)y, (int32_t)z);
      for (uint32_t i = 0; i < w->words; ++i, ++s) {
        const uint64_t buried = (*s << 1 | s[-1] >> 63) & (*s >> 1 | s[1] << 63) & s[-(ptrdiff_t)w->words] & s[w->words] &
                                s[-(ptrdiff_t)w->bit_plane] & s[w->bit_plane];
        active += (uint64_t)__builtin_popcountll(*s & ~buried);
      }
    }
  return active;
}

void scree_weather_get_stats(const scree_weather* w, scree_weather_stats* out) {
  *out = (scree_weather_stats){.step = w->step,
                               .start_rock = w->start_rock,
                               .rock = w->rock_count,
                               .colluvium = w->colluvium_count,
                               .active = count_active(w),
                               .removed = w->removed,
                               .fallen = w->fallen,
                               .memory = w->memory};
}

void scree_weather_radii(const scree_weather* w, double* radii) {
  for (uint32_t y = 0; y < w->size[1]; ++y) {
    uint64_t rock = 0;
    for (uint32_t z = 0; z < w->size[2]; ++z) rock += count_bits(w->rock + weather_row(w, (int32_t)y, (int32_t)z), w->words);
    radii[y] = sqrt((double)rock / 3.14159265358979323846);
  }
}

void scree_weather_size(const scree_weather* w, uint32_t size[3]) {
  memcpy(size, w->size, sizeof w->size);
}

void scree_weather_voxels(const scree_weather* w, uint8_t* voxels) {
  for (uint32_t z = 0; z < w->size[2]; ++z)
    for (uint32_t y = 0; y < w->size[1]; ++y) {
      const size_t row = weather_row(w, (int32_t)y, (int32_t)z);
      for (uint32_t x = 0; x < w->size[0]; ++x)
        *voxels++ = (uint8_t)(weather_bit(w->rock, row, x)        ? SCREE_VOXEL_ROCK
                              : weather_bit(w->colluvium, row, x) ? SCREE_VOXEL_COLLUVIUM
                                                                  : SCREE_VOXEL_AIR);
    }
}

uint64_t scree_weather_digest(const scree_weather* w) {
  uint64_t hash = hash_combine(w->size[0] | (uint64_t)w->size[1] << 32, w->size[2]);
  for (uint32_t z = 0; z < w->size[2]; ++z)
    for (uint32_t y = 0; y < w->size[1]; ++y) {
      const size_t row = weather_row(w, (int32_t)y, (int32_t)z);
      const int32_t* life = w->life + weather_at(w, 0, y, z);
      for (uint32_t i = 0; i < w->words; ++i) {
        hash = hash_combine(hash, w->rock[row + i]);
        hash = hash_combine(hash, w->colluvium[row + i]);
        for (uint64_t left = w->rock[row + i] | w->colluvium[row + i]; left != 0; left &= left - 1) {
          const uint32_t x = i * 64 + (uint32_t)__builtin_ctzll(left);
          if (life[x] != WEATHER_FULL) hash = hash_combine(hash, (uint64_t)x << 32 | (uint32_t)life[x]);
        }
      }
    }
  return hash;
}
