#include "make_shards.h"

#include <stdlib.h>
#include <string.h>

#include "random.h"

/* The lattice while it is made, and the arrays of its shards. */
typedef struct lattice {
  uint32_t size[3];
  double* planes[3]; /* size[axis] + 1 places */
  scree_shards* shards;
  scree_shard* shard;
  scree_link* links;
  scree_polygon* polygons;
  uint32_t *corners, *shard_links, *neighbour_first, *neighbours;
  double *vertices, *positions;
  uint32_t* indices;
  float* uvs;
  uint32_t* surface; /* of each vertex: its index in the solid */
  uint32_t link_count, polygon_count, corner_count, triangle_count, surface_count;
} lattice;

static void* must(void* memory) {
  if (memory == NULL) abort();
  return memory;
}

static uint32_t box_at(const lattice* l, const uint32_t at[3]) {
  return at[0] + l->size[0] * (at[1] + l->size[1] * at[2]);
}

static uint32_t vertex_at(const lattice* l, const uint32_t at[3]) {
  return at[0] + (l->size[0] + 1) * (at[1] + (l->size[1] + 1) * at[2]);
}

/* The corners of a box's face, counter-clockwise from outside. side: 0 = low, 1 = high. */
static void face_corners(const lattice* l, const uint32_t box[3], int axis, int side, uint32_t out[4]) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  static const uint32_t walk[2][4][2] = {{{0, 0}, {0, 1}, {1, 1}, {1, 0}}, {{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  for (int i = 0; i < 4; ++i) {
    uint32_t at[3];
    at[axis] = box[axis] + (uint32_t)side;
    at[u] = box[u] + walk[side][i][0];
    at[v] = box[v] + walk[side][i][1];
    out[i] = vertex_at(l, at);
  }
}

static uint32_t surface_vertex(lattice* l, uint32_t vertex) {
  if (l->surface[vertex] == UINT32_MAX) {
    l->surface[vertex] = l->surface_count++;
    memcpy(l->positions + 3 * (size_t)l->surface[vertex], l->vertices + 3 * (size_t)vertex, 3 * sizeof(double));
  }
  return l->surface[vertex];
}

static void add_polygon(lattice* l, const uint32_t* corners, uint32_t count, uint32_t triangle) {
  l->polygons[l->polygon_count++] = (scree_polygon){l->corner_count, count, triangle};
  memcpy(l->corners + l->corner_count, corners, count * sizeof *corners);
  l->corner_count += count;
}

static void add_triangle(lattice* l, const uint32_t corners[3]) {
  const uint32_t triangle = l->triangle_count++;
  for (int i = 0; i < 3; ++i) {
    const uint32_t at = surface_vertex(l, corners[i]);
    l->indices[3 * (size_t)triangle + (size_t)i] = at;
    for (int a = 0; a < 2; ++a) {
      const int axis = 2 * a;
      const double* planes = l->planes[axis];
      const double place = (l->positions[3 * (size_t)at + (size_t)axis] - planes[0]) / (planes[l->size[axis]] - planes[0]);
      l->uvs[6 * (size_t)triangle + 2 * (size_t)i + (size_t)a] = (float)place;
    }
  }
  add_polygon(l, corners, 3, triangle);
}

static void add_link(lattice* l, const uint32_t box[3], int axis, int side, uint32_t other) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  scree_link* link = &l->links[l->link_count++];
  *link = (scree_link){.shards = {box_at(l, box), other}, .first_polygon = l->polygon_count};
  link->area = (l->planes[u][box[u] + 1] - l->planes[u][box[u]]) * (l->planes[v][box[v] + 1] - l->planes[v][box[v]]);
  link->normal[axis] = side != 0 ? 1 : -1;
  link->centroid[axis] = l->planes[axis][box[axis] + (uint32_t)side];
  link->centroid[u] = (l->planes[u][box[u] + 1] + l->planes[u][box[u]]) / 2;
  link->centroid[v] = (l->planes[v][box[v] + 1] + l->planes[v][box[v]]) / 2;
  uint32_t corners[4];
  face_corners(l, box, axis, side, corners);
  if (other == SCREE_NO_SHARD) {
    add_triangle(l, corners);
    add_triangle(l, (const uint32_t[3]){corners[0], corners[2], corners[3]});
  } else {
    add_polygon(l, corners, 4, UINT32_MAX);
  }
  link->polygon_count = l->polygon_count - link->first_polygon;
}

static void add_links(lattice* l, bool exterior) {
  uint32_t box[3];
  for (box[2] = 0; box[2] < l->size[2]; ++box[2])
    for (box[1] = 0; box[1] < l->size[1]; ++box[1])
      for (box[0] = 0; box[0] < l->size[0]; ++box[0])
        for (int axis = 0; axis < 3; ++axis) {
          const bool last = box[axis] + 1 == l->size[axis];
          if (exterior) {
            if (box[axis] == 0) add_link(l, box, axis, 0, SCREE_NO_SHARD);
            if (last) add_link(l, box, axis, 1, SCREE_NO_SHARD);
          } else if (!last) {
            uint32_t next[3] = {box[0], box[1], box[2]};
            ++next[axis];
            add_link(l, box, axis, 1, box_at(l, next));
          }
        }
}

static int by_number(const void* a, const void* b) {
  const uint32_t x = *(const uint32_t*)a, y = *(const uint32_t*)b;
  return x < y ? -1 : x > y;
}

static bool share_edge(const scree_link* a, const scree_link* b) {
  for (int axis = 0; axis < 3; ++axis)
    if (a->normal[axis] != 0) return b->normal[axis] == 0;
  return false;
}

/* Both graphs: links of shards, then links that share an edge of a shard, which are all of its links but those opposite. */
static void add_graphs(lattice* l, uint32_t shard_count) {
  for (uint32_t i = 0; i < l->link_count; ++i)
    for (int side = 0; side < 2; ++side)
      if (l->links[i].shards[side] != SCREE_NO_SHARD) ++l->shard[l->links[i].shards[side]].link_count;
  for (uint32_t s = 0, at = 0; s < shard_count; ++s) {
    l->shard[s].first_link = at;
    at += l->shard[s].link_count;
    l->shard[s].link_count = 0;
  }
  for (uint32_t i = 0; i < l->link_count; ++i)
    for (int side = 0; side < 2; ++side)
      if (l->links[i].shards[side] != SCREE_NO_SHARD) {
        scree_shard* s = &l->shard[l->links[i].shards[side]];
        l->shard_links[s->first_link + s->link_count++] = i;
      }
  uint32_t count = 0;
  for (uint32_t i = 0; i < l->link_count; ++i) {
    l->neighbour_first[i] = count;
    for (int side = 0; side < 2; ++side) {
      if (l->links[i].shards[side] == SCREE_NO_SHARD) continue;
      const scree_shard* s = &l->shard[l->links[i].shards[side]];
      for (uint32_t k = 0; k < s->link_count; ++k) {
        const uint32_t other = l->shard_links[s->first_link + k];
        if (other != i && share_edge(&l->links[i], &l->links[other])) l->neighbours[count++] = other;
      }
    }
    qsort(l->neighbours + l->neighbour_first[i], count - l->neighbour_first[i], sizeof *l->neighbours, by_number);
  }
  l->neighbour_first[l->link_count] = count;
}

/* Takes `count` things of `size` from the one allocation, or only counts them where `memory` is NULL. */
static void* take(char* memory, size_t* used, size_t count, size_t size) {
  void* at = memory != NULL ? memory + *used : NULL;
  *used += (count * size + 63) / 64 * 64;
  return at;
}

static size_t lay_out(lattice* l, char* memory, uint32_t boxes, uint32_t interior, uint32_t exterior, uint32_t vertices) {
  size_t used = 0;
  l->shard = take(memory, &used, boxes, sizeof *l->shard);
  l->links = take(memory, &used, interior + exterior, sizeof *l->links);
  l->polygons = take(memory, &used, interior + 2 * exterior, sizeof *l->polygons);
  l->corners = take(memory, &used, 4 * (size_t)interior + 6 * (size_t)exterior, sizeof *l->corners);
  l->vertices = take(memory, &used, 3 * (size_t)vertices, sizeof *l->vertices);
  l->shard_links = take(memory, &used, 2 * (size_t)interior + exterior, sizeof *l->shard_links);
  l->neighbour_first = take(memory, &used, (size_t)interior + exterior + 1, sizeof *l->neighbour_first);
  l->neighbours = take(memory, &used, 8 * (size_t)interior + 4 * (size_t)exterior, sizeof *l->neighbours);
  l->positions = take(memory, &used, 3 * (size_t)vertices, sizeof *l->positions);
  l->indices = take(memory, &used, 6 * (size_t)exterior, sizeof *l->indices);
  l->uvs = take(memory, &used, 12 * (size_t)exterior, sizeof *l->uvs);
  return used;
}

static void place_planes(lattice* l, uint64_t random_seed) {
  random_stream stream = {hash_mix(random_seed)};
  for (int axis = 0; axis < 3; ++axis) {
    l->planes[axis] = must(malloc((l->size[axis] + 1) * sizeof(double)));
    double at = 0;
    for (uint32_t i = 0; i <= l->size[axis]; ++i) {
      l->planes[axis][i] = at;
      at += random_seed != 0 ? 0.6 + 0.8 * random_unit(&stream) : 1;
    }
    const double middle = axis == 1 ? 0 : l->planes[axis][l->size[axis]] / 2;
    for (uint32_t i = 0; i <= l->size[axis]; ++i) l->planes[axis][i] -= middle;
  }
}

static void place_boxes(lattice* l) {
  uint32_t at[3];
  for (at[2] = 0; at[2] <= l->size[2]; ++at[2])
    for (at[1] = 0; at[1] <= l->size[1]; ++at[1])
      for (at[0] = 0; at[0] <= l->size[0]; ++at[0]) {
        for (int a = 0; a < 3; ++a) l->vertices[3 * (size_t)vertex_at(l, at) + (size_t)a] = l->planes[a][at[a]];
        if (at[0] == l->size[0] || at[1] == l->size[1] || at[2] == l->size[2]) continue;
        scree_shard* s = &l->shard[box_at(l, at)];
        *s = (scree_shard){.seed = box_at(l, at), .volume = 1};
        for (int a = 0; a < 3; ++a) {
          s->centroid[a] = (l->planes[a][at[a]] + l->planes[a][at[a] + 1]) / 2;
          s->volume *= l->planes[a][at[a] + 1] - l->planes[a][at[a]];
        }
      }
}

scree_shards* make_lattice(const uint32_t size[3], uint64_t random_seed, const scree_allocator* given) {
  const scree_allocator allocator = scree_rt_allocator_or_default(given);
  lattice l = {.size = {size[0], size[1], size[2]}};
  const uint32_t boxes = size[0] * size[1] * size[2], vertices = (size[0] + 1) * (size[1] + 1) * (size[2] + 1);
  const uint32_t exterior = 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
  const uint32_t interior = 3 * boxes - exterior / 2;
  scree_shards* shards = must(scree_rt_allocate_zeroed(&allocator, 1, sizeof *shards));
  shards->allocator = allocator;
  shards->size = lay_out(&l, NULL, boxes, interior, exterior, vertices);
  shards->memory = must(scree_rt_allocate_zeroed(&allocator, shards->size, 1));
  lay_out(&l, shards->memory, boxes, interior, exterior, vertices);
  l.surface = must(malloc(vertices * sizeof *l.surface));
  memset(l.surface, 0xff, vertices * sizeof *l.surface);
  place_planes(&l, random_seed);
  place_boxes(&l);
  add_links(&l, false);
  add_links(&l, true);
  add_graphs(&l, boxes);

  shards->solid = (scree_solid){l.positions, l.indices, l.uvs, l.surface_count, l.triangle_count};
  scree_shards_view* v = &shards->view;
  *v = (scree_shards_view){.shards = l.shard,
                           .links = l.links,
                           .polygons = l.polygons,
                           .corners = l.corners,
                           .vertices = l.vertices,
                           .shard_links = l.shard_links,
                           .neighbour_first = l.neighbour_first,
                           .neighbours = l.neighbours,
                           .shard_count = boxes,
                           .link_count = l.link_count,
                           .interior_link_count = interior,
                           .polygon_count = l.polygon_count,
                           .corner_count = l.corner_count,
                           .vertex_count = vertices,
                           .clip = SCREE_CLIP_WALLS,
                           .solid = &shards->solid};
  double area = 0;
  for (uint32_t i = 0; i < l.link_count; ++i) area += i < interior ? 2 * l.links[i].area : l.links[i].area;
  v->mean_link_area = area / (2.0 * interior + exterior);
  for (uint32_t s = 0; s < boxes; ++s) v->volume += l.shard[s].volume;
  for (int a = 0; a < 3; ++a) {
    v->min[a] = l.planes[a][0];
    v->max[a] = l.planes[a][size[a]];
    free(l.planes[a]);
  }
  free(l.surface);
  return shards;
}
