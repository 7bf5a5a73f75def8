/* The parts of a cliff: which fields and which mesh shapes go along when its time is moved. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* after the four above */
#include <cmocka.h>

#include "edit.h"
#include "scene_live.h"

static const char* scenes_folder;
static bool memory_is_short;

void* __real_realloc(void* block, size_t size);
void* __wrap_realloc(void* block, size_t size);
void* __wrap_realloc(void* block, size_t size) {
  return memory_is_short ? NULL : __real_realloc(block, size);
}

typedef struct bench {
  scene_model scene;
  editor edit;
} bench;

static void bench_open(bench* b, const char* fields) {
  char text[4096];
  scree_error error = {""};
  const int length = snprintf(text, sizeof text, "{\"fields\": [%s]}", fields);
  assert_in_range(length, 1, sizeof text - 1);
  if (scene_parse(text, (size_t)length, "test", &b->scene, &error) != SCREE_OK) fail_msg("%s", error.message);
  edit_begin(&b->edit, &b->scene);
}

static void bench_close(bench* b) {
  edit_end(&b->edit);
  scene_destroy(&b->scene);
}

#define CLIFF(pack, time, x, more) "{\"pack\": \"" pack "\", \"time\": " time ", \"origin\": [" x ", 2, 3]" more "}"
#define MESH(pack, time, more) "{\"shape\": \"mesh\", \"pack\": \"" pack "\", \"time\": " time more "}"
#define SCREE(support) "{\"pack\": \"boulders\", \"cell_size\": 1, \"support\": " support "}"
#define AT(x) ", \"position\": [" x ", 2, 3]"

static void assert_parts(const bench* b, uint32_t field, uint64_t fields, uint64_t supports, uint32_t meshes) {
  cliff_parts parts;
  assert_true(cliff_parts_find(&b->scene, field, &parts));
  assert_int_equal(parts.fields, fields);
  assert_int_equal(parts.supports, supports);
  assert_int_equal(parts.mesh_count, meshes);
  cliff_parts_free(&parts);
}

static void fields_of_one_pack_time_and_place_are_parts(void** state) {
  (void)state;
  bench b;
  bench_open(&b, CLIFF("hill", "1", "0", ", \"what\": \"blocks\"") "," CLIFF("hill", "1", "0", ", \"what\": \"standing\"") ","
             /* none of these is the same cliff: */
             CLIFF("wall", "1", "0", "") "," CLIFF("hill", "2", "0", "") "," CLIFF("hill", "1", "9", "") "," CLIFF(
                 "hill", "1", "0", ", \"turn\": 90") "," CLIFF("hill", "1", "0", ", \"scale\": 2") ","
             /* but this one is, whatever its seed: */
             CLIFF("hill", "1", "0", ", \"seed\": 7"));
  for (uint32_t field = 0; field < 8; ++field) {
    const bool is_part = field < 2 || field == 7;
    assert_parts(&b, field, is_part ? 0x83 : UINT64_C(1) << field, 0, 0);
  }
  bench_close(&b);
}

static void meshes_are_parts_wherever_in_a_support_they_are(void** state) {
  (void)state;
  bench b;
  bench_open(&b, CLIFF("hill", "1", "0", "") ","
                 SCREE(MESH("hill", "1", AT("0"))) ","
                 SCREE("{\"shape\": \"difference\", \"children\": [{\"shape\": \"noise\", \"child\": " MESH("hill", "1", "") "},"
                       " {\"shape\": \"sphere\"}, " MESH("hill", "1", ", \"lod\": 2") "]}") ","
                 SCREE("{\"shape\": \"sphere\"}") ","
                 "{\"pack\": \"goblin\", \"spacing\": 2, \"support\": " MESH("hill", "1", "") "}");
  assert_parts(&b, 0, 1, 0x16, 4);
  bench_close(&b);
}

static void meshes_of_another_pack_or_time_or_of_a_file_are_none(void** state) {
  (void)state;
  bench b;
  bench_open(&b, CLIFF("hill", "1", "0", "") "," SCREE(MESH("hill", "0", AT("0"))) "," SCREE(MESH("wall", "1", AT("0"))) "," SCREE(
                     "{\"shape\": \"mesh\", \"file\": \"hill\"}"));
  assert_parts(&b, 0, 1, 0, 0);
  bench_close(&b);
}

/* Two cliffs of one pack at one time: each takes the meshes that stand where it stands, through all that is above them. */
static void mesh_goes_with_the_nearest_cliff_of_its_pack(void** state) {
  (void)state;
  bench b;
  bench_open(&b, CLIFF("hill", "1", "0", "") "," CLIFF("hill", "1", "40", ", \"turn\": 90") "," SCREE(
                     MESH("hill", "1", AT("0") ", \"scale\": 1.05")) "," /* a little larger, as a margin */
             SCREE("{\"shape\": \"union\", \"position\": [39, 2, 3], \"rotation\": [0, 90, 0], \"scale\": 2, \"children\": [" MESH(
                 "hill", "1", ", \"position\": [0, 0, 0.5], \"scale\": 0.5") "]}"));
  assert_parts(&b, 0, 1, 4, 1);
  assert_parts(&b, 1, 2, 8, 1);
  bench_close(&b);
}

static void turn_tells_cliffs_at_one_origin_apart(void** state) {
  (void)state;
  bench b;
  bench_open(&b, CLIFF("hill", "1", "0", "") "," CLIFF("hill", "1", "0", ", \"turn\": 180") "," SCREE(
                     MESH("hill", "1", AT("0") ", \"rotation\": [0, 180, 0]")) "," SCREE(MESH("hill", "1", AT("0"))));
  assert_parts(&b, 0, 1, 8, 1);
  assert_parts(&b, 1, 2, 4, 1);
  bench_close(&b);
}

/* The mesh at 40 belongs to the cliff there, although that one is at another time. */
static void mesh_of_a_cliff_at_another_time_stays_with_it(void** state) {
  (void)state;
  bench b;
  bench_open(&b, CLIFF("hill", "1", "0", "") "," CLIFF("hill", "2", "40", "") "," SCREE(MESH("hill", "1", AT("40"))));
  assert_parts(&b, 0, 1, 0, 0);
  assert_parts(&b, 1, 2, 0, 0);
  bench_close(&b);
}

static void fields_that_show_no_cliff_have_no_parts(void** state) {
  (void)state;
  bench b;
  cliff_parts parts;
  bench_open(&b, CLIFF("hill", "1", "0", "") "," SCREE(MESH("hill", "1", "")));
  for (uint32_t field = 1; field < 3; ++field) {
    b.edit.field = field;
    assert_false(cliff_parts_find(&b.scene, field, &parts));
    assert_int_equal(parts.fields, 0);
    assert_null(parts.meshes);
    assert_false(edit_cliff_time(&b.edit, 0));
  }
  assert_false(b.edit.unsaved);
  bench_close(&b);
}

static void short_memory_moves_nothing(void** state) {
  (void)state;
  bench b;
  cliff_parts parts;
  bench_open(&b, CLIFF("hill", "1", "0", "") "," SCREE(MESH("hill", "1", "")));
  memory_is_short = true;
  const bool found = cliff_parts_find(&b.scene, 0, &parts), moved = edit_cliff_time(&b.edit, 0);
  memory_is_short = false;
  assert_false(found);
  assert_null(parts.meshes);
  assert_false(moved);
  assert_int_equal(b.scene.fields[0].cliff.time, 1);
  bench_close(&b);
}

static void time_moves_every_part_and_says_what_has_changed(void** state) {
  (void)state;
  bench b;
  bench_open(&b, CLIFF("hill", "3", "0", ", \"what\": \"blocks\"") "," SCREE(MESH("hill", "3", "")) "," CLIFF(
                     "hill", "3", "0", ", \"what\": \"standing\"") "," CLIFF("hill", "3", "99", ""));
  b.edit.field = 2;
  assert_false(edit_cliff_time(&b.edit, 3)); /* where it is */
  assert_false(b.edit.unsaved);
  assert_true(edit_cliff_time(&b.edit, 1));
  assert_int_equal(b.scene.fields[0].cliff.time, 1);
  assert_int_equal(b.scene.fields[1].support->mesh.time, 1);
  assert_int_equal(b.scene.fields[2].cliff.time, 1);
  assert_int_equal(b.scene.fields[3].cliff.time, 3);
  assert_int_equal(b.edit.changed[0], SCENE_CHANGED_PACK);
  assert_int_equal(b.edit.changed[1], SCENE_CHANGED_SUPPORT);
  assert_int_equal(b.edit.changed[2], SCENE_CHANGED_PACK);
  assert_int_equal(b.edit.changed[3], 0);
  assert_true(b.edit.unsaved);
  bench_close(&b);
}

static void one_step_of_undo_takes_every_part_back(void** state) {
  (void)state;
  bench b;
  bench_open(&b, CLIFF("hill", "3", "0", "") "," SCREE(MESH("hill", "3", "")));
  edit_commit(&b.edit);
  assert_true(edit_cliff_time(&b.edit, 2));
  assert_true(edit_cliff_time(&b.edit, 1));
  edit_commit(&b.edit);
  assert_true(edit_undo(&b.edit));
  assert_int_equal(b.scene.fields[0].cliff.time, 3);
  assert_int_equal(b.scene.fields[1].support->mesh.time, 3);
  assert_true(edit_redo(&b.edit));
  assert_int_equal(b.scene.fields[0].cliff.time, 1);
  assert_int_equal(b.scene.fields[1].support->mesh.time, 1);
  bench_close(&b);
}

/* In one step the cliff passes a time that others at its place are at; with a step's end there it has become one with them. */
static void parts_are_those_of_the_time_that_the_step_began_at(void** state) {
  (void)state;
  for (int ends = 0; ends < 2; ++ends) {
    bench b;
    bench_open(&b, CLIFF("hill", "3", "0", "") "," CLIFF("hill", "2", "0", "") "," SCREE(MESH("hill", "2", "")));
    assert_true(edit_cliff_time(&b.edit, 2));
    if (ends == 1) edit_commit(&b.edit);
    assert_true(edit_cliff_time(&b.edit, 1));
    assert_int_equal(b.scene.fields[0].cliff.time, 1);
    assert_int_equal(b.scene.fields[1].cliff.time, ends == 1 ? 1 : 2);
    assert_int_equal(b.scene.fields[2].support->mesh.time, ends == 1 ? 1 : 2);
    bench_close(&b);
  }
}

/* A step that goes on after the tree was changed holds no node that is gone. */
static void deleted_mesh_is_let_go(void** state) {
  (void)state;
  bench b;
  bench_open(&b, CLIFF("hill", "3", "0",
                       "") "," SCREE("{\"shape\": \"union\", \"children\": [{\"shape\": \"sphere\"}, " MESH("hill", "3", "") "]}"));
  assert_true(edit_cliff_time(&b.edit, 2));
  b.edit.field = 1;
  b.edit.node = b.scene.fields[1].support->children[1];
  assert_int_equal(b.edit.cliff.mesh_count, 1);
  assert_true(edit_delete(&b.edit));
  assert_int_equal(b.edit.cliff.mesh_count, 0);
  b.edit.field = 0;
  assert_true(edit_cliff_time(&b.edit, 1));
  assert_int_equal(b.scene.fields[0].cliff.time, 1);
  bench_close(&b);
}

static uint32_t count_of(const char* text, const char* words) {
  uint32_t count = 0;
  for (const char* at = text; (at = strstr(at, words)) != NULL; at += strlen(words)) ++count;
  return count;
}

/* The scenes that ship: from whichever field it is moved, a saved scene has nothing left at the time before. */
static void saved_scene_has_every_part_at_the_new_time(void** state) {
  (void)state;
  static const struct {
    const char* file;
    const char *before, *after;
    uint32_t parts;
  } cases[] = {{"hill_cave.json", "\"time\": 3", "\"time\": 1", 4},
               {"basalt_wall.json", "\"time\": 2", "\"time\": 1", 4},
               {"tilted_slabs.json", "\"time\": 2", "\"time\": 1", 4}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
    for (uint32_t field = 0; field < 3; field += 2) {
      char file[1024];
      bench b;
      scree_error error = {""};
      snprintf(file, sizeof file, "%s/%s", scenes_folder, cases[i].file);
      if (scene_load(file, &b.scene, &error) != SCREE_OK) fail_msg("%s", error.message);
      edit_begin(&b.edit, &b.scene);
      b.edit.field = field;
      assert_true(edit_cliff_time(&b.edit, 1));
      char* text = scene_write(&b.scene, NULL);
      assert_non_null(text);
      assert_int_equal(count_of(text, cases[i].before), 0);
      assert_int_equal(count_of(text, cases[i].after), cases[i].parts);
      free(text);
      bench_close(&b);
    }
}

int main(int argc, char** argv) {
  if (argc != 2) return fprintf(stderr, "usage: %s SCENES\n", argv[0]), 2;
  scenes_folder = argv[1];
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(fields_of_one_pack_time_and_place_are_parts),
      cmocka_unit_test(meshes_are_parts_wherever_in_a_support_they_are),
      cmocka_unit_test(meshes_of_another_pack_or_time_or_of_a_file_are_none),
      cmocka_unit_test(mesh_goes_with_the_nearest_cliff_of_its_pack),
      cmocka_unit_test(turn_tells_cliffs_at_one_origin_apart),
      cmocka_unit_test(mesh_of_a_cliff_at_another_time_stays_with_it),
      cmocka_unit_test(fields_that_show_no_cliff_have_no_parts),
      cmocka_unit_test(short_memory_moves_nothing),
      cmocka_unit_test(time_moves_every_part_and_says_what_has_changed),
      cmocka_unit_test(one_step_of_undo_takes_every_part_back),
      cmocka_unit_test(parts_are_those_of_the_time_that_the_step_began_at),
      cmocka_unit_test(deleted_mesh_is_let_go),
      cmocka_unit_test(saved_scene_has_every_part_at_the_new_time),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
