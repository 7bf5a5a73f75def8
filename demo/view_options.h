/* The command line of scree-view. */
#ifndef VIEW_OPTIONS_H
#define VIEW_OPTIONS_H

#include <stdio.h>

#include "render.h"
#include "scene_support.h"
#include "weather_colour.h"

typedef struct view_options {
  scene_paths paths; /* the scene's file and the folders */
  const char* screenshot;
  const char* log; /* "-" = standard output; NULL = none */
  uint32_t width, height;
  uint32_t samples; /* 0 = the program's choice */
  int32_t lod;
  render_colour colour;
  float pixel_error; /* 0 = the renderer's */
  bool headless, wireframe, no_indirect, no_panel, all_rocks;
  bool has_camera;
  double eye[3], target[3], field_of_view; /* metres, degrees */
  const char* weather;                     /* the recipe to weather by hand, NULL = a scene is shown */
  uint32_t steps, variant;                 /* of it: taken before the first picture; which one */
  weather_colour paint;
  bool tells_levels, tells_weather; /* --colour is a word of scenes, of recipes */
} view_options;

/* Returns -1 to go on, else the exit status; help, version and complaints are printed. */
int view_options_parse(int count, char** arguments, view_options* out);

/* What was given as a scene is a recipe to weather. */
void view_options_weather(view_options* options);
/* What belongs to scenes was given with a recipe, or the other way round: prints why and returns the exit status, -1 to go on. */
int view_options_check(const view_options* options);

/* The file of --log; NULL when there is none or it cannot be written. */
FILE* view_log_open(const view_options* options);
void view_log_close(FILE* log);

/* The keys and mouse buttons of the window, one a line, as --help prints them and the help overlay shows them. */
extern const char view_keys[];
/* The same when a recipe is weathered. */
extern const char weather_keys[];

#endif
