/* Hulls of a field's assets, as the geometry wants them. */
#include "field_tables.h"
#include "pack_internal.h"

static void split_points(const void* xyz, bool narrow, uint32_t count, float* x, float* y, float* z) {
#ifdef SCREE_WIDE_KERNELS
  if (__builtin_cpu_supports("avx2")) {
    scree_rt_field_split_points_avx2(xyz, narrow, count, x, y, z);
    return;
  }
#endif
  const int8_t* bytes = xyz;
  const int16_t* words = xyz;
  float* const to[3] = {x, y, z};
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t a = 0; a < 3; ++a) to[a][i] = narrow ? bytes[3 * i + a] : words[3 * i + a];
}

uint32_t scree_rt_field_hull(const scree_field* field, uint32_t asset, float* x, float* y, float* z) {
  const scree_pack* pack = field->pack;
  if (pack != NULL) { /* used in place; scree_field_create has looked at every hull, but a mapped file may have changed since */
    const pack_asset* record = &pack->assets[asset];
    const bool narrow = pack->narrow_hulls;
    const uint32_t first = record->first_hull, points = record->hull_count;
    if (points > FIELD_MAX_HULL || first > pack->hull_count || points > pack->hull_count - first) return 0;
    split_points(pack->hulls + (narrow ? 3 : 3 * sizeof(int16_t)) * (size_t)first, narrow, points, x, y, z);
    return points;
  }
  if (field->hull_first == NULL) return 0;
  uint32_t count = field->hull_first[asset + 1] - field->hull_first[asset];
  if (count > FIELD_MAX_HULL) count = FIELD_MAX_HULL;
  split_points(field->hulls + (size_t)3 * field->hull_first[asset], false, count, x, y, z);
  return count;
}
