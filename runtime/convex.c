/* Based on: Gilbert, Johnson, Keerthi, A Fast Procedure for Computing the Distance between Complex Objects in Three-Dimensional
 * Space, 1988; van den Bergen, Ray Casting against General Convex Objects with Application to Continuous Collision Detection,
 * 2004. Where we differ: the closest point of a simplex is the best of its parts that hold the newest vertex, each judged by
 * itself, so that flat simplices need no special case; on a triangle it is taken along the triangle's normal, whose direction stays
 * right however near the origin is. */
#include "convex.h"

#include "convex_kernel.h"

/* A ray has arrived when it is this near the hull, squared: for the hull's size, and for how far the start is from it. */
#define RAY_TOUCH2 1e-20
#define RAY_ROUNDING2 1e-30

convex_measure scree_rt_convex_measure(const convex_hull* hull) {
#ifdef SCREE_WIDE_KERNELS
  if (__builtin_cpu_supports("avx2")) return scree_rt_convex_measure_avx2(hull);
#endif
  return measure_hull(hull);
}

bool scree_rt_convex_meet_measured(const convex_hull* a, const convex_measure* of_a, const convex_hull* b,
                                   const convex_measure* of_b) {
#ifdef SCREE_WIDE_KERNELS
  if (__builtin_cpu_supports("avx2")) return scree_rt_convex_meet_measured_avx2(a, of_a, b, of_b);
#endif
  return points_meet(a, of_a, b, of_b);
}

bool scree_rt_convex_meet(const convex_hull* a, const convex_hull* b) {
  const convex_measure of_a = scree_rt_convex_measure(a), of_b = scree_rt_convex_measure(b);
  return scree_rt_convex_meet_measured(a, &of_a, b, &of_b);
}

double scree_rt_convex_distance(const convex_hull* a, const convex_hull* b) {
  const convex_measure of_a = measure_hull(a), of_b = measure_hull(b);
  pair p = make_pair(a, &of_a, b, &of_b);
  double distance = sqrt(points_distance2(&p, -1, p.apart)) - (a->radius + b->radius);
  return distance > sqrt(p.size2) * CONVEX_TOUCH ? distance : 0;
}

/* --- a ray ------------------------------------------------------------------------------------------------------------------ */

/* The place moves from the start along the ray to each plane that is found to lie between it and the hull, and the hull's closest
 * point to the new place tells the next plane, until the place is on the hull. */
bool scree_rt_convex_ray(const convex_hull* hull, const double start[3], const double direction[3], double reach, double* t,
                         double normal[3]) {
  const vec origin = subtract(load(start), load(hull->at)), along = load(direction);
  vec place = origin, plane = times(along, -1);
  simplex s = {.count = 0};
  extend(&s, subtract(place, point_of(hull, 0)), 0);
  double at = 0, size2 = 0;
  for (uint32_t i = 0; i < hull->count; ++i) size2 = larger(size2, dot(point_of(hull, i), point_of(hull, i)));
  const float size = measure_hull(hull).size;
  const double touch = size2 * RAY_TOUCH2 + dot(origin, origin) * RAY_ROUNDING2;
  for (int step = 0; step < MAX_STEPS && s.distance2 > touch; ++step) {
    const uint32_t name = farthest(hull, s.closest, size);
    const vec point = point_of(hull, name);
    bool moved = false;
    if (dot(s.closest, subtract(place, point)) > 0) { /* the plane through the point lies between */
      double speed = dot(s.closest, along);
      if (!(speed < 0)) return false;
      double next = -dot(s.closest, subtract(origin, point)) / speed;
      if (!(next <= reach)) return false;
      moved = next > at;
      if (moved) {
        at = next;
        plane = s.closest;
        place = add(origin, times(along, at));
        for (uint32_t i = 0; i < s.count; ++i) s.at[i] = subtract(place, point_of(hull, s.name[i]));
      }
    }
    if (has(&s, name)) {
      if (!moved) break;
    } else {
      s.at[s.count] = subtract(place, point);
      s.name[s.count++] = name;
    }
    if (!reduce(&s, moved ? 0 : s.count - 1)) {
      s.distance2 = 0;
      break;
    }
  }
  if (s.distance2 > touch + size2 * (CONVEX_TOUCH * CONVEX_TOUCH)) return false;
  const double length = sqrt(dot(plane, plane));
  *t = at;
  normal[0] = plane.x / length;
  normal[1] = plane.y / length;
  normal[2] = plane.z / length;
  return true;
}
