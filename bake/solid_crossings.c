/* Pairs of triangles whose boxes meet, by the tree; then signs of corners against planes, nearly all of which rounding cannot
 * change; what is left is decided as by Devillers, Guigue 2003, "Faster triangle-triangle intersection tests", with open triangles.
 */
#include "solid_crossings.h"

#include <math.h>
#include <string.h>

#include "allocator.h"
#include "orientation.h"
#include "triangle_tree.h"
#include "vectors.h"

/* A triangle made ready for many others. */
typedef struct flat_triangle {
  const double* corners[3];
  double min[3], max[3], normal[3];
  double slack; /* side_of is right beyond it, times the largest difference of coordinates */
  uint32_t vertices[3], number;
} flat_triangle;

typedef struct crossing_search {
  const triangle_tree* tree;
  flat_triangle* triangles; /* in the tree's order */
  solid_crossing found;
} crossing_search;

static void make_ready(const double* positions, const uint32_t* indices, uint32_t number, flat_triangle* out) {
  double edges[2][3], longest = 0;
  out->number = number;
  for (int k = 0; k < 3; ++k) {
    out->vertices[k] = indices[k];
    out->corners[k] = positions + (size_t)3 * indices[k];
  }
  for (int a = 0; a < 3; ++a) {
    const double p = out->corners[0][a], q = out->corners[1][a], r = out->corners[2][a];
    out->min[a] = p < q ? (p < r ? p : r) : (q < r ? q : r);
    out->max[a] = p > q ? (p > r ? p : r) : (q > r ? q : r);
    edges[0][a] = q - p, edges[1][a] = r - p;
    if (out->max[a] - out->min[a] > longest) longest = out->max[a] - out->min[a];
  }
  cross(edges[0], edges[1], out->normal);
  out->slack = 2e-14 * longest * longest; /* six products of three, each with eight roundings of 2^-53, and some to spare */
}

/* 1 where p lies where the triangle's normal points to, -1 on the other side, 0 in its plane. */
static int side_of(const flat_triangle* t, const double p[3]) {
  double sum = 0, most = 0;
  for (int a = 0; a < 3; ++a) {
    const double d = p[a] - t->corners[0][a], size = fabs(d);
    sum += d * t->normal[a];
    if (size > most) most = size;
  }
  if (fabs(sum) > t->slack * most) return sum > 0 ? 1 : -1;
  return orientation_exact(t->corners[0], t->corners[1], t->corners[2], p);
}

/* Sides of all corners of b; false where b does not go through the plane of a. */
static bool goes_through(const flat_triangle* a, const flat_triangle* b, int sides[3], bool* in_plane) {
  int least = 1, most = -1;
  for (int k = 0; k < 3; ++k) {
    const uint32_t v = b->vertices[k];
    const bool shared = v == a->vertices[0] || v == a->vertices[1] || v == a->vertices[2];
    sides[k] = shared ? 0 : side_of(a, b->corners[k]);
    if (sides[k] < least) least = sides[k];
    if (sides[k] > most) most = sides[k];
  }
  *in_plane = least == 0 && most == 0;
  return least < 0 && most > 0;
}

/* Corners turned so that the first lies alone on its side of the other's plane; which side that is. */
static int turn_to_alone(const flat_triangle* t, const int sides[3], const double* out[3]) {
  int alone = 0;
  for (int side = -1; side <= 1; side += 2)
    for (int k = 0; k < 3; ++k)
      if (sides[k] == side && sides[(k + 1) % 3] != side && sides[(k + 2) % 3] != side) alone = k;
  for (int k = 0; k < 3; ++k) out[k] = t->corners[(alone + k) % 3];
  return sides[alone];
}

static void swap_last(const double* corners[3]) {
  const double* last = corners[2];
  corners[2] = corners[1];
  corners[1] = last;
}

/* --- where ------------------------------------------------------------------------------------------------------------------- */

static void minus(const double a[3], const double b[3], double out[3]) {
  for (int k = 0; k < 3; ++k) out[k] = a[k] - b[k];
}

/* The two ends of the stretch in which a triangle, turned to alone, meets the plane of the other, and where along `line` they lie.
 */
static void stretch_of(const double* corners[3], const flat_triangle* plane, const double line[3], double ends[2][3],
                       double at[2]) {
  double d[3], heights[3];
  for (int k = 0; k < 3; ++k) {
    minus(corners[k], plane->corners[0], d);
    heights[k] = dot(d, plane->normal);
  }
  for (int e = 0; e < 2; ++e) {
    const double whole = heights[0] - heights[e + 1], part = whole != 0 ? heights[0] / whole : 0;
    for (int a = 0; a < 3; ++a) ends[e][a] = corners[0][a] + part * (corners[e + 1][a] - corners[0][a]);
    at[e] = dot(ends[e], line);
  }
  if (at[0] <= at[1]) return;
  for (int a = 0; a < 3; ++a) {
    const double swap = ends[0][a];
    ends[0][a] = ends[1][a], ends[1][a] = swap;
  }
  const double swap = at[0];
  at[0] = at[1], at[1] = swap;
}

/* The middle of what two stretches have in common. */
static void middle_of_line(const flat_triangle* a, const double* p[3], const flat_triangle* b, const double* q[3],
                           double place[3]) {
  double line[3], ends[2][2][3], at[2][2];
  cross(a->normal, b->normal, line);
  stretch_of(p, b, line, ends[0], at[0]);
  stretch_of(q, a, line, ends[1], at[1]);
  const int from = at[0][0] > at[1][0] ? 0 : 1, to = at[0][1] < at[1][1] ? 0 : 1;
  for (int k = 0; k < 3; ++k) place[k] = 0.5 * (ends[from][0][k] + ends[to][1][k]);
}

/* The mean of the corners of what two triangles of one plane have in common: one clipped by the other's sides. */
static void middle_of_area(const flat_triangle* a, const flat_triangle* b, double place[3]) {
  double polygon[9][3], clipped[9][3];
  int count = 3;
  for (int k = 0; k < 3; ++k) memcpy(polygon[k], a->corners[k], sizeof polygon[k]);
  for (int side = 0; side < 3; ++side) {
    const double *from = b->corners[side], *to = b->corners[(side + 1) % 3];
    double along[3], inward[3], d[3];
    minus(to, from, along);
    cross(b->normal, along, inward);
    int kept = 0;
    for (int k = 0; k < count && kept < 8; ++k) {
      const double *p = polygon[k], *q = polygon[(k + 1) % count];
      minus(p, from, d);
      const double here = dot(d, inward);
      minus(q, from, d);
      const double there = dot(d, inward);
      if (here >= 0) memcpy(clipped[kept++], p, sizeof clipped[0]);
      if ((here < 0) == (there < 0)) continue;
      for (int c = 0; c < 3; ++c) clipped[kept][c] = p[c] + here / (here - there) * (q[c] - p[c]);
      ++kept;
    }
    if (kept == 0) break; /* rounding: what is left over from the side before will do */
    count = kept;
    memcpy(polygon, clipped, sizeof polygon);
  }
  for (int c = 0; c < 3; ++c) {
    place[c] = 0;
    for (int k = 0; k < count; ++k) place[c] += polygon[k][c] / count;
  }
}

/* --- whether ----------------------------------------------------------------------------------------------------------------- */

static bool is_apart(const double* const a[3], const double* const b[3], int turn, int x, int y) {
  for (int k = 0; k < 3; ++k) {
    bool beyond = true;
    for (int c = 0; c < 3 && beyond; ++c) beyond = turn * orientation_flat(a[k], a[(k + 1) % 3], b[c], x, y) <= 0;
    if (beyond) return true;
  }
  return false;
}

/* Of two triangles of one plane: insides have an area in common, and both look the same way. */
static bool lie_on_each_other(const flat_triangle* a, const flat_triangle* b) {
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (fabs(a->normal[k]) > fabs(a->normal[axis])) axis = k;
  const int x = (axis + 1) % 3, y = (axis + 2) % 3;
  const int turn = orientation_flat(a->corners[0], a->corners[1], a->corners[2], x, y);
  if (turn == 0 || orientation_flat(b->corners[0], b->corners[1], b->corners[2], x, y) != turn) return false;
  return !is_apart(a->corners, b->corners, turn, x, y) && !is_apart(b->corners, a->corners, turn, x, y);
}

static bool triangles_cross(const flat_triangle* a, const flat_triangle* b, double place[3]) {
  int sides_of_b[3], sides_of_a[3];
  bool in_plane;
  if (!goes_through(a, b, sides_of_b, &in_plane)) {
    if (!in_plane || !lie_on_each_other(a, b)) return false;
    if (place != NULL) middle_of_area(a, b, place);
    return true;
  }
  if (!goes_through(b, a, sides_of_a, &in_plane)) return false;
  /* Both alone on the upper side of the other: then two signs compare the ends of their stretches. */
  const double *p[3], *q[3];
  const int side_of_a = turn_to_alone(a, sides_of_a, p), side_of_b = turn_to_alone(b, sides_of_b, q);
  if (side_of_a < 0) swap_last(q);
  if (side_of_b < 0) swap_last(p);
  if (orientation(p[0], p[1], q[0], q[1]) >= 0 || orientation(p[0], p[2], q[2], q[0]) >= 0) return false;
  if (place != NULL) middle_of_line(a, p, b, q, place);
  return true;
}

static bool have_common_edge(const uint32_t a[3], const uint32_t b[3]) {
  int common = 0;
  for (int k = 0; k < 3; ++k) common += a[k] == b[0] || a[k] == b[1] || a[k] == b[2];
  return common > 1;
}

static void look_at(crossing_search* search, const flat_triangle* a, const flat_triangle* b) {
  if (!boxes_meet(a->min, a->max, b->min, b->max) || have_common_edge(a->vertices, b->vertices)) return;
  if (a->number > b->number) {
    const flat_triangle* swap = a;
    a = b;
    b = swap;
  }
  solid_crossing* found = &search->found;
  if (a->number > found->triangles[0] || (a->number == found->triangles[0] && b->number > found->triangles[1])) return;
  double place[3];
  if (!triangles_cross(a, b, place)) return;
  found->triangles[0] = a->number, found->triangles[1] = b->number;
  memcpy(found->place, place, sizeof place);
}

static void look_at_leaves(void* user, const tree_node* one, const tree_node* other) {
  crossing_search* search = user;
  for (uint32_t i = one->first; i < one->first + one->count; ++i)
    for (uint32_t k = one == other ? i + 1 : other->first; k < other->first + other->count; ++k)
      look_at(search, &search->triangles[i], &search->triangles[k]);
}

bool solid_triangles_cross(const double* positions, const uint32_t* a, const uint32_t* b, double place[3]) {
  if (have_common_edge(a, b)) return false;
  flat_triangle first, second;
  make_ready(positions, a, 0, &first);
  make_ready(positions, b, 1, &second);
  return boxes_meet(first.min, first.max, second.min, second.max) && triangles_cross(&first, &second, place);
}

scree_result solid_find_crossing(const double* positions, const uint32_t* indices, uint32_t triangle_count,
                                 const scree_allocator* allocator, solid_crossing* out) {
  *out = (solid_crossing){.triangles = {SCREE_NO_CROSSING, SCREE_NO_CROSSING}};
  const scree_allocator memory = scree_rt_allocator_or_default(allocator);
  triangle_tree tree;
  const scree_result result = triangle_tree_create(positions, indices, triangle_count, &memory, &tree);
  if (result != SCREE_OK) return result;
  crossing_search search = {&tree, scree_rt_allocate(&memory, triangle_count, sizeof *search.triangles), *out};
  const bool enough = search.triangles != NULL || triangle_count == 0;
  if (enough) {
    for (uint32_t i = 0; i < triangle_count; ++i)
      make_ready(positions, indices + (size_t)3 * tree.order[i], tree.order[i], &search.triangles[i]);
    triangle_tree_pairs(&tree, look_at_leaves, &search);
    *out = search.found;
  }
  scree_rt_release(&memory, search.triangles, triangle_count, sizeof *search.triangles);
  triangle_tree_destroy(&tree);
  return enough ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
}
