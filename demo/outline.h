/* Supports as wire frames, and the arrows to drag them by. */
#ifndef OUTLINE_H
#define OUTLINE_H

#include "edit.h"
#include "render.h"
#include "scene_support.h"

#define OUTLINE_SEGMENTS 6000 /* most of one outline */

typedef struct outline {
  render_segment* segments; /* owned */
  uint32_t count, capacity;
  double origin[3]; /* world point of the renderer's space */
} outline;

void outline_clear(outline* o);
void outline_free(outline* o);

/* Draws all leaves at and below `node` of the tree `root`. files: for shapes from files, may be NULL. */
void outline_add_node(outline* o, const scene_node* root, const scene_node* node, const scene_paths* paths, scene_files* files,
                      const uint8_t colour[4]);

/* Three arrows of `length` metres from a world point: x red, y green, z blue. `hot`: 0..2 for the one to highlight, else -1. */
void outline_add_arrows(outline* o, const double place[3], double length, int hot);

#endif
