/* Rays against a scene, layer by layer.
 * Based on: Hart, Sphere Tracing, 1996: where the support's distance is so large, or under a shell so small, that no rock can be
 * near, the ray jumps as far as the Lipschitz bound allows. Elsewhere it goes piece by piece, and the rocks round a piece are asked
 * of the scene, so that filters, overlaps and edits hold.
 *
 *      start                          | piece | piece |
 *   ----*------------->  . . . . . . .|-------|--o----|- - -
 *         jump: nothing exists here      rocks   first hull
 *                                        round it
 *
 * A rock belongs to the piece in which the ray enters the ball that holds it; a hull cannot be hit before that. So a hit within the
 * piece is the nearest of all. */
#include <math.h>
#include <string.h>

#include "scene_spatial.h"

typedef struct ray_walk {
  spatial_question q; /* origin: the ray's start */
  double along[3];    /* unit */
  double limit;       /* reach, then the nearest hit */
  bool found;
  scree_rock rock;
  double normal[3];
} ray_walk;

/* Where the ray is in a box relative to its start. Returns false where it is nowhere. */
static bool clip(const ray_walk* r, const double low[3], const double high[3], double* from, double* to) {
  for (int a = 0; a < 3; ++a) {
    if (r->along[a] == 0) {
      if (low[a] > 0 || high[a] < 0) return false;
      continue;
    }
    double in = low[a] / r->along[a], out = high[a] / r->along[a];
    if (in > out) {
      double swap = in;
      in = out;
      out = swap;
    }
    if (in > *from) *from = in;
    if (out < *to) *to = out;
  }
  return *from <= *to;
}

/* How far the ray can go from t on without coming near any rock of the layer; <= 0 when that is not known. */
static double free_way(const ray_walk* r, const scene_layer* layer, double t) {
  const scree_support* support = layer->given.support;
  if (!(layer->lipschitz > 0)) return 0;
  float p[3], distance;
  double largest = support->magnitude;
  for (int a = 0; a < 3; ++a) {
    const double at = (r->q.origin[a] - support->origin[a]) + t * r->along[a];
    if (fabs(at) > largest) largest = fabs(at);
    p[a] = (float)at;
  }
  scree_support_distance(support, &p[0], &p[1], &p[2], &distance, 1);
  /* A rock that reaches here has its centroid within its radius, where the distance differs by so much. */
  const double differ = layer->lipschitz * layer->rock_radius * 1.00001 + largest * 8e-6;
  double way = ((double)distance - layer->level_high - differ) / layer->lipschitz;
  if (layer->given.shell_depth > 0) {
    const double deep = (-(double)layer->given.shell_depth - (double)distance - differ) / layer->lipschitz;
    if (deep > way) way = deep;
  }
  return way;
}

static void test_part(ray_walk* r, const scene_layer* layer, const scree_rock* rock, uint32_t part, double first, double last) {
  const spatial_place place = scree_rt_spatial_part(layer, rock, part, r->q.origin);
  const double* c = place.centroid;
  const double middle = c[0] * r->along[0] + c[1] * r->along[1] + c[2] * r->along[2];
  double away2 = 0;
  for (int a = 0; a < 3; ++a) {
    const double away = c[a] - middle * r->along[a];
    away2 += away * away;
  }
  const double half2 = place.radius * place.radius - away2;
  if (!(half2 >= 0)) return;
  const double half = sqrt(half2), enter = middle - half;
  if (enter > last || enter > r->limit || middle + half < 0 || (enter < first && first > 0)) return;
  spatial_hull hull;
  double t, normal[3];
  if (!scree_rt_spatial_part_hull(layer, rock, part, place.home, &hull)) return;
  if (!scree_rt_convex_ray(&hull.hull, (const double[3]){0, 0, 0}, r->along, r->limit, &t, normal)) return;
  if (r->found && t == r->limit && scree_rt_edits_compare(&rock->id, &r->rock.id) > 0) return;
  r->found = true;
  r->limit = t;
  r->rock = *rock;
  scree_rt_spatial_unpack(layer, &r->rock);
  memcpy(r->normal, normal, sizeof normal);
}

/* Tests the rocks whose balls the ray enters between t and end. */
static scree_result test_piece(ray_walk* r, uint32_t layer, double first, double t, double end, uint64_t* count) {
  double low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    const double p = r->q.origin[a] + t * r->along[a], q = r->q.origin[a] + end * r->along[a];
    low[a] = p < q ? p : q;
    high[a] = p < q ? q : p;
  }
  const scree_rock* rocks;
  const scree_result result = scree_rt_spatial_rocks(&r->q, layer, low, high, &rocks, count);
  if (result != SCREE_OK) return result;
  const scene_layer* own = &r->q.scene->layers[layer];
  for (uint64_t i = 0; i < *count; ++i)
    for (uint32_t part = 0; part < scree_rt_spatial_parts(own, &rocks[i]); ++part) test_part(r, own, &rocks[i], part, first, end);
  return SCREE_OK;
}

static scree_result walk_layer(ray_walk* r, uint32_t index) {
  const scene_layer* layer = &r->q.scene->layers[index];
  const scree_support* support = layer->given.support;
  const double h = layer->given.field->cell_size * (layer->given.scatter != NULL ? 0.125 : 1), shortest = 2 * h, longest = 8 * h;
  double low[3], high[3], t = 0, end = r->limit;
  if (!scree_rt_support_level_bounds(support, layer->level_high > 0 ? layer->level_high : 0, low, high)) return SCREE_OK;
  for (int a = 0; a < 3; ++a) {
    const double base = support->origin[a] - r->q.origin[a], grown = layer->rock_radius * 1.001 + fabs(base) * 1e-12;
    low[a] += base - grown;
    high[a] += base + grown;
  }
  if (!clip(r, low, high, &t, &end)) return SCREE_OK;
  double first = t > 0 ? t - h : 0; /* the ray does not enter a ball before this that it has not been tested with */
  double length = shortest;
  while (t <= end && t <= r->limit) {
    const double way = free_way(r, layer, t);
    if (way > 0.25 * h) {
      t += way;
      first = t - h; /* none was left behind; rounding may put an entry before t */
      length = shortest;
      continue;
    }
    double to = t + length;
    if (to > r->limit) to = r->limit;
    if (to > end) to = end;
    if (!(to > t) && t > 0) break; /* so far away that doubles do not count pieces any longer */
    uint64_t count = 0;
    const scree_result result = test_piece(r, index, first, t, to, &count);
    if (result != SCREE_OK) return result;
    if (to >= end || to >= r->limit) break;
    first = to - h * 1e-7;
    t = to;
    length = count == 0 && 2 * length <= longest ? 2 * length : count == 0 ? length : shortest;
  }
  return SCREE_OK;
}

scree_result scree_scene_ray_cast(const scree_scene* scene, const scree_edits* edits, scree_scratch* scratch, const double start[3],
                                  const double direction[3], double reach, bool* found, scree_hit* hit) {
  if (found != NULL) *found = false;
  if (scene == NULL || scratch == NULL || start == NULL || direction == NULL || found == NULL || hit == NULL)
    return SCREE_ERROR_INVALID_ARGUMENT;
  if (!(reach > 0 && isfinite(reach))) return SCREE_ERROR_INVALID_ARGUMENT;
  ray_walk r = {.q = {.scene = scene, .edits = edits, .scratch = scratch}, .limit = reach};
  double largest = 0, length2 = 0;
  for (int a = 0; a < 3; ++a) {
    if (!isfinite(start[a]) || !isfinite(direction[a])) return SCREE_ERROR_INVALID_ARGUMENT;
    r.q.origin[a] = start[a];
    if (fabs(direction[a]) > largest) largest = fabs(direction[a]);
  }
  if (!(largest > 0)) return SCREE_ERROR_INVALID_ARGUMENT;
  for (int a = 0; a < 3; ++a) { /* twice, so that no length is too large or too small to be squared */
    r.along[a] = direction[a] / largest;
    length2 += r.along[a] * r.along[a];
  }
  for (int a = 0; a < 3; ++a) r.along[a] /= sqrt(length2);

  for (uint32_t layer = 0; layer < scene->layer_count; ++layer) {
    const scree_result result = walk_layer(&r, layer);
    if (result != SCREE_OK) return result;
  }
  *found = r.found;
  if (!r.found) return SCREE_OK;
  *hit = (scree_hit){.rock = r.rock, .distance = r.limit};
  for (int a = 0; a < 3; ++a) {
    hit->point[a] = (float)(r.along[a] * r.limit);
    hit->normal[a] = (float)r.normal[a];
  }
  return SCREE_OK;
}
