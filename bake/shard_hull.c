/* Corners of the convex hull of shards, those first that add most: a quickhull that may stop early. */
#include <math.h>
#include <string.h>

#include "shards_internal.h"
#include "vectors.h"

static const double FLAT = 1e-9; /* of the extent: points no farther out are in the hull */

typedef struct hull_face {
  uint32_t corners[3]; /* points, counter-clockwise seen from outside */
  double normal[3], offset;
  uint32_t farthest; /* the point farthest outside; UINT32_MAX = none */
  double distance;
} hull_face;

typedef struct hull {
  double (*points)[3];
  uint32_t point_count;
  hull_face* faces;
  uint32_t (*edges)[2]; /* of the hole that a new point leaves */
  uint32_t face_count, face_capacity;
  double flat;
} hull;

static double distance2(const double a[3], const double b[3]) {
  const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  return dot(d, d);
}

/* Of the points that are as far out as any, the one farthest from a fixed place: within a face of the hull that is a corner. */
static void look_outside(const hull* h, hull_face* face) {
  const double* from = h->points[face->corners[0]];
  double most = -1;
  face->farthest = UINT32_MAX;
  face->distance = h->flat;
  for (uint32_t i = 0; i < h->point_count; ++i) {
    const double distance = dot(face->normal, h->points[i]) - face->offset;
    if (distance > face->distance) face->distance = distance;
  }
  if (!(face->distance > h->flat)) return;
  for (uint32_t i = 0; i < h->point_count; ++i) {
    if (dot(face->normal, h->points[i]) - face->offset < face->distance - h->flat) continue;
    const double away = distance2(h->points[i], from);
    if (away > most) most = away, face->farthest = i;
  }
}

static void add_face(hull* h, uint32_t a, uint32_t b, uint32_t c) {
  hull_face* face = h->faces + h->face_count++;
  const double *p = h->points[a], *q = h->points[b], *r = h->points[c];
  const double u[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]}, v[3] = {r[0] - p[0], r[1] - p[1], r[2] - p[2]};
  *face = (hull_face){{a, b, c}, {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]}, 0, 0, 0};
  const double length = sqrt(dot(face->normal, face->normal));
  for (int axis = 0; axis < 3; ++axis) face->normal[axis] = length > 0 ? face->normal[axis] / length : 0;
  face->offset = dot(face->normal, p);
  look_outside(h, face);
}

/* Which comes first by x, then y, then z: the first and the last of all points are corners of the hull. */
static bool before(const double a[3], const double b[3]) {
  for (int axis = 0; axis < 2; ++axis)
    if (a[axis] != b[axis]) return a[axis] < b[axis];
  return a[2] < b[2];
}

/* The square of how far a point is from the line (normal NULL) or the plane of the first corners. */
static double away_from(const hull* h, const uint32_t corners[4], const double* normal, uint32_t point) {
  const double *p = h->points[corners[0]], *q = h->points[corners[1]], *r = h->points[point];
  const double d[3] = {r[0] - p[0], r[1] - p[1], r[2] - p[2]};
  if (normal != NULL) return dot(normal, d) * dot(normal, d);
  const double along[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
  const double n[3] = {along[1] * d[2] - along[2] * d[1], along[2] * d[0] - along[0] * d[2], along[0] * d[1] - along[1] * d[0]};
  return dot(n, n) / dot(along, along);
}

/* Of the points farthest from the line or plane, the one farthest from the first corner; UINT32_MAX where all lie in it. */
static uint32_t farthest_from(const hull* h, const uint32_t corners[4], const double* normal) {
  double most = 0, farthest = -1;
  uint32_t best = UINT32_MAX;
  for (uint32_t i = 0; i < h->point_count; ++i) {
    const double away = away_from(h, corners, normal, i);
    most = away > most ? away : most;
  }
  const double least = sqrt(most) - h->flat;
  if (!(least > 0)) return best;
  for (uint32_t i = 0; i < h->point_count; ++i) {
    if (away_from(h, corners, normal, i) < least * least) continue;
    const double far = distance2(h->points[i], h->points[corners[0]]);
    if (far > farthest) farthest = far, best = i;
  }
  return best;
}

/* The first four corners; fewer where all points lie in a plane, on a line or in one place. */
static uint32_t start(hull* h, uint32_t corners[4]) {
  uint32_t first = 0, last = 0;
  for (uint32_t i = 1; i < h->point_count; ++i) {
    if (before(h->points[i], h->points[first])) first = i;
    if (before(h->points[last], h->points[i])) last = i;
  }
  double longest = 0;
  for (uint32_t i = 0; i < h->point_count; ++i) {
    const double d2 = distance2(h->points[i], h->points[first]);
    longest = d2 > longest ? d2 : longest;
  }
  h->flat = FLAT * sqrt(longest);
  corners[0] = first;
  corners[1] = last;
  if (first == last || !(longest > 0)) return 1;
  corners[2] = farthest_from(h, corners, NULL);
  if (corners[2] == UINT32_MAX) return 2;
  const double *p = h->points[first], *q = h->points[last], *r = h->points[corners[2]];
  const double u[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]}, v[3] = {r[0] - p[0], r[1] - p[1], r[2] - p[2]};
  double normal[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  const double length = sqrt(dot(normal, normal));
  for (int axis = 0; axis < 3; ++axis) normal[axis] /= length;
  corners[3] = farthest_from(h, corners, normal);
  if (corners[3] == UINT32_MAX) return 3;
  const double* top = h->points[corners[3]];
  /* The first three go round as seen from the side away from the fourth. */
  if (dot(normal, top) > dot(normal, p)) {
    corners[1] = corners[2];
    corners[2] = last;
  }
  return 4;
}

/* Takes a point in: faces that see it go, the border of what they leave is joined to it. False where rounding made that border no
 * single loop; the hull is then as good as it gets. */
static bool add_point(hull* h, uint32_t point) {
  uint32_t edge_count = 0, seeing = 0;
  for (uint32_t f = 0; f < h->face_count; ++f) {
    const hull_face* face = h->faces + f;
    if (!(dot(face->normal, h->points[point]) - face->offset > h->flat)) continue;
    ++seeing;
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t a = face->corners[k], b = face->corners[k == 2 ? 0 : k + 1];
      uint32_t other = 0;
      while (other < edge_count && !(h->edges[other][0] == b && h->edges[other][1] == a)) ++other;
      if (other < edge_count) {
        --edge_count;
        h->edges[other][0] = h->edges[edge_count][0];
        h->edges[other][1] = h->edges[edge_count][1];
      } else {
        h->edges[edge_count][0] = a;
        h->edges[edge_count++][1] = b;
      }
    }
  }
  if (edge_count != seeing + 2 || h->face_count - seeing + edge_count > h->face_capacity) return false;
  uint32_t kept = 0;
  for (uint32_t f = 0; f < h->face_count; ++f)
    if (!(dot(h->faces[f].normal, h->points[point]) - h->faces[f].offset > h->flat)) h->faces[kept++] = h->faces[f];
  h->face_count = kept;
  for (uint32_t i = 0; i < edge_count; ++i) add_face(h, h->edges[i][0], h->edges[i][1], point);
  return true;
}

/* chosen: room for `capacity`. Returns how many there are. */
static uint32_t choose(hull* h, uint32_t* chosen, uint32_t capacity) {
  uint32_t count = start(h, chosen);
  if (count < 4) return count;
  add_face(h, chosen[0], chosen[1], chosen[2]);
  add_face(h, chosen[0], chosen[2], chosen[3]);
  add_face(h, chosen[2], chosen[1], chosen[3]);
  add_face(h, chosen[1], chosen[0], chosen[3]);
  while (count < capacity) {
    const hull_face* best = NULL;
    for (uint32_t f = 0; f < h->face_count; ++f)
      if (h->faces[f].farthest != UINT32_MAX && (best == NULL || h->faces[f].distance > best->distance)) best = h->faces + f;
    if (best == NULL) break;
    chosen[count] = best->farthest;
    if (!add_point(h, chosen[count++])) break;
  }
  return count;
}

/* Marks the vertices of some shards; returns how many there are. */
static uint32_t mark_vertices(const scree_shards_view* view, const uint32_t* list, uint32_t count, unsigned char* marks) {
  uint32_t marked = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const scree_shard* shard = view->shards + list[i];
    for (uint32_t k = 0; k < shard->link_count; ++k) {
      const scree_link* link = view->links + view->shard_links[shard->first_link + k];
      for (uint32_t p = 0; p < link->polygon_count; ++p) {
        const scree_polygon* polygon = view->polygons + link->first_polygon + p;
        for (uint32_t c = 0; c < polygon->corner_count; ++c) {
          unsigned char* mark = marks + view->corners[polygon->first_corner + c];
          marked += !*mark;
          *mark = 1;
        }
      }
    }
  }
  return marked;
}

scree_result scree_shards_hull(const scree_shards* shards, const uint32_t* list, uint32_t count, const double origin[3],
                               float* points, uint32_t capacity, uint32_t* point_count) {
  if (point_count != NULL) *point_count = 0;
  if (shards == NULL || list == NULL || count == 0 || origin == NULL || points == NULL || capacity < 4 || point_count == NULL)
    return SCREE_ERROR_INVALID_ARGUMENT;
  for (int axis = 0; axis < 3; ++axis)
    if (!isfinite(origin[axis])) return SCREE_ERROR_INVALID_ARGUMENT;
  const scree_shards_view* view = &shards->view;
  for (uint32_t i = 0; i < count; ++i)
    if (list[i] >= view->shard_count) return SCREE_ERROR_INVALID_ARGUMENT;
  const scree_allocator* allocator = &shards->allocator;
  unsigned char* marks = scree_rt_allocate_zeroed(allocator, view->vertex_count, 1);
  if (marks == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  hull h = {.point_count = mark_vertices(view, list, count, marks)};
  const uint32_t most = capacity < h.point_count ? capacity : h.point_count, total = h.point_count;
  h.face_capacity = 2 * most + 8;
  h.points = scree_rt_allocate(allocator, total, sizeof *h.points);
  h.faces = scree_rt_allocate(allocator, h.face_capacity, sizeof *h.faces);
  h.edges = scree_rt_allocate(allocator, h.face_capacity, 3 * sizeof *h.edges);
  uint32_t* chosen = scree_rt_allocate(allocator, most + (size_t)4, sizeof *chosen);
  scree_result result = SCREE_ERROR_OUT_OF_MEMORY;
  if (h.points != NULL && h.faces != NULL && h.edges != NULL && chosen != NULL) {
    uint32_t at = 0;
    for (uint32_t v = 0; v < view->vertex_count; ++v)
      if (marks[v]) {
        for (int axis = 0; axis < 3; ++axis) h.points[at][axis] = view->vertices[3 * (size_t)v + (size_t)axis] - origin[axis];
        ++at;
      }
    *point_count = choose(&h, chosen, most);
    for (uint32_t i = 0; i < *point_count; ++i)
      for (int axis = 0; axis < 3; ++axis) points[3 * (size_t)i + (size_t)axis] = (float)h.points[chosen[i]][axis];
    result = SCREE_OK;
  }
  scree_rt_release(allocator, marks, view->vertex_count, 1);
  scree_rt_release(allocator, h.points, total, sizeof *h.points);
  scree_rt_release(allocator, h.faces, h.face_capacity, sizeof *h.faces);
  scree_rt_release(allocator, h.edges, h.face_capacity, 3 * sizeof *h.edges);
  scree_rt_release(allocator, chosen, most + (size_t)4, sizeof *chosen);
  return result;
}
