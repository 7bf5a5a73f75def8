/* The kernels themselves, included by kernels_plain.c and kernels_avx2.c with KERNELS_TABLE and KERNELS_NAME set. Vectors of eight
 * floats: two registers on a plain target, one with AVX2. */
#include <math.h>
#include <string.h>

#include "kernels.h"

#define SIMD_WIDTH LANES
#include "simd.h"

static void voronoi_block(const block_tables* tables, const block_seed* seeds, uint32_t count, const block_fields* out) {
  const uint32_t voxels = tables->voxels, plane = tables->plane;
  const vfloat scale = v_set(tables->cells_per_unit);
  for (uint32_t z = 0; z < voxels; ++z) {
    const float plane_z = (float)(256 * (2 * (int32_t)z + 1));
    for (uint32_t at = 0; at < plane; at += LANES) {
      const vfloat x = v_load(tables->x + at), y = v_load(tables->y + at);
      vfloat best = v_set(INFINITY), second = v_set(INFINITY);
      vfloat best_x = v_set(0), best_y = v_set(0), best_z = v_set(0), second_x = v_set(0), second_y = v_set(0), second_z = v_set(0);
      vint owner = {0};
      for (uint32_t k = 0; k < count; ++k) {
        const block_seed* seed = &seeds[k];
        const uint32_t side_x = seed->corner & 1, side_y = seed->corner >> 1 & 1, side_z = seed->corner >> 2;
        const vfloat dx = (x - v_set(seed->position[0])) * scale, dy = (y - v_set(seed->position[1])) * scale;
        const vfloat dz = v_set((plane_z - seed->position[2]) * tables->cells_per_unit);
        const float* m = seed->metric;
        const vfloat mx = (v_set(m[0]) * dx + v_set(m[3]) * dy) + v_set(m[4]) * dz;
        const vfloat my = v_set(m[1]) * dy + v_set(m[5]) * dz;
        const vfloat mz = v_set(m[2]) * dz;
        const vfloat form = (mx * dx + my * dy) + mz * dz;
        const vfloat weight = v_load(tables->weight_xy[seed->corner & 3] + at) * v_set(tables->weight[side_z][z]);
        const vfloat distance = form * weight;
        const vfloat grad_x = (mx + v_set(m[0]) * dx) * weight + distance * v_load(tables->slope_x[side_x] + at);
        const vfloat grad_y = (my + v_set(m[1]) * dy + v_set(m[3]) * dx) * weight + distance * v_load(tables->slope_y[side_y] + at);
        const vfloat grad_z = (mz + mz + v_set(m[4]) * dx + v_set(m[5]) * dy) * weight + distance * v_set(tables->slope[side_z][z]);
        const vint first = distance < best, runner = distance < second;
        second_x = v_select(first, best_x, v_select(runner, grad_x, second_x));
        second_y = v_select(first, best_y, v_select(runner, grad_y, second_y));
        second_z = v_select(first, best_z, v_select(runner, grad_z, second_z));
        second = v_select(first, best, v_select(runner, distance, second));
        best_x = v_select(first, grad_x, best_x);
        best_y = v_select(first, grad_y, best_y);
        best_z = v_select(first, grad_z, best_z);
        best = v_select(first, distance, best);
        const int32_t number = (int32_t)k;
        owner = v_select_int(first, v_set_int(number), owner);
      }
      /* Levels instead of distances, see block_fields. */
      const vfloat k = v_set(tables->level), best_inverse = v_set(1) / (best + k), second_inverse = v_set(1) / (second + k);
      const vfloat best_scale = k * best_inverse * best_inverse, second_scale = k * second_inverse * second_inverse;
      const vfloat gx = best_x * best_scale - second_x * second_scale, gy = best_y * best_scale - second_y * second_scale;
      const vfloat gz = best_z * best_scale - second_z * second_scale;
      const vfloat slope = v_sqrt((gx * gx + gy * gy) + gz * gz);
      const vfloat inverse = v_set(1) / v_max(slope, v_set(1e-3f));
      const vfloat best_level = v_set(1) - k / (best + k), second_level = v_set(1) - k / (second + k);
      const size_t to = (size_t)z * plane + at;
      v_store(out->nearest + to, best_level);
      v_store(out->depth + to, (second_level - best_level) * inverse);
      v_store(out->inverse_slope + to, inverse);
      for (int i = 0; i < LANES; ++i) out->owner[to + (size_t)i] = (uint8_t)owner[i];
    }
  }
}

static void rock_field(const rock_row* row, float limit, float* field) {
  const float* m = row->metric;
  const vfloat dy = v_set(row->dy), dz = v_set(row->dz);
  for (uint32_t at = 0; at < row->count; at += LANES) {
    const vfloat dx = v_load(row->dx + at);
    const vfloat mx = (v_set(m[0]) * dx + v_set(m[3]) * dy) + v_set(m[4]) * dz;
    const vfloat my = v_set(m[1]) * dy + v_set(m[5]) * dz;
    const vfloat mz = v_set(m[2]) * dz;
    const vfloat form = (mx * dx + my * dy) + mz * dz;
    const vfloat weight = (v_load(row->weight_x + at) * v_set(row->weight_y)) * v_set(row->weight_z);
    const vfloat distance = form * weight;
    const vfloat level = v_set(1) - v_set(row->level) / (distance + v_set(row->level));
    const vfloat outside = (v_load(row->nearest + at) - level) * v_load(row->inverse_slope + at);
    vint own;
    memcpy(&own, row->own + at, sizeof own);
    vfloat value = v_select(own, v_load(row->depth + at), outside);
    v_store(field + at, v_max(v_min(value, v_set(limit)), v_set(-limit)));
  }
}

static void rock_erode(const rock_row* row, const rock_shape* shape, const float* noise, float* field, float* omega) {
  const vfloat y = v_set(row->y), z = v_set(row->z);
  for (uint32_t at = 0; at < row->count; at += LANES) {
    const vfloat x = v_load(row->x + at);
    vfloat nearest = v_set(1e6f);
    for (uint32_t c = 0; c < shape->contact_count; ++c) {
      const vfloat dx = x - v_set(shape->contacts[c][0]), dy = y - v_set(shape->contacts[c][1]),
                   dz = z - v_set(shape->contacts[c][2]);
      nearest = v_min(nearest, (dx * dx + dy * dy) + dz * dz);
    }
    vfloat t = (v_sqrt(nearest) - v_set(shape->contact_radius)) * v_set(shape->inverse_blend);
    t = v_max(v_min(t, v_set(1)), v_set(0));
    const vfloat damping = t * t * (v_set(3) - v_set(2) * t);
    vfloat value = v_load(field + at) - v_set(shape->erosion) * damping;
    for (uint32_t p = 0; p < shape->plane_count; ++p) {
      const float* plane = shape->planes[p];
      value = v_min(value, v_set(plane[3]) - ((v_set(plane[0]) * x + v_set(plane[1]) * y) + v_set(plane[2]) * z));
    }
    value = value - v_load(noise + at) * damping;
    v_store(field + at, value);
    v_store(omega + at, damping);
  }
}

static void carve_step(const float* field, const float* omega, float* out, uint32_t width, uint32_t height, uint32_t depth,
                       float strength) {
  const size_t slice = (size_t)width * height;
  memcpy(out, field, slice * sizeof *out);
  memcpy(out + (depth - 1) * slice, field + (depth - 1) * slice, slice * sizeof *out);
  for (uint32_t z = 1; z + 1 < depth; ++z) {
    memcpy(out + z * slice, field + z * slice, width * sizeof *out);
    memcpy(out + (z + 1) * slice - width, field + (z + 1) * slice - width, width * sizeof *out);
    for (uint32_t y = 1; y + 1 < height; ++y) {
      const size_t row = z * slice + (size_t)y * width;
      for (uint32_t x = 0; x < width; x += LANES) {
        const float* p = field + row + x;
        const vfloat here = v_load(p);
        const vfloat sum =
            ((v_load(p - 1) + v_load(p + 1)) + (v_load(p - width) + v_load(p + width))) + (v_load(p - slice) + v_load(p + slice));
        const vfloat change = v_min((sum - v_set(6) * here) * v_set(strength), v_set(0));
        v_store(out + row + x, here + change * v_load(omega + row + x));
      }
      out[row] = field[row];
      out[row + width - 1] = field[row + width - 1];
    }
  }
}

static void sign_rows(const float* field, uint32_t width, uint32_t rows, uint64_t* bits) {
  for (uint32_t row = 0; row < rows; ++row) {
    uint64_t word = 0;
    for (uint32_t x = 0; x < width; x += LANES) {
      const vint positive = v_load(field + (size_t)row * width + x) > v_set(0);
      word |= (uint64_t)v_bits(positive) << x;
    }
    bits[row] = word;
  }
}

static uint32_t farthest(const float* const points[3], uint32_t count, const float direction[3]) {
  vfloat most = v_set(-INFINITY);
  vint index = {0}, current = {0, 1, 2, 3, 4, 5, 6, 7};
  for (uint32_t at = 0; at < count; at += LANES, current += LANES) {
    const vfloat along = (v_load(points[0] + at) * v_set(direction[0]) + v_load(points[1] + at) * v_set(direction[1])) +
                         v_load(points[2] + at) * v_set(direction[2]);
    const vint more = along > most;
    most = v_select(more, along, most);
    index = v_select_int(more, current, index);
  }
  uint32_t lane = 0;
  for (uint32_t i = 1; i < LANES; ++i)
    if (most[i] > most[lane] || (most[i] == most[lane] && index[i] < index[lane])) lane = i;
  return (uint32_t)index[lane];
}

const kernel_set KERNELS_TABLE = {KERNELS_NAME, voronoi_block, rock_field, rock_erode, carve_step, sign_rows, farthest};
