/* Compiles a tree of shapes into a program (support_program.h). */
#include <math.h>
#include <string.h>

#include "allocator.h"
#include "support_leaf.h"
#include "support_text.h"

/* Which values matter to the root, see support_op; and how far smooth unions above let a surface swell. */
typedef struct context {
  bool flipped;
  double slack_low, slack_high, swell;
} context;

typedef struct compiler {
  const scree_support_desc* desc;
  scree_support* support;
  const support_part* parts; /* of each shape */
  bool too_far;              /* a shape beyond what floats carry */
  uint32_t far_shape;
} compiler;

static support_frame frame_of(const support_frame* parent, const scree_transform* t) {
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
  support_frame out;
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

/* What all leaves share, once kind, parameters and box are there. */
static void finish_leaf(compiler* c, support_op* op, uint32_t index, const support_frame* f, const context* why, double magnitude) {
  op->flipped = why->flipped;
  op->slack_low = (float)why->slack_low;
  op->slack_high = (float)why->slack_high;
  for (int a = 0; a < 3; ++a) {
    double size = op->max[a] - op->min[a];
    magnitude += fabs(f->origin[a]) + (isfinite(size) ? size : 0);
    if (isfinite(op->min[a]) && fabs(op->min[a]) > magnitude) magnitude = fabs(op->min[a]);
    if (isfinite(op->max[a]) && fabs(op->max[a]) > magnitude) magnitude = fabs(op->max[a]);
  }
  if (magnitude > c->support->magnitude) c->support->magnitude = magnitude;
  if (!(magnitude <= 1e9) && !c->too_far) {
    c->too_far = true;
    c->far_shape = index;
  }
  for (int a = 0; a < 3; ++a) { /* what rounding may have moved, and the swelling of smooth unions and noise above */
    double room = magnitude * 1e-6 + (why->swell + (double)op->doubt) * op->grow;
    op->min[a] -= room;
    op->max[a] += room;
  }
}

static support_op* next_op(compiler* c) {
  return &c->support->ops[c->support->op_count++];
}

static void compile_tube(compiler* c, uint32_t index, const support_frame* f, const context* why) {
  const scree_tube* tube = &c->desc->shapes[index].tube;
  uint32_t count = scree_rt_support_piece_count(tube);
  for (uint32_t i = 0; i < count; ++i) {
    support_piece piece;
    support_op* op = next_op(c);
    scree_rt_support_piece(tube, i, &piece);
    scree_rt_support_compile_piece(op, &piece, (double)tube->half_height, f);
    finish_leaf(c, op, index, f, why, 0);
    if (i > 0) next_op(c)->kind = OP_UNION;
  }
}

static void compile_leaf(compiler* c, uint32_t index, const support_frame* f, const context* why) {
  const scree_shape* s = &c->desc->shapes[index];
  if (s->kind == SCREE_SHAPE_TUBE) {
    compile_tube(c, index, f, why);
    return;
  }
  support_op* op = next_op(c);
  double magnitude = scree_rt_support_compile_leaf(op, s, f, &c->parts[index]);
  if (op->kind == OP_CALLBACK) {
    op->callback.shape = index;
    op->callback.log = &c->support->log;
  }
  finish_leaf(c, op, index, f, why, magnitude);
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

static void compile_shape(compiler* c, uint32_t index, const support_frame* parent, const context* why);

/* sup |n| and sup |grad n| of one octave: see support_noise_kernel.h. */
static void compile_noise(compiler* c, const scree_noise* n, const support_frame* f, const context* why) {
  double amplitude = (double)n->amplitude * f->scale, wavelength = (double)n->wavelength * f->scale;
  context inner = *why;
  inner.slack_low += amplitude * 1.0001;
  inner.slack_high += amplitude * 1.0001;
  inner.swell += amplitude * 1.0001;
  compile_shape(c, n->child, f, &inner);
  support_op* op = next_op(c);
  support_frame waves = *f;
  waves.scale = wavelength;
  op->kind = OP_NOISE;
  op->noise.frame = scree_rt_support_op_frame(&waves, false);
  op->noise.seed = n->seed;
  op->noise.octaves = n->octaves == 0 ? 1 : n->octaves;
  op->noise.amplitude = (float)amplitude;
  double height = 1, sum = 0;
  for (uint32_t o = 0; o < op->noise.octaves; ++o, height *= 0.5) sum += height;
  height = amplitude / sum / 1.04492;
  op->noise.slope = (float)(height * 3.01 / wavelength);
  op->lipschitz = op->noise.slope * (float)op->noise.octaves;
  for (uint32_t o = 0; o < op->noise.octaves; ++o, height *= 0.5) op->noise.heights[o] = (float)height;
  double magnitude = amplitude + wavelength;
  for (int a = 0; a < 3; ++a) magnitude += fabs(f->origin[a]);
  if (magnitude > c->support->magnitude) c->support->magnitude = magnitude;
}

static void compile_shape(compiler* c, uint32_t index, const support_frame* parent, const context* why) {
  const scree_shape* s = &c->desc->shapes[index];
  support_frame f = frame_of(parent, &s->transform);
  if (s->kind == SCREE_SHAPE_NOISE) {
    compile_noise(c, &s->noise, &f, why);
    return;
  }
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
    support_op* op = next_op(c);
    op->kind = (op_kind)(OP_UNION + (s->kind - SCREE_SHAPE_UNION));
    op->smooth.blend = (float)blend;
    op->smooth.inverse_blend = blend > 0 ? (float)(1 / blend) : 0.0f;
  }
}

/* Counts operations and nesting from the last shape to the first, before anything recurses. Children come after their groups. */
static scree_result measure(const scree_support_desc* desc, uint32_t* ops, uint32_t* nesting, scree_error* error) {
  for (uint32_t index = desc->shape_count; index-- > 0;) {
    const scree_shape* s = &desc->shapes[index];
    ops[index] = s->kind == SCREE_SHAPE_TUBE ? 2 * scree_rt_support_piece_count(&s->tube) - 1 : 1;
    nesting[index] = 0;
    if (s->kind < SCREE_SHAPE_UNION && ops[index] <= SUPPORT_MAX_OPS) continue;
    bool noise = s->kind == SCREE_SHAPE_NOISE, leaf = s->kind < SCREE_SHAPE_UNION;
    uint32_t children = noise ? 1 : leaf ? 0 : s->group.child_count;
    uint64_t count = noise ? 1 : leaf ? ops[index] : children - 1;
    for (uint32_t i = 0; i < children; ++i) {
      uint32_t child = noise ? s->noise.child : s->group.children[i];
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
      scree_rt_text_add(error,
                        ops[index] > SUPPORT_MAX_OPS ? " shapes (a shape used twice counts twice, a tube once a piece)" : " deep");
      return SCREE_ERROR_RANGE;
    }
  }
  return SCREE_OK;
}

static support_height* find_height(const scree_support* in, support_key key) {
  for (uint32_t i = 0; in != NULL && i < in->height_count; ++i)
    if (in->heights[i] != NULL && support_same_key(in->heights[i]->share.key, key)) return in->heights[i];
  return NULL;
}

static support_mesh* find_mesh(const scree_support* in, support_key key) {
  for (uint32_t i = 0; in != NULL && i < in->mesh_count; ++i)
    if (in->meshes[i] != NULL && support_same_key(in->meshes[i]->share.key, key)) return in->meshes[i];
  return NULL;
}

/* Takes the grid of a heightfield or mesh from an earlier support, or else checks what is in its arrays: all checks come before
 * the slow part. */
static scree_result find_grid(scree_support* support, const scree_support_desc* desc, uint32_t index, support_part* part,
                              scree_error* error) {
  const scree_shape* shape = &desc->shapes[index];
  part->key = scree_rt_support_key(shape);
  if (shape->kind == SCREE_SHAPE_HEIGHTFIELD && (part->height = find_height(desc->reuse, part->key)) != NULL) {
    support_keep(&part->height->share);
    support->heights[part->place] = part->height;
  } else if (shape->kind == SCREE_SHAPE_MESH && (part->mesh = find_mesh(desc->reuse, part->key)) != NULL) {
    support_keep(&part->mesh->share);
    support->meshes[part->place] = part->mesh;
  } else {
    scree_result result = scree_rt_support_check_content(shape, index, error);
    if (result != SCREE_OK || shape->kind == SCREE_SHAPE_HEIGHTFIELD) return result;
    return scree_rt_support_mesh_check(shape, index, &support->allocator, error);
  }
  return SCREE_OK;
}

/* Makes a grid that was not found, unless another shape of this support has the same. */
static scree_result make_grid(scree_support* support, const scree_support_desc* desc, uint32_t index, support_part* part) {
  const scree_shape* shape = &desc->shapes[index];
  if (shape->kind == SCREE_SHAPE_HEIGHTFIELD && part->height == NULL) {
    part->height = find_height(support, part->key);
    if (part->height != NULL)
      support_keep(&part->height->share);
    else
      part->height = scree_rt_support_height_create(shape, part->key, &support->allocator);
    support->heights[part->place] = part->height;
    if (part->height == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  } else if (shape->kind == SCREE_SHAPE_MESH && part->mesh == NULL) {
    part->mesh = find_mesh(support, part->key);
    if (part->mesh != NULL)
      support_keep(&part->mesh->share);
    else
      part->mesh = scree_rt_support_mesh_create(shape, part->key, &desc->jobs, &support->allocator);
    support->meshes[part->place] = part->mesh;
    if (part->mesh == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  }
  return SCREE_OK;
}

static bool has_grid(scree_shape_kind kind) {
  return kind == SCREE_SHAPE_HEIGHTFIELD || kind == SCREE_SHAPE_MESH;
}

/* Heightfields, meshes and tables: each is built once, however often the tree uses it. */
static scree_result build_parts(scree_support* support, const scree_support_desc* desc, support_part* parts, scree_error* error) {
  const scree_allocator* allocator = &support->allocator;
  uint32_t heights = 0, meshes = 0;
  size_t floats = 0;
  for (uint32_t i = 0; i < desc->shape_count; ++i) {
    if (desc->shapes[i].kind == SCREE_SHAPE_HEIGHTFIELD) parts[i].place = heights++;
    if (desc->shapes[i].kind == SCREE_SHAPE_MESH) parts[i].place = meshes++;
    floats += scree_rt_support_table_length(&desc->shapes[i]);
  }
  support->heights = heights > 0 ? scree_rt_allocate_zeroed(allocator, heights, sizeof *support->heights) : NULL;
  if (heights > 0 && support->heights == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  support->height_count = heights;
  support->meshes = meshes > 0 ? scree_rt_allocate_zeroed(allocator, meshes, sizeof *support->meshes) : NULL;
  if (meshes > 0 && support->meshes == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  support->mesh_count = meshes;
  support->tables = floats > 0 ? scree_rt_allocate(allocator, floats, sizeof(float)) : NULL;
  if (floats > 0 && support->tables == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  support->table_length = floats;

  scree_result result = SCREE_OK;
  for (uint32_t i = 0; i < desc->shape_count && result == SCREE_OK; ++i)
    if (has_grid(desc->shapes[i].kind)) result = find_grid(support, desc, i, &parts[i], error);
  for (uint32_t i = 0; i < desc->shape_count && result == SCREE_OK; ++i)
    if (has_grid(desc->shapes[i].kind)) result = make_grid(support, desc, i, &parts[i]);
  floats = 0;
  for (uint32_t i = 0; i < desc->shape_count; ++i) {
    if (scree_rt_support_table_length(&desc->shapes[i]) == 0) continue;
    parts[i].table = support->tables + floats;
    scree_rt_support_table_fill(&desc->shapes[i], support->tables + floats);
    floats += scree_rt_support_table_length(&desc->shapes[i]);
  }
  return result;
}

static scree_result build(scree_support* support, const scree_support_desc* desc, uint32_t* counts, support_part* parts,
                          scree_error* error) {
  uint32_t *ops = counts, *nesting = counts + desc->shape_count;
  scree_result result = measure(desc, ops, nesting, error);
  if (result != SCREE_OK) return result;

  support->op_capacity = ops[0] + 1;
  support->ops = scree_rt_allocate_zeroed(&support->allocator, support->op_capacity, sizeof(support_op));
  support->program = scree_rt_allocate_zeroed(&support->allocator, support->op_capacity, sizeof(uint16_t));
  if (support->ops == NULL || support->program == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  result = build_parts(support, desc, parts, error);
  if (result != SCREE_OK) return result;

  compiler c = {desc, support, parts, false, 0};
  const support_frame root = {{0, 0, 0}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1};
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
  uint32_t* counts = scree_rt_allocate_zeroed(&allocator, desc->shape_count, 2 * sizeof(uint32_t));
  support_part* parts = scree_rt_allocate_zeroed(&allocator, desc->shape_count, sizeof *parts);
  result = SCREE_ERROR_OUT_OF_MEMORY;
  if (support != NULL) {
    support->allocator = allocator;
    memcpy(support->origin, desc->origin, sizeof support->origin);
    support->log = desc->log;
    if (counts != NULL && parts != NULL) result = build(support, desc, counts, parts, error);
  }
  scree_rt_release(&allocator, counts, desc->shape_count, 2 * sizeof(uint32_t));
  scree_rt_release(&allocator, parts, desc->shape_count, sizeof *parts);
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
  for (uint32_t i = 0; i < support->height_count; ++i) scree_rt_support_height_drop(support->heights[i]);
  for (uint32_t i = 0; i < support->mesh_count; ++i) scree_rt_support_mesh_drop(support->meshes[i]);
  scree_rt_release(&allocator, support->heights, support->height_count, sizeof *support->heights);
  scree_rt_release(&allocator, support->meshes, support->mesh_count, sizeof *support->meshes);
  scree_rt_release(&allocator, support->tables, support->table_length, sizeof(float));
  scree_rt_release(&allocator, support->ops, support->op_capacity, sizeof(support_op));
  scree_rt_release(&allocator, support->program, support->op_capacity, sizeof(uint16_t));
  scree_rt_release(&allocator, support, 1, sizeof *support);
}

bool scree_rt_support_level_bounds(const scree_support* support, double level, double min[3], double max[3]) {
  double low[SUPPORT_MAX_STACK][3], high[SUPPORT_MAX_STACK][3];
  uint32_t top = 0;
  for (uint32_t i = 0; i < support->op_count; ++i) {
    const support_op* op = &support->ops[i];
    if (op_is_leaf(op->kind)) {
      for (int a = 0; a < 3; ++a) {
        low[top][a] = op->min[a] - level * op->grow;
        high[top][a] = op->max[a] + level * op->grow;
      }
      ++top;
      continue;
    }
    if (!op_is_pair(op->kind)) continue; /* noise swells the leaves' own boxes */
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

double scree_rt_support_lipschitz(const scree_support* support) {
  double slope[SUPPORT_MAX_STACK] = {0};
  uint32_t top = 0;
  for (uint32_t i = 0; i < support->op_count; ++i) {
    const support_op* op = &support->ops[i];
    if (op_is_leaf(op->kind)) {
      slope[top++] = (double)op->lipschitz;
    } else if (op_is_pair(op->kind)) {
      --top;
      if (slope[top] > slope[top - 1]) slope[top - 1] = slope[top];
    } else {
      slope[top - 1] += (double)op->lipschitz;
    }
  }
  return slope[0];
}

void scree_support_bounds(const scree_support* support, double min[3], double max[3]) {
  bool some = support->min[0] <= support->max[0] && support->min[1] <= support->max[1] && support->min[2] <= support->max[2];
  for (int a = 0; a < 3; ++a) {
    double middle = (support->min[a] + support->max[a]) * 0.5; /* an empty support has an empty box */
    if (!isfinite(middle)) middle = 0;
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
