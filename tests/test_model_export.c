/* Models as .glb: each stands where it stood, turned and scaled as it was, in both forms. Read back by other code than wrote it. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* after the ones above */
#include <cmocka.h>

#include "glb_scene.h"
#include "make_model_pack.h"
#include "model_file.h"
#include "rock_export.h"

enum { COUNT = 60 };

static char folder[64], file[96];
static uint8_t* bytes;
static scree_pack* pack;
static uint8_t* cliff_bytes;
static scree_pack* cliff;
static scene_models* models;
static scree_instance instances[COUNT];
static uint32_t hashes[COUNT];
static rock_turn turns[COUNT];
static const scene_palette palette = {.colours = {{0.5f, 0.4f, 0.3f}}, .colour_count = 1, .variation = 0};

/* Places far enough apart to find each again, turns all round. */
static void make_instances(uint32_t assets) {
  for (uint32_t i = 0; i < COUNT; ++i) {
    const double angle = 6.283185307179586 * i / COUNT;
    instances[i] =
        (scree_instance){.position = {(float)(i % 8) * 20, (float)(i % 3), (float)(i / 8) * 20}, .asset = i * 7 % assets};
    turns[i] = (rock_turn){(float)sin(angle), (float)cos(angle), 0.5f + 0.02f * (float)i};
    hashes[i] = i * UINT32_C(2654435761);
  }
}

static uint32_t lod;

static void export_layer(rock_layer layer, rock_format format) {
  scree_error error = {""};
  rock_export* writer;
  const rock_export_desc desc = {.path = file, .format = format, .lod = lod};
  layer.cell_size = 1;
  layer.palette = &palette;
  layer.instances = instances;
  layer.hashes = hashes;
  layer.turns = turns;
  layer.count = COUNT;
  assert_int_equal(rock_export_begin(&desc, &writer, &error), SCREE_OK);
  if (rock_export_add(writer, &layer, NULL, &error) != SCREE_OK) fail_msg("%s", error.message);
  assert_int_equal(rock_export_finish(writer, NULL, &error), SCREE_OK);
}

/* The row of the instance that stands at a place. */
static uint32_t row_of(const glb_rock* rock) {
  for (uint32_t i = 0; i < COUNT; ++i) {
    double off = 0;
    for (int a = 0; a < 3; ++a) off = fmax(off, fabs(rock->position[a] - (double)instances[i].position[a]));
    if (off < 1e-3) return i;
  }
  fail_msg("a model stands at %g %g %g, where none should", rock->position[0], rock->position[1], rock->position[2]);
  return 0;
}

static void assert_near(double a, double b, double tolerance) {
  if (!(fabs(a - b) <= tolerance)) fail_msg("%.9g is not within %g of %.9g", a, tolerance, b);
}

static void read_back(glb_scene* scene) {
  const int good = glb_scene_load(file, scene);
  assert_string_equal(scene->message, "");
  assert_true(good);
  assert_int_equal(scene->rock_count, COUNT);
  uint8_t seen[COUNT] = {0};
  for (size_t i = 0; i < COUNT; ++i) {
    const glb_rock* rock = &scene->rocks[i];
    const uint32_t row = row_of(rock);
    assert_int_equal(seen[row]++, 0);
    assert_near(rock->turn[0], (double)turns[row].sine, 1e-6);
    assert_near(rock->turn[1], (double)turns[row].cosine, 1e-6);
  }
}

static void models_of_a_pack_are_turned_and_scaled(void** state) {
  (void)state;
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  make_instances(info.asset_count);
  for (int format = ROCK_FORMAT_INSTANCED; format <= ROCK_FORMAT_FLAT; ++format) {
    glb_scene scene;
    export_layer((rock_layer){.name = "hoodoos", .pack = pack}, (rock_format)format);
    read_back(&scene);
    for (size_t i = 0; i < COUNT; ++i) {
      const uint32_t row = row_of(&scene.rocks[i]);
      scree_asset asset;
      assert_int_equal(scree_pack_get_asset(pack, instances[row].asset, &asset), SCREE_OK);
      for (int a = 0; a < 3; ++a) {
        assert_near(scene.rocks[i].min[a], (double)asset.bounds_min[a] * (double)turns[row].scale, 1e-4);
        assert_near(scene.rocks[i].max[a], (double)asset.bounds_max[a] * (double)turns[row].scale, 1e-4);
      }
      assert_false(scene.rocks[i].is_grey); /* beds have tints */
    }
    glb_scene_free(&scene);
  }
}

/* What a file should say of a cliff's asset at the size of its pack: triangles that are cuts, and the sums of glb_rock. */
static uint32_t measure_uvs(uint32_t asset, double sums[2]) {
  scree_pack_info info;
  scree_lod level;
  scree_pack_get_info(cliff, &info);
  assert_int_equal(scree_pack_get_lod(cliff, asset, lod, &level), SCREE_OK);
  const size_t corners = (size_t)level.triangles * 3;
  scree_vertex* vertices = malloc(level.vertices * sizeof *vertices);
  scree_uv* uvs = malloc(level.vertices * sizeof *uvs);
  uint32_t* indices = malloc(corners * sizeof *indices);
  assert_int_equal(scree_draco_decode_u32(cliff, asset, lod, vertices, level.vertices, indices, corners), SCREE_OK);
  assert_int_equal(scree_draco_decode_uvs(cliff, asset, lod, uvs, NULL, level.vertices), SCREE_OK);
  uint32_t cuts = 0;
  sums[0] = sums[1] = 0;
  for (size_t i = 0; i < corners; ++i) {
    const int16_t* at = vertices[indices[i]].position;
    const double weight = (double)(at[0] + 2 * at[1] + 3 * at[2]) / info.lattice_per_cell;
    const double raw[2] = {uvs[indices[i]].u, uvs[indices[i]].v};
    for (int k = 0; k < 2; ++k)
      sums[k] += weight * ((double)info.uv_min[k] + (double)(info.uv_max[k] - info.uv_min[k]) * raw[k] / 65535);
    bool is_cut = i % 3 == 0;
    for (size_t k = 0; k < 3 && is_cut; ++k) is_cut = (vertices[indices[i + k]].material & 15) == 2;
    cuts += is_cut;
  }
  free(vertices);
  free(uvs);
  free(indices);
  return cuts;
}

static void cliffs_have_uvs_and_cuts_of_their_own(void** state) {
  (void)state;
  scree_pack_info info;
  scree_pack_get_info(cliff, &info);
  make_instances(info.asset_count);
  for (int form = 0; form < 4; ++form) {
    glb_scene scene;
    lod = (uint32_t)form / 2;
    export_layer((rock_layer){.name = "cliffs", .pack = cliff}, form % 2 == 0 ? ROCK_FORMAT_INSTANCED : ROCK_FORMAT_FLAT);
    read_back(&scene);
    assert_int_equal(scene.material_count, 2);
    bool some = false, none = false;
    for (size_t i = 0; i < COUNT; ++i) {
      const glb_rock* rock = &scene.rocks[i];
      const uint32_t row = row_of(rock);
      double sums[2];
      const uint32_t cuts = measure_uvs(instances[row].asset, sums);
      assert_true(rock->has_uvs && rock->is_grey);
      assert_int_equal(rock->cut_triangles, cuts);
      some |= cuts > 0;
      none |= cuts == 0;
      for (int k = 0; k < 2; ++k) assert_near(rock->uv_sums[k], sums[k] * (double)turns[row].scale, 1e-6 * rock->triangles * 30);
    }
    assert_true(some && none);
    glb_scene_free(&scene);
  }
  lod = 0;
}

static void models_of_files_are_copied_with_their_colours(void** state) {
  (void)state;
  make_instances(models->count);
  for (int format = ROCK_FORMAT_INSTANCED; format <= ROCK_FORMAT_FLAT; ++format) {
    glb_scene scene;
    export_layer((rock_layer){.name = "trees", .models = models}, (rock_format)format);
    read_back(&scene);
    assert_int_equal(scene.material_count, 1);
    assert_false(scene.rocks[0].has_uvs);
    for (size_t i = 0; i < COUNT; ++i) {
      const uint32_t row = row_of(&scene.rocks[i]);
      const double scale = (double)turns[row].scale, step = 1.0 / (double)models->steps_per_metre;
      assert_int_equal(scene.rocks[i].triangles, MODEL_FILE_TRIANGLES);
      assert_near(scene.rocks[i].max[0], scale, scale * step);
      assert_near(scene.rocks[i].max[1], scale * (instances[row].asset == 0 ? 3 : 5), scale * step);
      assert_near((double)scene.rocks[i].base[1], 1, 1e-6);
      assert_false(scene.rocks[i].is_grey);
    }
    glb_scene_free(&scene);
  }
}

static int set_up(void** state) {
  (void)state;
  strcpy(folder, "/tmp/model-export-XXXXXX");
  if (mkdtemp(folder) == NULL) return -1;
  snprintf(file, sizeof file, "%s/out.glb", folder);
  size_t size;
  bytes = test_model_pack_make(NULL, &size);
  if (scree_pack_open_memory(bytes, size, NULL, &pack) != SCREE_OK) return -1;
  cliff_bytes = test_model_pack_make(&(test_models_desc){.cliff = true, .variants = 4}, &size);
  if (scree_pack_open_memory(cliff_bytes, size, NULL, &cliff) != SCREE_OK) return -1;
  char path[2][96], scene_file[96];
  static const char text[] =
      "{\"fields\": [{\"models\": [\"a.glb\", \"b.glb\"], \"spacing\": 1, \"support\": {\"shape\": \"box\"}}]}";
  for (int i = 0; i < 2; ++i) {
    snprintf(path[i], sizeof path[i], "%s/%c.glb", folder, 'a' + i);
    if (!model_file_write(path[i], 1, i == 0 ? 3 : 5)) return -1;
  }
  snprintf(scene_file, sizeof scene_file, "%s/s.json", folder);
  scene_model scene;
  scree_error error = {""};
  const scene_paths paths = {.scene = scene_file};
  if (scene_parse(text, sizeof text - 1, scene_file, &scene, &error) != SCREE_OK) return -1;
  const scree_result result = scene_models_create(&scene, 0, &paths, &models, &error);
  scene_destroy(&scene);
  for (int i = 0; i < 2; ++i) remove(path[i]);
  if (result != SCREE_OK) print_error("%s\n", error.message);
  return result == SCREE_OK ? 0 : -1;
}

static int tear_down(void** state) {
  (void)state;
  scree_pack_close(pack);
  free(bytes);
  scree_pack_close(cliff);
  free(cliff_bytes);
  scene_models_destroy(models);
  remove(file);
  return rmdir(folder);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(models_of_a_pack_are_turned_and_scaled),
      cmocka_unit_test(cliffs_have_uvs_and_cuts_of_their_own),
      cmocka_unit_test(models_of_files_are_copied_with_their_colours),
  };
  return cmocka_run_group_tests(tests, set_up, tear_down);
}
