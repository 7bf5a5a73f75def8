#include "triangle_sides.h"

#include <stdlib.h>

static int compare(const void* a, const void* b) {
  const triangle_side *x = a, *y = b;
  if (x->low != y->low) return x->low < y->low ? -1 : 1;
  if (x->high != y->high) return x->high < y->high ? -1 : 1;
  return (x->corner > y->corner) - (x->corner < y->corner);
}

void triangle_sides_sort(const uint32_t* indices, uint32_t triangle_count, triangle_side* sides) {
  for (uint32_t c = 0; c < 3 * triangle_count; ++c) {
    const uint32_t from = indices[c], to = indices[next_corner(c)];
    sides[c] = (triangle_side){from < to ? from : to, from < to ? to : from, c, from < to};
  }
  qsort(sides, (size_t)3 * triangle_count, sizeof *sides, compare);
}
