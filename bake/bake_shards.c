/* A recipe of shards to a pack: split, weather from time to time, let what fell come to rest, then make and encode all that stands
 * and lies, one job an asset; results by asset, so that neither the order nor the number of threads shows in the pack.
 *
 * Assets: what stands at each time, then blocks in the order in which they first lie somewhere. A block that lies otherwise at a
 * later time is another asset, since packs place blocks without turning them. */
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "allocator.h"
#include "bake_progress.h"
#include "clock.h"
#include "draco_encode.h"
#include "lattice.h"
#include "pack_format.h"
#include "pack_writer.h"
#include "plain_encode.h"
#include "recipe_text.h"
#include "shard_asset.h"
#include "shard_keys.h"
#include "shard_weather.h"

enum { STAGE_SHARDS, STAGE_FROST, STAGE_RUBBLE, STAGE_ASSETS, STAGE_ENCODE, STAGE_WRITE, STAGES };
#define NONE UINT32_MAX

enum { DEFAULT_LATTICE = 1000, LEAST_STEPS = 64 };

/* How much of a bake each stage is, for progress; frost and rubble take turns. */
static const double stage_ends[STAGES][2] = {{0, 0.2}, {0.2, 0.55}, {0.2, 0.55}, {0.55, 0.8}, {0.8, 0.98}, {0.98, 1}};
static const char* const stage_names[STAGES] = {"shards", "frost", "rubble", "assets", "encode", "write"};

/* A block as it lies. */
typedef struct resting {
  uint32_t block;
  uint32_t before; /* an earlier one of the same block, or NONE */
  double rotation[4];
} resting;

typedef struct shard_bake {
  const scree_shard_desc* desc;
  scree_shard_recipe recipe;
  scree_allocator allocator;
  shard_weather weather;
  scree_shards_view view;
  double origin[3];
  uint32_t lattice; /* steps a metre */
  uint32_t times;
  scree_frost_stats stats[SCREE_SHARD_TIMES];
  uint8_t* standing; /* times * shards: 1 where rock stands */
  uint32_t placement_first[SCREE_SHARD_TIMES + 1];
  scree_block_placement* placements;
  size_t placement_capacity;
  resting* blocks;
  size_t block_capacity;
  uint32_t block_count;
  uint32_t* last_of; /* of each block of frost, its last element of `blocks`, or NONE */
  size_t last_capacity;
  uint32_t asset_count, asset_capacity;
  shard_asset** assets; /* by asset */
  rock_record* rocks;
  model_record* models;
  uint32_t* cell_first;
  uint32_t* new_index; /* of each asset once dust is dropped, or NONE */
  uv_range uvs;
  atomic_uint done;      /* assets of this stage */
  scree_result* results; /* by asset */
  bake_progress progress;
  double seconds[STAGES];
  uint32_t stage;
} shard_bake;

/* part: of the stage. */
static bool report(shard_bake* bake, double part) {
  const double begin = stage_ends[bake->stage][0], end = stage_ends[bake->stage][1];
  return bake_progress_tell(&bake->progress, stage_names[bake->stage], begin + (end - begin) * (part < 1 ? part : 1));
}

/* What shards report is a stage of its own each; this one only has to go on. */
static bool report_shards(void* user, const char* stage, double done) {
  (void)stage;
  return report(user, done);
}

typedef struct time_progress {
  shard_bake* bake;
  uint32_t time;
} time_progress;

static bool report_time(void* user, double done) {
  const time_progress* at = user;
  const double part = at->bake->stage == STAGE_FROST ? 0.4 * done : 0.4 + 0.6 * done;
  return report(at->bake, (at->time + part) / at->bake->times);
}

static scree_result grow(shard_bake* bake, void** array, size_t* capacity, size_t needed, size_t size) {
  if (needed <= *capacity) return SCREE_OK;
  const size_t larger = needed > *capacity * 2 ? needed : *capacity * 2;
  void* grown = scree_rt_allocate(&bake->allocator, larger, size);
  if (grown == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  if (*array != NULL) memcpy(grown, *array, *capacity * size);
  scree_rt_release(&bake->allocator, *array, *capacity, size);
  *array = grown;
  *capacity = larger;
  return SCREE_OK;
}

static scree_result choose_lattice(shard_bake* bake, scree_error* error) {
  shard_asset_origin(bake->weather.shards, bake->recipe.rubble.ground, bake->origin);
  const double finest = shard_asset_lattice(bake->weather.shards, bake->origin);
  const uint32_t wanted = bake->recipe.lattice_per_metre;
  double across = 0;
  for (int a = 0; a < 3; ++a) across = fmax(across, bake->view.max[a] - bake->view.min[a]);
  if (!(finest >= 1)) {
    recipe_say(
        error,
        "input: what is %g metres across does not fit on the lattice of a pack; expected 16383 at most along x, y and z from "
        "the middle of its ground",
        across);
    return SCREE_ERROR_RANGE;
  }
  if (!(across * finest >= LEAST_STEPS)) {
    recipe_say(error, "input: what is %g metres across is too small for the lattice of a pack; expected at least %g", across,
               LEAST_STEPS / finest);
    return SCREE_ERROR_RANGE;
  }
  if (wanted > finest) {
    recipe_say(error, "lattice_per_metre: %u steps a metre are too fine for what is baked; expected at most %.0f", wanted, finest);
    return SCREE_ERROR_RANGE;
  }
  bake->lattice = wanted > 0 ? wanted : finest < DEFAULT_LATTICE ? (uint32_t)finest : DEFAULT_LATTICE;
  return SCREE_OK;
}

/* --- weather ---------------------------------------------------------------------------------------------------------------- */

/* The element of `blocks` for a block with this rotation, a new one if there is none. */
static scree_result find_block(shard_bake* bake, const scree_resting_block* at, uint32_t* out) {
  for (uint32_t b = bake->last_of[at->block]; b != NONE; b = bake->blocks[b].before) {
    const double* r = bake->blocks[b].rotation;
    if (r[0] != at->rotation[0] || r[1] != at->rotation[1] || r[2] != at->rotation[2] || r[3] != at->rotation[3]) continue;
    *out = b;
    return SCREE_OK;
  }
  const scree_result result =
      grow(bake, (void**)&bake->blocks, &bake->block_capacity, (size_t)bake->block_count + 1, sizeof *bake->blocks);
  if (result != SCREE_OK) return result;
  resting* block = &bake->blocks[bake->block_count];
  *block = (resting){.block = at->block, .before = bake->last_of[at->block]};
  memcpy(block->rotation, at->rotation, sizeof block->rotation);
  *out = bake->last_of[at->block] = bake->block_count++;
  return SCREE_OK;
}

static scree_result place_blocks(shard_bake* bake, uint32_t time, const scree_rubble* rubble) {
  const scree_resting_block* resting_blocks;
  const uint32_t count = scree_rubble_get(rubble, &resting_blocks);
  const uint32_t first = bake->placement_first[time];
  scree_result result =
      grow(bake, (void**)&bake->placements, &bake->placement_capacity, (size_t)first + count, sizeof *bake->placements);
  for (uint32_t i = 0; i < count && result == SCREE_OK; ++i) {
    const scree_resting_block* at = &resting_blocks[i];
    uint32_t block;
    result = find_block(bake, at, &block);
    if (result != SCREE_OK) break;
    scree_block_placement* placement = &bake->placements[first + i];
    placement->asset = bake->times + block;
    for (int a = 0; a < 3; ++a) placement->translation[a] = (float)(at->translation[a] - bake->origin[a]);
  }
  bake->placement_first[time + 1] = first + count;
  return result;
}

static scree_result settle(shard_bake* bake, uint32_t time, scree_error* error) {
  bake->placement_first[time + 1] = bake->placement_first[time];
  const scree_block* blocks;
  const uint32_t* list;
  const uint32_t fallen = scree_frost_blocks(bake->weather.frost, &blocks, &list);
  if (fallen == 0) return SCREE_OK;
  const size_t before = bake->last_capacity;
  scree_result result = grow(bake, (void**)&bake->last_of, &bake->last_capacity, fallen, sizeof *bake->last_of);
  if (result != SCREE_OK) return result;
  for (size_t b = before; b < bake->last_capacity; ++b) bake->last_of[b] = NONE;
  time_progress progress = {bake, time};
  scree_rubble_desc desc;
  shard_weather_rubble(&bake->weather, &desc);
  desc.allocator = bake->allocator;
  desc.progress = report_time;
  desc.progress_user = &progress;
  scree_rubble* rubble;
  scree_error fault = {{0}};
  result = scree_rubble_create(&desc, &rubble, &fault);
  if (result != SCREE_OK) {
    if (fault.message[0] != '\0') recipe_say(error, "rubble: %.400s", fault.message);
    return result;
  }
  result = place_blocks(bake, time, rubble);
  scree_rubble_destroy(rubble);
  return result;
}

static scree_result weather_all(shard_bake* bake, scree_error* error) {
  const size_t shards = bake->view.shard_count;
  scree_result result = shard_weather_start(&bake->weather, error);
  for (uint32_t time = 0; time < bake->times && result == SCREE_OK; ++time) {
    time_progress progress = {bake, time};
    double start = clock_seconds();
    bake->stage = STAGE_FROST;
    result = shard_weather_advance(&bake->weather, time, report_time, &progress, &bake->stats[time], error);
    bake->seconds[STAGE_FROST] += clock_seconds() - start;
    if (result != SCREE_OK) break;
    scree_frost_view view;
    scree_frost_get(bake->weather.frost, &view);
    for (size_t s = 0; s < shards; ++s) bake->standing[time * shards + s] = view.states[s] != SCREE_SHARD_AIR;
    start = clock_seconds();
    bake->stage = STAGE_RUBBLE;
    result = settle(bake, time, error);
    bake->seconds[STAGE_RUBBLE] += clock_seconds() - start;
  }
  return result;
}

/* --- assets ------------------------------------------------------------------------------------------------------------------ */

static void finish(shard_bake* bake, uint32_t asset, scree_result result) {
  bake->results[asset] = result;
  if (result != SCREE_OK)
    atomic_store(&bake->progress.stopped, true);
  else
    report(bake, (atomic_fetch_add(&bake->done, 1) + 1.0) / bake->asset_count);
}

static void make_asset(void* context, uint32_t index, uint32_t worker) {
  shard_bake* bake = context;
  (void)worker;
  if (atomic_load(&bake->progress.stopped)) return;
  const scree_allocator* allocator = &bake->allocator;
  const size_t shards = bake->view.shard_count;
  shard_asset_desc desc = {.shards = bake->weather.shards,
                           .steps_per_metre = bake->lattice,
                           .lods = bake->recipe.lod_levels,
                           .joints = bake->recipe.seeds.kind == SCREE_SEEDS_COLUMNS,
                           .block = index >= bake->times};
  uint8_t* inside = NULL;
  scree_result result = SCREE_OK;
  if (index < bake->times) {
    desc.inside = bake->standing + index * shards;
    memcpy(desc.origin, bake->origin, sizeof desc.origin);
  } else {
    const resting* at = &bake->blocks[index - bake->times];
    const scree_block* blocks;
    const uint32_t* list;
    scree_frost_blocks(bake->weather.frost, &blocks, &list);
    const scree_block* block = &blocks[at->block];
    inside = scree_rt_allocate_zeroed(allocator, shards, 1);
    if (inside == NULL) result = SCREE_ERROR_OUT_OF_MEMORY;
    for (uint32_t s = 0; s < block->shard_count && inside != NULL; ++s) inside[list[block->first_shard + s]] = 1;
    desc.inside = inside;
    memcpy(desc.origin, block->centroid, sizeof desc.origin);
    memcpy(desc.rotation, at->rotation, sizeof desc.rotation);
  }
  shard_asset* asset = result == SCREE_OK ? scree_rt_allocate(allocator, 1, sizeof *asset) : NULL;
  if (result == SCREE_OK && asset == NULL) result = SCREE_ERROR_OUT_OF_MEMORY;
  if (result == SCREE_OK) result = shard_asset_make(&desc, allocator, asset);
  if (result == SCREE_OK)
    bake->assets[index] = asset;
  else
    scree_rt_release(allocator, asset, 1, sizeof *asset);
  scree_rt_release(allocator, inside, shards, 1);
  /* A sliver that the lattice makes flat is dust; drop_dust looks for it. */
  if (result == SCREE_ERROR_INVALID_ARGUMENT && index >= bake->times) result = SCREE_OK;
  finish(bake, index, result);
}

static scree_result copy_hulls(const shard_bake* bake, const shard_asset* asset, rock_record* rock, model_record* model) {
  const scree_allocator* allocator = &bake->allocator;
  rock->hull = scree_rt_allocate(allocator, asset->hull_count, sizeof *rock->hull);
  model->part_first = scree_rt_allocate_zeroed(allocator, (size_t)asset->part_count + 1, sizeof *model->part_first);
  model->part_count = asset->part_count;
  rock->hull_count = asset->hull_count;
  if (rock->hull == NULL || model->part_first == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  memcpy(rock->hull, asset->hull, asset->hull_count * sizeof *rock->hull);
  for (uint32_t p = 0; p < asset->part_count; ++p) model->part_first[p + 1] = model->part_first[p] + asset->parts[p].hull_count;
  model->parts = scree_rt_allocate(allocator, model->part_first[asset->part_count], sizeof *model->parts);
  if (model->parts == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  for (uint32_t p = 0; p < asset->part_count; ++p)
    memcpy(model->parts[model->part_first[p]], asset->parts[p].hull, asset->parts[p].hull_count * sizeof *model->parts);
  return SCREE_OK;
}

static void encode_asset(void* context, uint32_t index, uint32_t worker) {
  shard_bake* bake = context;
  (void)worker;
  if (atomic_load(&bake->progress.stopped)) return;
  const shard_asset* asset = bake->assets[index];
  rock_record* rock = &bake->rocks[index];
  model_record* model = &bake->models[index];
  const bool stands = index < bake->times;
  rock->cell = stands ? 0 : index - bake->times + 1;
  rock->seed = stands ? index : 0;
  rock->burial = SCREE_BURIAL_NEVER;
  memcpy(rock->bounds_min, asset->bounds_min, sizeof rock->bounds_min);
  memcpy(rock->bounds_max, asset->bounds_max, sizeof rock->bounds_max);
  memcpy(rock->centroid, asset->centroid, sizeof rock->centroid);
  rock->volume = asset->volume;
  rock->inner_radius = asset->inner_radius;
  rock->outer_radius = asset->outer_radius;
  model->footprint = asset->footprint;
  model->height = asset->height;
  if (stands) {
    const scree_frost_stats* stats = &bake->stats[index];
    model->share = (float)(stats->volume / stats->start_volume);
    model->steps = stats->paths < UINT32_MAX ? (uint32_t)stats->paths : UINT32_MAX;
  } else {
    const scree_block* blocks;
    const uint32_t* list;
    scree_frost_blocks(bake->weather.frost, &blocks, &list);
    const scree_block* block = &blocks[bake->blocks[index - bake->times].block];
    model->share = (float)(block->volume / bake->stats[0].start_volume);
    model->steps = block->path < UINT32_MAX ? (uint32_t)block->path : UINT32_MAX;
  }
  scree_result result = copy_hulls(bake, asset, rock, model);
  for (uint32_t level = 0; level < bake->recipe.lod_levels && result == SCREE_OK; ++level) {
    lattice_mesh mesh = asset->lods[level].mesh;
    mesh.error = asset->lods[level].error_of_most;
    mesh.uv_bounds = bake->uvs;
    const bool coarsest = level + 1 == bake->recipe.lod_levels;
    result = (coarsest ? plain_encode : draco_encode)(&mesh, &bake->allocator, &rock->lods[level]);
    rock->lods[level].error = mesh.error;
  }
  finish(bake, index, result);
}

static scree_result run_stage(shard_bake* bake, uint32_t stage, void (*job)(void*, uint32_t, uint32_t), scree_error* error) {
  const scree_jobs* jobs = &bake->desc->jobs;
  const double start = clock_seconds();
  bake->stage = stage;
  atomic_store(&bake->done, 0);
  if (jobs->parallel_for != NULL && jobs->worker_count > 1)
    jobs->parallel_for(jobs->user, bake->asset_count, job, bake);
  else
    for (uint32_t i = 0; i < bake->asset_count; ++i) job(bake, i, 0);
  bake->seconds[stage] = clock_seconds() - start;
  if (atomic_load(&bake->progress.cancelled)) return SCREE_ERROR_CANCELLED;
  uint32_t failed = 0;
  while (failed < bake->asset_count && bake->results[failed] == SCREE_OK) ++failed;
  if (failed == bake->asset_count) return SCREE_OK;
  const char* what = stage == STAGE_ASSETS ? "a model" : "encoded";
  const char* why = scree_result_string(bake->results[failed]);
  if (failed < bake->times)
    recipe_say(error, "time %u: what stands cannot be %s: %s", failed, what, why);
  else
    recipe_say(error, "block %u: it cannot be %s: %s", bake->blocks[failed - bake->times].block, what, why);
  return bake->results[failed];
}

/* Blocks that are no assets are gone, with their placements. */
static void drop_dust(shard_bake* bake) {
  uint32_t kept = bake->times, placed = 0;
  for (uint32_t i = bake->times; i < bake->asset_count; ++i) {
    shard_asset* asset = bake->assets[i];
    bake->assets[i] = NULL;
    bake->new_index[i] = asset != NULL ? kept : NONE;
    if (asset == NULL) continue;
    bake->blocks[kept - bake->times] = bake->blocks[i - bake->times];
    bake->assets[kept++] = asset;
  }
  for (uint32_t t = 0, p = 0; t < bake->times; ++t) {
    const uint32_t end = bake->placement_first[t + 1];
    for (; p < end; ++p) {
      const uint32_t asset = bake->new_index[bake->placements[p].asset];
      if (asset == NONE) continue;
      bake->placements[placed] = bake->placements[p];
      bake->placements[placed++].asset = asset;
    }
    bake->placement_first[t + 1] = placed;
  }
  bake->asset_count = kept;
  bake->block_count = kept - bake->times;
}

static scree_result make_assets(shard_bake* bake, scree_error* error) {
  const scree_allocator* allocator = &bake->allocator;
  bake->asset_count = bake->asset_capacity = bake->times + bake->block_count;
  bake->assets = scree_rt_allocate_zeroed(allocator, bake->asset_count, sizeof *bake->assets);
  bake->rocks = scree_rt_allocate_zeroed(allocator, bake->asset_count, sizeof *bake->rocks);
  bake->models = scree_rt_allocate_zeroed(allocator, bake->asset_count, sizeof *bake->models);
  bake->results = scree_rt_allocate_zeroed(allocator, bake->asset_count, sizeof *bake->results);
  bake->new_index = scree_rt_allocate(allocator, bake->asset_count, sizeof *bake->new_index);
  bake->cell_first = scree_rt_allocate(allocator, (size_t)bake->asset_count + 1, sizeof *bake->cell_first);
  if (bake->assets == NULL || bake->rocks == NULL || bake->models == NULL || bake->results == NULL || bake->new_index == NULL ||
      bake->cell_first == NULL)
    return SCREE_ERROR_OUT_OF_MEMORY;
  scree_result result = run_stage(bake, STAGE_ASSETS, make_asset, error);
  if (result != SCREE_OK) return result;
  drop_dust(bake);
  bake->cell_first[0] = 0;
  for (uint32_t c = 0; c <= bake->block_count; ++c) bake->cell_first[c + 1] = bake->times + c;
  for (int a = 0; a < 2; ++a) {
    bake->uvs.min[a] = bake->assets[0]->uv_min[a];
    bake->uvs.max[a] = bake->assets[0]->uv_max[a];
    for (uint32_t i = 1; i < bake->asset_count; ++i) {
      bake->uvs.min[a] = fminf(bake->uvs.min[a], bake->assets[i]->uv_min[a]);
      bake->uvs.max[a] = fmaxf(bake->uvs.max[a], bake->assets[i]->uv_max[a]);
    }
  }
  return run_stage(bake, STAGE_ENCODE, encode_asset, error);
}

/* --- pack ------------------------------------------------------------------------------------------------------------------- */

static scree_result write_pack(shard_bake* bake, uint8_t** bytes, size_t* size) {
  const scree_allocator* allocator = &bake->allocator;
  const double start = clock_seconds();
  const size_t text_size = scree_shard_recipe_write(&bake->recipe, NULL, 0) + 1;
  char* text = scree_rt_allocate(allocator, text_size, 1);
  if (text == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  scree_shard_recipe_write(&bake->recipe, text, text_size);
  const cliff_record cliff = {
      .time_count = bake->times, .placement_first = bake->placement_first, .placements = bake->placements, .uvs = bake->uvs};
  const rock_set set = {.lattice_per_cell = bake->lattice,
                        .lod_count = bake->recipe.lod_levels,
                        .cell_count = 1 + bake->block_count,
                        .rock_count = bake->asset_count,
                        .cell_first = bake->cell_first,
                        .rocks = bake->rocks,
                        .models = bake->models,
                        .cliff = &cliff,
                        .recipe = text};
  const scree_result result = pack_write(&set, allocator, bytes, size);
  scree_rt_release(allocator, text, text_size, 1);
  bake->seconds[STAGE_WRITE] = clock_seconds() - start;
  return result;
}

static void fill_report(const shard_bake* bake, size_t size, double seconds, scree_shard_report* out) {
  const scree_frost_stats* last = &bake->stats[bake->times - 1];
  memset(out, 0, sizeof *out);
  out->bake.rocks = bake->asset_count;
  for (uint32_t i = 0; i < bake->asset_count; ++i)
    for (uint32_t level = 0; level < bake->recipe.lod_levels; ++level)
      out->bake.lod_triangles[level] += bake->rocks[i].lods[level].triangle_count;
  for (uint32_t level = 0; level < bake->recipe.lod_levels; ++level) out->bake.triangles += out->bake.lod_triangles[level];
  for (int s = 0; s < STAGES; ++s) out->bake.stages[out->bake.stage_count++] = (scree_bake_stage){stage_names[s], bake->seconds[s]};
  out->bake.bytes = size;
  out->bake.seconds = seconds;
  out->shards = bake->view.shard_count;
  out->interior_links = bake->view.interior_link_count;
  out->exterior_links = bake->view.link_count - bake->view.interior_link_count;
  out->times = bake->times;
  out->blocks = bake->block_count;
  out->placements = bake->placement_first[bake->times];
  out->paths = last->paths;
  out->breaks = last->breaks;
  out->share = last->volume / last->start_volume;
  out->idle_states = bake->weather.idle_states;
}

static void release(shard_bake* bake) {
  const scree_allocator* allocator = &bake->allocator;
  for (uint32_t i = 0; i < bake->asset_capacity; ++i) {
    if (bake->assets != NULL && bake->assets[i] != NULL) {
      shard_asset_destroy(bake->assets[i], allocator);
      scree_rt_release(allocator, bake->assets[i], 1, sizeof **bake->assets);
    }
    if (bake->rocks == NULL || bake->models == NULL) continue;
    rock_record* rock = &bake->rocks[i];
    model_record* model = &bake->models[i];
    scree_rt_release(allocator, rock->hull, rock->hull_count, sizeof *rock->hull);
    for (uint32_t l = 0; l < ROCK_MAX_LODS; ++l) scree_rt_release(allocator, rock->lods[l].blob, rock->lods[l].blob_size, 1);
    if (model->parts != NULL) scree_rt_release(allocator, model->parts, model->part_first[model->part_count], sizeof *model->parts);
    scree_rt_release(allocator, model->part_first, (size_t)model->part_count + 1, sizeof *model->part_first);
  }
  scree_rt_release(allocator, bake->assets, bake->asset_capacity, sizeof *bake->assets);
  scree_rt_release(allocator, bake->rocks, bake->asset_capacity, sizeof *bake->rocks);
  scree_rt_release(allocator, bake->models, bake->asset_capacity, sizeof *bake->models);
  scree_rt_release(allocator, bake->results, bake->asset_capacity, sizeof *bake->results);
  scree_rt_release(allocator, bake->new_index, bake->asset_capacity, sizeof *bake->new_index);
  scree_rt_release(allocator, bake->cell_first, (size_t)bake->asset_capacity + 1, sizeof *bake->cell_first);
  scree_rt_release(allocator, bake->last_of, bake->last_capacity, sizeof *bake->last_of);
  scree_rt_release(allocator, bake->blocks, bake->block_capacity, sizeof *bake->blocks);
  scree_rt_release(allocator, bake->placements, bake->placement_capacity, sizeof *bake->placements);
  scree_rt_release(allocator, bake->standing, (size_t)bake->times * bake->view.shard_count, 1);
  shard_weather_destroy(&bake->weather);
}

static scree_result run(shard_bake* bake, uint8_t** bytes, size_t* size, scree_error* error) {
  const double start = clock_seconds();
  scree_result result = shard_weather_create(bake->desc, report_shards, bake, &bake->weather, error);
  bake->seconds[STAGE_SHARDS] = clock_seconds() - start;
  if (result != SCREE_OK) return result;
  scree_shards_get(bake->weather.shards, &bake->view);
  bake->standing = scree_rt_allocate(&bake->allocator, (size_t)bake->times * bake->view.shard_count, 1);
  if (bake->standing == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  result = choose_lattice(bake, error);
  if (result == SCREE_OK) result = weather_all(bake, error);
  if (result == SCREE_OK) result = make_assets(bake, error);
  bake->stage = STAGE_WRITE;
  if (result == SCREE_OK) {
    result = write_pack(bake, bytes, size);
    if (result == SCREE_ERROR_RANGE || result == SCREE_ERROR_INVALID_ARGUMENT)
      recipe_say(error, "what was made does not fit into a pack: what stands and every block have to lie within %d metres",
                 PACK_MAX_MODEL_REACH);
  }
  if (result == SCREE_OK && !report(bake, 1)) result = SCREE_ERROR_CANCELLED;
  return result;
}

scree_result scree_shards_bake(const scree_shard_desc* desc, uint8_t** bytes, size_t* size, scree_shard_report* report_out,
                               scree_error* error) {
  const double start = clock_seconds();
  *bytes = NULL;
  *size = 0;
  if (error != NULL) memset(error, 0, sizeof *error);
  scree_result result = shard_check_all(desc->recipe, error);
  if (result != SCREE_OK) return result;
  const scree_allocator allocator = scree_rt_allocator_or_default(&desc->allocator);
  shard_bake* bake = scree_rt_allocate_zeroed(&allocator, 1, sizeof *bake);
  if (bake == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  scree_shard_desc own = *desc;
  bake->recipe = *desc->recipe;
  own.recipe = &bake->recipe;
  own.allocator = allocator;
  bake->desc = &own;
  bake->allocator = allocator;
  bake->times = shard_times(&bake->recipe);
  bake_progress_begin(&bake->progress, desc->progress, desc->progress_user);
  result = run(bake, bytes, size, error);
  if (result == SCREE_OK && report_out != NULL) {
    fill_report(bake, *size, clock_seconds() - start, report_out);
    report_out->bake.digest = pack_bytes_digest(*bytes);
  }
  if (result != SCREE_OK) {
    scree_shards_bake_free(desc, *bytes, *size);
    *bytes = NULL;
    *size = 0;
  }
  release(bake);
  scree_rt_release(&allocator, bake, 1, sizeof *bake);
  return result;
}

void scree_shards_bake_free(const scree_shard_desc* desc, uint8_t* bytes, size_t size) {
  const scree_allocator allocator = scree_rt_allocator_or_default(&desc->allocator);
  scree_rt_release(&allocator, bytes, size, 1);
}
