#include "camera.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DEGREES (3.14159265f / 180.0f)

static float clamp(float x, float low, float high) {
  return x < low ? low : x > high ? high : x;
}

void camera_look(camera* c, const float eye[3], const float target[3], float field_of_view) {
  float d[3], flat, length;
  for (int a = 0; a < 3; ++a) d[a] = target[a] - eye[a];
  memcpy(c->eye, eye, sizeof c->eye);
  flat = sqrtf(d[0] * d[0] + d[2] * d[2]);
  length = sqrtf(flat * flat + d[1] * d[1]);
  c->yaw = flat > 0 ? atan2f(d[0], -d[2]) : 0;
  c->pitch = clamp(length > 0 ? atan2f(d[1], flat) : 0, -89 * DEGREES, 89 * DEGREES);
  c->distance = length > 0 ? length : 1;
  c->field_of_view = field_of_view > 0 ? field_of_view : 45 * DEGREES;
}

void camera_axes(const camera* c, float forward[3], float right[3], float up[3]) {
  const float sy = sinf(c->yaw), cy = cosf(c->yaw), sp = sinf(c->pitch), cp = cosf(c->pitch);
  forward[0] = sy * cp;
  forward[1] = sp;
  forward[2] = -cy * cp;
  right[0] = cy;
  right[1] = 0;
  right[2] = sy;
  up[0] = -sy * sp;
  up[1] = cp;
  up[2] = cy * sp;
}

void camera_target(const camera* c, float target[3]) {
  float forward[3], right[3], up[3];
  camera_axes(c, forward, right, up);
  for (int a = 0; a < 3; ++a) target[a] = c->eye[a] + forward[a] * c->distance;
}

void camera_turn(camera* c, float yaw, float pitch) {
  float target[3], forward[3], right[3], up[3];
  camera_target(c, target);
  c->yaw = remainderf(c->yaw + yaw, 360 * DEGREES);
  c->pitch = clamp(c->pitch + pitch, -89 * DEGREES, 89 * DEGREES);
  if (c->free) return;
  camera_axes(c, forward, right, up);
  for (int a = 0; a < 3; ++a) c->eye[a] = target[a] - forward[a] * c->distance;
}

void camera_pan(camera* c, float x, float y) {
  float forward[3], right[3], up[3];
  camera_axes(c, forward, right, up);
  const float height = 2 * c->distance * tanf(0.5f * c->field_of_view);
  for (int a = 0; a < 3; ++a) c->eye[a] -= (right[a] * x + up[a] * y) * height;
}

void camera_zoom(camera* c, float factor) {
  float forward[3], right[3], up[3];
  camera_axes(c, forward, right, up);
  const float ahead = c->distance * (1 - factor);
  for (int a = 0; a < 3; ++a) c->eye[a] += forward[a] * ahead;
  if (!c->free) c->distance = clamp(c->distance * factor, 1e-3f, 1e6f);
}

void camera_fly(camera* c, float right, float up, float ahead) {
  float forward[3], side[3], above[3];
  camera_axes(c, forward, side, above);
  for (int a = 0; a < 3; ++a) c->eye[a] += side[a] * right + forward[a] * ahead + (a == 1 ? up : 0);
}

void camera_frame(camera* c, const float centre[3], float radius, float aspect) {
  float forward[3], right[3], up[3];
  camera_axes(c, forward, right, up);
  const float half_height = 0.5f * c->field_of_view, half_width = atanf(tanf(half_height) * aspect);
  c->distance = radius / sinf(half_height < half_width ? half_height : half_width);
  for (int a = 0; a < 3; ++a) c->eye[a] = centre[a] - forward[a] * c->distance;
}

void camera_ray(const camera* c, float x, float y, float aspect, float direction[3]) {
  float forward[3], right[3], up[3];
  camera_axes(c, forward, right, up);
  const float tangent = tanf(0.5f * c->field_of_view);
  for (int a = 0; a < 3; ++a) direction[a] = forward[a] + tangent * (x * aspect * right[a] + y * up[a]);
}

bool camera_project(const camera* c, const float point[3], float aspect, float* x, float* y) {
  float forward[3], right[3], up[3], depth = 0, across = 0, above = 0;
  camera_axes(c, forward, right, up);
  for (int a = 0; a < 3; ++a) {
    depth += (point[a] - c->eye[a]) * forward[a];
    across += (point[a] - c->eye[a]) * right[a];
    above += (point[a] - c->eye[a]) * up[a];
  }
  if (depth <= 1e-4f) return false;
  const float tangent = tanf(0.5f * c->field_of_view);
  *x = across / (depth * tangent * aspect);
  *y = above / (depth * tangent);
  return true;
}

bool camera_parse(const char* text, double eye[3], double target[3], double* field_of_view) {
  double values[7] = {0, 0, 0, 0, 0, 0, 45};
  int count = 0;
  for (;;) {
    char* end;
    if (count == 7) return false;
    values[count] = strtod(text, &end);
    if (end == text || !isfinite(values[count])) return false;
    ++count;
    if (*end == 0) break;
    if (*end != ',') return false;
    text = end + 1;
  }
  if (count < 6 || values[6] < 1 || values[6] > 170) return false;
  if (memcmp(values, values + 3, 3 * sizeof *values) == 0) return false;
  memcpy(eye, values, 3 * sizeof *values);
  memcpy(target, values + 3, 3 * sizeof *values);
  *field_of_view = values[6];
  return true;
}
