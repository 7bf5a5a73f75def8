/* Triangles in a tree of boxes: whether a ray meets one, and how far the nearest is. The answers do not depend on the tree. */
#ifndef SCREE_TRIANGLE_TREE_H
#define SCREE_TRIANGLE_TREE_H

#include <scree/base.h>

typedef struct tree_node {
  double min[3], max[3];
  uint32_t first; /* leaf: of its triangles in `order`; else: its children are nodes first and first + 1 */
  uint32_t count; /* of triangles; 0 = not a leaf */
} tree_node;

typedef struct triangle_tree {
  scree_allocator allocator;
  const double* positions; /* 3 each, the caller's */
  const uint32_t* indices; /* 3 a triangle, the caller's */
  uint32_t triangle_count;
  tree_node* nodes;
  uint32_t* order; /* triangles */
  uint32_t node_count, node_capacity;
} triangle_tree;

/* Returns SCREE_OK or OUT_OF_MEMORY. */
scree_result triangle_tree_create(const double* positions, const uint32_t* indices, uint32_t triangle_count,
                                  const scree_allocator* allocator, triangle_tree* out);
void triangle_tree_destroy(triangle_tree* tree); /* all zero is allowed */

/* Whether start + t * direction meets a triangle for some t in nearest..farthest. */
bool triangle_tree_meets(const triangle_tree* tree, const double start[3], const double direction[3], double nearest,
                         double farthest);

/* Squared distance to the nearest triangle; INFINITY without any. */
double triangle_tree_distance2(const triangle_tree* tree, const double point[3]);

/* Calls `visit` once for every two leaves whose boxes meet, a leaf and itself included. */
void triangle_tree_pairs(const triangle_tree* tree, void (*visit)(void* user, const tree_node* one, const tree_node* other),
                         void* user);

/* Squared distance from p to triangle abc. */
double distance2_to_triangle(const double p[3], const double a[3], const double b[3], const double c[3]);

#endif
