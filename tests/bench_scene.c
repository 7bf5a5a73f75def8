/* scree-bench-scene [NAME] [PACK.scree]: what questions about scenes cost, one JSON object a line.
 *
 * Medians of several runs of one thread, by its own clock. `reference` is the plain way to the same answer, measured in the same
 * run: every rock, or every pair of points, one after the other. Without a pack: build/packs/boulders.scree if it is there,
 * otherwise a field of random tables. NAME: only figures whose name starts with it. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define BENCH_PROGRAM "scree-bench-scene"
#include "bench.h"
#include "scene_spatial.h"
#include "synthetic_field.h"

enum { RUNS = 9, RAYS = 1000, PLAIN_RAYS = 20, BODIES = 100, HULLS = 1000, PAIRS = 20 };

typedef struct bench {
  const char* prefix;
  scree_field* field;
  scree_scratch* scratch;
} bench;

static bool wanted(const bench* b, const char* name) {
  return strncmp(name, b->prefix, strlen(b->prefix)) == 0;
}

static void report(const char* name, double value, const char* unit, double reference) {
  printf("{\"name\": \"%s\", \"value\": %.3f, \"unit\": \"%s\", \"reference\": %.3f, \"ratio\": %.6f}\n", name, value, unit,
         reference, value / reference);
  fflush(stdout);
}

/* --- spatial questions: a ball of 100,000 rocks ------------------------------------------------------------------------------ */

typedef struct ball {
  scree_support* support;
  scree_scene* scene;
  scree_rock* rocks;
  uint64_t count;
  double radius;
} ball;

static ball make_ball(bench* b, double rocks) {
  ball o = {.radius = b->field->cell_size * cbrt(rocks * 0.75 / 3.14159265358979)};
  const scree_shape shape = {.kind = SCREE_SHAPE_SPHERE, .sphere = {.radius = (float)o.radius}};
  const scree_support_desc support = {.shapes = &shape, .shape_count = 1};
  if (scree_support_create(&support, NULL, &o.support, NULL) != SCREE_OK) die("no support");
  const scree_layer layer = {.field = b->field, .support = o.support};
  if (scree_scene_create(&(scree_scene_desc){&layer, 1}, NULL, &o.scene, NULL) != SCREE_OK) die("no scene");
  const scree_scene_query_desc all = {.scene = o.scene};
  if (scree_scene_count(&all, b->scratch, &o.count) != SCREE_OK) die("the scene cannot be counted");
  o.rocks = must(malloc((size_t)o.count * sizeof *o.rocks));
  if (scree_scene_fill(&all, b->scratch, o.rocks, o.count, &o.count) != SCREE_OK) die("the scene cannot be read");
  return o;
}

static void free_ball(ball* o) {
  free(o->rocks);
  scree_scene_destroy(o->scene);
  scree_support_destroy(o->support);
}

static void random_ray(random_stream* r, const ball* o, double start[3], double direction[3]) {
  double length2 = 0;
  for (int a = 0; a < 3; ++a) {
    start[a] = random_in(r, -1, 1);
    length2 += start[a] * start[a];
  }
  for (int a = 0; a < 3; ++a) {
    start[a] *= 3 * o->radius / sqrt(length2);
    direction[a] = random_in(r, -0.5, 0.5) * o->radius - start[a];
  }
}

/* Seconds a ray, testing every rock's ball and then its hull. Stores the sum of the distances, so that it is not in vain. */
static double plain_rays(const ball* o, double* sum) {
  const scene_layer* layer = &o->scene->layers[0];
  random_stream r = {1};
  const double begin = seconds();
  for (int i = 0; i < PLAIN_RAYS; ++i) {
    double start[3], along[3], length2 = 0, best = 1e6;
    random_ray(&r, o, start, along);
    for (int a = 0; a < 3; ++a) length2 += along[a] * along[a];
    for (int a = 0; a < 3; ++a) along[a] /= sqrt(length2);
    for (uint64_t k = 0; k < o->count; ++k) {
      const spatial_place place = scree_rt_spatial_place(layer, &o->rocks[k], start);
      const double* c = place.centroid;
      const double middle = c[0] * along[0] + c[1] * along[1] + c[2] * along[2];
      const double away2 = c[0] * c[0] + c[1] * c[1] + c[2] * c[2] - middle * middle;
      spatial_hull hull;
      double t, normal[3];
      if (away2 > place.radius * place.radius || middle - place.radius > best) continue;
      if (!scree_rt_spatial_hull(layer, o->rocks[k].asset, place.home, &hull)) continue;
      if (scree_rt_convex_ray(&hull.hull, (const double[3]){0, 0, 0}, along, best, &t, normal)) best = t;
    }
    *sum += best;
  }
  return (seconds() - begin) / PLAIN_RAYS;
}

static void ray(bench* b) {
  if (!wanted(b, "scene.ray")) return;
  ball o = make_ball(b, 100000);
  double times[RUNS], sum = 0, plain_sum = 0;
  for (int run = 0; run < RUNS; ++run) {
    random_stream r = {1};
    const double begin = seconds();
    for (int i = 0; i < RAYS; ++i) {
      double start[3], direction[3];
      bool found;
      scree_hit hit;
      random_ray(&r, &o, start, direction);
      if (scree_scene_ray_cast(o.scene, NULL, b->scratch, start, direction, 1e6, &found, &hit) != SCREE_OK) die("no ray");
      if (run == 0 && i < PLAIN_RAYS) sum += found ? hit.distance : 1e6;
    }
    times[run] = (seconds() - begin) / RAYS;
  }
  const double plain = plain_rays(&o, &plain_sum);
  if (fabs(sum - plain_sum) > 1e-6) die("rays do not hit what they should");
  report("scene.ray", median(times, RUNS) * 1e6, "us a ray", plain * 1e6);
  free_ball(&o);
}

static void near(bench* b) {
  if (!wanted(b, "scene.near")) return;
  ball o = make_ball(b, 100000);
  random_stream r = {2};
  double points[3 * BODIES], times[RUNS];
  const double radius = b->field->cell_size, origin[3] = {0, 0, 0};
  for (int i = 0; i < BODIES; ++i) { /* bodies that lie on the pile */
    double p[3], length2 = 0;
    for (int a = 0; a < 3; ++a) {
      p[a] = random_in(&r, -1, 1);
      length2 += p[a] * p[a];
    }
    for (int a = 0; a < 3; ++a) points[3 * i + a] = p[a] * o.radius / sqrt(length2);
  }
  scree_rock* rocks = must(malloc((size_t)o.count * sizeof *rocks));
  uint64_t count = 0, plain_count = 0;
  for (int run = 0; run < RUNS; ++run) {
    const double begin = seconds();
    if (scree_scene_near(o.scene, NULL, b->scratch, points, BODIES, radius, origin, rocks, o.count, &count) != SCREE_OK)
      die("no near rocks");
    times[run] = seconds() - begin;
  }
  const double begin = seconds();
  for (uint64_t k = 0; k < o.count; ++k) {
    static const float zero[1] = {0};
    bool is_near = false;
    for (int i = 0; i < BODIES && !is_near; ++i) {
      const spatial_place place = scree_rt_spatial_place(&o.scene->layers[0], &o.rocks[k], points + 3 * i);
      const double* c = place.centroid;
      const double apart = radius + place.radius;
      spatial_hull hull;
      if (c[0] * c[0] + c[1] * c[1] + c[2] * c[2] > apart * apart) continue;
      if (!scree_rt_spatial_hull(&o.scene->layers[0], o.rocks[k].asset, place.home, &hull)) continue;
      const convex_hull body = {zero, zero, zero, 1, 1, {0, 0, 0}, radius};
      is_near = scree_rt_convex_meet(&hull.hull, &body);
    }
    plain_count += is_near;
  }
  const double plain = seconds() - begin;
  if (count != plain_count) die("near rocks are not those they should be");
  report("scene.near", median(times, RUNS) * 1e6, "us for 100 bodies", plain * 1e6);
  free(rocks);
  free_ball(&o);
}

/* --- hulls ------------------------------------------------------------------------------------------------------------------ */

static void meet(bench* b) {
  if (!wanted(b, "convex.meet")) return;
  random_stream r = {3};
  spatial_hull* hulls = must(malloc(HULLS * sizeof *hulls));
  for (int i = 0; i < HULLS; ++i) {
    const uint32_t asset = random_below(&r, b->field->asset_count);
    hulls[i].hull = (convex_hull){.x = hulls[i].x, .y = hulls[i].y, .z = hulls[i].z};
    hulls[i].hull.count = scree_rt_field_hull(b->field, asset, hulls[i].x, hulls[i].y, hulls[i].z);
    hulls[i].hull.scale = b->field->cell_size / b->field->lattice_per_cell;
    for (int a = 0; a < 3; ++a) hulls[i].hull.at[a] = random_in(&r, -0.6, 0.6) * b->field->cell_size;
  }
  double times[RUNS], plain_times[RUNS];
  uint64_t meeting = 0;
  volatile double sink = 0;
  for (int run = 0; run < RUNS; ++run) {
    double begin = seconds();
    for (int k = 1; k <= PAIRS; ++k)
      for (int i = 0; i + k < HULLS; ++i) meeting += scree_rt_convex_meet(&hulls[i].hull, &hulls[i + k].hull);
    times[run] = (seconds() - begin) / (PAIRS * (double)(HULLS - PAIRS / 2));
    begin = seconds();
    for (int k = 1; k <= PAIRS; ++k)
      for (int i = 0; i + k < HULLS; ++i) { /* the difference that lies farthest along one direction, of all pairs of points */
        const convex_hull *p = &hulls[i].hull, *q = &hulls[i + k].hull;
        double most = -1e30;
        for (uint32_t m = 0; m < p->count; ++m)
          for (uint32_t n = 0; n < q->count; ++n) {
            const double x = (double)(p->x[m] - q->x[n]), y = (double)(p->y[m] - q->y[n]), z = (double)(p->z[m] - q->z[n]);
            const double along = x * 0.6 + y * 0.5 + z * 0.4;
            most = along > most ? along : most;
          }
        sink = sink + most;
      }
    plain_times[run] = (seconds() - begin) / (PAIRS * (double)(HULLS - PAIRS / 2));
  }
  if (meeting == 0) die("no hulls meet");
  report("convex.meet", median(times, RUNS) * 1e9, "ns a pair", median(plain_times, RUNS) * 1e9);
  free(hulls);
}

int main(int argc, char** argv) {
  bench b = {.prefix = argc > 1 ? argv[1] : ""};
  scree_field_desc desc = {.seed = 2009, .cell_size = 1};
  scree_pack* pack = NULL;
  synthetic_source source = {0};
  if (argc > 3) die("usage: scree-bench-scene [NAME] [PACK.scree]");
  const char* path = argc > 2 ? argv[2] : "build/packs/boulders.scree";
  if (scree_pack_open_file(path, NULL, &pack) == SCREE_OK) {
    desc.pack = pack;
    if (scree_field_create(&desc, NULL, &b.field) != SCREE_OK) die("the pack cannot be used");
  } else {
    if (argc > 2) die("the pack cannot be opened");
    source = synthetic_create(5, 1, 1, 1);
    synthetic_add_hulls(&source, 1, 3, 4);
    if (scree_rt_field_create_from_source(&desc, &source.source, NULL, &b.field) != SCREE_OK) die("no field");
  }
  if (scree_scratch_create(NULL, &b.scratch) != SCREE_OK) die("out of memory");

  ray(&b);
  near(&b);
  meet(&b);

  scree_scratch_destroy(b.scratch);
  scree_field_destroy(b.field);
  synthetic_destroy(&source);
  scree_pack_close(pack);
  return 0;
}
