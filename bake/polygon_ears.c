#include "polygon_ears.h"

#include <stdbool.h>

/* Corners in the plane, in a ring. In doubles: the places are, too, and near-flat ears are told by a share of their sides. */
typedef struct ring {
  const uint32_t* corners;
  ear_corner* at;
  uint32_t count; /* left */
} ring;

/* How an ear must be: sound ones first, then what is left of polygons that rounding or slivers have spoilt. */
typedef enum strictness { SOUND, NOT_CROSSED, ANY } strictness;

/* An ear flatter than this share of its longest side squared is none, nor one whose third side passes a corner as near as that. */
#define FLAT 1e-9
#define NO_EAR (-2.0)

static double doubled_area(const ring* r, uint32_t a, uint32_t b, uint32_t c) {
  return (r->at[b].x - r->at[a].x) * (r->at[c].y - r->at[a].y) - (r->at[b].y - r->at[a].y) * (r->at[c].x - r->at[a].x);
}

static double length2(const ring* r, uint32_t a, uint32_t b) {
  const double x = r->at[b].x - r->at[a].x, y = r->at[b].y - r->at[a].y;
  return x * x + y * y;
}

/* Whether a corner lies in the way of the ear a, b, c. Another corner with the same vertex does not: it is the other side of a
 * bridge. */
static bool is_blocked(const ring* r, uint32_t a, uint32_t b, uint32_t c, strictness how) {
  const double near = how == SOUND ? -FLAT * length2(r, a, c) : 0;
  for (uint32_t p = r->at[c].next; p != a; p = r->at[p].next) {
    const uint32_t vertex = r->corners[p];
    if (vertex == r->corners[a] || vertex == r->corners[b] || vertex == r->corners[c]) continue;
    const double third = doubled_area(r, c, a, p);
    if (how == SOUND ? third < near : third <= 0) continue;
    const double first = doubled_area(r, a, b, p), second = doubled_area(r, b, c, p);
    if (how == SOUND ? first >= 0 && second >= 0 : first > 0 && second > 0) return true;
  }
  return false;
}

/* Of the triangle before, b, next: its doubled area over its longest side squared, at most 0.87; NO_EAR if it may not be cut. */
static double ear_quality(const ring* r, uint32_t b, strictness how) {
  const uint32_t a = r->at[b].before, c = r->at[b].next;
  double longest = length2(r, a, b);
  const double second = length2(r, b, c), third = length2(r, c, a);
  if (second > longest) longest = second;
  if (third > longest) longest = third;
  const double quality = longest > 0 ? doubled_area(r, a, b, c) / longest : 0;
  if (how == ANY) return quality;
  if (quality <= (how == SOUND ? FLAT : 0) || is_blocked(r, a, b, c, how)) return NO_EAR;
  return quality;
}

static uint32_t best_ear(const ring* r, uint32_t start) {
  uint32_t best = start;
  for (uint32_t p = r->at[start].next; p != start; p = r->at[p].next) {
    const double quality = r->at[p].quality, most = r->at[best].quality;
    if (quality > most || (quality >= most && p < best)) best = p;
  }
  return best;
}

static void measure_all(ring* r, uint32_t start, strictness how) {
  uint32_t p = start;
  do {
    r->at[p].quality = ear_quality(r, p, how);
    p = r->at[p].next;
  } while (p != start);
}

static void unlink_corner(ring* r, uint32_t p) {
  r->at[r->at[p].before].next = r->at[p].next;
  r->at[r->at[p].next].before = r->at[p].before;
  --r->count;
}

/* Where the ring goes to a vertex and straight back, that is no triangle: its sides cancel. Returns a corner that is still there.
 */
static uint32_t drop_spikes(ring* r, uint32_t start) {
  uint32_t unchanged = 0, p = start;
  while (r->count > 2 && unchanged <= r->count) {
    const uint32_t a = r->at[p].before, c = r->at[p].next;
    if (r->corners[a] == r->corners[c]) {
      unlink_corner(r, p);
      unlink_corner(r, c);
      p = a;
      unchanged = 0;
    } else {
      p = c;
      ++unchanged;
    }
  }
  return p;
}

static void project(ring* r, const double* positions, uint32_t count, const double normal[3]) {
  uint32_t axis = 0;
  double most = -1;
  for (uint32_t k = 0; k < 3; ++k) {
    const double size = normal[k] < 0 ? -normal[k] : normal[k];
    if (size > most) most = size, axis = k;
  }
  const uint32_t u = (axis + 1) % 3, v = (axis + 2) % 3;
  const bool turned = normal[axis] < 0;
  const double* origin = positions + (size_t)3 * r->corners[0];
  for (uint32_t k = 0; k < count; ++k) {
    const double* p = positions + (size_t)3 * r->corners[k];
    const double pu = p[u] - origin[u], pv = p[v] - origin[v];
    r->at[k].x = turned ? pv : pu;
    r->at[k].y = turned ? pu : pv;
    r->at[k].next = k + 1 < count ? k + 1 : 0;
    r->at[k].before = k > 0 ? k - 1 : count - 1;
  }
}

uint32_t polygon_ears(const double* positions, const uint32_t* corners, uint32_t count, const double normal[3], ear_corner* scratch,
                      uint32_t* out) {
  if (count < 3) return 0;
  ring r = {corners, scratch, count};
  project(&r, positions, count, normal);
  uint32_t triangles = 0, start = drop_spikes(&r, 0);
  if (r.count < 3) return 0;
  measure_all(&r, start, SOUND);
  while (r.count > 3) {
    uint32_t ear = best_ear(&r, start);
    /* Only the ears beside a cut are measured anew: others may have become free, which is looked at when none is left. */
    for (strictness how = SOUND; r.at[ear].quality <= NO_EAR; ++how) {
      measure_all(&r, start, how);
      ear = best_ear(&r, start);
    }
    const uint32_t a = r.at[ear].before, c = r.at[ear].next;
    out[3 * triangles] = corners[a];
    out[3 * triangles + 1] = corners[ear];
    out[3 * triangles++ + 2] = corners[c];
    unlink_corner(&r, ear);
    start = a;
    if (r.count > 3 && (corners[r.at[a].before] == corners[c] || corners[r.at[c].next] == corners[a])) {
      start = drop_spikes(&r, a);
      if (r.count < 3) return triangles;
      measure_all(&r, start, SOUND);
      continue;
    }
    r.at[a].quality = ear_quality(&r, a, SOUND);
    r.at[c].quality = ear_quality(&r, c, SOUND);
  }
  if (r.count == 3 && corners[start] != corners[r.at[start].next] && corners[start] != corners[r.at[start].before] &&
      corners[r.at[start].next] != corners[r.at[start].before]) {
    out[3 * triangles] = corners[r.at[start].before];
    out[3 * triangles + 1] = corners[start];
    out[3 * triangles++ + 2] = corners[r.at[start].next];
  }
  return triangles;
}
