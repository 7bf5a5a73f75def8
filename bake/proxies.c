/* The union of a tile's rocks is sampled on a grid of about 20 samples a side; gaps of up to two samples are closed and voids
 * filled, so that nothing but the outer surface is left. Levels are surface nets of averages of it, with the union's volume: 12 to
 * 3 blocks a side for a tile, 6 to 2 for an eighth. Rocks stick out of their tile, and so do proxies: they overlap their
 * neighbours. */
#include "proxies.h"

#include <math.h>
#include <string.h>

#include "draco_encode.h"
#include "lod_error.h"
#include "plain_encode.h"
#include "random.h"
#include "voxel_mask.h"

enum { SAMPLES_PER_TILE = 20, LEVEL_TABLE = 6, LINES = 32 };

/* How far proxies reach into their neighbours: cells, and blocks of the level. */
#define OVERLAP 0.1
#define OVERLAP_PER_BLOCK 0.15

/* Share of the light that stays when crevices between stones are averaged into a surface without them: measured, so that a pile is
 * as bright with proxies as with rocks. */
#define CREVICES 0.95

#define LEAST_VOLUME 0.75 /* share of the volume that a level has to hold */

/* Blocks across a tile and across half of one, from the finest level to the coarsest. */
static const double blocks_across[2][LEVEL_TABLE] = {{12, 9, 6.7, 5, 4, 3.3}, {6, 5, 3.4, 2.5, 2.2, 2}};

static uint32_t mask_per_cell(const bake_run* bake) {
  return bake->seeds.voxels / mask_step(bake->seeds.voxels);
}

/* Lattice steps to a mask voxel: even, and as many as leave the coordinates of a proxy in a byte. */
static uint32_t steps_per_voxel(const bake_run* bake) {
  const uint32_t steps = 255 / ((bake->seeds.n + 1) * mask_per_cell(bake)) & ~1u;
  return steps < 2 ? 2 : steps;
}

uint32_t proxies_per_cell(const bake_run* bake) {
  return steps_per_voxel(bake) * mask_per_cell(bake);
}

scree_result proxy_scratch_create(const bake_run* bake, proxy_scratch* out) {
  memset(out, 0, sizeof *out);
  out->bake = bake;
  const uint32_t per_cell = out->mask_per_cell = mask_per_cell(bake), across = bake->seeds.n * per_cell;
  out->voxels = across < SAMPLES_PER_TILE ? 1 : (across + SAMPLES_PER_TILE / 2) / SAMPLES_PER_TILE;
  out->size = ((bake->seeds.n + 2) * per_cell + out->voxels - 1) / out->voxels;
  out->step = steps_per_voxel(bake) * out->voxels;
  out->samples = (size_t)out->size * out->size * out->size;
  /* Levels have at most as many blocks as there are samples, and a border of two on each side. */
  const size_t side = out->size + 4;
  out->value_capacity = (size_t)round_to_lanes((uint32_t)side) * side * side;
  out->row_capacity = side * side;
  const scree_allocator* allocator = &bake->allocator;
  out->counts = scree_rt_allocate(allocator, PROXY_PARTS * out->samples, sizeof *out->counts);
  out->density = scree_rt_allocate(allocator, out->samples, sizeof *out->density);
  out->values = scree_rt_allocate(allocator, out->value_capacity, sizeof *out->values);
  out->rows = scree_rt_allocate(allocator, out->row_capacity, sizeof *out->rows);
  out->scratch = scree_rt_allocate(allocator, 2 * out->row_capacity, sizeof *out->scratch);
  if (out->counts == NULL || out->density == NULL || out->values == NULL || out->rows == NULL || out->scratch == NULL) {
    proxy_scratch_destroy(out);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  return SCREE_OK;
}

void proxy_scratch_destroy(proxy_scratch* scratch) {
  if (scratch->bake == NULL) return;
  const scree_allocator* allocator = &scratch->bake->allocator;
  scree_rt_release(allocator, scratch->counts, PROXY_PARTS * scratch->samples, sizeof *scratch->counts);
  scree_rt_release(allocator, scratch->density, scratch->samples, sizeof *scratch->density);
  scree_rt_release(allocator, scratch->values, scratch->value_capacity, sizeof *scratch->values);
  scree_rt_release(allocator, scratch->rows, scratch->row_capacity, sizeof *scratch->rows);
  scree_rt_release(allocator, scratch->scratch, 2 * scratch->row_capacity, sizeof *scratch->scratch);
  scree_rt_release(allocator, scratch->points, scratch->point_capacity, sizeof *scratch->points);
  scree_rt_release(allocator, scratch->fans, scratch->fan_capacity, sizeof *scratch->fans);
  mesh_buffer_destroy(&scratch->fine, allocator);
  mesh_buffer_destroy(&scratch->mesh, allocator);
  memset(scratch, 0, sizeof *scratch);
}

static scree_result reserve(const scree_allocator* allocator, void** memory, uint32_t* capacity, uint32_t count) {
  if (count <= *capacity) return SCREE_OK;
  scree_rt_release(allocator, *memory, *capacity, 4);
  *capacity = 0;
  *memory = scree_rt_allocate(allocator, (size_t)count * 2, 4);
  if (*memory == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  *capacity = count * 2;
  return SCREE_OK;
}

/* --- The union. --- */

/* Full voxels of every sample, for each part and for the whole. */
static void count_voxels(proxy_scratch* s, uint32_t code, const rock_mask* masks) {
  memset(s->counts, 0, PROXY_PARTS * s->samples * sizeof *s->counts);
  const uint32_t n = s->bake->seeds.n, low_half = (n + 1) / 2, per_cell = s->mask_per_cell;
  for (uint32_t place = 0; place < n * n * n; ++place) {
    const uint32_t x = place % n, y = place / n % n, z = place / n / n,
                   cell = scree_rt_lattice_cell(s->bake->seeds.n, code, x, y, z);
    const uint32_t part = 1 + (x >= low_half) + 2 * (y >= low_half) + 4 * (z >= low_half);
    /* First voxel of the box of two cells around the cell; the grid begins a cell before the tile. */
    const uint32_t x0 = (x + 1) * per_cell - per_cell / 2, y0 = (y + 1) * per_cell - per_cell / 2,
                   z0 = (z + 1) * per_cell - per_cell / 2;
    uint16_t* counts = s->counts + part * s->samples;
    for (uint32_t slot = s->bake->cell_rocks[cell]; slot < s->bake->cell_rocks[cell + 1]; ++slot) {
      const rock_mask* mask = &masks[slot];
      const uint32_t* next = mask->rows;
      if (next == NULL) continue;
      for (uint32_t k = 0; k < mask->size[2]; ++k)
        for (uint32_t j = 0; j < mask->size[1]; ++j) {
          const uint32_t sample_y = (y0 + mask->min[1] + j) / s->voxels, sample_z = (z0 + mask->min[2] + k) / s->voxels;
          uint16_t* row = counts + s->size * (sample_y + (size_t)s->size * sample_z);
          for (uint32_t bits = *next++; bits != 0; bits &= bits - 1) ++row[(x0 + (uint32_t)__builtin_ctz(bits)) / s->voxels];
        }
    }
  }
  for (uint32_t part = 1; part < PROXY_PARTS; ++part)
    for (size_t i = 0; i < s->samples; ++i) s->counts[i] = (uint16_t)(s->counts[i] + s->counts[part * s->samples + i]);
}

/* The density of a part's union. rows keep the samples that are rock, gaps left open. Returns its sum. */
static double close_union(proxy_scratch* s, uint32_t part) {
  const uint16_t* counts = s->counts + part * s->samples;
  const uint32_t full = s->voxels * s->voxels * s->voxels, size = s->size;
  uint64_t *open = s->rows, *closed = s->scratch;
  uint64_t* more = s->scratch + s->row_capacity;
  for (uint32_t row = 0; row < size * size; ++row) {
    open[row] = 0;
    for (uint32_t x = 0; x < size; ++x) open[row] |= (uint64_t)(2u * counts[row * size + x] >= full) << x;
  }
  memcpy(closed, open, (size_t)size * size * sizeof *closed);
  mask_grow(closed, size, size, more);
  uint64_t* flood = (uint64_t*)(void*)s->values; /* not in use yet */
  mask_fill_voids(closed, size, size, size, flood);
  mask_shrink(closed, size, size, more);
  double sum = 0;
  for (uint32_t row = 0; row < size * size; ++row)
    for (uint32_t x = 0; x < size; ++x) {
      const size_t i = (size_t)row * size + x;
      s->density[i] = (closed[row] | open[row]) >> x & 1 ? 1 : (float)counts[i] / (float)full;
      sum += (double)s->density[i];
    }
  return sum;
}

/* --- One level. --- */

/* Means over blocks of `span` samples a side, one half less, as a field that reaches a block beyond the samples on all sides. */
static void average(proxy_scratch* s, uint32_t span, voxel_field* out) {
  const uint32_t size = s->size, blocks = (size + span - 1) / span + 2, width = round_to_lanes(blocks);
  /* Blocks lie even about the middle of the samples. */
  const uint32_t before = ((blocks - 2) * span - size) / 2 + span;
  *out = (voxel_field){s->values, s->rows, width, blocks, blocks, {0}, (int32_t)(span * s->step)};
  const int32_t per_cell = (int32_t)s->mask_per_cell, per_voxel = (int32_t)(s->step / s->voxels);
  const int32_t first = (per_cell / 2 - 2 * per_cell) * per_voxel - (int32_t)(before * s->step);
  for (int axis = 0; axis < 3; ++axis) out->origin[axis] = first + out->step / 2;
  const size_t count = (size_t)width * blocks * blocks;
  memset(s->values, 0, count * sizeof *s->values);
  uint32_t block_of[64]; /* samples a side fit a word */
  for (uint32_t x = 0; x < size; ++x) block_of[x] = (x + before) / span;
  for (uint32_t z = 0; z < size; ++z)
    for (uint32_t y = 0; y < size; ++y) {
      const float* row = s->density + size * (y + (size_t)size * z);
      float* to = s->values + width * (block_of[y] + (size_t)blocks * block_of[z]);
      for (uint32_t x = 0; x < size; ++x) to[block_of[x]] += row[x];
    }
  const float inverse = 1.0f / (float)(span * span * span);
  for (size_t i = 0; i < count; ++i) s->values[i] = s->values[i] * inverse - 0.5f;
}

/* Meshes the density at blocks of `span` samples. False in *any: nothing is left at this size. */
static scree_result mesh_blocks(proxy_scratch* s, uint32_t span, voxel_field* field, mesh_buffer* mesh, bool* any) {
  average(s, span, field);
  const uint32_t rows = field->height * field->depth;
  s->bake->kernels->sign_rows(field->values, field->width, rows, field->rows);
  mask_make_well_composed(field->rows, field->height, field->depth, field->values, field->width, 0.02f);
  *any = false;
  for (uint32_t row = 0; row < rows; ++row) *any |= field->rows[row] != 0;
  if (!*any) return SCREE_OK;
  const scree_allocator* allocator = &s->bake->allocator;
  scree_result result = mesh_field(field, mesh, allocator);
  if (result == SCREE_OK) result = reserve(allocator, (void**)&s->points, &s->point_capacity, 9 * mesh->vertex_count);
  if (result != SCREE_OK) return result;
  surface_nets_triangulate(mesh);
  return SCREE_OK;
}

/* Whether a sample, by its place in samples, is rock. */
static bool is_full(const proxy_scratch* s, const uint16_t* counts, const double p[3]) {
  for (int axis = 0; axis < 3; ++axis)
    if (!(p[axis] >= 0 && p[axis] < s->size)) return false;
  const size_t sample = (size_t)p[0] + s->size * ((size_t)p[1] + (size_t)s->size * (size_t)p[2]);
  return 2u * counts[sample] >= s->voxels * s->voxels * s->voxels;
}

/* How open the sky is over every vertex: the share of lines into its hemisphere that meet no rock of the union, gaps left open,
 * within a cell and a half. */
static void shade(proxy_scratch* s, const uint16_t* counts, uint32_t rock_occlusion, mesh_buffer* mesh) {
  double directions[LINES][3];
  random_stream stream = {UINT64_C(0x5c1e)};
  for (uint32_t i = 0; i < LINES; ++i) random_direction(&stream, directions[i]);
  float* normals = s->points;
  memset(normals, 0, (size_t)mesh->vertex_count * 3 * sizeof *normals);
  for (uint32_t i = 0; i < mesh->index_count; i += 3) {
    const uint32_t* corner = mesh->indices + i;
    const int16_t *a = mesh->positions[corner[0]], *b = mesh->positions[corner[1]], *c = mesh->positions[corner[2]];
    const int32_t u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, w[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    const int32_t n[3] = {u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]};
    for (int k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis) normals[corner[k] * 3 + (uint32_t)axis] += (float)n[axis];
  }
  const int32_t per_cell = (int32_t)s->mask_per_cell;
  const double origin = (per_cell / 2 - 2 * per_cell) * (double)(s->step / s->voxels), inverse = 1.0 / s->step;
  const uint32_t reach = 1 + 3 * s->mask_per_cell / (2 * s->voxels);
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    const float* n = normals + (size_t)v * 3;
    const double length = sqrt((double)(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])), scale = length > 0 ? 1 / length : 0;
    double start[3];
    /* From the first sample above the surface that is open: a level cuts through stones. */
    for (uint32_t lift = 1; lift <= 4; ++lift) {
      for (int axis = 0; axis < 3; ++axis)
        start[axis] = (mesh->positions[v][axis] - origin) * inverse + lift * (double)n[axis] * scale;
      if (!is_full(s, counts, start)) break;
    }
    double total = 0, seen = 0;
    for (uint32_t i = 0; i < LINES; ++i) {
      double cosine = 0, p[3];
      for (int axis = 0; axis < 3; ++axis) cosine += directions[i][axis] * (double)n[axis] * scale;
      const double side = cosine < 0 ? -1 : 1; /* lines downward are turned up */
      memcpy(p, start, sizeof p);
      bool blocked = false;
      for (uint32_t at = 0; at < reach && !blocked; ++at) {
        blocked = is_full(s, counts, p);
        for (int axis = 0; axis < 3; ++axis) p[axis] += side * directions[i][axis];
      }
      total += side * cosine;
      if (!blocked) seen += side * cosine;
    }
    mesh->occlusion[v] = (uint8_t)(rock_occlusion * CREVICES * (total > 0 ? seen / total : 1));
  }
}

/* A grain, for a part in which nothing is left of any rock. */
static scree_result mesh_grain(proxy_scratch* s, uint32_t part, mesh_buffer* mesh) {
  const scree_result result = mesh_buffer_reserve(mesh, 4, 12, 1, &s->bake->allocator);
  if (result != SCREE_OK) return result;
  static const uint32_t corners[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  memcpy(mesh->indices, corners, sizeof corners);
  mesh->vertex_count = 4, mesh->index_count = 12;
  const uint32_t n = s->bake->seeds.n;
  for (uint32_t v = 0; v < 4; ++v) {
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const uint32_t cell = part == 0 ? n / 2 : (part - 1) >> axis & 1 ? n - 1 : 0;
      mesh->positions[v][axis] = (int16_t)(cell * proxies_per_cell(s->bake) + (v == axis + 1 ? 1 : 0));
    }
    mesh->occlusion[v] = 255;
  }
  return SCREE_OK;
}

static scree_result encode(const proxy_scratch* s, const mesh_buffer* mesh, uint32_t level, float error, rock_lod* out) {
  const lattice_mesh source = {.positions = mesh->positions,
                               .occlusion = mesh->occlusion,
                               .indices = mesh->indices,
                               .vertex_count = mesh->vertex_count,
                               .triangle_count = mesh->index_count / 3,
                               .error = error};
  const bool coarsest = level + 1 == s->bake->recipe.lod_levels;
  const scree_result result = (coarsest ? plain_encode : draco_encode)(&source, &s->bake->allocator, out);
  out->error = error;
  return result;
}

/* Cells of a part along an axis. */
static double side_of(uint32_t n, uint32_t part, uint32_t axis) {
  return part == 0 ? n : (part - 1) >> axis & 1 ? n / 2 : (n + 1) / 2;
}

/* How much more a box of a part's sides holds when it is larger by `margin` cells on each. */
static double grown_by(uint32_t n, uint32_t part, double margin) {
  double grown = 1;
  for (uint32_t axis = 0; axis < 3; ++axis) grown *= 1 + 2 * margin / side_of(n, part, axis);
  return grown;
}

static scree_result bake_part(proxy_scratch* s, uint32_t part, uint32_t rock_occlusion, proxy_record* out) {
  const uint16_t* counts = s->counts + part * s->samples;
  const scree_allocator* allocator = &s->bake->allocator;
  const double volume = close_union(s, part) * s->step * s->step * s->step;
  voxel_field field;
  bool any;
  scree_result result = mesh_blocks(s, 1, &field, &s->fine, &any);
  if (result != SCREE_OK) return result;
  const bool is_grain = !any;
  const uint32_t levels = s->bake->recipe.lod_levels, per_cell = proxies_per_cell(s->bake);
  const double across = (double)s->bake->seeds.n * s->mask_per_cell / s->voxels * (part == 0 ? 1 : 0.5);
  /* The fine mesh itself is off by up to half a sample, and has gaps closed. */
  float error = 0.5f * (float)s->step / (float)per_cell;
  for (uint32_t level = 0; level < levels; ++level) {
    if (is_grain) {
      result = mesh_grain(s, part, &s->mesh);
      if (result == SCREE_OK) result = encode(s, &s->mesh, level, 0, &out->lods[level]);
      if (result != SCREE_OK) return result;
      continue;
    }
    const uint32_t entry = levels == 1 ? LEVEL_TABLE - 1 : (2 * level * (LEVEL_TABLE - 1) + levels - 1) / (2 * (levels - 1));
    uint32_t span = (uint32_t)(across / blocks_across[part == 0 ? 0 : 1][entry] + 0.5);
    if (span < 1) span = 1;
    /* A part that is too sparse or thin for blocks of this size has finer ones. */
    bool lost = true;
    for (; span > 0 && lost; --span) {
      result = mesh_blocks(s, span, &field, &s->mesh, &any);
      if (result != SCREE_OK) return result;
      if (!any) continue;
      /* So much larger on all sides that the rounded edges of neighbours meet. */
      const double grown = grown_by(s->bake->seeds.n, part, OVERLAP + OVERLAP_PER_BLOCK * field.step / per_cell);
      mesh_match_volume(&s->mesh, volume * grown, 0.6f * (float)field.step, s->points);
      lost = mesh_volume(&s->mesh) < LEAST_VOLUME * volume;
    }
    shade(s, counts, rock_occlusion, &s->mesh);
    result = reserve(allocator, (void**)&s->fans, &s->fan_capacity, lod_error_scratch(&s->mesh));
    if (result == SCREE_OK) result = reserve(allocator, (void**)&s->points, &s->point_capacity, s->fine.vertex_count);
    if (result != SCREE_OK) return result;
    const float off = lod_error_of_most(&s->fine, &s->mesh, &field, s->fans, s->points) + 0.5f * (float)s->step;
    if (off > error * (float)per_cell) error = off / (float)per_cell;
    result = encode(s, &s->mesh, level, error, &out->lods[level]);
    if (result != SCREE_OK) return result;
  }
  return SCREE_OK;
}

scree_result proxies_of_tile(proxy_scratch* scratch, uint32_t code, const rock_mask* masks, uint32_t rock_occlusion,
                             proxy_record out[PROXY_PARTS]) {
  count_voxels(scratch, code, masks);
  for (uint32_t part = 0; part < PROXY_PARTS; ++part) {
    const scree_result result = bake_part(scratch, part, rock_occlusion, &out[part]);
    if (result != SCREE_OK) return result;
  }
  return SCREE_OK;
}
