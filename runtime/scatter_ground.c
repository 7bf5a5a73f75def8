/* Where the instances of a scatter stand.
 * Based on: Hart, Sphere Tracing, 1996. Where we differ: heights are whole steps, and what is looked for is the highest step of a
 * vertical line that is inside the ground; the Lipschitz bound only says which steps cannot be. So the answer depends on the
 * distances at those steps alone, not on where the search began: a change of the ground elsewhere changes nothing here. */
#include <math.h>
#include <string.h>

#include "scatter_internal.h"
#include "scene_layers.h"

enum {
  BATCH = 32,  /* points looked at together */
  SAMPLES = 8, /* of a footprint's circle */
  MOST_COLUMNS = BATCH * SAMPLES
};

#define HALF_ROOT 0.70710678118654752
static const double circle[SAMPLES][2] = {{1, 0},  {HALF_ROOT, HALF_ROOT},   {0, 1},  {-HALF_ROOT, HALF_ROOT},
                                          {-1, 0}, {-HALF_ROOT, -HALF_ROOT}, {0, -1}, {HALF_ROOT, -HALF_ROOT}};

/* A vertical line: the search goes down from `level`, to `low` at most. */
typedef struct column {
  float x, z; /* support's space */
  int64_t level, low;
  bool found;
} column;

typedef struct candidate {
  scatter_found found;
  double radius; /* of its footprint, metres */
  bool dropped;
} candidate;

typedef struct search {
  const scatter_visit* visit;
  double base[3]; /* the scatter's origin in the support's space */
  double lipschitz, largest, doubt;
  int64_t top;            /* no ground is higher, steps */
  double low[2], high[2]; /* box of the points, metres from the scatter's origin */
  candidate candidates[BATCH];
  uint32_t count;
  column columns[MOST_COLUMNS];
} search;

/* How many steps down the next one is that could be inside. */
static int64_t steps_down(const search* s, double distance, double x, double y, double z, double left) {
  const double largest = fmax(fmax(s->largest, fabs(y)), fmax(fabs(x), fabs(z)));
  const double way = (distance - 2 * s->doubt) / s->lipschitz - largest * 8e-6;
  const double steps = floor(way / s->visit->scatter->unit);
  return steps >= left ? (int64_t)left + 1 : steps > 1 ? (int64_t)steps : 1; /* what is not a number goes one step */
}

/* Moves columns down to the ground. */
static void go_down(search* s, uint32_t count) {
  uint16_t live[MOST_COLUMNS];
  for (uint32_t i = 0; i < count; ++i) live[i] = (uint16_t)i;
  while (count > 0) {
    uint32_t kept = 0;
    for (uint32_t first = 0; first < count; first += SUPPORT_BATCH) {
      const uint32_t n = count - first < SUPPORT_BATCH ? count - first : SUPPORT_BATCH;
      float x[SUPPORT_BATCH], y[SUPPORT_BATCH], z[SUPPORT_BATCH], distance[SUPPORT_BATCH];
      for (uint32_t i = 0; i < n; ++i) {
        const column* c = &s->columns[live[first + i]];
        x[i] = c->x;
        y[i] = (float)(s->base[1] + s->visit->scatter->unit * (double)c->level);
        z[i] = c->z;
      }
      scree_support_distance(s->visit->ground, x, y, z, distance, n);
      for (uint32_t i = 0; i < n; ++i) {
        column* c = &s->columns[live[first + i]];
        c->found = distance[i] <= 0;
        if (c->found) continue;
        c->level -= steps_down(s, (double)distance[i], (double)x[i], (double)y[i], (double)z[i], (double)(c->level - c->low));
        if (c->level >= c->low) live[kept++] = live[first + i];
      }
    }
    count = kept;
  }
}

bool scree_rt_scatter_passes(const scatter_visit* v, const scatter_found* found, bool planar) {
  if (v->layer == NULL || !v->layer->filtered) return true;
  const double half = v->scatter->lattice.cell_size * 0.5;
  double at[3]; /* relative to the lattice's origin */
  for (int a = 0; a < 3; ++a) at[a] = v->scatter->unit * (double)found->steps[a] - half;
  return scree_rt_scene_passes_at(v->layer, at, (const int32_t[3]){found->tile[0], 0, found->tile[1]}, found->local, planar);
}

/* The ground under the middles of all candidates. */
static void find_middles(search* s) {
  const scatter_visit* v = s->visit;
  for (uint32_t i = 0; i < s->count; ++i) {
    const int64_t* steps = s->candidates[i].found.steps;
    s->columns[i] = (column){.x = (float)(s->base[0] + v->scatter->unit * (double)steps[0]),
                             .z = (float)(s->base[2] + v->scatter->unit * (double)steps[2]),
                             .level = s->top,
                             .low = v->low[1] * SCATTER_SIDE};
  }
  go_down(s, s->count);
  uint32_t kept = 0;
  for (uint32_t i = 0; i < s->count; ++i) {
    candidate c = s->candidates[i];
    c.found.steps[1] = s->columns[i].level;
    const int64_t sink = (int64_t)(c.radius * v->scatter->slope / v->scatter->unit);
    if (s->columns[i].found && c.found.steps[1] - sink < v->high[1] * SCATTER_SIDE) s->candidates[kept++] = c;
  }
  s->count = kept;
}

/* Sinks candidates to the lowest ground round their footprints, or drops them. */
static void fit_footprints(search* s) {
  const scree_scatter* scatter = s->visit->scatter;
  for (uint32_t i = 0; i < s->count; ++i) {
    const candidate* c = &s->candidates[i];
    const int64_t slack = (int64_t)(c->radius * scatter->slope / scatter->unit);
    for (uint32_t k = 0; k < SAMPLES; ++k)
      s->columns[i * SAMPLES + k] =
          (column){.x = (float)((s->base[0] + scatter->unit * (double)c->found.steps[0]) + c->radius * circle[k][0]),
                   .z = (float)((s->base[2] + scatter->unit * (double)c->found.steps[2]) + c->radius * circle[k][1]),
                   .level = c->found.steps[1] + slack + 1, /* ground up there is too steep */
                   .low = c->found.steps[1] - slack};
  }
  go_down(s, s->count * SAMPLES);
  for (uint32_t i = 0; i < s->count; ++i) {
    candidate* c = &s->candidates[i];
    const int64_t middle = c->found.steps[1], slack = (int64_t)(c->radius * scatter->slope / scatter->unit);
    for (uint32_t k = 0; k < SAMPLES; ++k) {
      const column* edge = &s->columns[i * SAMPLES + k];
      if (!edge->found || edge->level > middle + slack) c->dropped = true;
      if (edge->level < c->found.steps[1]) c->found.steps[1] = edge->level;
    }
  }
}

/* Decides about the candidates so far. */
static bool settle(search* s, bool (*found)(void* user, const scatter_found* instance), void* user) {
  const scatter_visit* v = s->visit;
  find_middles(s);
  fit_footprints(s);
  bool on = true;
  for (uint32_t i = 0; i < s->count && on; ++i) {
    const candidate* c = &s->candidates[i];
    const int64_t y = c->found.steps[1];
    if (c->dropped || y < v->low[1] * SCATTER_SIDE || y >= v->high[1] * SCATTER_SIDE ||
        !scree_rt_scatter_passes(v, &c->found, false))
      continue;
    on = found(user, &c->found);
  }
  s->count = 0;
  return on;
}

/* What of the visit lies where the ground can be. Returns false where nothing does. */
static bool begin(search* s, const scatter_visit* v, int64_t low[2], int64_t high[2]) {
  const scree_scatter* scatter = v->scatter;
  const double side = scatter->lattice.cell_size;
  double ground_low[3], ground_high[3];
  s->visit = v;
  s->count = 0;
  s->lipschitz = scree_rt_support_lipschitz(v->ground);
  s->largest = v->ground->magnitude;
  s->doubt = 0;
  for (uint32_t i = 0; i < v->ground->op_count; ++i) /* not with fmax, over which gcc 12 for aarch64 stumbles */
    if ((double)v->ground->ops[i].doubt > s->doubt) s->doubt = (double)v->ground->ops[i].doubt;
  if (!scree_rt_support_level_bounds(v->ground, 0, ground_low, ground_high)) return false;
  for (int a = 0; a < 3; ++a) {
    s->base[a] = scatter->origin[a] - v->ground->origin[a];
    const double slack = (fabs(s->base[a]) + s->largest) * 1e-6 + 2 * s->doubt;
    ground_low[a] -= s->base[a] + slack;
    ground_high[a] -= s->base[a] - slack;
  }
  const double top = ground_high[1] / scatter->unit;
  if (!(fabs(top) < 9e15)) return false;
  s->top = (int64_t)ceil(top);
  for (int i = 0; i < 2; ++i) {
    s->low[i] = fmax(ground_low[2 * i], v->box_low[i]);
    s->high[i] = fmin(ground_high[2 * i], v->box_high[i]);
    const double first = floor(s->low[i] / side), last = floor(s->high[i] / side);
    low[i] = first > (double)v->low[2 * i] ? (int64_t)fmin(first, 3e9) : v->low[2 * i];
    high[i] = last < (double)v->high[2 * i] ? (int64_t)fmax(last, -3e9) + 1 : v->high[2 * i];
    if (low[i] >= high[i]) return false;
  }
  return s->top >= v->low[1] * SCATTER_SIDE;
}

uint32_t scree_rt_scatter_code(const scree_scatter* scatter, int32_t x, int32_t z) {
  const uint64_t seed = scatter->lattice.seed;
  const int32_t x1 = (int32_t)((uint32_t)x + 1), z1 = (int32_t)((uint32_t)z + 1); /* wraps at the end, as its hash does */
  return corner_colour(seed, x, 0, z) | corner_colour(seed, x1, 0, z) << 1 | corner_colour(seed, x, 0, z1) << 2 |
         corner_colour(seed, x1, 0, z1) << 3;
}

bool scree_rt_scatter_steps(const scree_scatter* scatter, int32_t x, int32_t z, uint32_t local, int64_t steps[2]) {
  if (scatter->is_cliff) {
    const cliff_point* point = scree_rt_cliff_point(scatter, x, z, local);
    if (point == NULL) return false;
    steps[0] = point->steps[0];
    steps[1] = point->steps[2];
    return true;
  }
  const scatter_tile* tile = &scatter->tiles[scree_rt_scatter_code(scatter, x, z)];
  if (local >= tile->count) return false;
  steps[0] = (int64_t)x * SCATTER_SIDE + tile->x[local];
  steps[1] = (int64_t)z * SCATTER_SIDE + tile->z[local];
  return true;
}

void scree_rt_scatter_place(const scree_scatter* scatter, const scree_id* id, uint32_t packed, double place[3]) {
  int64_t steps[2] = {0, 0};
  scree_rt_scatter_steps(scatter, id->cube[0], id->cube[2], id->local, steps);
  place[0] = scatter->unit * (double)steps[0];
  place[1] = scatter->unit * (double)scatter_level_of(id, packed);
  place[2] = scatter->unit * (double)steps[1];
}

static double share_of(uint64_t hash, uint64_t what) {
  return (double)(hash_combine(hash, what) >> 11) * 0x1p-53;
}

/* The model at a share of the sum of all weights. */
static uint32_t by_weight(const scree_scatter* s, double share) {
  double sum = 0;
  for (uint32_t i = 0; i < s->model_count; ++i) sum += s->models[i].weight;
  double left = share * sum;
  uint32_t chosen = 0;
  for (uint32_t i = 0; i < s->model_count; ++i) {
    if (!(s->models[i].weight > 0)) continue;
    chosen = i;
    left -= s->models[i].weight;
    if (left < 0) break;
  }
  return chosen;
}

uint32_t scree_rt_scatter_choose(const scree_scatter* s, uint64_t hash, const int64_t steps[2]) {
  const uint32_t model = by_weight(s, share_of(hash, 1));
  if (!s->masked) return model;
  uint32_t variant = 0;
  while (s->variants[variant + 1] <= model) ++variant;
  const double x = (s->origin[0] - s->age_mask.centre[0]) + s->unit * (double)steps[0],
               z = (s->origin[2] - s->age_mask.centre[2]) + s->unit * (double)steps[1];
  const uint32_t first = s->variants[variant], ages = s->variants[variant + 1] - first;
  const double age = scree_rt_filter_mask(&s->age_mask, x, z) * (double)(ages - 1) + share_of(hash, 2);
  return first + (age < (double)(ages - 1) ? (uint32_t)age : ages - 1);
}

static void look_at(search* s, int32_t x, int32_t z, uint32_t local) {
  const scree_scatter* scatter = s->visit->scatter;
  int64_t steps[2] = {0, 0};
  if (!scree_rt_scatter_steps(scatter, x, z, local, steps)) return;
  for (int i = 0; i < 2; ++i) {
    const double at = scatter->unit * (double)steps[i];
    if (!(at >= s->low[i] && at <= s->high[i])) return;
  }
  candidate c = {.found = {.tile = {x, z}, .local = local, .steps = {steps[0], 0, steps[1]}}};
  if (!scree_rt_scatter_passes(s->visit, &c.found, true)) return;
  const uint64_t hash = scree_rt_scatter_hash(scatter, x, z, local);
  float turn[2], scale;
  scree_scatter_turn(scatter, (uint32_t)(hash >> 32), turn, &scale);
  c.found.model = scree_rt_scatter_choose(scatter, hash, steps);
  c.radius = (double)scatter->models[c.found.model].footprint * (double)scale;
  s->candidates[s->count++] = c;
}

bool scree_rt_scatter_visit(const scatter_visit* v, bool (*found)(void* user, const scatter_found* instance), void* user) {
  if (v->scatter->is_cliff) return scree_rt_cliff_visit(v, found, user);
  search s;
  int64_t low[2], high[2];
  if (!begin(&s, v, low, high)) return true;
  for (int64_t z = low[1]; z < high[1]; ++z)
    for (int64_t x = low[0]; x < high[0]; ++x) {
      const uint32_t count = v->scatter->tiles[scree_rt_scatter_code(v->scatter, (int32_t)x, (int32_t)z)].count;
      for (uint32_t local = 0; local < count; ++local) {
        look_at(&s, (int32_t)x, (int32_t)z, local);
        if (s.count == BATCH && !settle(&s, found, user)) return false;
      }
    }
  return settle(&s, found, user);
}

/* --- without a scene -------------------------------------------------------------------------------------------------------- */

typedef struct placement_sink {
  const scree_scatter* scatter;
  const double *min, *max; /* NULL: all */
  scree_placement* placements;
  uint64_t capacity, count;
} placement_sink;

static bool place(void* user, const scatter_found* found) {
  placement_sink* sink = user;
  const scree_scatter* s = sink->scatter;
  scree_placement p;
  memset(&p, 0, sizeof p);
  for (int a = 0; a < 3; ++a) {
    p.position[a] = s->origin[a] + s->unit * (double)found->steps[a];
    if (sink->min != NULL && !(p.position[a] >= sink->min[a] && p.position[a] < sink->max[a])) return true;
  }
  p.id = (scree_id){{found->tile[0], (int32_t)(found->steps[1] >> SCATTER_SIDE_BITS), found->tile[1]}, (uint16_t)found->local, 0};
  p.random = scree_scatter_random(s, &p.id);
  scree_scatter_turn(s, p.random, p.turn, &p.scale);
  p.model = found->model;
  if (sink->count < sink->capacity) sink->placements[sink->count] = p;
  ++sink->count;
  return true;
}

scree_result scree_scatter_fill(const scree_scatter* scatter, const scree_support* ground, const double min[3], const double max[3],
                                scree_placement* placements, uint64_t capacity, uint64_t* count) {
  if (count != NULL) *count = 0;
  if (scatter != NULL && scatter->is_cliff) ground = scatter->ground;
  if (scatter == NULL || ground == NULL || min == NULL || max == NULL || count == NULL || (placements == NULL && capacity > 0))
    return SCREE_ERROR_INVALID_ARGUMENT;
  bool everywhere = true;
  for (int a = 0; a < 3; ++a) {
    if (!(min[a] <= max[a])) return SCREE_ERROR_INVALID_ARGUMENT;
    everywhere = everywhere && min[a] == 0 && max[a] == 0;
  }
  const double side = scatter->lattice.cell_size;
  double low[3], high[3];
  scatter_visit v = {.scatter = scatter, .ground = ground};
  if (!scree_rt_support_level_bounds(ground, 0, low, high)) return SCREE_OK;
  for (int a = 0; a < 3; ++a) {
    const double base = scatter->origin[a] - ground->origin[a];
    if (a == 1 && !isfinite(high[1])) return SCREE_ERROR_RANGE;
    low[a] -= base + (a == 1 ? scatter->sink + side : side) + fabs(base) * 1e-6;
    high[a] -= base - side - fabs(base) * 1e-6;
    if (!everywhere) {
      low[a] = fmax(low[a], min[a] - scatter->origin[a] - fabs(min[a]) * 1e-15);
      high[a] = fmin(high[a], max[a] - scatter->origin[a] + fabs(max[a]) * 1e-15);
    }
    if (!(low[a] <= high[a])) return SCREE_OK;
    const double first = floor(low[a] / side), end = floor(high[a] / side) + 1;
    if (!(first >= INT32_MIN && end <= INT32_MAX)) return SCREE_ERROR_RANGE;
    v.low[a] = (int64_t)first;
    v.high[a] = (int64_t)end;
    if (a == 1) continue;
    v.box_low[a / 2] = low[a];
    v.box_high[a / 2] = high[a];
  }
  placement_sink sink = {scatter, everywhere ? NULL : min, max, placements, capacity, 0};
  scree_rt_scatter_visit(&v, place, &sink);
  *count = sink.count;
  return sink.count > capacity ? SCREE_ERROR_CAPACITY : SCREE_OK;
}
