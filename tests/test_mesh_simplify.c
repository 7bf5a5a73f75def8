/* Levels of detail: closed, near, and the same everywhere. The first argument is a folder with meshes; those that are not there are
 * said to be skipped. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "allocator.h"
#include "failing_allocator.h"
#include "make_solids.h"
#include "mesh_simplify.h"
#include "mesh_twin.h"
#include "random.h"
#include "surface_twin.h"

static const char* folder = "";

/* A mesh with all that simplifying needs. */
typedef struct test_mesh {
  simplify_mesh mesh;
  uint32_t* groups;
  uint8_t* materials;
} test_mesh;

static void* must(void* memory) {
  if (memory == NULL) abort();
  return memory;
}

static void mesh_begin(test_mesh* t, uint32_t vertices, uint32_t triangles) {
  t->mesh.vertex_count = vertices;
  t->mesh.triangle_count = triangles;
  t->mesh.positions = must(calloc(vertices, sizeof *t->mesh.positions));
  t->mesh.corners = must(calloc(triangles, sizeof *t->mesh.corners));
  t->mesh.uvs = must(calloc(triangles, sizeof *t->mesh.uvs));
  t->mesh.groups = t->groups = must(calloc(triangles, sizeof *t->groups));
  t->mesh.materials = t->materials = must(calloc(triangles, 1));
}

static void mesh_end(test_mesh* t) {
  free(t->mesh.positions);
  free(t->mesh.corners);
  free(t->mesh.uvs);
  free(t->groups);
  free(t->materials);
}

/* A grid of n * n squares on each side of a cube, moved to `place`; vertices are joined. */
typedef void (*place_fn)(const double cube[3], double out[3]);

static uint32_t cube_vertex(test_mesh* t, uint32_t* numbers, uint32_t n, const uint32_t at[3], place_fn place) {
  uint32_t* number = &numbers[at[0] + (n + 1) * (at[1] + (n + 1) * at[2])];
  if (*number == UINT32_MAX) {
    *number = t->mesh.vertex_count++;
    double cube[3], p[3];
    for (uint32_t a = 0; a < 3; ++a) cube[a] = 2.0 * at[a] / n - 1;
    place(cube, p);
    for (uint32_t a = 0; a < 3; ++a) t->mesh.positions[*number][a] = (int16_t)floor(p[a] + 0.5);
  }
  return *number;
}

static void cube_mesh(test_mesh* t, uint32_t n, place_fn place) {
  mesh_begin(t, 6 * n * n + 2, 12 * n * n);
  t->mesh.vertex_count = 0;
  uint32_t* numbers = must(malloc((n + 1) * (n + 1) * (n + 1) * sizeof *numbers));
  memset(numbers, 255, (n + 1) * (n + 1) * (n + 1) * sizeof *numbers);
  uint32_t count = 0;
  for (uint32_t axis = 0; axis < 3; ++axis)
    for (uint32_t side = 0; side < 2; ++side)
      for (uint32_t i = 0; i < n; ++i)
        for (uint32_t k = 0; k < n; ++k) {
          uint32_t v[4];
          for (uint32_t c = 0; c < 4; ++c) {
            uint32_t at[3];
            at[axis] = side * n;
            at[(axis + 1) % 3] = i + (c == 1 || c == 2);
            at[(axis + 2) % 3] = k + (c >= 2);
            v[c] = cube_vertex(t, numbers, n, at, place);
          }
          for (uint32_t h = 0; h < 2; ++h, ++count) {
            uint32_t* c = t->mesh.corners[count];
            c[0] = v[0];
            c[1] = v[side ? 1 + h : 2 + h];
            c[2] = v[side ? 2 + h : 1 + h];
            t->groups[count] = 2 * axis + side;
            for (uint32_t m = 0; m < 3; ++m)
              for (uint32_t a = 0; a < 2; ++a)
                t->mesh.uvs[count][m][a] = 0.001f * (float)t->mesh.positions[c[m]][(axis + 1 + a) % 3];
          }
        }
  free(numbers);
}

static void to_cube(const double cube[3], double out[3]) {
  for (int a = 0; a < 3; ++a) out[a] = 1000 * cube[a];
}

static void to_sphere(const double cube[3], double out[3]) {
  const double length = sqrt(cube[0] * cube[0] + cube[1] * cube[1] + cube[2] * cube[2]);
  for (int a = 0; a < 3; ++a) out[a] = 5000 * cube[a] / length;
}

static void to_lump(const double cube[3], double out[3]) {
  to_sphere(cube, out);
  const double wave = 1 + 0.2 * sin(out[0] * 0.0011) * cos(out[1] * 0.0017) + 0.05 * sin(out[2] * 0.006);
  for (int a = 0; a < 3; ++a) out[a] *= wave;
}

/* --- facts -------------------------------------------------------------------------------------------------------------------- */

/* What is left, without gaps. */
static uint32_t left_of(const test_mesh* t, uint32_t* corners) {
  uint32_t count = 0;
  for (uint32_t i = 0; i < t->mesh.triangle_count; ++i)
    if (t->mesh.corners[i][0] != SIMPLIFY_GONE) memcpy(corners + 3 * count++, t->mesh.corners[i], 3 * sizeof *corners);
  return count;
}

static double volume_of(const test_mesh* t, const uint32_t* corners, uint32_t count) {
  const twin_mesh twin = {(const int16_t(*)[3])t->mesh.positions, corners, t->mesh.vertex_count, count};
  double volume, centroid[3];
  mesh_mass(&twin, &volume, centroid);
  return volume;
}

static void check_manifold(const test_mesh* t, const uint32_t* corners, uint32_t count) {
  const twin_mesh twin = {(const int16_t(*)[3])t->mesh.positions, corners, t->mesh.vertex_count, count};
  const mesh_faults faults = mesh_find_faults(&twin);
  assert_int_equal(faults.open_edges + faults.shared_edges + faults.repeated_corners + faults.pinched_vertices, 0);
  assert_int_equal(faults.flat_triangles, 0);
}

static mesh_simplifier* must_start(const test_mesh* t) {
  mesh_simplifier* s;
  assert_int_equal(mesh_simplifier_create(&t->mesh, NULL, &s), SCREE_OK);
  return s;
}

static void a_cube_needs_twelve_triangles(void** state) {
  (void)state;
  test_mesh t;
  cube_mesh(&t, 12, to_cube);
  mesh_simplifier* s = must_start(&t);
  assert_int_equal(mesh_simplifier_run(s, 12), 12);
  uint32_t* corners = must(malloc(3 * t.mesh.triangle_count * sizeof *corners));
  const uint32_t count = left_of(&t, corners);
  assert_int_equal(count, 12);
  check_manifold(&t, corners, count);
  assert_true(fabs(volume_of(&t, corners, count) - 8e9) < 1);
  /* All its corners stood, and every side has its own group and uvs. */
  for (uint32_t i = 0; i < t.mesh.triangle_count; ++i) {
    if (t.mesh.corners[i][0] == SIMPLIFY_GONE) continue;
    for (uint32_t m = 0; m < 3; ++m)
      for (uint32_t a = 0; a < 2; ++a)
        assert_true(t.mesh.uvs[i][m][a] == 0.001f * (float)t.mesh.positions[t.mesh.corners[i][m]][(t.groups[i] / 2 + 1 + a) % 3]);
  }
  mesh_simplifier_destroy(s);
  free(corners);
  mesh_end(&t);
}

static void levels_are_closed_and_have_nearly_the_volume(void** state) {
  (void)state;
  static const struct {
    place_fn place;
    double loss; /* share of the volume at a sixteenth of the triangles */
  } shapes[2] = {{to_sphere, 0.02}, {to_lump, 0.03}};
  for (uint32_t k = 0; k < 2; ++k) {
    test_mesh t;
    cube_mesh(&t, 40, shapes[k].place);
    memset(t.groups, 0, t.mesh.triangle_count * sizeof *t.groups);
    memset(t.mesh.uvs, 0, t.mesh.triangle_count * sizeof *t.mesh.uvs);
    uint32_t* corners = must(malloc(3 * t.mesh.triangle_count * sizeof *corners));
    uint32_t count = left_of(&t, corners);
    const double whole = volume_of(&t, corners, count);
    mesh_simplifier* s = must_start(&t);
    for (uint32_t target = t.mesh.triangle_count / 4; target >= 64; target /= 4) {
      const uint32_t made = mesh_simplifier_run(s, target);
      assert_in_range(made, target - 1, target);
      count = left_of(&t, corners);
      assert_int_equal(count, made);
      check_manifold(&t, corners, count);
      const double volume = volume_of(&t, corners, count);
      assert_true(volume < whole * 1.01);
      if (target >= t.mesh.triangle_count / 16) assert_true(volume > whole * (1 - shapes[k].loss));
      assert_true(volume > whole * 0.7);
    }
    mesh_simplifier_destroy(s);
    free(corners);
    mesh_end(&t);
  }
}

static void solids_that_touch_come_apart(void** state) {
  (void)state;
  /* Two cubes of 12 triangles that share an edge, and a third that shares a corner. */
  static const double at[3][3] = {{0, 0, 0}, {1, 1, 0}, {-1, -1, -1}};
  double positions[3 * 24];
  uint32_t corners[36][3], count = 0, vertices = 0;
  for (uint32_t cube = 0; cube < 3; ++cube) {
    uint32_t number[8];
    for (uint32_t v = 0; v < 8; ++v) {
      const double p[3] = {at[cube][0] + (v & 1), at[cube][1] + (v >> 1 & 1), at[cube][2] + (v >> 2)};
      number[v] = vertices;
      for (uint32_t k = 0; k < vertices; ++k)
        if (memcmp(positions + 3 * k, p, sizeof p) == 0) number[v] = k;
      if (number[v] == vertices) memcpy(positions + 3 * vertices++, p, sizeof p);
    }
    for (uint32_t t = 0; t < 12; ++t, ++count) {
      const uint32_t axis = t / 4, side = t / 2 % 2, base = side << axis, u = 1u << (axis + 1) % 3, v = 1u << (axis + 2) % 3;
      const uint32_t second = t % 2 == 0 ? u : u + v, third = t % 2 == 0 ? u + v : v;
      corners[count][0] = number[base];
      corners[count][1] = number[base + (side ? second : third)];
      corners[count][2] = number[base + (side ? third : second)];
    }
  }
  assert_int_equal(vertices, 24 - 2 - 1);
  uint32_t vertex_of[108], made;
  const scree_allocator allocator = scree_rt_allocator_or_default(NULL);
  assert_int_equal(mesh_split_fans(positions, corners, 36, &allocator, vertex_of, &made), SCREE_OK);
  assert_int_equal(made, 24);
  for (uint32_t t = 0; t < 36; ++t)
    for (uint32_t k = 0; k < 3; ++k) /* vertices of the cube that the triangle is of, and of no other */
      for (uint32_t other = 0; other < 36; ++other)
        for (uint32_t m = 0; m < 3 && other / 12 != t / 12; ++m) assert_int_not_equal(corners[t][k], corners[other][m]);
  corners[0][0] = corners[0][1];
  assert_int_equal(mesh_split_fans(positions, corners, 36, &allocator, vertex_of, &made), SCREE_ERROR_INVALID_ARGUMENT);
}

static void open_meshes_are_refused(void** state) {
  (void)state;
  test_mesh t;
  cube_mesh(&t, 2, to_cube);
  --t.mesh.triangle_count;
  mesh_simplifier* s;
  assert_int_equal(mesh_simplifier_create(&t.mesh, NULL, &s), SCREE_ERROR_INVALID_ARGUMENT);
  ++t.mesh.triangle_count;
  mesh_end(&t);
}

static void borders_of_materials_stay_where_they_are(void** state) {
  (void)state;
  test_mesh t;
  cube_mesh(&t, 32, to_sphere);
  memset(t.mesh.uvs, 0, t.mesh.triangle_count * sizeof *t.mesh.uvs);
  for (uint32_t i = 0; i < t.mesh.triangle_count; ++i) t.materials[i] = t.groups[i] == 3 ? 2 : 0; /* the cap around +y */
  memset(t.groups, 0, t.mesh.triangle_count * sizeof *t.groups);
  mesh_simplifier* s = must_start(&t);
  mesh_simplifier_run(s, t.mesh.triangle_count / 16);
  /* The cap of a cube on a sphere: |x| and |z| are at most y, but for what a sixteenth of the triangles allows. */
  for (uint32_t i = 0; i < t.mesh.triangle_count; ++i) {
    if (t.mesh.corners[i][0] == SIMPLIFY_GONE || t.materials[i] == 0) continue;
    for (uint32_t m = 0; m < 3; ++m) {
      const int16_t* p = t.mesh.positions[t.mesh.corners[i][m]];
      assert_true(abs(p[0]) < p[1] + 300 && abs(p[2]) < p[1] + 300);
    }
  }
  mesh_simplifier_destroy(s);
  mesh_end(&t);
}

static void cleaning_leaves_no_vertex_twice_and_no_flat_triangle(void** state) {
  (void)state;
  test_mesh t;
  cube_mesh(&t, 40, to_lump);
  /* A lattice far too coarse for it. */
  for (uint32_t v = 0; v < t.mesh.vertex_count; ++v)
    for (uint32_t a = 0; a < 3; ++a) t.mesh.positions[v][a] = (int16_t)(t.mesh.positions[v][a] / 400);
  memset(t.groups, 0, t.mesh.triangle_count * sizeof *t.groups);
  mesh_simplifier* s = must_start(&t);
  mesh_simplifier_clean(s);
  uint32_t* corners = must(malloc(3 * t.mesh.triangle_count * sizeof *corners));
  const uint32_t count = left_of(&t, corners);
  assert_int_equal(twin_open_edges(corners, count), 0);
  uint32_t flat = 0;
  const twin_mesh twin = {(const int16_t(*)[3])t.mesh.positions, corners, t.mesh.vertex_count, count};
  flat = mesh_find_faults(&twin).flat_triangles;
  assert_true(count > 500 && count < t.mesh.triangle_count / 2);
  assert_true(flat * 100 <= count);
  mesh_simplifier_destroy(s);
  free(corners);
  mesh_end(&t);
}

static void levels_repeat_to_the_bit(void** state) {
  (void)state;
  test_mesh t;
  cube_mesh(&t, 24, to_sphere); /* + - * / sqrt alone make it */
  mesh_simplifier* s = must_start(&t);
  mesh_simplifier_run(s, 400);
  uint32_t* corners = must(malloc(3 * t.mesh.triangle_count * sizeof *corners));
  const uint32_t count = left_of(&t, corners);
  const uint64_t digest = twin_digest(corners, 3 * count * sizeof *corners);
  if (digest != UINT64_C(0x88a469bf7f971554)) fail_msg("the digest is now 0x%016llx", (unsigned long long)digest);
  mesh_simplifier_destroy(s);
  free(corners);
  mesh_end(&t);
}

static void failed_allocations_leave_nothing_behind(void** state) {
  (void)state;
  test_mesh t;
  cube_mesh(&t, 3, to_cube);
  for (int32_t fail_at = 0;; ++fail_at) {
    failing_allocator f = {.fail_at = fail_at};
    const scree_allocator allocator = failing_allocator_of(&f);
    mesh_simplifier* s;
    const scree_result result = mesh_simplifier_create(&t.mesh, &allocator, &s);
    assert_int_equal(result, f.failed ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_OK);
    mesh_simplifier_destroy(s);
    assert_int_equal(f.live, 0);
    if (!f.failed) break;
  }
  mesh_end(&t);
}

/* Real meshes, down to a fiftieth, or 800 triangles. */
static void sculpted_meshes_stay_closed_and_near(void** state) {
  (void)state;
  static const char* const names[4] = {"bunny00", "knot1", "elephant", "armadillo"};
  static const double loss[4] = {0.02, 0.08, 0.04, 0.07}; /* thin limbs lose most */
  for (uint32_t k = 0; k < 4; ++k) {
    char file[512];
    snprintf(file, sizeof file, "%s/%s.off", folder, names[k]);
    solid_mesh read;
    const solid_mesh* solid = &read;
    if (!solid_read_off(file, &read)) {
      print_message("%s is not there: left out; ./dev fetches it\n", file);
      continue;
    }
    test_mesh t;
    mesh_begin(&t, solid->vertex_count, solid->triangle_count);
    double low[3] = {INFINITY, INFINITY, INFINITY}, extent = 0;
    for (uint32_t i = 0; i < 3 * solid->vertex_count; ++i)
      if (solid->positions[i] < low[i % 3]) low[i % 3] = solid->positions[i];
    for (uint32_t i = 0; i < 3 * solid->vertex_count; ++i) extent = fmax(extent, solid->positions[i] - low[i % 3]);
    for (uint32_t i = 0; i < 3 * solid->vertex_count; ++i)
      t.mesh.positions[i / 3][i % 3] = (int16_t)floor((solid->positions[i] - low[i % 3]) / extent * 8192 + 0.5);
    memcpy(t.mesh.corners, solid->indices, 3 * solid->triangle_count * sizeof *solid->indices);
    mesh_simplifier* s = must_start(&t);
    mesh_simplifier_clean(s);
    uint32_t* corners = must(malloc(3 * t.mesh.triangle_count * sizeof *corners));
    uint32_t count = left_of(&t, corners);
    const double whole = volume_of(&t, corners, count);
    assert_int_equal(twin_open_edges(corners, count), 0);
    const uint32_t target = solid->triangle_count / 50 > 800 ? solid->triangle_count / 50 : 800;
    assert_in_range(mesh_simplifier_run(s, target), target - 1, target);
    count = left_of(&t, corners);
    const twin_mesh twin = {(const int16_t(*)[3])t.mesh.positions, corners, t.mesh.vertex_count, count};
    const mesh_faults faults = mesh_find_faults(&twin);
    assert_int_equal(faults.open_edges + faults.shared_edges + faults.repeated_corners + faults.pinched_vertices, 0);
    const double volume = volume_of(&t, corners, count);
    if (fabs(volume / whole - 1) > loss[k]) fail_msg("%s: volume off by %g", names[k], volume / whole - 1);
    /* Every vertex within three hundredths of the extent. */
    random_stream r = {k};
    for (uint32_t i = 0; i < 300; ++i) {
      const int16_t* v = t.mesh.positions[(uint32_t)(random_unit(&r) * solid->vertex_count)];
      const double p[3] = {v[0], v[1], v[2]};
      const double off = mesh_distance(&twin, p, 0) / 8192;
      if (off > 0.03) fail_msg("%s: a vertex is %g of the extent away", names[k], off);
    }
    mesh_simplifier_destroy(s);
    free(corners);
    mesh_end(&t);
    solid_mesh_free(&read);
  }
}

int main(int argc, char** argv) {
  if (argc > 1) folder = argv[1];
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_cube_needs_twelve_triangles),
      cmocka_unit_test(levels_are_closed_and_have_nearly_the_volume),
      cmocka_unit_test(solids_that_touch_come_apart),
      cmocka_unit_test(open_meshes_are_refused),
      cmocka_unit_test(borders_of_materials_stay_where_they_are),
      cmocka_unit_test(cleaning_leaves_no_vertex_twice_and_no_flat_triangle),
      cmocka_unit_test(levels_repeat_to_the_bit),
      cmocka_unit_test(failed_allocations_leave_nothing_behind),
      cmocka_unit_test(sculpted_meshes_stay_closed_and_near),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
