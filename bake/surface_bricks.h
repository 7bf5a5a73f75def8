/* A mesh of a scalar field on a grid of any size, made brick by brick, so that what did not change is kept: dual marching cubes,
 * one vertex for each piece of surface in a cube of 2x2x2 voxels (surface_cubes.h), one quad across every edge between an inside
 * and an outside voxel. The result is a closed 2-manifold for any field.
 *
 *   voxel       -2  -1   0   1   2                 n-1   n
 *                    |---|---|---|---| ...      |---|---|     cubes, named by their lower voxel + 1: 0 .. n
 *   brick b has the cubes 16 b .. 16 b + 15 and looks at the voxels 16 b - 2 .. 16 b + 16
 *
 * Below y = 0 is ground: the mesh is closed along it by a floor at y = 0 exactly, and walls go straight down to it.
 *
 * Positions are floats within their own cube, away from its faces, so that vertices of neighbouring cubes never coincide. */
#ifndef SCREE_SURFACE_BRICKS_H
#define SCREE_SURFACE_BRICKS_H

#include <scree/weather.h>

#include "kernels.h"
#include "surface_cubes.h"

enum {
  BRICK_SIDE = 16,
  BLOCK_SIDE = BRICK_SIDE + 3,
  BLOCK_WIDTH = 24, /* BLOCK_SIDE rounded up to lanes */
  BLOCK_VALUES = BLOCK_WIDTH * BLOCK_SIDE * BLOCK_SIDE,
  RAW_SIDE = BLOCK_SIDE + 2, /* before a blur */
  RAW_VALUES = BLOCK_WIDTH * RAW_SIDE * RAW_SIDE
};

/* What a brick is made from, x fastest, BLOCK_WIDTH values a row; and a worker's scratch. */
typedef struct surface_block {
  float field[BLOCK_VALUES];     /* positive inside, at most 1/2 in size */
  float colluvium[BLOCK_VALUES]; /* how much of field + 1/2 is colluvium */
  bool has_colluvium;            /* otherwise it is not looked at */
  uint64_t rows[BLOCK_SIDE * BLOCK_SIDE];
  uint16_t cubes[BRICK_SIDE * BRICK_SIDE * BRICK_SIDE];
  float raw[2][RAW_VALUES]; /* for `load` alone */
} surface_block;

/* Where fields come from. The functions are called by several workers at a time and must not change anything they share. */
typedef struct surface_source {
  void* user;
  uint32_t size[3]; /* voxels */
  float width;      /* of a voxel, in units of the vertices' positions */
  /* Fills field, colluvium and has_colluvium of the voxels 16 brick - 2 .. 16 brick + 16. Voxels outside the grid are outside, but
   * those at y < 0 continue the field. False: all of the block is inside, or all is outside. */
  bool (*load)(const void* user, const int32_t brick[3], surface_block* out);
  /* Fills durability, curvature and layer of a vertex whose position and normal are known. */
  void (*describe)(const void* user, scree_surface_vertex* vertex);
  /* How much of the sky a vertex sees. */
  float (*sky)(const void* user, const scree_surface_vertex* vertex);
} surface_source;

/* A cube that the surface passes:
 *   bits 0..13 its first vertex, 14..21 its configuration, 22 whether its pinching face is cut the other way, 23..26 whether its
 *   corners 0, 1, 2 and 4 are colluvium. */
typedef uint32_t brick_cell;

typedef struct surface_brick {
  brick_cell* cells; /* of all cubes, NULL for a brick without surface; only those in `cubes` are set */
  uint16_t* cubes;   /* x + 16 y + 256 z, rising */
  scree_surface_vertex* vertices;
  uint32_t cube_count, cube_capacity;
  uint32_t vertex_count, vertex_capacity;
  uint32_t quads[2];        /* of rock and of colluvium that start at these cubes */
  uint32_t first_vertex;    /* in the whole mesh */
  uint32_t first_index[2];  /* of its rock and its colluvium, in the whole mesh */
  bool changed, incomplete; /* to be made anew; memory ran out */
} surface_brick;

typedef struct surface_mesher {
  scree_allocator allocator;
  scree_jobs jobs;
  const kernel_set* kernels;
  surface_source source;
  surface_cubes table;
  uint32_t bricks[3], brick_count;
  surface_brick* brick; /* x fastest; all are `changed` at first */
  uint32_t* list;       /* [brick_count] scratch */
  surface_block* blocks;
  uint32_t worker_count;
  scree_surface_vertex* vertices;
  uint32_t* indices;
  uint32_t vertex_capacity, index_capacity;
} surface_mesher;

scree_result surface_mesher_create(const surface_source* source, const scree_jobs* jobs, const scree_allocator* allocator,
                                   surface_mesher* out);
void surface_mesher_destroy(surface_mesher* mesher); /* all zero is allowed */

/* Marks the bricks that may have a vertex in the box min <= p <= max, in voxels; no coordinate of max is negative. */
void surface_mesher_touch(surface_mesher* mesher, const int32_t min[3], const int32_t max[3]);

/* Makes what changed anew, and the mesh. Two triangles of a quad follow each other and share their first corner's diagonal, as in
 * abc, acd. When memory runs out, what was not made is still marked. */
scree_result surface_mesher_update(surface_mesher* mesher, scree_surface* out);

/* Volume inside a closed mesh, cubic units. */
double surface_volume(const scree_surface* surface);

/* Moves the vertices of the mesh along their normals, all by the same distance but at most `most`, until it holds `wanted`; those
 * on the ground stay on it. A mesh with its vertices on the surface lies inside what is round, and looks shrunken when it is
 * coarse. */
scree_result surface_match_volume(surface_mesher* mesher, const scree_surface* surface, double wanted, float most);

/* The binomial blur [1 2 1]^3 / 64 of raw values: RAW_SIDE a side to BLOCK_SIDE a side. raw is overwritten. */
void surface_blur(float* raw, float* out);

/* Lets a field at y < 0 go on as it is at y = 0 and 1. For blocks of the lowest bricks. */
void surface_continue_below(float* field);

/* run(context, index, worker) for all of `count`, on the host's jobs if there are any. */
void run_jobs(const scree_jobs* jobs, uint32_t count, void (*run)(void* context, uint32_t index, uint32_t worker), void* context);

#endif
