/* Which blocks have to be looked at because a view has moved. Each shown block has a range of distances in which its levels stay as
 * they are. An update holds all of them against the views, four at a time where the compiler can: that costs less than to find, in
 * memory, the few that might be due. Numbers are floats relative to an anchor near the views; ranges are narrowed by what rounding
 * may do, so that no block is missed. */
#include <math.h>
#include <string.h>

#include "stream_internal.h"

enum { GROUP = 64, LOW = 0, HIGH = 3, NEAR = 6, FAR = 7, HOME = 8, WIDTH = 11 };

static const double ROUNDING = 2e-6;
static const float ANYWHERE = 1e18f; /* half the width of a box that is never left */

static float* column(const scree_stream* s, uint32_t which) {
  return s->watches + (size_t)which * scree_rt_stream_watch_rows(&s->desc.caps);
}

uint32_t scree_rt_stream_watch_rows(const scree_stream_caps* caps) {
  return (caps->blocks + GROUP - 1) / GROUP * GROUP;
}

void scree_rt_stream_unwatch(scree_stream* s, uint32_t block) {
  column(s, NEAR)[block] = -1;
  column(s, FAR)[block] = INFINITY;
  for (uint32_t a = 0; a < 3; ++a) column(s, HOME + a)[block] = -ANYWHERE;
  column(s, WIDTH)[block] = 2 * ANYWHERE;
}

void scree_rt_stream_watch_init(scree_stream* s) {
  for (uint32_t i = 0; i < scree_rt_stream_watch_rows(&s->desc.caps); ++i) {
    for (uint32_t k = LOW; k < NEAR; ++k) column(s, k)[i] = 0;
    scree_rt_stream_unwatch(s, i);
  }
}

/* How far from the anchor, along an axis, a block may reach: what rounding does to its numbers is a share of that. */
static double extent(const scree_stream* s, const stream_block* b) {
  double size = 0;
  for (uint32_t a = 0; a < 3; ++a)
    size = fmax(size, fabs(b->origin[a] - s->anchor[a]) + fmax(fabs((double)b->min[a]), fabs((double)b->max[a])));
  return size;
}

/* Sets the boxes of a block. */
static void place(scree_stream* s, uint32_t block) {
  const stream_block* b = &s->blocks[block];
  double slack = extent(s, b) * ROUNDING, width = stream_node_width(&s->layers[b->layer], 0);
  for (uint32_t a = 0; a < 3; ++a) {
    column(s, LOW + a)[block] = (float)(b->origin[a] + (double)b->min[a] - s->anchor[a]);
    column(s, HIGH + a)[block] = (float)(b->origin[a] + (double)b->max[a] - s->anchor[a]);
    if (b->level == 0) column(s, HOME + a)[block] = (float)(b->origin[a] - s->anchor[a] + slack);
  }
  if (b->level == 0) column(s, WIDTH)[block] = (float)(width - 2 * slack);
}

/* Sets the distances between which the levels of a block stay. */
static void set_band(scree_stream* s, uint32_t block, double near, double far) {
  double slack = (extent(s, &s->blocks[block]) + (isfinite(far) ? far : near)) * ROUNDING;
  column(s, NEAR)[block] = near >= 0 ? (float)((near + slack) * (near + slack)) : -1;
  column(s, FAR)[block] = isfinite(far) ? (float)(fmax(far - slack, 0) * (far - slack)) : INFINITY;
}

void scree_rt_stream_watch(scree_stream* s, uint32_t block, double near, double far) {
  place(s, block);
  set_band(s, block, near, far);
}

static void look_at(scree_stream* s, uint32_t block) {
  double near, far;
  scree_rt_stream_levels_aim(s, block, &near, &far);
  set_band(s, block, near, far);
}

static inline float away2(float low, float high, float p) {
  float before = low - p, behind = p - high;
  float away = before > behind ? before : behind;
  away = away > 0 ? away : 0;
  return away * away;
}

/* Squares of distances: scaled ones of what blocks draw, plain ones of their home cells. */
static void measure_group(const scree_stream* s, uint32_t first, float drawn[GROUP], float home[GROUP]) {
  const float *x0 = column(s, LOW) + first, *y0 = column(s, LOW + 1) + first, *z0 = column(s, LOW + 2) + first;
  const float *x1 = column(s, HIGH) + first, *y1 = column(s, HIGH + 1) + first, *z1 = column(s, HIGH + 2) + first;
  const float *x2 = column(s, HOME) + first, *y2 = column(s, HOME + 1) + first, *z2 = column(s, HOME + 2) + first;
  const float* width = column(s, WIDTH) + first;
  for (uint32_t i = 0; i < GROUP; ++i) drawn[i] = home[i] = INFINITY;
  for (uint32_t v = 0; v < s->view_count; ++v) {
    const stream_view* view = &s->views[v];
    float x = (float)(view->position[0] - s->anchor[0]), y = (float)(view->position[1] - s->anchor[1]),
          z = (float)(view->position[2] - s->anchor[2]), scale = (float)(view->ratio * view->ratio), sum[GROUP];
    for (uint32_t i = 0; i < GROUP; ++i)
      sum[i] = (away2(x0[i], x1[i], x) + away2(y0[i], y1[i], y) + away2(z0[i], z1[i], z)) * scale;
    for (uint32_t i = 0; i < GROUP; ++i) drawn[i] = sum[i] < drawn[i] ? sum[i] : drawn[i];
    for (uint32_t i = 0; i < GROUP; ++i)
      sum[i] = away2(x2[i], x2[i] + width[i], x) + away2(y2[i], y2[i] + width[i], y) + away2(z2[i], z2[i] + width[i], z);
    for (uint32_t i = 0; i < GROUP; ++i) home[i] = sum[i] < home[i] ? sum[i] : home[i];
  }
}

static void look_through_group(scree_stream* s, uint32_t first, bool anew) {
  float drawn[GROUP], home[GROUP], limit = (float)(s->view_limit * (1 - ROUNDING));
  uint32_t due[GROUP], left[GROUP], count = 0, left_count = 0;
  measure_group(s, first, drawn, home);
  const float *near = column(s, NEAR) + first, *far = column(s, FAR) + first;
  limit *= limit;
  for (uint32_t i = 0; i < GROUP; ++i) {
    due[count] = left[left_count] = first + i;
    count += !anew && !(drawn[i] > near[i] && drawn[i] < far[i]);
    left_count += home[i] > limit;
  }
  for (uint32_t i = 0; i < count; ++i) stream_prefetch(&s->blocks[due[i]], offsetof(stream_block, triangles));
  for (uint32_t i = 0; i < count; ++i) look_at(s, due[i]);
  for (uint32_t i = 0; i < left_count; ++i) scree_rt_stream_node_due(s, s->blocks[left[i]].node);
}

void scree_rt_stream_watch_update(scree_stream* s, bool anew) {
  if (s->view_count == 0 || (!anew && s->travel == s->watched_travel)) return;
  s->watched_travel = s->travel;
  for (int a = 0; a < 3; ++a) anew = anew || fabs(s->views[0].position[a] - s->anchor[a]) > 4 * s->desc.view_distance;
  if (anew) memcpy(s->anchor, s->views[0].position, sizeof s->anchor);
  for (uint32_t i = 0; i < s->blocks_used && anew; ++i)
    if (s->blocks[i].shown && !s->blocks[i].leaving) {
      place(s, i);
      look_at(s, i);
    }
  for (uint32_t first = 0; first < s->blocks_used; first += GROUP) look_through_group(s, first, anew);
}
