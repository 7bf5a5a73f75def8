/* What stands of split rock, or a block of it, as an asset: levels of detail on an integer lattice with UVs and smoothing groups,
 * mass, convex hulls, footprint. What recipes of shards hand to the pack writer; the surface comes from shard_surface.h.
 *
 * Lattice: relative to an origin of the caller's, for what stands shard_asset_origin, for a block its centroid; steps_per_metre
 * steps a metre. Cliffs of one solid at different times fit over each other.
 *
 * surface[v] of the meshes: material (0 the solid's own surface, 2 a cut; the bed is 0), durability (1, or with joints 0.5 to 1.5
 * by shard), curvature + 128 (above 128 on the sharp edges of cuts), smoothing group. Vertices at one place that differ in their
 * group belong to different sides of a sharp edge: a reader that adds up normals per place and group keeps the edge. */
#ifndef SCREE_SHARD_ASSET_H
#define SCREE_SHARD_ASSET_H

#include <scree/frost.h>

#include "rock_set.h"

enum {
  SHARD_ASSET_MAX_VERTICES = 65536, /* of a level: what 16-bit indices reach */
  SHARD_PARTS_MAX = 64,
  SHARD_PART_MAX_HULL = 32
};

typedef struct shard_part {
  int16_t hull[SHARD_PART_MAX_HULL][3]; /* lattice steps */
  uint32_t hull_count;                  /* 4..SHARD_PART_MAX_HULL */
} shard_part;

typedef struct shard_lod {
  lattice_mesh mesh; /* with surface and uvs (uv_bounds not set); closed as a set of places; error: metres, the largest distance */
  float error_of_most; /* metres: what 95 of 100 vertices of the finest level do not pass, what packs of models call error */
} shard_lod;

/* Metres relative to the origin, but for lattice steps where said. */
typedef struct shard_asset {
  uint32_t lod_count;
  shard_lod lods[ROCK_MAX_LODS];        /* finest first; one that cannot be made coarser repeats the one before it */
  int16_t bounds_min[3], bounds_max[3]; /* lattice steps, of lods[0] */
  float centroid[3], volume;
  float inner_radius, outer_radius;  /* balls around the centroid: inside the shape (0 where it is outside), and around the mesh */
  float footprint;                   /* the lowest hundredth of the height stays within this distance of the y axis */
  float height;                      /* of the highest place above the origin */
  int16_t hull[ROCK_MAX_HULL][3];    /* lattice steps, of all of it */
  uint32_t hull_count;               /* 4..ROCK_MAX_HULL */
  shard_part parts[SHARD_PARTS_MAX]; /* convex parts that together hold nearly all of every shard; of a block its hull */
  uint32_t part_count;               /* 1..SHARD_PARTS_MAX */
  float hull_air, parts_air;         /* share of the volume of the hull, and of the sum of the parts, that is not rock */
  float uv_min[2], uv_max[2];        /* of all levels */
} shard_asset;

typedef struct shard_asset_desc {
  const scree_shards* shards;
  const uint8_t* inside; /* of each shard: 1 = it is part of the asset */
  double origin[3];
  double rotation[4]; /* unit quaternion x, y, z, w about the origin, before anything else: a block as it lies; all zero = none */
  double steps_per_metre; /* > 0; everything must lie within 16384 steps of the origin */
  uint32_t lods;          /* 1..ROCK_MAX_LODS */
  bool joints;            /* every shard has a durability of its own, and the solid's surface comes apart along joints */
  bool block;             /* no ground darkens it, one convex part */
  scree_jobs jobs;        /* all zero = none */
} shard_asset_desc;

/* The middle of the solid's box, at the height of the level ground where that meets the solid, else at the end that is nearer to
 * it. */
void shard_asset_origin(const scree_shards* shards, double ground, double origin[3]);

/* The largest whole number of steps a metre, a power of two where it is not below 1, on which everything fits; 0 if none does.
 * origin: as above. */
double shard_asset_lattice(const scree_shards* shards, const double origin[3]);

/* allocator: for the arrays of `out`. Returns SCREE_OK, INVALID_ARGUMENT (nothing is inside, or it is flat on
 * the lattice), RANGE (it does not fit), or
 * OUT_OF_MEMORY; unless it is SCREE_OK, nothing of `out` is held. */
scree_result shard_asset_make(const shard_asset_desc* desc, const scree_allocator* allocator, shard_asset* out);
void shard_asset_destroy(shard_asset* asset, const scree_allocator* allocator); /* all zero is allowed */

#endif
