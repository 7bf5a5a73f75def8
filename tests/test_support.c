/* Supports: distances against plain formulas in double, their Lipschitz bounds, mesh grids against brute force. */
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
#include "random_support.h"
#include "support_program.h"

static void random_point(random_stream* r, double reach, double p[3]) {
  for (int a = 0; a < 3; ++a) p[a] = (double)(float)random_in(r, -reach, reach);
}

static double length(double x, double y, double z) {
  return sqrt(x * x + y * y + z * z);
}
static double larger(double a, double b) {
  return a > b ? a : b;
}
static double smaller(double a, double b) {
  return a < b ? a : b;
}

/* From the root's space into a shape's: the transform undone step by step. */
static void undo(const scree_transform* t, const double p[3], double out[3]) {
  double q[4], s = t->scale == 0 ? 1 : (double)t->scale, v[3], norm = 0;
  for (int a = 0; a < 4; ++a) {
    q[a] = (double)t->rotation[a];
    norm += q[a] * q[a];
  }
  if (norm == 0) q[3] = 1;
  for (int a = 0; a < 3; ++a) v[a] = p[a] - (double)t->translation[a];
  /* v' = v + 2 w (u x v) + 2 u x (u x v), with u the negated axis: the rotation backwards */
  double u[3] = {-q[0], -q[1], -q[2]}, c[3], cc[3];
  for (int a = 0; a < 3; ++a) c[a] = u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3];
  for (int a = 0; a < 3; ++a) cc[a] = u[(a + 1) % 3] * c[(a + 2) % 3] - u[(a + 2) % 3] * c[(a + 1) % 3];
  for (int a = 0; a < 3; ++a) out[a] = (v[a] + 2 * q[3] * c[a] + 2 * cc[a]) / s;
}

/* The distance of a flat profile in the half plane (r, y), r >= 0, to a convex polygon given counter-clockwise. */
static double profile_distance(double r, double y, const double (*corner)[2], int count) {
  double best = 1e300;
  bool inside = true;
  for (int i = 0; i < count; ++i) {
    const double *a = corner[i], *b = corner[(i + 1) % count];
    double ex = b[0] - a[0], ey = b[1] - a[1], px = r - a[0], py = y - a[1];
    if (ex * py - ey * px < 0) inside = false;
    if (a[0] == 0 && b[0] == 0) continue; /* the axis is no surface */
    double t = (px * ex + py * ey) / (ex * ex + ey * ey);
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    best = smaller(best, length(px - t * ex, py - t * ey, 0));
  }
  return inside ? -best : best;
}

static double true_distance(const scree_shape* s, const double p[3]) {
  double q[3], scale = s->transform.scale == 0 ? 1 : (double)s->transform.scale;
  undo(&s->transform, p, q);
  switch (s->kind) {
    case SCREE_SHAPE_SPHERE: return scale * (length(q[0], q[1], q[2]) - (double)s->sphere.radius);
    case SCREE_SHAPE_BOX: {
      double outside[3], deepest = -1e300, rounding = (double)s->box.rounding;
      for (int a = 0; a < 3; ++a) {
        double d = fabs(q[a]) - ((double)s->box.half[a] - rounding);
        outside[a] = larger(d, 0);
        deepest = larger(deepest, d);
      }
      return scale * (length(outside[0], outside[1], outside[2]) + smaller(deepest, 0) - rounding);
    }
    case SCREE_SHAPE_CAPSULE: {
      double best = 1e300; /* the segment, by ternary search: nothing in common with the formula under test */
      double low = 0, high = 1;
      for (int i = 0; i < 200; ++i) {
        double third[2] = {low + (high - low) / 3, high - (high - low) / 3}, d[2];
        for (int k = 0; k < 2; ++k) {
          double v[3];
          for (int a = 0; a < 3; ++a)
            v[a] = q[a] - ((double)s->capsule.a[a] + third[k] * ((double)s->capsule.b[a] - (double)s->capsule.a[a]));
          d[k] = length(v[0], v[1], v[2]);
        }
        if (d[0] < d[1])
          high = third[1];
        else
          low = third[0];
        best = smaller(best, smaller(d[0], d[1]));
      }
      return scale * (best - (double)s->capsule.radius);
    }
    case SCREE_SHAPE_CYLINDER: {
      double r = (double)s->cylinder.radius, h = (double)s->cylinder.half_height;
      const double corners[4][2] = {{0, -h}, {r, -h}, {r, h}, {0, h}};
      return scale * profile_distance(length(q[0], q[2], 0), q[1], corners, 4);
    }
    default: {
      double r = (double)s->cone.radius, h = (double)s->cone.height;
      const double corners[3][2] = {{0, 0}, {r, 0}, {0, h}};
      return scale * profile_distance(length(q[0], q[2], 0), q[1], corners, 3);
    }
  }
}

static void round_shapes_have_their_true_distance(void** state) {
  (void)state;
  random_stream r = {1};
  random_support s;
  for (int round = 0; round < 60; ++round) {
    random_leaf(&s, &r, (scree_shape_kind)(round % 5), 10);
    scree_support* support = must_create(&s.desc);
    for (int i = 0; i < 200; ++i) {
      double p[3];
      random_point(&r, 15, p);
      double expected = true_distance(s.desc.shapes, p), found = distance_at(support, p);
      if (fabs(found - expected) > 2e-5) fail_msg("kind %d: %g, expected %g", (int)s.desc.shapes[0].kind, found, expected);
    }
    scree_support_destroy(support);
  }
}

/* The layer's sign is exact; its distance is the vertical one, scaled down so that it is never too large, and no more than by the
 * steepest slope. */
static void heightfield_is_a_layer_between_two_surfaces(void** state) {
  (void)state;
  random_stream r = {2};
  random_support s;
  for (int round = 0; round < 30; ++round) {
    random_leaf(&s, &r, SCREE_SHAPE_HEIGHTFIELD, 10);
    memset(&s.shapes[0].transform, 0, sizeof s.shapes[0].transform);
    const scree_shape* f = &s.shapes[0];
    scree_support* support = must_create(&s.desc);
    double spacing = (double)f->heightfield.spacing, width = (f->heightfield.width - 1) * spacing,
           depth = (f->heightfield.depth - 1) * spacing;
    for (int i = 0; i < 300; ++i) {
      double p[3] = {random_in(&r, -0.5, 0.5) * width, random_in(&r, -8, 12), random_in(&r, -0.5, 0.5) * depth};
      double u = (p[0] + width / 2) / spacing, v = (p[2] + depth / 2) / spacing;
      uint32_t iu = (uint32_t)u, iv = (uint32_t)v;
      const float* h = f->heightfield.heights + iv * f->heightfield.width + iu;
      double fu = u - iu, fv = v - iv, a = (double)h[0] + fu * ((double)h[1] - (double)h[0]);
      h += f->heightfield.width;
      double b = (double)h[0] + fu * ((double)h[1] - (double)h[0]), y = p[1] - (a + fv * (b - a));
      double vertical = larger(y - (double)f->heightfield.above, -(double)f->heightfield.below - y);
      double side = larger(fabs(p[0]) - width / 2, fabs(p[2]) - depth / 2), found = distance_at(support, p);
      if (fabs(vertical) < 1e-4 || fabs(side) < 1e-4) continue;
      assert_true((found < 0) == (vertical < 0));
      assert_true(fabs(found) <= fabs(larger(vertical, side)) + 1e-4);
      double slope_scale = (double)support->heights[0]->cosine;
      if (found > side + 1e-4) assert_true(fabs(found) >= fabs(vertical) * slope_scale - 1e-4);
    }
    scree_support_destroy(support);
  }
}

/* Flat land, a slope of 1/2 and one cliff: by the surface, distances away from the cliff are the true ones, and everywhere none is
 * larger than the way to the nearest of many points of the surface. */
static void one_cliff_does_not_thicken_a_layer_elsewhere(void** state) {
  (void)state;
  enum { SIDE = 161 };
  static float heights[SIDE * SIDE];
  for (int z = 0; z < SIDE; ++z)
    for (int x = 0; x < SIDE; ++x) heights[z * SIDE + x] = (x > 80 ? 0.5f * (float)(x - 80) : 0) + (x < 10 ? 30 : 0);
  scree_shape ground = {.kind = SCREE_SHAPE_HEIGHTFIELD, .heightfield = {heights, SIDE, SIDE, 1, 0, 50}};
  scree_support* support = one_shape(&ground);
  random_stream r = {21};
  assert_true((double)support->heights[0]->cosine < 0.04);
  for (int i = 0; i < 3000; ++i) {
    double p[3] = {random_in(&r, -75, 75), 0, random_in(&r, -60, 60)}, x = p[0] + 80, nearest = 1e9;
    double surface = x > 80 ? 0.5 * (x - 80) : x <= 9 ? 30 : x < 10 ? 30 * (10 - x) : 0;
    double above = random_in(&r, -2, 2);
    p[1] = surface + above;
    for (double u = 0; u <= 160; u += 0.02) { /* the land is the same along z */
      double h = u > 80 ? 0.5 * (u - 80) : u <= 9 ? 30 : u < 10 ? 30 * (10 - u) : 0;
      nearest = smaller(nearest, (u - x) * (u - x) + (h - p[1]) * (h - p[1]));
    }
    nearest = sqrt(nearest);
    double found = distance_at(support, p);
    assert_true((found < 0) == (above < 0) || fabs(above) < 1e-4);
    assert_true(fabs(found) <= nearest + 0.02);
    if (x > 100) assert_true(fabs(found) >= 0.8 * nearest - 0.02);
    if (x > 100 && fabs(above) < 0.3) assert_true(fabs(found) >= 0.97 * nearest - 0.02);
  }
  scree_support_destroy(support);
}

static void groups_combine_the_distances_of_their_children(void** state) {
  (void)state;
  random_stream r = {3};
  const uint32_t children[3] = {1, 2, 3};
  for (int round = 0; round < 40; ++round) {
    scree_shape shapes[4];
    memset(shapes, 0, sizeof shapes);
    scree_shape_kind kind = (scree_shape_kind)(SCREE_SHAPE_UNION + round % 4);
    shapes[0] = (scree_shape){.kind = kind, .group = {children, 3, (float)random_in(&r, 0.1, 4)}};
    scree_support* alone[3];
    for (int i = 1; i < 4; ++i) {
      shapes[i].kind = SCREE_SHAPE_SPHERE;
      shapes[i].sphere.radius = (float)random_in(&r, 1, 5);
      for (int a = 0; a < 3; ++a) shapes[i].transform.translation[a] = (float)random_in(&r, -4, 4);
      alone[i - 1] = one_shape(&shapes[i]);
    }
    scree_support* together = must_create(&(scree_support_desc){.shapes = shapes, .shape_count = 4});
    for (int i = 0; i < 200; ++i) {
      double p[3], d[3];
      random_point(&r, 10, p);
      for (int k = 0; k < 3; ++k) d[k] = distance_at(alone[k], p);
      double expected = d[0], blend = (double)shapes[0].group.blend;
      for (int k = 1; k < 3; ++k) {
        double h = larger(blend - fabs(expected - d[k]), 0) / blend;
        expected = kind == SCREE_SHAPE_UNION          ? smaller(expected, d[k])
                   : kind == SCREE_SHAPE_INTERSECTION ? larger(expected, d[k])
                   : kind == SCREE_SHAPE_DIFFERENCE   ? larger(expected, -d[k])
                                                      : smaller(expected, d[k]) - h * h * blend / 4;
      }
      assert_true(fabs(distance_at(together, p) - expected) < 1e-5);
    }
    scree_support_destroy(together);
    for (int k = 0; k < 3; ++k) scree_support_destroy(alone[k]);
  }
}

/* A group's transform moves its children, and scales its blend with them. */
static void transforms_of_groups_reach_their_children(void** state) {
  (void)state;
  random_stream r = {4};
  const uint32_t children[2] = {1, 2};
  for (int round = 0; round < 20; ++round) {
    scree_shape shapes[3];
    memset(shapes, 0, sizeof shapes);
    shapes[0] = (scree_shape){.kind = SCREE_SHAPE_SMOOTH_UNION, .group = {children, 2, 2}};
    shapes[1] = (scree_shape){.kind = SCREE_SHAPE_BOX, .box = {{3, 1, 2}, 0.25f}};
    shapes[2] = (scree_shape){.kind = SCREE_SHAPE_CONE, .cone = {2, 3}};
    random_rotation(&r, shapes[1].transform.rotation);
    shapes[2].transform.translation[1] = 2;
    scree_support* still = must_create(&(scree_support_desc){.shapes = shapes, .shape_count = 3});
    scree_transform* t = &shapes[0].transform;
    random_rotation(&r, t->rotation);
    t->scale = (float)random_in(&r, 0.25, 4);
    for (int a = 0; a < 3; ++a) t->translation[a] = (float)random_in(&r, -10, 10);
    scree_support* moved = must_create(&(scree_support_desc){.shapes = shapes, .shape_count = 3});
    for (int i = 0; i < 100; ++i) {
      double p[3], q[3];
      random_point(&r, 15, p);
      undo(t, p, q);
      assert_true(fabs(distance_at(moved, p) - (double)t->scale * distance_at(still, q)) < 1e-4);
    }
    scree_support_destroy(still);
    scree_support_destroy(moved);
  }
}

/* What the walk relies on: over any two points, and for trees as a whole. */
static void no_distance_changes_faster_than_its_bound(void** state) {
  (void)state;
  random_stream r = {5};
  static random_support s;
  for (int round = 0; round < 240; ++round) {
    if (round < 150)
      random_leaf(&s, &r, (scree_shape_kind)(round % (SCREE_SHAPE_PATTERN + 1)), 10);
    else
      random_tree(&s, &r, 2 + random_below(&r, 20), 10);
    scree_support* support = must_create(&s.desc);
    double bound = scree_rt_support_lipschitz(support), doubt = 0;
    for (uint32_t i = 0; i < support->op_count; ++i) doubt = larger(doubt, (double)support->ops[i].doubt);
    for (int i = 0; i < 1500; ++i) {
      double p[3], q[3], apart = random_below(&r, 2) ? 0.3 : 10;
      random_point(&r, 20, p);
      for (int a = 0; a < 3; ++a) q[a] = (double)(float)(p[a] + random_in(&r, -apart, apart));
      double moved = length(p[0] - q[0], p[1] - q[1], p[2] - q[2]),
             change = fabs(distance_at(support, p) - distance_at(support, q));
      if (change > bound * moved + 1e-4 + doubt)
        fail_msg("round %d, kind %d: changes by %g over %g", round, (int)s.desc.shapes[0].kind, change, moved);
    }
    scree_support_destroy(support);
  }
}

/* Whoever is asked together with whom, in batches of any size, and in any lane. */
static void distances_do_not_depend_on_the_company_of_a_point(void** state) {
  (void)state;
  random_stream r = {6};
  static random_support s;
  for (int round = 0; round < 20; ++round) {
    random_tree(&s, &r, 12, 10);
    scree_support* support = must_create(&s.desc);
    float x[300], y[300], z[300], together[300], alone;
    for (int i = 0; i < 300; ++i) {
      x[i] = (float)random_in(&r, -15, 15);
      y[i] = (float)random_in(&r, -15, 15);
      z[i] = (float)random_in(&r, -15, 15);
    }
    scree_support_distance(support, x, y, z, together, 300);
    for (int i = 0; i < 300; ++i) {
      scree_support_distance(support, &x[i], &y[i], &z[i], &alone, 1);
      assert_memory_equal(&alone, &together[i], sizeof alone);
    }
    scree_support_destroy(support);
  }
}

static void nothing_of_a_support_lies_outside_its_bounds(void** state) {
  (void)state;
  random_stream r = {7};
  static random_support s;
  for (int round = 0; round < 60; ++round) {
    random_tree(&s, &r, 1 + random_below(&r, 12), 10);
    for (int a = 0; a < 3; ++a) s.desc.origin[a] = random_in(&r, -100, 100);
    scree_support* support = must_create(&s.desc);
    double min[3], max[3], low[3], high[3];
    scree_support_bounds(support, min, max);
    double level = random_in(&r, 0, 3);
    bool some = scree_rt_support_level_bounds(support, level, low, high);
    for (int i = 0; i < 2000; ++i) {
      double p[3];
      random_point(&r, 25, p);
      double d = distance_at(support, p);
      for (int a = 0; a < 3; ++a) {
        if (d <= 0) assert_true(p[a] + s.desc.origin[a] >= min[a] && p[a] + s.desc.origin[a] <= max[a]);
        if (d <= level) assert_true(some && p[a] >= low[a] && p[a] <= high[a]);
      }
    }
    scree_support_destroy(support);
  }
}

/* --- meshes ---------------------------------------------------------------------------------------------------------------- */

static double segment_distance(const double p[3], const double a[3], const double b[3]) {
  double ab[3], ap[3], dot = 0, length2 = 0;
  for (int k = 0; k < 3; ++k) {
    ab[k] = b[k] - a[k];
    ap[k] = p[k] - a[k];
    dot += ab[k] * ap[k];
    length2 += ab[k] * ab[k];
  }
  double t = length2 > 0 ? larger(0, smaller(1, dot / length2)) : 0;
  return length(ap[0] - t * ab[0], ap[1] - t * ab[1], ap[2] - t * ab[2]);
}

/* Distance and winding number (solid angles) by going over all triangles. */
static double brute_mesh(const scree_shape* s, const double p[3], double* winding) {
  double best = 1e300, angle = 0;
  for (uint32_t t = 0; t < s->mesh.triangle_count; ++t) {
    double c[3][3], v[3][3], l[3], n[3], dots[3];
    for (int k = 0; k < 3; ++k)
      for (int a = 0; a < 3; ++a) {
        c[k][a] = (double)s->mesh.positions[3 * s->mesh.indices[3 * t + k] + a];
        v[k][a] = c[k][a] - p[a];
      }
    for (int k = 0; k < 3; ++k) {
      best = smaller(best, segment_distance(p, c[k], c[(k + 1) % 3]));
      l[k] = length(v[k][0], v[k][1], v[k][2]);
      dots[k] = v[k][0] * v[(k + 1) % 3][0] + v[k][1] * v[(k + 1) % 3][1] + v[k][2] * v[(k + 1) % 3][2];
    }
    double e[3], f[3];
    for (int a = 0; a < 3; ++a) {
      e[a] = c[1][a] - c[0][a];
      f[a] = c[2][a] - c[0][a];
    }
    for (int a = 0; a < 3; ++a) n[a] = e[(a + 1) % 3] * f[(a + 2) % 3] - e[(a + 2) % 3] * f[(a + 1) % 3];
    double area = length(n[0], n[1], n[2]), above = -(v[0][0] * n[0] + v[0][1] * n[1] + v[0][2] * n[2]);
    bool over = area > 0; /* straight above or below the face? */
    for (int k = 0; k < 3 && over; ++k) {
      double side = 0;
      for (int a = 0; a < 3; ++a) {
        int b = (a + 1) % 3, d = (a + 2) % 3;
        side += n[a] * ((c[(k + 1) % 3][b] - c[k][b]) * (p[d] - c[k][d]) - (c[(k + 1) % 3][d] - c[k][d]) * (p[b] - c[k][b]));
      }
      over = side >= 0;
    }
    if (over) best = smaller(best, fabs(above) / area);
    double triple = v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) + v[0][1] * (v[1][2] * v[2][0] - v[1][0] * v[2][2]) +
                    v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0]);
    angle += 2 * atan2(triple, l[0] * l[1] * l[2] + dots[0] * l[2] + dots[1] * l[0] + dots[2] * l[1]);
  }
  *winding = angle / (4 * 3.14159265358979323846);
  return best;
}

enum { TUBE_RINGS = 48, TUBE_SIDES = 12 };

/* A trefoil knot with a thick tube: closed, smooth, as concave as it gets. */
static scree_shape knot(float* positions, uint32_t* indices) {
  const double turn = 2 * 3.14159265358979323846;
  uint32_t* to = indices;
  for (uint32_t i = 0; i < TUBE_RINGS; ++i) {
    double t = turn * i / TUBE_RINGS, centre[3], ahead[3], side[3], up[3];
    centre[0] = sin(t) + 2 * sin(2 * t);
    centre[1] = cos(t) - 2 * cos(2 * t);
    centre[2] = -sin(3 * t);
    ahead[0] = cos(t) + 4 * cos(2 * t);
    ahead[1] = -sin(t) + 4 * sin(2 * t);
    ahead[2] = -3 * cos(3 * t);
    double l = length(ahead[0], ahead[1], ahead[2]), m = length(ahead[0], ahead[1], 0);
    side[0] = -ahead[1] / m;
    side[1] = ahead[0] / m;
    side[2] = 0;
    for (int a = 0; a < 3; ++a) up[a] = (ahead[(a + 1) % 3] * side[(a + 2) % 3] - ahead[(a + 2) % 3] * side[(a + 1) % 3]) / l;
    for (uint32_t k = 0; k < TUBE_SIDES; ++k) {
      double phi = turn * k / TUBE_SIDES;
      for (int a = 0; a < 3; ++a)
        positions[3 * (i * TUBE_SIDES + k) + a] = (float)(centre[a] + 0.45 * (cos(phi) * side[a] + sin(phi) * up[a]));
      uint32_t next = (k + 1) % TUBE_SIDES, row = i * TUBE_SIDES, after = (i + 1) % TUBE_RINGS * TUBE_SIDES;
      const uint32_t quad[6] = {row + k, row + next, after + next, row + k, after + next, after + k};
      memcpy(to, quad, sizeof quad);
      to += 6;
    }
  }
  return (scree_shape){.kind = SCREE_SHAPE_MESH,
                       .mesh = {positions, indices, TUBE_RINGS * TUBE_SIDES, 2 * TUBE_RINGS * TUBE_SIDES, 64}};
}

/* Distances in grid steps: samples by the surface are exact, others nearly; between them trilinear interpolation adds its own. */
static void check_mesh_grid(const scree_shape* shape, int points) {
  random_stream r = {8};
  scree_support* support = one_shape(shape);
  const support_mesh* g = support->meshes[0];
  double step = (double)g->step;
  int by_surface = 0, inside = 0;
  for (int i = 0; i < points; ++i) {
    uint32_t c[3];
    double p[3], q[3], winding;
    for (int a = 0; a < 3; ++a) {
      c[a] = random_below(&r, g->size[a]);
      p[a] = g->middle[a] + (double)g->low[a] + c[a] * step;
      q[a] = (double)(float)(p[a] + random_in(&r, -0.5, 0.5) * step);
    }
    double truth = brute_mesh(shape, p, &winding);
    double found = (double)g->quantum * (int16_t)(g->samples[((size_t)c[2] * g->size[1] + c[1]) * g->size[0] + c[0]] & 0xffff);
    bool near = truth < 1.7 * step;
    by_surface += near;
    inside += winding > 0.5;
    if (truth > 0.51 * (double)g->quantum) assert_true((found < 0) == (winding > 0.5));
    assert_true(fabs(fabs(found) - truth) <= (near ? 1e-5 : 0.25) * step + 0.51 * (double)g->quantum);
    double anywhere = brute_mesh(shape, q, &winding) * (winding > 0.5 ? -1 : 1);
    assert_true(fabs(distance_at(support, q) - anywhere) <= 0.9 * step);
  }
  assert_true(by_surface > points / 50 && inside > points / 50);
  scree_support_destroy(support);
}

static void mesh_grid_is_the_signed_distance_of_a_knot(void** state) {
  (void)state;
  float positions[3 * TUBE_RINGS * TUBE_SIDES];
  uint32_t indices[6 * TUBE_RINGS * TUBE_SIDES];
  scree_shape shape = knot(positions, indices);
  check_mesh_grid(&shape, 1500);
}

/* The walk takes a brick's own bound for parts within MESH_BRICK cells of a point in it. */
static void mesh_distance_keeps_the_bounds_of_its_bricks(void** state) {
  (void)state;
  float positions[3 * TUBE_RINGS * TUBE_SIDES];
  uint32_t indices[6 * TUBE_RINGS * TUBE_SIDES];
  scree_shape shape = knot(positions, indices);
  scree_support* support = one_shape(&shape);
  const support_mesh* g = support->meshes[0];
  random_stream r = {12};
  int smooth = 0;
  for (int i = 0; i < 20000; ++i) {
    double p[3], q[3], apart = 0, step = (double)g->step, reach = random_below(&r, 2) ? 0.5 : 4.5;
    uint32_t brick[3];
    for (int a = 0; a < 3; ++a) {
      double cell = random_in(&r, 0, g->size[a] - 1);
      brick[a] = (uint32_t)cell / MESH_BRICK;
      p[a] = (double)(float)(g->middle[a] + (double)g->low[a] + cell * step);
      q[a] = (double)(float)(p[a] + random_in(&r, -reach, reach) * step);
      apart += (p[a] - q[a]) * (p[a] - q[a]);
    }
    double bound = (double)g->brick_lipschitz[(brick[2] * g->bricks[1] + brick[1]) * g->bricks[0] + brick[0]];
    assert_true(bound >= 1 && bound <= (double)g->lipschitz);
    assert_true(fabs(distance_at(support, p) - distance_at(support, q)) <= bound * sqrt(apart) + 1e-5);
    smooth += bound < 0.9 * (double)g->lipschitz;
  }
  assert_true(smooth > 100); /* or bricks would be for nothing */
  scree_support_destroy(support);
}

static void mesh_grid_is_the_signed_distance_of_a_square_ring(void** state) {
  (void)state;
  random_stream r = {9};
  random_support s;
  for (int round = 0; round < 6; ++round) {
    random_leaf(&s, &r, SCREE_SHAPE_MESH, 10);
    memset(&s.shapes[0].transform, 0, sizeof s.shapes[0].transform);
    check_mesh_grid(&s.shapes[0], 1000);
  }
}

/* Faces and edges that lie exactly in rows of samples, where crossings are easily counted twice or not at all. */
static void mesh_signs_survive_faces_in_the_planes_of_the_grid(void** state) {
  (void)state;
  float positions[24];
  for (int v = 0; v < 8; ++v)
    for (int a = 0; a < 3; ++a) positions[3 * v + a] = (v >> a & 1) ? 8.0f : 0.0f;
  const uint32_t indices[36] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
  scree_shape cube = {.kind = SCREE_SHAPE_MESH, .mesh = {positions, indices, 8, 12, 8}};
  scree_support* support = one_shape(&cube);
  for (double x = -3.5; x < 12; x += 1)
    for (double y = -3.5; y < 12; y += 1)
      for (double z = -3.5; z < 12; z += 1) {
        bool inside = x > 0 && x < 8 && y > 0 && y < 8 && z > 0 && z < 8;
        assert_true((distance_at(support, (double[]){x, y, z}) < 0) == inside);
      }
  scree_support_destroy(support);
}

static void run_backwards(void* user, uint32_t count, void (*run)(void* context, uint32_t index, uint32_t worker), void* context) {
  ++*(int*)user;
  for (uint32_t i = count; i-- > 0;) run(context, i, i % 3);
}

static void every_worker_builds_the_same_mesh_grid(void** state) {
  (void)state;
  float positions[3 * TUBE_RINGS * TUBE_SIDES];
  uint32_t indices[6 * TUBE_RINGS * TUBE_SIDES];
  scree_shape shape = knot(positions, indices);
  int calls = 0;
  scree_support* serial = one_shape(&shape);
  scree_support* shared =
      must_create(&(scree_support_desc){.shapes = &shape, .shape_count = 1, .jobs = {run_backwards, 3, &calls}});
  const support_mesh *a = serial->meshes[0], *b = shared->meshes[0];
  assert_true(calls > 0);
  assert_memory_equal(a->size, b->size, sizeof a->size);
  assert_memory_equal(a->samples, b->samples, sizeof *a->samples * a->size[0] * a->size[1] * a->size[2]);
  scree_support_destroy(serial);
  scree_support_destroy(shared);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(round_shapes_have_their_true_distance),
      cmocka_unit_test(heightfield_is_a_layer_between_two_surfaces),
      cmocka_unit_test(one_cliff_does_not_thicken_a_layer_elsewhere),
      cmocka_unit_test(groups_combine_the_distances_of_their_children),
      cmocka_unit_test(transforms_of_groups_reach_their_children),
      cmocka_unit_test(no_distance_changes_faster_than_its_bound),
      cmocka_unit_test(distances_do_not_depend_on_the_company_of_a_point),
      cmocka_unit_test(nothing_of_a_support_lies_outside_its_bounds),
      cmocka_unit_test(mesh_grid_is_the_signed_distance_of_a_knot),
      cmocka_unit_test(mesh_distance_keeps_the_bounds_of_its_bricks),
      cmocka_unit_test(mesh_grid_is_the_signed_distance_of_a_square_ring),
      cmocka_unit_test(mesh_signs_survive_faces_in_the_planes_of_the_grid),
      cmocka_unit_test(every_worker_builds_the_same_mesh_grid),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
