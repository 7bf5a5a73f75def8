/* Solids: what is closed and what is not, and terrains made into solids. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* after the five above */
#include <cmocka.h>

#include "failing_allocator.h"
#include "lattice.h"
#include "make_solid.h"
#include "one_line.h"

static const double zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};

static void a_box_is_closed(void** state) {
  (void)state;
  box_solid box;
  make_box(&box, zero, one);
  scree_error error;
  assert_int_equal(scree_solid_check(&box.solid, NULL, &error), SCREE_OK);
  assert_int_equal(scree_solid_check(&box.solid, NULL, NULL), SCREE_OK);
  assert_true(make_volume(&box.solid) == 1);
}

static void a_box_in_a_box_with_a_hollow_is_closed(void** state) {
  (void)state;
  box_solid box, hollow;
  make_box(&box, zero, one);
  make_box(&hollow, (const double[3]){0.25, 0.25, 0.25}, (const double[3]){0.5, 0.5, 0.5});
  double positions[48];
  uint32_t indices[72];
  memcpy(positions, box.positions, sizeof box.positions);
  memcpy(positions + 24, hollow.positions, sizeof hollow.positions);
  memcpy(indices, box.indices, sizeof box.indices);
  for (int i = 0; i < 36; ++i) indices[36 + i] = 8 + hollow.indices[i / 3 * 3 + 2 - i % 3];
  const scree_solid solid = {.positions = positions, .indices = indices, .vertex_count = 16, .triangle_count = 24};
  assert_int_equal(scree_solid_check(&solid, NULL, NULL), SCREE_OK);
  assert_true(fabs(make_volume(&solid) - (1 - 1.0 / 64)) < 1e-15);
}

static void an_open_box_is_told_with_the_edge_and_both_its_places(void** state) {
  (void)state;
  box_solid box;
  make_box(&box, zero, (const double[3]){2, 3, 5});
  box.solid.triangle_count = 11; /* without 4, 7, 6 of the top side */
  scree_error error;
  assert_int_equal(scree_solid_check(&box.solid, NULL, &error), SCREE_ERROR_NOT_CLOSED);
  assert_one_line(&error);
  assert_non_null(strstr(error.message, "from vertex 4 at (0, 0, 5) to vertex 6 at (0, 3, 5) has no triangle on its other side"));
  assert_int_equal(scree_solid_check(&box.solid, NULL, NULL), SCREE_ERROR_NOT_CLOSED);
}

static void a_doubled_triangle_is_told(void** state) {
  (void)state;
  box_solid box;
  make_box(&box, zero, one);
  uint32_t indices[39];
  memcpy(indices, box.indices, sizeof box.indices);
  memcpy(indices + 36, box.indices, 3 * sizeof *indices);
  box.solid.indices = indices;
  box.solid.triangle_count = 13;
  scree_error error;
  assert_int_equal(scree_solid_check(&box.solid, NULL, &error), SCREE_ERROR_NOT_CLOSED);
  assert_one_line(&error);
  assert_non_null(strstr(error.message,
                         "edge of triangle 12 from vertex 0 at (0, 0, 0) to vertex 4 at (0, 0, 1) is used by "
                         "another triangle in the same direction"));
}

static void what_is_not_a_solid_is_refused(void** state) {
  (void)state;
  scree_error error;
  box_solid box;
  make_box(&box, zero, one);
  scree_solid solid = box.solid;
  assert_int_equal(scree_solid_check(NULL, NULL, &error), SCREE_ERROR_INVALID_ARGUMENT);
  assert_one_line(&error);
  solid.triangle_count = 0;
  assert_int_equal(scree_solid_check(&solid, NULL, &error), SCREE_ERROR_INVALID_ARGUMENT);
  solid = box.solid, solid.positions = NULL;
  assert_int_equal(scree_solid_check(&solid, NULL, &error), SCREE_ERROR_INVALID_ARGUMENT);
  solid = box.solid, solid.vertex_count = 7;
  assert_int_equal(scree_solid_check(&solid, NULL, &error), SCREE_ERROR_INVALID_ARGUMENT);
  assert_one_line(&error);
  const double bad[] = {NAN, INFINITY, -1.1e6};
  for (int i = 0; i < 3; ++i) {
    make_box(&box, zero, one);
    box.positions[7] = bad[i];
    assert_int_equal(scree_solid_check(&box.solid, NULL, &error), SCREE_ERROR_RANGE);
    assert_one_line(&error);
  }
  make_box(&box, zero, one);
  float uvs[72] = {0};
  uvs[70] = NAN;
  box.solid.uvs = uvs;
  assert_int_equal(scree_solid_check(&box.solid, NULL, &error), SCREE_ERROR_RANGE);
  make_box(&box, zero, one);
  for (int t = 0; t < 12; ++t) {
    const uint32_t swap = box.indices[3 * t];
    box.indices[3 * t] = box.indices[3 * t + 1], box.indices[3 * t + 1] = swap;
  }
  assert_int_equal(scree_solid_check(&box.solid, NULL, &error), SCREE_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "inside out"));
  make_box(&box, zero, (const double[3]){1, 0, 1});
  assert_int_equal(scree_solid_check(&box.solid, NULL, &error), SCREE_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "no volume"));
  make_box(&box, zero, one);
  box.indices[1] = box.indices[0];
  assert_int_equal(scree_solid_check(&box.solid, NULL, &error), SCREE_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "twice"));
}

/* Heights that are multiples of 1/8, so that every sum is exact. */
static float* make_heights(uint32_t width, uint32_t depth, uint64_t seed) {
  float* heights = malloc((size_t)width * depth * sizeof *heights);
  assert_non_null(heights);
  for (uint32_t i = 0; i < width * depth; ++i) heights[i] = (float)(hash_combine(seed, i) % 64) / 8;
  return heights;
}

/* Below two triangles each, cut where heights differ less. */
static double heights_volume(const float* h, uint32_t width, uint32_t depth, double spacing, double base) {
  double sum = 0;
  for (uint32_t z = 0; z + 1 < depth; ++z)
    for (uint32_t x = 0; x + 1 < width; ++x) {
      const double a = (double)h[z * width + x] - base, b = (double)h[z * width + x + 1] - base;
      const double c = (double)h[(z + 1) * width + x] - base, d = (double)h[(z + 1) * width + x + 1] - base;
      sum += fabs(a - d) <= fabs(b - c) ? 2 * a + 2 * d + b + c : 2 * b + 2 * c + a + d;
    }
  return sum * spacing * spacing / 6;
}

static void heights_are_a_closed_solid_of_exactly_their_volume(void** state) {
  (void)state;
  const uint32_t sizes[][2] = {{2, 2}, {3, 2}, {2, 40}, {16, 17}, {17, 16}, {18, 33}, {50, 35}, {33, 33}};
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
    const uint32_t w = sizes[i][0], d = sizes[i][1];
    float* heights = make_heights(w, d, i);
    scree_solid_memory solid;
    scree_error error;
    assert_int_equal(scree_solid_from_heights(heights, w, d, 0.5, -2, NULL, &solid, &error), SCREE_OK);
    if (scree_solid_check(&solid.solid, NULL, &error) != SCREE_OK) fail_msg("%u x %u: %s", w, d, error.message);
    assert_true(fabs(make_volume(&solid.solid) - heights_volume(heights, w, d, 0.5, -2)) <
                1e-13 * heights_volume(heights, w, d, 0.5, -2));
    for (uint32_t v = 0; v < w * d; ++v) {
      assert_true(solid.solid.positions[3 * v] == (v % w - (w - 1) / 2.0) * 0.5);
      assert_true(solid.solid.positions[3 * v + 1] == (double)heights[v]);
      assert_true(solid.solid.positions[3 * v + 2] == (v / w - (d - 1) / 2.0) * 0.5);
    }
    for (uint32_t k = 0; k < 3 * solid.solid.triangle_count; ++k) {
      const double* p = solid.solid.positions + 3 * (size_t)solid.solid.indices[k];
      assert_true(fabs((double)solid.solid.uvs[2 * k] - (p[0] / ((w - 1) * 0.5) + 0.5)) < 1e-6);
      assert_true(fabs((double)solid.solid.uvs[2 * k + 1] - (p[2] / ((d - 1) * 0.5) + 0.5)) < 1e-6);
      assert_true(p[1] >= -2);
    }
    scree_solid_free(NULL, &solid);
    assert_null(solid.memory);
    free(heights);
  }
  scree_solid_free(NULL, &(scree_solid_memory){0});
  scree_solid_free(NULL, NULL);
}

static void no_triangle_of_a_large_terrains_base_is_long(void** state) {
  (void)state;
  float* heights = make_heights(200, 150, 9);
  scree_solid_memory solid;
  assert_int_equal(scree_solid_from_heights(heights, 200, 150, 1, -1, NULL, &solid, NULL), SCREE_OK);
  for (uint32_t k = 0; k < 3 * solid.solid.triangle_count; ++k) {
    const double* p = solid.solid.positions + 3 * (size_t)solid.solid.indices[k];
    const double* q = solid.solid.positions + 3 * (size_t)solid.solid.indices[k % 3 == 2 ? k - 2 : k + 1];
    assert_true(fabs(p[0] - q[0]) <= 16 && fabs(p[2] - q[2]) <= 16);
  }
  scree_solid_free(NULL, &solid);
  free(heights);
}

static void bad_heights_are_told(void** state) {
  (void)state;
  float heights[9] = {1, 1, 1, 1, 1, 1, 1, 1, 1};
  scree_solid_memory solid;
  scree_error error;
  assert_int_equal(scree_solid_from_heights(NULL, 3, 3, 1, 0, NULL, &solid, &error), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_solid_from_heights(heights, 1, 9, 1, 0, NULL, &solid, &error), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_solid_from_heights(heights, 3, 3, 1, 1, NULL, &solid, &error), SCREE_ERROR_INVALID_ARGUMENT);
  assert_one_line(&error);
  assert_int_equal(scree_solid_from_heights(heights, 3, 3, 0, 0, NULL, &solid, &error), SCREE_ERROR_RANGE);
  assert_int_equal(scree_solid_from_heights(heights, 3, 3, NAN, 0, NULL, &solid, &error), SCREE_ERROR_RANGE);
  assert_int_equal(scree_solid_from_heights(heights, 3, 3, 1e7, 0, NULL, &solid, &error), SCREE_ERROR_RANGE);
  assert_int_equal(scree_solid_from_heights(heights, 3, 3, 1, NAN, NULL, &solid, &error), SCREE_ERROR_RANGE);
  assert_int_equal(scree_solid_from_heights(heights, 1u << 31, 1u << 31, 1, 0, NULL, &solid, &error), SCREE_ERROR_RANGE);
  heights[5] = NAN;
  assert_int_equal(scree_solid_from_heights(heights, 3, 3, 1, 0, NULL, &solid, &error), SCREE_ERROR_RANGE);
  assert_non_null(strstr(error.message, "x 2, z 1"));
  assert_null(solid.memory);
}

static void solids_survive_every_failing_allocation(void** state) {
  (void)state;
  float heights[9] = {1, 1, 1, 1, 2, 1, 1, 1, 1};
  for (int32_t at = 0;; ++at) {
    failing_allocator failing = {.fail_at = at};
    const scree_allocator allocator = failing_allocator_of(&failing);
    scree_solid_memory solid;
    scree_result result = scree_solid_from_heights(heights, 3, 3, 1, 0, &allocator, &solid, NULL);
    if (result == SCREE_OK) result = scree_solid_check(&solid.solid, &allocator, NULL);
    assert_int_equal(result, failing.failed ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_OK);
    scree_solid_free(&allocator, &solid);
    assert_true(failing.live == 0);
    if (!failing.failed) break;
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_box_is_closed),
      cmocka_unit_test(a_box_in_a_box_with_a_hollow_is_closed),
      cmocka_unit_test(an_open_box_is_told_with_the_edge_and_both_its_places),
      cmocka_unit_test(a_doubled_triangle_is_told),
      cmocka_unit_test(what_is_not_a_solid_is_refused),
      cmocka_unit_test(heights_are_a_closed_solid_of_exactly_their_volume),
      cmocka_unit_test(no_triangle_of_a_large_terrains_base_is_long),
      cmocka_unit_test(bad_heights_are_told),
      cmocka_unit_test(solids_survive_every_failing_allocation),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
