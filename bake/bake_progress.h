/* How far a bake is, told to its caller by any of its workers, and whether it is to stop. */
#ifndef SCREE_BAKE_PROGRESS_H
#define SCREE_BAKE_PROGRESS_H

#include <stdatomic.h>
#include <stdbool.h>

typedef bool bake_listener(void* user, const char* stage, double done);

typedef struct bake_progress {
  bake_listener* listener; /* NULL is allowed; false = stop */
  void* user;
  double told;           /* the most that was said; guarded by `telling` */
  atomic_flag telling;   /* set while a worker is inside `listener` */
  atomic_bool stopped;   /* something failed, or the caller has had enough */
  atomic_bool cancelled; /* the caller has had enough */
} bake_progress;

void bake_progress_begin(bake_progress* progress, bake_listener* listener, void* user);

/* done: 0..1 of everything; what is not more than was said is not said. Workers who find another one inside go on. Returns whether
 * to go on. */
bool bake_progress_tell(bake_progress* progress, const char* stage, double done);

#endif
