/* How many cells around a rock have to be full for nearly nobody to see it: scree_asset.burial. */
#ifndef SCREE_BURIAL_H
#define SCREE_BURIAL_H

#include <stdatomic.h>

#include "bake_internal.h"
#include "rock_mask.h"

/* One worker's room: a tile with the cells around it. */
typedef struct burial_scratch {
  uint8_t* owners; /* [side^3], see burial.c */
  size_t side;     /* voxels */
  uint32_t per_cell;
  uint64_t bytes_of[256]; /* 255 in byte i where bit i is set */
} burial_scratch;

scree_result burial_scratch_create(const bake_run* bake, burial_scratch* out);
void burial_scratch_destroy(const bake_run* bake, burial_scratch* scratch);

/* How many lines were followed from a rock, and how many of them no rock of the rings 0 .. b stops, for b = 1 .. */
typedef struct burial_count {
  atomic_uint lines, out[SCREE_BURIAL_NEVER];
} burial_count;

/* Follows lines from the rocks of one tile and adds to the counts. masks, rocks, counts: by slot. Tiles may be done in any order
 * and at the same time: sums do not show it. */
void burial_of_tile(const bake_run* bake, uint32_t code, const rock_mask* masks, const rock_record* rocks, burial_count* counts,
                    burial_scratch* scratch);

/* 1 .. SCREE_BURIAL_NEVER. */
uint32_t burial_of_rock(burial_count* count);

#endif
