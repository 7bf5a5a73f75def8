#include "weather_twin.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lattice.h"
#include "weather_noise.h"

#define FULL 1073741824.0f

typedef struct offset {
  int32_t x, y, z;
} offset;

/* One bubble of one segment. */
typedef struct twin_bubble {
  offset* offsets;
  int32_t count, flat;
} twin_bubble;

struct weather_twin {
  int32_t size[3];
  uint64_t seed, step, removed, fallen;
  uint8_t* voxels;
  uint8_t* before; /* at the start of the step */
  int32_t* lives;
  int32_t* queue;
  float* durability; /* of rock in each voxel; that of colluvium is found each time */
  scree_weather_rules rules;
  scree_durability_point points[256];
  scree_bubble_segment segments[64];
  twin_bubble bubbles[64][4];
};

static size_t place(const weather_twin* t, int32_t x, int32_t y, int32_t z) {
  return (size_t)x + (size_t)t->size[0] * ((size_t)y + (size_t)t->size[1] * (size_t)z);
}

static bool in_grid(const weather_twin* t, int32_t x, int32_t y, int32_t z) {
  return x >= 0 && y >= 0 && z >= 0 && x < t->size[0] && y < t->size[1] && z < t->size[2];
}

/* Outside the grid is air, below it ground. */
static bool is_air(const weather_twin* t, const uint8_t* voxels, int32_t x, int32_t y, int32_t z) {
  if (y < 0) return false;
  return !in_grid(t, x, y, z) || voxels[place(t, x, y, z)] == SCREE_VOXEL_AIR;
}

static bool in_bubble(const scree_bubble* b, int32_t x, int32_t y, int32_t z) {
  const double r = b->radius, h = b->height;
  const double across = (double)x * x + (double)z * z, up = (double)y * y;
  if (b->kind == SCREE_BUBBLE_ELLIPSOID) return across * (h * h) + up * (r * r) <= r * r * (h * h);
  if (b->kind == SCREE_BUBBLE_DISC) return across <= r * r && y >= -1 && y <= 1;
  if (b->kind == SCREE_BUBBLE_GUMDROP) return across + up <= r * r && y >= -r / 2;
  return across + up <= r * r;
}

static void free_bubbles(weather_twin* t) {
  for (int i = 0; i < 64; ++i)
    for (int k = 0; k < 4; ++k) free(t->bubbles[i][k].offsets);
  memset(t->bubbles, 0, sizeof t->bubbles);
}

weather_twin* weather_twin_create(const uint32_t size[3], const uint8_t* voxels, const int32_t* lives, uint64_t seed) {
  weather_twin* t = calloc(1, sizeof *t);
  if (t == NULL) return NULL;
  const size_t count = (size_t)size[0] * size[1] * size[2];
  for (int a = 0; a < 3; ++a) t->size[a] = (int32_t)size[a];
  t->seed = seed;
  t->voxels = malloc(count);
  t->before = malloc(count);
  t->lives = calloc(count, sizeof *t->lives);
  t->queue = calloc(count * 3, sizeof *t->queue);
  t->durability = calloc(count, sizeof *t->durability);
  if (t->voxels == NULL || t->before == NULL || t->lives == NULL || t->queue == NULL || t->durability == NULL) {
    weather_twin_destroy(t);
    return NULL;
  }
  memcpy(t->voxels, voxels, count);
  for (size_t i = 0; i < count; ++i) t->lives[i] = lives != NULL ? lives[i] : voxels[i] != SCREE_VOXEL_AIR ? (int32_t)FULL : 0;
  return t;
}

void weather_twin_destroy(weather_twin* t) {
  if (t == NULL) return;
  free_bubbles(t);
  free(t->voxels);
  free(t->before);
  free(t->lives);
  free(t->queue);
  free(t->durability);
  free(t);
}

/* --- one voxel --------------------------------------------------------------------------------------------------------------- */

static double altitude_of(const weather_twin* t, int32_t y) {
  return (y + 0.5) / t->size[1];
}

static double graph_at(const weather_twin* t, double altitude) {
  const uint32_t last = t->rules.durability_count - 1;
  if (altitude < t->points[0].altitude) return t->points[0].durability;
  for (uint32_t i = last; i > 0; --i) {
    if (altitude >= t->points[i].altitude && i == last) return t->points[i].durability;
    const scree_durability_point *a = &t->points[i - 1], *b = &t->points[i];
    if (altitude >= a->altitude && altitude < b->altitude)
      return a->durability + (b->durability - a->durability) * ((altitude - a->altitude) / (b->altitude - a->altitude));
  }
  return t->points[last].durability;
}

static float durability_of(const weather_twin* t, int32_t x, int32_t y, int32_t z, bool colluvium) {
  const double altitude = altitude_of(t, y), graph = graph_at(t, altitude);
  if (colluvium) return (float)(graph * t->rules.colluvium_durability);
  const scree_durability_point* p = &t->points[0];
  for (uint32_t i = 0; i < t->rules.durability_count; ++i)
    if (t->points[i].altitude <= altitude) p = &t->points[i];
  if (p->noise_amplitude == 0) return (float)graph;
  const double frequency = 1 / (p->noise_period != 0 ? p->noise_period : 16);
  const weather_noise noise = {hash_combine(t->seed, 1), frequency, frequency * (p->noise_squash != 0 ? p->noise_squash : 1)};
  float value;
  weather_noise_row(&noise, NULL, (uint32_t)x, (uint32_t)y, (uint32_t)z, 1, &value);
  const float step = floorf(value * 127 + 127.5f) - 127;
  const float factor = 1 + (float)p->noise_amplitude * (step * (1.0f / 127));
  return (float)graph * fmaxf(factor, 1.0f / 16);
}

void weather_twin_rules(weather_twin* t, const scree_weather_rules* rules) {
  free_bubbles(t);
  t->rules = *rules;
  memcpy(t->points, rules->durability, rules->durability_count * sizeof *t->points);
  memcpy(t->segments, rules->bubbles, rules->bubble_count * sizeof *t->segments);
  for (uint32_t i = 0; i < rules->bubble_count; ++i)
    for (uint32_t k = 0; k < t->segments[i].bubble_count; ++k) {
      twin_bubble* b = &t->bubbles[i][k];
      b->offsets = malloc(25 * 25 * 25 * sizeof *b->offsets);
      if (b->offsets == NULL) abort();
      for (int32_t z = -12; z <= 12; ++z)
        for (int32_t y = -12; y <= 12; ++y)
          for (int32_t x = -12; x <= 12; ++x)
            if (in_bubble(&t->segments[i].bubbles[k], x, y, z)) {
              b->offsets[b->count++] = (offset){x, y, z};
              b->flat += y > 0;
            }
    }
  for (int32_t z = 0; z < t->size[2]; ++z)
    for (int32_t y = 0; y < t->size[1]; ++y)
      for (int32_t x = 0; x < t->size[0]; ++x) t->durability[place(t, x, y, z)] = durability_of(t, x, y, z, false);
}

static const twin_bubble* bubble_of(const weather_twin* t, int32_t x, int32_t y, int32_t z) {
  const double altitude = altitude_of(t, y);
  uint32_t i = 0;
  while (i + 1 < t->rules.bubble_count && t->segments[i + 1].altitude <= altitude) ++i;
  const scree_bubble_segment* s = &t->segments[i];
  if (s->bubble_count == 1) return &t->bubbles[i][0];
  const double frequency = 1 / (s->noise_period != 0 ? s->noise_period : 16);
  const weather_noise noise = {hash_combine(t->seed, 2), frequency, frequency};
  float value;
  weather_noise_row(&noise, NULL, (uint32_t)x, (uint32_t)y, (uint32_t)z, 1, &value);
  uint32_t which = (uint32_t)((value + 1) * 0.5f * (float)s->bubble_count);
  return &t->bubbles[i][which < s->bubble_count ? which : s->bubble_count - 1];
}

static double f(const scree_curve* curve, double x, double x_flat, double steps) {
  double t;
  switch (curve->kind) {
    case SCREE_CURVE_NONE: return 0;
    case SCREE_CURVE_LINEAR: return curve->gain * x / x_flat / steps;
    case SCREE_CURVE_CUBIC: return curve->gain * (3 * (x * x * x)) / (3 * (x_flat * x_flat * x_flat)) / steps;
    case SCREE_CURVE_QUARTIC: return curve->gain * (3 * (x * x * (x * x))) / (3 * (x_flat * x_flat * (x_flat * x_flat))) / steps;
    case SCREE_CURVE_SATURATING: break;
  }
  t = (x - x_flat - curve->threshold) / curve->saturation;
  t = t < 0 ? 0 : t > 1 ? 1 : t;
  double power = 1;
  for (uint32_t i = 0; i < curve->power; ++i) power *= t;
  return curve->gain * power;
}

/* What the step takes of the life of an exposed voxel. */
static int32_t taken(const weather_twin* t, int32_t x, int32_t y, int32_t z, int32_t faces) {
  const twin_bubble* b = bubble_of(t, x, y, z);
  int32_t air = 0;
  for (int32_t i = 0; i < b->count; ++i) air += is_air(t, t->before, x + b->offsets[i].x, y + b->offsets[i].y, z + b->offsets[i].z);
  const double c = (double)air / b->count, flat = (double)b->flat / b->count;
  const double rate = f(&t->rules.spheroidal, c, flat, t->rules.steps_per_voxel) +
                      f(&t->rules.cavernous, 1 - c, 1 - flat, t->rules.steps_per_voxel);
  const bool colluvium = t->before[place(t, x, y, z)] == SCREE_VOXEL_COLLUVIUM;
  const float durability = colluvium ? durability_of(t, x, y, z, true) : t->durability[place(t, x, y, z)];
  const float share = (float)(rate * FULL) * (float)pow(faces, t->rules.exposure) / durability;
  return (int32_t)fminf(share, FULL);
}

/* --- colluvium and rockfall ----------------------------------------------------------------------------------------------------
 */

static bool kept(const weather_twin* t, int32_t x, int32_t y, int32_t z, uint64_t* random) {
  const uint64_t key = hash_combine(hash_combine(t->seed, 6), t->step);
  *random = hash_corner(key, x, y, z);
  return (double)(*random >> 32) < t->rules.colluvium_share * 4294967296.0;
}

static int32_t fall(const weather_twin* t, int32_t x, int32_t y, int32_t z) {
  while (is_air(t, t->voxels, x, y - 1, z)) --y;
  return y;
}

/* Over how many cells a whole number of voxels has a slope within 6 % of the tangent; at most 16, then the best. */
static int32_t cells_ahead(double tangent) {
  int32_t best = 0;
  for (int32_t far = 1; far <= 16; ++far) {
    const double step = floor(tangent * far + 0.5), error = fabs(step / far - tangent);
    if (step < 1) continue;
    if (error <= 0.06 * tangent) return far;
    if (best == 0 || error < fabs(floor(tangent * best + 0.5) / best - tangent)) best = far;
  }
  return best;
}

static void settle(weather_twin* t, int32_t x, int32_t y, int32_t z, uint32_t random) {
  static const int32_t ways[8][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
  while (y < t->size[1] && t->voxels[place(t, x, y, z)] == SCREE_VOXEL_COLLUVIUM) ++y; /* grains lie where it was */
  if (y == t->size[1] || t->voxels[place(t, x, y, z)] == SCREE_VOXEL_ROCK) return;
  y = fall(t, x, y, z);
  for (;;) {
    int32_t best = -1, distance = 0;
    int64_t steepest[2] = {0, 1};
    for (uint32_t i = 0; i < 8; ++i) {
      const int32_t k = (int32_t)((random + i) % 8);
      const double tangent = k % 2 == 0 ? t->rules.repose : t->rules.repose * sqrt(2);
      const int32_t look = cells_ahead(tangent);
      for (int32_t far = 1; far <= look; ++far) {
        const int32_t nx = x + far * ways[k][0], nz = z + far * ways[k][1];
        if (!is_air(t, t->voxels, nx, y, nz)) break;
        int32_t drop = 0;
        while (drop < 32 && is_air(t, t->voxels, nx, y - 1 - drop, nz)) ++drop;
        /* With the grain the column is one higher. */
        if (drop == 0 || drop + 1 <= (far == look ? floor(tangent * far + 0.5) : ceil(tangent * far))) continue;
        const int64_t up = (int64_t)(drop + 1) * (drop + 1), across = (int64_t)far * far * (k % 2 == 0 ? 1 : 2);
        if (up * steepest[1] > steepest[0] * across) {
          steepest[0] = up;
          steepest[1] = across;
          best = k;
          distance = far;
        }
        break;
      }
    }
    if (best < 0) break;
    x += distance * ways[best][0];
    z += distance * ways[best][1];
    if (!in_grid(t, x, 0, z)) return;
    y = fall(t, x, y, z);
    random = random >> 3 | random << 29;
  }
  t->voxels[place(t, x, y, z)] = SCREE_VOXEL_COLLUVIUM;
  t->lives[place(t, x, y, z)] = (int32_t)FULL;
}

/* Marks with 2 in `joined` what a path of faces joins to the ground. */
static void join(weather_twin* t, uint8_t* joined) {
  static const offset six[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  size_t head = 0, tail = 0;
  memset(joined, 0, (size_t)t->size[0] * (size_t)t->size[1] * (size_t)t->size[2]);
  for (int32_t z = 0; z < t->size[2]; ++z)
    for (int32_t x = 0; x < t->size[0]; ++x) {
      if (t->voxels[place(t, x, 0, z)] == SCREE_VOXEL_AIR) continue;
      joined[place(t, x, 0, z)] = 2;
      memcpy(t->queue + 3 * tail++, (int32_t[3]){x, 0, z}, sizeof(int32_t[3]));
    }
  for (; head < tail; ++head)
    for (int i = 0; i < 6; ++i) {
      const int32_t x = t->queue[3 * head] + six[i].x, y = t->queue[3 * head + 1] + six[i].y, z = t->queue[3 * head + 2] + six[i].z;
      if (!in_grid(t, x, y, z) || joined[place(t, x, y, z)] != 0 || t->voxels[place(t, x, y, z)] == SCREE_VOXEL_AIR) continue;
      joined[place(t, x, y, z)] = 2;
      memcpy(t->queue + 3 * tail++, (int32_t[3]){x, y, z}, sizeof(int32_t[3]));
    }
}

void weather_twin_step(weather_twin* t) {
  const size_t count = (size_t)t->size[0] * (size_t)t->size[1] * (size_t)t->size[2];
  memcpy(t->before, t->voxels, count);
  t->removed = t->fallen = 0;
  uint8_t* grain = calloc(count, 1); /* 1 = its rock becomes colluvium */
  uint8_t* joined = malloc(count);
  if (grain == NULL || joined == NULL) abort();
  uint64_t random;
  for (int32_t z = 0; z < t->size[2]; ++z)
    for (int32_t y = 0; y < t->size[1]; ++y)
      for (int32_t x = 0; x < t->size[0]; ++x) {
        const size_t at = place(t, x, y, z);
        if (t->before[at] == SCREE_VOXEL_AIR) continue;
        const int32_t faces = is_air(t, t->before, x - 1, y, z) + is_air(t, t->before, x + 1, y, z) +
                              is_air(t, t->before, x, y - 1, z) + is_air(t, t->before, x, y + 1, z) +
                              is_air(t, t->before, x, y, z - 1) + is_air(t, t->before, x, y, z + 1);
        if (faces == 0) continue;
        t->lives[at] -= taken(t, x, y, z, faces);
        if (t->lives[at] > 0) continue;
        t->lives[at] = 0;
        t->voxels[at] = SCREE_VOXEL_AIR;
        ++t->removed;
        grain[at] = t->before[at] == SCREE_VOXEL_ROCK && kept(t, x, y, z, &random);
      }
  if (t->rules.rockfall != SCREE_ROCKFALL_NONE) {
    join(t, joined);
    for (int32_t z = 0; z < t->size[2]; ++z)
      for (int32_t y = 0; y < t->size[1]; ++y)
        for (int32_t x = 0; x < t->size[0]; ++x) {
          const size_t at = place(t, x, y, z);
          if (t->voxels[at] == SCREE_VOXEL_AIR || joined[at] != 0) continue;
          if (t->rules.rockfall == SCREE_ROCKFALL_COLLUVIUM)
            grain[at] = t->voxels[at] == SCREE_VOXEL_COLLUVIUM || kept(t, x, y, z, &random);
          t->voxels[at] = SCREE_VOXEL_AIR;
          t->lives[at] = 0;
          ++t->fallen;
        }
  }
  for (int32_t z = 0; z < t->size[2]; ++z)
    for (int32_t y = 0; y < t->size[1]; ++y)
      for (int32_t x = 0; x < t->size[0]; ++x)
        if (grain[place(t, x, y, z)] != 0) {
          kept(t, x, y, z, &random);
          settle(t, x, y, z, (uint32_t)random);
        }
  ++t->step;
  free(grain);
  free(joined);
}

const uint8_t* weather_twin_voxels(const weather_twin* t) {
  return t->voxels;
}

const int32_t* weather_twin_lives(const weather_twin* t) {
  return t->lives;
}

uint64_t weather_twin_removed(const weather_twin* t) {
  return t->removed;
}

uint64_t weather_twin_fallen(const weather_twin* t) {
  return t->fallen;
}
