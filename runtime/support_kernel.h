/* Evaluation of support programs, as static functions: included by each kernel (query_kernel_plain.c, query_kernel_avx2.c) and
 * compiled for its target. Distances after Inigo Quilez, "Distance functions"; all are exact or never too large, so moving by s
 * changes them by at most lipschitz * s. */
#ifndef SCREE_SUPPORT_KERNEL_H
#define SCREE_SUPPORT_KERNEL_H

#include "support_callback.h"
#include "support_noise_kernel.h"
#include "support_shapes_kernel.h"

static inline vfloat distance_sphere(const support_op* op, vpoint p) {
  vpoint q = minus(p, op->sphere.centre);
  return length3(q.x, q.y, q.z) - v_set(op->sphere.radius);
}

static inline vfloat distance_core(const support_op* op, vpoint q) {
  const vfloat zero = v_set(0);
  vfloat x = v_abs(q.x) - v_set(op->box.core[0]);
  vfloat y = v_abs(q.y) - v_set(op->box.core[1]);
  vfloat z = v_abs(q.z) - v_set(op->box.core[2]);
  vfloat outside = length3(v_max(x, zero), v_max(y, zero), v_max(z, zero));
  return outside + v_min(v_max(x, v_max(y, z)), zero) - v_set(op->box.rounding);
}

static inline vfloat distance_capsule(const support_op* op, vpoint p) {
  vpoint q = minus(p, op->capsule.a);
  const float* ab = op->capsule.ab;
  vfloat t = v_clamp(dot3(q.x, q.y, q.z, ab) * v_set(op->capsule.inverse_length2), v_set(0), v_set(1));
  return length3(q.x - t * v_set(ab[0]), q.y - t * v_set(ab[1]), q.z - t * v_set(ab[2])) - v_set(op->capsule.radius);
}

static inline vfloat distance_cylinder(const support_op* op, vpoint p) {
  const vfloat zero = v_set(0);
  vfloat height, r = off_axis(minus(p, op->cylinder.centre), op->cylinder.axis, &height);
  vfloat a = r - v_set(op->cylinder.radius), b = v_abs(height) - v_set(op->cylinder.half_height);
  return length2(v_max(a, zero), v_max(b, zero)) + v_min(v_max(a, b), zero);
}

/* In the half plane (r, height): the nearest of the base, from (0, 0) to (radius, 0), and the side, from there to (0, height). */
static inline vfloat distance_cone(const support_op* op, vpoint p) {
  const vfloat radius = v_set(op->cone.radius), tall = v_set(op->cone.height);
  vfloat y, r = off_axis(minus(p, op->cone.base), op->cone.axis, &y);
  vfloat out = r - radius; /* from the rim */
  vfloat t = v_clamp((y * tall - out * radius) * v_set(op->cone.inverse_side2), v_set(0), v_set(1));
  vfloat side_r = out + t * radius, side_y = y - t * tall;
  vfloat base_r = v_max(out, v_set(0));
  vfloat d = v_sqrt(v_min(side_r * side_r + side_y * side_y, base_r * base_r + y * y));
  vint inside = (y > v_set(0)) & (out * tall + y * radius < v_set(0));
  return v_select(inside, -d, d);
}

/* For each lane the words at index and index + 1, and both again `above` words on, by row and column. GCC 12 would not find this,
 * and gathers take three times as long. */
static inline void load_corners(const uint32_t* samples, size_t above, vint index, vint dword[2][2]) {
  int32_t at[SIMD_WIDTH];
  memcpy(at, &index, sizeof at);
#if SIMD_WIDTH == 8
  __m128i point[8]; /* of one lane: (x, z), (x + 1, z), (x, z + 1), (x + 1, z + 1) */
  for (int i = 0; i < 8; ++i) {
    const uint32_t* s = samples + (uint32_t)at[i];
    point[i] = _mm_unpacklo_epi64(_mm_loadl_epi64((const __m128i*)(const void*)s),
                                  _mm_loadl_epi64((const __m128i*)(const void*)(s + above)));
  }
  __m256i p04 = _mm256_inserti128_si256(_mm256_castsi128_si256(point[0]), point[4], 1);
  __m256i p15 = _mm256_inserti128_si256(_mm256_castsi128_si256(point[1]), point[5], 1);
  __m256i p26 = _mm256_inserti128_si256(_mm256_castsi128_si256(point[2]), point[6], 1);
  __m256i p37 = _mm256_inserti128_si256(_mm256_castsi128_si256(point[3]), point[7], 1);
  __m256i low01 = _mm256_unpacklo_epi32(p04, p15), low23 = _mm256_unpacklo_epi32(p26, p37);
  __m256i high01 = _mm256_unpackhi_epi32(p04, p15), high23 = _mm256_unpackhi_epi32(p26, p37);
  dword[0][0] = (vint)_mm256_unpacklo_epi64(low01, low23);
  dword[0][1] = (vint)_mm256_unpackhi_epi64(low01, low23);
  dword[1][0] = (vint)_mm256_unpacklo_epi64(high01, high23);
  dword[1][1] = (vint)_mm256_unpackhi_epi64(high01, high23);
#else
  for (int i = 0; i < SIMD_WIDTH; ++i)
    for (int z = 0; z < 2; ++z)
      for (int x = 0; x < 2; ++x) dword[z][x][i] = (int32_t)samples[(uint32_t)at[i] + (size_t)z * above + (size_t)x];
#endif
}

/* `rough`: only whether it is less than, equal to or more than 0 is asked. */
static inline vfloat distance_height(const support_op* op, vpoint p, bool rough) {
  const support_height* g = op->height.grid;
  const vfloat zero = v_set(0);
  vpoint q = into_frame(&op->height.frame, p);
  vfloat u = v_clamp(q.x * v_set(g->inverse_spacing) + v_set(g->middle_u), zero, v_set((float)(g->width - 1)));
  vfloat v = v_clamp(q.z * v_set(g->inverse_spacing) + v_set(g->middle_v), zero, v_set((float)(g->depth - 1)));
  vint iu = v_truncate(v_min(u, v_set((float)(g->width - 2)))), iv = v_truncate(v_min(v, v_set((float)(g->depth - 2))));
  u -= v_from_int(iu);
  v -= v_from_int(iv);
  vint index = iv * v_set_int((int32_t)g->width) + iu;
  vint corner[2][2];
  load_corners((const uint32_t*)(const void*)g->heights, g->width, index, corner);
  const vfloat h00 = (vfloat)corner[0][0], h10 = (vfloat)corner[0][1], h01 = (vfloat)corner[1][0], h11 = (vfloat)corner[1][1];
  vfloat near_side = h00 + u * (h10 - h00), far_side = h01 + u * (h11 - h01);
  vfloat surface = near_side + v * (far_side - near_side);
  vfloat vertical = v_abs(q.y - surface - v_set(op->height.middle)) - v_set(op->height.half);
  vfloat way = v_abs(vertical), least = way * v_set(g->cosine);
  if (!rough && v_bits(way < v_set(g->local)) != 0) { /* elsewhere the least is more, to the bit */
    vuint corners = (vuint)v_gather_int(g->cosines, index);
    const vuint byte = (vuint)v_set_int(0xff);
    vfloat c00 = v_from_int((vint)(corners & byte)), c10 = v_from_int((vint)(corners >> 8 & byte));
    vfloat c01 = v_from_int((vint)(corners >> 16 & byte)), c11 = v_from_int((vint)(corners >> 24));
    vfloat near_cosine = c00 + u * (c10 - c00), far_cosine = c01 + u * (c11 - c01);
    vfloat cosine = (near_cosine + v * (far_cosine - near_cosine)) * v_set(1.0f / HEIGHT_COSINE);
    least = v_max(way * cosine / (v_set(1) + way * v_set(g->bend)), least);
  }
  vfloat layer = v_select(vertical < zero, -least, least);
  vfloat x = v_abs(q.x) - v_set(g->extent_x), z = v_abs(q.z) - v_set(g->extent_z);
  vfloat beside = length2(v_max(x, zero), v_max(z, zero)) + v_min(v_max(x, z), zero);
  return v_max(layer, beside) * v_set(op->height.frame.scale);
}

/* The eight corners of a grid cell for each lane. */
static inline void mesh_corners(const support_mesh* g, vint index, vfloat c[2][2][2]) {
  vint dword[2][2]; /* by z, x: the pairs along y */
  load_corners(g->samples, (size_t)g->size[0] * g->size[1], index, dword);
  for (int z = 0; z < 2; ++z)
    for (int x = 0; x < 2; ++x) {
      c[z][0][x] = v_from_int((vint)((vuint)dword[z][x] << 16) >> 16);
      c[z][1][x] = v_from_int(dword[z][x] >> 16);
    }
}

static inline vfloat distance_mesh(const support_op* op, vpoint p) {
  const support_mesh* g = op->mesh.grid;
  vpoint q = into_frame(&op->mesh.frame, p);
  const vfloat zero = v_set(0);
  vfloat at[3] = {q.x, q.y, q.z}, part[3], away2 = zero;
  vint cell[3];
  for (int a = 0; a < 3; ++a) {
    vfloat inside = v_clamp(at[a], v_set(g->low[a]), v_set(g->high[a]));
    vfloat away = at[a] - inside;
    away2 += away * away;
    vfloat u = (inside - v_set(g->low[a])) * v_set(g->inverse_step);
    cell[a] = v_truncate(v_clamp(u, zero, v_set((float)(g->size[a] - 2))));
    part[a] = v_min(u - v_from_int(cell[a]), v_set(1));
  }
  vint row = v_set_int((int32_t)g->size[0]), index = (cell[2] * v_set_int((int32_t)g->size[1]) + cell[1]) * row + cell[0];
  vfloat c[2][2][2]; /* corners by z, y, x, in quanta */
  mesh_corners(g, index, c);
  vfloat plane[2];
  for (int k = 0; k < 2; ++k) {
    vfloat line0 = c[k][0][0] + part[0] * (c[k][0][1] - c[k][0][0]), line1 = c[k][1][0] + part[0] * (c[k][1][1] - c[k][1][0]);
    plane[k] = line0 + part[1] * (line1 - line0);
  }
  vfloat d = (plane[0] + part[2] * (plane[1] - plane[0])) * v_set(g->quantum);
  /* Beside the grid: what the nearest point of the grid says, at right angles to the way there. */
  d = v_select(away2 > zero, v_sqrt(d * d + away2), d);
  return d * v_set(op->mesh.frame.scale);
}

static inline vfloat smooth_min(vfloat a, vfloat b, float blend, float inverse_blend) {
  vfloat h = v_max(v_set(blend) - v_abs(a - b), v_set(0)) * v_set(inverse_blend);
  return v_min(a, b) - h * h * v_set(blend * 0.25f);
}

static void distance_callback(const support_op* op, const float* x, const float* y, const float* z, float* d, uint32_t count) {
  float px[SUPPORT_BATCH] = {0}, py[SUPPORT_BATCH] = {0}, pz[SUPPORT_BATCH] = {0};
  for (uint32_t i = 0; i < count; i += SIMD_WIDTH) {
    vpoint q = into_frame(&op->callback.frame, (vpoint){v_load(x + i), v_load(y + i), v_load(z + i)});
    v_store(px + i, q.x);
    v_store(py + i, q.y);
    v_store(pz + i, q.z);
  }
  op->callback.distance(op->callback.user, px, py, pz, d, count);
#ifndef NDEBUG
  scree_rt_support_callback_check(op, px, py, pz, d, count);
#endif
  /* What is not a number makes no rock appear: it is outside, or inside where the callback is taken away from something. */
  const vfloat none = v_set(op->flipped ? -INFINITY : INFINITY);
  const float *low = op->callback.min, *high = op->callback.max;
  for (uint32_t i = 0; i < count; i += SIMD_WIDTH) {
    vfloat qx = v_load(px + i), qy = v_load(py + i), qz = v_load(pz + i), value = v_load(d + i);
    vfloat away = length3(qx - v_clamp(qx, v_set(low[0]), v_set(high[0])), qy - v_clamp(qy, v_set(low[1]), v_set(high[1])),
                          qz - v_clamp(qz, v_set(low[2]), v_set(high[2])));
    value = v_select(value == value, value, none);
    value = v_select(away > v_set(0), v_max(away, value), value);
    v_store(d + i, value * v_set(op->callback.frame.scale));
  }
}

/* Distances of one leaf; count is a multiple of SIMD_WIDTH and at most SUPPORT_BATCH. `signs`: only the signs of the program's
 * distances are asked. */
static void evaluate_leaf(const support_op* op, const float* x, const float* y, const float* z, float* d, uint32_t count,
                          bool signs) {
  const bool rough = signs && op->slack_low == 0 && op->slack_high == 0; /* nothing adds to it */
#define EACH(expression)                                            \
  for (uint32_t i = 0; i < count; i += SIMD_WIDTH) {                \
    const vpoint p = {v_load(x + i), v_load(y + i), v_load(z + i)}; \
    v_store(d + i, expression);                                     \
  }                                                                 \
  break
  switch (op->kind) {
    case OP_SPHERE: EACH(distance_sphere(op, p));
    case OP_BOX: EACH(distance_core(op, minus(p, op->box.frame.centre)));
    case OP_BOX_TURNED: EACH(distance_core(op, into_frame(&op->box.frame, p)));
    case OP_CAPSULE: EACH(distance_capsule(op, p));
    case OP_CYLINDER: EACH(distance_cylinder(op, p));
    case OP_CONE: EACH(distance_cone(op, p));
    case OP_HEIGHTFIELD: EACH(distance_height(op, p, rough));
    case OP_MESH: EACH(distance_mesh(op, p));
    case OP_ELLIPSOID: EACH(distance_ellipsoid(op, p));
    case OP_HALF_SPACE: EACH(distance_half_space(op, p));
    case OP_TORUS: EACH(distance_torus(op, p));
    case OP_EXTRUSION: EACH(distance_extrusion(op, p));
    case OP_PIPE: EACH(distance_pipe(op, p));
    case OP_BAND: EACH(distance_band(op, p));
    case OP_BLOBS: EACH(distance_blobs(op, p));
    case OP_LINES: EACH(distance_lines(op, p));
    case OP_RINGS: EACH(distance_rings(op, p));
    case OP_WAVES: EACH(distance_waves(op, p));
    default: distance_callback(op, x, y, z, d, count); break;
  }
#undef EACH
}

static void combine(const support_op* op, float* a, const float* b, uint32_t count) {
#define EACH(expression)                                 \
  for (uint32_t i = 0; i < count; i += SIMD_WIDTH) {     \
    const vfloat va = v_load(a + i), vb = v_load(b + i); \
    v_store(a + i, expression);                          \
  }                                                      \
  break
  switch (op->kind) {
    case OP_UNION: EACH(v_min(va, vb));
    case OP_INTERSECTION: EACH(v_max(va, vb));
    case OP_DIFFERENCE: EACH(v_max(va, -vb));
    default: EACH(smooth_min(va, vb, op->smooth.blend, op->smooth.inverse_blend));
  }
#undef EACH
}

/* The operations on one value. */
static void change(const support_op* op, const float* x, const float* y, const float* z, float* a, uint32_t count) {
  for (uint32_t i = 0; i < count; i += SIMD_WIDTH) {
    vfloat v = v_load(a + i);
    v_store(a + i, op->kind == OP_NEGATE ? -v : v + noise_at(op, (vpoint){v_load(x + i), v_load(y + i), v_load(z + i)}));
  }
}

/* Distances of a program; count as above. `values` is scratch. The result lies in values[0]. */
static void evaluate_program(const support_op* ops, const uint16_t* program, uint32_t length, const float* x, const float* y,
                             const float* z, float values[SUPPORT_MAX_STACK][SUPPORT_BATCH], uint32_t count, bool signs) {
  uint32_t top = 0;
  for (uint32_t i = 0; i < length; ++i) {
    const support_op* op = &ops[program[i]];
    if (op_is_leaf(op->kind)) {
      evaluate_leaf(op, x, y, z, values[top++], count, signs);
    } else if (op_is_pair(op->kind)) {
      --top;
      combine(op, values[top - 1], values[top], count);
    } else {
      change(op, x, y, z, values[top - 1], count);
    }
  }
}

#endif
