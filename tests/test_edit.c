/* Editing a scene without a window: selection, dragging, adding, undo. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "edit.h"
#include "lattice.h"
#include "stage.h"

static const char scene_text[] =
    "{\"fields\": [{\"pack\": \"p\", \"cell_size\": 1, \"support\": {\"shape\": \"union\", \"position\": [10, 0, 0],"
    " \"rotation\": [0, 90, 0], \"scale\": 2, \"children\": ["
    "  {\"shape\": \"sphere\", \"radius\": 1, \"position\": [0, 1, 3]},"
    "  {\"shape\": \"union\", \"position\": [1, 0, 0], \"rotation\": [30, -20, 50], \"children\": ["
    "    {\"shape\": \"box\", \"half\": [4, 0.5, 4], \"position\": [0, -2, 0]},"
    "    {\"shape\": \"capsule\", \"a\": [0, 0, 0], \"b\": [0, 2, 0], \"radius\": 0.5, \"position\": [5, 5, 5]}]}]}},"
    " {\"pack\": \"p\", \"cell_size\": 1, \"support\": {\"shape\": \"cone\", \"radius\": 2, \"height\": 3}}]}";

typedef struct bench {
  scene_model scene;
  editor edit;
} bench;

static void bench_open(bench* b) {
  scree_error error = {""};
  if (scene_parse(scene_text, sizeof scene_text - 1, "test", &b->scene, &error) != SCREE_OK) fail_msg("%s", error.message);
  edit_begin(&b->edit, &b->scene);
}

static void bench_close(bench* b) {
  edit_end(&b->edit);
  scene_destroy(&b->scene);
}

static scene_node* root_of(bench* b, uint32_t field) {
  return b->scene.fields[field].support;
}

static void assert_near(const double* a, const double* b, double tolerance) {
  for (int i = 0; i < 3; ++i)
    if (!(fabs(a[i] - b[i]) <= tolerance)) fail_msg("(%g, %g, %g) is not (%g, %g, %g)", a[0], a[1], a[2], b[0], b[1], b[2]);
}

static void frames_nest_as_the_support_does(void** state) {
  (void)state;
  bench b;
  bench_open(&b);
  /* By hand: +90 degrees about y takes z to x; the sphere's (0, 1, 3), twice as large, stands at (10 + 6, 2, 0). */
  edit_frame own, parent;
  assert_true(edit_node_frame(root_of(&b, 0), root_of(&b, 0)->children[0], &own, &parent));
  assert_near(own.translation, (double[3]){16, 2, 0}, 1e-9);
  assert_near(parent.translation, (double[3]){10, 0, 0}, 1e-9);
  assert_float_equal(own.scale, 2, 1e-12);
  double there[3];
  edit_frame_point(&own, (double[3]){0, 0, 1}, there);
  assert_near(there, (double[3]){18, 2, 0}, 1e-9);
  assert_false(edit_node_frame(root_of(&b, 1), root_of(&b, 0), &own, NULL));

  /* And against the library's own transforms, through the distance of a deep leaf: its middle is as deep inside as it can be. */
  scene_node* capsule = root_of(&b, 0)->children[1]->children[1];
  assert_true(edit_node_frame(root_of(&b, 0), capsule, &own, NULL));
  edit_frame_point(&own, (double[3]){0, 1, 0}, there);
  scree_support* support;
  scree_error error;
  const scene_paths paths = {.scene = "test"};
  assert_int_equal(scene_support_create(&b.scene, 0, &paths, NULL, NULL, NULL, &support, &error), SCREE_OK);
  double origin[3];
  memcpy(origin, root_of(&b, 0)->position, sizeof origin);
  float x = (float)(there[0] - origin[0]), y = (float)(there[1] - origin[1]), z = (float)(there[2] - origin[2]), distance;
  scree_support_distance(support, &x, &y, &z, &distance, 1);
  assert_float_equal(distance, -1, 1e-4); /* radius 0.5 at scale 2 */
  scree_support_destroy(support);
  bench_close(&b);
}

static void stone_belongs_to_the_nearest_surface(void** state) {
  (void)state;
  bench b;
  bench_open(&b);
  const struct {
    scene_node* leaf;
    double local[3]; /* on its surface */
  } cases[] = {{root_of(&b, 0)->children[0], {0.6, 0.8, 0}},
               {root_of(&b, 0)->children[1]->children[0], {-3.5, 0.5, 3}},
               {root_of(&b, 0)->children[1]->children[0], {4, 0.1, -3}},
               {root_of(&b, 0)->children[1]->children[1], {0.5, 1.2, 0}}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    edit_frame own;
    double point[3];
    assert_true(edit_node_frame(root_of(&b, 0), cases[i].leaf, &own, NULL));
    edit_frame_point(&own, cases[i].local, point);
    assert_ptr_equal(edit_leaf_at(&b.scene, 0, point), cases[i].leaf);
  }
  assert_ptr_equal(edit_leaf_at(&b.scene, 1, (double[3]){100, 0, 0}), root_of(&b, 1));
  assert_null(edit_leaf_at(&b.scene, 2, (double[3]){0, 0, 0}));
  bench_close(&b);
}

static double random_between(uint64_t* seed, double low, double high) {
  *seed += UINT64_C(0x9e3779b97f4a7c15);
  return low + (high - low) * (double)(hash_mix(*seed) >> 11) / 9007199254740992.0;
}

/* Whatever stands between a node and the world, what was under the pointer stays under it. */
static void dragged_node_follows_the_pointer(void** state) {
  (void)state;
  uint64_t seed = 3;
  for (int round = 0; round < 200; ++round) {
    bench b;
    bench_open(&b);
    b.edit.node = root_of(&b, 0)->children[1]->children[round & 1];
    edit_frame before, after;
    assert_true(edit_node_frame(root_of(&b, 0), b.edit.node, &before, NULL));
    static const edit_drag_kind kinds[] = {EDIT_DRAG_GROUND, EDIT_DRAG_VERTICAL, EDIT_DRAG_X, EDIT_DRAG_Y, EDIT_DRAG_Z};
    edit_drag_kind kind = kinds[round % 5];
    double eye[3], grabbed[3], goal[3], direction[3];
    for (int a = 0; a < 3; ++a) {
      eye[a] = random_between(&seed, -30, 30) + (a == 1 ? 40 : 0);
      grabbed[a] = before.translation[a] + random_between(&seed, -2, 2);
      bool free = kind == EDIT_DRAG_GROUND ? a != 1 : kind == EDIT_DRAG_X ? a == 0 : kind == EDIT_DRAG_Z ? a == 2 : a == 1;
      goal[a] = grabbed[a] + (free ? random_between(&seed, -9, 9) : 0);
    }
    for (int a = 0; a < 3; ++a) direction[a] = goal[a] - eye[a];
    edit_drag_begin(&b.edit, kind, grabbed, 0.5);
    assert_true(edit_drag_to(&b.edit, eye, direction, 0.5));
    assert_true(edit_node_frame(root_of(&b, 0), b.edit.node, &after, NULL));
    double moved[3], wanted[3];
    for (int a = 0; a < 3; ++a) {
      moved[a] = after.translation[a] - before.translation[a];
      wanted[a] = goal[a] - grabbed[a];
    }
    assert_near(moved, wanted, 1e-6);
    assert_int_equal(b.edit.changed[0], SCENE_CHANGED_SUPPORT);
    assert_int_equal(b.edit.changed[1], 0);
    assert_true(b.edit.unsaved);
    edit_drag_end(&b.edit);
    assert_true(edit_undo(&b.edit));
    assert_true(edit_node_frame(root_of(&b, 0), b.edit.node, &after, NULL));
    assert_near(after.translation, before.translation, 1e-9);
    bench_close(&b);
  }
}

static void grabbing_an_arrow_moves_nothing_yet(void** state) {
  (void)state;
  bench b;
  bench_open(&b);
  b.edit.field = 1;
  b.edit.node = root_of(&b, 1);
  const double eye[3] = {7, 5, 9}, direction[3] = {-6, -4.5, -9}, place[3] = {0, 0, 0};
  edit_drag_begin(&b.edit, EDIT_DRAG_X, place, 0.5);
  edit_drag_grab(&b.edit, eye, direction);
  edit_drag_to(&b.edit, eye, direction, 0.5);
  assert_near(b.edit.node->position, place, 1e-9);
  bench_close(&b);
}

static void drag_above_the_horizon_is_ignored(void** state) {
  (void)state;
  bench b;
  bench_open(&b);
  b.edit.field = 1;
  b.edit.node = root_of(&b, 1);
  const double eye[3] = {0, 5, 20}, grabbed[3] = {0, 1, 1};
  edit_drag_begin(&b.edit, EDIT_DRAG_GROUND, grabbed, 0.5);
  assert_false(edit_drag_to(&b.edit, eye, (double[3]){0, 0.2, -1}, 0.5));
  assert_false(edit_drag_to(&b.edit, eye, (double[3]){0, 0, -1}, 0.5));
  /* Just below it the plane is miles away; the support goes far but not out of sight. */
  assert_true(edit_drag_to(&b.edit, eye, (double[3]){0, -1e-7, -1}, 0.5));
  assert_true(fabs(b.edit.node->position[2]) < 500);
  bench_close(&b);
}

static void scale_drag_grows_upwards(void** state) {
  (void)state;
  bench b;
  bench_open(&b);
  b.edit.field = 1;
  b.edit.node = root_of(&b, 1);
  const double zero[3] = {0, 0, 0}, ray[3] = {0, 0, -1};
  edit_drag_begin(&b.edit, EDIT_DRAG_SCALE, zero, 0.5);
  assert_true(edit_drag_to(&b.edit, zero, ray, 0.6));
  assert_true(b.edit.node->scale > 1.2);
  assert_true(edit_drag_to(&b.edit, zero, ray, 0.4));
  assert_true(b.edit.node->scale < 0.8);
  assert_true(edit_drag_to(&b.edit, zero, ray, 0.5));
  assert_float_equal(b.edit.node->scale, 1, 1e-12);
  bench_close(&b);
}

static void added_support_stands_where_it_was_put(void** state) {
  (void)state;
  static const scree_shape_kind kinds[] = {SCREE_SHAPE_SPHERE, SCREE_SHAPE_BOX, SCREE_SHAPE_CAPSULE, SCREE_SHAPE_CYLINDER,
                                           SCREE_SHAPE_CONE};
  for (uint32_t field = 0; field < 2; ++field)
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) {
      bench b;
      bench_open(&b);
      b.edit.field = field;
      const double place[3] = {-3, 4, 5.5};
      assert_true(edit_add(&b.edit, kinds[i], place, 0.75));
      assert_int_equal(root_of(&b, field)->kind, SCREE_SHAPE_UNION);
      assert_int_equal(root_of(&b, field)->child_count, field == 0 ? 3 : 2);
      edit_frame own;
      assert_true(edit_node_frame(root_of(&b, field), b.edit.node, &own, NULL));
      assert_near(own.translation, place, 1e-9);
      assert_float_equal(own.scale, 1, 1e-12);
      scree_support* support;
      scree_error error = {""};
      const scene_paths paths = {.scene = "test"};
      if (scene_support_create(&b.scene, field, &paths, NULL, NULL, NULL, &support, &error) != SCREE_OK)
        fail_msg("%s", error.message);
      scree_support_destroy(support);
      bench_close(&b);
    }
}

static void a_field_keeps_its_last_support(void** state) {
  (void)state;
  bench b;
  bench_open(&b);
  assert_false(edit_delete(&b.edit)); /* nothing selected */
  b.edit.node = root_of(&b, 0);
  assert_false(edit_delete(&b.edit));
  b.edit.node = root_of(&b, 0)->children[1]->children[0];
  assert_true(edit_delete(&b.edit));
  assert_null(b.edit.node);
  b.edit.node = root_of(&b, 0)->children[1]->children[0];
  assert_false(edit_delete(&b.edit));
  assert_int_equal(root_of(&b, 0)->children[1]->child_count, 1);
  b.edit.node = root_of(&b, 0)->children[1];
  assert_true(edit_delete(&b.edit));
  b.edit.node = root_of(&b, 0)->children[0];
  assert_false(edit_delete(&b.edit));
  bench_close(&b);
}

static void duplicate_is_equal_and_beside(void** state) {
  (void)state;
  bench b;
  bench_open(&b);
  scene_node* box = root_of(&b, 0)->children[1]->children[0];
  b.edit.node = box;
  assert_true(edit_duplicate(&b.edit));
  assert_ptr_not_equal(b.edit.node, box);
  assert_int_equal(root_of(&b, 0)->children[1]->child_count, 3);
  assert_int_equal(b.edit.node->kind, SCREE_SHAPE_BOX);
  assert_memory_equal(b.edit.node->box.half, box->box.half, sizeof box->box.half);
  assert_true(b.edit.node->position[0] > box->position[0]);
  bench_close(&b);
}

/* Wrapping moves nothing: the wrapped shape stays where it stood. */
static void wrapped_support_stays_in_place(void** state) {
  (void)state;
  static const scree_shape_kind kinds[] = {SCREE_SHAPE_NOISE, SCREE_SHAPE_HALF_SPACE};
  for (size_t i = 0; i < 2; ++i)
    for (int which = 0; which < 3; ++which) {
      bench b;
      bench_open(&b);
      scene_node* node = which == 0 ? root_of(&b, 0) : which == 1 ? root_of(&b, 0)->children[1]->children[1] : root_of(&b, 1);
      b.edit.field = which == 2;
      b.edit.node = node;
      edit_frame before, after;
      assert_true(edit_node_frame(root_of(&b, b.edit.field), node, &before, NULL));
      assert_true(edit_wrap(&b.edit, kinds[i]));
      assert_true(edit_node_frame(root_of(&b, b.edit.field), node, &after, NULL));
      assert_memory_equal(before.rotation, after.rotation, sizeof before.rotation);
      assert_near(after.translation, before.translation, 1e-9);
      assert_float_equal(after.scale, before.scale, 1e-12);
      assert_int_equal(b.edit.node->kind, kinds[i]);
      assert_int_equal(b.edit.changed[b.edit.field], SCENE_CHANGED_SUPPORT);
      bench_close(&b);
    }
  bench b;
  bench_open(&b);
  b.edit.node = root_of(&b, 0);
  assert_false(edit_wrap(&b.edit, SCREE_SHAPE_UNION));
  b.edit.node = NULL;
  assert_false(edit_wrap(&b.edit, SCREE_SHAPE_NOISE));
  bench_close(&b);
}

static void noise_is_copied_and_kept_with_its_shape(void** state) {
  (void)state;
  bench b;
  bench_open(&b);
  b.edit.node = root_of(&b, 0)->children[0];
  assert_true(edit_wrap(&b.edit, SCREE_SHAPE_NOISE));
  scene_node* noise = b.edit.node;
  b.edit.node = noise->children[0];
  assert_false(edit_delete(&b.edit)); /* noise without a shape is no support */
  assert_true(edit_duplicate(&b.edit));
  assert_int_equal(noise->child_count, 1);
  assert_int_equal(b.edit.node->kind, SCREE_SHAPE_NOISE);
  assert_int_equal(root_of(&b, 0)->child_count, 3);
  bench_close(&b);
}

static char* text_of(const bench* b) {
  char* text = scene_write(&b->scene, NULL);
  assert_non_null(text);
  return text;
}

static void undo_and_redo_walk_through_every_state(void** state) {
  (void)state;
  enum { STEPS = EDIT_HISTORY + 20 };
  bench b;
  bench_open(&b);
  assert_false(edit_undo(&b.edit));
  assert_false(edit_redo(&b.edit));
  char* states[STEPS + 1];
  states[0] = text_of(&b);
  for (int i = 1; i <= STEPS; ++i) {
    b.edit.field = 1;
    b.edit.node = root_of(&b, 1);
    b.edit.node->position[0] = i;
    edit_commit(&b.edit);
    edit_commit(&b.edit); /* nothing has changed since: no step */
    states[i] = text_of(&b);
  }
  int at = STEPS;
  while (edit_undo(&b.edit)) {
    --at;
    char* text = text_of(&b);
    assert_string_equal(text, states[at]);
    free(text);
    assert_ptr_equal(b.edit.node, root_of(&b, 1)); /* still selected, in the new tree */
    assert_true(b.edit.changed_fields);
  }
  assert_int_equal(at, STEPS - EDIT_HISTORY + 1);
  assert_true(edit_redo(&b.edit));
  assert_true(edit_redo(&b.edit));
  char* text = text_of(&b);
  assert_string_equal(text, states[at + 2]);
  free(text);
  /* A new step forgets what could have been done again. */
  root_of(&b, 1)->position[1] = 77;
  edit_commit(&b.edit);
  assert_false(edit_redo(&b.edit));
  for (int i = 0; i <= STEPS; ++i) free(states[i]);
  bench_close(&b);
}

static void undo_takes_back_what_was_never_committed(void** state) {
  (void)state;
  bench b;
  bench_open(&b);
  char* before = text_of(&b);
  root_of(&b, 0)->scale = 3;
  assert_true(edit_undo(&b.edit));
  char* after = text_of(&b);
  assert_string_equal(before, after);
  assert_true(edit_redo(&b.edit));
  assert_float_equal(root_of(&b, 0)->scale, 3, 0);
  free(before);
  free(after);
  bench_close(&b);
}

static void a_tree_grows_no_larger_than_a_scene_file_holds(void** state) {
  (void)state;
  bench b;
  bench_open(&b);
  const double place[3] = {0, 0, 0};
  scene_node* root = root_of(&b, 0);
  for (uint32_t nodes = 5; nodes < SCENE_NODES_MAX - 2; ++nodes)
    assert_true(scene_node_add(root, scene_node_create(SCREE_SHAPE_SPHERE)));
  assert_true(edit_add(&b.edit, SCREE_SHAPE_SPHERE, place, 1));
  assert_false(edit_add(&b.edit, SCREE_SHAPE_SPHERE, place, 1));
  assert_false(edit_duplicate(&b.edit));
  bench_close(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(frames_nest_as_the_support_does),
      cmocka_unit_test(stone_belongs_to_the_nearest_surface),
      cmocka_unit_test(dragged_node_follows_the_pointer),
      cmocka_unit_test(grabbing_an_arrow_moves_nothing_yet),
      cmocka_unit_test(drag_above_the_horizon_is_ignored),
      cmocka_unit_test(scale_drag_grows_upwards),
      cmocka_unit_test(added_support_stands_where_it_was_put),
      cmocka_unit_test(a_field_keeps_its_last_support),
      cmocka_unit_test(duplicate_is_equal_and_beside),
      cmocka_unit_test(wrapped_support_stays_in_place),
      cmocka_unit_test(noise_is_copied_and_kept_with_its_shape),
      cmocka_unit_test(undo_and_redo_walk_through_every_state),
      cmocka_unit_test(undo_takes_back_what_was_never_committed),
      cmocka_unit_test(a_tree_grows_no_larger_than_a_scene_file_holds),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
