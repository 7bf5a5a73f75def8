/* A small pool of threads for hosts that have no job system: what scree_jobs and scree_tasks ask for, on POSIX threads. Optional:
 * nothing else of scree needs it. */
#ifndef SCREE_THREADS_H
#define SCREE_THREADS_H

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct scree_threads scree_threads;

/* Starts `count` threads beside those of the host, 0..64. With 0, jobs run on the calling thread and tasks when they are submitted.
 * Returns SCREE_OK, RANGE, OUT_OF_MEMORY or UNSUPPORTED (the system gives no threads). */
SCREE_API scree_result scree_threads_create(uint32_t count, const scree_allocator* allocator, scree_threads** out);

/* Runs what is left, then stops. NULL is allowed. */
SCREE_API void scree_threads_destroy(scree_threads* threads);

/* parallel_for on the pool's threads and the calling one: worker_count is count + 1. Calls from several threads wait for each
 * other; calls must not be nested. */
SCREE_API scree_jobs scree_threads_jobs(scree_threads* threads);

/* Background work on the pool's threads, first come, first served. */
SCREE_API scree_tasks scree_threads_tasks(scree_threads* threads);

/* How many processors the system has, >= 1. */
SCREE_API uint32_t scree_threads_processors(void);

#ifdef __cplusplus
}
#endif

#endif
