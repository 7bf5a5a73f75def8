/* scree-scatter: a scene in, a .glb with all its rocks out. */
#define _POSIX_C_SOURCE 200809L

#include <scree/draco.h>
#include <scree/threads.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "arguments.h"
#include "buffer.h"
#include "file.h"
#include "rock_export.h"
#include "scene_live.h"
#include "timer.h"

static const char usage[] =
    "usage: scree-scatter SCENE.json -o OUT.glb [options]\n"
    "\n"
    "Fills the supports of a scene with rock and writes the rocks as glTF.\n"
    "\n"
    "  -o, --output FILE    the .glb to write; it appears only when it is whole\n"
    "      --format FORMAT  instanced (EXT_mesh_gpu_instancing and Draco, small; the default) or\n"
    "                       flat (plain glTF, for tools that know neither)\n"
    "      --rocks WHICH    visible (the default): without those that nobody can see behind their neighbours, for pictures; or\n"
    "                       all: every rock of the scene, for physics and counts\n"
    "      --lod N          level of detail of every rock, 0 = finest (default 0)\n"
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
  const char *scene, *output, *format, *packs, *data, *report, *rocks;
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

/* More are a mistake of scale: the file would be of a gigabyte and its readers would choke. */
#define ROCKS_MOST 20000000u

typedef struct scatter {
  const options* options;
  scene_model scene;
  scene_paths paths;
  scene_live* world;
  scene_rocks rocks;
  scree_jobs jobs;
  rock_export* export;
  progress progress;
  field_report* reports;
  scree_error error;
} scatter;

/* What a layer points at. */
typedef struct layer_arrays {
  scree_instance* instances;
  uint32_t* hashes;
  rock_turn* turns; /* of scatters */
} layer_arrays;

/* The rocks of a field as the exporter takes them. */
static scree_result fill_layer(const scatter* s, uint32_t index, rock_layer* layer, layer_arrays* arrays) {
  const size_t room = s->rocks.count > 0 ? (size_t)s->rocks.count : 1;
  const scree_scene* scene = scene_live_scene(s->world);
  const scree_scatter* models = scene_live_scatter(s->world, index);
  arrays->instances = malloc(room * sizeof *arrays->instances);
  arrays->hashes = malloc(room * sizeof *arrays->hashes);
  arrays->turns = models != NULL ? malloc(room * sizeof *arrays->turns) : NULL;
  if (arrays->instances == NULL || arrays->hashes == NULL || (models != NULL && arrays->turns == NULL))
    return SCREE_ERROR_OUT_OF_MEMORY;
  for (uint64_t i = 0; i < s->rocks.count; ++i) {
    const scree_rock* rock = &s->rocks.rocks[i];
    arrays->instances[i].asset = rock->asset;
    memcpy(arrays->instances[i].position, rock->position, sizeof rock->position);
    arrays->hashes[i] = scree_scene_random(scene, &rock->id);
    if (models == NULL) continue;
    float turn[2], scale;
    scree_scatter_turn(models, arrays->hashes[i], turn, &scale);
    arrays->turns[i] = (rock_turn){turn[0], turn[1], scale};
    arrays->hashes[i] = scene_model_hash(arrays->hashes[i]);
  }
  layer->instances = arrays->instances;
  layer->hashes = arrays->hashes;
  layer->turns = arrays->turns;
  layer->count = s->rocks.count;
  return SCREE_OK;
}

static scree_result add_field(scatter* s, uint32_t index) {
  const scene_field* field = &s->scene.fields[index];
  double start = timer_seconds();
  rock_layer layer = {.name = field->name[0] != '\0'   ? field->name
                              : field->pack[0] != '\0' ? field->pack
                                                       : field->scatter.models[0],
                      .pack = scene_live_pack(s->world, index),
                      .models = scene_live_models(s->world, index),
                      .cell_size = field->is_scatter || field->is_cliff ? 1 : field->cell_size,
                      .palette = &field->palette};
  scree_pack_info info = {.lod_count = UINT32_MAX}; /* models from files have one level, which stands for all */
  if (layer.pack != NULL) scree_pack_get_info(layer.pack, &info);
  if (s->options->lod >= info.lod_count)
    return fail_with(&s->error, SCREE_ERROR_RANGE, "%s: fields[%u]: --lod %u: the pack \"%s\" has the levels 0..%u",
                     s->options->scene, (unsigned)index, s->options->lod, field->pack, info.lod_count - 1);
  /* Places are told from the support's own, so that they are exact wherever in the world it lies. */
  memcpy(layer.origin, field->is_cliff ? field->origin : field->support->position, sizeof layer.origin);
  const uint32_t flags = strcmp(s->options->rocks, "all") == 0 ? 0 : SCREE_SCENE_VISIBLE;
  scree_result result = scene_live_query(s->world, index, layer.origin, flags, ROCKS_MOST, &s->rocks, &s->error);
  if (result != SCREE_OK) return result;
  layer_arrays arrays = {.instances = NULL};
  result = fill_layer(s, index, &layer, &arrays);
  if (result != SCREE_OK) {
    fail_with(&s->error, result, "%s: fields[%u]: out of memory", s->options->scene, (unsigned)index);
  } else {
    s->progress.field = index;
    result = rock_export_add(s->export, &layer, &s->reports[index].stats, &s->error);
  }
  s->reports[index].seconds = timer_seconds() - start;
  free(arrays.instances);
  free(arrays.hashes);
  free(arrays.turns);
  return result;
}

static char* write_report(const scatter* s, const rock_export_stats* stats, double seconds) {
  text_buffer t = {0};
  buffer_add(&t, "{\n  \"scene\": ");
  buffer_string(&t, s->options->scene);
  buffer_add(&t, ",\n  \"format\": ");
  buffer_string(&t, s->options->format);
  buffer_add(&t, ",\n  \"rocks\": ");
  buffer_string(&t, s->options->rocks);
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
  if (s->reports == NULL) return finish(s, fail_with(&s->error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", o->scene), false);
  rock_export_desc desc = {.path = o->output,
                           .format = strcmp(o->format, "flat") == 0 ? ROCK_FORMAT_FLAT : ROCK_FORMAT_INSTANCED,
                           .lod = o->lod,
                           .jobs = s->jobs,
                           .progress = show_progress,
                           .user = &s->progress};
  const scene_live_desc wanted = {.scene = &s->scene, .paths = s->paths, .jobs = s->jobs};
  result = rock_export_begin(&desc, &s->export, &s->error);
  if (result == SCREE_OK) result = scene_live_create(&wanted, &s->world, &s->error);
  if (result == SCREE_OK) result = scene_live_update_all(s->world, &s->error);
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
  options o = {.format = "instanced", .rocks = "visible"};
  const char* lod = "0";
  const char* threads = NULL;
  bool help = false, version = false;
  const argument known[] = {
      {"--output", "-o", &o.output, NULL}, {"--format", NULL, &o.format, NULL}, {"--lod", NULL, &lod, NULL},
      {"--packs", NULL, &o.packs, NULL},   {"--data", NULL, &o.data, NULL},     {"--report", NULL, &o.report, NULL},
      {"--threads", NULL, &threads, NULL}, {"--rocks", NULL, &o.rocks, NULL},   {"--help", "-h", NULL, &help},
      {"--version", NULL, NULL, &version},
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
  if (strcmp(o.rocks, "visible") != 0 && strcmp(o.rocks, "all") != 0) missing = "--rocks: expected visible or all";
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
  scene_live_destroy(s->world);
  scene_rocks_free(&s->rocks);
  scene_destroy(&s->scene);
  free(s->reports);
  free(s);
  return status;
}
