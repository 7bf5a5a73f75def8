/* What falls when a link breaks. The paper finds the connected components of all shards at each breakage; here two searches go out
 * from both ends by turns and stop as soon as the answer is known, which in a Voronoi diagram is after two or three shards. The
 * result is the components': of two parts that no unbroken link joins, the one without core shards falls where the other has some;
 * where neither has, the one of fewer shards, and of equal ones that of the link's second shard; where both have, none. With
 * stability, and as long as nothing is core, shards that rest on the lowest place are as core ones: frost_holds. */
#include <string.h>

#include "frost_internal.h"

/* --- what fell --------------------------------------------------------------------------------------------------------------- */

/* Heap sort: in place, and the same everywhere. */
static void sift(uint32_t* list, uint32_t from, uint32_t count) {
  const uint32_t value = list[from];
  for (;;) {
    uint32_t child = 2 * from + 1;
    if (child >= count) break;
    if (child + 1 < count && list[child + 1] > list[child]) ++child;
    if (list[child] <= value) break;
    list[from] = list[child];
    from = child;
  }
  list[from] = value;
}

static void sort(uint32_t* list, uint32_t count) {
  for (uint32_t i = count / 2; i-- > 0;) sift(list, i, count);
  while (count > 1) {
    --count;
    const uint32_t last = list[count];
    list[count] = list[0];
    list[0] = last;
    sift(list, 0, count);
  }
}

/* Where a block was and where it was pushed. */
static void measure_block(const scree_frost* f, scree_block* block, const double push[3]) {
  block->volume = 0;
  for (int a = 0; a < 3; ++a) block->centroid[a] = 0;
  for (uint32_t i = 0; i < block->shard_count; ++i) {
    const scree_shard* s = &f->view.shards[f->block_shards[block->first_shard + i]];
    block->volume += s->volume;
    for (int a = 0; a < 3; ++a) block->centroid[a] += s->volume * s->centroid[a];
  }
  for (int a = 0; a < 3; ++a)
    block->centroid[a] =
        block->volume > 0 ? block->centroid[a] / block->volume : f->view.shards[f->block_shards[block->first_shard]].centroid[a];
  const double length = sqrt(push[0] * push[0] + push[1] * push[1] + push[2] * push[2]);
  for (int a = 0; a < 3; ++a) block->push[a] = length > 0 ? push[a] / length : 0;
}

/* The shards that hang together with `from` by links of life above fall_life, marked `group`, as one more block. */
static void add_block(scree_frost* f, uint32_t from, uint32_t group) {
  const scree_shards_view* v = &f->view;
  scree_block* block = &f->blocks[f->stats.blocks++];
  *block = (scree_block){.first_shard = f->block_shard_count, .path = f->stats.paths};
  uint32_t* list = f->block_shards + block->first_shard;
  double push[3] = {0};
  list[block->shard_count++] = from;
  f->marks[from] = group + 1;
  for (uint32_t head = 0; head < block->shard_count; ++head) {
    const scree_shard* s = &v->shards[list[head]];
    for (uint32_t k = 0; k < s->link_count; ++k) {
      const uint32_t at = v->shard_links[s->first_link + k];
      const scree_link* link = &v->links[at];
      const uint32_t other = frost_across(link, list[head]);
      if (other == SCREE_NO_SHARD || !frost_stands(f, other)) continue;
      if (f->marks[other] != group && f->marks[other] != group + 1) { /* rock that stays */
        const double sign = link->shards[1] == list[head] ? link->area : -link->area;
        for (int a = 0; a < 3; ++a) push[a] += sign * link->normal[a];
      } else if (f->marks[other] == group && f->lives[at] > f->rules.fall_life) {
        f->marks[other] = group + 1;
        list[block->shard_count++] = other;
      }
    }
  }
  f->block_shard_count += block->shard_count;
  sort(list, block->shard_count);
  measure_block(f, block, push);
}

static void become_air(scree_frost* f, uint32_t shard) {
  const scree_shard* s = &f->view.shards[shard];
  if (f->states[shard] == SCREE_SHARD_CORE)
    --f->stats.core;
  else
    --f->stats.solid;
  ++f->stats.air;
  f->stats.volume -= s->volume;
  f->states[shard] = SCREE_SHARD_AIR;
  for (uint32_t k = 0; k < s->link_count; ++k) f->lives[f->view.shard_links[s->first_link + k]] = 0;
}

static void fall(scree_frost* f, uint32_t* list, uint32_t count) {
  sort(list, count);
  if (f->rules.fall == SCREE_FALL_KEPT) {
    const uint32_t group = frost_new_marks(f);
    for (uint32_t i = 0; i < count; ++i) f->marks[list[i]] = group;
    for (uint32_t i = 0; i < count; ++i)
      if (f->marks[list[i]] == group) add_block(f, list[i], group);
  }
  for (uint32_t i = 0; i < count; ++i) become_air(f, list[i]);
  ++f->stats.detachments;
  frost_update_exterior(f, list, count);
}

void frost_unblock(scree_frost* f, uint32_t shard) {
  for (uint32_t b = 0; b < f->stats.blocks; ++b) {
    scree_block* block = &f->blocks[b];
    for (uint32_t i = 0; i < block->shard_count; ++i) {
      const uint32_t at = block->first_shard + i;
      if (f->block_shards[at] != shard) continue;
      --f->block_shard_count;
      memmove(f->block_shards + at, f->block_shards + at + 1, (f->block_shard_count - at) * sizeof *f->block_shards);
      for (uint32_t later = b + 1; later < f->stats.blocks; ++later) --f->blocks[later].first_shard;
      if (--block->shard_count > 0) {
        const double push[3] = {block->push[0], block->push[1], block->push[2]};
        measure_block(f, block, push);
      } else {
        --f->stats.blocks;
        memmove(block, block + 1, (f->stats.blocks - b) * sizeof *block);
      }
      return;
    }
  }
}

/* --- what hangs together ----------------------------------------------------------------------------------------------------- */

/* A search that goes out from one shard over unbroken links. */
typedef struct search {
  uint32_t* queue;
  uint32_t head, count, mark;
  bool core; /* it has a shard that holds */
} search;

static search begin(scree_frost* f, uint32_t* queue, uint32_t shard, uint32_t mark) {
  queue[0] = shard;
  f->marks[shard] = mark;
  return (search){queue, 0, 1, mark, frost_holds(f, shard)};
}

static bool done(const search* s) {
  return s->head == s->count;
}

/* Looks at the links of one more shard. True when one leads to a shard of the other search. */
static bool advance(scree_frost* f, search* s, uint32_t others) {
  const uint32_t shard = s->queue[s->head++];
  const uint32_t* links = f->view.shard_links + f->view.shards[shard].first_link;
  const uint32_t count = f->view.shards[shard].link_count;
  for (uint32_t k = 0; k < count; ++k) {
    if (!(f->lives[links[k]] > 0)) continue;
    const uint32_t other = frost_across(&f->view.links[links[k]], shard);
    if (f->marks[other] == others) return true;
    if (f->marks[other] == s->mark) continue;
    f->marks[other] = s->mark;
    s->queue[s->count++] = other;
    s->core = s->core || frost_holds(f, other);
  }
  return false;
}

/* Of a search that is done, and one that may not be, not both with core: 1 when the first falls, -1 when the second does, 0 when it
 * is not known yet. wins_tie: the first stays where both are as large. */
static int who_falls(const search* whole, const search* other, bool wins_tie) {
  if (whole->core) return done(other) ? -1 : 0;
  if (other->core || other->count > whole->count) return 1;
  if (other->count == whole->count && !wins_tie) return 1;
  return done(other) ? -1 : 0;
}

static void detach(scree_frost* f, uint32_t first, uint32_t second) {
  const uint32_t mark = frost_new_marks(f);
  search a = begin(f, f->queues[0], first, mark), b = begin(f, f->queues[1], second, mark + 1);
  for (bool turn = false; !(a.core && b.core); turn = !turn) {
    const int falls = done(&a) ? who_falls(&a, &b, true) : done(&b) ? -who_falls(&b, &a, false) : 0;
    if (falls == 1) fall(f, a.queue, a.count);
    if (falls == -1) fall(f, b.queue, b.count);
    if (falls != 0 && f->apart) frost_settle(f);
    if (falls != 0) return;
    const bool of_b = done(&a) || (turn && !done(&b));
    if (of_b ? advance(f, &b, a.mark) : advance(f, &a, b.mark)) return;
  }
}

void frost_break_link(scree_frost* f, uint32_t at) {
  if (!(f->lives[at] > 0)) return;
  f->lives[at] = 0;
  f->passage[at] = 1;
  ++f->stats.breaks;
  ++f->unchecked;
  detach(f, f->view.links[at].shards[0], f->view.links[at].shards[1]);
}

/* A shard may hold many parts together: all of them are searched, the largest or those with core stay. */
void frost_take_shard(scree_frost* f, uint32_t shard) {
  const scree_shard* s = &f->view.shards[shard];
  const uint32_t mark = frost_new_marks(f);
  uint32_t parts = 0, total = 0, largest = 0, largest_count = 0, largest_lowest = 0;
  bool any_core = false;
  f->marks[shard] = mark;
  if (f->states[shard] == SCREE_SHARD_CORE) { /* what holds is to be told by what is left */
    f->states[shard] = SCREE_SHARD_SOLID;
    --f->stats.core;
    ++f->stats.solid;
  }
  uint32_t* queue = f->queues[0]; /* part after part: those that may fall start where `starts` says */
  uint32_t* starts = f->queues[1];
  for (uint32_t k = 0; k < s->link_count; ++k) {
    const uint32_t at = f->view.shard_links[s->first_link + k];
    if (!(f->lives[at] > 0)) continue;
    const uint32_t other = frost_across(&f->view.links[at], shard);
    if (f->marks[other] == mark) continue;
    search part = begin(f, queue + total, other, mark);
    while (!done(&part)) advance(f, &part, mark + 1);
    uint32_t lowest = UINT32_MAX;
    for (uint32_t i = 0; i < part.count; ++i) lowest = part.queue[i] < lowest ? part.queue[i] : lowest;
    any_core = any_core || part.core;
    if (part.count > largest_count || (part.count == largest_count && lowest < largest_lowest)) {
      largest = parts;
      largest_count = part.count;
      largest_lowest = lowest;
    }
    starts[parts++] = total;
    total += part.count;
  }
  become_air(f, shard);
  frost_update_exterior(f, &shard, 1);
  for (uint32_t p = 0; p < parts; ++p) {
    const uint32_t end = p + 1 < parts ? starts[p + 1] : total;
    bool core = false;
    for (uint32_t i = starts[p]; i < end; ++i) core = core || frost_holds(f, queue[i]);
    if (any_core ? !core : p != largest) fall(f, queue + starts[p], end - starts[p]);
  }
}

void frost_settle(scree_frost* f) {
  const uint32_t mark = frost_new_marks(f);
  uint32_t* queue = f->queues[0]; /* component after component, by their lowest shards; they start where `starts` says */
  uint32_t* starts = f->queues[1];
  uint32_t parts = 0, total = 0, largest = 0, largest_count = 0;
  bool any_holds = false;
  for (uint32_t s = 0; s < f->view.shard_count; ++s) {
    if (!frost_stands(f, s) || f->marks[s] == mark) continue;
    search part = begin(f, queue + total, s, mark);
    while (!done(&part)) advance(f, &part, mark + 1);
    any_holds = any_holds || part.core;
    if (part.count > largest_count) {
      largest = parts;
      largest_count = part.count;
    }
    starts[parts++] = total;
    total += part.count;
  }
  uint32_t left = parts;
  for (uint32_t p = 0; p < parts && parts > 1; ++p) {
    const uint32_t end = p + 1 < parts ? starts[p + 1] : total;
    bool stays = !any_holds && p == largest;
    for (uint32_t i = starts[p]; i < end && !stays; ++i) stays = any_holds ? frost_holds(f, queue[i]) : f->rests[queue[i]] != 0;
    if (stays) continue;
    fall(f, queue + starts[p], end - starts[p]);
    --left;
  }
  f->apart = left > 1 && !any_holds;
  f->unsettled = false;
}
