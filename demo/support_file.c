/* Mesh files: which reader, and welding. */
#include "support_file.h"

#include <stdlib.h>
#include <string.h>

#include "file.h"

#define MESH_FILE_LIMIT ((size_t)1 << 30)

void triangle_mesh_free(triangle_mesh* mesh) {
  free(mesh->positions);
  free(mesh->indices);
  free(mesh->uvs);
  *mesh = (triangle_mesh){0};
}

static bool ends_with(const char* text, const char* ending) {
  size_t length = strlen(text), tail = strlen(ending);
  if (length < tail) return false;
  for (size_t i = 0; i < tail; ++i) {
    char c = text[length - tail + i];
    if (c >= 'A' && c <= 'Z') c = (char)(c - 'A' + 'a');
    if (c != ending[i]) return false;
  }
  return true;
}

scree_result triangle_mesh_load(const char* file, triangle_mesh* out, scree_error* error) {
  static const struct {
    const char* ending;
    scree_result (*read)(const char* bytes, size_t size, const char* file, triangle_mesh* out, scree_error* error);
  } readers[] = {{".obj", mesh_read_obj}, {".off", mesh_read_off}, {".glb", mesh_read_gltf}, {".gltf", mesh_read_gltf}};
  *out = (triangle_mesh){0};
  for (size_t i = 0; i < sizeof readers / sizeof readers[0]; ++i) {
    if (!ends_with(file, readers[i].ending)) continue;
    char* bytes;
    size_t size;
    scree_result result = file_read(file, MESH_FILE_LIMIT, &bytes, &size, error);
    if (result != SCREE_OK) return result;
    result = readers[i].read(bytes, size, file, out, error);
    free(bytes);
    if (result == SCREE_OK && triangle_mesh_weld(out) != SCREE_OK)
      result = fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", file);
    if (result == SCREE_OK && out->triangle_count == 0) result = fail_with(error, SCREE_ERROR_SYNTAX, "%s: has no triangles", file);
    if (result != SCREE_OK) triangle_mesh_free(out);
    return result;
  }
  return fail_with(error, SCREE_ERROR_UNSUPPORTED, "%s: expected a file that ends in .obj, .off, .glb or .gltf", file);
}

void painted_mesh_free(painted_mesh* mesh) {
  free(mesh->positions);
  free(mesh->normals);
  free(mesh->colours);
  free(mesh->indices);
  *mesh = (painted_mesh){0};
}

scree_result painted_mesh_load(const char* file, painted_mesh* out, scree_error* error) {
  *out = (painted_mesh){0};
  if (!ends_with(file, ".glb") && !ends_with(file, ".gltf"))
    return fail_with(error, SCREE_ERROR_UNSUPPORTED, "%s: expected a file that ends in .glb or .gltf", file);
  char* bytes;
  size_t size;
  scree_result result = file_read(file, MESH_FILE_LIMIT, &bytes, &size, error);
  if (result != SCREE_OK) return result;
  result = model_read_gltf(bytes, size, file, out, error);
  free(bytes);
  return result;
}

static uint64_t position_hash(const float* p) {
  uint64_t hash = 0;
  for (int i = 0; i < 3; ++i) {
    uint32_t bits;
    memcpy(&bits, &p[i], sizeof bits);
    hash = (hash ^ bits) * UINT64_C(0x9e3779b97f4a7c15);
    hash ^= hash >> 32;
  }
  return hash;
}

scree_result triangle_mesh_weld(triangle_mesh* mesh) {
  if (mesh->vertex_count == 0) return SCREE_OK;
  size_t slots = 16;
  while (slots < (size_t)mesh->vertex_count * 2) slots *= 2;
  uint32_t* table = malloc(slots * sizeof *table);
  uint32_t* place = malloc(mesh->vertex_count * sizeof *place);
  if (table == NULL || place == NULL) {
    free(table);
    free(place);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  memset(table, 0xff, slots * sizeof *table);
  uint32_t kept = 0;
  for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
    float p[3];
    for (int k = 0; k < 3; ++k) p[k] = mesh->positions[3 * (size_t)i + k] + 0.0f; /* -0 and 0 are one place */
    size_t slot = (size_t)position_hash(p) & (slots - 1);
    while (table[slot] != UINT32_MAX && memcmp(&mesh->positions[3 * (size_t)table[slot]], p, sizeof p) != 0)
      slot = (slot + 1) & (slots - 1);
    if (table[slot] == UINT32_MAX) {
      memcpy(&mesh->positions[3 * (size_t)kept], p, sizeof p);
      table[slot] = kept++;
    }
    place[i] = table[slot];
  }
  uint32_t triangles = 0;
  for (uint32_t i = 0; i < mesh->triangle_count; ++i) {
    const uint32_t* from = &mesh->indices[3 * (size_t)i];
    uint32_t a = place[from[0]], b = place[from[1]], c = place[from[2]];
    if (a == b || b == c || c == a) continue;
    if (mesh->uvs != NULL && i != triangles)
      memcpy(&mesh->uvs[6 * (size_t)triangles], &mesh->uvs[6 * (size_t)i], 6 * sizeof *mesh->uvs);
    uint32_t* to = &mesh->indices[3 * (size_t)triangles++];
    to[0] = a, to[1] = b, to[2] = c;
  }
  mesh->vertex_count = kept;
  mesh->triangle_count = triangles;
  free(table);
  free(place);
  return SCREE_OK;
}
