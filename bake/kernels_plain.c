#include "kernels.h"

#define KERNELS_TABLE kernels_plain
#define KERNELS_NAME "plain"
#include "kernels_body.h"

const kernel_set* kernels_choose(bool plain) {
#ifdef SCREE_WIDE_KERNELS
  if (!plain && __builtin_cpu_supports("avx2")) return &kernels_avx2;
#endif
  (void)plain;
  return &kernels_plain;
}
