/* Based on: Peytavie et al. 2009, section 5. Where we differ: erosion acts on a continuous field instead of voxels' states, is
 * damped by the rock's own contacts only (so that a rock depends on its 27 cells), and only ever subtracts, which keeps every rock
 * inside its Voronoi cell: no overlap at any point. Chisel planes lie outside all contacts, so they spare them. */
#include "rock_field.h"

#include <string.h>

#include "clock.h"
#include "random.h"
#include "voxel_mask.h"

#define FIELD_LIMIT 0.5f /* cells; deeper or farther than this makes no difference */
#define MARGIN 2         /* empty voxels around what a rock owns */

scree_result rock_worker_create(const scree_recipe* recipe, const shared_blocks* shared, const scree_allocator* allocator,
                                rock_worker* out) {
  memset(out, 0, sizeof *out);
  out->recipe = recipe;
  out->seeds = shared->seeds;
  out->tables = shared->tables;
  out->kernels = shared->kernels;
  const uint32_t side = 2 * out->seeds->voxels + 2 * MARGIN;
  out->capacity = round_to_lanes(side) * side * side;
  scree_result result = block_cache_create(shared, allocator, &out->blocks);
  if (result == SCREE_OK)
    result = noise_scratch_create(round_to_lanes(side) + LANES, (double)(side + LANES) / out->seeds->voxels,
                                  out->seeds->voxels * 0.5, allocator, &out->noise_scratch);
  out->memory = scree_rt_allocate(allocator, (size_t)4 * (out->capacity + 2 * LANES), sizeof(float));
  out->rows = scree_rt_allocate(allocator, (size_t)3 * side * side, sizeof *out->rows);
  if (result == SCREE_OK && (out->memory == NULL || out->rows == NULL)) result = SCREE_ERROR_OUT_OF_MEMORY;
  if (result != SCREE_OK) {
    rock_worker_destroy(out, allocator);
    return result;
  }
  /* One group of lanes before and after each grid: the Laplacian reads a voxel to either side. */
  float** grids[4] = {&out->field, &out->omega, &out->other, &out->noise};
  memset(out->memory, 0, (size_t)4 * (out->capacity + 2 * LANES) * sizeof(float));
  for (size_t i = 0; i < 4; ++i) *grids[i] = out->memory + i * (out->capacity + 2 * LANES) + LANES;
  out->row_scratch = out->rows + (size_t)side * side;
  return SCREE_OK;
}

void rock_worker_destroy(rock_worker* worker, const scree_allocator* allocator) {
  const size_t side = worker->seeds == NULL ? 0 : 2 * worker->seeds->voxels + 2 * MARGIN;
  block_cache_destroy(&worker->blocks, allocator);
  noise_scratch_destroy(&worker->noise_scratch, allocator);
  scree_rt_release(allocator, worker->memory, (size_t)4 * (worker->capacity + 2 * LANES), sizeof(float));
  scree_rt_release(allocator, worker->rows, 3 * side * side, sizeof *worker->rows);
  memset(worker, 0, sizeof *worker);
}

/* Sets the grid around the voxels that the rock owns in its eight blocks. */
static bool find_grid(rock_grid* grid, const block* const blocks[8], uint32_t seed, int32_t voxels) {
  int32_t low[3] = {INT32_MAX, INT32_MAX, INT32_MAX}, high[3] = {-1, -1, -1};
  for (uint32_t b = 0; b < 8; ++b) {
    const uint8_t* bounds = blocks[b]->bounds[blocks[b]->first[7 - b] + seed];
    if (bounds[0] > bounds[3]) continue;
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const int32_t base = b >> axis & 1 ? voxels : 0;
      if (base + bounds[axis] < low[axis]) low[axis] = base + bounds[axis];
      if (base + bounds[3 + axis] > high[axis]) high[axis] = base + bounds[3 + axis];
    }
  }
  if (high[0] < 0) return false;
  for (uint32_t axis = 0; axis < 3; ++axis) {
    grid->min[axis] = low[axis] - MARGIN;
    grid->size[axis] = (uint32_t)(high[axis] - low[axis] + 1 + 2 * MARGIN);
  }
  grid->size[0] = round_to_lanes(grid->size[0]);
  return true;
}

/* Coordinates of the grid's voxels along one axis. */
typedef struct axis_table {
  float from_cell[64]; /* cells from the home cell's centre */
  float from_seed[64]; /* cells from the seed */
  float weight[64];    /* 1 / w; beyond the support, that of its last voxel: such voxels are never owned */
} axis_table;

static void fill_axis(const rock_worker* worker, uint32_t axis, int32_t seed, axis_table* out) {
  const int32_t voxels = (int32_t)worker->seeds->voxels;
  const block_tables* tables = worker->tables;
  for (uint32_t i = 0; i < worker->grid.size[axis]; ++i) {
    const int32_t v = worker->grid.min[axis] + (int32_t)i, units = 256 * (2 * (v - voxels) + 1);
    out->from_cell[i] = (float)units * tables->cells_per_unit;
    out->from_seed[i] = ((float)units - (float)seed) * tables->cells_per_unit;
    const int32_t clamped = v < 0 ? 0 : v >= 2 * voxels ? 2 * voxels - 1 : v;
    out->weight[i] = clamped < voxels ? tables->weight[1][clamped] : tables->weight[0][clamped - voxels];
  }
}

bool rock_voronoi(rock_worker* worker, int32_t x, int32_t y, int32_t z, uint32_t seed) {
  const double start = clock_seconds();
  const int32_t voxels = (int32_t)worker->seeds->voxels;
  const block* blocks[8];
  for (int32_t b = 0; b < 8; ++b)
    blocks[b] = block_cache_get(&worker->blocks, x - 1 + (b & 1), y - 1 + (b >> 1 & 1), z - 1 + (b >> 2));
  if (!find_grid(&worker->grid, blocks, seed, voxels)) return false;
  const rock_grid* grid = &worker->grid;

  neighbourhood_gather(worker->seeds, worker->blocks.code, x, y, z, &worker->around);
  const rock_seed* own_seed = &worker->around.seeds[13][seed];
  axis_table axes[3];
  for (uint32_t axis = 0; axis < 3; ++axis) fill_axis(worker, axis, own_seed->position[axis], &axes[axis]);

  float nearest[64], depth[64], inverse_slope[64];
  int32_t own[64];
  rock_row row = {.count = grid->size[0],
                  .x = axes[0].from_cell,
                  .dx = axes[0].from_seed,
                  .weight_x = axes[0].weight,
                  .metric = own_seed->metric,
                  .level = worker->tables->level,
                  .nearest = nearest,
                  .depth = depth,
                  .inverse_slope = inverse_slope,
                  .own = own};
  const uint32_t plane = worker->tables->plane;
  for (uint32_t k = 0; k < grid->size[2]; ++k)
    for (uint32_t j = 0; j < grid->size[1]; ++j) {
      const int32_t vy = grid->min[1] + (int32_t)j, vz = grid->min[2] + (int32_t)k;
      float* field = worker->field + (size_t)grid->size[0] * (j + (size_t)grid->size[1] * k);
      if (vy < 0 || vz < 0 || vy >= 2 * voxels || vz >= 2 * voxels) {
        for (uint32_t i = 0; i < grid->size[0]; ++i) field[i] = -FIELD_LIMIT;
        continue;
      }
      for (uint32_t i = 0; i < grid->size[0];) {
        const int32_t vx = grid->min[0] + (int32_t)i;
        if (vx < 0 || vx >= 2 * voxels) {
          nearest[i] = -1, depth[i] = 0, inverse_slope[i] = 1e6f, own[i] = 0;
          ++i;
          continue;
        }
        /* The part of the row that lies in one block. */
        const int32_t half = vx < voxels ? 0 : 1;
        const uint32_t b = (uint32_t)(half | (vy < voxels ? 0 : 2) | (vz < voxels ? 0 : 4));
        const block* from = blocks[b];
        const int32_t local_z = vz % voxels, local_y = vy % voxels, local_x = vx - half * voxels;
        uint32_t count = (uint32_t)(voxels - local_x);
        if (count > grid->size[0] - i) count = grid->size[0] - i;
        const size_t at = (size_t)local_z * plane + (size_t)(local_y * voxels + local_x);
        memcpy(nearest + i, from->fields.nearest + at, count * sizeof(float));
        memcpy(depth + i, from->fields.depth + at, count * sizeof(float));
        memcpy(inverse_slope + i, from->fields.inverse_slope + at, count * sizeof(float));
        const uint32_t number = from->first[7 - b] + seed;
        for (uint32_t n = 0; n < count; ++n) own[i + n] = from->fields.owner[at + n] == number ? -1 : 0;
        i += count;
      }
      row.y = axes[1].from_cell[j], row.z = axes[2].from_cell[k];
      row.dy = axes[1].from_seed[j], row.dz = axes[2].from_seed[k];
      row.weight_y = axes[1].weight[j], row.weight_z = axes[2].weight[k];
      worker->kernels->rock_field(&row, FIELD_LIMIT, field);
    }
  const double middle = clock_seconds();
  worker->seconds[0] += middle - start;
  worker->contact_count = contacts_find(&worker->around, seed, worker->recipe->contact_discard, worker->contacts);
  worker->seconds[1] += clock_seconds() - middle;
  return true;
}

/* Random half-spaces that hold all contacts with a margin to spare. */
static uint32_t chisel(const rock_worker* worker, uint64_t key, float (*planes)[4]) {
  const scree_recipe* recipe = worker->recipe;
  random_stream stream = {hash_combine(key, 1)};
  for (uint32_t p = 0; p < recipe->chisel_planes; ++p) {
    double normal[3], reach = 0.15; /* never so near to the cell's centre that nothing is left */
    random_direction(&stream, normal);
    for (uint32_t c = 0; c < worker->contact_count; ++c) {
      double along = 0;
      for (int axis = 0; axis < 3; ++axis) along += normal[axis] * worker->contacts[c].position[axis];
      along /= worker->seeds->unit;
      if (along > reach) reach = along;
    }
    reach += recipe->chisel_margin * (0.5 + random_unit(&stream));
    for (int axis = 0; axis < 3; ++axis) planes[p][axis] = (float)normal[axis];
    planes[p][3] = (float)reach;
  }
  return recipe->chisel_planes;
}

static uint32_t find_rows(rock_worker* worker) {
  const rock_grid* grid = &worker->grid;
  const float carved = 0.02f / (float)worker->seeds->voxels; /* a fiftieth of a voxel */
  worker->kernels->sign_rows(worker->field, grid->size[0], grid->size[1] * grid->size[2], worker->rows);
  mask_make_well_composed(worker->rows, grid->size[1], grid->size[2], worker->field, grid->size[0], carved);
  return mask_keep_largest(worker->rows, grid->size[1], grid->size[2], worker->field, grid->size[0], carved, worker->row_scratch);
}

uint32_t rock_erode(rock_worker* worker, uint64_t key) {
  const double start = clock_seconds();
  const scree_recipe* recipe = worker->recipe;
  const rock_grid* grid = &worker->grid;
  const size_t count = (size_t)grid->size[0] * grid->size[1] * grid->size[2];
  const float voxel = 1.0f / (float)worker->seeds->voxels;

  memset(worker->noise, 0, count * sizeof(float));
  if (recipe->noise > 0) {
    noise_grid at = {{grid->size[0], grid->size[1], grid->size[2]}, {0, 0, 0}, voxel};
    for (uint32_t axis = 0; axis < 3; ++axis)
      at.origin[axis] = ((float)(grid->min[axis] - (int32_t)worker->seeds->voxels) + 0.5f) * voxel;
    double frequency = recipe->noise_frequency, amplitude = recipe->noise, share = 0, weight = 1;
    for (uint32_t octave = 0; octave < recipe->noise_octaves; ++octave, weight *= 0.5) share += weight;
    for (uint32_t octave = 0; octave < recipe->noise_octaves; ++octave, frequency *= 2, amplitude *= 0.5)
      if (frequency <= worker->seeds->voxels * 0.5) /* finer octaves would only alias */
        noise_add(&worker->noise_scratch, &at, (float)frequency, (float)(amplitude / share), hash_combine(key, 2 + octave),
                  worker->noise);
  }

  float contacts[MAX_CONTACTS][3], planes[64][4];
  for (uint32_t c = 0; c < worker->contact_count; ++c)
    for (uint32_t axis = 0; axis < 3; ++axis)
      contacts[c][axis] = (float)worker->contacts[c].position[axis] * worker->tables->cells_per_unit;
  rock_shape shape = {.contact_count = worker->contact_count,
                      .contacts = (const float(*)[3])contacts,
                      .contact_radius = (float)recipe->contact_radius,
                      .inverse_blend = (float)(1 / (recipe->contact_blend - recipe->contact_radius)),
                      .erosion = (float)recipe->erosion,
                      .planes = (const float(*)[4])planes};
  shape.plane_count = chisel(worker, key, planes);

  axis_table axes[3];
  for (uint32_t axis = 0; axis < 3; ++axis) fill_axis(worker, axis, 0, &axes[axis]);
  rock_row row = {.count = grid->size[0], .x = axes[0].from_cell};
  for (uint32_t k = 0; k < grid->size[2]; ++k)
    for (uint32_t j = 0; j < grid->size[1]; ++j) {
      const size_t at = (size_t)grid->size[0] * (j + (size_t)grid->size[1] * k);
      row.y = axes[1].from_cell[j], row.z = axes[2].from_cell[k];
      worker->kernels->rock_erode(&row, &shape, worker->noise + at, worker->field + at, worker->omega + at);
    }
  for (uint32_t step = 0; step < recipe->erosion_steps; ++step) {
    worker->kernels->carve_step(worker->field, worker->omega, worker->other, grid->size[0], grid->size[1], grid->size[2],
                                (float)(recipe->erosion_strength / 6));
    float* swap = worker->field;
    worker->field = worker->other;
    worker->other = swap;
  }
  const uint32_t left = find_rows(worker);
  worker->seconds[2] += clock_seconds() - start;
  return left;
}
