#include "solid_inside.h"

#include <math.h>
#include <string.h>

enum { MOST_BINS = 1 << 18, MOST_ENTRIES = 32 /* a triangle */ };

static uint32_t bin_of(const solid_inside* s, int a, double x) {
  const double at = (x - s->min[a]) * s->step[a];
  return !(at > 0) ? 0 : at >= s->size[a] ? s->size[a] - 1 : (uint32_t)at;
}

/* The bins that a triangle lies in. */
static void bins_of(const solid_inside* s, uint32_t triangle, uint32_t low[2], uint32_t high[2]) {
  const uint32_t* v = s->indices + (size_t)3 * triangle;
  for (int a = 0; a < 2; ++a) {
    low[a] = UINT32_MAX, high[a] = 0;
    for (int k = 0; k < 3; ++k) {
      const uint32_t bin = bin_of(s, a, s->positions[(size_t)3 * v[k] + (size_t)(2 * a)]);
      if (bin < low[a]) low[a] = bin;
      if (bin > high[a]) high[a] = bin;
    }
  }
}

static size_t count_entries(const solid_inside* s, uint32_t triangle_count) {
  size_t entries = 0;
  for (uint32_t t = 0; t < triangle_count; ++t) {
    uint32_t low[2], high[2];
    bins_of(s, t, low, high);
    entries += (size_t)(high[0] - low[0] + 1) * (high[1] - low[1] + 1);
  }
  return entries;
}

/* About one triangle a bin; fewer bins where triangles are long. */
static void choose_bins(solid_inside* s, uint32_t triangle_count) {
  double max[2] = {0, 0};
  for (int a = 0; a < 2; ++a) s->min[a] = max[a] = s->positions[(size_t)3 * s->indices[0] + (size_t)(2 * a)];
  for (size_t i = 0; i < (size_t)3 * triangle_count; ++i)
    for (int a = 0; a < 2; ++a) {
      const double x = s->positions[(size_t)3 * s->indices[i] + (size_t)(2 * a)];
      if (x < s->min[a]) s->min[a] = x;
      if (x > max[a]) max[a] = x;
    }
  const double side[2] = {max[0] - s->min[0], max[1] - s->min[1]};
  for (double bins = triangle_count < MOST_BINS ? triangle_count : MOST_BINS;; bins /= 4) {
    const double density = side[0] > 0 && side[1] > 0 ? sqrt(bins / (side[0] * side[1])) : 0;
    for (int a = 0; a < 2; ++a) {
      const double count = floor(density * side[a]) + 1;
      s->size[a] = count < 4096 ? (uint32_t)count : 4096;
      s->step[a] = side[a] > 0 ? s->size[a] / side[a] : 0;
    }
    s->entries = count_entries(s, triangle_count);
    if (bins <= 1 || s->entries <= (size_t)MOST_ENTRIES * triangle_count) return;
  }
}

scree_result solid_inside_create(const double* positions, const uint32_t* indices, uint32_t triangle_count,
                                 const scree_allocator* allocator, solid_inside* out) {
  memset(out, 0, sizeof *out);
  out->positions = positions, out->indices = indices;
  choose_bins(out, triangle_count);
  const size_t bins = (size_t)out->size[0] * out->size[1];
  if (out->entries > UINT32_MAX) return SCREE_ERROR_OUT_OF_MEMORY;
  out->first = scree_rt_allocate_zeroed(allocator, bins + 1, sizeof *out->first);
  out->triangles = scree_rt_allocate(allocator, out->entries, sizeof *out->triangles);
  if (out->first == NULL || out->triangles == NULL) {
    solid_inside_free(out, allocator);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  for (int pass = 0; pass < 2; ++pass) { /* counts, shifted by one; then places */
    for (uint32_t t = triangle_count; t-- > 0;) {
      uint32_t low[2], high[2];
      bins_of(out, t, low, high);
      for (uint32_t z = low[1]; z <= high[1]; ++z)
        for (uint32_t x = low[0]; x <= high[0]; ++x) {
          uint32_t* at = &out->first[(size_t)z * out->size[0] + x];
          if (pass == 0)
            ++*at;
          else
            out->triangles[--*at] = t;
        }
    }
    if (pass == 0) { /* ends; what counts down from them leaves the beginnings */
      for (size_t i = 1; i < bins; ++i) out->first[i] += out->first[i - 1];
      out->first[bins] = (uint32_t)out->entries;
    }
  }
  return SCREE_OK;
}

void solid_inside_free(solid_inside* inside, const scree_allocator* allocator) {
  scree_rt_release(allocator, inside->first, (size_t)inside->size[0] * inside->size[1] + 1, sizeof *inside->first);
  scree_rt_release(allocator, inside->triangles, inside->entries, sizeof *inside->triangles);
  memset(inside, 0, sizeof *inside);
}

/* Whether the edge passes to the right (+x) of a point of the plane, and which way: +1 towards +z. Worked out from the lower vertex
 * to the higher one, so that both triangles of the edge get the same. */
static int32_t edge_turn(const double* positions, uint32_t from, uint32_t to, double x, double z) {
  const double *p = positions + (size_t)3 * (from < to ? from : to), *q = positions + (size_t)3 * (from < to ? to : from);
  const bool p_above = p[2] > z, q_above = q[2] > z;
  if (p_above == q_above) return 0;
  if (!(x < p[0] + (z - p[2]) / (q[2] - p[2]) * (q[0] - p[0]))) return 0;
  return q_above == (from < to) ? 1 : -1;
}

/* How the line through x, z passes a triangle: 0 not at all, +1 upwards out of the solid, -1 into it; and where. */
static int32_t cross_triangle(const solid_inside* s, uint32_t triangle, double x, double z, double* y) {
  const uint32_t* v = s->indices + (size_t)3 * triangle;
  int32_t turn = 0;
  for (int k = 0; k < 3; ++k) turn -= edge_turn(s->positions, v[k], v[(k + 1) % 3], x, z);
  if (turn == 0) return 0;
  const double *a = s->positions + (size_t)3 * v[0], *b = s->positions + (size_t)3 * v[1], *c = s->positions + (size_t)3 * v[2];
  const double wa = (b[0] - x) * (c[2] - z) - (b[2] - z) * (c[0] - x), wb = (c[0] - x) * (a[2] - z) - (c[2] - z) * (a[0] - x);
  const double wc = (a[0] - x) * (b[2] - z) - (a[2] - z) * (b[0] - x), sum = wa + wb + wc;
  const double low = fmin(a[1], fmin(b[1], c[1])), high = fmax(a[1], fmax(b[1], c[1]));
  double at = sum != 0 ? a[1] + (wb * (b[1] - a[1]) + wc * (c[1] - a[1])) / sum : (low + high) / 2;
  if (!(at > low)) at = low; /* slivers have no plane to speak of */
  if (at > high) at = high;
  *y = at;
  return turn;
}

static const uint32_t* bin_at(const solid_inside* s, double x, double z, uint32_t* count) {
  const size_t bin = (size_t)bin_of(s, 1, z) * s->size[0] + bin_of(s, 0, x);
  *count = s->first[bin + 1] - s->first[bin];
  return s->triangles + s->first[bin];
}

int32_t solid_winding(const solid_inside* inside, const double p[3]) {
  uint32_t count;
  const uint32_t* list = bin_at(inside, p[0], p[2], &count);
  int32_t winding = 0;
  for (uint32_t i = 0; i < count; ++i) {
    double y;
    const int32_t turn = cross_triangle(inside, list[i], p[0], p[2], &y);
    if (turn != 0 && y > p[1]) winding += turn;
  }
  return winding;
}

uint32_t solid_crossings(const solid_inside* inside, double x, double z, solid_crossing* out, uint32_t capacity) {
  uint32_t count, found = 0;
  const uint32_t* list = bin_at(inside, x, z, &count);
  for (uint32_t i = 0; i < count; ++i) {
    solid_crossing crossing;
    crossing.turn = cross_triangle(inside, list[i], x, z, &crossing.y);
    if (crossing.turn == 0) continue;
    if (found < capacity) {
      uint32_t at = found;
      for (; at > 0 && out[at - 1].y > crossing.y; --at) out[at] = out[at - 1];
      out[at] = crossing;
    }
    ++found;
  }
  return found;
}
