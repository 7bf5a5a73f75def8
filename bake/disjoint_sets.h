/* Disjoint sets of numbers: each has a parent, the least of a set is its root and its own parent. */
#ifndef SCREE_DISJOINT_SETS_H
#define SCREE_DISJOINT_SETS_H

#include <stdint.h>

static inline uint32_t root_of(uint32_t* parents, uint32_t i) {
  while (parents[i] != i) i = parents[i] = parents[parents[i]];
  return i;
}

static inline void join(uint32_t* parents, uint32_t a, uint32_t b) {
  a = root_of(parents, a);
  b = root_of(parents, b);
  if (a < b)
    parents[b] = a;
  else
    parents[a] = b;
}

#endif
