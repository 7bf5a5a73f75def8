#include "example_program.h"

#include "example_shaders.h"

static void add_shader(GLuint program, GLenum kind, const char* text) {
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &text, NULL);
  glCompileShader(shader);
  glAttachShader(program, shader);
  glDeleteShader(shader);
}

GLuint use_example_program(const char* vertex, char* log, GLsizei log_size) {
  const GLuint program = glCreateProgram();
  add_shader(program, GL_VERTEX_SHADER, vertex);
  add_shader(program, GL_FRAGMENT_SHADER, shader_example_frag);
  glLinkProgram(program);
  GLint linked;
  glGetProgramiv(program, GL_LINK_STATUS, &linked);
  if (!linked) {
    glGetProgramInfoLog(program, log_size, NULL, log);
    glDeleteProgram(program);
    return 0;
  }
  glUseProgram(program);
  GLuint vertex_array;
  glGenVertexArrays(1, &vertex_array);
  glBindVertexArray(vertex_array);
  return program;
}
