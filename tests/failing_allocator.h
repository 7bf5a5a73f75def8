/* An allocator whose n-th allocation fails, and which knows what has not been given back. For one thread. */
#ifndef FAILING_ALLOCATOR_H
#define FAILING_ALLOCATOR_H

#include <scree/base.h>

#include <stdlib.h>

typedef struct failing_allocator {
  int32_t fail_at; /* allocation 0, 1, ... gets nothing; < 0: none */
  int32_t calls;   /* allocations so far */
  int64_t live;    /* bytes that were not given back */
  bool failed;     /* one has failed */
} failing_allocator;

static inline void* failing_alloc(void* user, size_t size) {
  failing_allocator* f = user;
  if (f->calls++ == f->fail_at) {
    f->failed = true;
    return NULL;
  }
  f->live += (int64_t)size;
  return aligned_alloc(64, (size + 64) / 64 * 64);
}

static inline void failing_release(void* user, void* memory, size_t size) {
  failing_allocator* f = user;
  f->live -= (int64_t)size;
  free(memory);
}

static inline scree_allocator failing_allocator_of(failing_allocator* f) {
  return (scree_allocator){failing_alloc, failing_release, f};
}

#endif
