/* Shards without Voronoi: a lattice of boxes, for tests of what works on shards. */
#ifndef MAKE_SHARDS_H
#define MAKE_SHARDS_H

#include "shards_internal.h"

/* size[0] * size[1] * size[2] boxes, the shard of box x, y, z being x + size[0] * (y + size[1] * z), centred on x = z = 0, from
 * y = 0 up. Sides are 1 where random_seed is 0, 0.6..1.4 drawn for each layer of boxes otherwise. Polygons, vertices, the solid
 * (with UVs) and both graphs are as scree_shards_create would give them; an edge within has four boxes round it, though, where
 * Voronoi cells in general position have three. Ends the program where memory is short. allocator: NULL = malloc and free. */
scree_shards* make_lattice(const uint32_t size[3], uint64_t random_seed, const scree_allocator* allocator);

#endif
