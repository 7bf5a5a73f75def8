#include "triangle_tree.h"

#include <math.h>
#include <string.h>

#include "allocator.h"
#include "vectors.h"

enum { LEAF = 4, DEPTH = 64 };

/* --- Building: halves by the middle of the longest side, or by number where that parts nothing. --- */

static double middle_of(const triangle_tree* tree, uint32_t triangle, uint32_t axis) {
  const uint32_t* c = tree->indices + (size_t)3 * triangle;
  const double a = tree->positions[(size_t)3 * c[0] + axis], b = tree->positions[(size_t)3 * c[1] + axis],
               d = tree->positions[(size_t)3 * c[2] + axis];
  const double low = a < b ? (a < d ? a : d) : (b < d ? b : d), high = a > b ? (a > d ? a : d) : (b > d ? b : d);
  return 0.5 * (low + high);
}

static void set_box(const triangle_tree* tree, tree_node* node, uint32_t first, uint32_t count) {
  for (uint32_t a = 0; a < 3; ++a) node->min[a] = INFINITY, node->max[a] = -INFINITY;
  for (uint32_t i = first; i < first + count; ++i)
    for (uint32_t k = 0; k < 3; ++k)
      for (uint32_t a = 0; a < 3; ++a) {
        const double p = tree->positions[(size_t)3 * tree->indices[(size_t)3 * tree->order[i] + k] + a];
        if (p < node->min[a]) node->min[a] = p;
        if (p > node->max[a]) node->max[a] = p;
      }
}

/* Triangles that lie below the middle of the longest side first; how many these are. */
static uint32_t part(triangle_tree* tree, uint32_t first, uint32_t count) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (uint32_t i = first; i < first + count; ++i)
    for (uint32_t a = 0; a < 3; ++a) {
      const double m = middle_of(tree, tree->order[i], a);
      if (m < low[a]) low[a] = m;
      if (m > high[a]) high[a] = m;
    }
  uint32_t axis = 0;
  for (uint32_t a = 1; a < 3; ++a)
    if (high[a] - low[a] > high[axis] - low[axis]) axis = a;
  const double plane = 0.5 * (low[axis] + high[axis]);
  uint32_t below = first;
  for (uint32_t i = first; i < first + count; ++i) {
    const uint32_t triangle = tree->order[i];
    if (middle_of(tree, triangle, axis) >= plane) continue;
    tree->order[i] = tree->order[below];
    tree->order[below++] = triangle;
  }
  return below - first;
}

typedef struct build_step {
  uint32_t node, first, count, depth;
} build_step;

static void build(triangle_tree* tree) {
  build_step stack[2 * DEPTH];
  uint32_t held = 0;
  tree->node_count = 1;
  stack[held++] = (build_step){0, 0, tree->triangle_count, 0};
  while (held > 0) {
    const build_step step = stack[--held];
    tree_node* node = &tree->nodes[step.node];
    set_box(tree, node, step.first, step.count);
    node->first = step.first;
    node->count = step.count;
    if (step.count <= LEAF) continue;
    uint32_t below = step.depth < DEPTH / 2 ? part(tree, step.first, step.count) : 0;
    if (below == 0 || below == step.count) below = step.count / 2;
    node->first = tree->node_count;
    node->count = 0;
    tree->node_count += 2;
    stack[held++] = (build_step){node->first + 1, step.first + below, step.count - below, step.depth + 1};
    stack[held++] = (build_step){node->first, step.first, below, step.depth + 1};
  }
}

scree_result triangle_tree_create(const double* positions, const uint32_t* indices, uint32_t triangle_count,
                                  const scree_allocator* allocator, triangle_tree* out) {
  *out = (triangle_tree){scree_rt_allocator_or_default(allocator), positions, indices, triangle_count, NULL, NULL, 0, 0};
  if (triangle_count == 0) return SCREE_OK;
  out->node_capacity = 2 * triangle_count;
  out->nodes = scree_rt_allocate(&out->allocator, out->node_capacity, sizeof *out->nodes);
  out->order = scree_rt_allocate(&out->allocator, triangle_count, sizeof *out->order);
  if (out->nodes == NULL || out->order == NULL) {
    triangle_tree_destroy(out);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  for (uint32_t t = 0; t < triangle_count; ++t) out->order[t] = t;
  build(out);
  return SCREE_OK;
}

void triangle_tree_destroy(triangle_tree* tree) {
  if (tree->allocator.release == NULL) return;
  scree_rt_release(&tree->allocator, tree->nodes, tree->node_capacity, sizeof *tree->nodes);
  scree_rt_release(&tree->allocator, tree->order, tree->triangle_count, sizeof *tree->order);
  memset(tree, 0, sizeof *tree);
}

/* --- Rays. --- */

static void minus(const double a[3], const double b[3], double out[3]) {
  for (uint32_t k = 0; k < 3; ++k) out[k] = a[k] - b[k];
}

/* Moeller and Trumbore, 1997; both sides, borders included. */
static bool meets_triangle(const triangle_tree* tree, uint32_t triangle, const double start[3], const double direction[3],
                           double nearest, double farthest) {
  const uint32_t* c = tree->indices + (size_t)3 * triangle;
  const double* a = tree->positions + (size_t)3 * c[0];
  double u[3], v[3], across[3], off[3], side[3];
  minus(tree->positions + (size_t)3 * c[1], a, u);
  minus(tree->positions + (size_t)3 * c[2], a, v);
  cross(direction, v, across);
  const double determinant = dot(u, across);
  if (determinant == 0) return false;
  minus(start, a, off);
  const double s = dot(off, across) / determinant;
  if (s < 0 || s > 1) return false;
  cross(off, u, side);
  const double t = dot(direction, side) / determinant;
  if (t < 0 || s + t > 1) return false;
  const double at = dot(v, side) / determinant;
  return at >= nearest && at <= farthest;
}

static bool meets_box(const tree_node* node, const double start[3], const double inverse[3], double nearest, double farthest) {
  for (uint32_t a = 0; a < 3; ++a) {
    const double x = (node->min[a] - start[a]) * inverse[a], y = (node->max[a] - start[a]) * inverse[a];
    const double in = x < y ? x : y, out = x < y ? y : x;
    if (in > nearest) nearest = in;
    if (out < farthest) farthest = out;
  }
  /* A little more, so that rounding loses no triangle that lies in a face of its box. */
  return nearest <= farthest + 1e-9 * (farthest < 0 ? -farthest : farthest);
}

bool triangle_tree_meets(const triangle_tree* tree, const double start[3], const double direction[3], double nearest,
                         double farthest) {
  if (tree->triangle_count == 0) return false;
  double inverse[3];
  for (uint32_t a = 0; a < 3; ++a) inverse[a] = 1 / (direction[a] < 1e-30 && direction[a] > -1e-30 ? 1e-30 : direction[a]);
  uint32_t stack[2 * DEPTH], held = 0;
  stack[held++] = 0;
  while (held > 0) {
    const tree_node* node = &tree->nodes[stack[--held]];
    if (!meets_box(node, start, inverse, nearest, farthest)) continue;
    for (uint32_t i = node->first; i < node->first + node->count; ++i)
      if (meets_triangle(tree, tree->order[i], start, direction, nearest, farthest)) return true;
    if (node->count > 0) continue;
    stack[held++] = node->first + 1;
    stack[held++] = node->first;
  }
  return false;
}

/* --- Distances. --- */

/* Ericson, Real-Time Collision Detection, 2004, section 5.1.5. */
double distance2_to_triangle(const double p[3], const double a[3], const double b[3], const double c[3]) {
  double ab[3], ac[3], ap[3], rest[3];
  minus(b, a, ab);
  minus(c, a, ac);
  minus(p, a, ap);
  /* Barycentric coordinates by regions: a, edge ab, b, edge ac, c, edge bc, inside. */
  const double d1 = dot(ab, ap), d2 = dot(ac, ap), bb = dot(ab, ab), cc = dot(ac, ac), bc = dot(ab, ac);
  const double d3 = d1 - bb, d4 = d2 - bc, d5 = d1 - bc, d6 = d2 - cc;
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  double s = 0, t = 0; /* nearest point a + s ab + t ac */
  if (d1 <= 0 && d2 <= 0) {
  } else if (d3 >= 0 && d4 <= d3) {
    s = 1;
  } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    s = d1 > d3 ? d1 / (d1 - d3) : 0;
  } else if (d6 >= 0 && d5 <= d6) {
    t = 1;
  } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    t = d2 > d6 ? d2 / (d2 - d6) : 0;
  } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double whole = (d4 - d3) + (d5 - d6);
    t = whole > 0 ? (d4 - d3) / whole : 0;
    s = 1 - t;
  } else {
    const double inverse = va + vb + vc != 0 ? 1 / (va + vb + vc) : 0;
    s = vb * inverse, t = vc * inverse;
    /* Only rounding in a flat triangle leads out of it; any point of it will do then. */
    s = s > 0 ? (s < 1 ? s : 1) : 0;
    t = t > 0 ? (t < 1 - s ? t : 1 - s) : 0;
  }
  for (uint32_t k = 0; k < 3; ++k) rest[k] = ap[k] - s * ab[k] - t * ac[k];
  return dot(rest, rest);
}

static double box_distance2(const tree_node* node, const double p[3]) {
  double sum = 0;
  for (uint32_t a = 0; a < 3; ++a) {
    const double d = p[a] < node->min[a] ? node->min[a] - p[a] : p[a] > node->max[a] ? p[a] - node->max[a] : 0;
    sum += d * d;
  }
  return sum;
}

double triangle_tree_distance2(const triangle_tree* tree, const double point[3]) {
  double least = INFINITY;
  if (tree->triangle_count == 0) return least;
  struct {
    uint32_t node;
    double distance2;
  } stack[2 * DEPTH];
  uint32_t held = 0;
  stack[held].node = 0;
  stack[held++].distance2 = box_distance2(&tree->nodes[0], point);
  while (held > 0) {
    --held;
    if (stack[held].distance2 >= least) continue;
    const tree_node* node = &tree->nodes[stack[held].node];
    for (uint32_t i = node->first; i < node->first + node->count; ++i) {
      const uint32_t* c = tree->indices + (size_t)3 * tree->order[i];
      const double d2 = distance2_to_triangle(point, tree->positions + (size_t)3 * c[0], tree->positions + (size_t)3 * c[1],
                                              tree->positions + (size_t)3 * c[2]);
      if (d2 < least) least = d2;
    }
    if (node->count > 0) continue;
    const double a = box_distance2(&tree->nodes[node->first], point), b = box_distance2(&tree->nodes[node->first + 1], point);
    const uint32_t near = a <= b ? 0 : 1;
    stack[held].node = node->first + 1 - near;
    stack[held++].distance2 = near == 0 ? b : a;
    stack[held].node = node->first + near;
    stack[held++].distance2 = near == 0 ? a : b;
  }
  return least;
}

/* --- Pairs. --- */

void triangle_tree_pairs(const triangle_tree* tree, void (*visit)(void* user, const tree_node* one, const tree_node* other),
                         void* user) {
  if (tree->triangle_count == 0) return;
  struct {
    uint32_t one, other;
  } stack[4 * DEPTH]; /* each step goes one level down on one side or on both, and leaves two pairs behind at most */
  uint32_t held = 0;
  stack[held].one = 0, stack[held++].other = 0;
  while (held > 0) {
    const uint32_t one = stack[--held].one, other = stack[held].other;
    const tree_node *a = &tree->nodes[one], *b = &tree->nodes[other];
    if (!boxes_meet(a->min, a->max, b->min, b->max)) continue;
    if (a->count > 0 && b->count > 0) {
      visit(user, a, b);
    } else if (one == other) {
      stack[held].one = a->first, stack[held++].other = a->first + 1;
      stack[held].one = a->first + 1, stack[held++].other = a->first + 1;
      stack[held].one = a->first, stack[held++].other = a->first;
    } else if (b->count > 0 || (a->count == 0 && one < other)) { /* the lower number is nearer to the root */
      stack[held].one = a->first + 1, stack[held++].other = other;
      stack[held].one = a->first, stack[held++].other = other;
    } else {
      stack[held].one = one, stack[held++].other = b->first + 1;
      stack[held].one = one, stack[held++].other = b->first;
    }
  }
}
