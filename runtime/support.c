/* Compiles a tree of shapes into a program (support_program.h). */
#include <math.h>
#include <string.h>

#include "allocator.h"
#include "support_program.h"
#include "support_text.h"

/* From a shape's own space to the root's. */
typedef struct frame {
  double origin[3];
  double turn[3][3]; /* columns are the shape's axes */
  double scale;
} frame;

/* Which values matter to the root, see support_op; and how far smooth unions above let a surface swell. */
typedef struct context {
  bool flipped;
  double slack_low, slack_high, swell;
} context;

typedef struct compiler {
  const scree_support_desc* desc;
  scree_support* support;
  const uint32_t* part; /* of each shape: the index of its heightfield or mesh */
  bool too_far;         /* a shape beyond what floats carry */
  uint32_t far_shape;
} compiler;

static frame frame_of(const frame* parent, const scree_transform* t) {
  double q[4], length2 = 0;
  for (int a = 0; a < 4; ++a) {
    q[a] = (double)t->rotation[a];
    length2 += q[a] * q[a];
  }
  if (length2 == 0) {
    q[3] = 1;
  } else {
    double length = sqrt(length2);
    for (int a = 0; a < 4; ++a) q[a] /= length;
  }
  double x = q[0], y = q[1], z = q[2], w = q[3];
  const double own[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                            {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                            {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
  frame out;
  out.scale = parent->scale * (t->scale == 0 ? 1.0 : (double)t->scale);
  for (int r = 0; r < 3; ++r) {
    out.origin[r] = parent->origin[r];
    for (int c = 0; c < 3; ++c) {
      out.origin[r] += parent->turn[r][c] * (parent->scale * (double)t->translation[c]);
      out.turn[r][c] = parent->turn[r][0] * own[0][c] + parent->turn[r][1] * own[1][c] + parent->turn[r][2] * own[2][c];
    }
  }
  return out;
}

static void to_root(const frame* f, const double p[3], double out[3]) {
  for (int r = 0; r < 3; ++r)
    out[r] = f->origin[r] + f->scale * (f->turn[r][0] * p[0] + f->turn[r][1] * p[1] + f->turn[r][2] * p[2]);
}

static bool is_turned(const frame* f) {
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      if (f->turn[r][c] != (r == c ? 1.0 : 0.0)) return true;
  return false;
}

static void to_floats(float out[3], const double in[3]) {
  for (int a = 0; a < 3; ++a) out[a] = (float)in[a];
}

/* The frame of a leaf; lengths of the leaf are in the root's metres if `scaled`, in its own otherwise. */
static op_frame leaf_frame(const frame* f, bool scaled) {
  op_frame out;
  to_floats(out.centre, f->origin);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) out.rows[r][c] = (float)(scaled ? f->turn[c][r] : f->turn[c][r] / f->scale);
  out.scale = scaled ? 1.0f : (float)f->scale;
  return out;
}

/* The root's box round a box of the leaf's own space. */
static void set_bounds(support_op* op, const frame* f, const double low[3], const double high[3]) {
  double middle[3], half[3], centre[3];
  for (int a = 0; a < 3; ++a) {
    middle[a] = (low[a] + high[a]) * 0.5;
    half[a] = (high[a] - low[a]) * 0.5 * f->scale;
  }
  to_root(f, middle, centre);
  for (int r = 0; r < 3; ++r) {
    double reach = fabs(f->turn[r][0]) * half[0] + fabs(f->turn[r][1]) * half[1] + fabs(f->turn[r][2]) * half[2];
    op->min[r] = centre[r] - reach;
    op->max[r] = centre[r] + reach;
  }
}

/* The root's box round a disc or ball: centre, radius and the unit normal of a disc (NULL for a ball). */
static void add_disc(support_op* op, bool first, const double centre[3], double radius, const double normal[3]) {
  for (int a = 0; a < 3; ++a) {
    double flat = normal == NULL ? 1.0 : 1 - normal[a] * normal[a];
    double reach = radius * sqrt(flat > 0 ? flat : 0);
    if (first || centre[a] - reach < op->min[a]) op->min[a] = centre[a] - reach;
    if (first || centre[a] + reach > op->max[a]) op->max[a] = centre[a] + reach;
  }
}

static void compile_capsule(support_op* op, const scree_shape* s, const frame* f) {
  double a[3], b[3], ends[2][3], length2 = 0;
  for (int k = 0; k < 3; ++k) {
    ends[0][k] = (double)s->capsule.a[k];
    ends[1][k] = (double)s->capsule.b[k];
  }
  to_root(f, ends[0], a);
  to_root(f, ends[1], b);
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

static void compile_round(support_op* op, const scree_shape* s, const frame* f) {
  const double axis[3] = {f->turn[0][1], f->turn[1][1], f->turn[2][1]};
  bool cone = s->kind == SCREE_SHAPE_CONE;
  double radius = f->scale * (double)(cone ? s->cone.radius : s->cylinder.radius);
  double height = f->scale * (double)(cone ? s->cone.height : s->cylinder.half_height);
  double top[3], bottom[3];
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

static void compile_box(support_op* op, const scree_shape* s, const frame* f) {
  double low[3], high[3];
  op->kind = is_turned(f) ? OP_BOX_TURNED : OP_BOX;
  op->box.frame = leaf_frame(f, true);
  op->box.rounding = (float)((double)s->box.rounding * f->scale);
  for (int a = 0; a < 3; ++a) {
    high[a] = (double)s->box.half[a];
    low[a] = -high[a];
    op->box.core[a] = (float)((high[a] - (double)s->box.rounding) * f->scale);
  }
  set_bounds(op, f, low, high);
}

static double compile_height(support_op* op, const support_height* grid, const frame* f) {
  op->kind = OP_HEIGHTFIELD;
  op->height.frame = leaf_frame(f, false);
  op->height.grid = grid;
  const double low[3] = {-(double)grid->extent_x, (double)grid->lowest + (double)grid->middle - (double)grid->half,
                         -(double)grid->extent_z};
  const double high[3] = {(double)grid->extent_x, (double)grid->highest + (double)grid->middle + (double)grid->half,
                          (double)grid->extent_z};
  set_bounds(op, f, low, high);
  op->grow = 1 / (double)grid->cosine;
  return (fabs((double)grid->lowest) + fabs((double)grid->highest) + fabs((double)grid->middle) + (double)grid->half) * f->scale;
}

static void compile_mesh(support_op* op, const support_mesh* grid, const frame* f) {
  double low[3], high[3];
  op->kind = OP_MESH;
  frame centred = *f; /* on the grid */
  to_root(f, grid->middle, centred.origin);
  op->mesh.frame = leaf_frame(&centred, false);
  op->mesh.grid = grid;
  op->lipschitz = grid->lipschitz;
  for (int a = 0; a < 3; ++a) {
    low[a] = (double)grid->low[a];
    high[a] = (double)grid->high[a];
  }
  set_bounds(op, &centred, low, high);
}

static void compile_callback(support_op* op, const scree_shape* s, const frame* f) {
  double low[3], high[3];
  op->kind = OP_CALLBACK;
  op->callback.frame = leaf_frame(f, false);
  op->callback.distance = s->callback.distance;
  op->callback.user = s->callback.user;
  /* Outside its box the value is also held above the distance to the box, whose own bound is 1. */
  op->lipschitz = s->callback.lipschitz > 1 || s->callback.lipschitz == 0 ? s->callback.lipschitz : 1.0f;
  if (op->lipschitz == 0) op->lipschitz = 1;
  for (int a = 0; a < 3; ++a) {
    op->callback.min[a] = s->callback.min[a];
    op->callback.max[a] = s->callback.max[a];
    low[a] = (double)s->callback.min[a];
    high[a] = (double)s->callback.max[a];
  }
  set_bounds(op, f, low, high);
}

static void compile_leaf(compiler* c, uint32_t index, const frame* f, const context* why) {
  const scree_shape* s = &c->desc->shapes[index];
  scree_support* support = c->support;
  support_op* op = &support->ops[support->op_count++];
  double magnitude = 0;
  op->lipschitz = 1;
  op->grow = 1;
  op->flipped = why->flipped;
  op->slack_low = (float)why->slack_low;
  op->slack_high = (float)why->slack_high;
  switch (s->kind) {
    case SCREE_SHAPE_SPHERE:
      op->kind = OP_SPHERE;
      to_floats(op->sphere.centre, f->origin);
      op->sphere.radius = (float)((double)s->sphere.radius * f->scale);
      add_disc(op, true, f->origin, (double)s->sphere.radius * f->scale, NULL);
      break;
    case SCREE_SHAPE_BOX: compile_box(op, s, f); break;
    case SCREE_SHAPE_CAPSULE: compile_capsule(op, s, f); break;
    case SCREE_SHAPE_CYLINDER:
    case SCREE_SHAPE_CONE: compile_round(op, s, f); break;
    case SCREE_SHAPE_HEIGHTFIELD: magnitude = compile_height(op, &support->heights[c->part[index]], f); break;
    case SCREE_SHAPE_MESH: compile_mesh(op, &support->meshes[c->part[index]], f); break;
    default: compile_callback(op, s, f); break;
  }
  for (int a = 0; a < 3; ++a) {
    magnitude += fabs(f->origin[a]) + (op->max[a] - op->min[a]);
    if (fabs(op->min[a]) > magnitude) magnitude = fabs(op->min[a]);
    if (fabs(op->max[a]) > magnitude) magnitude = fabs(op->max[a]);
  }
  if (magnitude > support->magnitude) support->magnitude = magnitude;
  if (!(magnitude <= 1e9) && !c->too_far) {
    c->too_far = true;
    c->far_shape = index;
  }
  for (int a = 0; a < 3; ++a) { /* what rounding to floats may have moved, and the swelling of smooth unions above */
    double room = magnitude * 1e-6 + why->swell * op->grow;
    op->min[a] -= room;
    op->max[a] += room;
  }
}

/* Slack of a smooth union of n children over blend k, and how far below its smallest child it can lie.
 *
 * One step min(a, b) - h h k / 4 with h = max(k - |a - b|, 0) / k leaves the smaller side as it is, to the bit, once the sides are
 * k apart. If b > B + 1.25 k, then either a <= B + 0.25 k and is untouched, or both outcomes are > B: what b is, or whether it is
 * there, cannot matter to anyone who only asks about values <= B. In a chain of steps the outcomes with and without one child may
 * differ where both are > V = B + 2 k; a later child <= V - k makes them equal again, and without one the end is > V - 2 k = B.
 * A chain never ends below its smallest child - k, since a step from m to below c - k is impossible. */
static double smooth_slack(double k, uint32_t n) {
  return n < 2 ? 0 : n == 2 ? 1.25 * k : 3.25 * k;
}
static double smooth_swell(double k, uint32_t n) {
  return n < 5 ? k * (n - 1) * 0.25 : k;
}

static void compile_shape(compiler* c, uint32_t index, const frame* parent, const context* why) {
  const scree_shape* s = &c->desc->shapes[index];
  frame f = frame_of(parent, &s->transform);
  if (s->kind < SCREE_SHAPE_UNION) {
    compile_leaf(c, index, &f, why);
    return;
  }
  double blend = s->kind == SCREE_SHAPE_SMOOTH_UNION ? (double)s->group.blend * f.scale : 0;
  context inner = *why;
  inner.slack_high += smooth_slack(blend, s->group.child_count) * 1.0001;
  inner.swell += smooth_swell(blend, s->group.child_count);
  for (uint32_t i = 0; i < s->group.child_count; ++i) {
    if (s->kind == SCREE_SHAPE_DIFFERENCE && i == 1) {
      inner.flipped = !why->flipped;
      inner.slack_low = why->slack_high;
      inner.slack_high = why->slack_low;
    }
    compile_shape(c, s->group.children[i], &f, &inner);
    if (i == 0) continue;
    support_op* op = &c->support->ops[c->support->op_count++];
    op->kind = (op_kind)(OP_UNION + (s->kind - SCREE_SHAPE_UNION));
    op->smooth.blend = (float)blend;
    op->smooth.inverse_blend = blend > 0 ? (float)(1 / blend) : 0.0f;
  }
}

/* Counts operations and nesting from the last shape to the first, before anything recurses. Children come after their groups. */
static scree_result measure(const scree_support_desc* desc, uint32_t* ops, uint32_t* nesting, scree_error* error) {
  for (uint32_t index = desc->shape_count; index-- > 0;) {
    const scree_shape* s = &desc->shapes[index];
    ops[index] = 1;
    nesting[index] = 0;
    if (s->kind < SCREE_SHAPE_UNION) continue;
    uint64_t count = s->group.child_count - 1;
    for (uint32_t i = 0; i < s->group.child_count; ++i) {
      uint32_t child = s->group.children[i];
      count += ops[child];
      if (nesting[child] + 1 > nesting[index]) nesting[index] = nesting[child] + 1;
    }
    ops[index] = count < UINT32_MAX ? (uint32_t)count : UINT32_MAX;
    if (nesting[index] > SUPPORT_MAX_NESTING || ops[index] > SUPPORT_MAX_OPS) {
      scree_rt_text_clear(error);
      scree_rt_text_add(error, "shape ");
      scree_rt_text_add_count(error, index);
      scree_rt_text_add(error, ops[index] > SUPPORT_MAX_OPS ? ": the tree below has more than " : ": groups are nested more than ");
      scree_rt_text_add_count(error, ops[index] > SUPPORT_MAX_OPS ? SUPPORT_MAX_OPS / 2 : SUPPORT_MAX_NESTING);
      scree_rt_text_add(error, ops[index] > SUPPORT_MAX_OPS ? " shapes (a shape used twice counts twice)" : " deep");
      return SCREE_ERROR_RANGE;
    }
  }
  return SCREE_OK;
}

/* Heightfields and meshes: each is built once, however often the tree uses it. */
static scree_result build_parts(scree_support* support, const scree_support_desc* desc, uint32_t* part, scree_error* error) {
  const scree_allocator* allocator = &support->allocator;
  uint32_t heights = 0, meshes = 0;
  for (uint32_t i = 0; i < desc->shape_count; ++i) {
    scree_shape_kind kind = desc->shapes[i].kind;
    part[i] = kind == SCREE_SHAPE_HEIGHTFIELD ? heights++ : kind == SCREE_SHAPE_MESH ? meshes++ : 0;
  }
  support->heights = heights > 0 ? scree_rt_allocate_zeroed(allocator, heights, sizeof(support_height)) : NULL;
  if (heights > 0 && support->heights == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  support->height_count = heights;
  support->meshes = meshes > 0 ? scree_rt_allocate_zeroed(allocator, meshes, sizeof(support_mesh)) : NULL;
  if (meshes > 0 && support->meshes == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  support->mesh_count = meshes;

  for (uint32_t i = 0; i < desc->shape_count; ++i) { /* all checks come before the slow part */
    if (desc->shapes[i].kind != SCREE_SHAPE_MESH) continue;
    scree_result result = scree_rt_support_mesh_check(&desc->shapes[i], i, allocator, error);
    if (result != SCREE_OK) return result;
  }
  for (uint32_t i = 0; i < desc->shape_count; ++i) {
    scree_result result = SCREE_OK;
    if (desc->shapes[i].kind == SCREE_SHAPE_HEIGHTFIELD)
      result = scree_rt_support_height_create(&support->heights[part[i]], &desc->shapes[i], allocator);
    if (desc->shapes[i].kind == SCREE_SHAPE_MESH)
      result = scree_rt_support_mesh_create(&support->meshes[part[i]], &desc->shapes[i], &desc->jobs, allocator);
    if (result != SCREE_OK) return result;
  }
  return SCREE_OK;
}

static scree_result build(scree_support* support, const scree_support_desc* desc, uint32_t* scratch, scree_error* error) {
  uint32_t *ops = scratch, *nesting = scratch + desc->shape_count, *part = nesting; /* nesting is done with before part is filled */
  scree_result result = measure(desc, ops, nesting, error);
  if (result != SCREE_OK) return result;

  support->op_capacity = ops[0] + 1;
  support->ops = scree_rt_allocate_zeroed(&support->allocator, support->op_capacity, sizeof(support_op));
  support->program = scree_rt_allocate_zeroed(&support->allocator, support->op_capacity, sizeof(uint16_t));
  if (support->ops == NULL || support->program == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  result = build_parts(support, desc, part, error);
  if (result != SCREE_OK) return result;

  compiler c = {desc, support, part, false, 0};
  const frame root = {{0, 0, 0}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1};
  const context any = {false, 0, 0, 0};
  compile_shape(&c, 0, &root, &any);
  if (c.too_far) {
    scree_rt_text_clear(error);
    scree_rt_text_add(error, "shape ");
    scree_rt_text_add_count(error, c.far_shape);
    scree_rt_text_add(error, ": lies more than 1e9 metres from the support's origin, or is as large");
    return SCREE_ERROR_RANGE;
  }
  support->ops[support->op_count].kind = OP_NEGATE;
  for (uint32_t i = 0; i < support->op_count; ++i) support->program[i] = (uint16_t)i;
  scree_rt_support_level_bounds(support, 0, support->min, support->max);
  return SCREE_OK;
}

scree_result scree_support_create(const scree_support_desc* desc, const scree_allocator* given, scree_support** out,
                                  scree_error* error) {
  scree_rt_text_clear(error);
  if (out != NULL) *out = NULL;
  if (desc == NULL || out == NULL) {
    scree_rt_text_add(error, desc == NULL ? "desc is NULL" : "out is NULL");
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  scree_result result = scree_rt_support_check(desc, error);
  if (result != SCREE_OK) return result;

  scree_allocator allocator = scree_rt_allocator_or_default(given);
  scree_support* support = scree_rt_allocate_zeroed(&allocator, 1, sizeof *support);
  uint32_t* scratch = scree_rt_allocate_zeroed(&allocator, desc->shape_count, 2 * sizeof(uint32_t));
  result = SCREE_ERROR_OUT_OF_MEMORY;
  if (support != NULL) {
    support->allocator = allocator;
    memcpy(support->origin, desc->origin, sizeof support->origin);
    if (scratch != NULL) result = build(support, desc, scratch, error);
  }
  scree_rt_release(&allocator, scratch, desc->shape_count, 2 * sizeof(uint32_t));
  if (result == SCREE_OK) {
    *out = support;
    return SCREE_OK;
  }
  if (result == SCREE_ERROR_OUT_OF_MEMORY) {
    scree_rt_text_clear(error);
    scree_rt_text_add(error, "out of memory");
  }
  scree_support_destroy(support);
  return result;
}

void scree_support_destroy(scree_support* support) {
  if (support == NULL) return;
  scree_allocator allocator = support->allocator;
  for (uint32_t i = 0; i < support->height_count; ++i) scree_rt_support_height_destroy(&support->heights[i], &allocator);
  for (uint32_t i = 0; i < support->mesh_count; ++i) scree_rt_support_mesh_destroy(&support->meshes[i], &allocator);
  scree_rt_release(&allocator, support->heights, support->height_count, sizeof(support_height));
  scree_rt_release(&allocator, support->meshes, support->mesh_count, sizeof(support_mesh));
  scree_rt_release(&allocator, support->ops, support->op_capacity, sizeof(support_op));
  scree_rt_release(&allocator, support->program, support->op_capacity, sizeof(uint16_t));
  scree_rt_release(&allocator, support, 1, sizeof *support);
}

bool scree_rt_support_level_bounds(const scree_support* support, double level, double min[3], double max[3]) {
  double low[SUPPORT_MAX_STACK][3], high[SUPPORT_MAX_STACK][3];
  uint32_t top = 0;
  for (uint32_t i = 0; i < support->op_count; ++i) {
    const support_op* op = &support->ops[i];
    if (op->kind < OP_UNION) {
      for (int a = 0; a < 3; ++a) {
        low[top][a] = op->min[a] - level * op->grow;
        high[top][a] = op->max[a] + level * op->grow;
      }
      ++top;
      continue;
    }
    --top;
    for (int a = 0; a < 3; ++a) {
      double *l = &low[top - 1][a], *h = &high[top - 1][a], l2 = low[top][a], h2 = high[top][a];
      if (op->kind == OP_DIFFERENCE) continue;
      bool outer = op->kind != OP_INTERSECTION;
      *l = (outer ? l2 < *l : l2 > *l) ? l2 : *l;
      *h = (outer ? h2 > *h : h2 < *h) ? h2 : *h;
    }
  }
  bool some = true;
  for (int a = 0; a < 3; ++a) {
    min[a] = low[0][a];
    max[a] = high[0][a];
    some = some && min[a] <= max[a];
  }
  return some;
}

void scree_support_bounds(const scree_support* support, double min[3], double max[3]) {
  bool some = support->min[0] <= support->max[0] && support->min[1] <= support->max[1] && support->min[2] <= support->max[2];
  for (int a = 0; a < 3; ++a) {
    double middle = (support->min[a] + support->max[a]) * 0.5; /* an empty support has an empty box */
    min[a] = support->origin[a] + (some ? support->min[a] : middle);
    max[a] = support->origin[a] + (some ? support->max[a] : middle);
  }
}

void scree_support_distance(const scree_support* support, const float* x, const float* y, const float* z, float* distance,
                            uint32_t count) {
  float px[SUPPORT_BATCH], py[SUPPORT_BATCH], pz[SUPPORT_BATCH], d[SUPPORT_BATCH];
  for (uint32_t first = 0; first < count; first += SUPPORT_BATCH) {
    uint32_t n = count - first < SUPPORT_BATCH ? count - first : SUPPORT_BATCH;
    for (uint32_t i = 0; i < SUPPORT_BATCH; ++i) { /* whole vectors are evaluated, the last point fills them */
      uint32_t from = first + (i < n ? i : n - 1);
      px[i] = x[from];
      py[i] = y[from];
      pz[i] = z[from];
    }
    scree_rt_support_evaluate_plain(support->ops, support->program, support->op_count, px, py, pz, d, n);
    memcpy(distance + first, d, n * sizeof *d);
  }
}
