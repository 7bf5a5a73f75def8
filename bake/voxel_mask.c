#include "voxel_mask.h"

#include <stdbool.h>
#include <string.h>

typedef struct carver {
  uint64_t* rows;
  uint32_t height, width;
  float* field;
  float carved;
  uint32_t count;
} carver;

static float* voxel(const carver* c, uint32_t x, uint32_t y, uint32_t z) {
  return &c->field[x + (size_t)c->width * (y + (size_t)c->height * z)];
}

static void carve(carver* c, uint32_t x, uint32_t y, uint32_t z) {
  c->rows[y + (size_t)c->height * z] &= ~(UINT64_C(1) << x);
  *voxel(c, x, y, z) = -c->carved;
  ++c->count;
}

/* Carves the shallower of two inside voxels; the first of equals. */
static void carve_shallower(carver* c, uint32_t x0, uint32_t y0, uint32_t z0, uint32_t x1, uint32_t y1, uint32_t z1) {
  if (*voxel(c, x1, y1, z1) < *voxel(c, x0, y0, z0))
    carve(c, x1, y1, z1);
  else
    carve(c, x0, y0, z0);
}

/* Squares that span x and one other axis: row a, and row b one step along the other axis. */
static void carve_squares_x(carver* c, uint32_t y0, uint32_t z0, uint32_t y1, uint32_t z1) {
  const uint64_t a = c->rows[y0 + (size_t)c->height * z0], b = c->rows[y1 + (size_t)c->height * z1];
  uint64_t rising = a & (b >> 1) & ~(a >> 1) & ~b, falling = ~a & ~(b >> 1) & (a >> 1) & b;
  for (; rising != 0; rising &= rising - 1) {
    const uint32_t x = (uint32_t)__builtin_ctzll(rising);
    carve_shallower(c, x, y0, z0, x + 1, y1, z1);
  }
  for (; falling != 0; falling &= falling - 1) {
    const uint32_t x = (uint32_t)__builtin_ctzll(falling);
    carve_shallower(c, x + 1, y0, z0, x, y1, z1);
  }
}

static void carve_squares_yz(carver* c, uint32_t y, uint32_t z) {
  const uint64_t* at = c->rows + y + (size_t)c->height * z;
  const uint64_t a = at[0], b = at[1], d = at[c->height], e = at[c->height + 1];
  for (uint64_t bad = a & e & ~b & ~d; bad != 0; bad &= bad - 1) {
    const uint32_t x = (uint32_t)__builtin_ctzll(bad);
    carve_shallower(c, x, y, z, x, y + 1, z + 1);
  }
  for (uint64_t bad = b & d & ~a & ~e; bad != 0; bad &= bad - 1) {
    const uint32_t x = (uint32_t)__builtin_ctzll(bad);
    carve_shallower(c, x, y + 1, z, x, y, z + 1);
  }
}

/* Cubes with just two opposite corners inside, or just two outside. */
static void carve_cubes(carver* c, uint32_t y, uint32_t z) {
  const uint64_t* at = c->rows + y + (size_t)c->height * z;
  uint64_t corner[8];
  for (uint32_t i = 0; i < 8; ++i) corner[i] = at[(i >> 1 & 1) + (size_t)c->height * (i >> 2)] >> (i & 1);
  for (uint32_t i = 0; i < 4; ++i) {
    uint64_t only = corner[i] & corner[7 - i], all_but = ~corner[i] & ~corner[7 - i];
    for (uint32_t k = 0; k < 8; ++k)
      if (k != i && k != 7 - i) {
        only &= ~corner[k];
        all_but &= corner[k];
      }
    for (; only != 0; only &= only - 1) {
      const uint32_t x = (uint32_t)__builtin_ctzll(only), k = 7 - i;
      carve_shallower(c, x + (i & 1), y + (i >> 1 & 1), z + (i >> 2), x + (k & 1), y + (k >> 1 & 1), z + (k >> 2));
    }
    for (all_but &= ~(UINT64_C(1) << 63); all_but != 0; all_but &= all_but - 1) {
      const uint32_t x = (uint32_t)__builtin_ctzll(all_but), k = i ^ 1; /* a neighbour of the outside corner */
      carve(c, x + (k & 1), y + (k >> 1 & 1), z + (k >> 2));
    }
  }
}

uint32_t mask_make_well_composed(uint64_t* rows, uint32_t height, uint32_t depth, float* field, uint32_t width, float carved) {
  carver c = {rows, height, width, field, carved, 0};
  for (;;) {
    const uint32_t before = c.count;
    for (uint32_t z = 0; z < depth; ++z)
      for (uint32_t y = 0; y < height; ++y) {
        if (y + 1 < height) carve_squares_x(&c, y, z, y + 1, z);
        if (z + 1 < depth) carve_squares_x(&c, y, z, y, z + 1);
        if (y + 1 < height && z + 1 < depth) {
          carve_squares_yz(&c, y, z);
          carve_cubes(&c, y, z);
        }
      }
    if (c.count == before) return c.count; /* each round carves, so this ends */
  }
}

/* Spreads `seeds` along the runs of `open` that they touch. */
static uint64_t spread_row(uint64_t seeds, uint64_t open) {
  seeds &= open;
  for (uint32_t shift = 1; shift < 64; shift <<= 1) {
    seeds |= open & (seeds << shift);
    open &= open << shift;
  }
  return seeds;
}

static uint64_t reverse_bits(uint64_t v) {
  v = (v >> 1 & UINT64_C(0x5555555555555555)) | (v & UINT64_C(0x5555555555555555)) << 1;
  v = (v >> 2 & UINT64_C(0x3333333333333333)) | (v & UINT64_C(0x3333333333333333)) << 2;
  v = (v >> 4 & UINT64_C(0x0f0f0f0f0f0f0f0f)) | (v & UINT64_C(0x0f0f0f0f0f0f0f0f)) << 4;
  return __builtin_bswap64(v);
}

static uint64_t spread_both(uint64_t seeds, uint64_t open) {
  const uint64_t up = spread_row(seeds, open);
  return up | reverse_bits(spread_row(reverse_bits(seeds), reverse_bits(open)));
}

/* One sweep over all rows; returns whether anything grew. */
static bool flood_sweep(const uint64_t* open, uint64_t* filled, uint32_t height, uint32_t depth, bool forward) {
  const uint32_t count = height * depth;
  bool grew = false;
  for (uint32_t step = 0; step < count; ++step) {
    const uint32_t at = forward ? step : count - 1 - step, y = at % height;
    if (open[at] == filled[at]) continue;
    uint64_t seeds = filled[at];
    if (y > 0) seeds |= filled[at - 1];
    if (y + 1 < height) seeds |= filled[at + 1];
    if (at >= height) seeds |= filled[at - height];
    if (at + height < count) seeds |= filled[at + height];
    seeds &= open[at];
    if (seeds == 0 || seeds == filled[at]) continue;
    filled[at] = spread_both(seeds, open[at]);
    grew = true;
  }
  return grew;
}

uint32_t mask_keep_largest(uint64_t* rows, uint32_t height, uint32_t depth, float* field, uint32_t width, float carved,
                           uint64_t* scratch) {
  const uint32_t count = height * depth;
  uint64_t *component = scratch, *largest = scratch + count;
  uint32_t total = 0, kept = 0, visited = 0;
  for (uint32_t at = 0; at < count; ++at) total += (uint32_t)__builtin_popcountll(rows[at]);
  memset(largest, 0, count * sizeof *largest);
  /* Voxels of components that were looked at leave `rows`; the largest one is put back at the end. */
  for (uint32_t at = 0; at < count && total - visited > kept; ++at)
    while (rows[at] != 0 && total - visited > kept) {
      memset(component, 0, count * sizeof *component);
      component[at] = spread_both(rows[at] & (~rows[at] + 1), rows[at]);
      /* Both sweeps, whatever the first one found. */
      while ((int)flood_sweep(rows, component, height, depth, true) | (int)flood_sweep(rows, component, height, depth, false)) {}
      uint32_t size = 0;
      for (uint32_t i = at; i < count; ++i) {
        size += (uint32_t)__builtin_popcountll(component[i]);
        rows[i] &= ~component[i];
      }
      visited += size;
      if (size > kept) {
        kept = size;
        memcpy(largest, component, count * sizeof *largest);
      }
    }
  if (kept < total)
    for (uint32_t at = 0; at < count; ++at) {
      /* Dropped: whatever was inside and is not in the largest. Visited ones have left `rows`, so ask the field. */
      float* row = field + (size_t)at * width;
      for (uint32_t x = 0; x < width && x < 64; ++x)
        if (row[x] > 0 && (largest[at] >> x & 1) == 0) row[x] = -carved;
    }
  memcpy(rows, largest, count * sizeof *rows);
  return kept;
}

void mask_fill_voids(uint64_t* rows, uint32_t width, uint32_t height, uint32_t depth, uint64_t* scratch) {
  const uint32_t count = height * depth;
  uint64_t *open = scratch, *outside = scratch + count;
  const uint64_t all = width < 64 ? (UINT64_C(1) << width) - 1 : ~UINT64_C(0);
  memset(outside, 0, count * sizeof *outside);
  for (uint32_t at = 0; at < count; ++at) open[at] = all & ~rows[at];
  outside[0] = open[0];
  while ((int)flood_sweep(open, outside, height, depth, true) | (int)flood_sweep(open, outside, height, depth, false)) {}
  for (uint32_t at = 0; at < count; ++at) rows[at] = all & ~outside[at];
}

void mask_grow(uint64_t* rows, uint32_t height, uint32_t depth, uint64_t* scratch) {
  memcpy(scratch, rows, (size_t)height * depth * sizeof *rows);
  for (uint32_t z = 1; z + 1 < depth; ++z)
    for (uint32_t y = 1; y + 1 < height; ++y) {
      const uint64_t* at = scratch + y + (size_t)height * z;
      rows[y + (size_t)height * z] |= at[0] << 1 | at[0] >> 1 | at[1] | *(at - 1) | at[height] | *(at - height);
    }
}

void mask_shrink(uint64_t* rows, uint32_t height, uint32_t depth, uint64_t* scratch) {
  memcpy(scratch, rows, (size_t)height * depth * sizeof *rows);
  for (uint32_t z = 1; z + 1 < depth; ++z)
    for (uint32_t y = 1; y + 1 < height; ++y) {
      const uint64_t* at = scratch + y + (size_t)height * z;
      rows[y + (size_t)height * z] &= at[0] << 1 & at[0] >> 1 & at[1] & *(at - 1) & at[height] & *(at - height);
    }
}
