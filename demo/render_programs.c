#include "render_programs.h"

#include <epoxy/gl.h>
#include <stdio.h>
#include <string.h>

#include "shaders.h"

#define PARTS_MOST 8

typedef struct stage {
  GLenum kind;
  const char* name;
  const char* parts[PARTS_MOST]; /* after #version, ended by NULL */
} stage;

static GLuint compile(const stage* s, scree_error* error) {
  const char* parts[PARTS_MOST + 1] = {"#version 330 core\n"};
  GLsizei count = 1;
  for (; count <= PARTS_MOST && s->parts[count - 1] != NULL; ++count) parts[count] = s->parts[count - 1];
  GLuint shader = glCreateShader(s->kind);
  glShaderSource(shader, count, parts, NULL);
  glCompileShader(shader);
  GLint done = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &done);
  if (done == GL_TRUE) return shader;
  char log[400] = "";
  glGetShaderInfoLog(shader, sizeof log, NULL, log);
  for (char* c = log; *c != 0; ++c)
    if (*c == '\n') *c = ' ';
  snprintf(error->message, sizeof error->message, "shader %s does not compile: %s", s->name, log);
  glDeleteShader(shader);
  return 0;
}

static GLuint link(const stage* vertex, const stage* fragment, scree_error* error) {
  GLuint v = compile(vertex, error);
  if (v == 0) return 0;
  GLuint f = fragment != NULL ? compile(fragment, error) : 0;
  if (fragment != NULL && f == 0) {
    glDeleteShader(v);
    return 0;
  }
  GLuint program = glCreateProgram();
  glAttachShader(program, v);
  if (f != 0) glAttachShader(program, f);
  glLinkProgram(program);
  glDeleteShader(v);
  if (f != 0) glDeleteShader(f);
  GLint done = GL_FALSE;
  glGetProgramiv(program, GL_LINK_STATUS, &done);
  if (done != GL_TRUE) {
    char log[400] = "";
    glGetProgramInfoLog(program, sizeof log, NULL, log);
    snprintf(error->message, sizeof error->message, "shaders %s and %s do not link: %s", vertex->name,
             fragment != NULL ? fragment->name : "none", log);
    glDeleteProgram(program);
    return 0;
  }
  GLuint block = glGetUniformBlockIndex(program, "Frame");
  if (block != GL_INVALID_INDEX) glUniformBlockBinding(program, block, 0);

  static const struct {
    const char* name;
    GLint unit;
  } samplers[] = {{"noise_volume", RENDER_UNIT_NOISE},
                  {"detail_map", RENDER_UNIT_DETAIL},
                  {"shadow_depth", RENDER_UNIT_SHADOW_DEPTH},
                  {"shadow_compare", RENDER_UNIT_SHADOW_COMPARE},
                  {"surface_map", RENDER_UNIT_SURFACE},
                  {"tags_map", RENDER_UNIT_TAGS},
                  {"depth_map", RENDER_UNIT_DEPTH},
                  {"occlusion_map", RENDER_UNIT_OCCLUSION},
                  {"sum_map", RENDER_UNIT_SUM}};
  glUseProgram(program);
  for (size_t i = 0; i < sizeof samplers / sizeof *samplers; ++i) {
    GLint place = glGetUniformLocation(program, samplers[i].name);
    if (place >= 0) glUniform1i(place, samplers[i].unit);
  }
  glUseProgram(0);
  return program;
}

scree_result render_programs_create(render_programs* programs, scree_error* error) {
  memset(programs, 0, sizeof *programs);
  const stage stone = {GL_VERTEX_SHADER, "stone.vert", {shader_frame_glsl, shader_stone_vert}};
  const stage model = {GL_VERTEX_SHADER, "model.vert", {shader_frame_glsl, shader_model_vert}};
  const stage model_surface = {GL_FRAGMENT_SHADER, "model.frag", {shader_frame_glsl, shader_noise_glsl, shader_model_frag}};
  const stage solid = {GL_VERTEX_SHADER, "solid.vert", {shader_frame_glsl, shader_solid_vert}};
  const stage caster = {GL_VERTEX_SHADER, "caster.vert", {shader_caster_vert}};
  const stage fullscreen = {GL_VERTEX_SHADER, "fullscreen.vert", {shader_fullscreen_vert}};
  const stage line_vertex = {GL_VERTEX_SHADER, "line.vert", {shader_frame_glsl, shader_line_vert}};
  const stage surface = {GL_FRAGMENT_SHADER, "surface.frag", {shader_surface_frag}};
  const stage occlusion = {GL_FRAGMENT_SHADER, "occlusion.frag", {shader_frame_glsl, shader_occlusion_frag}};
  const stage light = {GL_FRAGMENT_SHADER,
                       "light.frag",
                       {shader_frame_glsl, shader_noise_glsl, shader_sky_glsl, shader_shadow_glsl, shader_stone_glsl,
                        shader_sandstone_glsl, shader_ground_glsl, shader_light_frag}};
  const stage resolve = {GL_FRAGMENT_SHADER, "resolve.frag", {shader_frame_glsl, shader_resolve_frag}};
  const stage line_fragment = {GL_FRAGMENT_SHADER, "line.frag", {shader_line_frag}};

  if ((programs->stone = link(&stone, &surface, error)) == 0 || (programs->model = link(&model, &model_surface, error)) == 0 ||
      (programs->solid = link(&solid, &surface, error)) == 0 || (programs->caster = link(&caster, NULL, error)) == 0 ||
      (programs->occlusion = link(&fullscreen, &occlusion, error)) == 0 ||
      (programs->light = link(&fullscreen, &light, error)) == 0 || (programs->resolve = link(&fullscreen, &resolve, error)) == 0 ||
      (programs->line = link(&line_vertex, &line_fragment, error)) == 0) {
    render_programs_destroy(programs);
    return SCREE_ERROR_UNSUPPORTED;
  }
  programs->stone_extra_tags = glGetUniformLocation(programs->stone, "extra_tags");
  programs->model_extra_tags = glGetUniformLocation(programs->model, "extra_tags");
  programs->model_look = glGetUniformLocation(programs->model, "look");
  programs->solid_extra_tags = glGetUniformLocation(programs->solid, "extra_tags");
  programs->solid_tags = glGetUniformLocation(programs->solid, "solid_tags");
  programs->caster_clip = glGetUniformLocation(programs->caster, "clip_from_world_caster");
  programs->line_half_width = glGetUniformLocation(programs->line, "half_width");
  programs->line_opacity = glGetUniformLocation(programs->line, "opacity");
  return SCREE_OK;
}

void render_programs_destroy(render_programs* programs) {
  const GLuint all[] = {programs->stone,     programs->model, programs->solid,   programs->caster,
                        programs->occlusion, programs->light, programs->resolve, programs->line};
  for (size_t i = 0; i < sizeof all / sizeof *all; ++i) glDeleteProgram(all[i]); /* 0 is ignored */
  memset(programs, 0, sizeof *programs);
}
