#include <stdlib.h>
#include <string.h>

#include "file.h"
#include "start_files.h"
#ifdef SCREE_WITH_MESHES
#include "support_file.h"
#endif

#ifdef SCREE_WITH_STB
#include <stb_image.h>

enum { IMAGES_LIMIT = 1 << 28, IMAGES_SIDE = 16384 };

/* Slices one below the other, each with its first row on top: rows become y upwards. */
static scree_result read_images(const scree_shard_images* images, const char* file, shard_files* out, scree_error* error) {
  char* bytes;
  size_t size;
  scree_error fault = {{0}};
  scree_result result = file_read(file, IMAGES_LIMIT, &bytes, &size, &fault);
  if (result != SCREE_OK) return fail_with(error, result, "images.file: %.400s", fault.message);
  const stbi_uc* data = (const stbi_uc*)bytes;
  int width = 0, height = 0, channels = 0;
  stbi_uc* grey = NULL;
  if (!stbi_info_from_memory(data, (int)size, &width, &height, &channels))
    result = fail_with(error, SCREE_ERROR_SYNTAX, "images.file: %s: not a PNG picture", file);
  else if (width > IMAGES_SIDE || height > IMAGES_SIDE)
    result = fail_with(error, SCREE_ERROR_RANGE, "images.file: %s: %d x %d pixels, more than the %d x %d that are read", file,
                       width, height, IMAGES_SIDE, IMAGES_SIDE);
  else if ((uint32_t)height % images->slices != 0)
    result = fail_with(error, SCREE_ERROR_RANGE, "images.slices: %u images do not share the %d rows of %s evenly", images->slices,
                       height, file);
  else if ((grey = stbi_load_from_memory(data, (int)size, &width, &height, &channels, 1)) == NULL)
    result = fail_with(error, SCREE_ERROR_SYNTAX, "images.file: %s: broken PNG: %s", file, stbi_failure_reason());
  else if ((out->images = malloc((size_t)width * (size_t)height)) == NULL)
    result = fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "images.file: %s: out of memory", file);
  if (result == SCREE_OK) {
    const size_t columns = (size_t)width, rows = (size_t)height / images->slices;
    for (size_t z = 0; z < images->slices; ++z)
      for (size_t y = 0; y < rows; ++y)
        memcpy(out->images + (z * rows + y) * columns, grey + (z * rows + rows - 1 - y) * columns, columns);
    out->image_size[0] = (uint32_t)columns;
    out->image_size[1] = (uint32_t)rows;
    out->image_size[2] = images->slices;
  }
  if (grey != NULL) stbi_image_free(grey);
  free(bytes);
  return result;
}
#else
static scree_result read_images(const scree_shard_images* images, const char* file, shard_files* out, scree_error* error) {
  (void)images;
  (void)out;
  return fail_with(error, SCREE_ERROR_UNSUPPORTED, "images.file: %s: this build reads no pictures", file);
}
#endif

#ifdef SCREE_WITH_MESHES
static scree_result read_mesh(const char* file, shard_files* out, scree_error* error) {
  triangle_mesh mesh;
  scree_error fault = {{0}};
  scree_result result = triangle_mesh_load(file, &mesh, &fault);
  if (result == SCREE_ERROR_UNSUPPORTED) result = SCREE_ERROR_SYNTAX; /* of this file, not by this build */
  if (result != SCREE_OK) return fail_with(error, result, "input.file: %.400s", fault.message);
  const size_t count = (size_t)3 * mesh.vertex_count;
  out->positions = malloc((count > 0 ? count : 1) * sizeof *out->positions);
  if (out->positions == NULL)
    result = fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "input.file: %s: out of memory", file);
  else {
    for (size_t i = 0; i < count; ++i) out->positions[i] = (double)mesh.positions[i];
    out->indices = mesh.indices;
    out->uvs = mesh.uvs;
    mesh.indices = NULL;
    mesh.uvs = NULL;
    out->mesh = (scree_solid){.positions = out->positions,
                              .indices = out->indices,
                              .uvs = out->uvs,
                              .vertex_count = mesh.vertex_count,
                              .triangle_count = mesh.triangle_count};
  }
  triangle_mesh_free(&mesh);
  return result;
}

static scree_result read_heights(const scree_shard_input* input, const char* file, shard_files* out, scree_error* error) {
  scene_height_map map = {.spacing = input->spacing, .low = input->low, .high = input->high};
  memcpy(map.crop, input->crop, sizeof map.crop);
  height_samples samples;
  scree_error fault = {{0}};
  scree_result result = height_samples_load(&map, file, &samples, &fault);
  if (result == SCREE_ERROR_UNSUPPORTED) result = SCREE_ERROR_SYNTAX; /* of this file */
  if (result != SCREE_OK) return fail_with(error, result, "input.file: %.400s", fault.message);
  out->heights = samples.heights;
  out->width = samples.width;
  out->depth = samples.depth;
  return SCREE_OK;
}
#else
static scree_result read_mesh(const char* file, shard_files* out, scree_error* error) {
  (void)out;
  return fail_with(error, SCREE_ERROR_UNSUPPORTED, "input.file: %s: this build reads no meshes", file);
}

static scree_result read_heights(const scree_shard_input* input, const char* file, shard_files* out, scree_error* error) {
  (void)input;
  (void)out;
  return fail_with(error, SCREE_ERROR_UNSUPPORTED, "input.file: %s: this build reads no height maps", file);
}
#endif

static scree_result read_hoodoo(const char* file, shard_files* out, scree_error* error) {
  enum { RECIPE_LIMIT = 1 << 24 };
  char* text;
  size_t size;
  scree_error fault = {{0}};
  scree_result result = file_read(file, RECIPE_LIMIT, &text, &size, &fault);
  if (result != SCREE_OK) return fail_with(error, result, "input.file: %.400s", fault.message);
  out->hoodoo = malloc(sizeof *out->hoodoo);
  if (out->hoodoo == NULL)
    result = fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "input.file: %s: out of memory", file);
  else {
    result = scree_hoodoo_parse(text, size, out->hoodoo, &fault);
    if (result == SCREE_OK) result = start_files_read(out->hoodoo, file, &out->hoodoo_files, &fault);
    if (result != SCREE_OK) fail_with(error, result, "input.file: %.200s: %.250s", file, fault.message);
  }
  free(text);
  return result;
}

scree_result shard_files_read(const scree_shard_recipe* recipe, const char* path, shard_files* out, scree_error* error) {
  const scree_shard_shape shape = recipe->input.shape;
  char file[4096];
  scree_result result = SCREE_OK;
  memset(out, 0, sizeof *out);
  if (shape == SCREE_SHARD_MESH || shape == SCREE_SHARD_TERRAIN || shape == SCREE_SHARD_HOODOO) {
    if (!file_beside(path, recipe->input.file, file, sizeof file))
      return fail_with(error, SCREE_ERROR_RANGE, "input.file: the path is too long");
    result = shape == SCREE_SHARD_MESH      ? read_mesh(file, out, error)
             : shape == SCREE_SHARD_TERRAIN ? read_heights(&recipe->input, file, out, error)
                                            : read_hoodoo(file, out, error);
  }
  if (result == SCREE_OK && recipe->images.file[0] != '\0') {
    if (file_beside(path, recipe->images.file, file, sizeof file))
      result = read_images(&recipe->images, file, out, error);
    else
      result = fail_with(error, SCREE_ERROR_RANGE, "images.file: the path is too long");
  }
  if (result != SCREE_OK) shard_files_free(out);
  out->hoodoo_desc = (scree_hoodoo_desc){.recipe = out->hoodoo,
                                         .map = out->hoodoo_files.map,
                                         .map_width = out->hoodoo_files.width,
                                         .map_depth = out->hoodoo_files.depth,
                                         .mesh = out->hoodoo_files.mesh};
  return result;
}

void shard_files_give(const shard_files* files, scree_shard_desc* desc) {
  if (files->positions != NULL) desc->mesh = &files->mesh;
  if (files->hoodoo != NULL) desc->hoodoo = &files->hoodoo_desc;
  desc->heights = files->heights;
  desc->height_width = files->width;
  desc->height_depth = files->depth;
  desc->images = files->images;
  memcpy(desc->image_size, files->image_size, sizeof desc->image_size);
}

void shard_files_free(shard_files* files) {
  free(files->positions);
  free(files->indices);
  free(files->uvs);
  free(files->heights);
  free(files->hoodoo);
  start_files_free(&files->hoodoo_files);
  free(files->images);
  memset(files, 0, sizeof *files);
}
