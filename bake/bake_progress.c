#include "bake_progress.h"

#include <stddef.h>

void bake_progress_begin(bake_progress* progress, bake_listener* listener, void* user) {
  progress->listener = listener;
  progress->user = user;
  progress->told = 0;
  atomic_flag_clear(&progress->telling);
  atomic_init(&progress->stopped, false);
  atomic_init(&progress->cancelled, false);
}

bool bake_progress_tell(bake_progress* progress, const char* stage, double done) {
  if (atomic_load_explicit(&progress->stopped, memory_order_relaxed)) return false;
  if (progress->listener == NULL || atomic_flag_test_and_set(&progress->telling)) return true;
  bool go_on = !atomic_load(&progress->cancelled); /* by who was inside just now */
  if (go_on && done > progress->told) {
    progress->told = done < 1 ? done : 1;
    go_on = progress->listener(progress->user, stage, progress->told);
  }
  if (!go_on) {
    atomic_store(&progress->cancelled, true);
    atomic_store(&progress->stopped, true);
  }
  atomic_flag_clear(&progress->telling);
  return go_on;
}
