/* Where the files of a scene are, and the ones that were read already. */
#include <stdlib.h>
#include <string.h>

#include "file.h"
#include "scene_support.h"

typedef struct entry {
  char path[SCENE_FILE_SIZE * 4];
  bool is_mesh;
  scene_height_map map; /* heights only */
  triangle_mesh mesh;
  height_samples heights;
  struct entry* next;
} entry;

struct scene_files {
  entry* first;
};

scene_files* scene_files_create(void) {
  return calloc(1, sizeof(scene_files));
}

void scene_files_destroy(scene_files* files) {
  if (files == NULL) return;
  for (entry *e = files->first, *next; e != NULL; e = next) {
    next = e->next;
    triangle_mesh_free(&e->mesh);
    height_samples_free(&e->heights);
    free(e);
  }
  free(files);
}

static const char* packs_of(const scene_paths* paths) {
  return paths->packs != NULL ? paths->packs : SCENE_DEFAULT_PACKS;
}
static const char* data_of(const scene_paths* paths) {
  return paths->data != NULL ? paths->data : SCENE_DEFAULT_DATA;
}

static bool format_path(char* out, size_t capacity, const char* folder, const char* name, const char* ending) {
  int length = snprintf(out, capacity, "%s/%s%s", folder, name, ending);
  return length >= 0 && (size_t)length < capacity;
}

static scree_result too_long(const scene_paths* paths, const char* where, scree_error* error) {
  return fail_with(error, SCREE_ERROR_RANGE, "%s: %s: the path is too long", paths->scene, where);
}

scree_result scene_find_pack(const scene_paths* paths, const char* where, const char* pack, char* out, size_t capacity,
                             scree_error* error) {
  size_t length = strlen(pack);
  bool is_path = strchr(pack, '/') != NULL || (length > 6 && strcmp(pack + length - 6, ".scree") == 0);
  bool fits =
      is_path ? file_beside(paths->scene, pack, out, capacity) : format_path(out, capacity, packs_of(paths), pack, ".scree");
  if (!fits) return too_long(paths, where, error);
  if (file_exists(out)) return SCREE_OK;
  return fail_with(error, SCREE_ERROR_IO, "%s: %s: there is no pack \"%s\": %s does not exist", paths->scene, where, pack, out);
}

scree_result scene_find_file(const scene_paths* paths, const char* where, const char* file, char* out, size_t capacity,
                             scree_error* error) {
  if (!file_beside(paths->scene, file, out, capacity)) return too_long(paths, where, error);
  if (file_exists(out)) return SCREE_OK;
  if (file[0] == '/') return fail_with(error, SCREE_ERROR_IO, "%s: %s: %s does not exist", paths->scene, where, file);
  if (!format_path(out, capacity, data_of(paths), file, "")) return too_long(paths, where, error);
  if (file_exists(out)) return SCREE_OK;
  return fail_with(error, SCREE_ERROR_IO, "%s: %s: \"%s\" is neither beside the scene nor in the data folder %s", paths->scene,
                   where, file, data_of(paths));
}

static bool same_map(const scene_height_map* a, const scene_height_map* b) {
  return a->low == b->low && a->high == b->high && memcmp(a->crop, b->crop, sizeof a->crop) == 0;
}

/* The entry of a file, read unless it is known. */
static scree_result find_entry(scene_files* files, const scene_paths* paths, const char* where, const char* file,
                               const scene_height_map* map, const entry** out, scree_error* error) {
  *out = NULL;
  entry* e = calloc(1, sizeof *e);
  if (e == NULL) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", paths->scene);
  scree_error cause = {""};
  scree_result result = scene_find_file(paths, where, file, e->path, sizeof e->path, error);
  if (result != SCREE_OK) {
    free(e);
    return result;
  }
  for (const entry* known = files->first; known != NULL; known = known->next) {
    if (known->is_mesh != (map == NULL) || strcmp(known->path, e->path) != 0) continue;
    if (map != NULL && !same_map(map, &known->map)) continue;
    free(e);
    *out = known;
    return SCREE_OK;
  }
  e->is_mesh = map == NULL;
  if (map != NULL) e->map = *map;
  result = map == NULL ? triangle_mesh_load(e->path, &e->mesh, &cause) : height_samples_load(map, e->path, &e->heights, &cause);
  if (result != SCREE_OK) {
    fail_with(error, result, "%s: %s: %.400s", paths->scene, where, cause.message);
    free(e);
    return result;
  }
  e->next = files->first;
  files->first = e;
  *out = e;
  return SCREE_OK;
}

scree_result scene_files_mesh(scene_files* files, const scene_paths* paths, const char* where, const char* file,
                              const triangle_mesh** out, scree_error* error) {
  const entry* found;
  scree_result result = find_entry(files, paths, where, file, NULL, &found, error);
  *out = found != NULL ? &found->mesh : NULL;
  return result;
}

scree_result scene_files_heights(scene_files* files, const scene_paths* paths, const char* where, const scene_height_map* map,
                                 const height_samples** out, scree_error* error) {
  const entry* found;
  scree_result result = find_entry(files, paths, where, map->file, map, &found, error);
  *out = found != NULL ? &found->heights : NULL;
  return result;
}
