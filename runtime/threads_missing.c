/* The pool where the system has no POSIX threads, or the build is told to do without: everything runs on the calling thread. */
#include <scree/threads.h>

#include "allocator.h"

struct scree_threads {
  scree_allocator allocator;
};

static void run_all(void* user, uint32_t count, void (*run)(void* context, uint32_t index, uint32_t worker), void* context) {
  (void)user;
  for (uint32_t i = 0; i < count; ++i) run(context, i, 0);
}

static void run_at_once(void* user, void (*run)(void* context), void* context) {
  (void)user;
  run(context);
}

static void nothing_is_left(void* user) {
  (void)user;
}

scree_result scree_threads_create(uint32_t count, const scree_allocator* given, scree_threads** out) {
  if (out == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  *out = NULL;
  if (count > 64) return SCREE_ERROR_RANGE;
  if (count > 0) return SCREE_ERROR_UNSUPPORTED;
  const scree_allocator allocator = scree_rt_allocator_or_default(given);
  scree_threads* pool = scree_rt_allocate(&allocator, 1, sizeof *pool);
  if (pool == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  pool->allocator = allocator;
  *out = pool;
  return SCREE_OK;
}

void scree_threads_destroy(scree_threads* pool) {
  if (pool == NULL) return;
  const scree_allocator allocator = pool->allocator;
  scree_rt_release(&allocator, pool, 1, sizeof *pool);
}

scree_jobs scree_threads_jobs(scree_threads* pool) {
  if (pool == NULL) return (scree_jobs){0};
  return (scree_jobs){.parallel_for = run_all, .worker_count = 1};
}

scree_tasks scree_threads_tasks(scree_threads* pool) {
  if (pool == NULL) return (scree_tasks){0};
  return (scree_tasks){.submit = run_at_once, .help = nothing_is_left};
}

uint32_t scree_threads_processors(void) {
  return 1;
}
