/* Stands for the encoder where there is no Draco: the digest of each mesh as draco_encode computes it, and a blob of zeros. The
 * digest of a pack does not cover blobs, so that a pack baked with this has the digest of a pack baked with Draco. */
#include "allocator.h"
#include "draco_encode.h"
#include "mesh_digest.h"
#include "occlusion.h"
#include "pack_format.h"
#include "uv_bytes.h"

scree_result draco_encode(const lattice_mesh* mesh, const scree_allocator* given, rock_lod* out) {
  const scree_allocator allocator = scree_rt_allocator_or_default(given);
  *out = (rock_lod){.error = mesh->error, .digest = scree_rt_mesh_digest(NULL, 0, NULL, 0, NULL, 0)};
  if (mesh->triangle_count == 0) return SCREE_OK;
  const uint32_t size = mesh->triangle_count / PACK_MAX_TRIANGLES_PER_BLOB_BYTE + 1;
  uint8_t* values = scree_rt_allocate(&allocator, mesh->vertex_count, 1);
  out->blob = scree_rt_allocate_zeroed(&allocator, size, 1);
  uint16_t(*uvs)[2] = mesh->uvs != NULL ? scree_rt_allocate(&allocator, mesh->vertex_count, sizeof *uvs) : NULL;
  if (values == NULL || out->blob == NULL || (mesh->uvs != NULL && uvs == NULL)) return SCREE_ERROR_OUT_OF_MEMORY;
  out->blob_size = size;
  out->vertex_count = mesh->vertex_count;
  out->triangle_count = mesh->triangle_count;
  for (uint32_t i = 0; i < mesh->vertex_count; ++i) values[i] = occlusion_value(occlusion_level(mesh->occlusion[i]));
  for (uint32_t i = 0; uvs != NULL && i < mesh->vertex_count; ++i) uv_values(mesh, i, uvs[i]);
  const size_t stride = sizeof *mesh->positions;
  if (mesh->surface != NULL)
    out->digest = scree_rt_model_digest(mesh->positions, stride, values, (const uint8_t(*)[4])mesh->surface,
                                        (const uint16_t(*)[2])uvs, mesh->indices, mesh->triangle_count);
  else
    out->digest = scree_rt_mesh_digest(mesh->positions, stride, values, 1, mesh->indices, mesh->triangle_count);
  scree_rt_release(&allocator, uvs, mesh->vertex_count, sizeof *uvs);
  scree_rt_release(&allocator, values, mesh->vertex_count, 1);
  return SCREE_OK;
}
