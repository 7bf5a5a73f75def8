#include <math.h>
#include <string.h>

#include "shard_clip.h"

/* Based on: Eberly 2002, "Triangulation by Ear Clipping", section 5: holes from the rightmost one on, each joined with what its
 * rightmost corner sees to the right. */

static double side_of(const double a[2], const double b[2], const double p[2]) {
  return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

static bool contains(const clip_loops* l, const clip_loop* loop, const double at[2]) {
  const double(*p)[2] = (const double(*)[2])l->places + loop->first;
  bool in = false;
  for (uint32_t k = 0, before = loop->count - 1; k < loop->count; before = k++)
    if ((p[k][1] > at[1]) != (p[before][1] > at[1]) &&
        at[0] < p[k][0] + (p[before][0] - p[k][0]) * ((at[1] - p[k][1]) / (p[before][1] - p[k][1])))
      in = !in;
  return in;
}

/* Whether the inside of a loop, seen from its corner k, has `at` in front. */
static bool opens_to(const double (*p)[2], uint32_t count, uint32_t k, const double at[2]) {
  const double *before = p[k > 0 ? k - 1 : count - 1], *after = p[k + 1 < count ? k + 1 : 0];
  const bool left = side_of(p[k], after, at) >= 0, also = side_of(before, p[k], at) >= 0;
  return side_of(before, p[k], after) > 0 ? left && also : left || also;
}

static bool in_triangle(const double a[2], const double b[2], const double c[2], const double at[2]) {
  const double x = side_of(a, b, at), y = side_of(b, c, at), z = side_of(c, a, at);
  return (x >= 0 && y >= 0 && z >= 0) || (x <= 0 && y <= 0 && z <= 0);
}

static uint32_t rightmost(const clip_loops* l, const clip_loop* loop) {
  uint32_t best = 0;
  for (uint32_t k = 1; k < loop->count; ++k)
    if (l->places[loop->first + k][0] > l->places[loop->first + best][0]) best = k;
  return best;
}

/* The corner of an outer loop that a hole's rightmost corner sees. */
static uint32_t find_bridge(const double (*p)[2], uint32_t count, const double from[2]) {
  double near = INFINITY;
  uint32_t best = CLIP_NONE;
  for (uint32_t k = 0; k < count; ++k) {
    const double *a = p[k], *b = p[k + 1 < count ? k + 1 : 0];
    if (!(a[1] <= from[1] && from[1] < b[1])) continue; /* its inside is to the left */
    const double x = a[0] + (b[0] - a[0]) * ((from[1] - a[1]) / (b[1] - a[1]));
    if (x < from[0] || x >= near) continue;
    near = x;
    best = a[0] > b[0] ? k : k + 1 < count ? k + 1 : 0;
  }
  if (best == CLIP_NONE) return best;
  const double hit[2] = {near, from[1]}, end[2] = {p[best][0], p[best][1]};
  double flattest = INFINITY;
  for (uint32_t k = 0; k < count; ++k) {
    if (p[k][0] < from[0] || !in_triangle(from, hit, end, p[k]) || !opens_to(p, count, k, from)) continue;
    const double slope = p[k][0] > from[0] ? fabs(p[k][1] - from[1]) / (p[k][0] - from[0]) : 1e300;
    if (slope < flattest || (slope == flattest && p[k][0] < p[best][0])) {
      flattest = slope;
      best = k;
    }
  }
  return best;
}

static scree_result reserve(clip_loops* l, size_t count, const scree_allocator* allocator) {
  const size_t needed = (size_t)l->corner_count + count;
  scree_result result = clip_reserve(allocator, &l->corners, &l->corner_capacity, l->corner_count, needed);
  if (result == SCREE_OK) result = clip_reserve(allocator, &l->places, &l->place_capacity, l->corner_count, needed);
  return result;
}

static void append(clip_loops* l, uint32_t from) {
  l->corners[l->corner_count] = l->corners[from];
  memcpy(l->places[l->corner_count], l->places[from], sizeof *l->places);
  ++l->corner_count;
}

/* Writes an outer loop anew, with a hole. */
static scree_result join(clip_loops* l, clip_loop* outer, const clip_loop* hole, const scree_allocator* allocator) {
  const scree_result result = reserve(l, (size_t)outer->count + hole->count + 2, allocator);
  if (result != SCREE_OK) return result;
  const uint32_t start = rightmost(l, hole), first = l->corner_count;
  const uint32_t to = find_bridge((const double(*)[2])l->places + outer->first, outer->count, l->places[hole->first + start]);
  if (to == CLIP_NONE) return SCREE_ERROR_UNSUPPORTED;
  for (uint32_t k = 0; k <= to; ++k) append(l, outer->first + k);
  for (uint32_t k = 0; k <= hole->count; ++k) append(l, hole->first + (start + k) % hole->count);
  for (uint32_t k = to; k < outer->count; ++k) append(l, outer->first + k);
  outer->first = first;
  outer->count = l->corner_count - first;
  return SCREE_OK;
}

scree_result clip_loops_join(clip_loops* l, const scree_allocator* allocator) {
  uint32_t holes = 0;
  for (uint32_t h = 0; h < l->loop_count; ++h) {
    clip_loop* hole = &l->loops[h];
    if (hole->outer) continue;
    hole->owner = CLIP_NONE;
    for (uint32_t k = 0; k < l->loop_count; ++k) {
      const clip_loop* loop = &l->loops[k];
      if (!loop->outer || !contains(l, loop, l->places[hole->first])) continue;
      if (hole->owner == CLIP_NONE || loop->area < l->loops[hole->owner].area) hole->owner = k;
    }
    if (hole->owner == CLIP_NONE) return SCREE_ERROR_UNSUPPORTED;
    ++holes;
  }
  for (; holes > 0; --holes) {
    clip_loop* next = NULL;
    double right = 0;
    for (uint32_t h = 0; h < l->loop_count; ++h) {
      clip_loop* hole = &l->loops[h];
      if (hole->outer || hole->count == 0) continue;
      const double x = l->places[hole->first + rightmost(l, hole)][0];
      if (next != NULL && x <= right) continue;
      next = hole;
      right = x;
    }
    if (next == NULL) return SCREE_ERROR_UNSUPPORTED; /* not so: each round takes one */
    const scree_result result = join(l, &l->loops[next->owner], next, allocator);
    if (result != SCREE_OK) return result;
    next->count = 0;
  }
  return SCREE_OK;
}

void clip_loops_free(clip_loops* l, const scree_allocator* allocator) {
  scree_rt_release(allocator, l->corners, l->corner_capacity, sizeof *l->corners);
  scree_rt_release(allocator, l->places, l->place_capacity, sizeof *l->places);
  scree_rt_release(allocator, l->loops, l->loop_capacity, sizeof *l->loops);
  *l = (clip_loops){0};
}
