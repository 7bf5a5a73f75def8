/* What a text for people has to be. */
#ifndef SCREE_TESTS_ONE_LINE_H
#define SCREE_TESTS_ONE_LINE_H

#include <scree/base.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

/* Not empty, ended, and without a control character. */
static inline void assert_one_line(const scree_error* error) {
  assert_non_null(memchr(error->message, '\0', sizeof error->message));
  assert_true(error->message[0] != '\0');
  for (const char* c = error->message; *c != '\0'; ++c) assert_true((unsigned char)*c >= ' ');
}

#endif
