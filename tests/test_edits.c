/* Sets of edits against a plain list. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "edits_internal.h"
#include "failing_allocator.h"
#include "synthetic_field.h"

enum { IDS = 4096 };

/* The twin: an array in no order, searched from its start. */
typedef struct plain_edits {
  scree_id ids[IDS];
  scree_edit edits[IDS];
  size_t count;
} plain_edits;

static bool same_id(const scree_id* a, const scree_id* b) {
  return memcmp(a, b, sizeof *a) == 0;
}

static void plain_set(plain_edits* p, const scree_id* id, scree_edit edit) {
  for (size_t i = 0; i < p->count; ++i)
    if (same_id(&p->ids[i], id)) {
      p->edits[i] = edit;
      return;
    }
  p->ids[p->count] = *id;
  p->edits[p->count++] = edit;
}

static scree_edit plain_get(const plain_edits* p, const scree_id* id) {
  for (size_t i = 0; i < p->count; ++i)
    if (same_id(&p->ids[i], id)) return p->edits[i];
  return SCREE_EDIT_NONE;
}

static scree_id random_id(random_stream* r, int32_t reach) {
  scree_id id = {{0, 0, 0}, (uint16_t)random_below(r, 4), (uint16_t)(random_below(r, 3) * 21845)};
  for (int a = 0; a < 3; ++a) id.cube[a] = (int32_t)random_below(r, (uint32_t)(2 * reach + 1)) - reach;
  return id;
}

static bool in_box(const scree_id* id, uint16_t layer, const int32_t low[3], const int32_t high[3]) {
  for (int a = 0; a < 3; ++a)
    if (id->cube[a] < low[a] || id->cube[a] >= high[a]) return false;
  return id->layer == layer;
}

static void check_box(const scree_edits* edits, const plain_edits* p, uint16_t layer, const int32_t low[3], const int32_t high[3]) {
  size_t expected = 0, found = 0, next = 0;
  for (size_t i = 0; i < p->count; ++i) expected += p->edits[i] != SCREE_EDIT_NONE && in_box(&p->ids[i], layer, low, high);
  const edits_entry* last = NULL;
  for (const edits_entry* e; (e = scree_rt_edits_next(edits, layer, low, high, &next)) != NULL; last = e, ++found) {
    assert_true(in_box(&e->id, layer, low, high));
    assert_int_equal(plain_get(p, &e->id), e->edit);
    assert_true(last == NULL || scree_rt_edits_compare(&last->id, &e->id) < 0);
  }
  assert_null(scree_rt_edits_next(edits, layer, low, high, &next));
  assert_int_equal(found, expected);
  assert_int_equal(scree_rt_edits_any(edits, layer, low, high), expected > 0);
}

static void random_edits_are_those_of_a_plain_list(void** state) {
  (void)state;
  random_stream r = {1};
  static plain_edits plain;
  for (int round = 0; round < 20; ++round) {
    plain.count = 0;
    scree_edits* edits;
    assert_int_equal(scree_edits_create(NULL, &edits), SCREE_OK);
    const int32_t reach = 1 + (int32_t)random_below(&r, 4);
    for (int i = 0; i < 600; ++i) {
      const scree_id id = random_id(&r, reach);
      const scree_edit edit = (scree_edit)random_below(&r, 3);
      const uint64_t revision = scree_edits_revision(edits);
      const bool changes = plain_get(&plain, &id) != edit;
      assert_int_equal(scree_edits_get(edits, &id), plain_get(&plain, &id));
      assert_int_equal(scree_edits_set(edits, &id, edit), SCREE_OK);
      plain_set(&plain, &id, edit);
      assert_int_equal(scree_edits_get(edits, &id), edit);
      assert_int_equal(scree_edits_revision(edits) > revision, changes);
    }
    size_t expected = 0;
    for (size_t i = 0; i < plain.count; ++i) expected += plain.edits[i] != SCREE_EDIT_NONE;
    assert_int_equal(scree_edits_count(edits), expected);

    static scree_id ids[IDS];
    static scree_edit states[IDS];
    assert_int_equal(scree_edits_list(edits, 0, ids, states, IDS), expected);
    for (size_t i = 0; i < expected; ++i) {
      assert_int_equal(states[i], plain_get(&plain, &ids[i]));
      assert_int_not_equal(states[i], SCREE_EDIT_NONE);
      assert_true(i == 0 || scree_rt_edits_compare(&ids[i - 1], &ids[i]) < 0);
      scree_id one;
      assert_int_equal(scree_edits_list(edits, i, &one, NULL, 1), 1);
      assert_true(same_id(&one, &ids[i]));
    }
    assert_int_equal(scree_edits_list(edits, expected, ids, states, IDS), 0);

    for (int i = 0; i < 100; ++i) {
      int32_t low[3], high[3];
      for (int a = 0; a < 3; ++a) {
        low[a] = (int32_t)random_below(&r, 10) - 6;
        high[a] = low[a] + (int32_t)random_below(&r, 6);
      }
      check_box(edits, &plain, (uint16_t)(random_below(&r, 3) * 21845), low, high);
    }
    const uint64_t revision = scree_edits_revision(edits);
    scree_edits_clear(edits);
    assert_int_equal(scree_edits_count(edits), 0);
    assert_int_equal(scree_edits_revision(edits) > revision, expected > 0);
    scree_edits_destroy(edits);
  }
}

static void order_is_layer_then_cube_z_y_x_then_local(void** state) {
  (void)state;
  const scree_id sorted[] = {{{9, 9, 9}, 9, 0},          {{INT32_MAX, INT32_MAX, INT32_MIN}, 65535, 1},
                             {{0, INT32_MIN, -1}, 0, 1}, {{5, 0, 0}, 0, 1},
                             {{5, 0, 0}, 1, 1},          {{6, 0, 0}, 0, 1},
                             {{-7, 1, 0}, 0, 1},         {{0, 0, 0}, 0, 65535}};
  const size_t count = sizeof sorted / sizeof *sorted;
  scree_edits* edits;
  assert_int_equal(scree_edits_create(NULL, &edits), SCREE_OK);
  for (size_t i = count; i-- > 0;) assert_int_equal(scree_edits_set(edits, &sorted[i], SCREE_EDIT_HIDE), SCREE_OK);
  scree_id ids[8];
  assert_int_equal(scree_edits_list(edits, 0, ids, NULL, 8), count);
  assert_memory_equal(ids, sorted, sizeof sorted);
  const int32_t low[3] = {INT32_MIN, INT32_MIN, INT32_MIN}, high[3] = {INT32_MAX, INT32_MAX, INT32_MAX};
  size_t next = 0, found = 0;
  while (scree_rt_edits_next(edits, 1, low, high, &next) != NULL) ++found;
  assert_int_equal(found, 5); /* one of the six is in the last cube, which is outside any box */
  scree_edits_destroy(edits);
}

static void merging_is_setting_one_by_one(void** state) {
  (void)state;
  random_stream r = {2};
  for (int round = 0; round < 200; ++round) {
    scree_edits *a, *b, *more;
    assert_int_equal(scree_edits_create(NULL, &a), SCREE_OK);
    assert_int_equal(scree_edits_create(NULL, &b), SCREE_OK);
    assert_int_equal(scree_edits_create(NULL, &more), SCREE_OK);
    for (uint32_t i = random_below(&r, 40); i > 0; --i) {
      const scree_id id = random_id(&r, 1);
      const scree_edit edit = (scree_edit)(1 + random_below(&r, 2));
      scree_edits_set(a, &id, edit);
      scree_edits_set(b, &id, edit);
    }
    for (uint32_t i = random_below(&r, 40); i > 0; --i) {
      const scree_id id = random_id(&r, 1);
      scree_edits_set(more, &id, (scree_edit)(1 + random_below(&r, 2)));
    }
    const uint64_t before = scree_edits_revision(a);
    for (size_t i = 0; i < more->count; ++i) scree_edits_set(a, &more->entries[i].id, more->entries[i].edit);
    const uint64_t merged = scree_edits_revision(b);
    assert_true(scree_rt_edits_merge(b, more->entries, more->count));
    assert_int_equal(scree_edits_revision(b) > merged, scree_edits_revision(a) > before);
    assert_int_equal(a->count, b->count);
    for (size_t i = 0; i < a->count; ++i) {
      assert_true(same_id(&a->entries[i].id, &b->entries[i].id));
      assert_int_equal(a->entries[i].edit, b->entries[i].edit);
    }
    scree_edits_destroy(a);
    scree_edits_destroy(b);
    scree_edits_destroy(more);
  }
}

static void wrong_arguments_are_refused(void** state) {
  (void)state;
  const scree_id id = {{0, 0, 0}, 0, 0};
  scree_edits* edits;
  assert_int_equal(scree_edits_create(NULL, NULL), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_edits_create(NULL, &edits), SCREE_OK);
  assert_int_equal(scree_edits_set(NULL, &id, SCREE_EDIT_HIDE), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_edits_set(edits, NULL, SCREE_EDIT_HIDE), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_edits_set(edits, &id, (scree_edit)3), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_edits_get(NULL, &id), SCREE_EDIT_NONE);
  assert_int_equal(scree_edits_count(NULL), 0);
  assert_int_equal(scree_edits_list(NULL, 0, NULL, NULL, 1), 0);
  scree_edits_clear(NULL);
  scree_edits_destroy(edits);
  scree_edits_destroy(NULL);
}

/* Sets and merges while the n-th allocation fails, for every n: the failing call changes nothing. */
static void failing_allocations_change_nothing(void** state) {
  (void)state;
  for (int32_t n = 0;; ++n) {
    failing_allocator memory = {.fail_at = n};
    const scree_allocator allocator = failing_allocator_of(&memory);
    scree_edits* edits;
    scree_result result = scree_edits_create(&allocator, &edits);
    if (result == SCREE_ERROR_OUT_OF_MEMORY) {
      assert_null(edits);
      assert_int_equal(memory.live, 0);
      continue;
    }
    size_t set = 0;
    for (int32_t i = 0; i < 300; ++i) {
      const scree_id id = {{i, 0, 0}, 0, 0};
      const uint64_t revision = scree_edits_revision(edits);
      result = scree_edits_set(edits, &id, SCREE_EDIT_REMOVE);
      if (result == SCREE_OK) {
        ++set;
      } else {
        assert_int_equal(result, SCREE_ERROR_OUT_OF_MEMORY);
        assert_int_equal(scree_edits_get(edits, &id), SCREE_EDIT_NONE);
        assert_int_equal(scree_edits_revision(edits), revision);
      }
      assert_int_equal(scree_edits_count(edits), set);
    }
    const edits_entry more[2] = {{{{-1, 0, 0}, 0, 0}, SCREE_EDIT_HIDE}, {{{5, 0, 0}, 0, 0}, SCREE_EDIT_HIDE}};
    const uint64_t revision = scree_edits_revision(edits);
    if (!scree_rt_edits_merge(edits, more, 2)) {
      assert_int_equal(scree_edits_count(edits), set);
      assert_int_equal(scree_edits_revision(edits), revision);
      assert_int_equal(scree_edits_get(edits, &more[1].id), SCREE_EDIT_REMOVE);
    }
    scree_edits_destroy(edits);
    assert_int_equal(memory.live, 0);
    if (!memory.failed) break;
    assert_true(n < 30);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(random_edits_are_those_of_a_plain_list), cmocka_unit_test(order_is_layer_then_cube_z_y_x_then_local),
      cmocka_unit_test(merging_is_setting_one_by_one),          cmocka_unit_test(wrong_arguments_are_refused),
      cmocka_unit_test(failing_allocations_change_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
