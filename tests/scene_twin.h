/* The plain twin of scenes: every rock of every cell, every pair of rocks, every neighbour, one after the other. */
#ifndef SCENE_TWIN_H
#define SCENE_TWIN_H

#include "query_twin.h"
#include "scatter_twin.h"
#include "scene_layers.h"

typedef struct twin_edit {
  scree_id id;
  scree_edit edit;
} twin_edit;

typedef struct twin_rock {
  scree_rock rock;
  int64_t cell[3];
  double place[3]; /* world: its home cell's centre, or where an instance of a scatter stands */
  uint32_t random; /* of an instance */
  bool dropped;    /* by the rule of overlaps */
  scree_edit edit;
} twin_rock;

/* All rocks of a layer that its support, shell and filters let exist. */
typedef struct twin_layer {
  const scree_layer* given;
  const field_source* source;       /* of a field */
  const scree_scatter_desc* models; /* of a scatter */
  int64_t low[3], high[3];          /* cells that were looked at */
  twin_rock* rocks;
  uint64_t count;
  uint8_t* full; /* of each cell: whether all its rocks exist, edits included */
} twin_layer;

typedef struct scene_twin {
  twin_layer layers[SCENE_MAX_LAYERS];
  uint32_t count;
} scene_twin;

/* Looks at everything within `reach` metres of `middle` along each axis. sources: what fields were made of; scatters: what scatters
 * were made of, NULL where there are none. */
scene_twin twin_scene(const scree_scene_desc* desc, const field_source* const* sources, const scree_scatter_desc* const* scatters,
                      const twin_edit* edits, uint32_t edit_count, const double middle[3], double reach, const double origin[3]);

/* The hull of a part of a rock relative to a world point; false when there is no such part. xyz: x, y and z of 64 points. */
bool twin_hull(const twin_layer* layer, const twin_rock* rock, uint32_t part, const double from[3], float xyz[3][64],
               convex_hull* hull);
void twin_scene_free(scene_twin* twin);

typedef struct scene_rocks {
  scree_rock* rocks; /* sorted by layer key and id */
  uint64_t count;
} scene_rocks;

/* What a query should deliver. */
scene_rocks twin_answer(const scene_twin* twin, const scree_scene_query_desc* desc);

/* What it does deliver; fails the test where count and fill do not agree. */
scene_rocks ask_scene(const scree_scene_query_desc* desc, scree_scratch* scratch);

void scene_rocks_free(scene_rocks* rocks);
void scene_rocks_sort(scene_rocks* rocks);
void scene_rocks_join(scene_rocks* a, const scree_rock* rocks, uint64_t count);

/* Fails the test when the two differ in any byte. */
void assert_scene_rocks_equal(const scene_rocks* expected, const scene_rocks* found);

/* How many rocks of b are not in a; for messages. */
uint64_t scene_rocks_missing(const scene_rocks* a, const scene_rocks* b);

#endif
