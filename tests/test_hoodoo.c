/* Hoodoos from recipe to pack: what is baked is what the recipe says, whoever bakes it, and what cannot be baked is said. */
#include <scree/draco.h>
#include <scree/hoodoo.h>
#include <scree/threads.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "failing_allocator.h"

/* A goblin of few voxels. */
static void small(scree_hoodoo_recipe* recipe) {
  scree_hoodoo_default(recipe);
  recipe->size[0] = recipe->size[2] = 40;
  recipe->size[1] = 32;
  recipe->start.radius = 11;
  recipe->variants = 2;
  recipe->age_count = 2;
  recipe->lod_levels = 3;
}

typedef struct baked {
  uint8_t* bytes;
  size_t size;
  scree_pack* pack;
  scree_bake_report report;
} baked;

static baked bake_with(const scree_hoodoo_desc* desc) {
  baked out = {0};
  scree_error error;
  if (scree_hoodoo_bake(desc, &out.bytes, &out.size, &out.report, &error) != SCREE_OK) fail_msg("%s", error.message);
  assert_int_equal(scree_pack_open_memory(out.bytes, out.size, NULL, &out.pack), SCREE_OK);
  assert_int_equal(scree_pack_verify(out.pack), SCREE_OK);
  return out;
}

static baked bake(const scree_hoodoo_recipe* recipe) {
  return bake_with(&(scree_hoodoo_desc){.recipe = recipe});
}

static void unbake(baked* it) {
  scree_pack_close(it->pack);
  scree_hoodoo_free(&(scree_hoodoo_desc){0}, it->bytes, it->size);
}

static scree_result refused(const scree_hoodoo_desc* desc, scree_error* error) {
  uint8_t* bytes;
  size_t size;
  const scree_result result = scree_hoodoo_bake(desc, &bytes, &size, NULL, error);
  assert_null(bytes);
  assert_int_equal(size, 0);
  return result;
}

static scree_model model_of(const scree_pack* pack, uint32_t variant, uint32_t age) {
  scree_model model;
  assert_int_equal(scree_pack_get_model(pack, scree_pack_model(pack, variant, age), &model), SCREE_OK);
  return model;
}

static uint64_t mesh_of(const scree_pack* pack, uint32_t variant, uint32_t age) {
  scree_lod level;
  assert_int_equal(scree_pack_get_lod(pack, scree_pack_model(pack, variant, age), 0, &level), SCREE_OK);
  return level.digest;
}

static void a_pack_holds_variants_by_ages_as_the_recipe_says(void** state) {
  (void)state;
  static scree_hoodoo_recipe recipe;
  small(&recipe);
  baked it = bake(&recipe);
  scree_pack_info info;
  scree_pack_get_info(it.pack, &info);
  assert_int_equal(info.kind, SCREE_PACK_MODELS);
  assert_int_equal(info.variant_count, 2);
  assert_int_equal(info.asset_count, 4);
  assert_int_equal(info.lattice_per_cell, 160);
  assert_int_equal(it.report.rocks, 4);
  assert_true(it.report.digest == info.digest && it.report.bytes == it.size);
  static scree_hoodoo_recipe again;
  assert_int_equal(scree_hoodoo_parse(info.recipe, info.recipe_size, &again, NULL), SCREE_OK);
  for (uint32_t v = 0; v < 2; ++v) {
    float volume = 1e9f;
    for (uint32_t a = 0; a < 2; ++a) {
      const uint32_t index = scree_pack_model(it.pack, v, a);
      const scree_model model = model_of(it.pack, v, a);
      scree_asset asset;
      assert_int_equal(scree_pack_get_asset(it.pack, index, &asset), SCREE_OK);
      assert_true(model.share <= (float)recipe.ages[a] && model.share > (float)recipe.ages[a] - 0.1f);
      assert_true(model.height > 1 && model.height <= 32 * 0.05f * 1.01f);
      assert_true(model.footprint > 0.3f && model.footprint < 20 * 0.05f * 1.5f);
      assert_true(asset.volume < volume && asset.volume > 0.2f);
      volume = asset.volume;
      /* Rock above the ground, and what stands on it within the footprint. */
      float error = 0;
      for (uint32_t lod = 0; lod < 3; ++lod) {
        scree_lod level;
        assert_int_equal(scree_pack_get_lod(it.pack, index, lod, &level), SCREE_OK);
        assert_true(level.error >= error && level.error <= 1.25f * 0.05f * (float)(1u << lod) && (level.error > 0) == (lod > 0));
        error = level.error;
        scree_vertex* vertices = malloc(level.vertices * sizeof *vertices);
        uint32_t* indices = malloc(3 * (size_t)level.triangles * sizeof *indices);
        assert_int_equal(
            scree_draco_decode_u32(it.pack, index, lod, vertices, level.vertices, indices, 3 * (size_t)level.triangles), SCREE_OK);
        assert_true(scree_model_mesh_digest(vertices, level.vertices, indices, level.triangles) == level.digest);
        bool durable = false, curved = false;
        for (uint32_t i = 0; i < level.vertices; ++i) {
          const double x = vertices[i].position[0] / 160.0, z = vertices[i].position[2] / 160.0;
          if (lod == 0 && vertices[i].position[1] <= 0)
            assert_true(x * x + z * z <= (double)(model.footprint * model.footprint) * 1.02);
          durable = durable || vertices[i].durability > 0;
          curved = curved || vertices[i].curvature != 0;
        }
        assert_true(durable && curved);
        free(indices);
        free(vertices);
      }
    }
  }
  assert_true(mesh_of(it.pack, 0, 0) != mesh_of(it.pack, 1, 0));
  unbake(&it);
}

static void the_digest_does_not_depend_on_threads(void** state) {
  (void)state;
  static scree_hoodoo_recipe recipe;
  small(&recipe);
  recipe.variants = 3;
  baked one = bake(&recipe);
  static const uint32_t counts[3] = {1, 2, 5};
  for (int i = 0; i < 3; ++i) {
    scree_threads* pool;
    assert_int_equal(scree_threads_create(counts[i] - 1, NULL, &pool), SCREE_OK);
    baked other = bake_with(&(scree_hoodoo_desc){.recipe = &recipe, .jobs = scree_threads_jobs(pool)});
    assert_int_equal(one.size, other.size);
    assert_memory_equal(one.bytes, other.bytes, one.size);
    unbake(&other);
    scree_threads_destroy(pool);
  }
  /* One variant by itself is the same one, with all threads inside it. */
  recipe.variants = 1;
  scree_threads* pool;
  assert_int_equal(scree_threads_create(2, NULL, &pool), SCREE_OK);
  baked alone = bake_with(&(scree_hoodoo_desc){.recipe = &recipe, .jobs = scree_threads_jobs(pool)});
  assert_true(mesh_of(alone.pack, 0, 1) == mesh_of(one.pack, 0, 1));
  scree_threads_destroy(pool);
  unbake(&alone);
  unbake(&one);
}

static void ages_by_steps_are_kept_at_those_steps(void** state) {
  (void)state;
  static scree_hoodoo_recipe recipe;
  small(&recipe);
  recipe.variants = 1;
  recipe.age_count = 0;
  recipe.age_step_count = 3;
  recipe.age_steps[0] = 0;
  recipe.age_steps[1] = 5;
  recipe.age_steps[2] = 17;
  baked it = bake(&recipe);
  for (uint32_t a = 0; a < 3; ++a) assert_int_equal(model_of(it.pack, 0, a).steps, recipe.age_steps[a]);
  assert_true(model_of(it.pack, 0, 0).share == 1 && model_of(it.pack, 0, 2).share < model_of(it.pack, 0, 1).share);
  unbake(&it);
}

/* The same steps by hand, with rules that change between them. */
static uint64_t weather_by_hand(const scree_hoodoo_recipe* recipe, uint32_t until, uint32_t change_at, double exposure) {
  scree_weather_desc desc = {0};
  scree_hoodoo_start_memory memory;
  const scree_hoodoo_desc hoodoo = {.recipe = recipe};
  assert_int_equal(scree_hoodoo_start_make(&hoodoo, 0, &desc.start, &memory, NULL), SCREE_OK);
  scree_hoodoo_rules_view(&recipe->rules, &desc.rules);
  scree_weather* weather;
  assert_int_equal(scree_weather_create(&desc, &weather, NULL), SCREE_OK);
  scree_hoodoo_start_free(&hoodoo, &memory);
  if (change_at < until) {
    assert_int_equal(scree_weather_step(weather, change_at), SCREE_OK);
    desc.rules.exposure = exposure;
    assert_int_equal(scree_weather_set_rules(weather, &desc.rules, NULL), SCREE_OK);
    assert_int_equal(scree_weather_step(weather, until - change_at), SCREE_OK);
  } else
    assert_int_equal(scree_weather_step(weather, until), SCREE_OK);
  scree_weather_stats stats;
  scree_weather_get_stats(weather, &stats);
  scree_weather_destroy(weather);
  return stats.rock;
}

static void phases_change_the_rules_at_their_moment(void** state) {
  (void)state;
  static scree_hoodoo_recipe recipe;
  small(&recipe);
  recipe.variants = 1;
  recipe.age_count = 0;
  recipe.age_step_count = 1;
  recipe.age_steps[0] = 20;
  const uint64_t plain = weather_by_hand(&recipe, 20, 99, 0), start = weather_by_hand(&recipe, 0, 99, 0);
  const uint64_t changed = weather_by_hand(&recipe, 20, 8, 2);
  assert_true(changed < plain && plain < start);
  baked it = bake(&recipe);
  assert_true(model_of(it.pack, 0, 0).share == (float)((double)plain / (double)start));
  unbake(&it);
  recipe.phase_count = 1;
  recipe.phases[0] = (scree_hoodoo_phase){.share = -1, .steps = 8, .changes = SCREE_HOODOO_EXPOSURE};
  recipe.phases[0].rules.exposure = 2;
  it = bake(&recipe);
  assert_true(model_of(it.pack, 0, 0).share == (float)((double)changed / (double)start));
  unbake(&it);
  /* By share, and one phase behind another, neither before its moment nor before the other. */
  recipe.phases[0].share = 0.9;
  recipe.phases[1] = recipe.phases[0];
  recipe.phases[1].share = 0.95;
  recipe.phases[1].rules.exposure = 0;
  recipe.phase_count = 2;
  uint32_t at = 0;
  while ((double)weather_by_hand(&recipe, at, 99, 0) > 0.9 * (double)start) ++at;
  const uint64_t both = weather_by_hand(&recipe, 20, at, 0);
  it = bake(&recipe);
  assert_true(model_of(it.pack, 0, 0).share == (float)((double)both / (double)start));
  unbake(&it);
}

static void every_start_shape_has_its_volume(void** state) {
  (void)state;
  static scree_hoodoo_recipe recipe;
  small(&recipe);
  recipe.variants = 1;
  recipe.age_count = 1;
  recipe.ages[0] = 1;
  recipe.voxel = 1;
  recipe.lattice_steps = 8;
  const double pi = 3.14159265358979;
  const struct {
    scree_hoodoo_shape shape;
    double radius, height, lift, volume;
  } shapes[] = {
      {SCREE_HOODOO_BOX, 1, 0, 0, 20 * 10 * 16},          {SCREE_HOODOO_COLUMN, 10, 20, 0, pi * 100 * 20},
      {SCREE_HOODOO_SPHERE, 9, 0, 4, 4.0 / 3 * pi * 729}, {SCREE_HOODOO_CYLINDER, 8, 12, 3, pi * 64 * 12},
      {SCREE_HOODOO_CONE, 14, 21, 0, pi * 196 * 7},       {SCREE_HOODOO_JOINTS, 1, 0, 0, 20 * 10 * 16},
  };
  for (size_t i = 0; i < sizeof shapes / sizeof *shapes; ++i) {
    recipe.start = (scree_hoodoo_start){.shape = shapes[i].shape,
                                        .min = {10, 2, 12},
                                        .max = {30, 12, 28},
                                        .radius = shapes[i].radius,
                                        .height = shapes[i].height,
                                        .lift = shapes[i].lift,
                                        .spacing = 8,
                                        .low = 1};
    scree_weather_desc desc = {0};
    scree_hoodoo_start_memory memory;
    const scree_hoodoo_desc hoodoo = {.recipe = &recipe};
    assert_int_equal(scree_hoodoo_start_make(&hoodoo, 0, &desc.start, &memory, NULL), SCREE_OK);
    scree_hoodoo_rules_view(&recipe.rules, &desc.rules);
    scree_weather* weather;
    assert_int_equal(scree_weather_create(&desc, &weather, NULL), SCREE_OK);
    scree_weather_stats stats;
    scree_weather_get_stats(weather, &stats);
    if ((double)stats.rock < shapes[i].volume * 0.95 || (double)stats.rock > shapes[i].volume * 1.05)
      fail_msg("shape %d: %llu voxels instead of %g", (int)shapes[i].shape, (unsigned long long)stats.rock, shapes[i].volume);
    scree_weather_destroy(weather);
    scree_hoodoo_start_free(&hoodoo, &memory);
    baked it = bake(&recipe);
    scree_asset asset;
    assert_int_equal(scree_pack_get_asset(it.pack, 0, &asset), SCREE_OK);
    assert_true((double)asset.volume > shapes[i].volume * 0.85 && (double)asset.volume < shapes[i].volume * 1.1);
    /* What stands on the ground goes four voxels into it. */
    assert_true((double)(asset.bounds_min[1] - (float)shapes[i].lift) > (shapes[i].lift > 0 ? -1.01 : -4.01));
    unbake(&it);
  }
}

static void maps_and_meshes_come_with_the_call(void** state) {
  (void)state;
  static scree_hoodoo_recipe recipe;
  small(&recipe);
  recipe.variants = 1;
  scree_error error;
  strcpy(recipe.start.file, "some.png");
  recipe.start.shape = SCREE_HOODOO_JOINT_MAP;
  assert_int_equal(refused(&(scree_hoodoo_desc){.recipe = &recipe}, &error), SCREE_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "start.file"));
  const uint8_t map[9] = {0, 0, 0, 0, 255, 0, 0, 128, 0};
  baked it = bake_with(&(scree_hoodoo_desc){.recipe = &recipe, .map = map, .map_width = 3, .map_depth = 3});
  unbake(&it);
  const uint8_t black[1] = {0};
  assert_int_equal(refused(&(scree_hoodoo_desc){.recipe = &recipe, .map = black, .map_width = 1, .map_depth = 1}, &error),
                   SCREE_ERROR_INVALID_ARGUMENT);
  recipe.start.shape = SCREE_HOODOO_MESH;
  assert_int_equal(refused(&(scree_hoodoo_desc){.recipe = &recipe}, &error), SCREE_ERROR_INVALID_ARGUMENT);
  const float positions[12] = {-0.8f, 0, -0.7f, 0.8f, 0, -0.7f, 0, 0, 0.9f, 0, 1.4f, 0};
  const uint32_t indices[12] = {0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0};
  const scree_shape shape = {.kind = SCREE_SHAPE_MESH,
                             .mesh = {.positions = positions, .vertex_count = 4, .indices = indices, .triangle_count = 4}};
  scree_support* mesh;
  if (scree_support_create(&(scree_support_desc){.shapes = &shape, .shape_count = 1}, NULL, &mesh, &error) != SCREE_OK)
    fail_msg("%s", error.message);
  it = bake_with(&(scree_hoodoo_desc){.recipe = &recipe, .mesh = mesh});
  assert_true(model_of(it.pack, 0, 0).height < 1.45f && model_of(it.pack, 0, 0).height > 0.6f);
  unbake(&it);
  scree_support_destroy(mesh);
}

static void what_cannot_be_baked_is_said(void** state) {
  (void)state;
  static scree_hoodoo_recipe recipe;
  scree_error error;
  const scree_hoodoo_desc desc = {.recipe = &recipe};
#define REFUSED(change, code, said)                                         \
  do {                                                                      \
    small(&recipe);                                                         \
    change;                                                                 \
    assert_int_equal(refused(&desc, &error), SCREE_ERROR_##code);           \
    if (strstr(error.message, said) == NULL) fail_msg("%s", error.message); \
  } while (0)
  REFUSED(recipe.voxel = 0.001, RANGE, "voxel: 0.001 metres at 8 lattice steps a voxel make 8000 steps a metre");
  REFUSED(recipe.max_steps = 3, RANGE, "variant 0: ages[0]: 0.8 is not reached in max_steps, 3");
  REFUSED((recipe.age_count = 0, recipe.age_step_count = 1, recipe.age_steps[0] = 9999, recipe.rules.colluvium_share = 0),
          INVALID_ARGUMENT, "no rock is left");
  REFUSED((recipe.size[0] = recipe.size[1] = recipe.size[2] = 4096), RANGE, "");
  REFUSED(recipe.rules.spheroidal.gain = -1, RANGE, "spheroidal.gain");
  REFUSED((recipe.size[0] = recipe.size[1] = recipe.size[2] = 10, recipe.rules.bubbles[0].bubbles[0].radius = 12), RANGE, "radius");
  small(&recipe);
  const scree_hoodoo_desc poor = {.recipe = &recipe, .memory_limit = 1000};
  assert_int_equal(refused(&poor, &error), SCREE_ERROR_RANGE);
  assert_true(error.message[0] != '\0');
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
  static scree_hoodoo_recipe recipe;
  small(&recipe);
  progress_log log = {0};
  scree_hoodoo_desc desc = {.recipe = &recipe, .progress = log_progress, .progress_user = &log};
  baked it = bake_with(&desc);
  unbake(&it);
  assert_true(log.calls > 10 && log.last == 1);
  log = (progress_log){.stop_at = 5};
  scree_error error;
  assert_int_equal(refused(&desc, &error), SCREE_ERROR_CANCELLED);
  assert_int_equal(log.calls, 5);
}

static void every_failing_allocation_is_survived(void** state) {
  (void)state;
  static scree_hoodoo_recipe recipe;
  small(&recipe);
  recipe.variants = 1;
  recipe.size[0] = recipe.size[1] = recipe.size[2] = 16;
  recipe.start.radius = 5;
  recipe.rules.bubbles[0].bubbles[0].radius = 2;
  recipe.age_count = 1;
  recipe.lod_levels = 2;
  scree_result result = SCREE_ERROR_OUT_OF_MEMORY;
  int32_t n = 0;
  for (; result != SCREE_OK; ++n) {
    assert_in_range(n, 0, 5000);
    failing_allocator memory = {.fail_at = n};
    const scree_hoodoo_desc desc = {.recipe = &recipe, .allocator = failing_allocator_of(&memory)};
    uint8_t* bytes;
    size_t size;
    scree_bake_report report;
    result = scree_hoodoo_bake(&desc, &bytes, &size, &report, NULL);
    scree_hoodoo_free(&desc, bytes, size);
    assert_true(memory.live == 0);
    if (result != SCREE_OK) assert_int_equal(result, SCREE_ERROR_OUT_OF_MEMORY);
    assert_true((result != SCREE_OK) == memory.failed);
  }
  assert_true(n > 20);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_pack_holds_variants_by_ages_as_the_recipe_says),
      cmocka_unit_test(the_digest_does_not_depend_on_threads),
      cmocka_unit_test(ages_by_steps_are_kept_at_those_steps),
      cmocka_unit_test(phases_change_the_rules_at_their_moment),
      cmocka_unit_test(every_start_shape_has_its_volume),
      cmocka_unit_test(maps_and_meshes_come_with_the_call),
      cmocka_unit_test(what_cannot_be_baked_is_said),
      cmocka_unit_test(progress_never_falls_and_can_stop_a_bake),
      cmocka_unit_test(every_failing_allocation_is_survived),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
