#include "digest_edits.h"

#include <scree/scene.h>
#include <stdlib.h>
#include <string.h>

#include "convex.h"
#include "pack_format.h"
#include "synthetic_field.h"

uint64_t digest_edits(void) {
  synthetic_source source = synthetic_create(3, 0, 2, 1);
  const scree_field_desc field_desc = {.seed = 2009, .cell_size = 0.7, .origin = {1e6 / 3, -0.0, -1e7 / 3}};
  const scree_shape ball = {.kind = SCREE_SHAPE_SPHERE, .sphere = {.radius = 3}};
  scree_field* field = NULL;
  scree_support* support = NULL;
  scree_scene* scene = NULL;
  scree_edits *edits = NULL, *loaded = NULL;
  uint64_t digest = 0;
  if (scree_rt_field_create_from_source(&field_desc, &source.source, NULL, &field) == SCREE_OK &&
      scree_support_create(&(scree_support_desc){.shapes = &ball, .shape_count = 1}, NULL, &support, NULL) == SCREE_OK &&
      scree_edits_create(NULL, &edits) == SCREE_OK && scree_edits_create(NULL, &loaded) == SCREE_OK) {
    const scree_layer layers[2] = {{.field = field, .support = support, .key = 9},
                                   {.field = field, .support = support, .key = 300}};
    random_stream r = {1};
    for (int i = 0; i < 500; ++i) {
      scree_id id = {.local = (uint16_t)random_below(&r, 54), .layer = random_below(&r, 2) ? 9 : 300};
      for (int a = 0; a < 3; ++a) id.cube[a] = (int32_t)(uint32_t)random_bits(&r);
      scree_edits_set(edits, &id, (scree_edit)(1 + random_below(&r, 2)));
    }
    size_t size = 0;
    scree_edits_report report = {0};
    if (scree_scene_create(&(scree_scene_desc){layers, 2}, NULL, &scene, NULL) == SCREE_OK &&
        scree_edits_save(edits, scene, NULL, 0, &size) == SCREE_ERROR_CAPACITY) {
      uint8_t* bytes = malloc(size);
      if (bytes != NULL && scree_edits_save(edits, scene, bytes, size, &size) == SCREE_OK &&
          scree_edits_load(loaded, scene, bytes, size, &report) == SCREE_OK)
        digest = hash_combine(hash_combine(scree_rt_pack_bytes_digest(bytes, size), report.applied), report.unknown_rock);
      free(bytes);
    }
  }
  scree_edits_destroy(loaded);
  scree_edits_destroy(edits);
  scree_scene_destroy(scene);
  scree_support_destroy(support);
  scree_field_destroy(field);
  synthetic_destroy(&source);
  return digest;
}

static uint64_t bits_of(double value) {
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  return bits;
}

uint64_t digest_convex(void) {
  random_stream r = {2};
  uint64_t digest = 0;
  for (int i = 0; i < 4000; ++i) {
    float data[6][16];
    for (int k = 0; k < 6; ++k)
      for (int j = 0; j < 16; ++j) data[k][j] = (float)random_below(&r, 41) - 20;
    convex_hull a = {data[0], data[1], data[2], 1 + random_below(&r, 16), random_in(&r, 0.01, 0.1), {0, 0, 0}, 0};
    convex_hull b = {data[3], data[4], data[5], 1 + random_below(&r, 16), random_in(&r, 0.01, 0.1), {0, 0, 0}, random_in(&r, 0, 1)};
    double direction[3] = {0.6, 0, -0.8}, t = 0, normal[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
      a.at[k] = random_in(&r, -1, 1);
      b.at[k] = random_in(&r, -1, 1) * 2;
    }
    digest = hash_combine(digest, scree_rt_convex_meet(&a, &b));
    digest = hash_combine(digest, bits_of(scree_rt_convex_distance(&a, &b)));
    digest = hash_combine(digest, scree_rt_convex_ray(&a, b.at, direction, 10, &t, normal));
    digest = hash_combine(hash_combine(digest, bits_of(t)), bits_of(normal[0]) ^ bits_of(normal[1]) ^ bits_of(normal[2]));
  }
  return digest;
}

/* Rays, overlaps and near rocks of two layers that overlap. */
static uint64_t ask(const scree_scene* scene, scree_scratch* scratch) {
  static scree_rock rocks[20000];
  random_stream r = {3};
  uint64_t digest = 0;
  for (int i = 0; i < 100; ++i) {
    double start[3], direction[3];
    for (int a = 0; a < 3; ++a) {
      start[a] = random_in(&r, -12, 12);
      direction[a] = random_in(&r, -4, 4) - start[a];
    }
    bool found;
    scree_hit hit;
    memset(&hit, 0, sizeof hit);
    if (scree_scene_ray_cast(scene, NULL, scratch, start, direction, 1e4, &found, &hit) != SCREE_OK) return 0;
    if (found) digest = hash_combine(digest, scree_rt_pack_bytes_digest(&hit, sizeof hit));
    float points[12];
    for (int k = 0; k < 12; ++k) points[k] = (float)random_in(&r, -1, 1);
    const scree_convex shape = {{start[0] / 3, start[1] / 3, start[2] / 3}, points, 4, 0.25f};
    uint64_t count = 0;
    if (scree_scene_overlap(scene, NULL, scratch, &shape, rocks, 20000, &count) != SCREE_OK) return 0;
    digest = hash_combine(digest, scree_rt_pack_bytes_digest(rocks, (size_t)count * sizeof *rocks));
    if (scree_scene_near(scene, NULL, scratch, shape.origin, 1, 1.5, start, rocks, 20000, &count) != SCREE_OK) return 0;
    digest = hash_combine(digest, scree_rt_pack_bytes_digest(rocks, (size_t)count * sizeof *rocks));
  }
  return digest;
}

uint64_t digest_spatial(void) {
  uint64_t digest = 0;
  synthetic_source source = synthetic_create(4, 1, 2, 4);
  synthetic_add_hulls(&source, 5, 3, 4);
  scree_field* fields[2] = {NULL, NULL};
  scree_support* supports[2] = {NULL, NULL};
  scree_scene* scene = NULL;
  scree_scratch* scratch = NULL;
  bool good = scree_scratch_create(NULL, &scratch) == SCREE_OK;
  for (int i = 0; i < 2 && good; ++i) {
    const scree_field_desc desc = {.seed = 7 + (uint64_t)i, .cell_size = i == 0 ? 1 : 0.45, .origin = {i, 0.3, -i}};
    const scree_shape ball = {
        .kind = SCREE_SHAPE_SPHERE, .transform = {.translation = {(float)(3 * i), 0, 0}}, .sphere = {.radius = 4}};
    good = scree_rt_field_create_from_source(&desc, &source.source, NULL, &fields[i]) == SCREE_OK &&
           scree_support_create(&(scree_support_desc){.shapes = &ball, .shape_count = 1}, NULL, &supports[i], NULL) == SCREE_OK;
  }
  const scree_layer layers[2] = {{.field = fields[0], .support = supports[0]}, {.field = fields[1], .support = supports[1]}};
  if (good && scree_scene_create(&(scree_scene_desc){layers, 2}, NULL, &scene, NULL) == SCREE_OK) digest = ask(scene, scratch);
  scree_scene_destroy(scene);
  for (int i = 0; i < 2; ++i) {
    scree_support_destroy(supports[i]);
    scree_field_destroy(fields[i]);
  }
  scree_scratch_destroy(scratch);
  synthetic_destroy(&source);
  return digest;
}
