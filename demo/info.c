/* scree-info: what is inside a pack, whether its bytes are the ones that were baked, and its rocks as glTF. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <scree/draco.h>
#include <scree/threads.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "arguments.h"
#include "file.h"
#include "info_report.h"
#include "rock_export.h"

static const char usage[] =
    "usage: scree-info PACK.scree [options]\n"
    "\n"
    "Prints what is inside a pack and checks all of its digests, those of the meshes by decoding them.\n"
    "\n"
    "      --json           print one JSON object instead of text\n"
    "      --glb FILE       also lay rocks out side by side in a .glb for any glTF tool, one cell = one metre\n"
    "      --assets A-B     which rocks, numbered from 0 (default 0-63, or as many as there are)\n"
    "      --lod N          their level of detail, 0 = finest (default 0)\n"
    "      --threads N      1..64 (default: one per processor)\n"
    "      --help, --version\n"
    "\n"
    "Exit status: 0 all is well, 1 the machine failed (memory, disk), 2 a mistake in the arguments or the pack.\n";

enum { THREADS_MAX = 64, ASSETS_AT_ONCE = 512 };

typedef struct options {
  const char *pack, *glb;
  uint32_t first, last, lod, threads;
  bool has_assets, json;
} options;

static void show_progress(bool is_shown, double done) {
  static const char bar[] = "########################################";
  const int filled = (int)(40 * done);
  if (is_shown) fprintf(stderr, "\r[%.*s%*s] %3d %%", filled, bar, 40 - filled, "", (int)(100 * done));
}

static void end_progress(bool is_shown) {
  if (is_shown) fprintf(stderr, "\r%*s\r", 48, "");
}

/* --- checking meshes -------------------------------------------------------------------------------------------------------- */

typedef struct mesh_buffer {
  scree_vertex* vertices;
  scree_uv* uvs; /* of cliffs, as the next: vertex_capacity */
  uint8_t* groups;
  uint32_t* indices;
  size_t vertex_capacity, index_capacity;
} mesh_buffer;

typedef struct mesh_fault {
  scree_result result; /* SCREE_OK = none */
  uint32_t asset, lod;
} mesh_fault;

typedef struct mesh_check {
  const scree_pack* pack;
  uint32_t first_asset, lod_count;
  scree_pack_kind kind;
  mesh_buffer buffers[THREADS_MAX];
  mesh_fault faults[ASSETS_AT_ONCE]; /* by asset, so that the first one is told whatever the order */
} mesh_check;

static bool make_room(mesh_buffer* buffer, size_t vertices, size_t indices) {
  if (buffer->vertex_capacity < vertices) {
    free(buffer->vertices);
    free(buffer->uvs);
    free(buffer->groups);
    buffer->vertices = malloc(vertices * sizeof *buffer->vertices);
    buffer->uvs = malloc(vertices * sizeof *buffer->uvs);
    buffer->groups = malloc(vertices);
    const bool complete = buffer->vertices != NULL && buffer->uvs != NULL && buffer->groups != NULL;
    buffer->vertex_capacity = complete ? vertices : 0;
  }
  if (buffer->index_capacity < indices) {
    free(buffer->indices);
    buffer->indices = malloc(indices * sizeof *buffer->indices);
    buffer->index_capacity = buffer->indices != NULL ? indices : 0;
  }
  return buffer->vertex_capacity >= vertices && buffer->index_capacity >= indices;
}

static scree_result check_mesh(const scree_pack* pack, scree_pack_kind kind, uint32_t asset, uint32_t lod, mesh_buffer* buffer) {
  scree_lod level;
  scree_result result = scree_pack_get_lod(pack, asset, lod, &level);
  if (result != SCREE_OK) return result;
  const size_t index_count = 3 * (size_t)level.triangles;
  if (!make_room(buffer, level.vertices, index_count)) return SCREE_ERROR_OUT_OF_MEMORY;
  result =
      scree_draco_decode_u32(pack, asset, lod, buffer->vertices, buffer->vertex_capacity, buffer->indices, buffer->index_capacity);
  if (result == SCREE_OK && kind == SCREE_PACK_CLIFF)
    result = scree_draco_decode_uvs(pack, asset, lod, buffer->uvs, buffer->groups, buffer->vertex_capacity);
  if (result != SCREE_OK) return result;
  const uint64_t digest = kind == SCREE_PACK_CLIFF ? scree_cliff_mesh_digest(buffer->vertices, buffer->uvs, buffer->groups,
                                                                             level.vertices, buffer->indices, level.triangles)
                                                   : (kind == SCREE_PACK_MODELS ? scree_model_mesh_digest : scree_mesh_digest)(
                                                         buffer->vertices, level.vertices, buffer->indices, level.triangles);
  return digest == level.digest ? SCREE_OK : SCREE_ERROR_DIGEST;
}

static void check_asset(void* context, uint32_t index, uint32_t worker) {
  mesh_check* check = context;
  mesh_fault* fault = &check->faults[index];
  *fault = (mesh_fault){SCREE_OK, check->first_asset + index, 0};
  for (; fault->lod < check->lod_count; ++fault->lod) {
    fault->result = check_mesh(check->pack, check->kind, fault->asset, fault->lod, &check->buffers[worker]);
    if (fault->result != SCREE_OK) return;
  }
}

/* Decodes every mesh. On failure `error` names the first that is wrong. */
static scree_result check_meshes(const scree_pack* pack, const scree_pack_info* info, const scree_jobs* jobs, const char* path,
                                 scree_error* error) {
  mesh_check* check = calloc(1, sizeof *check);
  if (check == NULL) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", path);
  check->pack = pack;
  check->lod_count = info->lod_count;
  check->kind = info->kind;
  const bool is_shown = isatty(STDERR_FILENO) != 0;
  scree_result result = SCREE_OK;
  const uint32_t total = info->asset_count + info->proxy_count;
  while (check->first_asset < total && result == SCREE_OK) {
    const uint32_t left = total - check->first_asset, count = left < ASSETS_AT_ONCE ? left : ASSETS_AT_ONCE;
    jobs->parallel_for(jobs->user, count, check_asset, check);
    for (uint32_t i = 0; i < count && result == SCREE_OK; ++i) {
      const mesh_fault* fault = &check->faults[i];
      if (fault->result == SCREE_OK) continue;
      result = fail_with(error, fault->result, "%s: mesh of asset %u, level %u: %s", path, fault->asset, fault->lod,
                         scree_result_string(fault->result));
    }
    check->first_asset += count;
    show_progress(is_shown, (double)check->first_asset / total);
  }
  end_progress(is_shown);
  for (uint32_t i = 0; i < THREADS_MAX; ++i) {
    free(check->buffers[i].vertices);
    free(check->buffers[i].uvs);
    free(check->buffers[i].groups);
    free(check->buffers[i].indices);
  }
  free(check);
  return result;
}

/* --- glTF ------------------------------------------------------------------------------------------------------------------- */

/* Rows along +X that follow one another along +Z. */
static scree_result write_glb(const options* o, const scree_pack* pack, const scree_pack_info* info, const scree_jobs* jobs,
                              scree_error* error) {
  const uint32_t count = o->last - o->first + 1, side = (uint32_t)ceil(sqrt(count));
  scree_instance* instances = calloc(count, sizeof *instances);
  uint32_t* hashes = calloc(count, sizeof *hashes);
  if (instances == NULL || hashes == NULL) {
    free(instances);
    free(hashes);
    return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", o->glb);
  }
  const float spacing = 2.2f * info->max_radius;
  for (uint32_t i = 0; i < count; ++i) {
    instances[i].asset = o->first + i;
    instances[i].position[0] = spacing * (float)(i % side);
    instances[i].position[2] = spacing * (float)(i / side);
  }
  const scene_palette palette = {.colours = {{0.55f, 0.53f, 0.5f}}, .colour_count = 1};
  const rock_layer layer = {
      .name = "rocks", .pack = pack, .cell_size = 1, .palette = &palette, .instances = instances, .hashes = hashes, .count = count};
  const rock_export_desc desc = {.path = o->glb, .format = ROCK_FORMAT_FLAT, .lod = o->lod, .jobs = *jobs};
  rock_export* file = NULL;
  scree_result result = rock_export_begin(&desc, &file, error);
  if (result == SCREE_OK) result = rock_export_add(file, &layer, NULL, error);
  if (result == SCREE_OK) {
    result = rock_export_finish(file, NULL, error);
  } else {
    rock_export_abort(file);
  }
  free(instances);
  free(hashes);
  return result;
}

/* --- the program ------------------------------------------------------------------------------------------------------------ */

static int bad_input(const scree_error* error) {
  fprintf(stderr, "scree-info: %s\n", error->message);
  return 2;
}

static int fault(scree_result result, const scree_error* error) {
  bad_input(error);
  return result == SCREE_ERROR_OUT_OF_MEMORY ? 1 : 2;
}

static scree_result print_report(const options* o, const scree_pack* pack, const info_report* report, scree_error* error) {
  text_buffer text = {0};
  if (o->json) {
    info_write_json(report, pack, &text);
  } else {
    info_write_text(report, pack, o->pack, &text);
    buffer_format(&text, "\nall digests are right: %u sections, the pack, %u meshes\n", report->section_count,
                  (report->pack.asset_count + report->pack.proxy_count) * report->pack.lod_count);
  }
  char* bytes = buffer_take(&text, NULL);
  if (bytes == NULL) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", o->pack);
  const bool printed = fputs(bytes, stdout) >= 0 && fflush(stdout) == 0;
  free(bytes);
  return printed ? SCREE_OK : fail_with(error, SCREE_ERROR_IO, "standard output cannot be written");
}

static int run(options* o, const scree_pack* pack, const scree_jobs* jobs) {
  scree_error error;
  scree_result result = scree_pack_verify(pack);
  if (result != SCREE_OK) {
    fail_with(&error, result, "%s: %s", o->pack, scree_result_string(result));
    return fault(result, &error);
  }
  info_report* report = malloc(sizeof *report);
  if (report == NULL) return fault(fail_with(&error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", o->pack), &error);
  uint32_t asset;
  result = info_gather(pack, report, &asset);
  if (result != SCREE_OK) fail_with(&error, result, "%s: asset %u: %s", o->pack, asset, scree_result_string(result));
  if (result == SCREE_OK) result = check_meshes(pack, &report->pack, jobs, o->pack, &error);
  int status = result == SCREE_OK ? 0 : fault(result, &error);
  const scree_pack_info* info = &report->pack;
  if (status == 0 && o->glb != NULL) {
    if (!o->has_assets) o->last = info->asset_count < 64 ? info->asset_count - 1 : 63;
    if (o->last >= info->asset_count) {
      fail_with(&error, SCREE_ERROR_RANGE, "--assets: %s has assets 0-%u", o->pack, info->asset_count - 1);
      status = bad_input(&error);
    } else if (o->lod >= info->lod_count) {
      fail_with(&error, SCREE_ERROR_RANGE, "--lod: %s has levels 0-%u", o->pack, info->lod_count - 1);
      status = bad_input(&error);
    } else if (write_glb(o, pack, info, jobs, &error) != SCREE_OK) {
      bad_input(&error);
      status = 1;
    }
  }
  if (status == 0 && print_report(o, pack, report, &error) != SCREE_OK) {
    bad_input(&error);
    status = 1;
  }
  free(report);
  return status;
}

static bool read_assets(const char* text, options* o, scree_error* error) {
  char first[16];
  const char* dash = strchr(text, '-');
  const size_t length = dash != NULL ? (size_t)(dash - text) : strlen(text);
  if (length < sizeof first) {
    memcpy(first, text, length);
    first[length] = '\0';
    if (!arguments_number("--assets", first, 0, UINT32_MAX - 1, &o->first, error)) return false;
    if (!arguments_number("--assets", dash != NULL ? dash + 1 : first, 0, UINT32_MAX - 1, &o->last, error)) return false;
    o->has_assets = true;
    if (o->first <= o->last) return true;
  }
  fail_with(error, SCREE_ERROR_RANGE, "--assets: expected A-B with A <= B, got '%s'", text);
  return false;
}

int main(int argc, char** argv) {
  options o = {0};
  const char *assets = NULL, *lod = NULL, *threads = NULL;
  bool help = false, version = false;
  const argument known[] = {
      {"--json", NULL, NULL, &o.json},     {"--glb", NULL, &o.glb, NULL},       {"--assets", NULL, &assets, NULL},
      {"--lod", NULL, &lod, NULL},         {"--threads", NULL, &threads, NULL}, {"--help", "-h", NULL, &help},
      {"--version", NULL, NULL, &version},
  };
  size_t packs;
  scree_error error;
  if (!arguments_read(argc, argv, known, sizeof known / sizeof known[0], &o.pack, 1, &packs, &error)) return bad_input(&error);
  if (help) return fputs(usage, stdout) < 0;
  if (version) return printf("scree-info %s\n", scree_version_string()) < 0;
  if (lod != NULL && !arguments_number("--lod", lod, 0, 15, &o.lod, &error)) return bad_input(&error);
  if (threads != NULL && !arguments_number("--threads", threads, 1, THREADS_MAX, &o.threads, &error)) return bad_input(&error);
  if (assets != NULL && !read_assets(assets, &o, &error)) return bad_input(&error);
  const char* wrong = packs == 0 ? "a pack is missing" : NULL;
  if (o.glb == NULL && (assets != NULL || lod != NULL)) wrong = "--assets and --lod say what --glb writes, and there is no --glb";
  if (wrong != NULL) {
    fail_with(&error, SCREE_ERROR_INVALID_ARGUMENT, "%s (--help says what there is)", wrong);
    return bad_input(&error);
  }
  if (o.glb != NULL && file_replace_check(o.glb, &error) != SCREE_OK) return bad_input(&error);
  scree_pack* pack;
  scree_result result = scree_pack_open_file(o.pack, NULL, &pack);
  if (result != SCREE_OK) {
    fail_with(&error, result, "%s: %s", o.pack, scree_result_string(result));
    return fault(result, &error);
  }
  scree_threads* pool;
  result = scree_threads_create((o.threads > 0 ? o.threads : scree_threads_processors()) - 1, NULL, &pool);
  if (result != SCREE_OK) fail_with(&error, result, "--threads: %s", scree_result_string(result));
  const scree_jobs jobs = scree_threads_jobs(pool);
  const int status = result == SCREE_OK ? run(&o, pack, &jobs) : fault(result, &error);
  scree_threads_destroy(pool);
  scree_pack_close(pack);
  return status;
}
