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
  return positive(c, "heightfield.above + below", -1, thickness);
}

static scree_result check_heights(checker* c, const scree_shape* s) {
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
  return SCREE_OK;
}

static scree_result check_triangles(checker* c, const scree_shape* s) {
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

static scree_result check_ellipsoid(checker* c, const scree_ellipsoid* e) {
  double smallest = INFINITY, largest = 0;
  for (int a = 0; a < 3; ++a) {
    double radius = (double)e->radii[a];
    TRY(positive(c, "ellipsoid.radii", a, radius));
    if (radius < smallest) smallest = radius;
    if (radius > largest) largest = radius;
  }
  if (largest > 1000.001 * smallest) return refuse(c, SCREE_ERROR_RANGE, "ellipsoid.radii", "differ by more than a factor of 1000");
  return SCREE_OK;
}

static scree_result count(checker* c, const char* field, uint32_t value, uint32_t low, uint32_t high, const char* expected) {
  return number(c, field, -1, value, value >= low && value <= high, expected);
}

static scree_result check_extrusion(checker* c, const scree_extrusion* e) {
  if (e->points == NULL) return refuse(c, SCREE_ERROR_INVALID_ARGUMENT, "extrusion.points", "is NULL");
  TRY(count(c, "extrusion.point_count", e->point_count, 3, 1024, "3 to 1024 points"));
  double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
  for (uint32_t i = 0; i < 2 * e->point_count; ++i) {
    double at = (double)e->points[i];
    TRY(finite(c, "extrusion.points", (int)i, at));
    if (at < low[i & 1]) low[i & 1] = at;
    if (at > high[i & 1]) high[i & 1] = at;
  }
  if (!(high[0] > low[0] && high[1] > low[1])) return refuse(c, SCREE_ERROR_RANGE, "extrusion.points", "enclose no area");
  TRY(finite(c, "extrusion.low", -1, (double)e->low));
  TRY(finite(c, "extrusion.high", -1, (double)e->high));
  return number(c, "extrusion.high", -1, (double)e->high, e->high > e->low, "more than extrusion.low");
}

static scree_result check_tube(checker* c, const scree_tube* t) {
  if (t->points == NULL) return refuse(c, SCREE_ERROR_INVALID_ARGUMENT, "tube.points", "is NULL");
  if (t->radii == NULL) return refuse(c, SCREE_ERROR_INVALID_ARGUMENT, "tube.radii", "is NULL");
  TRY(count(c, "tube.point_count", t->point_count, 2, 256, "2 to 256 points"));
  TRY(count(c, "tube.subdivisions", t->subdivisions, 0, 32, "0 (for 8) to 32"));
  TRY(number(c, "tube.half_height", -1, (double)t->half_height, t->half_height >= 0, "0 (for a pipe) or more"));
  for (uint32_t i = 0; i < t->point_count; ++i) {
    TRY(positive(c, "tube.radii", (int)i, (double)t->radii[i]));
    for (uint32_t a = 0; a < 3; ++a) TRY(finite(c, "tube.points", (int)(3 * i + a), (double)t->points[3 * i + a]));
  }
  for (uint32_t i = 0; i < t->point_count; ++i) {
    const float *p = t->points + 3 * i, *q = t->points + (i > 0 ? 3 * (i - 1) : 3 * (t->point_count - 1));
    if (i == 0 && !t->closed) continue;
    if (p[0] != q[0] || p[1] != q[1] || p[2] != q[2]) continue;
    say_field(c, "tube.points", (int)(3 * i));
    scree_rt_text_add(c->error, ": the point is the same as the one before");
    return SCREE_ERROR_RANGE;
  }
  return SCREE_OK;
}

static scree_result check_blobs(checker* c, const scree_blobs* b) {
  if (b->centres == NULL) return refuse(c, SCREE_ERROR_INVALID_ARGUMENT, "blobs.centres", "is NULL");
  if (b->radii == NULL) return refuse(c, SCREE_ERROR_INVALID_ARGUMENT, "blobs.radii", "is NULL");
  TRY(count(c, "blobs.count", b->count, 1, 256, "1 to 256 balls"));
  for (uint32_t i = 0; i < b->count; ++i) {
    for (uint32_t a = 0; a < 3; ++a) TRY(finite(c, "blobs.centres", (int)(3 * i + a), (double)b->centres[3 * i + a]));
    double radius = (double)b->radii[i];
    TRY(number(c, "blobs.radii", (int)i, radius, radius >= 1e-6, "a number of at least 1e-6"));
  }
  return SCREE_OK;
}

static scree_result check_pattern(checker* c, const scree_pattern* p) {
  if ((uint32_t)p->kind > SCREE_PATTERN_WAVES) {
    say_field(c, "pattern.kind", -1);
    scree_rt_text_add(c->error, " ");
    scree_rt_text_add_count(c->error, (uint32_t)p->kind);
    scree_rt_text_add(c->error, " is not known");
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  TRY(positive(c, "pattern.spacing", -1, (double)p->spacing));
  TRY(positive(c, "pattern.radius", -1, (double)p->radius));
  if (p->kind != SCREE_PATTERN_WAVES) return SCREE_OK;
  TRY(positive(c, "pattern.wavelength", -1, (double)p->wavelength));
  double amplitude = (double)p->amplitude;
  return number(c, "pattern.amplitude", -1, amplitude, amplitude >= 0 && amplitude <= 1000 * (double)p->wavelength,
                "from 0 to 1000 times pattern.wavelength");
}

static scree_result check_noise(checker* c, const scree_noise* n, uint32_t shape_count) {
  if (!(n->child > c->shape && n->child < shape_count)) {
    say_field(c, "noise.child", -1);
    scree_rt_text_add(c->error, " is ");
    scree_rt_text_add_count(c->error, n->child);
    scree_rt_text_add(c->error, ", expected a later shape of the ");
    scree_rt_text_add_count(c->error, shape_count);
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  TRY(positive(c, "noise.amplitude", -1, (double)n->amplitude));
  TRY(positive(c, "noise.wavelength", -1, (double)n->wavelength));
  if (n->amplitude > 1000 * n->wavelength)
    return refuse(c, SCREE_ERROR_RANGE, "noise.amplitude", "is more than 1000 times noise.wavelength");
  return count(c, "noise.octaves", n->octaves, 0, SUPPORT_MAX_OCTAVES, "0 (for 1) to 8");
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
  bool known = (uint32_t)s->kind <= SCREE_SHAPE_PATTERN || (s->kind >= SCREE_SHAPE_UNION && s->kind <= SCREE_SHAPE_NOISE);
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
    case SCREE_SHAPE_ELLIPSOID: return check_ellipsoid(c, &s->ellipsoid);
    case SCREE_SHAPE_HALF_SPACE: return SCREE_OK;
    case SCREE_SHAPE_TORUS:
      TRY(positive(c, "torus.radius", -1, (double)s->torus.radius));
      return positive(c, "torus.tube_radius", -1, (double)s->torus.tube_radius);
    case SCREE_SHAPE_EXTRUSION: return check_extrusion(c, &s->extrusion);
    case SCREE_SHAPE_TUBE: return check_tube(c, &s->tube);
    case SCREE_SHAPE_BLOBS: return check_blobs(c, &s->blobs);
    case SCREE_SHAPE_PATTERN: return check_pattern(c, &s->pattern);
    case SCREE_SHAPE_NOISE: return check_noise(c, &s->noise, shape_count);
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

scree_result scree_rt_support_check_content(const scree_shape* shape, uint32_t index, scree_error* error) {
  checker c = {error, index};
  return shape->kind == SCREE_SHAPE_MESH ? check_triangles(&c, shape) : check_heights(&c, shape);
}
