/* scree-bench-query [NAME] [PACK.scree]: how fast queries find rocks, one JSON object a line.
 *
 * Figures are millions of instances a second of one thread, medians of several runs, by the thread's own clock. `reference` is the
 * write floor measured in the same run: 16-byte records stored one after the other into the same buffer. Without a pack the field
 * is made of random tables with the shape of an n = 6 set. NAME: only figures whose name starts with it. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <scree/pack.h>

#define BENCH_PROGRAM "scree-bench-query"
#include "bench.h"
#include "query_kernel.h"
#include "random_support.h"
#include "synthetic_field.h"

enum { RUNS = 15, BALL_RINGS = 100, BALL_SIDES = 200, TERRAIN = 1024 };

typedef struct bench {
  const char* prefix;
  scree_field* field;
  scree_instance* buffer;
  uint64_t capacity;
} bench;

static bool wanted(const bench* b, const char* name) {
  return strncmp(name, b->prefix, strlen(b->prefix)) == 0;
}

/* Stores `count` records, whose values the compiler cannot foresee, RUNS times: the least that any answer costs. */
static double write_floor(bench* b, uint64_t count) {
  double times[RUNS];
  for (int run = 0; run < RUNS; ++run) {
    volatile float seed = (float)run;
    float x = seed, y = seed + 1, z = seed + 2;
    double start = seconds();
    for (uint64_t i = 0; i < count; ++i) {
      b->buffer[i] = (scree_instance){{x, y, z}, (uint32_t)i};
      __asm__ volatile("" ::"r"(b->buffer) : "memory");
    }
    times[run] = seconds() - start;
  }
  return (double)count / median(times, RUNS) * 1e-6;
}

static void report(const char* name, double value, const char* unit, double reference) {
  printf("{\"name\": \"%s\", \"value\": %.2f, \"unit\": \"%s\", \"reference\": %.2f, \"ratio\": %.4f}\n", name, value, unit,
         reference, value / reference);
  fflush(stdout);
}

static scree_support* make_support(const scree_shape* shapes, uint32_t count) {
  scree_support_desc desc = {.shapes = shapes, .shape_count = count};
  scree_support* support;
  scree_error error;
  if (scree_support_create(&desc, NULL, &support, &error) != SCREE_OK) die(error.message);
  return support;
}

static uint64_t fill(bench* b, const scree_query_desc* desc) {
  uint64_t count = 0;
  if (scree_query_fill(desc, b->buffer, NULL, b->capacity, &count) != SCREE_OK) die("the query failed");
  return count;
}

/* Median seconds; SCREE_BENCH_BEST in the environment asks for the best instead, for tuning on a busy machine. */
static double time_query(bench* b, const scree_query_desc* desc, uint64_t* count) {
  double times[RUNS];
  if (scree_query_count(desc, count) != SCREE_OK) die("the query failed");
  if (*count > b->capacity) { /* packs with many stones a cell */
    free(b->buffer);
    b->capacity = *count + FIELD_OCTET;
    b->buffer = must(malloc(b->capacity * sizeof *b->buffer));
  }
  *count = fill(b, desc);
  for (int run = 0; run < RUNS; ++run) {
    double start = seconds();
    *count = fill(b, desc);
    times[run] = seconds() - start;
  }
  double middle = median(times, RUNS);
  return getenv("SCREE_BENCH_BEST") != NULL ? times[0] : middle;
}

static void run_query(bench* b, const char* name, const scree_shape* shapes, uint32_t shape_count, uint32_t flags) {
  scree_support* support = make_support(shapes, shape_count);
  scree_query_desc desc = {.field = b->field, .support = support, .flags = flags};
  uint64_t count = 0;
  double time = time_query(b, &desc, &count);
  report(name, (double)count / time * 1e-6, "million instances/s", write_floor(b, count));
  if (getenv("SCREE_BENCH_VERBOSE") != NULL)
    fprintf(stderr, "%s: %.3f million instances, %.2f ms\n", name, (double)count * 1e-6, time * 1e3);
  scree_support_destroy(support);
}

/* --- scenes, lengths in cells ---------------------------------------------------------------------------------------------- */

static void sphere(bench* b, const char* name, float radius, uint32_t flags) {
  scree_shape ball = {.kind = SCREE_SHAPE_SPHERE, .sphere = {radius}};
  if (wanted(b, name)) run_query(b, name, &ball, 1, flags);
}

static float value_noise(uint32_t x, uint32_t z) {
  return (float)(hash_corner(17, (int32_t)x, 0, (int32_t)z) >> 40) * 0x1p-24f;
}

/* Smooth noise of one octave with this many samples between its lattice points. */
static float octave(uint32_t x, uint32_t z, uint32_t period) {
  float u = (float)(x % period) / (float)period, v = (float)(z % period) / (float)period;
  u = u * u * (3 - 2 * u);
  v = v * v * (3 - 2 * v);
  uint32_t i = x / period + period * 1000, k = z / period;
  float near_side = value_noise(i, k) + u * (value_noise(i + 1, k) - value_noise(i, k));
  float far_side = value_noise(i, k + 1) + u * (value_noise(i + 1, k + 1) - value_noise(i, k + 1));
  return near_side + v * (far_side - near_side);
}

/* Hills of 1024 x 1024 samples, two a cell, 512 x 512 cells; thick ground, of which the shell leaves the skin. */
static void heightfield_shell(bench* b) {
  const char* name = "query.heightfield_shell";
  if (!wanted(b, name)) return;
  float* heights = must(malloc(sizeof(float) * TERRAIN * TERRAIN));
  for (uint32_t z = 0; z < TERRAIN; ++z)
    for (uint32_t x = 0; x < TERRAIN; ++x) {
      float h = 0;
      for (uint32_t period = 256; period >= 4; period /= 2) h += octave(x, z, period) * (float)period * 0.2f;
      heights[z * TERRAIN + x] = h;
    }
  scree_shape ground = {.kind = SCREE_SHAPE_HEIGHTFIELD, .heightfield = {heights, TERRAIN, TERRAIN, 0.5f, 0, 40}};
  run_query(b, name, &ground, 1, SCREE_QUERY_SHELL);
  free(heights);
}

/* Ten balls and boxes, four capsules smoothly joined, a cylinder and a cone, and four balls cut out. */
static void csg20_shell(bench* b) {
  const char* name = "query.csg20_shell";
  if (!wanted(b, name)) return;
  random_stream r = {20};
  scree_shape shapes[24];
  uint32_t children[24];
  memset(shapes, 0, sizeof shapes);
  for (uint32_t i = 0; i < 24; ++i) children[i] = i;
  shapes[0] = (scree_shape){.kind = SCREE_SHAPE_DIFFERENCE, .group = {(uint32_t[]){1, 20, 21, 22, 23}, 5, 0}};
  shapes[1] = (scree_shape){.kind = SCREE_SHAPE_UNION, .group = {children + 2, 13, 0}};
  shapes[2] = (scree_shape){.kind = SCREE_SHAPE_SMOOTH_UNION, .group = {children + 15, 5, 10}};
  /* 3..14: balls, boxes, a cylinder and a cone; 15..18: capsules and 19 a ball, smooth; 20..23: cut out. */
  for (uint32_t i = 3; i < 24; ++i) {
    scree_shape* s = &shapes[i];
    for (int a = 0; a < 3; ++a) s->transform.translation[a] = (float)random_in(&r, -60, 60);
    s->transform.rotation[0] = (float)sin((double)i);
    s->transform.rotation[3] = (float)cos((double)i);
    s->kind = i < 9 || i >= 19 ? SCREE_SHAPE_SPHERE : i < 13 ? SCREE_SHAPE_BOX : i == 13 ? SCREE_SHAPE_CYLINDER : SCREE_SHAPE_CONE;
    if (i >= 15 && i < 19) s->kind = SCREE_SHAPE_CAPSULE;
    float size = (float)random_in(&r, 20, 40);
    if (s->kind == SCREE_SHAPE_SPHERE) s->sphere.radius = size;
    if (s->kind == SCREE_SHAPE_CYLINDER) s->cylinder.radius = s->cylinder.half_height = size;
    if (s->kind == SCREE_SHAPE_CONE) s->cone.radius = s->cone.height = size;
    if (s->kind == SCREE_SHAPE_BOX) s->box.half[0] = s->box.half[1] = s->box.half[2] = size;
    if (s->kind == SCREE_SHAPE_CAPSULE) {
      s->capsule.a[0] = -size;
      s->capsule.b[0] = size;
      s->capsule.radius = size * 0.4f;
    }
  }
  run_query(b, name, shapes, 24, SCREE_QUERY_SHELL);
}

/* A lumpy ball of 39,600 triangles and about 200 cells across. */
static void mesh_shell(bench* b) {
  const char* name = "query.mesh_shell";
  if (!wanted(b, name)) return;
  const uint32_t vertex_count = 2 + (BALL_RINGS - 1) * BALL_SIDES, triangle_count = 2 * BALL_SIDES * (BALL_RINGS - 1);
  float* positions = must(malloc(sizeof(float) * 3 * vertex_count));
  uint32_t* indices = must(malloc(sizeof(uint32_t) * 3 * triangle_count));
  uint32_t* to = indices;
  for (uint32_t v = 0; v < vertex_count; ++v) {
    uint32_t ring = v == 0                  ? 0
                    : v == vertex_count - 1 ? BALL_RINGS
                                            : 1 + (v - 1) / BALL_SIDES,
             side = v == 0 ? 0 : (v - 1) % BALL_SIDES;
    double theta = 3.14159265358979 * ring / BALL_RINGS, phi = 2 * 3.14159265358979 * side / BALL_SIDES;
    double radius = 80 * (1 + 0.15 * sin(5 * phi) * sin(theta) * sin(theta) + 0.1 * sin(7 * theta));
    positions[3 * v] = (float)(radius * sin(theta) * cos(phi));
    positions[3 * v + 1] = (float)(radius * cos(theta));
    positions[3 * v + 2] = (float)(-radius * sin(theta) * sin(phi));
  }
  for (uint32_t ring = 0; ring < BALL_RINGS; ++ring)
    for (uint32_t side = 0; side < BALL_SIDES; ++side) {
      uint32_t next = (side + 1) % BALL_SIDES, above = 1 + (ring - 1) * BALL_SIDES, below = 1 + ring * BALL_SIDES;
      uint32_t a = ring == 0 ? 0 : above + side, c = ring == BALL_RINGS - 1 ? vertex_count - 1 : below + side;
      if (ring < BALL_RINGS - 1) {
        const uint32_t one[3] = {a, c, below + next};
        memcpy(to, one, sizeof one);
        to += 3;
      }
      if (ring > 0) {
        const uint32_t two[3] = {a, ring < BALL_RINGS - 1 ? below + next : c, above + next};
        memcpy(to, two, sizeof two);
        to += 3;
      }
    }
  scree_shape ball = {.kind = SCREE_SHAPE_MESH, .mesh = {positions, indices, vertex_count, (uint32_t)(to - indices) / 3, 160}};
  run_query(b, name, &ball, 1, SCREE_QUERY_SHELL);
  free(positions);
  free(indices);
}

/* 500 shapes of all kinds in 50 clusters, groups and noise among them; the reference evaluates all of them everywhere. */
static void tree_500(bench* b) {
  const char* name = "query.tree_500";
  if (!wanted(b, name)) return;
  random_stream r = {500};
  random_grove grove = random_grove_create(&r, 42, 25, 200);
  scree_support* support;
  scree_error error;
  if (scree_support_create(&grove.desc, NULL, &support, &error) != SCREE_OK) die(error.message);
  const scree_query_desc desc = {.field = b->field, .support = support, .flags = SCREE_QUERY_SHELL};
  uint64_t count = 0, whole = 0;
  double fast = time_query(b, &desc, &count), times[3];
  for (int run = 0; run < 3; ++run) {
    double start = seconds();
    if (scree_rt_query_fill(&desc, QUERY_KERNEL_WHOLE, b->buffer, NULL, b->capacity, &whole) != SCREE_OK) die("the query failed");
    times[run] = seconds() - start;
  }
  if (whole != count) die("pruning changes what is found");
  report(name, (double)count / fast * 1e-6, "million instances/s", (double)count / median(times, 3) * 1e-6);
  if (getenv("SCREE_BENCH_VERBOSE") != NULL)
    fprintf(stderr, "%s: %u shapes, %.3f million instances, %.2f ms\n", name, grove.desc.shape_count, (double)count * 1e-6,
            fast * 1e3);
  scree_support_destroy(support);
  random_grove_destroy(&grove);
}

/* --- brute force ----------------------------------------------------------------------------------------------------------- */

/* Every rock of every cube from low to high - 1 along each axis, tested and kept or not. */
static uint64_t brute_force(bench* b, const scree_support* support, int32_t low, int32_t high, float depth) {
  const scree_field* f = b->field;
  float x[SUPPORT_BATCH], y[SUPPORT_BATCH], z[SUPPORT_BATCH], d[SUPPORT_BATCH];
  uint64_t count = 0;
  for (int32_t k = low; k < high; ++k)
    for (int32_t j = low; j < high; ++j)
      for (int32_t i = low; i < high; ++i) {
        const field_tile* tile = &f->tiles[scree_field_tile_code(f, (int32_t[]){i, j, k})];
        tile_slots s = field_slots(f, tile);
        const float base[3] = {(float)(i * f->cell_size * f->cells_per_cube), (float)(j * f->cell_size * f->cells_per_cube),
                               (float)(k * f->cell_size * f->cells_per_cube)};
        float h = (float)f->cell_size;
        for (uint32_t first = 0; first < tile->block_first[FIELD_BLOCKS]; first += SUPPORT_BATCH) {
          uint32_t n = tile->block_first[FIELD_BLOCKS] - first;
          if (n > SUPPORT_BATCH) n = SUPPORT_BATCH;
          for (uint32_t q = 0; q < n; ++q) {
            x[q] = base[0] + h * s.cx[first + q] + s.x[first + q];
            y[q] = base[1] + h * s.cy[first + q] + s.y[first + q];
            z[q] = base[2] + h * s.cz[first + q] + s.z[first + q];
          }
          scree_support_distance(support, x, y, z, d, n);
          for (uint32_t q = 0; q < n; ++q)
            if (d[q] <= 0 && d[q] > -depth)
              b->buffer[count++] =
                  (scree_instance){{x[q] - s.x[first + q], y[q] - s.y[first + q], z[q] - s.z[first + q]}, s.asset[first + q]};
        }
      }
  return count;
}

static void vs_bruteforce(bench* b) {
  const char* name = "query.vs_bruteforce";
  if (!wanted(b, name)) return;
  const float radius = 140;
  scree_shape ball = {.kind = SCREE_SHAPE_SPHERE, .sphere = {radius}};
  scree_support* support = make_support(&ball, 1);
  scree_query_desc desc = {.field = b->field, .support = support, .flags = SCREE_QUERY_SHELL};
  uint64_t count = 0;
  double fast = time_query(b, &desc, &count), times[3];
  int32_t reach = (int32_t)ceilf(radius / (float)(b->field->cells_per_cube)) + 1;
  for (int run = 0; run < 3; ++run) {
    double start = seconds();
    uint64_t found = brute_force(b, support, -reach, reach, 2 * b->field->max_radius);
    times[run] = seconds() - start;
    if (found + 10 < count || found > count + 10) die("brute force does not find the same rocks");
  }
  double slow = median(times, 3);
  report(name, (double)count / fast * 1e-6, "million instances/s", (double)count / slow * 1e-6);
  scree_support_destroy(support);
}

int main(int argc, char** argv) {
  bench b = {argc > 1 ? argv[1] : "", NULL, NULL, 12000000};
  scree_field_desc desc = {.seed = 2009, .cell_size = 1};
  scree_pack* pack = NULL;
  synthetic_source source = {0};
  if (argc > 3) die("usage: scree-bench-query [NAME] [PACK.scree]");
  if (argc > 2) {
    if (scree_pack_open_file(argv[2], NULL, &pack) != SCREE_OK) die("the pack cannot be opened");
    desc.pack = pack;
    if (scree_field_create(&desc, NULL, &b.field) != SCREE_OK) die("the pack cannot be used");
  } else {
    source = synthetic_create(5, 1, 1, 1);
    if (scree_rt_field_create_from_source(&desc, &source.source, NULL, &b.field) != SCREE_OK) die("no field");
  }
  b.buffer = must(malloc(b.capacity * sizeof *b.buffer));
  memset(b.buffer, 1, b.capacity * sizeof *b.buffer);

  sphere(&b, "query.sphere_full", 130, 0);
  sphere(&b, "query.sphere_shell", 280, SCREE_QUERY_SHELL);
  heightfield_shell(&b);
  csg20_shell(&b);
  mesh_shell(&b);
  tree_500(&b);
  vs_bruteforce(&b);

  free(b.buffer);
  scree_field_destroy(b.field);
  synthetic_destroy(&source);
  scree_pack_close(pack);
  return 0;
}
