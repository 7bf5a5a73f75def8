/* A scene brought to life for the viewer: packs opened, fields and supports made, stones queried and handed to the renderer. After
 * an edit only the fields that it touched, and those that make way for them, are queried again. */
#ifndef STAGE_H
#define STAGE_H

#include "camera.h"
#include "render.h"
#include "scene_live.h"

#ifdef __cplusplus
extern "C" {
#endif

#define STAGE_STONES_MOST 4000000u /* of one field; more is a mistake of scale rather than a wish */

typedef struct stage stage;

typedef struct stage_desc {
  render* renderer;         /* must outlive the stage */
  const scene_model* scene; /* likewise; read on every call */
  scene_paths paths;        /* strings likewise */
  scree_jobs jobs;
  uint32_t flags; /* SCREE_SCENE_...; pictures want SCREE_SCENE_VISIBLE */
} stage_desc;

/* Opens and queries everything. Returns SCREE_OK or an error with one line for people. */
scree_result stage_create(const stage_desc* desc, stage** out, scree_error* error);
void stage_destroy(stage* s);

/* Brings fields up to date with the scene, and the later fields that they may meet, whose stones make way for theirs; none is
 * queried twice. changed: SCENE_CHANGED_... of each field. The first that fails gives the error and has no stones; the others
 * are there. */
scree_result stage_update_fields(stage* s, const uint32_t changed[SCENE_FIELDS_MAX], scree_error* error);

/* After fields were added or removed: forgets all of them and queries anew. The first field that fails gives the error; the others
 * are there. */
scree_result stage_update_all(stage* s, scree_error* error);

/* The ground of the scene, plane, terrain or none. */
scree_result stage_update_ground(stage* s, scree_error* error);

/* Hands the stones of all fields to the renderer. */
scree_result stage_show(stage* s);

/* World point that the renderer's space starts from, metres. Fixed when the stage is made. */
void stage_origin(const stage* s, double origin[3]);

/* Box of a field's support in the renderer's space; false when it has none. */
bool stage_field_bounds(const stage* s, uint32_t index, float min[3], float max[3]);
/* Ball round all supports; false when there are none. */
bool stage_ball(const stage* s, float centre[3], float* radius);

/* Stones that are shown: those that nobody can see are left out. */
uint32_t stage_stone_count(const stage* s, uint32_t index);
/* Seconds that the last update of a field took. */
double stage_update_seconds(const stage* s, uint32_t index);

/* The files that supports were read from, for those who draw them. */
scene_files* stage_files(stage* s);
/* Times of a field's cliff; 0 for other fields and those that are not open. */
uint32_t stage_times(const stage* s, uint32_t field);
/* The same for a node that is a mesh of a cliff; 0 for other nodes. */
uint32_t stage_mesh_times(const stage* s, const scene_node* node);

/* A camera of the renderer's space from world points (metres) and a vertical field of view in degrees. */
void stage_camera(const stage* s, const double eye[3], const double target[3], double field_of_view, camera* out);

/* Sun, sky and ground of the scene. */
void stage_light(const stage* s, render_picture* picture);

#ifdef __cplusplus
}
#endif

#endif
