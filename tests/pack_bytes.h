/* Packs in memory, for tests that change their bytes. */
#ifndef SCREE_TESTS_PACK_BYTES_H
#define SCREE_TESTS_PACK_BYTES_H

#include <scree/pack.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "make_pack.h"
#include "pack_format.h"

static inline scree_pack* open_or_fail(const uint8_t* bytes, size_t size) {
  scree_pack* pack = NULL;
  assert_int_equal(scree_pack_open_memory(bytes, size, NULL, &pack), SCREE_OK);
  assert_non_null(pack);
  return pack;
}

/* What opening says of changed bytes whose digests are right again. */
static inline scree_result open_resealed(uint8_t* bytes, size_t size) {
  test_pack_reseal(bytes);
  scree_pack* pack;
  const scree_result result = scree_pack_open_memory(bytes, size, NULL, &pack);
  scree_pack_close(pack);
  return result;
}

static inline pack_header* header_of(uint8_t* bytes) {
  return (pack_header*)(void*)bytes;
}

/* Kinds count from 1, and a pack has those of its kind in order. */
static inline pack_section* section_of(uint8_t* bytes, uint32_t kind) {
  return (pack_section*)(void*)(bytes + sizeof(pack_header)) + (kind - 1);
}

static inline void* data_of(uint8_t* bytes, uint32_t kind) {
  return bytes + section_of(bytes, kind)->offset;
}

/* `call` asks `pack`, whose bytes hold `field`, and goes well until the field gets `value`. */
#define REFUSED(field, value, call)                          \
  do {                                                       \
    const __typeof__(field) saved = field;                   \
    assert_int_equal(call, SCREE_OK);                        \
    field = value;                                           \
    assert_int_equal(call, SCREE_ERROR_CORRUPT);             \
    assert_int_not_equal(scree_pack_verify(pack), SCREE_OK); \
    field = saved;                                           \
  } while (0)

#endif
