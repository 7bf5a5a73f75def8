/* Scatters: their descriptors, checked and copied, and what follows from an instance's 32 random bits. */
#include <math.h>
#include <string.h>

#include "allocator.h"
#include "scatter_internal.h"
#include "scene_layers.h"
#include "support_text.h"

/* --- checks ----------------------------------------------------------------------------------------------------------------- */

static scree_result check(const scree_scatter_desc* d, scree_error* error) {
  if (!(d->spacing >= 1e-6 && d->spacing <= 1e6)) return scree_rt_scatter_wrong_number("spacing", d->spacing, "1e-6..1e6", error);
  for (int a = 0; a < 3; ++a)
    if (!isfinite(d->origin[a])) return scree_rt_scatter_wrong_number("origin", d->origin[a], "finite", error);
  if (d->scale_min != 0 || d->scale_max != 0) {
    if (!(d->scale_min > 0 && d->scale_min <= 1e9f))
      return scree_rt_scatter_wrong_number("scale_min", (double)d->scale_min, "above 0", error);
    if (!(d->scale_max >= d->scale_min && d->scale_max <= 1e9f))
      return scree_rt_scatter_wrong_number("scale_max", (double)d->scale_max, "at least scale_min", error);
  }
  if (!(d->max_slope >= 0 && d->max_slope <= 80))
    return scree_rt_scatter_wrong_number("max_slope", (double)d->max_slope, "0..80", error);
  return d->age_mask != NULL ? scree_rt_scene_check_mask(d->age_mask, error) : SCREE_OK;
}

/* --- create, destroy -------------------------------------------------------------------------------------------------------- */

static bool copy_mask(scree_scatter* s, const scree_filter* mask) {
  if (mask == NULL) return true;
  s->masked = true;
  s->age_mask = *mask;
  s->sample_count = (size_t)mask->width * mask->depth;
  s->samples = scree_rt_allocate(&s->allocator, s->sample_count, sizeof *s->samples);
  if (s->samples == NULL) return false;
  memcpy(s->samples, mask->values, s->sample_count * sizeof *s->samples);
  s->age_mask.values = s->samples;
  return true;
}

/* The tangent of an angle, from the arc tangent that all machines agree on. */
static double tangent(double degrees) {
  double low = 0, high = 8;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) * 0.5;
    *(scree_rt_arc_degrees(middle) < degrees ? &low : &high) = middle;
  }
  return high;
}

/* The field that scenes and streams see: a cell of its lattice is a cube of tiles, and holds what stands in it. */
static void make_lattice(scree_scatter* s) {
  scree_field* f = &s->lattice;
  const double side = s->unit * SCATTER_SIDE;
  f->cell_size = side;
  f->cells_per_cube = 1;
  f->max_rocks_per_cell = SCATTER_MOST_LOCALS;
  f->per_cell_inverse = field_cell_inverse(SCATTER_MOST_LOCALS);
  f->cell_places = s->place;
  f->lattice_per_cell = 1;
  f->asset_count = s->model_count;
  for (int a = 0; a < 3; ++a) {
    f->origin[a] = s->origin[a] + side * 0.5; /* cells are centred on their places */
    f->centroid_min[a] = (float)(side * -0.5000001);
    f->centroid_max[a] = (float)(side * 0.5000001);
  }
  f->centroid_max[1] += (float)s->sink * 1.000001f; /* the ground that an instance stands on is up to that much higher */
  f->centroid_reach = (float)(side * 0.86602546 + s->sink);
}

void scree_rt_scatter_finish(scree_scatter* s) {
  s->outer_radius *= (double)s->scale_max * 1.000001;
  s->sink *= (double)s->scale_max * 1.000001 * s->slope;
  make_lattice(s);
}

scree_result scree_scatter_create(const scree_scatter_desc* desc, const scree_allocator* given, scree_scatter** out,
                                  scree_error* error) {
  scree_rt_text_clear(error);
  if (out != NULL) *out = NULL;
  if (desc == NULL || out == NULL)
    return scree_rt_scatter_wrong(SCREE_ERROR_INVALID_ARGUMENT, desc == NULL ? "desc is NULL" : "out is NULL", error);
  scree_result result = check(desc, error);
  if (result != SCREE_OK) return result;
  const scree_allocator allocator = scree_rt_allocator_or_default(given);
  scree_scatter* s = scree_rt_allocate_zeroed(&allocator, 1, sizeof *s);
  if (s == NULL) return scree_rt_scatter_wrong(SCREE_ERROR_OUT_OF_MEMORY, "out of memory", error);
  s->allocator = allocator;
  result = scree_rt_scatter_copy_models(s, desc, error);
  if (result == SCREE_OK && !copy_mask(s, desc->age_mask)) result = SCREE_ERROR_OUT_OF_MEMORY;
  if (result != SCREE_OK) {
    scree_scatter_destroy(s);
    if (result == SCREE_ERROR_OUT_OF_MEMORY) scree_rt_text_add(error, "out of memory");
    return result;
  }
  memcpy(s->origin, desc->origin, sizeof s->origin);
  s->lattice.seed = desc->seed;
  s->unit = desc->spacing / SCATTER_RADIUS;
  s->scale_min = desc->scale_max > 0 ? desc->scale_min : 1;
  s->scale_max = desc->scale_max > 0 ? desc->scale_max : 1;
  s->slope = tangent(desc->max_slope > 0 ? (double)desc->max_slope : 45);
  scree_rt_scatter_finish(s);
  scree_rt_scatter_make_tiles(desc->seed, s->tiles);
  *out = s;
  return SCREE_OK;
}

void scree_scatter_destroy(scree_scatter* s) {
  if (s == NULL) return;
  const scree_allocator allocator = s->allocator;
  scree_rt_scatter_drop_models(s);
  scree_rt_release(&allocator, s->samples, s->sample_count, sizeof *s->samples);
  scree_rt_release(&allocator, s->points, s->cliff_count, sizeof *s->points);
  scree_support_destroy(s->ground);
  scree_rt_release(&allocator, s, 1, sizeof *s);
}

/* --- what can be told at once ----------------------------------------------------------------------------------------------- */

uint32_t scree_scatter_model_count(const scree_scatter* scatter) {
  return scatter->model_count;
}

double scree_scatter_tile_width(const scree_scatter* scatter) {
  return scatter->lattice.cell_size;
}

uint64_t scree_rt_scatter_hash(const scree_scatter* s, int32_t x, int32_t z, uint32_t local) {
  return hash_combine(hash_corner(s->lattice.seed ^ UINT64_C(0x5c3ee0f1e1d5a1d7), x, 0, z), local);
}

uint32_t scree_scatter_random(const scree_scatter* scatter, const scree_id* id) {
  const uint64_t hash = scree_rt_scatter_hash(scatter, id->cube[0], id->cube[2], id->local);
  return scatter->is_cliff ? scatter->turn_bits | (uint32_t)(hash >> 48) : (uint32_t)(hash >> 32);
}

void scree_scatter_turn(const scree_scatter* scatter, uint32_t random, float turn[2], float* scale) {
  const float u = (float)(random >> 16 & 0x3fff) / 16384, t = u * (0.7854f + u * u * (0.1615f + u * u * 0.0531f));
  float c = (1 - t * t) / (1 + t * t), s = 2 * t / (1 + t * t);
  if (random >> 30 & 1) {
    const float swapped = c;
    c = -s;
    s = swapped;
  }
  const float sign = random >> 31 ? -1.0f : 1.0f;
  turn[0] = s * sign;
  turn[1] = c * sign;
  *scale = scatter->scale_min + (scatter->scale_max - scatter->scale_min) * (float)(random & 0xffff) / 65535;
}

scree_result scree_scatter_part(const scree_scatter* s, uint32_t model, uint32_t part, float* xyz, uint32_t capacity,
                                uint32_t* count) {
  if (count != NULL) *count = 0;
  if (s == NULL || count == NULL || (xyz == NULL && capacity > 0) || model >= s->model_count || part >= s->models[model].part_count)
    return SCREE_ERROR_INVALID_ARGUMENT;
  const scatter_part* p = &s->parts[s->models[model].first_part + part];
  *count = p->count;
  for (uint32_t i = 0; i < p->count && i < capacity; ++i) {
    xyz[3 * i] = s->x[p->first + i];
    xyz[3 * i + 1] = s->y[p->first + i];
    xyz[3 * i + 2] = s->z[p->first + i];
  }
  return p->count > capacity ? SCREE_ERROR_CAPACITY : SCREE_OK;
}

uint32_t scree_rt_scatter_hull(const scree_scatter* s, uint32_t part, uint32_t random, float* x, float* y, float* z, float* scale) {
  const scatter_part* p = &s->parts[part];
  float turn[2];
  scree_scatter_turn(s, random, turn, scale);
  for (uint32_t i = 0; i < p->count; ++i) {
    const float px = s->x[p->first + i], pz = s->z[p->first + i];
    x[i] = turn[1] * px + turn[0] * pz;
    y[i] = s->y[p->first + i];
    z[i] = turn[1] * pz - turn[0] * px;
  }
  return p->count;
}

double scree_rt_scatter_ball(const scree_scatter* s, uint32_t part, uint32_t random, double centre[3]) {
  const scatter_part* p = &s->parts[part];
  float turn[2], scale;
  scree_scatter_turn(s, random, turn, &scale);
  const double c = (double)turn[1], n = (double)turn[0], size = (double)scale;
  centre[0] = size * (c * (double)p->centre[0] + n * (double)p->centre[2]);
  centre[1] = size * (double)p->centre[1];
  centre[2] = size * (c * (double)p->centre[2] - n * (double)p->centre[0]);
  return size * (double)p->radius * 1.000001; /* sine and cosine are rounded */
}
