/* See stream_ranges.h. */
#include "stream_ranges.h"

#define RANGES_FREE 0x80000000u
#define NONE UINT32_MAX

/* Large arrays are handed out eight places at a time, which keeps the tables small. */
static uint32_t unit_of(uint32_t capacity) {
  return capacity >= 65536 ? 8 : 1;
}

size_t scree_rt_ranges_words(uint32_t capacity) {
  return (size_t)3 * (capacity / unit_of(capacity));
}

static uint32_t highest_bit(uint32_t value) {
  return 31 - (uint32_t)__builtin_clz(value);
}

/* The bin of ranges of this length: four a power of two. */
static uint32_t bin_of(uint32_t length) {
  if (length < 4) return length;
  uint32_t high = highest_bit(length);
  return 4 * (high - 1) + (length >> (high - 2) & 3);
}

static void link_range(stream_ranges* r, uint32_t at, uint32_t length) {
  uint32_t bin = bin_of(length);
  r->sizes[at] = r->sizes[at + length - 1] = length | RANGES_FREE;
  r->before[at] = NONE;
  r->after[at] = r->bins[bin];
  if (r->bins[bin] != NONE) r->before[r->bins[bin]] = at;
  r->bins[bin] = at;
  r->filled[bin / 64] |= UINT64_C(1) << bin % 64;
}

static void unlink_range(stream_ranges* r, uint32_t at) {
  uint32_t bin = bin_of(r->sizes[at] & ~RANGES_FREE);
  if (r->before[at] != NONE)
    r->after[r->before[at]] = r->after[at];
  else
    r->bins[bin] = r->after[at];
  if (r->after[at] != NONE) r->before[r->after[at]] = r->before[at];
  if (r->bins[bin] == NONE) r->filled[bin / 64] &= ~(UINT64_C(1) << bin % 64);
}

void scree_rt_ranges_init(stream_ranges* r, uint32_t capacity, uint32_t* words) {
  r->unit = unit_of(capacity);
  r->units = capacity / r->unit;
  r->free_units = r->units;
  r->filled[0] = r->filled[1] = 0;
  r->sizes = words;
  r->before = words + r->units;
  r->after = words + (size_t)2 * r->units;
  for (uint32_t i = 0; i < RANGES_BINS; ++i) r->bins[i] = NONE;
  if (r->units > 0) link_range(r, 0, r->units);
}

/* The first bin from `bin` on that is not empty. */
static uint32_t filled_bin(const stream_ranges* r, uint32_t bin) {
  for (uint32_t word = bin / 64; word < 2; ++word) {
    uint64_t bits = r->filled[word];
    if (word == bin / 64) bits &= UINT64_MAX << bin % 64;
    if (bits != 0) return word * 64 + (uint32_t)__builtin_ctzll(bits);
  }
  return NONE;
}

/* A free range of at least `length` units: the last that came into its own bin, if that fits, or one of the next bin that has any,
 * where nothing is shorter. If there is none its own is looked through, so that a range that fits is always found. */
static uint32_t find_range(const stream_ranges* r, uint32_t length) {
  uint32_t bin = bin_of(length);
  if (r->bins[bin] != NONE && (r->sizes[r->bins[bin]] & ~RANGES_FREE) >= length) return r->bins[bin];
  if (bin + 1 < RANGES_BINS) {
    uint32_t larger = filled_bin(r, bin + 1);
    if (larger != NONE) return r->bins[larger];
  }
  for (uint32_t at = r->bins[bin]; at != NONE; at = r->after[at])
    if ((r->sizes[at] & ~RANGES_FREE) >= length) return at;
  return NONE;
}

bool scree_rt_ranges_take(stream_ranges* r, uint32_t count, uint32_t* first) {
  uint32_t length = count / r->unit + (count % r->unit != 0);
  if (length == 0 || length > r->free_units) return false;
  uint32_t at = find_range(r, length);
  if (at == NONE) return false;
  uint32_t found = r->sizes[at] & ~RANGES_FREE;
  unlink_range(r, at);
  if (found > length) link_range(r, at + length, found - length);
  r->sizes[at] = r->sizes[at + length - 1] = length;
  r->free_units -= length;
  *first = at * r->unit;
  return true;
}

void scree_rt_ranges_trim(stream_ranges* r, uint32_t first, uint32_t count, uint32_t kept) {
  uint32_t at = first / r->unit, length = count / r->unit + (count % r->unit != 0), left = kept / r->unit + (kept % r->unit != 0);
  if (left >= length) return;
  r->sizes[at] = r->sizes[at + left - 1] = left;
  scree_rt_ranges_give(r, (at + left) * r->unit, (length - left) * r->unit);
}

void scree_rt_ranges_give(stream_ranges* r, uint32_t first, uint32_t count) {
  uint32_t at = first / r->unit, length = count / r->unit + (count % r->unit != 0);
  r->free_units += length;
  if (at + length < r->units && (r->sizes[at + length] & RANGES_FREE) != 0) {
    uint32_t next = r->sizes[at + length] & ~RANGES_FREE;
    unlink_range(r, at + length);
    length += next;
  }
  if (at > 0 && (r->sizes[at - 1] & RANGES_FREE) != 0) {
    uint32_t last = r->sizes[at - 1] & ~RANGES_FREE;
    unlink_range(r, at - last);
    at -= last;
    length += last;
  }
  link_range(r, at, length);
}
