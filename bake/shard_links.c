/* From polygons of cells to shards, links and their two graphs.
 *
 * Within a cell every edge of a polygon is met by the same edge, walked the other way, of another: polygons that meet so are one
 * shard, and their links are neighbours in the links graph. A cell's polygons fall into several shards where the solid is not
 * convex; a surface that encloses nothing but a hollow belongs to the shard around it. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "disjoint_sets.h"
#include "random.h"
#include "shards_internal.h"
#include "vectors.h"

static const double CLOSED = 1e-9; /* of a shard's area, and of the solid's volume */

typedef struct piece_measure {
  double vector[3]; /* area along the normal, out of cells[0] */
  double centroid[3];
  double area;
} piece_measure;

typedef struct half_edge {
  uint32_t low, high, half, stamp; /* stamp: of its cell, or none any more */
} half_edge;

/* What the edges of one cell are paired in: those that rise from the lower vertex to the higher, those that fall, and a hash table.
 */
typedef struct edge_lists {
  half_edge *ways[2], *table;
} edge_lists;

typedef struct half_pair {
  uint32_t a, b;
} half_pair;

typedef struct link_record {
  uint32_t shards[2], root;
} link_record;

/* A half is one side of a piece: 2 * piece + the side. Those of the outside are not used. */
typedef struct assembly {
  const scree_shards_desc* desc;
  const scree_allocator* allocator;
  const shard_pieces* pieces;
  scree_error* error;
  /* Everything below lies in one block, which is taken for the most that there can be: what is never used is never touched, and
   * what is dead makes room for what comes. Only what is of shards has its own where the block would be large, as there are far
   * fewer of them than could be. */
  unsigned char *memory, *shard_memory;
  size_t size, plain_size, used, shard_size; /* plain: without the shards */

  uint32_t cell_count, half_count, piece_count, shard_count, link_count, interior_count;
  piece_measure* measures;
  uint32_t *cell_first, *halves; /* of each cell */
  half_pair* pairs;
  uint32_t pair_count;
  uint32_t* half_parents;  /* by shard */
  uint32_t* piece_parents; /* by link */
  uint32_t* shard_of;      /* of each half */
  double* volumes;         /* of each half that is a root, in cells of several */
  scree_shard* shards;
  double* closing;  /* of each shard: the sum of area vectors, and of areas */
  uint32_t* starts; /* of each shard: its first half */
  link_record* records;
  uint32_t* link_of; /* of each piece */
  uint32_t *near_first, *near_count, *near;
  uint32_t near_total;
} assembly;

/* Adds so many elements to a size, and tells where they begin. */
static size_t place(size_t* size, size_t count, size_t of) {
  const size_t at = *size;
  *size += (count * of + SCREE_ALIGNMENT - 1) / SCREE_ALIGNMENT * SCREE_ALIGNMENT;
  return at;
}

static void* take(assembly* a, size_t count, size_t of) {
  return a->memory + place(&a->used, count, of);
}

static size_t place_shards(size_t* size, size_t count, size_t* at_closing, size_t* at_starts) {
  const size_t at = place(size, count, sizeof(scree_shard));
  *at_closing = place(size, count, 4 * sizeof(double));
  *at_starts = place(size, count, sizeof(uint32_t));
  return at;
}

/* In the order in which it is taken. A shard has a root among its halves: there are no more of them. */
static bool reserve(assembly* a) {
  const size_t pieces = a->piece_count, halves = a->half_count, corners = a->pieces->corner_count;
  size_t size = 0, early = 0, late = 0;
  place(&size, pieces, sizeof *a->measures);
  place(&size, a->cell_count + (size_t)2, sizeof *a->cell_first);
  for (int k = 0; k < 3; ++k) place(&size, halves, sizeof(uint32_t));
  for (int k = 0; k < 2; ++k) place(&size, pieces, sizeof(uint32_t));
  place(&size, corners, sizeof *a->pairs);
  place(&early, halves, sizeof *a->volumes);
  place(&early, halves, sizeof(uint32_t));
  place(&late, pieces, sizeof *a->records);
  place(&late, pieces + 2, sizeof *a->near_first);
  place(&late, pieces, sizeof *a->near_count);
  place(&late, 2 * corners, sizeof(uint32_t));
  a->size = a->plain_size = size + (early > late ? early : late);
  /* Blocks from 32 MiB on are given back at each release by glibc, to be cleared anew at the next touch. */
  const size_t most = (size_t)32 << 20;
  size_t unused[2];
  place_shards(&a->size, halves, unused, unused + 1);
  if (a->size >= most) a->size = a->plain_size;
  a->memory = scree_rt_allocate(a->allocator, a->size, 1);
  return a->memory != NULL;
}

static scree_result wrong(assembly* a, const char* what, uint32_t seed, const double place[3]) {
  if (a->error != NULL)
    snprintf(a->error->message, sizeof a->error->message, "the cell of seed %u %s, near (%g, %g, %g)", seed, what, place[0],
             place[1], place[2]);
  return SCREE_ERROR_UNSUPPORTED;
}

/* --- polygons --------------------------------------------------------------------------------------------------------------- */

static void measure_piece(const shard_pieces* pieces, const shard_piece* piece, piece_measure* out) {
  const uint32_t* corners = pieces->corners + piece->first_corner;
  const double* origin = pieces->vertices + 3 * (size_t)corners[0];
  double vector[3] = {0}, moment[3] = {0}, sum = 0;
  double before[3] = {0};
  /* Twice the area vector first: the centroid weighs triangles by their part of it, so that those of hollow corners count less
   * than nothing. */
  for (uint32_t i = 1; i < piece->corner_count; ++i) {
    const double* p = pieces->vertices + 3 * (size_t)corners[i];
    const double d[3] = {p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]};
    vector[0] += before[1] * d[2] - before[2] * d[1];
    vector[1] += before[2] * d[0] - before[0] * d[2];
    vector[2] += before[0] * d[1] - before[1] * d[0];
    memcpy(before, d, sizeof before);
  }
  const double length = sqrt(dot(vector, vector));
  out->area = length / 2;
  for (int axis = 0; axis < 3; ++axis) out->vector[axis] = vector[axis] / 2;
  if (length > 0) {
    memset(before, 0, sizeof before);
    for (uint32_t i = 1; i < piece->corner_count; ++i) {
      const double* p = pieces->vertices + 3 * (size_t)corners[i];
      const double d[3] = {p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]};
      const double part = (before[1] * d[2] - before[2] * d[1]) * vector[0] + (before[2] * d[0] - before[0] * d[2]) * vector[1] +
                          (before[0] * d[1] - before[1] * d[0]) * vector[2];
      sum += part;
      for (int axis = 0; axis < 3; ++axis) moment[axis] += part * (before[axis] + d[axis]);
      memcpy(before, d, sizeof before);
    }
  }
  for (int axis = 0; axis < 3; ++axis) out->centroid[axis] = origin[axis] + (sum > 0 ? moment[axis] / (3 * sum) : 0);
}

static bool list_halves(assembly* a) {
  const shard_pieces* pieces = a->pieces;
  a->piece_count = pieces->piece_count;
  a->half_count = 2 * pieces->piece_count;
  a->cell_count = 0;
  for (uint32_t i = 0; i < a->piece_count; ++i)
    for (int side = 0; side < 2; ++side) {
      const uint32_t cell = pieces->pieces[i].cells[side];
      if (cell != PIECE_OUTSIDE && cell >= a->cell_count) a->cell_count = cell + 1;
    }
  if (!reserve(a)) return false;
  a->measures = take(a, a->piece_count, sizeof *a->measures);
  a->cell_first = take(a, a->cell_count + (size_t)2, sizeof *a->cell_first);
  a->halves = take(a, a->half_count, sizeof *a->halves);
  a->half_parents = take(a, a->half_count, sizeof *a->half_parents);
  a->shard_of = take(a, a->half_count, sizeof *a->shard_of);
  a->piece_parents = take(a, a->piece_count, sizeof *a->piece_parents);
  a->link_of = take(a, a->piece_count, sizeof *a->link_of);
  a->pairs = take(a, pieces->corner_count, sizeof *a->pairs);
  memset(a->cell_first, 0, (a->cell_count + (size_t)2) * sizeof *a->cell_first);
  for (uint32_t i = 0; i < a->piece_count; ++i) {
    measure_piece(pieces, pieces->pieces + i, a->measures + i);
    a->piece_parents[i] = i;
    for (uint32_t side = 0; side < 2; ++side) {
      const uint32_t cell = pieces->pieces[i].cells[side];
      a->half_parents[2 * i + side] = 2 * i + side;
      a->shard_of[2 * i + side] = SCREE_NO_SHARD;
      if (cell != PIECE_OUTSIDE) ++a->cell_first[cell + 2];
    }
  }
  for (uint32_t cell = 0; cell < a->cell_count; ++cell) a->cell_first[cell + 2] += a->cell_first[cell + 1];
  for (uint32_t half = 0; half < a->half_count; ++half) {
    const uint32_t cell = pieces->pieces[half / 2].cells[half % 2];
    if (cell != PIECE_OUTSIDE) a->halves[a->cell_first[cell + 1]++] = half;
  }
  return true;
}

/* --- edges of cells --------------------------------------------------------------------------------------------------------- */

static uint32_t edge_hash(const half_edge* edge) {
  return (edge->low * UINT32_C(0x9e3779b1) ^ edge->high * UINT32_C(0x85ebca6b)) >> 7;
}

static scree_result wrong_edge(assembly* a, uint32_t cell, const half_edge* edge) {
  return wrong(a, "has an edge without its other side", cell, a->pieces->vertices + 3 * (size_t)edge->low);
}

/* Finds for each edge of a cell the same edge walked the other way, and joins their halves. Of several alike, the first goes with
 * the first. The two ways are told apart without a branch, for there is nothing to foresee. */
static scree_result pair_cell(assembly* a, uint32_t cell, const edge_lists* lists, uint32_t mask) {
  const shard_pieces* pieces = a->pieces;
  const uint32_t stamp = cell + 1;
  uint32_t counts[2] = {0};
  for (uint32_t k = a->cell_first[cell]; k < a->cell_first[cell + 1]; ++k) {
    const uint32_t half = a->halves[k];
    const shard_piece* piece = pieces->pieces + half / 2;
    const uint32_t* corners = pieces->corners + piece->first_corner;
    uint32_t before = corners[piece->corner_count - 1];
    for (uint32_t i = 0; i < piece->corner_count; ++i) {
      const uint32_t corner = corners[i], rises = before < corner, way = rises ^ (half & 1);
      lists->ways[way][counts[way]++] = (half_edge){rises ? before : corner, rises ? corner : before, half, stamp};
      before = corner;
    }
  }
  for (uint32_t i = 0; i < counts[0]; ++i) {
    uint32_t at = edge_hash(lists->ways[0] + i);
    while (lists->table[at & mask].stamp == stamp) ++at;
    lists->table[at & mask] = lists->ways[0][i];
  }
  for (uint32_t i = 0; i < counts[1]; ++i) {
    const half_edge* edge = lists->ways[1] + i;
    uint32_t at = edge_hash(edge);
    half_edge* other = lists->table + (at & mask);
    while (other->stamp == stamp && (other->low != edge->low || other->high != edge->high || other->half == UINT32_MAX))
      other = lists->table + (++at & mask);
    if (other->stamp != stamp) return wrong_edge(a, cell, edge);
    if (other->half != edge->half) {
      a->pairs[a->pair_count++] = (half_pair){other->half, edge->half};
      join(a->half_parents, other->half, edge->half);
    }
    other->half = UINT32_MAX;
  }
  if (counts[0] == counts[1]) return SCREE_OK;
  for (uint32_t i = 0; i <= mask; ++i)
    if (lists->table[i].stamp == stamp && lists->table[i].half != UINT32_MAX) return wrong_edge(a, cell, lists->table + i);
  return SCREE_ERROR_UNSUPPORTED;
}

static uint32_t edges_of(const assembly* a, uint32_t cell) {
  uint32_t edges = 0;
  for (uint32_t k = a->cell_first[cell]; k < a->cell_first[cell + 1]; ++k)
    edges += a->pieces->pieces[a->halves[k] / 2].corner_count;
  return edges;
}

static scree_result pair_edges(assembly* a) {
  uint32_t most = 1, size = 64;
  for (uint32_t cell = 0; cell < a->cell_count; ++cell) {
    const uint32_t edges = edges_of(a, cell);
    most = edges > most ? edges : most;
  }
  while (size < 2 * (uint64_t)most && size < UINT32_C(1) << 31) size *= 2;
  half_edge* both = scree_rt_allocate(a->allocator, most, 2 * sizeof *both);
  half_edge* table = scree_rt_allocate_zeroed(a->allocator, size, sizeof *table);
  scree_result result = both == NULL || table == NULL ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_OK;
  for (uint32_t cell = 0; cell < a->cell_count && result == SCREE_OK; ++cell) {
    const uint32_t edges = edges_of(a, cell);
    uint32_t part = 63;
    while (part < 2 * (uint64_t)edges && part < size - 1) part = 2 * part + 1;
    const edge_lists lists = {.ways = {both, both + most}, .table = table};
    result = pair_cell(a, cell, &lists, part);
  }
  scree_rt_release(a->allocator, both, most, 2 * sizeof *both);
  scree_rt_release(a->allocator, table, size, sizeof *table);
  return result;
}

/* --- shards ----------------------------------------------------------------------------------------------------------------- */

/* Adds what a half says of its shard. The volume of a closed surface does not depend on the origin. */
static void add_half(const assembly* a, uint32_t half, const double origin[3], double* volume, double moment[3]) {
  const piece_measure* m = a->measures + half / 2;
  const double d[3] = {m->centroid[0] - origin[0], m->centroid[1] - origin[1], m->centroid[2] - origin[2]};
  const double part = (half % 2 == 0 ? 1 : -1) * dot(m->vector, d) / 3;
  *volume += part;
  for (int axis = 0; axis < 3; ++axis) moment[axis] += part * 0.75 * d[axis];
}

static const double* origin_of(const assembly* a, uint32_t half) {
  return a->pieces->vertices + 3 * (size_t)a->pieces->corners[a->pieces->pieces[half / 2].first_corner];
}

/* How often the surface of a root's halves winds round a point, by a ray that is along no axis. */
static int winding(assembly* a, uint32_t cell, uint32_t root, const double point[3]) {
  static const double SLANT_X = 0.0123456789, SLANT_Z = 0.0456789123;
  int turns = 0;
  for (uint32_t k = a->cell_first[cell]; k < a->cell_first[cell + 1]; ++k) {
    const uint32_t half = a->halves[k];
    if (root_of(a->half_parents, half) != root) continue;
    const shard_piece* piece = a->pieces->pieces + half / 2;
    const uint32_t* corners = a->pieces->corners + piece->first_corner;
    double p[3][3];
    for (uint32_t i = 2; i < piece->corner_count; ++i) {
      const uint32_t fan[3] = {corners[0], corners[i - 1], corners[i]};
      for (int c = 0; c < 3; ++c) {
        const double* v = a->pieces->vertices + 3 * (size_t)fan[c];
        p[c][1] = v[1] - point[1];
        p[c][0] = v[0] - point[0] - SLANT_X * p[c][1];
        p[c][2] = v[2] - point[2] - SLANT_Z * p[c][1];
      }
      double w[3];
      for (int c = 0; c < 3; ++c) {
        const double *q = p[(c + 1) % 3], *r = p[(c + 2) % 3];
        w[c] = q[0] * r[2] - q[2] * r[0];
      }
      const bool up = w[0] > 0 && w[1] > 0 && w[2] > 0, down = w[0] < 0 && w[1] < 0 && w[2] < 0;
      if (!up && !down) continue;
      const double height = (w[0] * p[0][1] + w[1] * p[1][1] + w[2] * p[2][1]) / (w[0] + w[1] + w[2]);
      if (height > 0) turns += (up ? 1 : -1) * (half % 2 == 0 ? 1 : -1);
    }
  }
  return turns;
}

/* Gives hollows of one cell to the shard around them. */
static scree_result join_hollows(assembly* a, uint32_t cell) {
  const double* volumes = a->volumes;
  const uint32_t first = a->cell_first[cell], end = a->cell_first[cell + 1];
  for (uint32_t k = first; k < end; ++k) {
    const uint32_t hollow = a->halves[k];
    if (a->half_parents[hollow] != hollow || volumes[hollow] > 0) continue;
    uint32_t around = UINT32_MAX, largest = UINT32_MAX;
    for (uint32_t i = first; i < end; ++i) {
      const uint32_t half = a->halves[i];
      if (a->half_parents[half] != half || !(volumes[half] > 0)) continue;
      if (largest == UINT32_MAX || volumes[half] > volumes[largest]) largest = half;
      if ((around == UINT32_MAX || volumes[half] < volumes[around]) && volumes[half] > -volumes[hollow] &&
          winding(a, cell, half, origin_of(a, hollow)) != 0)
        around = half;
    }
    if (around == UINT32_MAX) around = largest;
    if (around == UINT32_MAX || !(volumes[around] > -volumes[hollow]))
      return wrong(a, "encloses less than nothing", cell, origin_of(a, hollow));
    /* Not through join: the lower of the two is not always the one around. */
    a->shard_of[hollow] = around;
  }
  return SCREE_OK;
}

/* In the block's last part, or in memory of its own. */
static bool take_shards(assembly* a) {
  size_t size = 0, at_closing, at_starts;
  const size_t at_shards = place_shards(&size, a->shard_count, &at_closing, &at_starts);
  unsigned char* memory = a->memory + a->plain_size;
  if (size > a->size - a->plain_size) {
    memory = a->shard_memory = scree_rt_allocate(a->allocator, size, 1);
    if (memory == NULL) return false;
    a->shard_size = size;
  }
  a->shards = (void*)(memory + at_shards);
  a->closing = (void*)(memory + at_closing);
  a->starts = (void*)(memory + at_starts);
  return true;
}

static scree_result find_shards(assembly* a) {
  const size_t mark = a->used;
  double* volumes = a->volumes = take(a, a->half_count, sizeof *volumes);
  uint32_t* ids = take(a, a->half_count, sizeof *ids);
  a->shard_count = 0;
  for (uint32_t cell = 0; cell < a->cell_count; ++cell) {
    const uint32_t first = a->cell_first[cell], end = a->cell_first[cell + 1];
    uint32_t roots = 0;
    bool hollow = false;
    for (uint32_t k = first; k < end; ++k) {
      const uint32_t half = a->halves[k];
      if (root_of(a->half_parents, half) != half) continue;
      a->shard_of[half] = half;
      ++roots;
    }
    a->shard_count += roots;
    if (roots > 1) {
      double unused[3] = {0};
      for (uint32_t k = first; k < end; ++k) volumes[a->halves[k]] = 0;
      for (uint32_t k = first; k < end; ++k)
        add_half(a, a->halves[k], origin_of(a, a->halves[first]), volumes + root_of(a->half_parents, a->halves[k]), unused);
      for (uint32_t k = first; k < end; ++k)
        hollow = hollow || (a->half_parents[a->halves[k]] == a->halves[k] && !(volumes[a->halves[k]] > 0));
      const scree_result result = hollow ? join_hollows(a, cell) : SCREE_OK;
      if (result != SCREE_OK) return result;
    }
  }
  if (!take_shards(a)) return SCREE_ERROR_OUT_OF_MEMORY;
  a->shard_count = 0;
  for (uint32_t cell = 0; cell < a->cell_count; ++cell) {
    const uint32_t first = a->cell_first[cell], end = a->cell_first[cell + 1];
    for (uint32_t k = first; k < end; ++k) {
      const uint32_t half = a->halves[k];
      if (a->half_parents[half] != half || a->shard_of[half] != half) continue;
      a->shards[a->shard_count] = (scree_shard){.seed = cell};
      ids[half] = a->shard_count++;
    }
    for (uint32_t k = first; k < end; ++k) { /* roots are read as long as halves after them ask for them */
      const uint32_t half = a->halves[end - 1 - (k - first)];
      a->shard_of[half] = ids[a->shard_of[root_of(a->half_parents, half)]];
    }
  }
  a->used = mark;
  return SCREE_OK;
}

static scree_result measure_shards(assembly* a) {
  double solid_volume = 0, sum = 0, middle[3];
  const scree_solid* solid = &a->desc->solid;
  memcpy(middle, solid->positions, sizeof middle);
  for (size_t t = 0; t < solid->triangle_count; ++t) {
    double p[3][3];
    for (int c = 0; c < 3; ++c)
      for (int axis = 0; axis < 3; ++axis)
        p[c][axis] = solid->positions[3 * (size_t)solid->indices[3 * t + (size_t)c] + (size_t)axis] - middle[axis];
    solid_volume += (p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) + p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
                     p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0])) /
                    6;
  }
  double* closing = a->closing;
  uint32_t* starts = a->starts;
  memset(closing, 0, a->shard_count * 4 * sizeof *closing);
  memset(starts, 0xff, a->shard_count * sizeof *starts);
  for (uint32_t k = 0; k < a->cell_first[a->cell_count]; ++k) {
    const uint32_t half = a->halves[k], id = a->shard_of[half];
    const piece_measure* m = a->measures + half / 2;
    if (starts[id] == UINT32_MAX) starts[id] = half;
    add_half(a, half, origin_of(a, starts[id]), &a->shards[id].volume, a->shards[id].centroid);
    for (int axis = 0; axis < 3; ++axis) closing[4 * (size_t)id + (size_t)axis] += (half % 2 == 0 ? 1 : -1) * m->vector[axis];
    closing[4 * (size_t)id + 3] += m->area;
  }
  for (uint32_t id = 0; id < a->shard_count; ++id) {
    scree_shard* shard = a->shards + id;
    const double* origin = origin_of(a, starts[id]);
    const double* open = closing + 4 * (size_t)id;
    if (!(shard->volume > 0)) return wrong(a, "has a shard without volume", shard->seed, origin);
    if (!(sqrt(dot(open, open)) <= CLOSED * open[3])) return wrong(a, "has a shard that is not closed", shard->seed, origin);
    for (int axis = 0; axis < 3; ++axis) shard->centroid[axis] = origin[axis] + shard->centroid[axis] / shard->volume;
    sum += shard->volume;
  }
  if (fabs(sum - solid_volume) <= CLOSED * solid_volume) return SCREE_OK;
  if (a->error != NULL)
    snprintf(a->error->message, sizeof a->error->message, "shards have a volume of %.17g together, the solid has %.17g", sum,
             solid_volume);
  return SCREE_ERROR_UNSUPPORTED;
}

/* --- links ------------------------------------------------------------------------------------------------------------------ */

static int by_shards(const void* a, const void* b) {
  const link_record *p = a, *q = b;
  const bool p_out = p->shards[1] == SCREE_NO_SHARD, q_out = q->shards[1] == SCREE_NO_SHARD;
  if (p_out != q_out) return p_out ? 1 : -1;
  if (p->shards[0] != q->shards[0]) return p->shards[0] < q->shards[0] ? -1 : 1;
  if (p->shards[1] != q->shards[1]) return p->shards[1] < q->shards[1] ? -1 : 1;
  return p->root < q->root ? -1 : p->root > q->root;
}

/* Pieces of one link: between the same cells, or turned by less than the angle on the surface. */
static void join_pieces(assembly* a) {
  const shard_piece* pieces = a->pieces->pieces;
  const double angle = a->desc->link_angle == 0 ? 0.35 : a->desc->link_angle;
  const double cosine = repeatable_cos_to_pi(angle);
  for (uint32_t i = 0; i < a->pair_count; ++i) {
    const uint32_t p = a->pairs[i].a / 2, q = a->pairs[i].b / 2;
    if (pieces[p].cells[1] != pieces[q].cells[1] || pieces[p].cells[0] != pieces[q].cells[0]) continue;
    const piece_measure *m = a->measures + p, *n = a->measures + q;
    /* A piece without area has no direction of its own. */
    if (pieces[p].cells[1] != PIECE_OUTSIDE || dot(m->vector, n->vector) >= cosine * m->area * n->area)
      join(a->piece_parents, p, q);
  }
}

static void list_links(assembly* a) {
  uint32_t inside = 0, outside = 0;
  for (uint32_t i = 0; i < a->piece_count; ++i)
    if (root_of(a->piece_parents, i) == i) {
      inside += a->pieces->pieces[i].cells[1] != PIECE_OUTSIDE;
      outside += a->pieces->pieces[i].cells[1] == PIECE_OUTSIDE;
    }
  a->records = take(a, inside + (size_t)outside, sizeof *a->records);
  a->interior_count = inside;
  a->link_count = inside + outside;
  uint32_t at_inside = 0, at_outside = inside;
  for (uint32_t i = 0; i < a->piece_count; ++i) {
    if (a->piece_parents[i] != i) continue;
    const bool out = a->pieces->pieces[i].cells[1] == PIECE_OUTSIDE;
    a->records[out ? at_outside++ : at_inside++] = (link_record){{a->shard_of[2 * i], a->shard_of[2 * i + 1]}, i};
  }
  /* Mostly sorted already: only cells of several shards mix them. */
  for (uint32_t i = 1; i < a->link_count; ++i)
    if (by_shards(a->records + i - 1, a->records + i) > 0) {
      qsort(a->records, a->link_count, sizeof *a->records, by_shards);
      break;
    }
  for (uint32_t i = 0; i < a->link_count; ++i) a->link_of[a->records[i].root] = i;
  for (uint32_t i = 0; i < a->piece_count; ++i) a->link_of[i] = a->link_of[root_of(a->piece_parents, i)];
}

/* The links graph: each list of neighbours is turned round, by rising link, into a rising list without doubles, which takes the
 * place of the pairs. */
static void list_neighbours(assembly* a) {
  uint32_t* first = take(a, a->link_count + (size_t)2, sizeof *first);
  a->near_count = take(a, a->link_count, sizeof *a->near_count);
  a->near_first = first;
  uint32_t* unsorted = take(a, 2 * (size_t)a->pair_count, sizeof *unsorted);
  memset(first, 0, (a->link_count + (size_t)2) * sizeof *first);
  memset(a->near_count, 0, a->link_count * sizeof *a->near_count);
  for (uint32_t i = 0; i < a->pair_count; ++i) {
    const uint32_t p = a->link_of[a->pairs[i].a / 2], q = a->link_of[a->pairs[i].b / 2];
    a->pairs[i] = (half_pair){p, q};
    if (p == q) continue;
    ++first[p + 2];
    ++first[q + 2];
  }
  for (uint32_t i = 0; i < a->link_count; ++i) first[i + 2] += first[i + 1];
  for (uint32_t i = 0; i < a->pair_count; ++i) {
    const half_pair pair = a->pairs[i];
    if (pair.a == pair.b) continue;
    unsorted[first[pair.a + 1]++] = pair.b;
    unsorted[first[pair.b + 1]++] = pair.a;
  }
  a->near = (void*)a->pairs;
  a->near_total = 0;
  for (uint32_t p = 0; p < a->link_count; ++p)
    for (uint32_t k = first[p]; k < first[p + 1]; ++k) {
      const uint32_t q = unsorted[k];
      uint32_t* list = a->near + first[q];
      if (a->near_count[q] > 0 && list[a->near_count[q] - 1] == p) continue;
      list[a->near_count[q]++] = p;
      ++a->near_total;
    }
}

/* --- the result ------------------------------------------------------------------------------------------------------------- */

static void write_links(const assembly* a, scree_link* links, scree_polygon* polygons, uint32_t* corners) {
  for (uint32_t i = 0; i < a->link_count; ++i)
    links[i] = (scree_link){.shards = {a->records[i].shards[0], a->records[i].shards[1]}};
  for (uint32_t i = 0; i < a->piece_count; ++i) ++links[a->link_of[i]].polygon_count;
  uint32_t polygon = 0, corner = 0;
  for (uint32_t i = 0; i < a->link_count; ++i) {
    links[i].first_polygon = polygon;
    polygon += links[i].polygon_count;
    links[i].polygon_count = 0;
  }
  for (uint32_t i = 0; i < a->piece_count; ++i) {
    scree_link* link = links + a->link_of[i];
    const shard_piece* piece = a->pieces->pieces + i;
    const piece_measure* m = a->measures + i;
    polygons[link->first_polygon + link->polygon_count++] =
        (scree_polygon){piece->first_corner, piece->corner_count, piece->triangle};
    link->area += m->area;
    for (int axis = 0; axis < 3; ++axis) {
      link->normal[axis] += m->vector[axis];
      link->centroid[axis] += m->area * (m->centroid[axis] - a->measures[a->records[a->link_of[i]].root].centroid[axis]);
    }
  }
  for (uint32_t i = 0; i < polygon; ++i) {
    memcpy(corners + corner, a->pieces->corners + polygons[i].first_corner, polygons[i].corner_count * sizeof *corners);
    polygons[i].first_corner = corner;
    corner += polygons[i].corner_count;
  }
  for (uint32_t i = 0; i < a->link_count; ++i) {
    scree_link* link = links + i;
    const double* from = a->measures[a->records[i].root].centroid;
    for (int axis = 0; axis < 3; ++axis)
      link->centroid[axis] = from[axis] + (link->area > 0 ? link->centroid[axis] / link->area : 0);
    double length = sqrt(dot(link->normal, link->normal));
    if (!(length > 0)) { /* no area: away from the shard, as well as can be said */
      for (int axis = 0; axis < 3; ++axis) link->normal[axis] = link->centroid[axis] - a->shards[link->shards[0]].centroid[axis];
      length = sqrt(dot(link->normal, link->normal));
    }
    for (int axis = 0; axis < 3; ++axis) link->normal[axis] = length > 0 ? link->normal[axis] / length : axis == 1;
  }
}

static void write_shard_links(const assembly* a, const scree_link* links, scree_shard* shards, uint32_t* shard_links) {
  memcpy(shards, a->shards, a->shard_count * sizeof *shards);
  for (uint32_t i = 0; i < a->link_count; ++i)
    for (int side = 0; side < 2; ++side)
      if (links[i].shards[side] != SCREE_NO_SHARD) ++shards[links[i].shards[side]].link_count;
  uint32_t first = 0;
  for (uint32_t i = 0; i < a->shard_count; ++i) {
    shards[i].first_link = first;
    first += shards[i].link_count;
    shards[i].link_count = 0;
  }
  for (uint32_t i = 0; i < a->link_count; ++i)
    for (int side = 0; side < 2; ++side)
      if (links[i].shards[side] != SCREE_NO_SHARD) {
        scree_shard* shard = shards + links[i].shards[side];
        shard_links[shard->first_link + shard->link_count++] = i;
      }
}

static scree_result write_shards(const assembly* a, scree_shards** out) {
  const shard_pieces* pieces = a->pieces;
  const scree_solid* solid = &a->desc->solid;
  const size_t sides = a->link_count + (size_t)a->interior_count, triangles = solid->triangle_count;
  size_t size = 0;
  const size_t at_shards = place(&size, a->shard_count, sizeof(scree_shard)),
               at_links = place(&size, a->link_count, sizeof(scree_link));
  const size_t at_polygons = place(&size, a->piece_count, sizeof(scree_polygon)),
               at_corners = place(&size, pieces->corner_count, sizeof(uint32_t));
  const size_t at_vertices = place(&size, pieces->vertex_count, 3 * sizeof(double)),
               at_sides = place(&size, sides, sizeof(uint32_t));
  const size_t at_first = place(&size, a->link_count + (size_t)1, sizeof(uint32_t)),
               at_near = place(&size, a->near_total, sizeof(uint32_t));
  const size_t at_positions = place(&size, solid->vertex_count, 3 * sizeof(double)),
               at_indices = place(&size, triangles, 3 * sizeof(uint32_t));
  const size_t at_uvs = place(&size, solid->uvs == NULL ? 0 : triangles, 6 * sizeof(float));
  scree_shards* made = scree_rt_allocate_zeroed(a->allocator, 1, sizeof *made);
  unsigned char* memory = made == NULL ? NULL : scree_rt_allocate(a->allocator, size, 1);
  if (memory == NULL) {
    scree_rt_release(a->allocator, made, 1, sizeof *made);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  *made = (scree_shards){.allocator = *a->allocator, .memory = memory, .size = size};
  scree_shard* shards = (void*)(memory + at_shards);
  scree_link* links = (void*)(memory + at_links);
  uint32_t *first = (void*)(memory + at_first), *near = (void*)(memory + at_near);
  write_links(a, links, (void*)(memory + at_polygons), (void*)(memory + at_corners));
  write_shard_links(a, links, shards, (void*)(memory + at_sides));
  memcpy(memory + at_vertices, pieces->vertices, pieces->vertex_count * 3 * sizeof(double));
  first[0] = 0;
  for (uint32_t i = 0; i < a->link_count; ++i) {
    memcpy(near + first[i], a->near + a->near_first[i], a->near_count[i] * sizeof *near);
    first[i + 1] = first[i] + a->near_count[i];
  }
  memcpy(memory + at_positions, solid->positions, solid->vertex_count * 3 * sizeof(double));
  memcpy(memory + at_indices, solid->indices, triangles * 3 * sizeof(uint32_t));
  if (solid->uvs != NULL) memcpy(memory + at_uvs, solid->uvs, triangles * 6 * sizeof(float));
  made->solid =
      (scree_solid){(void*)(memory + at_positions), (void*)(memory + at_indices), NULL, solid->vertex_count, solid->triangle_count};
  if (solid->uvs != NULL) made->solid.uvs = (void*)(memory + at_uvs);

  scree_shards_view* view = &made->view;
  *view = (scree_shards_view){.shards = shards,
                              .links = links,
                              .polygons = (void*)(memory + at_polygons),
                              .corners = (void*)(memory + at_corners),
                              .vertices = (void*)(memory + at_vertices),
                              .shard_links = (void*)(memory + at_sides),
                              .neighbour_first = first,
                              .neighbours = near,
                              .shard_count = a->shard_count,
                              .link_count = a->link_count,
                              .interior_link_count = a->interior_count,
                              .polygon_count = a->piece_count,
                              .corner_count = pieces->corner_count,
                              .vertex_count = pieces->vertex_count,
                              .clip = a->desc->clip,
                              .solid = &made->solid};
  for (uint32_t i = 0; i < a->shard_count; ++i) view->volume += shards[i].volume;
  for (uint32_t i = 0; i < a->link_count; ++i) view->mean_link_area += (i < a->interior_count ? 2 : 1) * links[i].area;
  if (sides > 0) view->mean_link_area /= (double)sides;
  for (int axis = 0; axis < 3; ++axis) {
    view->min[axis] = view->max[axis] = solid->positions[axis];
    for (size_t v = 1; v < solid->vertex_count; ++v) {
      const double x = solid->positions[3 * v + (size_t)axis];
      if (x < view->min[axis]) view->min[axis] = x;
      if (x > view->max[axis]) view->max[axis] = x;
    }
  }
  *out = made;
  return SCREE_OK;
}

scree_result shards_assemble(const scree_shards_desc* desc, const shard_pieces* pieces, scree_shards** out, scree_error* error) {
  const scree_allocator allocator = scree_rt_allocator_or_default(&desc->allocator);
  assembly a = {.desc = desc, .allocator = &allocator, .pieces = pieces, .error = error};
  scree_result result = list_halves(&a) ? pair_edges(&a) : SCREE_ERROR_OUT_OF_MEMORY;
  if (result == SCREE_OK) result = find_shards(&a);
  if (result == SCREE_OK) result = measure_shards(&a);
  if (result == SCREE_OK) {
    join_pieces(&a);
    list_links(&a);
    list_neighbours(&a);
    result = write_shards(&a, out);
  }
  scree_rt_release(&allocator, a.memory, a.size, 1);
  scree_rt_release(&allocator, a.shard_memory, a.shard_size, 1);
  return result;
}
