#include "mesh_digest.h"

#include <scree/draco.h>
#include <string.h>

#include "pack_format.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

typedef struct vertex_keys {
  const char* positions;
  size_t position_stride;
  const uint8_t* occlusion;
  size_t occlusion_stride;
} vertex_keys;

static uint64_t vertex_key(const vertex_keys* keys, uint32_t index) {
  uint16_t p[3];
  memcpy(p, keys->positions + index * keys->position_stride, sizeof p);
  return (uint64_t)p[0] | (uint64_t)p[1] << 16 | (uint64_t)p[2] << 32 |
         (uint64_t)keys->occlusion[index * keys->occlusion_stride] << 48;
}

static bool less(const uint64_t a[3], const uint64_t b[3]) {
  for (int i = 0; i < 3; ++i)
    if (a[i] != b[i]) return a[i] < b[i];
  return false;
}

uint64_t scree_rt_mesh_digest(const void* positions, size_t position_stride, const uint8_t* occlusion, size_t occlusion_stride,
                              const uint32_t* indices, size_t triangle_count) {
  const vertex_keys keys = {positions, position_stride, occlusion, occlusion_stride};
  uint64_t total[2] = {0, triangle_count};
  for (size_t triangle = 0; triangle < triangle_count; ++triangle) {
    const uint32_t* corner = indices + 3 * triangle;
    const uint64_t a = vertex_key(&keys, corner[0]), b = vertex_key(&keys, corner[1]), c = vertex_key(&keys, corner[2]);
    const uint64_t rotations[3][3] = {{a, b, c}, {b, c, a}, {c, a, b}};
    const uint64_t* least = rotations[0];
    if (less(rotations[1], least)) least = rotations[1];
    if (less(rotations[2], least)) least = rotations[2];
    total[0] += XXH3_64bits(least, 3 * sizeof *least);
  }
  return XXH3_64bits(total, sizeof total);
}

uint64_t scree_mesh_digest(const scree_vertex* vertices, size_t vertex_count, const uint32_t* indices, size_t triangle_count) {
  for (size_t i = 0; i < 3 * triangle_count; ++i)
    if (indices[i] >= vertex_count) return 0;
  if (triangle_count == 0) return scree_rt_mesh_digest(NULL, 0, NULL, 0, NULL, 0);
  return scree_rt_mesh_digest(&vertices->position, sizeof *vertices, &vertices->occlusion, sizeof *vertices, indices,
                              triangle_count);
}
