/* Closest points of simplices and of two hulls, as static functions: included by convex.c and convex_avx2.c and compiled for each
 * target. Every operation is the IEEE one of the scalar language, and the largest of some numbers does not depend on the order in
 * which they are looked at: all targets give the same bits.
 * Based on: Gilbert, Johnson, Keerthi, A Fast Procedure for Computing the Distance between Complex Objects in Three-Dimensional
 * Space, 1988. Where we differ: the closest point of a simplex is the best of its parts that hold the newest vertex, each judged by
 * itself, so that flat simplices need no special case; on a triangle it is taken along the triangle's normal, whose direction stays
 * right however near the origin is. */
#ifndef SCREE_CONVEX_KERNEL_H
#define SCREE_CONVEX_KERNEL_H

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "convex.h"
#include "simd.h"

/* Distances stop getting smaller after a handful of steps; the bound only keeps rounding from walking in a circle. */
enum { MAX_STEPS = 64, MOST_PORTALS = 10 };

#define PROGRESS 1e-12 /* a step that brings less of the squared distance than this is the last */
#define FLAT2 1e-16    /* triangles and tetrahedra flatter than the root of this, for their size, are left to their borders */

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

static inline double along_point(const convex_hull* hull, uint32_t i, vec along) {
  return (double)hull->x[i] * along.x + (double)hull->y[i] * along.y + (double)hull->z[i] * along.z;
}

/* The first of the points named by a mask that lie farthest along a direction. */
static uint32_t farthest_of(const convex_hull* hull, vec along, uint64_t names) {
  uint32_t best = (uint32_t)__builtin_ctzll(names);
  double most = -(double)INFINITY;
  for (; names != 0; names &= names - 1) {
    const uint32_t i = (uint32_t)__builtin_ctzll(names);
    const double value = along_point(hull, i, along);
    best = value > most ? i : best;
    most = value > most ? value : most;
  }
  return best;
}

/* The first of the points that lie farthest along a direction. `size`: no coordinate is larger. Floats tell which points can be,
 * doubles which is; so the answer does not depend on how the floats are added up. */
static uint32_t farthest(const convex_hull* hull, vec along, float size) {
  const uint32_t count = hull->count;
  const double bound = (double)size * (fabs(along.x) + fabs(along.y) + fabs(along.z));
  if (count < SIMD_WIDTH || !(bound > 1e-25 && bound < 1e30)) return farthest_of(hull, along, UINT64_MAX >> (64 - count));
  const vfloat ax = v_set((float)along.x), ay = v_set((float)along.y), az = v_set((float)along.z);
  const float *x = hull->x, *y = hull->y, *z = hull->z;
  float values[CONVEX_MAX_POINTS];
  vfloat most = v_set(-INFINITY);
  for (uint32_t i = 0; i < count; i += SIMD_WIDTH) {
    const uint32_t k = i + SIMD_WIDTH <= count ? i : count - SIMD_WIDTH; /* the last ones may be looked at twice */
    const vfloat v = v_load(x + k) * ax + v_load(y + k) * ay + v_load(z + k) * az;
    v_store(values + k, v);
    most = v_max(most, v);
  }
  const vfloat enough = v_set(v_most(most) - (float)(bound * 0x1p-20)); /* six roundings of 2^-24 on either side, and more */
  uint64_t names = 0;
  for (uint32_t i = 0; i < count; i += SIMD_WIDTH) {
    const uint32_t k = i + SIMD_WIDTH <= count ? i : count - SIMD_WIDTH;
    names |= (uint64_t)v_bits(v_load(values + k) >= enough) << k;
  }
  if ((names & (names - 1)) == 0 && names != 0) return (uint32_t)__builtin_ctzll(names);
  return farthest_of(hull, along, names != 0 ? names : UINT64_MAX >> (64 - count));
}

#define ABOUT 0x1p-19 /* times the size of a hull, and of the direction: the error of farthest_about */

/* A point that lies about as far along a direction as any: as floats see it. */
static uint32_t farthest_about(const convex_hull* hull, vec along, float size) {
  const uint32_t count = hull->count;
  const double bound = (double)size * (fabs(along.x) + fabs(along.y) + fabs(along.z));
  if (count < SIMD_WIDTH || !(bound > 1e-25 && bound < 1e30)) return farthest_of(hull, along, UINT64_MAX >> (64 - count));
  const vfloat ax = v_set((float)along.x), ay = v_set((float)along.y), az = v_set((float)along.z);
  const float *x = hull->x, *y = hull->y, *z = hull->z;
  vfloat most = v_set(-INFINITY);
  vint first = v_set_int(0); /* of the eight or four points that each lane's best is of */
  for (uint32_t i = 0; i < count; i += SIMD_WIDTH) {
    const uint32_t k = i + SIMD_WIDTH <= count ? i : count - SIMD_WIDTH; /* the last ones may be looked at twice */
    const vfloat v = v_load(x + k) * ax + v_load(y + k) * ay + v_load(z + k) * az;
    const vint better = v > most;
    most = v_max(v, most);
    first = v_select_int(better, v_set_int((int32_t)k), first);
  }
  const uint32_t lane = (uint32_t)__builtin_ctz(v_bits(most >= v_set(v_most(most))));
  int32_t firsts[SIMD_WIDTH];
  memcpy(firsts, &first, sizeof firsts);
  return (uint32_t)firsts[lane] + lane;
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

static inline void find_range(const float* values, uint32_t count, float* low, float* high) {
  if (count < SIMD_WIDTH) {
    *low = *high = values[0];
    for (uint32_t i = 1; i < count; ++i) {
      *low = values[i] < *low ? values[i] : *low;
      *high = values[i] > *high ? values[i] : *high;
    }
    return;
  }
  vfloat least = v_load(values + count - SIMD_WIDTH), most = least; /* some of them are looked at twice */
  for (uint32_t i = 0; i + SIMD_WIDTH < count; i += SIMD_WIDTH) {
    least = v_min(least, v_load(values + i));
    most = v_max(most, v_load(values + i));
  }
  *low = -v_most(-least);
  *high = v_most(most);
}

enum { MIDDLE_POINTS = 4 }; /* so many of a hull's points have it in their middle */

static convex_measure measure_hull(const convex_hull* hull) {
  const float* const values[3] = {hull->x, hull->y, hull->z};
  convex_measure m = {.size = 0};
  for (int a = 0; a < 3; ++a) {
    find_range(values[a], hull->count, &m.low[a], &m.high[a]);
    const float most = -m.low[a] > m.high[a] ? -m.low[a] : m.high[a];
    m.size = most > m.size ? most : m.size;
  }
  for (int a = 0; a < 3; ++a) {
    for (uint32_t k = 0; k < MIDDLE_POINTS; ++k) m.middle[a] += (double)values[a][k < hull->count ? k : 0];
    m.middle[a] *= 1.0 / MIDDLE_POINTS;
  }
  return m;
}

typedef struct pair {
  const convex_hull *a, *b;
  const convex_measure *of_a, *of_b;
  vec apart; /* a.at - b.at */
  double size2;
} pair;

static pair make_pair(const convex_hull* a, const convex_measure* of_a, const convex_hull* b, const convex_measure* of_b) {
  return (pair){a, b, of_a, of_b, subtract(load(a->at), load(b->at)), 0};
}

/* How far the boxes are apart along the axis where they are farthest; negative where they meet. `size`: no point of one is farther
 * from one of the other along any axis. `between`: from the middle of b's to that of a's, twice as long. */
static double boxes_apart(const pair* p, double* size, vec* between) {
  const double apart[3] = {p->apart.x, p->apart.y, p->apart.z}, sa = p->a->scale, sb = p->b->scale;
  double most = -(double)INFINITY, middle[3];
  *size = 0;
  for (int i = 0; i < 3; ++i) {
    const double al = (double)p->of_a->low[i] * sa, ah = (double)p->of_a->high[i] * sa;
    const double bl = (double)p->of_b->low[i] * sb, bh = (double)p->of_b->high[i] * sb;
    most = larger(most, larger(apart[i] + (al - bh), (bl - ah) - apart[i]));
    *size = larger(*size, fabs(apart[i]) + larger(ah - bl, bh - al));
    middle[i] = 2 * apart[i] + ((al + ah) - (bl + bh));
  }
  *between = load(middle);
  return most;
}

/* The point of a - b that lies farthest against a direction. */
static vec farthest_against(pair* p, vec v, uint32_t* name) {
  uint32_t i = farthest(p->a, times(v, -1), p->of_a->size), j = farthest(p->b, v, p->of_b->size);
  *name = i * CONVEX_MAX_POINTS + j;
  vec w = add(subtract(point_of(p->a, i), point_of(p->b, j)), p->apart);
  p->size2 = larger(p->size2, dot(w, w));
  return w;
}

/* One that lies about as far. */
static vec about_against(const pair* p, vec v) {
  const uint32_t i = farthest_about(p->a, times(v, -1), p->of_a->size), j = farthest_about(p->b, v, p->of_b->size);
  return add(subtract(point_of(p->a, i), point_of(p->b, j)), p->apart);
}

/* The distance of the points' hulls, squared; 0 where they meet. `enough` >= 0: only whether the distance is more than this is
 * asked, and any number on the right side of it may come back. */
static double points_distance2(pair* p, double enough, vec v) {
  const bool compares = enough >= 0;
  const double enough2 = compares ? enough * enough : 0;
  uint32_t name;
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

/* --- whether they meet: what is plain comes first ------------------------------------------------------------------------------
 */

typedef enum verdict { OPEN, MEETING, APART } verdict;

/* Whether all of a - b lies farther than `beyond` along v, judged by w, the point of it that lies farthest against v. */
static inline bool lies_beyond(vec v, vec w, double beyond) {
  const double along = dot(v, w);
  return along > 0 && along * along > beyond * beyond * dot(v, v);
}

/* Looks for a tetrahedron in a - b that holds the origin: a portal of three points of the border, which the ray from a point inside
 * through the origin passes, is moved outwards until the origin lies on its inner side, or until nothing more lies beyond. Says
 * only what holds by a margin of rounding, so that it does not matter who is a and who is b; the rest is left to the distance.
 * Based on: Snethen, XenoCollide: Complex Collision Made Simple, Game Programming Gems 7, 2008. */
static verdict look_for_portal(const pair* p, double beyond) {
  const convex_measure *ma = p->of_a, *mb = p->of_b;
  const vec inside = add(subtract(times(load(ma->middle), p->a->scale), times(load(mb->middle), p->b->scale)), p->apart);
  vec v1 = about_against(p, inside);
  if (lies_beyond(inside, v1, beyond)) return APART;
  vec n = cross(v1, inside), v2 = about_against(p, n), v3 = v1;
  if (lies_beyond(n, v2, beyond)) return APART;
  n = cross(subtract(v1, inside), subtract(v2, inside));
  if (dot(n, inside) > 0) { /* the origin is on the other side */
    const vec swap = v1;
    v1 = v2;
    v2 = swap;
    n = times(n, -1);
  }
  bool found = false;
  for (int step = 0; step < MOST_PORTALS; ++step) {
    if (found) {
      n = cross(subtract(v2, v1), subtract(v3, v1));
      if (dot(n, v1) >= 0) {
        const simplex s = {.at = {inside, v1, v2, v3}, .count = 4};
        return holds_origin(&s) ? MEETING : OPEN;
      }
    }
    const vec v4 = about_against(p, times(n, -1));
    if (dot(n, v4) <= 0) return lies_beyond(times(n, -1), v4, beyond) ? APART : OPEN;
    if (found) { /* through which of the three new portals does the ray pass? */
      const vec side = cross(v4, inside);
      if (dot(v1, side) > 0) {
        *(dot(v2, side) > 0 ? &v1 : &v3) = v4;
      } else {
        *(dot(v3, side) > 0 ? &v2 : &v1) = v4;
      }
    } else if (dot(cross(v1, v4), inside) < 0) {
      v2 = v4;
      n = cross(subtract(v1, inside), subtract(v4, inside));
    } else if (dot(cross(v4, v2), inside) < 0) {
      v1 = v4;
      n = cross(subtract(v4, inside), subtract(v2, inside));
    } else {
      v3 = v4;
      found = true;
    }
  }
  return OPEN;
}

static inline bool points_meet(const convex_hull* a, const convex_measure* of_a, const convex_hull* b, const convex_measure* of_b) {
  pair p = make_pair(a, of_a, b, of_b);
  const double grown = a->radius + b->radius;
  double size;
  vec between;
  const double apart = boxes_apart(&p, &size, &between), beyond = grown + size * 1e-6;
  if (apart > beyond) return false;
  const double about = ((double)of_a->size * a->scale + (double)of_b->size * b->scale) * ABOUT;
  const verdict plain = look_for_portal(&p, beyond + about);
  if (plain != OPEN) return plain == MEETING;
  return points_distance2(&p, grown, between) <= grown * grown;
}

#endif
