/* How the patterns of seeds are laid: a list that grows, and what all patterns know of the solid. */
#ifndef SCREE_SEED_LAY_H
#define SCREE_SEED_LAY_H

#include <scree/shards.h>

#include "seed_mask.h"
#include "shard_space.h"

enum { MOST_SEEDS = 1000000 };

/* Room for more points, by doubling. */
typedef struct seed_list {
  double* points; /* 3 each */
  uint32_t count, capacity;
} seed_list;

/* The solid in the space of its pattern. */
typedef struct seed_job {
  const scree_seed_pattern* pattern;
  scree_allocator allocator;
  scree_error* error;
  double* positions; /* 3 * vertex_count */
  const uint32_t* indices;
  uint32_t vertex_count, triangle_count;
  double min[3], max[3], volume;
  solid_inside inside;
  seed_list seeds;
} seed_job;

/* Returns SCREE_OK, RANGE (more than MOST_SEEDS) or OUT_OF_MEMORY. */
scree_result seed_add(seed_job* job, const double p[3]);

/* The reach is `most` everywhere, or as `reach` says. */
scree_result seed_job_mask(seed_job* job, double step, double most, seed_reach reach, const void* user, seed_mask* out);

/* Uniform within the solid: `count` points, added to the seeds. */
scree_result seeds_random(seed_job* job, uint32_t count, uint64_t random_seed);

/* No two nearer than a radius, and no room for one more but for slivers. grade: unit, in the space of the pattern; the radius is
 * radii[0] where the coordinate along it is ends[0], radii[1] at ends[1]. */
typedef struct seed_radius {
  double grade[3], ends[2], radii[2];
} seed_radius;

static inline double seed_radius_at(const seed_radius* r, const double p[3]) {
  const double span = r->ends[1] - r->ends[0];
  double t = span > 0 ? (r->grade[0] * p[0] + r->grade[1] * p[1] + r->grade[2] * p[2] - r->ends[0]) / span : 0;
  t = t > 0 ? t < 1 ? t : 1 : 0;
  return r->radii[0] + (r->radii[1] - r->radii[0]) * t;
}

scree_result seeds_poisson(seed_job* job, const seed_radius* radius, uint64_t random_seed);

#endif
