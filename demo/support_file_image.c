/* Height maps from 16-bit grey PNG pictures, through stb_image. */
#include <stb_image.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"
#include "support_file.h"

#define IMAGE_FILE_LIMIT ((size_t)1 << 30)

static scree_result crop_samples(const scene_height_map* map, const char* file, const stbi_us* pixels, uint32_t width,
                                 uint32_t depth, height_samples* out, scree_error* error) {
  uint32_t x = map->crop[0], z = map->crop[1], columns = map->crop[2], rows = map->crop[3];
  if (columns == 0 && rows == 0) x = z = 0, columns = width, rows = depth;
  if (columns > width || rows > depth || x > width - columns || z > depth - rows)
    return fail_with(error, SCREE_ERROR_RANGE, "%s: the crop [%u, %u, %u, %u] lies outside the picture of %u x %u", file, x, z,
                     columns, rows, width, depth);
  if (columns < 2 || rows < 2) return fail_with(error, SCREE_ERROR_RANGE, "%s: expected at least 2 x 2 samples", file);
  float* heights = malloc((size_t)columns * rows * sizeof *heights);
  if (heights == NULL) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", file);
  for (uint32_t row = 0; row < rows; ++row) {
    const stbi_us* from = pixels + (size_t)(z + row) * width + x;
    float* to = heights + (size_t)row * columns;
    for (uint32_t i = 0; i < columns; ++i) to[i] = (float)(map->low + (map->high - map->low) * (double)from[i] / 65535.0);
  }
  *out = (height_samples){heights, columns, rows};
  return SCREE_OK;
}

scree_result height_samples_load(const scene_height_map* map, const char* file, height_samples* out, scree_error* error) {
  static const char signature[8] = "\x89PNG\r\n\x1a\n";
  *out = (height_samples){0};
  char* bytes;
  size_t size;
  scree_result result = file_read(file, IMAGE_FILE_LIMIT, &bytes, &size, error);
  if (result != SCREE_OK) return result;
  const stbi_uc* data = (const stbi_uc*)bytes;
  int width = 0, depth = 0, channels = 0;
  if (size < sizeof signature || memcmp(bytes, signature, sizeof signature) != 0 ||
      !stbi_info_from_memory(data, (int)size, &width, &depth, &channels)) {
    result = fail_with(error, SCREE_ERROR_SYNTAX, "%s: not a PNG picture", file);
  } else if (channels != 1 || !stbi_is_16_bit_from_memory(data, (int)size)) {
    result = fail_with(error, SCREE_ERROR_UNSUPPORTED, "%s: expected a grey PNG of 16 bits a sample, got %d channels of %d bits",
                       file, channels, stbi_is_16_bit_from_memory(data, (int)size) ? 16 : 8);
  } else if (width > SCENE_CROP_MAX || depth > SCENE_CROP_MAX) {
    result = fail_with(error, SCREE_ERROR_RANGE, "%s: %d x %d samples, more than the %d x %d that are read", file, width, depth,
                       SCENE_CROP_MAX, SCENE_CROP_MAX);
  } else {
    stbi_us* pixels = stbi_load_16_from_memory(data, (int)size, &width, &depth, &channels, 1);
    if (pixels == NULL) {
      result = fail_with(error, SCREE_ERROR_SYNTAX, "%s: broken PNG: %s", file, stbi_failure_reason());
    } else {
      result = crop_samples(map, file, pixels, (uint32_t)width, (uint32_t)depth, out, error);
      stbi_image_free(pixels);
    }
  }
  free(bytes);
  return result;
}

void height_samples_free(height_samples* samples) {
  free(samples->heights);
  *samples = (height_samples){0};
}
