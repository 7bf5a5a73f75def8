/* scree-view over a recipe of a hoodoo: weathering by hand in a window, or one picture without a display. */
#ifndef WEATHER_VIEW_H
#define WEATHER_VIEW_H

#include "view_options.h"

/* Opens the recipe, takes options->steps steps, and shows it. jobs: who weathers, makes surfaces and decodes. Returns the exit
 * status: 0, 1 (no display, no OpenGL, no memory) or 2 (the recipe cannot be weathered). */
int weather_view_run(const view_options* options, const scree_jobs* jobs);

#endif
