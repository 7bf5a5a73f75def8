/* Prints the digests that must be the same on every compiler, optimisation level and CPU, one `name value` a line. Only our own C
 * is linked, so that it cross-compiles with nothing but a compiler; content/golden/small.txt holds what it must print. */
#include "lattice.h"

#include <inttypes.h>
#include <stdio.h>

/* Every cell of every tile, and the colours of a block of corners round the origin and at the ends of the int32 lattice. */
static uint64_t digest_lattice(void) {
  uint64_t digest = 0;
  for (uint32_t n = 3; n <= 6; ++n)
    for (uint32_t code = 0; code < 256; ++code)
      for (uint32_t z = 0; z < n; ++z)
        for (uint32_t y = 0; y < n; ++y)
          for (uint32_t x = 0; x < n; ++x) digest = hash_combine(digest, lattice_cell(n, code, x, y, z));
  const int32_t starts[3] = {-8, INT32_MIN, INT32_MAX - 17};
  for (int i = 0; i < 3; ++i)
    for (int32_t z = 0; z < 16; ++z)
      for (int32_t y = 0; y < 16; ++y)
        for (int32_t x = 0; x < 16; ++x)
          digest = hash_combine(digest, cube_code(2009, starts[i] + x, starts[i] + y, starts[i] + z));
  return digest;
}

int main(void) {
  printf("lattice %016" PRIx64 "\n", digest_lattice());
  return 0;
}
