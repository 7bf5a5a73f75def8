#include <math.h>
#include <string.h>

#include "shard_clip.h"
#include "vectors.h"

/* Sides of a triangle's part in one cell. */
enum { MOST_SIDES = 256 };

/* A row is how much nearer the cell's seed is than another one, at the corners of the triangle, squared distances; it is linear
 * over the triangle. Differences of coordinates are exact to one rounding, so its error depends on lengths around the seed alone.
 */
#define ROW_ERROR 2e-15

/* A corner of a part: shares of the triangle's corners, and how wrong they may be. Between side - 1 and side. */
typedef struct part_corner {
  double share[3], error;
  double distance2; /* to the seed */
  uint32_t side;    /* the side after it: 0..2 = of the triangle, from that corner to the next; 3.. = of cutter side - 3 */
} part_corner;

typedef struct part_cutter {
  double row[3], error;
  uint32_t seed;
} part_cutter;

typedef struct surface_cutter {
  clip_work* work;
  shard_pieces* out;
  uint32_t *cell_of, *edge_first; /* of each vertex of the mesh */
  uint32_t *met, *first_within;   /* of each seed: the last triangle that met it, and its clip_vertices of that triangle */
  uint32_t* queue;                /* cells that the triangle meets */
  uint32_t queue_count, queue_capacity;
} surface_cutter;

/* --- Seeds nearby. --- */

static bool nearer(const clip_near* a, const clip_near* b) {
  return a->distance2 < b->distance2 || (a->distance2 == b->distance2 && a->seed < b->seed);
}

static void sort_near(clip_near* list, uint32_t count) {
  static const uint32_t gaps[] = {4193, 1577, 701, 301, 132, 57, 23, 10, 4, 1};
  for (size_t g = 0; g < sizeof gaps / sizeof *gaps; ++g) {
    const uint32_t gap = gaps[g];
    for (uint32_t i = gap; i < count; ++i) {
      const clip_near one = list[i];
      uint32_t k = i;
      for (; k >= gap && nearer(&one, &list[k - gap]); k -= gap) list[k] = list[k - gap];
      list[k] = one;
    }
  }
}

/* Makes room for `more` of a list that the last page ends with, and has `kept` so far. */
static scree_result reserve_near(clip_work* work, size_t kept, size_t more) {
  enum { PAGE = 2048 };
  const clip_near_page* last = work->page;
  if (last != NULL && last->count + more <= last->capacity) return SCREE_OK;
  const size_t capacity = kept + more > PAGE / 2 ? 2 * (kept + more) : PAGE;
  if (capacity > SIZE_MAX / sizeof(clip_near) / 2) return SCREE_ERROR_OUT_OF_MEMORY;
  clip_near_page* page = scree_rt_allocate(work->allocator, 1, sizeof *page + capacity * sizeof *page->near);
  if (page == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  *page = (clip_near_page){.before = work->page, .count = kept, .capacity = capacity};
  if (kept > 0) memcpy(page->near, last->near + last->count - kept, kept * sizeof *page->near);
  if (work->page != NULL) work->page->count -= kept;
  work->page = page;
  return SCREE_OK;
}

/* Which boxes of the grid, along one axis, hold what is no further than `reach` from x. Wider by a hair, for boxes' rounded sides.
 */
static bool boxes_within(const voronoi_grid* grid, int axis, double x, double reach, uint32_t out[2]) {
  const double hair = 1e-6, last = (double)grid->size[axis] - 1;
  const double a = (x - reach - grid->min[axis]) / grid->step[axis] - hair,
               b = (x + reach - grid->min[axis]) / grid->step[axis] + hair;
  out[0] = !(a > 0) ? 0 : a > last ? (uint32_t)last : (uint32_t)a;
  out[1] = !(b > 0) ? 0 : b > last ? (uint32_t)last : (uint32_t)b;
  return a < 0 && b > last + 1;
}

/* How far a box of the grid is from x along one axis, at least. */
static double gap_to(const voronoi_grid* grid, int axis, uint32_t box, double x) {
  const double low = grid->min[axis] + (box - 1e-6) * grid->step[axis] - x,
               high = x - (grid->min[axis] + (box + (1 + 1e-6)) * grid->step[axis]);
  return low > 0 ? low : high > 0 ? high : 0;
}

/* Adds the seeds of boxes first .. end - 1, those within reach. */
static scree_result take_near(clip_work* work, uint32_t seed, size_t first_box, size_t end_box, double reach2, uint32_t* count) {
  const voronoi_grid* grid = &work->grid;
  const double* at = &work->input->seeds[3 * (size_t)seed];
  const uint32_t first = grid->first[first_box], end = grid->first[end_box];
  const scree_result result = reserve_near(work, *count, end - first);
  if (result != SCREE_OK) return result;
  clip_near *const list_end = work->page->near + work->page->count, *next = list_end;
  for (uint32_t k = first; k < end; ++k) {
    const double* point = &grid->points[3 * (size_t)k];
    const double to[3] = {point[0] - at[0], point[1] - at[1], point[2] - at[2]}, distance2 = dot(to, to);
    *next = (clip_near){{to[0], to[1], to[2]}, distance2, grid->order[k]}; /* overwritten unless it counts */
    next += (int)(distance2 < reach2) & (int)(grid->order[k] != seed);
  }
  work->page->count += (size_t)(next - list_end);
  *count += (uint32_t)(next - list_end);
  return SCREE_OK;
}

scree_result clip_near_find(clip_work* work, uint32_t seed, double distance2) {
  enum { ENOUGH = 20 };
  const voronoi_grid* grid = &work->grid;
  clip_near_list* list = &work->lists[seed];
  const double* at = &work->input->seeds[3 * (size_t)seed];
  double reach = list->reach2 > 0 ? 1.5 * sqrt(list->reach2) : 1.6 * work->spacing;
  while (reach * reach < distance2) reach *= 1.5;
  /* A list that was made last gives its place to the longer one. */
  if (list->reach2 > 0 && list->near + list->count == work->page->near + work->page->count) work->page->count -= list->count;
  for (;; reach *= 1.5) {
    uint32_t x[2], y[2], z[2];
    bool all = boxes_within(grid, 0, at[0], reach, x);
    all = boxes_within(grid, 1, at[1], reach, y) && all;
    all = boxes_within(grid, 2, at[2], reach, z) && all;
    const double reach2 = all ? INFINITY : reach * reach;
    uint32_t count = 0;
    for (uint32_t k = z[0]; k <= z[1]; ++k) {
      const double gap_z = gap_to(grid, 2, k, at[2]);
      for (uint32_t j = y[0]; j <= y[1]; ++j) {
        const double gap_y = gap_to(grid, 1, j, at[1]), left2 = reach2 - gap_z * gap_z - gap_y * gap_y;
        if (left2 < 0) continue;
        if (!all) boxes_within(grid, 0, at[0], sqrt(left2), x);
        const size_t row = ((size_t)k * grid->size[1] + j) * grid->size[0];
        const scree_result result = take_near(work, seed, row + x[0], row + x[1] + 1, reach2, &count);
        if (result != SCREE_OK) return result;
      }
    }
    clip_near* near = work->page->near + work->page->count - count;
    if (!all && count < ENOUGH) {
      work->page->count -= count;
      continue;
    }
    sort_near(near, count);
    *list = (clip_near_list){near, count, reach2};
    return SCREE_OK;
  }
}

/* Walks to the seed nearest to a point, from a seed near it. */
static scree_result walk(clip_work* work, const double at[3], uint32_t* cell) {
  for (;;) {
    const double* seed = &work->input->seeds[3 * (size_t)*cell];
    const double d[3] = {at[0] - seed[0], at[1] - seed[1], at[2] - seed[2]}, d2 = dot(d, d), reach2 = 4 * d2 * (1 + 1e-9);
    if (work->lists[*cell].reach2 == 0) {
      const scree_result result = clip_near_find(work, *cell, 0);
      if (result != SCREE_OK) return result;
    }
    const clip_near_list* list = &work->lists[*cell];
    const clip_near* near = list->near;
    uint32_t best = CLIP_NONE;
    double least = 0;
    bool unsure = false;
    const double sure = ROW_ERROR * (2 * reach2 + d2); /* for all of them */
    for (uint32_t k = 0; k < list->count && near[k].distance2 <= reach2; ++k) {
      const double by = near[k].distance2 - 2 * dot(d, near[k].to);
      if (by > sure) continue;
      const double error = ROW_ERROR * (2 * near[k].distance2 + d2);
      if (by < least && by < -error) {
        least = by;
        best = near[k].seed;
      }
      unsure = unsure || fabs(by) <= error;
    }
    if (best != CLIP_NONE) {
      *cell = best;
    } else if (list->reach2 <= reach2) {
      const scree_result result = clip_near_find(work, *cell, reach2);
      if (result != SCREE_OK) return result;
    } else {
      return unsure ? SCREE_ERROR_UNSUPPORTED : SCREE_OK;
    }
  }
}

/* --- A triangle in a cell. --- */

typedef struct part_polygon {
  const double *seeds, *seed, *at[3]; /* all seeds, that of the cell, the triangle's corners */
  part_corner corners[2][MOST_SIDES + 1];
  part_cutter cutters[MOST_SIDES];
  uint32_t count, cutter_count;
  const part_corner* now;
} part_polygon;

/* A sum of two doubles, for about twice their digits. Based on: Dekker 1971, "A floating-point technique for extending the
 * available precision". */
typedef struct wide {
  double high, low;
} wide;

static wide wide_sum(double a, double b) {
  const double sum = a + b, part = sum - a;
  return (wide){sum, (a - (sum - part)) + (b - part)};
}

static wide wide_add(wide a, wide b) {
  const wide high = wide_sum(a.high, b.high), low = wide_sum(a.low, b.low), once = wide_sum(high.high, high.low + low.high);
  return wide_sum(once.high, once.low + low.low);
}

static wide wide_minus(wide a) {
  return (wide){-a.high, -a.low};
}

static wide wide_times(wide a, wide b) {
  const double split = 134217729, p = split * a.high, q = split * b.high;
  const double a1 = p - (p - a.high), a2 = a.high - a1, b1 = q - (q - b.high), b2 = b.high - b1, high = a.high * b.high;
  const double low = ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2;
  return wide_sum(high, low + (a.high * b.low + a.low * b.high));
}

/* The rows of a cutter anew. */
static void wide_row(const part_polygon* p, uint32_t seed, wide row[3]) {
  const double* other = &p->seeds[3 * (size_t)seed];
  for (int c = 0; c < 3; ++c) {
    row[c] = (wide){0, 0};
    for (int axis = 0; axis < 3; ++axis) {
      const wide to = wide_sum(other[axis], -p->seed[axis]), d = wide_sum(p->at[c][axis], -p->seed[axis]);
      row[c] = wide_add(row[c], wide_times(to, wide_add(to, (wide){-2 * d.high, -2 * d.low})));
    }
  }
}

/* Where two planes and the triangle's are nearly one, doubles know little of the point where they meet. */
static void meet_wide(const part_polygon* p, uint32_t side, uint32_t seed, part_corner* out) {
  wide r[3], s[3], h[3], sum = {0, 0};
  wide_row(p, seed, s);
  for (uint32_t c = 0; c < 3; ++c) r[c] = (wide){c == (side + 2) % 3, 0};
  if (side >= 3) wide_row(p, p->cutters[side - 3].seed, r);
  double size = 0;
  for (int c = 0; c < 3; ++c) {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    h[c] = wide_add(wide_times(r[a], s[b]), wide_minus(wide_times(r[b], s[a])));
    sum = wide_add(sum, h[c]);
    size += fabs(r[a].high * s[b].high) + fabs(r[b].high * s[a].high);
  }
  for (int c = 0; c < 3; ++c) out->share[c] = h[c].high / sum.high;
  out->error = 4e-16 + 1e-29 * size / fabs(sum.high);
}

/* Where a side and a new cutter meet. */
static bool meet(const part_polygon* p, uint32_t side, const part_cutter* by, double d[3][3], part_corner* out) {
  if (side < 3) {
    const uint32_t a = side, b = (side + 1) % 3;
    const double length = by->row[a] - by->row[b];
    out->share[a] = -by->row[b] / length;
    out->share[b] = by->row[a] / length;
    out->share[(side + 2) % 3] = 0;
    out->error = 4 * by->error / fabs(length);
  } else {
    const part_cutter* with = &p->cutters[side - 3];
    const double *r = with->row, *s = by->row;
    const double h[3] = {r[1] * s[2] - r[2] * s[1], r[2] * s[0] - r[0] * s[2], r[0] * s[1] - r[1] * s[0]};
    const double sum = h[0] + h[1] + h[2];
    const double r1 = fabs(r[0]) + fabs(r[1]) + fabs(r[2]), s1 = fabs(s[0]) + fabs(s[1]) + fabs(s[2]);
    for (int c = 0; c < 3; ++c) out->share[c] = h[c] / sum;
    out->error = 4 * (r1 * by->error + s1 * with->error + 1e-15 * r1 * s1) / fabs(sum);
  }
  if (!(out->error < 1e-11)) meet_wide(p, side, by->seed, out);
  if (!(out->error < 1e-9)) return false;
  double at[3];
  for (int axis = 0; axis < 3; ++axis)
    at[axis] = out->share[0] * d[0][axis] + out->share[1] * d[1][axis] + out->share[2] * d[2][axis];
  out->distance2 = dot(at, at);
  return true;
}

static scree_result cut(part_polygon* p, const part_cutter* by, double d[3][3]) {
  const part_corner* now = p->now;
  const uint32_t count = p->count;
  const double size = fabs(by->row[0]) + fabs(by->row[1]) + fabs(by->row[2]);
  bool kept[MOST_SIDES + 1];
  uint32_t kept_count = 0;
  for (uint32_t k = 0; k < count; ++k) {
    const double value = dot(now[k].share, by->row);
    if (fabs(value) <= now[k].error * size + by->error) return SCREE_ERROR_UNSUPPORTED;
    kept[k] = value > 0;
    kept_count += kept[k];
  }
  if (kept_count == count) return SCREE_OK;
  if (kept_count == 0) return SCREE_ERROR_UNSUPPORTED; /* the neighbour that led here met it */
  uint32_t start = CLIP_NONE;
  for (uint32_t k = 0; k < count; ++k)
    if (kept[k] && !kept[k > 0 ? k - 1 : count - 1]) {
      if (start != CLIP_NONE) return SCREE_ERROR_UNSUPPORTED;
      start = k;
    }
  if (kept_count + 2 > MOST_SIDES || p->cutter_count == MOST_SIDES) return SCREE_ERROR_UNSUPPORTED;
  part_corner* out = p->corners[now == p->corners[0] ? 1 : 0];
  for (uint32_t k = 0; k < kept_count; ++k) out[k] = now[(start + k) % count];
  const uint32_t before = now[(start + count - 1) % count].side;
  if (!meet(p, out[kept_count - 1].side, by, d, &out[kept_count]) || !meet(p, before, by, d, &out[kept_count + 1]))
    return SCREE_ERROR_UNSUPPORTED;
  out[kept_count].side = 3 + p->cutter_count;
  out[kept_count + 1].side = before;
  p->cutters[p->cutter_count++] = *by;
  p->count = kept_count + 2;
  p->now = out;
  return SCREE_OK;
}

static double farthest2(const part_polygon* p) {
  double most = 0;
  for (uint32_t k = 0; k < p->count; ++k) most = p->now[k].distance2 > most ? p->now[k].distance2 : most;
  return most;
}

/* Cuts a triangle by all seeds that are near enough to matter. */
static scree_result make_part(clip_work* work, const uint32_t* triangle, uint32_t cell, part_polygon* p) {
  const double* seed = &work->input->seeds[3 * (size_t)cell];
  double d[3][3];
  p->seeds = work->input->seeds;
  p->seed = seed;
  p->count = 3;
  p->cutter_count = 0;
  p->now = p->corners[0];
  for (uint32_t c = 0; c < 3; ++c) {
    const double* at = &work->input->positions[3 * (size_t)triangle[c]];
    p->at[c] = at;
    for (int axis = 0; axis < 3; ++axis) d[c][axis] = at[axis] - seed[axis];
    part_corner* corner = &p->corners[0][c];
    *corner = (part_corner){{c == 0, c == 1, c == 2}, 0, dot(d[c], d[c]), c};
  }
  const double all2 = farthest2(p);
  double reach2 = 4 * all2 * (1 + 1e-6), span2 = 0;
  for (int c = 1; c < 3; ++c) {
    const double by[3] = {d[c][0] - d[0][0], d[c][1] - d[0][1], d[c][2] - d[0][2]}, by2 = dot(by, by);
    span2 = by2 > span2 ? by2 : span2;
  }
  /* Most seeds are far from the whole triangle, as its first corner alone can tell: rows differ by no more than twice the span
   * along the way to the seed. The slack is far above what rounding and the rows' errors make. */
  const double far = 4.004 * span2, slack = 1e-9 * all2;
  const clip_near_list* list = &work->lists[cell];
  const clip_near* near = list->near;
  uint32_t count = list->count;
  for (uint32_t k = 0;; ++k) {
    while (k >= count) {
      if (list->reach2 > reach2) return SCREE_OK;
      const scree_result result = clip_near_find(work, cell, 0);
      if (result != SCREE_OK) return result;
      near = list->near;
      count = list->count;
    }
    const double distance2 = near[k].distance2;
    if (distance2 > reach2) return SCREE_OK;
    const double first = distance2 - 2 * dot(d[0], near[k].to) - slack;
    if (first > 0 && first * first > far * distance2) continue;
    part_cutter by;
    for (int c = 0; c < 3; ++c) by.row[c] = distance2 - 2 * dot(d[c], near[k].to);
    by.error = ROW_ERROR * (2 * distance2 + all2);
    if (by.row[0] > by.error && by.row[1] > by.error && by.row[2] > by.error) continue;
    by.seed = near[k].seed;
    const uint32_t before = p->cutter_count;
    const scree_result result = cut(p, &by, d);
    if (result != SCREE_OK) return result;
    if (p->cutter_count != before) reach2 = 4 * farthest2(p) * (1 + 1e-6);
  }
}

/* --- Vertices by their keys. --- */

static void sort3(uint32_t v[3]) {
  for (int a = 0; a < 2; ++a)
    for (int b = 0; b < 2; ++b)
      if (v[b] > v[b + 1]) {
        const uint32_t swapped = v[b];
        v[b] = v[b + 1];
        v[b + 1] = swapped;
      }
}

static void widen(clip_box* box, const double at[3]) {
  for (int axis = 0; axis < 3; ++axis) {
    if (at[axis] < box->min[axis]) box->min[axis] = at[axis];
    if (at[axis] > box->max[axis]) box->max[axis] = at[axis];
  }
}

/* Finds or makes the vertex of two or three cells. edge_end: CLIP_NONE within a triangle. */
static scree_result find_vertex(surface_cutter* s, uint32_t* first, uint32_t edge_end, const uint32_t cells[3],
                                const part_corner* corner, const uint32_t* triangle, uint32_t* out) {
  clip_work* work = s->work;
  const uint32_t mesh_count = work->input->vertex_count;
  for (uint32_t k = *first; k != CLIP_NONE; k = work->vertices[k].next) {
    clip_vertex* v = &work->vertices[k];
    if (v->edge_end != edge_end || v->cells[0] != cells[0] || v->cells[1] != cells[1] || v->cells[2] != cells[2]) continue;
    ++v->uses;
    *out = mesh_count + k;
    return SCREE_OK;
  }
  const uint32_t made = work->vertex_count;
  if (s->out->vertex_count >= UINT32_C(0x80000000)) return SCREE_ERROR_OUT_OF_MEMORY;
  scree_result result = clip_reserve(work->allocator, &work->vertices, &work->vertex_capacity, made, (size_t)made + 1);
  if (result != SCREE_OK) return result;
  result = clip_reserve_(work->allocator, (void**)&s->out->vertices, &s->out->vertex_capacity, s->out->vertex_count,
                         (size_t)s->out->vertex_count + 1, 3 * sizeof(double));
  if (result != SCREE_OK) return result;
  double* at = &s->out->vertices[3 * (size_t)s->out->vertex_count++];
  double longest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
      const double x = work->input->positions[3 * (size_t)triangle[c] + axis];
      sum += corner->share[c] * x;
      const double side = fabs(x - work->input->positions[3 * (size_t)triangle[(c + 1) % 3] + axis]);
      longest = side > longest ? side : longest;
    }
    at[axis] = sum;
  }
  work->vertices[made] = (clip_vertex){{cells[0], cells[1], cells[2]}, 1, edge_end, *first, corner->error * 4 * longest};
  work->vertex_count = made + 1;
  *first = made;
  *out = mesh_count + made;
  return SCREE_OK;
}

static scree_result name_corner(surface_cutter* s, const part_polygon* p, uint32_t k, const uint32_t* triangle, uint32_t t,
                                uint32_t cell, uint32_t* out) {
  const uint32_t side = p->now[k].side, before = p->now[k > 0 ? k - 1 : p->count - 1].side;
  if (side < 3 && before < 3) {
    *out = triangle[side];
    return SCREE_OK;
  }
  if (side >= 3 && before >= 3) {
    uint32_t cells[3] = {cell, p->cutters[side - 3].seed, p->cutters[before - 3].seed};
    sort3(cells);
    if (s->met[cells[0]] != t) { /* it meets the triangle, but has not had its turn */
      s->met[cells[0]] = t;
      s->first_within[cells[0]] = CLIP_NONE;
      const scree_result result =
          clip_reserve(s->work->allocator, &s->queue, &s->queue_capacity, s->queue_count, (size_t)s->queue_count + 1);
      if (result != SCREE_OK) return result;
      s->queue[s->queue_count++] = cells[0];
    }
    return find_vertex(s, &s->first_within[cells[0]], CLIP_NONE, cells, &p->now[k], triangle, out);
  }
  const uint32_t edge = side < 3 ? side : before, other = p->cutters[(side < 3 ? before : side) - 3].seed;
  const uint32_t a = triangle[edge], b = triangle[(edge + 1) % 3];
  const uint32_t cells[3] = {cell < other ? cell : other, cell < other ? other : cell, CLIP_NONE};
  return find_vertex(s, &s->edge_first[a < b ? a : b], a < b ? b : a, cells, &p->now[k], triangle, out);
}

/* --- Parts. --- */

static scree_result add_part(surface_cutter* s, uint32_t cell, uint32_t t, uint32_t count, uint32_t** corners) {
  clip_work* work = s->work;
  scree_result result =
      clip_reserve(work->allocator, &work->parts, &work->part_capacity, work->part_count, (size_t)work->part_count + 1);
  if (result == SCREE_OK)
    result = clip_reserve(work->allocator, &s->out->corners, &s->out->corner_capacity, s->out->corner_count,
                          (size_t)s->out->corner_count + count);
  if (result != SCREE_OK) return result;
  work->parts[work->part_count++] = (clip_part){cell, t, s->out->corner_count, count};
  *corners = &s->out->corners[s->out->corner_count];
  s->out->corner_count += count;
  return SCREE_OK;
}

static scree_result cut_triangle(surface_cutter* s, uint32_t t, part_polygon* p) {
  clip_work* work = s->work;
  const uint32_t* triangle = &work->input->indices[3 * (size_t)t];
  s->queue_count = 1;
  s->queue[0] = s->cell_of[triangle[0]];
  s->met[s->queue[0]] = t;
  s->first_within[s->queue[0]] = CLIP_NONE;
  for (uint32_t next = 0; next < s->queue_count; ++next) {
    const uint32_t cell = s->queue[next];
    uint32_t* corners;
    scree_result result = make_part(work, triangle, cell, p);
    if (result == SCREE_OK) result = add_part(s, cell, t, p->count, &corners);
    if (result != SCREE_OK) return result;
    for (uint32_t k = 0; k < p->count; ++k) {
      result = name_corner(s, p, k, triangle, t, cell, &corners[k]);
      if (result != SCREE_OK) return result;
      widen(&work->boxes[cell], &s->out->vertices[3 * (size_t)corners[k]]);
    }
    for (uint32_t k = 0; k < p->count; ++k) {
      if (p->now[k].side < 3) continue;
      const uint32_t other = p->cutters[p->now[k].side - 3].seed;
      if (other > cell) {
        result = clip_reserve(work->allocator, &work->segments, &work->segment_capacity, work->segment_count,
                              (size_t)work->segment_count + 1);
        if (result != SCREE_OK) return result;
        work->segments[work->segment_count++] = (clip_segment){{cell, other}, corners[k], corners[(k + 1) % p->count]};
      }
      if (s->met[other] == t) continue;
      s->met[other] = t;
      s->first_within[other] = CLIP_NONE;
      result = clip_reserve(work->allocator, &s->queue, &s->queue_capacity, s->queue_count, (size_t)s->queue_count + 1);
      if (result != SCREE_OK) return result;
      s->queue[s->queue_count++] = other;
    }
  }
  for (int c = 1; c < 3; ++c)
    if (s->met[s->cell_of[triangle[c]]] != t) return SCREE_ERROR_UNSUPPORTED;
  return SCREE_OK;
}

static scree_result cut_all(surface_cutter* s) {
  clip_work* work = s->work;
  const shard_input* input = work->input;
  part_polygon polygon;
  for (uint32_t t = 0; t < input->triangle_count; ++t) {
    const uint32_t* triangle = &input->indices[3 * (size_t)t];
    uint32_t near = CLIP_NONE;
    for (int c = 0; c < 3; ++c)
      if (near == CLIP_NONE) near = s->cell_of[triangle[c]];
    if (near == CLIP_NONE) near = voronoi_grid_nearest(&work->grid, &input->positions[3 * (size_t)triangle[0]]);
    for (int c = 0; c < 3; ++c) {
      if (s->cell_of[triangle[c]] != CLIP_NONE) continue;
      const scree_result result = walk(work, &input->positions[3 * (size_t)triangle[c]], &near);
      if (result != SCREE_OK) return result;
      s->cell_of[triangle[c]] = near;
    }
    const uint32_t cell = s->cell_of[triangle[0]];
    scree_result result;
    if (cell == s->cell_of[triangle[1]] && cell == s->cell_of[triangle[2]]) {
      uint32_t* corners;
      result = add_part(s, cell, t, 3, &corners);
      if (result == SCREE_OK)
        for (int c = 0; c < 3; ++c) {
          corners[c] = triangle[c];
          widen(&work->boxes[cell], &input->positions[3 * (size_t)triangle[c]]);
        }
    } else {
      result = cut_triangle(s, t, &polygon);
    }
    if (result != SCREE_OK) return result;
  }
  for (uint32_t k = 0; k < work->vertex_count; ++k)
    if (work->vertices[k].uses != (work->vertices[k].cells[2] == CLIP_NONE ? 4u : 3u)) return SCREE_ERROR_UNSUPPORTED;
  return SCREE_OK;
}

scree_result clip_surface(clip_work* work, shard_pieces* out) {
  const shard_input* input = work->input;
  const scree_allocator* allocator = work->allocator;
  const uint32_t vertex_count = input->vertex_count, seed_count = input->seed_count;
  surface_cutter s = {.work = work, .out = out};
  s.cell_of = scree_rt_allocate(allocator, vertex_count, sizeof(uint32_t));
  s.edge_first = scree_rt_allocate(allocator, vertex_count, sizeof(uint32_t));
  s.met = scree_rt_allocate(allocator, seed_count, sizeof(uint32_t));
  s.first_within = scree_rt_allocate(allocator, seed_count, sizeof(uint32_t));
  const size_t triangle_count = input->triangle_count;
  scree_result result = SCREE_ERROR_OUT_OF_MEMORY;
  if (s.cell_of != NULL && s.edge_first != NULL && s.met != NULL && s.first_within != NULL)
    result = clip_reserve(allocator, &s.queue, &s.queue_capacity, 0, 64);
  if (result == SCREE_OK) result = clip_reserve(allocator, &work->vertices, &work->vertex_capacity, 0, (size_t)vertex_count);
  if (result == SCREE_OK) result = clip_reserve(allocator, &work->segments, &work->segment_capacity, 0, triangle_count / 2);
  if (result == SCREE_OK) result = clip_reserve(allocator, &work->parts, &work->part_capacity, 0, triangle_count);
  if (result == SCREE_OK) {
    out->vertex_count = vertex_count;
    memcpy(out->vertices, input->positions, (size_t)vertex_count * 3 * sizeof(double));
    for (uint32_t v = 0; v < vertex_count; ++v) s.cell_of[v] = s.edge_first[v] = CLIP_NONE;
    for (uint32_t k = 0; k < seed_count; ++k) s.met[k] = CLIP_NONE;
    result = cut_all(&s);
  }
  scree_rt_release(allocator, s.cell_of, vertex_count, sizeof(uint32_t));
  scree_rt_release(allocator, s.edge_first, vertex_count, sizeof(uint32_t));
  scree_rt_release(allocator, s.met, seed_count, sizeof(uint32_t));
  scree_rt_release(allocator, s.first_within, seed_count, sizeof(uint32_t));
  scree_rt_release(allocator, s.queue, s.queue_capacity, sizeof(uint32_t));
  return result;
}
