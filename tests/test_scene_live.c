/* Scenes opened: fields become layers, the earlier wins, an update changes what it says, and what cannot be shown is told at once.
 */
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

#include "make_pack.h"
#include "scene_live.h"

static char folder[64];

typedef struct opened {
  scene_model scene;
  scene_live* world;
  char file[96];
} opened;

/* Opens a scene whose packs lie in the test's folder. */
static scree_result open_scene(opened* o, const char* text, scree_error* error) {
  snprintf(o->file, sizeof o->file, "%s/s.json", folder);
  assert_int_equal(scene_parse(text, strlen(text), o->file, &o->scene, error), SCREE_OK);
  const scene_live_desc desc = {.scene = &o->scene, .paths = {.scene = o->file, .packs = folder, .data = folder}};
  assert_int_equal(scene_live_create(&desc, &o->world, error), SCREE_OK);
  return scene_live_update_all(o->world, error);
}

static void open_well(opened* o, const char* text) {
  scree_error error = {""};
  if (open_scene(o, text, &error) != SCREE_OK) fail_msg("%s", error.message);
}

static void close_scene(opened* o) {
  scene_live_destroy(o->world);
  scene_destroy(&o->scene);
}

static const double zero[3] = {0, 0, 0};

static uint64_t count_of(opened* o, uint32_t field) {
  scene_rocks rocks = {.rocks = NULL};
  scree_error error = {""};
  if (scene_live_query(o->world, field, zero, 0, 1000000, &rocks, &error) != SCREE_OK) fail_msg("%s", error.message);
  uint64_t count = rocks.count;
  scene_rocks_free(&rocks);
  return count;
}

/* Two fields in balls at these places. */
#define BALL(name, x, radius, more)                                    \
  "{\"pack\": \"" name "\", \"cell_size\": 0.5, \"shell\": false" more \
  ", \"support\": {\"shape\": \"sphere\", \"radius\": " radius ", \"position\": [" x ", 0, 0]}}"

static void earlier_field_wins_where_two_meet(void** state) {
  (void)state;
  opened o = {.world = NULL};
  open_well(&o, "{\"fields\": [" BALL("one", "0", "2", "") "," BALL("two", "20", "3", ", \"seed\": 5") "]}");
  const uint64_t first = count_of(&o, 0), second = count_of(&o, 1);
  assert_in_range(first, 100, 1000000);
  /* The first moves into the second, which loses rocks; the first loses none of its own. */
  scree_error error;
  o.scene.fields[0].support->position[0] = 20;
  assert_int_equal(scene_live_update(o.world, 0, SCENE_CHANGED_SUPPORT, &error), SCREE_OK);
  const uint64_t inside = count_of(&o, 0);
  assert_in_range(inside, first - first / 4, first + first / 4);
  assert_in_range(count_of(&o, 1), 1, second - first / 2);
  o.scene.fields[0].support->position[0] = 0;
  assert_int_equal(scene_live_update(o.world, 0, SCENE_CHANGED_SUPPORT, &error), SCREE_OK);
  assert_int_equal(count_of(&o, 0), first);
  assert_int_equal(count_of(&o, 1), second);
  close_scene(&o);
}

static void density_and_filters_thin_out_a_field(void** state) {
  (void)state;
  opened o = {.world = NULL};
  open_well(&o, "{\"fields\": [" BALL("one", "0", "3", "") "]}");
  const uint64_t all = count_of(&o, 0);
  scree_error error;
  scene_field* field = &o.scene.fields[0];
  field->density = 0.5;
  assert_int_equal(scene_live_update(o.world, 0, SCENE_CHANGED_RULES, &error), SCREE_OK);
  assert_in_range(count_of(&o, 0), all * 4 / 10, all * 6 / 10);
  field->density = 1;
  scene_filter* filter = scene_add_filter(field, SCREE_FILTER_ALTITUDE);
  filter->from = 0;
  filter->to = 100;
  assert_int_equal(scene_live_update(o.world, 0, SCENE_CHANGED_RULES, &error), SCREE_OK);
  const uint64_t upper = count_of(&o, 0);
  assert_in_range(upper, all * 4 / 10, all * 6 / 10);
  filter->inverted = true;
  assert_int_equal(scene_live_update(o.world, 0, SCENE_CHANGED_RULES, &error), SCREE_OK);
  assert_int_equal(count_of(&o, 0), all - upper);
  close_scene(&o);
}

static void update_that_fails_leaves_the_field_as_it_was(void** state) {
  (void)state;
  opened o = {.world = NULL};
  open_well(&o, "{\"fields\": [" BALL("one", "0", "2", "") "," BALL("two", "1", "2", "") "]}");
  const uint64_t first = count_of(&o, 0), second = count_of(&o, 1);
  scree_error error;
  strcpy(o.scene.fields[0].pack, "gone");
  assert_int_equal(scene_live_update(o.world, 0, SCENE_CHANGED_PACK, &error), SCREE_ERROR_IO);
  assert_non_null(strstr(error.message, "fields[0].pack: there is no pack \"gone\""));
  strcpy(o.scene.fields[0].pack, "one");
  scene_filter* filter = scene_add_filter(&o.scene.fields[1], SCREE_FILTER_MASK);
  strcpy(filter->map.file, "gone.png");
  assert_int_equal(scene_live_update(o.world, 1, SCENE_CHANGED_RULES, &error), SCREE_ERROR_IO);
  assert_non_null(strstr(error.message, "fields[1].filters[0]: \"gone.png\" is neither beside"));
  assert_int_equal(count_of(&o, 0), first);
  assert_int_equal(count_of(&o, 1), second);
  close_scene(&o);
}

static void field_that_cannot_be_opened_does_not_take_others_along(void** state) {
  (void)state;
  opened o = {.world = NULL};
  scree_error error = {""};
  assert_int_equal(open_scene(&o, "{\"fields\": [" BALL("gone", "0", "2", "") "," BALL("two", "0", "2", "") "]}", &error),
                   SCREE_ERROR_IO);
  assert_non_null(strstr(error.message, "fields[0].pack"));
  assert_int_equal(scene_live_layer(o.world, 0), UINT32_MAX);
  assert_null(scene_live_field(o.world, 0));
  assert_int_equal(scene_live_layer(o.world, 1), 0);
  assert_in_range(count_of(&o, 1), 100, 1000000);
  scene_rocks rocks = {.rocks = NULL};
  assert_int_equal(scene_live_query(o.world, 0, zero, 0, 10, &rocks, &error), SCREE_ERROR_INVALID_ARGUMENT);
  close_scene(&o);
}

static void fields_of_one_pack_share_it(void** state) {
  (void)state;
  opened o = {.world = NULL};
  open_well(&o, "{\"fields\": [" BALL("one", "0", "1", "") "," BALL("two", "9", "1", "") "," BALL("one", "19", "1", "") "]}");
  assert_ptr_equal(scene_live_pack(o.world, 0), scene_live_pack(o.world, 2));
  assert_ptr_not_equal(scene_live_pack(o.world, 0), scene_live_pack(o.world, 1));
  assert_int_equal(scene_live_pack_slot(o.world, 0), scene_live_pack_slot(o.world, 2));
  close_scene(&o);
}

/* A mistake of scale: as many rocks as nobody could wait for are not counted one by one. */
static void too_many_rocks_are_refused_without_counting_them(void** state) {
  (void)state;
  static const char* const fields[] = {
      BALL("one", "0", "1e5", ""), BALL("one", "0", "1e5", ", \"threshold\": 0.3"),
      "{\"pack\": \"one\", \"cell_size\": 0.01, \"support\": {\"shape\": \"sphere\", \"radius\": 1e4}}"};
  for (size_t i = 0; i < 3; ++i) {
    char text[400];
    snprintf(text, sizeof text, "{\"fields\": [%s]}", fields[i]);
    opened o = {.world = NULL};
    open_well(&o, text);
    scene_rocks rocks = {.rocks = NULL};
    scree_error error = {""};
    assert_int_equal(scene_live_query(o.world, 0, zero, 0, 1000000, &rocks, &error), SCREE_ERROR_RANGE);
    assert_non_null(strstr(error.message, "fields[0]: it has more than 1000000 rocks"));
    scene_rocks_free(&rocks);
    close_scene(&o);
  }
}

/* The limit is a limit, not a guess. */
static void as_many_rocks_as_allowed_are_delivered(void** state) {
  (void)state;
  opened o = {.world = NULL};
  open_well(&o, "{\"fields\": [" BALL("one", "0", "3", "") "]}");
  const uint64_t all = count_of(&o, 0);
  scene_rocks rocks = {.rocks = NULL};
  scree_error error = {""};
  assert_int_equal(scene_live_query(o.world, 0, zero, 0, all, &rocks, &error), SCREE_OK);
  assert_int_equal(rocks.count, all);
  assert_int_equal(scene_live_query(o.world, 0, zero, 0, all - 1, &rocks, &error), SCREE_ERROR_RANGE);
  scene_rocks_free(&rocks);
  close_scene(&o);
}

static void support_without_end_is_refused(void** state) {
  (void)state;
  static const char* const shapes[] = {"{\"shape\": \"half_space\"}",
                                       "{\"shape\": \"union\", \"children\": [{\"shape\": \"sphere\"}, {\"shape\": \"pattern\"}]}"};
  for (size_t i = 0; i < 2; ++i) {
    char text[256];
    snprintf(text, sizeof text, "{\"fields\": [{\"pack\": \"one\", \"support\": %s}]}", shapes[i]);
    opened o = {.world = NULL};
    scree_error error = {""};
    assert_int_equal(open_scene(&o, text, &error), SCREE_ERROR_RANGE);
    assert_non_null(strstr(error.message, "fields[0].support: it has no end"));
    close_scene(&o);
  }
}

static void write_pack(const char* name, const test_pack_desc* desc) {
  char path[96];
  size_t size;
  uint8_t* bytes = test_pack_make(desc, &size);
  snprintf(path, sizeof path, "%s/%s.scree", folder, name);
  FILE* file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(bytes, 1, size, file), size);
  assert_int_equal(fclose(file), 0);
  free(bytes);
}

static int make_folder(void** state) {
  (void)state;
  strcpy(folder, "/tmp/scene-live-XXXXXX");
  if (mkdtemp(folder) == NULL) return -1;
  write_pack("one", &(test_pack_desc){.cells_per_cube = 3});
  write_pack("two", &(test_pack_desc){.cells_per_cube = 3, .rocks_per_cell = 2});
  return 0;
}

static int remove_folder(void** state) {
  (void)state;
  static const char* const files[] = {"one.scree", "two.scree"};
  for (size_t i = 0; i < 2; ++i) {
    char path[96];
    snprintf(path, sizeof path, "%s/%s", folder, files[i]);
    remove(path);
  }
  return rmdir(folder);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(earlier_field_wins_where_two_meet),
      cmocka_unit_test(density_and_filters_thin_out_a_field),
      cmocka_unit_test(update_that_fails_leaves_the_field_as_it_was),
      cmocka_unit_test(field_that_cannot_be_opened_does_not_take_others_along),
      cmocka_unit_test(fields_of_one_pack_share_it),
      cmocka_unit_test(too_many_rocks_are_refused_without_counting_them),
      cmocka_unit_test(as_many_rocks_as_allowed_are_delivered),
      cmocka_unit_test(support_without_end_is_refused),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
