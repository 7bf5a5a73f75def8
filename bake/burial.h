/* How many cells around a rock have to be full for nearly nobody to see it: scree_asset.burial. */
#ifndef SCREE_BURIAL_H
#define SCREE_BURIAL_H

#include <stdatomic.h>

#include "bake_internal.h"
#include "rock_mask.h"

/* One worker's room: a tile with the cells around it. */
typedef struct burial_scratch {
  uint8_t* owners; /* [side^3], see burial.c */
  uint8_t* added;  /* by cell: are its rocks in? */
  size_t side;     /* voxels */
  uint32_t per_cell;
  uint64_t bytes_of[256]; /* 255 in byte i where bit i is set */
} burial_scratch;

scree_result burial_scratch_create(const bake_run* bake, burial_scratch* out);
void burial_scratch_destroy(const bake_run* bake, burial_scratch* scratch);

/* Follows lines from the rocks of one tile and raises the burial of those that are seen from farther. All by slot; burials: begin
 * at 1, the least there is. Tiles may be done in any order and at the same time: maxima do not show it. */
void burial_of_tile(const bake_run* bake, uint32_t code, const rock_mask* masks, const rock_record* rocks, atomic_uint* burials,
                    burial_scratch* scratch);

#endif
