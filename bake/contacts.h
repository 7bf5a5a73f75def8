/* Contacts: the points that two neighbouring rocks share and erosion spares. */
#ifndef SCREE_CONTACTS_H
#define SCREE_CONTACTS_H

#include <stdbool.h>

#include "seeds.h"

#define MAX_CONTACTS 255 /* of one rock; more are never seen, and the lowest neighbours win */

/* The 27 cells around a cell of a tile, x fastest, and their seeds. Cell 13 is the middle. */
typedef struct neighbourhood {
  const rock_seed* seeds[27];
  uint32_t counts[27];
  int32_t unit;
} neighbourhood;

void neighbourhood_gather(const seed_set* set, uint32_t code, int32_t x, int32_t y, int32_t z, neighbourhood* out);

typedef struct rock_contact {
  int32_t position[3]; /* units, relative to the centre of the rock's own cell */
  int8_t cell[3];
  uint8_t seed;
} rock_contact;

/* All contacts of rock `seed` of the middle cell, ordered by (cell z, y, x, seed). Both rocks of a pair find the same point, to the
 * bit, because it is computed in the frame of the lower cell. `discard` is the share thrown away, by a hash of the pair.
 * contacts: room for MAX_CONTACTS. Returns how many. */
uint32_t contacts_find(const neighbourhood* around, uint32_t seed, double discard, rock_contact* contacts);

#endif
