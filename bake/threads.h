/* Threads, clock and atomic counter: all that differs between systems in the baker is in threads.c. */
#ifndef SCREE_THREADS_H
#define SCREE_THREADS_H

#include <scree/base.h>

/* Jobs that run on `count` threads, the caller's among them, made and joined in each parallel_for. count 0 = one a processor. */
scree_jobs threads_jobs(uint32_t count);

uint32_t threads_processors(void);

#endif
