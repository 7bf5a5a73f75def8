/* From a height map to the mesh of a terrain. */
#include "terrain.h"

#include <math.h>
#include <stdlib.h>

#include "file.h"

static void fill_terrain(const height_samples* samples, float spacing, terrain_mesh* out) {
  uint32_t width = samples->width, depth = samples->depth;
  float left = -0.5f * (float)(width - 1) * spacing, back = -0.5f * (float)(depth - 1) * spacing;
  const float* heights = samples->heights;
  for (uint32_t z = 0; z < depth; ++z) {
    for (uint32_t x = 0; x < width; ++x) {
      size_t i = (size_t)z * width + x;
      float* p = &out->positions[3 * i];
      p[0] = left + (float)x * spacing;
      p[1] = heights[i];
      p[2] = back + (float)z * spacing;
      size_t x0 = x > 0 ? i - 1 : i, x1 = x + 1 < width ? i + 1 : i;
      size_t z0 = z > 0 ? i - width : i, z1 = z + 1 < depth ? i + width : i;
      float slope_x = (heights[x1] - heights[x0]) / ((float)(x1 - x0) * spacing);
      float slope_z = (heights[z1] - heights[z0]) / ((float)((z1 - z0) / width) * spacing);
      float length = sqrtf(slope_x * slope_x + 1.0f + slope_z * slope_z);
      float* n = &out->normals[3 * i];
      n[0] = -slope_x / length;
      n[1] = 1.0f / length;
      n[2] = -slope_z / length;
    }
  }
  uint32_t* index = out->indices;
  for (uint32_t z = 0; z + 1 < depth; ++z) {
    for (uint32_t x = 0; x + 1 < width; ++x) {
      uint32_t a = z * width + x, b = a + 1, c = a + width, d = c + 1;
      /* Counter-clockwise from above, +x right and +z towards the eye. */
      *index++ = a, *index++ = c, *index++ = b;
      *index++ = b, *index++ = c, *index++ = d;
    }
  }
}

scree_result terrain_mesh_create(const scene_ground* ground, const scene_paths* paths, scene_files* files, terrain_mesh* out,
                                 scree_error* error) {
  *out = (terrain_mesh){0};
  const height_samples* samples;
  scene_files* own = files == NULL ? scene_files_create() : NULL;
  if (files == NULL && own == NULL) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", paths->scene);
  scree_result result = scene_files_heights(files != NULL ? files : own, paths, "ground", &ground->map, &samples, error);
  if (result == SCREE_OK) {
    size_t vertices = (size_t)samples->width * samples->depth;
    size_t triangles = 2 * (size_t)(samples->width - 1) * (samples->depth - 1);
    out->positions = malloc(vertices * 3 * sizeof *out->positions);
    out->normals = malloc(vertices * 3 * sizeof *out->normals);
    out->indices = malloc(triangles * 3 * sizeof *out->indices);
    out->vertex_count = (uint32_t)vertices;
    out->triangle_count = (uint32_t)triangles;
    if (out->positions == NULL || out->normals == NULL || out->indices == NULL) {
      terrain_mesh_free(out);
      result = fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", paths->scene);
    } else {
      fill_terrain(samples, (float)ground->map.spacing, out);
    }
  }
  scene_files_destroy(own);
  return result;
}

void terrain_mesh_free(terrain_mesh* mesh) {
  free(mesh->positions);
  free(mesh->normals);
  free(mesh->indices);
  *mesh = (terrain_mesh){0};
}
