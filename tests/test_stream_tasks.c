/* Streams whose work is done in the background: by threads, late, in any order. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* after the four above */
#include <cmocka.h>

#include <scree/threads.h>

#include "stream_host.h"
#include "synthetic_field.h"

/* --- tasks that wait until somebody asks ------------------------------------------------------------------------------------ */

typedef struct late_task {
  void (*run)(void* context);
  void* context;
} late_task;

typedef struct late_queue {
  late_task tasks[4096];
  uint32_t count, submitted;
  random_stream random;
} late_queue;

static void late_submit(void* user, void (*run)(void* context), void* context) {
  late_queue* q = user;
  assert_true(q->count < 4096);
  q->tasks[q->count++] = (late_task){run, context};
  ++q->submitted;
}

/* Runs one of them, whichever. */
static void late_help(void* user) {
  late_queue* q = user;
  if (q->count == 0) return;
  uint32_t i = random_below(&q->random, q->count);
  late_task task = q->tasks[i];
  q->tasks[i] = q->tasks[--q->count];
  task.run(task.context);
}

/* --- flights ---------------------------------------------------------------------------------------------------------------- */

static scree_stream_desc describe(const stream_world* w) {
  return (scree_stream_desc){.scene = w->scene,
                             .edits = w->edits,
                             .view_distance = 30,
                             .max_error_pixels = 3,
                             .caps = {.instances = 30000,
                                      .blocks = 400,
                                      .mesh_bytes = 4000000,
                                      .upload_bytes = 300000,
                                      .builds = 9,
                                      .decodes = 30,
                                      .events = 500},
                             .decode = stream_decode_flaky};
}

/* A flight with jumps, edits and a change of scene; returns the digest of all events. */
static uint64_t fly(stream_world* w, const scree_stream_desc* desc, late_queue* late, int updates) {
  stream_host h;
  host_create(&h, desc, NULL);
  random_stream r = {77};
  scree_view view = host_view(0, 3, 0);
  double heading = 0;
  for (int i = 0; i < updates; ++i) {
    heading += random_in(&r, -0.1, 0.1);
    view.position[0] += cos(heading);
    view.position[2] += sin(heading);
    if (i % 97 == 96 || fabs(view.position[0]) > 80 || fabs(view.position[2]) > 80)
      for (int a = 0; a < 3; a += 2) view.position[a] = random_in(&r, -60, 60);
    if (i % 50 == 25 && h.shown_instances > 0) {
      scree_stream_wait(h.stream);
      uint32_t place = 0;
      while (h.owners[place] == 0) ++place;
      assert_int_equal(scree_edits_set(w->edits, &h.ids[place], SCREE_EDIT_REMOVE), SCREE_OK);
      assert_int_equal(scree_stream_edited(h.stream, &h.ids[place], 1), SCREE_OK);
    }
    if (i % 200 == 150) assert_int_equal(scree_stream_set_scene(h.stream, w->scene), SCREE_OK);
    host_update(&h, &view, 1);
    for (uint32_t k = 0; late != NULL && k < 3; ++k) late_help(late);
  }
  if (!desc->deterministic) {
    host_settle(&h, &view, 1, 2000);
    host_check(&h);
  }
  uint64_t digest = h.digest;
  host_destroy(&h);
  scree_edits_clear(w->edits);
  if (late != NULL) assert_int_equal(late->count, 0);
  return digest;
}

static void events_are_the_same_with_any_number_of_threads(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  scree_stream_desc desc = describe(&w);
  desc.deterministic = true;
  uint64_t alone = fly(&w, &desc, NULL, 400);
  const uint32_t counts[] = {0, 1, 2, 8};
  for (int i = 0; i < 4; ++i) {
    scree_threads* threads;
    assert_int_equal(scree_threads_create(counts[i], NULL, &threads), SCREE_OK);
    desc.tasks = scree_threads_tasks(threads);
    assert_int_equal(fly(&w, &desc, NULL, 400), alone);
    scree_threads_destroy(threads);
  }
  late_queue* late = calloc(1, sizeof *late);
  desc.tasks = (scree_tasks){late_submit, late_help, late};
  assert_int_equal(fly(&w, &desc, late, 400), alone);
  free(late);
  stream_world_free(&w);
}

static void free_running_threads_break_no_promise(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  scree_stream_desc desc = describe(&w);
  for (uint32_t count = 1; count <= 8; count *= 2) {
    scree_threads* threads;
    assert_int_equal(scree_threads_create(count, NULL, &threads), SCREE_OK);
    desc.tasks = scree_threads_tasks(threads);
    fly(&w, &desc, NULL, 300);
    scree_threads_destroy(threads);
  }
  stream_world_free(&w);
}

static void hosts_whose_threads_cannot_be_helped_are_waited_for(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  scree_stream_desc desc = describe(&w);
  desc.deterministic = true;
  uint64_t alone = fly(&w, &desc, NULL, 150);
  scree_threads* threads;
  assert_int_equal(scree_threads_create(2, NULL, &threads), SCREE_OK);
  desc.tasks = scree_threads_tasks(threads);
  desc.tasks.help = NULL;
  assert_int_equal(fly(&w, &desc, NULL, 150), alone);
  desc.deterministic = false;
  fly(&w, &desc, NULL, 150);
  scree_threads_destroy(threads);
  stream_world_free(&w);
}

static void tasks_may_run_late_and_in_any_order(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  for (uint64_t seed = 0; seed < 3; ++seed) {
    late_queue* late = calloc(1, sizeof *late);
    late->random.state = seed;
    scree_stream_desc desc = describe(&w);
    desc.tasks = (scree_tasks){late_submit, late_help, late};
    fly(&w, &desc, late, 400);
    free(late);
  }
  stream_world_free(&w);
}

static void destroy_waits_for_what_is_under_way(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  for (int updates = 1; updates < 12; ++updates) {
    late_queue* late = calloc(1, sizeof *late);
    scree_stream_desc desc = describe(&w);
    desc.tasks = (scree_tasks){late_submit, late_help, late};
    stream_host h;
    host_create(&h, &desc, NULL);
    scree_view view = host_view(0, 3, 0);
    for (int i = 0; i < updates; ++i) {
      host_update(&h, &view, 1);
      late_help(late);
    }
    host_destroy(&h);
    assert_int_equal(late->count, 0);
    free(late);
  }
  stream_world_free(&w);
}

static void a_settled_stream_submits_nothing(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  late_queue* late = calloc(1, sizeof *late);
  scree_stream_desc desc = describe(&w);
  desc.decode = stream_decode_pattern;
  desc.tasks = (scree_tasks){late_submit, late_help, late};
  desc.deterministic = true;
  stream_host h;
  host_create(&h, &desc, NULL);
  scree_view view = host_view(0, 3, 0);
  host_settle(&h, &view, 1, 2000);
  uint32_t submitted = late->submitted;
  assert_true(submitted > 0);
  for (int i = 0; i < 20; ++i) host_update(&h, &view, 1);
  assert_int_equal(late->submitted, submitted);
  host_destroy(&h);
  free(late);
  stream_world_free(&w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(events_are_the_same_with_any_number_of_threads),
      cmocka_unit_test(free_running_threads_break_no_promise),
      cmocka_unit_test(hosts_whose_threads_cannot_be_helped_are_waited_for),
      cmocka_unit_test(tasks_may_run_late_and_in_any_order),
      cmocka_unit_test(destroy_waits_for_what_is_under_way),
      cmocka_unit_test(a_settled_stream_submits_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
