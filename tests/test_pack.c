/* The pack: what is written is what is read; bad bytes give a result code, never a crash. */
#include <scree/pack.h>

#include "allocator.h"
#include "failing_allocator.h"
#include "lattice.h"
#include "make_pack.h"
#include "pack_bytes.h"
#include "pack_format.h"
#include "pack_writer.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void what_is_written_is_what_is_read(void** state) {
  (void)state;
  const test_pack_desc desc = {.cells_per_cube = 3, .rocks_per_cell = 3, .lod_count = 3};
  rock_set* set = test_rock_set_make(&desc);
  uint8_t* bytes;
  size_t size;
  assert_int_equal(pack_write(set, NULL, &bytes, &size), SCREE_OK);
  scree_pack* pack = open_or_fail(bytes, size);
  assert_int_equal(scree_pack_verify(pack), SCREE_OK);

  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  assert_int_equal(info.format_version, PACK_FORMAT_VERSION);
  assert_int_equal(info.cells_per_cube, 3);
  assert_int_equal(info.lattice_per_cell, set->lattice_per_cell);
  assert_int_equal(info.cell_count, 2266);
  assert_int_equal(info.asset_count, set->rock_count);
  assert_int_equal(info.lod_count, 3);
  assert_int_equal(info.proxy_count + info.proxy_per_cell, 0);
  assert_int_equal(scree_pack_proxy(pack, 0, 0), UINT32_MAX);
  assert_int_equal(info.max_rocks_per_cell, 3);
  assert_string_equal(info.recipe, set->recipe);
  assert_int_equal(info.recipe_size, strlen(set->recipe));
  assert_int_equal(info.file_size, size);

  float max_radius = 0;
  for (uint32_t i = 0; i < set->rock_count; ++i) {
    const rock_record* rock = &set->rocks[i];
    scree_asset asset;
    assert_int_equal(scree_pack_get_asset(pack, i, &asset), SCREE_OK);
    assert_int_equal(asset.cell, rock->cell);
    assert_int_equal(asset.seed, rock->seed);
    assert_int_equal(asset.burial, rock->burial);
    assert_true(asset.volume == rock->volume && asset.inner_radius == rock->inner_radius);
    assert_true(asset.outer_radius == rock->outer_radius);
    if (rock->outer_radius > max_radius) max_radius = rock->outer_radius;
    for (int axis = 0; axis < 3; ++axis) {
      assert_true(asset.centroid[axis] == rock->centroid[axis]);
      assert_true(asset.bounds_min[axis] == (float)rock->bounds_min[axis] / (float)set->lattice_per_cell);
      assert_true(asset.bounds_max[axis] == (float)rock->bounds_max[axis] / (float)set->lattice_per_cell);
    }

    scree_contact contacts[32];
    uint32_t count;
    assert_int_equal(scree_pack_get_contacts(pack, i, contacts, 32, &count), SCREE_OK);
    assert_int_equal(count, rock->contact_count);
    assert_int_equal(asset.contact_count, count);
    assert_memory_equal(contacts, rock->contacts, count * sizeof *contacts);

    int16_t hull[PACK_MAX_HULL][3];
    assert_int_equal(scree_pack_get_hull(pack, i, hull[0], PACK_MAX_HULL, &count), SCREE_OK);
    assert_int_equal(count, rock->hull_count);
    assert_int_equal(asset.hull_vertices, count);
    assert_memory_equal(hull, rock->hull, count * sizeof *hull);

    for (uint32_t lod = 0; lod < 3; ++lod) {
      scree_lod level;
      assert_int_equal(scree_pack_get_lod(pack, i, lod, &level), SCREE_OK);
      assert_int_equal(level.vertices, rock->lods[lod].vertex_count);
      assert_int_equal(level.triangles, rock->lods[lod].triangle_count);
      assert_true(level.error == rock->lods[lod].error);
      assert_true(level.digest == rock->lods[lod].digest);
      assert_int_equal(level.blob_size, rock->lods[lod].blob_size);
      assert_memory_equal(level.blob, rock->lods[lod].blob, level.blob_size);
    }
  }
  assert_true(info.max_radius == max_radius);
  scree_pack_close(pack);
  free(bytes);
  test_rock_set_free(set);
}

static void tiles_name_the_cells_of_the_lattice_and_cells_their_rocks(void** state) {
  (void)state;
  const test_pack_desc desc = {.cells_per_cube = 3, .rocks_per_cell = 2};
  size_t size;
  uint8_t* bytes = test_pack_make(&desc, &size);
  scree_pack* pack = open_or_fail(bytes, size);
  for (uint32_t code = 0; code < 256; ++code)
    for (uint32_t place = 0; place < 27; ++place) {
      uint32_t cell;
      assert_int_equal(scree_pack_tile_cell(pack, code, place % 3, place / 3 % 3, place / 9, &cell), SCREE_OK);
      assert_int_equal(cell, scree_rt_lattice_cell(3, code, place % 3, place / 3 % 3, place / 9));
    }
  uint32_t next = 0;
  for (uint32_t cell = 0; cell < 2266; ++cell) {
    uint32_t first, count;
    assert_int_equal(scree_pack_cell_assets(pack, cell, &first, &count), SCREE_OK);
    assert_int_equal(first, next);
    assert_int_equal(count, 1 + cell % 2);
    next = first + count;
  }
  scree_pack_close(pack);
  free(bytes);
}

static void the_same_set_gives_the_same_bytes(void** state) {
  (void)state;
  size_t sizes[2];
  uint8_t* packs[2] = {test_pack_make(NULL, &sizes[0]), test_pack_make(NULL, &sizes[1])};
  assert_int_equal(sizes[0], sizes[1]);
  assert_memory_equal(packs[0], packs[1], sizes[0]);
  free(packs[0]);
  free(packs[1]);
}

static void pack_digest_is_of_what_was_baked_and_not_of_how_it_was_encoded(void** state) {
  (void)state;
  rock_set* set = test_rock_set_make(NULL);
  uint64_t digests[3];
  for (int turn = 0; turn < 3; ++turn) {
    rock_record* rock = (rock_record*)set->rocks;
    if (turn == 1) rock->lods[0].blob[rock->lods[0].blob_size - 1] ^= 1; /* another encoder's bytes */
    if (turn == 2) rock->lods[0].digest ^= 1;                            /* another mesh */
    uint8_t* bytes;
    size_t size;
    assert_int_equal(pack_write(set, NULL, &bytes, &size), SCREE_OK);
    digests[turn] = header_of(bytes)->pack_digest;
    free(bytes);
  }
  assert_true(digests[0] == digests[1]);
  assert_true(digests[0] != digests[2]);
  test_rock_set_free(set);
}

/* Reads everything that a pack offers. Returns the number of calls that succeeded; that they return is what counts. */
static uint32_t walk(const scree_pack* pack) {
  uint32_t good = 0, value, count;
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  good += memchr(info.recipe, 0, info.recipe_size + 1) != NULL;
  for (uint32_t code = 0; code < 256; ++code) {
    const uint32_t last = info.cells_per_cube - 1;
    good += scree_pack_tile_cell(pack, code, 0, 0, 0, &value) == SCREE_OK;
    good += scree_pack_tile_cell(pack, code, last, last, last, &value) == SCREE_OK;
  }
  for (uint32_t cell = 0; cell < info.cell_count; ++cell) good += scree_pack_cell_assets(pack, cell, &value, &count) == SCREE_OK;
  for (uint32_t asset = 0; asset < info.asset_count; ++asset) {
    scree_asset record;
    scree_contact contacts[64];
    int16_t hull[PACK_MAX_HULL][3];
    good += scree_pack_get_asset(pack, asset, &record) == SCREE_OK;
    good += scree_pack_get_contacts(pack, asset, contacts, 64, &count) == SCREE_OK;
    good += scree_pack_get_hull(pack, asset, hull[0], PACK_MAX_HULL, &count) == SCREE_OK;
    for (uint32_t lod = 0; lod < info.lod_count; ++lod) {
      scree_lod level;
      if (scree_pack_get_lod(pack, asset, lod, &level) != SCREE_OK) continue;
      /* Reading the first and last byte is enough for a sanitizer to see a blob that lies outside. */
      if (level.blob_size > 0) good += 1 + (level.blob[0] + level.blob[level.blob_size - 1] > 1000);
    }
  }
  return good;
}

static void every_truncation_is_rejected(void** state) {
  (void)state;
  const test_pack_desc desc = {.lod_count = 1, .voxels_per_cell = 6};
  size_t size;
  uint8_t* bytes = test_pack_make(&desc, &size);
  for (size_t length = 0; length < size; ++length) {
    /* A buffer of exactly this size, so that a sanitizer sees a read past its end. */
    uint8_t* cut = malloc(length > 0 ? length : 1);
    assert_non_null(cut);
    memcpy(cut, bytes, length);
    scree_pack* pack = (scree_pack*)(void*)bytes;
    assert_int_equal(scree_pack_open_memory(cut, length, NULL, &pack), SCREE_ERROR_TRUNCATED);
    assert_null(pack);
    free(cut);
  }
  free(bytes);
}

static void every_truncation_with_a_header_to_match_is_rejected(void** state) {
  (void)state;
  const test_pack_desc desc = {.lod_count = 1, .voxels_per_cell = 6};
  size_t size;
  uint8_t* bytes = test_pack_make(&desc, &size);
  for (size_t length = sizeof(pack_header); length < size; ++length) {
    uint8_t* cut = malloc(length);
    assert_non_null(cut);
    memcpy(cut, bytes, length);
    header_of(cut)->file_size = length;
    header_of(cut)->header_check = scree_rt_pack_header_check(header_of(cut));
    scree_pack* pack;
    const scree_result result = scree_pack_open_memory(cut, length, NULL, &pack);
    assert_true(result == SCREE_ERROR_TRUNCATED || result == SCREE_ERROR_CORRUPT);
    free(cut);
  }
  free(bytes);
}

static void bytes_after_the_end_are_rejected(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_pack_make(NULL, &size);
  uint8_t* longer = calloc(1, size + 8);
  assert_non_null(longer);
  memcpy(longer, bytes, size);
  scree_pack* pack;
  assert_int_equal(scree_pack_open_memory(longer, size + 8, NULL, &pack), SCREE_ERROR_CORRUPT);
  free(longer);
  free(bytes);
}

static void every_flipped_byte_is_found_by_open_or_verify(void** state) {
  (void)state;
  const test_pack_desc desc = {.lod_count = 1, .voxels_per_cell = 6};
  size_t size;
  uint8_t* bytes = test_pack_make(&desc, &size);
  for (size_t i = 0; i < size; ++i)
    for (int bit = 0; bit < 8; bit += 7) {
      bytes[i] ^= (uint8_t)(1 << bit);
      scree_pack* pack;
      const scree_result opened = scree_pack_open_memory(bytes, size, NULL, &pack);
      if (opened == SCREE_OK) {
        walk(pack);
        assert_int_equal(scree_pack_verify(pack), SCREE_ERROR_DIGEST);
        scree_pack_close(pack);
      } else {
        /* Opening reads the header, the table and the few values that bound arrays. */
        assert_true(opened == SCREE_ERROR_DIGEST || opened == SCREE_ERROR_NOT_A_PACK || opened == SCREE_ERROR_VERSION ||
                    opened == SCREE_ERROR_CORRUPT);
      }
      bytes[i] ^= (uint8_t)(1 << bit);
    }
  scree_pack* pack = open_or_fail(bytes, size);
  assert_int_equal(scree_pack_verify(pack), SCREE_OK);
  scree_pack_close(pack);
  free(bytes);
}

static void flipped_bytes_with_digests_to_match_never_crash_a_reader(void** state) {
  (void)state;
  const test_pack_desc desc = {.lod_count = 1, .voxels_per_cell = 6};
  size_t size;
  uint8_t* bytes = test_pack_make(&desc, &size);
  uint8_t* changed = malloc(size);
  assert_non_null(changed);
  const size_t blobs = (size_t)section_of(bytes, PACK_BLOBS)->offset;
  uint64_t random = 7;
  uint32_t opened = 0;
  for (size_t i = sizeof(pack_header) + PACK_TILE_KINDS * sizeof(pack_section); i < blobs; ++i)
    for (int turn = 0; turn < 2; ++turn) {
      memcpy(changed, bytes, size);
      changed[i] = turn == 0 ? 0xff : (uint8_t)(random = hash_mix(random + 1));
      test_pack_reseal(changed);
      scree_pack* pack;
      if (scree_pack_open_memory(changed, size, NULL, &pack) != SCREE_OK) continue;
      ++opened;
      walk(pack);
      const scree_result verified = scree_pack_verify(pack);
      assert_true(verified == SCREE_OK || verified == SCREE_ERROR_CORRUPT || verified == SCREE_ERROR_DIGEST);
      scree_pack_close(pack);
    }
  assert_true(opened > 1000);
  free(changed);
  free(bytes);
}

static void random_headers_and_tables_never_crash_a_reader(void** state) {
  (void)state;
  const test_pack_desc desc = {.lod_count = 1, .voxels_per_cell = 6};
  size_t size;
  uint8_t* bytes = test_pack_make(&desc, &size);
  uint8_t* changed = malloc(size);
  assert_non_null(changed);
  static const uint64_t extremes[] = {0, 1, 63, 64, 0x7fffffff, 0x80000000, 0xffffffff, 0x7fffffffffffffff, 0xffffffffffffffff};
  uint64_t random = 11;
  for (int turn = 0; turn < 20000; ++turn) {
    memcpy(changed, bytes, size);
    random = hash_mix(random + 1);
    const size_t table = sizeof(pack_header) + PACK_TILE_KINDS * sizeof(pack_section);
    const size_t at = 12 + (random >> 8) % (table - 12 - 8) / 4 * 4;
    const uint64_t value = random & 1 ? extremes[(random >> 1) % 9] : random >> (random >> 1 & 31);
    memcpy(changed + at, &value, random & 2 ? 4 : 8);
    /* Re-seals by hand what can be sealed: the section count itself may be what was changed. */
    pack_header* header = header_of(changed);
    const uint64_t count = header->section_count < PACK_TILE_KINDS ? header->section_count : PACK_TILE_KINDS;
    header->table_digest = scree_rt_pack_bytes_digest(changed + sizeof *header, (size_t)count * sizeof(pack_section));
    const pack_section* sections[PACK_SECTION_KINDS];
    for (uint32_t i = 0; i < PACK_SECTION_KINDS; ++i) sections[i] = section_of(changed, i + 1);
    header->pack_digest = scree_rt_pack_digest(header, sections);
    header->header_check = scree_rt_pack_header_check(header);
    scree_pack* pack;
    if (scree_pack_open_memory(changed, size, NULL, &pack) != SCREE_OK) continue;
    walk(pack);
    scree_pack_verify(pack);
    scree_pack_close(pack);
  }
  free(changed);
  free(bytes);
}

static void other_magic_and_version_have_codes_of_their_own(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_pack_make(NULL, &size);
  scree_pack* pack;
  header_of(bytes)->format_version = PACK_FORMAT_VERSION + 1;
  assert_int_equal(open_resealed(bytes, size), SCREE_ERROR_VERSION);
  header_of(bytes)->format_version = PACK_FORMAT_VERSION - 1;
  assert_int_equal(open_resealed(bytes, size), SCREE_ERROR_VERSION);
  header_of(bytes)->format_version = 0;
  assert_int_equal(open_resealed(bytes, size), SCREE_ERROR_VERSION);
  bytes[0] = 'S';
  assert_int_equal(scree_pack_open_memory(bytes, size, NULL, &pack), SCREE_ERROR_NOT_A_PACK);
  const uint64_t other = UINT64_C(0x46546c67); /* "glTF" */
  assert_int_equal(scree_pack_open_memory(&other, 4, NULL, &pack), SCREE_ERROR_NOT_A_PACK);
  assert_int_equal(scree_pack_open_memory(NULL, 0, NULL, &pack), SCREE_ERROR_TRUNCATED);
  free(bytes);
}

static void sections_past_the_end_misplaced_doubled_or_missing_are_rejected(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_pack_make(NULL, &size);
  const pack_section kept = *section_of(bytes, PACK_BLOBS);
  pack_section* blobs = section_of(bytes, PACK_BLOBS);
  static const struct {
    int64_t offset, size;
  } moves[] = {{0, 1}, {0, INT64_MAX}, {64, 0}, {64, -64}, {-64, 64}, {8, -8}, {1, -1}, {INT64_MAX - 63, 0}, {0, -1}, {0, -64}};
  for (size_t i = 0; i < sizeof moves / sizeof moves[0]; ++i) {
    *blobs = kept;
    blobs->offset += (uint64_t)moves[i].offset;
    blobs->size += (uint64_t)moves[i].size;
    assert_int_equal(open_resealed(bytes, size), SCREE_ERROR_CORRUPT);
  }
  *blobs = kept;
  blobs->offset = UINT64_MAX - 63;
  blobs->size = 128;
  header_of(bytes)->file_size = size;
  /* Sealed by hand: this section wraps around, and a helper that hashed it would read outside. */
  header_of(bytes)->table_digest = scree_rt_pack_bytes_digest(section_of(bytes, 1), PACK_TILE_KINDS * sizeof(pack_section));
  header_of(bytes)->header_check = scree_rt_pack_header_check(header_of(bytes));
  scree_pack* pack;
  assert_int_equal(scree_pack_open_memory(bytes, size, NULL, &pack), SCREE_ERROR_CORRUPT);

  *blobs = kept;
  blobs->kind = PACK_HULLS;
  blobs->element_size = 3;
  header_of(bytes)->table_digest = scree_rt_pack_bytes_digest(section_of(bytes, 1), PACK_TILE_KINDS * sizeof(pack_section));
  header_of(bytes)->header_check = scree_rt_pack_header_check(header_of(bytes));
  assert_int_equal(scree_pack_open_memory(bytes, size, NULL, &pack), SCREE_ERROR_CORRUPT);
  *blobs = kept;
  blobs->kind = 77;
  header_of(bytes)->table_digest = scree_rt_pack_bytes_digest(section_of(bytes, 1), PACK_TILE_KINDS * sizeof(pack_section));
  header_of(bytes)->header_check = scree_rt_pack_header_check(header_of(bytes));
  assert_int_equal(scree_pack_open_memory(bytes, size, NULL, &pack), SCREE_ERROR_CORRUPT);
  free(bytes);
}

/* Each change of one number of a good pack, with the accessor that must refuse it. */
static void records_that_cannot_be_are_refused_where_they_are_read(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_pack_make(NULL, &size);
  pack_asset* asset = data_of(bytes, PACK_ASSETS);
  pack_lod* lod = data_of(bytes, PACK_LODS);
  pack_blob* blob = data_of(bytes, PACK_BLOB_INDEX);
  pack_narrow_contact* contact = data_of(bytes, PACK_CONTACTS);
  uint32_t* tiles = data_of(bytes, PACK_TILES);
  uint32_t* cells = data_of(bytes, PACK_CELLS);
  const uint32_t contacts = (uint32_t)(section_of(bytes, PACK_CONTACTS)->size / sizeof *contact);
  const uint32_t hull_vertices = (uint32_t)(section_of(bytes, PACK_HULLS)->size / 3);
  const uint32_t blob_units = (uint32_t)(section_of(bytes, PACK_BLOBS)->size / PACK_BLOB_UNIT);
  scree_pack* pack = open_or_fail(bytes, size);
  scree_asset a;
  scree_lod l;
  scree_contact c[64];
  int16_t h[PACK_MAX_HULL][3];
  uint32_t x, y;

  REFUSED(asset->cell, 2, scree_pack_get_asset(pack, 0, &a));
  REFUSED(asset->seed, 1, scree_pack_get_asset(pack, 0, &a));
  REFUSED(asset->volume, -1.0f, scree_pack_get_asset(pack, 0, &a));
  REFUSED(asset->volume, 0.0f / (asset->volume - asset->volume), scree_pack_get_asset(pack, 0, &a));
  REFUSED(asset->outer_radius, 17.0f, scree_pack_get_asset(pack, 0, &a));
  REFUSED(asset->inner_radius, asset->outer_radius * 2, scree_pack_get_asset(pack, 0, &a));
  REFUSED(asset->centroid[1], 1e9f, scree_pack_get_asset(pack, 0, &a));
  REFUSED(asset->bounds_min[2], INT16_MAX, scree_pack_get_asset(pack, 0, &a));
  REFUSED(asset->hull_count, 3, scree_pack_get_asset(pack, 0, &a));
  REFUSED(asset->hull_count, 65, scree_pack_get_asset(pack, 0, &a));
  REFUSED(asset->first_contact, contacts, scree_pack_get_contacts(pack, 0, c, 64, &x));
  REFUSED(asset->first_contact, UINT32_MAX, scree_pack_get_contacts(pack, 0, c, 64, &x));
  REFUSED(asset->first_contact, UINT32_MAX, scree_pack_get_asset(pack, 0, &a));
  REFUSED(asset->contact_count, UINT8_MAX, scree_pack_get_contacts(pack, 0, c, 64, &x));
  REFUSED(asset->burial, 0, scree_pack_get_asset(pack, 0, &a));
  REFUSED(asset->burial, SCREE_BURIAL_NEVER + 1, scree_pack_get_asset(pack, 0, &a));
  REFUSED(lod->triangles, 0, scree_pack_get_lod(pack, 0, 0, &l));
  REFUSED(asset->first_hull, hull_vertices - 3, scree_pack_get_hull(pack, 0, h[0], PACK_MAX_HULL, &x));
  REFUSED(asset->first_hull, UINT32_MAX, scree_pack_get_asset(pack, 0, &a));
  REFUSED(contact->neighbour, PACK_NEIGHBOURS, scree_pack_get_contacts(pack, 0, c, 64, &x));
  REFUSED(contact->seed, 1, scree_pack_get_contacts(pack, 0, c, 64, &x));
  REFUSED(lod->triangles, UINT32_MAX, scree_pack_get_lod(pack, 0, 0, &l));
  REFUSED(lod->error, -1.0f, scree_pack_get_lod(pack, 0, 0, &l));
  REFUSED(blob->vertices, 3 * lod->triangles + 1, scree_pack_get_lod(pack, 0, 0, &l));
  REFUSED(blob->offset, blob_units, scree_pack_get_lod(pack, 0, 0, &l));
  REFUSED(blob->offset, UINT32_MAX, scree_pack_get_lod(pack, 0, 0, &l));
  REFUSED(blob->size, UINT32_MAX, scree_pack_get_lod(pack, 0, 0, &l));
  REFUSED(tiles[0], 2, scree_pack_tile_cell(pack, 0, 0, 0, 0, &x));
  REFUSED(cells[1], 3, scree_pack_cell_assets(pack, 0, &x, &y));
  REFUSED(cells[1], UINT32_MAX, scree_pack_cell_assets(pack, 1, &x, &y));
  scree_pack_close(pack);
  free(bytes);
}

static void arguments_out_of_range_and_short_buffers_have_codes(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_pack_make(NULL, &size);
  scree_pack* pack = open_or_fail(bytes, size);
  scree_asset a;
  scree_lod l;
  scree_contact c[2];
  int16_t h[1][3];
  uint32_t x, y;
  assert_int_equal(scree_pack_get_asset(pack, 2, &a), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_get_lod(pack, 0, 2, &l), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_get_lod(pack, 2, 0, &l), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_tile_cell(pack, 256, 0, 0, 0, &x), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_tile_cell(pack, 0, 1, 0, 0, &x), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_cell_assets(pack, 2, &x, &y), SCREE_ERROR_INVALID_ARGUMENT);
  assert_int_equal(scree_pack_get_asset(pack, 0, &a), SCREE_OK);
  assert_int_equal(scree_pack_get_contacts(pack, 0, NULL, 0, &x), SCREE_ERROR_CAPACITY);
  assert_int_equal(x, a.contact_count);
  assert_int_equal(scree_pack_get_contacts(pack, 0, c, 2, &x), SCREE_ERROR_CAPACITY);
  assert_int_equal(x, a.contact_count);
  assert_int_equal(scree_pack_get_hull(pack, 0, h[0], 1, &x), SCREE_ERROR_CAPACITY);
  assert_int_equal(x, a.hull_vertices);
  scree_pack* second;
  assert_int_equal(scree_pack_open_memory(bytes + 4, size - 4, NULL, &second), SCREE_ERROR_INVALID_ARGUMENT);
  assert_null(second);
  scree_pack_close(pack);
  scree_pack_close(NULL);
  free(bytes);
}

static void a_file_opens_as_memory_does(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_pack_make(NULL, &size);
  const char* path = "test_pack_file.scree";
  FILE* file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(bytes, 1, size, file), size);
  fclose(file);
  scree_pack* pack;
  assert_int_equal(scree_pack_open_file(path, NULL, &pack), SCREE_OK);
  assert_int_equal(scree_pack_verify(pack), SCREE_OK);
  scree_pack_close(pack);
  file = fopen(path, "wb");
  assert_non_null(file);
  fclose(file);
  assert_int_equal(scree_pack_open_file(path, NULL, &pack), SCREE_ERROR_TRUNCATED);
  remove(path);
  assert_int_equal(scree_pack_open_file(path, NULL, &pack), SCREE_ERROR_IO);
  assert_null(pack);
  assert_int_equal(scree_pack_open_file(".", NULL, &pack), SCREE_ERROR_IO);
  free(bytes);
}

static void every_failed_allocation_of_open_and_write_is_reported(void** state) {
  (void)state;
  rock_set* set = test_rock_set_make(NULL);
  for (int32_t n = 0;; ++n) {
    assert_true(n < 10);
    failing_allocator memory = {.fail_at = n};
    const scree_allocator allocator = failing_allocator_of(&memory);
    uint8_t* bytes;
    size_t size;
    scree_result result = pack_write(set, &allocator, &bytes, &size);
    if (result == SCREE_OK) {
      scree_pack* pack;
      result = scree_pack_open_memory(bytes, size, &allocator, &pack);
      scree_pack_close(pack);
      scree_rt_release(&allocator, bytes, size, 1);
    } else {
      assert_null(bytes);
    }
    assert_int_equal(memory.live, 0);
    if (result == SCREE_OK) break;
    assert_int_equal(result, SCREE_ERROR_OUT_OF_MEMORY);
  }
  test_rock_set_free(set);
}

/* An allocator that writes down what was asked for. */
typedef struct ledger {
  size_t sizes[16];
  uint32_t count;
} ledger;

static void* ledger_alloc(void* user, size_t size) {
  ledger* book = user;
  assert_true(book->count < 16);
  book->sizes[book->count++] = size;
  return malloc(size);
}

static void ledger_release(void* user, void* memory, size_t size) {
  (void)user;
  (void)size;
  free(memory);
}

static void opening_allocates_the_same_whatever_the_number_of_assets(void** state) {
  (void)state;
  const test_pack_desc descs[3] = {
      {.rocks_per_cell = 2}, {.rocks_per_cell = 2, .lod_count = 1}, {.cells_per_cube = 3, .proxies = true}};
  ledger first = {{0}, 0};
  uint32_t assets[3];
  for (int i = 0; i < 3; ++i) {
    size_t size;
    uint8_t* bytes = test_pack_make(&descs[i], &size);
    ledger book = {{0}, 0};
    const scree_allocator allocator = {ledger_alloc, ledger_release, &book};
    scree_pack* pack;
    assert_int_equal(scree_pack_open_memory(bytes, size, &allocator, &pack), SCREE_OK);
    scree_pack_info info;
    scree_pack_get_info(pack, &info);
    assets[i] = info.asset_count;
    if (i == 0) first = book;
    assert_int_equal(book.count, first.count);
    assert_memory_equal(book.sizes, first.sizes, sizeof first.sizes);
    scree_pack_close(pack);
    free(bytes);
  }
  assert_true(first.count > 0 && assets[2] > 30 * assets[0]);
}

static void the_writer_refuses_sets_that_break_the_format(void** state) {
  (void)state;
  const test_pack_desc desc = {.rocks_per_cell = 2}; /* rocks 1 and 2 are of one cell */
  rock_set* set = test_rock_set_make(&desc);
  rock_record* rock = (rock_record*)set->rocks;
  uint8_t* bytes;
  size_t size;
#define UNWRITABLE(field, value, code)                            \
  do {                                                            \
    const __typeof__(field) saved = field;                        \
    field = value;                                                \
    assert_int_equal(pack_write(set, NULL, &bytes, &size), code); \
    assert_null(bytes);                                           \
    field = saved;                                                \
  } while (0)
  UNWRITABLE(rock->hull_count, 3, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(rock->hull_count, 65, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(rock->cell, 1, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(rock->seed, PACK_MAX_ROCKS_PER_CELL, SCREE_ERROR_RANGE);
  UNWRITABLE(rock[2].seed, rock[1].seed, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(rock->contact_count, UINT8_MAX + 1, SCREE_ERROR_RANGE);
  UNWRITABLE(rock->burial, 0, SCREE_ERROR_RANGE);
  UNWRITABLE(rock->burial, SCREE_BURIAL_NEVER + 1, SCREE_ERROR_RANGE);
  UNWRITABLE(rock->lods[0].triangle_count, 0, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(set->proxy_per_cell, 20, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(rock->outer_radius, 0, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(rock->lods[0].triangle_count, UINT32_MAX, SCREE_ERROR_RANGE);
  UNWRITABLE(set->cells_per_cube, 0, SCREE_ERROR_RANGE);
  UNWRITABLE(set->cells_per_cube, 2, SCREE_ERROR_INVALID_ARGUMENT);
  UNWRITABLE(set->lod_count, 0, SCREE_ERROR_RANGE);
  UNWRITABLE(set->lattice_per_cell, PACK_MAX_LATTICE_PER_CELL + 1, SCREE_ERROR_RANGE);
  UNWRITABLE(set->rock_count, 1, SCREE_ERROR_INVALID_ARGUMENT);
  test_rock_set_free(set);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_is_written_is_what_is_read),
      cmocka_unit_test(tiles_name_the_cells_of_the_lattice_and_cells_their_rocks),
      cmocka_unit_test(the_same_set_gives_the_same_bytes),
      cmocka_unit_test(pack_digest_is_of_what_was_baked_and_not_of_how_it_was_encoded),
      cmocka_unit_test(every_truncation_is_rejected),
      cmocka_unit_test(every_truncation_with_a_header_to_match_is_rejected),
      cmocka_unit_test(bytes_after_the_end_are_rejected),
      cmocka_unit_test(every_flipped_byte_is_found_by_open_or_verify),
      cmocka_unit_test(flipped_bytes_with_digests_to_match_never_crash_a_reader),
      cmocka_unit_test(random_headers_and_tables_never_crash_a_reader),
      cmocka_unit_test(other_magic_and_version_have_codes_of_their_own),
      cmocka_unit_test(sections_past_the_end_misplaced_doubled_or_missing_are_rejected),
      cmocka_unit_test(records_that_cannot_be_are_refused_where_they_are_read),
      cmocka_unit_test(arguments_out_of_range_and_short_buffers_have_codes),
      cmocka_unit_test(a_file_opens_as_memory_does),
      cmocka_unit_test(every_failed_allocation_of_open_and_write_is_reported),
      cmocka_unit_test(opening_allocates_the_same_whatever_the_number_of_assets),
      cmocka_unit_test(the_writer_refuses_sets_that_break_the_format),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
