#include "support_share.h"

#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

support_key scree_rt_support_key(const scree_shape* s) {
  uint64_t words[8] = {s->kind};
  XXH128_hash_t first, second = {0, 0};
  if (s->kind == SCREE_SHAPE_HEIGHTFIELD) {
    first = XXH3_128bits(s->heightfield.heights, sizeof(float) * s->heightfield.width * s->heightfield.depth);
    words[1] = s->heightfield.width;
    words[2] = s->heightfield.depth;
    memcpy(&words[3], &s->heightfield.spacing, sizeof s->heightfield.spacing);
  } else {
    first = XXH3_128bits(s->mesh.positions, sizeof(float) * 3 * s->mesh.vertex_count);
    second = XXH3_128bits(s->mesh.indices, sizeof(uint32_t) * 3 * s->mesh.triangle_count);
    words[1] = (uint64_t)s->mesh.vertex_count << 32 | s->mesh.triangle_count;
    words[2] = s->mesh.resolution > 0 ? s->mesh.resolution : 128;
  }
  words[4] = first.low64;
  words[5] = first.high64;
  words[6] = second.low64;
  words[7] = second.high64;
  XXH128_hash_t all = XXH3_128bits(words, sizeof words);
  return (support_key){all.low64, all.high64};
}
