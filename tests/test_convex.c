/* Convex hulls against plain twins: every simplex of the differences of two small hulls, in integers; every face of a hull. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "convex.h"
#include "rounds.h"
#include "synthetic_field.h"

typedef struct points {
  int32_t at[CONVEX_MAX_POINTS][3];
  float x[CONVEX_MAX_POINTS], y[CONVEX_MAX_POINTS], z[CONVEX_MAX_POINTS];
  uint32_t count;
} points;

static void add_point(points* p, int32_t x, int32_t y, int32_t z) {
  const uint32_t i = p->count++;
  p->at[i][0] = x;
  p->at[i][1] = y;
  p->at[i][2] = z;
  p->x[i] = (float)x;
  p->y[i] = (float)y;
  p->z[i] = (float)z;
}

static convex_hull hull_of(const points* p) {
  return (convex_hull){p->x, p->y, p->z, p->count, 1, {0, 0, 0}, 0};
}

/* How a random hull spreads: in space, in a plane, along a line, one point; or the corners of a box. */
typedef enum spread { SPACE, PLANE, LINE, POINT, BOX, SPREADS } spread;

/* Half of them solid. */
static spread random_spread(random_stream* r) {
  return random_below(r, 2) ? SPACE : (spread)random_below(r, SPREADS);
}

static points random_points(random_stream* r, spread kind, uint32_t most, int32_t reach, int32_t shift) {
  points p = {.count = 0};
  int32_t u[3], v[3], o[3];
  for (int a = 0; a < 3; ++a) {
    o[a] = (int32_t)random_below(r, (uint32_t)(2 * shift + 1)) - shift;
    u[a] = (int32_t)random_below(r, 5) - 2;
    v[a] = (int32_t)random_below(r, 5) - 2;
  }
  uint32_t count = kind == POINT ? 1 : 1 + random_below(r, most);
  if (kind == BOX) count = 8;
  for (uint32_t i = 0; i < count; ++i) {
    int32_t w[3];
    for (int a = 0; a < 3; ++a) w[a] = (int32_t)random_below(r, (uint32_t)(2 * reach + 1)) - reach;
    if (kind == SPACE || kind == POINT) add_point(&p, o[0] + w[0], o[1] + w[1], o[2] + w[2]);
    if (kind == BOX) add_point(&p, o[0] + (i & 1 ? reach : 0), o[1] + (i & 2 ? reach : 0), o[2] + (i & 4 ? reach : 0));
    if (kind == PLANE)
      add_point(&p, o[0] + w[0] * u[0] + w[1] * v[0], o[1] + w[0] * u[1] + w[1] * v[1], o[2] + w[0] * u[2] + w[1] * v[2]);
    if (kind == LINE) add_point(&p, o[0] + w[0] * u[0], o[1] + w[0] * u[1], o[2] + w[0] * u[2]);
  }
  return p;
}

/* --- the twin of meeting: in integers -------------------------------------------------------------------------------------- */

typedef struct ivec {
  int64_t x, y, z;
} ivec;

static ivec i_minus(ivec a, ivec b) {
  return (ivec){a.x - b.x, a.y - b.y, a.z - b.z};
}
static ivec i_cross(ivec a, ivec b) {
  return (ivec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static int64_t i_dot(ivec a, ivec b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
static bool i_zero(ivec a) {
  return a.x == 0 && a.y == 0 && a.z == 0;
}

static bool on_edge(ivec a, ivec b) {
  return i_zero(i_cross(a, b)) && i_dot(a, b) <= 0;
}

static bool on_triangle(ivec a, ivec b, ivec c) {
  ivec n = i_cross(i_minus(b, a), i_minus(c, a));
  if (i_zero(n) || i_dot(n, a) != 0) return false; /* flat ones are covered by their edges */
  return i_dot(i_cross(a, b), n) >= 0 && i_dot(i_cross(b, c), n) >= 0 && i_dot(i_cross(c, a), n) >= 0;
}

static bool in_tetrahedron(ivec a, ivec b, ivec c, ivec d) {
  int64_t volume = i_dot(i_cross(i_minus(b, a), i_minus(c, a)), i_minus(d, a));
  if (volume == 0) return false;
  int64_t sign = volume > 0 ? 1 : -1;
  /* The origin in the place of each vertex in turn. */
  int64_t va = i_dot(i_cross(b, c), d), vb = -i_dot(i_cross(a, c), d), vc = i_dot(i_cross(a, b), d), vd = -i_dot(i_cross(a, b), c);
  return va * sign >= 0 && vb * sign >= 0 && vc * sign >= 0 && vd * sign >= 0 && va + vb + vc + vd == volume;
}

static uint32_t differences(const points* a, const points* b, ivec out[CONVEX_MAX_POINTS]) {
  uint32_t count = 0;
  for (uint32_t i = 0; i < a->count; ++i)
    for (uint32_t j = 0; j < b->count; ++j)
      out[count++] = (ivec){a->at[i][0] - b->at[j][0], a->at[i][1] - b->at[j][1], a->at[i][2] - b->at[j][2]};
  return count;
}

/* A point lies in a hull if and only if it lies in a simplex of at most four of its points (Caratheodory, 1907). */
static bool twin_meet(const points* a, const points* b) {
  ivec d[CONVEX_MAX_POINTS];
  const uint32_t n = differences(a, b, d);
  for (uint32_t i = 0; i < n; ++i) {
    if (i_zero(d[i])) return true;
    for (uint32_t j = i + 1; j < n; ++j) {
      if (on_edge(d[i], d[j])) return true;
      for (uint32_t k = j + 1; k < n; ++k) {
        if (on_triangle(d[i], d[j], d[k])) return true;
        for (uint32_t l = k + 1; l < n; ++l)
          if (in_tetrahedron(d[i], d[j], d[k], d[l])) return true;
      }
    }
  }
  return false;
}

/* --- the twin of the distance: the nearest of all vertices, edges and triangles --------------------------------------------- */

static double to_edge2(ivec a, ivec b) {
  ivec d = i_minus(b, a), n = i_cross(a, b);
  int64_t along = -i_dot(a, d), length2 = i_dot(d, d);
  if (along <= 0 || along >= length2) return (double)INFINITY;
  return (double)i_dot(n, n) / (double)length2;
}

static double to_triangle2(ivec a, ivec b, ivec c) {
  ivec n = i_cross(i_minus(b, a), i_minus(c, a));
  if (i_zero(n)) return (double)INFINITY;
  if (i_dot(i_cross(a, b), n) < 0 || i_dot(i_cross(b, c), n) < 0 || i_dot(i_cross(c, a), n) < 0) return (double)INFINITY;
  double height = (double)i_dot(n, a);
  return height * height / (double)i_dot(n, n);
}

static double twin_distance(const points* a, const points* b) {
  if (twin_meet(a, b)) return 0;
  ivec d[CONVEX_MAX_POINTS];
  const uint32_t n = differences(a, b, d);
  double best = (double)INFINITY;
  for (uint32_t i = 0; i < n; ++i) {
    best = fmin(best, (double)i_dot(d[i], d[i]));
    for (uint32_t j = i + 1; j < n; ++j) {
      best = fmin(best, to_edge2(d[i], d[j]));
      for (uint32_t k = j + 1; k < n; ++k) best = fmin(best, to_triangle2(d[i], d[j], d[k]));
    }
  }
  return sqrt(best);
}

/* --- the twin of meeting for solid hulls of many points: all separating axes, in integers ---------------------------------------
 */

typedef struct axes {
  ivec faces[4 * CONVEX_MAX_POINTS], edges[8 * CONVEX_MAX_POINTS];
  uint32_t face_count, edge_count;
} axes;

static ivec i_at(const points* p, uint32_t i) {
  return (ivec){p->at[i][0], p->at[i][1], p->at[i][2]};
}

/* Normals and edges of all triangles that have every point on one side. Points of which four lie in a face give triangles twice
 * over, which is no harm, as long as they fit. */
static bool find_axes(const points* p, axes* out) {
  out->face_count = out->edge_count = 0;
  for (uint32_t i = 0; i < p->count; ++i)
    for (uint32_t j = i + 1; j < p->count; ++j)
      for (uint32_t k = j + 1; k < p->count; ++k) {
        const ivec a = i_at(p, i), b = i_at(p, j), c = i_at(p, k), n = i_cross(i_minus(b, a), i_minus(c, a));
        bool above = false, below = false;
        for (uint32_t l = 0; l < p->count && !(above && below); ++l) {
          const int64_t height = i_dot(n, i_minus(i_at(p, l), a));
          above = above || height > 0;
          below = below || height < 0;
        }
        if (i_zero(n) || (above && below)) continue;
        if (out->face_count == 4 * CONVEX_MAX_POINTS || out->edge_count + 3 > 8 * CONVEX_MAX_POINTS) return false;
        out->faces[out->face_count++] = n;
        out->edges[out->edge_count++] = i_minus(b, a);
        out->edges[out->edge_count++] = i_minus(c, a);
        out->edges[out->edge_count++] = i_minus(c, b);
      }
  return true;
}

static bool separates(ivec n, const points* p, const points* q) {
  int64_t p_low = INT64_MAX, p_high = INT64_MIN, q_low = INT64_MAX, q_high = INT64_MIN;
  for (uint32_t i = 0; i < p->count; ++i) {
    const int64_t d = i_dot(n, i_at(p, i));
    p_low = d < p_low ? d : p_low;
    p_high = d > p_high ? d : p_high;
  }
  for (uint32_t i = 0; i < q->count; ++i) {
    const int64_t d = i_dot(n, i_at(q, i));
    q_low = d < q_low ? d : q_low;
    q_high = d > q_high ? d : q_high;
  }
  return p_low > q_high || q_low > p_high;
}

static bool axes_meet(const points* p, const points* q, const axes* of_p, const axes* of_q) {
  for (uint32_t i = 0; i < of_p->face_count; ++i)
    if (separates(of_p->faces[i], p, q)) return false;
  for (uint32_t i = 0; i < of_q->face_count; ++i)
    if (separates(of_q->faces[i], p, q)) return false;
  for (uint32_t i = 0; i < of_p->edge_count; ++i)
    for (uint32_t j = 0; j < of_q->edge_count; ++j)
      if (separates(i_cross(of_p->edges[i], of_q->edges[j]), p, q)) return false;
  return true;
}

/* Points about on a ball, on the lattice that hulls of rocks have. */
static points random_rock(random_stream* r, uint32_t count) {
  points p = {.count = 0};
  while (p.count < count) {
    double v[3], length2 = 0, stretch[3] = {60, 45, 50};
    for (int a = 0; a < 3; ++a) {
      v[a] = random_in(r, -1, 1);
      length2 += v[a] * v[a];
    }
    for (int a = 0; a < 3; ++a) v[a] *= stretch[a] / sqrt(length2 + 1e-9);
    add_point(&p, (int32_t)v[0], (int32_t)v[1], (int32_t)v[2]);
  }
  return p;
}

static void hulls_of_rocks_meet_when_no_axis_separates_them(void** state) {
  (void)state;
  random_stream r = {7};
  int counts[2] = {0, 0}, close = 0;
  static axes of_p, of_q;
  for (int i = 0; i < 150; ++i) {
    points p = random_rock(&r, 8 + random_below(&r, 17)), q = random_rock(&r, 8 + random_below(&r, 17));
    if (!find_axes(&p, &of_p) || !find_axes(&q, &of_q)) continue;
    const convex_hull a = hull_of(&p);
    double along[3], length2 = 0;
    for (int k = 0; k < 3; ++k) {
      along[k] = random_in(&r, -1, 1);
      length2 += along[k] * along[k];
    }
    /* Closer and closer, a step at a time, so that the answer changes between two neighbours on the lattice. */
    int32_t near_step = 0, far_step = 140;
    while (far_step - near_step > 1) {
      const int32_t step = (near_step + far_step) / 2;
      points moved = {.count = 0};
      for (uint32_t k = 0; k < q.count; ++k)
        add_point(&moved, q.at[k][0] + (int32_t)(along[0] / sqrt(length2) * step),
                  q.at[k][1] + (int32_t)(along[1] / sqrt(length2) * step), q.at[k][2] + (int32_t)(along[2] / sqrt(length2) * step));
      const convex_hull b = hull_of(&moved);
      const bool expected = axes_meet(&p, &moved, &of_p, &of_q);
      assert_int_equal(scree_rt_convex_meet(&a, &b), expected);
      assert_int_equal(scree_rt_convex_meet(&b, &a), expected);
      ++counts[expected];
      close += !expected && scree_rt_convex_distance(&a, &b) < 1;
      if (expected) {
        near_step = step;
      } else {
        far_step = step;
      }
    }
  }
  if (counts[0] < 200 || counts[1] < 200 || close < 30) fail_msg("%d apart, %d meet, %d close", counts[0], counts[1], close);
}

/* --- tests ------------------------------------------------------------------------------------------------------------------ */

static void check_pair(const points* a, const points* b, int counts[2]) {
  convex_hull p = hull_of(a), q = hull_of(b);
  const bool expected = twin_meet(a, b);
  ++counts[expected];
  assert_int_equal(scree_rt_convex_meet(&p, &q), expected);
  assert_int_equal(scree_rt_convex_meet(&q, &p), expected);
  const double distance = scree_rt_convex_distance(&p, &q), twin = twin_distance(a, b);
  assert_true(scree_rt_convex_distance(&q, &p) == distance);
  if (!(fabs(distance - twin) <= 1e-7)) fail_msg("distance %.17g, expected %.17g", distance, twin);
}

static void small_hulls_meet_when_they_do_in_integers(void** state) {
  (void)state;
  random_stream r = {1};
  int counts[2] = {0, 0};
  for (int i = 0; i < ROUNDS(3000, 8); ++i) {
    const int32_t reach = 1 + (int32_t)random_below(&r, 8);
    points a = random_points(&r, random_spread(&r), 7, reach, 3);
    points b = random_points(&r, random_spread(&r), 7, reach, 3);
    check_pair(&a, &b, counts);
  }
  if (counts[0] < ROUNDS(400, 8) || counts[1] < ROUNDS(400, 8)) fail_msg("%d apart, %d meet", counts[0], counts[1]);
}

/* On a tiny grid almost every pair touches in some way or is nested, and most simplices are flat. */
static void touching_and_flat_hulls_meet(void** state) {
  (void)state;
  random_stream r = {2};
  int counts[2] = {0, 0};
  for (int i = 0; i < ROUNDS(5000, 8); ++i) {
    points a = random_points(&r, random_spread(&r), 6, 1, 1);
    points b = random_points(&r, random_spread(&r), 6, 1, 1);
    check_pair(&a, &b, counts);
  }
  if (counts[0] < ROUNDS(400, 8) || counts[1] < ROUNDS(400, 8)) fail_msg("%d apart, %d meet", counts[0], counts[1]);
}

static void boxes_meet_face_edge_and_corner_and_not_beyond(void** state) {
  (void)state;
  for (int32_t dz = -3; dz <= 3; ++dz)
    for (int32_t dy = -3; dy <= 3; ++dy)
      for (int32_t dx = -3; dx <= 3; ++dx) {
        points a = {.count = 0}, b = {.count = 0};
        for (int32_t c = 0; c < 8; ++c) {
          add_point(&a, 2 * (c & 1), 2 * (c >> 1 & 1), 2 * (c >> 2));
          add_point(&b, dx + 2 * (c & 1), dy + 2 * (c >> 1 & 1), dz + 2 * (c >> 2));
        }
        convex_hull p = hull_of(&a), q = hull_of(&b);
        bool touch = dx >= -2 && dx <= 2 && dy >= -2 && dy <= 2 && dz >= -2 && dz <= 2;
        assert_int_equal(scree_rt_convex_meet(&p, &q), touch);
        q.scale = 1 - 1e-4; /* shrunk towards its first corner */
        for (int a3 = 0; a3 < 3; ++a3) q.at[a3] = (a3 == 0 ? dx : a3 == 1 ? dy : dz) * (1 - q.scale);
        bool still = dx > -2 && dx <= 2 && dy > -2 && dy <= 2 && dz > -2 && dz <= 2;
        assert_int_equal(scree_rt_convex_meet(&p, &q), still);
        assert_int_equal(scree_rt_convex_meet(&q, &p), still);
      }
}

static void a_to_b_is_b_to_a_to_the_bit(void** state) {
  (void)state;
  random_stream r = {3};
  int meeting = 0;
  for (int i = 0; i < 20000; ++i) {
    float data[6][CONVEX_MAX_POINTS];
    uint32_t n = 1 + random_below(&r, CONVEX_MAX_POINTS), m = 1 + random_below(&r, CONVEX_MAX_POINTS);
    for (int k = 0; k < 6; ++k)
      for (int j = 0; j < CONVEX_MAX_POINTS; ++j) data[k][j] = (float)random_in(&r, -1, 1);
    convex_hull a = {data[0], data[1], data[2], n, random_in(&r, 0.1, 2), {0, 0, 0}, random_below(&r, 2) ? random_in(&r, 0, 1) : 0};
    convex_hull b = {data[3], data[4], data[5], m, random_in(&r, 0.1, 2), {0, 0, 0}, 0};
    for (int k = 0; k < 3; ++k) {
      a.at[k] = random_in(&r, -1, 1) * 2 + 1e7;
      b.at[k] = random_in(&r, -1, 1) * 2 + 1e7;
    }
    const bool meet = scree_rt_convex_meet(&a, &b);
    meeting += meet;
    assert_int_equal(meet, scree_rt_convex_meet(&b, &a));
    assert_true(scree_rt_convex_distance(&a, &b) == scree_rt_convex_distance(&b, &a));
    assert_int_equal(meet, scree_rt_convex_distance(&a, &b) == 0);
  }
  assert_true(meeting > 2000 && meeting < 18000);
}

static void radii_grow_hulls(void** state) {
  (void)state;
  random_stream r = {4};
  for (int i = 0; i < ROUNDS(3000, 8); ++i) {
    points a = random_points(&r, (spread)random_below(&r, SPREADS), 6, 3, 3);
    points b = random_points(&r, (spread)random_below(&r, SPREADS), 6, 3, 3);
    convex_hull p = hull_of(&a), q = hull_of(&b);
    const double gap = twin_distance(&a, &b), grown = gap * random_in(&r, 0, 2);
    p.radius = grown * 0.25;
    q.radius = grown * 0.75;
    if (fabs(grown - gap) < 1e-5) continue;
    assert_int_equal(scree_rt_convex_meet(&p, &q), gap <= grown);
    assert_int_equal(scree_rt_convex_meet(&q, &p), gap <= grown);
    const double rest = gap > grown ? gap - grown : 0;
    assert_true(fabs(scree_rt_convex_distance(&p, &q) - rest) < 1e-6);
  }
}

static void answers_do_not_depend_on_the_unit(void** state) {
  (void)state;
  random_stream r = {5};
  for (int i = 0; i < 3000; ++i) {
    points a = random_points(&r, SPACE, 12, 5, 4), b = random_points(&r, SPACE, 12, 5, 4);
    convex_hull p = hull_of(&a), q = hull_of(&b);
    const bool meet = scree_rt_convex_meet(&p, &q);
    const double distance = scree_rt_convex_distance(&p, &q);
    for (int e = -100; e <= 100; e += 50) {
      p.scale = q.scale = ldexp(1, e);
      assert_int_equal(scree_rt_convex_meet(&p, &q), meet);
      assert_true(scree_rt_convex_distance(&p, &q) == ldexp(distance, e));
    }
  }
}

/* The ray against every plane through three of the points that has all others on one side. Returns false on a miss; *doubt where
 * it passes an edge so closely that either answer will do. */
static bool twin_ray(const points* p, const double start[3], const double direction[3], double* t, bool* doubt) {
  double enter = -(double)INFINITY, leave = (double)INFINITY;
  for (uint32_t i = 0; i < p->count; ++i)
    for (uint32_t j = 0; j < p->count; ++j)
      for (uint32_t k = 0; k < p->count; ++k) {
        if (j == i || k == i || k == j) continue;
        ivec a = {p->at[i][0], p->at[i][1], p->at[i][2]}, b = {p->at[j][0], p->at[j][1], p->at[j][2]};
        ivec c = {p->at[k][0], p->at[k][1], p->at[k][2]};
        ivec n = i_cross(i_minus(b, a), i_minus(c, a));
        bool outer = !i_zero(n);
        for (uint32_t l = 0; l < p->count && outer; ++l)
          outer = i_dot(n, i_minus((ivec){p->at[l][0], p->at[l][1], p->at[l][2]}, a)) <= 0;
        if (!outer) continue;
        double scale = 1 / sqrt((double)i_dot(n, n)), nx = (double)n.x * scale, ny = (double)n.y * scale, nz = (double)n.z * scale;
        double height = nx * (start[0] - (double)a.x) + ny * (start[1] - (double)a.y) + nz * (start[2] - (double)a.z);
        double speed = nx * direction[0] + ny * direction[1] + nz * direction[2];
        if (fabs(height) < 1e-6) *doubt = true;
        if (fabs(speed) < 1e-9) {
          if (height > 0) enter = (double)INFINITY;
        } else if (speed < 0) {
          enter = fmax(enter, -height / speed);
        } else {
          leave = fmin(leave, -height / speed);
        }
      }
  if (fabs(leave - enter) < 1e-6) *doubt = true;
  if (fabs(leave) < 1e-6 || fabs(enter) < 1e-6) *doubt = true;
  *t = enter > 0 ? enter : 0;
  return enter <= leave && leave >= 0;
}

static void rays_hit_where_the_faces_say(void** state) {
  (void)state;
  random_stream r = {6};
  int hits = 0, inside = 0, misses = 0;
  for (int i = 0; i < 8000; ++i) {
    points p = random_points(&r, random_below(&r, 8) == 0 ? BOX : SPACE, 12, 6, 3);
    if (p.count < 5) continue;
    double start[3], direction[3], length2 = 0, far = random_below(&r, 4) == 0 ? 1000 : 1;
    for (int a = 0; a < 3; ++a) {
      start[a] = random_in(&r, -10, 10) * far;
      direction[a] = random_in(&r, -8, 8) - start[a];
      if (random_below(&r, 8) == 0 && a > 0) direction[a] = 0;
      length2 += direction[a] * direction[a];
    }
    for (int a = 0; a < 3; ++a) direction[a] /= sqrt(length2);
    ivec n = {0, 0, 0};
    for (uint32_t k = 2; k < p.count && i_zero(n); ++k) { /* flat hulls have no faces */
      ivec a = {p.at[0][0], p.at[0][1], p.at[0][2]}, b = {p.at[1][0], p.at[1][1], p.at[1][2]};
      n = i_cross(i_minus(b, a), i_minus((ivec){p.at[k][0], p.at[k][1], p.at[k][2]}, a));
    }
    bool solid = false;
    for (uint32_t k = 0; k < p.count; ++k)
      solid |= i_dot(n, (ivec){p.at[k][0] - p.at[0][0], p.at[k][1] - p.at[0][1], p.at[k][2] - p.at[0][2]}) != 0;
    if (!solid) continue;
    double expected, t = -1, normal[3];
    bool doubt = false, hit = twin_ray(&p, start, direction, &expected, &doubt);
    if (doubt) continue;
    convex_hull h = hull_of(&p);
    if (scree_rt_convex_ray(&h, start, direction, 1e6, &t, normal) != hit) fail_msg("ray %d: twin says %d", i, hit);
    misses += !hit;
    if (!hit) continue;
    ++hits;
    inside += expected == 0;
    if (!(fabs(t - expected) < 1e-7)) fail_msg("ray %d: at %.17g, expected %.17g", i, t, expected);
    if (expected == 0) {
      for (int a = 0; a < 3; ++a) assert_true(fabs(normal[a] + direction[a]) < 1e-15);
    } else {
      /* The normal's plane through the place of the hit has the hull behind it. */
      for (uint32_t k = 0; k < p.count; ++k) {
        double height = 0;
        for (int a = 0; a < 3; ++a) height += normal[a] * (p.at[k][a] - (start[a] + t * direction[a]));
        if (!(height < 1e-6)) fail_msg("ray %d: point %u is %g before the face", i, k, height);
      }
      assert_false(scree_rt_convex_ray(&h, start, direction, t * (1 - 1e-9), &t, normal));
    }
  }
  assert_true(hits > 1000 && misses > 500 && inside > 20);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(small_hulls_meet_when_they_do_in_integers),
      cmocka_unit_test(hulls_of_rocks_meet_when_no_axis_separates_them),
      cmocka_unit_test(touching_and_flat_hulls_meet),
      cmocka_unit_test(boxes_meet_face_edge_and_corner_and_not_beyond),
      cmocka_unit_test(a_to_b_is_b_to_a_to_the_bit),
      cmocka_unit_test(radii_grow_hulls),
      cmocka_unit_test(answers_do_not_depend_on_the_unit),
      cmocka_unit_test(rays_hit_where_the_faces_say),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
