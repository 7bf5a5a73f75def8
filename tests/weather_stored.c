#include "weather_stored.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FULL 1073741824.0f

typedef struct voxel {
  int32_t life, rate; /* of 2^30 */
  uint32_t count;     /* of air in its bubble */
  float durability;
  int16_t x, y, z;
} voxel;

struct weather_stored {
  int32_t size[3];
  voxel** grid; /* NULL = air, &unexposed, or an object */
  voxel unexposed;
  const float* durability;
  voxel** active;
  voxel** dead;
  uint64_t active_count, left;
  int32_t (*offsets)[3];
  uint32_t offset_count;
  float* rates; /* for each count */
};

static voxel** cell(const weather_stored* s, int32_t x, int32_t y, int32_t z) {
  return &s->grid[(size_t)x + (size_t)s->size[0] * ((size_t)y + (size_t)s->size[1] * (size_t)z)];
}

static bool in_grid(const weather_stored* s, int32_t x, int32_t y, int32_t z) {
  return x >= 0 && y >= 0 && z >= 0 && x < s->size[0] && y < s->size[1] && z < s->size[2];
}

static bool is_air(const weather_stored* s, int32_t x, int32_t y, int32_t z) {
  return y >= 0 && (!in_grid(s, x, y, z) || *cell(s, x, y, z) == NULL);
}

static const int32_t six[6][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};

static void set_rate(const weather_stored* s, voxel* v) {
  v->rate = (int32_t)fminf(s->rates[v->count] / v->durability, FULL);
}

/* A voxel becomes active: its object is made and its bubble counted once. */
static void expose(weather_stored* s, int32_t x, int32_t y, int32_t z) {
  voxel* v = malloc(sizeof *v);
  if (v == NULL) abort();
  *v = (voxel){.life = (int32_t)FULL, .x = (int16_t)x, .y = (int16_t)y, .z = (int16_t)z};
  v->durability = s->durability[cell(s, x, y, z) - s->grid];
  for (uint32_t i = 0; i < s->offset_count; ++i)
    v->count += is_air(s, x + s->offsets[i][0], y + s->offsets[i][1], z + s->offsets[i][2]);
  set_rate(s, v);
  *cell(s, x, y, z) = v;
  s->active[s->active_count++] = v;
}

weather_stored* weather_stored_create(const uint32_t size[3], const uint8_t* voxels, const float* durability, double radius,
                                      double steps_per_voxel) {
  weather_stored* s = calloc(1, sizeof *s);
  if (s == NULL) return NULL;
  const size_t count = (size_t)size[0] * size[1] * size[2];
  for (int a = 0; a < 3; ++a) s->size[a] = (int32_t)size[a];
  s->durability = durability;
  s->grid = calloc(count, sizeof *s->grid);
  s->active = calloc(count, sizeof *s->active);
  s->dead = calloc(count, sizeof *s->dead);
  s->offsets = calloc(25 * 25 * 25, sizeof *s->offsets);
  s->rates = calloc(25 * 25 * 25, sizeof *s->rates);
  if (s->grid == NULL || s->active == NULL || s->dead == NULL || s->offsets == NULL || s->rates == NULL) {
    weather_stored_destroy(s);
    return NULL;
  }
  uint32_t flat = 0;
  for (int32_t z = -12; z <= 12; ++z)
    for (int32_t y = -12; y <= 12; ++y)
      for (int32_t x = -12; x <= 12; ++x)
        if (x * x + y * y + z * z <= radius * radius) {
          memcpy(s->offsets[s->offset_count++], (int32_t[3]){x, y, z}, sizeof(int32_t[3]));
          flat += y > 0;
        }
  const double c_flat = (double)flat / s->offset_count;
  for (uint32_t i = 0; i <= s->offset_count; ++i) {
    const double c = (double)i / s->offset_count;
    s->rates[i] = (float)(3 * (c * c * c) / (3 * (c_flat * c_flat * c_flat)) / steps_per_voxel * FULL);
  }
  for (size_t i = 0; i < count; ++i)
    if (voxels[i] != 0) {
      s->grid[i] = &s->unexposed;
      ++s->left;
    }
  for (int32_t z = 0; z < s->size[2]; ++z)
    for (int32_t y = 0; y < s->size[1]; ++y)
      for (int32_t x = 0; x < s->size[0]; ++x) {
        if (*cell(s, x, y, z) == NULL) continue;
        bool exposed = false;
        for (int i = 0; i < 6; ++i) exposed = exposed || is_air(s, x + six[i][0], y + six[i][1], z + six[i][2]);
        if (exposed) expose(s, x, y, z);
      }
  return s;
}

void weather_stored_destroy(weather_stored* s) {
  if (s == NULL) return;
  for (uint64_t i = 0; i < s->active_count; ++i) free(s->active[i]);
  free(s->grid);
  free(s->active);
  free(s->dead);
  free(s->offsets);
  free(s->rates);
  free(s);
}

void weather_stored_step(weather_stored* s) {
  uint64_t dead = 0, kept = 0;
  for (uint64_t i = 0; i < s->active_count; ++i) {
    voxel* v = s->active[i];
    v->life -= v->rate;
    if (v->life <= 0)
      s->dead[dead++] = v;
    else
      s->active[kept++] = v;
  }
  s->active_count = kept;
  s->left -= dead;
  for (uint64_t i = 0; i < dead; ++i) *cell(s, s->dead[i]->x, s->dead[i]->y, s->dead[i]->z) = NULL;
  /* Those that have a bubble with a removed voxel in it raise their rates. */
  for (uint64_t i = 0; i < dead; ++i)
    for (uint32_t k = 0; k < s->offset_count; ++k) {
      const int32_t x = s->dead[i]->x - s->offsets[k][0], y = s->dead[i]->y - s->offsets[k][1],
                    z = s->dead[i]->z - s->offsets[k][2];
      if (!in_grid(s, x, y, z)) continue;
      voxel* v = *cell(s, x, y, z);
      if (v == NULL || v == &s->unexposed) continue;
      ++v->count;
      set_rate(s, v);
    }
  for (uint64_t i = 0; i < dead; ++i) {
    for (int k = 0; k < 6; ++k) {
      const int32_t x = s->dead[i]->x + six[k][0], y = s->dead[i]->y + six[k][1], z = s->dead[i]->z + six[k][2];
      if (in_grid(s, x, y, z) && *cell(s, x, y, z) == &s->unexposed) expose(s, x, y, z);
    }
    free(s->dead[i]);
  }
}

uint64_t weather_stored_left(const weather_stored* s) {
  return s->left;
}

bool weather_stored_rock(const weather_stored* s, uint32_t x, uint32_t y, uint32_t z) {
  return *cell(s, (int32_t)x, (int32_t)y, (int32_t)z) != NULL;
}
