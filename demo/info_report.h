/* What is inside a pack, as text for people and as JSON. */
#ifndef INFO_REPORT_H
#define INFO_REPORT_H

#include <scree/pack.h>

#include "buffer.h"

enum { INFO_LODS = 8, INFO_CONTACT_BINS = 27 };

typedef struct info_range {
  double least, greatest, sum;
} info_range;

typedef struct info_lod {
  uint64_t triangles, vertices, bytes;
  info_range triangles_per_mesh;
  float error, error_95; /* cells: the largest, and what 95 of 100 meshes do not pass */
  double error_sum;
  uint32_t meshes;
} info_lod;

typedef struct info_report {
  scree_pack_info pack;
  scree_pack_section sections[SCREE_PACK_SECTIONS];
  uint32_t section_count;
  info_lod lods[INFO_LODS];
  info_lod whole[INFO_LODS], parts[INFO_LODS]; /* proxies of tiles, and of their eighths */
  uint32_t rocks_with_burial[SCREE_BURIAL_NEVER + 1];
  info_range volume, inner_radius, outer_radius; /* cells */
  info_range hull_vertices;
  info_range contacts;
  uint32_t rocks_with_contacts[INFO_CONTACT_BINS]; /* the last bin holds all above too */
} info_report;

/* Reads every record. Returns SCREE_OK, CORRUPT, UNSUPPORTED (more levels than INFO_LODS) or OUT_OF_MEMORY; *asset is then the
 * asset at fault. */
scree_result info_gather(const scree_pack* pack, info_report* out, uint32_t* asset);

void info_write_text(const info_report* report, const scree_pack* pack, const char* path, text_buffer* out);

/* One JSON object. Numbers read back as the same float; digests are 16 hexadecimal digits. Three assets are shown whole, so that
 * another reader can be held against this one. */
void info_write_json(const info_report* report, const scree_pack* pack, text_buffer* out);

#endif
