/* An allocator whose n-th allocation fails, and which knows what was asked for and what has not been given back. For any thread. */
#ifndef FAILING_ALLOCATOR_H
#define FAILING_ALLOCATOR_H

#include <scree/base.h>

#include <stdatomic.h>
#include <stdlib.h>

typedef struct failing_allocator {
  int32_t fail_at;    /* allocation 0, 1, ... gets nothing; < 0: none */
  bool and_later;     /* nor do those after it */
  atomic_int calls;   /* allocations so far */
  atomic_llong asked; /* bytes that were ever handed out */
  atomic_llong live;  /* bytes that were not given back */
  atomic_bool failed; /* one has failed */
} failing_allocator;

static inline void* failing_alloc(void* user, size_t size) {
  failing_allocator* f = user;
  const int call = atomic_fetch_add(&f->calls, 1);
  void* memory = NULL;
  if (f->fail_at < 0 || call < f->fail_at || (call > f->fail_at && !f->and_later))
    memory = aligned_alloc(64, (size + 64) / 64 * 64);
  if (memory == NULL) {
    f->failed = true;
    return NULL;
  }
  f->asked += (long long)size;
  f->live += (long long)size;
  return memory;
}

static inline void failing_release(void* user, void* memory, size_t size) {
  failing_allocator* f = user;
  f->live -= (long long)size;
  free(memory);
}

static inline scree_allocator failing_allocator_of(failing_allocator* f) {
  return (scree_allocator){failing_alloc, failing_release, f};
}

#endif
