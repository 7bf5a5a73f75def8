#include "weather_kernels.h"

#define KERNELS_TABLE weather_kernels_plain
#define KERNELS_NAME "plain"
#include "weather_kernels_body.h"

const weather_kernels* weather_kernels_choose(void) {
#ifdef SCREE_WIDE_KERNELS
  if (__builtin_cpu_supports("avx2")) return &weather_kernels_avx2;
#endif
  return &weather_kernels_plain;
}
