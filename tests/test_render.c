/* The renderer on stones that need no pack, through EGL without a display. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "camera.h"
#include "headless.h"
#include "lattice.h"
#include "render.h"
#include "render_lights.h"
#include "render_list.h"
#include "synthetic_stones.h"

enum { WIDTH = 192, HEIGHT = 128, ASSETS = 12, BYTES = WIDTH * HEIGHT * 3 };

typedef struct stage {
  headless* context;
  render* renderer;
  render_source source;
  render_stone* stones;
  uint32_t count;
} stage;

static headless* display; /* NULL: no EGL here, the tests that need it are skipped */

static int open_display(void** state) {
  (void)state;
  scree_error error = {""};
  if (headless_create(&display, &error) != SCREE_OK) print_message("SKIPPED: %s\n", error.message);
  return 0;
}

static int close_display(void** state) {
  (void)state;
  headless_destroy(display);
  return 0;
}

static void stage_open_with(stage* s, bool no_indirect, uint32_t shadow_size) {
  if (display == NULL) skip();
  scree_error error = {""};
  const render_desc desc = {.no_indirect = no_indirect, .shadow_size = shadow_size};
  memset(s, 0, sizeof *s);
  if (render_create(&desc, &s->renderer, &error) != SCREE_OK) fail_msg("%s", error.message);
  assert_true(synthetic_source(ASSETS, &s->source));
  assert_int_equal(render_add_source(s->renderer, &s->source), 0);
  s->count = synthetic_heap(ASSETS, 3.0f, 0.7f, &s->stones);
  assert_int_equal(render_set_stones(s->renderer, s->stones, s->count), SCREE_OK);
}

static void stage_open(stage* s, bool no_indirect) {
  stage_open_with(s, no_indirect, 512);
}

static void stage_close(stage* s) {
  render_destroy(s->renderer);
  free((void*)s->source.assets);
  free(s->stones);
}

static render_picture picture_from(const char* text) {
  double eye[3], target[3], field_of_view;
  assert_true(camera_parse(text, eye, target, &field_of_view));
  camera c = {.yaw = 0};
  const float from[3] = {(float)eye[0], (float)eye[1], (float)eye[2]},
              to[3] = {(float)target[0], (float)target[1], (float)target[2]};
  camera_look(&c, from, to, (float)field_of_view * 0.017453293f);
  render_picture p;
  render_picture_init(&p);
  p.width = WIDTH;
  p.height = HEIGHT;
  float right[3];
  memcpy(p.eye, c.eye, sizeof p.eye);
  camera_axes(&c, p.forward, right, p.up);
  p.field_of_view = c.field_of_view;
  return p;
}

static render_picture heap_picture(void) {
  return picture_from("4,3.2,7,0,0.8,0,40");
}

static uint8_t* draw(render* r, const render_picture* p) {
  assert_int_equal(render_draw(r, p), SCREE_OK);
  uint8_t* pixels = malloc((size_t)p->width * p->height * 3);
  assert_non_null(pixels);
  render_read(r, pixels);
  return pixels;
}

static double brightness(const uint8_t* pixels, uint32_t x, uint32_t y, uint32_t size) {
  double sum = 0;
  for (uint32_t v = y; v < y + size; ++v)
    for (uint32_t u = x; u < x + size; ++u)
      for (uint32_t c = 0; c < 3; ++c) sum += pixels[3 * (v * WIDTH + u) + c];
  return sum / (3.0 * size * size);
}

static uint32_t differing(const uint8_t* a, const uint8_t* b) {
  uint32_t count = 0;
  for (uint32_t i = 0; i < WIDTH * HEIGHT; ++i) count += memcmp(a + 3 * i, b + 3 * i, 3) != 0;
  return count;
}

static void picture_shows_stones_ground_and_sky(void** state) {
  (void)state;
  stage s;
  stage_open(&s, false);
  render_picture p = heap_picture();
  uint8_t* pixels = draw(s.renderer, &p);
  uint32_t stones = 0, ground = 0, sky = 0;
  for (uint32_t y = 0; y < HEIGHT; ++y)
    for (uint32_t x = 0; x < WIDTH; ++x) {
      uint32_t stone;
      float point[3];
      if (!render_pick(s.renderer, x, y, &stone, point)) {
        ++sky;
      } else if (stone == RENDER_NOTHING) {
        ++ground;
        assert_float_equal(point[1], 0, 0.02f * (1 + fabsf(point[2])));
      } else {
        ++stones;
        assert_in_range(stone, 0, s.count - 1);
        float away = 0;
        for (int a = 0; a < 3; ++a) away += (point[a] - s.stones[stone].position[a]) * (point[a] - s.stones[stone].position[a]);
        assert_true(sqrtf(away) < 0.8f * s.stones[stone].cell_size);
      }
    }
  assert_in_range(stones, WIDTH * HEIGHT / 10, WIDTH * HEIGHT);
  assert_in_range(ground, WIDTH * HEIGHT / 10, WIDTH * HEIGHT);
  assert_in_range(sky, WIDTH * HEIGHT / 50, WIDTH * HEIGHT);
  /* Sky is blue, ground is not. */
  const uint8_t *top = pixels + 3 * (WIDTH / 2), *bottom = pixels + 3 * ((HEIGHT - 1) * WIDTH + WIDTH / 2);
  assert_true(top[2] > top[0]);
  assert_true(bottom[2] < bottom[0]);
  free(pixels);
  stage_close(&s);
}

static void picture_is_the_same_twice(void** state) {
  (void)state;
  uint8_t* pixels[2];
  for (int i = 0; i < 2; ++i) {
    stage s;
    stage_open(&s, false);
    render_picture p = heap_picture();
    p.samples = 3;
    pixels[i] = draw(s.renderer, &p);
    stage_close(&s);
  }
  assert_int_equal(differing(pixels[0], pixels[1]), 0);
  free(pixels[0]);
  free(pixels[1]);
}

static void plain_draws_give_the_pixels_of_indirect_ones(void** state) {
  (void)state;
  uint8_t* pixels[2];
  bool indirect[2];
  for (int i = 0; i < 2; ++i) {
    stage s;
    stage_open(&s, i == 1);
    render_picture p = heap_picture();
    pixels[i] = draw(s.renderer, &p);
    render_stats stats;
    render_get_stats(s.renderer, &stats);
    indirect[i] = stats.indirect;
    stage_close(&s);
  }
  assert_false(indirect[1]);
  if (!indirect[0]) print_message("note: no glMultiDrawElementsIndirect here, both pictures took the plain path\n");
  assert_int_equal(differing(pixels[0], pixels[1]), 0);
  free(pixels[0]);
  free(pixels[1]);
}

static void colours_tell_levels_and_tiles_apart(void** state) {
  (void)state;
  stage s;
  stage_open(&s, false);
  render_picture p = heap_picture();
  uint8_t* pixels[3];
  for (int i = 0; i < 3; ++i) {
    p.colour = (render_colour)i;
    pixels[i] = draw(s.renderer, &p);
  }
  for (int i = 0; i < 3; ++i) assert_in_range(differing(pixels[i], pixels[(i + 1) % 3]), WIDTH * HEIGHT / 20, WIDTH * HEIGHT);
  for (int i = 0; i < 3; ++i) free(pixels[i]);
  stage_close(&s);
}

static void shadow_falls_away_from_the_sun(void** state) {
  (void)state;
  stage s;
  stage_open(&s, false);
  /* Straight down, the sun in the west: the ground east of the heap lies in shade, the ground west of it does not. */
  render_picture p = picture_from("0,16,0.01,0,0,0,45");
  const float sun[3] = {-1, 0.5f, 0};
  memcpy(p.sun, sun, sizeof sun);
  p.samples = 4;
  uint8_t* lit = draw(s.renderer, &p);
  /* 128 rows show 13.25 m; the heap ends at 3.2 m, its shadow reaches beyond 4.5 m. */
  const uint32_t row = HEIGHT / 2 - 4, east = WIDTH / 2 + 34, west = WIDTH / 2 - 34 - 8;
  double east_light = brightness(lit, east, row, 8), west_light = brightness(lit, west, row, 8);
  assert_true(east_light < 0.6 * west_light);
  p.shadows_off = true;
  uint8_t* without = draw(s.renderer, &p);
  assert_true(brightness(without, east, row, 8) > 1.5 * east_light);
  assert_true(fabs(brightness(without, west, row, 8) - west_light) < 0.03 * west_light);
  free(lit);
  free(without);
  stage_close(&s);
}

/* Acne is light and dark in turn where all is lit: a big flat stone cannot be told from no shadow at all. */
static void open_ground_is_free_of_false_shadows(void** state) {
  (void)state;
  stage s;
  stage_open(&s, false);
  render_picture p = picture_from("-9,2.0,6,-6,0,3,40");
  p.samples = 2;
  uint8_t* with = draw(s.renderer, &p);
  p.shadows_off = true;
  uint8_t* without = draw(s.renderer, &p);
  for (uint32_t y = HEIGHT - 40; y < HEIGHT; ++y) assert_memory_equal(with + 3 * y * WIDTH, without + 3 * y * WIDTH, 3 * WIDTH);
  free(with);
  free(without);
  stage_close(&s);
}

/* Two levels of one stone lie in and out of each other: were the shadow's another than the picture's, lit faces would speckle. */
static void stone_casts_the_shadow_of_the_mesh_it_is_seen_as(void** state) {
  (void)state;
  stage s;
  stage_open_with(&s, false, 2048); /* fine enough to ask for better meshes than the picture does */
  render_picture p = heap_picture();
  p.pixel_error = 1000;
  uint8_t* chosen = draw(s.renderer, &p);
  p.pixel_error = 0;
  p.lod = 3;
  uint8_t* forced = draw(s.renderer, &p);
  assert_int_equal(differing(chosen, forced), 0);
  p.lod = 0;
  uint8_t* fine = draw(s.renderer, &p);
  assert_true(differing(chosen, fine) > WIDTH * HEIGHT / 50);
  free(chosen);
  free(forced);
  free(fine);
  stage_close(&s);
}

static void samples_may_be_gathered_over_calls(void** state) {
  (void)state;
  stage s;
  stage_open(&s, false);
  render_picture p = heap_picture();
  p.samples = 6;
  uint8_t* at_once = draw(s.renderer, &p);
  p.eye[0] += 1;
  free(draw(s.renderer, &p));
  p.eye[0] -= 1;
  p.samples = 1;
  p.samples_most = 6;
  uint8_t* in_turn = NULL;
  for (int i = 0; i < 8; ++i) { /* two more than there is room for */
    free(in_turn);
    in_turn = draw(s.renderer, &p);
  }
  render_stats stats;
  render_get_stats(s.renderer, &stats);
  assert_int_equal(stats.samples, 6);
  assert_int_equal(differing(at_once, in_turn), 0);
  free(at_once);
  free(in_turn);
  stage_close(&s);
}

static void budget_decodes_piecemeal_to_the_same_picture(void** state) {
  (void)state;
  stage s;
  stage_open(&s, false);
  render_picture p = heap_picture();
  uint8_t* whole = draw(s.renderer, &p);
  render_stats stats;
  render_get_stats(s.renderer, &stats);
  assert_int_equal(stats.meshes_missing, 0);
  const uint32_t meshes = stats.meshes;
  assert_true(meshes > 6);
  stage_close(&s);

  stage_open(&s, false);
  p.decode_budget = 2;
  uint32_t before = UINT32_MAX, calls = 0;
  uint8_t* pixels = NULL;
  do {
    free(pixels);
    pixels = draw(s.renderer, &p);
    render_get_stats(s.renderer, &stats);
    assert_true(stats.meshes_decoded <= 2);
    assert_true(stats.meshes_missing < before);
    before = stats.meshes_missing;
    ++calls;
  } while (stats.meshes_missing > 0);
  assert_int_equal(calls, (meshes + 1) / 2);
  assert_int_equal(differing(whole, pixels), 0);
  free(whole);
  free(pixels);
  stage_close(&s);
}

static bool decode_nothing(void* user, uint32_t asset, uint32_t lod, scree_vertex* vertices, uint16_t* indices) {
  (void)user, (void)asset, (void)lod, (void)vertices, (void)indices;
  return false;
}

static void meshes_that_cannot_be_decoded_are_drawn_as_nothing(void** state) {
  (void)state;
  stage s;
  stage_open(&s, false);
  assert_int_equal(render_set_stones(s.renderer, NULL, 0), SCREE_OK);
  render_remove_source(s.renderer, 0);
  render_source broken = s.source;
  broken.decode = decode_nothing;
  assert_int_equal(render_add_source(s.renderer, &broken), 0);
  assert_int_equal(render_set_stones(s.renderer, s.stones, s.count), SCREE_OK);
  render_picture p = heap_picture();
  free(draw(s.renderer, &p));
  render_stats stats;
  render_get_stats(s.renderer, &stats);
  assert_int_equal(stats.stones_drawn, 0);
  assert_int_equal(stats.meshes_missing, 0);
  assert_int_equal(stats.meshes, 0);
  stage_close(&s);
}

static void stones_of_unknown_sources_are_refused(void** state) {
  (void)state;
  stage s;
  stage_open(&s, false);
  render_stone stone = s.stones[0];
  stone.source = 1;
  assert_int_equal(render_set_stones(s.renderer, &stone, 1), SCREE_ERROR_INVALID_ARGUMENT);
  stone.source = 0;
  stone.asset = ASSETS;
  assert_int_equal(render_set_stones(s.renderer, &stone, 1), SCREE_ERROR_INVALID_ARGUMENT);
  render_picture p = heap_picture();
  p.width = 0;
  assert_int_equal(render_draw(s.renderer, &p), SCREE_ERROR_INVALID_ARGUMENT);
  stage_close(&s);
}

/* A red ball a metre to the right of where it stands. */
static bool decode_arm(void* user, uint32_t asset, uint32_t lod, scree_vertex* vertices, uint16_t* indices) {
  const render_source* source = user;
  if (!source->decode(source->user, asset, lod, vertices, indices)) return false;
  for (uint32_t i = 0; i < source->assets[asset].vertices[lod]; ++i) {
    vertices[i].position[0] = (int16_t)(vertices[i].position[0] / 4 + SYNTHETIC_LATTICE);
    vertices[i].position[1] = (int16_t)(vertices[i].position[1] / 4);
    vertices[i].position[2] = (int16_t)(vertices[i].position[2] / 4);
    vertices[i].material = 255;
    vertices[i].durability = 0;
    vertices[i].curvature = 0;
  }
  return true;
}

/* Where the one model of a picture is seen, and how red it is. */
static void find_model(render* r, const render_picture* p, float place[3], double* red, double* green) {
  uint8_t* pixels = draw(r, p);
  uint32_t count = 0;
  *red = *green = 0;
  for (int a = 0; a < 3; ++a) place[a] = 0;
  for (uint32_t y = 0; y < HEIGHT; ++y)
    for (uint32_t x = 0; x < WIDTH; ++x) {
      uint32_t stone;
      float point[3];
      if (!render_pick(r, x, y, &stone, point) || stone != 0) continue;
      ++count;
      for (int a = 0; a < 3; ++a) place[a] += point[a];
      *red += pixels[3 * (y * WIDTH + x)];
      *green += pixels[3 * (y * WIDTH + x) + 1];
    }
  free(pixels);
  assert_in_range(count, 20, WIDTH * HEIGHT / 4);
  for (int a = 0; a < 3; ++a) place[a] /= (float)count;
}

static void models_are_turned_scaled_and_painted(void** state) {
  (void)state;
  stage s;
  stage_open(&s, false);
  assert_int_equal(render_set_stones(s.renderer, NULL, 0), SCREE_OK);
  render_asset asset = s.source.assets[0];
  asset.centre[0] = 1;
  render_source arm = s.source;
  arm.asset_count = 1;
  arm.assets = &asset;
  arm.look = RENDER_LOOK_PAINTED;
  arm.decode = decode_arm;
  arm.user = &s.source;
  const uint32_t source = render_add_source(s.renderer, &arm);
  static const struct {
    float turn[2], scale, place[3];
  } cases[] = {{{0, 0}, 1, {1, 1, 0}},
               {{0, 1}, 1, {1, 1, 0}},
               {{1, 0}, 1, {0, 1, -1}},
               {{0, -1}, 1, {-1, 1, 0}},
               {{0.6f, 0.8f}, 1.5f, {1.2f, 1, -0.9f}}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    render_stone model = {.position = {0, 1, 0}, .cell_size = cases[i].scale, .source = (uint16_t)source};
    memcpy(model.turn, cases[i].turn, sizeof model.turn);
    assert_int_equal(render_set_stones(s.renderer, &model, 1), SCREE_OK);
    render_picture p = heap_picture();
    float place[3];
    double red, green;
    find_model(s.renderer, &p, place, &red, &green);
    /* What is seen of a ball is the half towards the eye. */
    for (int a = 0; a < 3; ++a) assert_float_equal(place[a], cases[i].place[a], 0.25f * cases[i].scale);
    assert_true(red > 2 * green);
  }
  stage_close(&s);
}

static void segments_are_seen_through_stones_but_dimmed(void** state) {
  (void)state;
  stage s;
  stage_open(&s, false);
  render_picture p = heap_picture();
  uint8_t* bare = draw(s.renderer, &p);
  const render_segment segment = {
      {-3, 0.6f, 0}, {3, 0.6f, 0}, {255, 0, 0, 255}}; /* through the middle of the heap and out at both ends */
  p.segments = &segment;
  p.segment_count = 1;
  uint8_t* with = draw(s.renderer, &p);
  uint32_t strong = 0, weak = 0;
  for (uint32_t i = 0; i < WIDTH * HEIGHT; ++i) {
    if (memcmp(bare + 3 * i, with + 3 * i, 3) == 0) continue;
    if (with[3 * i] > 200 && with[3 * i + 1] < 60)
      ++strong;
    else
      ++weak;
  }
  assert_in_range(weak, 30, 800);
  assert_in_range(strong, 3, 400);
  free(bare);
  free(with);
  stage_close(&s);
}

/* --- Arithmetic that needs no context --- */

static float random_between(uint64_t* seed, float low, float high) {
  *seed += UINT64_C(0x9e3779b97f4a7c15);
  return low + (high - low) * (float)(hash_mix(*seed) >> 40) / 16777216.0f;
}

static void level_of_detail_follows_size_on_screen(void** state) {
  (void)state;
  const render_asset asset = {.radius = 0.8f, .errors = {0, 0.01f, 0.04f, 0.12f}};
  render_view view = {.pixel = 0.001f, .pixel_error = 0.5f, .lod = -1};
  uint32_t before = 0;
  for (float distance = 0.1f; distance < 1000; distance *= 1.1f) {
    uint32_t lod = render_choose_lod(&view, &asset, 4, 1, distance);
    assert_true(lod >= before);
    float nearest = fmaxf(distance - 0.8f, 0.1f);
    assert_true(lod == 0 || asset.errors[lod] <= 0.5f * 0.001f * nearest);
    assert_true(lod == 3 || asset.errors[lod + 1] > 0.5f * 0.001f * nearest);
    before = lod;
  }
  assert_int_equal(before, 3);
  view.lod = 2;
  assert_int_equal(render_choose_lod(&view, &asset, 4, 1, 0.1f), 2);
  view.lod = 9;
  assert_int_equal(render_choose_lod(&view, &asset, 4, 1, 0.1f), 3);
}

static void visible_casters_lie_in_a_cascade(void** state) {
  (void)state;
  uint64_t seed = 5;
  uint32_t checked = 0;
  for (int round = 0; round < 300; ++round) {
    camera c = {.yaw = 0};
    float eye[3], target[3];
    for (int a = 0; a < 3; ++a) {
      eye[a] = random_between(&seed, -60, 60);
      target[a] = random_between(&seed, -20, 20);
    }
    camera_look(&c, eye, target, random_between(&seed, 0.3f, 1.4f));
    render_cascade_desc desc = {.size = 1024, .count = RENDER_CASCADES};
    float tangent = tanf(c.field_of_view * 0.5f), forward[3], right[3], up[3];
    camera_axes(&c, forward, right, up);
    const float sun[3] = {random_between(&seed, -1, 1), random_between(&seed, 0.2f, 1), random_between(&seed, -1, 1)};
    float length = sqrtf(sun[0] * sun[0] + sun[1] * sun[1] + sun[2] * sun[2]);
    for (int a = 0; a < 3; ++a) {
      desc.sun[a] = sun[a] / length;
      desc.eye[a] = eye[a];
      desc.forward[a] = forward[a];
      desc.right[a] = right[a] * tangent * 1.5f;
      desc.up[a] = up[a] * tangent;
      desc.casters_min[a] = random_between(&seed, -30, 0);
      desc.casters_max[a] = desc.casters_min[a] + random_between(&seed, 1, 30);
    }
    render_cascade cascades[RENDER_CASCADES];
    uint32_t count = render_fit_cascades(&desc, cascades);
    for (int i = 0; i < 50; ++i) {
      float p[3], d[3], depth = 0, x = 0, y = 0;
      for (int a = 0; a < 3; ++a) {
        p[a] = random_between(&seed, desc.casters_min[a], desc.casters_max[a]);
        d[a] = p[a] - eye[a];
        depth += d[a] * forward[a];
        x += d[a] * right[a];
        y += d[a] * up[a];
      }
      if (depth < 0.01f || fabsf(x) > depth * tangent * 1.5f || fabsf(y) > depth * tangent) continue;
      ++checked;
      bool held = false;
      for (uint32_t k = 0; k < count && !held; ++k) {
        held = true;
        for (int axis = 0; axis < 3; ++axis) {
          float at = 0;
          for (int a = 0; a < 3; ++a) at += cascades[k].axes[axis][a] * p[a];
          held = held && at >= cascades[k].min[axis] && at <= cascades[k].max[axis];
        }
      }
      assert_true(held);
    }
  }
  assert_true(checked > 1000);
}

static void packed_sizes_are_true_to_half_a_thousandth(void** state) {
  (void)state;
  for (float metres = 0.001f; metres < 1000; metres *= 1.037f) {
    float back = exp2f((float)render_pack_size(metres) / 1024.0f - 32.0f);
    assert_true(fabsf(back / metres - 1) < 0.0005f);
  }
}

static void camera_text_is_six_or_seven_numbers(void** state) {
  (void)state;
  static const char* const bad[] = {"",
                                    "1,2,3",
                                    "1,2,3,4,5",
                                    "1,2,3,4,5,x",
                                    "1,2,3,4,5,6,",
                                    "1,2,3,1,2,3",
                                    "1,2,3,4,5,6,0.5",
                                    "1,2,3,4,5,6,171",
                                    "1,2,3,4,5,6,50,1",
                                    "1,2,3,4,5,nan",
                                    "1 2 3 4 5 6"};
  double eye[3], target[3], field_of_view;
  for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) assert_false(camera_parse(bad[i], eye, target, &field_of_view));
  assert_true(camera_parse("-1.5,2e1,6371000.25,4,5,6", eye, target, &field_of_view));
  assert_true(eye[0] == -1.5 && eye[1] == 20 && eye[2] == 6371000.25 && target[0] == 4 && target[1] == 5 && target[2] == 6);
  assert_true(field_of_view == 45);
  assert_true(camera_parse("1,2,3,4,5,6,60", eye, target, &field_of_view));
  assert_true(field_of_view == 60);
}

static void orbiting_keeps_the_target_and_flying_keeps_the_eye(void** state) {
  (void)state;
  camera c = {.yaw = 0};
  const float eye[3] = {3, 4, 5}, target[3] = {1, 1, -2};
  camera_look(&c, eye, target, 0);
  camera_turn(&c, 0.7f, -0.3f);
  camera_zoom(&c, 0.5f);
  float now[3];
  camera_target(&c, now);
  for (int a = 0; a < 3; ++a) assert_float_equal(now[a], target[a], 1e-4);
  c.free = true;
  const float before[3] = {c.eye[0], c.eye[1], c.eye[2]};
  camera_turn(&c, -2, 9);
  assert_memory_equal(before, c.eye, sizeof before);
  float forward[3], right[3], up[3];
  camera_axes(&c, forward, right, up);
  assert_float_equal(forward[0] * up[0] + forward[1] * up[1] + forward[2] * up[2], 0, 1e-5);
  assert_true(up[1] > 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(picture_shows_stones_ground_and_sky),
      cmocka_unit_test(picture_is_the_same_twice),
      cmocka_unit_test(plain_draws_give_the_pixels_of_indirect_ones),
      cmocka_unit_test(colours_tell_levels_and_tiles_apart),
      cmocka_unit_test(shadow_falls_away_from_the_sun),
      cmocka_unit_test(open_ground_is_free_of_false_shadows),
      cmocka_unit_test(stone_casts_the_shadow_of_the_mesh_it_is_seen_as),
      cmocka_unit_test(samples_may_be_gathered_over_calls),
      cmocka_unit_test(budget_decodes_piecemeal_to_the_same_picture),
      cmocka_unit_test(meshes_that_cannot_be_decoded_are_drawn_as_nothing),
      cmocka_unit_test(stones_of_unknown_sources_are_refused),
      cmocka_unit_test(models_are_turned_scaled_and_painted),
      cmocka_unit_test(segments_are_seen_through_stones_but_dimmed),
      cmocka_unit_test(level_of_detail_follows_size_on_screen),
      cmocka_unit_test(visible_casters_lie_in_a_cascade),
      cmocka_unit_test(packed_sizes_are_true_to_half_a_thousandth),
      cmocka_unit_test(camera_text_is_six_or_seven_numbers),
      cmocka_unit_test(orbiting_keeps_the_target_and_flying_keeps_the_eye),
  };
  return cmocka_run_group_tests(tests, open_display, close_display);
}
