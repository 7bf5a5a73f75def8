/* The window of scree-view: camera, editing, panel, until it is closed. */
#ifndef WINDOW_H
#define WINDOW_H

#include "view_options.h"

/* Shows and edits `scene`; jobs: who queries and decodes. Returns the exit status: 0, 1 (no display, no OpenGL, no memory) or 2
 * (the scene cannot be shown). */
int window_run(const view_options* options, scene_model* scene, const scree_jobs* jobs);

#endif
