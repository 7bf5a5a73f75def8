/* Random scenes for property tests: fields on random tables, random supports, filters and edits. */
#ifndef RANDOM_WORLD_H
#define RANDOM_WORLD_H

#include "random_support.h"
#include "scene_twin.h"

enum { MAX_LAYERS = 4, IMAGE = 12, MAX_EDITS = 400 };

/* A random scene and everything it points at. */
typedef struct world {
  uint32_t count;
  synthetic_source sources[MAX_LAYERS];
  const field_source* source_of[MAX_LAYERS];
  random_scatter* scatters[MAX_LAYERS]; /* NULL: a layer of rocks */
  const scree_scatter_desc* scatter_of[MAX_LAYERS];
  scree_field* fields[MAX_LAYERS];
  random_support* shapes[MAX_LAYERS];
  scree_support* supports[MAX_LAYERS];
  scree_filter filters[MAX_LAYERS][3];
  float images[MAX_LAYERS][2][IMAGE * IMAGE];
  scree_layer layers[MAX_LAYERS];
  scree_scene_desc desc;
  scree_scene* scene;
  scree_edits* edits;
  twin_edit edit_list[MAX_EDITS];
  uint32_t edit_count;
  double middle[3];
} world;

scree_scratch* make_scratch(void);

/* Layers of any kind that overlap, with all rules. */
void make_world(world* w, random_stream* r, uint32_t layers);

/* A thick mass with or without a hollow, of which next to nothing is visible; beside it, sometimes, a smaller one, earlier or
 * later. */
void make_thick_world(world* w, random_stream* r);

/* Layers in one ball, each denser than the one before: most rocks have neighbours of an earlier layer, and many just miss them. */
void make_mixed_world(world* w, random_stream* r, uint32_t layers);

/* Layers in and on rolling ground, rocks and scatters in turn or at random. */
void make_scatter_world(world* w, random_stream* r, uint32_t layers);

void destroy_world(world* w);

void add_edit(world* w, const scree_id* id, scree_edit edit);

/* Removes and hides some rocks, alone and in bunches. */
void make_edits(world* w, random_stream* r, const scene_rocks* rocks);

/* Any layers, origin and box within 9 metres of the middle, or everywhere where the supports end within 16. */
scree_scene_query_desc random_question(const world* w, random_stream* r);

#endif
