/* What a scatter knows of its models: footprints, weights, and convex parts in metres. */
#include <math.h>
#include <string.h>

#include "allocator.h"
#include "convex.h"
#include "scatter_internal.h"
#include "support_text.h"

/* --- checks ----------------------------------------------------------------------------------------------------------------- */

scree_result scree_rt_scatter_wrong(scree_result code, const char* what, scree_error* error) {
  scree_rt_text_add(error, what);
  return code;
}

scree_result scree_rt_scatter_wrong_number(const char* name, double value, const char* range, scree_error* error) {
  scree_rt_text_add(error, name);
  scree_rt_text_add(error, " is ");
  scree_rt_text_add_number(error, value);
  scree_rt_text_add(error, ", it has to be ");
  scree_rt_text_add(error, range);
  return SCREE_ERROR_RANGE;
}

static bool is_length(float value) {
  return value > 0 && value <= 1e9f;
}

static scree_result check_model(const scree_scatter_model* m, scree_error* error) {
  if (!is_length(m->footprint_radius))
    return scree_rt_scatter_wrong_number("footprint_radius", (double)m->footprint_radius, "above 0", error);
  if (!is_length(m->height)) return scree_rt_scatter_wrong_number("height", (double)m->height, "above 0", error);
  if (m->outer_radius != 0 && !is_length(m->outer_radius))
    return scree_rt_scatter_wrong_number("outer_radius", (double)m->outer_radius, "0 or more", error);
  if (m->hull == NULL) return SCREE_OK;
  if (m->hull_count < 4 || m->hull_count > CONVEX_MAX_POINTS)
    return scree_rt_scatter_wrong_number("hull_count", m->hull_count, "4..64", error);
  for (uint32_t i = 0; i < 3 * m->hull_count; ++i)
    if (!(fabsf(m->hull[i]) <= 1e9f))
      return scree_rt_scatter_wrong_number("a coordinate of the hull", (double)m->hull[i], "at most 1e9", error);
  return SCREE_OK;
}

static scree_result check_models(const scree_scatter_desc* d, scree_error* error) {
  if (d->models == NULL) return scree_rt_scatter_wrong(SCREE_ERROR_INVALID_ARGUMENT, "models is NULL, and so is pack", error);
  if (d->model_count < 1 || d->model_count > SCATTER_MOST_MODELS)
    return scree_rt_scatter_wrong_number("model_count", d->model_count, "1..65536", error);
  if (d->age_count > 0 && d->model_count % d->age_count != 0)
    return scree_rt_scatter_wrong(SCREE_ERROR_INVALID_ARGUMENT, "age_count does not divide model_count", error);
  for (uint32_t i = 0; i < d->model_count; ++i) {
    scree_error inner;
    scree_rt_text_clear(&inner);
    const scree_result result = check_model(&d->models[i], &inner);
    if (result == SCREE_OK) continue;
    scree_rt_text_add(error, "model ");
    scree_rt_text_add_count(error, i);
    scree_rt_text_add(error, ": ");
    return scree_rt_scatter_wrong(result, inner.message, error);
  }
  return SCREE_OK;
}

static scree_result copy_weights(scree_scatter* s, const float* weights, scree_error* error) {
  double sum = 0;
  for (uint32_t i = 0; i < s->model_count; ++i) {
    const double weight = weights != NULL ? (double)weights[i] : 1;
    if (!(weight >= 0 && weight <= 1e9)) return scree_rt_scatter_wrong_number("a weight", weight, "0 or more", error);
    s->models[i].weight = weight;
    sum += weight;
  }
  return sum > 0 ? SCREE_OK : scree_rt_scatter_wrong(SCREE_ERROR_INVALID_ARGUMENT, "weights: no model has any", error);
}

/* --- tables ----------------------------------------------------------------------------------------------------------------- */

static bool allocate(scree_scatter* s) {
  s->models = scree_rt_allocate_zeroed(&s->allocator, s->model_count, sizeof *s->models);
  s->variants = scree_rt_allocate_zeroed(&s->allocator, (size_t)s->variant_count + 1, sizeof *s->variants);
  s->parts = scree_rt_allocate_zeroed(&s->allocator, s->part_count, sizeof *s->parts);
  s->x = scree_rt_allocate(&s->allocator, (size_t)3 * s->point_count, sizeof *s->x);
  if (s->models == NULL || s->variants == NULL || s->parts == NULL || s->x == NULL) return false;
  s->y = s->x + s->point_count;
  s->z = s->y + s->point_count;
  return true;
}

void scree_rt_scatter_drop_models(scree_scatter* s) {
  scree_rt_release(&s->allocator, s->models, s->model_count, sizeof *s->models);
  scree_rt_release(&s->allocator, s->variants, (size_t)s->variant_count + 1, sizeof *s->variants);
  scree_rt_release(&s->allocator, s->parts, s->part_count, sizeof *s->parts);
  scree_rt_release(&s->allocator, s->x, (size_t)3 * s->point_count, sizeof *s->x);
}

/* A ball round the middle of a part's box. Returns how far it reaches from the model's origin. */
static double measure_part(const scree_scatter* s, scatter_part* part) {
  const float* axes[3] = {s->x + part->first, s->y + part->first, s->z + part->first};
  double radius2 = 0, away2 = 0;
  for (int a = 0; a < 3; ++a) {
    float low = axes[a][0], high = axes[a][0];
    for (uint32_t i = 1; i < part->count; ++i) {
      low = axes[a][i] < low ? axes[a][i] : low;
      high = axes[a][i] > high ? axes[a][i] : high;
    }
    part->centre[a] = (low + high) * 0.5f;
    away2 += (double)part->centre[a] * (double)part->centre[a];
  }
  for (uint32_t i = 0; i < part->count; ++i) {
    double d2 = 0;
    for (int a = 0; a < 3; ++a) {
      const double d = (double)axes[a][i] - (double)part->centre[a];
      d2 += d * d;
    }
    radius2 = d2 > radius2 ? d2 : radius2;
  }
  part->radius = (float)(sqrt(radius2) * 1.000001);
  return sqrt(away2) + (double)part->radius;
}

/* The largest of all models decide for the scatter, before its scale. */
static void count_in(scree_scatter* s, double footprint, double outer) {
  s->outer_radius = fmax(s->outer_radius, outer);
  s->sink = fmax(s->sink, footprint); /* to be multiplied by the slope */
}

/* --- the host's own --------------------------------------------------------------------------------------------------------- */

enum { PRISM = 8 };

static const float circle[PRISM][2] = {{1, 0},  {0.70710677f, 0.70710677f},   {0, 1},  {-0.70710677f, 0.70710677f},
                                       {-1, 0}, {-0.70710677f, -0.70710677f}, {0, -1}, {0.70710677f, -0.70710677f}};

static uint32_t points_of(const scree_scatter_model* m) {
  return m->hull != NULL ? m->hull_count : 2 * PRISM;
}

/* Copies the hull of a model, or makes one: an eight-sided prism round its footprint. */
static void fill_part(scree_scatter* s, const scree_scatter_model* m, const scatter_part* part) {
  float *x = s->x + part->first, *y = s->y + part->first, *z = s->z + part->first;
  for (uint32_t i = 0; i < part->count; ++i) {
    x[i] = m->hull != NULL ? m->hull[3 * i] : circle[i % PRISM][0] * m->footprint_radius;
    y[i] = m->hull != NULL ? m->hull[3 * i + 1] : i < PRISM ? 0 : m->height;
    z[i] = m->hull != NULL ? m->hull[3 * i + 2] : circle[i % PRISM][1] * m->footprint_radius;
  }
}

static scree_result copy_own(scree_scatter* s, const scree_scatter_desc* d, scree_error* error) {
  const scree_result result = check_models(d, error);
  if (result != SCREE_OK) return result;
  const uint32_t ages = d->age_count > 0 ? d->age_count : 1;
  s->model_count = s->part_count = d->model_count;
  s->variant_count = d->model_count / ages;
  for (uint32_t i = 0; i < d->model_count; ++i) s->point_count += points_of(&d->models[i]);
  if (!allocate(s)) return SCREE_ERROR_OUT_OF_MEMORY;
  for (uint32_t v = 0; v <= s->variant_count; ++v) s->variants[v] = v * ages;
  for (uint32_t i = 0, at = 0; i < d->model_count; ++i) {
    const scree_scatter_model* m = &d->models[i];
    const double footprint = (double)m->footprint_radius, height = (double)m->height;
    s->models[i] = (scatter_model){.footprint = m->footprint_radius, .first_part = i, .part_count = 1};
    s->parts[i].first = at;
    s->parts[i].count = points_of(m);
    at += s->parts[i].count;
    fill_part(s, m, &s->parts[i]);
    const double outer = fmax(sqrt(footprint * footprint + height * height), measure_part(s, &s->parts[i]));
    count_in(s, footprint, fmax(outer, (double)m->outer_radius));
  }
  return SCREE_OK;
}

/* --- of a pack -------------------------------------------------------------------------------------------------------------- */

/* Sizes of all tables. */
static scree_result measure_pack(scree_scatter* s, scree_error* error) {
  scree_pack_info info;
  scree_pack_get_info(s->pack, &info);
  if (!s->is_cliff && info.kind == SCREE_PACK_CLIFF)
    return scree_rt_scatter_wrong(
        SCREE_ERROR_INVALID_ARGUMENT,
        "pack: expected one of models, this is a cliff, whose blocks lie where they fell: see scree_cliff_create", error);
  if (!s->is_cliff && info.kind != SCREE_PACK_MODELS)
    return scree_rt_scatter_wrong(SCREE_ERROR_INVALID_ARGUMENT, "pack: expected one of models", error);
  if (info.asset_count < 1 || info.asset_count > SCATTER_MOST_MODELS || info.lattice_per_cell < 1)
    return scree_rt_scatter_wrong(SCREE_ERROR_CORRUPT, "pack: too many models, or none", error);
  s->model_count = info.asset_count;
  s->variant_count = info.variant_count;
  for (uint32_t asset = 0; asset < s->model_count; ++asset) {
    scree_model model;
    scree_result result = scree_pack_get_model(s->pack, asset, &model);
    for (uint32_t k = 0; result == SCREE_OK && k < model.part_count; ++k) {
      uint32_t count;
      result = scree_pack_get_part(s->pack, asset, k, NULL, 0, &count);
      if (result == SCREE_ERROR_CAPACITY) result = count >= 4 && count <= CONVEX_MAX_POINTS ? SCREE_OK : SCREE_ERROR_CORRUPT;
      s->point_count += count;
      ++s->part_count;
    }
    if (result != SCREE_OK) return scree_rt_scatter_wrong(result, "pack: a model cannot be read", error);
  }
  return SCREE_OK;
}

static scree_result copy_pack_part(scree_scatter* s, uint32_t asset, uint32_t k, scatter_part* part, float step) {
  int16_t points[CONVEX_MAX_POINTS][3];
  const scree_result result = scree_pack_get_part(s->pack, asset, k, points[0], CONVEX_MAX_POINTS, &part->count);
  for (uint32_t i = 0; result == SCREE_OK && i < part->count; ++i) {
    s->x[part->first + i] = (float)points[i][0] * step;
    s->y[part->first + i] = (float)points[i][1] * step;
    s->z[part->first + i] = (float)points[i][2] * step;
  }
  return result;
}

static scree_result copy_pack(scree_scatter* s, scree_error* error) {
  scree_result result = measure_pack(s, error);
  if (result != SCREE_OK) return result;
  if (!allocate(s)) return SCREE_ERROR_OUT_OF_MEMORY;
  scree_pack_info info;
  scree_pack_get_info(s->pack, &info);
  uint32_t parts = 0, points = 0;
  for (uint32_t v = 0; v < s->variant_count && result == SCREE_OK; ++v) {
    uint32_t first, count;
    result = scree_pack_cell_assets(s->pack, v, &first, &count);
    if (result == SCREE_OK && (first != s->variants[v] || count < 1)) result = SCREE_ERROR_CORRUPT;
    if (result == SCREE_OK) s->variants[v + 1] = first + count;
  }
  if (result == SCREE_OK && s->variants[s->variant_count] != s->model_count) result = SCREE_ERROR_CORRUPT;
  for (uint32_t i = 0; i < s->model_count && result == SCREE_OK; ++i) {
    scree_model model;
    scree_asset asset;
    result = scree_pack_get_model(s->pack, i, &model);
    if (result == SCREE_OK) result = scree_pack_get_asset(s->pack, i, &asset);
    /* A model that does not reach down to the ground has no footprint: it is fitted by its middle alone. */
    if (result == SCREE_OK && !(model.footprint >= 0 && model.footprint <= 1e9f && is_length(asset.outer_radius)))
      result = SCREE_ERROR_CORRUPT;
    if (result != SCREE_OK) break;
    s->models[i] = (scatter_model){.footprint = model.footprint, .first_part = parts, .part_count = model.part_count};
    double outer = 0;
    for (int a = 0; a < 3; ++a) outer += (double)asset.centroid[a] * (double)asset.centroid[a];
    outer = sqrt(outer) + (double)asset.outer_radius;
    for (uint32_t k = 0; k < model.part_count && result == SCREE_OK; ++k) {
      scatter_part* part = &s->parts[parts++];
      part->first = points;
      result = copy_pack_part(s, i, k, part, 1.0f / (float)info.lattice_per_cell);
      points += part->count;
      if (result == SCREE_OK) outer = fmax(outer, measure_part(s, part));
    }
    count_in(s, (double)model.footprint, outer);
  }
  return result == SCREE_OK ? result : scree_rt_scatter_wrong(result, "pack: a model cannot be read", error);
}

scree_result scree_rt_scatter_copy_models(scree_scatter* s, const scree_scatter_desc* desc, scree_error* error) {
  s->pack = desc->pack;
  if (desc->pack != NULL && (desc->models != NULL || desc->model_count > 0 || desc->age_count > 0))
    return scree_rt_scatter_wrong(SCREE_ERROR_INVALID_ARGUMENT, "models are given beside a pack", error);
  const scree_result result = desc->pack != NULL ? copy_pack(s, error) : copy_own(s, desc, error);
  return result == SCREE_OK ? copy_weights(s, desc->weights, error) : result;
}
