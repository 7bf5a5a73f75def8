#include <string.h>

#include "frost_internal.h"
#include "surface_vertices.h"

scree_result scree_frost_surface_create(const scree_frost* frost, uint32_t block, const scree_allocator* allocator,
                                        scree_frost_surface* out) {
  if (out == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  memset(out, 0, sizeof *out);
  if (frost == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  const scree_block* blocks;
  const uint32_t* list;
  const uint32_t block_count = scree_frost_blocks(frost, &blocks, &list);
  const bool standing = block == UINT32_MAX;
  if (!standing && block >= block_count) return SCREE_ERROR_INVALID_ARGUMENT;
  const scree_allocator from = scree_rt_allocator_or_default(allocator);
  const uint32_t count = frost->view.shard_count;
  uint8_t* inside = scree_rt_allocate_zeroed(&from, count, 1);
  if (inside == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  surface_desc desc = {.shards = &frost->view, .inside = inside, .ground = standing};
  for (uint32_t s = 0; standing && s < count; ++s) inside[s] = frost_stands(frost, s);
  if (!standing) {
    for (uint32_t i = 0; i < blocks[block].shard_count; ++i) inside[list[blocks[block].first_shard + i]] = 1;
    memcpy(desc.origin, blocks[block].centroid, sizeof desc.origin);
  }
  surface_vertices vertices;
  const scree_result result = surface_vertices_create(&desc, &from, &vertices);
  if (result == SCREE_OK) {
    *out = vertices.surface;
    memset(&vertices.surface, 0, sizeof vertices.surface);
    surface_vertices_destroy(&vertices, &from);
  }
  scree_rt_release(&from, inside, count, 1);
  return result;
}
