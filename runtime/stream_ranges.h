/* Ranges of an array: which places of the stream's array of instances are in use. Two-level segregated fit (Masmano, Ripoll,
 * Crespo, Real 2004) over numbers instead of memory: taking and giving back cost the same whatever has gone before, and neighbours
 * that are free are one. */
#ifndef SCREE_STREAM_RANGES_H
#define SCREE_STREAM_RANGES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { RANGES_BINS = 128 };

typedef struct stream_ranges {
  uint32_t unit;       /* places are handed out in multiples of this */
  uint32_t units;      /* of the whole array */
  uint32_t free_units; /* that are not in use */
  uint64_t filled[2];  /* bit b: bin b is not empty */
  uint32_t bins[RANGES_BINS];
  uint32_t* sizes;          /* at the first and the last unit of a range: its length, with RANGES_FREE where it is free */
  uint32_t *before, *after; /* of a free range, at its first unit: neighbours in its bin */
} stream_ranges;

/* Numbers that the tables need for an array of `capacity` places. */
size_t scree_rt_ranges_words(uint32_t capacity);

/* All places are free. words: scree_rt_ranges_words(capacity) of them. */
void scree_rt_ranges_init(stream_ranges* ranges, uint32_t capacity, uint32_t* words);

/* Takes `count` > 0 places in a row; false when there are none. */
bool scree_rt_ranges_take(stream_ranges* ranges, uint32_t count, uint32_t* first);
void scree_rt_ranges_give(stream_ranges* ranges, uint32_t first, uint32_t count);
/* Gives back all but the first `kept` > 0 places of a range. */
void scree_rt_ranges_trim(stream_ranges* ranges, uint32_t first, uint32_t count, uint32_t kept);

#endif
