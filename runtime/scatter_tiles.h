/* Sixteen square tiles of points, of which any two that lie side by side in a plane of coloured corners fit: no two points of the
 * plane are nearer to one another than the radius, and no further point would fit anywhere.
 * Based on: Lagae and Dutre, An Alternative for Wang Tiles: Colored Edges versus Colored Corners, 2006, and Poisson Sphere
 * Distributions, 2006. Where we differ: zones are sharp and each is filled until it is full, so the whole plane is.
 *
 *      T +------.----------.------+        corner   |x| and |z| < c: a set for each colour of the corner
 *        | cor- : strip    : cor- |        strip    |z| < r / 2 between two corners (here x along it): a set for each pair of
 *        |. ner :..........: ner .|                 colours; strips that end at one corner are r apart, because
 *        |strip :          : strip|                 sqrt(2) (c - r / 2) >= r
 *        |      :  inside  :      |        inside   all the rest, one set a tile: r / 2 from the border, so what is beyond it is
 *        |......:..........:......|                 at least r away
 *        |. cor-: strip    : cor- |
 *      0 +------.----------.------+        Zones reach over the tile's border: a tile has the part of each that lies in it.
 *        0      c        T - c    T
 *
 * A zone is full given those before it, so every place of the plane is within r of a point: the set is maximal for any colouring.
 * Integers only: the tiles are the same everywhere. */
#ifndef SCREE_SCATTER_TILES_H
#define SCREE_SCATTER_TILES_H

#include <stdint.h>

enum {
  SCATTER_SIDE = 4096,      /* T: steps along a tile's side */
  SCATTER_SIDE_BITS = 12,   /* its logarithm */
  SCATTER_RADIUS = 400,     /* r: steps between two points at least */
  SCATTER_CORNER = 484,     /* c */
  SCATTER_TILES = 16,       /* code: bit dx + 2 dz is the colour of corner (dx, dz) */
  SCATTER_MOST_POINTS = 146 /* of a tile: discs of r / 2 take no more than pi / sqrt(12) of a square of T + r */
};

typedef struct scatter_tile {
  uint32_t count;
  uint16_t x[SCATTER_MOST_POINTS], z[SCATTER_MOST_POINTS]; /* below SCATTER_SIDE */
} scatter_tile;

/* Fills the tiles: some ten thousand darts and a search for what they left, a few milliseconds. */
void scree_rt_scatter_make_tiles(uint64_t seed, scatter_tile tiles[SCATTER_TILES]);

#endif
