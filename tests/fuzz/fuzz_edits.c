/* libFuzzer target: any bytes as edits of a scene, as they are, with their digest made right, and as changes to good ones. What
 * loads is saved, loads again, and is the same. */
#include <stdlib.h>
#include <string.h>

#include <scree/scene.h>

#include "pack_format.h"
#include "synthetic_field.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

/* Layers 0 and 1 on one field; made once. */
static scree_scene* scene_of_two_layers(void) {
  static scree_scene* scene;
  if (scene != NULL) return scene;
  static synthetic_source source;
  source = synthetic_create(3, 0, 2, 1);
  const scree_field_desc field_desc = {.seed = 1, .cell_size = 1};
  scree_field* field;
  if (scree_rt_field_create_from_source(&field_desc, &source.source, NULL, &field) != SCREE_OK) abort();
  const scree_shape ball = {.kind = SCREE_SHAPE_SPHERE, .sphere = {.radius = 3}};
  scree_support* support;
  if (scree_support_create(&(scree_support_desc){.shapes = &ball, .shape_count = 1}, NULL, &support, NULL) != SCREE_OK) abort();
  const scree_layer layers[2] = {{.field = field, .support = support}, {.field = field, .support = support}};
  if (scree_scene_create(&(scree_scene_desc){layers, 2}, NULL, &scene, NULL) != SCREE_OK) abort();
  return scene;
}

static void load(const uint8_t* bytes, size_t size) {
  const scree_scene* scene = scene_of_two_layers();
  scree_edits *edits, *again;
  scree_edits_report report;
  if (scree_edits_create(NULL, &edits) != SCREE_OK || scree_edits_create(NULL, &again) != SCREE_OK) abort();
  const scree_result result = scree_edits_load(edits, scene, bytes, size, &report);
  if (scree_edits_count(edits) != report.applied) abort();
  if (result == SCREE_OK) {
    size_t length, again_length;
    scree_edits_save(edits, scene, NULL, 0, &length);
    uint8_t *saved = malloc(length), *saved_again = malloc(length);
    if (scree_edits_save(edits, scene, saved, length, &length) != SCREE_OK) abort();
    if (scree_edits_load(again, scene, saved, length, &report) != SCREE_OK) abort();
    if (report.applied != scree_edits_count(edits) || report.stale + report.unknown_layer + report.unknown_rock != 0) abort();
    if (scree_edits_save(again, scene, saved_again, length, &again_length) != SCREE_OK) abort();
    if (again_length != length || memcmp(saved, saved_again, length) != 0) abort();
    free(saved);
    free(saved_again);
  }
  scree_edits_destroy(edits);
  scree_edits_destroy(again);
}

static void seal(uint8_t* bytes, size_t size) {
  if (size < 8) return;
  const uint64_t digest = scree_rt_pack_bytes_digest(bytes, size - 8);
  for (int i = 0; i < 8; ++i) bytes[size - 8 + (size_t)i] = (uint8_t)(digest >> (8 * i));
}

/* Every three bytes are a place in a good delta and what its byte is changed by. */
static void load_changed(const uint8_t* data, size_t size) {
  scree_edits* edits;
  if (scree_edits_create(NULL, &edits) != SCREE_OK) abort();
  for (uint16_t i = 0; i < 12; ++i) {
    const scree_id id = {{i % 3, i / 6, 0}, i, i % 2};
    if (scree_edits_set(edits, &id, (scree_edit)(1 + i % 2)) != SCREE_OK) abort();
  }
  size_t length;
  scree_edits_save(edits, scene_of_two_layers(), NULL, 0, &length);
  uint8_t* bytes = malloc(length);
  if (scree_edits_save(edits, scene_of_two_layers(), bytes, length, &length) != SCREE_OK) abort();
  for (size_t i = 0; i + 3 <= size; i += 3) bytes[(data[i] | (size_t)data[i + 1] << 8) % length] ^= data[i + 2];
  seal(bytes, length);
  load(bytes, length);
  free(bytes);
  scree_edits_destroy(edits);
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  uint8_t* bytes = malloc(size > 0 ? size : 1); /* exactly as long, so that a read past the end is seen */
  if (size > 0) memcpy(bytes, data, size);
  load(bytes, size);
  seal(bytes, size);
  load(bytes, size);
  free(bytes);
  load_changed(data, size);
  return 0;
}
