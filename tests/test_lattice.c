/* The lattice of corners: unique cells, the zones that decide them, and why one bake a rock is enough. */
#include "lattice.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void unique_cells_number_as_in_the_paper(void** state) {
  (void)state;
  assert_int_equal(scree_rt_lattice_cell_count(3), 2266);
  assert_int_equal(scree_rt_lattice_cell_count(4), 7382);
  assert_int_equal(scree_rt_lattice_cell_count(5), 17202);
  assert_int_equal(scree_rt_lattice_cell_count(6), 33262);
  for (uint32_t n = 3; n <= 8; ++n)
    assert_int_equal(scree_rt_lattice_cell_count(n), 2 + 12 * (n - 1) + 48 * (n - 1) * (n - 1) + 256 * (n - 1) * (n - 1) * (n - 1));
}

static void cell_place_is_the_inverse_of_cell(void** state) {
  (void)state;
  for (uint32_t n = 3; n <= 6; ++n)
    for (uint32_t cell = 0; cell < scree_rt_lattice_cell_count(n); ++cell) {
      uint32_t code, x, y, z;
      scree_rt_lattice_cell_place(n, cell, &code, &x, &y, &z);
      assert_true(code < 256 && x < n && y < n && z < n);
      assert_int_equal(scree_rt_lattice_cell(n, code, x, y, z), cell);
    }
}

static void every_tile_place_has_a_cell_in_range_and_every_cell_a_place(void** state) {
  (void)state;
  for (uint32_t n = 3; n <= 6; ++n) {
    uint32_t count = scree_rt_lattice_cell_count(n);
    uint8_t* seen = calloc(count, 1);
    assert_non_null(seen);
    for (uint32_t code = 0; code < 256; ++code)
      for (uint32_t z = 0; z < n; ++z)
        for (uint32_t y = 0; y < n; ++y)
          for (uint32_t x = 0; x < n; ++x) {
            uint32_t cell = scree_rt_lattice_cell(n, code, x, y, z);
            assert_true(cell < count);
            seen[cell] = 1;
          }
    for (uint32_t cell = 0; cell < count; ++cell) assert_int_equal(seen[cell], 1);
    free(seen);
  }
}

/* Which corners decide a cell, from the drawing in lattice.h: an axis at place 0 is decided by plane 0, any other by both. */
static uint32_t zone_corners(uint32_t x, uint32_t y, uint32_t z) {
  uint32_t corners = 0;
  for (uint32_t corner = 0; corner < 8; ++corner) {
    int decides = (x > 0 || !(corner & 1)) && (y > 0 || !(corner & 2)) && (z > 0 || !(corner & 4));
    corners |= (uint32_t)decides << corner;
  }
  return corners;
}

static void cell_depends_on_exactly_the_corners_of_its_zone(void** state) {
  (void)state;
  for (uint32_t n = 3; n <= 5; ++n)
    for (uint32_t code = 0; code < 256; ++code)
      for (uint32_t z = 0; z < n; ++z)
        for (uint32_t y = 0; y < n; ++y)
          for (uint32_t x = 0; x < n; ++x)
            for (uint32_t corner = 0; corner < 8; ++corner) {
              int changes = scree_rt_lattice_cell(n, code, x, y, z) != scree_rt_lattice_cell(n, code ^ (1u << corner), x, y, z);
              assert_int_equal(changes, zone_corners(x, y, z) >> corner & 1);
            }
}

/* Planes (bit p = plane p, of a line of planes) that a seed at global place m of an axis depends on. */
static uint32_t seed_planes(uint32_t n, uint32_t m) {
  uint32_t cube = m / n, place = m % n;
  if (place <= 1) return 1u << cube;
  if (place == n - 1) return 1u << (cube + 1);
  return 3u << cube;
}

static void seeds_of_the_27_cells_round_a_rock_stay_in_its_zone(void** state) {
  (void)state;
  /* One axis is enough: zones over three axes are products. A rock sees the seeds one cell to either side. */
  for (uint32_t n = 3; n <= 9; ++n)
    for (uint32_t m = n; m < 2 * n; ++m) {
      uint32_t needed = seed_planes(n, m - 1) | seed_planes(n, m) | seed_planes(n, m + 1);
      uint32_t granted = m == n ? 1u << 1 : 3u << 1;
      assert_int_equal(needed & ~granted, 0);
    }
  /* Two cells a side are too few: the zones of both corners collide, which is why n starts at 4 in recipes. */
  assert_int_not_equal((seed_planes(2, 1) | seed_planes(2, 2) | seed_planes(2, 3)) & ~(1u << 1), 0);
}

static void neighbouring_cubes_agree_about_the_cells_they_share(void** state) {
  (void)state;
  /* The cell on a corner plane belongs to the cube above it; its rock must not know what lies beyond that plane's corners:
   * cubes that share the colours of the plane show the same cell there. */
  uint64_t random = 42;
  for (int round = 0; round < 20000; ++round) {
    random = hash_mix(random + UINT64_C(0x9e3779b97f4a7c15));
    uint32_t a = (uint32_t)random & 255, other = (uint32_t)(random >> 8) & 255;
    uint32_t n = 3 + (uint32_t)(random >> 16) % 4, y = (uint32_t)(random >> 24) % n, z = (uint32_t)(random >> 32) % n;
    uint32_t b = (a & 0x55) | (other & 0xaa); /* the same four corners with dx = 0 */
    assert_int_equal(scree_rt_lattice_cell(n, a, 0, y, z), scree_rt_lattice_cell(n, b, 0, y, z));
  }
}

static void cube_code_is_the_colours_of_its_eight_corners(void** state) {
  (void)state;
  for (int32_t i = 0; i < 1000; ++i) {
    uint64_t seed = hash_mix((uint64_t)i + 1);
    int32_t x = (int32_t)(seed >> 3), y = i - 500, z = INT32_MIN + 7 * i;
    x = x == INT32_MAX ? 0 : x;
    for (int32_t corner = 0; corner < 8; ++corner)
      assert_int_equal(cube_code(seed, x, y, z) >> corner & 1,
                       corner_colour(seed, x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2)));
  }
}

static void corner_colours_are_fair_and_depend_on_every_coordinate(void** state) {
  (void)state;
  uint32_t ones = 0, differ[4] = {0, 0, 0, 0};
  enum { SIDE = 40, COUNT = SIDE * SIDE * SIDE };
  for (int32_t z = 0; z < SIDE; ++z)
    for (int32_t y = 0; y < SIDE; ++y)
      for (int32_t x = 0; x < SIDE; ++x) {
        uint32_t colour = corner_colour(7, x - 20, y - 20, z - 20);
        ones += colour;
        differ[0] += colour != corner_colour(7, x - 19, y - 20, z - 20);
        differ[1] += colour != corner_colour(7, x - 20, y - 19, z - 20);
        differ[2] += colour != corner_colour(7, x - 20, y - 20, z - 19);
        differ[3] += colour != corner_colour(8, x - 20, y - 20, z - 20);
      }
  /* Five standard deviations of a fair coin thrown COUNT times: 5 * sqrt(64000) / 2. */
  const uint32_t spread = 633;
  assert_in_range(ones, COUNT / 2 - spread, COUNT / 2 + spread);
  for (int i = 0; i < 4; ++i) assert_in_range(differ[i], COUNT / 2 - spread, COUNT / 2 + spread);
}

static void hash_of_a_corner_never_changes(void** state) {
  (void)state;
  /* A saved world is a seed: were these values to change, every world would. */
  assert_true(hash_mix(0) == 0);
  assert_true(hash_mix(UINT64_C(0x9e3779b97f4a7c15)) == UINT64_C(0xe220a8397b1dcdaf)); /* splitmix64's first output for seed 0 */
  assert_true(hash_corner(0, 0, 0, 0) == UINT64_C(0x109c9866120ad3cf));
  assert_true(hash_corner(1, -2, 3, INT32_MIN) == UINT64_C(0xc62b1465b149e62a));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(unique_cells_number_as_in_the_paper),
      cmocka_unit_test(cell_place_is_the_inverse_of_cell),
      cmocka_unit_test(every_tile_place_has_a_cell_in_range_and_every_cell_a_place),
      cmocka_unit_test(cell_depends_on_exactly_the_corners_of_its_zone),
      cmocka_unit_test(seeds_of_the_27_cells_round_a_rock_stay_in_its_zone),
      cmocka_unit_test(neighbouring_cubes_agree_about_the_cells_they_share),
      cmocka_unit_test(cube_code_is_the_colours_of_its_eight_corners),
      cmocka_unit_test(corner_colours_are_fair_and_depend_on_every_coordinate),
      cmocka_unit_test(hash_of_a_corner_never_changes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
