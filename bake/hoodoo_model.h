/* One model of a recipe of hoodoos by itself, for those who go on with it. */
#ifndef SCREE_HOODOO_MODEL_H
#define SCREE_HOODOO_MODEL_H

#include <scree/hoodoo.h>

#include "weather_asset.h"

/* Weathers one variant up to one age. lods: levels that `out` gets. steps_per_metre: of its lattice. Returns what scree_hoodoo_bake
 * returns; unless it is SCREE_OK, nothing of `out` is held. */
scree_result hoodoo_model_make(const scree_hoodoo_desc* desc, uint32_t variant, uint32_t age, uint32_t lods, weather_asset* out,
                               uint32_t* steps_per_metre, scree_error* error);

#endif
