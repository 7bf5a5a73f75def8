#include "mesh_normals.h"

#include <math.h>
#include <string.h>

void mesh_normals(scree_vertex* vertices, uint32_t vertex_count, const uint32_t* indices, uint32_t triangle_count,
                  int64_t (*sums)[4]) {
  memset(sums, 0, vertex_count * sizeof *sums);
  for (uint32_t triangle = 0; triangle < triangle_count; ++triangle) {
    const uint32_t* corner = indices + 3 * (size_t)triangle;
    const int16_t* a = vertices[corner[0]].position;
    const int16_t* b = vertices[corner[1]].position;
    const int16_t* c = vertices[corner[2]].position;
    const int64_t ux = b[0] - a[0], uy = b[1] - a[1], uz = b[2] - a[2];
    const int64_t vx = c[0] - a[0], vy = c[1] - a[1], vz = c[2] - a[2];
    const int64_t nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    for (int i = 0; i < 3; ++i) {
      int64_t* sum = sums[corner[i]];
      sum[0] += nx;
      sum[1] += ny;
      sum[2] += nz;
    }
  }
  for (uint32_t i = 0; i < vertex_count; ++i) {
    const double x = (double)sums[i][0], y = (double)sums[i][1], z = (double)sums[i][2];
    const double length = sqrt(x * x + y * y + z * z);
    const bool flat = length > 0;
    const double scale = flat ? 32767.0 / length : 0;
    int16_t* normal = vertices[i].normal;
    /* Truncation of a positive number is floor, without the call. */
    normal[0] = (int16_t)((int32_t)(x * scale + 32768.5) - 32768);
    normal[1] = flat ? (int16_t)((int32_t)(y * scale + 32768.5) - 32768) : 32767;
    normal[2] = (int16_t)((int32_t)(z * scale + 32768.5) - 32768);
  }
}
