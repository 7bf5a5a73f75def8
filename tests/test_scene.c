/* Scenes: what is read is what is written, and every kind of wrong scene is refused with a line that names the place. */
#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* after the four above */
#include <cjson/cJSON.h>
#include <cmocka.h>

#include "lattice.h"
#include "scene.h"

static const char everything[] =
    "{\"$schema\": \"../schema/scene.schema.json\", \"name\": \"All \\u00e9 \\\"keys\\\"\","
    "\"camera\": {\"eye\": [1, 2, 3.25], \"target\": [0, 0.1, -1e-7], \"fov\": 50},"
    "\"sun\": {\"direction\": [0.3, 1, 0], \"colour\": \"#fff0E0\"}, \"sky\": \"#8090a0\","
    "\"ground\": {\"kind\": \"terrain\", \"colour\": \"#102030\", \"cover\": \"sand\", \"file\": \"a/b.png\", \"spacing\": 30, "
    "\"low\": -5, \"high\": "
    "1000,"
    " \"crop\": [1, 2, 30, 40], \"position\": [0, -300, 0], \"water\": {\"height\": 12.5, \"colour\": \"#203040\"}},"
    "\"fields\": [{\"name\": \"f\", \"pack\": \"boulders\", \"seed\": 9007199254740992, \"cell_size\": 0.6, \"origin\": [0.1, 0, "
    "0],"
    " \"threshold\": 0.25, \"shell\": false, \"palette\": {\"colours\": [\"#010203\", \"#aabbcc\"], \"variation\": 0.5},"
    " \"key\": 1, \"density\": 0.875, \"filters\": ["
    "  {\"filter\": \"mask\", \"file\": \"m.png\", \"spacing\": 0.5, \"crop\": [1, 2, 3, 4], \"position\": [5, 6, 7], "
    "\"inverted\": true},"
    "  {\"filter\": \"slope\", \"file\": \"t.png\", \"low\": -3, \"high\": 30, \"from\": 20, \"to\": 45, \"fade\": 5},"
    "  {\"filter\": \"altitude\", \"from\": -10, \"to\": 1e6, \"fade\": 2.5}],"
    " \"support\": {\"shape\": \"difference\", \"name\": \"root\", \"position\": [1e6, 0, 0], \"children\": ["
    "  {\"shape\": \"smooth_union\", \"blend\": 0.75, \"rotation\": [0, 45, -30], \"children\": ["
    "   {\"shape\": \"sphere\", \"radius\": 2}, {\"shape\": \"box\", \"half\": [1, 2, 3], \"rounding\": 0.5},"
    "   {\"shape\": \"capsule\", \"a\": [0, 1, 0], \"b\": [0, 2, 0], \"radius\": 0.3},"
    "   {\"shape\": \"cylinder\", \"radius\": 1.5, \"half_height\": 2.5}, {\"shape\": \"cone\", \"radius\": 3, \"height\": 4}]},"
    "  {\"shape\": \"heightfield\", \"file\": \"h.png\", \"spacing\": 2, \"low\": 0, \"high\": 10, \"above\": 1, \"below\": 0.5},"
    "  {\"shape\": \"mesh\", \"file\": \"m.off\", \"resolution\": 64, \"scale\": 12},"
    "  {\"shape\": \"ellipsoid\", \"radii\": [1, 2, 3]}, {\"shape\": \"torus\", \"radius\": 2, \"tube_radius\": 0.5},"
    "  {\"shape\": \"extrusion\", \"points\": [[0, 0], [1, 0.5], [0, 1]], \"low\": -1, \"high\": 2},"
    "  {\"shape\": \"tube\", \"points\": [[0, 1, 2, 0.5], [3, 4, 5, 0.25], [6, 7, 8, 0.125]], \"closed\": true,"
    "   \"subdivisions\": 12, \"half_height\": 0.75},"
    "  {\"shape\": \"blobs\", \"points\": [[9, 8, 7, 6]]},"
    "  {\"shape\": \"pattern\", \"pattern\": \"waves\", \"spacing\": 0.5, \"radius\": 0.1, \"amplitude\": 0.3, \"wavelength\": 4},"
    "  {\"shape\": \"noise\", \"amplitude\": 0.2, \"wavelength\": 3, \"octaves\": 4, \"seed\": 4294967295,"
    "   \"child\": {\"shape\": \"intersection\", \"children\": [{\"shape\": \"half_space\"}, {\"shape\": \"pattern\"}]}},"
    "  {\"shape\": \"union\", \"children\": [{\"shape\": \"sphere\"}]},"
    "  {\"shape\": \"intersection\", \"children\": [{\"shape\": \"box\"}]},"
    "  {\"shape\": \"mesh\", \"pack\": \"hill_cave\", \"time\": 2, \"lod\": 3, \"rotation\": [0, 90, 0]}]}},"
    " {\"pack\": \"x.scree\", \"key\": 0, \"support\": {\"shape\": \"cone\"}},"
    " {\"pack\": \"goblin\", \"spacing\": 3.5, \"seed\": 4, \"scale\": [0.75, 1.25], \"max_slope\": 30, \"weights\": [0.5, 0, 2],"
    "  \"ages\": {\"file\": \"ages.png\", \"spacing\": 2, \"crop\": [1, 2, 3, 4], \"position\": [5, 0, 6], \"inverted\": true},"
    "  \"density\": 0.5, \"filters\": [{\"filter\": \"altitude\", \"to\": 9}], \"support\": {\"shape\": \"box\"}},"
    " {\"models\": [\"tree.glb\", \"a/bush.gltf\"], \"spacing\": 2, \"support\": {\"shape\": \"sphere\"}},"
    " {\"pack\": \"hill_cave\", \"time\": 3, \"origin\": [1, 2, -3], \"turn\": -45.5, \"scale\": 2, \"seed\": 6, \"what\": "
    "\"blocks\"}]}";

static scree_result parse(const char* text, scene_model* scene, scree_error* error) {
  return scene_parse(text, strlen(text), "s.json", scene, error);
}

static void every_key_is_read(void** state) {
  (void)state;
  scene_model scene;
  scree_error error = {""};
  scree_result result = parse(everything, &scene, &error);
  assert_string_equal(error.message, "");
  assert_int_equal(result, SCREE_OK);
  assert_string_equal(scene.name, "All \xc3\xa9 \"keys\"");
  assert_true(scene.camera.eye[2] == 3.25 && scene.camera.target[2] == -1e-7 && scene.camera.fov == 50);
  assert_true(scene.sun.colour[2] == 224 / 255.0f);
  assert_int_equal(scene.ground.kind, SCENE_GROUND_TERRAIN);
  assert_string_equal(scene.ground.map.file, "a/b.png");
  assert_true(scene.ground.map.low == -5 && scene.ground.map.crop[3] == 40 && scene.ground.position[1] == -300);
  assert_true(scene.ground.water && scene.ground.water_height == 12.5 && scene.ground.water_colour[1] == 48 / 255.0f);
  assert_int_equal(scene.field_count, 5);
  const scene_field* field = &scene.fields[0];
  assert_true(field->seed == UINT64_C(9007199254740992) && field->cell_size == 0.6 && field->threshold == 0.25 && !field->shell);
  assert_true(field->palette.colour_count == 2 && field->palette.variation == 0.5);
  assert_true(field->key == 1 && field->density == 0.875 && field->filter_count == 3);
  assert_true(scene_field_key(&scene, 0) == 1 && scene_field_key(&scene, 1) == 0);
  const scene_filter* filters = field->filters;
  assert_true(filters[0].kind == SCREE_FILTER_MASK && filters[0].inverted && filters[0].map.crop[3] == 4);
  assert_true(filters[0].position[2] == 7 && filters[0].map.low == 0 && filters[0].map.high == 1);
  assert_string_equal(filters[1].map.file, "t.png");
  assert_true(filters[1].kind == SCREE_FILTER_SLOPE && !filters[1].inverted && filters[1].map.low == -3 && filters[1].to == 45);
  assert_true(filters[2].kind == SCREE_FILTER_ALTITUDE && filters[2].from == -10 && filters[2].fade == 2.5);
  assert_int_equal(field->support->kind, SCREE_SHAPE_DIFFERENCE);
  assert_int_equal(field->support->child_count, 13);
  const scene_node* smooth = field->support->children[0];
  assert_true(smooth->group.blend == 0.75 && smooth->rotation[2] == -30 && smooth->child_count == 5);
  assert_true(smooth->children[1]->box.half[2] == 3 && smooth->children[1]->box.rounding == 0.5);
  assert_true(smooth->children[2]->capsule.b[1] == 2 && smooth->children[3]->cylinder.half_height == 2.5);
  assert_true(field->support->children[2]->scale == 12 && field->support->children[2]->mesh.resolution == 64);
  scene_node* const* children = field->support->children;
  assert_true(children[3]->ellipsoid.radii[1] == 2 && children[4]->torus.tube_radius == 0.5);
  assert_true(children[5]->point_count == 3 && children[5]->points[1].place[0] == 1 && children[5]->points[1].place[2] == 0.5);
  assert_true(children[5]->extrusion.low == -1 && children[5]->extrusion.high == 2);
  assert_true(children[6]->point_count == 3 && children[6]->points[2].place[1] == 7 && children[6]->points[2].radius == 0.125);
  assert_true(children[6]->tube.closed && children[6]->tube.subdivisions == 12 && children[6]->tube.half_height == 0.75);
  assert_true(children[7]->point_count == 1 && children[7]->points[0].place[0] == 9 && children[7]->points[0].radius == 6);
  assert_true(children[8]->pattern.kind == SCREE_PATTERN_WAVES && children[8]->pattern.wavelength == 4);
  assert_true(children[9]->noise.seed == UINT32_MAX && children[9]->noise.octaves == 4 && children[9]->child_count == 1);
  assert_int_equal(children[9]->children[0]->children[0]->kind, SCREE_SHAPE_HALF_SPACE);
  assert_string_equal(children[12]->mesh.pack, "hill_cave");
  assert_true(children[12]->mesh.time == 2 && children[12]->mesh.lod == 3 && children[12]->mesh.file[0] == '\0');
  assert_true(scene.fields[1].shell && scene.fields[1].threshold == 0.5 && scene.fields[1].palette.colour_count == 4);
  assert_false(scene.fields[0].is_scatter || scene.fields[1].is_scatter);
  const scene_field* hoodoos = &scene.fields[2];
  assert_true(hoodoos->is_scatter && hoodoos->scatter.spacing == 3.5 && hoodoos->scatter.max_slope == 30 && hoodoos->seed == 4);
  assert_true(hoodoos->scatter.scale[0] == 0.75 && hoodoos->scatter.scale[1] == 1.25 && hoodoos->density == 0.5);
  assert_true(hoodoos->scatter.weight_count == 3 && hoodoos->scatter.weights[2] == 2 && hoodoos->filter_count == 1);
  assert_true(hoodoos->scatter.has_ages && hoodoos->scatter.ages.inverted && hoodoos->scatter.ages.map.crop[2] == 3);
  assert_true(hoodoos->scatter.ages.position[2] == 6 && hoodoos->scatter.ages.map.spacing == 2);
  assert_string_equal(hoodoos->scatter.ages.map.file, "ages.png");
  const scene_field* trees = &scene.fields[3];
  assert_true(trees->is_scatter && trees->scatter.model_count == 2 && !trees->scatter.has_ages && trees->scatter.max_slope == 45);
  assert_string_equal(trees->scatter.models[1], "a/bush.gltf");
  assert_string_equal(trees->pack, "");
  const scene_field* cliff = &scene.fields[4];
  assert_true(cliff->is_cliff && !cliff->is_scatter && !trees->is_cliff && cliff->support == NULL);
  assert_true(cliff->cliff.time == 3 && cliff->cliff.turn == -45.5 && cliff->cliff.scale == 2 &&
              cliff->cliff.what == SCREE_CLIFF_BLOCKS && cliff->origin[2] == -3);
  scene_destroy(&scene);
}

static void written_scene_reads_back_the_same(void** state) {
  (void)state;
  scene_model scene, again;
  assert_int_equal(parse(everything, &scene, NULL), SCREE_OK);
  size_t size;
  char* first = scene_write(&scene, &size);
  assert_int_equal(size, strlen(first));
  scree_error error = {""};
  scree_result result = parse(first, &again, &error);
  assert_string_equal(error.message, "");
  assert_int_equal(result, SCREE_OK);
  char* second = scene_write(&again, NULL);
  assert_string_equal(first, second);
  assert_non_null(strstr(first, "\"seed\": 9007199254740992"));
  assert_non_null(strstr(first, "\"cell_size\": 0.6,"));
  assert_non_null(strstr(first, "\"colour\": \"#fff0e0\""));
  free(first);
  free(second);
  scene_destroy(&scene);
  scene_destroy(&again);
}

/* Every value of `source` stands in `written` too, which may have more keys. Colours may differ in case. */
static void assert_kept(const cJSON* source, const cJSON* written, const char* key) {
  if (written == NULL || (source->type & 0xff) != (written->type & 0xff)) fail_msg("%s is not kept", key);
  if (cJSON_IsNumber(source) && source->valuedouble != written->valuedouble) fail_msg("%s is not kept", key);
  if (cJSON_IsString(source) && strcasecmp(source->valuestring, written->valuestring) != 0) fail_msg("%s is not kept", key);
  if (cJSON_IsArray(source)) assert_int_equal(cJSON_GetArraySize(source), cJSON_GetArraySize(written));
  int index = 0;
  const cJSON* item;
  cJSON_ArrayForEach(item, source) {
    const cJSON* other =
        cJSON_IsArray(source) ? cJSON_GetArrayItem(written, index++) : cJSON_GetObjectItemCaseSensitive(written, item->string);
    assert_kept(item, other, item->string != NULL ? item->string : key);
  }
}

static void writing_keeps_every_value(void** state) {
  (void)state;
  scene_model scene;
  assert_int_equal(parse(everything, &scene, NULL), SCREE_OK);
  char* text = scene_write(&scene, NULL);
  cJSON* source = cJSON_Parse(everything);
  cJSON* written = cJSON_Parse(text);
  assert_kept(source, written, "scene");
  cJSON_Delete(source);
  cJSON_Delete(written);
  free(text);
  scene_destroy(&scene);
}

static double random_number(uint64_t* seed, double min, double max) {
  *seed += UINT64_C(0x9e3779b97f4a7c15);
  return min + (max - min) * (double)(hash_mix(*seed) >> 11) / 9007199254740992.0;
}

static scene_node* random_node(uint64_t* seed, uint32_t depth) {
  static const scree_shape_kind kinds[] = {
      SCREE_SHAPE_SPHERE,     SCREE_SHAPE_BOX,          SCREE_SHAPE_CAPSULE,      SCREE_SHAPE_CYLINDER,  SCREE_SHAPE_CONE,
      SCREE_SHAPE_ELLIPSOID,  SCREE_SHAPE_TORUS,        SCREE_SHAPE_HALF_SPACE,   SCREE_SHAPE_EXTRUSION, SCREE_SHAPE_TUBE,
      SCREE_SHAPE_BLOBS,      SCREE_SHAPE_PATTERN,      SCREE_SHAPE_HEIGHTFIELD,  SCREE_SHAPE_MESH,      SCREE_SHAPE_UNION,
      SCREE_SHAPE_DIFFERENCE, SCREE_SHAPE_INTERSECTION, SCREE_SHAPE_SMOOTH_UNION, SCREE_SHAPE_NOISE};
  enum { KINDS = sizeof kinds / sizeof *kinds, LEAVES = 14 };
  scene_node* node = scene_node_create(kinds[(uint32_t)random_number(seed, 0, depth < 4 ? KINDS : LEAVES)]);
  for (int i = 0; i < 3; ++i) {
    node->position[i] = random_number(seed, -100, 100);
    node->rotation[i] = random_number(seed, -360, 360);
  }
  node->scale = random_number(seed, 0.001, 100);
  snprintf(node->name, sizeof node->name, "node %d", (int)node->kind);
  switch (node->kind) {
    case SCREE_SHAPE_SPHERE: node->sphere.radius = random_number(seed, 0.1, 9); break;
    case SCREE_SHAPE_BOX: node->box.half[1] = random_number(seed, 0.1, 9); break;
    case SCREE_SHAPE_HEIGHTFIELD: strcpy(node->heightfield.map.file, "map.png"); break;
    case SCREE_SHAPE_MESH: strcpy(node->mesh.file, "mesh \\ \"x\".obj"); break;
    case SCREE_SHAPE_PATTERN: node->pattern.kind = (scree_pattern_kind)random_number(seed, 0, 3); break;
    default: break;
  }
  const bool flat = node->kind == SCREE_SHAPE_EXTRUSION;
  for (uint32_t more = scene_kind_points(node->kind).most > 0 ? (uint32_t)random_number(seed, 0, 9) : 0; more > 0; --more) {
    const scene_point point = {{random_number(seed, -9, 9), flat ? 0 : random_number(seed, -9, 9), random_number(seed, -9, 9)},
                               flat ? 0 : random_number(seed, 0.1, 5)};
    assert_true(scene_node_add_point(node, (uint32_t)random_number(seed, 0, 3), &point));
  }
  if (scene_kind_has_children(node->kind)) {
    uint32_t count = scene_kind_is_group(node->kind) ? 1 + (uint32_t)random_number(seed, 0, 3) : 1;
    for (uint32_t i = 0; i < count; ++i) assert_true(scene_node_add(node, random_node(seed, depth + 1)));
  }
  return node;
}

static void points_come_and_go_within_their_limits(void** state) {
  (void)state;
  static const scree_shape_kind kinds[] = {SCREE_SHAPE_EXTRUSION, SCREE_SHAPE_TUBE, SCREE_SHAPE_BLOBS};
  for (size_t k = 0; k < 3; ++k) {
    scene_node* node = scene_node_create(kinds[k]);
    const scene_point_limits limits = scene_kind_points(kinds[k]);
    assert_in_range(node->point_count, limits.least, limits.most);
    const scene_point added = {{7, 0, 0}, 1};
    assert_true(scene_node_add_point(node, 0, &added));
    assert_true(scene_node_add_point(node, 1, &node->points[0]));
    assert_true(node->points[0].place[0] == 7 && node->points[1].place[0] == 7 && node->points[2].place[0] != 7);
    while (node->point_count < limits.most) assert_true(scene_node_add_point(node, UINT32_MAX, &added));
    assert_false(scene_node_add_point(node, 0, &added));
    assert_false(scene_node_remove_point(node, limits.most));
    while (node->point_count > limits.least) assert_true(scene_node_remove_point(node, 0));
    assert_false(scene_node_remove_point(node, 0));
    assert_true(node->points[0].place[0] == 7);
    scene_node_destroy(node);
  }
  scene_node* ball = scene_node_create(SCREE_SHAPE_SPHERE);
  const scene_point point = {{0, 0, 0}, 1};
  assert_false(scene_node_add_point(ball, 0, &point));
  scene_node_destroy(ball);
}

static void random_scenes_survive_writing_and_reading(void** state) {
  (void)state;
  uint64_t seed = 11;
  for (int round = 0; round < 200; ++round) {
    scene_model scene, again;
    scene_init(&scene);
    uint32_t fields = (uint32_t)random_number(&seed, 0, 4);
    for (uint32_t i = 0; i < fields; ++i) {
      scene_field* field = scene_add_field(&scene);
      field->cell_size = random_number(&seed, 0.01, 3);
      field->origin[0] = random_number(&seed, -1e7, 1e7);
      field->density = random_number(&seed, 0.01, 1);
      if (random_number(&seed, 0, 2) < 1) field->key = (int32_t)(1000 + i);
      for (uint32_t k = (uint32_t)random_number(&seed, 0, 4); k > 0; --k) {
        scene_filter* filter = scene_add_filter(field, (scree_filter_kind)random_number(&seed, 0, 3));
        strcpy(filter->map.file, filter->kind == SCREE_FILTER_ALTITUDE ? "" : "filter.png");
        filter->inverted = random_number(&seed, 0, 2) < 1;
        if (filter->kind != SCREE_FILTER_MASK) filter->to = filter->from + random_number(&seed, 0, 80);
      }
      field->support = random_node(&seed, 0);
    }
    char* first = scene_write(&scene, NULL);
    scree_error error = {""};
    scree_result result = parse(first, &again, &error);
    assert_string_equal(error.message, "");
    assert_int_equal(result, SCREE_OK);
    char* second = scene_write(&again, NULL);
    assert_string_equal(first, second);
    free(first);
    free(second);
    scene_destroy(&scene);
    scene_destroy(&again);
  }
}

static void copied_node_is_equal_and_independent(void** state) {
  (void)state;
  uint64_t seed = 5;
  for (int round = 0; round < 20; ++round) {
    scene_model a, b;
    scene_init(&a);
    scene_init(&b);
    scene_add_field(&a)->support = random_node(&seed, 0);
    scene_add_field(&b)->support = scene_node_copy(a.fields[0].support);
    char* first = scene_write(&a, NULL);
    scene_destroy(&a);
    char* second = scene_write(&b, NULL);
    assert_string_equal(first, second);
    free(first);
    free(second);
    scene_destroy(&b);
  }
}

static void detached_child_leaves_its_parent(void** state) {
  (void)state;
  scene_node* group = scene_node_create(SCREE_SHAPE_UNION);
  scene_node* children[3];
  for (int i = 0; i < 3; ++i) {
    children[i] = scene_node_create(SCREE_SHAPE_SPHERE);
    assert_true(scene_node_add(group, children[i]));
  }
  assert_null(scene_node_detach(group, 3));
  assert_ptr_equal(scene_node_detach(group, 1), children[1]);
  assert_int_equal(group->child_count, 2);
  assert_ptr_equal(group->children[1], children[2]);
  scene_node_destroy(children[1]);
  scene_node_destroy(group);
}

static void removed_filter_leaves_the_others(void** state) {
  (void)state;
  scene_model scene;
  scene_init(&scene);
  scene_field* field = scene_add_field(&scene);
  for (uint32_t i = 0; i < SCENE_FILTERS_MAX; ++i) {
    scene_filter* filter = scene_add_filter(field, SCREE_FILTER_ALTITUDE);
    filter->from = filter->to = i;
  }
  assert_null(scene_add_filter(field, SCREE_FILTER_MASK));
  scene_remove_filter(field, 1);
  scene_remove_filter(field, 99);
  assert_int_equal(field->filter_count, SCENE_FILTERS_MAX - 1);
  assert_true(field->filters[0].from == 0 && field->filters[1].from == 2);
  scene_destroy(&scene);
}

static void removed_field_leaves_the_others(void** state) {
  (void)state;
  scene_model scene;
  scene_init(&scene);
  for (uint64_t i = 0; i < 3; ++i) {
    scene_field* field = scene_add_field(&scene);
    field->seed = i;
    field->support = scene_node_create(SCREE_SHAPE_SPHERE);
  }
  scene_remove_field(&scene, 0);
  scene_remove_field(&scene, 7);
  assert_int_equal(scene.field_count, 2);
  assert_int_equal(scene.fields[0].seed, 1);
  assert_int_equal(scene.fields[1].seed, 2);
  scene_destroy(&scene);
}

/* A whole scene round one fragment: WITH_NODE's is the support, WITH_ROOT's stands beside the fields. */
#define WITH_SCATTER(text) "{\"fields\": [{\"spacing\": 1, \"support\": {\"shape\": \"box\"}, " text "}]}"
#define WITH_NODE(node) "{\"fields\": [{\"pack\": \"boulders\", \"support\": " node "}]}"
#define WITH_FIELD(keys) "{\"fields\": [{\"pack\": \"boulders\", " keys ", \"support\": {\"shape\": \"sphere\"}}]}"
#define WITH_ROOT(keys) "{" keys ", \"fields\": []}"

static void wrong_scene_is_refused_by_name_and_key(void** state) {
  (void)state;
  static const struct {
    const char *text, *message;
  } cases[] = {
      {"", "s.json: line 1, column 1: not valid JSON"},
      {"{\n  \"fields\": [,]}", "s.json: line 2, column 14: not valid JSON"},
      {"{\"fields\": []} x", "s.json: line 1, column 16: not valid JSON"},
      {"[]", "s.json: expected an object, got an array of 0"},
      {"null", "s.json: expected an object, got null"},
      {"{}", "s.json: fields: key is missing"},
      {"{\"fields\": {}}", "s.json: fields: expected an array of at most 64 fields, got an object"},
      {"{\"fields\": [7]}", "s.json: fields[0]: expected an object, got 7"},
      {"{\"fields\": [{}]}", "s.json: fields[0].pack: key is missing"},
      {"{\"fields\": [{\"pack\": \"\"}]}", "s.json: fields[0].pack: expected text, got \"\""},
      {"{\"fields\": [{\"pack\": \"b\"}]}", "s.json: fields[0].support: key is missing"},
      {WITH_ROOT("\"fieldz\": 1"), "s.json: fieldz: unknown key"},
      {WITH_ROOT("\"name\": 1"), "s.json: name: expected a string, got 1"},
      {WITH_ROOT("\"name\": \"a\\nb\""), "s.json: name: expected UTF-8 text without control characters"},
      {WITH_ROOT("\"name\": \"\xff\""), "s.json: name: expected UTF-8 text without control characters"},
      {WITH_ROOT("\"name\": \"\xed\xa0\x80\""), "s.json: name: expected UTF-8 text without control characters"},
      {WITH_ROOT("\"name\": \"\xc0\xaf\""), "s.json: name: expected UTF-8 text without control characters"},
      {WITH_ROOT("\"name\": \"1234567890123456789012345678901234567890123456789012345678901234\""),
       "s.json: name: expected at most 63 bytes of text, got 64"},
      {WITH_ROOT("\"camera\": []"), "s.json: camera: expected an object, got an array of 0"},
      {WITH_ROOT("\"camera\": {\"eye\": [0, 0]}"), "s.json: camera.eye: expected an array of 3 numbers, got an array of 2"},
      {WITH_ROOT("\"camera\": {\"eye\": [0, 0, \"x\"]}"), "s.json: camera.eye[2]: expected a number in -1e+09..1e+09, got \"x\""},
      {WITH_ROOT("\"camera\": {\"eye\": [0, 0, 1e999]}"), "s.json: camera.eye[2]: expected a number in -1e+09..1e+09, got inf"},
      {WITH_ROOT("\"camera\": {\"eye\": [0, 0, 0], \"target\": [0, 0, 0]}"),
       "s.json: camera.target: expected another point than eye"},
      {WITH_ROOT("\"camera\": {\"fov\": 171}"), "s.json: camera.fov: expected a number in 1..170, got 171"},
      {WITH_ROOT("\"sun\": {\"direction\": [0, 0, 0]}"), "s.json: sun.direction: expected a vector that is not zero"},
      {WITH_ROOT("\"sky\": \"#12345g\""), "s.json: sky: expected a colour such as \"#a09080\", got \"#12345g\""},
      {WITH_ROOT("\"sky\": \"#12\", \"sky\": 3"), "s.json: sky: key appears twice"},
      {WITH_ROOT("\"ground\": {\"kind\": \"lake\"}"),
       "s.json: ground.kind: expected \"none\", \"plane\" or \"terrain\", got \"lake\""},
      {WITH_ROOT("\"ground\": {\"kind\": \"none\", \"height\": 1}"), "s.json: ground.height: unknown key"},
      {WITH_ROOT("\"ground\": {\"kind\": \"terrain\"}"), "s.json: ground.file: key is missing"},
      {WITH_ROOT("\"ground\": {\"kind\": \"terrain\", \"file\": \"a\", \"low\": 3, \"high\": 3}"),
       "s.json: ground.high: expected a number > low (3), got 3"},
      {WITH_ROOT("\"ground\": {\"kind\": \"terrain\", \"file\": \"a\", \"crop\": [0, 0, 1, 5]}"),
       "s.json: ground.crop: expected at least 2 columns and 2 rows"},
      {WITH_ROOT("\"ground\": {\"kind\": \"terrain\", \"file\": \"a\", \"crop\": [0, 0, 2.5, 5]}"),
       "s.json: ground.crop[2]: expected a whole number in 0..16384, got 2.5"},
      {WITH_FIELD("\"seed\": -1"), "s.json: fields[0].seed: expected a whole number in 0..9007199254740992, got -1"},
      {WITH_FIELD("\"seed\": 1e17"), "s.json: fields[0].seed: expected a whole number in 0..9007199254740992, got 1e+17"},
      {WITH_FIELD("\"cell_size\": 0"), "s.json: fields[0].cell_size: expected a number > 0, got 0"},
      {WITH_FIELD("\"cell_size\": 1e7"), "s.json: fields[0].cell_size: expected a number > 0 and <= 1e+06, got 10000000"},
      {WITH_FIELD("\"threshold\": 1"), "s.json: fields[0].threshold: expected a number in 0..1, limits excluded, got 1"},
      {WITH_FIELD("\"shell\": 0"), "s.json: fields[0].shell: expected true or false, got 0"},
      {WITH_FIELD("\"density\": 0"), "s.json: fields[0].density: expected a number > 0 and <= 1, got 0"},
      {WITH_FIELD("\"key\": 65536"), "s.json: fields[0].key: expected a whole number in 0..65535, got 65536"},
      {"{\"fields\": [{\"pack\": \"b\", \"support\": {\"shape\": \"box\"}, \"key\": 1}, {\"pack\": \"b\", \"support\": {\"shape\": "
       "\"box\"}}]}",
       "s.json: fields[1].key: fields[0] has the key 1 already"},
      {WITH_FIELD("\"filters\": {}"), "s.json: fields[0].filters: expected an array of at most 16 filters, got an object"},
      {WITH_FIELD("\"filters\": [1]"), "s.json: fields[0].filters[0]: expected an object, got 1"},
      {WITH_FIELD("\"filters\": [{}]"), "s.json: fields[0].filters[0].filter: key is missing"},
      {WITH_FIELD("\"filters\": [{\"filter\": \"altitude\"}, {\"filter\": \"rain\"}]"),
       "s.json: fields[0].filters[1].filter: expected mask, slope or altitude, got \"rain\""},
      {WITH_FIELD("\"filters\": [{\"filter\": \"mask\"}]"), "s.json: fields[0].filters[0].file: key is missing"},
      {WITH_FIELD("\"filters\": [{\"filter\": \"mask\", \"file\": \"a\", \"from\": 1}]"),
       "s.json: fields[0].filters[0].from: unknown key"},
      {WITH_FIELD("\"filters\": [{\"filter\": \"slope\", \"file\": \"a\", \"to\": 91}]"),
       "s.json: fields[0].filters[0].to: expected a number in 0..90, got 91"},
      {WITH_FIELD("\"filters\": [{\"filter\": \"altitude\", \"from\": 2, \"to\": 1}]"),
       "s.json: fields[0].filters[0].to: expected a number >= from (2), got 1"},
      {"{\"fields\": [{\"time\": 1}]}", "s.json: fields[0].pack: key is missing"},
      {"{\"fields\": [{\"pack\": \"a\", \"time\": 0.5}]}", "s.json: fields[0].time: expected a whole number in 0..254, got 0.5"},
      {"{\"fields\": [{\"pack\": \"a\", \"time\": 0, \"turn\": 361}]}",
       "s.json: fields[0].turn: expected a number in -360..360, got 361"},
      {"{\"fields\": [{\"pack\": \"a\", \"time\": 0, \"scale\": 0}]}", "s.json: fields[0].scale: expected a number > 0, got 0"},
      {"{\"fields\": [{\"pack\": \"a\", \"time\": 0, \"support\": {\"shape\": \"box\"}}]}",
       "s.json: fields[0].support: unknown key"},
      {"{\"fields\": [{\"pack\": \"a\", \"time\": 0, \"density\": 1}]}", "s.json: fields[0].density: unknown key"},
      {WITH_SCATTER("\"seed\": 1"), "s.json: fields[0].pack: key is missing"},
      {WITH_SCATTER("\"pack\": \"\""), "s.json: fields[0].pack: expected text, got \"\""},
      {WITH_SCATTER("\"pack\": \"a\", \"models\": [\"b\"]"), "s.json: fields[0].models: a scatter has a pack or models, not both"},
      {WITH_SCATTER("\"models\": [\"b\"], \"ages\": {\"file\": \"c\"}"), "s.json: fields[0].ages: only models of a pack have ages"},
      {WITH_SCATTER("\"pack\": \"a\", \"cell_size\": 1"), "s.json: fields[0].cell_size: unknown key"},
      {WITH_SCATTER("\"models\": []"), "s.json: fields[0].models: expected an array of 1..64 files, got an array of 0"},
      {WITH_SCATTER("\"models\": [\"a\", 3]"), "s.json: fields[0].models[1]: expected a string, got 3"},
      {WITH_SCATTER("\"models\": [\"\"]"), "s.json: fields[0].models[0]: expected text, got \"\""},
      {WITH_SCATTER("\"pack\": \"a\", \"scale\": [2, 1]"),
       "s.json: fields[0].scale: expected the smaller number first, got [2, 1]"},
      {WITH_SCATTER("\"pack\": \"a\", \"scale\": [0, 1]"), "s.json: fields[0].scale[0]: expected a number > 0 and <= 1e+06, got 0"},
      {WITH_SCATTER("\"pack\": \"a\", \"max_slope\": 81"), "s.json: fields[0].max_slope: expected a number > 0 and <= 80, got 81"},
      {WITH_SCATTER("\"pack\": \"a\", \"weights\": [0, 0]"), "s.json: fields[0].weights: expected one number that is not 0"},
      {WITH_SCATTER("\"pack\": \"a\", \"weights\": [1, -1]"),
       "s.json: fields[0].weights[1]: expected a number in 0..1e+06, got -1"},
      {WITH_SCATTER("\"pack\": \"a\", \"ages\": {}"), "s.json: fields[0].ages.file: key is missing"},
      {WITH_SCATTER("\"pack\": \"a\", \"ages\": {\"file\": \"b\", \"from\": 1}"), "s.json: fields[0].ages.from: unknown key"},
      {"{\"fields\": [{\"models\": [\"a\"], \"support\": {\"shape\": \"box\"}}]}", "s.json: fields[0].spacing: key is missing"},
      {"{\"fields\": [{\"pack\": \"a\", \"spacing\": 0, \"support\": {\"shape\": \"box\"}}]}",
       "s.json: fields[0].spacing: expected a number > 0, got 0"},
      {WITH_FIELD("\"scale\": [1, 1]"), "s.json: fields[0].scale: unknown key"},
      {WITH_FIELD("\"palette\": {\"colours\": []}"),
       "s.json: fields[0].palette.colours: expected an array of 1..8 colours, got an array of 0"},
      {WITH_FIELD("\"palette\": {\"colours\": [\"#000000\", 1]}"),
       "s.json: fields[0].palette.colours[1]: expected a colour such as \"#a09080\", got 1"},
      {WITH_NODE("[]"), "s.json: fields[0].support: expected an object, got an array of 0"},
      {WITH_NODE("{}"), "s.json: fields[0].support.shape: key is missing"},
      {WITH_NODE("{\"shape\": \"callback\"}"),
       "s.json: fields[0].support.shape: expected sphere, box, capsule, cylinder, cone, heightfield, mesh, ellipsoid, half_space, "
       "torus, extrusion, tube, blobs, pattern, union, intersection, difference, smooth_union or noise, got \"callback\""},
      {WITH_NODE("{\"shape\": \"half_space\", \"radius\": 1}"), "s.json: fields[0].support.radius: unknown key"},
      {WITH_NODE("{\"shape\": \"tube\"}"), "s.json: fields[0].support.points: key is missing"},
      {WITH_NODE("{\"shape\": \"tube\", \"points\": [[0, 0, 0, 1]]}"),
       "s.json: fields[0].support.points: expected an array of 2..256 points, got an array of 1"},
      {WITH_NODE("{\"shape\": \"tube\", \"points\": [[0, 0, 0, 1], [0, 0, 0]]}"),
       "s.json: fields[0].support.points[1]: expected an array of 4 numbers, got an array of 3"},
      {WITH_NODE("{\"shape\": \"tube\", \"points\": [[0, 0, 0, 1], [0, 0, 1, 0]]}"),
       "s.json: fields[0].support.points[1][3]: expected a number > 0 and <= 1e+06, got 0"},
      {WITH_NODE("{\"shape\": \"extrusion\", \"points\": [[0, 0], [0, 1], [1, \"x\"]]}"),
       "s.json: fields[0].support.points[2][1]: expected a number in -1e+06..1e+06, got \"x\""},
      {WITH_NODE("{\"shape\": \"extrusion\", \"points\": [[0, 0], [0, 1], [1, 1]], \"low\": 2}"),
       "s.json: fields[0].support.high: expected a number > low (2), got 1"},
      {WITH_NODE("{\"shape\": \"blobs\", \"points\": []}"),
       "s.json: fields[0].support.points: expected an array of 1..256 points, got an array of 0"},
      {WITH_NODE("{\"shape\": \"pattern\", \"pattern\": \"dots\"}"),
       "s.json: fields[0].support.pattern: expected lines, rings or waves, got \"dots\""},
      {WITH_NODE("{\"shape\": \"noise\"}"), "s.json: fields[0].support.child: key is missing"},
      {WITH_NODE("{\"shape\": \"noise\", \"octaves\": 9, \"child\": {\"shape\": \"box\"}}"),
       "s.json: fields[0].support.octaves: expected a whole number in 1..8, got 9"},
      {WITH_NODE(
           "{\"shape\": \"noise\", \"child\": {\"shape\": \"noise\", \"child\": {\"shape\": \"torus\", \"tube_radius\": -1}}}"),
       "s.json: fields[0].support.child.child.tube_radius: expected a number > 0, got -1"},
      {WITH_NODE("{\"shape\": \"sphere\", \"radius\": \"a\"}"),
       "s.json: fields[0].support.radius: expected a number > 0, got \"a\""},
      {WITH_NODE("{\"shape\": \"sphere\", \"half\": 1}"), "s.json: fields[0].support.half: unknown key"},
      {WITH_NODE("{\"shape\": \"box\", \"half\": [1, 1, 0]}"),
       "s.json: fields[0].support.half[2]: expected a number > 0 and <= 1e+06, got 0"},
      {WITH_NODE("{\"shape\": \"box\", \"rounding\": 2}"),
       "s.json: fields[0].support.rounding: expected at most the smallest half extent, 1"},
      {WITH_NODE("{\"shape\": \"mesh\"}"), "s.json: fields[0].support.file: key is missing"},
      {WITH_NODE("{\"shape\": \"mesh\", \"file\": \"a\", \"resolution\": 4}"),
       "s.json: fields[0].support.resolution: expected a whole number in 8..512, got 4"},
      {WITH_NODE("{\"shape\": \"heightfield\", \"file\": \"a\", \"below\": -1, \"above\": 1}"),
       "s.json: fields[0].support.below: expected above + below > 0"},
      {WITH_NODE("{\"shape\": \"union\"}"), "s.json: fields[0].support.children: key is missing"},
      {WITH_NODE("{\"shape\": \"union\", \"children\": []}"),
       "s.json: fields[0].support.children: expected an array of at least one shape, got an array of 0"},
      {WITH_NODE("{\"shape\": \"union\", \"children\": [{\"shape\": \"box\"}, {\"shape\": \"box\"}, {\"shape\": \"cone\", "
                 "\"radius\": -2}]}"),
       "s.json: fields[0].support.children[2].radius: expected a number > 0, got -2"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    scene_model scene;
    scree_error error = {""};
    scree_result result = parse(cases[i].text, &scene, &error);
    assert_string_equal(error.message, cases[i].message);
    assert_true(result == SCREE_ERROR_SYNTAX || result == SCREE_ERROR_RANGE);
    assert_null(scene.fields);
  }
}

static void deep_nesting_is_refused(void** state) {
  (void)state;
  static const size_t depths[] = {SCENE_DEPTH_MAX, 400, 5000, 200000};
  for (size_t i = 0; i < 4; ++i) {
    static const char open[] = "{\"shape\": \"union\", \"children\": [";
    size_t capacity = depths[i] * (sizeof open + 2) + 256;
    char* text = malloc(capacity);
    char* at = text + sprintf(text, "{\"fields\": [{\"pack\": \"b\", \"support\": ");
    for (size_t level = 0; level < depths[i]; ++level) at += sprintf(at, "%s", open);
    at += sprintf(at, "{\"shape\": \"sphere\"}");
    for (size_t level = 0; level < depths[i]; ++level) at += sprintf(at, "]}");
    sprintf(at, "}]}");
    scene_model scene;
    scree_error error = {""};
    assert_int_equal(parse(text, &scene, &error), SCREE_ERROR_SYNTAX);
    assert_non_null(strstr(error.message, i < 2 ? "expected at most 64 levels" : "not valid JSON"));
    free(text);
  }
}

static void every_truncation_is_refused(void** state) {
  (void)state;
  size_t size = strlen(everything);
  for (size_t length = 0; length < size; ++length) {
    /* A fresh block of the exact size each time, so that a read past the end is seen by the sanitizer. */
    char* text = malloc(length > 0 ? length : 1);
    memcpy(text, everything, length);
    scene_model scene;
    scree_error error = {""};
    assert_int_equal(scene_parse(text, length, "s.json", &scene, &error), SCREE_ERROR_SYNTAX);
    assert_true(strlen(error.message) > 8);
    free(text);
  }
}

static void changed_bytes_never_crash(void** state) {
  (void)state;
  size_t size = strlen(everything);
  char* text = malloc(size);
  uint64_t seed = 3;
  for (int round = 0; round < 20000; ++round) {
    memcpy(text, everything, size);
    uint32_t changes = 1 + (uint32_t)random_number(&seed, 0, 3);
    for (uint32_t i = 0; i < changes; ++i)
      text[(size_t)random_number(&seed, 0, (double)size)] = (char)(uint32_t)random_number(&seed, 0, 256);
    scene_model scene;
    scree_error error = {""};
    scree_result result = scene_parse(text, size, "s.json", &scene, &error);
    assert_true((result == SCREE_OK) == (error.message[0] == '\0'));
    assert_null(strchr(error.message, '\n'));
    scene_destroy(&scene);
  }
  free(text);
}

static void missing_file_is_one_clear_line(void** state) {
  (void)state;
  scene_model scene;
  scree_error error = {""};
  assert_int_equal(scene_load("no/such.json", &scene, &error), SCREE_ERROR_IO);
  assert_string_equal(error.message, "no/such.json: cannot open: No such file or directory");
  assert_int_equal(scene_load("/", &scene, &error), SCREE_ERROR_IO);
  assert_string_equal(error.message, "/: not a regular file");
}

static void saving_to_a_bad_place_changes_nothing(void** state) {
  (void)state;
  scene_model scene;
  scree_error error = {""};
  scene_init(&scene);
  assert_int_equal(scene_save(&scene, "no/such/folder/s.json", &error), SCREE_ERROR_IO);
  assert_string_equal(error.message, "no/such/folder/s.json: cannot write: No such file or directory");
  scene_destroy(&scene);
}

static void rotation_is_about_x_then_y_then_z(void** state) {
  (void)state;
  static const struct {
    double degrees[3], quaternion[4];
  } cases[] = {
      {{0, 0, 0}, {0, 0, 0, 1}},           {{90, 0, 0}, {0.70710678118654752, 0, 0, 0.70710678118654752}},
      {{0, 180, 0}, {0, 1, 0, 0}},         {{0, 0, -60}, {0, 0, -0.5, 0.86602540378443865}},
      {{90, 0, 90}, {0.5, 0.5, 0.5, 0.5}}, {{0, 720, 0}, {0, 0, 0, 1}},
  };
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    double q[4];
    scene_rotation_quaternion(cases[i].degrees, q);
    for (int k = 0; k < 4; ++k) assert_true(q[k] - cases[i].quaternion[k] < 1e-15 && cases[i].quaternion[k] - q[k] < 1e-15);
  }
}

static void stone_colour_is_a_base_colour_times_a_shade(void** state) {
  (void)state;
  scene_palette palette = {.colours = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .colour_count = 3, .variation = 0.25};
  uint32_t seen[3] = {0};
  uint64_t seed = 1;
  for (int i = 0; i < 3000; ++i) {
    float colour[3], shade;
    uint32_t base;
    scene_stone_colour(&palette, (uint32_t)hash_mix(seed++), colour, &base, &shade);
    assert_true(base < 3 && shade >= 0.75f && shade <= 1.0f);
    for (uint32_t k = 0; k < 3; ++k) assert_true(colour[k] == (k == base ? shade : 0.0f));
    ++seen[base];
  }
  for (int i = 0; i < 3; ++i) assert_in_range(seen[i], 900, 1100);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_key_is_read),
      cmocka_unit_test(written_scene_reads_back_the_same),
      cmocka_unit_test(writing_keeps_every_value),
      cmocka_unit_test(random_scenes_survive_writing_and_reading),
      cmocka_unit_test(points_come_and_go_within_their_limits),
      cmocka_unit_test(copied_node_is_equal_and_independent),
      cmocka_unit_test(detached_child_leaves_its_parent),
      cmocka_unit_test(removed_filter_leaves_the_others),
      cmocka_unit_test(removed_field_leaves_the_others),
      cmocka_unit_test(wrong_scene_is_refused_by_name_and_key),
      cmocka_unit_test(deep_nesting_is_refused),
      cmocka_unit_test(every_truncation_is_refused),
      cmocka_unit_test(changed_bytes_never_crash),
      cmocka_unit_test(missing_file_is_one_clear_line),
      cmocka_unit_test(saving_to_a_bad_place_changes_nothing),
      cmocka_unit_test(rotation_is_about_x_then_y_then_z),
      cmocka_unit_test(stone_colour_is_a_base_colour_times_a_shade),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
