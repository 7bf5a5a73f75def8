/* scree_mesher_*: what weathers as a field, and its meshes.
 *
 * The field is the share of its life that each voxel has left, blurred once by [1 2 1]^3: without the blur the fronts of erosion
 * show as terraces. Coarser levels are means of it. Every level keeps its own bricks. */
#include <math.h>
#include <string.h>

#include "surface_bricks.h"
#include "weather_internal.h"
#include "weather_sky.h"

enum {
  MAX_LEVEL = 5,
  MEAN_LEVEL = 4, /* the coarsest one that bricks of the finest are averaged to; below it are means of these */
  SLICE = BLOCK_WIDTH * BLOCK_SIDE,
  RAW_SLICE = BLOCK_WIDTH * RAW_SIDE,
  BRICK_VOXELS = BRICK_SIDE * BRICK_SIDE * BRICK_SIDE
};

typedef struct mesher_level {
  scree_mesher* mesher;
  bool exists;
  uint32_t level;
  uint32_t* stamps; /* of the simulation's bricks: what is in the bricks of `surface` */
  surface_mesher surface;
  /* Levels 1 and coarser: means of the finest field, and of the colluvium in it. */
  uint32_t stored;  /* the level that they are of: at most MEAN_LEVEL */
  uint32_t size[3]; /* cells */
  float *field, *colluvium;
  double* volumes; /* of the simulation's bricks */
  uint32_t* list;  /* of bricks to average anew */
} mesher_level;

/* What a brick of voxels holds. */
enum { HOLDS_SOLID = 1, HOLDS_AIR = 2 };

struct scree_mesher {
  const scree_weather* weather;
  scree_allocator allocator;
  uint8_t* holds;   /* of the simulation's bricks */
  uint32_t* stamps; /* of them, when that was found */
  weather_sky sky;
  mesher_level levels[MAX_LEVEL + 1];
};

static size_t brick_count(const scree_weather* w) {
  return (size_t)w->bricks[0] * w->bricks[1] * w->bricks[2];
}

/* --- The finest field. --- */

/* Bits x .. x + RAW_SIDE - 1 of a row; outside it are zeros. */
static uint64_t row_bits(const uint64_t* row, uint32_t words, int32_t x) {
  uint64_t bits = 0;
  const int32_t word = x >= 0 ? x / 64 : -1, shift = x & 63;
  if (word >= 0 && (uint32_t)word < words) bits = row[word] >> shift;
  if (shift > 64 - RAW_SIDE && (uint32_t)(word + 1) < words) bits |= row[word + 1] << (64 - shift);
  return bits & ((UINT64_C(1) << RAW_SIDE) - 1);
}

static uint8_t find_contents(const scree_weather* w, uint32_t x, uint32_t y, uint32_t z) {
  /* 64 is a multiple of a brick's side: a row of it lies in one word. */
  const uint64_t full = ((UINT64_C(1) << BRICK_SIDE) - 1) << (x % 64);
  uint64_t any = 0, all = full;
  for (uint32_t k = z; k < z + BRICK_SIDE; ++k)
    for (uint32_t j = y; j < y + BRICK_SIDE; ++j) {
      uint64_t bits = 0;
      if (j < w->size[1] && k < w->size[2]) {
        const size_t at = weather_row(w, (int32_t)j, (int32_t)k) + x / 64;
        bits = w->rock[at] | w->colluvium[at];
      }
      any |= bits & full;
      all &= bits;
    }
  return (uint8_t)((any != 0 ? HOLDS_SOLID : 0) | (all != full ? HOLDS_AIR : 0));
}

static void update_contents(scree_mesher* mesher) {
  const scree_weather* w = mesher->weather;
  uint32_t b = 0;
  for (uint32_t z = 0; z < w->bricks[2]; ++z)
    for (uint32_t y = 0; y < w->bricks[1]; ++y)
      for (uint32_t x = 0; x < w->bricks[0]; ++x, ++b) {
        if (mesher->stamps[b] == w->stamps[b]) continue;
        mesher->holds[b] = find_contents(w, x * BRICK_SIDE, y * BRICK_SIDE, z * BRICK_SIDE);
        mesher->stamps[b] = w->stamps[b];
      }
}

/* Whether the bricks of voxels around a brick of cubes have both rock and air. Outside the grid is air, but at the ground there is
 * always a surface. */
static bool may_pass(const scree_mesher* mesher, const int32_t brick[3]) {
  const scree_weather* w = mesher->weather;
  uint32_t holds = brick[1] == 0 ? HOLDS_AIR : 0;
  for (int32_t z = brick[2] - 1; z <= brick[2] + 1; ++z)
    for (int32_t y = brick[1] > 0 ? brick[1] - 1 : 0; y <= brick[1] + 1; ++y)
      for (int32_t x = brick[0] - 1; x <= brick[0] + 1; ++x) {
        const bool outside =
            x < 0 || z < 0 || (uint32_t)x >= w->bricks[0] || (uint32_t)y >= w->bricks[1] || (uint32_t)z >= w->bricks[2];
        holds |= outside ? HOLDS_AIR : mesher->holds[(uint32_t)x + w->bricks[0] * ((uint32_t)y + w->bricks[1] * (uint32_t)z)];
      }
  return holds == (HOLDS_SOLID | HOLDS_AIR);
}

/* Whether the block has both rock and air, and any colluvium. */
static bool look(const scree_weather* w, const int32_t at[3], bool* colluvium) {
  const uint64_t full = (UINT64_C(1) << RAW_SIDE) - 1;
  uint64_t any = 0, all = full, loose = 0;
  for (int32_t z = at[2]; z < at[2] + RAW_SIDE; ++z)
    for (int32_t y = at[1] < 0 ? 0 : at[1]; y < at[1] + RAW_SIDE; ++y) {
      if (z < 0 || (uint32_t)z >= w->size[2] || (uint32_t)y >= w->size[1]) {
        all = 0;
        continue;
      }
      const size_t row = weather_row(w, y, z);
      const uint64_t rock = row_bits(w->rock + row, w->words, at[0]), grains = row_bits(w->colluvium + row, w->words, at[0]);
      any |= rock | grains;
      all &= rock | grains;
      loose |= grains;
    }
  *colluvium = loose != 0;
  return any != 0 && (all != full || at[1] < 0);
}

/* Shares of life; voxels below the ground repeat those above it, so that walls go straight down. */
static void read_lives(const scree_weather* w, const int32_t at[3], bool only_colluvium, float* raw) {
  memset(raw, 0, RAW_VALUES * sizeof *raw);
  const int32_t first = at[0] < 0 ? -at[0] : 0;
  const int32_t beyond = (int32_t)w->size[0] - at[0], last = beyond < RAW_SIDE ? beyond : RAW_SIDE;
  for (int32_t k = 0; k < RAW_SIDE; ++k)
    for (int32_t j = 0; j < RAW_SIDE; ++j) {
      const int32_t z = at[2] + k, y = at[1] + j < 0 ? 0 : at[1] + j;
      if (z < 0 || (uint32_t)z >= w->size[2] || (uint32_t)y >= w->size[1]) continue;
      float* to = raw + (size_t)k * RAW_SLICE + (size_t)j * BLOCK_WIDTH;
      const int32_t* life = w->life + weather_at(w, 0, (uint32_t)y, (uint32_t)z);
      const size_t row = weather_row(w, y, z);
      const uint64_t grains = row_bits(w->colluvium + row, w->words, at[0]);
      if ((grains | row_bits(w->rock + row, w->words, at[0])) == 0) continue; /* lives are far larger, and cold */
      if (only_colluvium) {
        for (uint64_t bits = grains; bits != 0; bits &= bits - 1) {
          const int32_t x = __builtin_ctzll(bits);
          to[x] = (float)life[at[0] + x] * (1.0f / WEATHER_FULL);
        }
      } else
        for (int32_t x = first; x < last; ++x) to[x] = (float)life[at[0] + x] * (1.0f / WEATHER_FULL);
    }
}

static bool load_finest(const void* user, const int32_t brick[3], surface_block* out) {
  const scree_mesher* mesher = ((const mesher_level*)user)->mesher;
  const scree_weather* w = mesher->weather;
  if (!may_pass(mesher, brick)) return false;
  int32_t at[3];
  for (uint32_t axis = 0; axis < 3; ++axis) at[axis] = brick[axis] * BRICK_SIDE - 3;
  if (!look(w, at, &out->has_colluvium)) return false;
  read_lives(w, at, false, out->raw[0]);
  surface_blur(out->raw[0], out->field);
  for (uint32_t i = 0; i < BLOCK_VALUES; ++i) out->field[i] -= 0.5f;
  if (out->has_colluvium) {
    read_lives(w, at, true, out->raw[1]);
    surface_blur(out->raw[1], out->colluvium);
  }
  if (brick[1] == 0) surface_continue_below(out->field);
  return true;
}

/* --- Means of it. --- */

static size_t cell_count(const mesher_level* level) {
  return (size_t)level->size[0] * level->size[1] * level->size[2];
}

static void average_brick(void* context, uint32_t index, uint32_t worker) {
  mesher_level* level = context;
  const scree_weather* w = level->mesher->weather;
  const uint32_t b = level->list[index], side = BRICK_SIDE >> level->stored, cell = 1u << level->stored;
  const uint32_t brick[3] = {b % w->bricks[0], b / w->bricks[0] % w->bricks[1], b / w->bricks[0] / w->bricks[1]};
  surface_block* block = &level->surface.blocks[worker];
  const bool mixed = load_finest(level, (const int32_t[3]){(int32_t)brick[0], (int32_t)brick[1], (int32_t)brick[2]}, block);
  const float one = weather_voxel(w, (int32_t)brick[0] * BRICK_SIDE, (int32_t)brick[1] * BRICK_SIDE,
                                  (int32_t)brick[2] * BRICK_SIDE) != SCREE_VOXEL_AIR
                        ? 1
                        : 0;
  const float scale = 1.0f / (float)(cell * cell * cell);
  level->volumes[b] = 0;
  for (uint32_t z = 0; z < side; ++z)
    for (uint32_t y = 0; y < side; ++y)
      for (uint32_t x = 0; x < side; ++x) {
        const uint32_t to[3] = {brick[0] * side + x, brick[1] * side + y, brick[2] * side + z};
        if (to[0] >= level->size[0] || to[1] >= level->size[1] || to[2] >= level->size[2]) continue;
        float sum = 0, loose = 0;
        if (mixed)
          for (uint32_t k = 0; k < cell; ++k)
            for (uint32_t j = 0; j < cell; ++j) {
              const size_t row = 2 + x * cell + (size_t)BLOCK_WIDTH * (2 + y * cell + j) + (size_t)SLICE * (2 + z * cell + k);
              for (uint32_t i = 0; i < cell; ++i) sum += block->field[row + i] + 0.5f;
              if (block->has_colluvium)
                for (uint32_t i = 0; i < cell; ++i) loose += block->colluvium[row + i];
            }
        else
          sum = one * (float)(cell * cell * cell);
        const size_t at = to[0] + (size_t)level->size[0] * (to[1] + (size_t)level->size[1] * to[2]);
        level->field[at] = sum * scale;
        level->colluvium[at] = loose * scale;
        level->volumes[b] += (double)sum;
      }
}

static bool load_means(const void* user, const int32_t brick[3], surface_block* out) {
  const mesher_level* level = user;
  const uint32_t shift = level->level - level->stored, part = 1u << shift;
  const float scale = 1.0f / (float)(part * part * part);
  memset(out->field, 0, sizeof out->field);
  memset(out->colluvium, 0, sizeof out->colluvium);
  out->has_colluvium = true;
  bool any = false;
  for (int32_t k = 0; k < BLOCK_SIDE; ++k)
    for (int32_t j = 0; j < BLOCK_SIDE; ++j)
      for (int32_t i = 0; i < BLOCK_SIDE; ++i) {
        const int32_t x = brick[0] * BRICK_SIDE + i - 2, y = brick[1] * BRICK_SIDE + j - 2, z = brick[2] * BRICK_SIDE + k - 2;
        float sum = 0, loose = 0;
        if (x >= 0 && y >= 0 && z >= 0)
          for (uint32_t c = 0; c < part * part * part; ++c) {
            const uint32_t from[3] = {((uint32_t)x << shift) + c % part, ((uint32_t)y << shift) + c / part % part,
                                      ((uint32_t)z << shift) + c / part / part};
            if (from[0] >= level->size[0] || from[1] >= level->size[1] || from[2] >= level->size[2]) continue;
            const size_t at = from[0] + (size_t)level->size[0] * (from[1] + (size_t)level->size[1] * from[2]);
            sum += level->field[at];
            loose += level->colluvium[at];
          }
        const size_t to = (size_t)i + (size_t)BLOCK_WIDTH * (size_t)j + (size_t)SLICE * (size_t)k;
        out->field[to] = sum * scale - 0.5f;
        out->colluvium[to] = loose * scale;
        any = any || sum > 0;
      }
  if (brick[1] == 0) surface_continue_below(out->field);
  return any;
}

/* --- What a vertex tells. --- */

static uint32_t clamp_voxel(float at, uint32_t size) {
  return at <= 0 ? 0 : at >= (float)size ? size - 1 : (uint32_t)at;
}

/* Share of air in the bubble at a point: trilinear between the voxels around it. */
static float air_share(const scree_weather* w, const float position[3]) {
  uint32_t low[3], high[3];
  float t[3], v[8];
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const float p = position[axis] - 0.5f;
    low[axis] = clamp_voxel(p, w->size[axis]);
    high[axis] = low[axis] + 1 < w->size[axis] ? low[axis] + 1 : low[axis];
    t[axis] = p - (float)low[axis];
    t[axis] = t[axis] < 0 ? 0 : t[axis] > 1 ? 1 : t[axis];
  }
  for (uint32_t j = 0; j < 2; ++j) {
    const uint32_t y = j == 0 ? low[1] : high[1];
    const weather_layer* layer = &w->tables->layers[y];
    if (layer->bubble_count == 1) {
      const float scale = 1 / (float)w->tables->bubbles[layer->bubbles[0]].volume;
      const uint16_t *near = w->counts + w->count_row * y + w->count_plane * low[2],
                     *far = w->counts + w->count_row * y + w->count_plane * high[2];
      v[2 * j] = (float)near[low[0]] * scale;
      v[2 * j + 1] = (float)near[high[0]] * scale;
      v[2 * j + 4] = (float)far[low[0]] * scale;
      v[2 * j + 5] = (float)far[high[0]] * scale;
    } else
      for (uint32_t i = 0; i < 4; ++i) {
        const uint32_t x = i & 1 ? high[0] : low[0], z = i >> 1 ? high[2] : low[2];
        v[(i & 1) + 2 * j + 4 * (i >> 1)] = (float)weather_count(w, x, y, z) / (float)weather_bubble_at(w, x, y, z)->volume;
      }
  }
  for (uint32_t i = 0; i < 4; ++i) v[i] = v[2 * i] + (v[2 * i + 1] - v[2 * i]) * t[0];
  v[0] += (v[1] - v[0]) * t[1];
  v[1] = v[2] + (v[3] - v[2]) * t[1];
  return v[0] + (v[1] - v[0]) * t[2];
}

/* 2 c - 1 where a level face has 0. Bubbles count whole voxels, but the surface sinks by up to a voxel as their lives do: half a
 * voxel further out is right on average. (Looking for the surface of whole voxels shows their stairs.) */
static float curvature_at(const scree_weather* w, const float position[3], const float normal[3]) {
  float out[3];
  for (uint32_t axis = 0; axis < 3; ++axis) out[axis] = position[axis] + 0.5f * normal[axis];
  return 2 * air_share(w, out) - 1;
}

static void describe(const void* user, scree_surface_vertex* vertex) {
  const mesher_level* level = user;
  const scree_weather* w = level->mesher->weather;
  /* The first voxel beneath that is not air; a coarse surface may lie well above it. */
  uint32_t at[3] = {0, 0, 0};
  const uint32_t tries = 1 + (1u << level->level);
  for (uint32_t depth = 0; depth < tries; ++depth) {
    uint32_t p[3];
    for (uint32_t axis = 0; axis < 3; ++axis)
      p[axis] = clamp_voxel(vertex->position[axis] - vertex->normal[axis] * (0.5f + 0.5f * (float)depth), w->size[axis]);
    const bool solid = w->life[weather_at(w, p[0], p[1], p[2])] > 0;
    if (depth == 0 || solid) memcpy(at, p, sizeof at);
    if (solid) break;
  }
  vertex->durability = weather_durability(w, at[0], at[1], at[2]);
  vertex->layer = w->tables->layers[at[1]].segment;
  vertex->curvature = curvature_at(w, vertex->position, vertex->normal);
}

static float sky(const void* user, const scree_surface_vertex* vertex) {
  return weather_sky_at(&((const mesher_level*)user)->mesher->sky, vertex->position, vertex->normal);
}

/* --- Levels. --- */

static void level_destroy(mesher_level* level) {
  const scree_allocator* allocator = &level->mesher->allocator;
  const size_t bricks = brick_count(level->mesher->weather), cells = cell_count(level);
  scree_rt_release(allocator, level->stamps, bricks, sizeof *level->stamps);
  scree_rt_release(allocator, level->field, cells, sizeof *level->field);
  scree_rt_release(allocator, level->colluvium, cells, sizeof *level->colluvium);
  scree_rt_release(allocator, level->volumes, bricks, sizeof *level->volumes);
  scree_rt_release(allocator, level->list, bricks, sizeof *level->list);
  surface_mesher_destroy(&level->surface);
  memset(level, 0, sizeof *level);
}

static scree_result level_create(scree_mesher* mesher, uint32_t number) {
  mesher_level* level = &mesher->levels[number];
  const scree_weather* w = mesher->weather;
  const scree_allocator* allocator = &mesher->allocator;
  const size_t bricks = brick_count(w);
  memset(level, 0, sizeof *level);
  level->mesher = mesher;
  level->level = number;
  level->stored = number < MEAN_LEVEL ? number : MEAN_LEVEL;
  surface_source source = {level, {0}, (float)(1u << number), number == 0 ? load_finest : load_means, describe, sky};
  for (uint32_t axis = 0; axis < 3; ++axis) source.size[axis] = (w->size[axis] + (1u << number) - 1) >> number;
  if (number > 0)
    for (uint32_t axis = 0; axis < 3; ++axis) level->size[axis] = (w->size[axis] + (1u << level->stored) - 1) >> level->stored;
  scree_result result = surface_mesher_create(&source, &w->jobs, allocator, &level->surface);
  level->stamps = scree_rt_allocate(allocator, bricks, sizeof *level->stamps);
  bool complete = level->stamps != NULL;
  if (number > 0) {
    level->field = scree_rt_allocate(allocator, cell_count(level), sizeof *level->field);
    level->colluvium = scree_rt_allocate(allocator, cell_count(level), sizeof *level->colluvium);
    level->volumes = scree_rt_allocate(allocator, bricks, sizeof *level->volumes);
    level->list = scree_rt_allocate(allocator, bricks, sizeof *level->list);
    complete = complete && level->field != NULL && level->colluvium != NULL && level->volumes != NULL && level->list != NULL;
  }
  if (result == SCREE_OK && !complete) result = SCREE_ERROR_OUT_OF_MEMORY;
  if (result != SCREE_OK) {
    level_destroy(level);
    return result;
  }
  memset(level->stamps, 255, bricks * sizeof *level->stamps); /* the simulation gives no such stamp: all is to be made */
  level->exists = true;
  return SCREE_OK;
}

/* Whether the field of a brick of voxels may have changed: the blur looks at the bricks around it. */
static bool is_stale(const mesher_level* level, const uint32_t brick[3]) {
  const scree_weather* w = level->mesher->weather;
  uint32_t low[3], high[3];
  for (uint32_t axis = 0; axis < 3; ++axis) {
    low[axis] = brick[axis] > 0 ? brick[axis] - 1 : 0;
    high[axis] = brick[axis] + 1 < w->bricks[axis] ? brick[axis] + 1 : brick[axis];
  }
  for (uint32_t z = low[2]; z <= high[2]; ++z)
    for (uint32_t y = low[1]; y <= high[1]; ++y)
      for (uint32_t x = low[0]; x <= high[0]; ++x) {
        const size_t b = x + (size_t)w->bricks[0] * (y + (size_t)w->bricks[1] * z);
        if (level->stamps[b] != w->stamps[b]) return true;
      }
  return false;
}

/* How far from a changed voxel, in voxels, a vertex can feel it: by its place and normal, and by the bubble around the voxel
 * beneath it. */
static int32_t touch_reach(uint32_t level) {
  return level == 0 ? WEATHER_MARGIN + 2 : WEATHER_MARGIN + 2 + (4 << level);
}

/* Marks what the simulation has changed since the last time, and brings the means up to date. */
static void follow(mesher_level* level) {
  const scree_weather* w = level->mesher->weather;
  const int32_t reach = touch_reach(level->level), cell = 1 << level->level;
  uint32_t count = 0, b = 0;
  for (uint32_t z = 0; z < w->bricks[2]; ++z)
    for (uint32_t y = 0; y < w->bricks[1]; ++y)
      for (uint32_t x = 0; x < w->bricks[0]; ++x, ++b) {
        const uint32_t brick[3] = {x, y, z};
        if (level->level > 0 && is_stale(level, brick)) level->list[count++] = b;
        if (level->stamps[b] == w->stamps[b]) continue;
        int32_t min[3], max[3];
        for (uint32_t axis = 0; axis < 3; ++axis) {
          const int32_t low = (int32_t)brick[axis] * BRICK_SIDE - reach, high = low + BRICK_SIDE + 2 * reach;
          min[axis] = low < 0 ? 0 : low / cell;
          max[axis] = (high + cell - 1) / cell;
        }
        surface_mesher_touch(&level->surface, min, max);
      }
  if (count > 0) weather_parallel(w, count, average_brick, level);
  memcpy(level->stamps, w->stamps, brick_count(w) * sizeof *level->stamps);
}

scree_result scree_mesher_create(const scree_weather* weather, scree_mesher** out) {
  *out = NULL;
  scree_mesher* mesher = scree_rt_allocate_zeroed(&weather->allocator, 1, sizeof *mesher);
  if (mesher == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  mesher->weather = weather;
  mesher->allocator = weather->allocator;
  scree_result result = weather_sky_create(weather->size, &mesher->allocator, &mesher->sky);
  const size_t bricks = brick_count(weather);
  mesher->holds = scree_rt_allocate_zeroed(&mesher->allocator, bricks, sizeof *mesher->holds);
  mesher->stamps = scree_rt_allocate(&mesher->allocator, bricks, sizeof *mesher->stamps);
  if (mesher->holds == NULL || mesher->stamps == NULL) result = SCREE_ERROR_OUT_OF_MEMORY;
  if (result == SCREE_OK) {
    memset(mesher->stamps, 255, bricks * sizeof *mesher->stamps);
    *out = mesher;
  } else
    scree_mesher_destroy(mesher);
  return result;
}

void scree_mesher_destroy(scree_mesher* mesher) {
  if (mesher == NULL) return;
  const scree_allocator allocator = mesher->allocator;
  for (uint32_t level = 0; level <= MAX_LEVEL; ++level)
    if (mesher->levels[level].exists) level_destroy(&mesher->levels[level]);
  weather_sky_destroy(&mesher->sky, &allocator);
  scree_rt_release(&allocator, mesher->holds, brick_count(mesher->weather), sizeof *mesher->holds);
  scree_rt_release(&allocator, mesher->stamps, brick_count(mesher->weather), sizeof *mesher->stamps);
  scree_rt_release(&allocator, mesher, 1, sizeof *mesher);
}

scree_result scree_mesher_update(scree_mesher* mesher, uint32_t number, scree_surface* surface) {
  *surface = (scree_surface){0};
  if (number > MAX_LEVEL) return SCREE_ERROR_INVALID_ARGUMENT;
  mesher_level* level = &mesher->levels[number];
  if (!level->exists) {
    const scree_result result = level_create(mesher, number);
    if (result != SCREE_OK) return result;
  }
  update_contents(mesher);
  follow(level);
  weather_sky_update(&mesher->sky, mesher->weather);
  scree_result result = surface_mesher_update(&level->surface, surface);
  if (result != SCREE_OK || number == 0 || surface->vertex_count == 0) return result;
  double volume = 0;
  for (size_t b = 0; b < brick_count(mesher->weather); ++b) volume += level->volumes[b];
  result = surface_match_volume(&level->surface, surface, volume, 0.6f * (float)(1u << number));
  if (result != SCREE_OK) *surface = (scree_surface){0};
  return result;
}
