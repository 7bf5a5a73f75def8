/* Shards of solids that walls cut, and what joins polygons into shards. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <scree/shards.h>

#include "convex_solids.h"
#include "failing_allocator.h"
#ifdef SCREE_VORO
#include "voro_cells.h"
#endif

static const double UNIT[3] = {1, 1, 1}, ZERO[3] = {0, 0, 0};

/* Where hills and their seeds are. */
static const double HILL_MIN[3] = {-1.1, -0.1, -1.1}, HILL_MAX[3] = {1.1, 1, 1.1};

static scree_shards_desc desc_of(const convex_solid* solid, const double* seeds, uint32_t count) {
  /* An angle below all that walls turn by: each wall of a shard is a link. */
  return (scree_shards_desc){.solid = solid->solid, .seeds = seeds, .seed_count = count, .link_angle = 1e-3};
}

static scree_shards* must_make(const scree_shards_desc* desc) {
  scree_shards* shards = NULL;
  scree_error error = {{0}};
  const scree_result result = scree_shards_create(desc, &shards, &error);
  if (result != SCREE_OK) print_error("%s: %s\n", scree_result_string(result), error.message);
  assert_int_equal(result, SCREE_OK);
  return shards;
}

static double* seeds_in(uint64_t random_seed, const convex_solid* solid, bool hill, uint32_t count) {
  double* seeds = malloc(3 * (size_t)count * sizeof *seeds);
  assert_non_null(seeds);
  if (hill)
    lay_seeds(random_seed, HILL_MIN, HILL_MAX, solid->planes, HILL_PLANES, count, seeds);
  else
    lay_seeds(random_seed, ZERO, solid->positions + 3 * 7, NULL, 0, count, seeds);
  return seeds;
}

/* --- Voro++ --- */

#ifdef SCREE_VORO
/* The plane of the solid that an exterior link lies in, named as Voro++'s. */
static uint32_t wall_of(const convex_solid* solid, bool hill, const scree_link* link) {
  if (!hill) {
    for (uint32_t axis = 0; axis < 3; ++axis)
      if (fabs(link->normal[axis]) > 0.5) return VORO_WALL + 2 * axis + (link->normal[axis] > 0);
  } else
    for (uint32_t k = 0; k < HILL_PLANES; ++k) {
      const double* n = solid->planes[k];
      if (n[0] * link->normal[0] + n[1] * link->normal[1] + n[2] * link->normal[2] > 1 - 1e-9) return VORO_WALL + 6 + k;
    }
  fail_msg("an exterior link lies in no plane of the solid");
  return 0;
}

static int by_number(const void* a, const void* b) {
  const uint32_t x = *(const uint32_t*)a, y = *(const uint32_t*)b;
  return x < y ? -1 : x > y;
}

static void hold_against_voro(const convex_solid* solid, bool hill, uint32_t count, uint64_t random_seed) {
  double* seeds = seeds_in(random_seed, solid, hill, count);
  scree_shards_desc desc = desc_of(solid, seeds, count);
  scree_shards* shards = must_make(&desc);
  scree_shards_view view;
  scree_shards_get(shards, &view);
  assert_int_equal(view.clip, SCREE_CLIP_WALLS);
  assert_int_equal(view.attempts, 0);
  assert_int_equal(view.shard_count, count);
  voro_cells cells;
  voro_cells_make(hill ? HILL_MIN : ZERO, hill ? HILL_MAX : solid->positions + 3 * 7, hill ? solid->planes : NULL,
                  hill ? HILL_PLANES : 0, seeds, count, &cells);
  uint32_t* found = malloc((count + 100) * sizeof *found);
  for (uint32_t i = 0; i < count; ++i) {
    const scree_shard* shard = view.shards + i;
    assert_int_equal(shard->seed, i);
    assert_true(fabs(shard->volume - cells.volumes[i]) <= 1e-12 * cells.volumes[i]);
    const uint32_t faces = cells.neighbour_first[i + 1] - cells.neighbour_first[i];
    assert_int_equal(shard->link_count, faces);
    for (uint32_t k = 0; k < faces; ++k) {
      const scree_link* link = view.links + view.shard_links[shard->first_link + k];
      found[k] =
          link->shards[1] == SCREE_NO_SHARD ? wall_of(solid, hill, link) : view.shards[link->shards[link->shards[0] == i]].seed;
    }
    qsort(found, faces, sizeof *found, by_number);
    assert_memory_equal(found, cells.neighbours + cells.neighbour_first[i], faces * sizeof *found);
  }
  free(found);
  voro_cells_free(&cells);
  scree_shards_destroy(shards);
  free(seeds);
}
#endif

static void cells_of_a_box_are_those_of_voro(void** state) {
  (void)state;
#ifdef SCREE_VORO
  static const uint32_t counts[] = {1, 2, 3, 10, 100, 1000, 3000};
  static convex_solid box;
  for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i)
    for (uint64_t k = 0; k < 3; ++k) {
      const double size[3] = {k == 1 ? 7 : 1, 1, k == 2 ? 0.1 : 1};
      make_convex_box(&box, size);
      hold_against_voro(&box, false, counts[i], 100 * i + k);
    }
#else
  print_message("skipped: Voro++ is missing\n");
  skip();
#endif
}

static void cells_of_a_convex_hill_are_those_of_voro(void** state) {
  (void)state;
#ifdef SCREE_VORO
  static const uint32_t counts[] = {1, 5, 50, 500, 2908};
  static convex_solid hill;
  make_hill(&hill);
  for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i) hold_against_voro(&hill, true, counts[i], i);
#else
  print_message("skipped: Voro++ is missing\n");
  skip();
#endif
}

/* --- what is promised of every set of shards --- */

static bool polygon_has_edge(const scree_shards_view* view, const scree_link* link, uint32_t a, uint32_t b) {
  for (uint32_t p = 0; p < link->polygon_count; ++p) {
    const scree_polygon* polygon = view->polygons + link->first_polygon + p;
    const uint32_t* corners = view->corners + polygon->first_corner;
    for (uint32_t i = 0; i < polygon->corner_count; ++i) {
      const uint32_t from = corners[i], to = corners[(i + 1) % polygon->corner_count];
      if ((from == a && to == b) || (from == b && to == a)) return true;
    }
  }
  return false;
}

static bool links_share_an_edge(const scree_shards_view* view, uint32_t a, uint32_t b) {
  const scree_link* link = view->links + a;
  for (uint32_t p = 0; p < link->polygon_count; ++p) {
    const scree_polygon* polygon = view->polygons + link->first_polygon + p;
    const uint32_t* corners = view->corners + polygon->first_corner;
    for (uint32_t i = 0; i < polygon->corner_count; ++i)
      if (polygon_has_edge(view, view->links + b, corners[i], corners[(i + 1) % polygon->corner_count])) return true;
  }
  return false;
}

static bool link_is_of(const scree_link* link, uint32_t shard) {
  return link->shards[0] == shard || link->shards[1] == shard;
}

static void check_order(const scree_shards_view* view) {
  uint32_t sides = 0, polygons = 0;
  for (uint32_t i = 0; i < view->link_count; ++i) {
    const scree_link* link = view->links + i;
    assert_true((i < view->interior_link_count) == (link->shards[1] != SCREE_NO_SHARD));
    assert_true(link->shards[0] < link->shards[1]);
    assert_int_equal(link->first_polygon, polygons);
    polygons += link->polygon_count;
    assert_true(link->polygon_count > 0);
    if (i > 0 && i != view->interior_link_count) {
      const scree_link* before = link - 1;
      assert_true(before->shards[0] < link->shards[0] ||
                  (before->shards[0] == link->shards[0] && before->shards[1] <= link->shards[1]));
    }
    const double* n = link->normal;
    assert_true(fabs(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1) < 1e-12);
  }
  assert_int_equal(polygons, view->polygon_count);
  for (uint32_t i = 0; i < view->shard_count; ++i) {
    const scree_shard* shard = view->shards + i;
    assert_int_equal(shard->first_link, sides);
    assert_true(i == 0 || shard[-1].seed <= shard->seed);
    sides += shard->link_count;
    for (uint32_t k = 0; k < shard->link_count; ++k) {
      assert_true(link_is_of(view->links + view->shard_links[shard->first_link + k], i));
      assert_true(k == 0 || view->shard_links[shard->first_link + k - 1] < view->shard_links[shard->first_link + k]);
    }
  }
  assert_int_equal(sides, view->link_count + view->interior_link_count);
}

/* Closed, and as large as the links say. */
static void check_shards(const scree_shards_view* view, double volume) {
  double sum = 0, areas = 0;
  for (uint32_t i = 0; i < view->shard_count; ++i) {
    const scree_shard* shard = view->shards + i;
    double open[3] = {0}, area = 0;
    assert_true(shard->volume > 0);
    for (uint32_t k = 0; k < shard->link_count; ++k) {
      const scree_link* link = view->links + view->shard_links[shard->first_link + k];
      const double side = link->shards[0] == i ? 1 : -1;
      /* An exterior link's normal is that of its area vector, which is shorter than its area where it bends: by its polygons. */
      for (uint32_t p = 0; p < link->polygon_count; ++p) {
        const scree_polygon* polygon = view->polygons + link->first_polygon + p;
        const uint32_t* corners = view->corners + polygon->first_corner;
        const double* o = view->vertices + 3 * (size_t)corners[0];
        for (uint32_t c = 2; c < polygon->corner_count; ++c) {
          const double *a = view->vertices + 3 * (size_t)corners[c - 1], *b = view->vertices + 3 * (size_t)corners[c];
          for (int axis = 0; axis < 3; ++axis) {
            const int y = (axis + 1) % 3, z = (axis + 2) % 3;
            open[axis] += side / 2 * ((a[y] - o[y]) * (b[z] - o[z]) - (a[z] - o[z]) * (b[y] - o[y]));
          }
        }
      }
      area += link->area;
    }
    assert_true(sqrt(open[0] * open[0] + open[1] * open[1] + open[2] * open[2]) <= 1e-9 * area);
    areas += area;
    sum += shard->volume;
  }
  assert_true(fabs(sum - volume) <= 1e-9 * volume);
  assert_true(fabs(view->volume - sum) <= 1e-12 * sum);
  assert_true(fabs(view->mean_link_area * (view->link_count + view->interior_link_count) - areas) <= 1e-9 * areas);
}

/* Links are neighbours where polygons of them have an edge of a shard in common. */
static void check_neighbours(const scree_shards_view* view) {
  unsigned char* is_near = calloc(view->link_count, 1);
  for (uint32_t a = 0; a < view->link_count; ++a) {
    memset(is_near, 0, view->link_count);
    for (int side = 0; side < 2; ++side) {
      const uint32_t id = view->links[a].shards[side];
      for (uint32_t k = 0; id != SCREE_NO_SHARD && k < view->shards[id].link_count; ++k) {
        const uint32_t b = view->shard_links[view->shards[id].first_link + k];
        if (b != a && links_share_an_edge(view, a, b)) is_near[b] = 1;
      }
    }
    uint32_t count = 0, before = 0;
    for (uint32_t b = 0; b < view->link_count; ++b) count += is_near[b];
    assert_int_equal(view->neighbour_first[a + 1] - view->neighbour_first[a], count);
    for (uint32_t k = view->neighbour_first[a]; k < view->neighbour_first[a + 1]; ++k) {
      assert_true(is_near[view->neighbours[k]]);
      assert_true(k == view->neighbour_first[a] || before < view->neighbours[k]);
      before = view->neighbours[k];
    }
  }
  free(is_near);
}

static void check_all(const scree_shards* shards, double volume) {
  scree_shards_view view;
  scree_shards_get(shards, &view);
  check_order(&view);
  check_shards(&view, volume);
  check_neighbours(&view);
}

static void shards_keep_their_promises(void** state) {
  (void)state;
  static convex_solid solid;
  for (uint32_t k = 0; k < 6; ++k) {
    make_convex_box(&solid, UNIT);
    if (k % 2 == 1) make_hill(&solid);
    double* seeds = seeds_in(k, &solid, k % 2 == 1, 20 + 100 * k);
    scree_shards_desc desc = desc_of(&solid, seeds, 20 + 100 * k);
    if (k >= 2) desc.link_angle = 0;
    scree_shards* shards = must_make(&desc);
    scree_shards_view view;
    scree_shards_get(shards, &view);
    check_all(shards, view.volume);
    if (k % 2 == 0) assert_true(fabs(view.volume - 1) <= 1e-12);
    scree_shards_destroy(shards);
    free(seeds);
  }
}

/* --- exterior links --- */

static void stretches_of_surface_that_turn_little_are_one_link(void** state) {
  (void)state;
  static convex_solid hill;
  make_hill(&hill);
  const double seed[3] = {0, 0.4, 0};
  scree_shards_desc desc = desc_of(&hill, seed, 1);
  desc.link_angle = 0.27; /* sides of a ring turn by less than 15 degrees, 0.262 */
  scree_shards* shards = must_make(&desc);
  scree_shards_view view;
  scree_shards_get(shards, &view);
  /* The three rings, which turn by 0.34 at the least from one to the next, top and base. */
  assert_int_equal(view.link_count, 5);
  scree_shards_destroy(shards);
  desc.link_angle = 1e-3;
  shards = must_make(&desc);
  scree_shards_get(shards, &view);
  assert_int_equal(view.link_count, HILL_PLANES);
  scree_shards_destroy(shards);
}

/* --- seeds that do not go --- */

static void a_regular_grid_of_seeds_works(void** state) {
  (void)state;
  static convex_solid box;
  make_convex_box(&box, UNIT);
  double seeds[3 * 125];
  for (uint32_t i = 0; i < 125; ++i) {
    seeds[3 * i] = (i % 5 + 0.5) / 5;
    seeds[3 * i + 1] = (i / 5 % 5 + 0.5) / 5;
    seeds[3 * i + 2] = (i / 25 + 0.5) / 5;
  }
  scree_shards_desc desc = desc_of(&box, seeds, 125);
  scree_shards* shards = must_make(&desc);
  scree_shards_view view;
  scree_shards_get(shards, &view);
  assert_int_equal(view.attempts, 1);
  assert_int_equal(view.shard_count, 125);
  for (uint32_t i = 0; i < 125; ++i) assert_true(fabs(view.shards[i].volume * 125 - 1) < 1e-4);
  check_all(shards, 1);
  scree_shards_destroy(shards);
}

static void seeds_in_one_place_are_moved_apart(void** state) {
  (void)state;
  static convex_solid box;
  make_convex_box(&box, UNIT);
  double* seeds = seeds_in(5, &box, false, 50);
  for (uint32_t i = 0; i < 10; ++i) memcpy(seeds + 3 * (20 + i), seeds + 3 * i, 3 * sizeof *seeds);
  scree_shards_desc desc = desc_of(&box, seeds, 50);
  scree_shards* shards = must_make(&desc);
  scree_shards_view view;
  scree_shards_get(shards, &view);
  assert_true(view.attempts > 0);
  assert_int_equal(view.shard_count, 50);
  check_all(shards, 1);
  scree_shards_destroy(shards);
  free(seeds);
}

/* Moved by a millionth they are slivers, which rounding cannot always tell apart: then they are moved farther. */
static void many_seeds_in_one_place_are_moved_apart(void** state) {
  (void)state;
  static convex_solid box;
  make_convex_box(&box, UNIT);
  for (uint32_t count = 4; count <= 16; count += 4)
    for (uint32_t place = 0; place < 6; ++place)
      for (int mesh = 0; mesh < 2; ++mesh) {
        double seeds[3 * 17] = {0.75, 0.5, 0.25};
        for (uint32_t i = 1; i <= count; ++i) {
          const double at[3] = {0.25, 0.125 + 0.125 * place, 0.375};
          memcpy(seeds + 3 * i, at, sizeof at);
        }
        scree_shards_desc desc = desc_of(&box, seeds, count + 1);
        if (mesh) desc.clip = SCREE_CLIP_MESH;
        scree_shards* shards = must_make(&desc);
        scree_shards_view view;
        scree_shards_get(shards, &view);
        assert_true(view.attempts > 0);
        assert_true(fabs(view.volume - 1) < 1e-9);
        scree_shards_destroy(shards);
      }
}

static void seeds_whose_cell_misses_the_solid_have_no_shard(void** state) {
  (void)state;
  static convex_solid box;
  make_convex_box(&box, UNIT);
  double seeds[3 * 40];
  lay_seeds(3, ZERO, UNIT, NULL, 0, 20, seeds);
  static const double far_min[3] = {3, 3, 3}, far_max[3] = {4, 4, 4};
  lay_seeds(4, far_min, far_max, NULL, 0, 20, seeds + 60);
  scree_shards_desc desc = desc_of(&box, seeds, 40);
  scree_shards* shards = must_make(&desc);
  scree_shards_view view;
  scree_shards_get(shards, &view);
  assert_int_equal(view.shard_count, 20);
  check_all(shards, 1);
  scree_shards_destroy(shards);
}

/* --- distances --- */

/* Convex shards: a point is in the one none of whose links has it outside. */
static uint32_t seed_around(const scree_shards_view* view, const double p[3]) {
  for (uint32_t i = 0; i < view->shard_count; ++i) {
    const scree_shard* shard = view->shards + i;
    uint32_t k = 0;
    for (; k < shard->link_count; ++k) {
      const scree_link* link = view->links + view->shard_links[shard->first_link + k];
      const double side = link->shards[0] == i ? 1 : -1;
      double out = 0;
      for (int axis = 0; axis < 3; ++axis) out += side * link->normal[axis] * (p[axis] - link->centroid[axis]);
      if (out > 0) break;
    }
    if (k == shard->link_count) return shard->seed;
  }
  return UINT32_MAX;
}

static void stretched_cells_are_nearest_by_stretched_distance(void** state) {
  (void)state;
  static convex_solid box;
  make_convex_box(&box, UNIT);
  double* seeds = seeds_in(8, &box, false, 60);
  scree_shards_desc desc = desc_of(&box, seeds, 60);
  /* +Y lies along +X: the pattern's own y is the solid's x, its x the solid's -y. */
  static const double stretch[3] = {1, 4, 0.5}, up[3] = {2, 0, 0};
  desc.stretch = stretch;
  desc.up = up;
  scree_shards* shards = must_make(&desc);
  check_all(shards, 1);
  scree_shards_view view;
  scree_shards_get(shards, &view);
  random_stream stream = {.state = 1};
  for (uint32_t k = 0; k < 2000; ++k) {
    const double p[3] = {random_unit(&stream), random_unit(&stream), random_unit(&stream)};
    uint32_t best = 0;
    double least = INFINITY;
    for (uint32_t i = 0; i < 60; ++i) {
      const double dx = (p[0] - seeds[3 * i]) / 4, dy = p[1] - seeds[3 * i + 1], dz = (p[2] - seeds[3 * i + 2]) / 0.5;
      const double d = dx * dx + dy * dy + dz * dz;
      if (d < least) least = d, best = i;
    }
    assert_int_equal(seed_around(&view, p), best);
  }
  scree_shards_destroy(shards);
  free(seeds);
}

/* --- solids that are not convex: what joins polygons --- */

/* Boxes as one solid: each of `count` from low to high, inside out where `hollow` says so. */
static void make_boxes(const double (*low)[3], const double (*high)[3], const bool* hollow, uint32_t count, double* positions,
                       uint32_t* indices, scree_solid* out) {
  static convex_solid box;
  make_convex_box(&box, UNIT);
  for (uint32_t b = 0; b < count; ++b)
    for (uint32_t i = 0; i < 8; ++i)
      for (uint32_t axis = 0; axis < 3; ++axis) positions[24 * b + 3 * i + axis] = (i >> axis & 1) ? high[b][axis] : low[b][axis];
  for (uint32_t b = 0; b < count; ++b)
    for (uint32_t i = 0; i < 36; ++i) indices[36 * b + i] = 8 * b + box.indices[hollow[b] && i % 3 > 0 ? i - i % 3 + 3 - i % 3 : i];
  *out = (scree_solid){.positions = positions, .indices = indices, .vertex_count = 8 * count, .triangle_count = 12 * count};
}

static void a_cell_that_falls_apart_is_several_shards(void** state) {
  (void)state;
  static const double low[2][3] = {{0, 0, 0}, {2, 0, 0}}, high[2][3] = {{1, 1, 1}, {3, 1, 2}};
  static const bool hollow[2] = {false, false};
  double positions[48];
  uint32_t indices[72];
  convex_solid boxes;
  make_boxes(low, high, hollow, 2, positions, indices, &boxes.solid);
  static const double seed[3] = {1.4, 0.3, 0.2};
  scree_shards_desc desc = desc_of(&boxes, seed, 1);
  scree_shards* shards = must_make(&desc);
  scree_shards_view view;
  scree_shards_get(shards, &view);
  assert_int_equal(view.clip, SCREE_CLIP_MESH);
  assert_int_equal(view.shard_count, 2);
  assert_true(fabs(view.shards[0].volume - 1) < 1e-12 && fabs(view.shards[1].volume - 2) < 1e-12);
  check_all(shards, 3);
  scree_shards_destroy(shards);
}

static void a_hollow_belongs_to_the_shard_around_it(void** state) {
  (void)state;
  static const double low[3][3] = {{0, 0, 0}, {2, 0, 0}, {0.25, 0.25, 0.25}},
                      high[3][3] = {{1, 1, 1}, {4, 2, 2}, {0.75, 0.75, 0.75}};
  static const bool hollow[3] = {false, false, true};
  double positions[72];
  uint32_t indices[108];
  convex_solid boxes;
  make_boxes(low, high, hollow, 3, positions, indices, &boxes.solid);
  static const double seed[3] = {1.4, 0.3, 0.2};
  scree_shards_desc desc = desc_of(&boxes, seed, 1);
  scree_shards* shards = must_make(&desc);
  scree_shards_view view;
  scree_shards_get(shards, &view);
  assert_int_equal(view.shard_count, 2);
  assert_true(fabs(view.shards[0].volume - 0.875) < 1e-12);
  assert_true(fabs(view.shards[1].volume - 8) < 1e-12);
  assert_int_equal(view.shards[0].link_count, 12);
  check_all(shards, 8.875);
  scree_shards_destroy(shards);
}

/* --- repeating --- */

/* Backwards, on four workers. */
static void run_backwards(void* user, uint32_t count, void (*run)(void* context, uint32_t index, uint32_t worker), void* context) {
  (void)user;
  for (uint32_t i = count; i-- > 0;) run(context, i, i % 4);
}

static void shards_do_not_depend_on_jobs(void** state) {
  (void)state;
  static convex_solid hill;
  make_hill(&hill);
  double* seeds = seeds_in(12, &hill, true, 700);
  scree_shards_desc desc = desc_of(&hill, seeds, 700);
  scree_shards* alone = must_make(&desc);
  desc.jobs = (scree_jobs){run_backwards, 4, NULL};
  scree_shards* shared = must_make(&desc);
  assert_true(scree_shards_digest(alone) == scree_shards_digest(shared));
  scree_shards_destroy(alone);
  scree_shards_destroy(shared);
  free(seeds);
}

static void digest_is_golden(void** state) {
  (void)state;
  static const uint64_t GOLDEN = UINT64_C(0xb3c5058461097678);
  static convex_solid hill;
  make_hill(&hill);
  double* seeds = seeds_in(77, &hill, true, 300);
  scree_shards_desc desc = desc_of(&hill, seeds, 300);
  scree_shards* shards = must_make(&desc);
  if (scree_shards_digest(shards) != GOLDEN) print_error("digest 0x%016llx\n", (unsigned long long)scree_shards_digest(shards));
  assert_true(scree_shards_digest(shards) == GOLDEN);
  scree_shards_destroy(shards);
  seeds[0] += 1e-9;
  shards = must_make(&desc);
  assert_true(scree_shards_digest(shards) != GOLDEN);
  scree_shards_destroy(shards);
  free(seeds);
}

/* --- what can go wrong --- */

static void bad_input_is_told(void** state) {
  (void)state;
  static convex_solid box;
  make_convex_box(&box, UNIT);
  double* seeds = seeds_in(1, &box, false, 10);
  const scree_shards_desc good = desc_of(&box, seeds, 10);
  static const double zero_stretch[3] = {0, 1, 1}, no_up[3] = {NAN, 0, 0}, odd_seed[3] = {0, INFINITY, 0};
  static float uvs[12 * 6];
  for (uint32_t i = 0; i < 72; ++i) uvs[i] = (float)(i * 7 % 13);
  uint32_t open[36];
  memcpy(open, box.indices, sizeof open);
  open[0] = 1;
  scree_shards_desc bad[9];
  scree_result expected[9];
  for (int i = 0; i < 9; ++i) bad[i] = good;
  bad[0].seed_count = 0, expected[0] = SCREE_ERROR_INVALID_ARGUMENT;
  bad[1].seeds = NULL, expected[1] = SCREE_ERROR_INVALID_ARGUMENT;
  bad[2].seed_count = 1000001, expected[2] = SCREE_ERROR_RANGE;
  bad[3].stretch = zero_stretch, expected[3] = SCREE_ERROR_RANGE;
  bad[4].up = no_up, expected[4] = SCREE_ERROR_RANGE;
  bad[5].seeds = odd_seed, bad[5].seed_count = 1, expected[5] = SCREE_ERROR_RANGE;
  bad[6].link_angle = 4, expected[6] = SCREE_ERROR_RANGE;
  bad[7].solid.uvs = uvs, bad[7].clip = SCREE_CLIP_WALLS, expected[7] = SCREE_ERROR_INVALID_ARGUMENT;
  bad[8].solid.indices = open, expected[8] = SCREE_ERROR_NOT_CLOSED;
  for (int i = 0; i < 9; ++i) {
    scree_shards* shards = (scree_shards*)&box;
    scree_error error = {{0}};
    assert_int_equal(scree_shards_create(bad + i, &shards, &error), expected[i]);
    assert_null(shards);
    assert_true(error.message[0] != 0);
    assert_int_equal(scree_shards_create(bad + i, &shards, NULL), expected[i]);
  }
  scree_shards_destroy(NULL);
  free(seeds);
}

static void walls_refuse_a_solid_with_a_hollow_edge(void** state) {
  (void)state;
  static const double low[2][3] = {{0, 0, 0}, {2, 0, 0}}, high[2][3] = {{1, 1, 1}, {3, 1, 2}};
  static const bool hollow[2] = {false, false};
  double positions[48];
  uint32_t indices[72];
  convex_solid boxes;
  make_boxes(low, high, hollow, 2, positions, indices, &boxes.solid);
  scree_shards_desc desc = desc_of(&boxes, UNIT, 1);
  desc.clip = SCREE_CLIP_WALLS;
  scree_shards* shards;
  assert_int_equal(scree_shards_create(&desc, &shards, NULL), SCREE_ERROR_INVALID_ARGUMENT);
}

static void every_failing_allocation_is_told(void** state) {
  (void)state;
  static convex_solid solids[2];
  make_hill(solids);
  double* seeds = seeds_in(9, solids, true, 40);
  for (int clip = SCREE_CLIP_WALLS; clip <= SCREE_CLIP_MESH; ++clip)
    for (int32_t n = 0;; ++n) {
      failing_allocator f = {.fail_at = n};
      scree_shards_desc desc = desc_of(solids, seeds, 40);
      desc.clip = (scree_clip)clip;
      desc.allocator = failing_allocator_of(&f);
      scree_shards* shards;
      const scree_result result = scree_shards_create(&desc, &shards, NULL);
      if (!f.failed) {
        assert_int_equal(result, SCREE_OK);
        scree_shards_destroy(shards);
        assert_true(f.live == 0);
        assert_true(n > 20);
        break;
      }
      assert_int_equal(result, SCREE_ERROR_OUT_OF_MEMORY);
      assert_null(shards);
      assert_true(f.live == 0);
    }
  free(seeds);
}

static bool stop_at_once(void* user, const char* stage, double done) {
  (void)stage;
  (void)done;
  int* left = user;
  return (*left)-- > 0;
}

static void progress_can_cancel(void** state) {
  (void)state;
  static convex_solid box;
  make_convex_box(&box, UNIT);
  double* seeds = seeds_in(1, &box, false, 10);
  for (int calls = 0; calls < 4; ++calls) {
    failing_allocator f = {.fail_at = -1};
    int left = calls;
    scree_shards_desc desc = desc_of(&box, seeds, 10);
    desc.allocator = failing_allocator_of(&f);
    desc.progress = stop_at_once;
    desc.progress_user = &left;
    scree_shards* shards;
    const scree_result result = scree_shards_create(&desc, &shards, NULL);
    assert_int_equal(result, calls == 3 ? SCREE_OK : SCREE_ERROR_CANCELLED);
    scree_shards_destroy(shards);
    assert_true(f.live == 0);
  }
  free(seeds);
}

static void uneven_uvs_are_cut_by_mesh(void** state) {
  (void)state;
  static convex_solid box;
  make_convex_box(&box, UNIT);
  double* seeds = seeds_in(1, &box, false, 10);
  static float uvs[12 * 6];
  scree_shards_desc desc = desc_of(&box, seeds, 10);
  desc.solid.uvs = uvs;
  scree_shards_view view;
  for (int even = 0; even < 2; ++even) {
    for (uint32_t t = 0; t < 12; ++t)
      for (uint32_t k = 0; k < 3; ++k) {
        const double* p = box.positions + 3 * box.indices[3 * t + k];
        uvs[6 * t + 2 * k] = (float)(p[0] + 0.5 * p[1] + 0.25 * p[2]);
        uvs[6 * t + 2 * k + 1] = (float)(p[1] - p[2] + (even ? 0 : 0.1 * t));
      }
    scree_shards* shards = must_make(&desc);
    scree_shards_get(shards, &view);
    assert_int_equal(view.clip, even ? SCREE_CLIP_WALLS : SCREE_CLIP_MESH);
    check_all(shards, 1);
    scree_shards_destroy(shards);
  }
  free(seeds);
}

/* --- hulls --- */

static void hull_of_a_box_is_its_corners(void** state) {
  (void)state;
  static convex_solid box;
  make_convex_box(&box, UNIT);
  double* seeds = seeds_in(2, &box, false, 200);
  scree_shards_desc desc = desc_of(&box, seeds, 200);
  scree_shards* shards = must_make(&desc);
  uint32_t list[200], count;
  for (uint32_t i = 0; i < 200; ++i) list[i] = i;
  float points[3 * 64];
  static const double origin[3] = {0.5, 0.5, 0.5};
  assert_int_equal(scree_shards_hull(shards, list, 200, origin, points, 64, &count), SCREE_OK);
  assert_int_equal(count, 8);
  for (uint32_t i = 0; i < 3 * count; ++i) assert_true(fabsf(points[i]) == 0.5F);
  assert_int_equal(scree_shards_hull(shards, list, 200, origin, points, 4, &count), SCREE_OK);
  assert_int_equal(count, 4);
  assert_int_equal(scree_shards_hull(shards, list, 200, origin, points, 3, &count), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_shards_hull(shards, list, 0, origin, points, 8, &count), SCREE_ERROR_INVALID_ARGUMENT);
  const double nowhere[3] = {0, (double)NAN, 0};
  assert_int_equal(scree_shards_hull(shards, list, 200, nowhere, points, 8, &count), SCREE_ERROR_INVALID_ARGUMENT);
  list[0] = 200;
  assert_int_equal(scree_shards_hull(shards, list, 1, origin, points, 8, &count), SCREE_ERROR_INVALID_ARGUMENT);
  scree_shards_destroy(shards);
  free(seeds);
}

/* No direction has a vertex of the shard farther out than the hull. */
static void hull_reaches_as_far_as_its_shard(void** state) {
  (void)state;
  static convex_solid hill;
  make_hill(&hill);
  double* seeds = seeds_in(2, &hill, true, 100);
  scree_shards_desc desc = desc_of(&hill, seeds, 100);
  scree_shards* shards = must_make(&desc);
  scree_shards_view view;
  scree_shards_get(shards, &view);
  random_stream stream = {.state = 3};
  for (uint32_t s = 0; s < view.shard_count; ++s) {
    float points[3 * 128];
    uint32_t count;
    assert_int_equal(scree_shards_hull(shards, &s, 1, view.shards[s].centroid, points, 128, &count), SCREE_OK);
    assert_true(count >= 4);
    for (int round = 0; round < 50; ++round) {
      double direction[3], most = -INFINITY, hull = -INFINITY;
      random_direction(&stream, direction);
      for (uint32_t i = 0; i < count; ++i)
        hull = fmax(hull, direction[0] * points[3 * i] + direction[1] * points[3 * i + 1] + direction[2] * points[3 * i + 2]);
      for (uint32_t k = 0; k < view.shards[s].link_count; ++k) {
        const scree_link* link = view.links + view.shard_links[view.shards[s].first_link + k];
        for (uint32_t p = 0; p < link->polygon_count; ++p)
          for (uint32_t c = 0; c < view.polygons[link->first_polygon + p].corner_count; ++c) {
            const double* v = view.vertices + 3 * (size_t)view.corners[view.polygons[link->first_polygon + p].first_corner + c];
            double along = 0;
            for (int axis = 0; axis < 3; ++axis) along += direction[axis] * (v[axis] - view.shards[s].centroid[axis]);
            most = fmax(most, along);
          }
      }
      assert_true(fabs(most - hull) < 1e-6);
    }
  }
  scree_shards_destroy(shards);
  free(seeds);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(cells_of_a_box_are_those_of_voro),
      cmocka_unit_test(cells_of_a_convex_hill_are_those_of_voro),
      cmocka_unit_test(shards_keep_their_promises),
      cmocka_unit_test(stretches_of_surface_that_turn_little_are_one_link),
      cmocka_unit_test(a_regular_grid_of_seeds_works),
      cmocka_unit_test(seeds_in_one_place_are_moved_apart),
      cmocka_unit_test(many_seeds_in_one_place_are_moved_apart),
      cmocka_unit_test(seeds_whose_cell_misses_the_solid_have_no_shard),
      cmocka_unit_test(stretched_cells_are_nearest_by_stretched_distance),
      cmocka_unit_test(a_cell_that_falls_apart_is_several_shards),
      cmocka_unit_test(a_hollow_belongs_to_the_shard_around_it),
      cmocka_unit_test(shards_do_not_depend_on_jobs),
      cmocka_unit_test(digest_is_golden),
      cmocka_unit_test(bad_input_is_told),
      cmocka_unit_test(walls_refuse_a_solid_with_a_hollow_edge),
      cmocka_unit_test(every_failing_allocation_is_told),
      cmocka_unit_test(progress_can_cancel),
      cmocka_unit_test(uneven_uvs_are_cut_by_mesh),
      cmocka_unit_test(hull_of_a_box_is_its_corners),
      cmocka_unit_test(hull_reaches_as_far_as_its_shard),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
