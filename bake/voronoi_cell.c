#include "voronoi_cell.h"

#include <stdlib.h>
#include <string.h>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

/* Neighbours cut before the walls: enough that few walls still reach the cell, which is then small. */
enum { BEFORE_WALLS = 24, NEAR_BUCKETS = 64 };

typedef struct near_seed {
  double distance2;
  uint32_t point; /* in the grid's points */
  uint32_t seed;
} near_seed;

/* An edge of the hole that a plane leaves: from plane a to plane b, kept corner `beyond` on its other side. */
typedef struct hole_edge {
  uint32_t a, b, beyond;
  double position[3]; /* where both planes meet the new one */
} hole_edge;

/* --- memory ----------------------------------------------------------------------------------------------------------------- */

static bool grow(const scree_allocator* allocator, void* array, size_t old_count, size_t new_count, size_t size) {
  void* old;
  memcpy(&old, array, sizeof old);
  void* memory = scree_rt_allocate(allocator, new_count, size);
  if (memory == NULL) return false;
  if (old_count > 0) memcpy(memory, old, old_count * size);
  scree_rt_release(allocator, old, old_count, size);
  memcpy(array, &memory, sizeof memory);
  return true;
}

static void release_corners(voronoi_cell* cell) {
  const size_t n = cell->corner_capacity;
  scree_rt_release(cell->allocator, cell->positions, n, sizeof *cell->positions);
  scree_rt_release(cell->allocator, cell->corners, n, sizeof *cell->corners);
  scree_rt_release(cell->allocator, cell->indices, 3 * n, sizeof *cell->indices);
  scree_rt_release(cell->allocator, cell->x, n, sizeof *cell->x);
  scree_rt_release(cell->allocator, cell->y, n, sizeof *cell->y);
  scree_rt_release(cell->allocator, cell->z, n, sizeof *cell->z);
  scree_rt_release(cell->allocator, cell->removed, n, sizeof *cell->removed);
  scree_rt_release(cell->allocator, cell->outside, n / 64, sizeof *cell->outside);
}

/* All arrays of corners together: a new set is taken before the old one goes, so that a failure changes nothing. */
static bool need_corners(voronoi_cell* cell, size_t count) {
  if (count <= cell->corner_capacity) return true;
  const size_t n = count < 64 ? 128 : (2 * count + 63) / 64 * 64;
  voronoi_cell larger = *cell;
  larger.corner_capacity = (uint32_t)n;
  larger.positions = scree_rt_allocate(cell->allocator, n, sizeof *cell->positions);
  larger.corners = scree_rt_allocate(cell->allocator, n, sizeof *cell->corners);
  larger.indices = scree_rt_allocate(cell->allocator, 3 * n, sizeof *cell->indices);
  larger.x = scree_rt_allocate(cell->allocator, n, sizeof *cell->x);
  larger.y = scree_rt_allocate(cell->allocator, n, sizeof *cell->y);
  larger.z = scree_rt_allocate(cell->allocator, n, sizeof *cell->z);
  larger.removed = scree_rt_allocate(cell->allocator, n, sizeof *cell->removed);
  larger.outside = scree_rt_allocate(cell->allocator, n / 64, sizeof *cell->outside);
  if (larger.positions == NULL || larger.corners == NULL || larger.indices == NULL || larger.x == NULL || larger.y == NULL ||
      larger.z == NULL || larger.removed == NULL || larger.outside == NULL) {
    release_corners(&larger);
    return false;
  }
  const size_t used = cell->corner_capacity;
  if (used > 0) {
    memcpy(larger.corners, cell->corners, used * sizeof *cell->corners);
    memcpy(larger.x, cell->x, used * sizeof *cell->x);
    memcpy(larger.y, cell->y, used * sizeof *cell->y);
    memcpy(larger.z, cell->z, used * sizeof *cell->z);
    memcpy(larger.removed, cell->removed, used * sizeof *cell->removed);
    memcpy(larger.outside, cell->outside, used / 64 * sizeof *cell->outside);
  }
  release_corners(cell);
  *cell = larger;
  return true;
}

static bool need_planes(voronoi_cell* cell, size_t count) {
  const size_t old = cell->plane_capacity, n = count < 32 ? 64 : 2 * count;
  if (count <= old) return true;
  voronoi_plane* planes = scree_rt_allocate(cell->allocator, n, sizeof *planes);
  voronoi_face* faces = scree_rt_allocate(cell->allocator, n, sizeof *faces);
  uint32_t* marks = scree_rt_allocate_zeroed(cell->allocator, n, 2 * sizeof *marks);
  if (planes == NULL || faces == NULL || marks == NULL) {
    scree_rt_release(cell->allocator, planes, n, sizeof *planes);
    scree_rt_release(cell->allocator, faces, n, sizeof *faces);
    scree_rt_release(cell->allocator, marks, n, 2 * sizeof *marks);
    return false;
  }
  if (old > 0) {
    memcpy(planes, cell->planes, old * sizeof *planes);
    memcpy(marks, cell->marks, old * 2 * sizeof *marks);
  }
  scree_rt_release(cell->allocator, cell->planes, old, sizeof *planes);
  scree_rt_release(cell->allocator, cell->faces, old, sizeof *faces);
  scree_rt_release(cell->allocator, cell->marks, old, 2 * sizeof *marks);
  cell->planes = planes;
  cell->faces = faces;
  cell->marks = marks;
  cell->plane_capacity = (uint32_t)n;
  return true;
}

static bool need_near(voronoi_cell* cell, size_t count) {
  const size_t n = count < 128 ? 256 : 2 * count;
  if (count <= cell->near_capacity) return true;
  if (!grow(cell->allocator, &cell->near, cell->near_capacity, n, 2 * sizeof(near_seed))) return false;
  cell->near_capacity = (uint32_t)n;
  return true;
}

static bool need_edges(voronoi_cell* cell, size_t count) {
  const size_t n = count < 64 ? 128 : 2 * count;
  if (count <= cell->edge_capacity) return true;
  if (!grow(cell->allocator, &cell->edges, cell->edge_capacity, n, sizeof(hole_edge))) return false;
  cell->edge_capacity = (uint32_t)n;
  return true;
}

void voronoi_cell_free(voronoi_cell* cell) {
  if (cell->allocator == NULL) return;
  release_corners(cell);
  scree_rt_release(cell->allocator, cell->planes, cell->plane_capacity, sizeof *cell->planes);
  scree_rt_release(cell->allocator, cell->faces, cell->plane_capacity, sizeof *cell->faces);
  scree_rt_release(cell->allocator, cell->marks, cell->plane_capacity, 2 * sizeof *cell->marks);
  scree_rt_release(cell->allocator, cell->near, cell->near_capacity, 2 * sizeof(near_seed));
  scree_rt_release(cell->allocator, cell->edges, cell->edge_capacity, sizeof(hole_edge));
  *cell = (voronoi_cell){0};
}

/* --- cutting ---------------------------------------------------------------------------------------------------------------- */

/* Where three planes meet. false where rounding hides it. */
static bool meet(const voronoi_plane* a, const voronoi_plane* b, const voronoi_plane* c, double da, double db, double dc,
                 double out[3]) {
  const double bc[3] = {b->normal[1] * c->normal[2] - b->normal[2] * c->normal[1],
                        b->normal[2] * c->normal[0] - b->normal[0] * c->normal[2],
                        b->normal[0] * c->normal[1] - b->normal[1] * c->normal[0]};
  const double ca[3] = {c->normal[1] * a->normal[2] - c->normal[2] * a->normal[1],
                        c->normal[2] * a->normal[0] - c->normal[0] * a->normal[2],
                        c->normal[0] * a->normal[1] - c->normal[1] * a->normal[0]};
  const double ab[3] = {a->normal[1] * b->normal[2] - a->normal[2] * b->normal[1],
                        a->normal[2] * b->normal[0] - a->normal[0] * b->normal[2],
                        a->normal[0] * b->normal[1] - a->normal[1] * b->normal[0]};
  const double det = a->normal[0] * bc[0] + a->normal[1] * bc[1] + a->normal[2] * bc[2];
  if (!(det > 0)) return false;
  const double inverse = 1 / det;
  for (int axis = 0; axis < 3; ++axis) out[axis] = (da * bc[axis] + db * ca[axis] + dc * ab[axis]) * inverse;
  return true;
}

#ifdef __SSE2__
typedef struct vector_pair {
  __m128d x, y, z;
} vector_pair;

static vector_pair pair_of(const double a[3], const double b[3]) {
  return (vector_pair){_mm_set_pd(b[0], a[0]), _mm_set_pd(b[1], a[1]), _mm_set_pd(b[2], a[2])};
}

static __m128d minus(__m128d a, __m128d b, __m128d c, __m128d d) {
  return _mm_sub_pd(_mm_mul_pd(a, b), _mm_mul_pd(c, d));
}

static vector_pair crossed(const vector_pair* a, const vector_pair* b) {
  return (vector_pair){minus(a->y, b->z, a->z, b->y), minus(a->z, b->x, a->x, b->z), minus(a->x, b->y, a->y, b->x)};
}

static __m128d weighed(__m128d da, __m128d bc, __m128d db, __m128d ca, __m128d dc, __m128d ab, __m128d inverse) {
  const __m128d sum = _mm_add_pd(_mm_add_pd(_mm_mul_pd(da, bc), _mm_mul_pd(db, ca)), _mm_mul_pd(dc, ab));
  return _mm_mul_pd(sum, inverse);
}

/* Two at once, each as `meet` has it, to the bit. */
static bool meet_two(const voronoi_plane* planes, hole_edge* p, hole_edge* q, const voronoi_plane* plane) {
  const voronoi_plane *a0 = planes + p->a, *a1 = planes + q->a, *b0 = planes + p->b, *b1 = planes + q->b;
  const vector_pair a = pair_of(a0->normal, a1->normal), b = pair_of(b0->normal, b1->normal),
                    c = pair_of(plane->normal, plane->normal);
  const vector_pair bc = crossed(&b, &c), ca = crossed(&c, &a), ab = crossed(&a, &b);
  const __m128d det = _mm_add_pd(_mm_add_pd(_mm_mul_pd(a.x, bc.x), _mm_mul_pd(a.y, bc.y)), _mm_mul_pd(a.z, bc.z));
  if (_mm_movemask_pd(_mm_cmpgt_pd(det, _mm_setzero_pd())) != 3) return false;
  const __m128d inverse = _mm_div_pd(_mm_set1_pd(1), det);
  const __m128d da = _mm_set_pd(a1->cut, a0->cut), db = _mm_set_pd(b1->cut, b0->cut), dc = _mm_set1_pd(plane->cut);
  const __m128d at[3] = {weighed(da, bc.x, db, ca.x, dc, ab.x, inverse), weighed(da, bc.y, db, ca.y, dc, ab.y, inverse),
                         weighed(da, bc.z, db, ca.z, dc, ab.z, inverse)};
  for (int axis = 0; axis < 3; ++axis) {
    _mm_storel_pd(&p->position[axis], at[axis]);
    _mm_storeh_pd(&q->position[axis], at[axis]);
  }
  return true;
}
#endif

/* Where the planes of a hole's edges meet the new one. */
static bool meet_all(const voronoi_plane* planes, hole_edge* edges, uint32_t count, const voronoi_plane* plane) {
  uint32_t k = 0;
#ifdef __SSE2__
  for (; k + 2 <= count; k += 2)
    if (!meet_two(planes, edges + k, edges + k + 1, plane)) return false;
#endif
  for (; k < count; ++k) {
    const voronoi_plane *a = planes + edges[k].a, *b = planes + edges[k].b;
    if (!meet(a, b, plane, a->cut, b->cut, plane->cut, edges[k].position)) return false;
  }
  return true;
}

static void measure_radius(voronoi_cell* cell) {
  const double *x = cell->x, *y = cell->y, *z = cell->z;
  double radius2 = 0;
  for (size_t i = 0; i < cell->corner_count; ++i) {
    const double r2 = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
    radius2 = r2 > radius2 ? r2 : radius2;
  }
  cell->radius2 = radius2;
}

/* Fills a hole among the corners with the last of them. */
static void move_last(voronoi_cell* cell, uint32_t hole) {
  const uint32_t last = --cell->corner_count;
  if (hole == last) return;
  cell->x[hole] = cell->x[last];
  cell->y[hole] = cell->y[last];
  cell->z[hole] = cell->z[last];
  const voronoi_corner moved = cell->corners[last];
  cell->corners[hole] = moved;
  for (int side = 0; side < 3; ++side) {
    voronoi_corner* other = cell->corners + moved.corners[side];
    const uint32_t b = moved.planes[side == 2 ? 0 : side + 1];
    other->corners[other->planes[0] == b ? 0 : other->planes[1] == b ? 1 : 2] = hole;
  }
}

/* Marks the corners beyond a plane, 64 to a word of `outside`. Returns whether there are any. */
static bool mark_outside(voronoi_cell* cell, const voronoi_plane* plane) {
  const double nx = plane->normal[0], ny = plane->normal[1], nz = plane->normal[2], d = plane->cut;
  const double *x = cell->x, *y = cell->y, *z = cell->z;
  const uint32_t count = cell->corner_count;
  uint64_t any = 0;
  for (uint32_t first = 0; first < count; first += 64) {
    const uint32_t end = count - first < 64 ? count : first + 64;
    uint64_t word = 0;
    uint32_t i = first;
#ifdef __SSE2__
    const __m128d nx2 = _mm_set1_pd(nx), ny2 = _mm_set1_pd(ny), nz2 = _mm_set1_pd(nz), d2 = _mm_set1_pd(d);
    for (; i + 2 <= end; i += 2) {
      const __m128d xy = _mm_add_pd(_mm_mul_pd(nx2, _mm_loadu_pd(x + i)), _mm_mul_pd(ny2, _mm_loadu_pd(y + i)));
      const __m128d along = _mm_add_pd(xy, _mm_mul_pd(nz2, _mm_loadu_pd(z + i)));
      word |= (uint64_t)(uint32_t)_mm_movemask_pd(_mm_cmpgt_pd(along, d2)) << (i - first);
    }
#endif
    for (; i < end; ++i) word |= (uint64_t)(nx * x[i] + ny * y[i] + nz * z[i] > d) << (i - first);
    cell->outside[first / 64] = word;
    any |= word;
  }
  return any != 0;
}

static bool is_outside(const voronoi_cell* cell, uint32_t corner) {
  return cell->outside[corner / 64] >> (corner % 64) & 1;
}

static double corner_radius2(const voronoi_cell* cell, uint32_t i) {
  return cell->x[i] * cell->x[i] + cell->y[i] * cell->y[i] + cell->z[i] * cell->z[i];
}

/* Cuts off what lies beyond a plane. */
static scree_result cut(voronoi_cell* cell, const voronoi_plane* plane) {
  if (!mark_outside(cell, plane)) return SCREE_OK;
  const uint32_t count = cell->corner_count;
  uint32_t removed = 0;
  bool lost_farthest = false;
  for (uint32_t first = 0; first < count; first += 64)
    for (uint64_t word = cell->outside[first / 64]; word != 0; word &= word - 1) {
      const uint32_t i = first + (uint32_t)__builtin_ctzll(word);
      cell->removed[removed++] = i;
      lost_farthest = lost_farthest || corner_radius2(cell, i) == cell->radius2;
    }
  if (removed == count) {
    cell->corner_count = 0;
    return SCREE_OK;
  }
  if (!need_edges(cell, 3 * (size_t)removed + 1) || !need_corners(cell, count + (size_t)2) ||
      !need_planes(cell, cell->plane_count + (size_t)1))
    return SCREE_ERROR_OUT_OF_MEMORY;

  /* Written whether or not it is one: what lies beyond cannot be foreseen. */
  hole_edge* edges = cell->edges;
  uint32_t edge_count = 0;
  for (uint32_t k = 0; k < removed; ++k) {
    const voronoi_corner* corner = cell->corners + cell->removed[k];
    for (int side = 0; side < 3; ++side) {
      edges[edge_count].a = corner->planes[side];
      edges[edge_count].b = corner->planes[side == 2 ? 0 : side + 1];
      edges[edge_count].beyond = corner->corners[side];
      edge_count += !is_outside(cell, corner->corners[side]);
    }
  }
  if (edge_count > removed + 2) return SCREE_ERROR_UNSUPPORTED;
  const uint32_t stamp = ++cell->stamp;
  for (uint32_t k = 0; k < edge_count; ++k) {
    uint32_t* mark = cell->marks + 2 * (size_t)edges[k].a;
    if (mark[0] == stamp) return SCREE_ERROR_UNSUPPORTED;
    mark[0] = stamp;
    mark[1] = k;
  }
  if (edge_count < 3) return SCREE_ERROR_UNSUPPORTED;

  if (!meet_all(cell->planes, edges, edge_count, plane)) return SCREE_ERROR_UNSUPPORTED;
  const uint32_t added = cell->plane_count++;
  cell->planes[added] = *plane;
  uint32_t at = 0, before = UINT32_MAX, first = UINT32_MAX;
  double added_radius2 = 0;
  for (uint32_t k = 0; k < edge_count; ++k) {
    const hole_edge* edge = &edges[at];
    const uint32_t slot = k < removed ? cell->removed[k] : count + k - removed;
    cell->x[slot] = edge->position[0];
    cell->y[slot] = edge->position[1];
    cell->z[slot] = edge->position[2];
    const double r2 = corner_radius2(cell, slot);
    added_radius2 = r2 > added_radius2 ? r2 : added_radius2;
    voronoi_corner* corner = cell->corners + slot;
    corner->planes[0] = edge->a;
    corner->planes[1] = edge->b;
    corner->planes[2] = added;
    corner->corners[0] = edge->beyond;
    corner->corners[2] = before;
    if (before == UINT32_MAX)
      first = slot;
    else
      cell->corners[before].corners[1] = slot;
    voronoi_corner* beyond = cell->corners + edge->beyond;
    beyond->corners[beyond->planes[0] == edge->b ? 0 : beyond->planes[1] == edge->b ? 1 : 2] = slot;
    before = slot;
    if (cell->marks[2 * (size_t)edge->b] != stamp) return SCREE_ERROR_UNSUPPORTED;
    at = cell->marks[2 * (size_t)edge->b + 1];
    if (at == 0 && k + 1 < edge_count) return SCREE_ERROR_UNSUPPORTED; /* more than one loop */
  }
  if (at != 0) return SCREE_ERROR_UNSUPPORTED;
  cell->corners[before].corners[1] = first;
  cell->corners[first].corners[2] = before;
  cell->corner_count = edge_count > removed ? count + edge_count - removed : count;
  for (uint32_t k = removed; k-- > edge_count;) move_last(cell, cell->removed[k]);
  if (lost_farthest)
    measure_radius(cell);
  else if (added_radius2 > cell->radius2)
    cell->radius2 = added_radius2;
  return SCREE_OK;
}

static bool start_box(voronoi_cell* cell, const voronoi_bounds* bounds) {
  if (!need_planes(cell, VORONOI_BOX) || !need_corners(cell, 8)) return false;
  cell->plane_count = VORONOI_BOX;
  cell->corner_count = 8;
  double offset[VORONOI_BOX];
  for (uint32_t k = 0; k < VORONOI_BOX; ++k) {
    const uint32_t axis = k / 2;
    offset[k] = k % 2 == 0 ? cell->origin[axis] - bounds->min[axis] : bounds->max[axis] - cell->origin[axis];
    cell->planes[k] = (voronoi_plane){.offset = offset[k], .cut = offset[k], .neighbour = VORONOI_WALL + k};
    cell->planes[k].normal[axis] = k % 2 == 0 ? -1 : 1;
  }
  for (uint32_t i = 0; i < 8; ++i) {
    const uint32_t sign[3] = {i & 1, i >> 1 & 1, i >> 2 & 1};
    cell->x[i] = sign[0] ? offset[1] : -offset[0];
    cell->y[i] = sign[1] ? offset[3] : -offset[2];
    cell->z[i] = sign[2] ? offset[5] : -offset[4];
    /* A mirrored corner is walked the other way round. The edge of two planes goes along the third's axis. */
    const bool mirrored = (sign[0] + sign[1] + sign[2]) % 2 == 0;
    voronoi_corner* corner = cell->corners + i;
    const uint32_t x = sign[0], y = 2 + sign[1], z = 4 + sign[2];
    *corner = mirrored ? (voronoi_corner){{x, z, y}, {i ^ 2, i ^ 1, i ^ 4}} : (voronoi_corner){{x, y, z}, {i ^ 4, i ^ 1, i ^ 2}};
  }
  measure_radius(cell);
  return true;
}

/* --- neighbours ------------------------------------------------------------------------------------------------------------- */

static bool nearer(const near_seed* a, const near_seed* b) {
  return a->distance2 < b->distance2 || (a->distance2 == b->distance2 && a->seed < b->seed);
}

static int by_distance(const void* a, const void* b) {
  return nearer(a, b) ? -1 : nearer(b, a);
}

static void sort_few(near_seed* seeds, size_t count) {
  for (size_t i = 1; i < count; ++i) {
    const near_seed moved = seeds[i];
    size_t k = i;
    for (; k > 0 && nearer(&moved, seeds + k - 1); --k) seeds[k] = seeds[k - 1];
    seeds[k] = moved;
  }
}

/* Seeds that may cut a cell, in buckets by distance: only those that are asked for are sorted. */
typedef struct near_queue {
  near_seed* seeds;
  size_t count, sorted; /* the first `sorted` are in order */
  uint32_t ends[NEAR_BUCKETS], bucket;
} near_queue;

/* spare: room for as many; the queue's seeds are there in the end. */
static void queue_start(near_queue* queue, const near_seed* seeds, near_seed* spare, size_t count) {
  double most = 0;
  for (size_t i = 0; i < count; ++i) most = seeds[i].distance2 > most ? seeds[i].distance2 : most;
  const double scale = most > 1e-200 ? (NEAR_BUCKETS - 1) / most : 0; /* finite */
  uint32_t* ends = queue->ends;
  memset(ends, 0, sizeof queue->ends);
  for (size_t i = 0; i < count; ++i) ++ends[(uint32_t)(seeds[i].distance2 * scale)];
  uint32_t at = 0;
  for (int k = 0; k < NEAR_BUCKETS; ++k) {
    const uint32_t in = ends[k];
    ends[k] = at;
    at += in;
  }
  for (size_t i = 0; i < count; ++i) spare[ends[(uint32_t)(seeds[i].distance2 * scale)]++] = seeds[i];
  queue->seeds = spare;
  queue->count = count;
  queue->sorted = 0;
  queue->bucket = 0;
}

/* Sorts on until the seed at `index` < count is in its place. */
static const near_seed* queue_at(near_queue* queue, size_t index) {
  while (index >= queue->sorted) {
    near_seed* from = queue->seeds + queue->sorted;
    const size_t count = queue->ends[queue->bucket++] - queue->sorted;
    if (count > 64) /* seeds all as far away as each other */
      qsort(from, count, sizeof *from, by_distance);
    else
      sort_few(from, count);
    queue->sorted += count;
  }
  return queue->seeds + index;
}

static scree_result cut_by_seed(voronoi_cell* cell, const voronoi_grid* grid, const near_seed* near) {
  const double* point = grid->points + 3 * (size_t)near->point;
  voronoi_plane plane = {.offset = near->distance2 / 2, .cut = near->distance2 / 2, .neighbour = near->seed};
  for (int axis = 0; axis < 3; ++axis) plane.normal[axis] = point[axis] - cell->origin[axis];
  return cut(cell, &plane);
}

static scree_result cut_by_walls(voronoi_cell* cell, const voronoi_bounds* bounds) {
  for (uint32_t k = 0; k < bounds->wall_count && cell->corner_count > 0; ++k) {
    const voronoi_wall* wall = bounds->walls + k;
    const double* n = wall->normal;
    const double along = n[0] * cell->origin[0] + n[1] * cell->origin[1] + n[2] * cell->origin[2];
    const double d = wall->cut - along;
    if (d > 0 && d * d > cell->radius2) continue;
    const voronoi_plane plane = {{n[0], n[1], n[2]}, wall->offset - along, d, VORONOI_WALL + VORONOI_BOX + k};
    const scree_result result = cut(cell, &plane);
    if (result != SCREE_OK) return result;
  }
  return SCREE_OK;
}

/* How far a box of the grid is along one axis. */
static double gap(const voronoi_grid* grid, int axis, int box, double x) {
  const double low = grid->min[axis] + box * grid->step[axis] - x;
  const double high = x - (grid->min[axis] + (box + 1) * grid->step[axis]);
  return low > 0 ? low : high > 0 ? high : 0;
}

/* Adds the seeds of one ring of boxes (ring 1: of the 27 in the middle) that may still cut the cell. */
static bool gather(voronoi_cell* cell, const voronoi_grid* grid, const int centre[3], int ring, size_t* count) {
  *count = 0;
  /* A hair more than twice the radius, for boxes' rounded sides. */
  const double reach2 = 4 * cell->radius2 * (1 + 1e-9);
  for (int z = centre[2] - ring; z <= centre[2] + ring; ++z) {
    if (z < 0 || z >= (int)grid->size[2]) continue;
    const double gap_z = gap(grid, 2, z, cell->origin[2]);
    if (gap_z * gap_z > reach2) continue;
    for (int y = centre[1] - ring; y <= centre[1] + ring; ++y) {
      if (y < 0 || y >= (int)grid->size[1]) continue;
      const double gap_y = gap(grid, 1, y, cell->origin[1]), gap_yz = gap_y * gap_y + gap_z * gap_z;
      if (gap_yz > reach2) continue;
      const bool whole =
          ring == 1 || z == centre[2] - ring || z == centre[2] + ring || y == centre[1] - ring || y == centre[1] + ring;
      for (int x = centre[0] - ring; x <= centre[0] + ring; x += whole ? 1 : 2 * ring) {
        if (x < 0 || x >= (int)grid->size[0]) continue;
        const double gap_x = gap(grid, 0, x, cell->origin[0]);
        if (gap_x * gap_x + gap_yz > reach2) continue;
        const uint32_t box = ((uint32_t)z * grid->size[1] + (uint32_t)y) * grid->size[0] + (uint32_t)x;
        const uint32_t first = grid->first[box], end = grid->first[box + 1];
        if (!need_near(cell, *count + (end - first))) return false;
        near_seed* near = cell->near;
        for (uint32_t i = first; i < end; ++i) {
          const double* point = grid->points + 3 * (size_t)i;
          const double dx = point[0] - cell->origin[0], dy = point[1] - cell->origin[1], dz = point[2] - cell->origin[2];
          const double d2 = dx * dx + dy * dy + dz * dz;
          const uint32_t seed = grid->order[i];
          near[*count] = (near_seed){d2, i, seed}; /* overwritten unless it counts */
          *count += (size_t)(!(d2 > reach2) & (seed != cell->seed));
        }
      }
    }
  }
  return true;
}

/* The squared distance beyond which all seeds outside the boxes up to `ring` are; -1 when there are none. */
static double beyond_ring(const voronoi_cell* cell, const voronoi_grid* grid, const int centre[3], int ring) {
  double least = -1;
  for (int axis = 0; axis < 3; ++axis) {
    if (centre[axis] - ring > 0) {
      const double d = cell->origin[axis] - (grid->min[axis] + (centre[axis] - ring) * grid->step[axis]);
      if (least < 0 || d < least) least = d;
    }
    if (centre[axis] + ring + 1 < (int)grid->size[axis]) {
      const double d = grid->min[axis] + (centre[axis] + ring + 1) * grid->step[axis] - cell->origin[axis];
      if (least < 0 || d < least) least = d;
    }
  }
  return least < 0 ? -1 : least * least;
}

/* Cuts by near seeds, nearest first, until none reaches the cell any more. */
static scree_result cut_by_near(voronoi_cell* cell, const voronoi_grid* grid, near_queue* queue, size_t from, size_t to) {
  for (size_t i = from; i < to && cell->corner_count > 0; ++i) {
    const near_seed* near = queue_at(queue, i);
    if (!(near->distance2 <= 4 * cell->radius2)) break;
    const scree_result result = cut_by_seed(cell, grid, near);
    if (result != SCREE_OK) return result;
  }
  return SCREE_OK;
}

static scree_result cut_all(voronoi_cell* cell, const voronoi_grid* grid, const voronoi_bounds* bounds) {
  const uint32_t box = grid->box_of[cell->seed];
  const int centre[3] = {(int)(box % grid->size[0]), (int)(box / grid->size[0] % grid->size[1]),
                         (int)(box / grid->size[0] / grid->size[1])};
  for (int ring = 1;; ++ring) {
    size_t count, done = 0;
    if (!gather(cell, grid, centre, ring, &count)) return SCREE_ERROR_OUT_OF_MEMORY;
    near_queue queue;
    queue_start(&queue, cell->near, (near_seed*)cell->near + cell->near_capacity, count);
    scree_result result = SCREE_OK;
    if (ring == 1) {
      done = count < BEFORE_WALLS ? count : BEFORE_WALLS;
      result = cut_by_near(cell, grid, &queue, 0, done);
      if (result == SCREE_OK) result = cut_by_walls(cell, bounds);
    }
    if (result == SCREE_OK) result = cut_by_near(cell, grid, &queue, done, count);
    if (result != SCREE_OK || cell->corner_count == 0) return result;
    const double beyond2 = beyond_ring(cell, grid, centre, ring);
    if (beyond2 < 0 || beyond2 > 4 * cell->radius2 * (1 + 1e-9)) return SCREE_OK;
  }
}

/* --- what is read ----------------------------------------------------------------------------------------------------------- */

/* Corners that only decisions put by `cut` get their place by `offset`. */
static bool solve_positions(voronoi_cell* cell) {
  for (size_t i = 0; i < cell->corner_count; ++i) {
    const uint32_t* planes = cell->corners[i].planes;
    const voronoi_plane *a = cell->planes + planes[0], *b = cell->planes + planes[1], *c = cell->planes + planes[2];
    double* out = cell->positions[i];
    if (a->cut == a->offset && b->cut == b->offset && c->cut == c->offset) {
      out[0] = cell->x[i];
      out[1] = cell->y[i];
      out[2] = cell->z[i];
    } else if (!meet(a, b, c, a->offset, b->offset, c->offset, out))
      return false;
  }
  return true;
}

static bool list_faces(voronoi_cell* cell) {
  const uint32_t stamp = ++cell->stamp;
  uint64_t* keys = (void*)cell->x; /* which positions took the place of: neighbour << 32 | plane of each face, rising */
  cell->face_count = 0;
  cell->index_count = 0;
  for (uint32_t i = 0; i < cell->corner_count; ++i)
    for (int side = 0; side < 3; ++side) {
      const uint32_t plane = cell->corners[i].planes[side];
      if (cell->marks[2 * (size_t)plane] == stamp) continue;
      cell->marks[2 * (size_t)plane] = stamp;
      cell->marks[2 * (size_t)plane + 1] = i;
      if (cell->face_count == cell->corner_count) return false; /* a closed cell has half as many and two */
      const uint64_t key = (uint64_t)cell->planes[plane].neighbour << 32 | plane;
      uint32_t at = cell->face_count++;
      for (; at > 0 && keys[at - 1] > key; --at) keys[at] = keys[at - 1];
      keys[at] = key;
    }
  for (uint32_t k = 0; k < cell->face_count; ++k) {
    voronoi_face* face = cell->faces + k;
    *face = (voronoi_face){.neighbour = (uint32_t)(keys[k] >> 32), .plane = (uint32_t)keys[k], .first_index = cell->index_count};
    const uint32_t first = cell->marks[2 * (size_t)face->plane + 1];
    uint32_t at = first;
    do {
      /* Each corner has three faces: more indices can only be a face that is walked wrongly. */
      if (cell->index_count == 3 * cell->corner_count) return false;
      cell->indices[cell->index_count++] = at;
      const voronoi_corner* corner = cell->corners + at;
      const int side = corner->planes[0] == face->plane ? 0 : corner->planes[1] == face->plane ? 1 : 2;
      if (corner->planes[side] != face->plane) return false;
      at = corner->corners[side == 0 ? 2 : side - 1];
    } while (at != first);
    face->count = cell->index_count - face->first_index;
    if (face->count < 3) return false;
  }
  return cell->index_count == 3 * cell->corner_count;
}

scree_result voronoi_cell_make(voronoi_cell* cell, const voronoi_grid* grid, uint32_t seed, const voronoi_bounds* bounds,
                               const scree_allocator* allocator) {
  cell->allocator = allocator;
  cell->seed = seed;
  cell->face_count = cell->index_count = cell->corner_count = 0;
  memcpy(cell->origin, grid->seeds + 3 * (size_t)seed, sizeof cell->origin);
  /* Stamps start anew long before they come round. */
  if (cell->stamp > UINT32_MAX / 2) {
    memset(cell->marks, 0, cell->plane_capacity * 2 * sizeof *cell->marks);
    cell->stamp = 0;
  }
  if (!start_box(cell, bounds)) return SCREE_ERROR_OUT_OF_MEMORY;
  const scree_result result = cut_all(cell, grid, bounds);
  if (result != SCREE_OK) return result;
  return solve_positions(cell) && list_faces(cell) ? SCREE_OK : SCREE_ERROR_UNSUPPORTED;
}

void voronoi_cell_key(const voronoi_cell* cell, uint32_t corner, uint32_t key[4]) {
  key[0] = cell->seed;
  for (int k = 0; k < 3; ++k) {
    const uint32_t next = cell->planes[cell->corners[corner].planes[k]].neighbour;
    int at = k + 1;
    for (; at > 0 && key[at - 1] > next; --at) key[at] = key[at - 1];
    key[at] = next;
  }
}
