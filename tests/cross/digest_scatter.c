#include "digest_scatter.h"

#include <scree/scatter.h>
#include <string.h>

#include "field_tables.h"
#include "synthetic_field.h"

enum { MOST = 8192 };

static uint64_t digest_words(uint64_t digest, const void* bytes, size_t size) {
  for (size_t at = 0; at + sizeof(uint32_t) <= size; at += sizeof(uint32_t)) {
    uint32_t word;
    memcpy(&word, (const char*)bytes + at, sizeof word);
    digest = hash_combine(digest, word);
  }
  return digest;
}

static uint64_t digest_placements(uint64_t digest, const scree_scatter* scatter, const scree_support* ground) {
  static scree_placement placements[MOST];
  const double all[3] = {0, 0, 0};
  uint64_t count;
  if (scree_scatter_fill(scatter, ground, all, all, placements, MOST, &count) != SCREE_OK || count < 300) return 0;
  return digest_words(digest, placements, (size_t)count * sizeof *placements);
}

/* Rocks in a slab that the ground rises out of, earlier and later than the scatter. */
static uint64_t digest_scene(uint64_t digest, const scree_scatter* scatter, const scree_support* ground, const scree_support* slab,
                             const scree_field* field) {
  static scree_rock rocks[4 * MOST];
  const scree_layer orders[2][2] = {{{.scatter = scatter, .support = ground, .density = 0.7f}, {.field = field, .support = slab}},
                                    {{.field = field, .support = slab}, {.scatter = scatter, .support = ground}}};
  scree_scratch* scratch;
  if (scree_scratch_create(NULL, &scratch) != SCREE_OK) return 0;
  for (int i = 0; i < 2 && digest != 0; ++i) {
    scree_scene* scene;
    uint64_t count = 0;
    if (scree_scene_create(&(scree_scene_desc){orders[i], 2}, NULL, &scene, NULL) != SCREE_OK) {
      digest = 0;
      break;
    }
    const scree_scene_query_desc all = {.scene = scene};
    const scree_result result = scree_scene_fill(&all, scratch, rocks, 4 * MOST, &count);
    digest = result == SCREE_OK && count > 500 ? digest_words(digest, rocks, (size_t)count * sizeof *rocks) : 0;
    for (int ray = 0; ray < 40 && digest != 0; ++ray) {
      const double start[3] = {ray * 0.7 - 14, 9, ray * 0.3 - 6}, down[3] = {0.1, -1, 0.05};
      bool found;
      scree_hit hit;
      memset(&hit, 0, sizeof hit);
      if (scree_scene_ray_cast(scene, NULL, scratch, start, down, 20, &found, &hit) != SCREE_OK) digest = 0;
      if (digest != 0 && found) digest = digest_words(digest, &hit.distance, sizeof hit.distance);
    }
    scree_scene_destroy(scene);
  }
  scree_scratch_destroy(scratch);
  return digest;
}

uint64_t digest_scatter(void) {
  static const uint32_t children[] = {2, 3};
  static const float image[6] = {0, 0.4f, 1, 0.2f, 0.9f, 0}, weights[4] = {1, 0.5f, 2, 3};
  static const float tent[] = {-0.5f, 0, -0.5f, 0.5f, 0, -0.5f, 0, 0, 0.6f, 0.1f, 2, 0};
  const scree_shape shapes[] = {
      {.kind = SCREE_SHAPE_NOISE, .noise = {.child = 1, .amplitude = 0.8f, .wavelength = 7, .octaves = 3, .seed = 4}},
      {.kind = SCREE_SHAPE_SMOOTH_UNION, .group = {children, 2, 2}},
      {.kind = SCREE_SHAPE_BOX, .box = {{16, 1, 14}, 0.2f}},
      {.kind = SCREE_SHAPE_ELLIPSOID, .ellipsoid = {{9, 5, 7}}, .transform.translation = {3, 0, -2}},
  };
  const scree_filter mask = {.kind = SCREE_FILTER_MASK, .values = image, .width = 3, .depth = 2, .spacing = 11};
  const scree_scatter_model models[4] = {{.footprint_radius = 0.3f, .height = 2},
                                         {.footprint_radius = 0.2f, .height = 1.5f},
                                         {.footprint_radius = 0.5f, .height = 2, .hull = tent, .hull_count = 4},
                                         {.footprint_radius = 0.4f, .height = 1}};
  const scree_scatter_desc desc = {.models = models,
                                   .model_count = 4,
                                   .age_count = 2,
                                   .weights = weights,
                                   .age_mask = &mask,
                                   .spacing = 0.9,
                                   .origin = {3, -1, 7},
                                   .seed = 2006,
                                   .scale_min = 0.6f,
                                   .scale_max = 1.4f,
                                   .max_slope = 38};
  synthetic_source source = synthetic_create(4, 1, 1, 77);
  synthetic_add_hulls(&source, 78, 2, 0);
  const scree_field_desc field_desc = {.seed = 79, .cell_size = 0.9};
  scree_support *ground = NULL, *slab = NULL;
  scree_scatter* scatter = NULL;
  scree_field* field = NULL;
  uint64_t digest = 1;
  if (scree_support_create(&(scree_support_desc){.shapes = shapes, .shape_count = 4}, NULL, &ground, NULL) != SCREE_OK ||
      scree_support_create(&(scree_support_desc){.shapes = &shapes[2], .shape_count = 1}, NULL, &slab, NULL) != SCREE_OK ||
      scree_scatter_create(&desc, NULL, &scatter, NULL) != SCREE_OK ||
      scree_rt_field_create_from_source(&field_desc, &source.source, NULL, &field) != SCREE_OK)
    digest = 0;
  if (digest != 0) digest = digest_placements(digest, scatter, ground);
  if (digest != 0) digest = digest_scene(digest, scatter, ground, slab, field);
  scree_field_destroy(field);
  scree_scatter_destroy(scatter);
  scree_support_destroy(slab);
  scree_support_destroy(ground);
  synthetic_destroy(&source);
  return digest;
}
