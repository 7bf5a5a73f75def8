/* Whether two hulls meet, with AVX2: compiled with -mavx2 and called only where the machine has it. */
#include "convex_kernel.h"

bool scree_rt_convex_meet_avx2(const convex_hull* a, const convex_hull* b) {
  return points_meet(a, b);
}
