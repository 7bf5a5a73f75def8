#include <math.h>
#include <string.h>

#include "shard_clip.h"

/* A face between two cells is the convex polygon of the Voronoi diagram, cut by the segments that triangles left on it. Segments
 * join end to end: rings, and paths from border to border. Going around the border counter-clockwise, from where a path ends the
 * border is inside the solid until the next path starts:
 *
 *        +----S=====E----+      S, E: a path starts, ends; === inside
 *        |     \   /     |
 *        |      path     |
 *        +---------------+
 *
 * The cell is made within a box around its parts of the surface. A side of the box that the solid does not touch changes nothing,
 * as no surface is beyond; one that it does touch makes the box too small. */

/* Marks a name that is a corner of the cell at hand instead of a vertex. */
#define CORNER UINT32_C(0x80000000)

/* A vertex where four cells meet; the lowest of them makes it. */
typedef struct four_cells {
  uint32_t others[3], uses;
} four_cells;

typedef struct border_end {
  double along, error;
  uint32_t side, path;
  bool start;
} border_end;

typedef struct border_path {
  uint32_t first, count; /* in clip_loops.corners */
  uint32_t end;          /* row of border_end */
  bool done;
} border_path;

typedef struct face_piece {
  uint32_t neighbour, first, count;
  bool bridged;
} face_piece;

typedef enum cell_state { CELL_OUTSIDE = 0, CELL_INSIDE = 1, CELL_CUT = 2 } cell_state;

typedef struct face_maker {
  clip_work* work;
  shard_pieces* out;
  clip_rays rays;
  voronoi_cell cell;
  double rounding; /* of coordinates */

  uint8_t* states; /* of each seed */
  uint32_t *part_first, *part_order, *segment_first, *segment_order;
  uint32_t* next; /* of each vertex: the segment of the face at hand that starts there */
  uint32_t vertex_count;

  four_cells* corners;                 /* of out->vertices from vertex_count on */
  uint32_t *corner_first, *corner_end; /* of each seed that is the lowest of four */
  uint32_t* known;                     /* of each corner of the cell at hand: in `corners` */
  uint32_t corner_count, corner_capacity, known_capacity;

  clip_loops loops; /* of the face at hand */
  uint32_t* path_corners;
  border_end* ends;
  border_path* paths;
  uint32_t path_corner_capacity, end_capacity, path_capacity;
  uint32_t path_corner_count, end_count, path_count;

  uint32_t* names; /* of the cell at hand */
  face_piece* pieces;
  uint32_t name_count, piece_count, name_capacity, piece_capacity;
  bool touched; /* the box was too small */
} face_maker;

/* --- What is inside. --- */

static scree_result place_of(const face_maker* f, const double at[3], bool* inside, bool* sure) {
  const clip_box* solid = &f->work->solid;
  *inside = false;
  *sure = true;
  for (int axis = 0; axis < 3; ++axis)
    if (at[axis] < solid->min[axis] || at[axis] > solid->max[axis]) return SCREE_OK;
  const clip_place place = clip_rays_place(&f->rays, at);
  *sure = place != CLIP_UNSURE;
  *inside = place == CLIP_INSIDE;
  return place == CLIP_CROSSED ? SCREE_ERROR_UNSUPPORTED : SCREE_OK;
}

static scree_result find_states(face_maker* f) {
  clip_work* work = f->work;
  for (uint32_t seed = 0; seed < work->input->seed_count; ++seed) {
    const double* at = &work->input->seeds[3 * (size_t)seed];
    if (f->part_first[seed] < f->part_first[seed + 1]) {
      f->states[seed] = CELL_CUT;
      continue;
    }
    bool inside, sure;
    scree_result result = place_of(f, at, &inside, &sure);
    if (result != SCREE_OK) return result;
    if (!sure) {
      if (work->lists[seed].reach2 == 0) result = clip_near_find(work, seed, 0);
      if (result != SCREE_OK) return result;
      /* Nowhere is the surface nearer than half the way to the nearest seed, but straight below an edge there may be doubt. */
      for (uint32_t k = 0; !sure && k < work->lists[seed].count && k < 16; ++k) {
        const clip_near* near = &work->lists[seed].near[k];
        const double share = 0.3 * sqrt(work->lists[seed].near[0].distance2 / near->distance2);
        double by[3];
        for (int axis = 0; axis < 3; ++axis) by[axis] = at[axis] + share * near->to[axis];
        result = place_of(f, by, &inside, &sure);
        if (result != SCREE_OK) return result;
      }
      if (!sure) return SCREE_ERROR_UNSUPPORTED;
    }
    f->states[seed] = inside ? CELL_INSIDE : CELL_OUTSIDE;
  }
  return SCREE_OK;
}

static void corner_place(const face_maker* f, const voronoi_face* face, uint32_t k, double out[3]) {
  const double* at = f->cell.positions[f->cell.indices[face->first_index + k % face->count]];
  for (int axis = 0; axis < 3; ++axis) out[axis] = f->cell.origin[axis] + at[axis];
}

/* Whether a face that no triangle cuts is inside the solid; or, with `border`, whether the border of a face is. */
static scree_result face_place(const face_maker* f, const voronoi_face* face, bool border, bool* inside) {
  double middle[3] = {0, 0, 0}, at[3];
  for (uint32_t k = 0; k < face->count; ++k) {
    corner_place(f, face, k, at);
    for (int axis = 0; axis < 3; ++axis) middle[axis] += at[axis] / face->count;
  }
  for (uint32_t k = 0; k < 2 * face->count; ++k) {
    if (border) {
      double after[3];
      corner_place(f, face, k, at);
      corner_place(f, face, k + 1, after);
      const double share = k < face->count ? 0.5 : 0.3;
      for (int axis = 0; axis < 3; ++axis) at[axis] += share * (after[axis] - at[axis]);
    } else {
      corner_place(f, face, k, at);
      const double share = k == 0 ? 0 : k < face->count ? 0.4 : 0.7;
      for (int axis = 0; axis < 3; ++axis) at[axis] = middle[axis] + share * (at[axis] - middle[axis]);
    }
    bool sure;
    const scree_result result = place_of(f, at, inside, &sure);
    if (result != SCREE_OK || sure) return result;
  }
  return SCREE_ERROR_UNSUPPORTED;
}

/* --- Loops of one face. --- */

static scree_result add_loop_corner(face_maker* f, uint32_t name) {
  clip_loops* l = &f->loops;
  const scree_allocator* allocator = f->work->allocator;
  scree_result result = clip_reserve(allocator, &l->corners, &l->corner_capacity, l->corner_count, (size_t)l->corner_count + 1);
  if (result == SCREE_OK)
    result = clip_reserve(allocator, &l->places, &l->place_capacity, l->corner_count, (size_t)l->corner_count + 1);
  if (result == SCREE_OK) l->corners[l->corner_count++] = name;
  return result;
}

/* A corner of the cell, where the solid is. */
static scree_result add_cell_corner(face_maker* f, const voronoi_face* face, uint32_t k) {
  const uint32_t corner = f->cell.indices[face->first_index + k % face->count];
  for (int p = 0; p < 3; ++p)
    if (f->cell.planes[f->cell.corners[corner].planes[p]].neighbour >= VORONOI_WALL) f->touched = true;
  return add_loop_corner(f, CORNER | corner);
}

static scree_result begin_loop(face_maker* f, bool outer) {
  clip_loops* l = &f->loops;
  const scree_result result =
      clip_reserve(f->work->allocator, &l->loops, &l->loop_capacity, l->loop_count, (size_t)l->loop_count + 1);
  if (result == SCREE_OK) l->loops[l->loop_count++] = (clip_loop){.first = l->corner_count, .outer = outer};
  return result;
}

static void end_loop(face_maker* f) {
  clip_loop* loop = &f->loops.loops[f->loops.loop_count - 1];
  loop->count = f->loops.corner_count - loop->first;
}

static scree_result add_border(face_maker* f, const voronoi_face* face) {
  scree_result result = begin_loop(f, true);
  for (uint32_t k = 0; result == SCREE_OK && k < face->count; ++k) result = add_cell_corner(f, face, k);
  if (result == SCREE_OK) end_loop(f);
  return result;
}

static const clip_vertex* clip_vertex_of(const face_maker* f, uint32_t vertex) {
  return &f->work->vertices[vertex - f->work->input->vertex_count];
}

static bool on_border(const face_maker* f, uint32_t vertex) {
  return clip_vertex_of(f, vertex)->cells[2] != CLIP_NONE;
}

/* Where on the border a path starts or ends. */
static scree_result add_end(face_maker* f, const voronoi_face* face, uint32_t vertex, bool start, uint32_t path) {
  const voronoi_cell* cell = &f->cell;
  const clip_vertex* v = clip_vertex_of(f, vertex);
  uint32_t third = CLIP_NONE;
  for (int k = 0; k < 3; ++k)
    if (v->cells[k] != cell->seed && v->cells[k] != face->neighbour) third = v->cells[k];
  for (uint32_t side = 0; side < face->count; ++side) {
    const uint32_t a = cell->indices[face->first_index + side], b = cell->indices[face->first_index + (side + 1) % face->count];
    bool here = false;
    for (int p = 0; p < 3; ++p) {
      const uint32_t plane = cell->corners[a].planes[p];
      if (cell->planes[plane].neighbour != third) continue;
      for (int q = 0; q < 3; ++q) here = here || cell->corners[b].planes[q] == plane;
    }
    if (!here) continue;
    const double* at = &f->out->vertices[3 * (size_t)vertex];
    double along = 0, length2 = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double d = cell->positions[b][axis] - cell->positions[a][axis];
      along += d * (at[axis] - cell->origin[axis] - cell->positions[a][axis]);
      length2 += d * d;
    }
    if (!(length2 > 0)) return SCREE_ERROR_UNSUPPORTED;
    const scree_result result =
        clip_reserve(f->work->allocator, &f->ends, &f->end_capacity, f->end_count, (size_t)f->end_count + 1);
    if (result != SCREE_OK) return result;
    uint32_t k = f->end_count++;
    const border_end end = {along / sqrt(length2), v->error + f->rounding, side, path, start};
    for (; k > 0 && (f->ends[k - 1].side > side || (f->ends[k - 1].side == side && f->ends[k - 1].along > end.along)); --k)
      f->ends[k] = f->ends[k - 1];
    f->ends[k] = end;
    return SCREE_OK;
  }
  return SCREE_ERROR_UNSUPPORTED;
}

static bool are_tied(const border_end* a, const border_end* b) {
  return a->side == b->side && b->along - a->along <= a->error + b->error;
}

/* Whether the first end along the border has to be the start of a path: whether the border is inside before it. */
static scree_result first_is_start(const face_maker* f, const voronoi_face* face, bool* start) {
  for (uint32_t k = 0; k < f->end_count; ++k) {
    const bool tied =
        (k > 0 && are_tied(&f->ends[k - 1], &f->ends[k])) || (k + 1 < f->end_count && are_tied(&f->ends[k], &f->ends[k + 1]));
    *start = f->ends[k].start != (k % 2 == 1);
    if (!tied) return SCREE_OK;
  }
  for (uint32_t k = 0; k < face->count; ++k) {
    double at[3];
    bool inside, sure;
    corner_place(f, face, k, at);
    const scree_result result = place_of(f, at, &inside, &sure);
    if (result != SCREE_OK) return result;
    uint32_t before = 0;
    while (before < f->end_count && f->ends[before].side < k) ++before;
    *start = inside != (before % 2 == 1);
    if (sure) return SCREE_OK;
  }
  return SCREE_ERROR_UNSUPPORTED;
}

/* Along a border starts and ends take turns. So they do where two are at one place, as parts of a solid that touch face to face
 * make them: what comes first there follows from the others. */
static scree_result order_ends(face_maker* f, const voronoi_face* face) {
  if (f->end_count == 0) return SCREE_OK;
  bool start;
  const scree_result result = first_is_start(f, face, &start);
  if (result != SCREE_OK) return result;
  for (uint32_t k = 0; k < f->end_count; ++k, start = !start) {
    border_end* end = &f->ends[k];
    const bool tied = k + 1 < f->end_count && are_tied(&end[0], &end[1]);
    if (tied && ((k > 0 && are_tied(&end[-1], &end[0])) || (k + 2 < f->end_count && are_tied(&end[1], &end[2]))))
      return SCREE_ERROR_UNSUPPORTED;
    if (tied && end->start != start) {
      const border_end other = end[0];
      end[0] = end[1];
      end[1] = other;
    }
    if (end->start != start) return SCREE_ERROR_UNSUPPORTED;
    if (!end->start) f->paths[end->path].end = k;
  }
  return SCREE_OK;
}

static scree_result add_path_corner(face_maker* f, uint32_t vertex) {
  const scree_result result = clip_reserve(f->work->allocator, &f->path_corners, &f->path_corner_capacity, f->path_corner_count,
                                           (size_t)f->path_corner_count + 1);
  if (result == SCREE_OK) f->path_corners[f->path_corner_count++] = vertex;
  return result;
}

static scree_result add_paths(face_maker* f, const voronoi_face* face, const uint32_t* segments, uint32_t count) {
  const clip_segment* all = f->work->segments;
  f->path_count = f->path_corner_count = f->end_count = 0;
  for (uint32_t k = 0; k < count; ++k) {
    if (!on_border(f, all[segments[k]].to)) continue;
    scree_result result = clip_reserve(f->work->allocator, &f->paths, &f->path_capacity, f->path_count, (size_t)f->path_count + 1);
    if (result != SCREE_OK) return result;
    border_path* path = &f->paths[f->path_count];
    *path = (border_path){.first = f->path_corner_count};
    uint32_t at = all[segments[k]].to;
    result = add_end(f, face, at, true, f->path_count);
    if (result == SCREE_OK) result = add_path_corner(f, at);
    while (result == SCREE_OK) {
      const uint32_t segment = f->next[at];
      if (segment == CLIP_NONE) return SCREE_ERROR_UNSUPPORTED;
      f->next[at] = CLIP_NONE;
      at = all[segment].from;
      result = add_path_corner(f, at);
      if (on_border(f, at)) break;
    }
    if (result == SCREE_OK) result = add_end(f, face, at, false, f->path_count);
    if (result != SCREE_OK) return result;
    path->count = f->path_corner_count - path->first;
    ++f->path_count;
  }
  const scree_result ordered = order_ends(f, face);
  if (ordered != SCREE_OK) return ordered;
  for (uint32_t k = 0; k < f->path_count; ++k) {
    if (f->paths[k].done) continue;
    scree_result result = begin_loop(f, true);
    for (uint32_t p = k; result == SCREE_OK && !f->paths[p].done;) {
      border_path* path = &f->paths[p];
      path->done = true;
      for (uint32_t c = 0; result == SCREE_OK && c < path->count; ++c)
        result = add_loop_corner(f, f->path_corners[path->first + c]);
      const uint32_t after = path->end + 1 < f->end_count ? path->end + 1 : 0;
      const uint32_t last = f->ends[after].side + (after == 0 ? face->count : 0);
      for (uint32_t side = f->ends[path->end].side + 1; result == SCREE_OK && side <= last; ++side)
        result = add_cell_corner(f, face, side);
      p = f->ends[after].path;
    }
    if (result != SCREE_OK) return result;
    end_loop(f);
  }
  return SCREE_OK;
}

static scree_result add_rings(face_maker* f, const uint32_t* segments, uint32_t count, uint32_t* rings) {
  const clip_segment* all = f->work->segments;
  for (uint32_t k = 0; k < count; ++k) {
    const uint32_t start = all[segments[k]].to;
    if (f->next[start] == CLIP_NONE) continue;
    scree_result result = begin_loop(f, false);
    for (uint32_t at = start; result == SCREE_OK;) {
      const uint32_t segment = f->next[at];
      if (segment == CLIP_NONE) return SCREE_ERROR_UNSUPPORTED;
      f->next[at] = CLIP_NONE;
      result = add_loop_corner(f, at);
      at = all[segment].from;
      if (at == start) break;
    }
    if (result != SCREE_OK) return result;
    end_loop(f);
    ++*rings;
  }
  return SCREE_OK;
}

/* Places of all corners, seen from outside, and areas; says of rings whether they are holes. */
static void place_loops(face_maker* f, const voronoi_face* face, uint32_t first_ring, uint32_t rings) {
  const double* normal = f->cell.planes[face->plane].normal;
  int drop = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (fabs(normal[axis]) > fabs(normal[drop])) drop = axis;
  const int u = (drop + (normal[drop] > 0 ? 1 : 2)) % 3, v = (drop + (normal[drop] > 0 ? 2 : 1)) % 3;
  clip_loops* l = &f->loops;
  for (uint32_t k = 0; k < l->corner_count; ++k) {
    const bool corner = (l->corners[k] & CORNER) != 0;
    const double* at = corner ? f->cell.positions[l->corners[k] & ~CORNER] : &f->out->vertices[3 * (size_t)l->corners[k]];
    l->places[k][0] = at[u] - (corner ? 0 : f->cell.origin[u]);
    l->places[k][1] = at[v] - (corner ? 0 : f->cell.origin[v]);
  }
  for (uint32_t k = 0; k < l->loop_count; ++k) {
    clip_loop* loop = &l->loops[k];
    const double(*p)[2] = (const double(*)[2])l->places + loop->first;
    loop->area = 0;
    for (uint32_t c = 1; c + 1 < loop->count; ++c)
      loop->area += (p[c][0] - p[0][0]) * (p[c + 1][1] - p[0][1]) - (p[c][1] - p[0][1]) * (p[c + 1][0] - p[0][0]);
    if (k >= first_ring && k < first_ring + rings) loop->outer = loop->area > 0;
  }
}

static scree_result add_piece(face_maker* f, const voronoi_face* face, const clip_loop* loop, uint32_t plain_count) {
  const scree_allocator* allocator = f->work->allocator;
  scree_result result = clip_reserve(allocator, &f->pieces, &f->piece_capacity, f->piece_count, (size_t)f->piece_count + 1);
  if (result == SCREE_OK)
    result = clip_reserve(allocator, &f->names, &f->name_capacity, f->name_count, (size_t)f->name_count + loop->count);
  if (result != SCREE_OK) return result;
  f->pieces[f->piece_count++] = (face_piece){face->neighbour, f->name_count, loop->count, loop->first >= plain_count};
  memcpy(&f->names[f->name_count], &f->loops.corners[loop->first], loop->count * sizeof *f->names);
  f->name_count += loop->count;
  return SCREE_OK;
}

static scree_result make_face(face_maker* f, const voronoi_face* face, const uint32_t* segments, uint32_t count) {
  f->loops.corner_count = f->loops.loop_count = 0;
  scree_result result = SCREE_OK;
  if (count == 0) {
    bool inside = f->states[f->cell.seed] == CELL_INSIDE || f->states[face->neighbour] == CELL_INSIDE;
    if (!inside && f->states[face->neighbour] == CELL_CUT) result = face_place(f, face, false, &inside);
    if (result == SCREE_OK && inside) result = add_border(f, face);
  } else {
    bool clash = false;
    for (uint32_t k = 0; k < count; ++k) {
      uint32_t* next = &f->next[f->work->segments[segments[k]].to];
      clash = clash || *next != CLIP_NONE;
      *next = segments[k];
    }
    if (!clash) result = add_paths(f, face, segments, count);
    const uint32_t first_ring = f->loops.loop_count;
    uint32_t rings = 0;
    if (!clash && result == SCREE_OK) result = add_rings(f, segments, count, &rings);
    for (uint32_t k = 0; k < count; ++k) f->next[f->work->segments[segments[k]].to] = CLIP_NONE;
    if (clash) return SCREE_ERROR_UNSUPPORTED;
    bool inside = false;
    if (result == SCREE_OK && first_ring == 0) result = face_place(f, face, true, &inside);
    if (result == SCREE_OK && inside) result = add_border(f, face);
    if (result == SCREE_OK && rings > 0) place_loops(f, face, first_ring, rings);
    const uint32_t plain_count = f->loops.corner_count;
    if (result == SCREE_OK && rings > 0) result = clip_loops_join(&f->loops, f->work->allocator);
    for (uint32_t k = 0; result == SCREE_OK && k < f->loops.loop_count; ++k)
      if (f->loops.loops[k].outer) result = add_piece(f, face, &f->loops.loops[k], plain_count);
    return result;
  }
  if (result == SCREE_OK && f->loops.loop_count > 0) result = add_piece(f, face, &f->loops.loops[0], f->loops.corner_count);
  return result;
}

/* --- Cells. --- */

static scree_result add_corner(face_maker* f, uint32_t corner, const uint32_t key[4], uint32_t* out) {
  const scree_allocator* allocator = f->work->allocator;
  shard_pieces* pieces = f->out;
  if (pieces->vertex_count >= CORNER) return SCREE_ERROR_OUT_OF_MEMORY;
  scree_result result = clip_reserve(allocator, &f->corners, &f->corner_capacity, f->corner_count, (size_t)f->corner_count + 1);
  if (result == SCREE_OK && pieces->vertex_count == pieces->vertex_capacity)
    result = clip_reserve_(allocator, (void**)&pieces->vertices, &pieces->vertex_capacity, pieces->vertex_count,
                           (size_t)pieces->vertex_count + 1, 3 * sizeof(double));
  if (result != SCREE_OK) return result;
  double* at = &pieces->vertices[3 * (size_t)pieces->vertex_count++];
  for (int axis = 0; axis < 3; ++axis) at[axis] = f->cell.origin[axis] + f->cell.positions[corner][axis];
  *out = f->corner_count++;
  f->corners[*out] = (four_cells){{key[1], key[2], key[3]}, 0};
  return SCREE_OK;
}

/* The vertex of a corner of the cell: cells come by rising seed, so that the lowest of four makes it and the others find it. */
static scree_result vertex_of_corner(face_maker* f, uint32_t corner, bool again, uint32_t* vertex) {
  uint32_t at = f->known[corner];
  if (at == CLIP_NONE) {
    uint32_t key[4];
    voronoi_cell_key(&f->cell, corner, key);
    if (key[0] == f->cell.seed) {
      const scree_result result = add_corner(f, corner, key, &at);
      if (result != SCREE_OK) return result;
    } else {
      const uint32_t end = f->corner_end[key[0]];
      for (at = f->corner_first[key[0]]; at < end; ++at) {
        const uint32_t* others = f->corners[at].others;
        if (others[0] == key[1] && others[1] == key[2] && others[2] == key[3]) break;
      }
      if (at == end) return SCREE_ERROR_UNSUPPORTED; /* the two cells do not see the same corners */
    }
    f->known[corner] = at;
  }
  if (!again) ++f->corners[at].uses;
  *vertex = f->vertex_count + at;
  return SCREE_OK;
}

/* Hands the faces of the cell at hand over. */
static scree_result keep_cell(face_maker* f) {
  const scree_allocator* allocator = f->work->allocator;
  shard_pieces* out = f->out;
  scree_result result =
      clip_reserve(allocator, &out->pieces, &out->piece_capacity, out->piece_count, (size_t)out->piece_count + f->piece_count);
  if (result == SCREE_OK)
    result =
        clip_reserve(allocator, &out->corners, &out->corner_capacity, out->corner_count, (size_t)out->corner_count + f->name_count);
  if (result == SCREE_OK) result = clip_reserve(allocator, &f->known, &f->known_capacity, 0, f->cell.corner_count);
  if (result != SCREE_OK) return result;
  for (uint32_t k = 0; k < f->cell.corner_count; ++k) f->known[k] = CLIP_NONE;
  f->corner_first[f->cell.seed] = f->corner_count;
  for (uint32_t p = 0; p < f->piece_count; ++p) {
    const face_piece* piece = &f->pieces[p];
    const uint32_t* names = &f->names[piece->first];
    out->pieces[out->piece_count++] = (shard_piece){{f->cell.seed, piece->neighbour}, CLIP_NONE, out->corner_count, piece->count};
    for (uint32_t k = 0; k < piece->count; ++k) {
      uint32_t vertex = names[k];
      if (vertex & CORNER) {
        bool again = false;
        for (uint32_t b = 0; piece->bridged && b < k; ++b) again = again || names[b] == names[k];
        result = vertex_of_corner(f, vertex & ~CORNER, again, &vertex);
        if (result != SCREE_OK) return result;
      }
      out->corners[out->corner_count++] = vertex;
    }
  }
  f->corner_end[f->cell.seed] = f->corner_count;
  return SCREE_OK;
}

static scree_result make_faces_within(face_maker* f, uint32_t seed, const clip_box* box) {
  clip_work* work = f->work;
  voronoi_bounds bounds = {.wall_count = 0};
  memcpy(bounds.min, box->min, sizeof bounds.min);
  memcpy(bounds.max, box->max, sizeof bounds.max);
  f->touched = false;
  f->piece_count = f->name_count = 0;
  scree_result result = voronoi_cell_make(&f->cell, &work->grid, seed, &bounds, work->allocator);
  if (result != SCREE_OK) return result;
  /* No surface crosses the sides of the box: each is inside or outside as a whole. */
  for (uint32_t k = f->cell.face_count; k-- > 0 && f->cell.faces[k].neighbour >= VORONOI_WALL;) {
    bool inside = f->states[seed] == CELL_INSIDE;
    if (!inside) result = face_place(f, &f->cell.faces[k], false, &inside);
    f->touched = f->touched || inside;
    if (result != SCREE_OK || f->touched) return result;
  }
  const uint32_t* segments = f->segment_order;
  uint32_t at = f->segment_first[seed];
  const uint32_t end = f->segment_first[seed + 1];
  for (uint32_t k = 0; k < f->cell.face_count && !f->touched; ++k) {
    const voronoi_face* face = &f->cell.faces[k];
    if (face->neighbour >= VORONOI_WALL || face->neighbour < seed) continue;
    const uint32_t first = at;
    while (at < end && work->segments[segments[at]].cells[1] == face->neighbour) ++at;
    result = make_face(f, face, &segments[first], at - first);
    if (result != SCREE_OK) return result;
  }
  return f->touched || at == end ? SCREE_OK : SCREE_ERROR_UNSUPPORTED;
}

static scree_result make_cell(face_maker* f, uint32_t seed) {
  clip_work* work = f->work;
  const double* at = &work->input->seeds[3 * (size_t)seed];
  /* About as large as a cell: rather once more than a cell cut by what it would never reach. */
  clip_box box = work->boxes[seed];
  double margin = 1.6 * work->spacing;
  if (f->states[seed] == CELL_CUT && work->lists[seed].count > 0) {
    const clip_near_list* list = &work->lists[seed];
    margin = sqrt(list->near[list->count > 8 ? 8 : list->count - 1].distance2);
  }
  for (int axis = 0; axis < 3; ++axis) {
    box.min[axis] = (at[axis] < box.min[axis] ? at[axis] : box.min[axis]) - margin;
    box.max[axis] = (at[axis] > box.max[axis] ? at[axis] : box.max[axis]) + margin;
  }
  for (;;) {
    const scree_result result = make_faces_within(f, seed, &box);
    if (result != SCREE_OK) return result;
    if (!f->touched) return keep_cell(f);
    bool all = true;
    for (int axis = 0; axis < 3; ++axis) {
      all = all && box.min[axis] < work->solid.min[axis] && box.max[axis] > work->solid.max[axis];
      const double length = box.max[axis] - box.min[axis];
      box.min[axis] -= length;
      box.max[axis] += length;
    }
    if (all) return SCREE_ERROR_UNSUPPORTED;
  }
}

static scree_result add_parts(face_maker* f, uint32_t seed) {
  shard_pieces* out = f->out;
  const uint32_t first = f->part_first[seed], end = f->part_first[seed + 1];
  const scree_result result = clip_reserve(f->work->allocator, &out->pieces, &out->piece_capacity, out->piece_count,
                                           (size_t)out->piece_count + (end - first));
  if (result != SCREE_OK) return result;
  for (uint32_t k = first; k < end; ++k) {
    const clip_part* part = &f->work->parts[f->part_order[k]];
    out->pieces[out->piece_count++] = (shard_piece){{seed, PIECE_OUTSIDE}, part->triangle, part->first_corner, part->corner_count};
  }
  return SCREE_OK;
}

/* --- All of it. --- */

/* By cell, and segments by their other cell too; otherwise as they came. */
static void sort_into_cells(face_maker* f) {
  const clip_work* work = f->work;
  const uint32_t seed_count = work->input->seed_count;
  for (uint32_t k = 0; k < work->part_count; ++k) ++f->part_first[work->parts[k].cell];
  for (uint32_t k = 0; k < work->segment_count; ++k) ++f->segment_first[work->segments[k].cells[0]];
  for (uint32_t k = 1; k <= seed_count; ++k) {
    f->part_first[k] += f->part_first[k - 1];
    f->segment_first[k] += f->segment_first[k - 1];
  }
  for (uint32_t k = work->part_count; k-- > 0;) f->part_order[--f->part_first[work->parts[k].cell]] = k;
  for (uint32_t k = work->segment_count; k-- > 0;) {
    const uint32_t first = --f->segment_first[work->segments[k].cells[0]];
    f->segment_order[first] = k;
  }
  for (uint32_t seed = 0; seed < seed_count; ++seed) {
    uint32_t* order = &f->segment_order[f->segment_first[seed]];
    const uint32_t count = f->segment_first[seed + 1] - f->segment_first[seed];
    for (uint32_t gap = count; gap > 1;) {
      gap = gap > 3 ? gap * 4 / 9 : 1;
      for (uint32_t i = gap; i < count; ++i) {
        const uint32_t one = order[i], key = work->segments[one].cells[1];
        uint32_t k = i;
        for (; k >= gap; k -= gap) {
          const uint32_t other = order[k - gap], other_key = work->segments[other].cells[1];
          if (other_key < key || (other_key == key && other < one)) break;
          order[k] = other;
        }
        order[k] = one;
      }
    }
  }
}

static scree_result make_all(face_maker* f) {
  clip_work* work = f->work;
  sort_into_cells(f);
  scree_result result = find_states(f);
  for (uint32_t seed = 0; result == SCREE_OK && seed < work->input->seed_count; ++seed) {
    if (f->states[seed] == CELL_OUTSIDE) continue;
    result = make_cell(f, seed);
    if (result == SCREE_OK) result = add_parts(f, seed);
  }
  /* A place where four cells meet within the solid is a corner of six faces. */
  for (uint32_t k = 0; result == SCREE_OK && k < f->corner_count; ++k)
    if (f->corners[k].uses != 6) result = SCREE_ERROR_UNSUPPORTED;
  return result;
}

scree_result clip_faces(clip_work* work, shard_pieces* out) {
  const scree_allocator* allocator = work->allocator;
  const uint32_t seed_count = work->input->seed_count;
  face_maker f = {.work = work, .out = out, .vertex_count = out->vertex_count};
  for (int axis = 0; axis < 3; ++axis) {
    const double low = fabs(work->solid.min[axis]), high = fabs(work->solid.max[axis]), most = low > high ? low : high;
    if (1e-15 * most > f.rounding) f.rounding = 1e-15 * most;
  }
  f.states = scree_rt_allocate(allocator, seed_count, sizeof *f.states);
  f.part_first = scree_rt_allocate_zeroed(allocator, (size_t)seed_count + 1, sizeof(uint32_t));
  f.segment_first = scree_rt_allocate_zeroed(allocator, (size_t)seed_count + 1, sizeof(uint32_t));
  f.part_order = scree_rt_allocate(allocator, (size_t)work->part_count + 1, sizeof(uint32_t));
  f.segment_order = scree_rt_allocate(allocator, (size_t)work->segment_count + 1, sizeof(uint32_t));
  f.next = scree_rt_allocate(allocator, f.vertex_count, sizeof(uint32_t));
  f.corner_first = scree_rt_allocate_zeroed(allocator, seed_count, sizeof(uint32_t));
  f.corner_end = scree_rt_allocate_zeroed(allocator, seed_count, sizeof(uint32_t));
  scree_result result = SCREE_ERROR_OUT_OF_MEMORY;
  if (f.states != NULL && f.part_first != NULL && f.segment_first != NULL && f.part_order != NULL && f.segment_order != NULL &&
      f.next != NULL && f.corner_first != NULL && f.corner_end != NULL)
    result = clip_rays_create(work->input, &work->solid, allocator, &f.rays);
  if (result == SCREE_OK) {
    for (uint32_t v = 0; v < f.vertex_count; ++v) f.next[v] = CLIP_NONE;
    result = clip_reserve(allocator, &f.corners, &f.corner_capacity, 0, (size_t)7 * seed_count);
    if (result == SCREE_OK) result = make_all(&f);
  }
  voronoi_cell_free(&f.cell);
  clip_rays_free(&f.rays, allocator);
  clip_loops_free(&f.loops, allocator);
  scree_rt_release(allocator, f.states, seed_count, sizeof *f.states);
  scree_rt_release(allocator, f.part_first, (size_t)seed_count + 1, sizeof(uint32_t));
  scree_rt_release(allocator, f.segment_first, (size_t)seed_count + 1, sizeof(uint32_t));
  scree_rt_release(allocator, f.part_order, (size_t)work->part_count + 1, sizeof(uint32_t));
  scree_rt_release(allocator, f.segment_order, (size_t)work->segment_count + 1, sizeof(uint32_t));
  scree_rt_release(allocator, f.next, f.vertex_count, sizeof(uint32_t));
  scree_rt_release(allocator, f.corner_first, seed_count, sizeof(uint32_t));
  scree_rt_release(allocator, f.corner_end, seed_count, sizeof(uint32_t));
  scree_rt_release(allocator, f.corners, f.corner_capacity, sizeof *f.corners);
  scree_rt_release(allocator, f.known, f.known_capacity, sizeof *f.known);
  scree_rt_release(allocator, f.path_corners, f.path_corner_capacity, sizeof *f.path_corners);
  scree_rt_release(allocator, f.ends, f.end_capacity, sizeof *f.ends);
  scree_rt_release(allocator, f.paths, f.path_capacity, sizeof *f.paths);
  scree_rt_release(allocator, f.names, f.name_capacity, sizeof *f.names);
  scree_rt_release(allocator, f.pieces, f.piece_capacity, sizeof *f.pieces);
  return result;
}
