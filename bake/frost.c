/* Simulations of freeze and thaw: life, steps, edits and what they tell. */
#include <string.h>

#include "frost_internal.h"
#include "support_text.h"

/* --- life and death ---------------------------------------------------------------------------------------------------------- */

static void forget_pointers(scree_frost_rules* rules) {
  rules->resistance.function = NULL;
  rules->resistance.user = NULL;
  rules->resistance.layers = NULL;
  rules->resistance.images = NULL;
}

/* Every array of the simulation, for allocation, release and the count of bytes. */
typedef struct array {
  void* at; /* of the pointer to it */
  size_t count, size;
} array;

enum { ARRAYS = 14 };

static void arrays_of(scree_frost* f, array out[ARRAYS]) {
  const size_t shards = f->view.shard_count, links = f->view.link_count;
  const array all[ARRAYS] = {
      {&f->states, shards, sizeof *f->states},
      {&f->open, shards, sizeof *f->open},
      {&f->rests, shards, sizeof *f->rests},
      {&f->exterior, links, sizeof *f->exterior},
      {&f->lives, links, sizeof *f->lives},
      {&f->passage, links, sizeof *f->passage},
      {&f->blocks, shards, sizeof *f->blocks},
      {&f->block_shards, shards, sizeof *f->block_shards},
      {&f->queues[0], shards, sizeof *f->queues[0]},
      {&f->queues[1], shards, sizeof *f->queues[1]},
      {&f->queues[2], shards, sizeof *f->queues[2]},
      {&f->marks, shards, sizeof *f->marks},
      {&f->path_links, FROST_LAST_PATH, sizeof *f->path_links},
      {&f->path_water, FROST_LAST_PATH, sizeof *f->path_water},
  };
  memcpy(out, all, sizeof all);
}

static void start_state(scree_frost* f, const uint8_t* states) {
  const scree_shards_view* v = &f->view;
  for (uint32_t s = 0; s < v->shard_count; ++s) {
    f->states[s] = states != NULL ? states[s] : SCREE_SHARD_SOLID;
    f->stats.solid += f->states[s] == SCREE_SHARD_SOLID;
    f->stats.core += f->states[s] == SCREE_SHARD_CORE;
    f->stats.air += f->states[s] == SCREE_SHARD_AIR;
    if (frost_stands(f, s)) f->stats.volume += v->shards[s].volume;
  }
  f->stats.start_volume = f->stats.volume;
  double area = 0;
  for (uint32_t l = 0; l < v->link_count; ++l) {
    const uint32_t* sides = v->links[l].shards;
    f->lives[l] = sides[1] != SCREE_NO_SHARD && frost_stands(f, sides[0]) && frost_stands(f, sides[1]) ? 1 : 0;
    area += v->links[l].area;
  }
  f->weight_scale = area > 0 ? 0x1p51 / area : 0;
  frost_derive(f);
}

static scree_result check(const scree_frost_desc* desc, scree_error* error) {
  scree_rt_text_clear(error);
  if (desc->shards == NULL) {
    scree_rt_text_add(error, "shards: there are none");
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  const scree_shards_view* v = &desc->shards->view;
  for (uint32_t s = 0; desc->states != NULL && s < v->shard_count; ++s) {
    if (desc->states[s] <= SCREE_SHARD_CORE) continue;
    scree_rt_text_add(error, "states[");
    scree_rt_text_add_count(error, s);
    scree_rt_text_add(error, "]: ");
    scree_rt_text_add_count(error, desc->states[s]);
    scree_rt_text_add(error, ": no such state");
    return SCREE_ERROR_RANGE;
  }
  return frost_check_rules(&desc->rules, error);
}

/* Scratch for stability, where the rules have it. */
static scree_result need_stability(scree_frost* f, const scree_frost_rules* rules) {
  if (!(rules->strength > 0) || f->stability != NULL) return SCREE_OK;
  const scree_result result = frost_stability_create(f->shards, &f->allocator, &f->stability);
  if (result == SCREE_OK) f->stats.memory += frost_stability_memory(f->stability);
  return result;
}

scree_result scree_frost_create(const scree_frost_desc* desc, scree_frost** out, scree_error* error) {
  *out = NULL;
  scree_result result = check(desc, error);
  if (result != SCREE_OK) return result;
  const scree_allocator allocator = scree_rt_allocator_or_default(&desc->allocator);
  scree_frost* f = scree_rt_allocate_zeroed(&allocator, 1, sizeof *f);
  if (f == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  f->allocator = allocator;
  f->shards = desc->shards;
  f->view = desc->shards->view;
  f->rules = desc->rules;
  forget_pointers(&f->rules);
  f->stream.state = hash_mix(desc->random_seed);
  f->stats.memory = sizeof *f;
  array arrays[ARRAYS];
  arrays_of(f, arrays);
  for (int i = 0; i < ARRAYS && result == SCREE_OK; ++i) {
    void* memory = scree_rt_allocate_zeroed(&allocator, arrays[i].count, arrays[i].size);
    memcpy(arrays[i].at, &memory, sizeof memory);
    if (memory == NULL) result = SCREE_ERROR_OUT_OF_MEMORY;
    f->stats.memory += arrays[i].count * arrays[i].size;
  }
  if (result == SCREE_OK) result = frost_tables_create(&f->view, &desc->rules, &allocator, &f->tables);
  if (result == SCREE_OK) result = need_stability(f, &desc->rules);
  if (result != SCREE_OK) {
    scree_frost_destroy(f);
    return result;
  }
  f->stats.memory += f->tables.size;
  frost_find_rests(&f->view, f->tables.gravity, f->rests);
  start_state(f, desc->states);
  frost_settle(f);
  *out = f;
  return SCREE_OK;
}

void scree_frost_destroy(scree_frost* f) {
  if (f == NULL) return;
  const scree_allocator allocator = f->allocator;
  array arrays[ARRAYS];
  arrays_of(f, arrays);
  for (int i = 0; i < ARRAYS; ++i) {
    void* memory;
    memcpy(&memory, arrays[i].at, sizeof memory);
    scree_rt_release(&allocator, memory, arrays[i].count, arrays[i].size);
  }
  frost_tables_destroy(&f->tables, &allocator);
  frost_stability_destroy(f->stability);
  scree_rt_release(&allocator, f, 1, sizeof *f);
}

scree_result scree_frost_set_rules(scree_frost* f, const scree_frost_rules* rules, scree_error* error) {
  scree_rt_text_clear(error);
  scree_result result = frost_check_rules(rules, error);
  if (result != SCREE_OK) return result;
  frost_tables tables;
  result = frost_tables_create(&f->view, rules, &f->allocator, &tables);
  if (result != SCREE_OK) return result;
  result = need_stability(f, rules);
  if (result != SCREE_OK) {
    frost_tables_destroy(&tables, &f->allocator);
    return result;
  }
  f->stats.memory += tables.size;
  f->stats.memory -= f->tables.size;
  frost_tables_destroy(&f->tables, &f->allocator);
  f->tables = tables;
  f->rules = *rules;
  forget_pointers(&f->rules);
  frost_find_rests(&f->view, f->tables.gravity, f->rests);
  f->unsettled = true;
  ++f->rules_set;
  frost_derive(f);
  return SCREE_OK;
}

/* --- steps ------------------------------------------------------------------------------------------------------------------- */

static void check_stability(scree_frost* f) {
  frost_stability_break(f);
  f->unchecked = 0;
}

static void settle(scree_frost* f) {
  if (f->unsettled) frost_settle(f);
}

/* One path. False when nothing takes water. */
static bool step(scree_frost* f) {
  f->stats.dry = !frost_path(f);
  if (f->unchecked >= f->rules.stability_interval) check_stability(f);
  return !f->stats.dry;
}

scree_result scree_frost_step(scree_frost* f, uint64_t count) {
  settle(f);
  for (uint64_t i = 0; i < count && step(f); ++i) {}
  check_stability(f);
  return SCREE_OK;
}

/* Of what stands, added up anew: what is kept while shards fall is rounded otherwise. */
static double standing_volume(const scree_frost* f) {
  double volume = 0;
  for (uint32_t s = 0; s < f->view.shard_count; ++s)
    if (frost_stands(f, s)) volume += f->view.shards[s].volume;
  return volume;
}

/* Judges by what the stats say, so that a share that is reached here is reached for all who ask. */
static bool is_above(scree_frost* f, double stop) {
  if (f->stats.volume > stop + 1e-9 * f->stats.start_volume) return true;
  f->stats.volume = standing_volume(f);
  return f->stats.volume > stop;
}

scree_result scree_frost_run(scree_frost* f, double share, uint64_t most, bool (*progress)(void* user, double done), void* user) {
  enum { PATHS_BETWEEN = 1024 };
  if (!(share >= 0) || !(share <= 1)) return SCREE_ERROR_RANGE;
  settle(f);
  const double stop = share * f->stats.start_volume, start = f->stats.volume;
  bool go_on = true;
  for (uint64_t i = 0; i < most && is_above(f, stop) && go_on && step(f); ++i) {
    if (progress == NULL || (i + 1) % PATHS_BETWEEN != 0) continue;
    const double by_volume = (start - f->stats.volume) / (start - stop), by_paths = (double)(i + 1) / (double)most;
    const double done = by_volume > by_paths ? by_volume : by_paths;
    go_on = progress(user, done < 1 ? done : 1);
  }
  check_stability(f);
  if (go_on && progress != NULL) go_on = progress(user, 1);
  return go_on ? SCREE_OK : SCREE_ERROR_CANCELLED;
}

/* --- edits ------------------------------------------------------------------------------------------------------------------- */

/* It hangs together with what stands by new links. */
static void stand_again(scree_frost* f, uint32_t shard, scree_shard_state state) {
  const scree_shard* s = &f->view.shards[shard];
  frost_unblock(f, shard);
  f->states[shard] = (uint8_t)state;
  --f->stats.air;
  f->stats.volume += s->volume;
  for (uint32_t k = 0; k < s->link_count; ++k) {
    const uint32_t link = f->view.shard_links[s->first_link + k];
    const uint32_t other = frost_across(&f->view.links[link], shard);
    if (other != SCREE_NO_SHARD && frost_stands(f, other)) f->lives[link] = 1;
  }
  frost_derive(f); /* it may have closed what was open */
}

scree_result scree_frost_set_shard(scree_frost* f, uint32_t shard, scree_shard_state state) {
  if (shard >= f->view.shard_count || (uint32_t)state > SCREE_SHARD_CORE) return SCREE_ERROR_INVALID_ARGUMENT;
  settle(f);
  const scree_shard_state was = (scree_shard_state)f->states[shard];
  if (state == was) return SCREE_OK;
  if (state == SCREE_SHARD_AIR) {
    frost_take_shard(f, shard);
    frost_settle(f);
    return SCREE_OK;
  }
  const bool more_core = state == SCREE_SHARD_CORE && was == SCREE_SHARD_SOLID && f->stats.core > 0; /* all are held as they were */
  f->stats.solid += state == SCREE_SHARD_SOLID;
  f->stats.core += state == SCREE_SHARD_CORE;
  f->stats.solid -= was == SCREE_SHARD_SOLID;
  f->stats.core -= was == SCREE_SHARD_CORE;
  if (was == SCREE_SHARD_AIR)
    stand_again(f, shard, state);
  else
    f->states[shard] = (uint8_t)state;
  if (!more_core) frost_settle(f);
  return SCREE_OK;
}

scree_result scree_frost_set_life(scree_frost* f, uint32_t link, double life) {
  if (link >= f->view.interior_link_count || !(life >= 0) || !(life <= 1)) return SCREE_ERROR_INVALID_ARGUMENT;
  settle(f);
  if (life == 0) {
    frost_break_link(f, link);
    return SCREE_OK;
  }
  const uint32_t* sides = f->view.links[link].shards;
  if (!frost_stands(f, sides[0]) || !frost_stands(f, sides[1])) return SCREE_ERROR_INVALID_ARGUMENT;
  f->lives[link] = life;
  f->passage[link] = 1 - life * f->tables.resistance[link];
  if (f->apart) frost_settle(f); /* it may have made another component the largest */
  return SCREE_OK;
}

/* --- what there is ----------------------------------------------------------------------------------------------------------- */

void scree_frost_get_stats(const scree_frost* f, scree_frost_stats* out) {
  *out = f->stats;
  out->exterior_links = 0;
  out->volume = standing_volume(f);
  for (uint32_t l = 0; l < f->view.link_count; ++l) out->exterior_links += f->exterior[l];
}

void scree_frost_get(const scree_frost* f, scree_frost_view* out) {
  *out = (scree_frost_view){f->states, f->lives, f->exterior, f->view.shard_count, f->view.link_count};
}

uint64_t scree_frost_digest(const scree_frost* f) {
  uint64_t hash = hash_combine(f->view.shard_count, f->view.link_count);
  for (uint32_t s = 0; s < f->view.shard_count; ++s) hash = hash_combine(hash, f->states[s]);
  for (uint32_t l = 0; l < f->view.link_count; ++l) {
    uint64_t bits;
    memcpy(&bits, &f->lives[l], sizeof bits);
    hash = hash_combine(hash, bits);
    hash = hash_combine(hash, f->exterior[l]);
  }
  return hash;
}

uint32_t scree_frost_last_path(const scree_frost* f, uint32_t* links, double* water, uint32_t capacity) {
  const uint32_t count = frost_path_kept(f->path_length);
  for (uint32_t i = 0; i < count && i < capacity; ++i) {
    if (links != NULL) links[i] = f->path_links[i];
    if (water != NULL) water[i] = f->path_water[i];
  }
  return count;
}

uint32_t scree_frost_blocks(const scree_frost* f, const scree_block** blocks, const uint32_t** shards) {
  *blocks = f->blocks;
  *shards = f->block_shards;
  return f->stats.blocks;
}
