/* The plain twin of scatters: every point of every tile, every step of every vertical line, one after the other. */
#ifndef SCATTER_TWIN_H
#define SCATTER_TWIN_H

#include "convex.h"
#include "scatter_internal.h"
#include "support_program.h"
#include "synthetic_field.h"

typedef struct twin_stand {
  scree_id id; /* layer 0 */
  int64_t steps[3];
  uint32_t model, random;
} twin_stand;

typedef struct twin_stands {
  twin_stand* stands;
  uint64_t count;
} twin_stands;

/* All instances of tiles low .. high - 1 (x and z), on ground that is looked for from `top` metres down to `bottom`, world. desc:
 * what the scatter was made of. */
twin_stands twin_scatter(const scree_scatter* scatter, const scree_scatter_desc* desc, const scree_support* ground,
                         const int32_t low[2], const int32_t high[2], double top, double bottom);

enum { RANDOM_MODELS = 6 };

/* A random scatter and what it points at; must not be moved while it is in use. Points are `spacing` apart. */
typedef struct random_scatter {
  scree_scatter_desc desc;
  scree_scatter_model models[RANDOM_MODELS];
  float hulls[RANDOM_MODELS][3 * 12], weights[RANDOM_MODELS], image[5 * 4];
  scree_filter mask;
  scree_scatter* scatter;
} random_scatter;

void make_random_scatter(random_scatter* s, random_stream* r, double spacing, const double origin[3]);

#endif
