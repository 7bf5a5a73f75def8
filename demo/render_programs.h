/* The renderer's shader programs: compiled from the texts that the build embeds. */
#ifndef RENDER_PROGRAMS_H
#define RENDER_PROGRAMS_H

#include <scree/base.h>

enum {
  RENDER_UNIT_NOISE,
  RENDER_UNIT_DETAIL,
  RENDER_UNIT_SHADOW_DEPTH,
  RENDER_UNIT_SHADOW_COMPARE,
  RENDER_UNIT_SURFACE,
  RENDER_UNIT_TAGS,
  RENDER_UNIT_DEPTH,
  RENDER_UNIT_OCCLUSION,
  RENDER_UNIT_SUM
};

typedef struct render_programs {
  uint32_t stone, model, solid, caster, occlusion, light, resolve, line;
  int32_t stone_extra_tags, model_extra_tags, model_look, solid_extra_tags, solid_tags, caster_clip, line_half_width, line_opacity;
} render_programs;

/* Returns SCREE_OK or UNSUPPORTED with the compiler's first words in `error`. Texture units are bound as above and the uniform
 * block to binding point 0. */
scree_result render_programs_create(render_programs* programs, scree_error* error);
void render_programs_destroy(render_programs* programs);

#endif
