/* Framebuffers of the renderer. */
#ifndef RENDER_TARGETS_H
#define RENDER_TARGETS_H

#include <scree/base.h>

typedef struct render_targets {
  uint32_t width, height;
  uint32_t surface, tags, depth, occlusion, sum, output; /* textures; output is a renderbuffer */
  uint32_t depth_buffer;                                 /* shared by surface_frame and output_frame */
  uint32_t surface_frame, occlusion_frame, sum_frame, output_frame;
} render_targets;

/* Makes all of them for this size; the old ones go. Returns SCREE_OK, OUT_OF_MEMORY or UNSUPPORTED. */
scree_result render_targets_resize(render_targets* t, uint32_t width, uint32_t height);
void render_targets_destroy(render_targets* t);

typedef struct render_shadows {
  uint32_t size, layers;
  uint32_t texture, frame;
  uint32_t plain_sampler, compare_sampler;
} render_shadows;

scree_result render_shadows_create(render_shadows* s, uint32_t size, uint32_t layers);
void render_shadows_destroy(render_shadows* s);

#endif
