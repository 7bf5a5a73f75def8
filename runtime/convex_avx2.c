/* Whether two hulls meet, with AVX2: compiled with -mavx2 and called only where the machine has it. */
#include "convex_kernel.h"

convex_measure scree_rt_convex_measure_avx2(const convex_hull* hull) {
  return measure_hull(hull);
}

bool scree_rt_convex_meet_measured_avx2(const convex_hull* a, const convex_measure* of_a, const convex_hull* b,
                                        const convex_measure* of_b) {
  return points_meet(a, of_a, b, of_b);
}
