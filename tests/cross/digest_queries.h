/* One digest of many queries: random supports of every kind, shells, thresholds, boxes, ids. */
#ifndef DIGEST_QUERIES_H
#define DIGEST_QUERIES_H

#include <stdint.h>

/* Zero when something fails. */
uint64_t digest_queries(void);

#endif
