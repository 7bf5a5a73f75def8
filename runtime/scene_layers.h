/* A scene, as the files that answer questions about it see it. */
#ifndef SCREE_SCENE_LAYERS_H
#define SCREE_SCENE_LAYERS_H

#include "edits_internal.h"
#include "query_kernel.h"
#include "scene_internal.h"
#include "scratch.h"

enum { SCENE_MAX_LAYERS = 64, SCENE_MAX_FILTERS = 16 };

typedef struct scene_layer {
  scree_layer told;   /* as it was given, but for the key, which is the one in use, and filters, which are the scene's copies */
  scree_layer given;  /* the same, but the field of a scatter is its lattice */
  double offset[3];   /* the field's origin relative to the scene's base: that of the first layer's field */
  double reach;       /* metres: no part of a rock is farther from the centre of its home cell */
  double rock_radius; /* metres: no outer radius is larger */
  double density;     /* share, filters apart */
  double level_low, level_high; /* rocks exist where the support's distance is at most something between these, metres */
  double lipschitz;             /* of the support */
  double doubt;                 /* metres: what rounding may do to the support's distance, beyond a share of coordinates */
  bool filtered;                /* density or filters leave something out */
  size_t values;                /* copied samples of all its filters */
  float* samples;               /* NULL when there are none */
  scree_filter* filters;        /* given.filters, to be released; NULL when there are none */
} scene_layer;

struct scree_scene {
  scree_allocator allocator;
  uint32_t layer_count;
  double base[3]; /* world: rocks of different layers are compared relative to this point, which nothing but the scene decides */
  scene_layer* layers;
};

/* A rock's home cell, counted from the field's corner (0, 0, 0). */
static inline void rock_cell(const scree_field* field, const scree_id* id, int64_t cell[3]) {
  const uint8_t* place = field->cell_places[field_cell_of(field, id->local)];
  for (int a = 0; a < 3; ++a) cell[a] = (int64_t)id->cube[a] * field->cells_per_cube + place[a];
}

/* The centre of a cell relative to the scene's base. */
static inline void cell_centre(const scene_layer* layer, const int64_t cell[3], double centre[3]) {
  for (int a = 0; a < 3; ++a) centre[a] = layer->offset[a] + layer->given.field->cell_size * (double)cell[a];
}

/* Whether density and filters let a rock of a filtered layer exist. */
bool scree_rt_scene_passes(const scene_layer* layer, const scree_id* id);

/* The same for what stands at a place relative to the field's origin, by a hash of cube and local. planar: filters that need a
 * height are left out; what does not pass then does not pass with them either. */
bool scree_rt_scene_passes_at(const scene_layer* layer, const double at[3], const int32_t cube[3], uint32_t local, bool planar);

/* The share of a mask at a place relative to its centre; what is wrong with a mask that belongs to no layer. */
double scree_rt_filter_mask(const scree_filter* mask, double x, double z);
scree_result scree_rt_scene_check_mask(const scree_filter* mask, scree_error* error);

/* Arc tangent of t >= 0 in degrees, the same on all machines. */
double scree_rt_arc_degrees(double t);

/* Checks filters 0 .. filter_count - 1 of a layer; counts the samples to be copied. */
scree_result scree_rt_scene_check_filters(const scree_layer* layer, uint32_t index, size_t* values, scree_error* error);

/* Rocks of one layer that a question needs. */
typedef struct layer_rocks {
  bool needed, asked;
  int64_t low[3], high[3];                      /* cells in which it is needed */
  int64_t asked_low[3], asked_high[3];          /* cells in which it is asked for */
  uint64_t first, count;                        /* its rocks in the arrays */
  double tight_low[3], tight_high[3];           /* box of the balls round its rocks, relative to the scene's base */
  double region_low[3], region_high[3];         /* union of the tight boxes of later layers that need it */
  bool wanted;                                  /* by a later layer */
  uint64_t kept_first, start_first, ball_first; /* where later layers look it up, cell by cell; see scene_keep.c */
  uint32_t kept_count, cell_count[3];
  double cell_low[3], cell_step, cell_inverse, cell_slack, ball_slack;
} layer_rocks;

/* One question on its way: which rocks of which layers exist, edits apart. */
typedef struct scene_question {
  const scree_scene* scene;
  scree_scratch* scratch;
  double origin[3];
  const scree_edits* edits;        /* or NULL */
  const double *box_min, *box_max; /* world box of the instances of scatters that are asked for; NULL: all of the cells */
  bool visible;                    /* only what can be seen is delivered; then one layer is asked for, not more */
  uint64_t most;                   /* rocks that may be looked at; more are SCREE_ERROR_CAPACITY */
  layer_rocks layers[SCENE_MAX_LAYERS];
  scree_instance* instances; /* of all layers, in the scratch; rocks that are left out are moved out */
  scree_id* ids;
  uint64_t count;
  uint64_t start_count, kept_count, ball_count;
  uint32_t part_count; /* kept parts of scatters */
  cell_grid grid;      /* of the layer that is asked for, where burial is looked at */
} scene_question;

/* Whether anything of a layer can be hidden by its neighbours. */
static inline bool looks_at_burial(const scene_question* q, uint32_t layer) {
  return q->visible && q->layers[layer].asked && q->scene->layers[layer].given.field->deepest_burial > 0;
}

/* What follows from a layer's field and support: offset, reach, levels and so on. */
void scree_rt_scene_measure(scene_layer* layer, const double base[3]);

/* One layer, with its burial where `visible`. Its rocks are q->ids and q->instances from q->layers[layer].first on; those outside
 * of the range may be among them. */
scree_result scree_rt_scene_answer(scene_question* q, const scree_scene* scene, const scree_edits* edits, uint32_t layer,
                                   const int64_t low[3], const int64_t high[3], const double origin[3], bool visible, uint64_t most,
                                   scree_scratch* scratch);

/* scree_scene_fill; with `packed`, assets of scatters are as in questions (scene_scatter.h). */
scree_result scree_rt_scene_fill(const scree_scene_query_desc* desc, bool packed, scree_scratch* scratch, scree_rock* rocks,
                                 uint64_t capacity, uint64_t* count);

/* Whether a layer can have rocks in a range of cells; true when in doubt. */
bool scree_rt_scene_cells_may_hold(const scene_layer* layer, const int64_t low[3], const int64_t high[3]);

/* Asks for a range of cells of a layer; call before scree_rt_scene_gather. */
void scree_rt_scene_ask(scene_question* q, uint32_t layer, const int64_t low[3], const int64_t high[3]);

/* Finds the rocks of all layers that are asked for, and those of earlier layers that they may meet: supports, shells and filters
 * only. */
scree_result scree_rt_scene_gather(scene_question* q);

/* Moves out the rocks of the layer that is asked for that nobody can see. The edits' own rocks may stay. */
scree_result scree_rt_scene_cull(scene_question* q, uint32_t layer);

/* All cells low .. high - 1, none of them full. */
scree_result scree_rt_scene_make_grid(scree_scratch* scratch, const int64_t low[3], const int64_t high[3], cell_grid* grid);

/* In these cells of a layer without filters, shell, edits and earlier layers: rocks that lie deeper than this have all the
 * neighbours that burial looks at. Metres. */
double scree_rt_scene_floor(const scene_layer* layer, const int64_t low[3], const int64_t high[3]);

/* Whether a layer has edits in a range of cells. */
bool scree_rt_scene_edited(const scene_question* q, uint32_t layer, const int64_t low[3], const int64_t high[3]);

/* Drops those that meet a kept rock of an earlier layer. */
scree_result scree_rt_scene_keep(scene_question* q);

#endif
