/* What a stream makes of its views: what comes first, and how far from the views everything is covered. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* after the four above */
#include <cmocka.h>

#include "stream_host.h"
#include "stream_internal.h"
#include "synthetic_field.h"

static double box_distance(const double p[3], const double low[3], const double high[3]) {
  double sum = 0;
  for (int a = 0; a < 3; ++a) {
    double d = p[a] < low[a] ? low[a] - p[a] : p[a] > high[a] ? p[a] - high[a] : 0;
    sum += d * d;
  }
  return sqrt(sum);
}

static scree_rock* all_rocks(const stream_world* w, uint64_t* count) {
  scree_scratch* scratch;
  assert_int_equal(scree_scratch_create(NULL, &scratch), SCREE_OK);
  scree_scene_query_desc query = {.scene = w->scene, .flags = SCREE_SCENE_VISIBLE};
  assert_int_equal(scree_scene_count(&query, scratch, count), SCREE_OK);
  scree_rock* rocks = malloc((*count + 1) * sizeof *rocks);
  assert_non_null(rocks);
  assert_int_equal(scree_scene_fill(&query, scratch, rocks, *count, count), SCREE_OK);
  scree_scratch_destroy(scratch);
  return rocks;
}

/* The distance of the nearest block of rocks of which no node above shows anything; `most` where there is none. */
static double nearest_hole(const stream_host* h, const scree_rock* rocks, uint64_t count, const scree_view* view, double most) {
  const scree_stream* s = h->stream;
  const stream_layer* layer = &s->layers[0];
  double nearest = most;
  for (uint64_t i = 0; i < count; ++i) {
    int32_t at[3];
    double low[3], high[3];
    for (int a = 0; a < 3; ++a) at[a] = (int32_t)floor((double)rocks[i].id.cube[a] / STREAM_BLOCK_CUBES);
    stream_node_low(layer, 0, at, low);
    for (int a = 0; a < 3; ++a) high[a] = low[a] + stream_node_width(layer, 0);
    double distance = box_distance(view->position, low, high);
    if (distance >= nearest) continue;
    bool covered = false;
    uint32_t node = layer->root;
    for (; node != STREAM_NONE; node = s->nodes[node].next) {
      bool inside = true;
      for (int a = 0; a < 3; ++a) inside = inside && at[a] >> layer->top == s->nodes[node].at[a];
      if (inside) break;
    }
    while (node != STREAM_NONE && !covered) {
      covered = s->nodes[node].shown;
      uint32_t level = s->nodes[node].level;
      if (level == 0) break;
      uint32_t child = 0;
      for (uint32_t a = 0; a < 3; ++a) child |= (uint32_t)(at[a] >> (level - 1) & 1) << a;
      node = s->nodes[node].child[child];
    }
    if (!covered) nearest = distance;
  }
  return nearest;
}

static void what_is_covered_has_no_hole(void** state) {
  (void)state;
  for (int proxies = 0; proxies < 2; ++proxies) {
    stream_world w;
    stream_world_make(&w, &(stream_world_desc){.proxies = proxies});
    uint64_t count;
    scree_rock* rocks = all_rocks(&w, &count);
    scree_stream_desc desc = {
        .scene = w.scene, .view_distance = 50, .max_error_pixels = 30, .caps = {.builds = 3}, .decode = stream_decode_pattern};
    stream_host h;
    host_create(&h, &desc, NULL);
    random_stream r = {2};
    scree_view view = host_view(0, 4, 0);
    uint32_t partly = 0, wholly = 0;
    for (int i = 0; i < 400; ++i) {
      if (i % 130 == 129) { /* a jump */
        view.position[0] = random_in(&r, -60, 60);
        view.position[2] = random_in(&r, -60, 60);
      }
      view.position[0] += i % 130 > 100 ? 0.7 : 0;
      host_update(&h, &view, 1);
      scree_stream_stats stats;
      scree_stream_get_stats(h.stream, &stats);
      double hole = nearest_hole(&h, rocks, count, &view, desc.view_distance);
      assert_true(stats.covered <= hole + 1e-9);
      partly += stats.covered < desc.view_distance;
      wholly += stats.covered == desc.view_distance;
    }
    assert_true(partly > 10 && wholly > 10);
    host_destroy(&h);
    free(rocks);
    stream_world_free(&w);
  }
}

static void a_far_field_covers_the_view_long_before_it_is_complete(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){.proxies = true});
  scree_stream_desc desc = {.scene = w.scene, .view_distance = 60, .caps = {.builds = 4}, .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &desc, NULL);
  scree_view view = host_view(0, 4, 0);
  uint32_t covered = 0, complete = 0;
  for (uint32_t i = 1; i <= 1000 && complete == 0; ++i) {
    host_update(&h, &view, 1);
    scree_stream_stats stats;
    scree_stream_get_stats(h.stream, &stats);
    if (covered == 0 && stats.covered >= desc.view_distance) covered = i;
    if (covered > 0) assert_true(stats.covered >= desc.view_distance); /* and stays so */
    if (stats.complete) complete = i;
  }
  assert_true(covered > 0 && covered * 3 < complete);
  host_destroy(&h);
  stream_world_free(&w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_is_covered_has_no_hole),
      cmocka_unit_test(a_far_field_covers_the_view_long_before_it_is_complete),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
