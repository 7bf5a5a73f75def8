#include "edit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene_support.h"
#include "stage.h"

/* --- Frames --- */

static void rotate(const double q[4], const double v[3], double out[3]) {
  /* v + 2 q x (q x v + w v) */
  double t[3] = {q[1] * v[2] - q[2] * v[1] + q[3] * v[0], q[2] * v[0] - q[0] * v[2] + q[3] * v[1],
                 q[0] * v[1] - q[1] * v[0] + q[3] * v[2]};
  double r[3] = {v[0] + 2 * (q[1] * t[2] - q[2] * t[1]), v[1] + 2 * (q[2] * t[0] - q[0] * t[2]),
                 v[2] + 2 * (q[0] * t[1] - q[1] * t[0])};
  memcpy(out, r, sizeof r);
}

void edit_frame_point(const edit_frame* frame, const double local[3], double world[3]) {
  double scaled[3], turned[3];
  for (int a = 0; a < 3; ++a) scaled[a] = local[a] * frame->scale;
  rotate(frame->rotation, scaled, turned);
  for (int a = 0; a < 3; ++a) world[a] = frame->translation[a] + turned[a];
}

static void to_local(const edit_frame* frame, const double world[3], double local[3]) {
  const double back[4] = {-frame->rotation[0], -frame->rotation[1], -frame->rotation[2], frame->rotation[3]};
  double moved[3];
  for (int a = 0; a < 3; ++a) moved[a] = (world[a] - frame->translation[a]) / frame->scale;
  rotate(back, moved, local);
}

static edit_frame within(const edit_frame* parent, const scene_node* node) {
  edit_frame own;
  double q[4];
  const double* p = parent->rotation;
  scene_rotation_quaternion(node->rotation, q);
  edit_frame_point(parent, node->position, own.translation);
  own.rotation[0] = p[3] * q[0] + p[0] * q[3] + p[1] * q[2] - p[2] * q[1];
  own.rotation[1] = p[3] * q[1] - p[0] * q[2] + p[1] * q[3] + p[2] * q[0];
  own.rotation[2] = p[3] * q[2] + p[0] * q[1] - p[1] * q[0] + p[2] * q[3];
  own.rotation[3] = p[3] * q[3] - p[0] * q[0] - p[1] * q[1] - p[2] * q[2];
  own.scale = parent->scale * node->scale;
  return own;
}

static const edit_frame world_frame = {{0, 0, 0}, {0, 0, 0, 1}, 1};

static bool find_frame(const scene_node* at, const edit_frame* above, const scene_node* node, edit_frame* own, edit_frame* parent) {
  edit_frame here = within(above, at);
  if (at == node) {
    if (own != NULL) *own = here;
    if (parent != NULL) *parent = *above;
    return true;
  }
  for (uint32_t i = 0; i < at->child_count; ++i)
    if (find_frame(at->children[i], &here, node, own, parent)) return true;
  return false;
}

bool edit_node_frame(const scene_node* root, const scene_node* node, edit_frame* own, edit_frame* parent) {
  return root != NULL && node != NULL && find_frame(root, &world_frame, node, own, parent);
}

/* --- Leaves --- */

/* Round the points and what their radii add. A curve may swing out a little between its points. */
static bool points_box(const scene_node* node, double min[3], double max[3]) {
  for (uint32_t i = 0; i < node->point_count; ++i)
    for (int a = 0; a < 3; ++a) {
      const scene_point* p = &node->points[i];
      const double reach =
          a == 1 && node->kind == SCREE_SHAPE_TUBE && node->tube.half_height > 0 ? node->tube.half_height : p->radius;
      min[a] = i == 0 ? p->place[a] - reach : fmin(min[a], p->place[a] - reach);
      max[a] = i == 0 ? p->place[a] + reach : fmax(max[a], p->place[a] + reach);
    }
  if (node->kind == SCREE_SHAPE_EXTRUSION) {
    min[1] = node->extrusion.low;
    max[1] = node->extrusion.high;
  }
  return node->point_count > 0;
}

bool edit_leaf_box(const scene_node* node, double min[3], double max[3]) {
  double half[3] = {0, 0, 0};
  switch (node->kind) {
    case SCREE_SHAPE_SPHERE: half[0] = half[1] = half[2] = node->sphere.radius; break;
    case SCREE_SHAPE_BOX: memcpy(half, node->box.half, sizeof half); break;
    case SCREE_SHAPE_CYLINDER:
      half[0] = half[2] = node->cylinder.radius;
      half[1] = node->cylinder.half_height;
      break;
    case SCREE_SHAPE_CONE:
      for (int a = 0; a < 3; ++a) {
        min[a] = a == 1 ? 0 : -node->cone.radius;
        max[a] = a == 1 ? node->cone.height : node->cone.radius;
      }
      return true;
    case SCREE_SHAPE_CAPSULE:
      for (int a = 0; a < 3; ++a) {
        min[a] = fmin(node->capsule.a[a], node->capsule.b[a]) - node->capsule.radius;
        max[a] = fmax(node->capsule.a[a], node->capsule.b[a]) + node->capsule.radius;
      }
      return true;
    case SCREE_SHAPE_ELLIPSOID: memcpy(half, node->ellipsoid.radii, sizeof half); break;
    case SCREE_SHAPE_TORUS:
      half[0] = half[2] = node->torus.radius + node->torus.tube_radius;
      half[1] = node->torus.tube_radius;
      break;
    case SCREE_SHAPE_EXTRUSION:
    case SCREE_SHAPE_TUBE:
    case SCREE_SHAPE_BLOBS: return points_box(node, min, max);
    default: return false;
  }
  for (int a = 0; a < 3; ++a) {
    min[a] = -half[a];
    max[a] = half[a];
  }
  return true;
}

/* How far a point of a leaf's own space is from its surface. Shapes from files: no telling, they are taken where nothing else is
 * near. */
static double leaf_distance(const scene_node* node, const double p[3]) {
  scree_support* alone;
  if (scene_leaf_support(node, &alone) != SCREE_OK) return HUGE_VAL;
  const float x = (float)p[0], y = (float)p[1], z = (float)p[2];
  float distance;
  scree_support_distance(alone, &x, &y, &z, &distance, 1);
  scree_support_destroy(alone);
  return fabs((double)distance);
}

typedef struct leaf_search {
  const double* point;
  const scene_node* best;
  double best_distance; /* metres from its surface */
} leaf_search;

static void search_leaf(leaf_search* s, const scene_node* node, const edit_frame* above) {
  edit_frame here = within(above, node);
  if (scene_kind_has_children(node->kind)) {
    for (uint32_t i = 0; i < node->child_count; ++i) search_leaf(s, node->children[i], &here);
    return;
  }
  double local[3];
  to_local(&here, s->point, local);
  double distance = leaf_distance(node, local) * here.scale;
  if (s->best == NULL || distance < s->best_distance) {
    s->best = node;
    s->best_distance = distance;
  }
}

scene_node* edit_leaf_at(const scene_model* scene, uint32_t field, const double point[3]) {
  if (field >= scene->field_count || scene->fields[field].support == NULL) return NULL;
  leaf_search s = {point, NULL, 0};
  search_leaf(&s, scene->fields[field].support, &world_frame);
  return (scene_node*)(uintptr_t)s.best; /* the scene is the caller's, and so is what it holds */
}

/* --- Changing the tree --- */

static scene_node* parent_of(scene_node* at, const scene_node* node, uint32_t* index) {
  for (uint32_t i = 0; i < at->child_count; ++i) {
    if (at->children[i] == node) {
      *index = i;
      return at;
    }
    scene_node* found = parent_of(at->children[i], node, index);
    if (found != NULL) return found;
  }
  return NULL;
}

void edit_touch(editor* e, uint32_t what) {
  cliff_parts_free(&e->cliff); /* what it held may be gone */
  if (e->field < SCENE_FIELDS_MAX) e->changed[e->field] |= what;
  e->unsaved = true;
}

/* Puts a node into the selected field's root, which becomes a union if it is none. Takes the node when it returns true. */
static bool add_to_root(editor* e, scene_node* node) {
  scene_field* field = &e->scene->fields[e->field];
  if (field->support == NULL) {
    field->support = node;
    return true;
  }
  if (field->support->kind != SCREE_SHAPE_UNION && field->support->kind != SCREE_SHAPE_SMOOTH_UNION) {
    scene_node* group = scene_node_create(SCREE_SHAPE_UNION);
    if (group == NULL) return false;
    if (!scene_node_add(group, field->support)) {
      scene_node_destroy(group);
      return false;
    }
    field->support = group;
  }
  return scene_node_add(field->support, node);
}

static uint32_t count_nodes(const scene_node* node) {
  uint32_t count = 1;
  for (uint32_t i = 0; node != NULL && i < node->child_count; ++i) count += count_nodes(node->children[i]);
  return node == NULL ? 0 : count;
}

/* Room for `more` nodes, and a group above them, in a tree that a scene file may hold. */
static bool has_room(const editor* e, uint32_t more) {
  if (e->scene->fields[e->field].is_cliff) return false; /* it has no shapes */
  return count_nodes(e->scene->fields[e->field].support) + more + 1 <= SCENE_NODES_MAX;
}

/* Ridges go on for ever: a new pattern comes with the cylinder that cuts it to size. */
static scene_node* raked_bed(double size) {
  scene_node* bed = scene_node_create(SCREE_SHAPE_INTERSECTION);
  scene_node* ridges = scene_node_create(SCREE_SHAPE_PATTERN);
  scene_node* cut = scene_node_create(SCREE_SHAPE_CYLINDER);
  if (ridges != NULL) {
    ridges->pattern.spacing = 0.3 * size;
    ridges->pattern.radius = 0.12 * size;
  }
  if (cut != NULL) {
    cut->cylinder.radius = size;
    cut->cylinder.half_height = size;
  }
  bool good = bed != NULL && ridges != NULL && cut != NULL;
  if (good && scene_node_add(bed, ridges)) {
    ridges = NULL;
    if (scene_node_add(bed, cut)) return bed;
  }
  scene_node_destroy(bed);
  scene_node_destroy(ridges);
  scene_node_destroy(cut);
  return NULL;
}

bool edit_add(editor* e, scree_shape_kind kind, const double place[3], double size) {
  if (e->field >= e->scene->field_count || scene_kind_has_children(kind) || kind == SCREE_SHAPE_HALF_SPACE ||
      !has_room(e, kind == SCREE_SHAPE_PATTERN ? 3 : 1))
    return false;
  scene_node* node = kind == SCREE_SHAPE_PATTERN ? raked_bed(size) : scene_node_create(kind);
  if (node == NULL) return false;
  switch (kind) {
    case SCREE_SHAPE_SPHERE: node->sphere.radius = size; break;
    case SCREE_SHAPE_BOX:
      for (int a = 0; a < 3; ++a) node->box.half[a] = size;
      node->box.rounding = 0;
      break;
    case SCREE_SHAPE_CAPSULE:
      for (int a = 0; a < 3; ++a) {
        node->capsule.a[a] = a == 0 ? -size : 0;
        node->capsule.b[a] = a == 0 ? size : 0;
      }
      node->capsule.radius = 0.5 * size;
      break;
    case SCREE_SHAPE_CYLINDER:
      node->cylinder.radius = size;
      node->cylinder.half_height = size;
      break;
    case SCREE_SHAPE_CONE:
      node->cone.radius = size;
      node->cone.height = 1.5 * size;
      break;
    case SCREE_SHAPE_ELLIPSOID:
      for (int a = 0; a < 3; ++a) node->ellipsoid.radii[a] = a == 1 ? 0.6 * size : size;
      break;
    case SCREE_SHAPE_TORUS:
      node->torus.radius = size;
      node->torus.tube_radius = 0.3 * size;
      break;
    case SCREE_SHAPE_EXTRUSION:
    case SCREE_SHAPE_TUBE:
    case SCREE_SHAPE_BLOBS:
      if (kind == SCREE_SHAPE_EXTRUSION) node->extrusion.high = size;
      for (uint32_t i = 0; i < node->point_count; ++i) {
        for (int a = 0; a < 3; ++a) node->points[i].place[a] *= size;
        node->points[i].radius *= kind == SCREE_SHAPE_BLOBS ? 2 * size : size;
      }
      break;
    default: break;
  }
  if (!add_to_root(e, node)) {
    scene_node_destroy(node);
    return false;
  }
  edit_frame parent = world_frame;
  edit_node_frame(e->scene->fields[e->field].support, node, NULL, &parent);
  if (node != e->scene->fields[e->field].support) node->scale = 1 / parent.scale;
  to_local(&parent, place, node->position);
  e->node = node;
  edit_touch(e, SCENE_CHANGED_SUPPORT);
  return true;
}

bool edit_wrap(editor* e, scree_shape_kind kind) {
  if (e->node == NULL || e->field >= e->scene->field_count || !has_room(e, 1)) return false;
  if (kind != SCREE_SHAPE_NOISE && kind != SCREE_SHAPE_HALF_SPACE) return false;
  scene_node** root = &e->scene->fields[e->field].support;
  uint32_t index = 0;
  scene_node* parent = parent_of(*root, e->node, &index);
  if (parent == NULL && *root != e->node) return false;
  scene_node* wrapper = scene_node_create(kind == SCREE_SHAPE_NOISE ? SCREE_SHAPE_NOISE : SCREE_SHAPE_DIFFERENCE);
  scene_node* cut = kind == SCREE_SHAPE_NOISE ? NULL : scene_node_create(SCREE_SHAPE_HALF_SPACE);
  if (wrapper == NULL || (kind != SCREE_SHAPE_NOISE && cut == NULL) || !scene_node_add(wrapper, e->node)) {
    scene_node_destroy(wrapper);
    scene_node_destroy(cut);
    return false;
  }
  if (cut != NULL && !scene_node_add(wrapper, cut)) {
    scene_node_detach(wrapper, 0);
    scene_node_destroy(wrapper);
    scene_node_destroy(cut);
    return false;
  }
  /* The place goes to the wrapper, so that a root's stays the support's origin. */
  memcpy(wrapper->position, e->node->position, sizeof wrapper->position);
  memset(e->node->position, 0, sizeof e->node->position);
  *(parent != NULL ? &parent->children[index] : root) = wrapper;
  e->node = cut != NULL ? cut : wrapper;
  edit_touch(e, SCENE_CHANGED_SUPPORT);
  return true;
}

bool edit_delete(editor* e) {
  if (e->node == NULL || e->field >= e->scene->field_count) return false;
  scene_field* field = &e->scene->fields[e->field];
  if (field->support == e->node) return false;
  uint32_t index;
  scene_node* parent = parent_of(field->support, e->node, &index);
  if (parent == NULL || parent->child_count == 1) return false;
  scene_node_destroy(scene_node_detach(parent, index));
  e->node = NULL;
  edit_touch(e, SCENE_CHANGED_SUPPORT);
  return true;
}

bool edit_duplicate(editor* e) {
  if (e->node == NULL || e->field >= e->scene->field_count) return false;
  uint32_t index;
  scene_node* original = e->node;
  scene_node* parent = parent_of(e->scene->fields[e->field].support, original, &index);
  while (parent != NULL && parent->kind == SCREE_SHAPE_NOISE) { /* which has room for one shape: the two are copied together */
    original = parent;
    parent = parent_of(e->scene->fields[e->field].support, original, &index);
  }
  scene_node* copy = has_room(e, count_nodes(original)) ? scene_node_copy(original) : NULL;
  if (copy == NULL) return false;
  if (!(parent != NULL ? scene_node_add(parent, copy) : add_to_root(e, copy))) {
    scene_node_destroy(copy);
    return false;
  }
  double min[3], max[3], step = 1;
  if (edit_leaf_box(copy, min, max)) step = 0.6 * (max[0] - min[0]) * copy->scale;
  copy->position[0] += step;
  e->node = copy;
  edit_touch(e, SCENE_CHANGED_SUPPORT);
  return true;
}

bool edit_cliff_time(editor* e, uint32_t time) {
  if (e->field >= e->scene->field_count || !e->scene->fields[e->field].is_cliff) return false;
  if (e->scene->fields[e->field].cliff.time == time) return false;
  if ((e->cliff.fields >> e->field & 1) == 0) {
    cliff_parts_free(&e->cliff);
    if (!cliff_parts_find(e->scene, e->field, &e->cliff)) return false;
  }
  cliff_parts_set_time(&e->cliff, e->scene, time);
  for (uint32_t i = 0; i < e->scene->field_count; ++i) {
    if ((e->cliff.fields >> i & 1) != 0) e->changed[i] |= SCENE_CHANGED_PACK;
    if ((e->cliff.supports >> i & 1) != 0) e->changed[i] |= SCENE_CHANGED_SUPPORT;
  }
  e->unsaved = true;
  return true;
}

/* --- Dragging --- */

void edit_drag_begin(editor* e, edit_drag_kind kind, const double grabbed[3], double height) {
  if (e->node == NULL) return;
  e->drag = kind;
  memcpy(e->drag_grabbed, grabbed, sizeof e->drag_grabbed);
  memcpy(e->drag_position, e->node->position, sizeof e->drag_position);
  e->drag_scale = e->node->scale;
  e->drag_height = height;
}

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* How far along `axis` from `from` the ray comes closest to it; false when the ray runs along the axis. */
static bool along_axis(const double from[3], const double axis[3], const double eye[3], const double direction[3], double* out) {
  double between[3];
  for (int a = 0; a < 3; ++a) between[a] = eye[a] - from[a];
  double b = dot(axis, direction), c = dot(direction, direction);
  double d = dot(axis, between), f = dot(direction, between), determinant = c - b * b;
  if (determinant < 1e-6 * c) return false;
  *out = (c * d - b * f) / determinant;
  return true;
}

static int drag_axis(edit_drag_kind kind) {
  return kind == EDIT_DRAG_X ? 0 : kind == EDIT_DRAG_Z ? 2 : 1;
}

void edit_drag_grab(editor* e, const double eye[3], const double direction[3]) {
  const int axis = drag_axis(e->drag);
  const double unit[3] = {axis == 0, axis == 1, axis == 2};
  double way;
  if (along_axis(e->drag_grabbed, unit, eye, direction, &way)) e->drag_grabbed[axis] += way;
}

bool edit_drag_to(editor* e, const double eye[3], const double direction[3], double height) {
  if (e->drag == EDIT_DRAG_NONE || e->node == NULL) return false;
  const scene_node before = *e->node;
  if (e->drag == EDIT_DRAG_SCALE) {
    double factor = exp(2.5 * (height - e->drag_height));
    e->node->scale = fmin(fmax(e->drag_scale * factor, 1e-3), 1e3);
  } else {
    double moved[3] = {0, 0, 0};
    if (e->drag == EDIT_DRAG_GROUND) {
      /* Towards the horizon a pixel is a mile: hold the pointer below it. */
      if (direction[1] * (e->drag_grabbed[1] - eye[1]) <= 0) return false;
      double t = (e->drag_grabbed[1] - eye[1]) / direction[1];
      for (int a = 0; a < 3; a += 2) moved[a] = eye[a] + t * direction[a] - e->drag_grabbed[a];
      double reach = 0, away = sqrt(moved[0] * moved[0] + moved[2] * moved[2]);
      for (int a = 0; a < 3; ++a) reach += (e->drag_grabbed[a] - eye[a]) * (e->drag_grabbed[a] - eye[a]);
      reach = 20 * sqrt(reach);
      if (away > reach)
        for (int a = 0; a < 3; a += 2) moved[a] *= reach / away;
    } else {
      const int axis = drag_axis(e->drag);
      const double unit[3] = {axis == 0, axis == 1, axis == 2};
      double way;
      if (!along_axis(e->drag_grabbed, unit, eye, direction, &way)) return false;
      moved[axis] = way;
    }
    edit_frame parent;
    if (!edit_node_frame(e->scene->fields[e->field].support, e->node, NULL, &parent)) return false;
    edit_frame turned = parent;
    for (int a = 0; a < 3; ++a) turned.translation[a] = 0;
    double local[3];
    to_local(&turned, moved, local);
    for (int a = 0; a < 3; ++a) e->node->position[a] = e->drag_position[a] + local[a];
  }
  if (memcmp(before.position, e->node->position, sizeof before.position) == 0 && before.scale == e->node->scale) return false;
  edit_touch(e, SCENE_CHANGED_SUPPORT);
  return true;
}

void edit_drag_end(editor* e) {
  if (e->drag == EDIT_DRAG_NONE) return;
  e->drag = EDIT_DRAG_NONE;
  edit_commit(e);
}

/* --- History --- */

void edit_begin(editor* e, scene_model* scene) {
  memset(e, 0, sizeof *e);
  e->scene = scene;
  e->history[0] = scene_write(scene, NULL);
  e->history_count = e->history[0] != NULL;
}

void edit_end(editor* e) {
  cliff_parts_free(&e->cliff);
  for (uint32_t i = 0; i < e->history_count; ++i) free(e->history[i]);
  memset(e, 0, sizeof *e);
}

void edit_commit(editor* e) {
  cliff_parts_free(&e->cliff);
  if (e->history_count == 0) return; /* no memory from the start: no history */
  char* text = scene_write(e->scene, NULL);
  if (text == NULL) return;
  if (strcmp(text, e->history[e->history_now]) == 0) {
    free(text);
    return;
  }
  while (e->history_count > e->history_now + 1) free(e->history[--e->history_count]);
  if (e->history_count == EDIT_HISTORY) {
    free(e->history[0]);
    memmove(e->history, e->history + 1, (EDIT_HISTORY - 1) * sizeof *e->history);
    --e->history_count;
  }
  e->history[e->history_count] = text;
  e->history_now = e->history_count++;
}

/* Nodes by number, depth first, so that a selection outlives the tree that it was made in. */
static scene_node* node_by_number(scene_node* at, uint32_t* number) {
  if (at == NULL) return NULL;
  if ((*number)-- == 0) return at;
  for (uint32_t i = 0; i < at->child_count; ++i) {
    scene_node* found = node_by_number(at->children[i], number);
    if (found != NULL) return found;
  }
  return NULL;
}

static bool number_of_node(const scene_node* at, const scene_node* node, uint32_t* number) {
  if (at == node) return true;
  ++*number;
  for (uint32_t i = 0; i < at->child_count; ++i)
    if (number_of_node(at->children[i], node, number)) return true;
  return false;
}

static bool go_to(editor* e, uint32_t state) {
  const char* text = e->history[state];
  scene_model earlier;
  scree_error error;
  if (scene_parse(text, strlen(text), "history", &earlier, &error) != SCREE_OK) return false;
  uint32_t number = 0;
  bool selected = e->node != NULL && number_of_node(e->scene->fields[e->field].support, e->node, &number);
  cliff_parts_free(&e->cliff);
  scene_destroy(e->scene);
  *e->scene = earlier;
  if (e->field >= e->scene->field_count) e->field = 0;
  e->node = selected && e->scene->field_count > 0 ? node_by_number(e->scene->fields[e->field].support, &number) : NULL;
  e->history_now = state;
  e->changed_fields = e->changed_ground = e->unsaved = true;
  e->drag = EDIT_DRAG_NONE;
  return true;
}

bool edit_undo(editor* e) {
  edit_commit(e); /* what is not yet committed is a state that redo may want */
  return e->history_now > 0 && go_to(e, e->history_now - 1);
}

bool edit_redo(editor* e) {
  return e->history_count > 0 && e->history_now + 1 < e->history_count && go_to(e, e->history_now + 1);
}
