/* Prints the digests that must be the same on every compiler, optimisation level and CPU, one `name value` a line. Only our own C
 * is linked, so that it cross-compiles with nothing but a compiler; content/golden/small.txt holds what it must print. */
#include <inttypes.h>
#include <scree/shard_recipe.h>
#include <stdio.h>
#include <string.h>

#include "digest_edits.h"
#include "digest_frost.h"
#include "digest_queries.h"
#include "digest_scatter.h"
#include "digest_surface.h"
#include "lattice.h"

/* Every cell of every tile, and the colours of a block of corners round the origin and at the ends of the int32 lattice. */
static uint64_t digest_lattice(void) {
  uint64_t digest = 0;
  for (uint32_t n = 3; n <= 6; ++n)
    for (uint32_t code = 0; code < 256; ++code)
      for (uint32_t z = 0; z < n; ++z)
        for (uint32_t y = 0; y < n; ++y)
          for (uint32_t x = 0; x < n; ++x) digest = hash_combine(digest, scree_rt_lattice_cell(n, code, x, y, z));
  const int32_t starts[3] = {-8, INT32_MIN, INT32_MAX - 17};
  for (int i = 0; i < 3; ++i)
    for (int32_t z = 0; z < 16; ++z)
      for (int32_t y = 0; y < 16; ++y)
        for (int32_t x = 0; x < 16; ++x)
          digest = hash_combine(digest, cube_code(2009, starts[i] + x, starts[i] + y, starts[i] + z));
  return digest;
}

/* The recipe of content/golden/small.json, which scree-bake is given by another test: every stage runs, on few voxels. */
static scree_result digest_pack(uint64_t* digest) {
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  recipe.n = 4;
  recipe.voxels_per_cell = 6;
  recipe.lod_levels = 3;
  recipe.seeds_max = 2;
  recipe.gamma = (scree_range){2, 3};
  recipe.contact_discard = 0.1;
  scree_bake_report report = {0};
  uint8_t* bytes = NULL;
  size_t size = 0;
  const scree_bake_desc desc = {.recipe = &recipe};
  const scree_result result = scree_bake_rocks(&desc, &bytes, &size, &report, NULL);
  scree_bake_free(&desc, bytes, size);
  *digest = report.digest;
  return result;
}

/* The recipe of content/golden/small_hoodoo.json: every part of weathering, on few voxels. */
static scree_result digest_hoodoo(uint64_t* digest) {
  static scree_hoodoo_recipe recipe;
  scree_hoodoo_default(&recipe);
  recipe.size[0] = recipe.size[2] = 44;
  recipe.size[1] = 36;
  recipe.start.radius = 13;
  recipe.rules.bubbles[0] = (scree_bubble_segment){
      .bubbles = {{SCREE_BUBBLE_SPHERE, 3, 4}, {SCREE_BUBBLE_GUMDROP, 4, 4}}, .bubble_count = 2, .noise_period = 16};
  recipe.rules.cavernous = (scree_curve){SCREE_CURVE_SATURATING, 0.2, 0.05, 0.2, 2};
  recipe.phases[0] = (scree_hoodoo_phase){.share = 0.7, .changes = SCREE_HOODOO_SPHEROIDAL | SCREE_HOODOO_ROCKFALL};
  recipe.phases[0].rules.spheroidal = (scree_curve){SCREE_CURVE_QUARTIC, 1, 0, 1, 1};
  recipe.phases[0].rules.rockfall = SCREE_ROCKFALL_DROP;
  recipe.phase_count = 1;
  recipe.variants = 2;
  recipe.age_count = 2;
  recipe.lod_levels = 3;
  scree_bake_report report = {0};
  uint8_t* bytes = NULL;
  size_t size = 0;
  const scree_hoodoo_desc desc = {.recipe = &recipe};
  const scree_result result = scree_hoodoo_bake(&desc, &bytes, &size, &report, NULL);
  scree_hoodoo_free(&desc, bytes, size);
  *digest = report.digest;
  return result;
}

/* The recipe of content/golden/small_shards.json: seeds, cutting, frost, stability, rubble and assets, on few shards. */
static scree_result digest_cliff(uint64_t* digest) {
  static scree_shard_recipe recipe;
  scree_shard_recipe_default(&recipe);
  strcpy(recipe.name, "small shards");
  recipe.input.radius = 4;
  recipe.input.height = 5;
  recipe.input.sides = 7;
  recipe.input.rings = 2;
  recipe.seeds.kind = SCREE_SEEDS_GRID;
  recipe.seeds.count = 120;
  recipe.seeds.jitter = 0.7;
  recipe.seeds.up[0] = 0.2;
  recipe.seeds.up[2] = 0.1;
  scree_shard_rules* rules = &recipe.rules;
  rules->frost.rains[0] = (scree_rain){{0.3, -1, 0.1}, 0.5, 1};
  rules->frost.rains[1] = (scree_rain){{1, 0, 0}, 0.1, 0.5};
  rules->frost.rain_count = 2;
  rules->frost.resistance.kind = SCREE_RESISTANCE_LAYERS;
  rules->frost.resistance.amplitude = 0.2;
  rules->frost.resistance.period = 2;
  rules->frost.resistance.layer_count = 2;
  rules->layers[0][1] = 0.7;
  rules->layers[1][0] = 3;
  rules->layers[1][1] = 0.3;
  rules->frost.resistance_absorption = 0.05;
  rules->frost.damage = 6;
  rules->frost.strength = 300000;
  rules->frost.stability_interval = 8;
  recipe.states[0] = (scree_shard_region){.where = SCREE_SHARD_AT_BASE, .state = SCREE_SHARD_CORE};
  recipe.state_count = 1;
  recipe.phases[0] = (scree_shard_phase){.share = -1, .paths = 400, .changes = SCREE_SHARD_DAMAGE | SCREE_SHARD_FALL_LIFE};
  recipe.phases[0].rules.frost.damage = 9;
  recipe.phases[0].rules.frost.fall_life = 0.3;
  recipe.phase_count = 1;
  recipe.path_count = 3;
  recipe.paths[0] = 0;
  recipe.paths[1] = 300;
  recipe.paths[2] = 900;
  recipe.lod_levels = 2;
  scree_shard_report report = {0};
  uint8_t* bytes = NULL;
  size_t size = 0;
  const scree_shard_desc desc = {.recipe = &recipe};
  const scree_result result = scree_shards_bake(&desc, &bytes, &size, &report, NULL);
  scree_shards_bake_free(&desc, bytes, size);
  *digest = report.bake.digest;
  return result;
}

int main(void) {
  printf("lattice %016" PRIx64 "\n", digest_lattice());
  uint64_t pack, hoodoo = 0, cliff = 0;
  scree_result result = digest_pack(&pack);
  if (result == SCREE_OK) result = digest_hoodoo(&hoodoo);
  if (result == SCREE_OK) result = digest_cliff(&cliff);
  if (result != SCREE_OK) {
    fprintf(stderr, "digest_small: %s\n", scree_result_string(result));
    return 1;
  }
  printf("pack %016" PRIx64 "\n", pack);
  printf("hoodoo %016" PRIx64 "\n", hoodoo);
  printf("cliff %016" PRIx64 "\n", cliff);
  printf("queries %016" PRIx64 "\n", digest_queries());
  printf("edits %016" PRIx64 "\n", digest_edits());
  printf("convex %016" PRIx64 "\n", digest_convex());
  printf("spatial %016" PRIx64 "\n", digest_spatial());
  printf("scatter %016" PRIx64 "\n", digest_scatter());
  printf("surface %016" PRIx64 "\n", digest_surface());
  printf("shards %016" PRIx64 "\n", digest_shards());
  printf("frost %016" PRIx64 "\n", digest_frost());
  return 0;
}
