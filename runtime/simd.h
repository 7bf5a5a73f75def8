/* Short vectors of floats for the kernels, in runtime/ and in bake/, that are compiled twice, once for the plain target and once
 * for AVX2.
 *
 * Everything here has one meaning whatever the width: the lanes never talk to each other, and each operation is the IEEE one
 * that the scalar language has. So both builds of a kernel give the same bits. Comparisons give all ones or all zeros.
 * GCC's and clang's vector extensions carry + - * / and comparisons; only what they lack is spelt out for each target. */
#ifndef SCREE_SIMD_H
#define SCREE_SIMD_H

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Whoever includes this may ask for a width; the compiler then makes up what the machine's registers do not hold. */
#if !defined(SIMD_WIDTH) && defined(__AVX2__)
#define SIMD_WIDTH 8
#elif !defined(SIMD_WIDTH)
#define SIMD_WIDTH 4
#endif
#if SIMD_WIDTH == 8 && defined(__AVX2__)
#define SIMD_AVX2
#include <immintrin.h>
#elif SIMD_WIDTH == 4 && defined(__SSE2__)
#define SIMD_SSE2
#include <emmintrin.h>
#elif SIMD_WIDTH == 4 && defined(__aarch64__)
#define SIMD_NEON
#include <arm_neon.h>
#endif

typedef float vfloat __attribute__((vector_size(4 * SIMD_WIDTH)));
typedef int32_t vint __attribute__((vector_size(4 * SIMD_WIDTH)));
typedef uint32_t vuint __attribute__((vector_size(4 * SIMD_WIDTH)));

static inline vfloat v_load(const float* from) {
  vfloat v;
  memcpy(&v, from, sizeof v);
  return v;
}

static inline void v_store(float* to, vfloat v) {
  memcpy(to, &v, sizeof v);
}

static inline vfloat v_set(float x) {
  return x - (vfloat){0};
}

static inline vint v_set_int(int32_t x) {
  return x - (vint){0};
}

/* mask ? a : b, lane by lane. */
static inline vfloat v_select(vint mask, vfloat a, vfloat b) {
#if defined(SIMD_AVX2)
  return (vfloat)_mm256_blendv_ps((__m256)b, (__m256)a, (__m256)mask);
#else
  return (vfloat)(((vint)a & mask) | ((vint)b & ~mask));
#endif
}

static inline vint v_select_int(vint mask, vint a, vint b) {
  return (a & mask) | (b & ~mask);
}

/* a < b ? a : b and a > b ? a : b: the second when a lane is not a number, which is how a bound is put on anything at all. */
static inline vfloat v_min(vfloat a, vfloat b) {
#if defined(SIMD_AVX2)
  return (vfloat)_mm256_min_ps((__m256)a, (__m256)b);
#elif defined(SIMD_SSE2)
  return (vfloat)_mm_min_ps((__m128)a, (__m128)b);
#else
  return v_select(a < b, a, b);
#endif
}

static inline vfloat v_max(vfloat a, vfloat b) {
#if defined(SIMD_AVX2)
  return (vfloat)_mm256_max_ps((__m256)a, (__m256)b);
#elif defined(SIMD_SSE2)
  return (vfloat)_mm_max_ps((__m128)a, (__m128)b);
#else
  return v_select(a > b, a, b);
#endif
}

/* The largest lane. */
static inline float v_most(vfloat v) {
#if defined(SIMD_AVX2) || defined(SIMD_SSE2)
#if defined(SIMD_AVX2)
  __m128 m = _mm_max_ps(_mm256_castps256_ps128((__m256)v), _mm256_extractf128_ps((__m256)v, 1));
#else
  __m128 m = (__m128)v;
#endif
  m = _mm_max_ps(m, _mm_movehl_ps(m, m));
  return _mm_cvtss_f32(_mm_max_ss(m, _mm_shuffle_ps(m, m, 1)));
#else
  float most = v[0];
  for (int i = 1; i < SIMD_WIDTH; ++i) most = v[i] > most ? v[i] : most;
  return most;
#endif
}

static inline vfloat v_clamp(vfloat v, vfloat low, vfloat high) {
  return v_max(v_min(v, high), low);
}

static inline vfloat v_abs(vfloat v) {
  return (vfloat)((vint)v & v_set_int(INT32_MAX));
}

static inline vfloat v_sqrt(vfloat v) {
#if defined(SIMD_AVX2)
  return (vfloat)_mm256_sqrt_ps((__m256)v);
#elif defined(SIMD_SSE2)
  return (vfloat)_mm_sqrt_ps((__m128)v);
#elif defined(SIMD_NEON)
  return (vfloat)vsqrtq_f32((float32x4_t)v);
#else
  for (int i = 0; i < SIMD_WIDTH; ++i) v[i] = sqrtf(v[i]);
  return v;
#endif
}

/* Towards zero; lanes must fit int32. */
static inline vint v_truncate(vfloat v) {
  return __builtin_convertvector(v, vint);
}

static inline vfloat v_from_int(vint v) {
  return __builtin_convertvector(v, vfloat);
}

/* The largest whole number that is not larger; of any float. Never -0. */
static inline vfloat v_floor(vfloat v) {
#if defined(SIMD_AVX2)
  return (vfloat)_mm256_floor_ps((__m256)v) + v_set(0);
#else
  const vfloat whole = v_set(8388608); /* from here on floats have no fractions */
  vint small = v_abs(v) < whole;
  vfloat t = v_from_int(v_truncate(v_select(small, v, v_set(0))));
  return v_select(small, t - (vfloat)((vint)v_set(1) & (t > v)), v);
#endif
}

/* Bit i is set where lane i of a comparison is. */
static inline uint32_t v_bits(vint mask) {
#if defined(SIMD_AVX2)
  return (uint32_t)_mm256_movemask_ps((__m256)mask);
#elif defined(SIMD_SSE2)
  return (uint32_t)_mm_movemask_ps((__m128)mask);
#else
  uint32_t bits = 0;
  for (int i = 0; i < SIMD_WIDTH; ++i) bits |= ((uint32_t)mask[i] & 1u) << i;
  return bits;
#endif
}

/* table[index], lane by lane; GCC 12 does not find the AVX2 gather by itself. */
static inline vint v_gather_int(const uint32_t* table, vint index) {
#if defined(__AVX2__)
  return (vint)_mm256_i32gather_epi32((const int*)(const void*)table, (__m256i)index, 4);
#else
  vint v = {0};
  for (int i = 0; i < SIMD_WIDTH; ++i) v[i] = (int32_t)table[index[i]];
  return v;
#endif
}

static inline vfloat v_gather(const float* table, vint index) {
#if defined(SIMD_AVX2)
  return (vfloat)_mm256_i32gather_ps(table, (__m256i)index, 4);
#else
  vfloat v = {0};
  for (int i = 0; i < SIMD_WIDTH; ++i) v[i] = table[index[i]];
  return v;
#endif
}

#endif
