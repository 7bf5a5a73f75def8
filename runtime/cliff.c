/* Cliffs: scatters whose instances are the placements of a pack. */
#include <math.h>
#include <string.h>

#include <scree/cliff.h>

#include "allocator.h"
#include "scatter_internal.h"
#include "scene_layers.h"
#include "support_text.h"

enum { MOST_BLOCKS = 1 << 24 };

/* --- places ----------------------------------------------------------------------------------------------------------------- */

/* The first point whose tile is not before (x, z). */
static uint32_t first_of(const scree_scatter* s, int64_t x, int64_t z) {
  uint32_t low = 0, high = s->cliff_count;
  while (low < high) {
    const uint32_t middle = low + (high - low) / 2;
    const cliff_point* p = &s->points[middle];
    if (p->tile[1] < z || (p->tile[1] == z && p->tile[0] < x))
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

const cliff_point* scree_rt_cliff_point(const scree_scatter* s, int32_t x, int32_t z, uint32_t local) {
  const uint32_t first = first_of(s, x, z);
  if (local >= s->cliff_count - first) return NULL;
  const cliff_point* p = &s->points[first + local];
  return p->tile[0] == x && p->tile[1] == z ? p : NULL;
}

bool scree_rt_cliff_visit(const scatter_visit* v, bool (*found)(void* user, const scatter_found* instance), void* user) {
  const scree_scatter* s = v->scatter;
  uint32_t first = first_of(s, v->low[0], v->low[2]); /* of a tile */
  while (first < s->cliff_count && s->points[first].tile[1] < v->high[2]) {
    const int32_t x = s->points[first].tile[0], z = s->points[first].tile[1];
    if (x < v->low[0] || x >= v->high[0]) {
      first = first_of(s, v->low[0], x < v->low[0] ? (int64_t)z : (int64_t)z + 1);
      continue;
    }
    uint32_t end = first;
    for (; end < s->cliff_count && s->points[end].tile[0] == x && s->points[end].tile[1] == z; ++end) {
      const cliff_point* p = &s->points[end];
      const int64_t y = p->steps[1] >> SCATTER_SIDE_BITS;
      if (y < v->low[1] || y >= v->high[1]) continue;
      const double east = s->unit * (double)p->steps[0], south = s->unit * (double)p->steps[2];
      if (!(east >= v->box_low[0] && east <= v->box_high[0] && south >= v->box_low[1] && south <= v->box_high[1])) continue;
      const scatter_found instance = {
          .tile = {x, z}, .local = end - first, .model = p->asset, .steps = {p->steps[0], p->steps[1], p->steps[2]}};
      if (scree_rt_scatter_passes(v, &instance, false) && !found(user, &instance)) return false;
    }
    first = end;
  }
  return true;
}

/* --- create ----------------------------------------------------------------------------------------------------------------- */

/* By tile z, tile x and number in the pack: a heap, so that nothing is allocated. */
static bool before(const cliff_point* a, const cliff_point* b) {
  if (a->tile[1] != b->tile[1]) return a->tile[1] < b->tile[1];
  if (a->tile[0] != b->tile[0]) return a->tile[0] < b->tile[0];
  return a->number < b->number;
}

static void sift(cliff_point* points, uint32_t at, uint32_t count) {
  const cliff_point moved = points[at];
  for (uint32_t child; (child = 2 * at + 1) < count; at = child) {
    if (child + 1 < count && before(&points[child], &points[child + 1])) ++child;
    if (!before(&moved, &points[child])) break;
    points[at] = points[child];
  }
  points[at] = moved;
}

static void sort(cliff_point* points, uint32_t count) {
  for (uint32_t i = count / 2; i-- > 0;) sift(points, i, count);
  for (uint32_t end = count; end-- > 1;) {
    const cliff_point last = points[end];
    points[end] = points[0];
    points[0] = last;
    sift(points, 0, end);
  }
}

static scree_result check(const scree_cliff_desc* d, scree_error* error) {
  if (d->pack == NULL) return scree_rt_scatter_wrong(SCREE_ERROR_INVALID_ARGUMENT, "pack is NULL", error);
  scree_pack_info info;
  scree_pack_get_info(d->pack, &info);
  if (info.kind != SCREE_PACK_CLIFF) return scree_rt_scatter_wrong(SCREE_ERROR_PACK_KIND, "pack: expected one of a cliff", error);
  if (d->time >= info.time_count) return scree_rt_scatter_wrong_number("time", d->time, "less than the pack's times", error);
  if ((d->what & ~(uint32_t)(SCREE_CLIFF_STANDING | SCREE_CLIFF_BLOCKS)) != 0)
    return scree_rt_scatter_wrong_number("what", d->what, "0..3", error);
  for (int a = 0; a < 3; ++a)
    if (!isfinite(d->origin[a])) return scree_rt_scatter_wrong_number("origin", d->origin[a], "finite", error);
  if (!isfinite(d->turn)) return scree_rt_scatter_wrong_number("turn", d->turn, "finite", error);
  if (d->scale != 0 && !(d->scale > 0 && d->scale <= 1e9f))
    return scree_rt_scatter_wrong_number("scale", (double)d->scale, "above 0", error);
  return SCREE_OK;
}

/* Fills in assets and numbers of all instances, in the pack's order, what stands first. at: their places relative to the origin,
 * metres, 3 each. */
static scree_result read_places(scree_scatter* s, const scree_pack* pack, const scree_cliff_time* time, uint32_t standing,
                                double* at) {
  float turn[2], scale;
  scree_scatter_turn(s, s->turn_bits, turn, &scale);
  const double size = (double)scale, sine = (double)turn[0], cosine = (double)turn[1];
  if (standing != 0) {
    s->points[0] = (cliff_point){.asset = time->asset};
    at[0] = at[1] = at[2] = 0;
  }
  for (uint32_t i = standing; i < s->cliff_count;) {
    scree_block_placement some[32];
    const uint32_t n = s->cliff_count - i < 32 ? s->cliff_count - i : 32;
    const scree_result result = scree_pack_get_placements(pack, time->first_placement + (i - standing), n, some);
    if (result != SCREE_OK) return result;
    for (uint32_t k = 0; k < n; ++k, ++i) {
      const double x = (double)some[k].translation[0], y = (double)some[k].translation[1], z = (double)some[k].translation[2];
      s->points[i] = (cliff_point){.asset = some[k].asset, .number = i};
      at[3 * i] = size * (cosine * x + sine * z);
      at[3 * i + 1] = size * y;
      at[3 * i + 2] = size * (cosine * z - sine * x);
    }
  }
  for (uint32_t i = 0; i < s->cliff_count; ++i)
    if (s->points[i].asset >= s->model_count) return SCREE_ERROR_CORRUPT;
  return SCREE_OK;
}

/* Whether no tile has more instances than can be numbered. */
static bool tiles_fit(const scree_scatter* s) {
  for (uint32_t i = SCATTER_MOST_LOCALS; i < s->cliff_count; ++i) {
    const cliff_point *a = &s->points[i - SCATTER_MOST_LOCALS], *b = &s->points[i];
    if (a->tile[0] == b->tile[0] && a->tile[1] == b->tile[1]) return false;
  }
  return true;
}

/* Puts instances on the lattice of a unit. */
static void place(scree_scatter* s, const double* at) {
  for (uint32_t i = 0; i < s->cliff_count; ++i) {
    cliff_point* p = &s->points[i];
    const double* from = &at[(size_t)3 * p->number];
    for (int a = 0; a < 3; ++a) p->steps[a] = (int64_t)floor(from[a] / s->unit + 0.5);
    p->tile[0] = (int32_t)(p->steps[0] >> SCATTER_SIDE_BITS);
    p->tile[1] = (int32_t)(p->steps[2] >> SCATTER_SIDE_BITS);
  }
  sort(s->points, s->cliff_count);
}

/* A lattice of cubes of a thirty-second of the width of everything, narrower where too much lies in one: places are rounded to
 * 1/65536 of how far the farthest is. */
static bool place_all(scree_scatter* s, const double* at) {
  double extent = 1e-3;
  for (uint32_t i = 0; i < 3 * s->cliff_count; ++i) extent = fmax(extent, fabs(at[i]));
  for (double side = extent / 16; side > extent * 1e-5; side *= 0.5) {
    s->unit = side / SCATTER_SIDE;
    place(s, at);
    if (tiles_fit(s)) return true;
  }
  return false;
}

static scree_result make_ground(scree_scatter* s, const double* at) {
  double low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    low[a] = high[a] = at[a];
    for (uint32_t i = 1; i < s->cliff_count; ++i) {
      low[a] = fmin(low[a], at[(size_t)3 * i + (size_t)a]);
      high[a] = fmax(high[a], at[(size_t)3 * i + (size_t)a]);
    }
  }
  scree_shape box = {.kind = SCREE_SHAPE_BOX};
  scree_support_desc desc = {.shapes = &box, .shape_count = 1};
  for (int a = 0; a < 3; ++a) {
    desc.origin[a] = s->origin[a] + (low[a] + high[a]) * 0.5;
    box.box.half[a] = (float)((high[a] - low[a]) * 0.5 + s->unit * SCATTER_SIDE * 0.25); /* more than places are rounded by */
  }
  return scree_support_create(&desc, &s->allocator, &s->ground, NULL);
}

static scree_result make(scree_scatter* s, const scree_cliff_desc* desc, scree_error* error) {
  const uint32_t what = desc->what != 0 ? desc->what : SCREE_CLIFF_STANDING | SCREE_CLIFF_BLOCKS;
  const uint32_t standing = (what & SCREE_CLIFF_STANDING) != 0 ? 1 : 0;
  scree_cliff_time time;
  scree_result result = scree_rt_scatter_copy_models(s, &(scree_scatter_desc){.pack = desc->pack}, error);
  if (result == SCREE_OK) result = scree_pack_get_time(desc->pack, desc->time, &time);
  if (result != SCREE_OK) return result;
  const uint32_t blocks = (what & SCREE_CLIFF_BLOCKS) != 0 ? time.placement_count : 0;
  if (blocks > MOST_BLOCKS) return scree_rt_scatter_wrong(SCREE_ERROR_RANGE, "pack: too many blocks", error);
  const uint32_t count = standing + blocks;
  const size_t numbers = count > 0 ? (size_t)3 * count : 3; /* where nothing has fallen, its blocks are a layer of none */
  double* at = scree_rt_allocate_zeroed(&s->allocator, numbers, sizeof *at);
  if (count > 0) s->points = scree_rt_allocate_zeroed(&s->allocator, count, sizeof *s->points);
  s->cliff_count = count;
  const bool is_there = at != NULL && (count == 0 || s->points != NULL);
  result = is_there ? read_places(s, desc->pack, &time, standing, at) : SCREE_ERROR_OUT_OF_MEMORY;
  if (result == SCREE_OK && !place_all(s, at))
    result = scree_rt_scatter_wrong(SCREE_ERROR_RANGE, "pack: too many blocks lie in one place", error);
  if (result == SCREE_OK) {
    scree_rt_scatter_finish(s);
    result = make_ground(s, at);
  }
  scree_rt_release(&s->allocator, at, numbers, sizeof *at);
  return result;
}

scree_result scree_cliff_create(const scree_cliff_desc* desc, const scree_allocator* given, scree_scatter** out,
                                scree_error* error) {
  scree_rt_text_clear(error);
  if (out != NULL) *out = NULL;
  if (desc == NULL || out == NULL)
    return scree_rt_scatter_wrong(SCREE_ERROR_INVALID_ARGUMENT, desc == NULL ? "desc is NULL" : "out is NULL", error);
  scree_result result = check(desc, error);
  if (result != SCREE_OK) return result;
  const scree_allocator allocator = scree_rt_allocator_or_default(given);
  scree_scatter* s = scree_rt_allocate_zeroed(&allocator, 1, sizeof *s);
  if (s == NULL) return scree_rt_scatter_wrong(SCREE_ERROR_OUT_OF_MEMORY, "out of memory", error);
  s->allocator = allocator;
  s->is_cliff = true;
  memcpy(s->origin, desc->origin, sizeof s->origin);
  s->lattice.seed = desc->seed;
  s->scale_min = s->scale_max = desc->scale > 0 ? desc->scale : 1;
  const double turn = desc->turn - floor(desc->turn);
  s->turn_bits = ((uint32_t)floor(turn * 65536 + 0.5) & 0xffff) << 16;
  result = make(s, desc, error);
  if (result != SCREE_OK) {
    scree_scatter_destroy(s);
    if (result == SCREE_ERROR_OUT_OF_MEMORY) scree_rt_text_add(error, "out of memory");
    return result;
  }
  *out = s;
  return SCREE_OK;
}
