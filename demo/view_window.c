#include "view_window.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "headless.h"

static GLFWwindow* refuse(void) {
  const char* reason = NULL;
  glfwGetError(&reason);
  fprintf(stderr, "scree-view: no window with OpenGL 3.3 can be opened (%s); --headless draws a picture without one\n",
          reason != NULL ? reason : "no reason given");
  return NULL;
}

GLFWwindow* view_window_open(const view_options* options, const char* about) {
  static const int versions[][2] = {{4, 5}, {4, 3}, {3, 3}};
  if (!glfwInit()) return refuse();
  GLFWwindow* window = NULL;
  char title[SCENE_FILE_SIZE + 32];
  snprintf(title, sizeof title, "scree-view: %s", about);
  for (size_t i = 0; i < sizeof versions / sizeof *versions && window == NULL; ++i) {
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, versions[i][0]);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, versions[i][1]);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    window = glfwCreateWindow((int)options->width, (int)options->height, title, NULL, NULL);
  }
  if (window == NULL) return refuse();
  glfwMakeContextCurrent(window);
  glfwSwapInterval(1);
  return window;
}

void view_look(const camera* eye, render_picture* picture) {
  float right[3];
  memcpy(picture->eye, eye->eye, sizeof picture->eye);
  camera_axes(eye, picture->forward, right, picture->up);
  picture->field_of_view = eye->field_of_view;
}

uint32_t view_coarseness(uint32_t coarseness, double seconds) {
  if (seconds > 0.07 && coarseness < VIEW_COARSEST) return coarseness + 1;
  return seconds < 0.02 && coarseness > 1 ? coarseness - 1 : coarseness;
}

scree_result view_picture_save(const view_options* options, render* r, const render_picture* picture, const char** file,
                               scree_error* error) {
  *file = options->screenshot != NULL ? options->screenshot : "scree-view.png";
  uint8_t* rgb = malloc((size_t)picture->width * picture->height * 3);
  if (rgb == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  render_read(r, rgb);
  const scree_result result = picture_write(*file, picture->width, picture->height, rgb, error);
  free(rgb);
  return result;
}
