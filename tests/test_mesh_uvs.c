/* Texture coordinates of mesh files: each corner keeps its own, v runs down, and wrong ones are told in one line. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* after those above */
#include <cmocka.h>

#ifdef SCREE_WITH_DRACO
#include "draco_cube.h"
#endif
#include "mesh_files.h"

/* A tetrahedron with a vt in every corner: one, two and three numbers, counts from both ends, a triangle that welding drops before
 * one that it keeps, and vertices at one place with different vt. */
static const char mapped_obj[] =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 0\nvt 0.25\nvt 0.5 0.25\nvt 1 2 3\nf 1/1 3/2 2/3\nf 1/1 5/2 2/3\n"
    "f -1/-3/1 -4/-2/1 -2/-1\nvt -0.5 0.75 # a seam\nf 2/4 3/2 4/3\nf 1/4/ 4/2 3/1\n";

static const float mapped_uvs[4][6] = {{0.25f, 1, 0.5f, 0.75f, 1, -1},
                                       {0.25f, 1, 0.5f, 0.75f, 1, -1},
                                       {-0.5f, 0.25f, 0.5f, 0.75f, 1, -1},
                                       {-0.5f, 0.25f, 0.5f, 0.75f, 0.25f, 1}};

static void vt_of_obj_belong_to_corners_and_v_runs_down(void** state) {
  (void)state;
  triangle_mesh mesh;
  scree_error error = {""};
  scree_result result = load_text("mapped.obj", mapped_obj, &mesh, &error);
  assert_string_equal(error.message, "");
  assert_int_equal(result, SCREE_OK);
  assert_true(mesh.vertex_count == 4 && mesh.triangle_count == 4 && is_closed(&mesh));
  assert_non_null(mesh.uvs);
  assert_memory_equal(mesh.uvs, mapped_uvs, sizeof mapped_uvs);
  triangle_mesh_free(&mesh);
}

static void meshes_have_uvs_of_every_triangle_or_none(void** state) {
  (void)state;
  static const char* const lacking[] = {"f 1 4 3\n", "f 1/1 4/1 3\n", "f 1 4/1 3/1\n", "f 1/1/ 4/1/ 3//\n", "f 1//1 4//1 3//1\n"};
  for (size_t i = 0; i < sizeof lacking / sizeof lacking[0]; ++i)
    for (int first = 0; first < 2; ++first) {
      char text[512];
      static const char others[] = "f 1/1 3/1 2/1\nf 1/1 2/1 4/1\nf 2/1 3/1 4/1\n";
      snprintf(text, sizeof text, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\n%s%s%s", first ? lacking[i] : "", others,
               first ? "" : lacking[i]);
      triangle_mesh mesh;
      scree_error error = {""};
      assert_int_equal(load_text("partly.obj", text, &mesh, &error), SCREE_OK);
      assert_true(mesh.triangle_count == 4 && is_closed(&mesh));
      assert_null(mesh.uvs);
      triangle_mesh_free(&mesh);
    }
}

static void wrong_vt_is_refused_by_line(void** state) {
  (void)state;
  static const struct {
    const char *text, *message;
  } cases[] = {
      {"v 1 2 3\nvt 0 0\nvt 0 nan\n", "line 3: expected a number"},
      {"v 1 2 3\nvt 1e39\n", "line 2: expected a number"},
      {"v 1 2 3\nvt\t\n", "line 2: expected a number"},
      {"v 1 2 3\nvt 0 x\n", "line 2: expected a number"},
      {"v 1 2 3\nf 1/1 1/1 1/1\n", "line 2: a face names a vt that does not exist"},
      {"v 1 2 3\nvt 0 0\nf 1/1 1/1 1/2\n", "line 3: a face names a vt that does not exist"},
      {"v 1 2 3\nvt 0 0\nf 1/1 1/0 1/1\n", "line 3: a face names a vt that does not exist"},
      {"v 1 2 3\nvt 0 0\nf 1/1 1/1 1/-2\n", "line 3: a face names a vt that does not exist"},
      {"v 1 2 3\nvt 0 0\nf 1/99999999999999999999 1/1 1/1\n", "line 3: expected a whole number"},
      {"v 1 2 3\nvt 0 0\nf 1/1 1/1 1/x\n", "line 3: expected a whole number"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    triangle_mesh mesh;
    scree_error error = {""};
    char expected[256];
    assert_int_equal(load_text("a.obj", cases[i].text, &mesh, &error), SCREE_ERROR_SYNTAX);
    snprintf(expected, sizeof expected, "%s/a.obj: %s", folder, cases[i].message);
    assert_string_equal(error.message, expected);
    assert_true(mesh.positions == NULL && mesh.uvs == NULL);
  }
}

/* The cube with a third view of 24 UVs: u tells the place, x + 2 y + 4 z, and v the side. */
#define MAPPED_DATA(accessor, meshes)                                                                                 \
  "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"byteLength\": 552}],"                                         \
  "\"bufferViews\": [{\"buffer\": 0, \"byteLength\": 288}, {\"buffer\": 0, \"byteOffset\": 288, \"byteLength\": 72}," \
  "{\"buffer\": 0, \"byteOffset\": 360, \"byteLength\": 192}],"                                                       \
  "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 24, \"type\": \"VEC3\"},"                  \
  "{\"bufferView\": 1, \"componentType\": 5123, \"count\": 36, \"type\": \"SCALAR\"}, {" accessor "}], \"meshes\": [" meshes "],"
#define NODES "\"nodes\": [{\"mesh\": 0}], \"scenes\": [{\"nodes\": [0]}]}"
#define MAPPED_MESH "{\"primitives\": [{\"attributes\": {\"POSITION\": 0, \"TEXCOORD_0\": 2}, \"indices\": 1}]}"
#define BARE_MESH "{\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"indices\": 1}]}"
#define PAIRS "\"bufferView\": 2, \"componentType\": 5126, \"count\": 24, \"type\": \"VEC2\""

static void make_mapped(const char* json, glb_file* out) {
  char bin[552];
  cube_bin(bin);
  for (uint32_t i = 0; i < 24; ++i) {
    float p[3], uv[2];
    memcpy(p, bin + (size_t)i * 12, sizeof p);
    uv[0] = p[0] + 2 * p[1] + 4 * p[2];
    uv[1] = (float)(i / 4);
    memcpy(bin + 360 + (size_t)i * 8, uv, sizeof uv);
  }
  make_glb(json, bin, sizeof bin, out);
}

static scree_result read_mapped(const char* json, triangle_mesh* mesh, scree_error* error) {
  glb_file glb;
  make_mapped(json, &glb);
  return triangle_mesh_load(write_file("cube.glb", glb.bytes, glb.size), mesh, error);
}

static void texture_coordinates_of_glb_stay_with_their_corners(void** state) {
  (void)state;
  triangle_mesh mesh;
  scree_error error = {""};
  /* Mirrored, so that triangles are turned round; then plain. */
  scree_result result = read_mapped(MAPPED_DATA(PAIRS, MAPPED_MESH) "\"nodes\": [{\"mesh\": 0, \"scale\": [-1, 1, 1]}, "
                                                                    "{\"mesh\": 0, \"translation\": [5, 0, 0]}],"
                                                                    "\"scenes\": [{\"nodes\": [0, 1]}]}",
                                    &mesh, &error);
  assert_string_equal(error.message, "");
  assert_int_equal(result, SCREE_OK);
  assert_true(mesh.vertex_count == 16 && mesh.triangle_count == 24 && is_closed(&mesh) && signed_volume(&mesh) > 1.9);
  assert_non_null(mesh.uvs);
  for (uint32_t i = 0; i < 24 * 3; ++i) {
    const float* p = &mesh.positions[3 * mesh.indices[i]];
    assert_true(mesh.uvs[2 * i] == (p[0] >= 5 ? p[0] - 5 : -p[0]) + 2 * p[1] + 4 * p[2]);
    assert_true(mesh.uvs[2 * i + 1] == (float)(i / 6 % 6));
  }
  triangle_mesh_free(&mesh);
}

static void texture_coordinates_of_draco_meshes_stay_with_their_corners(void** state) {
  (void)state;
#ifdef SCREE_WITH_DRACO
  static const struct {
    uint32_t ones; /* what stands for 1 */
    const char *keys, *message;
  } cases[] = {
      {0, "\"POSITION\": 0, \"TEXCOORD_0\": 1", NULL},
      {255, "\"POSITION\": 0, \"TEXCOORD_0\": 1", NULL},
      {65535, "\"POSITION\": 0, \"TEXCOORD_0\": 1", NULL},
      {0, "\"POSITION\": 0", "none"},
      {0, "\"POSITION\": 0, \"TEXCOORD_0\": 0", "Draco: no such TEXCOORD_0"},
      {0, "\"POSITION\": 0, \"TEXCOORD_0\": 2", "Draco: no such TEXCOORD_0"},
      {0, "\"POSITION\": 0, \"TEXCOORD_0\": -1", "Draco: no such TEXCOORD_0"},
  };
  char bin[360], bytes[4096] = {0}, json[1024], expected[256];
  float positions[72], uvs[48];
  uint16_t indices[36];
  cube_bin(bin);
  memcpy(positions, bin, sizeof positions);
  memcpy(indices, bin + 288, sizeof indices);
  for (uint32_t i = 0; i < 24; ++i) {
    uvs[2 * i] = (positions[3 * i] + 2 * positions[3 * i + 1] + 4 * positions[3 * i + 2]) / 15;
    uvs[2 * i + 1] = (float)(i / 4) / 5;
  }
  for (size_t c = 0; c < sizeof cases / sizeof cases[0]; ++c) {
    const size_t size = draco_cube_encode(positions, uvs, 24, indices, 12, cases[c].ones, bytes, sizeof bytes);
    const size_t padded = (size + 3) & ~(size_t)3;
    assert_true(size > 0 && padded <= sizeof bytes);
    snprintf(json, sizeof json,
             "{\"asset\": {\"version\": \"2.0\"}, \"extensionsRequired\": [\"KHR_draco_mesh_compression\"],"
             "\"buffers\": [{\"byteLength\": %zu}], \"bufferViews\": [{\"buffer\": 0, \"byteLength\": %zu}],"
             "\"accessors\": [{\"componentType\": 5126, \"count\": 24, \"type\": \"VEC3\"}],"
             "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"extensions\": {"
             "\"KHR_draco_mesh_compression\": {\"bufferView\": 0, \"attributes\": {%s}}}}]}]," NODES,
             padded, size, cases[c].keys);
    glb_file glb;
    make_glb(json, bytes, padded, &glb);
    triangle_mesh mesh;
    scree_error error = {""};
    const scree_result result = triangle_mesh_load(write_file("draco.glb", glb.bytes, glb.size), &mesh, &error);
    const bool good = cases[c].message == NULL || strcmp(cases[c].message, "none") == 0;
    snprintf(expected, sizeof expected, "%s/draco.glb: %s", folder, good ? "" : cases[c].message);
    assert_string_equal(error.message, good ? "" : expected);
    assert_int_equal(result, good ? SCREE_OK : SCREE_ERROR_SYNTAX);
    if (!good) continue;
    assert_unit_cube(&mesh);
    assert_true((mesh.uvs == NULL) == (cases[c].message != NULL));
    for (uint32_t i = 0; mesh.uvs != NULL && i < 36; ++i) {
      const float *p = &mesh.positions[3 * mesh.indices[i]], *uv = &mesh.uvs[2 * i];
      const float side = 5 * mesh.uvs[i / 3 * 6 + 1];
      assert_true(fabsf(15 * uv[0] - (p[0] + 2 * p[1] + 4 * p[2])) < 1e-5f);
      assert_true(fabsf(side - roundf(side)) < 1e-5f && uv[1] == mesh.uvs[i / 3 * 6 + 1]);
    }
    triangle_mesh_free(&mesh);
  }
#else
  skip();
#endif
}

static void glb_with_a_part_that_lacks_texture_coordinates_has_none(void** state) {
  (void)state;
  for (int first = 0; first < 2; ++first) {
    triangle_mesh mesh;
    scree_error error = {""};
    const char* nodes = first ? "\"nodes\": [{\"mesh\": 1}, {\"mesh\": 0, \"translation\": [5, 0, 0]}]"
                              : "\"nodes\": [{\"mesh\": 0}, {\"mesh\": 1, \"translation\": [5, 0, 0]}]";
    char json[2048];
    snprintf(json, sizeof json, "%s%s, \"scenes\": [{\"nodes\": [0, 1]}]}", MAPPED_DATA(PAIRS, MAPPED_MESH "," BARE_MESH), nodes);
    assert_int_equal(read_mapped(json, &mesh, &error), SCREE_OK);
    assert_true(mesh.triangle_count == 24 && is_closed(&mesh));
    assert_null(mesh.uvs);
    triangle_mesh_free(&mesh);
  }
}

static void wrong_texture_coordinates_of_glb_are_one_clear_line(void** state) {
  (void)state;
  static const struct {
    const char *json, *message;
  } cases[] = {
#define MAPPED(keys) MAPPED_DATA(keys, MAPPED_MESH) NODES
      {MAPPED("\"bufferView\": 2, \"componentType\": 5126, \"count\": 23, \"type\": \"VEC2\""),
       "TEXCOORD_0 has not one element a vertex"},
      {MAPPED("\"bufferView\": 2, \"componentType\": 5126, \"count\": 4000000000, \"type\": \"VEC2\""),
       "TEXCOORD_0 has not one element a vertex"},
      {MAPPED("\"byteOffset\": 4, " PAIRS), "an accessor reaches past the end of its buffer view"},
      {MAPPED("\"bufferView\": 2, \"componentType\": 5126, \"count\": 24, \"type\": \"VEC3\""),
       "TEXCOORD_0 is of a type that is not read"},
      {MAPPED("\"bufferView\": 2, \"componentType\": 5121, \"count\": 24, \"type\": \"VEC2\""),
       "TEXCOORD_0 is of a type that is not read"},
      {MAPPED("\"bufferView\": 2, \"componentType\": 5120, \"normalized\": true, \"count\": 24, \"type\": \"VEC2\""),
       "TEXCOORD_0 is of a type that is not read"},
      {MAPPED("\"bufferView\": 7, \"componentType\": 5126, \"count\": 24, \"type\": \"VEC2\""),
       "names the buffer view 7, which does not exist"},
      {MAPPED_DATA(PAIRS, "{\"primitives\": [{\"attributes\": {\"POSITION\": 0, \"TEXCOORD_0\": 9}, \"indices\": 1}]}") NODES,
       "names the accessor 9, which does not exist"},
  };
  triangle_mesh mesh;
  char expected[256];
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    scree_error error = {""};
    assert_int_equal(read_mapped(cases[i].json, &mesh, &error), SCREE_ERROR_SYNTAX);
    snprintf(expected, sizeof expected, "%s/cube.glb: %s", folder, cases[i].message);
    assert_string_equal(error.message, expected);
  }
  static const float wrong[2] = {NAN, INFINITY};
  for (int i = 0; i < 2; ++i) {
    glb_file glb;
    scree_error error = {""};
    make_mapped(MAPPED(PAIRS), &glb);
    memcpy(glb.bytes + glb.size - 4, &wrong[i], 4);
    assert_int_equal(mesh_read_gltf(glb.bytes, glb.size, "m.glb", &mesh, &error), SCREE_ERROR_SYNTAX);
    assert_string_equal(error.message, "m.glb: TEXCOORD_0 is not finite");
  }
}

static void broken_uvs_never_crash(void** state) {
  (void)state;
  glb_file glb;
  make_mapped(MAPPED(PAIRS), &glb);
  mutate(glb.bytes, glb.size, 5, 4000, mesh_read_gltf);
  mutate(mapped_obj, strlen(mapped_obj), 4, 5000, mesh_read_obj);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(vt_of_obj_belong_to_corners_and_v_runs_down),
      cmocka_unit_test(meshes_have_uvs_of_every_triangle_or_none),
      cmocka_unit_test(wrong_vt_is_refused_by_line),
      cmocka_unit_test(texture_coordinates_of_glb_stay_with_their_corners),
      cmocka_unit_test(texture_coordinates_of_draco_meshes_stay_with_their_corners),
      cmocka_unit_test(glb_with_a_part_that_lacks_texture_coordinates_has_none),
      cmocka_unit_test(wrong_texture_coordinates_of_glb_are_one_clear_line),
      cmocka_unit_test(broken_uvs_never_crash),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
