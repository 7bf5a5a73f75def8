#include "make_hill.h"

#include <math.h>

#include "make_solids.h"

static scree_shards* split(const scree_solid* solid, const scree_seed_pattern* pattern, scree_error* error) {
  double* seeds;
  uint32_t count;
  if (scree_seeds_create(pattern, solid, NULL, &seeds, &count, error) != SCREE_OK) return NULL;
  scree_shards* shards = NULL;
  const scree_shards_desc desc = {.solid = *solid, .seeds = seeds, .seed_count = count};
  const scree_result result = scree_shards_create(&desc, &shards, error);
  scree_seeds_free(NULL, seeds, count);
  return result == SCREE_OK ? shards : NULL;
}

scree_shards* make_hill(uint32_t cells, double size, uint64_t random_seed, scree_error* error) {
  enum { SIDES = 24, RINGS = 4 };
  static const double radius[RINGS] = {0.5, 0.4, 0.25, 0.1}, height[RINGS] = {0, 0.175, 0.35, 0.45};
  double positions[3 * SIDES * RINGS];
  uint32_t indices[3 * (2 * SIDES * (RINGS - 1) + 2 * (SIDES - 2))], at = 0;
  double around[SIDES][2] = {{1, 0}};
  const double c = 0.96592582628906829, s = 0.25881904510252076; /* of 15 degrees: no sine of libm, which differs */
  for (int i = 1; i < SIDES; ++i) {
    around[i][0] = c * around[i - 1][0] - s * around[i - 1][1];
    around[i][1] = s * around[i - 1][0] + c * around[i - 1][1];
  }
  for (uint32_t ring = 0; ring < RINGS; ++ring)
    for (uint32_t i = 0; i < SIDES; ++i) {
      double* p = positions + 3 * (size_t)(ring * SIDES + i);
      p[0] = size * radius[ring] * around[i][0];
      p[1] = size * height[ring];
      p[2] = size * radius[ring] * around[i][1];
    }
  for (uint32_t ring = 0; ring + 1 < RINGS; ++ring)
    for (uint32_t i = 0; i < SIDES; ++i) {
      const uint32_t a = ring * SIDES + i, b = ring * SIDES + (i + 1) % SIDES;
      const uint32_t quad[6] = {a, b + SIDES, b, a, a + SIDES, b + SIDES};
      for (int k = 0; k < 6; ++k) indices[at++] = quad[k];
    }
  for (uint32_t i = 1; i + 1 < SIDES; ++i) {
    const uint32_t top = SIDES * (RINGS - 1), fans[6] = {0, i, i + 1, top, top + i + 1, top + i};
    for (int k = 0; k < 6; ++k) indices[at++] = fans[k];
  }
  const scree_solid solid = {positions, indices, NULL, SIDES * RINGS, at / 3};
  return split(&solid, &(scree_seed_pattern){.kind = SCREE_SEEDS_RANDOM, .count = cells, .random_seed = random_seed}, error);
}

scree_shards* make_ring(uint32_t cells, double size, uint64_t random_seed, scree_error* error) {
  solid_mesh mesh = solid_torus(size * 0.35, size * 0.15, 24, 12);
  const scree_solid solid = {mesh.positions, mesh.indices, NULL, mesh.vertex_count, mesh.triangle_count};
  scree_shards* shards =
      split(&solid, &(scree_seed_pattern){.kind = SCREE_SEEDS_RANDOM, .count = cells, .random_seed = random_seed}, error);
  solid_mesh_free(&mesh);
  return shards;
}

scree_shards* make_columns(uint32_t across, uint32_t deep, double height, uint64_t random_seed, scree_error* error) {
  const double max[3] = {across / 2.0, height, deep * sqrt(3) / 4};
  double positions[24];
  for (int i = 0; i < 8; ++i) {
    positions[3 * i] = (i & 1) != 0 ? max[0] : -max[0];
    positions[3 * i + 1] = (i & 2) != 0 ? max[1] : 0;
    positions[3 * i + 2] = (i & 4) != 0 ? max[2] : -max[2];
  }
  static const uint32_t indices[36] = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                       2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
  const scree_solid solid = {positions, indices, NULL, 8, 12};
  const scree_seed_pattern pattern = {.kind = SCREE_SEEDS_COLUMNS, .spacing = 1, .jitter = 0.15, .random_seed = random_seed};
  return split(&solid, &pattern, error);
}
