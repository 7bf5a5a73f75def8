/* An OpenGL context without a window or a display, by way of EGL's surfaceless platform; and the picture file at the end. */
#ifndef HEADLESS_H
#define HEADLESS_H

#include <scree/base.h>

typedef struct headless headless;

/* Makes a context of the highest core version that can be had, 3.3 or newer, current on this thread.
 * Returns SCREE_OK or UNSUPPORTED with the reason. */
scree_result headless_create(headless** out, scree_error* error);
void headless_destroy(headless* h);

/* Writes an 8-bit RGB picture, top row first, as PNG: to a temporary name beside `path`, then renamed. Returns SCREE_OK or IO. */
scree_result picture_write(const char* path, uint32_t width, uint32_t height, const uint8_t* rgb, scree_error* error);

#endif
