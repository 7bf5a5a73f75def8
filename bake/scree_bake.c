/* scree-bake: a recipe file in, a pack file out. A thin program over scree/bake.h, scree/hoodoo.h and
 * scree/shard_recipe.h. */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <scree/shard_recipe.h>
#include <scree/threads.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "file.h"
#include "start_files.h"

static const char usage[] =
    "Usage: scree-bake RECIPE.json -o PACK.scree [options]\n"
    "\n"
    "Bakes all unique rocks of a recipe into a pack: meshes at several levels of detail, hulls, contacts,\n"
    "and merged meshes of tiles for far fields (--set proxies=false leaves these out). A recipe with\n"
    "\"kind\": \"hoodoo\" is weathered instead: its variants, each in several ages. One with \"kind\": \"shards\"\n"
    "is split and broken by frost: what stands at several times, and the blocks that fell with their places.\n"
    "\n"
    "  -o, --output FILE    the pack to write (a temporary file beside it is renamed when all is well)\n"
    "      --set KEY=VALUE  override a key of the recipe, VALUE as in JSON: --set n=5 --set g=[1,2]; may be repeated;\n"
    "                       of hoodoos also --set start.radius=40, of shards --set seeds.count=500; an object as a\n"
    "                       whole, where keys go together: --set 'input={\"shape\": \"mesh\", \"file\": \"a.obj\"}'\n"
    "      --threads N      worker threads, 1..64; default: one a processor. The pack does not depend on it\n"
    "      --report FILE    write rocks, models or assets, triangles, bytes, digest and seconds by stage as JSON; - is standard\n"
    "                       output\n"
    "      --print-recipe   print the recipe with every key and its value, and stop\n"
    "  -q, --quiet          no progress, no summary, as where there is no terminal; warnings are said\n"
    "      --help, --version\n"
    "\n"
    "The keys of a recipe are described in content/schema: recipe.schema.json, hoodoo.schema.json, shards.schema.json.\n"
    "Exit status: 0 done, 1 the machine failed (out of memory, disk full), 2 a mistake in the arguments or the recipe.\n";

typedef struct options {
  const char *recipe, *output, *report;
  const char* sets[256];
  uint32_t set_count, threads;
  bool quiet, print;
} options;

static int fail(int status, const char* what, const char* why) {
  fprintf(stderr, "scree-bake: %s: %s\n", what, why);
  return status;
}

/* Returns -1 to go on, else the exit status. */
static int parse_options(int count, char** arguments, options* out) {
  memset(out, 0, sizeof *out);
  for (int i = 1; i < count; ++i) {
    const char* name = arguments[i];
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0) {
      fputs(usage, stdout);
      return 0;
    }
    if (strcmp(name, "--version") == 0) {
      printf("scree-bake %s\n", scree_version_string());
      return 0;
    }
    if (strcmp(name, "-q") == 0 || strcmp(name, "--quiet") == 0)
      out->quiet = true;
    else if (strcmp(name, "--print-recipe") == 0)
      out->print = true;
    else if (name[0] == '-' && name[1] != '\0') {
      const bool known = strcmp(name, "-o") == 0 || strcmp(name, "--output") == 0 || strcmp(name, "--set") == 0 ||
                         strcmp(name, "--threads") == 0 || strcmp(name, "--report") == 0;
      if (!known) return fail(2, name, "unknown option; see --help");
      if (i + 1 == count) return fail(2, name, "needs a value; see --help");
      const char* value = arguments[++i];
      if (strcmp(name, "--set") == 0) {
        if (out->set_count == sizeof out->sets / sizeof *out->sets) return fail(2, name, "given too often");
        out->sets[out->set_count++] = value;
      } else if (strcmp(name, "--threads") == 0) {
        char* end;
        const long threads = strtol(value, &end, 10);
        if (*value == '\0' || *end != '\0' || threads < 1 || threads > 64)
          return fail(2, value, "--threads takes a number from 1 to 64");
        out->threads = (uint32_t)threads;
      } else if (strcmp(name, "--report") == 0)
        out->report = value;
      else
        out->output = value;
    } else if (out->recipe == NULL)
      out->recipe = name;
    else
      return fail(2, name, "one recipe at a time; see --help");
  }
  if (out->recipe == NULL) return fail(2, "no recipe", "see --help");
  if (out->output == NULL && !out->print) return fail(2, "no output", "give -o PACK.scree; see --help");
  return -1;
}

static char* read_text(const char* path, size_t* size) {
  FILE* file = fopen(path, "rb");
  char* text = NULL;
  size_t capacity = 0;
  *size = 0;
  if (file == NULL) return NULL;
  for (;;) {
    if (*size == capacity) {
      capacity = capacity == 0 ? 4096 : capacity * 2;
      char* larger = capacity > (size_t)1 << 24 ? NULL : realloc(text, capacity); /* no recipe is that long */
      if (larger == NULL) {
        errno = EFBIG;
        break;
      }
      text = larger;
    }
    const size_t got = fread(text + *size, 1, capacity - *size, file);
    *size += got;
    if (got == 0) {
      if (ferror(file) != 0) break;
      fclose(file);
      return text;
    }
  }
  const int reason = errno;
  free(text);
  fclose(file);
  errno = reason;
  return NULL;
}

/* error: names the file. */
static int fail_with_file(int status, const scree_error* error) {
  fprintf(stderr, "scree-bake: %s\n", error->message);
  return status;
}

/* The file is whole or not there. */
static bool write_file(const char* path, const void* bytes, size_t size, scree_error* error) {
  file_replacement file;
  if (file_replace_begin(path, &file, error) != SCREE_OK) return false;
  fwrite(bytes, 1, size, file.stream); /* what fails here, the end finds */
  return file_replace_commit(&file, error) == SCREE_OK;
}

static bool show_progress(void* user, const char* stage, double done) {
  (void)user;
  char bar[41];
  const int filled = (int)(done * 40);
  for (int i = 0; i < 40; ++i) bar[i] = i < filled ? '#' : '.';
  bar[40] = '\0';
  fprintf(stderr, "\r%-7s [%s] %3d %%", stage, bar, (int)(done * 100));
  return true;
}

/* What was baked, of any kind. */
typedef struct baked {
  const char* name;   /* the recipe's */
  const char* pieces; /* "rocks", "models" or "assets" */
  uint32_t lod_levels, threads;
  uint8_t* bytes;
  size_t size;
  scree_bake_report report;
  bool has_shards;
  scree_shard_report shards; /* where it has some */
} baked;

/* Members of the report that only shards have. */
static void describe_shards(const scree_shard_report* shards, char* text, size_t capacity) {
  snprintf(text, capacity,
           "  \"shards\": %u,\n  \"interior_links\": %u,\n  \"exterior_links\": %u,\n  \"times\": %u,\n  \"blocks\": %u,\n"
           "  \"placements\": %u,\n  \"paths\": %llu,\n  \"breaks\": %llu,\n  \"share\": %.6f,\n",
           shards->shards, shards->interior_links, shards->exterior_links, shards->times, shards->blocks, shards->placements,
           (unsigned long long)shards->paths, (unsigned long long)shards->breaks, shards->share);
}

static bool write_report(const char* path, const baked* pack, scree_error* error) {
  const scree_bake_report* report = &pack->report;
  char* text = NULL;
  size_t size = 0;
  FILE* out = open_memstream(&text, &size);
  if (out == NULL) {
    fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", path);
    return false;
  }
  fprintf(out, "{\n  \"recipe\": \"");
  for (const char* c = pack->name; *c != '\0'; ++c) {
    if (*c == '"' || *c == '\\') fputc('\\', out);
    if ((unsigned char)*c >= ' ') fputc(*c, out);
  }
  fprintf(out, "\",\n  \"%s\": %u,\n  \"contacts\": %llu,\n  \"triangles\": %llu,\n  \"lod_triangles\": [", pack->pieces,
          report->rocks, (unsigned long long)report->contacts, (unsigned long long)report->triangles);
  for (uint32_t level = 0; level < pack->lod_levels; ++level)
    fprintf(out, "%s%llu", level == 0 ? "" : ", ", (unsigned long long)report->lod_triangles[level]);
  char shards[512] = "";
  if (pack->has_shards) describe_shards(&pack->shards, shards, sizeof shards);
  fprintf(out,
          "],\n%s  \"proxies\": %u,\n  \"proxy_triangles\": %llu,\n  \"proxy_bytes\": %llu,\n  \"bytes\": %llu,\n  \"digest\": "
          "\"%016llx\",\n  \"threads\": %u,\n  \"version\": \"%s\",\n  \"seconds\": {\n",
          shards, report->proxies, (unsigned long long)report->proxy_triangles, (unsigned long long)report->proxy_bytes,
          (unsigned long long)report->bytes, (unsigned long long)report->digest, pack->threads, scree_version_string());
  for (uint32_t s = 0; s < report->stage_count; ++s)
    fprintf(out, "    \"%s\": %.3f,\n", report->stages[s].name, report->stages[s].seconds);
  fprintf(out, "    \"total\": %.3f\n  }\n}\n", report->seconds);
  bool good = fclose(out) == 0;
  if (good && strcmp(path, "-") == 0) good = fwrite(text, 1, size, stdout) == size && fflush(stdout) == 0;
  if (!good) fail_with(error, SCREE_ERROR_IO, "%s: cannot write", path);
  if (good && strcmp(path, "-") != 0) good = write_file(path, text, size, error);
  free(text);
  return good;
}

/* Which of the recipes it is, and what goes with it. */
typedef struct any_recipe {
  scree_recipe_kind kind;
  scree_recipe rocks;
  scree_hoodoo_recipe hoodoo;
  scree_shard_recipe shards;
} any_recipe;

static scree_result parse_recipe(const char* text, size_t size, any_recipe* out, scree_error* error) {
  switch (out->kind) {
    case SCREE_RECIPE_HOODOO: return scree_hoodoo_parse(text, size, &out->hoodoo, error);
    case SCREE_RECIPE_SHARDS: return scree_shard_recipe_parse(text, size, &out->shards, error);
    case SCREE_RECIPE_ROCKS: break;
  }
  return scree_recipe_parse(text, size, &out->rocks, error);
}

static scree_result set_key(any_recipe* recipe, const char* set, scree_error* error) {
  switch (recipe->kind) {
    case SCREE_RECIPE_HOODOO: return scree_hoodoo_set(&recipe->hoodoo, set, error);
    case SCREE_RECIPE_SHARDS: return scree_shard_recipe_set(&recipe->shards, set, error);
    case SCREE_RECIPE_ROCKS: break;
  }
  return scree_recipe_set(&recipe->rocks, set, error);
}

static size_t write_recipe(const any_recipe* recipe, char* text, size_t capacity) {
  switch (recipe->kind) {
    case SCREE_RECIPE_HOODOO: return scree_hoodoo_write(&recipe->hoodoo, text, capacity);
    case SCREE_RECIPE_SHARDS: return scree_shard_recipe_write(&recipe->shards, text, capacity);
    case SCREE_RECIPE_ROCKS: break;
  }
  return scree_recipe_write(&recipe->rocks, text, capacity);
}

/* Returns -1 to go on, else the exit status. */
static int read_recipe(const options* given, any_recipe* out) {
  size_t size;
  scree_error error = {{0}};
  char* text = read_text(given->recipe, &size);
  if (text == NULL) return fail(2, given->recipe, strerror(errno));
  scree_result result = scree_recipe_get_kind(text, size, &out->kind, &error);
  if (result == SCREE_OK) result = parse_recipe(text, size, out, &error);
  free(text);
  if (result != SCREE_OK) return fail(2, given->recipe, error.message);
  for (uint32_t s = 0; s < given->set_count; ++s)
    if (set_key(out, given->sets[s], &error) != SCREE_OK) return fail(2, "--set", error.message);
  return -1;
}

static int print_recipe(const any_recipe* recipe) {
  const size_t size = write_recipe(recipe, NULL, 0) + 1;
  char* text = malloc(size);
  if (text == NULL) return fail(1, "--print-recipe", "out of memory");
  write_recipe(recipe, text, size);
  fputs(text, stdout);
  free(text);
  return 0;
}

static scree_result bake_rocks(const any_recipe* recipe, const scree_jobs* jobs, bool terminal, baked* out, scree_error* error) {
  const scree_bake_desc desc = {.recipe = &recipe->rocks, .jobs = *jobs, .progress = terminal ? show_progress : NULL};
  out->name = recipe->rocks.name;
  out->pieces = "rocks";
  out->lod_levels = recipe->rocks.lod_levels;
  return scree_bake_rocks(&desc, &out->bytes, &out->size, &out->report, error);
}

/* Files that the recipe names lie beside it. */
static scree_result bake_hoodoo(const any_recipe* recipe, const char* path, const scree_jobs* jobs, bool terminal, baked* out,
                                scree_error* error) {
  scree_hoodoo_desc desc = {.recipe = &recipe->hoodoo, .jobs = *jobs, .progress = terminal ? show_progress : NULL};
  out->name = recipe->hoodoo.name;
  out->pieces = "models";
  out->lod_levels = recipe->hoodoo.lod_levels;
  start_files files;
  scree_result result = start_files_read(&recipe->hoodoo, path, &files, error);
  if (result != SCREE_OK) return result;
  desc.map = files.map;
  desc.map_width = files.width;
  desc.map_depth = files.depth;
  desc.mesh = files.mesh;
  result = scree_hoodoo_bake(&desc, &out->bytes, &out->size, &out->report, error);
  start_files_free(&files);
  return result;
}

static scree_result bake_shards(const any_recipe* recipe, const char* path, const scree_jobs* jobs, bool terminal, baked* out,
                                scree_error* error) {
  scree_shard_desc desc = {.recipe = &recipe->shards, .jobs = *jobs, .progress = terminal ? show_progress : NULL};
  out->name = recipe->shards.name;
  out->pieces = "assets";
  out->lod_levels = recipe->shards.lod_levels;
  shard_files files;
  scree_result result = shard_files_read(&recipe->shards, path, &files, error);
  if (result != SCREE_OK) return result;
  shard_files_give(&files, &desc);
  result = scree_shards_bake(&desc, &out->bytes, &out->size, &out->shards, error);
  out->report = out->shards.bake;
  out->has_shards = true;
  shard_files_free(&files);
  return result;
}

static scree_result bake(const any_recipe* recipe, const char* path, const scree_jobs* jobs, bool terminal, baked* out,
                         scree_error* error) {
  switch (recipe->kind) {
    case SCREE_RECIPE_HOODOO: return bake_hoodoo(recipe, path, jobs, terminal, out, error);
    case SCREE_RECIPE_SHARDS: return bake_shards(recipe, path, jobs, terminal, out, error);
    case SCREE_RECIPE_ROCKS: break;
  }
  return bake_rocks(recipe, jobs, terminal, out, error);
}

/* A mistake of the recipe, and not of the machine. */
static bool is_mistake(scree_result result) {
  return result != SCREE_ERROR_OUT_OF_MEMORY && result != SCREE_ERROR_UNSUPPORTED && result != SCREE_ERROR_CANCELLED;
}

int main(int count, char** arguments) {
  options given;
  int status = parse_options(count, arguments, &given);
  if (status >= 0) return status;
  static any_recipe recipe; /* large for a stack */
  status = read_recipe(&given, &recipe);
  if (status >= 0) return status;
  if (given.print) return print_recipe(&recipe);

  scree_error error = {{0}};
  const bool reports_to_file = given.report != NULL && strcmp(given.report, "-") != 0;
  if (reports_to_file && file_is_replaced(given.report) && strcmp(given.report, given.output) == 0)
    return fail(2, given.report, "cannot be both the pack and the report");
  if (file_replace_check(given.output, &error) != SCREE_OK) return fail_with_file(2, &error);
  if (reports_to_file && file_replace_check(given.report, &error) != SCREE_OK) return fail_with_file(2, &error);

  const bool terminal = isatty(STDERR_FILENO) != 0 && !given.quiet;
  const uint32_t threads = given.threads > 0 ? given.threads : scree_threads_processors();
  scree_threads* pool;
  scree_result result = scree_threads_create(threads - 1, NULL, &pool);
  if (result != SCREE_OK) return fail(1, "threads", scree_result_string(result));
  const scree_jobs jobs = scree_threads_jobs(pool);
  baked pack = {.threads = jobs.worker_count};
  result = bake(&recipe, given.recipe, &jobs, terminal, &pack, &error);
  scree_threads_destroy(pool);
  if (terminal) fprintf(stderr, "\r%*s\r", 60, "");
  if (result != SCREE_OK)
    return fail(is_mistake(result) ? 2 : 1, given.recipe, error.message[0] != '\0' ? error.message : scree_result_string(result));

  for (uint32_t s = 0; s < SCREE_SHARD_REGIONS && pack.has_shards; ++s)
    if (pack.shards.idle_states >> s & 1)
      fprintf(stderr, "scree-bake: %s: warning: states[%u]: no shard lies there\n", given.recipe, s);

  int exit_status = 0;
  if (!write_file(given.output, pack.bytes, pack.size, &error)) exit_status = fail_with_file(1, &error);
  scree_bake_free(&(scree_bake_desc){0}, pack.bytes, pack.size); /* all kinds come from the default allocator */
  if (exit_status == 0 && given.report != NULL && !write_report(given.report, &pack, &error))
    exit_status = fail_with_file(1, &error);
  const scree_bake_report* report = &pack.report;
  if (exit_status == 0 && terminal && pack.has_shards)
    fprintf(stderr, "%s: %u shards, %u times, %u blocks in %u places, %.1f %% stands after %llu paths\n", given.output,
            pack.shards.shards, pack.shards.times, pack.shards.blocks, pack.shards.placements, 100 * pack.shards.share,
            (unsigned long long)pack.shards.paths);
  if (exit_status == 0 && terminal)
    fprintf(stderr, "%s: %u %s, %llu triangles, %.1f MB, digest %016llx, %.1f s\n", given.output, report->rocks, pack.pieces,
            (unsigned long long)report->triangles, (double)report->bytes * 1e-6, (unsigned long long)report->digest,
            report->seconds);
  return exit_status;
}
