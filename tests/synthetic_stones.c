#include "synthetic_stones.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lattice.h"

#define LEVELS 4
/* Subdivided octahedron: side 2^k, 4 side^2 + 2 vertices, 8 side^2 triangles. */
static const uint32_t sides[LEVELS] = {20, 12, 7, 4};

static float random_unit(uint64_t* state) {
  *state += UINT64_C(0x9e3779b97f4a7c15);
  return (float)(hash_mix(*state) >> 40) * (1.0f / 16777216.0f);
}

static void random_direction(uint64_t* state, float out[3]) {
  float length;
  do {
    for (int a = 0; a < 3; ++a) out[a] = 2 * random_unit(state) - 1;
    length = sqrtf(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
  } while (length > 1 || length < 0.1f);
  for (int a = 0; a < 3; ++a) out[a] /= length;
}

/* Distance from the middle to the surface along a unit direction, cells. */
static float radius_along(uint32_t asset, const float direction[3]) {
  uint64_t state = asset + 1;
  const float stretch[3] = {0.75f + 0.5f * random_unit(&state), 0.6f + 0.4f * random_unit(&state),
                            0.75f + 0.5f * random_unit(&state)};
  float d[3], norm = 0;
  for (int a = 0; a < 3; ++a) {
    d[a] = direction[a] / stretch[a];
    norm += d[a] * d[a];
  }
  float radius = 0.56f / sqrtf(norm);
  for (int i = 0; i < 6; ++i) {
    float axis[3], phase = 6 * random_unit(&state), wave = 2 + 4 * random_unit(&state);
    random_direction(&state, axis);
    float t = axis[0] * direction[0] + axis[1] * direction[1] + axis[2] * direction[2];
    radius += 0.018f * sinf(wave * t * 2 + phase);
  }
  for (int i = 0; i < 9; ++i) {
    float axis[3], depth = 0.36f + 0.16f * random_unit(&state);
    random_direction(&state, axis);
    float t = axis[0] * direction[0] + axis[1] * direction[1] + axis[2] * direction[2];
    if (t > 0.05f && radius * t > depth) radius += 0.92f * (depth / t - radius);
  }
  return radius;
}

static bool decode(void* user, uint32_t asset, uint32_t lod, scree_vertex* vertices, uint16_t* indices) {
  (void)user;
  const int side = (int)sides[lod];
  /* Each face of the octahedron is a grid of its own; vertices on shared edges are doubled, which no pass minds. */
  uint32_t count = 0, index = 0;
  for (int face = 0; face < 8; ++face) {
    const float sign[3] = {face & 1 ? -1.0f : 1.0f, face & 2 ? -1.0f : 1.0f, face & 4 ? -1.0f : 1.0f};
    const bool flipped = (sign[0] * sign[1] * sign[2]) < 0;
    uint32_t first = count;
    for (int row = 0; row <= side; ++row)
      for (int column = 0; column <= side - row; ++column) {
        float p[3] = {(float)row / (float)side, (float)column / (float)side, (float)(side - row - column) / (float)side};
        float direction[3], length = sqrtf(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]), place[3], normal[3];
        for (int a = 0; a < 3; ++a) direction[a] = sign[a] * p[a] / length;
        float radius = radius_along(asset, direction);
        for (int a = 0; a < 3; ++a) place[a] = radius * direction[a];
        /* Normal: from two steps across the direction. */
        float u[3] = {-direction[1], direction[0], 0}, v[3];
        if (u[0] * u[0] + u[1] * u[1] < 0.01f) memcpy(u, (float[3]){0, -direction[2], direction[1]}, sizeof u);
        float ul = sqrtf(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        for (int a = 0; a < 3; ++a) u[a] /= ul;
        v[0] = direction[1] * u[2] - direction[2] * u[1];
        v[1] = direction[2] * u[0] - direction[0] * u[2];
        v[2] = direction[0] * u[1] - direction[1] * u[0];
        const float step = 0.03f;
        float q[2][3];
        for (int k = 0; k < 2; ++k) {
          const float* w = k == 0 ? u : v;
          float e[3], el = sqrtf(1 + step * step);
          for (int a = 0; a < 3; ++a) e[a] = (direction[a] + step * w[a]) / el;
          float er = radius_along(asset, e);
          for (int a = 0; a < 3; ++a) q[k][a] = er * e[a] - place[a];
        }
        normal[0] = q[0][1] * q[1][2] - q[0][2] * q[1][1];
        normal[1] = q[0][2] * q[1][0] - q[0][0] * q[1][2];
        normal[2] = q[0][0] * q[1][1] - q[0][1] * q[1][0];
        float nl = sqrtf(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
        scree_vertex* out = &vertices[count++];
        memset(out, 0, sizeof *out);
        for (int a = 0; a < 3; ++a) {
          out->position[a] = (int16_t)lrintf(place[a] * SYNTHETIC_LATTICE);
          out->normal[a] = (int16_t)lrintf(normal[a] / nl * 32767);
        }
        out->occlusion = 255;
      }
    uint32_t start = first;
    for (int row = 0; row < side; ++row) {
      uint32_t next = start + (uint32_t)(side - row + 1);
      for (int column = 0; column < side - row; ++column) {
        uint32_t a = start + (uint32_t)column, b = next + (uint32_t)column, c = a + 1, d = b + 1;
        const uint32_t triangles[6] = {a, b, c, c, b, d};
        for (int k = 0; k < (column + 1 < side - row ? 6 : 3); k += 3) {
          indices[index++] = (uint16_t)triangles[k];
          indices[index++] = (uint16_t)triangles[flipped ? k + 2 : k + 1];
          indices[index++] = (uint16_t)triangles[flipped ? k + 1 : k + 2];
        }
      }
      start = next;
    }
  }
  return true;
}

bool synthetic_source(uint32_t count, render_source* out) {
  render_asset* assets = calloc(count, sizeof *assets);
  if (assets == NULL) return false;
  for (uint32_t i = 0; i < count; ++i) {
    assets[i].radius = 0.8f;
    for (uint32_t lod = 0; lod < LEVELS; ++lod) {
      uint32_t side = sides[lod];
      assets[i].vertices[lod] = 8 * (side + 1) * (side + 2) / 2;
      assets[i].triangles[lod] = 8 * side * side;
      assets[i].errors[lod] = lod == 0 ? 0 : 1.2f / (float)(side * side);
    }
  }
  *out = (render_source){
      .asset_count = count, .lod_count = LEVELS, .lattice_per_cell = SYNTHETIC_LATTICE, .assets = assets, .decode = decode};
  return true;
}

uint32_t synthetic_heap(uint32_t assets, float radius, float cell_size, render_stone** out) {
  const int reach = (int)(radius / cell_size) + 2;
  uint32_t count = 0, capacity = (uint32_t)(2 * reach + 1) * (uint32_t)(2 * reach + 1) * (uint32_t)(reach + 2);
  render_stone* stones = calloc(capacity, sizeof *stones);
  *out = stones;
  if (stones == NULL) return 0;
  uint64_t state = 77;
  for (int y = 0; y < reach; ++y)
    for (int z = -reach; z <= reach; ++z)
      for (int x = -reach; x <= reach; ++x) {
        float p[3] = {(float)x, (float)y + 0.35f, (float)z};
        for (int a = 0; a < 3; ++a) p[a] = (p[a] + (a == 1 && y == 0 ? 0.0f : 0.45f * (random_unit(&state) - 0.5f))) * cell_size;
        float away = sqrtf(p[0] * p[0] + 1.7f * p[1] * p[1] + p[2] * p[2]);
        uint32_t asset = (uint32_t)(random_unit(&state) * (float)assets), hash = (uint32_t)hash_mix(state);
        if (away > radius || away < radius - 3.0f * cell_size) continue;
        stones[count] = (render_stone){.cell_size = cell_size, .hash = hash, .asset = asset % assets};
        static const uint8_t colours[4][3] = {{178, 172, 160}, {158, 155, 150}, {172, 158, 138}, {140, 138, 136}};
        memcpy(stones[count].colour, colours[hash >> 30], 3);
        stones[count].tile = (uint8_t)(hash_combine((uint64_t)(x >> 2) << 32 | (uint32_t)(z >> 2), (uint64_t)(y >> 2)) & 255);
        memcpy(stones[count++].position, p, sizeof p);
      }
  return count;
}
