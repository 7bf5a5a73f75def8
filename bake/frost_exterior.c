/* Which links rain can reach. Mateos et al. walk the links graph from the exterior links that are left; here air knows whether it
 * joins the outside through faces, which is the same wherever three shards meet at an edge, and does not depend on the order in
 * which shards fell. Air only grows between edits, so that each shard is opened once. */
#include <string.h>

#include "frost_draw.h"

static void set_weight(scree_frost* f, uint32_t rain, uint32_t link, uint64_t weight) {
  const size_t count = f->view.link_count;
  uint64_t* at = &f->tables.weights[rain * count + link];
  const uint64_t change = weight - *at; /* modulo 2^64 */
  if (change == 0) return;
  *at = weight;
  f->tables.totals[rain] += change;
  uint64_t* tree = f->tables.trees + rain * (count + 1);
  for (size_t i = (size_t)link + 1; i <= count; i += i & (~i + 1)) tree[i] += change;
}

static bool has_rock(const scree_frost* f, const scree_link* link) {
  return frost_stands(f, link->shards[0]) || (link->shards[1] != SCREE_NO_SHARD && frost_stands(f, link->shards[1]));
}

static bool is_exterior(const scree_frost* f, const scree_link* link) {
  const bool first = frost_stands(f, link->shards[0]);
  if (link->shards[1] == SCREE_NO_SHARD) return first;
  if (first == frost_stands(f, link->shards[1])) return false;
  return f->open[link->shards[first ? 1 : 0]] != 0;
}

static uint64_t weight_of(const scree_frost* f, uint32_t rain, uint32_t at) {
  const scree_link* link = &f->view.links[at];
  if (f->exterior[at] == 0) return 0;
  return frost_weight(&f->tables.rains[rain], link, frost_stands(f, link->shards[0]), f->weight_scale);
}

static void refresh(scree_frost* f, uint32_t at) {
  const scree_link* link = &f->view.links[at];
  f->exterior[at] = is_exterior(f, link);
  f->passage[at] = has_rock(f, link) ? 1 - f->lives[at] * f->tables.resistance[at] : 0;
  for (uint32_t r = 0; r < f->rules.rain_count; ++r) set_weight(f, r, at, weight_of(f, r, at));
}

static bool touches_outside(const scree_frost* f, uint32_t shard) {
  const scree_shard* s = &f->view.shards[shard];
  for (uint32_t k = 0; k < s->link_count; ++k) {
    const uint32_t other = frost_across(&f->view.links[f->view.shard_links[s->first_link + k]], shard);
    if (other == SCREE_NO_SHARD || f->open[other] != 0) return true;
  }
  return false;
}

/* Opens a shard of air and all closed air behind it; links: brings those of each up to date, too. */
static void open_from(scree_frost* f, uint32_t shard, bool links) {
  uint32_t* queue = f->queues[2];
  uint32_t count = 0;
  f->open[shard] = 1;
  queue[count++] = shard;
  for (uint32_t head = 0; head < count; ++head) {
    const scree_shard* s = &f->view.shards[queue[head]];
    for (uint32_t k = 0; k < s->link_count; ++k) {
      const uint32_t link = f->view.shard_links[s->first_link + k];
      const uint32_t other = frost_across(&f->view.links[link], queue[head]);
      if (links) refresh(f, link);
      if (other == SCREE_NO_SHARD || frost_stands(f, other) || f->open[other] != 0) continue;
      f->open[other] = 1;
      queue[count++] = other;
    }
  }
}

void frost_update_exterior(scree_frost* f, const uint32_t* shards, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i)
    if (f->open[shards[i]] == 0 && touches_outside(f, shards[i])) open_from(f, shards[i], true);
  for (uint32_t i = 0; i < count; ++i) {
    if (f->open[shards[i]] != 0) continue; /* its links are done */
    const scree_shard* s = &f->view.shards[shards[i]];
    for (uint32_t k = 0; k < s->link_count; ++k) refresh(f, f->view.shard_links[s->first_link + k]);
  }
}

void frost_derive(scree_frost* f) {
  const scree_shards_view* v = &f->view;
  const size_t count = v->link_count;
  memset(f->open, 0, v->shard_count);
  for (uint32_t s = 0; s < v->shard_count; ++s)
    if (!frost_stands(f, s) && f->open[s] == 0 && touches_outside(f, s)) open_from(f, s, false);
  for (uint32_t l = 0; l < v->link_count; ++l) {
    f->exterior[l] = is_exterior(f, &v->links[l]);
    f->passage[l] = has_rock(f, &v->links[l]) ? 1 - f->lives[l] * f->tables.resistance[l] : 0;
  }
  for (uint32_t r = 0; r < f->rules.rain_count; ++r) {
    uint64_t* weights = f->tables.weights + r * count;
    uint64_t* tree = f->tables.trees + r * (count + 1);
    f->tables.totals[r] = 0;
    memset(tree, 0, (count + 1) * sizeof *tree);
    for (uint32_t l = 0; l < v->link_count; ++l) {
      weights[l] = weight_of(f, r, l);
      f->tables.totals[r] += weights[l];
      tree[l + 1] += weights[l];
      const size_t above = (size_t)l + 1 + ((l + 1) & (~(size_t)l));
      if (above <= count) tree[above] += tree[l + 1];
    }
  }
}
