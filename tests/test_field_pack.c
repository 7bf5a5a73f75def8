/* From a pack to a field: the same tables as by hand, and packs that no field can be made of. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "field_tables.h"
#include "make_pack.h"

static void field_of_a_pack_has_the_rocks_of_the_pack(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_pack_make(&(test_pack_desc){.cells_per_cube = 3, .rocks_per_cell = 2}, &size);
  scree_pack* pack;
  assert_int_equal(scree_pack_open_memory(bytes, size, NULL, &pack), SCREE_OK);
  const scree_field_desc desc = {.pack = pack, .seed = 5, .cell_size = 2};
  scree_field* field;
  assert_int_equal(scree_field_create(&desc, NULL, &field), SCREE_OK);
  for (uint32_t code = 0; code < 256; ++code) {
    const field_tile* tile = &field->tiles[code];
    tile_slots slots = field_slots(field, tile);
    uint32_t rocks = 0;
    for (uint32_t cell = 0; cell < 27; ++cell) {
      uint32_t unique, first, count;
      assert_int_equal(scree_pack_tile_cell(pack, code, cell % 3, cell / 3 % 3, cell / 9, &unique), SCREE_OK);
      assert_int_equal(scree_pack_cell_assets(pack, unique, &first, &count), SCREE_OK);
      rocks += count;
    }
    assert_int_equal(tile->block_first[FIELD_BLOCKS], rocks);
    for (uint32_t i = 0; i < rocks; ++i) {
      scree_asset asset;
      uint32_t unique;
      assert_int_equal(scree_pack_get_asset(pack, slots.asset[i], &asset), SCREE_OK);
      assert_int_equal(scree_pack_tile_cell(pack, code, slots.cx[i], slots.cy[i], slots.cz[i], &unique), SCREE_OK);
      assert_int_equal(asset.cell, unique);
      assert_int_equal(slots.local[i], (slots.cx[i] + 3u * (slots.cy[i] + 3u * slots.cz[i])) * 2 + asset.seed);
      assert_true(slots.x[i] == 2 * asset.centroid[0] && slots.y[i] == 2 * asset.centroid[1] &&
                  slots.z[i] == 2 * asset.centroid[2]);
      assert_true(slots.mean_radius[i] == (float)((double)asset.inner_radius + (double)asset.outer_radius));
    }
  }
  scree_field_destroy(field);
  scree_pack_close(pack);
  free(bytes);
}

static void wrong_fields_are_refused(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_pack_make(&(test_pack_desc){.cells_per_cube = 3}, &size);
  scree_pack* pack;
  assert_int_equal(scree_pack_open_memory(bytes, size, NULL, &pack), SCREE_OK);
  scree_field* field = (scree_field*)pack;
  scree_field_desc desc = {.pack = pack, .cell_size = 1};
  assert_int_equal(scree_field_create(NULL, NULL, &field), SCREE_ERROR_INVALID_ARGUMENT);
  assert_null(field);
  assert_int_equal(scree_field_create(&desc, NULL, NULL), SCREE_ERROR_INVALID_ARGUMENT);
  desc.cell_size = -1;
  assert_int_equal(scree_field_create(&desc, NULL, &field), SCREE_ERROR_RANGE);
  desc.cell_size = 1;
  desc.pack = NULL;
  assert_int_equal(scree_field_create(&desc, NULL, &field), SCREE_ERROR_INVALID_ARGUMENT);
  scree_field_destroy(NULL);
  scree_pack_close(pack);
  free(bytes);
}

/* Every byte of the tables changed in turn: a field or a result code, never a fault. Under the sanitizers this is a small fuzzer.
 */
static void flipped_bytes_of_a_pack_give_a_field_or_a_result_code(void** state) {
  (void)state;
  size_t size;
  uint8_t* bytes = test_pack_make(&(test_pack_desc){.cells_per_cube = 3}, &size);
  uint32_t refused = 0;
  for (size_t step = 0; step < 400; ++step) {
    size_t at = step * 7919 % size;
    bytes[at] ^= 0xff;
    scree_pack* pack = NULL;
    scree_field* field = NULL;
    if (scree_pack_open_memory(bytes, size, NULL, &pack) == SCREE_OK) {
      const scree_field_desc desc = {.pack = pack, .cell_size = 1};
      scree_result result = scree_field_create(&desc, NULL, &field);
      assert_true((result == SCREE_OK) == (field != NULL));
      refused += result != SCREE_OK;
    }
    scree_field_destroy(field);
    scree_pack_close(pack);
    bytes[at] ^= 0xff;
  }
  assert_true(refused > 0);
  free(bytes);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(field_of_a_pack_has_the_rocks_of_the_pack),
      cmocka_unit_test(wrong_fields_are_refused),
      cmocka_unit_test(flipped_bytes_of_a_pack_give_a_field_or_a_result_code),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
