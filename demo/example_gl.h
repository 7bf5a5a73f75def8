/* What scree-example needs of GLFW and OpenGL and what has nothing to do with scree: a window, a program, buffers, a camera, a
 * picture. Whatever fails ends the program. */
#ifndef EXAMPLE_GL_H
#define EXAMPLE_GL_H

#include <epoxy/gl.h>

#include <GLFW/glfw3.h>
#include <stdbool.h>

/* Ends the program with a line unless `good`. */
void check(bool good, const char* what);

/* A window with OpenGL 4.5 that draws with shaders/example.vert; its context is current. */
GLFWwindow* open_window(int width, int height);

/* A buffer of `size` bytes, bound to `target`, and for shader storage to `binding`. */
GLuint make_buffer(GLenum target, GLuint binding, GLsizeiptr size);

/* Looks along a direction from the origin, which is where the eye is: +Y up, field of view in radians from top to bottom. */
void look(float field_of_view, float x, float y, float z);

/* Writes what was drawn as a PPM file. */
void write_picture(const char* path, int width, int height);

#endif
