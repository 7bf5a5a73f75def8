/* The directed edges of a triangle mesh, from -> to as from << 32 | to, in an open hash table. No edge joins a vertex to itself, so
 * 0 marks an empty place. */
#ifndef SCREE_EDGE_TABLE_H
#define SCREE_EDGE_TABLE_H

#include <stddef.h>

#include "lattice.h"

typedef struct edge_table {
  uint64_t* edges;
  size_t size; /* a power of two, at least twice the number of edges */
} edge_table;

static inline uint64_t edge_key(uint32_t from, uint32_t to) {
  return (uint64_t)from << 32 | to;
}

/* The place of the edge, or the empty place where it belongs. */
static inline uint64_t* edge_place(const edge_table* table, uint64_t edge) {
  size_t at = (size_t)hash_mix(edge) & (table->size - 1);
  while (table->edges[at] != 0 && table->edges[at] != edge) at = (at + 1) & (table->size - 1);
  return &table->edges[at];
}

#endif
