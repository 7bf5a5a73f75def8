/* Scatters without a scene: where instances stand, which models they have, how they are turned, and what is refused. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* after the five above */
#include <cmocka.h>

#include "failing_allocator.h"
#include "must_create.h"
#include "random_support.h"
#include "scatter_twin.h"

static const double nowhere[3] = {0, 0, 0};

static scree_support* make_support(const scree_shape* shapes, uint32_t count, const double origin[3]) {
  return must_create(&(scree_support_desc){.shapes = shapes, .shape_count = count, .origin = {origin[0], origin[1], origin[2]}});
}

/* All that a box holds; frees nothing. */
static scree_placement* ask(const scree_scatter* s, const scree_support* ground, const double min[3], const double max[3],
                            uint64_t* count) {
  uint64_t wanted = 0;
  scree_result result = scree_scatter_fill(s, ground, min, max, NULL, 0, &wanted);
  assert_int_equal(result, wanted > 0 ? SCREE_ERROR_CAPACITY : SCREE_OK);
  scree_placement* placements = malloc((wanted + 1) * sizeof *placements);
  assert_non_null(placements);
  assert_int_equal(scree_scatter_fill(s, ground, min, max, placements, wanted, count), SCREE_OK);
  assert_int_equal(*count, wanted);
  return placements;
}

static int compare(const void* a, const void* b) {
  const scree_id *p = &((const scree_placement*)a)->id, *q = &((const scree_placement*)b)->id;
  for (int k = 2; k >= 0; --k)
    if (p->cube[k] != q->cube[k]) return p->cube[k] < q->cube[k] ? -1 : 1;
  return (int)p->local - (int)q->local;
}

/* --- against the twin ------------------------------------------------------------------------------------------------------- */

static void instances_of_random_grounds_are_those_of_the_twin(void** state) {
  (void)state;
  uint64_t total = 0;
  for (uint64_t round = 0; round < 40; ++round) {
    random_stream r = {round};
    random_support* shapes = calloc(1, sizeof *shapes);
    assert_non_null(shapes);
    double origin[3], place[3];
    for (int a = 0; a < 3; ++a) {
      origin[a] = random_in(&r, -2000, 2000);
      place[a] = origin[a] + random_in(&r, -15, 15);
      shapes->desc.origin[a] = origin[a];
    }
    random_tree(shapes, &r, 1 + random_below(&r, 5), 7);
    memcpy(shapes->desc.origin, origin, sizeof origin);
    scree_support* ground;
    assert_int_equal(scree_support_create(&shapes->desc, NULL, &ground, NULL), SCREE_OK);
    random_scatter s;
    make_random_scatter(&s, &r, random_in(&r, 0.7, 2.5), place);
    double low[3], high[3];
    scree_support_bounds(ground, low, high);
    const double side = scree_scatter_tile_width(s.scatter);
    int32_t first[2], end[2];
    double bottom = fmax(low[1], origin[1] - 60);
    for (int i = 0; i < 2; ++i) {
      first[i] = (int32_t)floor((fmax(low[2 * i], origin[2 * i] - 25) - place[2 * i]) / side);
      end[i] = (int32_t)floor((fmin(high[2 * i], origin[2 * i] + 25) - place[2 * i]) / side) + 1;
    }
    double min[3] = {place[0] + first[0] * side, bottom, place[2] + first[1] * side};
    double max[3] = {place[0] + end[0] * side, high[1] + 1, place[2] + end[1] * side};
    twin_stands expected = twin_scatter(s.scatter, &s.desc, ground, first, end, high[1] + 0.5, bottom - 1);
    uint64_t count, at = 0;
    scree_placement* found = ask(s.scatter, ground, min, max, &count);
    qsort(found, count, sizeof *found, compare);
    for (uint64_t i = 0; i < expected.count; ++i) {
      const twin_stand* e = &expected.stands[i];
      bool inside = true;
      double position[3];
      for (int a = 0; a < 3; ++a) {
        position[a] = place[a] + s.scatter->unit * (double)e->steps[a];
        inside = inside && position[a] >= min[a] && position[a] < max[a];
      }
      if (!inside) continue;
      ++at;
      scree_placement key = {.id = e->id};
      const scree_placement* p = bsearch(&key, found, count, sizeof *found, compare);
      assert_non_null(p);
      assert_memory_equal(p->position, position, sizeof position);
      assert_int_equal(p->model, e->model);
      assert_int_equal(p->random, e->random);
    }
    assert_int_equal(at, count);
    total += count;
    free(found);
    free(expected.stands);
    scree_scatter_destroy(s.scatter);
    scree_support_destroy(ground);
    free(shapes);
  }
  print_message("%llu instances\n", (unsigned long long)total);
  assert_true(total > 1000);
}

/* --- grounds that are known ------------------------------------------------------------------------------------------------- */

static const scree_scatter_model post = {.footprint_radius = 0.3f, .height = 2};

static scree_scatter* make_scatter(const scree_scatter_desc* desc) {
  scree_scatter* s;
  scree_error error;
  if (scree_scatter_create(desc, NULL, &s, &error) != SCREE_OK) fail_msg("%s", error.message);
  return s;
}

static void boxes_that_share_a_face_share_no_instance_and_leave_none_out(void** state) {
  (void)state;
  const uint32_t children[] = {1, 2};
  scree_shape shapes[] = {{.kind = SCREE_SHAPE_UNION, .group = {children, 2, 0}},
                          {.kind = SCREE_SHAPE_BOX, .box = {{40, 2, 40}, 0}},
                          {.kind = SCREE_SHAPE_SPHERE, .sphere = {12}}};
  scree_support* ground = make_support(shapes, 3, nowhere);
  scree_scatter* s = make_scatter(&(scree_scatter_desc){.models = &post, .model_count = 1, .spacing = 1.3, .origin = {5, 1, 3}});
  uint64_t all, sum = 0;
  free(ask(s, ground, nowhere, nowhere, &all));
  assert_true(all > 2000);
  for (int z = -3; z < 3; ++z)
    for (int y = -1; y < 2; ++y)
      for (int x = -3; x < 3; ++x) {
        const double min[3] = {x * 13.7, y * 7.1, z * 14.01}, max[3] = {(x + 1) * 13.7, (y + 1) * 7.1, (z + 1) * 14.01};
        uint64_t count;
        scree_placement* found = ask(s, ground, min, max, &count);
        for (uint64_t i = 0; i < count; ++i)
          for (int a = 0; a < 3; ++a) assert_true(found[i].position[a] >= min[a] && found[i].position[a] < max[a]);
        sum += count;
        free(found);
      }
  assert_int_equal(sum, all);
  scree_scatter_destroy(s);
  scree_support_destroy(ground);
}

/* A plane of some degrees: all stand as long as it is not too steep, none when it is, and the circle is never over the ground. */
static void footprints_touch_a_slope_all_round_and_end_at_the_steepest(void** state) {
  (void)state;
  const double degrees[] = {0, 10, 30, 44, 46, 60};
  for (int i = 0; i < 6; ++i) {
    const double tilt = degrees[i] * 3.14159265358979 / 180;
    scree_shape slab = {.kind = SCREE_SHAPE_BOX, .box = {{20, 1, 20}, 0}};
    slab.transform.rotation[2] = (float)sin(tilt / 2); /* rises along x */
    slab.transform.rotation[3] = (float)cos(tilt / 2);
    scree_support* ground = make_support(&slab, 1, nowhere);
    scree_scatter* s = make_scatter(&(scree_scatter_desc){.models = &post, .model_count = 1, .spacing = 1});
    const double min[3] = {-4, -50, -10}, max[3] = {4, 50, 10};
    uint64_t count;
    scree_placement* found = ask(s, ground, min, max, &count);
    if (degrees[i] < 45) {
      assert_true(count > 90);
    } else {
      assert_int_equal(count, 0);
    }
    for (uint64_t k = 0; k < count; ++k) {
      const double surface = tan(tilt) * found[k].position[0] + 1 / cos(tilt), sunk = surface - found[k].position[1];
      const double least = 0.3 * tan(tilt);
      assert_true(sunk >= least - 1e-5 && sunk <= least + 2 * scree_scatter_tile_width(s) / 4096);
    }
    free(found);
    scree_scatter_destroy(s);
    scree_support_destroy(ground);
  }
}

static void nothing_hangs_over_an_edge(void** state) {
  (void)state;
  const scree_shape slab = {.kind = SCREE_SHAPE_BOX, .box = {{10, 1, 10}, 0}};
  scree_support* ground = make_support(&slab, 1, nowhere);
  scree_scatter* s = make_scatter(&(scree_scatter_desc){.models = &post, .model_count = 1, .spacing = 0.5});
  uint64_t count;
  scree_placement* found = ask(s, ground, nowhere, nowhere, &count);
  assert_true(count > 800);
  for (uint64_t i = 0; i < count; ++i) {
    /* Eight places of the circle are looked at: between two of them it can reach out by 8 % of its radius. */
    assert_true(fabs(found[i].position[0]) <= 10 - 0.27 && fabs(found[i].position[2]) <= 10 - 0.27);
    assert_true(found[i].position[1] <= 1 && found[i].position[1] > 0.99);
  }
  free(found);
  scree_scatter_destroy(s);
  scree_support_destroy(ground);
}

static void points_keep_their_distance_on_endless_ground(void** state) {
  (void)state;
  const scree_shape plane = {.kind = SCREE_SHAPE_HALF_SPACE};
  const double far[3] = {3e6, -20, -7e5};
  scree_support* ground = make_support(&plane, 1, far);
  scree_scatter* s = make_scatter(&(scree_scatter_desc){.models = &post, .model_count = 1, .spacing = 2, .seed = 3});
  const double min[3] = {3e6 - 30, -100, -7e5 - 30}, max[3] = {3e6 + 30, 100, -7e5 + 30};
  uint64_t count;
  scree_placement* found = ask(s, ground, min, max, &count);
  assert_true(count > 560 && count < 720); /* 0.7 for each spacing squared */
  for (uint64_t i = 0; i < count; ++i)
    for (uint64_t k = 0; k < i; ++k)
      assert_true(hypot(found[i].position[0] - found[k].position[0], found[i].position[2] - found[k].position[2]) >= 2 - 1e-9);
  assert_int_equal(scree_scatter_fill(s, ground, nowhere, nowhere, NULL, 0, &count), SCREE_ERROR_RANGE);
  free(found);
  scree_scatter_destroy(s);
  scree_support_destroy(ground);
}

/* --- models, turns, sizes --------------------------------------------------------------------------------------------------- */

static void turns_are_unit_vectors_all_round_and_sizes_fill_their_range(void** state) {
  (void)state;
  scree_scatter* s =
      make_scatter(&(scree_scatter_desc){.models = &post, .model_count = 1, .spacing = 2, .scale_min = 0.5f, .scale_max = 3});
  uint32_t angles[36] = {0};
  float least = 10, most = 0;
  for (uint32_t i = 0; i < 360000; ++i) {
    float turn[2], scale;
    scree_scatter_turn(s, (uint32_t)(hash_mix(i + 1) >> 32), turn, &scale);
    assert_true(fabsf(turn[0] * turn[0] + turn[1] * turn[1] - 1) < 1e-6f);
    ++angles[(int)floor((atan2((double)turn[0], (double)turn[1]) / 6.283185307179587 + 0.5) * 35.99999)];
    assert_true(scale >= 0.5f && scale <= 3);
    least = fminf(least, scale);
    most = fmaxf(most, scale);
  }
  for (int i = 0; i < 36; ++i) assert_true(abs((int)angles[i] - 10000) < 600); /* the curve is right to two percent */
  assert_true(least < 0.501f && most > 2.999f);
  float turn[2], scale;
  scree_scatter_turn(s, 0, turn, &scale);
  assert_true(turn[0] == 0 && turn[1] == 1 && scale == 0.5f);
  scree_scatter_turn(s, UINT32_C(0x4000ffff), turn, &scale);
  assert_true(turn[0] == 1 && fabsf(turn[1]) == 0 && scale == 3);
  scree_scatter_destroy(s);
}

static void weights_choose_models_and_masks_their_ages(void** state) {
  (void)state;
  const scree_shape slab = {.kind = SCREE_SHAPE_BOX, .box = {{100, 1, 100}, 0}};
  scree_support* ground = make_support(&slab, 1, nowhere);
  const scree_scatter_model models[6] = {post, post, post, post, post, post}; /* two variants of three ages */
  const float weights[6] = {1, 1, 1, 3, 3, 3}, image[4] = {0, 1, 0, 1};
  const scree_filter mask = {.kind = SCREE_FILTER_MASK, .values = image, .width = 2, .depth = 2, .spacing = 100};
  scree_scatter_desc desc = {.models = models, .model_count = 6, .weights = weights, .age_count = 3, .spacing = 1};
  for (int masked = 0; masked < 2; ++masked) {
    desc.age_mask = masked ? &mask : NULL;
    scree_scatter* s = make_scatter(&desc);
    uint64_t count, of[6] = {0}, young_left = 0, left = 0, old_right = 0, right = 0;
    scree_placement* found = ask(s, ground, nowhere, nowhere, &count);
    for (uint64_t i = 0; i < count; ++i) {
      ++of[found[i].model];
      left += found[i].position[0] < -50;
      right += found[i].position[0] > 50;
      young_left += found[i].position[0] < -50 && found[i].model % 3 == 0;
      old_right += found[i].position[0] > 50 && found[i].model % 3 == 2;
    }
    assert_true(count > 25000);
    const double threes = (double)(of[3] + of[4] + of[5]) / (double)count;
    assert_true(threes > 0.74 && threes < 0.76);
    if (masked) {
      assert_int_equal(young_left, left);
      assert_int_equal(old_right, right);
    } else {
      assert_true(fabs((double)young_left / (double)left - 1 / 3.0) < 0.02);
    }
    free(found);
    scree_scatter_destroy(s);
  }
  scree_support_destroy(ground);
}

static void parts_are_the_hull_that_was_given_or_a_prism(void** state) {
  (void)state;
  const float tent[] = {-1, 0, -1, 1, 0, -1, 0, 0, 1, 0, 2, 0};
  const scree_scatter_model models[2] = {post, {.footprint_radius = 1, .height = 2, .hull = tent, .hull_count = 4}};
  scree_scatter* s = make_scatter(&(scree_scatter_desc){.models = models, .model_count = 2, .spacing = 5});
  float xyz[3 * 64];
  uint32_t count;
  assert_int_equal(scree_scatter_part(s, 1, 0, xyz, 64, &count), SCREE_OK);
  assert_int_equal(count, 4);
  assert_memory_equal(xyz, tent, sizeof tent);
  assert_int_equal(scree_scatter_part(s, 0, 0, xyz, 64, &count), SCREE_OK);
  assert_int_equal(count, 16);
  for (uint32_t i = 0; i < count; ++i) {
    assert_true(fabsf(hypotf(xyz[3 * i], xyz[3 * i + 2]) - 0.3f) < 1e-6f);
    assert_true(xyz[3 * i + 1] == (i < 8 ? 0.0f : 2.0f));
  }
  assert_int_equal(scree_scatter_part(s, 1, 0, xyz, 3, &count), SCREE_ERROR_CAPACITY);
  assert_int_equal(count, 4);
  assert_int_equal(scree_scatter_part(s, 1, 1, xyz, 64, &count), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_scatter_part(s, 2, 0, xyz, 64, &count), SCREE_ERROR_INVALID_ARGUMENT);
  scree_scatter_destroy(s);
}

/* --- what is refused -------------------------------------------------------------------------------------------------------- */

static void refuse(scree_scatter_desc desc, scree_result expected, const char* words) {
  scree_scatter* s = (scree_scatter*)&desc;
  scree_error error;
  assert_int_equal(scree_scatter_create(&desc, NULL, &s, &error), expected);
  assert_null(s);
  if (strstr(error.message, words) == NULL) fail_msg("\"%s\" does not say \"%s\"", error.message, words);
}

static void wrong_descriptors_are_refused_with_the_reason(void** state) {
  (void)state;
  const scree_scatter_desc good = {.models = &post, .model_count = 1, .spacing = 1};
  const float nan_point[12] = {NAN}, none[2] = {0, 0}, values[4] = {0, 0, 2, 0};
  scree_filter mask = {.kind = SCREE_FILTER_MASK, .values = values, .width = 2, .depth = 2, .spacing = 1};
  scree_scatter_model models[2] = {post, post};
  scree_scatter_desc d = good;
#define REFUSE(change, code, words) \
  do {                              \
    d = good;                       \
    models[1] = post;               \
    change;                         \
    refuse(d, code, words);         \
  } while (0)
  REFUSE(d.models = NULL, SCREE_ERROR_INVALID_ARGUMENT, "models is NULL");
  REFUSE(d.model_count = 0, SCREE_ERROR_RANGE, "model_count is 0");
  REFUSE(d.model_count = 65537, SCREE_ERROR_RANGE, "model_count is 65537");
  REFUSE(d.spacing = 0, SCREE_ERROR_RANGE, "spacing is 0");
  REFUSE(d.spacing = NAN, SCREE_ERROR_RANGE, "spacing");
  REFUSE(d.origin[1] = INFINITY, SCREE_ERROR_RANGE, "origin");
  REFUSE(d.scale_max = 1, SCREE_ERROR_RANGE, "scale_min is 0");
  REFUSE(d.scale_min = 1, SCREE_ERROR_RANGE, "scale_max is 0");
  REFUSE(d.max_slope = 81, SCREE_ERROR_RANGE, "max_slope is 81");
  REFUSE(d.max_slope = -1, SCREE_ERROR_RANGE, "max_slope");
  REFUSE((d.models = models, d.model_count = 2, models[1].height = 0), SCREE_ERROR_RANGE, "model 1: height is 0");
  REFUSE((d.models = models, d.model_count = 2, models[1].footprint_radius = -1), SCREE_ERROR_RANGE, "footprint_radius is -1");
  REFUSE((d.models = models, d.model_count = 2, models[1].outer_radius = NAN), SCREE_ERROR_RANGE, "outer_radius");
  REFUSE((d.models = models, d.model_count = 2, models[1].hull = nan_point, models[1].hull_count = 4), SCREE_ERROR_RANGE, "hull");
  REFUSE((d.models = models, d.model_count = 2, models[1].hull = nan_point, models[1].hull_count = 3), SCREE_ERROR_RANGE,
         "hull_count is 3");
  REFUSE((d.models = models, d.model_count = 2, d.weights = none), SCREE_ERROR_INVALID_ARGUMENT, "weights");
  REFUSE((d.models = models, d.model_count = 2, d.age_count = 3), SCREE_ERROR_INVALID_ARGUMENT, "age_count");
  REFUSE((d.age_mask = &mask), SCREE_ERROR_RANGE, "age_mask: a value is 2");
  const float fine[4] = {0, 0, 1, 0};
  mask.values = fine;
  mask.kind = SCREE_FILTER_ALTITUDE;
  REFUSE((d.age_mask = &mask), SCREE_ERROR_INVALID_ARGUMENT, "age_mask: it has to be of kind MASK");
#undef REFUSE
}

static void wrong_questions_are_refused(void** state) {
  (void)state;
  const scree_shape ball = {.kind = SCREE_SHAPE_SPHERE, .sphere = {3}};
  scree_shape wall = {.kind = SCREE_SHAPE_HALF_SPACE};
  wall.transform.rotation[0] = wall.transform.rotation[3] = 0.70710678f;
  scree_support *ground = make_support(&ball, 1, nowhere), *upright = make_support(&wall, 1, nowhere);
  scree_scatter* s = make_scatter(&(scree_scatter_desc){.models = &post, .model_count = 1, .spacing = 1});
  const double low[3] = {-1, -1, -1}, high[3] = {1, 1, 1}, bad[3] = {NAN, 1, 1};
  uint64_t count = 7;
  assert_int_equal(scree_scatter_fill(s, ground, high, low, NULL, 0, &count), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(count, 0);
  assert_int_equal(scree_scatter_fill(s, ground, low, bad, NULL, 0, &count), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_scatter_fill(s, ground, low, high, NULL, 1, &count), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_scatter_fill(NULL, ground, low, high, NULL, 0, &count), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_scatter_fill(s, upright, low, high, NULL, 0, &count), SCREE_ERROR_RANGE);
  scree_scatter_destroy(s);
  scree_scatter_destroy(NULL);
  scree_support_destroy(ground);
  scree_support_destroy(upright);
}

static void each_allocation_may_fail(void** state) {
  (void)state;
  random_stream r = {3};
  for (int round = 0; round < 5; ++round) {
    random_scatter s;
    make_random_scatter(&s, &r, 2, nowhere);
    scree_scatter_destroy(s.scatter);
    bool failed = true;
    for (int at = 0; failed; ++at) {
      failing_allocator failing = {.fail_at = at};
      const scree_allocator allocator = failing_allocator_of(&failing);
      scree_error error;
      const scree_result result = scree_scatter_create(&s.desc, &allocator, &s.scatter, &error);
      failed = result != SCREE_OK;
      if (failed) {
        assert_int_equal(result, SCREE_ERROR_OUT_OF_MEMORY);
        assert_true(failing.failed);
        assert_null(s.scatter);
      } else {
        assert_true(at >= 4);
        scree_scatter_destroy(s.scatter);
      }
      assert_int_equal(failing.live, 0);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(instances_of_random_grounds_are_those_of_the_twin),
      cmocka_unit_test(boxes_that_share_a_face_share_no_instance_and_leave_none_out),
      cmocka_unit_test(footprints_touch_a_slope_all_round_and_end_at_the_steepest),
      cmocka_unit_test(nothing_hangs_over_an_edge),
      cmocka_unit_test(points_keep_their_distance_on_endless_ground),
      cmocka_unit_test(turns_are_unit_vectors_all_round_and_sizes_fill_their_range),
      cmocka_unit_test(weights_choose_models_and_masks_their_ages),
      cmocka_unit_test(parts_are_the_hull_that_was_given_or_a_prism),
      cmocka_unit_test(wrong_descriptors_are_refused_with_the_reason),
      cmocka_unit_test(wrong_questions_are_refused),
      cmocka_unit_test(each_allocation_may_fail),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
