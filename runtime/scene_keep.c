/* The rule of overlaps: a rock is dropped if its hull meets the hull of a kept rock of an earlier layer.
 *
 * Kept rocks lie in buckets by the bricks of space that hold their centroids, one set of buckets for each layer, with bricks as
 * wide as the layer's largest rock. Two balls round the centroids tell most pairs apart; hulls decide the rest. All places are
 * relative to the scene's base and computed from the integers of cells, so that a pair is judged alike in every question. */
#include <math.h>
#include <string.h>

#include "convex.h"
#include "scene_layers.h"

/* A kept rock that later layers may meet. */
typedef struct kept_rock {
  double centroid[3], home[3]; /* relative to the scene's base */
  double radius;               /* of the ball round the centroid that holds it */
  uint32_t asset;
  uint32_t bucket;
} kept_rock;

static kept_rock place_rock(const scene_layer* layer, const scree_id* id, uint32_t asset) {
  const scree_field* field = layer->given.field;
  const field_asset* a = &field->assets[asset];
  kept_rock rock;
  int64_t cell[3];
  rock_cell(field, id, cell);
  cell_centre(layer, cell, rock.home);
  for (int i = 0; i < 3; ++i) rock.centroid[i] = rock.home[i] + (double)a->centroid[i] * field->cell_size;
  rock.radius = (double)a->outer_radius * field->cell_size;
  rock.asset = asset;
  rock.bucket = 0;
  return rock;
}

/* Whether a ball reaches into a box. */
static bool ball_meets_box(const double centre[3], double radius, const double low[3], const double high[3]) {
  double away2 = 0;
  for (int a = 0; a < 3; ++a) {
    double away = centre[a] < low[a] ? low[a] - centre[a] : centre[a] > high[a] ? centre[a] - high[a] : 0;
    away2 += away * away;
  }
  return away2 <= radius * radius;
}

/* Brick of a place along one axis. Beyond what an int64 holds all places share a brick, which costs time and nothing else. */
static int64_t brick_of(double place, double brick) {
  double at = floor(place / brick);
  return at > 9e18 ? (int64_t)9e18 : at < -9e18 ? (int64_t)-9e18 : (int64_t)at;
}

static uint32_t bucket_of(const int64_t brick[3], uint32_t mask) {
  uint64_t hash = (uint64_t)brick[0] * UINT64_C(0x9e3779b97f4a7c15) ^ (uint64_t)brick[1] * UINT64_C(0xc2b2ae3d27d4eb4f) ^
                  (uint64_t)brick[2] * UINT64_C(0x165667b19e3779f9);
  return (uint32_t)((hash * UINT64_C(0x9fb21c651e98df25)) >> 40) & mask;
}

/* Puts the kept rocks of a layer into buckets, as far as later layers can meet them: bucket b has the rocks starts[b] ..
 * starts[b + 1] - 1 of those from kept_first on. */
static scree_result fill_buckets(scene_question* q, uint32_t index) {
  const scene_layer* layer = &q->scene->layers[index];
  layer_rocks* rocks = &q->layers[index];
  /* First all rocks behind one another, then sorted by bucket into the second half. */
  kept_rock* kept =
      scree_rt_scratch_extend(q->scratch, SCRATCH_BUCKET_ROCKS, q->kept_count, q->kept_count + 2 * rocks->count, sizeof *kept);
  if (kept == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  kept_rock* unsorted = kept + q->kept_count + rocks->count;
  uint32_t count = 0;
  for (uint64_t i = rocks->first; i < rocks->first + rocks->count; ++i) {
    kept_rock rock = place_rock(layer, &q->ids[i], q->instances[i].asset);
    if (ball_meets_box(rock.centroid, rock.radius, rocks->region_low, rocks->region_high)) unsorted[count++] = rock;
  }
  uint32_t size = 16;
  while (size < 2 * count) size *= 2;
  uint32_t* starts =
      scree_rt_scratch_extend(q->scratch, SCRATCH_BUCKETS, q->bucket_count, q->bucket_count + size + 1, sizeof *starts);
  if (starts == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  rocks->bucket_first = (uint32_t)q->bucket_count;
  rocks->bucket_mask = size - 1;
  rocks->kept_first = q->kept_count;
  rocks->kept_count = count;
  rocks->brick = 2 * layer->rock_radius;
  starts += q->bucket_count;
  memset(starts, 0, (size + 1) * sizeof *starts);
  for (uint32_t i = 0; i < count; ++i) {
    int64_t brick[3];
    for (int a = 0; a < 3; ++a) brick[a] = brick_of(unsorted[i].centroid[a], rocks->brick);
    unsorted[i].bucket = bucket_of(brick, rocks->bucket_mask);
    ++starts[unsorted[i].bucket];
  }
  for (uint32_t b = 0, sum = 0; b <= size; ++b) { /* ends; the next pass counts them down to the starts */
    sum += starts[b];
    starts[b] = sum;
  }
  for (uint32_t i = count; i-- > 0;) kept[q->kept_count + --starts[unsorted[i].bucket]] = unsorted[i];
  q->bucket_count += size + 1;
  q->kept_count += count;
  return SCREE_OK;
}

/* A hull, on the stack. */
typedef struct hull_copy {
  float x[FIELD_MAX_HULL], y[FIELD_MAX_HULL], z[FIELD_MAX_HULL];
  convex_hull hull;
  bool made;
} hull_copy;

static void make_hull(hull_copy* copy, const scene_layer* layer, uint32_t asset) {
  const scree_field* field = layer->given.field;
  copy->hull = (convex_hull){.x = copy->x, .y = copy->y, .z = copy->z};
  copy->hull.count = scree_rt_field_hull(field, asset, copy->x, copy->y, copy->z);
  copy->hull.scale = field->cell_size / field->lattice_per_cell;
  copy->made = true;
}

/* A rock of a later layer that looks for one that it meets. */
typedef struct seeker {
  const scene_layer* layer;
  kept_rock rock;
  hull_copy hull;
} seeker;

/* Whether the balls of a pair leave it open, and how deep they are in one another: less is deeper. */
static bool balls_meet(const seeker* s, const kept_rock* rock, double* depth) {
  double d2 = 0, apart = s->rock.radius + rock->radius;
  for (int a = 0; a < 3; ++a) {
    double d = rock->centroid[a] - s->rock.centroid[a];
    d2 += d * d;
  }
  *depth = d2 - apart * apart;
  return *depth <= 0;
}

static bool hulls_meet(seeker* s, const scene_layer* other, const kept_rock* rock) {
  if (!s->hull.made) make_hull(&s->hull, s->layer, s->rock.asset);
  hull_copy theirs;
  make_hull(&theirs, other, rock->asset);
  if (s->hull.hull.count == 0 || theirs.hull.count == 0) return false;
  for (int a = 0; a < 3; ++a) theirs.hull.at[a] = rock->home[a] - s->rock.home[a];
  return scree_rt_convex_meet(&s->hull.hull, &theirs.hull);
}

enum { MOST_OPEN = 32 };

/* Rocks whose balls meet the seeker's. The deepest is asked first, because one that meets is enough. */
typedef struct open_pairs {
  const kept_rock* rocks[MOST_OPEN];
  uint32_t count, deepest;
  double depth;
} open_pairs;

static bool settle(open_pairs* open, seeker* s, const scene_layer* other) {
  if (open->count == 0) return false;
  bool met = hulls_meet(s, other, open->rocks[open->deepest]);
  for (uint32_t i = 0; i < open->count && !met; ++i) met = i != open->deepest && hulls_meet(s, other, open->rocks[i]);
  open->count = 0;
  return met;
}

/* Looks at `count` rocks of a bucket; true when one of them is known to meet. */
static bool look_at(open_pairs* open, seeker* s, const scene_layer* other, const kept_rock* rocks, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    double depth;
    if (!balls_meet(s, &rocks[i], &depth)) continue;
    if (open->count == 0 || depth < open->depth) {
      open->deepest = open->count;
      open->depth = depth;
    }
    open->rocks[open->count++] = &rocks[i];
    if (open->count == MOST_OPEN && settle(open, s, other)) return true;
  }
  return false;
}

static bool meets_layer(const scene_question* q, seeker* s, uint32_t index) {
  const scene_layer* layer = &q->scene->layers[index];
  const layer_rocks* rocks = &q->layers[index];
  const kept_rock* kept = (const kept_rock*)q->scratch->buffers[SCRATCH_BUCKET_ROCKS].memory + rocks->kept_first;
  const uint32_t* starts = (const uint32_t*)q->scratch->buffers[SCRATCH_BUCKETS].memory + rocks->bucket_first;
  double reach = s->rock.radius + layer->rock_radius, bricks = 1;
  int64_t low[3], high[3], at[3];
  open_pairs open;
  open.count = 0;
  for (int a = 0; a < 3; ++a) {
    low[a] = brick_of(s->rock.centroid[a] - reach, rocks->brick);
    high[a] = brick_of(s->rock.centroid[a] + reach, rocks->brick);
    bricks *= (double)(high[a] - low[a]) + 1;
  }
  if (bricks > (double)rocks->kept_count) /* a giant among pebbles, or few pebbles */
    return look_at(&open, s, layer, kept, rocks->kept_count) || settle(&open, s, layer);
  for (at[2] = low[2]; at[2] <= high[2]; ++at[2])
    for (at[1] = low[1]; at[1] <= high[1]; ++at[1])
      for (at[0] = low[0]; at[0] <= high[0]; ++at[0]) {
        uint32_t bucket = bucket_of(at, rocks->bucket_mask);
        if (look_at(&open, s, layer, kept + starts[bucket], starts[bucket + 1] - starts[bucket])) return true;
      }
  return settle(&open, s, layer);
}

/* Moves out the rocks of a layer that meet one of the earlier layers with a bit in `others`. */
static void drop(scene_question* q, uint32_t index, uint64_t others) {
  layer_rocks* rocks = &q->layers[index];
  seeker s;
  s.layer = &q->scene->layers[index];
  uint64_t end = rocks->first + rocks->count, kept = rocks->first;
  for (uint64_t i = rocks->first; i < end; ++i) {
    s.rock = place_rock(s.layer, &q->ids[i], q->instances[i].asset);
    s.hull.made = false;
    bool meets_one = false;
    for (uint64_t rest = others; rest != 0 && !meets_one; rest &= rest - 1) {
      uint32_t other = (uint32_t)__builtin_ctzll(rest);
      const layer_rocks* theirs = &q->layers[other];
      if (ball_meets_box(s.rock.centroid, s.rock.radius, theirs->tight_low, theirs->tight_high))
        meets_one = meets_layer(q, &s, other);
    }
    if (meets_one) continue;
    q->ids[kept] = q->ids[i];
    q->instances[kept++] = q->instances[i];
  }
  rocks->count = kept - rocks->first;
}

scree_result scree_rt_scene_keep(scene_question* q) {
  q->bucket_count = q->kept_count = 0;
  uint64_t filled = 0;
  for (uint32_t k = 0; k < q->scene->layer_count; ++k) {
    layer_rocks* rocks = &q->layers[k];
    if (!rocks->needed || rocks->count == 0) continue;
    uint64_t others = 0;
    for (uint64_t rest = filled; rest != 0; rest &= rest - 1) {
      uint32_t j = (uint32_t)__builtin_ctzll(rest);
      bool apart = q->layers[j].kept_count == 0;
      for (int a = 0; a < 3; ++a)
        apart = apart || q->layers[j].tight_low[a] > rocks->tight_high[a] || q->layers[j].tight_high[a] < rocks->tight_low[a];
      if (!apart) others |= UINT64_C(1) << j;
    }
    if (others != 0) drop(q, k, others);
    if (!rocks->wanted) continue;
    scree_result result = fill_buckets(q, k);
    if (result != SCREE_OK) return result;
    filled |= UINT64_C(1) << k;
  }
  return SCREE_OK;
}
