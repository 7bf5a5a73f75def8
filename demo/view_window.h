/* What both windows of scree-view need: a window with OpenGL, a picture as the camera sees it, and one that is kept. */
#ifndef VIEW_WINDOW_H
#define VIEW_WINDOW_H

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "camera.h"
#include "view_options.h"

#define VIEW_COARSEST 4 /* smallest share of the window's pixels, one way, that a moving picture is drawn at */

/* Starts GLFW and opens a window of the newest OpenGL that there is, current on this thread. NULL, and the reason on the standard
 * error output, where none can be had; GLFW has to be ended by the caller in any case. about: what the title names. */
GLFWwindow* view_window_open(const view_options* options, const char* about);

/* Puts the camera into a picture. */
void view_look(const camera* eye, render_picture* picture);

/* How many pixels share one, each way, in the next moving picture when this one took so many seconds: as fine as the machine can
 * keep up with. */
uint32_t view_coarseness(uint32_t coarseness, double seconds);

/* Writes the picture that was drawn last to the file of --screenshot, or to one of the program's own name; `file` says which. */
scree_result view_picture_save(const view_options* options, render* r, const render_picture* picture, const char** file,
                               scree_error* error);

#endif
