#include "synthetic_field.h"

#include <math.h>
#include <stdlib.h>

static void* must_allocate(size_t count, size_t size) {
  void* memory = calloc(count, size);
  if (memory == NULL) abort();
  return memory;
}

synthetic_source synthetic_create(uint32_t n, uint32_t seeds_min, uint32_t seeds_max, uint64_t seed) {
  random_stream r = {seed};
  synthetic_source s = {0};
  uint32_t cells = scree_rt_lattice_cell_count(n);
  s.tile_cells = must_allocate((size_t)256 * n * n * n, sizeof *s.tile_cells);
  s.cell_first = must_allocate(cells + 1, sizeof *s.cell_first);
  s.rocks = must_allocate((size_t)cells * seeds_max, sizeof *s.rocks);
  uint32_t* out = s.tile_cells;
  for (uint32_t code = 0; code < 256; ++code)
    for (uint32_t z = 0; z < n; ++z)
      for (uint32_t y = 0; y < n; ++y)
        for (uint32_t x = 0; x < n; ++x) *out++ = scree_rt_lattice_cell(n, code, x, y, z);

  uint32_t rocks = 0;
  float largest = 0;
  for (uint32_t cell = 0; cell < cells; ++cell) {
    s.cell_first[cell] = rocks;
    uint32_t count = seeds_min + random_below(&r, seeds_max - seeds_min + 1);
    uint32_t skip = seeds_max > count ? random_below(&r, seeds_max - count + 1) : 0; /* seeds whose rock vanished leave holes */
    for (uint32_t k = 0; k < count; ++k) {
      field_rock* rock = &s.rocks[rocks++];
      for (int a = 0; a < 3; ++a) rock->centroid[a] = (float)random_in(&r, -0.5, 0.5);
      rock->outer_radius = (float)random_in(&r, 0.45, 1.05);
      rock->inner_radius = rock->outer_radius * (float)random_in(&r, 0.3, 0.8);
      rock->seed = skip + k;
      if (rock->outer_radius > largest) largest = rock->outer_radius;
    }
  }
  s.cell_first[cells] = rocks;
  s.source = (field_source){.cells_per_cube = n,
                            .cell_count = cells,
                            .asset_count = rocks,
                            .max_rocks_per_cell = seeds_max,
                            .max_radius = largest,
                            .tile_cells = s.tile_cells,
                            .cell_first = s.cell_first,
                            .rocks = s.rocks};
  return s;
}

void synthetic_add_hulls(synthetic_source* s, uint64_t seed, uint32_t deepest, uint32_t bare) {
  enum { LATTICE = 32, POINTS = 16 };
  random_stream r = {seed};
  uint32_t rocks = s->source.asset_count;
  s->hull_first = must_allocate((size_t)rocks + 1, sizeof *s->hull_first);
  s->hulls = must_allocate((size_t)rocks * POINTS, 3 * sizeof *s->hulls);
  for (uint32_t i = 0; i < rocks; ++i) {
    field_rock* rock = &s->rocks[i];
    rock->burial = 1 + random_below(&r, deepest);
    if (bare > 0 && random_below(&r, bare) == 0) rock->burial = SCREE_BURIAL_NEVER;
    uint32_t count = 4 + random_below(&r, POINTS - 3), first = s->hull_first[i];
    for (uint32_t k = 0; k < count; ++k) {
      double p[3], length2 = 0;
      for (int a = 0; a < 3; ++a) {
        p[a] = random_in(&r, -1, 1);
        length2 += p[a] * p[a];
      }
      double radius = (double)rock->outer_radius * LATTICE - 1; /* one step less, for rounding to the lattice */
      for (int a = 0; a < 3; ++a)
        s->hulls[3 * (first + k) + (uint32_t)a] =
            (int16_t)floor((double)rock->centroid[a] * LATTICE + p[a] * radius / sqrt(length2 + 1e-9) + 0.5);
    }
    s->hull_first[i + 1] = first + count;
  }
  s->source.lattice_per_cell = LATTICE;
  s->source.hull_first = s->hull_first;
  s->source.hulls = s->hulls;
}

void synthetic_destroy(synthetic_source* s) {
  free(s->hull_first);
  free(s->hulls);
  free(s->tile_cells);
  free(s->cell_first);
  free(s->rocks);
}
