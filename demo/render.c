#include "render.h"

#include <epoxy/gl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "render_cache.h"
#include "render_free.h"
#include "render_lights.h"
#include "render_list.h"
#include "render_programs.h"
#include "render_solid.h"
#include "render_targets.h"
#include "render_textures.h"

#define SHADOW_SIZE 2048
#define PIXEL_ERROR 2.0f  /* of the largest distance between two levels: what an outline is off by is a fifth of it */
#define SHADOW_ERROR 3.0f /* the same in texels of a cascade */
#define SUN_RADIUS 0.016f /* radians; the real one's 0.0047 would look cut with a knife at the size of a stone */
#define EXPOSURE 0.64f    /* at which sunlit pale stone is bright and not yet white */
#define SUN_STRENGTH 3.1f /* of the sky's */
#define KIND_STONE (1u << 8)
#define KIND_GROUND (2u << 8)
#define KIND_TERRAIN (3u << 8)
#define KIND_WATER (4u << 8)
#define KIND_MODEL (5u << 8)
#define TAG_WIRE (1u << 4)
#define CASTERS UINT32_MAX

/* Mirrors frame.glsl, std140: nothing but vectors of four. */
typedef struct frame_block {
  float clip_from_world[16];
  float shadow_from_world[RENDER_CASCADES][16];
  float cascade[RENDER_CASCADES][4];
  float eye[4], right[4], up[4], forward[4];
  float size[4], jitter[4];
  float sun[4], sun_colour[4];
  float sky_zenith[4], sky_horizon[4], sky_haze[4], ground_colour[4];
  float ground[4], water[4], occlusion[4], air[4];
  int32_t mode[4];
} frame_block;

struct render {
  bool indirect;
  render_programs programs;
  render_targets targets;
  render_shadows shadows;
  render_cache cache;
  render_list view_list, cascade_lists[RENDER_CASCADES];
  render_cascade cascades[RENDER_CASCADES];
  uint32_t cascade_count;
  uint32_t noise, detail;
  uint32_t frame_buffer, instance_buffer, command_buffer;
  uint32_t empty_array, segment_array, segment_buffer;
  render_solid ground, terrain;
  render_free free_mesh;
  render_stone* stones;
  uint8_t* levels; /* of each stone in the camera's view */
  uint32_t stone_count;
  float stones_min[3], stones_max[3], stone_size; /* box of all balls; smallest cell size */
  render_picture last;                            /* what the sum holds; width 0 = nothing */
  uint32_t samples;
  float near_plane, far_plane;
  frame_block frame;
  render_stats stats;
};

static float dot3(const float a[3], const float b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross3(const float a[3], const float b[3], float out[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

/* --- Making and unmaking --- */

static void bind_texture(GLuint unit, GLenum target, GLuint texture) {
  glActiveTexture(GL_TEXTURE0 + unit);
  glBindTexture(target, texture);
}

static void segments_create(render* r) {
  glGenVertexArrays(1, &r->segment_array);
  glGenBuffers(1, &r->segment_buffer);
  glBindVertexArray(r->segment_array);
  glBindBuffer(GL_ARRAY_BUFFER, r->segment_buffer);
  for (GLuint attribute = 0; attribute < 3; ++attribute) {
    glEnableVertexAttribArray(attribute);
    glVertexAttribDivisor(attribute, 1);
  }
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(render_segment), buffer_offset(offsetof(render_segment, from)));
  glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, sizeof(render_segment), buffer_offset(offsetof(render_segment, to)));
  glVertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(render_segment), buffer_offset(offsetof(render_segment, colour)));
  glBindVertexArray(0);
}

scree_result render_create(const render_desc* desc, render** out, scree_error* error) {
  *out = NULL;
  if (epoxy_gl_version() < 33) {
    snprintf(error->message, sizeof error->message, "OpenGL 3.3 is needed, the context has %d.%d", epoxy_gl_version() / 10,
             epoxy_gl_version() % 10);
    return SCREE_ERROR_UNSUPPORTED;
  }
  render* r = calloc(1, sizeof *r);
  if (r == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  r->indirect = !desc->no_indirect && epoxy_gl_version() >= 43;
  glGenBuffers(1, &r->instance_buffer);
  glGenBuffers(1, &r->command_buffer);
  glGenBuffers(1, &r->frame_buffer);
  glGenVertexArrays(1, &r->empty_array);
  render_cache_create(&r->cache, r->instance_buffer, &desc->jobs);
  render_solid_create(&r->ground);
  render_solid_create(&r->terrain);
  render_free_create(&r->free_mesh);
  segments_create(r);
  scree_result result = render_programs_create(&r->programs, error);
  if (result == SCREE_OK) {
    result = render_shadows_create(&r->shadows, desc->shadow_size != 0 ? desc->shadow_size : SHADOW_SIZE, RENDER_CASCADES);
    if (result != SCREE_OK) snprintf(error->message, sizeof error->message, "no framebuffer for shadows can be had");
  }
  if (result == SCREE_OK) {
    r->noise = render_noise_texture();
    r->detail = render_detail_texture();
    if (r->noise == 0 || r->detail == 0) {
      snprintf(error->message, sizeof error->message, "no memory for the stone textures");
      result = SCREE_ERROR_OUT_OF_MEMORY;
    }
  }
  if (result != SCREE_OK) {
    render_destroy(r);
    return result;
  }
  glBindBuffer(GL_UNIFORM_BUFFER, r->frame_buffer);
  glBufferData(GL_UNIFORM_BUFFER, sizeof(frame_block), NULL, GL_DYNAMIC_DRAW);
  *out = r;
  return SCREE_OK;
}

void render_destroy(render* r) {
  if (r == NULL) return;
  render_cache_destroy(&r->cache);
  render_list_destroy(&r->view_list);
  for (int i = 0; i < RENDER_CASCADES; ++i) render_list_destroy(&r->cascade_lists[i]);
  render_programs_destroy(&r->programs);
  render_targets_destroy(&r->targets);
  render_shadows_destroy(&r->shadows);
  render_solid_destroy(&r->ground);
  render_solid_destroy(&r->terrain);
  render_free_destroy(&r->free_mesh);
  const GLuint textures[] = {r->noise, r->detail};
  const GLuint buffers[] = {r->instance_buffer, r->command_buffer, r->frame_buffer, r->segment_buffer};
  const GLuint arrays[] = {r->empty_array, r->segment_array};
  glDeleteTextures(2, textures);
  glDeleteBuffers(4, buffers);
  glDeleteVertexArrays(2, arrays);
  free(r->stones);
  free(r->levels);
  free(r);
}

/* --- What is drawn --- */

uint32_t render_add_source(render* r, const render_source* source) {
  return render_cache_add(&r->cache, source);
}

void render_remove_source(render* r, uint32_t source) {
  if (source >= RENDER_SOURCES) return;
  render_cache_remove(&r->cache, source);
  r->last.width = 0;
}

scree_result render_set_stones(render* r, const render_stone* stones, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t source = stones[i].source;
    if (source >= RENDER_SOURCES || !r->cache.sources[source].used ||
        stones[i].asset >= r->cache.sources[source].source.asset_count)
      return SCREE_ERROR_INVALID_ARGUMENT;
  }
  render_stone* copy = malloc((count > 0 ? count : 1) * sizeof *copy);
  uint8_t* levels = malloc(count > 0 ? count : 1);
  if (copy == NULL || levels == NULL) {
    free(copy);
    free(levels);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  if (count > 0) memcpy(copy, stones, count * sizeof *copy);
  free(r->stones);
  free(r->levels);
  r->stones = copy;
  r->levels = levels;
  r->stone_count = count;
  r->last.width = 0;

  /* The smallest, not the mean: leaving out stones that nobody sees must not change what the ground and the shadows look like. */
  float smallest = INFINITY;
  for (int a = 0; a < 3; ++a) {
    r->stones_min[a] = INFINITY;
    r->stones_max[a] = -INFINITY;
  }
  for (uint32_t i = 0; i < count; ++i) {
    const render_asset* asset = &r->cache.sources[stones[i].source].assets[stones[i].asset];
    const float size = stones[i].cell_size;
    float centre[3];
    render_stone_centre(&stones[i], asset, centre);
    for (int a = 0; a < 3; ++a) {
      r->stones_min[a] = fminf(r->stones_min[a], centre[a] - asset->radius * size);
      r->stones_max[a] = fmaxf(r->stones_max[a], centre[a] + asset->radius * size);
    }
    smallest = fminf(smallest, size);
  }
  r->stone_size = count > 0 ? smallest : 1.0f;
  return SCREE_OK;
}

scree_result render_set_terrain(render* r, const float* positions, const float* normals, uint32_t vertex_count,
                                const uint32_t* indices, uint32_t index_count) {
  r->last.width = 0;
  return render_solid_fill(&r->terrain, positions, normals, vertex_count, indices, index_count);
}

scree_result render_set_free_mesh(render* r, const render_vertex* vertices, uint32_t vertex_count, const uint32_t* indices,
                                  uint32_t index_count, render_look look, const uint8_t colour[3]) {
  if (look != RENDER_LOOK_HOODOO && look != RENDER_LOOK_PAINTED) return SCREE_ERROR_INVALID_ARGUMENT;
  r->last.width = 0;
  r->free_mesh.look = look;
  memcpy(r->free_mesh.colour, colour, sizeof r->free_mesh.colour);
  const scree_result result = render_free_fill(&r->free_mesh, vertices, vertex_count, indices, index_count);
  r->stats.free_triangles = r->free_mesh.index_count / 3;
  r->stats.free_sent = r->free_mesh.sent;
  return result;
}

/* --- Preparing a picture --- */

void render_picture_init(render_picture* p) {
  *p = (render_picture){.field_of_view = 0.8f,
                        .forward = {0, 0, -1},
                        .up = {0, 1, 0},
                        .samples = 1,
                        .lod = -1,
                        .sun = {-0.52f, 0.62f, 0.44f},
                        .sun_colour = {1.0f, 0.88f, 0.74f},
                        .sky = {0.55f, 0.66f, 0.78f},
                        .ground = true,
                        .ground_colour = {0.202f, 0.181f, 0.117f}};
}

static void prepare_camera(render* r, const render_picture* p) {
  frame_block* f = &r->frame;
  float across[3];
  cross3(p->forward, p->up, across);
  const float tangent = tanf(0.5f * p->field_of_view), aspect = (float)p->width / (float)p->height;
  for (int a = 0; a < 3; ++a) {
    f->eye[a] = p->eye[a];
    f->forward[a] = p->forward[a];
    f->right[a] = across[a] * tangent * aspect;
    f->up[a] = p->up[a] * tangent;
  }
  f->eye[3] = 2 * tangent / (float)p->height;
  f->size[0] = (float)p->width;
  f->size[1] = (float)p->height;
  f->size[2] = 1 / f->size[0];
  f->size[3] = 1 / f->size[1];

  /* The near plane as far out as the scene allows: depth is finer then. */
  float closest = INFINITY, extent = 1;
  const float* boxes[3][2] = {
      {r->stones_min, r->stones_max}, {r->terrain.min, r->terrain.max}, {r->free_mesh.min, r->free_mesh.max}};
  const uint32_t present[3] = {r->stone_count, r->terrain.index_count, r->free_mesh.index_count};
  for (int b = 0; b < 3; ++b) {
    if (present[b] == 0) continue;
    float away = 0;
    for (int a = 0; a < 3; ++a) {
      float outside = fmaxf(fmaxf(boxes[b][0][a] - p->eye[a], p->eye[a] - boxes[b][1][a]), 0);
      away += outside * outside;
      extent = fmaxf(extent, boxes[b][1][a] - boxes[b][0][a]);
      extent = fmaxf(extent, outside);
    }
    closest = fminf(closest, sqrtf(away));
  }
  if (p->ground) closest = fminf(closest, fabsf(p->eye[1] - p->ground_height));
  float smallest = r->stone_count > 0 ? 0.05f * r->stone_size : 0.02f;
  r->near_plane = fmaxf(isfinite(closest) ? 0.3f * closest : 0, smallest);
  r->far_plane = fmaxf(40 * extent, 4000);

  f->ground[0] = p->ground_height;
  f->ground[1] = p->ground && !p->water ? 1 : 0;
  f->water[3] = p->ground && p->water ? 1 : 0;
  f->ground[2] = r->stone_count > 0 ? r->stone_size : 1;
  f->occlusion[0] = 2.4f * f->ground[2];
  f->occlusion[1] = 0.16f * (float)p->height;
  f->occlusion[3] = 1;
  f->air[0] = 1 / (900 + 6 * extent);
  f->air[1] = EXPOSURE * (p->exposure > 0 ? p->exposure : 1);
  f->mode[0] = (int32_t)p->colour;
}

static void prepare_sun(render* r, const render_picture* p) {
  frame_block* f = &r->frame;
  float sun[3];
  memcpy(sun, p->sun, sizeof sun);
  float length = sqrtf(dot3(sun, sun));
  for (int a = 0; a < 3; ++a) f->sun[a] = sun[a] / length;
  f->sun[3] = SUN_RADIUS;
  const float* sky = p->sky;
  const float grey = 0.2126f * sky[0] + 0.7152f * sky[1] + 0.0722f * sky[2];
  for (int a = 0; a < 3; ++a) {
    f->sun_colour[a] = SUN_STRENGTH * powf(p->sun_colour[a], 0.6f); /* a camera balances some of the tint away */
    f->sky_horizon[a] = sky[a];
    f->sky_zenith[a] = sky[a] * sky[a] * sky[a]; /* the same hue, deeper */
    f->sky_haze[a] = 0.55f * sky[a] + 0.45f * grey;
    f->ground_colour[a] = p->ground_colour[a];
    f->water[a] = p->water_colour[a];
  }
  f->ground_colour[3] = p->ground_sand ? 1 : 0;

  r->cascade_count = 0;
  if (!p->shadows_off && (r->stone_count > 0 || r->free_mesh.index_count > 0)) {
    render_cascade_desc desc = {.size = r->shadows.size, .pixel = f->eye[3], .count = p->draft ? 1 : RENDER_CASCADES};
    memcpy(desc.sun, f->sun, sizeof desc.sun);
    memcpy(desc.eye, f->eye, sizeof desc.eye);
    memcpy(desc.forward, f->forward, sizeof desc.forward);
    memcpy(desc.right, f->right, sizeof desc.right);
    memcpy(desc.up, f->up, sizeof desc.up);
    for (int a = 0; a < 3; ++a) {
      desc.casters_min[a] = r->stone_count > 0 ? r->stones_min[a] : INFINITY;
      desc.casters_max[a] = r->stone_count > 0 ? r->stones_max[a] : -INFINITY;
    }
    const float* more[2][2] = {{r->terrain.min, r->terrain.max}, {r->free_mesh.min, r->free_mesh.max}};
    for (int i = 0; i < 2; ++i) {
      if ((i == 0 ? r->terrain.index_count : r->free_mesh.index_count) == 0) continue;
      for (int a = 0; a < 3; ++a) {
        desc.casters_min[a] = fminf(desc.casters_min[a], more[i][0][a]);
        desc.casters_max[a] = fmaxf(desc.casters_max[a], more[i][1][a]);
      }
    }
    r->cascade_count = render_fit_cascades(&desc, r->cascades);
  }
  f->mode[2] = (int32_t)r->cascade_count;
  for (uint32_t c = 0; c < r->cascade_count; ++c) {
    const render_cascade* cascade = &r->cascades[c];
    float* m = f->shadow_from_world[c];
    render_cascade_clip(cascade, m);
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column) m[4 * column + row] = 0.5f * m[4 * column + row] + (column == 3 ? 0.5f : 0);
    f->cascade[c][0] = cascade->texel;
    f->cascade[c][1] = cascade->max[2] - cascade->min[2];
  }
}

static render_view camera_view(const render* r, const render_picture* p) {
  const frame_block* f = &r->frame;
  render_view view = {.plane_count = 5,
                      .pixel = f->eye[3],
                      .pixel_error = (p->pixel_error > 0 ? p->pixel_error : PIXEL_ERROR) * (p->draft ? 3 : 1),
                      .lod = p->lod,
                      .tags = KIND_STONE,
                      .model_tags = KIND_MODEL};
  memcpy(view.eye, f->eye, sizeof view.eye);
  for (int i = 0; i < 5; ++i) {
    const float* side = i < 2 ? f->right : f->up;
    float sign = i & 1 ? 1.0f : -1.0f;
    float normal[3];
    /* A side plane holds the eye and leans inwards: normal = forward * |side|^2 / |side| -+ side / |side|, made unit. */
    float tangent = sqrtf(dot3(side, side)), scale = 1 / sqrtf(1 + tangent * tangent);
    for (int a = 0; a < 3; ++a) normal[a] = i == 4 ? f->forward[a] : (f->forward[a] * tangent - sign * side[a] / tangent) * scale;
    memcpy(view.planes[i], normal, sizeof normal);
    view.planes[i][3] = -dot3(normal, f->eye) - (i == 4 ? r->near_plane : 0);
  }
  return view;
}

static render_view cascade_view(const render* r, const render_picture* p, uint32_t c) {
  render_view view = {.plane_count = 4,
                      .parallel = true,
                      .pixel = r->cascades[c].texel,
                      .pixel_error = p->draft ? 3 * SHADOW_ERROR : SHADOW_ERROR,
                      .lod = p->lod};
  render_cascade_planes(&r->cascades[c], view.planes);
  return view;
}

/* Chooses, decodes, groups and uploads. */
static scree_result prepare_stones(render* r, const render_picture* p) {
  render_view views[RENDER_CASCADES + 1];
  render_list* lists[RENDER_CASCADES + 1] = {&r->view_list, &r->cascade_lists[0], &r->cascade_lists[1], &r->cascade_lists[2]};
  const uint32_t count = 1 + r->cascade_count;
  views[0] = camera_view(r, p);
  for (uint32_t c = 0; c < r->cascade_count; ++c) views[c + 1] = cascade_view(r, p, c);
  render_cache_trim(&r->cache);
  for (uint32_t i = 0; i < count; ++i)
    if (!render_list_choose(lists[i], &views[i], &r->cache, r->stones, r->stone_count, r->levels)) return SCREE_ERROR_OUT_OF_MEMORY;
  r->stats.meshes_missing = render_cache_decode(&r->cache, p->decode_budget);
  r->stats.meshes_decoded = r->cache.decoded;
  uint32_t instances = 0, commands = 0;
  for (uint32_t i = 0; i < count; ++i) {
    if (!render_list_build(lists[i], &views[i], &r->cache, r->stones, instances)) return SCREE_ERROR_OUT_OF_MEMORY;
    instances += lists[i]->instance_count;
    commands += lists[i]->command_count;
  }

  glBindBuffer(GL_ARRAY_BUFFER, r->instance_buffer);
  glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)((instances + 1) * sizeof(render_instance)), NULL, GL_STREAM_DRAW);
  if (r->indirect) {
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, r->command_buffer);
    glBufferData(GL_DRAW_INDIRECT_BUFFER, (GLsizeiptr)((commands + 1) * sizeof(render_command)), NULL, GL_STREAM_DRAW);
  }
  r->stats.shadow_triangles = 0;
  for (uint32_t i = 0, instance = 0, command = 0; i < count; ++i) {
    const render_list* list = lists[i];
    glBufferSubData(GL_ARRAY_BUFFER, (GLintptr)(instance * sizeof(render_instance)),
                    (GLsizeiptr)(list->instance_count * sizeof(render_instance)), list->instances);
    if (r->indirect)
      glBufferSubData(GL_DRAW_INDIRECT_BUFFER, (GLintptr)(command * sizeof(render_command)),
                      (GLsizeiptr)(list->command_count * sizeof(render_command)), list->commands);
    instance += list->instance_count;
    command += list->command_count;
    if (i > 0) r->stats.shadow_triangles += list->triangles;
  }
  r->stats.stones = r->stone_count;
  r->stats.stones_drawn = r->view_list.instance_count;
  r->stats.draws = r->view_list.command_count;
  r->stats.triangles = r->view_list.triangles;
  r->stats.meshes = render_cache_mesh_count(&r->cache);
  r->stats.mesh_bytes = render_cache_bytes(&r->cache);
  return SCREE_OK;
}

/* --- Drawing --- */

/* Stones and models have programs of their own. */
static void use_program_of(const render* r, render_look look, uint32_t extra_tags) {
  if (look == RENDER_LOOK_STONE) {
    glUseProgram(r->programs.stone);
    glUniform1ui(r->programs.stone_extra_tags, extra_tags);
    return;
  }
  glUseProgram(r->programs.model);
  glUniform1ui(r->programs.model_extra_tags, extra_tags);
  glUniform1i(r->programs.model_look, (int)look);
}

/* first_command: where this list's commands begin in the command buffer. extra_tags: CASTERS keeps the program that is in use. */
static void draw_list(render* r, const render_list* list, uint32_t first_command, uint32_t extra_tags) {
  for (uint32_t s = 0; s < list->span_count; ++s) {
    const render_span* span = &list->spans[s];
    const render_meshes* meshes = &r->cache.sources[span->source].meshes;
    if (extra_tags != CASTERS) use_program_of(r, r->cache.sources[span->source].source.look, extra_tags);
    glBindVertexArray(meshes->vertex_array);
    if (r->indirect) {
      glBindBuffer(GL_DRAW_INDIRECT_BUFFER, r->command_buffer);
      glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_SHORT,
                                  buffer_offset((first_command + span->first_command) * sizeof(render_command)),
                                  (GLsizei)span->command_count, sizeof(render_command));
      continue;
    }
    for (uint32_t i = 0; i < span->command_count; ++i) {
      const render_command* command = &list->commands[span->first_command + i];
      render_meshes_point_at(r->instance_buffer, command->base_instance);
      glDrawElementsInstancedBaseVertex(GL_TRIANGLES, (GLsizei)command->index_count, GL_UNSIGNED_SHORT,
                                        buffer_offset(command->first_index * sizeof(uint16_t)), (GLsizei)command->instance_count,
                                        command->base_vertex);
    }
    render_meshes_point_at(r->instance_buffer, 0);
  }
  glBindVertexArray(0);
}

static void draw_free_mesh(const render* r, uint32_t extra_tags) {
  if (r->free_mesh.index_count == 0) return;
  use_program_of(r, r->free_mesh.look, extra_tags);
  render_free_draw(&r->free_mesh, KIND_MODEL | render_pack_size(1) << 16);
}

static void draw_shadows(render* r) {
  glBindFramebuffer(GL_FRAMEBUFFER, r->shadows.frame);
  glViewport(0, 0, (GLsizei)r->shadows.size, (GLsizei)r->shadows.size);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glUseProgram(r->programs.caster);
  glVertexAttrib4f(3, 0, 0, 0, 1); /* the place and turn of what has no instances */
  glVertexAttrib2f(5, 0, 1);
  uint32_t first_command = r->view_list.command_count;
  for (uint32_t c = 0; c < r->cascade_count; ++c) {
    glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, r->shadows.texture, 0, (GLint)c);
    glClear(GL_DEPTH_BUFFER_BIT);
    float clip[16];
    render_cascade_clip(&r->cascades[c], clip);
    glUniformMatrix4fv(r->programs.caster_clip, 1, GL_FALSE, clip);
    draw_list(r, &r->cascade_lists[c], first_command, CASTERS);
    render_solid_draw(&r->terrain);
    render_free_draw(&r->free_mesh, 0);
    first_command += r->cascade_lists[c].command_count;
  }
}

static float radical_inverse(uint32_t index, uint32_t base) {
  float result = 0, scale = 1;
  for (; index > 0; index /= base) {
    scale /= (float)base;
    result += scale * (float)(index % base);
  }
  return result;
}

/* Where in a pixel's neighbourhood a sample looks: a tent of two pixels' width, which keeps edges soft without blur. */
static float tent(float u) {
  return u < 0.5f ? sqrtf(2 * u) - 1 : 1 - sqrtf(2 - 2 * u);
}

static void begin_sample(render* r, const render_picture* p, uint32_t sample, uint32_t samples_most) {
  frame_block* f = &r->frame;
  float x = 0, y = 0;
  if (samples_most > 1) {
    x = tent(radical_inverse(sample + 1, 2)) * 0.85f;
    y = tent(radical_inverse(sample + 1, 3)) * 0.85f;
  }
  f->jitter[0] = 2 * x / (float)p->width;
  f->jitter[1] = 2 * y / (float)p->height;
  f->jitter[2] = fmodf((float)sample * 0.75487767f, 1.0f); /* powers of the plastic number: Roberts' sequence */
  f->jitter[3] = fmodf((float)sample * 0.56984029f, 1.0f);
  f->mode[1] = (int32_t)sample;
  uint32_t slices = samples_most >= 8 ? 1 : samples_most >= 3 ? 2 : 4;
  f->occlusion[2] = (float)slices;

  /* clip = projection * view, with x and y scaled by the tangents and moved by the jitter times w. */
  const float n = r->near_plane, w = r->far_plane;
  float tangent_x = sqrtf(dot3(f->right, f->right)), tangent_y = sqrtf(dot3(f->up, f->up));
  float rows[4][4] = {{0}};
  for (int a = 0; a < 3; ++a) {
    rows[0][a] = f->right[a] / (tangent_x * tangent_x) + f->jitter[0] * f->forward[a];
    rows[1][a] = f->up[a] / (tangent_y * tangent_y) + f->jitter[1] * f->forward[a];
    rows[2][a] = f->forward[a] * (w + n) / (w - n);
    rows[3][a] = f->forward[a];
  }
  for (int row = 0; row < 4; ++row) rows[row][3] = -dot3(rows[row], f->eye) - (row == 2 ? 2 * w * n / (w - n) : 0);
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) f->clip_from_world[4 * column + row] = rows[row][column];
  glBindBuffer(GL_UNIFORM_BUFFER, r->frame_buffer);
  glBufferSubData(GL_UNIFORM_BUFFER, 0, sizeof *f, f);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, r->frame_buffer);
}

static void draw_surfaces(render* r, const render_picture* p) {
  static const GLfloat zeroes[4] = {0, 0, 0, 0};
  static const GLuint no_tags[4] = {0, 0, 0, 0};
  static const GLfloat farthest = 1;
  glBindFramebuffer(GL_FRAMEBUFFER, r->targets.surface_frame);
  glViewport(0, 0, (GLsizei)p->width, (GLsizei)p->height);
  glDisable(GL_BLEND);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glClearBufferfv(GL_COLOR, 0, zeroes);
  glClearBufferuiv(GL_COLOR, 1, no_tags);
  glClearBufferfv(GL_COLOR, 2, zeroes);
  glClearBufferfv(GL_DEPTH, 0, &farthest);
  bind_texture(RENDER_UNIT_NOISE, GL_TEXTURE_3D, r->noise);
  draw_list(r, &r->view_list, 0, 0);
  draw_free_mesh(r, 0);
  glUseProgram(r->programs.solid);
  glUniform1ui(r->programs.solid_extra_tags, 0);
  glUniform1ui(r->programs.solid_tags, KIND_TERRAIN);
  render_solid_draw(&r->terrain);
  if (p->ground) {
    glUniform1ui(r->programs.solid_tags, p->water ? KIND_WATER : KIND_GROUND);
    render_solid_draw(&r->ground);
  }
  if (p->wireframe) {
    glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
    glEnable(GL_POLYGON_OFFSET_LINE);
    glPolygonOffset(-1, -2);
    draw_list(r, &r->view_list, 0, TAG_WIRE);
    draw_free_mesh(r, TAG_WIRE);
    glDisable(GL_POLYGON_OFFSET_LINE);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  }
}

static void draw_fullscreen(render* r, uint32_t program) {
  glUseProgram(program);
  glBindVertexArray(r->empty_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindVertexArray(0);
}

static void draw_sample(render* r, const render_picture* p, uint32_t sample, uint32_t samples_most) {
  begin_sample(r, p, sample, samples_most);
  draw_surfaces(r, p);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  bind_texture(RENDER_UNIT_SURFACE, GL_TEXTURE_2D, r->targets.surface);
  bind_texture(RENDER_UNIT_TAGS, GL_TEXTURE_2D, r->targets.tags);
  bind_texture(RENDER_UNIT_DEPTH, GL_TEXTURE_2D, r->targets.depth);
  glBindFramebuffer(GL_FRAMEBUFFER, r->targets.occlusion_frame);
  draw_fullscreen(r, r->programs.occlusion);

  bind_texture(RENDER_UNIT_OCCLUSION, GL_TEXTURE_2D, r->targets.occlusion);
  bind_texture(RENDER_UNIT_NOISE, GL_TEXTURE_3D, r->noise);
  bind_texture(RENDER_UNIT_DETAIL, GL_TEXTURE_2D, r->detail);
  bind_texture(RENDER_UNIT_SHADOW_DEPTH, GL_TEXTURE_2D_ARRAY, r->shadows.texture);
  bind_texture(RENDER_UNIT_SHADOW_COMPARE, GL_TEXTURE_2D_ARRAY, r->shadows.texture);
  glBindSampler(RENDER_UNIT_SHADOW_DEPTH, r->shadows.plain_sampler);
  glBindSampler(RENDER_UNIT_SHADOW_COMPARE, r->shadows.compare_sampler);
  glBindFramebuffer(GL_FRAMEBUFFER, r->targets.sum_frame);
  if (sample == 0) {
    static const GLfloat zeroes[4] = {0, 0, 0, 0};
    glClearBufferfv(GL_COLOR, 0, zeroes);
  }
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  draw_fullscreen(r, r->programs.light);
  glDisable(GL_BLEND);
  glBindSampler(RENDER_UNIT_SHADOW_DEPTH, 0);
  glBindSampler(RENDER_UNIT_SHADOW_COMPARE, 0);
}

static void draw_segments(render* r, const render_picture* p) {
  if (p->segment_count == 0) return;
  glBindBuffer(GL_ARRAY_BUFFER, r->segment_buffer);
  glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(p->segment_count * sizeof *p->segments), p->segments, GL_STREAM_DRAW);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_FALSE);
  glUseProgram(r->programs.line);
  glUniform1f(r->programs.line_half_width, 1.9f);
  glBindVertexArray(r->segment_array);
  for (int hidden = 0; hidden < 2; ++hidden) {
    glDepthFunc(hidden ? GL_GREATER : GL_LEQUAL);
    glUniform1f(r->programs.line_opacity, hidden ? 0.4f : 0.95f);
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, (GLsizei)p->segment_count);
  }
  glBindVertexArray(0);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
}

/* Does a picture show the same as what the sum holds, so that its samples can go on top? */
static bool same_picture(const render_picture* a, const render_picture* b) {
  return a->width == b->width && a->height == b->height && memcmp(a->eye, b->eye, sizeof a->eye) == 0 &&
         memcmp(a->forward, b->forward, sizeof a->forward) == 0 && memcmp(a->up, b->up, sizeof a->up) == 0 &&
         a->field_of_view == b->field_of_view && a->colour == b->colour && a->lod == b->lod && a->pixel_error == b->pixel_error &&
         a->wireframe == b->wireframe && a->shadows_off == b->shadows_off && a->draft == b->draft &&
         memcmp(a->sun, b->sun, sizeof a->sun) == 0 && memcmp(a->sun_colour, b->sun_colour, sizeof a->sun_colour) == 0 &&
         memcmp(a->sky, b->sky, sizeof a->sky) == 0 && memcmp(a->ground_colour, b->ground_colour, sizeof a->ground_colour) == 0 &&
         a->ground_sand == b->ground_sand && a->ground == b->ground && a->ground_height == b->ground_height &&
         a->water == b->water && memcmp(a->water_colour, b->water_colour, sizeof a->water_colour) == 0;
}

scree_result render_draw(render* r, const render_picture* picture) {
  const render_picture* p = picture;
  if (p->width < 1 || p->width > 16384 || p->height < 1 || p->height > 16384 || p->samples < 1 || p->field_of_view <= 0)
    return SCREE_ERROR_INVALID_ARGUMENT;
  scree_result result = render_targets_resize(&r->targets, p->width, p->height);
  if (result != SCREE_OK) return result;
  const uint32_t samples_most = p->samples_most > p->samples ? p->samples_most : p->samples;

  glDisable(GL_SCISSOR_TEST);
  glDepthFunc(GL_LESS);
  bool again = r->stats.meshes_missing > 0 || !same_picture(&r->last, p);
  if (again) {
    r->samples = 0;
    prepare_camera(r, p);
    prepare_sun(r, p);
    if (p->ground) {
      result = render_solid_disc(&r->ground, p->eye, p->ground_height, 0.98f * r->far_plane);
      if (result != SCREE_OK) return result;
    }
    result = prepare_stones(r, p);
    if (result != SCREE_OK) return result;
    glEnable(GL_CULL_FACE);
    draw_shadows(r);
  }
  for (uint32_t i = 0; i < p->samples && r->samples < samples_most; ++i) {
    glEnable(GL_CULL_FACE);
    draw_sample(r, p, r->samples, samples_most);
    ++r->samples;
  }
  r->last = *p;
  r->last.segments = NULL;
  r->stats.samples = r->samples;
  r->stats.indirect = r->indirect;

  glBindFramebuffer(GL_FRAMEBUFFER, r->targets.output_frame);
  glViewport(0, 0, (GLsizei)p->width, (GLsizei)p->height);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  bind_texture(RENDER_UNIT_SUM, GL_TEXTURE_2D, r->targets.sum);
  draw_fullscreen(r, r->programs.resolve);
  draw_segments(r, p);
  glUseProgram(0);
  glActiveTexture(GL_TEXTURE0);
  return SCREE_OK;
}

/* --- What came of it --- */

void render_show(const render* r, uint32_t target, uint32_t width, uint32_t height) {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, r->targets.output_frame);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target);
  bool same = width == r->targets.width && height == r->targets.height;
  glBlitFramebuffer(0, 0, (GLint)r->targets.width, (GLint)r->targets.height, 0, 0, (GLint)width, (GLint)height, GL_COLOR_BUFFER_BIT,
                    same ? GL_NEAREST : GL_LINEAR);
  glBindFramebuffer(GL_FRAMEBUFFER, target);
}

void render_read(const render* r, uint8_t* rgb) {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, r->targets.output_frame);
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  const size_t row = (size_t)3 * r->targets.width;
  for (uint32_t y = 0; y < r->targets.height; ++y)
    glReadPixels(0, (GLint)(r->targets.height - 1 - y), (GLsizei)r->targets.width, 1, GL_RGB, GL_UNSIGNED_BYTE, rgb + y * row);
}

bool render_pick(const render* r, uint32_t x, uint32_t y, uint32_t* stone, float point[3]) {
  *stone = RENDER_NOTHING;
  if (x >= r->targets.width || y >= r->targets.height) return false;
  const uint32_t row = r->targets.height - 1 - y;
  GLuint tags[4] = {0};
  GLfloat depth = 0;
  glBindFramebuffer(GL_READ_FRAMEBUFFER, r->targets.surface_frame);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadBuffer(GL_COLOR_ATTACHMENT1);
  glReadPixels((GLint)x, (GLint)row, 1, 1, GL_RGBA_INTEGER, GL_UNSIGNED_INT, tags);
  glReadBuffer(GL_COLOR_ATTACHMENT2);
  glReadPixels((GLint)x, (GLint)row, 1, 1, GL_RED, GL_FLOAT, &depth);
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  if (depth <= 0) return false;
  const frame_block* f = &r->frame;
  float clip_x = ((float)x + 0.5f) * f->size[2] * 2 - 1 - f->jitter[0],
        clip_y = ((float)row + 0.5f) * f->size[3] * 2 - 1 - f->jitter[1];
  for (int a = 0; a < 3; ++a) point[a] = f->eye[a] + depth * (f->forward[a] + clip_x * f->right[a] + clip_y * f->up[a]);
  if (tags[2] > 0) *stone = tags[2] - 1;
  return true;
}

void render_get_stats(const render* r, render_stats* out) {
  *out = r->stats;
}
