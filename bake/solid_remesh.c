/* Triangles of any kind as a closed solid. Inside is where the generalised winding number is 1/2 or more. Where the triangles
 * close, crossing each other or not, that number is whole, and rays count it; only where they leave holes it is summed up in full.
 */
#include <math.h>
#include <string.h>

#include "lattice.h"
#include "recipe_text.h"
#include "seed_mask.h"
#include "solid_mesh.h"
#include "winding_tree.h"

enum { BLOCK = 8, MOST_CROSSINGS = 256, HALVINGS = 8 };

/* What remeshing works on: triangles whose corners are three places. */
typedef struct soup {
  const double* positions;
  uint32_t* indices; /* equal positions are one vertex */
  uint32_t vertex_count, triangle_count, capacity;
  scree_allocator allocator;
  bool closed;
  solid_inside inside; /* closed */
  winding_tree tree;   /* not closed */
} soup;

/* --- equal positions, and edges --------------------------------------------------------------------------------------------- */

static uint64_t place_hash(const double* p) {
  uint64_t hash = 0;
  for (int a = 0; a < 3; ++a) {
    const double x = p[a] == 0 ? 0 : p[a]; /* -0 is 0 */
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    hash = hash_combine(hash, bits);
  }
  return hash;
}

static size_t table_size(uint64_t count) {
  size_t size = 16;
  while (size < 2 * count && size < SIZE_MAX / 64) size *= 2;
  return size;
}

/* Drops triangles that are none. */
static bool weld(soup* s, const scree_solid* solid) {
  const size_t size = table_size(solid->vertex_count);
  uint32_t* table = scree_rt_allocate_zeroed(&s->allocator, size, sizeof *table); /* vertex + 1 */
  uint32_t* first = scree_rt_allocate(&s->allocator, solid->vertex_count, sizeof *first);
  if (table != NULL && first != NULL) {
    for (uint32_t v = 0; v < solid->vertex_count; ++v) {
      const double* p = solid->positions + (size_t)3 * v;
      size_t at = (size_t)place_hash(p) & (size - 1);
      for (; table[at] != 0; at = (at + 1) & (size - 1)) {
        const double* q = solid->positions + (size_t)3 * (table[at] - 1);
        if (p[0] == q[0] && p[1] == q[1] && p[2] == q[2]) break;
      }
      if (table[at] == 0) table[at] = v + 1;
      first[v] = table[at] - 1;
    }
    for (size_t t = 0; t < solid->triangle_count; ++t) {
      const uint32_t* v = solid->indices + 3 * t;
      const uint32_t w[3] = {first[v[0]], first[v[1]], first[v[2]]};
      if (w[0] == w[1] || w[1] == w[2] || w[2] == w[0]) continue;
      memcpy(s->indices + (size_t)3 * s->triangle_count++, w, sizeof w);
    }
  }
  const bool done = table != NULL && first != NULL;
  scree_rt_release(&s->allocator, table, size, sizeof *table);
  scree_rt_release(&s->allocator, first, solid->vertex_count, sizeof *first);
  return done;
}

typedef struct edge_sum {
  uint64_t edge; /* lower vertex << 32 | higher one; 0 = none */
  int32_t sum;   /* uses upwards less uses downwards */
} edge_sum;

/* Whether every edge is used as often one way as the other: then winding numbers are whole. */
static bool find_closed(soup* s) {
  const size_t size = table_size((uint64_t)3 * s->triangle_count);
  edge_sum* table = scree_rt_allocate_zeroed(&s->allocator, size, sizeof *table);
  if (table == NULL) return false;
  for (size_t t = 0; t < s->triangle_count; ++t)
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t from = s->indices[3 * t + k], to = s->indices[3 * t + (k + 1) % 3];
      const uint64_t edge = from < to ? (uint64_t)from << 32 | to : (uint64_t)to << 32 | from;
      size_t at = (size_t)hash_mix(edge) & (size - 1);
      while (table[at].edge != 0 && table[at].edge != edge) at = (at + 1) & (size - 1);
      table[at].edge = edge;
      table[at].sum += from < to ? 1 : -1;
    }
  s->closed = true;
  for (size_t i = 0; i < size; ++i) s->closed = s->closed && table[i].sum == 0;
  scree_rt_release(&s->allocator, table, size, sizeof *table);
  return true;
}

/* --- samples ---------------------------------------------------------------------------------------------------------------- */

static bool soup_has(const soup* s, const double p[3]) {
  return s->closed ? solid_winding(&s->inside, p) > 0 : winding_tree_at(&s->tree, p) >= 0.5;
}

static bool fill_by_rays(void* user, solid_grid* grid) {
  const soup* s = user;
  solid_crossing crossings[MOST_CROSSINGS];
  for (uint32_t z = 0; z < grid->size[2]; ++z)
    for (uint32_t x = 0; x < grid->size[0]; ++x) {
      double p[3];
      solid_grid_place(grid, x, 0, z, p);
      const uint32_t count = solid_crossings(&s->inside, p[0], p[2], crossings, MOST_CROSSINGS);
      if (count == 0) continue;
      int32_t winding = 0;
      uint32_t next = 0;
      if (count <= MOST_CROSSINGS)
        for (uint32_t i = 0; i < count; ++i) winding += crossings[i].turn;
      for (uint32_t y = 0; y < grid->size[1]; ++y) {
        solid_grid_place(grid, x, y, z, p);
        if (count > MOST_CROSSINGS)
          winding = solid_winding(&s->inside, p);
        else
          for (; next < count && crossings[next].y <= p[1]; ++next) winding -= crossings[next].turn;
        if (winding > 0) solid_grid_set(grid, solid_grid_at(grid, x, y, z));
      }
    }
  return true;
}

/* 1 or 0 where a block of samples that no triangle comes near to is all inside or all outside, -1 where it may be both. Within such
 * a block the winding number is harmonic: it has its extremes at the border, and is smooth. */
static int32_t judge_block(const soup* s, const solid_grid* grid, const seed_mask* mask, const uint32_t low[3]) {
  double middle[3], half = (BLOCK - 1) * grid->step / 2, least = 2, most = -2;
  for (int a = 0; a < 3; ++a) middle[a] = grid->min[a] + low[a] * grid->step + half;
  if (seed_mask_has(mask, middle)) return -1;
  for (int i = 0; i < 9; ++i) {
    double p[3];
    for (int a = 0; a < 3; ++a) p[a] = middle[a] + (i == 8 ? 0 : i >> a & 1 ? half : -half);
    const double w = winding_tree_at(&s->tree, p);
    if (w < least) least = w;
    if (w > most) most = w;
  }
  const double change = most - least;
  return least - change > 0.6 ? 1 : most + change < 0.4 ? 0 : -1;
}

static bool fill_by_angles(void* user, solid_grid* grid) {
  const soup* s = user;
  seed_mask mask;
  const seed_mask_desc desc = {.positions = s->positions,
                               .indices = s->indices,
                               .vertex_count = s->vertex_count,
                               .triangle_count = s->triangle_count,
                               .step = 2 * grid->step,
                               .most = 0.8661 * (BLOCK - 1) * grid->step};
  if (seed_mask_create(&desc, &s->allocator, &mask) != SCREE_OK) return false;
  uint32_t low[3];
  for (low[2] = 0; low[2] < grid->size[2]; low[2] += BLOCK)
    for (low[1] = 0; low[1] < grid->size[1]; low[1] += BLOCK)
      for (low[0] = 0; low[0] < grid->size[0]; low[0] += BLOCK) {
        uint32_t end[3];
        for (int a = 0; a < 3; ++a) end[a] = low[a] + BLOCK < grid->size[a] ? low[a] + BLOCK : grid->size[a];
        const int32_t whole = judge_block(s, grid, &mask, low);
        if (whole == 0) continue;
        for (uint32_t z = low[2]; z < end[2]; ++z)
          for (uint32_t y = low[1]; y < end[1]; ++y)
            for (uint32_t x = low[0]; x < end[0]; ++x) {
              double p[3];
              solid_grid_place(grid, x, y, z, p);
              if (whole == 1 || soup_has(s, p)) solid_grid_set(grid, solid_grid_at(grid, x, y, z));
            }
      }
  seed_mask_free(&mask, &s->allocator);
  return true;
}

static double find_surface(void* user, const double p[3], const double q[3]) {
  double low = 0, high = 1;
  for (int i = 0; i < HALVINGS; ++i) {
    const double t = (low + high) / 2;
    double at[3];
    for (int a = 0; a < 3; ++a) at[a] = p[a] + t * (q[a] - p[a]);
    if (soup_has(user, at))
      low = t;
    else
      high = t;
  }
  return (low + high) / 2;
}

static scree_result remesh(soup* s, const scree_solid* solid, uint32_t resolution, scree_solid_memory* out, scree_error* error) {
  static const char what[] = "remesh";
  s->capacity = solid->triangle_count;
  s->indices = scree_rt_allocate(&s->allocator, (size_t)3 * s->capacity, sizeof *s->indices);
  bool room = s->indices != NULL && weld(s, solid);
  if (room && s->triangle_count == 0) {
    recipe_say(error, "%s: all triangles are without area", what);
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  room = room && find_closed(s);
  if (room && s->closed)
    room = solid_inside_create(s->positions, s->indices, s->triangle_count, &s->allocator, &s->inside) == SCREE_OK;
  else if (room)
    room = winding_tree_create(s->positions, s->indices, s->triangle_count, &s->allocator, &s->tree) == SCREE_OK;
  if (!room) {
    recipe_say(error, "%s: out of memory", what);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  double min[3], max[3];
  solid_bounds(solid, min, max);
  const solid_source source = {s, s->closed ? fill_by_rays : fill_by_angles, find_surface};
  return solid_mesh(&source, min, max, resolution, what, &s->allocator, out, error);
}

scree_result scree_solid_remesh(const scree_solid* solid, uint32_t resolution, const scree_allocator* allocator,
                                scree_solid_memory* out, scree_error* error) {
  if (out == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  memset(out, 0, sizeof *out);
  scree_result result = solid_check_numbers(solid, error);
  if (result != SCREE_OK) return result;
  if (resolution < 8 || resolution > 512) {
    recipe_say(error, "remesh: resolution must be 8..512, not %u", resolution);
    return SCREE_ERROR_RANGE;
  }
  soup s = {
      .positions = solid->positions, .vertex_count = solid->vertex_count, .allocator = scree_rt_allocator_or_default(allocator)};
  result = remesh(&s, solid, resolution, out, error);
  solid_inside_free(&s.inside, &s.allocator);
  winding_tree_free(&s.tree, &s.allocator);
  scree_rt_release(&s.allocator, s.indices, (size_t)3 * s.capacity, sizeof *s.indices);
  return result;
}
