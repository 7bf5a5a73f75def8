/* Sides of triangles, sorted so that those at one edge stand side by side. */
#ifndef SCREE_TRIANGLE_SIDES_H
#define SCREE_TRIANGLE_SIDES_H

#include <stdbool.h>
#include <stdint.h>

typedef struct triangle_side {
  uint32_t low, high; /* vertices at its ends */
  uint32_t corner;    /* 3 * triangle + k: from corner k to the next */
  bool rising;        /* from low to high */
} triangle_side;

static inline uint32_t next_corner(uint32_t corner) {
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}

/* sides: one of each corner. By edge, then by corner. */
void triangle_sides_sort(const uint32_t* indices, uint32_t triangle_count, triangle_side* sides);

#endif
