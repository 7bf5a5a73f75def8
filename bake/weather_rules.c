#include "weather_rules.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "faults.h"
#include "support_text.h"

static const scree_durability_point default_durability[1] = {{.durability = 1}};
static const scree_bubble_segment default_bubbles[1] = {{.bubbles = {{SCREE_BUBBLE_SPHERE, 4, 0}}, .bubble_count = 1}};

void scree_weather_rules_default(scree_weather_rules* out) {
  *out = (scree_weather_rules){
      .durability = default_durability,
      .durability_count = 1,
      .bubbles = default_bubbles,
      .bubble_count = 1,
      .spheroidal = {.kind = SCREE_CURVE_CUBIC, .gain = 1},
      .exposure = 0.6,
      .steps_per_voxel = 12,
      .colluvium_share = 0.2,
      .colluvium_durability = 0.35,
      .repose = 0.7,
      .rockfall = SCREE_ROCKFALL_COLLUVIUM,
  };
}

/* --- checks ------------------------------------------------------------------------------------------------------------------ */

/* As fault_value, with the place in an array: "array[index].name: value: what". */
static scree_result wrong_at(scree_error* error, const char* array, uint32_t index, const char* name, double value,
                             const char* what) {
  scree_rt_text_clear(error);
  scree_rt_text_add(error, array);
  scree_rt_text_add(error, "[");
  scree_rt_text_add_count(error, index);
  scree_rt_text_add(error, "].");
  scree_rt_text_add(error, name);
  scree_rt_text_add(error, ": ");
  return fault_add(error, value, what);
}

static scree_result missing(scree_error* error, const char* what) {
  scree_rt_text_clear(error);
  scree_rt_text_add(error, what);
  return SCREE_ERROR_INVALID_ARGUMENT;
}

static scree_result check_durability(const scree_weather_rules* rules, scree_error* error) {
  static const char array[] = "durability";
  for (uint32_t i = 0; i < rules->durability_count; ++i) {
    const scree_durability_point* p = &rules->durability[i];
    if (!within(p->altitude, i > 0 ? rules->durability[i - 1].altitude : 0, 1))
      return wrong_at(error, array, i, "altitude", p->altitude, "0 to 1 and not below that of the point before");
    if (!(p->durability > 0) || !(p->durability <= 1e6))
      return wrong_at(error, array, i, "durability", p->durability, "more than 0, up to 1e6");
    if (!within(p->noise_amplitude, 0, 4)) return wrong_at(error, array, i, "noise_amplitude", p->noise_amplitude, "0 to 4");
    if (p->noise_period != 0 && !within(p->noise_period, 1, 1e6))
      return wrong_at(error, array, i, "noise_period", p->noise_period, "1 to 1e6 voxels, or 0 for 16");
    if (p->noise_squash != 0 && !within(p->noise_squash, 0.1, 100))
      return wrong_at(error, array, i, "noise_squash", p->noise_squash, "0.1 to 100, or 0 for 1");
  }
  return SCREE_OK;
}

static scree_result check_bubbles(const scree_weather_rules* rules, const uint32_t size[3], scree_error* error) {
  static const char array[] = "bubbles";
  uint32_t side = size[0] > size[1] ? size[0] : size[1];
  if (size[2] > side) side = size[2];
  for (uint32_t i = 0; i < rules->bubble_count; ++i) {
    const scree_bubble_segment* s = &rules->bubbles[i];
    if (!within(s->altitude, i > 0 ? rules->bubbles[i - 1].altitude : 0, 1))
      return wrong_at(error, array, i, "altitude", s->altitude, "0 to 1 and not below that of the segment before");
    if (s->bubble_count < 1 || s->bubble_count > 4) return wrong_at(error, array, i, "bubble_count", s->bubble_count, "1 to 4");
    if (s->noise_period != 0 && !within(s->noise_period, 1, 1e6))
      return wrong_at(error, array, i, "noise_period", s->noise_period, "1 to 1e6 voxels, or 0 for 16");
    for (uint32_t k = 0; k < s->bubble_count; ++k) {
      const scree_bubble* b = &s->bubbles[k];
      if ((uint32_t)b->kind > SCREE_BUBBLE_DISC) return wrong_at(error, array, i, "kind", b->kind, "no such bubble");
      if (!within(b->radius, 1, 12)) return wrong_at(error, array, i, "radius", b->radius, "1 to 12");
      if (b->radius > side) return wrong_at(error, array, i, "radius", b->radius, "larger than the grid");
      if (b->kind == SCREE_BUBBLE_ELLIPSOID && !within(b->height, 1, 12))
        return wrong_at(error, array, i, "height", b->height, "1 to 12");
      if (b->kind == SCREE_BUBBLE_ELLIPSOID && b->height > side)
        return wrong_at(error, array, i, "height", b->height, "larger than the grid");
    }
  }
  return SCREE_OK;
}

static scree_result check_curve(const scree_curve* curve, bool cavernous, scree_error* error) {
  if ((uint32_t)curve->kind > SCREE_CURVE_SATURATING)
    return fault_value(error, cavernous ? "cavernous.kind" : "spheroidal.kind", curve->kind, "no such curve");
  if (curve->kind == SCREE_CURVE_NONE) return SCREE_OK;
  if (!within(curve->gain, 0, 1e3))
    return fault_value(error, cavernous ? "cavernous.gain" : "spheroidal.gain", curve->gain, "0 to 1000");
  if (curve->kind != SCREE_CURVE_SATURATING) return SCREE_OK;
  if (!within(curve->threshold, -1, 1))
    return fault_value(error, cavernous ? "cavernous.threshold" : "spheroidal.threshold", curve->threshold, "-1 to 1");
  if (!(curve->saturation > 0) || !(curve->saturation <= 2))
    return fault_value(error, cavernous ? "cavernous.saturation" : "spheroidal.saturation", curve->saturation,
                       "more than 0, up to 2");
  if (curve->power < 1 || curve->power > 4)
    return fault_value(error, cavernous ? "cavernous.power" : "spheroidal.power", curve->power, "1 to 4");
  return SCREE_OK;
}

scree_result weather_check_rules(const scree_weather_rules* rules, const uint32_t size[3], scree_error* error) {
  if (rules->durability == NULL || rules->bubbles == NULL) return missing(error, "rules: no durability graph or no bubble graph");
  if (rules->durability_count < 1 || rules->durability_count > 256)
    return fault_value(error, "durability_count", rules->durability_count, "1 to 256");
  if (rules->bubble_count < 1 || rules->bubble_count > 64)
    return fault_value(error, "bubble_count", rules->bubble_count, "1 to 64");
  scree_result result = check_durability(rules, error);
  if (result == SCREE_OK) result = check_bubbles(rules, size, error);
  if (result == SCREE_OK) result = check_curve(&rules->spheroidal, false, error);
  if (result == SCREE_OK) result = check_curve(&rules->cavernous, true, error);
  if (result != SCREE_OK) return result;
  if (!within(rules->exposure, 0, 2)) return fault_value(error, "exposure", rules->exposure, "0 to 2");
  if (!within(rules->steps_per_voxel, 1, 1e4)) return fault_value(error, "steps_per_voxel", rules->steps_per_voxel, "1 to 1e4");
  if (!within(rules->colluvium_share, 0, 1)) return fault_value(error, "colluvium_share", rules->colluvium_share, "0 to 1");
  if (!(rules->colluvium_durability > 0) || !(rules->colluvium_durability <= 1e6))
    return fault_value(error, "colluvium_durability", rules->colluvium_durability, "more than 0, up to 1e6");
  if (!within(rules->repose, 1.0 / 16, 4)) return fault_value(error, "repose", rules->repose, "1/16 to 4");
  if ((uint32_t)rules->rockfall > SCREE_ROCKFALL_COLLUVIUM)
    return fault_value(error, "rockfall", rules->rockfall, "no such kind of rockfall");
  return SCREE_OK;
}

/* --- bubbles ----------------------------------------------------------------------------------------------------------------- */

static bool inside(const scree_bubble* b, int32_t x, int32_t y, int32_t z) {
  const double across = (double)(x * x + z * z), up = (double)(y * y), r2 = b->radius * b->radius;
  switch (b->kind) {
    case SCREE_BUBBLE_ELLIPSOID: return across * (b->height * b->height) + up * r2 <= r2 * (b->height * b->height);
    case SCREE_BUBBLE_GUMDROP: return across + up <= r2 && y >= -b->radius / 2;
    case SCREE_BUBBLE_DISC: return across <= r2 && y >= -1 && y <= 1;
    case SCREE_BUBBLE_SPHERE: break;
  }
  return across + up <= r2;
}

static void make_bubble(const scree_bubble* shape, weather_bubble* out) {
  memset(out, 0, sizeof *out);
  memset(out->half, -1, sizeof out->half);
  out->shape = *shape;
  for (int32_t z = -WEATHER_MARGIN; z <= WEATHER_MARGIN; ++z)
    for (int32_t y = -WEATHER_MARGIN; y <= WEATHER_MARGIN; ++y) {
      if (!inside(shape, 0, y, z)) continue;
      int32_t half = 0;
      while (half < WEATHER_MARGIN && inside(shape, half + 1, y, z)) ++half;
      out->half[z + WEATHER_MARGIN][y + WEATHER_MARGIN] = (int8_t)half;
      out->volume += (uint32_t)(2 * half + 1);
      if (y > 0) out->flat += (uint32_t)(2 * half + 1);
      if (abs(y) > out->reach_y) out->reach_y = abs(y);
      if (abs(z) > out->reach_z) out->reach_z = abs(z);
    }
}

/* The different bubbles of the rules, in the order in which they come first. */
static uint32_t collect_bubbles(const scree_weather_rules* rules, scree_bubble out[256], uint8_t index[64][4]) {
  uint32_t count = 0;
  for (uint32_t i = 0; i < rules->bubble_count; ++i)
    for (uint32_t k = 0; k < rules->bubbles[i].bubble_count; ++k) {
      scree_bubble b = rules->bubbles[i].bubbles[k];
      if (b.kind != SCREE_BUBBLE_ELLIPSOID) b.height = 0;
      uint32_t at = 0;
      while (at < count && (out[at].kind != b.kind || out[at].radius != b.radius || out[at].height != b.height)) ++at;
      if (at == count) out[count++] = b;
      index[i][k] = (uint8_t)at;
    }
  return count;
}

/* --- rates ------------------------------------------------------------------------------------------------------------------- */

static double curve_value(scree_curve_kind kind, double x) {
  return kind == SCREE_CURVE_LINEAR ? x : kind == SCREE_CURVE_CUBIC ? 3 * (x * x * x) : 3 * (x * x * (x * x));
}

static double curve_rate(const scree_curve* curve, double x, double x_flat, double steps) {
  if (curve->kind == SCREE_CURVE_NONE) return 0;
  if (curve->kind != SCREE_CURVE_SATURATING)
    return curve->gain * curve_value(curve->kind, x) / curve_value(curve->kind, x_flat) / steps;
  double t = (x - x_flat - curve->threshold) / curve->saturation, power = 1;
  t = t < 0 ? 0 : t > 1 ? 1 : t;
  for (uint32_t i = 0; i < curve->power; ++i) power *= t;
  return curve->gain * power;
}

/* k^e for e in 0..2 from the binary digits of e: libm's pow differs between systems. */
static double power_of(double k, double e) {
  double result = 1, root = k;
  while (e >= 1) result *= k, e -= 1;
  for (int digit = 0; digit < 52 && e > 0; ++digit) {
    root = sqrt(root);
    e *= 2;
    if (e >= 1) result *= root, e -= 1;
  }
  return result;
}

/* The nearest cell over which a whole step is within 6 % of the slope, or else the best. */
static void make_repose(double slope, weather_repose* out) {
  double least = 1e30;
  for (int32_t far = 1; far <= 16 && least > 0.06 * slope; ++far) {
    const double step = floor(slope * far + 0.5), error = fabs(step / far - slope);
    if (step < 1 || error >= least) continue;
    least = error;
    out->look = far;
    out->steps[far] = (int32_t)step;
  }
  for (int32_t far = 1; far < out->look; ++far) out->steps[far] = (int32_t)ceil(slope * far);
}

/* --- layers ------------------------------------------------------------------------------------------------------------------ */

static void make_layer(const scree_weather_rules* rules, uint8_t index[64][4], double altitude, weather_layer* out) {
  const scree_durability_point* p = rules->durability;
  uint32_t below = 0; /* points at this altitude or below */
  while (below < rules->durability_count && p[below].altitude <= altitude) ++below;
  double value = p[below > 0 ? below - 1 : 0].durability;
  if (below > 0 && below < rules->durability_count) {
    const scree_durability_point *a = &p[below - 1], *b = &p[below];
    value = a->durability + (b->durability - a->durability) * ((altitude - a->altitude) / (b->altitude - a->altitude));
  }
  memset(out, 0, sizeof *out);
  out->graph = value > 1e-30 ? (float)value : 1e-30f;
  out->colluvium = value * rules->colluvium_durability > 1e-30 ? (float)(value * rules->colluvium_durability) : 1e-30f;
  out->segment = (uint8_t)(below < 255 ? below : 255);
  out->point = (uint8_t)(below > 0 ? below - 1 : 0);
  out->amplitude = (float)p[out->point].noise_amplitude;
  uint32_t segment = 0;
  while (segment + 1 < rules->bubble_count && rules->bubbles[segment + 1].altitude <= altitude) ++segment;
  const scree_bubble_segment* s = &rules->bubbles[segment];
  out->bubble_count = (uint8_t)s->bubble_count;
  memcpy(out->bubbles, index[segment], sizeof out->bubbles);
  out->mixture_period = s->bubble_count == 1 ? 0 : s->noise_period != 0 ? s->noise_period : 16;
}

/* --- all of it --------------------------------------------------------------------------------------------------------------- */

/* Where each part lies in the one allocation; parts start at multiples of 64. */
typedef struct parts {
  size_t layers, bubbles, rates, points, total;
} parts;

static size_t place(size_t* total, size_t bytes) {
  const size_t at = *total;
  *total += (bytes + 63) / 64 * 64;
  return at;
}

static parts lay_out(uint32_t layers, uint32_t bubbles, uint32_t rates, uint32_t points) {
  parts p = {0};
  place(&p.total, sizeof(weather_tables));
  p.layers = place(&p.total, layers * sizeof(weather_layer));
  p.bubbles = place(&p.total, bubbles * sizeof(weather_bubble));
  p.rates = place(&p.total, rates * sizeof(float));
  p.points = place(&p.total, points * sizeof(scree_durability_point));
  return p;
}

static uint32_t count_rates(const scree_bubble* shapes, uint32_t count) {
  uint32_t rates = 0;
  for (uint32_t i = 0; i < count; ++i) {
    weather_bubble bubble;
    make_bubble(&shapes[i], &bubble);
    rates += bubble.volume + 1;
  }
  return rates;
}

size_t weather_tables_bytes(const scree_weather_rules* rules, const uint32_t size[3], bool* mixed) {
  scree_bubble shapes[256];
  uint8_t index[64][4];
  const uint32_t bubbles = collect_bubbles(rules, shapes, index);
  *mixed = false;
  for (uint32_t i = 0; i < rules->bubble_count; ++i) *mixed = *mixed || rules->bubbles[i].bubble_count > 1;
  return lay_out(size[1], bubbles, count_rates(shapes, bubbles), rules->durability_count).total;
}

scree_result weather_tables_create(const scree_weather_rules* rules, const uint32_t size[3], const scree_allocator* allocator,
                                   weather_tables** out) {
  scree_bubble shapes[256];
  uint8_t index[64][4] = {{0}};
  const uint32_t bubbles = collect_bubbles(rules, shapes, index), rates = count_rates(shapes, bubbles);
  const parts at = lay_out(size[1], bubbles, rates, rules->durability_count);
  char* memory = scree_rt_allocate_zeroed(allocator, at.total, 1);
  if (memory == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  weather_tables* t = (weather_tables*)(void*)memory;
  t->bytes = at.total;
  t->layers = (weather_layer*)(void*)(memory + at.layers);
  t->bubbles = (weather_bubble*)(void*)(memory + at.bubbles);
  t->rates = (float*)(void*)(memory + at.rates);
  t->points = (scree_durability_point*)(void*)(memory + at.points);
  t->bubble_count = bubbles;
  t->point_count = rules->durability_count;
  memcpy(t->points, rules->durability, rules->durability_count * sizeof *t->points);
  for (uint32_t i = 0; i < t->point_count; ++i) {
    if (t->points[i].noise_period == 0) t->points[i].noise_period = 16;
    if (t->points[i].noise_squash == 0) t->points[i].noise_squash = 1;
  }
  for (uint32_t i = 0; i < bubbles; ++i) {
    weather_bubble* b = &t->bubbles[i];
    make_bubble(&shapes[i], b);
    b->rate_first = t->rate_count;
    t->rate_count += b->volume + 1;
    if (b->reach_y > t->reach) t->reach = b->reach_y;
    if (b->reach_z > t->reach) t->reach = b->reach_z;
    const double flat = (double)b->flat / b->volume;
    for (uint32_t count = 0; count <= b->volume; ++count) {
      const double c = (double)count / b->volume;
      const double rate = curve_rate(&rules->spheroidal, c, flat, rules->steps_per_voxel) +
                          curve_rate(&rules->cavernous, 1 - c, 1 - flat, rules->steps_per_voxel);
      t->rates[b->rate_first + count] = (float)(rate * WEATHER_FULL);
    }
  }
  for (uint32_t y = 0; y < size[1]; ++y) {
    make_layer(rules, index, ((double)y + 0.5) / size[1], &t->layers[y]);
    t->mixed = t->mixed || t->layers[y].bubble_count > 1;
  }
  for (uint32_t k = 1; k <= 6; ++k) t->exposure[k] = (float)power_of(k, rules->exposure);
  t->share = (uint64_t)ceil(rules->colluvium_share * 4294967296.0);
  make_repose(rules->repose, &t->repose[0]);
  make_repose(rules->repose * sqrt(2), &t->repose[1]);
  t->rockfall = rules->rockfall;
  *out = t;
  return SCREE_OK;
}

void weather_tables_destroy(weather_tables* tables, const scree_allocator* allocator) {
  if (tables != NULL) scree_rt_release(allocator, tables, tables->bytes, 1);
}

bool weather_same_noise(const weather_tables* a, const weather_tables* b, uint32_t layers) {
  for (uint32_t y = 0; y < layers; ++y) {
    const scree_durability_point *p = &a->points[a->layers[y].point], *q = &b->points[b->layers[y].point];
    const bool none = a->layers[y].amplitude == 0, other_none = b->layers[y].amplitude == 0;
    if (none != other_none) return false;
    if (!none && (p->noise_period != q->noise_period || p->noise_squash != q->noise_squash)) return false;
  }
  return true;
}

bool weather_same_bubbles(const weather_tables* a, const weather_tables* b, uint32_t layers) {
  for (uint32_t y = 0; y < layers; ++y) {
    const weather_layer *l = &a->layers[y], *m = &b->layers[y];
    if (l->bubble_count != m->bubble_count || l->mixture_period != m->mixture_period) return false;
    for (uint32_t k = 0; k < l->bubble_count; ++k) {
      const scree_bubble *s = &a->bubbles[l->bubbles[k]].shape, *t = &b->bubbles[m->bubbles[k]].shape;
      if (s->kind != t->kind || s->radius != t->radius || s->height != t->height) return false;
    }
  }
  return true;
}
