/* Based on: Gibson, Constrained Elastic SurfaceNets, 1998, in the naive form: each vertex is the mean of the crossings of its
 * cube's edges. Where we differ: whole rows of voxels are tested as bit masks, and vertices live on an integer lattice. */
#include "surface_nets.h"

#include <math.h>
#include <stdbool.h>

void surface_nets_bounds(const voxel_field* field, uint32_t* vertices, uint32_t* indices) {
  uint32_t cubes = 0, edges = 0;
  for (uint32_t z = 0; z + 1 < field->depth; ++z)
    for (uint32_t y = 0; y + 1 < field->height; ++y) {
      const uint64_t* at = field->rows + y + (size_t)field->height * z;
      const uint64_t a = at[0], b = at[1], c = at[field->height], d = at[field->height + 1];
      const uint64_t any = a | b | c | d, all = a & b & c & d;
      cubes += (uint32_t)__builtin_popcountll((any | any >> 1) & ~(all & all >> 1));
      edges += (uint32_t)(__builtin_popcountll(a ^ a >> 1) + __builtin_popcountll(a ^ b) + __builtin_popcountll(a ^ c));
    }
  *vertices = cubes;
  *indices = edges * 6;
}

/* Sum of the crossing points of one cube's edges relative to its first voxel, in voxels, and their number. */
static uint32_t crossings(const voxel_field* field, const float* at, float sum[3]) {
  const size_t dy = field->width, dz = (size_t)field->width * field->height;
  const float v[8] = {at[0], at[1], at[dy], at[dy + 1], at[dz], at[dz + 1], at[dz + dy], at[dz + dy + 1]};
  uint32_t inside = 0, count = 0;
  for (uint32_t i = 0; i < 8; ++i) inside |= (v[i] > 0 ? 1u : 0u) << i;
  sum[0] = sum[1] = sum[2] = 0;
  /* Lower ends of the edges along x, y and z whose ends differ. */
  const uint32_t edges[3] = {(inside ^ inside >> 1) & 0x55, (inside ^ inside >> 2) & 0x33, (inside ^ inside >> 4) & 0x0f};
  for (uint32_t axis = 0; axis < 3; ++axis)
    for (uint32_t rest = edges[axis]; rest != 0; rest &= rest - 1) {
      const uint32_t i = (uint32_t)__builtin_ctz(rest), k = i | 1u << axis;
      sum[0] += (float)(i & 1);
      sum[1] += (float)(i >> 1 & 1);
      sum[2] += (float)(i >> 2);
      sum[axis] += v[i] / (v[i] - v[k]);
      ++count;
    }
  return count;
}

/* Rounds down, so that vertices of neighbouring cubes never coincide and none is off by more than half a step; see surface_nets.h.
 */
static int16_t to_lattice(float offset, int32_t origin, uint32_t cube, int32_t step) {
  int32_t within = (int32_t)floorf(offset * (float)step);
  within = within < 0 ? 0 : within > step - 1 ? step - 1 : within;
  return (int16_t)(origin + (int32_t)cube * step + within);
}

static void add_quad(mesh_buffer* out, uint32_t a, uint32_t b, uint32_t c, uint32_t d, uint64_t flip) {
  uint32_t* to = out->indices + out->index_count;
  to[0] = a;
  to[1] = flip ? d : b;
  to[2] = c;
  to[3] = flip ? b : d;
  out->index_count += 4;
}

void surface_nets(const voxel_field* field, mesh_buffer* out) {
  const uint32_t height = field->height;
  const size_t dy = field->width, dz = (size_t)field->width * height;
  out->vertex_count = out->index_count = 0;
  for (uint32_t z = 0; z + 1 < field->depth; ++z)
    for (uint32_t y = 0; y + 1 < height; ++y) {
      const uint64_t* at = field->rows + y + (size_t)height * z;
      const uint64_t a = at[0], b = at[1], c = at[height], d = at[height + 1];
      const uint64_t any = a | b | c | d, all = a & b & c & d;
      for (uint64_t cubes = (any | any >> 1) & ~(all & all >> 1); cubes != 0; cubes &= cubes - 1) {
        const uint32_t x = (uint32_t)__builtin_ctzll(cubes);
        const size_t voxel = x + dy * y + dz * z;
        float sum[3];
        const float inverse = 1 / (float)crossings(field, field->values + voxel, sum);
        const uint32_t cube[3] = {x, y, z};
        for (uint32_t axis = 0; axis < 3; ++axis) {
          out->positions[out->vertex_count][axis] = to_lattice(sum[axis] * inverse, field->origin[axis], cube[axis], field->step);
          out->cells[out->vertex_count][axis] = (uint16_t)cube[axis];
        }
        out->vertex_of[voxel] = out->vertex_count++;
      }
    }

  /* The four cubes around an edge, counter-clockwise seen from its upper end; the quad faces away from the inside voxel. */
  for (uint32_t z = 1; z + 1 < field->depth; ++z)
    for (uint32_t y = 1; y + 1 < height; ++y) {
      const uint64_t* at = field->rows + y + (size_t)height * z;
      const uint64_t here = at[0], along_x = here >> 1, along_y = at[1], along_z = at[height];
      const uint32_t* vertex = out->vertex_of + dy * y + dz * z;
      for (uint64_t edges = here ^ along_x; edges != 0; edges &= edges - 1) {
        const uint32_t* v = vertex + __builtin_ctzll(edges);
        add_quad(out, v[0], *(v - dy), *(v - dy - dz), *(v - dz), here >> __builtin_ctzll(edges) & 1 ? 0 : 1);
      }
      for (uint64_t edges = here ^ along_y; edges != 0; edges &= edges - 1) {
        const uint32_t* v = vertex + __builtin_ctzll(edges);
        add_quad(out, v[0], *(v - dz), *(v - dz - 1), *(v - 1), here >> __builtin_ctzll(edges) & 1 ? 0 : 1);
      }
      for (uint64_t edges = here ^ along_z; edges != 0; edges &= edges - 1) {
        const uint32_t* v = vertex + __builtin_ctzll(edges);
        add_quad(out, v[0], *(v - 1), *(v - 1 - dy), *(v - dy), here >> __builtin_ctzll(edges) & 1 ? 0 : 1);
      }
    }
}

static int64_t distance2(const int16_t a[3], const int16_t b[3]) {
  int64_t sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int64_t d = a[axis] - b[axis];
    sum += d * d;
  }
  return sum;
}

static bool is_flat(const int16_t a[3], const int16_t b[3], const int16_t c[3]) {
  const int32_t u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, w[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  return u[0] * w[1] == u[1] * w[0] && u[1] * w[2] == u[2] * w[1] && u[2] * w[0] == u[0] * w[2];
}

void surface_nets_triangulate(mesh_buffer* mesh) {
  /* In place, from the end: four indices a quad become six. */
  const uint32_t quads = mesh->index_count / 4;
  for (uint32_t q = quads; q-- > 0;) {
    const uint32_t* from = mesh->indices + (size_t)q * 4;
    const uint32_t a = from[0], b = from[1], c = from[2], d = from[3];
    uint32_t* to = mesh->indices + (size_t)q * 6;
    const int16_t *pa = mesh->positions[a], *pb = mesh->positions[b], *pc = mesh->positions[c], *pd = mesh->positions[d];
    bool along_ac = distance2(pa, pc) <= distance2(pb, pd);
    /* Where one diagonal makes a triangle without area the other does not: a line misses one of the four cubes around an edge. */
    if (along_ac ? is_flat(pa, pb, pc) || is_flat(pa, pc, pd) : is_flat(pa, pb, pd) || is_flat(pb, pc, pd)) along_ac = !along_ac;
    if (along_ac) {
      to[0] = a, to[1] = b, to[2] = c, to[3] = a, to[4] = c, to[5] = d;
    } else {
      to[0] = a, to[1] = b, to[2] = d, to[3] = b, to[4] = c, to[5] = d;
    }
  }
  mesh->index_count = quads * 6;
}
