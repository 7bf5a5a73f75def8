/* A scene opened: packs, fields, supports and the scree_scene that they are the layers of. Programs that show, export and measure a
 * scene all come through here, so that they mean the same rocks. Not thread-safe. */
#ifndef SCENE_LIVE_H
#define SCENE_LIVE_H

#include <scree/scene.h>

#include "scene_models.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct scene_live scene_live;

/* What of a field has changed. */
enum {
  SCENE_CHANGED_PACK = 1u << 0,    /* pack, seed, cell size or origin; all that only a scatter has */
  SCENE_CHANGED_SUPPORT = 1u << 1, /* any node */
  SCENE_CHANGED_RULES = 1u << 2,   /* threshold, shell, key, density or filters */
  SCENE_CHANGED_PALETTE = 1u << 3, /* colours: nothing of this file */
  SCENE_CHANGED_ALL = 15u
};

typedef struct scene_live_desc {
  const scene_model* scene; /* must outlive the world; read on every update */
  scene_paths paths;        /* strings likewise */
  scree_jobs jobs;
  /* Told of packs, or models from files (the other is NULL), that fields come to share and leave; either may be NULL.
   * slot: 0..SCENE_FIELDS_MAX. What pack_opened returns, unless SCREE_OK, is why the field cannot be had. */
  scree_result (*pack_opened)(void* user, uint32_t slot, const scree_pack* pack, const scene_models* models);
  void (*pack_closing)(void* user, uint32_t slot);
  void* user;
} scene_live_desc;

/* A world without fields. Returns SCREE_OK or OUT_OF_MEMORY. */
scree_result scene_live_create(const scene_live_desc* desc, scene_live** out, scree_error* error);
void scene_live_destroy(scene_live* w);

/* Brings field `index` up to date with the scene; error: one line with the file and the key. On failure the field stays as it was.
 * A support without end is an error: the programs ask for whole fields. */
scree_result scene_live_update(scene_live* w, uint32_t index, uint32_t changed, scree_error* error);

/* Forgets all fields and opens those of the scene. The first that fails gives the error; the others are there. */
scree_result scene_live_update_all(scene_live* w, scree_error* error);

/* The layers; NULL as long as there is no field. Valid until the next update. */
const scree_scene* scene_live_scene(const scene_live* w);
/* The index of a field's layer, UINT32_MAX if it could not be opened. */
uint32_t scene_live_layer(const scene_live* w, uint32_t index);
const scree_field* scene_live_field(const scene_live* w, uint32_t index);     /* NULL as above, and of a scatter */
const scree_scatter* scene_live_scatter(const scene_live* w, uint32_t index); /* NULL as above, and of rocks */
const scree_support* scene_live_support(const scene_live* w, uint32_t index);
const scree_pack* scene_live_pack(const scene_live* w, uint32_t index);     /* NULL as above, and of models from files */
const scene_models* scene_live_models(const scene_live* w, uint32_t index); /* of files, or NULL */
uint32_t scene_live_pack_slot(const scene_live* w, uint32_t index);
scene_files* scene_live_files(scene_live* w);

/* How far a rock of the field can reach from its home cell's centre, metres. */
double scene_live_reach(const scene_live* w, uint32_t index);

/* Rocks of a query, kept so that the next one need not allocate. All zero = empty. */
typedef struct scene_rocks {
  scree_rock* rocks; /* owned, malloc */
  uint64_t count, capacity;
} scene_rocks;
void scene_rocks_free(scene_rocks* rocks);

/* The rocks of one field, by the rules of the whole scene: where fields overlap, the earlier wins.
 * origin: what positions are relative to. flags: SCREE_SCENE_... most: more rocks are an error, found without counting them all.
 * Returns SCREE_OK, RANGE (too many), OUT_OF_MEMORY, INVALID_ARGUMENT (there is no such field), with a line for people. */
scree_result scene_live_query(scene_live* w, uint32_t index, const double origin[3], uint32_t flags, uint64_t most,
                              scene_rocks* out, scree_error* error);

#ifdef __cplusplus
}
#endif

#endif
