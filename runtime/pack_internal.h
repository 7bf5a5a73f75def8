/* An open pack, as the files of the runtime that read packs see it. */
#ifndef SCREE_PACK_INTERNAL_H
#define SCREE_PACK_INTERNAL_H

#include <scree/pack.h>

#include "map_file.h"
#include "pack_format.h"

/* Typed views of the mapped sections. The sizes of all arrays were checked against one another on opening; their contents were
 * not, and are checked where they are read. */
struct scree_pack {
  scree_allocator allocator;
  mapped_file file; /* empty when the bytes are the caller's */
  const uint8_t* bytes;
  size_t size;
  const pack_header* header;                        /* first_bytes */
  pack_header first_bytes;                          /* a copy: what bounds the arrays holds even if the bytes change */
  const pack_section* sections[PACK_SECTION_KINDS]; /* by kind - 1; NULL for those that packs of its kind lack */

  const char* recipe;
  const uint32_t* tiles;
  const uint32_t* cells;
  const pack_asset* assets;
  const pack_lod* lods;
  const uint8_t* contacts; /* of either width, see scree_rt_pack_read_contact() */
  const uint8_t* hulls;
  const pack_blob* blob_index;
  const uint8_t* blobs;
  const uint32_t* parts;            /* packs of models and cliffs */
  const pack_model* models;         /* packs of models and cliffs */
  const pack_placement* placements; /* cliffs, as the next two */
  const pack_time* times;
  const pack_uvs* uvs;

  uint32_t cell_count;
  uint32_t asset_count;
  uint32_t proxy_count;
  uint64_t contact_count;
  uint64_t hull_count; /* vertices */
  uint64_t part_count;
  uint32_t placement_count, time_count;
  uint64_t blob_bytes;
  bool narrow_contacts, narrow_hulls;
  scree_pack_kind kind;
  float reach; /* what no radius, error or coordinate of a centroid passes, cells */
};

static inline const void* section_bytes(const scree_pack* pack, uint32_t kind) {
  return pack->bytes + pack->sections[kind - 1]->offset;
}

static inline uint64_t section_elements(const scree_pack* pack, uint32_t kind) {
  return pack->sections[kind - 1]->size / pack->sections[kind - 1]->element_size;
}

#ifdef __cplusplus
extern "C" {
#endif

/* The contact at an index below contact_count, as it is stored: neighbour and seed are not checked. */
pack_contact scree_rt_pack_read_contact(const scree_pack* pack, uint64_t index);

/* scree_pack_coarse_mesh with indices of 2 or 4 bytes. */
scree_result scree_rt_pack_coarse_mesh(const scree_pack* pack, uint32_t asset, scree_vertex* vertices, size_t vertex_capacity,
                                       void* indices, uint32_t index_size, size_t index_capacity);

/* Checks the numbers of a cliff that bound others, as scree_pack_open_memory does of the other sections. */
scree_result scree_rt_pack_read_cliff(scree_pack* pack);

/* Checks times and placements, for scree_pack_verify. */
scree_result scree_rt_pack_verify_cliff(const scree_pack* pack);

#ifdef __cplusplus
}
#endif

#endif
