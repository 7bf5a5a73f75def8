/* What is solid, as columns of intervals along gravity. Places here are in the frame of rubble: y up, against gravity. */
#ifndef SCREE_RUBBLE_DEXELS_H
#define SCREE_RUBBLE_DEXELS_H

#include "allocator.h"

#define DEXEL_END UINT32_MAX

typedef struct dexel {
  double low, high;
  uint32_t next; /* above, DEXEL_END at the top; a gap lies between */
  uint32_t padding;
} dexel;

typedef struct dexels {
  scree_allocator allocator;
  double origin[2]; /* x, z of the grid's corner: column i, k is round origin + (i + 0.5, k + 0.5) * size */
  double size;
  uint32_t count[2];
  uint32_t* first; /* of each column i + count[0] * k: its lowest interval */
  dexel* pool;
  uint32_t pool_count, pool_capacity;
} dexels;

/* Columns without anything in them. Returns SCREE_OK or OUT_OF_MEMORY; then nothing is owned. */
scree_result dexels_create(const scree_allocator* allocator, const double origin[2], double size, const uint32_t count[2],
                           dexels* out);
void dexels_free(dexels* d);

/* Returns as dexels_create. */
scree_result dexels_copy(const dexels* from, dexels* out);

/* Whether a height of a column is within what is solid; nothing is beyond the grid. */
bool dexels_hold(const dexels* d, const int32_t column[2], double height);

/* Makes low..high of a column solid; what it meets or touches becomes one interval with it. Returns false when memory is short. */
bool dexels_add(dexels* d, uint32_t column, double low, double high);

#endif
