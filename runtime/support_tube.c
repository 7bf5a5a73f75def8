/* Tubes: a centripetal Catmull-Rom curve cut into straight pieces.
 * Based on: Barry and Goldman, A Recursive Evaluation Algorithm for a Class of Catmull-Rom Splines, 1988; Yuksel, Schaefer and
 * Keyser, On the Parameterization of Catmull-Rom Curves, 2009: the centripetal one has no cusps and no loops within a span. */
#include <math.h>

#include "support_leaf.h"

static uint32_t spans(const scree_tube* t) {
  return t->closed ? t->point_count : t->point_count - 1;
}

static uint32_t pieces_of_span(const scree_tube* t) {
  return t->subdivisions == 0 ? 8 : t->subdivisions;
}

uint32_t scree_rt_support_piece_count(const scree_tube* t) {
  return spans(t) * pieces_of_span(t);
}

/* Point `index` of the curve, also the one before the first and the one after the last: of an open curve, the end's neighbour
 * mirrored at the end. */
static void control(const scree_tube* t, int64_t index, double out[3]) {
  int64_t n = t->point_count;
  if (t->closed) index = (index + n) % n;
  int64_t end = index < 0 ? 0 : index >= n ? n - 1 : index, mirrored = index < 0 ? 1 : n - 2;
  for (int a = 0; a < 3; ++a) {
    out[a] = (double)t->points[3 * end + a];
    if (index != end) out[a] = 2 * out[a] - (double)t->points[3 * mirrored + a];
  }
}

static double knot(const double a[3], const double b[3]) {
  double d2 = 0;
  for (int k = 0; k < 3; ++k) d2 += (b[k] - a[k]) * (b[k] - a[k]);
  return sqrt(sqrt(d2));
}

static void curve_point(const scree_tube* t, uint32_t index, double out[3], double* radius) {
  uint32_t per_span = pieces_of_span(t), span = index / per_span, step = index % per_span;
  if (span == spans(t)) { /* the curve's end */
    --span;
    step = per_span;
  }
  uint32_t next = span + 1 < t->point_count ? span + 1 : 0;
  double u = (double)step / per_span;
  *radius = (double)t->radii[span] + u * ((double)t->radii[next] - (double)t->radii[span]);
  double p[4][3];
  for (int k = 0; k < 4; ++k) control(t, (int64_t)span + k - 1, p[k]);
  for (int a = 0; a < 3; ++a) out[a] = p[step == 0 ? 1 : 2][a];
  if (step == 0 || step == per_span) return; /* runs through its points to the bit */
  double k0 = -knot(p[0], p[1]), k2 = knot(p[1], p[2]), k3 = k2 + knot(p[2], p[3]), at = u * k2;
  for (int a = 0; a < 3; ++a) {
    double a1 = p[0][a] + (at - k0) / -k0 * (p[1][a] - p[0][a]), a2 = p[1][a] + u * (p[2][a] - p[1][a]);
    double a3 = p[2][a] + (at - k2) / (k3 - k2) * (p[3][a] - p[2][a]);
    double b1 = a1 + (at - k0) / (k2 - k0) * (a2 - a1), b2 = a2 + at / k3 * (a3 - a2);
    out[a] = b1 + u * (b2 - b1);
  }
}

void scree_rt_support_piece(const scree_tube* t, uint32_t index, support_piece* out) {
  curve_point(t, index, out->ends[0], &out->radii[0]);
  curve_point(t, index + 1, out->ends[1], &out->radii[1]);
}

/* A ball or disc that shrinks by `taper` a metre over `length` metres; where the second one lies in the first or the other way
 * round, the larger stands for both. Returns which end the axis starts from. */
static int taper_of(double length, const double radii[2], double* taper, double* lean) {
  *taper = *lean = 0;
  if (!(fabs(radii[0] - radii[1]) < 0.9999 * length)) return radii[0] >= radii[1] ? 0 : 1;
  *taper = (radii[0] - radii[1]) / length;
  *lean = *taper / sqrt(1 - *taper * *taper);
  return 0;
}

static void compile_pipe(support_op* op, const support_piece* piece, const support_frame* f) {
  double ends[2][3], radii[2], axis[3], length2 = 0, taper, lean;
  for (int e = 0; e < 2; ++e) {
    scree_rt_support_to_root(f, piece->ends[e], ends[e]);
    radii[e] = piece->radii[e] * f->scale;
  }
  for (int a = 0; a < 3; ++a) {
    axis[a] = ends[1][a] - ends[0][a];
    length2 += axis[a] * axis[a];
  }
  double length = sqrt(length2);
  int start = taper_of(length, radii, &taper, &lean);
  if (taper == 0 && radii[0] != radii[1]) length = 0;
  op->kind = OP_PIPE;
  for (int a = 0; a < 3; ++a) {
    op->pipe.a[a] = (float)ends[start][a];
    op->pipe.axis[a] = length > 0 ? (float)(axis[a] / length) : 0.0f;
    op->min[a] = op->max[a] = ends[start][a];
    for (int e = 0; e < 2; ++e) {
      if (ends[e][a] - radii[e] < op->min[a]) op->min[a] = ends[e][a] - radii[e];
      if (ends[e][a] + radii[e] > op->max[a]) op->max[a] = ends[e][a] + radii[e];
    }
  }
  op->pipe.length = (float)length;
  op->pipe.radius = (float)radii[start];
  op->pipe.taper = (float)taper;
  op->pipe.lean = (float)lean;
}

/* Seen from above a pipe in the plane; up and down a wall that follows the curve's slope. Each is a distance by itself, and they
 * are at right angles but where the piece both tapers and climbs: `shrink` makes up for that. */
static void compile_band(support_op* op, const support_piece* piece, double half_height, const support_frame* f) {
  double ends[2][3], radii[2], taper, lean;
  for (int e = 0; e < 2; ++e) {
    for (int a = 0; a < 3; ++a) ends[e][a] = piece->ends[e][a];
    radii[e] = piece->radii[e] * f->scale;
  }
  double x = (ends[1][0] - ends[0][0]) * f->scale, z = (ends[1][2] - ends[0][2]) * f->scale, length = sqrt(x * x + z * z);
  double rise = (ends[1][1] - ends[0][1]) * f->scale, half = half_height * f->scale;
  int start = taper_of(length, radii, &taper, &lean);
  double from[3] = {ends[start][0], ends[start][1], ends[start][2]}, slope = 0;
  if (length < 1e-6 * (radii[0] + radii[1]) || (taper == 0 && radii[0] != radii[1])) {
    /* Upright, or one disc in the other: as high as both. */
    from[1] = (ends[0][1] + ends[1][1]) * 0.5;
    half += fabs(rise) * 0.5;
    if (radii[1] > radii[start]) start = 1;
    length = taper = lean = 0;
  } else {
    slope = rise / length;
  }
  support_frame own = *f;
  scree_rt_support_to_root(f, from, own.origin);
  double cosine = 1 / sqrt(1 + slope * slope), shrink = 1 / sqrt(1 + fabs(slope) * cosine * fabs(taper));
  op->kind = OP_BAND;
  op->band.frame = scree_rt_support_op_frame(&own, true);
  op->band.axis[0] = length > 0 ? (float)(x / length) : 1.0f;
  op->band.axis[1] = length > 0 ? (float)(z / length) : 0.0f;
  op->band.length = (float)length;
  op->band.radius = (float)radii[start];
  op->band.taper = (float)taper;
  op->band.lean = (float)lean;
  op->band.slope = (float)slope;
  op->band.half_height = (float)half;
  op->band.cosine = (float)cosine;
  op->band.shrink = (float)shrink;
  op->grow = 1 / (cosine * shrink);
  double low[3], high[3], reach = radii[0] > radii[1] ? radii[0] : radii[1];
  const double to[3] = {length > 0 ? x : 0, slope * length, length > 0 ? z : 0};
  for (int a = 0; a < 3; ++a) { /* set_bounds scales */
    double room = a == 1 ? half : reach;
    low[a] = ((to[a] < 0 ? to[a] : 0) - room) / f->scale;
    high[a] = ((to[a] > 0 ? to[a] : 0) + room) / f->scale;
  }
  scree_rt_support_set_bounds(op, &own, low, high);
}

void scree_rt_support_compile_piece(support_op* op, const support_piece* piece, double half_height, const support_frame* f) {
  op->lipschitz = 1;
  op->grow = 1;
  if (half_height > 0)
    compile_band(op, piece, half_height, f);
  else
    compile_pipe(op, piece, f);
}
