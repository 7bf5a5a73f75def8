/* One digest of scatters: tiles, ground, models, turns and sizes, and a scene in which rocks make room. */
#ifndef DIGEST_SCATTER_H
#define DIGEST_SCATTER_H

#include <stdint.h>

/* Zero when something fails. */
uint64_t digest_scatter(void);

#endif
