/* The later shapes of supports against what they are: whether a point is inside is asked of plain formulas in double, and how far
 * the surface is, of rays into all directions. A distance is never larger than that, and about as large by the surface. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "must_create.h"
#include "query_kernel.h"
#include "random_support.h"
#include "rounds.h"

static double square(double x) {
  return x * x;
}
static double length(const double v[3]) {
  return sqrt(square(v[0]) + square(v[1]) + square(v[2]));
}

/* --- who is inside, in the shape's own space ------------------------------------------------------------------------------- */

static bool in_polygon(const scree_extrusion* e, double x, double z) {
  bool in = false; /* a ray along +z */
  for (uint32_t i = 0; i < e->point_count; ++i) {
    const float *a = e->points + 2 * i, *b = e->points + 2 * ((i + 1) % e->point_count);
    double ax = (double)a[0], bx = (double)b[0];
    if ((ax > x) == (bx > x)) continue;
    in ^= (double)a[1] + (x - ax) / (bx - ax) * ((double)b[1] - (double)a[1]) > z;
  }
  return in;
}

/* Centripetal Catmull-Rom by its tangents. */
static void spline(const scree_tube* t, uint32_t span, double u, double out[3], double* radius) {
  double p[4][3], gap[3];
  int64_t n = t->point_count;
  for (int64_t k = 0; k < 4; ++k)
    for (int64_t a = 0; a < 3; ++a) {
      int64_t i = (int64_t)span + k - 1;
      if (t->closed) i = (i + n) % n;
      if (i >= 0 && i < n)
        p[k][a] = (double)t->points[3 * i + a];
      else if (i < 0)
        p[k][a] = 2 * (double)t->points[a] - (double)t->points[3 + a];
      else
        p[k][a] = 2 * (double)t->points[3 * (n - 1) + a] - (double)t->points[3 * (n - 2) + a];
    }
  for (int k = 0; k < 3; ++k) {
    const double step[3] = {p[k + 1][0] - p[k][0], p[k + 1][1] - p[k][1], p[k + 1][2] - p[k][2]};
    gap[k] = pow(length(step), 0.5);
  }
  for (int a = 0; a < 3; ++a) {
    double in = (p[1][a] - p[0][a]) / gap[0] - (p[2][a] - p[0][a]) / (gap[0] + gap[1]) + (p[2][a] - p[1][a]) / gap[1];
    double on = (p[2][a] - p[1][a]) / gap[1] - (p[3][a] - p[1][a]) / (gap[1] + gap[2]) + (p[3][a] - p[2][a]) / gap[2];
    double m1 = in * gap[1], m2 = on * gap[1];
    out[a] =
        (2 * p[1][a] - 2 * p[2][a] + m1 + m2) * u * u * u + (-3 * p[1][a] + 3 * p[2][a] - 2 * m1 - m2) * u * u + m1 * u + p[1][a];
  }
  double ra = (double)t->radii[span], rb = (double)t->radii[(span + 1) % t->point_count];
  *radius = ra + u * (rb - ra);
}

/* Whether some ball or disc between two is closer than its radius: a quadratic in the way along, over 0..1. */
static bool swept(const double* q, const double* e, int axes, double ra, double rb) {
  double ee = 0, qe = 0, qq = 0;
  for (int a = 0; a < axes; ++a) {
    ee += e[a] * e[a];
    qe += q[a] * e[a];
    qq += q[a] * q[a];
  }
  double dr = rb - ra, A = ee - dr * dr, B = -2 * (qe + ra * dr), C = qq - ra * ra;
  if (C <= 0 || A + B + C <= 0) return true;
  if (A <= 0) return false;
  double t = -B / (2 * A);
  return t > 0 && t < 1 && A * t * t + B * t + C <= 0;
}

static bool in_tube(const scree_tube* t, const double p[3]) {
  uint32_t spans = t->closed ? t->point_count : t->point_count - 1, steps = t->subdivisions == 0 ? 8 : t->subdivisions;
  for (uint32_t i = 0; i < spans; ++i)
    for (uint32_t k = 0; k < steps; ++k) {
      double a[3], b[3], ra, rb;
      spline(t, i, (double)k / steps, a, &ra);
      spline(t, i, (double)(k + 1) / steps, b, &rb);
      const double q[3] = {p[0] - a[0], p[1] - a[1], p[2] - a[2]}, e[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
      if (t->half_height == 0) {
        if (swept(q, e, 3, ra, rb)) return true;
        continue;
      }
      const double flat_q[2] = {q[0], q[2]}, flat_e[2] = {e[0], e[2]};
      double along = (q[0] * e[0] + q[2] * e[2]) / (square(e[0]) + square(e[2]));
      along = along < 0 ? 0 : along > 1 ? 1 : along;
      if (fabs(q[1] - along * e[1]) <= (double)t->half_height && swept(flat_q, flat_e, 2, ra, rb)) return true;
    }
  return false;
}

static bool inside(const scree_shape* s, const double p[3]) {
  switch (s->kind) {
    case SCREE_SHAPE_ELLIPSOID: {
      double sum = 0;
      for (int a = 0; a < 3; ++a) sum += square(p[a] / (double)s->ellipsoid.radii[a]);
      return sum <= 1;
    }
    case SCREE_SHAPE_HALF_SPACE: return p[1] <= 0;
    case SCREE_SHAPE_TORUS: {
      double ring = sqrt(square(p[0]) + square(p[2])) - (double)s->torus.radius;
      return square(ring) + square(p[1]) <= square((double)s->torus.tube_radius);
    }
    case SCREE_SHAPE_EXTRUSION:
      return p[1] >= (double)s->extrusion.low && p[1] <= (double)s->extrusion.high && in_polygon(&s->extrusion, p[0], p[2]);
    case SCREE_SHAPE_TUBE: return in_tube(&s->tube, p);
    case SCREE_SHAPE_BLOBS: {
      double sum = 0;
      for (uint32_t i = 0; i < s->blobs.count; ++i) {
        double r2 = 0;
        for (uint32_t a = 0; a < 3; ++a) r2 += square(p[a] - (double)s->blobs.centres[3 * i + a]);
        double k = 1 - r2 / square((double)s->blobs.radii[i]);
        if (k > 0) sum += k * k * k;
      }
      return sum >= 0.5;
    }
    default: {
      double spacing = (double)s->pattern.spacing, radius = (double)s->pattern.radius, at;
      if (s->pattern.kind == SCREE_PATTERN_RINGS)
        at = sqrt(square(p[0]) + square(p[2])) - spacing / 2;
      else
        at = p[0];
      at -= spacing * floor(at / spacing + 0.5);
      return square(at) + square(p[1]) <= square(radius);
    }
  }
}

/* --- distances ------------------------------------------------------------------------------------------------------------- */

static void random_direction(random_stream* r, double v[3]) {
  double l;
  do {
    for (int a = 0; a < 3; ++a) v[a] = random_in(r, -1, 1);
    l = length(v);
  } while (l > 1 || l < 0.1);
  for (int a = 0; a < 3; ++a) v[a] /= l;
}

/* The shortest way from p to the surface among many directions, looked for up to `reach`; reach when there is none. */
static double way_out(const scree_shape* s, const double p[3], double reach, random_stream* r) {
  enum { DIRECTIONS = 700, STEPS = 12 };
  bool in = inside(s, p);
  double best = reach, toward[3] = {0, 0, 0};
  for (int i = 0; i < DIRECTIONS; ++i) {
    double v[3], q[3], low = 0, high = -1;
    random_direction(r, v);
    if (2 * i > DIRECTIONS) { /* around the best so far, closer and closer */
      for (int a = 0; a < 3; ++a) v[a] = toward[a] + 0.5 * pow(0.985, i - DIRECTIONS / 2) * v[a];
      double l = length(v);
      for (int a = 0; a < 3; ++a) v[a] /= l;
    }
    for (int k = 1; k <= STEPS && high < 0; ++k) {
      double at = best * k / STEPS;
      for (int a = 0; a < 3; ++a) q[a] = p[a] + at * v[a];
      if (inside(s, q) != in)
        high = at;
      else
        low = at;
    }
    if (high < 0) continue;
    for (int k = 0; k < 25; ++k) {
      double at = (low + high) / 2;
      for (int a = 0; a < 3; ++a) q[a] = p[a] + at * v[a];
      if (inside(s, q) != in)
        high = at;
      else
        low = at;
    }
    best = high;
    memcpy(toward, v, sizeof v);
  }
  return best;
}

/* Random points within `near` of the surface: the sign is right, the distance is no larger than the way out, and at least `least`
 * of it. */
static void check_shape(const scree_shape* given, double reach, double near, double least, random_stream* r) {
  scree_shape s = *given;
  memset(&s.transform, 0, sizeof s.transform);
  scree_support* support = one_shape(&s);
  int found = 0;
  for (int i = 0; i < 100000 && found < 20; ++i) {
    double p[3];
    for (int a = 0; a < 3; ++a) p[a] = (double)(float)random_in(r, -reach, reach);
    double d = distance_at(support, p);
    if (fabs(d) > 1e-4 && (d <= 0) != inside(&s, p))
      fail_msg("kind %d: distance %g, but inside is %d", (int)s.kind, d, inside(&s, p));
    if (fabs(d) > near || fabs(d) < 1e-3 * near) continue;
    ++found;
    double way = way_out(&s, p, 1.5 * fabs(d) / least, r);
    if (fabs(d) > way * 1.0001 + 2e-5) fail_msg("kind %d: distance %g, but the surface is %g away", (int)s.kind, d, way);
    /* Within a union of pieces that overlap, the way to each piece's own surface counts. */
    bool united = d < 0 && s.kind == SCREE_SHAPE_TUBE && s.tube.subdivisions != 1;
    if (!united && fabs(d) < least * way - 2e-5) fail_msg("kind %d: distance %g for a surface %g away", (int)s.kind, d, way);
  }
  assert_true(found >= 10);
  scree_support_destroy(support);
}

static void check_kind(scree_shape_kind kind, int rounds, double near, double least) {
  static random_support s;
  random_stream r = {(uint64_t)kind * 7 + 1};
  for (int round = 0; round < rounds; ++round) {
    do random_leaf(&s, &r, kind, 10);
    while (kind == SCREE_SHAPE_PATTERN && (s.shapes[0].pattern.kind == SCREE_PATTERN_WAVES || /* or bars that overlap */
                                           s.shapes[0].pattern.radius > 0.5f * s.shapes[0].pattern.spacing));
    if (kind == SCREE_SHAPE_BLOBS && s.shapes[0].blobs.count > 3) s.shapes[0].blobs.count = 3;
    check_shape(&s.shapes[0], 6, near, least, &r);
  }
}

static void ellipsoids_have_their_true_distance(void** state) {
  (void)state;
  check_kind(SCREE_SHAPE_ELLIPSOID, 25, 0.5, 0.97);
  random_stream r = {2};
  const float radii[][3] = {{5, 5, 0.05f}, {5, 0.05f, 0.05f}, {3, 3, 3}, {5, 0.4f, 0.005f}, {0.02f, 4, 4}};
  for (int i = 0; i < 5; ++i) {
    scree_shape s = {.kind = SCREE_SHAPE_ELLIPSOID};
    memcpy(s.ellipsoid.radii, radii[i], sizeof radii[i]);
    float smallest = fminf(radii[i][0], fminf(radii[i][1], radii[i][2]));
    check_shape(&s, 5.5, fmin(1, 3 * (double)smallest), 0.95, &r); /* farther out few rays meet it */
  }
}

/* The nearest point, by halving an interval in double. */
static double nearest_on_ellipsoid(const float radii[3], const double p[3]) {
  double smallest = 1e300, low = 0, high = 1e9, y[3], excess[3], away = 0, in = 0;
  for (int a = 0; a < 3; ++a) smallest = fmin(smallest, (double)radii[a]);
  for (int a = 0; a < 3; ++a) {
    y[a] = fabs(p[a]) + 1e-12;
    excess[a] = ((double)radii[a] - smallest) * ((double)radii[a] + smallest);
  }
  for (int i = 0; i < 300; ++i) {
    double middle = (low + high) / 2, sum = 0;
    for (int a = 0; a < 3; ++a) sum += square((double)radii[a] * y[a] / (middle + excess[a]));
    if (sum > 1)
      low = middle;
    else
      high = middle;
  }
  for (int a = 0; a < 3; ++a) {
    away += square(y[a] - square((double)radii[a]) * y[a] / (low + excess[a]));
    in += square(y[a] / (double)radii[a]);
  }
  return in < 1 ? -sqrt(away) : sqrt(away);
}

static void ellipsoids_of_any_proportions_are_solved(void** state) {
  (void)state;
  random_stream r = {30};
  for (int round = 0; round < 600; ++round) {
    scree_shape s = {.kind = SCREE_SHAPE_ELLIPSOID, .ellipsoid = {{1, 1, 1}}};
    for (int a = 1; a < 3; ++a) s.ellipsoid.radii[a] = (float)pow(1e-3, random_in(&r, 0, 0.999));
    if (round % 4 == 0) s.ellipsoid.radii[2] = s.ellipsoid.radii[1];
    scree_support* support = one_shape(&s);
    for (int i = 0; i < 60; ++i) {
      double p[3];
      for (int a = 0; a < 3; ++a) {
        double out = random_below(&r, 3) ? random_in(&r, 0, 2) : pow(10, random_in(&r, -6, 0));
        p[a] = (double)(float)(out * (double)s.ellipsoid.radii[a]);
      }
      double truth = nearest_on_ellipsoid(s.ellipsoid.radii, p), found = distance_at(support, p);
      if (!(fabs(found - truth) < 2e-5)) fail_msg("%g, expected %g", found, truth);
    }
    scree_support_destroy(support);
  }
}

/* On the planes and axes through the middle, where the nearest point is not the only one and the solution has a double pole. */
static void ellipsoids_are_right_on_their_planes(void** state) {
  (void)state;
  random_stream r = {3};
  for (int round = 0; round < 300; ++round) {
    scree_shape s = {.kind = SCREE_SHAPE_ELLIPSOID};
    for (int a = 0; a < 3; ++a) s.ellipsoid.radii[a] = (float)random_in(&r, 0.05, 4);
    scree_support* support = one_shape(&s);
    double smallest = 1e9;
    for (int a = 0; a < 3; ++a) smallest = fmin(smallest, (double)s.ellipsoid.radii[a]);
    assert_true(fabs(distance_at(support, (double[]){0, 0, 0}) + smallest) < 1e-4);
    for (int a = 0; a < 3; ++a) {
      double p[3] = {0, 0, 0};
      p[a] = random_in(&r, 1, 3) * (double)s.ellipsoid.radii[a]; /* straight out of an end */
      assert_true(fabs(distance_at(support, p) - (p[a] - (double)s.ellipsoid.radii[a])) < 1e-4);
      p[a] = (double)s.ellipsoid.radii[a];
      assert_true(fabs(distance_at(support, p)) < 1e-4);
      p[a] *= random_in(&r, 0, 1);
      assert_true(distance_at(support, p) >= -smallest - 1e-4);
      assert_true(distance_at(support, p) <= p[a] - (double)s.ellipsoid.radii[a] + (double)s.ellipsoid.radii[a] - p[a] + 1e-4);
    }
    scree_support_destroy(support);
  }
}

static void half_spaces_and_tori_have_their_true_distance(void** state) {
  (void)state;
  check_kind(SCREE_SHAPE_HALF_SPACE, 2, 3, 0.97);
  check_kind(SCREE_SHAPE_TORUS, 20, 0.4, 0.97);
}

static void extrusions_have_their_true_distance(void** state) {
  (void)state;
  check_kind(SCREE_SHAPE_EXTRUSION, 30, 0.4, 0.95);
}

/* Hundreds of edges, of which whole chunks are skipped. */
static void extrusions_of_many_edges_have_their_true_distance(void** state) {
  (void)state;
  enum { POINTS = 600 };
  static float points[2 * POINTS];
  random_stream r = {4};
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < POINTS; ++i) {
      double turn = 6.28318530718 * i / POINTS, arm = 4 + sin(turn * 17) + random_in(&r, -0.05, 0.05);
      points[2 * i] = (float)(arm * cos(turn));
      points[2 * i + 1] = (float)(arm * sin(turn));
    }
    scree_shape s = {.kind = SCREE_SHAPE_EXTRUSION, .extrusion = {points, POINTS, -1, 2}};
    check_shape(&s, 6, 0.5, 0.97, &r);
  }
}

/* Pieces unite, and where they meet at a corner the inside is measured to the nearer piece's end. */
static void tubes_follow_their_curve(void** state) {
  (void)state;
  random_stream r = {5};
  static random_support s;
  for (int round = 0; round < ROUNDS(30, 5); ++round) {
    random_leaf(&s, &r, SCREE_SHAPE_TUBE, 10);
    check_shape(&s.shapes[0], 6, 0.15, s.shapes[0].tube.half_height > 0 ? 0.3 : 0.5, &r);
  }
}

static void straight_tubes_have_their_true_distance(void** state) {
  (void)state;
  random_stream r = {6};
  for (int round = 0; round < 24; ++round) {
    float points[6] = {-4, (float)random_in(&r, -1, 1), -2, 4, (float)random_in(&r, -1, 1), 1};
    float radii[2] = {(float)random_in(&r, 0.4, 1.2), (float)random_in(&r, 0.4, 1.2)};
    if (round % 2) points[4] = points[1];
    scree_shape s = {.kind = SCREE_SHAPE_TUBE, .tube = {points, radii, 2, false, 1, round % 3 ? 1.5f : 0}};
    check_shape(&s, 6, 0.4, round % 3 && round % 2 == 0 ? 0.9 : 0.97, &r);
  }
}

static void curves_run_through_their_points_and_close(void** state) {
  (void)state;
  random_stream r = {7};
  static random_support s;
  for (int round = 0; round < 40; ++round) {
    random_leaf(&s, &r, SCREE_SHAPE_TUBE, 10);
    memset(&s.shapes[0].transform, 0, sizeof s.shapes[0].transform);
    const scree_tube* t = &s.shapes[0].tube;
    scree_support* support = must_create(&s.desc);
    for (uint32_t i = 0; i < t->point_count; ++i) {
      const double p[3] = {(double)t->points[3 * i], (double)t->points[3 * i + 1], (double)t->points[3 * i + 2]};
      double depth = -distance_at(support, p), radius = (double)t->radii[i];
      if (t->half_height > 0 && (double)t->half_height < radius) radius = (double)t->half_height;
      assert_true(depth >= radius * (t->half_height > 0 ? 0.1 : 1) - 1e-4);
    }
    uint32_t spans = t->closed ? t->point_count : t->point_count - 1, steps = t->subdivisions == 0 ? 8 : t->subdivisions;
    assert_int_equal(support->op_count, 2 * spans * steps - 1);
    scree_support_destroy(support);
  }
}

static void blobs_have_the_right_size_near_their_surface(void** state) {
  (void)state;
  check_kind(SCREE_SHAPE_BLOBS, 30, 0.08, 0.6);
}

static void one_blob_is_a_ball(void** state) {
  (void)state;
  float centre[3] = {1, 2, 3}, radius = 2;
  scree_shape s = {.kind = SCREE_SHAPE_BLOBS, .blobs = {centre, &radius, 1}};
  scree_support* support = one_shape(&s);
  double surface = 2 * sqrt(1 - pow(0.5, 1.0 / 3));
  assert_true(fabs(surface / 2 - 0.4543) < 1e-4);
  for (double at = 0; at < 6; at += 0.01) {
    double d = distance_at(support, (double[]){1, 2 + at, 3}), truth = at - surface;
    assert_true((d < 0) == (truth < 0) || fabs(truth) < 1e-4);
    assert_true(fabs(d) <= fabs(truth) + 1e-4 && fabs(d) >= 0.65 * fabs(truth) - 1e-4);
  }
  scree_support_destroy(support);
}

static void lines_and_rings_have_their_true_distance(void** state) {
  (void)state;
  check_kind(SCREE_SHAPE_PATTERN, 20, 0.2, 0.9);
}

/* The swing has this amplitude, this period and no other; bars are round and at most a little thicker in the bends. */
static void waves_swing_as_they_were_told(void** state) {
  (void)state;
  random_stream r = {8};
  for (int round = 0; round < 30; ++round) {
    double wavelength = random_in(&r, 1, 4), amplitude = wavelength * random_in(&r, 0, 0.15), spacing = random_in(&r, 1.5, 3);
    scree_shape s = {.kind = SCREE_SHAPE_PATTERN,
                     .pattern = {SCREE_PATTERN_WAVES, (float)spacing, 0.1f, (float)amplitude, (float)wavelength}};
    scree_support* support = one_shape(&s);
    for (int i = 0; i < 50; ++i) {
      double z = random_in(&r, -10, 10), u = z / wavelength - floor(z / wavelength);
      double swing = u < 0.5 ? 16 * u * (0.5 - u) : -16 * (u - 0.5) * (1 - u), k = floor(random_in(&r, -5, 5));
      assert_true(fabs(swing - sin(6.28318530718 * u)) < 0.06);
      double axis[3] = {k * spacing + amplitude * swing, 0, z}; /* in the middle of a bar */
      assert_true(fabs(distance_at(support, axis) + 0.1) < 1e-4);
      axis[1] = 0.1;
      assert_true(fabs(distance_at(support, axis)) < 1e-4);
      axis[1] = 3;
      assert_true(fabs(distance_at(support, axis) - 2.9) < 1e-4);
    }
    scree_support_destroy(support);
  }
  scree_shape s = {.kind = SCREE_SHAPE_PATTERN, .pattern = {SCREE_PATTERN_WAVES, 2, 0.2f, 0.3f, 4}};
  scree_support* support = one_shape(&s);
  for (int i = 0; i < 2000; ++i) { /* far from the curve, sampled densely, nobody is inside, and close to it everybody */
    double p[3] = {random_in(&r, -2, 2), random_in(&r, -0.3, 0.3), random_in(&r, -4, 4)}, nearest = 1e9;
    for (double z = p[2] - 1; z < p[2] + 1; z += 0.01)
      for (int k = -2; k <= 2; ++k) {
        double u = z / 4 - floor(z / 4), swing = u < 0.5 ? 16 * u * (0.5 - u) : -16 * (u - 0.5) * (1 - u);
        nearest = fmin(nearest, sqrt(square(p[0] - 2 * k - 0.3 * swing) + square(p[1]) + square(p[2] - z)));
      }
    double d = distance_at(support, p);
    if (nearest < 0.19) assert_true(d < 0);
    if (nearest > 0.22) assert_true(d > 0);
    assert_true(d <= nearest - 0.2 + 0.001);
  }
  scree_support_destroy(support);
}

/* --- noise ----------------------------------------------------------------------------------------------------------------- */

static uint32_t twin_hash(uint32_t h) {
  h ^= h >> 16;
  h *= 0x7feb352du;
  h ^= h >> 15;
  h *= 0x846ca68bu;
  return h ^ (h >> 16);
}

/* One octave, not yet divided by its largest value. */
static double twin_noise(const double p[3], uint32_t seed) {
  static const int gradients[16][3] = {{1, 1, 0},  {-1, 1, 0},  {1, -1, 0}, {-1, -1, 0}, {1, 0, 1},  {-1, 0, 1},
                                       {1, 0, -1}, {-1, 0, -1}, {0, 1, 1},  {0, -1, 1},  {0, 1, -1}, {0, -1, -1},
                                       {1, 1, 0},  {0, -1, 1},  {-1, 1, 0}, {0, -1, -1}};
  double sum = 0;
  for (int c = 0; c < 8; ++c) {
    double weight = 1, away[3];
    uint32_t at[3];
    for (int a = 0; a < 3; ++a) {
      double low = floor(p[a]), t = p[a] - low;
      int b = c >> a & 1;
      at[a] = (uint32_t)(int32_t)low + (uint32_t)b;
      away[a] = t - b;
      weight *= b ? t * t * (3 - 2 * t) : 1 - t * t * (3 - 2 * t);
    }
    const int* g = gradients[twin_hash(at[0] ^ twin_hash(at[1] ^ twin_hash(at[2] ^ seed))) >> 28];
    sum += weight * (g[0] * away[0] + g[1] * away[1] + g[2] * away[2]);
  }
  return sum;
}

static void noise_is_what_its_plain_twin_says(void** state) {
  (void)state;
  random_stream r = {9};
  for (int round = 0; round < 40; ++round) {
    scree_noise n = {.child = 1,
                     .amplitude = (float)random_in(&r, 0.1, 2),
                     .wavelength = (float)random_in(&r, 0.5, 5),
                     .octaves = 1 + (uint32_t)round % 8,
                     .seed = (uint32_t)random_bits(&r)};
    scree_shape shapes[2] = {{.kind = SCREE_SHAPE_NOISE, .noise = n}, {.kind = SCREE_SHAPE_SPHERE, .sphere = {4}}};
    scree_support* support = must_create(&(scree_support_desc){.shapes = shapes, .shape_count = 2});
    double total = 0, low = 0, high = 0;
    for (uint32_t o = 0; o < n.octaves; ++o) total += pow(0.5, o);
    for (int i = 0; i < 500; ++i) {
      double p[3], q[3], expected = 0;
      for (int a = 0; a < 3; ++a) p[a] = (double)(float)random_in(&r, -8, 8);
      for (uint32_t o = 0; o < n.octaves; ++o) {
        for (int a = 0; a < 3; ++a) q[a] = p[a] / (double)n.wavelength * pow(2, o);
        expected += pow(0.5, o) * twin_noise(q, n.seed + o * 0x9e3779b9u) / 1.04492;
      }
      expected *= (double)n.amplitude / total;
      double added = distance_at(support, p) - (length(p) - 4);
      assert_true(fabs(added - expected) < 2e-4 * (1 + (double)n.amplitude * n.octaves));
      assert_true(fabs(added) <= (double)n.amplitude + 1e-5);
      low = fmin(low, added);
      high = fmax(high, added);
    }
    assert_true(low < -0.3 * (double)n.amplitude && high > 0.3 * (double)n.amplitude);
    scree_support_destroy(support);
  }
}

/* Scaled and turned with its child: the same shape elsewhere. */
static void noise_moves_with_its_space(void** state) {
  (void)state;
  random_stream r = {10};
  scree_shape shapes[2] = {{.kind = SCREE_SHAPE_NOISE, .noise = {1, 0.5f, 2, 3, 17}},
                           {.kind = SCREE_SHAPE_BOX, .box = {{2, 1, 3}, 0.2f}}};
  scree_support* still = must_create(&(scree_support_desc){.shapes = shapes, .shape_count = 2});
  shapes[0].transform.scale = 2;
  shapes[0].transform.translation[2] = 5;
  shapes[0].transform.rotation[1] = shapes[0].transform.rotation[3] = (float)sqrt(0.5); /* a quarter round Y: x to -z */
  scree_support* moved = must_create(&(scree_support_desc){.shapes = shapes, .shape_count = 2});
  for (int i = 0; i < 300; ++i) {
    double p[3];
    for (int a = 0; a < 3; ++a) p[a] = random_in(&r, -4, 4);
    const double q[3] = {2 * p[2], 2 * p[1], 5 - 2 * p[0]};
    assert_true(fabs(distance_at(moved, q) - 2 * distance_at(still, p)) < 1e-4);
  }
  scree_support_destroy(still);
  scree_support_destroy(moved);
}

/* --- without an end -------------------------------------------------------------------------------------------------------- */

static void endless_supports_need_a_box(void** state) {
  (void)state;
  synthetic_source source = synthetic_create(4, 1, 1, 1);
  const scree_field_desc field_desc = {.seed = 1, .cell_size = 1};
  scree_field* field;
  assert_int_equal(scree_rt_field_create_from_source(&field_desc, &source.source, NULL, &field), SCREE_OK);
  static const uint32_t children[2] = {1, 2};
  scree_shape shapes[3] = {{.kind = SCREE_SHAPE_INTERSECTION, .group = {children, 2, 0}},
                           {.kind = SCREE_SHAPE_HALF_SPACE},
                           {.kind = SCREE_SHAPE_SPHERE, .sphere = {5}}};
  double min[3], max[3];
  uint64_t count;
  for (int kind = 0; kind < 4; ++kind) {
    if (kind > 0)
      shapes[1] = (scree_shape){.kind = SCREE_SHAPE_PATTERN, .pattern = {(scree_pattern_kind)(kind - 1), 4, 1, 0.5f, 6}};
    scree_support* endless = one_shape(&shapes[1]);
    scree_support_bounds(endless, min, max);
    assert_true(min[0] == -INFINITY && max[0] == INFINITY && min[2] == -INFINITY && max[2] == INFINITY);
    if (kind == 0) assert_true(min[1] == -INFINITY && fabs(max[1]) < 1e-3);
    if (kind > 0) assert_true(fabs(min[1] + 1) < 1e-3 && fabs(max[1] - 1) < 1e-3);
    scree_query_desc d = {.field = field, .support = endless};
    assert_int_equal(scree_query_count(&d, &count), SCREE_ERROR_RANGE);
    for (int a = 0; a < 3; ++a) {
      d.min[a] = -10;
      d.max[a] = 10;
    }
    assert_int_equal(scree_query_count(&d, &count), SCREE_OK);
    assert_true(count > 50);
    scree_support_destroy(endless);
    scree_support* cut = must_create(&(scree_support_desc){.shapes = shapes, .shape_count = 3});
    scree_support_bounds(cut, min, max);
    for (int a = 0; a < 3; ++a) assert_true(min[a] >= -5.001 && max[a] <= 5.001);
    d = (scree_query_desc){.field = field, .support = cut};
    assert_int_equal(scree_query_count(&d, &count), SCREE_OK);
    assert_true(count > 10);
    scree_support_destroy(cut);
  }
  scree_field_destroy(field);
  synthetic_destroy(&source);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(ellipsoids_have_their_true_distance),
      cmocka_unit_test(ellipsoids_of_any_proportions_are_solved),
      cmocka_unit_test(ellipsoids_are_right_on_their_planes),
      cmocka_unit_test(half_spaces_and_tori_have_their_true_distance),
      cmocka_unit_test(extrusions_have_their_true_distance),
      cmocka_unit_test(extrusions_of_many_edges_have_their_true_distance),
      cmocka_unit_test(tubes_follow_their_curve),
      cmocka_unit_test(straight_tubes_have_their_true_distance),
      cmocka_unit_test(curves_run_through_their_points_and_close),
      cmocka_unit_test(blobs_have_the_right_size_near_their_surface),
      cmocka_unit_test(one_blob_is_a_ball),
      cmocka_unit_test(lines_and_rings_have_their_true_distance),
      cmocka_unit_test(waves_swing_as_they_were_told),
      cmocka_unit_test(noise_is_what_its_plain_twin_says),
      cmocka_unit_test(noise_moves_with_its_space),
      cmocka_unit_test(endless_supports_need_a_box),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
