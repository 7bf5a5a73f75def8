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

#include "lattice.h"
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

static void views_far_apart_find_what_they_would_alone(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  scree_stream_desc desc = {.scene = w.scene, .view_distance = 25, .max_error_pixels = 4, .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &desc, NULL);
  random_stream r = {12};
  for (int i = 0; i < 60; ++i) { /* numbers relative to the first view are as coarse as a metre */
    scree_view views[2] = {host_view(9e6 + i, 4, 5e6), host_view(-20 + 0.5 * i, 4, random_in(&r, -3, 3))};
    host_settle(&h, views, 2, 500);
    host_check_truth(&h, views, 2, true);
  }
  host_destroy(&h);
  stream_world_free(&w);
}

/* The most instances of a long walk; none of it is drawn coarser for want of room. */
static uint32_t most_of_a_walk(const stream_world* w, uint32_t cap) {
  scree_stream_desc desc = {.scene = w->scene,
                            .view_distance = 20,
                            .max_error_pixels = 12,
                            .no_far_field = true,
                            .caps = {.instances = cap},
                            .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &desc, NULL);
  random_stream r = {5};
  uint32_t most = 0;
  for (int i = 0; i < 1200; ++i) {
    scree_view view = host_view(25 * sin(i * 0.07) + random_in(&r, -3, 3), 3, 25 * cos(i * 0.043));
    host_update(&h, &view, 1);
    scree_stream_stats stats;
    scree_stream_get_stats(h.stream, &stats);
    assert_int_equal(stats.degraded, 0);
    if (stats.instances > most) most = stats.instances;
  }
  host_destroy(&h);
  return most;
}

static void blocks_that_come_and_go_leave_room_for_others(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  uint32_t most = most_of_a_walk(&w, 1u << 16);
  assert_true(most > 1000);
  most_of_a_walk(&w, most + most / 2);
  stream_world_free(&w);
}

static void what_a_cap_took_comes_back_while_the_views_stand(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  scree_stream_desc desc = {.scene = w.scene,
                            .view_distance = 30,
                            .max_error_pixels = 12,
                            .no_far_field = true,
                            .caps = {.instances = 4000, .mesh_bytes = 3500000},
                            .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &desc, NULL);
  scree_view views[2] = {host_view(0, 3, 0), host_view(-88, 3, 0)}; /* amid the rocks; where few are near */
  scree_stream_stats stats;
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 1000; ++i) host_update(&h, &views[0], 1);
    scree_stream_get_stats(h.stream, &stats);
    assert_true(stats.degraded > 0 && stats.instances > 2000);
    for (int i = 0; i < 50; ++i) { /* it does not come and go */
      host_update(&h, &views[0], 1);
      assert_int_equal(h.events, 0);
    }
    for (int i = 0; i < 1000; ++i) host_update(&h, &views[1], 1);
    scree_stream_get_stats(h.stream, &stats);
    assert_int_equal(stats.degraded, 0);
    assert_true(stats.covered == desc.view_distance && stats.instances > 100);
    host_check_truth(&h, &views[1], 1, true);
  }
  host_destroy(&h);
  stream_world_free(&w);
}

static void levels_change_at_few_distances(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){.proxies = true, .levels = 4});
  scree_stream_desc desc = {.scene = w.scene, .view_distance = 20, .decode = stream_decode_pattern};
  scree_stream* s;
  assert_int_equal(scree_stream_create(&desc, NULL, &s, NULL), SCREE_OK);
  const stream_pack* p = &s->packs[0];
  uint32_t used = 0;
  for (uint32_t kind = 0; kind < 2; ++kind) {
    float largest[STREAM_CLASSES][STREAM_LEVELS] = {{0}}, base = 0;
    for (uint32_t i = kind ? p->assets : 0; i < (kind ? p->total : p->assets); ++i)
      for (uint32_t level = 0; level < p->levels; ++level) {
        scree_lod lod;
        assert_int_equal(scree_pack_get_lod(w.pack, i, level, &lod), SCREE_OK);
        float* most = &largest[s->classes[p->first_asset + i]][level];
        *most = fmaxf(*most, lod.error);
        base = fmaxf(base, lod.error);
      }
    for (uint32_t class = 0; class < STREAM_CLASSES; ++class)
      for (uint32_t level = 0; level < p->levels; ++level) {
        float error = p->error[kind][class][level];
        if (level > 0) largest[class][level] = fmaxf(largest[class][level], largest[class][level - 1]);
        assert_true(error >= largest[class][level] && error <= largest[class][level] * 1.250001f);
        if (error == 0) continue;
        double steps = log((double)base / (double)error) / log(1.25);
        assert_true(fabs(steps - round(steps)) < 1e-4);
        used += class > 0;
      }
  }
  assert_true(used > 8);
  scree_stream_destroy(s);
  stream_world_free(&w);
}

/* Changes of levels while a view swings to and fro. */
static uint64_t changes_of_a_swing(const stream_world* w, float hysteresis) {
  scree_stream_desc desc = {.scene = w->scene,
                            .view_distance = 200,
                            .max_error_pixels = 4,
                            .hysteresis = hysteresis,
                            .no_far_field = true,
                            .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &desc, NULL);
  uint64_t before = 0;
  for (int swing = 0; swing < 12; ++swing) {
    const scree_view view = host_view(swing & 1 ? 0.4 : -0.4, 22, 0);
    host_settle(&h, &view, 1, 2000);
    if (swing == 1) before = h.counts[SCREE_EVENT_BLOCK_CHANGE];
  }
  const uint64_t changes = h.counts[SCREE_EVENT_BLOCK_CHANGE] - before;
  host_destroy(&h);
  return changes;
}

static void levels_stay_where_a_view_swings_less_than_the_hysteresis(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  assert_true(changes_of_a_swing(&w, 1e-6f) > 0);
  assert_int_equal(changes_of_a_swing(&w, 0.2f), 0);
  stream_world_free(&w);
}

static void fades_go_from_one_level_to_the_other_in_their_time(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  scree_stream_desc desc = {
      .scene = w.scene, .view_distance = 200, .max_error_pixels = 4, .fade_seconds = 0.5f, .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &desc, NULL);
  scree_view view = host_view(0, 22, 0);
  host_settle(&h, &view, 1, 2000);
  uint32_t early = 0, halfway = 0, late = 0;
  view.position[1] = 15;
  for (int i = 0; i < 60; ++i) {
    host_update(&h, &view, 1);
    for (uint32_t k = 0; k < h.caps.blocks; ++k)
      for (uint32_t n = 0; h.blocks[k].shown && n < h.blocks[k].run_count; ++n) {
        const scree_stream_run* run = &h.blocks[k].runs[n];
        if (run->from_level == 255) continue;
        assert_int_not_equal(run->from_level, run->level);
        const double since = h.time - (double)run->fade_start, fade = (double)scree_stream_fade(h.stream, run->fade_start, h.time);
        assert_true(since > -1e-5 && since < 0.5 + 2.0 / 60);
        assert_true(fabs(fade - fmin(since / 0.5, 1)) < 1e-4);
        early += fade < 0.2;
        halfway += fade > 0.4 && fade < 0.6;
        late += fade > 0.8;
      }
  }
  assert_true(early > 0 && halfway > 0 && late > 0);
  assert_true(scree_stream_fade(h.stream, 7, 6) == 0 && scree_stream_fade(h.stream, 7, 8) == 1);
  assert_true(scree_stream_fade(NULL, 7, 7) == 1); /* no fades: all of it at once */
  host_destroy(&h);
  stream_world_free(&w);
}

/* Rocks in blocks that the half-space of a plane meets, and in those that lie wholly outside. */
static void count_sides(const stream_host* h, const float plane[4], const scree_view* view, uint32_t sides[2]) {
  sides[0] = sides[1] = 0;
  double width = stream_node_width(&h->stream->layers[0], 0);
  for (uint32_t k = 0; k < h->caps.blocks; ++k) {
    const host_block* b = &h->blocks[k];
    if (!b->shown) continue;
    double sum = (double)plane[3];
    for (int a = 0; a < 3; ++a) sum += (double)plane[a] * (b->origin[a] + (plane[a] > 0 ? width : 0) - view->position[a]);
    sides[sum >= 0] += b->count;
  }
}

static void what_is_in_the_frustum_comes_first(void** state) {
  (void)state;
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){0});
  for (int turn = 0; turn < 4; ++turn) {
    const float plane[4] = {turn == 0 ? 1 : turn == 1 ? -1 : 0, 0, turn == 2 ? 1 : turn == 3 ? -1 : 0, 0};
    scree_stream_desc desc = {.scene = w.scene, .view_distance = 45, .no_far_field = true, .caps = {.builds = 2}};
    stream_host h;
    host_create(&h, &desc, NULL);
    scree_view view = host_view(0, 4, 0);
    view.frustum = plane;
    view.plane_count = 1;
    uint32_t sides[2], inside_before = 0, most = 0, first_outside = 0;
    for (int i = 0; i < 400; ++i) {
      host_update(&h, &view, 1);
      count_sides(&h, plane, &view, sides);
      if (first_outside == 0 && sides[0] > 0) first_outside = inside_before = sides[1];
      most = sides[1];
    }
    assert_true(first_outside > 0 && inside_before * 20 > most * 19);
    assert_true(sides[0] > most / 4);
    host_destroy(&h);
  }
  stream_world_free(&w);
}

/* Flies over a world that lies `origin` from the place where coordinates start. Returns a digest of how much is shown after each
 * update. Not of the events themselves: far away, distances that are alike differ in their last bits, which changes the order. */
static uint64_t fly_at(double origin) {
  stream_world w;
  stream_world_make(&w, &(stream_world_desc){.origin = origin});
  scree_stream_desc desc = {
      .scene = w.scene, .view_distance = 25, .max_error_pixels = 4, .fade_seconds = 0.1f, .decode = stream_decode_pattern};
  stream_host h;
  host_create(&h, &desc, NULL);
  uint64_t sum = 0;
  for (int i = 0; i < 200; ++i) {
    scree_view view = host_view(origin + 0.25 * i - 20, origin + 4, origin + 0.125 * i);
    host_update(&h, &view, 1);
    sum = hash_combine(sum, (uint64_t)h.shown_instances << 32 | h.shown_blocks);
  }
  scree_view view = host_view(origin + 30, origin + 4, origin + 25);
  host_settle(&h, &view, 1, 500);
  host_check(&h);
  host_check_truth(&h, &view, 1, true);
  assert_true(h.counts[SCREE_EVENT_BLOCK_IN] > 50 && h.counts[SCREE_EVENT_BLOCK_OUT] > 20);
  host_destroy(&h);
  stream_world_free(&w);
  return sum;
}

static void as_much_is_shown_ten_thousand_kilometres_away(void** state) {
  (void)state;
  uint64_t here = fly_at(0);
  assert_int_equal(fly_at(1e7), here);
  assert_int_equal(fly_at(-1e7), here);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_is_covered_has_no_hole),
      cmocka_unit_test(what_is_in_the_frustum_comes_first),
      cmocka_unit_test(views_far_apart_find_what_they_would_alone),
      cmocka_unit_test(blocks_that_come_and_go_leave_room_for_others),
      cmocka_unit_test(what_a_cap_took_comes_back_while_the_views_stand),
      cmocka_unit_test(levels_change_at_few_distances),
      cmocka_unit_test(levels_stay_where_a_view_swings_less_than_the_hysteresis),
      cmocka_unit_test(fades_go_from_one_level_to_the_other_in_their_time),
      cmocka_unit_test(as_much_is_shown_ten_thousand_kilometres_away),
      cmocka_unit_test(a_far_field_covers_the_view_long_before_it_is_complete),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
