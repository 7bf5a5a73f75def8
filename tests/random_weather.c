#include "random_weather.h"

#include <string.h>

uint32_t random_below(random_stream* random, uint32_t count) {
  return (uint32_t)(random_bits(random) >> 32) % count;
}

static double unit(random_stream* random, double low, double high) {
  return random_in(random, (scree_range){low, high});
}

static scree_support* random_shapes(random_stream* random, double width, double height, double depth) {
  scree_shape shapes[6];
  memset(shapes, 0, sizeof shapes);
  static const uint32_t children[5] = {1, 2, 3, 4, 5};
  shapes[0].kind = SCREE_SHAPE_UNION;
  shapes[0].group = (scree_group){children, 5, 0};
  const double least = width < depth ? width : depth;
  for (int i = 1; i < 6; ++i) {
    scree_shape* s = &shapes[i];
    s->transform.translation[0] = (float)unit(random, 0, width);
    s->transform.translation[1] = (float)unit(random, 0, height);
    s->transform.translation[2] = (float)unit(random, 0, depth);
    const float radius = (float)unit(random, least / 8 + 0.5, least / 2.5 + 1);
    if (i == 1) {
      s->kind = SCREE_SHAPE_TORUS;
      s->torus = (scree_torus){radius, radius / 3};
    } else if (i == 2) {
      s->kind = SCREE_SHAPE_BOX;
      s->box = (scree_box){{radius, radius / 2, radius}, 0};
    } else {
      s->kind = SCREE_SHAPE_SPHERE;
      s->sphere.radius = radius;
    }
  }
  const scree_support_desc desc = {.shapes = shapes, .shape_count = 6, .origin = {1000, -20, 3}};
  scree_support* support = NULL;
  return scree_support_create(&desc, NULL, &support, NULL) == SCREE_OK ? support : NULL;
}

void random_start_make(random_stream* random, uint32_t most, random_start* out) {
  memset(out, 0, sizeof *out);
  scree_weather_start* s = &out->start;
  s->seed = random_bits(random);
  for (int a = 0; a < 3; ++a) s->size[a] = 3 + random_below(random, most - 2);
  s->kind = (scree_start_kind)random_below(random, 4);
  if (s->kind == SCREE_START_BOX || s->kind == SCREE_START_JOINTS) {
    if (random_below(random, 4) != 0)
      for (int a = 0; a < 3; ++a) {
        s->box_min[a] = random_below(random, s->size[a] / 3 + 1);
        s->box_max[a] = s->size[a] - random_below(random, s->size[a] / 3 + 1);
      }
    s->joint_spacing = unit(random, 4, 9);
    s->joint_gap = unit(random, 0, 0.25);
    s->joint_warp = unit(random, 0, 0.5);
    s->joint_missing = unit(random, 0, 0.3);
    s->joint_low = unit(random, 0.4, 1);
  } else if (s->kind == SCREE_START_JOINT_MAP) {
    s->map = out->map;
    s->map_width = 1 + random_below(random, 32);
    s->map_depth = 1 + random_below(random, 32);
    for (uint32_t i = 0; i < s->map_width * s->map_depth; ++i)
      out->map[i] = random_below(random, 3) == 0 ? 0 : (uint8_t)random_below(random, 256);
  } else {
    s->voxel = unit(random, 0.2, 2);
    for (int a = 0; a < 3; ++a) s->origin[a] = a == 0 ? 1000 : a == 1 ? -20 : 3;
    s->support = out->support = random_shapes(random, s->voxel * s->size[0], s->voxel * s->size[1], s->voxel * s->size[2]);
  }
}

void random_start_free(random_start* start) {
  scree_support_destroy(start->support);
}

static scree_bubble random_bubble(random_stream* random, double most_radius) {
  scree_bubble b = {(scree_bubble_kind)random_below(random, 4), unit(random, 1, most_radius), unit(random, 1, most_radius)};
  if (random_below(random, 2) == 0) b.radius = (double)(uint32_t)b.radius;
  return b;
}

static scree_curve random_curve(random_stream* random) {
  scree_curve c = {(scree_curve_kind)random_below(random, 5), unit(random, 0.2, 2), unit(random, -0.1, 0.1), unit(random, 0.05, 1),
                   1 + random_below(random, 4)};
  if (c.kind == SCREE_CURVE_SATURATING) c.gain /= 3;
  return c;
}

void random_rules_make(random_stream* random, double most_radius, random_rules* out) {
  memset(out, 0, sizeof *out);
  scree_weather_rules* r = &out->rules;
  r->durability = out->points;
  r->durability_count = 1 + random_below(random, 8);
  double altitude = random_below(random, 2) == 0 ? 0 : 0.2;
  for (uint32_t i = 0; i < r->durability_count; ++i) {
    out->points[i].altitude = altitude;
    out->points[i].durability = unit(random, 0.3, 2);
    if (random_below(random, 2) == 0) {
      out->points[i].noise_amplitude = unit(random, 0.1, 1.5);
      out->points[i].noise_period = random_below(random, 3) == 0 ? 0 : unit(random, 1, 30);
      out->points[i].noise_squash = random_below(random, 2) == 0 ? 0 : unit(random, 0.5, 3);
    }
    altitude += random_below(random, 5) == 0 ? 0 : (1 - altitude) * unit(random, 0, 0.4);
  }
  r->bubbles = out->segments;
  r->bubble_count = 1 + random_below(random, 4);
  altitude = 0;
  for (uint32_t i = 0; i < r->bubble_count; ++i) {
    scree_bubble_segment* s = &out->segments[i];
    s->altitude = altitude;
    s->bubble_count = random_below(random, 2) == 0 ? 1 : 1 + random_below(random, 4);
    for (uint32_t k = 0; k < s->bubble_count; ++k) s->bubbles[k] = random_bubble(random, most_radius);
    s->noise_period = random_below(random, 2) == 0 ? 0 : unit(random, 2, 12);
    altitude += (1 - altitude) * unit(random, 0.1, 0.6);
  }
  r->spheroidal = random_curve(random);
  r->cavernous = random_below(random, 2) == 0 ? random_curve(random) : (scree_curve){0};
  r->exposure = random_below(random, 3) == 0 ? 0 : unit(random, 0, 2);
  r->steps_per_voxel = unit(random, 1, 8);
  r->colluvium_share = random_below(random, 3) == 0 ? 0 : random_below(random, 5) == 0 ? 1 : unit(random, 0, 1);
  r->colluvium_durability = unit(random, 0.1, 1);
  r->repose = unit(random, 1.0 / 16, 4);
  r->rockfall = (scree_rockfall)random_below(random, 3);
}
