/* Result codes, the version, and the allocator with its overflow checks. */
#include <scree/base.h>

#include "allocator.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

/* Codes are never renumbered: these numbers are part of the API. */
static const struct {
  scree_result code;
  int number;
  const char* text;
} codes[] = {{SCREE_OK, 0, "success"},
             {SCREE_ERROR_INVALID_ARGUMENT, 1, "invalid argument"},
             {SCREE_ERROR_OUT_OF_MEMORY, 2, "out of memory"},
             {SCREE_ERROR_IO, 3, "file cannot be read or written"},
             {SCREE_ERROR_NOT_A_PACK, 4, "not a scree pack"},
             {SCREE_ERROR_VERSION, 5, "pack has another format version"},
             {SCREE_ERROR_TRUNCATED, 6, "file is truncated"},
             {SCREE_ERROR_CORRUPT, 7, "file is corrupt"},
             {SCREE_ERROR_DIGEST, 8, "digest does not match"},
             {SCREE_ERROR_UNSUPPORTED, 9, "not supported by this build"},
             {SCREE_ERROR_CAPACITY, 10, "buffer is too small"},
             {SCREE_ERROR_NOT_CLOSED, 11, "mesh is not closed"},
             {SCREE_ERROR_SYNTAX, 12, "syntax error"},
             {SCREE_ERROR_RANGE, 13, "number out of range"},
             {SCREE_ERROR_CANCELLED, 14, "cancelled"},
             {SCREE_ERROR_PACK_KIND, 15, "pack is of the wrong kind: tiles, models and a cliff are not alike"}};
enum { CODE_COUNT = sizeof codes / sizeof codes[0] };

static void every_result_code_keeps_its_number_and_text(void** state) {
  (void)state;
  for (int i = 0; i < CODE_COUNT; ++i) {
    assert_int_equal((int)codes[i].code, codes[i].number);
    assert_string_equal(scree_result_string(codes[i].code), codes[i].text);
  }
}

static void values_that_are_no_result_code_have_a_text_too(void** state) {
  (void)state;
  const int strangers[] = {-1, CODE_COUNT, 1000, INT32_MAX, INT32_MIN};
  for (size_t i = 0; i < sizeof strangers / sizeof strangers[0]; ++i) {
    scree_result stranger;
    _Static_assert(sizeof stranger == sizeof strangers[0], "results are ints");
    memcpy(&stranger, &strangers[i], sizeof stranger);
    assert_string_equal(scree_result_string(stranger), "unknown result code");
  }
}

static void version_string_is_the_header_s_numbers(void** state) {
  (void)state;
  char expected[32];
  snprintf(expected, sizeof expected, "%d.%d.%d", SCREE_VERSION_MAJOR, SCREE_VERSION_MINOR, SCREE_VERSION_PATCH);
  assert_string_equal(scree_version_string(), expected);
}

static void default_memory_is_aligned_and_writable(void** state) {
  (void)state;
  scree_allocator allocator = scree_rt_allocator_or_default(NULL);
  const size_t sizes[] = {0, 1, 63, 64, 65, 4096, 100001};
  for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
    unsigned char* memory = scree_rt_allocate(&allocator, sizes[i], 1);
    assert_non_null(memory);
    assert_int_equal((uintptr_t)memory % SCREE_ALIGNMENT, 0);
    memset(memory, 0xa5, sizes[i]);
    scree_rt_release(&allocator, memory, sizes[i], 1);
  }
}

static void zeroed_memory_is_zero(void** state) {
  (void)state;
  scree_allocator allocator = scree_rt_allocator_or_default(NULL);
  for (int round = 0; round < 4; ++round) {
    unsigned char* memory = scree_rt_allocate_zeroed(&allocator, 1000, 3);
    assert_non_null(memory);
    for (int i = 0; i < 3000; ++i) assert_int_equal(memory[i], 0);
    memset(memory, 0xff, 3000);
    scree_rt_release(&allocator, memory, 1000, 3);
  }
}

typedef struct counting_host {
  size_t live, calls;
} counting_host;

static unsigned char counted[256];

static void* counting_alloc(void* user, size_t size) {
  counting_host* host = user;
  host->live += size;
  ++host->calls;
  return size <= sizeof counted ? counted : NULL;
}

static void counting_release(void* user, void* memory, size_t size) {
  (void)memory;
  ((counting_host*)user)->live -= size;
}

static void size_that_overflows_is_refused_before_the_host_is_asked(void** state) {
  (void)state;
  counting_host host = {0, 0};
  scree_allocator allocator = {counting_alloc, counting_release, &host};
  assert_null(scree_rt_allocate(&allocator, SIZE_MAX / 2 + 1, 2));
  assert_null(scree_rt_allocate(&allocator, 2, SIZE_MAX / 2 + 1));
  assert_null(scree_rt_allocate_zeroed(&allocator, SIZE_MAX, SIZE_MAX));
  assert_int_equal(host.calls, 0);
}

static void size_near_the_limit_is_refused_by_the_default_host(void** state) {
  (void)state;
  scree_allocator allocator = scree_rt_allocator_or_default(NULL);
  assert_null(allocator.alloc(allocator.user, SIZE_MAX));
}

static void host_gets_back_the_size_that_it_gave(void** state) {
  (void)state;
  counting_host host = {0, 0};
  scree_allocator given = {counting_alloc, counting_release, &host};
  scree_allocator allocator = scree_rt_allocator_or_default(&given);
  void* memory = scree_rt_allocate(&allocator, 10, 24);
  assert_ptr_equal(memory, counted);
  assert_int_equal(host.live, 240);
  scree_rt_release(&allocator, memory, 10, 24);
  assert_int_equal(host.live, 0);
}

static void releasing_null_does_not_reach_the_host(void** state) {
  (void)state;
  counting_host host = {100, 0};
  scree_allocator allocator = {counting_alloc, counting_release, &host};
  scree_rt_release(&allocator, NULL, 4, 4);
  assert_int_equal(host.live, 100);
}

static void allocator_without_functions_means_malloc(void** state) {
  (void)state;
  scree_allocator zero = {NULL, NULL, NULL};
  scree_allocator allocator = scree_rt_allocator_or_default(&zero);
  void* memory = scree_rt_allocate(&allocator, 1, 1);
  assert_non_null(memory);
  scree_rt_release(&allocator, memory, 1, 1);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_result_code_keeps_its_number_and_text),
      cmocka_unit_test(values_that_are_no_result_code_have_a_text_too),
      cmocka_unit_test(version_string_is_the_header_s_numbers),
      cmocka_unit_test(default_memory_is_aligned_and_writable),
      cmocka_unit_test(zeroed_memory_is_zero),
      cmocka_unit_test(size_that_overflows_is_refused_before_the_host_is_asked),
      cmocka_unit_test(size_near_the_limit_is_refused_by_the_default_host),
      cmocka_unit_test(host_gets_back_the_size_that_it_gave),
      cmocka_unit_test(releasing_null_does_not_reach_the_host),
      cmocka_unit_test(allocator_without_functions_means_malloc),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
