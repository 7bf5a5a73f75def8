#include "mesh_normals.h"

#include <math.h>
#include <string.h>

/* Sums of three numbers a vertex. Rocks of any usual size fit int32, which is twice as fast; the bound in scree_rt_mesh_normals()
 * says when.
 */
#define DEFINE_SUM_NORMALS(name, integer)                                                                               \
  static void name(const scree_vertex* vertices, const uint32_t* indices, uint32_t triangle_count, integer(*sums)[3]) { \
    for (uint32_t triangle = 0; triangle < triangle_count; ++triangle) {                                                \
      const uint32_t* corner = indices + 3 * (size_t)triangle;                                                          \
      const int16_t* a = vertices[corner[0]].position;                                                                  \
      const int16_t* b = vertices[corner[1]].position;                                                                  \
      const int16_t* c = vertices[corner[2]].position;                                                                  \
      const integer ux = b[0] - a[0], uy = b[1] - a[1], uz = b[2] - a[2];                                               \
      const integer vx = c[0] - a[0], vy = c[1] - a[1], vz = c[2] - a[2];                                               \
      const integer nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;                             \
      for (int i = 0; i < 3; ++i) {                                                                                     \
        integer* sum = sums[corner[i]];                                                                                 \
        sum[0] += nx;                                                                                                   \
        sum[1] += ny;                                                                                                   \
        sum[2] += nz;                                                                                                   \
      }                                                                                                                 \
    }                                                                                                                   \
  }
DEFINE_SUM_NORMALS(sum_normals_32, int32_t)
DEFINE_SUM_NORMALS(sum_normals_64, int64_t)

/* Rounds to nearest; |value| <= 32767 up to rounding. Truncation of a positive number is floor, without the call. */
static int16_t round_component(float value) {
  return (int16_t)((int32_t)(value + 32768.5f) - 32768);
}

static void set_normal(float x, float y, float z, int16_t normal[3]) {
  const float squared = x * x + y * y + z * z;
  const float scale = squared > 0 ? 32767.0f / sqrtf(squared) : 0;
  normal[0] = round_component(x * scale);
  normal[1] = squared > 0 ? round_component(y * scale) : 32767;
  normal[2] = round_component(z * scale);
}

void scree_rt_mesh_normal(const int64_t sum[3], int16_t normal[3]) {
  set_normal((float)sum[0], (float)sum[1], (float)sum[2], normal);
}

/* The largest distance of two vertices along an axis. */
static uint32_t extent(const scree_vertex* vertices, uint32_t vertex_count) {
  int32_t greatest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    int32_t low = INT16_MAX, high = INT16_MIN;
    for (uint32_t i = 0; i < vertex_count; ++i) {
      const int32_t p = vertices[i].position[axis];
      low = p < low ? p : low;
      high = p > high ? p : high;
    }
    greatest = high - low > greatest ? high - low : greatest;
  }
  return (uint32_t)greatest;
}

void scree_rt_mesh_normals(scree_vertex* vertices, uint32_t vertex_count, const uint32_t* indices, uint32_t triangle_count,
                           void* scratch) {
  const uint64_t reach = extent(vertices, vertex_count);
  /* A component of a cross product is at most 2 reach^2, and a vertex has at most all triangles around it. */
  if (2 * reach * reach < (UINT64_C(1) << 31) / ((uint64_t)triangle_count + 1)) {
    int32_t(*sums)[3] = scratch;
    memset(sums, 0, vertex_count * sizeof *sums);
    sum_normals_32(vertices, indices, triangle_count, sums);
    for (uint32_t i = 0; i < vertex_count; ++i)
      set_normal((float)sums[i][0], (float)sums[i][1], (float)sums[i][2], vertices[i].normal);
  } else {
    int64_t(*sums)[3] = scratch;
    memset(sums, 0, vertex_count * sizeof *sums);
    sum_normals_64(vertices, indices, triangle_count, sums);
    for (uint32_t i = 0; i < vertex_count; ++i) scree_rt_mesh_normal(sums[i], vertices[i].normal);
  }
}

/* Slots of a table of all keys: a power of two, at most half full. */
static uint32_t slot_bits(uint32_t vertex_count) {
  uint32_t bits = 4;
  while (UINT64_C(1) << bits < 2 * (uint64_t)vertex_count) ++bits;
  return bits;
}

size_t scree_rt_joined_normals_scratch(uint32_t vertex_count) {
  return (size_t)vertex_count * MESH_NORMALS_SCRATCH + ((size_t)1 << slot_bits(vertex_count)) * sizeof(uint32_t);
}

void scree_rt_joined_normals(scree_vertex* vertices, const uint8_t* groups, uint32_t vertex_count, const uint32_t* indices,
                             uint32_t triangle_count, void* scratch) {
  int64_t(*sums)[3] = scratch;
  uint32_t* slots = (uint32_t*)(void*)(sums + vertex_count);
  const uint32_t bits = slot_bits(vertex_count);
  memset(sums, 0, vertex_count * sizeof *sums);
  memset(slots, 0xff, ((size_t)1 << bits) * sizeof *slots);
  sum_normals_64(vertices, indices, triangle_count, sums);
  /* Twice over the vertices: the first of a key gathers the sums of all, which then have its normal. */
  for (int turn = 0; turn < 2; ++turn)
    for (uint32_t v = 0; v < vertex_count; ++v) {
      const uint64_t key = scree_rt_normal_key(vertices[v].position, groups[v]);
      size_t slot = (size_t)(scree_rt_normal_hash(key) >> (64 - bits));
      while (slots[slot] != UINT32_MAX && scree_rt_normal_key(vertices[slots[slot]].position, groups[slots[slot]]) != key)
        slot = (slot + 1) & (((size_t)1 << bits) - 1);
      if (slots[slot] == UINT32_MAX) slots[slot] = v;
      const uint32_t first = slots[slot];
      for (int axis = 0; turn == 0 && first != v && axis < 3; ++axis) sums[first][axis] += sums[v][axis];
      if (turn == 1) scree_rt_mesh_normal(sums[first], vertices[v].normal);
    }
}
