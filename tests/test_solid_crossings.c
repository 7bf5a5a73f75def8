/* Meshes that cross themselves are told with their triangles and the place; those that only touch themselves are not. */
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
#include <scree/shard_recipe.h>

#include "failing_allocator.h"
#include "make_solids.h"
#include "one_line.h"
#include "orientation.h"
#include "rounds.h"
#include "solid_crossings.h"
#include "triangle_tree.h"

static const char* folder = ".";
static const double zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};

static uint32_t draw(uint64_t* stream, uint32_t below) {
  *stream = *stream * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
  return (uint32_t)((*stream >> 33) % below);
}

/* --- signs ------------------------------------------------------------------------------------------------------------------- */

/* Of points with small whole coordinates. */
static int64_t whole_determinant(const double* a, const double* b, const double* c, const double* d) {
  int64_t u[3], v[3], w[3];
  for (int k = 0; k < 3; ++k) u[k] = (int64_t)(b[k] - a[k]), v[k] = (int64_t)(c[k] - a[k]), w[k] = (int64_t)(d[k] - a[k]);
  return (u[1] * v[2] - u[2] * v[1]) * w[0] + (u[2] * v[0] - u[0] * v[2]) * w[1] + (u[0] * v[1] - u[1] * v[0]) * w[2];
}

static int sign(int64_t x) {
  return (x > 0) - (x < 0);
}

static void signs_are_those_of_whole_numbers(void** state) {
  (void)state;
  uint64_t stream = 1;
  uint32_t flat = 0;
  for (int round = 0; round < ROUNDS(200000, 10); ++round) {
    double p[4][3];
    const uint32_t range = round % 2 ? 4 : 1 << 18;
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 3; ++k) p[i][k] = draw(&stream, range);
    if (round % 3 == 0) /* in the plane of the others, or one off */
      for (int k = 0; k < 3; ++k) p[3][k] = p[0][k] + p[1][k] - p[2][k];
    if (round % 6 == 0) p[3][round / 6 % 3] += 1;
    const int expected = sign(whole_determinant(p[0], p[1], p[2], p[3]));
    flat += expected == 0;
    /* Far away and small, where no difference is exact in a double product. */
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 3; ++k) p[i][k] = p[i][k] * 0x1p-30 + (k + 1) * 300;
    assert_int_equal(orientation(p[0], p[1], p[2], p[3]), expected);
    assert_int_equal(orientation_exact(p[0], p[1], p[2], p[3]), expected);
    const double(*q)[3] = (const double(*)[3])p;
    const double x0 = (q[0][0] - q[2][0]) * 0x1p30, y0 = (q[0][1] - q[2][1]) * 0x1p30;
    const double x1 = (q[1][0] - q[2][0]) * 0x1p30, y1 = (q[1][1] - q[2][1]) * 0x1p30;
    const int64_t area = (int64_t)x0 * (int64_t)y1 - (int64_t)y0 * (int64_t)x1;
    assert_int_equal(orientation_flat(p[0], p[1], p[2], 0, 1), sign(area));
  }
  assert_true(flat > 1000);
}

static void signs_hold_to_the_last_bit(void** state) {
  (void)state;
  /* Differences have more digits than a double, so that the determinant's sign lies in what products round away. */
  const double tiny = 0x1p-52;
  const double a[3] = {1 + tiny, 1, 0x1p-40}, b[3] = {-1e6, 0.1, 3}, c[3] = {0.3, -0x1p-45, 1e5};
  double d[3];
  for (int k = 0; k < 3; ++k) d[k] = a[k];
  assert_int_equal(orientation(a, b, c, d), 0);
  int seen[3] = {0};
  for (int k = 0; k < 3; ++k)
    for (int up = -1; up <= 1; up += 2) {
      memcpy(d, a, sizeof d);
      d[k] = nextafter(a[k], up * 1e9);
      const int here = orientation(a, b, c, d);
      memcpy(d, a, sizeof d);
      d[k] = a[k] + up; /* the same way, far enough for any arithmetic */
      assert_int_equal(here, orientation(a, b, c, d));
      assert_int_equal(here, orientation_exact(a, b, c, d));
      ++seen[here + 1];
    }
  assert_true(seen[0] == 3 && seen[1] == 0 && seen[2] == 3);
}

/* --- the plain twin: whole numbers, all pairs -------------------------------------------------------------------------------- */

static void whole_normal(const int64_t p[3][3], int64_t out[3]) {
  int64_t u[3], v[3];
  for (int k = 0; k < 3; ++k) u[k] = p[1][k] - p[0][k], v[k] = p[2][k] - p[0][k];
  for (int k = 0; k < 3; ++k) out[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
}

static int64_t whole_dot(const int64_t a[3], const int64_t b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Where along a line an open triangle meets a plane: two fractions, denominators > 0. False: it does not go through. */
typedef struct fraction {
  int64_t above, below;
} fraction;

static bool twin_stretch(const int64_t p[3][3], const int64_t normal[3], const int64_t at[3], const int64_t line[3],
                         fraction out[2]) {
  int64_t h[3];
  bool up = false, down = false;
  for (int k = 0; k < 3; ++k) {
    const int64_t d[3] = {p[k][0] - at[0], p[k][1] - at[1], p[k][2] - at[2]};
    h[k] = whole_dot(d, normal);
    up |= h[k] > 0, down |= h[k] < 0;
  }
  if (!up || !down) return false;
  int found = 0;
  for (int k = 0; k < 3; ++k) {
    const int m = (k + 1) % 3;
    if (h[k] == 0) out[found++] = (fraction){whole_dot(p[k], line), 1};
    if (h[k] * h[m] >= 0) continue;
    const int64_t above = whole_dot(p[k], line) * h[m] - whole_dot(p[m], line) * h[k], below = h[m] - h[k];
    out[found++] = below > 0 ? (fraction){above, below} : (fraction){-above, -below};
  }
  if (out[0].above * out[1].below > out[1].above * out[0].below) {
    const fraction swap = out[0];
    out[0] = out[1], out[1] = swap;
  }
  return true;
}

/* Whether insides of triangles of a plane meet: some point of thirds between corners and crossings of sides lies in both. In the
 * plane without the axis along which the normal is not 0. */
static int64_t flat_area(const int64_t* a, const int64_t* b, const int64_t* c, int x, int y) {
  return (b[x] - a[x]) * (c[y] - a[y]) - (b[y] - a[y]) * (c[x] - a[x]);
}

static bool twin_overlap(const int64_t p[3][3], const int64_t q[3][3], const int64_t normal[3]) {
  const int axis = normal[0] != 0 ? 0 : normal[1] != 0 ? 1 : 2, x = (axis + 1) % 3, y = (axis + 2) % 3;
  const int64_t turn = sign(normal[axis]);
  /* Apart where a side of one has the other beyond it: tried as lines through all pairs of corners of both. */
  const int64_t* all[6] = {p[0], p[1], p[2], q[0], q[1], q[2]};
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      if (all[i][x] == all[j][x] && all[i][y] == all[j][y]) continue;
      bool parts = true;
      for (int c = 0; c < 3; ++c)
        parts = parts && turn * flat_area(all[i], all[j], p[c], x, y) >= 0 && turn * flat_area(all[i], all[j], q[c], x, y) <= 0;
      if (parts) return false;
    }
  return true;
}

static bool twin_cross(const double* positions, const uint32_t* a, const uint32_t* b) {
  int64_t p[3][3], q[3][3], n[3], m[3], line[3];
  int common = 0;
  for (int c = 0; c < 3; ++c) {
    common += a[c] == b[0] || a[c] == b[1] || a[c] == b[2];
    for (int k = 0; k < 3; ++k)
      p[c][k] = (int64_t)positions[3 * a[c] + (uint32_t)k], q[c][k] = (int64_t)positions[3 * b[c] + (uint32_t)k];
  }
  if (common > 1) return false;
  whole_normal((const int64_t(*)[3])p, n);
  whole_normal((const int64_t(*)[3])q, m);
  if (whole_dot(n, n) == 0 || whole_dot(m, m) == 0) return false;
  for (int k = 0; k < 3; ++k) line[k] = n[(k + 1) % 3] * m[(k + 2) % 3] - n[(k + 2) % 3] * m[(k + 1) % 3];
  if (whole_dot(line, line) == 0) {
    const int64_t d[3] = {q[0][0] - p[0][0], q[0][1] - p[0][1], q[0][2] - p[0][2]};
    return whole_dot(d, n) == 0 && whole_dot(n, m) > 0 && twin_overlap((const int64_t(*)[3])p, (const int64_t(*)[3])q, n);
  }
  fraction s[2], t[2];
  if (!twin_stretch((const int64_t(*)[3])p, m, q[0], line, s) || !twin_stretch((const int64_t(*)[3])q, n, p[0], line, t))
    return false;
  return s[0].above * t[1].below < t[1].above * s[0].below && t[0].above * s[1].below < s[1].above * t[0].below;
}

static double off_triangle(const double* positions, const uint32_t* t, const double place[3]) {
  return sqrt(distance2_to_triangle(place, positions + 3 * t[0], positions + 3 * t[1], positions + 3 * t[2]));
}

static void the_first_crossing_is_that_of_all_pairs(void** state) {
  (void)state;
  enum { VERTICES = 40, TRIANGLES = 30 };
  uint64_t stream = 7;
  uint32_t clean = 0, dirty = 0, touching = 0, flat = 0;
  for (int round = 0; round < ROUNDS(20000, 10); ++round) {
    double positions[3 * VERTICES], moved[3 * VERTICES];
    uint32_t indices[3 * TRIANGLES];
    const uint32_t range = 2 + draw(&stream, 7), count = 2 + draw(&stream, round % 4 == 0 ? TRIANGLES - 1 : 4);
    for (int i = 0; i < 3 * VERTICES; ++i) {
      positions[i] = i % 3 == 1 && round % 5 == 0 ? 1 : draw(&stream, range);
      moved[i] = positions[i] * 0x1p-20 + 700;
    }
    for (uint32_t i = 0; i < 3 * count; ++i) indices[i] = draw(&stream, VERTICES);
    solid_crossing found, elsewhere;
    assert_int_equal(solid_find_crossing(positions, indices, count, NULL, &found), SCREE_OK);
    assert_int_equal(solid_find_crossing(moved, indices, count, NULL, &elsewhere), SCREE_OK);
    uint32_t first[2] = {SCREE_NO_CROSSING, SCREE_NO_CROSSING};
    for (uint32_t a = 0; a < count; ++a)
      for (uint32_t b = a + 1; b < count; ++b) {
        const bool expected = twin_cross(positions, indices + 3 * a, indices + 3 * b);
        if (expected != solid_triangles_cross(positions, indices + 3 * a, indices + 3 * b, NULL))
          fail_msg("round %d: triangles %u and %u: %d", round, a, b, expected);
        assert_int_equal(solid_triangles_cross(positions, indices + 3 * b, indices + 3 * a, NULL), expected);
        if (expected && first[0] == SCREE_NO_CROSSING) first[0] = a, first[1] = b;
        touching += !expected;
      }
    assert_int_equal(found.triangles[0], first[0]);
    assert_int_equal(found.triangles[1], first[1]);
    assert_int_equal(elsewhere.triangles[0], first[0]);
    assert_int_equal(elsewhere.triangles[1], first[1]);
    dirty += first[0] != SCREE_NO_CROSSING, clean += first[0] == SCREE_NO_CROSSING;
    if (first[0] == SCREE_NO_CROSSING) continue;
    flat += round % 5 == 0;
    for (int k = 0; k < 2; ++k) assert_true(off_triangle(positions, indices + 3 * first[k], found.place) < 1e-12);
  }
  assert_true(clean > 100 && dirty > 100 && touching > 100 && flat > 100);
}

static void a_tip_crosses_from_the_last_bit_on(void** state) {
  (void)state;
  uint64_t stream = 3;
  uint32_t seen[3] = {0};
  for (int round = 0; round < ROUNDS(3000, 10); ++round) {
    double p[6][3];
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) p[i][k] = draw(&stream, 1 << 30) * 0x1.2345678p-30 + k;
    /* A tip in the face but for rounding, and the other two corners above it. */
    const double s = 0.2 + draw(&stream, 1 << 20) * 0x1p-22, t = 0.2 + draw(&stream, 1 << 20) * 0x1p-22;
    double u[3], v[3];
    for (int k = 0; k < 3; ++k) u[k] = p[1][k] - p[0][k], v[k] = p[2][k] - p[0][k];
    for (int k = 0; k < 3; ++k) {
      const double up = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
      p[3][k] = p[0][k] + s * u[k] + t * v[k];
      p[4][k] = p[3][k] + up + 0.01 * u[k];
      p[5][k] = p[3][k] + up - 0.01 * u[k];
    }
    const int side = orientation_exact(p[0], p[1], p[2], p[3]);
    const uint32_t face[3] = {0, 1, 2}, tip[3] = {3, 4, 5};
    if (orientation_exact(p[0], p[1], p[2], p[4]) <= 0 || orientation_exact(p[0], p[1], p[2], p[5]) <= 0) continue;
    assert_int_equal(solid_triangles_cross(p[0], face, tip, NULL), side < 0);
    ++seen[side + 1];
  }
  assert_true(seen[0] > 10 && seen[2] > 10);
}

/* --- solids ------------------------------------------------------------------------------------------------------------------ */

static scree_solid solid_of(const solid_mesh* mesh) {
  return (scree_solid){.positions = mesh->positions,
                       .indices = mesh->indices,
                       .vertex_count = mesh->vertex_count,
                       .triangle_count = mesh->triangle_count};
}

/* Two boxes as one solid. */
static scree_result check_boxes(const double low[3], const double high[3], const double low2[3], const double high2[3],
                                scree_error* error) {
  box_solid a, b;
  make_box(&a, low, high);
  make_box(&b, low2, high2);
  double positions[48];
  uint32_t indices[72];
  memcpy(positions, a.positions, sizeof a.positions);
  memcpy(positions + 24, b.positions, sizeof b.positions);
  memcpy(indices, a.indices, sizeof a.indices);
  for (int i = 0; i < 36; ++i) indices[36 + i] = 8 + b.indices[i];
  const scree_solid solid = {.positions = positions, .indices = indices, .vertex_count = 16, .triangle_count = 24};
  return scree_solid_check(&solid, NULL, error);
}

static void closed_parts_may_touch(void** state) {
  (void)state;
  scree_error error;
  const double far[3] = {2, 2, 2};
  assert_int_equal(check_boxes(zero, one, one, far, &error), SCREE_OK); /* corners */
  assert_int_equal(check_boxes(zero, one, (const double[3]){1, 1, 0}, (const double[3]){2, 2, 1}, &error), SCREE_OK);
  assert_int_equal(check_boxes(zero, one, (const double[3]){1, 1, 0.3}, (const double[3]){2, 2, 0.7}, &error), SCREE_OK);
  assert_int_equal(check_boxes(zero, one, (const double[3]){1, 0, 0}, (const double[3]){2, 1, 1}, &error), SCREE_OK);
  assert_int_equal(check_boxes(zero, one, (const double[3]){1, 0.3, 0.3}, (const double[3]){2, 0.6, 3}, &error), SCREE_OK);
  /* The corner of one on a face of the other. */
  double points[12] = {0.5, 1, 0.5, 0, 2, 0, 0, 2, 1, 1, 2, 0.5};
  uint32_t sides[12] = {0, 2, 1, 0, 3, 2, 0, 1, 3, 1, 2, 3};
  box_solid box;
  make_box(&box, zero, one);
  const solid_mesh peak = {points, sides, 4, 4}, below = {box.positions, box.indices, 8, 12};
  solid_mesh tip = {0};
  solid_add(&tip, &peak, zero, 1);
  solid_add(&tip, &below, zero, 1);
  scree_solid solid = solid_of(&tip);
  assert_int_equal(scree_solid_check(&solid, NULL, &error), SCREE_OK);
  tip.positions[1] = nextafter(1, 0); /* and the least way into it */
  assert_int_equal(scree_solid_check(&solid, NULL, &error), SCREE_ERROR_UNSUPPORTED);
  solid_mesh_free(&tip);
}

static void crossing_boxes_are_told_with_triangles_and_place(void** state) {
  (void)state;
  scree_error error;
  assert_int_equal(check_boxes(zero, one, (const double[3]){0.25, 0.25, 0.5}, (const double[3]){0.75, 0.5, 2}, &error),
                   SCREE_ERROR_UNSUPPORTED);
  assert_one_line(&error);
  unsigned a, b;
  double p[3];
  const char* at = strstr(error.message, "triangles ");
  assert_non_null(at);
  assert_int_equal(sscanf(at, "triangles %u and %u go through each other at (%lf, %lf, %lf)", &a, &b, &p[0], &p[1], &p[2]), 5);
  assert_true(a < 12 && b >= 12 && b < 24);
  assert_true(p[2] == 1 && p[0] >= 0.25 && p[0] <= 0.75 && p[1] >= 0.25 && p[1] <= 0.5); /* in the first one's upper face */
  assert_int_equal(check_boxes(zero, one, (const double[3]){0.25, 0.25, 0.5}, (const double[3]){0.75, 0.5, 2}, NULL),
                   SCREE_ERROR_UNSUPPORTED);
  /* Moved along an axis: no edge goes through a face, but faces lie on each other. */
  assert_int_equal(check_boxes(zero, one, (const double[3]){0.5, 0, 0}, (const double[3]){1.5, 1, 1}, &error),
                   SCREE_ERROR_UNSUPPORTED);
  assert_int_equal(check_boxes(zero, one, zero, one, &error), SCREE_ERROR_UNSUPPORTED);
}

static void few_seeds_do_not_hide_a_crossing_from_recipes(void** state) {
  (void)state;
  solid_mesh mesh = solid_torus(2, 0.7, 20, 10), other = solid_torus(2, 0.7, 20, 10);
  solid_add(&mesh, &other, (const double[3]){1.1, 0.2, 0.3}, 1);
  const scree_solid solid = solid_of(&mesh);
  static scree_shard_recipe recipe;
  scree_shard_recipe_default(&recipe);
  recipe.input.shape = SCREE_SHARD_MESH;
  strcpy(recipe.input.file, "two_rings.obj");
  recipe.input.scale = 10;
  recipe.input.resolution = 0;
  scree_solid_memory made;
  scree_error error;
  const scree_shard_desc desc = {.recipe = &recipe, .mesh = &solid};
  assert_int_equal(scree_shard_solid_make(&desc, &made, &error), SCREE_ERROR_INVALID_ARGUMENT);
  assert_null(made.memory);
  assert_one_line(&error);
  assert_non_null(strstr(error.message, "input: two_rings.obj: solid crosses itself: triangles "));
  recipe.input.resolution = 40; /* made anew */
  assert_int_equal(scree_shard_solid_make(&desc, &made, &error), SCREE_OK);
  assert_int_equal(scree_solid_check(&made.solid, NULL, &error), SCREE_OK);
  scree_solid_free(NULL, &made);
  solid_mesh_free(&mesh);
  solid_mesh_free(&other);
}

static void meshes_that_scanners_and_weather_made_are_clean(void** state) {
  (void)state;
  static const char* const names[] = {"bunny00", "armadillo", "knot1", "knot2", "elephant"};
  solid_crossing found;
  solid_mesh mesh = solid_goblin(24, 60);
  assert_int_equal(solid_find_crossing(mesh.positions, mesh.indices, mesh.triangle_count, NULL, &found), SCREE_OK);
  assert_true(found.triangles[0] == SCREE_NO_CROSSING && found.triangles[1] == SCREE_NO_CROSSING);
  solid_mesh_free(&mesh);
  char path[1024];
  for (size_t k = 0; k < sizeof names / sizeof *names; ++k) {
    snprintf(path, sizeof path, "%s/%s.off", folder, names[k]);
    if (!solid_read_off(path, &mesh)) continue;
    assert_int_equal(solid_find_crossing(mesh.positions, mesh.indices, mesh.triangle_count, NULL, &found), SCREE_OK);
    if (found.triangles[0] != SCREE_NO_CROSSING) fail_msg("%s: %u, %u", names[k], found.triangles[0], found.triangles[1]);
    solid_mesh_free(&mesh);
  }
  snprintf(path, sizeof path, "%s/man.off", folder);
  if (!solid_read_off(path, &mesh)) return; /* this one has them */
  assert_int_equal(solid_find_crossing(mesh.positions, mesh.indices, mesh.triangle_count, NULL, &found), SCREE_OK);
  assert_true(found.triangles[0] != SCREE_NO_CROSSING);
  for (int i = 0; i < 2; ++i)
    assert_true(off_triangle(mesh.positions, mesh.indices + 3 * (size_t)found.triangles[i], found.place) < 1e-9);
  solid_mesh_free(&mesh);
}

static void the_search_survives_every_failing_allocation(void** state) {
  (void)state;
  solid_mesh mesh = solid_torus(2, 0.7, 12, 6);
  for (int32_t at = 0;; ++at) {
    failing_allocator failing = {.fail_at = at};
    const scree_allocator allocator = failing_allocator_of(&failing);
    solid_crossing found;
    const scree_result result = solid_find_crossing(mesh.positions, mesh.indices, mesh.triangle_count, &allocator, &found);
    assert_int_equal(result, failing.failed ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_OK);
    assert_true(failing.live == 0);
    if (!failing.failed) break;
  }
  solid_mesh_free(&mesh);
}

int main(int argc, char** argv) {
  if (argc > 1) folder = argv[1];
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(signs_are_those_of_whole_numbers),
      cmocka_unit_test(signs_hold_to_the_last_bit),
      cmocka_unit_test(the_first_crossing_is_that_of_all_pairs),
      cmocka_unit_test(a_tip_crosses_from_the_last_bit_on),
      cmocka_unit_test(closed_parts_may_touch),
      cmocka_unit_test(crossing_boxes_are_told_with_triangles_and_place),
      cmocka_unit_test(few_seeds_do_not_hide_a_crossing_from_recipes),
      cmocka_unit_test(meshes_that_scanners_and_weather_made_are_clean),
      cmocka_unit_test(the_search_survives_every_failing_allocation),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
