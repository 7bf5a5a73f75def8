/* Threads that take indices from one counter. */
#define _POSIX_C_SOURCE 200809L

#include "workers.h"

#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>

enum { WORKERS_MAX = 64 };

typedef struct loop {
  void (*run)(void* context, uint32_t index, uint32_t worker);
  void* context;
  uint32_t count;
  atomic_uint next;
} loop;

typedef struct worker {
  pthread_t thread;
  loop* loop;
  uint32_t index;
} worker;

static void* work(void* argument) {
  const worker* self = argument;
  for (;;) {
    uint32_t index = atomic_fetch_add(&self->loop->next, 1);
    if (index >= self->loop->count) return NULL;
    self->loop->run(self->loop->context, index, self->index);
  }
}

static void parallel_for(void* user, uint32_t count, void (*run)(void* context, uint32_t index, uint32_t worker), void* context) {
  uint32_t threads = (uint32_t)(uintptr_t)user;
  loop shared = {.run = run, .context = context, .count = count};
  worker workers[WORKERS_MAX] = {0};
  uint32_t started = 1; /* a thread that cannot be started leaves its share to the others */
  if (threads > count) threads = count;
  for (uint32_t i = 1; i < threads; ++i) {
    worker* w = &workers[started];
    w->loop = &shared;
    w->index = started;
    if (pthread_create(&w->thread, NULL, work, w) == 0) ++started;
  }
  workers[0].loop = &shared;
  work(&workers[0]);
  for (uint32_t i = 1; i < started; ++i) pthread_join(workers[i].thread, NULL);
}

scree_jobs workers_jobs(uint32_t count) {
  if (count == 0) {
    long processors = sysconf(_SC_NPROCESSORS_ONLN);
    count = processors > 0 ? (uint32_t)processors : 1;
  }
  if (count > WORKERS_MAX) count = WORKERS_MAX;
  return (scree_jobs){.parallel_for = parallel_for, .worker_count = count, .user = (void*)(uintptr_t)count};
}
