/* Places of the array of instances against a plain map of them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* after the four above */
#include <cmocka.h>

#include "stream_ranges.h"
#include "synthetic_field.h"

enum { MOST = 2000 };

typedef struct taken_range {
  uint32_t first, count;
} taken_range;

/* The longest run of free places, in whole units, that start at a multiple of the unit. */
static uint32_t longest_free(const uint8_t* map, uint32_t units) {
  uint32_t longest = 0, now = 0;
  for (uint32_t i = 0; i < units; ++i) {
    now = map[i] ? 0 : now + 1;
    if (now > longest) longest = now;
  }
  return longest;
}

static void check_against_map(uint32_t capacity, uint32_t largest, uint64_t seed) {
  uint32_t* words = malloc(scree_rt_ranges_words(capacity) * sizeof *words);
  taken_range* taken = calloc(MOST, sizeof *taken);
  stream_ranges ranges;
  scree_rt_ranges_init(&ranges, capacity, words);
  uint8_t* map = calloc(ranges.units, 1);
  assert_true(words != NULL && taken != NULL && map != NULL);
  uint32_t unit = ranges.unit, count = 0, refused = 0;
  random_stream r = {seed};
  for (int step = 0; step < 4000; ++step) {
    bool fills = step / 500 % 2 == 0;
    if (count < MOST && random_below(&r, 10) < (fills ? 8u : 3u)) {
      uint32_t wanted = 1 + random_below(&r, largest), first;
      uint32_t need = (wanted + unit - 1) / unit;
      bool fits = longest_free(map, ranges.units) >= need;
      assert_int_equal(scree_rt_ranges_take(&ranges, wanted, &first), fits); /* what fits is always found */
      refused += !fits;
      if (!fits) continue;
      assert_int_equal(first % unit, 0);
      assert_true(first / unit + need <= ranges.units);
      for (uint32_t i = 0; i < need; ++i) {
        assert_int_equal(map[first / unit + i], 0);
        map[first / unit + i] = 1;
      }
      taken[count++] = (taken_range){first, wanted};
    } else if (count > 0 && random_below(&r, 4) == 0) {
      taken_range* range = &taken[random_below(&r, count)];
      uint32_t kept = 1 + random_below(&r, range->count), left = (kept + unit - 1) / unit;
      scree_rt_ranges_trim(&ranges, range->first, range->count, kept);
      memset(map + range->first / unit + left, 0, (range->count + unit - 1) / unit - left);
      range->count = kept;
    } else if (count > 0) {
      uint32_t which = random_below(&r, count);
      scree_rt_ranges_give(&ranges, taken[which].first, taken[which].count);
      memset(map + taken[which].first / unit, 0, (taken[which].count + unit - 1) / unit);
      taken[which] = taken[--count];
    }
    uint32_t free_units = 0;
    for (uint32_t i = 0; i < ranges.units; ++i) free_units += map[i] == 0;
    assert_int_equal(ranges.free_units, free_units);
  }
  assert_true(refused > 0);
  while (count > 0) {
    --count;
    scree_rt_ranges_give(&ranges, taken[count].first, taken[count].count);
  }
  uint32_t first; /* nothing is lost: all of it is one range again */
  assert_true(scree_rt_ranges_take(&ranges, ranges.units * unit, &first));
  assert_int_equal(first, 0);
  assert_int_equal(ranges.free_units, 0);
  assert_false(scree_rt_ranges_take(&ranges, 1, &first));
  free(map);
  free(taken);
  free(words);
}

static void what_fits_is_found_and_nothing_overlaps(void** state) {
  (void)state;
  for (uint64_t seed = 0; seed < 4; ++seed) {
    check_against_map(100, 30, seed);
    check_against_map(1000, 90, seed);
    check_against_map(4096, 700, seed);
    check_against_map(65536 + 13, 9000, seed); /* handed out eight at a time */
  }
}

static void the_smallest_arrays_work(void** state) {
  (void)state;
  uint32_t words[3 * 3], first, second, third;
  for (uint32_t capacity = 1; capacity <= 3; ++capacity) {
    stream_ranges ranges;
    assert_true(scree_rt_ranges_words(capacity) <= 9);
    scree_rt_ranges_init(&ranges, capacity, words);
    assert_false(scree_rt_ranges_take(&ranges, capacity + 1, &first));
    for (uint32_t i = 0; i < capacity; ++i) assert_true(scree_rt_ranges_take(&ranges, 1, &first));
    assert_false(scree_rt_ranges_take(&ranges, 1, &second));
    for (uint32_t i = 0; i < capacity; ++i) scree_rt_ranges_give(&ranges, i, 1);
    assert_true(scree_rt_ranges_take(&ranges, capacity, &third));
    assert_int_equal(third, 0);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_fits_is_found_and_nothing_overlaps),
      cmocka_unit_test(the_smallest_arrays_work),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
