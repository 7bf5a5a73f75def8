/* Levels of detail of a surface of shards, as meshes for the pack. */
#ifndef SCREE_SHARD_LEVELS_H
#define SCREE_SHARD_LEVELS_H

#include "mesh_simplify.h"
#include "shard_asset.h"
#include "surface_vertices.h"

/* A surface on the lattice, while it loses triangles. */
typedef struct shard_levels {
  scree_allocator allocator;
  simplify_mesh mesh; /* its arrays are owned */
  uint32_t* groups;   /* of each triangle: smooth over every edge within one */
  uint8_t* materials; /* of each triangle: material + durability, which is a multiple of 4, so that both have borders to keep */
  uint64_t* openness; /* by vertex and group, sorted: vertex << 40 | group << 8 | occlusion */
  uint32_t* rank;     /* of each vertex: equal for equal places */
  uint32_t rank_count;
  mesh_simplifier* simplifier;
} shard_levels;

/* places: of each vertex of the shards, lattice steps. Returns SCREE_OK, INVALID_ARGUMENT (not closed) or OUT_OF_MEMORY; on failure
 * nothing is held. */
scree_result shard_levels_create(const shard_asset_desc* desc, const surface_vertices* surface, const int16_t (*places)[3],
                                 const scree_allocator* allocator, shard_levels* out);
void shard_levels_destroy(shard_levels* levels); /* all zero is allowed */

/* What is left now as a mesh of its own, which shard_level_release gives back; error is 0. */
scree_result shard_levels_take(const shard_levels* levels, lattice_mesh* out);
scree_result shard_level_copy(const lattice_mesh* from, const scree_allocator* allocator, lattice_mesh* out);
void shard_level_release(lattice_mesh* mesh, const scree_allocator* allocator);

#endif
