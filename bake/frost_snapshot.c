/* Snapshots: the state, without what follows from it. */
#include <string.h>

#include "frost_internal.h"

struct scree_frost_snapshot {
  uint8_t* states;
  double* lives;
  scree_block* blocks;
  uint32_t* block_shards;
  uint32_t block_shard_count, unchecked, path_length, rules_set;
  bool unsettled, apart;
  random_stream stream;
  scree_frost_stats stats;
  uint32_t* path_links;
  double* path_water;
};

/* A copy, or NULL where there is nothing to copy or no memory, which `enough` then tells. */
static void* copy(const scree_frost* f, const void* from, size_t count, size_t size, bool* enough) {
  if (count == 0) return NULL;
  void* to = scree_rt_allocate(&f->allocator, count, size);
  if (to == NULL) *enough = false;
  if (to != NULL) memcpy(to, from, count * size);
  return to;
}

static void release(const scree_frost* f, scree_frost_snapshot* s) {
  scree_rt_release(&f->allocator, s->states, f->view.shard_count, sizeof *s->states);
  scree_rt_release(&f->allocator, s->lives, f->view.interior_link_count, sizeof *s->lives);
  scree_rt_release(&f->allocator, s->blocks, s->stats.blocks, sizeof *s->blocks);
  scree_rt_release(&f->allocator, s->block_shards, s->block_shard_count, sizeof *s->block_shards);
  scree_rt_release(&f->allocator, s->path_links, frost_path_kept(s->path_length), sizeof *s->path_links);
  scree_rt_release(&f->allocator, s->path_water, frost_path_kept(s->path_length), sizeof *s->path_water);
  scree_rt_release(&f->allocator, s, 1, sizeof *s);
}

void scree_frost_forget(scree_frost* f, scree_frost_snapshot* s) {
  if (s != NULL) release(f, s);
}

scree_result scree_frost_save(const scree_frost* f, scree_frost_snapshot** out) {
  *out = NULL;
  scree_frost_snapshot* s = scree_rt_allocate_zeroed(&f->allocator, 1, sizeof *s);
  if (s == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  s->block_shard_count = f->block_shard_count;
  s->unchecked = f->unchecked;
  s->path_length = f->path_length;
  s->rules_set = f->rules_set;
  s->unsettled = f->unsettled;
  s->apart = f->apart;
  s->stream = f->stream;
  s->stats = f->stats;
  bool enough = true;
  s->states = copy(f, f->states, f->view.shard_count, sizeof *s->states, &enough);
  s->lives = copy(f, f->lives, f->view.interior_link_count, sizeof *s->lives, &enough); /* exterior links have none */
  s->blocks = copy(f, f->blocks, f->stats.blocks, sizeof *s->blocks, &enough);
  s->block_shards = copy(f, f->block_shards, f->block_shard_count, sizeof *s->block_shards, &enough);
  s->path_links = copy(f, f->path_links, frost_path_kept(f->path_length), sizeof *s->path_links, &enough);
  s->path_water = copy(f, f->path_water, frost_path_kept(f->path_length), sizeof *s->path_water, &enough);
  if (!enough) {
    release(f, s);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  *out = s;
  return SCREE_OK;
}

static void copy_back(void* to, const void* from, size_t bytes) {
  if (bytes > 0) memcpy(to, from, bytes);
}

void scree_frost_restore(scree_frost* f, const scree_frost_snapshot* s) {
  const size_t memory = f->stats.memory; /* that of the rules of now */
  copy_back(f->states, s->states, f->view.shard_count * sizeof *s->states);
  copy_back(f->lives, s->lives, f->view.interior_link_count * sizeof *s->lives);
  copy_back(f->blocks, s->blocks, s->stats.blocks * sizeof *s->blocks);
  copy_back(f->block_shards, s->block_shards, s->block_shard_count * sizeof *s->block_shards);
  copy_back(f->path_links, s->path_links, frost_path_kept(s->path_length) * sizeof *s->path_links);
  copy_back(f->path_water, s->path_water, frost_path_kept(s->path_length) * sizeof *s->path_water);
  f->block_shard_count = s->block_shard_count;
  f->unchecked = s->unchecked;
  f->path_length = s->path_length;
  f->stream = s->stream;
  f->stats = s->stats;
  f->stats.memory = memory;
  f->apart = s->apart;
  f->unsettled = s->unsettled || s->rules_set != f->rules_set;
  frost_derive(f);
}
