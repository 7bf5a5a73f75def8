#include "rock_mesh.h"

#include <math.h>
#include <string.h>

#include "voxel_mask.h"

/* Voxels of the averaged fields of the coarser levels, in voxels of the finest. */
static const uint32_t level_steps[ROCK_MAX_LODS] = {1, 2, 3, 4, 6, 8};

#define BLUR 3 /* voxels that the density is blurred over, to either side */

scree_result rock_mesher_create(const rock_worker* worker, uint32_t lattice_per_voxel, const scree_allocator* allocator,
                                rock_mesher* out) {
  memset(out, 0, sizeof *out);
  out->allocator = allocator;
  out->kernels = worker->kernels;
  out->lattice_per_voxel = lattice_per_voxel;
  out->capacity = worker->capacity;
  out->coarse = allocate(allocator, out->capacity, sizeof *out->coarse);
  out->coarse_rows = allocate(allocator, (size_t)3 * out->capacity / LANES, sizeof *out->coarse_rows);
  out->density = allocate(allocator, out->capacity, sizeof *out->density);
  out->blur = allocate(allocator, out->capacity, sizeof *out->blur);
  if (out->coarse == NULL || out->coarse_rows == NULL || out->density == NULL || out->blur == NULL) {
    rock_mesher_destroy(out);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  return SCREE_OK;
}

static void mesh_buffer_destroy(mesh_buffer* mesh, const scree_allocator* allocator) {
  release(allocator, mesh->positions, mesh->vertex_capacity, sizeof *mesh->positions);
  release(allocator, mesh->cells, mesh->vertex_capacity, sizeof *mesh->cells);
  release(allocator, mesh->occlusion, mesh->vertex_capacity, 1);
  release(allocator, mesh->indices, mesh->index_capacity, sizeof *mesh->indices);
  release(allocator, mesh->vertex_of, mesh->voxel_capacity, sizeof *mesh->vertex_of);
  memset(mesh, 0, sizeof *mesh);
}

void rock_mesher_destroy(rock_mesher* mesher) {
  if (mesher->allocator == NULL) return;
  for (uint32_t level = 0; level < ROCK_MAX_LODS; ++level) mesh_buffer_destroy(&mesher->meshes[level], mesher->allocator);
  release(mesher->allocator, mesher->coarse, mesher->capacity, sizeof *mesher->coarse);
  release(mesher->allocator, mesher->coarse_rows, (size_t)3 * mesher->capacity / LANES, sizeof *mesher->coarse_rows);
  release(mesher->allocator, mesher->density, mesher->capacity, sizeof *mesher->density);
  release(mesher->allocator, mesher->blur, mesher->capacity, sizeof *mesher->blur);
  release(mesher->allocator, mesher->fans, mesher->fan_capacity, sizeof *mesher->fans);
  memset(mesher, 0, sizeof *mesher);
}

/* Makes room for a mesh; what the buffer held is gone when it has to grow. */
static scree_result mesh_buffer_reserve(mesh_buffer* mesh, uint32_t vertices, uint32_t indices, uint32_t voxels,
                                        const scree_allocator* allocator) {
  if (vertices <= mesh->vertex_capacity && indices <= mesh->index_capacity && voxels <= mesh->voxel_capacity) return SCREE_OK;
  vertices = vertices > mesh->vertex_capacity ? vertices + vertices / 2 : mesh->vertex_capacity;
  indices = indices > mesh->index_capacity ? indices + indices / 2 : mesh->index_capacity;
  voxels = voxels > mesh->voxel_capacity ? voxels + voxels / 2 : mesh->voxel_capacity;
  mesh_buffer_destroy(mesh, allocator);
  mesh->vertex_capacity = vertices;
  mesh->index_capacity = indices;
  mesh->voxel_capacity = voxels;
  mesh->positions = allocate(allocator, vertices, sizeof *mesh->positions);
  mesh->cells = allocate(allocator, vertices, sizeof *mesh->cells);
  mesh->occlusion = allocate(allocator, vertices, 1);
  mesh->indices = allocate(allocator, indices, sizeof *mesh->indices);
  mesh->vertex_of = allocate(allocator, voxels, sizeof *mesh->vertex_of);
  if (mesh->positions == NULL || mesh->cells == NULL || mesh->occlusion == NULL || mesh->indices == NULL ||
      mesh->vertex_of == NULL) {
    mesh_buffer_destroy(mesh, allocator);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  return SCREE_OK;
}

static scree_result mesh_field(const voxel_field* field, mesh_buffer* mesh, const scree_allocator* allocator) {
  uint32_t vertices, indices;
  surface_nets_bounds(field, &vertices, &indices);
  const scree_result result = mesh_buffer_reserve(mesh, vertices, indices, field->width * field->height * field->depth, allocator);
  if (result == SCREE_OK) surface_nets(field, mesh);
  return result;
}

/* --- The fine field, sampled anywhere. --- */

/* Trilinear interpolation at p, in voxels; p is clamped into the grid. */
static float sample(const float* values, const uint32_t size[3], const float p[3]) {
  uint32_t at[3];
  float t[3];
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const float top = (float)(size[axis] - 1) - 1e-3f, clamped = p[axis] < 0 ? 0 : p[axis] > top ? top : p[axis];
    at[axis] = (uint32_t)clamped;
    t[axis] = clamped - (float)at[axis];
  }
  const size_t dy = size[0], dz = (size_t)size[0] * size[1];
  const float* v = values + at[0] + dy * at[1] + dz * at[2];
  const float a = v[0] + (v[1] - v[0]) * t[0], b = v[dy] + (v[dy + 1] - v[dy]) * t[0];
  const float c = v[dz] + (v[dz + 1] - v[dz]) * t[0], d = v[dz + dy] + (v[dz + dy + 1] - v[dz + dy]) * t[0];
  const float e = a + (b - a) * t[1], f = c + (d - c) * t[1];
  return e + (f - e) * t[2];
}

/* Gradient by central differences over a voxel; points inwards. Returns its squared length. */
static float gradient(const float* values, const uint32_t size[3], const float p[3], float out[3]) {
  float length2 = 0;
  for (uint32_t axis = 0; axis < 3; ++axis) {
    float q[3] = {p[0], p[1], p[2]};
    q[axis] = p[axis] + 0.5f;
    const float above = sample(values, size, q);
    q[axis] = p[axis] - 0.5f;
    out[axis] = above - sample(values, size, q);
    length2 += out[axis] * out[axis];
  }
  return length2;
}

/* Running mean over 2 BLUR + 1 values along one axis, zeros beyond the ends. */
static void blur_axis(const float* in, float* out, const uint32_t size[3], uint32_t axis) {
  const size_t strides[3] = {1, size[0], (size_t)size[0] * size[1]};
  const size_t stride = strides[axis];
  const uint32_t length = size[axis], other = axis == 0 ? 1 : 0, third = axis == 2 ? 1 : 2;
  for (uint32_t k = 0; k < size[third]; ++k)
    for (uint32_t i = 0; i < length; ++i) {
      const uint32_t first = i < BLUR ? 0 : i - BLUR, last = i + BLUR >= length ? length - 1 : i + BLUR;
      for (uint32_t j = 0; j < size[other]; ++j) {
        const size_t base = j * strides[other] + k * strides[third];
        float sum = 0;
        for (uint32_t m = first; m <= last; ++m) sum += in[base + m * stride];
        out[base + i * stride] = sum * (1.0f / (2 * BLUR + 1));
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
  blur_axis(mesher->density, mesher->blur, size, 0);
  blur_axis(mesher->blur, mesher->density, size, 1);
  blur_axis(mesher->density, mesher->blur, size, 2);
}

/* How open the sky is over a point of the surface: a box one blur radius above a plane is empty, in a hollow it is not. */
static uint8_t ambient(const rock_mesher* mesher, const uint32_t size[3], const float p[3], const float inward[3], float length2) {
  const float scale = length2 > 0 ? (BLUR + 0.5f) / sqrtf(length2) : 0;
  const float above[3] = {p[0] - inward[0] * scale, p[1] - inward[1] * scale, p[2] - inward[2] * scale};
  const float hidden = sample(mesher->blur, size, above) * 1.8f - 0.12f;
  return (uint8_t)(255 - (int32_t)((hidden < 0 ? 0 : hidden > 0.8f ? 0.8f : hidden) * 255));
}

/* Position of a vertex in voxels of the fine grid. */
static void to_voxels(const voxel_field* fine, const int16_t position[3], float out[3]) {
  for (uint32_t axis = 0; axis < 3; ++axis) out[axis] = (float)(position[axis] - fine->origin[axis]) / (float)fine->step;
}

static void shade(const rock_mesher* mesher, const rock_worker* worker, const voxel_field* fine, mesh_buffer* mesh) {
  const uint32_t* size = worker->grid.size;
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    float p[3], inward[3];
    to_voxels(fine, mesh->positions[v], p);
    const float length2 = gradient(worker->field, size, p, inward);
    mesh->occlusion[v] = ambient(mesher, size, p, inward, length2);
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
  const size_t coarse_slice = (size_t)size[0] * size[1];
  for (uint32_t z = 0; z < grid->size[2]; ++z)
    for (uint32_t y = 0; y < grid->size[1]; ++y) {
      const float* row = worker->field + (size_t)grid->size[0] * (y + (size_t)grid->size[1] * z);
      const uint32_t to_z = (uint32_t)((grid->min[2] + (int32_t)z - first[2] * s) / s),
                     to_y = (uint32_t)((grid->min[1] + (int32_t)y - first[1] * s) / s);
      float* to = out->values + coarse_slice * to_z + (size_t)size[0] * to_y;
      const uint32_t shift = (uint32_t)(grid->min[0] - first[0] * s);
      for (uint32_t x = 0; x < grid->size[0]; ++x) to[(shift + x) / step] += row[x];
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
      const float value = sample(worker->field, worker->grid.size, p);
      const float length2 = gradient(worker->field, worker->grid.size, p, inward);
      if (length2 < 1e-8f) break;
      for (uint32_t axis = 0; axis < 3; ++axis) p[axis] -= inward[axis] * value / length2;
    }
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const int32_t low = coarse->origin[axis] + mesh->cells[v][axis] * coarse->step;
      const float wanted = floorf(p[axis] * (float)fine->step + (float)fine->origin[axis] + 0.5f);
      const float least = (float)(low + 1), most = (float)(low + coarse->step - 1);
      mesh->positions[v][axis] = (int16_t)(wanted < least ? least : wanted > most ? most : wanted);
    }
  }
}

/* Squared distance from p to triangle abc. (Ericson, Real-Time Collision Detection, 2004, section 5.1.5.) */
static float triangle_distance2(const float p[3], const float a[3], const float b[3], const float c[3]) {
  float ab[3], ac[3], ap[3];
  for (int i = 0; i < 3; ++i) ab[i] = b[i] - a[i], ac[i] = c[i] - a[i], ap[i] = p[i] - a[i];
#define DOT(u, w) (u[0] * w[0] + u[1] * w[1] + u[2] * w[2])
  const float d1 = DOT(ab, ap), d2 = DOT(ac, ap), bb = DOT(ab, ab), cc = DOT(ac, ac), bc = DOT(ab, ac);
  /* Barycentric coordinates by regions: a, edge ab, b, edge ac, c, edge bc, inside. */
  const float d3 = d1 - bb, d4 = d2 - bc, d5 = d1 - bc, d6 = d2 - cc;
  float s = 0, t = 0; /* nearest point a + s ab + t ac */
  const float vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (d1 <= 0 && d2 <= 0) {
  } else if (d3 >= 0 && d4 <= d3) {
    s = 1;
  } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    s = d1 / (d1 - d3);
  } else if (d6 >= 0 && d5 <= d6) {
    t = 1;
  } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    t = d2 / (d2 - d6);
  } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    s = 1 - t;
  } else {
    const float inverse = 1 / (va + vb + vc);
    s = vb * inverse, t = vc * inverse;
  }
  float rest[3];
  for (int i = 0; i < 3; ++i) rest[i] = ap[i] - s * ab[i] - t * ac[i];
  return DOT(rest, rest);
#undef DOT
}

/* Largest distance, in lattice steps, from a vertex of `fine` to the triangles of `coarse` around its nearest vertex: never less
 * than the true distance to the coarse surface. */
static float level_error(const mesh_buffer* fine, const mesh_buffer* coarse, const voxel_field* field, uint32_t* fans) {
  /* Triangles around each vertex: fans[first[v] .. first[v + 1] - 1]. */
  uint32_t* first = fans;
  uint32_t* list = fans + coarse->vertex_count + 1;
  memset(first, 0, (coarse->vertex_count + 1) * sizeof *first);
  for (uint32_t i = 0; i < coarse->index_count; ++i) ++first[coarse->indices[i]];
  uint32_t sum = 0;
  for (uint32_t v = 0; v <= coarse->vertex_count; ++v) {
    const uint32_t count = v < coarse->vertex_count ? first[v] : 0;
    first[v] = sum;
    sum += count;
  }
  for (uint32_t i = 0; i < coarse->index_count; ++i) list[first[coarse->indices[i]]++] = i / 3;
  for (uint32_t v = coarse->vertex_count; v > 0; --v) first[v] = first[v - 1];
  first[0] = 0;

  const size_t dy = field->width, dz = (size_t)field->width * field->height;
  memset(coarse->vertex_of, 255, dz * field->depth * sizeof *coarse->vertex_of);
  for (uint32_t v = 0; v < coarse->vertex_count; ++v)
    coarse->vertex_of[coarse->cells[v][0] + dy * coarse->cells[v][1] + dz * coarse->cells[v][2]] = v;

  float worst = 0;
  const int32_t limit[3] = {(int32_t)field->width - 2, (int32_t)field->height - 2, (int32_t)field->depth - 2};
  for (uint32_t v = 0; v < fine->vertex_count; ++v) {
    const int16_t* p = fine->positions[v];
    int32_t low[3], high[3];
    for (int axis = 0; axis < 3; ++axis) {
      const int32_t cube = (p[axis] - field->origin[axis]) / field->step;
      low[axis] = cube < 1 ? 0 : cube - 1;
      high[axis] = cube + 1 > limit[axis] ? limit[axis] : cube + 1;
    }
    uint32_t nearest = UINT32_MAX;
    int64_t least = INT64_MAX;
    for (int32_t z = low[2]; z <= high[2]; ++z)
      for (int32_t y = low[1]; y <= high[1]; ++y)
        for (int32_t x = low[0]; x <= high[0]; ++x) {
          const uint32_t at = coarse->vertex_of[(size_t)x + dy * (size_t)y + dz * (size_t)z];
          if (at == UINT32_MAX) continue;
          int64_t d2 = 0;
          for (int axis = 0; axis < 3; ++axis) {
            const int64_t d = p[axis] - coarse->positions[at][axis];
            d2 += d * d;
          }
          if (d2 < least) least = d2, nearest = at;
        }
    float d2;
    const float point[3] = {p[0], p[1], p[2]};
    if (nearest == UINT32_MAX) {
      /* A thin part that the coarse level lost: as far as its nearest vertex anywhere. */
      d2 = INFINITY;
      for (uint32_t c = 0; c < coarse->vertex_count; ++c) {
        float sum2 = 0;
        for (int axis = 0; axis < 3; ++axis) {
          const float d = point[axis] - (float)coarse->positions[c][axis];
          sum2 += d * d;
        }
        if (sum2 < d2) d2 = sum2;
      }
    } else {
      d2 = (float)least;
      for (uint32_t f = first[nearest]; f < first[nearest + 1] && d2 > worst; ++f) {
        const uint32_t* corner = coarse->indices + (size_t)list[f] * 3;
        float t[3][3];
        for (int k = 0; k < 3; ++k)
          for (int axis = 0; axis < 3; ++axis) t[k][axis] = (float)coarse->positions[corner[k]][axis];
        const float triangle = triangle_distance2(point, t[0], t[1], t[2]);
        if (triangle < d2) d2 = triangle;
      }
    }
    if (d2 > worst) worst = d2;
  }
  return sqrtf(worst);
}

static void copy_mesh(const mesh_buffer* from, mesh_buffer* to) {
  memcpy(to->positions, from->positions, from->vertex_count * sizeof *to->positions);
  memcpy(to->cells, from->cells, from->vertex_count * sizeof *to->cells);
  memcpy(to->occlusion, from->occlusion, from->vertex_count);
  memcpy(to->indices, from->indices, from->index_count * sizeof *to->indices);
  to->vertex_count = from->vertex_count;
  to->index_count = from->index_count;
}

static scree_result mesh_level(rock_mesher* mesher, const rock_worker* worker, const voxel_field* fine, uint32_t level) {
  mesh_buffer* mesh = &mesher->meshes[level];
  voxel_field coarse;
  average(worker, level_steps[level], mesher->lattice_per_voxel, mesher, &coarse);
  const uint32_t count = coarse.height * coarse.depth;
  mesher->kernels->sign_rows(coarse.values, coarse.width, count, coarse.rows);
  const float carved = 0.02f * (float)level_steps[level] / (float)worker->seeds->voxels;
  mask_make_well_composed(coarse.rows, coarse.height, coarse.depth, coarse.values, coarse.width, carved);
  const uint32_t kept =
      mask_keep_largest(coarse.rows, coarse.height, coarse.depth, coarse.values, coarse.width, carved, coarse.rows + count);
  if (kept == 0) {
    const mesh_buffer* before = &mesher->meshes[level - 1];
    const scree_result result =
        mesh_buffer_reserve(mesh, before->vertex_count, before->index_count, mesh->voxel_capacity, mesher->allocator);
    if (result != SCREE_OK) return result;
    copy_mesh(before, mesh);
    mesher->errors[level] = mesher->errors[level - 1];
    return SCREE_OK;
  }
  const scree_result result = mesh_field(&coarse, mesh, mesher->allocator);
  if (result != SCREE_OK) return result;
  project(worker, fine, &coarse, mesh);
  surface_nets_triangulate(mesh);
  shade(mesher, worker, fine, mesh);
  const uint32_t needed = mesh->vertex_count + 1 + mesh->index_count;
  if (needed > mesher->fan_capacity) {
    release(mesher->allocator, mesher->fans, mesher->fan_capacity, sizeof *mesher->fans);
    mesher->fan_capacity = 0;
    mesher->fans = allocate(mesher->allocator, (size_t)needed * 2, sizeof *mesher->fans);
    if (mesher->fans == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
    mesher->fan_capacity = needed * 2;
  }
  const float lattice = (float)(mesher->lattice_per_voxel * worker->seeds->voxels);
  const float error = level_error(&mesher->meshes[0], mesh, &coarse, mesher->fans) / lattice;
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
  find_density(mesher, worker);
  shade(mesher, worker, &fine, &mesher->meshes[0]);
  for (uint32_t level = 1; level < lods && result == SCREE_OK; ++level) result = mesh_level(mesher, worker, &fine, level);
  return result;
}

/* --- Mass and hull. --- */

void rock_mass(const rock_mesher* mesher, float cells_per_lattice, rock_record* out) {
  const mesh_buffer* mesh = &mesher->meshes[0];
  memcpy(out->bounds_min, mesh->positions[0], sizeof out->bounds_min);
  memcpy(out->bounds_max, mesh->positions[0], sizeof out->bounds_max);
  for (uint32_t v = 0; v < mesh->vertex_count; ++v)
    for (int axis = 0; axis < 3; ++axis) {
      const int16_t p = mesh->positions[v][axis];
      if (p < out->bounds_min[axis]) out->bounds_min[axis] = p;
      if (p > out->bounds_max[axis]) out->bounds_max[axis] = p;
    }
  /* Sums over tetrahedra to the origin, exact in integers. */
  int64_t volume6 = 0, moment24[3] = {0, 0, 0};
  for (uint32_t i = 0; i < mesh->index_count; i += 3) {
    const int16_t *a = mesh->positions[mesh->indices[i]], *b = mesh->positions[mesh->indices[i + 1]],
                  *c = mesh->positions[mesh->indices[i + 2]];
    const int64_t determinant = (int64_t)a[0] * (b[1] * c[2] - b[2] * c[1]) + (int64_t)a[1] * (b[2] * c[0] - b[0] * c[2]) +
                                (int64_t)a[2] * (b[0] * c[1] - b[1] * c[0]);
    volume6 += determinant;
    for (int axis = 0; axis < 3; ++axis) moment24[axis] += determinant * (a[axis] + b[axis] + c[axis]);
  }
  double centroid[3];
  for (int axis = 0; axis < 3; ++axis)
    centroid[axis] =
        volume6 > 0 ? (double)moment24[axis] / (4.0 * (double)volume6) : 0.5 * (out->bounds_min[axis] + out->bounds_max[axis]);

  /* A ball that surely lies inside: the plane of a triangle is nearer than the triangle, and so is a vertex less the longest edge.
   */
  double nearest2 = 0, farthest2 = 0, inner = INFINITY;
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    double d2 = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double d = mesh->positions[v][axis] - centroid[axis];
      d2 += d * d;
    }
    if (d2 > farthest2) farthest2 = d2;
    if (v == 0 || d2 < nearest2) nearest2 = d2;
  }
  for (uint32_t i = 0; i < mesh->index_count; i += 3) {
    double p[3][3], u[3], w[3], n[3];
    double corner2 = INFINITY, edge2 = 0;
    for (int k = 0; k < 3; ++k) {
      double d2 = 0;
      for (int axis = 0; axis < 3; ++axis) {
        p[k][axis] = mesh->positions[mesh->indices[i + (uint32_t)k]][axis] - centroid[axis];
        d2 += p[k][axis] * p[k][axis];
      }
      if (d2 < corner2) corner2 = d2;
    }
    for (int k = 0; k < 3; ++k) {
      double d2 = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const double d = p[(k + 1) % 3][axis] - p[k][axis];
        d2 += d * d;
      }
      if (d2 > edge2) edge2 = d2;
    }
    for (int axis = 0; axis < 3; ++axis) u[axis] = p[1][axis] - p[0][axis], w[axis] = p[2][axis] - p[0][axis];
    n[0] = u[1] * w[2] - u[2] * w[1], n[1] = u[2] * w[0] - u[0] * w[2], n[2] = u[0] * w[1] - u[1] * w[0];
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    const double along = n[0] * p[0][0] + n[1] * p[0][1] + n[2] * p[0][2];
    const double by_plane = length > 0 ? (along < 0 ? -along : along) / length : 0;
    const double by_vertex = sqrt(corner2) - sqrt(edge2);
    const double bound = by_plane > by_vertex ? by_plane : by_vertex;
    if (bound < inner) inner = bound;
  }
  if (inner > sqrt(nearest2)) inner = sqrt(nearest2);
  const double scale = cells_per_lattice;
  for (int axis = 0; axis < 3; ++axis) out->centroid[axis] = (float)(centroid[axis] * scale);
  out->volume = (float)((double)volume6 / 6 * scale * scale * scale);
  out->inner_radius = (float)((inner > 0 ? inner : 0) * scale * (1 - 1e-6));
  out->outer_radius = (float)(sqrt(farthest2) * scale * (1 + 1e-6));
}

uint32_t rock_hull(const rock_mesher* mesher, uint32_t most, int16_t (*hull)[3]) {
  const mesh_buffer* mesh = &mesher->meshes[0];
  uint32_t count = 0;
  /* Directions in order of the squared length of (x, y, z): faces, edges and corners of a cube, then ever finer ones. */
  for (int32_t shell = 1; shell <= 6 && count < most; ++shell)
    for (int32_t code = 0; code < 125 && count < most; ++code) {
      const int32_t x = code % 5 - 2, y = code / 5 % 5 - 2, z = code / 25 - 2;
      if (x * x + y * y + z * z != shell) continue;
      uint32_t best = 0;
      int32_t farthest = INT32_MIN;
      for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        const int32_t along = x * mesh->positions[v][0] + y * mesh->positions[v][1] + z * mesh->positions[v][2];
        if (along > farthest) farthest = along, best = v;
      }
      bool known = false;
      for (uint32_t h = 0; h < count; ++h) known = known || memcmp(hull[h], mesh->positions[best], sizeof *hull) == 0;
      if (!known) memcpy(hull[count++], mesh->positions[best], sizeof *hull);
    }
  return count;
}
