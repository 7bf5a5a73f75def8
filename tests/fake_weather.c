#include "fake_weather.h"

#include <stdlib.h>
#include <string.h>

static void* need(size_t count, size_t size) {
  void* memory = calloc(count, size);
  if (memory == NULL) abort();
  return memory;
}

scree_weather* fake_weather_create(const uint32_t size[3], const scree_jobs* jobs, const scree_allocator* allocator) {
  scree_weather* w = need(1, sizeof *w);
  w->allocator = scree_rt_allocator_or_default(allocator);
  if (jobs != NULL) w->jobs = *jobs;
  memcpy(w->size, size, sizeof w->size);
  w->words = size[0] / 64 + 1;
  w->bit_plane = (size_t)w->words * (size[1] + 2);
  w->bit_count = w->bit_plane * (size[2] + 2);
  w->rock = need(w->bit_count, sizeof *w->rock);
  w->colluvium = need(w->bit_count, sizeof *w->colluvium);
  w->voxel_plane = (size_t)size[0] * size[1];
  w->life = need(w->voxel_plane * size[2], sizeof *w->life);
  w->noise = need(w->voxel_plane * size[2], 1);
  w->count_row = size[0];
  w->count_plane = w->voxel_plane;
  w->counts = need(w->voxel_plane * size[2], sizeof *w->counts);
  for (int axis = 0; axis < 3; ++axis) w->bricks[axis] = (size[axis] + WEATHER_BRICK - 1) / WEATHER_BRICK;
  w->stamps = need((size_t)w->bricks[0] * w->bricks[1] * w->bricks[2], sizeof *w->stamps);
  w->tables = need(1, sizeof *w->tables);
  w->tables->layers = need(size[1], sizeof *w->tables->layers);
  w->tables->bubbles = need(1, sizeof *w->tables->bubbles);
  w->tables->bubbles[0].volume = 7;
  for (uint32_t y = 0; y < size[1]; ++y)
    w->tables->layers[y] = (weather_layer){.graph = 1, .colluvium = 0.35f, .segment = (uint8_t)(y / 8), .bubble_count = 1};
  return w;
}

void fake_weather_destroy(scree_weather* w) {
  free(w->rock);
  free(w->colluvium);
  free(w->life);
  free(w->noise);
  free(w->counts);
  free(w->stamps);
  free(w->tables->layers);
  free(w->tables->bubbles);
  free(w->tables);
  free(w);
}

void fake_weather_set(scree_weather* w, uint32_t x, uint32_t y, uint32_t z, scree_voxel voxel, float life) {
  const size_t word = weather_row(w, (int32_t)y, (int32_t)z) + x / 64;
  const uint64_t bit = UINT64_C(1) << (x % 64);
  w->rock[word] = voxel == SCREE_VOXEL_ROCK ? w->rock[word] | bit : w->rock[word] & ~bit;
  w->colluvium[word] = voxel == SCREE_VOXEL_COLLUVIUM ? w->colluvium[word] | bit : w->colluvium[word] & ~bit;
  w->life[weather_at(w, x, y, z)] = voxel == SCREE_VOXEL_AIR ? 0 : (int32_t)(life * WEATHER_FULL);
  w->stamps[weather_brick(w, x, y, z)] = w->change;
}
