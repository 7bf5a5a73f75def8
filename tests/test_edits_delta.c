/* Edits as bytes: what is saved is loaded, on scenes that have changed too, and nothing else is.
 *
 * usage: test_edits_delta [FOLDER]: FOLDER gets cases for edits_reader.py, which must say the same of each. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <scree/scene.h>

#include "edits_internal.h"
#include "failing_allocator.h"
#include "pack_format.h"
#include "synthetic_field.h"

enum { LAYERS = 3, MOST_EDITS = 4096 };

static const uint16_t keys[LAYERS] = {7, 0, 65535};

/* Three layers on random fields of two kinds. */
typedef struct world {
  synthetic_source sources[2];
  scree_field_desc descs[LAYERS];
  scree_field* fields[LAYERS];
  scree_support* support;
  scree_scene* scene;
} world;

static void make_scene(world* w, uint32_t layer_count) {
  scree_layer layers[LAYERS] = {{0}};
  for (uint32_t i = 0; i < layer_count; ++i)
    layers[i] = (scree_layer){.field = w->fields[i], .support = w->support, .key = keys[i]};
  const scree_scene_desc desc = {layers, layer_count};
  scree_error error;
  if (scree_scene_create(&desc, NULL, &w->scene, &error) != SCREE_OK) fail_msg("%s", error.message);
}

static void make_field(world* w, uint32_t i) {
  assert_int_equal(scree_rt_field_create_from_source(&w->descs[i], &w->sources[i % 2].source, NULL, &w->fields[i]), SCREE_OK);
}

static void make_world(world* w) {
  memset(w, 0, sizeof *w);
  w->sources[0] = synthetic_create(3, 1, 1, 1);
  w->sources[1] = synthetic_create(4, 0, 3, 2);
  for (uint32_t i = 0; i < LAYERS; ++i) {
    w->descs[i] = (scree_field_desc){.seed = UINT64_C(0x123456789abcdef) * (i + 1), .cell_size = 0.3 + i};
    for (int a = 0; a < 3; ++a) w->descs[i].origin[a] = (a - 1) * 1e6 / 3;
    make_field(w, i);
  }
  const scree_shape ball = {.kind = SCREE_SHAPE_SPHERE, .sphere = {.radius = 3}};
  const scree_support_desc desc = {.shapes = &ball, .shape_count = 1};
  assert_int_equal(scree_support_create(&desc, NULL, &w->support, NULL), SCREE_OK);
  make_scene(w, LAYERS);
}

static void destroy_world(world* w) {
  scree_scene_destroy(w->scene);
  scree_support_destroy(w->support);
  for (int i = 0; i < LAYERS; ++i) scree_field_destroy(w->fields[i]);
  for (int i = 0; i < 2; ++i) synthetic_destroy(&w->sources[i]);
}

/* The plain way to know whether a rock stands somewhere. */
static bool stands(const world* w, uint32_t layer, const scree_id* id) {
  const field_source* s = &w->sources[layer % 2].source;
  const uint32_t n = s->cells_per_cube, cell = id->local / s->max_rocks_per_cell, seed = id->local % s->max_rocks_per_cell;
  if (cell >= n * n * n) return false;
  for (int a = 0; a < 3; ++a)
    if (id->cube[a] == INT32_MAX) return false;
  const uint32_t code = cube_code(w->descs[layer].seed, id->cube[0], id->cube[1], id->cube[2]);
  const uint32_t unique = s->tile_cells[code * n * n * n + cell];
  for (uint32_t i = s->cell_first[unique]; i < s->cell_first[unique + 1]; ++i)
    if (s->rocks[i].seed == seed) return true;
  return false;
}

static scree_id random_id(const world* w, random_stream* r, uint32_t layer) {
  const field_source* s = &w->sources[layer % 2].source;
  const uint32_t locals = s->cells_per_cube * s->cells_per_cube * s->cells_per_cube * s->max_rocks_per_cell;
  scree_id id = {.layer = keys[layer]};
  id.local = (uint16_t)random_below(r, random_below(r, 8) == 0 ? 65536 : locals);
  for (int a = 0; a < 3; ++a) {
    id.cube[a] = (int32_t)random_below(r, 7) - 3;
    if (random_below(r, 16) == 0) id.cube[a] = (int32_t)(uint32_t)random_bits(r);
    if (random_below(r, 64) == 0) id.cube[a] = random_below(r, 2) ? INT32_MAX : INT32_MIN;
  }
  return id;
}

typedef struct counts {
  uint64_t all[LAYERS], standing[LAYERS];
} counts;

static scree_edits* random_edits(const world* w, random_stream* r, uint32_t most, counts* c) {
  scree_edits* edits;
  assert_int_equal(scree_edits_create(NULL, &edits), SCREE_OK);
  for (uint32_t i = random_below(r, most + 1); i > 0; --i) {
    const scree_id id = random_id(w, r, random_below(r, LAYERS));
    assert_int_equal(scree_edits_set(edits, &id, (scree_edit)(1 + random_below(r, 2))), SCREE_OK);
  }
  memset(c, 0, sizeof *c);
  for (size_t i = 0; i < edits->count; ++i)
    for (uint32_t l = 0; l < LAYERS; ++l)
      if (edits->entries[i].id.layer == keys[l]) {
        ++c->all[l];
        c->standing[l] += stands(w, l, &edits->entries[i].id);
      }
  return edits;
}

/* Exactly as long as the delta. */
static uint8_t* save(const scree_edits* edits, const scree_scene* scene, size_t* size) {
  assert_int_equal(scree_edits_save(edits, scene, NULL, 0, size), SCREE_ERROR_CAPACITY);
  const size_t needed = *size;
  uint8_t* bytes = malloc(needed);
  assert_int_equal(scree_edits_save(edits, scene, bytes, needed - 1, size), SCREE_ERROR_CAPACITY);
  assert_int_equal(*size, needed);
  assert_int_equal(scree_edits_save(edits, scene, bytes, needed, size), SCREE_OK);
  assert_int_equal(*size, needed);
  return bytes;
}

static bool same_set(const scree_edits* a, const scree_edits* b) {
  if (a->count != b->count) return false;
  for (size_t i = 0; i < a->count; ++i)
    if (memcmp(&a->entries[i].id, &b->entries[i].id, sizeof(scree_id)) != 0 || a->entries[i].edit != b->entries[i].edit)
      return false;
  return true;
}

static void what_is_saved_is_loaded_where_rocks_stand(void** state) {
  (void)state;
  random_stream r = {1};
  world here, there; /* two machines */
  make_world(&here);
  make_world(&there);
  for (int round = 0; round < 100; ++round) {
    counts c;
    scree_edits *edits = random_edits(&here, &r, 300, &c), *expected, *loaded;
    assert_int_equal(scree_edits_create(NULL, &expected), SCREE_OK);
    assert_int_equal(scree_edits_create(NULL, &loaded), SCREE_OK);
    for (uint32_t i = random_below(&r, 100); i > 0; --i) { /* what was there before stays, where the delta says nothing of it */
      const scree_id id = random_id(&here, &r, random_below(&r, LAYERS));
      scree_edits_set(expected, &id, SCREE_EDIT_HIDE);
      scree_edits_set(loaded, &id, SCREE_EDIT_HIDE);
    }
    uint64_t applied = 0, unknown = 0;
    for (size_t i = 0; i < edits->count; ++i)
      for (uint32_t l = 0; l < LAYERS; ++l)
        if (edits->entries[i].id.layer == keys[l]) {
          const bool standing = stands(&here, l, &edits->entries[i].id);
          applied += standing;
          unknown += !standing;
          if (standing) scree_edits_set(expected, &edits->entries[i].id, edits->entries[i].edit);
        }
    size_t size, again_size;
    uint8_t* bytes = save(edits, here.scene, &size);
    scree_edits_report report;
    assert_int_equal(scree_edits_load(loaded, there.scene, bytes, size, &report), SCREE_OK);
    assert_int_equal(report.applied, applied);
    assert_int_equal(report.unknown_rock, unknown);
    assert_int_equal(report.unknown_layer + report.stale, 0);
    assert_true(same_set(expected, loaded));

    uint8_t *a = save(expected, here.scene, &size), *b = save(loaded, there.scene, &again_size);
    assert_int_equal(size, again_size);
    assert_memory_equal(a, b, size);
    free(a);
    free(b);
    free(bytes);
    scree_edits_destroy(edits);
    scree_edits_destroy(expected);
    scree_edits_destroy(loaded);
  }
  destroy_world(&here);
  destroy_world(&there);
}

static void a_layer_made_of_something_else_is_stale(void** state) {
  (void)state;
  random_stream r = {2};
  for (int change = 0; change < 6; ++change) {
    world w;
    make_world(&w);
    counts c;
    scree_edits *edits = random_edits(&w, &r, 300, &c), *loaded;
    size_t size;
    uint8_t* bytes = save(edits, w.scene, &size);
    scree_scene_destroy(w.scene);
    scree_field_destroy(w.fields[1]);
    scree_field_desc* d = &w.descs[1];
    if (change == 0) d->seed ^= UINT64_C(1) << 63;
    if (change == 1) d->cell_size += 1e-12;
    if (change >= 2 && change < 5) d->origin[change - 2] += 1e-6;
    make_field(&w, 1);
    make_scene(&w, LAYERS);
    if (change == 5) { /* of another pack: its digest in the delta is another */
      for (size_t at = 24; at < 24 + 3 * 64; at += 64)
        if (bytes[at] == keys[1] && bytes[at + 1] == 0) bytes[at + 16] ^= 1;
      const uint64_t digest = scree_rt_pack_bytes_digest(bytes, size - 8);
      memcpy(bytes + size - 8, &digest, 8);
    }
    assert_int_equal(scree_edits_create(NULL, &loaded), SCREE_OK);
    scree_edits_report report;
    assert_int_equal(scree_edits_load(loaded, w.scene, bytes, size, &report), SCREE_OK);
    assert_true(c.all[1] > 0);
    assert_int_equal(report.stale, c.all[1]);
    assert_int_equal(report.applied, c.standing[0] + c.standing[2]);
    assert_int_equal(report.applied, scree_edits_count(loaded));
    for (size_t i = 0; i < loaded->count; ++i) assert_int_not_equal(loaded->entries[i].id.layer, keys[1]);
    free(bytes);
    scree_edits_destroy(edits);
    scree_edits_destroy(loaded);
    destroy_world(&w);
  }
}

static void a_layer_that_is_gone_is_reported(void** state) {
  (void)state;
  random_stream r = {3};
  world w;
  make_world(&w);
  counts c;
  scree_edits *edits = random_edits(&w, &r, 300, &c), *loaded;
  size_t size;
  uint8_t* bytes = save(edits, w.scene, &size);
  scree_scene_destroy(w.scene);
  make_scene(&w, 2);
  assert_int_equal(scree_edits_create(NULL, &loaded), SCREE_OK);
  scree_edits_report report;
  assert_int_equal(scree_edits_load(loaded, w.scene, bytes, size, &report), SCREE_OK);
  assert_true(c.all[2] > 0);
  assert_int_equal(report.unknown_layer, c.all[2]);
  assert_int_equal(report.applied, c.standing[0] + c.standing[1]);
  assert_int_equal(report.stale, 0);
  assert_int_equal(scree_edits_save(edits, w.scene, NULL, 0, &size), SCREE_ERROR_INVALID_ARGUMENT);
  free(bytes);
  scree_edits_destroy(edits);
  scree_edits_destroy(loaded);
  destroy_world(&w);
}

static void seal(uint8_t* bytes, size_t size) {
  if (size < 8) return;
  const uint64_t digest = scree_rt_pack_bytes_digest(bytes, size - 8);
  for (int i = 0; i < 8; ++i) bytes[size - 8 + i] = (uint8_t)(digest >> (8 * i));
}

/* Loads into a set that has an edit already; whatever fails must leave it alone. */
static scree_result load_bad(const world* w, const uint8_t* bytes, size_t size) {
  scree_edits *edits, *before;
  assert_int_equal(scree_edits_create(NULL, &edits), SCREE_OK);
  assert_int_equal(scree_edits_create(NULL, &before), SCREE_OK);
  const scree_id id = {{100, 0, 0}, 0, 0};
  scree_edits_set(edits, &id, SCREE_EDIT_HIDE);
  scree_edits_set(before, &id, SCREE_EDIT_HIDE);
  uint8_t* exact = malloc(size > 0 ? size : 1);
  memcpy(exact, bytes, size);
  scree_edits_report report;
  const scree_result result = scree_edits_load(edits, w->scene, exact, size, &report);
  if (result != SCREE_OK) {
    assert_true(same_set(edits, before));
    assert_int_equal(scree_edits_revision(edits), 1);
    assert_int_equal(report.applied + report.stale + report.unknown_layer + report.unknown_rock, 0);
  } else {
    assert_true(scree_edits_count(edits) <= 1 + report.applied);
    for (size_t i = 0; i < edits->count; ++i)
      for (uint32_t l = 0; l < LAYERS; ++l)
        if (edits->entries[i].id.layer == keys[l] && memcmp(&edits->entries[i].id, &id, sizeof id) != 0)
          assert_true(stands(w, l, &edits->entries[i].id));
  }
  free(exact);
  scree_edits_destroy(edits);
  scree_edits_destroy(before);
  return result;
}

static void bytes_that_end_early_are_refused(void** state) {
  (void)state;
  random_stream r = {4};
  world w;
  make_world(&w);
  counts c;
  scree_edits* edits = random_edits(&w, &r, 60, &c);
  size_t size;
  uint8_t* bytes = save(edits, w.scene, &size);
  for (size_t n = 0; n < size; ++n) assert_int_equal(load_bad(&w, bytes, n), SCREE_ERROR_TRUNCATED);
  uint8_t* longer = calloc(size + 16, 1);
  memcpy(longer, bytes, size);
  for (size_t n = size + 1; n <= size + 16; ++n) assert_int_equal(load_bad(&w, longer, n), SCREE_ERROR_CORRUPT);
  free(longer);
  free(bytes);
  scree_edits_destroy(edits);
  destroy_world(&w);
}

static void every_flipped_bit_is_found(void** state) {
  (void)state;
  random_stream r = {5};
  world w;
  make_world(&w);
  counts c;
  scree_edits* edits = random_edits(&w, &r, 60, &c);
  size_t size;
  uint8_t* bytes = save(edits, w.scene, &size);
  for (size_t bit = 0; bit < 8 * size; ++bit) {
    bytes[bit / 8] ^= (uint8_t)(1u << bit % 8);
    const scree_result result = load_bad(&w, bytes, size);
    if (bit < 64) {
      assert_int_equal(result, SCREE_ERROR_NOT_A_PACK);
    } else if (bit < 96) {
      assert_int_equal(result, SCREE_ERROR_VERSION);
    } else if (bit < 192) {
      assert_true(result == SCREE_ERROR_TRUNCATED || result == SCREE_ERROR_CORRUPT);
    } else {
      assert_int_equal(result, SCREE_ERROR_DIGEST);
    }
    bytes[bit / 8] ^= (uint8_t)(1u << bit % 8);
  }
  free(bytes);
  scree_edits_destroy(edits);
  destroy_world(&w);
}

/* A delta of two layers, keys 0 and 7, with two edits each, one byte changed and sealed again. */
static scree_result load_changed(const world* w, const uint8_t* bytes, size_t size, size_t at, int value) {
  uint8_t* copy = malloc(size);
  memcpy(copy, bytes, size);
  copy[at] = (uint8_t)value;
  seal(copy, size);
  const scree_result result = load_bad(w, copy, size);
  free(copy);
  return result;
}

static void every_rule_of_the_format_is_checked(void** state) {
  (void)state;
  world w;
  make_world(&w);
  scree_edits* edits;
  assert_int_equal(scree_edits_create(NULL, &edits), SCREE_OK);
  for (uint16_t i = 0; i < 4; ++i) {
    const scree_id id = {{0, 0, i}, 5, i < 2 ? 0 : 7};
    scree_edits_set(edits, &id, SCREE_EDIT_REMOVE);
  }
  size_t size;
  uint8_t* bytes = save(edits, w.scene, &size);
  assert_int_equal(size, 24 + 2 * 64 + 4 * 16 + 8);
  assert_int_equal(load_changed(&w, bytes, size, 24, 0), SCREE_OK);
  assert_int_equal(load_changed(&w, bytes, size, 24, 7), SCREE_ERROR_CORRUPT);     /* keys equal */
  assert_int_equal(load_changed(&w, bytes, size, 24, 8), SCREE_ERROR_CORRUPT);     /* keys out of order */
  assert_int_equal(load_changed(&w, bytes, size, 24 + 8, 0), SCREE_ERROR_CORRUPT); /* an empty layer */
  assert_int_equal(load_changed(&w, bytes, size, 24 + 8, 1), SCREE_ERROR_CORRUPT); /* counts that do not add up */
  assert_int_equal(load_changed(&w, bytes, size, 24 + 8, 3), SCREE_ERROR_CORRUPT);
  assert_int_equal(load_changed(&w, bytes, size, 24 + 15, 1), SCREE_ERROR_CORRUPT); /* a count that does not fit */
  for (size_t at = 26; at < 32; ++at) assert_int_equal(load_changed(&w, bytes, size, at, 1), SCREE_ERROR_CORRUPT); /* padding */
  const size_t first = 24 + 2 * 64;
  assert_int_equal(load_changed(&w, bytes, size, first + 14, 2), SCREE_OK);
  assert_int_equal(load_changed(&w, bytes, size, first + 14, 0), SCREE_ERROR_CORRUPT); /* states */
  assert_int_equal(load_changed(&w, bytes, size, first + 14, 3), SCREE_ERROR_CORRUPT);
  assert_int_equal(load_changed(&w, bytes, size, first + 15, 1), SCREE_ERROR_CORRUPT); /* padding */
  assert_int_equal(load_changed(&w, bytes, size, first + 8, 1), SCREE_ERROR_CORRUPT);  /* twice the same */
  assert_int_equal(load_changed(&w, bytes, size, first + 8, 2), SCREE_ERROR_CORRUPT);  /* out of order */
  for (uint8_t count = 0; count < 5; ++count) { /* where one layer's edits end is said by the counts alone, and none may be empty */
    bytes[24 + 8] = count;
    assert_int_equal(load_changed(&w, bytes, size, 24 + 64 + 8, 4 - count), count % 4 == 0 ? SCREE_ERROR_CORRUPT : SCREE_OK);
  }
  free(bytes);
  scree_edits_destroy(edits);

  assert_int_equal(scree_edits_create(NULL, &edits), SCREE_OK);
  bytes = save(edits, w.scene, &size);
  assert_int_equal(size, 32);
  assert_int_equal(scree_edits_load(edits, w.scene, bytes, size, NULL), SCREE_OK);
  free(bytes);
  scree_edits_destroy(edits);
  destroy_world(&w);
}

static void failing_allocations_change_nothing(void** state) {
  (void)state;
  random_stream r = {6};
  world w;
  make_world(&w);
  counts c;
  scree_edits* edits = random_edits(&w, &r, 100, &c);
  size_t size;
  uint8_t* bytes = save(edits, w.scene, &size);
  for (int32_t n = 0;; ++n) {
    failing_allocator memory = {.fail_at = n};
    const scree_allocator allocator = failing_allocator_of(&memory);
    scree_edits* loaded;
    if (scree_edits_create(&allocator, &loaded) != SCREE_OK) continue;
    const scree_id id = {{0, 0, 0}, 0, 1};
    const scree_edit before = scree_edits_set(loaded, &id, SCREE_EDIT_HIDE) == SCREE_OK ? SCREE_EDIT_HIDE : SCREE_EDIT_NONE;
    const uint64_t count = scree_edits_count(loaded), revision = scree_edits_revision(loaded);
    scree_edits_report report;
    const scree_result result = scree_edits_load(loaded, w.scene, bytes, size, &report);
    if (result != SCREE_OK) {
      assert_int_equal(result, SCREE_ERROR_OUT_OF_MEMORY);
      assert_int_equal(scree_edits_count(loaded), count);
      assert_int_equal(scree_edits_revision(loaded), revision);
      assert_int_equal(report.applied, 0);
    }
    assert_int_equal(scree_edits_get(loaded, &id), before);
    scree_edits_destroy(loaded);
    assert_int_equal(memory.live, 0);
    if (!memory.failed) break;
    assert_true(n < 10);
  }
  free(bytes);
  scree_edits_destroy(edits);
  destroy_world(&w);
}

/* --- cases for the second reader -------------------------------------------------------------------------------------------- */

static const char* code_name(scree_result result) {
  switch (result) {
    case SCREE_OK: return "OK";
    case SCREE_ERROR_NOT_A_PACK: return "NOT_A_PACK";
    case SCREE_ERROR_VERSION: return "VERSION";
    case SCREE_ERROR_TRUNCATED: return "TRUNCATED";
    case SCREE_ERROR_DIGEST: return "DIGEST";
    case SCREE_ERROR_CORRUPT: return "CORRUPT";
    default: return "other";
  }
}

static uint64_t bits_of(double value) {
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  return bits;
}

/* What is in the delta as this program knows it, in the words of edits_reader.py. */
static void write_text(const world* w, const scree_edits* edits, const char* path) {
  FILE* file = fopen(path, "w");
  assert_non_null(file);
  for (size_t i = 0; i < edits->count; ++i) {
    const edits_entry* e = &edits->entries[i];
    if (i == 0 || e[-1].id.layer != e->id.layer)
      for (uint32_t l = 0; l < LAYERS; ++l)
        if (keys[l] == e->id.layer) {
          const scree_field_desc* d = &w->descs[l];
          fprintf(file, "layer %u %016x %016llx %016llx", keys[l], 0, (unsigned long long)d->seed,
                  (unsigned long long)bits_of(d->cell_size));
          for (int a = 0; a < 3; ++a) fprintf(file, " %016llx", (unsigned long long)bits_of(d->origin[a]));
          fprintf(file, "\n");
        }
    fprintf(file, "edit %d %d %d %u %d\n", e->id.cube[0], e->id.cube[1], e->id.cube[2], e->id.local, (int)e->edit);
  }
  assert_int_equal(fclose(file), 0);
}

static void write_cases(const char* folder) {
  random_stream r = {7};
  world w;
  make_world(&w);
  char path[4096];
  snprintf(path, sizeof path, "%s/cases.bin", folder);
  FILE* cases = fopen(path, "wb");
  assert_non_null(cases);
  for (int i = 0; i < 3000; ++i) {
    counts c;
    scree_edits* edits = random_edits(&w, &r, i == 0 ? 300 : 6, &c);
    size_t size;
    uint8_t* bytes = save(edits, w.scene, &size);
    if (i == 0) {
      snprintf(path, sizeof path, "%s/good.bin", folder);
      FILE* good = fopen(path, "wb");
      assert_non_null(good);
      assert_int_equal(fwrite(bytes, 1, size, good), size);
      assert_int_equal(fclose(good), 0);
      snprintf(path, sizeof path, "%s/good.txt", folder);
      write_text(&w, edits, path);
    }
    for (uint32_t k = random_below(&r, 3); k > 0; --k)
      bytes[random_below(&r, (uint32_t)size)] ^= (uint8_t)(1u << random_below(&r, 8));
    if (size > 64 && random_below(&r, 2)) bytes[24 + random_below(&r, 32)] = (uint8_t)random_below(&r, 3);
    if (random_below(&r, 8) == 0) size = random_below(&r, (uint32_t)size);
    if (random_below(&r, 2)) seal(bytes, size);
    fprintf(cases, "%s %u\n", code_name(load_bad(&w, bytes, size)), (unsigned)size);
    assert_int_equal(fwrite(bytes, 1, size, cases), size);
    free(bytes);
    scree_edits_destroy(edits);
  }
  assert_int_equal(fclose(cases), 0);
  destroy_world(&w);
}

static const char* case_folder;

static void cases_for_the_second_reader_are_written(void** state) {
  (void)state;
  if (case_folder != NULL) write_cases(case_folder);
}

int main(int count, char** arguments) {
  case_folder = count > 1 ? arguments[1] : NULL;
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_is_saved_is_loaded_where_rocks_stand),
      cmocka_unit_test(a_layer_made_of_something_else_is_stale),
      cmocka_unit_test(a_layer_that_is_gone_is_reported),
      cmocka_unit_test(bytes_that_end_early_are_refused),
      cmocka_unit_test(every_flipped_bit_is_found),
      cmocka_unit_test(every_rule_of_the_format_is_checked),
      cmocka_unit_test(failing_allocations_change_nothing),
      cmocka_unit_test(cases_for_the_second_reader_are_written),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
