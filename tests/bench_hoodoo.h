/* Benchmarks of a whole hoodoo, for scree-bench-weather. */
#ifndef BENCH_HOODOO_H
#define BENCH_HOODOO_H

/* hoodoo.goblin_seconds: a goblin from its start shape to its surface, on one thread. */
void bench_goblin(void);

/* hoodoo.steer: a step of half a goblin and the remesh of what it changed, on two threads, milliseconds of the wall clock. */
void bench_steer(void);

#endif
