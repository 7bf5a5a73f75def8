/* Checking a whole pack: every byte against its digest, then every record against the rules of the format. */
#include <string.h>

#include "pack_internal.h"
#include "plain_mesh.h"

static bool all_zero(const uint8_t* bytes, size_t size) {
  for (size_t i = 0; i < size; ++i)
    if (bytes[i] != 0) return false;
  return true;
}

static scree_result verify_bytes(const scree_pack* pack) {
  const pack_section* table = (const pack_section*)(const void*)(pack->bytes + sizeof(pack_header));
  uint64_t end = sizeof(pack_header) + pack->header->section_count * sizeof(pack_section);
  for (uint32_t i = 0; i < pack->header->section_count; ++i) {
    const pack_section* section = &table[i];
    if (!all_zero(pack->bytes + end, (size_t)(section->offset - end))) return SCREE_ERROR_DIGEST;
    if (scree_rt_pack_bytes_digest(pack->bytes + section->offset, (size_t)section->size) != section->digest)
      return SCREE_ERROR_DIGEST;
    end = section->offset + section->size;
  }
  return SCREE_OK;
}

static scree_result verify_tables(const scree_pack* pack) {
  const uint32_t n = pack->header->cells_per_cube;
  for (uint32_t i = 0; i < 256 * n * n * n; ++i)
    if (pack->tiles[i] >= pack->cell_count) return SCREE_ERROR_CORRUPT;
  for (uint32_t cell = 0; cell < pack->cell_count; ++cell) {
    uint32_t first, count;
    scree_result result = scree_pack_cell_assets(pack, cell, &first, &count);
    if (result != SCREE_OK) return result;
    for (uint32_t asset = first; asset < first + count; ++asset)
      if (pack->assets[asset].cell != cell || (asset > first && pack->assets[asset].seed <= pack->assets[asset - 1].seed))
        return SCREE_ERROR_CORRUPT;
    /* Every variant has the ages 0, 1, .. of its own. */
    if (pack->models != NULL && (count < 1 || pack->assets[first].seed != 0 || pack->assets[first + count - 1].seed != count - 1))
      return SCREE_ERROR_CORRUPT;
  }
  return strlen(pack->recipe) + 1 == pack->sections[PACK_RECIPE - 1]->size ? SCREE_OK : SCREE_ERROR_CORRUPT;
}

/* Of a rock or proxy. The coarsest level is looked into, because it needs no decoder. */
static scree_result verify_levels(const scree_pack* pack, uint32_t asset) {
  scree_lod level = {0};
  for (uint32_t lod = 0; lod < pack->header->lod_count; ++lod) {
    const scree_result result = scree_pack_get_lod(pack, asset, lod, &level);
    if (result != SCREE_OK) return result;
  }
  plain_mesh mesh;
  const bool good = scree_rt_plain_mesh_read(level.blob, level.blob_size, level.vertices, level.triangles, pack->kind, &mesh);
  return good ? SCREE_OK : SCREE_ERROR_CORRUPT;
}

static scree_result verify_model(const scree_pack* pack, uint32_t asset) {
  scree_model model;
  scree_result result = scree_pack_get_model(pack, asset, &model);
  for (uint32_t part = 0; result == SCREE_OK && part < model.part_count; ++part) {
    uint32_t count;
    result = scree_pack_get_part(pack, asset, part, NULL, 0, &count);
    if (result == SCREE_ERROR_CAPACITY) result = SCREE_OK;
  }
  return result;
}

static scree_result verify_asset(const scree_pack* pack, uint32_t asset) {
  scree_asset record;
  scree_result result = scree_pack_get_asset(pack, asset, &record);
  for (uint32_t i = 0; result == SCREE_OK && i < record.contact_count; ++i) {
    const pack_contact contact = scree_rt_pack_read_contact(pack, pack->assets[asset].first_contact + (uint64_t)i);
    if (contact.neighbour >= PACK_NEIGHBOURS || contact.seed >= pack->header->max_rocks_per_cell) result = SCREE_ERROR_CORRUPT;
  }
  if (result == SCREE_OK && pack->models != NULL) result = verify_model(pack, asset);
  return result;
}

scree_result scree_pack_verify(const scree_pack* pack) {
  if (pack == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  scree_result result = verify_bytes(pack);
  if (result == SCREE_OK) result = verify_tables(pack);
  for (uint32_t asset = 0; asset < pack->asset_count && result == SCREE_OK; ++asset) result = verify_asset(pack, asset);
  for (uint32_t mesh = 0; mesh < pack->asset_count + pack->proxy_count && result == SCREE_OK; ++mesh)
    result = verify_levels(pack, mesh);
  if (result == SCREE_OK && pack->times != NULL) result = scree_rt_pack_verify_cliff(pack);
  return result;
}
