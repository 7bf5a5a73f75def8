/* Meshes of cliffs as closed ones. */
#include <string.h>

#include <scree/cliff.h>

#include "allocator.h"
#include "lattice.h"

/* Vertices by their place on the lattice, in an open hash table: places hold a vertex + 1. */
typedef struct place_table {
  uint32_t* places;
  size_t size; /* a power of two, at least twice the number of vertices */
} place_table;

static uint64_t place_key(const int16_t position[3]) {
  return (uint64_t)(uint16_t)position[0] | (uint64_t)(uint16_t)position[1] << 16 | (uint64_t)(uint16_t)position[2] << 32;
}

/* The first vertex that lies where this one does. */
static uint32_t first_there(const place_table* table, const scree_vertex* vertices, uint32_t vertex) {
  const uint64_t key = place_key(vertices[vertex].position);
  size_t at = (size_t)hash_mix(key + 1) & (table->size - 1);
  while (table->places[at] != 0 && place_key(vertices[table->places[at] - 1].position) != key) at = (at + 1) & (table->size - 1);
  if (table->places[at] == 0) table->places[at] = vertex + 1;
  return table->places[at] - 1;
}

/* Whether a triangle keeps its three corners. */
static bool is_whole(const uint32_t* ids, const uint32_t* triangle) {
  const uint32_t a = ids[triangle[0]], b = ids[triangle[1]], c = ids[triangle[2]];
  return a != b && b != c && c != a;
}

/* Numbers places in `ids`, and copies what is left. */
static scree_result weld(const place_table* table, const scree_vertex* vertices, uint32_t vertex_count, const uint32_t* indices,
                         size_t triangle_count, float step, uint32_t* ids, const scree_allocator* allocator, scree_mesh* out) {
  uint32_t places = 0, whole = 0;
  for (uint32_t v = 0; v < vertex_count; ++v) {
    const uint32_t first = first_there(table, vertices, v);
    ids[v] = first == v ? places++ : ids[first];
  }
  for (size_t t = 0; t < triangle_count; ++t) whole += is_whole(ids, indices + 3 * t);
  float* positions = scree_rt_allocate(allocator, places, 3 * sizeof *positions);
  uint32_t* corners = scree_rt_allocate(allocator, whole, 3 * sizeof *corners);
  if (positions == NULL || corners == NULL) {
    scree_rt_release(allocator, positions, places, 3 * sizeof *positions);
    scree_rt_release(allocator, corners, whole, 3 * sizeof *corners);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  for (uint32_t v = 0; v < vertex_count; ++v)
    for (int a = 0; a < 3; ++a) positions[3 * (size_t)ids[v] + (size_t)a] = (float)vertices[v].position[a] * step;
  *out = (scree_mesh){.positions = positions, .indices = corners, .vertex_count = places, .triangle_count = whole};
  for (size_t t = 0; t < triangle_count; ++t)
    if (is_whole(ids, indices + 3 * t))
      for (int c = 0; c < 3; ++c) *corners++ = ids[indices[3 * t + (size_t)c]];
  return SCREE_OK;
}

scree_result scree_cliff_mesh_create(const scree_pack* pack, const scree_vertex* vertices, uint32_t vertex_count,
                                     const uint32_t* indices, uint32_t index_count, const scree_allocator* given, scree_mesh* out) {
  if (out != NULL) *out = (scree_mesh){0};
  if (pack == NULL || out == NULL || vertices == NULL || indices == NULL || vertex_count == 0 || index_count == 0 ||
      index_count % 3 != 0)
    return SCREE_ERROR_INVALID_ARGUMENT;
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  if (info.kind != SCREE_PACK_CLIFF) return SCREE_ERROR_PACK_KIND;
  for (size_t i = 0; i < index_count; ++i)
    if (indices[i] >= vertex_count) return SCREE_ERROR_RANGE;
  const scree_allocator allocator = scree_rt_allocator_or_default(given);
  place_table table = {.size = 16};
  while (table.size < 2 * (size_t)vertex_count) table.size *= 2;
  table.places = scree_rt_allocate_zeroed(&allocator, table.size, sizeof *table.places);
  uint32_t* ids = scree_rt_allocate(&allocator, vertex_count, sizeof *ids);
  scree_result result = SCREE_ERROR_OUT_OF_MEMORY;
  if (table.places != NULL && ids != NULL)
    result = weld(&table, vertices, vertex_count, indices, index_count / 3, 1 / (float)info.lattice_per_cell, ids, &allocator, out);
  scree_rt_release(&allocator, table.places, table.size, sizeof *table.places);
  scree_rt_release(&allocator, ids, vertex_count, sizeof *ids);
  return result;
}

void scree_cliff_mesh_free(const scree_allocator* given, scree_mesh* mesh) {
  const scree_allocator allocator = scree_rt_allocator_or_default(given);
  void *positions, *indices; /* its own, which others may only read */
  memcpy(&positions, &mesh->positions, sizeof positions);
  memcpy(&indices, &mesh->indices, sizeof indices);
  scree_rt_release(&allocator, positions, mesh->vertex_count, 3 * sizeof *mesh->positions);
  scree_rt_release(&allocator, indices, mesh->triangle_count, 3 * sizeof *mesh->indices);
  *mesh = (scree_mesh){0};
}
