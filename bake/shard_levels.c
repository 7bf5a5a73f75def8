#include "shard_levels.h"

#include <stdlib.h>
#include <string.h>

#include "allocator.h"
#include "creases.h"
#include "lattice.h"
#include "shards_internal.h"

#define ROCK_DURABILITY 64 /* the byte that stands for 1 */

enum {
  ROCK_CURVATURE = 128, /* none */
  EDGE_CURVATURE = 176, /* where cuts meet others or the solid's surface, outwards */
  NOOK_CURVATURE = 96   /* and inwards */
};

static int compare_words(const void* a, const void* b) {
  const uint64_t x = *(const uint64_t*)a, y = *(const uint64_t*)b;
  return (x > y) - (x < y);
}

/* --- Setting up. --- */

/* Half to one and a half of the rock's, by shard, so that neighbours differ at all times alike. */
static uint8_t durability_of(uint32_t shard) {
  return (uint8_t)(ROCK_DURABILITY / 2 + 4 * (hash_combine(0, shard) >> 32 & 15));
}

/* Groups: charts of the solid that smooth edges join; behind them each link's cut. */
static scree_result set_triangles(shard_levels* l, const shard_asset_desc* desc, const surface_vertices* surface) {
  const scree_solid* solid = desc->shards->view.solid;
  const shard_surface* source = &surface->source;
  uint32_t* charts = scree_rt_allocate(&l->allocator, solid->triangle_count, sizeof *charts);
  scree_result result = charts != NULL ? crease_charts(solid, &l->allocator, charts) : SCREE_ERROR_OUT_OF_MEMORY;
  for (uint32_t t = 0; result == SCREE_OK && t < source->count; ++t) {
    const shard_triangle* triangle = &source->triangles[t];
    const bool cut = t >= source->solid_count;
    memcpy(l->mesh.corners[t], triangle->corner, sizeof triangle->corner);
    l->groups[t] = cut ? solid->triangle_count + triangle->source : charts[triangle->source];
    l->materials[t] =
        (uint8_t)((cut ? SURFACE_CUT : SURFACE_SOLID) | (desc->joints ? durability_of(triangle->shard) : ROCK_DURABILITY));
    for (uint32_t k = 0; k < 3; ++k)
      memcpy(l->mesh.uvs[t][k], surface->surface.vertices[surface->surface.indices[(size_t)3 * t + k]].uv,
             sizeof l->mesh.uvs[t][k]);
  }
  scree_rt_release(&l->allocator, charts, solid->triangle_count, sizeof *charts);
  return result;
}

static void set_openness(shard_levels* l, const surface_vertices* surface) {
  const uint32_t corners = 3 * l->mesh.triangle_count;
  for (uint32_t c = 0; c < corners; ++c) {
    const uint64_t vertex = l->mesh.corners[c / 3][c % 3], group = l->groups[c / 3];
    l->openness[c] = vertex << 40 | group << 8 | surface->surface.vertices[surface->surface.indices[c]].occlusion;
  }
  qsort(l->openness, corners, sizeof *l->openness, compare_words);
}

/* The first that is not less; of a vertex and a group, or where the group has come from elsewhere, of the vertex. */
static uint8_t openness_at(const shard_levels* l, uint32_t vertex, uint32_t group) {
  const uint64_t key = (uint64_t)vertex << 40 | (uint64_t)group << 8;
  const uint32_t corners = 3 * l->mesh.triangle_count;
  uint32_t low = 0, high = corners;
  while (low < high) {
    const uint32_t middle = low + (high - low) / 2;
    if (l->openness[middle] < key)
      low = middle + 1;
    else
      high = middle;
  }
  if (low == corners || l->openness[low] >> 40 != vertex) low = low > 0 ? low - 1 : 0;
  return (uint8_t)(l->openness[low] & 255);
}

/* places: sorted with the number of the vertex below them. */
static scree_result set_ranks(shard_levels* l) {
  const uint32_t count = l->mesh.vertex_count;
  struct place {
    uint64_t at;
    uint64_t vertex;
  }* sorted = scree_rt_allocate(&l->allocator, count, sizeof *sorted);
  if (sorted == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  for (uint32_t v = 0; v < count; ++v) {
    const int16_t* p = l->mesh.positions[v];
    sorted[v].at = (uint64_t)(uint16_t)p[0] << 32 | (uint64_t)(uint16_t)p[1] << 16 | (uint16_t)p[2];
    sorted[v].vertex = v;
  }
  qsort(sorted, count, sizeof *sorted, compare_words);
  l->rank_count = 0;
  for (uint32_t i = 0; i < count; ++i) {
    if (i > 0 && sorted[i].at != sorted[i - 1].at) ++l->rank_count;
    l->rank[sorted[i].vertex] = l->rank_count;
  }
  ++l->rank_count;
  scree_rt_release(&l->allocator, sorted, count, sizeof *sorted);
  return SCREE_OK;
}

static scree_result set_vertices(shard_levels* l, const scree_shards_view* view, const int16_t (*places)[3]) {
  const uint32_t corners = 3 * l->mesh.triangle_count;
  uint32_t* vertex_of = scree_rt_allocate(&l->allocator, corners, sizeof *vertex_of);
  if (vertex_of == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  scree_result result =
      mesh_split_fans(view->vertices, l->mesh.corners, l->mesh.triangle_count, &l->allocator, vertex_of, &l->mesh.vertex_count);
  if (result == SCREE_OK) {
    l->mesh.positions = scree_rt_allocate(&l->allocator, l->mesh.vertex_count, sizeof *l->mesh.positions);
    l->rank = scree_rt_allocate(&l->allocator, l->mesh.vertex_count, sizeof *l->rank);
    result = l->mesh.positions != NULL && l->rank != NULL ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
  }
  for (uint32_t v = 0; result == SCREE_OK && v < l->mesh.vertex_count; ++v)
    memcpy(l->mesh.positions[v], places[vertex_of[v]], sizeof *l->mesh.positions);
  scree_rt_release(&l->allocator, vertex_of, corners, sizeof *vertex_of);
  return result == SCREE_OK ? set_ranks(l) : result;
}

static bool arrays_create(shard_levels* l) {
  const uint32_t triangles = l->mesh.triangle_count;
  l->mesh.corners = scree_rt_allocate(&l->allocator, triangles, sizeof *l->mesh.corners);
  l->mesh.uvs = scree_rt_allocate(&l->allocator, triangles, sizeof *l->mesh.uvs);
  l->mesh.groups = l->groups = scree_rt_allocate(&l->allocator, triangles, sizeof *l->groups);
  l->mesh.materials = l->materials = scree_rt_allocate(&l->allocator, triangles, 1);
  l->openness = scree_rt_allocate(&l->allocator, (size_t)3 * triangles, sizeof *l->openness);
  return l->mesh.corners != NULL && l->mesh.uvs != NULL && l->groups != NULL && l->materials != NULL && l->openness != NULL;
}

scree_result shard_levels_create(const shard_asset_desc* desc, const surface_vertices* surface, const int16_t (*places)[3],
                                 const scree_allocator* allocator, shard_levels* out) {
  memset(out, 0, sizeof *out);
  out->allocator = *allocator;
  out->mesh.triangle_count = surface->source.count;
  scree_result result = arrays_create(out) ? set_triangles(out, desc, surface) : SCREE_ERROR_OUT_OF_MEMORY;
  if (result == SCREE_OK) result = set_vertices(out, &desc->shards->view, places);
  if (result == SCREE_OK) {
    set_openness(out, surface);
    result = mesh_simplifier_create(&out->mesh, &out->allocator, &out->simplifier);
  }
  if (result != SCREE_OK) shard_levels_destroy(out);
  return result;
}

void shard_levels_destroy(shard_levels* l) {
  if (l->allocator.release == NULL) return;
  const uint32_t triangles = l->mesh.triangle_count;
  mesh_simplifier_destroy(l->simplifier);
  scree_rt_release(&l->allocator, l->mesh.positions, l->mesh.vertex_count, sizeof *l->mesh.positions);
  scree_rt_release(&l->allocator, l->rank, l->mesh.vertex_count, sizeof *l->rank);
  scree_rt_release(&l->allocator, l->mesh.corners, triangles, sizeof *l->mesh.corners);
  scree_rt_release(&l->allocator, l->mesh.uvs, triangles, sizeof *l->mesh.uvs);
  scree_rt_release(&l->allocator, l->groups, triangles, sizeof *l->groups);
  scree_rt_release(&l->allocator, l->materials, triangles, 1);
  scree_rt_release(&l->allocator, l->openness, (size_t)3 * triangles, sizeof *l->openness);
  memset(l, 0, sizeof *l);
}

/* --- What is left, as a mesh. --- */

typedef struct take_work {
  const shard_levels* levels;
  uint64_t* pairs;  /* group << 32 | rank, each once, sorted */
  uint8_t* colour;  /* of each pair */
  uint64_t* taken;  /* of each rank: colours */
  uint8_t* kinds;   /* of each rank: 1 = a cut is there, 2 = more than one group */
  uint32_t* only;   /* of each rank: the first group */
  float (*bend)[6]; /* of each rank: sums of area vectors, and of the ways to its neighbours */
  uint32_t* table;  /* vertices by hash */
  uint32_t* triangles;
  uint32_t pair_count, table_size, triangle_count;
} take_work;

static bool is_left(const shard_levels* l, uint32_t triangle) {
  const uint32_t* c = l->mesh.corners[triangle];
  if (c[0] == SIMPLIFY_GONE) return false;
  return l->rank[c[0]] != l->rank[c[1]] && l->rank[c[1]] != l->rank[c[2]] && l->rank[c[2]] != l->rank[c[0]];
}

static void look_at_corners(take_work* w) {
  const shard_levels* l = w->levels;
  for (uint32_t r = 0; r < l->rank_count; ++r) w->only[r] = UINT32_MAX;
  for (uint32_t t = 0; t < l->mesh.triangle_count; ++t) {
    if (!is_left(l, t)) continue;
    w->triangles[w->triangle_count++] = t;
    const int16_t* p[3];
    float area[3];
    for (uint32_t k = 0; k < 3; ++k) p[k] = l->mesh.positions[l->mesh.corners[t][k]];
    for (uint32_t a = 0; a < 3; ++a) {
      const uint32_t x = (a + 1) % 3, y = (a + 2) % 3;
      area[a] = (float)(p[1][x] - p[0][x]) * (float)(p[2][y] - p[0][y]) - (float)(p[1][y] - p[0][y]) * (float)(p[2][x] - p[0][x]);
    }
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t rank = l->rank[l->mesh.corners[t][k]];
      w->pairs[w->pair_count++] = (uint64_t)l->groups[t] << 32 | rank;
      if ((l->materials[t] & SIMPLIFY_MATERIAL) == SURFACE_CUT) w->kinds[rank] |= 1;
      if (w->only[rank] == UINT32_MAX) w->only[rank] = l->groups[t];
      if (w->only[rank] != l->groups[t]) w->kinds[rank] |= 2;
      for (uint32_t a = 0; a < 3; ++a) {
        w->bend[rank][a] += area[a];
        w->bend[rank][3 + a] += (float)(p[(k + 1) % 3][a] - p[k][a]) + (float)(p[(k + 2) % 3][a] - p[k][a]);
      }
    }
  }
  qsort(w->pairs, w->pair_count, sizeof *w->pairs, compare_words);
  uint32_t kept = 0;
  for (uint32_t i = 0; i < w->pair_count; ++i)
    if (kept == 0 || w->pairs[i] != w->pairs[kept - 1]) w->pairs[kept++] = w->pairs[i];
  w->pair_count = kept;
}

/* Each group has the lowest colour that none has that it meets at a place. */
static void colour_groups(take_work* w) {
  for (uint32_t first = 0; first < w->pair_count;) {
    uint64_t taken = 0;
    uint32_t end = first, colour = 0;
    for (; end < w->pair_count && w->pairs[end] >> 32 == w->pairs[first] >> 32; ++end) taken |= w->taken[(uint32_t)w->pairs[end]];
    while (colour < 63 && (taken >> colour & 1) != 0) ++colour;
    for (; first < end; ++first) {
      w->colour[first] = (uint8_t)colour;
      w->taken[(uint32_t)w->pairs[first]] |= UINT64_C(1) << colour;
    }
  }
}

static uint8_t colour_of(const take_work* w, uint32_t group, uint32_t rank) {
  const uint64_t key = (uint64_t)group << 32 | rank;
  uint32_t low = 0, high = w->pair_count;
  while (low < high) {
    const uint32_t middle = low + (high - low) / 2;
    if (w->pairs[middle] < key)
      low = middle + 1;
    else
      high = middle;
  }
  return w->colour[low];
}

static uint8_t curvature_at(const take_work* w, uint32_t rank) {
  if (w->kinds[rank] != 3) return ROCK_CURVATURE;
  const float* b = w->bend[rank];
  const float along = b[0] * b[3] + b[1] * b[4] + b[2] * b[5];
  return along < 0 ? EDGE_CURVATURE : along > 0 ? NOOK_CURVATURE : ROCK_CURVATURE;
}

static uint32_t find_vertex(take_work* w, uint32_t triangle, uint32_t k, lattice_mesh* out) {
  const shard_levels* l = w->levels;
  const uint32_t v = l->mesh.corners[triangle][k], rank = l->rank[v], group = l->groups[triangle];
  const uint8_t surface[4] = {l->materials[triangle] & SIMPLIFY_MATERIAL, l->materials[triangle] & ~SIMPLIFY_MATERIAL,
                              curvature_at(w, rank), colour_of(w, group, rank)};
  const float* uv = l->mesh.uvs[triangle][k];
  uint32_t bits[2];
  memcpy(bits, uv, sizeof bits);
  const uint64_t hash = hash_combine(hash_combine(rank, (uint64_t)surface[1] << 8 | surface[3]), (uint64_t)bits[0] << 32 | bits[1]);
  uint32_t slot = (uint32_t)hash & (w->table_size - 1);
  for (; w->table[slot] != UINT32_MAX; slot = (slot + 1) & (w->table_size - 1)) {
    const uint32_t known = w->table[slot];
    if (memcmp(out->positions[known], l->mesh.positions[v], sizeof *out->positions) == 0 &&
        memcmp(out->uvs[known], uv, sizeof *out->uvs) == 0 && out->surface[known][0] == surface[0] &&
        out->surface[known][1] == surface[1] && out->surface[known][3] == surface[3])
      return known;
  }
  const uint32_t made = out->vertex_count++;
  w->table[slot] = made;
  memcpy(out->positions[made], l->mesh.positions[v], sizeof *out->positions);
  memcpy(out->uvs[made], uv, sizeof *out->uvs);
  memcpy(out->surface[made], surface, sizeof surface);
  out->occlusion[made] = openness_at(l, v, group);
  return made;
}

static bool mesh_create(uint32_t vertices, uint32_t triangles, const scree_allocator* allocator, lattice_mesh* out) {
  out->vertex_count = vertices;
  out->triangle_count = triangles;
  out->positions = scree_rt_allocate(allocator, vertices, sizeof *out->positions);
  out->occlusion = scree_rt_allocate(allocator, vertices, 1);
  out->surface = scree_rt_allocate(allocator, vertices, sizeof *out->surface);
  out->uvs = scree_rt_allocate(allocator, vertices, sizeof *out->uvs);
  out->indices = scree_rt_allocate(allocator, (size_t)3 * triangles, sizeof *out->indices);
  return out->positions != NULL && out->occlusion != NULL && out->surface != NULL && out->uvs != NULL && out->indices != NULL;
}

void shard_level_release(lattice_mesh* mesh, const scree_allocator* allocator) {
  scree_rt_release(allocator, mesh->positions, mesh->vertex_count, sizeof *mesh->positions);
  scree_rt_release(allocator, mesh->occlusion, mesh->vertex_count, 1);
  scree_rt_release(allocator, mesh->surface, mesh->vertex_count, sizeof *mesh->surface);
  scree_rt_release(allocator, mesh->uvs, mesh->vertex_count, sizeof *mesh->uvs);
  scree_rt_release(allocator, mesh->indices, (size_t)3 * mesh->triangle_count, sizeof *mesh->indices);
  memset(mesh, 0, sizeof *mesh);
}

scree_result shard_level_copy(const lattice_mesh* from, const scree_allocator* allocator, lattice_mesh* out) {
  memset(out, 0, sizeof *out);
  if (!mesh_create(from->vertex_count, from->triangle_count, allocator, out)) {
    shard_level_release(out, allocator);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  memcpy(out->positions, from->positions, from->vertex_count * sizeof *out->positions);
  memcpy(out->occlusion, from->occlusion, from->vertex_count);
  memcpy(out->surface, from->surface, from->vertex_count * sizeof *out->surface);
  memcpy(out->uvs, from->uvs, from->vertex_count * sizeof *out->uvs);
  memcpy(out->indices, from->indices, (size_t)3 * from->triangle_count * sizeof *out->indices);
  out->error = from->error;
  return SCREE_OK;
}

static bool work_create(take_work* w, uint32_t corners) {
  const shard_levels* l = w->levels;
  const scree_allocator* a = &l->allocator;
  for (w->table_size = 64; w->table_size < 2 * corners;) w->table_size *= 2;
  w->pairs = scree_rt_allocate(a, corners, sizeof *w->pairs);
  w->colour = scree_rt_allocate(a, corners, 1);
  w->taken = scree_rt_allocate_zeroed(a, l->rank_count, sizeof *w->taken);
  w->kinds = scree_rt_allocate_zeroed(a, l->rank_count, 1);
  w->only = scree_rt_allocate(a, l->rank_count, sizeof *w->only);
  w->bend = scree_rt_allocate_zeroed(a, l->rank_count, sizeof *w->bend);
  w->table = scree_rt_allocate(a, w->table_size, sizeof *w->table);
  w->triangles = scree_rt_allocate(a, l->mesh.triangle_count, sizeof *w->triangles);
  return w->pairs != NULL && w->colour != NULL && w->taken != NULL && w->kinds != NULL && w->only != NULL && w->bend != NULL &&
         w->table != NULL && w->triangles != NULL;
}

static void work_destroy(take_work* w, uint32_t corners) {
  const shard_levels* l = w->levels;
  const scree_allocator* a = &l->allocator;
  scree_rt_release(a, w->pairs, corners, sizeof *w->pairs);
  scree_rt_release(a, w->colour, corners, 1);
  scree_rt_release(a, w->taken, l->rank_count, sizeof *w->taken);
  scree_rt_release(a, w->kinds, l->rank_count, 1);
  scree_rt_release(a, w->only, l->rank_count, sizeof *w->only);
  scree_rt_release(a, w->bend, l->rank_count, sizeof *w->bend);
  scree_rt_release(a, w->table, w->table_size, sizeof *w->table);
  scree_rt_release(a, w->triangles, l->mesh.triangle_count, sizeof *w->triangles);
}

scree_result shard_levels_take(const shard_levels* levels, lattice_mesh* out) {
  memset(out, 0, sizeof *out);
  const uint32_t corners = 3 * levels->mesh.triangle_count;
  take_work w = {.levels = levels};
  lattice_mesh large = {0}; /* as many vertices as there are corners */
  scree_result result = work_create(&w, corners) ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
  uint32_t room = 0;
  if (result == SCREE_OK) {
    look_at_corners(&w);
    colour_groups(&w);
    memset(w.table, 255, w.table_size * sizeof *w.table);
    room = 3 * w.triangle_count;
    result = mesh_create(room, w.triangle_count, &levels->allocator, &large) ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
  }
  if (result == SCREE_OK) {
    large.vertex_count = 0;
    for (uint32_t t = 0; t < w.triangle_count; ++t)
      for (uint32_t k = 0; k < 3; ++k) large.indices[(size_t)3 * t + k] = find_vertex(&w, w.triangles[t], k, &large);
    result = shard_level_copy(&large, &levels->allocator, out);
  }
  large.vertex_count = room;
  shard_level_release(&large, &levels->allocator);
  work_destroy(&w, corners);
  return result;
}
