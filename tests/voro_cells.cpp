#include "voro_cells.h"

#include <voro++/voro++.hh>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <list>
#include <vector>

namespace {

template <typename T>
T* kept(const std::vector<T>& values) {
  T* memory = static_cast<T*>(malloc((values.size() + 1) * sizeof(T)));
  if (memory == nullptr) abort();
  std::copy(values.begin(), values.end(), memory);
  return memory;
}

}  // namespace

void voro_cells_make(const double min[3], const double max[3], const double (*planes)[4], uint32_t plane_count, const double* seeds,
                     uint32_t seed_count, voro_cells* out) {
  /* Blocks of five seeds, as Voro++'s own examples have them. */
  const double step = std::cbrt((max[0] - min[0]) * (max[1] - min[1]) * (max[2] - min[2]) * 5 / seed_count);
  int size[3];
  for (int axis = 0; axis < 3; ++axis) size[axis] = static_cast<int>((max[axis] - min[axis]) / step) + 1;
  voro::container container(min[0], max[0], min[1], max[1], min[2], max[2], size[0], size[1], size[2], false, false, false, 8);
  std::list<voro::wall_plane> walls;
  for (uint32_t i = 0; i < plane_count; ++i) {
    walls.emplace_back(planes[i][0], planes[i][1], planes[i][2], planes[i][3], -7 - static_cast<int>(i));
    container.add_wall(walls.back());
  }
  for (uint32_t i = 0; i < seed_count; ++i) container.put(static_cast<int>(i), seeds[3 * i], seeds[3 * i + 1], seeds[3 * i + 2]);

  std::vector<double> volumes(seed_count);
  std::vector<uint32_t> first(seed_count + 1), count(seed_count), start(seed_count), found, sorted;
  voro::c_loop_all loop(container);
  voro::voronoicell_neighbor cell;
  std::vector<int> neighbours;
  if (loop.start()) do
      if (container.compute_cell(cell, loop)) {
        const uint32_t seed = static_cast<uint32_t>(loop.pid());
        volumes[seed] = cell.volume();
        cell.neighbors(neighbours);
        start[seed] = static_cast<uint32_t>(found.size());
        count[seed] = static_cast<uint32_t>(neighbours.size());
        for (const int n : neighbours)
          found.push_back(n < 0 ? VORO_WALL + static_cast<uint32_t>(-1 - n) : static_cast<uint32_t>(n));
        std::sort(found.begin() + start[seed], found.end());
      }
    while (loop.inc());
  for (uint32_t i = 0; i < seed_count; ++i) {
    first[i] = static_cast<uint32_t>(sorted.size());
    sorted.insert(sorted.end(), found.begin() + start[i], found.begin() + start[i] + count[i]);
  }
  first[seed_count] = static_cast<uint32_t>(sorted.size());
  *out = {kept(volumes), kept(first), kept(sorted)};
}

void voro_cells_free(voro_cells* cells) {
  free(cells->volumes);
  free(cells->neighbour_first);
  free(cells->neighbours);
  *cells = {};
}
