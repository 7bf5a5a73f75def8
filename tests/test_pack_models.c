/* Packs of models: what is written is what is read, at both doors of a mesh; what is no pack of models gives a result code. */
#include <scree/draco.h>
#include <scree/field.h>

#include "failing_allocator.h"
#include "lattice.h"
#include "make_model_pack.h"
#include "mesh_digest.h"
#include "pack_bytes.h"
#include "pack_writer.h"

#include <stdlib.h>
#include <string.h>

static const test_models_desc several = {.variants = 3, .ages = 3, .lod_count = 3};

static void what_is_written_is_what_is_read(void** state) {
  (void)state;
  rock_set* set = test_model_set_make(&several);
  uint8_t* bytes;
  size_t size;
  assert_int_equal(pack_write(set, NULL, &bytes, &size), SCREE_OK);
  scree_pack* pack = open_or_fail(bytes, size);
  assert_int_equal(scree_pack_verify(pack), SCREE_OK);
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  assert_int_equal(info.kind, SCREE_PACK_MODELS);
  assert_int_equal(info.variant_count, 3);
  assert_int_equal(info.cell_count, 3);
  assert_int_equal(info.cells_per_cube + info.proxy_count, 0);
  assert_int_equal(info.asset_count, 3 + 1 + 2);
  assert_int_equal(info.max_rocks_per_cell, 3);
  static const uint32_t ages[3] = {3, 1, 2};
  uint32_t next = 0;
  for (uint32_t variant = 0; variant < 3; ++variant) {
    for (uint32_t age = 0; age < ages[variant]; ++age) assert_int_equal(scree_pack_model(pack, variant, age), next++);
    assert_int_equal(scree_pack_model(pack, variant, ages[variant]), UINT32_MAX);
  }
  assert_int_equal(scree_pack_model(pack, 3, 0), UINT32_MAX);
  for (uint32_t i = 0; i < info.asset_count; ++i) {
    const rock_record* rock = &set->rocks[i];
    const model_record* from = &set->models[i];
    scree_asset asset;
    scree_model model;
    assert_int_equal(scree_pack_get_asset(pack, i, &asset), SCREE_OK);
    assert_int_equal(scree_pack_get_model(pack, i, &model), SCREE_OK);
    assert_int_equal(asset.burial, SCREE_BURIAL_NEVER);
    assert_int_equal(asset.contact_count, 0);
    assert_true(model.variant == rock->cell && model.age == rock->seed && asset.cell == rock->cell && asset.seed == rock->seed);
    assert_true(model.footprint == from->footprint && model.height == from->height && model.share == from->share);
    assert_true(model.steps == from->steps && model.part_count == from->part_count);
    assert_true(model.height == asset.bounds_max[1] && asset.bounds_min[1] < 0 && model.footprint > 0);
    int16_t hull[PACK_MAX_HULL][3];
    uint32_t count;
    assert_int_equal(scree_pack_get_hull(pack, i, hull[0], PACK_MAX_HULL, &count), SCREE_OK);
    assert_int_equal(count, rock->hull_count);
    assert_memory_equal(hull, rock->hull, count * sizeof *hull);
    for (uint32_t p = 0; p < model.part_count; ++p) {
      assert_int_equal(scree_pack_get_part(pack, i, p, hull[0], PACK_MAX_HULL, &count), SCREE_OK);
      assert_int_equal(count, from->part_first[p + 1] - from->part_first[p]);
      assert_memory_equal(hull, from->parts[from->part_first[p]], count * sizeof *hull);
      hull[3][0] = 12345;
      assert_int_equal(scree_pack_get_part(pack, i, p, hull[0], 3, &count), SCREE_ERROR_CAPACITY);
      assert_true(count == from->part_first[p + 1] - from->part_first[p] && hull[3][0] == 12345);
    }
    assert_int_equal(scree_pack_get_part(pack, i, model.part_count, hull[0], PACK_MAX_HULL, &count), SCREE_ERROR_INVALID_ARGUMENT);
  }
  scree_pack_section section;
  assert_int_equal(scree_pack_get_section(pack, 10, &section), SCREE_OK);
  assert_string_equal(section.name, "models");
  assert_int_equal(section.elements, info.asset_count);
  scree_pack_close(pack);
  free(bytes);
  test_model_set_free(set);
}

static void surfaces_come_back_from_both_codecs(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_model_pack_make(&several, &size);
  scree_pack* pack = open_or_fail(bytes, size);
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  bool colluvium = false, bed = false, hollow = false, edge = false;
  for (uint32_t i = 0; i < info.asset_count; ++i)
    for (uint32_t lod = 0; lod < info.lod_count; ++lod) {
      scree_lod level;
      assert_int_equal(scree_pack_get_lod(pack, i, lod, &level), SCREE_OK);
      scree_vertex* vertices = malloc(level.vertices * sizeof *vertices);
      const size_t index_count = 3 * (size_t)level.triangles;
      uint32_t* indices = malloc(index_count * sizeof *indices);
      assert_int_equal(scree_draco_decode_u32(pack, i, lod, vertices, level.vertices, indices, index_count), SCREE_OK);
      assert_true(scree_model_mesh_digest(vertices, level.vertices, indices, level.triangles) == level.digest);
      assert_true(scree_mesh_digest(vertices, level.vertices, indices, level.triangles) != level.digest);
      for (uint32_t v = 0; v < level.vertices; ++v) {
        const scree_vertex* vertex = &vertices[v];
        assert_int_equal(vertex->material & 15, vertex->position[1] < 4);
        assert_int_equal(vertex->material >> 4, vertex->position[1] / 8 & 15);
        assert_int_equal(vertex->durability, 128 + vertex->position[0]);
        assert_int_equal(vertex->curvature, vertex->position[2]);
        colluvium |= (vertex->material & 15) == 1;
        bed |= vertex->material > 15;
        hollow |= vertex->curvature < 0;
        edge |= vertex->curvature > 0;
      }
      free(indices);
      free(vertices);
    }
  assert_true(colluvium && bed && hollow && edge);
  scree_pack_close(pack);
  free(bytes);
}

static void digest_of_a_model_is_what_the_format_says_and_sees_its_surface(void** state) {
  (void)state;
  scree_vertex v[4] = {{.occlusion = 0, .durability = 64},
                       {{10, 0, 0}, 85, 16, {0}, 0, -127},
                       {{0, 10, 0}, 170, 33, {0}, 255, 127},
                       {{0, 0, 10}, 255, 1, {0}, 128, -28}};
  const uint32_t indices[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  assert_true(scree_model_mesh_digest(v, 4, indices, 4) == UINT64_C(0x90d6656ee2bd09da));
  assert_true(scree_mesh_digest(v, 4, indices, 4) == UINT64_C(0x87865a563ad6a90a));
  v[3].curvature = -27;
  assert_true(scree_model_mesh_digest(v, 4, indices, 4) != UINT64_C(0x90d6656ee2bd09da));
  v[3].curvature = -28;
  v[0].material = 1;
  assert_true(scree_model_mesh_digest(v, 4, indices, 4) != UINT64_C(0x90d6656ee2bd09da));
  v[0].material = 0;
  v[2].durability = 254;
  assert_true(scree_model_mesh_digest(v, 4, indices, 4) != UINT64_C(0x90d6656ee2bd09da));
  assert_true(scree_model_mesh_digest(v, 3, indices, 4) == 0);
}

static void a_field_needs_tiles_and_a_model_needs_models(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_model_pack_make(NULL, &size);
  scree_pack* pack = open_or_fail(bytes, size);
  const scree_field_desc desc = {.pack = pack, .cell_size = 1};
  scree_field* field;
  assert_int_equal(scree_field_create(&desc, NULL, &field), SCREE_ERROR_PACK_KIND);
  assert_null(field);
  uint32_t value;
  assert_int_equal(scree_pack_tile_cell(pack, 0, 0, 0, 0, &value), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_proxy(pack, 0, 0), UINT32_MAX);
  scree_model model;
  assert_int_equal(scree_pack_get_model(NULL, 0, &model), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_get_model(pack, 0, NULL), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_get_model(pack, 1000, &model), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_get_part(pack, 0, 0, NULL, 1, &value), SCREE_ERROR_INVALID_ARGUMENT);
  scree_pack_close(pack);
  free(bytes);

  bytes = test_pack_make(NULL, &size);
  pack = open_or_fail(bytes, size);
  assert_int_equal(scree_pack_get_model(pack, 0, &model), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_get_part(pack, 0, 0, NULL, 0, &value), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_model(pack, 0, 0), UINT32_MAX);
  scree_pack_section section;
  assert_int_equal(scree_pack_get_section(pack, 8, &section), SCREE_OK);
  assert_int_equal(scree_pack_get_section(pack, 9, &section), SCREE_ERROR_INVALID_ARGUMENT);
  scree_pack_close(pack);
  free(bytes);
}

/* Everything that a pack of models offers; that the calls return is what counts. */
static void walk(const scree_pack* pack) {
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  for (uint32_t i = 0; i < info.asset_count; ++i) {
    scree_asset asset;
    scree_model model = {0};
    int16_t hull[PACK_MAX_HULL][3];
    uint32_t count;
    scree_pack_get_asset(pack, i, &asset);
    scree_pack_get_hull(pack, i, hull[0], PACK_MAX_HULL, &count);
    if (scree_pack_get_model(pack, i, &model) == SCREE_OK)
      for (uint32_t p = 0; p < model.part_count; ++p) scree_pack_get_part(pack, i, p, hull[0], PACK_MAX_HULL, &count);
    static scree_vertex vertices[4096];
    static uint16_t indices[3 * 8192];
    for (uint32_t lod = 0; lod < info.lod_count; ++lod) scree_draco_decode_u16(pack, i, lod, vertices, 4096, indices, 3 * 8192);
  }
  for (uint32_t variant = 0; variant < info.variant_count && variant < 100; ++variant) scree_pack_model(pack, variant, 0);
}

static void every_flipped_byte_is_found_by_open_or_verify(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_model_pack_make(&(test_models_desc){.variants = 1, .lod_count = 1}, &size);
  for (size_t i = 0; i < size; ++i) {
    bytes[i] ^= 1;
    scree_pack* pack;
    if (scree_pack_open_memory(bytes, size, NULL, &pack) == SCREE_OK) {
      walk(pack);
      assert_int_equal(scree_pack_verify(pack), SCREE_ERROR_DIGEST);
      scree_pack_close(pack);
    }
    bytes[i] ^= 1;
  }
  free(bytes);
}

static void changed_bytes_with_digests_to_match_never_crash_a_reader(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_model_pack_make(&(test_models_desc){.variants = 1}, &size);
  uint8_t* changed = malloc(size);
  uint64_t random = 7;
  uint32_t opened = 0, refused = 0;
  for (size_t i = 0; i < size; i += i < 2048 ? 1 : 7)
    for (int turn = 0; turn < 2; ++turn) {
      memcpy(changed, bytes, size);
      changed[i] = turn == 0 ? 0xff : (uint8_t)(random = hash_mix(random + 1));
      if (i < sizeof(pack_header) && i >= 12 && i < 24) continue; /* counts that the sealing itself goes by */
      test_pack_reseal(changed);
      scree_pack* pack;
      if (scree_pack_open_memory(changed, size, NULL, &pack) != SCREE_OK) {
        ++refused;
        continue;
      }
      ++opened;
      walk(pack);
      scree_pack_verify(pack);
      scree_pack_close(pack);
    }
  assert_true(opened > 1000 && refused > 50);
  free(changed);
  free(bytes);
}

#define RECORD(type, kind) ((type*)(void*)(bytes + section_of(bytes, kind)->offset))
/* Changes a number of a fresh pack and says what opening, or else verifying, makes of it. */
#define BAD(change)                                                         \
  do {                                                                      \
    size_t size;                                                            \
    uint8_t* bytes = test_model_pack_make(&several, &size);                 \
    change;                                                                 \
    test_pack_reseal(bytes);                                                \
    scree_pack* pack;                                                       \
    scree_result result = scree_pack_open_memory(bytes, size, NULL, &pack); \
    if (result == SCREE_OK) result = scree_pack_verify(pack);               \
    assert_int_equal(result, SCREE_ERROR_CORRUPT);                          \
    scree_pack_close(pack);                                                 \
    free(bytes);                                                            \
  } while (0)

static void numbers_that_cannot_be_are_corrupt(void** state) {
  (void)state;
  BAD(header_of(bytes)->kind = 2);
  BAD(header_of(bytes)->kind = 3);
  BAD(header_of(bytes)->kind = SCREE_PACK_TILES);
  BAD(header_of(bytes)->reserved = 1);
  BAD(header_of(bytes)->cells_per_cube = 1);
  BAD(header_of(bytes)->proxy_per_cell = 1);
  BAD(header_of(bytes)->max_radius = 5000);
  BAD(header_of(bytes)->section_count = 9);
  BAD(section_of(bytes, PACK_MODELS)->kind = 99);
  BAD(RECORD(pack_asset, PACK_ASSETS)->burial = 3);
  BAD(RECORD(pack_asset, PACK_ASSETS)->contact_count = 1);
  BAD(RECORD(pack_asset, PACK_ASSETS)[1].seed = 2);
  BAD(RECORD(pack_asset, PACK_ASSETS)->centroid[1] = 5000);
  BAD(RECORD(pack_model, PACK_MODELS)->footprint = -1);
  BAD(RECORD(pack_model, PACK_MODELS)[2].height = (float)(0.0 / (double)header_of(bytes)->reserved));
  BAD(RECORD(pack_model, PACK_MODELS)->share = 1.5f);
  BAD(RECORD(pack_model, PACK_MODELS)->part_count = 0);
  BAD(RECORD(pack_model, PACK_MODELS)->part_count = 256);
  BAD(RECORD(pack_model, PACK_MODELS)->first_part = 11);
  BAD(RECORD(uint32_t, PACK_PARTS)[1] = 2);
  BAD(RECORD(uint32_t, PACK_PARTS)[12] = 100000);
  BAD(RECORD(uint32_t, PACK_CELLS)[1] = 0);
  BAD((RECORD(pack_lod, PACK_LODS)->triangles = 21850, RECORD(pack_blob, PACK_BLOB_INDEX)->vertices = 65537));
  BAD(RECORD(pack_lod, PACK_LODS)->error = 4097);
}

/* The surface of the first vertex of the last level, which is plain. */
static uint8_t* surface_in(uint8_t* bytes) {
  const pack_blob* blob = RECORD(pack_blob, PACK_BLOB_INDEX) + 2;
  uint8_t* plain = bytes + section_of(bytes, PACK_BLOBS)->offset + blob->offset * (size_t)PACK_BLOB_UNIT;
  return plain + 8 + (size_t)blob->vertices * (3u * plain[6] + 1);
}

static void surfaces_that_cannot_be_are_corrupt(void** state) {
  (void)state;
  BAD(surface_in(bytes)[0] = 2);
  BAD(surface_in(bytes)[2] = 0);
  BAD(surface_in(bytes)[3] = 1);
}

#define UNWRITABLE(place, value, expected)                              \
  do {                                                                  \
    rock_set* set = test_model_set_make(&several);                      \
    rock_record* rocks = (rock_record*)set->rocks;                      \
    model_record* models = (model_record*)set->models;                  \
    (void)rocks;                                                        \
    (void)models;                                                       \
    const __typeof__(place) before = (place);                           \
    (place) = (value);                                                  \
    uint8_t* bytes;                                                     \
    size_t size;                                                        \
    assert_int_equal(pack_write(set, NULL, &bytes, &size), (expected)); \
    assert_null(bytes);                                                 \
    (place) = before;                                                   \
    test_model_set_free(set);                                           \
  } while (0)

static void sets_that_break_a_rule_are_not_written(void** state) {
  (void)state;
  UNWRITABLE(set->cells_per_cube, 1, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(set->cell_count, 0, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(rocks[1].seed, 2, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(rocks[0].burial, 1, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(rocks[0].outer_radius, 4097, SCREE_ERROR_RANGE);
  UNWRITABLE(rocks[0].lods[0].vertex_count, 65537, SCREE_ERROR_RANGE);
  UNWRITABLE(models[5].footprint, -1, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(models[5].height, 1e9f, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(models[5].share, 2, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(models[5].part_count, 0, SCREE_ERROR_RANGE);
  UNWRITABLE(models[5].part_count, 256, SCREE_ERROR_RANGE);
  UNWRITABLE(models[5].part_first[1], 2, SCREE_ERROR_INVALID_ARGUMENT);
}

static void writing_survives_every_failing_allocation(void** state) {
  (void)state;
  rock_set* set = test_model_set_make(&several);
  scree_result result = SCREE_ERROR_OUT_OF_MEMORY;
  for (int32_t n = 0; result != SCREE_OK; ++n) {
    assert_in_range(n, 0, 20);
    failing_allocator memory = {.fail_at = n};
    const scree_allocator allocator = failing_allocator_of(&memory);
    uint8_t* bytes;
    size_t size;
    result = pack_write(set, &allocator, &bytes, &size);
    if (result == SCREE_OK) allocator.release(allocator.user, bytes, size);
    assert_true(memory.live == 0 && (result == SCREE_ERROR_OUT_OF_MEMORY) == memory.failed);
  }
  test_model_set_free(set);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_is_written_is_what_is_read),
      cmocka_unit_test(surfaces_come_back_from_both_codecs),
      cmocka_unit_test(digest_of_a_model_is_what_the_format_says_and_sees_its_surface),
      cmocka_unit_test(a_field_needs_tiles_and_a_model_needs_models),
      cmocka_unit_test(every_flipped_byte_is_found_by_open_or_verify),
      cmocka_unit_test(changed_bytes_with_digests_to_match_never_crash_a_reader),
      cmocka_unit_test(numbers_that_cannot_be_are_corrupt),
      cmocka_unit_test(surfaces_that_cannot_be_are_corrupt),
      cmocka_unit_test(sets_that_break_a_rule_are_not_written),
      cmocka_unit_test(writing_survives_every_failing_allocation),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
