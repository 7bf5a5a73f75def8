/* Weathered shapes as assets: meshes on the lattice, masses, hulls and parts, against slow and plain twins. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "failing_allocator.h"
#include "fake_weather.h"
#include "mesh_twin.h"
#include "random.h"
#include "weather_asset.h"

static twin_mesh twin_of(const weather_lod* lod) {
  return (twin_mesh){(const int16_t(*)[3])lod->mesh.positions, lod->mesh.indices, lod->mesh.vertex_count, lod->mesh.triangle_count};
}

/* --- Shapes: shares of voxels by 3^3 samples of a function. --- */

typedef double shape_depth(const double p[3]); /* > 0 inside */

static scree_weather* sample_shape(const uint32_t size[3], shape_depth* depth, const scree_allocator* allocator) {
  scree_weather* w = fake_weather_create(size, NULL, allocator);
  for (uint32_t z = 0; z < size[2]; ++z)
    for (uint32_t y = 0; y < size[1]; ++y)
      for (uint32_t x = 0; x < size[0]; ++x) {
        uint32_t in = 0;
        for (uint32_t i = 0; i < 27; ++i)
          in += depth((double[3]){x + (i % 3 + 0.5) / 3, y + (i / 3 % 3 + 0.5) / 3, z + (i / 9 + 0.5) / 3}) > 0;
        if (in > 0) fake_weather_set(w, x, y, z, y < 4 && x < 30 ? SCREE_VOXEL_COLLUVIUM : SCREE_VOXEL_ROCK, (float)in / 27);
      }
  return w;
}

static double length(double x, double y, double z) {
  return sqrt(x * x + y * y + z * z);
}

/* A cap on a thin neck on a foot; all in 64 x 80 x 64. */
static double pedestal(const double p[3]) {
  const double x = p[0] - 32, z = p[2] - 32, r = length(x, 0, z);
  return fmax(fmax(5 - r + (p[1] > 70 ? 70 - p[1] : 0), 22 - p[1] * 1.2 - r), 1 - length(x / 24, (p[1] - 60) / 10, z / 24));
}
static double ball(const double p[3]) {
  return 20 - length(p[0] - 32, p[1] - 40, p[2] - 32);
}
/* Four pillars, far apart: nothing that cuts along y alone could part. */
static double pillars(const double p[3]) {
  const double x = fabs(p[0] - 32), z = fabs(p[2] - 32);
  return fmin(7 - length(x - 20, 0, z - 20), 60 - p[1]);
}
/* A ring on its side: its centre of mass is in the air. */
static double ring(const double p[3]) {
  return 6 - length(length(p[0] - 32, 0, p[2] - 32) - 22, p[1] - 8, 0);
}

/* A ball, and crumbs beside it that coarse levels lose. */
static double crumbs(const double p[3]) {
  const double x = fmod(p[0], 16) - 8, z = fmod(p[2], 16) - 8;
  return fmax(18 - length(p[0] - 32, p[1] - 50, p[2] - 32), p[0] > 16 ? -1 : 2.2 - length(x, p[1] - 3, z));
}

static const struct {
  const char* name;
  shape_depth* depth;
} shapes[] = {{"pedestal", pedestal}, {"ball", ball}, {"pillars", pillars}, {"ring", ring}, {"crumbs", crumbs}};
enum { SHAPES = sizeof shapes / sizeof shapes[0] };
static const uint32_t shape_size[3] = {64, 80, 64};

static void make(shape_depth* depth, uint32_t lods, weather_asset* out) {
  scree_weather* w = sample_shape(shape_size, depth, NULL);
  scree_mesher* mesher;
  assert_int_equal(scree_mesher_create(w, &mesher), SCREE_OK);
  assert_int_equal(weather_asset_make(mesher, shape_size, weather_lattice(shape_size), lods, NULL, out), SCREE_OK);
  scree_mesher_destroy(mesher);
  fake_weather_destroy(w);
}

/* What lies below the ground to the ground. */
static void raise_floor(weather_asset* asset) {
  for (uint32_t lod = 0; lod < asset->lod_count; ++lod)
    for (uint32_t v = 0; v < asset->lods[lod].mesh.vertex_count; ++v)
      if (asset->lods[lod].mesh.positions[v][1] < 0) asset->lods[lod].mesh.positions[v][1] = 0;
}

/* --- Facts. --- */

static void levels_are_closed_and_their_errors_hold(void** state) {
  (void)state;
  for (int k = 0; k < SHAPES; ++k) {
    weather_asset asset;
    make(shapes[k].depth, 5, &asset);
    assert_int_equal(asset.lod_count, 5);
    assert_int_equal(asset.lattice_per_voxel, 64);
    const twin_mesh finest = twin_of(&asset.lods[0]);
    double volume, centroid[3];
    mesh_mass(&finest, &volume, centroid);
    for (uint32_t lod = 0; lod < asset.lod_count; ++lod) {
      const weather_lod* level = &asset.lods[lod];
      const twin_mesh mesh = twin_of(level);
      const mesh_faults faults = mesh_find_faults(&mesh);
      assert_int_equal(mesh_fault_sum(&faults), 0);
      assert_true(level->rock_triangles <= mesh.triangle_count);
      assert_true(level->mesh.error >= (lod == 0 ? 0 : asset.lods[lod - 1].mesh.error));
      double here, unused[3];
      mesh_mass(&mesh, &here, unused);
      assert_true(here > 0.8 * volume && here < 1.2 * volume);
      double worst = 0;
      for (uint32_t v = 0; v < finest.vertex_count; v += 1 + finest.vertex_count / 300) {
        const int16_t* p = finest.positions[v];
        worst = fmax(worst, mesh_distance(&mesh, (double[3]){p[0], p[1], p[2]}, worst));
      }
      if (shapes[k].depth == crumbs)
        assert_true(lod < 2 || (worst > 20 * 64 && level->level >= 2 && level->mesh.error < 6));
      else
        assert_true(worst <= (double)level->mesh.error * 64 * 1.0001 + 0.01);
      print_message("%s %u: level %u, %u vertices, error %.2f voxels\n", shapes[k].name, lod, level->level, mesh.vertex_count,
                    (double)level->mesh.error);
    }
    weather_asset_destroy(&asset, NULL);
    assert_null(asset.lods[0].mesh.positions);
  }
}

static void masses_are_those_of_the_twin(void** state) {
  (void)state;
  for (int k = 0; k < SHAPES; ++k) {
    weather_asset asset;
    make(shapes[k].depth, 2, &asset);
    const twin_mesh mesh = twin_of(&asset.lods[0]);
    uint32_t floor = 0;
    for (uint32_t v = 0; v < mesh.vertex_count; ++v) floor += mesh.positions[v][1] < 0;
    assert_true((floor > 0) == (shapes[k].depth == pedestal || shapes[k].depth == pillars));
    assert_true(floor > 0 ? asset.bounds_min[1] == -256 : asset.bounds_min[1] >= 0);
    double around = 0;
    for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
      const int16_t* p = mesh.positions[v];
      for (int axis = 0; axis < 3; ++axis) assert_true(p[axis] >= asset.bounds_min[axis] && p[axis] <= asset.bounds_max[axis]);
      around = fmax(around, length(p[0] - (double)asset.centroid[0] * 64, p[1] - (double)asset.centroid[1] * 64,
                                   p[2] - (double)asset.centroid[2] * 64));
    }
    assert_true(fabs((double)asset.outer_radius * 64 - around) < 0.1);
    raise_floor(&asset);
    double volume, centroid[3];
    mesh_mass(&mesh, &volume, centroid);
    assert_true(fabs((double)asset.volume * 64 * 64 * 64 / volume - 1) < 1e-5);
    double foot = 0, top = 0;
    for (int axis = 0; axis < 3; ++axis) assert_true(fabs((double)asset.centroid[axis] * 64 - centroid[axis]) < 0.05);
    for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
      const int16_t* p = mesh.positions[v];
      if (p[1] == 0) foot = fmax(foot, length(p[0], 0, p[2]));
      top = fmax(top, p[1]);
    }
    assert_true(fabs((double)asset.footprint * 64 - foot) < 0.01);
    assert_true(fabs((double)asset.height * 64 - top) < 0.01);
    if (shapes[k].depth == ring || shapes[k].depth == pillars)
      assert_true(asset.inner_radius == 0);
    else {
      assert_true(asset.inner_radius > 0);
      assert_true(mesh_distance(&mesh, centroid, 0) >= (double)asset.inner_radius * 64 * 0.999);
    }
    weather_asset_destroy(&asset, NULL);
  }
}

static void hulls_hold_the_shape_and_parts_hold_less_air(void** state) {
  (void)state;
  for (int k = 0; k < SHAPES; ++k) {
    weather_asset asset;
    make(shapes[k].depth, 4, &asset);
    raise_floor(&asset);
    const twin_mesh mesh = twin_of(&asset.lods[0]);
    assert_in_range(asset.hull_count, 4, ROCK_MAX_HULL);
    assert_in_range(asset.part_count, 1, PARTS_MAX);
    double worst = 0, worst_part = 0;
    for (uint32_t v = 0; v < mesh.vertex_count; v += 7) {
      const double p[3] = {mesh.positions[v][0], mesh.positions[v][1], mesh.positions[v][2]};
      worst = fmax(worst, hull_distance((const int16_t(*)[3])asset.hull, asset.hull_count, p, worst));
      double nearest = INFINITY;
      for (uint32_t part = 0; part < asset.part_count && nearest > worst_part; ++part) {
        assert_in_range(asset.parts[part].hull_count, 4, PARTS_MAX_HULL);
        const double off = hull_distance((const int16_t(*)[3])asset.parts[part].hull, asset.parts[part].hull_count, p, worst_part);
        nearest = fmin(nearest, off);
      }
      worst_part = fmax(worst_part, nearest);
    }
    print_message("%s: hull %u vertices, %.0f %% air, misses by %.2f voxels; %u parts, %.0f %% air, %.2f voxels\n", shapes[k].name,
                  asset.hull_count, 100 * (double)asset.hull_air, worst / 64, asset.part_count, 100 * (double)asset.parts_air,
                  worst_part / 64);
    for (uint32_t part = 1; part < asset.part_count; ++part) assert_true(asset.parts[part - 1].bottom <= asset.parts[part].bottom);
    assert_true(worst < 1.5 * 64 && worst_part < 3.5 * 64);
    if (shapes[k].depth == ball)
      assert_int_equal(asset.part_count, 1);
    else
      assert_true(asset.parts_air < 0.2f && asset.hull_air > asset.parts_air + 0.15f);
    weather_asset_destroy(&asset, NULL);
  }
}

static void a_hull_has_the_volume_of_its_points(void** state) {
  (void)state;
  const int16_t box[9][3] = {{0, 0, 0},   {10, 0, 0},  {0, 20, 0},   {10, 20, 0}, {0, 0, 30},
                             {10, 0, 30}, {0, 20, 30}, {10, 20, 30}, {5, 5, 5}};
  assert_true(fabs(convex_volume(box, 9) - 6000) < 2);
  assert_true(convex_volume(box, 4) < 2);
  assert_true(convex_volume(box, 3) == 0);
  const int16_t corner[4][3] = {{0, 0, 0}, {60, 0, 0}, {0, 60, 0}, {0, 0, 60}};
  assert_true(fabs(convex_volume(corner, 4) - 36000) < 10);
}

/* All that surfaces can hold, most of it as small as voxels are. */
static void noise_makes_assets_without_faults_on_any_lattice(void** state) {
  (void)state;
  random_stream random = {5};
  for (uint32_t lattice = 2; lattice <= 64; lattice *= 2) {
    const uint32_t size[3] = {24, 20, 22};
    scree_weather* w = fake_weather_create(size, NULL, NULL);
    for (uint32_t z = 0; z < size[2]; ++z)
      for (uint32_t y = 0; y < size[1]; ++y)
        for (uint32_t x = 0; x < size[0]; ++x)
          if (random_unit(&random) < 0.7) fake_weather_set(w, x, y, z, SCREE_VOXEL_ROCK, (float)random_unit(&random));
    scree_mesher* mesher;
    weather_asset asset;
    assert_int_equal(scree_mesher_create(w, &mesher), SCREE_OK);
    assert_int_equal(weather_asset_make(mesher, size, lattice, 4, NULL, &asset), SCREE_OK);
    for (uint32_t lod = 0; lod < asset.lod_count; ++lod) {
      const twin_mesh mesh = twin_of(&asset.lods[lod]);
      const mesh_faults faults = mesh_find_faults(&mesh);
      print_message("lattice %u level %u: %u triangles, %u flat, %u repeated, %u in all\n", lattice, lod, mesh.triangle_count,
                    faults.flat_triangles, faults.repeated_vertices, mesh_fault_sum(&faults));
      if (lattice >= 8) assert_int_equal(mesh_fault_sum(&faults), 0);
      assert_int_equal(mesh_fault_sum(&faults) - faults.flat_triangles - faults.repeated_vertices, 0);
    }
    weather_asset_destroy(&asset, NULL);
    scree_mesher_destroy(mesher);
    fake_weather_destroy(w);
  }
}

static void what_is_too_fine_for_a_pack_starts_at_a_coarser_level(void** state) {
  (void)state;
  const uint32_t size[3] = {200, 12, 200};
  scree_weather* w = fake_weather_create(size, NULL, NULL);
  for (uint32_t z = 0; z < size[2]; ++z)
    for (uint32_t y = 0; y < size[1]; ++y)
      for (uint32_t x = 0; x < size[0]; ++x) fake_weather_set(w, x, y, z, SCREE_VOXEL_ROCK, 1);
  scree_mesher* mesher;
  weather_asset asset;
  assert_int_equal(scree_mesher_create(w, &mesher), SCREE_OK);
  assert_int_equal(weather_asset_make(mesher, size, 16, 6, NULL, &asset), SCREE_OK);
  assert_int_equal(asset.lods[0].level, 1);
  assert_int_equal(asset.lod_count, 6);
  for (uint32_t lod = 0; lod < 6; ++lod) assert_true(asset.lods[lod].mesh.vertex_count <= WEATHER_MAX_VERTICES);
  weather_asset_destroy(&asset, NULL);
  scree_mesher_destroy(mesher);
  fake_weather_destroy(w);
}

static void lattices_fit_what_they_hold(void** state) {
  (void)state;
  const uint32_t small[3] = {40, 50, 60}, goblin[3] = {192, 130, 188}, long_one[3] = {4096, 4, 4};
  assert_int_equal(weather_lattice(small), 64);
  assert_int_equal(weather_lattice(goblin), 64);
  assert_int_equal(weather_lattice(long_one), 4);
}

static void nothing_is_no_asset_and_wrong_numbers_are_refused(void** state) {
  (void)state;
  scree_weather* w = fake_weather_create(shape_size, NULL, NULL);
  scree_mesher* mesher;
  weather_asset asset;
  assert_int_equal(scree_mesher_create(w, &mesher), SCREE_OK);
  assert_int_equal(weather_asset_make(mesher, shape_size, 64, 4, NULL, &asset), SCREE_ERROR_INVALID_ARGUMENT);
  fake_weather_set(w, 5, 5, 5, SCREE_VOXEL_ROCK, 1); /* a lone voxel is blurred away */
  ++w->change;
  assert_int_equal(weather_asset_make(mesher, shape_size, 64, 4, NULL, &asset), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(weather_asset_make(mesher, shape_size, 63, 4, NULL, &asset), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(weather_asset_make(mesher, shape_size, 128, 4, NULL, &asset), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(weather_asset_make(mesher, shape_size, 0, 4, NULL, &asset), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(weather_asset_make(mesher, shape_size, 64, 0, NULL, &asset), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(weather_asset_make(mesher, shape_size, 64, 7, NULL, &asset), SCREE_ERROR_INVALID_ARGUMENT);
  weather_asset_destroy(&asset, NULL);
  scree_mesher_destroy(mesher);
  fake_weather_destroy(w);
}

static void an_asset_without_memory_is_no_asset(void** state) {
  (void)state;
  scree_weather* w = sample_shape(shape_size, pedestal, NULL);
  scree_mesher* mesher;
  assert_int_equal(scree_mesher_create(w, &mesher), SCREE_OK);
  failing_allocator f = {.fail_at = -1};
  const scree_allocator allocator = failing_allocator_of(&f);
  for (int32_t n = 0;; ++n) {
    weather_asset asset;
    f.calls = 0;
    f.failed = false;
    f.fail_at = n;
    const scree_result result = weather_asset_make(mesher, shape_size, 64, 4, &allocator, &asset);
    assert_int_equal(result, f.failed ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_OK);
    if (f.failed) assert_int_equal(f.live, 0);
    weather_asset_destroy(&asset, &allocator);
    assert_int_equal(f.live, 0);
    if (!f.failed) {
      assert_true(n > 15);
      break;
    }
  }
  scree_mesher_destroy(mesher);
  fake_weather_destroy(w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(levels_are_closed_and_their_errors_hold),
      cmocka_unit_test(masses_are_those_of_the_twin),
      cmocka_unit_test(hulls_hold_the_shape_and_parts_hold_less_air),
      cmocka_unit_test(a_hull_has_the_volume_of_its_points),
      cmocka_unit_test(noise_makes_assets_without_faults_on_any_lattice),
      cmocka_unit_test(what_is_too_fine_for_a_pack_starts_at_a_coarser_level),
      cmocka_unit_test(lattices_fit_what_they_hold),
      cmocka_unit_test(nothing_is_no_asset_and_wrong_numbers_are_refused),
      cmocka_unit_test(an_asset_without_memory_is_no_asset),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
