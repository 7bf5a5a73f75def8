/* What benchmarks share: a clock, a median, and an end with a message that names the program. */
#ifndef BENCH_H
#define BENCH_H

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static inline double clock_seconds(clockid_t clock) {
  struct timespec t;
  clock_gettime(clock, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Of the calling thread's processor time. */
static inline double seconds(void) {
  return clock_seconds(CLOCK_THREAD_CPUTIME_ID);
}

static inline void die(const char* what) {
  fprintf(stderr, BENCH_PROGRAM ": %s\n", what);
  exit(2);
}

static inline void* must(void* memory) {
  if (memory == NULL) die("out of memory");
  return memory;
}

static inline int by_value(const void* a, const void* b) {
  const double x = *(const double*)a, y = *(const double*)b;
  return x < y ? -1 : x > y;
}

static inline double median(double* values, int count) {
  qsort(values, (size_t)count, sizeof *values, by_value);
  return values[count / 2];
}

#endif
