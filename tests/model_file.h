/* A .glb of somebody else's, made without any baker: a pyramid on a square foot, half of it red and half of it green. */
#ifndef SCREE_TESTS_MODEL_FILE_H
#define SCREE_TESTS_MODEL_FILE_H

#include "glb.h"

enum { MODEL_FILE_TRIANGLES = 6 };

/* foot: half the side of the square, metres. Returns whether it was written. */
static inline bool model_file_write(const char* path, float foot, float height) {
  const float c[5][3] = {{-foot, 0, -foot}, {foot, 0, -foot}, {foot, 0, foot}, {-foot, 0, foot}, {0, height, 0}};
  static const int faces[MODEL_FILE_TRIANGLES][3] = {{1, 0, 4}, {2, 1, 4}, {3, 2, 4}, {0, 3, 4}, {0, 1, 2}, {0, 2, 3}};
  static const float red[3] = {1, 0, 0}, green[3] = {0, 1, 0};
  scree_error error;
  glb_writer* writer;
  if (glb_begin(path, &writer, &error) != SCREE_OK) return false;
  const uint32_t materials[2] = {glb_add_material(writer, "red", red), glb_add_material(writer, "green", green)};
  glb_node root = {.mesh = GLB_NONE,
                   .translations = GLB_NONE,
                   .instance_colours = GLB_NONE,
                   .rotations = GLB_NONE,
                   .scales = GLB_NONE,
                   .child_count = 2,
                   .is_root = true};
  for (int half = 0; half < 2; ++half) {
    float positions[27], normals[27], low[3] = {0}, high[3] = {0};
    uint16_t indices[9];
    for (int i = 0; i < 9; ++i) {
      const int* face = faces[3 * half + i / 3];
      float u[3], v[3], n[3], length = 0;
      for (int a = 0; a < 3; ++a) {
        positions[3 * i + a] = c[face[i % 3]][a];
        low[a] = i == 0 || positions[3 * i + a] < low[a] ? positions[3 * i + a] : low[a];
        high[a] = i == 0 || positions[3 * i + a] > high[a] ? positions[3 * i + a] : high[a];
        u[a] = c[face[1]][a] - c[face[0]][a];
        v[a] = c[face[2]][a] - c[face[0]][a];
      }
      for (int a = 0; a < 3; ++a) {
        n[a] = u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3];
        length += n[a] * n[a];
      }
      for (int a = 0; a < 3; ++a) normals[3 * i + a] = n[a] / sqrtf(length);
      indices[i] = (uint16_t)i;
    }
    const glb_mesh mesh = {.positions = glb_add_data(writer, GLB_POSITIONS, positions, 9, low, high),
                           .normals = glb_add_data(writer, GLB_NORMALS, normals, 9, NULL, NULL),
                           .colours = GLB_NONE,
                           .indices = glb_add_data(writer, GLB_INDICES16, indices, 9, NULL, NULL),
                           .material = materials[half],
                           .blob = GLB_NONE};
    glb_node node = {.mesh = glb_add_mesh(writer, &mesh),
                     .translations = GLB_NONE,
                     .instance_colours = GLB_NONE,
                     .rotations = GLB_NONE,
                     .scales = GLB_NONE};
    const uint32_t row = glb_add_node(writer, &node);
    if (half == 0) root.first_child = row;
  }
  glb_add_node(writer, &root);
  return glb_finish(writer, NULL, &error) == SCREE_OK;
}

#endif
