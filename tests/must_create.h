/* Supports that tests are sure of, and single distances to them. */
#ifndef SCREE_TESTS_MUST_CREATE_H
#define SCREE_TESTS_MUST_CREATE_H

#include <scree/support.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* Ends the test on failure. */
static inline scree_support* must_create(const scree_support_desc* desc) {
  scree_support* support = NULL;
  scree_error error;
  if (scree_support_create(desc, NULL, &support, &error) != SCREE_OK) fail_msg("%s", error.message);
  return support;
}

static inline scree_support* one_shape(const scree_shape* shape) {
  return must_create(&(scree_support_desc){.shapes = shape, .shape_count = 1});
}

static inline double distance_at(const scree_support* support, const double p[3]) {
  float x = (float)p[0], y = (float)p[1], z = (float)p[2], d;
  scree_support_distance(support, &x, &y, &z, &d, 1);
  return (double)d;
}

#endif
