/* Checks of a support's description: every number of every shape, before anything is built. */
#include <math.h>

#include "support_program.h"
#include "support_text.h"

#define LARGEST 1e9 /* metres; a float's square and cube are still finite */

typedef struct checker {
  scree_error* error;
  uint32_t shape;
} checker;

static void say_field(checker* c, const char* field, int index) {
  scree_rt_text_clear(c->error);
  scree_rt_text_add(c->error, "shape ");
  scree_rt_text_add_count(c->error, c->shape);
  scree_rt_text_add(c->error, ": ");
  scree_rt_text_add(c->error, field);
  if (index >= 0) {
    scree_rt_text_add(c->error, "[");
    scree_rt_text_add_count(c->error, (uint64_t)index);
    scree_rt_text_add(c->error, "]");
  }
}

static scree_result refuse(checker* c, scree_result result, const char* field, const char* why) {
  say_field(c, field, -1);
  scree_rt_text_add(c->error, " ");
  scree_rt_text_add(c->error, why);
  return result;
}

static scree_result number(checker* c, const char* field, int index, double value, bool fits, const char* expected) {
  if (isfinite(value) && fabs(value) <= LARGEST && fits) return SCREE_OK;
  say_field(c, field, index);
  scree_rt_text_add(c->error, " is ");
  scree_rt_text_add_number(c->error, value);
  scree_rt_text_add(c->error, ", expected ");
  scree_rt_text_add(c->error, isfinite(value) && fits ? "at most 1e9 metres" : expected);
  return SCREE_ERROR_RANGE;
}

#define TRY(call)                                  \
  do {                                             \
    scree_result try_result = (call);              \
    if (try_result != SCREE_OK) return try_result; \
  } while (0)

static scree_result positive(checker* c, const char* field, int index, double value) {
  return number(c, field, index, value, value > 0, "a number > 0");
}

static scree_result finite(checker* c, const char* field, int index, double value) {
  return number(c, field, index, value, true, "a finite number");
}

static scree_result three(checker* c, const char* field, const float v[3]) {
  for (int a = 0; a < 3; ++a) TRY(finite(c, field, a, (double)v[a]));
  return SCREE_OK;
}

static scree_result check_transform(checker* c, const scree_transform* t) {
  TRY(three(c, "transform.translation", t->translation));
  double length2 = 0;
  for (int a = 0; a < 4; ++a) {
    TRY(finite(c, "transform.rotation", a, (double)t->rotation[a]));
    length2 += (double)t->rotation[a] * (double)t->rotation[a];
  }
  if (length2 != 0 && !(length2 > 0.998 && length2 < 1.002))
    return refuse(c, SCREE_ERROR_RANGE, "transform.rotation", "is not a unit quaternion (nor all zero)");
  double scale = (double)t->scale;
  return number(c, "transform.scale", -1, scale, scale == 0 || (scale >= 1e-6 && scale <= 1e6),
                "0 (for 1) or a number from 1e-6 to 1e6");
}

static scree_result check_heightfield(checker* c, const scree_shape* s) {
  if (s->heightfield.heights == NULL) return refuse(c, SCREE_ERROR_INVALID_ARGUMENT, "heightfield.heights", "is NULL");
  TRY(number(c, "heightfield.width", -1, s->heightfield.width, s->heightfield.width >= 2, "at least 2 samples"));
  TRY(number(c, "heightfield.depth", -1, s->heightfield.depth, s->heightfield.depth >= 2, "at least 2 samples"));
  if ((uint64_t)s->heightfield.width * s->heightfield.depth > INT32_MAX)
    return refuse(c, SCREE_ERROR_RANGE, "heightfield", "has more than 2^31 - 1 samples");
  TRY(positive(c, "heightfield.spacing", -1, (double)s->heightfield.spacing));
  TRY(finite(c, "heightfield.above", -1, (double)s->heightfield.above));
  TRY(finite(c, "heightfield.below", -1, (double)s->heightfield.below));
  double thickness = (double)s->heightfield.above + (double)s->heightfield.below;
  TRY(positive(c, "heightfield.above + below", -1, thickness));
  size_t count = (size_t)s->heightfield.width * s->heightfield.depth;
  for (size_t i = 0; i < count; ++i)
    if (!(fabsf(s->heightfield.heights[i]) <= (float)LARGEST))
      return number(c, "heightfield.heights", (int)i, (double)s->heightfield.heights[i], false, "a finite number of metres");
  return SCREE_OK;
}

static scree_result check_mesh(checker* c, const scree_shape* s) {
  if (s->mesh.positions == NULL) return refuse(c, SCREE_ERROR_INVALID_ARGUMENT, "mesh.positions", "is NULL");
  if (s->mesh.indices == NULL) return refuse(c, SCREE_ERROR_INVALID_ARGUMENT, "mesh.indices", "is NULL");
  TRY(number(c, "mesh.triangle_count", -1, s->mesh.triangle_count,
             s->mesh.triangle_count >= 4 && s->mesh.triangle_count <= INT32_MAX / 3, "4 or more triangles"));
  TRY(number(c, "mesh.vertex_count", -1, s->mesh.vertex_count, s->mesh.vertex_count >= 4, "4 or more vertices"));
  TRY(number(c, "mesh.resolution", -1, s->mesh.resolution,
             s->mesh.resolution == 0 || (s->mesh.resolution >= 8 && s->mesh.resolution <= 512), "0 (for 128) or 8 to 512"));
  for (size_t i = 0; i < (size_t)s->mesh.vertex_count * 3; ++i)
    if (!(fabsf(s->mesh.positions[i]) <= (float)LARGEST))
      return number(c, "mesh.positions", (int)i, (double)s->mesh.positions[i], false, "a finite number of metres");
  double longest = 0;
  for (int a = 0; a < 3; ++a) {
    double low = (double)s->mesh.positions[a], high = low;
    for (size_t i = (size_t)a; i < (size_t)s->mesh.vertex_count * 3; i += 3) {
      if ((double)s->mesh.positions[i] < low) low = (double)s->mesh.positions[i];
      if ((double)s->mesh.positions[i] > high) high = (double)s->mesh.positions[i];
    }
    if (high - low > longest) longest = high - low;
  }
  TRY(number(c, "the longest side of mesh", -1, longest, longest >= 1e-6, "at least 1e-6 metres"));
  for (size_t i = 0; i < (size_t)s->mesh.triangle_count * 3; ++i)
    if (s->mesh.indices[i] >= s->mesh.vertex_count) {
      say_field(c, "mesh.indices", (int)i);
      scree_rt_text_add(c->error, " is ");
      scree_rt_text_add_count(c->error, s->mesh.indices[i]);
      scree_rt_text_add(c->error, ", but there are only ");
      scree_rt_text_add_count(c->error, s->mesh.vertex_count);
      scree_rt_text_add(c->error, " vertices");
      return SCREE_ERROR_RANGE;
    }
  return SCREE_OK;
}

static scree_result check_callback(checker* c, const scree_shape* s) {
  if (s->callback.distance == NULL) return refuse(c, SCREE_ERROR_INVALID_ARGUMENT, "callback.distance", "is NULL");
  double lipschitz = (double)s->callback.lipschitz;
  TRY(number(c, "callback.lipschitz", -1, lipschitz, lipschitz == 0 || (lipschitz > 0 && lipschitz <= 1e6),
             "0 (for 1) or a number > 0 and at most 1e6"));
  TRY(three(c, "callback.min", s->callback.min));
  TRY(three(c, "callback.max", s->callback.max));
  for (int a = 0; a < 3; ++a)
    TRY(number(c, "callback.max", a, (double)s->callback.max[a], s->callback.max[a] > s->callback.min[a],
               "more than callback.min"));
  return SCREE_OK;
}

static scree_result check_group(checker* c, const scree_shape* s, uint32_t shape_count) {
  if (s->group.children == NULL) return refuse(c, SCREE_ERROR_INVALID_ARGUMENT, "group.children", "is NULL");
  if (s->group.child_count == 0) return refuse(c, SCREE_ERROR_INVALID_ARGUMENT, "group.child_count", "is 0, expected 1 or more");
  for (uint32_t i = 0; i < s->group.child_count; ++i) {
    uint32_t child = s->group.children[i];
    if (child > c->shape && child < shape_count) continue;
    say_field(c, "group.children", (int)i);
    scree_rt_text_add(c->error, " is ");
    scree_rt_text_add_count(c->error, child);
    scree_rt_text_add(c->error, child < shape_count ? ", expected a later shape than the group itself" : ", but there are only ");
    if (child >= shape_count) {
      scree_rt_text_add_count(c->error, shape_count);
      scree_rt_text_add(c->error, " shapes");
    }
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  if (s->kind == SCREE_SHAPE_SMOOTH_UNION) TRY(positive(c, "group.blend", -1, (double)s->group.blend));
  return SCREE_OK;
}

static scree_result check_shape(checker* c, const scree_shape* s, uint32_t shape_count) {
  bool known = (uint32_t)s->kind <= SCREE_SHAPE_CALLBACK || (s->kind >= SCREE_SHAPE_UNION && s->kind <= SCREE_SHAPE_SMOOTH_UNION);
  if (!known) {
    say_field(c, "kind", -1);
    scree_rt_text_add(c->error, " ");
    scree_rt_text_add_count(c->error, (uint32_t)s->kind);
    scree_rt_text_add(c->error, " is not known");
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  TRY(check_transform(c, &s->transform));
  switch (s->kind) {
    case SCREE_SHAPE_SPHERE: return positive(c, "sphere.radius", -1, (double)s->sphere.radius);
    case SCREE_SHAPE_BOX: {
      float smallest = s->box.half[0];
      for (int a = 0; a < 3; ++a) {
        TRY(positive(c, "box.half", a, (double)s->box.half[a]));
        if (s->box.half[a] < smallest) smallest = s->box.half[a];
      }
      return number(c, "box.rounding", -1, (double)s->box.rounding, s->box.rounding >= 0 && s->box.rounding <= smallest,
                    "from 0 to the smallest of box.half");
    }
    case SCREE_SHAPE_CAPSULE:
      TRY(three(c, "capsule.a", s->capsule.a));
      TRY(three(c, "capsule.b", s->capsule.b));
      return positive(c, "capsule.radius", -1, (double)s->capsule.radius);
    case SCREE_SHAPE_CYLINDER:
      TRY(positive(c, "cylinder.radius", -1, (double)s->cylinder.radius));
      return positive(c, "cylinder.half_height", -1, (double)s->cylinder.half_height);
    case SCREE_SHAPE_CONE:
      TRY(positive(c, "cone.radius", -1, (double)s->cone.radius));
      return positive(c, "cone.height", -1, (double)s->cone.height);
    case SCREE_SHAPE_HEIGHTFIELD: return check_heightfield(c, s);
    case SCREE_SHAPE_MESH: return check_mesh(c, s);
    case SCREE_SHAPE_CALLBACK: return check_callback(c, s);
    default: return check_group(c, s, shape_count);
  }
}

scree_result scree_rt_support_check(const scree_support_desc* desc, scree_error* error) {
  checker c = {error, 0};
  scree_rt_text_clear(error);
  if (desc->shapes == NULL || desc->shape_count == 0) {
    scree_rt_text_add(error, "a support needs at least one shape");
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  if (desc->jobs.parallel_for != NULL && desc->jobs.worker_count == 0) {
    scree_rt_text_add(error, "jobs.worker_count is 0, expected 1 or more");
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  for (int a = 0; a < 3; ++a)
    if (!isfinite(desc->origin[a])) {
      scree_rt_text_add(error, "origin is ");
      scree_rt_text_add_number(error, desc->origin[a]);
      scree_rt_text_add(error, ", expected a finite number");
      return SCREE_ERROR_RANGE;
    }
  for (c.shape = 0; c.shape < desc->shape_count; ++c.shape) TRY(check_shape(&c, &desc->shapes[c.shape], desc->shape_count));
  return SCREE_OK;
}
