/* The kernels themselves, included by kernels_plain.c and kernels_avx2.c with KERNELS_TABLE and KERNELS_NAME set. Vectors of eight
 * floats: two registers on a plain target, one with AVX2. */
#include <math.h>
#include <string.h>

#include "kernels.h"

typedef float vf __attribute__((vector_size(32)));
typedef int32_t vi __attribute__((vector_size(32)));

static inline vf load(const float* p) {
  vf v;
  memcpy(&v, p, sizeof v);
  return v;
}
static inline void store(float* p, vf v) {
  memcpy(p, &v, sizeof v);
}
static inline vf splat(float s) {
  return (vf){s, s, s, s, s, s, s, s};
}
static inline vi select_int(vi mask, vi a, vi b) {
  return (a & mask) | (b & ~mask);
}
#ifdef __AVX2__
/* The same choices as the portable ones below, spelt for the machine: minps(a, b) is a < b ? a : b. */
static inline vf select(vi mask, vf a, vf b) {
  return __builtin_ia32_blendvps256(b, a, (vf)mask);
}
static inline vf least(vf a, vf b) {
  return __builtin_ia32_minps256(a, b);
}
static inline vf greatest(vf a, vf b) {
  return __builtin_ia32_maxps256(a, b);
}
#else
static inline vf select(vi mask, vf a, vf b) {
  return (vf)(((vi)a & mask) | ((vi)b & ~mask));
}
static inline vf least(vf a, vf b) {
  return select(a < b, a, b);
}
static inline vf greatest(vf a, vf b) {
  return select(a > b, a, b);
}
#endif
static inline vf root(vf v) {
  vf out;
  for (int i = 0; i < LANES; ++i) out[i] = sqrtf(v[i]);
  return out;
}

static void voronoi_block(const block_tables* tables, const block_seed* seeds, uint32_t count, const block_fields* out) {
  const uint32_t voxels = tables->voxels, plane = tables->plane;
  const vf scale = splat(tables->cells_per_unit);
  for (uint32_t z = 0; z < voxels; ++z) {
    const float plane_z = (float)(256 * (2 * (int32_t)z + 1));
    for (uint32_t at = 0; at < plane; at += LANES) {
      const vf x = load(tables->x + at), y = load(tables->y + at);
      vf best = splat(INFINITY), second = splat(INFINITY);
      vf best_x = splat(0), best_y = splat(0), best_z = splat(0), second_x = splat(0), second_y = splat(0), second_z = splat(0);
      vi owner = {0};
      for (uint32_t k = 0; k < count; ++k) {
        const block_seed* seed = &seeds[k];
        const uint32_t side_x = seed->corner & 1, side_y = seed->corner >> 1 & 1, side_z = seed->corner >> 2;
        const vf dx = (x - splat(seed->position[0])) * scale, dy = (y - splat(seed->position[1])) * scale;
        const vf dz = splat((plane_z - seed->position[2]) * tables->cells_per_unit);
        const float* m = seed->metric;
        const vf mx = (splat(m[0]) * dx + splat(m[3]) * dy) + splat(m[4]) * dz;
        const vf my = splat(m[1]) * dy + splat(m[5]) * dz;
        const vf mz = splat(m[2]) * dz;
        const vf form = (mx * dx + my * dy) + mz * dz;
        const vf weight = load(tables->weight_xy[seed->corner & 3] + at) * splat(tables->weight[side_z][z]);
        const vf distance = form * weight;
        const vf grad_x = (mx + splat(m[0]) * dx) * weight + distance * load(tables->slope_x[side_x] + at);
        const vf grad_y = (my + splat(m[1]) * dy + splat(m[3]) * dx) * weight + distance * load(tables->slope_y[side_y] + at);
        const vf grad_z = (mz + mz + splat(m[4]) * dx + splat(m[5]) * dy) * weight + distance * splat(tables->slope[side_z][z]);
        const vi first = distance < best, runner = distance < second;
        second_x = select(first, best_x, select(runner, grad_x, second_x));
        second_y = select(first, best_y, select(runner, grad_y, second_y));
        second_z = select(first, best_z, select(runner, grad_z, second_z));
        second = select(first, best, select(runner, distance, second));
        best_x = select(first, grad_x, best_x);
        best_y = select(first, grad_y, best_y);
        best_z = select(first, grad_z, best_z);
        best = select(first, distance, best);
        const int32_t number = (int32_t)k;
        owner = select_int(first, (vi){number, number, number, number, number, number, number, number}, owner);
      }
      /* Levels instead of distances, see block_fields. */
      const vf k = splat(tables->level), best_inverse = splat(1) / (best + k), second_inverse = splat(1) / (second + k);
      const vf best_scale = k * best_inverse * best_inverse, second_scale = k * second_inverse * second_inverse;
      const vf gx = best_x * best_scale - second_x * second_scale, gy = best_y * best_scale - second_y * second_scale;
      const vf gz = best_z * best_scale - second_z * second_scale;
      const vf slope = root((gx * gx + gy * gy) + gz * gz);
      const vf inverse = splat(1) / greatest(slope, splat(1e-3f));
      const vf best_level = splat(1) - k / (best + k), second_level = splat(1) - k / (second + k);
      const size_t to = (size_t)z * plane + at;
      store(out->nearest + to, best_level);
      store(out->depth + to, (second_level - best_level) * inverse);
      store(out->inverse_slope + to, inverse);
      for (int i = 0; i < LANES; ++i) out->owner[to + (size_t)i] = (uint8_t)owner[i];
    }
  }
}

static void rock_field(const rock_row* row, float limit, float* field) {
  const float* m = row->metric;
  const vf dy = splat(row->dy), dz = splat(row->dz);
  for (uint32_t at = 0; at < row->count; at += LANES) {
    const vf dx = load(row->dx + at);
    const vf mx = (splat(m[0]) * dx + splat(m[3]) * dy) + splat(m[4]) * dz;
    const vf my = splat(m[1]) * dy + splat(m[5]) * dz;
    const vf mz = splat(m[2]) * dz;
    const vf form = (mx * dx + my * dy) + mz * dz;
    const vf weight = (load(row->weight_x + at) * splat(row->weight_y)) * splat(row->weight_z);
    const vf distance = form * weight;
    const vf level = splat(1) - splat(row->level) / (distance + splat(row->level));
    const vf outside = (load(row->nearest + at) - level) * load(row->inverse_slope + at);
    vi own;
    memcpy(&own, row->own + at, sizeof own);
    vf value = select(own, load(row->depth + at), outside);
    store(field + at, greatest(least(value, splat(limit)), splat(-limit)));
  }
}

static void rock_erode(const rock_row* row, const rock_shape* shape, const float* noise, float* field, float* omega) {
  const vf y = splat(row->y), z = splat(row->z);
  for (uint32_t at = 0; at < row->count; at += LANES) {
    const vf x = load(row->x + at);
    vf nearest = splat(1e6f);
    for (uint32_t c = 0; c < shape->contact_count; ++c) {
      const vf dx = x - splat(shape->contacts[c][0]), dy = y - splat(shape->contacts[c][1]), dz = z - splat(shape->contacts[c][2]);
      nearest = least(nearest, (dx * dx + dy * dy) + dz * dz);
    }
    vf t = (root(nearest) - splat(shape->contact_radius)) * splat(shape->inverse_blend);
    t = greatest(least(t, splat(1)), splat(0));
    const vf damping = t * t * (splat(3) - splat(2) * t);
    vf value = load(field + at) - splat(shape->erosion) * damping;
    for (uint32_t p = 0; p < shape->plane_count; ++p) {
      const float* plane = shape->planes[p];
      value = least(value, splat(plane[3]) - ((splat(plane[0]) * x + splat(plane[1]) * y) + splat(plane[2]) * z));
    }
    value = value - load(noise + at) * damping;
    store(field + at, value);
    store(omega + at, damping);
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
        const vf here = load(p);
        const vf sum = ((load(p - 1) + load(p + 1)) + (load(p - width) + load(p + width))) + (load(p - slice) + load(p + slice));
        const vf change = least((sum - splat(6) * here) * splat(strength), splat(0));
        store(out + row + x, here + change * load(omega + row + x));
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
      const vi positive = load(field + (size_t)row * width + x) > splat(0);
      uint32_t byte = 0;
#ifdef __AVX2__
      byte = (uint32_t)__builtin_ia32_movmskps256((vf)positive);
#else
      for (uint32_t i = 0; i < LANES; ++i) byte |= (uint32_t)(positive[i] & 1) << i;
#endif
      word |= (uint64_t)byte << x;
    }
    bits[row] = word;
  }
}

static uint32_t farthest(const float* const points[3], uint32_t count, const float direction[3]) {
  vf most = splat(-INFINITY);
  vi index = {0}, current = {0, 1, 2, 3, 4, 5, 6, 7};
  for (uint32_t at = 0; at < count; at += LANES, current += LANES) {
    const vf along = (load(points[0] + at) * splat(direction[0]) + load(points[1] + at) * splat(direction[1])) +
                     load(points[2] + at) * splat(direction[2]);
    const vi more = along > most;
    most = select(more, along, most);
    index = select_int(more, current, index);
  }
  uint32_t lane = 0;
  for (uint32_t i = 1; i < LANES; ++i)
    if (most[i] > most[lane] || (most[i] == most[lane] && index[i] < index[lane])) lane = i;
  return (uint32_t)index[lane];
}

const kernel_set KERNELS_TABLE = {KERNELS_NAME, voronoi_block, rock_field, rock_erode, carve_step, sign_rows, farthest};
