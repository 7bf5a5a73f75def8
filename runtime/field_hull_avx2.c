/* Points of hulls with AVX2: compiled with -mavx2 and called only where the machine has it. */
#include <immintrin.h>

#include "field_tables.h"

static inline void store_floats(__m128i v, float* to) {
  _mm256_storeu_ps(to, _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(v)));
}

/* Eight points at a time: 24 numbers in three vectors, whose bytes each coordinate picks. */
void scree_rt_field_split_points_avx2(const void* xyz, bool narrow, uint32_t count, float* x, float* y, float* z) {
  const int8_t* bytes = xyz;
  const int16_t* words = xyz;
  static const int8_t picks[3][3][16] = {{{0, 1, 6, 7, 12, 13, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1},
                                          {-1, -1, -1, -1, -1, -1, 2, 3, 8, 9, 14, 15, -1, -1, -1, -1},
                                          {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, 4, 5, 10, 11}},
                                         {{2, 3, 8, 9, 14, 15, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1},
                                          {-1, -1, -1, -1, -1, -1, 4, 5, 10, 11, -1, -1, -1, -1, -1, -1},
                                          {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, 0, 1, 6, 7, 12, 13}},
                                         {{4, 5, 10, 11, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1},
                                          {-1, -1, -1, -1, 0, 1, 6, 7, 12, 13, -1, -1, -1, -1, -1, -1},
                                          {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, 2, 3, 8, 9, 14, 15}}};
  float* const to[3] = {x, y, z};
  uint32_t i = 0;
  for (; i + 8 <= count; i += 8) {
    __m128i from[3];
    for (int v = 0; v < 3; ++v)
      from[v] = narrow ? _mm_cvtepi8_epi16(_mm_loadl_epi64((const __m128i*)(const void*)(bytes + 3 * i + 8 * v)))
                       : _mm_loadu_si128((const __m128i*)(const void*)(words + 3 * i + 8 * v));
    for (int a = 0; a < 3; ++a) {
      __m128i sum = _mm_setzero_si128();
      for (int v = 0; v < 3; ++v)
        sum = _mm_or_si128(sum, _mm_shuffle_epi8(from[v], _mm_loadu_si128((const __m128i*)(const void*)picks[a][v])));
      store_floats(sum, to[a] + i);
    }
  }
  for (; i < count; ++i)
    for (uint32_t a = 0; a < 3; ++a) to[a][i] = narrow ? bytes[3 * i + a] : words[3 * i + a];
}
