/* Exported .glb files hold what the query found: read back by other code (glb_scene.cpp) and compared rock by rock. */
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
#include <math.h>
#include <scree/threads.h>

#include "file.h"
#include "glb_scene.h"
#include "make_pack.h"
#include "rock_export.h"

enum { LAYERS = 2, LODS = 3 };

static char folder[64];

/* Two fields of one pack with their rocks, one of them far from the world's origin. */
static struct {
  uint8_t* bytes;
  scree_pack* pack;
  scree_pack_info info;
  scene_palette palettes[LAYERS];
  rock_layer layers[LAYERS];
  uint64_t total;
} given;

static const scene_palette greys = {
    .colours = {{0.5f, 0.4f, 0.3f}, {0.7f, 0.7f, 0.7f}, {0.2f, 0.25f, 0.3f}}, .colour_count = 3, .variation = 0.4};
static const scene_palette plain = {.colours = {{0.8f, 0.1f, 0.1f}}, .colour_count = 1, .variation = 0};

static bool fill_layer(rock_layer* layer, double cell_size, uint64_t seed) {
  scree_field* field;
  scree_support* support;
  scree_shape ball = {.kind = SCREE_SHAPE_SPHERE, .sphere = {.radius = 6.0f * (float)cell_size}};
  scree_field_desc field_desc = {.pack = given.pack, .seed = seed, .cell_size = cell_size};
  scree_support_desc support_desc = {.shapes = &ball, .shape_count = 1};
  memcpy(support_desc.origin, layer->origin, sizeof support_desc.origin);
  if (scree_field_create(&field_desc, NULL, &field) != SCREE_OK) return false;
  if (scree_support_create(&support_desc, NULL, &support, NULL) != SCREE_OK) return false;
  scree_query_desc query = {.field = field, .support = support};
  memcpy(query.origin, layer->origin, sizeof query.origin);
  uint64_t count = 0;
  if (scree_query_count(&query, &count) != SCREE_OK || count < 100) return false;
  scree_instance* instances = malloc(count * sizeof *instances);
  scree_id* ids = malloc(count * sizeof *ids);
  uint32_t* hashes = malloc(count * sizeof *hashes);
  bool good = scree_query_fill(&query, instances, ids, count, &count) == SCREE_OK;
  for (uint64_t i = 0; i < count; ++i) hashes[i] = scree_world_hash(field, &ids[i]);
  free(ids);
  layer->pack = given.pack;
  layer->cell_size = cell_size;
  layer->instances = instances;
  layer->hashes = hashes;
  layer->count = count;
  given.total += count;
  scree_field_destroy(field);
  scree_support_destroy(support);
  return good;
}

static int set_up(void** state) {
  (void)state;
  snprintf(folder, sizeof folder, "rock_export_XXXXXX");
  if (mkdtemp(folder) == NULL) return 1;
  size_t size;
  test_pack_desc desc = {.cells_per_cube = 3, .lod_count = LODS, .shapes = 40};
  given.bytes = test_pack_make(&desc, &size);
  if (scree_pack_open_memory(given.bytes, size, NULL, &given.pack) != SCREE_OK) return 1;
  scree_pack_get_info(given.pack, &given.info);
  given.palettes[0] = greys;
  given.palettes[1] = plain;
  given.layers[0] = (rock_layer){.name = "near \"quoted\"", .palette = &given.palettes[0]};
  given.layers[1] = (rock_layer){.name = "far", .palette = &given.palettes[1], .origin = {70000, -3, 250.5}};
  return fill_layer(&given.layers[0], 0.5, 1) && fill_layer(&given.layers[1], 1.25, 2) ? 0 : 1;
}

static int tear_down(void** state) {
  (void)state;
  for (int i = 0; i < LAYERS; ++i) {
    free((void*)given.layers[i].instances);
    free((void*)given.layers[i].hashes);
  }
  scree_pack_close(given.pack);
  free(given.bytes);
  char command[96];
  snprintf(command, sizeof command, "rm -r '%s'", folder);
  return system(command);
}

static void export_layers(const char* path, rock_format format, uint32_t lod, uint32_t threads, const rock_layer* layers,
                          rock_export_stats* stats) {
  scree_error error = {""};
  rock_export* file;
  rock_export_desc desc = {.path = path, .format = format, .lod = lod};
  scree_threads* pool = NULL;
  if (threads > 0) assert_int_equal(scree_threads_create(threads - 1, NULL, &pool), SCREE_OK);
  desc.jobs = scree_threads_jobs(pool);
  scree_result result = rock_export_begin(&desc, &file, &error);
  for (int i = 0; i < LAYERS && result == SCREE_OK; ++i) result = rock_export_add(file, &layers[i], NULL, &error);
  if (result == SCREE_OK) result = rock_export_finish(file, stats, &error);
  assert_string_equal(error.message, "");
  assert_int_equal(result, SCREE_OK);
  scree_threads_destroy(pool);
}

static void export_all(const char* path, rock_format format, uint32_t lod, uint32_t threads, rock_export_stats* stats) {
  export_layers(path, format, lod, threads, given.layers, stats);
}

static void export_empty(const char* path, rock_format format) {
  rock_layer layers[LAYERS];
  memcpy(layers, given.layers, sizeof layers);
  for (int i = 0; i < LAYERS; ++i) layers[i].count = 0;
  export_layers(path, format, 0, 0, layers, NULL);
}

typedef struct expected_rock {
  double position[3];
  uint32_t layer, row;
} expected_rock;

/* Orders places along x, then y, then z, with a grid coarse enough that rounding does not matter. */
static int compare_places(const double* a, const double* b) {
  for (int k = 0; k < 3; ++k) {
    double x = floor(a[k] * 16 + 0.5), y = floor(b[k] * 16 + 0.5);
    if (x != y) return x < y ? -1 : 1;
  }
  return 0;
}

static int compare_expected(const void* a, const void* b) {
  return compare_places(((const expected_rock*)a)->position, ((const expected_rock*)b)->position);
}

static int compare_found(const void* a, const void* b) {
  return compare_places(((const glb_rock*)a)->position, ((const glb_rock*)b)->position);
}

static expected_rock* expected_rocks(void) {
  expected_rock* rocks = malloc(given.total * sizeof *rocks);
  uint64_t n = 0;
  for (uint32_t l = 0; l < LAYERS; ++l) {
    for (uint32_t i = 0; i < given.layers[l].count; ++i) {
      expected_rock* rock = &rocks[n++];
      *rock = (expected_rock){.layer = l, .row = i};
      for (int k = 0; k < 3; ++k) rock->position[k] = given.layers[l].origin[k] + (double)given.layers[l].instances[i].position[k];
    }
  }
  qsort(rocks, given.total, sizeof *rocks, compare_expected);
  return rocks;
}

static void assert_near(double a, double b, double tolerance) {
  if (!(fabs(a - b) <= tolerance)) fail_msg("%.9g is not within %g of %.9g", a, tolerance, b);
}

static void compare_rock(const glb_rock* rock, const expected_rock* expected, rock_format format, uint32_t lod) {
  const rock_layer* layer = &given.layers[expected->layer];
  uint32_t asset = layer->instances[expected->row].asset;
  for (int k = 0; k < 3; ++k) assert_near(rock->position[k], expected->position[k], 1e-5);
  scree_lod level;
  scree_asset record;
  assert_int_equal(scree_pack_get_lod(given.pack, asset, lod, &level), SCREE_OK);
  assert_int_equal(scree_pack_get_asset(given.pack, asset, &record), SCREE_OK);
  assert_int_equal(rock->triangles, level.triangles);
  assert_int_equal(rock->vertices, level.vertices);
  assert_true(rock->volume > 0);
  assert_true(rock->is_grey && rock->turn[0] == 0 && rock->turn[1] == 1);
  for (int k = 0; k < 3 && lod == 0; ++k) {
    assert_near(rock->min[k], (double)record.bounds_min[k] * layer->cell_size, 1e-5);
    assert_near(rock->max[k], (double)record.bounds_max[k] * layer->cell_size, 1e-5);
  }
  float colour[3], shade;
  uint32_t base;
  scene_stone_colour(layer->palette, layer->hashes[expected->row], colour, &base, &shade);
  /* Instanced rocks have their own shade; flat ones the middle of the span that it lies in. */
  double off = format == ROCK_FORMAT_FLAT ? layer->palette->variation / 8 + 1e-5 : 1e-5;
  for (int k = 0; k < 3; ++k) {
    float linear = scene_linear_from_srgb(layer->palette->colours[base][k]);
    assert_near((double)rock->colour[k], (double)colour[k], off * (double)linear);
    if (format == ROCK_FORMAT_INSTANCED) assert_near((double)rock->base[k], (double)linear, 1e-5);
  }
}

static void compare_file(const char* path, rock_format format, uint32_t lod) {
  glb_scene scene;
  int good = glb_scene_load(path, &scene);
  assert_string_equal(scene.message, "");
  assert_true(good);
  assert_int_equal(scene.rock_count, given.total);
  assert_int_equal(scene.needs_draco, format == ROCK_FORMAT_INSTANCED);
  assert_int_equal(scene.needs_instancing, format == ROCK_FORMAT_INSTANCED);
  qsort(scene.rocks, scene.rock_count, sizeof *scene.rocks, compare_found);
  expected_rock* expected = expected_rocks();
  for (uint64_t i = 0; i < given.total; ++i) compare_rock(&scene.rocks[i], &expected[i], format, lod);
  free(expected);
  glb_scene_free(&scene);
}

static void exported_rocks_are_those_of_the_query(void** state) {
  (void)state;
  for (int format = ROCK_FORMAT_INSTANCED; format <= ROCK_FORMAT_FLAT; ++format) {
    for (uint32_t lod = 0; lod < LODS; ++lod) {
      char path[96];
      rock_export_stats stats;
      snprintf(path, sizeof path, "%s/rocks.glb", folder);
      export_all(path, (rock_format)format, lod, 2, &stats);
      assert_int_equal(stats.instances, given.total);
      compare_file(path, (rock_format)format, lod);
    }
  }
}

static uint32_t used_assets(const rock_layer* layer) {
  uint8_t* seen = calloc(given.info.asset_count, 1);
  uint32_t count = 0;
  for (uint64_t i = 0; i < layer->count; ++i) {
    uint32_t asset = layer->instances[i].asset;
    count += seen[asset] == 0;
    seen[asset] = 1;
  }
  free(seen);
  return count;
}

static void only_used_shapes_are_stored_and_each_once(void** state) {
  (void)state;
  uint32_t used = used_assets(&given.layers[0]) + used_assets(&given.layers[1]);
  for (int format = ROCK_FORMAT_INSTANCED; format <= ROCK_FORMAT_FLAT; ++format) {
    char path[96];
    rock_export_stats stats;
    glb_scene scene;
    snprintf(path, sizeof path, "%s/shapes.glb", folder);
    export_all(path, (rock_format)format, 2, 0, &stats);
    assert_true(glb_scene_load(path, &scene));
    assert_int_equal(stats.shapes, used);
    assert_int_equal(scene.shape_count, used);
    FILE* stream = fopen(path, "rb");
    fseek(stream, 0, SEEK_END);
    assert_int_equal(stats.bytes, ftell(stream));
    fclose(stream);
    /* Flat: a node a rock and one a layer. Instanced: a node a mesh and one a layer. */
    assert_int_equal(scene.node_count, (format == ROCK_FORMAT_FLAT ? given.total : scene.mesh_count) + LAYERS);
    assert_int_equal(scene.material_count, format == ROCK_FORMAT_FLAT ? 3 * 4 + 1 : 3 + 1);
    glb_scene_free(&scene);
  }
}

static void bytes_do_not_depend_on_the_number_of_threads(void** state) {
  (void)state;
  for (int format = ROCK_FORMAT_INSTANCED; format <= ROCK_FORMAT_FLAT; ++format) {
    char *first = NULL, *bytes;
    size_t first_size = 0, size;
    for (uint32_t threads = 0; threads <= 5; threads += threads == 0 ? 1 : 4) {
      char path[96];
      snprintf(path, sizeof path, "%s/threads.glb", folder);
      export_all(path, (rock_format)format, 1, threads, NULL);
      assert_int_equal(file_read(path, SIZE_MAX, &bytes, &size, NULL), SCREE_OK);
      if (first == NULL) {
        first = bytes;
        first_size = size;
        continue;
      }
      assert_int_equal(size, first_size);
      assert_memory_equal(bytes, first, size);
      free(bytes);
    }
    free(first);
  }
}

static void level_beyond_the_coarsest_gives_the_coarsest(void** state) {
  (void)state;
  char path[96];
  snprintf(path, sizeof path, "%s/coarse.glb", folder);
  export_all(path, ROCK_FORMAT_FLAT, 99, 2, NULL);
  compare_file(path, ROCK_FORMAT_FLAT, LODS - 1);
}

static void scene_without_rocks_is_still_a_file(void** state) {
  (void)state;
  for (int format = ROCK_FORMAT_INSTANCED; format <= ROCK_FORMAT_FLAT; ++format) {
    char path[96];
    snprintf(path, sizeof path, "%s/empty.glb", folder);
    export_empty(path, (rock_format)format);
    glb_scene scene;
    assert_true(glb_scene_load(path, &scene));
    assert_int_equal(scene.rock_count, 0);
    glb_scene_free(&scene);
  }
}

static uint32_t count_files(void) {
  char command[128], line[256];
  uint32_t count = 0;
  snprintf(command, sizeof command, "ls -A '%s'", folder);
  FILE* list = popen(command, "r");
  while (fgets(line, sizeof line, list) != NULL) ++count;
  pclose(list);
  return count;
}

static void given_up_export_leaves_nothing_behind(void** state) {
  (void)state;
  char path[96];
  snprintf(path, sizeof path, "%s/never.glb", folder);
  uint32_t before = count_files();
  rock_export* file;
  rock_export_desc desc = {.path = path};
  assert_int_equal(rock_export_begin(&desc, &file, NULL), SCREE_OK);
  assert_int_equal(rock_export_add(file, &given.layers[0], NULL, NULL), SCREE_OK);
  rock_export_abort(file);
  assert_int_equal(count_files(), before);
}

static void bad_asset_is_one_clear_line(void** state) {
  (void)state;
  char path[96];
  snprintf(path, sizeof path, "%s/bad.glb", folder);
  scree_instance instance = {.asset = given.info.asset_count};
  uint32_t hash = 0;
  rock_layer layer = given.layers[0];
  layer.instances = &instance;
  layer.hashes = &hash;
  layer.count = 1;
  rock_export* file;
  rock_export_desc desc = {.path = path};
  scree_error error = {""};
  assert_int_equal(rock_export_begin(&desc, &file, &error), SCREE_OK);
  assert_int_equal(rock_export_add(file, &layer, NULL, &error), SCREE_ERROR_INVALID_ARGUMENT);
  char expected[160];
  snprintf(expected, sizeof expected, "near \"quoted\": rock %u of the pack, level 0: invalid argument", given.info.asset_count);
  assert_string_equal(error.message, expected);
  rock_export_abort(file);
  assert_int_not_equal(access(path, F_OK), 0);
}

static void bad_place_is_known_before_the_work(void** state) {
  (void)state;
  rock_export* file;
  rock_export_desc desc = {.path = "no/such/folder/rocks.glb"};
  scree_error error = {""};
  assert_int_equal(rock_export_begin(&desc, &file, &error), SCREE_ERROR_IO);
  assert_null(file);
  assert_string_equal(error.message, "no/such/folder/rocks.glb: cannot write: No such file or directory");
}

int main(int argc, char** argv) {
  /* With an argument: only write files of each form, for the validator. */
  if (argc > 1) {
    if (set_up(NULL) != 0) return 1;
    for (int format = ROCK_FORMAT_INSTANCED; format <= ROCK_FORMAT_FLAT; ++format) {
      char path[512];
      snprintf(path, sizeof path, "%s-%s.glb", argv[1], format == ROCK_FORMAT_FLAT ? "flat" : "instanced");
      export_all(path, (rock_format)format, 0, 2, NULL);
      snprintf(path, sizeof path, "%s-empty-%s.glb", argv[1], format == ROCK_FORMAT_FLAT ? "flat" : "instanced");
      export_empty(path, (rock_format)format);
    }
    return tear_down(NULL);
  }
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(exported_rocks_are_those_of_the_query),
      cmocka_unit_test(only_used_shapes_are_stored_and_each_once),
      cmocka_unit_test(bytes_do_not_depend_on_the_number_of_threads),
      cmocka_unit_test(level_beyond_the_coarsest_gives_the_coarsest),
      cmocka_unit_test(scene_without_rocks_is_still_a_file),
      cmocka_unit_test(given_up_export_leaves_nothing_behind),
      cmocka_unit_test(bad_asset_is_one_clear_line),
      cmocka_unit_test(bad_place_is_known_before_the_work),
  };
  return cmocka_run_group_tests(tests, set_up, tear_down);
}
