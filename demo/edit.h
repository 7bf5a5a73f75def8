/* Editing a scene: what is selected, what has changed, dragging, undo. No window and no OpenGL, so that tests can drive it. */
#ifndef EDIT_H
#define EDIT_H

#include "cliff_parts.h"
#include "scene.h"

#ifdef __cplusplus
extern "C" {
#endif

#define EDIT_HISTORY 100

/* From a node's own space to the world's: scale, then rotate, then move. */
typedef struct edit_frame {
  double translation[3]; /* metres */
  double rotation[4];    /* unit quaternion x, y, z, w */
  double scale;
} edit_frame;

typedef enum edit_drag_kind {
  EDIT_DRAG_NONE,
  EDIT_DRAG_GROUND,   /* over the horizontal plane through the point that was grabbed */
  EDIT_DRAG_VERTICAL, /* up and down */
  EDIT_DRAG_X,
  EDIT_DRAG_Y,
  EDIT_DRAG_Z,    /* along an axis of the world */
  EDIT_DRAG_SCALE /* larger as the pointer goes up */
} edit_drag_kind;

typedef struct editor {
  scene_model* scene;
  uint32_t field;   /* selected */
  scene_node* node; /* selected, in that field's support, or NULL */

  /* What the caller has to bring up to date; it clears them when done. */
  uint32_t changed[SCENE_FIELDS_MAX]; /* SCENE_CHANGED_... of each field */
  bool changed_fields;                /* fields came or went, or anything may have changed */
  bool changed_ground;                /* the terrain's mesh */
  bool unsaved;

  edit_drag_kind drag;
  double drag_grabbed[3]; /* world point under the pointer when the drag began */
  double drag_position[3], drag_scale, drag_height;

  cliff_parts cliff; /* that edit_cliff_time moves until the step ends; empty otherwise */

  char* history[EDIT_HISTORY]; /* scenes as text, owned; the one at `now` is the scene as it was last committed */
  uint32_t history_count, history_now;
} editor;

/* Begins with nothing selected and the scene as the first state of history. */
void edit_begin(editor* e, scene_model* scene);
void edit_end(editor* e);

/* A step that undo can take back ends here: call it when a key or a button is let go. Does nothing when nothing changed. */
void edit_commit(editor* e);
/* Return false when there is nothing to take back or to do again. */
bool edit_undo(editor* e);
bool edit_redo(editor* e);

/* The frame of `node` within the tree `root` (NULL root or a node that is not in it: false), and its parent's, either may be NULL.
 */
bool edit_node_frame(const scene_node* root, const scene_node* node, edit_frame* own, edit_frame* parent);
void edit_frame_point(const edit_frame* frame, const double local[3], double world[3]);

/* Box of a leaf in its own space; false for groups and for shapes from files, whose size the scene does not hold. */
bool edit_leaf_box(const scene_node* node, double min[3], double max[3]);

/* The leaf of a field that a stone at a world point belongs to: the one whose surface is nearest, for what is seen of a support are
 * the stones at its surface. NULL without leaves. */
scene_node* edit_leaf_at(const scene_model* scene, uint32_t field, const double point[3]);

/* Adds a support of this kind to the selected field and selects it. `place`: where it stands, world; `size`: its radius or half its
 * side, metres. A root that is not a union becomes the first child of one. A pattern comes in an intersection that cuts it to size.
 * Returns false when memory is short, there is no field, or the kind has children or no end (HALF_SPACE): see edit_wrap. */
bool edit_add(editor* e, scree_shape_kind kind, const double place[3], double size);
/* Puts the selected node into noise (NOISE), or cuts off what lies below its place (HALF_SPACE: a difference with one, which is
 * then selected). Returns false when memory is short or nothing is selected. */
bool edit_wrap(editor* e, scree_shape_kind kind);
/* Removes the selected node. The last one of a field cannot go: returns false. */
bool edit_delete(editor* e);
/* Copies the selected node beside itself, with the noise that it is in, and selects the copy. */
bool edit_duplicate(editor* e);

/* `eye` and `direction` (not unit) are the ray under the pointer, world; `grabbed` the point that it hit; `height` the pointer's
 * height on the screen, 0 bottom to 1 top. Needs a selected node. */
void edit_drag_begin(editor* e, edit_drag_kind kind, const double grabbed[3], double height);
/* For a drag along an axis: makes the point of the axis nearest to the ray the one that was grabbed. */
void edit_drag_grab(editor* e, const double eye[3], const double direction[3]);
/* Moves or scales the selected node. Returns whether anything changed. */
bool edit_drag_to(editor* e, const double eye[3], const double direction[3], double height);
void edit_drag_end(editor* e);

/* Moves the cliff that the selected field shows to another time, below 255, with all of its parts. Which these are is found once a
 * step: a slider that is drawn over the time of other parts at the same place takes them not along. Returns whether anything
 * changed. */
bool edit_cliff_time(editor* e, uint32_t time);

/* Notes that the support of the selected field has changed. */
void edit_touch(editor* e, uint32_t what);

#ifdef __cplusplus
}
#endif

#endif
