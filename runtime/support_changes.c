/* What differs between two supports. A leaf that differs matters to the root only where one of its two values is in the range that
 * a query for [-level, level] at the root would look at (support_op: slack), so within the leaf's own box grown by that. */
#include <math.h>
#include <string.h>

#include "support_leaf.h"

typedef struct bounds {
  double min[3], max[3];
  bool some;
} bounds;

static void add_box(bounds* b, const double min[3], const double max[3]) {
  for (int a = 0; a < 3; ++a) {
    if (!b->some || min[a] < b->min[a]) b->min[a] = min[a];
    if (!b->some || max[a] > b->max[a]) b->max[a] = max[a];
  }
  b->some = true;
}

static void add_whole(bounds* b, const scree_support* support, double level) {
  double min[3], max[3];
  if (scree_rt_support_level_bounds(support, level, min, max)) add_box(b, min, max);
}

static void add_leaf(bounds* b, const support_op* op, double level) {
  double min[3], max[3], grow = (level + (double)op->slack_high) * op->grow;
  for (int a = 0; a < 3; ++a) {
    min[a] = op->min[a] - grow;
    max[a] = op->max[a] + grow;
  }
  add_box(b, min, max);
}

/* Operations were zeroed before they were filled, so that bytes can be compared; what is pointed at is compared first. */
static bool same_op(const support_op* before, const support_op* after) {
  support_op a, b;
  if (before->kind != after->kind) return false;
  memcpy(&a, before, sizeof a);
  memcpy(&b, after, sizeof b);
  switch (before->kind) {
    case OP_HEIGHTFIELD:
      if (!support_same_key(a.height.grid->share.key, b.height.grid->share.key)) return false;
      b.height.grid = a.height.grid;
      break;
    case OP_MESH:
      if (!support_same_key(a.mesh.grid->share.key, b.mesh.grid->share.key)) return false;
      b.mesh.grid = a.mesh.grid;
      break;
    case OP_EXTRUSION: {
      uint32_t edges = a.extrusion.edge_count;
      size_t length = scree_rt_support_edges_length(edges);
      if (edges != b.extrusion.edge_count || memcmp(a.extrusion.edges, b.extrusion.edges, length * sizeof(float)) != 0)
        return false;
      b.extrusion.edges = a.extrusion.edges;
      break;
    }
    case OP_BLOBS:
      if (a.blobs.count != b.blobs.count || memcmp(a.blobs.balls, b.blobs.balls, sizeof(float) * BLOB_FLOATS * a.blobs.count) != 0)
        return false;
      b.blobs.balls = a.blobs.balls;
      break;
    case OP_CALLBACK:
      b.callback.log = a.callback.log;
      b.callback.shape = a.callback.shape;
      break;
    default: break;
  }
  return memcmp(&a, &b, sizeof a) == 0;
}

/* Whether two programs are the same but for their leaves. */
static bool built_alike(const scree_support* a, const scree_support* b) {
  if (a->op_count != b->op_count || memcmp(a->origin, b->origin, sizeof a->origin) != 0) return false;
  for (uint32_t i = 0; i < a->op_count; ++i) {
    bool leaf = op_is_leaf(a->ops[i].kind);
    if (leaf != op_is_leaf(b->ops[i].kind)) return false;
    if (!leaf && !same_op(&a->ops[i], &b->ops[i])) return false;
  }
  return true;
}

bool scree_support_changed_bounds(const scree_support* before, const scree_support* after, double level, double min[3],
                                  double max[3]) {
  if (!(level > 0)) level = 0;
  bounds was = {.some = false}, is = {.some = false}, changed = {.some = false};
  add_whole(&was, before, level);
  add_whole(&is, after, level);
  for (int a = 0; a < 3; ++a) { /* to the world */
    was.min[a] += before->origin[a];
    was.max[a] += before->origin[a];
    is.min[a] += after->origin[a];
    is.max[a] += after->origin[a];
  }
  bounds whole = was;
  if (is.some) add_box(&whole, is.min, is.max);
  if (built_alike(before, after)) {
    for (uint32_t i = 0; i < before->op_count; ++i) {
      if (!op_is_leaf(before->ops[i].kind) || same_op(&before->ops[i], &after->ops[i])) continue;
      add_leaf(&changed, &before->ops[i], level);
      add_leaf(&changed, &after->ops[i], level);
    }
    for (int a = 0; a < 3; ++a) { /* and no farther than anything reaches */
      min[a] = fmax(changed.min[a] + before->origin[a], whole.min[a]);
      max[a] = fmin(changed.max[a] + before->origin[a], whole.max[a]);
    }
  } else {
    changed = whole;
    memcpy(min, whole.min, sizeof whole.min);
    memcpy(max, whole.max, sizeof whole.max);
  }
  bool some = changed.some && whole.some;
  for (int a = 0; a < 3 && some; ++a) some = min[a] <= max[a];
  for (int a = 0; a < 3 && !some; ++a) min[a] = max[a] = 0;
  return some;
}
