/* Based on: Peytavie et al. 2009, section 3 (zones) and section 4 (anisotropic distance). Where we differ: zones of radius 1 per
 * axis, and a seed is a pure function of its zone, its place in it and the colours, so nothing has to be copied between zones. */
#include "seeds.h"

#include <string.h>

#include "random.h"
#include "vectors.h"

/* Place class of a cell along one axis: 0..2 = pinned to a corner plane with offset -1, 0, 1; 3.. = free. */
static uint32_t place_class(uint32_t n, int32_t m, int32_t* plane) {
  if (m <= 1) {
    *plane = 0;
    return (uint32_t)(m + 1);
  }
  if (m >= (int32_t)n - 1) {
    *plane = 1;
    return (uint32_t)(m - (int32_t)n + 1);
  }
  *plane = -1;
  return (uint32_t)m + 1;
}

static size_t seed_slot(const seed_set* set, uint32_t code, int32_t x, int32_t y, int32_t z) {
  const uint32_t n = set->n;
  const int32_t place[3] = {x, y, z};
  uint32_t class[3], pinned = 0, value = 0;
  for (uint32_t axis = 0; axis < 3; ++axis) {
    int32_t plane;
    class[axis] = place_class(n, place[axis], &plane);
    if (plane >= 0) {
      pinned |= 1u << axis;
      value |= (uint32_t)plane << axis;
    }
  }
  uint32_t colours = 0, count = 0;
  for (uint32_t corner = 0; corner < 8; ++corner)
    if ((corner & pinned) == value) colours |= (code >> corner & 1) << count++;
  return (size_t)(class[0] + n * (class[1] + n * class[2])) * 256 + colours;
}

static uint32_t slot_variants(uint32_t n, size_t slot) {
  uint32_t class = (uint32_t)(slot / 256), free_axes = 0;
  for (uint32_t axis = 0; axis < 3; ++axis) {
    free_axes += class % n >= 3;
    class /= n;
  }
  return UINT32_C(1) << (UINT32_C(1) << free_axes);
}

/* A unit vector orthogonal to `axis`, uniform around it. */
static void random_orthogonal(random_stream* stream, const double axis[3], double out[3]) {
  for (;;) {
    double direction[3];
    random_direction(stream, direction);
    cross(axis, direction, out);
    double length2 = out[0] * out[0] + out[1] * out[1] + out[2] * out[2];
    if (length2 < 1e-4) continue;
    for (int i = 0; i < 3; ++i) out[i] /= sqrt(length2);
    return;
  }
}

/* The frame's axes, frame[2] being z. */
static void random_frame(random_stream* stream, const scree_recipe* recipe, double frame[3][3]) {
  if (recipe->orientation == SCREE_ORIENTATION_ALIGNED) {
    double axis[3], side[3], length2 = 0;
    for (int i = 0; i < 3; ++i) length2 += recipe->align_axis[i] * recipe->align_axis[i];
    for (int i = 0; i < 3; ++i) axis[i] = recipe->align_axis[i] / sqrt(length2);
    random_orthogonal(stream, axis, side);
    double least = repeatable_cos(recipe->align_angle);
    double cosine = least + (1 - least) * random_unit(stream);
    double sine = sqrt(cosine >= 1 ? 0 : 1 - cosine * cosine);
    for (int i = 0; i < 3; ++i) frame[2][i] = axis[i] * cosine + side[i] * sine;
  } else {
    random_direction(stream, frame[2]);
  }
  random_orthogonal(stream, frame[2], frame[0]);
  cross(frame[2], frame[0], frame[1]);
}

/* Steps of the additive low-discrepancy sequence in three dimensions: powers of 1 / 1.2207440846, the root of x^4 = x + 1.
 * (Roberts, The Unreasonable Effectiveness of Quasirandom Sequences, 2018.) */
static const double sequence_step[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};

static void make_seeds(const seed_set* set, const scree_recipe* recipe, uint64_t key, rock_seed* seeds, uint32_t count) {
  random_stream stream = {key};
  double shift[3];
  for (int axis = 0; axis < 3; ++axis) shift[axis] = random_unit(&stream);
  for (uint32_t s = 0; s < count; ++s) {
    rock_seed* seed = &seeds[s];
    memset(seed, 0, sizeof *seed);
    seed->key = hash_combine(key, s + 1);
    for (int axis = 0; axis < 3; ++axis) {
      double u = shift[axis] + s * sequence_step[axis];
      u -= floor(u);
      seed->position[axis] = (int32_t)floor((u - 0.5) * recipe->jitter * set->unit + 0.5);
    }
    double frame[3][3];
    random_frame(&stream, recipe, frame);
    double g = random_in(&stream, recipe->g);
    const double scale[3] = {random_in(&stream, recipe->alpha) / g, random_in(&stream, recipe->beta) / g,
                             random_in(&stream, recipe->gamma) / g};
    double m[3][3] = {{0}};
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) m[i][j] += scale[k] * frame[k][i] * frame[k][j];
    seed->metric[0] = (float)m[0][0];
    seed->metric[1] = (float)m[1][1];
    seed->metric[2] = (float)m[2][2];
    seed->metric[3] = (float)(2 * m[0][1]);
    seed->metric[4] = (float)(2 * m[0][2]);
    seed->metric[5] = (float)(2 * m[1][2]);
  }
}

scree_result seed_set_create(const scree_recipe* recipe, const scree_allocator* allocator, seed_set* out) {
  memset(out, 0, sizeof *out);
  out->n = recipe->n - 1;
  out->voxels = recipe->voxels_per_cell;
  out->unit = (int32_t)(UNITS_PER_VOXEL * recipe->voxels_per_cell);
  const size_t slots = (size_t)out->n * out->n * out->n * 256;
  out->first_count = slots + 1;
  out->first = scree_rt_allocate_zeroed(allocator, out->first_count, sizeof *out->first);
  if (out->first == NULL) return SCREE_ERROR_OUT_OF_MEMORY;

  const uint64_t world = hash_combine(recipe->random_seed, UINT64_C(0x5eed));
  for (size_t slot = 0; slot < slots; ++slot) {
    uint32_t count = 0;
    if (slot % 256 < slot_variants(out->n, slot)) {
      random_stream stream = {hash_combine(world, slot * 2 + 1)};
      count = recipe->seeds_min + (uint32_t)(random_unit(&stream) * (recipe->seeds_max - recipe->seeds_min + 1));
    }
    out->first[slot + 1] = out->first[slot] + count;
  }
  out->seed_count = out->first[slots];
  out->seeds = scree_rt_allocate(allocator, out->seed_count, sizeof *out->seeds);
  if (out->seeds == NULL) {
    seed_set_destroy(out, allocator);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  for (size_t slot = 0; slot < slots; ++slot)
    make_seeds(out, recipe, hash_combine(world, slot * 2), out->seeds + out->first[slot], out->first[slot + 1] - out->first[slot]);
  return SCREE_OK;
}

void seed_set_destroy(seed_set* set, const scree_allocator* allocator) {
  scree_rt_release(allocator, set->seeds, set->seed_count, sizeof *set->seeds);
  scree_rt_release(allocator, set->first, set->first_count, sizeof *set->first);
  memset(set, 0, sizeof *set);
}

const rock_seed* seeds_of_cell(const seed_set* set, uint32_t code, int32_t x, int32_t y, int32_t z, uint32_t* count) {
  size_t slot = seed_slot(set, code, x, y, z);
  *count = set->first[slot + 1] - set->first[slot];
  return set->seeds + set->first[slot];
}
