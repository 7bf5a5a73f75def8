/* A support, compiled: the tree of shapes as a flat program in postfix order, every leaf in the root's space.
 *
 *   union(A, difference(B, C, D))   ->   A  B  C  DIFFERENCE  D  DIFFERENCE  UNION
 *
 * Transforms are folded into the leaves once, in double. A query works on prefixes of no one else's data: it copies the indices of
 * the operations that can still matter in a part of space (uint16_t each) and drops the rest. */
#ifndef SCREE_SUPPORT_PROGRAM_H
#define SCREE_SUPPORT_PROGRAM_H

#include <scree/support.h>

#include "support_height.h"
#include "support_mesh.h"

enum {
  SUPPORT_MAX_OPS = 8192,                      /* of a program, so that uint16_t and fixed scratch on the stack suffice */
  SUPPORT_MAX_NESTING = 32,                    /* groups within groups */
  SUPPORT_MAX_STACK = SUPPORT_MAX_NESTING + 2, /* values alive at once while a program runs; a tube is a union by itself */
  SUPPORT_BATCH = 64,                          /* points evaluated at once, at most */
  SUPPORT_MAX_OCTAVES = 8
};

typedef enum op_kind {
  OP_SPHERE,
  OP_BOX,
  OP_BOX_TURNED,
  OP_CAPSULE,
  OP_CYLINDER,
  OP_CONE,
  OP_HEIGHTFIELD,
  OP_MESH,
  OP_CALLBACK,
  OP_ELLIPSOID,
  OP_HALF_SPACE,
  OP_TORUS,
  OP_EXTRUSION,
  OP_PIPE, /* one straight piece of a tube */
  OP_BAND,
  OP_BLOBS,
  OP_LINES,
  OP_RINGS,
  OP_WAVES,
  OP_UNION, /* the first of the operations on two values */
  OP_INTERSECTION,
  OP_DIFFERENCE,
  OP_SMOOTH_UNION,
  OP_NEGATE, /* the first on one value; only in pruned programs: what is left of a difference without its first side */
  OP_NOISE
} op_kind;

static inline bool op_is_leaf(op_kind kind) {
  return kind < OP_UNION;
}
static inline bool op_is_pair(op_kind kind) {
  return kind >= OP_UNION && kind < OP_NEGATE;
}

/* Edges of a polygon come in chunks: a box round them, then each edge. */
enum { EXTRUSION_CHUNK = 8, EXTRUSION_BOX = 5, EXTRUSION_EDGE = 6 };

/* Balls of a sum of blobs: centre, 1 / R^2 and R. */
enum { BLOB_FLOATS = 5 };

/* From the root's space to a leaf's own: rows * (p - centre). Distances come back times `scale`. */
typedef struct op_frame {
  float centre[3];
  float rows[3][3];
  float scale;
} op_frame;

typedef struct support_op {
  op_kind kind;
  float lipschitz; /* leaves: |f(p) - f(q)| <= lipschitz * |p - q| in the root's space; noise: what it adds to its child's */
  float doubt;     /* leaves: what rounding may do to a value beyond the query's margin */

  /* Which values of this operation can matter to a query that asks only what lies in [low, high] at the root: those in
   * [low - slack_low, high + slack_high], or in [-high - slack_low, -low + slack_high] where `flipped`. */
  bool flipped;
  float slack_low, slack_high;

  /* Leaves: where the distance is <= level lies within this box grown by level * grow on each side, for level >= 0. Infinite where
   * the leaf is unbounded. */
  double min[3], max[3], grow;

  union {
    struct {
      float centre[3], radius;
    } sphere;
    struct {
      op_frame frame; /* scale folded into the lengths */
      float core[3];  /* half extents without the rounding */
      float rounding;
    } box;
    struct {
      float a[3], ab[3], inverse_length2, radius;
    } capsule;
    struct {
      float centre[3], axis[3], radius, half_height;
    } cylinder;
    struct {
      float base[3], axis[3], radius, height, inverse_side2;
    } cone;
    struct {
      op_frame frame;
      const support_height* grid;
      float middle, half; /* the layer is |y - height - middle| <= half */
    } height;
    struct {
      op_frame frame;
      const support_mesh* grid;
    } mesh;
    struct {
      op_frame frame;
      scree_distance_fn distance;
      void* user;
      float min[3], max[3]; /* in the leaf's own space */
      float lipschitz;      /* as it was stated */
      uint32_t shape;       /* for messages */
      const scree_log* log; /* the support's */
    } callback;
    struct {
      op_frame frame;                      /* in units of the largest radius */
      float radii[3], excess[3], smallest; /* excess: radii squared less the smallest's */
    } ellipsoid;
    struct {
      float centre[3], normal[3];
    } plane;
    struct {
      float centre[3], axis[3], radius, tube_radius;
    } torus;
    struct {
      op_frame frame;
      const float* edges; /* in the support's tables */
      uint32_t edge_count;
      float middle, half; /* y */
    } extrusion;
    struct {
      float a[3], axis[3], length, radius, taper, lean; /* radius at a, its loss a metre; see distance_pipe */
    } pipe;
    struct {
      op_frame frame;                             /* centred on one end, scale folded into the lengths */
      float axis[2], length, radius, taper, lean; /* as a pipe's, in x and z */
      float slope, half_height, cosine, shrink;
    } band;
    struct {
      op_frame frame;
      const float* balls; /* in the support's tables */
      uint32_t count;
      float curvature; /* no second derivative of the sum is larger */
      float level;     /* the value where all influence ends */
    } blobs;
    struct {
      op_frame frame; /* scale folded into the lengths */
      float spacing, inverse_spacing, radius;
      float amplitude, inverse_wavelength, steepest, curvature; /* waves: of the swing's derivatives */
    } pattern;
    struct {
      float blend, inverse_blend;
    } smooth;
    struct {
      op_frame frame; /* to wavelengths */
      float amplitude;
      float heights[SUPPORT_MAX_OCTAVES]; /* what each octave is multiplied with; 2.1 times that is more than its range */
      float slope;                        /* of each octave, the same for all */
      uint32_t octaves, seed;
    } noise;
  };
} support_op;

struct scree_support {
  scree_allocator allocator;
  double origin[3];
  double min[3], max[3]; /* root's space; min > max where nothing is inside */
  scree_log log;
  double magnitude;  /* no coordinate or length of the program is larger; scales the margins for rounding */
  support_op* ops;   /* op_count + 1: the last is OP_NEGATE */
  uint16_t* program; /* op_count: 0, 1, 2, ... */
  uint32_t op_count, op_capacity;
  support_height** heights; /* one for each heightfield shape */
  uint32_t height_count;
  support_mesh** meshes; /* one for each mesh shape */
  uint32_t mesh_count;
  float* tables; /* of extrusions and blobs */
  size_t table_length;
};

/* The box, in the root's space, that holds every point whose distance is <= level, level >= 0. Returns false if there is none. */
bool scree_rt_support_level_bounds(const scree_support* support, double level, double min[3], double max[3]);

/* Distances in the order of the program; count points in SUPPORT_BATCH-sized arrays. Plain kernel. */
void scree_rt_support_evaluate_plain(const support_op* ops, const uint16_t* program, uint32_t length, const float* x,
                                     const float* y, const float* z, float* distance, uint32_t count);

/* How fast the support's distance can change, whatever the tree. */
double scree_rt_support_lipschitz(const scree_support* support);

/* Checks every shape, names what is wrong. What is in the arrays of a heightfield or mesh is checked apart, so that it need not be
 * where a grid is there already. */
scree_result scree_rt_support_check(const scree_support_desc* desc, scree_error* error);
scree_result scree_rt_support_check_content(const scree_shape* shape, uint32_t index, scree_error* error);

#endif
