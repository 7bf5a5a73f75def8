/* Where the shadow cascades of a picture lie. Pure arithmetic. */
#ifndef RENDER_LIGHTS_H
#define RENDER_LIGHTS_H

#include <scree/base.h>

/* A parallel view along the sun's rays. Its own space: x and y across the rays, z along them, away from the sun. */
typedef struct render_cascade {
  float axes[3][3];     /* unit, of x, y, z */
  float min[3], max[3]; /* in that space, metres; max - min is the same in x and y */
  float texel;          /* metres */
} render_cascade;

typedef struct render_cascade_desc {
  float sun[3];                         /* unit, towards the sun */
  float eye[3], forward[3];             /* unit forward */
  float right[3], up[3];                /* times the tangents of half the fields of view */
  float casters_min[3], casters_max[3]; /* world box of all that casts shadows */
  float pixel;                          /* metres across a pixel at distance 1 */
  uint32_t size;                        /* texels a side */
  uint32_t count;                       /* cascades wanted, 1..RENDER_CASCADES */
} render_cascade_desc;

/* Splits what the camera sees of the casters' shadows among cascades, near ones finer. Returns how many are of use: fewer when a
 * later one would add nothing. A point outside of all of them is lit. */
uint32_t render_fit_cascades(const render_cascade_desc* desc, render_cascade* cascades);

/* Column-major matrix into clip space, as OpenGL takes it. */
void render_cascade_clip(const render_cascade* cascade, float matrix[16]);

/* Four planes, the normals into the cascade: what lies beyond them casts no shadow that it could show. */
void render_cascade_planes(const render_cascade* cascade, float planes[4][4]);

#endif
