/* Supports and fields that cannot be made: every wrong number, tree, mesh and table, and every allocation that fails. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "failing_allocator.h"
#include "random_support.h"
#include "support_program.h"
#include "support_text.h"

static void assert_refused(const scree_shape* shapes, uint32_t count, scree_result expected, const char* part) {
  scree_error error;
  scree_support* support = (scree_support*)&error;
  scree_support_desc desc = {.shapes = shapes, .shape_count = count};
  scree_result result = scree_support_create(&desc, NULL, &support, &error);
  if (result != expected) fail_msg("%d instead of %d: %s", (int)result, (int)expected, error.message);
  assert_null(support);
  if (strstr(error.message, part) == NULL) fail_msg("\"%s\" does not say \"%s\"", error.message, part);
  assert_null(strchr(error.message, '\n'));
  assert_int_equal(scree_support_create(&desc, NULL, &support, NULL), expected); /* texts are optional */
}

static void wrong_numbers_are_refused_by_shape_and_field(void** state) {
  (void)state;
  const float heights[4] = {0, 1, 2, 3}, broken[4] = {0, 1, NAN, 3};
  const float polygon[6] = {0, 0, 2, 0, 0, 2}, flat[6] = {0, 0, 1, 0, 2, 0}, broken_points[6] = {0, 0, NAN, 0, 0, 2};
  const float path[6] = {0, 0, 0, 3, 1, 0}, stuck[9] = {0, 0, 0, 1, 1, 1, 1, 1, 1}, ring[9] = {0, 0, 0, 1, 1, 1, 0, 0, 0};
  const float radii[3] = {1, 2, 1}, none[3] = {1, 0, 1};
  const scree_shape good[] = {{.kind = SCREE_SHAPE_SPHERE, .sphere = {1}},
                              {.kind = SCREE_SHAPE_BOX, .box = {{1, 2, 3}, 0}},
                              {.kind = SCREE_SHAPE_CAPSULE, .capsule = {{0, 0, 0}, {1, 0, 0}, 1}},
                              {.kind = SCREE_SHAPE_CYLINDER, .cylinder = {1, 2}},
                              {.kind = SCREE_SHAPE_CONE, .cone = {1, 2}},
                              {.kind = SCREE_SHAPE_HEIGHTFIELD, .heightfield = {heights, 2, 2, 1, 0, 1}},
                              {.kind = SCREE_SHAPE_ELLIPSOID, .ellipsoid = {{1, 2, 3}}},
                              {.kind = SCREE_SHAPE_TORUS, .torus = {2, 1}},
                              {.kind = SCREE_SHAPE_EXTRUSION, .extrusion = {polygon, 3, 0, 1}},
                              {.kind = SCREE_SHAPE_TUBE, .tube = {path, radii, 2, false, 0, 0}},
                              {.kind = SCREE_SHAPE_BLOBS, .blobs = {path, radii, 2}},
                              {.kind = SCREE_SHAPE_PATTERN, .pattern = {SCREE_PATTERN_WAVES, 1, 0.2f, 0.1f, 2}},
                              {.kind = SCREE_SHAPE_HALF_SPACE}};
  for (size_t i = 0; i < sizeof good / sizeof good[0]; ++i) {
    scree_support* made;
    scree_error error;
    if (scree_support_create(&(scree_support_desc){.shapes = &good[i], .shape_count = 1}, NULL, &made, &error) != SCREE_OK)
      fail_msg("%s", error.message);
    scree_support_destroy(made);
  }
#define REFUSED(index, change, result, part)           \
  do {                                                 \
    scree_shape s = good[index];                       \
    change;                                            \
    assert_refused(&s, 1, SCREE_ERROR_##result, part); \
  } while (0)
  REFUSED(0, s.sphere.radius = 0, RANGE, "shape 0: sphere.radius is 0, expected a number > 0");
  REFUSED(0, s.sphere.radius = -2.5f, RANGE, "sphere.radius is -2.5");
  REFUSED(0, s.sphere.radius = NAN, RANGE, "sphere.radius is not a number");
  REFUSED(0, s.sphere.radius = INFINITY, RANGE, "sphere.radius is infinity");
  REFUSED(0, s.sphere.radius = 2e9f, RANGE, "sphere.radius is 2e9, expected at most 1e9");
  REFUSED(0, s.transform.translation[1] = NAN, RANGE, "transform.translation[1]");
  REFUSED(0, s.transform.rotation[2] = NAN, RANGE, "transform.rotation[2]");
  REFUSED(0, s.transform.rotation[3] = 2, RANGE, "not a unit quaternion");
  REFUSED(0, s.transform.scale = -1, RANGE, "transform.scale is -1");
  REFUSED(0, s.transform.scale = NAN, RANGE, "transform.scale");
  REFUSED(0, s.kind = (scree_shape_kind)99, INVALID_ARGUMENT, "kind 99");
  REFUSED(1, s.box.half[2] = 0, RANGE, "box.half[2]");
  REFUSED(1, s.box.rounding = 1.5f, RANGE, "box.rounding is 1.5");
  REFUSED(1, s.box.rounding = -0.1f, RANGE, "box.rounding is -0.1");
  REFUSED(2, s.capsule.a[0] = NAN, RANGE, "capsule.a[0]");
  REFUSED(2, s.capsule.b[2] = INFINITY, RANGE, "capsule.b[2]");
  REFUSED(2, s.capsule.radius = 0, RANGE, "capsule.radius");
  REFUSED(3, s.cylinder.radius = 0, RANGE, "cylinder.radius");
  REFUSED(3, s.cylinder.half_height = -1, RANGE, "cylinder.half_height");
  REFUSED(4, s.cone.radius = 0, RANGE, "cone.radius");
  REFUSED(4, s.cone.height = 0, RANGE, "cone.height");
  REFUSED(5, s.heightfield.heights = NULL, INVALID_ARGUMENT, "heightfield.heights is NULL");
  REFUSED(5, s.heightfield.heights = broken, RANGE, "heightfield.heights[2] is not a number");
  REFUSED(5, s.heightfield.width = 1, RANGE, "heightfield.width is 1");
  REFUSED(5, s.heightfield.depth = 0, RANGE, "heightfield.depth is 0");
  REFUSED(5, (s.heightfield.width = 1u << 20, s.heightfield.depth = 1u << 20), RANGE, "2^31");
  REFUSED(5, s.heightfield.spacing = 0, RANGE, "heightfield.spacing");
  REFUSED(5, s.heightfield.above = NAN, RANGE, "heightfield.above");
  REFUSED(5, s.heightfield.below = 0, RANGE, "heightfield.above + below is 0");
  REFUSED(6, s.ellipsoid.radii[1] = 0, RANGE, "ellipsoid.radii[1] is 0");
  REFUSED(6, s.ellipsoid.radii[2] = NAN, RANGE, "ellipsoid.radii[2] is not a number");
  REFUSED(6, s.ellipsoid.radii[2] = 2000, RANGE, "ellipsoid.radii differ by more than a factor of 1000");
  REFUSED(7, s.torus.radius = 0, RANGE, "torus.radius is 0");
  REFUSED(7, s.torus.tube_radius = -1, RANGE, "torus.tube_radius is -1");
  REFUSED(8, s.extrusion.points = NULL, INVALID_ARGUMENT, "extrusion.points is NULL");
  REFUSED(8, s.extrusion.points = broken_points, RANGE, "extrusion.points[2] is not a number");
  REFUSED(8, s.extrusion.points = flat, RANGE, "extrusion.points enclose no area");
  REFUSED(8, s.extrusion.point_count = 2, RANGE, "extrusion.point_count is 2, expected 3 to 1024");
  REFUSED(8, s.extrusion.point_count = 1025, RANGE, "extrusion.point_count is 1025");
  REFUSED(8, s.extrusion.high = 0, RANGE, "extrusion.high is 0, expected more than extrusion.low");
  REFUSED(8, s.extrusion.low = -INFINITY, RANGE, "extrusion.low is -infinity");
  REFUSED(9, s.tube.points = NULL, INVALID_ARGUMENT, "tube.points is NULL");
  REFUSED(9, s.tube.radii = NULL, INVALID_ARGUMENT, "tube.radii is NULL");
  REFUSED(9, s.tube.point_count = 1, RANGE, "tube.point_count is 1, expected 2 to 256");
  REFUSED(9, s.tube.point_count = 257, RANGE, "tube.point_count is 257");
  REFUSED(9, s.tube.subdivisions = 33, RANGE, "tube.subdivisions is 33");
  REFUSED(9, s.tube.half_height = -1, RANGE, "tube.half_height is -1");
  REFUSED(9, s.tube.half_height = NAN, RANGE, "tube.half_height");
  REFUSED(9, s.tube.radii = none, RANGE, "tube.radii[1] is 0");
  REFUSED(9, (s.tube.points = broken_points), RANGE, "tube.points[2] is not a number");
  REFUSED(9, (s.tube.points = stuck, s.tube.point_count = 3), RANGE, "tube.points[6]: the point is the same as the one before");
  REFUSED(9, (s.tube.points = ring, s.tube.point_count = 3, s.tube.closed = true), RANGE, "tube.points[0]");
  REFUSED(10, s.blobs.centres = NULL, INVALID_ARGUMENT, "blobs.centres is NULL");
  REFUSED(10, s.blobs.radii = NULL, INVALID_ARGUMENT, "blobs.radii is NULL");
  REFUSED(10, s.blobs.count = 0, RANGE, "blobs.count is 0, expected 1 to 256");
  REFUSED(10, s.blobs.count = 257, RANGE, "blobs.count is 257");
  REFUSED(10, s.blobs.radii = none, RANGE, "blobs.radii[1] is 0");
  REFUSED(10, s.blobs.centres = broken_points, RANGE, "blobs.centres[2]");
  REFUSED(11, s.pattern.kind = (scree_pattern_kind)3, INVALID_ARGUMENT, "pattern.kind 3 is not known");
  REFUSED(11, s.pattern.spacing = 0, RANGE, "pattern.spacing is 0");
  REFUSED(11, s.pattern.radius = -1, RANGE, "pattern.radius is -1");
  REFUSED(11, s.pattern.amplitude = -1, RANGE, "pattern.amplitude is -1");
  REFUSED(11, s.pattern.amplitude = 2001, RANGE, "pattern.amplitude is 2001");
  REFUSED(11, s.pattern.wavelength = 0, RANGE, "pattern.wavelength is 0");
#undef REFUSED
  scree_support* support;
  assert_int_equal(scree_support_create(NULL, NULL, &support, NULL), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_support_create(&(scree_support_desc){.shapes = good, .shape_count = 1}, NULL, NULL, NULL),
                   SCREE_ERROR_INVALID_ARGUMENT);
  assert_refused(NULL, 1, SCREE_ERROR_INVALID_ARGUMENT, "at least one shape");
  assert_refused(good, 0, SCREE_ERROR_INVALID_ARGUMENT, "at least one shape");
  scree_support_desc astray = {.shapes = good, .shape_count = 1, .origin = {0, NAN, 0}};
  assert_int_equal(scree_support_create(&astray, NULL, &support, NULL), SCREE_ERROR_RANGE);
}

static void numbers_in_errors_have_six_digits(void** state) {
  (void)state;
  const struct {
    double number;
    const char* text;
  } cases[] = {{0, "0"},
               {1, "1"},
               {-1.5, "-1.5"},
               {0.1, "0.1"},
               {0.00012, "0.00012"},
               {3.14159265, "3.14159"},
               {12.05, "12.05"},
               {99999.9, "99999.9"},
               {123456, "123456"},
               {1234567, "1234567"},
               {1e9, "1e9"},
               {2.5e12, "2.5e12"},
               {1e-5, "1e-5"},
               {-3e-7, "-3e-7"},
               {INFINITY, "infinity"},
               {-INFINITY, "-infinity"},
               {NAN, "not a number"}};
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    scree_error error;
    scree_rt_text_clear(&error);
    scree_rt_text_add_number(&error, cases[i].number);
    assert_string_equal(error.message, cases[i].text);
  }
  scree_error full; /* what does not fit is cut off */
  scree_rt_text_clear(&full);
  for (int i = 0; i < 200; ++i) scree_rt_text_add(&full, "word ");
  assert_int_equal(strlen(full.message), sizeof full.message - 1);
  scree_rt_text_add(NULL, "nobody listens");
}

static void broken_meshes_are_refused_by_edge(void** state) {
  (void)state;
  float positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const uint32_t tetrahedron[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
#define REFUSED(change, result, part)                                                  \
  do {                                                                                 \
    uint32_t indices[12];                                                              \
    memcpy(indices, tetrahedron, sizeof indices);                                      \
    scree_shape s = {.kind = SCREE_SHAPE_MESH, .mesh = {positions, indices, 4, 4, 8}}; \
    change;                                                                            \
    assert_refused(&s, 1, SCREE_ERROR_##result, part);                                 \
  } while (0)
  REFUSED(s.mesh.positions = NULL, INVALID_ARGUMENT, "mesh.positions is NULL");
  REFUSED(s.mesh.indices = NULL, INVALID_ARGUMENT, "mesh.indices is NULL");
  REFUSED(s.mesh.triangle_count = 3, RANGE, "mesh.triangle_count is 3");
  REFUSED(s.mesh.vertex_count = 3, RANGE, "mesh.vertex_count is 3");
  REFUSED(s.mesh.resolution = 7, RANGE, "mesh.resolution is 7");
  REFUSED(s.mesh.resolution = 513, RANGE, "mesh.resolution is 513");
  REFUSED(indices[5] = 4, RANGE, "mesh.indices[5] is 4, but there are only 4 vertices");
  REFUSED(indices[4] = 0, INVALID_ARGUMENT, "triangle 1 uses vertex 0 twice");
  REFUSED((indices[0] = 0, indices[1] = 1, indices[2] = 2), NOT_CLOSED, "edge from vertex 0 to 1 of triangle 0 is used by another");
  REFUSED((positions[0] = NAN), RANGE, "mesh.positions[0]");
  positions[0] = 0;
  const uint32_t turned[12] = {2, 0, 1, 1, 0, 3, 3, 0, 2, 2, 1, 3};
  REFUSED(memcpy(indices, turned, sizeof indices), INVALID_ARGUMENT, "shape 0: mesh is inside out");
  positions[11] = 0;
  REFUSED((void)0, INVALID_ARGUMENT, "encloses no volume");
  memset(positions, 0, sizeof positions);
  REFUSED((void)0, RANGE, "longest side");
#undef REFUSED

  /* A hole names an edge of its rim. */
  float corners[24];
  for (int v = 0; v < 8; ++v)
    for (int a = 0; a < 3; ++a) corners[3 * v + a] = (float)(v >> a & 1);
  const uint32_t open[33] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7};
  scree_shape box = {.kind = SCREE_SHAPE_MESH, .mesh = {corners, open, 8, 11, 8}};
  const scree_shape shapes[2] = {{.kind = SCREE_SHAPE_SPHERE, .sphere = {1}}, box};
  assert_refused(shapes, 2, SCREE_ERROR_NOT_CLOSED,
                 "shape 1: mesh is not closed: the edge from vertex 5 to 7 of triangle 2 has no triangle");
}

/* Two boxes on a diagonal share an edge, which four triangles use. */
static void boxes_that_touch_along_an_edge_are_one_closed_mesh(void** state) {
  (void)state;
  static const uint32_t sides[36] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                     2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
  float corners[48];
  uint32_t indices[72];
  for (int v = 0; v < 16; ++v)
    for (int a = 0; a < 3; ++a) corners[3 * v + a] = (float)((v & 7) >> a & 1) + (v >= 8 && a < 2 ? 1 : 0);
  for (int i = 0; i < 36; ++i) {
    const uint32_t v = sides[i];
    indices[i] = v;
    indices[36 + i] = v == 0 ? 3 : v == 4 ? 7 : v + 8; /* the edge x = y = 1 is the first box's */
  }
  const scree_shape s = {.kind = SCREE_SHAPE_MESH, .mesh = {corners, indices, 16, 24, 16}};
  scree_support* support;
  scree_error error;
  assert_int_equal(scree_support_create(&(scree_support_desc){.shapes = &s, .shape_count = 1}, NULL, &support, &error), SCREE_OK);
  const float x[4] = {0.5f, 1.5f, 1.5f, 0.5f}, y[4] = {0.5f, 1.5f, 0.5f, 1.5f}, z[4] = {0.5f, 0.5f, 0.5f, 0.5f};
  float distance[4];
  scree_support_distance(support, x, y, z, distance, 4);
  assert_true(distance[0] < -0.3f && distance[1] < -0.3f);
  assert_true(distance[2] > 0.3f && distance[3] > 0.3f);
  scree_support_destroy(support);

  const scree_shape open = {.kind = SCREE_SHAPE_MESH, .mesh = {corners, indices, 16, 23, 16}};
  assert_refused(&open, 1, SCREE_ERROR_NOT_CLOSED, "has no triangle on its other side");
}

static void broken_trees_and_callbacks_are_refused(void** state) {
  (void)state;
  uint32_t children[2] = {1, 2};
  scree_shape shapes[3] = {{.kind = SCREE_SHAPE_UNION, .group = {children, 2, 0}},
                           {.kind = SCREE_SHAPE_SPHERE, .sphere = {1}},
                           {.kind = SCREE_SHAPE_SPHERE, .sphere = {1}}};
  children[1] = 3;
  assert_refused(shapes, 3, SCREE_ERROR_INVALID_ARGUMENT, "group.children[1] is 3, but there are only 3 shapes");
  children[1] = 0;
  assert_refused(shapes, 3, SCREE_ERROR_INVALID_ARGUMENT, "group.children[1] is 0, expected a later shape");
  children[1] = 2;
  shapes[0].group.child_count = 0;
  assert_refused(shapes, 3, SCREE_ERROR_INVALID_ARGUMENT, "group.child_count is 0");
  shapes[0].group.child_count = 2;
  shapes[0].group.children = NULL;
  assert_refused(shapes, 3, SCREE_ERROR_INVALID_ARGUMENT, "group.children is NULL");
  shapes[0].group.children = children;
  shapes[0].kind = SCREE_SHAPE_SMOOTH_UNION;
  assert_refused(shapes, 3, SCREE_ERROR_RANGE, "group.blend is 0");
  const scree_shape group = shapes[0];
  scree_noise noise = {.child = 0, .amplitude = 1, .wavelength = 1};
#define NOISE_REFUSED(change, result, part)                               \
  do {                                                                    \
    shapes[0] = (scree_shape){.kind = SCREE_SHAPE_NOISE, .noise = noise}; \
    shapes[0].noise.child = 1;                                            \
    change;                                                               \
    assert_refused(shapes, 3, SCREE_ERROR_##result, part);                \
  } while (0)
  NOISE_REFUSED(shapes[0].noise.child = 0, INVALID_ARGUMENT, "noise.child is 0, expected a later shape");
  NOISE_REFUSED(shapes[0].noise.child = 3, INVALID_ARGUMENT, "noise.child is 3, expected a later shape");
  NOISE_REFUSED(shapes[0].noise.amplitude = 0, RANGE, "noise.amplitude is 0");
  NOISE_REFUSED(shapes[0].noise.amplitude = 1001, RANGE, "noise.amplitude is more than 1000 times noise.wavelength");
  NOISE_REFUSED(shapes[0].noise.wavelength = NAN, RANGE, "noise.wavelength is not a number");
  NOISE_REFUSED(shapes[0].noise.octaves = 9, RANGE, "noise.octaves is 9");
#undef NOISE_REFUSED
  shapes[0] = group;
  shapes[2].sphere.radius = -1;
  shapes[0].group.blend = 1;
  assert_refused(shapes, 3, SCREE_ERROR_RANGE, "shape 2: sphere.radius");

  random_stream r = {1};
  random_support s;
  random_leaf(&s, &r, SCREE_SHAPE_CALLBACK, 10);
  scree_shape good = s.shapes[0], bad = good;
  bad.callback.distance = NULL;
  assert_refused(&bad, 1, SCREE_ERROR_INVALID_ARGUMENT, "callback.distance is NULL");
  bad = good;
  bad.callback.lipschitz = -1;
  assert_refused(&bad, 1, SCREE_ERROR_RANGE, "callback.lipschitz is -1");
  bad = good;
  bad.callback.max[1] = bad.callback.min[1];
  assert_refused(&bad, 1, SCREE_ERROR_RANGE, "callback.max[1]");
  bad = good;
  bad.callback.min[0] = -INFINITY;
  assert_refused(&bad, 1, SCREE_ERROR_RANGE, "callback.min[0] is -infinity");

  /* Nested once too deep, a shape used so often that the tree has too many, and too far out by transforms in transforms. */
  enum { DEEP = SUPPORT_MAX_NESTING + 1 };
  scree_shape chain[DEEP + 1];
  uint32_t next[DEEP][2];
  memset(chain, 0, sizeof chain);
  for (uint32_t i = 0; i < DEEP; ++i) {
    next[i][0] = next[i][1] = i + 1;
    chain[i] = (scree_shape){.kind = SCREE_SHAPE_UNION, .group = {next[i], 1, 0}};
  }
  chain[DEEP] = shapes[1];
  assert_refused(chain, DEEP + 1, SCREE_ERROR_RANGE, "nested more than 32 deep");
  for (uint32_t i = 0; i < DEEP; ++i) chain[i].group.child_count = 2;
  assert_refused(chain, DEEP + 1, SCREE_ERROR_RANGE, "has more than 4096 shapes");
  float points[3 * 256], radii[256]; /* a tube counts once a piece */
  for (int i = 0; i < 3 * 256; ++i) points[i] = (float)(i * i % 101);
  for (int i = 0; i < 256; ++i) radii[i] = 1;
  scree_shape tube = {.kind = SCREE_SHAPE_TUBE, .tube = {points, radii, 256, true, 32, 0}};
  assert_refused(&tube, 1, SCREE_ERROR_RANGE, "shape 0: the tree below has more than 4096 shapes");
  chain[0] = (scree_shape){.kind = SCREE_SHAPE_UNION, .transform = {.scale = 1e6f}, .group = {next[0], 1, 0}};
  chain[1] = (scree_shape){.kind = SCREE_SHAPE_SPHERE, .transform = {.translation = {1e6f, 0, 0}}, .sphere = {1}};
  assert_refused(chain, 2, SCREE_ERROR_RANGE, "shape 1: lies more than 1e9 metres");
}

/* --- memory ---------------------------------------------------------------------------------------------------------------- */

/* Each allocation fails once; nothing is left behind, and in the end it works. */
static void creating_survives_every_failed_allocation(void** state) {
  (void)state;
  random_stream r = {11};
  random_support ring, ground;
  random_leaf(&ring, &r, SCREE_SHAPE_MESH, 10);
  random_leaf(&ground, &r, SCREE_SHAPE_HEIGHTFIELD, 10);
  random_support blobs, walls;
  random_leaf(&blobs, &r, SCREE_SHAPE_BLOBS, 10);
  random_leaf(&walls, &r, SCREE_SHAPE_EXTRUSION, 10);
  const uint32_t children[6] = {1, 2, 2, 3, 4, 5};
  const scree_shape shapes[6] = {{.kind = SCREE_SHAPE_UNION, .group = {children, 6, 0}},
                                 ring.shapes[0],
                                 ground.shapes[0],
                                 blobs.shapes[0],
                                 walls.shapes[0],
                                 ground.shapes[0]};
  scree_support_desc desc = {.shapes = shapes, .shape_count = 6};
  scree_support* earlier = NULL; /* shares its grids in the last round */
  assert_int_equal(scree_support_create(&desc, NULL, &earlier, NULL), SCREE_OK);
  synthetic_source source = synthetic_create(4, 1, 2, 1);
  const scree_field_desc field_desc = {.seed = 1, .cell_size = 1};
  for (int what = 0; what < 3; ++what) {
    if (what == 2) desc.reuse = earlier;
    scree_result result = SCREE_ERROR_OUT_OF_MEMORY;
    int n = 0;
    for (; result != SCREE_OK; ++n) {
      failing_allocator memory = {.fail_at = n};
      const scree_allocator allocator = failing_allocator_of(&memory);
      scree_support* support = NULL;
      scree_field* field = NULL;
      scree_error error;
      result = what != 1 ? scree_support_create(&desc, &allocator, &support, &error)
                         : scree_rt_field_create_from_source(&field_desc, &source.source, &allocator, &field);
      if (result == SCREE_OK) {
        assert_true(memory.live > 0);
      } else {
        assert_int_equal(result, SCREE_ERROR_OUT_OF_MEMORY);
        assert_true(support == NULL && field == NULL);
        if (what != 1) assert_string_equal(error.message, "out of memory");
      }
      scree_support_destroy(support);
      scree_field_destroy(field);
      assert_int_equal(memory.live, 0);
    }
    assert_true(n > 3);
  }
  scree_support_destroy(earlier);
  synthetic_destroy(&source);
}

/* Tables that no field can be made of. */
static void broken_field_tables_are_refused(void** state) {
  (void)state;
  synthetic_source s = synthetic_create(4, 1, 2, 1);
  const scree_field_desc good = {.seed = 1, .cell_size = 1};
  scree_field* field;
#define REFUSED(change, undo_change, result)                                                                 \
  do {                                                                                                       \
    scree_field_desc desc = good;                                                                            \
    field_source source = s.source;                                                                          \
    change;                                                                                                  \
    assert_int_equal(scree_rt_field_create_from_source(&desc, &source, NULL, &field), SCREE_ERROR_##result); \
    assert_null(field);                                                                                      \
    undo_change;                                                                                             \
    (void)desc;                                                                                              \
    (void)source;                                                                                            \
  } while (0)
#define BROKEN(place, value)                             \
  do {                                                   \
    __typeof__(place) kept = (place);                    \
    REFUSED((place) = (value), (place) = kept, CORRUPT); \
  } while (0)
  REFUSED(desc.cell_size = 0, (void)0, RANGE);
  REFUSED(desc.cell_size = NAN, (void)0, RANGE);
  REFUSED(desc.cell_size = INFINITY, (void)0, RANGE);
  REFUSED(desc.origin[2] = NAN, (void)0, RANGE);
  REFUSED(source.cells_per_cube = 2, (void)0, CORRUPT);
  REFUSED(source.cells_per_cube = 9, (void)0, CORRUPT);
  REFUSED(source.max_rocks_per_cell = 0, (void)0, CORRUPT);
  REFUSED(source.max_rocks_per_cell = 1, (void)0, CORRUPT);
  REFUSED(source.max_rocks_per_cell = 1000, (void)0, CORRUPT);
  REFUSED(source.max_radius = 0, (void)0, CORRUPT);
  REFUSED(source.max_radius = NAN, (void)0, CORRUPT);
  REFUSED(source.max_radius = 0.5f, (void)0, CORRUPT);
  REFUSED(source.asset_count -= 1, (void)0, CORRUPT);
  BROKEN(s.tile_cells[777], s.source.cell_count);
  BROKEN(s.cell_first[5], UINT32_MAX);
  BROKEN(s.cell_first[5], 0);
  BROKEN(s.rocks[9].centroid[1], NAN);
  BROKEN(s.rocks[9].centroid[1], 2.5f);
  BROKEN(s.rocks[9].inner_radius, -0.1f);
  BROKEN(s.rocks[9].inner_radius, 1.06f);
  BROKEN(s.rocks[9].outer_radius, NAN);
  BROKEN(s.rocks[9].outer_radius, 2.0f);
  BROKEN(s.rocks[9].seed, 2);
#undef BROKEN
#undef REFUSED
  assert_int_equal(scree_rt_field_create_from_source(&good, &s.source, NULL, &field), SCREE_OK);
  scree_field_destroy(field);
  synthetic_destroy(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(wrong_numbers_are_refused_by_shape_and_field),
      cmocka_unit_test(numbers_in_errors_have_six_digits),
      cmocka_unit_test(broken_meshes_are_refused_by_edge),
      cmocka_unit_test(boxes_that_touch_along_an_edge_are_one_closed_mesh),
      cmocka_unit_test(broken_trees_and_callbacks_are_refused),
      cmocka_unit_test(creating_survives_every_failed_allocation),
      cmocka_unit_test(broken_field_tables_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
