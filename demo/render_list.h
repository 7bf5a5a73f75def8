/* From stones to draw calls: which of them a view sees, at which level of detail, grouped by mesh. */
#ifndef RENDER_LIST_H
#define RENDER_LIST_H

#include "render.h"
#include "render_cache.h"

/* As the vertex shaders read it. 40 bytes. */
typedef struct render_instance {
  float place[4];   /* metres; metres per lattice step */
  float turn[2];    /* sine and cosine */
  uint32_t tags[4]; /* hash; level, kind and cell size (see frame.glsl); row of the stone + 1; colour and tile code */
} render_instance;

/* As glMultiDrawElementsIndirect reads it. 20 bytes. */
typedef struct render_command {
  uint32_t index_count, instance_count, first_index;
  int32_t base_vertex;
  uint32_t base_instance;
} render_command;

typedef struct render_span {
  uint32_t source, first_command, command_count;
} render_span;

/* What is looked at and how closely. A stone is out when its ball lies wholly on the negative side of a plane. */
typedef struct render_view {
  float planes[6][4]; /* unit normal into the view, and distance */
  uint32_t plane_count;
  bool parallel;       /* a shadow cascade: sizes do not shrink with distance */
  float eye[3];        /* not for parallel views */
  float pixel;         /* metres across a pixel: at distance 1, or everywhere for a parallel view */
  float pixel_error;   /* pixels that an outline may be off */
  int32_t lod;         /* >= 0: this level for every stone */
  uint32_t tags;       /* or'ed into the tags of every stone, cliffs included */
  uint32_t model_tags; /* the same of every model */
} render_view;

typedef struct render_list {
  render_instance* instances;
  render_command* commands;
  render_span spans[RENDER_SOURCES];
  uint32_t instance_count, command_count, span_count;
  uint64_t triangles;
  float error;                    /* metres: largest error of the levels in the list */
  struct render_pick_item* picks; /* working memory */
  uint32_t* counts;
  uint32_t pick_capacity, instance_capacity, command_capacity, count_capacity;
} render_list;

/* The level a view needs for a stone of this asset whose centre is `distance` away. */
uint32_t render_choose_lod(const render_view* view, const render_asset* asset, uint32_t lod_count, float cell_size, float distance);

/* The middle of the ball that holds a stone. */
void render_stone_centre(const render_stone* stone, const render_asset* asset, float centre[3]);

/* A length as frame.glsl's tag_size reads it: 16 bits of its logarithm, true to 0.04 %. */
uint32_t render_pack_size(float metres);

#define RENDER_UNSEEN 255

/* Chooses stones and levels, and notes absent meshes with the cache as wanted. Returns false when memory is short.
 * levels: `count` elements. The camera's view fills it (RENDER_UNSEEN where a stone is out); a parallel view takes from it: a stone
 * casts the shadow of the mesh that it is seen as, or the two would lie in and out of each other and speckle. */
bool render_list_choose(render_list* list, const render_view* view, render_cache* cache, const render_stone* stones, uint32_t count,
                        uint8_t* levels);

/* Fills instances, commands and spans with what is there, after the cache had its chance to decode. Base instances start at
 * first_instance. */
bool render_list_build(render_list* list, const render_view* view, render_cache* cache, const render_stone* stones,
                       uint32_t first_instance);

void render_list_destroy(render_list* list);

#endif
