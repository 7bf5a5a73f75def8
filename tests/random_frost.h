/* Random rules and states of freeze and thaw, for tests of what holds for all. */
#ifndef RANDOM_FROST_H
#define RANDOM_FROST_H

#include "frost_internal.h"

/* Rules that lead to falls within some hundred paths on a few dozen shards, and all kinds of resistance. */
void random_frost_rules(random_stream* stream, scree_frost_rules* out);

/* States for so many shards: mostly solid, in some rounds with core, in some with air. */
void random_frost_states(random_stream* stream, uint32_t count, uint8_t* out);

/* Ends the test on failure. */
scree_frost* must_freeze(const scree_shards* shards, const scree_frost_rules* rules, const uint8_t* states, uint64_t random_seed);

#endif
