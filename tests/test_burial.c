/* Burial against the meshes themselves: a ball of real rocks, looked at from outside with and without those that are buried. */
#include <scree/bake.h>
#include <scree/draco.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "lattice.h"
#include "random.h"

enum { RADIUS = 12, SIDE = 2 * RADIUS + 3, SEED = 2009, RAYS = 20000 };

typedef struct mesh {
  scree_vertex* vertices;
  uint32_t* indices;
  uint32_t triangle_count;
  scree_asset rock;
} mesh;

typedef struct pile {
  scree_pack* pack;
  scree_pack_info info;
  mesh* meshes;                      /* by asset */
  uint32_t cells[SIDE][SIDE][SIDE];  /* unique cell, by z, y, x; UINT32_MAX where the ball is not */
  uint8_t kept[SIDE][SIDE][SIDE][8]; /* rocks that are not buried, by seed's place in the cell */
  uint32_t looked[SIDE][SIDE][SIDE]; /* last ray that the cell was looked at for */
  uint32_t ray;
  uint32_t rocks, buried;
} pile;

static mesh decode(const scree_pack* pack, uint32_t asset) {
  scree_lod level;
  assert_int_equal(scree_pack_get_lod(pack, asset, 0, &level), SCREE_OK);
  mesh out = {malloc(level.vertices * sizeof *out.vertices),
              malloc((size_t)level.triangles * 3 * sizeof *out.indices),
              level.triangles,
              {0}};
  assert_int_equal(scree_pack_get_asset(pack, asset, &out.rock), SCREE_OK);
  assert_true(out.vertices != NULL && out.indices != NULL);
  assert_int_equal(scree_draco_decode_u32(pack, asset, 0, out.vertices, level.vertices, out.indices, (size_t)level.triangles * 3),
                   SCREE_OK);
  return out;
}

/* Whether all cells within `ring` of one are full. */
static bool is_surrounded(const pile* p, int32_t x, int32_t y, int32_t z, int32_t ring) {
  for (int32_t k = z - ring; k <= z + ring; ++k)
    for (int32_t j = y - ring; j <= y + ring; ++j)
      for (int32_t i = x - ring; i <= x + ring; ++i)
        if (i < 0 || j < 0 || k < 0 || i >= SIDE || j >= SIDE || k >= SIDE || p->cells[k][j][i] == UINT32_MAX) return false;
  return true;
}

static pile* make_pile(const scree_recipe* recipe) {
  uint8_t* bytes;
  size_t size;
  const scree_bake_desc desc = {.recipe = recipe};
  assert_int_equal(scree_bake_rocks(&desc, &bytes, &size, NULL, NULL), SCREE_OK);
  pile* p = calloc(1, sizeof *p);
  assert_non_null(p);
  assert_int_equal(scree_pack_open_memory(bytes, size, NULL, &p->pack), SCREE_OK);
  scree_pack_get_info(p->pack, &p->info);
  assert_true(p->info.max_rocks_per_cell <= 8);
  p->meshes = calloc(p->info.asset_count, sizeof *p->meshes);
  assert_non_null(p->meshes);
  const int32_t n = (int32_t)p->info.cells_per_cube, middle = SIDE / 2;
  for (int32_t z = 0; z < SIDE; ++z)
    for (int32_t y = 0; y < SIDE; ++y)
      for (int32_t x = 0; x < SIDE; ++x) {
        const int32_t far = (x - middle) * (x - middle) + (y - middle) * (y - middle) + (z - middle) * (z - middle);
        p->cells[z][y][x] = UINT32_MAX;
        if (far > RADIUS * RADIUS) continue;
        const uint32_t code = cube_code(SEED, x / n, y / n, z / n);
        assert_int_equal(
            scree_pack_tile_cell(p->pack, code, (uint32_t)(x % n), (uint32_t)(y % n), (uint32_t)(z % n), &p->cells[z][y][x]),
            SCREE_OK);
      }
  for (int32_t z = 0; z < SIDE; ++z)
    for (int32_t y = 0; y < SIDE; ++y)
      for (int32_t x = 0; x < SIDE; ++x) {
        if (p->cells[z][y][x] == UINT32_MAX) continue;
        uint32_t first, count;
        assert_int_equal(scree_pack_cell_assets(p->pack, p->cells[z][y][x], &first, &count), SCREE_OK);
        for (uint32_t i = 0; i < count; ++i) {
          if (p->meshes[first + i].vertices == NULL) p->meshes[first + i] = decode(p->pack, first + i);
          const uint32_t burial = p->meshes[first + i].rock.burial;
          p->kept[z][y][x][i] = burial == SCREE_BURIAL_NEVER || !is_surrounded(p, x, y, z, (int32_t)burial);
          ++p->rocks;
          p->buried += !p->kept[z][y][x][i];
        }
      }
  return p;
}

static void free_pile(pile* p) {
  for (uint32_t a = 0; a < p->info.asset_count; ++a) {
    free(p->meshes[a].vertices);
    free(p->meshes[a].indices);
  }
  free(p->meshes);
  scree_pack_close(p->pack);
  free(p);
}

/* Distance along the ray to a mesh, in cells; INFINITY where it misses. (Moeller and Trumbore, 1997.) */
static double hit_mesh(const mesh* m, double scale, const double from[3], const double direction[3]) {
  double nearest = INFINITY;
  for (uint32_t t = 0; t < m->triangle_count; ++t) {
    double p[3][3], u[3], v[3], s[3];
    for (uint32_t k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis) p[k][axis] = m->vertices[m->indices[3 * t + k]].position[axis] * scale;
    for (int axis = 0; axis < 3; ++axis)
      u[axis] = p[1][axis] - p[0][axis], v[axis] = p[2][axis] - p[0][axis], s[axis] = from[axis] - p[0][axis];
    const double d[3] = {direction[1] * v[2] - direction[2] * v[1], direction[2] * v[0] - direction[0] * v[2],
                         direction[0] * v[1] - direction[1] * v[0]};
    const double determinant = u[0] * d[0] + u[1] * d[1] + u[2] * d[2];
    if (determinant < 1e-12) continue; /* from behind, or along it */
    const double a = (s[0] * d[0] + s[1] * d[1] + s[2] * d[2]) / determinant;
    const double q[3] = {s[1] * u[2] - s[2] * u[1], s[2] * u[0] - s[0] * u[2], s[0] * u[1] - s[1] * u[0]};
    const double b = (direction[0] * q[0] + direction[1] * q[1] + direction[2] * q[2]) / determinant;
    const double at = (v[0] * q[0] + v[1] * q[1] + v[2] * q[2]) / determinant;
    if (a >= 0 && b >= 0 && a + b <= 1 && at > 0 && at < nearest) nearest = at;
  }
  return nearest;
}

/* Whether the line passes the ball of a rock nearer than `nearest`. offset: from the rock's cell to the line's start. */
static bool passes(const scree_asset* rock, const double offset[3], const double direction[3], double nearest) {
  double along = 0, far = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double d = offset[axis] - (double)rock->centroid[axis];
    along -= d * direction[axis], far += d * d;
  }
  const double radius = (double)rock->outer_radius * 1.001;
  return far - along * along <= radius * radius && along - radius <= nearest;
}

static void look_at_cell(const pile* p, const int32_t cell[3], const double from[3], const double direction[3], double* nearest,
                         bool* buried) {
  const uint32_t unique = p->cells[cell[2]][cell[1]][cell[0]];
  if (unique == UINT32_MAX) return;
  const double offset[3] = {from[0] - cell[0], from[1] - cell[1], from[2] - cell[2]};
  uint32_t first, count;
  scree_pack_cell_assets(p->pack, unique, &first, &count);
  for (uint32_t i = 0; i < count; ++i) {
    if (!passes(&p->meshes[first + i].rock, offset, direction, *nearest)) continue;
    const double at = hit_mesh(&p->meshes[first + i], 1.0 / p->info.lattice_per_cell, offset, direction);
    if (at >= *nearest) continue;
    *nearest = at;
    *buried = !p->kept[cell[2]][cell[1]][cell[0]][i];
  }
}

/* The nearest hit of a ray with the pile; *buried says whether that is a rock that would be left out. Rocks reach a cell away from
 * their own cell's middle along each axis: all cells within two of the ray are looked at, half a cell after half a cell. */
static double look(pile* p, const double from[3], const double direction[3], bool* buried) {
  double nearest = INFINITY;
  ++p->ray;
  for (double along = 0; along < 6 * RADIUS && along < nearest + 2; along += 0.5) {
    int32_t low[3], high[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double at = from[axis] + along * direction[axis];
      low[axis] = at < 1.5 ? 0 : (int32_t)(at - 1.5);
      high[axis] = at > SIDE - 3.5 ? SIDE - 1 : at < -2.5 ? -1 : (int32_t)(at + 2.5);
    }
    int32_t c[3];
    for (c[2] = low[2]; c[2] <= high[2]; ++c[2])
      for (c[1] = low[1]; c[1] <= high[1]; ++c[1])
        for (c[0] = low[0]; c[0] <= high[0]; ++c[0]) {
          uint32_t* looked = &p->looked[c[2]][c[1]][c[0]];
          if (*looked == p->ray) continue;
          *looked = p->ray;
          look_at_cell(p, c, from, direction, &nearest, buried);
        }
  }
  return nearest;
}

static void expect_buried_rocks_are_not_seen(const scree_recipe* recipe, double least_saved) {
  pile* p = make_pile(recipe);
  uint32_t hits = 0, changed = 0;
  random_stream stream = {42};
  for (uint32_t ray = 0; ray < RAYS; ++ray) {
    double direction[3], across[3], from[3];
    random_direction(&stream, direction);
    random_direction(&stream, across);
    for (int axis = 0; axis < 3; ++axis)
      from[axis] = SIDE / 2 + across[axis] * RADIUS * sqrt(random_unit(&stream)) - direction[axis] * 3 * RADIUS;
    bool buried = false;
    if (look(p, from, direction, &buried) == INFINITY) continue;
    ++hits;
    changed += buried;
  }
  print_message("%s: %u of %u rocks are buried; %u of %u rays see one\n", recipe->name, p->buried, p->rocks, changed, hits);
  assert_true(hits > RAYS / 2);
  assert_true(p->buried > least_saved * p->rocks);
  assert_true(changed == 0);
  free_pile(p);
}

static void from_outside_next_to_no_ray_sees_a_buried_rock(void** state) {
  (void)state;
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  recipe.n = 4;
  recipe.proxies = false;
  recipe.voxels_per_cell = 6;
  recipe.lod_levels = 2;
  expect_buried_rocks_are_not_seen(&recipe, 0.05);
}

static void small_stones_are_buried_by_fewer_cells(void** state) {
  (void)state;
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  strcpy(recipe.name, "gravel");
  recipe.n = 4;
  recipe.proxies = false;
  recipe.seeds_min = 3, recipe.seeds_max = 5;
  recipe.erosion = 0.035, recipe.noise = 0.045, recipe.contact_radius = 0.04, recipe.contact_blend = 0.25;
  recipe.voxels_per_cell = 10;
  recipe.lod_levels = 2;
  expect_buried_rocks_are_not_seen(&recipe, 0.12);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(from_outside_next_to_no_ray_sees_a_buried_rock),
      cmocka_unit_test(small_stones_are_buried_by_fewer_cells),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
