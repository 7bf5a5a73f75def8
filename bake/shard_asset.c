#include "shard_asset.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "allocator.h"
#include "convex_parts.h"
#include "shard_levels.h"
#include "shard_parts.h"
#include "shards_internal.h"
#include "triangle_tree.h"

enum {
  MAX_REACH = 16384,    /* lattice steps from the origin: moments of what fills such a box still fit 64 bits */
  COARSEST_MOST = 4096, /* triangles of the last level: a pack keeps it without a codec */
  COARSEST_LEAST = 24   /* no level is asked to have fewer */
};

/* As of other models: a level that holds less or more of the finest one's volume repeats the one before it. */
#define LEAST_VOLUME 0.8
#define MOST_VOLUME 1.2

void shard_asset_origin(const scree_shards* shards, double ground, double origin[3]) {
  const scree_shards_view* v = &shards->view;
  origin[0] = 0.5 * (v->min[0] + v->max[0]);
  origin[1] = ground > v->max[1] ? v->max[1] : ground > v->min[1] ? ground : v->min[1];
  origin[2] = 0.5 * (v->min[2] + v->max[2]);
}

double shard_asset_lattice(const scree_shards* shards, const double origin[3]) {
  const scree_shards_view* v = &shards->view;
  double reach = 0;
  for (uint32_t a = 0; a < 3; ++a) {
    const double low = origin[a] - v->min[a], high = v->max[a] - origin[a];
    if (low > reach) reach = low;
    if (high > reach) reach = high;
  }
  if (!(reach > 0)) return 0;
  double steps = 1;
  while (steps * 2 * reach <= MAX_REACH - 1 && steps < 65536) steps *= 2;
  while (steps * reach > MAX_REACH - 1 && steps > 1e-6) steps /= 2;
  return steps * reach <= MAX_REACH - 1 ? steps : 0;
}

void shard_asset_destroy(shard_asset* asset, const scree_allocator* allocator) {
  const scree_allocator from = scree_rt_allocator_or_default(allocator);
  for (uint32_t k = 0; k < ROCK_MAX_LODS; ++k) shard_level_release(&asset->lods[k].mesh, &from);
  memset(asset, 0, sizeof *asset);
}

/* --- On the lattice. --- */

/* v + 2 w (q x v) + 2 q x (q x v) of a unit quaternion. */
static void turn(const double q[4], const double v[3], double out[3]) {
  double t[3], u[3];
  for (uint32_t a = 0; a < 3; ++a) t[a] = 2 * (q[(a + 1) % 3] * v[(a + 2) % 3] - q[(a + 2) % 3] * v[(a + 1) % 3]);
  for (uint32_t a = 0; a < 3; ++a) u[a] = q[(a + 1) % 3] * t[(a + 2) % 3] - q[(a + 2) % 3] * t[(a + 1) % 3];
  for (uint32_t a = 0; a < 3; ++a) out[a] = v[a] + q[3] * t[a] + u[a];
}

/* Places of the vertices that the surface has, and of all corners of shards inside, to the nearest step; the others are 0. */
static bool set_places(const shard_asset_desc* desc, int16_t (*places)[3]) {
  const scree_shards_view* view = &desc->shards->view;
  const double* q = desc->rotation;
  const bool turned = q[0] != 0 || q[1] != 0 || q[2] != 0;
  memset(places, 0, view->vertex_count * sizeof *places);
  for (uint32_t l = 0; l < view->link_count; ++l) {
    const scree_link* link = &view->links[l];
    const bool in = desc->inside[link->shards[0]] || (link->shards[1] != SCREE_NO_SHARD && desc->inside[link->shards[1]]);
    for (uint32_t p = link->first_polygon; in && p < link->first_polygon + link->polygon_count; ++p)
      for (uint32_t c = 0; c < view->polygons[p].corner_count; ++c) {
        const uint32_t v = view->corners[view->polygons[p].first_corner + c];
        double at[3], there[3];
        for (uint32_t a = 0; a < 3; ++a) at[a] = view->vertices[(size_t)3 * v + a] - desc->origin[a];
        memcpy(there, at, sizeof there);
        if (turned) turn(q, at, there);
        for (uint32_t a = 0; a < 3; ++a) {
          const double step = floor(there[a] * desc->steps_per_metre + 0.5);
          if (!(step >= -MAX_REACH && step <= MAX_REACH)) return false;
          places[v][a] = (int16_t)step;
        }
      }
  }
  return true;
}

static mesh_buffer view_of(const lattice_mesh* mesh) {
  mesh_buffer out = {0};
  out.positions = mesh->positions;
  out.occlusion = mesh->occlusion;
  out.indices = mesh->indices;
  out.vertex_count = mesh->vertex_count;
  out.index_count = mesh->triangle_count * 3;
  return out;
}

/* --- Levels. --- */

static int compare_doubles(const void* a, const void* b) {
  const double x = *(const double*)a, y = *(const double*)b;
  return (x > y) - (x < y);
}

static double* doubles_of(const lattice_mesh* mesh, const scree_allocator* allocator) {
  double* out = scree_rt_allocate(allocator, (size_t)3 * mesh->vertex_count, sizeof *out);
  for (uint32_t i = 0; out != NULL && i < 3 * mesh->vertex_count; ++i) out[i] = mesh->positions[i / 3][i % 3];
  return out;
}

/* From the vertices of the finest level to the surface of another: the largest distance, and what 95 of 100 do not pass. */
static scree_result measure_error(const lattice_mesh* fine, const lattice_mesh* coarse, const scree_allocator* allocator,
                                  double metres, float* error, float* of_most) {
  double* places = doubles_of(coarse, allocator);
  double* distances = scree_rt_allocate(allocator, fine->vertex_count, sizeof *distances);
  triangle_tree tree = {0};
  scree_result result = places != NULL && distances != NULL
                            ? triangle_tree_create(places, coarse->indices, coarse->triangle_count, allocator, &tree)
                            : SCREE_ERROR_OUT_OF_MEMORY;
  if (result == SCREE_OK) {
    for (uint32_t v = 0; v < fine->vertex_count; ++v) {
      const double p[3] = {fine->positions[v][0], fine->positions[v][1], fine->positions[v][2]};
      distances[v] = triangle_tree_distance2(&tree, p);
    }
    qsort(distances, fine->vertex_count, sizeof *distances, compare_doubles);
    *error = (float)(sqrt(distances[fine->vertex_count - 1]) * metres);
    *of_most = (float)(sqrt(distances[(uint32_t)((95 * (uint64_t)fine->vertex_count + 99) / 100 - 1)]) * metres);
    triangle_tree_destroy(&tree);
  }
  scree_rt_release(allocator, places, (size_t)3 * coarse->vertex_count, sizeof *places);
  scree_rt_release(allocator, distances, fine->vertex_count, sizeof *distances);
  return result;
}

static scree_result make_finest(shard_levels* levels, shard_asset* out) {
  lattice_mesh* mesh = &out->lods[0].mesh;
  uint32_t left = UINT32_MAX;
  mesh_simplifier_clean(levels->simplifier);
  for (;;) {
    const scree_result result = shard_levels_take(levels, mesh);
    if (result != SCREE_OK || mesh->vertex_count <= SHARD_ASSET_MAX_VERTICES) return result;
    /* As many triangles fewer as there are vertices too many. */
    const uint32_t target = (uint32_t)((uint64_t)mesh->triangle_count * SHARD_ASSET_MAX_VERTICES / mesh->vertex_count * 95 / 100);
    shard_level_release(mesh, &levels->allocator);
    const uint32_t made = mesh_simplifier_run(levels->simplifier, target);
    if (made == left) return SCREE_ERROR_RANGE;
    left = made;
  }
}

/* A quarter of the triangles of the level before, the last one small enough. */
static scree_result make_level(shard_levels* levels, const shard_asset_desc* desc, shard_asset* out, uint32_t lod) {
  const lattice_mesh *finest = &out->lods[0].mesh, *before = &out->lods[lod - 1].mesh;
  uint32_t target = before->triangle_count / 4;
  if (lod + 1 == desc->lods && target > COARSEST_MOST) target = COARSEST_MOST;
  if (target < COARSEST_LEAST) target = COARSEST_LEAST;
  shard_lod* here = &out->lods[lod];
  mesh_simplifier_run(levels->simplifier, target);
  scree_result result = shard_levels_take(levels, &here->mesh);
  if (result != SCREE_OK) return result;
  const mesh_buffer a = view_of(finest), b = view_of(&here->mesh);
  const double share = here->mesh.triangle_count >= 4 ? mesh_volume(&b) / mesh_volume(&a) : 0;
  const bool coarser = here->mesh.triangle_count < before->triangle_count && here->mesh.vertex_count <= SHARD_ASSET_MAX_VERTICES;
  if (!coarser || !(share >= LEAST_VOLUME && share <= MOST_VOLUME)) {
    shard_level_release(&here->mesh, &levels->allocator);
    here->error_of_most = out->lods[lod - 1].error_of_most;
    return shard_level_copy(before, &levels->allocator, &here->mesh);
  }
  result =
      measure_error(finest, &here->mesh, &levels->allocator, 1 / desc->steps_per_metre, &here->mesh.error, &here->error_of_most);
  if (here->mesh.error < before->error) here->mesh.error = before->error;
  if (here->error_of_most < out->lods[lod - 1].error_of_most) here->error_of_most = out->lods[lod - 1].error_of_most;
  return result;
}

/* --- Mass and hulls. --- */

/* Whether a point is inside, by the parity of the triangles along a skew line; false where the line passes too near an edge to be
 * sure. */
static bool holds(const lattice_mesh* mesh, const double p[3]) {
  const double d[3] = {0.0837, 1, 0.0611};
  bool inside = false;
  for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
    double c[3][3], side[3];
    for (uint32_t k = 0; k < 3; ++k)
      for (uint32_t a = 0; a < 3; ++a) c[k][a] = mesh->positions[mesh->indices[(size_t)3 * t + k]][a] - p[a];
    for (uint32_t k = 0; k < 3; ++k) {
      const double *u = c[k], *v = c[(k + 1) % 3];
      side[k] = d[0] * (u[1] * v[2] - u[2] * v[1]) + d[1] * (u[2] * v[0] - u[0] * v[2]) + d[2] * (u[0] * v[1] - u[1] * v[0]);
    }
    const bool all_left = side[0] >= 0 && side[1] >= 0 && side[2] >= 0, all_right = side[0] <= 0 && side[1] <= 0 && side[2] <= 0;
    const double all = side[0] + side[1] + side[2];
    if (!(all_left || all_right) || all == 0) continue;
    const double least = all_left ? fmin(side[0], fmin(side[1], side[2])) : -fmax(side[0], fmax(side[1], side[2]));
    if (least <= 1e-9 * fabs(all)) return false;
    const double y = (side[1] * c[0][1] + side[2] * c[1][1] + side[0] * c[2][1]) / all;
    if (y > 0) inside = !inside;
  }
  return inside;
}

static void add_extent(const shard_asset_desc* desc, shard_asset* out) {
  const lattice_mesh* mesh = &out->lods[0].mesh;
  const double metres = 1 / desc->steps_per_metre;
  /* What stands may reach into the ground, which is y = 0. */
  const double ground = desc->block || out->bounds_min[1] > 0 ? out->bounds_min[1] : 0;
  const double foot = ground + 0.01 * (out->bounds_max[1] - ground);
  double farthest2 = 0;
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    const int16_t* p = mesh->positions[v];
    const double distance2 = (double)p[0] * p[0] + (double)p[2] * p[2];
    if (p[1] >= ground && p[1] <= foot && distance2 > farthest2) farthest2 = distance2;
  }
  for (size_t i = 0; i < (size_t)3 * mesh->triangle_count; ++i) {
    const int16_t *p = mesh->positions[mesh->indices[i]], *q = mesh->positions[mesh->indices[i % 3 == 2 ? i - 2 : i + 1]];
    if (!(p[1] < ground && q[1] > ground)) continue; /* the other way is another triangle's */
    const double part = (ground - p[1]) / (q[1] - p[1]), x = p[0] + part * (q[0] - p[0]), z = p[2] + part * (q[2] - p[2]);
    if (x * x + z * z > farthest2) farthest2 = x * x + z * z;
  }
  out->footprint = (float)(sqrt(farthest2) * metres * (1 + 1e-6));
  out->height = (float)(out->bounds_max[1] * metres);
  for (uint32_t lod = 0; lod < out->lod_count; ++lod)
    for (uint32_t v = 0; v < out->lods[lod].mesh.vertex_count; ++v)
      for (uint32_t a = 0; a < 2; ++a) {
        const float uv = out->lods[lod].mesh.uvs[v][a];
        const bool first = lod == 0 && v == 0;
        if (first || uv < out->uv_min[a]) out->uv_min[a] = uv;
        if (first || uv > out->uv_max[a]) out->uv_max[a] = uv;
      }
}

static scree_result add_mass(const shard_asset_desc* desc, const int16_t (*places)[3], const scree_allocator* allocator,
                             shard_asset* out) {
  const lattice_mesh* finest = &out->lods[0].mesh;
  const mesh_buffer mesh = view_of(finest);
  rock_record record = {0};
  rock_mass(&mesh, (float)(1 / desc->steps_per_metre), &record);
  memcpy(out->bounds_min, record.bounds_min, sizeof out->bounds_min);
  memcpy(out->bounds_max, record.bounds_max, sizeof out->bounds_max);
  memcpy(out->centroid, record.centroid, sizeof out->centroid);
  out->volume = record.volume;
  out->outer_radius = record.outer_radius;
  double centroid[3];
  for (uint32_t a = 0; a < 3; ++a) centroid[a] = (double)record.centroid[a] * desc->steps_per_metre;
  out->inner_radius = holds(finest, centroid) ? record.inner_radius : 0;
  add_extent(desc, out);
  scree_result result = convex_hull_of(&mesh, kernels_choose(false), ROCK_MAX_HULL, allocator, out->hull, &out->hull_count);
  if (result != SCREE_OK) return result;
  const double volume = mesh_volume(&mesh), hull = convex_volume((const int16_t(*)[3])out->hull, out->hull_count);
  if (!(volume > 0 && hull > 0) || out->hull_count < 4) return SCREE_ERROR_INVALID_ARGUMENT;
  double parts = 0;
  if (!desc->block)
    result = shard_parts_make(&desc->shards->view, desc->inside, places, allocator, out->parts, &out->part_count, &parts);
  if (result != SCREE_OK) return result;
  if (out->part_count == 0) {
    uint32_t count;
    result = convex_hull_of(&mesh, kernels_choose(false), SHARD_PART_MAX_HULL, allocator, out->parts[0].hull, &count);
    if (result != SCREE_OK) return result;
    out->parts[0].hull_count = count;
    out->part_count = 1;
    parts = convex_volume((const int16_t(*)[3])out->parts[0].hull, count);
  }
  out->hull_air = (float)(hull > volume ? 1 - volume / hull : 0);
  out->parts_air = (float)(parts > volume ? 1 - volume / parts : 0);
  return SCREE_OK;
}

/* --- All of it. --- */

static scree_result make_levels(const shard_asset_desc* desc, const int16_t (*places)[3], const scree_allocator* allocator,
                                shard_asset* out) {
  surface_desc on = {
      .shards = &desc->shards->view, .inside = desc->inside, .joints = desc->joints, .ground = !desc->block, .jobs = desc->jobs};
  memcpy(on.origin, desc->origin, sizeof on.origin);
  surface_vertices surface;
  scree_result result = surface_vertices_create(&on, allocator, &surface);
  if (result != SCREE_OK) return result;
  shard_levels levels = {0};
  result =
      surface.source.count >= 4 ? shard_levels_create(desc, &surface, places, allocator, &levels) : SCREE_ERROR_INVALID_ARGUMENT;
  surface_vertices_destroy(&surface, allocator);
  if (result == SCREE_OK) result = make_finest(&levels, out);
  if (result == SCREE_OK && out->lods[0].mesh.triangle_count < 4) result = SCREE_ERROR_INVALID_ARGUMENT;
  for (out->lod_count = 1; result == SCREE_OK && out->lod_count < desc->lods; ++out->lod_count)
    result = make_level(&levels, desc, out, out->lod_count);
  shard_levels_destroy(&levels);
  return result;
}

scree_result shard_asset_make(const shard_asset_desc* desc, const scree_allocator* allocator, shard_asset* out) {
  memset(out, 0, sizeof *out);
  if (!(desc->steps_per_metre > 0) || desc->lods < 1 || desc->lods > ROCK_MAX_LODS) return SCREE_ERROR_INVALID_ARGUMENT;
  const scree_allocator from = scree_rt_allocator_or_default(allocator);
  const uint32_t count = desc->shards->view.vertex_count;
  int16_t(*places)[3] = scree_rt_allocate(&from, count, sizeof *places);
  if (places == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  scree_result result = set_places(desc, places) ? SCREE_OK : SCREE_ERROR_RANGE;
  if (result == SCREE_OK) result = make_levels(desc, (const int16_t(*)[3])places, &from, out);
  if (result == SCREE_OK) result = add_mass(desc, (const int16_t(*)[3])places, &from, out);
  scree_rt_release(&from, places, count, sizeof *places);
  if (result != SCREE_OK) shard_asset_destroy(out, &from);
  return result;
}
