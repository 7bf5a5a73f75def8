/* Level sets of the distance from what is supported, merged from the farthest in by union-find; each group's root carries its
 * weight and, while its level is looked at, the sums over its cut. */
#include "frost_stability.h"

#include <math.h>
#include <string.h>

#include "shards_internal.h"
#include "vectors.h"

#define GRAVITY 9.81
#define NO_LEVEL UINT32_MAX

/* Symmetric 3 x 3: xx, yy, zz, xy, xz, yz. */
typedef double symmetric[6];

/* Of the group whose root this shard is. */
typedef struct group_sums {
  double volume, first[3]; /* sum of volume and of volume * centroid */
  double area, centre[3];  /* of its cut at this level: A, then c */
  symmetric moments;       /* J */
  double twist[3];         /* t */
  uint32_t level;          /* that these sums are of */
  bool breaks;             /* the cut is too weak */
} group_sums;

struct frost_stability {
  scree_allocator allocator;
  scree_shards_view view;
  symmetric* spread; /* K of each interior link */
  uint32_t* level;
  uint32_t* queue;  /* shards by level */
  uint32_t* root;   /* union-find */
  uint32_t* groups; /* roots of the level that is looked at */
  group_sums* sums;
  uint32_t* cuts;
  uint32_t cut_count;
};

static void add_outer(symmetric s, const double v[3], double weight) {
  s[0] += weight * v[0] * v[0];
  s[1] += weight * v[1] * v[1];
  s[2] += weight * v[2] * v[2];
  s[3] += weight * v[0] * v[1];
  s[4] += weight * v[0] * v[2];
  s[5] += weight * v[1] * v[2];
}

/* K of a link: polygons as fans of triangles, with signs, so that they may be concave. */
static void spread_of(const scree_shards_view* v, const scree_link* link, symmetric out) {
  memset(out, 0, sizeof(symmetric));
  for (uint32_t p = link->first_polygon; p < link->first_polygon + link->polygon_count; ++p) {
    const scree_polygon* polygon = &v->polygons[p];
    const uint32_t* corners = v->corners + polygon->first_corner;
    for (uint32_t i = 1; i + 1 < polygon->corner_count; ++i) {
      const double* from[3] = {v->vertices + 3 * (size_t)corners[0], v->vertices + 3 * (size_t)corners[i],
                               v->vertices + 3 * (size_t)corners[i + 1]};
      double place[3][3], sum[3] = {0, 0, 0}, edges[2][3], normal[3];
      for (int c = 0; c < 3; ++c)
        for (int axis = 0; axis < 3; ++axis) {
          place[c][axis] = from[c][axis] - link->centroid[axis];
          sum[axis] += place[c][axis];
        }
      for (int axis = 0; axis < 3; ++axis) {
        edges[0][axis] = place[1][axis] - place[0][axis];
        edges[1][axis] = place[2][axis] - place[0][axis];
      }
      cross(edges[0], edges[1], normal);
      const double twelfth = dot(normal, link->normal) / 24;
      for (int c = 0; c < 3; ++c) add_outer(out, place[c], twelfth);
      add_outer(out, sum, twelfth);
    }
  }
}

static void release_all(frost_stability* s) {
  const scree_allocator a = s->allocator;
  const uint32_t shards = s->view.shard_count, links = s->view.interior_link_count;
  scree_rt_release(&a, s->spread, links, sizeof *s->spread);
  scree_rt_release(&a, s->level, shards, sizeof *s->level);
  scree_rt_release(&a, s->queue, shards, sizeof *s->queue);
  scree_rt_release(&a, s->root, shards, sizeof *s->root);
  scree_rt_release(&a, s->groups, shards, sizeof *s->groups);
  scree_rt_release(&a, s->sums, shards, sizeof *s->sums);
  scree_rt_release(&a, s->cuts, links, sizeof *s->cuts);
  scree_rt_release(&a, s, 1, sizeof *s);
}

scree_result frost_stability_create(const scree_shards* shards, const scree_allocator* allocator, frost_stability** out) {
  *out = NULL;
  const scree_allocator a = scree_rt_allocator_or_default(allocator);
  frost_stability* s = scree_rt_allocate_zeroed(&a, 1, sizeof *s);
  if (s == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  s->allocator = a;
  s->view = shards->view;
  const uint32_t count = s->view.shard_count, links = s->view.interior_link_count;
  s->spread = scree_rt_allocate(&a, links, sizeof *s->spread);
  s->level = scree_rt_allocate(&a, count, sizeof *s->level);
  s->queue = scree_rt_allocate(&a, count, sizeof *s->queue);
  s->root = scree_rt_allocate(&a, count, sizeof *s->root);
  s->groups = scree_rt_allocate(&a, count, sizeof *s->groups);
  s->sums = scree_rt_allocate(&a, count, sizeof *s->sums);
  s->cuts = scree_rt_allocate(&a, links, sizeof *s->cuts);
  if ((links > 0 && (s->spread == NULL || s->cuts == NULL)) || s->level == NULL || s->queue == NULL || s->root == NULL ||
      s->groups == NULL || s->sums == NULL) {
    release_all(s);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  for (uint32_t l = 0; l < links; ++l) spread_of(&s->view, &s->view.links[l], s->spread[l]);
  *out = s;
  return SCREE_OK;
}

void frost_stability_destroy(frost_stability* stability) {
  if (stability != NULL) release_all(stability);
}

size_t frost_stability_memory(const frost_stability* s) {
  return sizeof *s + s->view.interior_link_count * (sizeof *s->spread + sizeof *s->cuts) +
         s->view.shard_count * (sizeof *s->level + sizeof *s->queue + sizeof *s->root + sizeof *s->groups + sizeof *s->sums);
}

/* Whether a shard reaches as far as `least` along a direction. */
static bool reaches(const scree_shards_view* v, const scree_shard* shard, const double along[3], double least) {
  for (uint32_t k = 0; k < shard->link_count; ++k) {
    const scree_link* link = &v->links[v->shard_links[shard->first_link + k]];
    for (uint32_t p = link->first_polygon; p < link->first_polygon + link->polygon_count; ++p) {
      const scree_polygon* polygon = &v->polygons[p];
      for (uint32_t c = 0; c < polygon->corner_count; ++c)
        if (dot(v->vertices + 3 * (size_t)v->corners[polygon->first_corner + c], along) >= least) return true;
    }
  }
  return false;
}

void frost_find_rests(const scree_shards_view* v, const double gravity[3], uint8_t* rests) {
  double least = INFINITY, most = -INFINITY;
  for (uint32_t i = 0; i < v->vertex_count; ++i) {
    const double at = dot(v->vertices + 3 * (size_t)i, gravity);
    if (at < least) least = at;
    if (at > most) most = at;
  }
  const double lowest = most - 1e-6 * (most - least);
  for (uint32_t i = 0; i < v->shard_count; ++i) rests[i] = reaches(v, &v->shards[i], gravity, lowest);
}

/* Levels, breadth first. Returns how many shards have one; they are the queue's first, by level. */
static uint32_t find_levels(frost_stability* s, const frost_stability_state* state) {
  const scree_shards_view* v = &s->view;
  bool core = false;
  for (uint32_t i = 0; i < v->shard_count && !core; ++i) core = state->states[i] == SCREE_SHARD_CORE;
  uint32_t met = 0;
  for (uint32_t i = 0; i < v->shard_count; ++i) {
    const bool supported =
        core ? state->states[i] == SCREE_SHARD_CORE : state->states[i] != SCREE_SHARD_AIR && state->rests[i] != 0;
    s->level[i] = supported ? 0 : NO_LEVEL;
    if (supported) s->queue[met++] = i;
  }
  for (uint32_t done = 0; done < met; ++done) {
    const uint32_t i = s->queue[done];
    const scree_shard* shard = &v->shards[i];
    for (uint32_t k = 0; k < shard->link_count; ++k) {
      const uint32_t l = v->shard_links[shard->first_link + k];
      if (l >= v->interior_link_count) break; /* they rise, and exterior ones are behind */
      if (!(state->lives[l] > 0)) continue;
      const scree_link* link = &v->links[l];
      const uint32_t j = link->shards[0] == i ? link->shards[1] : link->shards[0];
      if (state->states[j] == SCREE_SHARD_AIR || s->level[j] != NO_LEVEL) continue;
      s->level[j] = s->level[i] + 1;
      s->queue[met++] = j;
    }
  }
  return met;
}

static uint32_t find_root(frost_stability* s, uint32_t i) {
  while (s->root[i] != i) {
    s->root[i] = s->root[s->root[i]];
    i = s->root[i];
  }
  return i;
}

static void join(frost_stability* s, uint32_t a, uint32_t b) {
  a = find_root(s, a);
  b = find_root(s, b);
  if (a == b) return;
  if (b < a) {
    const uint32_t swap = a;
    a = b;
    b = swap;
  }
  s->root[b] = a; /* halving of paths alone keeps this near constant */
  s->sums[a].volume += s->sums[b].volume;
  for (int axis = 0; axis < 3; ++axis) s->sums[a].first[axis] += s->sums[b].first[axis];
}

/* J t = M by Cramer's rule; J is positive definite. */
static void solve(const symmetric j, const double m[3], double out[3]) {
  const double xx = j[1] * j[2] - j[5] * j[5], xy = j[4] * j[5] - j[3] * j[2], xz = j[3] * j[5] - j[4] * j[1];
  const double yy = j[0] * j[2] - j[4] * j[4], yz = j[3] * j[4] - j[0] * j[5], zz = j[0] * j[1] - j[3] * j[3];
  const double determinant = j[0] * xx + j[3] * xy + j[4] * xz;
  out[0] = (xx * m[0] + xy * m[1] + xz * m[2]) / determinant;
  out[1] = (xy * m[0] + yy * m[1] + yz * m[2]) / determinant;
  out[2] = (xz * m[0] + yz * m[1] + zz * m[2]) / determinant;
}

/* What the sums over a level's links are for. */
typedef enum cut_pass { PASS_AREA, PASS_MOMENTS, PASS_STRESS, PASS_LIST } cut_pass;

static void visit_cut(frost_stability* s, const frost_stability_state* state, uint32_t shard, uint32_t l, const double weight[3],
                      cut_pass pass) {
  const scree_shards_view* v = &s->view;
  const scree_link* link = &v->links[l];
  group_sums* g = &s->sums[find_root(s, shard)];
  const double life = state->lives[l], area = life * link->area;
  if (pass == PASS_AREA) {
    g->area += area;
    for (int axis = 0; axis < 3; ++axis) g->centre[axis] += area * link->centroid[axis];
  } else if (pass == PASS_MOMENTS) {
    symmetric places = {0};
    double r[3];
    for (int axis = 0; axis < 3; ++axis) r[axis] = link->centroid[axis] - g->centre[axis];
    add_outer(places, r, area);
    for (int e = 0; e < 6; ++e) places[e] += life * s->spread[l][e];
    const double trace = places[0] + places[1] + places[2];
    for (int e = 0; e < 6; ++e) g->moments[e] += (e < 3 ? trace : 0) - places[e];
  } else if (pass == PASS_STRESS) {
    const double sign = link->shards[0] == shard ? -1 : 1; /* the normal goes out of shards[0] */
    for (uint32_t p = link->first_polygon; p < link->first_polygon + link->polygon_count && !g->breaks; ++p) {
      const scree_polygon* polygon = &v->polygons[p];
      for (uint32_t c = 0; c < polygon->corner_count; ++c) {
        const double* at = v->vertices + 3 * (size_t)v->corners[polygon->first_corner + c];
        double r[3], turn[3], force[3], along[3];
        for (int axis = 0; axis < 3; ++axis) r[axis] = at[axis] - g->centre[axis];
        cross(g->twist, r, turn);
        for (int axis = 0; axis < 3; ++axis) force[axis] = weight[axis] * g->volume / g->area + turn[axis];
        const double tension = sign * dot(force, link->normal);
        for (int axis = 0; axis < 3; ++axis) along[axis] = force[axis] - sign * tension * link->normal[axis];
        /* So put that a cut of no area, whose stress is no number, breaks. */
        const bool holds = tension + sqrt(dot(along, along)) <= state->strength && -tension <= state->compression * state->strength;
        if (!holds) g->breaks = true;
      }
    }
  } else if (g->breaks) {
    s->cuts[s->cut_count++] = l;
  }
}

/* Looks at the links from shards queue[first] .. queue[end - 1], which are all at one level, to the level below. */
static void visit_level(frost_stability* s, const frost_stability_state* state, uint32_t first, uint32_t end,
                        const double weight[3], cut_pass pass) {
  const scree_shards_view* v = &s->view;
  for (uint32_t q = first; q < end; ++q) {
    const uint32_t i = s->queue[q];
    const scree_shard* shard = &v->shards[i];
    for (uint32_t k = 0; k < shard->link_count; ++k) {
      const uint32_t l = v->shard_links[shard->first_link + k];
      if (l >= v->interior_link_count) break;
      if (!(state->lives[l] > 0)) continue;
      const scree_link* link = &v->links[l];
      const uint32_t j = link->shards[0] == i ? link->shards[1] : link->shards[0];
      if (s->level[j] != NO_LEVEL && s->level[j] + 1 == s->level[i]) visit_cut(s, state, i, l, weight, pass);
    }
  }
}

/* A level's shards join what they touch at their own level or farther out. Those that broke off are passed over. */
static void gather(frost_stability* s, const frost_stability_state* state, uint32_t first, uint32_t end) {
  const scree_shards_view* v = &s->view;
  for (uint32_t q = first; q < end; ++q) {
    const uint32_t i = s->queue[q];
    group_sums* g = &s->sums[i];
    memset(g, 0, sizeof *g);
    s->root[i] = i;
    g->volume = v->shards[i].volume;
    for (int axis = 0; axis < 3; ++axis) g->first[axis] = v->shards[i].volume * v->shards[i].centroid[axis];
  }
  for (uint32_t q = first; q < end; ++q) {
    const uint32_t i = s->queue[q];
    const scree_shard* shard = &v->shards[i];
    for (uint32_t k = 0; k < shard->link_count; ++k) {
      const uint32_t l = v->shard_links[shard->first_link + k];
      if (l >= v->interior_link_count) break;
      if (!(state->lives[l] > 0)) continue;
      const scree_link* link = &v->links[l];
      const uint32_t j = link->shards[0] == i ? link->shards[1] : link->shards[0];
      if (s->level[j] == NO_LEVEL || s->level[j] < s->level[i]) continue;
      if (s->sums[find_root(s, j)].breaks) continue; /* it has fallen with its weight */
      join(s, i, j);
    }
  }
}

/* One level. Returns how many of its groups break off. */
static uint32_t weigh_level(frost_stability* s, const frost_stability_state* state, uint32_t first, uint32_t end,
                            const double weight[3]) {
  gather(s, state, first, end);
  const uint32_t level = s->level[s->queue[first]];
  uint32_t count = 0, broken = 0;
  for (uint32_t q = first; q < end; ++q) {
    const uint32_t root = find_root(s, s->queue[q]); /* which may be farther out */
    group_sums* g = &s->sums[root];
    if (g->level == level) continue;
    g->level = level;
    g->area = 0;
    memset(g->centre, 0, sizeof g->centre);
    memset(g->moments, 0, sizeof g->moments);
    s->groups[count++] = root;
  }
  visit_level(s, state, first, end, weight, PASS_AREA);
  for (uint32_t i = 0; i < count; ++i) {
    group_sums* g = &s->sums[s->groups[i]];
    for (int axis = 0; axis < 3; ++axis) g->centre[axis] /= g->area;
  }
  visit_level(s, state, first, end, weight, PASS_MOMENTS);
  for (uint32_t i = 0; i < count; ++i) {
    group_sums* g = &s->sums[s->groups[i]];
    double arm[3], force[3], moment[3];
    const double little = 1e-9 * (g->moments[0] + g->moments[1] + g->moments[2]);
    for (int axis = 0; axis < 3; ++axis) {
      g->moments[axis] += little;
      arm[axis] = g->first[axis] / g->volume - g->centre[axis];
      force[axis] = weight[axis] * g->volume;
    }
    cross(arm, force, moment);
    solve(g->moments, moment, g->twist);
  }
  visit_level(s, state, first, end, weight, PASS_STRESS);
  for (uint32_t i = 0; i < count; ++i) broken += s->sums[s->groups[i]].breaks;
  if (broken > 0) visit_level(s, state, first, end, weight, PASS_LIST);
  return broken;
}

uint32_t frost_stability_weigh(frost_stability* s, const frost_stability_state* state) {
  s->cut_count = 0;
  const double length = sqrt(dot(state->gravity, state->gravity));
  double weight[3];
  for (int axis = 0; axis < 3; ++axis) weight[axis] = state->gravity[axis] / length * (GRAVITY * state->density);
  uint32_t broken = 0;
  for (uint32_t end = find_levels(s, state), first; end > 0; end = first) {
    const uint32_t level = s->level[s->queue[end - 1]];
    if (level == 0) break;
    for (first = end; first > 0 && s->level[s->queue[first - 1]] == level;) --first;
    broken += weigh_level(s, state, first, end, weight);
  }
  return broken;
}

uint32_t frost_stability_cuts(const frost_stability* s, const uint32_t** links) {
  *links = s->cuts;
  return s->cut_count;
}
