/* Which rocks meet a convex shape, and which come near some points. */
#include <math.h>

#include "scene_spatial.h"

static double distance2(const double a[3], const double b[3]) {
  double d2 = 0;
  for (int i = 0; i < 3; ++i) d2 += (a[i] - b[i]) * (a[i] - b[i]);
  return d2;
}

/* --- overlap ---------------------------------------------------------------------------------------------------------------- */

static bool shape_is_sound(const scree_convex* shape) {
  if (shape == NULL || shape->points == NULL || shape->point_count < 1 || shape->point_count > CONVEX_MAX_POINTS) return false;
  if (!(shape->radius >= 0 && isfinite(shape->radius))) return false;
  for (int a = 0; a < 3; ++a)
    if (!isfinite(shape->origin[a])) return false;
  for (uint32_t i = 0; i < 3 * shape->point_count; ++i)
    if (!isfinite(shape->points[i])) return false;
  return true;
}

static bool ball_meets_box(const double centre[3], double radius, const double low[3], const double high[3]) {
  double nearest[3];
  for (int a = 0; a < 3; ++a) nearest[a] = centre[a] < low[a] ? low[a] : centre[a] > high[a] ? high[a] : centre[a];
  return distance2(centre, nearest) <= radius * radius;
}

scree_result scree_scene_overlap(const scree_scene* scene, const scree_edits* edits, scree_scratch* scratch,
                                 const scree_convex* shape, scree_rock* rocks, uint64_t capacity, uint64_t* count) {
  if (count != NULL) *count = 0;
  if (scene == NULL || scratch == NULL || count == NULL || (rocks == NULL && capacity > 0) || !shape_is_sound(shape))
    return SCREE_ERROR_INVALID_ARGUMENT;
  spatial_question q = {.scene = scene, .edits = edits, .scratch = scratch};
  spatial_hull own;
  double low[3], high[3], world_low[3], world_high[3]; /* relative to the shape's origin, and not */
  for (uint32_t i = 0; i < shape->point_count; ++i) {
    own.x[i] = shape->points[3 * i];
    own.y[i] = shape->points[3 * i + 1];
    own.z[i] = shape->points[3 * i + 2];
  }
  own.hull = (convex_hull){own.x, own.y, own.z, shape->point_count, 1, {0, 0, 0}, (double)shape->radius};
  double size = 0;
  for (int a = 0; a < 3; ++a) {
    const float* axis = a == 0 ? own.x : a == 1 ? own.y : own.z;
    low[a] = high[a] = (double)axis[0];
    for (uint32_t i = 1; i < shape->point_count; ++i) {
      if ((double)axis[i] < low[a]) low[a] = (double)axis[i];
      if ((double)axis[i] > high[a]) high[a] = (double)axis[i];
    }
    size += fabs(low[a]) + fabs(high[a]);
  }
  for (int a = 0; a < 3; ++a) { /* a little more than the shape, for what counts as touching */
    const double grown = own.hull.radius * (1 + 1e-6) + size * 1e-6;
    q.origin[a] = shape->origin[a];
    low[a] -= grown;
    high[a] += grown;
    world_low[a] = q.origin[a] + low[a];
    world_high[a] = q.origin[a] + high[a];
  }

  spatial_list list = {NULL, 0};
  for (uint32_t k = 0; k < scene->layer_count; ++k) {
    const scene_layer* layer = &scene->layers[k];
    const scree_rock* found;
    uint64_t found_count;
    const scree_result result = scree_rt_spatial_rocks(&q, k, world_low, world_high, &found, &found_count);
    if (result != SCREE_OK) return result;
    for (uint64_t i = 0; i < found_count; ++i) {
      bool met = false;
      for (uint32_t part = 0; part < scree_rt_spatial_parts(layer, &found[i]) && !met; ++part) {
        const spatial_place place = scree_rt_spatial_part(layer, &found[i], part, q.origin);
        spatial_hull hull;
        met = ball_meets_box(place.centroid, place.radius, low, high) &&
              scree_rt_spatial_part_hull(layer, &found[i], part, place.home, &hull) && scree_rt_convex_meet(&hull.hull, &own.hull);
      }
      if (met && !scree_rt_spatial_add(&q, k, &list, &found[i])) return SCREE_ERROR_OUT_OF_MEMORY;
    }
  }
  return scree_rt_spatial_deliver(&list, rocks, capacity, count);
}

/* --- near ------------------------------------------------------------------------------------------------------------------- */

/* Some of the points, in the order in which they were given, and the box that holds them. */
typedef struct cluster {
  const double* points;
  uint32_t count;
  double low[3], high[3];
} cluster;

static double grown_volume(const double low[3], const double high[3], double by) {
  return (high[0] - low[0] + 2 * by) * (high[1] - low[1] + 2 * by) * (high[2] - low[2] + 2 * by);
}

/* Takes points from the front as long as asking for their common box costs no more than asking for each one's. */
static cluster take_cluster(const double* points, uint32_t count, double by) {
  cluster c = {.points = points, .count = 1};
  for (int a = 0; a < 3; ++a) c.low[a] = c.high[a] = points[a];
  const double one = grown_volume(c.low, c.high, by);
  for (; c.count < count; ++c.count) {
    const double* p = points + 3 * (size_t)c.count;
    double low[3], high[3];
    for (int a = 0; a < 3; ++a) {
      low[a] = p[a] < c.low[a] ? p[a] : c.low[a];
      high[a] = p[a] > c.high[a] ? p[a] : c.high[a];
    }
    if (!(grown_volume(low, high, by) <= one * ((double)c.count + 1))) break;
    for (int a = 0; a < 3; ++a) {
      c.low[a] = low[a];
      c.high[a] = high[a];
    }
  }
  return c;
}

/* Whether the hull of a rock's part comes within the radius of a point. */
static bool is_near(const scene_layer* layer, const scree_rock* rock, uint32_t part, spatial_hull* hull, bool* made,
                    const double point[3], double radius) {
  static const float zero[1] = {0};
  const spatial_place place = scree_rt_spatial_part(layer, rock, part, point);
  const double reach = place.radius + radius * (1 + 1e-6), d2 = distance2(place.centroid, (const double[3]){0, 0, 0});
  if (d2 > reach * reach) return false;
  if (!*made && !scree_rt_spatial_part_hull(layer, rock, part, place.home, hull)) return false;
  *made = true;
  for (int a = 0; a < 3; ++a) hull->hull.at[a] = place.home[a];
  const convex_hull ball = {zero, zero, zero, 1, 1, {0, 0, 0}, radius};
  return scree_rt_convex_meet(&hull->hull, &ball);
}

static scree_result add_near(const spatial_question* q, const cluster* c, double radius, spatial_list* list) {
  double low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    const double grown = radius * (1 + 1e-6);
    low[a] = c->low[a] - grown;
    high[a] = c->high[a] + grown;
  }
  for (uint32_t k = 0; k < q->scene->layer_count; ++k) {
    const scene_layer* layer = &q->scene->layers[k];
    const scree_rock* found;
    uint64_t count;
    const scree_result result = scree_rt_spatial_rocks(q, k, low, high, &found, &count);
    if (result != SCREE_OK) return result;
    for (uint64_t i = 0; i < count; ++i) {
      bool near = false;
      for (uint32_t part = 0; part < scree_rt_spatial_parts(layer, &found[i]) && !near; ++part) {
        spatial_hull hull;
        bool made = false;
        for (uint32_t p = 0; p < c->count && !near; ++p)
          near = is_near(layer, &found[i], part, &hull, &made, c->points + 3 * p, radius);
      }
      if (near && !scree_rt_spatial_add(q, k, list, &found[i])) return SCREE_ERROR_OUT_OF_MEMORY;
    }
  }
  return SCREE_OK;
}

scree_result scree_scene_near(const scree_scene* scene, const scree_edits* edits, scree_scratch* scratch, const double* points,
                              uint32_t point_count, double radius, const double origin[3], scree_rock* rocks, uint64_t capacity,
                              uint64_t* count) {
  if (count != NULL) *count = 0;
  if (scene == NULL || scratch == NULL || origin == NULL || count == NULL || (points == NULL && point_count > 0) ||
      (rocks == NULL && capacity > 0) || !(radius >= 0 && isfinite(radius)))
    return SCREE_ERROR_INVALID_ARGUMENT;
  spatial_question q = {.scene = scene, .edits = edits, .scratch = scratch};
  double reach = 0;
  for (int a = 0; a < 3; ++a) {
    if (!isfinite(origin[a])) return SCREE_ERROR_INVALID_ARGUMENT;
    q.origin[a] = origin[a];
  }
  for (size_t i = 0; i < 3 * (size_t)point_count; ++i)
    if (!isfinite(points[i])) return SCREE_ERROR_INVALID_ARGUMENT;
  for (uint32_t k = 0; k < scene->layer_count; ++k)
    if (reach == 0 || scene->layers[k].reach < reach) reach = scene->layers[k].reach;

  spatial_list list = {NULL, 0};
  for (uint32_t i = 0; i < point_count;) {
    const cluster c = take_cluster(points + 3 * (size_t)i, point_count - i, radius + reach);
    const scree_result result = add_near(&q, &c, radius, &list);
    if (result != SCREE_OK) return result;
    i += c.count;
  }
  return scree_rt_spatial_deliver(&list, rocks, capacity, count);
}
