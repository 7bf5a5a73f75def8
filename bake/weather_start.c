#include "weather_start.h"

#include <math.h>
#include <string.h>

#include "faults.h"
#include "lattice.h"
#include "support_program.h"
#include "support_text.h"
#include "weather_noise.h"
#include "weather_rules.h"

static scree_result invalid(scree_error* error, const char* text) {
  scree_rt_text_clear(error);
  scree_rt_text_add(error, text);
  return SCREE_ERROR_INVALID_ARGUMENT;
}

static bool whole_grid(const scree_weather_start* s) {
  bool zero = true;
  for (int a = 0; a < 3; ++a) zero = zero && s->box_min[a] == 0 && s->box_max[a] == 0;
  return zero;
}

static scree_result check_box(const scree_weather_start* s, scree_error* error) {
  static const char* const names[3] = {"box_max[0]", "box_max[1]", "box_max[2]"};
  if (whole_grid(s)) return SCREE_OK;
  for (int a = 0; a < 3; ++a)
    if (s->box_max[a] > s->size[a] || s->box_min[a] >= s->box_max[a])
      return fault_value(error, names[a], s->box_max[a], "more than box_min, at most the size");
  return SCREE_OK;
}

scree_result weather_check_start(const scree_weather_start* s, scree_error* error) {
  static const char* const sizes[3] = {"size[0]", "size[1]", "size[2]"};
  for (int a = 0; a < 3; ++a)
    if (s->size[a] < 1 || s->size[a] > 4096) return fault_value(error, sizes[a], s->size[a], "1 to 4096 voxels");
  switch (s->kind) {
    case SCREE_START_BOX: return check_box(s, error);
    case SCREE_START_JOINT_MAP:
      if (s->map == NULL) return invalid(error, "map: missing");
      if (s->map_width < 1 || s->map_width > 65536) return fault_value(error, "map_width", s->map_width, "1 to 65536");
      if (s->map_depth < 1 || s->map_depth > 65536) return fault_value(error, "map_depth", s->map_depth, "1 to 65536");
      return SCREE_OK;
    case SCREE_START_SUPPORT:
      if (s->support == NULL) return invalid(error, "support: missing");
      if (!(s->voxel > 0) || !(s->voxel <= 1e6)) return fault_value(error, "voxel", s->voxel, "more than 0, up to 1e6 metres");
      for (int a = 0; a < 3; ++a)
        if (!within(s->origin[a], -1e12, 1e12)) return fault_value(error, "origin", s->origin[a], "-1e12 to 1e12 metres");
      return SCREE_OK;
    case SCREE_START_JOINTS: {
      const scree_result result = check_box(s, error);
      if (result != SCREE_OK) return result;
      if (!within(s->joint_spacing, 4, 1e6)) return fault_value(error, "joint_spacing", s->joint_spacing, "4 to 1e6 voxels");
      if (!within(s->joint_gap, 0, 0.5)) return fault_value(error, "joint_gap", s->joint_gap, "0 to 0.5");
      if (!within(s->joint_warp, 0, 1)) return fault_value(error, "joint_warp", s->joint_warp, "0 to 1");
      if (!within(s->joint_missing, 0, 1)) return fault_value(error, "joint_missing", s->joint_missing, "0 to 1");
      if (!within(s->joint_low, 0, 1)) return fault_value(error, "joint_low", s->joint_low, "0 to 1");
      return SCREE_OK;
    }
  }
  return fault_value(error, "kind", s->kind, "no such start shape");
}

/* --- columns: boxes, joint maps and joints ----------------------------------------------------------------------------------- */

/* A block of jointed rock: the cell of the jittered grid that it grew from. */
typedef struct joint {
  double nearest, second; /* squared distances, spacings */
  int32_t block[2];
} joint;

static joint find_joint(uint64_t key, double x, double z) {
  joint found = {1e30, 1e30, {0, 0}};
  const int32_t cx = (int32_t)floor(x), cz = (int32_t)floor(z);
  for (int32_t dz = -2; dz <= 2; ++dz)
    for (int32_t dx = -2; dx <= 2; ++dx) {
      const uint64_t hash = hash_corner(key, cx + dx, 0, cz + dz);
      const double px = cx + dx + (double)(hash >> 32) * 0x1p-32 - x, pz = cz + dz + (double)(hash & 0xffffffff) * 0x1p-32 - z;
      const double d = px * px + pz * pz;
      if (d < found.nearest) {
        found.second = found.nearest;
        found.nearest = d;
        found.block[0] = cx + dx;
        found.block[1] = cz + dz;
      } else if (d < found.second)
        found.second = d;
    }
  return found;
}

/* Voxels of the column above box_min that are rock, of `height`. */
static uint32_t joint_height(const scree_weather_start* s, uint32_t x, uint32_t z, const float warp[2], uint32_t height) {
  const uint64_t key = hash_combine(s->seed, 3);
  const double px = ((double)x + 0.5) / s->joint_spacing + warp[0] * s->joint_warp;
  const double pz = ((double)z + 0.5) / s->joint_spacing + warp[1] * s->joint_warp;
  const joint j = find_joint(key, px, pz);
  if (sqrt(j.second) - sqrt(j.nearest) < s->joint_gap) return 0;
  const uint64_t hash = hash_corner(hash_combine(key, 1), j.block[0], 0, j.block[1]);
  if ((double)(hash >> 32) * 0x1p-32 < s->joint_missing) return 0;
  const double share = s->joint_low + (1 - s->joint_low) * ((double)(hash & 0xffffffff) * 0x1p-32);
  return (uint32_t)(share * height + 0.5);
}

static void column_heights(const scree_weather* w, const scree_weather_start* s, uint32_t z, uint32_t* low, uint32_t high[4096]) {
  const uint32_t nx = w->size[0], ny = w->size[1];
  *low = 0;
  if (s->kind == SCREE_START_JOINT_MAP) {
    const uint64_t row = ((uint64_t)z * 2 + 1) * s->map_depth / ((uint64_t)w->size[2] * 2);
    for (uint32_t x = 0; x < nx; ++x) {
      const uint64_t column = ((uint64_t)x * 2 + 1) * s->map_width / ((uint64_t)nx * 2);
      high[x] = (s->map[row * s->map_width + column] * ny * 2 + 255) / 510;
    }
    return;
  }
  const bool all = whole_grid(s);
  const uint32_t x0 = all ? 0 : s->box_min[0], x1 = all ? nx : s->box_max[0];
  const uint32_t y0 = all ? 0 : s->box_min[1], y1 = all ? ny : s->box_max[1];
  const uint32_t z0 = all ? 0 : s->box_min[2], z1 = all ? w->size[2] : s->box_max[2];
  *low = y0;
  for (uint32_t x = 0; x < nx; ++x) high[x] = x >= x0 && x < x1 && z >= z0 && z < z1 ? y1 : 0;
  if (s->kind != SCREE_START_JOINTS) return;
  const double frequency = 1 / s->joint_spacing;
  const weather_noise along_x = {hash_combine(s->seed, 4), frequency, frequency};
  const weather_noise along_z = {hash_combine(s->seed, 5), frequency, frequency};
  for (uint32_t x = 0; x < nx; ++x) {
    if (high[x] == 0) continue;
    float warp[2];
    weather_noise_row(&along_x, NULL, x, 0, z, 1, &warp[0]);
    weather_noise_row(&along_z, NULL, x, 0, z, 1, &warp[1]);
    high[x] = y0 + joint_height(s, x, z, warp, y1 - y0);
  }
}

static void fill_columns(const scree_weather* w, const scree_weather_start* s, uint32_t z) {
  uint32_t high[4096], low;
  column_heights(w, s, z, &low, high);
  for (uint32_t y = low; y < w->size[1]; ++y) {
    uint64_t* row = w->rock + weather_row(w, (int32_t)y, (int32_t)z);
    for (uint32_t x = 0; x < w->size[0]; ++x) row[x / 64] |= (uint64_t)(y < high[x]) << (x % 64);
  }
}

/* --- supports ---------------------------------------------------------------------------------------------------------------- */

static void fill_support(const scree_weather* w, const scree_weather_start* s, uint32_t z) {
  float px[64], py[64], pz[64], distance[64];
  for (int i = 0; i < 64; ++i) pz[i] = (float)(s->origin[2] + ((double)z + 0.5) * s->voxel - s->support->origin[2]);
  for (uint32_t y = 0; y < w->size[1]; ++y) {
    for (int i = 0; i < 64; ++i) py[i] = (float)(s->origin[1] + ((double)y + 0.5) * s->voxel - s->support->origin[1]);
    uint64_t* row = w->rock + weather_row(w, (int32_t)y, (int32_t)z);
    for (uint32_t x = 0; x < w->size[0]; x += 64) {
      const uint32_t count = w->size[0] - x < 64 ? w->size[0] - x : 64;
      for (uint32_t i = 0; i < count; ++i)
        px[i] = (float)(s->origin[0] + ((double)(x + i) + 0.5) * s->voxel - s->support->origin[0]);
      scree_support_distance(s->support, px, py, pz, distance, count);
      for (uint32_t i = 0; i < count; ++i) row[x / 64] |= (uint64_t)(distance[i] <= 0) << i;
    }
  }
}

typedef struct fill_job {
  const scree_weather* w;
  const scree_weather_start* start;
} fill_job;

static void fill_plane(void* context, uint32_t z, uint32_t worker) {
  (void)worker;
  const fill_job* job = context;
  if (job->start->kind == SCREE_START_SUPPORT)
    fill_support(job->w, job->start, z);
  else
    fill_columns(job->w, job->start, z);
}

void weather_fill_start(const scree_weather* w, const scree_weather_start* start) {
  fill_job job = {w, start};
  weather_parallel(w, w->size[2], fill_plane, &job);
}
