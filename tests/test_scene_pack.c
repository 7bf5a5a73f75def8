/* Scenes of baked rocks: rays through a big pile, hulls, and deltas that know their pack. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <scree/bake.h>

#include "scene_spatial.h"
#include "synthetic_field.h"

typedef struct pile {
  uint8_t* bytes;
  size_t size;
  scree_pack* pack;
  scree_field* field;
  scree_support* support;
  scree_scene* scene;
  scree_scratch* scratch;
  double centre[3];
} pile;

static pile world;

/* A small set of stones, as content/golden/small.json has it; `seed` makes other stones. */
static void bake(pile* p, uint64_t seed) {
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  recipe.n = 4;
  recipe.voxels_per_cell = 6;
  recipe.lod_levels = 2;
  recipe.proxies = false;
  recipe.random_seed = seed;
  scree_bake_report report = {0};
  const scree_bake_desc desc = {.recipe = &recipe};
  assert_int_equal(scree_bake_rocks(&desc, &p->bytes, &p->size, &report, NULL), SCREE_OK);
  assert_int_equal(scree_pack_open_memory(p->bytes, p->size, NULL, &p->pack), SCREE_OK);
}

static void make_field(pile* p) {
  scree_field_desc desc = {.pack = p->pack, .seed = 2009, .cell_size = 0.4, .origin = {1e5, 0.1, -1e5}};
  assert_int_equal(scree_field_create(&desc, NULL, &p->field), SCREE_OK);
}

static void make_scene(pile* p) {
  const scree_layer layer = {.field = p->field, .support = p->support, .key = 5};
  assert_int_equal(scree_scene_create(&(scree_scene_desc){&layer, 1}, NULL, &p->scene, NULL), SCREE_OK);
}

static int make_pile(void** state) {
  (void)state;
  pile* p = &world;
  bake(p, 1);
  make_field(p);
  /* A heap with a hole through it: 30 m wide, 8 m high. */
  const uint32_t parts[2] = {1, 2};
  const scree_shape shapes[3] = {
      {.kind = SCREE_SHAPE_DIFFERENCE, .group = {.children = parts, .child_count = 2}},
      {.kind = SCREE_SHAPE_CONE, .cone = {15, 8}},
      {.kind = SCREE_SHAPE_CAPSULE, .capsule = {{-20, 1, 0}, {20, 1, 0}, 1.5f}},
  };
  scree_support_desc desc = {.shapes = shapes, .shape_count = 3, .origin = {1e5 + 3, 2, -1e5 + 1}};
  memcpy(p->centre, desc.origin, sizeof p->centre);
  assert_int_equal(scree_support_create(&desc, NULL, &p->support, NULL), SCREE_OK);
  make_scene(p);
  assert_int_equal(scree_scratch_create(NULL, &p->scratch), SCREE_OK);
  return 0;
}

static int free_pile(void** state) {
  (void)state;
  pile* p = &world;
  scree_scratch_destroy(p->scratch);
  scree_scene_destroy(p->scene);
  scree_support_destroy(p->support);
  scree_field_destroy(p->field);
  scree_pack_close(p->pack);
  scree_bake_free(&(scree_bake_desc){0}, p->bytes, p->size);
  return 0;
}

static void rays_through_a_big_pile_hit_the_nearest_of_all_rocks(void** state) {
  (void)state;
  const pile* p = &world;
  const scene_layer* layer = &p->scene->layers[0];
  scree_scene_query_desc all = {.scene = p->scene};
  uint64_t count;
  assert_int_equal(scree_scene_count(&all, p->scratch, &count), SCREE_OK);
  assert_true(count > 20000);
  scree_rock* rocks = malloc((size_t)count * sizeof *rocks);
  random_stream r = {1};
  int hits = 0, misses = 0;
  for (int i = 0; i < 80; ++i) {
    const double away = i % 4 == 0 ? 2000 : i % 4 == 1 ? 4 : 30;
    double along[3], length2 = 0, best = 1e6, best_normal[3] = {0, 0, 0};
    for (int a = 0; a < 3; ++a) all.origin[a] = p->centre[a] + random_in(&r, -away, away);
    for (int a = 0; a < 3; ++a) {
      along[a] = p->centre[a] + random_in(&r, -10, 10) - all.origin[a];
      length2 += along[a] * along[a];
    }
    for (int a = 0; a < 3; ++a) along[a] /= sqrt(length2);
    assert_int_equal(scree_scene_fill(&all, p->scratch, rocks, count, &count), SCREE_OK);
    const scree_rock* first = NULL;
    for (uint64_t k = 0; k < count; ++k) {
      spatial_hull hull;
      double t, normal[3];
      const spatial_place place = scree_rt_spatial_place(layer, &rocks[k], all.origin);
      const double* c = place.centroid;
      const double middle = c[0] * along[0] + c[1] * along[1] + c[2] * along[2];
      if (c[0] * c[0] + c[1] * c[1] + c[2] * c[2] - middle * middle > place.radius * place.radius * 2) continue;
      assert_true(scree_rt_spatial_hull(layer, rocks[k].asset, place.home, &hull));
      if (!scree_rt_convex_ray(&hull.hull, (const double[3]){0, 0, 0}, along, 1e6, &t, normal)) continue;
      if (t > best || (t == best && first != NULL && scree_rt_edits_compare(&first->id, &rocks[k].id) < 0)) continue;
      best = t;
      first = &rocks[k];
      memcpy(best_normal, normal, sizeof normal);
    }
    bool found;
    scree_hit hit;
    assert_int_equal(scree_scene_ray_cast(p->scene, NULL, p->scratch, all.origin, along, 1e6, &found, &hit), SCREE_OK);
    assert_int_equal(found, first != NULL);
    hits += found;
    misses += !found;
    if (!found) continue;
    assert_memory_equal(&hit.rock, first, sizeof *first);
    assert_true(fabs(hit.distance - best) <= 1e-9 * best); /* the library's unit vector is rounded once more */
    double against = 0;
    for (int a = 0; a < 3; ++a) {
      against += (double)hit.normal[a] * along[a];
      assert_true(fabs((double)hit.normal[a] - best_normal[a]) < 1e-4);
    }
    assert_true(against < 0);
  }
  assert_true(hits > 40 && misses > 2);
  free(rocks);
}

static void hulls_are_those_of_the_pack_in_metres(void** state) {
  (void)state;
  const pile* p = &world;
  scree_pack_info info;
  scree_pack_get_info(p->pack, &info);
  for (uint32_t asset = 0; asset < info.asset_count; asset += 31) {
    int16_t steps[3 * 64];
    float metres[3 * 64];
    uint32_t count, same;
    assert_int_equal(scree_pack_get_hull(p->pack, asset, steps, 64, &count), SCREE_OK);
    assert_int_equal(scree_scene_hull(p->scene, 0, asset, metres, 64, &same), SCREE_OK);
    assert_int_equal(count, same);
    for (uint32_t i = 0; i < 3 * count; ++i) assert_true(fabs((double)metres[i] - steps[i] * 0.4 / info.lattice_per_cell) < 1e-6);
  }
}

static void edits_of_another_pack_are_stale(void** state) {
  (void)state;
  pile other = {.support = world.support};
  bake(&other, 2);
  make_field(&other);
  make_scene(&other);
  scree_edits *edits, *loaded;
  assert_int_equal(scree_edits_create(NULL, &edits), SCREE_OK);
  assert_int_equal(scree_edits_create(NULL, &loaded), SCREE_OK);
  scree_rock rock;
  scree_scene_query_desc all = {.scene = world.scene};
  uint64_t count;
  assert_int_equal(scree_scene_fill(&all, world.scratch, &rock, 1, &count), SCREE_ERROR_CAPACITY);
  assert_int_equal(scree_edits_set(edits, &rock.id, SCREE_EDIT_REMOVE), SCREE_OK);
  uint8_t bytes[256];
  size_t size;
  assert_int_equal(scree_edits_save(edits, world.scene, bytes, sizeof bytes, &size), SCREE_OK);
  scree_edits_report report;
  assert_int_equal(scree_edits_load(loaded, other.scene, bytes, size, &report), SCREE_OK);
  assert_int_equal(report.stale, 1);
  assert_int_equal(scree_edits_count(loaded), 0);
  assert_int_equal(scree_edits_load(loaded, world.scene, bytes, size, &report), SCREE_OK);
  assert_int_equal(report.applied, 1);
  scree_edits_destroy(edits);
  scree_edits_destroy(loaded);
  scree_scene_destroy(other.scene);
  scree_field_destroy(other.field);
  scree_pack_close(other.pack);
  scree_bake_free(&(scree_bake_desc){0}, other.bytes, other.size);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rays_through_a_big_pile_hit_the_nearest_of_all_rocks),
      cmocka_unit_test(hulls_are_those_of_the_pack_in_metres),
      cmocka_unit_test(edits_of_another_pack_are_stale),
  };
  return cmocka_run_group_tests(tests, make_pile, free_pile);
}
