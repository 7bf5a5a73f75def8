/* What weathering promises: the papers' claims as numbers, start shapes, snapshots, errors and memory. */
#include <math.h>
#include <scree/weather.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* after the four above */
#include <cmocka.h>

#include "make_weather.h"
#include "random_weather.h"
#include "weather_kernels.h"

static scree_weather_rules plain_rules(void) {
  scree_weather_rules rules;
  scree_weather_rules_default(&rules);
  rules.colluvium_share = 0;
  rules.rockfall = SCREE_ROCKFALL_NONE;
  return rules;
}

static uint8_t* voxels_of(const scree_weather* w) {
  uint8_t* voxels = malloc((size_t)w->size[0] * w->size[1] * w->size[2]);
  assert_non_null(voxels);
  scree_weather_voxels(w, voxels);
  return voxels;
}

static uint8_t voxel_at(const scree_weather* w, const uint8_t* voxels, int32_t x, int32_t y, int32_t z) {
  if (x < 0 || y < 0 || z < 0 || x >= (int32_t)w->size[0] || y >= (int32_t)w->size[1] || z >= (int32_t)w->size[2]) return 0;
  return voxels[(size_t)x + (size_t)w->size[0] * ((size_t)y + (size_t)w->size[1] * (size_t)z)];
}

/* --- the papers' claims --------------------------------------------------------------------------------------------------------
 */

/* The field of lives after one binomial blur: what surfaces are made of. */
static double blurred(const scree_weather* w, int32_t x, int32_t y, int32_t z) {
  double sum = 0;
  for (int32_t dz = -1; dz <= 1; ++dz)
    for (int32_t dy = -1; dy <= 1; ++dy)
      for (int32_t dx = -1; dx <= 1; ++dx) {
        if (weather_voxel(w, x + dx, y + dy, z + dz) == SCREE_VOXEL_AIR) continue;
        const double share = (2 - abs(dx)) * (2 - abs(dy)) * (2 - abs(dz));
        sum += share / 64 * (double)weather_life(w, (uint32_t)(x + dx), (uint32_t)(y + dy), (uint32_t)(z + dz));
      }
  return sum;
}

static double field_at(const scree_weather* w, const double p[3]) {
  int32_t cell[3];
  double t[3], sum = 0;
  for (int a = 0; a < 3; ++a) {
    cell[a] = (int32_t)floor(p[a] - 0.5);
    t[a] = p[a] - 0.5 - cell[a];
  }
  for (int corner = 0; corner < 8; ++corner) {
    double share = 1;
    for (int a = 0; a < 3; ++a) share *= (corner >> a & 1) != 0 ? t[a] : 1 - t[a];
    sum += share * blurred(w, cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1), cell[2] + (corner >> 2));
  }
  return sum;
}

/* How far from `middle` along `direction` the field falls below one half, coming from outside. */
static double radius_along(const scree_weather* w, const double middle[3], const double direction[3], double from) {
  double low = 0, high = from;
  for (double r = from; r > 0; r -= 0.25) {
    const double p[3] = {middle[0] + r * direction[0], middle[1] + r * direction[1], middle[2] + r * direction[2]};
    if (field_at(w, p) > 0.5) {
      low = r;
      high = r + 0.25;
      break;
    }
  }
  for (int i = 0; i < 20; ++i) {
    const double r = (low + high) / 2;
    const double p[3] = {middle[0] + r * direction[0], middle[1] + r * direction[1], middle[2] + r * direction[2]};
    if (field_at(w, p) > 0.5)
      low = r;
    else
      high = r;
  }
  return low;
}

typedef struct spread {
  double mean, deviation, least, most;
} spread;

static spread spread_of(const double* values, int count) {
  spread s = {0, 0, values[0], values[0]};
  for (int i = 0; i < count; ++i) {
    s.mean += values[i] / count;
    s.least = values[i] < s.least ? values[i] : s.least;
    s.most = values[i] > s.most ? values[i] : s.most;
  }
  for (int i = 0; i < count; ++i) s.deviation += (values[i] - s.mean) * (values[i] - s.mean) / count;
  s.deviation = sqrt(s.deviation);
  return s;
}

/* A cube of `side` voxels that hangs in the middle of the grid. */
static scree_weather_start cube_start(uint32_t side) {
  scree_weather_start start = {.kind = SCREE_START_BOX};
  for (int a = 0; a < 3; ++a) {
    start.size[a] = side + 24;
    start.box_min[a] = 12;
    start.box_max[a] = side + 12;
  }
  return start;
}

static double cube_deviation(double exposure) {
  const scree_weather_start start = cube_start(40);
  scree_weather_rules rules = plain_rules();
  rules.spheroidal.kind = SCREE_CURVE_QUARTIC;
  rules.exposure = exposure;
  scree_weather* w = make(&start, &rules);
  assert_int_equal(scree_weather_run(w, 0.2, 1000, NULL, NULL), SCREE_OK);
  const scree_weather_stats stats = stats_of(w);
  assert_true(stats.rock <= 12800 && stats.rock > 10000);
  enum { RAYS = 600 };
  double radii[RAYS];
  for (int i = 0; i < RAYS; ++i) {
    const double y = 1 - (2 * i + 1.0) / RAYS, across = sqrt(1 - y * y), angle = i * 2.399963229728653;
    const double middle[3] = {32, 32, 32}, direction[3] = {across * cos(angle), y, across * sin(angle)};
    radii[i] = radius_along(w, middle, direction, 28);
  }
  const spread s = spread_of(radii, RAYS);
  scree_weather_destroy(w);
  return s.deviation / s.mean;
}

static void a_cube_becomes_a_sphere(void** state) {
  (void)state;
  const double with = cube_deviation(0.6), without = cube_deviation(0);
  print_message("deviation of the radius: %.4f, without the exponent %.4f\n", with, without);
  assert_true(with <= 0.025);
  assert_true(without > with);
}

static void a_gumdrop_makes_a_round_top_and_a_flat_bottom(void** state) {
  (void)state;
  const scree_weather_start start = cube_start(40);
  scree_weather_rules rules = plain_rules();
  const scree_bubble_segment bubble = {.bubbles = {{SCREE_BUBBLE_GUMDROP, 7, 0}}, .bubble_count = 1};
  rules.bubbles = &bubble;
  rules.spheroidal.kind = SCREE_CURVE_QUARTIC;
  scree_weather* w = make(&start, &rules);
  assert_int_equal(scree_weather_run(w, 0.3, 1000, NULL, NULL), SCREE_OK);
  double radii[64];
  scree_weather_radii(w, radii);
  int low = 0, high = 63;
  while (radii[low] == 0) ++low;
  while (radii[high] == 0) --high;
  /* How many layers each end takes to become nine tenths as wide as the widest layer. */
  const double wide = 0.9 * spread_of(radii, 64).most;
  int bottom = 0, top = 0;
  while (radii[low + bottom] < wide) ++bottom;
  while (radii[high - top] < wide) ++top;
  print_message("flat within %d layers at the bottom, round over %d at the top\n", bottom, top);
  assert_true(bottom <= 4);
  assert_true(top >= 2 * bottom);
  scree_weather_destroy(w);
}

static void a_disc_makes_a_cylinder(void** state) {
  (void)state;
  const scree_weather_start start = cube_start(40);
  scree_weather_rules rules = plain_rules();
  const scree_bubble_segment bubble = {.bubbles = {{SCREE_BUBBLE_DISC, 6, 0}}, .bubble_count = 1};
  rules.bubbles = &bubble;
  rules.spheroidal.kind = SCREE_CURVE_QUARTIC;
  scree_weather* w = make(&start, &rules);
  assert_int_equal(scree_weather_run(w, 0.3, 1000, NULL, NULL), SCREE_OK);
  double radii[64];
  scree_weather_radii(w, radii);
  int low = 0, high = 63;
  while (radii[low] == 0) ++low;
  while (radii[high] == 0) --high;
  /* All layers but the rounded ends. */
  const int end = (high - low + 1) / 5;
  const spread layers = spread_of(radii + low + end, high - low + 1 - 2 * end);
  double round[180];
  for (int i = 0; i < 180; ++i) {
    const double middle[3] = {32, (low + high + 1) / 2.0, 32}, direction[3] = {cos(i * 0.0349066), 0, sin(i * 0.0349066)};
    round[i] = radius_along(w, middle, direction, 28);
  }
  const spread section = spread_of(round, 180);
  print_message("radius of layers %.2f +- %.4f, of a section %.2f +- %.4f, %d layers\n", layers.mean,
                layers.deviation / layers.mean, section.mean, section.deviation / section.mean, high - low + 1);
  assert_true(layers.deviation <= 0.01 * layers.mean);
  assert_true(section.deviation <= 0.03 * section.mean);
  scree_weather_destroy(w);
}

static void the_silhouette_follows_the_durability_graph(void** state) {
  (void)state;
  static const scree_durability_point points[8] = {{.altitude = 0, .durability = 1.7},    {.altitude = 0.14, .durability = 0.6},
                                                   {.altitude = 0.28, .durability = 1.2}, {.altitude = 0.42, .durability = 0.5},
                                                   {.altitude = 0.57, .durability = 1.5}, {.altitude = 0.71, .durability = 0.8},
                                                   {.altitude = 0.85, .durability = 1.4}, {.altitude = 1, .durability = 0.9}};
  const scree_weather_start start = {.kind = SCREE_START_BOX, .size = {104, 100, 104}};
  scree_weather_rules rules = plain_rules();
  rules.durability = points;
  rules.durability_count = 8;
  rules.spheroidal.kind = SCREE_CURVE_LINEAR;
  scree_weather* w = make(&start, &rules);
  assert_int_equal(scree_weather_run(w, 0.5, 1000, NULL, NULL), SCREE_OK);
  double radii[100], sum[5] = {0};
  scree_weather_radii(w, radii);
  /* The top layers are worn from above, too, as the papers say: they do not count. */
  for (uint32_t y = 0; y < 85; ++y) {
    const double d = (double)w->tables->layers[y].graph;
    sum[0] += radii[y];
    sum[1] += d;
    sum[2] += radii[y] * radii[y];
    sum[3] += d * d;
    sum[4] += radii[y] * d;
  }
  const double n = 85;
  const double correlation = (n * sum[4] - sum[0] * sum[1]) / sqrt((n * sum[2] - sum[0] * sum[0]) * (n * sum[3] - sum[1] * sum[1]));
  print_message("correlation %.3f\n", correlation);
  assert_true(correlation >= 0.9);
  scree_weather_destroy(w);
}

/* A wall on a floor: the fold between them runs along z at x = 24, y = 20. */
static scree_weather_start fold_start(uint8_t map[2]) {
  map[0] = 255;
  map[1] = 106; /* 20 of 48 layers */
  return (scree_weather_start){.kind = SCREE_START_JOINT_MAP, .size = {48, 48, 40}, .map = map, .map_width = 2, .map_depth = 1};
}

static void a_cavern_opens_at_the_fold_and_stops_growing(void** state) {
  (void)state;
  static const scree_bubble_segment bubble = {.bubbles = {{SCREE_BUBBLE_SPHERE, 8, 0}}, .bubble_count = 1};
  /* The walls' feet are folds with the ground, too: they are too hard to open. */
  static const scree_durability_point points[3] = {
      {.altitude = 0, .durability = 1e6}, {.altitude = 0.2, .durability = 1e6}, {.altitude = 0.2, .durability = 1}};
  uint8_t map[2];
  const scree_weather_start start = fold_start(map);
  scree_weather_rules rules = plain_rules();
  rules.durability = points;
  rules.durability_count = 3;
  rules.bubbles = &bubble;
  rules.spheroidal = (scree_curve){SCREE_CURVE_NONE, 0, 0, 0, 0};
  rules.cavernous = (scree_curve){SCREE_CURVE_SATURATING, 1.0 / 3, 0.15, 0.08, 1};
  rules.exposure = 0;
  scree_weather* w = make(&start, &rules);
  /* It opens at the fold. */
  assert_int_equal(scree_weather_step(w, 12), SCREE_OK);
  uint64_t opened = stats_of(w).start_rock - stats_of(w).rock;
  assert_true(opened > 50);
  for (int32_t z = 0; z < 40; ++z)
    for (int32_t y = 0; y < 48; ++y)
      for (int32_t x = 0; x < 48; ++x) {
        const bool was_rock = x < 24 || y < 20;
        if (was_rock && weather_voxel(w, x, y, z) == SCREE_VOXEL_AIR) assert_true(hypot(x + 0.5 - 24, y + 0.5 - 20) <= 6);
      }
  /* It grows, and then no more. */
  uint64_t volume[5] = {0};
  for (int quarter = 1; quarter <= 4; ++quarter) {
    assert_int_equal(scree_weather_step(w, 77), SCREE_OK);
    volume[quarter] = stats_of(w).start_rock - stats_of(w).rock;
  }
  print_message("hollow after each quarter: %u %u %u %u\n", (unsigned)volume[1], (unsigned)volume[2], (unsigned)volume[3],
                (unsigned)volume[4]);
  assert_true(volume[1] > 20 * opened);
  assert_true(volume[4] - volume[3] <= volume[4] / 100);
  /* The faces of the wall and the floor stand away from the fold. */
  for (int32_t z = 0; z < 40; ++z) {
    for (int32_t y = 32; y < 48; ++y) assert_int_equal(weather_voxel(w, 23, y, z), SCREE_VOXEL_ROCK);
    for (int32_t x = 46; x < 48; ++x) assert_int_equal(weather_voxel(w, x, 19, z), SCREE_VOXEL_ROCK);
  }
  scree_weather_destroy(w);
}

/* Tangent of the slope of the cone that a crumbling pillar leaves. */
static double cone_slope(double repose) {
  const scree_weather_start start = {
      .kind = SCREE_START_BOX, .size = {101, 60, 101}, .box_min = {46, 0, 46}, .box_max = {55, 60, 55}, .seed = 3};
  scree_weather_rules rules = plain_rules();
  rules.colluvium_share = 1;
  rules.colluvium_durability = 1e6;
  rules.repose = repose;
  rules.steps_per_voxel = 4;
  rules.rockfall = SCREE_ROCKFALL_COLLUVIUM;
  scree_weather* w = make(&start, &rules);
  assert_int_equal(scree_weather_step(w, 150), SCREE_OK);
  uint8_t* voxels = voxels_of(w);
  /* Mean heights of rings, from the pillar's top of rubble down to the foot. */
  double heights[50] = {0};
  int columns[50] = {0};
  for (int32_t z = 0; z < 101; ++z)
    for (int32_t x = 0; x < 101; ++x) {
      int32_t height = 0;
      while (voxel_at(w, voxels, x, height, z) != 0) ++height;
      const int ring = (int)hypot(x - 50.0, z - 50.0);
      if (ring >= 50) continue;
      heights[ring] += height;
      ++columns[ring];
    }
  int low = 6, high = 6;
  while (high < 49 && heights[high + 1] / columns[high + 1] > 1.5) ++high;
  free(voxels);
  scree_weather_destroy(w);
  assert_true(high - low >= 6);
  return (heights[low] / columns[low] - heights[high] / columns[high]) / (high - low);
}

static void colluvium_lies_at_its_angle_of_repose(void** state) {
  (void)state;
  static const double tangents[] = {0.25, 0.5, 0.7, 1, 1.5};
  for (int i = 0; i < 5; ++i) {
    const double slope = cone_slope(tangents[i]);
    print_message("repose %.3f: slope %.3f, %.1f instead of %.1f degrees\n", tangents[i], slope, atan(slope) * 57.29578,
                  atan(tangents[i]) * 57.29578);
    assert_true(fabs(atan(slope) - atan(tangents[i])) <= 2 / 57.29578);
  }
}

static bool something_hangs(const scree_weather* w) {
  const size_t count = (size_t)w->size[0] * w->size[1] * w->size[2];
  uint8_t* voxels = voxels_of(w);
  size_t* stack = malloc(count * sizeof *stack);
  assert_non_null(stack);
  const size_t nx = w->size[0], ny = w->size[1], nz = w->size[2];
  size_t depth = 0, left = 0;
  for (size_t z = 0; z < nz; ++z)
    for (size_t x = 0; x < nx; ++x) {
      const size_t at = x + nx * ny * z;
      if (voxels[at] == 0) continue;
      voxels[at] = 0;
      stack[depth++] = at;
    }
  while (depth > 0) {
    const size_t at = stack[--depth], x = at % nx, y = at / nx % ny, z = at / nx / ny;
    const size_t next[6] = {at + 1, at - 1, at + nx, at - nx, at + nx * ny, at - nx * ny};
    const bool there[6] = {x + 1 < nx, x > 0, y + 1 < ny, y > 0, z + 1 < nz, z > 0};
    for (int i = 0; i < 6; ++i)
      if (there[i] && voxels[next[i]] != 0) {
        voxels[next[i]] = 0;
        stack[depth++] = next[i];
      }
  }
  for (size_t i = 0; i < count; ++i) left += voxels[i] != 0;
  free(stack);
  free(voxels);
  return left > 0;
}

static void nothing_hangs_in_the_air_after_rockfall(void** state) {
  (void)state;
  random_stream random = {21};
  uint64_t fallen = 0;
  for (int i = 0; i < 30; ++i) {
    random_start start;
    random_rules rules;
    random_start_make(&random, 26, &start);
    random_rules_make(&random, 3, &rules);
    rules.rules.rockfall = i % 2 == 0 ? SCREE_ROCKFALL_DROP : SCREE_ROCKFALL_COLLUVIUM;
    const scree_weather_desc desc = {.start = start.start, .rules = rules.rules};
    scree_weather* w;
    if (scree_weather_create(&desc, &w, NULL) == SCREE_OK) {
      for (int step = 0; step < 10; ++step) {
        assert_int_equal(scree_weather_step(w, 1), SCREE_OK);
        assert_false(something_hangs(w));
        fallen += stats_of(w).fallen;
      }
      scree_weather_destroy(w);
    }
    random_start_free(&start);
  }
  assert_true(fallen > 1000);
}

/* A beam over three words of voxels, on one post: a snake of such beams, each on the end of the one below. */
static void a_beam_on_one_post_does_not_fall(void** state) {
  (void)state;
  for (int post = 0; post < 2; ++post) {
    scree_shape shapes[6];
    memset(shapes, 0, sizeof shapes);
    static const uint32_t children[5] = {1, 2, 3, 4, 5};
    shapes[0].kind = SCREE_SHAPE_UNION;
    shapes[0].group = (scree_group){children, 5, 0};
    for (int i = 1; i < 6; ++i) shapes[i].kind = SCREE_SHAPE_BOX;
    const float near = post == 0 ? 1 : 199, far = 200 - near;
    /* The post, a beam, what carries the next beam at its other end, that beam; and a cube that nothing carries. */
    for (int i = 1; i < 4; i += 2) {
      shapes[i].transform.translation[0] = i == 1 ? near : far;
      shapes[i].transform.translation[1] = i == 1 ? 3 : 9;
      shapes[i].box.half[0] = shapes[i].box.half[2] = 1;
      shapes[i].box.half[1] = 3;
      shapes[i + 1].transform.translation[0] = 100;
      shapes[i + 1].transform.translation[1] = i == 1 ? 7 : 13;
      shapes[i + 1].box.half[0] = 100;
      shapes[i + 1].box.half[1] = shapes[i + 1].box.half[2] = 1;
    }
    shapes[5].transform.translation[0] = 100;
    shapes[5].transform.translation[1] = 18;
    shapes[5].box.half[0] = shapes[5].box.half[1] = shapes[5].box.half[2] = 1;
    const scree_support_desc desc = {.shapes = shapes, .shape_count = 6};
    scree_support* support;
    assert_int_equal(scree_support_create(&desc, NULL, &support, NULL), SCREE_OK);
    const scree_weather_start start = {
        .kind = SCREE_START_SUPPORT, .size = {200, 20, 4}, .support = support, .voxel = 1, .origin = {0, 0, -2}};
    scree_weather_rules rules = plain_rules();
    rules.spheroidal.kind = SCREE_CURVE_NONE;
    rules.rockfall = SCREE_ROCKFALL_DROP;
    scree_weather* w = make(&start, &rules);
    assert_int_equal(scree_weather_step(w, 1), SCREE_OK);
    assert_int_equal(stats_of(w).fallen, 8);
    assert_false(something_hangs(w));
    scree_weather_destroy(w);
    scree_support_destroy(support);
  }
}

static void without_rockfall_a_cube_hangs(void** state) {
  (void)state;
  const scree_weather_start start = cube_start(10);
  scree_weather_rules rules = plain_rules();
  scree_weather* w = make(&start, &rules);
  assert_int_equal(scree_weather_step(w, 3), SCREE_OK);
  assert_true(something_hangs(w));
  rules.rockfall = SCREE_ROCKFALL_DROP;
  assert_int_equal(scree_weather_set_rules(w, &rules, NULL), SCREE_OK);
  const uint64_t rock = stats_of(w).rock;
  assert_int_equal(scree_weather_step(w, 1), SCREE_OK);
  assert_int_equal(stats_of(w).rock, 0);
  assert_int_equal(stats_of(w).fallen + stats_of(w).removed, rock);
  scree_weather_destroy(w);
}

/* A level plain loses a voxel in steps_per_voxel steps, whatever the curve and the bubble. */
static void a_level_plain_wears_at_the_rate_of_the_rules(void** state) {
  (void)state;
  const scree_weather_start start = {.kind = SCREE_START_BOX, .size = {41, 20, 41}};
  for (uint32_t kind = 0; kind < 4; ++kind)
    for (uint32_t curve = SCREE_CURVE_LINEAR; curve <= SCREE_CURVE_QUARTIC; ++curve) {
      const scree_bubble_segment bubble = {.bubbles = {{(scree_bubble_kind)kind, 5, 4}}, .bubble_count = 1};
      scree_weather_rules rules = plain_rules();
      rules.bubbles = &bubble;
      rules.spheroidal.kind = (scree_curve_kind)curve;
      rules.steps_per_voxel = 10.5;
      scree_weather* w = make(&start, &rules);
      assert_int_equal(scree_weather_step(w, 10), SCREE_OK);
      assert_int_equal(weather_voxel(w, 20, 19, 20), SCREE_VOXEL_ROCK);
      assert_int_equal(scree_weather_step(w, 1), SCREE_OK);
      assert_int_equal(weather_voxel(w, 20, 19, 20), SCREE_VOXEL_AIR);
      scree_weather_destroy(w);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_cube_becomes_a_sphere),
      cmocka_unit_test(a_gumdrop_makes_a_round_top_and_a_flat_bottom),
      cmocka_unit_test(a_disc_makes_a_cylinder),
      cmocka_unit_test(the_silhouette_follows_the_durability_graph),
      cmocka_unit_test(a_cavern_opens_at_the_fold_and_stops_growing),
      cmocka_unit_test(colluvium_lies_at_its_angle_of_repose),
      cmocka_unit_test(nothing_hangs_in_the_air_after_rockfall),
      cmocka_unit_test(a_beam_on_one_post_does_not_fall),
      cmocka_unit_test(without_rockfall_a_cube_hangs),
      cmocka_unit_test(a_level_plain_wears_at_the_rate_of_the_rules),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
