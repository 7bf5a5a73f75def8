/* The two textures that stone and ground are made of, computed when the renderer starts: the same numbers on every machine. */
#ifndef RENDER_TEXTURES_H
#define RENDER_TEXTURES_H

#include <scree/base.h>

#define RENDER_NOISE_SIZE 64   /* texels a side of the volume */
#define RENDER_NOISE_PERIOD 8  /* lattice steps after which it repeats */
#define RENDER_DETAIL_SIZE 512 /* texels a side of the detail map */

/* Gradient noise over RENDER_NOISE_PERIOD lattice steps. texels: 4 * RENDER_NOISE_SIZE^3, x fastest: the value in about [-0.7, 0.7]
 * and its derivative by x, y, z per lattice step. */
void render_noise_volume(float* texels);

/* Grain of broken stone: pits, hairline cracks and speckles, tileable. texels: 4 * RENDER_DETAIL_SIZE^2: slope by u and v, height
 * below (-) or above the mean, speckle from dark (-) to bright; each 127.5 (1 + value). */
void render_detail_map(uint8_t* texels);

/* The above as textures with mipmaps on the current context; 0 when memory is short. */
uint32_t render_noise_texture(void);
uint32_t render_detail_texture(void);

#endif
