/* All unique rocks of a recipe: one job a tile code, one worker's scratch a thread, results by rock, so that neither the order nor
 * the number of threads shows in the pack. */
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "bake_internal.h"
#include "bake_progress.h"
#include "burial.h"
#include "clock.h"
#include "draco_encode.h"
#include "lattice.h"
#include "pack_writer.h"
#include "plain_encode.h"
#include "plain_mesh.h"
#include "proxies.h"
#include "recipe.h"

#define TILES 256

/* Unique cells in the order of the tile that they are baked in: cells[first[code]] .. */
static scree_result sort_cells(bake_run* out) {
  const uint32_t n = out->seeds.n;
  out->cell_count = scree_rt_lattice_cell_count(n);
  out->cells = scree_rt_allocate(&out->allocator, out->cell_count, sizeof *out->cells);
  out->cell_rocks = scree_rt_allocate(&out->allocator, (size_t)out->cell_count + 1, sizeof *out->cell_rocks);
  if (out->cells == NULL || out->cell_rocks == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  memset(out->tile_first, 0, sizeof out->tile_first);
  uint32_t code, x, y, z, count;
  uint32_t rocks = 0;
  for (uint32_t cell = 0; cell < out->cell_count; ++cell) {
    scree_rt_lattice_cell_place(n, cell, &code, &x, &y, &z);
    ++out->tile_first[code + 1];
    seeds_of_cell(&out->seeds, code, (int32_t)x, (int32_t)y, (int32_t)z, &count);
    out->cell_rocks[cell] = rocks;
    rocks += count;
  }
  out->cell_rocks[out->cell_count] = rocks;
  out->slot_count = rocks;
  for (uint32_t tile = 0; tile < TILES; ++tile) out->tile_first[tile + 1] += out->tile_first[tile];
  uint32_t next[TILES];
  memcpy(next, out->tile_first, sizeof next);
  for (uint32_t cell = 0; cell < out->cell_count; ++cell) {
    scree_rt_lattice_cell_place(n, cell, &code, &x, &y, &z);
    out->cells[next[code]++] = cell;
  }
  return SCREE_OK;
}

static void run_jobs(const scree_jobs* jobs, uint32_t count, void (*run)(void* context, uint32_t index, uint32_t worker),
                     void* context) {
  if (jobs->parallel_for != NULL)
    jobs->parallel_for(jobs->user, count, run, context);
  else
    for (uint32_t index = 0; index < count; ++index) run(context, index, 0);
}

static void fill_shared(void* context, uint32_t index, uint32_t worker) {
  (void)worker;
  shared_blocks_fill(context, index);
}

scree_result bake_begin(const scree_bake_desc* desc, bool plain_kernels, bake_run* out) {
  memset(out, 0, sizeof *out);
  out->allocator = scree_rt_allocator_or_default(&desc->allocator);
  out->recipe = *desc->recipe;
  out->kernels = kernels_choose(plain_kernels);
  out->worker_count = desc->jobs.parallel_for == NULL ? 1 : desc->jobs.worker_count;
  scree_result result = recipe_check_all(desc->recipe, NULL);
  if (result == SCREE_OK) result = seed_set_create(&out->recipe, &out->allocator, &out->seeds);
  if (result == SCREE_OK) result = block_tables_create(&out->recipe, &out->allocator, &out->tables);
  if (result == SCREE_OK) result = shared_blocks_create(&out->seeds, &out->tables, out->kernels, &out->allocator, &out->shared);
  if (result == SCREE_OK) result = sort_cells(out);
  if (result == SCREE_OK) {
    out->workers = scree_rt_allocate_zeroed(&out->allocator, out->worker_count, sizeof *out->workers);
    if (out->workers == NULL) result = SCREE_ERROR_OUT_OF_MEMORY;
  }
  for (uint32_t w = 0; w < out->worker_count && result == SCREE_OK; ++w) {
    bake_worker* worker = &out->workers[w];
    result = rock_worker_create(&out->recipe, &out->shared, &out->allocator, &worker->rock);
    if (result == SCREE_OK) result = rock_mesher_create(&worker->rock, out->recipe.lattice_steps, &out->allocator, &worker->mesher);
  }
  if (result != SCREE_OK) {
    bake_end(out);
    return result;
  }
  run_jobs(&desc->jobs, out->shared.count, fill_shared, &out->shared);
  return SCREE_OK;
}

void bake_end(bake_run* bake) {
  for (uint32_t w = 0; bake->workers != NULL && w < bake->worker_count; ++w) {
    rock_mesher_destroy(&bake->workers[w].mesher);
    rock_worker_destroy(&bake->workers[w].rock, &bake->allocator);
  }
  scree_rt_release(&bake->allocator, bake->workers, bake->worker_count, sizeof *bake->workers);
  scree_rt_release(&bake->allocator, bake->cells, bake->cell_count, sizeof *bake->cells);
  scree_rt_release(&bake->allocator, bake->cell_rocks, (size_t)bake->cell_count + 1, sizeof *bake->cell_rocks);
  shared_blocks_destroy(&bake->shared, &bake->allocator);
  block_tables_destroy(&bake->tables, &bake->allocator);
  seed_set_destroy(&bake->seeds, &bake->allocator);
  memset(bake, 0, sizeof *bake);
}

bool bake_rock_field(bake_run* bake, bake_worker* worker, uint32_t cell, uint32_t seed) {
  uint32_t code, x, y, z;
  scree_rt_lattice_cell_place(bake->seeds.n, cell, &code, &x, &y, &z);
  if (!worker->started || worker->rock.blocks.code != code) block_cache_begin(&worker->rock.blocks, code);
  worker->started = true;
  if (!rock_voronoi(&worker->rock, (int32_t)x, (int32_t)y, (int32_t)z, seed)) return false;
  /* Planes and noise belong to the unique rock, not to its seed: stones that share a seed differ all the more. */
  const uint64_t key = hash_combine(hash_combine(bake->recipe.random_seed, UINT64_C(0x70c4)), (uint64_t)cell << 8 | seed);
  return rock_erode(&worker->rock, key) > 0;
}

/* --- The whole set. --- */

typedef struct set_bake {
  bake_run* bake;
  const scree_bake_desc* desc;
  rock_record* rocks;      /* by slot: rocks that came out empty have no hull */
  rock_mask* masks;        /* by slot */
  atomic_uint* burials;    /* by slot */
  burial_scratch* burying; /* by worker, made when it is first needed */
  proxy_record* proxies;   /* by (code, part), NULL when the recipe wants none */
  proxy_scratch* merging;  /* by worker, made when it is first needed */
  uint32_t rock_occlusion; /* mean of all vertices of all coarsest levels */
  const char* stage;       /* that runs now */
  uint32_t jobs;           /* of all stages */
  atomic_uint jobs_done;
  bake_progress progress;
  atomic_int failure; /* first scree_result that was not SCREE_OK */
} set_bake;

static void free_levels(rock_lod* lods, const scree_allocator* allocator) {
  for (uint32_t level = 0; level < ROCK_MAX_LODS; ++level) scree_rt_release(allocator, lods[level].blob, lods[level].blob_size, 1);
}

static void free_record(rock_record* rock, const scree_allocator* allocator) {
  scree_rt_release(allocator, rock->hull, rock->hull_count, sizeof *rock->hull);
  scree_rt_release(allocator, rock->contacts, rock->contact_count, sizeof *rock->contacts);
  free_levels(rock->lods, allocator);
}

static scree_result copy_contacts(const bake_run* bake, const rock_worker* worker, rock_record* out) {
  out->contact_count = worker->contact_count;
  if (out->contact_count == 0) return SCREE_OK;
  out->contacts = scree_rt_allocate_zeroed(&bake->allocator, out->contact_count, sizeof *out->contacts);
  if (out->contacts == NULL) {
    out->contact_count = 0;
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  for (uint32_t c = 0; c < out->contact_count; ++c) {
    const rock_contact* from = &worker->contacts[c];
    for (int axis = 0; axis < 3; ++axis) {
      const double lattice = (double)from->position[axis] * bake->recipe.lattice_steps / UNITS_PER_VOXEL;
      out->contacts[c].position[axis] = (int16_t)floor(lattice); /* like the vertices, see surface_nets.h */
      out->contacts[c].cell[axis] = from->cell[axis];
    }
    out->contacts[c].seed = from->seed;
  }
  return SCREE_OK;
}

scree_result bake_rock(bake_run* bake, bake_worker* worker, uint32_t cell, uint32_t seed, rock_record* out, rock_mask* mask) {
  if (!bake_rock_field(bake, worker, cell, seed)) return SCREE_OK;
  const scree_recipe* recipe = &bake->recipe;
  double start = clock_seconds();
  scree_result result = rock_mesh(&worker->mesher, &worker->rock, recipe->lod_levels);
  if (result != SCREE_OK) return result;
  out->cell = cell;
  out->seed = seed;
  rock_mass(&worker->mesher.meshes[0], 1.0f / (float)(recipe->lattice_steps * recipe->voxels_per_cell), out);
  int16_t hull[ROCK_MAX_HULL][3];
  const uint32_t hull_count = rock_hull(&worker->mesher, recipe->hull_vertices, hull);
  out->hull = scree_rt_allocate(&bake->allocator, hull_count, sizeof *out->hull);
  if (out->hull == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  out->hull_count = hull_count;
  memcpy(out->hull, hull, hull_count * sizeof *hull);
  result = copy_contacts(bake, &worker->rock, out);
  double now = clock_seconds();
  worker->mesh_seconds += now - start;
  for (uint32_t level = 0; level < recipe->lod_levels && result == SCREE_OK; ++level) {
    const mesh_buffer* mesh = &worker->mesher.meshes[level];
    const lattice_mesh source = {.positions = mesh->positions,
                                 .occlusion = mesh->occlusion,
                                 .indices = mesh->indices,
                                 .vertex_count = mesh->vertex_count,
                                 .triangle_count = mesh->index_count / 3,
                                 .error = worker->mesher.errors[level]};
    const bool coarsest = level + 1 == recipe->lod_levels;
    result = (coarsest ? plain_encode : draco_encode)(&source, &bake->allocator, &out->lods[level]);
    out->lods[level].error = source.error;
  }
  start = clock_seconds();
  worker->encode_seconds += start - now;
  if (result == SCREE_OK) result = rock_mask_make(&worker->rock, &bake->allocator, mask);
  worker->burial_seconds += clock_seconds() - start;
  return result;
}

static void fail(set_bake* set, scree_result result) {
  atomic_store(&set->failure, (int)result);
}

static bool failed(set_bake* set) {
  return atomic_load_explicit(&set->failure, memory_order_relaxed) != SCREE_OK;
}

/* One more job is done. */
static void report_job(set_bake* set) {
  const uint32_t done = atomic_fetch_add(&set->jobs_done, 1) + 1;
  if (!bake_progress_tell(&set->progress, set->stage, (double)done / set->jobs)) fail(set, SCREE_ERROR_CANCELLED);
}

static void bake_tile(void* context, uint32_t tile, uint32_t worker_number) {
  set_bake* set = context;
  bake_run* bake = set->bake;
  bake_worker* worker = &bake->workers[worker_number];
  for (uint32_t i = bake->tile_first[tile]; i < bake->tile_first[tile + 1]; ++i) {
    const uint32_t cell = bake->cells[i], first = bake->cell_rocks[cell], count = bake->cell_rocks[cell + 1] - first;
    for (uint32_t seed = 0; seed < count; ++seed) {
      if (failed(set)) return;
      const scree_result result = bake_rock(bake, worker, cell, seed, &set->rocks[first + seed], &set->masks[first + seed]);
      if (result != SCREE_OK) fail(set, result);
    }
  }
  report_job(set);
}

static void bury_tile(void* context, uint32_t tile, uint32_t worker_number) {
  set_bake* set = context;
  if (failed(set)) return;
  const double start = clock_seconds();
  burial_scratch* scratch = &set->burying[worker_number];
  if (scratch->owners == NULL && burial_scratch_create(set->bake, scratch) != SCREE_OK) {
    fail(set, SCREE_ERROR_OUT_OF_MEMORY);
    return;
  }
  burial_of_tile(set->bake, tile, set->masks, set->rocks, set->burials, scratch);
  set->bake->workers[worker_number].burial_seconds += clock_seconds() - start;
  report_job(set);
}

static void merge_tile(void* context, uint32_t tile, uint32_t worker_number) {
  set_bake* set = context;
  if (failed(set)) return;
  const double start = clock_seconds();
  proxy_scratch* scratch = &set->merging[worker_number];
  scree_result result = scratch->bake != NULL ? SCREE_OK : proxy_scratch_create(set->bake, scratch);
  if (result == SCREE_OK)
    result = proxies_of_tile(scratch, tile, set->masks, set->rock_occlusion, &set->proxies[(size_t)tile * PROXY_PARTS]);
  if (result != SCREE_OK) fail(set, result);
  set->bake->workers[worker_number].proxy_seconds += clock_seconds() - start;
  report_job(set);
}

static uint32_t mean_occlusion(const set_bake* set) {
  uint64_t sum = 0, vertices = 0;
  for (uint32_t slot = 0; slot < set->bake->slot_count; ++slot) {
    const rock_lod* level = &set->rocks[slot].lods[set->bake->recipe.lod_levels - 1];
    plain_mesh mesh;
    if (level->blob == NULL ||
        !scree_rt_plain_mesh_read(level->blob, level->blob_size, level->vertex_count, level->triangle_count, false, &mesh))
      continue;
    for (uint32_t v = 0; v < mesh.vertex_count; ++v) sum += mesh.occlusion[v];
    vertices += mesh.vertex_count;
  }
  return vertices > 0 ? (uint32_t)(sum / vertices) : 255;
}

static scree_result bake_proxies(set_bake* set, const scree_jobs* jobs) {
  bake_run* bake = set->bake;
  set->proxies = scree_rt_allocate_zeroed(&bake->allocator, (size_t)TILES * PROXY_PARTS, sizeof *set->proxies);
  set->merging = scree_rt_allocate_zeroed(&bake->allocator, bake->worker_count, sizeof *set->merging);
  if (set->proxies == NULL || set->merging == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  set->rock_occlusion = mean_occlusion(set);
  set->stage = "proxies";
  run_jobs(jobs, TILES, merge_tile, set);
  return (scree_result)atomic_load(&set->failure);
}

/* Everything that is made of rocks, into the records. */
static scree_result bake_set(set_bake* set, const scree_jobs* jobs) {
  bake_run* bake = set->bake;
  set->rocks = scree_rt_allocate_zeroed(&bake->allocator, bake->slot_count, sizeof *set->rocks);
  set->masks = scree_rt_allocate_zeroed(&bake->allocator, bake->slot_count, sizeof *set->masks);
  set->burials = scree_rt_allocate_zeroed(&bake->allocator, bake->slot_count, sizeof *set->burials);
  set->burying = scree_rt_allocate_zeroed(&bake->allocator, bake->worker_count, sizeof *set->burying);
  if (set->rocks == NULL || set->masks == NULL || set->burials == NULL || set->burying == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  set->jobs = (bake->recipe.proxies ? 3 : 2) * TILES;
  set->stage = "rocks";
  run_jobs(jobs, TILES, bake_tile, set);
  for (uint32_t slot = 0; slot < bake->slot_count; ++slot) atomic_init(&set->burials[slot], 1);
  set->stage = "burial";
  if (!failed(set)) run_jobs(jobs, TILES, bury_tile, set);
  for (uint32_t slot = 0; slot < bake->slot_count; ++slot) set->rocks[slot].burial = atomic_load(&set->burials[slot]);
  const scree_result result = (scree_result)atomic_load(&set->failure);
  return result == SCREE_OK && bake->recipe.proxies ? bake_proxies(set, jobs) : result;
}

static void free_set(set_bake* set) {
  bake_run* bake = set->bake;
  const scree_allocator* allocator = &bake->allocator;
  for (uint32_t slot = 0; set->rocks != NULL && slot < bake->slot_count; ++slot) free_record(&set->rocks[slot], allocator);
  for (uint32_t slot = 0; set->masks != NULL && slot < bake->slot_count; ++slot) rock_mask_free(&set->masks[slot], allocator);
  for (uint32_t w = 0; set->burying != NULL && w < bake->worker_count; ++w) burial_scratch_destroy(bake, &set->burying[w]);
  for (uint32_t i = 0; set->proxies != NULL && i < TILES * PROXY_PARTS; ++i) free_levels(set->proxies[i].lods, allocator);
  for (uint32_t w = 0; set->merging != NULL && w < bake->worker_count; ++w) proxy_scratch_destroy(&set->merging[w]);
  scree_rt_release(allocator, set->proxies, (size_t)TILES * PROXY_PARTS, sizeof *set->proxies);
  scree_rt_release(allocator, set->merging, bake->worker_count, sizeof *set->merging);
  scree_rt_release(allocator, set->rocks, bake->slot_count, sizeof *set->rocks);
  scree_rt_release(allocator, set->masks, bake->slot_count, sizeof *set->masks);
  scree_rt_release(allocator, set->burials, bake->slot_count, sizeof *set->burials);
  scree_rt_release(allocator, set->burying, bake->worker_count, sizeof *set->burying);
}

static void add_stage(scree_bake_report* report, const char* name, double seconds) {
  report->stages[report->stage_count++] = (scree_bake_stage){name, seconds};
}

static void fill_report(const set_bake* set, const rock_set* rocks, double seconds, double write_seconds,
                        scree_bake_report* report) {
  memset(report, 0, sizeof *report);
  report->rocks = rocks->rock_count;
  for (uint32_t r = 0; r < rocks->rock_count; ++r) {
    report->contacts += rocks->rocks[r].contact_count;
    for (uint32_t level = 0; level < rocks->lod_count; ++level)
      report->lod_triangles[level] += rocks->rocks[r].lods[level].triangle_count;
  }
  for (uint32_t level = 0; level < rocks->lod_count; ++level) report->triangles += report->lod_triangles[level];
  for (uint32_t i = 0; rocks->proxies != NULL && i < TILES * PROXY_PARTS; ++i) {
    ++report->proxies;
    for (uint32_t level = 0; level < rocks->lod_count; ++level) {
      report->proxy_triangles += rocks->proxies[i].lods[level].triangle_count;
      report->proxy_bytes += rocks->proxies[i].lods[level].blob_size;
    }
  }
  double stage[7] = {0};
  for (uint32_t w = 0; w < set->bake->worker_count; ++w) {
    const bake_worker* worker = &set->bake->workers[w];
    for (int i = 0; i < 3; ++i) stage[i] += worker->rock.seconds[i];
    stage[3] += worker->mesh_seconds;
    stage[4] += worker->encode_seconds;
    stage[5] += worker->burial_seconds;
    stage[6] += worker->proxy_seconds;
  }
  add_stage(report, "voronoi", stage[0]);
  add_stage(report, "contacts", stage[1]);
  add_stage(report, "erosion", stage[2]);
  add_stage(report, "meshes", stage[3]);
  add_stage(report, "encode", stage[4]);
  add_stage(report, "burial", stage[5]);
  add_stage(report, "proxies", stage[6]);
  add_stage(report, "write", write_seconds);
  report->seconds = seconds;
}

scree_result scree_bake_rocks(const scree_bake_desc* desc, uint8_t** bytes, size_t* size, scree_bake_report* report,
                              scree_error* error) {
  const double start = clock_seconds();
  *bytes = NULL;
  *size = 0;
  if (error != NULL) memset(error, 0, sizeof *error);
  scree_result result = recipe_check_all(desc->recipe, error);
  if (result != SCREE_OK) return result;
  bake_run bake;
  result = bake_begin(desc, false, &bake);
  if (result != SCREE_OK) return result;

  set_bake set = {.bake = &bake, .desc = desc};
  atomic_init(&set.failure, SCREE_OK);
  atomic_init(&set.jobs_done, 0);
  bake_progress_begin(&set.progress, desc->progress, desc->progress_user);
  uint32_t* cell_first = scree_rt_allocate(&bake.allocator, (size_t)bake.cell_count + 1, sizeof *cell_first);
  result = cell_first == NULL ? SCREE_ERROR_OUT_OF_MEMORY : bake_set(&set, &desc->jobs);

  char* recipe_text = NULL;
  size_t recipe_size = 0;
  double write_start = clock_seconds();
  if (result == SCREE_OK) {
    /* Closes the gaps that rocks too small for a single voxel left. Their records own nothing. */
    uint32_t kept = 0;
    for (uint32_t cell = 0; cell < bake.cell_count; ++cell) {
      cell_first[cell] = kept;
      for (uint32_t slot = bake.cell_rocks[cell]; slot < bake.cell_rocks[cell + 1]; ++slot)
        if (set.rocks[slot].hull != NULL) {
          if (kept != slot) {
            set.rocks[kept] = set.rocks[slot];
            memset(&set.rocks[slot], 0, sizeof set.rocks[slot]);
          }
          ++kept;
        }
    }
    cell_first[bake.cell_count] = kept;
    recipe_size = scree_recipe_write(&bake.recipe, NULL, 0) + 1;
    recipe_text = scree_rt_allocate(&bake.allocator, recipe_size, 1);
    if (recipe_text == NULL)
      result = SCREE_ERROR_OUT_OF_MEMORY;
    else {
      scree_recipe_write(&bake.recipe, recipe_text, recipe_size);
      const rock_set rocks = {.cells_per_cube = bake.seeds.n,
                              .lattice_per_cell = bake.recipe.lattice_steps * bake.recipe.voxels_per_cell,
                              .lod_count = bake.recipe.lod_levels,
                              .cell_count = bake.cell_count,
                              .rock_count = kept,
                              .cell_first = cell_first,
                              .rocks = set.rocks,
                              .proxies = set.proxies,
                              .proxy_per_cell = set.proxies != NULL ? proxies_per_cell(&bake) : 0,
                              .recipe = recipe_text};
      result = pack_write(&rocks, &bake.allocator, bytes, size);
      if (result == SCREE_OK && report != NULL) {
        fill_report(&set, &rocks, clock_seconds() - start, clock_seconds() - write_start, report);
        report->bytes = *size;
        report->digest = pack_bytes_digest(*bytes);
      }
    }
  }
  scree_rt_release(&bake.allocator, recipe_text, recipe_size, 1);
  free_set(&set);
  scree_rt_release(&bake.allocator, cell_first, (size_t)bake.cell_count + 1, sizeof *cell_first);
  bake_end(&bake);
  return result;
}

void scree_bake_free(const scree_bake_desc* desc, uint8_t* bytes, size_t size) {
  const scree_allocator allocator = scree_rt_allocator_or_default(&desc->allocator);
  scree_rt_release(&allocator, bytes, size, 1);
}
