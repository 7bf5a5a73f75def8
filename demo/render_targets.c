#include "render_targets.h"

#include <epoxy/gl.h>
#include <string.h>

static GLuint texture(GLint format, uint32_t width, uint32_t height, GLenum layout, GLenum type) {
  GLuint name = 0;
  glGenTextures(1, &name);
  glBindTexture(GL_TEXTURE_2D, name);
  glTexImage2D(GL_TEXTURE_2D, 0, format, (GLsizei)width, (GLsizei)height, 0, layout, type, NULL);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  return name;
}

static GLuint renderbuffer(GLenum format, uint32_t width, uint32_t height) {
  GLuint name = 0;
  glGenRenderbuffers(1, &name);
  glBindRenderbuffer(GL_RENDERBUFFER, name);
  glRenderbufferStorage(GL_RENDERBUFFER, format, (GLsizei)width, (GLsizei)height);
  return name;
}

static GLuint frame(uint32_t count, const GLuint* textures, bool* complete) {
  static const GLenum slots[3] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2};
  GLuint name = 0;
  glGenFramebuffers(1, &name);
  glBindFramebuffer(GL_FRAMEBUFFER, name);
  for (uint32_t i = 0; i < count; ++i) glFramebufferTexture2D(GL_FRAMEBUFFER, slots[i], GL_TEXTURE_2D, textures[i], 0);
  if (count > 0) {
    glDrawBuffers((GLsizei)count, slots);
    *complete = *complete && glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
  }
  return name;
}

scree_result render_targets_resize(render_targets* t, uint32_t width, uint32_t height) {
  if (t->width == width && t->height == height) return SCREE_OK;
  render_targets_destroy(t);
  while (glGetError() != GL_NO_ERROR) continue;
  t->surface = texture(GL_RGBA16F, width, height, GL_RGBA, GL_FLOAT);
  t->tags = texture(GL_RGBA32UI, width, height, GL_RGBA_INTEGER, GL_UNSIGNED_INT);
  t->depth = texture(GL_R32F, width, height, GL_RED, GL_FLOAT);
  t->occlusion = texture(GL_R8, width, height, GL_RED, GL_UNSIGNED_BYTE);
  t->sum = texture(GL_RGBA32F, width, height, GL_RGBA, GL_FLOAT);
  t->output = renderbuffer(GL_RGBA8, width, height);
  t->depth_buffer = renderbuffer(GL_DEPTH_COMPONENT32F, width, height);

  bool complete = true;
  const GLuint surfaces[3] = {t->surface, t->tags, t->depth};
  t->surface_frame = frame(3, surfaces, &complete);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, t->depth_buffer);
  complete = complete && glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
  t->occlusion_frame = frame(1, &t->occlusion, &complete);
  t->sum_frame = frame(1, &t->sum, &complete);
  t->output_frame = frame(0, NULL, &complete);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, t->output);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, t->depth_buffer);
  complete = complete && glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
  bool out_of_memory = glGetError() != GL_NO_ERROR;
  if (!complete || out_of_memory) {
    render_targets_destroy(t);
    return out_of_memory ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_ERROR_UNSUPPORTED;
  }
  t->width = width;
  t->height = height;
  return SCREE_OK;
}

void render_targets_destroy(render_targets* t) {
  const GLuint frames[] = {t->surface_frame, t->occlusion_frame, t->sum_frame, t->output_frame};
  const GLuint textures[] = {t->surface, t->tags, t->depth, t->occlusion, t->sum};
  const GLuint buffers[] = {t->output, t->depth_buffer};
  glDeleteFramebuffers(4, frames);
  glDeleteTextures(5, textures);
  glDeleteRenderbuffers(2, buffers);
  memset(t, 0, sizeof *t);
}

scree_result render_shadows_create(render_shadows* s, uint32_t size, uint32_t layers) {
  memset(s, 0, sizeof *s);
  while (glGetError() != GL_NO_ERROR) continue;
  s->size = size;
  s->layers = layers;
  glGenTextures(1, &s->texture);
  glBindTexture(GL_TEXTURE_2D_ARRAY, s->texture);
  glTexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_DEPTH_COMPONENT32F, (GLsizei)size, (GLsizei)size, (GLsizei)layers, 0, GL_DEPTH_COMPONENT,
               GL_FLOAT, NULL);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAX_LEVEL, 0);

  /* One texture, read in two ways: as depth for the search of what casts, and compared for the filter. */
  GLuint samplers[2];
  glGenSamplers(2, samplers);
  for (int i = 0; i < 2; ++i) {
    GLint filter = i == 0 ? GL_NEAREST : GL_LINEAR;
    glSamplerParameteri(samplers[i], GL_TEXTURE_MIN_FILTER, filter);
    glSamplerParameteri(samplers[i], GL_TEXTURE_MAG_FILTER, filter);
    glSamplerParameteri(samplers[i], GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glSamplerParameteri(samplers[i], GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }
  glSamplerParameteri(samplers[1], GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glSamplerParameteri(samplers[1], GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  s->plain_sampler = samplers[0];
  s->compare_sampler = samplers[1];

  glGenFramebuffers(1, &s->frame);
  glBindFramebuffer(GL_FRAMEBUFFER, s->frame);
  glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, s->texture, 0, 0);
  glDrawBuffer(GL_NONE);
  glReadBuffer(GL_NONE);
  bool complete = glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
  bool out_of_memory = glGetError() != GL_NO_ERROR;
  if (complete && !out_of_memory) return SCREE_OK;
  render_shadows_destroy(s);
  return out_of_memory ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_ERROR_UNSUPPORTED;
}

void render_shadows_destroy(render_shadows* s) {
  const GLuint samplers[2] = {s->plain_sampler, s->compare_sampler};
  glDeleteTextures(1, &s->texture);
  glDeleteFramebuffers(1, &s->frame);
  glDeleteSamplers(2, samplers);
  memset(s, 0, sizeof *s);
}
