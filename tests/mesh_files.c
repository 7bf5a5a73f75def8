#define _POSIX_C_SOURCE 200809L

#include "mesh_files.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* after those above */
#include <cmocka.h>

#include "lattice.h"

char folder[64];

const char* write_file(const char* name, const void* bytes, size_t size) {
  static char path[128];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  FILE* stream = fopen(path, "wb");
  assert_non_null(stream);
  assert_int_equal(fwrite(bytes, 1, size, stream), size);
  assert_int_equal(fclose(stream), 0);
  return path;
}

int make_folder(void** state) {
  (void)state;
  snprintf(folder, sizeof folder, "support_file_XXXXXX");
  return mkdtemp(folder) != NULL ? 0 : 1;
}

int remove_folder(void** state) {
  (void)state;
  char command[96];
  snprintf(command, sizeof command, "rm -r '%s'", folder);
  return system(command);
}

double signed_volume(const triangle_mesh* mesh) {
  double six = 0;
  for (uint32_t i = 0; i < mesh->triangle_count; ++i) {
    const uint32_t* t = &mesh->indices[3 * i];
    const float *a = &mesh->positions[3 * t[0]], *b = &mesh->positions[3 * t[1]], *c = &mesh->positions[3 * t[2]];
    six += (double)a[0] * ((double)b[1] * c[2] - (double)b[2] * c[1]) + (double)a[1] * ((double)b[2] * c[0] - (double)b[0] * c[2]) +
           (double)a[2] * ((double)b[0] * c[1] - (double)b[1] * c[0]);
  }
  return six / 6;
}

bool is_closed(const triangle_mesh* mesh) {
  for (uint32_t i = 0; i < mesh->triangle_count * 3; ++i) {
    uint32_t a = mesh->indices[i], b = mesh->indices[i / 3 * 3 + (i + 1) % 3], same = 0, back = 0;
    for (uint32_t k = 0; k < mesh->triangle_count * 3; ++k) {
      uint32_t c = mesh->indices[k], d = mesh->indices[k / 3 * 3 + (k + 1) % 3];
      same += a == c && b == d;
      back += a == d && b == c;
    }
    if (same != 1 || back != 1) return false;
  }
  return true;
}

void assert_unit_cube(const triangle_mesh* mesh) {
  assert_int_equal(mesh->vertex_count, 8);
  assert_int_equal(mesh->triangle_count, 12);
  assert_true(is_closed(mesh));
  double volume = signed_volume(mesh);
  assert_true(volume > 0.999999 && volume < 1.000001);
}

scree_result load_text(const char* name, const char* text, triangle_mesh* mesh, scree_error* error) {
  return triangle_mesh_load(write_file(name, text, strlen(text)), mesh, error);
}

void mutate(const char* good, size_t size, uint64_t seed, int rounds,
            scree_result (*read)(const char*, size_t, const char*, triangle_mesh*, scree_error*)) {
  for (size_t round = 0; round < size + (size_t)rounds; ++round) {
    size_t length = round < size ? round : size;
    char* bytes = malloc(length + 1);
    memcpy(bytes, good, length);
    bytes[length] = '\0';
    for (int i = 0; round >= size && i < 2; ++i) {
      seed = hash_mix(seed + UINT64_C(0x9e3779b97f4a7c15));
      bytes[seed % length] = (char)(seed >> 40);
    }
    triangle_mesh mesh;
    scree_error error = {""};
    if (read(bytes, length, "m", &mesh, &error) == SCREE_OK) {
      for (uint32_t i = 0; i < mesh.triangle_count * 3; ++i) assert_true(mesh.indices[i] < mesh.vertex_count);
      for (uint32_t i = 0; mesh.uvs != NULL && i < mesh.triangle_count * 6; ++i) assert_true(isfinite(mesh.uvs[i]));
      assert_int_equal(triangle_mesh_weld(&mesh), SCREE_OK);
      triangle_mesh_free(&mesh);
    } else {
      assert_true(error.message[0] != '\0' && strchr(error.message, '\n') == NULL);
      assert_true(mesh.positions == NULL && mesh.uvs == NULL);
    }
    free(bytes);
  }
}

static void put_word(char* to, uint32_t word) {
  for (int i = 0; i < 4; ++i) to[i] = (char)(word >> (8 * i) & 255);
}

void make_glb(const char* json, const void* bin, size_t bin_size, glb_file* out) {
  size_t text = (strlen(json) + 3) & ~(size_t)3;
  out->size = 12 + 8 + text + 8 + bin_size;
  assert_true(out->size <= sizeof out->bytes);
  memcpy(out->bytes, "glTF", 4);
  put_word(out->bytes + 4, 2);
  put_word(out->bytes + 8, (uint32_t)out->size);
  put_word(out->bytes + 12, (uint32_t)text);
  memcpy(out->bytes + 16, "JSON", 4);
  memset(out->bytes + 20, ' ', text);
  memcpy(out->bytes + 20, json, strlen(json));
  put_word(out->bytes + 20 + text, (uint32_t)bin_size);
  memcpy(out->bytes + 24 + text, "BIN\0", 4);
  memcpy(out->bytes + 28 + text, bin, bin_size);
}

void cube_bin(char bin[360]) {
  static const float corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  static const int quads[6][4] = {{3, 2, 1, 0}, {4, 5, 6, 7}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 4, 7, 3}, {1, 2, 6, 5}};
  static const uint16_t fan[6] = {0, 1, 2, 0, 2, 3};
  for (int q = 0; q < 6; ++q) {
    for (int k = 0; k < 4; ++k) memcpy(bin + (q * 4 + k) * 12, corner[quads[q][k]], 12);
    for (int k = 0; k < 6; ++k) {
      uint16_t index = (uint16_t)(q * 4 + fan[k]);
      memcpy(bin + 288 + (q * 6 + k) * 2, &index, 2);
    }
  }
}
