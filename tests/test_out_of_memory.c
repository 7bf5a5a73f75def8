/* Every allocation of the programs' own code is made to fail once: each time there is an error that says so, and nothing else is
 * lost (the address sanitizer's build of this test finds what leaks). Linked with --wrap for malloc, calloc and realloc; memory of
 * cJSON, stb_image and the C++ files is not reached. */
#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* after the four above */
#include <cmocka.h>

#include "make_model_pack.h"
#include "make_pack.h"
#include "rock_export.h"
#include "scene_live.h"
#include "support_file.h"
#include "terrain.h"

void* __real_malloc(size_t size);
void* __real_calloc(size_t count, size_t size);
void* __real_realloc(void* memory, size_t size);
void* __wrap_malloc(size_t size);
void* __wrap_calloc(size_t count, size_t size);
void* __wrap_realloc(void* memory, size_t size);

static uint32_t countdown; /* the allocation that fails is the one that takes this to 0; 0 = none does */

static bool fails_now(void) {
  return countdown > 0 && --countdown == 0;
}

void* __wrap_malloc(size_t size) {
  return fails_now() ? NULL : __real_malloc(size);
}
void* __wrap_calloc(size_t count, size_t size) {
  return fails_now() ? NULL : __real_calloc(count, size);
}
void* __wrap_realloc(void* memory, size_t size) {
  return fails_now() ? NULL : __real_realloc(memory, size);
}

/* Runs `step` with its first, second, ... allocation failing until it needs fewer; `least` is how often that must be at least. */
static void fail_each(scree_result (*step)(scree_error* error), uint32_t least) {
  for (uint32_t nth = 1;; ++nth) {
    scree_error error = {""};
    countdown = nth;
    scree_result result = step(&error);
    bool reached = countdown == 0;
    countdown = 0;
    if (!reached) {
      assert_string_equal(error.message, "");
      assert_int_equal(result, SCREE_OK);
      assert_true(nth > least);
      return;
    }
    if (result != SCREE_ERROR_OUT_OF_MEMORY) fail_msg("allocation %u: %d, %s", nth, result, error.message);
    assert_non_null(strstr(error.message, "out of memory"));
  }
}

static const char scene_text[] =
    "{\"fields\": [{\"pack\": \"a\", \"support\": {\"shape\": \"union\", \"children\": ["
    "{\"shape\": \"blobs\", \"points\": [[0, 0, 0, 1]]}, {\"shape\": \"smooth_union\", \"children\": [{\"shape\": \"box\"}, "
    "{\"shape\": \"cone\"}]}]}},"
    "{\"pack\": \"b\", \"support\": {\"shape\": \"sphere\"}}]}";

static scree_result parse_scene(scree_error* error) {
  scene_model scene;
  scree_result result = scene_parse(scene_text, strlen(scene_text), "s.json", &scene, error);
  scene_destroy(&scene);
  return result;
}

static void reading_a_scene_survives(void** state) {
  (void)state;
  fail_each(parse_scene, 10);
}

static scene_model loaded;

static scree_result out_of_memory(scree_error* error) {
  strcpy(error->message, "out of memory");
  return SCREE_ERROR_OUT_OF_MEMORY;
}

static scree_result write_scene(scree_error* error) {
  char* text = scene_write(&loaded, NULL);
  bool good = text != NULL;
  free(text);
  return good ? SCREE_OK : out_of_memory(error);
}

static scree_result copy_tree(scree_error* error) {
  scene_node* copy = scene_node_copy(loaded.fields[0].support);
  bool good = copy != NULL;
  scene_node_destroy(copy);
  return good ? SCREE_OK : out_of_memory(error);
}

static scree_result compile_support(scree_error* error) {
  scree_support* support;
  scene_paths paths = {.scene = "s.json"};
  scree_result result = scene_support_create(&loaded, 0, &paths, NULL, NULL, NULL, &support, error);
  scree_support_destroy(support);
  return result;
}

static scree_result save_scene(scree_error* error) {
  return scene_save(&loaded, "/dev/null", error);
}

static void writing_and_copying_a_scene_survive(void** state) {
  (void)state;
  assert_int_equal(scene_parse(scene_text, strlen(scene_text), "s.json", &loaded, NULL), SCREE_OK);
  fail_each(write_scene, 1);
  fail_each(copy_tree, 5);
  fail_each(compile_support, 3);
  fail_each(save_scene, 2);
  scene_destroy(&loaded);
}

static scree_result read_obj(scree_error* error) {
  static const char text[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
  triangle_mesh mesh;
  scree_result result = mesh_read_obj(text, strlen(text), "m.obj", &mesh, error);
  if (result == SCREE_OK && triangle_mesh_weld(&mesh) != SCREE_OK) result = out_of_memory(error);
  triangle_mesh_free(&mesh);
  return result;
}

static scree_result read_mapped_obj(scree_error* error) {
  static const char text[] =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 1\nf 1/1 3/1 2/1\nf 1/1 2/1 4/1\nf 2/1 3/1 4/1\nf 3/1 1/1 4/1\n";
  triangle_mesh mesh;
  scree_result result = mesh_read_obj(text, strlen(text), "m.obj", &mesh, error);
  if (result == SCREE_OK) assert_non_null(mesh.uvs);
  if (result == SCREE_OK && triangle_mesh_weld(&mesh) != SCREE_OK) result = out_of_memory(error);
  triangle_mesh_free(&mesh);
  return result;
}

/* One triangle and its UVs, all zeros. */
static scree_result read_mapped_gltf(scree_error* error) {
  static const char text[] =
      "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"byteLength\": 36, \"uri\": "
      "\"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA\"}],"
      "\"bufferViews\": [{\"buffer\": 0, \"byteLength\": 36}], \"accessors\": ["
      "{\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\"},"
      "{\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC2\"}],"
      "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0, \"TEXCOORD_0\": 1}}]}],"
      "\"nodes\": [{\"mesh\": 0}], \"scenes\": [{\"nodes\": [0]}]}";
  triangle_mesh mesh;
  scree_result result = mesh_read_gltf(text, strlen(text), "m.gltf", &mesh, error);
  if (result == SCREE_OK) assert_non_null(mesh.uvs);
  triangle_mesh_free(&mesh);
  return result;
}

static void reading_a_mesh_survives(void** state) {
  (void)state;
  fail_each(read_obj, 4);
  fail_each(read_mapped_obj, 6);
  fail_each(read_mapped_gltf, 3);
}

static struct {
  uint8_t* bytes;
  scree_pack* pack;
  rock_layer layer;
  scene_palette palette;
} given;

static scree_result open_and_query(scree_error* error) {
  static const double origin[3] = {0, 0, 0};
  const scene_live_desc desc = {.scene = &loaded, .paths = {.scene = "s.json", .packs = "."}};
  scene_live* live;
  scree_result result = scene_live_create(&desc, &live, error);
  if (result != SCREE_OK) return result;
  scene_rocks rocks = {.rocks = NULL};
  result = scene_live_update_all(live, error);
  for (uint32_t i = 0; i < 2 && result == SCREE_OK; ++i)
    result = scene_live_query(live, i, origin, SCREE_SCENE_VISIBLE, 1000000, &rocks, error);
  scene_rocks_free(&rocks);
  scene_live_destroy(live);
  return result;
}

static void opening_and_querying_a_scene_survives(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_pack_make(&(test_pack_desc){.cells_per_cube = 3}, &size);
  FILE* file = fopen("out_of_memory.scree", "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(bytes, 1, size, file), size);
  assert_int_equal(fclose(file), 0);
  free(bytes);
  static const char text[] =
      "{\"fields\": [{\"pack\": \"out_of_memory\", \"cell_size\": 0.5, \"support\": {\"shape\": \"tube\", \"points\": [[0, 0, 0, "
      "1], "
      "[2, 0, 0, 1]]}}, {\"pack\": \"out_of_memory\", \"cell_size\": 0.4, \"filters\": [{\"filter\": \"altitude\", \"to\": 3}], "
      "\"support\": {\"shape\": \"noise\", \"child\": {\"shape\": \"sphere\", \"radius\": 2}}}]}";
  assert_int_equal(scene_parse(text, strlen(text), "s.json", &loaded, NULL), SCREE_OK);
  fail_each(open_and_query, 8);
  scene_destroy(&loaded);
  assert_int_equal(remove("out_of_memory.scree"), 0);
}

static rock_format format;

static scree_result export_rocks(scree_error* error) {
  rock_export* file;
  rock_export_desc desc = {.path = "out_of_memory.glb", .format = format};
  scree_result result = rock_export_begin(&desc, &file, error);
  if (result != SCREE_OK) return result;
  result = rock_export_add(file, &given.layer, NULL, error);
  if (result == SCREE_OK) return rock_export_finish(file, NULL, error);
  rock_export_abort(file);
  return result;
}

static void exporting_rocks_survives(void** state) {
  (void)state;
  size_t size;
  given.bytes = test_pack_make(NULL, &size);
  assert_int_equal(scree_pack_open_memory(given.bytes, size, NULL, &given.pack), SCREE_OK);
  static const scree_instance instances[] = {{{0, 0, 0}, 0}, {{1, 0, 0}, 1}, {{2, 0, 0}, 0}, {{3, 1, 0}, 1}};
  static const uint32_t hashes[] = {1, 0x80000000u, 0xffffffffu, 7};
  given.palette = (scene_palette){.colours = {{1, 1, 1}, {0, 0, 0}}, .colour_count = 2, .variation = 0.5};
  given.layer = (rock_layer){.name = "rocks",
                             .pack = given.pack,
                             .cell_size = 1,
                             .palette = &given.palette,
                             .instances = instances,
                             .hashes = hashes,
                             .count = 4};
  format = ROCK_FORMAT_INSTANCED;
  fail_each(export_rocks, 20);
  format = ROCK_FORMAT_FLAT;
  fail_each(export_rocks, 20);
  scree_pack_close(given.pack);
  free(given.bytes);
  given.bytes = test_model_pack_make(&(test_models_desc){.cliff = true}, &size);
  assert_int_equal(scree_pack_open_memory(given.bytes, size, NULL, &given.pack), SCREE_OK);
  given.layer.pack = given.pack;
  for (int form = ROCK_FORMAT_INSTANCED; form <= ROCK_FORMAT_FLAT; ++form) {
    format = (rock_format)form;
    fail_each(export_rocks, 25);
  }
  assert_int_equal(remove("out_of_memory.glb"), 0);
  scree_pack_close(given.pack);
  free(given.bytes);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(reading_a_scene_survives),
      cmocka_unit_test(writing_and_copying_a_scene_survive),
      cmocka_unit_test(reading_a_mesh_survives),
      cmocka_unit_test(exporting_rocks_survives),
      cmocka_unit_test(opening_and_querying_a_scene_survives),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
