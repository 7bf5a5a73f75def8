/* scree-bench-stream [NAME] [PACK.scree] [HEIGHTS.png]: streams over a real mountain, one JSON object a line. Run it from the root
 * of the repository, where the defaults lie: build/packs/boulders.scree (./dev demo bakes it) and content/terrain/jacksboro.png.
 *
 * Times of updates are those of the thread that calls, by its own clock; background work has one thread of its own. NAME: only
 * figures whose name starts with it. SCREE_BENCH_UPDATES: updates of stream.soak, whose goal is a million; SCREE_BENCH_VERBOSE
 * tells how flights go.
 *
 * The scene of the flights: one layer of stones of 0.5 m, one metre deep, on a mountainside of the size that nature made it, all of
 * them that can be seen. Proxies begin where seven in eight of them are right to a pixel, which of these stones is at about 290 m:
 * the view of 300 m is one of rocks. That is four million instances; what most games show is less. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <scree/draco.h>
#include <scree/stream.h>
#include <scree/threads.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define BENCH_PROGRAM "scree-bench-stream"
#include "bench.h"
#include "support_file.h"
#include "synthetic_field.h"

enum { FLIGHT = 600, WARM = 60, SOAK = 20000 };

static const double CELL = 0.5, SPACING = 15, ABOVE_GROUND = 30;

static void check(scree_result result, const char* what) {
  if (result == SCREE_OK) return;
  fprintf(stderr, "scree-bench-stream: %s: %s\n", what, scree_result_string(result));
  exit(2);
}

typedef struct bench {
  const char *prefix, *pack_file;
  height_samples heights;
  scree_pack* pack;
  scree_field* field;
  scree_support* ground;
  scree_scene* mountain;
} bench;

static bool wanted(const bench* b, const char* name) {
  return strncmp(name, b->prefix, strlen(b->prefix)) == 0;
}

static void print_row(const char* name, double value, const char* unit, double goal, const char* more) {
  printf("{\"name\": \"%s\", \"value\": %.4g, \"unit\": \"%s\", \"goal\": %g%s}\n", name, value, unit, goal, more);
  fflush(stdout);
}

/* --- the mountain ----------------------------------------------------------------------------------------------------------- */

static double ground_height(const bench* b, double x, double z) {
  double u = x / SPACING + (b->heights.width - 1) * 0.5, v = z / SPACING + (b->heights.depth - 1) * 0.5;
  uint32_t i = (uint32_t)fmin(fmax(u, 0), b->heights.width - 2), k = (uint32_t)fmin(fmax(v, 0), b->heights.depth - 2);
  return (double)b->heights.heights[k * b->heights.width + i];
}

static scree_scene* make_scene(const scree_field* field, const scree_support* support, float shell) {
  scree_layer layer = {.field = field, .support = support, .shell_depth = shell};
  scree_scene_desc desc = {&layer, 1};
  scree_scene* scene;
  check(scree_scene_create(&desc, NULL, &scene, NULL), "scene");
  return scene;
}

static void make_mountain(bench* b, const char* pack, const char* heights) {
  scree_error error;
  scene_height_map map = {.spacing = SPACING, .low = 475, .high = 1028};
  if (height_samples_load(&map, heights, &b->heights, &error) != SCREE_OK) die(error.message);
  check(scree_pack_open_file(pack, NULL, &b->pack), pack);
  scree_field_desc field = {.pack = b->pack, .seed = 21, .cell_size = CELL};
  check(scree_field_create(&field, NULL, &b->field), "field");
  scree_shape ground = {.kind = SCREE_SHAPE_HEIGHTFIELD,
                        .heightfield = {b->heights.heights, b->heights.width, b->heights.depth, (float)SPACING, 0, 30}};
  scree_support_desc support = {.shapes = &ground, .shape_count = 1};
  check(scree_support_create(&support, NULL, &b->ground, &error), error.message);
  b->mountain = make_scene(b->field, b->ground, 1);
}

/* --- flights ---------------------------------------------------------------------------------------------------------------- */

typedef struct flight {
  double p50, p99, mean, worst;                  /* milliseconds */
  double instances, triangles, uploaded, events; /* means */
  double covered;                                /* metres, the least of all updates */
  uint64_t mesh_bytes, holes, degraded, coarser;
} flight;

static scree_view view_at(const bench* b, double along) {
  double x = along - 700, z = 200 * sin(along / 300);
  return (scree_view){
      .position = {x, ground_height(b, x, z) + ABOVE_GROUND, z}, .field_of_view = 1.0471976f, .viewport_height = 1080};
}

static scree_stream_desc describe(const bench* b, const scree_scene* scene, double distance) {
  (void)b;
  return (scree_stream_desc){.scene = scene, .view_distance = distance, .decode = scree_draco_decode_u16};
}

/* Goes on until the picture is complete, or as good as the caps allow. */
static uint32_t settle(scree_stream* stream, const scree_view* view, double* time) {
  uint32_t quiet = 0, updates = 0;
  while (quiet < 3 && updates < 5000) {
    const scree_event* events;
    uint32_t count;
    scree_stream_wait(stream);
    check(scree_stream_update(stream, view, 1, *time += 1.0 / 60, &events, &count), "update");
    scree_stream_stats stats;
    scree_stream_get_stats(stream, &stats);
    quiet = count == 0 && stats.builds == 0 && stats.decodes == 0 ? quiet + 1 : 0;
    ++updates;
  }
  return updates;
}

/* Flights take place in real time, so that the background has as long as it has in a game. */
static void wait_until(double moment) {
  double whole = floor(moment);
  struct timespec t = {(time_t)whole, (long)((moment - whole) * 1e9)};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL);
}

static flight fly(const bench* b, double distance, uint32_t threads_count) {
  scree_threads* threads;
  check(scree_threads_create(threads_count, NULL, &threads), "threads");
  scree_stream_desc desc = describe(b, b->mountain, distance);
  desc.caps = (scree_stream_caps){.instances = 12u << 20, .blocks = 1u << 15, .mesh_bytes = UINT64_C(512) << 20};
  desc.tasks = scree_threads_tasks(threads);
  scree_stream* stream;
  scree_error error;
  if (scree_stream_create(&desc, NULL, &stream, &error) != SCREE_OK) die(error.message);
  double time = 0, times[FLIGHT], sum = 0;
  scree_view view = view_at(b, 0);
  settle(stream, &view, &time);
  flight f = {.covered = distance};
  double began = clock_seconds(CLOCK_MONOTONIC);
  for (int i = -WARM; i < FLIGHT; ++i) {
    view = view_at(b, (double)(i + WARM));
    wait_until(began += 1.0 / 60);
    const scree_event* events;
    uint32_t count;
    double start = clock_seconds(CLOCK_THREAD_CPUTIME_ID);
    check(scree_stream_update(stream, &view, 1, time += 1.0 / 60, &events, &count), "update");
    double took = clock_seconds(CLOCK_THREAD_CPUTIME_ID) - start;
    scree_stream_stats stats;
    scree_stream_get_stats(stream, &stats);
    if (getenv("SCREE_BENCH_VERBOSE") != NULL && i % 100 == 0)
      fprintf(stderr,
              "%5d: %.3f ms, %u events, %u instances, %u blocks, %u proxies, %.1f MiB meshes, %u coarser, %u builds, %u decodes\n",
              i, took * 1e3, count, stats.instances, stats.blocks, stats.proxies, (double)stats.mesh_bytes / 1048576, stats.coarser,
              stats.builds, stats.decodes);
    if (i < 0) continue;
    times[i] = took * 1e3;
    sum += took * 1e3;
    f.instances += stats.instances;
    f.triangles += (double)stats.triangles;
    f.uploaded += (double)stats.upload_bytes;
    f.events += count;
    f.degraded += stats.degraded;
    f.coarser += stats.coarser;
    f.covered = fmin(f.covered, stats.covered);
    f.holes += stats.covered < 0.98 * distance; /* what has just come into view may take an update or two */
    f.mesh_bytes = stats.mesh_bytes;
  }
  qsort(times, FLIGHT, sizeof *times, by_value);
  f.p50 = times[FLIGHT / 2];
  f.p99 = times[FLIGHT * 99 / 100];
  f.worst = times[FLIGHT - 1];
  f.mean = sum / FLIGHT;
  f.instances /= FLIGHT;
  f.triangles /= FLIGHT;
  f.uploaded /= FLIGHT;
  f.events /= FLIGHT;
  scree_stream_destroy(stream);
  scree_threads_destroy(threads);
  return f;
}

static void run_flights(const bench* b) {
  bool near_wanted = wanted(b, "stream.flight_p50") || wanted(b, "stream.flight_p99"), far_wanted = wanted(b, "stream.far_ratio");
  if (!near_wanted && !far_wanted) return;
  flight near = fly(b, 300, 1);
  char more[500];
  snprintf(
      more, sizeof more,
      ", \"instances\": %.0f, \"triangles\": %.0f, \"mesh_mib\": %.1f, \"upload_bytes\": %.0f, \"events\": %.1f, \"mean\": %.4f, "
      "\"worst\": %.3f, \"coarser\": %.1f, \"degraded\": %llu, \"holes\": %llu, \"covered\": %.1f",
      near.instances, near.triangles, (double)near.mesh_bytes / 1048576, near.uploaded, near.events, near.mean, near.worst,
      (double)near.coarser / FLIGHT, (unsigned long long)near.degraded, (unsigned long long)near.holes, near.covered);
  if (wanted(b, "stream.flight_p50")) print_row("stream.flight_p50", near.p50, "ms", 0.3, more);
  if (wanted(b, "stream.flight_p99")) print_row("stream.flight_p99", near.p99, "ms", 2, more);
  if (!far_wanted) return;
  flight far = fly(b, 2000, 1);
  snprintf(more, sizeof more,
           ", \"near\": %.4f, \"far\": %.4f, \"instances_ratio\": %.3f, \"triangles_ratio\": %.3f, \"far_p99\": %.3f, "
           "\"far_holes\": %llu, \"far_covered\": %.1f",
           near.mean, far.mean, far.instances / near.instances, far.triangles / near.triangles, far.p99,
           (unsigned long long)far.holes, far.covered);
  print_row("stream.far_ratio", far.mean / near.mean, "times", 3, more);
}

/* --- first picture ---------------------------------------------------------------------------------------------------------- */

/* From a file that is not open to a view in which every place shows something, with far proxies where rocks have yet to come; then
 * to all rocks. Without tasks: the caller does all the work. */
static void first_picture(const bench* b) {
  if (!wanted(b, "stream.first_picture")) return;
  double start = clock_seconds(CLOCK_MONOTONIC);
  scree_pack* pack;
  scree_field* field;
  scree_stream* stream;
  check(scree_pack_open_file(b->pack_file, NULL, &pack), "pack");
  scree_field_desc field_desc = {.pack = pack, .seed = 21, .cell_size = CELL};
  check(scree_field_create(&field_desc, NULL, &field), "field");
  scree_scene* scene = make_scene(field, b->ground, 1);
  scree_stream_desc desc = describe(b, scene, 300);
  desc.caps.instances = 8u << 20;
  desc.decode = NULL;
  check(scree_stream_create(&desc, NULL, &stream, NULL), "stream");
  double opened = clock_seconds(CLOCK_MONOTONIC), time = 0, covered = 0;
  scree_view view = view_at(b, 700);
  uint32_t updates = 0, updates_covered = 0, proxies = 0;
  scree_stream_stats stats;
  do {
    const scree_event* events;
    uint32_t count;
    check(scree_stream_update(stream, &view, 1, time += 1.0 / 60, &events, &count), "update");
    scree_stream_get_stats(stream, &stats);
    ++updates;
    if (covered == 0 && stats.covered >= desc.view_distance) {
      covered = clock_seconds(CLOCK_MONOTONIC);
      updates_covered = updates;
      proxies = stats.proxies;
    }
  } while (!stats.complete && updates < 1000);
  double ended = clock_seconds(CLOCK_MONOTONIC);
  if (covered == 0) die("stream.first_picture: the view is never covered");
  char more[300];
  snprintf(more, sizeof more,
           ", \"opening\": %.2f, \"updates\": %u, \"proxies\": %u, \"complete_ms\": %.0f, \"complete_updates\": %u, \"instances\": "
           "%u, \"blocks\": %u, \"complete\": %s",
           (opened - start) * 1e3, updates_covered, proxies, (ended - start) * 1e3, updates, stats.instances, stats.blocks,
           stats.complete ? "true" : "false");
  print_row("stream.first_picture", (covered - start) * 1e3, "ms", 100, more);
  scree_stream_destroy(stream);
  scree_scene_destroy(scene);
  scree_field_destroy(field);
  scree_pack_close(pack);
}

/* --- an edit of the scene --------------------------------------------------------------------------------------------------- */

enum { BALLS = 40 };

static scree_support* make_balls(const scree_support* reuse, double moved) {
  scree_shape shapes[BALLS + 1];
  uint32_t children[BALLS];
  memset(shapes, 0, sizeof shapes);
  for (uint32_t i = 0; i < BALLS; ++i) {
    children[i] = i + 1;
    shapes[i + 1] = (scree_shape){.kind = SCREE_SHAPE_SPHERE, .sphere = {4}};
    shapes[i + 1].transform.translation[0] = (float)(i % 8) * 10;
    shapes[i + 1].transform.translation[2] = (float)(i / 8) * 10;
  }
  shapes[1 + BALLS / 2].transform.translation[1] = (float)moved;
  shapes[0] = (scree_shape){.kind = SCREE_SHAPE_UNION, .group = {children, BALLS, 0}};
  scree_support_desc desc = {.shapes = shapes, .shape_count = BALLS + 1, .reuse = reuse};
  scree_support* support;
  check(scree_support_create(&desc, NULL, &support, NULL), "support");
  return support;
}

/* From a moved sphere to the event that carries the last changed block. */
static void edit(const bench* b) {
  if (!wanted(b, "stream.edit")) return;
  scree_support* support = make_balls(NULL, 0);
  scree_scene* scene = make_scene(b->field, support, 0);
  scree_stream_desc desc = describe(b, scene, 300);
  desc.decode = NULL;
  scree_stream* stream;
  check(scree_stream_create(&desc, NULL, &stream, NULL), "stream");
  scree_view view = {.position = {35, 20, 60}, .field_of_view = 1, .viewport_height = 1080};
  double time = 0, times[51];
  settle(stream, &view, &time);
  scree_stream_stats stats;
  scree_stream_get_stats(stream, &stats);
  uint32_t updates = 0, sent = 0;
  for (int i = 0; i < 51; ++i) {
    double start = clock_seconds(CLOCK_THREAD_CPUTIME_ID);
    scree_support* moved = make_balls(support, i & 1 ? 0 : 1.5);
    scree_scene* next = make_scene(b->field, moved, 0);
    check(scree_stream_set_scene(stream, next), "set_scene");
    updates = sent = 0;
    do {
      const scree_event* events;
      uint32_t count;
      check(scree_stream_update(stream, &view, 1, time += 1.0 / 60, &events, &count), "update");
      sent += count;
      scree_stream_get_stats(stream, &stats);
      ++updates;
    } while (!stats.complete && updates < 100);
    times[i] = (clock_seconds(CLOCK_THREAD_CPUTIME_ID) - start) * 1e3;
    scree_scene_destroy(scene);
    scree_support_destroy(support);
    scene = next;
    support = moved;
  }
  qsort(times, 51, sizeof *times, by_value);
  uint64_t rocks = 0;
  scree_scratch* scratch;
  check(scree_scratch_create(NULL, &scratch), "scratch");
  scree_scene_query_desc query = {.scene = scene};
  check(scree_scene_count(&query, scratch, &rocks), "count");
  char more[200];
  snprintf(more, sizeof more, ", \"rocks\": %llu, \"shown\": %u, \"updates\": %u, \"events\": %u", (unsigned long long)rocks,
           stats.instances, updates, sent);
  print_row("stream.edit", times[25], "ms", 5, more);
  scree_scratch_destroy(scratch);
  scree_stream_destroy(stream);
  scree_scene_destroy(scene);
  scree_support_destroy(support);
}

/* --- soak ------------------------------------------------------------------------------------------------------------------- */

typedef struct counted_memory {
  atomic_size_t bytes;
  atomic_uint_fast64_t allocations;
} counted_memory;

static void* counted_alloc(void* user, size_t size) {
  counted_memory* memory = user;
  ++memory->allocations;
  memory->bytes += size;
  return aligned_alloc(64, (size + 63) / 64 * 64);
}

static void counted_release(void* user, void* bytes, size_t size) {
  ((counted_memory*)user)->bytes -= size;
  free(bytes);
}

/* A long flight with edits and changes of the scene, under caps that bind; the sums of the events are held against the caps. */
static void soak(const bench* b) {
  if (!wanted(b, "stream.soak")) return;
  const char* asked = getenv("SCREE_BENCH_UPDATES");
  uint64_t updates = asked != NULL ? strtoull(asked, NULL, 10) : SOAK;
  counted_memory memory = {0, 0};
  scree_allocator allocator = {counted_alloc, counted_release, &memory};
  scree_scene* scenes[2] = {b->mountain, make_scene(b->field, b->ground, 0.8f)};
  scree_edits* edits;
  check(scree_edits_create(NULL, &edits), "edits");
  scree_stream_desc desc = describe(b, scenes[0], 60);
  desc.edits = edits;
  desc.caps = (scree_stream_caps){.instances = 60000, .blocks = 600, .mesh_bytes = UINT64_C(24) << 20, .upload_bytes = 1 << 20};
  scree_threads* threads;
  check(scree_threads_create(2, NULL, &threads), "threads");
  desc.tasks = scree_threads_tasks(threads);
  scree_stream* stream;
  check(scree_stream_create(&desc, &allocator, &stream, NULL), "stream");
  random_stream r = {1};
  double heading = 0, x = 0, z = 0, time = 0;
  uint64_t passed = 0, events_sum = 0;
  size_t early = 0;
  uint64_t early_allocations = 0;
  uint32_t instances = 0, blocks = 0;
  uint64_t mesh_bytes = 0;
  for (uint64_t i = 0; i < updates; ++i) {
    heading += random_in(&r, -0.05, 0.05);
    x += cos(heading);
    z += sin(heading);
    if (fabs(x) > 800 || fabs(z) > 800 || random_below(&r, 5000) == 0) {
      x = random_in(&r, -800, 800);
      z = random_in(&r, -800, 800);
    }
    scree_view view = {.position = {x, ground_height(b, x, z) + 10, z}, .field_of_view = 1, .viewport_height = 1080};
    scree_id id;
    if (i % 97 == 0 && scree_stream_id(stream, random_below(&r, 60000), &id)) {
      scree_stream_wait(stream);
      check(scree_edits_set(edits, &id, (scree_edit)random_below(&r, 3)), "edit");
      check(scree_stream_edited(stream, &id, 1), "edited");
    }
    if (i % 20011 == 0) check(scree_stream_set_scene(stream, scenes[i / 20011 & 1]), "set_scene");
    const scree_event* events;
    uint32_t count;
    check(scree_stream_update(stream, &view, 1, time += 1.0 / 60, &events, &count), "update");
    uint64_t uploaded = 0;
    for (uint32_t k = 0; k < count; ++k) {
      const scree_event* e = &events[k];
      uint64_t bytes = e->kind <= SCREE_EVENT_MESH_OUT ? e->mesh.vertex_count * sizeof(scree_vertex) + e->mesh.index_count * 2 : 0;
      if (e->kind == SCREE_EVENT_MESH_IN) mesh_bytes += bytes, uploaded += bytes;
      if (e->kind == SCREE_EVENT_MESH_OUT) {
        scree_lod lod;
        check(scree_pack_get_lod(e->mesh.pack, e->mesh.asset, e->mesh.level, &lod), "lod");
        mesh_bytes -= lod.vertices * sizeof(scree_vertex) + lod.triangles * UINT64_C(6);
      }
      if (e->kind == SCREE_EVENT_BLOCK_IN) instances += e->block.instance_count, ++blocks;
      if (e->kind == SCREE_EVENT_BLOCK_OUT) instances -= e->block.instance_count, --blocks;
      if (e->kind >= SCREE_EVENT_BLOCK_IN) uploaded += e->block.run_count * sizeof(scree_stream_run);
      if (e->kind >= SCREE_EVENT_BLOCK_IN && e->block.instances != NULL)
        uploaded += e->block.instance_count * sizeof(scree_stream_instance);
      passed += mesh_bytes > desc.caps.mesh_bytes || blocks > desc.caps.blocks;
    }
    scree_stream_stats stats;
    scree_stream_get_stats(stream, &stats);
    instances = stats.instances; /* changes bring other counts */
    passed += uploaded > desc.caps.upload_bytes || instances > desc.caps.instances || stats.mesh_bytes != mesh_bytes;
    events_sum += count;
    if (i == updates / 4) early = memory.bytes, early_allocations = memory.allocations;
  }
  size_t late = memory.bytes;
  uint64_t late_allocations = memory.allocations;
  scree_stream_destroy(stream);
  scree_threads_destroy(threads);
  char more[300];
  snprintf(more, sizeof more,
           ", \"events\": %llu, \"caps_passed\": %llu, \"grown_bytes\": %lld, \"late_allocations\": %llu, \"leaked_bytes\": %llu, "
           "\"memory_mib\": %.1f",
           (unsigned long long)events_sum, (unsigned long long)passed, (long long)late - (long long)early,
           (unsigned long long)(late_allocations - early_allocations), (unsigned long long)atomic_load(&memory.bytes),
           (double)late / 1048576);
  print_row("stream.soak", (double)updates, "updates", 1e6, more);
  if (passed > 0) die("stream.soak: a cap was passed");
  if (atomic_load(&memory.bytes) > 0) die("stream.soak: memory leaked");
  scree_edits_destroy(edits);
  scree_scene_destroy(scenes[1]);
}

int main(int argc, char** argv) {
  if (argc > 4) die("usage: scree-bench-stream [NAME] [PACK.scree] [HEIGHTS.png]");
  bench b = {.prefix = argc > 1 ? argv[1] : "", .pack_file = argc > 2 ? argv[2] : "build/packs/boulders.scree"};
  if (strncmp("stream.", b.prefix, strlen(b.prefix)) != 0 && strncmp(b.prefix, "stream.", 7) != 0) return 0;
  make_mountain(&b, b.pack_file, argc > 3 ? argv[3] : "content/terrain/jacksboro.png");
  first_picture(&b);
  run_flights(&b);
  edit(&b);
  soak(&b);
  scree_scene_destroy(b.mountain);
  scree_support_destroy(b.ground);
  scree_field_destroy(b.field);
  scree_pack_close(b.pack);
  height_samples_free(&b.heights);
  return 0;
}
