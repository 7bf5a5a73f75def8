/* Closed triangle meshes: is one closed, and a terrain made into one. */
#include <math.h>
#include <string.h>

#include "edge_table.h"
#include "recipe_text.h"
#include "solid_crossings.h"
#include "solid_internal.h"
#include "vectors.h"

enum { TERRAIN_TILE = 16 }; /* samples a side of one fan of a terrain's base */

scree_result solid_check_numbers(const scree_solid* solid, scree_error* error) {
  if (solid == NULL || solid->positions == NULL || solid->indices == NULL || solid->vertex_count == 0 ||
      solid->triangle_count == 0) {
    recipe_say(error, "solid: no triangles");
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  for (size_t i = 0; i < (size_t)3 * solid->vertex_count; ++i)
    if (!(fabs(solid->positions[i]) <= SOLID_LIMIT)) {
      recipe_say(error, "solid: vertex %zu has a coordinate that is not a number from -1e6 to 1e6: %g", i / 3, solid->positions[i]);
      return SCREE_ERROR_RANGE;
    }
  for (size_t i = 0; i < (size_t)3 * solid->triangle_count; ++i)
    if (solid->indices[i] >= solid->vertex_count) {
      recipe_say(error, "solid: triangle %zu uses vertex %u of %u", i / 3, solid->indices[i], solid->vertex_count);
      return SCREE_ERROR_INVALID_ARGUMENT;
    }
  if (solid->uvs != NULL)
    for (size_t i = 0; i < (size_t)6 * solid->triangle_count; ++i)
      if (!isfinite(solid->uvs[i])) {
        recipe_say(error, "solid: triangle %zu has a u or v that is not a finite number", i / 6);
        return SCREE_ERROR_RANGE;
      }
  return SCREE_OK;
}

void solid_bounds(const scree_solid* solid, double min[3], double max[3]) {
  points_bounds(solid->positions, solid->vertex_count, min, max);
}

double solid_volume6(const scree_solid* solid) {
  double min[3], max[3], sum = 0;
  solid_bounds(solid, min, max);
  for (size_t t = 0; t < solid->triangle_count; ++t) {
    double p[3][3];
    for (int k = 0; k < 3; ++k)
      for (int a = 0; a < 3; ++a)
        p[k][a] = solid->positions[3 * (size_t)solid->indices[3 * t + (size_t)k] + (size_t)a] - (min[a] + max[a]) / 2;
    sum += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) + p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
           p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
  }
  return sum;
}

/* --- edges ------------------------------------------------------------------------------------------------------------------ */

static scree_result refuse_edge(const scree_solid* solid, uint32_t from, uint32_t to, size_t triangle, const char* why,
                                scree_error* error) {
  const double *p = solid->positions + (size_t)3 * from, *q = solid->positions + (size_t)3 * to;
  recipe_say(error,
             "solid is not closed: the edge of triangle %zu from vertex %u at (%g, %g, %g) to vertex %u at (%g, %g, %g) %s; "
             "weld equal positions, or mesh it anew",
             triangle, from, p[0], p[1], p[2], to, q[0], q[1], q[2], why);
  return SCREE_ERROR_NOT_CLOSED;
}

static scree_result check_edges(const scree_solid* solid, const edge_table* table, scree_error* error) {
  for (size_t t = 0; t < solid->triangle_count; ++t) {
    const uint32_t* v = solid->indices + 3 * t;
    for (int k = 0; k < 3; ++k) {
      const uint32_t from = v[k], to = v[(k + 1) % 3];
      if (from == to) {
        const double* p = solid->positions + (size_t)3 * from;
        recipe_say(error, "solid: triangle %zu uses vertex %u at (%g, %g, %g) twice", t, from, p[0], p[1], p[2]);
        return SCREE_ERROR_INVALID_ARGUMENT;
      }
      uint64_t* place = edge_place(table, edge_key(from, to));
      if (*place != 0) return refuse_edge(solid, from, to, t, "is used by another triangle in the same direction", error);
      *place = edge_key(from, to);
    }
  }
  for (size_t t = 0; t < solid->triangle_count; ++t) {
    const uint32_t* v = solid->indices + 3 * t;
    for (int k = 0; k < 3; ++k) {
      const uint32_t from = v[k], to = v[(k + 1) % 3];
      if (*edge_place(table, edge_key(to, from)) == 0)
        return refuse_edge(solid, from, to, t, "has no triangle on its other side", error);
    }
  }
  return SCREE_OK;
}

/* Whether all edges pair up: quick, without a hash table, but does not say which do not nor why. Edges are put to the lower of
 * their ends, as the higher one and the direction; sorted, each is followed by the same one walked the other way. Large fans, which
 * would take long to sort so, are left open. */
static scree_result pair_edges(const scree_solid* solid, const scree_allocator* allocator, bool* paired) {
  enum { MOST_FAN = 64 };
  const size_t vertices = solid->vertex_count, edges = 3 * (size_t)solid->triangle_count;
  *paired = false;
  if (vertices > UINT32_MAX / 2 || edges > UINT32_MAX) return SCREE_OK;
  uint32_t* end = scree_rt_allocate_zeroed(allocator, vertices + 1, sizeof *end);
  uint32_t* others = scree_rt_allocate(allocator, edges, sizeof *others);
  const scree_result result = end == NULL || others == NULL ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_OK;
  bool pair = result == SCREE_OK;
  for (size_t e = 0; pair && e < edges; e += 3)
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t from = solid->indices[e + k], to = solid->indices[e + (k + 1) % 3];
      ++end[(from < to ? from : to) + (size_t)1];
    }
  for (size_t v = 0; pair && v < vertices; ++v) {
    pair = end[v + 1] <= MOST_FAN;
    end[v + 1] += end[v];
  }
  for (size_t e = 0; pair && e < edges; e += 3)
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t from = solid->indices[e + k], to = solid->indices[e + (k + 1) % 3];
      pair = pair && from != to;
      others[end[from < to ? from : to]++] = from < to ? 2 * to : 2 * from + 1;
    }
  uint32_t first = 0;
  for (size_t v = 0; pair && v < vertices; ++v) {
    uint32_t* of = others + first;
    const uint32_t count = end[v] - first;
    for (uint32_t i = 1; i < count; ++i) {
      const uint32_t moved = of[i];
      uint32_t k = i;
      for (; k > 0 && of[k - 1] > moved; --k) of[k] = of[k - 1];
      of[k] = moved;
    }
    pair = count % 2 == 0;
    for (uint32_t i = 0; i < count / 2; ++i) pair = pair && of[2 * i] % 2 == 0 && of[2 * i + 1] == of[2 * i] + 1;
    first = end[v];
  }
  scree_rt_release(allocator, end, vertices + 1, sizeof *end);
  scree_rt_release(allocator, others, edges, sizeof *others);
  *paired = pair;
  return result;
}

/* The same with a table, in the order of triangles, so that an error names the first edge that is wrong. */
static scree_result find_open_edge(const scree_solid* solid, const scree_allocator* memory, scree_error* error) {
  edge_table table = {NULL, 16};
  const uint64_t places = (uint64_t)6 * solid->triangle_count;
  while (table.size < places && table.size < SIZE_MAX / 32) table.size *= 2;
  table.edges = table.size < places ? NULL : scree_rt_allocate_zeroed(memory, table.size, sizeof *table.edges);
  if (table.edges == NULL) {
    recipe_say(error, "solid: out of memory");
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  const scree_result result = check_edges(solid, &table, error);
  scree_rt_release(memory, table.edges, table.size, sizeof *table.edges);
  return result;
}

scree_result solid_check_closed(const scree_solid* solid, const scree_allocator* allocator, scree_error* error) {
  scree_result result = solid_check_numbers(solid, error);
  if (result != SCREE_OK) return result;
  const scree_allocator memory = scree_rt_allocator_or_default(allocator);
  bool paired;
  result = pair_edges(solid, &memory, &paired);
  if (result != SCREE_OK) recipe_say(error, "solid: out of memory");
  if (result == SCREE_OK && !paired) result = find_open_edge(solid, &memory, error);
  if (result != SCREE_OK) return result;
  const double volume = solid_volume6(solid);
  if (volume > 0) return SCREE_OK;
  recipe_say(error, volume < 0 ? "solid is inside out: its triangles must run counter-clockwise seen from outside"
                               : "solid encloses no volume");
  return SCREE_ERROR_INVALID_ARGUMENT;
}

scree_result solid_check_crossings(const scree_solid* solid, const scree_allocator* allocator, scree_error* error) {
  solid_crossing crossing;
  const scree_result result = solid_find_crossing(solid->positions, solid->indices, solid->triangle_count, allocator, &crossing);
  if (result != SCREE_OK) {
    recipe_say(error, "solid: out of memory");
    return result;
  }
  if (crossing.triangles[0] == SCREE_NO_CROSSING) return SCREE_OK;
  recipe_say(error, "solid crosses itself: triangles %u and %u go through each other at (%g, %g, %g); part them, or mesh it anew",
             crossing.triangles[0], crossing.triangles[1], crossing.place[0], crossing.place[1], crossing.place[2]);
  return SCREE_ERROR_UNSUPPORTED;
}

scree_result scree_solid_check(const scree_solid* solid, const scree_allocator* allocator, scree_error* error) {
  const scree_result result = solid_check_closed(solid, allocator, error);
  return result == SCREE_OK ? solid_check_crossings(solid, allocator, error) : result;
}

/* --- memory ----------------------------------------------------------------------------------------------------------------- */

scree_result solid_memory_create(uint64_t vertices, uint64_t triangles, bool uvs, const scree_allocator* allocator,
                                 scree_solid_memory* out, scree_error* error) {
  memset(out, 0, sizeof *out);
  if (vertices > UINT32_MAX || triangles > UINT32_MAX / 3) {
    recipe_say(error, "solid: too many triangles, %llu", (unsigned long long)triangles);
    return SCREE_ERROR_RANGE;
  }
  const uint64_t size = vertices * 3 * sizeof(double) + triangles * (3 * sizeof(uint32_t) + (uvs ? 6 * sizeof(float) : 0));
  out->memory = size > SIZE_MAX ? NULL : scree_rt_allocate_zeroed(allocator, 1, (size_t)size);
  if (out->memory == NULL) {
    recipe_say(error, "solid: out of memory");
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  out->size = (size_t)size;
  out->solid.vertex_count = (uint32_t)vertices, out->solid.triangle_count = (uint32_t)triangles;
  out->solid.positions = solid_positions(out);
  out->solid.indices = solid_indices(out);
  out->solid.uvs = uvs ? solid_uvs(out) : NULL;
  return SCREE_OK;
}

void scree_solid_free(const scree_allocator* allocator, scree_solid_memory* solid) {
  if (solid == NULL) return;
  const scree_allocator memory = scree_rt_allocator_or_default(allocator);
  scree_rt_release(&memory, solid->memory, 1, solid->size);
  memset(solid, 0, sizeof *solid);
}

/* --- terrain ---------------------------------------------------------------------------------------------------------------- */

/*   heights          a vertex a sample
 *   |  |  |  |       skirt: a quad a sample, straight down
 *   ring             a vertex below each sample of the border, and below each corner of a tile
 *    \ | /           base: a fan round the middle of each tile of TERRAIN_TILE samples, so that no triangle of a large terrain is
 *    middle          long and thin
 */
typedef struct terrain {
  const float* heights;
  uint32_t width, depth, tiles_x, tiles_z;
  double spacing, base;
  uint32_t ring, corners, middles; /* first vertex of each kind; the ring starts at (0, 0), x first, once round */
  double* positions;
  uint32_t* indices;
  float* uvs;
  size_t triangles;
} terrain;

static void place(const terrain* t, uint32_t vertex, double x, double z, double y) {
  double* p = t->positions + (size_t)3 * vertex;
  p[0] = (x - (double)(t->width - 1) / 2) * t->spacing;
  p[1] = y;
  p[2] = (z - (double)(t->depth - 1) / 2) * t->spacing;
}

static uint32_t ring_vertex(const terrain* t, uint32_t x, uint32_t z) {
  const uint32_t w = t->width - 1, d = t->depth - 1;
  return t->ring + (z == 0 ? x : x == w ? w + z : z == d ? w + d + (w - x) : 2 * w + d + (d - z));
}

static uint32_t tile_edge(uint32_t tile, uint32_t last) {
  return tile * TERRAIN_TILE < last ? tile * TERRAIN_TILE : last;
}

/* The vertex of the base below a sample of a tile's border that has one. */
static uint32_t base_vertex(const terrain* t, uint32_t x, uint32_t z) {
  if (x == 0 || z == 0 || x == t->width - 1 || z == t->depth - 1) return ring_vertex(t, x, z);
  return t->corners + (z / TERRAIN_TILE - 1) * (t->tiles_x - 1) + x / TERRAIN_TILE - 1;
}

static void triangle(terrain* t, uint32_t a, uint32_t b, uint32_t c) {
  const uint32_t v[3] = {a, b, c};
  for (size_t k = 0; k < 3; ++k) {
    t->indices[3 * t->triangles + k] = v[k];
    const double* p = t->positions + (size_t)3 * v[k];
    t->uvs[6 * t->triangles + 2 * k] = (float)(p[0] / ((double)(t->width - 1) * t->spacing) + 0.5);
    t->uvs[6 * t->triangles + 2 * k + 1] = (float)(p[2] / ((double)(t->depth - 1) * t->spacing) + 0.5);
  }
  ++t->triangles;
}

/* Quads are cut along the diagonal whose ends are nearer in height: ridges and gullies stay whole. */
static void put_top(terrain* t) {
  for (uint32_t z = 0; z < t->depth; ++z)
    for (uint32_t x = 0; x < t->width; ++x) {
      const uint32_t v = z * t->width + x;
      place(t, v, x, z, (double)t->heights[v]);
    }
  for (uint32_t z = 0; z + 1 < t->depth; ++z)
    for (uint32_t x = 0; x + 1 < t->width; ++x) {
      const uint32_t a = z * t->width + x, b = a + 1, c = a + t->width, d = c + 1;
      const double ad = fabs((double)t->heights[a] - (double)t->heights[d]);
      const double bc = fabs((double)t->heights[b] - (double)t->heights[c]);
      if (ad <= bc)
        triangle(t, a, d, b), triangle(t, a, c, d);
      else
        triangle(t, a, c, b), triangle(t, b, c, d);
    }
}

static void put_skirt(terrain* t, uint32_t x0, uint32_t z0, uint32_t x1, uint32_t z1) {
  const uint32_t a = z0 * t->width + x0, b = z1 * t->width + x1, c = ring_vertex(t, x0, z0), d = ring_vertex(t, x1, z1);
  triangle(t, a, b, d), triangle(t, a, d, c);
}

/* One side of a tile, walked from its first corner to its last; every sample has a vertex on the terrain's border, only the corners
 * have one within. */
static void put_base_side(terrain* t, uint32_t middle, uint32_t x0, uint32_t z0, uint32_t x1, uint32_t z1) {
  const bool border = x0 == x1 ? x0 == 0 || x0 == t->width - 1 : z0 == 0 || z0 == t->depth - 1;
  uint32_t x = x0, z = z0;
  while (x != x1 || z != z1) {
    const uint32_t from = base_vertex(t, x, z);
    if (!border)
      x = x1, z = z1;
    else
      x = x < x1 ? x + 1 : x > x1 ? x - 1 : x, z = z < z1 ? z + 1 : z > z1 ? z - 1 : z;
    triangle(t, middle, from, base_vertex(t, x, z));
  }
}

static void put_base(terrain* t) {
  const uint32_t w = t->width - 1, d = t->depth - 1;
  for (uint32_t x = 0; x <= w; ++x) place(t, ring_vertex(t, x, 0), x, 0, t->base), place(t, ring_vertex(t, x, d), x, d, t->base);
  for (uint32_t z = 0; z <= d; ++z) place(t, ring_vertex(t, 0, z), 0, z, t->base), place(t, ring_vertex(t, w, z), w, z, t->base);
  for (uint32_t j = 1; j < t->tiles_z; ++j)
    for (uint32_t i = 1; i < t->tiles_x; ++i)
      place(t, base_vertex(t, i * TERRAIN_TILE, j * TERRAIN_TILE), i * TERRAIN_TILE, j * TERRAIN_TILE, t->base);
  for (uint32_t j = 0; j < t->tiles_z; ++j)
    for (uint32_t i = 0; i < t->tiles_x; ++i) {
      const uint32_t x0 = tile_edge(i, w), x1 = tile_edge(i + 1, w), z0 = tile_edge(j, d), z1 = tile_edge(j + 1, d);
      const uint32_t middle = t->middles + j * t->tiles_x + i;
      place(t, middle, (double)(x0 + x1) / 2, (double)(z0 + z1) / 2, t->base);
      put_base_side(t, middle, x0, z0, x1, z0);
      put_base_side(t, middle, x1, z0, x1, z1);
      put_base_side(t, middle, x1, z1, x0, z1);
      put_base_side(t, middle, x0, z1, x0, z0);
    }
}

static scree_result check_terrain(const float* heights, uint32_t width, uint32_t depth, double spacing, double base,
                                  scree_error* error) {
  if (heights == NULL || width < 2 || depth < 2) {
    recipe_say(error, "heights: at least 2 x 2 are needed");
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  if ((uint64_t)width * depth > UINT32_C(1) << 28) {
    recipe_say(error, "heights: %u x %u are too many", width, depth);
    return SCREE_ERROR_RANGE;
  }
  const double side = (width > depth ? width : depth) - 1;
  if (!(spacing >= 1e-9 && spacing * side / 2 <= SOLID_LIMIT)) {
    recipe_say(error, "heights: spacing must be at least 1e-9 and keep the terrain within 1e6 of its middle, not %g", spacing);
    return SCREE_ERROR_RANGE;
  }
  if (!(fabs(base) <= SOLID_LIMIT)) {
    recipe_say(error, "heights: base must be a number from -1e6 to 1e6, not %g", base);
    return SCREE_ERROR_RANGE;
  }
  for (size_t i = 0; i < (size_t)width * depth; ++i) {
    if (!(fabs((double)heights[i]) <= SOLID_LIMIT)) {
      recipe_say(error, "heights: that at x %zu, z %zu is not a number from -1e6 to 1e6: %g", i % width, i / width,
                 (double)heights[i]);
      return SCREE_ERROR_RANGE;
    }
    if (!((double)heights[i] > base)) {
      recipe_say(error, "heights: that at x %zu, z %zu, %g, is not above the base, %g", i % width, i / width, (double)heights[i],
                 base);
      return SCREE_ERROR_INVALID_ARGUMENT;
    }
  }
  return SCREE_OK;
}

scree_result scree_solid_from_heights(const float* heights, uint32_t width, uint32_t depth, double spacing, double base,
                                      const scree_allocator* allocator, scree_solid_memory* out, scree_error* error) {
  if (out == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  memset(out, 0, sizeof *out);
  scree_result result = check_terrain(heights, width, depth, spacing, base, error);
  if (result != SCREE_OK) return result;
  const uint32_t w = width - 1, d = depth - 1;
  terrain t = {.heights = heights, .width = width, .depth = depth, .spacing = spacing, .base = base};
  t.tiles_x = (w + TERRAIN_TILE - 1) / TERRAIN_TILE, t.tiles_z = (d + TERRAIN_TILE - 1) / TERRAIN_TILE;
  const uint32_t around = 2 * (w + d), inner = (t.tiles_x - 1) * (t.tiles_z - 1), tiles = t.tiles_x * t.tiles_z;
  t.ring = width * depth;
  t.corners = t.ring + around;
  t.middles = t.corners + inner;
  /* Each side between two tiles is a triangle of both. */
  const uint64_t sides = (uint64_t)(t.tiles_x - 1) * t.tiles_z + (uint64_t)(t.tiles_z - 1) * t.tiles_x;
  const uint64_t triangles = (uint64_t)2 * w * d + (uint64_t)3 * around + 2 * sides;
  const scree_allocator memory = scree_rt_allocator_or_default(allocator);
  result = solid_memory_create((uint64_t)t.middles + tiles, triangles, true, &memory, out, error);
  if (result != SCREE_OK) return result;
  t.positions = solid_positions(out), t.indices = solid_indices(out), t.uvs = solid_uvs(out);
  put_top(&t);
  put_base(&t);
  for (uint32_t x = 0; x < w; ++x) put_skirt(&t, x, 0, x + 1, 0), put_skirt(&t, x + 1, d, x, d);
  for (uint32_t z = 0; z < d; ++z) put_skirt(&t, 0, z + 1, 0, z), put_skirt(&t, w, z, w, z + 1);
  return SCREE_OK;
}
