/* Threads for the programs, on POSIX: what scree_jobs asks of a host. */
#ifndef WORKERS_H
#define WORKERS_H

#include <scree/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Jobs on `count` threads, 1..64, the calling one among them; 0 = as many as there are processors. They live as long as one
 * parallel_for does, so there is nothing to free. Calls must not be nested. */
scree_jobs workers_jobs(uint32_t count);

#ifdef __cplusplus
}
#endif

#endif
