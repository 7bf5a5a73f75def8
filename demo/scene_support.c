/* From the tree of a scene to a compiled support. */
#include "scene_support.h"

#include <stdlib.h>
#include <string.h>

#include "file.h"

typedef struct builder {
  const scene_paths* paths;
  scene_files* files;
  scree_error* error;
  scree_shape* shapes;
  uint32_t* children; /* all groups' lists of children, one after the other */
  float* numbers;     /* all lists of points, one after the other */
  uint32_t shape_count, child_count;
  size_t number_count;
  char where[256]; /* "fields[0].support.children[2]" */
  size_t length;
} builder;

static uint32_t count_nodes(const scene_node* node) {
  uint32_t count = 1;
  for (uint32_t i = 0; i < node->child_count; ++i) count += count_nodes(node->children[i]);
  return count;
}

static size_t count_points(const scene_node* node) {
  size_t count = node->point_count;
  for (uint32_t i = 0; i < node->child_count; ++i) count += count_points(node->children[i]);
  return count;
}

static void to_floats(const double* from, float* to) {
  for (int i = 0; i < 3; ++i) to[i] = (float)from[i];
}

static scree_transform transform_of(const scene_node* node, bool is_root) {
  scree_transform transform = {.scale = (float)node->scale};
  double quaternion[4];
  scene_rotation_quaternion(node->rotation, quaternion);
  for (int i = 0; i < 4; ++i) transform.rotation[i] = (float)quaternion[i];
  /* The root's place is the support's origin. */
  if (!is_root) to_floats(node->position, transform.translation);
  return transform;
}

static scree_result fill_heightfield(builder* b, const scene_node* node, scree_shape* shape) {
  const height_samples* samples;
  const scene_height_map* map = &node->heightfield.map;
  scree_result result = scene_files_heights(b->files, b->paths, b->where, map, &samples, b->error);
  if (result != SCREE_OK) return result;
  shape->heightfield.heights = samples->heights;
  shape->heightfield.width = samples->width;
  shape->heightfield.depth = samples->depth;
  shape->heightfield.spacing = (float)map->spacing;
  shape->heightfield.above = (float)node->heightfield.above;
  shape->heightfield.below = (float)node->heightfield.below;
  return SCREE_OK;
}

static scree_result fill_mesh(builder* b, const scene_node* node, scree_shape* shape) {
  return scene_files_mesh(b->files, b->paths, b->where, &node->mesh, &shape->mesh, b->error);
}

static float* take_numbers(builder* b, size_t count) {
  float* numbers = b->numbers + b->number_count;
  b->number_count += count;
  return numbers;
}

static const float* corners_of(builder* b, const scene_node* node) {
  float* corners = take_numbers(b, (size_t)2 * node->point_count);
  for (uint32_t i = 0; i < node->point_count; ++i) {
    corners[2 * i] = (float)node->points[i].place[0];
    corners[2 * i + 1] = (float)node->points[i].place[2];
  }
  return corners;
}

static const float* places_of(builder* b, const scene_node* node) {
  float* places = take_numbers(b, (size_t)3 * node->point_count);
  for (uint32_t i = 0; i < node->point_count; ++i) to_floats(node->points[i].place, places + 3 * i);
  return places;
}

static const float* radii_of(builder* b, const scene_node* node) {
  float* radii = take_numbers(b, node->point_count);
  for (uint32_t i = 0; i < node->point_count; ++i) radii[i] = (float)node->points[i].radius;
  return radii;
}

static scree_result add_node(builder* b, const scene_node* node);

/* Goes down to a child, whose place in the file is `step` below its parent's. number: the child's. */
static scree_result add_child(builder* b, const scene_node* child, const char* step, uint32_t* number) {
  size_t before = b->length, length = strlen(step);
  if (length < sizeof b->where - before) {
    memcpy(b->where + before, step, length + 1);
    b->length = before + length;
  }
  *number = b->shape_count;
  scree_result result = add_node(b, child);
  if (result != SCREE_OK) return result;
  b->length = before;
  b->where[before] = '\0';
  return SCREE_OK;
}

static scree_result fill_group(builder* b, const scene_node* node, scree_shape* shape) {
  uint32_t* children = b->children + b->child_count;
  b->child_count += node->child_count;
  shape->group.children = children;
  shape->group.child_count = node->child_count;
  shape->group.blend = (float)node->group.blend;
  if (node->child_count == 0)
    return fail_with(b->error, SCREE_ERROR_RANGE, "%s: %s: a group needs at least one shape", b->paths->scene, b->where);
  for (uint32_t i = 0; i < node->child_count; ++i) {
    char step[32];
    snprintf(step, sizeof step, ".children[%u]", i);
    scree_result result = add_child(b, node->children[i], step, &children[i]);
    if (result != SCREE_OK) return result;
  }
  return SCREE_OK;
}

static scree_result fill_noise(builder* b, const scene_node* node, scree_shape* shape) {
  shape->noise.amplitude = (float)node->noise.amplitude;
  shape->noise.wavelength = (float)node->noise.wavelength;
  shape->noise.octaves = node->noise.octaves;
  shape->noise.seed = node->noise.seed;
  if (node->child_count != 1)
    return fail_with(b->error, SCREE_ERROR_RANGE, "%s: %s: noise needs one shape", b->paths->scene, b->where);
  return add_child(b, node->children[0], ".child", &shape->noise.child);
}

static scree_result add_node(builder* b, const scene_node* node) {
  bool is_root = b->shape_count == 0;
  scree_shape* shape = &b->shapes[b->shape_count++];
  *shape = (scree_shape){.kind = node->kind, .transform = transform_of(node, is_root)};
  switch (node->kind) {
    case SCREE_SHAPE_SPHERE: shape->sphere.radius = (float)node->sphere.radius; break;
    case SCREE_SHAPE_BOX:
      to_floats(node->box.half, shape->box.half);
      shape->box.rounding = (float)node->box.rounding;
      break;
    case SCREE_SHAPE_CAPSULE:
      to_floats(node->capsule.a, shape->capsule.a);
      to_floats(node->capsule.b, shape->capsule.b);
      shape->capsule.radius = (float)node->capsule.radius;
      break;
    case SCREE_SHAPE_CYLINDER:
      shape->cylinder.radius = (float)node->cylinder.radius;
      shape->cylinder.half_height = (float)node->cylinder.half_height;
      break;
    case SCREE_SHAPE_CONE:
      shape->cone.radius = (float)node->cone.radius;
      shape->cone.height = (float)node->cone.height;
      break;
    case SCREE_SHAPE_HEIGHTFIELD: return fill_heightfield(b, node, shape);
    case SCREE_SHAPE_MESH: return fill_mesh(b, node, shape);
    case SCREE_SHAPE_UNION:
    case SCREE_SHAPE_INTERSECTION:
    case SCREE_SHAPE_DIFFERENCE:
    case SCREE_SHAPE_SMOOTH_UNION: return fill_group(b, node, shape);
    case SCREE_SHAPE_NOISE: return fill_noise(b, node, shape);
    case SCREE_SHAPE_ELLIPSOID: to_floats(node->ellipsoid.radii, shape->ellipsoid.radii); break;
    case SCREE_SHAPE_TORUS:
      shape->torus.radius = (float)node->torus.radius;
      shape->torus.tube_radius = (float)node->torus.tube_radius;
      break;
    case SCREE_SHAPE_EXTRUSION:
      shape->extrusion.points = corners_of(b, node);
      shape->extrusion.point_count = node->point_count;
      shape->extrusion.low = (float)node->extrusion.low;
      shape->extrusion.high = (float)node->extrusion.high;
      break;
    case SCREE_SHAPE_TUBE:
      shape->tube.points = places_of(b, node);
      shape->tube.radii = radii_of(b, node);
      shape->tube.point_count = node->point_count;
      shape->tube.closed = node->tube.closed;
      shape->tube.subdivisions = node->tube.subdivisions;
      shape->tube.half_height = (float)node->tube.half_height;
      break;
    case SCREE_SHAPE_BLOBS:
      shape->blobs.centres = places_of(b, node);
      shape->blobs.radii = radii_of(b, node);
      shape->blobs.count = node->point_count;
      break;
    case SCREE_SHAPE_PATTERN:
      shape->pattern.kind = node->pattern.kind;
      shape->pattern.spacing = (float)node->pattern.spacing;
      shape->pattern.radius = (float)node->pattern.radius;
      shape->pattern.amplitude = (float)node->pattern.amplitude;
      shape->pattern.wavelength = (float)node->pattern.wavelength;
      break;
    case SCREE_SHAPE_HALF_SPACE:
    case SCREE_SHAPE_CALLBACK: break;
  }
  return SCREE_OK;
}

/* The path below `node` of the shape with this number; shapes are numbered in the order of the file. Returns false when it is not
 * there, with *number less by all that are. */
static bool path_of_shape(const scene_node* node, uint32_t* number, char* path, size_t capacity, const scene_node** found) {
  if (*number == 0) {
    *found = node;
    return true;
  }
  --*number;
  for (uint32_t i = 0; i < node->child_count; ++i) {
    int length =
        node->kind == SCREE_SHAPE_NOISE ? snprintf(path, capacity, ".child") : snprintf(path, capacity, ".children[%u]", i);
    if (length < 0 || (size_t)length >= capacity) return false;
    if (path_of_shape(node->children[i], number, path + length, capacity - (size_t)length, found)) return true;
  }
  path[0] = '\0';
  return false;
}

/* The runtime names a shape by its number; people know it by its place in the file. */
static scree_result fail_at_shape(builder* b, const scene_node* root, scree_result result, const scree_error* cause) {
  const char* message = cause->message[0] != '\0' ? cause->message : scree_result_string(result);
  const scene_node* node = NULL;
  uint32_t number;
  int end = 0;
  if (sscanf(message, "shape %u: %n", &number, &end) == 1 && end > 0) {
    if (path_of_shape(root, &number, b->where + b->length, sizeof b->where - b->length, &node)) message += end;
  }
  const bool is_mesh = node != NULL && node->kind == SCREE_SHAPE_MESH;
  const char* file = !is_mesh ? "" : node->mesh.pack[0] != '\0' ? node->mesh.pack : node->mesh.file;
  return fail_with(b->error, result, "%s: %s: %s%s%.300s", b->paths->scene, b->where, file, file[0] != '\0' ? ": " : "", message);
}

static scree_result build(builder* b, const scene_node* root, const scree_jobs* jobs, const scree_support* reuse,
                          scree_support** out) {
  scree_result result = add_node(b, root);
  if (result != SCREE_OK) return result;
  scree_support_desc desc = {.shapes = b->shapes, .shape_count = b->shape_count, .reuse = reuse};
  memcpy(desc.origin, root->position, sizeof desc.origin);
  if (jobs != NULL) desc.jobs = *jobs;
  scree_error cause = {""};
  result = scree_support_create(&desc, NULL, out, &cause);
  if (result == SCREE_OK) return SCREE_OK;
  return fail_at_shape(b, root, result, &cause);
}

scree_result scene_support_create(const scene_model* scene, uint32_t index, const scene_paths* paths, scene_files* files,
                                  const scree_jobs* jobs, const scree_support* reuse, scree_support** out, scree_error* error) {
  *out = NULL;
  builder b = {.paths = paths, .files = files, .error = error};
  b.length = (size_t)snprintf(b.where, sizeof b.where, "fields[%u].support", index);
  const scene_node* root = index < scene->field_count ? scene->fields[index].support : NULL;
  if (root == NULL) return fail_with(error, SCREE_ERROR_INVALID_ARGUMENT, "%s: %s: there is none", paths->scene, b.where);
  uint32_t count = count_nodes(root);
  if (files == NULL) b.files = scene_files_create();
  b.shapes = calloc(count, sizeof *b.shapes);
  b.children = calloc(count, sizeof *b.children);
  b.numbers = calloc(4 * count_points(root) + 1, sizeof *b.numbers);
  scree_result result;
  if (b.files == NULL || b.shapes == NULL || b.children == NULL || b.numbers == NULL) {
    result = fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", paths->scene);
  } else {
    result = build(&b, root, jobs, reuse, out);
  }
  free(b.shapes);
  free(b.children);
  free(b.numbers);
  if (files == NULL) scene_files_destroy(b.files);
  return result;
}

scree_result scene_leaf_support(const scene_node* leaf, scree_support** out) {
  *out = NULL;
  if (scene_kind_has_children(leaf->kind) || leaf->kind == SCREE_SHAPE_HEIGHTFIELD || leaf->kind == SCREE_SHAPE_MESH)
    return SCREE_ERROR_UNSUPPORTED;
  const scene_paths paths = {.scene = ""};
  scree_shape shape;
  builder b = {.paths = &paths, .shapes = &shape, .numbers = calloc((size_t)4 * leaf->point_count + 1, sizeof *b.numbers)};
  if (b.numbers == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  scree_result result = add_node(&b, leaf);
  shape.transform = (scree_transform){.scale = 1};
  const scree_support_desc desc = {.shapes = &shape, .shape_count = 1};
  if (result == SCREE_OK) result = scree_support_create(&desc, NULL, out, NULL);
  free(b.numbers);
  return result;
}
