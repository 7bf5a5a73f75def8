/* The lattice of corners, its colours, and the unique cells of the 256 corner cubes.
 * Based on: Peytavie et al., Procedural Generation of Rock Piles using Aperiodic Tiling, 2009; Lagae and Dutre, Poisson Sphere
 * Distributions, 2006. Where we differ: zones of radius 1 suffice, because a seed's distance has compact support.
 *
 * One axis of a cube, N = 5 cells, each centred on an integer; the cube is [0, N), and cell 0 sits on the corner plane:
 *
 *        plane 0                                plane 1
 *           |                                      |
 *        [  0  ][  1  ][  2  ][  3  ][  4  ][  0' ][  1' ] ...
 *   seed:  P0     P0    free   free    P1     P1     P1       which planes a SEED in the cell depends on
 *   rock:  P0    both   both   both   both    P1    both      which planes a ROCK of the cell depends on (its 27 cells do)
 *
 * Per axis a cell is pinned (one plane decides) or free (both do); over three axes, the corners that decide are the product. */
#ifndef SCREE_LATTICE_H
#define SCREE_LATTICE_H

#include <stdint.h>

/* Finaliser of splitmix64 (Steele, Lea, Flood 2014): a bijection of 64 bits with full avalanche. */
static inline uint64_t hash_mix(uint64_t x) {
  x ^= x >> 30;
  x *= UINT64_C(0xbf58476d1ce4e5b9);
  x ^= x >> 27;
  x *= UINT64_C(0x94d049bb133111eb);
  x ^= x >> 31;
  return x;
}

/* One step of a running hash over 64-bit words. */
static inline uint64_t hash_combine(uint64_t hash, uint64_t word) {
  return hash_mix((hash ^ word) * UINT64_C(0x9e3779b97f4a7c15) + UINT64_C(0x632be59bd9b4e019));
}

static inline uint64_t hash_corner(uint64_t seed, int32_t x, int32_t y, int32_t z) {
  uint64_t hash = hash_combine(seed, (uint64_t)(uint32_t)x | (uint64_t)(uint32_t)y << 32);
  return hash_combine(hash, (uint64_t)(uint32_t)z);
}

/* Colour of a corner of the lattice, 0 or 1. */
static inline uint32_t corner_colour(uint64_t seed, int32_t x, int32_t y, int32_t z) {
  return (uint32_t)(hash_corner(seed, x, y, z) >> 63);
}

/* Code of the cube whose least corner is (x, y, z): bit dx + 2 dy + 4 dz is the colour of corner (x + dx, y + dy, z + dz). */
static inline uint32_t cube_code(uint64_t seed, int32_t x, int32_t y, int32_t z) {
  uint32_t code = 0;
  for (int32_t corner = 0; corner < 8; ++corner)
    code |= corner_colour(seed, x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2)) << corner;
  return code;
}

/* Number of unique cells for N cells a side: 2 + 12 (N-1) + 48 (N-1)^2 + 256 (N-1)^3. */
uint32_t scree_rt_lattice_cell_count(uint32_t n);

/* The unique cell at (x, y, z), each 0..N-1, of the tile with this code. Cells are numbered zone by zone (corner, edges along x, y,
 * z, faces, inside), within a zone by place (x fastest) and then by the colours that decide. */
uint32_t scree_rt_lattice_cell(uint32_t n, uint32_t code, uint32_t x, uint32_t y, uint32_t z);

/* The reverse: one tile code and place where a unique cell stands (the corners that do not matter get colour 0). */
void scree_rt_lattice_cell_place(uint32_t n, uint32_t cell, uint32_t* code, uint32_t* x, uint32_t* y, uint32_t* z);

#endif
