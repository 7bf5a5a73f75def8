#include "mesh_simplify.h"

#include <math.h>
#include <string.h>

#include "allocator.h"
#include "vectors.h"

/* The squared distances to planes, weighted by area: p A p + 2 b p + c, and the sum of the areas. */
typedef struct quadric {
  double xx, xy, xz, yy, yz, zz, x, y, z, c;
} quadric;

#define NONE UINT32_MAX

/* A triangle may not turn by more than this cosine, nor become thinner than this share of area to longest side squared. */
#define LEAST_COSINE 0.25
#define LEAST_SHAPE 0.02
/* How much planes across the edges between groups and uvs, between materials, and between shades count. */
#define SEAM_WEIGHT 0.5
#define MATERIAL_WEIGHT 2.0
#define SHADE_WEIGHT 0.05

struct mesh_simplifier {
  scree_allocator allocator;
  simplify_mesh mesh;
  uint32_t alive;    /* triangles */
  uint32_t* first;   /* of each vertex: a corner, 3 * triangle + k, or NONE */
  uint32_t* next;    /* of each corner: another of the same vertex, or NONE */
  quadric* quadrics; /* of each vertex */
  uint8_t* locked;   /* of each vertex: an edge joins it to another twice, and it stays */
  uint32_t* marks;   /* of each vertex, held against stamp */
  uint32_t stamp;
  uint32_t* target; /* of each vertex: where it would go, or NONE */
  double* cost;
  uint32_t* heap; /* vertices, the cheapest first */
  uint32_t* slot; /* of each vertex in the heap, or NONE */
  uint32_t heap_count;
  uint32_t *ring, *other, *around; /* scratch: the vertices around one */
  float (*pending)[2];             /* uvs of corners that move */
};

/* --- Geometry. --- */

static void between(const int16_t from[3], const int16_t to[3], double out[3]) {
  for (uint32_t a = 0; a < 3; ++a) out[a] = to[a] - from[a];
}

static bool same_place(const simplify_mesh* m, uint32_t u, uint32_t v) {
  return memcmp(m->positions[u], m->positions[v], sizeof *m->positions) == 0;
}

/* Twice the area vector, exact. */
static void area_vector(const simplify_mesh* m, const uint32_t c[3], double out[3]) {
  double u[3], v[3];
  between(m->positions[c[0]], m->positions[c[1]], u);
  between(m->positions[c[0]], m->positions[c[2]], v);
  cross(u, v, out);
}

/* Doubled area over the longest side squared. */
static double shape_of(const simplify_mesh* m, const uint32_t c[3], double doubled_area) {
  double longest = 0;
  for (uint32_t k = 0; k < 3; ++k) {
    double side[3];
    between(m->positions[c[k]], m->positions[c[(k + 1) % 3]], side);
    if (dot(side, side) > longest) longest = dot(side, side);
  }
  return longest > 0 ? doubled_area / longest : 0;
}

static void add_plane(quadric* q, const double n[3], const int16_t at[3], double weight) {
  const double p[3] = {at[0], at[1], at[2]}, d = -dot(n, p);
  q->xx += weight * n[0] * n[0];
  q->xy += weight * n[0] * n[1];
  q->xz += weight * n[0] * n[2];
  q->yy += weight * n[1] * n[1];
  q->yz += weight * n[1] * n[2];
  q->zz += weight * n[2] * n[2];
  q->x += weight * n[0] * d;
  q->y += weight * n[1] * d;
  q->z += weight * n[2] * d;
  q->c += weight * d * d;
}

static void add_quadric(quadric* to, const quadric* q) {
  to->xx += q->xx, to->xy += q->xy, to->xz += q->xz, to->yy += q->yy, to->yz += q->yz, to->zz += q->zz;
  to->x += q->x, to->y += q->y, to->z += q->z, to->c += q->c;
}

static double quadric_at(const quadric* q, const int16_t at[3]) {
  const double x = at[0], y = at[1], z = at[2];
  return q->xx * x * x + q->yy * y * y + q->zz * z * z + 2 * (q->xy * x * y + q->xz * x * z + q->yz * y * z) +
         2 * (q->x * x + q->y * y + q->z * z) + q->c;
}

/* --- Corners and rings. --- */

static uint32_t* corners_of(const mesh_simplifier* s, uint32_t corner) {
  return s->mesh.corners[corner / 3];
}

static uint32_t vertex_at(const mesh_simplifier* s, uint32_t corner, uint32_t ahead) {
  return s->mesh.corners[corner / 3][(corner % 3 + ahead) % 3];
}

/* The vertices that edges join to one, as its triangles come. */
static uint32_t find_ring(mesh_simplifier* s, uint32_t vertex, uint32_t* ring) {
  uint32_t count = 0;
  ++s->stamp;
  for (uint32_t c = s->first[vertex]; c != NONE; c = s->next[c])
    for (uint32_t k = 1; k < 3; ++k) {
      const uint32_t v = vertex_at(s, c, k);
      if (s->marks[v] == s->stamp) continue;
      s->marks[v] = s->stamp;
      ring[count++] = v;
    }
  return count;
}

/* Whether the mesh stays what it is when u goes to v: the two have just the far corners of their two triangles in common, and no
 * triangle across these. */
static bool keeps_topology(mesh_simplifier* s, uint32_t u, uint32_t v) {
  if (s->locked[u] || s->locked[v]) return false;
  uint32_t dying = 0, far[2] = {NONE, NONE};
  for (uint32_t c = s->first[u]; c != NONE; c = s->next[c])
    for (uint32_t k = 1; k < 3; ++k)
      if (vertex_at(s, c, k) == v) {
        if (dying == 2) return false;
        far[dying++] = vertex_at(s, c, 3 - k);
      }
  if (dying != 2 || far[0] == far[1]) return false;
  find_ring(s, u, s->other);
  const uint32_t of_u = s->stamp;
  for (uint32_t c = s->first[v]; c != NONE; c = s->next[c])
    for (uint32_t k = 1; k < 3; ++k) {
      const uint32_t w = vertex_at(s, c, k);
      if (w != u && s->marks[w] == of_u && w != far[0] && w != far[1]) return false;
    }
  for (uint32_t c = s->first[u]; c != NONE; c = s->next[c]) {
    const uint32_t a = vertex_at(s, c, 1), b = vertex_at(s, c, 2);
    if ((a == far[0] && b == far[1]) || (a == far[1] && b == far[0])) return false;
  }
  return true;
}

/* Whether no triangle turns over or gets too thin. */
static bool keeps_shape(const mesh_simplifier* s, uint32_t u, uint32_t v) {
  const simplify_mesh* m = &s->mesh;
  for (uint32_t c = s->first[u]; c != NONE; c = s->next[c]) {
    const uint32_t* old = corners_of(s, c);
    if (old[0] == v || old[1] == v || old[2] == v) continue;
    uint32_t new[3] = {old[0], old[1], old[2]};
    new[c % 3] = v;
    double before[3], after[3];
    area_vector(m, old, before);
    area_vector(m, new, after);
    const double before2 = dot(before, before), after2 = dot(after, after);
    if (before2 == 0) continue; /* nothing to lose */
    if (after2 == 0) return false;
    const double length = sqrt(after2);
    if (dot(before, after) < LEAST_COSINE * (sqrt(before2) * length)) return false;
    const double shape = shape_of(m, new, length);
    if (shape < LEAST_SHAPE && shape < shape_of(m, old, sqrt(before2))) return false;
  }
  return true;
}

/* --- The heap. --- */

static bool is_before(const mesh_simplifier* s, uint32_t u, uint32_t v) {
  const double a = s->cost[u], b = s->cost[v];
  return a < b || (a <= b && u < v);
}

static void put(mesh_simplifier* s, uint32_t at, uint32_t vertex) {
  s->heap[at] = vertex;
  s->slot[vertex] = at;
}

static void sift(mesh_simplifier* s, uint32_t at) {
  const uint32_t vertex = s->heap[at];
  while (at > 0 && is_before(s, vertex, s->heap[(at - 1) / 2])) {
    put(s, at, s->heap[(at - 1) / 2]);
    at = (at - 1) / 2;
  }
  for (uint32_t child; (child = 2 * at + 1) < s->heap_count; at = child) {
    if (child + 1 < s->heap_count && is_before(s, s->heap[child + 1], s->heap[child])) ++child;
    if (!is_before(s, s->heap[child], vertex)) break;
    put(s, at, s->heap[child]);
  }
  put(s, at, vertex);
}

static void heap_remove(mesh_simplifier* s, uint32_t vertex) {
  const uint32_t at = s->slot[vertex];
  if (at == NONE) return;
  s->slot[vertex] = NONE;
  const uint32_t last = s->heap[--s->heap_count];
  if (at == s->heap_count) return;
  put(s, at, last);
  sift(s, at);
}

static void heap_set(mesh_simplifier* s, uint32_t vertex) {
  if (s->slot[vertex] == NONE) put(s, s->heap_count++, vertex);
  sift(s, s->slot[vertex]);
}

/* Finds where a vertex goes for the least, and puts it into the heap or takes it out. */
static void choose_target(mesh_simplifier* s, uint32_t u) {
  uint32_t count = find_ring(s, u, s->ring);
  s->target[u] = NONE;
  while (count > 0) {
    uint32_t best = 0;
    double least = INFINITY;
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t v = s->ring[i];
      const double cost = quadric_at(&s->quadrics[u], s->mesh.positions[v]) + quadric_at(&s->quadrics[v], s->mesh.positions[v]);
      if (cost < least || (cost <= least && v < s->ring[best])) least = cost, best = i;
    }
    const uint32_t v = s->ring[best];
    if (keeps_shape(s, u, v) && keeps_topology(s, u, v)) {
      s->target[u] = v;
      s->cost[u] = least > 0 ? least : 0;
      heap_set(s, u);
      return;
    }
    s->ring[best] = s->ring[--count];
  }
  heap_remove(s, u);
}

/* --- A collapse. --- */

/* The uv of a place on the plane of a triangle, by the triangle's own map. */
static void extend_uv(const simplify_mesh* m, uint32_t triangle, const int16_t at[3], float uv[2]) {
  const uint32_t* c = m->corners[triangle];
  double u[3], v[3], p[3];
  between(m->positions[c[0]], m->positions[c[1]], u);
  between(m->positions[c[0]], m->positions[c[2]], v);
  between(m->positions[c[0]], at, p);
  const double uu = dot(u, u), vw = dot(u, v), vv = dot(v, v), pu = dot(p, u), pv = dot(p, v), all = uu * vv - vw * vw;
  if (!(all > 0)) return;
  const double s = (pu * vv - pv * vw) / all, t = (pv * uu - pu * vw) / all;
  for (uint32_t k = 0; k < 2; ++k)
    uv[k] = (float)((1 - s - t) * (double)m->uvs[triangle][0][k] + s * (double)m->uvs[triangle][1][k] +
                    t * (double)m->uvs[triangle][2][k]);
}

static bool same_wedge(const simplify_mesh* m, uint32_t a, uint32_t b) {
  return m->groups[a / 3] == m->groups[b / 3] && memcmp(m->uvs[a / 3][a % 3], m->uvs[b / 3][b % 3], sizeof m->uvs[0][0]) == 0;
}

static bool has_vertex(const mesh_simplifier* s, uint32_t corner, uint32_t v) {
  return vertex_at(s, corner, 1) == v || vertex_at(s, corner, 2) == v;
}

/* The uv that a corner of u gets at v: that of a dying triangle of the same side of all seams, or else by the map of the largest
 * triangle there, so that those that shared a uv go on to share one. */
static void wedge_uv(const mesh_simplifier* s, uint32_t corner, uint32_t u, uint32_t v, float uv[2]) {
  const simplify_mesh* m = &s->mesh;
  uint32_t widest = corner;
  double most = -1;
  memcpy(uv, m->uvs[corner / 3][corner % 3], 2 * sizeof *uv);
  for (uint32_t c = s->first[u]; c != NONE; c = s->next[c]) {
    if (!same_wedge(m, corner, c)) continue;
    if (has_vertex(s, c, v)) {
      const uint32_t k = vertex_at(s, c, 1) == v ? 1 : 2;
      memcpy(uv, m->uvs[c / 3][(c % 3 + k) % 3], 2 * sizeof *uv);
      return;
    }
    double area[3];
    area_vector(m, corners_of(s, c), area);
    const double size = dot(area, area);
    if (size > most || (size >= most && c < widest)) most = size, widest = c;
  }
  extend_uv(m, widest / 3, m->positions[v], uv);
}

static void remove_corner(mesh_simplifier* s, uint32_t vertex, uint32_t corner) {
  uint32_t* at = &s->first[vertex];
  while (*at != corner) at = &s->next[*at];
  *at = s->next[corner];
}

static void move_vertex(mesh_simplifier* s, uint32_t u, uint32_t v) {
  simplify_mesh* m = &s->mesh;
  /* All new uvs before any changes: each is told from the triangles as they were. */
  uint32_t n = 0;
  for (uint32_t c = s->first[u]; c != NONE; c = s->next[c])
    if (!has_vertex(s, c, v)) wedge_uv(s, c, u, v, s->pending[n++]);
  n = 0;
  for (uint32_t c = s->first[u], after; c != NONE; c = after) {
    after = s->next[c];
    if (has_vertex(s, c, v)) {
      for (uint32_t k = 1; k < 3; ++k) remove_corner(s, vertex_at(s, c, k), c / 3 * 3 + (c % 3 + k) % 3);
      m->corners[c / 3][0] = SIMPLIFY_GONE;
      --s->alive;
      continue;
    }
    m->corners[c / 3][c % 3] = v;
    memcpy(m->uvs[c / 3][c % 3], s->pending[n++], sizeof *s->pending);
    s->next[c] = s->first[v];
    s->first[v] = c;
  }
  s->first[u] = NONE;
  add_quadric(&s->quadrics[v], &s->quadrics[u]);
  heap_remove(s, u);
}

/* --- Setting up. --- */

/* The corner that begins the same edge on the other side, or NONE. */
static uint32_t twin_of(const mesh_simplifier* s, uint32_t corner) {
  const uint32_t from = vertex_at(s, corner, 0), to = vertex_at(s, corner, 1);
  for (uint32_t c = s->first[to]; c != NONE; c = s->next[c])
    if (vertex_at(s, c, 1) == from) return c;
  return NONE;
}

static uint32_t ahead(uint32_t corner) {
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}

/* Across an edge that is not smooth, a plane on the edge at right angles to its triangle. */
static void add_seam(mesh_simplifier* s, uint32_t corner, const double normal[3]) {
  const simplify_mesh* m = &s->mesh;
  const uint32_t twin = twin_of(s, corner);
  const uint32_t differs = m->materials[corner / 3] ^ m->materials[twin / 3];
  const bool material = (differs & SIMPLIFY_MATERIAL) != 0;
  const bool smooth = same_wedge(m, corner, ahead(twin)) && same_wedge(m, ahead(corner), twin);
  if (smooth && differs == 0) return;
  double edge[3], across[3];
  between(m->positions[vertex_at(s, corner, 0)], m->positions[vertex_at(s, corner, 1)], edge);
  const double length2 = dot(edge, edge);
  cross(edge, normal, across);
  const double length = sqrt(dot(across, across));
  if (length == 0) return;
  for (uint32_t a = 0; a < 3; ++a) across[a] /= length;
  const double weight = length2 * (material ? MATERIAL_WEIGHT : smooth ? SHADE_WEIGHT : SEAM_WEIGHT);
  for (uint32_t k = 0; k < 2; ++k) {
    const uint32_t v = vertex_at(s, corner, k);
    add_plane(&s->quadrics[v], across, m->positions[v], weight);
  }
}

static void add_quadrics(mesh_simplifier* s) {
  const simplify_mesh* m = &s->mesh;
  for (uint32_t t = 0; t < m->triangle_count; ++t) {
    double n[3];
    area_vector(m, m->corners[t], n);
    const double length = sqrt(dot(n, n));
    if (length == 0) continue;
    for (uint32_t a = 0; a < 3; ++a) n[a] /= length;
    for (uint32_t k = 0; k < 3; ++k) add_plane(&s->quadrics[m->corners[t][k]], n, m->positions[m->corners[t][0]], 0.5 * length);
    for (uint32_t k = 0; k < 3; ++k) add_seam(s, 3 * t + k, n);
  }
}

/* Whether edges go both ways alike. A mesh that touches itself along an edge within one fan has two edges between the same
 * vertices: these are locked. */
static bool is_closed(mesh_simplifier* s) {
  const simplify_mesh* m = &s->mesh;
  for (uint32_t c = 0; c < 3 * m->triangle_count; ++c) {
    const uint32_t from = vertex_at(s, c, 0), to = vertex_at(s, c, 1);
    uint32_t there = 0, back = 0;
    for (uint32_t other = s->first[from]; other != NONE; other = s->next[other]) {
      there += vertex_at(s, other, 1) == to;
      back += vertex_at(s, other, 2) == to;
    }
    if (there != back || from == to) return false;
    if (there > 1) s->locked[from] = s->locked[to] = 1;
  }
  return true;
}

static bool arrays_create(mesh_simplifier* s) {
  const uint32_t vertices = s->mesh.vertex_count, corners = 3 * s->mesh.triangle_count;
  s->first = scree_rt_allocate(&s->allocator, vertices, sizeof *s->first);
  s->next = scree_rt_allocate(&s->allocator, corners, sizeof *s->next);
  s->quadrics = scree_rt_allocate_zeroed(&s->allocator, vertices, sizeof *s->quadrics);
  s->locked = scree_rt_allocate_zeroed(&s->allocator, vertices, 1);
  s->marks = scree_rt_allocate_zeroed(&s->allocator, vertices, sizeof *s->marks);
  s->target = scree_rt_allocate(&s->allocator, vertices, sizeof *s->target);
  s->cost = scree_rt_allocate_zeroed(&s->allocator, vertices, sizeof *s->cost);
  s->heap = scree_rt_allocate(&s->allocator, vertices, sizeof *s->heap);
  s->slot = scree_rt_allocate(&s->allocator, vertices, sizeof *s->slot);
  s->ring = scree_rt_allocate(&s->allocator, vertices, sizeof *s->ring);
  s->other = scree_rt_allocate(&s->allocator, vertices, sizeof *s->other);
  s->around = scree_rt_allocate(&s->allocator, vertices, sizeof *s->around);
  s->pending = scree_rt_allocate(&s->allocator, vertices, sizeof *s->pending);
  return s->first != NULL && s->next != NULL && s->quadrics != NULL && s->locked != NULL && s->marks != NULL && s->target != NULL &&
         s->cost != NULL && s->heap != NULL && s->slot != NULL && s->ring != NULL && s->other != NULL && s->around != NULL &&
         s->pending != NULL;
}

scree_result mesh_simplifier_create(const simplify_mesh* mesh, const scree_allocator* allocator, mesh_simplifier** out) {
  *out = NULL;
  const scree_allocator from = scree_rt_allocator_or_default(allocator);
  mesh_simplifier* s = scree_rt_allocate_zeroed(&from, 1, sizeof *s);
  if (s == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  s->allocator = from;
  s->mesh = *mesh;
  s->alive = mesh->triangle_count;
  scree_result result = arrays_create(s) ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
  if (result == SCREE_OK) {
    memset(s->first, 255, mesh->vertex_count * sizeof *s->first);
    memset(s->target, 255, mesh->vertex_count * sizeof *s->target);
    memset(s->slot, 255, mesh->vertex_count * sizeof *s->slot);
    for (uint32_t c = 3 * mesh->triangle_count; c-- > 0;) {
      const uint32_t v = vertex_at(s, c, 0);
      s->next[c] = s->first[v];
      s->first[v] = c;
    }
    if (!is_closed(s)) result = SCREE_ERROR_INVALID_ARGUMENT;
  }
  if (result != SCREE_OK) {
    mesh_simplifier_destroy(s);
    return result;
  }
  add_quadrics(s);
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) choose_target(s, v);
  *out = s;
  return SCREE_OK;
}

void mesh_simplifier_destroy(mesh_simplifier* s) {
  if (s == NULL) return;
  const scree_allocator from = s->allocator;
  const uint32_t vertices = s->mesh.vertex_count, corners = 3 * s->mesh.triangle_count;
  scree_rt_release(&from, s->first, vertices, sizeof *s->first);
  scree_rt_release(&from, s->next, corners, sizeof *s->next);
  scree_rt_release(&from, s->quadrics, vertices, sizeof *s->quadrics);
  scree_rt_release(&from, s->locked, vertices, 1);
  scree_rt_release(&from, s->marks, vertices, sizeof *s->marks);
  scree_rt_release(&from, s->target, vertices, sizeof *s->target);
  scree_rt_release(&from, s->cost, vertices, sizeof *s->cost);
  scree_rt_release(&from, s->heap, vertices, sizeof *s->heap);
  scree_rt_release(&from, s->slot, vertices, sizeof *s->slot);
  scree_rt_release(&from, s->ring, vertices, sizeof *s->ring);
  scree_rt_release(&from, s->other, vertices, sizeof *s->other);
  scree_rt_release(&from, s->around, vertices, sizeof *s->around);
  scree_rt_release(&from, s->pending, vertices, sizeof *s->pending);
  scree_rt_release(&from, s, 1, sizeof *s);
}

/* --- Running. --- */

static void collapse(mesh_simplifier* s, uint32_t u, uint32_t v) {
  move_vertex(s, u, v);
  const uint32_t count = find_ring(s, v, s->around);
  choose_target(s, v);
  for (uint32_t i = 0; i < count; ++i) choose_target(s, s->around[i]);
}

uint32_t mesh_simplifier_run(mesh_simplifier* s, uint32_t triangles) {
  while (s->alive > triangles && s->heap_count > 0) {
    const uint32_t u = s->heap[0], v = s->target[u];
    /* What lies farther off may have changed since the target was chosen. */
    if (s->first[v] != NONE && keeps_shape(s, u, v) && keeps_topology(s, u, v))
      collapse(s, u, v);
    else
      choose_target(s, u);
  }
  return s->alive;
}

/* Whether moving u to v changes the surface by less than a step or so, as the planes around u see it. */
static bool is_small_move(const mesh_simplifier* s, uint32_t u, uint32_t v) {
  if (same_place(&s->mesh, u, v)) return true;
  double sum = 0;
  for (uint32_t c = s->first[u]; c != NONE; c = s->next[c]) {
    double n[3];
    area_vector(&s->mesh, corners_of(s, c), n);
    sum += 0.5 * sqrt(dot(n, n));
  }
  return quadric_at(&s->quadrics[u], s->mesh.positions[v]) <= 0.5 * sum && keeps_shape(s, u, v);
}

static bool clean_triangle(mesh_simplifier* s, uint32_t triangle) {
  const uint32_t* c = s->mesh.corners[triangle];
  for (uint32_t pair = 0; pair < 6; ++pair) {
    const uint32_t u = c[pair % 3], v = c[(pair % 3 + (pair < 3 ? 1 : 2)) % 3];
    if (!is_small_move(s, u, v) || !keeps_topology(s, u, v)) continue;
    collapse(s, u, v);
    return true;
  }
  return false;
}

void mesh_simplifier_clean(mesh_simplifier* s) {
  const simplify_mesh* m = &s->mesh;
  bool changed = true;
  for (uint32_t pass = 0; changed && pass < 4; ++pass) {
    changed = false;
    for (uint32_t t = 0; t < m->triangle_count; ++t) {
      if (m->corners[t][0] == SIMPLIFY_GONE) continue;
      double n[3];
      area_vector(m, m->corners[t], n);
      if (dot(n, n) == 0) changed = clean_triangle(s, t) || changed;
    }
  }
}
