/* Where what fell comes to rest: columns of what is solid, and blocks that are put onto them one after another. Motion is not
 * simulated in time: each block goes the way a stone would and stays where it would lie, which is what a heap looks like. */
#include <math.h>
#include <string.h>

#include "faults.h"
#include "frost_internal.h"
#include "random.h"
#include "rubble_internal.h"
#include "support_text.h"

#define MOST_COLUMNS (1u << 24)
#define DEEP (-1e9)
#define FEW_COLUMNS 8
#define THINNEST 0.1 /* of what is not dust, in columns */

/* All that a call of rubble_settle needs. */
typedef struct work {
  const rubble_input* input;
  const scree_rubble_desc* desc;
  scree_allocator allocator;
  double frame[3][3];     /* rows: x, y, z of rubble's frame, y up, in the world */
  double low[3], high[3]; /* of the solid in it */
  double reach, repose;
  dexels solid, rock; /* with the blocks that rest; what stands */
  rubble_flood* flood;
  double* places; /* of all vertices, in it */
  double* points; /* of one block */
  uint32_t point_capacity;
  rubble_raster rasters[2];
  double mean_volume; /* of blocks that are kept */
} work;

static scree_result check(const scree_rubble_desc* desc, scree_error* error) {
  scree_rt_text_clear(error);
  if (!within(desc->ground, -1e6, 1e6)) return fault_value(error, "ground", desc->ground, "within 1e6");
  if (!within(desc->resolution, 0, 1e6)) return fault_value(error, "resolution", desc->resolution, "0 to 1e6");
  if (!within(desc->repose, 0, 100)) return fault_value(error, "repose", desc->repose, "0 to 100");
  if (!within(desc->min_volume, 0, 1e18)) return fault_value(error, "min_volume", desc->min_volume, "0 to 1e18");
  if (!within(desc->share, 0, 1)) return fault_value(error, "share", desc->share, "0 to 1");
  if (!within(desc->reach, 0, 1e6)) return fault_value(error, "reach", desc->reach, "0 to 1e6");
  if (desc->heights == NULL) return SCREE_OK;
  if (desc->width < 2) return fault_value(error, "width", desc->width, "at least 2");
  if (desc->depth < 2) return fault_value(error, "depth", desc->depth, "at least 2");
  if (!within(desc->spacing, 1e-6, 1e6)) return fault_value(error, "spacing", desc->spacing, "1e-6 to 1e6");
  for (size_t i = 0; i < (size_t)desc->width * desc->depth; ++i)
    if (!within(desc->heights[i], -1e6, 1e6)) return fault_value(error, "heights", desc->heights[i], "within 1e6");
  return SCREE_OK;
}

/* --- frame and grid --------------------------------------------------------------------------------------------------------------
 */

/* The world's own axes where gravity is -Y. */
static void make_frame(work* w) {
  const double* g = w->input->gravity;
  double(*f)[3] = w->frame;
  const double up[3] = {-g[0], -g[1], -g[2]};
  const int axis = up[0] * up[0] < 0.75 ? 0 : 2;
  double side[3], length = 0;
  for (int k = 0; k < 3; ++k) {
    side[k] = (k == axis ? 1 : 0) - up[axis] * up[k];
    length += side[k] * side[k];
  }
  for (int k = 0; k < 3; ++k) {
    f[0][k] = side[k] / sqrt(length);
    f[1][k] = up[k];
  }
  for (int k = 0; k < 3; ++k) {
    const int u = (k + 1) % 3, v = (k + 2) % 3;
    f[2][k] = f[0][u] * f[1][v] - f[0][v] * f[1][u];
  }
}

static void to_frame(const work* w, const double p[3], double out[3]) {
  for (int k = 0; k < 3; ++k) out[k] = w->frame[k][0] * p[0] + w->frame[k][1] * p[1] + w->frame[k][2] * p[2];
}

static void to_world(const work* w, const double p[3], double out[3]) {
  for (int k = 0; k < 3; ++k) out[k] = w->frame[0][k] * p[0] + w->frame[1][k] * p[1] + w->frame[2][k] * p[2];
}

static double ground_at(const scree_rubble_desc* desc, double x, double z) {
  if (desc->heights == NULL) return desc->ground;
  const double u = x / desc->spacing + 0.5 * (desc->width - 1), v = z / desc->spacing + 0.5 * (desc->depth - 1);
  if (!(u >= 0 && v >= 0 && u <= desc->width - 1 && v <= desc->depth - 1)) return desc->ground;
  uint32_t i = (uint32_t)u, k = (uint32_t)v;
  if (i > desc->width - 2) i = desc->width - 2;
  if (k > desc->depth - 2) k = desc->depth - 2;
  const float* h = desc->heights + i + (size_t)desc->width * k;
  const double s = u - i, t = v - k;
  const double height = (1 - t) * ((1 - s) * h[0] + s * h[1]) + t * ((1 - s) * h[desc->width] + s * h[desc->width + 1]);
  return height > desc->ground ? height : desc->ground;
}

static scree_result make_grid(work* w, scree_error* error) {
  const scree_shards_view* v = w->input->view;
  for (int k = 0; k < 3; ++k) {
    w->low[k] = INFINITY;
    w->high[k] = -INFINITY;
  }
  w->places = scree_rt_allocate(&w->allocator, v->vertex_count, 3 * sizeof *w->places);
  if (w->places == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  for (uint32_t i = 0; i < v->vertex_count; ++i) {
    double* p = w->places + 3 * (size_t)i;
    to_frame(w, v->vertices + 3 * (size_t)i, p);
    for (int k = 0; k < 3; ++k) {
      if (p[k] < w->low[k]) w->low[k] = p[k];
      if (p[k] > w->high[k]) w->high[k] = p[k];
    }
  }
  double size = w->desc->resolution, widest = w->high[0] - w->low[0];
  if (w->high[2] - w->low[2] > widest) widest = w->high[2] - w->low[2];
  if (size == 0) size = repeatable_cube_root(v->volume / v->shard_count) / 3;
  w->reach = w->desc->reach > 0 ? w->desc->reach : 0.5 * widest;
  /* Half the solid more, so that a block that ends within reach has all its columns. */
  const double margin = w->reach + 0.5 * widest + size;
  double origin[2], sides[2];
  for (uint32_t wider = 0;; ++wider, size *= 1.25) {
    for (int k = 0; k < 2; ++k) {
      origin[k] = w->low[2 * k] - margin;
      sides[k] = floor((w->high[2 * k] + margin - origin[k]) / size) + 1;
    }
    if (w->desc->resolution > 0 || wider == 6 || sides[0] * sides[1] <= MOST_COLUMNS) break;
  }
  if (!(sides[0] * sides[1] <= MOST_COLUMNS))
    return fault_value(error, "resolution", size, "too small for so wide a ground: more than 2^24 columns");
  const uint32_t count[2] = {(uint32_t)sides[0], (uint32_t)sides[1]};
  return dexels_create(&w->allocator, origin, size, count, &w->solid);
}

/* --- what stands -----------------------------------------------------------------------------------------------------------------
 */

/* Where an upright line goes through the surface of what stands. */
typedef struct crossing {
  double height;
  int32_t sign; /* 1: into the rock, on the way up */
} crossing;

typedef struct crossings {
  crossing* list;   /* NULL: they are only counted */
  uint32_t* starts; /* of each column, and the end: first its number of crossings */
  double part[2];   /* where in each column its line is: 0.5, 0.5 in the middle */
} crossings;

/* Whether the line at (x, z) has the edge from a to b on its way to x = infinity: 1 or -1 by the direction of the edge. The same
 * answer whichever way round the edge is asked about, so that polygons that share it neither both have the line nor both miss it.
 */
static int edge_beyond(const double a[3], const double b[3], double x, double z) {
  if ((a[2] <= z) == (b[2] <= z)) return 0;
  const double *p = a[2] < b[2] ? a : b, *q = a[2] < b[2] ? b : a;
  if ((q[0] - p[0]) * (z - p[2]) - (x - p[0]) * (q[2] - p[2]) <= 0) return 0;
  return a[2] <= z ? 1 : -1;
}

static void cross_polygon(const work* w, const scree_polygon* polygon, const double outward[3], crossings* out) {
  const scree_shards_view* v = w->input->view;
  const uint32_t* corners = v->corners + polygon->first_corner;
  if (!(outward[1] > 1e-9 || outward[1] < -1e-9)) return;
  double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY}, anchor[3] = {0, 0, 0};
  for (uint32_t c = 0; c < polygon->corner_count; ++c) {
    const double* p = w->places + 3 * (size_t)corners[c];
    for (int k = 0; k < 2; ++k) {
      if (p[2 * k] < low[k]) low[k] = p[2 * k];
      if (p[2 * k] > high[k]) high[k] = p[2 * k];
    }
    for (int k = 0; k < 3; ++k) anchor[k] += p[k] / polygon->corner_count;
  }
  uint32_t from[2], to[2];
  for (int k = 0; k < 2; ++k) {
    from[k] = (uint32_t)floor((low[k] - w->solid.origin[k]) / w->solid.size);
    to[k] = (uint32_t)floor((high[k] - w->solid.origin[k]) / w->solid.size);
  }
  for (uint32_t k = from[1]; k <= to[1]; ++k)
    for (uint32_t i = from[0]; i <= to[0]; ++i) {
      const double x = w->solid.origin[0] + (i + out->part[0]) * w->solid.size;
      const double z = w->solid.origin[1] + (k + out->part[1]) * w->solid.size;
      int turns = 0;
      const double* last = w->places + 3 * (size_t)corners[polygon->corner_count - 1];
      for (uint32_t c = 0; c < polygon->corner_count; ++c) {
        const double* next = w->places + 3 * (size_t)corners[c];
        turns += edge_beyond(last, next, x, z);
        last = next;
      }
      if (turns == 0) continue;
      const uint32_t column = i + w->solid.count[0] * k;
      if (out->list == NULL) {
        ++out->starts[column];
        continue;
      }
      double height = anchor[1] - (outward[0] * (x - anchor[0]) + outward[2] * (z - anchor[2])) / outward[1];
      out->list[--out->starts[column]] = (crossing){height, outward[1] < 0 ? 1 : -1};
    }
}

static void cross_surface(const work* w, crossings* out) {
  const scree_shards_view* v = w->input->view;
  const uint8_t* states = w->input->states;
  for (uint32_t l = 0; l < v->link_count; ++l) {
    const scree_link* link = &v->links[l];
    const bool first = states[link->shards[0]] != SCREE_SHARD_AIR;
    const bool second = link->shards[1] != SCREE_NO_SHARD && states[link->shards[1]] != SCREE_SHARD_AIR;
    if (first == second) continue;
    for (uint32_t p = link->first_polygon; p < link->first_polygon + link->polygon_count; ++p) {
      const scree_polygon* polygon = &v->polygons[p];
      /* Each polygon's own normal: an exterior link is not flat. */
      double area[3] = {0, 0, 0}, outward[3];
      const double* a = v->vertices + 3 * (size_t)v->corners[polygon->first_corner];
      for (uint32_t c = 1; c + 1 < polygon->corner_count; ++c) {
        const double* b = v->vertices + 3 * (size_t)v->corners[polygon->first_corner + c];
        const double* d = v->vertices + 3 * (size_t)v->corners[polygon->first_corner + c + 1];
        for (int axis = 0; axis < 3; ++axis) {
          const int u = (axis + 1) % 3, n = (axis + 2) % 3;
          area[axis] += (b[u] - a[u]) * (d[n] - a[n]) - (b[n] - a[n]) * (d[u] - a[u]);
        }
      }
      const double length = sqrt(area[0] * area[0] + area[1] * area[1] + area[2] * area[2]);
      if (!(length > 0)) continue;
      for (int axis = 0; axis < 3; ++axis) area[axis] *= (first ? 1 : -1) / length;
      to_frame(w, area, outward);
      cross_polygon(w, polygon, outward, out);
    }
  }
}

/* Columns of what stands, from crossings in order: inside between an entry and the exit that evens it out. */
static scree_result fill_columns(const work* w, const crossings* c, dexels* out) {
  const uint32_t columns = w->solid.count[0] * w->solid.count[1];
  for (uint32_t column = 0; column < columns; ++column) {
    crossing* list = c->list + c->starts[column];
    const uint32_t count = c->starts[column + 1] - c->starts[column];
    for (uint32_t i = 1; i < count; ++i) {
      const crossing moved = list[i];
      uint32_t k = i;
      for (; k > 0 && list[k - 1].height > moved.height; --k) list[k] = list[k - 1];
      list[k] = moved;
    }
    int32_t depth = 0;
    double entry = 0;
    for (uint32_t i = 0; i < count; ++i) {
      if (depth == 0) entry = list[i].height;
      depth += list[i].sign;
      if (depth == 0 && list[i].height > entry && !dexels_add(out, column, entry, list[i].height)) return SCREE_ERROR_OUT_OF_MEMORY;
    }
    const double x = w->solid.origin[0] + (column % w->solid.count[0] + 0.5) * w->solid.size;
    const double z = w->solid.origin[1] + (column / w->solid.count[0] + 0.5) * w->solid.size;
    if (!dexels_add(out, column, DEEP, ground_at(w->desc, x, z))) return SCREE_ERROR_OUT_OF_MEMORY;
  }
  return SCREE_OK;
}

static scree_result fill(const work* w, double x, double z, dexels* out) {
  const uint32_t columns = w->solid.count[0] * w->solid.count[1];
  crossings c = {.starts = scree_rt_allocate_zeroed(&w->allocator, (size_t)columns + 1, sizeof *c.starts), .part = {x, z}};
  if (c.starts == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  cross_surface(w, &c);
  uint32_t total = 0;
  for (uint32_t i = 0; i <= columns; ++i) {
    total += c.starts[i]; /* ends, which go down to starts as they are filled */
    c.starts[i] = total;
  }
  scree_result result = SCREE_ERROR_OUT_OF_MEMORY;
  c.list = scree_rt_allocate(&w->allocator, (size_t)total + 1, sizeof *c.list);
  if (c.list != NULL) {
    cross_surface(w, &c);
    result = fill_columns(w, &c, out);
  }
  scree_rt_release(&w->allocator, c.list, (size_t)total + 1, sizeof *c.list);
  scree_rt_release(&w->allocator, c.starts, (size_t)columns + 1, sizeof *c.starts);
  return result;
}

/* What stands along five lines of each column, so that walls as thin as a column have no holes. */
static scree_result fill_rock(work* w) {
  scree_result result = dexels_copy(&w->solid, &w->rock);
  for (int line = 0; line < 4 && result == SCREE_OK; ++line)
    result = fill(w, line % 2 ? 0.75 : 0.25, line / 2 ? 0.75 : 0.25, &w->rock);
  return result;
}

/* --- blocks ----------------------------------------------------------------------------------------------------------------------
 */

static bool kept(const work* w, uint32_t block) {
  if (w->input->blocks[block].volume < w->desc->min_volume) return false;
  random_stream stream = {hash_combine(w->desc->random_seed, block)};
  return random_unit(&stream) < w->desc->share;
}

/* The corners of a block's shards, relative to its centroid, in the frame; only counted where out is NULL. */
static uint32_t block_points(const work* w, const scree_block* block, double* out) {
  const scree_shards_view* v = w->input->view;
  uint32_t count = 0;
  for (uint32_t s = 0; s < block->shard_count; ++s) {
    const scree_shard* shard = &v->shards[w->input->block_shards[block->first_shard + s]];
    for (uint32_t k = 0; k < shard->link_count; ++k) {
      const scree_link* link = &v->links[v->shard_links[shard->first_link + k]];
      for (uint32_t p = link->first_polygon; p < link->first_polygon + link->polygon_count; ++p) {
        const scree_polygon* polygon = &v->polygons[p];
        for (uint32_t c = 0; c < polygon->corner_count && out != NULL; ++c) {
          const double* at = v->vertices + 3 * (size_t)v->corners[polygon->first_corner + c];
          const double relative[3] = {at[0] - block->centroid[0], at[1] - block->centroid[1], at[2] - block->centroid[2]};
          to_frame(w, relative, out + 3 * (size_t)(count + c));
        }
        count += polygon->corner_count;
      }
    }
  }
  return count;
}

/* Room for the largest block. */
static scree_result make_scratch(work* w, scree_rubble* rubble, scree_error* error) {
  uint32_t blocks = 0;
  double widest = 0;
  for (uint32_t i = 0; i < w->input->block_count; ++i) {
    if (!kept(w, i)) continue;
    const uint32_t points = block_points(w, &w->input->blocks[i], NULL);
    if (points > w->point_capacity) w->point_capacity = points;
    w->mean_volume += w->input->blocks[i].volume;
    ++blocks;
  }
  if (blocks == 0) return SCREE_OK;
  if (fill_rock(w) != SCREE_OK) return SCREE_ERROR_OUT_OF_MEMORY;
  w->flood = scree_rt_allocate(&w->allocator, 1, sizeof *w->flood);
  w->mean_volume /= blocks;
  w->points = scree_rt_allocate(&w->allocator, w->point_capacity, 3 * sizeof *w->points);
  rubble->blocks = scree_rt_allocate(&w->allocator, blocks, sizeof *rubble->blocks);
  rubble->capacity = blocks;
  if (w->flood == NULL || w->points == NULL || rubble->blocks == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  for (uint32_t i = 0; i < w->input->block_count; ++i) {
    if (!kept(w, i)) continue;
    const uint32_t points = block_points(w, &w->input->blocks[i], w->points);
    for (uint32_t p = 0; p < points; ++p) {
      const double* at = w->points + 3 * (size_t)p;
      const double square = at[0] * at[0] + at[1] * at[1] + at[2] * at[2];
      if (square > widest) widest = square;
    }
  }
  const double side = floor(2 * sqrt(widest) / w->solid.size) + 4;
  if (!(side * side <= MOST_COLUMNS)) return fault_value(error, "resolution", w->solid.size, "too small for so large a block");
  const uint32_t cells = (uint32_t)(side * side);
  for (int r = 0; r < 2; ++r) {
    w->rasters[r].cells = scree_rt_allocate(&w->allocator, cells, sizeof(rubble_cell));
    if (w->rasters[r].cells == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
    w->rasters[r].capacity = cells;
  }
  return SCREE_OK;
}

/* Makes a block that rests part of what is solid. */
static bool stamp(work* w, const rubble_mover* m, const rubble_pose* pose) {
  const rubble_raster* raster = &m->rasters[0];
  uint32_t middles = 0;
  for (uint32_t c = 0; c < raster->count; ++c) middles += raster->cells[c].mid_low < raster->cells[c].mid_high;
  const bool corners = middles < FEW_COLUMNS; /* so small that its middles say little: by its corners, too */
  for (uint32_t c = 0; c < raster->count; ++c) {
    const rubble_cell* cell = &raster->cells[c];
    const double low = corners ? cell->low : cell->mid_low, high = corners ? cell->high : cell->mid_high;
    if (!(low < high)) continue;
    const uint32_t column =
        (uint32_t)(pose->column[0] + cell->column[0]) + w->solid.count[0] * (uint32_t)(pose->column[1] + cell->column[1]);
    if (!dexels_add(&w->solid, column, pose->height + low, pose->height + high)) return false;
  }
  return true;
}

/* One block. It is in `rubble` then, unless it rolled beyond reach. */
static scree_result settle_block(work* w, uint32_t index, scree_rubble* rubble) {
  const scree_block* block = &w->input->blocks[index];
  rubble_hull hull;
  if (!rubble_hull_make(w->points, block_points(w, block, w->points), &hull)) return SCREE_OK; /* flat: nothing to see */
  if (hull.thickness < THINNEST * w->solid.size) return SCREE_OK; /* dust: columns do not tell where it lies */
  double push[3], at[3];
  to_frame(w, block->push, push);
  to_frame(w, block->centroid, at);
  /* Large blocks roll on where small ones stay. Less than the repose that is asked for, because stones also hold each other. */
  const double large = block->volume / (block->volume + w->mean_volume);
  rubble_mover mover = {.solid = &w->solid,
                        .rock = &w->rock,
                        .hull = &hull,
                        .flood = w->flood,
                        .limit = at[1] + 0.02 * hull.size,
                        .slope = w->repose * (1 - 0.3 * large),
                        .give = 0.5 * w->solid.size,
                        .rasters = {w->rasters[0], w->rasters[1]},
                        .stream = {hash_combine(hash_combine(w->desc->random_seed, index), 1)}};
  if (mover.give > 0.15 * hull.thickness) mover.give = 0.15 * hull.thickness;
  rubble_pose pose = {.height = at[1], .turn = {0, 0, 0, 1}};
  for (int k = 0; k < 2; ++k) {
    const double place = (at[2 * k] - w->solid.origin[k]) / w->solid.size;
    pose.column[k] = (int32_t)floor(place);
    pose.part[k] = place - pose.column[k];
  }
  if (!rubble_move(&mover, &pose, push)) return SCREE_OK;
  double place[3] = {0, pose.height, 0};
  for (int k = 0; k < 2; ++k) {
    place[2 * k] = w->solid.origin[k] + (pose.column[k] + pose.part[k]) * w->solid.size;
    if (place[2 * k] < w->low[2 * k] - w->reach || place[2 * k] > w->high[2 * k] + w->reach) return SCREE_OK;
  }
  if (!stamp(w, &mover, &pose)) return SCREE_ERROR_OUT_OF_MEMORY;
  scree_resting_block* out = &rubble->blocks[rubble->count++];
  memset(out, 0, sizeof *out);
  out->block = index;
  to_world(w, place, out->translation);
  to_world(w, pose.turn, out->rotation);
  out->rotation[3] = pose.turn[3];
  return SCREE_OK;
}

static bool tell(const work* w, double done) {
  return w->desc->progress == NULL || w->desc->progress(w->desc->progress_user, done);
}

static scree_result settle_all(work* w, scree_rubble* rubble, scree_error* error) {
  if (!tell(w, 0)) return SCREE_ERROR_CANCELLED;
  scree_result result = make_grid(w, error);
  if (result == SCREE_OK) result = fill(w, 0.5, 0.5, &w->solid);
  if (result == SCREE_OK) result = make_scratch(w, rubble, error);
  for (uint32_t i = 0; i < w->input->block_count && result == SCREE_OK; ++i) {
    if (kept(w, i)) result = settle_block(w, i, rubble);
    if (result == SCREE_OK && i % 64 == 63 && !tell(w, (double)i / w->input->block_count)) result = SCREE_ERROR_CANCELLED;
  }
  if (result == SCREE_OK && !tell(w, 1)) result = SCREE_ERROR_CANCELLED;
  return result;
}

scree_result rubble_settle(const rubble_input* input, const scree_rubble_desc* desc, scree_rubble** out, scree_error* error) {
  *out = NULL;
  scree_result result = check(desc, error);
  if (result != SCREE_OK) return result;
  work w = {.input = input,
            .desc = desc,
            .allocator = scree_rt_allocator_or_default(&desc->allocator),
            .repose = desc->repose > 0 ? desc->repose : 0.7};
  make_frame(&w);
  scree_rubble* rubble = scree_rt_allocate_zeroed(&w.allocator, 1, sizeof *rubble);
  if (rubble == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  rubble->allocator = w.allocator;
  result = settle_all(&w, rubble, error);
  dexels_free(&w.solid);
  dexels_free(&w.rock);
  scree_rt_release(&w.allocator, w.flood, 1, sizeof *w.flood);
  scree_rt_release(&w.allocator, w.places, input->view->vertex_count, 3 * sizeof *w.places);
  scree_rt_release(&w.allocator, w.points, w.point_capacity, 3 * sizeof *w.points);
  for (int r = 0; r < 2; ++r) scree_rt_release(&w.allocator, w.rasters[r].cells, w.rasters[r].capacity, sizeof(rubble_cell));
  if (result != SCREE_OK) {
    scree_rubble_destroy(rubble);
    return result;
  }
  *out = rubble;
  return SCREE_OK;
}

scree_result scree_rubble_create(const scree_rubble_desc* desc, scree_rubble** out, scree_error* error) {
  const scree_frost* f = desc->frost;
  const rubble_input input = {.view = &f->view,
                              .states = f->states,
                              .blocks = f->blocks,
                              .block_shards = f->block_shards,
                              .block_count = f->stats.blocks,
                              .gravity = {f->tables.gravity[0], f->tables.gravity[1], f->tables.gravity[2]}};
  return rubble_settle(&input, desc, out, error);
}

void scree_rubble_destroy(scree_rubble* rubble) {
  if (rubble == NULL) return;
  const scree_allocator allocator = rubble->allocator;
  scree_rt_release(&allocator, rubble->blocks, rubble->capacity, sizeof *rubble->blocks);
  scree_rt_release(&allocator, rubble, 1, sizeof *rubble);
}

uint32_t scree_rubble_get(const scree_rubble* rubble, const scree_resting_block** blocks) {
  *blocks = rubble->blocks;
  return rubble->count;
}
