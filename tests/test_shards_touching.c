/* Parts of a solid that touch each other, in points, along edges and face to face, are split each for itself: no shard reaches from
 * one into another, and each part's shards fill it. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* after the five above */
#include <cmocka.h>
#include <scree/shards.h>

#include "lattice.h"
#include "make_solids.h"
#include "random.h"
#include "rounds.h"

enum { MOST_PARTS = 27, SEEDS = 40 };

typedef struct parts {
  solid_mesh mesh;
  double min[MOST_PARTS][3], max[MOST_PARTS][3];
  uint32_t count;
} parts;

static void add_part(parts* p, const double min[3], const double max[3]) {
  const double zero[3] = {0, 0, 0};
  box_solid box;
  make_box(&box, min, max);
  const solid_mesh more = {box.positions, box.indices, 8, 12};
  solid_add(&p->mesh, &more, zero, 1);
  memcpy(p->min[p->count], min, 3 * sizeof *min);
  memcpy(p->max[p->count++], max, 3 * sizeof *max);
}

static bool is_inside(const parts* p, uint32_t part, const double at[3], double slack) {
  for (int a = 0; a < 3; ++a)
    if (at[a] < p->min[part][a] - slack || at[a] > p->max[part][a] + slack) return false;
  return true;
}

/* Each shard is in one part, with all its corners, and the parts are full. Returns how often seeds had to be moved. */
static uint32_t check_split(const parts* p, const scree_shards_desc* desc) {
  scree_error error;
  scree_shards* shards;
  assert_int_equal(scree_solid_check(&desc->solid, NULL, &error), SCREE_OK);
  if (scree_shards_create(desc, &shards, &error) != SCREE_OK) fail_msg("%s", error.message);
  scree_shards_view view;
  scree_shards_get(shards, &view);
  double filled[MOST_PARTS] = {0};
  for (uint32_t s = 0; s < view.shard_count; ++s) {
    uint32_t part = 0;
    while (part < p->count && !is_inside(p, part, view.shards[s].centroid, 0)) ++part;
    assert_in_range(part, 0, p->count - 1);
    filled[part] += view.shards[s].volume;
    for (uint32_t l = 0; l < view.shards[s].link_count; ++l) {
      const scree_link* link = &view.links[view.shard_links[view.shards[s].first_link + l]];
      for (uint32_t k = link->first_polygon; k < link->first_polygon + link->polygon_count; ++k)
        for (uint32_t c = 0; c < view.polygons[k].corner_count; ++c)
          assert_true(is_inside(p, part, view.vertices + 3 * (size_t)view.corners[view.polygons[k].first_corner + c], 1e-9));
    }
  }
  for (uint32_t part = 0; part < p->count; ++part) {
    double volume = 1;
    for (int a = 0; a < 3; ++a) volume *= p->max[part][a] - p->min[part][a];
    assert_true(fabs(filled[part] - volume) <= 1e-9 * volume);
  }
  const uint32_t attempts = view.attempts;
  scree_shards_destroy(shards);
  return attempts;
}

/* Cells of a lattice, each a box of its own: they meet in every way that boxes of one size can. In every second round distances are
 * measured in a space that is turned and stretched, where what was in one plane is so only to the last bits. */
static void boxes_of_a_lattice_are_split_each_for_itself(void** state) {
  (void)state;
  random_stream r = {11};
  uint32_t touching = 0, moved = 0;
  for (uint32_t round = 0; round < ROUNDS(1000, 50); ++round) {
    parts p = {0};
    bool there[27];
    for (uint32_t i = 0; i < 27; ++i) {
      const double min[3] = {i % 3, i / 3 % 3, i / 9}, max[3] = {min[0] + 1, min[1] + 1, min[2] + 1};
      there[i] = random_unit(&r) < 0.4;
      if (!there[i]) continue;
      add_part(&p, min, max);
      touching += (i % 3 > 0 && there[i - 1]) + (i / 3 % 3 > 0 && there[i - 3]) + (i / 9 > 0 && there[i - 9]);
    }
    if (p.count == 0) continue;
    double seeds[3 * SEEDS];
    for (uint32_t i = 0; i < 3 * SEEDS; ++i) seeds[i] = 3 * random_unit(&r);
    const double up[3] = {random_unit(&r), 1, random_unit(&r)}, stretch[3] = {1, 2, 0.5};
    scree_shards_desc desc = {.solid = {.positions = p.mesh.positions,
                                        .indices = p.mesh.indices,
                                        .vertex_count = p.mesh.vertex_count,
                                        .triangle_count = p.mesh.triangle_count},
                              .seeds = seeds,
                              .seed_count = SEEDS};
    if (round % 2 == 1) desc.up = up, desc.stretch = stretch;
    moved += check_split(&p, &desc);
    solid_mesh_free(&p.mesh);
  }
  assert_in_range(touching, ROUNDS(5000, 50), 100000);
  assert_in_range(moved, 0, ROUNDS(100, 50));
}

/* Faces of different sizes: a stone on a slab, one within the face of another, one that stands over its edge. */
static void a_stone_on_a_slab_is_split_for_itself(void** state) {
  (void)state;
  random_stream r = {12};
  for (uint32_t round = 0; round < ROUNDS(600, 50); ++round) {
    parts p = {0};
    add_part(&p, (const double[3]){-2, -1, -2}, (const double[3]){2, 0, 2});
    double min[3] = {-2.5 + 3 * random_unit(&r), 0, -2.5 + 3 * random_unit(&r)};
    if (round % 3 == 0) min[0] = min[2] = -0.5;
    if (round % 3 == 1) min[0] = -2;
    add_part(&p, min, (const double[3]){min[0] + 1.5, 1 + random_unit(&r), min[2] + 1.5});
    double seeds[3 * SEEDS];
    for (uint32_t i = 0; i < 3 * SEEDS; ++i) seeds[i] = (i % 3 == 1 ? 3 : 5) * (random_unit(&r) - 0.5);
    const scree_shards_desc desc = {.solid = {.positions = p.mesh.positions,
                                              .indices = p.mesh.indices,
                                              .vertex_count = p.mesh.vertex_count,
                                              .triangle_count = p.mesh.triangle_count},
                                    .seeds = seeds,
                                    .seed_count = SEEDS};
    check_split(&p, &desc);
    solid_mesh_free(&p.mesh);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(boxes_of_a_lattice_are_split_each_for_itself),
      cmocka_unit_test(a_stone_on_a_slab_is_split_for_itself),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
