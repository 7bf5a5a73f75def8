/* Eroded rocks: no two of them overlap anywhere, erosion never adds, contacts are kept, no rock hangs in the air. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "lattice.h"
#include "tiling.h"

static void* need(size_t count, size_t size) {
  void* memory = calloc(count, size);
  assert_non_null(memory);
  return memory;
}

/* One unique rock after erosion. */
typedef struct stone {
  rock_grid grid;
  float* field; /* NULL when nothing was left */
  rock_contact* contacts;
  uint32_t contact_count;
} stone;

typedef struct stones {
  bake_run bake;
  stone* by_slot;
} stones;

static void stones_create(const scree_recipe* recipe, stones* out) {
  const scree_bake_desc desc = {.recipe = recipe};
  assert_int_equal(bake_begin(&desc, false, &out->bake), SCREE_OK);
  const bake_run* bake = &out->bake;
  out->by_slot = need(bake->slot_count, sizeof *out->by_slot);
  const rock_worker* worker = &bake->workers[0].rock;
  for (uint32_t i = 0; i < bake->cell_count; ++i) {
    const uint32_t cell = bake->cells[i];
    for (uint32_t slot = bake->cell_rocks[cell]; slot < bake->cell_rocks[cell + 1]; ++slot) {
      if (!bake_rock_field(&out->bake, &out->bake.workers[0], cell, slot - bake->cell_rocks[cell])) continue;
      stone* to = &out->by_slot[slot];
      to->grid = worker->grid;
      const size_t voxels = (size_t)to->grid.size[0] * to->grid.size[1] * to->grid.size[2];
      to->field = need(voxels, sizeof *to->field);
      memcpy(to->field, worker->field, voxels * sizeof *to->field);
      to->contact_count = worker->contact_count;
      to->contacts = need(to->contact_count + 1, sizeof *to->contacts);
      memcpy(to->contacts, worker->contacts, to->contact_count * sizeof *to->contacts);
    }
  }
}

static void stones_destroy(stones* set) {
  for (uint32_t slot = 0; slot < set->bake.slot_count; ++slot) {
    free(set->by_slot[slot].field);
    free(set->by_slot[slot].contacts);
  }
  free(set->by_slot);
  bake_end(&set->bake);
}

static const stone* stone_at(const stones* set, const tiling_box* box, const int32_t cell[3], uint32_t seed) {
  return &set->by_slot[set->bake.cell_rocks[box->unique[tiling_box_index(box, cell)]] + seed];
}

/* Trilinear field at a point in units from the centre of the rock's cell; -1 outside the grid. */
static float field_at(const stone* rock, int32_t voxels, const int32_t point[3]) {
  int32_t at[3];
  float t[3];
  for (int axis = 0; axis < 3; ++axis) {
    const int32_t from_first = point[axis] - 256 * (2 * (rock->grid.min[axis] - voxels) + 1);
    if (from_first < 0) return -1;
    at[axis] = from_first / 512;
    if (at[axis] + 1 >= (int32_t)rock->grid.size[axis]) return -1;
    t[axis] = (float)(from_first % 512) / 512;
  }
  float sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
    const float weight = (dx ? t[0] : 1 - t[0]) * (dy ? t[1] : 1 - t[1]) * (dz ? t[2] : 1 - t[2]);
    sum += weight * rock->field[at[0] + dx + (size_t)rock->grid.size[0] * (at[1] + dy + (size_t)rock->grid.size[1] * (at[2] + dz))];
  }
  return sum;
}

typedef struct pile_facts {
  uint64_t voxels, filled, overlaps; /* overlaps: voxels where two fields sum above 0 */
  uint64_t pairs, close_pairs;       /* contacts, and those where both surfaces lie within 0.3 voxel of the point */
  uint64_t rocks, lonely, contacts;  /* rocks of whole neighbourhoods, those without a contact, contacts */
} pile_facts;

/* Sets the rocks out over a coloured lattice of cubes and looks at every voxel. */
static pile_facts look_at_pile(const stones* set, int32_t cubes) {
  const int32_t voxels = (int32_t)set->bake.seeds.voxels, cells = cubes * (int32_t)set->bake.seeds.n, side = cells * voxels;
  tiling lattice;
  tiling_create(UINT64_C(0xf1e1d), &set->bake.seeds, &lattice);
  const int32_t low[3] = {-1, -1, -1}, size[3] = {cells + 3, cells + 3, cells + 3};
  tiling_box box;
  tiling_box_create(&lattice, low, size, &box);
  const size_t total = (size_t)side * (size_t)side * (size_t)side;
  float *best = need(total, sizeof *best), *second = need(total, sizeof *second);
  for (size_t i = 0; i < total; ++i) best[i] = second[i] = -1;

  pile_facts facts = {.voxels = total};
  int32_t cell[3];
  for (cell[2] = 0; cell[2] <= cells; ++cell[2])
    for (cell[1] = 0; cell[1] <= cells; ++cell[1])
      for (cell[0] = 0; cell[0] <= cells; ++cell[0]) {
        const uint32_t index = tiling_box_index(&box, cell);
        for (uint32_t seed = 0; seed < box.first[index + 1] - box.first[index]; ++seed) {
          const stone* rock = stone_at(set, &box, cell, seed);
          ++facts.rocks;
          facts.contacts += rock->contact_count;
          facts.lonely += rock->contact_count == 0;
          for (uint32_t c = 0; c < rock->contact_count; ++c) {
            const rock_contact* contact = &rock->contacts[c];
            int32_t other[3], there[3];
            for (int axis = 0; axis < 3; ++axis) {
              other[axis] = cell[axis] + contact->cell[axis];
              there[axis] = contact->position[axis] - contact->cell[axis] * set->bake.seeds.unit;
            }
            const stone* neighbour = stone_at(set, &box, other, contact->seed);
            const float limit = 0.3f / (float)voxels;
            ++facts.pairs;
            if (neighbour->field != NULL)
              facts.close_pairs +=
                  fabsf(field_at(rock, voxels, contact->position)) <= limit && fabsf(field_at(neighbour, voxels, there)) <= limit;
          }
          if (rock->field == NULL) continue;
          const rock_grid* grid = &rock->grid;
          const float* field = rock->field;
          for (uint32_t z = 0; z < grid->size[2]; ++z)
            for (uint32_t y = 0; y < grid->size[1]; ++y)
              for (uint32_t x = 0; x < grid->size[0]; ++x, ++field) {
                const int32_t v[3] = {(cell[0] - 1) * voxels + grid->min[0] + (int32_t)x,
                                      (cell[1] - 1) * voxels + grid->min[1] + (int32_t)y,
                                      (cell[2] - 1) * voxels + grid->min[2] + (int32_t)z};
                if (v[0] < 0 || v[1] < 0 || v[2] < 0 || v[0] >= side || v[1] >= side || v[2] >= side) continue;
                const size_t at = (size_t)v[0] + (size_t)side * ((size_t)v[1] + (size_t)side * (size_t)v[2]);
                if (*field > best[at]) {
                  second[at] = best[at];
                  best[at] = *field;
                } else if (*field > second[at]) {
                  second[at] = *field;
                }
              }
        }
      }
  for (size_t i = 0; i < total; ++i) {
    facts.filled += best[i] > 0;
    facts.overlaps += !(best[i] + second[i] <= 0) || isnan(second[i]);
  }
  free(best);
  free(second);
  tiling_box_destroy(&box);
  tiling_destroy(&lattice);
  return facts;
}

static void print_facts(const char* name, const pile_facts* facts) {
  print_message(
      "%-14s %llu voxels: %llu where two fields sum above 0; filled %.3f; %llu rocks, %.2f contacts each, %llu without; "
      "%.1f %% of contacts within 0.3 voxel of both surfaces\n",
      name, (unsigned long long)facts->voxels, (unsigned long long)facts->overlaps, (double)facts->filled / (double)facts->voxels,
      (unsigned long long)facts->rocks, (double)facts->contacts / (double)facts->rocks, (unsigned long long)facts->lonely,
      100.0 * (double)facts->close_pairs / (double)facts->pairs);
}

static void boulders_touch_their_neighbours_and_never_overlap_them(void** state) {
  (void)state;
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  recipe.n = 5;
  stones set;
  stones_create(&recipe, &set);
  const pile_facts facts = look_at_pile(&set, 5);
  print_facts("boulders", &facts);
  stones_destroy(&set);
  assert_int_equal(facts.overlaps, 0);
  assert_true((double)facts.close_pairs >= 0.9 * (double)facts.pairs);
  /* Real rock that was poured fills 0.55 to 0.65 of its room. */
  assert_true((double)facts.filled > 0.5 * (double)facts.voxels && (double)facts.filled < 0.8 * (double)facts.voxels);
}

/* Without a single step of erosion fields sum to exactly 0 on the border: the sharpest case there is. */
static void bare_voronoi_cells_share_borders_and_never_overlap(void** state) {
  (void)state;
  static const double shapes[3][3] = {{1, 1, 1}, {1, 1, 5}, {5, 5, 1}};
  for (int shape = 0; shape < 3; ++shape) {
    scree_recipe recipe;
    scree_recipe_default(&recipe);
    recipe.n = 4;
    recipe.voxels_per_cell = 8;
    recipe.alpha = (scree_range){shapes[shape][0], shapes[shape][0]};
    recipe.beta = (scree_range){shapes[shape][1], shapes[shape][1]};
    recipe.gamma = (scree_range){shapes[shape][2], shapes[shape][2]};
    recipe.jitter = 1;
    recipe.erosion = recipe.noise = 0;
    recipe.erosion_steps = recipe.chisel_planes = 0;
    stones set;
    stones_create(&recipe, &set);
    const pile_facts facts = look_at_pile(&set, 6);
    print_facts("bare", &facts);
    stones_destroy(&set);
    assert_int_equal(facts.overlaps, 0);
    assert_true((double)facts.filled > 0.97 * (double)facts.voxels);
  }
}

static void many_seeds_a_cell_never_overlap(void** state) {
  (void)state;
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  recipe.n = 4;
  recipe.voxels_per_cell = 10;
  recipe.seeds_max = 6;
  recipe.contact_radius = 0.04;
  recipe.contact_blend = 0.25;
  recipe.erosion = 0.035;
  recipe.noise = 0.045;
  stones set;
  stones_create(&recipe, &set);
  const pile_facts facts = look_at_pile(&set, 4);
  print_facts("1 to 6 seeds", &facts);
  stones_destroy(&set);
  assert_int_equal(facts.overlaps, 0);
}

static void deep_rocks_have_nine_contacts_or_more_and_none_hangs_in_the_air(void** state) {
  (void)state;
  for (uint32_t n = 4; n <= 6; ++n) {
    scree_recipe recipe;
    scree_recipe_default(&recipe);
    recipe.n = n;
    recipe.voxels_per_cell = 6;
    recipe.noise = 0;
    recipe.erosion_steps = recipe.chisel_planes = 0;
    stones set;
    stones_create(&recipe, &set);
    uint64_t contacts = 0;
    uint32_t lonely = 0;
    for (uint32_t slot = 0; slot < set.bake.slot_count; ++slot) {
      contacts += set.by_slot[slot].contact_count;
      lonely += set.by_slot[slot].contact_count == 0;
    }
    const double mean = (double)contacts / set.bake.slot_count;
    const pile_facts facts = look_at_pile(&set, 6);
    print_facts("deep rocks", &facts);
    print_message("n %u: %.2f contacts a unique rock, %u of %u without\n", n, mean, lonely, set.bake.slot_count);
    stones_destroy(&set);
    assert_int_equal(lonely, 0);
    assert_true(mean >= 9);
    assert_int_equal(facts.lonely, 0);
    assert_true((double)facts.contacts >= 9.0 * (double)facts.rocks);
  }
}

static void erosion_only_subtracts(void** state) {
  (void)state;
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  recipe.n = 4;
  recipe.seeds_max = 2;
  const scree_bake_desc desc = {.recipe = &recipe};
  bake_run bake;
  assert_int_equal(bake_begin(&desc, false, &bake), SCREE_OK);
  rock_worker* worker = &bake.workers[0].rock;
  float* before = need(worker->capacity, sizeof *before);
  uint64_t added = 0, voxels = 0, taken = 0, wrong_count = 0, wrong_rows = 0;
  for (uint32_t i = 0; i < bake.cell_count; ++i) {
    uint32_t code, x, y, z;
    scree_rt_lattice_cell_place(bake.seeds.n, bake.cells[i], &code, &x, &y, &z);
    if (i == 0 || worker->blocks.code != code) block_cache_begin(&worker->blocks, code);
    const uint32_t seeds = bake.cell_rocks[bake.cells[i] + 1] - bake.cell_rocks[bake.cells[i]];
    for (uint32_t seed = 0; seed < seeds; ++seed) {
      if (!rock_voronoi(worker, (int32_t)x, (int32_t)y, (int32_t)z, seed)) continue;
      const rock_grid grid = worker->grid;
      const size_t count = (size_t)grid.size[0] * grid.size[1] * grid.size[2];
      memcpy(before, worker->field, count * sizeof *before);
      const uint32_t left = rock_erode(worker, hash_mix(i * 64 + seed));
      uint32_t inside = 0;
      for (size_t v = 0; v < count; ++v) {
        const bool within = worker->field[v] > 0;
        added += !(worker->field[v] <= before[v]);
        taken += worker->field[v] < before[v];
        inside += within;
        wrong_rows += within != (worker->rows[v / grid.size[0]] >> v % grid.size[0] & 1);
      }
      wrong_count += left != inside;
      voxels += count;
    }
  }
  free(before);
  bake_end(&bake);
  print_message("%llu voxels: %llu higher than before, %llu lower\n", (unsigned long long)voxels, (unsigned long long)added,
                (unsigned long long)taken);
  assert_int_equal(added, 0);
  assert_true(taken > voxels / 10);
  assert_int_equal(wrong_count, 0);
  assert_int_equal(wrong_rows, 0);
}

/* What is left of a rock is one piece, and the outermost voxels of its grid are empty, so that its surface closes. */
static void an_eroded_rock_is_one_piece_inside_its_grid(void** state) {
  (void)state;
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  recipe.n = 4;
  recipe.voxels_per_cell = 8;
  recipe.seeds_max = 3;
  recipe.gamma = (scree_range){4, 6};
  recipe.noise = 0.3; /* carves rocks to pieces */
  stones set;
  stones_create(&recipe, &set);
  uint32_t pieces = 0, touching = 0, stone_count = 0;
  for (uint32_t slot = 0; slot < set.bake.slot_count; ++slot) {
    const stone* rock = &set.by_slot[slot];
    if (rock->field == NULL) continue;
    ++stone_count;
    const uint32_t* size = rock->grid.size;
    const uint32_t count = size[0] * size[1] * size[2], strides[3] = {1, size[0], size[0] * size[1]};
    uint8_t* seen = need(count, 1);
    uint32_t* stack = need(count, sizeof *stack);
    for (uint32_t v = 0; v < count; ++v) {
      if (!(rock->field[v] > 0)) continue;
      const uint32_t at[3] = {v % size[0], v / size[0] % size[1], v / strides[2]};
      for (int axis = 0; axis < 3; ++axis) touching += at[axis] == 0 || at[axis] + 1 == size[axis];
      if (seen[v]) continue;
      ++pieces;
      uint32_t height = 0;
      stack[height++] = v;
      seen[v] = 1;
      while (height > 0) {
        const uint32_t top = stack[--height];
        for (int axis = 0; axis < 3; ++axis)
          for (int side = 0; side < 2; ++side) {
            const uint32_t next = side == 0 ? top - strides[axis] : top + strides[axis];
            if (next >= count || seen[next] || !(rock->field[next] > 0)) continue;
            seen[next] = 1;
            stack[height++] = next;
          }
      }
    }
    free(seen);
    free(stack);
  }
  stones_destroy(&set);
  print_message("%u rocks, %u pieces, %u voxels at the border of a grid\n", stone_count, pieces, touching);
  assert_true(stone_count > 2000);
  assert_int_equal(pieces, stone_count);
  assert_int_equal(touching, 0);
}

/* Distance from an owned voxel to the nearest one that the rock does not own, in voxels, up to `most`. */
static double true_depth(const rock_worker* worker, const uint32_t at[3], int32_t most) {
  const uint32_t* size = worker->grid.size;
  int32_t least = most * most;
  for (int32_t z = -most; z <= most; ++z)
    for (int32_t y = -most; y <= most; ++y)
      for (int32_t x = -most; x <= most; ++x) {
        const int32_t d2 = x * x + y * y + z * z, v[3] = {(int32_t)at[0] + x, (int32_t)at[1] + y, (int32_t)at[2] + z};
        if (d2 >= least) continue;
        bool own = true;
        for (int axis = 0; axis < 3; ++axis) own = own && v[axis] >= 0 && v[axis] < (int32_t)size[axis];
        if (own) own = worker->field[(uint32_t)v[0] + (size_t)size[0] * ((uint32_t)v[1] + (size_t)size[1] * (uint32_t)v[2])] > 0;
        if (!own) least = d2;
      }
  return sqrt(least);
}

/* Else erosion, which cuts where the field is shallow, would cut clefts through the middle of a rock. */
static void the_field_is_deep_where_the_rock_is_deep(void** state) {
  (void)state;
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  recipe.n = 4;
  const scree_bake_desc desc = {.recipe = &recipe};
  bake_run bake;
  assert_int_equal(bake_begin(&desc, false, &bake), SCREE_OK);
  rock_worker* worker = &bake.workers[0].rock;
  const double voxels = recipe.voxels_per_cell;
  double shallowest = INFINITY;
  uint32_t looked = 0;
  for (uint32_t i = 0; i < bake.cell_count; i += 23) {
    uint32_t code, x, y, z;
    scree_rt_lattice_cell_place(bake.seeds.n, bake.cells[i], &code, &x, &y, &z);
    block_cache_begin(&worker->blocks, code);
    if (!rock_voronoi(worker, (int32_t)x, (int32_t)y, (int32_t)z, 0)) continue;
    const uint32_t* size = worker->grid.size;
    uint32_t at[3];
    for (at[2] = 0; at[2] < size[2]; ++at[2])
      for (at[1] = 0; at[1] < size[1]; ++at[1])
        for (at[0] = 0; at[0] < size[0]; ++at[0]) {
          const float field = worker->field[at[0] + (size_t)size[0] * (at[1] + (size_t)size[1] * at[2])];
          if (field <= 0) continue;
          const double depth = true_depth(worker, at, 4);
          if (depth < 3) continue;
          ++looked;
          shallowest = fmin(shallowest, field * voxels / depth);
        }
  }
  bake_end(&bake);
  print_message("%u voxels 3 voxels or more below the border: the field is at least %.2f of that\n", looked, shallowest);
  assert_true(looked > 2000);
  assert_true(shallowest > 0.3);
}

static void boulders_have_no_cavities(void** state) {
  (void)state;
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  recipe.n = 4;
  stones set;
  stones_create(&recipe, &set);
  uint32_t hollow = 0;
  for (uint32_t slot = 0; slot < set.bake.slot_count; ++slot) {
    const stone* rock = &set.by_slot[slot];
    assert_non_null(rock->field);
    const uint32_t *size = rock->grid.size, strides[3] = {1, size[0], size[0] * size[1]}, count = strides[2] * size[2];
    uint8_t* open = need(count, 1); /* outside voxels that a flood from the first one reaches */
    uint32_t* stack = need(count, sizeof *stack);
    uint32_t height = 1, outside = 0;
    open[0] = 1;
    while (height > 0) {
      const uint32_t top = stack[--height], at[3] = {top % size[0], top / size[0] % size[1], top / strides[2]};
      for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side) {
          if (side == 0 ? at[axis] == 0 : at[axis] + 1 == size[axis]) continue;
          const uint32_t next = side == 0 ? top - strides[axis] : top + strides[axis];
          if (open[next] || rock->field[next] > 0) continue;
          open[next] = 1;
          stack[height++] = next;
        }
    }
    for (uint32_t v = 0; v < count; ++v) outside += !open[v] && !(rock->field[v] > 0);
    hollow += outside > 0;
    free(open);
    free(stack);
  }
  print_message("%u of %u rocks have a cavity\n", hollow, set.bake.slot_count);
  stones_destroy(&set);
  assert_int_equal(hollow, 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(boulders_touch_their_neighbours_and_never_overlap_them),
      cmocka_unit_test(bare_voronoi_cells_share_borders_and_never_overlap),
      cmocka_unit_test(many_seeds_a_cell_never_overlap),
      cmocka_unit_test(deep_rocks_have_nine_contacts_or_more_and_none_hangs_in_the_air),
      cmocka_unit_test(erosion_only_subtracts),
      cmocka_unit_test(an_eroded_rock_is_one_piece_inside_its_grid),
      cmocka_unit_test(the_field_is_deep_where_the_rock_is_deep),
      cmocka_unit_test(boulders_have_no_cavities),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
