/* The digests of a pack, shared by the reader and the writer. xxHash is compiled in, so that nothing of it is linked. */
#include "pack_format.h"

#define XXH_INLINE_ALL
#include <string.h>
#include <xxhash.h>

uint32_t scree_rt_pack_kinds(const pack_header* header) {
  return header->kind == SCREE_PACK_CLIFF    ? PACK_SECTION_KINDS
         : header->kind == SCREE_PACK_MODELS ? PACK_MODEL_KINDS
                                             : PACK_TILE_KINDS;
}

uint32_t scree_rt_pack_element_size(uint32_t kind, bool narrow) {
  switch (kind) {
    case PACK_RECIPE: return 1;
    case PACK_TILES: return 4;
    case PACK_CELLS: return 4;
    case PACK_ASSETS: return sizeof(pack_asset);
    case PACK_LODS: return sizeof(pack_lod);
    case PACK_CONTACTS: return narrow ? sizeof(pack_narrow_contact) : sizeof(pack_contact);
    case PACK_HULLS: return 3 * (narrow ? sizeof(int8_t) : sizeof(int16_t));
    case PACK_BLOB_INDEX: return sizeof(pack_blob);
    case PACK_BLOBS: return 1;
    case PACK_PARTS: return 4;
    case PACK_MODELS: return sizeof(pack_model);
    case PACK_PLACEMENTS: return sizeof(pack_placement);
    case PACK_TIMES: return sizeof(pack_time);
    case PACK_UVS: return sizeof(pack_uvs);
    default: return 0;
  }
}

uint64_t scree_rt_pack_bytes_digest(const void* bytes, size_t size) {
  return XXH3_64bits(bytes, size);
}

uint32_t scree_rt_pack_header_check(const pack_header* header) {
  return (uint32_t)XXH3_64bits(header, offsetof(pack_header, header_check));
}

uint64_t scree_rt_pack_digest(const pack_header* header, const pack_section* sections[PACK_SECTION_KINDS]) {
  enum { NUMBERS = offsetof(pack_header, header_check) - offsetof(pack_header, cells_per_cube) };
  uint8_t canonical[NUMBERS + PACK_SECTION_KINDS * sizeof(uint64_t)];
  memcpy(canonical, &header->cells_per_cube, NUMBERS);
  size_t size = NUMBERS;
  for (size_t kind = 1; kind <= scree_rt_pack_kinds(header); ++kind) {
    if (kind > PACK_CANONICAL_KINDS && kind <= PACK_TILE_KINDS) continue;
    memcpy(canonical + size, &sections[kind - 1]->digest, sizeof(uint64_t));
    size += sizeof(uint64_t);
  }
  return XXH3_64bits(canonical, size);
}
