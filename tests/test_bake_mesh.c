/* The meshes of rocks, their masses, balls, hulls and errors, against slow and plain twins. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "lattice.h"
#include "mesh_twin.h"
#include "tiling.h"

static void* need(size_t count, size_t size) {
  void* memory = calloc(count + 1, size);
  assert_non_null(memory);
  return memory;
}

static twin_mesh mesh_of(const bake_worker* worker, uint32_t level) {
  const mesh_buffer* mesh = &worker->mesher.meshes[level];
  return (twin_mesh){(const int16_t(*)[3])mesh->positions, mesh->indices, mesh->vertex_count, mesh->index_count / 3};
}

/* Boulders, pebbles, flat stones, gravel, and rocks that noise and erosion nearly carve to pieces. */
static scree_recipe recipe_of(int kind) {
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  recipe.n = 4;
  recipe.voxels_per_cell = 10;
  recipe.random_seed = 11 + (uint64_t)kind;
  if (kind == 1) recipe.noise = 0, recipe.chisel_planes = 0, recipe.contact_radius = 0.12, recipe.voxels_per_cell = 12;
  if (kind == 2) recipe.gamma = (scree_range){4, 6}, recipe.orientation = SCREE_ORIENTATION_ALIGNED, recipe.voxels_per_cell = 14;
  if (kind == 3) recipe.seeds_min = 3, recipe.seeds_max = 6, recipe.erosion = 0.035, recipe.contact_radius = 0.04;
  if (kind == 4) {
    recipe.seeds_max = 3;
    recipe.alpha = recipe.beta = (scree_range){3, 5};
    recipe.noise = 0.3;
    recipe.voxels_per_cell = 6;
    recipe.lod_levels = 6;
    recipe.lattice_steps = 2;
    recipe.hull_vertices = 8;
  }
  return recipe;
}
enum { KINDS = 5 };
static const char* const kind_names[KINDS] = {"boulders", "pebbles", "flat stones", "gravel", "crumbs"};

typedef void rock_visitor(const bake_run* bake, const bake_worker* worker, const rock_record* rock, void* context);

/* Meshes the rocks of every `stride`-th unique cell, or of those that `wanted` names, and shows them. What a bake does for each
 * rock, but without its encoding. Returns how many there were. */
static uint32_t visit_rocks(const scree_recipe* recipe, uint32_t stride, const uint8_t* wanted, rock_visitor* visit,
                            void* context) {
  const scree_bake_desc desc = {.recipe = recipe};
  bake_run bake;
  assert_int_equal(bake_begin(&desc, false, &bake), SCREE_OK);
  bake_worker* worker = &bake.workers[0];
  uint32_t rocks = 0;
  for (uint32_t i = 0; i < bake.cell_count; i += stride) {
    const uint32_t cell = bake.cells[i];
    for (uint32_t seed = 0; seed < bake.cell_rocks[cell + 1] - bake.cell_rocks[cell]; ++seed) {
      if ((wanted != NULL && !wanted[cell]) || !bake_rock_field(&bake, worker, cell, seed)) continue;
      assert_int_equal(rock_mesh(&worker->mesher, &worker->rock, recipe->lod_levels), SCREE_OK);
      int16_t hull[ROCK_MAX_HULL][3];
      rock_record rock = {.cell = cell, .seed = seed, .hull = hull};
      rock_mass(&worker->mesher.meshes[0], 1.0f / (float)(recipe->lattice_steps * recipe->voxels_per_cell), &rock);
      rock.hull_count = rock_hull(&worker->mesher, recipe->hull_vertices, hull);
      visit(&bake, worker, &rock, context);
      ++rocks;
    }
  }
  bake_end(&bake);
  return rocks;
}

/* --- Manifolds. --- */

typedef struct manifold_sum {
  mesh_faults faults[ROCK_MAX_LODS];
  uint64_t triangles[ROCK_MAX_LODS];
  uint32_t hollow;          /* meshes without a volume */
  double least, most, mean; /* volume of a coarse level over that of the finest */
} manifold_sum;

static void add_faults(const bake_run* bake, const bake_worker* worker, const rock_record* rock, void* context) {
  (void)rock;
  manifold_sum* sum = context;
  double finest = 0;
  for (uint32_t level = 0; level < bake->recipe.lod_levels; ++level) {
    const twin_mesh mesh = mesh_of(worker, level);
    const mesh_faults faults = mesh_find_faults(&mesh);
    for (size_t i = 0; i < sizeof faults / sizeof(uint32_t); ++i)
      ((uint32_t*)&sum->faults[level])[i] += ((const uint32_t*)&faults)[i];
    sum->triangles[level] += mesh.triangle_count;
    double volume, centroid[3];
    mesh_mass(&mesh, &volume, centroid);
    sum->hollow += !(volume > 0);
    if (level == 0) finest = volume;
    sum->least = fmin(sum->least, volume / finest);
    sum->most = fmax(sum->most, volume / finest);
    sum->mean += volume / finest / bake->recipe.lod_levels;
  }
}

static void every_level_is_a_closed_manifold_that_holds_the_volume_of_the_finest(void** state) {
  (void)state;
  uint32_t all_faults = 0, hollow = 0;
  for (int kind = 0; kind < KINDS; ++kind) {
    const scree_recipe recipe = recipe_of(kind);
    manifold_sum sum = {.least = 1, .most = 1};
    const uint32_t rocks = visit_rocks(&recipe, kind == 3 ? 4 : 1, NULL, add_faults, &sum);
    for (uint32_t level = 0; level < recipe.lod_levels; ++level) {
      const mesh_faults* f = &sum.faults[level];
      all_faults += mesh_fault_sum(f);
      print_message(
          "%-11s LOD%u of %u rocks, %7.1f triangles: %u repeated corners, %u flat, %u shared and %u open edges, %u pinched, %u "
          "unused and %u repeated vertices\n",
          kind_names[kind], level, rocks, (double)sum.triangles[level] / rocks, f->repeated_corners, f->flat_triangles,
          f->shared_edges, f->open_edges, f->pinched_vertices, f->unused_vertices, f->repeated_vertices);
    }
    print_message("%-11s levels hold %.3f of the finest's volume, %.3f at least, %.3f at most\n", kind_names[kind],
                  sum.mean / rocks, sum.least, sum.most);
    assert_true(rocks > 1000);
    assert_true(sum.least > 0.79 && sum.most < 1.21);
    assert_true(fabs(sum.mean / rocks - 1) < 0.02);
    hollow += sum.hollow;
  }
  assert_int_equal(all_faults, 0);
  assert_int_equal(hollow, 0);
}

/* --- Mass. --- */

typedef struct mass_sum {
  uint32_t wrong_bounds, wrong_mass, wrong_outer, wrong_inner, no_inner;
  double tightness; /* inner radius over the true one, summed over rocks whose centroid lies inside */
  uint32_t inside;
} mass_sum;

static bool near(double a, double b, double tolerance) {
  return fabs(a - b) <= tolerance;
}

static void check_mass(const bake_run* bake, const bake_worker* worker, const rock_record* rock, void* context) {
  mass_sum* sum = context;
  const twin_mesh mesh = mesh_of(worker, 0);
  const double lattice = bake->recipe.lattice_steps * bake->recipe.voxels_per_cell;
  double volume, centroid[3], outer = 0, farthest_off = 0;
  mesh_mass(&mesh, &volume, centroid);
  bool bounds = true;
  for (int axis = 0; axis < 3; ++axis) {
    int32_t low = INT32_MAX, high = INT32_MIN;
    for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
      if (mesh.positions[v][axis] < low) low = mesh.positions[v][axis];
      if (mesh.positions[v][axis] > high) high = mesh.positions[v][axis];
    }
    bounds = bounds && rock->bounds_min[axis] == low && rock->bounds_max[axis] == high;
    farthest_off = fmax(farthest_off, fabs(rock->centroid[axis] - centroid[axis] / lattice));
  }
  sum->wrong_bounds += !bounds;
  sum->wrong_mass += !near(rock->volume, volume / (lattice * lattice * lattice), 1e-5 * rock->volume + 1e-9) || farthest_off > 1e-5;
  double middle[3];
  for (int axis = 0; axis < 3; ++axis) middle[axis] = (double)rock->centroid[axis] * lattice;
  for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
    double d2 = 0;
    for (int axis = 0; axis < 3; ++axis) d2 += pow(mesh.positions[v][axis] - middle[axis], 2);
    outer = fmax(outer, sqrt(d2) / lattice);
  }
  sum->wrong_outer += !(rock->outer_radius >= outer - 1e-6 && rock->outer_radius <= outer * (1 + 1e-5));
  const double inner = mesh_distance(&mesh, middle, 0) / lattice;
  if (mesh_winding(&mesh, middle) > 0.5) {
    sum->wrong_inner += !(rock->inner_radius <= inner + 1e-6);
    sum->tightness += inner > 0 ? rock->inner_radius / inner : 1;
    ++sum->inside;
  } else {
    sum->wrong_inner += rock->inner_radius > 0;
  }
  sum->no_inner += !(rock->inner_radius > 0);
}

static void bounds_mass_and_balls_are_those_of_the_mesh(void** state) {
  (void)state;
  for (int kind = 0; kind < KINDS; ++kind) {
    scree_recipe recipe = recipe_of(kind);
    recipe.lod_levels = 1;
    mass_sum sum = {0};
    const uint32_t rocks = visit_rocks(&recipe, kind == 3 ? 16 : 2, NULL, check_mass, &sum);
    print_message(
        "%-11s %u rocks: %u bounds, %u masses, %u outer and %u inner balls wrong; inner ball %.2f of the largest there is, %u "
        "rocks without; %u centroids outside\n",
        kind_names[kind], rocks, sum.wrong_bounds, sum.wrong_mass, sum.wrong_outer, sum.wrong_inner, sum.tightness / sum.inside,
        sum.no_inner, rocks - sum.inside);
    assert_int_equal(sum.wrong_bounds, 0);
    assert_int_equal(sum.wrong_mass, 0);
    assert_int_equal(sum.wrong_outer, 0);
    assert_int_equal(sum.wrong_inner, 0);
    /* Stones of a few voxels have edges as long as they are thick, which the bound takes off. */
    assert_true(sum.tightness / sum.inside > (kind == 4 ? 0.1 : 0.5));
  }
}

/* --- Levels of detail. --- */

typedef struct error_sum {
  double given[ROCK_MAX_LODS], at_vertices[ROCK_MAX_LODS], between[ROCK_MAX_LODS], back[ROCK_MAX_LODS]; /* largest, cells */
  double given_mean[ROCK_MAX_LODS], true_mean[ROCK_MAX_LODS];
  uint32_t too_small, falling, between_more, back_more;
  double worst_between; /* largest of (distance - error), cells */
  uint64_t random;
} error_sum;

/* A point of the surface: vertex v, or a random point of triangle v. */
static void surface_point(const twin_mesh* mesh, uint32_t v, bool vertex, uint64_t* random, double out[3]) {
  double weight[3] = {1, 0, 0};
  const uint32_t single[3] = {v, v, v};
  const uint32_t* corners = vertex ? single : mesh->indices + (size_t)3 * v;
  if (!vertex) {
    *random = hash_mix(*random + UINT64_C(0x9e3779b97f4a7c15));
    double s = (double)(*random >> 40) * 0x1p-24, t = (double)(*random << 24 >> 40) * 0x1p-24;
    if (s + t > 1) s = 1 - s, t = 1 - t;
    weight[0] = 1 - s - t, weight[1] = s, weight[2] = t;
  }
  for (int axis = 0; axis < 3; ++axis) {
    out[axis] = 0;
    for (int k = 0; k < 3; ++k) out[axis] += weight[k] * mesh->positions[corners[k]][axis];
  }
}

static void check_errors(const bake_run* bake, const bake_worker* worker, const rock_record* rock, void* context) {
  (void)rock;
  error_sum* sum = context;
  const double lattice = bake->recipe.lattice_steps * bake->recipe.voxels_per_cell;
  const twin_mesh fine = mesh_of(worker, 0);
  assert_true(worker->mesher.errors[0] == 0);
  for (uint32_t level = 1; level < bake->recipe.lod_levels; ++level) {
    const twin_mesh coarse = mesh_of(worker, level);
    const double error = worker->mesher.errors[level];
    double p[3], at_vertices = 0, between = 0, back = 0;
    for (uint32_t v = 0; v < fine.vertex_count; ++v) {
      surface_point(&fine, v, true, &sum->random, p);
      at_vertices = fmax(at_vertices, mesh_distance(&coarse, p, at_vertices * lattice) / lattice);
    }
    for (uint32_t t = 0; t < fine.triangle_count; ++t) {
      surface_point(&fine, t, false, &sum->random, p);
      between = fmax(between, mesh_distance(&coarse, p, between * lattice) / lattice);
    }
    for (uint32_t t = 0; t < coarse.triangle_count; ++t) {
      surface_point(&coarse, t, false, &sum->random, p);
      back = fmax(back, mesh_distance(&fine, p, back * lattice) / lattice);
    }
    sum->given[level] = fmax(sum->given[level], error);
    sum->at_vertices[level] = fmax(sum->at_vertices[level], at_vertices);
    sum->between[level] = fmax(sum->between[level], between);
    sum->back[level] = fmax(sum->back[level], back);
    sum->given_mean[level] += error;
    sum->true_mean[level] += fmax(at_vertices, between);
    sum->too_small += !(error >= at_vertices - 1e-5);
    sum->between_more += between > error + 1e-5;
    sum->back_more += back > error + 1e-5;
    sum->worst_between = fmax(sum->worst_between, between - error);
    sum->falling += worker->mesher.errors[level] < worker->mesher.errors[level - 1];
  }
}

static void errors_of_levels_bound_the_distance_to_the_finest(void** state) {
  (void)state;
  for (int kind = 0; kind < KINDS; ++kind) {
    const scree_recipe recipe = recipe_of(kind);
    error_sum sum = {.random = 7};
    const uint32_t rocks = visit_rocks(&recipe, kind == 3 ? 400 : 97, NULL, check_errors, &sum);
    for (uint32_t level = 1; level < recipe.lod_levels; ++level)
      print_message(
          "%-11s LOD%u of %u rocks: error %.4f cells at most, true %.4f at vertices, %.4f between, %.4f back; means %.4f and "
          "%.4f\n",
          kind_names[kind], level, rocks, sum.given[level], sum.at_vertices[level], sum.between[level], sum.back[level],
          sum.given_mean[level] / rocks, sum.true_mean[level] / rocks);
    print_message(
        "            %u errors are less than a vertex is away, %u less than a point between, by %.4f cells at most; %u less than "
        "the way "
        "back\n",
        sum.too_small, sum.between_more, sum.worst_between, sum.back_more);
    assert_int_equal(sum.too_small, 0);
    assert_int_equal(sum.falling, 0);
    /* The error is that of vertices; a fine triangle between them is no larger than a voxel. */
    assert_true(sum.worst_between < 0.02);
  }
}

/* Asked of many rocks, because few have an arm that averaging takes off. */
static void count_lost_arms(const bake_run* bake, const bake_worker* worker, const rock_record* rock, void* context) {
  (void)rock;
  static const double voxels[ROCK_MAX_LODS] = {1, 2, 3, 4, 6, 8};
  uint32_t* lost = context;
  for (uint32_t level = 1; level < bake->recipe.lod_levels; ++level)
    *lost += (double)worker->mesher.errors[level] * bake->recipe.voxels_per_cell > 1.25 * voxels[level] + 1e-4;
}

static void no_level_loses_an_arm_of_its_rock(void** state) {
  (void)state;
  static const int kinds[3] = {0, 2, 4}; /* those that have arms */
  for (int i = 0; i < 3; ++i) {
    const scree_recipe recipe = recipe_of(kinds[i]);
    uint32_t lost = 0;
    assert_true(visit_rocks(&recipe, 3, NULL, count_lost_arms, &lost) > 500);
    assert_int_equal(lost, 0);
  }
}

/* --- Hulls. --- */

typedef struct hull_sum {
  double worst, mean; /* how far mesh vertices stick out, cells */
  uint32_t strangers, doubles, few, vertices;
} hull_sum;

static void check_hull(const bake_run* bake, const bake_worker* worker, const rock_record* rock, void* context) {
  hull_sum* sum = context;
  const twin_mesh mesh = mesh_of(worker, 0);
  const double lattice = bake->recipe.lattice_steps * bake->recipe.voxels_per_cell;
  for (uint32_t h = 0; h < rock->hull_count; ++h) {
    bool found = false;
    for (uint32_t v = 0; v < mesh.vertex_count && !found; ++v)
      found = memcmp(mesh.positions[v], rock->hull[h], sizeof *rock->hull) == 0;
    sum->strangers += !found;
    for (uint32_t k = 0; k < h; ++k) sum->doubles += memcmp(rock->hull[k], rock->hull[h], sizeof *rock->hull) == 0;
  }
  sum->few += rock->hull_count < 4 || rock->hull_count > bake->recipe.hull_vertices;
  double worst = 0;
  for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
    const double p[3] = {mesh.positions[v][0], mesh.positions[v][1], mesh.positions[v][2]};
    worst = fmax(worst, hull_distance((const int16_t(*)[3])rock->hull, rock->hull_count, p, 0.02 * lattice) / lattice);
  }
  sum->worst = fmax(sum->worst, worst);
  sum->mean += worst;
  sum->vertices += rock->hull_count;
}

static void hulls_hold_nearly_all_of_the_mesh(void** state) {
  (void)state;
  for (int kind = 0; kind < KINDS; ++kind) {
    const scree_recipe recipe = recipe_of(kind);
    hull_sum sum = {0};
    const uint32_t rocks = visit_rocks(&recipe, kind == 3 ? 200 : 31, NULL, check_hull, &sum);
    print_message("%-11s %u rocks, %.1f hull vertices: the mesh sticks out %.3f cells at most, %.3f on average\n", kind_names[kind],
                  rocks, (double)sum.vertices / rocks, sum.worst, sum.mean / rocks);
    assert_int_equal(sum.strangers, 0);
    assert_int_equal(sum.doubles, 0);
    assert_int_equal(sum.few, 0);
    /* A few directions only leave more out, and 8 vertices are for boxes. */
    assert_true(sum.worst < (recipe.hull_vertices < 32 ? 0.8 : 0.25));
  }
}

/* --- Ambient occlusion. --- */

typedef struct shade_sum {
  double hollow, ridge; /* sums over vertices that lie below or above their neighbours */
  uint64_t hollows, ridges, least, most;
} shade_sum;

static void check_shade(const bake_run* bake, const bake_worker* worker, const rock_record* rock, void* context) {
  (void)rock;
  shade_sum* sum = context;
  for (uint32_t level = 0; level < bake->recipe.lod_levels; ++level) {
    const twin_mesh mesh = mesh_of(worker, level);
    const uint8_t* shade = worker->mesher.meshes[level].occlusion;
    double(*around)[7] = need(mesh.vertex_count, sizeof *around); /* sum of neighbours, of normals, and their number */
    for (uint32_t t = 0; t < mesh.triangle_count; ++t) {
      const uint32_t* v = mesh.indices + (size_t)3 * t;
      double p[3][3], u[3], w[3];
      for (int k = 0; k < 3; ++k)
        for (int axis = 0; axis < 3; ++axis) p[k][axis] = mesh.positions[v[k]][axis];
      for (int axis = 0; axis < 3; ++axis) u[axis] = p[1][axis] - p[0][axis], w[axis] = p[2][axis] - p[0][axis];
      const double normal[3] = {u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]};
      for (int k = 0; k < 3; ++k) {
        for (int axis = 0; axis < 3; ++axis) {
          around[v[k]][axis] += p[(k + 1) % 3][axis];
          around[v[k]][3 + axis] += normal[axis];
        }
        around[v[k]][6] += 1;
      }
    }
    for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
      double height = 0, length2 = 0;
      for (int axis = 0; axis < 3; ++axis) {
        height += (mesh.positions[v][axis] - around[v][axis] / around[v][6]) * around[v][3 + axis];
        length2 += around[v][3 + axis] * around[v][3 + axis];
      }
      height /= sqrt(length2) * bake->recipe.lattice_steps; /* voxels above the neighbours' mean */
      if (height < -0.1) sum->hollow += shade[v], ++sum->hollows;
      if (height > 0.3) sum->ridge += shade[v], ++sum->ridges;
      if (shade[v] < sum->least) sum->least = shade[v];
      if (shade[v] > sum->most) sum->most = shade[v];
    }
    free(around);
  }
}

static void hollows_are_darker_than_ridges(void** state) {
  (void)state;
  for (int kind = 0; kind + 1 < KINDS; ++kind) { /* crumbs have no hollows to speak of */
    const scree_recipe recipe = recipe_of(kind);
    shade_sum sum = {.least = 255};
    visit_rocks(&recipe, kind == 3 ? 40 : 7, NULL, check_shade, &sum);
    print_message("%-11s ambient visibility %llu..%llu; %.1f in %llu hollows, %.1f on %llu ridges\n", kind_names[kind],
                  (unsigned long long)sum.least, (unsigned long long)sum.most, sum.hollow / (double)sum.hollows,
                  (unsigned long long)sum.hollows, sum.ridge / (double)sum.ridges, (unsigned long long)sum.ridges);
    assert_true(sum.hollows > 20 && sum.ridges > 1000);
    assert_true(sum.least < 230 && sum.most > 240);
    assert_true(sum.hollow / (double)sum.hollows < sum.ridge / (double)sum.ridges);
  }
}

/* --- Neighbours. --- */

typedef struct solids {
  const bake_run* bake;
  mesh_columns* by_slot; /* mesh.vertex_count is 0 where nothing was left */
} solids;

static void keep_solid(const bake_run* bake, const bake_worker* worker, const rock_record* rock, void* context) {
  solids* set = context;
  const twin_mesh from = mesh_of(worker, 0);
  int16_t(*positions)[3] = need(from.vertex_count, sizeof *positions);
  uint32_t* indices = need((size_t)3 * from.triangle_count, sizeof *indices);
  memcpy(positions, from.positions, from.vertex_count * sizeof *positions);
  memcpy(indices, from.indices, (size_t)3 * from.triangle_count * sizeof *indices);
  const twin_mesh kept = {(const int16_t(*)[3])positions, indices, from.vertex_count, from.triangle_count};
  mesh_columns_create(&kept, &set->by_slot[bake->cell_rocks[rock->cell] + rock->seed]);
}

typedef struct depths {
  uint64_t rocks, vertices, inside, deeper;
  double deepest; /* voxels */
} depths;

static void look_into_neighbours(const bake_run* bake, const tiling_box* box, const mesh_columns* by_slot, const int32_t cell[3],
                                 uint32_t seed, depths* found) {
  const int32_t lattice = (int32_t)(bake->recipe.lattice_steps * bake->recipe.voxels_per_cell);
  const mesh_columns* own = &by_slot[bake->cell_rocks[box->unique[tiling_box_index(box, cell)]] + seed];
  ++found->rocks;
  found->vertices += own->mesh.vertex_count;
  for (int32_t neighbour = 0; neighbour < 27; ++neighbour) {
    const int32_t offset[3] = {neighbour % 3 - 1, neighbour / 3 % 3 - 1, neighbour / 9 - 1};
    const int32_t other[3] = {cell[0] + offset[0], cell[1] + offset[1], cell[2] + offset[2]};
    const uint32_t index = tiling_box_index(box, other), count = box->first[index + 1] - box->first[index];
    for (uint32_t s = 0; s < count; ++s) {
      if (neighbour == 13 && s == seed) continue;
      const mesh_columns* theirs = &by_slot[bake->cell_rocks[box->unique[index]] + s];
      if (theirs->mesh.vertex_count == 0) continue;
      for (uint32_t v = 0; v < own->mesh.vertex_count; ++v) {
        int32_t p[3];
        for (int axis = 0; axis < 3; ++axis) p[axis] = own->mesh.positions[v][axis] - offset[axis] * lattice;
        if (!mesh_holds(theirs, p)) continue;
        const double point[3] = {p[0], p[1], p[2]};
        const double depth = mesh_distance(&theirs->mesh, point, 0) / bake->recipe.lattice_steps;
        ++found->inside;
        found->deeper += depth > 0.3;
        found->deepest = fmax(found->deepest, depth);
      }
    }
  }
}

static void no_vertex_lies_deep_inside_a_neighbour(void** state) {
  (void)state;
  static const int32_t cubes[KINDS] = {6, 4, 4, 2, 4};
  for (int kind = 0; kind < KINDS; ++kind) {
    scree_recipe recipe = recipe_of(kind);
    recipe.lod_levels = 1;
    if (kind == 4) recipe.lattice_steps = 8; /* half a voxel is as fine as 2 steps go */
    const scree_bake_desc desc = {.recipe = &recipe};
    bake_run bake;
    assert_int_equal(bake_begin(&desc, false, &bake), SCREE_OK);
    solids set = {&bake, need(bake.slot_count, sizeof *set.by_slot)};
    tiling lattice;
    tiling_create(UINT64_C(0xdeeb), &bake.seeds, &lattice);
    const int32_t cells = cubes[kind] * (int32_t)bake.seeds.n, low[3] = {-1, -1, -1}, size[3] = {cells + 2, cells + 2, cells + 2};
    tiling_box box;
    tiling_box_create(&lattice, low, size, &box);
    uint8_t* wanted = need(bake.cell_count, 1);
    for (int32_t i = 0; i < size[0] * size[1] * size[2]; ++i) wanted[box.unique[i]] = 1;
    visit_rocks(&recipe, 1, wanted, keep_solid, &set);
    free(wanted);
    depths found = {0};
    int32_t cell[3];
    for (cell[2] = 0; cell[2] < cells; ++cell[2])
      for (cell[1] = 0; cell[1] < cells; ++cell[1])
        for (cell[0] = 0; cell[0] < cells; ++cell[0]) {
          const uint32_t index = tiling_box_index(&box, cell);
          for (uint32_t seed = 0; seed < box.first[index + 1] - box.first[index]; ++seed)
            look_into_neighbours(&bake, &box, set.by_slot, cell, seed, &found);
        }
    print_message("%-11s %llu rocks: %llu of %llu vertices inside a neighbour, %.3f voxel deep at most, %llu deeper than 0.3\n",
                  kind_names[kind], (unsigned long long)found.rocks, (unsigned long long)found.inside,
                  (unsigned long long)found.vertices, found.deepest, (unsigned long long)found.deeper);
    for (uint32_t slot = 0; slot < bake.slot_count; ++slot) {
      free((void*)set.by_slot[slot].mesh.positions);
      free((void*)set.by_slot[slot].mesh.indices);
      mesh_columns_destroy(&set.by_slot[slot]);
    }
    free(set.by_slot);
    tiling_box_destroy(&box);
    tiling_destroy(&lattice);
    bake_end(&bake);
    assert_true(found.rocks > 200);
    assert_int_equal(found.deeper, 0);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_level_is_a_closed_manifold_that_holds_the_volume_of_the_finest),
      cmocka_unit_test(bounds_mass_and_balls_are_those_of_the_mesh),
      cmocka_unit_test(no_level_loses_an_arm_of_its_rock),
      cmocka_unit_test(errors_of_levels_bound_the_distance_to_the_finest),
      cmocka_unit_test(hulls_hold_nearly_all_of_the_mesh),
      cmocka_unit_test(hollows_are_darker_than_ridges),
      cmocka_unit_test(no_vertex_lies_deep_inside_a_neighbour),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
