#include "plain_mesh.h"

#include <string.h>

#include "mesh_normals.h"
#include "surface_bytes.h"

/* Element `index` of an array of numbers of 1 or 2 bytes, which may lie anywhere. */
static uint32_t number_at(const uint8_t* numbers, uint32_t size, size_t index) {
  if (size == 1) return numbers[index];
  uint16_t wide;
  memcpy(&wide, numbers + index * sizeof wide, sizeof wide);
  return wide;
}

bool scree_rt_plain_mesh_read(const uint8_t* blob, size_t blob_size, uint32_t vertex_count, uint32_t triangle_count,
                              scree_pack_kind kind, plain_mesh* out) {
  if (blob_size < PLAIN_MESH_HEAD || vertex_count > PLAIN_MESH_MAX_VERTICES) return false;
  memcpy(out->base, blob, sizeof out->base);
  out->position_size = blob[6];
  out->index_size = blob[7];
  if (out->position_size < 1 || out->position_size > 2 || out->index_size < 1 || out->index_size > 2) return false;
  out->vertex_count = vertex_count;
  out->triangle_count = triangle_count;
  const uint64_t position_bytes = (uint64_t)vertex_count * 3 * out->position_size;
  const uint64_t index_bytes = (uint64_t)triangle_count * 3 * out->index_size;
  const bool model = kind != SCREE_PACK_TILES, cliff = kind == SCREE_PACK_CLIFF;
  const uint64_t surface_bytes = model ? (uint64_t)vertex_count * sizeof *out->surface : 0;
  const uint64_t uv_bytes = cliff ? (uint64_t)vertex_count * sizeof(scree_uv) : 0;
  if (blob_size != PLAIN_MESH_HEAD + position_bytes + vertex_count + surface_bytes + uv_bytes + index_bytes) return false;
  out->positions = blob + PLAIN_MESH_HEAD;
  out->occlusion = out->positions + position_bytes;
  out->surface = model ? (const uint8_t(*)[4])(out->occlusion + vertex_count) : NULL;
  out->uvs = cliff ? out->occlusion + vertex_count + surface_bytes : NULL;
  out->indices = out->occlusion + vertex_count + surface_bytes + uv_bytes;

  for (size_t i = 0; i < (size_t)vertex_count * 3; ++i)
    if (out->base[i % 3] + (int32_t)number_at(out->positions, out->position_size, i) > INT16_MAX) return false;
  for (size_t i = 0; i < vertex_count && model; ++i)
    if (!scree_rt_surface_is_sound(out->surface[i], cliff)) return false;
  for (size_t i = 0; i < (size_t)triangle_count * 3; ++i)
    if (number_at(out->indices, out->index_size, i) >= vertex_count) return false;
  return true;
}

int32_t scree_rt_plain_mesh_coordinate(const plain_mesh* mesh, uint32_t vertex, uint32_t axis) {
  return mesh->base[axis] + (int32_t)number_at(mesh->positions, mesh->position_size, (size_t)vertex * 3 + axis);
}

/* Vertices whose normals are summed at once, on the stack: the runtime's smallest meshes need one pass, and none needs memory. */
#define BATCH 128

/* Which rows of the sums vertices add to: of rocks and models each vertex of a batch has its own; of cliffs, those of the whole
 * mesh that share a normal with one of the batch add to the row of the first of these. */
typedef struct normal_rows {
  uint32_t first, count;    /* vertices of the batch */
  uint64_t keys[BATCH];     /* of cliffs, by row */
  uint8_t slots[2 * BATCH]; /* row + 1, 0 = free */
} normal_rows;

/* The row of a key, or the slot where it belongs, from BATCH on. */
static uint32_t find_row(const normal_rows* rows, uint64_t key) {
  uint32_t slot = (uint32_t)(scree_rt_normal_hash(key) >> 56);
  for (; rows->slots[slot] != 0; slot = (slot + 1) % (2 * BATCH))
    if (rows->keys[rows->slots[slot] - 1] == key) return rows->slots[slot] - 1u;
  return BATCH + slot;
}

static uint64_t key_of(const plain_mesh* mesh, const scree_vertex* vertices, uint32_t v) {
  return scree_rt_normal_key(vertices[v].position, mesh->surface[v][3]);
}

/* The row of a vertex, BATCH or more if it has none. */
static uint32_t row_of(const plain_mesh* mesh, const scree_vertex* vertices, const normal_rows* rows, uint32_t v) {
  if (mesh->uvs != NULL) return find_row(rows, key_of(mesh, vertices, v));
  return v - rows->first < rows->count ? v - rows->first : BATCH;
}

static void start_rows(const plain_mesh* mesh, const scree_vertex* vertices, uint32_t first, normal_rows* rows) {
  rows->first = first;
  rows->count = mesh->vertex_count - first < BATCH ? mesh->vertex_count - first : BATCH;
  if (mesh->uvs == NULL) return;
  memset(rows->slots, 0, sizeof rows->slots);
  for (uint32_t i = 0; i < rows->count; ++i) {
    const uint64_t key = key_of(mesh, vertices, first + i);
    const uint32_t found = find_row(rows, key);
    if (found < BATCH) continue;
    rows->keys[i] = key;
    rows->slots[found - BATCH] = (uint8_t)(i + 1);
  }
}

static void add_normals(const plain_mesh* mesh, const scree_vertex* vertices, const normal_rows* rows, int64_t (*sums)[3]) {
  for (size_t t = 0; t < (size_t)mesh->triangle_count * 3; t += 3) {
    uint32_t corner[3], row[3];
    bool near = false;
    for (size_t k = 0; k < 3; ++k) {
      corner[k] = number_at(mesh->indices, mesh->index_size, t + k);
      row[k] = row_of(mesh, vertices, rows, corner[k]);
      near |= row[k] < BATCH;
    }
    if (!near) continue;
    const int16_t *a = vertices[corner[0]].position, *b = vertices[corner[1]].position, *c = vertices[corner[2]].position;
    const int64_t u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    const int64_t n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    for (int k = 0; k < 3; ++k)
      if (row[k] < BATCH)
        for (int axis = 0; axis < 3; ++axis) sums[row[k]][axis] += n[axis];
  }
}

void scree_rt_plain_mesh_decode(const plain_mesh* mesh, scree_vertex* vertices, void* indices, uint32_t index_size) {
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    scree_vertex vertex = {.occlusion = mesh->occlusion[v]};
    for (uint32_t axis = 0; axis < 3; ++axis) vertex.position[axis] = (int16_t)scree_rt_plain_mesh_coordinate(mesh, v, axis);
    if (mesh->surface != NULL) scree_rt_surface_decode(mesh->surface[v], &vertex);
    vertices[v] = vertex;
  }
  for (uint32_t first = 0; first < mesh->vertex_count; first += BATCH) {
    int64_t sums[BATCH][3] = {{0}};
    normal_rows rows;
    start_rows(mesh, vertices, first, &rows);
    add_normals(mesh, vertices, &rows, sums);
    for (uint32_t v = first; v < first + rows.count; ++v)
      scree_rt_mesh_normal(sums[row_of(mesh, vertices, &rows, v)], vertices[v].normal);
  }
  for (size_t i = 0; i < (size_t)mesh->triangle_count * 3; ++i) {
    const uint32_t index = number_at(mesh->indices, mesh->index_size, i);
    if (index_size == sizeof(uint32_t))
      ((uint32_t*)indices)[i] = index;
    else
      ((uint16_t*)indices)[i] = (uint16_t)index;
  }
}
