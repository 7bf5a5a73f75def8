#include "digest_surface.h"

#include <stdlib.h>
#include <string.h>

#include "lattice.h"
#include "pack_format.h"
#include "weather_asset.h"

static uint64_t digest_bytes(uint64_t digest, const void* bytes, size_t size) {
  return hash_combine(digest, scree_rt_pack_bytes_digest(bytes, size));
}

static uint64_t digest_asset(uint64_t digest, const weather_asset* asset) {
  for (uint32_t lod = 0; lod < asset->lod_count; ++lod) {
    const lattice_mesh* mesh = &asset->lods[lod].mesh;
    digest = digest_bytes(digest, mesh->positions, mesh->vertex_count * sizeof *mesh->positions);
    digest = digest_bytes(digest, mesh->occlusion, mesh->vertex_count);
    digest = digest_bytes(digest, mesh->surface, mesh->vertex_count * sizeof *mesh->surface);
    digest = digest_bytes(digest, mesh->indices, (size_t)mesh->triangle_count * 3 * sizeof *mesh->indices);
    digest = digest_bytes(digest, &mesh->error, sizeof mesh->error);
  }
  digest = digest_bytes(digest, asset->centroid, sizeof asset->centroid);
  const float numbers[5] = {asset->volume, asset->inner_radius, asset->outer_radius, asset->footprint, asset->parts_air};
  digest = digest_bytes(digest, numbers, sizeof numbers);
  digest = digest_bytes(digest, asset->hull, asset->hull_count * sizeof *asset->hull);
  for (uint32_t part = 0; part < asset->part_count; ++part)
    digest = digest_bytes(digest, asset->parts[part].hull, asset->parts[part].hull_count * sizeof *asset->parts[part].hull);
  return digest;
}

uint64_t digest_surface(void) {
  static const scree_durability_point beds[5] = {
      {0, 1.7, 0.6, 9, 1}, {0.3, 0.5, 0.6, 9, 1.5}, {0.55, 0.45, 0.6, 9, 1}, {0.6, 1.8, 0.6, 12, 1}, {1, 1.2, 0.6, 12, 1}};
  scree_weather_desc desc = {.start = {.kind = SCREE_START_JOINTS,
                                       .size = {72, 44, 60},
                                       .box_min = {12, 0, 12},
                                       .box_max = {60, 40, 48},
                                       .joint_spacing = 22,
                                       .joint_gap = 0.1,
                                       .joint_warp = 0.2,
                                       .joint_low = 0.6,
                                       .seed = 11}};
  scree_weather_rules_default(&desc.rules);
  desc.rules.durability = beds;
  desc.rules.durability_count = 5;
  desc.rules.colluvium_share = 0.3;
  scree_weather* w = NULL;
  scree_mesher* mesher = NULL;
  uint64_t digest = 0;
  if (scree_weather_create(&desc, &w, NULL) != SCREE_OK || scree_weather_run(w, 0.45, 200, NULL, NULL) != SCREE_OK ||
      scree_mesher_create(w, &mesher) != SCREE_OK)
    abort();
  for (uint32_t level = 0; level < 3; ++level) {
    scree_surface surface;
    if (scree_mesher_update(mesher, level, &surface) != SCREE_OK) abort();
    digest = digest_bytes(digest, surface.vertices, surface.vertex_count * sizeof *surface.vertices);
    digest = digest_bytes(digest, surface.indices,
                          ((size_t)surface.rock_triangles + surface.colluvium_triangles) * 3 * sizeof(uint32_t));
    digest = hash_combine(digest, surface.rock_triangles);
  }
  weather_asset asset;
  if (weather_asset_make(mesher, desc.start.size, 32, 4, NULL, &asset) != SCREE_OK) abort();
  digest = digest_asset(digest, &asset);
  weather_asset_destroy(&asset, NULL);
  scree_mesher_destroy(mesher);
  scree_weather_destroy(w);
  return digest;
}
