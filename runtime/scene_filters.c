/* Filters: how dense a layer is from place to place. Everything is a function of the home cell's integers and the difference of
 * two world points, in double: no question, no block, no distance from the origin changes it. */
#include <math.h>

#include "scene_layers.h"
#include "support_text.h"

#define LONE_MASK UINT32_MAX /* in place of a layer */

static scree_result wrong(scree_result code, uint32_t layer, uint32_t filter, const char* what, scree_error* error) {
  if (layer == LONE_MASK) {
    scree_rt_text_add(error, "age_mask: ");
  } else {
    scree_rt_text_add(error, "layer ");
    scree_rt_text_add_count(error, layer);
    scree_rt_text_add(error, ", filter ");
    scree_rt_text_add_count(error, filter);
    scree_rt_text_add(error, ": ");
  }
  scree_rt_text_add(error, what);
  return code;
}

static scree_result wrong_number(uint32_t layer, uint32_t filter, const char* name, double value, const char* range,
                                 scree_error* error) {
  wrong(SCREE_ERROR_RANGE, layer, filter, name, error);
  scree_rt_text_add(error, " is ");
  scree_rt_text_add_number(error, value);
  scree_rt_text_add(error, ", it has to be ");
  scree_rt_text_add(error, range);
  return SCREE_ERROR_RANGE;
}

static scree_result check_image(const scree_filter* f, uint32_t layer, uint32_t index, scree_error* error) {
  if (f->values == NULL) return wrong(SCREE_ERROR_INVALID_ARGUMENT, layer, index, "values is NULL", error);
  if (f->width < 2 || f->width > 65536) return wrong_number(layer, index, "width", f->width, "2..65536", error);
  if (f->depth < 2 || f->depth > 65536) return wrong_number(layer, index, "depth", f->depth, "2..65536", error);
  if (!(f->spacing > 0 && isfinite(f->spacing))) return wrong_number(layer, index, "spacing", (double)f->spacing, "above 0", error);
  for (int a = 0; a < 3; ++a)
    if (!isfinite(f->centre[a])) return wrong_number(layer, index, "centre", f->centre[a], "finite", error);
  for (size_t i = 0; i < (size_t)f->width * f->depth; ++i) {
    double v = (double)f->values[i];
    if (f->kind == SCREE_FILTER_MASK && !(v >= 0 && v <= 1)) return wrong_number(layer, index, "a value", v, "0..1", error);
    if (!(fabs(v) <= 1e9)) return wrong_number(layer, index, "a height", v, "at most 1e9", error);
  }
  return SCREE_OK;
}

scree_result scree_rt_scene_check_filters(const scree_layer* layer, uint32_t index, size_t* values, scree_error* error) {
  *values = 0;
  if (layer->filter_count > SCENE_MAX_FILTERS) {
    wrong(SCREE_ERROR_RANGE, index, SCENE_MAX_FILTERS, "there may be 16 at most", error);
    return SCREE_ERROR_RANGE;
  }
  if (layer->filter_count > 0 && layer->filters == NULL)
    return wrong(SCREE_ERROR_INVALID_ARGUMENT, index, 0, "filters is NULL", error);
  for (uint32_t i = 0; i < layer->filter_count; ++i) {
    const scree_filter* f = &layer->filters[i];
    if (f->kind != SCREE_FILTER_MASK && f->kind != SCREE_FILTER_SLOPE && f->kind != SCREE_FILTER_ALTITUDE)
      return wrong(SCREE_ERROR_INVALID_ARGUMENT, index, i, "no such kind", error);
    if (f->kind != SCREE_FILTER_ALTITUDE) {
      scree_result result = check_image(f, index, i, error);
      if (result != SCREE_OK) return result;
      *values += (size_t)f->width * f->depth;
    }
    if (f->kind == SCREE_FILTER_MASK) continue;
    if (!isfinite(f->from)) return wrong_number(index, i, "from", (double)f->from, "finite", error);
    if (!(f->to >= f->from && isfinite(f->to))) return wrong_number(index, i, "to", (double)f->to, "at least `from`", error);
    if (!(f->fade >= 0 && isfinite(f->fade))) return wrong_number(index, i, "fade", (double)f->fade, "0 or more", error);
  }
  return SCREE_OK;
}

scree_result scree_rt_scene_check_mask(const scree_filter* mask, scree_error* error) {
  if (mask->kind != SCREE_FILTER_MASK) return wrong(SCREE_ERROR_INVALID_ARGUMENT, LONE_MASK, 0, "it has to be of kind MASK", error);
  return check_image(mask, LONE_MASK, 0, error);
}

/* The patch of an image that a place lies in, and where in it. */
typedef struct image_place {
  double corner[4]; /* at (0, 0), (1, 0), (0, 1), (1, 1) */
  double u, v;      /* 0..1 */
} image_place;

static double place_along(double distance, double spacing, uint32_t samples, uint32_t* at) {
  double last = (double)(samples - 1), u = distance / spacing + last * 0.5;
  if (!(u > 0)) u = 0;
  if (u > last) u = last;
  uint32_t cell = (uint32_t)u;
  *at = cell > samples - 2 ? samples - 2 : cell;
  return u - (double)*at;
}

static image_place find_place(const scree_filter* f, double x, double z) {
  uint32_t i, k;
  image_place p;
  p.u = place_along(x, (double)f->spacing, f->width, &i);
  p.v = place_along(z, (double)f->spacing, f->depth, &k);
  const float* row = f->values + (size_t)k * f->width + i;
  p.corner[0] = (double)row[0];
  p.corner[1] = (double)row[1];
  p.corner[2] = (double)row[f->width];
  p.corner[3] = (double)row[f->width + 1];
  return p;
}

static double mix(double a, double b, double t) {
  return a + t * (b - a);
}

/* Arc tangent of t >= 0 in degrees. The angle is halved twice, then the series ends: no libm, whose last bits differ from one to
 * the next. */
double scree_rt_arc_degrees(double t) {
  bool steep = t > 1;
  if (steep) t = 1 / t;
  for (int i = 0; i < 2; ++i) t = t / (1 + sqrt(1 + t * t));
  double square = t * t, sum = 0;
  static const double odd[] = {1.0 / 21, 1.0 / 19, 1.0 / 17, 1.0 / 15, 1.0 / 13, 1.0 / 11, 1.0 / 9, 1.0 / 7, 1.0 / 5, 1.0 / 3, 1};
  for (size_t k = 0; k < sizeof odd / sizeof *odd; ++k) sum = odd[k] - square * sum;
  double degrees = 4 * t * sum * 57.295779513082320877;
  return steep ? 90 - degrees : degrees;
}

static double slope_at(const scree_filter* f, double x, double z) {
  image_place p = find_place(f, x, z);
  double along_x = mix(p.corner[1] - p.corner[0], p.corner[3] - p.corner[2], p.v) / (double)f->spacing;
  double along_z = mix(p.corner[2] - p.corner[0], p.corner[3] - p.corner[1], p.u) / (double)f->spacing;
  return scree_rt_arc_degrees(sqrt(along_x * along_x + along_z * along_z));
}

static double band(const scree_filter* f, double value) {
  double from = (double)f->from, to = (double)f->to, fade = (double)f->fade;
  double outside = value < from ? from - value : value > to ? value - to : 0;
  if (outside <= 0) return 1;
  return outside < fade ? 1 - outside / fade : 0;
}

double scree_rt_filter_mask(const scree_filter* f, double x, double z) {
  const image_place p = find_place(f, x, z);
  const double part = mix(mix(p.corner[0], p.corner[1], p.u), mix(p.corner[2], p.corner[3], p.u), p.v);
  return f->inverted ? 1 - part : part;
}

/* The number from 0 up to 1 that a rock draws: it exists where its share is more. Another seed than scree_world_hash has: what is
 * thinned out says nothing about colours. */
static double draw(const scree_field* field, const int32_t cube[3], uint32_t local) {
  uint64_t hash = hash_corner(field->seed ^ UINT64_C(0xd1b54a32d192ed03), cube[0], cube[1], cube[2]);
  return (double)(hash_combine(hash, local) >> 11) * 0x1p-53;
}

bool scree_rt_scene_passes_at(const scene_layer* layer, const double at[3], const int32_t cube[3], uint32_t local, bool planar) {
  const scree_field* field = layer->given.field;
  double share = layer->density;
  /* Filters only take away, but for rounding. */
  if (share < 1 && draw(field, cube, local) >= share * (1 + 1e-9)) return false;
  for (uint32_t i = 0; i < layer->given.filter_count && share > 0; ++i) {
    const scree_filter* f = &layer->given.filters[i];
    double part;
    if (f->kind == SCREE_FILTER_ALTITUDE) {
      if (planar) continue;
      part = band(f, field->origin[1] + at[1]);
    } else {
      double x = (field->origin[0] - f->centre[0]) + at[0], z = (field->origin[2] - f->centre[2]) + at[2];
      if (f->kind == SCREE_FILTER_MASK) {
        share *= scree_rt_filter_mask(f, x, z);
        continue;
      }
      part = band(f, slope_at(f, x, z));
    }
    share *= f->inverted ? 1 - part : part;
  }
  if (!(share > 0 && share < 1)) return share >= 1; /* as every number from 0 up to 1 would say */
  return draw(field, cube, local) < share;
}

bool scree_rt_scene_passes(const scene_layer* layer, const scree_id* id) {
  int64_t cell[3];
  rock_cell(layer->given.field, id, cell);
  double at[3];
  for (int a = 0; a < 3; ++a) at[a] = layer->given.field->cell_size * (double)cell[a];
  return scree_rt_scene_passes_at(layer, at, id->cube, id->local, false);
}
