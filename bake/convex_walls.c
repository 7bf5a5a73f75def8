#include "convex_walls.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "disjoint_sets.h"
#include "lattice.h"
#include "vectors.h"

/* Where more than three walls meet, each cuts by a plane that lies up to this part of the solid's extent further out, so that all
 * cells see the same plain corners: far above rounding, far below what is checked. */
static const double APART = 1e-10;
static const double FLAT = 1e-10; /* parts of the extent within which points lie in a plane */

typedef struct side {
  uint64_t edge; /* lower vertex, higher vertex */
  uint32_t triangle, opposite;
} side;

static int by_edge(const void* a, const void* b) {
  const side *p = a, *q = b;
  if (p->edge != q->edge) return p->edge < q->edge ? -1 : 1;
  return p->triangle < q->triangle ? -1 : p->triangle > q->triangle;
}

static const double* corner_of(const double* positions, const uint32_t* indices, uint32_t triangle, uint32_t k) {
  return positions + 3 * (size_t)indices[3 * (size_t)triangle + k];
}

/* Twice the area; the normal is unit unless that is 0. */
static double normal_of(const double* positions, const uint32_t* indices, uint32_t triangle, double out[3]) {
  const double* a = corner_of(positions, indices, triangle, 0);
  const double* b = corner_of(positions, indices, triangle, 1);
  const double* c = corner_of(positions, indices, triangle, 2);
  const double u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  out[0] = u[1] * v[2] - u[2] * v[1];
  out[1] = u[2] * v[0] - u[0] * v[2];
  out[2] = u[0] * v[1] - u[1] * v[0];
  const double length = sqrt(dot(out, out));
  if (length > 0)
    for (int axis = 0; axis < 3; ++axis) out[axis] /= length;
  return length;
}

static double extent_of(const double* positions, uint32_t vertex_count) {
  double min[3], max[3], extent = 0;
  points_bounds(positions, vertex_count, min, max);
  for (int axis = 0; axis < 3; ++axis) extent = max[axis] - min[axis] > extent ? max[axis] - min[axis] : extent;
  return extent;
}

bool convex_walls_possible(const double* positions, uint32_t vertex_count, const uint32_t* indices, uint32_t triangle_count) {
  const double flat = FLAT * extent_of(positions, vertex_count);
  const uint32_t step = triangle_count / 64 + 1;
  for (uint32_t t = 0; t < triangle_count; t += step) {
    double normal[3];
    if (!(normal_of(positions, indices, t, normal) > 0)) continue;
    /* A sliver's normal says little: hold it against its own plane only as far as that is sure. */
    const double offset = dot(normal, corner_of(positions, indices, t, 0)) + 1e3 * flat;
    for (size_t i = 0; i < vertex_count; ++i)
      if (dot(normal, positions + 3 * i) > offset) return false;
  }
  return true;
}

/* Everything that is built on the way. */
typedef struct building {
  const double* positions;
  const uint32_t* indices;
  double* normals; /* 3 each */
  double* areas;
  side* sides;
  uint32_t *parents, *wall_at;
  double flat;
} building;

/* How far triangle u's corner that is not on the common edge lies outside t's plane. */
static double above(const building* b, uint32_t t, const double* corner) {
  const double* a = corner_of(b->positions, b->indices, t, 0);
  const double d[3] = {corner[0] - a[0], corner[1] - a[1], corner[2] - a[2]};
  return dot(b->normals + 3 * (size_t)t, d);
}

/* Joins triangles of one plane; says whether no edge is hollow. */
static bool join_flat(building* b, uint32_t triangle_count, uint32_t* edge_count) {
  const size_t count = 3 * (size_t)triangle_count;
  bool convex = true;
  *edge_count = 0;
  for (size_t i = 0; i < count;) {
    size_t end = i + 1;
    while (end < count && b->sides[end].edge == b->sides[i].edge) ++end;
    ++*edge_count;
    if (end != i + 2) convex = false;
    const side *s = b->sides + i, *t = b->sides + end - 1;
    i = end;
    const double area_s = b->areas[s->triangle], area_t = b->areas[t->triangle];
    if (!(area_s > 0) || !(area_t > 0)) {
      join(b->parents, s->triangle, t->triangle);
      continue;
    }
    const double out_t = above(b, s->triangle, b->positions + 3 * (size_t)t->opposite);
    const double out_s = above(b, t->triangle, b->positions + 3 * (size_t)s->opposite);
    if (out_t > b->flat || out_s > b->flat) convex = false;
    const bool flat = fabs(out_t) <= b->flat && fabs(out_s) <= b->flat;
    if (flat && dot(b->normals + 3 * (size_t)s->triangle, b->normals + 3 * (size_t)t->triangle) > 0)
      join(b->parents, s->triangle, t->triangle);
  }
  return convex;
}

/* Whether all triangles hang together: by walls is not enough, so that it is asked of vertices. */
static bool is_ball(building* b, uint32_t vertex_count, uint32_t triangle_count, uint32_t edge_count, uint32_t* scratch) {
  uint32_t used = 0, roots = 0;
  for (uint32_t v = 0; v < vertex_count; ++v) scratch[v] = UINT32_MAX;
  for (uint32_t t = 0; t < triangle_count; ++t)
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t v = b->indices[3 * (size_t)t + k];
      if (scratch[v] == UINT32_MAX) scratch[v] = v, ++used;
    }
  for (uint32_t t = 0; t < triangle_count; ++t) {
    const uint32_t* v = b->indices + 3 * (size_t)t;
    join(scratch, v[0], v[1]);
    join(scratch, v[0], v[2]);
  }
  for (uint32_t v = 0; v < vertex_count; ++v) roots += scratch[v] == v;
  return roots == 1 && (int64_t)used - edge_count + triangle_count == 2;
}

/* Walls in the order of the largest triangle of each. */
static void number_walls(building* b, convex_walls* out) {
  uint32_t* largest = b->wall_at; /* by root */
  for (uint32_t t = 0; t < out->triangle_count; ++t) largest[t] = UINT32_MAX;
  for (uint32_t t = 0; t < out->triangle_count; ++t) {
    const uint32_t root = root_of(b->parents, t);
    if (largest[root] == UINT32_MAX || b->areas[t] > b->areas[largest[root]]) largest[root] = t;
  }
  out->wall_count = 0;
  for (uint32_t t = 0; t < out->triangle_count; ++t) {
    if (largest[root_of(b->parents, t)] != t) continue;
    const double* n = b->normals + 3 * (size_t)t;
    double offset = 0;
    for (uint32_t k = 0; k < 3; ++k) offset += dot(n, corner_of(b->positions, b->indices, t, k)) / 3;
    out->walls[out->wall_count] = (voronoi_wall){{n[0], n[1], n[2]}, offset, offset};
    out->wall_of[t] = out->wall_count;
    out->triangles[out->wall_count++] = t;
  }
  for (uint32_t t = 0; t < out->triangle_count; ++t) out->wall_of[t] = out->wall_of[largest[root_of(b->parents, t)]];
}

static void list_corners(const building* b, convex_walls* out, double extent) {
  memset(out->at_first, 0, ((size_t)out->vertex_count + 1) * sizeof *out->at_first);
  for (size_t i = 0; i < 3 * (size_t)out->triangle_count; ++i) ++out->at_first[b->indices[i] + 1];
  for (size_t v = 0; v < out->vertex_count; ++v) {
    out->at_first[v + 1] += out->at_first[v];
    out->at_count[v] = 0;
  }
  for (uint32_t t = 0; t < out->triangle_count; ++t)
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t v = b->indices[3 * (size_t)t + k];
      uint32_t* at = out->at + out->at_first[v];
      uint32_t i = 0;
      while (i < out->at_count[v] && at[i] != out->wall_of[t]) ++i;
      if (i == out->at_count[v]) at[out->at_count[v]++] = out->wall_of[t];
    }
  memset(out->corner_first, 0, ((size_t)out->wall_count + 1) * sizeof *out->corner_first);
  for (uint32_t v = 0; v < out->vertex_count; ++v) {
    const uint32_t count = out->at_count[v];
    if (count < 3) continue;
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t wall = out->at[out->at_first[v] + i];
      ++out->corner_first[wall + 1];
      if (count > 3) {
        const double part = (double)(hash_mix(wall + 1) >> 11) * 0x1p-53;
        out->walls[wall].cut = out->walls[wall].offset + APART * extent * part;
      }
    }
  }
  for (size_t wall = 0; wall < out->wall_count; ++wall) out->corner_first[wall + 1] += out->corner_first[wall];
  for (uint32_t v = 0; v < out->vertex_count; ++v)
    for (uint32_t i = 0; out->at_count[v] >= 3 && i < out->at_count[v]; ++i)
      out->corners[out->corner_first[out->at[out->at_first[v] + i]]++] = v;
  memmove(out->corner_first + 1, out->corner_first, out->wall_count * sizeof *out->corner_first);
  out->corner_first[0] = 0;
}

static bool allocate_walls(convex_walls* out, const scree_allocator* allocator) {
  const size_t triangles = out->triangle_count, vertices = out->vertex_count;
  out->walls = scree_rt_allocate(allocator, triangles, sizeof *out->walls);
  out->triangles = scree_rt_allocate(allocator, triangles, sizeof(uint32_t));
  out->wall_of = scree_rt_allocate(allocator, triangles, sizeof(uint32_t));
  out->at_first = scree_rt_allocate(allocator, vertices + 1, sizeof(uint32_t));
  out->at_count = scree_rt_allocate(allocator, vertices, sizeof(uint32_t));
  out->at = scree_rt_allocate(allocator, triangles, 3 * sizeof(uint32_t));
  out->corner_first = scree_rt_allocate(allocator, triangles + 1, sizeof(uint32_t));
  out->corners = scree_rt_allocate(allocator, triangles, 3 * sizeof(uint32_t));
  return out->walls != NULL && out->triangles != NULL && out->wall_of != NULL && out->at_first != NULL && out->at_count != NULL &&
         out->at != NULL && out->corner_first != NULL && out->corners != NULL;
}

void convex_walls_free(convex_walls* walls, const scree_allocator* allocator) {
  const size_t triangles = walls->triangle_count, vertices = walls->vertex_count;
  scree_rt_release(allocator, walls->walls, triangles, sizeof *walls->walls);
  scree_rt_release(allocator, walls->triangles, triangles, sizeof(uint32_t));
  scree_rt_release(allocator, walls->wall_of, triangles, sizeof(uint32_t));
  scree_rt_release(allocator, walls->at_first, vertices + 1, sizeof(uint32_t));
  scree_rt_release(allocator, walls->at_count, vertices, sizeof(uint32_t));
  scree_rt_release(allocator, walls->at, triangles, 3 * sizeof(uint32_t));
  scree_rt_release(allocator, walls->corner_first, triangles + 1, sizeof(uint32_t));
  scree_rt_release(allocator, walls->corners, triangles, 3 * sizeof(uint32_t));
  *walls = (convex_walls){0};
}

static void list_sides(building* b, uint32_t triangle_count) {
  for (uint32_t t = 0; t < triangle_count; ++t) {
    b->areas[t] = normal_of(b->positions, b->indices, t, b->normals + 3 * (size_t)t);
    b->parents[t] = t;
    const uint32_t* v = b->indices + 3 * (size_t)t;
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t from = v[k], to = v[k == 2 ? 0 : k + 1], opposite = v[k == 0 ? 2 : k - 1];
      const uint64_t low = from < to ? from : to, high = from < to ? to : from;
      b->sides[3 * (size_t)t + k] = (side){low << 32 | high, t, opposite};
    }
  }
  qsort(b->sides, 3 * (size_t)triangle_count, sizeof *b->sides, by_edge);
}

scree_result convex_walls_create(const double* positions, uint32_t vertex_count, const uint32_t* indices, uint32_t triangle_count,
                                 const scree_allocator* allocator, convex_walls* out, bool* convex) {
  *out = (convex_walls){.vertex_count = vertex_count, .triangle_count = triangle_count};
  const double extent = extent_of(positions, vertex_count);
  building b = {.positions = positions, .indices = indices, .flat = FLAT * extent};
  b.normals = scree_rt_allocate(allocator, triangle_count, 3 * sizeof *b.normals);
  b.areas = scree_rt_allocate(allocator, triangle_count, sizeof *b.areas);
  b.sides = scree_rt_allocate(allocator, triangle_count, 3 * sizeof *b.sides);
  b.parents = scree_rt_allocate(allocator, triangle_count, sizeof *b.parents);
  b.wall_at = scree_rt_allocate(allocator, triangle_count, sizeof *b.wall_at);
  scree_result result = SCREE_ERROR_OUT_OF_MEMORY;
  if (b.normals != NULL && b.areas != NULL && b.sides != NULL && b.parents != NULL && b.wall_at != NULL &&
      allocate_walls(out, allocator)) {
    uint32_t edge_count;
    list_sides(&b, triangle_count);
    bool is_convex = join_flat(&b, triangle_count, &edge_count);
    if (convex != NULL) *convex = is_convex && is_ball(&b, vertex_count, triangle_count, edge_count, out->at_count);
    number_walls(&b, out);
    list_corners(&b, out, extent);
    result = SCREE_OK;
  }
  scree_rt_release(allocator, b.normals, triangle_count, 3 * sizeof *b.normals);
  scree_rt_release(allocator, b.areas, triangle_count, sizeof *b.areas);
  scree_rt_release(allocator, b.sides, triangle_count, 3 * sizeof *b.sides);
  scree_rt_release(allocator, b.parents, triangle_count, sizeof *b.parents);
  scree_rt_release(allocator, b.wall_at, triangle_count, sizeof *b.wall_at);
  if (result != SCREE_OK) convex_walls_free(out, allocator);
  return result;
}

static bool meets(const convex_walls* walls, uint32_t vertex, uint32_t wall) {
  const uint32_t* at = walls->at + walls->at_first[vertex];
  for (uint32_t i = 0; i < walls->at_count[vertex]; ++i)
    if (at[i] == wall) return true;
  return false;
}

uint32_t convex_walls_corner(const convex_walls* walls, uint32_t a, uint32_t b, uint32_t c) {
  for (uint32_t i = walls->corner_first[a]; i < walls->corner_first[a + 1]; ++i)
    if (meets(walls, walls->corners[i], b) && meets(walls, walls->corners[i], c)) return walls->corners[i];
  return UINT32_MAX;
}
