/* Weathering gives the same state whoever runs its work: any number of threads, and any order of the slabs. */
#include <scree/threads.h>
#include <scree/weather.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* after the four above */
#include <cmocka.h>

#include "random_weather.h"

/* Digests after each of a few steps, with a change of rules and a snapshot in between. */
enum { DIGESTS = 7 };

static void run(const scree_weather_start* start, const random_rules rules[2], scree_jobs jobs, uint64_t digests[DIGESTS]) {
  const scree_weather_desc desc = {.start = *start, .rules = rules[0].rules, .jobs = jobs};
  scree_weather* w;
  assert_int_equal(scree_weather_create(&desc, &w, NULL), SCREE_OK);
  digests[0] = scree_weather_digest(w);
  assert_int_equal(scree_weather_step(w, 3), SCREE_OK);
  digests[1] = scree_weather_digest(w);
  scree_weather_snapshot* snapshot;
  assert_int_equal(scree_weather_save(w, &snapshot), SCREE_OK);
  assert_int_equal(scree_weather_step(w, 3), SCREE_OK);
  digests[2] = scree_weather_digest(w);
  assert_int_equal(scree_weather_set_rules(w, &rules[1].rules, NULL), SCREE_OK);
  assert_int_equal(scree_weather_step(w, 3), SCREE_OK);
  digests[3] = scree_weather_digest(w);
  scree_weather_restore(w, snapshot);
  digests[4] = scree_weather_digest(w);
  assert_int_equal(scree_weather_step(w, 3), SCREE_OK);
  digests[5] = scree_weather_digest(w);
  assert_int_equal(scree_weather_run(w, 0.5, 4, NULL, NULL), SCREE_OK);
  digests[6] = scree_weather_digest(w);
  scree_weather_forget(w, snapshot);
  scree_weather_destroy(w);
}

static void backwards(void* user, uint32_t count, void (*work)(void* context, uint32_t index, uint32_t worker), void* context) {
  (void)user;
  for (uint32_t i = count; i-- > 0;) work(context, i, i % 3);
}

static void the_state_depends_on_no_thread_and_no_order(void** state) {
  (void)state;
  scree_threads* pools[2];
  assert_int_equal(scree_threads_create(1, NULL, &pools[0]), SCREE_OK);
  assert_int_equal(scree_threads_create(4, NULL, &pools[1]), SCREE_OK);
  random_stream random = {41};
  uint32_t cases = 0;
  while (cases < 10) {
    random_start start;
    random_rules rules[2];
    random_start_make(&random, 40, &start);
    random_rules_make(&random, 3, &rules[0]);
    random_rules_make(&random, 3, &rules[1]);
    start.start.size[2] = 50 + random_below(&random, 40); /* several slabs */
    const scree_weather_desc desc = {.start = start.start, .rules = rules[0].rules};
    scree_weather* w;
    if (scree_weather_create(&desc, &w, NULL) == SCREE_OK) {
      scree_weather_destroy(w);
      uint64_t alone[DIGESTS], others[DIGESTS];
      run(&start.start, rules, (scree_jobs){0}, alone);
      for (int pool = 0; pool < 2; ++pool) {
        run(&start.start, rules, scree_threads_jobs(pools[pool]), others);
        assert_memory_equal(alone, others, sizeof alone);
      }
      run(&start.start, rules, (scree_jobs){backwards, 3, NULL}, others);
      assert_memory_equal(alone, others, sizeof alone);
      assert_int_equal(alone[1], alone[4]);
      ++cases;
    }
    random_start_free(&start);
  }
  for (int pool = 0; pool < 2; ++pool) scree_threads_destroy(pools[pool]);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(the_state_depends_on_no_thread_and_no_order)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
