/* Edits as bytes, docs/edits_format.md:
 *
 *   header 24 | layers, 64 each, by key | edits, 16 each, by (layer, cube z, y, x, local) | XXH3-64 of all that, 8 */
#include <string.h>

#include "allocator.h"
#include "edits_internal.h"
#include "field_tables.h"
#include "pack_format.h"
#include "scatter_internal.h"
#include "scene_internal.h"

enum { VERSION = 1, HEADER_SIZE = 24, LAYER_SIZE = 64, EDIT_SIZE = 16, DIGEST_SIZE = 8, MAX_LAYERS = 65536 };

static const uint8_t magic[8] = {0x89, 'S', 'E', 'D', '\r', '\n', 0x1a, '\n'};

/* What the ids of a layer mean: with any of this different, they name other rocks. */
typedef struct fingerprint {
  uint64_t pack_digest, seed;
  double cell_size, origin[3];
} fingerprint;

static fingerprint fingerprint_of(const scree_layer* layer) {
  const scree_field* field = layer->field;
  const scree_pack* pack = layer->scatter != NULL ? layer->scatter->pack : field->pack;
  const double* origin = layer->scatter != NULL ? layer->scatter->origin : field->origin;
  fingerprint f = {0, field->seed, field->cell_size, {0, 0, 0}};
  if (pack != NULL) {
    scree_pack_info info;
    scree_pack_get_info(pack, &info);
    f.pack_digest = info.digest;
  }
  for (int a = 0; a < 3; ++a) f.origin[a] = origin[a] + 0.0; /* so that -0 is 0 */
  return f;
}

static bool same(const fingerprint* a, const fingerprint* b) {
  return a->pack_digest == b->pack_digest && a->seed == b->seed && a->cell_size == b->cell_size && a->origin[0] == b->origin[0] &&
         a->origin[1] == b->origin[1] && a->origin[2] == b->origin[2];
}

/* --- numbers as bytes ------------------------------------------------------------------------------------------------------- */

static uint8_t* put(uint8_t* to, uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) *to++ = (uint8_t)(value >> (8 * i));
  return to;
}

static uint8_t* put_double(uint8_t* to, double value) {
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  return put(to, bits, 8);
}

static uint64_t get(const uint8_t* from, int bytes) {
  uint64_t value = 0;
  for (int i = 0; i < bytes; ++i) value |= (uint64_t)from[i] << (8 * i);
  return value;
}

static double get_double(const uint8_t* from) {
  const uint64_t bits = get(from, 8);
  double value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static int32_t get_int(const uint8_t* from) {
  const uint32_t bits = (uint32_t)get(from, 4);
  return bits <= INT32_MAX ? (int32_t)bits : (int32_t)(bits - 0x80000000u) + INT32_MIN;
}

/* --- saving ----------------------------------------------------------------------------------------------------------------- */

/* One past the last entry of the layer of entry `first`. */
static size_t layer_end(const scree_edits* edits, size_t first) {
  size_t end = first;
  while (end < edits->count && edits->entries[end].id.layer == edits->entries[first].id.layer) ++end;
  return end;
}

static uint8_t* put_layer(uint8_t* to, const scree_layer* layer, uint16_t key, size_t count) {
  const fingerprint f = fingerprint_of(layer);
  to = put(to, key, 2);
  to = put(to, 0, 6);
  to = put(to, count, 8);
  to = put(to, f.pack_digest, 8);
  to = put(to, f.seed, 8);
  to = put_double(to, f.cell_size);
  for (int a = 0; a < 3; ++a) to = put_double(to, f.origin[a]);
  return to;
}

static uint8_t* put_edit(uint8_t* to, const edits_entry* entry) {
  for (int a = 0; a < 3; ++a) to = put(to, (uint32_t)entry->id.cube[a], 4);
  to = put(to, entry->id.local, 2);
  to = put(to, (uint64_t)entry->edit, 1);
  return put(to, 0, 1);
}

scree_result scree_edits_save(const scree_edits* edits, const struct scree_scene* scene, uint8_t* bytes, size_t capacity,
                              size_t* size) {
  if (size != NULL) *size = 0;
  if (edits == NULL || scene == NULL || size == NULL || (bytes == NULL && capacity > 0)) return SCREE_ERROR_INVALID_ARGUMENT;
  uint32_t layers = 0;
  for (size_t first = 0; first < edits->count; first = layer_end(edits, first), ++layers)
    if (scree_scene_layer_of(scene, edits->entries[first].id.layer) == UINT32_MAX) return SCREE_ERROR_INVALID_ARGUMENT;
  *size = HEADER_SIZE + layers * (size_t)LAYER_SIZE + edits->count * EDIT_SIZE + DIGEST_SIZE;
  if (capacity < *size) return SCREE_ERROR_CAPACITY;

  uint8_t* to = bytes;
  memcpy(to, magic, sizeof magic);
  to = put(to + sizeof magic, VERSION, 4);
  to = put(to, layers, 4);
  to = put(to, edits->count, 8);
  for (size_t first = 0; first < edits->count;) {
    const uint16_t key = edits->entries[first].id.layer;
    const size_t end = layer_end(edits, first);
    to = put_layer(to, scree_rt_scene_layer(scene, scree_scene_layer_of(scene, key)), key, end - first);
    first = end;
  }
  for (size_t i = 0; i < edits->count; ++i) to = put_edit(to, &edits->entries[i]);
  put(to, scree_rt_pack_bytes_digest(bytes, (size_t)(to - bytes)), DIGEST_SIZE);
  return SCREE_OK;
}

/* --- loading ---------------------------------------------------------------------------------------------------------------- */

typedef struct delta {
  const uint8_t *layers, *edits;
  size_t layer_count, edit_count;
} delta;

typedef struct delta_layer {
  uint16_t key;
  size_t count;
  fingerprint print;
} delta_layer;

static delta_layer read_layer(const delta* d, size_t index) {
  const uint8_t* from = d->layers + index * LAYER_SIZE;
  delta_layer layer = {.key = (uint16_t)get(from, 2), .count = (size_t)get(from + 8, 8)};
  layer.print = (fingerprint){get(from + 16, 8), get(from + 24, 8), get_double(from + 32), {0, 0, 0}};
  for (int a = 0; a < 3; ++a) layer.print.origin[a] = get_double(from + 40 + 8 * a);
  return layer;
}

static edits_entry read_edit(const delta* d, size_t index, uint16_t key) {
  const uint8_t* from = d->edits + index * EDIT_SIZE;
  return (edits_entry){{{get_int(from), get_int(from + 4), get_int(from + 8)}, (uint16_t)get(from + 12, 2), key},
                       (scree_edit)from[14]};
}

/* Sizes and the digest; after that no read can pass the end. */
static scree_result open_delta(const uint8_t* bytes, size_t size, delta* d) {
  if (memcmp(bytes, magic, size < sizeof magic ? size : sizeof magic) != 0) return SCREE_ERROR_NOT_A_PACK;
  if (size < HEADER_SIZE) return SCREE_ERROR_TRUNCATED;
  if (get(bytes + 8, 4) != VERSION) return SCREE_ERROR_VERSION;
  const uint64_t layers = get(bytes + 12, 4), edits = get(bytes + 16, 8);
  if (layers > MAX_LAYERS || edits > UINT64_MAX / 2 / EDIT_SIZE) return SCREE_ERROR_CORRUPT;
  const uint64_t needed = HEADER_SIZE + layers * LAYER_SIZE + edits * EDIT_SIZE + DIGEST_SIZE;
  if (size < needed) return SCREE_ERROR_TRUNCATED;
  if (size > needed) return SCREE_ERROR_CORRUPT;
  if (get(bytes + size - DIGEST_SIZE, DIGEST_SIZE) != scree_rt_pack_bytes_digest(bytes, size - DIGEST_SIZE))
    return SCREE_ERROR_DIGEST;
  const uint8_t* first = bytes + HEADER_SIZE;
  *d = (delta){first, first + layers * LAYER_SIZE, (size_t)layers, (size_t)edits};
  return SCREE_OK;
}

/* Order, padding and ranges of all that is in it. */
static bool is_sound(const delta* d) {
  size_t at = 0;
  for (size_t l = 0; l < d->layer_count; ++l) {
    const delta_layer layer = read_layer(d, l);
    if (l > 0 && layer.key <= read_layer(d, l - 1).key) return false;
    if (get(d->layers + l * LAYER_SIZE + 2, 6) != 0) return false;
    if (layer.count == 0 || layer.count > d->edit_count - at) return false;
    for (size_t i = 0; i < layer.count; ++i, ++at) {
      const edits_entry entry = read_edit(d, at, layer.key);
      if (entry.edit != SCREE_EDIT_REMOVE && entry.edit != SCREE_EDIT_HIDE) return false;
      if (d->edits[at * EDIT_SIZE + 15] != 0) return false;
      if (i > 0) {
        const edits_entry before = read_edit(d, at - 1, layer.key);
        if (scree_rt_edits_compare(&before.id, &entry.id) >= 0) return false;
      }
    }
  }
  return at == d->edit_count;
}

static bool has_rock(const scree_layer* layer, const scree_id* id) {
  const scree_field* field = layer->field;
  for (int a = 0; a < 3; ++a)
    if (id->cube[a] == INT32_MAX) return false; /* the corner behind it has no number */
  int64_t steps[2];
  if (layer->scatter != NULL) return scree_rt_scatter_steps(layer->scatter, id->cube[0], id->cube[2], id->local, steps);
  const uint32_t code = cube_code(field->seed, id->cube[0], id->cube[1], id->cube[2]);
  return scree_rt_field_slot(field, code, id->local) != UINT32_MAX;
}

/* Sorts the edits into the report; those that apply go to `out` if it is not NULL. */
static scree_edits_report judge(const delta* d, const scree_scene* scene, edits_entry* out) {
  scree_edits_report report = {0, 0, 0, 0};
  size_t at = 0;
  for (size_t l = 0; l < d->layer_count; ++l) {
    const delta_layer layer = read_layer(d, l);
    const size_t end = at + layer.count;
    const uint32_t index = scree_scene_layer_of(scene, layer.key);
    if (index == UINT32_MAX) {
      report.unknown_layer += layer.count;
      at = end;
      continue;
    }
    const scree_layer* own = scree_rt_scene_layer(scene, index);
    const fingerprint now = fingerprint_of(own);
    if (!same(&now, &layer.print)) {
      report.stale += layer.count;
      at = end;
      continue;
    }
    for (; at < end; ++at) {
      const edits_entry entry = read_edit(d, at, layer.key);
      if (!has_rock(own, &entry.id)) {
        ++report.unknown_rock;
      } else {
        if (out != NULL) *out++ = entry;
        ++report.applied;
      }
    }
  }
  return report;
}

scree_result scree_edits_load(scree_edits* edits, const struct scree_scene* scene, const uint8_t* bytes, size_t size,
                              scree_edits_report* report) {
  if (report != NULL) *report = (scree_edits_report){0, 0, 0, 0};
  if (edits == NULL || scene == NULL || (bytes == NULL && size > 0)) return SCREE_ERROR_INVALID_ARGUMENT;
  delta d;
  scree_result result = size == 0 ? SCREE_ERROR_TRUNCATED : open_delta(bytes, size, &d);
  if (result != SCREE_OK) return result;
  if (!is_sound(&d)) return SCREE_ERROR_CORRUPT;

  const scree_edits_report found = judge(&d, scene, NULL);
  const size_t applied = (size_t)found.applied;
  if (applied > 0) {
    edits_entry* entries = scree_rt_allocate(&edits->allocator, applied, sizeof *entries);
    if (entries == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
    judge(&d, scene, entries);
    const bool merged = scree_rt_edits_merge(edits, entries, applied);
    scree_rt_release(&edits->allocator, entries, applied, sizeof *entries);
    if (!merged) return SCREE_ERROR_OUT_OF_MEMORY;
  }
  if (report != NULL) *report = found;
  return SCREE_OK;
}
