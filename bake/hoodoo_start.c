/* What a variant of a recipe stands as before its first step. */
#include <math.h>
#include <string.h>

#include "allocator.h"
#include "hoodoo_recipe.h"
#include "lattice.h"
#include "random.h"
#include "recipe_text.h"

uint64_t hoodoo_variant_seed(const scree_hoodoo_recipe* recipe, uint32_t variant) {
  return hash_combine(hash_combine(recipe->random_seed, UINT64_C(0x400d)), variant);
}

/* The outline of a column: a circle with two, three and five lobes at random places. */
typedef struct outline {
  double radius, lobes;
  double cosine[3], sine[3]; /* of the phases of the lobes */
} outline;

static outline make_outline(const scree_hoodoo_start* start, uint64_t seed) {
  outline out = {.radius = start->radius, .lobes = start->lobes};
  random_stream stream = {hash_combine(seed, UINT64_C(0x10be))};
  for (int i = 0; i < 3; ++i) {
    double x, y, length2;
    do {
      x = 2 * random_unit(&stream) - 1;
      y = 2 * random_unit(&stream) - 1;
      length2 = x * x + y * y;
    } while (length2 > 1 || length2 < 1e-6);
    const double length = sqrt(length2);
    out.cosine[i] = x / length;
    out.sine[i] = y / length;
  }
  return out;
}

/* Multiples of an angle by polynomials of its cosine and sine: libm's differ between systems. */
static bool inside_outline(const outline* line, double x, double z) {
  const double r = sqrt(x * x + z * z);
  if (r == 0) return true;
  const double c = x / r, s = z / r, c2 = c * c, s2 = s * s;
  const double cosines[3] = {c2 - s2, c * (4 * c2 - 3), c * (16 * c2 * c2 - 20 * c2 + 5)};
  const double sines[3] = {2 * c * s, s * (3 - 4 * s2), s * (16 * s2 * s2 - 20 * s2 + 5)};
  static const double heights[3] = {0.125, 0.0875, 0.0625};
  double reach = 1;
  for (int i = 0; i < 3; ++i) reach += line->lobes * heights[i] * (sines[i] * line->cosine[i] + cosines[i] * line->sine[i]);
  return r <= line->radius * reach;
}

static scree_result make_column(const scree_hoodoo_recipe* recipe, uint64_t seed, const scree_allocator* allocator,
                                scree_weather_start* out, scree_hoodoo_start_memory* memory) {
  const uint32_t width = recipe->size[0], depth = recipe->size[2];
  memory->map_size = (size_t)width * depth;
  uint8_t* map = memory->map = scree_rt_allocate(allocator, memory->map_size, 1);
  if (map == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  const double share = recipe->start.height > 0 ? recipe->start.height / recipe->size[1] : 1;
  const uint8_t height = (uint8_t)(share < 1 ? share * 255 + 0.5 : 255);
  const outline line = make_outline(&recipe->start, seed);
  for (uint32_t z = 0; z < depth; ++z)
    for (uint32_t x = 0; x < width; ++x)
      map[(size_t)z * width + x] = inside_outline(&line, x + 0.5 - 0.5 * width, z + 0.5 - 0.5 * depth) ? height : 0;
  out->kind = SCREE_START_JOINT_MAP;
  out->map = map;
  out->map_width = width;
  out->map_depth = depth;
  return SCREE_OK;
}

/* One shape, with voxels for metres, in the middle of the ground. */
static scree_result make_shape(const scree_hoodoo_recipe* recipe, const scree_allocator* allocator, scree_weather_start* out,
                               scree_hoodoo_start_memory* memory, scree_error* error) {
  const scree_hoodoo_start* start = &recipe->start;
  const double height = start->height > 0 ? start->height : recipe->size[1] - start->lift;
  const float radius = (float)start->radius;
  scree_shape shape = {.kind = SCREE_SHAPE_SPHERE, .sphere = {radius}};
  double middle = start->lift + start->radius;
  if (start->shape != SCREE_HOODOO_SPHERE && !(height > 0)) {
    recipe_say(error, "start.lift: %g leaves no room below the top of the grid, %u", start->lift, recipe->size[1]);
    return SCREE_ERROR_RANGE;
  }
  if (start->shape == SCREE_HOODOO_CYLINDER) {
    shape.kind = SCREE_SHAPE_CYLINDER;
    shape.cylinder = (scree_cylinder){radius, (float)(0.5 * height)};
    middle = start->lift + 0.5 * height;
  } else if (start->shape == SCREE_HOODOO_CONE) {
    shape.kind = SCREE_SHAPE_CONE;
    shape.cone = (scree_cone){radius, (float)height};
    middle = start->lift;
  }
  shape.transform.translation[1] = (float)middle;
  out->kind = SCREE_START_SUPPORT;
  out->voxel = 1;
  for (int a = 0; a < 3; a += 2) out->origin[a] = -0.5 * recipe->size[a];
  const scree_result result =
      scree_support_create(&(scree_support_desc){.shapes = &shape, .shape_count = 1}, allocator, &memory->support, error);
  out->support = memory->support;
  return result;
}

static scree_result not_given(scree_error* error, const char* what) {
  recipe_say(error, "start.file: the %s was not given", what);
  return SCREE_ERROR_INVALID_ARGUMENT;
}

scree_result scree_hoodoo_start_make(const scree_hoodoo_desc* desc, uint32_t variant, scree_weather_start* out,
                                     scree_hoodoo_start_memory* memory, scree_error* error) {
  const scree_hoodoo_recipe* recipe = desc->recipe;
  const scree_hoodoo_start* start = &recipe->start;
  const scree_allocator allocator = scree_rt_allocator_or_default(&desc->allocator);
  memset(out, 0, sizeof *out);
  memset(memory, 0, sizeof *memory);
  out->seed = hoodoo_variant_seed(recipe, variant);
  memcpy(out->size, recipe->size, sizeof out->size);
  memcpy(out->box_min, start->min, sizeof out->box_min);
  memcpy(out->box_max, start->max, sizeof out->box_max);
  switch (start->shape) {
    case SCREE_HOODOO_BOX: out->kind = SCREE_START_BOX; return SCREE_OK;
    case SCREE_HOODOO_COLUMN: return make_column(recipe, out->seed, &allocator, out, memory);
    case SCREE_HOODOO_JOINT_MAP:
      if (desc->map == NULL) return not_given(error, "image");
      out->kind = SCREE_START_JOINT_MAP;
      out->map = desc->map;
      out->map_width = desc->map_width;
      out->map_depth = desc->map_depth;
      return SCREE_OK;
    case SCREE_HOODOO_JOINTS:
      out->kind = SCREE_START_JOINTS;
      out->joint_spacing = start->spacing;
      out->joint_gap = start->gap;
      out->joint_warp = start->warp;
      out->joint_missing = start->missing;
      out->joint_low = start->low;
      return SCREE_OK;
    case SCREE_HOODOO_SPHERE:
    case SCREE_HOODOO_CYLINDER:
    case SCREE_HOODOO_CONE: return make_shape(recipe, &allocator, out, memory, error);
    case SCREE_HOODOO_MESH:
      if (desc->mesh == NULL) return not_given(error, "mesh");
      out->kind = SCREE_START_SUPPORT;
      out->support = desc->mesh;
      out->voxel = recipe->voxel;
      for (int a = 0; a < 3; a += 2) out->origin[a] = -0.5 * recipe->size[a] * recipe->voxel;
      return SCREE_OK;
  }
  return SCREE_ERROR_RANGE;
}

void scree_hoodoo_start_free(const scree_hoodoo_desc* desc, scree_hoodoo_start_memory* memory) {
  const scree_allocator allocator = scree_rt_allocator_or_default(&desc->allocator);
  scree_rt_release(&allocator, memory->map, memory->map_size, 1);
  scree_support_destroy(memory->support);
  memset(memory, 0, sizeof *memory);
}
