#include "winding_tree.h"

#include <math.h>
#include <string.h>

#include "allocator.h"
#include "vectors.h"

enum { LEAF = 4, DEEPEST = 64 };
static const double pi = 3.14159265358979323846;

#define FAR2 9.0 /* squared distance, in squared radii, from where on a cluster is one dipole */

/* --- angles ----------------------------------------------------------------------------------------------------------------- */

/* 0..1: the angle is halved twice, then its series ends soon. */
static double small_atan(double t) {
  for (int i = 0; i < 2; ++i) t = t / (1 + sqrt(1 + t * t));
  const double t2 = t * t;
  double sum = 0;
  for (int k = 10; k >= 0; --k) sum = 1.0 / (2 * k + 1) - t2 * sum;
  return 4 * t * sum;
}

double repeatable_atan2(double y, double x) {
  const double ax = fabs(x), ay = fabs(y);
  if (!(ax > 0 || ay > 0)) return 0;
  double angle = ay <= ax ? small_atan(ay / ax) : pi / 2 - small_atan(ax / ay);
  if (x < 0) angle = pi - angle;
  return y < 0 ? -angle : angle;
}

/* Van Oosterom, Strackee 1983. */
static double solid_angle(const winding_tree* tree, uint32_t triangle, const double p[3]) {
  double v[3][3], length[3];
  for (int k = 0; k < 3; ++k) {
    const double* q = tree->positions + (size_t)3 * tree->indices[(size_t)3 * triangle + (size_t)k];
    for (int a = 0; a < 3; ++a) v[k][a] = q[a] - p[a];
    length[k] = sqrt(dot(v[k], v[k]));
  }
  const double turn = v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) - v[0][1] * (v[1][0] * v[2][2] - v[1][2] * v[2][0]) +
                      v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0]);
  const double along =
      length[0] * length[1] * length[2] + dot(v[0], v[1]) * length[2] + dot(v[1], v[2]) * length[0] + dot(v[2], v[0]) * length[1];
  return 2 * repeatable_atan2(turn, along);
}

/* --- the tree --------------------------------------------------------------------------------------------------------------- */

static void measure(const winding_tree* tree, winding_node* node, uint32_t first, uint32_t count) {
  double weight = 0, plain[3] = {0, 0, 0};
  memset(node, 0, sizeof *node);
  for (uint32_t i = first; i < first + count; ++i) {
    const uint32_t t = tree->order[i];
    const uint32_t* v = tree->indices + (size_t)3 * t;
    const double *a = tree->positions + (size_t)3 * v[0], *b = tree->positions + (size_t)3 * v[1],
                 *c = tree->positions + (size_t)3 * v[2];
    double area[3], size2 = 0;
    for (int k = 0; k < 3; ++k) {
      const int u = (k + 1) % 3, w = (k + 2) % 3;
      area[k] = ((b[u] - a[u]) * (c[w] - a[w]) - (b[w] - a[w]) * (c[u] - a[u])) / 2;
      size2 += area[k] * area[k];
    }
    const double size = sqrt(size2);
    weight += size;
    for (int k = 0; k < 3; ++k) {
      const double centre = tree->centres[(size_t)3 * t + (size_t)k];
      node->area[k] += area[k];
      node->middle[k] += size * centre;
      plain[k] += centre / count;
    }
  }
  for (int k = 0; k < 3; ++k) node->middle[k] = weight > 0 ? node->middle[k] / weight : plain[k];
  for (uint32_t i = first; i < first + count; ++i)
    for (int k = 0; k < 3; ++k) {
      const double* p = tree->positions + (size_t)3 * tree->indices[(size_t)3 * tree->order[i] + (size_t)k];
      double d2 = 0;
      for (int a = 0; a < 3; ++a) d2 += (p[a] - node->middle[a]) * (p[a] - node->middle[a]);
      if (d2 > node->radius2) node->radius2 = d2;
    }
}

/* Sorts triangles by whether their centres lie below the middle of all, and returns how many do: half of them where that would be
 * none or all, or where the tree grows too deep. */
static uint32_t divide(const winding_tree* tree, uint32_t first, uint32_t count, uint32_t depth) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (uint32_t i = 0; i < count; ++i)
    for (int a = 0; a < 3; ++a) {
      const double x = tree->centres[(size_t)3 * tree->order[first + i] + (size_t)a];
      if (x < low[a]) low[a] = x;
      if (x > high[a]) high[a] = x;
    }
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (high[a] - low[a] > high[axis] - low[axis]) axis = a;
  const double middle = (low[axis] + high[axis]) / 2;
  uint32_t below = 0;
  if (depth < DEEPEST / 2)
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t t = tree->order[first + i];
      if (!(tree->centres[(size_t)3 * t + (size_t)axis] < middle)) continue;
      tree->order[first + i] = tree->order[first + below];
      tree->order[first + below++] = t;
    }
  return below == 0 || below == count ? count / 2 : below;
}

static void build(winding_tree* tree, uint32_t at, uint32_t first, uint32_t count, uint32_t depth) {
  measure(tree, &tree->nodes[at], first, count);
  if (count <= LEAF) {
    tree->nodes[at].first = first;
    tree->nodes[at].count = count;
    return;
  }
  const uint32_t below = divide(tree, first, count, depth), children = tree->node_count;
  tree->node_count += 2;
  tree->nodes[at].first = children;
  build(tree, children, first, below, depth + 1);
  build(tree, children + 1, first + below, count - below, depth + 1);
}

scree_result winding_tree_create(const double* positions, const uint32_t* indices, uint32_t triangle_count,
                                 const scree_allocator* allocator, winding_tree* out) {
  memset(out, 0, sizeof *out);
  out->positions = positions, out->indices = indices;
  out->triangle_count = triangle_count;
  out->nodes = scree_rt_allocate(allocator, (size_t)2 * triangle_count, sizeof *out->nodes);
  out->order = scree_rt_allocate(allocator, triangle_count, sizeof *out->order);
  out->centres = scree_rt_allocate(allocator, (size_t)3 * triangle_count, sizeof *out->centres);
  if (out->nodes == NULL || out->order == NULL || out->centres == NULL) {
    winding_tree_free(out, allocator);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  for (uint32_t t = 0; t < triangle_count; ++t) {
    out->order[t] = t;
    const uint32_t* v = indices + (size_t)3 * t;
    for (size_t a = 0; a < 3; ++a)
      out->centres[(size_t)3 * t + a] =
          (positions[(size_t)3 * v[0] + a] + positions[(size_t)3 * v[1] + a] + positions[(size_t)3 * v[2] + a]) / 3;
  }
  out->node_count = 1;
  build(out, 0, 0, triangle_count, 0);
  return SCREE_OK;
}

void winding_tree_free(winding_tree* tree, const scree_allocator* allocator) {
  scree_rt_release(allocator, tree->nodes, (size_t)2 * tree->triangle_count, sizeof *tree->nodes);
  scree_rt_release(allocator, tree->order, tree->triangle_count, sizeof *tree->order);
  scree_rt_release(allocator, tree->centres, (size_t)3 * tree->triangle_count, sizeof *tree->centres);
  memset(tree, 0, sizeof *tree);
}

double winding_tree_at(const winding_tree* tree, const double p[3]) {
  uint32_t stack[2 * DEEPEST + 8], depth = 0;
  double angle = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const winding_node* node = &tree->nodes[stack[--depth]];
    double to[3], d2 = 0;
    for (int a = 0; a < 3; ++a) {
      to[a] = node->middle[a] - p[a];
      d2 += to[a] * to[a];
    }
    if (d2 > FAR2 * node->radius2)
      angle += dot(to, node->area) / (d2 * sqrt(d2));
    else if (node->count > 0)
      for (uint32_t i = 0; i < node->count; ++i) angle += solid_angle(tree, tree->order[node->first + i], p);
    else
      stack[depth++] = node->first + 1, stack[depth++] = node->first;
  }
  return angle / (4 * pi);
}
