/* A closed triangle mesh as a support: its signed distance, sampled on a grid when the support is made. */
#ifndef SCREE_SUPPORT_MESH_H
#define SCREE_SUPPORT_MESH_H

#include "support_share.h"

/* Cells along each side of a brick. */
#define MESH_BRICK 8

typedef struct support_mesh {
  support_share share;
  /* size[0] * size[1] * size[2], x fastest: the sample in the low 16 bits and its neighbour along y in the high ones, both signed
   * multiples of `quantum`, negative inside, > 0 on the grid's outer faces. So two loads of 64 bits give all eight corners. */
  uint32_t* samples;
  uint32_t size[3]; /* each >= 2 */
  float quantum;    /* metres */
  double middle[3]; /* of the grid in the mesh's space: positions below are relative to it */
  float low[3];     /* of sample (0, 0, 0) */
  float high[3];    /* of the last sample */
  float step;       /* metres between samples */
  float inverse_step;
  float lipschitz; /* of the interpolated distance: up to sqrt(3) where surfaces are equally far */
  /* The same for what lies in a brick of cells or its neighbours, so within MESH_BRICK cells of any point of the brick: by a smooth
   * surface that is hardly more than 1. bricks[0] * bricks[1] * bricks[2], x fastest. */
  float* brick_lipschitz;
  uint32_t bricks[3];
} support_mesh;

/* Checks that the mesh is closed and not inside out; its numbers were checked before. shape_index is for the error's text.
 * Returns SCREE_OK, INVALID_ARGUMENT, NOT_CLOSED or OUT_OF_MEMORY. */
scree_result scree_rt_support_mesh_check(const scree_shape* shape, uint32_t shape_index, const scree_allocator* allocator,
                                         scree_error* error);

/* Samples the distance; the mesh was checked. NULL when out of memory. */
support_mesh* scree_rt_support_mesh_create(const scree_shape* shape, support_key key, const scree_jobs* jobs,
                                           const scree_allocator* allocator);
void scree_rt_support_mesh_drop(support_mesh* grid); /* NULL is allowed */

#endif
