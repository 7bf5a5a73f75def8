/* Readers of meshes and height maps: what good files give, and that bad ones give one line that says what is wrong. */
#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* after the four above */
#include <cmocka.h>

#include "mesh_files.h"
#include "scene_support.h"
#include "terrain.h"

/* A cube of quads in every dialect: comments, joined lines, texture and normal indices, counts from the end, windows line ends. */
static const char cube_obj[] =
    "# a cube\r\no cube\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0 0.5 0.5 0.5\nv 0 1.0e0 0 # corner\nv 0 0 1\nv \\\n 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "vt 0 0\nvn 0 0 1\ns off\nusemtl stone\nf 4 3 2 1\nf 5/1 6/1 7/1 8/1\nf 1//1 2//1 6//1 5//1\r\nf 3/1/1 4/1/1 8/1/1 7/1/1\n"
    "f -8 -4 -1 -5\nl 1 2\nf 2 3 \\\n 7 6";

static const char cube_off[] =
    "OFF # a cube\n\n# counts\n8 6 12\n0 0 0\n1 0 0 255 0 0\n1 1 0\n0 1 0\n0 0 1\n\n1 0 1\n1 1 1\n0 1 1\n"
    "4 3 2 1 0\n4 4 5 6 7  0.5 0.5 0.5\n4 0 1 5 4\n4 2 3 7 6 # face\n4 0 4 7 3\n4 1 2 6 5";

static void obj_of_every_dialect_is_read(void** state) {
  (void)state;
  triangle_mesh mesh;
  scree_error error = {""};
  scree_result result = load_text("cube.obj", cube_obj, &mesh, &error);
  assert_string_equal(error.message, "");
  assert_int_equal(result, SCREE_OK);
  assert_unit_cube(&mesh);
  triangle_mesh_free(&mesh);
}

static void off_of_every_dialect_is_read(void** state) {
  (void)state;
  static const char* const headers[] = {"OFF", "COFF", "NOFF"};
  for (size_t i = 0; i < 3; ++i) {
    char text[512];
    snprintf(text, sizeof text, "%s%s", headers[i], cube_off + 3);
    triangle_mesh mesh;
    scree_error error = {""};
    scree_result result = load_text("CUBE.OFF", text, &mesh, &error);
    assert_string_equal(error.message, "");
    assert_int_equal(result, SCREE_OK);
    assert_unit_cube(&mesh);
    triangle_mesh_free(&mesh);
  }
}

static void wrong_text_mesh_is_refused_by_line(void** state) {
  (void)state;
  static const struct {
    const char *name, *text, *message;
  } cases[] = {
      {"a.obj", "", "has no triangles"},
      {"a.obj", "v 1 2\nf 1 1 1\n", "line 1: expected a number"},
      {"a.obj", "v 1 2 nan\n", "line 1: expected a number"},
      {"a.obj", "v 1 2 1e99\n", "line 1: expected a number"},
      {"a.obj", "v 1 2 3x\n", "line 1: expected a number"},
      {"a.obj", "v 1 2 3\n\nf 1 2 1\n", "line 3: a face names a vertex that does not exist"},
      {"a.obj", "v 1 2 3\nf 0 1 1\n", "line 2: a face names a vertex that does not exist"},
      {"a.obj", "v 1 2 3\nf -2 1 1\n", "line 2: a face names a vertex that does not exist"},
      {"a.obj", "v 1 2 3\nf 99999999999999999999 1 1\n", "line 2: expected a whole number"},
      {"a.obj", "v 1 2 3\nf 1 1\n", "line 2: a face has fewer than 3 corners"},
      {"a.obj", "v 1 2 3\nf 1 1 1.5\n", "line 2: expected a corner such as 7, 7/1, 7//2 or 7/1/2"},
      {"a.obj", "v 0 0 0\nf 1 1 1\n", "has no triangles"},
      {"a.off", "", "line 1: the file ends early"},
      {"a.off", "PLY\n", "line 1: not an OFF file: it does not begin with OFF"},
      {"a.off", "OFF BINARY\n", "line 1: binary OFF is not read, only text"},
      {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n", "line 5: the file ends early"},
      {"a.off", "OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2", "line 4: expected a number"},
      {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3", "line 6: a count or an index out of range"},
      {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1", "line 6: a count or an index out of range"},
      {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1    ", "line 6: a face has fewer than 3 corners"},
      {"a.off", "OFF\n2000000000 2000000000 0\n", "line 2: a count or an index out of range"},
      {"a.off", "OFF\n0 0 0\n", "line 2: has no triangles"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    triangle_mesh mesh;
    scree_error error = {""};
    assert_int_equal(load_text(cases[i].name, cases[i].text, &mesh, &error), SCREE_ERROR_SYNTAX);
    char expected[256];
    snprintf(expected, sizeof expected, "%s/%s: %s", folder, cases[i].name, cases[i].message);
    assert_string_equal(error.message, expected);
    assert_null(mesh.positions);
  }
}

static void unknown_ending_and_missing_file_are_named(void** state) {
  (void)state;
  triangle_mesh mesh;
  scree_error error;
  assert_int_equal(triangle_mesh_load("a.stl", &mesh, &error), SCREE_ERROR_UNSUPPORTED);
  assert_string_equal(error.message, "a.stl: expected a file that ends in .obj, .off, .glb or .gltf");
  assert_int_equal(triangle_mesh_load("no_such.obj", &mesh, &error), SCREE_ERROR_IO);
  assert_string_equal(error.message, "no_such.obj: cannot open: No such file or directory");
}

static void welding_joins_equal_places_only(void** state) {
  (void)state;
  triangle_mesh mesh = {.vertex_count = 7, .triangle_count = 3};
  static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, -0.0f, 0, 0, 1, 0, 0, 0, 1, 1e-30f, 0, 1, 0};
  static const uint32_t indices[] = {0, 1, 2, 3, 4, 5, 0, 3, 6};
  mesh.positions = malloc(sizeof positions);
  mesh.indices = malloc(sizeof indices);
  memcpy(mesh.positions, positions, sizeof positions);
  memcpy(mesh.indices, indices, sizeof indices);
  assert_int_equal(triangle_mesh_weld(&mesh), SCREE_OK);
  assert_int_equal(mesh.vertex_count, 4);
  assert_int_equal(mesh.triangle_count, 2); /* the third lost an edge */
  static const uint32_t expected[] = {0, 1, 2, 0, 1, 3};
  assert_memory_equal(mesh.indices, expected, sizeof expected);
  assert_true(mesh.positions[3 * 3 + 2] == 1e-30f);
  triangle_mesh_free(&mesh);
}

static void broken_text_meshes_never_crash(void** state) {
  (void)state;
  mutate(cube_obj, strlen(cube_obj), 1, 5000, mesh_read_obj);
  mutate(cube_off, strlen(cube_off), 2, 5000, mesh_read_off);
}

/* --- glTF ---------------------------------------------------------------------------------------------------------------- */

#define CUBE_DATA                                                                                                       \
  "\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"byteLength\": 360}],"                                            \
  "\"bufferViews\": [{\"buffer\": 0, \"byteLength\": 288}, {\"buffer\": 0, \"byteOffset\": 288, \"byteLength\": 72}],"  \
  "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 24, \"type\": \"VEC3\", \"min\": [0, 0, 0]," \
  " \"max\": [1, 1, 1]}, {\"bufferView\": 1, \"componentType\": 5123, \"count\": 36, \"type\": \"SCALAR\"}],"           \
  "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"indices\": 1}]}],"

static scree_result read_glb(const char* json, triangle_mesh* mesh, scree_error* error) {
  char bin[360];
  glb_file glb;
  cube_bin(bin);
  make_glb(json, bin, sizeof bin, &glb);
  return triangle_mesh_load(write_file("cube.glb", glb.bytes, glb.size), mesh, error);
}

static void glb_cube_is_read_and_welded(void** state) {
  (void)state;
  triangle_mesh mesh;
  scree_error error = {""};
  scree_result result = read_glb("{" CUBE_DATA "\"nodes\": [{\"mesh\": 0}], \"scenes\": [{\"nodes\": [0]}]}", &mesh, &error);
  assert_string_equal(error.message, "");
  assert_int_equal(result, SCREE_OK);
  assert_unit_cube(&mesh);
  triangle_mesh_free(&mesh);
}

static void glb_default_scene_is_merged_with_its_transforms(void** state) {
  (void)state;
  triangle_mesh mesh;
  scree_error error = {""};
  /* A parent at x = 10, scaled by 2, with a child turned a quarter about z and mirrored, and a plain sibling from a matrix. Scene 0
   * is not the default one. */
  scree_result result =
      read_glb("{" CUBE_DATA
               "\"nodes\": [{\"mesh\": 0}, {\"translation\": [10, 0, 0], \"scale\": [2, 2, 2], \"children\": [2]},"
               " {\"mesh\": 0, \"rotation\": [0, 0, 0.70710678, 0.70710678], \"scale\": [1, 1, -1]},"
               " {\"mesh\": 0, \"matrix\": [1, 0, 0, 0, 0, 3, 0, 0, 0, 0, 1, 0, -5, 0, 0, 1]}],"
               "\"scenes\": [{\"nodes\": [0]}, {\"nodes\": [1, 3]}], \"scene\": 1}",
               &mesh, &error);
  assert_string_equal(error.message, "");
  assert_int_equal(result, SCREE_OK);
  assert_int_equal(mesh.vertex_count, 16);
  assert_int_equal(mesh.triangle_count, 24);
  assert_true(is_closed(&mesh));
  double volume = signed_volume(&mesh);
  assert_true(volume > 10.9999 && volume < 11.0001); /* 8 + 3, both the right way out */
  float min[3] = {1e9f, 1e9f, 1e9f}, max[3] = {-1e9f, -1e9f, -1e9f};
  for (uint32_t i = 0; i < 24; ++i) {
    float value = mesh.positions[i];
    min[i % 3] = value < min[i % 3] ? value : min[i % 3];
    max[i % 3] = value > max[i % 3] ? value : max[i % 3];
  }
  static const float expected_min[3] = {8, 0, -2}, expected_max[3] = {10, 2, 0};
  for (int k = 0; k < 3; ++k) {
    assert_true(min[k] > expected_min[k] - 1e-5f && min[k] < expected_min[k] + 1e-5f);
    assert_true(max[k] > expected_max[k] - 1e-5f && max[k] < expected_max[k] + 1e-5f);
  }
  triangle_mesh_free(&mesh);
}

static void wrong_glb_is_one_clear_line(void** state) {
  (void)state;
#define NODES "\"nodes\": [{\"mesh\": 0}], \"scenes\": [{\"nodes\": [0]}]}"
#define DATA(view, accessor, primitive)                                                                \
  "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"byteLength\": 360}], \"bufferViews\": [{" view \
  "}, {\"buffer\": 0, \"byteOffset\": 288, \"byteLength\": 72}], \"accessors\": [{" accessor           \
  "}, {\"bufferView\": 1, \"componentType\": 5123, \"count\": 36, \"type\": \"SCALAR\"}]," primitive
#define VIEW "\"buffer\": 0, \"byteLength\": 288"
#define ACCESSOR "\"bufferView\": 0, \"componentType\": 5126, \"count\": 24, \"type\": \"VEC3\""
#define MESH(keys) "\"meshes\": [{\"primitives\": [{" keys "}]}]," NODES
#define PRIMITIVE MESH("\"attributes\": {\"POSITION\": 0}, \"indices\": 1")
  static const struct {
    const char *json, *message;
  } cases[] = {
      {"{", "not valid JSON"},
      {"[]", "not valid JSON"},
      {"{\"asset\": {\"version\": \"2.0\"}}", "has no scene"},
      {"{" CUBE_DATA "\"scenes\": [{}]}", "has no triangles"},
      {"{" CUBE_DATA "\"scenes\": [{\"nodes\": [3]}]}", "names the node 3, which does not exist"},
      {"{" CUBE_DATA "\"nodes\": [{\"mesh\": 4}], \"scenes\": [{\"nodes\": [0]}]}", "names the mesh 4, which does not exist"},
      {"{" CUBE_DATA "\"nodes\": [{\"children\": [0]}], \"scenes\": [{\"nodes\": [0]}]}",
       "nodes form a loop, or are nested too deeply"},
      {"{" CUBE_DATA "\"nodes\": [{\"mesh\": 0, \"translation\": [1e300, 0, 0]}], \"scenes\": [{\"nodes\": [0]}]}",
       "a position is not finite"},
      {"{\"extensionsRequired\": [\"KHR_mesh_quantization\"]," CUBE_DATA NODES,
       "needs the extension KHR_mesh_quantization, which is not read"},
      {DATA("\"buffer\": 0, \"byteLength\": 999", ACCESSOR, PRIMITIVE), "a buffer view reaches past the end of its buffer"},
      {DATA("\"buffer\": 0, \"byteOffset\": 300, \"byteLength\": 288", ACCESSOR, PRIMITIVE),
       "a buffer view reaches past the end of its buffer"},
      {DATA("\"buffer\": 9, \"byteLength\": 288", ACCESSOR, PRIMITIVE), "names the buffer 9, which does not exist"},
      {DATA(VIEW, "\"bufferView\": 0, \"componentType\": 5126, \"count\": 25, \"type\": \"VEC3\"", PRIMITIVE),
       "an accessor reaches past the end of its buffer view"},
      {DATA(VIEW, ACCESSOR ", \"byteOffset\": 4", PRIMITIVE), "an accessor reaches past the end of its buffer view"},
      {DATA(VIEW, "\"bufferView\": 7, \"componentType\": 5126, \"count\": 24, \"type\": \"VEC3\"", PRIMITIVE),
       "names the buffer view 7, which does not exist"},
      {DATA(VIEW, "\"bufferView\": 0, \"componentType\": 5123, \"count\": 24, \"type\": \"VEC3\"", PRIMITIVE),
       "only float POSITION is read"},
      {DATA(VIEW, "\"bufferView\": 0, \"componentType\": 5126, \"count\": 23, \"type\": \"VEC3\"", PRIMITIVE),
       "an index points past the last vertex"},
      {DATA(VIEW, ACCESSOR, MESH("\"attributes\": {\"NORMAL\": 0}, \"indices\": 1")), "a mesh has no POSITION"},
      {DATA(VIEW, ACCESSOR, MESH("\"attributes\": {\"POSITION\": 5}, \"indices\": 1")),
       "names the accessor 5, which does not exist"},
      {DATA(VIEW, ACCESSOR, MESH("\"mode\": 5, \"attributes\": {\"POSITION\": 0}, \"indices\": 1")),
       "only lists of triangles are read, no strips and fans"},
      {DATA(VIEW, ACCESSOR, MESH("\"mode\": 1, \"attributes\": {\"POSITION\": 0}, \"indices\": 1")), "has no triangles"},
      {DATA(VIEW, ACCESSOR,
            MESH("\"attributes\": {\"POSITION\": 0}, \"indices\": 1,"
                 "\"extensions\": {\"KHR_draco_mesh_compression\": {\"bufferView\": 9, \"attributes\": {\"POSITION\": 0}}}")),
       "names the buffer view 9, which does not exist"},
      {DATA(VIEW, ACCESSOR,
            MESH("\"attributes\": {\"POSITION\": 0}, \"indices\": 1, \"extensions\": {\"KHR_draco_mesh_compression\": {}}")),
       "KHR_draco_mesh_compression names no POSITION"},
      {DATA(VIEW, ACCESSOR,
            MESH("\"attributes\": {\"POSITION\": 0}, \"indices\": 1,"
                 "\"extensions\": {\"KHR_draco_mesh_compression\": {\"bufferView\": 0, \"attributes\": {\"POSITION\": 0}}}")),
       "Draco: Not a Draco file."},
  };
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    triangle_mesh mesh;
    scree_error error = {""};
    assert_int_equal(read_glb(cases[i].json, &mesh, &error), SCREE_ERROR_SYNTAX);
    char expected[256];
    snprintf(expected, sizeof expected, "%s/cube.glb: %s", folder, cases[i].message);
    assert_string_equal(error.message, expected);
  }
}

static void deeply_nested_gltf_is_refused(void** state) {
  (void)state;
  size_t depth = 1000000;
  char* text = malloc(2 * depth + 64);
  char* at = text + sprintf(text, "{\"asset\": {\"version\": \"2.0\"}, \"extras\": ");
  memset(at, '[', depth);
  memset(at + depth, ']', depth);
  strcpy(at + 2 * depth, "}");
  triangle_mesh mesh;
  scree_error error = {""};
  assert_int_equal(mesh_read_gltf(text, strlen(text), "deep.gltf", &mesh, &error), SCREE_ERROR_SYNTAX);
  assert_string_equal(error.message, "deep.gltf: JSON is nested too deeply");
  free(text);
}

static void gltf_with_a_buffer_beside_it_is_read(void** state) {
  (void)state;
  char bin[360];
  cube_bin(bin);
  write_file("cube.bin", bin, sizeof bin);
  static const char json[] =
      "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"byteLength\": 360, \"uri\": \"cube.bin\"}],"
      "\"bufferViews\": [{\"buffer\": 0, \"byteLength\": 288}],"
      "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 24, \"type\": \"VEC3\"}],"
      "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}}]}],"
      "\"nodes\": [{\"mesh\": 0}], \"scenes\": [{\"nodes\": [0]}]}";
  triangle_mesh mesh;
  scree_error error = {""};
  assert_int_equal(load_text("cube.gltf", json, &mesh, &error), SCREE_OK);
  assert_int_equal(mesh.triangle_count, 8); /* without indices every three corners are a triangle */
  triangle_mesh_free(&mesh);
  char* broken = strdup(json);
  memcpy(strstr(broken, "cube.bin"), "gone.bin", 8);
  assert_int_equal(load_text("gone.gltf", broken, &mesh, &error), SCREE_ERROR_SYNTAX);
  assert_non_null(strstr(error.message, "gone.bin"));
  free(broken);
}

static void broken_glb_never_crashes(void** state) {
  (void)state;
  char bin[360];
  glb_file glb;
  cube_bin(bin);
  make_glb("{" CUBE_DATA "\"nodes\": [{\"mesh\": 0, \"scale\": [1, 2, 3]}], \"scenes\": [{\"nodes\": [0]}], \"scene\": 0}", bin,
           sizeof bin, &glb);
  mutate(glb.bytes, glb.size, 3, 4000, mesh_read_gltf);
}

/* --- height maps --------------------------------------------------------------------------------------------------------- */

static uint32_t png_crc(const unsigned char* bytes, size_t size) {
  uint32_t crc = UINT32_MAX;
  for (size_t i = 0; i < size; ++i) {
    crc ^= bytes[i];
    for (int k = 0; k < 8; ++k) crc = crc >> 1 ^ (crc & 1 ? UINT32_C(0xedb88320) : 0);
  }
  return ~crc;
}

static void put_big(unsigned char* to, uint32_t word) {
  for (int i = 0; i < 4; ++i) to[i] = (unsigned char)(word >> (24 - 8 * i));
}

static size_t png_chunk(unsigned char* to, const char* type, const unsigned char* data, size_t size) {
  put_big(to, (uint32_t)size);
  memcpy(to + 4, type, 4);
  if (size > 0) memcpy(to + 8, data, size);
  put_big(to + 8 + size, png_crc(to + 4, size + 4));
  return size + 12;
}

/* A PNG of one stored block: `rows` holds height rows, each a filter byte 0 and the samples. */
static size_t make_png(uint32_t width, uint32_t height, int bits, int colour_type, const unsigned char* rows, size_t size,
                       unsigned char* out) {
  unsigned char header[13] = {0}, packed[512];
  put_big(header, width);
  put_big(header + 4, height);
  header[8] = (unsigned char)bits;
  header[9] = (unsigned char)colour_type;
  assert_true(size + 11 <= sizeof packed);
  packed[0] = 0x78, packed[1] = 0x01, packed[2] = 1;
  packed[3] = (unsigned char)size, packed[4] = (unsigned char)(size >> 8);
  packed[5] = (unsigned char)~packed[3], packed[6] = (unsigned char)~packed[4];
  memcpy(packed + 7, rows, size);
  uint32_t a = 1, b = 0;
  for (size_t i = 0; i < size; ++i) {
    a = (a + rows[i]) % 65521;
    b = (b + a) % 65521;
  }
  put_big(packed + 7 + size, b << 16 | a);
  memcpy(out, "\x89PNG\r\n\x1a\n", 8);
  size_t length = 8;
  length += png_chunk(out + length, "IHDR", header, 13);
  length += png_chunk(out + length, "IDAT", packed, size + 11);
  return length + png_chunk(out + length, "IEND", NULL, 0);
}

/* 4 x 3 samples: 1000 * (row * 4 + column), the last one 65535. */
static size_t small_map(unsigned char* out) {
  unsigned char rows[27] = {0};
  for (uint32_t i = 0; i < 12; ++i) {
    uint32_t value = i == 11 ? 65535 : 1000 * i;
    unsigned char* to = rows + i / 4 * 9 + 1 + i % 4 * 2;
    to[0] = (unsigned char)(value >> 8);
    to[1] = (unsigned char)value;
  }
  return make_png(4, 3, 16, 0, rows, sizeof rows, out);
}

static void height_map_is_cropped_and_scaled(void** state) {
  (void)state;
  unsigned char png[1024] = {0};
  size_t size = small_map(png);
  const char* path = write_file("map.png", png, size);
  scene_height_map map = {.spacing = 2, .low = -100, .high = 555.35};
  height_samples samples;
  scree_error error = {""};
  scree_result result = height_samples_load(&map, path, &samples, &error);
  assert_string_equal(error.message, "");
  assert_int_equal(result, SCREE_OK);
  assert_true(samples.width == 4 && samples.depth == 3);
  assert_true(samples.heights[0] == -100.0f && samples.heights[11] == 555.35f);
  assert_true(samples.heights[1] > -90.001f && samples.heights[1] < -89.999f); /* 1000 / 65535 of 655.35 m */
  height_samples_free(&samples);
  memcpy(map.crop, (uint32_t[4]){1, 1, 2, 2}, sizeof map.crop);
  assert_int_equal(height_samples_load(&map, path, &samples, &error), SCREE_OK);
  assert_true(samples.width == 2 && samples.depth == 2);
  assert_true(samples.heights[0] > -50.001f && samples.heights[0] < -49.999f); /* row 1, column 1: sample 5 */
  assert_true(samples.heights[3] > -0.001f && samples.heights[3] < 0.001f);    /* row 2, column 2: sample 10 */
  height_samples_free(&samples);
}

static void wrong_height_map_is_one_clear_line(void** state) {
  (void)state;
  unsigned char png[1024], rows[64] = {0};
  size_t size = small_map(png);
  scene_height_map map = {.spacing = 2, .low = 0, .high = 1, .crop = {3, 0, 2, 2}};
  height_samples samples;
  scree_error error = {""};
  char expected[256];
  assert_int_equal(height_samples_load(&map, write_file("map.png", png, size), &samples, &error), SCREE_ERROR_RANGE);
  snprintf(expected, sizeof expected, "%s/map.png: the crop [3, 0, 2, 2] lies outside the picture of 4 x 3", folder);
  assert_string_equal(error.message, expected);
  assert_int_equal(height_samples_load(&map, write_file("map.png", "hello", 5), &samples, &error), SCREE_ERROR_SYNTAX);
  snprintf(expected, sizeof expected, "%s/map.png: not a PNG picture", folder);
  assert_string_equal(error.message, expected);
  size = make_png(2, 2, 8, 0, rows, 6, png);
  assert_int_equal(height_samples_load(&map, write_file("map.png", png, size), &samples, &error), SCREE_ERROR_UNSUPPORTED);
  snprintf(expected, sizeof expected, "%s/map.png: expected a grey PNG of 16 bits a sample, got 1 channels of 8 bits", folder);
  assert_string_equal(error.message, expected);
  size = make_png(2, 2, 16, 2, rows, 26, png);
  assert_int_equal(height_samples_load(&map, write_file("map.png", png, size), &samples, &error), SCREE_ERROR_UNSUPPORTED);
  snprintf(expected, sizeof expected, "%s/map.png: expected a grey PNG of 16 bits a sample, got 3 channels of 16 bits", folder);
  assert_string_equal(error.message, expected);
}

static void truncated_height_map_is_refused(void** state) {
  (void)state;
  unsigned char png[1024] = {0};
  size_t size = small_map(png);
  scene_height_map map = {.spacing = 2, .low = 0, .high = 1};
  /* From here on only the checksum of the pixels and the end mark are missing, which stb_image does not ask for. */
  size_t enough = size - 12 - 4 - 4;
  for (size_t length = 0; length < enough; ++length) {
    height_samples samples;
    scree_error error = {""};
    assert_int_not_equal(height_samples_load(&map, write_file("map.png", png, length), &samples, &error), SCREE_OK);
    assert_true(error.message[0] != '\0');
    assert_null(samples.heights);
  }
}

static void terrain_mesh_faces_up_and_has_unit_normals(void** state) {
  (void)state;
  unsigned char png[1024] = {0};
  size_t size = small_map(png);
  write_file("map.png", png, size);
  char scene_name[96];
  snprintf(scene_name, sizeof scene_name, "%s/scene.json", folder);
  scene_paths paths = {.scene = scene_name};
  scene_ground ground = {.kind = SCENE_GROUND_TERRAIN, .map = {.file = "map.png", .spacing = 2, .low = 0, .high = 10}};
  terrain_mesh mesh;
  scree_error error = {""};
  scree_result result = terrain_mesh_create(&ground, &paths, NULL, &mesh, &error);
  assert_string_equal(error.message, "");
  assert_int_equal(result, SCREE_OK);
  assert_int_equal(mesh.vertex_count, 12);
  assert_int_equal(mesh.triangle_count, 12);
  assert_true(mesh.positions[0] == -3.0f && mesh.positions[2] == -2.0f && mesh.positions[33] == 3.0f && mesh.positions[35] == 2.0f);
  for (uint32_t i = 0; i < 12; ++i) {
    const float* n = &mesh.normals[3 * i];
    float length = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    assert_true(length > 0.9999f && length < 1.0001f && n[1] > 0);
    const uint32_t* t = &mesh.indices[3 * i];
    const float *a = &mesh.positions[3 * t[0]], *b = &mesh.positions[3 * t[1]], *c = &mesh.positions[3 * t[2]];
    assert_true((b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2]) > 0);
  }
  /* Uphill is +x and +z, so normals lean back. */
  assert_true(mesh.normals[3 * 5] < 0 && mesh.normals[3 * 5 + 2] < 0);
  terrain_mesh_free(&mesh);
}

static void files_are_looked_for_beside_the_scene_then_in_the_data_folder(void** state) {
  (void)state;
  char scene_name[96], found[SCENE_FILE_SIZE * 2], expected[512];
  snprintf(scene_name, sizeof scene_name, "%s/scene.json", folder);
  write_file("beside.off", cube_off, strlen(cube_off));
  scene_paths paths = {.scene = scene_name, .packs = "p", .data = "d"};
  scree_error error = {""};
  assert_int_equal(scene_find_file(&paths, "fields[0].support", "beside.off", found, sizeof found, &error), SCREE_OK);
  snprintf(expected, sizeof expected, "%s/beside.off", folder);
  assert_string_equal(found, expected);
  paths.scene = "scene.json";
  paths.data = folder;
  assert_int_equal(scene_find_file(&paths, "fields[0].support", "beside.off", found, sizeof found, &error), SCREE_OK);
  assert_string_equal(found, expected);
  assert_int_equal(scene_find_file(&paths, "fields[0].support", "gone.off", found, sizeof found, &error), SCREE_ERROR_IO);
  snprintf(expected, sizeof expected,
           "scene.json: fields[0].support: \"gone.off\" is neither beside the scene nor in the data folder %s", folder);
  assert_string_equal(error.message, expected);
  assert_int_equal(scene_find_pack(&paths, "fields[0].pack", "boulders", found, sizeof found, &error), SCREE_ERROR_IO);
  assert_string_equal(error.message, "scene.json: fields[0].pack: there is no pack \"boulders\": p/boulders.scree does not exist");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(obj_of_every_dialect_is_read),
      cmocka_unit_test(off_of_every_dialect_is_read),
      cmocka_unit_test(wrong_text_mesh_is_refused_by_line),
      cmocka_unit_test(unknown_ending_and_missing_file_are_named),
      cmocka_unit_test(welding_joins_equal_places_only),
      cmocka_unit_test(broken_text_meshes_never_crash),
      cmocka_unit_test(glb_cube_is_read_and_welded),
      cmocka_unit_test(glb_default_scene_is_merged_with_its_transforms),
      cmocka_unit_test(wrong_glb_is_one_clear_line),
      cmocka_unit_test(deeply_nested_gltf_is_refused),
      cmocka_unit_test(gltf_with_a_buffer_beside_it_is_read),
      cmocka_unit_test(broken_glb_never_crashes),
      cmocka_unit_test(height_map_is_cropped_and_scaled),
      cmocka_unit_test(wrong_height_map_is_one_clear_line),
      cmocka_unit_test(truncated_height_map_is_refused),
      cmocka_unit_test(terrain_mesh_faces_up_and_has_unit_normals),
      cmocka_unit_test(files_are_looked_for_beside_the_scene_then_in_the_data_folder),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
