#include "start_files.h"

#include <stdlib.h>
#include <string.h>

#include "file.h"
#ifdef SCREE_WITH_MESHES
#include "support_file.h"
#endif

#ifdef SCREE_WITH_STB
#include <stb_image.h>

enum { MAP_LIMIT = 1 << 26, MAP_SIDE = 8192 };

static scree_result read_map(const char* file, start_files* out, scree_error* error) {
  char* bytes;
  size_t size;
  scree_error fault = {{0}};
  scree_result result = file_read(file, MAP_LIMIT, &bytes, &size, &fault);
  if (result != SCREE_OK) return fail_with(error, result, "start.file: %.400s", fault.message);
  int width = 0, depth = 0, channels = 0;
  const stbi_uc* data = (const stbi_uc*)bytes;
  if (!stbi_info_from_memory(data, (int)size, &width, &depth, &channels))
    result = fail_with(error, SCREE_ERROR_SYNTAX, "start.file: %s: not a PNG picture", file);
  else if (width > MAP_SIDE || depth > MAP_SIDE)
    result = fail_with(error, SCREE_ERROR_RANGE, "start.file: %s: %d x %d pixels, more than the %d x %d that are read", file, width,
                       depth, MAP_SIDE, MAP_SIDE);
  else {
    stbi_uc* grey = stbi_load_from_memory(data, (int)size, &width, &depth, &channels, 1);
    out->map = grey != NULL ? malloc((size_t)width * (size_t)depth) : NULL;
    if (grey == NULL)
      result = fail_with(error, SCREE_ERROR_SYNTAX, "start.file: %s: broken PNG: %s", file, stbi_failure_reason());
    else if (out->map == NULL)
      result = fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "start.file: %s: out of memory", file);
    else
      memcpy(out->map, grey, (size_t)width * (size_t)depth);
    stbi_image_free(grey);
    out->width = (uint32_t)width;
    out->depth = (uint32_t)depth;
  }
  free(bytes);
  return result;
}
#else
static scree_result read_map(const char* file, start_files* out, scree_error* error) {
  (void)out;
  return fail_with(error, SCREE_ERROR_UNSUPPORTED, "start.file: %s: this build reads no pictures", file);
}
#endif

#ifdef SCREE_WITH_MESHES
static scree_result read_mesh(const char* file, start_files* out, scree_error* error) {
  triangle_mesh mesh;
  scree_error fault = {{0}};
  scree_result result = triangle_mesh_load(file, &mesh, &fault);
  if (result == SCREE_ERROR_UNSUPPORTED) result = SCREE_ERROR_SYNTAX; /* of this file, not by this build */
  if (result != SCREE_OK) return fail_with(error, result, "start.file: %.400s", fault.message);
  const scree_shape shape = {.kind = SCREE_SHAPE_MESH,
                             .mesh = {.positions = mesh.positions,
                                      .vertex_count = mesh.vertex_count,
                                      .indices = mesh.indices,
                                      .triangle_count = mesh.triangle_count}};
  result = scree_support_create(&(scree_support_desc){.shapes = &shape, .shape_count = 1}, NULL, &out->mesh, &fault);
  if (result != SCREE_OK) fail_with(error, result, "start.file: %s: %.300s", file, fault.message);
  triangle_mesh_free(&mesh);
  return result;
}
#else
static scree_result read_mesh(const char* file, start_files* out, scree_error* error) {
  (void)out;
  return fail_with(error, SCREE_ERROR_UNSUPPORTED, "start.file: %s: this build reads no meshes", file);
}
#endif

scree_result start_files_read(const scree_hoodoo_recipe* recipe, const char* path, start_files* out, scree_error* error) {
  *out = (start_files){0};
  const scree_hoodoo_shape shape = recipe->start.shape;
  if (shape != SCREE_HOODOO_JOINT_MAP && shape != SCREE_HOODOO_MESH) return SCREE_OK;
  char file[4096];
  if (!file_beside(path, recipe->start.file, file, sizeof file))
    return fail_with(error, SCREE_ERROR_RANGE, "start.file: the path is too long");
  if (shape == SCREE_HOODOO_JOINT_MAP) return read_map(file, out, error);
  return read_mesh(file, out, error);
}

void start_files_free(start_files* files) {
  free(files->map);
  scree_support_destroy(files->mesh);
  *files = (start_files){0};
}
