/* The generalised winding number of any triangles: solid angle over 4 pi, exact near by, and far away that of one dipole for a
 * whole cluster of triangles. Based on: Jacobson, Kavan, Sorkine-Hornung 2013, "Robust Inside-Outside Segmentation using
 * Generalized Winding Numbers"; Barill, Dickson, Schmidt, Levin, Jacobson 2018, "Fast Winding Numbers for Soups and Clouds". */
#ifndef SCREE_WINDING_TREE_H
#define SCREE_WINDING_TREE_H

#include <scree/base.h>

typedef struct winding_node {
  double middle[3]; /* centroid of the triangles, by area */
  double area[3];   /* sum of their area vectors */
  double radius2;   /* of a ball round the middle that holds them, squared */
  uint32_t first;   /* leaf: of its triangles in `order`; else: its children are nodes first and first + 1 */
  uint32_t count;   /* of triangles; 0 = not a leaf */
} winding_node;

typedef struct winding_tree {
  const double* positions; /* 3 each, the caller's */
  const uint32_t* indices; /* 3 a triangle, the caller's */
  winding_node* nodes;
  uint32_t* order;
  double* centres; /* of triangles, 3 each; scratch */
  uint32_t triangle_count, node_count;
} winding_tree;

/* Returns SCREE_OK or OUT_OF_MEMORY. triangle_count: 1 .. 2^30. */
scree_result winding_tree_create(const double* positions, const uint32_t* indices, uint32_t triangle_count,
                                 const scree_allocator* allocator, winding_tree* out);
void winding_tree_free(winding_tree* tree, const scree_allocator* allocator); /* all zero is allowed */

/* 1 inside, 0 outside, in between where triangles leave holes; repeats to the bit everywhere. Thread-safe. */
double winding_tree_at(const winding_tree* tree, const double p[3]);

/* atan2 in operations that repeat, to 1e-12. */
double repeatable_atan2(double y, double x);

#endif
