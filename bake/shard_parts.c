#include "shard_parts.h"

#include <math.h>
#include <string.h>

#include "allocator.h"
#include "convex_parts.h"

enum {
  GROUPS_MAX = 320, /* that joining starts from; with more shards near ones are put together first */
  BATCH = 512       /* points that are looked at at a time */
};

/* Below 64 parts two are joined only where that adds less air than this share of all. */
#define LEAST_AIR 0.005

typedef struct group {
  int16_t hull[SHARD_PART_MAX_HULL][3];
  uint32_t hull_count;
  double volume; /* of the hull */
  uint32_t into; /* itself, or the group that it was joined to */
} group;

typedef struct pair {
  uint32_t a, b; /* a < b */
  double added;  /* volume, when they become one hull */
} pair;

typedef struct parts_work {
  const scree_shards_view* view;
  const uint8_t* inside;
  const int16_t (*places)[3];
  uint32_t* group_of; /* of each shard, or UINT32_MAX */
  uint32_t* list;     /* shards inside */
  group* groups;
  pair* pairs;
  uint32_t listed, group_count, pair_count;
} parts_work;

/* The corners of a hull of points, at most SHARD_PART_MAX_HULL: the farthest in fixed directions. */
static uint32_t reduce(const int16_t (*points)[3], uint32_t count, int16_t (*hull)[3]) {
  uint32_t kept = 0;
  int16_t out[SHARD_PART_MAX_HULL][3];
  for (int32_t shell = 1; shell <= 6; ++shell)
    for (int32_t code = 0; code < 125 && kept < SHARD_PART_MAX_HULL; ++code) {
      const int32_t x = code % 5 - 2, y = code / 5 % 5 - 2, z = code / 25 - 2;
      if (x * x + y * y + z * z != shell || shell == 4) continue;
      int32_t most = INT32_MIN;
      uint32_t best = 0;
      for (uint32_t i = 0; i < count; ++i) {
        const int32_t along = x * points[i][0] + y * points[i][1] + z * points[i][2];
        if (along > most) most = along, best = i;
      }
      bool known = false;
      for (uint32_t k = 0; k < kept; ++k) known = known || memcmp(out[k], points[best], sizeof *out) == 0;
      if (!known) memcpy(out[kept++], points[best], sizeof *out);
    }
  memcpy(hull, out, kept * sizeof *out);
  return kept;
}

/* Hulls of shards grow a batch of points at a time. */
static void add_shard(const parts_work* w, uint32_t shard, group* to) {
  int16_t points[BATCH + SHARD_PART_MAX_HULL][3];
  uint32_t count = to->hull_count;
  memcpy(points, to->hull, count * sizeof *points);
  const scree_shard* s = &w->view->shards[shard];
  for (uint32_t i = 0; i < s->link_count; ++i) {
    const scree_link* link = &w->view->links[w->view->shard_links[s->first_link + i]];
    for (uint32_t p = link->first_polygon; p < link->first_polygon + link->polygon_count; ++p)
      for (uint32_t c = 0; c < w->view->polygons[p].corner_count; ++c) {
        memcpy(points[count++], w->places[w->view->corners[w->view->polygons[p].first_corner + c]], sizeof *points);
        if (count == BATCH + SHARD_PART_MAX_HULL) count = reduce((const int16_t(*)[3])points, count, points);
      }
  }
  to->hull_count = reduce((const int16_t(*)[3])points, count, to->hull);
}

/* Halves a run of shards by the middle of their centroids along the longest side until there are `most` runs. */
static void split(parts_work* w, uint32_t first, uint32_t count, uint32_t most) {
  if (count <= 1 || most <= 1) {
    for (uint32_t i = first; i < first + count; ++i) w->group_of[w->list[i]] = w->group_count;
    w->group_count += count > 0;
    return;
  }
  uint32_t axis = 0;
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (uint32_t i = first; i < first + count; ++i)
    for (uint32_t a = 0; a < 3; ++a) {
      const double c = w->view->shards[w->list[i]].centroid[a];
      if (c < low[a]) low[a] = c;
      if (c > high[a]) high[a] = c;
    }
  for (uint32_t a = 1; a < 3; ++a)
    if (high[a] - low[a] > high[axis] - low[axis]) axis = a;
  const double plane = 0.5 * (low[axis] + high[axis]);
  uint32_t below = first;
  for (uint32_t i = first; i < first + count; ++i) {
    const uint32_t shard = w->list[i];
    if (w->view->shards[shard].centroid[axis] >= plane) continue;
    w->list[i] = w->list[below];
    w->list[below++] = shard;
  }
  uint32_t part = below - first;
  if (part == 0 || part == count) part = count / 2;
  /* Runs in proportion to shards, one at least for each half. */
  uint32_t share = (uint32_t)((uint64_t)most * part / count);
  share = share < 1 ? 1 : share > most - 1 ? most - 1 : share;
  split(w, first, part, share);
  split(w, first + part, count - part, most - share);
}

static double joined_volume(const group* a, const group* b, int16_t (*hull)[3], uint32_t* count) {
  int16_t points[2 * SHARD_PART_MAX_HULL][3];
  memcpy(points, a->hull, a->hull_count * sizeof *points);
  memcpy(points + a->hull_count, b->hull, b->hull_count * sizeof *points);
  *count = reduce((const int16_t(*)[3])points, a->hull_count + b->hull_count, hull);
  return convex_volume((const int16_t(*)[3])hull, *count);
}

static void measure(const parts_work* w, pair* p) {
  int16_t hull[SHARD_PART_MAX_HULL][3];
  uint32_t count;
  const group *a = &w->groups[p->a], *b = &w->groups[p->b];
  p->added = joined_volume(a, b, hull, &count) - a->volume - b->volume;
}

static void add_pair(parts_work* w, uint32_t a, uint32_t b) {
  const uint32_t low = a < b ? a : b, high = a < b ? b : a;
  if (low == high) return;
  for (uint32_t i = 0; i < w->pair_count; ++i)
    if (w->pairs[i].a == low && w->pairs[i].b == high) return;
  w->pairs[w->pair_count] = (pair){low, high, 0};
  measure(w, &w->pairs[w->pair_count++]);
}

/* b becomes part of a. */
static void merge(parts_work* w, uint32_t a, uint32_t b) {
  group *to = &w->groups[a], *from = &w->groups[b];
  to->volume = joined_volume(to, from, to->hull, &to->hull_count);
  from->into = a;
  uint32_t kept = 0;
  const uint32_t before = w->pair_count;
  for (uint32_t i = 0; i < before; ++i) {
    pair p = w->pairs[i];
    const bool changed = p.a == a || p.b == a || p.a == b || p.b == b;
    if (p.a == b) p.a = a;
    if (p.b == b) p.b = a;
    if (p.a == p.b) continue;
    if (p.a > p.b) p = (pair){p.b, p.a, 0};
    bool known = false;
    for (uint32_t k = 0; changed && k < kept; ++k) known = known || (w->pairs[k].a == p.a && w->pairs[k].b == p.b);
    if (known) continue;
    if (changed) measure(w, &p);
    w->pairs[kept++] = p;
  }
  w->pair_count = kept;
}

static void join_groups(parts_work* w, double all) {
  for (uint32_t left = w->group_count; left > 1; --left) {
    uint32_t best = w->pair_count;
    double least = INFINITY;
    for (uint32_t i = 0; i < w->pair_count; ++i)
      if (w->pairs[i].added < least) least = w->pairs[i].added, best = i;
    if (left <= SHARD_PARTS_MAX && !(least < LEAST_AIR * all)) return;
    uint32_t a = 0, b = 0;
    if (best < w->pair_count) {
      a = w->pairs[best].a;
      b = w->pairs[best].b;
    } else { /* apart from each other: the last two */
      for (b = w->group_count - 1; w->groups[b].into != b; --b) {}
      for (a = b - 1; w->groups[a].into != a; --a) {}
    }
    merge(w, a, b);
  }
}

static bool work_create(parts_work* w, uint32_t shards, const scree_allocator* allocator) {
  w->group_of = scree_rt_allocate(allocator, shards, sizeof *w->group_of);
  w->list = scree_rt_allocate(allocator, shards, sizeof *w->list);
  w->groups = scree_rt_allocate_zeroed(allocator, GROUPS_MAX, sizeof *w->groups);
  w->pairs = scree_rt_allocate(allocator, (size_t)GROUPS_MAX * GROUPS_MAX / 2, sizeof *w->pairs);
  return w->group_of != NULL && w->list != NULL && w->groups != NULL && w->pairs != NULL;
}

scree_result shard_parts_make(const scree_shards_view* shards, const uint8_t* inside, const int16_t (*places)[3],
                              const scree_allocator* allocator, shard_part* parts, uint32_t* count, double* volume) {
  parts_work w = {.view = shards, .inside = inside, .places = places};
  const bool complete = work_create(&w, shards->shard_count, allocator);
  *count = 0;
  *volume = 0;
  if (complete) {
    for (uint32_t s = 0; s < shards->shard_count; ++s) {
      w.group_of[s] = UINT32_MAX;
      if (inside[s]) w.list[w.listed++] = s;
    }
    split(&w, 0, w.listed, GROUPS_MAX);
    for (uint32_t s = 0; s < shards->shard_count; ++s)
      if (inside[s]) add_shard(&w, s, &w.groups[w.group_of[s]]);
    double all = 0;
    for (uint32_t g = 0; g < w.group_count; ++g) {
      w.groups[g].into = g;
      w.groups[g].volume = convex_volume((const int16_t(*)[3])w.groups[g].hull, w.groups[g].hull_count);
      all += w.groups[g].volume;
    }
    for (uint32_t l = 0; l < shards->interior_link_count; ++l) {
      const uint32_t a = shards->links[l].shards[0], b = shards->links[l].shards[1];
      if (inside[a] && inside[b]) add_pair(&w, w.group_of[a], w.group_of[b]);
    }
    join_groups(&w, all);
    for (uint32_t g = 0; g < w.group_count; ++g) {
      if (w.groups[g].into != g || w.groups[g].hull_count < 4 || !(w.groups[g].volume > 0)) continue;
      memcpy(parts[*count].hull, w.groups[g].hull, sizeof parts->hull);
      parts[(*count)++].hull_count = w.groups[g].hull_count;
      *volume += w.groups[g].volume;
    }
  }
  scree_rt_release(allocator, w.group_of, shards->shard_count, sizeof *w.group_of);
  scree_rt_release(allocator, w.list, shards->shard_count, sizeof *w.list);
  scree_rt_release(allocator, w.groups, GROUPS_MAX, sizeof *w.groups);
  scree_rt_release(allocator, w.pairs, (size_t)GROUPS_MAX * GROUPS_MAX / 2, sizeof *w.pairs);
  return complete ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
}
