/* Distances of the later leaves, as static functions: included by support_kernel.h. Each changes by at most s over a way of s, so
 * none is larger than the way to its surface, and near the surface each has a slope of 1. */
#ifndef SCREE_SUPPORT_SHAPES_KERNEL_H
#define SCREE_SUPPORT_SHAPES_KERNEL_H

#include "support_vectors.h"

/* The distance to a convex body is the largest of n.p - h(n) over unit normals n, where h is how far the body reaches along n: with
 * a normal that is nearly right it is too small by the square of the error, and never too large. The normal at the nearest point is
 * p / (t + r^2) for the t that brings that point onto the surface. Based on: Eberly, Distance from a Point to an Ellipse, an
 * Ellipsoid, or a Hyperellipsoid, 2013, for the equation; More and Sorensen, Computing a Trust Region Step, 1983, for solving it.
 * s is t + the smallest r^2; ten steps leave 1e-5 of the largest radius at radii of 1 : 1000. */
static inline vfloat distance_ellipsoid(const support_op* op, vpoint p) {
  enum { STEPS = 10 };
  vpoint q = into_frame(&op->ellipsoid.frame, p);
  const vfloat at[3] = {v_abs(q.x), v_abs(q.y), v_abs(q.z)};
  vfloat y[3], pull[3], s = v_set(0), largest = v_set(0), length2 = v_set(0), reach2 = v_set(0), along = v_set(0);
  for (int a = 0; a < 3; ++a) {
    const vfloat radius = v_set(op->ellipsoid.radii[a]);
    /* Off the plane through the middle, where the equation loses its root; only the normal notices. */
    y[a] = op->ellipsoid.excess[a] == 0 ? v_max(at[a], v_set(op->ellipsoid.smallest * 1e-5f)) : at[a];
    pull[a] = radius * y[a];
    s = v_max(s, pull[a] - v_set(op->ellipsoid.excess[a]));
    if (op->ellipsoid.excess[a] > 0) largest = v_max(largest, v_set(op->ellipsoid.excess[a]));
  }
  s = v_max(s, v_sqrt(pull[0] * pull[0] + pull[1] * pull[1] + pull[2] * pull[2]) - largest);
  for (int step = 0; step < STEPS; ++step) {
    vfloat norm2 = v_set(0), slope = v_set(0);
    for (int a = 0; a < 3; ++a) {
      vfloat share = v_set(1) / (s + v_set(op->ellipsoid.excess[a])), v = pull[a] * share;
      norm2 += v * v;
      slope += v * v * share;
    }
    s += (v_sqrt(norm2) - v_set(1)) * norm2 / slope;
  }
  for (int a = 0; a < 3; ++a) {
    vfloat n = y[a] / (s + v_set(op->ellipsoid.excess[a])), r = v_set(op->ellipsoid.radii[a]) * n;
    length2 += n * n;
    reach2 += r * r;
    along += n * at[a];
  }
  return (along - v_sqrt(reach2)) / v_sqrt(length2) * v_set(op->ellipsoid.frame.scale);
}

static inline vfloat distance_half_space(const support_op* op, vpoint p) {
  vpoint q = minus(p, op->plane.centre);
  return dot3(q.x, q.y, q.z, op->plane.normal);
}

static inline vfloat distance_torus(const support_op* op, vpoint p) {
  vfloat height, r = off_axis(minus(p, op->torus.centre), op->torus.axis, &height);
  return length2(r - v_set(op->torus.radius), height) - v_set(op->torus.tube_radius);
}

/* A box in two distances that are at right angles. */
static inline vfloat distance_cut(vfloat a, vfloat b) {
  const vfloat zero = v_set(0);
  return length2(v_max(a, zero), v_max(b, zero)) + v_min(v_max(a, b), zero);
}

/* The nearest edge, and even or odd crossings of the ray along +x. Chunks of edges that are farther away than what was found, and
 * beside the ray, are left out; that changes no bit. */
static inline vfloat distance_polygon(const float* table, uint32_t count, vfloat x, vfloat z) {
  const vfloat zero = v_set(0);
  vfloat best = v_set(3e38f);
  vint odd = v_set_int(0);
  for (uint32_t first = 0; first < count; first += EXTRUSION_CHUNK) {
    const float* box = table;
    uint32_t edges = count - first < EXTRUSION_CHUNK ? count - first : EXTRUSION_CHUNK;
    const float* edge = table + EXTRUSION_BOX;
    table = edge + edges * EXTRUSION_EDGE;
    vfloat dx = v_max(v_max(v_set(box[0]) - x, x - v_set(box[1])), zero);
    vfloat dz = v_max(v_max(v_set(box[2]) - z, z - v_set(box[3])), zero);
    vint near = (dx * dx + dz * dz) * v_set(0.95f) <= best + v_set(box[4]);
    vint beside = (z < v_set(box[2])) | (z > v_set(box[3])) | (x > v_set(box[1]));
    if (v_bits(near | ~beside) == 0) continue;
    for (uint32_t i = 0; i < edges; ++i, edge += EXTRUSION_EDGE) {
      const vfloat ex = v_set(edge[2]), ez = v_set(edge[3]);
      vfloat px = x - v_set(edge[0]), pz = z - v_set(edge[1]);
      vfloat t = v_clamp((px * ex + pz * ez) * v_set(edge[4]), zero, v_set(1));
      vfloat qx = px - t * ex, qz = pz - t * ez;
      best = v_min(best, qx * qx + qz * qz);
      vint spans = (v_set(edge[1]) <= z) ^ (v_set(edge[5]) <= z);
      vfloat side = ex * pz - ez * px;
      odd ^= spans & (edge[3] > 0 ? side > zero : side < zero);
    }
  }
  vfloat d = v_sqrt(best);
  return v_select(odd, -d, d);
}

static inline vfloat distance_extrusion(const support_op* op, vpoint p) {
  vpoint q = into_frame(&op->extrusion.frame, p);
  vfloat side = distance_polygon(op->extrusion.edges, op->extrusion.edge_count, q.x, q.z);
  vfloat above = v_abs(q.y - v_set(op->extrusion.middle)) - v_set(op->extrusion.half);
  return distance_cut(side, above) * v_set(op->extrusion.frame.scale);
}

/* The nearest of all balls along the axis, whose radii shrink by `taper` a metre: the one whose surface is met at a right angle
 * lies `lean` metres before the foot of the point for each metre beside the axis. */
static inline vfloat distance_taper(vfloat along, vfloat beside, float length, float radius, float taper, float lean) {
  vfloat foot = v_clamp(along - beside * v_set(lean), v_set(0), v_set(length));
  return length2(beside, along - foot) - (v_set(radius) - foot * v_set(taper));
}

static inline vfloat distance_pipe(const support_op* op, vpoint p) {
  vfloat along, beside = off_axis(minus(p, op->pipe.a), op->pipe.axis, &along);
  return distance_taper(along, beside, op->pipe.length, op->pipe.radius, op->pipe.taper, op->pipe.lean);
}

static inline vfloat distance_band(const support_op* op, vpoint p) {
  vpoint q = into_frame(&op->band.frame, p);
  const vfloat ax = v_set(op->band.axis[0]), az = v_set(op->band.axis[1]);
  vfloat along = q.x * ax + q.z * az, beside = v_abs(q.z * ax - q.x * az);
  vfloat side = distance_taper(along, beside, op->band.length, op->band.radius, op->band.taper, op->band.lean);
  vfloat middle = v_clamp(along, v_set(0), v_set(op->band.length)) * v_set(op->band.slope);
  vfloat above = (v_abs(q.y - middle) - v_set(op->band.half_height)) * v_set(op->band.cosine);
  vfloat d = distance_cut(side, above);
  return v_select(d > v_set(0), d * v_set(op->band.shrink), d);
}

/* How far a value `c` away from its surface's is at least, where the slope is g and changes by no more than m a metre: the root of
 * g s + m s^2 / 2 = |c|. It has the slope 1 at the surface and none more than that, since g itself changes by no more than m. */
static inline vfloat distance_by_slope(vfloat c, vfloat g, vfloat m) {
  vfloat root = v_sqrt(g * g + (m + m) * v_abs(c));
  return (c + c) / v_max(g + root, v_set(1e-30f));
}

static inline vfloat distance_blobs(const support_op* op, vpoint p) {
  const vfloat zero = v_set(0), one = v_set(1);
  vpoint q = into_frame(&op->blobs.frame, p);
  vfloat sum = zero, gx = zero, gy = zero, gz = zero, share = v_set(-1); /* share > 0: within some ball */
  const float* ball = op->blobs.balls;
  for (uint32_t i = 0; i < op->blobs.count; ++i, ball += BLOB_FLOATS) {
    vpoint r = minus(q, ball);
    vfloat k = one - (r.x * r.x + r.y * r.y + r.z * r.z) * v_set(ball[3]);
    share = v_max(share, k);
    k = v_max(k, zero);
    vfloat pull = k * k * v_set(6 * ball[3]);
    sum += k * k * k;
    gx += pull * r.x;
    gy += pull * r.y;
    gz += pull * r.z;
  }
  vfloat d = distance_by_slope(v_set(0.5f) - sum, length3(gx, gy, gz), v_set(op->blobs.curvature));
  if (v_bits(share <= zero) != 0) {
    vfloat nearest = v_set(3e38f);
    ball = op->blobs.balls;
    for (uint32_t i = 0; i < op->blobs.count; ++i, ball += BLOB_FLOATS) {
      vpoint r = minus(q, ball);
      nearest = v_min(nearest, length3(r.x, r.y, r.z) - v_set(ball[4]));
    }
    d = v_select(share <= zero, v_set(op->blobs.level) + v_max(nearest, zero), d);
  }
  return d * v_set(op->blobs.frame.scale);
}

static inline vfloat distance_lines(const support_op* op, vpoint p) {
  vpoint q = into_frame(&op->pattern.frame, p);
  vfloat k = v_floor(q.x * v_set(op->pattern.inverse_spacing) + v_set(0.5f));
  return length2(q.x - k * v_set(op->pattern.spacing), q.y) - v_set(op->pattern.radius);
}

static inline vfloat distance_rings(const support_op* op, vpoint p) {
  vpoint q = into_frame(&op->pattern.frame, p);
  vfloat r = length2(q.x, q.z), k = v_floor(r * v_set(op->pattern.inverse_spacing)) + v_set(0.5f);
  return length2(r - k * v_set(op->pattern.spacing), q.y) - v_set(op->pattern.radius);
}

/* The swing is made of parabolas, 16 u (1/2 - u) over half a wavelength, which look like a sine and need no more than +, - and *.
 */
static inline vfloat distance_waves(const support_op* op, vpoint p) {
  vpoint q = into_frame(&op->pattern.frame, p);
  const vfloat half = v_set(0.5f);
  vfloat u = q.z * v_set(op->pattern.inverse_wavelength);
  u -= v_floor(u);
  vint back = u >= half;
  u = v_select(back, u - half, u);
  vfloat swing = v_set(16) * u * (half - u), slope = v_abs(half - (u + u)) * v_set(2 * op->pattern.steepest);
  vfloat x = q.x - v_select(back, -swing, swing) * v_set(op->pattern.amplitude);
  vfloat k = v_floor(x * v_set(op->pattern.inverse_spacing) + half);
  vfloat side = v_abs(x - k * v_set(op->pattern.spacing));
  side = distance_by_slope(side, v_sqrt(v_set(1) + slope * slope), v_set(op->pattern.curvature));
  return length2(side, q.y) - v_set(op->pattern.radius);
}

#endif
