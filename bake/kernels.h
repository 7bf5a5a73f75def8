/* The inner loops of the rock baker. kernels_body.h is compiled once for the plain target and once for AVX2; both give the same
 * bits, because each lane does the same IEEE operations in the same order. */
#ifndef SCREE_KERNELS_H
#define SCREE_KERNELS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define LANES 8

static inline uint32_t round_to_lanes(uint32_t count) {
  return (count + LANES - 1) / LANES * LANES;
}

/* Tables over the voxels of one dual block: the R^3 voxels between the centres of 2x2x2 cells. A plane of constant z is a linear
 * array of R^2 voxels (x fastest), padded to whole lanes. `side` 0 is the lower cell of an axis, 1 the upper. */
typedef struct block_tables {
  uint32_t voxels; /* R */
  uint32_t plane;  /* R^2 rounded up to lanes */
  float cells_per_unit;
  float level;         /* k */
  float* x;            /* [plane] units from the lower cell's centre */
  float* y;            /* [plane] */
  float* weight_xy[4]; /* [plane] 1 / (w(x) w(y)) for side x + 2 side y */
  float* slope_x[2];   /* [plane] d ln(1 / w) / dx, per cell */
  float* slope_y[2];   /* [plane] */
  float* weight[2];    /* [R] 1 / w along one axis */
  float* slope[2];     /* [R] */
} block_tables;

typedef struct block_seed {
  float position[3]; /* units from the centre of the block's lowest cell */
  float metric[6];
  uint32_t corner; /* which of the 2x2x2 cells it belongs to: x + 2 y + 4 z */
} block_seed;

/* One dual block, R planes each.
 *
 * Depths are differences of levels, divided by the gradient of that difference. The level of a distance d is d / (d + k): it grows
 * with d, so it has the same owner and the same border, but it stays smooth where a support ends and d does not. (With plain
 * distances the depth falls to nothing at the centre of a cell, where all its neighbours' supports end, and rocks come out hollow.)
 * It is computed as 1 - k / (d + k), whose roundings are all monotone: the fields of two rocks never add up to more than 0. */
typedef struct block_fields {
  float* nearest;       /* level of the best seed */
  float* depth;         /* (level of the second best - of the best) * inverse_slope: signed depth below the border, cells */
  float* inverse_slope; /* 1 / |grad level best - grad level second| */
  uint8_t* owner;       /* index of the best seed */
} block_fields;

/* One row of voxels of a rock's own grid. `count` is a whole number of lanes. */
typedef struct rock_row {
  uint32_t count;
  const float* x;        /* cells from the home cell's centre */
  const float* dx;       /* cells from the seed */
  const float* weight_x; /* 1 / w(x) */
  float y, z;            /* cells from the home cell's centre */
  float dy, dz;          /* cells from the seed */
  float weight_y, weight_z;
  const float* metric;
  float level;          /* k of the levels */
  const float* nearest; /* as in block_fields, gathered along the row */
  const float* depth;
  const float* inverse_slope;
  const int32_t* own; /* all bits set where the rock owns the voxel, else 0 */
} rock_row;

typedef struct rock_shape {
  uint32_t contact_count;
  const float (*contacts)[3]; /* cells */
  float contact_radius;       /* a */
  float inverse_blend;        /* 1 / (b - a) */
  float erosion;
  uint32_t plane_count;
  const float (*planes)[4]; /* unit normal and offset: inside where n . p <= offset */
} rock_shape;

typedef struct kernel_set {
  const char* name;
  /* Best and second-best seed of every voxel; ties go to the first seed of the list. count >= 2. */
  void (*voronoi_block)(const block_tables* tables, const block_seed* seeds, uint32_t count, const block_fields* out);
  /* The continuous field of one rock, clamped to +-limit. */
  void (*rock_field)(const rock_row* row, float limit, float* field);
  /* Damping omega and the eroded, chiselled field; `noise` is the depth to carve, before damping. */
  void (*rock_erode)(const rock_row* row, const rock_shape* shape, const float* noise, float* field, float* omega);
  /* One carving step: out = field + min(0, strength * laplacian) * omega, inside the grid; its border is copied. */
  void (*carve_step)(const float* field, const float* omega, float* out, uint32_t width, uint32_t height, uint32_t depth,
                     float strength);
  /* One bit a voxel: field > 0. width <= 64 and a whole number of lanes; one row a word. */
  void (*sign_rows)(const float* field, uint32_t width, uint32_t rows, uint64_t* bits);
  /* The point farthest along a direction, the first of equals. points: x, y and z, `count` each, a whole number of lanes > 0. */
  uint32_t (*farthest)(const float* const points[3], uint32_t count, const float direction[3]);
} kernel_set;

/* The widest kernels this machine runs; `plain` asks for the portable ones. */
const kernel_set* kernels_choose(bool plain);

extern const kernel_set kernels_plain;
extern const kernel_set kernels_avx2;

#endif
