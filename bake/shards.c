#include <math.h>
#include <stdio.h>
#include <string.h>

#include "convex_walls.h"
#include "lattice.h"
#include "random.h"
#include "shard_space.h"
#include "shards_internal.h"
#include "solid_internal.h"
#include "vectors.h"

enum { MOST_ATTEMPTS = 8 };

static const double MOST = 1e6;   /* of coordinates and counts */
static const double MOVED = 1e-6; /* of the seeds' spacing, at first; where that is too little, farther each time */
static const double FARTHER = 4;
static const float SAME_UV = 1e-5F; /* of the largest difference along a wall */

static scree_result tell(scree_error* error, scree_result result, const char* message) {
  if (error != NULL) snprintf(error->message, sizeof error->message, "%s", message);
  return result;
}

/* --- what is asked ---------------------------------------------------------------------------------------------------------- */

static scree_result check_desc(const scree_shards_desc* desc, const scree_allocator* allocator, shard_space* space,
                               scree_error* error) {
  const scree_result result = solid_check_closed(&desc->solid, allocator, error);
  if (result != SCREE_OK) return result;
  if (desc->seeds == NULL || desc->seed_count == 0) return tell(error, SCREE_ERROR_INVALID_ARGUMENT, "no seeds are given");
  if (desc->seed_count > MOST) return tell(error, SCREE_ERROR_RANGE, "more than 1,000,000 seeds are given");
  for (size_t i = 0; i < 3 * (size_t)desc->seed_count; ++i)
    if (!(fabs(desc->seeds[i]) <= MOST)) {
      if (error != NULL)
        snprintf(error->message, sizeof error->message, "seed %u is not within 1e6 of the origin", (unsigned)(i / 3));
      return SCREE_ERROR_RANGE;
    }
  if (!shard_space_make(desc->up, desc->stretch, space))
    return tell(error, SCREE_ERROR_RANGE, "stretch must be 0.01..100, and up have a direction");
  if (!(desc->link_angle >= 0 && desc->link_angle <= 3.14159265358979323846))
    return tell(error, SCREE_ERROR_RANGE, "link_angle must be 0..pi");
  if (desc->clip != SCREE_CLIP_AUTO && desc->clip != SCREE_CLIP_WALLS && desc->clip != SCREE_CLIP_MESH)
    return tell(error, SCREE_ERROR_INVALID_ARGUMENT, "clip is none of the three ways");
  if (desc->jobs.parallel_for != NULL && desc->jobs.worker_count == 0)
    return tell(error, SCREE_ERROR_INVALID_ARGUMENT, "jobs have no workers");
  return SCREE_OK;
}

/* Whether UVs go on evenly over every wall, so that one triangle says them for all of it. */
static bool uvs_are_even(const scree_solid* solid, const double* positions, const convex_walls* walls) {
  if (solid->uvs == NULL) return true;
  for (uint32_t t = 0; t < solid->triangle_count; ++t) {
    const uint32_t from = walls->triangles[walls->wall_of[t]];
    if (from == t) continue;
    const double* n = walls->walls[walls->wall_of[t]].normal;
    const double* at[3];
    for (uint32_t k = 0; k < 3; ++k) at[k] = positions + 3 * (size_t)solid->indices[3 * (size_t)from + k];
    for (uint32_t k = 0; k < 3; ++k) {
      const double* p = positions + 3 * (size_t)solid->indices[3 * (size_t)t + k];
      double part[3], sum = 0;
      for (int c = 0; c < 3; ++c) {
        const double *a = at[(c + 1) % 3], *b = at[(c + 2) % 3];
        const double u[3] = {a[0] - p[0], a[1] - p[1], a[2] - p[2]}, v[3] = {b[0] - p[0], b[1] - p[1], b[2] - p[2]};
        part[c] = n[0] * (u[1] * v[2] - u[2] * v[1]) + n[1] * (u[2] * v[0] - u[0] * v[2]) + n[2] * (u[0] * v[1] - u[1] * v[0]);
        sum += part[c];
      }
      for (int axis = 0; axis < 2; ++axis) {
        const float* uv = solid->uvs + 6 * (size_t)from + axis;
        double said = 0, most = 1;
        for (int c = 0; c < 3; ++c) {
          said += part[c] / sum * (double)uv[2 * c];
          most = fabs((double)uv[2 * c]) > most ? fabs((double)uv[2 * c]) : most;
        }
        if (!(fabs(said - (double)solid->uvs[6 * (size_t)t + 2 * k + (uint32_t)axis]) <= (double)SAME_UV * most)) return false;
      }
    }
  }
  return true;
}

static scree_result choose_clip(const scree_shards_desc* desc, const shard_input* input, scree_clip* clip, scree_error* error) {
  *clip = desc->clip;
  if (desc->clip == SCREE_CLIP_MESH) return SCREE_OK;
  bool convex = convex_walls_possible(input->positions, input->vertex_count, input->indices, input->triangle_count), even = true;
  if (convex) {
    convex_walls walls;
    const scree_result result = convex_walls_create(input->positions, input->vertex_count, input->indices, input->triangle_count,
                                                    &input->allocator, &walls, &convex);
    if (result != SCREE_OK) return result;
    even = !convex || uvs_are_even(&desc->solid, input->positions, &walls);
    convex_walls_free(&walls, &input->allocator);
  }
  if (desc->clip == SCREE_CLIP_WALLS) {
    if (!convex) return tell(error, SCREE_ERROR_INVALID_ARGUMENT, "the solid is not convex: walls cannot cut it");
    if (!even)
      return tell(error, SCREE_ERROR_INVALID_ARGUMENT,
                  "UVs turn within a plane of the solid: walls cannot say where, clip by mesh");
  }
  *clip = convex && even ? SCREE_CLIP_WALLS : SCREE_CLIP_MESH;
  return SCREE_OK;
}

/* --- attempts --------------------------------------------------------------------------------------------------------------- */

/* How far seeds are apart, roughly: as if they filled the solid's box. */
static double spacing_of(const shard_input* input) {
  double min[3], max[3];
  points_bounds(input->positions, input->vertex_count, min, max);
  const double volume = (max[0] - min[0]) * (max[1] - min[1]) * (max[2] - min[2]);
  return volume > 0 ? repeatable_cube_root(volume / input->seed_count) : 1;
}

static void move_seeds(const double* from, uint32_t count, uint32_t attempt, double reach, double* out) {
  for (uint64_t i = 0; i < 3 * (uint64_t)count; ++i) {
    const double part = (double)(hash_mix((i + 1) * MOST_ATTEMPTS + attempt) >> 11) * 0x1p-52 - 1;
    out[i] = from[i] + reach * part;
  }
}

/* done never falls: what is left shrinks with each attempt. */
static bool told_to_stop(const scree_shards_desc* desc, double left) {
  const double done = 1 - left;
  return desc->progress != NULL && !desc->progress(desc->progress_user, "shards", done);
}

static scree_result attempt_shards(const scree_shards_desc* desc, const shard_input* input, const shard_space* space, double* left,
                                   scree_shards** out, scree_error* error) {
  shard_pieces pieces;
  scree_result result = desc->clip == SCREE_CLIP_WALLS ? shard_walls_cut(input, &pieces) : shard_clip_cut(input, &pieces);
  if (result != SCREE_OK) return result;
  *left *= 0.3;
  if (told_to_stop(desc, *left))
    result = SCREE_ERROR_CANCELLED;
  else {
    if (!space->is_plain)
      for (size_t i = 0; i < pieces.vertex_count; ++i) shard_space_out_of(space, pieces.vertices + 3 * i, pieces.vertices + 3 * i);
    result = shards_assemble(desc, &pieces, out, error);
  }
  shard_pieces_free(&pieces, &input->allocator);
  return result;
}

/* As given first, then with seeds moved, as long as the geometry cannot be right. */
static scree_result try_shards(const scree_shards_desc* desc, const shard_input* still, const shard_space* space, double* moved,
                               double* left, scree_shards** out, scree_error* error) {
  shard_input input = *still;
  double reach = MOVED * spacing_of(still);
  scree_result result = SCREE_ERROR_UNSUPPORTED;
  for (uint32_t attempt = 0; attempt <= MOST_ATTEMPTS && result == SCREE_ERROR_UNSUPPORTED; ++attempt) {
    if (told_to_stop(desc, *left)) return SCREE_ERROR_CANCELLED;
    if (attempt > 0) {
      move_seeds(still->seeds, still->seed_count, attempt, reach, moved);
      input.seeds = moved;
      reach *= FARTHER;
    }
    result = attempt_shards(desc, &input, space, left, out, error);
    if (result == SCREE_OK) (*out)->view.attempts = attempt;
  }
  return result;
}

static scree_result make_shards(const scree_shards_desc* given, const shard_input* input, const shard_space* space, double* moved,
                                scree_shards** out, scree_error* error) {
  scree_shards_desc desc = *given;
  scree_result result = choose_clip(given, input, &desc.clip, error);
  if (result != SCREE_OK) return result;
  double left = 1;
  result = try_shards(&desc, input, space, moved, &left, out, error);
  if (result != SCREE_ERROR_UNSUPPORTED || given->clip != SCREE_CLIP_AUTO || desc.clip == SCREE_CLIP_MESH) return result;
  /* Not as convex as it looked. */
  desc.clip = SCREE_CLIP_MESH;
  return try_shards(&desc, input, space, moved, &left, out, error);
}

scree_result scree_shards_create(const scree_shards_desc* desc, scree_shards** out, scree_error* error) {
  if (out != NULL) *out = NULL;
  if (desc == NULL || out == NULL) return tell(error, SCREE_ERROR_INVALID_ARGUMENT, "no description, or no place for the shards");
  const scree_allocator allocator = scree_rt_allocator_or_default(&desc->allocator);
  shard_space space;
  scree_result result = check_desc(desc, &allocator, &space, error);
  if (result != SCREE_OK) return result;
  const uint32_t vertices = desc->solid.vertex_count, seeds = desc->seed_count;
  double* positions = scree_rt_allocate(&allocator, vertices, 3 * sizeof *positions);
  double* still = scree_rt_allocate(&allocator, seeds, 3 * sizeof *still);
  double* moved = scree_rt_allocate(&allocator, seeds, 3 * sizeof *moved);
  result = SCREE_ERROR_OUT_OF_MEMORY;
  if (positions != NULL && still != NULL && moved != NULL) {
    for (size_t i = 0; i < vertices; ++i) shard_space_into(&space, desc->solid.positions + 3 * i, positions + 3 * i);
    for (size_t i = 0; i < seeds; ++i) shard_space_into(&space, desc->seeds + 3 * i, still + 3 * i);
    const shard_input input = {positions, desc->solid.indices, vertices, desc->solid.triangle_count, still,
                               seeds,     desc->jobs,          allocator};
    result = make_shards(desc, &input, &space, moved, out, error);
  }
  scree_rt_release(&allocator, positions, vertices, 3 * sizeof *positions);
  scree_rt_release(&allocator, still, seeds, 3 * sizeof *still);
  scree_rt_release(&allocator, moved, seeds, 3 * sizeof *moved);
  if (result == SCREE_ERROR_OUT_OF_MEMORY) return tell(error, result, "out of memory");
  if (result == SCREE_ERROR_CANCELLED) return tell(error, result, "cancelled");
  if (result == SCREE_ERROR_UNSUPPORTED && solid_check_crossings(&desc->solid, &allocator, error) != SCREE_ERROR_UNSUPPORTED)
    return tell(error, result, "cells do not fit together: the solid crosses itself along edges, or seeds are too near to it");
  if (result == SCREE_OK && told_to_stop(desc, 0)) {
    scree_shards_destroy(*out);
    *out = NULL;
    return tell(error, SCREE_ERROR_CANCELLED, "cancelled");
  }
  return result;
}

/* --- what was made ---------------------------------------------------------------------------------------------------------- */

void scree_shards_destroy(scree_shards* shards) {
  if (shards == NULL) return;
  const scree_allocator allocator = shards->allocator;
  scree_rt_release(&allocator, shards->memory, shards->size, 1);
  scree_rt_release(&allocator, shards, 1, sizeof *shards);
}

void scree_shards_get(const scree_shards* shards, scree_shards_view* out) {
  *out = shards->view;
}

static uint64_t hash_doubles(uint64_t hash, const double* values, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    uint64_t bits;
    const double value = values[i] + 0.0; /* -0 is 0 */
    memcpy(&bits, &value, sizeof bits);
    hash = hash_combine(hash, bits);
  }
  return hash;
}

static uint64_t hash_words(uint64_t hash, const uint32_t* values, size_t count) {
  for (size_t i = 0; i < count; ++i) hash = hash_combine(hash, values[i]);
  return hash;
}

uint64_t scree_shards_digest(const scree_shards* shards) {
  const scree_shards_view* view = &shards->view;
  uint64_t hash = hash_combine(UINT64_C(0x7368617264733031), view->shard_count); /* "shards01" */
  hash = hash_combine(hash, (uint64_t)view->interior_link_count << 32 | view->link_count);
  for (uint32_t i = 0; i < view->shard_count; ++i) {
    const scree_shard* shard = view->shards + i;
    hash = hash_combine(hash_doubles(hash_doubles(hash, shard->centroid, 3), &shard->volume, 1), shard->seed);
  }
  for (uint32_t i = 0; i < view->link_count; ++i) {
    const scree_link* link = view->links + i;
    hash = hash_words(hash_doubles(hash_doubles(hash_doubles(hash, &link->area, 1), link->normal, 3), link->centroid, 3),
                      link->shards, 2);
    hash = hash_combine(hash, link->polygon_count);
  }
  for (uint32_t i = 0; i < view->polygon_count; ++i)
    hash = hash_combine(hash, (uint64_t)view->polygons[i].triangle << 32 | view->polygons[i].corner_count);
  hash = hash_words(hash, view->corners, view->corner_count);
  hash = hash_doubles(hash, view->vertices, 3 * (size_t)view->vertex_count);
  hash = hash_words(hash, view->neighbour_first, view->link_count + (size_t)1);
  return hash_words(hash, view->neighbours, view->neighbour_first[view->link_count]);
}
