#include "example_gl.h"

#include <cglm/cglm.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "example_program.h"
#include "example_shaders.h"

void check(bool good, const char* what) {
  if (good) return;
  fprintf(stderr, "scree-example: %s\n", what);
  exit(1);
}

GLFWwindow* open_window(int width, int height) {
  check(glfwInit(), "no display");
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  GLFWwindow* window = glfwCreateWindow(width, height, "scree-example", NULL, NULL);
  check(window != NULL, "no window with OpenGL 4.5");
  glfwMakeContextCurrent(window);
  char log[1024] = "";
  check(use_example_program(shader_example_vert, log, sizeof log) != 0, log);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_CULL_FACE);
  glClearColor(0.62f, 0.73f, 0.85f, 1);
  return window;
}

GLuint make_buffer(GLenum target, GLuint binding, GLsizeiptr size) {
  GLuint buffer;
  glCreateBuffers(1, &buffer);
  glNamedBufferStorage(buffer, size, NULL, GL_DYNAMIC_STORAGE_BIT);
  glBindBuffer(target, buffer);
  if (target == GL_SHADER_STORAGE_BUFFER) glBindBufferBase(target, binding, buffer);
  return buffer;
}

void look(float field_of_view, float x, float y, float z) {
  GLint place[4];
  mat4 projection, camera;
  glGetIntegerv(GL_VIEWPORT, place);
  glm_perspective(field_of_view, (float)place[2] / (float)place[3], 0.2f, 2000, projection);
  glm_look((vec3){0, 0, 0}, (vec3){x, y, z}, (vec3){0, 1, 0}, camera);
  glm_mat4_mul(projection, camera, camera);
  glUniformMatrix4fv(0, 1, GL_FALSE, camera[0]);
}

void write_picture(const char* path, int width, int height) {
  const size_t row = (size_t)width * 3;
  uint8_t* rgb = malloc(row * (size_t)height);
  check(rgb != NULL, "out of memory");
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, rgb);
  FILE* file = fopen(path, "wb");
  check(file != NULL && fprintf(file, "P6 %d %d 255\n", width, height) > 0, path);
  for (int y = height; y-- > 0;) check(fwrite(rgb + (size_t)y * row, row, 1, file) == 1, path);
  check(fclose(file) == 0, path);
  free(rgb);
}
