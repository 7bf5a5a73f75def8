#include <math.h>
#include <string.h>

#include "shard_clip.h"

/* Seen from above: x and z are the plane, the ray goes up along y. */

static void span(const clip_rays* rays, double low, double high, int axis, uint32_t out[2]) {
  const double last = (double)rays->size[axis] - 1;
  const double a = (low - rays->min[axis]) * rays->scale[axis], b = (high - rays->min[axis]) * rays->scale[axis];
  out[0] = !(a > 0) ? 0 : a > last ? (uint32_t)last : (uint32_t)a;
  out[1] = !(b > 0) ? 0 : b > last ? (uint32_t)last : (uint32_t)b;
}

static uint32_t least(uint32_t a, uint32_t b, uint32_t c) {
  const uint32_t d = a < b ? a : b;
  return d < c ? d : c;
}

static uint32_t most(uint32_t a, uint32_t b, uint32_t c) {
  const uint32_t d = a > b ? a : b;
  return d > c ? d : c;
}

/* A vertex in its bin: x in the low half, z in the high one. */
static uint32_t bin_of(const clip_rays* rays, const double at[3]) {
  uint32_t x[2], z[2];
  span(rays, at[0], at[0], 0, x);
  span(rays, at[2], at[2], 1, z);
  return z[0] << 16 | x[0];
}

/* The bins of a triangle's box. Rounding never turns the order of places round, so its corners' bins say them. */
static void spans(const clip_rays* rays, const uint32_t* bins, uint32_t t, uint32_t x[2], uint32_t z[2]) {
  const uint32_t* triangle = &rays->input->indices[3 * (size_t)t];
  const uint32_t a = bins[triangle[0]], b = bins[triangle[1]], c = bins[triangle[2]];
  x[0] = least(a & 0xffff, b & 0xffff, c & 0xffff);
  x[1] = most(a & 0xffff, b & 0xffff, c & 0xffff);
  z[0] = least(a >> 16, b >> 16, c >> 16);
  z[1] = most(a >> 16, b >> 16, c >> 16);
}

scree_result clip_rays_create(const shard_input* input, const clip_box* solid, const scree_allocator* allocator, clip_rays* out) {
  *out = (clip_rays){.input = input};
  double side = sqrt((double)input->triangle_count) / 1.5;
  side = side < 8 ? 8 : side > 512 ? 512 : side;
  for (int axis = 0; axis < 2; ++axis) {
    const double length = solid->max[2 * axis] - solid->min[2 * axis];
    out->size[axis] = (uint32_t)side;
    out->min[axis] = solid->min[2 * axis];
    out->scale[axis] = length > 0 ? (double)out->size[axis] / length : 0;
  }
  const size_t bins = (size_t)out->size[0] * out->size[1];
  uint32_t* bin_of_vertex = scree_rt_allocate(allocator, input->vertex_count, sizeof *bin_of_vertex);
  out->first = scree_rt_allocate_zeroed(allocator, bins + 1, sizeof *out->first);
  size_t total = 0;
  if (bin_of_vertex != NULL && out->first != NULL) {
    for (uint32_t v = 0; v < input->vertex_count; ++v) bin_of_vertex[v] = bin_of(out, &input->positions[3 * (size_t)v]);
    for (uint32_t t = 0; t < input->triangle_count; ++t) {
      uint32_t x[2], z[2];
      spans(out, bin_of_vertex, t, x, z);
      total += (size_t)(x[1] - x[0] + 1) * (z[1] - z[0] + 1);
      if (total >= UINT32_MAX) break;
      for (uint32_t b = z[0]; b <= z[1]; ++b)
        for (uint32_t a = x[0]; a <= x[1]; ++a) ++out->first[(size_t)b * out->size[0] + a];
    }
    if (total < UINT32_MAX) out->triangles = scree_rt_allocate(allocator, total, sizeof *out->triangles);
  }
  if (out->triangles != NULL) {
    out->triangle_count = total;
    uint32_t sum = 0;
    for (size_t k = 0; k <= bins; ++k) {
      sum += out->first[k];
      out->first[k] = sum;
    }
    for (uint32_t t = input->triangle_count; t-- > 0;) {
      uint32_t x[2], z[2];
      spans(out, bin_of_vertex, t, x, z);
      for (uint32_t b = z[0]; b <= z[1]; ++b)
        for (uint32_t a = x[0]; a <= x[1]; ++a) out->triangles[--out->first[(size_t)b * out->size[0] + a]] = t;
    }
  }
  scree_rt_release(allocator, bin_of_vertex, input->vertex_count, sizeof *bin_of_vertex);
  if (out->triangles != NULL) return SCREE_OK;
  clip_rays_free(out, allocator);
  return SCREE_ERROR_OUT_OF_MEMORY;
}

void clip_rays_free(clip_rays* rays, const scree_allocator* allocator) {
  scree_rt_release(allocator, rays->first, (size_t)rays->size[0] * rays->size[1] + 1, sizeof *rays->first);
  scree_rt_release(allocator, rays->triangles, rays->triangle_count, sizeof *rays->triangles);
  *rays = (clip_rays){0};
}

/* Twice the area of origin, a, b seen from above; its rounding is added to `error`. */
static double turn(const double a[3], const double b[3], double* error) {
  const double p = a[0] * b[2], q = a[2] * b[0];
  *error = 1e-15 * (fabs(p) + fabs(q));
  return p - q;
}

/* What a triangle adds to how often a point is inside: seen from the origin of d, upwards. */
static clip_place cross_one(const double d[3][3], int* winding) {
  double turns[3], errors[3];
  int over = 0, under = 0, unsure = 0;
  for (int c = 0; c < 3; ++c) {
    turns[c] = turn(d[c], d[(c + 1) % 3], &errors[c]);
    if (fabs(turns[c]) <= errors[c])
      ++unsure;
    else if (turns[c] > 0)
      ++over;
    else
      ++under;
  }
  if (over > 0 && under > 0) return CLIP_OUTSIDE;
  if (d[0][1] < 0 && d[1][1] < 0 && d[2][1] < 0) return CLIP_OUTSIDE;
  if (unsure > 0) return CLIP_UNSURE;
  /* Height of the triangle over the point, times an area of the sign of the turns. */
  double height = 0, error = 0;
  for (int c = 0; c < 3; ++c) {
    const double y = d[(c + 2) % 3][1];
    height += turns[c] * y;
    error += (errors[c] + 1e-15 * fabs(turns[c])) * fabs(y);
  }
  if (fabs(height) <= 2 * error) return CLIP_UNSURE;
  if ((height > 0) != (over > 0)) return CLIP_OUTSIDE;
  /* x to z turns the other way round seen from above: a triangle that faces up has negative turns. */
  *winding += over > 0 ? -1 : 1;
  return CLIP_INSIDE;
}

clip_place clip_rays_place(const clip_rays* rays, const double point[3]) {
  uint32_t x[2], z[2];
  span(rays, point[0], point[0], 0, x);
  span(rays, point[2], point[2], 1, z);
  const size_t bin = (size_t)z[0] * rays->size[0] + x[0];
  int winding = 0;
  for (uint32_t k = rays->first[bin]; k < rays->first[bin + 1]; ++k) {
    const uint32_t* triangle = &rays->input->indices[3 * (size_t)rays->triangles[k]];
    double d[3][3];
    for (int c = 0; c < 3; ++c)
      for (int axis = 0; axis < 3; ++axis) d[c][axis] = rays->input->positions[3 * (size_t)triangle[c] + axis] - point[axis];
    if (cross_one((const double(*)[3])d, &winding) == CLIP_UNSURE) return CLIP_UNSURE;
  }
  return winding == 0 ? CLIP_OUTSIDE : winding == 1 ? CLIP_INSIDE : CLIP_CROSSED;
}
