#include "pack_source.h"

#include <stdlib.h>
#include <string.h>

static bool decode(void* user, uint32_t asset, uint32_t lod, scree_vertex* vertices, uint16_t* indices) {
  const scree_pack* pack = user;
  scree_lod record;
  if (scree_pack_get_lod(pack, asset, lod, &record) != SCREE_OK) return false;
  return scree_draco_decode_u16(pack, asset, lod, vertices, record.vertices, indices, (size_t)3 * record.triangles) == SCREE_OK;
}

scree_result pack_source(const scree_pack* pack, render_source* out) {
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  if (info.lod_count > RENDER_LODS) return SCREE_ERROR_UNSUPPORTED;
  render_asset* assets = calloc(info.asset_count > 0 ? info.asset_count : 1, sizeof *assets);
  if (assets == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  for (uint32_t a = 0; a < info.asset_count; ++a) {
    scree_asset record;
    scree_result result = scree_pack_get_asset(pack, a, &record);
    memcpy(assets[a].centre, record.centroid, sizeof assets[a].centre);
    assets[a].radius = record.outer_radius;
    for (uint32_t lod = 0; lod < info.lod_count && result == SCREE_OK; ++lod) {
      scree_lod level;
      result = scree_pack_get_lod(pack, a, lod, &level);
      assets[a].errors[lod] = level.error;
      assets[a].vertices[lod] = level.vertices;
      assets[a].triangles[lod] = level.triangles;
    }
    if (result != SCREE_OK) {
      free(assets);
      return result;
    }
  }
  *out = (render_source){info.asset_count, info.lod_count, (float)info.lattice_per_cell, assets, decode, (void*)(uintptr_t)pack};
  return SCREE_OK;
}
