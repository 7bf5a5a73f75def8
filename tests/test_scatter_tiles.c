/* The tiles of scatters: distances and density over any colouring, and the same points everywhere. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* after the five above */
#include <cmocka.h>

#include "lattice.h"
#include "scatter_tiles.h"

enum { PLANE = 12, SIDE = SCATTER_SIDE, RADIUS = SCATTER_RADIUS };

/* Points of a plane of PLANE x PLANE tiles, coloured at random. */
typedef struct plane {
  uint32_t count, first[PLANE * PLANE + 1];
  int32_t x[PLANE * PLANE * SCATTER_MOST_POINTS], z[PLANE * PLANE * SCATTER_MOST_POINTS];
} plane;

/* `pattern` < 16 repeats one 2 x 2 pattern of colours, others are random. */
static uint32_t colour(uint64_t pattern, int32_t x, int32_t z) {
  return pattern < 16 ? (uint32_t)(pattern >> ((x & 1) + 2 * (z & 1)) & 1) : corner_colour(pattern, x, 0, z);
}

static void lay(plane* p, const scatter_tile* tiles, uint64_t pattern) {
  p->count = 0;
  for (int32_t z = 0; z < PLANE; ++z)
    for (int32_t x = 0; x < PLANE; ++x) {
      uint32_t code = 0;
      for (int32_t i = 0; i < 4; ++i) code |= colour(pattern, x + (i & 1), z + (i >> 1)) << i;
      const scatter_tile* tile = &tiles[code];
      p->first[z * PLANE + x] = p->count;
      for (uint32_t i = 0; i < tile->count; ++i) {
        assert_true(tile->x[i] < SIDE && tile->z[i] < SIDE);
        p->x[p->count] = x * SIDE + tile->x[i];
        p->z[p->count++] = z * SIDE + tile->z[i];
      }
    }
  p->first[PLANE * PLANE] = p->count;
}

/* The least squared distance from a place to a point of the plane that is not `self`; within a tile round it. */
static int64_t nearest2(const plane* p, int32_t x, int32_t z, uint32_t self) {
  int64_t least = INT64_MAX;
  for (int32_t tz = z / SIDE - 1; tz <= z / SIDE + 1; ++tz)
    for (int32_t tx = x / SIDE - 1; tx <= x / SIDE + 1; ++tx) {
      if (tx < 0 || tz < 0 || tx >= PLANE || tz >= PLANE) continue;
      for (uint32_t i = p->first[tz * PLANE + tx]; i < p->first[tz * PLANE + tx + 1]; ++i) {
        const int64_t dx = p->x[i] - x, dz = p->z[i] - z;
        if (i != self && dx * dx + dz * dz < least) least = dx * dx + dz * dz;
      }
    }
  return least;
}

static plane* make_plane(void) {
  plane* p = malloc(sizeof *p);
  assert_non_null(p);
  return p;
}

static void no_two_points_of_any_colouring_are_nearer_than_the_radius(void** state) {
  (void)state;
  plane* p = make_plane();
  scatter_tile tiles[SCATTER_TILES];
  for (uint64_t seed = 0; seed < 64; ++seed) { /* many, because points of two borders of a corner seldom come near */
    scree_rt_scatter_make_tiles(seed * UINT64_C(0x123456789abcdef), tiles);
    for (uint64_t pattern = seed == 0 ? 0 : 16; pattern < 17; ++pattern) {
      lay(p, tiles, pattern + (pattern == 16 ? seed : 0));
      for (uint32_t i = 0; i < p->count; ++i) assert_true(nearest2(p, p->x[i], p->z[i], i) >= RADIUS * RADIUS);
    }
  }
  free(p);
}

static void no_further_point_fits_anywhere(void** state) {
  (void)state;
  plane* p = make_plane();
  scatter_tile tiles[SCATTER_TILES];
  uint64_t random = 1;
  for (uint64_t seed = 0; seed < 4; ++seed) {
    scree_rt_scatter_make_tiles(seed, tiles);
    lay(p, tiles, 100 + seed);
    for (int i = 0; i < 50000; ++i) {
      random = hash_mix(random + 1);
      const int32_t x = SIDE + (int32_t)(random % ((PLANE - 2) * SIDE)),
                    z = SIDE + (int32_t)((random >> 32) % ((PLANE - 2) * SIDE));
      assert_true(nearest2(p, x, z, UINT32_MAX) < RADIUS * RADIUS);
    }
    /* Every place of one tile, borders and corners included. */
    for (int32_t z = 5 * SIDE - 3; z < 5 * SIDE + 600; ++z)
      for (int32_t x = 5 * SIDE - 3; x < 5 * SIDE + 600; ++x) assert_true(nearest2(p, x, z, UINT32_MAX) < RADIUS * RADIUS);
  }
  free(p);
}

/* Random sequential adsorption of discs fills 0.5471 of the plane: 0.6966 points for each radius squared. Maximal sets lie between
 * that of the tightest packing, 1.1547, and a third of it. */
static void density_is_that_of_a_maximal_set_of_random_darts_within_three_percent(void** state) {
  (void)state;
  plane* p = make_plane();
  scatter_tile tiles[SCATTER_TILES];
  double sum = 0, least = 10, most = 0;
  const int seeds = 24;
  for (int seed = 0; seed < seeds; ++seed) {
    scree_rt_scatter_make_tiles((uint64_t)seed, tiles);
    lay(p, tiles, 1000 + (uint64_t)seed);
    double density = (double)p->count / (PLANE * PLANE) * RADIUS * RADIUS / SIDE / SIDE;
    sum += density;
    least = fmin(least, density);
    most = fmax(most, density);
  }
  print_message("points for each radius squared: %.4f on average, %.4f to %.4f; random darts: 0.6966\n", sum / seeds, least, most);
  assert_true(fabs(sum / seeds / 0.6966 - 1) < 0.03);
  assert_true(least > 0.64 && most < 0.76);
  free(p);
}

/* Tiles that share the colours of a border share the points along it; all else differs. */
static void tiles_differ_where_their_colours_do(void** state) {
  (void)state;
  scatter_tile tiles[SCATTER_TILES];
  scree_rt_scatter_make_tiles(5, tiles);
  for (int a = 0; a < SCATTER_TILES; ++a)
    for (int b = 0; b < a; ++b) assert_memory_not_equal(&tiles[a], &tiles[b], sizeof tiles[a]);
}

static void tiles_are_the_same_everywhere(void** state) {
  (void)state;
  uint64_t digest = 0;
  for (uint64_t seed = 0; seed < 4; ++seed) {
    scatter_tile tiles[SCATTER_TILES];
    scree_rt_scatter_make_tiles(seed, tiles);
    for (uint32_t t = 0; t < SCATTER_TILES; ++t) {
      digest = hash_combine(digest, tiles[t].count);
      for (uint32_t i = 0; i < tiles[t].count; ++i) digest = hash_combine(digest, tiles[t].x[i] | (uint64_t)tiles[t].z[i] << 32);
    }
  }
  const uint64_t golden = UINT64_C(0x8ce69f33b8405bf9);
  if (digest != golden) fail_msg("the digest of the tiles is 0x%016llx", (unsigned long long)digest);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(no_two_points_of_any_colouring_are_nearer_than_the_radius),
      cmocka_unit_test(no_further_point_fits_anywhere),
      cmocka_unit_test(density_is_that_of_a_maximal_set_of_random_darts_within_three_percent),
      cmocka_unit_test(tiles_differ_where_their_colours_do),
      cmocka_unit_test(tiles_are_the_same_everywhere),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
