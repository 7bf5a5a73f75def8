/* The surfaces of weathered shapes: closed, manifold, smooth, and the same whatever was kept from the time before. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <scree/threads.h>

#include "failing_allocator.h"
#include "fake_weather.h"
#include "mesh_twin.h"
#include "random_weather.h"
#include "surface_cubes.h"

static void* need(size_t count, size_t size) {
  void* memory = calloc(count + 1, size);
  assert_non_null(memory);
  return memory;
}

/* --- Facts about one surface. --- */

static uint32_t triangles_of(const scree_surface* s) {
  return s->rock_triangles + s->colluvium_triangles;
}

/* Topology by the twin; what speaks of places is looked at in floats here. */
static void assert_surface_is_right(const scree_surface* s) {
  int16_t(*flat)[3] = need(s->vertex_count, sizeof *flat);
  const twin_mesh mesh = {(const int16_t(*)[3])flat, s->indices, s->vertex_count, triangles_of(s)};
  const mesh_faults faults = mesh_find_faults(&mesh);
  free(flat);
  assert_int_equal(faults.bad_indices, 0);
  assert_int_equal(faults.repeated_corners, 0);
  assert_int_equal(faults.shared_edges, 0);
  assert_int_equal(faults.open_edges, 0);
  assert_int_equal(faults.pinched_vertices, 0);
  assert_int_equal(faults.unused_vertices, 0);
  for (uint32_t t = 0; t < triangles_of(s); ++t) {
    const scree_surface_vertex* corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = &s->vertices[s->indices[t * 3 + k]];
    double u[3], w[3], longest = 0;
    for (int axis = 0; axis < 3; ++axis) {
      u[axis] = (double)corner[1]->position[axis] - (double)corner[0]->position[axis];
      w[axis] = (double)corner[2]->position[axis] - (double)corner[0]->position[axis];
    }
    const double n[3] = {u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]};
    longest = fmax(u[0] * u[0] + u[1] * u[1] + u[2] * u[2], w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    assert_true(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] > 1e-12 * longest * longest);
    for (int k = 0; k < 3; ++k) assert_true(t < s->rock_triangles || corner[k]->material == 1);
  }
  for (uint32_t v = 0; v < s->vertex_count; ++v) {
    const scree_surface_vertex* vertex = &s->vertices[v];
    const float* n = vertex->normal;
    assert_true(fabsf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1) < 1e-4f);
    assert_true(vertex->occlusion >= 0 && vertex->occlusion <= 1);
    assert_true(vertex->curvature >= -1 && vertex->curvature <= 1);
    assert_true(vertex->durability > 0);
    assert_true(vertex->position[1] >= 0);
    assert_true(vertex->padding[0] == 0 && vertex->padding[1] == 0);
  }
}

static double volume_of(const scree_surface* s) {
  double sum = 0;
  for (uint32_t i = 0; i < triangles_of(s) * 3; i += 3) {
    double p[3][3];
    for (int k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis) p[k][axis] = (double)s->vertices[s->indices[i + (uint32_t)k]].position[axis];
    sum += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) + p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
           p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
  }
  return sum / 6;
}

static bool same_surface(const scree_surface* a, const scree_surface* b) {
  return a->vertex_count == b->vertex_count && a->rock_triangles == b->rock_triangles &&
         a->colluvium_triangles == b->colluvium_triangles &&
         (a->vertex_count == 0 || (memcmp(a->vertices, b->vertices, a->vertex_count * sizeof *a->vertices) == 0 &&
                                   memcmp(a->indices, b->indices, (size_t)triangles_of(a) * 3 * sizeof *a->indices) == 0));
}

/* --- Shapes. --- */

/* Every voxel by chance, of any life: all configurations of cubes, side by side. */
static void fill_with_noise(scree_weather* w, random_stream* random, double share) {
  for (uint32_t z = 0; z < w->size[2]; ++z)
    for (uint32_t y = 0; y < w->size[1]; ++y)
      for (uint32_t x = 0; x < w->size[0]; ++x) {
        if (random_unit(random) >= share) continue;
        const scree_voxel voxel = random_unit(random) < 0.3 ? SCREE_VOXEL_COLLUVIUM : SCREE_VOXEL_ROCK;
        fake_weather_set(w, x, y, z, voxel, random_unit(random) < 0.5 ? 1.0f : (float)random_unit(random));
      }
}

static void a_cube_has_at_most_one_face_that_pinches(void** state) {
  (void)state;
  surface_cubes* cubes = need(1, sizeof *cubes);
  surface_cubes_fill(cubes);
  uint32_t pinching = 0;
  for (uint32_t c = 0; c < 256; ++c) {
    if (cubes->pinching[c] == CUBE_NO_FACE) continue;
    ++pinching;
    /* Cut the other way, the piece falls in two. */
    assert_int_equal(cubes->pieces[1][c], cubes->pieces[0][c] + 1);
  }
  assert_int_equal(pinching, 36);
  free(cubes);
}

static void noise_of_any_density_has_a_closed_manifold_surface_on_every_level(void** state) {
  (void)state;
  random_stream random = {1};
  uint32_t colluvium = 0;
  for (uint32_t round = 0; round < 40; ++round) {
    const uint32_t size[3] = {1 + (uint32_t)(random_unit(&random) * 40), 1 + (uint32_t)(random_unit(&random) * 40),
                              1 + (uint32_t)(random_unit(&random) * 40)};
    scree_weather* w = fake_weather_create(size, NULL, NULL);
    fill_with_noise(w, &random, 0.1 + 0.85 * random_unit(&random));
    scree_mesher* mesher;
    assert_int_equal(scree_mesher_create(w, &mesher), SCREE_OK);
    for (uint32_t level = 0; level <= 5; ++level) {
      scree_surface s;
      assert_int_equal(scree_mesher_update(mesher, level, &s), SCREE_OK);
      assert_surface_is_right(&s);
      colluvium += s.colluvium_triangles;
    }
    scree_mesher_destroy(mesher);
    fake_weather_destroy(w);
  }
  assert_true(colluvium > 1000);
}

static void what_was_kept_is_what_would_be_made(void** state) {
  (void)state;
  random_stream random = {2};
  const uint32_t size[3] = {70, 50, 60};
  scree_weather* w = fake_weather_create(size, NULL, NULL);
  scree_mesher* kept;
  assert_int_equal(scree_mesher_create(w, &kept), SCREE_OK);
  fill_with_noise(w, &random, 0.8);
  for (uint32_t step = 0; step < 20; ++step) {
    ++w->change;
    /* A few boxes become air or rock, most of them beside the faces of bricks. */
    for (uint32_t box = 0; box < 6; ++box) {
      uint32_t min[3], side[3];
      for (int axis = 0; axis < 3; ++axis) {
        side[axis] = 1 + (uint32_t)(random_unit(&random) * (step % 5 == 0 ? 16 : 2));
        min[axis] = (uint32_t)(random_unit(&random) * (size[axis] - side[axis]));
        if (random_unit(&random) < 0.6) min[axis] = min[axis] / 16 * 16;
      }
      for (uint32_t z = 0; z < side[2]; ++z)
        for (uint32_t y = 0; y < side[1]; ++y)
          for (uint32_t x = 0; x < side[0]; ++x)
            fake_weather_set(w, min[0] + x, min[1] + y, min[2] + z, step % 2 ? SCREE_VOXEL_ROCK : SCREE_VOXEL_AIR, 0.7f);
    }
    scree_mesher* fresh;
    assert_int_equal(scree_mesher_create(w, &fresh), SCREE_OK);
    for (uint32_t level = step % 2; level <= 5; level += 2) {
      scree_surface a, b;
      assert_int_equal(scree_mesher_update(kept, level, &a), SCREE_OK);
      assert_int_equal(scree_mesher_update(fresh, level, &b), SCREE_OK);
      assert_true(a.vertex_count > 0);
      assert_true(same_surface(&a, &b));
    }
    scree_mesher_destroy(fresh);
  }
  scree_mesher_destroy(kept);
  fake_weather_destroy(w);
}

/* A ball as exact shares of voxels, by 4^3 samples. */
static scree_weather* ball_of(uint32_t side, double radius) {
  const uint32_t size[3] = {side, side, side};
  scree_weather* w = fake_weather_create(size, NULL, NULL);
  for (uint32_t z = 0; z < side; ++z)
    for (uint32_t y = 0; y < side; ++y)
      for (uint32_t x = 0; x < side; ++x) {
        uint32_t in = 0;
        for (uint32_t i = 0; i < 64; ++i) {
          const double p[3] = {x + (i % 4 + 0.5) / 4 - side / 2.0, y + (i / 4 % 4 + 0.5) / 4 - side / 2.0,
                               z + (i / 16 + 0.5) / 4 - side / 2.0};
          in += p[0] * p[0] + p[1] * p[1] + p[2] * p[2] <= radius * radius;
        }
        if (in > 0) fake_weather_set(w, x, y, z, SCREE_VOXEL_ROCK, (float)in / 64);
      }
  return w;
}

static void levels_keep_the_volume(void** state) {
  (void)state;
  scree_weather* w = ball_of(64, 24.3);
  scree_mesher* mesher;
  assert_int_equal(scree_mesher_create(w, &mesher), SCREE_OK);
  double finest = 0;
  for (uint32_t level = 0; level <= 4; ++level) {
    scree_surface s;
    assert_int_equal(scree_mesher_update(mesher, level, &s), SCREE_OK);
    assert_surface_is_right(&s);
    const double volume = volume_of(&s);
    if (level == 0) finest = volume;
    print_message("level %u: %u vertices, volume %.4f of the finest, %.4f of the ball\n", level, s.vertex_count, volume / finest,
                  volume / (4.0 / 3 * 3.14159265358979 * 24.3 * 24.3 * 24.3));
    assert_true(fabs(volume / finest - 1) < (level < 4 ? 0.01 : 0.05));
  }
  scree_mesher_destroy(mesher);
  fake_weather_destroy(w);
}

static void normals_of_a_ball_point_outward(void** state) {
  (void)state;
  scree_weather* w = ball_of(64, 20.5);
  scree_mesher* mesher;
  scree_surface s;
  assert_int_equal(scree_mesher_create(w, &mesher), SCREE_OK);
  assert_int_equal(scree_mesher_update(mesher, 0, &s), SCREE_OK);
  double sum = 0;
  for (uint32_t v = 0; v < s.vertex_count; ++v) {
    double dot = 0, length2 = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double d = (double)s.vertices[v].position[axis] - 32;
      dot += d * (double)s.vertices[v].normal[axis];
      length2 += d * d;
    }
    sum += acos(fmin(dot / sqrt(length2), 1)) * 180 / 3.14159265358979;
  }
  print_message("mean normal error %.2f degrees\n", sum / s.vertex_count);
  assert_true(sum / s.vertex_count < 3);
  scree_mesher_destroy(mesher);
  fake_weather_destroy(w);
}

static void a_wall_meets_the_ground_at_a_right_angle(void** state) {
  (void)state;
  const uint32_t size[3] = {40, 20, 40};
  scree_weather* w = fake_weather_create(size, NULL, NULL);
  for (uint32_t z = 10; z < 30; ++z)
    for (uint32_t y = 0; y < 15; ++y)
      for (uint32_t x = 10; x < 30; ++x) fake_weather_set(w, x, y, z, SCREE_VOXEL_ROCK, 1);
  scree_mesher* mesher;
  scree_surface s;
  assert_int_equal(scree_mesher_create(w, &mesher), SCREE_OK);
  assert_int_equal(scree_mesher_update(mesher, 0, &s), SCREE_OK);
  assert_surface_is_right(&s);
  uint32_t ground = 0;
  for (uint32_t v = 0; v < s.vertex_count; ++v) {
    const scree_surface_vertex* vertex = &s.vertices[v];
    if (vertex->position[1] > 0) continue;
    ++ground;
    const float off = fabsf(vertex->position[0] - 20), along = fabsf(vertex->position[2] - 20);
    if (off > 9.9f && along < 8) {
      assert_true(fabsf(off - 10) < 1e-5f);
      assert_true(fabsf(vertex->normal[0]) > 0.999f);
    }
    if (off < 9 && along < 9) assert_true(vertex->normal[1] < -0.999f);
  }
  assert_int_equal(ground, 21 * 21);
  scree_mesher_destroy(mesher);
  fake_weather_destroy(w);
}

/* --- What weathers. --- */

static void random_simulations_have_right_surfaces_and_keep_them(void** state) {
  (void)state;
  uint32_t colluvium = 0, vertices = 0, kept_rounds = 0;
  for (uint64_t round = 0; round < 30; ++round) {
    random_stream random = {100 + round};
    random_start start;
    random_rules rules[2];
    random_start_make(&random, 40, &start);
    random_rules_make(&random, 8, &rules[0]);
    random_rules_make(&random, 8, &rules[1]);
    const scree_weather_desc desc = {.start = start.start, .rules = rules[0].rules};
    scree_weather* w;
    if (scree_weather_create(&desc, &w, NULL) == SCREE_OK) {
      ++kept_rounds;
      scree_weather_snapshot* before = NULL;
      scree_mesher* kept;
      assert_int_equal(scree_mesher_create(w, &kept), SCREE_OK);
      for (uint32_t step = 0; step < 8; ++step) {
        if (step == 2) assert_int_equal(scree_weather_save(w, &before), SCREE_OK);
        if (step == 4) assert_int_equal(scree_weather_set_rules(w, &rules[1].rules, NULL), SCREE_OK);
        if (step == 6)
          scree_weather_restore(w, before);
        else if (step != 4)
          assert_int_equal(scree_weather_step(w, 1 + random_below(&random, 6)), SCREE_OK);
        scree_mesher* fresh;
        assert_int_equal(scree_mesher_create(w, &fresh), SCREE_OK);
        for (uint32_t level = step % 2; level <= 5; level += 1 + random_below(&random, 3)) {
          scree_surface a, b;
          assert_int_equal(scree_mesher_update(kept, level, &a), SCREE_OK);
          assert_int_equal(scree_mesher_update(fresh, level, &b), SCREE_OK);
          assert_true(same_surface(&a, &b));
          if (step % 3 == 0) assert_surface_is_right(&a);
          colluvium += a.colluvium_triangles;
          vertices += a.vertex_count;
        }
        scree_mesher_destroy(fresh);
      }
      scree_mesher_destroy(kept);
      scree_weather_forget(w, before);
      scree_weather_destroy(w);
    }
    random_start_free(&start);
  }
  assert_true(kept_rounds > 15 && vertices > 50000 && colluvium > 1000);
}

/* The research's sphere: a cube of 40, 3c^4 in a bubble of 4, exposure 0.6, until a fifth is left. */
static void a_cube_weathers_to_a_smooth_ball(void** state) {
  (void)state;
  const scree_durability_point point = {.durability = 1};
  scree_weather_desc desc = {
      .start = {.kind = SCREE_START_BOX, .size = {56, 56, 56}, .box_min = {8, 8, 8}, .box_max = {48, 48, 48}}};
  scree_weather_rules_default(&desc.rules);
  desc.rules.durability = &point;
  desc.rules.durability_count = 1;
  desc.rules.spheroidal.kind = SCREE_CURVE_QUARTIC;
  desc.rules.exposure = 0.6;
  desc.rules.colluvium_share = 0;
  desc.rules.rockfall = SCREE_ROCKFALL_NONE;
  scree_weather* w;
  scree_mesher* mesher;
  scree_surface s;
  assert_int_equal(scree_weather_create(&desc, &w, NULL), SCREE_OK);
  assert_int_equal(scree_weather_run(w, 0.2, 10000, NULL, NULL), SCREE_OK);
  assert_int_equal(scree_mesher_create(w, &mesher), SCREE_OK);
  assert_int_equal(scree_mesher_update(mesher, 0, &s), SCREE_OK);
  assert_surface_is_right(&s);
  double area = 0;
  for (uint32_t t = 0; t < triangles_of(&s); ++t) {
    double u[3], v[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double p = (double)s.vertices[s.indices[3 * t]].position[axis];
      u[axis] = (double)s.vertices[s.indices[3 * t + 1]].position[axis] - p;
      v[axis] = (double)s.vertices[s.indices[3 * t + 2]].position[axis] - p;
    }
    const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    area += sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / 2;
  }
  double off = 0, worst = 0, radius = 0, radius2 = 0;
  for (uint32_t v = 0; v < s.vertex_count; ++v) {
    double dot = 0, length2 = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double d = (double)s.vertices[v].position[axis] - 28;
      dot += d * (double)s.vertices[v].normal[axis];
      length2 += d * d;
    }
    const double angle = acos(fmin(dot / sqrt(length2), 1)) * 180 / 3.14159265358979;
    off += angle / s.vertex_count;
    worst = fmax(worst, angle);
    radius += sqrt(length2) / s.vertex_count;
    radius2 += length2 / s.vertex_count;
  }
  const double volume = volume_of(&s), psi = cbrt(3.14159265358979) * pow(6 * volume, 2.0 / 3) / area;
  const double deviation = sqrt(radius2 - radius * radius) / radius;
  print_message("sphericity %.4f, radius +- %.2f %%, normals off by %.2f degrees, at most %.1f\n", psi, 100 * deviation, off,
                worst);
  assert_true(psi >= 0.99);
  assert_true(deviation <= 0.025);
  assert_true(off <= 6);
  assert_true(worst <= 15);
  scree_mesher_destroy(mesher);
  scree_weather_destroy(w);
}

static void vertices_tell_what_lies_beneath(void** state) {
  (void)state;
  /* Three beds of a block; colluvium is whatever fell from them. */
  const scree_durability_point points[4] = {{0, 1, 0, 0, 0}, {0.4, 1, 0, 0, 0}, {0.401, 3, 0, 0, 0}, {1, 3, 0, 0, 0}};
  scree_weather_desc desc = {
      .start = {.kind = SCREE_START_BOX, .size = {60, 50, 60}, .box_min = {15, 0, 15}, .box_max = {45, 45, 45}}};
  scree_weather_rules_default(&desc.rules);
  desc.rules.durability = points;
  desc.rules.durability_count = 4;
  desc.rules.colluvium_share = 0.5;
  scree_weather* w;
  scree_mesher* mesher;
  scree_surface s;
  assert_int_equal(scree_weather_create(&desc, &w, NULL), SCREE_OK);
  assert_int_equal(scree_weather_run(w, 0.6, 10000, NULL, NULL), SCREE_OK);
  assert_int_equal(scree_mesher_create(w, &mesher), SCREE_OK);
  assert_int_equal(scree_mesher_update(mesher, 0, &s), SCREE_OK);
  double edge = 0, wall = 0;
  uint32_t edges = 0, walls = 0, low = 0, high = 0, bed = 0, grains = 0;
  for (uint32_t v = 0; v < s.vertex_count; ++v) {
    const scree_surface_vertex* vertex = &s.vertices[v];
    const float y = vertex->position[1];
    if (vertex->material == 1) {
      ++grains;
      continue;
    }
    if (y > 2 && y < 17) {
      low += vertex->layer == 1;
      assert_true(vertex->layer <= 2);
    }
    if (y > 24) {
      ++high;
      /* Of the bed, or of grains that are too few to show. */
      assert_true(fabsf(vertex->durability - 3) < 1e-3f || fabsf(vertex->durability - 3 * 0.35f) < 1e-3f);
      bed += vertex->durability > 2;
      assert_int_equal(vertex->layer, 3);
    }
    /* The top's rim is an edge; the middle of its face is level. */
    if (y > 40 && vertex->normal[1] > 0.5f && vertex->normal[1] < 0.9f) edge += (double)vertex->curvature, ++edges;
    const float away = fmaxf(fabsf(vertex->position[0] - 30), fabsf(vertex->position[2] - 30));
    if (vertex->normal[1] > 0.999f && away < 5) wall += (double)vertex->curvature, ++walls;
  }
  print_message("edges %u of %.2f, level %u of %.3f, low %u, high %u, grains %u\n", edges, edge / edges, walls, wall / walls, low,
                high, grains);
  assert_true(edges > 20 && walls > 20 && low > 20 && high > 100 && bed > high * 0.95 && grains > 20);
  assert_true(fabs(wall / walls) < 0.15);
  assert_true(edge / edges > 0.15);
  scree_mesher_destroy(mesher);
  scree_weather_destroy(w);
}

/* A deep shaft is dark at its bottom, a plain is not. */
static void hollows_are_dark_and_plains_are_not(void** state) {
  (void)state;
  const uint32_t size[3] = {80, 50, 80};
  scree_weather* w = fake_weather_create(size, NULL, NULL);
  for (uint32_t z = 4; z < 76; ++z)
    for (uint32_t y = 0; y < 44; ++y)
      for (uint32_t x = 4; x < 76; ++x) {
        const bool shaft = x >= 34 && x < 46 && z >= 34 && z < 46 && y >= 10;
        if (!shaft) fake_weather_set(w, x, y, z, SCREE_VOXEL_ROCK, 1);
      }
  scree_mesher* mesher;
  scree_surface s;
  assert_int_equal(scree_mesher_create(w, &mesher), SCREE_OK);
  assert_int_equal(scree_mesher_update(mesher, 0, &s), SCREE_OK);
  uint32_t dark = 0, open = 0;
  for (uint32_t v = 0; v < s.vertex_count; ++v) {
    const scree_surface_vertex* vertex = &s.vertices[v];
    const float x = fabsf(vertex->position[0] - 40), z = fabsf(vertex->position[2] - 40), y = vertex->position[1];
    if (y < 12 && y > 5 && x < 4 && z < 4) {
      ++dark;
      assert_true(vertex->occlusion < 0.35f);
    }
    if (y > 43 && (x > 16 || z > 16) && x < 30 && z < 30) {
      ++open;
      assert_true(vertex->occlusion > 0.95f);
    }
  }
  assert_true(dark > 20 && open > 1000);
  scree_mesher_destroy(mesher);
  fake_weather_destroy(w);
}

static void threads_change_nothing(void** state) {
  (void)state;
  const uint32_t size[3] = {60, 40, 50};
  scree_threads* threads;
  assert_int_equal(scree_threads_create(3, NULL, &threads), SCREE_OK);
  const scree_jobs jobs = scree_threads_jobs(threads);
  scree_weather* w[2];
  scree_mesher* mesher[2];
  for (int i = 0; i < 2; ++i) {
    random_stream random = {3};
    w[i] = fake_weather_create(size, i == 0 ? NULL : &jobs, NULL);
    fill_with_noise(w[i], &random, 0.5);
    assert_int_equal(scree_mesher_create(w[i], &mesher[i]), SCREE_OK);
  }
  for (uint32_t level = 0; level <= 5; ++level) {
    scree_surface s[2];
    for (int i = 0; i < 2; ++i) assert_int_equal(scree_mesher_update(mesher[i], level, &s[i]), SCREE_OK);
    assert_true(same_surface(&s[0], &s[1]));
  }
  for (int i = 0; i < 2; ++i) {
    scree_mesher_destroy(mesher[i]);
    fake_weather_destroy(w[i]);
  }
  scree_threads_destroy(threads);
}

static void a_mesher_without_memory_says_so_and_goes_on(void** state) {
  (void)state;
  failing_allocator f = {.fail_at = -1};
  const scree_allocator allocator = failing_allocator_of(&f);
  const uint32_t size[3] = {30, 20, 34};
  random_stream random = {4};
  scree_weather* w = fake_weather_create(size, NULL, &allocator);
  fill_with_noise(w, &random, 0.5);
  scree_mesher *right, *mesher;
  scree_surface wanted[3], s;
  assert_int_equal(scree_mesher_create(w, &right), SCREE_OK);
  for (uint32_t level = 0; level < 3; ++level) assert_int_equal(scree_mesher_update(right, level, &wanted[level]), SCREE_OK);
  const long long before = f.live;
  uint32_t fails = 0;
  for (int32_t n = 0;; ++n) {
    f.calls = 0;
    f.failed = false;
    f.fail_at = n;
    scree_result result = scree_mesher_create(w, &mesher);
    assert_true(result == SCREE_OK || mesher == NULL);
    for (uint32_t level = 0; level < 3 && mesher != NULL; ++level) {
      result = scree_mesher_update(mesher, level, &s);
      assert_true(result == SCREE_OK || s.vertex_count == 0);
      if (result != SCREE_OK) assert_int_equal(scree_mesher_update(mesher, level, &s), SCREE_OK);
      fails += result != SCREE_OK;
      assert_true(same_surface(&wanted[level], &s));
    }
    scree_mesher_destroy(mesher);
    assert_int_equal(f.live, before);
    if (!f.failed) break;
  }
  assert_true(fails > 20);
  f.fail_at = -1;
  scree_mesher_destroy(right);
  assert_int_equal(f.live, 0);
  fake_weather_destroy(w);
}

static void nothing_has_no_surface(void** state) {
  (void)state;
  const uint32_t size[3] = {20, 20, 20};
  scree_weather* w = fake_weather_create(size, NULL, NULL);
  scree_mesher* mesher;
  scree_surface s;
  assert_int_equal(scree_mesher_create(w, &mesher), SCREE_OK);
  for (uint32_t level = 0; level <= 5; ++level) {
    assert_int_equal(scree_mesher_update(mesher, level, &s), SCREE_OK);
    assert_int_equal(s.vertex_count + s.rock_triangles + s.colluvium_triangles, 0);
  }
  assert_int_equal(scree_mesher_update(mesher, 6, &s), SCREE_ERROR_INVALID_ARGUMENT);
  scree_mesher_destroy(mesher);
  scree_mesher_destroy(NULL);
  fake_weather_destroy(w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_cube_has_at_most_one_face_that_pinches),
      cmocka_unit_test(noise_of_any_density_has_a_closed_manifold_surface_on_every_level),
      cmocka_unit_test(what_was_kept_is_what_would_be_made),
      cmocka_unit_test(levels_keep_the_volume),
      cmocka_unit_test(normals_of_a_ball_point_outward),
      cmocka_unit_test(a_wall_meets_the_ground_at_a_right_angle),
      cmocka_unit_test(random_simulations_have_right_surfaces_and_keep_them),
      cmocka_unit_test(a_cube_weathers_to_a_smooth_ball),
      cmocka_unit_test(vertices_tell_what_lies_beneath),
      cmocka_unit_test(hollows_are_dark_and_plains_are_not),
      cmocka_unit_test(threads_change_nothing),
      cmocka_unit_test(a_mesher_without_memory_says_so_and_goes_on),
      cmocka_unit_test(nothing_has_no_surface),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
