#include "rock_mesh.h"

#include <math.h>
#include <string.h>

#include "lod_error.h"
#include "voxel_mask.h"

/* Voxels of the averaged fields of the coarser levels, in voxels of the finest. */
static const uint32_t level_steps[ROCK_MAX_LODS] = {1, 2, 3, 4, 6, 8};

#define BLUR 2 /* voxels that the density is blurred over, to either side */

scree_result rock_mesher_create(const rock_worker* worker, uint32_t lattice_per_voxel, const scree_allocator* allocator,
                                rock_mesher* out) {
  memset(out, 0, sizeof *out);
  out->allocator = allocator;
  out->kernels = worker->kernels;
  out->lattice_per_voxel = lattice_per_voxel;
  out->capacity = worker->capacity;
  out->coarse = scree_rt_allocate(allocator, out->capacity, sizeof *out->coarse);
  out->coarse_rows = scree_rt_allocate(allocator, (size_t)3 * out->capacity / LANES, sizeof *out->coarse_rows);
  out->density = scree_rt_allocate(allocator, out->capacity, sizeof *out->density);
  out->blur = scree_rt_allocate(allocator, out->capacity, sizeof *out->blur);
  if (out->coarse == NULL || out->coarse_rows == NULL || out->density == NULL || out->blur == NULL) {
    rock_mesher_destroy(out);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  return SCREE_OK;
}

void mesh_buffer_destroy(mesh_buffer* mesh, const scree_allocator* allocator) {
  scree_rt_release(allocator, mesh->positions, mesh->vertex_capacity, sizeof *mesh->positions);
  scree_rt_release(allocator, mesh->cells, mesh->vertex_capacity, sizeof *mesh->cells);
  scree_rt_release(allocator, mesh->occlusion, mesh->vertex_capacity, 1);
  scree_rt_release(allocator, mesh->indices, mesh->index_capacity, sizeof *mesh->indices);
  scree_rt_release(allocator, mesh->vertex_of, mesh->voxel_capacity, sizeof *mesh->vertex_of);
  memset(mesh, 0, sizeof *mesh);
}

void rock_mesher_destroy(rock_mesher* mesher) {
  if (mesher->allocator == NULL) return;
  for (uint32_t level = 0; level < ROCK_MAX_LODS; ++level) mesh_buffer_destroy(&mesher->meshes[level], mesher->allocator);
  scree_rt_release(mesher->allocator, mesher->coarse, mesher->capacity, sizeof *mesher->coarse);
  scree_rt_release(mesher->allocator, mesher->coarse_rows, (size_t)3 * mesher->capacity / LANES, sizeof *mesher->coarse_rows);
  scree_rt_release(mesher->allocator, mesher->density, mesher->capacity, sizeof *mesher->density);
  scree_rt_release(mesher->allocator, mesher->blur, mesher->capacity, sizeof *mesher->blur);
  scree_rt_release(mesher->allocator, mesher->points, mesher->point_capacity, sizeof *mesher->points);
  scree_rt_release(mesher->allocator, mesher->fans, mesher->fan_capacity, sizeof *mesher->fans);
  memset(mesher, 0, sizeof *mesher);
}

scree_result mesh_buffer_reserve(mesh_buffer* mesh, uint32_t vertices, uint32_t indices, uint32_t voxels,
                                 const scree_allocator* allocator) {
  if (vertices <= mesh->vertex_capacity && indices <= mesh->index_capacity && voxels <= mesh->voxel_capacity) return SCREE_OK;
  vertices = vertices > mesh->vertex_capacity ? vertices + vertices / 2 : mesh->vertex_capacity;
  indices = indices > mesh->index_capacity ? indices + indices / 2 : mesh->index_capacity;
  voxels = voxels > mesh->voxel_capacity ? voxels + voxels / 2 : mesh->voxel_capacity;
  mesh_buffer_destroy(mesh, allocator);
  mesh->vertex_capacity = vertices;
  mesh->index_capacity = indices;
  mesh->voxel_capacity = voxels;
  mesh->positions = scree_rt_allocate(allocator, vertices, sizeof *mesh->positions);
  mesh->cells = scree_rt_allocate(allocator, vertices, sizeof *mesh->cells);
  mesh->occlusion = scree_rt_allocate(allocator, vertices, 1);
  mesh->indices = scree_rt_allocate(allocator, indices, sizeof *mesh->indices);
  mesh->vertex_of = scree_rt_allocate(allocator, voxels, sizeof *mesh->vertex_of);
  if (mesh->positions == NULL || mesh->cells == NULL || mesh->occlusion == NULL || mesh->indices == NULL ||
      mesh->vertex_of == NULL) {
    mesh_buffer_destroy(mesh, allocator);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  return SCREE_OK;
}

scree_result mesh_field(const voxel_field* field, mesh_buffer* mesh, const scree_allocator* allocator) {
  uint32_t vertices, indices;
  surface_nets_bounds(field, &vertices, &indices);
  const scree_result result = mesh_buffer_reserve(mesh, vertices, indices, field->width * field->height * field->depth, allocator);
  if (result == SCREE_OK) surface_nets(field, mesh);
  return result;
}

/* --- The fine field, sampled anywhere. --- */

/* Trilinear interpolation at p, in voxels; p is clamped into the grid. `slope`, if given, gets the gradient of the interpolant. */
static float sample(const float* values, const uint32_t size[3], const float p[3], float slope[3]) {
  uint32_t at[3];
  float t[3];
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const float top = (float)(size[axis] - 1) - 1e-3f, clamped = p[axis] < 0 ? 0 : p[axis] > top ? top : p[axis];
    at[axis] = (uint32_t)clamped;
    t[axis] = clamped - (float)at[axis];
  }
  const size_t dy = size[0], dz = (size_t)size[0] * size[1];
  const float* v = values + at[0] + dy * at[1] + dz * at[2];
  const float ax = v[1] - v[0], bx = v[dy + 1] - v[dy], cx = v[dz + 1] - v[dz], dx = v[dz + dy + 1] - v[dz + dy];
  const float a = v[0] + ax * t[0], b = v[dy] + bx * t[0], c = v[dz] + cx * t[0], d = v[dz + dy] + dx * t[0];
  const float e = a + (b - a) * t[1], f = c + (d - c) * t[1];
  if (slope != NULL) {
    const float low = ax + (bx - ax) * t[1], high = cx + (dx - cx) * t[1];
    slope[0] = low + (high - low) * t[2];
    slope[1] = (b - a) + ((d - c) - (b - a)) * t[2];
    slope[2] = f - e;
  }
  return e + (f - e) * t[2];
}

static float length2(const float v[3]) {
  return v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
}

/* Mean over 2 BLUR + 1 values along a row, zeros beyond its ends. */
static void blur_row(const float* in, float* out, uint32_t count) {
  float padded[64 + 2 * BLUR] = {0};
  memcpy(padded + BLUR, in, count * sizeof *in);
  for (uint32_t x = 0; x < count; ++x) {
    float sum = 0;
    for (uint32_t m = 0; m <= 2 * BLUR; ++m) sum += padded[x + m];
    out[x] = sum * (1.0f / (2 * BLUR + 1));
  }
}

/* The same across `lines` lines that lie `stride` apart, each of `length` values. */
static void blur_lines(const float* in, float* out, size_t length, uint32_t lines, size_t stride) {
  for (uint32_t line = 0; line < lines; ++line) {
    const uint32_t first = line < BLUR ? 0 : line - BLUR, last = line + BLUR >= lines ? lines - 1 : line + BLUR;
    float* to = out + line * stride;
    memset(to, 0, length * sizeof *to);
    for (uint32_t m = first; m <= last; ++m) {
      const float* from = in + m * stride;
      for (size_t i = 0; i < length; ++i) to[i] += from[i] * (1.0f / (2 * BLUR + 1));
    }
  }
}

/* Share of rock in a box of 2 BLUR + 1 voxels around each voxel. */
static void find_density(rock_mesher* mesher, const rock_worker* worker) {
  const uint32_t* size = worker->grid.size;
  const size_t count = (size_t)size[0] * size[1] * size[2];
  const float scale = 0.5f * (float)worker->seeds->voxels;
  for (size_t i = 0; i < count; ++i) {
    const float share = worker->field[i] * scale + 0.5f;
    mesher->density[i] = share < 0 ? 0 : share > 1 ? 1 : share;
  }
  const size_t slice = (size_t)size[0] * size[1];
  for (uint32_t row = 0; row < size[1] * size[2]; ++row)
    blur_row(mesher->density + (size_t)row * size[0], mesher->blur + (size_t)row * size[0], size[0]);
  for (uint32_t z = 0; z < size[2]; ++z)
    blur_lines(mesher->blur + z * slice, mesher->density + z * slice, size[0], size[1], size[0]);
  blur_lines(mesher->density, mesher->blur, slice, size[2], slice);
}

/* Voxels above the surface where the density is looked up; the share of rock found there over the rounded parts of a stone, which
 * are as open as can be; and how fast visibility falls beyond it. A plane holds 0.3; of the boulders' vertices half hold 0.19 to
 * 0.25, the hollows 0.35 and more. */
#define LIFT 1.0f
#define OPEN_SHARE 0.17f
#define HIDDEN_PER_SHARE 3.5f

/* How open the sky is over a point of the surface. */
static uint8_t ambient(const rock_mesher* mesher, const uint32_t size[3], const float p[3], const float inward[3]) {
  const float squared = length2(inward), scale = squared > 0 ? LIFT / sqrtf(squared) : 0;
  const float above[3] = {p[0] - inward[0] * scale, p[1] - inward[1] * scale, p[2] - inward[2] * scale};
  const float hidden = (sample(mesher->blur, size, above, NULL) - OPEN_SHARE) * HIDDEN_PER_SHARE;
  return (uint8_t)(255 - (int32_t)((hidden < 0 ? 0 : hidden > 0.8f ? 0.8f : hidden) * 255));
}

/* Position of a vertex in voxels of the fine grid. */
static void to_voxels(const voxel_field* fine, const int16_t position[3], float out[3]) {
  for (uint32_t axis = 0; axis < 3; ++axis) out[axis] = ((float)(position[axis] - fine->origin[axis]) + 0.5f) / (float)fine->step;
}

static void shade(const rock_mesher* mesher, const rock_worker* worker, const voxel_field* fine, mesh_buffer* mesh) {
  const uint32_t* size = worker->grid.size;
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    float p[3], inward[3];
    to_voxels(fine, mesh->positions[v], p);
    sample(worker->field, size, p, inward);
    mesh->occlusion[v] = ambient(mesher, size, p, inward);
  }
}

/* --- Coarser levels. --- */

/* Means over blocks of step^3 voxels. The blocks are counted from the corner of the box of 2R voxels around the home cell, so that
 * they do not depend on the rock's own bounds. */
static void average(const rock_worker* worker, uint32_t step, uint32_t lattice_per_voxel, rock_mesher* mesher, voxel_field* out) {
  const rock_grid* grid = &worker->grid;
  const int32_t s = (int32_t)step;
  int32_t first[3];
  uint32_t size[3];
  for (uint32_t axis = 0; axis < 3; ++axis) {
    first[axis] = (grid->min[axis] + 16 * s) / s - 16 - 1; /* floor of min / s, and one more for an empty border */
    const int32_t last = (grid->min[axis] + (int32_t)grid->size[axis] - 1 + 16 * s) / s - 16 + 1;
    size[axis] = (uint32_t)(last - first[axis] + 1);
  }
  size[0] = round_to_lanes(size[0]);
  *out = (voxel_field){mesher->coarse, mesher->coarse_rows, size[0], size[1], size[2], {0}, s * (int32_t)lattice_per_voxel};
  for (uint32_t axis = 0; axis < 3; ++axis)
    out->origin[axis] = (2 * (first[axis] * s - (int32_t)worker->seeds->voxels) + s) * (int32_t)lattice_per_voxel / 2;

  const size_t count = (size_t)size[0] * size[1] * size[2];
  memset(out->values, 0, count * sizeof(float));
  uint32_t to_x[64];
  for (uint32_t x = 0; x < grid->size[0]; ++x) to_x[x] = (uint32_t)(grid->min[0] + (int32_t)x - first[0] * s) / step;
  const size_t coarse_slice = (size_t)size[0] * size[1];
  for (uint32_t z = 0; z < grid->size[2]; ++z)
    for (uint32_t y = 0; y < grid->size[1]; ++y) {
      const float* row = worker->field + (size_t)grid->size[0] * (y + (size_t)grid->size[1] * z);
      const uint32_t to_z = (uint32_t)((grid->min[2] + (int32_t)z - first[2] * s) / s),
                     to_y = (uint32_t)((grid->min[1] + (int32_t)y - first[1] * s) / s);
      float* to = out->values + coarse_slice * to_z + (size_t)size[0] * to_y;
      for (uint32_t x = 0; x < grid->size[0]; ++x) to[to_x[x]] += row[x];
    }
  const float inverse = 1.0f / (float)(step * step * step);
  for (size_t i = 0; i < count; ++i) out->values[i] *= inverse;
  /* Blocks that the rock's grid does not reach. */
  const float outside = -0.5f;
  for (uint32_t z = 0; z < size[2]; ++z)
    for (uint32_t y = 0; y < size[1]; ++y)
      for (uint32_t x = 0; x < size[0]; ++x)
        if (x == 0 || y == 0 || z == 0 || x + 1 == size[0] || y + 1 == size[1] || z + 1 == size[2] ||
            out->values[x + (size_t)size[0] * y + coarse_slice * z] == 0)
          out->values[x + (size_t)size[0] * y + coarse_slice * z] = outside;
}

/* Moves the vertices of a coarse mesh onto the fine surface, each within its own cube. */
static void project(const rock_worker* worker, const voxel_field* fine, const voxel_field* coarse, mesh_buffer* mesh) {
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    float p[3];
    to_voxels(fine, mesh->positions[v], p);
    for (uint32_t iteration = 0; iteration < 2; ++iteration) {
      float inward[3];
      const float value = sample(worker->field, worker->grid.size, p, inward);
      if (length2(inward) < 1e-8f) break;
      const float step = value / length2(inward);
      for (uint32_t axis = 0; axis < 3; ++axis) p[axis] -= inward[axis] * step;
    }
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const int32_t low = coarse->origin[axis] + mesh->cells[v][axis] * coarse->step;
      const float wanted = floorf(p[axis] * (float)fine->step + (float)fine->origin[axis]);
      const float least = (float)low, most = (float)(low + coarse->step - 1);
      mesh->positions[v][axis] = (int16_t)(wanted < least ? least : wanted > most ? most : wanted);
    }
  }
}

static scree_result reserve_points(rock_mesher* mesher, uint32_t count) {
  if (count <= mesher->point_capacity) return SCREE_OK;
  scree_rt_release(mesher->allocator, mesher->points, mesher->point_capacity, sizeof *mesher->points);
  mesher->point_capacity = 0;
  mesher->points = scree_rt_allocate(mesher->allocator, (size_t)count * 2, sizeof *mesher->points);
  if (mesher->points == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  mesher->point_capacity = count * 2;
  return SCREE_OK;
}

/* Normals of a mesh's vertices at `points`, weighted by area and not unit. Returns twice the area. */
static double area_normals(const mesh_buffer* mesh, const float* points, float* normals) {
  memset(normals, 0, (size_t)mesh->vertex_count * 3 * sizeof *normals);
  double area2 = 0;
  for (uint32_t i = 0; i < mesh->index_count; i += 3) {
    const uint32_t* corner = mesh->indices + i;
    const float *a = points + (size_t)corner[0] * 3, *b = points + (size_t)corner[1] * 3, *c = points + (size_t)corner[2] * 3;
    const float u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, w[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    const float n[3] = {u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]};
    area2 += sqrtf(length2(n));
    for (uint32_t k = 0; k < 3; ++k)
      for (uint32_t axis = 0; axis < 3; ++axis) normals[(size_t)corner[k] * 3 + axis] += n[axis];
  }
  return area2;
}

static bool has_flat_triangle(const mesh_buffer* mesh) {
  for (uint32_t i = 0; i < mesh->index_count; i += 3) {
    const int16_t *a = mesh->positions[mesh->indices[i]], *b = mesh->positions[mesh->indices[i + 1]],
                  *c = mesh->positions[mesh->indices[i + 2]];
    const int32_t u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, w[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    if (u[1] * w[2] == u[2] * w[1] && u[2] * w[0] == u[0] * w[2] && u[0] * w[1] == u[1] * w[0]) return true;
  }
  return false;
}

void mesh_match_volume(mesh_buffer* mesh, double wanted, float most, float* scratch) {
  const uint32_t count = mesh->vertex_count * 3;
  float *points = scratch, *normals = scratch + count, *before = scratch + (size_t)2 * count;
  for (uint32_t v = 0; v < mesh->vertex_count; ++v)
    for (uint32_t axis = 0; axis < 3; ++axis) points[(size_t)v * 3 + axis] = mesh->positions[v][axis];
  memcpy(before, points, count * sizeof *before);
  float moved = 0;
  for (uint32_t iteration = 0; iteration < 3; ++iteration) {
    const double area2 = area_normals(mesh, points, normals);
    float step = (float)((wanted - mesh_volume(mesh)) * 2 / area2);
    if (moved + step > most) step = most - moved;
    if (moved + step < -most) step = -most - moved;
    moved += step;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
      const float* n = normals + (size_t)v * 3;
      const float squared = length2(n), scale = squared > 0 ? step / sqrtf(squared) : 0;
      for (uint32_t axis = 0; axis < 3; ++axis) {
        float* p = &points[(size_t)v * 3 + axis];
        *p += n[axis] * scale;
        mesh->positions[v][axis] = (int16_t)floorf(*p + 0.5f);
      }
    }
  }
  if (has_flat_triangle(mesh))
    for (uint32_t v = 0; v < mesh->vertex_count; ++v)
      for (uint32_t axis = 0; axis < 3; ++axis) mesh->positions[v][axis] = (int16_t)before[(size_t)v * 3 + axis];
}

static void copy_mesh(const mesh_buffer* from, mesh_buffer* to) {
  memcpy(to->positions, from->positions, from->vertex_count * sizeof *to->positions);
  memcpy(to->cells, from->cells, from->vertex_count * sizeof *to->cells);
  memcpy(to->occlusion, from->occlusion, from->vertex_count);
  memcpy(to->indices, from->indices, from->index_count * sizeof *to->indices);
  to->vertex_count = from->vertex_count;
  to->index_count = from->index_count;
}

static scree_result repeat_level(rock_mesher* mesher, uint32_t level) {
  const mesh_buffer* before = &mesher->meshes[level - 1];
  mesh_buffer* mesh = &mesher->meshes[level];
  const scree_result result =
      mesh_buffer_reserve(mesh, before->vertex_count, before->index_count, mesh->voxel_capacity, mesher->allocator);
  if (result != SCREE_OK) return result;
  copy_mesh(before, mesh);
  mesher->errors[level] = mesher->errors[level - 1];
  return SCREE_OK;
}

/* A level that holds less or more of the finest one's volume is too coarse for this rock, and the one before it is repeated. So is
 * one that is farther off than this many of its voxels: averaging has taken an arm off the rock, and the volume is in the rest. */
#define LEAST_VOLUME 0.8
#define MOST_VOLUME 1.2
#define MOST_ERROR 1.25f

static scree_result mesh_level(rock_mesher* mesher, const rock_worker* worker, const voxel_field* fine, uint32_t level) {
  mesh_buffer* mesh = &mesher->meshes[level];
  voxel_field coarse;
  average(worker, level_steps[level], mesher->lattice_per_voxel, mesher, &coarse);
  const uint32_t count = coarse.height * coarse.depth;
  mesher->kernels->sign_rows(coarse.values, coarse.width, count, coarse.rows);
  const float carved = 0.02f * (float)level_steps[level] / (float)worker->seeds->voxels;
  mask_make_well_composed(coarse.rows, coarse.height, coarse.depth, coarse.values, coarse.width, carved);
  /* Parts that come apart at this step are kept: together they look more like the stone than the largest of them. */
  uint32_t left = 0;
  for (uint32_t row = 0; row < count; ++row) left += (uint32_t)__builtin_popcountll(coarse.rows[row]);
  if (left == 0) return repeat_level(mesher, level);
  scree_result result = mesh_field(&coarse, mesh, mesher->allocator);
  if (result != SCREE_OK) return result;
  project(worker, fine, &coarse, mesh);
  surface_nets_triangulate(mesh);
  result = reserve_points(mesher, mesh->vertex_count * 9);
  if (result != SCREE_OK) return result;
  mesh_match_volume(mesh, mesh_volume(&mesher->meshes[0]), 0.6f * (float)coarse.step, mesher->points);
  const double share = mesh_volume(mesh) / mesh_volume(&mesher->meshes[0]);
  if (share < LEAST_VOLUME || share > MOST_VOLUME) return repeat_level(mesher, level);
  shade(mesher, worker, fine, mesh);
  const uint32_t needed = lod_error_scratch(mesh);
  if (needed > mesher->fan_capacity) {
    scree_rt_release(mesher->allocator, mesher->fans, mesher->fan_capacity, sizeof *mesher->fans);
    mesher->fans = NULL;
    mesher->fan_capacity = 0;
    mesher->fans = scree_rt_allocate(mesher->allocator, (size_t)needed * 2, sizeof *mesher->fans);
    if (mesher->fans == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
    mesher->fan_capacity = needed * 2;
  }
  const float lattice = (float)(mesher->lattice_per_voxel * worker->seeds->voxels);
  const float off = lod_error(&mesher->meshes[0], mesh, &coarse, mesher->fans), error = off / lattice;
  if (off > MOST_ERROR * (float)coarse.step) return repeat_level(mesher, level);
  mesher->errors[level] = error > mesher->errors[level - 1] ? error : mesher->errors[level - 1];
  return SCREE_OK;
}

scree_result rock_mesh(rock_mesher* mesher, const rock_worker* worker, uint32_t lods) {
  const rock_grid* grid = &worker->grid;
  voxel_field fine = {
      worker->field, worker->rows, grid->size[0], grid->size[1], grid->size[2], {0}, (int32_t)mesher->lattice_per_voxel};
  for (uint32_t axis = 0; axis < 3; ++axis)
    fine.origin[axis] = (2 * (grid->min[axis] - (int32_t)worker->seeds->voxels) + 1) * (int32_t)mesher->lattice_per_voxel / 2;
  scree_result result = mesh_field(&fine, &mesher->meshes[0], mesher->allocator);
  if (result != SCREE_OK) return result;
  surface_nets_triangulate(&mesher->meshes[0]);
  mesher->errors[0] = 0;
  result = reserve_points(mesher, 3 * round_to_lanes(mesher->meshes[0].vertex_count));
  if (result != SCREE_OK) return result;
  find_density(mesher, worker);
  shade(mesher, worker, &fine, &mesher->meshes[0]);
  for (uint32_t level = 1; level < lods && result == SCREE_OK; ++level) result = mesh_level(mesher, worker, &fine, level);
  return result;
}
