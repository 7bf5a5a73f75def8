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
  SCREE_SHAPE_ELLIPSOID = 8,
  SCREE_SHAPE_HALF_SPACE = 9, /* all below the plane y = 0; no parameters; unbounded */
  SCREE_SHAPE_TORUS = 10,
  SCREE_SHAPE_EXTRUSION = 11, /* a polygon, upright */
  SCREE_SHAPE_TUBE = 12,      /* along a spline: a pipe, or an upright band such as a wall or a river bank */
  SCREE_SHAPE_BLOBS = 13,     /* metaballs */
  SCREE_SHAPE_PATTERN = 14,   /* the raked ridges of a Zen garden; unbounded */

  SCREE_SHAPE_UNION = 64, /* from here on: shapes made of other shapes */
  SCREE_SHAPE_INTERSECTION = 65,
  SCREE_SHAPE_DIFFERENCE = 66,   /* the first child without all the others: how to write negative shapes */
  SCREE_SHAPE_SMOOTH_UNION = 67, /* polynomial smooth minimum over `blend` metres */
  SCREE_SHAPE_NOISE = 68         /* a child whose surface noise displaces */
} scree_shape_kind;

/* From a shape's own space to its parent's: scale, then rotate, then translate. All zero means identity. */
typedef struct scree_transform {
  float translation[3]; /* metres */
  float rotation[4];    /* unit quaternion x, y, z, w (glTF's order); all zero = none */
  float scale;          /* uniform, > 0; 0 = 1 */
} scree_transform;

/* Signed distances of `count` points in the shape's own space, metres, negative inside; x, y, z and distance have `count` elements,
 * count is at most 64 and points may repeat. Must be a pure function of each point by itself and may be called from several
 * threads. |f(p) - f(q)| <= lipschitz * |p - q| must hold, but for rounding.
 * What is not a number makes no rock appear: there the shape counts as outside, and as inside where a difference takes it away.
 * Infinities are taken as they are. A bound that does not hold gives rocks too few or too many, nothing worse. Debug builds check
 * every call: they tell the support's log what is wrong, or stop the program if it has none. */
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

/* A layer along a terrain: bilinear; vertical distances are scaled down by the slopes around, so that none is too large: near the
 * surface by those next to it, farther away by ever more of them. */
typedef struct scree_heightfield {
  const float* heights;  /* width * depth, row-major, x fastest then z; copied */
  uint32_t width, depth; /* samples, each >= 2 */
  float spacing;         /* between samples, > 0; the field is centred on x = z = 0 */
  float above, below;    /* the layer reaches from the surface + above to the surface - below; above + below > 0 */
} scree_heightfield;

/* A closed triangle mesh: each edge used as often in one direction as in the other, more than once where parts touch along it;
 * volume > 0; overlapping parts unite. Distances are interpolated between the samples of a grid, so that details finer than its
 * cells are rounded off. */
typedef struct scree_mesh {
  const float* positions;  /* 3 * vertex_count; copied */
  const uint32_t* indices; /* 3 * triangle_count, counter-clockwise from outside */
  uint32_t vertex_count, triangle_count;
  uint32_t resolution; /* cells of the distance grid along the longest side, 0 = 128, 8..512 */
} scree_mesh;

/* Distances are exact, or at least never too large and of the right size near the surface. */
typedef struct scree_ellipsoid {
  float radii[3]; /* > 0, the largest at most 1000 times the smallest */
} scree_ellipsoid;

typedef struct scree_torus {
  float radius;      /* of the ring round the Y axis, > 0 */
  float tube_radius; /* > 0 */
} scree_torus;

typedef struct scree_extrusion {
  const float* points;  /* 2 * point_count: x, z of a closed polygon, convex or not, either way round; copied */
  uint32_t point_count; /* 3..1024; inside is where the even-odd rule says */
  float low, high;      /* y, low < high */
} scree_extrusion;

typedef struct scree_tube {
  const float* points;   /* 3 * point_count: the curve runs through them (centripetal Catmull-Rom); copied */
  const float* radii;    /* point_count, > 0: radius of a pipe, half the width of a band; linear between points; copied */
  uint32_t point_count;  /* 2..256 */
  bool closed;           /* the curve returns to its first point */
  uint32_t subdivisions; /* straight pieces between two points, 1..32; 0 = 8 */
  float half_height;     /* 0: a pipe; > 0: an upright band that reaches this far above and below the curve */
} scree_tube;

/* Wyvill's kernels: the sum of (1 - (r / R)^2)^3 over all balls is 1/2 or more inside. A ball alone has its surface at 0.4543 R. */
typedef struct scree_blobs {
  const float* centres; /* 3 * count; copied */
  const float* radii;   /* count: R, where a ball's influence ends, > 0; copied */
  uint32_t count;       /* 1..256 */
} scree_blobs;

typedef enum scree_pattern_kind {
  SCREE_PATTERN_LINES = 0, /* along z */
  SCREE_PATTERN_RINGS = 1, /* round the Y axis, at spacing / 2, 3/2 spacing, ... */
  SCREE_PATTERN_WAVES = 2  /* lines along z that swing in x */
} scree_pattern_kind;

/* Endless parallel ridges, round bars with their axes on the plane y = 0. Cut them to size with an intersection. */
typedef struct scree_pattern {
  scree_pattern_kind kind;
  float spacing;    /* between axes, > 0 */
  float radius;     /* of the bars, > 0 */
  float amplitude;  /* WAVES: of the swing, 0 to 1000 wavelengths, metres; where it bends, bars are a little thicker */
  float wavelength; /* WAVES: along z, > 0 */
} scree_pattern;

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

/* d(p) = child(p) + amplitude * n(p / wavelength), n in [-1, 1]: gradient noise in octaves, each half as high and half as long. */
typedef struct scree_noise {
  uint32_t child;   /* index, greater than this shape's own */
  float amplitude;  /* metres, > 0, at most 1000 wavelengths */
  float wavelength; /* metres, > 0 */
  uint32_t octaves; /* 1..8; 0 = 1 */
  uint32_t seed;
} scree_noise;

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
    scree_ellipsoid ellipsoid;
    scree_torus torus;
    scree_extrusion extrusion;
    scree_tube tube;
    scree_blobs blobs;
    scree_pattern pattern;
    scree_group group; /* UNION, INTERSECTION, DIFFERENCE, SMOOTH_UNION */
    scree_noise noise;
  };
} scree_shape;

typedef struct scree_support_desc {
  const scree_shape* shapes;  /* shape 0 is the root */
  uint32_t shape_count;       /* >= 1 */
  double origin[3];           /* where the root's space lies in the world, metres; keep shapes within some kilometres of it */
  scree_jobs jobs;            /* used while mesh distance grids are built */
  const scree_support* reuse; /* NULL, or an earlier support: grids of meshes and heightfields that are the same are shared with it,
                                 so that moving a shape beside a mesh costs nothing; either may be destroyed first, on any thread.
                                 A grid stays with the allocator it was made with */
  scree_log log;              /* told in debug builds when a callback breaks its promises */
} scree_support_desc;

/* Compiles a support. Everything that `desc` points at is copied, callbacks' user pointers excepted. A mesh of 75,000 triangles at
 * resolution 128 takes about a second of one core; its grid 4 bytes a sample, while it is made 14.
 * Limits: 4096 shapes in the tree, one that is used twice counting twice and a tube once for each straight piece; groups and noise
 * 32 deep; 1e9 metres. Shapes that the root does not reach are checked too.
 * error: may be NULL; says which shape is wrong and how.
 * Returns SCREE_OK, INVALID_ARGUMENT (tree order, NULLs, a mesh that is inside out), RANGE (a number outside its range or not
 * finite), NOT_CLOSED (a mesh with a border; the error names an edge) or OUT_OF_MEMORY. */
SCREE_API scree_result scree_support_create(const scree_support_desc* desc, const scree_allocator* allocator, scree_support** out,
                                            scree_error* error);
SCREE_API void scree_support_destroy(scree_support* support);

/* The world box that holds the support; of no size if nothing can be inside; infinite where the support is unbounded. Thread-safe.
 */
SCREE_API void scree_support_bounds(const scree_support* support, double min[3], double max[3]);

/* The world box outside of which two supports are alike to all who only look at distances within [-level, level], level >= 0: at
 * each point outside, both have the same distance to the bit, or both more than level, or both less than -level. What moving one
 * shape of a tree touches; pass the depth of a shell as level where there is one. Where the trees are built alike, only shapes that
 * differ count; otherwise all do. Callbacks with the same function and user pointer are the same.
 * Returns false if nothing differs. Thread-safe; allocates nothing. */
SCREE_API bool scree_support_changed_bounds(const scree_support* before, const scree_support* after, double level, double min[3],
                                            double max[3]);

/* Signed distances of `count` world points relative to the support's origin, as the queries see them; the slow, plain way.
 * A point's distance does not depend on the others of the call. Allocates nothing, uses 10 KiB of stack. Thread-safe. */
SCREE_API void scree_support_distance(const scree_support* support, const float* x, const float* y, const float* z, float* distance,
                                      uint32_t count);

#ifdef __cplusplus
}
#endif

#endif
