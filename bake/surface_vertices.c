#include "surface_vertices.h"

#include <math.h>
#include <string.h>

#include "allocator.h"
#include "creases.h"
#include "lattice.h"
#include "triangle_tree.h"
#include "vectors.h"

/* --- Vertices: one for each place, normal, uv and material. --- */

typedef struct vertex_work {
  const surface_desc* desc;
  const scree_allocator* allocator;
  const shard_surface* source;
  double* normals; /* 9 a triangle of the solid */
  uint32_t* table; /* vertices of the surface by hash, UINT32_MAX = free */
  uint32_t table_size;
  scree_frost_vertex* vertices;
  uint32_t* place;
  uint32_t count;
} vertex_work;

static void unit(double n[3]) {
  const double length = sqrt(dot(n, n));
  for (uint32_t a = 0; a < 3; ++a) n[a] = length > 0 ? n[a] / length : a == 1;
}

/* How much each corner of a triangle of the solid has of a vertex: exact at corners, and on edges the same from both sides. */
static void weights_of(const vertex_work* w, uint32_t triangle, uint32_t vertex, double weights[3]) {
  const scree_solid* solid = w->desc->shards->solid;
  const uint32_t* corners = solid->indices + (size_t)3 * triangle;
  const shard_place* place = &w->source->places[vertex];
  const double* p = w->desc->shards->vertices + (size_t)3 * vertex;
  uint32_t low = 3, high = 3;
  for (uint32_t k = 0; k < 3; ++k) {
    weights[k] = 0;
    if (place->kind == PLACE_INNER || place->kind == PLACE_FACE) continue;
    if (corners[k] == place->on[0]) low = k;
    if (place->kind == PLACE_EDGE && corners[k] == place->on[1]) high = k;
  }
  if (place->kind == PLACE_VERTEX && low < 3) {
    weights[low] = 1;
    return;
  }
  double edge[3], off[3];
  if (low < 3 && high < 3) {
    const double *a = solid->positions + (size_t)3 * place->on[0], *b = solid->positions + (size_t)3 * place->on[1];
    for (uint32_t k = 0; k < 3; ++k) edge[k] = b[k] - a[k], off[k] = p[k] - a[k];
    const double length2 = dot(edge, edge), t = length2 > 0 ? dot(off, edge) / length2 : 0;
    weights[high] = t; /* polygons that walls cut may reach beyond their triangle */
    weights[low] = 1 - weights[high];
    return;
  }
  const double *a = solid->positions + (size_t)3 * corners[0], *b = solid->positions + (size_t)3 * corners[1],
               *c = solid->positions + (size_t)3 * corners[2];
  double side[3];
  for (uint32_t k = 0; k < 3; ++k) edge[k] = b[k] - a[k], side[k] = c[k] - a[k], off[k] = p[k] - a[k];
  const double uu = dot(edge, edge), uv = dot(edge, side), vv = dot(side, side), pu = dot(off, edge), pv = dot(off, side);
  const double determinant = uu * vv - uv * uv;
  weights[1] = determinant > 0 ? (pu * vv - pv * uv) / determinant : 0;
  weights[2] = determinant > 0 ? (pv * uu - pu * uv) / determinant : 0;
  weights[0] = 1 - weights[1] - weights[2];
}

static void solid_vertex(const vertex_work* w, uint32_t triangle, uint32_t vertex, scree_frost_vertex* out) {
  const float* uvs = w->desc->shards->solid->uvs;
  double weights[3], normal[3] = {0, 0, 0}, uv[2] = {0, 0};
  weights_of(w, triangle, vertex, weights);
  /* Corners that count for nothing stay out, so that both sides of an edge add the same numbers; two numbers add alike in any
   * order. */
  for (uint32_t k = 0; k < 3; ++k) {
    if (weights[k] == 0) continue;
    const double* corner = w->normals + (size_t)9 * triangle + 3 * k;
    for (uint32_t a = 0; a < 3; ++a) normal[a] += weights[k] * corner[a];
    for (uint32_t a = 0; a < 2 && uvs != NULL; ++a) uv[a] += weights[k] * (double)uvs[(size_t)6 * triangle + 2 * k + a];
  }
  unit(normal);
  for (uint32_t a = 0; a < 3; ++a) out->normal[a] = (float)normal[a];
  for (uint32_t a = 0; a < 2; ++a) out->uv[a] = (float)uv[a];
  out->material = SURFACE_SOLID;
}

/* Lengths along two directions in the plane of a cut, u level where it can be, v up the face: so beds look alike on all cuts. */
static void cut_uv(const double normal[3], const double p[3], float uv[2]) {
  double u[3] = {normal[2], 0, -normal[0]}, v[3];
  if (u[0] * u[0] + u[2] * u[2] < 1e-6) u[0] = 1, u[2] = 0;
  unit(u);
  for (uint32_t a = 0; a < 3; ++a) v[a] = normal[(a + 1) % 3] * u[(a + 2) % 3] - normal[(a + 2) % 3] * u[(a + 1) % 3];
  uv[0] = (float)dot(u, p);
  uv[1] = (float)dot(v, p);
}

static void cut_vertex(const vertex_work* w, const shard_triangle* triangle, const double place[3], scree_frost_vertex* out) {
  const scree_link* link = &w->desc->shards->links[triangle->source];
  const double sign = link->shards[0] == triangle->shard ? 1 : -1;
  double normal[3];
  for (uint32_t a = 0; a < 3; ++a) normal[a] = sign * link->normal[a];
  unit(normal);
  for (uint32_t a = 0; a < 3; ++a) out->normal[a] = (float)normal[a];
  cut_uv(normal, place, out->uv);
  out->material = SURFACE_CUT;
}

/* The solid's vertices may be those of several shards: the first that names one gives its shard. */
static bool same_vertex(const vertex_work* w, uint32_t at, uint32_t place, const scree_frost_vertex* v) {
  const scree_frost_vertex* known = &w->vertices[at];
  return w->place[at] == place && known->material == v->material && memcmp(known->normal, v->normal, sizeof v->normal) == 0 &&
         memcmp(known->uv, v->uv, sizeof v->uv) == 0 && (v->material == SURFACE_SOLID || known->shard == v->shard);
}

static uint32_t find_vertex(vertex_work* w, uint32_t place, const scree_frost_vertex* v) {
  uint64_t hash = hash_combine(place, v->material);
  for (uint32_t a = 0; a < 3; ++a) {
    uint32_t bits;
    memcpy(&bits, &v->normal[a], sizeof bits);
    hash = hash_combine(hash, bits);
  }
  uint32_t slot = (uint32_t)(hash & (w->table_size - 1));
  for (; w->table[slot] != UINT32_MAX; slot = (slot + 1) & (w->table_size - 1))
    if (same_vertex(w, w->table[slot], place, v)) return w->table[slot];
  w->table[slot] = w->count;
  w->vertices[w->count] = *v;
  w->place[w->count] = place;
  return w->count++;
}

static void make_vertices(vertex_work* w, uint32_t* indices) {
  const shard_surface* source = w->source;
  for (uint32_t t = 0; t < source->count; ++t)
    for (uint32_t k = 0; k < 3; ++k) {
      const shard_triangle* triangle = &source->triangles[t];
      const uint32_t place = triangle->corner[k];
      const double* at = w->desc->shards->vertices + (size_t)3 * place;
      scree_frost_vertex v = {.shard = triangle->shard};
      double p[3];
      for (uint32_t a = 0; a < 3; ++a) p[a] = at[a] - w->desc->origin[a];
      if (t < source->solid_count)
        solid_vertex(w, triangle->source, place, &v);
      else
        cut_vertex(w, triangle, p, &v);
      for (uint32_t a = 0; a < 3; ++a) {
        v.position[a] = (float)p[a] + 0.0f; /* no -0: places are compared as bytes */
        v.normal[a] += 0.0f;
      }
      indices[(size_t)3 * t + k] = find_vertex(w, place, &v);
    }
}

/* --- How open a place is: rays in a fixed set of directions, weighted by the cosine with the normal. --- */

enum { CHUNK = 256 };

typedef struct light {
  scree_frost_vertex* vertices;
  const uint32_t* place;
  const double* positions; /* of the shards */
  const triangle_tree* tree;
  double floor; /* below it all is dark; -INFINITY: nothing is */
  double extent;
  uint32_t count;
} light;

/* Along (x, y, z), whole numbers from -2 to 2 without a common factor, the cube's faces, edges, corners and (1, 1, 2): 50. */
static uint8_t openness(const light* l, uint32_t vertex) {
  const scree_frost_vertex* v = &l->vertices[vertex];
  const double n[3] = {(double)v->normal[0], (double)v->normal[1], (double)v->normal[2]};
  double start[3], open = 0, all = 0;
  for (uint32_t a = 0; a < 3; ++a) start[a] = l->positions[(size_t)3 * l->place[vertex] + a] + 1e-4 * l->extent * n[a];
  for (int32_t code = 0; code < 125; ++code) {
    const int32_t x = code % 5 - 2, y = code / 5 % 5 - 2, z = code / 25 - 2, square = x * x + y * y + z * z;
    if (square == 0 || square == 4 || square == 5 || square > 6) continue;
    double direction[3] = {x, y, z};
    unit(direction);
    const double weight = dot(direction, n);
    if (weight < 0.05) continue;
    all += weight;
    /* The ground is level and has no end. */
    if (direction[1] < 0 && l->floor > -INFINITY) continue;
    if (!triangle_tree_meets(l->tree, start, direction, 0, 4 * l->extent)) open += weight;
  }
  return all > 0 ? (uint8_t)(255 * open / all + 0.5) : 255;
}

static void light_chunk(void* context, uint32_t index, uint32_t worker) {
  const light* l = context;
  (void)worker;
  const uint32_t end = (index + 1) * CHUNK < l->count ? (index + 1) * CHUNK : l->count;
  for (uint32_t v = index * CHUNK; v < end; ++v) l->vertices[v].occlusion = openness(l, v);
}

static scree_result light_vertices(const surface_desc* desc, const surface_vertices* out, const scree_allocator* allocator) {
  const shard_surface* source = &out->source;
  const scree_shards_view* shards = desc->shards;
  uint32_t* corners = scree_rt_allocate(allocator, (size_t)3 * source->count, sizeof *corners);
  if (corners == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  for (uint32_t t = 0; t < source->count; ++t) memcpy(corners + (size_t)3 * t, source->triangles[t].corner, 3 * sizeof *corners);
  triangle_tree tree;
  const scree_result result = triangle_tree_create(shards->vertices, corners, source->count, allocator, &tree);
  if (result == SCREE_OK) {
    light l = {out->surface.vertices,    out->place, shards->vertices, &tree, desc->ground ? shards->min[1] : -INFINITY, 0,
               out->surface.vertex_count};
    /* Of what is lit, not of the solid: a block's own nooks matter as much as those of the whole. */
    const tree_node* all = &tree.nodes[0];
    for (uint32_t a = 0; a < 3; ++a)
      if (all->max[a] - all->min[a] > l.extent) l.extent = all->max[a] - all->min[a];
    const uint32_t chunks = (l.count + CHUNK - 1) / CHUNK;
    if (desc->jobs.parallel_for != NULL)
      desc->jobs.parallel_for(desc->jobs.user, chunks, light_chunk, &l);
    else
      for (uint32_t chunk = 0; chunk < chunks; ++chunk) light_chunk(&l, chunk, 0);
    triangle_tree_destroy(&tree);
  }
  scree_rt_release(allocator, corners, (size_t)3 * source->count, sizeof *corners);
  return result;
}

/* --- All of it. --- */

/* The surface's arrays are as long as there are vertices: their sizes follow from it. */
static scree_result keep_vertices(const vertex_work* w, const scree_allocator* allocator, surface_vertices* out) {
  scree_frost_surface* surface = &out->surface;
  surface->vertices = scree_rt_allocate(allocator, w->count, sizeof *surface->vertices);
  out->place = scree_rt_allocate(allocator, w->count, sizeof *out->place);
  surface->vertex_count = out->place_capacity = w->count;
  if (surface->vertices == NULL || out->place == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  memcpy(surface->vertices, w->vertices, w->count * sizeof *surface->vertices);
  memcpy(out->place, w->place, w->count * sizeof *out->place);
  return SCREE_OK;
}

static scree_result join_vertices(const surface_desc* desc, const scree_allocator* allocator, surface_vertices* out) {
  const scree_solid* solid = desc->shards->solid;
  const size_t normals = (size_t)9 * solid->triangle_count, corners = (size_t)3 * out->source.count;
  vertex_work w = {.desc = desc, .allocator = allocator, .source = &out->source, .table_size = 64};
  while (w.table_size < 2 * corners) w.table_size *= 2;
  scree_frost_surface* surface = &out->surface;
  surface->solid_triangles = out->source.solid_count;
  surface->cut_triangles = out->source.count - out->source.solid_count;
  surface->indices = scree_rt_allocate(allocator, corners, sizeof *surface->indices);
  w.normals = scree_rt_allocate(allocator, normals, sizeof *w.normals);
  w.table = scree_rt_allocate(allocator, w.table_size, sizeof *w.table);
  w.vertices = scree_rt_allocate(allocator, corners, sizeof *w.vertices);
  w.place = scree_rt_allocate(allocator, corners, sizeof *w.place);
  const bool complete = surface->indices != NULL && w.normals != NULL && w.table != NULL && w.vertices != NULL && w.place != NULL;
  scree_result result = complete ? crease_normals(solid, allocator, w.normals) : SCREE_ERROR_OUT_OF_MEMORY;
  if (result == SCREE_OK) {
    memset(w.table, 255, w.table_size * sizeof *w.table);
    make_vertices(&w, surface->indices);
    result = keep_vertices(&w, allocator, out);
  }
  scree_rt_release(allocator, w.normals, normals, sizeof *w.normals);
  scree_rt_release(allocator, w.table, w.table_size, sizeof *w.table);
  scree_rt_release(allocator, w.vertices, corners, sizeof *w.vertices);
  scree_rt_release(allocator, w.place, corners, sizeof *w.place);
  return result;
}

scree_result surface_vertices_create(const surface_desc* desc, const scree_allocator* allocator, surface_vertices* out) {
  memset(out, 0, sizeof *out);
  const scree_allocator from = scree_rt_allocator_or_default(allocator);
  scree_result result = shard_surface_create(desc->shards, desc->inside, desc->joints, &from, &out->source);
  if (result == SCREE_OK && out->source.count > 0) {
    result = join_vertices(desc, &from, out);
    if (result == SCREE_OK) result = light_vertices(desc, out, &from);
  }
  scree_frost_surface* surface = &out->surface;
  surface->memory = surface->vertex_count * sizeof *surface->vertices + (size_t)3 * out->source.count * sizeof *surface->indices;
  if (result != SCREE_OK) surface_vertices_destroy(out, &from);
  return result;
}

void surface_vertices_destroy(surface_vertices* vertices, const scree_allocator* allocator) {
  const scree_allocator from = scree_rt_allocator_or_default(allocator);
  scree_frost_surface_free(&from, &vertices->surface);
  scree_rt_release(&from, vertices->place, vertices->place_capacity, sizeof *vertices->place);
  shard_surface_destroy(&vertices->source, &from);
  memset(vertices, 0, sizeof *vertices);
}

void scree_frost_surface_free(const scree_allocator* allocator, scree_frost_surface* surface) {
  if (surface == NULL) return;
  const scree_allocator from = scree_rt_allocator_or_default(allocator);
  const size_t triangles = (size_t)surface->solid_triangles + surface->cut_triangles;
  scree_rt_release(&from, surface->vertices, surface->vertex_count, sizeof *surface->vertices);
  scree_rt_release(&from, surface->indices, 3 * triangles, sizeof *surface->indices);
  memset(surface, 0, sizeof *surface);
}
