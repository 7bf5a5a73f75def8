/* What is inside a simulation of weathering, for the files of bake/ that work on it. include/scree/weather.h says what it means.
 *
 *   bits      rock, colluvium, solid, grains, scratch: a bit a voxel, rows along x in words, every row with at least one spare bit
 * (always 0, so that shifts by one carry air in), planes of size[1] + 2 rows, size[2] + 2 planes: the ring of guard rows is air,
 * the ground below (y = -1) apart, which is solid for all x and z of the grid in `solid`. life      an int32 a voxel, WEATHER_FULL
 * = all of it, 0 = air. What a step takes is a share of it, so that rules can change and lives stay. noise     an int8 a voxel,
 * -127..127 for -1..1: the noise of the voxel's segment of the durability graph. counts    a uint16 a voxel, air as well as rock:
 * voxels of air in the voxel's bubble. Rows have a margin that takes what lies beside the grid, so that spans are added without
 * clipping.
 *
 *      rock | colluvium changes during a step; `solid` is what counts speak of and follows at its end. */
#ifndef SCREE_WEATHER_INTERNAL_H
#define SCREE_WEATHER_INTERNAL_H

#include <scree/weather.h>

#include "allocator.h"

#define WEATHER_FULL (1 << 30)
#define WEATHER_BRICK 16  /* voxels a side: the unit of "changed since", and of work along z */
#define WEATHER_MARGIN 12 /* the largest reach of a bubble */
#define WEATHER_REACH (2 * WEATHER_MARGIN + 1)

/* A bubble as spans along x. */
typedef struct weather_bubble {
  scree_bubble shape;
  int32_t reach_y, reach_z;                  /* rows with |dy| and |dz| up to these have voxels */
  uint32_t volume;                           /* voxels, the middle one too */
  uint32_t flat;                             /* of them above the middle: what is air over a level plain */
  uint32_t rate_first;                       /* its rates in weather_tables.rates, one a count 0..volume */
  int8_t half[WEATHER_REACH][WEATHER_REACH]; /* [dz + 12][dy + 12]: the span is x - half..x + half; -1 = none */
} weather_bubble;

/* One layer of voxels, y. */
typedef struct weather_layer {
  float graph;          /* durability without noise */
  float amplitude;      /* of the noise */
  float colluvium;      /* durability of colluvium that lies here */
  uint8_t segment;      /* of the durability graph: points at this altitude or below; 255 at most */
  uint8_t point;        /* whose noise counts */
  uint8_t bubble_count; /* 1..4; more than one is a mixture */
  uint8_t bubbles[4];   /* in weather_tables.bubbles */
  double mixture_period;
} weather_layer;

/* The largest steps that colluvium rests over. */
typedef struct weather_repose {
  int32_t look;      /* cells that a grain looks ahead */
  int32_t steps[17]; /* [cells ahead] voxels */
} weather_repose;

/* All that follows from rules. set_rules makes a new one and swaps it in as a whole. */
typedef struct weather_tables {
  size_t bytes; /* of the one allocation that all of it lies in */
  weather_layer* layers;
  weather_bubble* bubbles;
  float* rates; /* share of life * WEATHER_FULL at durability 1 and one exposed face, for each bubble and count */
  scree_durability_point* points;
  uint32_t bubble_count, rate_count, point_count;
  int32_t reach;            /* the largest of all bubbles' */
  bool mixed;               /* some layer has a mixture */
  float exposure[8];        /* k^e */
  uint64_t share;           /* a removed voxel of rock becomes colluvium when the top 32 bits of its hash are below this */
  weather_repose repose[2]; /* along an axis, along a diagonal */
  scree_rockfall rockfall;
} weather_tables;

struct scree_weather {
  scree_allocator allocator;
  scree_jobs jobs;
  const struct weather_kernels* kernels; /* tests put others in */
  size_t memory_limit;
  uint64_t seed;
  uint32_t size[3];

  uint32_t words;   /* of a row of bits */
  size_t bit_plane; /* words of a plane, guard rows too */
  size_t bit_count; /* words of an array of bits */
  uint64_t *rock, *colluvium, *solid;
  uint64_t* grains;     /* places whose rock becomes colluvium in this step; empty between steps */
  uint64_t* scratch;    /* of the sweep and of rockfall */
  uint64_t* mixture[2]; /* the two bits of which bubble of a mixture; NULL where no layer has one */
  uint8_t* rows;        /* a byte a row of bits: something in it changed since `solid` was brought up to date */

  size_t voxel_plane; /* lives and noises of a plane: size[0] * size[1] and a little */
  int32_t* life;
  int8_t* noise;

  size_t count_row, count_plane, count_count;
  uint16_t* counts; /* of voxel (0, 0, 0); the margin is before it */

  uint32_t bricks[3];
  uint32_t* stamps; /* for each brick, x fastest: `change` when one of its voxels, lives or durabilities changed last */
  uint32_t change;  /* grows with every call that changes anything; never goes back */

  weather_tables* tables;
  uint32_t noise_version; /* grows when the noise becomes another */
  uint64_t step;          /* since the start; goes back with a snapshot */
  uint64_t start_rock, rock_count, colluvium_count, removed, fallen, grain_count;
  bool may_hang;               /* something other than a step changed the grid or the rules since rockfall looked last */
  struct weather_tally* tally; /* one a slab of bricks */
  size_t memory;
};

/* What one slab of WEATHER_BRICK planes saw in a step; added up in their order. */
typedef struct weather_tally {
  uint64_t rock, colluvium; /* removed */
  uint64_t grains;
} weather_tally;

/* Word of the first voxel of row (y, z); -1 and size are the guards. */
static inline size_t weather_row(const scree_weather* w, int32_t y, int32_t z) {
  return (size_t)(z + 1) * w->bit_plane + (size_t)(y + 1) * w->words;
}

static inline size_t weather_at(const scree_weather* w, uint32_t x, uint32_t y, uint32_t z) {
  return x + (size_t)w->size[0] * y + w->voxel_plane * z;
}

static inline bool weather_bit(const uint64_t* bits, size_t row, uint32_t x) {
  return (bits[row + x / 64] >> (x % 64) & 1) != 0;
}

/* Any place; outside the grid is air, below it rock. */
static inline scree_voxel weather_voxel(const scree_weather* w, int32_t x, int32_t y, int32_t z) {
  if (y < 0) return SCREE_VOXEL_ROCK;
  if (x < 0 || z < 0 || (uint32_t)x >= w->size[0] || (uint32_t)y >= w->size[1] || (uint32_t)z >= w->size[2]) return SCREE_VOXEL_AIR;
  const size_t row = weather_row(w, y, z);
  if (weather_bit(w->rock, row, (uint32_t)x)) return SCREE_VOXEL_ROCK;
  return weather_bit(w->colluvium, row, (uint32_t)x) ? SCREE_VOXEL_COLLUVIUM : SCREE_VOXEL_AIR;
}

/* The share of its life that a voxel of the grid has left: 0 = air, 1 = whole. */
static inline float weather_life(const scree_weather* w, uint32_t x, uint32_t y, uint32_t z) {
  return (float)w->life[weather_at(w, x, y, z)] * (1.0f / WEATHER_FULL);
}

/* Durability of rock in a layer where the noise is q / 127. */
static inline float weather_rock_durability(const weather_layer* layer, int8_t q) {
  const float factor = 1 + layer->amplitude * ((float)q * (1.0f / 127));
  return layer->graph * (factor > 1.0f / 16 ? factor : 1.0f / 16);
}

/* Of the rock in a voxel of the grid, or of the colluvium if that is what it holds. */
static inline float weather_durability(const scree_weather* w, uint32_t x, uint32_t y, uint32_t z) {
  const weather_layer* layer = &w->tables->layers[y];
  if (weather_bit(w->colluvium, weather_row(w, (int32_t)y, (int32_t)z), x)) return layer->colluvium;
  return weather_rock_durability(layer, w->noise[weather_at(w, x, y, z)]);
}

/* The bubble that a voxel of the grid looks through. */
static inline const weather_bubble* weather_bubble_at(const scree_weather* w, uint32_t x, uint32_t y, uint32_t z) {
  const weather_layer* layer = &w->tables->layers[y];
  uint32_t which = 0;
  if (layer->bubble_count > 1) {
    const size_t row = weather_row(w, (int32_t)y, (int32_t)z);
    which = (uint32_t)weather_bit(w->mixture[0], row, x) + 2 * (uint32_t)weather_bit(w->mixture[1], row, x);
  }
  return &w->tables->bubbles[layer->bubbles[which]];
}

/* Voxels of air in that bubble. */
static inline uint32_t weather_count(const scree_weather* w, uint32_t x, uint32_t y, uint32_t z) {
  return w->counts[x + w->count_row * y + w->count_plane * z];
}

static inline size_t weather_brick(const scree_weather* w, uint32_t x, uint32_t y, uint32_t z) {
  return x / WEATHER_BRICK + (size_t)w->bricks[0] * (y / WEATHER_BRICK + (size_t)w->bricks[1] * (z / WEATHER_BRICK));
}

/* run(context, index, worker) for every index below count, on the simulation's jobs. */
static inline void weather_parallel(const scree_weather* w, uint32_t count,
                                    void (*run)(void* context, uint32_t index, uint32_t worker), void* context) {
  if (w->jobs.parallel_for != NULL)
    w->jobs.parallel_for(w->jobs.user, count, run, context);
  else
    for (uint32_t i = 0; i < count; ++i) run(context, i, 0);
}

#endif
