/* What stands of split rock as an asset. The first argument is a folder with meshes; those that are not there are said to be
 * skipped. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "failing_allocator.h"
#include "make_shards.h"
#include "make_solids.h"
#include "mesh_twin.h"
#include "random.h"
#include "shard_asset.h"
#include "surface_twin.h"

static const char* folder = "";

static void* must(void* memory) {
  if (memory == NULL) abort();
  return memory;
}

static twin_mesh twin_of(const lattice_mesh* mesh) {
  return (twin_mesh){(const int16_t(*)[3])mesh->positions, mesh->indices, mesh->vertex_count, mesh->triangle_count};
}

/* Joined by place. */
static uint32_t open_places(const lattice_mesh* mesh) {
  uint32_t* corners = must(malloc(3 * (size_t)mesh->triangle_count * sizeof *corners));
  scree_frost_surface places = {.vertex_count = mesh->vertex_count,
                                .solid_triangles = mesh->triangle_count,
                                .indices = mesh->indices,
                                .vertices = must(calloc(mesh->vertex_count, sizeof *places.vertices))};
  for (uint32_t v = 0; v < mesh->vertex_count; ++v)
    for (uint32_t a = 0; a < 3; ++a) places.vertices[v].position[a] = mesh->positions[v][a];
  twin_join_places(&places, corners);
  const uint32_t open = twin_open_edges(corners, mesh->triangle_count);
  free(places.vertices);
  free(corners);
  return open;
}

/* What is true of every asset. steps: a metre. */
static void check_asset(const shard_asset* asset, uint32_t lods, double steps, double volume, double near) {
  assert_int_equal(asset->lod_count, lods);
  assert_true(fabs((double)asset->volume - volume) < near * volume);
  for (uint32_t k = 0; k < lods; ++k) {
    const lattice_mesh* mesh = &asset->lods[k].mesh;
    assert_int_equal(open_places(mesh), 0);
    assert_in_range(mesh->vertex_count, 4, SHARD_ASSET_MAX_VERTICES);
    if (k > 0) assert_true(mesh->triangle_count <= asset->lods[k - 1].mesh.triangle_count);
    const twin_mesh twin = twin_of(mesh);
    const mesh_faults faults = mesh_find_faults(&twin);
    assert_int_equal(faults.bad_indices + faults.repeated_corners + faults.unused_vertices, 0);
    double held, centroid[3];
    mesh_mass(&twin, &held, centroid);
    held /= steps * steps * steps;
    assert_true(held > 0.75 * volume && held < 1.25 * volume);
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
      assert_true(mesh->surface[v][0] == 0 || mesh->surface[v][0] == 2);
      assert_true(mesh->surface[v][2] > 0);
      for (uint32_t a = 0; a < 2; ++a) {
        assert_true(mesh->uvs[v][a] >= asset->uv_min[a] && mesh->uvs[v][a] <= asset->uv_max[a]);
        assert_true(isfinite(mesh->uvs[v][a]));
      }
    }
  }
  const lattice_mesh* finest = &asset->lods[0].mesh;
  for (uint32_t v = 0; v < finest->vertex_count; ++v) {
    double off = 0;
    for (uint32_t a = 0; a < 3; ++a) {
      assert_true(finest->positions[v][a] >= asset->bounds_min[a] && finest->positions[v][a] <= asset->bounds_max[a]);
      off += pow(finest->positions[v][a] / steps - (double)asset->centroid[a], 2);
    }
    assert_true(sqrt(off) <= (double)asset->outer_radius);
    assert_true(sqrt(off) >= (double)asset->inner_radius);
    if (v % 7 == 0) { /* the hull holds nearly everything */
      const double p[3] = {finest->positions[v][0], finest->positions[v][1], finest->positions[v][2]};
      const double reach = 0.1 * (double)asset->outer_radius * steps + 1;
      assert_true(hull_distance(asset->hull, asset->hull_count, p, reach) <= reach);
    }
  }
  assert_in_range(asset->hull_count, 4, ROCK_MAX_HULL);
  assert_in_range(asset->part_count, 1, SHARD_PARTS_MAX);
  for (uint32_t p = 0; p < asset->part_count; ++p) assert_in_range(asset->parts[p].hull_count, 4, SHARD_PART_MAX_HULL);
}

static uint8_t* random_inside(random_stream* r, uint32_t count, double share) {
  uint8_t* inside = must(calloc(count, 1));
  for (uint32_t s = 0; s < count; ++s) inside[s] = random_unit(r) < share;
  return inside;
}

static double volume_inside(const scree_shards_view* view, const uint8_t* inside) {
  double sum = 0;
  for (uint32_t s = 0; s < view->shard_count; ++s) sum += inside[s] ? view->shards[s].volume : 0;
  return sum;
}

static shard_asset_desc desc_of(const scree_shards* shards, const uint8_t* inside, uint32_t lods) {
  shard_asset_desc desc = {.shards = shards, .inside = inside, .lods = lods};
  shard_asset_origin(shards, -1e6, desc.origin);
  desc.steps_per_metre = shard_asset_lattice(shards, desc.origin);
  return desc;
}

static shard_asset* must_make(const shard_asset_desc* desc) {
  shard_asset* asset = must(malloc(sizeof *asset));
  assert_int_equal(shard_asset_make(desc, NULL, asset), SCREE_OK);
  return asset;
}

static void must_free(shard_asset* asset) {
  shard_asset_destroy(asset, NULL);
  free(asset);
}

static void what_stands_of_boxes_is_a_sound_asset(void** state) {
  (void)state;
  random_stream r = {31};
  for (uint32_t round = 0; round < 12; ++round) {
    scree_shards* shards = make_lattice((const uint32_t[3]){5, 4 + round % 3, 5}, round, NULL);
    scree_shards_view view;
    scree_shards_get(shards, &view);
    uint8_t* inside = random_inside(&r, view.shard_count, round == 0 ? 2 : 0.5 + 0.4 * random_unit(&r));
    shard_asset_desc desc = desc_of(shards, inside, 1 + round % 5);
    desc.joints = round % 2 == 1;
    assert_true(desc.steps_per_metre >= 1000);
    shard_asset* asset = must_make(&desc);
    check_asset(asset, desc.lods, desc.steps_per_metre, volume_inside(&view, inside), 0.002);
    must_free(asset);
    free(inside);
    scree_shards_destroy(shards);
  }
}

/* With joints every triangle is of one shard, so that its corners are equally durable, and neighbours differ; without, none does.
 * The outside of a whole lattice is flat: only joints keep it from being a few triangles. */
static void joints_show_on_the_solid_at_every_level(void** state) {
  (void)state;
  scree_shards* shards = make_lattice((const uint32_t[3]){5, 5, 5}, 3, NULL);
  scree_shards_view view;
  scree_shards_get(shards, &view);
  uint8_t inside[125];
  memset(inside, 1, sizeof inside);
  for (uint32_t joints = 0; joints < 2; ++joints) {
    shard_asset_desc desc = desc_of(shards, inside, 3);
    desc.joints = joints == 1;
    shard_asset* asset = must_make(&desc);
    check_asset(asset, desc.lods, desc.steps_per_metre, view.volume, 0.002);
    for (uint32_t lod = 0; lod < asset->lod_count; ++lod) {
      const lattice_mesh* mesh = &asset->lods[lod].mesh;
      uint32_t kinds = 0;
      bool known[256] = {false};
      for (uint32_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        const uint8_t durability = mesh->surface[mesh->indices[i]][1];
        assert_int_equal(durability, mesh->surface[mesh->indices[i / 3 * 3]][1]);
        assert_in_range(durability, joints == 1 ? 32 : 64, joints == 1 ? 92 : 64);
        assert_int_equal(durability % 4, 0);
        kinds += !known[durability];
        known[durability] = true;
      }
      if (joints == 0) assert_int_equal(kinds, 1);
      if (joints == 1) assert_true(kinds >= 8);
    }
    if (joints == 1) assert_true(asset->lods[0].mesh.triangle_count >= 2 * 6 * 25);
    must_free(asset);
  }
  scree_shards_destroy(shards);
}

/* A whole box of columns cut by mesh is its own 12 triangles; with joints each shard has its own, whichever way it was cut. */
static void joints_split_the_triangles_of_the_solid(void** state) {
  (void)state;
  box_solid box;
  make_box(&box, (const double[3]){0, 0, 0}, (const double[3]){4, 2, 3});
  const scree_seed_pattern pattern = {.kind = SCREE_SEEDS_COLUMNS, .spacing = 0.8, .jitter = 0.3, .random_seed = 4};
  double* seeds;
  uint32_t count;
  assert_int_equal(scree_seeds_create(&pattern, &box.solid, NULL, &seeds, &count, NULL), SCREE_OK);
  for (uint32_t clip = SCREE_CLIP_WALLS; clip <= SCREE_CLIP_MESH; ++clip) {
    const scree_shards_desc cut = {.solid = box.solid, .seeds = seeds, .seed_count = count, .clip = (scree_clip)clip};
    scree_shards* shards;
    assert_int_equal(scree_shards_create(&cut, &shards, NULL), SCREE_OK);
    scree_shards_view view;
    scree_shards_get(shards, &view);
    uint8_t* inside = must(malloc(view.shard_count));
    memset(inside, 1, view.shard_count);
    for (uint32_t joints = 0; joints < 2; ++joints) {
      shard_asset_desc desc = desc_of(shards, inside, 1);
      desc.joints = joints == 1;
      shard_asset* asset = must_make(&desc);
      check_asset(asset, desc.lods, desc.steps_per_metre, view.volume, 0.002);
      const uint32_t triangles = asset->lods[0].mesh.triangle_count;
      if (joints == 0 && clip == SCREE_CLIP_MESH) assert_int_equal(triangles, 12);
      if (joints == 1) assert_true(triangles > 2 * view.shard_count);
      must_free(asset);
    }
    free(inside);
    scree_shards_destroy(shards);
  }
  scree_seeds_free(NULL, seeds, count);
}

/* All sides of boxes are flat: where vertices share place and group, their triangles look the same way. */
static void groups_keep_edges_sharp(void** state) {
  (void)state;
  random_stream r = {5};
  scree_shards* shards = make_lattice((const uint32_t[3]){5, 5, 5}, 1, NULL);
  uint8_t* inside = random_inside(&r, 125, 0.6);
  const shard_asset_desc desc = desc_of(shards, inside, 1);
  shard_asset* asset = must_make(&desc);
  const lattice_mesh* mesh = &asset->lods[0].mesh;
  uint32_t most = 0;
  for (uint32_t i = 0; i < 3 * mesh->triangle_count; ++i) {
    for (uint32_t k = i + 1; k < 3 * mesh->triangle_count; ++k) {
      const uint32_t v = mesh->indices[i], w = mesh->indices[k];
      if (memcmp(mesh->positions[v], mesh->positions[w], sizeof mesh->positions[v]) != 0) continue;
      if (mesh->surface[v][3] != mesh->surface[w][3]) continue;
      double n[2][3];
      for (uint32_t side = 0; side < 2; ++side) {
        const uint32_t* c = mesh->indices + (side == 0 ? i : k) / 3 * 3;
        for (uint32_t a = 0; a < 3; ++a) {
          const uint32_t x = (a + 1) % 3, y = (a + 2) % 3;
          const int16_t *p = mesh->positions[c[0]], *q = mesh->positions[c[1]], *s = mesh->positions[c[2]];
          n[side][a] = (double)(q[x] - p[x]) * (s[y] - p[y]) - (double)(q[y] - p[y]) * (s[x] - p[x]);
        }
      }
      const double along = n[0][0] * n[1][0] + n[0][1] * n[1][1] + n[0][2] * n[1][2];
      const double both = sqrt(n[0][0] * n[0][0] + n[0][1] * n[0][1] + n[0][2] * n[0][2]) *
                          sqrt(n[1][0] * n[1][0] + n[1][1] * n[1][1] + n[1][2] * n[1][2]);
      assert_true(along > 0.999 * both);
    }
    if (mesh->surface[mesh->indices[i]][3] > most) most = mesh->surface[mesh->indices[i]][3];
  }
  assert_in_range(most, 2, 20);
  must_free(asset);
  free(inside);
  scree_shards_destroy(shards);
}

static void errors_are_what_all_triangles_say(void** state) {
  (void)state;
  random_stream r = {6};
  scree_shards* shards = make_lattice((const uint32_t[3]){7, 6, 7}, 1, NULL);
  uint8_t* inside = random_inside(&r, 7 * 6 * 7, 0.85);
  const shard_asset_desc desc = desc_of(shards, inside, 4);
  shard_asset* asset = must_make(&desc);
  const lattice_mesh* fine = &asset->lods[0].mesh;
  assert_true(asset->lods[0].mesh.error == 0.0f);
  for (uint32_t k = 1; k < 4; ++k) {
    if (asset->lods[k].mesh.triangle_count == asset->lods[k - 1].mesh.triangle_count) continue;
    const twin_mesh twin = twin_of(&asset->lods[k].mesh);
    double most = 0;
    uint32_t beyond = 0;
    for (uint32_t v = 0; v < fine->vertex_count; ++v) {
      const double p[3] = {fine->positions[v][0], fine->positions[v][1], fine->positions[v][2]};
      const double d = mesh_distance(&twin, p, 0) / desc.steps_per_metre;
      if (d > most) most = d;
      beyond += d > (double)asset->lods[k].error_of_most * (1 + 1e-5) + 1e-9;
    }
    assert_true(most <= (double)asset->lods[k].mesh.error * (1 + 1e-5) + 1e-9);
    assert_true(beyond * 20 <= fine->vertex_count);
    assert_true(asset->lods[k].error_of_most <= asset->lods[k].mesh.error);
  }
  must_free(asset);
  free(inside);
  scree_shards_destroy(shards);
}

static void blocks_lie_as_they_are_turned(void** state) {
  (void)state;
  scree_shards* shards = make_lattice((const uint32_t[3]){3, 3, 3}, 7, NULL);
  scree_shards_view view;
  scree_shards_get(shards, &view);
  uint8_t inside[27] = {0};
  inside[4] = inside[5] = 1;
  shard_asset_desc desc = desc_of(shards, inside, 2);
  desc.block = true;
  for (uint32_t a = 0; a < 3; ++a)
    desc.origin[a] = (view.shards[4].centroid[a] * view.shards[4].volume + view.shards[5].centroid[a] * view.shards[5].volume) /
                     (view.shards[4].volume + view.shards[5].volume);
  shard_asset* flat = must_make(&desc);
  desc.rotation[2] = desc.rotation[3] = sqrt(0.5); /* a quarter turn round z: x becomes y */
  shard_asset* turned = must_make(&desc);
  for (uint32_t a = 0; a < 3; ++a) assert_true(fabsf(flat->centroid[a]) < 0.001f);
  assert_true(abs(turned->bounds_max[1] - flat->bounds_max[0]) <= 1 && abs(turned->bounds_max[0] + flat->bounds_min[1]) <= 1);
  check_asset(turned, 2, desc.steps_per_metre, view.shards[4].volume + view.shards[5].volume, 0.002);
  assert_int_equal(turned->part_count, 1);
  assert_true(turned->hull_air < 0.01f);
  must_free(flat);
  must_free(turned);
  scree_shards_destroy(shards);
}

static void parts_fit_closer_than_the_hull(void** state) {
  (void)state;
  scree_shards* shards = make_lattice((const uint32_t[3]){9, 9, 9}, 0, NULL);
  uint8_t* inside = must(calloc(729, 1));
  for (uint32_t s = 0; s < 729; ++s) { /* a gate: two pillars and a beam */
    const uint32_t x = s % 9, y = s / 9 % 9;
    inside[s] = x < 2 || x > 6 || y > 6;
  }
  const shard_asset_desc desc = desc_of(shards, inside, 1);
  shard_asset* asset = must_make(&desc);
  assert_true(asset->hull_air > 0.4f);
  assert_true(asset->parts_air < 0.1f);
  assert_in_range(asset->part_count, 3, 48);
  must_free(asset);
  free(inside);
  scree_shards_destroy(shards);
}

static void what_does_not_fit_is_refused(void** state) {
  (void)state;
  scree_shards* shards = make_lattice((const uint32_t[3]){2, 2, 2}, 0, NULL);
  uint8_t inside[8] = {0};
  shard_asset asset;
  shard_asset_desc desc = desc_of(shards, inside, 1);
  assert_int_equal(shard_asset_make(&desc, NULL, &asset), SCREE_ERROR_INVALID_ARGUMENT);
  inside[3] = 1;
  desc.steps_per_metre *= 16;
  assert_int_equal(shard_asset_make(&desc, NULL, &asset), SCREE_ERROR_RANGE);
  desc.steps_per_metre = 0;
  assert_int_equal(shard_asset_make(&desc, NULL, &asset), SCREE_ERROR_INVALID_ARGUMENT);
  scree_shards_destroy(shards);
}

static void assets_repeat_to_the_bit(void** state) {
  (void)state;
  random_stream r = {9};
  scree_shards* shards = make_lattice((const uint32_t[3]){6, 6, 6}, 2, NULL);
  uint8_t* inside = random_inside(&r, 216, 0.7);
  const shard_asset_desc desc = desc_of(shards, inside, 3);
  shard_asset* asset = must_make(&desc);
  uint64_t digest = twin_digest(asset->hull, asset->hull_count * 6);
  for (uint32_t p = 0; p < asset->part_count; ++p) digest += twin_digest(asset->parts[p].hull, asset->parts[p].hull_count * 6);
  for (uint32_t k = 0; k < 3; ++k) {
    const lattice_mesh* m = &asset->lods[k].mesh;
    digest = digest * 31 + twin_digest(m->positions, m->vertex_count * 6) + twin_digest(m->surface, m->vertex_count * 4) +
             twin_digest(m->uvs, m->vertex_count * 8) + twin_digest(m->occlusion, m->vertex_count) +
             twin_digest(m->indices, m->triangle_count * 12) + twin_digest(&m->error, 4);
  }
  if (digest != UINT64_C(0xf0018273ad121234)) fail_msg("the digest is now 0x%016llx", (unsigned long long)digest);
  must_free(asset);
  free(inside);
  scree_shards_destroy(shards);
}

static void failed_allocations_leave_nothing_behind(void** state) {
  (void)state;
  scree_shards* shards = make_lattice((const uint32_t[3]){3, 2, 2}, 2, NULL);
  uint8_t inside[12] = {1, 1, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  const shard_asset_desc desc = desc_of(shards, inside, 2);
  for (int32_t fail_at = 0;; ++fail_at) {
    failing_allocator f = {.fail_at = fail_at};
    const scree_allocator allocator = failing_allocator_of(&f);
    shard_asset asset;
    const scree_result result = shard_asset_make(&desc, &allocator, &asset);
    assert_int_equal(result, f.failed ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_OK);
    shard_asset_destroy(&asset, &allocator);
    assert_int_equal(f.live, 0);
    if (!f.failed) break;
  }
  scree_shards_destroy(shards);
}

/* Real ones: Voronoi shards of a sculpted mesh, a third of them gone. */
static void what_stands_of_sculpted_meshes_is_a_sound_asset(void** state) {
  (void)state;
  static const char* const names[3] = {"elephant", "knot1", "bunny00"};
  for (uint32_t k = 0; k < 3; ++k) {
    char file[1024];
    solid_mesh mesh;
    snprintf(file, sizeof file, "%s/%s.off", folder, names[k]);
    if (!solid_read_off(file, &mesh)) {
      print_message("%s is not there: left out; ./dev fetches it\n", file);
      continue;
    }
    const scree_solid solid = {mesh.positions, mesh.indices, NULL, mesh.vertex_count, mesh.triangle_count};
    const scree_seed_pattern pattern = {.kind = SCREE_SEEDS_RANDOM, .count = 300, .random_seed = k};
    double* seeds;
    uint32_t count;
    scree_error error;
    if (scree_seeds_create(&pattern, &solid, NULL, &seeds, &count, &error) != SCREE_OK) fail_msg("%s", error.message);
    const scree_shards_desc desc = {.solid = solid, .seeds = seeds, .seed_count = count};
    scree_shards* shards;
    if (scree_shards_create(&desc, &shards, &error) != SCREE_OK) fail_msg("%s: %s", names[k], error.message);
    scree_shards_view view;
    scree_shards_get(shards, &view);
    random_stream r = {k};
    uint8_t* inside = random_inside(&r, view.shard_count, 0.67);
    shard_asset_desc of = desc_of(shards, inside, 4);
    shard_asset* asset = must_make(&of);
    check_asset(asset, 4, of.steps_per_metre, volume_inside(&view, inside), 0.005);
    assert_true(asset->lods[1].mesh.triangle_count * 2 < asset->lods[0].mesh.triangle_count);
    print_message("%s: %u shards, triangles %u %u %u %u, errors %g %g %g, %u parts, air %g of hull, %g of parts\n", names[k],
                  view.shard_count, asset->lods[0].mesh.triangle_count, asset->lods[1].mesh.triangle_count,
                  asset->lods[2].mesh.triangle_count, asset->lods[3].mesh.triangle_count, (double)asset->lods[1].error_of_most,
                  (double)asset->lods[2].error_of_most, (double)asset->lods[3].error_of_most, asset->part_count,
                  (double)asset->hull_air, (double)asset->parts_air);
    must_free(asset);
    memset(inside, 1, view.shard_count);
    of.lods = 1;
    asset = must_make(&of);
    check_asset(asset, 1, of.steps_per_metre, view.volume, 0.005);
    assert_true(asset->lods[0].mesh.triangle_count <= mesh.triangle_count);
    must_free(asset);
    free(inside);
    scree_shards_destroy(shards);
    scree_seeds_free(NULL, seeds, count);
    solid_mesh_free(&mesh);
  }
}

int main(int argc, char** argv) {
  if (argc > 1) folder = argv[1];
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_stands_of_boxes_is_a_sound_asset),
      cmocka_unit_test(groups_keep_edges_sharp),
      cmocka_unit_test(joints_split_the_triangles_of_the_solid),
      cmocka_unit_test(joints_show_on_the_solid_at_every_level),
      cmocka_unit_test(errors_are_what_all_triangles_say),
      cmocka_unit_test(blocks_lie_as_they_are_turned),
      cmocka_unit_test(parts_fit_closer_than_the_hull),
      cmocka_unit_test(what_does_not_fit_is_refused),
      cmocka_unit_test(assets_repeat_to_the_bit),
      cmocka_unit_test(failed_allocations_leave_nothing_behind),
      cmocka_unit_test(what_stands_of_sculpted_meshes_is_a_sound_asset),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
