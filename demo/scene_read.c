/* Scenes from JSON. Every limit here is a limit of content/schema/scene.schema.json too. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"
#include "json_reader.h"
#include "scene.h"

#define FILE_LIMIT ((size_t)16 << 20)

static const json_limits any_place = {-1e9, 1e9, false, false};
static const json_limits any_angle = {-36000, 36000, false, false};
static const json_limits positive = {0, 1e6, true, false};
static const json_limits not_negative = {0, 1e6, false, false};
static const json_limits any_height = {-1e5, 1e5, false, false};

/* Says "a number > 0" rather than naming the far limit, which nobody meets by mistake. */
static bool positive_number(json_reader* r, const cJSON* object, const char* key, double* out) {
  static const json_limits above_zero = {0, HUGE_VAL, true, false};
  return json_number(r, object, key, above_zero, out) && json_number(r, object, key, positive, out);
}

static bool require(json_reader* r, const cJSON* object, const char* key) {
  if (r->result != SCREE_OK) return false;
  return cJSON_GetObjectItemCaseSensitive(object, key) != NULL || json_fail(r, key, "key is missing");
}

static bool require_text(json_reader* r, const cJSON* object, const char* key, size_t capacity, char* out) {
  if (!require(r, object, key) || !json_string(r, object, key, capacity, out)) return false;
  return out[0] != '\0' || json_fail(r, key, "expected text, got \"\"");
}

static bool is_zero(const double v[3]) {
  return v[0] == 0 && v[1] == 0 && v[2] == 0;
}

static bool read_crop(json_reader* r, const cJSON* object, scene_height_map* out) {
  if (!json_integers(r, object, "crop", SCENE_CROP_MAX, 4, out->crop)) return false;
  bool cropped = cJSON_HasObjectItem(object, "crop");
  if (cropped && (out->crop[2] < 2 || out->crop[3] < 2)) return json_fail(r, "crop", "expected at least 2 columns and 2 rows");
  return true;
}

static bool read_height_map(json_reader* r, const cJSON* object, scene_height_map* out) {
  bool good = require_text(r, object, "file", sizeof out->file, out->file) &&
              positive_number(r, object, "spacing", &out->spacing) && json_number(r, object, "low", any_height, &out->low) &&
              json_number(r, object, "high", any_height, &out->high);
  if (!good) return false;
  if (!(out->low < out->high)) return json_fail(r, "high", "expected a number > low (%g), got %g", out->low, out->high);
  return read_crop(r, object, out);
}

static bool read_camera(json_reader* r, const cJSON* value, scene_camera* out) {
  static const char* const keys[] = {"eye", "target", "fov", NULL};
  static const json_limits fov = {1, 170, false, false};
  if (!json_check_object(r, value, keys, NULL) || !json_vector(r, value, "eye", any_place, 3, out->eye) ||
      !json_vector(r, value, "target", any_place, 3, out->target) || !json_number(r, value, "fov", fov, &out->fov))
    return false;
  double away[3];
  for (int i = 0; i < 3; ++i) away[i] = out->eye[i] - out->target[i];
  return !is_zero(away) || json_fail(r, "target", "expected another point than eye");
}

static bool read_sun(json_reader* r, const cJSON* value, scene_sun* out) {
  static const char* const keys[] = {"direction", "colour", NULL};
  static const json_limits any_direction = {-1e6, 1e6, false, false};
  if (!json_check_object(r, value, keys, NULL) || !json_vector(r, value, "direction", any_direction, 3, out->direction) ||
      !json_colour(r, value, "colour", out->colour))
    return false;
  return !is_zero(out->direction) || json_fail(r, "direction", "expected a vector that is not zero");
}

static bool read_water(json_reader* r, const cJSON* ground, scene_ground* out) {
  static const char* const keys[] = {"height", "colour", NULL};
  const cJSON* water = cJSON_GetObjectItemCaseSensitive(ground, "water");
  if (water == NULL) return true;
  size_t before = json_enter_key(r, "water");
  out->water = json_check_object(r, water, keys, NULL) && json_number(r, water, "height", any_place, &out->water_height) &&
               json_colour(r, water, "colour", out->water_colour);
  json_leave(r, before);
  return out->water;
}

static bool read_ground(json_reader* r, const cJSON* value, scene_ground* out) {
  static const char* const any[] = {"kind", "colour", "cover", NULL};
  static const char* const none[] = {NULL};
  static const char* const plane[] = {"height", NULL};
  static const char* const terrain[] = {"file", "spacing", "low", "high", "crop", "position", "water", NULL};
  char kind[16] = "plane";
  if (!cJSON_IsObject(value)) return json_fail_expected(r, NULL, "an object", value);
  if (!json_string(r, value, "kind", sizeof kind, kind)) return false;
  const char* const* keys;
  if (strcmp(kind, "none") == 0) {
    out->kind = SCENE_GROUND_NONE;
    keys = none;
  } else if (strcmp(kind, "plane") == 0) {
    out->kind = SCENE_GROUND_PLANE;
    keys = plane;
  } else if (strcmp(kind, "terrain") == 0) {
    out->kind = SCENE_GROUND_TERRAIN;
    keys = terrain;
  } else {
    return json_fail(r, "kind", "expected \"none\", \"plane\" or \"terrain\", got \"%s\"", kind);
  }
  char cover[16] = "grass";
  if (!json_check_object(r, value, any, keys) || !json_colour(r, value, "colour", out->colour) ||
      !json_string(r, value, "cover", sizeof cover, cover))
    return false;
  out->sand = strcmp(cover, "sand") == 0;
  if (!out->sand && strcmp(cover, "grass") != 0) return json_fail(r, "cover", "expected \"grass\" or \"sand\", got \"%s\"", cover);
  if (out->kind == SCENE_GROUND_PLANE) return json_number(r, value, "height", any_place, &out->height);
  if (out->kind == SCENE_GROUND_NONE) return true;
  return read_height_map(r, value, &out->map) && json_vector(r, value, "position", any_place, 3, out->position) &&
         read_water(r, value, out);
}

static bool read_palette(json_reader* r, const cJSON* value, scene_palette* out) {
  static const char* const keys[] = {"colours", "variation", NULL};
  static const json_limits share = {0, 1, false, false};
  if (!json_check_object(r, value, keys, NULL) || !json_number(r, value, "variation", share, &out->variation)) return false;
  const cJSON* colours = cJSON_GetObjectItemCaseSensitive(value, "colours");
  if (colours == NULL) return true;
  size_t before = json_enter_key(r, "colours");
  int count = cJSON_IsArray(colours) ? cJSON_GetArraySize(colours) : 0;
  bool good = count >= 1 && count <= SCENE_PALETTE_MAX;
  if (!good) {
    json_fail_expected(r, NULL, "an array of 1..8 colours", colours);
    colours = NULL;
  }
  out->colour_count = 0;
  const cJSON* item;
  cJSON_ArrayForEach(item, colours) {
    size_t element = json_enter_index(r, out->colour_count);
    good = good && json_colour_value(r, item, out->colours[out->colour_count++]);
    json_leave(r, element);
  }
  json_leave(r, before);
  return good;
}

static bool kind_from_name(const char* name, scree_shape_kind* out) {
  for (int kind = 0; kind <= SCREE_SHAPE_NOISE; ++kind) {
    const char* known = scene_kind_name((scree_shape_kind)kind);
    if (known != NULL && strcmp(known, name) == 0) {
      *out = (scree_shape_kind)kind;
      return true;
    }
  }
  return false;
}

static const char* const* keys_of_kind(scree_shape_kind kind) {
  static const char* const sphere[] = {"radius", NULL};
  static const char* const box[] = {"half", "rounding", NULL};
  static const char* const capsule[] = {"a", "b", "radius", NULL};
  static const char* const cylinder[] = {"radius", "half_height", NULL};
  static const char* const cone[] = {"radius", "height", NULL};
  static const char* const heightfield[] = {"file", "spacing", "low", "high", "crop", "above", "below", NULL};
  static const char* const mesh[] = {"file", "pack", "time", "lod", "resolution", NULL};
  static const char* const ellipsoid[] = {"radii", NULL};
  static const char* const half_space[] = {NULL};
  static const char* const torus[] = {"radius", "tube_radius", NULL};
  static const char* const extrusion[] = {"points", "low", "high", NULL};
  static const char* const tube[] = {"points", "closed", "subdivisions", "half_height", NULL};
  static const char* const blobs[] = {"points", NULL};
  static const char* const pattern[] = {"pattern", "spacing", "radius", "amplitude", "wavelength", NULL};
  static const char* const noise[] = {"child", "amplitude", "wavelength", "octaves", "seed", NULL};
  static const char* const group[] = {"children", NULL};
  static const char* const smooth[] = {"children", "blend", NULL};
  switch (kind) {
    case SCREE_SHAPE_SPHERE: return sphere;
    case SCREE_SHAPE_BOX: return box;
    case SCREE_SHAPE_CAPSULE: return capsule;
    case SCREE_SHAPE_CYLINDER: return cylinder;
    case SCREE_SHAPE_CONE: return cone;
    case SCREE_SHAPE_HEIGHTFIELD: return heightfield;
    case SCREE_SHAPE_MESH: return mesh;
    case SCREE_SHAPE_ELLIPSOID: return ellipsoid;
    case SCREE_SHAPE_HALF_SPACE: return half_space;
    case SCREE_SHAPE_TORUS: return torus;
    case SCREE_SHAPE_EXTRUSION: return extrusion;
    case SCREE_SHAPE_TUBE: return tube;
    case SCREE_SHAPE_BLOBS: return blobs;
    case SCREE_SHAPE_PATTERN: return pattern;
    case SCREE_SHAPE_SMOOTH_UNION: return smooth;
    case SCREE_SHAPE_NOISE: return noise;
    case SCREE_SHAPE_CALLBACK:
    case SCREE_SHAPE_UNION:
    case SCREE_SHAPE_INTERSECTION:
    case SCREE_SHAPE_DIFFERENCE: break;
  }
  return group;
}

static const json_limits any_coordinate = {-1e6, 1e6, false, false};

/* An integer that may be absent: *out stays as it is then. */
static bool small_integer(json_reader* r, const cJSON* object, const char* key, uint32_t min, uint32_t max, uint32_t* out) {
  uint64_t value = *out;
  if (!json_integer(r, object, key, min, max, &value)) return false;
  *out = (uint32_t)value;
  return true;
}

/* One point at the current path: `numbers` values, an extrusion's x and z or place and radius. */
static bool read_point(json_reader* r, const cJSON* item, uint32_t numbers, scene_point* out) {
  double values[4];
  char expected[48];
  snprintf(expected, sizeof expected, "an array of %u numbers", numbers);
  if (!cJSON_IsArray(item) || cJSON_GetArraySize(item) != (int)numbers) return json_fail_expected(r, NULL, expected, item);
  uint32_t i = 0;
  const cJSON* value;
  cJSON_ArrayForEach(value, item) {
    size_t before = json_enter_index(r, i);
    const bool good = json_number_value(r, value, i == 3 ? positive : any_coordinate, &values[i]);
    json_leave(r, before);
    if (!good) return false;
    ++i;
  }
  *out = numbers == 2 ? (scene_point){.place = {values[0], 0, values[1]}}
                      : (scene_point){.place = {values[0], values[1], values[2]}, .radius = values[3]};
  return true;
}

static bool read_points(json_reader* r, const cJSON* object, scene_node* node) {
  const scene_point_limits limits = scene_kind_points(node->kind);
  if (!require(r, object, "points")) return false;
  const cJSON* points = cJSON_GetObjectItemCaseSensitive(object, "points");
  const uint32_t count = cJSON_IsArray(points) ? (uint32_t)cJSON_GetArraySize(points) : 0;
  if (count < limits.least || count > limits.most) {
    char expected[48];
    snprintf(expected, sizeof expected, "an array of %u..%u points", limits.least, limits.most);
    return json_fail_expected(r, "points", expected, points);
  }
  scene_point* read = calloc(count, sizeof *read);
  if (read == NULL) return json_fail_memory(r);
  free(node->points);
  node->points = read;
  node->point_count = 0;
  size_t before = json_enter_key(r, "points");
  const cJSON* item;
  cJSON_ArrayForEach(item, points) {
    size_t element = json_enter_index(r, node->point_count);
    const bool good = read_point(r, item, node->kind == SCREE_SHAPE_EXTRUSION ? 2 : 4, &read[node->point_count]);
    json_leave(r, element);
    if (!good) break;
    ++node->point_count;
  }
  json_leave(r, before);
  return r->result == SCREE_OK;
}

static bool read_pattern(json_reader* r, const cJSON* value, scene_node* node) {
  char word[16] = "lines";
  if (!json_string(r, value, "pattern", sizeof word, word)) return false;
  int kind = SCREE_PATTERN_LINES;
  while (kind <= SCREE_PATTERN_WAVES && strcmp(scene_pattern_name((scree_pattern_kind)kind), word) != 0) ++kind;
  if (kind > SCREE_PATTERN_WAVES) return json_fail(r, "pattern", "expected lines, rings or waves, got \"%s\"", word);
  node->pattern.kind = (scree_pattern_kind)kind;
  return positive_number(r, value, "spacing", &node->pattern.spacing) &&
         positive_number(r, value, "radius", &node->pattern.radius) &&
         json_number(r, value, "amplitude", not_negative, &node->pattern.amplitude) &&
         positive_number(r, value, "wavelength", &node->pattern.wavelength);
}

static bool read_parameters(json_reader* r, const cJSON* value, scene_node* node) {
  switch (node->kind) {
    case SCREE_SHAPE_SPHERE: return positive_number(r, value, "radius", &node->sphere.radius);
    case SCREE_SHAPE_BOX: {
      double* half = node->box.half;
      if (!json_vector(r, value, "half", positive, 3, half) ||
          !json_number(r, value, "rounding", not_negative, &node->box.rounding))
        return false;
      double least = fmin(half[0], fmin(half[1], half[2]));
      return node->box.rounding <= least || json_fail(r, "rounding", "expected at most the smallest half extent, %g", least);
    }
    case SCREE_SHAPE_CAPSULE:
      return json_vector(r, value, "a", any_place, 3, node->capsule.a) &&
             json_vector(r, value, "b", any_place, 3, node->capsule.b) &&
             positive_number(r, value, "radius", &node->capsule.radius);
    case SCREE_SHAPE_CYLINDER:
      return positive_number(r, value, "radius", &node->cylinder.radius) &&
             positive_number(r, value, "half_height", &node->cylinder.half_height);
    case SCREE_SHAPE_CONE:
      return positive_number(r, value, "radius", &node->cone.radius) && positive_number(r, value, "height", &node->cone.height);
    case SCREE_SHAPE_HEIGHTFIELD:
      if (!read_height_map(r, value, &node->heightfield.map) ||
          !json_number(r, value, "above", any_height, &node->heightfield.above) ||
          !json_number(r, value, "below", any_height, &node->heightfield.below))
        return false;
      return node->heightfield.above + node->heightfield.below > 0 || json_fail(r, "below", "expected above + below > 0");
    case SCREE_SHAPE_MESH: {
      uint64_t resolution = 0, time = 0, lod = 1;
      if (cJSON_HasObjectItem(value, "pack")) {
        if (cJSON_HasObjectItem(value, "file")) return json_fail(r, "file", "expected a file or a pack, not both");
        if (!require_text(r, value, "pack", sizeof node->mesh.pack, node->mesh.pack) || !require(r, value, "time") ||
            !json_integer(r, value, "time", 0, 254, &time) || !json_integer(r, value, "lod", 0, 7, &lod))
          return false;
        node->mesh.time = (uint32_t)time;
        node->mesh.lod = (uint32_t)lod;
      } else if (cJSON_HasObjectItem(value, "time") || cJSON_HasObjectItem(value, "lod"))
        return json_fail(r, cJSON_HasObjectItem(value, "time") ? "time" : "lod", "a mesh of a file has none");
      else if (!require_text(r, value, "file", sizeof node->mesh.file, node->mesh.file))
        return false;
      if (!cJSON_HasObjectItem(value, "resolution")) return true;
      if (!json_integer(r, value, "resolution", 8, SCENE_MESH_RESOLUTION, &resolution)) return false;
      node->mesh.resolution = (uint32_t)resolution;
      return true;
    }
    case SCREE_SHAPE_ELLIPSOID: return json_vector(r, value, "radii", positive, 3, node->ellipsoid.radii);
    case SCREE_SHAPE_TORUS:
      return positive_number(r, value, "radius", &node->torus.radius) &&
             positive_number(r, value, "tube_radius", &node->torus.tube_radius);
    case SCREE_SHAPE_EXTRUSION:
      if (!read_points(r, value, node) || !json_number(r, value, "low", any_height, &node->extrusion.low) ||
          !json_number(r, value, "high", any_height, &node->extrusion.high))
        return false;
      return node->extrusion.low < node->extrusion.high ||
             json_fail(r, "high", "expected a number > low (%g), got %g", node->extrusion.low, node->extrusion.high);
    case SCREE_SHAPE_TUBE:
      return read_points(r, value, node) && json_bool(r, value, "closed", &node->tube.closed) &&
             small_integer(r, value, "subdivisions", 1, 32, &node->tube.subdivisions) &&
             json_number(r, value, "half_height", not_negative, &node->tube.half_height);
    case SCREE_SHAPE_BLOBS: return read_points(r, value, node);
    case SCREE_SHAPE_PATTERN: return read_pattern(r, value, node);
    case SCREE_SHAPE_SMOOTH_UNION: return positive_number(r, value, "blend", &node->group.blend);
    case SCREE_SHAPE_NOISE:
      return positive_number(r, value, "amplitude", &node->noise.amplitude) &&
             positive_number(r, value, "wavelength", &node->noise.wavelength) &&
             small_integer(r, value, "octaves", 1, 8, &node->noise.octaves) &&
             small_integer(r, value, "seed", 0, UINT32_MAX, &node->noise.seed);
    case SCREE_SHAPE_HALF_SPACE:
    case SCREE_SHAPE_CALLBACK:
    case SCREE_SHAPE_UNION:
    case SCREE_SHAPE_INTERSECTION:
    case SCREE_SHAPE_DIFFERENCE: break;
  }
  return true;
}

static scene_node* read_node(json_reader* r, const cJSON* value, uint32_t depth, uint32_t* nodes);

/* Hands a child that was read to its parent. */
static void take_child(json_reader* r, scene_node* parent, scene_node* child) {
  if (child == NULL || scene_node_add(parent, child)) return;
  scene_node_destroy(child);
  json_fail_memory(r);
}

/* The one child of noise. */
static bool read_child(json_reader* r, const cJSON* value, uint32_t depth, uint32_t* nodes, scene_node* parent) {
  if (!require(r, value, "child")) return false;
  size_t before = json_enter_key(r, "child");
  take_child(r, parent, read_node(r, cJSON_GetObjectItemCaseSensitive(value, "child"), depth + 1, nodes));
  json_leave(r, before);
  return r->result == SCREE_OK;
}

static bool read_children(json_reader* r, const cJSON* value, uint32_t depth, uint32_t* nodes, scene_node* parent) {
  if (!require(r, value, "children")) return false;
  const cJSON* children = cJSON_GetObjectItemCaseSensitive(value, "children");
  if (!cJSON_IsArray(children) || children->child == NULL)
    return json_fail_expected(r, "children", "an array of at least one shape", children);
  size_t before = json_enter_key(r, "children");
  const cJSON* item;
  cJSON_ArrayForEach(item, children) {
    size_t element = json_enter_index(r, parent->child_count);
    take_child(r, parent, read_node(r, item, depth + 1, nodes));
    json_leave(r, element);
    if (r->result != SCREE_OK) break;
  }
  json_leave(r, before);
  return r->result == SCREE_OK;
}

static scene_node* read_node(json_reader* r, const cJSON* value, uint32_t depth, uint32_t* nodes) {
  static const char* const any[] = {"shape", "name", "position", "rotation", "scale", NULL};
  char word[16] = "";
  scree_shape_kind kind;
  if (r->result != SCREE_OK) return NULL;
  if (!cJSON_IsObject(value)) {
    json_fail_expected(r, NULL, "an object", value);
    return NULL;
  }
  if (depth >= SCENE_DEPTH_MAX || ++*nodes > SCENE_NODES_MAX) {
    json_fail(r, NULL, "expected at most %d levels and %d shapes", SCENE_DEPTH_MAX, SCENE_NODES_MAX);
    return NULL;
  }
  if (!require(r, value, "shape") || !json_string(r, value, "shape", sizeof word, word)) return NULL;
  if (!kind_from_name(word, &kind)) {
    json_fail(r, "shape",
              "expected sphere, box, capsule, cylinder, cone, heightfield, mesh, ellipsoid, half_space, torus, extrusion, tube, "
              "blobs, pattern, union, intersection, difference, smooth_union or noise, got \"%s\"",
              word);
    return NULL;
  }
  if (!json_check_object(r, value, any, keys_of_kind(kind))) return NULL;
  scene_node* node = scene_node_create(kind);
  if (node == NULL) {
    json_fail_memory(r);
    return NULL;
  }
  bool good = json_string(r, value, "name", sizeof node->name, node->name) &&
              json_vector(r, value, "position", any_place, 3, node->position) &&
              json_vector(r, value, "rotation", any_angle, 3, node->rotation) && positive_number(r, value, "scale", &node->scale) &&
              read_parameters(r, value, node);
  if (good && scene_kind_is_group(kind)) good = read_children(r, value, depth, nodes, node);
  if (good && kind == SCREE_SHAPE_NOISE) good = read_child(r, value, depth, nodes, node);
  if (good) return node;
  scene_node_destroy(node);
  return NULL;
}

static const char* const* keys_of_filter(scree_filter_kind kind) {
  static const char* const mask[] = {"file", "spacing", "crop", "position", NULL};
  static const char* const slope[] = {"file", "spacing", "low", "high", "crop", "position", "from", "to", "fade", NULL};
  static const char* const altitude[] = {"from", "to", "fade", NULL};
  return kind == SCREE_FILTER_MASK ? mask : kind == SCREE_FILTER_SLOPE ? slope : altitude;
}

static bool read_filter(json_reader* r, const cJSON* value, scene_field* field) {
  static const char* const any[] = {"filter", "inverted", NULL};
  static const json_limits degrees = {0, 90, false, false};
  char word[16] = "";
  if (!cJSON_IsObject(value)) return json_fail_expected(r, NULL, "an object", value);
  if (!require(r, value, "filter") || !json_string(r, value, "filter", sizeof word, word)) return false;
  int kind = SCREE_FILTER_MASK;
  while (kind <= SCREE_FILTER_ALTITUDE && strcmp(scene_filter_name((scree_filter_kind)kind), word) != 0) ++kind;
  if (kind > SCREE_FILTER_ALTITUDE) return json_fail(r, "filter", "expected mask, slope or altitude, got \"%s\"", word);
  if (!json_check_object(r, value, any, keys_of_filter((scree_filter_kind)kind))) return false;
  scene_filter* out = scene_add_filter(field, (scree_filter_kind)kind);
  if (out == NULL) return json_fail_memory(r);
  if (!json_bool(r, value, "inverted", &out->inverted)) return false;
  if (kind != SCREE_FILTER_ALTITUDE && !json_vector(r, value, "position", any_place, 3, out->position)) return false;
  if (kind == SCREE_FILTER_MASK)
    return require_text(r, value, "file", sizeof out->map.file, out->map.file) &&
           positive_number(r, value, "spacing", &out->map.spacing) && read_crop(r, value, &out->map);
  if (kind == SCREE_FILTER_SLOPE && !read_height_map(r, value, &out->map)) return false;
  const json_limits limits = kind == SCREE_FILTER_SLOPE ? degrees : any_place;
  if (!json_number(r, value, "from", limits, &out->from) || !json_number(r, value, "to", limits, &out->to) ||
      !json_number(r, value, "fade", not_negative, &out->fade))
    return false;
  return out->from <= out->to || json_fail(r, "to", "expected a number >= from (%g), got %g", out->from, out->to);
}

static bool read_filters(json_reader* r, const cJSON* value, scene_field* out) {
  if (!cJSON_IsArray(value) || cJSON_GetArraySize(value) > SCENE_FILTERS_MAX)
    return json_fail_expected(r, NULL, "an array of at most 16 filters", value);
  const cJSON* item;
  uint32_t index = 0;
  cJSON_ArrayForEach(item, value) {
    size_t before = json_enter_index(r, index++);
    const bool good = read_filter(r, item, out);
    json_leave(r, before);
    if (!good) return false;
  }
  return true;
}

/* Layers are told apart by their keys. */
static bool check_key(json_reader* r, const scene_model* scene, uint32_t index) {
  for (uint32_t i = 0; i < index; ++i)
    if (scene_field_key(scene, i) == scene_field_key(scene, index))
      return json_fail(r, "key", "fields[%u] has the key %u already", i, scene_field_key(scene, index));
  return true;
}

/* What a mass of rock has and a scatter has not. */
static bool read_rocks(json_reader* r, const cJSON* value, scene_field* out) {
  static const json_limits share = {0, 1, true, true};
  return require_text(r, value, "pack", sizeof out->pack, out->pack) && positive_number(r, value, "cell_size", &out->cell_size) &&
         json_number(r, value, "threshold", share, &out->threshold) && json_bool(r, value, "shell", &out->shell);
}

static bool read_models(json_reader* r, const cJSON* models, scene_scatter* out) {
  const int count = cJSON_IsArray(models) ? cJSON_GetArraySize(models) : 0;
  if (count < 1 || count > SCENE_MODELS_MAX) return json_fail_expected(r, NULL, "an array of 1..64 files", models);
  if (!scene_set_models(out, (uint32_t)count)) return json_fail_memory(r);
  uint32_t i = 0;
  const cJSON* item;
  cJSON_ArrayForEach(item, models) {
    size_t before = json_enter_index(r, i);
    const bool good = json_string_value(r, item, SCENE_FILE_SIZE, out->models[i]) &&
                      (out->models[i][0] != '\0' || json_fail(r, NULL, "expected text, got \"\""));
    json_leave(r, before);
    if (!good) return false;
    ++i;
  }
  return true;
}

static bool read_weights(json_reader* r, const cJSON* weights, scene_scatter* out) {
  const int count = cJSON_IsArray(weights) ? cJSON_GetArraySize(weights) : 0;
  if (count < 1 || count > SCENE_WEIGHTS_MAX) return json_fail_expected(r, NULL, "an array of 1..256 numbers", weights);
  if (!scene_set_weights(out, (uint32_t)count)) return json_fail_memory(r);
  double sum = 0;
  uint32_t i = 0;
  const cJSON* item;
  cJSON_ArrayForEach(item, weights) {
    size_t before = json_enter_index(r, i);
    const bool good = json_number_value(r, item, not_negative, &out->weights[i]);
    json_leave(r, before);
    if (!good) return false;
    sum += out->weights[i++];
  }
  return sum > 0 || json_fail(r, NULL, "expected one number that is not 0");
}

static bool read_ages(json_reader* r, const cJSON* value, scene_scatter* out) {
  static const char* const keys[] = {"file", "spacing", "crop", "position", "inverted", NULL};
  scene_filter* ages = &out->ages;
  out->has_ages = true;
  return json_check_object(r, value, keys, NULL) && require_text(r, value, "file", sizeof ages->map.file, ages->map.file) &&
         positive_number(r, value, "spacing", &ages->map.spacing) && read_crop(r, value, &ages->map) &&
         json_vector(r, value, "position", any_place, 3, ages->position) && json_bool(r, value, "inverted", &ages->inverted);
}

static bool read_scatter(json_reader* r, const cJSON* value, scene_field* out) {
  static const json_limits slope = {0, 80, true, false};
  static bool (*const readers[])(json_reader*, const cJSON*, scene_scatter*) = {read_models, read_weights, read_ages};
  static const char* const parts[] = {"models", "weights", "ages"};
  scene_scatter* s = &out->scatter;
  out->is_scatter = true;
  out->pack[0] = '\0';
  if (cJSON_HasObjectItem(value, "models")) {
    if (cJSON_HasObjectItem(value, "pack")) return json_fail(r, "models", "a scatter has a pack or models, not both");
    if (cJSON_HasObjectItem(value, "ages")) return json_fail(r, "ages", "only models of a pack have ages");
  } else if (!require_text(r, value, "pack", sizeof out->pack, out->pack)) {
    return false;
  }
  if (!require(r, value, "spacing") || !positive_number(r, value, "spacing", &s->spacing) ||
      !json_vector(r, value, "scale", positive, 2, s->scale) || !json_number(r, value, "max_slope", slope, &s->max_slope))
    return false;
  if (s->scale[0] > s->scale[1])
    return json_fail(r, "scale", "expected the smaller number first, got [%g, %g]", s->scale[0], s->scale[1]);
  for (int i = 0; i < 3; ++i) {
    const cJSON* part = cJSON_GetObjectItemCaseSensitive(value, parts[i]);
    if (part == NULL) continue;
    size_t before = json_enter_key(r, parts[i]);
    const bool good = readers[i](r, part, s);
    json_leave(r, before);
    if (!good) return false;
  }
  return true;
}

static bool read_cliff(json_reader* r, const cJSON* value, scene_field* out) {
  static const json_limits turn = {-360, 360, false, false};
  uint64_t time = 0;
  out->is_cliff = true;
  if (!require_text(r, value, "pack", sizeof out->pack, out->pack) || !json_integer(r, value, "time", 0, 254, &time) ||
      !json_number(r, value, "turn", turn, &out->cliff.turn) || !positive_number(r, value, "scale", &out->cliff.scale))
    return false;
  out->cliff.time = (uint32_t)time;
  char what[16] = "all";
  if (!json_string(r, value, "what", sizeof what, what)) return false;
  if (strcmp(what, "all") == 0) return true;
  out->cliff.what = strcmp(what, "standing") == 0 ? SCREE_CLIFF_STANDING : strcmp(what, "blocks") == 0 ? SCREE_CLIFF_BLOCKS : 0;
  return out->cliff.what != 0 || json_fail(r, "what", "expected all, standing or blocks");
}

static bool read_field(json_reader* r, const cJSON* value, scene_field* out) {
  static const char* const keys[] = {"name", "pack", "seed", "origin", "palette", "key", NULL};
  static const char* const rocks[] = {"support", "density", "filters", "cell_size", "threshold", "shell", NULL};
  static const char* const scatter[] = {"support", "density",   "filters", "models", "spacing",
                                        "scale",   "max_slope", "weights", "ages",   NULL};
  static const char* const cliff[] = {"time", "turn", "scale", "what", NULL};
  static const json_limits density = {0, 1, true, false};
  const bool scattered = cJSON_HasObjectItem(value, "spacing") || cJSON_HasObjectItem(value, "models");
  const bool is_cliff = cJSON_HasObjectItem(value, "time");
  bool good = json_check_object(r, value, keys,
                                is_cliff    ? cliff
                                : scattered ? scatter
                                            : rocks) &&
              json_string(r, value, "name", sizeof out->name, out->name) &&
              json_integer(r, value, "seed", 0, UINT64_C(1) << 53, &out->seed) &&
              json_vector(r, value, "origin", any_place, 3, out->origin) &&
              json_number(r, value, "density", density, &out->density) &&
              (is_cliff    ? read_cliff(r, value, out)
               : scattered ? read_scatter(r, value, out)
                           : read_rocks(r, value, out));
  uint64_t number = 0;
  if (good && cJSON_HasObjectItem(value, "key")) {
    good = json_integer(r, value, "key", 0, UINT16_MAX, &number);
    out->key = (int32_t)number;
  }
  const cJSON* filters = good ? cJSON_GetObjectItemCaseSensitive(value, "filters") : NULL;
  if (filters != NULL) {
    size_t before = json_enter_key(r, "filters");
    good = read_filters(r, filters, out);
    json_leave(r, before);
  }
  const cJSON* palette = good ? cJSON_GetObjectItemCaseSensitive(value, "palette") : NULL;
  if (palette != NULL) {
    size_t before = json_enter_key(r, "palette");
    good = read_palette(r, palette, &out->palette);
    json_leave(r, before);
  }
  if (good && is_cliff) return true;
  if (!good || !require(r, value, "support")) return false;
  uint32_t nodes = 0;
  size_t before = json_enter_key(r, "support");
  out->support = read_node(r, cJSON_GetObjectItemCaseSensitive(value, "support"), 0, &nodes);
  json_leave(r, before);
  return out->support != NULL;
}

static bool read_fields(json_reader* r, const cJSON* root, scene_model* out) {
  if (!require(r, root, "fields")) return false;
  const cJSON* fields = cJSON_GetObjectItemCaseSensitive(root, "fields");
  if (!cJSON_IsArray(fields) || cJSON_GetArraySize(fields) > SCENE_FIELDS_MAX)
    return json_fail_expected(r, "fields", "an array of at most 64 fields", fields);
  size_t before = json_enter_key(r, "fields");
  const cJSON* item;
  cJSON_ArrayForEach(item, fields) {
    size_t element = json_enter_index(r, out->field_count);
    scene_field* field = scene_add_field(out);
    if (field == NULL) {
      json_fail_memory(r);
    } else {
      if (read_field(r, item, field)) check_key(r, out, out->field_count - 1);
    }
    json_leave(r, element);
    if (r->result != SCREE_OK) break;
  }
  json_leave(r, before);
  return r->result == SCREE_OK;
}

static bool read_scene(json_reader* r, const cJSON* root, scene_model* out) {
  static const char* const keys[] = {"$schema", "name", "camera", "sun", "sky", "ground", "fields", NULL};
  if (!json_check_object(r, root, keys, NULL) || !json_string(r, root, "$schema", sizeof out->schema, out->schema) ||
      !json_string(r, root, "name", sizeof out->name, out->name))
    return false;
  bool good = true;
  const cJSON* camera = cJSON_GetObjectItemCaseSensitive(root, "camera");
  if (camera != NULL) {
    size_t before = json_enter_key(r, "camera");
    good = read_camera(r, camera, &out->camera);
    json_leave(r, before);
  }
  const cJSON* sun = cJSON_GetObjectItemCaseSensitive(root, "sun");
  if (good && sun != NULL) {
    size_t before = json_enter_key(r, "sun");
    good = read_sun(r, sun, &out->sun);
    json_leave(r, before);
  }
  good = good && json_colour(r, root, "sky", out->sky);
  const cJSON* ground = cJSON_GetObjectItemCaseSensitive(root, "ground");
  if (good && ground != NULL) {
    size_t before = json_enter_key(r, "ground");
    good = read_ground(r, ground, &out->ground);
    json_leave(r, before);
  }
  return good && read_fields(r, root, out);
}

scree_result scene_parse(const char* text, size_t size, const char* file, scene_model* out, scree_error* error) {
  scene_init(out);
  json_reader reader = {.file = file, .error = error};
  char* copy = malloc(size + 1);
  if (copy == NULL) {
    json_fail_memory(&reader);
    return reader.result;
  }
  memcpy(copy, text, size);
  copy[size] = '\0';
  cJSON* root = json_parse(&reader, copy, size);
  if (root != NULL) read_scene(&reader, root, out);
  cJSON_Delete(root);
  free(copy);
  if (reader.result != SCREE_OK) scene_destroy(out);
  return reader.result;
}

scree_result scene_load(const char* file, scene_model* out, scree_error* error) {
  memset(out, 0, sizeof *out);
  char* text;
  size_t size;
  scree_result result = file_read(file, FILE_LIMIT, &text, &size, error);
  if (result != SCREE_OK) return result;
  result = scene_parse(text, size, file, out, error);
  free(text);
  return result;
}
