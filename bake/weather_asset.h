/* A weathered shape as an asset: levels of detail on an integer lattice, mass, convex hulls, footprint. What recipes of hoodoos
 * hand to the pack writer; the surfaces come from scree_mesher_update.
 *
 * Lattice: x and z from the middle of the grid's footprint, y from the ground, lattice_per_voxel steps to a voxel; it does not
 * depend on what the weather left, so all ages and variants of one grid fit over each other.
 *
 * Meshes go 4 voxels into the ground: there the walls go straight down to a level floor. So they stand in ground that is not quite
 * level, and normals made from triangles are those of the walls where these meet the ground. Mass, hulls and parts leave it out. */
#ifndef SCREE_WEATHER_ASSET_H
#define SCREE_WEATHER_ASSET_H

#include <scree/weather.h>

#include "convex_parts.h"

enum { WEATHER_MAX_VERTICES = 65536 }; /* of a level: what 16-bit indices reach */

typedef struct weather_lod {
  lattice_mesh mesh;       /* with its surface; triangles of rock first, then those of colluvium; error in voxels; closed, manifold,
                              none flat */
  float error_of_most;     /* voxels: what 95 of 100 vertices of the finest level do not pass. Crumbs that a level drops make the
                              largest distance many times as much, and no view needs a finer level for their sake */
  uint32_t rock_triangles; /* of mesh.triangle_count */
  uint32_t level;          /* of scree_mesher_update that it was made from */
} weather_lod;

typedef struct weather_asset {
  uint32_t lattice_per_voxel;
  uint32_t lod_count;
  weather_lod lods[ROCK_MAX_LODS]; /* finest first; one that would be too coarse repeats the one before it */

  /* Lattice steps, of lods[0]; the rest in voxels, of what stands above the ground. Relative to the lattice's origin. */
  int16_t bounds_min[3], bounds_max[3];
  float centroid[3], volume;
  float inner_radius, outer_radius; /* balls around the centroid: inside the shape, and around the mesh */
  float footprint;                  /* what stands on the ground stays within this distance of the lattice's origin */
  float height;                     /* above the ground */

  /* Convex hulls: one over all, and the parts that fit closer where the shape is not convex. part_count = 1: the hull is right. */
  int16_t hull[ROCK_MAX_HULL][3]; /* lattice steps */
  uint32_t hull_count;            /* 4..ROCK_MAX_HULL */
  convex_part parts[PARTS_MAX];   /* from the ground up */
  uint32_t part_count;            /* 1..PARTS_MAX */
  float hull_air, parts_air;      /* share of the volume of the hull, and of the sum of the parts, that is not rock */
} weather_asset;

/* The finest lattice, a power of two up to 64 steps a voxel, that a grid of this size fits on; 0 if none does. */
uint32_t weather_lattice(const uint32_t size[3]);

/* Makes an asset of what stands now. mesher: of a simulation on a grid of `size` voxels. lattice_per_voxel:
 * even, 2..weather_lattice. lods: 1..ROCK_MAX_LODS levels; the first is made from the finest level of the mesher that keeps to
 * WEATHER_MAX_VERTICES. allocator: for the arrays of `out`. Returns SCREE_OK, INVALID_ARGUMENT (nothing stands, or it does not
 * fit), or OUT_OF_MEMORY; unless it is SCREE_OK, nothing of `out` is held. */
scree_result weather_asset_make(scree_mesher* mesher, const uint32_t size[3], uint32_t lattice_per_voxel, uint32_t lods,
                                const scree_allocator* allocator, weather_asset* out);
void weather_asset_destroy(weather_asset* asset, const scree_allocator* allocator); /* all zero is allowed */

#endif
