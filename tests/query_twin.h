/* The plain twin of the queries: every rock of every cell of a range, one after the other, no hierarchy, no tables. */
#ifndef QUERY_TWIN_H
#define QUERY_TWIN_H

#include "query_kernel.h"
#include "synthetic_field.h"

typedef struct found_rock {
  scree_id id;
  scree_instance instance;
} found_rock;

typedef struct found_rocks {
  found_rock* rocks; /* sorted by id */
  uint64_t count;
} found_rocks;

/* What the query should find among the cells low .. high - 1 of the field. */
found_rocks twin_query(const scree_query_desc* desc, const field_source* source, const int64_t low[3], const int64_t high[3]);

/* What it does find with a kernel; fails the test when count, fill and ids do not agree. */
found_rocks run_query(const scree_query_desc* desc, query_kernel kernel);

void found_free(found_rocks* found);

/* Fails the test when the two differ in any byte. */
void assert_found_equal(const found_rocks* expected, const found_rocks* found);

/* Appends b to a and sorts. */
void found_join(found_rocks* a, const found_rocks* b);

#endif
