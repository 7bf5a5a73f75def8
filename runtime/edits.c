/* Edits as a sorted array: some thousand at most in a saved game, read a million times as often as changed. */
#include <string.h>

#include "allocator.h"
#include "edits_internal.h"

static int compare_int(int64_t a, int64_t b) {
  return (a > b) - (a < b);
}

int scree_rt_edits_compare(const scree_id* a, const scree_id* b) {
  if (a->layer != b->layer) return compare_int(a->layer, b->layer);
  for (int axis = 2; axis >= 0; --axis)
    if (a->cube[axis] != b->cube[axis]) return compare_int(a->cube[axis], b->cube[axis]);
  return compare_int(a->local, b->local);
}

/* The first entry from `first` on that is not before the id. */
static size_t lower_bound(const scree_edits* edits, size_t first, const scree_id* id) {
  size_t end = edits->count;
  while (first < end) {
    size_t middle = first + (end - first) / 2;
    if (scree_rt_edits_compare(&edits->entries[middle].id, id) < 0) {
      first = middle + 1;
    } else {
      end = middle;
    }
  }
  return first;
}

static bool is_at(const scree_edits* edits, size_t at, const scree_id* id) {
  return at < edits->count && scree_rt_edits_compare(&edits->entries[at].id, id) == 0;
}

scree_result scree_edits_create(const scree_allocator* given, scree_edits** out) {
  if (out == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  scree_allocator allocator = scree_rt_allocator_or_default(given);
  *out = scree_rt_allocate_zeroed(&allocator, 1, sizeof **out);
  if (*out == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  (*out)->allocator = allocator;
  return SCREE_OK;
}

void scree_edits_destroy(scree_edits* edits) {
  if (edits == NULL) return;
  scree_allocator allocator = edits->allocator;
  scree_rt_release(&allocator, edits->entries, edits->capacity, sizeof *edits->entries);
  scree_rt_release(&allocator, edits, 1, sizeof *edits);
}

scree_result scree_edits_set(scree_edits* edits, const scree_id* id, scree_edit edit) {
  if (edits == NULL || id == NULL || (uint32_t)edit > SCREE_EDIT_HIDE) return SCREE_ERROR_INVALID_ARGUMENT;
  const size_t at = lower_bound(edits, 0, id);
  const bool known = is_at(edits, at, id);
  if (edit == SCREE_EDIT_NONE) {
    if (!known) return SCREE_OK;
    memmove(edits->entries + at, edits->entries + at + 1, (edits->count - at - 1) * sizeof *edits->entries);
    --edits->count;
  } else if (known) {
    if (edits->entries[at].edit == edit) return SCREE_OK;
    edits->entries[at].edit = edit;
  } else {
    if (edits->count == edits->capacity) {
      const size_t capacity = edits->capacity < 32 ? 64 : edits->capacity + edits->capacity / 2;
      edits_entry* entries = scree_rt_allocate(&edits->allocator, capacity, sizeof *entries);
      if (entries == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
      if (edits->count > 0) memcpy(entries, edits->entries, edits->count * sizeof *entries);
      scree_rt_release(&edits->allocator, edits->entries, edits->capacity, sizeof *entries);
      edits->entries = entries;
      edits->capacity = capacity;
    }
    memmove(edits->entries + at + 1, edits->entries + at, (edits->count - at) * sizeof *edits->entries);
    edits->entries[at] = (edits_entry){*id, edit};
    ++edits->count;
  }
  ++edits->revision;
  return SCREE_OK;
}

scree_edit scree_edits_get(const scree_edits* edits, const scree_id* id) {
  if (edits == NULL || id == NULL || edits->count == 0) return SCREE_EDIT_NONE;
  const size_t at = lower_bound(edits, 0, id);
  return is_at(edits, at, id) ? edits->entries[at].edit : SCREE_EDIT_NONE;
}

void scree_edits_clear(scree_edits* edits) {
  if (edits == NULL || edits->count == 0) return;
  edits->count = 0;
  ++edits->revision;
}

uint64_t scree_edits_count(const scree_edits* edits) {
  return edits == NULL ? 0 : edits->count;
}

uint64_t scree_edits_revision(const scree_edits* edits) {
  return edits == NULL ? 0 : edits->revision;
}

uint64_t scree_edits_list(const scree_edits* edits, uint64_t first, scree_id* ids, scree_edit* edits_out, uint64_t capacity) {
  if (edits == NULL || first >= edits->count) return 0;
  const uint64_t rest = edits->count - first, written = rest < capacity ? rest : capacity;
  for (uint64_t i = 0; i < written; ++i) {
    if (ids != NULL) ids[i] = edits->entries[first + i].id;
    if (edits_out != NULL) edits_out[i] = edits->entries[first + i].edit;
  }
  return written;
}

const edits_entry* scree_rt_edits_next(const scree_edits* edits, uint16_t layer, const int32_t low[3], const int32_t high[3],
                                       size_t* next) {
  if (edits == NULL || edits->count == 0) return NULL;
  for (int axis = 0; axis < 3; ++axis)
    if (low[axis] >= high[axis]) return NULL;
  /* Where the entry at *next is outside, `from` is the first id of the box that can follow it. */
  scree_id from = {{low[0], low[1], low[2]}, 0, layer};
  size_t at = *next;
  if (at == 0) at = lower_bound(edits, 0, &from);
  while (at < edits->count) {
    const edits_entry* entry = &edits->entries[at];
    const int32_t* cube = entry->id.cube;
    if (entry->id.layer != layer || cube[2] >= high[2]) break;
    if (cube[1] >= low[1] && cube[1] < high[1] && cube[0] >= low[0] && cube[0] < high[0]) {
      *next = at + 1;
      return entry;
    }
    /* The box goes on in this row, in a later row of this layer of cubes, or in the next layer of cubes. */
    from.cube[2] = cube[2];
    if (cube[1] < low[1]) {
      from.cube[1] = low[1];
    } else if (cube[1] < high[1] && cube[0] < low[0]) {
      from.cube[1] = cube[1];
    } else if (cube[1] < high[1] - 1) {
      from.cube[1] = cube[1] + 1;
    } else {
      from.cube[1] = low[1];
      if (cube[2] == high[2] - 1) break;
      from.cube[2] = cube[2] + 1;
    }
    at = lower_bound(edits, at + 1, &from);
  }
  *next = edits->count;
  return NULL;
}

bool scree_rt_edits_any(const scree_edits* edits, uint16_t layer, const int32_t low[3], const int32_t high[3]) {
  size_t next = 0;
  return scree_rt_edits_next(edits, layer, low, high, &next) != NULL;
}

bool scree_rt_edits_merge(scree_edits* edits, const edits_entry* entries, size_t count) {
  if (count == 0) return true;
  const size_t capacity = edits->count + count;
  edits_entry* merged = capacity >= count ? scree_rt_allocate(&edits->allocator, capacity, sizeof *merged) : NULL;
  if (merged == NULL) return false;
  size_t a = 0, b = 0, out = 0;
  bool changed = false;
  while (a < edits->count || b < count) {
    int order = a == edits->count ? 1 : b == count ? -1 : scree_rt_edits_compare(&edits->entries[a].id, &entries[b].id);
    if (order < 0) {
      merged[out++] = edits->entries[a++];
      continue;
    }
    changed = changed || order > 0 || edits->entries[a].edit != entries[b].edit;
    merged[out++] = entries[b++];
    if (order == 0) ++a;
  }
  scree_rt_release(&edits->allocator, edits->entries, edits->capacity, sizeof *edits->entries);
  edits->entries = merged;
  edits->count = out;
  edits->capacity = capacity;
  edits->revision += changed;
  return true;
}
