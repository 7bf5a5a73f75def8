/* Of the surfaces of a small hoodoo, for digest_small. */
#ifndef DIGEST_SURFACE_H
#define DIGEST_SURFACE_H

#include <stdint.h>

/* Three levels, and the asset they make: lattice meshes, mass, hull and parts. */
uint64_t digest_surface(void);

#endif
