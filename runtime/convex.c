/* Based on: Gilbert, Johnson, Keerthi, A Fast Procedure for Computing the Distance between Complex Objects in Three-Dimensional
 * Space, 1988; van den Bergen, Ray Casting against General Convex Objects with Application to Continuous Collision Detection,
 * 2004. Where we differ: the closest point of a simplex is the best of its parts that hold the newest vertex, each judged by
 * itself, so that flat simplices need no special case; on a triangle it is taken along the triangle's normal, whose direction stays
 * right however near the origin is. */
#include "convex.h"

#include <math.h>
#include <stddef.h>

/* Distances stop getting smaller after a handful of steps; the bound only keeps rounding from walking in a circle. */
enum { MAX_STEPS = 64 };

#define PROGRESS 1e-12 /* a step that brings less of the squared distance than this is the last */
#define FLAT2 1e-16    /* triangles and tetrahedra flatter than the root of this, for their size, are left to their borders */

/* A ray has arrived when it is this near the hull, squared: for the hull's size, and for how far the start is from it. */
#define RAY_TOUCH2 1e-20
#define RAY_ROUNDING2 1e-30

typedef struct vec {
  double x, y, z;
} vec;

/* Points of a set, newest last, and the point of their hull that is closest to the origin. */
typedef struct simplex {
  vec at[4];
  uint32_t name[4]; /* which points they are */
  uint32_t count;
  vec closest;
  double distance2;
} simplex;

static inline vec add(vec a, vec b) {
  return (vec){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline vec subtract(vec a, vec b) {
  return (vec){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline vec times(vec a, double s) {
  return (vec){a.x * s, a.y * s, a.z * s};
}
static inline double dot(vec a, vec b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline vec cross(vec a, vec b) {
  return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline vec load(const double p[3]) {
  return (vec){p[0], p[1], p[2]};
}

static inline double larger(double a, double b) {
  return a > b ? a : b;
}

/* The first of the points that lie farthest along a direction. */
static uint32_t farthest(const convex_hull* hull, vec along) {
  double values[CONVEX_MAX_POINTS];
  const float *x = hull->x, *y = hull->y, *z = hull->z;
  const uint32_t count = hull->count;
  for (uint32_t i = 0; i < count; ++i) values[i] = (double)x[i] * along.x + (double)y[i] * along.y + (double)z[i] * along.z;
  uint32_t best = 0;
  double most = -(double)INFINITY;
  for (uint32_t i = 0; i < count; ++i) {
    best = values[i] > most ? i : best;
    most = values[i] > most ? values[i] : most;
  }
  return best;
}

static inline vec point_of(const convex_hull* hull, uint32_t i) {
  return (vec){(double)hull->x[i] * hull->scale, (double)hull->y[i] * hull->scale, (double)hull->z[i] * hull->scale};
}

/* --- closest points of simplices -------------------------------------------------------------------------------------------- */

/* Takes a candidate for the closest point: part is a mask of vertices. The first of equals stays. */
static inline void offer(vec p, uint32_t part, vec* best, double* distance2, uint32_t* best_part) {
  double d = dot(p, p);
  if (d < *distance2) {
    *best = p;
    *distance2 = d;
    *best_part = part;
  }
}

/* The inside of the edge from the newest vertex n to i. */
static void offer_edge(const simplex* s, uint32_t n, uint32_t i, vec* best, double* distance2, uint32_t* part) {
  vec a = s->at[n], d = subtract(s->at[i], a);
  double length2 = dot(d, d), along = -dot(a, d);
  if (!(along > 0 && length2 > 0)) return; /* the newest vertex is nearer */
  if (along >= length2) {
    offer(s->at[i], 1u << i, best, distance2, part);
  } else {
    offer(add(a, times(d, along / length2)), 1u << n | 1u << i, best, distance2, part);
  }
}

/* The inside of the triangle of n, i and j. */
static void offer_triangle(const simplex* s, uint32_t n, uint32_t i, uint32_t j, vec* best, double* distance2, uint32_t* part) {
  vec a = s->at[n], b = s->at[i], c = s->at[j];
  vec ab = subtract(b, a), ac = subtract(c, a), normal = cross(ab, ac);
  double area2 = dot(normal, normal);
  if (!(area2 > FLAT2 * dot(ab, ab) * dot(ac, ac))) return;
  /* The origin's shadow is inside where it lies on the inner side of all three edges. */
  if (dot(cross(a, b), normal) > 0 && dot(cross(b, c), normal) > 0 && dot(cross(c, a), normal) > 0)
    offer(times(normal, dot(a, normal) / area2), 1u << n | 1u << i | 1u << j, best, distance2, part);
}

/* Whether the origin lies in the tetrahedron, its border included. */
static bool holds_origin(const simplex* s) {
  static const uint8_t faces[4][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}}; /* the last is opposite */
  for (int f = 0; f < 4; ++f) {
    vec a = s->at[faces[f][0]], normal = cross(subtract(s->at[faces[f][1]], a), subtract(s->at[faces[f][2]], a));
    vec up = subtract(s->at[faces[f][3]], a);
    double origin = -dot(normal, a), other = dot(normal, up);
    if (!(other * other > FLAT2 * dot(normal, normal) * dot(up, up))) return false;
    if (other > 0 ? origin < 0 : origin > 0) return false;
  }
  return true;
}

/* Finds the closest point and keeps the vertices that it needs. Looks at parts that have one of the vertices from `first` on: where
 * the closest point of the others is known, a new one is in every part that is closer. Returns false where the origin is inside. */
static bool reduce(simplex* s, uint32_t first) {
  const uint32_t count = s->count;
  uint32_t part = 1u << (count - 1), kept = 0;
  vec best = s->at[count - 1];
  double distance2 = dot(best, best);
  for (uint32_t n = count; n-- > first;) {
    offer(s->at[n], 1u << n, &best, &distance2, &part);
    for (uint32_t i = 0; i < n; ++i) offer_edge(s, n, i, &best, &distance2, &part);
    for (uint32_t i = 0; i < n; ++i)
      for (uint32_t j = i + 1; j < n; ++j) offer_triangle(s, n, i, j, &best, &distance2, &part);
  }
  if (count == 4 && holds_origin(s)) return false;
  for (uint32_t i = 0; i < count; ++i)
    if (part >> i & 1) {
      s->at[kept] = s->at[i];
      s->name[kept++] = s->name[i];
    }
  s->count = kept;
  s->closest = best;
  s->distance2 = distance2;
  return true;
}

static bool extend(simplex* s, vec point, uint32_t name) {
  s->at[s->count] = point;
  s->name[s->count++] = name;
  return reduce(s, s->count - 1);
}

static bool has(const simplex* s, uint32_t name) {
  for (uint32_t i = 0; i < s->count; ++i)
    if (s->name[i] == name) return true;
  return false;
}

/* --- two hulls -------------------------------------------------------------------------------------------------------------- */

typedef struct pair {
  const convex_hull *a, *b;
  vec apart; /* a.at - b.at */
  double size2;
} pair;

static pair make_pair(const convex_hull* a, const convex_hull* b) {
  return (pair){a, b, subtract(load(a->at), load(b->at)), 0};
}

/* The point of a - b that lies farthest against a direction. */
static vec farthest_against(pair* p, vec v, uint32_t* name) {
  uint32_t i = farthest(p->a, times(v, -1)), j = farthest(p->b, v);
  *name = i * CONVEX_MAX_POINTS + j;
  vec w = add(subtract(point_of(p->a, i), point_of(p->b, j)), p->apart);
  p->size2 = larger(p->size2, dot(w, w));
  return w;
}

/* The distance of the points' hulls, squared; 0 where they meet. `enough` >= 0: only whether the distance is more than this is
 * asked, and any number on the right side of it may come back. */
static double points_distance2(pair* p, double enough) {
  const bool compares = enough >= 0;
  const double enough2 = compares ? enough * enough : 0;
  uint32_t name;
  vec v = p->apart;
  if (!(dot(v, v) > 0)) v = subtract(point_of(p->a, 0), point_of(p->b, 0));
  simplex s = {.count = 0};
  vec w = farthest_against(p, v, &name);
  extend(&s, w, name);
  double distance2 = s.distance2, touch = 0;
  for (int step = 0; step < MAX_STEPS; ++step) {
    w = farthest_against(p, s.closest, &name);
    touch = p->size2 * (CONVEX_TOUCH * CONVEX_TOUCH);
    if (distance2 <= touch || (compares && distance2 <= enough2)) break;
    double along = dot(s.closest, w); /* times 1 / |closest|: all of a - b is at least this far away */
    if (compares && along > 0 && along * along > (enough2 + 4 * touch) * distance2) return along * along / distance2;
    if (has(&s, name) || distance2 - along <= PROGRESS * distance2) break;
    if (!extend(&s, w, name)) return 0;
    if (!(s.distance2 < distance2)) break;
    distance2 = s.distance2;
  }
  return distance2 <= touch ? 0 : distance2;
}

bool scree_rt_convex_meet(const convex_hull* a, const convex_hull* b) {
  pair p = make_pair(a, b);
  double grown = a->radius + b->radius;
  return points_distance2(&p, grown) <= grown * grown;
}

double scree_rt_convex_distance(const convex_hull* a, const convex_hull* b) {
  pair p = make_pair(a, b);
  double distance = sqrt(points_distance2(&p, -1)) - (a->radius + b->radius);
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
  const double touch = size2 * RAY_TOUCH2 + dot(origin, origin) * RAY_ROUNDING2;
  for (int step = 0; step < MAX_STEPS && s.distance2 > touch; ++step) {
    const uint32_t name = farthest(hull, s.closest);
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
