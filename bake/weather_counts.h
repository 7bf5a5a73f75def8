/* Counts of air in bubbles: made once, then kept up to date by what changed. */
#ifndef SCREE_WEATHER_COUNTS_H
#define SCREE_WEATHER_COUNTS_H

#include "weather_internal.h"

/* Which bubble of a mixture each voxel has, for the tables and mixture bits of w. */
void weather_fill_mixture(const scree_weather* w);

/* Counts where all of the grid is air, and `solid` empty to match; weather_update_counts then makes the rest. */
void weather_clear_counts(scree_weather* w);

/* Brings counts, `solid` and the bricks' stamps up to date with rock and colluvium, in the rows that `rows` names; clears `rows`.
 */
void weather_update_counts(scree_weather* w);

/* Noises of all voxels of rock. */
void weather_fill_noise(const scree_weather* w);

static inline uint8_t* weather_row_flag(const scree_weather* w, uint32_t y, uint32_t z) {
  return &w->rows[(size_t)y + (size_t)w->size[1] * z];
}

#endif
