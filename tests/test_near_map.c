/* The map that tells which rocks are far from all others: what it may never do, and what it is for. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "near_map.h"
#include "synthetic_field.h"

enum { BALLS = 40, POINTS = 4000 };

/* Where the map lies, and relative to what its points are given. */
static void check_map(random_stream* r, scree_scratch* scratch, double middle, double origin, double step, double most,
                      uint32_t* empty) {
  double low[3], high[3], from[3], centres[BALLS][3], radii[BALLS];
  for (int a = 0; a < 3; ++a) {
    low[a] = middle - random_in(r, 1, 30);
    high[a] = middle + random_in(r, 1, 30);
    from[a] = origin;
  }
  near_map map;
  assert_true(scree_rt_near_map_begin(&map, scratch, low, high, from, step, most));
  for (int i = 0; i < BALLS; ++i) {
    for (int a = 0; a < 3; ++a) centres[i][a] = random_in(r, low[a] - 2, high[a] + 2);
    radii[i] = random_in(r, 0.01, 2);
    scree_rt_near_map_add(&map, centres[i], radii[i], (uint8_t)(1u << i % 8));
  }
  for (int k = 0; k < POINTS; ++k) {
    float at[3];
    double away[3];
    for (int a = 0; a < 3; ++a) {
      double place = random_in(r, low[a], high[a]);
      if (k % 2 == 0) { /* in a ball, often just below its surface */
        const double reach = radii[k / 2 % BALLS] * 0.577;
        place = fmin(fmax(centres[k / 2 % BALLS][a] + (random_below(r, 2) ? reach : -reach), low[a]), high[a]);
      }
      at[a] = (float)(place - origin);
      away[a] = place;
    }
    const uint8_t kinds = near_map_kinds(&map, at);
    *empty += k % 2 == 1 && kinds == 0;
    for (int i = 0; i < BALLS; ++i) {
      double d2 = 0;
      for (int a = 0; a < 3; ++a) d2 += (centres[i][a] - away[a]) * (centres[i][a] - away[a]);
      if (d2 <= radii[i] * radii[i]) assert_true(kinds >> i % 8 & 1);
    }
  }
}

static void no_point_of_a_ball_is_missed(void** state) {
  (void)state;
  random_stream r = {2024};
  scree_scratch* scratch = NULL;
  assert_int_equal(scree_scratch_create(NULL, &scratch), SCREE_OK);
  uint32_t empty = 0, unused = 0;
  for (int i = 0; i < 20; ++i) check_map(&r, scratch, 0, 0, 0.5, 1e6, &empty);
  assert_true(empty > 20 * POINTS / 4); /* of half the points: most of space is far from all balls */
  for (int i = 0; i < 20; ++i) {
    check_map(&r, scratch, 1e7, 1e7, 0.3, 1e6, &unused);
    check_map(&r, scratch, -3e5, 0, 0.3, 1e5, &unused); /* floats far from their origin are coarse */
    check_map(&r, scratch, 50, -50, 1e-9, 100, &unused);
  }
  scree_scratch_destroy(scratch);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(no_point_of_a_ball_is_missed)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
