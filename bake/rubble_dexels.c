#include "rubble_dexels.h"

#include <string.h>

scree_result dexels_create(const scree_allocator* allocator, const double origin[2], double size, const uint32_t count[2],
                           dexels* out) {
  *out = (dexels){.allocator = *allocator,
                  .origin = {origin[0], origin[1]},
                  .size = size,
                  .count = {count[0], count[1]},
                  .pool_capacity = 4 * count[0] * count[1]};
  const size_t columns = (size_t)count[0] * count[1];
  out->first = scree_rt_allocate(allocator, columns, sizeof *out->first);
  out->pool = scree_rt_allocate(allocator, out->pool_capacity, sizeof *out->pool);
  if (out->first == NULL || out->pool == NULL) {
    dexels_free(out);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  for (size_t i = 0; i < columns; ++i) out->first[i] = DEXEL_END;
  return SCREE_OK;
}

void dexels_free(dexels* d) {
  scree_rt_release(&d->allocator, d->first, (size_t)d->count[0] * d->count[1], sizeof *d->first);
  scree_rt_release(&d->allocator, d->pool, d->pool_capacity, sizeof *d->pool);
  memset(d, 0, sizeof *d);
}

scree_result dexels_copy(const dexels* from, dexels* out) {
  const size_t columns = (size_t)from->count[0] * from->count[1];
  *out = *from;
  out->pool_capacity = from->pool_count > 0 ? from->pool_count : 1;
  out->first = scree_rt_allocate(&from->allocator, columns, sizeof *out->first);
  out->pool = scree_rt_allocate(&from->allocator, out->pool_capacity, sizeof *out->pool);
  if (out->first == NULL || out->pool == NULL) {
    dexels_free(out);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  memcpy(out->first, from->first, columns * sizeof *out->first);
  memcpy(out->pool, from->pool, from->pool_count * sizeof *out->pool);
  return SCREE_OK;
}

bool dexels_hold(const dexels* d, const int32_t column[2], double height) {
  if (column[0] < 0 || column[1] < 0 || column[0] >= (int32_t)d->count[0] || column[1] >= (int32_t)d->count[1]) return false;
  uint32_t n = d->first[(uint32_t)column[0] + d->count[0] * (uint32_t)column[1]];
  while (n != DEXEL_END && d->pool[n].high <= height) n = d->pool[n].next;
  return n != DEXEL_END && d->pool[n].low < height;
}

static bool grow(dexels* d) {
  if (d->pool_capacity > UINT32_MAX / 4) return false;
  const uint32_t capacity = 2 * d->pool_capacity;
  dexel* pool = scree_rt_allocate(&d->allocator, capacity, sizeof *pool);
  if (pool == NULL) return false;
  memcpy(pool, d->pool, d->pool_count * sizeof *pool);
  scree_rt_release(&d->allocator, d->pool, d->pool_capacity, sizeof *pool);
  d->pool = pool;
  d->pool_capacity = capacity;
  return true;
}

bool dexels_add(dexels* d, uint32_t column, double low, double high) {
  if (d->pool_count == d->pool_capacity && !grow(d)) return false;
  uint32_t* link = &d->first[column];
  while (*link != DEXEL_END && d->pool[*link].high < low) link = &d->pool[*link].next;
  uint32_t after = *link;
  uint32_t own = DEXEL_END; /* what it swallows is used anew */
  for (; after != DEXEL_END && d->pool[after].low <= high; after = d->pool[after].next) {
    if (d->pool[after].low < low) low = d->pool[after].low;
    if (d->pool[after].high > high) high = d->pool[after].high;
    own = after;
  }
  if (own == DEXEL_END) own = d->pool_count++;
  d->pool[own] = (dexel){low, high, after, 0};
  *link = own;
  return true;
}
