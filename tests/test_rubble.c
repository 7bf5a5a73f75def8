/* Where what fell comes to rest: boxes of lattices, whose places are then looked at exactly, without columns. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "failing_allocator.h"
#include "make_shards.h"
#include "rubble_internal.h"

/* A lattice of which some boxes fell, each a block of its own. */
typedef struct scene {
  scree_shards* shards;
  scree_shards_view view;
  uint32_t size[3];
  uint8_t* states;
  scree_block* blocks;
  uint32_t* block_shards;
  double (*halves)[3]; /* half the sides of each shard's box */
  rubble_input input;
  scree_rubble_desc desc;
  scree_rubble* rubble;
  const scree_resting_block* resting;
  uint32_t count;
} scene;

static scene make_scene(uint32_t x, uint32_t y, uint32_t z, uint64_t seed) {
  scene s = {.size = {x, y, z}, .desc = {.share = 1}};
  s.shards = make_lattice(s.size, seed, NULL);
  s.view = s.shards->view;
  s.states = calloc(s.view.shard_count, 1);
  s.blocks = calloc(s.view.shard_count, sizeof *s.blocks);
  s.block_shards = calloc(s.view.shard_count, sizeof *s.block_shards);
  s.halves = calloc(s.view.shard_count, sizeof *s.halves);
  assert_true(s.states != NULL && s.blocks != NULL && s.block_shards != NULL && s.halves != NULL);
  for (uint32_t l = 0; l < s.view.link_count; ++l)
    for (int side = 0; side < 2; ++side) {
      const scree_link* link = &s.view.links[l];
      if (link->shards[side] == SCREE_NO_SHARD) continue;
      double* half = s.halves[link->shards[side]];
      const double* centre = s.view.shards[link->shards[side]].centroid;
      for (int axis = 0; axis < 3; ++axis) half[axis] = fmax(half[axis], fabs(link->centroid[axis] - centre[axis]));
    }
  s.input = (rubble_input){.states = s.states, .blocks = s.blocks, .block_shards = s.block_shards, .gravity = {0, -1, 0}};
  return s;
}

static void free_scene(scene* s) {
  scree_rubble_destroy(s->rubble);
  scree_shards_destroy(s->shards);
  free(s->states);
  free(s->blocks);
  free(s->block_shards);
  free(s->halves);
}

static uint32_t at(const scene* s, uint32_t x, uint32_t y, uint32_t z) {
  return x + s->size[0] * (y + s->size[1] * z);
}

/* x, y, z: where it is pushed. */
static void drop(scene* s, uint32_t shard, double x, double y, double z) {
  const scree_shard* from = &s->view.shards[shard];
  const uint32_t n = s->input.block_count++;
  s->states[shard] = SCREE_SHARD_AIR;
  s->block_shards[n] = shard;
  s->blocks[n] = (scree_block){.first_shard = n, .shard_count = 1, .path = n, .volume = from->volume, .push = {x, y, z}};
  memcpy(s->blocks[n].centroid, from->centroid, sizeof from->centroid);
}

/* `height` boxes one above the other, as one block. */
static void drop_column(scene* s, uint32_t x, uint32_t y, uint32_t z, uint32_t height, double push) {
  const uint32_t n = s->input.block_count++;
  scree_block* block = &s->blocks[n];
  *block = (scree_block){.first_shard = n > 0 ? block[-1].first_shard + block[-1].shard_count : 0, .path = n, .push = {0, 0, push}};
  for (uint32_t k = 0; k < height; ++k) {
    const uint32_t shard = at(s, x, y + k, z);
    const scree_shard* from = &s->view.shards[shard];
    s->states[shard] = SCREE_SHARD_AIR;
    s->block_shards[block->first_shard + block->shard_count++] = shard;
    block->volume += from->volume;
    for (int axis = 0; axis < 3; ++axis) block->centroid[axis] += from->volume * from->centroid[axis];
  }
  for (int axis = 0; axis < 3; ++axis) block->centroid[axis] /= block->volume;
}

static scree_result settle_quietly(scene* s, scree_error* error) {
  s->input.view = &s->view;
  scree_rubble_destroy(s->rubble);
  s->rubble = NULL;
  const scree_result result = rubble_settle(&s->input, &s->desc, &s->rubble, error);
  s->count = result == SCREE_OK ? scree_rubble_get(s->rubble, &s->resting) : 0;
  return result;
}

static void settle(scene* s) {
  scree_error error;
  if (settle_quietly(s, &error) != SCREE_OK) fail_msg("%s", error.message);
}

/* A width of columns that the facts below are measured in: as the header's default. */
static double column_of(const scene* s) {
  return s->desc.resolution > 0 ? s->desc.resolution : cbrt(s->view.volume / s->view.shard_count) / 3;
}

/* A cliff of which most of the front fell, from below up. */
static scene make_cliff(uint32_t width, uint32_t height, uint32_t fallen, uint64_t seed) {
  scene s = make_scene(width, height, 5 + fallen, seed);
  for (uint32_t y = 1; y < height; ++y)
    for (uint32_t z = 5 + fallen; z-- > 5;)
      for (uint32_t x = 0; x < width; ++x) drop(&s, at(&s, x, y, z), 0, 0, 1);
  s.desc.reach = 40;
  return s;
}

/* A room in a cliff, open to the front, whose upper layers fell. */
static scene make_cave(uint64_t seed) {
  scene s = make_scene(9, 8, 9, seed);
  for (uint32_t y = 1; y < 6; ++y)
    for (uint32_t z = 2; z < 7; ++z)
      for (uint32_t x = 2; x < 7; ++x) {
        s.states[at(&s, x, y, z)] = SCREE_SHARD_AIR;
        if (y > 3) drop(&s, at(&s, x, y, z), 0, -1, 0);
      }
  return s;
}

/* --- exact boxes -------------------------------------------------------------------------------------------------------------- */

/* How deep p is in a box at `place`, turned by `turn`; < 0 outside. */
static double depth_in(const double place[3], const double turn[4], const double half[3], const double p[3]) {
  const double back[4] = {-turn[0], -turn[1], -turn[2], turn[3]};
  double from[3], in[3], depth = INFINITY;
  for (int axis = 0; axis < 3; ++axis) from[axis] = p[axis] - place[axis];
  rubble_rotate(back, from, in);
  for (int axis = 0; axis < 3; ++axis) depth = fmin(depth, half[axis] - fabs(in[axis]));
  return depth;
}

static const double unturned[4] = {0, 0, 0, 1};

/* How deep p is in the ground, in what stands, or in a block but `self`. */
static double depth_at(const scene* s, uint32_t self, const double p[3]) {
  double depth = s->desc.ground - p[1];
  for (uint32_t i = 0; i < s->view.shard_count; ++i) {
    const double* c = s->view.shards[i].centroid;
    if (s->states[i] == SCREE_SHARD_AIR || fabs(p[0] - c[0]) > 2 || fabs(p[1] - c[1]) > 2 || fabs(p[2] - c[2]) > 2) continue;
    depth = fmax(depth, depth_in(c, unturned, s->halves[i], p));
  }
  for (uint32_t i = 0; i < s->count; ++i) {
    const scree_resting_block* r = &s->resting[i];
    if (i == self || fabs(p[0] - r->translation[0]) > 2 || fabs(p[1] - r->translation[1]) > 2 || fabs(p[2] - r->translation[2]) > 2)
      continue;
    depth = fmax(depth, depth_in(r->translation, r->rotation, s->halves[s->block_shards[r->block]], p));
  }
  return depth;
}

/* A place on the surface of a resting block: u, v of -1..1 on face 0..5. */
static void surface_at(const scene* s, uint32_t i, int face, double u, double v, double out[3]) {
  const double* half = s->halves[s->block_shards[s->resting[i].block]];
  double local[3];
  const int axis = face / 2;
  local[axis] = face % 2 ? half[axis] : -half[axis];
  local[(axis + 1) % 3] = u * half[(axis + 1) % 3];
  local[(axis + 2) % 3] = v * half[(axis + 2) % 3];
  rubble_rotate(s->resting[i].rotation, local, out);
  for (int k = 0; k < 3; ++k) out[k] += s->resting[i].translation[k];
}

/* The least drop after which some place on a block's surface is in something, in parts of a column; up to 2. */
static double gap_below(const scene* s, uint32_t i) {
  for (int part = 0; part < 8; ++part)
    for (int face = 0; face < 6; ++face)
      for (int u = -4; u <= 4; ++u)
        for (int v = -4; v <= 4; ++v) {
          double p[3];
          surface_at(s, i, face, u / 4.0, v / 4.0, p);
          p[1] -= part * 0.25 * column_of(s);
          if (depth_at(s, i, p) >= -1e-9) return part * 0.25;
        }
  return 2;
}

static double deepest(const scene* s, uint32_t i) {
  double most = 0;
  for (int face = 0; face < 6; ++face)
    for (int u = -2; u <= 2; ++u)
      for (int v = -2; v <= 2; ++v) {
        double p[3];
        surface_at(s, i, face, u / 2.0, v / 2.0, p);
        most = fmax(most, depth_at(s, i, p));
      }
  return most / column_of(s);
}

/* Whether the centre of mass is above what bears the block: no level direction has all places that bear on its far side. */
static bool lies_still(const scene* s, uint32_t i) {
  double places[6 * 81][2];
  uint32_t count = 0;
  const double* centre = s->resting[i].translation;
  for (int face = 0; face < 6; ++face)
    for (int u = -4; u <= 4; ++u)
      for (int v = -4; v <= 4; ++v) {
        double p[3];
        surface_at(s, i, face, u / 4.0, v / 4.0, p);
        p[1] -= column_of(s);
        if (depth_at(s, i, p) < 0) continue;
        places[count][0] = p[0] - centre[0];
        places[count++][1] = p[2] - centre[2];
      }
  for (int k = 0; k < 64; ++k) {
    const double angle = k * 3.141592653589793 / 32;
    double most = -INFINITY;
    for (uint32_t c = 0; c < count; ++c) most = fmax(most, places[c][0] * cos(angle) + places[c][1] * sin(angle));
    if (!(most > 0)) return false;
  }
  return true;
}

/* --- facts -------------------------------------------------------------------------------------------------------------------- */

static void look_at(scene* s, uint32_t fewest) {
  settle(s);
  assert_true(s->count >= fewest);
  uint32_t still = 0;
  for (uint32_t i = 0; i < s->count; ++i) {
    assert_true(gap_below(s, i) <= 0.5);
    assert_true(deepest(s, i) <= 1.25);
    still += lies_still(s, i);
  }
  assert_true(still >= 0.95 * s->count);
}

static void blocks_touch_do_not_sink_and_lie_still(void** unused) {
  (void)unused;
  for (uint64_t seed = 1; seed <= 2; ++seed) {
    scene s = make_cliff(10, 9, 4, seed);
    look_at(&s, 320);
    free_scene(&s);
    s = make_cave(seed);
    look_at(&s, 50);
    free_scene(&s);
  }
}

static void blocks_in_a_cave_stay_in_it(void** unused) {
  (void)unused;
  scene s = make_cave(5);
  settle(&s);
  assert_int_equal(s.count, s.input.block_count);
  const double* low = s.view.shards[at(&s, 1, 0, 1)].centroid;
  const double* high = s.view.shards[at(&s, 7, 6, 7)].centroid;
  for (uint32_t i = 0; i < s.count; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      assert_true(s.resting[i].translation[axis] > low[axis]);
      assert_true(s.resting[i].translation[axis] < high[axis]);
    }
  free_scene(&s);
}

static void none_higher_than_it_was(scene* s) {
  settle(s);
  for (uint32_t i = 0; i < s->count; ++i)
    assert_true(s->resting[i].translation[1] <= s->blocks[s->resting[i].block].centroid[1] + 0.03);
}

/* A third of a level top, alone or beside each other, that could only go up. */
static scene make_plateau(uint64_t seed) {
  scene s = make_scene(11, 4, 11, seed);
  random_stream stream = {seed};
  for (uint32_t z = 1; z < 10; ++z)
    for (uint32_t x = 1; x < 10; ++x)
      if (random_unit(&stream) < 0.33) drop(&s, at(&s, x, 3, z), 0, 1, 0);
  return s;
}

static void none_rests_higher_than_it_was(void** unused) {
  (void)unused;
  for (uint64_t seed = 1; seed <= 2; ++seed) {
    scene s = make_plateau(seed);
    none_higher_than_it_was(&s);
    free_scene(&s);
    s = make_cliff(10, 9, 4, seed);
    none_higher_than_it_was(&s);
    assert_int_equal(s.count, s.input.block_count);
    free_scene(&s);
    s = make_cave(seed);
    none_higher_than_it_was(&s);
    free_scene(&s);
  }
}

static void a_block_whose_only_way_out_is_up_is_not_there(void** unused) {
  (void)unused;
  scene s = make_scene(5, 4, 5, 0);
  drop(&s, at(&s, 2, 3, 2), 0, 1, 0);
  settle(&s);
  assert_int_equal(s.count, 0);
  free_scene(&s);
}

/* Of a box, all that stands is a wall of one layer behind what fell, into which that was pushed. */
static void none_goes_through_a_wall(void** unused) {
  (void)unused;
  for (int coarse = 0; coarse < 4; ++coarse) {
    scene s = make_scene(9, 6, 4, 0);
    s.desc.reach = 40;
    s.desc.resolution = coarse > 0 ? 0.85 + 0.1 * coarse : 0; /* a wall as thick as a column */
    for (uint32_t y = 0; y < 6; ++y)
      for (uint32_t z = 1; z < 4; ++z)
        for (uint32_t x = 0; x < 9; ++x) {
          if (x > 2 && x < 6 && y > 1)
            drop(&s, at(&s, x, y, z), 0, 0, -1);
          else
            s.states[at(&s, x, y, z)] = SCREE_SHARD_AIR;
        }
    settle(&s);
    assert_int_equal(s.count, s.input.block_count);
    for (uint32_t i = 0; i < s.count; ++i) {
      const double* p = s.resting[i].translation;
      assert_true(p[2] > -1 || fabs(p[0]) > 4.5); /* round its ends they may */
    }
    free_scene(&s);
  }
}

static void columns_do_not_stand_on_end(void** unused) {
  (void)unused;
  uint32_t upright = 0, all = 0;
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    scene s = make_scene(12, 5, 7, seed);
    s.desc.reach = 40;
    for (uint32_t z = 7; z-- > 3;)
      for (uint32_t x = 0; x < 12; ++x) {
        s.states[at(&s, x, 0, z)] = SCREE_SHARD_AIR;
        drop_column(&s, x, 1, z, 4, x % 3 == 0 ? 1 : -1);
      }
    settle(&s);
    for (uint32_t i = 0; i < s.count; ++i) {
      double along[3];
      rubble_rotate(s.resting[i].rotation, (const double[3]){0, 1, 0}, along);
      upright += fabs(along[1]) > 0.9;
    }
    all += s.count;
    free_scene(&s);
  }
  assert_true(all > 100);
  assert_true(upright <= 0.02 * all);
}

static void what_is_thinner_than_a_tenth_of_a_column_is_dust(void** unused) {
  (void)unused;
  for (int dust = 0; dust < 2; ++dust) {
    scene s = make_scene(3, 4, 3, 0);
    s.desc.resolution = dust ? 10.5 : 9.5;
    s.desc.reach = 40;
    for (uint32_t i = 0; i < s.view.shard_count; ++i) s.states[i] = SCREE_SHARD_AIR;
    drop(&s, at(&s, 1, 3, 1), 0, 0, 0);
    settle(&s);
    assert_int_equal(s.count, dust ? 0 : 1);
    free_scene(&s);
  }
}

/* The slope of a heap's flank: of a line through its mean height at each distance from the cliff, above its toe. */
static double flank_of(const scene* s) {
  double tops[6][40] = {{0}}, n = 0, sum[4] = {0};
  const double wall = s->view.shards[at(s, 0, 1, 4)].centroid[2] + 0.5;
  for (uint32_t i = 0; i < s->count; ++i) {
    const double* p = s->resting[i].translation;
    const int far = (int)floor((p[2] - wall) / 1.5), across = (int)floor(p[0] / 1.5) + 3;
    if (far >= 0 && far < 40 && across >= 0 && across < 6) tops[across][far] = fmax(tops[across][far], p[1]);
  }
  for (int far = 0; far < 40; ++far) {
    double x = far * 1.5, y = 0;
    for (int across = 0; across < 6; ++across) y += tops[across][far] / 6;
    if (y < 1) break;
    n += 1;
    sum[0] += x;
    sum[1] += y;
    sum[2] += x * x;
    sum[3] += x * y;
  }
  assert_true(n >= 3);
  return -(n * sum[3] - sum[0] * sum[1]) / (n * sum[2] - sum[0] * sum[0]);
}

static void heaps_are_as_steep_as_their_angle_of_repose(void** unused) {
  (void)unused;
  static const double repose[3] = {0.5, 0.7, 0.9};
  for (int k = 0; k < 3; ++k) {
    scene s = make_cliff(14, 12, 5, 9);
    s.desc.repose = repose[k];
    settle(&s);
    assert_true(fabs(flank_of(&s) / repose[k] - 1) < 0.15);
    free_scene(&s);
  }
}

static void large_blocks_roll_farther(void** unused) {
  (void)unused;
  double far[2] = {0}, count[2] = {0};
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    scene s = make_cliff(10, 9, 4, seed);
    settle(&s);
    for (uint32_t i = 0; i < s.count; ++i) {
      const double volume = s.blocks[s.resting[i].block].volume;
      if (volume > 0.7 && volume < 1.3) continue;
      far[volume > 1] += s.resting[i].translation[2] - s.blocks[s.resting[i].block].centroid[2];
      count[volume > 1] += 1;
    }
    free_scene(&s);
  }
  assert_true(far[1] / count[1] > far[0] / count[0] + 0.5);
}

static void on_level_ground_a_box_lies_flat(void** unused) {
  (void)unused;
  scene s = make_scene(3, 4, 3, 11);
  s.desc.ground = -2.5;
  for (uint32_t i = 0; i < s.view.shard_count; ++i) s.states[i] = SCREE_SHARD_AIR;
  drop(&s, at(&s, 1, 3, 1), 0, 0, 0);
  settle(&s);
  assert_int_equal(s.count, 1);
  double up[3];
  const double* turn = s.resting[0].rotation;
  rubble_rotate((const double[4]){-turn[0], -turn[1], -turn[2], turn[3]}, (const double[3]){0, 1, 0}, up);
  const double* half = s.halves[at(&s, 1, 3, 1)];
  double height = 0, most = 0;
  for (int axis = 0; axis < 3; ++axis) {
    height += fabs(up[axis]) * half[axis];
    most = fmax(most, fabs(up[axis]));
  }
  assert_true(most > 1 - 1e-9);
  assert_true(fabs(s.resting[0].translation[1] - (-2.5 + height)) < 1e-9);
  free_scene(&s);
}

static void on_a_slope_blocks_lie_along_it_or_leave(void** unused) {
  (void)unused;
  float heights[61 * 61];
  for (int steep = 0; steep < 2; ++steep) {
    for (int k = 0; k < 61; ++k)
      for (int i = 0; i < 61; ++i) heights[i + 61 * k] = (float)((30 - i) * (steep ? 1.2 : 0.4));
    scene s = make_scene(3, 8, 3, 0);
    s.desc.heights = heights;
    s.desc.width = s.desc.depth = 61;
    s.desc.spacing = 1;
    s.desc.ground = -100;
    s.desc.reach = 12;
    for (uint32_t i = 0; i < s.view.shard_count; ++i) s.states[i] = SCREE_SHARD_AIR;
    drop(&s, at(&s, 1, 7, 1), 0, 0, 0);
    settle(&s);
    assert_int_equal(s.count, steep ? 0 : 1);
    if (steep == 0) {
      double up[3], most = 0;
      const double* turn = s.resting[0].rotation;
      rubble_rotate((const double[4]){-turn[0], -turn[1], -turn[2], turn[3]},
                    (const double[3]){0.4 / sqrt(1.16), 1 / sqrt(1.16), 0}, up);
      for (int axis = 0; axis < 3; ++axis) most = fmax(most, fabs(up[axis]));
      assert_true(most > 0.98);
    }
    free_scene(&s);
  }
}

static void none_lies_beyond_reach(void** unused) {
  (void)unused;
  scene s = make_cliff(8, 7, 3, 2);
  settle(&s);
  const uint32_t all = s.count;
  assert_int_equal(all, s.input.block_count);
  s.desc.reach = 4;
  settle(&s);
  assert_true(s.count < all && s.count > all / 4);
  for (uint32_t i = 0; i < s.count; ++i)
    for (int axis = 0; axis < 3; axis += 2) assert_true(fabs(s.resting[i].translation[axis]) <= s.view.max[axis] + 4);
  free_scene(&s);
}

static void dust_and_what_is_carried_away_are_not_there(void** unused) {
  (void)unused;
  scene s = make_cliff(8, 7, 3, 6);
  s.desc.min_volume = 0.8;
  settle(&s);
  uint32_t large = 0;
  for (uint32_t i = 0; i < s.input.block_count; ++i) large += s.blocks[i].volume >= 0.8;
  assert_int_equal(s.count, large);
  for (uint32_t i = 0; i < s.count; ++i) {
    assert_true(s.blocks[s.resting[i].block].volume >= 0.8);
    assert_true(i == 0 || s.resting[i].block > s.resting[i - 1].block);
  }
  s.desc.min_volume = 0;
  s.desc.share = 0.3;
  settle(&s);
  assert_true(fabs(s.count - 0.3 * s.input.block_count) < 0.06 * s.input.block_count);
  s.desc.share = 0;
  settle(&s);
  assert_int_equal(s.count, 0);
  free_scene(&s);
}

static void gravity_may_point_anywhere(void** unused) {
  (void)unused;
  scene s = make_scene(3, 3, 3, 0);
  s.input.gravity[1] = 0;
  s.input.gravity[2] = 1;
  s.desc.ground = -20; /* along +Z: at z = 20 */
  for (uint32_t i = 0; i < s.view.shard_count; ++i) s.states[i] = SCREE_SHARD_AIR;
  drop(&s, at(&s, 1, 2, 1), 0, 0, 0);
  settle(&s);
  assert_int_equal(s.count, 1);
  const double* p = s.resting[0].translation;
  assert_true(fabs(p[2] - 19.5) < 1e-9);
  assert_true(fabs(p[0]) < 3 && fabs(p[1] - 2.5) < 3);
  free_scene(&s);
}

static uint64_t digest(const scene* s) {
  uint64_t hash = s->count;
  for (uint32_t i = 0; i < s->count; ++i) {
    hash = hash_combine(hash, s->resting[i].block);
    uint64_t bits[7];
    memcpy(bits, s->resting[i].translation, sizeof s->resting[i].translation);
    memcpy(bits + 3, s->resting[i].rotation, sizeof s->resting[i].rotation);
    for (int k = 0; k < 7; ++k) hash = hash_combine(hash, bits[k]);
  }
  return hash;
}

static void the_same_heap_every_time_and_everywhere(void** unused) {
  (void)unused;
  scene s = make_cliff(8, 7, 3, 8);
  settle(&s);
  const uint64_t first = digest(&s);
  settle(&s);
  assert_true(digest(&s) == first);
  s.desc.random_seed = 1;
  settle(&s);
  assert_true(digest(&s) != first);
  if (first != UINT64_C(0xb4b147f58f37963e)) fail_msg("the heap is 0x%016llx now", (unsigned long long)first);
  free_scene(&s);
}

static bool stop_at(void* user, double done) {
  double* last = user;
  assert_true(done >= 0 && done <= 1);
  if (*last < 0) *last = done;
  return done < 0.5;
}

static void it_can_be_stopped(void** unused) {
  (void)unused;
  scene s = make_cliff(8, 7, 3, 1);
  double last = -1;
  failing_allocator counting = {.fail_at = -1};
  s.desc.allocator = failing_allocator_of(&counting);
  s.desc.progress = stop_at;
  s.desc.progress_user = &last;
  assert_int_equal(settle_quietly(&s, NULL), SCREE_ERROR_CANCELLED);
  assert_null(s.rubble);
  assert_true(last == 0);
  assert_int_equal(counting.live, 0);
  free_scene(&s);
}

static void numbers_out_of_range_are_named(void** unused) {
  (void)unused;
  scene s = make_scene(2, 2, 2, 0);
  const scree_rubble_desc good = s.desc;
  scree_error error;
  float heights[4] = {0, 0, 0, NAN};
  static const char* const names[] = {"ground", "resolution", "repose", "min_volume", "share",
                                      "reach",  "spacing",    "width",  "heights",    "resolution"};
  for (int k = 0; k < 10; ++k) {
    s.desc = good;
    if (k >= 6 && k < 9) {
      s.desc.heights = heights;
      s.desc.width = s.desc.depth = 2;
      s.desc.spacing = 1;
    }
    if (k == 0) s.desc.ground = NAN;
    if (k == 1) s.desc.resolution = -1;
    if (k == 2) s.desc.repose = INFINITY;
    if (k == 3) s.desc.min_volume = -1;
    if (k == 4) s.desc.share = 1.5;
    if (k == 5) s.desc.reach = -2;
    if (k == 6) s.desc.spacing = 0;
    if (k == 7) s.desc.width = 1;
    if (k == 9) s.desc.resolution = 1e-6;
    assert_int_equal(settle_quietly(&s, &error), SCREE_ERROR_RANGE);
    assert_true(strncmp(error.message, names[k], strlen(names[k])) == 0);
    assert_int_equal(settle_quietly(&s, NULL), SCREE_ERROR_RANGE);
  }
  s.desc = good;
  settle(&s);
  assert_int_equal(s.count, 0); /* nothing fell */
  free_scene(&s);
}

static void every_allocation_may_fail(void** unused) {
  (void)unused;
  scene s = make_cave(1);
  for (int32_t n = 0;; ++n) {
    failing_allocator failing = {.fail_at = n};
    s.desc.allocator = failing_allocator_of(&failing);
    const scree_result result = settle_quietly(&s, NULL);
    scree_rubble_destroy(s.rubble);
    s.rubble = NULL;
    assert_int_equal(failing.live, 0);
    if (!failing.failed) {
      assert_int_equal(result, SCREE_OK);
      assert_true(n >= 8);
      break;
    }
    assert_int_equal(result, SCREE_ERROR_OUT_OF_MEMORY);
  }
  free_scene(&s);
}

static void what_a_simulation_let_fall_lies_on_the_ground(void** unused) {
  (void)unused;
  const uint32_t size[3] = {4, 4, 4};
  scree_shards* shards = make_lattice(size, 3, NULL);
  scree_frost_desc desc = {.shards = shards};
  scree_frost_rules_default(&desc.rules);
  scree_frost* frost;
  assert_int_equal(scree_frost_create(&desc, &frost, NULL), SCREE_OK);
  for (uint32_t l = 0; l < shards->view.interior_link_count; ++l) {
    const uint32_t* ends = shards->view.links[l].shards;
    if (ends[0] == 63 || ends[1] == 63) assert_int_equal(scree_frost_set_life(frost, l, 0), SCREE_OK);
  }
  const scree_rubble_desc of = {.frost = frost, .share = 1, .reach = 10};
  scree_rubble* rubble;
  assert_int_equal(scree_rubble_create(&of, &rubble, NULL), SCREE_OK);
  const scree_resting_block* resting;
  assert_int_equal(scree_rubble_get(rubble, &resting), 1);
  assert_int_equal(resting[0].block, 0);
  /* It was the corner on top, and lies on the ground beside the lattice or where it was, on what is below. */
  assert_true(resting[0].translation[1] > 0 && resting[0].translation[1] <= shards->view.shards[63].centroid[1] + 0.5);
  scree_rubble_destroy(rubble);
  scree_rubble_destroy(NULL);
  scree_frost_destroy(frost);
  scree_shards_destroy(shards);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(blocks_touch_do_not_sink_and_lie_still),
      cmocka_unit_test(blocks_in_a_cave_stay_in_it),
      cmocka_unit_test(none_rests_higher_than_it_was),
      cmocka_unit_test(a_block_whose_only_way_out_is_up_is_not_there),
      cmocka_unit_test(none_goes_through_a_wall),
      cmocka_unit_test(columns_do_not_stand_on_end),
      cmocka_unit_test(what_is_thinner_than_a_tenth_of_a_column_is_dust),
      cmocka_unit_test(heaps_are_as_steep_as_their_angle_of_repose),
      cmocka_unit_test(large_blocks_roll_farther),
      cmocka_unit_test(on_level_ground_a_box_lies_flat),
      cmocka_unit_test(on_a_slope_blocks_lie_along_it_or_leave),
      cmocka_unit_test(none_lies_beyond_reach),
      cmocka_unit_test(dust_and_what_is_carried_away_are_not_there),
      cmocka_unit_test(gravity_may_point_anywhere),
      cmocka_unit_test(the_same_heap_every_time_and_everywhere),
      cmocka_unit_test(what_a_simulation_let_fall_lies_on_the_ground),
      cmocka_unit_test(it_can_be_stopped),
      cmocka_unit_test(numbers_out_of_range_are_named),
      cmocka_unit_test(every_allocation_may_fail),
  };
  return cmocka_run_group_tests_name("rubble", tests, NULL, NULL);
}
