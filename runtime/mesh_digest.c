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
  const uint8_t (*surface)[4]; /* NULL for rocks */
  const uint16_t (*uvs)[2];    /* NULL but for cliffs */
} vertex_keys;

enum { MOST_WORDS = 2 };

static void vertex_key(const vertex_keys* keys, uint32_t index, uint64_t* key) {
  uint16_t p[3];
  memcpy(p, keys->positions + index * keys->position_stride, sizeof p);
  key[0] = (uint64_t)p[0] | (uint64_t)p[1] << 16 | (uint64_t)p[2] << 32 |
           (uint64_t)keys->occlusion[index * keys->occlusion_stride] << 48;
  if (keys->surface == NULL) return;
  const uint8_t* s = keys->surface[index];
  key[1] = (uint64_t)s[0] | (uint64_t)s[1] << 8 | (uint64_t)(s[2] ^ 0x80u) << 16; /* + 128 to two's complement */
  if (keys->uvs != NULL) key[1] |= (uint64_t)s[3] << 24 | (uint64_t)keys->uvs[index][0] << 32 | (uint64_t)keys->uvs[index][1] << 48;
}

static bool less(const uint64_t* a, const uint64_t* b, size_t words) {
  for (size_t i = 0; i < words; ++i)
    if (a[i] != b[i]) return a[i] < b[i];
  return false;
}

static uint64_t triangle_digest(const vertex_keys* keys, const uint32_t corner[3]) {
  const size_t words = keys->surface != NULL ? 2 : 1;
  uint64_t twice[6 * MOST_WORDS]; /* a b c a b c: each rotation is three keys one behind the other */
  for (size_t k = 0; k < 3; ++k) vertex_key(keys, corner[k], twice + k * words);
  memcpy(twice + 3 * words, twice, 3 * words * sizeof *twice);
  const uint64_t* least = twice;
  for (size_t k = 1; k < 3; ++k)
    if (less(twice + k * words, least, 3 * words)) least = twice + k * words;
  return XXH3_64bits(least, 3 * words * sizeof *least);
}

static uint64_t mesh_digest(const vertex_keys* keys, const uint32_t* indices, size_t triangle_count) {
  uint64_t total[2] = {0, triangle_count};
  for (size_t triangle = 0; triangle < triangle_count; ++triangle) total[0] += triangle_digest(keys, indices + 3 * triangle);
  return XXH3_64bits(total, sizeof total);
}

uint64_t scree_rt_mesh_digest(const void* positions, size_t position_stride, const uint8_t* occlusion, size_t occlusion_stride,
                              const uint32_t* indices, size_t triangle_count) {
  return mesh_digest(&(vertex_keys){positions, position_stride, occlusion, occlusion_stride, NULL, NULL}, indices, triangle_count);
}

uint64_t scree_rt_model_digest(const void* positions, size_t position_stride, const uint8_t* occlusion, const uint8_t (*surface)[4],
                               const uint16_t (*uvs)[2], const uint32_t* indices, size_t triangle_count) {
  return mesh_digest(&(vertex_keys){positions, position_stride, occlusion, 1, surface, uvs}, indices, triangle_count);
}

static bool indices_fit(const uint32_t* indices, size_t triangle_count, size_t vertex_count) {
  for (size_t i = 0; i < 3 * triangle_count; ++i)
    if (indices[i] >= vertex_count) return false;
  return true;
}

uint64_t scree_mesh_digest(const scree_vertex* vertices, size_t vertex_count, const uint32_t* indices, size_t triangle_count) {
  if (!indices_fit(indices, triangle_count, vertex_count)) return 0;
  if (triangle_count == 0) return scree_rt_mesh_digest(NULL, 0, NULL, 0, NULL, 0);
  return scree_rt_mesh_digest(&vertices->position, sizeof *vertices, &vertices->occlusion, sizeof *vertices, indices,
                              triangle_count);
}

/* uvs, groups: NULL but for cliffs. */
static uint64_t surface_digest(const scree_vertex* vertices, const scree_uv* uvs, const uint8_t* groups, size_t vertex_count,
                               const uint32_t* indices, size_t triangle_count) {
  if (!indices_fit(indices, triangle_count, vertex_count)) return 0;
  /* The bytes of a vertex do not lie together as those of a blob do, and there is no memory to gather them all in: one triangle at
   * a time. */
  uint64_t total[2] = {0, triangle_count};
  for (size_t triangle = 0; triangle < triangle_count; ++triangle) {
    int16_t positions[3][3];
    uint8_t occlusion[3], surface[3][4];
    uint16_t places[3][2] = {{0}};
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t index = indices[3 * triangle + k];
      const scree_vertex* v = &vertices[index];
      memcpy(positions[k], v->position, sizeof positions[k]);
      occlusion[k] = v->occlusion;
      const uint8_t bytes[4] = {v->material, v->durability, (uint8_t)(v->curvature + 128), groups != NULL ? groups[index] : 0};
      memcpy(surface[k], bytes, sizeof bytes);
      if (uvs == NULL) continue;
      places[k][0] = uvs[index].u;
      places[k][1] = uvs[index].v;
    }
    const vertex_keys keys = {(const char*)positions,       sizeof *positions,           occlusion, 1,
                              (const uint8_t(*)[4])surface, (const uint16_t(*)[2])places};
    total[0] += triangle_digest(&keys, (const uint32_t[3]){0, 1, 2});
  }
  return XXH3_64bits(total, sizeof total);
}

uint64_t scree_model_mesh_digest(const scree_vertex* vertices, size_t vertex_count, const uint32_t* indices,
                                 size_t triangle_count) {
  return surface_digest(vertices, NULL, NULL, vertex_count, indices, triangle_count);
}

uint64_t scree_cliff_mesh_digest(const scree_vertex* vertices, const scree_uv* uvs, const uint8_t* groups, size_t vertex_count,
                                 const uint32_t* indices, size_t triangle_count) {
  return surface_digest(vertices, uvs, groups, vertex_count, indices, triangle_count);
}
