/* Shards: a closed triangle mesh, split into the Voronoi cells of seeds. Exact: every shard is a closed polyhedron, both shards of
 * a link have the same polygons, all volumes together are the mesh's. What frost then breaks is in scree/frost.h.
 * Source: Mateos, Carranza, Susin, Argudo 2024, "Simulation of Mechanical Weathering for Modeling Rocky Terrains", section 4.
 *
 * Words of the paper: a cell is the set of points that are nearest to one seed; a shard is a connected piece of the mesh within a
 * cell, so that a cell of a concave mesh may have several; a link is the bond across a piece of surface: an interior link joins two
 * shards, an exterior link is a stretch of the mesh's own surface that faces one direction. The cells graph has shards as nodes and
 * interior links as edges; the links graph joins links whose faces share an edge of a shard.
 *
 * Lengths are in the mesh's own units, metres where weight matters; +Y is up. Everything repeats to the bit on every machine and
 * with any number of threads. Shards are immutable once made and may be read by any number of threads. */
#ifndef SCREE_SHARDS_H
#define SCREE_SHARDS_H

#include "base.h"
#include "support.h"

#ifdef __cplusplus
extern "C" {
#endif

/* --- what is split ---------------------------------------------------------------------------------------------------------- */

/* A closed triangle mesh: each edge used once in each direction. Convex or not, of any number of separate pieces, hollows
 * included; triangles must not cross each other. Vertices are joined by index: weld equal positions first. */
typedef struct scree_solid {
  const double* positions; /* 3 * vertex_count */
  const uint32_t* indices; /* 3 * triangle_count, counter-clockwise from outside */
  const float* uvs;        /* 6 * triangle_count: u, v of each triangle's corners, v down as in packs; NULL = none */
  uint32_t vertex_count, triangle_count;
} scree_solid;

/* A solid whose arrays are owned by it; scree_solid_free gives them back. */
typedef struct scree_solid_memory {
  scree_solid solid;
  void* memory;
  size_t size;
} scree_solid_memory;

/* Says whether a solid can be split. error: may be NULL; names the edge or the triangles, and the place. Returns SCREE_OK,
 * INVALID_ARGUMENT (nothing, an index out of range, inside out), RANGE (not finite, beyond 1e6), NOT_CLOSED (a border, or an edge
 * used twice in one direction: says between which places), UNSUPPORTED (two triangles go through each other, or lie on each other
 * and look the same way: the two of lowest numbers, and where) or OUT_OF_MEMORY. Triangles may touch: in points, along edges, and
 * face to face; surfaces that go through each other along edges alone are not told from these. */
SCREE_API scree_result scree_solid_check(const scree_solid* solid, const scree_allocator* allocator, scree_error* error);

/* A terrain closed by a skirt and a base: heights[width * depth], x fastest then z, `spacing` apart, centred on x = z = 0, down to
 * `base`, which must be below every height. u, v run 0..1 along x and z over the terrain; the skirt has those of its border.
 * Returns SCREE_OK, INVALID_ARGUMENT, RANGE or OUT_OF_MEMORY. */
SCREE_API scree_result scree_solid_from_heights(const float* heights, uint32_t width, uint32_t depth, double spacing, double base,
                                                const scree_allocator* allocator, scree_solid_memory* out, scree_error* error);

/* A support as a solid: its surface where the distance is 0, meshed at `resolution` voxels along the longest side (8..512),
 * manifold whatever the support. Also how a mesh that is not closed or crosses itself is made anew: as a support's callback or
 * scree_solid_remesh. Returns SCREE_OK, INVALID_ARGUMENT (empty, unbounded), RANGE or OUT_OF_MEMORY. */
SCREE_API scree_result scree_solid_from_support(const scree_support* support, uint32_t resolution, const scree_allocator* allocator,
                                                scree_solid_memory* out, scree_error* error);

/* Triangles of any kind, open, crossing, doubled, as a closed solid: what the generalised winding number (Jacobson et al. 2013)
 * says is inside, meshed as above; loses UVs. solid: need not pass scree_solid_check but for indices and numbers. */
SCREE_API scree_result scree_solid_remesh(const scree_solid* solid, uint32_t resolution, const scree_allocator* allocator,
                                          scree_solid_memory* out, scree_error* error);
SCREE_API void scree_solid_free(const scree_allocator* allocator, scree_solid_memory* solid); /* all zero is allowed */

/* --- seeds ------------------------------------------------------------------------------------------------------------------ */

typedef enum scree_seed_kind {
  SCREE_SEEDS_RANDOM = 0,  /* uniform in the solid */
  SCREE_SEEDS_GRID = 1,    /* a grid of cubes, each seed moved by up to `jitter` of half the spacing along each axis */
  SCREE_SEEDS_COLUMNS = 2, /* hexagonal columns: a hexagonal lattice in the plane across `up`, `length` long */
  SCREE_SEEDS_SLABS = 3,   /* layers of the thicknesses of `layers`, each cut by a grid */
  SCREE_SEEDS_POISSON = 4, /* no two nearer than a radius that goes from `spacing` at the lower end of `grade` to `spacing_end` */
  SCREE_SEEDS_POINTS = 5   /* those given */
} scree_seed_kind;

/* Where seeds are. A pattern is laid in its own space, whose y axis is turned to lie along `up`; `stretch` makes cells longer along
 * the pattern's axes, so that lengths below are before stretch. Seeds reach a little beyond the solid where the pattern goes on
 * outside it, so that cells at the surface have the pattern's shape; to have it at all, they must be cut with the same `up` and
 * `stretch` (scree_shards_desc).
 *
 * Columns with joints have upright sides where `length` is small against `spacing`, by a quarter or less, and stretch[1] makes them
 * long: without it, joints at different heights tilt the sides between them. A layer of slabs that has less than about half of its
 * thickness above or below it is cut once more in between, so that all joints are flat and where they should be. */
typedef struct scree_seed_pattern {
  scree_seed_kind kind;
  uint32_t count;       /* RANDOM: seeds; the others, but POINTS: 0 = by spacing, or so many cells by volume, 1..1e6 */
  double spacing;       /* GRID, COLUMNS, SLABS: between seeds; POISSON: the radius at the lower end; > 0 unless count is given */
  double spacing_end;   /* POISSON: the radius at the upper end; 0 = spacing */
  double grade[3];      /* POISSON: the direction along which the radius changes, over the extent of the solid; all zero = up */
  double length;        /* COLUMNS: of a column until a cross joint, before stretch[1], so that joints end up length * stretch[1]
                           apart; each column's are at random heights; 0 = endless */
  const double* layers; /* SLABS: thicknesses from below, repeated; NULL = all `spacing` */
  uint32_t layer_count;
  double jitter;        /* GRID, COLUMNS, SLABS: 0..1 */
  double up[3];         /* where the pattern's y axis lies; all zero = +Y: tilts slabs and columns */
  double stretch[3];    /* cells are so many times as long along the pattern's x, y, z; all zero = 1, 1, 1; 0.01..100 */
  const double* points; /* POINTS: 3 * point_count */
  uint32_t point_count; /* POINTS */
  uint64_t random_seed;
} scree_seed_pattern;

/* Where the seeds of a pattern are. out: 3 doubles a seed, to be freed with scree_seeds_free. Returns SCREE_OK, RANGE,
 * INVALID_ARGUMENT (no seeds) or OUT_OF_MEMORY. */
SCREE_API scree_result scree_seeds_create(const scree_seed_pattern* pattern, const scree_solid* solid,
                                          const scree_allocator* allocator, double** out, uint32_t* count, scree_error* error);
SCREE_API void scree_seeds_free(const scree_allocator* allocator, double* seeds, uint32_t count);

/* --- shards ----------------------------------------------------------------------------------------------------------------- */

typedef struct scree_shards scree_shards;

typedef enum scree_clip {
  SCREE_CLIP_AUTO = 0,  /* walls where the solid is convex and UVs go on evenly over triangles of one plane */
  SCREE_CLIP_WALLS = 1, /* planes of the triangles cut cells: for such solids only */
  SCREE_CLIP_MESH = 2   /* restricted Voronoi diagram with symbolic vertices: for any */
} scree_clip;

typedef struct scree_shards_desc {
  scree_solid solid;   /* copied */
  const double* seeds; /* 3 * seed_count; seeds that coincide or are cocircular are moved, by parts of 1e-6 of their spacing up to a
                          sixtieth */
  uint32_t seed_count; /* 1..1e6; seeds whose cell misses the solid have no shard */
  const double*
      stretch;      /* NULL, or 3: distances are measured with x, y, z divided by these, in the space of `up`: anisotropic cells */
  const double* up; /* NULL = +Y */
  scree_clip clip;
  double
      link_angle; /* exterior links: neighbouring triangles of a shard join where their normals differ by less, radians; 0 = 0.35 */
  scree_jobs jobs;           /* used where walls cut; clipping by mesh runs on the calling thread */
  scree_allocator allocator; /* all zero = malloc and free */
  /* As in scree_bake_desc. May be NULL. */
  bool (*progress)(void* user, const char* stage, double done);
  void* progress_user;
} scree_shards_desc;

/* Splits a solid. Every shard is checked: area vectors sum to 0, no volume is negative, volumes sum to the solid's; where a check
 * fails the seeds are moved, see `seeds`, and all is done again, up to 8 times, each time moved farther.
 * Returns SCREE_OK, INVALID_ARGUMENT, RANGE, NOT_CLOSED, CANCELLED, OUT_OF_MEMORY, or UNSUPPORTED: the solid crosses itself, so
 * that no closed shards exist; the error says where. error: may be NULL. Crossings are looked for only where cells do not fit
 * together, for looking takes about as long as cutting; few seeds can miss one: scree_solid_check does not. */
SCREE_API scree_result scree_shards_create(const scree_shards_desc* desc, scree_shards** out, scree_error* error);
SCREE_API void scree_shards_destroy(scree_shards* shards); /* NULL is allowed */

#define SCREE_NO_SHARD UINT32_MAX

/* A connected piece of a cell. */
typedef struct scree_shard {
  double centroid[3]; /* of its volume */
  double volume;
  uint32_t seed;       /* the cell */
  uint32_t first_link; /* its links are shard_links[first_link] .. [first_link + link_count - 1], rising */
  uint32_t link_count;
} scree_shard;

typedef struct scree_link {
  uint32_t shards[2]; /* [0] < [1] or [1] = SCREE_NO_SHARD: an exterior link */
  double area;
  double normal[3];   /* unit, out of shards[0]: of an exterior link, that of its area vector */
  double centroid[3]; /* of its area */
  uint32_t first_polygon, polygon_count;
} scree_link;

/* One flat piece of a link: a polygon, convex or not, holes joined in by bridges that are walked both ways. */
typedef struct scree_polygon {
  uint32_t first_corner, corner_count; /* counter-clockwise seen from outside shards[0] */
  /* Of the solid, for exterior links; UINT32_MAX for interior ones. Where walls cut, the largest triangle of the polygon's plane:
   * the polygon may reach beyond it, and UVs go on evenly. */
  uint32_t triangle;
} scree_polygon;

/* Everything there is to read; arrays owned by the shards. */
typedef struct scree_shards_view {
  const scree_shard* shards;
  const scree_link* links; /* interior links first, by (shards[0], shards[1]); then exterior links, by shard */
  const scree_polygon* polygons;
  const uint32_t* corners; /* of polygons: vertices */
  const double* vertices;  /* 3 each; polygons that meet share them */
  const uint32_t* shard_links;
  const uint32_t*
      neighbour_first; /* links graph: link_count + 1; neighbours of link l are neighbours[neighbour_first[l]] .., rising */
  const uint32_t* neighbours;
  uint32_t shard_count, link_count, interior_link_count, polygon_count, corner_count, vertex_count;
  double volume;            /* of the solid */
  double mean_link_area;    /* a bar of the paper: over all faces of all shards, an interior link counting twice */
  double min[3], max[3];    /* of the solid */
  scree_clip clip;          /* which way it was made */
  uint32_t attempts;        /* how often seeds had to be moved */
  const scree_solid* solid; /* the copy */
} scree_shards_view;

/* All of the above at once; valid until scree_shards_destroy. */
SCREE_API void scree_shards_get(const scree_shards* shards, scree_shards_view* out);

/* Names the shards: equal for equal ones. */
SCREE_API uint64_t scree_shards_digest(const scree_shards* shards);

/* Vertices of the convex hull of some shards together, for physics: at most `capacity` (>= 4), 3 floats each relative to `origin`.
 * Returns SCREE_OK, INVALID_ARGUMENT (a shard that is not there, an origin that is not finite) or OUT_OF_MEMORY. */
SCREE_API scree_result scree_shards_hull(const scree_shards* shards, const uint32_t* list, uint32_t count, const double origin[3],
                                         float* points, uint32_t capacity, uint32_t* point_count);

#ifdef __cplusplus
}
#endif

#endif
