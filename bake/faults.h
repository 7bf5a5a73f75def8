/* What is wrong with a number that a caller gave, in words. */
#ifndef SCREE_FAULTS_H
#define SCREE_FAULTS_H

#include <scree/base.h>

/* Adds "value: what" to what an error says. error: may be NULL, as below. Returns RANGE. */
scree_result fault_add(scree_error* error, double value, const char* what);

/* "name: value: what". Returns RANGE. */
scree_result fault_value(scree_error* error, const char* name, double value, const char* what);

/* False for what is not a number, too. */
static inline bool within(double value, double low, double high) {
  return value >= low && value <= high;
}

#endif
