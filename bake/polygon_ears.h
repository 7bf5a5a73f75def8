/* A flat polygon in space as triangles. */
#ifndef SCREE_POLYGON_EARS_H
#define SCREE_POLYGON_EARS_H

#include <stddef.h>
#include <stdint.h>

/* Scratch: a corner of the polygon in its plane. */
typedef struct ear_corner {
  double x, y, quality;
  uint32_t next, before;
} ear_corner;

/* Cuts ears, always the best-shaped one, and none whose third side would run along a corner that lies on it, as long as there is
 * one: so vertices within the polygon's edges stay corners and no triangle is flat. positions: 3 each, of all vertices; corners: of
 * the polygon, counter-clockwise about `normal`, holes joined by bridges that are walked both ways; normal: of its plane, of any
 * length. scratch: `count` elements; out: 3 * (count - 2). Returns the number of triangles, count - 2 or, where
 * the polygon walks there and back, fewer. Sides of triangles that are none of the polygon's cancel each other. */
uint32_t polygon_ears(const double* positions, const uint32_t* corners, uint32_t count, const double normal[3], ear_corner* scratch,
                      uint32_t* out);

#endif
