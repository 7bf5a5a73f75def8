/* What a simulation of freeze and thaw holds; shared by frost*.c, rubble and surfaces. */
#ifndef SCREE_FROST_INTERNAL_H
#define SCREE_FROST_INTERNAL_H

#include <scree/frost.h>

#include "allocator.h"
#include "frost_stability.h"
#include "random.h"
#include "shards_internal.h"

enum { FROST_LAST_PATH = 4096 /* links of the last path that are kept */ };

static inline uint32_t frost_path_kept(uint32_t path_length) {
  return path_length < FROST_LAST_PATH ? path_length : FROST_LAST_PATH;
}

/* A neighbour that water can go down to. */
typedef struct frost_way {
  double pull; /* f_g of the paper, > 0 */
  uint32_t link;
  uint32_t padding;
} frost_way;

/* A rain ready to be drawn from. */
typedef struct frost_rain {
  double axis[3]; /* unit, towards where it comes from */
  double side[3], other[3];
  double cosine, sine, cap; /* of the spread; 1 - cosine */
  double weight;
} frost_rain;

/* What follows from shards and rules alone, and the weights of where water starts, in one allocation. */
typedef struct frost_tables {
  double gravity[3];   /* unit */
  double* resistance;  /* of each link, 0 .. 1 - 2^-20 */
  uint32_t* way_first; /* link_count + 1 */
  frost_way* ways;     /* of link l: ways[way_first[l]] .., rising by link */
  uint64_t* weights;   /* of the links, for each rain; 0 where not exterior */
  uint64_t* trees;     /* Fenwick trees of the weights, link_count + 1 for each rain */
  uint64_t totals[SCREE_FROST_RAINS];
  frost_rain rains[SCREE_FROST_RAINS];
  uint32_t top_bit;                                /* the largest power of two <= link_count */
  double solid_absorption, air_absorption, damage; /* k_solid, k_air and k_dmg of the paper */
  void* memory;
  size_t size;
} frost_tables;

struct scree_frost {
  scree_allocator allocator;
  const scree_shards* shards;
  scree_shards_view view;  /* of the shards */
  scree_frost_rules rules; /* its pointers are NULL: what they pointed to is in the tables */
  frost_tables tables;
  double weight_scale; /* areas to integer weights: all together stay below 2^52 */

  /* The state. */
  uint8_t* states;   /* scree_shard_state of each shard */
  uint8_t* open;     /* of each shard: 1 where it is air that joins the outside, through faces */
  uint8_t* exterior; /* of each link, see scree_frost_view */
  double* lives;     /* of each link; > 0 only between two shards that stand */
  double* passage;   /* of each link: 1 - life * resistance, 0 where no rock is on either side and so no water */
  random_stream stream;
  scree_frost_stats stats; /* its `volume` is kept by sums; memory too */
  uint32_t unchecked;      /* breaks since stability was looked at */
  frost_stability* stability;
  uint8_t* rests;     /* of each shard: 1 where it reaches down to the solid's lowest place */
  bool unsettled;     /* rules or state came anew: what these do not hold falls before the next path or edit */
  bool apart;         /* more than one component stands, and none by what holds: see frost_settle */
  uint32_t rules_set; /* how often rules came anew */

  /* What fell and was kept, in the order of falling: a shard is in at most one block. */
  scree_block* blocks;
  uint32_t* block_shards;
  uint32_t block_shard_count; /* stats.blocks is the number of blocks */

  /* Scratch. */
  uint32_t* queues[3]; /* shard_count each; the third is frost_update_exterior's */
  uint32_t* marks;     /* of each shard, to be held against frost_new_marks */
  uint32_t stamp;

  uint32_t* path_links; /* FROST_LAST_PATH */
  double* path_water;   /* what reached each */
  uint32_t path_length; /* may be more than is kept */
};

static inline bool frost_stands(const scree_frost* f, uint32_t shard) {
  return f->states[shard] != SCREE_SHARD_AIR;
}

/* Whether what hangs together with the shard stays: it is core, or, with stability and without core, rests on the lowest place. */
static inline bool frost_holds(const scree_frost* f, uint32_t shard) {
  if (f->states[shard] == SCREE_SHARD_CORE) return true;
  return f->rules.strength > 0 && f->stats.core == 0 && f->rests[shard] != 0;
}

/* The shard on the other side of a link: SCREE_NO_SHARD for the outside. */
static inline uint32_t frost_across(const scree_link* link, uint32_t shard) {
  return link->shards[0] == shard ? link->shards[1] : link->shards[0];
}

/* Two marks that no shard has: the one returned and the next. */
static inline uint32_t frost_new_marks(scree_frost* f) {
  if (f->stamp > UINT32_MAX - 4) {
    for (uint32_t s = 0; s < f->view.shard_count; ++s) f->marks[s] = 0;
    f->stamp = 0;
  }
  f->stamp += 2;
  return f->stamp - 1;
}

/* --- frost_detach.c ---------------------------------------------------------------------------------------------------------- */

/* Breaks a link as water would: life 0, one more in stats.breaks, and what then hangs on nothing falls at once. The caller counts
 * why: stats.forced, stats.overloaded. Nothing happens where the link is broken already. */
void frost_break_link(scree_frost* f, uint32_t link);

/* Makes a shard air that fell not, and lets fall what it leaves hanging. */
void frost_take_shard(scree_frost* f, uint32_t shard);

/* Of all components of what stands, those that nothing holds fall, by their lowest shards: where some have a shard that holds,
 * those that have none, else all but the largest, of equal ones that with the lowest shard, and those that rest on the lowest
 * place. Breakages keep to that by themselves, but where components are apart without what holds: there the largest may become
 * another. */
void frost_settle(scree_frost* f);

/* Takes a shard that stands again out of the block that it fell in. */
void frost_unblock(scree_frost* f, uint32_t shard);

/* --- frost_exterior.c -------------------------------------------------------------------------------------------------------- */

/* After these shards became air. */
void frost_update_exterior(scree_frost* f, const uint32_t* shards, uint32_t count);

/* Everything that follows from states, lives and tables: open, exterior, passage, weights and trees. */
void frost_derive(scree_frost* f);

/* --- frost_tables.c ---------------------------------------------------------------------------------------------------------- */

scree_result frost_check_rules(const scree_frost_rules* rules, scree_error* error); /* frost_rules.c */
bool frost_unit(const double v[3], double out[3]);                                  /* false where v has no direction */

/* Resistance of the material at the middle of every link. frost_resistance.c. */
void frost_resistances(const scree_shards_view* view, const scree_resistance* rule, double* out);

/* Rules must have passed the check. Returns SCREE_OK or OUT_OF_MEMORY. */
scree_result frost_tables_create(const scree_shards_view* view, const scree_frost_rules* rules, const scree_allocator* allocator,
                                 frost_tables* out);
void frost_tables_destroy(frost_tables* tables, const scree_allocator* allocator);

/* --- frost_flow.c ------------------------------------------------------------------------------------------------------------ */

bool frost_path(scree_frost* f); /* false: nothing takes water */

#endif
