/* The program that the example draws with, for whoever draws the same way in other windows or in none. */
#ifndef EXAMPLE_PROGRAM_H
#define EXAMPLE_PROGRAM_H

#include <epoxy/gl.h>

/* shaders/example.frag after the text of a vertex shader, put to use with a vertex array, which OpenGL wants although it holds
 * nothing. Returns the program, or 0 with the linker's words in log. */
GLuint use_example_program(const char* vertex, char* log, GLsizei log_size);

#endif
