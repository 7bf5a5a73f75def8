#include "lattice.h"

/* Zones in the order of their numbers: bit a of the mask says that axis a is free (its place is 1..N-1, both planes decide). */
static const uint8_t zone_masks[8] = {0, 1, 2, 4, 3, 5, 6, 7};

static uint32_t free_axes(uint32_t mask) {
  return (mask & 1) + (mask >> 1 & 1) + (mask >> 2 & 1);
}

/* Cells of one zone: (N-1)^free places times 2^(2^free) colourings. */
static uint32_t zone_size(uint32_t n, uint32_t mask, uint32_t* variants) {
  uint32_t places = 1;
  for (uint32_t axis = 0; axis < 3; ++axis)
    if (mask >> axis & 1) places *= n - 1;
  *variants = UINT32_C(1) << (UINT32_C(1) << free_axes(mask));
  return places * *variants;
}

uint32_t scree_rt_lattice_cell_count(uint32_t n) {
  uint32_t total = 0, variants;
  for (uint32_t zone = 0; zone < 8; ++zone) total += zone_size(n, zone_masks[zone], &variants);
  return total;
}

uint32_t scree_rt_lattice_cell(uint32_t n, uint32_t code, uint32_t x, uint32_t y, uint32_t z) {
  const uint32_t place[3] = {x, y, z};
  uint32_t mask = (x > 0 ? 1u : 0u) | (y > 0 ? 2u : 0u) | (z > 0 ? 4u : 0u);

  uint32_t first = 0, variants = 0;
  for (uint32_t zone = 0; zone < 8; ++zone) {
    uint32_t size = zone_size(n, zone_masks[zone], &variants);
    if (zone_masks[zone] == mask) break;
    first += size;
  }

  uint32_t index = 0;
  for (uint32_t axis = 3; axis-- > 0;)
    if (mask >> axis & 1) index = index * (n - 1) + (place[axis] - 1);

  /* The colours that decide, packed: corner bits whose pinned axes are 0. */
  uint32_t colours = 0, count = 0;
  for (uint32_t corner = 0; corner < 8; ++corner)
    if ((corner & ~mask & 7) == 0) colours |= (code >> corner & 1) << count++;
  return first + index * variants + colours;
}

void scree_rt_lattice_cell_place(uint32_t n, uint32_t cell, uint32_t* code, uint32_t* x, uint32_t* y, uint32_t* z) {
  uint32_t place[3] = {0, 0, 0}, mask = 0, variants = 1;
  for (uint32_t zone = 0; zone < 8; ++zone) {
    mask = zone_masks[zone];
    uint32_t size = zone_size(n, mask, &variants);
    if (cell < size) break;
    cell -= size;
  }
  uint32_t colours = cell % variants, index = cell / variants;
  for (uint32_t axis = 0; axis < 3; ++axis)
    if (mask >> axis & 1) {
      place[axis] = index % (n - 1) + 1;
      index /= n - 1;
    }
  *code = 0;
  for (uint32_t corner = 0, count = 0; corner < 8; ++corner)
    if ((corner & ~mask & 7) == 0) *code |= (colours >> count++ & 1) << corner;
  *x = place[0];
  *y = place[1];
  *z = place[2];
}
