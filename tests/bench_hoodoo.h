/* Benchmarks of a whole hoodoo, for scree-bench-weather. */
#ifndef BENCH_HOODOO_H
#define BENCH_HOODOO_H

#include <stdbool.h>

/* hoodoo.goblin_seconds: the first goblin of content/recipes/goblin.json from recipe to surface, on one thread. */
void bench_goblin(void);

/* hoodoo.steer: a step of that goblin half way and the remesh of what it changed, on two threads, milliseconds of the wall clock;
 * hoodoo.steer_larger: the same of one a quarter wider and taller. */
void bench_steer(bool larger);

#endif
