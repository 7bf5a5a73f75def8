#include "digest_queries.h"

#include <stdlib.h>
#include <string.h>

#include "random_support.h"

static uint64_t digest_bytes(uint64_t digest, const void* bytes, size_t size) {
  for (size_t at = 0; at < size; at += sizeof(uint32_t)) {
    uint32_t word;
    memcpy(&word, (const char*)bytes + at, sizeof word);
    digest = hash_combine(digest, word);
  }
  return digest;
}

static uint64_t digest_query(uint64_t digest, const scree_query_desc* desc) {
  uint64_t count = 0;
  if (scree_query_count(desc, &count) != SCREE_OK) return 0;
  scree_instance* instances = malloc((size_t)(count + 1) * sizeof *instances);
  scree_id* ids = malloc((size_t)(count + 1) * sizeof *ids);
  digest = hash_combine(digest, count);
  if (instances == NULL || ids == NULL || scree_query_fill(desc, instances, ids, count, &count) != SCREE_OK) {
    digest = 0;
  } else {
    digest = digest_bytes(digest, instances, (size_t)count * sizeof *instances);
    digest = digest_bytes(digest, ids, (size_t)count * sizeof *ids);
    for (uint64_t i = 0; i < count; ++i) digest = hash_combine(digest, scree_world_hash(desc->field, &ids[i]));
  }
  free(instances);
  free(ids);
  return digest;
}

uint64_t digest_queries(void) {
  static random_support shapes;
  random_stream r = {2009};
  uint64_t digest = 1;
  for (uint32_t round = 0; round < 12 && digest != 0; ++round) {
    synthetic_source source = synthetic_create(3 + round % 6, 1, 1 + round % 3, random_bits(&r));
    scree_field_desc field_desc = {.seed = random_bits(&r), .cell_size = 0.75, .origin = {3, -4, 5}};
    random_tree(&shapes, &r, 1 + random_below(&r, RANDOM_MAX_LEAVES), 12);
    scree_field* field = NULL;
    scree_support* support = NULL;
    if (scree_rt_field_create_from_source(&field_desc, &source.source, NULL, &field) != SCREE_OK ||
        scree_support_create(&shapes.desc, NULL, &support, NULL) != SCREE_OK)
      digest = 0;
    for (uint32_t kind = 0; kind < 4 && digest != 0; ++kind) {
      scree_query_desc desc = {.field = field, .support = support, .origin = {7.25, 0, -1e5}, .flags = kind & 1};
      if (kind & 2) {
        desc.threshold = (float)random_in(&r, 0.1, 0.9);
        for (int a = 0; a < 3; ++a) {
          desc.min[a] = random_in(&r, -8, 0);
          desc.max[a] = random_in(&r, 0, 8);
        }
      }
      digest = digest_query(digest, &desc);
    }
    scree_field_destroy(field);
    scree_support_destroy(support);
    synthetic_destroy(&source);
  }
  return digest;
}
