/* The optional pool: every index and every task runs once, whoever runs it; what is left at the end runs too; and failing
 * allocations and failing starts of threads cost speed, never work or memory. Linked with --wrap for pthread_create. */
#define _POSIX_C_SOURCE 200809L
#include <scree/threads.h>

#include <errno.h>
#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* after the four above */
#include <cmocka.h>

int __real_pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*), void* argument);
int __wrap_pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*), void* argument);

static uint32_t starts_left = UINT32_MAX; /* threads that may still be started */

int __wrap_pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*), void* argument) {
  if (starts_left == 0) return EAGAIN;
  --starts_left;
  return __real_pthread_create(thread, attributes, run, argument);
}

/* Memory that is counted, of which the n-th allocation fails. */
typedef struct counted_memory {
  atomic_size_t bytes;
  atomic_uint allocations;
  uint32_t fails_at; /* 0 = never */
} counted_memory;

static void* counted_alloc(void* user, size_t size) {
  counted_memory* memory = user;
  if (atomic_fetch_add(&memory->allocations, 1) + 1 == memory->fails_at) return NULL;
  atomic_fetch_add(&memory->bytes, size);
  return aligned_alloc(64, (size + 63) / 64 * 64);
}

static void counted_release(void* user, void* bytes, size_t size) {
  counted_memory* memory = user;
  atomic_fetch_sub(&memory->bytes, size);
  free(bytes);
}

static scree_allocator counting(counted_memory* memory) {
  return (scree_allocator){counted_alloc, counted_release, memory};
}

/* A door that tasks wait at. */
typedef struct door {
  pthread_mutex_t lock;
  pthread_cond_t changed;
  bool open;
  uint32_t waiting;
} door;

#define CLOSED_DOOR \
  { .lock = PTHREAD_MUTEX_INITIALIZER, .changed = PTHREAD_COND_INITIALIZER }

static void wait_at(void* context) {
  door* d = context;
  pthread_mutex_lock(&d->lock);
  ++d->waiting;
  pthread_cond_broadcast(&d->changed);
  while (!d->open) pthread_cond_wait(&d->changed, &d->lock);
  --d->waiting;
  pthread_mutex_unlock(&d->lock);
}

static void open_door(void* context) {
  door* d = context;
  pthread_mutex_lock(&d->lock);
  d->open = true;
  pthread_cond_broadcast(&d->changed);
  pthread_mutex_unlock(&d->lock);
}

static void see_waiting(door* d, uint32_t count) {
  pthread_mutex_lock(&d->lock);
  while (d->waiting < count) pthread_cond_wait(&d->changed, &d->lock);
  pthread_mutex_unlock(&d->lock);
}

static scree_threads* pool_of(uint32_t count) {
  scree_threads* pool;
  assert_int_equal(scree_threads_create(count, NULL, &pool), SCREE_OK);
  assert_non_null(pool);
  return pool;
}

enum { INDICES = 5000 };

typedef struct loop_record {
  atomic_uint runs[INDICES];
  atomic_uint at_work[65]; /* by worker: nobody shares a number */
  atomic_bool shared;
} loop_record;

static void record_index(void* context, uint32_t index, uint32_t worker) {
  loop_record* record = context;
  if (worker > 64 || atomic_fetch_add(&record->at_work[worker], 1) != 0) atomic_store(&record->shared, true);
  atomic_fetch_add(&record->runs[index], 1);
  atomic_fetch_sub(&record->at_work[worker], 1);
}

static void each_index_runs_once(void** state) {
  (void)state;
  static const uint32_t counts[] = {0, 1, 2, 8, 64}, lengths[] = {0, 1, 2, 63, INDICES};
  for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
    scree_threads* pool = pool_of(counts[c]);
    const scree_jobs jobs = scree_threads_jobs(pool);
    assert_int_equal(jobs.worker_count, counts[c] + 1);
    for (size_t l = 0; l < sizeof lengths / sizeof *lengths; ++l) {
      loop_record* record = calloc(1, sizeof *record);
      jobs.parallel_for(jobs.user, lengths[l], record_index, record);
      for (uint32_t i = 0; i < INDICES; ++i) assert_int_equal(record->runs[i], i < lengths[l] ? 1 : 0);
      assert_false(record->shared);
      free(record);
    }
    scree_threads_destroy(pool);
  }
}

static void note_thread(void* context, uint32_t index, uint32_t worker) {
  (void)worker;
  ((pthread_t*)context)[index] = pthread_self();
}

static void note_task(void* context) {
  *(pthread_t*)context = pthread_self();
}

static void a_pool_of_no_threads_works_on_the_calling_one(void** state) {
  (void)state;
  scree_threads* pool = pool_of(0);
  const scree_jobs jobs = scree_threads_jobs(pool);
  const scree_tasks tasks = scree_threads_tasks(pool);
  pthread_t threads[3];
  jobs.parallel_for(jobs.user, 2, note_thread, threads);
  tasks.submit(tasks.user, note_task, &threads[2]);
  for (int i = 0; i < 3; ++i) assert_true(pthread_equal(threads[i], pthread_self()));
  tasks.help(tasks.user);
  scree_threads_destroy(pool);
}

/* All indices of a loop wait until each of the threads has one: only a pool in which all take part gets through. */
typedef struct meeting {
  pthread_mutex_t lock;
  pthread_cond_t changed;
  uint32_t here, expected;
  bool seen[65]; /* by worker */
  bool shared;
} meeting;

static void meet(void* context, uint32_t index, uint32_t worker) {
  (void)index;
  meeting* m = context;
  pthread_mutex_lock(&m->lock);
  if (worker > 64 || m->seen[worker])
    m->shared = true;
  else
    m->seen[worker] = true;
  ++m->here;
  pthread_cond_broadcast(&m->changed);
  while (m->here < m->expected) pthread_cond_wait(&m->changed, &m->lock);
  pthread_mutex_unlock(&m->lock);
}

static void all_threads_take_part_in_a_loop_with_numbers_of_their_own(void** state) {
  (void)state;
  scree_threads* pool = pool_of(5);
  const scree_jobs jobs = scree_threads_jobs(pool);
  for (int round = 0; round < 100; ++round) {
    meeting m = {PTHREAD_MUTEX_INITIALIZER, PTHREAD_COND_INITIALIZER, .expected = 6};
    jobs.parallel_for(jobs.user, 6, meet, &m);
    assert_int_equal(m.here, 6);
    assert_false(m.shared);
  }
  scree_threads_destroy(pool);
}

typedef struct caller {
  scree_jobs jobs;
  loop_record* record;
  atomic_uint* loops; /* under way */
  atomic_bool* met;
  pthread_t thread;
} caller;

static void record_of_caller(void* context, uint32_t index, uint32_t worker) {
  const caller* self = context;
  if (index == 0 && atomic_fetch_add(self->loops, 1) != 0) atomic_store(self->met, true);
  record_index(self->record, index, worker);
  if (index == 0) atomic_fetch_sub(self->loops, 1);
}

static void* call_loops(void* argument) {
  const caller* self = argument;
  for (int i = 0; i < 50; ++i) self->jobs.parallel_for(self->jobs.user, 100, record_of_caller, argument);
  return NULL;
}

static void loops_of_several_threads_wait_for_each_other(void** state) {
  (void)state;
  scree_threads* pool = pool_of(3);
  loop_record* record = calloc(1, sizeof *record);
  atomic_uint loops = 0;
  atomic_bool met = false;
  caller callers[4];
  for (int i = 0; i < 4; ++i) {
    callers[i] = (caller){.jobs = scree_threads_jobs(pool), .record = record, .loops = &loops, .met = &met};
    assert_int_equal(pthread_create(&callers[i].thread, NULL, call_loops, &callers[i]), 0);
  }
  for (int i = 0; i < 4; ++i) pthread_join(callers[i].thread, NULL);
  assert_false(met);
  assert_false(record->shared); /* worker numbers are unique over all four callers */
  for (uint32_t i = 0; i < 100; ++i) assert_int_equal(record->runs[i], 200);
  free(record);
  scree_threads_destroy(pool);
}

typedef struct sequence {
  uint32_t order[2000];
  uint32_t count;
  struct sequence_task {
    struct sequence* all;
    uint32_t number;
  } tasks[2000];
} sequence;

static void append(void* context) {
  const struct sequence_task* task = context;
  task->all->order[task->all->count++] = task->number;
}

static void one_thread_runs_tasks_in_the_order_they_came(void** state) {
  (void)state;
  scree_threads* pool = pool_of(1);
  const scree_tasks tasks = scree_threads_tasks(pool);
  sequence* s = calloc(1, sizeof *s);
  door at_start = CLOSED_DOOR, at_end = CLOSED_DOOR;
  tasks.submit(tasks.user, wait_at, &at_start); /* so that the queue grows while it is in use */
  see_waiting(&at_start, 1);
  for (uint32_t i = 0; i < 2000; ++i) {
    s->tasks[i].all = s;
    s->tasks[i].number = i;
    tasks.submit(tasks.user, append, &s->tasks[i]);
  }
  tasks.submit(tasks.user, open_door, &at_end);
  open_door(&at_start);
  wait_at(&at_end);
  assert_int_equal(s->count, 2000);
  for (uint32_t i = 0; i < 2000; ++i) assert_int_equal(s->order[i], i);
  scree_threads_destroy(pool);
  free(s);
}

static void add_one(void* context) {
  atomic_fetch_add((atomic_uint*)context, 1);
}

static void help_runs_tasks_when_all_threads_are_busy(void** state) {
  (void)state;
  scree_threads* pool = pool_of(2);
  const scree_tasks tasks = scree_threads_tasks(pool);
  door d = CLOSED_DOOR;
  tasks.submit(tasks.user, wait_at, &d);
  tasks.submit(tasks.user, wait_at, &d);
  see_waiting(&d, 2);
  atomic_uint runs = 0;
  for (uint32_t i = 0; i < 10; ++i) tasks.submit(tasks.user, add_one, &runs);
  for (uint32_t i = 1; i <= 10; ++i) {
    tasks.help(tasks.user);
    assert_int_equal(runs, i);
  }
  tasks.help(tasks.user); /* nothing is left to run, two are under way: comes back all the same */
  open_door(&d);
  scree_threads_destroy(pool);
}

static void a_loop_ends_while_all_threads_are_busy_with_tasks(void** state) {
  (void)state;
  scree_threads* pool = pool_of(2);
  const scree_tasks tasks = scree_threads_tasks(pool);
  const scree_jobs jobs = scree_threads_jobs(pool);
  door d = CLOSED_DOOR;
  tasks.submit(tasks.user, wait_at, &d);
  tasks.submit(tasks.user, wait_at, &d);
  see_waiting(&d, 2);
  pthread_t threads[100];
  jobs.parallel_for(jobs.user, 100, note_thread, threads);
  for (int i = 0; i < 100; ++i) assert_true(pthread_equal(threads[i], pthread_self()));
  open_door(&d);
  scree_threads_destroy(pool);
}

typedef struct tree {
  scree_tasks tasks;
  atomic_uint runs;
} tree;

typedef struct tree_node {
  tree* all;
  uint32_t depth;
} tree_node;

static void grow_tree(void* context) {
  tree_node* node = context;
  atomic_fetch_add(&node->all->runs, 1);
  for (uint32_t i = 0; node->depth > 0 && i < 2; ++i) {
    tree_node* child = malloc(sizeof *child);
    *child = (tree_node){node->all, node->depth - 1};
    node->all->tasks.submit(node->all->tasks.user, grow_tree, child);
  }
  free(node);
}

static void destroy_runs_what_is_left_and_what_that_submits(void** state) {
  (void)state;
  for (uint32_t count = 0; count <= 3; ++count) {
    scree_threads* pool = pool_of(count);
    tree t = {.tasks = scree_threads_tasks(pool)};
    tree_node* root = malloc(sizeof *root);
    *root = (tree_node){&t, 10};
    t.tasks.submit(t.tasks.user, grow_tree, root);
    scree_threads_destroy(pool);
    assert_int_equal(t.runs, (1 << 11) - 1);
  }
}

typedef struct task_with_loop {
  scree_jobs jobs;
  loop_record* record;
  door ended;
} task_with_loop;

static void run_loop(void* context) {
  task_with_loop* t = context;
  t->jobs.parallel_for(t->jobs.user, 1000, record_index, t->record);
  open_door(&t->ended);
}

static void a_task_may_run_a_loop(void** state) {
  (void)state;
  scree_threads* pool = pool_of(2);
  const scree_tasks tasks = scree_threads_tasks(pool);
  task_with_loop t = {.jobs = scree_threads_jobs(pool), .record = calloc(1, sizeof *t.record), .ended = CLOSED_DOOR};
  tasks.submit(tasks.user, run_loop, &t);
  t.jobs.parallel_for(t.jobs.user, 1000, record_index, t.record);
  wait_at(&t.ended);
  for (uint32_t i = 0; i < 1000; ++i) assert_int_equal(t.record->runs[i], 2);
  assert_false(t.record->shared);
  scree_threads_destroy(pool);
  free(t.record);
}

/* Makes a pool, holds its threads up, and submits more than the queue holds at first. */
static scree_result overfill(const scree_allocator* allocator) {
  scree_threads* pool;
  const scree_result result = scree_threads_create(2, allocator, &pool);
  if (result != SCREE_OK) {
    assert_null(pool);
    return result;
  }
  const scree_tasks tasks = scree_threads_tasks(pool);
  door d = CLOSED_DOOR;
  tasks.submit(tasks.user, wait_at, &d);
  tasks.submit(tasks.user, wait_at, &d);
  see_waiting(&d, 2);
  atomic_uint runs = 0;
  for (uint32_t i = 0; i < 1000; ++i) tasks.submit(tasks.user, add_one, &runs);
  open_door(&d);
  scree_threads_destroy(pool);
  assert_int_equal(runs, 1000); /* also where the queue could not grow */
  return SCREE_OK;
}

static void failing_allocations_lose_no_task_and_no_memory(void** state) {
  (void)state;
  uint32_t refused = 0;
  for (uint32_t nth = 1;; ++nth) {
    counted_memory memory = {.fails_at = nth};
    const scree_allocator allocator = counting(&memory);
    const scree_result result = overfill(&allocator);
    assert_int_equal(memory.bytes, 0);
    if (result != SCREE_OK) {
      assert_int_equal(result, SCREE_ERROR_OUT_OF_MEMORY);
      ++refused;
    }
    if (memory.allocations < nth) {
      assert_true(nth > 4); /* the pool, its queue, and the queue's growth */
      break;
    }
  }
  assert_int_equal(refused, 2);
}

static void threads_that_do_not_start_make_a_smaller_pool_or_none(void** state) {
  (void)state;
  for (uint32_t start = 0; start <= 4; ++start) {
    counted_memory memory = {0};
    const scree_allocator allocator = counting(&memory);
    scree_threads* pool;
    starts_left = start;
    const scree_result result = scree_threads_create(4, &allocator, &pool);
    starts_left = UINT32_MAX;
    assert_int_equal(result, start == 0 ? SCREE_ERROR_UNSUPPORTED : SCREE_OK);
    if (start == 0) {
      assert_null(pool);
    } else {
      const scree_jobs jobs = scree_threads_jobs(pool);
      assert_int_equal(jobs.worker_count, start + 1);
      meeting m = {PTHREAD_MUTEX_INITIALIZER, PTHREAD_COND_INITIALIZER, .expected = start + 1};
      jobs.parallel_for(jobs.user, start + 1, meet, &m);
      scree_threads_destroy(pool);
    }
    assert_int_equal(memory.bytes, 0);
  }
}

static void wrong_arguments_are_told(void** state) {
  (void)state;
  scree_threads* pool = (scree_threads*)&pool;
  assert_int_equal(scree_threads_create(65, NULL, &pool), SCREE_ERROR_RANGE);
  assert_null(pool);
  assert_int_equal(scree_threads_create(1, NULL, NULL), SCREE_ERROR_INVALID_ARGUMENT);
  scree_threads_destroy(NULL);
  assert_true(scree_threads_jobs(NULL).parallel_for == NULL);
  assert_true(scree_threads_tasks(NULL).submit == NULL);
  assert_true(scree_threads_processors() >= 1 && scree_threads_processors() <= 64);
}

static void note_signals(void* context) {
  pthread_sigmask(SIG_SETMASK, NULL, context);
}

static void signals_of_the_host_are_not_for_the_pool(void** state) {
  (void)state;
  sigset_t before, after, of_pool;
  pthread_sigmask(SIG_SETMASK, NULL, &before);
  scree_threads* pool = pool_of(1);
  pthread_sigmask(SIG_SETMASK, NULL, &after);
  const scree_tasks tasks = scree_threads_tasks(pool);
  door d = CLOSED_DOOR;
  tasks.submit(tasks.user, note_signals, &of_pool);
  tasks.submit(tasks.user, open_door, &d);
  wait_at(&d);
  scree_threads_destroy(pool);
  assert_int_equal(sigismember(&of_pool, SIGINT), 1);
  assert_int_equal(sigismember(&before, SIGINT), 0);
  assert_int_equal(sigismember(&after, SIGINT), 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_index_runs_once),
      cmocka_unit_test(a_pool_of_no_threads_works_on_the_calling_one),
      cmocka_unit_test(all_threads_take_part_in_a_loop_with_numbers_of_their_own),
      cmocka_unit_test(loops_of_several_threads_wait_for_each_other),
      cmocka_unit_test(one_thread_runs_tasks_in_the_order_they_came),
      cmocka_unit_test(help_runs_tasks_when_all_threads_are_busy),
      cmocka_unit_test(a_loop_ends_while_all_threads_are_busy_with_tasks),
      cmocka_unit_test(destroy_runs_what_is_left_and_what_that_submits),
      cmocka_unit_test(a_task_may_run_a_loop),
      cmocka_unit_test(failing_allocations_lose_no_task_and_no_memory),
      cmocka_unit_test(threads_that_do_not_start_make_a_smaller_pool_or_none),
      cmocka_unit_test(wrong_arguments_are_told),
      cmocka_unit_test(signals_of_the_host_are_not_for_the_pool),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
