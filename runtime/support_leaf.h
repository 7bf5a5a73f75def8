/* Leaves of a support's program: from a shape in its own space to an operation in the root's. */
#ifndef SCREE_SUPPORT_LEAF_H
#define SCREE_SUPPORT_LEAF_H

#include "support_program.h"

/* From a shape's own space to the root's. */
typedef struct support_frame {
  double origin[3];
  double turn[3][3]; /* columns are the shape's axes */
  double scale;
} support_frame;

/* What a shape was given when its parts were built. */
typedef struct support_part {
  support_height* height;
  support_mesh* mesh;
  const float* table;
  support_key key; /* of a grid, and its place among the support's */
  uint32_t place;
} support_part;

void scree_rt_support_to_root(const support_frame* frame, const double p[3], double out[3]);

/* Lengths of the leaf are in the root's metres if `scaled`, in its own otherwise; then distances come back times the scale. */
op_frame scree_rt_support_op_frame(const support_frame* frame, bool scaled);

/* The root's box round a box of the leaf's own space, which may be infinite. */
void scree_rt_support_set_bounds(support_op* op, const support_frame* frame, const double low[3], const double high[3]);

/* Fills kind, parameters, bounds, lipschitz, doubt and grow of an operation that is all zero. Returns what the largest coordinate
 * or length is beyond those of its box and of the frame's origin. */
double scree_rt_support_compile_leaf(support_op* op, const scree_shape* shape, const support_frame* frame,
                                     const support_part* part);

/* Floats that a shape needs in the support's tables, and what goes there. 0 for most. */
size_t scree_rt_support_table_length(const scree_shape* shape);
size_t scree_rt_support_edges_length(size_t edges); /* of an extrusion */
void scree_rt_support_table_fill(const scree_shape* shape, float* table);

/* Tubes: straight pieces between points of the curve. */
typedef struct support_piece {
  double ends[2][3], radii[2];
} support_piece;

uint32_t scree_rt_support_piece_count(const scree_tube* tube);
void scree_rt_support_piece(const scree_tube* tube, uint32_t index, support_piece* out);
void scree_rt_support_compile_piece(support_op* op, const support_piece* piece, double half_height, const support_frame* frame);

#endif
