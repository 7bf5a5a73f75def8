/* Weathering's start shapes, snapshots, bricks' stamps, wrong input, and memory that runs out. */
#include <math.h>
#include <scree/weather.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* after the four above */
#include <cmocka.h>

#include "failing_allocator.h"
#include "make_weather.h"
#include "random_weather.h"
#include "weather_internal.h"

static scree_weather_rules default_rules(void) {
  scree_weather_rules rules;
  scree_weather_rules_default(&rules);
  return rules;
}

/* A pillar with noise, a mixture and some of everything. */
static const scree_durability_point some_points[3] = {{0, 1.5, 0.3, 8, 0}, {0.4, 0.6, 0.8, 0, 1.8}, {0.8, 1.8, 0, 0, 0}};
static const scree_bubble_segment some_segments[2] = {{0, {{SCREE_BUBBLE_SPHERE, 3, 0}, {SCREE_BUBBLE_DISC, 4, 0}}, 2, 6},
                                                      {0.5, {{SCREE_BUBBLE_GUMDROP, 4, 0}}, 1, 0}};

static scree_weather_desc some_desc(void) {
  scree_weather_desc desc = {
      .start = {.kind = SCREE_START_BOX, .size = {30, 40, 36}, .box_min = {8, 0, 8}, .box_max = {24, 36, 28}, .seed = 9}};
  desc.rules = default_rules();
  desc.rules.durability = some_points;
  desc.rules.durability_count = 3;
  desc.rules.bubbles = some_segments;
  desc.rules.bubble_count = 2;
  desc.rules.steps_per_voxel = 4;
  return desc;
}

/* --- start shapes --------------------------------------------------------------------------------------------------------------
 */

static void a_box_is_rock_and_nothing_else_is(void** state) {
  (void)state;
  const scree_weather_start start = {.kind = SCREE_START_BOX, .size = {70, 9, 11}, .box_min = {3, 2, 1}, .box_max = {68, 7, 10}};
  const scree_weather_rules rules = default_rules();
  scree_weather* w = make(&start, &rules);
  uint8_t* voxels = malloc(70 * 9 * 11);
  assert_non_null(voxels);
  scree_weather_voxels(w, voxels);
  for (uint32_t z = 0; z < 11; ++z)
    for (uint32_t y = 0; y < 9; ++y)
      for (uint32_t x = 0; x < 70; ++x) {
        const bool in = x >= 3 && x < 68 && y >= 2 && y < 7 && z >= 1 && z < 10;
        assert_int_equal(voxels[x + 70 * (y + 9 * z)], in ? SCREE_VOXEL_ROCK : SCREE_VOXEL_AIR);
      }
  const scree_weather_stats stats = stats_of(w);
  assert_int_equal(stats.start_rock, 65 * 5 * 9);
  assert_int_equal(stats.rock, 65 * 5 * 9);
  assert_int_equal(stats.active, 65 * 5 * 9 - 63 * 3 * 7);
  double radii[9];
  scree_weather_radii(w, radii);
  for (int y = 0; y < 9; ++y) assert_true(fabs(radii[y] - (y >= 2 && y < 7 ? sqrt(65 * 9 / 3.14159265358979323846) : 0)) < 1e-12);
  uint32_t size[3];
  scree_weather_size(w, size);
  assert_memory_equal(size, start.size, sizeof size);
  free(voxels);
  scree_weather_destroy(w);
}

static void grey_scales_the_height_of_a_column_and_black_is_none(void** state) {
  (void)state;
  static const uint8_t map[6] = {0, 255, 128, 51, 1, 102};
  const scree_weather_start start = {.kind = SCREE_START_JOINT_MAP, .size = {6, 50, 4}, .map = map, .map_width = 3, .map_depth = 2};
  const scree_weather_rules rules = default_rules();
  scree_weather* w = make(&start, &rules);
  static const uint32_t heights[6] = {0, 50, 25, 10, 0, 20};
  for (uint32_t z = 0; z < 4; ++z)
    for (uint32_t x = 0; x < 6; ++x)
      for (uint32_t y = 0; y < 50; ++y)
        assert_int_equal(weather_voxel(w, (int32_t)x, (int32_t)y, (int32_t)z),
                         y < heights[x / 2 + 3 * (z / 2)] ? SCREE_VOXEL_ROCK : SCREE_VOXEL_AIR);
  scree_weather_destroy(w);
}

static void a_support_is_rock_where_the_middles_of_voxels_are_inside(void** state) {
  (void)state;
  scree_shape sphere = {.kind = SCREE_SHAPE_SPHERE, .transform = {.translation = {2, 3, 1}}, .sphere = {4}};
  const scree_support_desc support_desc = {.shapes = &sphere, .shape_count = 1, .origin = {5000, 10, -70}};
  scree_support* support;
  assert_int_equal(scree_support_create(&support_desc, NULL, &support, NULL), SCREE_OK);
  const scree_weather_start start = {.kind = SCREE_START_SUPPORT,
                                     .size = {41, 45, 43},
                                     .support = support,
                                     .voxel = 0.25,
                                     .origin = {5002 - 5, 13 - 5.5, -69 - 5.25}};
  const scree_weather_rules rules = default_rules();
  scree_weather* w = make(&start, &rules);
  scree_support_destroy(support); /* it is not looked at again */
  for (int32_t z = 0; z < 43; ++z)
    for (int32_t y = 0; y < 45; ++y)
      for (int32_t x = 0; x < 41; ++x) {
        const double dx = (x + 0.5) * 0.25 - 5, dy = (y + 0.5) * 0.25 - 5.5, dz = (z + 0.5) * 0.25 - 5.25;
        const double d = sqrt(dx * dx + dy * dy + dz * dz) - 4;
        if (fabs(d) > 1e-3) assert_int_equal(weather_voxel(w, x, y, z), d < 0 ? SCREE_VOXEL_ROCK : SCREE_VOXEL_AIR);
      }
  scree_weather_destroy(w);
}

/* Columns of rock at the top of the box's lowest blocks that hang together. */
static uint32_t count_blocks(const scree_weather* w, int32_t y) {
  const uint32_t nx = w->size[0], nz = w->size[2];
  uint8_t* seen = calloc((size_t)nx * nz, 1);
  uint32_t* stack = malloc((size_t)nx * nz * sizeof *stack);
  assert_non_null(seen);
  assert_non_null(stack);
  uint32_t blocks = 0;
  for (uint32_t start = 0; start < nx * nz; ++start) {
    if (seen[start] != 0 || weather_voxel(w, (int32_t)(start % nx), y, (int32_t)(start / nx)) == SCREE_VOXEL_AIR) continue;
    uint32_t depth = 0, columns = 0;
    seen[start] = 1;
    stack[depth++] = start;
    while (depth > 0) {
      const uint32_t at = stack[--depth];
      ++columns;
      static const int32_t ways[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
      for (int i = 0; i < 4; ++i) {
        const int32_t x = (int32_t)(at % nx) + ways[i][0], z = (int32_t)(at / nx) + ways[i][1];
        if (weather_voxel(w, x, y, z) == SCREE_VOXEL_AIR || seen[(uint32_t)x + nx * (uint32_t)z] != 0) continue;
        seen[(uint32_t)x + nx * (uint32_t)z] = 1;
        stack[depth++] = (uint32_t)x + nx * (uint32_t)z;
      }
    }
    blocks += columns >= 20;
  }
  free(seen);
  free(stack);
  return blocks;
}

static void joints_cut_a_block_into_pillars_of_different_heights(void** state) {
  (void)state;
  scree_weather_start start = {.kind = SCREE_START_JOINTS,
                               .size = {120, 20, 120},
                               .joint_spacing = 30,
                               .joint_gap = 0.1,
                               .joint_warp = 0.2,
                               .joint_low = 0.5,
                               .seed = 4};
  const scree_weather_rules rules = default_rules();
  scree_weather* w = make(&start, &rules);
  const uint32_t whole = count_blocks(w, 0);
  assert_in_range(whole, 14, 30);              /* 16 cells, cut by the box */
  assert_int_equal(count_blocks(w, 9), whole); /* none is lower than half of the box */
  assert_true(count_blocks(w, 19) < whole / 2);
  assert_true(stats_of(w).rock < 120 * 20 * 90);
  scree_weather_destroy(w);
  start.joint_missing = 0.5;
  w = make(&start, &rules);
  assert_in_range(count_blocks(w, 0), whole / 4, whole * 3 / 4);
  scree_weather_destroy(w);
  start.joint_missing = 0;
  start.joint_gap = 0;
  start.joint_low = 1;
  w = make(&start, &rules);
  assert_int_equal(stats_of(w).rock, 120 * 20 * 120);
  scree_weather_destroy(w);
}

/* --- steps ----------------------------------------------------------------------------------------------------------------------
 */

static void a_run_stops_at_the_share_or_the_step_that_was_asked_for(void** state) {
  (void)state;
  const scree_weather_desc desc = some_desc();
  scree_weather* w = make(&desc.start, &desc.rules);
  assert_int_equal(scree_weather_run(w, 0.6, 1000, NULL, NULL), SCREE_OK);
  const scree_weather_stats stats = stats_of(w);
  assert_true((double)stats.rock <= 0.6 * (double)stats.start_rock);
  assert_true((double)stats.rock > 0.5 * (double)stats.start_rock);
  assert_int_equal(scree_weather_run(w, 0.6, 1000, NULL, NULL), SCREE_OK);
  assert_int_equal(stats_of(w).step, stats.step);
  assert_int_equal(scree_weather_run(w, 0, 3, NULL, NULL), SCREE_OK);
  assert_int_equal(stats_of(w).step, stats.step + 3);
  assert_int_equal(scree_weather_run(w, -0.1, 3, NULL, NULL), SCREE_ERROR_RANGE);
  assert_int_equal(scree_weather_run(w, NAN, 3, NULL, NULL), SCREE_ERROR_RANGE);
  scree_weather_destroy(w);
}

typedef struct watcher {
  double last;
  uint32_t calls, stop_at;
} watcher;

static bool watch(void* user, double done) {
  watcher* s = user;
  assert_true(done >= s->last && done <= 1);
  s->last = done;
  return ++s->calls != s->stop_at;
}

static void a_run_tells_its_progress_and_can_be_cancelled(void** state) {
  (void)state;
  const scree_weather_desc desc = some_desc();
  scree_weather* w = make(&desc.start, &desc.rules);
  watcher watched = {0, 0, 0};
  assert_int_equal(scree_weather_run(w, 0.7, 1000, watch, &watched), SCREE_OK);
  assert_true(watched.calls > 3 && watched.last == 1);
  watched = (watcher){0, 0, 2};
  assert_int_equal(scree_weather_run(w, 0.1, 1000, watch, &watched), SCREE_ERROR_CANCELLED);
  assert_int_equal(watched.calls, 2);
  scree_weather_destroy(w);
}

static void what_changes_stamps_its_brick(void** state) {
  (void)state;
  scree_weather_desc desc = some_desc();
  /* Only what lies in a hollow wears: most bricks must keep their stamps. */
  desc.start.size[0] = desc.start.size[2] = 70;
  desc.start.box_min[0] = desc.start.box_min[2] = 4;
  desc.start.box_max[0] = desc.start.box_max[2] = 66;
  desc.rules.spheroidal = (scree_curve){SCREE_CURVE_SATURATING, 0.3, 0.25, 0.1, 1};
  scree_weather* w = make(&desc.start, &desc.rules);
  const size_t count = (size_t)w->size[0] * w->size[1] * w->size[2];
  const size_t bricks = (size_t)w->bricks[0] * w->bricks[1] * w->bricks[2];
  int32_t* lives = malloc(count * sizeof *lives);
  uint8_t* before = malloc(count);
  uint8_t* after = malloc(count);
  assert_non_null(lives);
  assert_non_null(before);
  assert_non_null(after);
  size_t kept = 0;
  for (int step = 0; step < 12; ++step) {
    scree_weather_voxels(w, before);
    size_t at = 0;
    for (uint32_t z = 0; z < w->size[2]; ++z)
      for (uint32_t y = 0; y < w->size[1]; ++y)
        for (uint32_t x = 0; x < w->size[0]; ++x) lives[at++] = w->life[weather_at(w, x, y, z)];
    assert_int_equal(scree_weather_step(w, 1), SCREE_OK);
    scree_weather_voxels(w, after);
    at = 0;
    for (uint32_t z = 0; z < w->size[2]; ++z)
      for (uint32_t y = 0; y < w->size[1]; ++y)
        for (uint32_t x = 0; x < w->size[0]; ++x, ++at)
          if (before[at] != after[at] || lives[at] != w->life[weather_at(w, x, y, z)])
            assert_int_equal(w->stamps[weather_brick(w, x, y, z)], w->change);
    for (size_t i = 0; i < bricks; ++i) kept += w->stamps[i] != w->change;
  }
  assert_true(kept > 12 * bricks / 8);
  free(lives);
  free(before);
  free(after);
  scree_weather_destroy(w);
}

static void new_rules_leave_lives_and_voxels(void** state) {
  (void)state;
  scree_weather_desc desc = some_desc();
  scree_weather* w = make(&desc.start, &desc.rules);
  assert_int_equal(scree_weather_step(w, 7), SCREE_OK);
  const uint64_t digest = scree_weather_digest(w);
  const scree_weather_rules others = default_rules();
  assert_int_equal(scree_weather_set_rules(w, &others, NULL), SCREE_OK);
  assert_int_equal(scree_weather_digest(w), digest);
  scree_weather_rules wrong = default_rules();
  wrong.exposure = NAN;
  scree_error error;
  assert_int_equal(scree_weather_set_rules(w, &wrong, &error), SCREE_ERROR_RANGE);
  assert_non_null(strstr(error.message, "exposure"));
  assert_int_equal(scree_weather_digest(w), digest);
  assert_int_equal(scree_weather_step(w, 1), SCREE_OK);
  assert_int_not_equal(scree_weather_digest(w), digest);
  scree_weather_destroy(w);
}

static void a_snapshot_restores_to_the_bit(void** state) {
  (void)state;
  random_stream random = {31};
  for (int i = 0; i < 12; ++i) {
    random_start start;
    random_rules rules, others;
    random_start_make(&random, 30, &start);
    random_rules_make(&random, 3, &rules);
    random_rules_make(&random, 3, &others);
    const scree_weather_desc desc = {.start = start.start, .rules = rules.rules};
    scree_weather* w;
    if (scree_weather_create(&desc, &w, NULL) == SCREE_OK) {
      scree_weather_snapshot *first, *second;
      assert_int_equal(scree_weather_save(w, &first), SCREE_OK);
      const uint64_t at_start = scree_weather_digest(w);
      assert_int_equal(scree_weather_step(w, 4), SCREE_OK);
      const uint64_t at_four = scree_weather_digest(w);
      const scree_weather_stats stats = stats_of(w);
      assert_int_equal(scree_weather_save(w, &second), SCREE_OK);
      assert_int_equal(scree_weather_step(w, 5), SCREE_OK);
      const uint64_t at_nine = scree_weather_digest(w);

      scree_weather_restore(w, second);
      assert_int_equal(scree_weather_digest(w), at_four);
      const scree_weather_stats again = stats_of(w);
      assert_memory_equal(&again, &stats, sizeof stats);
      assert_int_equal(scree_weather_step(w, 5), SCREE_OK);
      assert_int_equal(scree_weather_digest(w), at_nine);

      /* Other rules in between, other noise among them. */
      assert_int_equal(scree_weather_set_rules(w, &others.rules, NULL), SCREE_OK);
      assert_int_equal(scree_weather_step(w, 3), SCREE_OK);
      scree_weather_restore(w, first);
      assert_int_equal(scree_weather_digest(w), at_start);
      assert_int_equal(scree_weather_set_rules(w, &rules.rules, NULL), SCREE_OK);
      assert_int_equal(scree_weather_step(w, 9), SCREE_OK);
      assert_int_equal(scree_weather_digest(w), at_nine);
      assert_int_equal(scree_weather_set_rules(w, &others.rules, NULL), SCREE_OK);
      scree_weather_restore(w, first);
      assert_int_equal(scree_weather_step(w, 2), SCREE_OK);
      const uint64_t with_others = scree_weather_digest(w);
      scree_weather_forget(w, first);
      scree_weather_forget(w, second);
      scree_weather_destroy(w);
      const scree_weather_desc fresh = {.start = start.start, .rules = others.rules};
      assert_int_equal(scree_weather_create(&fresh, &w, NULL), SCREE_OK);
      assert_int_equal(scree_weather_step(w, 2), SCREE_OK);
      assert_int_equal(scree_weather_digest(w), with_others);
      scree_weather_destroy(w);
    }
    random_start_free(&start);
  }
}

/* --- wrong input -----------------------------------------------------------------------------------------------------------------
 */

static void assert_refused(const scree_weather_desc* desc, scree_result expected, const char* says) {
  failing_allocator memory = {.fail_at = -1};
  scree_weather_desc d = *desc;
  d.allocator = failing_allocator_of(&memory);
  scree_weather* w = (scree_weather*)&d;
  scree_error error;
  const scree_result result = scree_weather_create(&d, &w, &error);
  if (result != expected || strstr(error.message, says) == NULL)
    fail_msg("%s: '%s' instead of '%s'", scree_result_string(result), error.message, says);
  assert_null(w);
  assert_int_equal(memory.live, 0);
  if (strstr(says, "no voxel") == NULL) {
    assert_int_equal(memory.calls, 0); /* found before anything is allocated */
    if (strstr(error.message, "memory_limit") == NULL) assert_int_equal(scree_weather_memory(desc), 0);
  }
  assert_int_equal(scree_weather_create(&d, &w, NULL), expected); /* without an error to write to */
}

#define REFUSED(change, expected, says)               \
  do {                                                \
    scree_weather_desc desc = some_desc();            \
    scree_durability_point points[3];                 \
    scree_bubble_segment segments[2];                 \
    memcpy(points, some_points, sizeof points);       \
    memcpy(segments, some_segments, sizeof segments); \
    desc.rules.durability = points;                   \
    desc.rules.bubbles = segments;                    \
    change;                                           \
    assert_refused(&desc, expected, says);            \
  } while (0)

static void wrong_rules_are_refused_by_name(void** state) {
  (void)state;
  REFUSED(desc.rules.durability = NULL, SCREE_ERROR_INVALID_ARGUMENT, "durability graph");
  REFUSED(desc.rules.bubbles = NULL, SCREE_ERROR_INVALID_ARGUMENT, "bubble graph");
  REFUSED(desc.rules.durability_count = 0, SCREE_ERROR_RANGE, "durability_count: 0");
  REFUSED(desc.rules.durability_count = 257, SCREE_ERROR_RANGE, "durability_count: 257");
  REFUSED(desc.rules.bubble_count = 0, SCREE_ERROR_RANGE, "bubble_count: 0");
  REFUSED(desc.rules.bubble_count = 65, SCREE_ERROR_RANGE, "bubble_count: 65");
  REFUSED(points[2].altitude = 0.3, SCREE_ERROR_RANGE, "durability[2].altitude: 0.3");
  REFUSED(points[0].altitude = -0.1, SCREE_ERROR_RANGE, "durability[0].altitude: -0.1");
  REFUSED(points[2].altitude = 1.5, SCREE_ERROR_RANGE, "durability[2].altitude: 1.5");
  REFUSED(points[1].altitude = NAN, SCREE_ERROR_RANGE, "durability[1].altitude: not a number");
  REFUSED(points[1].durability = 0, SCREE_ERROR_RANGE, "durability[1].durability: 0");
  REFUSED(points[1].durability = -1, SCREE_ERROR_RANGE, "durability[1].durability: -1");
  REFUSED(points[1].durability = NAN, SCREE_ERROR_RANGE, "durability[1].durability: not a number");
  REFUSED(points[1].durability = INFINITY, SCREE_ERROR_RANGE, "durability[1].durability: infinity");
  REFUSED(points[0].noise_amplitude = NAN, SCREE_ERROR_RANGE, "noise_amplitude");
  REFUSED(points[0].noise_amplitude = 5, SCREE_ERROR_RANGE, "noise_amplitude");
  REFUSED(points[0].noise_period = 0.5, SCREE_ERROR_RANGE, "noise_period");
  REFUSED(points[0].noise_period = NAN, SCREE_ERROR_RANGE, "noise_period");
  REFUSED(points[0].noise_squash = 0.01, SCREE_ERROR_RANGE, "noise_squash");
  REFUSED(points[0].noise_squash = NAN, SCREE_ERROR_RANGE, "noise_squash");
  REFUSED(segments[0].altitude = 0.9, SCREE_ERROR_RANGE, "bubbles[1].altitude");
  REFUSED(segments[1].altitude = NAN, SCREE_ERROR_RANGE, "bubbles[1].altitude");
  REFUSED(segments[0].bubble_count = 5, SCREE_ERROR_RANGE, "bubbles[0].bubble_count: 5");
  REFUSED(segments[0].bubble_count = 0, SCREE_ERROR_RANGE, "bubbles[0].bubble_count: 0");
  REFUSED(segments[0].noise_period = NAN, SCREE_ERROR_RANGE, "bubbles[0].noise_period");
  REFUSED(segments[0].bubbles[1].radius = 13, SCREE_ERROR_RANGE, "bubbles[0].radius: 13");
  REFUSED(segments[0].bubbles[1].radius = 0.5, SCREE_ERROR_RANGE, "bubbles[0].radius");
  REFUSED(segments[0].bubbles[1].radius = NAN, SCREE_ERROR_RANGE, "bubbles[0].radius");
  REFUSED(segments[1].bubbles[0].kind = (scree_bubble_kind)4, SCREE_ERROR_RANGE, "bubbles[1].kind");
  REFUSED((segments[1].bubbles[0] = (scree_bubble){SCREE_BUBBLE_ELLIPSOID, 3, NAN}), SCREE_ERROR_RANGE, "bubbles[1].height");
  REFUSED((segments[1].bubbles[0] = (scree_bubble){SCREE_BUBBLE_ELLIPSOID, 3, 0}), SCREE_ERROR_RANGE, "bubbles[1].height: 0");
  REFUSED(desc.rules.spheroidal.kind = (scree_curve_kind)5, SCREE_ERROR_RANGE, "spheroidal.kind");
  REFUSED(desc.rules.spheroidal.gain = NAN, SCREE_ERROR_RANGE, "spheroidal.gain");
  REFUSED(desc.rules.spheroidal.gain = -1, SCREE_ERROR_RANGE, "spheroidal.gain");
  REFUSED((desc.rules.cavernous = (scree_curve){SCREE_CURVE_SATURATING, 1, NAN, 1, 1}), SCREE_ERROR_RANGE, "cavernous.threshold");
  REFUSED((desc.rules.cavernous = (scree_curve){SCREE_CURVE_SATURATING, 1, 0, 0, 1}), SCREE_ERROR_RANGE, "cavernous.saturation");
  REFUSED((desc.rules.cavernous = (scree_curve){SCREE_CURVE_SATURATING, 1, 0, NAN, 1}), SCREE_ERROR_RANGE, "cavernous.saturation");
  REFUSED((desc.rules.cavernous = (scree_curve){SCREE_CURVE_SATURATING, 1, 0, 1, 0}), SCREE_ERROR_RANGE, "cavernous.power");
  REFUSED(desc.rules.exposure = NAN, SCREE_ERROR_RANGE, "exposure");
  REFUSED(desc.rules.exposure = 2.5, SCREE_ERROR_RANGE, "exposure: 2.5");
  REFUSED(desc.rules.steps_per_voxel = 0, SCREE_ERROR_RANGE, "steps_per_voxel");
  REFUSED(desc.rules.steps_per_voxel = NAN, SCREE_ERROR_RANGE, "steps_per_voxel");
  REFUSED(desc.rules.colluvium_share = 1.5, SCREE_ERROR_RANGE, "colluvium_share");
  REFUSED(desc.rules.colluvium_share = NAN, SCREE_ERROR_RANGE, "colluvium_share");
  REFUSED(desc.rules.colluvium_durability = 0, SCREE_ERROR_RANGE, "colluvium_durability");
  REFUSED(desc.rules.colluvium_durability = NAN, SCREE_ERROR_RANGE, "colluvium_durability");
  REFUSED(desc.rules.repose = 0.01, SCREE_ERROR_RANGE, "repose");
  REFUSED(desc.rules.repose = NAN, SCREE_ERROR_RANGE, "repose");
  REFUSED(desc.rules.rockfall = (scree_rockfall)3, SCREE_ERROR_RANGE, "rockfall");
}

static void wrong_start_shapes_are_refused_by_name(void** state) {
  (void)state;
  static const uint8_t black[4] = {0, 0, 0, 0};
  scree_shape sphere = {.kind = SCREE_SHAPE_SPHERE, .sphere = {1}};
  const scree_support_desc support_desc = {.shapes = &sphere, .shape_count = 1};
  scree_support* support;
  assert_int_equal(scree_support_create(&support_desc, NULL, &support, NULL), SCREE_OK);
  REFUSED(desc.start.size[1] = 0, SCREE_ERROR_RANGE, "size[1]: 0");
  REFUSED(desc.start.size[2] = 4097, SCREE_ERROR_RANGE, "size[2]: 4097");
  REFUSED(desc.start.kind = (scree_start_kind)4, SCREE_ERROR_RANGE, "kind: 4");
  REFUSED(desc.start.box_max[0] = 31, SCREE_ERROR_RANGE, "box_max[0]: 31");
  REFUSED(desc.start.box_max[2] = 8, SCREE_ERROR_RANGE, "box_max[2]: 8");
  REFUSED((desc.start.kind = SCREE_START_JOINT_MAP), SCREE_ERROR_INVALID_ARGUMENT, "map: missing");
  REFUSED((desc.start.kind = SCREE_START_JOINT_MAP, desc.start.map = black, desc.start.map_depth = 2), SCREE_ERROR_RANGE,
          "map_width: 0");
  REFUSED((desc.start.kind = SCREE_START_JOINT_MAP, desc.start.map = black, desc.start.map_width = 2, desc.start.map_depth = 2),
          SCREE_ERROR_INVALID_ARGUMENT, "no voxel is rock");
  REFUSED((desc.start.kind = SCREE_START_SUPPORT), SCREE_ERROR_INVALID_ARGUMENT, "support: missing");
  REFUSED((desc.start.kind = SCREE_START_SUPPORT, desc.start.support = support), SCREE_ERROR_RANGE, "voxel: 0");
  REFUSED((desc.start.kind = SCREE_START_SUPPORT, desc.start.support = support, desc.start.voxel = NAN), SCREE_ERROR_RANGE,
          "voxel: not a number");
  REFUSED((desc.start.kind = SCREE_START_SUPPORT, desc.start.support = support, desc.start.voxel = 1, desc.start.origin[1] = NAN),
          SCREE_ERROR_RANGE, "origin");
  REFUSED((desc.start.kind = SCREE_START_SUPPORT, desc.start.support = support, desc.start.voxel = 1, desc.start.origin[1] = 100),
          SCREE_ERROR_INVALID_ARGUMENT, "no voxel is rock");
  REFUSED((desc.start.kind = SCREE_START_JOINTS), SCREE_ERROR_RANGE, "joint_spacing: 0");
  REFUSED((desc.start.kind = SCREE_START_JOINTS, desc.start.joint_spacing = 9, desc.start.joint_gap = 0.6), SCREE_ERROR_RANGE,
          "joint_gap");
  REFUSED((desc.start.kind = SCREE_START_JOINTS, desc.start.joint_spacing = 9, desc.start.joint_warp = NAN), SCREE_ERROR_RANGE,
          "joint_warp");
  REFUSED((desc.start.kind = SCREE_START_JOINTS, desc.start.joint_spacing = 9, desc.start.joint_missing = -1), SCREE_ERROR_RANGE,
          "joint_missing");
  REFUSED((desc.start.kind = SCREE_START_JOINTS, desc.start.joint_spacing = 9, desc.start.joint_low = 2), SCREE_ERROR_RANGE,
          "joint_low");
  REFUSED((desc.start.kind = SCREE_START_JOINTS, desc.start.joint_spacing = 9, desc.start.joint_missing = 1),
          SCREE_ERROR_INVALID_ARGUMENT, "no voxel is rock");
  scree_support_destroy(support);
}

static void a_radius_larger_than_the_grid_is_refused(void** state) {
  (void)state;
  REFUSED((desc.start = (scree_weather_start){.kind = SCREE_START_BOX, .size = {3, 3, 3}}, desc.rules.bubbles = some_segments),
          SCREE_ERROR_RANGE, "bubbles[0].radius: 4: larger than the grid");
}

static void a_grid_that_does_not_fit_is_refused_with_its_size(void** state) {
  (void)state;
  REFUSED((desc.start.size[0] = desc.start.size[1] = desc.start.size[2] = 4096), SCREE_ERROR_RANGE,
          "size: 4096 x 4096 x 4096 voxels take 5");
  scree_weather_desc desc = some_desc();
  const uint64_t bytes = scree_weather_memory(&desc);
  assert_true(bytes > 43200 * 7 && bytes < 43200 * 20);
  desc.memory_limit = (size_t)bytes - 1;
  assert_refused(&desc, SCREE_ERROR_RANGE, "memory_limit");
  desc.memory_limit = (size_t)bytes;
  failing_allocator memory = {.fail_at = -1};
  desc.allocator = failing_allocator_of(&memory);
  scree_weather* w;
  assert_int_equal(scree_weather_create(&desc, &w, NULL), SCREE_OK);
  assert_int_equal(stats_of(w).memory, bytes);
  assert_int_equal(memory.live, bytes);
  /* More rules than fit are refused, too. */
  scree_bubble_segment segments[64];
  for (int i = 0; i < 64; ++i)
    segments[i] = (scree_bubble_segment){
        i / 64.0, {{SCREE_BUBBLE_SPHERE, 11 + i / 128.0, 0}, {SCREE_BUBBLE_SPHERE, 10 + i / 128.0, 0}}, 2, 0};
  scree_weather_rules rules = default_rules();
  rules.bubbles = segments;
  rules.bubble_count = 64;
  scree_error error;
  const uint64_t digest = scree_weather_digest(w);
  assert_int_equal(scree_weather_set_rules(w, &rules, &error), SCREE_ERROR_RANGE);
  assert_non_null(strstr(error.message, "memory_limit"));
  assert_int_equal(memory.live, bytes);
  assert_int_equal(scree_weather_digest(w), digest);
  scree_weather_destroy(w);
  assert_int_equal(memory.live, 0);
}

/* --- memory
 * ----------------------------------------------------------------------------------------------------------------------- */

static void every_failing_allocation_is_reported_and_nothing_leaks(void** state) {
  (void)state;
  int32_t in_create = 0, in_save = 0, in_rules = 0;
  for (int32_t n = 0;; ++n) {
    failing_allocator memory = {.fail_at = n};
    scree_weather_desc desc = some_desc();
    desc.rules = default_rules(); /* without a mixture: that comes with set_rules */
    desc.allocator = failing_allocator_of(&memory);
    scree_weather* w;
    const scree_result created = scree_weather_create(&desc, &w, NULL);
    if (created != SCREE_OK) {
      assert_int_equal(created, SCREE_ERROR_OUT_OF_MEMORY);
      assert_null(w);
      assert_int_equal(memory.live, 0);
      ++in_create;
      continue;
    }
    const int32_t before = memory.calls;
    assert_int_equal(scree_weather_step(w, 6), SCREE_OK);
    assert_int_equal(memory.calls, before); /* steps allocate nothing */
    const uint64_t digest = scree_weather_digest(w);
    const int64_t live = memory.live;
    scree_weather_snapshot* snapshot;
    const scree_result saved = scree_weather_save(w, &snapshot);
    if (saved != SCREE_OK) {
      assert_int_equal(saved, SCREE_ERROR_OUT_OF_MEMORY);
      assert_null(snapshot);
      assert_int_equal(memory.live, live);
      ++in_save;
    }
    const int64_t with_snapshot = memory.live;
    const scree_weather_desc others = some_desc();
    const scree_result changed = scree_weather_set_rules(w, &others.rules, NULL);
    if (changed != SCREE_OK) {
      assert_int_equal(changed, SCREE_ERROR_OUT_OF_MEMORY);
      assert_int_equal(memory.live, with_snapshot);
      ++in_rules;
    }
    assert_int_equal(scree_weather_digest(w), digest);
    assert_int_equal(scree_weather_step(w, 2), SCREE_OK);
    scree_weather_forget(w, snapshot);
    scree_weather_destroy(w);
    assert_int_equal(memory.live, 0);
    if (!memory.failed) break;
  }
  assert_true(in_create >= 11);
  assert_int_equal(in_save, 5);
  assert_int_equal(in_rules, 3);
  scree_weather_destroy(NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_box_is_rock_and_nothing_else_is),
      cmocka_unit_test(grey_scales_the_height_of_a_column_and_black_is_none),
      cmocka_unit_test(a_support_is_rock_where_the_middles_of_voxels_are_inside),
      cmocka_unit_test(joints_cut_a_block_into_pillars_of_different_heights),
      cmocka_unit_test(a_run_stops_at_the_share_or_the_step_that_was_asked_for),
      cmocka_unit_test(a_run_tells_its_progress_and_can_be_cancelled),
      cmocka_unit_test(what_changes_stamps_its_brick),
      cmocka_unit_test(new_rules_leave_lives_and_voxels),
      cmocka_unit_test(a_snapshot_restores_to_the_bit),
      cmocka_unit_test(wrong_rules_are_refused_by_name),
      cmocka_unit_test(wrong_start_shapes_are_refused_by_name),
      cmocka_unit_test(a_radius_larger_than_the_grid_is_refused),
      cmocka_unit_test(a_grid_that_does_not_fit_is_refused_with_its_size),
      cmocka_unit_test(every_failing_allocation_is_reported_and_nothing_leaks),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
