#include "shard_surface.h"

#include <stdlib.h>
#include <string.h>

#include "allocator.h"
#include "polygon_ears.h"

typedef struct edge {
  uint32_t from, to;
} edge;

/* A vertex of the shards is one of the solid's if it is no farther from it than this share of the solid's extent. */
#define SAME_PLACE 1e-9

typedef struct surface_work {
  const scree_shards_view* view;
  const uint8_t* inside;
  bool joints; /* triangles of several shards come apart */
  const scree_allocator* allocator;
  uint32_t* link_of;        /* of each polygon */
  uint32_t* triangle_first; /* the solid's triangle t has the polygons list[triangle_first[t]] .. [triangle_first[t + 1] - 1] */
  uint32_t* list;           /* polygons of exterior links of shards inside */
  uint8_t* needed;          /* of each vertex: a cut or a triangle in pieces has it */
  uint8_t* in_pieces;       /* of each triangle: its polygons stay apart, for what is inside is no simple one, or joints show */
  uint32_t* nearest;        /* of each vertex of the solid: the vertex of the shards, or UINT32_MAX */
  double* distance2;        /* and its distance */
  edge* edges;              /* of one triangle's polygons */
  uint32_t* loop;           /* corners */
  uint32_t* ears;           /* triangles of one polygon */
  ear_corner* ear_corners;
  uint32_t most_corners;
} surface_work;

static uint32_t shard_of(const surface_work* w, uint32_t polygon) {
  return w->view->links[w->link_of[polygon]].shards[0];
}

static bool is_cut(const surface_work* w, const scree_link* link) {
  return link->shards[1] != SCREE_NO_SHARD && (w->inside[link->shards[0]] != 0) != (w->inside[link->shards[1]] != 0);
}

/* --- Where vertices are. --- */

static double distance2_of(const double* a, const double* b) {
  double d2 = 0;
  for (uint32_t k = 0; k < 3; ++k) d2 += (a[k] - b[k]) * (a[k] - b[k]);
  return d2;
}

/* Whether two of its corners are as good as one place: which of them a vertex is, this triangle cannot tell. */
static bool is_doubtful(const scree_solid* solid, uint32_t triangle, double reach2) {
  for (uint32_t k = 0; k < 3; ++k)
    if (distance2_of(solid->positions + 3 * (size_t)solid->indices[3 * (size_t)triangle + k],
                     solid->positions + 3 * (size_t)solid->indices[3 * (size_t)triangle + (k + 1) % 3]) <= 4 * reach2)
      return true;
  return false;
}

static void near_corners(surface_work* w, const scree_polygon* polygon) {
  const scree_shards_view* view = w->view;
  for (uint32_t c = 0; c < polygon->corner_count; ++c)
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t v = view->corners[polygon->first_corner + c], s = view->solid->indices[3 * (size_t)polygon->triangle + k];
      const double d2 = distance2_of(view->vertices + 3 * (size_t)v, view->solid->positions + 3 * (size_t)s);
      if (d2 > w->distance2[s] || (d2 >= w->distance2[s] && w->nearest[s] <= v)) continue;
      w->distance2[s] = d2;
      w->nearest[s] = v;
    }
}

/* What is left around vertices all of whose triangles are doubtful: any that is no other vertex of the solid. */
static void take_corners(surface_work* w, const scree_polygon* polygon, double reach2, shard_place* places) {
  const scree_shards_view* view = w->view;
  for (uint32_t k = 0; k < 3; ++k) {
    const uint32_t s = view->solid->indices[3 * (size_t)polygon->triangle + k];
    for (uint32_t c = 0; c < polygon->corner_count && w->nearest[s] == UINT32_MAX; ++c) {
      const uint32_t v = view->corners[polygon->first_corner + c];
      if (places[v].kind == PLACE_VERTEX) continue;
      if (distance2_of(view->vertices + 3 * (size_t)v, view->solid->positions + 3 * (size_t)s) > reach2) continue;
      w->nearest[s] = v;
      places[v] = (shard_place){PLACE_VERTEX, {s, 0}};
    }
  }
}

static void find_nearest(surface_work* w, shard_place* places) {
  const scree_shards_view* view = w->view;
  double extent = 0;
  for (uint32_t a = 0; a < 3; ++a) extent += view->max[a] - view->min[a];
  const double reach2 = SAME_PLACE * extent * (SAME_PLACE * extent);
  for (uint32_t s = 0; s < view->solid->vertex_count; ++s) w->nearest[s] = UINT32_MAX, w->distance2[s] = reach2;
  bool doubts = false;
  for (uint32_t l = view->interior_link_count; l < view->link_count; ++l)
    for (uint32_t p = view->links[l].first_polygon; p < view->links[l].first_polygon + view->links[l].polygon_count; ++p)
      if (is_doubtful(view->solid, view->polygons[p].triangle, reach2))
        doubts = true;
      else
        near_corners(w, &view->polygons[p]);
  for (uint32_t s = 0; s < view->solid->vertex_count; ++s)
    if (w->nearest[s] != UINT32_MAX) places[w->nearest[s]] = (shard_place){PLACE_VERTEX, {s, 0}};
  for (uint32_t l = view->interior_link_count; doubts && l < view->link_count; ++l)
    for (uint32_t p = view->links[l].first_polygon; p < view->links[l].first_polygon + view->links[l].polygon_count; ++p)
      if (is_doubtful(view->solid, view->polygons[p].triangle, reach2)) take_corners(w, &view->polygons[p], reach2, places);
}

/* The edge that two triangles of the solid share. */
static bool shared_edge(const scree_solid* solid, uint32_t t, uint32_t u, uint32_t ends[2]) {
  uint32_t found = 0;
  ends[0] = ends[1] = 0;
  for (uint32_t k = 0; k < 3; ++k)
    for (uint32_t m = 0; m < 3 && found < 2; ++m)
      if (solid->indices[3 * (size_t)t + k] == solid->indices[3 * (size_t)u + m]) ends[found++] = solid->indices[3 * (size_t)t + k];
  if (found < 2) return false;
  if (ends[0] > ends[1]) {
    const uint32_t first = ends[0];
    ends[0] = ends[1];
    ends[1] = first;
  }
  return true;
}

static void find_places(surface_work* w, shard_place* places) {
  const scree_shards_view* view = w->view;
  for (uint32_t v = 0; v < view->vertex_count; ++v) places[v] = (shard_place){PLACE_INNER, {0, 0}};
  find_nearest(w, places);
  for (uint32_t l = view->interior_link_count; l < view->link_count; ++l)
    for (uint32_t p = view->links[l].first_polygon; p < view->links[l].first_polygon + view->links[l].polygon_count; ++p) {
      const scree_polygon* polygon = &view->polygons[p];
      for (uint32_t c = 0; c < polygon->corner_count; ++c) {
        shard_place* place = &places[view->corners[polygon->first_corner + c]];
        uint32_t ends[2];
        if (place->kind == PLACE_INNER)
          *place = (shard_place){PLACE_FACE, {polygon->triangle, 0}};
        else if (place->kind == PLACE_FACE && place->on[0] != polygon->triangle &&
                 shared_edge(view->solid, place->on[0], polygon->triangle, ends))
          *place = (shard_place){PLACE_EDGE, {ends[0], ends[1]}};
      }
    }
}

/* --- What of a triangle is inside, as one polygon. --- */

static int compare_edges(const void* a, const void* b) {
  const edge *x = a, *y = b;
  const uint32_t x_low = x->from < x->to ? x->from : x->to, y_low = y->from < y->to ? y->from : y->to;
  if (x_low != y_low) return x_low < y_low ? -1 : 1;
  const uint32_t x_high = x->from < x->to ? x->to : x->from, y_high = y->from < y->to ? y->to : y->from;
  if (x_high != y_high) return x_high < y_high ? -1 : 1;
  return (x->from > y->from) - (x->from < y->from);
}

static int compare_starts(const void* a, const void* b) {
  const edge *x = a, *y = b;
  return x->from != y->from ? (x->from < y->from ? -1 : 1) : (x->to > y->to) - (x->to < y->to);
}

/* Leaves the edges that no other cancels. */
static uint32_t cancel_edges(edge* edges, uint32_t count) {
  qsort(edges, count, sizeof *edges, compare_edges);
  uint32_t kept = 0;
  for (uint32_t i = 0; i < count;) {
    const edge first = edges[i];
    uint32_t end = i, same = 0, other = 0;
    for (; end < count; ++end) {
      const edge e = edges[end];
      if (e.from == first.from && e.to == first.to)
        ++same;
      else if (e.from == first.to && e.to == first.from)
        ++other;
      else
        break;
    }
    const edge back = {first.to, first.from};
    for (; same > other; ++other) edges[kept++] = first;
    for (; other > same; ++same) edges[kept++] = back;
    i = end;
  }
  return kept;
}

static const edge* edge_from(const edge* edges, uint32_t count, uint32_t vertex) {
  uint32_t low = 0, high = count;
  while (low < high) {
    const uint32_t middle = low + (high - low) / 2;
    if (edges[middle].from < vertex)
      low = middle + 1;
    else
      high = middle;
  }
  return &edges[low < count ? low : 0];
}

/* The border of what is inside of a triangle, into w->loop. Returns its length; 0 where it is not one polygon that meets itself
 * nowhere. */
static uint32_t find_loop(surface_work* w, uint32_t triangle) {
  const scree_shards_view* view = w->view;
  uint32_t count = 0;
  for (uint32_t i = w->triangle_first[triangle]; i < w->triangle_first[triangle + 1]; ++i) {
    const scree_polygon* polygon = &view->polygons[w->list[i]];
    const uint32_t* corners = view->corners + polygon->first_corner;
    for (uint32_t c = 0; c < polygon->corner_count; ++c)
      w->edges[count++] = (edge){corners[c], corners[c + 1 < polygon->corner_count ? c + 1 : 0]};
  }
  count = cancel_edges(w->edges, count);
  if (count < 3) return 0;
  qsort(w->edges, count, sizeof *w->edges, compare_starts);
  for (uint32_t i = 1; i < count; ++i)
    if (w->edges[i].from == w->edges[i - 1].from) return 0;
  uint32_t length = 0, at = w->edges[0].from;
  do {
    w->loop[length++] = at;
    at = edge_from(w->edges, count, at)->to;
  } while (at != w->edges[0].from && length < count);
  return at == w->edges[0].from && length == count ? count : 0;
}

/* --- Triangles. --- */

static void add_polygon(surface_work* w, const uint32_t* corners, uint32_t count, const double normal[3], bool turned,
                        uint32_t source, uint32_t shard, shard_surface* out) {
  const uint32_t ears = polygon_ears(w->view->vertices, corners, count, normal, w->ear_corners, w->ears);
  for (uint32_t t = 0; t < ears; ++t) {
    const uint32_t* c = w->ears + (size_t)3 * t;
    out->triangles[out->count++] = (shard_triangle){{c[0], c[turned ? 2 : 1], c[turned ? 1 : 2]}, source, shard};
  }
}

/* The solid's own, if a loop has only its corners. */
static bool add_whole(surface_work* w, uint32_t triangle, uint32_t count, uint32_t shard, shard_surface* out) {
  const uint32_t* corners = w->view->solid->indices + (size_t)3 * triangle;
  if (count != 3) return false;
  for (uint32_t turn = 0; turn < 3; ++turn) {
    bool same = true;
    for (uint32_t k = 0; k < 3; ++k) {
      const shard_place* place = &out->places[w->loop[(turn + k) % 3]];
      same = same && place->kind == PLACE_VERTEX && place->on[0] == corners[k];
    }
    if (!same) continue;
    out->triangles[out->count++] =
        (shard_triangle){{w->loop[turn], w->loop[(turn + 1) % 3], w->loop[(turn + 2) % 3]}, triangle, shard};
    return true;
  }
  return false;
}

static void triangle_normal(const scree_solid* solid, uint32_t triangle, double normal[3]) {
  const double *a = solid->positions + 3 * (size_t)solid->indices[3 * (size_t)triangle],
               *b = solid->positions + 3 * (size_t)solid->indices[3 * (size_t)triangle + 1],
               *c = solid->positions + 3 * (size_t)solid->indices[3 * (size_t)triangle + 2];
  for (uint32_t k = 0; k < 3; ++k) {
    const uint32_t u = (k + 1) % 3, v = (k + 2) % 3;
    normal[k] = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
  }
}

static void add_triangle(surface_work* w, uint32_t triangle, shard_surface* out) {
  const scree_shards_view* view = w->view;
  const uint32_t first = w->triangle_first[triangle], end = w->triangle_first[triangle + 1];
  if (first == end) return;
  double normal[3];
  triangle_normal(view->solid, triangle, normal);
  if (w->in_pieces[triangle]) {
    for (uint32_t i = first; i < end; ++i) {
      const scree_polygon* polygon = &view->polygons[w->list[i]];
      add_polygon(w, view->corners + polygon->first_corner, polygon->corner_count, normal, false, triangle, shard_of(w, w->list[i]),
                  out);
    }
    return;
  }
  const uint32_t length = find_loop(w, triangle);
  uint32_t count = 0, shard = UINT32_MAX;
  for (uint32_t i = 0; i < length; ++i) {
    const uint32_t v = w->loop[i];
    if (w->needed[v] || out->places[v].kind != PLACE_EDGE) w->loop[count++] = v;
  }
  for (uint32_t i = first; i < end; ++i)
    if (shard_of(w, w->list[i]) < shard) shard = shard_of(w, w->list[i]);
  if (!add_whole(w, triangle, count, shard, out)) add_polygon(w, w->loop, count, normal, false, triangle, shard, out);
}

static void add_cut(surface_work* w, uint32_t l, shard_surface* out) {
  const scree_link* link = &w->view->links[l];
  const bool turned = w->inside[link->shards[0]] == 0;
  for (uint32_t p = link->first_polygon; p < link->first_polygon + link->polygon_count; ++p) {
    const scree_polygon* polygon = &w->view->polygons[p];
    add_polygon(w, w->view->corners + polygon->first_corner, polygon->corner_count, link->normal, turned, l,
                link->shards[turned ? 1 : 0], out);
  }
}

/* --- All of it. --- */

static void need_corners(surface_work* w, uint32_t polygon) {
  const scree_polygon* p = &w->view->polygons[polygon];
  for (uint32_t c = 0; c < p->corner_count; ++c) w->needed[w->view->corners[p->first_corner + c]] = 1;
}

/* Polygons inside by triangle, and the corners of cuts. Returns how many corners all that is cut into triangles has. */
static uint32_t sort_polygons(surface_work* w) {
  const scree_shards_view* view = w->view;
  const uint32_t triangles = view->solid->triangle_count;
  uint32_t corners = 0;
  for (uint32_t l = 0; l < view->link_count; ++l) {
    const scree_link* link = &view->links[l];
    const bool exterior = link->shards[1] == SCREE_NO_SHARD, cut = is_cut(w, link);
    for (uint32_t p = link->first_polygon; p < link->first_polygon + link->polygon_count; ++p) {
      w->link_of[p] = l;
      if (exterior ? w->inside[link->shards[0]] == 0 : !cut) continue;
      corners += view->polygons[p].corner_count;
      if (view->polygons[p].corner_count > w->most_corners) w->most_corners = view->polygons[p].corner_count;
      if (cut)
        need_corners(w, p);
      else
        ++w->triangle_first[view->polygons[p].triangle];
    }
  }
  uint32_t sum = 0;
  for (uint32_t t = 0; t <= triangles; ++t) {
    const uint32_t here = w->triangle_first[t];
    w->triangle_first[t] = sum;
    sum += here;
  }
  for (uint32_t l = view->interior_link_count; l < view->link_count; ++l) {
    const scree_link* link = &view->links[l];
    for (uint32_t p = link->first_polygon; w->inside[link->shards[0]] && p < link->first_polygon + link->polygon_count; ++p)
      w->list[w->triangle_first[view->polygons[p].triangle]++] = p;
  }
  for (uint32_t t = triangles; t > 0; --t) w->triangle_first[t] = w->triangle_first[t - 1];
  w->triangle_first[0] = 0;
  for (uint32_t t = 0; t < triangles; ++t) {
    uint32_t of_triangle = 0;
    for (uint32_t i = w->triangle_first[t]; i < w->triangle_first[t + 1]; ++i)
      of_triangle += view->polygons[w->list[i]].corner_count;
    if (of_triangle > w->most_corners) w->most_corners = of_triangle;
  }
  return corners;
}

static bool work_create(surface_work* w) {
  const scree_shards_view* view = w->view;
  const scree_solid* solid = view->solid;
  w->link_of = scree_rt_allocate(w->allocator, view->polygon_count, sizeof *w->link_of);
  w->triangle_first = scree_rt_allocate_zeroed(w->allocator, (size_t)solid->triangle_count + 1, sizeof *w->triangle_first);
  w->list = scree_rt_allocate(w->allocator, view->polygon_count, sizeof *w->list);
  w->needed = scree_rt_allocate_zeroed(w->allocator, view->vertex_count, 1);
  w->in_pieces = scree_rt_allocate_zeroed(w->allocator, solid->triangle_count, 1);
  w->nearest = scree_rt_allocate(w->allocator, solid->vertex_count, sizeof *w->nearest);
  w->distance2 = scree_rt_allocate(w->allocator, solid->vertex_count, sizeof *w->distance2);
  return w->link_of != NULL && w->triangle_first != NULL && w->list != NULL && w->needed != NULL && w->in_pieces != NULL &&
         w->nearest != NULL && w->distance2 != NULL;
}

static bool polygons_create(surface_work* w) {
  w->edges = scree_rt_allocate(w->allocator, w->most_corners, sizeof *w->edges);
  w->loop = scree_rt_allocate(w->allocator, w->most_corners, sizeof *w->loop);
  w->ears = scree_rt_allocate(w->allocator, (size_t)3 * w->most_corners, sizeof *w->ears);
  w->ear_corners = scree_rt_allocate(w->allocator, w->most_corners, sizeof *w->ear_corners);
  return w->edges != NULL && w->loop != NULL && w->ears != NULL && w->ear_corners != NULL;
}

static void work_destroy(surface_work* w) {
  const scree_shards_view* view = w->view;
  const scree_solid* solid = view->solid;
  scree_rt_release(w->allocator, w->link_of, view->polygon_count, sizeof *w->link_of);
  scree_rt_release(w->allocator, w->triangle_first, (size_t)solid->triangle_count + 1, sizeof *w->triangle_first);
  scree_rt_release(w->allocator, w->list, view->polygon_count, sizeof *w->list);
  scree_rt_release(w->allocator, w->needed, view->vertex_count, 1);
  scree_rt_release(w->allocator, w->in_pieces, solid->triangle_count, 1);
  scree_rt_release(w->allocator, w->nearest, solid->vertex_count, sizeof *w->nearest);
  scree_rt_release(w->allocator, w->distance2, solid->vertex_count, sizeof *w->distance2);
  scree_rt_release(w->allocator, w->edges, w->most_corners, sizeof *w->edges);
  scree_rt_release(w->allocator, w->loop, w->most_corners, sizeof *w->loop);
  scree_rt_release(w->allocator, w->ears, (size_t)3 * w->most_corners, sizeof *w->ears);
  scree_rt_release(w->allocator, w->ear_corners, w->most_corners, sizeof *w->ear_corners);
}

static scree_result make_surface(surface_work* w, shard_surface* out) {
  const scree_shards_view* view = w->view;
  if (!work_create(w)) return SCREE_ERROR_OUT_OF_MEMORY;
  out->place_count = view->vertex_count;
  out->places = scree_rt_allocate(w->allocator, out->place_count, sizeof *out->places);
  if (out->places == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  find_places(w, out->places);
  const uint32_t corners = sort_polygons(w);
  if (corners == 0) return SCREE_OK;
  if (!polygons_create(w)) return SCREE_ERROR_OUT_OF_MEMORY;
  out->capacity = corners;
  out->triangles = scree_rt_allocate(w->allocator, corners, sizeof *out->triangles);
  if (out->triangles == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  for (uint32_t t = 0; t < view->solid->triangle_count; ++t) {
    const uint32_t polygons = w->triangle_first[t + 1] - w->triangle_first[t];
    if (polygons == 0 || (!(w->joints && polygons > 1) && find_loop(w, t) > 0)) continue;
    w->in_pieces[t] = 1;
    for (uint32_t i = w->triangle_first[t]; i < w->triangle_first[t + 1]; ++i) need_corners(w, w->list[i]);
  }
  for (uint32_t t = 0; t < view->solid->triangle_count; ++t) add_triangle(w, t, out);
  out->solid_count = out->count;
  for (uint32_t l = 0; l < view->interior_link_count; ++l)
    if (is_cut(w, &view->links[l])) add_cut(w, l, out);
  return SCREE_OK;
}

scree_result shard_surface_create(const scree_shards_view* shards, const uint8_t* inside, bool joints,
                                  const scree_allocator* allocator, shard_surface* out) {
  memset(out, 0, sizeof *out);
  const scree_allocator from = scree_rt_allocator_or_default(allocator);
  surface_work w = {.view = shards, .inside = inside, .joints = joints, .allocator = &from};
  const scree_result result = make_surface(&w, out);
  work_destroy(&w);
  if (result != SCREE_OK) shard_surface_destroy(out, &from);
  return result;
}

void shard_surface_destroy(shard_surface* surface, const scree_allocator* allocator) {
  const scree_allocator from = scree_rt_allocator_or_default(allocator);
  scree_rt_release(&from, surface->triangles, surface->capacity, sizeof *surface->triangles);
  scree_rt_release(&from, surface->places, surface->place_count, sizeof *surface->places);
  memset(surface, 0, sizeof *surface);
}
