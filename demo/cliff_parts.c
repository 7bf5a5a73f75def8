#include "cliff_parts.h"

#include <stdlib.h>
#include <string.h>

#include "edit.h"

static bool same_place(const scene_field* a, const scene_field* b) {
  for (int i = 0; i < 3; ++i)
    if (a->origin[i] != b->origin[i]) return false;
  return a->cliff.turn == b->cliff.turn && a->cliff.scale == b->cliff.scale;
}

static edit_frame frame_of(const scene_field* field) {
  edit_frame frame = {.scale = field->cliff.scale};
  const double degrees[3] = {0, field->cliff.turn, 0};
  memcpy(frame.translation, field->origin, sizeof frame.translation);
  scene_rotation_quaternion(degrees, frame.rotation);
  return frame;
}

/* How far two frames take the origin and the ends of the three axes apart: of cliffs at one origin, the turn decides. */
static double apart(const edit_frame* a, const edit_frame* b) {
  static const double points[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  double squared = 0;
  for (int i = 0; i < 4; ++i) {
    double p[3], q[3];
    edit_frame_point(a, points[i], p);
    edit_frame_point(b, points[i], q);
    for (int k = 0; k < 3; ++k) squared += (p[k] - q[k]) * (p[k] - q[k]);
  }
  return squared;
}

/* The field of a cliff of this pack, at any time, that stands nearest to `frame`; the first of equals. There is one. */
static const scene_field* nearest(const scene_model* scene, const char* pack, const edit_frame* frame) {
  const scene_field* best = NULL;
  double best_apart = 0;
  for (uint32_t i = 0; i < scene->field_count; ++i) {
    const scene_field* field = &scene->fields[i];
    if (!field->is_cliff || strcmp(field->pack, pack) != 0) continue;
    const edit_frame own = frame_of(field);
    const double distance = apart(&own, frame);
    if (best != NULL && distance >= best_apart) continue;
    best = field;
    best_apart = distance;
  }
  return best;
}

static bool add_mesh(cliff_parts* parts, scene_node* node) {
  if (parts->mesh_count == parts->mesh_capacity) {
    const uint32_t capacity = 2 * parts->mesh_capacity + 8;
    scene_node** grown = realloc(parts->meshes, capacity * sizeof *grown);
    if (grown == NULL) return false;
    parts->meshes = grown;
    parts->mesh_capacity = capacity;
  }
  parts->meshes[parts->mesh_count++] = node;
  return true;
}

/* Adds the meshes of the cliff that are at and below `node`, in the tree `root`. */
static bool add_meshes(const scene_model* scene, const scene_field* field, const scene_node* root, scene_node* node,
                       cliff_parts* parts) {
  for (uint32_t i = 0; i < node->child_count; ++i)
    if (!add_meshes(scene, field, root, node->children[i], parts)) return false;
  if (node->kind != SCREE_SHAPE_MESH || node->mesh.time != field->cliff.time || strcmp(node->mesh.pack, field->pack) != 0)
    return true;
  edit_frame frame;
  if (!edit_node_frame(root, node, &frame, NULL) || !same_place(nearest(scene, field->pack, &frame), field)) return true;
  return add_mesh(parts, node);
}

bool cliff_parts_find(const scene_model* scene, uint32_t field, cliff_parts* out) {
  *out = (cliff_parts){.meshes = NULL};
  if (field >= scene->field_count || !scene->fields[field].is_cliff) return false;
  const scene_field* cliff = &scene->fields[field];
  for (uint32_t i = 0; i < scene->field_count; ++i) {
    const scene_field* other = &scene->fields[i];
    if (other->is_cliff) {
      if (other->cliff.time == cliff->cliff.time && strcmp(other->pack, cliff->pack) == 0 && same_place(other, cliff))
        out->fields |= UINT64_C(1) << i;
      continue;
    }
    const uint32_t before = out->mesh_count;
    if (other->support != NULL && !add_meshes(scene, cliff, other->support, other->support, out)) {
      cliff_parts_free(out);
      return false;
    }
    if (out->mesh_count > before) out->supports |= UINT64_C(1) << i;
  }
  return true;
}

void cliff_parts_free(cliff_parts* parts) {
  free(parts->meshes);
  *parts = (cliff_parts){.meshes = NULL};
}

void cliff_parts_set_time(const cliff_parts* parts, scene_model* scene, uint32_t time) {
  for (uint32_t i = 0; i < scene->field_count; ++i)
    if ((parts->fields >> i & 1) != 0) scene->fields[i].cliff.time = time;
  for (uint32_t i = 0; i < parts->mesh_count; ++i) parts->meshes[i]->mesh.time = time;
}
