/* Of small shards and what frost makes of them, for digest_small. */
#ifndef DIGEST_FROST_H
#define DIGEST_FROST_H

#include <stdint.h>

/* A hill, and a wall of columns. 0 where they cannot be made. */
uint64_t digest_shards(void);

/* The hill and a lattice after some thousand paths: several rains, noise, stability, blocks. */
uint64_t digest_frost(void);

#endif
