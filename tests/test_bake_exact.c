/* Exact tiles: rocks that are baked once each and set out by the colours of the corners are, voxel by voxel, the Voronoi diagram of
 * all seeds of the endless lattice, and both rocks of a contact know it. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "lattice.h"
#include "tiling.h"

enum { CUBES = 6 }; /* along an axis of the coloured lattice */

typedef struct setting {
  uint32_t n, voxels, seeds_max;
  double alpha, beta, gamma;
  uint32_t field_stride; /* every so many unique cells, the continuous field is held against ownership */
  int32_t contact_cells; /* side of the box of cells whose contacts are compared, 0 = all */
  int32_t plane_stride;  /* every so many planes of voxels are held against the reference; gaps and overlaps are sought in all */
} setting;

static void* need(size_t count, size_t size) {
  void* memory = calloc(count, size);
  assert_non_null(memory);
  return memory;
}

/* The voxels that each unique rock owns, in the box of 2R voxels around its cell: a row of x a word. */
typedef struct ownership {
  uint32_t side;
  uint32_t* rows;
} ownership;

static uint32_t* rows_of(const ownership* own, uint32_t slot) {
  return own->rows + (size_t)slot * own->side * own->side;
}

static void own_from_blocks(bake_run* bake, bake_worker* worker, const uint32_t place[3], uint32_t seed, uint32_t* rows) {
  const uint32_t voxels = bake->seeds.voxels, side = 2 * voxels, plane = bake->tables.plane;
  for (uint32_t b = 0; b < 8; ++b) {
    const uint32_t half[3] = {b & 1, b >> 1 & 1, b >> 2};
    int32_t at[3];
    for (int axis = 0; axis < 3; ++axis) at[axis] = (int32_t)(place[axis] + half[axis]) - 1;
    const block* from = block_cache_get(&worker->rock.blocks, at[0], at[1], at[2]);
    const uint32_t number = from->first[7 - b] + seed;
    for (uint32_t z = 0; z < voxels; ++z)
      for (uint32_t y = 0; y < voxels; ++y) {
        uint32_t row = 0;
        for (uint32_t x = 0; x < voxels; ++x)
          row |= (uint32_t)(from->fields.owner[(size_t)z * plane + y * voxels + x] == number) << x;
        rows[y + half[1] * voxels + side * (z + half[2] * voxels)] |= row << (half[0] * voxels);
      }
  }
}

/* The rock's own grid holds what it owns: never negative there, never positive elsewhere. Returns how many voxels do not agree. */
static uint32_t count_sign_faults(const bake_worker* worker, const uint32_t* rows, uint32_t side, bool any) {
  const rock_grid* grid = &worker->rock.grid;
  uint32_t faults = 0, owned = 0, met = 0;
  for (uint32_t row = 0; row < side * side; ++row) owned += (uint32_t)__builtin_popcount(rows[row]);
  if (!any) return owned;
  for (uint32_t z = 0; z < grid->size[2]; ++z)
    for (uint32_t y = 0; y < grid->size[1]; ++y)
      for (uint32_t x = 0; x < grid->size[0]; ++x) {
        const int64_t v[3] = {(int64_t)grid->min[0] + x, (int64_t)grid->min[1] + y, (int64_t)grid->min[2] + z};
        bool own = false;
        if (v[0] >= 0 && v[1] >= 0 && v[2] >= 0 && v[0] < side && v[1] < side && v[2] < side)
          own = rows[v[1] + side * v[2]] >> v[0] & 1;
        const float field = worker->rock.field[x + (size_t)grid->size[0] * (y + (size_t)grid->size[1] * z)];
        met += own;
        faults += own ? !(field >= 0) : !(field <= 0);
      }
  return faults + (owned - met);
}

typedef struct baked_contacts {
  rock_contact* contacts;
  uint32_t count;
  bool done;
} baked_contacts;

/* Bakes the contacts of a global cell's unique rocks, once. */
static void bake_contacts(bake_run* bake, uint32_t cell, baked_contacts* by_slot) {
  uint32_t code, place[3];
  scree_rt_lattice_cell_place(bake->seeds.n, cell, &code, &place[0], &place[1], &place[2]);
  neighbourhood around;
  neighbourhood_gather(&bake->seeds, code, (int32_t)place[0], (int32_t)place[1], (int32_t)place[2], &around);
  for (uint32_t slot = bake->cell_rocks[cell]; slot < bake->cell_rocks[cell + 1]; ++slot) {
    if (by_slot[slot].done) return;
    rock_contact contacts[MAX_CONTACTS];
    const uint32_t count = contacts_find(&around, slot - bake->cell_rocks[cell], bake->recipe.contact_discard, contacts);
    by_slot[slot] = (baked_contacts){need(count + 1, sizeof *contacts), count, true};
    memcpy(by_slot[slot].contacts, contacts, count * sizeof *contacts);
  }
}

static const baked_contacts* contacts_of(const bake_run* bake, const tiling_box* box, const baked_contacts* by_slot,
                                         const int32_t cell[3], uint32_t seed) {
  return &by_slot[bake->cell_rocks[box->unique[tiling_box_index(box, cell)]] + seed];
}

typedef struct contact_faults {
  uint64_t contacts;
  uint32_t one_sided, unlike_reference, close_calls;
} contact_faults;

static const rock_contact* find_contact(const baked_contacts* list, const int32_t offset[3], uint32_t seed) {
  for (uint32_t c = 0; c < list->count; ++c) {
    const rock_contact* at = &list->contacts[c];
    if (at->cell[0] == offset[0] && at->cell[1] == offset[1] && at->cell[2] == offset[2] && at->seed == seed) return at;
  }
  return NULL;
}

/* The pairs that touch are just those of the reference, at the same point up to rounding. */
static void check_against_reference(const bake_run* bake, const tiling_box* box, const baked_contacts* own, const int32_t cell[3],
                                    uint32_t seed, contact_faults* faults) {
  uint32_t met = 0;
  for (int32_t neighbour = 0; neighbour < 27; ++neighbour) {
    const int32_t offset[3] = {neighbour % 3 - 1, neighbour / 3 % 3 - 1, neighbour / 9 - 1};
    const int32_t other[3] = {cell[0] + offset[0], cell[1] + offset[1], cell[2] + offset[2]};
    const uint32_t index = tiling_box_index(box, other), count = box->first[index + 1] - box->first[index];
    for (uint32_t s = 0; s < count; ++s) {
      if (neighbour == 13 && s == seed) continue;
      double point[3];
      const reference_verdict verdict = reference_contact(box, cell, seed, other, s, point);
      const rock_contact* found = find_contact(own, offset, s);
      met += found != NULL;
      if (verdict == REFERENCE_CLOSE_CALL)
        ++faults->close_calls;
      else if ((found != NULL) != (verdict == REFERENCE_CONTACT))
        ++faults->unlike_reference;
      for (int axis = 0; axis < 3 && found != NULL; ++axis)
        if (fabs((double)found->position[axis] + (double)cell[axis] * bake->seeds.unit - point[axis]) > 2) {
          ++faults->unlike_reference;
          break;
        }
    }
  }
  faults->unlike_reference += met != own->count;
}

/* Every contact of a rock is the neighbour's too, once, at the very same point. */
static void check_contacts(const bake_run* bake, const tiling_box* box, const baked_contacts* by_slot, const int32_t cell[3],
                           uint32_t seed, bool discards, contact_faults* faults) {
  const int32_t unit = bake->seeds.unit;
  const baked_contacts* own = contacts_of(bake, box, by_slot, cell, seed);
  if (!discards) check_against_reference(bake, box, own, cell, seed, faults);
  faults->contacts += own->count;
  for (uint32_t c = 0; c < own->count; ++c) {
    const rock_contact* contact = &own->contacts[c];
    const int32_t other[3] = {cell[0] + contact->cell[0], cell[1] + contact->cell[1], cell[2] + contact->cell[2]};
    const baked_contacts* theirs = contacts_of(bake, box, by_slot, other, contact->seed);
    uint32_t found = 0;
    for (uint32_t t = 0; t < theirs->count; ++t) {
      const rock_contact* back = &theirs->contacts[t];
      bool same = back->seed == seed;
      for (int axis = 0; axis < 3; ++axis)
        same = same && back->cell[axis] == -contact->cell[axis] &&
               back->position[axis] == contact->position[axis] - contact->cell[axis] * unit;
      found += same;
    }
    faults->one_sided += found != 1;
  }
}

static contact_faults compare_contacts(bake_run* bake, const tiling_box* box, int32_t cells, bool discards) {
  contact_faults faults = {0, 0, 0, 0};
  baked_contacts* by_slot = need(bake->slot_count, sizeof *by_slot);
  int32_t low[3], high[3], cell[3];
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = box->min[axis] + 3; /* the reference looks two cells around either rock */
    high[axis] = cells > 0 ? low[axis] + cells : box->min[axis] + box->size[axis] - 3;
  }
  for (cell[2] = low[2] - 1; cell[2] <= high[2]; ++cell[2])
    for (cell[1] = low[1] - 1; cell[1] <= high[1]; ++cell[1])
      for (cell[0] = low[0] - 1; cell[0] <= high[0]; ++cell[0])
        bake_contacts(bake, box->unique[tiling_box_index(box, cell)], by_slot);
  for (cell[2] = low[2]; cell[2] < high[2]; ++cell[2])
    for (cell[1] = low[1]; cell[1] < high[1]; ++cell[1])
      for (cell[0] = low[0]; cell[0] < high[0]; ++cell[0]) {
        const uint32_t index = tiling_box_index(box, cell);
        for (uint32_t s = 0; s < box->first[index + 1] - box->first[index]; ++s)
          check_contacts(bake, box, by_slot, cell, s, discards, &faults);
      }
  for (uint32_t slot = 0; slot < bake->slot_count; ++slot) free(by_slot[slot].contacts);
  free(by_slot);
  return faults;
}

static scree_recipe recipe_of(const setting* given) {
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  recipe.n = given->n;
  recipe.voxels_per_cell = given->voxels;
  recipe.seeds_max = given->seeds_max;
  recipe.alpha = (scree_range){given->alpha, given->alpha};
  recipe.beta = (scree_range){given->beta, given->beta};
  recipe.gamma = (scree_range){given->gamma, given->gamma};
  recipe.g = (scree_range){1, 4};
  recipe.jitter = 1;
  return recipe;
}

static void compare(const setting* given) {
  const scree_recipe recipe = recipe_of(given);
  const scree_bake_desc desc = {.recipe = &recipe};
  bake_run bake;
  assert_int_equal(bake_begin(&desc, false, &bake), SCREE_OK);
  bake_worker* worker = &bake.workers[0];
  const int32_t voxels = (int32_t)recipe.voxels_per_cell, cells = CUBES * (int32_t)bake.seeds.n, side = cells * voxels;

  /* Every unique rock once, in the tile that it is baked in. */
  ownership own = {.side = 2 * recipe.voxels_per_cell};
  own.rows = need((size_t)bake.slot_count * own.side * own.side, sizeof *own.rows);
  uint32_t sign_faults = 0;
  for (uint32_t i = 0; i < bake.cell_count; ++i) {
    const uint32_t cell = bake.cells[i];
    uint32_t code, place[3];
    scree_rt_lattice_cell_place(bake.seeds.n, cell, &code, &place[0], &place[1], &place[2]);
    if (i == 0 || worker->rock.blocks.code != code) block_cache_begin(&worker->rock.blocks, code);
    for (uint32_t slot = bake.cell_rocks[cell]; slot < bake.cell_rocks[cell + 1]; ++slot) {
      const uint32_t seed = slot - bake.cell_rocks[cell];
      own_from_blocks(&bake, worker, place, seed, rows_of(&own, slot));
      if (i % given->field_stride != 0) continue;
      const bool any = rock_voronoi(&worker->rock, (int32_t)place[0], (int32_t)place[1], (int32_t)place[2], seed);
      sign_faults += count_sign_faults(worker, rows_of(&own, slot), own.side, any);
    }
  }

  /* The tiled rocks, over the voxels between the centres of cells 0 and 6 N of every axis. */
  tiling lattice;
  tiling_create(UINT64_C(0xc0105) + given->n * 100 + given->seeds_max, &bake.seeds, &lattice);
  const int32_t low[3] = {-3, -3, -3}, size[3] = {cells + 7, cells + 7, cells + 7};
  tiling_box box;
  tiling_box_create(&lattice, low, size, &box);
  const size_t total = (size_t)side * (size_t)side * (size_t)side;
  uint32_t* owner = need(total, sizeof *owner);
  uint8_t* owners = need(total, 1);
  int32_t cell[3];
  for (cell[2] = 0; cell[2] <= cells; ++cell[2])
    for (cell[1] = 0; cell[1] <= cells; ++cell[1])
      for (cell[0] = 0; cell[0] <= cells; ++cell[0]) {
        const uint32_t index = tiling_box_index(&box, cell), first = bake.cell_rocks[box.unique[index]];
        for (uint32_t rock = box.first[index]; rock < box.first[index + 1]; ++rock) {
          const uint32_t* rows = rows_of(&own, first + rock - box.first[index]);
          for (int32_t row = 0; row < 4 * voxels * voxels; ++row)
            for (uint32_t bits = rows[row]; bits != 0; bits &= bits - 1) {
              const int32_t v[3] = {(cell[0] - 1) * voxels + __builtin_ctz(bits), (cell[1] - 1) * voxels + row % (2 * voxels),
                                    (cell[2] - 1) * voxels + row / (2 * voxels)};
              if (v[0] < 0 || v[1] < 0 || v[2] < 0 || v[0] >= side || v[1] >= side || v[2] >= side) continue;
              const size_t at = (size_t)v[0] + (size_t)side * ((size_t)v[1] + (size_t)side * (size_t)v[2]);
              owner[at] = rock;
              if (owners[at] < 255) ++owners[at];
            }
        }
      }

  uint64_t gaps = 0, overlaps = 0, differing = 0, compared = 0;
  int32_t v[3];
  size_t at = 0;
  for (v[2] = 0; v[2] < side; ++v[2])
    for (v[1] = 0; v[1] < side; ++v[1])
      for (v[0] = 0; v[0] < side; ++v[0], ++at) {
        gaps += owners[at] == 0;
        overlaps += owners[at] > 1;
        if (v[2] % given->plane_stride != 0) continue;
        differing += owner[at] != reference_owner(&box, v);
        ++compared;
      }
  const contact_faults contacts = compare_contacts(&bake, &box, given->contact_cells, false);
  print_message(
      "n %u, %2u seeds, %g:%g:%g: %6u rocks, %zu voxels: %llu gaps, %llu overlaps; %llu of %llu differ; %u signs off; %llu "
      "contacts: "
      "%u one-sided, %u unlike the reference (%u close calls)\n",
      given->n, given->seeds_max, given->alpha, given->beta, given->gamma, bake.slot_count, total, (unsigned long long)gaps,
      (unsigned long long)overlaps, (unsigned long long)differing, (unsigned long long)compared, sign_faults,
      (unsigned long long)contacts.contacts, contacts.one_sided, contacts.unlike_reference, contacts.close_calls);
  free(owner);
  free(owners);
  free(own.rows);
  tiling_box_destroy(&box);
  tiling_destroy(&lattice);
  bake_end(&bake);
  assert_int_equal(gaps, 0);
  assert_int_equal(overlaps, 0);
  assert_int_equal(differing, 0);
  assert_int_equal(sign_faults, 0);
  assert_int_equal(contacts.one_sided, 0);
  assert_int_equal(contacts.unlike_reference, 0);
  assert_true(contacts.contacts > 1000 && contacts.close_calls < contacts.contacts / 20);
}

/* Cells of 1 seed and of 1 to 20, round rocks, flat ones (1:1:5) and long ones (5:5:1). */
static void compare_shapes(setting given) {
  static const double shapes[3][3] = {{1, 1, 1}, {1, 1, 5}, {5, 5, 1}};
  for (int shape = 0; shape < 3; ++shape) {
    given.alpha = shapes[shape][0], given.beta = shapes[shape][1], given.gamma = shapes[shape][2];
    compare(&given);
  }
}

static void tiled_rocks_of_one_seed_are_the_global_diagram(void** state) {
  (void)state;
  compare_shapes((setting){.n = 4, .voxels = 6, .seeds_max = 1, .field_stride = 1, .plane_stride = 1});
  compare_shapes((setting){.n = 5, .voxels = 6, .seeds_max = 1, .field_stride = 1, .plane_stride = 1});
  compare_shapes((setting){.n = 6, .voxels = 6, .seeds_max = 1, .field_stride = 1, .contact_cells = 16, .plane_stride = 1});
}

static void tiled_rocks_of_up_to_twenty_seeds_are_the_global_diagram(void** state) {
  (void)state;
  compare_shapes((setting){.n = 4, .voxels = 6, .seeds_max = 20, .field_stride = 16, .contact_cells = 3, .plane_stride = 1});
  compare_shapes((setting){.n = 5, .voxels = 6, .seeds_max = 20, .field_stride = 64, .contact_cells = 3, .plane_stride = 2});
  compare_shapes((setting){.n = 6, .voxels = 6, .seeds_max = 20, .field_stride = 128, .contact_cells = 3, .plane_stride = 5});
}

static void finer_voxels_make_no_difference_to_exactness(void** state) {
  (void)state;
  const setting given = {
      .n = 4, .voxels = 10, .seeds_max = 1, .alpha = 1, .beta = 1, .gamma = 1, .field_stride = 1, .plane_stride = 1};
  compare(&given);
}

static void discarded_contacts_are_gone_on_both_sides(void** state) {
  (void)state;
  const setting given = {.n = 4, .voxels = 6, .seeds_max = 1, .alpha = 1, .beta = 1, .gamma = 1};
  uint64_t left[3];
  static const double shares[3] = {0, 0.25, 1};
  for (int i = 0; i < 3; ++i) {
    scree_recipe recipe = recipe_of(&given);
    recipe.contact_discard = shares[i];
    const scree_bake_desc desc = {.recipe = &recipe};
    bake_run bake;
    assert_int_equal(bake_begin(&desc, false, &bake), SCREE_OK);
    tiling lattice;
    tiling_create(77, &bake.seeds, &lattice);
    const int32_t low[3] = {-3, -3, -3}, size[3] = {24, 24, 24};
    tiling_box box;
    tiling_box_create(&lattice, low, size, &box);
    const contact_faults faults = compare_contacts(&bake, &box, 0, true);
    assert_int_equal(faults.one_sided, 0);
    left[i] = faults.contacts;
    tiling_box_destroy(&box);
    tiling_destroy(&lattice);
    bake_end(&bake);
  }
  const double share = 1 - (double)left[1] / (double)left[0];
  print_message("a quarter discarded: %.3f of %llu contacts\n", share, (unsigned long long)left[0]);
  assert_true(share > 0.2 && share < 0.3);
  assert_int_equal(left[2], 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(tiled_rocks_of_one_seed_are_the_global_diagram),
      cmocka_unit_test(tiled_rocks_of_up_to_twenty_seeds_are_the_global_diagram),
      cmocka_unit_test(finer_voxels_make_no_difference_to_exactness),
      cmocka_unit_test(discarded_contacts_are_gone_on_both_sides),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
