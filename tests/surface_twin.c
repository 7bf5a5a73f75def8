#include "surface_twin.h"

#include <stdlib.h>
#include <string.h>

typedef struct twin_edge {
  uint32_t low, high;
  int32_t way;
} twin_edge;

static int by_ends(const void* a, const void* b) {
  const twin_edge *x = a, *y = b;
  if (x->low != y->low) return x->low < y->low ? -1 : 1;
  return (x->high > y->high) - (x->high < y->high);
}

uint32_t twin_open_edges(const uint32_t* indices, uint32_t triangle_count) {
  twin_edge* edges = malloc((3 * (size_t)triangle_count + 1) * sizeof *edges);
  if (edges == NULL) abort();
  const uint32_t count = 3 * triangle_count;
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t from = indices[i], to = indices[i % 3 == 2 ? i - 2 : i + 1];
    edges[i] = (twin_edge){from < to ? from : to, from < to ? to : from, from < to ? 1 : from > to ? -1 : 0};
  }
  qsort(edges, count, sizeof *edges, by_ends);
  uint32_t open = 0;
  for (uint32_t i = 0; i < count;) {
    uint32_t end = i;
    int32_t sum = 0;
    for (; end < count && by_ends(&edges[i], &edges[end]) == 0; ++end) sum += edges[end].way;
    open += sum != 0;
    i = end;
  }
  free(edges);
  return open;
}

double twin_volume(const double* positions, const uint32_t* indices, uint32_t triangle_count) {
  double sum = 0;
  const double* origin = positions + 3 * (size_t)indices[0];
  for (uint32_t t = 0; t < triangle_count; ++t) {
    double p[3][3];
    for (uint32_t k = 0; k < 3; ++k)
      for (uint32_t a = 0; a < 3; ++a) p[k][a] = positions[3 * (size_t)indices[3 * t + k] + a] - origin[a];
    sum += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) + p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
           p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
  }
  return sum / 6;
}

static int by_place(const void* a, const void* b) {
  const scree_frost_vertex *x = *(const scree_frost_vertex*const*)a, *y = *(const scree_frost_vertex*const*)b;
  for (int k = 0; k < 3; ++k)
    if (x->position[k] != y->position[k]) return x->position[k] < y->position[k] ? -1 : 1;
  return 0;
}

void twin_join_places(const scree_frost_surface* surface, uint32_t* corners) {
  const uint32_t count = surface->vertex_count;
  const scree_frost_vertex** sorted = malloc((count + 1) * sizeof *sorted);
  uint32_t* place = malloc((count + 1) * sizeof *place);
  if (sorted == NULL || place == NULL) abort();
  for (uint32_t v = 0; v < count; ++v) sorted[v] = &surface->vertices[v];
  qsort(sorted, count, sizeof *sorted, by_place);
  uint32_t first = 0;
  for (uint32_t i = 0; i < count; ++i) {
    if (by_place(&sorted[first], &sorted[i]) != 0) first = i;
    place[sorted[i] - surface->vertices] = first;
  }
  const uint32_t triangles = surface->solid_triangles + surface->cut_triangles;
  for (uint32_t i = 0; i < 3 * triangles; ++i) corners[i] = place[surface->indices[i]];
  free(sorted);
  free(place);
}

/* By the signs of volumes: the ends of the ray lie on both sides of the plane, and the line turns the same way past all edges. */
bool twin_ray_meets(const double* c, const double start[3], const double direction[3], double farthest) {
  double end[3], side[2] = {0, 0}, past[3] = {0, 0, 0};
  for (int a = 0; a < 3; ++a) end[a] = start[a] + farthest * direction[a];
  for (int which = 0; which < 5; ++which) {
    const double* rows[5][4] = {{c, c + 3, c + 6, start},
                                {c, c + 3, c + 6, end},
                                {start, end, c, c + 3},
                                {start, end, c + 3, c + 6},
                                {start, end, c + 6, c}};
    double m[3][3];
    for (int i = 0; i < 3; ++i)
      for (int a = 0; a < 3; ++a) m[i][a] = rows[which][i + 1][a] - rows[which][0][a];
    const double volume = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                          m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    if (which < 2)
      side[which] = volume;
    else
      past[which - 2] = volume;
  }
  if (side[0] * side[1] > 0 || (side[0] == 0 && side[1] == 0)) return false;
  return (past[0] >= 0 && past[1] >= 0 && past[2] >= 0) || (past[0] <= 0 && past[1] <= 0 && past[2] <= 0);
}

uint64_t twin_digest(const void* bytes, size_t size) {
  uint64_t hash = UINT64_C(0xcbf29ce484222325);
  for (size_t i = 0; i < size; ++i) hash = (hash ^ ((const uint8_t*)bytes)[i]) * UINT64_C(0x100000001b3);
  return hash;
}
