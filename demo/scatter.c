/* scree-scatter: a scene in, a .glb with all its rocks out. */
#define _POSIX_C_SOURCE 200809L

#include <scree/draco.h>
#include <scree/field.h>
#include <scree/threads.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "arguments.h"
#include "buffer.h"
#include "file.h"
#include "rock_export.h"
#include "scene_support.h"
#include "timer.h"

static const char usage[] =
    "usage: scree-scatter SCENE.json -o OUT.glb [options]\n"
    "\n"
    "Fills the supports of a scene with rock and writes the rocks as glTF.\n"
    "\n"
    "  -o, --output FILE    the .glb to write; it appears only when it is whole\n"
    "      --format FORMAT  instanced (EXT_mesh_gpu_instancing and Draco, small; the default) or\n"
    "                       flat (plain glTF, for tools that know neither)\n"
    "      --lod N          level of detail of every rock, 0 = finest (default 0); the coarsest if there are fewer\n"
    "      --packs DIR      where NAME.scree of a field's pack is (default " SCENE_DEFAULT_PACKS
    ")\n"
    "      --data DIR       where meshes and pictures are that are not beside the scene (default " SCENE_DEFAULT_DATA
    ")\n"
    "      --report FILE    write counts, sizes and times as JSON\n"
    "      --threads N      1..64 (default: one per processor)\n"
    "      --help, --version\n"
    "\n"
    "Exit status: 0 done, 1 the machine failed (memory, disk), 2 a mistake in the arguments or the scene.\n";

typedef struct options {
  const char *scene, *output, *format, *packs, *data, *report;
  uint32_t lod, threads;
} options;

/* What the report says of one field. */
typedef struct field_report {
  rock_export_stats stats;
  double seconds;
} field_report;

typedef struct progress {
  bool is_shown;
  const char* what;
  uint32_t field, fields;
  int last; /* percent */
} progress;

static void show_progress(void* user, double done) {
  progress* p = user;
  int percent = (int)(100.0 * (p->field + done) / p->fields);
  if (!p->is_shown || percent == p->last) return;
  static const char bar[] = "########################################";
  int filled = percent * 40 / 100;
  p->last = percent;
  fprintf(stderr, "\r[%.*s%*s] %3d %%", filled, bar, 40 - filled, "", percent);
  fflush(stderr);
}

static void end_progress(const progress* p) {
  if (p->is_shown && p->last >= 0) fprintf(stderr, "\r%*s\r", 48, "");
}

/* Packs that are open; fields that name the same one share it. */
typedef struct open_packs {
  struct {
    char path[SCENE_FILE_SIZE * 2];
    scree_pack* pack;
  } items[SCENE_FIELDS_MAX];
  uint32_t count;
} open_packs;

static scree_result find_pack(open_packs* packs, const scene_paths* paths, const char* where, const char* name, scree_pack** out,
                              scree_error* error) {
  char path[SCENE_FILE_SIZE * 2];
  scree_result result = scene_find_pack(paths, where, name, path, sizeof path, error);
  if (result != SCREE_OK) return result;
  for (uint32_t i = 0; i < packs->count; ++i) {
    if (strcmp(packs->items[i].path, path) == 0) {
      *out = packs->items[i].pack;
      return SCREE_OK;
    }
  }
  result = scree_pack_open_file(path, NULL, out);
  if (result != SCREE_OK) return fail_with(error, result, "%s: %s", path, scree_result_string(result));
  memcpy(packs->items[packs->count].path, path, sizeof path);
  packs->items[packs->count++].pack = *out;
  return SCREE_OK;
}

/* Asks which rocks there are, and for the hash of each. */
static scree_result query_rocks(const scree_query_desc* query, rock_layer* layer, const char* where, scree_error* error) {
  uint64_t count = 0;
  scree_result result = scree_query_count(query, &count);
  if (result != SCREE_OK) return fail_with(error, result, "%s: %s", where, scree_result_string(result));
  if (count > INT32_MAX)
    return fail_with(error, SCREE_ERROR_RANGE, "%s: %llu rocks are too many", where, (unsigned long long)count);
  size_t room = count > 0 ? (size_t)count : 1;
  scree_instance* instances = malloc(room * sizeof *instances);
  scree_id* ids = malloc(room * sizeof *ids);
  uint32_t* hashes = malloc(room * sizeof *hashes);
  layer->instances = instances;
  layer->hashes = hashes;
  layer->count = count;
  if (instances == NULL || ids == NULL || hashes == NULL) {
    result = fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory for %llu rocks", where, (unsigned long long)count);
  } else {
    result = scree_query_fill(query, instances, ids, count, &count);
    if (result != SCREE_OK) fail_with(error, result, "%s: %s", where, scree_result_string(result));
  }
  for (uint64_t i = 0; i < count && result == SCREE_OK; ++i) hashes[i] = scree_world_hash(query->field, &ids[i]);
  free(ids);
  return result;
}

typedef struct scatter {
  const options* options;
  scene_model scene;
  scene_paths paths;
  scene_files* files;
  open_packs packs;
  scree_jobs jobs;
  rock_export* export;
  progress progress;
  field_report* reports;
  scree_error error;
} scatter;

static scree_result add_field(scatter* s, uint32_t index) {
  const scene_field* field = &s->scene.fields[index];
  char where[SCENE_FILE_SIZE + 64], key[32];
  snprintf(key, sizeof key, "fields[%u].pack", index);
  snprintf(where, sizeof where, "%.*s: fields[%u]", SCENE_FILE_SIZE, s->options->scene, index);
  double start = timer_seconds();
  scree_pack* pack;
  scree_result result = find_pack(&s->packs, &s->paths, key, field->pack, &pack, &s->error);
  if (result != SCREE_OK) return result;
  scree_support* support = NULL;
  result = scene_support_create(&s->scene, index, &s->paths, s->files, &s->jobs, &support, &s->error);
  if (result != SCREE_OK) return result;
  scree_field* rocks = NULL;
  scree_field_desc desc = {.pack = pack, .seed = field->seed, .cell_size = field->cell_size};
  memcpy(desc.origin, field->origin, sizeof desc.origin);
  result = scree_field_create(&desc, NULL, &rocks);
  if (result != SCREE_OK) fail_with(&s->error, result, "%s: %s", where, scree_result_string(result));
  rock_layer layer = {.name = field->name[0] != '\0' ? field->name : field->pack,
                      .pack = pack,
                      .cell_size = field->cell_size,
                      .palette = &field->palette};
  /* Places are told from the support's own, so that they are exact wherever in the world it lies. */
  memcpy(layer.origin, field->support->position, sizeof layer.origin);
  if (result == SCREE_OK) {
    scree_query_desc query = {
        .field = rocks, .support = support, .threshold = (float)field->threshold, .flags = field->shell ? SCREE_QUERY_SHELL : 0};
    memcpy(query.origin, layer.origin, sizeof query.origin);
    result = query_rocks(&query, &layer, where, &s->error);
  }
  if (result == SCREE_OK) {
    s->progress.field = index;
    result = rock_export_add(s->export, &layer, &s->reports[index].stats, &s->error);
  }
  s->reports[index].seconds = timer_seconds() - start;
  free((void*)layer.instances);
  free((void*)layer.hashes);
  scree_field_destroy(rocks);
  scree_support_destroy(support);
  return result;
}

static char* write_report(const scatter* s, const rock_export_stats* stats, double seconds) {
  text_buffer t = {0};
  buffer_add(&t, "{\n  \"scene\": ");
  buffer_string(&t, s->options->scene);
  buffer_add(&t, ",\n  \"format\": ");
  buffer_string(&t, s->options->format);
  buffer_format(&t,
                ",\n  \"lod\": %u,\n  \"instances\": %llu,\n  \"unique_meshes\": %llu,\n  \"triangles\": %llu,\n  \"bytes\": %llu",
                s->options->lod, (unsigned long long)stats->instances, (unsigned long long)stats->shapes,
                (unsigned long long)stats->triangles, (unsigned long long)stats->bytes);
  buffer_format(&t, ",\n  \"seconds\": %.3f,\n  \"fields\": [", seconds);
  for (uint32_t i = 0; i < s->scene.field_count; ++i) {
    const scene_field* field = &s->scene.fields[i];
    const field_report* r = &s->reports[i];
    buffer_add(&t, i > 0 ? ",\n    {\"name\": " : "\n    {\"name\": ");
    buffer_string(&t, field->name);
    buffer_add(&t, ", \"pack\": ");
    buffer_string(&t, field->pack);
    buffer_format(&t, ", \"instances\": %llu, \"unique_meshes\": %llu, \"triangles\": %llu, \"seconds\": %.3f}",
                  (unsigned long long)r->stats.instances, (unsigned long long)r->stats.shapes,
                  (unsigned long long)r->stats.triangles, r->seconds);
  }
  buffer_add(&t, "\n  ]\n}\n");
  return buffer_take(&t, NULL);
}

static scree_result save_report(const scatter* s, const rock_export_stats* stats, double seconds, scree_error* error) {
  char* text = write_report(s, stats, seconds);
  if (text == NULL) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", s->options->report);
  file_replacement file;
  scree_result result = file_replace_begin(s->options->report, &file, error);
  if (result == SCREE_OK) {
    fputs(text, file.stream);
    result = file_replace_commit(&file, error);
  }
  free(text);
  return result;
}

/* Returns the exit status. */
static int finish(const scatter* s, scree_result result, bool is_writing) {
  end_progress(&s->progress);
  if (result == SCREE_OK) return 0;
  fprintf(stderr, "scree-scatter: %s\n", s->error.message);
  return result == SCREE_ERROR_OUT_OF_MEMORY || is_writing ? 1 : 2;
}

static int run(scatter* s) {
  const options* o = s->options;
  double start = timer_seconds();
  scree_result result = scene_load(o->scene, &s->scene, &s->error);
  if (result != SCREE_OK) return finish(s, result, false);
  if (o->report != NULL) result = file_replace_check(o->report, &s->error);
  if (result != SCREE_OK) return finish(s, result, false);
  s->progress = (progress){.is_shown = isatty(STDERR_FILENO) != 0, .fields = s->scene.field_count, .last = -1};
  s->reports = calloc(s->scene.field_count + 1, sizeof *s->reports);
  s->files = scene_files_create();
  if (s->reports == NULL || s->files == NULL)
    return finish(s, fail_with(&s->error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", o->scene), false);
  rock_export_desc desc = {.path = o->output,
                           .format = strcmp(o->format, "flat") == 0 ? ROCK_FORMAT_FLAT : ROCK_FORMAT_INSTANCED,
                           .lod = o->lod,
                           .jobs = s->jobs,
                           .progress = show_progress,
                           .user = &s->progress};
  result = rock_export_begin(&desc, &s->export, &s->error);
  for (uint32_t i = 0; i < s->scene.field_count && result == SCREE_OK; ++i) result = add_field(s, i);
  if (result != SCREE_OK) return finish(s, result, false);
  rock_export_stats stats;
  result = rock_export_finish(s->export, &stats, &s->error);
  s->export = NULL;
  double seconds = timer_seconds() - start;
  if (result == SCREE_OK && o->report != NULL) result = save_report(s, &stats, seconds, &s->error);
  if (result == SCREE_OK && s->progress.is_shown) {
    end_progress(&s->progress);
    s->progress.is_shown = false;
    fprintf(stderr, "%s: %llu rocks of %llu shapes, %.1f MB, %.2f s\n", o->output, (unsigned long long)stats.instances,
            (unsigned long long)stats.shapes, 1e-6 * (double)stats.bytes, seconds);
  }
  return finish(s, result, true);
}

static int bad_usage(const scree_error* error) {
  fprintf(stderr, "scree-scatter: %s\n", error->message);
  return 2;
}

int main(int argc, char** argv) {
  options o = {.format = "instanced"};
  const char* lod = "0";
  const char* threads = NULL;
  bool help = false, version = false;
  const argument known[] = {
      {"--output", "-o", &o.output, NULL}, {"--format", NULL, &o.format, NULL}, {"--lod", NULL, &lod, NULL},
      {"--packs", NULL, &o.packs, NULL},   {"--data", NULL, &o.data, NULL},     {"--report", NULL, &o.report, NULL},
      {"--threads", NULL, &threads, NULL}, {"--help", "-h", NULL, &help},       {"--version", NULL, NULL, &version},
  };
  size_t scenes;
  scree_error error;
  if (!arguments_read(argc, argv, known, sizeof known / sizeof known[0], &o.scene, 1, &scenes, &error)) return bad_usage(&error);
  if (help) return fputs(usage, stdout) < 0;
  if (version) return printf("scree-scatter %s\n", scree_version_string()) < 0;
  if (!arguments_number("--lod", lod, 0, 15, &o.lod, &error)) return bad_usage(&error);
  if (threads != NULL && !arguments_number("--threads", threads, 1, 64, &o.threads, &error)) return bad_usage(&error);
  const char* missing = scenes == 0 ? "a scene is missing" : o.output == NULL ? "-o OUT.glb is missing" : NULL;
  if (strcmp(o.format, "instanced") != 0 && strcmp(o.format, "flat") != 0) missing = "--format: expected instanced or flat";
  if (missing != NULL) {
    fail_with(&error, SCREE_ERROR_INVALID_ARGUMENT, "%s (--help says what there is)", missing);
    return bad_usage(&error);
  }
  scatter* s = calloc(1, sizeof *s);
  if (s == NULL) return 1;
  s->options = &o;
  s->paths = (scene_paths){o.scene, o.packs, o.data};
  scree_threads* pool;
  scree_result result = scree_threads_create((o.threads > 0 ? o.threads : scree_threads_processors()) - 1, NULL, &pool);
  if (result != SCREE_OK) fail_with(&s->error, result, "--threads: %s", scree_result_string(result));
  s->jobs = scree_threads_jobs(pool);
  int status = result == SCREE_OK ? run(s) : finish(s, result, false);
  scree_threads_destroy(pool);
  rock_export_abort(s->export);
  for (uint32_t i = 0; i < s->packs.count; ++i) scree_pack_close(s->packs.items[i].pack);
  scene_files_destroy(s->files);
  scene_destroy(&s->scene);
  free(s->reports);
  free(s);
  return status;
}
