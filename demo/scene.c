/* Scenes: defaults, ownership, the tree of nodes, rotations and colours. */
#include "scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void set3(double* out, double x, double y, double z) {
  out[0] = x;
  out[1] = y;
  out[2] = z;
}

static void set_colour(float* out, int r, int g, int b) {
  out[0] = (float)r / 255.0f;
  out[1] = (float)g / 255.0f;
  out[2] = (float)b / 255.0f;
}

void scene_init(scene_model* out) {
  memset(out, 0, sizeof *out);
  set3(out->camera.eye, 12, 8, 16);
  out->camera.fov = 45;
  set3(out->sun.direction, 0.5, 0.8, 0.35);
  set_colour(out->sun.colour, 255, 241, 224);
  set_colour(out->sky, 196, 212, 228);
  out->ground.kind = SCENE_GROUND_PLANE;
  set_colour(out->ground.colour, 124, 118, 96);
  set_colour(out->ground.water_colour, 62, 84, 78);
  out->ground.map.spacing = 1;
  out->ground.map.high = 1;
}

static void empty_field(scene_field* field) {
  scene_node_destroy(field->support);
  free(field->filters);
  free(field->scatter.models);
  free(field->scatter.weights);
}

void scene_destroy(scene_model* scene) {
  for (uint32_t i = 0; i < scene->field_count; ++i) empty_field(&scene->fields[i]);
  free(scene->fields);
  memset(scene, 0, sizeof *scene);
}

scene_field* scene_add_field(scene_model* scene) {
  if (scene->field_count >= SCENE_FIELDS_MAX) return NULL;
  scene_field* grown = realloc(scene->fields, (scene->field_count + 1) * sizeof *grown);
  if (grown == NULL) return NULL;
  scene->fields = grown;
  scene_field* field = &grown[scene->field_count++];
  memset(field, 0, sizeof *field);
  strcpy(field->pack, "boulders");
  field->cell_size = 1;
  field->threshold = 0.5;
  field->shell = true;
  field->key = -1;
  field->density = 1;
  field->cliff.scale = 1;
  field->scatter = (scene_scatter){.spacing = 1, .scale = {1, 1}, .max_slope = 45, .ages = {.kind = SCREE_FILTER_MASK}};
  field->scatter.ages.map.spacing = 1;
  field->scatter.ages.map.high = 1;
  set_colour(field->palette.colours[0], 178, 172, 160);
  set_colour(field->palette.colours[1], 158, 155, 150);
  set_colour(field->palette.colours[2], 172, 158, 138);
  set_colour(field->palette.colours[3], 140, 138, 136);
  field->palette.colour_count = 4;
  field->palette.variation = 0.25;
  return field;
}

void scene_remove_field(scene_model* scene, uint32_t index) {
  if (index >= scene->field_count) return;
  empty_field(&scene->fields[index]);
  --scene->field_count;
  memmove(&scene->fields[index], &scene->fields[index + 1], (scene->field_count - index) * sizeof *scene->fields);
}

bool scene_set_models(scene_scatter* scatter, uint32_t count) {
  char(*models)[SCENE_FILE_SIZE] = count > 0 ? calloc(count, sizeof *models) : NULL;
  if (count > 0 && models == NULL) return false;
  free(scatter->models);
  scatter->models = models;
  scatter->model_count = count;
  return true;
}

bool scene_set_weights(scene_scatter* scatter, uint32_t count) {
  double* weights = count > 0 ? calloc(count, sizeof *weights) : NULL;
  if (count > 0 && weights == NULL) return false;
  free(scatter->weights);
  scatter->weights = weights;
  scatter->weight_count = count;
  return true;
}

uint16_t scene_field_key(const scene_model* scene, uint32_t index) {
  const int32_t key = scene->fields[index].key;
  return (uint16_t)(key >= 0 ? (uint32_t)key : index);
}

scene_filter* scene_add_filter(scene_field* field, scree_filter_kind kind) {
  if (field->filter_count >= SCENE_FILTERS_MAX) return NULL;
  scene_filter* grown = realloc(field->filters, (field->filter_count + 1) * sizeof *grown);
  if (grown == NULL) return NULL;
  field->filters = grown;
  scene_filter* filter = &grown[field->filter_count++];
  memset(filter, 0, sizeof *filter);
  filter->kind = kind;
  filter->to = kind == SCREE_FILTER_SLOPE ? 90 : 0;
  filter->map.spacing = 1;
  filter->map.high = 1;
  return filter;
}

void scene_remove_filter(scene_field* field, uint32_t index) {
  if (index >= field->filter_count) return;
  --field->filter_count;
  memmove(&field->filters[index], &field->filters[index + 1], (field->filter_count - index) * sizeof *field->filters);
}

const char* scene_kind_name(scree_shape_kind kind) {
  switch (kind) {
    case SCREE_SHAPE_SPHERE: return "sphere";
    case SCREE_SHAPE_BOX: return "box";
    case SCREE_SHAPE_CAPSULE: return "capsule";
    case SCREE_SHAPE_CYLINDER: return "cylinder";
    case SCREE_SHAPE_CONE: return "cone";
    case SCREE_SHAPE_HEIGHTFIELD: return "heightfield";
    case SCREE_SHAPE_MESH: return "mesh";
    case SCREE_SHAPE_CALLBACK: break;
    case SCREE_SHAPE_ELLIPSOID: return "ellipsoid";
    case SCREE_SHAPE_HALF_SPACE: return "half_space";
    case SCREE_SHAPE_TORUS: return "torus";
    case SCREE_SHAPE_EXTRUSION: return "extrusion";
    case SCREE_SHAPE_TUBE: return "tube";
    case SCREE_SHAPE_BLOBS: return "blobs";
    case SCREE_SHAPE_PATTERN: return "pattern";
    case SCREE_SHAPE_UNION: return "union";
    case SCREE_SHAPE_INTERSECTION: return "intersection";
    case SCREE_SHAPE_DIFFERENCE: return "difference";
    case SCREE_SHAPE_SMOOTH_UNION: return "smooth_union";
    case SCREE_SHAPE_NOISE: return "noise";
  }
  return NULL;
}

const char* scene_pattern_name(scree_pattern_kind kind) {
  switch (kind) {
    case SCREE_PATTERN_LINES: return "lines";
    case SCREE_PATTERN_RINGS: return "rings";
    case SCREE_PATTERN_WAVES: return "waves";
  }
  return NULL;
}

const char* scene_filter_name(scree_filter_kind kind) {
  switch (kind) {
    case SCREE_FILTER_MASK: return "mask";
    case SCREE_FILTER_SLOPE: return "slope";
    case SCREE_FILTER_ALTITUDE: return "altitude";
  }
  return NULL;
}

scene_point_limits scene_kind_points(scree_shape_kind kind) {
  switch (kind) {
    case SCREE_SHAPE_EXTRUSION: return (scene_point_limits){3, SCENE_CORNERS_MAX};
    case SCREE_SHAPE_TUBE: return (scene_point_limits){2, SCENE_POINTS_MAX};
    case SCREE_SHAPE_BLOBS: return (scene_point_limits){1, SCENE_POINTS_MAX};
    default: return (scene_point_limits){0, 0};
  }
}

/* What a new shape with points starts from. */
static bool set_points(scene_node* node) {
  static const scene_point corners[] = {{{-1, 0, -1}, 0}, {{1, 0, -1}, 0}, {{1, 0, 1}, 0}, {{-1, 0, 1}, 0}};
  static const scene_point curve[] = {{{-1, 0, 0}, 0.5}, {{1, 0, 0}, 0.5}};
  static const scene_point balls[] = {{{0, 0, 0}, 1}};
  const scene_point* points = node->kind == SCREE_SHAPE_EXTRUSION ? corners : node->kind == SCREE_SHAPE_TUBE ? curve : balls;
  const uint32_t count = node->kind == SCREE_SHAPE_EXTRUSION ? 4 : node->kind == SCREE_SHAPE_TUBE ? 2 : 1;
  for (uint32_t i = 0; i < count; ++i)
    if (!scene_node_add_point(node, i, &points[i])) return false;
  return true;
}

scene_node* scene_node_create(scree_shape_kind kind) {
  scene_node* node = calloc(1, sizeof *node);
  if (node == NULL) return NULL;
  node->kind = kind;
  node->scale = 1;
  switch (kind) {
    case SCREE_SHAPE_SPHERE: node->sphere.radius = 1; break;
    case SCREE_SHAPE_BOX: set3(node->box.half, 1, 1, 1); break;
    case SCREE_SHAPE_CAPSULE:
      set3(node->capsule.a, 0, -1, 0);
      set3(node->capsule.b, 0, 1, 0);
      node->capsule.radius = 1;
      break;
    case SCREE_SHAPE_CYLINDER:
      node->cylinder.radius = 1;
      node->cylinder.half_height = 1;
      break;
    case SCREE_SHAPE_CONE:
      node->cone.radius = 1;
      node->cone.height = 1;
      break;
    case SCREE_SHAPE_HEIGHTFIELD:
      node->heightfield.map.spacing = 1;
      node->heightfield.map.high = 1;
      node->heightfield.below = 1;
      break;
    case SCREE_SHAPE_ELLIPSOID: set3(node->ellipsoid.radii, 1, 1, 1); break;
    case SCREE_SHAPE_TORUS:
      node->torus.radius = 1;
      node->torus.tube_radius = 0.25;
      break;
    case SCREE_SHAPE_EXTRUSION: node->extrusion.high = 1; break;
    case SCREE_SHAPE_PATTERN:
      node->pattern.spacing = 1;
      node->pattern.radius = 0.25;
      node->pattern.wavelength = 1;
      break;
    case SCREE_SHAPE_SMOOTH_UNION: node->group.blend = 1; break;
    case SCREE_SHAPE_NOISE:
      node->noise.amplitude = 0.25;
      node->noise.wavelength = 1;
      node->noise.octaves = 1;
      break;
    case SCREE_SHAPE_MESH:
    case SCREE_SHAPE_CALLBACK:
    case SCREE_SHAPE_HALF_SPACE:
    case SCREE_SHAPE_TUBE:
    case SCREE_SHAPE_BLOBS:
    case SCREE_SHAPE_UNION:
    case SCREE_SHAPE_INTERSECTION:
    case SCREE_SHAPE_DIFFERENCE: break;
  }
  if (scene_kind_points(kind).most > 0 && !set_points(node)) {
    scene_node_destroy(node);
    return NULL;
  }
  return node;
}

void scene_node_destroy(scene_node* node) {
  if (node == NULL) return;
  for (uint32_t i = 0; i < node->child_count; ++i) scene_node_destroy(node->children[i]);
  free(node->children);
  free(node->points);
  free(node);
}

scene_node* scene_node_copy(const scene_node* node) {
  scene_node* copy = malloc(sizeof *copy);
  if (copy == NULL) return NULL;
  *copy = *node;
  copy->children = NULL;
  copy->child_count = 0;
  copy->points = NULL;
  if (node->point_count > 0) {
    copy->points = malloc(node->point_count * sizeof *copy->points);
    if (copy->points == NULL) {
      free(copy);
      return NULL;
    }
    memcpy(copy->points, node->points, node->point_count * sizeof *copy->points);
  }
  for (uint32_t i = 0; i < node->child_count; ++i) {
    scene_node* child = scene_node_copy(node->children[i]);
    if (child == NULL || !scene_node_add(copy, child)) {
      scene_node_destroy(child);
      scene_node_destroy(copy);
      return NULL;
    }
  }
  return copy;
}

bool scene_node_add(scene_node* parent, scene_node* child) {
  scene_node** grown = realloc(parent->children, (parent->child_count + 1) * sizeof *grown);
  if (grown == NULL) return false;
  parent->children = grown;
  grown[parent->child_count++] = child;
  return true;
}

bool scene_node_add_point(scene_node* node, uint32_t index, const scene_point* point) {
  if (node->point_count >= scene_kind_points(node->kind).most) return false;
  const scene_point added = *point; /* it may be one of the node's own */
  scene_point* grown = realloc(node->points, (node->point_count + 1) * sizeof *grown);
  if (grown == NULL) return false;
  node->points = grown;
  if (index > node->point_count) index = node->point_count;
  memmove(grown + index + 1, grown + index, (node->point_count - index) * sizeof *grown);
  grown[index] = added;
  ++node->point_count;
  return true;
}

bool scene_node_remove_point(scene_node* node, uint32_t index) {
  if (index >= node->point_count || node->point_count <= scene_kind_points(node->kind).least) return false;
  --node->point_count;
  memmove(node->points + index, node->points + index + 1, (node->point_count - index) * sizeof *node->points);
  return true;
}

scene_node* scene_node_detach(scene_node* parent, uint32_t index) {
  if (index >= parent->child_count) return NULL;
  scene_node* child = parent->children[index];
  --parent->child_count;
  memmove(&parent->children[index], &parent->children[index + 1], (parent->child_count - index) * sizeof *parent->children);
  return child;
}

/* Sine and cosine of degrees by their series on -45..45, where twelve terms are exact to the last bit or two. libm's differ between
 * systems, and which rocks exist must not. */
static void sine_cosine(double degrees, double* sine, double* cosine) {
  double turns = degrees / 90.0;
  double quarter = floor(turns + 0.5);
  double x = (degrees - quarter * 90.0) * 0.017453292519943295;
  double s = x, c = 1, term_s = x, term_c = 1;
  for (int i = 1; i <= 12; ++i) {
    term_c = -term_c * x * x / (double)((2 * i - 1) * (2 * i));
    term_s = -term_s * x * x / (double)((2 * i) * (2 * i + 1));
    c += term_c;
    s += term_s;
  }
  double quadrant = quarter - floor(quarter / 4.0) * 4.0;
  if (quadrant < 0.5) {
    *sine = s, *cosine = c;
  } else if (quadrant < 1.5) {
    *sine = c, *cosine = -s;
  } else if (quadrant < 2.5) {
    *sine = -s, *cosine = -c;
  } else {
    *sine = -c, *cosine = s;
  }
}

void scene_rotation_quaternion(const double degrees[3], double quaternion[4]) {
  double s[3], c[3];
  for (int i = 0; i < 3; ++i) sine_cosine(degrees[i] * 0.5, &s[i], &c[i]);
  /* qz * qy * qx: x first, about fixed axes. */
  quaternion[0] = s[0] * c[1] * c[2] - c[0] * s[1] * s[2];
  quaternion[1] = c[0] * s[1] * c[2] + s[0] * c[1] * s[2];
  quaternion[2] = c[0] * c[1] * s[2] - s[0] * s[1] * c[2];
  quaternion[3] = c[0] * c[1] * c[2] + s[0] * s[1] * s[2];
}

float scene_linear_from_srgb(float value) {
  return value <= 0.04045f ? value / 12.92f : powf((value + 0.055f) / 1.055f, 2.4f);
}

uint32_t scene_model_hash(uint32_t random) {
  random ^= random >> 16;
  random *= UINT32_C(0x45d9f3b);
  random ^= random >> 16;
  random *= UINT32_C(0x45d9f3b);
  return random ^ random >> 16;
}

void scene_stone_colour(const scene_palette* palette, uint32_t world_hash, float linear[3], uint32_t* base, float* shade) {
  uint32_t count = palette->colour_count > 0 ? palette->colour_count : 1;
  /* High bits choose the base colour, low ones the shade: the two must not go together. */
  uint32_t chosen = (uint32_t)((uint64_t)(world_hash >> 16) * count >> 16);
  float factor = 1.0f - (float)palette->variation * (float)(world_hash & 0xffffu) / 65535.0f;
  for (int i = 0; i < 3; ++i) linear[i] = scene_linear_from_srgb(palette->colours[chosen][i]) * factor;
  if (base != NULL) *base = chosen;
  if (shade != NULL) *shade = factor;
}
