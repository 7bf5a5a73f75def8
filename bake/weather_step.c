#include "weather_step.h"

#include "weather_counts.h"
#include "weather_kernels.h"

static void sweep_slab(void* context, uint32_t slab, uint32_t worker) {
  (void)worker;
  scree_weather* w = context;
  const uint32_t low = slab * WEATHER_BRICK, high = w->size[2] - low < WEATHER_BRICK ? w->size[2] : low + WEATHER_BRICK;
  w->tally[slab] = (weather_tally){0, 0, 0};
  for (uint32_t z = low; z < high; ++z) w->kernels->sweep(w, z, weather_step_key(w), &w->tally[slab]);
}

static void step(scree_weather* w) {
  ++w->change;
  weather_parallel(w, w->bricks[2], sweep_slab, w);
  weather_tally sum = {0, 0, 0};
  for (uint32_t slab = 0; slab < w->bricks[2]; ++slab) {
    sum.rock += w->tally[slab].rock;
    sum.colluvium += w->tally[slab].colluvium;
    sum.grains += w->tally[slab].grains;
  }
  w->rock_count -= sum.rock;
  w->colluvium_count -= sum.colluvium;
  w->removed = sum.rock + sum.colluvium;
  w->fallen = 0;
  w->grain_count = sum.grains;
  /* Where nothing went, nothing new hangs in the air. */
  if (w->tables->rockfall != SCREE_ROCKFALL_NONE && (w->removed > 0 || w->may_hang)) weather_rockfall(w);
  w->may_hang = false;
  if (w->grain_count > 0) weather_settle(w);
  if (w->removed + w->fallen > 0) weather_update_counts(w);
  ++w->step;
}

scree_result scree_weather_step(scree_weather* w, uint32_t count) {
  for (uint32_t i = 0; i < count && w->rock_count + w->colluvium_count > 0; ++i) step(w);
  return SCREE_OK;
}

scree_result scree_weather_run(scree_weather* w, double share, uint32_t most, bool (*progress)(void* user, double done),
                               void* user) {
  if (!(share >= 0 && share <= 1)) return SCREE_ERROR_RANGE;
  const double start = (double)w->start_rock;
  for (uint32_t i = 0; i < most && (double)w->rock_count > share * start; ++i) {
    step(w);
    if (progress == NULL) continue;
    const double steps = (double)(i + 1) / most, worn = share < 1 ? (1 - (double)w->rock_count / start) / (1 - share) : 1;
    const double done = steps > worn ? steps : worn;
    if (!progress(user, done < 1 ? done : 1)) return SCREE_ERROR_CANCELLED;
  }
  return SCREE_OK;
}
