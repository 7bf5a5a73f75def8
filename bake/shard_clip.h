/* What the parts of the restricted Voronoi diagram share: shard_clip.c runs them, shard_clip_surface.c cuts triangles by cells,
 * shard_clip_inside.c says what lies inside, shard_clip_faces.c makes the faces between cells, shard_clip_loops.c puts holes in
 * them.
 *
 * Vertices are what their keys say, never what their coordinates say: a vertex of the mesh; an edge of the mesh and two cells; a
 * triangle and three cells; four cells. Every decision is a sign that is larger than its rounding, or else UNSUPPORTED is returned
 * and the seeds are moved: so all cells agree on what meets what, as in exact arithmetic. Based on: Yan, Levy, Liu, Sun, Wang 2009,
 * "Isotropic remeshing with fast and exact computation of restricted Voronoi diagram". */
#ifndef SCREE_SHARD_CLIP_H
#define SCREE_SHARD_CLIP_H

#include "shard_pieces.h"
#include "voronoi_cell.h"

#define CLIP_NONE UINT32_MAX

/* A vertex where cells cut the mesh. Its index is that of the mesh's vertices and all clip_vertices before it. */
typedef struct clip_vertex {
  uint32_t cells[3]; /* rising; [2] = CLIP_NONE: on an edge of the mesh */
  uint32_t uses;     /* corners of parts: 3 within a triangle, 4 on an edge */
  uint32_t edge_end; /* on an edge: the higher of its ends */
  uint32_t next;     /* clip_vertex of the same edge or triangle, or CLIP_NONE */
  double error;      /* how far off its place may be */
} clip_vertex;

/* A side of a part that lies between two cells, as the lower one's part has it. */
typedef struct clip_segment {
  uint32_t cells[2]; /* rising */
  uint32_t from, to; /* vertices */
} clip_segment;

/* What of a triangle lies in a cell. */
typedef struct clip_part {
  uint32_t cell, triangle, first_corner, corner_count;
} clip_part;

/* A seed seen from another one. */
typedef struct clip_near {
  double to[3], distance2;
  uint32_t seed;
} clip_near;

/* The seeds around one, nearest first: all that are nearer than `reach`. */
typedef struct clip_near_list {
  const clip_near* near;
  uint32_t count;
  double reach2;
} clip_near_list;

/* Memory of lists. A list lies in one page. */
typedef struct clip_near_page {
  struct clip_near_page* before;
  size_t count, capacity;
  clip_near near[];
} clip_near_page;

typedef struct clip_box {
  double min[3], max[3]; /* min > max: nothing */
} clip_box;

typedef struct clip_work {
  const shard_input* input;
  const scree_allocator* allocator;
  voronoi_grid grid;
  double spacing; /* between seeds, about */
  clip_box solid; /* of the mesh */

  clip_vertex* vertices;
  clip_segment* segments;
  clip_part* parts;
  uint32_t vertex_count, segment_count, part_count;
  uint32_t vertex_capacity, segment_capacity, part_capacity;

  clip_near_list* lists; /* of each seed; reach2 = 0: not made yet */
  clip_near_page* page;  /* the last one */

  clip_box* boxes; /* of each seed: of its parts */
} clip_work;

/* Makes room for `needed` elements; keeps `count`. Returns SCREE_OK or OUT_OF_MEMORY. */
scree_result clip_reserve_(const scree_allocator* allocator, void** memory, uint32_t* capacity, uint32_t count, size_t needed,
                           size_t size);
#define clip_reserve(allocator, memory, capacity, count, needed) \
  ((needed) <= *(capacity) ? SCREE_OK : clip_reserve_(allocator, (void**)(memory), capacity, count, needed, sizeof **(memory)))

/* Seeds at least `distance2` around one, sorted. */
scree_result clip_near_find(clip_work* work, uint32_t seed, double distance2);

/* Cuts all triangles: fills vertices, segments, parts, boxes; out->vertices and out->corners. */
scree_result clip_surface(clip_work* work, shard_pieces* out);

/* --- inside ----------------------------------------------------------------------------------------------------------------- */

/* Triangles by where they lie seen from above. */
typedef struct clip_rays {
  const shard_input* input;
  uint32_t size[2];
  double min[2], scale[2];
  uint32_t *first, *triangles;
  size_t triangle_count;
} clip_rays;

scree_result clip_rays_create(const shard_input* input, const clip_box* solid, const scree_allocator* allocator, clip_rays* out);
void clip_rays_free(clip_rays* rays, const scree_allocator* allocator); /* all zero is allowed */

typedef enum clip_place { CLIP_OUTSIDE = 0, CLIP_INSIDE = 1, CLIP_UNSURE = 2, CLIP_CROSSED = 3 } clip_place;

/* CLIP_UNSURE: within rounding of the mesh, or straight above or below an edge; CLIP_CROSSED: inside twice, or inside out. */
clip_place clip_rays_place(const clip_rays* rays, const double point[3]);

/* --- faces ------------------------------------------------------------------------------------------------------------------ */

/* Faces between cells and what of the surface each has: out->pieces, in order. */
scree_result clip_faces(clip_work* work, shard_pieces* out);

/* --- loops ------------------------------------------------------------------------------------------------------------------ */

/* Closed loops of one flat face. */
typedef struct clip_loop {
  uint32_t first, count; /* in corners */
  bool outer;
  uint32_t owner; /* of a hole: the loop around it */
  double area;
} clip_loop;

typedef struct clip_loops {
  uint32_t* corners;   /* names of vertices; a bridge repeats them */
  double (*places)[2]; /* of corners, seen from outside, so that outer loops are counter-clockwise */
  clip_loop* loops;
  uint32_t corner_count, corner_capacity, place_capacity, loop_count, loop_capacity;
} clip_loops;

/* Joins every hole with the loop around it: afterwards only loops with `outer` count. Returns SCREE_OK, OUT_OF_MEMORY, or
 * UNSUPPORTED where a hole lies in no loop. */
scree_result clip_loops_join(clip_loops* loops, const scree_allocator* allocator);
void clip_loops_free(clip_loops* loops, const scree_allocator* allocator);

#endif
