#include "frost_twin.h"

#include <stdlib.h>
#include <string.h>

#include "frost_draw.h"
#include "stability_twin.h"

static void* must(void* memory) {
  if (memory == NULL) abort();
  return memory;
}

static bool stands(const frost_twin* t, uint32_t shard) {
  return t->states[shard] != SCREE_SHARD_AIR;
}

/* Unit. Rules may have changed since the last time. */
static void gravity_of(const frost_twin* t, double out[3]) {
  const double* g = t->like->rules.gravity;
  const double most = fmax(fmax(fabs(g[0]), fabs(g[1])), fabs(g[2]));
  for (int a = 0; a < 3; ++a) out[a] = g[a] / most;
  const double length = sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
  for (int a = 0; a < 3; ++a) out[a] /= length;
}

/* Over the faces of all shards, so that an interior link counts twice; and over all links. */
static void find_areas(frost_twin* t) {
  const scree_shards_view* v = &t->like->view;
  double sum = 0, all = 0, faces = 0;
  for (uint32_t l = 0; l < v->link_count; ++l) {
    const double sides = v->links[l].shards[1] == SCREE_NO_SHARD ? 1 : 2;
    sum += sides * v->links[l].area;
    all += v->links[l].area;
    faces += sides;
  }
  t->mean_area = sum / faces;
  t->scale = 0x1p51 / all;
}

frost_twin* frost_twin_create(const scree_frost* like) {
  const size_t shards = like->view.shard_count, links = like->view.link_count;
  frost_twin* t = must(calloc(1, sizeof *t));
  t->like = like;
  t->stream = like->stream;
  t->states = must(malloc(shards));
  t->exterior = must(malloc(links));
  t->walked = must(malloc(links));
  t->lives = must(malloc(links * sizeof *t->lives));
  t->down = must(calloc(shards, 1));
  t->labels = must(malloc(shards * sizeof *t->labels));
  t->queue = must(malloc((shards + links) * sizeof *t->queue));
  t->blocks = must(calloc(shards, sizeof *t->blocks));
  memcpy(t->states, like->states, shards);
  memcpy(t->exterior, like->exterior, links);
  memcpy(t->lives, like->lives, links * sizeof *t->lives);
  const scree_block* blocks;
  const uint32_t* list;
  t->block_count = scree_frost_blocks(like, &blocks, &list);
  for (uint32_t b = 0; b < t->block_count; ++b)
    for (uint32_t i = 0; i < blocks[b].shard_count; ++i) t->blocks[list[blocks[b].first_shard + i]] = b + 1;
  find_areas(t);
  t->paths = like->stats.paths;
  t->breaks = like->stats.breaks;
  t->forced = like->stats.forced;
  t->detachments = like->stats.detachments;
  t->overloaded = like->stats.overloaded;
  t->unchecked = like->unchecked;
  t->visited = like->stats.links_visited;
  t->poured = like->stats.poured;
  t->absorbed = like->stats.absorbed;
  t->drained = like->stats.drained;
  return t;
}

frost_twin* frost_twin_start(const scree_frost* like, const uint8_t* states) {
  const scree_shards_view* v = &like->view;
  frost_twin* t = frost_twin_create(like);
  memset(t->states, SCREE_SHARD_SOLID, v->shard_count);
  if (states != NULL) memcpy(t->states, states, v->shard_count);
  memset(t->blocks, 0, v->shard_count * sizeof *t->blocks);
  t->block_count = 0;
  t->detachments = 0;
  for (uint32_t l = 0; l < v->link_count; ++l) {
    const uint32_t* sides = v->links[l].shards;
    t->lives[l] = sides[1] != SCREE_NO_SHARD && stands(t, sides[0]) && stands(t, sides[1]) ? 1 : 0;
  }
  frost_twin_exterior(t, t->exterior);
  frost_twin_settle(t);
  return t;
}

void frost_twin_destroy(frost_twin* t) {
  free(t->states);
  free(t->exterior);
  free(t->walked);
  free(t->lives);
  free(t->down);
  free(t->labels);
  free(t->queue);
  free(t->blocks);
  free(t);
}

/* --- 5.3: components and exterior links -------------------------------------------------------------------------------------- */

/* Labels all shards of `among` (their label there is `from`) that links of life above `least` join. */
static void label(frost_twin* t, uint32_t shard, uint32_t from, uint32_t to, double least) {
  const scree_shards_view* v = &t->like->view;
  uint32_t count = 0;
  t->labels[shard] = to;
  t->queue[count++] = shard;
  for (uint32_t head = 0; head < count; ++head)
    for (uint32_t k = 0; k < v->shards[t->queue[head]].link_count; ++k) {
      const uint32_t link = v->shard_links[v->shards[t->queue[head]].first_link + k];
      const uint32_t* sides = v->links[link].shards;
      const uint32_t other = sides[0] == t->queue[head] ? sides[1] : sides[0];
      if (other == SCREE_NO_SHARD || !(t->lives[link] > least) || t->labels[other] != from) continue;
      t->labels[other] = to;
      t->queue[count++] = other;
    }
}

/* Which air joins the outside, from nothing; then which links it has on one side and rock on the other. */
void frost_twin_exterior(frost_twin* t, uint8_t* out) {
  const scree_shards_view* v = &t->like->view;
  uint8_t* open = must(calloc(v->shard_count, 1));
  for (bool more = true; more;) {
    more = false;
    for (uint32_t l = 0; l < v->link_count; ++l) {
      const uint32_t a = v->links[l].shards[0], b = v->links[l].shards[1];
      const bool air_a = !stands(t, a), air_b = b == SCREE_NO_SHARD || !stands(t, b);
      if (!air_a || !air_b) continue;
      const bool open_b = b == SCREE_NO_SHARD || open[b] != 0;
      if ((open[a] != 0) == open_b) continue;
      open[a] = 1;
      if (b != SCREE_NO_SHARD) open[b] = 1;
      more = true;
    }
  }
  for (uint32_t l = 0; l < v->link_count; ++l) {
    const uint32_t a = v->links[l].shards[0], b = v->links[l].shards[1];
    const bool rock_a = stands(t, a), rock_b = b != SCREE_NO_SHARD && stands(t, b);
    const bool open_a = open[a] != 0, open_b = b == SCREE_NO_SHARD || open[b] != 0;
    out[l] = (rock_a && !rock_b && open_b) || (rock_b && open_a);
  }
  free(open);
}

/* The paper's way: breadth first over the links graph from the exterior links that still have rock, through links between rock and
 * air. */
static void walk_exterior(const frost_twin* t, uint8_t* out) {
  const scree_shards_view* v = &t->like->view;
  uint32_t count = 0;
  uint32_t* queue = must(malloc(v->link_count * sizeof *queue));
  for (uint32_t l = 0; l < v->link_count; ++l) {
    const uint32_t a = v->links[l].shards[0], b = v->links[l].shards[1];
    out[l] = t->exterior[l] != 0 && stands(t, a) != (b != SCREE_NO_SHARD && stands(t, b));
    if (out[l] != 0) queue[count++] = l;
  }
  for (uint32_t head = 0; head < count; ++head)
    for (uint32_t k = v->neighbour_first[queue[head]]; k < v->neighbour_first[queue[head] + 1]; ++k) {
      const uint32_t l = v->neighbours[k], a = v->links[l].shards[0], b = v->links[l].shards[1];
      if (out[l] != 0 || stands(t, a) == (b != SCREE_NO_SHARD && stands(t, b))) continue;
      out[l] = 1;
      queue[count++] = l;
    }
  free(queue);
}

static void keep_blocks(frost_twin* t, uint32_t falling) {
  const scree_shards_view* v = &t->like->view;
  for (uint32_t s = 0; s < v->shard_count; ++s) {
    if (t->labels[s] != falling) continue;
    label(t, s, falling, falling + 1, t->like->rules.fall_life);
    ++t->block_count;
    for (uint32_t i = 0; i < v->shard_count; ++i)
      if (t->labels[i] == falling + 1) {
        t->labels[i] = falling + 2; /* done */
        t->blocks[i] = t->block_count;
      }
  }
}

static void fall(frost_twin* t, uint32_t falling, bool walk) {
  const scree_shards_view* v = &t->like->view;
  if (t->like->rules.fall == SCREE_FALL_KEPT) keep_blocks(t, falling);
  for (uint32_t s = 0; s < v->shard_count; ++s)
    if (t->labels[s] == falling || t->labels[s] == falling + 2) t->states[s] = SCREE_SHARD_AIR;
  for (uint32_t l = 0; l < v->interior_link_count; ++l)
    if (!stands(t, v->links[l].shards[0]) || !stands(t, v->links[l].shards[1])) t->lives[l] = 0;
  ++t->detachments;
  if (walk) walk_exterior(t, t->walked);
  frost_twin_exterior(t, t->exterior);
  for (uint32_t l = 0; walk && l < v->link_count; ++l) t->walk_differs += t->walked[l] != t->exterior[l];
}

/* Which shards reach down to the lowest place there is. */
static void find_down(frost_twin* t) {
  const scree_shards_view* v = &t->like->view;
  double g[3], lowest = -INFINITY, highest = INFINITY;
  gravity_of(t, g);
  if (g[0] == t->down_gravity[0] && g[1] == t->down_gravity[1] && g[2] == t->down_gravity[2]) return;
  memcpy(t->down_gravity, g, sizeof t->down_gravity);
  double* low = must(malloc(v->shard_count * sizeof *low));
  for (uint32_t s = 0; s < v->shard_count; ++s) low[s] = -INFINITY;
  for (uint32_t l = 0; l < v->link_count; ++l)
    for (uint32_t p = v->links[l].first_polygon; p < v->links[l].first_polygon + v->links[l].polygon_count; ++p)
      for (uint32_t c = 0; c < v->polygons[p].corner_count; ++c) {
        const double* at = v->vertices + 3 * (size_t)v->corners[v->polygons[p].first_corner + c];
        const double along = g[0] * at[0] + g[1] * at[1] + g[2] * at[2];
        lowest = fmax(lowest, along);
        highest = fmin(highest, along);
        for (int side = 0; side < 2; ++side) {
          const uint32_t s = v->links[l].shards[side];
          if (s != SCREE_NO_SHARD) low[s] = fmax(low[s], along);
        }
      }
  for (uint32_t s = 0; s < v->shard_count; ++s) t->down[s] = lowest - low[s] <= 1e-6 * (lowest - highest);
  free(low);
}

static bool any_core(const frost_twin* t) {
  for (uint32_t s = 0; s < t->like->view.shard_count; ++s)
    if (t->states[s] == SCREE_SHARD_CORE) return true;
  return false;
}

/* Core, or what is as core: with stability and without core, what reaches down. */
static bool holds(const frost_twin* t, uint32_t shard, bool core) {
  if (core) return t->states[shard] == SCREE_SHARD_CORE;
  return t->like->rules.strength > 0 && stands(t, shard) && t->down[shard] != 0;
}

/* All connected components: the label of each shard is 1 + the lowest shard of its own, 0 = air. */
static void label_all(frost_twin* t) {
  const uint32_t count = t->like->view.shard_count;
  memset(t->labels, 0, count * sizeof *t->labels);
  for (uint32_t s = 0; s < count; ++s)
    if (t->labels[s] == 0 && stands(t, s)) label(t, s, 0, s + 1, 0);
}

static void drop(frost_twin* t, uint32_t component) {
  const uint32_t count = t->like->view.shard_count, falling = count + 1;
  for (uint32_t s = 0; s < count; ++s)
    if (t->labels[s] == component) t->labels[s] = falling;
  fall(t, falling, t->walk);
  for (uint32_t s = 0; s < count; ++s)
    if (!stands(t, s)) t->labels[s] = 0;
}

/* What of a component matters, by its label. */
typedef struct component {
  uint32_t size;
  bool holds, down;
} component;

/* Of the largest, the one with the lowest shard. */
static component* weigh_components(frost_twin* t, uint32_t* largest, bool* any_holds) {
  const uint32_t count = t->like->view.shard_count;
  component* all = must(calloc((size_t)count + 1, sizeof *all));
  const bool core = any_core(t);
  find_down(t);
  *largest = 0;
  *any_holds = false;
  for (uint32_t s = 0; s < count; ++s) {
    if (t->labels[s] == 0) continue;
    component* c = &all[t->labels[s]];
    ++c->size;
    c->holds = c->holds || holds(t, s, core);
    c->down = c->down || t->down[s] != 0;
    *any_holds = *any_holds || c->holds;
  }
  for (uint32_t i = 1; i <= count; ++i)
    if (all[i].size > all[*largest].size) *largest = i;
  return all;
}

uint32_t frost_twin_floating(frost_twin* t) {
  const uint32_t count = t->like->view.shard_count;
  uint32_t largest, floating = 0;
  bool any_holds;
  label_all(t);
  component* all = weigh_components(t, &largest, &any_holds);
  for (uint32_t i = 1; i <= count; ++i)
    if (any_holds ? !all[i].holds : !all[i].down && all[i].size < all[largest].size) floating += all[i].size;
  free(all);
  return floating;
}

/* Of components that are labelled, drops those that nothing holds. */
static void settle(frost_twin* t) {
  uint32_t largest;
  bool any_holds;
  component* all = weigh_components(t, &largest, &any_holds);
  for (uint32_t i = 1; i <= t->like->view.shard_count; ++i)
    if (all[i].size > 0 && (any_holds ? !all[i].holds : !all[i].down && i != largest)) drop(t, i);
  free(all);
}

void frost_twin_settle(frost_twin* t) {
  label_all(t);
  settle(t);
}

static void break_link(frost_twin* t, uint32_t link) {
  const scree_shards_view* v = &t->like->view;
  const uint32_t* ends = v->links[link].shards;
  t->lives[link] = 0;
  ++t->breaks;
  ++t->unchecked;
  label_all(t);
  const uint32_t labels[2] = {t->labels[ends[0]], t->labels[ends[1]]};
  if (labels[0] == labels[1]) return;
  uint32_t sizes[2] = {0}, cores[2] = {0};
  const bool core = any_core(t);
  find_down(t);
  for (uint32_t s = 0; s < v->shard_count; ++s)
    for (int i = 0; i < 2; ++i)
      if (t->labels[s] == labels[i]) {
        ++sizes[i];
        cores[i] += holds(t, s, core);
      }
  if (cores[0] > 0 && cores[1] > 0) return;
  uint32_t loser = sizes[0] < sizes[1] ? 0 : 1;
  if (cores[0] > 0) loser = 1;
  if (cores[1] > 0) loser = 0;
  drop(t, labels[loser]);
  settle(t);
}

/* --- stability --------------------------------------------------------------------------------------------------------------- */

/* Shards by how far they are from the supported ones, those first, as they are met link by link. Returns how many. */
static uint32_t line_up(const frost_twin* t, const uint8_t* supported, uint32_t* queue) {
  const scree_shards_view* v = &t->like->view;
  uint8_t* met = must(calloc(v->shard_count, 1));
  uint32_t count = 0;
  for (uint32_t s = 0; s < v->shard_count; ++s)
    if (supported[s] != 0) met[s] = 1, queue[count++] = s;
  for (uint32_t head = 0; head < count; ++head)
    for (uint32_t k = 0; k < v->shards[queue[head]].link_count; ++k) {
      const uint32_t link = v->shard_links[v->shards[queue[head]].first_link + k];
      const uint32_t* sides = v->links[link].shards;
      const uint32_t other = sides[sides[0] == queue[head]];
      if (other == SCREE_NO_SHARD || !(t->lives[link] > 0) || met[other] != 0) continue;
      met[other] = 1;
      queue[count++] = other;
    }
  free(met);
  return count;
}

/* Breaks the links that one look at everything condemns: the farthest shards' first, of one distance as they are met. Returns how
 * many groups those held. */
static uint32_t break_weak(frost_twin* t, const uint8_t* supported) {
  const scree_shards_view* v = &t->like->view;
  const scree_frost_rules* rules = &t->like->rules;
  stability_twin rule = {.view = v, .density = rules->density, .strength = rules->strength, .compression = rules->compression};
  gravity_of(t, rule.gravity);
  double* left = must(malloc(v->link_count * sizeof *left));
  uint32_t* level = must(malloc(v->shard_count * sizeof *level));
  uint32_t* queue = must(malloc(v->shard_count * sizeof *queue));
  memcpy(left, t->lives, v->link_count * sizeof *left);
  stability_twin_levels(&rule, t->lives, supported, level);
  const uint32_t count = line_up(t, supported, queue), groups = stability_twin_weigh(&rule, supported, left);
  for (uint32_t d = v->shard_count; groups > 0 && d > 0; --d)
    for (uint32_t i = 0; i < count; ++i) {
      const scree_shard* shard = &v->shards[queue[i]];
      if (level[queue[i]] != d) continue;
      for (uint32_t k = 0; k < shard->link_count; ++k) {
        const uint32_t link = v->shard_links[shard->first_link + k];
        const uint32_t* sides = v->links[link].shards;
        const uint32_t other = sides[sides[0] == queue[i]];
        const bool condemned = other != SCREE_NO_SHARD && level[other] == d - 1 && left[link] == 0;
        if (!condemned || !(t->lives[link] > 0)) continue;
        break_link(t, link);
        ++t->overloaded;
      }
    }
  free(left);
  free(level);
  free(queue);
  return groups;
}

void frost_twin_check(frost_twin* t) {
  const uint32_t count = t->like->view.shard_count;
  uint8_t* supported = must(malloc(count));
  uint32_t groups = t->like->rules.strength > 0;
  while (groups > 0) {
    const bool core = any_core(t);
    find_down(t);
    for (uint32_t s = 0; s < count; ++s) supported[s] = holds(t, s, core);
    groups = break_weak(t, supported);
  }
  free(supported);
  t->unchecked = 0;
}

/* --- edits ------------------------------------------------------------------------------------------------------------------- */

static void take_shard(frost_twin* t, uint32_t shard) {
  const scree_shards_view* v = &t->like->view;
  const scree_shard* s = &v->shards[shard];
  bool* linked = must(calloc(v->shard_count, sizeof *linked));
  for (uint32_t k = 0; k < s->link_count; ++k) {
    const uint32_t l = v->shard_links[s->first_link + k];
    if (t->lives[l] > 0) linked[v->links[l].shards[v->links[l].shards[0] == shard]] = true;
    t->lives[l] = 0;
  }
  t->states[shard] = SCREE_SHARD_AIR;
  frost_twin_exterior(t, t->exterior);
  label_all(t);
  uint32_t largest;
  bool any_holds;
  component* all = weigh_components(t, &largest, &any_holds);
  any_holds = false; /* among the parts that it leaves */
  largest = 0;
  for (uint32_t i = 0; i < v->shard_count; ++i)
    if (linked[i]) {
      const component* c = &all[t->labels[i]];
      any_holds = any_holds || c->holds;
      if (c->size > all[largest].size || (c->size == all[largest].size && t->labels[i] < largest)) largest = t->labels[i];
    }
  for (uint32_t k = 0; k < s->link_count; ++k) { /* blocks are numbered in the order of links */
    const uint32_t* sides = v->links[v->shard_links[s->first_link + k]].shards;
    const uint32_t other = sides[sides[0] == shard];
    if (other == SCREE_NO_SHARD || !linked[other] || !stands(t, other)) continue;
    if (any_holds ? !all[t->labels[other]].holds : t->labels[other] != largest) drop(t, t->labels[other]);
  }
  free(all);
  free(linked);
}

/* Out of its block; a block that it was alone in is no more. */
static void stand_again(frost_twin* t, uint32_t shard) {
  const scree_shards_view* v = &t->like->view;
  const uint32_t block = t->blocks[shard];
  t->blocks[shard] = 0;
  bool alone = block != 0;
  for (uint32_t s = 0; s < v->shard_count; ++s) alone = alone && t->blocks[s] != block;
  for (uint32_t s = 0; s < v->shard_count; ++s) t->blocks[s] -= alone && t->blocks[s] > block;
  t->block_count -= alone;
  for (uint32_t l = 0; l < v->interior_link_count; ++l) {
    const uint32_t* sides = v->links[l].shards;
    if ((sides[0] == shard || sides[1] == shard) && stands(t, sides[0]) && stands(t, sides[1])) t->lives[l] = 1;
  }
  frost_twin_exterior(t, t->exterior);
}

void frost_twin_set_shard(frost_twin* t, uint32_t shard, scree_shard_state state) {
  const bool stood = stands(t, shard);
  if (state == SCREE_SHARD_AIR) {
    if (stood) take_shard(t, shard);
  } else {
    t->states[shard] = (uint8_t)state;
    if (!stood) stand_again(t, shard);
  }
  frost_twin_settle(t);
}

void frost_twin_set_life(frost_twin* t, uint32_t link, double life) {
  if (life > 0)
    t->lives[link] = life;
  else if (t->lives[link] > 0)
    break_link(t, link);
  frost_twin_settle(t);
}

/* --- 5.1: where water goes --------------------------------------------------------------------------------------------------- */

/* normal . direction, the normal out of the rock of an exterior link. */
static double facing(const frost_twin* t, const scree_link* link, const double direction[3]) {
  const double sign = stands(t, link->shards[0]) ? 1 : -1;
  double sum = 0;
  for (int a = 0; a < 3; ++a) sum += link->normal[a] * direction[a];
  return sign * sum;
}

/* What a link is proposed by, before a direction is known: its area and the best cosine that the cone of the rain has for it, that
 * of the angle to the axis less the spread; 1e-12 more than the error of cosines. */
static uint64_t weight(const frost_twin* t, const frost_rain* rain, const scree_link* link) {
  const double cosine = facing(t, link, rain->axis), sine2 = 1 - cosine * cosine, sine = sqrt(sine2 > 0 ? sine2 : 0);
  const double best = cosine < rain->cosine ? cosine * rain->cosine + sine * rain->sine : 1;
  return best + 1e-12 > 2e-12 ? (uint64_t)ceil(t->scale * link->area * (best + 1e-12)) : 0;
}

/* area * max(normal . rain, 0). */
static double share(const frost_twin* t, const scree_link* link, const double direction[3]) {
  const double cosine = facing(t, link, direction);
  return cosine > 0 ? t->scale * link->area * cosine : 0;
}

static uint64_t total_weight(const frost_twin* t, const frost_rain* rain) {
  const scree_shards_view* v = &t->like->view;
  uint64_t total = 0;
  for (uint32_t l = 0; l < v->link_count; ++l)
    if (t->exterior[l] != 0) total += weight(t, rain, &v->links[l]);
  return total;
}

static bool draw_start(frost_twin* t, uint32_t* out) {
  const scree_shards_view* v = &t->like->view;
  uint64_t totals[SCREE_FROST_RAINS];
  double sum = 0;
  uint32_t wet = 0, chosen = 0;
  for (uint32_t r = 0; r < t->like->rules.rain_count; ++r) {
    totals[r] = total_weight(t, &t->like->tables.rains[r]);
    if (totals[r] == 0) continue;
    sum += t->like->rules.rains[r].weight;
    chosen = r;
    ++wet;
  }
  if (wet == 0) return false;
  for (int sky = 0; sky < FROST_SKIES; ++sky) {
    uint32_t r = chosen;
    if (wet > 1) {
      double left = random_unit(&t->stream) * sum;
      for (r = 0; r < t->like->rules.rain_count; ++r) {
        if (totals[r] == 0) continue;
        left -= t->like->rules.rains[r].weight;
        if (left < 0) break;
      }
      if (r == t->like->rules.rain_count) r = chosen;
    }
    const frost_rain* rain = &t->like->tables.rains[r];
    double direction[3];
    frost_draw_direction(rain, &t->stream, direction);
    for (int i = 0; i < FROST_PROPOSALS; ++i) {
      uint64_t place = frost_draw_below(&t->stream, totals[r]);
      for (uint32_t l = 0; l < v->link_count; ++l) {
        const uint64_t here = t->exterior[l] != 0 ? weight(t, rain, &v->links[l]) : 0;
        if (place >= here) {
          place -= here;
          continue;
        }
        if (random_unit(&t->stream) * (double)here < share(t, &v->links[l], direction)) {
          *out = l;
          return true;
        }
        break;
      }
    }
    uint64_t total = 0;
    for (uint32_t l = 0; l < v->link_count; ++l)
      if (t->exterior[l] != 0) total += (uint64_t)share(t, &v->links[l], direction);
    if (total == 0) continue;
    uint64_t place = frost_draw_below(&t->stream, total);
    for (uint32_t l = 0; l < v->link_count; ++l) {
      if (t->exterior[l] == 0) continue;
      const uint64_t here = (uint64_t)share(t, &v->links[l], direction);
      if (place < here) {
        *out = l;
        return true;
      }
      place -= here;
    }
  }
  return false;
}

static double f_r(const frost_twin* t, uint32_t link) {
  return t->lives[link] * t->like->tables.resistance[link];
}

static double f_g(const frost_twin* t, uint32_t from, uint32_t to) {
  const double *g = t->gravity, *x = t->like->view.links[from].centroid, *y = t->like->view.links[to].centroid;
  const double down = (g[0] * y[0] + g[1] * y[1] + g[2] * y[2]) - (g[0] * x[0] + g[1] * x[1] + g[2] * x[2]);
  const double d[3] = {y[0] - x[0], y[1] - x[1], y[2] - x[2]};
  return down > 0 ? down / sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) : 0;
}

/* p_flow, but for the factor that makes them sum to 1. Links that have no rock are gone with it. */
static double flow(const frost_twin* t, uint32_t from, uint32_t to) {
  const uint32_t* sides = t->like->view.links[to].shards;
  if (!stands(t, sides[0]) && (sides[1] == SCREE_NO_SHARD || !stands(t, sides[1]))) return 0;
  return f_g(t, from, to) * (1 - f_r(t, to));
}

static bool draw_way(frost_twin* t, uint32_t* link) {
  const scree_shards_view* v = &t->like->view;
  const uint32_t from = *link;
  double sum = 0;
  for (uint32_t k = v->neighbour_first[from]; k < v->neighbour_first[from + 1]; ++k) sum += flow(t, from, v->neighbours[k]);
  if (!(sum > 0)) return false;
  double left = random_unit(&t->stream) * sum;
  for (uint32_t k = v->neighbour_first[from]; k < v->neighbour_first[from + 1]; ++k) {
    const double here = flow(t, from, v->neighbours[k]);
    if (here == 0) continue;
    *link = v->neighbours[k];
    if (left < here) return true;
    left -= here;
  }
  return true;
}

/* --- 5.2: absorption and erosion --------------------------------------------------------------------------------------------- */

static double w_abs(const frost_twin* t, uint32_t link) {
  const scree_frost_rules* rules = &t->like->rules;
  const double a = t->like->view.links[link].area, mean = t->mean_area;
  const double k_solid = rules->solid_absorption / mean, k_air = rules->air_absorption / mean;
  return t->lives[link] > 0 ? a * k_solid + f_r(t, link) * rules->resistance_absorption : a * k_air;
}

bool frost_twin_path(frost_twin* t, bool walk) {
  t->walk = walk;
  gravity_of(t, t->gravity);
  const scree_frost_rules* rules = &t->like->rules;
  const double k_dmg = rules->damage * t->mean_area;
  uint32_t link;
  if (!draw_start(t, &link)) return false;
  double water = rules->water;
  ++t->paths;
  t->poured += water;
  for (;;) {
    ++t->visited;
    double taken = w_abs(t, link);
    taken = taken < water ? taken : water;
    if (t->lives[link] > 0) {
      const double life = t->lives[link] - k_dmg * taken / t->like->view.links[link].area;
      if (!(life > 0)) {
        break_link(t, link);
      } else if (life < rules->break_life && random_unit(&t->stream) < rules->break_chance * (1 - life / rules->break_life)) {
        ++t->forced;
        break_link(t, link);
      } else {
        t->lives[link] = life;
      }
    }
    water -= taken;
    t->absorbed += taken;
    if (water > 0 && rules->total_absorption && random_unit(&t->stream) < 1 - water / rules->water) {
      t->absorbed += water;
      water = 0;
    }
    if (!(water > 0) || !draw_way(t, &link)) break;
  }
  t->drained += water;
  if (t->unchecked >= rules->stability_interval) frost_twin_check(t);
  return true;
}
