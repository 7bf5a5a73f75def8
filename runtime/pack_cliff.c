/* What packs of cliffs have beside models: times, placements of blocks, UVs. */
#include <string.h>

#include "pack_internal.h"
#include "plain_mesh.h"

/* 21 bits, each moved to three times its place. */
static uint64_t spread(uint64_t bits) {
  static const uint64_t masks[5] = {0x1f00000000ffff, 0x1f0000ff0000ff, 0x100f00f00f00f00f, 0x10c30c30c30c30c3, 0x1249249249249249};
  for (int step = 0; step < 5; ++step) bits = (bits | bits << (32 >> step)) & masks[step];
  return bits;
}

uint64_t scree_rt_pack_place_code(const float translation[3]) {
  uint64_t code = 0;
  for (int axis = 0; axis < 3; ++axis) code |= spread((uint64_t)(((double)translation[axis] + PACK_MAX_MODEL_REACH) * 128)) << axis;
  return code;
}

scree_result scree_rt_pack_read_cliff(scree_pack* pack) {
  const uint64_t times = section_elements(pack, PACK_TIMES), placements = section_elements(pack, PACK_PLACEMENTS);
  if (section_elements(pack, PACK_UVS) != 1 || times < 1 || times > PACK_MAX_ROCKS_PER_CELL || placements > UINT32_MAX)
    return SCREE_ERROR_CORRUPT;
  if (pack->asset_count != times + pack->cell_count - 1) return SCREE_ERROR_CORRUPT;
  const pack_uvs* uvs = section_bytes(pack, PACK_UVS);
  for (int axis = 0; axis < 2; ++axis)
    if (!within(uvs->min[axis], PACK_MAX_UV) || !within(uvs->max[axis], PACK_MAX_UV) || uvs->min[axis] > uvs->max[axis])
      return SCREE_ERROR_CORRUPT;
  pack->uvs = uvs;
  pack->times = section_bytes(pack, PACK_TIMES);
  pack->placements = section_bytes(pack, PACK_PLACEMENTS);
  pack->time_count = (uint32_t)times;
  pack->placement_count = (uint32_t)placements;
  return SCREE_OK;
}

scree_result scree_pack_get_time(const scree_pack* pack, uint32_t time, scree_cliff_time* out) {
  if (pack == NULL || out == NULL || time >= pack->time_count) return SCREE_ERROR_INVALID_ARGUMENT;
  scree_model model;
  const scree_result result = scree_pack_get_model(pack, time, &model);
  if (result != SCREE_OK) return result;
  if (model.variant != 0 || model.age != time) return SCREE_ERROR_CORRUPT;
  const pack_time* record = &pack->times[time];
  const uint64_t first = time == 0 ? 0 : (uint64_t)record[-1].first_placement + record[-1].placement_count;
  const uint64_t end = (uint64_t)record->first_placement + record->placement_count;
  if (record->first_placement != first || end > pack->placement_count) return SCREE_ERROR_CORRUPT;
  if (time + 1 == pack->time_count && end != pack->placement_count) return SCREE_ERROR_CORRUPT;
  for (int axis = 0; axis < 3; ++axis) {
    const float low = record->bounds_min[axis], high = record->bounds_max[axis];
    if (!within(low, 4 * pack->reach) || !within(high, 4 * pack->reach) || low > high) return SCREE_ERROR_CORRUPT;
    if (record->placement_count == 0 && (low != 0 || high != 0)) return SCREE_ERROR_CORRUPT;
  }
  *out = (scree_cliff_time){
      .asset = time,
      .paths = model.steps,
      .share = model.share,
      .first_placement = record->first_placement,
      .placement_count = record->placement_count,
  };
  memcpy(out->bounds_min, record->bounds_min, sizeof out->bounds_min);
  memcpy(out->bounds_max, record->bounds_max, sizeof out->bounds_max);
  return SCREE_OK;
}

scree_result scree_pack_get_placements(const scree_pack* pack, uint32_t first, uint32_t count, scree_block_placement* placements) {
  if (pack == NULL || pack->times == NULL || (placements == NULL && count > 0)) return SCREE_ERROR_INVALID_ARGUMENT;
  if (first > pack->placement_count || count > pack->placement_count - first) return SCREE_ERROR_INVALID_ARGUMENT;
  for (uint32_t i = 0; i < count; ++i) {
    const pack_placement* from = &pack->placements[(size_t)first + i];
    if (from->asset < pack->time_count || from->asset >= pack->asset_count) return SCREE_ERROR_CORRUPT;
    for (int axis = 0; axis < 3; ++axis)
      if (!within(from->translation[axis], pack->reach)) return SCREE_ERROR_CORRUPT;
    placements[i].asset = from->asset;
    memcpy(placements[i].translation, from->translation, sizeof from->translation);
  }
  return SCREE_OK;
}

scree_result scree_pack_coarse_uvs(const scree_pack* pack, uint32_t asset, scree_uv* uvs, uint8_t* groups, size_t capacity) {
  if (pack == NULL || pack->times == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  scree_lod level;
  const scree_result result = scree_pack_get_lod(pack, asset, pack->header->lod_count - 1, &level);
  if (result != SCREE_OK) return result;
  if (capacity < level.vertices) return SCREE_ERROR_CAPACITY;
  if (uvs == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  plain_mesh mesh;
  if (!scree_rt_plain_mesh_read(level.blob, level.blob_size, level.vertices, level.triangles, pack->kind, &mesh))
    return SCREE_ERROR_CORRUPT;
  memcpy(uvs, mesh.uvs, level.vertices * sizeof *uvs);
  for (uint32_t v = 0; v < level.vertices && groups != NULL; ++v) groups[v] = mesh.surface[v][3];
  return SCREE_OK;
}

scree_result scree_rt_pack_verify_cliff(const scree_pack* pack) {
  for (uint32_t t = 0; t < pack->time_count; ++t) {
    scree_cliff_time time;
    scree_result result = scree_pack_get_time(pack, t, &time);
    uint64_t before = 0;
    for (uint32_t i = 0; result == SCREE_OK && i < time.placement_count; ++i) {
      scree_block_placement block;
      result = scree_pack_get_placements(pack, time.first_placement + i, 1, &block);
      if (result != SCREE_OK) break;
      for (int axis = 0; axis < 3; ++axis)
        if (block.translation[axis] < time.bounds_min[axis] || block.translation[axis] > time.bounds_max[axis])
          return SCREE_ERROR_CORRUPT;
      const uint64_t code = scree_rt_pack_place_code(block.translation);
      if (code < before) return SCREE_ERROR_CORRUPT;
      before = code;
    }
    if (result != SCREE_OK) return result;
  }
  return SCREE_OK;
}
