#include <scree/stream.h>
#include <scree/threads.h>
#include <stdio.h>

static void count(void* context, uint32_t index, uint32_t worker) {
  (void)worker;
  ((int*)context)[index] = 1;
}

int main(void) {
  scree_threads* pool;
  scree_stream* stream;
  int runs[3] = {0};
  if (scree_threads_create(scree_threads_processors() - 1, NULL, &pool) != SCREE_OK) return 1;
  const scree_jobs jobs = scree_threads_jobs(pool);
  jobs.parallel_for(jobs.user, 3, count, runs);
  scree_threads_destroy(pool);
  const scree_result result = scree_stream_create(&(scree_stream_desc){.view_distance = 100}, NULL, &stream, NULL);
  printf("scree %s, no scene: %s\n", scree_version_string(), scree_result_string(result));
  return runs[0] + runs[1] + runs[2] == 3 ? 0 : 1;
}
