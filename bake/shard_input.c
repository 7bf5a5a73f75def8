/* The solid of a recipe of shards, and which of its shards are core. */
#include <math.h>
#include <string.h>

#include "hoodoo_model.h"
#include "pack_format.h"
#include "random.h"
#include "recipe_text.h"
#include "shard_keys.h"
#include "solid_internal.h"

enum { DEFAULT_RESOLUTION = 96 };
#define HALF_PI 1.5707963267948966

static scree_result not_given(scree_error* error, const char* what) {
  recipe_say(error, "input.shape: the %s was not given", what);
  return SCREE_ERROR_INVALID_ARGUMENT;
}

/* Puts the key before what a callee said, which names the file where there is one. */
static scree_result tell(scree_result result, const scree_error* fault, scree_error* error) {
  if (result != SCREE_OK && fault->message[0] != '\0') recipe_say(error, "input: %.400s", fault->message);
  return result;
}

static scree_result make_box(const scree_shard_input* input, const scree_allocator* allocator, scree_solid_memory* out,
                             scree_error* error) {
  static const uint32_t quads[6][4] = {{0, 2, 6, 4}, {1, 5, 7, 3}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 6, 7, 5}};
  const scree_result result = solid_memory_create(8, 12, false, allocator, out, error);
  if (result != SCREE_OK) return result;
  double* positions = solid_positions(out);
  uint32_t* indices = solid_indices(out);
  for (uint32_t v = 0; v < 8; ++v) {
    positions[3 * v] = ((v >> 2 & 1) - 0.5) * input->size[0];
    positions[3 * v + 1] = (v >> 1 & 1) * input->size[1];
    positions[3 * v + 2] = ((v & 1) - 0.5) * input->size[2];
  }
  for (uint32_t q = 0; q < 6; ++q) {
    const uint32_t corners[6] = {quads[q][0], quads[q][1], quads[q][2], quads[q][0], quads[q][2], quads[q][3]};
    for (uint32_t i = 0; i < 6; ++i) *indices++ = corners[i];
  }
  return SCREE_OK;
}

/* Cosine of turn / sides of a full turn, in operations that repeat. */
static double cosine_of_turn(uint32_t turn, uint32_t sides) {
  const uint32_t eighths = 4 * turn / sides; /* which quarter */
  const double x = 4 * HALF_PI * turn / sides - eighths * HALF_PI;
  switch (eighths & 3) {
    case 0: return repeatable_cos(x);
    case 1: return -repeatable_cos(HALF_PI - x);
    case 2: return -repeatable_cos(x);
    default: return repeatable_cos(HALF_PI - x);
  }
}

/* A flank that is a parabola from the foot to the rim of the top: convex for every bulge. Corner k of ring r is vertex r * sides +
 * k, and walls between rings are planar, since both their edges are parallel. */
static scree_result make_hill(const scree_shard_input* input, const scree_allocator* allocator, scree_solid_memory* out,
                              scree_error* error) {
  const uint32_t rings = input->rings, sides = input->sides;
  const uint64_t triangles = (uint64_t)2 * rings * sides + 2 * (sides - 2);
  const scree_result result = solid_memory_create((uint64_t)(rings + 1) * sides, triangles, false, allocator, out, error);
  if (result != SCREE_OK) return result;
  double* positions = solid_positions(out);
  uint32_t* indices = solid_indices(out);
  const double foot = input->radius, rim = input->top * input->radius;
  const double middle = 0.5 * (foot + rim) + input->bulge * 0.5 * (foot - rim); /* of the parabola's control polygon */
  const double middle_height = 0.5 * input->height + input->bulge * 0.5 * input->height;
  for (uint32_t r = 0; r <= rings; ++r) {
    const double t = (double)r / rings, s = 1 - t;
    const double radius = s * s * foot + 2 * s * t * middle + t * t * rim;
    const double height = 2 * s * t * middle_height + t * t * input->height;
    for (uint32_t k = 0; k < sides; ++k) {
      double* p = positions + 3 * ((size_t)r * sides + k);
      p[0] = radius * cosine_of_turn(k, sides);
      p[1] = height;
      p[2] = -radius * cosine_of_turn((4 * k + 3 * sides) % (4 * sides), 4 * sides); /* sine, counter-clockwise from above */
    }
  }
  for (uint32_t r = 0; r < rings; ++r)
    for (uint32_t k = 0; k < sides; ++k) {
      const uint32_t a = r * sides + k, b = r * sides + (k + 1) % sides, c = a + sides, d = b + sides;
      const uint32_t corners[6] = {a, b, d, a, d, c};
      for (uint32_t i = 0; i < 6; ++i) *indices++ = corners[i];
    }
  for (uint32_t k = 1; k + 1 < sides; ++k) {
    const uint32_t last = rings * sides, corners[6] = {0, k + 1, k, last, last + k, last + k + 1};
    for (uint32_t i = 0; i < 6; ++i) *indices++ = corners[i];
  }
  return SCREE_OK;
}

static uint32_t resolution_of(const scree_shard_input* input) {
  return input->resolution > 0 ? input->resolution : DEFAULT_RESOLUTION;
}

/* A shape of distances, with noise on it. */
static scree_result make_shape(const scree_shard_input* input, uint32_t seed, const scree_allocator* allocator,
                               scree_solid_memory* out, scree_error* error) {
  const float radius = (float)input->radius, height = (float)input->height;
  scree_shape shapes[2] = {
      {.kind = SCREE_SHAPE_NOISE,
       .noise = {.child = 1,
                 .amplitude = (float)input->noise,
                 .wavelength = (float)input->wavelength,
                 .octaves = input->octaves,
                 .seed = seed}},
      {.kind = SCREE_SHAPE_SPHERE, .sphere = {radius}},
  };
  scree_shape* shape = &shapes[1];
  shape->transform.translation[1] = radius;
  if (input->shape == SCREE_SHARD_BOX) {
    shape->kind = SCREE_SHAPE_BOX;
    shape->box = (scree_box){{(float)(0.5 * input->size[0]), (float)(0.5 * input->size[1]), (float)(0.5 * input->size[2])}, 0};
    shape->transform.translation[1] = (float)(0.5 * input->size[1]);
  } else if (input->shape == SCREE_SHARD_CONE) {
    shape->kind = SCREE_SHAPE_CONE;
    shape->cone = (scree_cone){radius, height};
    shape->transform.translation[1] = 0;
  } else if (input->shape == SCREE_SHARD_CAPSULE && height > 2 * radius) {
    shape->kind = SCREE_SHAPE_CAPSULE;
    shape->capsule = (scree_capsule){{0, 0, 0}, {0, height - 2 * radius, 0}, radius};
  }
  const bool noisy = input->noise > 0;
  const scree_support_desc desc = {.shapes = noisy ? shapes : shape, .shape_count = noisy ? 2 : 1};
  scree_support* support;
  scree_result result = scree_support_create(&desc, allocator, &support, error);
  if (result != SCREE_OK) return result;
  result = scree_solid_from_support(support, resolution_of(input), allocator, out, error);
  scree_support_destroy(support);
  return result;
}

/* The pack says of no u or v that it lies farther out. */
static scree_result check_uvs(const scree_solid* mesh, const char* file, scree_error* error) {
  for (size_t i = 0; mesh->uvs != NULL && i < (size_t)6 * mesh->triangle_count; ++i)
    if (!(fabsf(mesh->uvs[i]) <= (float)PACK_MAX_UV)) {
      recipe_say(error, "%.200s%striangle %zu has a u or v that is not a number from -%d to %d: %g", file,
                 file[0] != '\0' ? ": " : "", i / 6, PACK_MAX_UV, PACK_MAX_UV, (double)mesh->uvs[i]);
      return SCREE_ERROR_RANGE;
    }
  return SCREE_OK;
}

static scree_result make_mesh(const scree_shard_input* input, const scree_solid* mesh, const scree_allocator* allocator,
                              scree_solid_memory* out, scree_error* error) {
  scree_result result = solid_check_numbers(mesh, error);
  if (result == SCREE_OK && input->resolution == 0) result = check_uvs(mesh, input->file, error);
  if (result != SCREE_OK) return result;
  const bool has_uvs = mesh->uvs != NULL && input->resolution == 0;
  scree_solid_memory moved;
  result = solid_memory_create(mesh->vertex_count, mesh->triangle_count, has_uvs, allocator, &moved, error);
  if (result != SCREE_OK) return result;
  double* positions = solid_positions(&moved);
  for (size_t i = 0; i < (size_t)3 * mesh->vertex_count; ++i)
    positions[i] = mesh->positions[i] * input->scale + input->position[i % 3];
  memcpy(solid_indices(&moved), mesh->indices, (size_t)3 * mesh->triangle_count * sizeof(uint32_t));
  if (has_uvs) memcpy(solid_uvs(&moved), mesh->uvs, (size_t)6 * mesh->triangle_count * sizeof(float));
  if (input->resolution == 0) {
    scree_error fault = {{0}};
    result = scree_solid_check(&moved.solid, allocator, &fault);
    if (result == SCREE_OK) {
      *out = moved;
      return SCREE_OK;
    }
    scree_solid_free(allocator, &moved);
    recipe_say(error, "%.200s%s%.280s", input->file, input->file[0] != '\0' ? ": " : "", fault.message);
    return result == SCREE_ERROR_UNSUPPORTED ? SCREE_ERROR_INVALID_ARGUMENT : result; /* of this solid, not by this build */
  }
  result = scree_solid_remesh(&moved.solid, input->resolution, allocator, out, error);
  scree_solid_free(allocator, &moved);
  return result;
}

static scree_result make_hoodoo(const scree_shard_desc* desc, const scree_allocator* allocator, scree_solid_memory* out,
                                scree_error* error) {
  const scree_shard_input* input = &desc->recipe->input;
  scree_hoodoo_desc hoodoo = *desc->hoodoo;
  hoodoo.jobs = desc->jobs;
  hoodoo.allocator = *allocator;
  hoodoo.progress = NULL;
  weather_asset* asset = scree_rt_allocate_zeroed(allocator, 1, sizeof *asset);
  if (asset == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  uint32_t steps;
  scree_result result = hoodoo_model_make(&hoodoo, input->variant, input->age, input->lod + 1, asset, &steps, error);
  if (result == SCREE_OK) {
    const lattice_mesh* mesh = &asset->lods[input->lod].mesh;
    result = solid_memory_create(mesh->vertex_count, mesh->triangle_count, false, allocator, out, error);
    if (result == SCREE_OK) {
      double* positions = solid_positions(out);
      for (size_t v = 0; v < mesh->vertex_count; ++v)
        for (int a = 0; a < 3; ++a) positions[3 * v + a] = (double)mesh->positions[v][a] / steps;
      memcpy(solid_indices(out), mesh->indices, (size_t)3 * mesh->triangle_count * sizeof(uint32_t));
    }
    weather_asset_destroy(asset, allocator);
  }
  scree_rt_release(allocator, asset, 1, sizeof *asset);
  return result;
}

scree_result scree_shard_solid_make(const scree_shard_desc* desc, scree_solid_memory* out, scree_error* error) {
  const scree_shard_input* input = &desc->recipe->input;
  const scree_allocator allocator = scree_rt_allocator_or_default(&desc->allocator);
  const uint32_t seed = (uint32_t)hash_mix(desc->recipe->random_seed ^ UINT64_C(0x696e707574));
  scree_error fault = {{0}};
  memset(out, 0, sizeof *out);
  if (error != NULL) memset(error, 0, sizeof *error);
  scree_result result = shard_check_all(desc->recipe, error);
  if (result != SCREE_OK) return result;
  switch (input->shape) {
    case SCREE_SHARD_BOX:
      result = input->noise > 0 ? make_shape(input, seed, &allocator, out, &fault) : make_box(input, &allocator, out, &fault);
      break;
    case SCREE_SHARD_HILL: result = make_hill(input, &allocator, out, &fault); break;
    case SCREE_SHARD_SPHERE:
    case SCREE_SHARD_CONE:
    case SCREE_SHARD_CAPSULE: result = make_shape(input, seed, &allocator, out, &fault); break;
    case SCREE_SHARD_MESH:
      if (desc->mesh == NULL) return not_given(error, "mesh");
      result = make_mesh(input, desc->mesh, &allocator, out, &fault);
      break;
    case SCREE_SHARD_TERRAIN:
      if (desc->heights == NULL) return not_given(error, "terrain");
      result = scree_solid_from_heights(desc->heights, desc->height_width, desc->height_depth, input->spacing, input->base,
                                        &allocator, out, &fault);
      break;
    case SCREE_SHARD_HOODOO:
      if (desc->hoodoo == NULL || desc->hoodoo->recipe == NULL) return not_given(error, "recipe of hoodoos");
      result = make_hoodoo(desc, &allocator, out, &fault);
      break;
    case SCREE_SHARD_SUPPORT:
      if (desc->support == NULL) return not_given(error, "support");
      result = scree_solid_from_support(desc->support, resolution_of(input), &allocator, out, &fault);
      break;
  }
  return tell(result, &fault, error);
}

/* --- states ----------------------------------------------------------------------------------------------------------------- */

static double along(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Whether a face of a shard on the outside looks where a region says. */
static bool is_facing(const scree_shards_view* view, const scree_shard* shard, const double direction[3], double least) {
  for (uint32_t i = 0; i < shard->link_count; ++i) {
    const scree_link* link = &view->links[view->shard_links[shard->first_link + i]];
    if (link->shards[1] == SCREE_NO_SHARD && along(link->normal, direction) >= least) return true;
  }
  return false;
}

static double lowest(const scree_shards_view* view, const scree_shard* shard) {
  double low = shard->centroid[1];
  for (uint32_t i = 0; i < shard->link_count; ++i) {
    const scree_link* link = &view->links[view->shard_links[shard->first_link + i]];
    for (uint32_t p = link->first_polygon; p < link->first_polygon + link->polygon_count; ++p)
      for (uint32_t c = 0; c < view->polygons[p].corner_count; ++c) {
        const double y = view->vertices[3 * (size_t)view->corners[view->polygons[p].first_corner + c] + 1];
        if (y < low) low = y;
      }
  }
  return low;
}

static bool is_within(const scree_shards_view* view, const scree_shard* shard, const scree_shard_region* region) {
  const double* c = shard->centroid;
  const double length = sqrt(along(region->direction, region->direction));
  double direction[3] = {0, 1, 0}, distance2 = 0;
  for (int a = 0; a < 3 && length > 0; ++a) direction[a] = region->direction[a] / length;
  switch (region->where) {
    case SCREE_SHARD_ALL: return true;
    case SCREE_SHARD_EXTERIOR: return is_facing(view, shard, direction, -2);
    case SCREE_SHARD_FACING: return is_facing(view, shard, direction, repeatable_cos_to_pi(region->angle));
    case SCREE_SHARD_AT_BASE: {
      const double slack = 1e-6 * (view->max[1] - view->min[1]);
      return lowest(view, shard) <= view->min[1] + region->depth + slack;
    }
    case SCREE_SHARD_IN_BOX:
      for (int a = 0; a < 3; ++a)
        if (!(c[a] >= region->min[a] && c[a] <= region->max[a])) return false;
      return true;
    case SCREE_SHARD_IN_SPHERE:
      for (int a = 0; a < 3; ++a) distance2 += (c[a] - region->centre[a]) * (c[a] - region->centre[a]);
      return distance2 <= region->radius * region->radius;
    case SCREE_SHARD_BEYOND: return along(c, direction) >= region->offset;
  }
  return false;
}

uint32_t scree_shard_states(const scree_shard_recipe* recipe, const scree_shards* shards, uint8_t* states) {
  scree_shards_view view;
  scree_shards_get(shards, &view);
  uint32_t idle = (UINT32_C(1) << recipe->state_count) - 1;
  for (uint32_t s = 0; s < view.shard_count; ++s) {
    states[s] = SCREE_SHARD_SOLID;
    for (uint32_t r = 0; r < recipe->state_count; ++r) {
      if (!is_within(&view, &view.shards[s], &recipe->states[r])) continue;
      states[s] = (uint8_t)recipe->states[r].state;
      idle &= ~(UINT32_C(1) << r);
    }
  }
  return idle;
}
