#include "seed_mask.h"
#include "vectors.h"

#include <math.h>
#include <string.h>

enum { MOST_BOXES = 1 << 22, MOST_CROSSINGS = 256 };
enum { OUT_OF_REACH = 0, MARKED = 1, TOUCHED = 2 };

static double segment_distance2(const double p[3], const double a[3], const double b[3]) {
  double ab[3], ap[3];
  for (int i = 0; i < 3; ++i) ab[i] = b[i] - a[i], ap[i] = p[i] - a[i];
  const double length2 = dot(ab, ab);
  double t = length2 > 0 ? dot(ap, ab) / length2 : 0;
  if (!(t > 0)) t = 0;
  if (t > 1) t = 1;
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const double d = ap[i] - t * ab[i];
    sum += d * d;
  }
  return sum;
}

double mask_triangle_distance2(const double p[3], const double a[3], const double b[3], const double c[3]) {
  double ab[3], ac[3], ap[3];
  for (int i = 0; i < 3; ++i) ab[i] = b[i] - a[i], ac[i] = c[i] - a[i], ap[i] = p[i] - a[i];
  const double n[3] = {ab[1] * ac[2] - ab[2] * ac[1], ab[2] * ac[0] - ab[0] * ac[2], ab[0] * ac[1] - ab[1] * ac[0]};
  const double area2 = dot(n, n);
  if (area2 > 0) {
    const double u[3] = {ap[1] * ac[2] - ap[2] * ac[1], ap[2] * ac[0] - ap[0] * ac[2], ap[0] * ac[1] - ap[1] * ac[0]};
    const double v[3] = {ab[1] * ap[2] - ab[2] * ap[1], ab[2] * ap[0] - ab[0] * ap[2], ab[0] * ap[1] - ab[1] * ap[0]};
    const double s = dot(u, n) / area2, t = dot(v, n) / area2;
    if (s >= 0 && t >= 0 && s + t <= 1) {
      const double height = dot(ap, n);
      return height * height / area2;
    }
  }
  return fmin(segment_distance2(p, a, b), fmin(segment_distance2(p, b, c), segment_distance2(p, c, a)));
}

static size_t box_at(const seed_mask* m, uint32_t x, uint32_t y, uint32_t z) {
  return ((size_t)z * m->size[1] + y) * m->size[0] + x;
}

static uint32_t box_of(const seed_mask* m, int a, double x) {
  const double at = floor((x - m->min[a]) / m->step);
  return !(at > 0) ? 0 : at >= m->size[a] ? m->size[a] - 1 : (uint32_t)at;
}

/* Halves a block of boxes until those are left that the triangle touches. */
static void touch(seed_mask* m, const double* const corner[3], const uint32_t low[3], const uint32_t high[3]) {
  double middle[3], half2 = 0;
  int longest = 0;
  for (int a = 0; a < 3; ++a) {
    const double half = (high[a] - low[a] + 1) * m->step * 0.5;
    middle[a] = m->min[a] + low[a] * m->step + half;
    half2 += half * half;
    if (high[a] - low[a] > high[longest] - low[longest]) longest = a;
  }
  if (mask_triangle_distance2(middle, corner[0], corner[1], corner[2]) > half2 * (1 + 1e-9)) return;
  if (high[longest] == low[longest]) {
    m->marked[box_at(m, low[0], low[1], low[2])] = TOUCHED;
    return;
  }
  uint32_t first[3] = {high[0], high[1], high[2]}, second[3] = {low[0], low[1], low[2]};
  first[longest] = low[longest] + (high[longest] - low[longest]) / 2;
  second[longest] = first[longest] + 1;
  touch(m, corner, low, first);
  touch(m, corner, second, high);
}

static void touch_all(const seed_mask_desc* desc, seed_mask* m) {
  const double slack = m->step * 1e-9;
  for (size_t t = 0; t < desc->triangle_count; ++t) {
    const double* corner[3];
    for (size_t k = 0; k < 3; ++k) corner[k] = desc->positions + (size_t)3 * desc->indices[3 * t + k];
    uint32_t low[3], high[3];
    for (int a = 0; a < 3; ++a) {
      low[a] = box_of(m, a, fmin(corner[0][a], fmin(corner[1][a], corner[2][a])) - slack);
      high[a] = box_of(m, a, fmax(corner[0][a], fmax(corner[1][a], corner[2][a])) + slack);
    }
    touch(m, corner, low, high);
  }
}

static void spread(const seed_mask_desc* desc, seed_mask* m) {
  for (uint32_t z = 0; z < m->size[2]; ++z)
    for (uint32_t y = 0; y < m->size[1]; ++y)
      for (uint32_t x = 0; x < m->size[0]; ++x) {
        if (m->marked[box_at(m, x, y, z)] != TOUCHED) continue;
        const int32_t at[3] = {(int32_t)x, (int32_t)y, (int32_t)z};
        double p[3];
        for (int a = 0; a < 3; ++a) p[a] = m->min[a] + (at[a] + 0.5) * m->step;
        const double reach = (desc->reach != NULL ? desc->reach(desc->user, p) : desc->most) / m->step;
        const int32_t r = (int32_t)floor(reach) + 1;
        for (int32_t k = -r; k <= r; ++k)
          for (int32_t j = -r; j <= r; ++j)
            for (int32_t i = -r; i <= r; ++i) {
              const int32_t b[3] = {at[0] + i, at[1] + j, at[2] + k}, d[3] = {i < 0 ? -i : i, j < 0 ? -j : j, k < 0 ? -k : k};
              double gap2 = 0;
              bool within = true;
              for (int a = 0; a < 3; ++a) {
                within &= b[a] >= 0 && b[a] < (int32_t)m->size[a];
                if (d[a] > 1) gap2 += (double)(d[a] - 1) * (d[a] - 1);
              }
              if (!within || gap2 > reach * reach) continue;
              uint8_t* mark = &m->marked[box_at(m, (uint32_t)b[0], (uint32_t)b[1], (uint32_t)b[2])];
              if (*mark == OUT_OF_REACH) *mark = MARKED;
            }
      }
}

/* Boxes that no triangle touches lie inside or outside as a whole. */
static void fill(const solid_inside* inside, seed_mask* m) {
  solid_crossing crossings[MOST_CROSSINGS];
  for (uint32_t z = 0; z < m->size[2]; ++z)
    for (uint32_t x = 0; x < m->size[0]; ++x) {
      const double px = m->min[0] + (x + 0.5) * m->step, pz = m->min[2] + (z + 0.5) * m->step;
      const uint32_t count = solid_crossings(inside, px, pz, crossings, MOST_CROSSINGS);
      if (count == 0) continue;
      uint32_t next = 0;
      int32_t winding = 0; /* below all crossings */
      if (count <= MOST_CROSSINGS)
        for (uint32_t i = 0; i < count; ++i) winding += crossings[i].turn;
      for (uint32_t y = 0; y < m->size[1]; ++y) {
        const double p[3] = {px, m->min[1] + (y + 0.5) * m->step, pz};
        if (count > MOST_CROSSINGS)
          winding = solid_winding(inside, p);
        else
          for (; next < count && crossings[next].y <= p[1]; ++next) winding -= crossings[next].turn;
        uint8_t* mark = &m->marked[box_at(m, x, y, z)];
        if (*mark == OUT_OF_REACH && winding > 0) *mark = MARKED;
      }
    }
}

scree_result seed_mask_create(const seed_mask_desc* desc, const scree_allocator* allocator, seed_mask* out) {
  memset(out, 0, sizeof *out);
  double max[3];
  points_bounds(desc->positions, desc->vertex_count, out->min, max);
  for (out->step = desc->step;; out->step *= 1.25) {
    double boxes = 1;
    for (int a = 0; a < 3; ++a) {
      const double count = floor((max[a] - out->min[a] + 2 * desc->most) / out->step) + 3;
      boxes *= count;
      if (boxes <= MOST_BOXES) out->size[a] = (uint32_t)count;
    }
    if (boxes <= MOST_BOXES) break;
  }
  for (int a = 0; a < 3; ++a) out->min[a] -= (out->size[a] * out->step - (max[a] - out->min[a])) / 2;
  out->marked = scree_rt_allocate_zeroed(allocator, (size_t)out->size[0] * out->size[1] * out->size[2], 1);
  if (out->marked == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  touch_all(desc, out);
  if (desc->most > 0) spread(desc, out);
  if (desc->inside != NULL) fill(desc->inside, out);
  for (size_t i = 0; i < (size_t)out->size[0] * out->size[1] * out->size[2]; ++i) out->marked[i] = out->marked[i] != OUT_OF_REACH;
  return SCREE_OK;
}

void seed_mask_free(seed_mask* mask, const scree_allocator* allocator) {
  scree_rt_release(allocator, mask->marked, (size_t)mask->size[0] * mask->size[1] * mask->size[2], 1);
  memset(mask, 0, sizeof *mask);
}

bool seed_mask_has(const seed_mask* mask, const double p[3]) {
  size_t at = 0, row = 1;
  for (int a = 0; a < 3; ++a) {
    const double box = floor((p[a] - mask->min[a]) / mask->step);
    if (!(box >= 0 && box < mask->size[a])) return false;
    at += (size_t)box * row;
    row *= mask->size[a];
  }
  return mask->marked[at] != 0;
}
