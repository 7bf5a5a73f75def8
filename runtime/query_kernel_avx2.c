/* The same kernels with AVX2, compiled with -mavx2 and called only where the machine has it. */
#include "query_walk_kernel.h"

void scree_rt_query_run_avx2(query_run* run) {
  walk_query(run);
}
