/* The pool: threads that sleep until there is a loop to join or a task to run. One lock guards everything but the counter from
 * which the threads of a loop draw their indices. A loop never waits for a thread that did not join it, so threads that are busy
 * with tasks slow a loop down and cannot block it. */
#define _POSIX_C_SOURCE 200809L
#include <scree/threads.h>

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "allocator.h"

enum { THREADS_MAX = 64, TASKS_AT_FIRST = 128 };

typedef struct pool_thread {
  scree_threads* pool;
  pthread_t thread;
  uint32_t worker; /* its number in loops, >= 1: 0 is the thread that called parallel_for */
} pool_thread;

typedef struct pool_task {
  void (*run)(void* context);
  void* context;
} pool_task;

struct scree_threads {
  scree_allocator allocator;
  pthread_mutex_t lock;
  pthread_cond_t work;      /* a loop has begun, a task was submitted, or the pool stops */
  pthread_cond_t loop_left; /* the last thread but the caller's has left the loop */
  pthread_cond_t loop_free; /* another loop may begin */
  pthread_cond_t task_ended;
  bool stopping;

  /* The loop of the moment. */
  bool looping;
  void (*loop_run)(void* context, uint32_t index, uint32_t worker);
  void* loop_context;
  uint32_t loop_count;
  uint32_t loop_threads; /* of the pool, at work on it */
  atomic_uint loop_next;

  /* Submitted tasks, a ring. */
  pool_task* tasks;
  uint32_t task_capacity, task_first, task_count;
  uint32_t tasks_running;

  uint32_t count;
  pool_thread threads[THREADS_MAX];
};

static void run_indices(scree_threads* pool, uint32_t worker) {
  for (uint32_t index = atomic_load(&pool->loop_next); index < pool->loop_count;) {
    /* Not fetch_add, which could run over the end of uint32 and start again. */
    if (!atomic_compare_exchange_weak(&pool->loop_next, &index, index + 1)) continue;
    pool->loop_run(pool->loop_context, index, worker);
    index = atomic_load(&pool->loop_next);
  }
}

/* Called with the lock held, like all below that take no lock themselves. */
static void join_loop(scree_threads* pool, uint32_t worker) {
  ++pool->loop_threads;
  pthread_mutex_unlock(&pool->lock);
  run_indices(pool, worker);
  pthread_mutex_lock(&pool->lock);
  if (--pool->loop_threads == 0) pthread_cond_signal(&pool->loop_left);
}

static void run_task(scree_threads* pool) {
  const pool_task task = pool->tasks[pool->task_first];
  pool->task_first = (pool->task_first + 1) % pool->task_capacity;
  --pool->task_count;
  ++pool->tasks_running;
  pthread_mutex_unlock(&pool->lock);
  task.run(task.context);
  pthread_mutex_lock(&pool->lock);
  --pool->tasks_running;
  pthread_cond_broadcast(&pool->task_ended);
}

static void* work_until_stopped(void* argument) {
  const pool_thread* self = argument;
  scree_threads* pool = self->pool;
  pthread_mutex_lock(&pool->lock);
  for (;;) {
    if (pool->looping && atomic_load(&pool->loop_next) < pool->loop_count)
      join_loop(pool, self->worker);
    else if (pool->task_count > 0)
      run_task(pool);
    else if (pool->stopping)
      break;
    else
      pthread_cond_wait(&pool->work, &pool->lock);
  }
  pthread_mutex_unlock(&pool->lock);
  return NULL;
}

static void parallel_for(void* user, uint32_t count, void (*run)(void* context, uint32_t index, uint32_t worker), void* context) {
  scree_threads* pool = user;
  pthread_mutex_lock(&pool->lock);
  while (pool->looping) pthread_cond_wait(&pool->loop_free, &pool->lock);
  pool->looping = true;
  pool->loop_run = run;
  pool->loop_context = context;
  pool->loop_count = count;
  atomic_store(&pool->loop_next, 0);
  if (count > 1) pthread_cond_broadcast(&pool->work);
  pthread_mutex_unlock(&pool->lock);

  run_indices(pool, 0);

  pthread_mutex_lock(&pool->lock);
  while (pool->loop_threads > 0) pthread_cond_wait(&pool->loop_left, &pool->lock);
  pool->looping = false;
  pthread_cond_signal(&pool->loop_free);
  pthread_mutex_unlock(&pool->lock);
}

/* Room for one more task. */
static bool make_room(scree_threads* pool) {
  if (pool->task_count < pool->task_capacity) return true;
  if (pool->task_capacity > UINT32_MAX / 2) return false;
  const uint32_t capacity = pool->task_capacity * 2;
  pool_task* larger = scree_rt_allocate(&pool->allocator, capacity, sizeof *larger);
  if (larger == NULL) return false;
  const uint32_t to_end = pool->task_capacity - pool->task_first;
  memcpy(larger, pool->tasks + pool->task_first, to_end * sizeof *larger);
  memcpy(larger + to_end, pool->tasks, pool->task_first * sizeof *larger);
  scree_rt_release(&pool->allocator, pool->tasks, pool->task_capacity, sizeof *pool->tasks);
  pool->tasks = larger;
  pool->task_first = 0;
  pool->task_capacity = capacity;
  return true;
}

static void submit(void* user, void (*run)(void* context), void* context) {
  scree_threads* pool = user;
  bool taken = false;
  if (pool->count > 0) {
    pthread_mutex_lock(&pool->lock);
    taken = make_room(pool);
    if (taken) {
      pool->tasks[(pool->task_first + pool->task_count) % pool->task_capacity] = (pool_task){run, context};
      ++pool->task_count;
      pthread_cond_signal(&pool->work);
    }
    pthread_mutex_unlock(&pool->lock);
  }
  if (!taken) run(context);
}

/* The wait has an end because what the caller waits for may have ended before it got here, while other tasks go on for long. */
static void help(void* user) {
  scree_threads* pool = user;
  pthread_mutex_lock(&pool->lock);
  if (pool->task_count > 0) {
    run_task(pool);
  } else if (pool->tasks_running > 0) {
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_nsec += 1000000;
    if (until.tv_nsec >= 1000000000) {
      until.tv_nsec -= 1000000000;
      ++until.tv_sec;
    }
    pthread_cond_timedwait(&pool->task_ended, &pool->lock, &until);
  }
  pthread_mutex_unlock(&pool->lock);
}

static bool create_locks(scree_threads* pool) {
  pthread_condattr_t clock;
  if (pthread_condattr_init(&clock) != 0) return false;
  pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
  pthread_cond_t* conditions[] = {&pool->work, &pool->loop_left, &pool->loop_free, &pool->task_ended};
  int made = 0;
  while (made < 4 && pthread_cond_init(conditions[made], &clock) == 0) ++made;
  pthread_condattr_destroy(&clock);
  if (made == 4 && pthread_mutex_init(&pool->lock, NULL) == 0) return true;
  while (made > 0) pthread_cond_destroy(conditions[--made]);
  return false;
}

/* The host's signals are not for these threads. */
static void start_threads(scree_threads* pool, uint32_t count) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  for (uint32_t i = 0; i < count; ++i) {
    pool_thread* thread = &pool->threads[i];
    thread->pool = pool;
    thread->worker = i + 1;
    if (pthread_create(&thread->thread, NULL, work_until_stopped, thread) != 0) break;
    ++pool->count;
  }
  pthread_sigmask(SIG_SETMASK, &before, NULL);
}

static void release_pool(scree_threads* pool) {
  const scree_allocator allocator = pool->allocator;
  scree_rt_release(&allocator, pool->tasks, pool->task_capacity, sizeof *pool->tasks);
  scree_rt_release(&allocator, pool, 1, sizeof *pool);
}

scree_result scree_threads_create(uint32_t count, const scree_allocator* given, scree_threads** out) {
  if (out == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  *out = NULL;
  if (count > THREADS_MAX) return SCREE_ERROR_RANGE;
  const scree_allocator allocator = scree_rt_allocator_or_default(given);
  scree_threads* pool = scree_rt_allocate_zeroed(&allocator, 1, sizeof *pool);
  if (pool == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  pool->allocator = allocator;
  pool->task_capacity = TASKS_AT_FIRST;
  pool->tasks = scree_rt_allocate(&allocator, pool->task_capacity, sizeof *pool->tasks);
  if (pool->tasks == NULL || !create_locks(pool)) {
    release_pool(pool);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  atomic_init(&pool->loop_next, 0);
  start_threads(pool, count);
  if (pool->count == 0 && count > 0) {
    scree_threads_destroy(pool);
    return SCREE_ERROR_UNSUPPORTED;
  }
  *out = pool;
  return SCREE_OK;
}

void scree_threads_destroy(scree_threads* pool) {
  if (pool == NULL) return;
  pthread_mutex_lock(&pool->lock);
  pool->stopping = true;
  pthread_cond_broadcast(&pool->work);
  while (pool->task_count > 0) run_task(pool);
  pthread_mutex_unlock(&pool->lock);
  for (uint32_t i = 0; i < pool->count; ++i) pthread_join(pool->threads[i].thread, NULL);
  pthread_cond_destroy(&pool->work);
  pthread_cond_destroy(&pool->loop_left);
  pthread_cond_destroy(&pool->loop_free);
  pthread_cond_destroy(&pool->task_ended);
  pthread_mutex_destroy(&pool->lock);
  release_pool(pool);
}

scree_jobs scree_threads_jobs(scree_threads* pool) {
  if (pool == NULL) return (scree_jobs){0};
  return (scree_jobs){.parallel_for = parallel_for, .worker_count = pool->count + 1, .user = pool};
}

scree_tasks scree_threads_tasks(scree_threads* pool) {
  if (pool == NULL) return (scree_tasks){0};
  return (scree_tasks){.submit = submit, .help = help, .user = pool};
}

uint32_t scree_threads_processors(void) {
  const long count = sysconf(_SC_NPROCESSORS_ONLN);
  return count < 1 ? 1 : count > THREADS_MAX ? THREADS_MAX : (uint32_t)count;
}
