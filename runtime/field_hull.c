/* Hulls of a field's assets, as the geometry wants them. */
#include "field_tables.h"

static void split_points(const int16_t* xyz, uint32_t count, float* x, float* y, float* z) {
#ifdef SCREE_WIDE_KERNELS
  if (__builtin_cpu_supports("avx2")) {
    scree_rt_field_split_points_avx2(xyz, count, x, y, z);
    return;
  }
#endif
  for (uint32_t i = 0; i < count; ++i) {
    x[i] = xyz[3 * i];
    y[i] = xyz[3 * i + 1];
    z[i] = xyz[3 * i + 2];
  }
}

uint32_t scree_rt_field_hull(const scree_field* field, uint32_t asset, float* x, float* y, float* z) {
  uint32_t count = 0;
  if (field->pack != NULL) {
    int16_t copy[FIELD_MAX_HULL][3];
    /* Cannot fail: scree_field_create has looked at every hull. */
    if (scree_pack_get_hull(field->pack, asset, copy[0], FIELD_MAX_HULL, &count) != SCREE_OK) return 0;
    split_points(copy[0], count, x, y, z);
  } else if (field->hull_first != NULL) {
    count = field->hull_first[asset + 1] - field->hull_first[asset];
    if (count > FIELD_MAX_HULL) count = FIELD_MAX_HULL;
    split_points(field->hulls + (size_t)3 * field->hull_first[asset], count, x, y, z);
  }
  return count;
}
