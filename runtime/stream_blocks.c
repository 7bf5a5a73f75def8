/* What nodes show: blocks, and their places in the array of instances. */
#include <math.h>
#include <string.h>

#include "stream_internal.h"

/* --- slots ------------------------------------------------------------------------------------------------------------------ */

static uint32_t take_slot(scree_stream* s) {
  uint32_t slot = s->free_block;
  if (slot != STREAM_NONE) {
    s->free_block = s->blocks[slot].next;
    --s->blocks_free;
  } else {
    if (s->blocks_used == s->desc.caps.blocks) return STREAM_NONE;
    slot = s->blocks_used++;
  }
  memset(&s->blocks[slot], 0, sizeof s->blocks[slot]);
  s->blocks[slot].waiting_at = s->blocks[slot].fading_at = STREAM_NONE;
  return slot;
}

static void give_slot(scree_stream* s, uint32_t slot) {
  s->blocks[slot].unused = true;
  s->blocks[slot].shown = false;
  s->blocks[slot].next = s->free_block;
  s->free_block = slot;
  ++s->blocks_free;
}

static void give_all(scree_stream* s, uint32_t slot) {
  scree_rt_ranges_give(&s->ranges, s->blocks[slot].first, s->blocks[slot].count);
  give_slot(s, slot);
}

/* --- taking in -------------------------------------------------------------------------------------------------------------- */

/* What instances say for their block: one that is going to be replaced keeps its slot. */
static uint32_t label_of(const stream_node* node, uint32_t slot) {
  return node->shown && node->block != STREAM_NONE ? node->block : slot;
}

void scree_rt_stream_keep_place(scree_stream* s, stream_build* build) {
  const stream_node* node = &s->nodes[build->node];
  const scree_stream_caps* caps = &s->desc.caps;
  uint32_t places = s->usual[node->level > 0];
  build->place = 0;
  build->slot = STREAM_NONE;
  bool plenty = s->ranges.free_units > s->ranges.units / 4 + places / s->ranges.unit &&
                s->blocks_used - s->blocks_free < caps->blocks - caps->blocks / 4;
  if (places == 0 || !plenty || !scree_rt_ranges_take(&s->ranges, places, &build->first)) return;
  build->place = places;
  build->slot = take_slot(s);
  build->label = label_of(node, build->slot);
}

static void leave_place(scree_stream* s, stream_build* build) {
  if (build->place == 0) return;
  scree_rt_ranges_give(&s->ranges, build->first, build->place);
  give_slot(s, build->slot);
  build->place = 0;
}

/* The block that a build's instances become, with its place; STREAM_NONE when there is no room. Few instances move to a place of
 * their size: the rest of what was kept would be too short for most blocks, and the array would be full while much of it is free.
 */
static uint32_t take_place(scree_stream* s, stream_build* build) {
  if (build->placed && build->count >= build->place / 2) {
    scree_rt_ranges_trim(&s->ranges, build->first, build->place, build->count);
    build->place = 0;
    s->blocks[build->slot].first = build->first;
    return build->slot;
  }
  build->placed = false;
  leave_place(s, build);
  uint32_t slot = take_slot(s);
  if (slot != STREAM_NONE && scree_rt_ranges_take(&s->ranges, build->count, &s->blocks[slot].first)) return slot;
  if (slot != STREAM_NONE) give_slot(s, slot);
  return STREAM_NONE;
}

static void fill_block(scree_stream* s, uint32_t slot, const stream_build* build) {
  stream_block* b = &s->blocks[slot];
  const stream_node* node = &s->nodes[build->node];
  memcpy(b->origin, build->origin, sizeof b->origin);
  memcpy(b->min, build->min, sizeof b->min);
  memcpy(b->max, build->max, sizeof b->max);
  b->count = build->count;
  b->node = build->node;
  b->layer = node->layer;
  b->pack = (uint16_t)s->layers[node->layer].pack;
  b->level = node->level;
  b->cell = s->layers[node->layer].cell;
  b->largest = s->layers[node->layer].largest;
  b->run_count = 0;
  for (uint32_t class = 0; class < STREAM_CLASSES; ++class) {
    uint32_t first = build->class_first[class], count = build->class_first[class + 1] - first;
    if (count == 0) continue;
    b->run_class[b->run_count] = (uint8_t) class;
    memcpy(b->triangles[b->run_count], build->triangles[class], sizeof b->triangles[0]);
    b->runs[b->run_count++] = (scree_stream_run){.first = b->first + first, .count = count, .from_level = 255};
  }
  scree_stream_instance* to = s->instances + b->first;
  uint32_t label = label_of(node, slot);
  if (!build->placed) {
    memmove(to, build->instances, build->count * sizeof *to);
    memmove(s->ids + b->first, build->ids, build->count * sizeof *s->ids);
  }
  if (!build->placed || build->label != label)
    for (uint32_t i = 0; i < build->count; ++i) to[i].block = label;
}

static uint32_t run_count(const stream_build* build) {
  uint32_t runs = 0;
  for (uint32_t class = 0; class < STREAM_CLASSES; ++class) runs += build->class_first[class + 1] > build->class_first[class];
  return runs;
}

/* Whether a build found what its node shows already. */
static bool is_same(const scree_stream* s, const stream_node* node, const stream_build* build) {
  if (!node->shown || node->block == STREAM_NONE) return false;
  const stream_block* b = &s->blocks[node->block];
  if (b->count != build->count) return false;
  for (uint32_t i = 0; i < b->count; ++i) {
    const scree_stream_instance *is = &s->instances[b->first + i], *was = &build->instances[i];
    if (memcmp(is->position, was->position, sizeof is->position) != 0 || is->asset != was->asset || is->random != was->random)
      return false;
  }
  return memcmp(s->ids + b->first, build->ids, b->count * sizeof *s->ids) == 0;
}

static void refuse(scree_stream* s, stream_node* node) {
  if (!node->refused) ++s->refused;
  node->refused = true;
}

static void take_answer(scree_stream* s, stream_build* build) {
  stream_node* node = &s->nodes[build->node];
  if (node->generation != build->generation) return; /* it is gone */
  node->building = false;
  if (node->touched > build->touch || build->result == SCREE_ERROR_OUT_OF_MEMORY) return; /* to be built once more */
  scree_rt_stream_drop_fresh(s, node);
  if (node->refused) --s->refused;
  node->refused = false;
  if (build->result != SCREE_OK || build->count == 0) {
    node->ready = true;
    return;
  }
  if (is_same(s, node, build)) {
    node->stale = false;
    return;
  }
  const scree_stream_caps* caps = &s->desc.caps;
  uint64_t bytes = build->count * sizeof(scree_stream_instance) + run_count(build) * sizeof(scree_stream_run);
  if (build->count > s->ranges.units * s->ranges.unit || bytes > caps->upload_bytes) {
    refuse(s, node);
    node->ready = true;
    return;
  }
  uint32_t slot = take_place(s, build);
  if (slot == STREAM_NONE) {
    s->short_of_room = true;
    return;
  }
  fill_block(s, slot, build);
  node->fresh = slot;
  node->ready = true;
}

/* Moves up seven steps for each count above and down a step for all others: seven in eight are below in the end. */
static void learn(uint32_t* usual, uint32_t count) {
  uint32_t step = *usual / 128 + 1;
  if (*usual == 0)
    *usual = count;
  else if (count > *usual)
    *usual += 7 * step;
  else if (*usual > step)
    *usual -= step;
}

void scree_rt_stream_take_build(scree_stream* s, stream_build* build) {
  if (build->result == SCREE_OK && build->count > 0) learn(&s->usual[build->level > 0], build->count);
  take_answer(s, build);
  leave_place(s, build);
}

void scree_rt_stream_drop_fresh(scree_stream* s, stream_node* node) {
  if (node->fresh != STREAM_NONE) give_all(s, node->fresh);
  node->fresh = STREAM_NONE;
  node->ready = false;
}

/* --- events ----------------------------------------------------------------------------------------------------------------- */

scree_event* scree_rt_stream_send_block(scree_stream* s, scree_event_kind kind, uint32_t block, uint64_t bytes) {
  stream_block* b = &s->blocks[block];
  const stream_pack* pack = &s->packs[b->pack];
  scree_event* event = scree_rt_stream_send(s, kind, bytes);
  scree_event_block* e = &event->block;
  e->block = block;
  e->layer = b->layer;
  e->level = b->level;
  memcpy(e->origin, b->origin, sizeof e->origin);
  e->scale = b->level == 0 ? b->cell * pack->lattice[0] : b->cell * (float)(1u << (b->level - 1)) * pack->lattice[1];
  memcpy(e->min, b->min, sizeof e->min);
  memcpy(e->max, b->max, sizeof e->max);
  e->first_instance = b->first;
  e->instance_count = b->count;
  e->fade_start = b->fade_start;
  e->leaving = b->leaving;
  if (kind != SCREE_EVENT_BLOCK_OUT) {
    e->runs = b->runs;
    e->run_count = b->run_count;
  }
  b->sent = s->update;
  return event;
}

static void send_instances(scree_stream* s, scree_event_kind kind, uint32_t block) {
  const stream_block* b = &s->blocks[block];
  scree_event* event = scree_rt_stream_send_block(s, kind, block, b->count * sizeof(scree_stream_instance) + stream_run_bytes(b));
  event->block.instances = s->instances + b->first;
  event->block.ids = s->ids + b->first;
}

uint64_t scree_rt_stream_fresh_bytes(const scree_stream* s, const stream_node* node) {
  if (node->fresh == STREAM_NONE) return 0;
  const stream_block* b = &s->blocks[node->fresh];
  return b->count * sizeof(scree_stream_instance) + stream_run_bytes(b);
}

/* --- in, out, anew ---------------------------------------------------------------------------------------------------------- */

static void count_shown(scree_stream* s, const stream_block* b, bool in) {
  uint32_t* sum = b->level == 0 ? &s->shown_instances : &s->shown_proxies;
  if (in) {
    *sum += b->count;
    ++s->blocks_shown;
    ++s->packs[b->pack].blocks;
  } else {
    *sum -= b->count;
    --s->blocks_shown;
    --s->packs[b->pack].blocks;
  }
}

static void count_node(scree_stream* s, uint32_t number, bool shown) {
  for (uint32_t n = number; n != STREAM_NONE; n = s->nodes[n].parent) s->nodes[n].shown_below += shown ? 1u : UINT32_MAX;
}

static void own_places(scree_stream* s, uint32_t block) {
  const stream_block* b = &s->blocks[block];
  for (uint32_t unit = b->first / s->ranges.unit; unit <= (b->first + b->count - 1) / s->ranges.unit; ++unit)
    s->owners[unit] = block;
}

static void bring_in(scree_stream* s, uint32_t block) {
  stream_block* b = &s->blocks[block];
  b->shown = true;
  count_shown(s, b, true);
  own_places(s, block);
  scree_rt_stream_levels_start(s, block, s->desc.fade_seconds > 0);
  send_instances(s, SCREE_EVENT_BLOCK_IN, block);
}

void scree_rt_stream_show(scree_stream* s, uint32_t number) {
  stream_node* node = &s->nodes[number];
  node->shown = true;
  node->ready = false;
  node->block = node->fresh;
  node->fresh = STREAM_NONE;
  count_node(s, number, true);
  if (node->block != STREAM_NONE) bring_in(s, node->block);
}

void scree_rt_stream_block_out(scree_stream* s, uint32_t block) {
  stream_block* b = &s->blocks[block];
  scree_rt_stream_levels_end(s, block);
  count_shown(s, b, false);
  scree_rt_stream_send_block(s, SCREE_EVENT_BLOCK_OUT, block, 0);
  give_all(s, block);
}

void scree_rt_stream_hide(scree_stream* s, uint32_t number) {
  stream_node* node = &s->nodes[number];
  uint32_t block = node->block;
  node->block = STREAM_NONE;
  node->shown = false;
  count_node(s, number, false);
  if (node->refused) {
    node->refused = false;
    --s->refused;
  }
  node->stale = false;
  if (block == STREAM_NONE) return;
  if (s->desc.fade_seconds > 0) {
    s->blocks[block].node = STREAM_NONE;
    scree_rt_stream_levels_fade_out(s, block);
    scree_rt_stream_send_block(s, SCREE_EVENT_BLOCK_CHANGE, block, stream_run_bytes(&s->blocks[block]));
  } else {
    scree_rt_stream_block_out(s, block);
  }
}

void scree_rt_stream_replace(scree_stream* s, uint32_t number) {
  stream_node* node = &s->nodes[number];
  uint32_t old = node->block, fresh = node->fresh;
  node->ready = false;
  node->stale = false;
  node->fresh = STREAM_NONE;
  if (old == STREAM_NONE || fresh == STREAM_NONE) {
    node->block = fresh;
    if (old != STREAM_NONE) scree_rt_stream_block_out(s, old);
    if (fresh != STREAM_NONE) bring_in(s, fresh);
    return;
  }
  stream_block* b = &s->blocks[old];
  scree_rt_stream_levels_end(s, old);
  count_shown(s, b, false);
  scree_rt_ranges_give(&s->ranges, b->first, b->count);
  *b = s->blocks[fresh];
  b->shown = true;
  give_slot(s, fresh);
  count_shown(s, b, true);
  own_places(s, old);
  scree_rt_stream_levels_start(s, old, false);
  send_instances(s, SCREE_EVENT_BLOCK_CHANGE, old);
}
