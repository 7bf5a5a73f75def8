/* A small pool of threads for hosts that have no job system: what scree_jobs and scree_tasks ask for, on POSIX threads. This is the
 * optional library scree::threads; nothing of the core runtime needs it. Threads that have nothing to do sleep. */
#ifndef SCREE_THREADS_H
#define SCREE_THREADS_H

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct scree_threads scree_threads;

/* Starts `count` threads beside those of the host, 0..64; fewer where the system gives no more of them, scree_jobs.worker_count
 * tells. With 0, jobs run on the calling thread and tasks when they are submitted. The threads take none of the host's signals.
 * Returns SCREE_OK, INVALID_ARGUMENT, RANGE, OUT_OF_MEMORY or UNSUPPORTED (none was to be had, or the build is one without). */
SCREE_API scree_result scree_threads_create(uint32_t count, const scree_allocator* allocator, scree_threads** out);

/* Runs what is left, then stops. No call of parallel_for may be under way. NULL is allowed. */
SCREE_API void scree_threads_destroy(scree_threads* threads);

/* parallel_for on the pool's threads and the calling one: worker_count is their number. Calls from several threads wait for each
 * other; calls must not be nested. NULL: all zero. */
SCREE_API scree_jobs scree_threads_jobs(scree_threads* threads);

/* Background work on the pool's threads, first come, first served; loops come before. What waits is kept in memory of the
 * allocator, and where there is none, submit runs the task at once. NULL: all zero. */
SCREE_API scree_tasks scree_threads_tasks(scree_threads* threads);

/* How many processors the system has, as far as a pool makes use of them: 1..64. One thread fewer beside the calling one keeps them
 * all busy. */
SCREE_API uint32_t scree_threads_processors(void);

#ifdef __cplusplus
}
#endif

#endif
