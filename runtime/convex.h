/* Convex hulls given as points: whether two meet, how far they are apart, where a ray meets one.
 *
 *   hull = all p with |p - (at + scale * c)| <= radius for some c in the convex hull of the points
 *
 * Decided in double with + - * / sqrt in a fixed order: the same bits on every machine. Every formula is odd in the difference of
 * its two hulls, so that A asked about B and B asked about A give the same answer, always.
 *
 * Touching is meeting: hulls meet when they are no farther apart than CONVEX_TOUCH times the pair's size (the largest difference
 * of two of their points that was looked at), which is far above rounding and far below anything that can be seen. Points may
 * coincide, lie on a line or in a plane. */
#ifndef SCREE_CONVEX_H
#define SCREE_CONVEX_H

#include <stdbool.h>
#include <stdint.h>

#define CONVEX_TOUCH 0x1p-24

enum { CONVEX_MAX_POINTS = 64 };

/* Keeps pointers: the coordinates stay the caller's. */
typedef struct convex_hull {
  const float *x, *y, *z; /* `count` each */
  uint32_t count;         /* 1..CONVEX_MAX_POINTS */
  double scale;           /* > 0 */
  double at[3];
  double radius; /* >= 0, in units of `at` */
} convex_hull;

/* What is asked of a hull in every pair, in its own units. */
typedef struct convex_measure {
  float low[3], high[3]; /* the smallest box of its points */
  float size;            /* no coordinate is larger */
  double middle[3];      /* somewhere in the hull */
} convex_measure;

convex_measure scree_rt_convex_measure(const convex_hull* hull);

/* Whether two hulls have a point in common. Stops at the first direction that separates them, and at the first tetrahedron that
 * shows that they meet. */
bool scree_rt_convex_meet(const convex_hull* a, const convex_hull* b);

/* The same, where the measures of both are known. */
bool scree_rt_convex_meet_measured(const convex_hull* a, const convex_measure* of_a, const convex_hull* b,
                                   const convex_measure* of_b);
#ifdef SCREE_WIDE_KERNELS
/* The same two, for machines that have AVX2. */
convex_measure scree_rt_convex_measure_avx2(const convex_hull* hull);
bool scree_rt_convex_meet_measured_avx2(const convex_hull* a, const convex_measure* of_a, const convex_hull* b,
                                        const convex_measure* of_b);
#endif

/* The distance of two hulls, 0 where they meet. Right to about 1e-9 of the pair's size. */
double scree_rt_convex_distance(const convex_hull* a, const convex_hull* b);

/* Where the ray start + t * direction, 0 <= t <= reach, first meets a hull; its radius is not looked at. direction: unit. start:
 * relative to the same point as `at`. normal: unit, of the face that is met; where the start is inside, t = 0 and the normal is
 * -direction. Returns false when the ray misses. */
bool scree_rt_convex_ray(const convex_hull* hull, const double start[3], const double direction[3], double reach, double* t,
                         double normal[3]);

#endif
