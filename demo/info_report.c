#include "info_report.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void widen(info_range* range, double value) {
  range->least = value < range->least ? value : range->least;
  range->greatest = value > range->greatest ? value : range->greatest;
  range->sum += value;
}

enum { MODELS_SHOWN = 100 };

static const info_range nothing = {INFINITY, -INFINITY, 0};

static scree_result add_level(const scree_pack* pack, uint32_t asset, uint32_t lod, info_lod* sum, float* errors) {
  scree_lod level;
  const scree_result result = scree_pack_get_lod(pack, asset, lod, &level);
  if (result != SCREE_OK) return result;
  sum->triangles += level.triangles;
  sum->vertices += level.vertices;
  sum->bytes += level.blob_size;
  sum->error = level.error > sum->error ? level.error : sum->error;
  sum->error_sum += (double)level.error;
  errors[sum->meshes++] = level.error;
  widen(&sum->triangles_per_mesh, level.triangles);
  return SCREE_OK;
}

static int compare_floats(const void* a, const void* b) {
  const float x = *(const float*)a, y = *(const float*)b;
  return (x > y) - (x < y);
}

/* The levels of every `step`th mesh from `first` on. */
static scree_result gather_levels(const scree_pack* pack, uint32_t lod, uint32_t first, uint32_t end, uint32_t step, info_lod* out,
                                  float* errors, uint32_t* asset) {
  out->triangles_per_mesh = nothing;
  for (*asset = first; *asset < end; *asset += step) {
    const scree_result result = add_level(pack, *asset, lod, out, errors);
    if (result != SCREE_OK) return result;
  }
  qsort(errors, out->meshes, sizeof *errors, compare_floats);
  out->error_95 = errors[(95 * (uint64_t)out->meshes + 99) / 100 - 1];
  return SCREE_OK;
}

static scree_result gather_meshes(const scree_pack* pack, info_report* out, uint32_t* asset) {
  const uint32_t rocks = out->pack.asset_count, proxies = out->pack.proxy_count, tiles = proxies / 256;
  float* errors = malloc(((size_t)rocks + proxies) * sizeof *errors);
  if (errors == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  scree_result result = SCREE_OK;
  for (uint32_t lod = 0; lod < out->pack.lod_count && result == SCREE_OK; ++lod) {
    result = gather_levels(pack, lod, 0, rocks, 1, &out->lods[lod], errors, asset);
    if (proxies == 0 || result != SCREE_OK) continue;
    result = gather_levels(pack, lod, rocks, rocks + proxies, tiles, &out->whole[lod], errors, asset);
    out->parts[lod].triangles_per_mesh = nothing;
    for (uint32_t code = 0; code < 256 && result == SCREE_OK; ++code)
      for (uint32_t part = 1; part < tiles && result == SCREE_OK; ++part) {
        *asset = scree_pack_proxy(pack, code, part);
        result = add_level(pack, *asset, lod, &out->parts[lod], errors);
      }
    qsort(errors, out->parts[lod].meshes, sizeof *errors, compare_floats);
    out->parts[lod].error_95 = errors[(95 * (uint64_t)out->parts[lod].meshes + 99) / 100 - 1];
  }
  free(errors);
  return result;
}

scree_result info_gather(const scree_pack* pack, info_report* out, uint32_t* asset) {
  memset(out, 0, sizeof *out);
  scree_pack_get_info(pack, &out->pack);
  *asset = 0;
  if (out->pack.lod_count > INFO_LODS) return SCREE_ERROR_UNSUPPORTED;
  while (out->section_count < SCREE_PACK_SECTIONS &&
         scree_pack_get_section(pack, out->section_count, &out->sections[out->section_count]) == SCREE_OK)
    ++out->section_count;
  out->volume = out->inner_radius = out->outer_radius = out->hull_vertices = out->contacts = nothing;
  for (*asset = 0; *asset < out->pack.asset_count; ++*asset) {
    scree_asset rock;
    const scree_result result = scree_pack_get_asset(pack, *asset, &rock);
    if (result != SCREE_OK) return result;
    widen(&out->volume, (double)rock.volume);
    widen(&out->inner_radius, (double)rock.inner_radius);
    widen(&out->outer_radius, (double)rock.outer_radius);
    widen(&out->hull_vertices, rock.hull_vertices);
    widen(&out->contacts, rock.contact_count);
    ++out->rocks_with_contacts[rock.contact_count < INFO_CONTACT_BINS ? rock.contact_count : INFO_CONTACT_BINS - 1];
    ++out->rocks_with_burial[rock.burial];
  }
  return gather_meshes(pack, out, asset);
}

static void text_range(text_buffer* out, const char* name, const info_range* range, uint32_t count, const char* unit) {
  buffer_format(out, "  %-18s %9.3f  (%.3f .. %.3f) %s\n", name, range->sum / count, range->least, range->greatest, unit);
}

static void text_levels(text_buffer* out, const char* of, const info_lod* levels, uint32_t count) {
  buffer_format(out, "\nlevels of detail of %s\n", of);
  buffer_add(out, "         triangles of a mesh       vertices     bytes  bytes a triangle  error: mean   95 %   largest, cells\n");
  for (uint32_t lod = 0; lod < count; ++lod) {
    const info_lod* level = &levels[lod];
    const double meshes = level->meshes, triangles = (double)level->triangles;
    buffer_format(out, "  LOD %u  %10.1f  (%.0f .. %.0f)  %9.1f  %8.1f  %16.3f  %11.4f  %.4f  %.4f\n", lod, triangles / meshes,
                  level->triangles_per_mesh.least, level->triangles_per_mesh.greatest, (double)level->vertices / meshes,
                  (double)level->bytes / meshes, (double)level->bytes / triangles, level->error_sum / meshes,
                  (double)level->error_95, (double)level->error);
  }
}

static void text_recipe(const scree_pack_info* pack, text_buffer* out) {
  buffer_add(out, "\nrecipe\n");
  buffer_add(out, pack->recipe);
  if (pack->recipe_size == 0 || pack->recipe[pack->recipe_size - 1] != '\n') buffer_add(out, "\n");
}

static void text_models(const info_report* report, const scree_pack* pack, text_buffer* out) {
  buffer_add(out, "\nmodels\n  variant  age  share left   steps  height, m  footprint, m  parts  triangles     bytes\n");
  const uint32_t shown = report->pack.asset_count < MODELS_SHOWN ? report->pack.asset_count : MODELS_SHOWN;
  for (uint32_t i = 0; i < shown; ++i) {
    scree_model model;
    scree_lod level;
    if (scree_pack_get_model(pack, i, &model) != SCREE_OK || scree_pack_get_lod(pack, i, 0, &level) != SCREE_OK) return;
    uint64_t bytes = level.blob_size;
    const uint32_t triangles = level.triangles;
    for (uint32_t lod = 1; lod < report->pack.lod_count && scree_pack_get_lod(pack, i, lod, &level) == SCREE_OK; ++lod)
      bytes += level.blob_size;
    buffer_format(out, "  %7u  %3u  %8.1f %%  %6u  %9.2f  %12.2f  %5u  %9u  %8llu\n", model.variant, model.age,
                  100 * (double)model.share, model.steps, (double)model.height, (double)model.footprint, model.part_count,
                  triangles, (unsigned long long)bytes);
  }
  if (shown < report->pack.asset_count) buffer_format(out, "  and %u more\n", report->pack.asset_count - shown);
}

/* The box of the blocks of a time. The pack's own is that of the balls around them. */
static bool find_blocks(const scree_pack* pack, const scree_cliff_time* time, float min[3], float max[3]) {
  for (uint32_t i = 0; i < time->placement_count; ++i) {
    scree_block_placement placement;
    scree_asset asset;
    if (scree_pack_get_placements(pack, time->first_placement + i, 1, &placement) != SCREE_OK) return false;
    if (scree_pack_get_asset(pack, placement.asset, &asset) != SCREE_OK) return false;
    for (int a = 0; a < 3; ++a) {
      const float low = placement.translation[a] + asset.bounds_min[a], high = placement.translation[a] + asset.bounds_max[a];
      if (i == 0 || low < min[a]) min[a] = low;
      if (i == 0 || high > max[a]) max[a] = high;
    }
  }
  return time->placement_count > 0;
}

/* Blocks are many: how many there are and how large, instead of a line for each. */
static void text_cliff(const info_report* report, const scree_pack* pack, text_buffer* out) {
  buffer_add(out,
             "\ntimes of the cliff\n   time     paths  stands  height, m  parts  triangles     bytes  blocks that lie about\n");
  for (uint32_t t = 0; t < report->pack.time_count; ++t) {
    scree_cliff_time time;
    scree_model model;
    scree_lod level;
    if (scree_pack_get_time(pack, t, &time) != SCREE_OK || scree_pack_get_model(pack, time.asset, &model) != SCREE_OK) return;
    if (scree_pack_get_lod(pack, time.asset, 0, &level) != SCREE_OK) return;
    uint64_t bytes = level.blob_size;
    const uint32_t triangles = level.triangles;
    for (uint32_t lod = 1; lod < report->pack.lod_count && scree_pack_get_lod(pack, time.asset, lod, &level) == SCREE_OK; ++lod)
      bytes += level.blob_size;
    buffer_format(out, "  %5u  %8u  %4.1f %%  %9.2f  %5u  %9u  %8llu  %u", t, time.paths, 100 * (double)time.share,
                  (double)model.height, model.part_count, triangles, (unsigned long long)bytes, time.placement_count);
    float min[3], max[3];
    if (find_blocks(pack, &time, min, max))
      buffer_format(out, " within (%.2f, %.2f, %.2f) .. (%.2f, %.2f, %.2f) m", (double)min[0], (double)min[1], (double)min[2],
                    (double)max[0], (double)max[1], (double)max[2]);
    buffer_add(out, "\n");
  }
  info_range volume = nothing;
  uint64_t triangles = 0;
  const uint32_t first = report->pack.time_count, count = report->pack.asset_count - first;
  for (uint32_t i = first; i < report->pack.asset_count; ++i) {
    scree_asset asset;
    scree_lod level;
    if (scree_pack_get_asset(pack, i, &asset) != SCREE_OK || scree_pack_get_lod(pack, i, 0, &level) != SCREE_OK) return;
    widen(&volume, (double)asset.volume);
    triangles += level.triangles;
  }
  if (count > 0)
    buffer_format(out, "  %u blocks of %.3f .. %.3f m3, %.3f m3 together, %.1f triangles each\n", count, volume.least,
                  volume.greatest, volume.sum, (double)triangles / count);
  buffer_format(out, "  UVs of %g .. %g, %g .. %g\n", (double)report->pack.uv_min[0], (double)report->pack.uv_max[0],
                (double)report->pack.uv_min[1], (double)report->pack.uv_max[1]);
}

void info_write_text(const info_report* report, const scree_pack* open, const char* path, text_buffer* out) {
  const scree_pack_info* pack = &report->pack;
  buffer_add(out, path);
  buffer_format(out, ": scree pack, format %u, %.2f MB, digest %016llx\n", pack->format_version, 1e-6 * (double)pack->file_size,
                (unsigned long long)pack->digest);
  const bool cliff = pack->kind == SCREE_PACK_CLIFF, models = cliff || pack->kind == SCREE_PACK_MODELS;
  if (cliff) {
    buffer_format(out, "  a cliff at %u times, %u blocks that fell, %u placements of these\n", pack->time_count,
                  pack->variant_count - 1, pack->placement_count);
    buffer_format(out, "  a cell is a metre: %u lattice steps", pack->lattice_per_cell);
  } else if (models) {
    buffer_format(out, "  %u models: %u variants, each in up to %u ages\n", pack->asset_count, pack->variant_count,
                  pack->max_rocks_per_cell);
    buffer_format(out, "  a cell is a metre: %u lattice steps", pack->lattice_per_cell);
  } else {
    buffer_format(out, "  %u rocks in %u unique cells, at most %u a cell; a cube has %u x %u x %u cells (n = %u)\n",
                  pack->asset_count, pack->cell_count, pack->max_rocks_per_cell, pack->cells_per_cube, pack->cells_per_cube,
                  pack->cells_per_cube, pack->cells_per_cube + 1);
    buffer_format(out, "  %u lattice steps a cell; %u proxies", pack->lattice_per_cell, pack->proxy_count);
    if (pack->proxy_count > 0) buffer_format(out, " of %u steps a cell", pack->proxy_per_cell);
  }
  buffer_add(out, "\n\nsections\n");
  for (uint32_t i = 0; i < report->section_count; ++i) {
    const scree_pack_section* section = &report->sections[i];
    buffer_format(out, "  %-12s %12llu bytes  %5.1f %%  digest %016llx\n", section->name, (unsigned long long)section->size,
                  100.0 * (double)section->size / (double)pack->file_size, (unsigned long long)section->digest);
  }
  if (cliff)
    text_cliff(report, open, out);
  else if (models)
    text_models(report, open, out);
  text_levels(out, models ? "models" : "rocks", report->lods, pack->lod_count);
  if (pack->proxy_count > 0) {
    text_levels(out, "proxies of whole tiles", report->whole, pack->lod_count);
    text_levels(out, "proxies of the eighths of tiles", report->parts, pack->lod_count);
  }
  buffer_format(out, "\n%-6s                    mean  (least .. greatest)\n", models ? "models" : "rocks");
  text_range(out, "volume", &report->volume, pack->asset_count, "cubic cells");
  text_range(out, "inner radius", &report->inner_radius, pack->asset_count, "cells");
  text_range(out, "outer radius", &report->outer_radius, pack->asset_count, "cells");
  text_range(out, "hull vertices", &report->hull_vertices, pack->asset_count, "");
  if (models) {
    text_recipe(pack, out);
    return;
  }
  text_range(out, "contacts", &report->contacts, pack->asset_count, "");
  buffer_add(out, "\ncontacts of a rock and how many rocks have so many\n ");
  for (uint32_t i = 0; i < INFO_CONTACT_BINS; ++i)
    if (report->rocks_with_contacts[i] > 0)
      buffer_format(out, " %u%s:%u", i, i == INFO_CONTACT_BINS - 1 ? "+" : "", report->rocks_with_contacts[i]);
  buffer_add(out, "\n\nburial: cells around a rock that must be full for nobody to see it, and how many rocks are buried so\n ");
  for (uint32_t b = 1; b < SCREE_BURIAL_NEVER; ++b) buffer_format(out, " %u:%u", b, report->rocks_with_burial[b]);
  buffer_format(out, " never:%u", report->rocks_with_burial[SCREE_BURIAL_NEVER]);
  buffer_add(out, "\n");
  text_recipe(pack, out);
}

static void json_floats(text_buffer* out, const char* name, const float* values, uint32_t count) {
  buffer_format(out, ", \"%s\": [", name);
  for (uint32_t i = 0; i < count; ++i) {
    if (i > 0) buffer_add(out, ", ");
    buffer_float(out, values[i]);
  }
  buffer_add(out, "]");
}

static void json_range(text_buffer* out, const char* name, const info_range* range, uint32_t count) {
  buffer_format(out, ",\n  \"%s\": {\"mean\": ", name);
  buffer_number(out, range->sum / count);
  buffer_add(out, ", \"least\": ");
  buffer_number(out, range->least);
  buffer_add(out, ", \"greatest\": ");
  buffer_number(out, range->greatest);
  buffer_add(out, "}");
}

static void json_part(const scree_pack* pack, uint32_t asset, uint32_t part, text_buffer* out) {
  int16_t hull[256][3];
  uint32_t count;
  if (scree_pack_get_part(pack, asset, part, hull[0], 256, &count) != SCREE_OK) count = 0;
  buffer_add(out, part > 0 ? ", [" : "[");
  for (uint32_t i = 0; i < count; ++i) buffer_format(out, "%s[%d, %d, %d]", i > 0 ? ", " : "", hull[i][0], hull[i][1], hull[i][2]);
  buffer_add(out, "]");
}

/* Its parts whole, where they are asked for, or their number. */
static void json_model(const scree_pack* pack, uint32_t asset, bool whole, text_buffer* out) {
  scree_model model;
  if (scree_pack_get_model(pack, asset, &model) != SCREE_OK) return;
  buffer_format(out, "{\"variant\": %u, \"age\": %u, \"steps\": %u, \"footprint\": ", model.variant, model.age, model.steps);
  buffer_float(out, model.footprint);
  buffer_add(out, ", \"height\": ");
  buffer_float(out, model.height);
  buffer_add(out, ", \"share\": ");
  buffer_float(out, model.share);
  if (whole) {
    buffer_add(out, ", \"parts\": [");
    for (uint32_t part = 0; part < model.part_count; ++part) json_part(pack, asset, part, out);
    buffer_add(out, "]}");
  } else {
    buffer_format(out, ", \"parts\": %u}", model.part_count);
  }
}

static void json_example(const scree_pack* pack, uint32_t lod_count, uint32_t asset, text_buffer* out) {
  scree_asset rock;
  if (scree_pack_get_asset(pack, asset, &rock) != SCREE_OK) return;
  buffer_format(out, "    {\"asset\": %u, \"cell\": %u, \"seed\": %u, \"burial\": %u, \"volume\": ", asset, rock.cell, rock.seed,
                rock.burial);
  buffer_float(out, rock.volume);
  buffer_add(out, ", \"inner_radius\": ");
  buffer_float(out, rock.inner_radius);
  buffer_add(out, ", \"outer_radius\": ");
  buffer_float(out, rock.outer_radius);
  json_floats(out, "centroid", rock.centroid, 3);
  json_floats(out, "bounds_min", rock.bounds_min, 3);
  json_floats(out, "bounds_max", rock.bounds_max, 3);

  buffer_add(out, ",\n     \"contacts\": [");
  scree_contact* contacts = malloc((rock.contact_count + (size_t)1) * sizeof *contacts);
  uint32_t count = 0;
  if (contacts != NULL && scree_pack_get_contacts(pack, asset, contacts, rock.contact_count, &count) != SCREE_OK) count = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const scree_contact* c = &contacts[i];
    buffer_format(out, "%s[%d, %d, %d, %d, %d, %d, %u]", i > 0 ? ", " : "", c->position[0], c->position[1], c->position[2],
                  c->cell[0], c->cell[1], c->cell[2], c->seed);
  }
  free(contacts);

  buffer_add(out, "],\n     \"hull\": [");
  int16_t hull[256][3];
  if (scree_pack_get_hull(pack, asset, hull[0], 256, &count) != SCREE_OK) count = 0;
  for (uint32_t i = 0; i < count; ++i) buffer_format(out, "%s[%d, %d, %d]", i > 0 ? ", " : "", hull[i][0], hull[i][1], hull[i][2]);

  buffer_add(out, "]");
  scree_model model;
  if (scree_pack_get_model(pack, asset, &model) == SCREE_OK) {
    buffer_add(out, ",\n     \"model\": ");
    json_model(pack, asset, true, out);
  }
  buffer_add(out, ",\n     \"lods\": [");
  for (uint32_t lod = 0; lod < lod_count; ++lod) {
    scree_lod level;
    if (scree_pack_get_lod(pack, asset, lod, &level) != SCREE_OK) break;
    buffer_format(
        out, "%s{\"triangles\": %u, \"vertices\": %u, \"bytes\": %llu, \"digest\": \"%016llx\", \"error\": ", lod > 0 ? ", " : "",
        level.triangles, level.vertices, (unsigned long long)level.blob_size, (unsigned long long)level.digest);
    buffer_float(out, level.error);
    buffer_add(out, "}");
  }
  buffer_add(out, "]}");
}

/* The recipe is JSON already; a pack whose recipe is not gives it as a string. */
static void json_recipe(const char* recipe, text_buffer* out) {
  cJSON* tree = cJSON_Parse(recipe);
  char* text = tree != NULL ? cJSON_PrintUnformatted(tree) : NULL;
  if (text != NULL) {
    buffer_add(out, text);
  } else {
    buffer_string(out, recipe);
  }
  cJSON_free(text);
  cJSON_Delete(tree);
}

static void json_levels(text_buffer* out, const info_lod* levels, uint32_t count) {
  for (uint32_t lod = 0; lod < count; ++lod) {
    const info_lod* level = &levels[lod];
    buffer_format(out, "%s\n    {\"triangles\": %llu, \"vertices\": %llu, \"bytes\": %llu, \"error\": ", lod > 0 ? "," : "",
                  (unsigned long long)level->triangles, (unsigned long long)level->vertices, (unsigned long long)level->bytes);
    buffer_float(out, level->error);
    buffer_add(out, ", \"error_95\": ");
    buffer_float(out, level->error_95);
    buffer_add(out, ", \"error_mean\": ");
    buffer_number(out, level->error_sum / level->meshes);
    buffer_add(out, "}");
  }
}

static void json_cliff(const scree_pack* pack, const scree_pack_info* info, text_buffer* out) {
  buffer_format(out, ",\n  \"placements\": %u", info->placement_count);
  json_floats(out, "uv_min", info->uv_min, 2);
  json_floats(out, "uv_max", info->uv_max, 2);
  buffer_add(out, ",\n  \"times\": [");
  for (uint32_t t = 0; t < info->time_count; ++t) {
    scree_cliff_time time;
    if (scree_pack_get_time(pack, t, &time) != SCREE_OK) break;
    buffer_format(out, "%s\n    {\"asset\": %u, \"paths\": %u, \"first_placement\": %u, \"placements\": %u, \"share\": ",
                  t > 0 ? "," : "", time.asset, time.paths, time.first_placement, time.placement_count);
    buffer_float(out, time.share);
    json_floats(out, "bounds_min", time.bounds_min, 3); /* what the pack says: of balls around the blocks */
    json_floats(out, "bounds_max", time.bounds_max, 3);
    buffer_add(out, "}");
  }
  buffer_add(out, "\n  ]");
}

void info_write_json(const info_report* report, const scree_pack* pack, text_buffer* out) {
  const scree_pack_info* info = &report->pack;
  buffer_format(out, "{\n  \"format_version\": %u,\n  \"file_size\": %llu,\n  \"digest\": \"%016llx\",\n", info->format_version,
                (unsigned long long)info->file_size, (unsigned long long)info->digest);
  buffer_format(out, "  \"kind\": \"%s\",\n",
                info->kind == SCREE_PACK_CLIFF    ? "cliff"
                : info->kind == SCREE_PACK_MODELS ? "models"
                                                  : "tiles");
  buffer_format(out, "  \"cells_per_cube\": %u,\n  \"lattice_per_cell\": %u,\n  \"lod_count\": %u,\n", info->cells_per_cube,
                info->lattice_per_cell, info->lod_count);
  buffer_format(out, "  \"proxy_count\": %u,\n  \"proxy_per_cell\": %u,\n", info->proxy_count, info->proxy_per_cell);
  buffer_format(out, "  \"max_rocks_per_cell\": %u,\n  \"max_radius\": ", info->max_rocks_per_cell);
  buffer_float(out, info->max_radius);
  buffer_format(out, ",\n  \"cells\": %u,\n  \"assets\": %u,\n  \"sections\": {", info->cell_count, info->asset_count);
  for (uint32_t i = 0; i < report->section_count; ++i)
    buffer_format(out, "%s\"%s\": %llu", i > 0 ? ", " : "", report->sections[i].name, (unsigned long long)report->sections[i].size);
  buffer_add(out, "},\n  \"section_digests\": {");
  for (uint32_t i = 0; i < report->section_count; ++i)
    buffer_format(out, "%s\"%s\": \"%016llx\"", i > 0 ? ", " : "", report->sections[i].name,
                  (unsigned long long)report->sections[i].digest);
  buffer_add(out, "},\n  \"lods\": [");
  json_levels(out, report->lods, info->lod_count);
  if (info->proxy_count > 0) {
    buffer_add(out, "\n  ],\n  \"proxies\": {\"whole\": [");
    json_levels(out, report->whole, info->lod_count);
    buffer_add(out, "], \"parts\": [");
    json_levels(out, report->parts, info->lod_count);
    buffer_add(out, "]},");
  } else {
    buffer_add(out, "\n  ],");
  }
  buffer_add(out, "\n  \"burial\": [");
  for (uint32_t b = 1; b <= SCREE_BURIAL_NEVER; ++b) buffer_format(out, "%s%u", b > 1 ? ", " : "", report->rocks_with_burial[b]);
  buffer_format(out, "],\n  \"contacts\": %.0f", report->contacts.sum);
  json_range(out, "contacts_per_rock", &report->contacts, info->asset_count);
  json_range(out, "volume", &report->volume, info->asset_count);
  json_range(out, "inner_radius", &report->inner_radius, info->asset_count);
  json_range(out, "outer_radius", &report->outer_radius, info->asset_count);
  json_range(out, "hull_vertices", &report->hull_vertices, info->asset_count);
  if (info->kind == SCREE_PACK_CLIFF) json_cliff(pack, info, out);
  if (info->kind != SCREE_PACK_TILES) {
    buffer_format(out, ",\n  \"variants\": %u,\n  \"models\": [", info->variant_count);
    for (uint32_t i = 0; i < info->asset_count; ++i) {
      buffer_add(out, i > 0 ? ",\n    " : "\n    ");
      json_model(pack, i, false, out);
    }
    buffer_add(out, "\n  ]");
  }
  buffer_add(out, ",\n  \"examples\": [\n");
  const uint32_t last = info->asset_count - 1, examples[3] = {0, info->asset_count / 2, last};
  for (uint32_t i = 0; i < 3; ++i) {
    if (i > 0) buffer_add(out, ",\n");
    json_example(pack, info->lod_count, examples[i], out);
  }
  buffer_add(out, "\n  ],\n  \"recipe\": ");
  json_recipe(info->recipe, out);
  buffer_add(out, "\n}\n");
}
