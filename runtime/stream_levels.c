/* Levels of detail. A run is the instances of one class of a block; it has one level. The rule: the coarsest level whose error,
 * seen from the nearest point of the block's box, is at most max_error_pixels; back to a coarser one only when its error is below
 * max_error_pixels / (1 + hysteresis). While a run waits for meshes it is counted as the user of those that are already there, so
 * that they do not go out again before the last has come. */
#include <math.h>
#include <string.h>

#include "stream_internal.h"

enum {
  URGENT = 16, /* blocks that are served first in an update */
  ROUND = 128  /* others that are looked at in turn */
};

static inline uint32_t run_mesh(const scree_stream* s, const stream_block* b, uint32_t run, uint32_t i, uint32_t level) {
  return stream_mesh_slot(&s->packs[b->pack], s->instances[b->runs[run].first + i].asset, level);
}

/* --- the rule --------------------------------------------------------------------------------------------------------------- */

/* Metres that one cell of a block's meshes is wide, at most. */
static float block_cell(const stream_block* b) {
  return b->level > 0 ? b->cell * (float)(1u << (b->level - 1)) : b->cell * b->largest;
}

/* The coarsest level whose error is at most `allowed`, in cells. */
static uint8_t coarsest_within(const float* error, uint32_t levels, double allowed) {
  uint8_t level = 0;
  while (level + 1u < levels && (double)error[level + 1] <= allowed) ++level;
  return level;
}

/* The level that a run is on its way to: its aim, but for levels that cannot be read. */
static uint8_t effective_aim(const stream_block* b, uint32_t run) {
  uint8_t level = b->aim[run];
  while (b->barred[run] >> level & 1) ++level; /* the coarsest is never barred */
  return level;
}

static void count_coarser(scree_stream* s, stream_block* b) {
  s->coarser -= b->coarser;
  b->coarser = 0;
  if (s->desc.decode != NULL)
    for (uint32_t r = 0; r < b->run_count; ++r)
      if (b->runs[r].level > b->ideal[r]) b->coarser += b->runs[r].count;
  s->coarser += b->coarser;
}

static bool waits(const stream_block* b) {
  for (uint32_t r = 0; r < b->run_count; ++r)
    if (effective_aim(b, r) != b->runs[r].level) return true;
  return false;
}

/* What the rule says for a distance; delivers between which distances it says the same. first: the block has no levels yet, so
 * there is no hysteresis. Where one run has to become finer, all that may do so at once, which saves events. */
static void aim_at(const scree_stream* s, stream_block* b, double scaled, bool first, double* near, double* far) {
  const stream_pack* pack = &s->packs[b->pack];
  double per_metre = (double)s->desc.max_error_pixels / s->pixels / (double)block_cell(b); /* cells a metre of distance */
  double hysteresis = 1 + (double)s->desc.hysteresis;
  const float(*errors)[STREAM_LEVELS] = pack->error[b->level > 0];
  uint32_t levels = pack->levels, runs = b->run_count < STREAM_CLASSES ? b->run_count : STREAM_CLASSES;
  *near = -INFINITY;
  *far = INFINITY;
  if (s->desc.decode == NULL) {
    for (uint32_t r = 0; r < runs; ++r) b->ideal[r] = b->aim[r] = (uint8_t)(levels - 1);
    return;
  }
  for (int bounded = 0; bounded < (s->mesh_scale > 1 ? 2 : 1); ++bounded) {
    double unit = bounded ? per_metre * s->mesh_scale : per_metre;
    uint8_t* level = bounded ? b->aim : b->ideal;
    bool finer = first;
    for (uint32_t r = 0; r < runs && !finer; ++r)
      finer = level[r] > coarsest_within(errors[b->run_class[r]], levels, scaled * unit);
    for (uint32_t r = 0; r < runs; ++r) {
      const float* error = errors[b->run_class[r]];
      uint8_t fine = coarsest_within(error, levels, scaled * unit / hysteresis);
      if (first)
        level[r] = coarsest_within(error, levels, scaled * unit);
      else if (level[r] < fine || (finer && level[r] > fine))
        level[r] = fine;
      if (level[r] > 0) *near = fmax(*near, (double)error[level[r]] / unit);
      if (level[r] + 1u < levels) *far = fmin(*far, (double)error[level[r] + 1] * hysteresis / unit);
    }
  }
  if (s->mesh_scale <= 1) memcpy(b->aim, b->ideal, sizeof b->aim);
}

static double block_distance(const scree_stream* s, const stream_block* b) {
  double low[3], high[3], scaled;
  for (int a = 0; a < 3; ++a) {
    low[a] = b->origin[a] + (double)b->min[a];
    high[a] = b->origin[a] + (double)b->max[a];
  }
  scree_rt_stream_distance(s, low, high, &scaled);
  return scaled;
}

static float urgency(const scree_stream* s, const stream_block* b) {
  float worst = 0;
  for (uint32_t r = 0; r < b->run_count; ++r)
    if (effective_aim(b, r) < b->runs[r].level)
      worst = fmaxf(worst, s->packs[b->pack].error[b->level > 0][b->run_class[r]][b->runs[r].level]);
  return worst * block_cell(b) / (float)(block_distance(s, b) + 1e-3);
}

/* --- lists ------------------------------------------------------------------------------------------------------------------ */

static void start_waiting(scree_stream* s, uint32_t block) {
  stream_block* b = &s->blocks[block];
  if (b->waiting_at == STREAM_NONE) {
    b->waiting_at = s->waiting_count++;
    s->waiting[b->waiting_at].block = block;
  }
  s->waiting[b->waiting_at].urgency = urgency(s, b);
}

static void stop_waiting(scree_stream* s, uint32_t block) {
  stream_block* b = &s->blocks[block];
  if (b->waiting_at == STREAM_NONE) return;
  stream_wait last = s->waiting[--s->waiting_count];
  s->waiting[b->waiting_at] = last;
  s->blocks[last.block].waiting_at = b->waiting_at;
  b->waiting_at = STREAM_NONE;
}

static void start_fading(scree_stream* s, uint32_t block) {
  stream_block* b = &s->blocks[block];
  if (b->fading_at != STREAM_NONE) return;
  b->fading_at = s->fading_count;
  s->fading[s->fading_count++] = block;
}

static void stop_fading(scree_stream* s, uint32_t block) {
  stream_block* b = &s->blocks[block];
  if (b->fading_at == STREAM_NONE) return;
  uint32_t last = s->fading[--s->fading_count];
  s->fading[b->fading_at] = last;
  s->blocks[last].fading_at = b->fading_at;
  b->fading_at = STREAM_NONE;
}

/* --- users of meshes -------------------------------------------------------------------------------------------------------- */

static void leave_level(scree_stream* s, const stream_block* b, uint32_t run, uint32_t level, uint32_t count) {
  if (s->roomy) return;
  for (uint32_t i = 0; i < count; ++i) scree_rt_stream_mesh_leave(s, run_mesh(s, b, run, i, level));
}

static void uncount(scree_stream* s, stream_block* b, uint32_t run) {
  leave_level(s, b, run, b->goal[run], b->counted[run]);
  b->counted[run] = 0;
}

/* Counts the run as user of `level` as far as meshes are there; true when all are. */
static bool count_on(scree_stream* s, stream_block* b, uint32_t run, uint8_t level) {
  if (b->goal[run] != level) uncount(s, b, run);
  b->goal[run] = level;
  if (s->roomy && s->packs[b->pack].absent[b->level > 0][b->run_class[run]][level] == 0) b->counted[run] = b->runs[run].count;
  for (uint32_t count = b->runs[run].count; b->counted[run] < count; ++b->counted[run]) {
    uint32_t mesh = run_mesh(s, b, run, b->counted[run], level);
    if (s->meshes[mesh].state == MESH_FAILED) b->barred[run] |= (uint8_t)(1u << level);
    if (!stream_mesh_usable(&s->meshes[mesh])) return false;
    if (!s->roomy) scree_rt_stream_mesh_use(s, mesh);
  }
  return true;
}

void scree_rt_stream_levels_recount(scree_stream* s, uint32_t block) {
  stream_block* b = &s->blocks[block];
  for (uint32_t r = 0; r < b->run_count; ++r) {
    b->counted[r] = 0;
    for (uint32_t i = 0; i < b->runs[r].count && !s->roomy; ++i) {
      scree_rt_stream_mesh_use(s, run_mesh(s, b, r, i, b->runs[r].level));
      if (b->runs[r].from_level != 255) scree_rt_stream_mesh_use(s, run_mesh(s, b, r, i, b->runs[r].from_level));
    }
  }
}

static void add_run(scree_stream* s, const stream_block* b, uint32_t run) {
  s->triangles += b->triangles[run][b->runs[run].level];
  if (b->level == 0) s->shown_by_level[b->runs[run].level] += b->runs[run].count;
}

static void remove_run(scree_stream* s, const stream_block* b, uint32_t run) {
  s->triangles -= b->triangles[run][b->runs[run].level];
  if (b->level == 0) s->shown_by_level[b->runs[run].level] -= b->runs[run].count;
}

/* All instances of the run are counted at its goal: that is its level from now on. */
static void switch_run(scree_stream* s, uint32_t block, uint32_t run) {
  stream_block* b = &s->blocks[block];
  scree_stream_run* r = &b->runs[run];
  uint8_t old = r->level;
  remove_run(s, b, run);
  r->level = b->goal[run];
  b->counted[run] = 0;
  add_run(s, b, run);
  if (s->desc.fade_seconds > 0) {
    r->from_level = old;
    r->fade_start = (float)s->time;
    start_fading(s, block);
  } else {
    leave_level(s, b, run, old, r->count);
  }
}

/* --- a block comes, changes, goes ------------------------------------------------------------------------------------------- */

void scree_rt_stream_levels_start(scree_stream* s, uint32_t block, bool fades) {
  stream_block* b = &s->blocks[block];
  b->waiting_at = b->fading_at = STREAM_NONE;
  b->coarser = 0;
  b->fade_start = fades ? (float)s->time : -INFINITY;
  memset(b->barred, 0, sizeof b->barred);
  memset(b->counted, 0, sizeof b->counted);
  memset(b->goal, 0, sizeof b->goal);
  double near, far;
  aim_at(s, b, block_distance(s, b), true, &near, &far);
  for (uint32_t r = 0; r < b->run_count; ++r) {
    uint8_t level = b->aim[r], coarsest = (uint8_t)(s->packs[b->pack].levels - 1);
    while (!count_on(s, b, r, level) && level < coarsest) ++level;
    b->runs[r].level = level;
    b->runs[r].from_level = 255;
    b->runs[r].padding = 0;
    b->runs[r].fade_start = -INFINITY;
    b->counted[r] = 0;
    add_run(s, b, r);
  }
  count_coarser(s, b);
  if (waits(b)) start_waiting(s, block);
  scree_rt_stream_watch(s, block, near, far);
}

void scree_rt_stream_levels_end(scree_stream* s, uint32_t block) {
  stream_block* b = &s->blocks[block];
  for (uint32_t r = 0; r < b->run_count; ++r) {
    remove_run(s, b, r);
    uncount(s, b, r);
    leave_level(s, b, r, b->runs[r].level, b->runs[r].count);
    if (b->runs[r].from_level != 255) leave_level(s, b, r, b->runs[r].from_level, b->runs[r].count);
  }
  s->coarser -= b->coarser;
  b->coarser = 0;
  stop_waiting(s, block);
  stop_fading(s, block);
  scree_rt_stream_unwatch(s, block);
}

void scree_rt_stream_levels_fade_out(scree_stream* s, uint32_t block) {
  stream_block* b = &s->blocks[block];
  for (uint32_t r = 0; r < b->run_count; ++r) uncount(s, b, r);
  stop_waiting(s, block);
  scree_rt_stream_unwatch(s, block);
  b->leaving = true;
  b->fade_start = (float)s->time;
  start_fading(s, block);
}

void scree_rt_stream_levels_aim(scree_stream* s, uint32_t block, double* near, double* far) {
  stream_block* b = &s->blocks[block];
  aim_at(s, b, block_distance(s, b), false, near, far);
  count_coarser(s, b);
  if (waits(b))
    s->moved[s->moved_count++] = block;
  else
    stop_waiting(s, block);
}

/* Brings a run as near to its aim as the meshes that are there allow. Returns whether it has changed. */
static bool step_run(scree_stream* s, uint32_t block, uint32_t run) {
  stream_block* b = &s->blocks[block];
  if (b->runs[run].from_level != 255) return false;
  for (;;) {
    uint8_t aim = effective_aim(b, run), level = b->runs[run].level;
    if (aim == level) {
      uncount(s, b, run);
      return false;
    }
    if (count_on(s, b, run, aim)) {
      switch_run(s, block, run);
      return true;
    }
    if (effective_aim(b, run) != aim) continue; /* a mesh of that level cannot be read */
    /* The next best: a level between, or a coarser one when memory has to be given back. */
    uint8_t end = aim < level ? level : s->short_of_meshes ? (uint8_t)s->packs[b->pack].levels : 0;
    for (uint8_t other = (uint8_t)(aim + 1); other < end; ++other) {
      if (b->barred[run] >> other & 1) continue;
      uint32_t i = 0;
      while (i < b->runs[run].count && stream_mesh_usable(&s->meshes[run_mesh(s, b, run, i, other)])) ++i;
      if (i < b->runs[run].count) continue;
      if (count_on(s, b, run, other)) {
        switch_run(s, block, run);
        return true;
      }
    }
    return false;
  }
}

/* Returns false when no more meshes can be asked for now. */
static bool ask_for_run(scree_stream* s, const stream_block* b, uint32_t run) {
  uint8_t aim = effective_aim(b, run);
  if (aim == b->runs[run].level || b->goal[run] != aim) return true;
  for (uint32_t i = b->counted[run]; i < b->runs[run].count; ++i) {
    uint32_t asset = s->instances[b->runs[run].first + i].asset;
    if (s->meshes[stream_mesh_slot(&s->packs[b->pack], asset, aim)].state != MESH_OUT) continue;
    if (!scree_rt_stream_mesh_ask(s, b->pack, asset, aim)) return false;
  }
  return true;
}

/* Steps all runs of a block. */
static void serve(scree_stream* s, uint32_t block) {
  stream_block* b = &s->blocks[block];
  if (b->sent == s->update || !scree_rt_stream_can_send(s, 1, stream_run_bytes(b))) return;
  bool changed = false;
  for (uint32_t r = 0; r < b->run_count; ++r) changed |= step_run(s, block, r);
  if (changed) {
    scree_rt_stream_send_block(s, SCREE_EVENT_BLOCK_CHANGE, block, stream_run_bytes(b));
    count_coarser(s, b);
  }
  if (!waits(b)) stop_waiting(s, block);
}

/* --- every update ----------------------------------------------------------------------------------------------------------- */

static bool is_over(const scree_stream* s, float start) {
  return s->time >= (double)start + (double)s->desc.fade_seconds;
}

static void end_fades(scree_stream* s) {
  for (uint32_t i = s->fading_count; i-- > 0;) {
    uint32_t block = s->fading[i];
    stream_block* b = &s->blocks[block];
    if (b->leaving) {
      if (is_over(s, b->fade_start) && scree_rt_stream_can_send(s, 1, 0)) scree_rt_stream_block_out(s, block);
      continue;
    }
    bool over = false, left = false;
    for (uint32_t r = 0; r < b->run_count; ++r)
      if (b->runs[r].from_level != 255) *(is_over(s, b->runs[r].fade_start) ? &over : &left) = true;
    if (!over || b->sent == s->update || !scree_rt_stream_can_send(s, 1, stream_run_bytes(b))) continue;
    for (uint32_t r = 0; r < b->run_count; ++r) {
      if (b->runs[r].from_level == 255 || !is_over(s, b->runs[r].fade_start)) continue;
      leave_level(s, b, r, b->runs[r].from_level, b->runs[r].count);
      b->runs[r].from_level = 255;
    }
    if (!left) stop_fading(s, block);
    scree_rt_stream_send_block(s, SCREE_EVENT_BLOCK_CHANGE, block, stream_run_bytes(b));
  }
}

/* The blocks that need meshes most. */
static uint32_t most_urgent(const scree_stream* s, uint32_t blocks[URGENT]) {
  stream_wait best[URGENT];
  uint32_t count = 0;
  for (uint32_t i = 0; i < s->waiting_count; ++i) {
    stream_wait w = s->waiting[i];
    if (count == URGENT && !(w.urgency > best[count - 1].urgency)) continue;
    uint32_t at = count < URGENT ? count++ : URGENT - 1;
    while (at > 0 && best[at - 1].urgency < w.urgency) {
      best[at] = best[at - 1];
      --at;
    }
    best[at] = w;
  }
  for (uint32_t i = 0; i < count; ++i) blocks[i] = best[i].block;
  return count;
}

void scree_rt_stream_levels_update(scree_stream* s) {
  scree_rt_stream_watch_update(s, s->revisit);
  if (s->fading_count > 0) end_fades(s);
  for (uint32_t i = 0; i < s->moved_count; ++i) { /* most find their meshes there */
    serve(s, s->moved[i]);
    if (waits(&s->blocks[s->moved[i]])) start_waiting(s, s->moved[i]);
  }
  if (s->waiting_count == 0) return;
  uint32_t urgent[URGENT], count = most_urgent(s, urgent);
  for (uint32_t i = 0; i < count; ++i) serve(s, urgent[i]);
  bool more = true;
  for (uint32_t i = 0; i < count && more; ++i) {
    const stream_block* b = &s->blocks[urgent[i]];
    for (uint32_t r = 0; r < b->run_count && more; ++r) more = ask_for_run(s, b, r);
  }
  for (uint32_t i = 0; i < ROUND && s->waiting_count > 0; ++i) {
    if (s->waiting_next >= s->waiting_count) s->waiting_next = 0;
    uint32_t before = s->waiting_count, block = s->waiting[s->waiting_next].block;
    serve(s, block);
    if (s->waiting_count == before) ++s->waiting_next;
    if (i + 1 >= before) break;
  }
}
