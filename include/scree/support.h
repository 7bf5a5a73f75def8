/* Supports: shapes, given as signed distances, that decide which rocks of a field exist. A support is a tree of shapes,
 * described by an array of scree_shape and compiled once; it is immutable and may be shared between threads and fields. */
#ifndef SCREE_SUPPORT_H
#define SCREE_SUPPORT_H

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct scree_support scree_support;

typedef enum scree_shape_kind {
  SCREE_SHAPE_SPHERE = 0,
  SCREE_SHAPE_BOX = 1,
  SCREE_SHAPE_CAPSULE = 2,
  SCREE_SHAPE_CYLINDER = 3,
  SCREE_SHAPE_CONE = 4,
  SCREE_SHAPE_HEIGHTFIELD = 5,
  SCREE_SHAPE_MESH = 6,
  SCREE_SHAPE_CALLBACK = 7,
  SCREE_SHAPE_UNION = 8,
  SCREE_SHAPE_INTERSECTION = 9,
  SCREE_SHAPE_DIFFERENCE = 10,  /* the first child without all the others */
  SCREE_SHAPE_SMOOTH_UNION = 11 /* polynomial smooth minimum over `blend` metres */
} scree_shape_kind;

/* From a shape's own space to its parent's: scale, then rotate, then translate. All zero means identity. */
typedef struct scree_transform {
  float translation[3]; /* metres */
  float rotation[4];    /* unit quaternion x, y, z, w (glTF's order); all zero = none */
  float scale;          /* uniform, > 0; 0 = 1 */
} scree_transform;

/* Signed distances of `count` points in the shape's own space, metres, negative inside; x, y, z and distance have `count` elements,
 * count is at most 64 and points may repeat. Must be a pure function of each point by itself and may be called from several
 * threads. |f(p) - f(q)| <= lipschitz * |p - q| must hold, but for rounding. */
typedef void (*scree_distance_fn)(void* user, const float* x, const float* y, const float* z, float* distance, uint32_t count);

/* The parameters of each kind, in the shape's own space. Lengths in metres. */
typedef struct scree_sphere {
  float radius; /* > 0 */
} scree_sphere;

typedef struct scree_box {
  float half[3];  /* half extents, > 0 */
  float rounding; /* of edges, >= 0 and <= the smallest half */
} scree_box;

typedef struct scree_capsule {
  float a[3], b[3]; /* ends of the segment */
  float radius;     /* > 0 */
} scree_capsule;

typedef struct scree_cylinder {
  float radius, half_height; /* along Y, both > 0 */
} scree_cylinder;

typedef struct scree_cone {
  float radius, height; /* base on the plane y = 0, apex at y = height, both > 0 */
} scree_cone;

/* A layer along a terrain: bilinear; distances are scaled down by the steepest slope anywhere, so that none is too large. */
typedef struct scree_heightfield {
  const float* heights;  /* width * depth, row-major, x fastest then z; copied */
  uint32_t width, depth; /* samples, each >= 2 */
  float spacing;         /* between samples, > 0; the field is centred on x = z = 0 */
  float above, below;    /* the layer reaches from the surface + above to the surface - below; above + below > 0 */
} scree_heightfield;

/* A closed triangle mesh: each edge used once in each direction; volume > 0; overlapping parts unite. Distances are interpolated
 * between the samples of a grid, so that details finer than its cells are rounded off. */
typedef struct scree_mesh {
  const float* positions;  /* 3 * vertex_count; copied */
  const uint32_t* indices; /* 3 * triangle_count, counter-clockwise from outside */
  uint32_t vertex_count, triangle_count;
  uint32_t resolution; /* cells of the distance grid along the longest side, 0 = 128, 8..512 */
} scree_mesh;

typedef struct scree_callback {
  scree_distance_fn distance;
  void* user;           /* must outlive the support */
  float lipschitz;      /* >= the true bound; 0 = 1 */
  float min[3], max[3]; /* box of all points with distance <= 0; outside, a distance counts as at least that to the box */
} scree_callback;

typedef struct scree_group {
  const uint32_t* children; /* indices into scree_support_desc.shapes, each greater than this shape's own index */
  uint32_t child_count;     /* >= 1 */
  float blend;              /* SMOOTH_UNION: > 0 */
} scree_group;

typedef struct scree_shape {
  scree_shape_kind kind;
  scree_transform transform;
  union { /* by kind */
    scree_sphere sphere;
    scree_box box;
    scree_capsule capsule;
    scree_cylinder cylinder;
    scree_cone cone;
    scree_heightfield heightfield;
    scree_mesh mesh;
    scree_callback callback;
    scree_group group; /* UNION, INTERSECTION, DIFFERENCE, SMOOTH_UNION */
  };
} scree_shape;

typedef struct scree_support_desc {
  const scree_shape* shapes; /* shape 0 is the root */
  uint32_t shape_count;      /* >= 1 */
  double origin[3];          /* where the root's space lies in the world, metres; keep shapes within some kilometres of it */
  scree_jobs jobs;           /* used while mesh distance grids are built */
} scree_support_desc;

/* Compiles a support. Everything that `desc` points at is copied, callbacks' user pointers excepted. A mesh of 75,000 triangles at
 * resolution 128 takes about a second of one core; its grid 4 bytes a sample, while it is made 14.
 * Limits: 4096 shapes in the tree, one that is used twice counting twice; groups 32 deep; 1e9 metres. Shapes that the root does not
 * reach are checked too.
 * error: may be NULL; says which shape is wrong and how.
 * Returns SCREE_OK, INVALID_ARGUMENT (tree order, NULLs, a mesh that is inside out), RANGE (a number outside its range or not
 * finite), NOT_CLOSED (a mesh with a border; the error names an edge) or OUT_OF_MEMORY. */
SCREE_API scree_result scree_support_create(const scree_support_desc* desc, const scree_allocator* allocator, scree_support** out,
                                            scree_error* error);
SCREE_API void scree_support_destroy(scree_support* support);

/* The world box that holds the support; of no size if nothing can be inside. Thread-safe. */
SCREE_API void scree_support_bounds(const scree_support* support, double min[3], double max[3]);

/* Signed distances of `count` world points relative to the support's origin, as the queries see them; the slow, plain way.
 * A point's distance does not depend on the others of the call. Allocates nothing, uses 10 KiB of stack. Thread-safe. */
SCREE_API void scree_support_distance(const scree_support* support, const float* x, const float* y, const float* z, float* distance,
                                      uint32_t count);

#ifdef __cplusplus
}
#endif

#endif
