/* The rocks of each tile, and of its eighths, merged into one closed mesh for views from afar: scree_pack_proxy. */
#ifndef SCREE_PROXIES_H
#define SCREE_PROXIES_H

#include "bake_internal.h"

enum { PROXY_PARTS = 9 };

/* One worker's room, and the grid that all proxies of a bake are made on. */
typedef struct proxy_scratch {
  const bake_run* bake;
  uint32_t mask_per_cell;   /* mask voxels per cell */
  uint32_t voxels;          /* mask voxels to a sample, along each axis */
  uint32_t size;            /* samples a side: the tile and a cell on all sides */
  uint32_t step;            /* lattice steps to a sample */
  uint16_t* counts;         /* [PROXY_PARTS][size^3] full voxels of each sample */
  float* density;           /* [size^3] of the union, its gaps and voids filled */
  float* values;            /* of a level */
  uint64_t *rows, *scratch; /* one bit a sample or less, and 2 words a row */
  size_t samples, value_capacity, row_capacity;
  mesh_buffer fine, mesh;
  float* points;
  uint32_t* fans;
  uint32_t point_capacity, fan_capacity;
} proxy_scratch;

/* Lattice steps per cell of the vertices of a recipe's proxies. */
uint32_t proxies_per_cell(const bake_run* bake);

scree_result proxy_scratch_create(const bake_run* bake, proxy_scratch* out);
void proxy_scratch_destroy(proxy_scratch* scratch);

/* The proxies of one tile. masks: by slot. rock_occlusion: mean of all rocks' vertices, which proxies take over, 0..255. out:
 * zeroed; on failure the caller still frees what it owns. */
scree_result proxies_of_tile(proxy_scratch* scratch, uint32_t code, const rock_mask* masks, uint32_t rock_occlusion,
                             proxy_record out[PROXY_PARTS]);

#endif
