#include "plain_encode.h"

#include <string.h>

#include "allocator.h"
#include "mesh_digest.h"
#include "plain_mesh.h"
#include "uv_bytes.h"

/* Writes a number of 1 or 2 bytes and returns what is behind it. */
static uint8_t* put(uint8_t* at, uint32_t size, uint32_t number) {
  const uint16_t wide = (uint16_t)number;
  if (size == 1)
    *at = (uint8_t)number;
  else
    memcpy(at, &wide, sizeof wide);
  return at + size;
}

scree_result plain_encode(const lattice_mesh* mesh, const scree_allocator* given, rock_lod* out) {
  const scree_allocator allocator = scree_rt_allocator_or_default(given);
  *out = (rock_lod){.error = mesh->error};
  if (mesh->triangle_count == 0 || (mesh->uvs != NULL && mesh->surface == NULL)) return SCREE_ERROR_INVALID_ARGUMENT;
  if (mesh->vertex_count > PLAIN_MESH_MAX_VERTICES || mesh->triangle_count > UINT32_MAX / 8) return SCREE_ERROR_RANGE;
  for (size_t i = 0; i < (size_t)mesh->triangle_count * 3; ++i)
    if (mesh->indices[i] >= mesh->vertex_count) return SCREE_ERROR_INVALID_ARGUMENT;

  int16_t low[3], high[3];
  memcpy(low, mesh->positions[0], sizeof low);
  memcpy(high, low, sizeof high);
  for (uint32_t v = 1; v < mesh->vertex_count; ++v)
    for (int axis = 0; axis < 3; ++axis) {
      const int16_t p = mesh->positions[v][axis];
      if (p < low[axis]) low[axis] = p;
      if (p > high[axis]) high[axis] = p;
    }
  bool narrow = true;
  for (int axis = 0; axis < 3; ++axis) narrow &= high[axis] - low[axis] <= UINT8_MAX;
  const uint32_t position_size = narrow ? 1 : 2, index_size = mesh->vertex_count <= 256 ? 1 : 2;

  const uint32_t surface_size = mesh->surface != NULL ? sizeof *mesh->surface : 0,
                 uv_size = mesh->uvs != NULL ? sizeof(scree_uv) : 0;
  const uint32_t vertex_size = 3 * position_size + 1 + surface_size + uv_size;
  const uint32_t size = PLAIN_MESH_HEAD + mesh->vertex_count * vertex_size + mesh->triangle_count * 3 * index_size;
  uint8_t* blob = scree_rt_allocate(&allocator, size, 1);
  uint16_t(*uvs)[2] = mesh->uvs != NULL ? scree_rt_allocate(&allocator, mesh->vertex_count, sizeof *uvs) : NULL;
  if (blob == NULL || (mesh->uvs != NULL && uvs == NULL)) {
    scree_rt_release(&allocator, blob, size, 1);
    scree_rt_release(&allocator, uvs, mesh->vertex_count, sizeof *uvs);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  memcpy(blob, low, sizeof low);
  blob[6] = (uint8_t)position_size;
  blob[7] = (uint8_t)index_size;
  uint8_t* at = blob + PLAIN_MESH_HEAD;
  for (uint32_t v = 0; v < mesh->vertex_count; ++v)
    for (int axis = 0; axis < 3; ++axis) at = put(at, position_size, (uint32_t)(mesh->positions[v][axis] - low[axis]));
  memcpy(at, mesh->occlusion, mesh->vertex_count);
  at += mesh->vertex_count;
  if (mesh->surface != NULL) {
    memcpy(at, mesh->surface, mesh->vertex_count * sizeof *mesh->surface);
    at += mesh->vertex_count * sizeof *mesh->surface;
  }
  if (mesh->uvs != NULL) {
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) uv_values(mesh, v, uvs[v]);
    memcpy(at, uvs, mesh->vertex_count * sizeof *uvs);
    at += mesh->vertex_count * sizeof *uvs;
  }
  for (size_t i = 0; i < (size_t)mesh->triangle_count * 3; ++i) at = put(at, index_size, mesh->indices[i]);

  out->blob = blob;
  out->blob_size = size;
  out->vertex_count = mesh->vertex_count;
  out->triangle_count = mesh->triangle_count;
  const size_t stride = sizeof *mesh->positions;
  if (mesh->surface != NULL)
    out->digest = scree_rt_model_digest(mesh->positions, stride, mesh->occlusion, (const uint8_t(*)[4])mesh->surface,
                                        (const uint16_t(*)[2])uvs, mesh->indices, mesh->triangle_count);
  else
    out->digest = scree_rt_mesh_digest(mesh->positions, stride, mesh->occlusion, 1, mesh->indices, mesh->triangle_count);
  scree_rt_release(&allocator, uvs, mesh->vertex_count, sizeof *uvs);
  return SCREE_OK;
}
