/* All models of a recipe: one job a variant, which is weathered from age to age; results by model, so that neither the order nor
 * the number of threads shows in the pack. */
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "allocator.h"
#include "bake_progress.h"
#include "clock.h"
#include "draco_encode.h"
#include "hoodoo_model.h"
#include "hoodoo_recipe.h"
#include "pack_format.h"
#include "pack_writer.h"
#include "plain_encode.h"
#include "recipe_text.h"
#include "weather_asset.h"

enum { STAGE_START, STAGE_WEATHER, STAGE_SURFACE, STAGE_ENCODE, STAGES };

typedef struct hoodoo_worker {
  double seconds[STAGES];
} hoodoo_worker;

typedef struct hoodoo_bake {
  const scree_hoodoo_desc* desc;
  scree_hoodoo_recipe recipe;
  scree_allocator allocator;
  scree_jobs inner;       /* for the steps of one variant */
  size_t memory_limit;    /* of one simulation */
  uint32_t ages;          /* of a variant */
  uint32_t lattice;       /* steps a voxel */
  uint32_t steps_a_metre; /* of the lattice */
  rock_record* rocks;     /* by variant x age */
  model_record* models;
  hoodoo_worker* workers;
  scree_result* results; /* by variant */
  scree_error* errors;   /* by variant */
  atomic_uint done;      /* models */
  bake_progress progress;
} hoodoo_bake;

/* A variant on its way. */
typedef struct variant_run {
  hoodoo_bake* bake;
  uint32_t variant, next_phase;
  scree_weather* weather;
  scree_mesher* mesher;
  scree_hoodoo_rules rules; /* that hold now */
} variant_run;

static scree_result fail(const variant_run* run, scree_result result, const char* what) {
  char* message = run->bake->errors[run->variant].message;
  if (message[0] == '\0') recipe_say(&run->bake->errors[run->variant], "variant %u: %s", run->variant, what);
  return result;
}

/* part: of a model that is not done yet. */
static bool report(hoodoo_bake* bake, double part) {
  return bake_progress_tell(&bake->progress, "weather",
                            (atomic_load(&bake->done) + part) / (bake->recipe.variants * (double)bake->ages));
}

static bool report_step(void* user, double done) {
  return report(user, done * 0.9);
}

static bool worn_down_to(const scree_weather_stats* stats, double share) {
  return (double)stats->rock <= share * (double)stats->start_rock;
}

/* Whether a moment has come: a share of the rock, or steps where it is below 0. */
static bool has_come(const scree_weather_stats* stats, double share, uint32_t steps) {
  return share < 0 ? stats->step >= steps : worn_down_to(stats, share);
}

static void change_rules(scree_hoodoo_rules* rules, const scree_hoodoo_phase* phase) {
  const scree_hoodoo_rules* from = &phase->rules;
  if (phase->changes & SCREE_HOODOO_DURABILITY) {
    memcpy(rules->durability, from->durability, sizeof rules->durability);
    rules->durability_count = from->durability_count;
  }
  if (phase->changes & SCREE_HOODOO_BUBBLES) {
    memcpy(rules->bubbles, from->bubbles, sizeof rules->bubbles);
    rules->bubble_count = from->bubble_count;
  }
  if (phase->changes & SCREE_HOODOO_SPHEROIDAL) rules->spheroidal = from->spheroidal;
  if (phase->changes & SCREE_HOODOO_CAVERNOUS) rules->cavernous = from->cavernous;
  if (phase->changes & SCREE_HOODOO_EXPOSURE) rules->exposure = from->exposure;
  if (phase->changes & SCREE_HOODOO_STEPS_PER_VOXEL) rules->steps_per_voxel = from->steps_per_voxel;
  if (phase->changes & SCREE_HOODOO_COLLUVIUM) {
    rules->colluvium_share = from->colluvium_share;
    rules->colluvium_durability = from->colluvium_durability;
    rules->repose = from->repose;
  }
  if (phase->changes & SCREE_HOODOO_ROCKFALL) rules->rockfall = from->rockfall;
}

/* Begins the phases whose moment has come. */
static scree_result begin_phases(variant_run* run, const scree_weather_stats* stats) {
  const scree_hoodoo_recipe* recipe = &run->bake->recipe;
  const uint32_t before = run->next_phase;
  for (; run->next_phase < recipe->phase_count; ++run->next_phase) {
    const scree_hoodoo_phase* phase = &recipe->phases[run->next_phase];
    if (!has_come(stats, phase->share, phase->steps)) break;
    change_rules(&run->rules, phase);
  }
  if (run->next_phase == before) return SCREE_OK;
  scree_weather_rules rules;
  scree_hoodoo_rules_view(&run->rules, &rules);
  scree_error error = {{0}};
  const scree_result result = scree_weather_set_rules(run->weather, &rules, &error);
  if (result == SCREE_OK) return result;
  recipe_say(&run->bake->errors[run->variant], "phases[%u]: %.400s", run->next_phase - 1, error.message);
  return result;
}

/* Weathers up to an age. */
static scree_result advance(variant_run* run, uint32_t age, scree_weather_stats* stats) {
  hoodoo_bake* bake = run->bake;
  const scree_hoodoo_recipe* recipe = &bake->recipe;
  const double share = recipe->age_count > 0 ? recipe->ages[age] : -1;
  const uint32_t steps = recipe->age_count > 0 ? recipe->max_steps : recipe->age_steps[age];
  for (;;) {
    scree_weather_get_stats(run->weather, stats);
    scree_result result = begin_phases(run, stats);
    if (result != SCREE_OK) return result;
    if (stats->rock == 0) {
      recipe_say(&bake->errors[run->variant], "variant %u: no rock is left after %llu steps, before age %u", run->variant,
                 (unsigned long long)stats->step, age);
      return SCREE_ERROR_INVALID_ARGUMENT;
    }
    if (has_come(stats, share, steps)) return SCREE_OK;
    if (stats->step >= recipe->max_steps) {
      recipe_say(&bake->errors[run->variant], "variant %u: ages[%u]: %g is not reached in max_steps, %u: a share of %.3f is left",
                 run->variant, age, share, recipe->max_steps, (double)stats->rock / (double)stats->start_rock);
      return SCREE_ERROR_RANGE;
    }
    double next_share = share < 0 ? 0 : share;
    uint32_t next_step = steps;
    if (run->next_phase < recipe->phase_count) {
      const scree_hoodoo_phase* phase = &recipe->phases[run->next_phase];
      if (phase->share < 0 && phase->steps < next_step) next_step = phase->steps;
      if (phase->share > next_share) next_share = phase->share;
    }
    result = scree_weather_run(run->weather, next_share, next_step - (uint32_t)stats->step, report_step, bake);
    if (result != SCREE_OK) return result;
  }
}

static scree_result copy_hull(const hoodoo_bake* bake, const weather_asset* asset, rock_record* rock) {
  rock->hull = scree_rt_allocate(&bake->allocator, asset->hull_count, sizeof *rock->hull);
  if (rock->hull == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  rock->hull_count = asset->hull_count;
  memcpy(rock->hull, asset->hull, asset->hull_count * sizeof *rock->hull);
  return SCREE_OK;
}

/* The parts; or the one hull for all of them. */
static scree_result copy_parts(const hoodoo_bake* bake, const weather_asset* asset, model_record* model) {
  const uint32_t count = bake->recipe.parts ? asset->part_count : 1;
  model->part_first = scree_rt_allocate(&bake->allocator, (size_t)count + 1, sizeof *model->part_first);
  if (model->part_first == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  model->part_count = count;
  model->part_first[0] = 0;
  for (uint32_t p = 0; p < count; ++p)
    model->part_first[p + 1] = model->part_first[p] + (bake->recipe.parts ? asset->parts[p].hull_count : asset->hull_count);
  model->parts = scree_rt_allocate(&bake->allocator, model->part_first[count], sizeof *model->parts);
  if (model->parts == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  for (uint32_t p = 0; p < count; ++p) {
    const uint32_t first = model->part_first[p], end = model->part_first[p + 1];
    memcpy(model->parts[first], bake->recipe.parts ? asset->parts[p].hull : asset->hull, (end - first) * sizeof *model->parts);
  }
  return SCREE_OK;
}

/* To 64 levels of durability and 31 of curvature: what no eye tells apart is not worth a sixth of the pack. Level stays level. */
static void round_surface(lattice_mesh* mesh) {
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    uint8_t* bytes = mesh->surface[v];
    const int durability = (bytes[1] + 2) / 4 * 4, curvature = (bytes[2] + 4) / 8 * 8; /* 128 is a multiple of both */
    bytes[1] = (uint8_t)(durability < 255 ? durability : 255);
    bytes[2] = (uint8_t)(curvature < 8 ? 8 : curvature > 248 ? 248 : curvature);
  }
}

static scree_result keep_model(const variant_run* run, uint32_t age, const scree_weather_stats* stats, const weather_asset* asset,
                               rock_record* rock, model_record* model) {
  const hoodoo_bake* bake = run->bake;
  const float metres = (float)((double)bake->lattice / bake->steps_a_metre); /* a voxel */
  rock->cell = run->variant;
  rock->seed = age;
  rock->burial = SCREE_BURIAL_NEVER;
  memcpy(rock->bounds_min, asset->bounds_min, sizeof rock->bounds_min);
  memcpy(rock->bounds_max, asset->bounds_max, sizeof rock->bounds_max);
  for (int a = 0; a < 3; ++a) rock->centroid[a] = asset->centroid[a] * metres;
  rock->volume = asset->volume * metres * metres * metres;
  rock->inner_radius = asset->inner_radius * metres;
  rock->outer_radius = asset->outer_radius * metres;
  model->footprint = asset->footprint * metres;
  model->height = asset->height * metres;
  model->share = (float)((double)stats->rock / (double)stats->start_rock);
  model->steps = (uint32_t)stats->step;
  scree_result result = copy_hull(bake, asset, rock);
  if (result == SCREE_OK) result = copy_parts(bake, asset, model);
  for (uint32_t level = 0; level < bake->recipe.lod_levels && result == SCREE_OK; ++level) {
    lattice_mesh mesh = asset->lods[level].mesh;
    mesh.error = asset->lods[level].error_of_most * metres;
    round_surface(&mesh);
    const bool coarsest = level + 1 == bake->recipe.lod_levels;
    result = (coarsest ? plain_encode : draco_encode)(&mesh, &bake->allocator, &rock->lods[level]);
    rock->lods[level].error = mesh.error;
  }
  return result;
}

static scree_result bake_age(variant_run* run, uint32_t age, hoodoo_worker* worker) {
  hoodoo_bake* bake = run->bake;
  const uint32_t model = run->variant * bake->ages + age;
  scree_weather_stats stats;
  double start = clock_seconds(), now;
  scree_result result = advance(run, age, &stats);
  worker->seconds[STAGE_WEATHER] += (now = clock_seconds()) - start;
  if (result != SCREE_OK) return result;
  start = now;
  weather_asset asset;
  result = weather_asset_make(run->mesher, bake->recipe.size, bake->lattice, bake->recipe.lod_levels, &bake->allocator, &asset);
  worker->seconds[STAGE_SURFACE] += (now = clock_seconds()) - start;
  if (result != SCREE_OK) {
    recipe_say(&bake->errors[run->variant], "variant %u, age %u: no model can be made: %s", run->variant, age,
               scree_result_string(result));
    return result;
  }
  start = now;
  result = keep_model(run, age, &stats, &asset, &bake->rocks[model], &bake->models[model]);
  weather_asset_destroy(&asset, &bake->allocator);
  worker->seconds[STAGE_ENCODE] += clock_seconds() - start;
  if (result != SCREE_OK) return fail(run, result, scree_result_string(result));
  atomic_fetch_add(&bake->done, 1);
  return report(bake, 0) ? SCREE_OK : SCREE_ERROR_CANCELLED;
}

static scree_result start_variant(variant_run* run) {
  hoodoo_bake* bake = run->bake;
  scree_error* error = &bake->errors[run->variant];
  scree_weather_desc desc = {.memory_limit = bake->memory_limit, .jobs = bake->inner, .allocator = bake->allocator};
  scree_hoodoo_start_memory memory;
  scree_result result = scree_hoodoo_start_make(bake->desc, run->variant, &desc.start, &memory, error);
  scree_hoodoo_rules_view(&run->rules, &desc.rules);
  if (result == SCREE_OK) result = scree_weather_create(&desc, &run->weather, error);
  scree_hoodoo_start_free(bake->desc, &memory);
  if (result == SCREE_OK) result = scree_mesher_create(run->weather, &run->mesher);
  return result;
}

static void bake_variant(void* context, uint32_t variant, uint32_t worker_number) {
  hoodoo_bake* bake = context;
  hoodoo_worker* worker = &bake->workers[worker_number];
  if (atomic_load(&bake->progress.stopped)) return;
  variant_run run = {.bake = bake, .variant = variant, .rules = bake->recipe.rules};
  const double start = clock_seconds();
  scree_result result = start_variant(&run);
  worker->seconds[STAGE_START] += clock_seconds() - start;
  for (uint32_t age = 0; age < bake->ages && result == SCREE_OK; ++age) result = bake_age(&run, age, worker);
  scree_mesher_destroy(run.mesher);
  scree_weather_destroy(run.weather);
  bake->results[variant] = result;
  if (result != SCREE_OK) atomic_store(&bake->progress.stopped, true);
}

/* The lattice that the models of a recipe lie on. */
static scree_result choose_lattice(hoodoo_bake* bake, scree_error* error) {
  const scree_hoodoo_recipe* recipe = &bake->recipe;
  const uint32_t finest = weather_lattice(recipe->size);
  if (finest < 2) {
    recipe_say(error, "size: a grid of %u x %u x %u voxels does not fit on the lattice of a pack", recipe->size[0], recipe->size[1],
               recipe->size[2]);
    return SCREE_ERROR_RANGE;
  }
  bake->lattice = recipe->lattice_steps < finest ? recipe->lattice_steps : finest;
  const double steps = floor(bake->lattice / recipe->voxel + 0.5);
  if (!(steps >= 1 && steps <= PACK_MAX_LATTICE_PER_CELL)) {
    recipe_say(error, "voxel: %g metres at %u lattice steps a voxel make %g steps a metre; expected 1 to %d", recipe->voxel,
               bake->lattice, steps, PACK_MAX_LATTICE_PER_CELL);
    return SCREE_ERROR_RANGE;
  }
  bake->steps_a_metre = (uint32_t)steps;
  return SCREE_OK;
}

static scree_result allocate(hoodoo_bake* bake, uint32_t workers) {
  const scree_allocator* allocator = &bake->allocator;
  const uint32_t variants = bake->recipe.variants, count = variants * bake->ages;
  bake->rocks = scree_rt_allocate_zeroed(allocator, count, sizeof *bake->rocks);
  bake->models = scree_rt_allocate_zeroed(allocator, count, sizeof *bake->models);
  bake->workers = scree_rt_allocate_zeroed(allocator, workers, sizeof *bake->workers);
  bake->results = scree_rt_allocate_zeroed(allocator, variants, sizeof *bake->results);
  bake->errors = scree_rt_allocate_zeroed(allocator, variants, sizeof *bake->errors);
  const bool good =
      bake->rocks != NULL && bake->models != NULL && bake->workers != NULL && bake->results != NULL && bake->errors != NULL;
  return good ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
}

static void release(hoodoo_bake* bake, uint32_t workers) {
  const scree_allocator* allocator = &bake->allocator;
  const uint32_t variants = bake->recipe.variants, count = variants * bake->ages;
  for (uint32_t i = 0; i < count && bake->rocks != NULL && bake->models != NULL; ++i) {
    rock_record* rock = &bake->rocks[i];
    model_record* model = &bake->models[i];
    scree_rt_release(allocator, rock->hull, rock->hull_count, sizeof *rock->hull);
    for (uint32_t l = 0; l < ROCK_MAX_LODS; ++l) scree_rt_release(allocator, rock->lods[l].blob, rock->lods[l].blob_size, 1);
    if (model->parts != NULL) scree_rt_release(allocator, model->parts, model->part_first[model->part_count], sizeof *model->parts);
    scree_rt_release(allocator, model->part_first, (size_t)model->part_count + 1, sizeof *model->part_first);
  }
  scree_rt_release(allocator, bake->rocks, count, sizeof *bake->rocks);
  scree_rt_release(allocator, bake->models, count, sizeof *bake->models);
  scree_rt_release(allocator, bake->workers, workers, sizeof *bake->workers);
  scree_rt_release(allocator, bake->results, variants, sizeof *bake->results);
  scree_rt_release(allocator, bake->errors, variants, sizeof *bake->errors);
}

/* All variants, side by side where there are several, else the one with all threads. */
static scree_result weather_all(hoodoo_bake* bake, scree_error* error) {
  const scree_jobs* jobs = &bake->desc->jobs;
  const uint32_t variants = bake->recipe.variants;
  const bool parallel = jobs->parallel_for != NULL && jobs->worker_count > 1;
  const size_t limit = bake->desc->memory_limit > 0 ? bake->desc->memory_limit : (size_t)4 << 30;
  bake->memory_limit = limit;
  if (parallel && variants > 1) {
    bake->memory_limit = limit / (variants < jobs->worker_count ? variants : jobs->worker_count);
    jobs->parallel_for(jobs->user, variants, bake_variant, bake);
  } else {
    bake->inner = *jobs;
    for (uint32_t v = 0; v < variants; ++v) bake_variant(bake, v, 0);
  }
  if (atomic_load(&bake->progress.cancelled)) return SCREE_ERROR_CANCELLED;
  for (uint32_t v = 0; v < variants; ++v) {
    if (bake->results[v] == SCREE_OK || bake->results[v] == SCREE_ERROR_CANCELLED) continue;
    if (error != NULL) *error = bake->errors[v];
    return bake->results[v];
  }
  return SCREE_OK;
}

static void fill_report(const hoodoo_bake* bake, uint32_t workers, double seconds, double write_seconds, scree_bake_report* out) {
  static const char* const names[STAGES] = {"start", "weather", "surface", "encode"};
  memset(out, 0, sizeof *out);
  out->rocks = bake->recipe.variants * bake->ages;
  for (uint32_t i = 0; i < out->rocks; ++i)
    for (uint32_t level = 0; level < bake->recipe.lod_levels; ++level)
      out->lod_triangles[level] += bake->rocks[i].lods[level].triangle_count;
  for (uint32_t level = 0; level < bake->recipe.lod_levels; ++level) out->triangles += out->lod_triangles[level];
  for (int s = 0; s < STAGES; ++s) {
    double sum = 0;
    for (uint32_t w = 0; w < workers; ++w) sum += bake->workers[w].seconds[s];
    out->stages[out->stage_count++] = (scree_bake_stage){names[s], sum};
  }
  out->stages[out->stage_count++] = (scree_bake_stage){"write", write_seconds};
  out->seconds = seconds;
}

static scree_result write_models(const hoodoo_bake* bake, uint8_t** bytes, size_t* size) {
  const scree_allocator* allocator = &bake->allocator;
  const uint32_t variants = bake->recipe.variants;
  const size_t text_size = scree_hoodoo_write(&bake->recipe, NULL, 0) + 1;
  char* text = scree_rt_allocate(allocator, text_size, 1);
  uint32_t* first = scree_rt_allocate(allocator, (size_t)variants + 1, sizeof *first);
  scree_result result = SCREE_ERROR_OUT_OF_MEMORY;
  if (text != NULL && first != NULL) {
    scree_hoodoo_write(&bake->recipe, text, text_size);
    for (uint32_t v = 0; v <= variants; ++v) first[v] = v * bake->ages;
    const rock_set set = {.lattice_per_cell = bake->steps_a_metre,
                          .lod_count = bake->recipe.lod_levels,
                          .cell_count = variants,
                          .rock_count = variants * bake->ages,
                          .cell_first = first,
                          .rocks = bake->rocks,
                          .models = bake->models,
                          .recipe = text};
    result = pack_write(&set, allocator, bytes, size);
  }
  scree_rt_release(allocator, text, text_size, 1);
  scree_rt_release(allocator, first, (size_t)variants + 1, sizeof *first);
  return result;
}

scree_result hoodoo_model_make(const scree_hoodoo_desc* desc, uint32_t variant, uint32_t age, uint32_t lods, weather_asset* out,
                               uint32_t* steps_per_metre, scree_error* error) {
  const scree_hoodoo_recipe* recipe = desc->recipe;
  const scree_allocator allocator = scree_rt_allocator_or_default(&desc->allocator);
  const uint32_t ages = recipe->age_count > 0 ? recipe->age_count : recipe->age_step_count;
  memset(out, 0, sizeof *out);
  scree_result result = hoodoo_check_all(recipe, error);
  if (result != SCREE_OK) return result;
  if (variant >= recipe->variants || age >= ages) {
    recipe_say(error, "variant %u, age %u: the recipe has %u variants of %u ages", variant, age, recipe->variants, ages);
    return SCREE_ERROR_RANGE;
  }
  hoodoo_bake* bake = scree_rt_allocate_zeroed(&allocator, 1, sizeof *bake);
  if (bake == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  bake->desc = desc;
  bake->recipe = *recipe;
  bake->recipe.variants = 1;
  bake->allocator = allocator;
  bake->inner = desc->jobs;
  bake->memory_limit = desc->memory_limit > 0 ? desc->memory_limit : (size_t)4 << 30;
  bake->ages = 1;
  bake_progress_begin(&bake->progress, desc->progress, desc->progress_user);
  bake->errors = scree_rt_allocate_zeroed(&allocator, (size_t)variant + 1, sizeof *bake->errors);
  variant_run run = {.bake = bake, .variant = variant, .rules = recipe->rules};
  result = bake->errors == NULL ? SCREE_ERROR_OUT_OF_MEMORY : choose_lattice(bake, error);
  if (result == SCREE_OK) {
    scree_weather_stats stats;
    result = start_variant(&run);
    if (result == SCREE_OK) result = advance(&run, age, &stats);
    if (result != SCREE_OK && error != NULL && bake->errors[variant].message[0] != '\0') *error = bake->errors[variant];
  }
  if (result == SCREE_OK) {
    result = weather_asset_make(run.mesher, recipe->size, bake->lattice, lods, &allocator, out);
    if (result != SCREE_OK)
      recipe_say(error, "variant %u, age %u: no model can be made: %s", variant, age, scree_result_string(result));
    *steps_per_metre = bake->steps_a_metre;
  }
  scree_mesher_destroy(run.mesher);
  scree_weather_destroy(run.weather);
  scree_rt_release(&allocator, bake->errors, (size_t)variant + 1, sizeof *bake->errors);
  scree_rt_release(&allocator, bake, 1, sizeof *bake);
  return result;
}

scree_result scree_hoodoo_bake(const scree_hoodoo_desc* desc, uint8_t** bytes, size_t* size, scree_bake_report* report_out,
                               scree_error* error) {
  const double start = clock_seconds();
  *bytes = NULL;
  *size = 0;
  if (error != NULL) memset(error, 0, sizeof *error);
  scree_result result = hoodoo_check_all(desc->recipe, error);
  if (result != SCREE_OK) return result;
  const scree_allocator allocator = scree_rt_allocator_or_default(&desc->allocator);
  hoodoo_bake* bake = scree_rt_allocate_zeroed(&allocator, 1, sizeof *bake);
  if (bake == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  bake->desc = desc;
  bake->recipe = *desc->recipe;
  bake->allocator = allocator;
  bake->ages = bake->recipe.age_count > 0 ? bake->recipe.age_count : bake->recipe.age_step_count;
  bake_progress_begin(&bake->progress, desc->progress, desc->progress_user);
  const uint32_t workers = desc->jobs.parallel_for == NULL ? 1 : desc->jobs.worker_count;
  result = choose_lattice(bake, error);
  if (result == SCREE_OK) result = allocate(bake, workers);
  if (result == SCREE_OK) result = weather_all(bake, error);
  const double write_start = clock_seconds();
  if (result == SCREE_OK) result = write_models(bake, bytes, size);
  if (result == SCREE_OK && report_out != NULL) {
    fill_report(bake, workers, clock_seconds() - start, clock_seconds() - write_start, report_out);
    report_out->bytes = *size;
    report_out->digest = pack_bytes_digest(*bytes);
  }
  release(bake, workers);
  scree_rt_release(&allocator, bake, 1, sizeof *bake);
  return result;
}

void scree_hoodoo_free(const scree_hoodoo_desc* desc, uint8_t* bytes, size_t size) {
  const scree_allocator allocator = scree_rt_allocator_or_default(&desc->allocator);
  scree_rt_release(&allocator, bytes, size, 1);
}
