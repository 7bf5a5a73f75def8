#include "render_lights.h"

#include <math.h>
#include <string.h>

#include "render.h"

static float dot(const float a[3], const float b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const float a[3], const float b[3], float out[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

static void normalise(float v[3]) {
  float length = sqrtf(dot(v, v));
  for (int a = 0; a < 3; ++a) v[a] /= length;
}

typedef struct box {
  float min[3], max[3];
} box;

static void box_add(box* b, const float p[3]) {
  for (int a = 0; a < 3; ++a) {
    if (p[a] < b->min[a]) b->min[a] = p[a];
    if (p[a] > b->max[a]) b->max[a] = p[a];
  }
}

static const box nothing = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void to_axes(float axes[3][3], const float p[3], float out[3]) {
  for (int a = 0; a < 3; ++a) out[a] = dot(axes[a], p);
}

static void corner_of(const float min[3], const float max[3], int corner, float out[3]) {
  for (int a = 0; a < 3; ++a) out[a] = corner >> a & 1 ? max[a] : min[a];
}

uint32_t render_fit_cascades(const render_cascade_desc* desc, render_cascade* cascades) {
  float axes[3][3];
  for (int a = 0; a < 3; ++a) axes[2][a] = -desc->sun[a];
  /* Texels along the camera's own sideways direction: shadow edges then run across few of them in most pictures. */
  float sideways[3] = {desc->right[0], desc->right[1], desc->right[2]};
  cross(axes[2], sideways, axes[1]);
  if (dot(axes[1], axes[1]) < 1e-6f * dot(sideways, sideways)) cross(axes[2], desc->up, axes[1]);
  normalise(axes[1]);
  cross(axes[2], axes[1], axes[0]); /* right x up = backwards: seen from the sun, counter-clockwise stays so */

  box casters = nothing;
  float nearest = INFINITY, farthest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    float p[3], q[3];
    corner_of(desc->casters_min, desc->casters_max, corner, p);
    to_axes(axes, p, q);
    box_add(&casters, q);
    for (int a = 0; a < 3; ++a) p[a] -= desc->eye[a];
    float depth = dot(p, desc->forward);
    if (depth < nearest) nearest = depth;
    if (depth > farthest) farthest = depth;
  }
  if (!(casters.min[0] <= casters.max[0]) || farthest <= 0) return 0;
  /* Shadows reach as far behind the casters as they are high, more or less. */
  farthest += casters.max[2] - casters.min[2];
  if (nearest < farthest * 0.004f) nearest = farthest * 0.004f;

  /* One cascade over all casters will do where its texels are no larger than the nearest pixels. */
  const float whole = fmaxf(casters.max[0] - casters.min[0], casters.max[1] - casters.min[1]);
  const bool single = whole < desc->pixel * nearest * (float)desc->size;

  uint32_t used = 0;
  float from = nearest < 1.0f ? 0 : nearest * 0.5f;
  for (uint32_t i = 0; i < desc->count; ++i) {
    float share = (float)(i + 1) / (float)desc->count;
    float even = nearest + (farthest - nearest) * share, steep = nearest * powf(farthest / nearest, share);
    float until = 0.35f * even + 0.65f * steep;
    box seen = nothing;
    for (int corner = 0; corner < 8; ++corner) {
      float depth = corner & 4 ? until : from, p[3], q[3];
      float x = corner & 1 ? 1.0f : -1.0f, y = corner & 2 ? 1.0f : -1.0f;
      for (int a = 0; a < 3; ++a) p[a] = desc->eye[a] + depth * (desc->forward[a] + x * desc->right[a] + y * desc->up[a]);
      to_axes(axes, p, q);
      box_add(&seen, q);
    }
    from = until;
    render_cascade* cascade = &cascades[used];
    memcpy(cascade->axes, axes, sizeof axes);
    float side = 0;
    bool empty = false, all = true;
    for (int a = 0; a < 2; ++a) {
      cascade->min[a] = single ? casters.min[a] : fmaxf(seen.min[a], casters.min[a]);
      cascade->max[a] = single ? casters.max[a] : fminf(seen.max[a], casters.max[a]);
      empty = empty || cascade->min[a] >= cascade->max[a];
      all = all && cascade->min[a] <= casters.min[a] && cascade->max[a] >= casters.max[a];
      side = fmaxf(side, cascade->max[a] - cascade->min[a]);
    }
    if (empty) continue;
    side *= 1.0f + 16.0f / (float)desc->size; /* room for filters at the rim */
    cascade->texel = side / (float)desc->size;
    for (int a = 0; a < 2; ++a) {
      float middle = 0.5f * (cascade->min[a] + cascade->max[a]);
      cascade->min[a] = middle - 0.5f * side;
      cascade->max[a] = middle + 0.5f * side;
    }
    cascade->min[2] = casters.min[2] - 0.01f * side;
    cascade->max[2] = casters.max[2] + 0.01f * side;
    ++used;
    if (all) break;
  }
  return used;
}

void render_cascade_clip(const render_cascade* cascade, float matrix[16]) {
  memset(matrix, 0, 16 * sizeof *matrix);
  for (int row = 0; row < 3; ++row) {
    float scale = 2.0f / (cascade->max[row] - cascade->min[row]);
    for (int a = 0; a < 3; ++a) matrix[4 * a + row] = cascade->axes[row][a] * scale;
    matrix[12 + row] = -cascade->min[row] * scale - 1.0f;
  }
  matrix[15] = 1;
}

void render_cascade_planes(const render_cascade* cascade, float planes[4][4]) {
  for (int axis = 0; axis < 2; ++axis)
    for (int a = 0; a < 3; ++a) {
      planes[2 * axis][a] = cascade->axes[axis][a];
      planes[2 * axis + 1][a] = -cascade->axes[axis][a];
    }
  for (int axis = 0; axis < 2; ++axis) {
    planes[2 * axis][3] = -cascade->min[axis];
    planes[2 * axis + 1][3] = cascade->max[axis];
  }
}
