#define _POSIX_C_SOURCE 200809L
#include "threads.h"

#include <pthread.h>
#include <stdatomic.h>
#include <time.h>
#include <unistd.h>

#include "clock.h"

#define MAX_THREADS 256

double clock_seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

uint32_t threads_processors(void) {
  const long count = sysconf(_SC_NPROCESSORS_ONLN);
  return count < 1 ? 1 : count > MAX_THREADS ? MAX_THREADS : (uint32_t)count;
}

typedef struct loop {
  atomic_uint next;
  uint32_t count;
  void (*run)(void* context, uint32_t index, uint32_t worker);
  void* context;
} loop;

typedef struct worker {
  pthread_t thread;
  loop* work;
  uint32_t number;
} worker;

static void* work_on(void* argument) {
  const worker* self = argument;
  for (;;) {
    const uint32_t index = atomic_fetch_add(&self->work->next, 1);
    if (index >= self->work->count) return NULL;
    self->work->run(self->work->context, index, self->number);
  }
}

static void parallel_for(void* user, uint32_t count, void (*run)(void* context, uint32_t index, uint32_t worker), void* context) {
  uint32_t threads = (uint32_t)(uintptr_t)user;
  if (threads > count) threads = count;
  loop work = {.count = count, .run = run, .context = context};
  atomic_init(&work.next, 0);
  worker workers[MAX_THREADS];
  uint32_t started = 1; /* a thread that cannot be started is one fewer: the others take its work */
  for (uint32_t i = 1; i < threads; ++i) {
    workers[started] = (worker){.work = &work, .number = started};
    if (pthread_create(&workers[started].thread, NULL, work_on, &workers[started]) == 0) ++started;
  }
  workers[0] = (worker){.work = &work, .number = 0};
  work_on(&workers[0]);
  for (uint32_t i = 1; i < started; ++i) pthread_join(workers[i].thread, NULL);
}

scree_jobs threads_jobs(uint32_t count) {
  if (count == 0) count = threads_processors();
  if (count > MAX_THREADS) count = MAX_THREADS;
  return (scree_jobs){parallel_for, count, (void*)(uintptr_t)count};
}
