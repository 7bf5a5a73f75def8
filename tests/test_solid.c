/* Solids: what is closed and what is not, and solids made from terrains, supports and triangles of any kind. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* after the five above */
#include <cmocka.h>

#include "allocator.h"
#include "failing_allocator.h"
#include "lattice.h"
#include "make_solids.h"
#include "must_create.h"
#include "one_line.h"
#include "winding_tree.h"

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

static void a_triangle_that_is_turned_over_is_told(void** state) {
  (void)state;
  box_solid box;
  make_box(&box, zero, one);
  uint32_t indices[36];
  memcpy(indices, box.indices, sizeof indices);
  indices[30] = box.indices[31];
  indices[31] = box.indices[30];
  box.solid.indices = indices;
  scree_error error;
  assert_int_equal(scree_solid_check(&box.solid, NULL, &error), SCREE_ERROR_NOT_CLOSED);
  assert_non_null(strstr(error.message, "is used by another triangle in the same direction"));
}

static void a_cone_of_many_sides_is_closed_until_a_side_is_taken(void** state) {
  (void)state;
  enum { SIDES = 200 };
  double positions[3 * (SIDES + 2)] = {0};
  uint32_t indices[6 * SIDES];
  positions[3 * SIDES + 1] = -1;
  positions[3 * SIDES + 4] = 2;
  for (uint32_t k = 0; k < SIDES; ++k) {
    const uint32_t after = (k + 1) % SIDES, corners[6] = {k, after, SIDES, after, k, SIDES + 1};
    positions[3 * k] = cos(k * (6.283185307179586 / SIDES));
    positions[3 * k + 2] = sin(k * (6.283185307179586 / SIDES));
    memcpy(indices + 6 * k, corners, sizeof corners);
  }
  scree_solid cone = {.positions = positions, .indices = indices, .vertex_count = SIDES + 2, .triangle_count = 2 * SIDES};
  assert_int_equal(scree_solid_check(&cone, NULL, NULL), SCREE_OK);
  --cone.triangle_count;
  assert_int_equal(scree_solid_check(&cone, NULL, NULL), SCREE_ERROR_NOT_CLOSED);
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

/* --- solids from samples ---------------------------------------------------------------------------------------------------- */

static const double* vertex_of(const scree_solid* s, uint32_t triangle, uint32_t corner) {
  return s->positions + (size_t)3 * s->indices[(size_t)3 * triangle + corner];
}

static double turn_of(const double* a, const double* b, const double* c, const double* d) {
  double u[3], v[3], w[3];
  for (int i = 0; i < 3; ++i) u[i] = b[i] - a[i], v[i] = c[i] - a[i], w[i] = d[i] - a[i];
  return u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0]);
}

/* Whether the segment goes through the triangle; touching does not count. */
static bool pierces(const double* p, const double* q, const double* const t[3]) {
  const double slack = 1e-13, low = turn_of(t[0], t[1], t[2], p), high = turn_of(t[0], t[1], t[2], q);
  if (!((low > slack && high < -slack) || (low < -slack && high > slack))) return false;
  const double a = turn_of(p, q, t[0], t[1]), b = turn_of(p, q, t[1], t[2]), c = turn_of(p, q, t[2], t[0]);
  return (a > slack && b > slack && c > slack) || (a < -slack && b < -slack && c < -slack);
}

static uint32_t count_crossings(const scree_solid* s) {
  uint32_t found = 0;
  for (uint32_t i = 0; i < s->triangle_count; ++i) {
    const double* t[3] = {vertex_of(s, i, 0), vertex_of(s, i, 1), vertex_of(s, i, 2)};
    double low[3], high[3];
    for (int a = 0; a < 3; ++a) {
      low[a] = fmin(t[0][a], fmin(t[1][a], t[2][a]));
      high[a] = fmax(t[0][a], fmax(t[1][a], t[2][a]));
    }
    for (uint32_t j = 0; j < s->triangle_count; ++j)
      for (uint32_t k = 0; k < 3; ++k) {
        const double *p = vertex_of(s, j, k), *q = vertex_of(s, j, (k + 1) % 3);
        bool apart = false;
        for (int a = 0; a < 3; ++a) apart |= (p[a] < low[a] && q[a] < low[a]) || (p[a] > high[a] && q[a] > high[a]);
        for (int c = 0; c < 3; ++c) apart |= p == t[c] || q == t[c];
        if (!apart) found += pierces(p, q, t);
      }
  }
  return found;
}

/* The triangles round each vertex are one fan. */
static void assert_vertices_are_manifold(const scree_solid* s) {
  uint32_t *uses = calloc(s->vertex_count, sizeof *uses), *start = calloc((size_t)s->vertex_count + 1, sizeof *start);
  uint32_t(*fan)[2] = malloc((size_t)3 * s->triangle_count * sizeof *fan);
  assert_true(uses != NULL && start != NULL && fan != NULL);
  for (uint32_t i = 0; i < 3 * s->triangle_count; ++i) ++start[s->indices[i] + 1];
  for (uint32_t v = 0; v < s->vertex_count; ++v) start[v + 1] += start[v];
  for (uint32_t i = 0; i < 3 * s->triangle_count; ++i) {
    const uint32_t v = s->indices[i], *t = s->indices + i / 3 * 3;
    uint32_t* to = fan[start[v] + uses[v]++];
    to[0] = t[(i % 3 + 1) % 3], to[1] = t[(i % 3 + 2) % 3];
  }
  for (uint32_t v = 0; v < s->vertex_count; ++v) {
    const uint32_t count = start[v + 1] - start[v];
    assert_true(count >= 3);
    uint32_t at = fan[start[v]][0], steps = 0;
    do {
      uint32_t k = 0;
      while (k < count && fan[start[v] + k][0] != at) ++k;
      assert_true(k < count);
      at = fan[start[v] + k][1];
    } while (++steps < count && at != fan[start[v]][0]);
    assert_int_equal(steps, count);
  }
  free(uses), free(start), free(fan);
}

static scree_solid_memory must_mesh(const scree_support* support, uint32_t resolution) {
  scree_solid_memory solid;
  scree_error error;
  if (scree_solid_from_support(support, resolution, NULL, &solid, &error) != SCREE_OK) fail_msg("%s", error.message);
  if (scree_solid_check(&solid.solid, NULL, &error) != SCREE_OK) fail_msg("%s", error.message);
  return solid;
}

static void a_sphere_keeps_its_place_and_volume(void** state) {
  (void)state;
  const scree_shape sphere = {.kind = SCREE_SHAPE_SPHERE, .sphere = {1.5f}};
  scree_support* support = must_create(&(scree_support_desc){.shapes = &sphere, .shape_count = 1, .origin = {1000, -20, 3}});
  scree_solid_memory solid = must_mesh(support, 24);
  const double volume = make_volume(&solid.solid), wanted = 4.0 / 3 * 3.141592653589793 * 1.5 * 1.5 * 1.5;
  assert_true(fabs(volume / wanted - 1) < 0.01);
  for (uint32_t v = 0; v < solid.solid.vertex_count; ++v) {
    const double* p = solid.solid.positions + 3 * (size_t)v;
    const double r = sqrt((p[0] - 1000) * (p[0] - 1000) + (p[1] + 20) * (p[1] + 20) + (p[2] - 3) * (p[2] - 3));
    assert_true(fabs(r - 1.5) < 0.1 * 3.0 / 24);
  }
  assert_int_equal(count_crossings(&solid.solid), 0);
  assert_vertices_are_manifold(&solid.solid);
  scree_solid_free(NULL, &solid);
  scree_support_destroy(support);
}

/* Each sample by itself: all configurations of cubes beside each other. */
static void noise_distance(void* user, const float* x, const float* y, const float* z, float* distance, uint32_t count) {
  const uint64_t* seed = user;
  for (uint32_t i = 0; i < count; ++i) {
    const uint64_t hash =
        hash_corner(*seed, (int32_t)floorf(x[i] * 7.3f), (int32_t)floorf(y[i] * 7.3f), (int32_t)floorf(z[i] * 7.3f));
    distance[i] = (float)(hash % 1000) / 1000 - 0.5f;
  }
}

static void any_samples_give_a_manifold_that_crosses_itself_almost_nowhere(void** state) {
  (void)state;
  uint32_t crossings = 0, triangles = 0;
  for (uint64_t seed = 0; seed < 3; ++seed) {
    const scree_shape shape = {.kind = SCREE_SHAPE_CALLBACK,
                               .callback = {noise_distance, (void*)&seed, 1000, {-1, -1, -1}, {1, 1, 1}}};
    scree_support* support = one_shape(&shape);
    scree_solid_memory solid = must_mesh(support, 11);
    assert_vertices_are_manifold(&solid.solid);
    crossings += count_crossings(&solid.solid);
    triangles += solid.solid.triangle_count;
    scree_solid_free(NULL, &solid);
    scree_support_destroy(support);
  }
  assert_true(triangles > 10000);
  assert_true(crossings * 1000 < triangles);
}

static void supports_without_an_inside_or_an_end_are_told(void** state) {
  (void)state;
  scree_error error;
  scree_solid_memory solid;
  const scree_shape plane = {.kind = SCREE_SHAPE_HALF_SPACE}, sphere = {.kind = SCREE_SHAPE_SPHERE, .sphere = {1}};
  scree_support *endless = one_shape(&plane), *ball = one_shape(&sphere);
  assert_int_equal(scree_solid_from_support(endless, 32, NULL, &solid, &error), SCREE_ERROR_INVALID_ARGUMENT);
  assert_one_line(&error);
  assert_non_null(strstr(error.message, "no end"));
  assert_int_equal(scree_solid_from_support(NULL, 32, NULL, &solid, &error), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_solid_from_support(ball, 7, NULL, &solid, &error), SCREE_ERROR_RANGE);
  assert_int_equal(scree_solid_from_support(ball, 513, NULL, &solid, &error), SCREE_ERROR_RANGE);
  scree_support_destroy(endless);
  scree_support_destroy(ball);
  const uint32_t children[2] = {1, 2};
  const scree_shape nothing[3] = {{.kind = SCREE_SHAPE_DIFFERENCE, .group = {children, 2, 0}}, sphere, sphere};
  scree_support* empty = must_create(&(scree_support_desc){.shapes = nothing, .shape_count = 3});
  assert_int_equal(scree_solid_from_support(empty, 32, NULL, &solid, &error), SCREE_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "nothing"));
  scree_support_destroy(empty);
}

/* --- meshed anew ------------------------------------------------------------------------------------------------------------ */

static double slow_winding(const scree_solid* solid, const double* p) {
  double sum = 0;
  for (uint32_t t = 0; t < solid->triangle_count; ++t) {
    double v[3][3], l[3], dots[3];
    const double here[3] = {0, 0, 0};
    for (uint32_t k = 0; k < 3; ++k) {
      for (int a = 0; a < 3; ++a) v[k][a] = vertex_of(solid, t, k)[a] - p[a];
      l[k] = sqrt(v[k][0] * v[k][0] + v[k][1] * v[k][1] + v[k][2] * v[k][2]);
    }
    for (int k = 0; k < 3; ++k) dots[k] = v[k][0] * v[(k + 1) % 3][0] + v[k][1] * v[(k + 1) % 3][1] + v[k][2] * v[(k + 1) % 3][2];
    sum += 2 * atan2(turn_of(here, v[0], v[1], v[2]), l[0] * l[1] * l[2] + dots[0] * l[2] + dots[1] * l[0] + dots[2] * l[1]);
  }
  return sum / (4 * 3.141592653589793);
}

static scree_solid solid_of(const solid_mesh* mesh) {
  return (scree_solid){.positions = mesh->positions,
                       .indices = mesh->indices,
                       .vertex_count = mesh->vertex_count,
                       .triangle_count = mesh->triangle_count};
}

static void repeatable_angles_are_angles(void** state) {
  (void)state;
  for (int i = -400; i <= 400; ++i)
    for (int j = -40; j <= 40; ++j) {
      const double y = i / 100.0, x = j / 7.0;
      if (i == 0 && j <= 0) continue;
      assert_true(fabs(repeatable_atan2(y, x) - atan2(y, x)) < 1e-12);
    }
}

static void the_tree_winds_as_all_triangles_do(void** state) {
  (void)state;
  solid_mesh torus = solid_torus(1, 0.4, 40, 20);
  scree_solid solid = solid_of(&torus);
  solid.triangle_count -= 137; /* open */
  const scree_allocator allocator = scree_rt_allocator_or_default(NULL);
  winding_tree tree;
  assert_int_equal(winding_tree_create(solid.positions, solid.indices, solid.triangle_count, &allocator, &tree), SCREE_OK);
  uint64_t random = 0;
  double worst = 0;
  for (int i = 0; i < 1500; ++i) {
    double p[3];
    for (int a = 0; a < 3; ++a) p[a] = (double)(hash_mix(++random) % 4001) / 1000 - 2;
    worst = fmax(worst, fabs(winding_tree_at(&tree, p) - slow_winding(&solid, p)));
  }
  assert_true(worst < 0.03);
  winding_tree_free(&tree, &allocator);
  solid_mesh_free(&torus);
}

static scree_solid_memory must_remesh(const scree_solid* from, uint32_t resolution) {
  scree_solid_memory solid;
  scree_error error;
  if (scree_solid_remesh(from, resolution, NULL, &solid, &error) != SCREE_OK) fail_msg("%s", error.message);
  if (scree_solid_check(&solid.solid, NULL, &error) != SCREE_OK) fail_msg("%s", error.message);
  return solid;
}

static void an_open_mesh_is_closed_and_keeps_its_volume(void** state) {
  (void)state;
  solid_mesh torus = solid_torus(1, 0.4, 48, 24);
  scree_solid solid = solid_of(&torus);
  const double volume = make_volume(&solid);
  solid.triangle_count -= 60; /* of 2304 */
  assert_int_equal(scree_solid_check(&solid, NULL, NULL), SCREE_ERROR_NOT_CLOSED);
  scree_solid_memory anew = must_remesh(&solid, 28);
  assert_true(fabs(make_volume(&anew.solid) / volume - 1) < 0.03);
  assert_int_equal(count_crossings(&anew.solid), 0);
  scree_solid_free(NULL, &anew);
  solid_mesh_free(&torus);
}

static void crossing_doubled_and_torn_triangles_are_one_solid(void** state) {
  (void)state;
  /* Three boxes, two of which cross and one is there twice, all triangles with vertices of their own. */
  const double boxes[4][2][3] = {
      {{0, 0, 0}, {2, 1, 1}}, {{1, 0.25, 0.25}, {3, 0.75, 0.75}}, {{5, 0, 0}, {6, 1, 1}}, {{5, 0, 0}, {6, 1, 1}}};
  double positions[4 * 108];
  uint32_t indices[4 * 36];
  for (uint32_t i = 0; i < 4 * 36; ++i) {
    box_solid box;
    make_box(&box, boxes[i / 36][0], boxes[i / 36][1]);
    memcpy(positions + 3 * i, box.positions + 3 * box.indices[i % 36], 3 * sizeof(double));
    indices[i] = i;
  }
  const scree_solid soup = {.positions = positions, .indices = indices, .vertex_count = 4 * 36, .triangle_count = 4 * 12};
  assert_int_equal(scree_solid_check(&soup, NULL, NULL), SCREE_ERROR_NOT_CLOSED);
  assert_true(count_crossings(&soup) > 0);
  scree_solid_memory anew = must_remesh(&soup, 150);
  assert_true(fabs(make_volume(&anew.solid) / (2 + 0.25 + 1) - 1) < 0.01);
  scree_solid_free(NULL, &anew);
}

/* The real thing, where it is there. */
static void meshes_from_files_are_made_anew(void** state) {
  static const char* const names[] = {"bunny00.off", "armadillo.off", "knot1.off", "elephant.off"};
  uint32_t read = 0;
  for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
    char file[512];
    snprintf(file, sizeof file, "%s/%s", (const char*)*state, names[i]);
    solid_mesh mesh;
    if (!solid_read_off(file, &mesh)) continue;
    ++read;
    scree_solid solid = solid_of(&mesh);
    scree_solid_memory anew = must_remesh(&solid, 48);
    const double volume = make_volume(&anew.solid), whole = make_volume(&solid);
    const bool closed = scree_solid_check(&solid, NULL, NULL) == SCREE_OK;
    if (closed) assert_true(fabs(volume / whole - 1) < 0.02);
    scree_solid_free(NULL, &anew);
    if (i == 0) { /* torn: every 40th triangle is gone */
      uint32_t kept = 0;
      for (uint32_t t = 0; t < mesh.triangle_count; ++t)
        if (t % 40 != 7) memmove(mesh.indices + (size_t)3 * kept++, mesh.indices + (size_t)3 * t, 3 * sizeof *mesh.indices);
      solid.triangle_count = kept;
      assert_int_equal(scree_solid_check(&solid, NULL, NULL), SCREE_ERROR_NOT_CLOSED);
      anew = must_remesh(&solid, 24);
      assert_true(fabs(make_volume(&anew.solid) / volume - 1) < 0.08);
      scree_solid_free(NULL, &anew);
    }
    solid_mesh_free(&mesh);
  }
  if (read == 0) {
    print_message("no meshes in %s: `./dev` fetches them\n", (const char*)*state);
    skip();
  }
}

static uint64_t digest(const scree_solid* s) {
  uint64_t hash = hash_combine(s->vertex_count, s->triangle_count);
  for (size_t i = 0; i < (size_t)3 * s->vertex_count; ++i) {
    uint64_t bits;
    memcpy(&bits, &s->positions[i], sizeof bits);
    hash = hash_combine(hash, bits);
  }
  for (size_t i = 0; i < (size_t)3 * s->triangle_count; ++i) hash = hash_combine(hash, s->indices[i]);
  return hash;
}

static void solids_are_the_same_everywhere(void** state) {
  (void)state;
  static const uint64_t wanted[4] = {UINT64_C(0xb0ec3b56b98b9d36), UINT64_C(0x35c7ddb39470b763), UINT64_C(0x387a35a657161f74),
                                     UINT64_C(0x994d330111ba57c0)};
  box_solid box;
  make_box(&box, zero, (const double[3]){1, 2, 3});
  const scree_shape shape = {.kind = SCREE_SHAPE_TORUS, .torus = {2, 0.7f}};
  scree_support* support = one_shape(&shape);
  float* heights = make_heights(20, 9, 3);
  scree_solid_memory solids[4];
  solids[0] = must_mesh(support, 20);
  solids[1] = must_remesh(&box.solid, 11);
  box.solid.triangle_count = 7;
  solids[2] = must_remesh(&box.solid, 11);
  assert_int_equal(scree_solid_from_heights(heights, 20, 9, 0.3, -2, NULL, &solids[3], NULL), SCREE_OK);
  bool same = true;
  for (int i = 0; i < 4; ++i) {
    if (digest(&solids[i].solid) != wanted[i])
      same = false, print_error("solid %d has the digest 0x%016llx\n", i, (unsigned long long)digest(&solids[i].solid));
    scree_solid_free(NULL, &solids[i]);
  }
  assert_true(same);
  free(heights);
  scree_support_destroy(support);
}

static void hostile_triangles_are_meshed_or_refused(void** state) {
  (void)state;
  uint64_t random = 4;
  for (int round = 0; round < 40; ++round) {
    double positions[60];
    uint32_t indices[120];
    for (int i = 0; i < 60; ++i) {
      const double unit = (double)(hash_mix(++random) % 1000) / 1000;
      positions[i] = round % 3 == 0 ? floor(unit * 3) : round % 3 == 1 ? unit : (unit - 0.5) * 1e6;
    }
    for (int i = 0; i < 120; ++i) indices[i] = (uint32_t)(hash_mix(++random) % 20);
    const scree_solid soup = {.positions = positions, .indices = indices, .vertex_count = 20, .triangle_count = 40};
    scree_solid_memory anew;
    const scree_result result = scree_solid_remesh(&soup, 16, NULL, &anew, NULL);
    assert_true(result == SCREE_OK || result == SCREE_ERROR_INVALID_ARGUMENT);
    if (result == SCREE_OK) assert_int_equal(scree_solid_check(&anew.solid, NULL, NULL), SCREE_OK);
    scree_solid_free(NULL, &anew);
  }
  box_solid box;
  make_box(&box, zero, one);
  scree_solid_memory anew;
  scree_error error;
  assert_int_equal(scree_solid_remesh(&box.solid, 7, NULL, &anew, &error), SCREE_ERROR_RANGE);
  assert_one_line(&error);
  make_box(&box, zero, (const double[3]){1e6, 1, 1}); /* no room for what is outside */
  assert_int_equal(scree_solid_remesh(&box.solid, 16, NULL, &anew, &error), SCREE_ERROR_RANGE);
  assert_one_line(&error);
  box.positions[3] = NAN;
  assert_int_equal(scree_solid_remesh(&box.solid, 16, NULL, &anew, &error), SCREE_ERROR_RANGE);
  memset(&box, 0, sizeof box.positions);
  assert_int_equal(scree_solid_remesh(&box.solid, 16, NULL, &anew, &error), SCREE_ERROR_INVALID_ARGUMENT);
  assert_one_line(&error);
}

static void solids_from_samples_survive_every_failing_allocation(void** state) {
  (void)state;
  const scree_shape shape = {.kind = SCREE_SHAPE_SPHERE, .sphere = {1}};
  scree_support* support = one_shape(&shape);
  for (int way = 0; way < 3; ++way)
    for (int32_t at = 0;; ++at) {
      box_solid box;
      make_box(&box, zero, one);
      if (way == 2) box.solid.triangle_count = 11;
      failing_allocator failing = {.fail_at = at};
      const scree_allocator allocator = failing_allocator_of(&failing);
      scree_solid_memory solid;
      const scree_result result = way == 0 ? scree_solid_from_support(support, 9, &allocator, &solid, NULL)
                                           : scree_solid_remesh(&box.solid, 9, &allocator, &solid, NULL);
      assert_int_equal(result, failing.failed ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_OK);
      scree_solid_free(&allocator, &solid);
      assert_true(failing.live == 0);
      if (!failing.failed) break;
    }
  scree_support_destroy(support);
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

int main(int count, char** arguments) {
  const char* data = count > 1 ? arguments[1] : ".";
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_box_is_closed),
      cmocka_unit_test(a_box_in_a_box_with_a_hollow_is_closed),
      cmocka_unit_test(an_open_box_is_told_with_the_edge_and_both_its_places),
      cmocka_unit_test(a_doubled_triangle_is_told),
      cmocka_unit_test(a_triangle_that_is_turned_over_is_told),
      cmocka_unit_test(a_cone_of_many_sides_is_closed_until_a_side_is_taken),
      cmocka_unit_test(what_is_not_a_solid_is_refused),
      cmocka_unit_test(heights_are_a_closed_solid_of_exactly_their_volume),
      cmocka_unit_test(no_triangle_of_a_large_terrains_base_is_long),
      cmocka_unit_test(bad_heights_are_told),
      cmocka_unit_test(solids_survive_every_failing_allocation),
      cmocka_unit_test(a_sphere_keeps_its_place_and_volume),
      cmocka_unit_test(any_samples_give_a_manifold_that_crosses_itself_almost_nowhere),
      cmocka_unit_test(supports_without_an_inside_or_an_end_are_told),
      cmocka_unit_test(repeatable_angles_are_angles),
      cmocka_unit_test(the_tree_winds_as_all_triangles_do),
      cmocka_unit_test(an_open_mesh_is_closed_and_keeps_its_volume),
      cmocka_unit_test(crossing_doubled_and_torn_triangles_are_one_solid),
      cmocka_unit_test_prestate(meshes_from_files_are_made_anew, (void*)(uintptr_t)data),
      cmocka_unit_test(solids_are_the_same_everywhere),
      cmocka_unit_test(hostile_triangles_are_meshed_or_refused),
      cmocka_unit_test(solids_from_samples_survive_every_failing_allocation),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
