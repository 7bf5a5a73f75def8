#include "support_leaf.h"

#include <math.h>

void scree_rt_support_to_root(const support_frame* f, const double p[3], double out[3]) {
  for (int r = 0; r < 3; ++r)
    out[r] = f->origin[r] + f->scale * (f->turn[r][0] * p[0] + f->turn[r][1] * p[1] + f->turn[r][2] * p[2]);
}

static bool is_turned(const support_frame* f) {
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      if (f->turn[r][c] != (r == c ? 1.0 : 0.0)) return true;
  return false;
}

static void to_floats(float out[3], const double in[3]) {
  for (int a = 0; a < 3; ++a) out[a] = (float)in[a];
}

op_frame scree_rt_support_op_frame(const support_frame* f, bool scaled) {
  op_frame out;
  to_floats(out.centre, f->origin);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) out.rows[r][c] = (float)(scaled ? f->turn[c][r] : f->turn[c][r] / f->scale);
  out.scale = scaled ? 1.0f : (float)f->scale;
  return out;
}

void scree_rt_support_set_bounds(support_op* op, const support_frame* f, const double low[3], const double high[3]) {
  for (int r = 0; r < 3; ++r) {
    op->min[r] = op->max[r] = f->origin[r];
    for (int c = 0; c < 3; ++c) {
      double t = f->turn[r][c] * f->scale;
      if (t == 0) continue; /* times infinity */
      op->min[r] += t * (t > 0 ? low[c] : high[c]);
      op->max[r] += t * (t > 0 ? high[c] : low[c]);
    }
  }
}

/* Grows the root's box to a disc or ball: centre, radius and the unit normal of a disc (NULL for a ball). */
static void add_disc(support_op* op, bool first, const double centre[3], double radius, const double normal[3]) {
  for (int a = 0; a < 3; ++a) {
    double flat = normal == NULL ? 1.0 : 1 - normal[a] * normal[a];
    double reach = radius * sqrt(flat > 0 ? flat : 0);
    if (first || centre[a] - reach < op->min[a]) op->min[a] = centre[a] - reach;
    if (first || centre[a] + reach > op->max[a]) op->max[a] = centre[a] + reach;
  }
}

static void compile_sphere(support_op* op, const scree_shape* s, const support_frame* f) {
  op->kind = OP_SPHERE;
  to_floats(op->sphere.centre, f->origin);
  op->sphere.radius = (float)((double)s->sphere.radius * f->scale);
  add_disc(op, true, f->origin, (double)s->sphere.radius * f->scale, NULL);
}

static void compile_capsule(support_op* op, const scree_shape* s, const support_frame* f) {
  double a[3], b[3], ends[2][3], length2 = 0;
  for (int k = 0; k < 3; ++k) {
    ends[0][k] = (double)s->capsule.a[k];
    ends[1][k] = (double)s->capsule.b[k];
  }
  scree_rt_support_to_root(f, ends[0], a);
  scree_rt_support_to_root(f, ends[1], b);
  double radius = (double)s->capsule.radius * f->scale;
  for (int k = 0; k < 3; ++k) length2 += (b[k] - a[k]) * (b[k] - a[k]);
  op->kind = OP_CAPSULE;
  to_floats(op->capsule.a, a);
  for (int k = 0; k < 3; ++k) op->capsule.ab[k] = (float)(b[k] - a[k]);
  op->capsule.inverse_length2 = length2 > 1e-30 ? (float)(1 / length2) : 0.0f; /* a point: the capsule is a sphere */
  op->capsule.radius = (float)radius;
  add_disc(op, true, a, radius, NULL);
  add_disc(op, false, b, radius, NULL);
}

static void axis_of(const support_frame* f, double axis[3]) {
  for (int a = 0; a < 3; ++a) axis[a] = f->turn[a][1];
}

static void compile_round(support_op* op, const scree_shape* s, const support_frame* f) {
  double axis[3], top[3], bottom[3];
  bool cone = s->kind == SCREE_SHAPE_CONE;
  double radius = f->scale * (double)(cone ? s->cone.radius : s->cylinder.radius);
  double height = f->scale * (double)(cone ? s->cone.height : s->cylinder.half_height);
  axis_of(f, axis);
  for (int a = 0; a < 3; ++a) {
    top[a] = f->origin[a] + height * axis[a];
    bottom[a] = f->origin[a] - height * axis[a];
  }
  if (cone) {
    op->kind = OP_CONE;
    to_floats(op->cone.base, f->origin);
    to_floats(op->cone.axis, axis);
    op->cone.radius = (float)radius;
    op->cone.height = (float)height;
    op->cone.inverse_side2 = (float)(1 / (radius * radius + height * height));
    add_disc(op, true, f->origin, radius, axis);
    add_disc(op, false, top, 0, NULL);
  } else {
    op->kind = OP_CYLINDER;
    to_floats(op->cylinder.centre, f->origin);
    to_floats(op->cylinder.axis, axis);
    op->cylinder.radius = (float)radius;
    op->cylinder.half_height = (float)height;
    add_disc(op, true, top, radius, axis);
    add_disc(op, false, bottom, radius, axis);
  }
}

static void compile_torus(support_op* op, const scree_shape* s, const support_frame* f) {
  double axis[3], tube = (double)s->torus.tube_radius * f->scale;
  axis_of(f, axis);
  op->kind = OP_TORUS;
  to_floats(op->torus.centre, f->origin);
  to_floats(op->torus.axis, axis);
  op->torus.radius = (float)((double)s->torus.radius * f->scale);
  op->torus.tube_radius = (float)tube;
  add_disc(op, true, f->origin, (double)s->torus.radius * f->scale, axis);
  for (int a = 0; a < 3; ++a) {
    op->min[a] -= tube;
    op->max[a] += tube;
  }
}

static void compile_box(support_op* op, const scree_shape* s, const support_frame* f) {
  double low[3], high[3];
  op->kind = is_turned(f) ? OP_BOX_TURNED : OP_BOX;
  op->box.frame = scree_rt_support_op_frame(f, true);
  op->box.rounding = (float)((double)s->box.rounding * f->scale);
  for (int a = 0; a < 3; ++a) {
    high[a] = (double)s->box.half[a];
    low[a] = -high[a];
    op->box.core[a] = (float)((high[a] - (double)s->box.rounding) * f->scale);
  }
  scree_rt_support_set_bounds(op, f, low, high);
}

static void compile_ellipsoid(support_op* op, const scree_shape* s, const support_frame* f) {
  double r[3], largest = 0, smallest = 1;
  for (int a = 0; a < 3; ++a)
    if ((double)s->ellipsoid.radii[a] > largest) largest = (double)s->ellipsoid.radii[a];
  for (int a = 0; a < 3; ++a) {
    r[a] = (double)s->ellipsoid.radii[a] / largest;
    if (r[a] < smallest) smallest = r[a];
  }
  support_frame unit = *f;
  unit.scale *= largest;
  op->kind = OP_ELLIPSOID;
  op->ellipsoid.frame = scree_rt_support_op_frame(&unit, false);
  op->ellipsoid.smallest = (float)smallest;
  for (int a = 0; a < 3; ++a) {
    op->ellipsoid.radii[a] = (float)r[a];
    op->ellipsoid.excess[a] = (float)((r[a] - smallest) * (r[a] + smallest));
    double reach = 0; /* of the ellipsoid along the root's axis */
    for (int c = 0; c < 3; ++c) {
      double along = f->turn[a][c] * f->scale * (double)s->ellipsoid.radii[c];
      reach += along * along;
    }
    op->min[a] = f->origin[a] - sqrt(reach);
    op->max[a] = f->origin[a] + sqrt(reach);
  }
  op->doubt = (float)(2e-5 * unit.scale); /* what the last iteration leaves */
}

static void compile_half_space(support_op* op, const support_frame* f) {
  const double low[3] = {-INFINITY, -INFINITY, -INFINITY}, high[3] = {INFINITY, 0, INFINITY};
  double normal[3];
  axis_of(f, normal);
  op->kind = OP_HALF_SPACE;
  to_floats(op->plane.centre, f->origin);
  to_floats(op->plane.normal, normal);
  scree_rt_support_set_bounds(op, f, low, high);
}

static double compile_height(support_op* op, const scree_shape* s, const support_height* grid, const support_frame* f) {
  double above = (double)s->heightfield.above, below = (double)s->heightfield.below;
  op->kind = OP_HEIGHTFIELD;
  op->height.frame = scree_rt_support_op_frame(f, false);
  op->height.grid = grid;
  op->height.middle = (float)((above - below) * 0.5);
  op->height.half = (float)((above + below) * 0.5);
  const double low[3] = {-(double)grid->extent_x, (double)grid->lowest - below, -(double)grid->extent_z};
  const double high[3] = {(double)grid->extent_x, (double)grid->highest + above, (double)grid->extent_z};
  scree_rt_support_set_bounds(op, f, low, high);
  /* Its level sets grow by 1 / cosine upwards and by 1 to the sides, and so to their diagonal where it leans. */
  double steep = 1 / (double)grid->cosine;
  op->grow = is_turned(f) ? sqrt(1 + steep * steep) : steep;
  return (fabs((double)grid->lowest) + fabs((double)grid->highest) + fabs(above) + fabs(below)) * f->scale;
}

static void compile_mesh(support_op* op, const support_mesh* grid, const support_frame* f) {
  double low[3], high[3];
  op->kind = OP_MESH;
  support_frame centred = *f; /* on the grid */
  scree_rt_support_to_root(f, grid->middle, centred.origin);
  op->mesh.frame = scree_rt_support_op_frame(&centred, false);
  op->mesh.grid = grid;
  op->lipschitz = grid->lipschitz;
  for (int a = 0; a < 3; ++a) {
    low[a] = (double)grid->low[a];
    high[a] = (double)grid->high[a];
  }
  scree_rt_support_set_bounds(op, &centred, low, high);
}

static void compile_callback(support_op* op, const scree_shape* s, const support_frame* f) {
  double low[3], high[3];
  op->kind = OP_CALLBACK;
  op->callback.frame = scree_rt_support_op_frame(f, false);
  op->callback.distance = s->callback.distance;
  op->callback.user = s->callback.user;
  op->callback.lipschitz = s->callback.lipschitz == 0 ? 1.0f : s->callback.lipschitz;
  /* Outside its box the value is also held above the distance to the box, whose own bound is 1. */
  op->lipschitz = s->callback.lipschitz > 1 ? s->callback.lipschitz : 1.0f;
  for (int a = 0; a < 3; ++a) {
    op->callback.min[a] = s->callback.min[a];
    op->callback.max[a] = s->callback.max[a];
    low[a] = (double)s->callback.min[a];
    high[a] = (double)s->callback.max[a];
  }
  scree_rt_support_set_bounds(op, f, low, high);
}

static void compile_extrusion(support_op* op, const scree_shape* s, const support_frame* f, const float* table) {
  const scree_extrusion* e = &s->extrusion;
  double low[3] = {INFINITY, (double)e->low, INFINITY}, high[3] = {-INFINITY, (double)e->high, -INFINITY};
  for (uint32_t i = 0; i < e->point_count; ++i)
    for (int a = 0; a < 2; ++a) {
      double at = (double)e->points[2 * i + (uint32_t)a];
      if (at < low[2 * a]) low[2 * a] = at;
      if (at > high[2 * a]) high[2 * a] = at;
    }
  op->kind = OP_EXTRUSION;
  op->extrusion.frame = scree_rt_support_op_frame(f, false);
  op->extrusion.edges = table;
  op->extrusion.edge_count = e->point_count;
  op->extrusion.middle = (float)((high[1] + low[1]) * 0.5);
  op->extrusion.half = (float)((high[1] - low[1]) * 0.5);
  scree_rt_support_set_bounds(op, f, low, high);
}

/* The largest second derivative of the sum: 6 / R^2 of each ball, of those that reach into one another at once. */
static double blobs_curvature(const scree_blobs* b, uint32_t* crowd) {
  double most = 0;
  *crowd = 1;
  for (uint32_t i = 0; i < b->count; ++i) {
    double sum = 0;
    uint32_t reaching = 0;
    for (uint32_t k = 0; k < b->count; ++k) {
      double r = (double)b->radii[k], near = (double)b->radii[i] + r, d2 = 0;
      for (int a = 0; a < 3; ++a) {
        double d = (double)b->centres[3 * i + (uint32_t)a] - (double)b->centres[3 * k + (uint32_t)a];
        d2 += d * d;
      }
      if (d2 > near * near) continue;
      sum += 6 / (r * r);
      ++reaching;
    }
    if (sum > most) most = sum;
    if (reaching > *crowd) *crowd = reaching;
  }
  return most;
}

/* Where all influence ends, at D = 0, the sum is 1/2 below the surface's, and flat: the distance is `level` there, and no less than
 * level + D farther out. */
static void compile_blobs(support_op* op, const scree_shape* s, const support_frame* f, const float* table) {
  uint32_t crowd;
  double curvature = blobs_curvature(&s->blobs, &crowd) * 1.0001, level = 1 / sqrt(curvature);
  op->kind = OP_BLOBS;
  op->blobs.frame = scree_rt_support_op_frame(f, false);
  op->blobs.balls = table;
  op->blobs.count = s->blobs.count;
  op->blobs.curvature = (float)curvature;
  op->blobs.level = (float)level;
  /* Where the sum is flat just at the surface's value, the square root makes much of its rounding. */
  op->doubt = (float)(sqrt(6e-7 * (2 + crowd)) * level * f->scale);
  for (uint32_t i = 0; i < s->blobs.count; ++i) {
    double own[3], centre[3];
    for (uint32_t a = 0; a < 3; ++a) own[a] = (double)s->blobs.centres[3 * i + a];
    scree_rt_support_to_root(f, own, centre);
    add_disc(op, i == 0, centre, ((double)s->blobs.radii[i] - level) * f->scale, NULL);
  }
}

static double compile_pattern(support_op* op, const scree_shape* s, const support_frame* f) {
  const scree_pattern* p = &s->pattern;
  static const op_kind kinds[] = {OP_LINES, OP_RINGS, OP_WAVES};
  double spacing = (double)p->spacing * f->scale, radius = (double)p->radius * f->scale;
  op->kind = kinds[p->kind];
  op->pattern.frame = scree_rt_support_op_frame(f, true);
  op->pattern.spacing = (float)spacing;
  op->pattern.inverse_spacing = (float)(1 / spacing);
  op->pattern.radius = (float)radius;
  double magnitude = spacing + radius;
  if (p->kind == SCREE_PATTERN_WAVES) {
    double amplitude = (double)p->amplitude * f->scale, wavelength = (double)p->wavelength * f->scale;
    op->pattern.amplitude = (float)amplitude;
    op->pattern.inverse_wavelength = (float)(1 / wavelength);
    op->pattern.steepest = (float)(8 * amplitude / wavelength);
    op->pattern.curvature = (float)(32 * amplitude / (wavelength * wavelength));
    magnitude += amplitude + wavelength;
  }
  const double low[3] = {-INFINITY, -(double)p->radius, -INFINITY}, high[3] = {INFINITY, (double)p->radius, INFINITY};
  scree_rt_support_set_bounds(op, f, low, high);
  return magnitude;
}

double scree_rt_support_compile_leaf(support_op* op, const scree_shape* s, const support_frame* f, const support_part* part) {
  op->lipschitz = 1;
  op->grow = 1;
  switch (s->kind) {
    case SCREE_SHAPE_SPHERE: compile_sphere(op, s, f); return 0;
    case SCREE_SHAPE_BOX: compile_box(op, s, f); return 0;
    case SCREE_SHAPE_CAPSULE: compile_capsule(op, s, f); return 0;
    case SCREE_SHAPE_CYLINDER:
    case SCREE_SHAPE_CONE: compile_round(op, s, f); return 0;
    case SCREE_SHAPE_HEIGHTFIELD: return compile_height(op, s, part->height, f);
    case SCREE_SHAPE_MESH: compile_mesh(op, part->mesh, f); return 0;
    case SCREE_SHAPE_ELLIPSOID: compile_ellipsoid(op, s, f); return 0;
    case SCREE_SHAPE_HALF_SPACE: compile_half_space(op, f); return 0;
    case SCREE_SHAPE_TORUS: compile_torus(op, s, f); return 0;
    case SCREE_SHAPE_EXTRUSION: compile_extrusion(op, s, f, part->table); return 0;
    case SCREE_SHAPE_BLOBS: compile_blobs(op, s, f, part->table); return 0;
    case SCREE_SHAPE_PATTERN: return compile_pattern(op, s, f);
    default: compile_callback(op, s, f); return 0;
  }
}

/* --- tables ---------------------------------------------------------------------------------------------------------------- */

size_t scree_rt_support_table_length(const scree_shape* s) {
  if (s->kind == SCREE_SHAPE_BLOBS) return (size_t)BLOB_FLOATS * s->blobs.count;
  return s->kind == SCREE_SHAPE_EXTRUSION ? scree_rt_support_edges_length(s->extrusion.point_count) : 0;
}

size_t scree_rt_support_edges_length(size_t edges) {
  return edges * EXTRUSION_EDGE + (edges + EXTRUSION_CHUNK - 1) / EXTRUSION_CHUNK * EXTRUSION_BOX;
}

static void fill_edges(const scree_extrusion* e, float* table) {
  for (uint32_t first = 0; first < e->point_count; first += EXTRUSION_CHUNK) {
    float* box = table; /* x from, to, z from, to, and what rounding may do to squared distances */
    table += EXTRUSION_BOX;
    for (uint32_t i = first; i < first + EXTRUSION_CHUNK && i < e->point_count; ++i, table += EXTRUSION_EDGE) {
      const float *a = e->points + 2 * i, *b = e->points + 2 * (i + 1 < e->point_count ? i + 1 : 0);
      double ex = (double)b[0] - (double)a[0], ez = (double)b[1] - (double)a[1], length2 = ex * ex + ez * ez;
      table[0] = a[0];
      table[1] = a[1];
      table[2] = (float)ex;
      table[3] = (float)ez;
      table[4] = length2 > 1e-30 ? (float)(1 / length2) : 0.0f;
      table[5] = b[1];
      for (int k = 0; k < 2; ++k) {
        float from = a[k] < b[k] ? a[k] : b[k], to = a[k] < b[k] ? b[k] : a[k];
        if (i == first || from < box[2 * k]) box[2 * k] = from;
        if (i == first || to > box[2 * k + 1]) box[2 * k + 1] = to;
      }
    }
    float x = box[1] - box[0], z = box[3] - box[2];
    box[4] = (x * x + z * z) * 1e-8f;
  }
}

void scree_rt_support_table_fill(const scree_shape* s, float* table) {
  if (s->kind == SCREE_SHAPE_EXTRUSION) fill_edges(&s->extrusion, table);
  if (s->kind != SCREE_SHAPE_BLOBS) return;
  for (uint32_t i = 0; i < s->blobs.count; ++i, table += BLOB_FLOATS) {
    for (uint32_t a = 0; a < 3; ++a) table[a] = s->blobs.centres[3 * i + a];
    table[3] = (float)(1 / ((double)s->blobs.radii[i] * (double)s->blobs.radii[i]));
    table[4] = s->blobs.radii[i];
  }
}
