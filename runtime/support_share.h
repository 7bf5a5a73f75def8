/* Grids of meshes and heightfields, which supports may share: counted, immutable, known by a digest of what they were made from. */
#ifndef SCREE_SUPPORT_SHARE_H
#define SCREE_SUPPORT_SHARE_H

#include <scree/support.h>
#include <stdatomic.h>

typedef struct support_key {
  uint64_t low, high;
} support_key;

/* The first member of each grid. */
typedef struct support_share {
  scree_allocator allocator; /* that the grid was made with and goes back to */
  support_key key;
  atomic_uint uses;
} support_share;

/* 128 bits of XXH3 over everything that decides about the grid of a heightfield or a mesh. */
support_key scree_rt_support_key(const scree_shape* shape);

static inline bool support_same_key(support_key a, support_key b) {
  return a.low == b.low && a.high == b.high;
}

/* One more use, from any thread that holds one. */
static inline void support_keep(support_share* share) {
  atomic_fetch_add_explicit(&share->uses, 1, memory_order_relaxed);
}

/* One use less; true when it was the last. */
static inline bool support_drop(support_share* share) {
  return atomic_fetch_sub_explicit(&share->uses, 1, memory_order_acq_rel) == 1;
}

#endif
