/* Filling zones: darts, then a search for gaps. A square that one disc covers is done, any other is tried with a dart and cut into
 * four, down to single places; so the search ends with no place left. */
#include "scatter_tiles.h"

#include <stdbool.h>
#include <string.h>

#include "lattice.h"

enum {
  T = SCATTER_SIDE,
  R = SCATTER_RADIUS,
  C = SCATTER_CORNER,
  MOST_PLACED = 320, /* the points of a tile's zones, with those parts of them that lie beyond the tile: 4 * 14 + 4 * 20 + 146 */
  MOST_IN_ZONE = SCATTER_MOST_POINTS,
  SPARE_DARTS = 8 /* thrown for each disc's worth of area */
};

typedef struct zone_points {
  uint32_t count;
  int32_t x[MOST_IN_ZONE], z[MOST_IN_ZONE];
} zone_points;

/* A zone being filled: low <= x, z < high, for the inside of a tile without its corners. */
typedef struct zone_fill {
  int32_t low[2], high[2];
  bool inside;
  uint64_t random;
  uint32_t first, count; /* points from `first` on are its own */
  int32_t x[MOST_PLACED], z[MOST_PLACED];
} zone_fill;

static uint32_t random_below(zone_fill* zone, uint32_t end) {
  zone->random += UINT64_C(0x9e3779b97f4a7c15);
  return (uint32_t)((hash_mix(zone->random) >> 32) * end >> 32);
}

/* 0: a corner's part along an axis, on either side; 1: what lies between. */
static int part_of(int32_t at) {
  return at >= C && at < T - C;
}

static bool is_in_zone(const zone_fill* zone, int32_t x, int32_t z) {
  if (x < zone->low[0] || x >= zone->high[0] || z < zone->low[1] || z >= zone->high[1]) return false;
  return !zone->inside || part_of(x) || part_of(z);
}

/* Whether a square has no place in the zone. */
static bool is_outside(const zone_fill* zone, int32_t x, int32_t z, int32_t size) {
  const int32_t x1 = x + size - 1, z1 = z + size - 1;
  if (x1 < zone->low[0] || x >= zone->high[0] || z1 < zone->low[1] || z >= zone->high[1]) return true;
  return zone->inside && (x1 < C || x >= T - C) && (z1 < C || z >= T - C);
}

static bool is_free(const zone_fill* zone, int32_t x, int32_t z) {
  for (uint32_t i = 0; i < zone->count; ++i) {
    const int32_t dx = zone->x[i] - x, dz = zone->z[i] - z;
    if (dx * dx + dz * dz < R * R) return false;
  }
  return true;
}

static void add(zone_fill* zone, int32_t x, int32_t z) {
  if (zone->count == MOST_PLACED) return; /* cannot be */
  zone->x[zone->count] = x;
  zone->z[zone->count++] = z;
}

static void try_dart(zone_fill* zone, int32_t x, int32_t z) {
  if (is_in_zone(zone, x, z) && is_free(zone, x, z)) add(zone, x, z);
}

/* Whether one disc covers a square. */
static bool is_covered(const zone_fill* zone, int32_t x, int32_t z, int32_t size) {
  for (uint32_t i = 0; i < zone->count; ++i) {
    const int32_t x0 = x - zone->x[i], x1 = x0 + size - 1, z0 = z - zone->z[i], z1 = z0 + size - 1;
    const int32_t dx2 = x0 * x0 > x1 * x1 ? x0 * x0 : x1 * x1, dz2 = z0 * z0 > z1 * z1 ? z0 * z0 : z1 * z1;
    if (dx2 + dz2 < R * R) return true;
  }
  return false;
}

static void fill_gaps(zone_fill* zone, int32_t x, int32_t z, int32_t size) {
  if (is_outside(zone, x, z, size) || is_covered(zone, x, z, size)) return;
  const int32_t dart_x = x + (int32_t)random_below(zone, (uint32_t)size);
  const int32_t dart_z = z + (int32_t)random_below(zone, (uint32_t)size);
  try_dart(zone, dart_x, dart_z);
  if (size == 1) return;
  const int32_t half = size / 2;
  const uint32_t turn = random_below(zone, 4); /* so that no side comes first everywhere */
  for (uint32_t i = 0; i < 4; ++i) {
    const uint32_t part = i ^ turn;
    fill_gaps(zone, x + (part & 1 ? half : 0), z + (part & 2 ? half : 0), half);
  }
}

/* Fills a zone round which the points so far were placed; delivers its own. */
static void fill(zone_fill* zone, zone_points* out) {
  zone->first = zone->count;
  const uint32_t width = (uint32_t)(zone->high[0] - zone->low[0]), depth = (uint32_t)(zone->high[1] - zone->low[1]);
  const uint32_t darts = SPARE_DARTS * (width * depth / (R * R) + 1);
  for (uint32_t i = 0; i < darts; ++i) {
    const int32_t x = zone->low[0] + (int32_t)random_below(zone, width), z = zone->low[1] + (int32_t)random_below(zone, depth);
    try_dart(zone, x, z);
  }
  fill_gaps(zone, zone->low[0], zone->low[1], T);
  out->count = zone->count - zone->first;
  memcpy(out->x, zone->x + zone->first, out->count * sizeof *out->x);
  memcpy(out->z, zone->z + zone->first, out->count * sizeof *out->z);
}

static void begin(zone_fill* zone, uint64_t seed, uint32_t name) {
  memset(zone, 0, sizeof *zone);
  zone->random = hash_combine(seed ^ UINT64_C(0x8f1bbcdcbfa53e0b), name);
}

static void surround(zone_fill* zone, const zone_points* points, int32_t x, int32_t z) {
  for (uint32_t i = 0; i < points->count; ++i) add(zone, points->x[i] + x, points->z[i] + z);
}

static void keep_own(scatter_tile* tile, const zone_points* points, int32_t x, int32_t z) {
  for (uint32_t i = 0; i < points->count; ++i) {
    const int32_t px = points->x[i] + x, pz = points->z[i] + z;
    if (px < 0 || px >= T || pz < 0 || pz >= T || tile->count == SCATTER_MOST_POINTS) continue;
    tile->x[tile->count] = (uint16_t)px;
    tile->z[tile->count++] = (uint16_t)pz;
  }
}

/* All zones but the insides. */
typedef struct borders {
  zone_points corners[2];
  zone_points strips[2][4]; /* along x, along z; colour of the first corner + 2 * colour of the second */
} borders;

static void make_borders(uint64_t seed, borders* all) {
  zone_fill zone;
  for (uint32_t colour = 0; colour < 2; ++colour) {
    begin(&zone, seed, colour);
    zone.low[0] = zone.low[1] = -C;
    zone.high[0] = zone.high[1] = C;
    fill(&zone, &all->corners[colour]);
  }
  for (uint32_t axis = 0; axis < 2; ++axis)
    for (uint32_t pair = 0; pair < 4; ++pair) {
      begin(&zone, seed, 2 + 4 * axis + pair);
      surround(&zone, &all->corners[pair & 1], 0, 0);
      surround(&zone, &all->corners[pair >> 1], axis == 0 ? T : 0, axis == 0 ? 0 : T);
      zone.low[axis] = C;
      zone.high[axis] = T - C;
      zone.low[1 - axis] = -R / 2;
      zone.high[1 - axis] = R / 2;
      fill(&zone, &all->strips[axis][pair]);
    }
}

void scree_rt_scatter_make_tiles(uint64_t seed, scatter_tile tiles[SCATTER_TILES]) {
  borders all;
  make_borders(seed, &all);
  for (uint32_t code = 0; code < SCATTER_TILES; ++code) {
    /* What lies round the inside, and where. */
    const zone_points* round[8];
    int32_t at[8][2];
    for (uint32_t i = 0; i < 4; ++i) {
      round[i] = &all.corners[code >> i & 1];
      at[i][0] = i & 1 ? T : 0;
      at[i][1] = i & 2 ? T : 0;
      /* Strips: along x at z = 0 and z = T, then along z at x = 0 and x = T. */
      const uint32_t far = i & 1, along_z = i >> 1;
      const uint32_t first = along_z ? far : 2 * far, second = along_z ? far + 2 : 2 * far + 1;
      round[4 + i] = &all.strips[along_z][(code >> first & 1) | (code >> second & 1) << 1];
      at[4 + i][0] = along_z && far ? T : 0;
      at[4 + i][1] = !along_z && far ? T : 0;
    }
    zone_fill zone;
    zone_points inside;
    begin(&zone, seed, 10 + code);
    for (uint32_t i = 0; i < 8; ++i) surround(&zone, round[i], at[i][0], at[i][1]);
    zone.inside = true;
    zone.low[0] = zone.low[1] = R / 2;
    zone.high[0] = zone.high[1] = T - R / 2;
    fill(&zone, &inside);
    scatter_tile* tile = &tiles[code];
    memset(tile, 0, sizeof *tile);
    for (uint32_t i = 0; i < 8; ++i) keep_own(tile, round[i], at[i][0], at[i][1]);
    keep_own(tile, &inside, 0, 0);
  }
}
