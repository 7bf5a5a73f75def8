/* Where the files of a scene are, and the ones that were read already. */
#include <stdlib.h>
#include <string.h>

#include <scree/cliff.h>
#include <scree/draco.h>

#include "file.h"
#include "scene_support.h"

typedef struct entry {
  char path[SCENE_FILE_SIZE * 4];
  bool is_mesh;
  uint32_t time, lod;   /* of a mesh of a cliff; 0 of others */
  uint32_t times;       /* that its pack keeps */
  scene_height_map map; /* heights only */
  triangle_mesh mesh;   /* of a file; its UVs are let go */
  scree_mesh cliff;     /* of a pack */
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
    scree_cliff_mesh_free(NULL, &e->cliff);
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

static scree_result say(scree_result result, const char* path, const char* what, scree_error* error) {
  return fail_with(error, result, "%s: %s", path, what != NULL ? what : scree_result_string(result));
}

#ifdef SCREE_WITH_DRACO
static scree_result decode_cliff(const scree_pack* pack, uint32_t asset, uint32_t level, const char* path, scree_mesh* out,
                                 scree_error* error) {
  scree_lod lod;
  scree_result result = scree_pack_get_lod(pack, asset, level, &lod);
  if (result != SCREE_OK) return say(result, path, NULL, error);
  scree_vertex* vertices = malloc(lod.vertices * sizeof *vertices);
  uint32_t* indices = malloc(3 * (size_t)lod.triangles * sizeof *indices);
  result = SCREE_ERROR_OUT_OF_MEMORY;
  if (vertices != NULL && indices != NULL)
    result = scree_draco_decode_u32(pack, asset, level, vertices, lod.vertices, indices, 3 * (size_t)lod.triangles);
  if (result == SCREE_OK) result = scree_cliff_mesh_create(pack, vertices, lod.vertices, indices, 3 * lod.triangles, NULL, out);
  free(vertices);
  free(indices);
  return result == SCREE_OK ? result : say(result, path, NULL, error);
}
#endif

/* What stands of a cliff, from its pack. times: how many it keeps. */
static scree_result load_cliff(const char* path, const scene_mesh* from, scree_mesh* out, uint32_t* times, scree_error* error) {
  scree_pack* pack;
  scree_result result = scree_pack_open_file(path, NULL, &pack);
  if (result != SCREE_OK) return say(result, path, NULL, error);
  scree_pack_info info;
  scree_cliff_time time;
  scree_pack_get_info(pack, &info);
  *times = info.time_count;
  if (info.kind != SCREE_PACK_CLIFF)
    result = say(SCREE_ERROR_PACK_KIND, path, "holds no cliff", error);
  else if (from->time >= info.time_count)
    result = fail_with(error, SCREE_ERROR_RANGE, "%s: it has %u times, 0 the first", path, info.time_count);
  else if ((result = scree_pack_get_time(pack, from->time, &time)) != SCREE_OK)
    result = say(result, path, NULL, error);
  else {
#ifdef SCREE_WITH_DRACO
    result = decode_cliff(pack, time.asset, from->lod < info.lod_count ? from->lod : info.lod_count - 1, path, out, error);
#else
    (void)out;
    result = say(SCREE_ERROR_UNSUPPORTED, path, "this program was built without Draco, which meshes of cliffs need", error);
#endif
  }
  scree_pack_close(pack);
  return result;
}

/* The entry of a file, read unless it is known. map: NULL of a mesh; mesh: empty of heights. */
static scree_result find_entry(scene_files* files, const scene_paths* paths, const char* where, const scene_mesh* mesh,
                               const scene_height_map* map, const entry** out, scree_error* error) {
  const bool is_cliff = mesh->pack[0] != '\0';
  *out = NULL;
  entry* e = calloc(1, sizeof *e);
  if (e == NULL) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", paths->scene);
  scree_error cause = {""};
  scree_result result = is_cliff
                            ? scene_find_pack(paths, where, mesh->pack, e->path, sizeof e->path, error)
                            : scene_find_file(paths, where, map != NULL ? map->file : mesh->file, e->path, sizeof e->path, error);
  if (result != SCREE_OK) {
    free(e);
    return result;
  }
  for (const entry* known = files->first; known != NULL; known = known->next) {
    if (known->is_mesh != (map == NULL) || strcmp(known->path, e->path) != 0) continue;
    if (map != NULL && !same_map(map, &known->map)) continue;
    if (is_cliff && (known->time != mesh->time || known->lod != mesh->lod)) continue;
    free(e);
    *out = known;
    return SCREE_OK;
  }
  e->is_mesh = map == NULL;
  if (map != NULL) e->map = *map;
  if (is_cliff) {
    e->time = mesh->time;
    e->lod = mesh->lod;
  }
  result = map != NULL ? height_samples_load(map, e->path, &e->heights, &cause)
           : is_cliff  ? load_cliff(e->path, mesh, &e->cliff, &e->times, &cause)
                       : triangle_mesh_load(e->path, &e->mesh, &cause);
  if (result != SCREE_OK) {
    fail_with(error, result, "%s: %s: %.400s", paths->scene, where, cause.message);
    free(e);
    return result;
  }
  free(e->mesh.uvs);
  e->mesh.uvs = NULL;
  e->next = files->first;
  files->first = e;
  *out = e;
  return SCREE_OK;
}

scree_result scene_files_mesh(scene_files* files, const scene_paths* paths, const char* where, const scene_mesh* mesh,
                              scree_mesh* out, scree_error* error) {
  const entry* found;
  const scree_result result = find_entry(files, paths, where, mesh, NULL, &found, error);
  *out = (scree_mesh){0};
  if (result != SCREE_OK) return result;
  const triangle_mesh* file = &found->mesh;
  *out = mesh->pack[0] != '\0' ? found->cliff
                               : (scree_mesh){.positions = file->positions,
                                              .indices = file->indices,
                                              .vertex_count = file->vertex_count,
                                              .triangle_count = file->triangle_count};
  out->resolution = mesh->resolution;
  return SCREE_OK;
}

uint32_t scene_files_times(const scene_files* files, const scene_paths* paths, const scene_mesh* mesh) {
  char path[SCENE_FILE_SIZE * 4];
  if (mesh->pack[0] == '\0' || scene_find_pack(paths, "", mesh->pack, path, sizeof path, NULL) != SCREE_OK) return 0;
  for (const entry* known = files->first; known != NULL; known = known->next)
    if (known->times > 0 && strcmp(known->path, path) == 0) return known->times;
  return 0;
}

static const scene_mesh no_mesh;

scree_result scene_files_heights(scene_files* files, const scene_paths* paths, const char* where, const scene_height_map* map,
                                 const height_samples** out, scree_error* error) {
  const entry* found;
  scree_result result = find_entry(files, paths, where, &no_mesh, map, &found, error);
  *out = found != NULL ? &found->heights : NULL;
  return result;
}
