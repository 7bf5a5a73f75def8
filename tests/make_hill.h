/* The solids of benchmarks of frost, and their shards. */
#ifndef MAKE_HILL_H
#define MAKE_HILL_H

#include <scree/shards.h>

/* A convex hill of `size` across: 3 rings of 24 walls, a flat top and the ground. Random seeds. NULL where shards cannot be made;
 * error: may be NULL. */
scree_shards* make_hill(uint32_t cells, double size, uint64_t random_seed, scree_error* error);

/* A ring of `size` across that lies on the ground: concave. Random seeds. */
scree_shards* make_ring(uint32_t cells, double size, uint64_t random_seed, scree_error* error);

/* A wall of `across` times `deep` hexagonal columns, `height` high, one length wide each; the last row is at the lowest z. */
scree_shards* make_columns(uint32_t across, uint32_t deep, double height, uint64_t random_seed, scree_error* error);

#endif
