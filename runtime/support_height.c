#include "support_height.h"

#include <math.h>
#include <string.h>

#include "allocator.h"

static double square(double x) {
  return x * x;
}

/* Inside one cell of a bilinear surface each slope lies between those of the two opposite edges. */
static double cell_cosine(const float* h, uint32_t width, double spacing) {
  const float* next = h + width;
  double x0 = square((double)h[1] - (double)h[0]), x1 = square((double)next[1] - (double)next[0]);
  double z0 = square((double)next[0] - (double)h[0]), z1 = square((double)next[1] - (double)h[1]);
  double slope2 = ((x0 > x1 ? x0 : x1) + (z0 > z1 ? z0 : z1)) / square(spacing);
  return 1 / sqrt(1 + slope2);
}

static void lower(uint8_t* cosine, uint32_t to) {
  if (*cosine > to) *cosine = (uint8_t)to;
}

/* The cosine at each sample: no more than that of any cell around it, so that between samples it is no more than that of the cell,
 * and no more than HEIGHT_BEND above any neighbour's. Returns the least. */
static double fill_cosines(const support_height* g, uint8_t* cosine, double spacing) {
  const size_t width = g->width, count = width * g->depth;
  double least = 1;
  for (size_t i = 0; i < count; ++i) cosine[i] = HEIGHT_COSINE;
  for (size_t v = 0; v + 1 < g->depth; ++v)
    for (size_t u = 0; u + 1 < width; ++u) {
      size_t i = v * width + u;
      double c = cell_cosine(g->heights + i, g->width, spacing);
      if (c < least) least = c;
      uint32_t steps = (uint32_t)(c * HEIGHT_COSINE); /* rounded down */
      lower(&cosine[i], steps);
      lower(&cosine[i + 1], steps);
      lower(&cosine[i + width], steps);
      lower(&cosine[i + width + 1], steps);
    }
  for (size_t i = 0; i < count; ++i) {
    if (i % width > 0) lower(&cosine[i], cosine[i - 1] + HEIGHT_BEND);
    if (i >= width) lower(&cosine[i], cosine[i - width] + HEIGHT_BEND);
  }
  for (size_t i = count; i-- > 0;) {
    if (i % width < width - 1) lower(&cosine[i], cosine[i + 1] + HEIGHT_BEND);
    if (i + width < count) lower(&cosine[i], cosine[i + width] + HEIGHT_BEND);
  }
  return least;
}

/* The four corners of each cell in one word. */
static void pack_cosines(support_height* g, const uint8_t* cosine) {
  const size_t width = g->width, count = width * g->depth;
  for (size_t i = 0; i < count; ++i) {
    size_t right = i % width < width - 1 ? 1 : 0, below = i + width < count ? width : 0;
    const size_t corners[4] = {i, i + right, i + below, i + below + right};
    g->cosines[i] = 0;
    for (int k = 0; k < 4; ++k) g->cosines[i] |= (uint32_t)cosine[corners[k]] << (8 * k);
  }
}

support_height* scree_rt_support_height_create(const scree_shape* shape, support_key key, const scree_allocator* allocator) {
  uint32_t width = shape->heightfield.width, depth = shape->heightfield.depth;
  size_t count = (size_t)width * depth;
  double spacing = (double)shape->heightfield.spacing;

  support_height* grid = scree_rt_allocate_zeroed(allocator, 1, sizeof *grid);
  if (grid == NULL) return NULL;
  grid->share.allocator = *allocator;
  grid->share.key = key;
  atomic_init(&grid->share.uses, 1);
  grid->width = width;
  grid->depth = depth;
  grid->heights = scree_rt_allocate(allocator, count, sizeof(float));
  grid->cosines = scree_rt_allocate(allocator, count, sizeof(uint32_t));
  uint8_t* scratch = scree_rt_allocate(allocator, count, 1);
  if (grid->heights == NULL || grid->cosines == NULL || scratch == NULL) {
    scree_rt_release(allocator, scratch, count, 1);
    scree_rt_support_height_drop(grid);
    return NULL;
  }
  memcpy(grid->heights, shape->heightfield.heights, count * sizeof(float));

  grid->inverse_spacing = (float)(1 / spacing);
  grid->middle_u = (float)((width - 1) * 0.5);
  grid->middle_v = (float)((depth - 1) * 0.5);
  grid->extent_x = (float)((width - 1) * 0.5 * spacing);
  grid->extent_z = (float)((depth - 1) * 0.5 * spacing);
  double least = fill_cosines(grid, scratch, spacing), most = 0;
  for (size_t i = 0; i < count; ++i)
    if (scratch[i] > most) most = scratch[i];
  most /= HEIGHT_COSINE;
  pack_cosines(grid, scratch);
  scree_rt_release(allocator, scratch, count, 1);
  grid->cosine = (float)least;
  /* It may bend along both axes at once. */
  grid->bend = (float)(sqrt(2.0) * HEIGHT_BEND / HEIGHT_COSINE * 1.001 / spacing);
  /* c v / (1 + k v) > C v needs a v below this. */
  grid->local = most > least ? (float)((most / least - 1) / (double)grid->bend * 1.001) : 0.0f;
  grid->lowest = grid->highest = grid->heights[0];
  for (size_t i = 1; i < count; ++i) {
    if (grid->heights[i] < grid->lowest) grid->lowest = grid->heights[i];
    if (grid->heights[i] > grid->highest) grid->highest = grid->heights[i];
  }
  return grid;
}

void scree_rt_support_height_drop(support_height* grid) {
  if (grid == NULL || !support_drop(&grid->share)) return;
  scree_allocator allocator = grid->share.allocator;
  scree_rt_release(&allocator, grid->heights, (size_t)grid->width * grid->depth, sizeof(float));
  scree_rt_release(&allocator, grid->cosines, (size_t)grid->width * grid->depth, sizeof(uint32_t));
  scree_rt_release(&allocator, grid, 1, sizeof *grid);
}
