/* Which blocks have to be looked at because a view has moved. Each shown block has a range of distances in which its levels stay as
 * they are; from the nearer end of it follows how far the views may travel before it can be left. Blocks lie in a wheel of buckets
 * by that: an update looks only at those whose travel has passed. */
#include <math.h>

#include "stream_internal.h"

enum { PREFETCHED = 192 }; /* bytes of a block that decide about its levels */

static double bucket_width(const scree_stream* s) {
  return s->desc.view_distance / STREAM_BUCKETS;
}

static uint32_t* bucket_of(scree_stream* s, uint64_t number) {
  return &s->buckets[number % STREAM_BUCKETS];
}

static void put(scree_stream* s, uint32_t block, double margin) {
  stream_watch* w = &s->watches[block];
  double ahead = floor((s->travel + margin) / bucket_width(s)) - (double)s->bucket_now;
  uint64_t number = s->bucket_now + (ahead < 0 ? 0 : ahead < STREAM_BUCKETS - 1 ? (uint64_t)ahead : STREAM_BUCKETS - 1);
  uint32_t* head = bucket_of(s, number);
  w->bucket = (uint32_t)(number % STREAM_BUCKETS);
  w->before = STREAM_NONE;
  w->after = *head;
  if (*head != STREAM_NONE) s->watches[*head].before = block;
  *head = block;
}

static void take_out(scree_stream* s, uint32_t block) {
  stream_watch* w = &s->watches[block];
  if (w->before != STREAM_NONE)
    s->watches[w->before].after = w->after;
  else
    s->buckets[w->bucket] = w->after;
  if (w->after != STREAM_NONE) s->watches[w->after].before = w->before;
  w->bucket = STREAM_NONE;
}

static void put_back(scree_stream* s, uint32_t block, double scaled) {
  const stream_watch* w = &s->watches[block];
  put(s, block, fmax(0, fmin(scaled - w->near, w->far - scaled)));
}

void scree_rt_stream_watch(scree_stream* s, uint32_t block, double scaled, double near, double far) {
  const stream_block* b = &s->blocks[block];
  stream_watch* w = &s->watches[block];
  for (int a = 0; a < 3; ++a) {
    w->low[a] = b->origin[a] + (double)b->min[a];
    w->high[a] = b->origin[a] + (double)b->max[a];
  }
  w->near = near;
  w->far = far;
  put_back(s, block, scaled);
}

void scree_rt_stream_unwatch(scree_stream* s, uint32_t block) {
  if (s->watches[block].bucket != STREAM_NONE) take_out(s, block);
}

static void look_at(scree_stream* s, uint32_t block, bool anew) {
  stream_watch* w = &s->watches[block];
  double scaled;
  scree_rt_stream_distance(s, w->low, w->high, &scaled);
  if (anew || !(scaled > w->near && scaled < w->far)) scree_rt_stream_levels_aim(s, block, scaled, &w->near, &w->far);
  put_back(s, block, scaled);
}

static void look_at_bucket(scree_stream* s, uint32_t* head, bool anew) {
  uint32_t block = *head;
  *head = STREAM_NONE;
  while (block != STREAM_NONE) { /* what is put back comes to the front of a bucket, never behind this one */
    uint32_t after = s->watches[block].after;
    if (after != STREAM_NONE) { /* blocks of a bucket lie all over the memory */
      stream_prefetch(&s->watches[after], sizeof *s->watches);
      stream_prefetch(&s->blocks[after], PREFETCHED);
    }
    look_at(s, block, anew);
    block = after;
  }
}

void scree_rt_stream_watch_update(scree_stream* s, bool anew) {
  uint64_t now = (uint64_t)floor(s->travel / bucket_width(s));
  if (!anew && s->travel == s->watched_travel && *bucket_of(s, s->bucket_now) == STREAM_NONE) return;
  uint64_t steps = now - s->bucket_now;
  if (anew || steps >= STREAM_BUCKETS) { /* all of them */
    uint32_t all = STREAM_NONE;
    for (uint32_t i = 0; i < STREAM_BUCKETS; ++i)
      for (uint32_t block = s->buckets[i], after; block != STREAM_NONE; block = after) {
        after = s->watches[block].after;
        s->watches[block].after = all;
        all = block;
        s->buckets[i] = after;
      }
    s->bucket_now = now;
    look_at_bucket(s, &all, anew);
  } else {
    for (uint64_t last = s->bucket_now; last <= now; ++last) {
      s->bucket_now = last;
      uint32_t chain = *bucket_of(s, last);
      *bucket_of(s, last) = STREAM_NONE;
      s->bucket_now = now;
      look_at_bucket(s, &chain, false);
    }
  }
  s->watched_travel = s->travel;
}
