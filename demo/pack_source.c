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
  *out = (render_source){.asset_count = info.asset_count,
                         .lod_count = info.lod_count,
                         .lattice_per_cell = (float)info.lattice_per_cell,
                         .assets = assets,
                         .decode = decode,
                         .user = (void*)(uintptr_t)pack,
                         .look = info.kind == SCREE_PACK_CLIFF    ? RENDER_LOOK_CLIFF
                                 : info.kind == SCREE_PACK_MODELS ? RENDER_LOOK_HOODOO
                                                                  : RENDER_LOOK_STONE};
  return SCREE_OK;
}

static bool place(void* user, uint32_t asset, uint32_t lod, scree_vertex* vertices, uint16_t* indices) {
  (void)lod;
  scene_models_vertices(user, asset, vertices, indices);
  return true;
}

scree_result models_source(const scene_models* models, render_source* out) {
  render_asset* assets = calloc(models->count, sizeof *assets);
  if (assets == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  for (uint32_t i = 0; i < models->count; ++i) {
    const scene_model_mesh* m = &models->models[i];
    memcpy(assets[i].centre, m->centre, sizeof assets[i].centre);
    assets[i].radius = m->radius;
    assets[i].vertices[0] = m->mesh.vertex_count;
    assets[i].triangles[0] = m->mesh.triangle_count;
  }
  *out = (render_source){.asset_count = models->count,
                         .lod_count = 1,
                         .lattice_per_cell = models->steps_per_metre,
                         .assets = assets,
                         .decode = place,
                         .user = (void*)(uintptr_t)models,
                         .look = RENDER_LOOK_PAINTED};
  return SCREE_OK;
}
