/* Digests of saved edits, of what is decided about convex hulls, and of rays and overlaps. */
#ifndef DIGEST_EDITS_H
#define DIGEST_EDITS_H

#include <stdint.h>

/* Zero when something fails. */
uint64_t digest_edits(void);

uint64_t digest_convex(void);

uint64_t digest_spatial(void);

#endif
