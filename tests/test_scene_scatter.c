/* Scatters in scenes: models of packs and of files stand on their ground, rocks make room, updates and mistakes. */
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

#include "make_model_pack.h"
#include "make_pack.h"
#include "model_file.h"
#include "scene_live.h"

static char folder[64];

typedef struct opened {
  scene_model scene;
  scene_live* world;
  char file[96];
  scene_rocks rocks;
} opened;

static scree_result open_scene(opened* o, const char* text, scree_error* error) {
  *o = (opened){.world = NULL};
  snprintf(o->file, sizeof o->file, "%s/s.json", folder);
  if (scene_parse(text, strlen(text), o->file, &o->scene, error) != SCREE_OK) fail_msg("%s", error->message);
  const scene_live_desc desc = {.scene = &o->scene, .paths = {.scene = o->file, .packs = folder, .data = folder}};
  assert_int_equal(scene_live_create(&desc, &o->world, error), SCREE_OK);
  return scene_live_update_all(o->world, error);
}

static void open_well(opened* o, const char* text) {
  scree_error error = {""};
  if (open_scene(o, text, &error) != SCREE_OK) fail_msg("%s", error.message);
}

static void close_scene(opened* o) {
  scene_rocks_free(&o->rocks);
  scene_live_destroy(o->world);
  scene_destroy(&o->scene);
}

static uint64_t ask(opened* o, uint32_t field) {
  static const double zero[3] = {0, 0, 0};
  scree_error error = {""};
  if (scene_live_query(o->world, field, zero, 0, 1000000, &o->rocks, &error) != SCREE_OK) fail_msg("%s", error.message);
  return o->rocks.count;
}

#define GROUND "\"support\": {\"shape\": \"box\", \"half\": [60, 2, 60], \"position\": [0, -1, 0]}"
#define HOODOOS(more) "{\"pack\": \"models\", \"spacing\": 9, \"seed\": 3" more ", " GROUND "}"
#define TREES(more) "{\"models\": [\"tree.glb\", \"bush.glb\"], \"spacing\": 9, \"seed\": 3" more ", " GROUND "}"
#define ROCKS \
  "{\"pack\": \"rocks\", \"cell_size\": 1, \"support\": {\"shape\": \"box\", \"half\": [40, 1, 40], \"position\": [0, 1.5, 0]}}"

/* Between the most discs of half the spacing that fit into the ground and half as dense. */
static void assert_stand(opened* o, uint32_t field, double spacing, uint32_t models) {
  const uint64_t count = ask(o, field);
  assert_in_range(count, (uint64_t)(0.5 * 120 * 120 / (spacing * spacing)), (uint64_t)(1.1 * 120 * 120 / (spacing * spacing)));
  for (uint64_t i = 0; i < count; ++i) {
    const scree_rock* a = &o->rocks.rocks[i];
    assert_true(fabsf(a->position[1] - 1) < 0.05f);
    assert_in_range(a->asset, 0, models - 1);
    for (uint64_t k = 0; k < i; ++k) {
      const scree_rock* b = &o->rocks.rocks[k];
      const float dx = a->position[0] - b->position[0], dz = a->position[2] - b->position[2];
      assert_true((double)(dx * dx + dz * dz) >= 0.9999 * spacing * spacing);
    }
  }
}

static void models_of_a_pack_stand_on_the_ground(void** state) {
  (void)state;
  opened o;
  open_well(&o, "{\"fields\": [" HOODOOS("") "]}");
  assert_non_null(scene_live_scatter(o.world, 0));
  assert_null(scene_live_field(o.world, 0));
  assert_null(scene_live_models(o.world, 0));
  assert_stand(&o, 0, 9, scree_scatter_model_count(scene_live_scatter(o.world, 0)));
  close_scene(&o);
}

static void models_of_files_stand_on_the_ground(void** state) {
  (void)state;
  opened o;
  open_well(&o, "{\"fields\": [" TREES("") "]}");
  const scene_models* models = scene_live_models(o.world, 0);
  assert_non_null(models);
  assert_null(scene_live_pack(o.world, 0));
  assert_int_equal(models->count, 2);
  assert_true(models->shapes[0].height == 4 && fabsf(models->shapes[0].footprint_radius - 1.4142f) < 1e-3f);
  assert_int_equal(models->shapes[0].hull_count, 5);
  assert_stand(&o, 0, 9, 2);
  close_scene(&o);
}

static void models_of_files_keep_their_colours(void** state) {
  (void)state;
  opened o;
  open_well(&o, "{\"fields\": [" TREES("") "]}");
  const scene_models* models = scene_live_models(o.world, 0);
  const painted_mesh* mesh = &models->models[0].mesh;
  assert_int_equal(mesh->triangle_count, MODEL_FILE_TRIANGLES);
  scree_vertex vertices[3 * MODEL_FILE_TRIANGLES];
  uint16_t indices[3 * MODEL_FILE_TRIANGLES];
  scene_models_vertices(models, 0, vertices, indices);
  uint32_t red = 0, green = 0;
  for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
    red += vertices[i].material == 255 && vertices[i].durability == 0 && vertices[i].curvature == 0;
    green += vertices[i].material == 0 && vertices[i].durability == 255 && vertices[i].curvature == 0;
    for (int a = 0; a < 3; ++a)
      assert_true(fabsf((float)vertices[i].position[a] / models->steps_per_metre - mesh->positions[3 * i + (uint32_t)a]) < 1e-3f);
  }
  assert_true(red == 9 && green == 9);
  close_scene(&o);
}

static void rocks_make_room_for_models(void** state) {
  (void)state;
  opened o;
  open_well(&o, "{\"fields\": [" ROCKS "]}");
  const uint64_t alone = ask(&o, 0);
  close_scene(&o);
  open_well(&o, "{\"fields\": [" HOODOOS("") "," ROCKS "]}");
  const uint64_t models = ask(&o, 0), beside = ask(&o, 1);
  assert_in_range(beside, alone / 4, alone - 20);
  close_scene(&o);
  /* The other way round models give way. */
  open_well(&o, "{\"fields\": [" ROCKS "," HOODOOS("") "]}");
  assert_int_equal(ask(&o, 0), alone);
  assert_in_range(ask(&o, 1), 1, models - 20);
  close_scene(&o);
}

static void spacing_and_density_can_change(void** state) {
  (void)state;
  opened o;
  open_well(&o, "{\"fields\": [" TREES("") "]}");
  const uint64_t wide = ask(&o, 0);
  const scene_models* models = scene_live_models(o.world, 0);
  scree_error error = {""};
  o.scene.fields[0].scatter.spacing = 4.5;
  assert_int_equal(scene_live_update(o.world, 0, SCENE_CHANGED_PACK, &error), SCREE_OK);
  assert_in_range(ask(&o, 0), 3 * wide, 5 * wide);
  assert_ptr_equal(scene_live_models(o.world, 0), models); /* their files are not read again */
  o.scene.fields[0].density = 0.25;
  assert_int_equal(scene_live_update(o.world, 0, SCENE_CHANGED_RULES, &error), SCREE_OK);
  assert_in_range(ask(&o, 0), wide / 2, 3 * wide / 2);
  close_scene(&o);
}

static void weights_choose_models_and_variants(void** state) {
  (void)state;
  opened o;
  open_well(&o, "{\"fields\": [" TREES(", \"weights\": [0, 1]") "," HOODOOS(", \"origin\": [3, 0, 0], \"key\": 5") "]}");
  for (uint64_t i = ask(&o, 0); i-- > 0;) assert_int_equal(o.rocks.rocks[i].asset, 1);
  close_scene(&o);
  open_well(&o, "{\"fields\": [" HOODOOS(", \"weights\": [1, 0]") "]}");
  scree_model model;
  for (uint64_t i = ask(&o, 0); i-- > 0;) {
    assert_int_equal(scree_pack_get_model(scene_live_pack(o.world, 0), o.rocks.rocks[i].asset, &model), SCREE_OK);
    assert_int_equal(model.variant, 0);
  }
  close_scene(&o);
}

static void mistakes_are_told_by_field_and_key(void** state) {
  (void)state;
  static const struct {
    const char *text, *message;
    scree_result result;
  } cases[] = {
      {"{\"pack\": \"rocks\", \"spacing\": 3, " GROUND "}", "fields[0].pack: ", SCREE_ERROR_PACK_KIND},
      {"{\"pack\": \"models\", \"cell_size\": 3, " GROUND "}", "fields[0].pack: ", SCREE_ERROR_PACK_KIND},
      {"{\"pack\": \"cliff\", \"spacing\": 3, " GROUND "}", "cliff.scree holds a cliff, whose blocks lie", SCREE_ERROR_PACK_KIND},
      {"{\"pack\": \"cliff\", \"cell_size\": 3, " GROUND "}", "cliff.scree holds a cliff, which fills no shape",
       SCREE_ERROR_PACK_KIND},
      {"{\"models\": [\"tree.glb\", \"gone.glb\"], \"spacing\": 3, " GROUND "}",
       "fields[0].models[1]: \"gone.glb\" is neither beside the scene nor in the data folder", SCREE_ERROR_IO},
      {"{\"models\": [\"models.scree\"], \"spacing\": 3, " GROUND "}", "fields[0].models[0]: ", SCREE_ERROR_UNSUPPORTED},
      {"{\"models\": [\"flat.glb\"], \"spacing\": 3, " GROUND "}", "fields[0].models[0]: ", SCREE_ERROR_RANGE},
      {TREES(", \"weights\": [1, 2, 3]"), "fields[0].weights: expected 2 numbers, one a model", SCREE_ERROR_RANGE},
      {HOODOOS(", \"weights\": [1, 2, 3, 4, 5]"), "fields[0].weights: expected 2 numbers, one a variant, or", SCREE_ERROR_RANGE},
      {HOODOOS(", \"ages\": {\"file\": \"gone.png\"}"), "fields[0].ages: \"gone.png\" is neither", SCREE_ERROR_IO},
      {"{\"pack\": \"models\", \"spacing\": 3, \"support\": {\"shape\": \"half_space\"}}", "fields[0].support: it has no end",
       SCREE_ERROR_RANGE},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    char text[600];
    snprintf(text, sizeof text, "{\"fields\": [%s]}", cases[i].text);
    opened o;
    scree_error error = {""};
    const scree_result result = open_scene(&o, text, &error);
    if (result != cases[i].result || strstr(error.message, cases[i].message) == NULL)
      fail_msg("%s: %d, %s", cases[i].text, (int)result, error.message);
    close_scene(&o);
  }
}

static void too_many_models_are_refused_without_counting_them(void** state) {
  (void)state;
  opened o;
  open_well(&o, "{\"fields\": [{\"pack\": \"models\", \"spacing\": 0.01, " GROUND "}]}");
  scree_error error = {""};
  static const double zero[3] = {0, 0, 0};
  assert_int_equal(scene_live_query(o.world, 0, zero, 0, 1000000, &o.rocks, &error), SCREE_ERROR_RANGE);
  assert_non_null(strstr(error.message, "fields[0]: it has more than 1000000 models; enlarge spacing"));
  close_scene(&o);
}

static void write_bytes(const char* name, uint8_t* bytes, size_t size) {
  char path[96];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  FILE* file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(bytes, 1, size, file), size);
  assert_int_equal(fclose(file), 0);
  free(bytes);
}

static const char* const files[] = {"models.scree", "rocks.scree", "cliff.scree", "tree.glb", "bush.glb", "flat.glb"};

static int make_folder(void** state) {
  (void)state;
  strcpy(folder, "/tmp/scene-scatter-XXXXXX");
  if (mkdtemp(folder) == NULL) return -1;
  size_t size;
  uint8_t* bytes = test_model_pack_make(NULL, &size);
  write_bytes(files[0], bytes, size);
  bytes = test_pack_make(&(test_pack_desc){.cells_per_cube = 3}, &size);
  write_bytes(files[1], bytes, size);
  bytes = test_model_pack_make(&(test_models_desc){.cliff = true}, &size);
  write_bytes(files[2], bytes, size);
  static const float heights[] = {4, 1, -1}; /* the last points down */
  for (int i = 0; i < 3; ++i) {
    char path[96];
    snprintf(path, sizeof path, "%s/%s", folder, files[3 + i]);
    if (!model_file_write(path, 1, heights[i])) return -1;
  }
  return 0;
}

static int remove_folder(void** state) {
  (void)state;
  for (size_t i = 0; i < sizeof files / sizeof *files; ++i) {
    char path[96];
    snprintf(path, sizeof path, "%s/%s", folder, files[i]);
    remove(path);
  }
  return rmdir(folder);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(models_of_a_pack_stand_on_the_ground), cmocka_unit_test(models_of_files_stand_on_the_ground),
      cmocka_unit_test(models_of_files_keep_their_colours),   cmocka_unit_test(rocks_make_room_for_models),
      cmocka_unit_test(spacing_and_density_can_change),       cmocka_unit_test(weights_choose_models_and_variants),
      cmocka_unit_test(mistakes_are_told_by_field_and_key),   cmocka_unit_test(too_many_models_are_refused_without_counting_them),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
