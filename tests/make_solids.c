#include "make_solids.h"

#include <math.h>
#include <scree/weather.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void* must(size_t count, size_t size) {
  void* memory = calloc(count + 1, size);
  if (memory == NULL) abort();
  return memory;
}

static bool filled(const char* map, const int64_t size[3], int64_t x, int64_t y, int64_t z) {
  if (x < 0 || y < 0 || z < 0 || x >= size[0] || y >= size[1] || z >= size[2]) return false;
  return map[(y * size[2] + z) * size[0] + x] != ' ';
}

solid_mesh solid_from_voxels(const char* map, uint32_t width, uint32_t depth, uint32_t height) {
  static const int corners[6][4][3] = {{{0, 0, 0}, {0, 0, 1}, {0, 1, 1}, {0, 1, 0}}, {{1, 0, 0}, {1, 1, 0}, {1, 1, 1}, {1, 0, 1}},
                                       {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}}, {{0, 1, 0}, {0, 1, 1}, {1, 1, 1}, {1, 1, 0}},
                                       {{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}}, {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}};
  const int64_t size[3] = {width, height, depth};
  const size_t voxels = (size_t)width * depth * height, places = (size_t)(width + 1) * (depth + 1) * (height + 1);
  solid_mesh mesh = {must(places, 3 * sizeof(double)), must(voxels * 12, 3 * sizeof(uint32_t)), 0, 0};
  uint32_t* vertex_of = must(places, sizeof *vertex_of);
  for (int64_t y = 0; y < size[1]; ++y)
    for (int64_t z = 0; z < size[2]; ++z)
      for (int64_t x = 0; x < size[0]; ++x)
        for (int side = 0; filled(map, size, x, y, z) && side < 6; ++side) {
          const int axis = side / 2, step = side % 2 ? 1 : -1;
          if (filled(map, size, x + (axis == 0 ? step : 0), y + (axis == 1 ? step : 0), z + (axis == 2 ? step : 0))) continue;
          uint32_t v[4];
          for (int c = 0; c < 4; ++c) {
            const int64_t at[3] = {x + corners[side][c][0], y + corners[side][c][1], z + corners[side][c][2]};
            uint32_t* known = &vertex_of[(at[1] * (size[2] + 1) + at[2]) * (size[0] + 1) + at[0]];
            if (*known == 0) {
              for (int a = 0; a < 3; ++a) mesh.positions[3 * (size_t)mesh.vertex_count + (size_t)a] = (double)at[a];
              *known = ++mesh.vertex_count;
            }
            v[c] = *known - 1;
          }
          const uint32_t two[6] = {v[0], v[1], v[2], v[0], v[2], v[3]};
          memcpy(&mesh.indices[3 * (size_t)mesh.triangle_count], two, sizeof two);
          mesh.triangle_count += 2;
        }
  free(vertex_of);
  return mesh;
}

solid_mesh solid_torus(double major, double minor, uint32_t around, uint32_t across) {
  const uint32_t count = around * across;
  solid_mesh mesh = {must(count, 3 * sizeof(double)), must(2 * (size_t)count, 3 * sizeof(uint32_t)), count, 2 * count};
  for (uint32_t i = 0; i < around; ++i)
    for (uint32_t k = 0; k < across; ++k) {
      const double turn = 6.283185307179586, a = turn * i / around, b = turn * k / across, r = major + minor * cos(b);
      double* at = mesh.positions + 3 * ((size_t)i * across + k);
      at[0] = r * cos(a), at[1] = minor * sin(b), at[2] = r * sin(a);
      const uint32_t i1 = (i + 1) % around, k1 = (k + 1) % across;
      const uint32_t v[4] = {i * across + k, i * across + k1, i1 * across + k1, i1 * across + k};
      const uint32_t two[6] = {v[0], v[1], v[2], v[0], v[2], v[3]};
      memcpy(&mesh.indices[6 * ((size_t)i * across + k)], two, sizeof two);
    }
  return mesh;
}

solid_mesh solid_goblin(uint32_t size, uint32_t steps) {
  scree_weather_rules rules;
  scree_weather_rules_default(&rules);
  const scree_durability_point durability = {0, 1, 0.6, size / 4.0, 0.6};
  rules.durability = &durability;
  rules.durability_count = 1;
  const scree_weather_desc desc = {.start = {.kind = SCREE_START_BOX, .size = {size, size, size}, .seed = 7}, .rules = rules};
  scree_weather* weather;
  scree_mesher* mesher;
  scree_surface surface;
  if (scree_weather_create(&desc, &weather, NULL) != SCREE_OK || scree_weather_step(weather, steps) != SCREE_OK ||
      scree_mesher_create(weather, &mesher) != SCREE_OK || scree_mesher_update(mesher, 0, &surface) != SCREE_OK)
    abort();
  const uint32_t triangles = surface.rock_triangles + surface.colluvium_triangles;
  solid_mesh mesh = {must(surface.vertex_count, 3 * sizeof(double)), must(triangles, 3 * sizeof(uint32_t)), surface.vertex_count,
                     triangles};
  for (uint32_t v = 0; v < surface.vertex_count; ++v)
    for (int a = 0; a < 3; ++a) mesh.positions[3 * (size_t)v + (size_t)a] = (double)surface.vertices[v].position[a];
  memcpy(mesh.indices, surface.indices, (size_t)triangles * 3 * sizeof(uint32_t));
  scree_mesher_destroy(mesher);
  scree_weather_destroy(weather);
  return mesh;
}

bool solid_read_off(const char* file, solid_mesh* out) {
  FILE* in = fopen(file, "r");
  if (in == NULL) return false;
  unsigned vertices, triangles, edges;
  if (fscanf(in, "OFF %u %u %u", &vertices, &triangles, &edges) != 3) abort();
  *out = (solid_mesh){must(vertices, 3 * sizeof(double)), must(triangles, 3 * sizeof(uint32_t)), vertices, triangles};
  for (size_t k = 0; k < 3 * (size_t)vertices; ++k)
    if (fscanf(in, "%lf", &out->positions[k]) != 1) abort();
  for (size_t t = 0; t < triangles; ++t) {
    uint32_t* v = &out->indices[3 * t];
    unsigned corners, a, b, c;
    if (fscanf(in, "%u %u %u %u", &corners, &a, &b, &c) != 4 || corners != 3) abort();
    v[0] = a, v[1] = b, v[2] = c;
  }
  fclose(in);
  return true;
}

void solid_add(solid_mesh* to, const solid_mesh* more, const double move[3], double scale) {
  const solid_mesh both = {must((size_t)to->vertex_count + more->vertex_count, 3 * sizeof(double)),
                           must((size_t)to->triangle_count + more->triangle_count, 3 * sizeof(uint32_t)),
                           to->vertex_count + more->vertex_count, to->triangle_count + more->triangle_count};
  if (to->triangle_count > 0) memcpy(both.positions, to->positions, (size_t)to->vertex_count * 3 * sizeof(double));
  if (to->triangle_count > 0) memcpy(both.indices, to->indices, (size_t)to->triangle_count * 3 * sizeof(uint32_t));
  for (size_t k = 0; k < 3 * (size_t)more->vertex_count; ++k)
    both.positions[3 * (size_t)to->vertex_count + k] = move[k % 3] + scale * more->positions[k];
  for (size_t k = 0; k < 3 * (size_t)more->triangle_count; ++k) {
    /* Mirrored in a point, a mesh is inside out: turned round it is a hollow, so that scale < 0 makes one. */
    both.indices[3 * (size_t)to->triangle_count + k] = to->vertex_count + more->indices[k];
  }
  solid_mesh_free(to);
  *to = both;
}

void solid_mesh_free(solid_mesh* mesh) {
  free(mesh->positions);
  free(mesh->indices);
  *mesh = (solid_mesh){0};
}
