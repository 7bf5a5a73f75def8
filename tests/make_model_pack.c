#include "make_model_pack.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "allocator.h"
#include "draco_encode.h"
#include "lattice.h"
#include "pack_writer.h"
#include "plain_encode.h"
#include "synthetic_rock.h"

#define TEST_RECIPE "{\"name\": \"test\", \"kind\": \"hoodoo\", \"note\": \"not baked\"}"

enum { STEPS_BELOW = 3, AXES = 14, PARTS = 2 };

static const uv_range test_uvs = {{-1, 0}, {1, 2}};

static void* checked(void* memory) {
  if (memory == NULL) abort();
  return memory;
}

static test_models_desc with_defaults(const test_models_desc* given) {
  test_models_desc desc = given != NULL ? *given : (test_models_desc){0};
  if (desc.variants == 0) desc.variants = 2;
  if (desc.ages == 0) desc.ages = 2;
  if (desc.lod_count == 0) desc.lod_count = 2;
  if (desc.lattice_per_cell == 0) desc.lattice_per_cell = 8;
  return desc;
}

/* A synthetic rock, a tenth smaller with each age. */
static void make_mesh(uint64_t seed, uint32_t age, uint32_t coarsening, lattice_mesh* mesh) {
  synthetic_rock_make(seed, 12, 4, coarsening, mesh);
  mesh->surface = checked(malloc(mesh->vertex_count * sizeof *mesh->surface));
  for (uint32_t v = 0; v < mesh->vertex_count; ++v)
    for (int axis = 0; axis < 3; ++axis)
      mesh->positions[v][axis] = (int16_t)(mesh->positions[v][axis] * (10 - (int)(age < 5 ? age : 5)) / 10);
}

static int lowest_point(const lattice_mesh* mesh) {
  int lowest = INT16_MAX;
  for (uint32_t v = 0; v < mesh->vertex_count; ++v)
    if (mesh->positions[v][1] < lowest) lowest = mesh->positions[v][1];
  return lowest;
}

/* Moves it up and gives it a surface. */
static void stand_up(lattice_mesh* mesh, int up) {
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    int16_t* p = mesh->positions[v];
    p[1] = (int16_t)(p[1] + up);
    const uint8_t bytes[4] = {(uint8_t)((p[1] < 4 ? 1 : 0) | (p[1] / 8 & 15) << 4), (uint8_t)(128 + p[0]), (uint8_t)(128 + p[2]),
                              0};
    memcpy(mesh->surface[v], bytes, sizeof bytes);
  }
}

/* Smoothing groups by octant, and UVs that differ along x and z. */
static void add_uvs(lattice_mesh* mesh) {
  mesh->uvs = checked(malloc(mesh->vertex_count * sizeof *mesh->uvs));
  mesh->uv_bounds = test_uvs;
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    const int16_t* p = mesh->positions[v];
    mesh->surface[v][3] = (uint8_t)((p[0] > 0) | (p[1] > 20) << 1 | (p[2] > 0) << 2);
    mesh->uvs[v][0] = (float)p[0] / 40;
    mesh->uvs[v][1] = 1 + (float)p[2] / 40;
  }
}

/* A cube of cut faces, each with its own four vertices, group and UVs. */
static void make_cube(int half, bool smooth, lattice_mesh* mesh) {
  *mesh = (lattice_mesh){.positions = checked(malloc(24 * sizeof *mesh->positions)),
                         .occlusion = checked(malloc(24)),
                         .indices = checked(malloc(36 * sizeof *mesh->indices)),
                         .surface = checked(malloc(24 * sizeof *mesh->surface)),
                         .uvs = checked(malloc(24 * sizeof *mesh->uvs)),
                         .uv_bounds = test_uvs,
                         .vertex_count = 24,
                         .triangle_count = 12};
  for (uint32_t face = 0; face < 6; ++face) {
    const uint32_t axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3, first = 4 * face;
    for (uint32_t k = 0; k < 4; ++k) {
      const int s = k == 1 || k == 2 ? 1 : -1, t = k >= 2 ? 1 : -1, side = face % 2 != 0 ? 1 : -1;
      mesh->positions[first + k][axis] = (int16_t)(side * half);
      mesh->positions[first + k][u] = (int16_t)(s * side * half);
      mesh->positions[first + k][v] = (int16_t)(t * half);
      mesh->occlusion[first + k] = (uint8_t)(17 * (face + k));
      const uint8_t bytes[4] = {2, 64, 200, (uint8_t)(smooth ? 9 : face + 1)};
      memcpy(mesh->surface[first + k], bytes, sizeof bytes);
      mesh->uvs[first + k][0] = (float)(s * half) / 16;
      mesh->uvs[first + k][1] = 1 + (float)(t * half) / 16;
    }
    const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
    for (uint32_t k = 0; k < 6; ++k) mesh->indices[6 * face + k] = first + corners[k];
  }
}

static void free_mesh(lattice_mesh* mesh) {
  free(mesh->surface);
  free(mesh->uvs);
  synthetic_rock_free(mesh);
}

/* The extreme vertices along the axes and diagonals among those with y in [low, high]: not the convex hull, but as many numbers. */
static void extremes(const lattice_mesh* mesh, int low, int high, int16_t (*out)[3]) {
  static const int directions[AXES][3] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},   {0, -1, 0}, {0, 0, 1},   {0, 0, -1},  {1, 1, 1},
                                          {1, 1, -1}, {1, -1, 1}, {1, -1, -1}, {-1, 1, 1}, {-1, 1, -1}, {-1, -1, 1}, {-1, -1, -1}};
  for (int i = 0; i < AXES; ++i) {
    int best = INT32_MIN;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
      const int16_t* p = mesh->positions[v];
      const int reach = directions[i][0] * p[0] + directions[i][1] * p[1] + directions[i][2] * p[2];
      if (p[1] < low || p[1] > high || reach <= best) continue;
      best = reach;
      memcpy(out[i], p, sizeof out[i]);
    }
  }
}

static void fill_sizes(const lattice_mesh* mesh, float metre, rock_record* rock, model_record* model) {
  for (int axis = 0; axis < 3; ++axis) {
    rock->bounds_min[axis] = INT16_MAX;
    rock->bounds_max[axis] = INT16_MIN;
  }
  float outer = 0, footprint = 0;
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    const int16_t* p = mesh->positions[v];
    for (int axis = 0; axis < 3; ++axis) {
      if (p[axis] < rock->bounds_min[axis]) rock->bounds_min[axis] = p[axis];
      if (p[axis] > rock->bounds_max[axis]) rock->bounds_max[axis] = p[axis];
    }
    const float across = sqrtf((float)(p[0] * p[0] + p[2] * p[2]));
    if (p[1] <= STEPS_BELOW && across > footprint) footprint = across;
  }
  rock->centroid[1] = 0.5f * (float)(rock->bounds_min[1] + rock->bounds_max[1]) / metre;
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    float squared = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const float d = (float)mesh->positions[v][axis] / metre - rock->centroid[axis];
      squared += d * d;
    }
    outer = sqrtf(squared) > outer ? sqrtf(squared) : outer;
  }
  rock->outer_radius = outer * 1.0001f;
  rock->inner_radius = outer * 0.3f;
  rock->volume = outer * outer * outer;
  model->footprint = footprint / metre;
  model->height = (float)rock->bounds_max[1] / metre;
}

static void fill_hulls(const lattice_mesh* mesh, rock_record* rock, model_record* model) {
  rock->hull = checked(malloc(AXES * sizeof *rock->hull));
  rock->hull_count = AXES;
  extremes(mesh, INT16_MIN, INT16_MAX, rock->hull);
  const int middle = (rock->bounds_min[1] + rock->bounds_max[1]) / 2;
  model->parts = checked(malloc(PARTS * AXES * sizeof *model->parts));
  model->part_first = checked(malloc((PARTS + 1) * sizeof *model->part_first));
  model->part_count = PARTS;
  for (uint32_t p = 0; p <= PARTS; ++p) model->part_first[p] = p * AXES;
  extremes(mesh, INT16_MIN, middle, model->parts);
  extremes(mesh, middle, INT16_MAX, model->parts + AXES);
}

static void fill_model(uint32_t variant, uint32_t age, const test_models_desc* desc, rock_record* rock, model_record* model) {
  int up = 0;
  for (uint32_t lod = 0; lod < desc->lod_count; ++lod) {
    lattice_mesh mesh;
    if (desc->cliff && variant > 0) {
      make_cube((int)(6 + variant), variant + 1 == desc->variants, &mesh);
    } else {
      make_mesh(variant + 1, age, lod + 1, &mesh);
      if (lod == 0) up = -lowest_point(&mesh) - STEPS_BELOW;
      stand_up(&mesh, up);
      if (desc->cliff) add_uvs(&mesh);
    }
    if (lod == 0) {
      fill_sizes(&mesh, (float)desc->lattice_per_cell, rock, model);
      fill_hulls(&mesh, rock, model);
    }
    const bool coarsest = lod + 1 == desc->lod_count;
    if ((coarsest ? plain_encode : draco_encode)(&mesh, NULL, &rock->lods[lod]) != SCREE_OK) abort();
    free_mesh(&mesh);
  }
  rock->cell = variant;
  rock->seed = age;
  rock->burial = SCREE_BURIAL_NEVER;
  model->share = 1 - 0.125f * (float)(age < 7 ? age : 7);
  model->steps = 10 * age;
}

/* Blocks strewn about the cliff. */
static cliff_record* make_cliff(const test_models_desc* desc, uint32_t assets) {
  const uint32_t count = TEST_PLACEMENTS * (desc->ages * (desc->ages - 1) / 2) * (assets > desc->ages);
  uint32_t* first = checked(malloc((desc->ages + 1) * sizeof *first));
  scree_block_placement* placements = checked(malloc((count + 1) * sizeof *placements));
  first[0] = 0;
  for (uint32_t t = 0; t < desc->ages; ++t) first[t + 1] = first[t] + (count > 0 ? TEST_PLACEMENTS * t : 0);
  uint64_t random = 5;
  for (uint32_t i = 0; i < count; ++i) {
    random = hash_mix(random + 1);
    placements[i].asset = desc->ages + (uint32_t)(random >> 8) % (assets - desc->ages);
    for (int axis = 0; axis < 3; ++axis) placements[i].translation[axis] = (float)(int)((random >> (16 * axis)) % 4096) / 128 - 16;
  }
  cliff_record* cliff = checked(malloc(sizeof *cliff));
  *cliff = (cliff_record){.time_count = desc->ages, .placement_first = first, .placements = placements, .uvs = test_uvs};
  return cliff;
}

rock_set* test_model_set_make(const test_models_desc* given) {
  const test_models_desc desc = with_defaults(given);
  uint32_t* first = checked(malloc((desc.variants + 1) * sizeof *first));
  first[0] = 0;
  for (uint32_t v = 0; v < desc.variants; ++v)
    first[v + 1] = first[v] + 1 + (desc.cliff && v > 0 ? 0 : (v + desc.ages - 1) % desc.ages);
  const uint32_t count = first[desc.variants];
  rock_record* rocks = checked(calloc(count, sizeof *rocks));
  model_record* models = checked(calloc(count, sizeof *models));
  for (uint32_t v = 0; v < desc.variants; ++v)
    for (uint32_t i = first[v]; i < first[v + 1]; ++i) fill_model(v, i - first[v], &desc, &rocks[i], &models[i]);
  rock_set* set = checked(malloc(sizeof *set));
  *set = (rock_set){
      .lattice_per_cell = desc.lattice_per_cell,
      .lod_count = desc.lod_count,
      .cell_count = desc.variants,
      .rock_count = count,
      .cell_first = first,
      .rocks = rocks,
      .models = models,
      .cliff = desc.cliff ? make_cliff(&desc, count) : NULL,
      .recipe = TEST_RECIPE,
  };
  return set;
}

void test_model_set_free(rock_set* set) {
  const scree_allocator allocator = scree_rt_allocator_or_default(NULL);
  for (uint32_t i = 0; i < set->rock_count; ++i) {
    const rock_record* rock = &set->rocks[i];
    for (uint32_t lod = 0; lod < set->lod_count; ++lod)
      scree_rt_release(&allocator, rock->lods[lod].blob, rock->lods[lod].blob_size, 1);
    free(rock->hull);
    free(set->models[i].parts);
    free(set->models[i].part_first);
  }
  if (set->cliff != NULL) {
    free((void*)set->cliff->placement_first);
    free((void*)set->cliff->placements);
  }
  free((void*)set->cliff);
  free((void*)set->models);
  free((void*)set->rocks);
  free((void*)set->cell_first);
  free(set);
}

uint8_t* test_model_pack_make(const test_models_desc* desc, size_t* size) {
  rock_set* set = test_model_set_make(desc);
  uint8_t* bytes;
  if (pack_write(set, NULL, &bytes, size) != SCREE_OK) abort();
  test_model_set_free(set);
  return bytes; /* the default allocator's memory is freed with free() */
}
