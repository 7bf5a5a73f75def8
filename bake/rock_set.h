/* What the baker hands to the pack writer: all unique rocks, or all models, in order, meshes already encoded. */
#ifndef SCREE_ROCK_SET_H
#define SCREE_ROCK_SET_H

#include <scree/base.h>
#include <scree/pack.h>

#define ROCK_MAX_LODS 6
#define ROCK_MAX_HULL 64

/* What 0 and 65535 of the UVs in a pack stand for: one range for all its meshes, min <= max, finite. */
typedef struct uv_range {
  float min[2], max[2];
} uv_range;

/* A mesh on the pack's lattice, before encoding. */
typedef struct lattice_mesh {
  int16_t (*positions)[3]; /* lattice steps relative to the home cell's centre */
  uint8_t* occlusion;      /* ambient visibility, one a vertex */
  uint32_t* indices;       /* 3 a triangle, counter-clockwise from outside */
  uint32_t vertex_count;
  uint32_t triangle_count;
  float error; /* cells */
  /* Of models, NULL for rocks: material, durability, curvature + 128 and group of each vertex, see scree_vertex. group: the
   * smoothing group, 0 but in cliffs; vertices that differ in it are different vertices, so their normals do not mix. */
  uint8_t (*surface)[4];
  /* Of cliffs and their blocks, else NULL; within `uv_bounds`, to which the encoders clamp them. */
  float (*uvs)[2];
  uv_range uv_bounds; /* the pack's: that of the cliff_record */
} lattice_mesh;

typedef struct rock_lod {
  uint8_t* blob; /* Draco bytes, at the coarsest level a plain mesh */
  uint32_t blob_size;
  uint32_t vertex_count; /* as decoded */
  uint32_t triangle_count;
  float error;
  uint64_t digest; /* canonical, computed before encoding */
} rock_lod;

typedef struct rock_record {
  uint32_t cell; /* unique cell; rocks are sorted by (cell, seed) */
  uint32_t seed;
  int16_t bounds_min[3], bounds_max[3];                  /* lattice steps */
  float centroid[3], volume, inner_radius, outer_radius; /* cells */
  int16_t (*hull)[3];                                    /* lattice steps */
  uint32_t hull_count;
  scree_contact* contacts;
  uint32_t contact_count;
  uint32_t burial; /* as in scree_asset */
  rock_lod lods[ROCK_MAX_LODS];
} rock_record;

/* What models have beside a rock_record. Metres. */
typedef struct model_record {
  float footprint, height, share; /* as in scree_model */
  uint32_t steps;
  int16_t (*parts)[3];  /* vertices of all convex parts, lattice steps */
  uint32_t* part_first; /* part_count + 1 elements: part p has the vertices part_first[p] .. part_first[p + 1] - 1 */
  uint32_t part_count;
} model_record;

/* What a cliff has beside models: variant 0 is the cliff, of as many ages as there are times; all others are blocks, of one age
 * each (model_record.share and steps of the cliff's ages: what stands, and paths; of blocks: of the volume at the start, and the
 * path at which it fell). */
typedef struct cliff_record {
  uint32_t time_count;             /* 1..255 */
  const uint32_t* placement_first; /* time_count + 1: time t has the placements placement_first[t] .. placement_first[t + 1] - 1 */
  const scree_block_placement* placements; /* in any order within a time: the writer puts near ones together */
  uv_range uvs;                            /* of all meshes */
} cliff_record;

typedef struct proxy_record {
  rock_lod lods[ROCK_MAX_LODS];
} proxy_record;

typedef struct rock_set {
  uint32_t cells_per_cube; /* N; 0 for models */
  uint32_t lattice_per_cell;
  uint32_t lod_count;
  uint32_t cell_count;
  uint32_t rock_count;
  const uint32_t* cell_first;  /* cell_count + 1 elements: rocks of cell c are cell_first[c] .. cell_first[c + 1] - 1 */
  const rock_record* rocks;    /* rock_count */
  const proxy_record* proxies; /* NULL, or 256 * 9 by (code, part) */
  uint32_t proxy_per_cell;     /* lattice steps; 0 without proxies */
  const model_record* models;  /* NULL, or rock_count: cells are variants, seeds are ages, meshes have a surface */
  const cliff_record* cliff;   /* NULL, or models are a cliff and its blocks, and every mesh has UVs */
  const char* recipe;          /* JSON, NUL-terminated */
} rock_set;

#endif
