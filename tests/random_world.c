#include "random_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* after the five above */
#include <cmocka.h>

scree_scratch* make_scratch(void) {
  scree_scratch* scratch;
  assert_int_equal(scree_scratch_create(NULL, &scratch), SCREE_OK);
  return scratch;
}

static void make_filters(world* w, random_stream* r, uint32_t k) {
  w->layers[k].filter_count = random_below(r, 4);
  w->layers[k].filters = w->filters[k];
  uint32_t images = 0;
  for (uint32_t i = 0; i < w->layers[k].filter_count; ++i) {
    scree_filter* f = &w->filters[k][i];
    *f = (scree_filter){.kind = (scree_filter_kind)random_below(r, 3), .inverted = random_below(r, 2)};
    if (images == 2) f->kind = SCREE_FILTER_ALTITUDE;
    double from = f->kind == SCREE_FILTER_SLOPE ? 0 : w->middle[1] - 10, to = f->kind == SCREE_FILTER_SLOPE ? 80 : from + 20;
    f->from = (float)random_in(r, from, to);
    f->to = f->from + (float)random_in(r, 0, (to - from) * 0.5);
    if (random_below(r, 2)) f->fade = (float)random_in(r, 0, (to - from) * 0.3);
    if (f->kind == SCREE_FILTER_ALTITUDE) continue;
    float* image = w->images[k][images++];
    for (int p = 0; p < IMAGE * IMAGE; ++p)
      image[p] = (float)(f->kind == SCREE_FILTER_MASK ? fmin(fmax(random_in(r, -0.5, 1.5), 0), 1) : random_in(r, -3, 3));
    f->values = image;
    f->width = 2 + random_below(r, IMAGE - 1);
    f->depth = 2 + random_below(r, IMAGE - 1);
    f->spacing = (float)random_in(r, 0.5, 4);
    for (int a = 0; a < 3; ++a) f->centre[a] = w->middle[a] + random_in(r, -5, 5);
  }
}

static void make_field(world* w, random_stream* r, uint32_t k, double smallest, double largest) {
  scree_field_desc field = {.seed = random_bits(r), .cell_size = random_in(r, smallest, largest)};
  for (int a = 0; a < 3; ++a) field.origin[a] = w->middle[a] + random_in(r, -50, 50);
  assert_int_equal(scree_rt_field_create_from_source(&field, w->source_of[k], NULL, &w->fields[k]), SCREE_OK);
}

static void make_support(world* w, random_stream* r, uint32_t k, double astray) {
  for (int a = 0; a < 3; ++a) w->shapes[k]->desc.origin[a] = w->middle[a] + random_in(r, -astray, astray);
  scree_error error;
  if (scree_support_create(&w->shapes[k]->desc, NULL, &w->supports[k], &error) != SCREE_OK) fail_msg("%s", error.message);
  w->layers[k] = (scree_layer){.field = w->fields[k], .support = w->supports[k]};
}

static void make_scene(world* w, random_stream* r) {
  if (random_below(r, 2))
    for (uint32_t k = 0; k < w->count; ++k) w->layers[k].key = (uint16_t)(100 - 7 * k);
  w->desc = (scree_scene_desc){w->layers, w->count};
  scree_error error;
  if (scree_scene_create(&w->desc, NULL, &w->scene, &error) != SCREE_OK) fail_msg("%s", error.message);
  assert_int_equal(scree_edits_create(NULL, &w->edits), SCREE_OK);
}

static void begin_world(world* w, random_stream* r, uint32_t layers) {
  memset(w, 0, sizeof *w);
  w->count = layers;
  for (int a = 0; a < 3; ++a) w->middle[a] = random_in(r, -40, 40);
  for (uint32_t k = 0; k < layers; ++k) {
    w->shapes[k] = calloc(1, sizeof *w->shapes[k]);
    assert_non_null(w->shapes[k]);
  }
}

void make_world(world* w, random_stream* r, uint32_t layers) {
  begin_world(w, r, layers);
  for (uint32_t k = 0; k < layers; ++k) {
    w->sources[k] = synthetic_create(3 + random_below(r, 4), random_below(r, 3) > 0, random_below(r, 3) ? 1 : 3, random_bits(r));
    synthetic_add_hulls(&w->sources[k], random_bits(r), 1 + random_below(r, 3), random_below(r, 3) ? 4 : 0);
    w->source_of[k] = &w->sources[k].source;
    make_field(w, r, k, 0.6, 1.6);
    random_tree(w->shapes[k], r, 1 + random_below(r, 5), 7);
    make_support(w, r, k, 2);
    if (random_below(r, 3) == 0) w->layers[k].threshold = (float)random_in(r, 0.1, 0.9);
    if (random_below(r, 3) == 0) w->layers[k].shell_depth = (float)random_in(r, 0.5, 3);
    if (random_below(r, 4) == 0) w->layers[k].density = (float)random_in(r, 0.1, 1);
    if (random_below(r, 3) == 0) make_filters(w, r, k);
  }
  make_scene(w, r);
}

void make_thick_world(world* w, random_stream* r) {
  static const uint32_t children[] = {1, 2};
  begin_world(w, r, 1 + random_below(r, 3) / 2);
  uint32_t thick = random_below(r, w->count);
  for (uint32_t k = 0; k < w->count; ++k) {
    w->sources[k] = synthetic_create(3 + random_below(r, 4), random_below(r, 4) > 0, random_below(r, 3) ? 1 : 2, random_bits(r));
    synthetic_add_hulls(&w->sources[k], random_bits(r), 1 + random_below(r, 2), random_below(r, 2) ? 9 : 0);
    w->source_of[k] = &w->sources[k].source;
    make_field(w, r, k, 0.55, 0.8);
    random_support* s = w->shapes[k];
    s->shapes[0] = (scree_shape){.kind = SCREE_SHAPE_DIFFERENCE, .group = {children, 2, 0}};
    for (uint32_t i = 1; i < 3; ++i) {
      bool box = random_below(r, 2);
      float size = (float)(k == thick ? i == 1 ? random_in(r, 6.5, 9) : random_in(r, 0.2, 2) : random_in(r, 1, 2));
      s->shapes[i] = box ? (scree_shape){.kind = SCREE_SHAPE_BOX, .box = {{size, size * 0.9f, size}, 0}}
                         : (scree_shape){.kind = SCREE_SHAPE_SPHERE, .sphere = {size}};
      random_rotation(r, s->shapes[i].transform.rotation);
      for (int a = 0; a < 3; ++a) s->shapes[i].transform.translation[a] = (float)random_in(r, -2, 2);
    }
    s->desc = (scree_support_desc){.shapes = s->shapes, .shape_count = 3};
    make_support(w, r, k, k == thick ? 1 : 6);
    if (random_below(r, 4) == 0) w->layers[k].threshold = (float)random_in(r, 0.1, 0.9);
    if (random_below(r, 5) == 0) w->layers[k].shell_depth = (float)random_in(r, 3, 6);
    if (random_below(r, 5) == 0) w->layers[k].density = (float)random_in(r, 0.995, 1);
  }
  make_scene(w, r);
}

void make_mixed_world(world* w, random_stream* r, uint32_t layers) {
  begin_world(w, r, layers);
  for (uint32_t k = 0; k < layers; ++k) {
    w->sources[k] = synthetic_create(3 + random_below(r, 4), 1, random_below(r, 3) ? 1 : 2, random_bits(r));
    synthetic_add_hulls(&w->sources[k], random_bits(r), 1 + random_below(r, 3), random_below(r, 3) ? 4 : 0);
    w->source_of[k] = &w->sources[k].source;
    make_field(w, r, k, 0.5, 2);
    w->shapes[k]->shapes[0] = (scree_shape){.kind = SCREE_SHAPE_SPHERE, .sphere = {6}};
    w->shapes[k]->desc = (scree_support_desc){.shapes = w->shapes[k]->shapes, .shape_count = 1};
    make_support(w, r, k, 1);
    w->layers[k].density = k + 1 == layers ? 1 : (float)random_in(r, 0.02, 0.3);
  }
  make_scene(w, r);
}

/* A slab, tilted and rolling, with balls on it. */
static void roll(random_support* s, random_stream* r) {
  static const uint32_t children[] = {2, 3, 4};
  const float amplitude = (float)random_in(r, 0.05, 0.6), wavelength = (float)random_in(r, 3, 9);
  s->shapes[0] = (scree_shape){.kind = SCREE_SHAPE_NOISE, .noise = {.child = 1, .amplitude = amplitude, .wavelength = wavelength}};
  s->shapes[1] = (scree_shape){.kind = SCREE_SHAPE_UNION, .group = {children, 3, 0}};
  s->shapes[2] = (scree_shape){.kind = SCREE_SHAPE_BOX, .box = {{8, 1, 8}, 0}};
  const double tilt = random_in(r, -0.2, 0.2);
  s->shapes[2].transform.rotation[0] = (float)tilt;
  s->shapes[2].transform.rotation[3] = (float)sqrt(1 - tilt * tilt);
  for (int i = 3; i < 5; ++i) {
    s->shapes[i] = (scree_shape){.kind = SCREE_SHAPE_SPHERE, .sphere = {(float)random_in(r, 0.5, 4)}};
    for (int a = 0; a < 3; ++a) s->shapes[i].transform.translation[a] = (float)random_in(r, -4, 4);
  }
  s->shapes[1].transform.rotation[1] = s->shapes[1].transform.rotation[3] = 0.70710678f;
  s->desc = (scree_support_desc){.shapes = s->shapes, .shape_count = 5};
}

void make_scatter_world(world* w, random_stream* r, uint32_t layers) {
  begin_world(w, r, layers);
  const uint32_t first = random_below(r, 2);
  for (uint32_t k = 0; k < layers; ++k) {
    const bool scattered = random_below(r, 4) > 0 ? (k + first) % 2 == 0 : random_below(r, 2) == 0;
    if (scattered) {
      w->scatters[k] = malloc(sizeof *w->scatters[k]);
      assert_non_null(w->scatters[k]);
      double origin[3];
      for (int a = 0; a < 3; ++a) origin[a] = w->middle[a] + random_in(r, -50, 50);
      make_random_scatter(w->scatters[k], r, random_in(r, 0.8, 2.5), origin);
      w->scatter_of[k] = &w->scatters[k]->desc;
    } else {
      w->sources[k] = synthetic_create(3 + random_below(r, 4), 1, random_below(r, 3) ? 1 : 2, random_bits(r));
      synthetic_add_hulls(&w->sources[k], random_bits(r), 1 + random_below(r, 3), random_below(r, 3) ? 4 : 0);
      w->source_of[k] = &w->sources[k].source;
      make_field(w, r, k, 0.5, 1.5);
    }
    if (random_below(r, 4) > 0) {
      roll(w->shapes[k], r);
    } else {
      random_tree(w->shapes[k], r, 1 + random_below(r, 4), 7);
    }
    make_support(w, r, k, 2);
    if (scattered) w->layers[k].scatter = w->scatters[k]->scatter;
    w->layers[k].density = random_below(r, 3) ? 1 : (float)random_in(r, 0.2, 1);
    if (random_below(r, 3) == 0) make_filters(w, r, k);
  }
  make_scene(w, r);
}

void destroy_world(world* w) {
  scree_scene_destroy(w->scene);
  scree_edits_destroy(w->edits);
  for (uint32_t k = 0; k < w->count; ++k) {
    scree_field_destroy(w->fields[k]);
    scree_support_destroy(w->supports[k]);
    if (w->source_of[k] != NULL) synthetic_destroy(&w->sources[k]);
    if (w->scatters[k] != NULL) scree_scatter_destroy(w->scatters[k]->scatter);
    free(w->scatters[k]);
    free(w->shapes[k]);
  }
}

void add_edit(world* w, const scree_id* id, scree_edit edit) {
  if (w->edit_count == MAX_EDITS || scree_edits_get(w->edits, id) != SCREE_EDIT_NONE) return;
  w->edit_list[w->edit_count++] = (twin_edit){*id, edit};
  assert_int_equal(scree_edits_set(w->edits, id, edit), SCREE_OK);
}

void make_edits(world* w, random_stream* r, const scene_rocks* rocks) {
  for (int i = 0; i < 30 && rocks->count > 0; ++i) {
    uint64_t at = random_bits(r) % rocks->count;
    uint32_t bunch = random_below(r, 3) ? 1 : 1 + random_below(r, 10);
    for (uint32_t k = 0; k < bunch && at + k < rocks->count; ++k)
      add_edit(w, &rocks->rocks[at + k].id, random_below(r, 2) ? SCREE_EDIT_REMOVE : SCREE_EDIT_HIDE);
  }
}

scree_scene_query_desc random_question(const world* w, random_stream* r) {
  scree_scene_query_desc d = {.scene = w->scene};
  for (int a = 0; a < 3; ++a) {
    d.origin[a] = w->middle[a] + random_in(r, -30, 30);
    double p = w->middle[a] + random_in(r, -8, 8), q = w->middle[a] + random_in(r, -8, 8);
    d.min[a] = p < q ? p : q;
    d.max[a] = p < q ? q : p;
  }
  if (random_below(r, 2)) d.layers = 1 + random_below(r, (1u << w->count) - 1);
  double low[3], high[3];
  scree_scene_bounds(w->scene, low, high);
  bool small = true;
  for (int a = 0; a < 3; ++a) small = small && low[a] > w->middle[a] - 16 && high[a] < w->middle[a] + 16;
  if (small && random_below(r, 3) > 0) memset(d.min, 0, sizeof d.min), memset(d.max, 0, sizeof d.max);
  return d;
}
