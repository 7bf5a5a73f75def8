/* The kernels for any machine. */
#include "query_walk_kernel.h"

void scree_rt_query_run_plain(query_run* run) {
  walk_query(run);
}

void scree_rt_support_evaluate_plain(const support_op* ops, const uint16_t* program, uint32_t length, const float* x,
                                     const float* y, const float* z, float* distance, uint32_t count) {
  float values[SUPPORT_MAX_STACK][SUPPORT_BATCH];
  evaluate_program(ops, program, length, x, y, z, values, (count + SIMD_WIDTH - 1) / SIMD_WIDTH * SIMD_WIDTH, false);
  memcpy(distance, values[0], count * sizeof *distance);
}
