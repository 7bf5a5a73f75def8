/* Proxies: closed meshes that stand for the rocks of a tile, where they are, as bright as they are, without see-through borders. */
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

enum { LODS = 3, PARTS = 9, MOST_VERTICES = 8192 };

typedef struct mesh {
  scree_vertex vertices[MOST_VERTICES];
  uint32_t indices[6 * MOST_VERTICES];
  scree_lod level;
} mesh;

static uint8_t* bytes;
static size_t size;
static scree_pack* pack;
static scree_pack_info info;
static mesh shape;

static int bake(void** state) {
  (void)state;
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  recipe.n = 4;
  recipe.voxels_per_cell = 6;
  recipe.lod_levels = LODS;
  const scree_bake_desc desc = {.recipe = &recipe};
  if (scree_bake_rocks(&desc, &bytes, &size, NULL, NULL) != SCREE_OK) return -1;
  if (scree_pack_open_memory(bytes, size, NULL, &pack) != SCREE_OK) return -1;
  scree_pack_get_info(pack, &info);
  return 0;
}

static int close_pack(void** state) {
  (void)state;
  scree_pack_close(pack);
  const scree_bake_desc desc = {0};
  scree_bake_free(&desc, bytes, size);
  return 0;
}

static void decode(uint32_t asset, uint32_t lod) {
  assert_int_equal(scree_pack_get_lod(pack, asset, lod, &shape.level), SCREE_OK);
  assert_int_equal(
      scree_draco_decode_u32(pack, asset, lod, shape.vertices, MOST_VERTICES, shape.indices, 6 * (size_t)MOST_VERTICES), SCREE_OK);
}

static int compare_edges(const void* a, const void* b) {
  const uint64_t x = *(const uint64_t*)a, y = *(const uint64_t*)b;
  return (x > y) - (x < y);
}

/* Positions name vertices, as the decoder may double a vertex. */
static void every_proxy_is_a_closed_mesh(void** state) {
  (void)state;
  assert_int_equal(info.proxy_count, 256 * PARTS);
  static uint64_t edges[6 * MOST_VERTICES], back[6 * MOST_VERTICES];
  for (uint32_t i = 0; i < info.proxy_count; i += 7)
    for (uint32_t lod = 0; lod < LODS; ++lod) {
      decode(info.asset_count + i, lod);
      const uint32_t count = 3 * shape.level.triangles;
      for (uint32_t e = 0; e < count; ++e) {
        uint64_t ends[2];
        for (uint32_t k = 0; k < 2; ++k) {
          const int16_t* p = shape.vertices[shape.indices[e / 3 * 3 + (e + k) % 3]].position;
          ends[k] = (uint64_t)(p[0] + 512) | (uint64_t)(p[1] + 512) << 10 | (uint64_t)(p[2] + 512) << 20;
        }
        edges[e] = ends[0] << 32 | ends[1];
        back[e] = ends[1] << 32 | ends[0];
      }
      qsort(edges, count, sizeof *edges, compare_edges);
      qsort(back, count, sizeof *back, compare_edges);
      assert_memory_equal(edges, back, count * sizeof *edges);
    }
}

static void levels_get_coarser_and_say_by_how_much(void** state) {
  (void)state;
  double first[2] = {0}, last[2] = {0};
  float worst = 0;
  for (uint32_t i = 0; i < info.proxy_count; ++i) {
    scree_lod finer = {0};
    for (uint32_t lod = 0; lod < LODS; ++lod) {
      scree_lod level;
      assert_int_equal(scree_pack_get_lod(pack, info.asset_count + i, lod, &level), SCREE_OK);
      assert_true(level.error > 0 && level.error >= finer.error && level.error < 1.6f);
      if (level.error > worst) worst = level.error;
      if (lod == 0) first[i % PARTS != 0] += level.triangles;
      if (lod + 1 == LODS) last[i % PARTS != 0] += level.triangles;
      finer = level;
    }
  }
  const double tiles = 256, parts = 256 * 8;
  print_message("largest error %.2f cells; triangles: tiles %.0f to %.0f, parts %.0f to %.0f\n", (double)worst, first[0] / tiles,
                last[0] / tiles, first[1] / parts, last[1] / parts);
  assert_true(first[0] / tiles > 1000 && first[0] / tiles < 3000);
  assert_true(last[0] / tiles > 50 && last[0] / tiles < 250);
  assert_true(last[1] / parts > 15 && last[1] / parts < 80);
}

/* A box around the vertices of a mesh at (x, y, z), cells. */
static void widen(double scale, double x, double y, double z, double low[3], double high[3]) {
  const double at[3] = {x, y, z};
  for (uint32_t v = 0; v < shape.level.vertices; ++v)
    for (int axis = 0; axis < 3; ++axis) {
      const double p = shape.vertices[v].position[axis] * scale + at[axis];
      if (p < low[axis]) low[axis] = p;
      if (p > high[axis]) high[axis] = p;
    }
}

static void proxies_lie_where_their_rocks_do(void** state) {
  (void)state;
  const uint32_t n = info.cells_per_cube, low_half = (n + 1) / 2;
  double worst = 0;
  for (uint32_t code = 0; code < 256; code += 15)
    for (uint32_t part = 0; part < PARTS; ++part) {
      double low[3] = {99, 99, 99}, high[3] = {-99, -99, -99}, proxy_low[3] = {99, 99, 99}, proxy_high[3] = {-99, -99, -99};
      for (uint32_t place = 0; place < n * n * n; ++place) {
        const uint32_t x = place % n, y = place / n % n, z = place / n / n;
        if (part != 0 && part != 1u + (x >= low_half) + 2u * (y >= low_half) + 4u * (z >= low_half)) continue;
        uint32_t cell, first, count;
        assert_int_equal(scree_pack_tile_cell(pack, code, x, y, z, &cell), SCREE_OK);
        assert_int_equal(scree_pack_cell_assets(pack, cell, &first, &count), SCREE_OK);
        for (uint32_t i = 0; i < count; ++i) {
          decode(first + i, 0);
          widen(1.0 / info.lattice_per_cell, x, y, z, low, high);
        }
      }
      for (uint32_t lod = 0; lod < LODS; ++lod) {
        for (int axis = 0; axis < 3; ++axis) proxy_low[axis] = 99, proxy_high[axis] = -99;
        decode(scree_pack_proxy(pack, code, part), lod);
        widen(1.0 / info.proxy_per_cell, 0, 0, 0, proxy_low, proxy_high);
        for (int axis = 0; axis < 3; ++axis) {
          worst = fmax(worst, fmax(fabs(proxy_low[axis] - low[axis]), fabs(proxy_high[axis] - high[axis])));
        }
      }
    }
  print_message("sides differ by at most %.2f cells\n", worst);
  assert_true(worst < 0.85);
}

static void proxies_are_about_as_bright_as_rocks(void** state) {
  (void)state;
  double rocks = 0, proxies = 0, rock_vertices = 0, proxy_vertices = 0;
  for (uint32_t asset = 0; asset < info.asset_count; asset += 11) {
    decode(asset, LODS - 1);
    for (uint32_t v = 0; v < shape.level.vertices; ++v) rocks += shape.vertices[v].occlusion;
    rock_vertices += shape.level.vertices;
  }
  for (uint32_t i = 0; i < info.proxy_count; i += 7) {
    decode(info.asset_count + i, 0);
    for (uint32_t v = 0; v < shape.level.vertices; ++v) proxies += shape.vertices[v].occlusion;
    proxy_vertices += shape.level.vertices;
  }
  const double ratio = proxies / proxy_vertices / (rocks / rock_vertices);
  print_message("mean occlusion of proxies over that of rocks: %.3f\n", ratio);
  assert_true(ratio > 0.75 && ratio < 1);
}

/* Whether a ray meets the mesh from its outer side. (Moeller and Trumbore, 1997.) */
static bool meets(double scale, const double from[3], const double direction[3]) {
  for (uint32_t t = 0; t < shape.level.triangles; ++t) {
    double p[3][3], u[3], v[3], s[3];
    for (uint32_t k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis) p[k][axis] = shape.vertices[shape.indices[3 * t + k]].position[axis] * scale;
    for (int axis = 0; axis < 3; ++axis)
      u[axis] = p[1][axis] - p[0][axis], v[axis] = p[2][axis] - p[0][axis], s[axis] = from[axis] - p[0][axis];
    const double d[3] = {direction[1] * v[2] - direction[2] * v[1], direction[2] * v[0] - direction[0] * v[2],
                         direction[0] * v[1] - direction[1] * v[0]};
    const double determinant = u[0] * d[0] + u[1] * d[1] + u[2] * d[2];
    if (determinant < 1e-12) continue;
    const double a = (s[0] * d[0] + s[1] * d[1] + s[2] * d[2]) / determinant;
    const double q[3] = {s[1] * u[2] - s[2] * u[1], s[2] * u[0] - s[0] * u[2], s[0] * u[1] - s[1] * u[0]};
    const double b = (direction[0] * q[0] + direction[1] * q[1] + direction[2] * q[2]) / determinant;
    const double at = (v[0] * q[0] + v[1] * q[1] + v[2] * q[2]) / determinant;
    if (a >= 0 && b >= 0 && a + b <= 1 && at > 0) return true;
  }
  return false;
}

/* Rays at the cracks between 3 x 3 x 3 tiles: through points on the borders of the middle one. */
static void no_ray_passes_between_proxies_side_by_side(void** state) {
  (void)state;
  enum { RAYS = 400 };
  const double n = info.cells_per_cube;
  for (uint32_t lod = 0; lod < LODS; ++lod) {
    bool stopped[RAYS] = {false};
    double from[RAYS][3], direction[RAYS][3];
    random_stream stream = {11};
    for (uint32_t r = 0; r < RAYS; ++r) {
      random_direction(&stream, direction[r]);
      for (int axis = 0; axis < 3; ++axis) {
        const double border = random_bits(&stream) % 3 == 0 ? random_unit(&stream) : (double)(random_bits(&stream) % 2);
        from[r][axis] = n * border - 0.5 - 20 * direction[r][axis];
      }
    }
    for (int32_t tile = 0; tile < 27; ++tile) {
      const int32_t x = tile % 3 - 1, y = tile / 3 % 3 - 1, z = tile / 9 - 1;
      decode(scree_pack_proxy(pack, cube_code(3, x, y, z), 0), lod);
      for (uint32_t r = 0; r < RAYS; ++r) {
        const double local[3] = {from[r][0] - n * x, from[r][1] - n * y, from[r][2] - n * z};
        stopped[r] = stopped[r] || meets(1.0 / info.proxy_per_cell, local, direction[r]);
      }
    }
    uint32_t passed = 0;
    for (uint32_t r = 0; r < RAYS; ++r) passed += !stopped[r];
    assert_int_equal(passed, 0);
  }
}

static void a_recipe_can_do_without(void** state) {
  (void)state;
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  recipe.n = 4;
  recipe.voxels_per_cell = 6;
  recipe.lod_levels = 1;
  recipe.proxies = false;
  const scree_bake_desc desc = {.recipe = &recipe};
  uint8_t* sparse_bytes;
  size_t sparse_size;
  scree_bake_report report;
  assert_int_equal(scree_bake_rocks(&desc, &sparse_bytes, &sparse_size, &report, NULL), SCREE_OK);
  assert_int_equal(report.proxies + report.proxy_triangles, 0);
  scree_pack* without;
  assert_int_equal(scree_pack_open_memory(sparse_bytes, sparse_size, NULL, &without), SCREE_OK);
  assert_int_equal(scree_pack_verify(without), SCREE_OK);
  assert_int_equal(scree_pack_proxy(without, 0, 0), UINT32_MAX);
  scree_pack_close(without);
  scree_bake_free(&desc, sparse_bytes, sparse_size);
}

/* Rocks so worn that nothing is left in some eighths of tiles: there, and nowhere else, a grain stands for them, in its place. */
static void an_eighth_without_rocks_has_a_grain_for_a_mesh(void** state) {
  (void)state;
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  recipe.n = 4;
  recipe.voxels_per_cell = 6;
  recipe.lod_levels = 2;
  recipe.erosion = 0.5, recipe.erosion_steps = 64, recipe.erosion_strength = 1;
  recipe.chisel_planes = 64, recipe.chisel_margin = 0.5;
  recipe.noise = 0.5;
  recipe.gamma = (scree_range){1, 1};
  const scree_bake_desc desc = {.recipe = &recipe};
  uint8_t* sparse_bytes;
  size_t sparse_size;
  assert_int_equal(scree_bake_rocks(&desc, &sparse_bytes, &sparse_size, NULL, NULL), SCREE_OK);
  scree_pack* sparse;
  assert_int_equal(scree_pack_open_memory(sparse_bytes, sparse_size, NULL, &sparse), SCREE_OK);
  assert_int_equal(scree_pack_verify(sparse), SCREE_OK);
  scree_pack_info about;
  scree_pack_get_info(sparse, &about);
  const uint32_t n = about.cells_per_cube, low_half = (n + 1) / 2;
  uint32_t grains = 0;
  for (uint32_t code = 0; code < 256; ++code) {
    uint32_t rocks[PARTS] = {0};
    for (uint32_t place = 0; place < n * n * n; ++place) {
      const uint32_t x = place % n, y = place / n % n, z = place / n / n;
      uint32_t cell, first, count;
      assert_int_equal(scree_pack_tile_cell(sparse, code, x, y, z, &cell), SCREE_OK);
      assert_int_equal(scree_pack_cell_assets(sparse, cell, &first, &count), SCREE_OK);
      rocks[1 + (x >= low_half) + 2 * (y >= low_half) + 4 * (z >= low_half)] += count;
    }
    for (uint32_t part = 1; part < PARTS; ++part)
      for (uint32_t lod = 0; lod < 2; ++lod) {
        const uint32_t proxy = scree_pack_proxy(sparse, code, part);
        assert_int_equal(scree_pack_get_lod(sparse, proxy, lod, &shape.level), SCREE_OK);
        assert_int_equal(shape.level.triangles == 4, rocks[part] == 0);
        if (rocks[part] > 0) continue;
        ++grains;
        assert_true(shape.level.vertices == 4 && shape.level.error == 0);
        assert_int_equal(scree_draco_decode_u32(sparse, proxy, lod, shape.vertices, 4, shape.indices, 12), SCREE_OK);
        for (uint32_t v = 0; v < 4; ++v)
          for (int axis = 0; axis < 3; ++axis) {
            const double p = (double)shape.vertices[v].position[axis] / about.proxy_per_cell, middle = low_half - 0.5;
            const bool high = (part - 1) >> axis & 1;
            assert_true(p >= (high ? middle : -0.5) && p <= (high ? n - 0.5 : middle));
          }
        double volume = 0; /* six times what it holds: a closed mesh, seen from outside */
        for (uint32_t t = 0; t < 4; ++t) {
          const int16_t *a = shape.vertices[shape.indices[3 * t]].position, *b = shape.vertices[shape.indices[3 * t + 1]].position,
                        *c = shape.vertices[shape.indices[3 * t + 2]].position;
          volume += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
        }
        assert_true(volume == 1);
      }
  }
  print_message("%u rocks are left; %u grains\n", about.asset_count, grains);
  assert_true(grains > 10);
  scree_pack_close(sparse);
  scree_bake_free(&desc, sparse_bytes, sparse_size);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_proxy_is_a_closed_mesh),
      cmocka_unit_test(levels_get_coarser_and_say_by_how_much),
      cmocka_unit_test(proxies_lie_where_their_rocks_do),
      cmocka_unit_test(proxies_are_about_as_bright_as_rocks),
      cmocka_unit_test(no_ray_passes_between_proxies_side_by_side),
      cmocka_unit_test(a_recipe_can_do_without),
      cmocka_unit_test(an_eighth_without_rocks_has_a_grain_for_a_mesh),
  };
  return cmocka_run_group_tests(tests, bake, close_pack);
}
