/* Surfaces of what stands: closed, of the right volume, the solid's own where it is untouched. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "creases.h"
#include "failing_allocator.h"
#include "make_shards.h"
#include "make_solids.h"
#include "polygon_ears.h"
#include "random.h"
#include "surface_twin.h"
#include "surface_vertices.h"
#include "triangle_tree.h"

static uint32_t random_below(random_stream* r, uint32_t count) {
  return (uint32_t)(random_unit(r) * count);
}

/* --- shards of a cube whose sides are two triangles each ------------------------------------------------------------------- */

/* A lattice of n^3 unit boxes whose solid is the cube of 12 triangles: every triangle is in pieces. The caller frees `solid`. */
typedef struct cube {
  scree_shards* shards;
  double positions[24];
  uint32_t indices[36];
  float uvs[72];
} cube;

static void cube_create(uint32_t n, cube* out) {
  out->shards = make_lattice((const uint32_t[3]){n, n, n}, 0, NULL);
  scree_shards_view* view = &out->shards->view;
  const double half = 0.5 * n;
  for (uint32_t v = 0; v < 8; ++v) {
    out->positions[3 * v] = v & 1 ? half : -half;
    out->positions[3 * v + 1] = v & 2 ? n : 0;
    out->positions[3 * v + 2] = v & 4 ? half : -half;
  }
  /* Triangle 4 axis + 2 side has the corner that is high along u alone, the one behind it that along v. */
  for (uint32_t t = 0; t < 12; ++t) {
    const uint32_t axis = t / 4, side = t / 2 % 2, base = side << axis, u = 1u << (axis + 1) % 3, v = 1u << (axis + 2) % 3;
    const uint32_t second = t % 2 == 0 ? u : u + v, third = t % 2 == 0 ? u + v : v;
    out->indices[3 * t] = base;
    out->indices[3 * t + 1] = base + (side ? second : third);
    out->indices[3 * t + 2] = base + (side ? third : second);
  }
  /* Every triangle has its own affine map. */
  for (uint32_t i = 0; i < 72; ++i) out->uvs[i] = (float)(hash_mix(i + 1) >> 40) * 0x1p-24f;
  out->shards->solid = (scree_solid){out->positions, out->indices, out->uvs, 8, 12};
  scree_polygon* polygons = (scree_polygon*)(uintptr_t)view->polygons;
  for (uint32_t l = view->interior_link_count; l < view->link_count; ++l)
    for (uint32_t p = view->links[l].first_polygon; p < view->links[l].first_polygon + view->links[l].polygon_count; ++p) {
      uint32_t axis = 0;
      for (uint32_t a = 1; a < 3; ++a)
        if (view->links[l].normal[a] != 0) axis = a;
      const uint32_t side = view->links[l].normal[axis] > 0;
      double middle[3] = {0, 0, 0};
      for (uint32_t c = 0; c < 3; ++c)
        for (uint32_t a = 0; a < 3; ++a) middle[a] += view->vertices[3 * view->corners[polygons[p].first_corner + c] + a] / 3;
      middle[1] -= half;
      polygons[p].triangle = 4 * axis + 2 * side + (middle[(axis + 1) % 3] < middle[(axis + 2) % 3]);
    }
}

static uint8_t* random_inside(random_stream* r, uint32_t count, double share) {
  uint8_t* inside = calloc(count, 1);
  if (inside == NULL) abort();
  for (uint32_t s = 0; s < count; ++s) inside[s] = random_unit(r) < share;
  return inside;
}

static surface_vertices must_make(const scree_shards_view* view, const uint8_t* inside, bool ground) {
  surface_vertices out;
  const surface_desc desc = {.shards = view, .inside = inside, .ground = ground};
  assert_int_equal(surface_vertices_create(&desc, NULL, &out), SCREE_OK);
  return out;
}

static double volume_inside(const scree_shards_view* view, const uint8_t* inside) {
  double sum = 0;
  for (uint32_t s = 0; s < view->shard_count; ++s) sum += inside[s] ? view->shards[s].volume : 0;
  return sum;
}

/* By index in doubles: closed, and the volume of the shards. */
static void check_source(const scree_shards_view* view, const uint8_t* inside, const shard_surface* source) {
  uint32_t* corners = malloc((3 * (size_t)source->count + 1) * sizeof *corners);
  if (corners == NULL) abort();
  for (uint32_t t = 0; t < source->count; ++t) memcpy(corners + 3 * (size_t)t, source->triangles[t].corner, 3 * sizeof *corners);
  assert_int_equal(twin_open_edges(corners, source->count), 0);
  const double volume = volume_inside(view, inside);
  assert_true(fabs(twin_volume(view->vertices, corners, source->count) - volume) <= 1e-9 * view->volume);
  free(corners);
}

/* As floats, joined by place: closed still. */
static void check_places(const scree_frost_surface* surface) {
  const uint32_t triangles = surface->solid_triangles + surface->cut_triangles;
  uint32_t* corners = malloc((3 * (size_t)triangles + 1) * sizeof *corners);
  if (corners == NULL) abort();
  twin_join_places(surface, corners);
  assert_int_equal(twin_open_edges(corners, triangles), 0);
  free(corners);
}

static void an_untouched_solid_gives_back_its_own_triangles(void** state) {
  (void)state;
  for (uint32_t kind = 0; kind < 2; ++kind) {
    cube c;
    if (kind == 0)
      cube_create(3, &c);
    else
      c.shards = make_lattice((const uint32_t[3]){3, 2, 4}, 5, NULL);
    const scree_shards_view* view = &c.shards->view;
    const scree_solid* solid = view->solid;
    uint8_t inside[27];
    memset(inside, 1, sizeof inside);
    surface_vertices made = must_make(view, inside, true);
    assert_int_equal(made.surface.cut_triangles, 0);
    assert_int_equal(made.surface.solid_triangles, solid->triangle_count);
    for (uint32_t i = 0; i < 3 * solid->triangle_count; ++i) {
      const scree_frost_vertex* v = &made.surface.vertices[made.surface.indices[i]];
      for (uint32_t a = 0; a < 3; ++a) assert_true(v->position[a] == (float)solid->positions[3 * solid->indices[i] + a]);
      assert_memory_equal(v->uv, solid->uvs + 2 * (size_t)i, sizeof v->uv);
      assert_int_equal(v->material, SURFACE_SOLID);
    }
    surface_vertices_destroy(&made, NULL);
    scree_shards_destroy(c.shards);
  }
}

static void surfaces_are_closed_and_have_the_volume_of_their_shards(void** state) {
  (void)state;
  random_stream r = {17};
  for (uint32_t round = 0; round < 60; ++round) {
    cube c;
    if (round % 2 == 0)
      cube_create(2 + round % 4, &c);
    else
      c.shards = make_lattice((const uint32_t[3]){2 + round % 3, 1 + round % 5, 4}, round, NULL);
    const scree_shards_view* view = &c.shards->view;
    uint8_t* inside = random_inside(&r, view->shard_count, 0.1 + 0.8 * random_unit(&r));
    inside[0] = 1;
    surface_vertices made = must_make(view, inside, true);
    check_source(view, inside, &made.source);
    check_places(&made.surface);
    surface_vertices_destroy(&made, NULL);
    free(inside);
    scree_shards_destroy(c.shards);
  }
}

/* Vertices of one place, and triangles without area between them: what simplifying on a lattice leaves, also around vertices that
 * have no other triangles. */
static void solids_with_vertices_in_one_place_have_closed_surfaces(void** state) {
  (void)state;
  random_stream r = {23};
  uint32_t cut = 0;
  for (uint32_t round = 0; round < 60; ++round) {
    solid_mesh ring = solid_torus(2, 0.8, 16, 9);
    const double share = 0.3 * random_unit(&r);
    for (uint32_t i = 0; i < 3 * ring.triangle_count; ++i)
      if (random_unit(&r) < share / 6)
        memcpy(ring.positions + 3 * (size_t)ring.indices[i], ring.positions + 3 * (size_t)ring.indices[i / 3 * 3 + (i + 1) % 3],
               3 * sizeof *ring.positions);
    const scree_solid solid = {.positions = ring.positions,
                               .indices = ring.indices,
                               .vertex_count = ring.vertex_count,
                               .triangle_count = ring.triangle_count};
    double seeds[3 * 60];
    for (uint32_t i = 0; i < 3 * 60; ++i) seeds[i] = (i % 3 == 1 ? 1 : 6) * (random_unit(&r) - 0.5);
    scree_shards* shards = NULL;
    if (scree_solid_check(&solid, NULL, NULL) == SCREE_OK) {
      const scree_shards_desc desc = {.solid = solid, .seeds = seeds, .seed_count = 60};
      const scree_result result = scree_shards_create(&desc, &shards, NULL);
      assert_true(result == SCREE_OK || result == SCREE_ERROR_UNSUPPORTED); /* folded through itself along edges alone */
      for (uint32_t all = 0; shards != NULL && all < 2; ++all) {
        uint8_t* inside = random_inside(&r, shards->view.shard_count, all ? 2 : 0.7);
        surface_vertices made = must_make(&shards->view, inside, true);
        check_source(&shards->view, inside, &made.source);
        if (all) assert_int_equal(made.surface.solid_triangles, solid.triangle_count);
        surface_vertices_destroy(&made, NULL);
        free(inside);
      }
      cut += shards != NULL;
    }
    scree_shards_destroy(shards);
    solid_mesh_free(&ring);
  }
  assert_in_range(cut, 20, 60);
}

static void triangles_far_from_a_cut_stay_whole(void** state) {
  (void)state;
  cube c;
  cube_create(6, &c);
  uint8_t inside[216];
  memset(inside, 1, sizeof inside);
  inside[1 + 6 * (5 + 6 * 5)] = 0; /* at the edge between the far side in z and the top */
  surface_vertices made = must_make(&c.shards->view, inside, false);
  /* Ten triangles are not touched; two have lost a square at a side, which leaves seven corners. */
  assert_int_equal(made.source.solid_count, 10 + 5 + 5);
  assert_int_equal(made.surface.cut_triangles, 8);
  check_source(&c.shards->view, inside, &made.source);
  surface_vertices_destroy(&made, NULL);
  scree_shards_destroy(c.shards);
}

static void uvs_of_the_solid_are_interpolated(void** state) {
  (void)state;
  random_stream r = {3};
  cube c;
  cube_create(5, &c);
  const scree_shards_view* view = &c.shards->view;
  uint8_t* inside = random_inside(&r, view->shard_count, 0.6);
  surface_vertices made = must_make(view, inside, false);
  for (uint32_t i = 0; i < 3 * made.surface.solid_triangles; ++i) {
    const uint32_t t = made.source.triangles[i / 3].source;
    const scree_frost_vertex* v = &made.surface.vertices[made.surface.indices[i]];
    const double* p = view->vertices + 3 * (size_t)made.source.triangles[i / 3].corner[i % 3];
    const double *a = c.positions + 3 * c.indices[3 * t], *b = c.positions + 3 * c.indices[3 * t + 1],
                 *d = c.positions + 3 * c.indices[3 * t + 2];
    /* Areas on the side's plane. */
    const uint32_t axis = t / 4, x = (axis + 1) % 3, y = (axis + 2) % 3;
    const double whole = (b[x] - a[x]) * (d[y] - a[y]) - (b[y] - a[y]) * (d[x] - a[x]);
    const double wb = ((p[x] - a[x]) * (d[y] - a[y]) - (p[y] - a[y]) * (d[x] - a[x])) / whole;
    const double wd = ((b[x] - a[x]) * (p[y] - a[y]) - (b[y] - a[y]) * (p[x] - a[x])) / whole;
    for (uint32_t k = 0; k < 2; ++k) {
      const float* uv = c.uvs + 6 * t + k;
      const double want = (1 - wb - wd) * (double)uv[0] + wb * (double)uv[2] + wd * (double)uv[4];
      assert_true(fabs((double)v->uv[k] - want) < 1e-6);
    }
  }
  surface_vertices_destroy(&made, NULL);
  free(inside);
  scree_shards_destroy(c.shards);
}

static void cuts_are_flat_and_share_no_vertex_with_what_they_meet(void** state) {
  (void)state;
  random_stream r = {4};
  scree_shards* shards = make_lattice((const uint32_t[3]){4, 4, 4}, 9, NULL);
  uint8_t* inside = random_inside(&r, 64, 0.5);
  surface_vertices made = must_make(&shards->view, inside, false);
  const scree_frost_surface* s = &made.surface;
  assert_true(s->cut_triangles > 20);
  for (uint32_t t = 0; t < s->solid_triangles + s->cut_triangles; ++t) {
    const scree_frost_vertex* v[3];
    float n[3];
    for (uint32_t k = 0; k < 3; ++k) v[k] = &s->vertices[s->indices[3 * t + k]];
    for (uint32_t a = 0; a < 3; ++a) {
      const uint32_t x = (a + 1) % 3, y = (a + 2) % 3;
      n[a] = (v[1]->position[x] - v[0]->position[x]) * (v[2]->position[y] - v[0]->position[y]) -
             (v[1]->position[y] - v[0]->position[y]) * (v[2]->position[x] - v[0]->position[x]);
    }
    for (uint32_t k = 0; k < 3; ++k) {
      const float along = n[0] * v[k]->normal[0] + n[1] * v[k]->normal[1] + n[2] * v[k]->normal[2];
      const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
      assert_true(along > 0.9999f * length); /* boxes: the solid's sides are flat, too */
      assert_int_equal(v[k]->material, t < s->solid_triangles ? SURFACE_SOLID : SURFACE_CUT);
      assert_true(inside[v[k]->shard]);
      /* Lengths: sides of the triangle are as long in the plane of its uvs. */
      const scree_frost_vertex* next = v[(k + 1) % 3];
      double in_space = 0, in_uv = 0;
      for (uint32_t a = 0; a < 3; ++a) in_space += pow((double)(next->position[a] - v[k]->position[a]), 2);
      for (uint32_t a = 0; a < 2; ++a) in_uv += pow((double)(next->uv[a] - v[k]->uv[a]), 2);
      if (t >= s->solid_triangles) assert_true(fabs(sqrt(in_space) - sqrt(in_uv)) < 1e-5);
    }
  }
  surface_vertices_destroy(&made, NULL);
  free(inside);
  scree_shards_destroy(shards);
}

/* Two squares that meet at an angle: the normals along the fold. */
static void edges_are_smooth_up_to_forty_degrees(void** state) {
  (void)state;
  static const uint32_t indices[12] = {0, 2, 1, 1, 2, 3, 2, 4, 3, 3, 4, 5};
  for (int degrees = 5; degrees < 90; degrees += 10) {
    const double angle = degrees * 3.14159265358979 / 180;
    const double positions[18] = {-1, 0, 0, -1, 0, 1, 0, 0, 0, 0, 0, 1, cos(angle), -sin(angle), 0, cos(angle), -sin(angle), 1};
    const scree_solid solid = {positions, indices, NULL, 6, 4};
    double normals[36];
    const scree_allocator allocator = scree_rt_allocator_or_default(NULL);
    assert_int_equal(crease_normals(&solid, &allocator, normals), SCREE_OK);
    const double sharpness = fabs(normals[3 * 1] - normals[3 * 6]); /* vertex 2 seen from both squares */
    if (degrees < 40)
      assert_true(sharpness < 1e-12);
    else
      assert_true(sharpness > 0.5);
  }
}

static void openness_falls_into_pits_and_the_ground_darkens_the_foot(void** state) {
  (void)state;
  scree_shards* shards = make_lattice((const uint32_t[3]){5, 5, 5}, 0, NULL);
  uint8_t inside[125];
  memset(inside, 1, sizeof inside);
  surface_vertices free_box = must_make(&shards->view, inside, false);
  for (uint32_t v = 0; v < free_box.surface.vertex_count; ++v) assert_int_equal(free_box.surface.vertices[v].occlusion, 255);
  surface_vertices on_ground = must_make(&shards->view, inside, true);
  for (uint32_t v = 0; v < on_ground.surface.vertex_count; ++v) {
    const scree_frost_vertex* at = &on_ground.surface.vertices[v];
    if (at->normal[1] > 0.5f) assert_int_equal(at->occlusion, 255);
    if (at->normal[1] < -0.5f) assert_int_equal(at->occlusion, 0);
    if (at->normal[0] > 0.5f) assert_in_range(at->occlusion, 100, 240);
  }
  for (uint32_t y = 2; y < 5; ++y) inside[2 + 5 * (y + 5 * 2)] = 0; /* a shaft from the top */
  surface_vertices pit = must_make(&shards->view, inside, true);
  for (uint32_t v = 0; v < pit.surface.vertex_count; ++v) {
    const scree_frost_vertex* at = &pit.surface.vertices[v];
    const bool bottom = at->position[1] == 2.0f && fabsf(at->position[0]) < 0.6f && fabsf(at->position[2]) < 0.6f;
    if (bottom) assert_in_range(at->occlusion, 0, 80);
  }
  surface_vertices_destroy(&free_box, NULL);
  surface_vertices_destroy(&on_ground, NULL);
  surface_vertices_destroy(&pit, NULL);
  scree_shards_destroy(shards);
}

/* --- polygons --------------------------------------------------------------------------------------------------------------- */

static double area_of(const double* positions, const uint32_t* corners, uint32_t count) {
  double sum = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const double *a = positions + 3 * corners[i], *b = positions + 3 * corners[(i + 1) % count];
    sum += a[0] * b[1] - a[1] * b[0];
  }
  return 0.5 * sum;
}

/* Star-shaped, with vertices within its edges, and now and then a square hole in the middle joined by a bridge. */
static uint32_t random_polygon(random_stream* r, double* positions, uint32_t* corners, bool hole) {
  const uint32_t points = 4 + random_below(r, 20);
  uint32_t count = 0;
  for (uint32_t i = 0; i < points; ++i) {
    const double angle = 6.283185307179586 * (i + 0.8 * random_unit(r)) / points, radius = 1 + 3 * random_unit(r);
    const double p[3] = {radius * cos(angle), radius * sin(angle), 0};
    if (i > 0 && random_below(r, 3) == 0) {
      for (uint32_t a = 0; a < 3; ++a) positions[3 * count + a] = 0.5 * (positions[3 * (count - 1) + a] + p[a]);
      corners[count] = count;
      ++count;
    }
    memcpy(positions + 3 * count, p, sizeof p);
    corners[count] = count;
    ++count;
  }
  if (!hole) return count;
  /* The bridge goes from the last vertex straight inwards to the nearest corner of the hole. */
  const uint32_t last = count - 1;
  const double* at = positions + 3 * last;
  const double length = sqrt(at[0] * at[0] + at[1] * at[1]), x = 0.2 * at[0] / length, y = 0.2 * at[1] / length;
  const double places[4][2] = {{x, y}, {y, -x}, {-x, -y}, {-y, x}}; /* clockwise */
  const uint32_t first = count;
  for (uint32_t i = 0; i < 4; ++i, ++count) {
    positions[3 * count] = places[i][0];
    positions[3 * count + 1] = places[i][1];
    positions[3 * count + 2] = 0;
    corners[count] = count;
  }
  corners[count++] = first;
  corners[count++] = last;
  return count;
}

static void polygons_become_triangles_that_fill_them(void** state) {
  (void)state;
  random_stream r = {11};
  for (uint32_t round = 0; round < 2000; ++round) {
    double positions[3 * 64];
    uint32_t corners[64], triangles[6 * 64];
    ear_corner scratch[64];
    const uint32_t count = random_polygon(&r, positions, corners, round % 3 == 0);
    const uint32_t made = polygon_ears(positions, corners, count, (const double[3]){0, 0, 0.1}, scratch, triangles);
    assert_int_equal(made, count - 2);
    double sum = 0;
    for (uint32_t t = 0; t < made; ++t) {
      const double area = area_of(positions, triangles + 3 * t, 3);
      assert_true(area > 0);
      sum += area;
    }
    assert_true(fabs(sum - area_of(positions, corners, count)) < 1e-9);
    /* With the polygon walked backwards it is closed. */
    for (uint32_t i = 0; i + 2 < count; ++i) {
      triangles[3 * (made + i)] = corners[0];
      triangles[3 * (made + i) + 1] = corners[i + 2];
      triangles[3 * (made + i) + 2] = corners[i + 1];
    }
    assert_int_equal(twin_open_edges(triangles, made + count - 2), 0);
  }
}

static void edges_that_are_walked_both_ways_make_no_triangle(void** state) {
  (void)state;
  const double positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 3, 0, 0};
  const uint32_t corners[5] = {0, 1, 3, 1, 2};
  uint32_t triangles[9];
  ear_corner scratch[5];
  assert_int_equal(polygon_ears(positions, corners, 5, (const double[3]){0, 0, 1}, scratch, triangles), 1);
  assert_true(area_of(positions, triangles, 3) == 0.5);
  assert_int_equal(polygon_ears(positions, (const uint32_t[3]){0, 1, 0}, 3, (const double[3]){0, 0, 1}, scratch, triangles), 0);
}

/* --- trees ------------------------------------------------------------------------------------------------------------------ */

static void trees_answer_as_all_triangles_do(void** state) {
  (void)state;
  enum { TRIANGLES = 300 };
  random_stream r = {23};
  static double positions[9 * TRIANGLES];
  static uint32_t indices[3 * TRIANGLES];
  for (uint32_t t = 0; t < TRIANGLES; ++t)
    for (uint32_t i = 0; i < 9; ++i)
      positions[9 * t + i] = i < 3 ? 10 * random_unit(&r) : positions[9 * t + i % 3] + random_unit(&r);
  for (uint32_t i = 0; i < 3 * TRIANGLES; ++i) indices[i] = i;
  triangle_tree tree;
  assert_int_equal(triangle_tree_create(positions, indices, TRIANGLES, NULL, &tree), SCREE_OK);
  uint32_t met = 0;
  for (uint32_t round = 0; round < 500; ++round) {
    double p[3], d[3], least = INFINITY;
    bool any = false;
    for (uint32_t a = 0; a < 3; ++a) p[a] = 14 * random_unit(&r) - 2, d[a] = random_below(&r, 4) ? 2 * random_unit(&r) - 1 : 0;
    for (uint32_t t = 0; t < TRIANGLES; ++t) {
      const double* c = positions + 9 * t;
      const double d2 = distance2_to_triangle(p, c, c + 3, c + 6);
      if (d2 < least) least = d2;
      any = any || twin_ray_meets(c, p, d, 20);
    }
    assert_true(triangle_tree_distance2(&tree, p) == least);
    assert_int_equal(triangle_tree_meets(&tree, p, d, 0, 20), any);
    met += any;
  }
  assert_in_range(met, 30, 470);
  triangle_tree_destroy(&tree);
}

/* --- all ---------------------------------------------------------------------------------------------------------------------- */

static void surfaces_repeat_to_the_bit(void** state) {
  (void)state;
  random_stream r = {8};
  cube c;
  cube_create(5, &c);
  uint8_t* inside = random_inside(&r, 125, 0.7);
  surface_vertices a = must_make(&c.shards->view, inside, true);
  uint64_t digest = twin_digest(a.surface.vertices, a.surface.vertex_count * sizeof *a.surface.vertices);
  digest ^= twin_digest(a.surface.indices, 3 * sizeof(uint32_t) * (a.surface.solid_triangles + a.surface.cut_triangles));
  if (digest != UINT64_C(0x40aebdb2e36622b4)) fail_msg("the digest is now 0x%016llx", (unsigned long long)digest);
  surface_vertices_destroy(&a, NULL);
  free(inside);
  scree_shards_destroy(c.shards);
}

static void failed_allocations_leave_nothing_behind(void** state) {
  (void)state;
  cube c;
  cube_create(3, &c);
  uint8_t inside[27];
  memset(inside, 1, sizeof inside);
  inside[13] = inside[26] = 0;
  for (int32_t fail_at = 0;; ++fail_at) {
    failing_allocator f = {.fail_at = fail_at};
    const scree_allocator allocator = failing_allocator_of(&f);
    surface_vertices made;
    const surface_desc desc = {.shards = &c.shards->view, .inside = inside};
    const scree_result result = surface_vertices_create(&desc, &allocator, &made);
    assert_int_equal(result, f.failed ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_OK);
    surface_vertices_destroy(&made, &allocator);
    assert_int_equal(f.live, 0);
    if (!f.failed) break;
  }
  scree_shards_destroy(c.shards);
}

/* --- of a simulation --------------------------------------------------------------------------------------------------------- */

static void what_stands_and_every_block_have_a_surface(void** state) {
  (void)state;
  scree_shards* shards = make_lattice((const uint32_t[3]){6, 6, 6}, 3, NULL);
  scree_frost_desc desc = {.shards = shards, .random_seed = 2};
  scree_frost_rules_default(&desc.rules);
  desc.rules.fall_life = 0.3; /* some blocks of several shards */
  scree_frost* frost;
  assert_int_equal(scree_frost_create(&desc, &frost, NULL), SCREE_OK);
  assert_int_equal(scree_frost_run(frost, 0.6, 1000000, NULL, NULL), SCREE_OK);
  const scree_block* blocks;
  const uint32_t* list;
  const uint32_t count = scree_frost_blocks(frost, &blocks, &list);
  assert_true(count > 5);
  scree_frost_stats stats;
  scree_frost_get_stats(frost, &stats);
  scree_frost_surface surface;
  for (uint32_t b = 0; b <= count; ++b) {
    const bool standing = b == count;
    assert_int_equal(scree_frost_surface_create(frost, standing ? UINT32_MAX : b, NULL, &surface), SCREE_OK);
    check_places(&surface);
    const uint32_t triangles = surface.solid_triangles + surface.cut_triangles;
    assert_true(triangles >= 4 && surface.cut_triangles > 0);
    double* positions = malloc(3 * surface.vertex_count * sizeof *positions);
    if (positions == NULL) abort();
    for (uint32_t v = 0; v < surface.vertex_count; ++v)
      for (uint32_t a = 0; a < 3; ++a) positions[3 * v + a] = (double)surface.vertices[v].position[a];
    const double want = standing ? stats.volume : blocks[b].volume;
    assert_true(fabs(twin_volume(positions, surface.indices, triangles) - want) < 1e-5 * want);
    /* A block's places are relative to its centroid. */
    double low = INFINITY, high = -INFINITY;
    for (uint32_t v = 0; v < surface.vertex_count; ++v) low = fmin(low, positions[3 * v]), high = fmax(high, positions[3 * v]);
    assert_true(low < 0 && high > 0);
    free(positions);
    scree_frost_surface_free(NULL, &surface);
  }
  assert_int_equal(scree_frost_surface_create(frost, count, NULL, &surface), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_frost_surface_create(NULL, UINT32_MAX, NULL, &surface), SCREE_ERROR_INVALID_ARGUMENT);
  for (int32_t fail_at = 0;; ++fail_at) {
    failing_allocator f = {.fail_at = fail_at};
    const scree_allocator allocator = failing_allocator_of(&f);
    const scree_result result = scree_frost_surface_create(frost, UINT32_MAX, &allocator, &surface);
    assert_int_equal(result, f.failed ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_OK);
    scree_frost_surface_free(&allocator, &surface);
    assert_int_equal(f.live, 0);
    if (!f.failed) break;
  }
  scree_frost_destroy(frost);
  scree_shards_destroy(shards);
}

static void nothing_inside_has_no_surface(void** state) {
  (void)state;
  scree_shards* shards = make_lattice((const uint32_t[3]){2, 2, 2}, 0, NULL);
  const uint8_t inside[8] = {0};
  surface_vertices made = must_make(&shards->view, inside, true);
  assert_int_equal(made.surface.vertex_count, 0);
  surface_vertices_destroy(&made, NULL);
  scree_shards_destroy(shards);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_untouched_solid_gives_back_its_own_triangles),
      cmocka_unit_test(surfaces_are_closed_and_have_the_volume_of_their_shards),
      cmocka_unit_test(solids_with_vertices_in_one_place_have_closed_surfaces),
      cmocka_unit_test(triangles_far_from_a_cut_stay_whole),
      cmocka_unit_test(uvs_of_the_solid_are_interpolated),
      cmocka_unit_test(cuts_are_flat_and_share_no_vertex_with_what_they_meet),
      cmocka_unit_test(edges_are_smooth_up_to_forty_degrees),
      cmocka_unit_test(openness_falls_into_pits_and_the_ground_darkens_the_foot),
      cmocka_unit_test(polygons_become_triangles_that_fill_them),
      cmocka_unit_test(edges_that_are_walked_both_ways_make_no_triangle),
      cmocka_unit_test(trees_answer_as_all_triangles_do),
      cmocka_unit_test(surfaces_repeat_to_the_bit),
      cmocka_unit_test(failed_allocations_leave_nothing_behind),
      cmocka_unit_test(what_stands_and_every_block_have_a_surface),
      cmocka_unit_test(nothing_inside_has_no_surface),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
