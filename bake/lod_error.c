#include "lod_error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Squared distance from p to triangle abc. (Ericson, Real-Time Collision Detection, 2004, section 5.1.5.) */
static float triangle_distance2(const float p[3], const float a[3], const float b[3], const float c[3]) {
  float ab[3], ac[3], ap[3];
  for (int i = 0; i < 3; ++i) ab[i] = b[i] - a[i], ac[i] = c[i] - a[i], ap[i] = p[i] - a[i];
#define DOT(u, w) (u[0] * w[0] + u[1] * w[1] + u[2] * w[2])
  const float d1 = DOT(ab, ap), d2 = DOT(ac, ap), bb = DOT(ab, ab), cc = DOT(ac, ac), bc = DOT(ab, ac);
  /* Barycentric coordinates by regions: a, edge ab, b, edge ac, c, edge bc, inside. */
  const float d3 = d1 - bb, d4 = d2 - bc, d5 = d1 - bc, d6 = d2 - cc;
  float s = 0, t = 0; /* nearest point a + s ab + t ac */
  const float vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (d1 <= 0 && d2 <= 0) {
  } else if (d3 >= 0 && d4 <= d3) {
    s = 1;
  } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    s = d1 / (d1 - d3);
  } else if (d6 >= 0 && d5 <= d6) {
    t = 1;
  } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    t = d2 / (d2 - d6);
  } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    s = 1 - t;
  } else {
    const float inverse = 1 / (va + vb + vc);
    s = vb * inverse, t = vc * inverse;
  }
  float rest[3];
  for (int i = 0; i < 3; ++i) rest[i] = ap[i] - s * ab[i] - t * ac[i];
  return DOT(rest, rest);
#undef DOT
}

/* A coarse mesh with its triangles by vertex and its vertices by cube. */
typedef struct target {
  const mesh_buffer* mesh;
  const voxel_field* field;
  const uint32_t* first; /* triangles around vertex v: list[first[v]] .. list[first[v + 1] - 1] */
  const uint32_t* list;
  float longest;  /* edge */
  uint32_t* seen; /* by triangle: the last point that it was measured from, or NULL */
  uint32_t point;
} target;

static void sort_triangles(const mesh_buffer* mesh, uint32_t* first, uint32_t* list) {
  memset(first, 0, (mesh->vertex_count + 1) * sizeof *first);
  for (uint32_t i = 0; i < mesh->index_count; ++i) ++first[mesh->indices[i]];
  uint32_t sum = 0;
  for (uint32_t v = 0; v <= mesh->vertex_count; ++v) {
    const uint32_t count = v < mesh->vertex_count ? first[v] : 0;
    first[v] = sum;
    sum += count;
  }
  for (uint32_t i = 0; i < mesh->index_count; ++i) list[first[mesh->indices[i]]++] = i / 3;
  for (uint32_t v = mesh->vertex_count; v > 0; --v) first[v] = first[v - 1];
  first[0] = 0;
}

static void sort_vertices(const mesh_buffer* mesh, const voxel_field* field) {
  const size_t dy = field->width, dz = dy * field->height;
  memset(mesh->vertex_of, 255, dz * field->depth * sizeof *mesh->vertex_of);
  for (uint32_t v = 0; v < mesh->vertex_count; ++v)
    mesh->vertex_of[mesh->cells[v][0] + dy * mesh->cells[v][1] + dz * mesh->cells[v][2]] = v;
}

static float vertex_distance2(const target* to, const float p[3], uint32_t vertex) {
  float sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float d = p[axis] - (float)to->mesh->positions[vertex][axis];
    sum += d * d;
  }
  return sum;
}

/* Squared distance to the triangles around one vertex; stops early below `enough`. */
static float fan_distance2(const target* to, const float p[3], uint32_t vertex, float enough) {
  float least = vertex_distance2(to, p, vertex);
  for (uint32_t f = to->first[vertex]; f < to->first[vertex + 1] && least > enough; ++f) {
    if (to->seen != NULL) {
      uint32_t* seen = &to->seen[to->list[f]];
      if (*seen == to->point) continue;
      *seen = to->point;
    }
    const uint32_t* corner = to->mesh->indices + (size_t)to->list[f] * 3;
    float t[3][3];
    for (int k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis) t[k][axis] = (float)to->mesh->positions[corner[k]][axis];
    const float d2 = triangle_distance2(p, t[0], t[1], t[2]);
    if (d2 < least) least = d2;
  }
  return least;
}

/* Squared distance from a point to the coarse surface, or any number not above `enough` when it is surely not more than that. Only
 * the largest distance counts, so nearly all points are settled by the vertex of their own cube. */
static float distance2(const target* to, const int16_t position[3], float enough) {
  const voxel_field* field = to->field;
  const float p[3] = {position[0], position[1], position[2]};
  const uint32_t size[3] = {field->width, field->height, field->depth};
  uint32_t low[3], high[3], cube[3];
  for (int axis = 0; axis < 3; ++axis) {
    cube[axis] = (uint32_t)((position[axis] - field->origin[axis]) / field->step);
    low[axis] = cube[axis] < 1 ? 0 : cube[axis] - 1;
    high[axis] = cube[axis] + 2 > size[axis] - 1 ? size[axis] - 1 : cube[axis] + 2;
  }
  const size_t dy = field->width, dz = dy * field->height;
  const uint32_t own = to->mesh->vertex_of[cube[0] + dy * cube[1] + dz * cube[2]];
  float least = INFINITY;
  if (own != UINT32_MAX) {
    least = fan_distance2(to, p, own, enough);
    if (least <= enough) return least;
  }
  for (uint32_t z = low[2]; z < high[2]; ++z)
    for (uint32_t y = low[1]; y < high[1]; ++y)
      for (uint32_t x = low[0]; x < high[0]; ++x) {
        const uint32_t vertex = to->mesh->vertex_of[x + dy * y + dz * z];
        if (vertex == UINT32_MAX || vertex == own) continue;
        /* No point of the triangles around a vertex is farther from it than their longest edge. */
        if (sqrtf(vertex_distance2(to, p, vertex)) - to->longest > 1.001f * sqrtf(least)) continue;
        const float d2 = fan_distance2(to, p, vertex, enough);
        if (d2 <= enough) return d2;
        if (d2 < least) least = d2;
      }
  if (least < INFINITY) return least;
  /* A thin part that the coarse level lost: as far as its nearest vertex anywhere. */
  for (uint32_t vertex = 0; vertex < to->mesh->vertex_count; ++vertex) {
    const float d2 = vertex_distance2(to, p, vertex);
    if (d2 < least) least = d2;
  }
  return least;
}

static float longest_edge(const mesh_buffer* mesh) {
  int32_t most = 0;
  for (uint32_t i = 0; i < mesh->index_count; ++i) {
    const int16_t *a = mesh->positions[mesh->indices[i]], *b = mesh->positions[mesh->indices[i % 3 == 2 ? i - 2 : i + 1]];
    int32_t sum = 0;
    for (int axis = 0; axis < 3; ++axis) sum += (a[axis] - b[axis]) * (a[axis] - b[axis]);
    if (sum > most) most = sum;
  }
  return sqrtf((float)most);
}

float lod_error_capped(const mesh_buffer* fine, const mesh_buffer* coarse, const voxel_field* field, uint32_t* scratch,
                       const float* caps) {
  uint32_t* list = scratch + coarse->vertex_count + 1;
  sort_triangles(coarse, scratch, list);
  sort_vertices(coarse, field);
  const target to = {coarse, field, scratch, list, longest_edge(coarse), NULL, 0};
  float worst = 0;
  for (uint32_t v = 0; v < fine->vertex_count; ++v) {
    const float cap = caps != NULL ? caps[v] * caps[v] : INFINITY;
    if (cap <= worst) continue;
    const float d2 = distance2(&to, fine->positions[v], worst);
    if (d2 > worst) worst = d2 < cap ? d2 : cap;
  }
  return sqrtf(worst);
}

float lod_error(const mesh_buffer* fine, const mesh_buffer* coarse, const voxel_field* field, uint32_t* scratch) {
  return lod_error_capped(fine, coarse, field, scratch, NULL);
}

static int compare_floats(const void* a, const void* b) {
  const float x = *(const float*)a, y = *(const float*)b;
  return (x > y) - (x < y);
}

float lod_error_of_most(const mesh_buffer* fine, const mesh_buffer* coarse, const voxel_field* field, uint32_t* scratch,
                        float* distances) {
  enum { ENOUGH = 40 };
  uint32_t* list = scratch + coarse->vertex_count + 1;
  sort_triangles(coarse, scratch, list);
  sort_vertices(coarse, field);
  target to = {coarse, field, scratch, list, longest_edge(coarse), list + coarse->index_count, 0};
  memset(to.seen, 0, coarse->index_count / 3 * sizeof *to.seen);
  const uint32_t skip = fine->vertex_count / ENOUGH + 1;
  uint32_t count = 0;
  for (uint32_t v = 0; v < fine->vertex_count; v += skip) {
    ++to.point;
    distances[count++] = distance2(&to, fine->positions[v], 0);
  }
  qsort(distances, count, sizeof *distances, compare_floats);
  return sqrtf(distances[(95 * count + 99) / 100 - 1]);
}
