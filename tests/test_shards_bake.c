/* Shards from recipe to pack: what is baked is what the recipe says, whoever bakes it, and what cannot be baked is said. */
#include <scree/draco.h>
#include <scree/shard_recipe.h>
#include <scree/threads.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "failing_allocator.h"

/* A hill of few shards that wears fast. */
static void small(scree_shard_recipe* recipe) {
  scree_shard_recipe_default(recipe);
  recipe->input.radius = 4;
  recipe->input.height = 5;
  recipe->input.sides = 7;
  recipe->input.rings = 2;
  recipe->seeds.count = 80;
  recipe->rules.frost.rains[0] = (scree_rain){{0.6, -1, 0}, 1.2, 1};
  recipe->rules.frost.resistance_absorption = 0.05;
  recipe->rules.frost.damage = 8;
  recipe->states[0] = (scree_shard_region){.where = SCREE_SHARD_AT_BASE, .state = SCREE_SHARD_CORE};
  recipe->state_count = 1;
  recipe->path_count = 3;
  recipe->paths[0] = 0;
  recipe->paths[1] = 500;
  recipe->paths[2] = 1500;
  recipe->lod_levels = 2;
}

typedef struct baked {
  uint8_t* bytes;
  size_t size;
  scree_pack* pack;
  scree_shard_report report;
} baked;

static baked bake_with(const scree_shard_desc* desc) {
  baked out = {0};
  scree_error error;
  const scree_result result = scree_shards_bake(desc, &out.bytes, &out.size, &out.report, &error);
  if (result != SCREE_OK) fail_msg("%s: %s", scree_result_string(result), error.message);
  assert_int_equal(scree_pack_open_memory(out.bytes, out.size, NULL, &out.pack), SCREE_OK);
  assert_int_equal(scree_pack_verify(out.pack), SCREE_OK);
  return out;
}

static baked bake(const scree_shard_recipe* recipe) {
  return bake_with(&(scree_shard_desc){.recipe = recipe});
}

static void unbake(baked* it) {
  scree_pack_close(it->pack);
  scree_shards_bake_free(&(scree_shard_desc){0}, it->bytes, it->size);
}

static scree_result refused(const scree_shard_desc* desc, scree_error* error) {
  uint8_t* bytes;
  size_t size;
  const scree_result result = scree_shards_bake(desc, &bytes, &size, NULL, error);
  assert_null(bytes);
  assert_int_equal(size, 0);
  return result;
}

static void a_pack_holds_times_and_blocks_as_the_recipe_says(void** state) {
  (void)state;
  static scree_shard_recipe recipe, again;
  small(&recipe);
  baked it = bake(&recipe);
  scree_pack_info info;
  scree_pack_get_info(it.pack, &info);
  assert_int_equal(info.kind, SCREE_PACK_CLIFF);
  assert_int_equal(info.time_count, 3);
  assert_int_equal(info.lod_count, 2);
  assert_int_equal(info.asset_count, it.report.bake.rocks);
  assert_int_equal(info.asset_count, 3 + it.report.blocks);
  assert_int_equal(info.variant_count, 1 + it.report.blocks);
  assert_int_equal(info.placement_count, it.report.placements);
  assert_true(it.report.shards == 80 && it.report.blocks > 3 && it.report.paths == 1500 && it.report.breaks > 50);
  assert_true(it.report.bake.digest == info.digest && it.report.bake.bytes == it.size);
  assert_int_equal(scree_shard_recipe_parse(info.recipe, info.recipe_size, &again, NULL), SCREE_OK);
  uint32_t placed = 0;
  float share = 2, volume = 1e9f, start = 0;
  for (uint32_t t = 0; t < 3; ++t) {
    scree_cliff_time time;
    scree_asset asset;
    assert_int_equal(scree_pack_get_time(it.pack, t, &time), SCREE_OK);
    assert_int_equal(scree_pack_get_asset(it.pack, time.asset, &asset), SCREE_OK);
    assert_int_equal(time.paths, recipe.paths[t]);
    assert_true(time.share < share && asset.volume < volume);
    assert_true(t > 0 || (time.share == 1 && time.placement_count == 0));
    share = time.share;
    volume = asset.volume;
    if (t == 0) start = volume;
    assert_true(fabsf(volume / start - share) < 1e-4f);
    for (uint32_t p = 0; p < time.placement_count; ++p, ++placed) {
      scree_block_placement placement;
      assert_int_equal(scree_pack_get_placements(it.pack, time.first_placement + p, 1, &placement), SCREE_OK);
      assert_true(placement.asset >= 3 && placement.asset < info.asset_count);
      assert_int_equal(scree_pack_get_asset(it.pack, placement.asset, &asset), SCREE_OK);
      assert_true(placement.translation[1] > 0 && placement.translation[1] < 6 && asset.volume > 0);
    }
  }
  assert_int_equal(placed, info.placement_count);
  assert_true(fabs((double)share - it.report.share) < 1e-6);
  for (uint32_t a = 0; a < info.asset_count; ++a)
    for (uint32_t lod = 0; lod < 2; ++lod) {
      scree_lod level;
      assert_int_equal(scree_pack_get_lod(it.pack, a, lod, &level), SCREE_OK);
      scree_vertex* vertices = malloc(level.vertices * sizeof *vertices);
      scree_uv* uvs = malloc(level.vertices * sizeof *uvs);
      uint8_t* groups = malloc(level.vertices);
      uint32_t* indices = malloc(3 * (size_t)level.triangles * sizeof *indices);
      assert_int_equal(scree_draco_decode_u32(it.pack, a, lod, vertices, level.vertices, indices, 3 * (size_t)level.triangles),
                       SCREE_OK);
      assert_int_equal(scree_draco_decode_uvs(it.pack, a, lod, uvs, groups, level.vertices), SCREE_OK);
      assert_true(scree_cliff_mesh_digest(vertices, uvs, groups, level.vertices, indices, level.triangles) == level.digest);
      uint32_t cuts = 0;
      for (uint32_t v = 0; v < level.vertices; ++v) cuts += vertices[v].material == 2;
      assert_true(a == 0 ? cuts == 0 : cuts > 0);
      free(vertices);
      free(uvs);
      free(groups);
      free(indices);
    }
  unbake(&it);
}

/* What reaches into the ground stays in it: the ground on which blocks lie is y = 0 of the pack. */
static void blocks_lie_on_the_ground_at_y_0(void** state) {
  (void)state;
  static scree_shard_recipe recipe;
  small(&recipe);
  recipe.rubble.ground = 1;
  baked it = bake(&recipe);
  scree_asset asset;
  assert_int_equal(scree_pack_get_asset(it.pack, 0, &asset), SCREE_OK);
  assert_true(asset.bounds_min[1] == -1);
  scree_cliff_time time;
  assert_int_equal(scree_pack_get_time(it.pack, 2, &time), SCREE_OK);
  uint32_t lying = 0;
  for (uint32_t p = 0; p < time.placement_count; ++p) {
    scree_block_placement placement;
    assert_int_equal(scree_pack_get_placements(it.pack, time.first_placement + p, 1, &placement), SCREE_OK);
    assert_int_equal(scree_pack_get_asset(it.pack, placement.asset, &asset), SCREE_OK);
    lying += fabsf(placement.translation[1] + asset.bounds_min[1]) < 0.01f;
  }
  assert_true(lying > 3);
  unbake(&it);
}

/* A ball that lies in the ground to its middle is nowhere as wide as there, and its foot is but a point. */
static void a_footprint_is_taken_at_the_ground(void** state) {
  (void)state;
  static scree_shard_recipe recipe;
  small(&recipe);
  recipe.input.shape = SCREE_SHARD_SPHERE;
  recipe.rubble.ground = 4;
  recipe.path_count = 1;
  baked it = bake(&recipe);
  scree_model model;
  assert_int_equal(scree_pack_get_model(it.pack, 0, &model), SCREE_OK);
  assert_true(model.footprint > 3.8f && model.footprint < 4.05f);
  unbake(&it);
}

static const double tetrahedron[12] = {-1, 0, -1, 1, 0, -1, 0, 0, 1, 0, 2, 0};
static const uint32_t tetrahedron_sides[12] = {0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0};

static uint32_t finest_triangles(const baked* it, uint32_t asset) {
  scree_lod level;
  assert_int_equal(scree_pack_get_lod(it->pack, asset, 0, &level), SCREE_OK);
  return level.triangles;
}

/* Two triangles a side of a box, whatever cells lie under them; where each plane is one triangle, walls lose none. */
static void a_whole_convex_solid_is_its_own_triangles(void** state) {
  (void)state;
  static scree_shard_recipe recipe;
  small(&recipe);
  recipe.path_count = 1;
  const scree_solid pyramid = {.positions = tetrahedron, .indices = tetrahedron_sides, .vertex_count = 4, .triangle_count = 4};
  for (scree_clip clip = SCREE_CLIP_AUTO; clip <= SCREE_CLIP_MESH; ++clip) {
    recipe.clip = clip;
    recipe.input.shape = SCREE_SHARD_BOX;
    memcpy(recipe.input.size, (const double[3]){3, 4, 5}, sizeof recipe.input.size);
    baked it = bake(&recipe);
    if (clip == SCREE_CLIP_WALLS)
      assert_true(finest_triangles(&it, 0) > 12);
    else
      assert_int_equal(finest_triangles(&it, 0), 12);
    unbake(&it);
    recipe.input.shape = SCREE_SHARD_MESH;
    strcpy(recipe.input.file, "pyramid.obj");
    it = bake_with(&(scree_shard_desc){.recipe = &recipe, .mesh = &pyramid});
    assert_int_equal(finest_triangles(&it, 0), 4);
    unbake(&it);
  }
}

static void the_pack_does_not_depend_on_threads(void** state) {
  (void)state;
  static scree_shard_recipe recipe;
  small(&recipe);
  baked one = bake(&recipe);
  static const uint32_t counts[3] = {1, 2, 5};
  for (int i = 0; i < 3; ++i) {
    scree_threads* pool;
    assert_int_equal(scree_threads_create(counts[i] - 1, NULL, &pool), SCREE_OK);
    baked other = bake_with(&(scree_shard_desc){.recipe = &recipe, .jobs = scree_threads_jobs(pool)});
    assert_int_equal(one.size, other.size);
    assert_memory_equal(one.bytes, other.bytes, one.size);
    unbake(&other);
    scree_threads_destroy(pool);
  }
  recipe.random_seed = 2;
  baked other = bake(&recipe);
  assert_true(other.report.bake.digest != one.report.bake.digest);
  unbake(&other);
  unbake(&one);
}

static void what_falls_is_gone_where_the_recipe_says_so(void** state) {
  (void)state;
  static scree_shard_recipe recipe;
  small(&recipe);
  baked kept = bake(&recipe);
  recipe.rules.frost.fall = SCREE_FALL_GONE;
  baked gone = bake(&recipe);
  assert_int_equal(gone.report.blocks, 0);
  assert_int_equal(gone.report.placements, 0);
  assert_true(gone.report.share == kept.report.share && gone.report.breaks == kept.report.breaks);
  unbake(&gone);
  recipe.rules.frost.fall = SCREE_FALL_KEPT;
  recipe.rubble.min_volume = 1e6;
  gone = bake(&recipe);
  assert_int_equal(gone.report.placements, 0);
  unbake(&gone);
  unbake(&kept);
}

static void blocks_too_thin_for_the_lattice_are_dust(void** state) {
  (void)state;
  static scree_shard_recipe recipe;
  small(&recipe);
  baked fine = bake(&recipe);
  recipe.lattice_per_metre = 1;
  baked coarse = bake(&recipe);
  assert_true(coarse.report.blocks < fine.report.blocks && coarse.report.breaks == fine.report.breaks);
  for (uint32_t t = 0; t < 3; ++t) {
    scree_cliff_time time;
    assert_int_equal(scree_pack_get_time(coarse.pack, t, &time), SCREE_OK);
    for (uint32_t p = 0; p < time.placement_count; ++p) {
      scree_block_placement placement;
      scree_asset asset;
      assert_int_equal(scree_pack_get_placements(coarse.pack, time.first_placement + p, 1, &placement), SCREE_OK);
      assert_int_equal(scree_pack_get_asset(coarse.pack, placement.asset, &asset), SCREE_OK);
      assert_true(asset.volume > 0);
    }
  }
  unbake(&coarse);
  unbake(&fine);
}

static void times_by_share_are_kept_when_so_much_stands(void** state) {
  (void)state;
  static scree_shard_recipe recipe;
  small(&recipe);
  recipe.path_count = 0;
  recipe.share_count = 2;
  recipe.shares[0] = 0.95;
  recipe.shares[1] = 0.8;
  baked it = bake(&recipe);
  for (uint32_t t = 0; t < 2; ++t) {
    scree_cliff_time time;
    assert_int_equal(scree_pack_get_time(it.pack, t, &time), SCREE_OK);
    assert_true((double)time.share <= recipe.shares[t] && (double)time.share > recipe.shares[t] - 0.15 && time.paths > 0);
  }
  unbake(&it);
}

/* The digest of the state after so many paths by hand, with a damage that changes after some. */
static uint64_t weather_by_hand(const scree_shard_recipe* recipe, uint64_t until, uint64_t change_at, double damage,
                                uint32_t* breaks) {
  scree_error error;
  const scree_shard_desc desc = {.recipe = recipe};
  scree_solid_memory solid;
  assert_int_equal(scree_shard_solid_make(&desc, &solid, &error), SCREE_OK);
  scree_seed_pattern pattern;
  scree_shard_seeds_view(recipe, &pattern);
  double* seeds;
  uint32_t seed_count;
  assert_int_equal(scree_seeds_create(&pattern, &solid.solid, NULL, &seeds, &seed_count, &error), SCREE_OK);
  scree_shards* shards;
  const scree_shards_desc split = {.solid = solid.solid, .seeds = seeds, .seed_count = seed_count};
  assert_int_equal(scree_shards_create(&split, &shards, &error), SCREE_OK);
  scree_seeds_free(NULL, seeds, seed_count);
  scree_solid_free(NULL, &solid);
  scree_shards_view view;
  scree_shards_get(shards, &view);
  uint8_t* states = malloc(view.shard_count);
  scree_shard_states(recipe, shards, states);
  scree_frost_desc frost_desc = {.shards = shards, .states = states, .random_seed = 1};
  scree_shard_rules_view(&desc, &recipe->rules, &frost_desc.rules);
  scree_frost* frost;
  assert_int_equal(scree_frost_create(&frost_desc, &frost, &error), SCREE_OK);
  scree_frost_step(frost, change_at < until ? change_at : until);
  if (change_at < until) {
    frost_desc.rules.damage = damage;
    assert_int_equal(scree_frost_set_rules(frost, &frost_desc.rules, &error), SCREE_OK);
    scree_frost_step(frost, until - change_at);
  }
  const uint64_t digest = scree_frost_digest(frost);
  scree_frost_stats stats;
  scree_frost_get_stats(frost, &stats);
  *breaks = (uint32_t)stats.breaks;
  scree_frost_destroy(frost);
  scree_shards_destroy(shards);
  free(states);
  return digest;
}

static void phases_change_the_rules_at_their_moment(void** state) {
  (void)state;
  static scree_shard_recipe recipe;
  small(&recipe);
  recipe.path_count = 2;
  recipe.paths[0] = 400;
  recipe.paths[1] = 800;
  uint32_t plain, changed;
  weather_by_hand(&recipe, 800, 1000, 0, &plain);
  weather_by_hand(&recipe, 800, 400, 0, &changed);
  assert_true(changed < plain);
  baked it = bake(&recipe);
  const uint64_t first = it.report.breaks;
  unbake(&it);
  recipe.phase_count = 1;
  recipe.phases[0] = (scree_shard_phase){.share = -1, .paths = 400, .changes = SCREE_SHARD_DAMAGE};
  recipe.phases[0].rules.frost.damage = 0; /* from here on nothing breaks by damage */
  it = bake(&recipe);
  assert_true(it.report.breaks < first);
  const uint64_t until_share = it.report.breaks;
  unbake(&it);
  /* A phase waits for the one before it, and for its own moment. */
  recipe.phases[1] = recipe.phases[0];
  recipe.phases[1].share = 1;
  recipe.phases[1].rules.frost.damage = recipe.rules.frost.damage;
  recipe.phase_count = 2;
  it = bake(&recipe);
  assert_true(it.report.breaks == first && first > until_share);
  unbake(&it);
}

static double volume_of(const scree_solid* solid) {
  double volume6 = 0;
  for (uint32_t t = 0; t < solid->triangle_count; ++t) {
    const double* p[3];
    for (int k = 0; k < 3; ++k) p[k] = solid->positions + 3 * (size_t)solid->indices[3 * t + k];
    volume6 += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) + p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
               p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
  }
  return volume6 / 6;
}

static double solid_volume(const scree_shard_desc* desc, double* low) {
  scree_solid_memory solid;
  scree_error error;
  if (scree_shard_solid_make(desc, &solid, &error) != SCREE_OK) fail_msg("%s", error.message);
  if (scree_solid_check(&solid.solid, NULL, &error) != SCREE_OK) fail_msg("%s", error.message);
  const double volume = volume_of(&solid.solid);
  *low = 1e9;
  for (uint32_t v = 0; v < solid.solid.vertex_count; ++v) *low = fmin(*low, solid.solid.positions[3 * v + 1]);
  scree_solid_free(NULL, &solid);
  return volume;
}

static void every_shape_is_closed_and_has_its_volume(void** state) {
  (void)state;
  static scree_shard_recipe recipe;
  const double pi = 3.14159265358979;
  const struct {
    scree_shard_input input;
    double volume, tolerance;
  } shapes[] = {
      {{.shape = SCREE_SHARD_BOX, .size = {3, 4, 5}}, 60, 1e-9},
      {{.shape = SCREE_SHARD_BOX, .size = {3, 4, 5}, .noise = 0.2, .resolution = 60}, 60, 6},
      {{.shape = SCREE_SHARD_HILL, .radius = 2, .height = 3, .top = 1, .rings = 1, .sides = 4}, 8 * 3, 1e-9},
      {{.shape = SCREE_SHARD_HILL, .radius = 2, .height = 3, .top = 1e-2, .rings = 16, .sides = 64}, pi * 4 * 3 / 3 * 1.01, 0.15},
      {{.shape = SCREE_SHARD_SPHERE, .radius = 2}, 4.0 / 3 * pi * 8, 0.4},
      {{.shape = SCREE_SHARD_CONE, .radius = 2, .height = 6}, pi * 8, 0.4},
      {{.shape = SCREE_SHARD_CAPSULE, .radius = 1, .height = 5}, pi * 3 + 4.0 / 3 * pi, 0.3},
      {{.shape = SCREE_SHARD_CAPSULE, .radius = 1, .height = 2}, 4.0 / 3 * pi, 0.1},
  };
  for (size_t i = 0; i < sizeof shapes / sizeof *shapes; ++i) {
    small(&recipe);
    scree_shard_input input = shapes[i].input;
    input.wavelength = 2;
    input.octaves = 2;
    recipe.input = input;
    double low;
    const double volume = solid_volume(&(scree_shard_desc){.recipe = &recipe}, &low);
    if (!(fabs(volume - shapes[i].volume) <= shapes[i].tolerance))
      fail_msg("shape %zu: %g cubic metres instead of %g", i, volume, shapes[i].volume);
    if (!(fabs(low) < 0.06 + input.noise)) fail_msg("shape %zu: stands at %g", i, low);
  }
  /* A bulge makes more of it, and stays convex: each wall is below all others' corners. */
  small(&recipe);
  double low, flat, round;
  recipe.input.bulge = 0;
  flat = solid_volume(&(scree_shard_desc){.recipe = &recipe}, &low);
  recipe.input.bulge = 1;
  round = solid_volume(&(scree_shard_desc){.recipe = &recipe}, &low);
  assert_true(round > flat * 1.2);
}

static void what_recipes_name_comes_with_the_call(void** state) {
  (void)state;
  static scree_shard_recipe recipe;
  static scree_hoodoo_recipe hoodoo;
  scree_error error;
  double low;
  small(&recipe);
  strcpy(recipe.input.file, "some.obj");
  static const scree_shard_shape shapes[] = {SCREE_SHARD_MESH, SCREE_SHARD_TERRAIN, SCREE_SHARD_HOODOO, SCREE_SHARD_SUPPORT};
  for (int i = 0; i < 4; ++i) {
    recipe.input.shape = shapes[i];
    assert_int_equal(refused(&(scree_shard_desc){.recipe = &recipe}, &error), SCREE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "not given"));
  }
  recipe.input.shape = SCREE_SHARD_MESH;
  recipe.input.scale = 3;
  recipe.input.position[1] = 2;
  scree_solid mesh = {.positions = tetrahedron, .indices = tetrahedron_sides, .vertex_count = 4, .triangle_count = 4};
  const double volume = solid_volume(&(scree_shard_desc){.recipe = &recipe, .mesh = &mesh}, &low);
  assert_true(fabs(volume - 27 * 4.0 / 3) < 1e-9 && low == 2);
  baked it = bake_with(&(scree_shard_desc){.recipe = &recipe, .mesh = &mesh});
  unbake(&it);
  mesh.triangle_count = 3;
  assert_int_equal(refused(&(scree_shard_desc){.recipe = &recipe, .mesh = &mesh}, &error), SCREE_ERROR_NOT_CLOSED);

  recipe.input.shape = SCREE_SHARD_TERRAIN;
  recipe.input.spacing = 2;
  const float heights[9] = {0, 1, 0, 1, 3, 1, 0, 1, 0};
  const scree_shard_desc terrain = {.recipe = &recipe, .heights = heights, .height_width = 3, .height_depth = 3};
  assert_true(solid_volume(&terrain, &low) > 16 && low == -1);
  it = bake_with(&terrain);
  unbake(&it);

  recipe.input.shape = SCREE_SHARD_HOODOO;
  scree_hoodoo_default(&hoodoo);
  hoodoo.size[0] = hoodoo.size[2] = 40;
  hoodoo.size[1] = 32;
  hoodoo.start.radius = 11;
  const scree_hoodoo_desc given = {.recipe = &hoodoo};
  recipe.input.variant = 1;
  recipe.input.age = 1;
  const scree_shard_desc split = {.recipe = &recipe, .hoodoo = &given};
  const double younger = solid_volume(&split, &low);
  assert_true(low < 0 && low > -0.25);
  recipe.input.age = 2;
  assert_true(solid_volume(&split, &low) < younger);
  recipe.input.age = 7;
  assert_int_equal(refused(&split, &error), SCREE_ERROR_RANGE);
  assert_non_null(strstr(error.message, "4 variants of 3 ages"));

  recipe.input.shape = SCREE_SHARD_SUPPORT;
  recipe.input.resolution = 40;
  scree_support* support;
  const scree_shape ball = {.kind = SCREE_SHAPE_SPHERE, .sphere = {3}};
  assert_int_equal(scree_support_create(&(scree_support_desc){.shapes = &ball, .shape_count = 1}, NULL, &support, NULL), SCREE_OK);
  assert_true(fabs(solid_volume(&(scree_shard_desc){.recipe = &recipe, .support = support}, &low) - 113) < 5);
  scree_support_destroy(support);
}

static void regions_say_what_is_core_later_ones_over_earlier_ones(void** state) {
  (void)state;
  static scree_shard_recipe recipe;
  static const scree_shard_region regions[] = {
      {.where = SCREE_SHARD_ALL, .state = SCREE_SHARD_CORE},
      {.where = SCREE_SHARD_AT_BASE, .state = SCREE_SHARD_AIR},
      {.where = SCREE_SHARD_IN_BOX, .state = SCREE_SHARD_SOLID, .min = {-2.1, 1.4, -2.1}, .max = {2.1, 1.6, 2.1}},
      {.where = SCREE_SHARD_BEYOND, .state = SCREE_SHARD_AIR, .direction = {0, 3, 0}, .offset = 2.1},
      {.where = SCREE_SHARD_FACING, .state = SCREE_SHARD_CORE, .direction = {1, 0, 0}, .angle = 0.3},
      {.where = SCREE_SHARD_IN_SPHERE, .state = SCREE_SHARD_SOLID, .centre = {-1.5, 2.5, -1.5}, .radius = 0.4},
  };
  /* A box of 4 x 3 x 4 cubes: rows x, layers y. */
  double seeds[48][3];
  for (int i = 0; i < 48; ++i) {
    seeds[i][0] = i % 4 - 1.5;
    seeds[i][1] = i / 4 % 3 + 0.5;
    seeds[i][2] = i / 12 - 1.5;
  }
  small(&recipe);
  recipe.input.shape = SCREE_SHARD_BOX;
  recipe.input.size[0] = recipe.input.size[2] = 4;
  recipe.input.size[1] = 3;
  scree_solid_memory solid;
  assert_int_equal(scree_shard_solid_make(&(scree_shard_desc){.recipe = &recipe}, &solid, NULL), SCREE_OK);
  scree_shards* shards;
  scree_error error;
  if (scree_shards_create(&(scree_shards_desc){.solid = solid.solid, .seeds = &seeds[0][0], .seed_count = 48}, &shards, &error) !=
      SCREE_OK)
    fail_msg("%s", error.message);
  scree_shards_view view;
  scree_shards_get(shards, &view);
  assert_int_equal(view.shard_count, 48);
  memcpy(recipe.states, regions, sizeof regions);
  recipe.state_count = sizeof regions / sizeof *regions;
  uint8_t states[48];
  assert_int_equal(scree_shard_states(&recipe, shards, states), 0);
  for (uint32_t s = 0; s < 48; ++s) {
    const uint32_t i = view.shards[s].seed, x = i % 4, y = i / 4 % 3, z = i / 12;
    scree_shard_state expected = y == 1 ? SCREE_SHARD_SOLID : SCREE_SHARD_AIR; /* base, box, half-space */
    if (x == 3) expected = SCREE_SHARD_CORE;                                   /* looks along x */
    if (x == 0 && y == 2 && z == 0) expected = SCREE_SHARD_SOLID;
    if (states[s] != expected) fail_msg("%u %u %u is %u", x, y, z, states[s]);
  }
  recipe.states[0].where = SCREE_SHARD_EXTERIOR;
  recipe.state_count = 1;
  scree_shard_states(&recipe, shards, states);
  uint32_t core = 0;
  for (uint32_t s = 0; s < 48; ++s) core += states[s] == SCREE_SHARD_CORE;
  assert_int_equal(core, 44);
  /* Where no shard lies is told, also where others speak later. */
  recipe.states[1] = (scree_shard_region){.where = SCREE_SHARD_IN_SPHERE, .centre = {0, 5000, 0}, .radius = 20};
  recipe.states[2] = (scree_shard_region){.where = SCREE_SHARD_ALL};
  recipe.state_count = 3;
  assert_int_equal(scree_shard_states(&recipe, shards, states), 2);
  recipe.state_count = 0;
  assert_int_equal(scree_shard_states(&recipe, shards, states), 0);
  scree_shards_destroy(shards);
  scree_solid_free(NULL, &solid);
}

static void what_cannot_be_baked_is_said(void** state) {
  (void)state;
  static scree_shard_recipe recipe;
  scree_error error;
  const scree_shard_desc desc = {.recipe = &recipe};
#define REFUSED(change, code, said)                                                    \
  do {                                                                                 \
    small(&recipe);                                                                    \
    change;                                                                            \
    const scree_result got = refused(&desc, &error);                                   \
    if (got != SCREE_ERROR_##code || strstr(error.message, said) == NULL)              \
      fail_msg("%s: %s instead of %s", scree_result_string(got), error.message, said); \
  } while (0)
  REFUSED(recipe.input.radius = -1, RANGE, "input.radius: expected a number from");
  REFUSED((recipe.lattice_per_metre = 4096, recipe.input.radius = 40), RANGE, "lattice_per_metre: 4096 steps a metre are too fine");
  REFUSED(recipe.input.radius = 1e5, RANGE, "does not fit on the lattice");
  REFUSED((recipe.input.radius = 6000, recipe.path_count = 1), RANGE, "every block have to lie within 4096 metres");
  REFUSED((recipe.path_count = 0, recipe.share_count = 1, recipe.shares[0] = 0.5, recipe.max_paths = 10), RANGE,
          "shares[0]: 0.5 is not reached in max_paths");
  REFUSED((recipe.path_count = 0, recipe.share_count = 1, recipe.shares[0] = 0.99, recipe.max_paths = 3000,
           recipe.states[0].where = SCREE_SHARD_ALL),
          RANGE, "shares[0]: 0.99 is not reached in max_paths: a share of 1.000 stands after 3000 paths");
  REFUSED((recipe.states[0].where = SCREE_SHARD_ALL, recipe.states[0].state = SCREE_SHARD_AIR), INVALID_ARGUMENT,
          "paths[0]: nothing stands after 0 paths");
  REFUSED(recipe.rules.frost.resistance.kind = SCREE_RESISTANCE_FUNCTION, INVALID_ARGUMENT, "resistance.kind");
  REFUSED((recipe.seeds.kind = SCREE_SEEDS_POINTS, recipe.seeds.point_count = 2, recipe.seeds.points[0][1] = 2000,
           recipe.seeds.points[1][0] = 4.5),
          RANGE, "seeds.points: none of 2 lies in the box of the input, (-3.60388, 0, -3.89971) .. (4, 5, 3.89971) m");
  REFUSED((recipe.seeds.count = 0, recipe.seeds.spacing = 0.001), RANGE, "seeds.spacing: 0.001 metres make");
#undef REFUSED
}

typedef struct progress_log {
  double last;
  uint32_t calls, stop_at;
} progress_log;

static bool log_progress(void* user, const char* stage, double done) {
  progress_log* log = user;
  assert_non_null(stage);
  assert_true(done >= log->last && done <= 1);
  log->last = done;
  return ++log->calls != log->stop_at;
}

static void progress_never_falls_and_can_stop_a_bake(void** state) {
  (void)state;
  static scree_shard_recipe recipe;
  small(&recipe);
  progress_log log = {0};
  scree_shard_desc desc = {.recipe = &recipe, .progress = log_progress, .progress_user = &log};
  baked it = bake_with(&desc);
  unbake(&it);
  assert_true(log.calls > 10 && log.last == 1);
  const uint32_t calls = log.calls;
  for (uint32_t stop_at = 1; stop_at <= calls; stop_at += 1 + calls / 12) {
    scree_error error;
    log = (progress_log){.stop_at = stop_at};
    assert_int_equal(refused(&desc, &error), SCREE_ERROR_CANCELLED);
    assert_int_equal(log.calls, stop_at);
  }
}

static void every_failing_allocation_is_survived(void** state) {
  (void)state;
  static scree_shard_recipe recipe;
  small(&recipe);
  recipe.seeds.count = 8;
  recipe.path_count = 1;
  recipe.paths[0] = 300;
  scree_result result = SCREE_ERROR_OUT_OF_MEMORY;
  int32_t n = 0;
  for (; result != SCREE_OK; ++n) {
    assert_in_range(n, 0, 20000);
    failing_allocator memory = {.fail_at = n};
    const scree_shard_desc desc = {.recipe = &recipe, .allocator = failing_allocator_of(&memory)};
    uint8_t* bytes;
    size_t size;
    scree_shard_report report;
    result = scree_shards_bake(&desc, &bytes, &size, &report, NULL);
    scree_shards_bake_free(&desc, bytes, size);
    if (memory.live != 0) fail_msg("allocation %d: %lld bytes are not given back", n, (long long)memory.live);
    if (result != SCREE_OK) assert_int_equal(result, SCREE_ERROR_OUT_OF_MEMORY);
    assert_true((result != SCREE_OK) == memory.failed);
  }
  assert_true(n > 20);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_pack_holds_times_and_blocks_as_the_recipe_says),
      cmocka_unit_test(blocks_lie_on_the_ground_at_y_0),
      cmocka_unit_test(a_footprint_is_taken_at_the_ground),
      cmocka_unit_test(a_whole_convex_solid_is_its_own_triangles),
      cmocka_unit_test(the_pack_does_not_depend_on_threads),
      cmocka_unit_test(what_falls_is_gone_where_the_recipe_says_so),
      cmocka_unit_test(blocks_too_thin_for_the_lattice_are_dust),
      cmocka_unit_test(times_by_share_are_kept_when_so_much_stands),
      cmocka_unit_test(phases_change_the_rules_at_their_moment),
      cmocka_unit_test(every_shape_is_closed_and_has_its_volume),
      cmocka_unit_test(what_recipes_name_comes_with_the_call),
      cmocka_unit_test(regions_say_what_is_core_later_ones_over_earlier_ones),
      cmocka_unit_test(what_cannot_be_baked_is_said),
      cmocka_unit_test(progress_never_falls_and_can_stop_a_bake),
      cmocka_unit_test(every_failing_allocation_is_survived),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
