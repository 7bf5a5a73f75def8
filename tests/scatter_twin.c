#include "scatter_twin.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* after the five above */
#include <cmocka.h>

/* The highest step of a line from `top` down to `low` that is inside, or low - 1. x, z: support's space. */
static int64_t ground_below(const scree_scatter* s, const scree_support* ground, double x, double z, int64_t top, int64_t low) {
  while (top >= low) {
    float xs[64], ys[64], zs[64], distance[64];
    uint32_t n = 0;
    for (; n < 64 && top - n >= low; ++n) {
      xs[n] = (float)x;
      ys[n] = (float)((s->origin[1] - ground->origin[1]) + s->unit * (double)(top - n));
      zs[n] = (float)z;
    }
    scree_support_distance(ground, xs, ys, zs, distance, n);
    for (uint32_t i = 0; i < n; ++i)
      if (distance[i] <= 0) return top - i;
    top -= n;
  }
  return low - 1;
}

static double weight_of(const scree_scatter_desc* d, uint32_t model) {
  return d->weights != NULL ? (double)d->weights[model] : 1;
}

static double uniform(uint64_t hash, uint64_t what) {
  return (double)(hash_combine(hash, what) >> 11) / 9007199254740992.0;
}

static uint32_t choose(const scree_scatter_desc* d, uint64_t hash, double x, double z) {
  uint32_t ages = d->age_count > 0 ? d->age_count : 1, model = 0;
  double sum = 0, at = weight_of(d, 0);
  for (uint32_t m = 0; m < d->model_count; ++m) sum += weight_of(d, m);
  while (uniform(hash, 1) * sum >= at) at += weight_of(d, ++model);
  if (d->age_mask == NULL) return model;
  const scree_filter* f = d->age_mask;
  double u = (x - f->centre[0]) / (double)f->spacing + (f->width - 1) * 0.5;
  double v = (z - f->centre[2]) / (double)f->spacing + (f->depth - 1) * 0.5;
  u = fmin(fmax(u, 0), f->width - 1.0);
  v = fmin(fmax(v, 0), f->depth - 1.0);
  uint32_t i = (uint32_t)fmin(u, f->width - 2.0), k = (uint32_t)fmin(v, f->depth - 2.0);
  u -= i;
  v -= k;
  const float* p = f->values + k * f->width + i;
  double share =
      ((double)p[0] * (1 - u) + (double)p[1] * u) * (1 - v) + ((double)p[f->width] * (1 - u) + (double)p[f->width + 1] * u) * v;
  if (f->inverted) share = 1 - share;
  return model / ages * ages + (uint32_t)fmin(floor(share * (ages - 1) + uniform(hash, 2)), ages - 1);
}

twin_stands twin_scatter(const scree_scatter* s, const scree_scatter_desc* desc, const scree_support* ground, const int32_t low[2],
                         const int32_t high[2], double top, double bottom) {
  twin_stands out = {NULL, 0};
  const int64_t first = (int64_t)ceil((top - desc->origin[1]) / s->unit),
                last = (int64_t)floor((bottom - desc->origin[1]) / s->unit);
  for (int32_t tz = low[1]; tz < high[1]; ++tz)
    for (int32_t tx = low[0]; tx < high[0]; ++tx) {
      uint32_t code = 0;
      for (int32_t i = 0; i < 4; ++i) code |= corner_colour(desc->seed, tx + (i & 1), 0, tz + (i >> 1)) << i;
      const scatter_tile* tile = &s->tiles[code];
      out.stands = realloc(out.stands, (out.count + tile->count + 1) * sizeof *out.stands);
      assert_non_null(out.stands);
      for (uint32_t local = 0; local < tile->count; ++local) {
        twin_stand stand = {.steps = {(int64_t)tx * 4096 + tile->x[local], 0, (int64_t)tz * 4096 + tile->z[local]}};
        const uint64_t hash = hash_combine(hash_corner(desc->seed ^ UINT64_C(0x5c3ee0f1e1d5a1d7), tx, 0, tz), local);
        const double x = (s->origin[0] - ground->origin[0]) + s->unit * (double)stand.steps[0];
        const double z = (s->origin[2] - ground->origin[2]) + s->unit * (double)stand.steps[2];
        stand.random = (uint32_t)(hash >> 32);
        stand.model = choose(desc, hash, desc->origin[0] + s->unit * (double)stand.steps[0],
                             desc->origin[2] + s->unit * (double)stand.steps[2]);
        float turn[2], scale;
        scree_scatter_turn(s, stand.random, turn, &scale);
        const double radius = (double)desc->models[stand.model].footprint_radius * (double)scale;
        const int64_t middle = ground_below(s, ground, x, z, first, last), slack = (int64_t)(radius * s->slope / s->unit);
        if (middle < last) continue;
        bool stands = true;
        stand.steps[1] = middle;
        for (int k = 0; k < 8; ++k) {
          const double h = 0.70710678118654752;
          const double c[8] = {1, h, 0, -h, -1, -h, 0, h}, n[8] = {0, h, 1, h, 0, -h, -1, -h};
          const int64_t edge = ground_below(s, ground, x + radius * c[k], z + radius * n[k], middle + slack + 1, middle - slack);
          stands = stands && edge >= middle - slack && edge <= middle + slack;
          if (edge < stand.steps[1]) stand.steps[1] = edge;
        }
        if (!stands) continue;
        stand.id = (scree_id){{tx, (int32_t)floor((double)stand.steps[1] / 4096), tz}, (uint16_t)local, 0};
        out.stands[out.count++] = stand;
      }
    }
  return out;
}

void make_random_scatter(random_scatter* s, random_stream* r, double spacing, const double origin[3]) {
  memset(s, 0, sizeof *s);
  const uint32_t ages = 1 + random_below(r, 3), variants = 1 + random_below(r, RANDOM_MODELS / ages);
  s->desc = (scree_scatter_desc){.models = s->models,
                                 .model_count = ages * variants,
                                 .age_count = ages,
                                 .spacing = spacing,
                                 .origin = {origin[0], origin[1], origin[2]},
                                 .seed = random_bits(r)};
  if (random_below(r, 2)) {
    s->desc.scale_min = (float)random_in(r, 0.5, 1.5);
    s->desc.scale_max = s->desc.scale_min + (float)random_in(r, 0, 1);
  }
  if (random_below(r, 2)) s->desc.max_slope = (float)random_in(r, 10, 75);
  for (uint32_t m = 0; m < s->desc.model_count; ++m) {
    scree_scatter_model* model = &s->models[m];
    model->footprint_radius = (float)(spacing * random_in(r, 0.05, 0.4));
    model->height = (float)(spacing * random_in(r, 0.2, 1));
    if (random_below(r, 2)) { /* a hull of its own */
      model->hull = s->hulls[m];
      model->hull_count = 4 + random_below(r, 9);
      for (uint32_t i = 0; i < 3 * model->hull_count; ++i)
        s->hulls[m][i] = (float)(spacing * (i % 3 == 1 ? random_in(r, -0.1, 0.8) : random_in(r, -0.4, 0.4)));
    }
    s->weights[m] = (float)random_in(r, 0.1, 2);
    if (m >= ages && random_below(r, 4) == 0) s->weights[m] = 0;
  }
  if (random_below(r, 2)) s->desc.weights = s->weights;
  if (random_below(r, 2)) {
    for (int i = 0; i < 20; ++i) s->image[i] = (float)fmin(fmax(random_in(r, -0.3, 1.3), 0), 1);
    s->mask = (scree_filter){.kind = SCREE_FILTER_MASK, .inverted = random_below(r, 2), .values = s->image, .width = 5, .depth = 4};
    s->mask.spacing = (float)random_in(r, 1, 10);
    for (int a = 0; a < 3; ++a) s->mask.centre[a] = origin[a] + random_in(r, -10, 10);
    s->desc.age_mask = &s->mask;
  }
  scree_error error;
  if (scree_scatter_create(&s->desc, NULL, &s->scatter, &error) != SCREE_OK) fail_msg("%s", error.message);
}
