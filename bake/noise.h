/* Smooth value noise on the voxels of one rock: cubic B-splines over random lattice values, in octaves. */
#ifndef SCREE_NOISE_H
#define SCREE_NOISE_H

#include "allocator.h"

/* Scratch for one worker. */
typedef struct noise_scratch {
  float* lattice;  /* random values of one octave */
  float* plane;    /* combined along z */
  float* row;      /* combined along y */
  uint32_t* index; /* lattice index of each x */
  float* weights;  /* 4 a voxel of x */
  uint32_t side;   /* most lattice values along an axis */
  uint32_t width;  /* most voxels along x */
} noise_scratch;

/* For grids of at most `voxels` a side that span at most `cells`, and frequencies up to `frequency` per cell. */
scree_result noise_scratch_create(uint32_t voxels, double cells, double frequency, const scree_allocator* allocator,
                                  noise_scratch* out);
void noise_scratch_destroy(noise_scratch* scratch, const scree_allocator* allocator);

typedef struct noise_grid {
  uint32_t size[3]; /* voxels; x is a row */
  float origin[3];  /* cells, of voxel 0 */
  float step;       /* cells from voxel to voxel */
} noise_grid;

/* Adds amplitude * noise in [0, amplitude] to out[size x * y * z]; `key` names the noise. */
void noise_add(const noise_scratch* scratch, const noise_grid* grid, float frequency, float amplitude, uint64_t key, float* out);

#endif
