/* Stones that need no pack: noisy, chiselled balls with four levels of detail, and a heap of them. For tests of the renderer. */
#ifndef SYNTHETIC_STONES_H
#define SYNTHETIC_STONES_H

#include "render.h"

#define SYNTHETIC_LATTICE 256.0f /* lattice steps per cell */

/* `count` assets. The source's arrays belong to the caller: free `assets`. decode makes the mesh anew each time. */
bool synthetic_source(uint32_t count, render_source* out);

/* A dome of stones on the plane y = 0. Returns how many there are; *out is the caller's to free. */
uint32_t synthetic_heap(uint32_t assets, float radius, float cell_size, render_stone** out);

#endif
