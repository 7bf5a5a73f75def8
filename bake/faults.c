#include "faults.h"

#include "support_text.h"

scree_result fault_add(scree_error* error, double value, const char* what) {
  scree_rt_text_add_number(error, value);
  scree_rt_text_add(error, ": ");
  scree_rt_text_add(error, what);
  return SCREE_ERROR_RANGE;
}

scree_result fault_value(scree_error* error, const char* name, double value, const char* what) {
  scree_rt_text_clear(error);
  scree_rt_text_add(error, name);
  scree_rt_text_add(error, ": ");
  return fault_add(error, value, what);
}
