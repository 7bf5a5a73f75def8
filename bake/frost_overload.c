/* The rule of stability, laid on a simulation. */
#include "frost_internal.h"

static uint32_t weigh(const scree_frost* f) {
  if (!(f->rules.strength > 0)) return 0;
  const frost_stability_state state = {.states = f->states,
                                       .rests = f->rests,
                                       .lives = f->lives,
                                       .gravity = {f->tables.gravity[0], f->tables.gravity[1], f->tables.gravity[2]},
                                       .density = f->rules.density,
                                       .strength = f->rules.strength,
                                       .compression = f->rules.compression};
  return frost_stability_weigh(f->stability, &state);
}

/* One round is enough: what breaks off has nothing that is supported, so that it falls, not what it hung on. The loop is there
 * because that is how the promise is made. */
uint32_t frost_stability_break(scree_frost* f) {
  uint32_t total = 0;
  for (uint32_t groups; (groups = weigh(f)) > 0; total += groups) {
    const uint32_t* links;
    const uint32_t count = frost_stability_cuts(f->stability, &links);
    for (uint32_t i = 0; i < count; ++i) {
      if (!(f->lives[links[i]] > 0)) continue; /* it went with what fell before */
      frost_break_link(f, links[i]);
      ++f->stats.overloaded;
    }
  }
  return total;
}

uint32_t scree_frost_check_stability(const scree_frost* frost) {
  return weigh(frost);
}
