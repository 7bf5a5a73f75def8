#include "weather_session.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"
#include "start_files.h"
#include "weather_glb.h"

#define RECIPE_LIMIT ((size_t)1 << 20)
#define NEVER UINT64_MAX

typedef struct snapshot {
  uint64_t step, rock_before; /* rock_before: rock at the step before */
  scree_weather_snapshot* state;
} snapshot;

struct weather_session {
  char* path;
  scree_jobs jobs;
  scree_hoodoo_recipe recipe;
  start_files files;
  scree_hoodoo_desc hoodoo;
  uint32_t variant, snapshot_every;
  scree_weather* weather;
  scree_mesher* mesher;
  scree_weather_stats stats;
  scree_hoodoo_rules rules;                /* that hold now */
  uint32_t begun;                          /* phases that hold now */
  uint64_t begun_at[SCREE_HOODOO_PHASES];  /* steps, NEVER = not yet */
  uint64_t age_reached[SCREE_HOODOO_AGES]; /* likewise */
  uint64_t last, rock_before;
  snapshot snapshots[WEATHER_SNAPSHOTS]; /* rising */
  uint32_t snapshot_count;
  bool unsaved;
};

/* --- Files --- */

bool weather_recipe_is(const char* path) {
  char* text;
  size_t size;
  scree_error ignored;
  if (file_read(path, RECIPE_LIMIT, &text, &size, &ignored) != SCREE_OK) return false;
  cJSON* json = cJSON_ParseWithLength(text, size);
  const cJSON* kind = cJSON_GetObjectItemCaseSensitive(json, "kind");
  const bool is = cJSON_IsString(kind) && strcmp(kind->valuestring, "hoodoo") == 0;
  cJSON_Delete(json);
  free(text);
  return is;
}

static scree_result read_recipe(const char* path, scree_hoodoo_recipe* out, scree_error* error) {
  char* text;
  size_t size;
  scree_result result = file_read(path, RECIPE_LIMIT, &text, &size, error);
  if (result != SCREE_OK) return result;
  scree_error inner = {""};
  result = scree_hoodoo_parse(text, size, out, &inner);
  free(text);
  if (result != SCREE_OK)
    return fail_with(error, result, "%.200s: %.300s", path, inner.message[0] != 0 ? inner.message : scree_result_string(result));
  return result;
}

static scree_result read_start(weather_session* s, scree_error* error) {
  scree_error inner = {""};
  const scree_result result = start_files_read(&s->recipe, s->path, &s->files, &inner);
  if (result != SCREE_OK) return fail_with(error, result, "%.150s: %.300s", s->path, inner.message);
  return result;
}

/* --- Rules --- */

static bool same_curve(const scree_curve* a, const scree_curve* b) {
  return a->kind == b->kind && a->gain == b->gain && a->threshold == b->threshold && a->saturation == b->saturation &&
         a->power == b->power;
}

static bool same_durability(const scree_hoodoo_rules* a, const scree_hoodoo_rules* b) {
  if (a->durability_count != b->durability_count) return false;
  for (uint32_t i = 0; i < a->durability_count; ++i) {
    const scree_durability_point *p = &a->durability[i], *q = &b->durability[i];
    if (p->altitude != q->altitude || p->durability != q->durability || p->noise_amplitude != q->noise_amplitude ||
        p->noise_period != q->noise_period || p->noise_squash != q->noise_squash)
      return false;
  }
  return true;
}

static bool same_bubbles(const scree_hoodoo_rules* a, const scree_hoodoo_rules* b) {
  if (a->bubble_count != b->bubble_count) return false;
  for (uint32_t i = 0; i < a->bubble_count; ++i) {
    const scree_bubble_segment *p = &a->bubbles[i], *q = &b->bubbles[i];
    if (p->altitude != q->altitude || p->bubble_count != q->bubble_count || p->noise_period != q->noise_period) return false;
    for (uint32_t k = 0; k < p->bubble_count; ++k)
      if (p->bubbles[k].kind != q->bubbles[k].kind || p->bubbles[k].radius != q->bubbles[k].radius ||
          p->bubbles[k].height != q->bubbles[k].height)
        return false;
  }
  return true;
}

/* What differs, as SCREE_HOODOO_... */
static uint32_t differences(const scree_hoodoo_rules* a, const scree_hoodoo_rules* b) {
  uint32_t changes = 0;
  if (!same_durability(a, b)) changes |= SCREE_HOODOO_DURABILITY;
  if (!same_bubbles(a, b)) changes |= SCREE_HOODOO_BUBBLES;
  if (!same_curve(&a->spheroidal, &b->spheroidal)) changes |= SCREE_HOODOO_SPHEROIDAL;
  if (!same_curve(&a->cavernous, &b->cavernous)) changes |= SCREE_HOODOO_CAVERNOUS;
  if (a->exposure != b->exposure) changes |= SCREE_HOODOO_EXPOSURE;
  if (a->steps_per_voxel != b->steps_per_voxel) changes |= SCREE_HOODOO_STEPS_PER_VOXEL;
  if (a->colluvium_share != b->colluvium_share || a->colluvium_durability != b->colluvium_durability || a->repose != b->repose)
    changes |= SCREE_HOODOO_COLLUVIUM;
  if (a->rockfall != b->rockfall) changes |= SCREE_HOODOO_ROCKFALL;
  return changes;
}

static void apply(scree_hoodoo_rules* rules, uint32_t changes, const scree_hoodoo_rules* from) {
  if (changes & SCREE_HOODOO_DURABILITY) {
    memcpy(rules->durability, from->durability, sizeof rules->durability);
    rules->durability_count = from->durability_count;
  }
  if (changes & SCREE_HOODOO_BUBBLES) {
    memcpy(rules->bubbles, from->bubbles, sizeof rules->bubbles);
    rules->bubble_count = from->bubble_count;
  }
  if (changes & SCREE_HOODOO_SPHEROIDAL) rules->spheroidal = from->spheroidal;
  if (changes & SCREE_HOODOO_CAVERNOUS) rules->cavernous = from->cavernous;
  if (changes & SCREE_HOODOO_EXPOSURE) rules->exposure = from->exposure;
  if (changes & SCREE_HOODOO_STEPS_PER_VOXEL) rules->steps_per_voxel = from->steps_per_voxel;
  if (changes & SCREE_HOODOO_COLLUVIUM) {
    rules->colluvium_share = from->colluvium_share;
    rules->colluvium_durability = from->colluvium_durability;
    rules->repose = from->repose;
  }
  if (changes & SCREE_HOODOO_ROCKFALL) rules->rockfall = from->rockfall;
}

/* The rules of the recipe with its first `phases` phases. */
static void compose(const weather_session* s, uint32_t phases, scree_hoodoo_rules* out) {
  *out = s->recipe.rules;
  for (uint32_t i = 0; i < phases; ++i) apply(out, s->recipe.phases[i].changes, &s->recipe.phases[i].rules);
}

/* Makes the simulation go by `rules`; on an error it goes by the old ones. */
static scree_result use_rules(weather_session* s, const scree_hoodoo_rules* rules, scree_error* error) {
  if (differences(&s->rules, rules) == 0) return SCREE_OK;
  scree_weather_rules view;
  scree_error inner = {""};
  scree_hoodoo_rules_view(rules, &view);
  const scree_result result = scree_weather_set_rules(s->weather, &view, &inner);
  if (result != SCREE_OK)
    return fail_with(error, result, "%.150s: %.300s", s->path, inner.message[0] != 0 ? inner.message : scree_result_string(result));
  s->rules = *rules;
  return SCREE_OK;
}

/* --- Time --- */

/* As scree_hoodoo_bake asks: a share of the rock, or steps where it is below 0. */
static bool has_come(const weather_session* s, double share, uint32_t steps) {
  return share < 0 ? s->stats.step >= steps : (double)s->stats.rock <= share * (double)s->stats.start_rock;
}

static void note_ages(weather_session* s) {
  for (uint32_t i = 0; i < weather_session_ages(s); ++i)
    if (s->age_reached[i] == NEVER &&
        has_come(s, s->recipe.age_count > 0 ? s->recipe.ages[i] : -1, s->recipe.age_count > 0 ? 0 : s->recipe.age_steps[i]))
      s->age_reached[i] = s->stats.step;
}

/* Begins the phases whose moment has come, and marks ages that are reached. */
static scree_result arrive(weather_session* s, scree_error* error) {
  scree_weather_get_stats(s->weather, &s->stats);
  if (s->stats.step > s->last) s->last = s->stats.step;
  uint32_t begun = s->begun;
  while (begun < s->recipe.phase_count && has_come(s, s->recipe.phases[begun].share, s->recipe.phases[begun].steps)) {
    if (s->begun_at[begun] == NEVER) s->begun_at[begun] = s->stats.step;
    ++begun;
  }
  note_ages(s);
  scree_hoodoo_rules rules;
  compose(s, begun, &rules);
  const scree_result result = use_rules(s, &rules, error);
  if (result == SCREE_OK) s->begun = begun;
  return result;
}

/* Every other one goes, but that of step 0. */
static void thin_snapshots(weather_session* s) {
  uint32_t kept = 0;
  for (uint32_t i = 0; i < s->snapshot_count; ++i) {
    if (i % 2 == 0)
      s->snapshots[kept++] = s->snapshots[i];
    else
      scree_weather_forget(s->weather, s->snapshots[i].state);
  }
  s->snapshot_count = kept;
  s->snapshot_every *= 2;
}

/* What cannot be kept for want of memory only makes going back slower, but for the start. */
static scree_result keep_snapshot(weather_session* s) {
  const uint64_t step = s->stats.step;
  if (s->snapshot_count > 0 && (step % s->snapshot_every != 0 || s->snapshots[s->snapshot_count - 1].step >= step)) return SCREE_OK;
  if (s->snapshot_count == WEATHER_SNAPSHOTS) thin_snapshots(s);
  scree_weather_snapshot* state;
  const scree_result result = scree_weather_save(s->weather, &state);
  if (result != SCREE_OK) return s->snapshot_count > 0 ? SCREE_OK : result;
  s->snapshots[s->snapshot_count++] = (snapshot){step, s->rock_before, state};
  return SCREE_OK;
}

/* Nothing is known of what comes after `step` any more. */
static void forget_after(weather_session* s, uint64_t step) {
  while (s->snapshot_count > 0 && s->snapshots[s->snapshot_count - 1].step > step)
    scree_weather_forget(s->weather, s->snapshots[--s->snapshot_count].state);
  for (uint32_t i = 0; i < SCREE_HOODOO_PHASES; ++i)
    if (s->begun_at[i] > step) s->begun_at[i] = NEVER;
  for (uint32_t i = 0; i < SCREE_HOODOO_AGES; ++i)
    if (s->age_reached[i] > step) s->age_reached[i] = NEVER;
  if (s->last > step) s->last = step;
}

scree_result weather_session_step(weather_session* s, scree_error* error) {
  if (s->stats.rock == 0) return SCREE_OK;
  s->rock_before = s->stats.rock;
  const scree_result result = scree_weather_step(s->weather, 1);
  if (result != SCREE_OK) return fail_with(error, result, "%.200s: %s", s->path, scree_result_string(result));
  scree_weather_get_stats(s->weather, &s->stats);
  keep_snapshot(s);
  return arrive(s, error);
}

static scree_result go_back(weather_session* s, uint64_t step, scree_error* error) {
  uint32_t i = s->snapshot_count - 1;
  while (i > 0 && s->snapshots[i].step > step) --i;
  scree_weather_restore(s->weather, s->snapshots[i].state);
  s->rock_before = s->snapshots[i].rock_before;
  s->begun = 0;
  return arrive(s, error);
}

scree_result weather_session_go(weather_session* s, uint32_t step, scree_error* error) {
  scree_result result = SCREE_OK;
  /* Ahead, a snapshot between here and there saves steps. */
  uint64_t nearest = 0;
  for (uint32_t i = 0; i < s->snapshot_count; ++i)
    if (s->snapshots[i].step <= step) nearest = s->snapshots[i].step;
  if (step < s->stats.step || nearest > s->stats.step) result = go_back(s, step, error);
  while (result == SCREE_OK && s->stats.step < step && s->stats.rock > 0) result = weather_session_step(s, error);
  return result;
}

/* --- Opening --- */

static void close_simulation(weather_session* s) {
  for (uint32_t i = 0; i < s->snapshot_count; ++i) scree_weather_forget(s->weather, s->snapshots[i].state);
  s->snapshot_count = 0;
  scree_mesher_destroy(s->mesher);
  scree_weather_destroy(s->weather);
  s->mesher = NULL;
  s->weather = NULL;
}

static scree_result begin(weather_session* s, scree_error* error) {
  s->rules = s->recipe.rules;
  s->begun = 0;
  s->last = 0;
  for (uint32_t i = 0; i < SCREE_HOODOO_PHASES; ++i) s->begun_at[i] = NEVER;
  for (uint32_t i = 0; i < SCREE_HOODOO_AGES; ++i) s->age_reached[i] = NEVER;
  scree_weather_get_stats(s->weather, &s->stats);
  s->rock_before = s->stats.rock;
  scree_result result = keep_snapshot(s);
  if (result != SCREE_OK) return fail_with(error, result, "%.200s: %s", s->path, scree_result_string(result));
  return arrive(s, error);
}

static scree_result make_simulation(weather_session* s, uint32_t variant, scree_weather** weather, scree_mesher** mesher,
                                    scree_error* error) {
  *weather = NULL;
  *mesher = NULL;
  scree_weather_desc desc = {.jobs = s->jobs};
  scree_hoodoo_start_memory memory;
  scree_error inner = {""};
  scree_result result = scree_hoodoo_start_make(&s->hoodoo, variant, &desc.start, &memory, &inner);
  scree_hoodoo_rules_view(&s->recipe.rules, &desc.rules);
  if (result == SCREE_OK) result = scree_weather_create(&desc, weather, &inner);
  scree_hoodoo_start_free(&s->hoodoo, &memory);
  if (result == SCREE_OK) result = scree_mesher_create(*weather, mesher);
  if (result == SCREE_OK) return result;
  scree_weather_destroy(*weather);
  *weather = NULL;
  return fail_with(error, result, "%.150s: %.300s", s->path, inner.message[0] != 0 ? inner.message : scree_result_string(result));
}

scree_result weather_session_open(const weather_session_desc* desc, weather_session** out, scree_error* error) {
  *out = NULL;
  weather_session* s = calloc(1, sizeof *s);
  char* path = malloc(strlen(desc->path) + 1);
  if (s == NULL || path == NULL) {
    free(s);
    free(path);
    return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%.200s: out of memory", desc->path);
  }
  s->path = strcpy(path, desc->path);
  s->jobs = desc->jobs;
  s->snapshot_every = desc->snapshot_every > 0 ? desc->snapshot_every : 5;
  scree_result result = read_recipe(path, &s->recipe, error);
  if (result == SCREE_OK) result = read_start(s, error);
  if (result == SCREE_OK && desc->variant >= s->recipe.variants)
    result = fail_with(error, SCREE_ERROR_RANGE, "%.200s: variants: there are %u, from 0; %u is none of them", path,
                       s->recipe.variants, desc->variant);
  if (result == SCREE_OK) {
    s->hoodoo = (scree_hoodoo_desc){.recipe = &s->recipe,
                                    .map = s->files.map,
                                    .map_width = s->files.width,
                                    .map_depth = s->files.depth,
                                    .mesh = s->files.mesh,
                                    .jobs = s->jobs};
    s->variant = desc->variant;
    result = make_simulation(s, s->variant, &s->weather, &s->mesher, error);
  }
  if (result == SCREE_OK) result = begin(s, error);
  if (result == SCREE_OK)
    *out = s;
  else
    weather_session_close(s);
  return result;
}

void weather_session_close(weather_session* s) {
  if (s == NULL) return;
  close_simulation(s);
  start_files_free(&s->files);
  free(s->path);
  free(s);
}

scree_result weather_session_set_variant(weather_session* s, uint32_t variant, scree_error* error) {
  if (variant >= s->recipe.variants)
    return fail_with(error, SCREE_ERROR_RANGE, "%.200s: variants: there are %u, from 0; %u is none of them", s->path,
                     s->recipe.variants, variant);
  scree_weather* weather;
  scree_mesher* mesher;
  const scree_result result = make_simulation(s, variant, &weather, &mesher, error);
  if (result != SCREE_OK) return result;
  close_simulation(s);
  s->weather = weather;
  s->mesher = mesher;
  s->variant = variant;
  return begin(s, error);
}

/* --- Changes --- */

scree_result weather_session_set_rules(weather_session* s, const scree_hoodoo_rules* rules, scree_error* error) {
  if (differences(&s->rules, rules) == 0) return SCREE_OK;
  scree_hoodoo_recipe* recipe = &s->recipe;
  const uint64_t now = s->stats.step;
  const uint32_t k = s->begun;
  const bool base = now == 0 && k == 0;
  const bool again = k > 0 && recipe->phases[k - 1].share < 0 && s->begun_at[k - 1] == now && recipe->phases[k - 1].steps == now;
  if (!base && !again && recipe->phase_count == SCREE_HOODOO_PHASES)
    return fail_with(error, SCREE_ERROR_RANGE,
                     "%.150s: phases: all %d are taken; drop one, or let the rules of now hold from the start", s->path,
                     SCREE_HOODOO_PHASES);
  const scree_result result = use_rules(s, rules, error);
  if (result != SCREE_OK) return result;
  s->unsaved = true;
  forget_after(s, now);
  if (base) {
    recipe->rules = *rules;
    return SCREE_OK;
  }
  /* A second change at the same step is part of the first; one that is taken back was none. */
  scree_hoodoo_rules before;
  compose(s, again ? k - 1 : k, &before);
  const uint32_t changes = differences(&before, rules);
  if (again && changes == 0) {
    memmove(&recipe->phases[k - 1], &recipe->phases[k], (recipe->phase_count - k) * sizeof *recipe->phases);
    memmove(&s->begun_at[k - 1], &s->begun_at[k], (SCREE_HOODOO_PHASES - k) * sizeof *s->begun_at);
    --recipe->phase_count;
    --s->begun;
    return SCREE_OK;
  }
  if (!again) {
    memmove(&recipe->phases[k + 1], &recipe->phases[k], (recipe->phase_count - k) * sizeof *recipe->phases);
    ++recipe->phase_count;
    s->begun_at[k] = now;
    ++s->begun;
  }
  recipe->phases[again ? k - 1 : k] =
      (scree_hoodoo_phase){.share = -1, .steps = (uint32_t)now, .changes = changes, .rules = *rules};
  return SCREE_OK;
}

scree_result weather_session_drop_phase(weather_session* s, uint32_t phase, scree_error* error) {
  scree_hoodoo_recipe* recipe = &s->recipe;
  if (phase >= recipe->phase_count)
    return fail_with(error, SCREE_ERROR_RANGE, "%.200s: phases: there is no phase %u", s->path, phase);
  const uint64_t now = s->stats.step, began = s->begun_at[phase];
  memmove(&recipe->phases[phase], &recipe->phases[phase + 1], (recipe->phase_count - phase - 1) * sizeof *recipe->phases);
  memmove(&s->begun_at[phase], &s->begun_at[phase + 1], (SCREE_HOODOO_PHASES - phase - 1) * sizeof *s->begun_at);
  s->begun_at[SCREE_HOODOO_PHASES - 1] = NEVER;
  --recipe->phase_count;
  s->unsaved = true;
  if (began == NEVER) return SCREE_OK;
  forget_after(s, began);
  const scree_result result = go_back(s, began, error);
  return result == SCREE_OK ? weather_session_go(s, (uint32_t)now, error) : result;
}

scree_result weather_session_flatten(weather_session* s, scree_error* error) {
  const scree_hoodoo_rules rules = s->rules;
  s->recipe.rules = rules;
  s->recipe.phase_count = 0;
  s->unsaved = true;
  forget_after(s, 0);
  for (uint32_t i = 0; i < SCREE_HOODOO_PHASES; ++i) s->begun_at[i] = NEVER;
  return go_back(s, 0, error);
}

/* --- Ages --- */

uint32_t weather_session_ages(const weather_session* s) {
  return s->recipe.age_count > 0 ? s->recipe.age_count : s->recipe.age_step_count;
}

bool weather_session_age_step(const weather_session* s, uint32_t age, uint32_t* step) {
  if (age >= weather_session_ages(s) || s->age_reached[age] == NEVER) return false;
  *step = (uint32_t)s->age_reached[age];
  return true;
}

/* A share of few decimals that is reached at this step and not at the one before. */
static double share_of_now(const weather_session* s) {
  const double start = (double)s->stats.start_rock, rock = (double)s->stats.rock, before = (double)s->rock_before;
  double scale = 100;
  for (int decimals = 2; decimals <= 9; ++decimals, scale *= 10) {
    const double share = ceil(rock / start * scale) / scale;
    if (share <= 1 && share * start >= rock && (s->stats.step == 0 || share * start < before)) return share;
  }
  return rock / start;
}

scree_result weather_session_keep_age(weather_session* s, scree_error* error) {
  scree_hoodoo_recipe* recipe = &s->recipe;
  const uint32_t count = weather_session_ages(s);
  if (s->stats.rock == 0) return fail_with(error, SCREE_ERROR_RANGE, "%.200s: ages: no rock is left", s->path);
  uint32_t at = 0;
  while (at < count && s->age_reached[at] < s->stats.step) ++at;
  if (at < count && s->age_reached[at] == s->stats.step)
    return fail_with(error, SCREE_ERROR_RANGE, "%.200s: ages: this one is kept already", s->path);
  if (count == SCREE_HOODOO_AGES)
    return fail_with(error, SCREE_ERROR_RANGE, "%.200s: ages: all %d are taken", s->path, SCREE_HOODOO_AGES);
  if (recipe->age_count > 0) {
    const double share = share_of_now(s);
    memmove(&recipe->ages[at + 1], &recipe->ages[at], (count - at) * sizeof *recipe->ages);
    recipe->ages[at] = share;
    ++recipe->age_count;
  } else {
    memmove(&recipe->age_steps[at + 1], &recipe->age_steps[at], (count - at) * sizeof *recipe->age_steps);
    recipe->age_steps[at] = (uint32_t)s->stats.step;
    ++recipe->age_step_count;
  }
  memmove(&s->age_reached[at + 1], &s->age_reached[at], (count - at) * sizeof *s->age_reached);
  s->age_reached[at] = s->stats.step;
  if (recipe->max_steps < s->stats.step) recipe->max_steps = (uint32_t)s->stats.step;
  s->unsaved = true;
  return SCREE_OK;
}

scree_result weather_session_drop_age(weather_session* s, uint32_t age, scree_error* error) {
  scree_hoodoo_recipe* recipe = &s->recipe;
  const uint32_t count = weather_session_ages(s);
  if (age >= count) return fail_with(error, SCREE_ERROR_RANGE, "%.200s: ages: there is no age %u", s->path, age);
  if (count == 1) return fail_with(error, SCREE_ERROR_RANGE, "%.200s: ages: a recipe keeps its last one", s->path);
  if (recipe->age_count > 0) {
    memmove(&recipe->ages[age], &recipe->ages[age + 1], (count - age - 1) * sizeof *recipe->ages);
    --recipe->age_count;
  } else {
    memmove(&recipe->age_steps[age], &recipe->age_steps[age + 1], (count - age - 1) * sizeof *recipe->age_steps);
    --recipe->age_step_count;
  }
  memmove(&s->age_reached[age], &s->age_reached[age + 1], (count - age - 1) * sizeof *s->age_reached);
  s->age_reached[SCREE_HOODOO_AGES - 1] = NEVER;
  s->unsaved = true;
  return SCREE_OK;
}

/* --- Results --- */

scree_result weather_session_save(weather_session* s, const char* path, scree_error* error) {
  if (path == NULL) path = s->path;
  const size_t size = scree_hoodoo_write(&s->recipe, NULL, 0);
  char* text = malloc(size + 1);
  scree_hoodoo_recipe* back = malloc(sizeof *back);
  if (text == NULL || back == NULL) {
    free(text);
    free(back);
    return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%.200s: out of memory", path);
  }
  scree_hoodoo_write(&s->recipe, text, size + 1);
  /* What could not be opened again is not written. */
  scree_error inner = {""};
  scree_result result = scree_hoodoo_parse(text, size, back, &inner);
  if (result != SCREE_OK) fail_with(error, result, "%.150s: %.300s", path, inner.message);
  free(back);
  if (result == SCREE_OK) {
    file_replacement file;
    result = file_replace_begin(path, &file, error);
    if (result == SCREE_OK) {
      fwrite(text, 1, size, file.stream);
      result = file_replace_commit(&file, error);
    }
  }
  free(text);
  if (result == SCREE_OK) s->unsaved = false;
  return result;
}

scree_result weather_session_surface(weather_session* s, scree_surface* out, scree_error* error) {
  const scree_result result = scree_mesher_update(s->mesher, 0, out);
  if (result != SCREE_OK) return fail_with(error, result, "%.200s: no surface: %s", s->path, scree_result_string(result));
  return result;
}

scree_result weather_session_export(weather_session* s, const char* path, scree_error* error) {
  scree_surface surface;
  const scree_result result = weather_session_surface(s, &surface, error);
  if (result != SCREE_OK) return result;
  return weather_glb_write(path, s->recipe.name, &surface, s->recipe.size, s->recipe.voxel, error);
}

/* --- What there is --- */

const scree_hoodoo_recipe* weather_session_recipe(const weather_session* s) {
  return &s->recipe;
}
uint32_t weather_session_variant(const weather_session* s) {
  return s->variant;
}
uint32_t weather_session_last(const weather_session* s) {
  return (uint32_t)s->last;
}
uint32_t weather_session_snapshots(const weather_session* s) {
  return s->snapshot_count;
}
void weather_session_stats(const weather_session* s, scree_weather_stats* out) {
  *out = s->stats;
}
uint64_t weather_session_digest(const weather_session* s) {
  return scree_weather_digest(s->weather);
}
const scree_hoodoo_rules* weather_session_rules(const weather_session* s) {
  return &s->rules;
}
uint32_t weather_session_phases_begun(const weather_session* s) {
  return s->begun;
}
bool weather_session_unsaved(const weather_session* s) {
  return s->unsaved;
}
